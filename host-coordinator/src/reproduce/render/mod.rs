//! Figures as PNG and SVG files: the layout, the legend and the pens; `chart` draws curves and bars,
//! `map` paths on maps.

mod chart;
mod map;

use plotters::{
    coord::{CoordTranslate, Shift},
    element::DashedPathElement,
    prelude::*,
    style::{
        RGBColor,
        text_anchor::{HPos, Pos, VPos},
    },
};

use super::figure::{Content, Figure};
use crate::plot::{self, COLOURS, Drawn, INK, Picture, PlotError, text_style};

/// The longer side of what the axes enclose, in pixels.
const PANE: f64 = 840.0;
/// No side of it is shorter, however narrow a map is.
const LEAST_PANE: f64 = 160.0;
/// What coordinate systems without a map enclose.
const CHART: (u32, u32) = (840, 480);
/// Around everything, and the axes' numbers and names.
const MARGIN: u32 = 14;
const X_AXIS: u32 = 52;
const Y_AXIS: u32 = 76;
const TITLE: u32 = 36;
/// A row of the legend, and the line in front of its text.
const LEGEND_ROW: u32 = 26;
const SAMPLE: u32 = 30;
/// A letter of the legend at its widest, to know in advance how many rows there are.
const LETTER: u32 = 9;

/// A PNG file.
///
/// # Errors
/// [`PlotError`]; it is not to be expected.
pub fn png(figure: &Figure) -> Result<Vec<u8>, PlotError> {
    plot::png(figure)
}

/// An SVG file.
///
/// # Errors
/// [`PlotError`]; it is not to be expected.
pub fn svg(figure: &Figure) -> Result<String, PlotError> {
    plot::svg(figure)
}

impl Picture for Figure {
    fn size(&self) -> (u32, u32) {
        let (width, height) = pane(&self.content);
        let legend = LEGEND_ROW * rows(&self.content).len() as u32;
        (width + Y_AXIS + 2 * MARGIN, height + X_AXIS + TITLE + legend + 2 * MARGIN)
    }

    fn draw<B>(&self, area: &DrawingArea<B, Shift>, scale: u32) -> Drawn
    where
        B: DrawingBackend,
        B::ErrorType: 'static,
    {
        let margin = MARGIN * scale;
        let area = area.margin(margin, margin, margin, margin);
        let (title, area) = area.split_vertically(TITLE * scale);
        let bold = text_style(19, scale).pos(Pos::new(HPos::Left, VPos::Top));
        title.draw(&Text::new(self.title.clone(), ((Y_AXIS * scale) as i32, 0), bold))?;
        let rows = rows(&self.content);
        let (legend, area) = area.split_vertically(LEGEND_ROW * scale * rows.len() as u32);
        draw_legend(&legend, scale, &rows)?;
        match &self.content {
            Content::Curves { x, y, lines } => chart::curves(&area, scale, (x, y), lines),
            Content::Bars { groups, y, series } => chart::bars(&area, scale, groups, y, series),
            Content::Map { grid, frame, lines, marks } => {
                map::paths(&area, scale, (grid, *frame), lines, marks)
            }
        }
    }
}

/// The width and height of what the axes enclose.
fn pane(content: &Content) -> (u32, u32) {
    let Content::Map { grid, .. } = content else { return CHART };
    let (width, height) = (f64::from(grid.width().max(1)), f64::from(grid.height().max(1)));
    let zoom = PANE / width.max(height);
    let side = |cells: f64| (cells * zoom).round().max(LEAST_PANE) as u32;
    (side(width), side(height))
}

/// The labels of a figure, each once, in order.
fn labels(content: &Content) -> Vec<&str> {
    match content {
        Content::Curves { lines, .. } | Content::Map { lines, .. } => {
            once(&lines.iter().map(|line| line.label.as_str()).collect::<Vec<_>>())
        }
        Content::Bars { series, .. } => {
            once(&series.iter().map(|series| series.label.as_str()).collect::<Vec<_>>())
        }
    }
}

/// The first of each of equal labels.
fn once<'a>(all: &[&'a str]) -> Vec<&'a str> {
    let mut labels: Vec<&str> = Vec::new();
    for label in all {
        if !labels.contains(label) {
            labels.push(label);
        }
    }
    labels
}

/// The legend's rows: the number of each entry's colour, and its label.
fn rows(content: &Content) -> Vec<Vec<(usize, &str)>> {
    let room = pane(content).0;
    let mut rows: Vec<Vec<(usize, &str)>> = Vec::new();
    let mut used = u32::MAX;
    for (number, label) in labels(content).into_iter().enumerate() {
        let width = entry_width(label);
        if used.saturating_add(width) > room {
            rows.push(Vec::new());
            used = 0;
        }
        used += width;
        if let Some(row) = rows.last_mut() {
            row.push((number, label));
        }
    }
    rows
}

fn entry_width(label: &str) -> u32 {
    SAMPLE + 24 + LETTER * label.chars().count() as u32
}

/// The style of the lines with the label of this number, of so many labels.
#[derive(Clone, Copy)]
struct Pen {
    colour: RGBColor,
    width: u32,
    dashed: bool,
}

impl Pen {
    fn stroke<B, C>(self, area: &DrawingArea<B, C>, scale: u32, points: Vec<C::From>) -> Drawn
    where
        B: DrawingBackend,
        B::ErrorType: 'static,
        C: CoordTranslate,
        C::From: Clone,
    {
        let style = self.colour.stroke_width(self.width * scale);
        if self.dashed {
            area.draw(&DashedPathElement::new(points, 9 * scale, 5 * scale, style))?;
        } else {
            area.draw(&PathElement::new(points, style))?;
        }
        Ok(())
    }
}

/// The pen of each line, all labels known.
fn pens<'a>(content_labels: impl IntoIterator<Item = &'a str>) -> Vec<Pen> {
    let of_lines: Vec<&str> = content_labels.into_iter().collect();
    let once = once(&of_lines);
    let number = |label: &&str| once.iter().position(|known| known == label).unwrap_or_default();
    of_lines.iter().map(|label| pen(number(label), once.len())).collect()
}

fn pen(number: usize, labels: usize) -> Pen {
    let colour = COLOURS.get(number % COLOURS.len()).copied().unwrap_or(INK);
    let width = if labels <= 3 { 2 + 2 * (labels - 1).saturating_sub(number) as u32 } else { 2 };
    Pen { colour, width: width.max(2), dashed: number >= COLOURS.len() }
}

fn draw_legend<B>(area: &DrawingArea<B, Shift>, scale: u32, rows: &[Vec<(usize, &str)>]) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let count = rows.iter().map(Vec::len).sum();
    for (row, entries) in (0u32..).zip(rows) {
        let mut x = Y_AXIS;
        for &(number, label) in entries {
            let pen = pen(number, count);
            let y = ((row * LEGEND_ROW + 10) * scale) as i32;
            let ends = vec![((x * scale) as i32, y), (((x + SAMPLE) * scale) as i32, y)];
            pen.stroke(area, scale, ends)?;
            let style = text_style(14, scale).pos(Pos::new(HPos::Left, VPos::Center));
            area.draw(&Text::new(label.to_owned(), (((x + SAMPLE + 8) * scale) as i32, y), style))?;
            x += entry_width(label);
        }
    }
    Ok(())
}
