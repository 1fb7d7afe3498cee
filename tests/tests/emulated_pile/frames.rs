//! What single frames and single reads of the RFID reader do to the pile, and what they must not.

use std::time::Instant;

use protocol::{Availability, DurationMs, EndReason, Epoch, Message, NackReason, Revoke};

use tests::pile_bench::{ENERGY_J, EPOCH, ETA, POWER_W, PileBench, ROBOT, SOON, STRANGER};

#[test]
fn a_granted_robot_is_charged_as_eq_1_says_and_counted_once() {
    let mut bench = PileBench::new();
    let lease = bench.granted();
    let reserved = bench.state_where("that it is reserved", |state| state.holder == Some(lease));
    assert_eq!((reserved.row.availability, reserved.energised), (Availability::Reserved, false));

    bench.reader.dock(ROBOT);
    bench.board.wait_for("contactor closed", SOON).unwrap_or_else(|error| panic!("{error}"));
    let begun = Instant::now();
    let mut charging = vec![bench.state_where("that it charges", |state| state.energised)];
    let ended = loop {
        let state = bench.state();
        if state.holder.is_none() {
            break state;
        }
        charging.push(state);
    };
    let took = begun.elapsed();

    // Eq. 2: what the battery lacks by the pile's power, and the reserve.
    let planned = DurationMs(DurationMs::from_seconds(ENERGY_J / POWER_W).0 + ETA.0);
    for state in &charging {
        assert_eq!((state.row.availability, state.row.planned), (Availability::Charging, planned));
        // Eq. 1.
        let expected = 1.0 - state.elapsed.as_seconds() / planned.as_seconds();
        let remaining = state.row.remaining.get();
        assert!((remaining - expected).abs() < 1e-3, "q is {remaining} instead of {expected}");
    }
    for pair in charging.windows(2) {
        assert!(pair[1].row.remaining <= pair[0].row.remaining, "q rose: {pair:?}");
    }
    assert!(charging.len() > 20, "q fell in {} steps only", charging.len());
    let (first, last) = (charging[0].row.remaining.get(), charging[charging.len() - 1].row.remaining.get());
    assert!(first > 0.9 && last < 0.1, "q fell from {first} to {last} only");

    let over = ended.ended.expect("no lease has ended");
    assert_eq!((over.lease, over.reason), (lease, EndReason::Completed));
    assert!((planned..DurationMs(planned.0 + 500)).contains(&over.charged), "charged for {:?}", over.charged);
    assert_eq!(ended.row.availability, Availability::Done);
    assert_eq!(ended.row.remaining.get(), 0.0);
    // QEMU's clock is the host's; both log and link are read late on a busy one.
    let seconds = f64::from(planned.as_seconds());
    assert!((seconds - 1.0..seconds + 6.0).contains(&took.as_secs_f64()), "it took {took:?}");
    bench.board.wait_for("contactor open", SOON).unwrap_or_else(|error| panic!("{error}"));
    bench.state_where("that its contacts are dead", |state| !state.energised);

    bench.reader.clear();
    bench.state_where("that it is free", |state| state.row.availability == Availability::Free);
    // All that time it was one pass (eq. 4, one for each approach).
    let passes: Vec<_> = bench.passes.iter().map(|count| (count.tag, count.passes)).collect();
    assert_eq!(passes, [(ROBOT, 1)]);
}

#[test]
fn a_wrong_tag_does_nothing_and_the_right_one_still_charges() {
    let mut bench = PileBench::new();
    let lease = bench.granted();
    bench.reader.dock(STRANGER);
    // The pile reports whom it saw, so it did not charge although it saw somebody.
    let seen = (0..20).any(|_| {
        bench.stays_dead_for(1);
        bench.passes.iter().any(|count| count.tag == STRANGER)
    });
    assert!(seen, "the pile did not see the wrong tag");
    assert_eq!(bench.stays_dead_for(2).holder, Some(lease));
    bench.reader.dock(ROBOT);
    bench.state_where("that it charges", |state| state.energised);
}

#[test]
fn a_stale_epoch_is_refused_and_its_robot_not_charged() {
    let mut bench = PileBench::new();
    let stale = bench.grant(100, Epoch(EPOCH.0 - 1));
    bench.say(Message::Grant(stale));
    assert_eq!(bench.answer(100), Err(NackReason::StaleEpoch { highest: EPOCH }));
    bench.reader.dock(ROBOT);
    assert_eq!(bench.stays_dead_for(4).holder, None);
    let lease = bench.granted();
    assert_eq!(bench.state_where("that it charges", |state| state.energised).holder, Some(lease));
}

#[test]
fn corrupted_frames_do_nothing_and_cost_no_good_one() {
    let mut bench = PileBench::new();
    // A first lease, taken back: the clock is known and only damage can keep a grant from working.
    let lease = bench.granted();
    let head = bench.grant(99, EPOCH).head;
    bench.say(Message::Revoke(Revoke { head, lease }));
    assert_eq!(bench.answer(99), Ok(()));

    bench.reader.dock(ROBOT);
    let grant = bench.grant(100, EPOCH);
    let good = bench.frame(Message::Grant(grant));
    let damaged: Vec<u8> = (1..good.len() - 1)
        .flat_map(|index| {
            let mut frame = good.clone();
            frame[index] ^= 1 << (index % 8);
            frame
        })
        .collect();
    bench.transmit(&damaged);
    assert_eq!(bench.stays_dead_for(4).holder, None);

    bench.transmit(&[&damaged, &good[..]].concat());
    assert_eq!(bench.answer(100), Ok(()));
    assert_eq!(bench.state_where("that it charges", |state| state.energised).holder, Some(grant.lease));
}

#[test]
fn a_flood_of_noise_is_survived() {
    let mut bench = PileBench::new();
    let lease = bench.granted();
    let mut noise: u32 = 0x9E37_79B9;
    let flood: Vec<u8> = (0..16 * 1024)
        .map(|_| {
            // Marsaglia's xorshift: the same noise in every run.
            noise ^= noise << 13;
            noise ^= noise >> 17;
            noise ^= noise << 5;
            noise as u8
        })
        .collect();
    bench.transmit(&flood);
    bench.extended(lease, 200);
    bench.reader.dock(ROBOT);
    assert_eq!(bench.state_where("that it charges", |state| state.energised).holder, Some(lease));
}
