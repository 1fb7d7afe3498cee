//! The task that runs the pile's core, generic over a board's drivers; the tasks around it are
//! those of [`firmware_common::tasks`].
//!
//! It alone owns the core and has an interrupt executor to itself: nothing that the other tasks do
//! delays a sample of the sensors. It never waits for another task: what does not fit the outbox is
//! dropped, as a message lost on the link would be, and comes again.

use defmt::warn;
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Ticker};
use firmware_common::supervisor::Place;
use firmware_common::tasks::{Inbox, News, Outbox};
use protocol::{Availability, Millis};

use crate::{ChargingPile, Input, Outputs, Power, Sensors, store::Record};

/// How often the sensors are read.
const TICK: Duration = Duration::from_millis(10);

/// Messages that wait for the link: those of a step, and as many again.
pub const OUTBOX: usize = 2 * crate::io::MESSAGES_PER_STEP;

/// Sensors, power stage and contactor of a board. Neither call may wait for long: a tick has 10 ms.
pub trait Charger {
    /// What the sensors say `now`; called once a tick.
    fn sense(&mut self, now: Millis) -> Sensors;

    /// What contactor and power stage do from now on. A contactor that is to open is opened first.
    fn command(&mut self, power: Power);

    /// What a person who stands at the pile is to see, if the board can show it.
    fn show(&mut self, _availability: Availability) {}
}

/// What a restart must not forget.
pub trait Memory {
    /// Stores a record. When this returns, it is stored.
    fn store(&mut self, record: Record) -> impl Future<Output = ()>;
}

/// Runs the core: every input at its time, a sample before anything else that waits; the power first,
/// then the memory, then the messages.
pub async fn run(
    mut pile: ChargingPile,
    mut charger: impl Charger,
    mut memory: impl Memory,
    inbox: &Inbox,
    outbox: &Outbox<OUTBOX>,
    place: Place,
) -> ! {
    let mut ticker = Ticker::every(TICK);
    loop {
        let event = select(ticker.next(), inbox.receive()).await;
        let now = Millis(Instant::now().as_millis());
        let outputs = match &event {
            Either::First(()) => {
                place.check_in();
                pile.step(now, Input::Sensors(charger.sense(now)))
            }
            Either::Second(News::Frame(frame)) => pile.step(now, Input::Frame(frame)),
            Either::Second(News::Seen(seen)) => pile.step(now, (*seen).into()),
            Either::Second(News::Discarded(error)) => pile.step(now, Input::Discarded(*error)),
        };
        obey(outputs, &mut charger, &mut memory, outbox).await;
        charger.show(pile.availability());
    }
}

async fn obey(
    outputs: Outputs,
    charger: &mut impl Charger,
    memory: &mut impl Memory,
    outbox: &Outbox<OUTBOX>,
) {
    charger.command(outputs.power);
    if outputs.urgent {
        outbox.clear();
    }
    for record in outputs.store {
        memory.store(record).await;
    }
    // Over a UART both the coordinator and, through it, the other piles are reached.
    for outgoing in outputs.messages {
        if outbox.try_send((outgoing.to.into(), outgoing.message)).is_err() {
            warn!("link: too slow, a message is lost");
        }
    }
}
