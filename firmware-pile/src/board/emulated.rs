//! What QEMU's machine does not have: a charger, which is a [`Plant`](crate::plant::Plant) here, with
//! a test bench that breaks it. The machine itself is [`firmware_common::emulated`].

mod bench;
mod charger;
pub mod seal_cost;
pub mod store_cost;

pub use bench::serve;
pub use charger::ModelledCharger;
