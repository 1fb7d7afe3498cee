//! How much was tried, over all inputs of a run.

use std::ops::AddAssign;
use std::sync::{Mutex, Once, PoisonError};

/// A number of things (frames, replies, records), and how many of them were good.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tried {
    /// All.
    pub tried: u64,
    /// Those that were taken for what they say.
    pub accepted: u64,
}

impl Tried {
    /// One more.
    pub fn add(&mut self, accepted: bool) {
        *self += Self { tried: 1, accepted: u64::from(accepted) };
    }
}

impl AddAssign for Tried {
    fn add_assign(&mut self, more: Self) {
        self.tried += more.tried;
        self.accepted += more.accepted;
    }
}

static ALL: Mutex<Tried> = Mutex::new(Tried { tried: 0, accepted: 0 });
static AT_EXIT: Once = Once::new();

unsafe extern "C" {
    safe fn atexit(function: extern "C" fn()) -> i32;
}

/// Counts what an input was; the sums are printed when the process ends, which libFuzzer alone
/// decides.
pub fn count(more: Tried) {
    AT_EXIT.call_once(|| {
        atexit(print);
    });
    *ALL.lock().unwrap_or_else(PoisonError::into_inner) += more;
}

extern "C" fn print() {
    let all = *ALL.lock().unwrap_or_else(PoisonError::into_inner);
    eprintln!("stat::tried: {}\nstat::accepted: {}", all.tried, all.accepted);
}
