//! QEMU's machine has no flash that can be written, so nothing outlives the emulator: an emulated
//! pile starts without an epoch and learns it from the coordinator's Hello.

use protocol::{BootEpoch, Epoch};
use semihosting::sys::arm_compat::sys_time;

use crate::tasks::Memory;

/// Forgets everything.
pub struct VolatileMemory;

impl Memory for VolatileMemory {
    async fn store_epoch(&mut self, epoch: Epoch) {
        defmt::info!("epoch {} would be stored", epoch.0);
    }
}

/// The number of this start. With nothing to count in, it is the host's clock in seconds, which
/// grows from start to start as a count would.
pub fn boot_epoch() -> BootEpoch {
    BootEpoch(sys_time().ok().and_then(|seconds| u32::try_from(seconds).ok()).unwrap_or(1))
}
