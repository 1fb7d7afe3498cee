//! A robot's chassis on the line to this computer, which stands in for the robot's own: drive it,
//! watch it, record it and plot what was recorded.
//!
//! | module | one idea |
//! |---|---|
//! | [`session`] | what to say to a chassis, and when: pure |
//! | [`outcome`] | how a session ends: its report, or why it failed |
//! | [`run`] | the shell around a session: line, clock, signal |
//! | [`words`] | what a chassis says, for a person |
//! | [`recording`] | MCAP files, written and read |
//! | [`ros`] | the ROS 2 messages in them |
//! | [`plot`] | a recording as a picture |

pub mod outcome;
pub mod plot;
pub mod recording;
pub mod ros;
pub mod run;
pub mod session;
pub mod words;

/// What the chassis' USART is set to.
pub const BAUD: u32 = 921_600;
