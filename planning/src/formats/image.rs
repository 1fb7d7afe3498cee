//! Grey, colour and palette pictures that maps are kept in: PGM and PNG.

use std::io::Cursor;

use crate::grid::MAX_SIDE;

/// The most memory that the samples of a picture may take, in bytes: a small file can promise much.
pub const MAX_BYTES: usize = 256 << 20;

/// What is wrong with a picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// It is neither PGM nor PNG.
    #[error("not a picture that can be read: expected PGM (P2, P5) or PNG")]
    Kind,
    /// A PGM's header does not continue as it should.
    #[error("line {line}: no {what} in the PGM's header: expected a whole number from 1 to 65535")]
    Header {
        /// The line, from 1.
        line: usize,
        /// What should stand there.
        what: &'static str,
    },
    /// It is larger than a map can be.
    #[error(
        "a picture of {width} x {height} pixels: expected sides of 1 to {MAX_SIDE} and at most {} MiB",
        MAX_BYTES >> 20
    )]
    TooLarge {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The file ends before the last pixel.
    #[error("the picture ends after {found} pixels: expected {expected}, as its header says")]
    TooShort {
        /// The pixels that the header promises.
        expected: usize,
        /// Those that are there.
        found: usize,
    },
    /// A pixel of a P2 picture is no number, or brighter than white.
    #[error(
        "line {line}: pixel {pixel} is no whole number from 0 to {white}: expected one, as the header says"
    )]
    Pixel {
        /// The line, from 1.
        line: usize,
        /// Which pixel, from 1.
        pixel: usize,
        /// The brightest value.
        white: u16,
    },
    /// It is no valid PNG.
    #[error("no valid PNG ({0}): expected a whole one")]
    Png(String),
}

/// A picture's pixels, from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    /// The value of white, or of what is opaque.
    white: u16,
    /// Samples a pixel: colours, then opacity if there is an even number.
    channels: usize,
    samples: Vec<u16>,
}

/// A pixel of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Its mean brightness over red, green and blue, from 0 to 1.
    pub shade: f64,
    /// How opaque it is, from 0 to 1; none in a picture where nothing can be seen through.
    pub opacity: Option<f64>,
}

impl Image {
    /// Columns.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// The pixels, row by row from the top.
    pub fn pixels(&self) -> impl Iterator<Item = Pixel> + '_ {
        let (white, has_opacity) = (f64::from(self.white), self.channels.is_multiple_of(2));
        self.samples.chunks_exact(self.channels).map(move |samples| {
            let (colours, opacity) = match samples {
                [colours @ .., opacity] if has_opacity => (colours, Some(f64::from(*opacity) / white)),
                colours => (colours, None),
            };
            let sum: f64 = colours.iter().copied().map(f64::from).sum();
            Pixel { shade: sum / colours.len() as f64 / white, opacity }
        })
    }
}

/// Reads a picture; which kind it is, its first bytes say.
///
/// # Errors
/// [`ImageError`] if it is none, or too large.
pub fn read(bytes: &[u8]) -> Result<Image, ImageError> {
    match bytes {
        [b'P', b'2' | b'5', ..] => pgm(bytes),
        [0x89, b'P', b'N', b'G', ..] => png(bytes),
        _ => Err(ImageError::Kind),
    }
}

/// Writes a binary 8-bit PGM of `width` columns, with `comment` in its header.
#[must_use]
pub fn write_pgm(width: u32, comment: &str, pixels: &[u8]) -> Vec<u8> {
    let height = pixels.len().checked_div(width as usize).unwrap_or(0);
    let mut bytes = format!("P5\n# {comment}\n{width} {height}\n255\n").into_bytes();
    bytes.extend(pixels);
    bytes
}

fn pgm(bytes: &[u8]) -> Result<Image, ImageError> {
    let ascii = bytes.get(1) == Some(&b'2');
    let mut words = Words { bytes, at: 2, line: 1 };
    let mut number = |what| {
        let found = words.next().and_then(|word| word.parse().ok()).filter(|&number: &u32| number > 0);
        found.ok_or(ImageError::Header { line: words.line, what })
    };
    let (width, height) = (number("width")?, number("height")?);
    let brightest = number("brightest value")?;
    let line = words.line;
    let white = u16::try_from(brightest).map_err(|_| ImageError::Header { line, what: "brightest value" })?;
    let pixels = checked(width, height, 2)?;
    let wide = if white > 255 { 2 } else { 1 };
    // A single space follows the header.
    let rest = bytes.get(words.at + 1..).unwrap_or_default();
    let samples: Vec<u16> = if ascii {
        let mut samples = Vec::new();
        while samples.len() < pixels {
            let expected = pixels;
            let Some(word) = words.next() else {
                return Err(ImageError::TooShort { expected, found: samples.len() });
            };
            let value = word.parse().ok().filter(|&value| value <= white);
            let (line, pixel) = (words.line, samples.len() + 1);
            samples.push(value.ok_or(ImageError::Pixel { line, pixel, white })?);
        }
        samples
    } else {
        let found = rest.len() / wide;
        if found < pixels {
            return Err(ImageError::TooShort { expected: pixels, found });
        }
        let one = |bytes: &[u8]| bytes.iter().fold(0, |value, &byte| value << 8 | u16::from(byte)).min(white);
        rest.chunks_exact(wide).take(pixels).map(one).collect()
    };
    Ok(Image { width, height, white, channels: 1, samples })
}

