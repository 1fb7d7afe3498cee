//! The pile's tasks, generic over a board's drivers: bytes and time in, commands and bytes out.
//!
//! ```text
//!  link UART ──▶ listen ──▶                        ──▶ speak ──▶ link UART
//!                           inbox ──▶ run ──▶ outbox
//!  reader UART ◀▶ watch ──▶            │
//!                                      ▼ contactor, memory
//! ```
//! [`run`] alone owns the core and never waits for another task: what does not fit the outbox is
//! dropped, as a message lost on the link would be, and comes again. What does not fit the inbox
//! waits in the UARTs' rings.

use defmt::{Debug2Format, Display2Format, debug, warn};
use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Instant, Ticker, Timer, with_timeout};
use embedded_io_async::{Read, Write};
use protocol::{Deframer, Epoch, Frame, FrameBytes, FrameWriter, Millis};

use crate::reader::Seen;
use crate::reader::r200::R200;
use crate::{ChargingPile, Contactor, Input, Outputs};

/// How often the core learns that time has passed; it asks for 100 ms at the latest.
const TICK: Duration = Duration::from_millis(50);

/// How often the reader is asked what is in its field.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// A reader answers within this time or not at all.
const POLL_TIMEOUT: Duration = Duration::from_millis(100);

/// After an error of a UART, so that one that lasts does not keep the others from running.
const PAUSE: Duration = Duration::from_millis(10);

/// What the other tasks tell the core.
#[expect(clippy::large_enum_variant, reason = "there is no heap to box it on")]
pub enum News {
    /// A frame arrived on the link.
    Frame(Frame),
    /// The reader answered.
    Seen(Seen),
}

/// What waits for the core.
pub type Inbox = Channel<CriticalSectionRawMutex, News, 4>;

/// Frames that wait for the link: those of a step, and as many again.
pub type Outbox = Channel<CriticalSectionRawMutex, FrameBytes, { 2 * crate::pile::MESSAGES_PER_STEP }>;

/// The switch between the mains and the contacts.
pub trait Contacts {
    /// Makes the contacts live or dead.
    fn command(&mut self, contactor: Contactor);

    /// Whether the contactor is found closed by its auxiliary contact, whatever it was told.
    fn closed(&self) -> bool;
}

/// What a restart must not forget.
pub trait Memory {
    /// Stores the highest epoch seen. When this returns, it is stored.
    fn store_epoch(&mut self, epoch: Epoch) -> impl Future<Output = ()>;
}

/// Turns what arrives on the link into frames for the core.
pub async fn listen(mut link: impl Read, inbox: &Inbox) -> ! {
    let mut deframer = Deframer::new();
    let mut buffer = [0; 64];
    loop {
        let length = match link.read(&mut buffer).await {
            Ok(length) => length,
            Err(error) => {
                warn!("link: {}", Debug2Format(&error));
                Timer::after(PAUSE).await;
                continue;
            }
        };
        for &byte in buffer.iter().take(length) {
            match deframer.push(byte) {
                None => {}
                Some(Ok(frame)) => inbox.send(News::Frame(frame)).await,
                Some(Err(error)) => warn!("link: {}", Display2Format(&error)),
            }
        }
    }
}

/// Sends the core's frames on the link.
pub async fn speak(mut link: impl Write, outbox: &Outbox) -> ! {
    loop {
        let frame = outbox.receive().await;
        if let Err(error) = link.write_all(&frame).await {
            warn!("link: {}", Debug2Format(&error));
        }
    }
}

/// Asks the reader again and again what is in its field. Its silence is the core's to notice.
pub async fn watch<Port: Read + Write>(mut reader: R200<Port>, inbox: &Inbox) -> ! {
    let mut ticker = Ticker::every(POLL_INTERVAL);
    loop {
        ticker.next().await;
        let mut found = heapless::Vec::<Seen, 8>::new();
        let poll = reader.poll(|reply| match reply {
            // More tags than these in one field are seen at the next poll.
            Ok(seen) => drop(found.push(seen)),
            Err(error) => warn!("reader: {}", Display2Format(&error)),
        });
        match with_timeout(POLL_TIMEOUT, poll).await {
            Ok(Ok(())) => {}
            Ok(Err(error)) => warn!("reader: {}", Debug2Format(&error)),
            Err(_) => debug!("reader: no answer"),
        }
        for seen in found {
            inbox.send(News::Seen(seen)).await;
        }
    }
}

/// Runs the core: every input at its time, the contactor first, then the memory, then the messages.
pub async fn run(
    mut pile: ChargingPile,
    mut writer: FrameWriter,
    mut contacts: impl Contacts,
    mut memory: impl Memory,
    inbox: &Inbox,
    outbox: &Outbox,
) -> ! {
    let mut ticker = Ticker::every(TICK);
    loop {
        let news = select(inbox.receive(), ticker.next()).await;
        let now = Millis(Instant::now().as_millis());
        let outputs = match &news {
            Either::First(News::Frame(frame)) => pile.step(now, Input::Frame(frame)),
            Either::First(News::Seen(seen)) => pile.step(now, (*seen).into()),
            Either::Second(()) => pile.step(now, Input::ContactorFeedback { closed: contacts.closed() }),
        };
        obey(outputs, &mut writer, &mut contacts, &mut memory, outbox).await;
    }
}

async fn obey(
    outputs: Outputs,
    writer: &mut FrameWriter,
    contacts: &mut impl Contacts,
    memory: &mut impl Memory,
    outbox: &Outbox,
) {
    contacts.command(outputs.contactor);
    if let Some(epoch) = outputs.store_epoch {
        memory.store_epoch(epoch).await;
    }
    // Over a UART both the coordinator and, through it, the other piles are reached.
    for outgoing in outputs.messages {
        match writer.write(outgoing.message) {
            Ok(frame) => {
                if outbox.try_send(frame).is_err() {
                    warn!("link: too slow, a message is lost");
                }
            }
            Err(error) => warn!("link: {}", Display2Format(&error)),
        }
    }
}
