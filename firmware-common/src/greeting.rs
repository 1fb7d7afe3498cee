//! The rule of Hello: a device says who it is until its peer answers, and answers a peer that has
//! started anew.

use protocol::{DurationMs, Epoch, Hello, Millis, limits};

/// Whether `interval` has passed since `last`, or it never happened.
#[must_use]
pub fn is_due(now: Millis, last: Option<Millis>, interval: DurationMs) -> bool {
    last.is_none_or(|last| now.since(last) >= interval)
}

/// When Hello was said last, and whether it was answered.
#[derive(Clone, Debug, Default)]
pub struct Greeting {
    said_at: Option<Millis>,
    answered: bool,
}

impl Greeting {
    /// Nothing was said yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { said_at: None, answered: false }
    }

    /// The peer's Hello arrived. It answers ours, or is the first of its start and wants ours: that
    /// is to be said now if this is true. Ours is held back while the last is fresh, so that two
    /// answers never chase each other.
    pub fn greeted(&mut self, now: Millis) -> bool {
        let wanted = self.answered && is_due(now, self.said_at, limits::REPEAT_INTERVAL);
        // Before our own Hello there was nothing to answer.
        self.answered = self.said_at.is_some();
        wanted
    }

    /// A frame that says it is of the peer does not authenticate: it may not know of our start, and
    /// Hello is to be said now if this is true.
    #[must_use]
    pub fn distrusted(&self, now: Millis) -> bool {
        is_due(now, self.said_at, limits::REPEAT_INTERVAL)
    }

    /// Whether Hello has to be said because the peer has not answered it yet.
    #[must_use]
    pub fn is_due(&self, now: Millis) -> bool {
        !self.answered && is_due(now, self.said_at, limits::REPEAT_INTERVAL)
    }

    /// Says Hello. `epoch` is the highest that this device has seen of a coordinator.
    pub fn hello(&mut self, now: Millis, epoch: Epoch) -> Hello {
        self.said_at = Some(now);
        Hello::new(epoch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPEAT: u64 = limits::REPEAT_INTERVAL.0 as u64;

    /// When Hello is said in the ten intervals after `from`, looked at every millisecond.
    fn said(greeting: &mut Greeting, from: u64) -> Vec<u64> {
        let times = (from..from + 10 * REPEAT).filter(|&ms| {
            let due = greeting.is_due(Millis(ms));
            if due {
                greeting.hello(Millis(ms), Epoch(0));
            }
            due
        });
        times.collect()
    }

    #[test]
    fn hello_is_repeated_until_it_is_answered_and_then_no_more() {
        let mut greeting = Greeting::new();
        let expected: Vec<_> = (0..10).map(|count| count * REPEAT).collect();
        assert_eq!(said(&mut greeting, 0), expected);
        assert!(!greeting.greeted(Millis(10 * REPEAT)));
        assert_eq!(said(&mut greeting, 10 * REPEAT), []);
    }

    #[test]
    fn a_peer_that_starts_anew_is_answered_but_not_while_our_last_hello_is_fresh() {
        let mut greeting = Greeting::new();
        greeting.hello(Millis(0), Epoch(0));
        assert!(!greeting.greeted(Millis(1)), "it is the answer to ours");
        assert!(!greeting.greeted(Millis(REPEAT - 1)));
        assert!(greeting.greeted(Millis(REPEAT)));
        greeting.hello(Millis(REPEAT), Epoch(0));
        assert!(!greeting.greeted(Millis(REPEAT + 1)), "two answers would chase each other");
    }

    #[test]
    fn a_peer_that_is_distrusted_is_told_of_our_start_but_not_faster_than_it_may_answer() {
        let mut greeting = Greeting::new();
        greeting.hello(Millis(0), Epoch(0));
        greeting.greeted(Millis(1));
        assert!(!greeting.distrusted(Millis(REPEAT - 1)));
        assert!(greeting.distrusted(Millis(REPEAT)));
        greeting.hello(Millis(REPEAT), Epoch(0));
        assert!(!greeting.distrusted(Millis(REPEAT + 1)));
    }

    #[test]
    fn a_peer_that_greets_first_is_greeted_all_the_same() {
        let mut greeting = Greeting::new();
        assert!(!greeting.greeted(Millis(0)));
        assert_eq!(said(&mut greeting, 5)[..2], [5, 5 + REPEAT]);
    }
}
