//! A body that is no message of its version is an error, though its frame is good.

use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};
use protocol::{
    AngleRad, CoordinateM, Covariance, DurationMs, EnergyJ, Fraction, FrameError, Hello, Message, Millis,
    Reference, SiteMillis, SpeedMps, TemperatureC, TimeRequest, TimeSync, TurnRateRadps,
};

use crate::{
    bytes::{body, read_body},
    largest,
    strategies::message,
};

/// `body` with `bad` instead of one of the places where `good` stands, for every such place.
fn with_each_replaced(body: &[u8], good: &[u8], bad: &[u8]) -> Vec<Vec<u8>> {
    let places = body.windows(good.len()).enumerate().filter(|(_, window)| *window == good);
    places.map(|(at, _)| [&body[..at], bad, &body[at + good.len()..]].concat()).collect()
}

/// Puts every one of `bad` in every place where a message of [`largest`] has `good`; answers how
/// many places there are.
fn refuses(good: &[u8], bad: &[Vec<u8>]) -> usize {
    let mut places = 0;
    for (message, name, _) in largest::messages() {
        for bad in bad {
            for body in with_each_replaced(&body(&message), good, bad) {
                assert_eq!(read_body(&body), [Err(FrameError::Body)], "{bad:02X?} for {good:02X?} in {name}");
                places += 1;
            }
        }
    }
    places / bad.len()
}

/// Numbers that are no value of a quantity with this range.
fn no_values(min: f32, max: f32) -> Vec<Vec<u8>> {
    let outside = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, max.next_up(), min.next_down()];
    outside.iter().map(|value| value.to_le_bytes().to_vec()).collect()
}

fn varint(value: u64) -> Vec<u8> {
    let mut buffer = [0; 10];
    postcard::to_slice(&value, &mut buffer).unwrap().to_vec()
}

/// Numbers beyond a time's range: the next one, and the largest of as many bytes.
fn too_late(max: u64) -> Vec<Vec<u8>> {
    vec![varint(max + 1), varint((1 << (7 * varint(max).len())) - 1)]
}

#[test]
fn nan_infinities_and_values_out_of_range_are_errors_wherever_a_quantity_stands() {
    // 24 waypoints of an assignment and of a rescue, a robot's and a request's position, the start of a pose; and the power of
    // PileParameters and Provision, whose range ends there too.
    let coordinate = no_values(CoordinateM::MIN.get(), CoordinateM::MAX.get());
    assert_eq!(refuses(&CoordinateM::MAX.get().to_le_bytes(), &coordinate), 2 * (24 + 27) + 2);
    // Grant, RobotState, ChargeRequest, TaskEnergy twice, ChassisState, ChargeReport, Rescue, RescueState, ClaimPile.
    let energy = no_values(EnergyJ::MIN.get(), EnergyJ::MAX.get());
    assert_eq!(refuses(&EnergyJ::MAX.get().to_le_bytes(), &energy), 10);
    // PileState and the eight rows of a table.
    let fraction = no_values(Fraction::MIN.get(), Fraction::MAX.get());
    assert_eq!(refuses(&Fraction::MAX.get().to_le_bytes(), &fraction), 9);
    // Drive, and Odometry's three twists.
    let speed = no_values(SpeedMps::MIN.get(), SpeedMps::MAX.get());
    assert_eq!(refuses(&SpeedMps::MAX.get().to_le_bytes(), &speed), 2 * 4);
    // The same, and the voltages and currents of PileState (1), ChassisState (2), PileReadings (3),
    // PileParameters (2) and Provision (2).
    let hundred = no_values(-100.0, 100.0);
    assert_eq!(refuses(&TurnRateRadps::MAX.get().to_le_bytes(), &hundred), 4 + 10);
    // PileReadings, PileParameters twice, Provision twice.
    let temperature = no_values(TemperatureC::MIN.get(), TemperatureC::MAX.get());
    assert_eq!(refuses(&TemperatureC::MAX.get().to_le_bytes(), &temperature), 5);
    let angle = no_values(AngleRad::MIN.get(), AngleRad::MAX.get());
    assert_eq!(refuses(&AngleRad::MAX.get().to_le_bytes(), &angle), 1);
    let covariance = no_values(Covariance::MIN.get(), Covariance::MAX.get());
    assert_eq!(refuses(&Covariance::MAX.get().to_le_bytes(), &covariance), 9);
}

#[test]
fn times_out_of_range_are_errors_wherever_a_time_stands() {
    // TimeRequest, TimeSync, Odometry.
    assert_eq!(refuses(&varint(Millis::MAX.0), &too_late(Millis::MAX.0)), 3);
    // Nine rows, Grant twice, Revoke, TimeSync, ChargeReport twice.
    assert_eq!(refuses(&varint(SiteMillis::MAX.0), &too_late(SiteMillis::MAX.0)), 15);
    // Nine rows, PileState twice, Drive, ChargeReport, PileParameters, Provision, ClaimPile.
    let max = DurationMs::MAX.0.into();
    assert_eq!(refuses(&varint(max), &too_late(max)), 16);
}

