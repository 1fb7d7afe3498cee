//! Maps as other programs write them.

pub mod movingai;
pub mod scen;
