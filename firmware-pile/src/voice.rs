//! What a pile says of itself to the coordinator, and when: who it is, and its state.

use firmware_common::greeting::{Greeting, is_due};
use protocol::{Epoch, Hello, Millis, PileState, SiteMillis, limits};

/// A change of the charge state by this share is a change worth telling at once.
const REMAINING_STEP: f32 = 0.01;

/// What was said last, and when.
#[derive(Clone, Debug)]
pub struct Voice {
    state: PileState,
    state_at: Option<Millis>,
    greeting: Greeting,
    /// When a tool was answered last.
    tool_answered_at: Option<Millis>,
}

/// A state to tell.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    /// The state.
    pub state: PileState,
    /// Whether it has changed, rather than that it is time to tell it again.
    pub changed: bool,
}

impl Voice {
    /// A pile that has said nothing yet and begins in `state`.
    #[must_use]
    pub const fn new(state: PileState) -> Self {
        Self { state, state_at: None, greeting: Greeting::new(), tool_answered_at: None }
    }

    /// The state that was told last.
    #[must_use]
    pub const fn told(&self) -> &PileState {
        &self.state
    }

    /// The coordinator's Hello arrived. Whether ours is to be said now; the state is due too, because
    /// what was said before may not have been believed.
    pub fn greeted(&mut self, now: Millis) -> bool {
        self.state_at = None;
        self.greeting.greeted(now)
    }

    /// A frame that says it is of the coordinator does not authenticate. Whether Hello is to be said.
    #[must_use]
    pub fn distrusted(&self, now: Millis) -> bool {
        self.greeting.distrusted(now)
    }

    /// Whether Hello has to be said because the coordinator has not answered it yet.
    #[must_use]
    pub fn hello_is_due(&self, now: Millis) -> bool {
        self.greeting.is_due(now)
    }

    /// Says Hello.
    pub fn hello(&mut self, now: Millis, epoch: Epoch) -> Hello {
        self.greeting.hello(now, epoch)
    }

    /// The service tool has said Hello, or something that it would not have said if it knew of our start.
    /// It is answered by Hello, but not while the last is fresh; it asks again.
    pub fn answer_tool(&mut self, now: Millis, epoch: Epoch) -> Option<Hello> {
        let due = is_due(now, self.tool_answered_at, limits::REPEAT_INTERVAL);
        due.then(|| {
            self.tool_answered_at = Some(now);
            Hello::new(epoch)
        })
    }

    /// The state to tell now, if it has changed or was told [`limits::STATE_INTERVAL`] ago (LMPP
    /// Fig. 1). What is told has a new version and a new stamp, so that others see how fresh it is.
    pub fn tell(&mut self, now: Millis, site_now: Option<SiteMillis>, mut state: PileState) -> Option<Told> {
        let changed = differ(&state, &self.state);
        if !changed && !is_due(now, self.state_at, limits::STATE_INTERVAL) {
            return None;
        }
        state.row.version = self.state.row.version.saturating_add(1);
        state.row.stamp = site_now;
        self.state = state;
        self.state_at = Some(now);
        Some(Told { state, changed })
    }
}

fn differ(a: &PileState, b: &PileState) -> bool {
    let discrete = |state: &PileState| {
        (
            state.row.availability,
            state.row.planned,
            state.holder,
            state.energised,
            state.ended,
            state.standing,
        )
    };
    discrete(a) != discrete(b) || (a.row.remaining.get() - b.row.remaining.get()).abs() >= REMAINING_STEP
}
