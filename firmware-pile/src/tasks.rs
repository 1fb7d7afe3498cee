//! The task that runs the pile's core, generic over a board's drivers; the tasks around it are
//! those of [`firmware_common::tasks`].
//!
//! It alone owns the core and has an interrupt executor to itself: nothing that the other tasks do
//! delays a sample of the sensors. It never waits for another task: what does not fit the outbox is
//! dropped, as a message lost on the link would be, and comes again.

use core::fmt::Debug;

use cortex_m::peripheral::SCB;
use defmt::{Display2Format, error, info, warn};
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Ticker};
use embedded_storage_async::nor_flash::NorFlash;
use firmware_common::supervisor::Place;
use firmware_common::tasks::{Inbox, News, Outbox};
use protocol::{Availability, DeviceId, Millis, Recipient};

use crate::device::Device;
use crate::provisioning::Fresh;
use crate::store::{Record, Store};
use crate::{ChargingPile, Input, Outputs, Power, Sensors};

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

/// Runs a board: every input at its time, a sample before anything else that waits; the power first,
/// then the store, then the messages. `button_held` says whether the button is held. The device is too
/// large to be handed over on a stack.
pub async fn run<F: NorFlash<Error: Debug>>(
    device: &mut Device,
    mut charger: impl Charger,
    mut store: Store<F>,
    mut button_held: impl FnMut() -> bool,
    inbox: &Inbox,
    outbox: &Outbox<OUTBOX>,
    place: Place,
) -> ! {
    // A charge may begin with the first frame.
    make_room(&mut store).await;
    let pile = match device {
        Device::Pile(pile) => pile,
        Device::Fresh(fresh) => wait_for_identity(fresh, store, inbox, outbox, place).await,
    };
    let mut held = button_held();
    if held {
        // Frames that wait already were sent while it was.
        pile.step(Millis(Instant::now().as_millis()), Input::Button { held });
    }
    let mut ticker = Ticker::every(TICK);
    loop {
        let event = select(ticker.next(), inbox.receive()).await;
        let now = Millis(Instant::now().as_millis());
        let outputs = match &event {
            Either::First(()) if held != button_held() => {
                held = !held;
                pile.step(now, Input::Button { held })
            }
            Either::First(()) => {
                place.check_in();
                pile.step(now, Input::Sensors(charger.sense(now)))
            }
            Either::Second(News::Frame(frame)) => pile.step(now, Input::Frame(frame)),
            Either::Second(News::Seen(seen)) => pile.step(now, (*seen).into()),
            Either::Second(News::Discarded(error)) => pile.step(now, Input::Discarded(*error)),
        };
        obey(outputs, now, pile, &mut charger, &mut store, outbox).await;
        charger.show(pile.availability());
    }
}

async fn obey<F: NorFlash<Error: Debug>>(
    mut outputs: Outputs,
    now: Millis,
    pile: &mut ChargingPile,
    charger: &mut impl Charger,
    store: &mut Store<F>,
    outbox: &Outbox<OUTBOX>,
) {
    charger.command(outputs.power);
    if !keep(store, &outputs.store).await {
        outputs = pile.step(now, Input::StoreFailed);
        charger.command(outputs.power);
    }
    if !pile.energised() {
        make_room(store).await;
    }
    if outputs.urgent {
        outbox.clear();
    }
    // Over a UART both the coordinator and, through it, the other piles are reached.
    for outgoing in outputs.messages {
        if outbox.try_send((outgoing.to.into(), outgoing.message)).is_err() {
            warn!("link: too slow, a message is lost");
        }
    }
    if outputs.restart {
        restart();
    }
}

/// Runs a board that is nobody, which has nothing to charge with, until it restarts as somebody.
async fn wait_for_identity<F: NorFlash<Error: Debug>>(
    fresh: &mut Fresh,
    mut store: Store<F>,
    inbox: &Inbox,
    outbox: &Outbox<OUTBOX>,
    place: Place,
) -> ! {
    let mut ticker = Ticker::every(TICK);
    loop {
        let event = select(ticker.next(), inbox.receive()).await;
        place.check_in();
        let now = Millis(Instant::now().as_millis());
        let outputs = match &event {
            Either::Second(News::Frame(frame)) => fresh.step(now, Some(frame)),
            _ => fresh.step(now, None),
        };
        if !keep(&mut store, outputs.store.as_slice()).await {
            fresh.store_failed();
            continue;
        }
        for message in outputs.messages {
            if outbox.try_send((Recipient::Device(DeviceId::Service), message)).is_err() {
                warn!("link: too slow, a message is lost");
            }
        }
        if outputs.restart {
            restart();
        }
    }
}

/// Stores the records; whether all of them are.
async fn keep<F: NorFlash<Error: Debug>>(store: &mut Store<F>, records: &[Record]) -> bool {
    for record in records {
        if let Err(failure) = store.append(record).await {
            error!("store: {}", Display2Format(&failure));
            return false;
        }
    }
    true
}

/// The contacts are dead: the store may erase.
async fn make_room<F: NorFlash<Error: Debug>>(store: &mut Store<F>) {
    if let Err(failure) = store.make_room().await {
        error!("store: {}", Display2Format(&failure));
    }
}

fn restart() -> ! {
    info!("restarts as the pile it has become");
    SCB::sys_reset()
}
