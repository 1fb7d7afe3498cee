//! `cargo xtask`: set up, test, emulate, measure.
fn main() {}
