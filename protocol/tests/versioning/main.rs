//! The bytes of every version, kept by hand.
//!
//! `vNN.rs` holds what version NN added, and is never edited once that version is released. This
//! file alone lives on: it knows all variants there are now, and looks that a version keeps each.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod v01;

use core::fmt::Debug;

use protocol::{
    Activity, Availability, BootEpoch, ChassisFault, ChassisMode, ChassisRefusal, Deframer, DeviceId,
    EndReason, FaultCode, Frame, FrameError, Message, NackReason, PileId, Reference, RescuePhase, Session,
    Sessions, StopReason, Topic, Trust, UnassignedReason, Wheel,
};
use serde::{Serialize, de::DeserializeOwned};

/// The bytes of hexadecimal text; blanks and bars are there for the reader.
fn bytes(text: &str) -> Vec<u8> {
    let digits: Vec<u32> =
        text.chars().filter(|c| !" |".contains(*c)).map(|c| c.to_digit(16).unwrap()).collect();
    digits.chunks(2).map(|pair| u8::try_from(pair[0] << 4 | pair[1]).unwrap()).collect()
}

/// Checks that values are written as, and read from, their golden bytes.
fn check<T: Debug + PartialEq + Serialize + DeserializeOwned>(golden: &[(T, &str)]) {
    for (value, text) in golden {
        let mut buffer = [0; 1024];
        assert_eq!(postcard::to_slice(value, &mut buffer).unwrap(), bytes(text), "{value:?} is not {text}");
        assert_eq!(&postcard::from_bytes::<T>(&bytes(text)).unwrap(), value, "{text}");
    }
}

/// Checks an enum's golden bytes, and that every variant has some. The variants are listed; the
/// compiler sees to it that none is forgotten.
macro_rules! check_enum {
    ($name:ident { $($variant:ident),* } in $golden:expr) => {{
        let variant = |value: &$name| match value { $($name::$variant { .. } => stringify!($variant)),* };
        let golden = $golden;
        check(&golden);
        for wanted in [$(stringify!($variant)),*] {
            assert!(
                golden.iter().any(|(value, _)| variant(value) == wanted),
                "no version keeps bytes of {}::{wanted}",
                stringify!($name),
            );
        }
    }};
}

#[test]
fn every_message_keeps_its_bytes() {
    check_enum!(Message {
        Hello, PileState, PileTable, Grant, Revoke, PassReport, TimeRequest, TimeSync, Ack, Nack, Fault,
        RobotState, ChargeRequest, Assignment, Unassigned, Drive, Stop, Release, Task, TaskEnergy, Odometry,
        ChassisState, PileReadings, ChargeReport, Query, PileFaults, PendingPasses, PileParameters, ClearFault,
        Provision, Rescue, RescueState, ClaimPile, ClaimRule
    } in v01::messages());
}

#[test]
fn every_enum_keeps_its_ordinals() {
    check_enum!(Availability { Free, Reserved, Charging, Done, Fault } in v01::AVAILABILITIES);
    check_enum!(EndReason { Completed, Expired, Revoked, RobotLeft, Fault } in v01::END_REASONS);
    check_enum!(Reference { Command, Report, Claim } in v01::REFERENCES);
    check_enum!(NackReason {
        StaleEpoch, TooLate, ClockUnknown, Held, Occupied, Faulted, Ended, Chassis, NotCleared, Provisioned,
        NotClaimable
    } in v01::NACK_REASONS);
    check_enum!(FaultCode {
        ReaderSilent, ContactorWelded, ContactorStuckOpen, OverCurrent, OverVoltage, OverTemperature,
        ReversedPolarity, StrayCurrent, VoltageSensor, CurrentSensor, TemperatureSensor, EmergencyStop,
        MainsLost, StoreFailed
    } in v01::FAULT_CODES);
    check_enum!(Topic { State, Faults, Passes, Table, Parameters } in v01::TOPICS);
    check_enum!(Activity { Working, Waiting, Approaching, Docked, Stranded, Charging } in v01::ACTIVITIES);
    check_enum!(RescuePhase { Driving, Charging, Done, GaveUp } in v01::RESCUE_PHASES);
    check_enum!(UnassignedReason { AllTaken, OutOfReach, Withdrawn } in v01::UNASSIGNED_REASONS);
    check_enum!(ChassisRefusal {
        ForwardSpeed, SidewaysSpeed, TurnRate, TimeToLive, Stopped, Moving, NotCleared, TooManyTasks
    } in v01::CHASSIS_REFUSALS);
    check_enum!(StopReason {
        Started, Watchdog, Commanded, LinkSilent, LinkCorrupted, Emergency, DriverFault, EncoderStuck,
        WheelStalled
    } in v01::STOP_REASONS);
    check_enum!(ChassisMode { Braked, Driving, Stopping } in v01::CHASSIS_MODES);
    check_enum!(Wheel { RearLeft, FrontLeft, FrontRight, RearRight } in v01::WHEELS);
    check_enum!(ChassisFault {
        Driver, EncoderStuck, Stalled, Slipping, GyroSilent, BatterySilent
    } in v01::CHASSIS_FAULTS);
}

#[test]
fn every_kind_of_sender_keeps_its_header() {
    for (frame, text) in v01::frames() {
        assert_eq!(frame.encode().unwrap(), bytes(text)[..], "{frame:?}");
        let mut receiver = Sessions::insecure(DeviceId::Coordinator, BootEpoch(1));
        assert_eq!(opened(&mut receiver, &bytes(text)), [Ok(frame)]);
    }
}

/// What a receiver makes of a stream.
fn opened<Peers: AsMut<[Session]>>(
    receiver: &mut Sessions<Peers>,
    stream: &[u8],
) -> Vec<Result<Frame, FrameError>> {
    let mut found = Vec::new();
    Deframer::new().feed(stream, |result| found.push(result.and_then(|packet| receiver.open(packet))));
    found
}

#[test]
fn sealed_frames_keep_their_bytes() {
    let [device, site] = v01::keys();
    let (pile, coordinator) = (DeviceId::Pile(PileId(7)), DeviceId::Coordinator);
    let keys = |peer| Trust::Keys { site: Some(site), peers: [Session::new(peer, device)] };
    let mut ends = [
        Sessions::new(pile, BootEpoch(3), keys(coordinator)),
        Sessions::new(coordinator, BootEpoch(5), keys(pile)),
    ];
    for (frame, to, text) in v01::conversation() {
        let [ours, theirs] = &mut ends;
        let (sender, receiver) = if frame.header.sender == pile { (ours, theirs) } else { (theirs, ours) };
        assert_eq!(sender.seal(to, &frame.message).unwrap(), bytes(text)[..], "{frame:?}");
        assert_eq!(opened(receiver, &bytes(text)), [Ok(frame)]);
    }
}

#[test]
fn the_book_shows_the_bytes_of_a_pile_s_hello() {
    let book = include_str!("../../../docs/protocol.md");
    let plain = v01::frames()[1].1;
    let sealed = v01::conversation()[0].2;
    for text in [plain, sealed] {
        assert!(book.contains(text), "the book lacks {text}");
    }
}
