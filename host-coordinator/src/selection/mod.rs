//! Which charging pile each robot should use, and why (LMPP section III, Access 2).
//!
//! Pure functions: what is known of the robot and of every pile goes in, a [`Choice`] with an
//! [`Explanation`] for every pile comes out.
//!
//! | module | one idea |
//! |---|---|
//! | [`reach`] | how far a robot gets and when it must ask (eqs. 3, 6) |
//! | [`margin`] | when a charge has to begin at the latest (Access eq. 3) |
//! | [`activity`] | where a robot is wanted after its charge (eqs. 5, 8) |
//! | [`priority`] | who comes first (Access eqs. 4, 5) |
//! | [`situation`] | what is known of all robots that wait and of every pile |
//! | [`policy`] | the policies there are, behind one trait |
//! | [`multistage`] | LMPP's choice for one robot (eqs. 7, 9), in two readings |
//! | [`nearest`] | the nearest free pile, one robot after the other |
//! | [`joint`] | all robots together, by the time that it takes them |
//! | `preempt` | a charge is cut short for a critical robot (Access 2.3) |
//! | [`alone`] | a robot's own choice while no coordinator is heard |
//! | [`explain`] | what is told about every pile |

pub mod activity;
pub mod alone;
pub mod explain;
pub mod joint;
pub mod margin;
pub mod multistage;
pub mod nearest;
pub mod policy;
mod preempt;
pub mod priority;
pub mod reach;
pub mod situation;

pub use alone::{Known, choose_alone};
pub use explain::{Choice, Explanation, PileStage, Stage, Verdict};
pub use multistage::{Candidate, Rule, choose};
pub use policy::{ChargingPolicy, PolicyName};
pub use situation::{Asker, Holder, Offer, Situation, Times};
