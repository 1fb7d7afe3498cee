//! Pictures as PNG and SVG, drawn once for both.
//!
//! A drawing is a function of an area and a scale: a PNG is drawn larger than it is and then averaged, so
//! that lines and letters are smooth; an SVG is smooth by itself. Lengths in a drawing are pixels
//! times the scale.

use std::error::Error;

use plotters::{
    coord::Shift,
    prelude::*,
    style::{FontStyle, RGBColor, register_font},
};

/// A PNG is drawn this much larger and then averaged.
const OVERSAMPLING: u32 = 2;
/// DejaVu Sans, cut down to Latin letters; its licence stands beside it. Not the system's: a bare
/// machine has none.
const FONT: &[u8] = include_bytes!("font/DejaVuSans-ASCII.ttf");
/// The name by which a drawing asks for its font; in an SVG the reader's own stands in.
pub const FONT_NAME: &str = "sans-serif";

/// Lines that help the eye.
pub const GRID: RGBColor = RGBColor(225, 225, 225);
/// Axes and letters.
pub const INK: RGBColor = RGBColor(60, 60, 60);
/// Of Okabe and Ito: told apart by colour-blind people too.
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(213, 94, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// What a drawing ends with.
pub type Drawn = Result<(), Box<dyn Error>>;

/// Something that can be drawn, as PNG and as SVG alike.
pub trait Picture {
    /// Its width and height in pixels.
    fn size(&self) -> (u32, u32);

    /// Draws it on an area of its size times `scale`, which is white.
    ///
    /// # Errors
    /// What the backend reports.
    fn draw<B>(&self, area: &DrawingArea<B, Shift>, scale: u32) -> Drawn
    where
        B: DrawingBackend,
        B::ErrorType: 'static;
}

/// A picture could not be made.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw the plot: {0}")]
pub struct PlotError(String);

/// The picture as a PNG file.
///
/// # Errors
/// [`PlotError`]; it is not to be expected.
pub fn png(picture: &impl Picture) -> Result<Vec<u8>, PlotError> {
    register()?;
    let size = picture.size();
    let large_size = (size.0 * OVERSAMPLING, size.1 * OVERSAMPLING);
    let mut large = vec![0; large_size.0 as usize * large_size.1 as usize * 3];
    {
        let area = BitMapBackend::with_buffer(&mut large, large_size).into_drawing_area();
        draw(picture, &area, OVERSAMPLING)?;
    }
    encode(&averaged(&large, size), size).map_err(|error| PlotError(error.to_string()))
}

/// The picture as an SVG file.
///
/// # Errors
/// [`PlotError`]; it is not to be expected.
pub fn svg(picture: &impl Picture) -> Result<String, PlotError> {
    register()?;
    let mut text = String::new();
    draw(picture, &SVGBackend::with_string(&mut text, picture.size()).into_drawing_area(), 1)?;
    Ok(text)
}

/// Letters of this many pixels.
#[must_use]
pub fn text_style(size: u32, scale: u32) -> TextStyle<'static> {
    (FONT_NAME, size * scale).into_font().color(&INK)
}

fn register() -> Result<(), PlotError> {
    register_font(FONT_NAME, FontStyle::Normal, FONT).map_err(|_| PlotError("font".into()))
}

fn draw<B>(picture: &impl Picture, area: &DrawingArea<B, Shift>, scale: u32) -> Result<(), PlotError>
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
    let drawn = || -> Drawn {
        area.fill(&WHITE)?;
        picture.draw(area, scale)?;
        Ok(area.present()?)
    };
    drawn().map_err(|error| PlotError(error.to_string()))
}

/// The mean of each square of [`OVERSAMPLING`] by [`OVERSAMPLING`] pixels.
fn averaged(large: &[u8], size: (u32, u32)) -> Vec<u8> {
    let (side, width) = (OVERSAMPLING as usize, size.0 as usize);
    let row_bytes = width * side * 3;
    let mut small = Vec::with_capacity(width * size.1 as usize * 3);
    for rows in large.chunks_exact(row_bytes * side) {
        for column in 0..width {
            for channel in 0..3 {
                let of_row = |row: &[u8]| -> u32 {
                    let pixels = row.iter().skip(column * side * 3 + channel).step_by(3).take(side);
                    pixels.map(|&value| u32::from(value)).sum()
                };
                let sum: u32 = rows.chunks_exact(row_bytes).map(of_row).sum();
                small.push(u8::try_from(sum / (OVERSAMPLING * OVERSAMPLING)).unwrap_or(u8::MAX));
            }
        }
    }
    small
}

fn encode(pixels: &[u8], (width, height): (u32, u32)) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(file)
}
