//! A test bench on a UART: a line of words in, a line out. What a board understands besides these is
//! its own:
//!
//! | line | what happens |
//! |---|---|
//! | `hang` | the task of the test bench never returns: the watchdog's business |
//! | `cost` | `cost TICKS MEDIAN WORST STACK`: instructions of control ticks, bytes of stack |
//!
//! A line that nobody understands is answered `what?`.

use core::fmt::Write as _;

use embedded_io_async::{Read, Write};
use heapless::{String, Vec};

use super::{cost, deepest_stack};
use crate::supervisor::Place;
use crate::tasks::waiting;

/// The longest line, in bytes.
pub const LINE: usize = 96;

/// A line.
pub type Line = String<LINE>;

/// Serves the test bench on `port`. `answer` takes the board's own words, and gives none to those it
/// does not understand.
pub async fn serve(
    mut port: impl Read + Write,
    place: Place,
    mut answer: impl AsyncFnMut(&str) -> Option<Line>,
) -> ! {
    let mut line = Vec::<u8, LINE>::new();
    loop {
        let mut byte = [0];
        let _ = waiting(place, port.read(&mut byte)).await;
        let [byte] = byte;
        if byte != b'\n' {
            // A line that is too long is none of ours, cut off or not.
            let _ = line.push(byte);
            continue;
        }
        let words = core::str::from_utf8(&line).unwrap_or_default();
        let mut said = match words {
            "hang" => loop {
                cortex_m::asm::nop();
            },
            "cost" => costs(),
            words => answer(words).await.unwrap_or_else(|| text(format_args!("what?"))),
        };
        // It fits, or what is cut off is seen by whoever asked.
        let _ = said.push('\n');
        line.clear();
        let _ = waiting(place, port.write_all(said.as_bytes())).await;
    }
}

/// A line of this text.
pub fn text(text: core::fmt::Arguments<'_>) -> Line {
    let mut line = Line::new();
    let _ = line.write_fmt(text);
    line
}

fn costs() -> Line {
    let cost::Costs { ticks, median, worst } = cost::take();
    text(format_args!("cost {ticks} {median} {worst} {}", deepest_stack()))
}
