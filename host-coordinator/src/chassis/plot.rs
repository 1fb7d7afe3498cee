//! The commanded, ramped and measured speed of a recording as a PNG: a panel for each of forward,
//! left and turn.

use plotters::{coord::Shift, prelude::*, style::RGBColor};
use protocol::Twist;

use super::recording::Speeds;
use crate::plot::{Drawn, GRID, INK, Picture, PlotError, text_style};

/// The picture's size in pixels.
pub const SIZE: (u32, u32) = (1_200, 1_080);

// Of Okabe and Ito: told apart by colour-blind people too.
const COMMANDED: RGBColor = RGBColor(0, 0, 0);
const RAMPED: RGBColor = RGBColor(230, 159, 0);
const MEASURED: RGBColor = RGBColor(0, 114, 178);

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
    crate::plot::png(&Panels { speeds, title })
}

struct Panels<'a> {
    speeds: &'a Speeds,
    title: &'a str,
}

impl Picture for Panels<'_> {
    fn size(&self) -> (u32, u32) {
        SIZE
    }

    fn draw<B>(&self, area: &DrawingArea<B, Shift>, scale: u32) -> Drawn
    where
        B: DrawingBackend,
        B::ErrorType: 'static,
    {
        let area = area.margin(10 * scale, 10 * scale, 10 * scale, 20 * scale);
        let area = area.titled(self.title, text_style(20, scale))?;
        for (panel, area) in PANELS.iter().zip(area.split_evenly((PANELS.len(), 1))) {
            draw_panel(&area, scale, panel, self.speeds)?;
        }
        Ok(())
    }
}

fn draw_panel<B>(area: &DrawingArea<B, Shift>, scale: u32, panel: &Panel, speeds: &Speeds) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
{
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
    let text = |size| text_style(size, scale);
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
