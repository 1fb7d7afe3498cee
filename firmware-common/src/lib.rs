//! What the boards of piles and robots share. Both have a link that carries frames, an RFID reader
//! that counts passes, and a watchdog that is fed only while every task lives.
//!
//! | module | one idea |
//! |---|---|
//! | [`reader`] | the RFID readers: bytes in, tags out |
//! | [`presence`] | which tags stand in front of a reader |
//! | [`clock`] | the site's time |
//! | [`greeting`] | who a device is, said until it is answered |
//! | [`passes`] | how often robots pass piles, by period of the day (LMPP eqs. 4, 8) |
//! | [`supervisor`] | the watchdog is fed only if every task has checked in |
//! | `tasks` | link and reader as tasks, generic over a board's drivers, only built for ARM |
//! | `executor` | one executor for the tasks, one above it for control; only built for ARM |
//! | `emulated` | the machine that QEMU emulates: UARTs, clock; only built for it |
//! | `stm32` | what the boards that are flashed have in common; only built for them |
#![cfg_attr(not(test), no_std)]

pub mod clock;
#[cfg(all(target_arch = "arm", target_os = "none", feature = "emulated"))]
pub mod emulated;
#[cfg(all(target_arch = "arm", target_os = "none", any(feature = "emulated", feature = "stm32")))]
pub mod executor;
pub mod greeting;
pub mod passes;
pub mod presence;
pub mod reader;
#[cfg(all(target_arch = "arm", target_os = "none", feature = "stm32"))]
pub mod stm32;
pub mod supervisor;
#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod tasks;
