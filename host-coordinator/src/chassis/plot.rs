//! The commanded, ramped and measured speed of a recording as a PNG: a panel for each of forward,
//! left and turn.

use plotters::{
    coord::Shift,
    prelude::*,
    style::{FontStyle, RGBColor, register_font},
};
use protocol::Twist;

use super::recording::Speeds;

/// The picture's size in pixels.
pub const SIZE: (u32, u32) = (1_200, 1_080);
/// It is drawn this much larger and then averaged: smooth lines and letters.
const OVERSAMPLING: u32 = 2;
/// DejaVu Sans, cut down to Latin letters; its licence stands beside it. Not the system's: a bare
/// machine has none.
const FONT: &[u8] = include_bytes!("font/DejaVuSans-ASCII.ttf");
const FONT_NAME: &str = "sans-serif";

// Of Okabe and Ito: told apart by colour-blind people too.
const COMMANDED: RGBColor = RGBColor(0, 0, 0);
const RAMPED: RGBColor = RGBColor(230, 159, 0);
const MEASURED: RGBColor = RGBColor(0, 114, 178);
const GRID: RGBColor = RGBColor(225, 225, 225);
const INK: RGBColor = RGBColor(60, 60, 60);

/// The picture could not be made.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw the plot: {0}")]
pub struct PlotError(String);

struct Panel {
    label: &'static str,
    /// Of a resting robot's panel, so that noise does not fill it.
    least: f64,
    value: fn(&Twist) -> f64,
}

const PANELS: [Panel; 3] = [
    Panel { label: "vx, forward (m/s)", least: 0.1, value: |twist| twist.vx.get().into() },
    Panel { label: "vy, left (m/s)", least: 0.1, value: |twist| twist.vy.get().into() },
    Panel { label: "wz, counter-clockwise (rad/s)", least: 0.2, value: |twist| twist.wz.get().into() },
];

/// Draws the speeds; the answer is a PNG file of [`SIZE`].
///
/// # Errors
/// [`PlotError`]; it is not to be expected.
pub fn png(speeds: &Speeds, title: &str) -> Result<Vec<u8>, PlotError> {
    register_font(FONT_NAME, FontStyle::Normal, FONT).map_err(|_| PlotError("font".into()))?;
    let (width, height) = (SIZE.0 * OVERSAMPLING, SIZE.1 * OVERSAMPLING);
    let mut large = vec![0; width as usize * height as usize * 3];
    draw(&mut large, (width, height), speeds, title).map_err(|error| PlotError(error.to_string()))?;
    encode(&averaged(&large)).map_err(|error| PlotError(error.to_string()))
}

fn draw(
    buffer: &mut [u8],
    size: (u32, u32),
    speeds: &Speeds,
    title: &str,
) -> Result<(), Box<dyn std::error::Error>> {
    let scale = OVERSAMPLING;
    let root = BitMapBackend::with_buffer(buffer, size).into_drawing_area();
    root.fill(&WHITE)?;
    let root = root.margin(10 * scale, 10 * scale, 10 * scale, 20 * scale);
    let root = root.titled(title, (FONT_NAME, 20 * scale).into_font().color(&INK))?;
    for (panel, area) in PANELS.iter().zip(root.split_evenly((PANELS.len(), 1))) {
        draw_panel(&area, panel, speeds)?;
    }
    root.present()?;
    Ok(())
}

fn draw_panel(
    area: &DrawingArea<BitMapBackend<'_>, Shift>,
    panel: &Panel,
    speeds: &Speeds,
) -> Result<(), Box<dyn std::error::Error>> {
    let scale = OVERSAMPLING;
    let series = [
        ("commanded", &speeds.commanded, COMMANDED, 1),
        ("ramped", &speeds.ramped, RAMPED, 3),
        ("measured", &speeds.measured, MEASURED, 2),
    ];
    let samples = || series.iter().flat_map(|(_, samples, ..)| samples.iter());
    let end_s = samples().map(|sample| sample.at_s).fold(0.1, f64::max);
    let values = || samples().map(|sample| (panel.value)(&sample.twist));
    let (low, high) = (values().fold(-panel.least, f64::min), values().fold(panel.least, f64::max));
    let room = 0.08 * (high - low);

    let mut chart = ChartBuilder::on(area)
        .margin(6 * scale)
        .x_label_area_size(44 * scale)
        .y_label_area_size(72 * scale)
        .build_cartesian_2d(0.0..end_s, low - room..high + room)?;
    let text = |size: u32| (FONT_NAME, size * scale).into_font().color(&INK);
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(scale))
        .axis_style(INK.stroke_width(scale))
        .label_style(text(14))
        .axis_desc_style(text(15))
        .x_desc("time (s)")
        .y_desc(panel.label)
        .x_labels(12)
        .y_labels(7)
        .x_label_formatter(&|value| format!("{:.1}", unsigned_zero(*value)))
        .y_label_formatter(&|value| format!("{:.2}", unsigned_zero(*value)))
        .draw()?;
    for (name, samples, colour, width) in series {
        let style = colour.stroke_width(width * scale);
        // A command holds until the next one.
        let holds = name == "commanded";
        let mut before = None;
        let points = samples.iter().flat_map(|sample| {
            let value = (panel.value)(&sample.twist);
            let held = before.replace(value).filter(|_| holds).map(|held| (sample.at_s, held));
            held.into_iter().chain([(sample.at_s, value)])
        });
        let length = i32::try_from(24 * scale)?;
        chart
            .draw_series(LineSeries::new(points, style))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + length, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .legend_area_size(32 * scale)
        .margin(8 * scale)
        .background_style(WHITE.mix(0.85))
        .border_style(GRID)
        .label_font(text(14))
        .draw()?;
    Ok(())
}

/// Of a number that is printed with two digits at most.
fn unsigned_zero(value: f64) -> f64 {
    (value * 100.0).round() / 100.0 + 0.0
}

/// The mean of each square of [`OVERSAMPLING`] by [`OVERSAMPLING`] pixels.
fn averaged(large: &[u8]) -> Vec<u8> {
    let (side, width) = (OVERSAMPLING as usize, SIZE.0 as usize);
    let row_bytes = width * side * 3;
    let mut small = Vec::with_capacity(width * SIZE.1 as usize * 3);
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

fn encode(pixels: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, SIZE.0, SIZE.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use protocol::{SpeedMps, TurnRateRadps};

    use super::*;
    use crate::chassis::recording::Sample;

    #[test]
    fn one_sample_centuries_and_the_fastest_of_all_twists_are_drawn() {
        let fastest = Twist { vx: SpeedMps::MAX, vy: SpeedMps::MIN, wz: TurnRateRadps::MAX };
        let sample = |at_s, twist| Sample { at_s, twist };
        let rest = sample(0.0, Twist::default());
        for measured in [vec![rest], vec![rest, sample(1.8e10, fastest)], vec![sample(1.8e10, fastest), rest]]
        {
            let speeds = Speeds { measured, ..Speeds::default() };
            assert!(png(&speeds, "°²−").unwrap().starts_with(b"\x89PNG"));
        }
    }
}
