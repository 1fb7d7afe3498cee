//! What QEMU's machine does not have: a contactor, which shows in the log, and a memory, which
//! forgets. The machine itself is [`firmware_common::emulated`].

mod contacts;
mod memory;

pub use contacts::LoggedContactor;
pub use memory::VolatileMemory;
