//! The order of things: inputs are taken, steps are made, events are recorded, and only then are
//! effects performed.
//!
//! If the log cannot be written (a full disk), the engine says so, takes no new input and performs
//! nothing that depends on the missing record until the log can be written again. Nothing
//! unrecorded happens, and nothing that was decided is lost.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::Instant,
};

use protocol::{DeviceId, Message, RequestId, RobotId, SiteMillis};
use serde::Serialize;

use super::{planning_times::PlanningTimes, warnings::Warnings};
use crate::{
    core::{
        Coordinator, Decision, Effect, Event, Fact, Input, View,
        orders::{Order, Refusal},
    },
    store::{Store, StoreError},
};

/// What has become of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Ordered {
    /// For which robot.
    pub robot: RobotId,
    /// Under which request.
    pub request: RequestId,
    /// The decision that was made at once, if it is about that.
    pub decision: Option<u64>,
}

/// The core and its log.
#[derive(Debug)]
pub struct Engine {
    coordinator: Coordinator,
    store: Store,
    unrecorded: Vec<Event>,
    withheld: Vec<Effect>,
    insecure: bool,
    degraded: Option<String>,
    warnings: Warnings,
    planning: Arc<Mutex<PlanningTimes>>,
}

impl Engine {
    /// An engine for a coordinator that was recovered from the store's events. `insecure` says that it
    /// has no keys.
    #[must_use]
    pub fn new(
        coordinator: Coordinator,
        store: Store,
        warnings: Warnings,
        planning: Arc<Mutex<PlanningTimes>>,
        insecure: bool,
    ) -> Self {
        let (unrecorded, withheld) = (Vec::new(), Vec::new());
        Self { coordinator, store, unrecorded, withheld, insecure, degraded: None, warnings, planning }
    }

    /// The core.
    #[must_use]
    pub const fn coordinator(&self) -> &Coordinator {
        &self.coordinator
    }

    /// Makes a step. Effects are performed at once where no event has to be recorded first.
    pub fn take(&mut self, now: SiteMillis, input: Input, send: &mut dyn FnMut(DeviceId, Message)) {
        let begun = Instant::now();
        let step = self.coordinator.step(now, input);
        if step.events.iter().any(|event| matches!(event.fact, Fact::Decided(_))) {
            let mut planning = self.planning.lock().unwrap_or_else(PoisonError::into_inner);
            planning.add(begun.elapsed());
        }
        self.unrecorded.extend(step.events);
        if self.unrecorded.is_empty() {
            perform(&self.warnings, step.effects, send);
        } else {
            self.withheld.extend(step.effects);
        }
    }

    /// Does an order that came over the API, and answers under which request.
    ///
    /// # Errors
    /// [`Refusal`] if it can't be done.
    pub fn order(
        &mut self,
        now: SiteMillis,
        order: Order,
        send: &mut dyn FnMut(DeviceId, Message),
    ) -> Result<Ordered, Refusal> {
        let robot = self.coordinator.check(&order)?;
        let asked = |coordinator: &Coordinator| Some(coordinator.state().requests.get(&robot)?.id);
        let before = asked(&self.coordinator);
        self.take(now, Input::Order(order), send);
        let request = before.or_else(|| asked(&self.coordinator)).unwrap_or_default();
        let decisions = &self.coordinator.state().decisions;
        let decision =
            decisions.iter().find(|decision| (decision.robot, decision.request) == (robot, request));
        Ok(Ordered { robot, request, decision: decision.map(|decision| decision.id) })
    }

    /// Records the events since the last call in one transaction, then performs what waits for
    /// them. To be called again after an error, and no step to be made until it succeeds.
    ///
    /// # Errors
    /// Why the log cannot be written.
    pub fn commit(&mut self, send: &mut dyn FnMut(DeviceId, Message)) -> Result<(), StoreError> {
        if self.unrecorded.is_empty() {
            return Ok(());
        }
        if let Err(error) = self.store.append(&self.unrecorded) {
            if self.degraded.is_none() {
                tracing::error!("{error}; nothing is decided until it can be written again");
            }
            self.degraded = Some(error.to_string());
            return Err(error);
        }
        if self.degraded.take().is_some() {
            tracing::info!("the event log {} can be written again", self.store.file().display());
        }
        self.unrecorded.drain(..).for_each(|event| log(&event));
        perform(&self.warnings, self.withheld.drain(..), send);
        Ok(())
    }

    /// A decision that was ever made, by its number; `None` if there was none with it.
    ///
    /// # Errors
    /// Why the log cannot be read.
    pub fn decision(&self, id: u64) -> Result<Option<Decision>, StoreError> {
        self.store.decision(id)
    }

    /// The picture of the site. What is not recorded yet is not shown as if it were: the caller
    /// shows no view between a step and its record, except to say that the log cannot be written.
    #[must_use]
    pub fn view(&self, now: SiteMillis) -> View {
        let Self { insecure, .. } = *self;
        let (degraded, warnings) = (self.degraded.clone(), self.warnings.list());
        View { insecure, degraded, warnings, ..self.coordinator.view(now) }
    }
}

fn perform(
    warnings: &Warnings,
    effects: impl IntoIterator<Item = Effect>,
    send: &mut dyn FnMut(DeviceId, Message),
) {
    for effect in effects {
        match effect {
            Effect::Send { to, message } => send(to, message),
            Effect::Warn(text) => warnings.note(text),
        }
    }
}

