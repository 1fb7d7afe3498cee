//! The coordinator's core: pure, deterministic, event-sourced.
//!
//! [`Coordinator::step`] takes an input at an instant and answers with [`Event`]s and [`Effect`]s.
//! The shell ([`daemon`](crate::daemon)) appends the events to the log before it performs the
//! effects, so whatever the world has seen of the coordinator is recorded. After a crash
//! [`Coordinator::recover`] folds the log, the first input [`Input::Started`] raises the epoch, and
//! the leases that were alive go on under the same numbers.
//!
//! | module | one idea |
//! |---|---|
//! | [`event`] | what the log records |
//! | [`decision`] | a choice of a pile, kept so that a person can ask why |
//! | [`state`] | what is known for sure: the fold of the log |
//! | [`profile`] | what a robot's tasks take from its battery |
//! | [`observed`] | what was heard since the start |
//! | [`coordinator`] | the step: who is heard and what it means |
//! | `power` | all piles together are given no more than the facility has |
//! | `turn` | a step in the making, and whom it concerns |
//! | `grants` | leases: granted, extended, taken back, ended |
//! | [`contradictions`] | what piles and robots say that cannot both be right, and who is silent |
//! | `queue` | robots that ask: who waits, who is given which pile, what they are told |
//! | `calls` | robots that are called to charge without having asked |
//! | [`orders`] | what a person orders over the API |
//! | `situation` | what is known of all robots that wait, as the policies take it |
//! | [`consumption`] | what a robot is seen to take for a metre |
//! | [`rescue`] | help for robots that can't come to a pile |
//! | [`routes`] | ways and their lengths (LMPP Algorithm 6) |
//! | [`replay`] | the log followed again: what was known when, and decisions taken anew |
//! | [`view`] | what a person sees; its map is drawn in `site_view` |

mod calls;
pub mod consumption;
pub mod contradictions;
pub mod coordinator;
pub mod decision;
pub mod event;
mod grants;
pub mod observed;
pub mod orders;
mod power;
pub mod profile;
mod queue;
pub mod replay;
pub mod rescue;
pub mod routes;
mod site_view;
mod situation;
pub mod state;
mod turn;
pub mod view;

pub use coordinator::{Coordinator, Effect, Input, Step};
pub use decision::Decision;
pub use event::{Event, Fact};
pub use grants::CLOCK_MARGIN;
pub use state::State;
pub use view::View;

use firmware_pile::Parameters;
use protocol::{DurationMs, PileId};

/// What all piles have in common: the periods of the day by which they count passes (LMPP eq. 8),
/// and the adjustment of their planned times (eq. 2).
const PILE: Parameters = Parameters::new(PileId(0), 0.0);

/// A robot that still works this long after a pile was granted to it will not come.
pub const ROBOT_PATIENCE: DurationMs = DurationMs(30_000);
