//! The task that runs the pile's core, generic over a board's drivers; the tasks around it are
//! those of [`firmware_common::tasks`].
//!
//! It alone owns the core and never waits for another task: what does not fit the outbox is
//! dropped, as a message lost on the link would be, and comes again.

use defmt::warn;
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Ticker};
use firmware_common::supervisor::Place;
use firmware_common::tasks::{Inbox, News, Outbox};
use protocol::{Epoch, Millis};

use crate::{ChargingPile, Contactor, Input, Outputs};

/// How often the core learns that time has passed; it asks for 100 ms at the latest.
const TICK: Duration = Duration::from_millis(50);

/// Messages that wait for the link: those of a step, and as many again.
pub const OUTBOX: usize = 2 * crate::pile::MESSAGES_PER_STEP;

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

/// Runs the core: every input at its time, the contactor first, then the memory, then the messages.
pub async fn run(
    mut pile: ChargingPile,
    mut contacts: impl Contacts,
    mut memory: impl Memory,
    inbox: &Inbox,
    outbox: &Outbox<OUTBOX>,
    place: Place,
) -> ! {
    let mut ticker = Ticker::every(TICK);
    loop {
        let news = select(inbox.receive(), ticker.next()).await;
        place.check_in();
        let now = Millis(Instant::now().as_millis());
        let outputs = match &news {
            Either::First(News::Frame(frame)) => pile.step(now, Input::Frame(frame)),
            Either::First(News::Seen(seen)) => pile.step(now, (*seen).into()),
            Either::First(News::Discarded(_)) => continue,
            Either::Second(()) => pile.step(now, Input::ContactorFeedback { closed: contacts.closed() }),
        };
        obey(outputs, &mut contacts, &mut memory, outbox).await;
    }
}

async fn obey(
    outputs: Outputs,
    contacts: &mut impl Contacts,
    memory: &mut impl Memory,
    outbox: &Outbox<OUTBOX>,
) {
    contacts.command(outputs.contactor);
    if let Some(epoch) = outputs.store_epoch {
        memory.store_epoch(epoch).await;
    }
    // Over a UART both the coordinator and, through it, the other piles are reached.
    for outgoing in outputs.messages {
        if outbox.try_send((outgoing.to.into(), outgoing.message)).is_err() {
            warn!("link: too slow, a message is lost");
        }
    }
}