/// One line for what an operator may look for in the log.
fn log(event: &Event) {
    match &event.fact {
        Fact::EpochStarted { epoch, .. } => tracing::info!("epoch {epoch} begins"),
        Fact::Granted { pile, lease, .. } => {
            tracing::info!("lease {}: pile {pile} is offered to robot {}", lease.lease, lease.robot);
        }
        Fact::Accepted { pile, lease } => tracing::debug!("lease {lease}: pile {pile} accepts"),
        Fact::Refused { pile, lease, reason } => {
            tracing::info!("lease {lease}: pile {pile} refuses: {reason:?}");
        }
        Fact::Revoked { pile, lease, why, .. } => {
            tracing::info!("lease {}: pile {pile} is to end it: {why:?}", lease.lease);
        }
        Fact::Ended { pile, lease, robot, why, charged } => tracing::info!(
            "lease {lease}: over at pile {pile} for robot {robot}: {why:?}, charged {:.0} s",
            charged.as_seconds()
        ),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use protocol::{BootEpoch, ChargeRequest, EnergyJ, Frame, Header, PileId, Sequence, TagId, TaskPriority};

    use super::*;
    use crate::{
        config::{Policy, RobotConfig},
        site::Site,
    };

    const ROBOT: RobotId = RobotId(1);

    fn asks(request: u32) -> Input {
        let site = Site::fig7().unwrap();
        let position = site.position(site.piles[0].cell);
        let energy = EnergyJ::new(5_000.0).unwrap();
        let header = Header::new(DeviceId::Robot(ROBOT), BootEpoch(1), Sequence(request));
        let asked = ChargeRequest {
            request: RequestId(request),
            position,
            energy,
            task: None,
            priority: TaskPriority::USUAL,
        };
        Input::Frame(Frame { header, message: Message::ChargeRequest(asked) })
    }

    fn recovered(file: &std::path::Path) -> Engine {
        let (store, events) = Store::open(file).unwrap();
        let full = EnergyJ::new(10_000.0).unwrap();
        let robot = RobotConfig {
            id: ROBOT,
            tag: TagId([1; 12]),
            full,
            energy_per_metre_j: 10.0,
            speed_mps: 0.5,
            gives_w: None,
        };
        let site = Arc::new(Site::fig7().unwrap());
        let coordinator =
            Coordinator::recover(Arc::clone(&site), site.lmpp(1.0), Policy::default(), &[robot], &events);
        Engine::new(coordinator, store, Warnings::default(), Arc::default(), false)
    }

    #[test]
    fn nothing_happens_that_is_not_recorded_and_nothing_recorded_is_lost_on_a_full_disk() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("events.sqlite");
        let mut engine = recovered(&file);
        let mut ignored = |_, _| {};
        engine.take(SiteMillis(1), Input::Started { boot_floor: BootEpoch(0) }, &mut ignored);
        engine.commit(&mut ignored).unwrap();
        engine.store.limit_pages(1);

        let mut sent = Vec::new();
        let mut now = 1;
        let error = loop {
            now += 1;
            engine.take(SiteMillis(now), asks(now as u32), &mut |to, _| sent.push(to));
            let before = sent.len();
            match engine.commit(&mut |to, _| sent.push(to)) {
                Ok(()) => assert!(sent.len() > before, "a recorded request is answered"),
                Err(error) => {
                    assert_eq!(sent.len(), before, "an unrecorded request must not be answered");
                    break error;
                }
            }
        };
        assert!(matches!(error, StoreError::Full { .. }), "{error}");
        let told = engine.view(SiteMillis(now)).degraded.unwrap();
        assert!(told.contains("events.sqlite") && told.contains("free space"), "{told}");
        assert!(engine.commit(&mut |to, _| sent.push(to)).is_err(), "the disk is still full");

        engine.store.limit_pages(1_000_000);
        let before = sent.len();
        engine.commit(&mut |to, _| sent.push(to)).unwrap();
        assert!(sent.len() > before, "the withheld answer goes out");
        assert_eq!(engine.view(SiteMillis(now)).degraded, None);
        let state = engine.coordinator().state().clone();
        assert_eq!(state.totals.requests, now - 1);
        drop(engine);
        assert_eq!(*recovered(&file).coordinator().state(), state);
    }

    #[test]
    fn an_answer_that_depends_on_no_record_does_not_wait_for_one() {
        let folder = tempfile::tempdir().unwrap();
        let mut engine = recovered(&folder.path().join("events.sqlite"));
        let mut sent = Vec::new();
        engine.take(SiteMillis(1), Input::Started { boot_floor: BootEpoch(0) }, &mut |_, _| {});
        engine.commit(&mut |_, _| {}).unwrap();
        let header = Header::new(DeviceId::Pile(PileId(1)), BootEpoch(1), Sequence(0));
        let asked = protocol::TimeRequest { asked_at: protocol::Millis(7) };
        let frame = Frame { header, message: Message::TimeRequest(asked) };
        engine.take(SiteMillis(2), Input::Frame(frame), &mut |_, message| sent.push(message));
        assert!(sent.iter().any(|message| matches!(message, Message::TimeSync(_))), "{sent:?}");
    }
}
