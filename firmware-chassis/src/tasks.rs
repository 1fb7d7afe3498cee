//! The task that runs the chassis' core, generic over a board's drivers; the tasks around it are
//! those of [`firmware_common::tasks`].
//!
//! [`control`] alone owns the core and has an interrupt executor to itself: nothing that the other
//! tasks do delays a control tick. It waits for no other task: what does not fit the outbox is
//! dropped, as a message lost on the link would be, and comes again.

use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use firmware_common::reader::Seen;
use firmware_common::supervisor::Place;
use firmware_common::tasks::{Inbox, News, Outbox};
use protocol::{DeviceId, Millis, Recipient, RobotId};

use crate::{Chassis, Input, Messages, Motors, Sensors, TICK};

/// Messages that wait for the link: those of a few ticks.
pub const OUTBOX: usize = 4 * crate::chassis::MESSAGES_PER_STEP;

/// The robot an image is built for: 1, unless `CHARGEHAND_ROBOT_ID` was set to another number.
pub const ROBOT: RobotId = RobotId(match option_env!("CHARGEHAND_ROBOT_ID") {
    None => 1,
    Some(text) => match u16::from_str_radix(text, 10) {
        Ok(id) => id,
        Err(_) => panic!("CHARGEHAND_ROBOT_ID must be a number from 0 to 65535"),
    },
});

/// Whom the chassis speaks to.
const COMPUTER: Recipient = Recipient::Device(DeviceId::Robot(ROBOT));

/// Motors, encoders, gyroscope and battery meter of a board. Neither call may wait for long: a tick
/// has 10 ms.
pub trait Body {
    /// What the sensors say `now`; called once a tick.
    fn sense(&mut self, now: Millis) -> Sensors;

    /// What the motors do from now on.
    fn drive(&mut self, motors: Motors);
}

/// Runs the core: the motors first, then the messages. A frame is taken when it arrives, so that an
/// emergency stop does not wait for a tick.
pub async fn control(
    mut chassis: Chassis,
    mut body: impl Body,
    inbox: &Inbox,
    outbox: &Outbox<OUTBOX>,
    place: Place,
) -> ! {
    let mut tick_at = Instant::now();
    let mut messages = Messages::new();
    loop {
        let event = select(Timer::at(tick_at), inbox.receive()).await;
        let woken_at = Instant::now();
        let now = Millis(woken_at.as_millis());
        let input = match &event {
            Either::First(()) => {
                place.check_in();
                tick_at = next_tick(tick_at, woken_at);
                Input::Tick(body.sense(now))
            }
            Either::Second(News::Frame(frame)) => Input::Frame(frame),
            Either::Second(News::Discarded(error)) => Input::Discarded(*error),
            Either::Second(News::Seen(Seen::Tag(read))) => Input::Tag(*read),
            Either::Second(News::Seen(Seen::Nothing)) => continue,
        };
        body.drive(chassis.step(now, input, &mut messages));
        for message in messages.drain(..) {
            // A link too slow for it: odometry and state come again.
            let _ = outbox.try_send((COMPUTER, message));
        }
    }
}

/// When to tick after the one that was due at `due` and came at `now`. Ticks that were missed are
/// not made up for: the core takes a late one for as many as have passed.
fn next_tick(due: Instant, now: Instant) -> Instant {
    let tick = Duration::from_millis(TICK.0.into());
    let missed = now.saturating_duration_since(due).as_ticks() / tick.as_ticks();
    due + Duration::from_ticks(tick.as_ticks() * (missed + 1))
}
