//! The maps of ROS's `map_server`: a YAML file that names a picture.
//!
//! A pixel's occupancy is its darkness, or its brightness if `negate` is set, from 0 to 1. It is
//! compared as Nav2's map_server does it:
//!
//! | mode | occupied | free | otherwise |
//! |---|---|---|---|
//! | `trinary` (if none is named) | above `occupied_thresh` | below `free_thresh` | unknown |
//! | `scale` | the same | the same | unknown if seen through, else in between |
//! | `raw` | the pixel's value is a percentage from 0 to 100 above `occupied_thresh` | below `free_thresh` | unknown |
//!
//! In `trinary` mode opacity counts as a fourth colour; in `raw` mode `negate` means nothing. Only what
//! is free is free: **a robot goes neither where nobody has looked nor where a cell is in between.**
//! `occupied_thresh` may be left out for 0.65, `free_thresh` for 0.196 (which keeps the grey 205 unknown
//! that map savers write), `mode`, `negate` and the origin's yaw too.

use serde::Deserialize;

use super::{
    image::{self, Image, Pixel},
    yaml::{self, YamlError},
};
use crate::{
    frame::Frame,
    grid::{Grid, TooLarge},
};

/// What is wrong with a map's YAML file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RosError {
    /// It is no YAML, or lacks something.
    #[error(transparent)]
    Yaml(#[from] YamlError),
    /// A value makes no sense.
    #[error("`{key}` is {found}: expected {expected}")]
    Value {
        /// The key.
        key: &'static str,
        /// What it says.
        found: String,
        /// What it should.
        expected: &'static str,
    },
    /// The picture is larger than a grid can be.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

/// How pixels are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

/// A map's YAML file.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The picture's file, if relative then to the YAML file's folder.
    pub image: String,
    resolution_m: f64,
    /// x and y in metres, yaw in radians.
    origin: [f64; 3],
    occupied: f64,
    free: f64,
    negate: bool,
    mode: Mode,
}

/// A map with its place in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct RosMap {
    /// Which cells are free for sure.
    pub grid: Grid,
    /// Where they are.
    pub frame: Frame,
    /// How many cells are neither free nor occupied; they are blocked in the grid.
    pub unknown: usize,
}

#[derive(Deserialize)]
struct Raw {
    image: String,
    resolution: f64,
    origin: Vec<f64>,
    negate: Option<Switch>,
    occupied_thresh: Option<f64>,
    free_thresh: Option<f64>,
    mode: Option<String>,
}

/// `0`, `1` or a truth value.
#[derive(Deserialize)]
#[serde(untagged)]
enum Switch {
    Number(i64),
    Truth(bool),
}

fn value(key: &'static str, found: impl ToString, expected: &'static str) -> RosError {
    RosError::Value { key, found: found.to_string(), expected }
}

impl Description {
    /// Reads a map's YAML file.
    ///
    /// # Errors
    /// [`RosError`] says what is wrong with it.
    pub fn read(text: &str) -> Result<Self, RosError> {
        let raw: Raw = yaml::read(text)?;
        if raw.image.trim().is_empty() {
            return Err(value("image", "empty", "the picture's file"));
        }
        if !(0.0001..=1000.0).contains(&raw.resolution) {
            return Err(value("resolution", raw.resolution, "metres for a pixel, more than 0"));
        }
        let origin = match *raw.origin {
            [x, y] => [x, y, 0.0],
            [x, y, yaw] => [x, y, yaw],
            _ => return Err(value("origin", format!("{:?}", raw.origin), "[x, y, yaw]")),
        };
        if !origin.iter().all(|number| number.abs() < 1e9) {
            return Err(value("origin", format!("{origin:?}"), "finite numbers of metres and radians"));
        }
        let (occupied, free) = (raw.occupied_thresh.unwrap_or(0.65), raw.free_thresh.unwrap_or(0.196));
        for (key, threshold) in [("occupied_thresh", occupied), ("free_thresh", free)] {
            if !(0.0..=1.0).contains(&threshold) {
                return Err(value(key, threshold, "a number from 0 to 1"));
            }
        }
        if free > occupied {
            return Err(value("free_thresh", free, "no more than `occupied_thresh`"));
        }
        let mode = match raw.mode.as_deref().map(str::to_ascii_lowercase).as_deref() {
            None | Some("trinary") => Mode::Trinary,
            Some("scale") => Mode::Scale,
            Some("raw") => Mode::Raw,
            Some(other) => return Err(value("mode", format!("`{other}`"), "trinary, scale or raw")),
        };
        let negate = raw.negate.is_some_and(|negate| match negate {
            Switch::Number(number) => number != 0,
            Switch::Truth(truth) => truth,
        });
        Ok(Self { image: raw.image, resolution_m: raw.resolution, origin, occupied, free, negate, mode })
    }

