//! Paths and named places on a map.

use planning::grid::Grid;
use plotters::{
    coord::{Shift, types::RangedCoordf64},
    prelude::*,
    style::{
        RGBColor,
        text_anchor::{HPos, Pos, VPos},
    },
};

use super::{X_AXIS, Y_AXIS, pens};
use crate::{
    plot::{Drawn, INK, text_style},
    reproduce::figure::{Line, Mark},
    site::SiteFrame,
};

const WALL: RGBColor = RGBColor(104, 110, 118);

/// Draws walls, then paths, then marks.
pub(super) fn paths<B>(
    area: &DrawingArea<B, Shift>,
    scale: u32,
    (grid, frame): (&Grid, SiteFrame),
    lines: &[Line],
    marks: &[Mark],
) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let axes =
        Axes { origin: frame.origin.into(), flipped: frame.y_up.then(|| f64::from(grid.height()) - 1.0) };
    // Cells are as wide as 1, their middles at whole numbers.
    let (right, low) = ((f64::from(grid.width()) - 0.5).max(0.5), (f64::from(grid.height()) - 0.5).max(0.5));
    let ((left, low), (right, high)) = (axes.at((-0.5, low)), axes.at((right, -0.5)));
    let mut chart = ChartBuilder::on(area)
        .x_label_area_size(X_AXIS * scale)
        .y_label_area_size(Y_AXIS * scale)
        .build_cartesian_2d(left..right, low..high)?;
    let pane = chart.plotting_area();
    for Block { x, y, width, height } in blocks(grid) {
        let (left, top) = (f64::from(x) - 0.5, f64::from(y) - 0.5);
        let corners = [(left, top), (left + f64::from(width), top + f64::from(height))];
        pane.draw(&Rectangle::new(corners.map(|corner| axes.at(corner)), WALL.filled()))?;
    }
    for (line, pen) in lines.iter().zip(pens(lines.iter().map(|line| line.label.as_str()))) {
        pen.stroke(pane, scale, line.points.iter().map(|&point| axes.at(point)).collect())?;
    }
    for mark in marks {
        let has_neighbour = marks.iter().any(|other| is_close_right(mark.at, other.at, grid));
        let to_the_left = has_neighbour || mark.at.0 > 0.85 * f64::from(grid.width());
        draw_mark(pane, scale, &mark.label, axes.at(mark.at), to_the_left)?;
    }
    let whole = |value: &f64| value.round().to_string();
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(INK.stroke_width(scale))
        .label_style(text_style(13, scale))
        .axis_desc_style(text_style(15, scale))
        .x_desc("x (cells)")
        .y_desc("y (cells)")
        .x_labels(12)
        .y_labels(12)
        .x_label_formatter(&whole)
        .y_label_formatter(&whole)
        .draw()?;
    Ok(())
}

/// How the axes count.
#[derive(Clone, Copy)]
struct Axes {
    origin: f64,
    /// The last row, where y grows upwards.
    flipped: Option<f64>,
}

impl Axes {
    fn at(self, (x, y): (f64, f64)) -> (f64, f64) {
        (x + self.origin, self.flipped.map_or(y, |last| last - y) + self.origin)
    }
}

/// Whether `other` is where the label of a mark would stand.
fn is_close_right((x, y): (f64, f64), other: (f64, f64), grid: &Grid) -> bool {
    let side = f64::from(grid.width().max(grid.height()));
    let (right, down) = ((other.0 - x) / side, (other.1 - y) / side);
    right > 0.0 && right < 0.04 && down.abs() < 0.015
}

type Pane<B> = DrawingArea<B, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// A dot with its name beside it, on that side where there is room.
fn draw_mark<B>(pane: &Pane<B>, scale: u32, label: &str, at: (f64, f64), to_the_left: bool) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let pixels = |length: i32| length * scale as i32;
    let dot = EmptyElement::at(at)
        + Circle::new((0, 0), pixels(5), INK.filled())
        + Circle::new((0, 0), pixels(3), WHITE.filled());
    pane.draw(&dot)?;
    let (side, anchor) = if to_the_left { (-1, HPos::Right) } else { (1, HPos::Left) };
    let style = text_style(13, scale).pos(Pos::new(anchor, VPos::Center));
    let (text_width, text_height) = pane.estimate_text_size(label, &style)?;
    let (near, far) = (pixels(7), pixels(11) + text_width as i32);
    let half = text_height as i32 / 2 + pixels(1);
    let behind = Rectangle::new([(side * near, -half), (side * far, half)], WHITE.mix(0.75).filled());
    let name = Text::new(label.to_owned(), (side * pixels(9), pixels(1)), style);
    pane.draw(&(EmptyElement::at(at) + behind + name))?;
    Ok(())
}

/// Blocked cells that form a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Block {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

/// The blocked cells as few rectangles: runs in a row, together with the same runs in the rows below.
fn blocks(grid: &Grid) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut growing: Vec<usize> = Vec::new();
    for y in 0..grid.height() {
        let mut of_row = Vec::new();
        for (x, width) in runs(grid, y) {
            let above = growing
                .iter()
                .copied()
                .find(|&index| blocks.get(index).is_some_and(|block| (block.x, block.width) == (x, width)));
            match above.and_then(|index| Some((index, blocks.get_mut(index)?))) {
                Some((index, block)) => {
                    block.height += 1;
                    of_row.push(index);
                }
                None => {
                    of_row.push(blocks.len());
                    blocks.push(Block { x, y, width, height: 1 });
                }
            }
        }
        growing = of_row;
    }
    blocks
}

/// The first column and the width of each run of blocked cells in a row.
fn runs(grid: &Grid, y: u32) -> Vec<(u32, u32)> {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for x in (0..grid.width()).filter(|&x| !grid.is_free((x as i32, y as i32).into())) {
        match runs.last_mut() {
            Some((start, width)) if *start + *width == x => *width += 1,
            _ => runs.push((x, 1)),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn blocks_cover_every_blocked_cell_once_and_no_free_one(
            width in 1u32..9, height in 1u32..9, bits in any::<u64>(),
        ) {
            let mut grid = Grid::blocked(width, height).unwrap();
            for index in 0..grid.len() {
                grid.set(grid.cell(index), bits >> index & 1 == 0);
            }
            let mut covered = vec![0; grid.len()];
            for Block { x, y, width, height } in blocks(&grid) {
                for (x, y) in (x..x + width).flat_map(|x| (y..y + height).map(move |y| (x, y))) {
                    covered[grid.index((x as i32, y as i32).into()).unwrap()] += 1;
                }
            }
            for (index, times) in covered.into_iter().enumerate() {
                prop_assert_eq!(times, i32::from(!grid.is_free(grid.cell(index))));
            }
        }
    }

    #[test]
    fn a_wall_is_one_block() {
        let mut grid = Grid::blocked(500, 500).unwrap();
        assert_eq!(blocks(&grid).len(), 1);
        for y in 0..500 {
            grid.set((250, y).into(), true);
        }
        assert_eq!(blocks(&grid).len(), 2);
    }
}
