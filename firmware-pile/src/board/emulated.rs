//! What QEMU's machine does not have: a charger, which is a [`Plant`](crate::plant::Plant) here, and
//! a memory, which forgets. The machine itself is [`firmware_common::emulated`].

mod charger;
mod memory;
pub mod seal_cost;

pub use charger::ModelledCharger;
pub use memory::VolatileMemory;
