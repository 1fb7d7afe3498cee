//! Which charging pile a robot should use, and why (LMPP section III).
//!
//! Pure functions: what is known of the robot and of every pile goes in, a [`Choice`] with an
//! [`Explanation`] for every pile comes out.
//!
//! | module | one idea |
//! |---|---|
//! | [`reach`] | how far a robot gets and when it must ask (eqs. 3, 6) |
//! | [`activity`] | where a robot is wanted after its charge (eqs. 5, 8) |
//! | [`multistage`] | the choice itself (eqs. 7, 9), in two readings |
//! | [`explain`] | what is told about every pile |

pub mod activity;
pub mod explain;
pub mod multistage;
pub mod reach;

pub use explain::{Choice, Explanation, PileStage, Stage, Verdict};
pub use multistage::{Candidate, Rule, choose};
