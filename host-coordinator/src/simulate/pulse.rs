//! How far the coordinator is behind the simulated time.
//!
//! At 200 times the real time a hiccup of 50 ms, which any computer has, would be ten seconds in
//! which nobody is heard. So simulated time waits for the coordinator: a robot asks it for the
//! time again and again, and time stands still while an answer is overdue. The question goes the
//! way of every frame, through sockets, core and event log, so the answer tells of all of them.

use protocol::{DurationMs, Millis};

/// How often the robot asks.
const INTERVAL: DurationMs = DurationMs(500);
/// Simulated time waits for an answer that is older: less than the two seconds after which a
/// pile does not trust an answer to its own question.
const LAG: DurationMs = DurationMs(1_500);

/// The questions and answers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pulse {
    asked: Millis,
    answered: Millis,
}

impl Pulse {
    /// Whether to ask now.
    pub fn asks(&mut self, now: Millis) -> bool {
        let due = now.since(self.asked) >= INTERVAL;
        if due {
            self.asked = now;
        }
        due
    }

    /// Takes the question that was answered last.
    pub fn answered(&mut self, question: Millis) {
        self.answered = self.answered.max(question);
    }

    /// Whether time has to wait for the coordinator.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.asked.since(self.answered) >= LAG
    }
}
