//! What the chassis says of itself, and when: who it is, and its state.

use firmware_common::greeting::{Greeting, is_due};
use protocol::{ChassisState, Epoch, Hello, Millis, limits};

/// What was said last, and when.
#[derive(Clone, Debug, Default)]
pub struct Voice {
    state: Option<(Millis, ChassisState)>,
    greeting: Greeting,
}

impl Voice {
    /// A chassis that has said nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { state: None, greeting: Greeting::new() }
    }

    /// The computer's Hello arrived. Whether ours is to be said now.
    pub fn greeted(&mut self, now: Millis) -> bool {
        self.greeting.greeted(now)
    }

    /// Whether Hello has to be said because the computer has not answered it yet.
    #[must_use]
    pub fn hello_is_due(&self, now: Millis) -> bool {
        self.greeting.is_due(now)
    }

    /// Says Hello. A chassis knows no coordinator, and no epoch.
    pub fn hello(&mut self, now: Millis) -> Hello {
        self.greeting.hello(now, Epoch(0))
    }

    /// The state to tell now, if its mode, stop or faults have changed or it was told
    /// [`limits::STATE_INTERVAL`] ago.
    pub fn tell(&mut self, now: Millis, state: ChassisState) -> Option<ChassisState> {
        let told = self.state.as_ref().is_some_and(|(at, told)| {
            (told.mode, told.stop, &told.faults) == (state.mode, state.stop, &state.faults)
                && !is_due(now, Some(*at), limits::STATE_INTERVAL)
        });
        if told {
            return None;
        }
        self.state = Some((now, state.clone()));
        Some(state)
    }
}
