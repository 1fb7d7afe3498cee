//! A line that shows how something is now.

use std::{
    io::{self, IsTerminal as _, Write as _},
    time::{Duration, Instant},
};

/// A line that is written again in its place on a terminal, and one under the other elsewhere.
pub struct LiveLine {
    terminal: bool,
    shown: Option<Instant>,
}

impl LiveLine {
    /// Nothing is shown yet.
    pub fn new() -> Self {
        Self { terminal: io::stdout().is_terminal(), shown: None }
    }

    /// Shows `line`, unless the last is too young to have been read.
    pub fn show(&mut self, line: impl FnOnce() -> String) -> io::Result<()> {
        let interval = Duration::from_millis(if self.terminal { 100 } else { 1_000 });
        if self.shown.is_some_and(|shown| shown.elapsed() < interval) {
            return Ok(());
        }
        self.shown = Some(Instant::now());
        let mut stdout = anstream::stdout().lock();
        if self.terminal {
            // Without a line break at the terminal's edge: a second line would not be overwritten.
            write!(stdout, "\r\x1b[2K\x1b[?7l{}\x1b[?7h", line())?;
        } else {
            writeln!(stdout, "{}", line())?;
        }
        stdout.flush()
    }

    /// Leaves the last line as it is.
    pub fn close(self) {
        if self.terminal && self.shown.is_some() {
            // Nothing is left to do where standard output is closed.
            let _ = writeln!(io::stdout());
        }
    }
}