/// How many pixels there are, if a map can have as many.
fn checked(width: u32, height: u32, bytes_each: usize) -> Result<usize, ImageError> {
    let pixels = width as usize * height as usize;
    let fits = width.max(height) <= MAX_SIDE && pixels > 0 && pixels.saturating_mul(bytes_each) <= MAX_BYTES;
    fits.then_some(pixels).ok_or(ImageError::TooLarge { width, height })
}

fn png(bytes: &[u8]) -> Result<Image, ImageError> {
    let wrong = |error: png::DecodingError| ImageError::Png(error.to_string());
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: MAX_BYTES });
    // Palettes become colours, transparent colours opacity, few bits eight.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(wrong)?;
    let (width, height) = (reader.info().width, reader.info().height);
    let (colour, depth) = reader.output_color_type();
    let channels = colour.samples();
    checked(width, height, channels * 2)?;
    let mut content = vec![0; reader.output_buffer_size().ok_or(ImageError::TooLarge { width, height })?];
    reader.next_frame(&mut content).map_err(wrong)?;
    let (white, samples) = if depth == png::BitDepth::Sixteen {
        (u16::MAX, content.as_chunks::<2>().0.iter().map(|&sample| u16::from_be_bytes(sample)).collect())
    } else {
        (255, content.into_iter().map(u16::from).collect())
    };
    Ok(Image { width, height, white, channels, samples })
}

/// The words of a PGM, without its comments.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a str> {
        loop {
            match self.bytes.get(self.at)? {
                b'#' => {
                    let rest = self.bytes.get(self.at..)?;
                    self.at += rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
                }
                b'\n' => (self.at, self.line) = (self.at + 1, self.line + 1),
                byte if byte.is_ascii_whitespace() => self.at += 1,
                _ => break,
            }
        }
        let rest = self.bytes.get(self.at..)?;
        let end = rest.iter().position(|byte| byte.is_ascii_whitespace() || *byte == b'#');
        let word = rest.get(..end.unwrap_or(rest.len()))?;
        self.at += word.len();
        str::from_utf8(word).ok()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn shades(bytes: &[u8]) -> Vec<f64> {
        read(bytes).unwrap().pixels().map(|pixel| pixel.shade).collect()
    }

    fn encoded(colour: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == png::ColorType::Indexed {
            encoder.set_palette(vec![255, 255, 255, 0, 0, 0]);
            encoder.set_trns(vec![255, 51]);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    #[test]
    fn both_kinds_of_pgm_with_comments_are_read() {
        assert_eq!(shades(b"P2 # plain\n# made by hand\n3 1\n10\n0 5 # middle\n10\n"), [0.0, 0.5, 1.0]);
        assert_eq!(shades(b"P5\r\n#x\r\n2 1\n255\n\x00\xff"), [0.0, 1.0]);
        assert_eq!(shades(b"P5 2 1 65535\n\x00\x00\xff\xff"), [0.0, 1.0]);
    }

    #[test]
    fn all_kinds_of_png_are_read() {
        use png::{BitDepth, ColorType};
        assert_eq!(shades(&encoded(ColorType::Grayscale, BitDepth::One, &[0b0100_0000])), [0.0, 1.0]);
        assert_eq!(shades(&encoded(ColorType::Grayscale, BitDepth::Sixteen, &[0, 0, 255, 255])), [0.0, 1.0]);
        assert_eq!(
            shades(&encoded(ColorType::Rgb, BitDepth::Eight, &[0, 0, 255, 255, 255, 0])),
            [1.0 / 3.0, 2.0 / 3.0]
        );
        let palette = read(&encoded(ColorType::Indexed, BitDepth::One, &[0b0100_0000])).unwrap();
        let pixels: Vec<_> = palette.pixels().collect();
        assert_eq!(pixels[0], Pixel { shade: 1.0, opacity: Some(1.0) });
        assert_eq!(pixels[1], Pixel { shade: 0.0, opacity: Some(0.2) });
    }

    #[test]
    fn what_is_wrong_with_a_picture_is_said() {
        let error = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        assert_eq!(error(b"BM"), "not a picture that can be read: expected PGM (P2, P5) or PNG");
        assert_eq!(
            error(b"P5\n3 x"),
            "line 2: no height in the PGM's header: expected a whole number from 1 to 65535"
        );
        assert_eq!(
            error(b"P5 2 2 255\nabc"),
            "the picture ends after 3 pixels: expected 4, as its header says"
        );
        assert_eq!(
            error(b"P2 2 1 7\n3\n8"),
            "line 3: pixel 2 is no whole number from 0 to 7: expected one, as the header says"
        );
        assert!(error(b"P5 60000 60000 255\n").starts_with("a picture of 60000 x 60000 pixels"));
        assert!(error(b"\x89PNG\r\n\x1a\nrubbish").starts_with("no valid PNG"));
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic(head in "P[25][ \n][0-9]{0,3} [0-9]{0,3} [0-9]{0,5}[ \n#]", rest: Vec<u8>) {
            let _ = read(&[head.as_bytes(), &rest].concat());
        }
    }
}
