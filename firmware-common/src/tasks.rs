//! Link, reader and supervisor as tasks, generic over a board's drivers.
//!
//! ```text
//!  link UART ──▶ listen ──▶ inbox ──▶ (the board's core) ──▶ outbox ──▶ speak ──▶ link UART
//!  reader UART ◀▶ watch ──▶
//! ```
//! What does not fit the inbox waits in the UARTs' rings. Each task checks in with the supervisor,
//! also while there is nothing to do. `listen` opens and `speak` seals what goes over the link, so
//! that the core sees only frames that are to be believed; neither does so in an interrupt, however
//! high the core runs.

use core::cell::RefCell;
use core::pin::pin;

use defmt::{Debug2Format, Display2Format, debug, error, warn};
use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Ticker, Timer, with_timeout};
use embedded_io_async::{Read, Write};
use protocol::{
    Deframer, Frame, FrameBytes, FrameError, Message, Packet, Recipient, SealError, Session, Sessions,
};

use crate::reader::{Seen, TagReader};
use crate::supervisor::{self, Place, Roll};

/// How often the reader is asked what is in its field.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// A reader answers within this time or not at all.
const POLL_TIMEOUT: Duration = Duration::from_millis(100);

/// After an error of a UART, so that one that lasts does not keep the others from running.
const PAUSE: Duration = Duration::from_millis(10);

/// A task that waits checks in this often: twice between two roll calls.
const CHECK_IN_INTERVAL: Duration = Duration::from_millis(supervisor::PERIOD.0 as u64 / 2);

/// What the other tasks tell the core.
#[expect(clippy::large_enum_variant, reason = "there is no heap to box it on")]
pub enum News {
    /// A frame arrived on the link, and is to be believed.
    Frame(Frame),
    /// Something arrived on the link that is no frame, or none to be believed.
    Discarded(FrameError),
    /// The reader answered.
    Seen(Seen),
}

/// What waits for the core.
pub type Inbox = Channel<CriticalSectionRawMutex, News, 4>;

/// Messages that wait for the link, and for whom they are.
pub type Outbox<const CAPACITY: usize> = Channel<CriticalSectionRawMutex, (Recipient, Message), CAPACITY>;

/// The board's sessions, for the two tasks of the link. They have to run on one executor.
pub struct Trusted<const PEERS: usize>(RefCell<Sessions<[Session; PEERS]>>);

impl<const PEERS: usize> Trusted<PEERS> {
    /// Shares `sessions`.
    #[must_use]
    pub const fn new(sessions: Sessions<[Session; PEERS]>) -> Self {
        Self(RefCell::new(sessions))
    }

    fn open(&self, packet: Packet<'_>) -> Result<Frame, FrameError> {
        // Never borrowed twice: neither task waits while it borrows, and neither interrupts the other.
        self.0.borrow_mut().open(packet)
    }

    fn seal(&self, to: Recipient, message: &Message) -> Result<FrameBytes, SealError> {
        self.0.borrow_mut().seal(to, message)
    }
}

/// Resets the board unless it is fed.
pub trait Watchdog {
    /// Starts its time anew; it then has at least three of [`supervisor::PERIOD`].
    fn feed(&mut self);
}

/// Waits for `work`, and checks in for as long as that takes.
pub async fn waiting<T>(place: Place, work: impl Future<Output = T>) -> T {
    let mut work = pin!(work);
    loop {
        place.check_in();
        if let Either::First(done) = select(work.as_mut(), Timer::after(CHECK_IN_INTERVAL)).await {
            return done;
        }
    }
}

/// Turns what arrives on the link into news for the core.
pub async fn listen<const PEERS: usize>(
    mut link: impl Read,
    trusted: &Trusted<PEERS>,
    inbox: &Inbox,
    place: Place,
) -> ! {
    let mut deframer = Deframer::new();
    let mut buffer = [0; 64];
    let mut errors: u32 = 0;
    loop {
        let length = match waiting(place, link.read(&mut buffer)).await {
            Ok(length) => length,
            Err(error) => {
                // Noise, or bytes that came too fast: they cost the frames they hit.
                errors = errors.saturating_add(1);
                warn!("link: {}, error {} since the start", Debug2Format(&error), errors);
                Timer::after(PAUSE).await;
                continue;
            }
        };
        for &byte in buffer.iter().take(length) {
            let Some(found) = deframer.push(byte) else { continue };
            let news = match found.and_then(|packet| trusted.open(packet)) {
                Ok(frame) => News::Frame(frame),
                Err(error) => {
                    warn!("link: {}", Display2Format(&error));
                    News::Discarded(error)
                }
            };
            waiting(place, inbox.send(news)).await;
        }
    }
}

/// Sends the core's messages on the link.
pub async fn speak<const PEERS: usize, const CAPACITY: usize>(
    mut link: impl Write,
    trusted: &Trusted<PEERS>,
    outbox: &Outbox<CAPACITY>,
    place: Place,
) -> ! {
    loop {
        let (to, message) = waiting(place, outbox.receive()).await;
        match trusted.seal(to, &message) {
            Ok(frame) => {
                if let Err(error) = waiting(place, link.write_all(&frame)).await {
                    warn!("link: {}", Debug2Format(&error));
                }
            }
            // It comes again once the peer was heard.
            Err(error) => debug!("link: {}", Display2Format(&error)),
        }
    }
}

/// Asks the reader again and again what is in its field. Its silence is the core's to notice.
pub async fn watch(mut reader: impl TagReader, inbox: &Inbox, place: Place) -> ! {
    let mut ticker = Ticker::every(POLL_INTERVAL);
    loop {
        waiting(place, ticker.next()).await;
        let mut found = heapless::Vec::<Seen, 8>::new();
        let poll = reader.poll(|reply| match reply {
            // More tags than these in one field are seen at the next poll.
            Ok(seen) => drop(found.push(seen)),
            Err(error) => warn!("reader: {}", Display2Format(&error)),
        });
        if waiting(place, with_timeout(POLL_TIMEOUT, poll)).await.is_err() {
            debug!("reader: no answer");
        }
        for seen in found {
            waiting(place, inbox.send(News::Seen(seen))).await;
        }
    }
}

/// Feeds the watchdog while nobody is missing from the roll. `names` are for the log.
pub async fn supervise<const TASKS: usize>(
    mut watchdog: impl Watchdog,
    roll: &Roll<TASKS>,
    names: [&'static str; TASKS],
) -> ! {
    let mut ticker = Ticker::every(Duration::from_millis(supervisor::PERIOD.0.into()));
    loop {
        ticker.next().await;
        match roll.call() {
            Ok(()) => watchdog.feed(),
            Err(missing) => {
                for (index, name) in names.iter().enumerate() {
                    if missing.0 & (1 << index) != 0 {
                        error!("watchdog: {} did not check in", *name);
                    }
                }
            }
        }
    }
}
