//! A line in use: what happens on it next, and what is written to it.

use std::{
    io,
    pin::Pin,
    time::{Duration, Instant},
};

use protocol::Millis;
use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    time::{self, Interval, MissedTickBehavior},
};

use super::Line;

/// How often time passes for who uses a line.
const TICK: Duration = Duration::from_millis(5);
/// A line that takes no byte for this long is lost.
const STUCK: Duration = Duration::from_secs(2);

/// What has happened.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// Time has passed.
    Tick,
    /// The person wants it to end; once.
    Interrupt,
    /// These bytes have arrived.
    Bytes(&'a [u8]),
}

/// A line, a clock that starts at 0 with it, and the person who may want it to end.
pub struct Wire<'a> {
    line: &'a mut dyn Line,
    interrupt: Option<Pin<Box<dyn Future<Output = ()> + 'a>>>,
    ticks: Interval,
    start: Instant,
    buffer: [u8; 2048],
}

impl<'a> Wire<'a> {
    /// Uses `line` until the caller is done with it; `interrupt` ends when the person wants it to
    /// end.
    pub fn new(line: &'a mut dyn Line, interrupt: impl Future<Output = ()> + 'a) -> Self {
        let mut ticks = time::interval(TICK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let interrupt: Pin<Box<dyn Future<Output = ()> + 'a>> = Box::pin(interrupt);
        Self { line, interrupt: Some(interrupt), ticks, start: Instant::now(), buffer: [0; 2048] }
    }

    /// The time since the start.
    #[must_use]
    pub fn now(&self) -> Millis {
        Millis(u64::try_from(self.start.elapsed().as_millis()).unwrap_or(u64::MAX))
    }

    /// Waits for what happens next.
    ///
    /// # Errors
    /// The line is lost.
    pub async fn next(&mut self) -> io::Result<Event<'_>> {
        let interrupted = async {
            match &mut self.interrupt {
                Some(interrupt) => interrupt.await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            _ = self.ticks.tick() => Ok(Event::Tick),
            () = interrupted => {
                self.interrupt = None;
                Ok(Event::Interrupt)
            }
            read = self.line.read(&mut self.buffer) => match read? {
                0 => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the other side hung up")),
                length => Ok(Event::Bytes(self.buffer.get(..length).unwrap_or_default())),
            }
        }
    }

    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// The line is lost, or takes nothing.
    pub async fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        time::timeout(STUCK, self.line.write_all(bytes)).await?
    }
}
