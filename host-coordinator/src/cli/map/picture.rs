//! Draws a map: subareas in colours, doors, piles, places and lanes.

use std::{error::Error, fs, io::BufWriter, path::Path};

use planning::{floor_plan::Layout, grid::Cell, rooms::Rooms};

use super::rooms::Pile;

type Colour = [u8; 3];

const WALL: Colour = [38, 40, 46];
const DOOR: Colour = [214, 40, 40];
const PILE: Colour = [20, 110, 40];

/// A colour that differs from those of the numbers before and after: steps of the golden angle.
fn colour(number: u16) -> Colour {
    let hue = f64::from(number) * 137.508 % 360.0 / 60.0;
    let channel = |shift: f64| {
        let distance = ((hue + shift) % 6.0 - 3.0).abs() - 1.0;
        (150.0 + 95.0 * distance.clamp(0.0, 1.0)) as u8
    };
    [channel(0.0), channel(4.0), channel(2.0)]
}

/// Writes the picture of a map as PNG, each cell a square of as many pixels as make it about a
/// thousand wide.
pub fn write(file: &Path, layout: &Layout, rooms: &Rooms, piles: &[Pile]) -> Result<(), Box<dyn Error>> {
    let grid = &layout.grid;
    let (width, height) = (grid.width(), grid.height());
    let zoom = (1000 / width.max(height).max(1)).clamp(1, 12);
    let mut canvas = Canvas { width: width * zoom, height: height * zoom, pixels: Vec::new() };
    for y in 0..canvas.height {
        for x in 0..canvas.width {
            let cell = Cell { x: (x / zoom) as i32, y: (y / zoom) as i32 };
            canvas.pixels.extend(rooms.find_subarea(cell).map_or(WALL, |subarea| colour(subarea.0)));
        }
    }
    let radius = (zoom as i32 / 2).max(3);
    let middle = |cell: Cell| {
        let zoom = zoom as i32;
        (cell.x * zoom + zoom / 2, cell.y * zoom + zoom / 2)
    };
    for door in rooms.doors() {
        canvas.disc(middle(door.cell), radius, DOOR);
    }
    for pile in piles {
        canvas.disc(middle(pile.cell), radius + 2, [255, 255, 255]);
        canvas.disc(middle(pile.cell), radius + 1, PILE);
    }
    canvas.write(file)
}

struct Canvas {
    width: u32,
    height: u32,
    pixels: Vec<u8>,
}

impl Canvas {
    fn disc(&mut self, (x, y): (i32, i32), radius: i32, colour: Colour) {
        for (dx, dy) in (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy))) {
            let (Ok(x), Ok(y)) = (usize::try_from(x + dx), usize::try_from(y + dy)) else { continue };
            if dx * dx + dy * dy <= radius * radius && x < self.width as usize {
                let at = 3 * (y * self.width as usize + x);
                if let Some(pixel) = self.pixels.get_mut(at..at + 3) {
                    pixel.copy_from_slice(&colour);
                }
            }
        }
    }

    fn write(self, file: &Path) -> Result<(), Box<dyn Error>> {
        let created = fs::File::create(file).map_err(|error| {
            format!("{} cannot be written ({error}); name a place where you may write", file.display())
        })?;
        let mut encoder = png::Encoder::new(BufWriter::new(created), self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        Ok(encoder.write_header()?.write_image_data(&self.pixels)?)
    }
}
