//! A pile at a desk: on the line to this computer, without a coordinator. Ask it what it does,
//! measures and has counted, and clear its faults.
//!
//! | module | one idea |
//! |---|---|
//! | [`session`] | what to ask a pile, and when: pure |
//! | [`answers`] | what it has answered |
//! | [`error`](mod@error) | why it has not |
//! | [`run`] | the shell around a session: line, clock, signal |
//! | [`words`] | what a pile says, for a person |

pub mod answers;
pub mod error;
pub mod run;
pub mod session;
pub mod words;
