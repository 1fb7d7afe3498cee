//! The RFID readers.

pub mod r200;
