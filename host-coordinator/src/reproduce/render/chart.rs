//! Curves and bars in a coordinate system.

use plotters::{
    coord::{Shift, types::RangedCoordf64},
    prelude::*,
};

use super::{X_AXIS, Y_AXIS, pen, pens};
use crate::{
    plot::{Drawn, GRID, INK, text_style},
    reproduce::figure::{Line, Series},
};

/// Points are marked where a line has no more of them.
const MARKED_POINTS: usize = 30;
/// How much of a group of bars is bars.
const FILLED: f64 = 0.7;

type Axes = Cartesian2d<RangedCoordf64, RangedCoordf64>;

/// Lines through points.
pub(super) fn curves<B>(
    area: &DrawingArea<B, Shift>,
    scale: u32,
    (x, y): (&str, &str),
    lines: &[Line],
) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let points = || lines.iter().flat_map(|line| line.points.iter());
    let xs = range(points().map(|&(x, _)| x), 0.0);
    let ys = range(points().map(|&(_, y)| y), 0.06);
    let chart = axes(area, scale, (xs, ys), (x, y), |value| plain(*value))?;
    for (line, pen) in lines.iter().zip(pens(lines.iter().map(|line| line.label.as_str()))) {
        pen.stroke(chart.plotting_area(), scale, line.points.clone())?;
        if line.points.len() <= MARKED_POINTS {
            for &point in &line.points {
                let dot = Circle::new(point, (pen.width + 2) * scale, pen.colour.filled());
                chart.plotting_area().draw(&dot)?;
            }
        }
    }
    Ok(())
}

/// Bars side by side, in groups.
pub(super) fn bars<B>(
    area: &DrawingArea<B, Shift>,
    scale: u32,
    groups: &[String],
    y: &str,
    series: &[Series],
) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let values = || series.iter().flat_map(|series| series.values.iter().copied());
    let ys = 0.0..range(values().chain([0.0]), 0.08).end;
    let xs = -0.5..groups.len() as f64 - 0.5;
    let name = |x: &f64| {
        let group = (x - x.round()).abs() < 1e-6 && *x >= 0.0;
        groups.get(x.round().max(0.0) as usize).filter(|_| group).cloned().unwrap_or_default()
    };
    let chart = axes(area, scale, (xs, ys), ("", y), name)?;
    let (chart, width) = (chart.plotting_area(), FILLED / series.len().max(1) as f64);
    for (number, series) in series.iter().enumerate() {
        let pen = pen(number, usize::MAX);
        for (group, &value) in series.values.iter().enumerate() {
            let left = group as f64 - FILLED / 2.0 + number as f64 * width;
            let corners = [(left, value), (left + 0.94 * width, 0.0)];
            chart.draw(&Rectangle::new(corners, pen.colour.filled()))?;
            let above = (left + 0.47 * width, value);
            let style = text_style(12, scale).pos(centred_above());
            let gap = 4 * scale as i32;
            chart.draw(&(EmptyElement::at(above) + Text::new(plain(value), (0, -gap), style)))?;
        }
    }
    Ok(())
}

const fn centred_above() -> plotters::style::text_anchor::Pos {
    use plotters::style::text_anchor::{HPos, Pos, VPos};
    Pos { h_pos: HPos::Center, v_pos: VPos::Bottom }
}

/// Draws axes with names and a grid.
fn axes<'a, 'b, B>(
    area: &'b DrawingArea<B, Shift>,
    scale: u32,
    (xs, ys): (std::ops::Range<f64>, std::ops::Range<f64>),
    (x, y): (&str, &str),
    x_label: impl Fn(&f64) -> String,
) -> Result<ChartContext<'a, B, Axes>, Box<dyn std::error::Error>>
where
    B: DrawingBackend + 'a,
    B::ErrorType: 'static,
    'b: 'a,
{
    let mut chart = ChartBuilder::on(area)
        .x_label_area_size(X_AXIS * scale)
        .y_label_area_size(Y_AXIS * scale)
        .build_cartesian_2d(xs, ys)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(scale))
        .axis_style(INK.stroke_width(scale))
        .label_style(text_style(13, scale))
        .axis_desc_style(text_style(15, scale))
        .x_desc(x)
        .y_desc(y)
        .x_labels(14)
        .y_labels(8)
        .x_label_formatter(&x_label)
        .y_label_formatter(&|value| plain(*value))
        .draw()?;
    Ok(chart)
}

/// From the least to the largest of the finite `values`, widened by `room` of that at both ends.
fn range(values: impl Iterator<Item = f64> + Clone, room: f64) -> std::ops::Range<f64> {
    let finite = || values.clone().filter(|value| value.is_finite());
    let (Some(low), Some(high)) = (finite().reduce(f64::min), finite().reduce(f64::max)) else {
        return 0.0..1.0;
    };
    let room = room * (high - low);
    if high > low { low - room..high + room } else { low - 0.5..high + 0.5 }
}

/// A number with no more digits than it needs.
fn plain(value: f64) -> String {
    let decimals = if value.abs() >= 100.0 { 0 } else { 2 };
    let text = format!("{:.decimals$}", value + 0.0);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
