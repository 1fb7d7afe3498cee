//! Draws a map: subareas in colours, doors and piles.

use std::{error::Error, fs, path::Path};

use host_coordinator::plot::{self, Drawn, Picture};
use planning::{
    grid::{Cell, Grid},
    rooms::Rooms,
};
use plotters::{coord::Shift, prelude::*, style::RGBColor};

use super::rooms::Pile;

const WALL: RGBColor = RGBColor(38, 40, 46);
const DOOR: RGBColor = RGBColor(214, 40, 40);
const PILE: RGBColor = RGBColor(20, 110, 40);

/// A colour that differs from those of the numbers before and after: steps of the golden angle.
fn colour(number: u16) -> RGBColor {
    let hue = f64::from(number) * 137.508 % 360.0 / 60.0;
    let channel = |shift: f64| {
        let distance = ((hue + shift) % 6.0 - 3.0).abs() - 1.0;
        (150.0 + 95.0 * distance.clamp(0.0, 1.0)) as u8
    };
    RGBColor(channel(0.0), channel(4.0), channel(2.0))
}

/// A map and what is to be seen on it.
pub struct MapPicture<'a> {
    pub grid: &'a Grid,
    pub rooms: &'a Rooms,
    pub piles: &'a [Pile],
}

impl MapPicture<'_> {
    /// Writes the picture, as PNG or SVG as the file's name ends.
    pub fn write(&self, file: &Path) -> Result<(), Box<dyn Error>> {
        let extension = file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let bytes = match extension.as_str() {
            "png" => plot::png(self)?,
            "svg" => plot::svg(self)?.into_bytes(),
            _ => {
                return Err(format!("{} is no picture: name a .png or an .svg file", file.display()).into());
            }
        };
        fs::write(file, bytes).map_err(|error| {
            format!("{} cannot be written ({error}); name a place where you may write", file.display()).into()
        })
    }

    /// The side of a cell in pixels, so that the picture is about a thousand wide.
    fn zoom(&self) -> u32 {
        (1000 / self.grid.width().max(self.grid.height()).max(1)).clamp(1, 12)
    }

    /// The columns of each run of cells in row `y` that are of one subarea, or of none, and their colour.
    fn runs(&self, y: i32) -> Vec<(i32, i32, RGBColor)> {
        let mut runs: Vec<(i32, i32, RGBColor)> = Vec::new();
        for x in 0..self.grid.width() as i32 {
            let colour = self.rooms.find_subarea(Cell { x, y }).map_or(WALL, |subarea| colour(subarea.0));
            match runs.last_mut() {
                Some((_, end, of)) if *of == colour => *end = x + 1,
                _ => runs.push((x, x + 1, colour)),
            }
        }
        runs
    }
}

impl Picture for MapPicture<'_> {
    fn size(&self) -> (u32, u32) {
        (self.grid.width() * self.zoom(), self.grid.height() * self.zoom())
    }

    fn draw<B>(&self, area: &DrawingArea<B, Shift>, scale: u32) -> Drawn
    where
        B: DrawingBackend,
        B::ErrorType: 'static,
    {
        let side = (self.zoom() * scale) as i32;
        for y in 0..self.grid.height() as i32 {
            for (start, end, colour) in self.runs(y) {
                let corners = [(start * side, y * side), (end * side, (y + 1) * side)];
                area.draw(&Rectangle::new(corners, colour.filled()))?;
            }
        }
        let middle = |cell: Cell| (cell.x * side + side / 2, cell.y * side + side / 2);
        let radius = (self.zoom() / 2).max(3);
        for door in self.rooms.doors() {
            area.draw(&Circle::new(middle(door.cell), radius * scale, DOOR.filled()))?;
        }
        for pile in self.piles {
            area.draw(&Circle::new(middle(pile.cell), (radius + 2) * scale, WHITE.filled()))?;
            area.draw(&Circle::new(middle(pile.cell), (radius + 1) * scale, PILE.filled()))?;
        }
        Ok(())
    }
}
