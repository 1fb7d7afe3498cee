//! What a run of the demo comes to.

use std::fmt;

use serde::Serialize;

/// The sums of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Charges that were given in full.
    pub charges_completed: u64,
    /// From a robot's first asking until a pile accepted its lease: the mean, in seconds.
    pub mean_wait_s: f64,
    /// The longest of these, in seconds.
    pub worst_wait_s: f64,
    /// Robots without energy at the end.
    pub stranded: usize,
    /// Violations that the auditor found.
    pub double_grants: usize,
    /// What answering a request took to plan and choose.
    pub planning_us: Planning,
}

/// Real time in microseconds, at most which half and 99 of 100 decisions took; 0 without any.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Planning {
    /// The median.
    pub p50: u32,
    /// The 99th percentile.
    pub p99: u32,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { mean_wait_s, worst_wait_s, planning_us: Planning { p50, p99 }, .. } = self;
        writeln!(f, "charges completed  {}", self.charges_completed)?;
        writeln!(f, "wait for a pile    {mean_wait_s:.1} s mean, {worst_wait_s:.1} s worst")?;
        writeln!(f, "stranded robots    {}", self.stranded)?;
        writeln!(f, "double grants      {}", self.double_grants)?;
        write!(f, "planning           {p50} us median, {p99} us 99th percentile")
    }
}
