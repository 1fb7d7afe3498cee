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

use protocol::{DeviceId, Message, SiteMillis};

use super::{planning_times::PlanningTimes, warnings::Warnings};
use crate::{
    core::{Coordinator, Effect, Event, Fact, Input, View},
    store::{Store, StoreError},
};

/// The core and its log.
#[derive(Debug)]
pub struct Engine {
    coordinator: Coordinator,
    store: Store,
    unrecorded: Vec<Event>,
    withheld: Vec<Effect>,
    degraded: Option<String>,
    warnings: Warnings,
    planning: Arc<Mutex<PlanningTimes>>,
}

impl Engine {
    /// An engine for a coordinator that was recovered from the store's events.
    #[must_use]
    pub fn new(
        coordinator: Coordinator,
        store: Store,
        warnings: Warnings,
        planning: Arc<Mutex<PlanningTimes>>,
    ) -> Self {
        let (unrecorded, withheld) = (Vec::new(), Vec::new());
        Self { coordinator, store, unrecorded, withheld, degraded: None, warnings, planning }
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

    /// The picture of the site. What is not recorded yet is not shown as if it were: the caller
    /// shows no view between a step and its record, except to say that the log cannot be written.
    #[must_use]
    pub fn view(&self, now: SiteMillis) -> View {
        View { degraded: self.degraded.clone(), warnings: self.warnings.list(), ..self.coordinator.view(now) }
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
