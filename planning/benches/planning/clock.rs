//! Clocks: the wall's for what is short, the thread's own for what is long.
//!
//! Reading the thread's takes about a microsecond, but it stands still while other programs run.

use std::time::Instant;

use rustix::time::{ClockId, clock_gettime};

/// Which.
#[derive(Clone, Copy, Debug)]
pub enum Clock {
    Wall,
    Thread,
}

impl Clock {
    /// What `work` takes, in microseconds, and what it gives.
    pub fn time<T>(self, work: impl FnOnce() -> T) -> (f64, T) {
        match self {
            Self::Wall => {
                let start = Instant::now();
                let done = work();
                (start.elapsed().as_secs_f64() * 1e6, done)
            }
            Self::Thread => {
                let start = thread_micros();
                let done = work();
                (thread_micros() - start, done)
            }
        }
    }
}

fn thread_micros() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 * 1e6 + now.tv_nsec as f64 / 1e3
}