    /// The map that `image` shows.
    ///
    /// # Errors
    /// [`RosError::TooLarge`] if no grid can be as large.
    pub fn map(&self, image: &Image) -> Result<RosMap, RosError> {
        let mut grid = Grid::blocked(image.width(), image.height())?;
        let mut unknown = 0;
        for (index, pixel) in image.pixels().enumerate() {
            match self.is_free(pixel) {
                Some(free) => grid.set(grid.cell(index), free),
                None => unknown += 1,
            }
        }
        let [x, y, yaw_rad] = self.origin;
        let frame =
            Frame { resolution_m: self.resolution_m, origin_m: [x, y], yaw_rad, rows: image.height() };
        Ok(RosMap { grid, frame, unknown })
    }

    /// Whether a pixel is free or occupied, if either.
    fn is_free(&self, Pixel { shade, opacity }: Pixel) -> Option<bool> {
        let shade = match (self.mode, opacity) {
            (Mode::Trinary, Some(opacity)) => (3.0 * shade + opacity) / 4.0,
            (Mode::Scale, Some(opacity)) if opacity < 1.0 => return None,
            _ => shade,
        };
        let occupancy = match self.mode {
            Mode::Raw => (shade * 255.0).round() / 100.0,
            _ if self.negate => shade,
            _ => 1.0 - shade,
        };
        if self.mode == Mode::Raw && occupancy > 1.0 {
            return None;
        }
        let (occupied, free) = (occupancy > self.occupied, occupancy < self.free);
        (occupied || free).then_some(free)
    }
}

