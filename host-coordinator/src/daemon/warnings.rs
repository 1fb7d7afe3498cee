//! Trouble an operator should know of: logged, and kept for the dashboard.
//!
//! The same trouble is told once a minute, and no more than a few kinds of it are told in that
//! time, so that neither a broken device nor a hostile one can flood the log.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

/// How long the same warning is not repeated.
const QUIET: Duration = Duration::from_secs(60);
/// How many warnings are kept, and how many are told in [`QUIET`].
const KEPT: usize = 20;

/// The newest warnings. Clones share them.
#[derive(Clone, Debug, Default)]
pub struct Warnings(Arc<Mutex<VecDeque<(Instant, String)>>>);

impl Warnings {
    /// Logs and keeps a warning, unless it or too much else was told a moment ago.
    pub fn note(&self, text: String) {
        self.note_at(Instant::now(), text);
    }

    fn note_at(&self, now: Instant, text: String) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let fresh = |at: Instant| now.saturating_duration_since(at) < QUIET;
        if let Some(known) = kept.iter().position(|(_, known)| *known == text) {
            if kept.get(known).is_some_and(|(at, _)| fresh(*at)) {
                return;
            }
            kept.remove(known);
        } else if kept.len() >= KEPT {
            if kept.back().is_some_and(|(at, _)| fresh(*at)) {
                return;
            }
            kept.pop_back();
        }
        tracing::warn!("{text}");
        kept.push_front((now, text));
    }

    /// The warnings, newest first.
    #[must_use]
    pub fn list(&self) -> Vec<String> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().map(|(_, text)| text.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_repeated_warning_moves_to_the_front_after_a_minute() {
        let (warnings, start) = (Warnings::default(), Instant::now());
        for text in ["a", "b", "a"] {
            warnings.note_at(start, text.to_owned());
        }
        assert_eq!(warnings.list(), ["b", "a"]);
        warnings.note_at(start + QUIET, "a".to_owned());
        assert_eq!(warnings.list(), ["a", "b"]);
    }

    #[test]
    fn a_flood_of_warnings_is_held_back() {
        let (warnings, start) = (Warnings::default(), Instant::now());
        for number in 0..1000 {
            warnings.note_at(start, number.to_string());
        }
        let list = warnings.list();
        assert_eq!((list.len(), list[0].as_str()), (KEPT, "19"));
        warnings.note_at(start + QUIET, "later".to_owned());
        assert_eq!(warnings.list()[0], "later");
    }
}