#[test]
fn a_time_beyond_its_range_is_sent_as_the_largest() {
    let sent = Message::TimeSync(TimeSync { asked_at: Millis(u64::MAX), site_now: SiteMillis(u64::MAX) });
    let read = Message::TimeSync(TimeSync { asked_at: Millis::MAX, site_now: SiteMillis::MAX });
    assert_eq!(read_body(&body(&sent)), [Ok(read)]);
}

/// The ordinals of one byte that are messages: every message has a value of zeros only.
fn known_ordinals() -> Vec<u8> {
    let zeros = |ordinal: u8| [&[ordinal][..], &[0; 128]].concat();
    (0..0x80).filter(|&ordinal| postcard::take_from_bytes::<Message>(&zeros(ordinal)).is_ok()).collect()
}

#[test]
fn the_messages_tried_here_are_all_there_are() {
    let largest = largest::messages().map(|(message, ..)| body(&message)[0]);
    assert_eq!(largest[..], known_ordinals()[..]);

    let mut runner = TestRunner::deterministic();
    let mut tried: Vec<u8> =
        (0..1000).map(|_| body(&message().new_tree(&mut runner).unwrap().current())[0]).collect();
    tried.sort_unstable();
    tried.dedup();
    assert_eq!(tried, known_ordinals());
}

#[test]
fn an_unknown_ordinal_is_an_error() {
    for ordinal in known_ordinals().len() as u8..0x80 {
        assert_eq!(read_body(&[&[ordinal][..], &[0; 128]].concat()), [Err(FrameError::Body)]);
    }
    // An enum within a message: an acknowledgement of neither a command nor a report.
    let acknowledged = Message::Ack(protocol::Ack { of: Reference::Command(protocol::CommandId(5)) });
    assert_eq!(body(&acknowledged), [8, 0, 5]);
    assert_eq!(read_body(&[8, 2, 5]), [Err(FrameError::Body)]);
}

#[test]
fn a_list_longer_than_its_limit_is_an_error() {
    for (message, ordinal, limit) in [
        ("PileTable", &[2][..], protocol::limits::ROWS_PER_TABLE),
        ("PassReport", &[5, 0, 0][..], protocol::limits::PASSES_PER_REPORT),
        ("Assignment", &[13, 0, 0, 0, 0][..], protocol::limits::WAYPOINTS_PER_PART),
        ("Rescue", &[30, 0, 0, 0, 0, 0, 0, 0, 0][..], protocol::limits::WAYPOINTS_PER_PART),
        ("ChassisState", &[21, 0, 0][..], protocol::limits::CHASSIS_FAULTS),
        ("PileFaults", &[25][..], protocol::FaultCode::ALL.len()),
        ("PendingPasses", &[26][..], protocol::limits::PASSES_PER_REPORT),
    ] {
        let list = |length: usize, zeros: usize| [ordinal, &[length as u8], &vec![0; zeros]].concat();
        let zeros = (0..).find(|&zeros| read_body(&list(limit, zeros))[0].is_ok());
        let zeros_per_item = zeros.unwrap() / limit;
        let too_long = list(limit + 1, zeros_per_item * (limit + 1));
        assert_eq!(read_body(&too_long), [Err(FrameError::Body)], "{message}");
    }
}

#[test]
fn a_longer_way_to_write_a_number_is_read_as_the_number() {
    let message = Message::TimeRequest(TimeRequest { asked_at: Millis(5) });
    assert_eq!(body(&message), [6, 5]);
    assert_eq!(read_body(&[6, 0x85, 0x80, 0x00]), [Ok(message)]);
}

proptest! {
    #[test]
    fn bytes_left_over_are_an_error(
        message in message(), extra in prop::collection::vec(any::<u8>(), 1..8),
    ) {
        let body = [body(&message), extra].concat();
        prop_assert_eq!(read_body(&body), [Err(FrameError::Body)]);
    }

    #[test]
    fn a_body_cut_short_is_an_error(message in message(), at: prop::sample::Index) {
        let body = body(&message);
        prop_assert_eq!(read_body(&body[..at.index(body.len())]), [Err(FrameError::Body)]);
    }

    #[test]
    fn a_hello_may_say_any_versions(hello: (u8, u8, [u8; 3], u32)) {
        let (min, current, software, epoch) = hello;
        let hello = Message::Hello(Hello { min, current, software, epoch: protocol::Epoch(epoch) });
        prop_assert_eq!(read_body(&body(&hello)), [Ok(hello)]);
    }
}
