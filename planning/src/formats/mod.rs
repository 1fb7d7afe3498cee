//! Maps as other programs write them.

pub mod image;
pub mod lif;
pub mod movingai;
pub mod nurbs;
pub mod rmf;
pub mod ros;
pub mod scen;
pub mod yaml;
