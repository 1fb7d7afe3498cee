//! Tests that cross crates: loopback, emulated boards, the demo.
