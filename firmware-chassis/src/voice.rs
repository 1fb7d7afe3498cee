//! What the chassis says of itself, and when: who it is, and its state.

use protocol::{ChassisState, DurationMs, Epoch, Hello, Millis, limits, version};

/// What was said last, and when.
#[derive(Clone, Debug, Default)]
pub struct Voice {
    state: Option<(Millis, ChassisState)>,
    hello_at: Option<Millis>,
    greeted: bool,
}

impl Voice {
    /// A chassis that has said nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { state: None, hello_at: None, greeted: false }
    }

    /// The computer's Hello arrived. It answers ours, or is the first of its start and wants ours:
    /// that is to be said now if this is true. Ours is held back while the last is fresh, so that
    /// two answers never chase each other.
    pub fn greeted(&mut self, now: Millis) -> bool {
        let wanted = self.greeted && is_due(now, self.hello_at, limits::REPEAT_INTERVAL);
        // Before our own Hello there was nothing to answer.
        self.greeted = self.hello_at.is_some();
        wanted
    }

    /// Whether Hello has to be said because the computer has not answered it yet.
    #[must_use]
    pub fn hello_is_due(&self, now: Millis) -> bool {
        !self.greeted && is_due(now, self.hello_at, limits::REPEAT_INTERVAL)
    }

    /// Says Hello.
    pub fn hello(&mut self, now: Millis) -> Hello {
        self.hello_at = Some(now);
        Hello { min: version::MIN, current: version::CURRENT, software: SOFTWARE, epoch: Epoch(0) }
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

const SOFTWARE: [u8; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

const fn number(text: &str) -> u8 {
    match u8::from_str_radix(text, 10) {
        Ok(number) => number,
        Err(_) => u8::MAX,
    }
}

fn is_due(now: Millis, last: Option<Millis>, interval: DurationMs) -> bool {
    last.is_none_or(|last| now.since(last) >= interval)
}
