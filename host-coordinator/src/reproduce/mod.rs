//! The papers' tables, computed again and compared with what is printed: a module a paper.

pub mod figure;
pub mod lmpp;
mod row;

pub use row::{Printed, Row, Value, Verdict};
