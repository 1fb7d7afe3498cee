//! Robots that pass a pile (LMPP eq. 4).

use crate::bench::{Bench, tag};

#[test]
fn a_parked_robot_passes_once() {
    let mut bench = Bench::new();
    bench.standing = Some((tag(3), -65));
    bench.wait(100_000);
    assert_eq!(bench.passes_of(tag(3)), 1);
}