/// Writes a map as map_server reads it: the YAML file, which names the picture `image`, and the
/// picture as PGM. Blocked cells are occupied.
#[must_use]
pub fn write(grid: &Grid, frame: &Frame, image: &str) -> (String, Vec<u8>) {
    let Frame { resolution_m, origin_m: [x, y], yaw_rad, .. } = frame;
    // A JSON string is a YAML string too, whatever is in it.
    let name = serde_json::Value::from(image);
    let text = format!(
        "image: {name}\nmode: trinary\nresolution: {resolution_m:?}\norigin: [{x:?}, {y:?}, {yaw_rad:?}]\n\
         negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    );
    let pixels: Vec<u8> =
        (0..grid.len()).map(|index| if grid.is_free(grid.cell(index)) { 254 } else { 0 }).collect();
    (text, image::write_pgm(grid.width(), "Chargehand", &pixels))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const HEAD: &str = "image: a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n";

    /// What becomes of grey pixels: `.` free, `@` occupied, `?` unknown.
    fn read(text: &str, greys: &[u8]) -> String {
        let description = Description::read(&format!("{HEAD}{text}")).unwrap();
        let image = image::read(&image::write_pgm(greys.len() as u32, "", greys)).unwrap();
        let sign = |pixel| match description.is_free(pixel) {
            Some(true) => '.',
            Some(false) => '@',
            None => '?',
        };
        image.pixels().map(sign).collect()
    }

    #[test]
    fn pixels_are_compared_as_map_server_does() {
        // 205 is 0.19608 occupied, 89 and 90 are just above and below 0.65.
        let greys = [0, 89, 90, 205, 206, 255];
        assert_eq!(read("", &greys), "@@??..");
        assert_eq!(read("free_thresh: 0.25", &greys), "@@?...");
        assert_eq!(read("negate: 1", &greys), ".??@@@");
        assert_eq!(read("negate: true", &greys), read("negate: 1", &greys));
        assert_eq!(read("mode: Raw", &[0, 19, 20, 65, 66, 100, 101, 255]), "..??@@??");
    }

    #[test]
    fn opacity_is_a_colour_in_trinary_mode_and_unknown_in_scale_mode() {
        let trinary = Description::read(HEAD).unwrap();
        let scale = Description::read(&format!("{HEAD}mode: scale\n")).unwrap();
        let black = |opacity| Pixel { shade: 0.0, opacity: Some(opacity) };
        assert_eq!((trinary.is_free(black(1.0)), trinary.is_free(black(0.0))), (Some(false), Some(false)));
        assert_eq!((scale.is_free(black(1.0)), scale.is_free(black(0.9))), (Some(false), None));
        let white = Pixel { shade: 1.0, opacity: Some(0.0) };
        assert_eq!((trinary.is_free(white), scale.is_free(white)), (None, None));
    }

    #[test]
    fn variants_that_people_write_are_read() {
        let text =
            "\u{feff}# by hand\r\nimage:\t'x y.PNG'\r\nresolution: 1e-1\r\norigin: [-1, 2]\r\nnegate: 0\r\n";
        let description = Description::read(text).unwrap();
        assert_eq!((description.image.as_str(), description.origin), ("x y.PNG", [-1.0, 2.0, 0.0]));
    }

    #[test]
    fn nonsense_is_refused_with_its_place() {
        let error = |text: &str| Description::read(text).unwrap_err().to_string();
        assert!(error("image: a\nresolution: five\norigin: [0, 0]\n").starts_with("line 2: "));
        assert!(error("image: a\nresolution: 1\n").contains("origin"));
        assert_eq!(
            error("image: a\nresolution: 0\norigin: [0, 0]\n"),
            "`resolution` is 0: expected metres for a pixel, more than 0"
        );
        assert_eq!(
            error("image: a\nresolution: 1\norigin: [0]\n"),
            "`origin` is [0.0]: expected [x, y, yaw]"
        );
        assert_eq!(
            error("image: a\nresolution: 1\norigin: [.nan, 0]\n"),
            "`origin` is [NaN, 0.0, 0.0]: expected finite numbers of metres and radians"
        );
        assert_eq!(error(&format!("{HEAD}mode: grey\n")), "`mode` is `grey`: expected trinary, scale or raw");
        assert_eq!(
            error(&format!("{HEAD}occupied_thresh: 0.1\n")),
            "`free_thresh` is 0.196: expected no more than `occupied_thresh`"
        );
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again(
            width in 1u32..20, cells in prop::collection::vec(any::<bool>(), 1..200),
            origin_m in prop::array::uniform2(-100.0..100.0), yaw_rad in -3.0..3.0, name in "[ -~]{1,9}",
        ) {
            prop_assume!(!name.trim().is_empty());
            let rows = (cells.len() as u32).div_ceil(width);
            let mut grid = Grid::blocked(width, rows).unwrap();
            for (index, &free) in cells.iter().enumerate() {
                grid.set(grid.cell(index), free);
            }
            let frame = Frame { resolution_m: 0.05, origin_m, yaw_rad, rows };
            let (text, picture) = write(&grid, &frame, &name);
            let description = Description::read(&text).unwrap();
            prop_assert_eq!(&description.image, &name);
            let map = description.map(&image::read(&picture).unwrap()).unwrap();
            prop_assert_eq!(map, RosMap { grid, frame, unknown: 0 });
        }

        #[test]
        fn no_text_makes_the_reader_panic(text in "(image: a\n)?(resolution: [0-9.e-]{1,5}\n)?(origin: [\\[\\]0-9, ]{1,9}\n)?[ -~\n\t]{0,60}") {
            let _ = Description::read(&text);
        }
    }
}
