//! What goes over a Chargehand wire: messages, frames, versions.
#![cfg_attr(not(test), no_std)]
