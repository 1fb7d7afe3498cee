//! The `chargehand` binary.
fn main() {}
