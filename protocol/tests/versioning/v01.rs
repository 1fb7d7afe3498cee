//! The bytes of version 1. Never edit this file once version 1 is released: a test that fails here
//! means that devices in the field would no longer be understood.
//!
//! Numbers above 7F are varints: seven bits a byte, the lowest first, the top bit set in all but the
//! last. Bars stand between the fields, and between a message's ordinal and its fields.

use heapless::Vec;
use protocol::*;

pub const AVAILABILITIES: [(Availability, &str); 5] = [
    (Availability::Free, "00"),
    (Availability::Reserved, "01"),
    (Availability::Charging, "02"),
    (Availability::Done, "03"),
    (Availability::Fault, "04"),
];

pub const END_REASONS: [(EndReason, &str); 5] = [
    (EndReason::Completed, "00"),
    (EndReason::Expired, "01"),
    (EndReason::Revoked, "02"),
    (EndReason::RobotLeft, "03"),
    (EndReason::Fault, "04"),
];

pub const REFERENCES: [(Reference, &str); 3] = [
    (Reference::Command(CommandId(5)), "00|05"),
    (Reference::Report(REPORT), "01|03 06"),
    (Reference::Claim(ClaimRef { robot: RobotId(3), request: RequestId(300) }), "02|03 AC02"),
];

pub const NACK_REASONS: [(NackReason, &str); 11] = [
    (NackReason::StaleEpoch { highest: Epoch(300) }, "00|AC02"),
    (NackReason::TooLate, "01"),
    (NackReason::ClockUnknown, "02"),
    (NackReason::Held { by: LEASE }, "03|02 09 03"),
    (NackReason::Occupied, "04"),
    (NackReason::Faulted, "05"),
    (NackReason::Ended, "06"),
    (NackReason::Chassis { refusal: ChassisRefusal::TurnRate }, "07|02"),
    (NackReason::NotCleared, "08"),
    (NackReason::Provisioned, "09"),
    (NackReason::NotClaimable, "0A"),
];

pub const FAULT_CODES: [(FaultCode, &str); 14] = [
    (FaultCode::ReaderSilent, "00"),
    (FaultCode::ContactorWelded, "01"),
    (FaultCode::ContactorStuckOpen, "02"),
    (FaultCode::OverCurrent, "03"),
    (FaultCode::OverVoltage, "04"),
    (FaultCode::OverTemperature, "05"),
    (FaultCode::ReversedPolarity, "06"),
    (FaultCode::StrayCurrent, "07"),
    (FaultCode::VoltageSensor, "08"),
    (FaultCode::CurrentSensor, "09"),
    (FaultCode::TemperatureSensor, "0A"),
    (FaultCode::EmergencyStop, "0B"),
    (FaultCode::MainsLost, "0C"),
    (FaultCode::StoreFailed, "0D"),
];

pub const TOPICS: [(Topic, &str); 5] = [
    (Topic::State, "00"),
    (Topic::Faults, "01"),
    (Topic::Passes, "02"),
    (Topic::Table, "03"),
    (Topic::Parameters, "04"),
];

pub const ACTIVITIES: [(Activity, &str); 6] = [
    (Activity::Working, "00"),
    (Activity::Waiting, "01"),
    (Activity::Approaching, "02"),
    (Activity::Docked, "03"),
    (Activity::Stranded, "04"),
    (Activity::Charging, "05"),
];

pub const UNASSIGNED_REASONS: [(UnassignedReason, &str); 3] = [
    (UnassignedReason::AllTaken, "00"),
    (UnassignedReason::OutOfReach, "01"),
    (UnassignedReason::Withdrawn, "02"),
];

pub const RESCUE_PHASES: [(RescuePhase, &str); 4] = [
    (RescuePhase::Driving, "00"),
    (RescuePhase::Charging, "01"),
    (RescuePhase::Done, "02"),
    (RescuePhase::GaveUp, "03"),
];

pub const CHASSIS_REFUSALS: [(ChassisRefusal, &str); 8] = [
    (ChassisRefusal::ForwardSpeed, "00"),
    (ChassisRefusal::SidewaysSpeed, "01"),
    (ChassisRefusal::TurnRate, "02"),
    (ChassisRefusal::TimeToLive, "03"),
    (ChassisRefusal::Stopped { by: StopReason::Emergency }, "04|05"),
    (ChassisRefusal::Moving, "05"),
    (ChassisRefusal::NotCleared, "06"),
    (ChassisRefusal::TooManyTasks, "07"),
];

pub const STOP_REASONS: [(StopReason, &str); 9] = [
    (StopReason::Started, "00"),
    (StopReason::Watchdog, "01"),
    (StopReason::Commanded, "02"),
    (StopReason::LinkSilent, "03"),
    (StopReason::LinkCorrupted, "04"),
    (StopReason::Emergency, "05"),
    (StopReason::DriverFault, "06"),
    (StopReason::EncoderStuck, "07"),
    (StopReason::WheelStalled, "08"),
];

pub const CHASSIS_MODES: [(ChassisMode, &str); 3] =
    [(ChassisMode::Braked, "00"), (ChassisMode::Driving, "01"), (ChassisMode::Stopping, "02")];

pub const WHEELS: [(Wheel, &str); 4] =
    [(Wheel::RearLeft, "00"), (Wheel::FrontLeft, "01"), (Wheel::FrontRight, "02"), (Wheel::RearRight, "03")];

pub const CHASSIS_FAULTS: [(ChassisFault, &str); 6] = [
    (ChassisFault::Driver { wheel: Wheel::FrontLeft }, "00|01"),
    (ChassisFault::EncoderStuck { wheel: Wheel::FrontRight }, "01|02"),
    (ChassisFault::Stalled { wheel: Wheel::RearRight }, "02|03"),
    (ChassisFault::Slipping, "03"),
    (ChassisFault::GyroSilent, "04"),
    (ChassisFault::BatterySilent, "05"),
];

/// `03 06`: boot, number.
const REPORT: ReportId = ReportId { boot: BootEpoch(3), number: 6 };

/// `02 09 03`
const LEASE: LeaseRef = LeaseRef { epoch: Epoch(2), lease: LeaseId(9), robot: RobotId(3) };

/// `0A | E0D403`
const HEAD: CommandHead = CommandHead { id: CommandId(10), valid_until: SiteMillis(60_000) };

/// `30751FEB705C5904E3D50D70`
const TAG: TagId = TagId([0x30, 0x75, 0x1F, 0xEB, 0x70, 0x5C, 0x59, 0x04, 0xE3, 0xD5, 0x0D, 0x70]);

/// `07 | 03 | 2C | 01 90A10F | 02 | 0000003F | C0CF24`: pile, boot, version, stamp, availability,
/// remaining, planned.
fn row() -> PileRow {
    PileRow {
        pile: PileId(7),
        boot: BootEpoch(3),
        version: 44,
        stamp: Some(SiteMillis(250_000)),
        availability: Availability::Charging,
        remaining: Fraction::new(0.5).unwrap(),
        planned: DurationMs(600_000),
    }
}

/// `00004841 | 000010C0`
fn position() -> Position {
    Position { x: CoordinateM::new(12.5).unwrap(), y: CoordinateM::new(-2.25).unwrap() }
}

fn energy() -> EnergyJ {
    EnergyJ::new(1_000.0).unwrap()
}

/// `0000003F | 000080BE | 0000803F`
fn twist() -> Twist {
    Twist {
        vx: SpeedMps::new(0.5).unwrap(),
        vy: SpeedMps::new(-0.25).unwrap(),
        wz: TurnRateRadps::new(1.0).unwrap(),
    }
}

/// What a robot's computer says to its chassis.
fn driving() -> [(Message, &'static str); 6] {
    let command = CommandId(300);
    [
        // command | time to live | vx, vy, wz
        (
            Message::Drive(Drive { command, ttl: DurationMs(200), twist: twist() }),
            "0F | AC02 | C801 | 0000003F 000080BE 0000803F",
        ),
        // command | emergency
        (Message::Stop(Stop { command, emergency: true }), "10 | AC02 | 01"),
        // command
        (Message::Release(Release { command }), "11 | AC02"),
        // command | task
        (Message::Task(Task { command, task: Some(TaskId(7)) }), "12 | AC02 | 01 07"),
        (Message::Task(Task { command, task: None }), "12 | AC02 | 00"),
        // of command 5 | reason
        (
            Message::Nack(Nack {
                of: Reference::Command(CommandId(5)),
                reason: NackReason::Chassis { refusal: ChassisRefusal::ForwardSpeed },
            }),
            "09 | 00 05 | 07 00",
        ),
    ]
}

/// What a chassis says.
fn chassis() -> [(Message, &'static str); 4] {
    let covariance = |value| Covariance::new(value).unwrap();
    let mut faults = Vec::new();
    faults.extend([ChassisFault::Stalled { wheel: Wheel::FrontRight }, ChassisFault::Slipping]);
    [
        // task | runs | last | mean
        (
            Message::TaskEnergy(TaskEnergy { task: TaskId(7), runs: 300, last: energy(), mean: energy() }),
            "13 | 07 | AC02 | 00007A44 | 00007A44",
        ),
        // stamp | x, y, yaw | six covariances | measured | three variances | ramped | commanded
        (
            Message::Odometry(Odometry {
                stamp: Millis(1_000),
                pose: Pose { x: position().x, y: position().y, yaw: AngleRad::new(1.5).unwrap() },
                pose_covariance: PoseCovariance {
                    xx: covariance(1.0),
                    xy: covariance(-1.0),
                    xyaw: covariance(2.0),
                    yy: covariance(-2.0),
                    yyaw: covariance(4.0),
                    yawyaw: covariance(0.5),
                },
                measured: twist(),
                measured_variance: TwistVariance {
                    vx: covariance(1.0),
                    vy: covariance(2.0),
                    wz: covariance(4.0),
                },
                ramped: Twist::default(),
                commanded: twist(),
            }),
            "14 | E807 | 00004841 000010C0 0000C03F \
             | 0000803F 000080BF 00000040 000000C0 00008040 0000003F | 0000003F 000080BE 0000803F \
             | 0000803F 00000040 00008040 | 00000000 00000000 00000000 | 0000003F 000080BE 0000803F",
        ),
        // mode | stop | faults | battery: voltage, current, energy | discarded
        (
            Message::ChassisState(ChassisState {
                mode: ChassisMode::Braked,
                stop: Some(StopReason::WheelStalled),
                faults,
                battery: Some(BatteryState {
                    voltage: VoltageV::new(12.5).unwrap(),
                    current: CurrentA::new(-2.25).unwrap(),
                    energy: energy(),
                }),
                discarded: 300,
            }),
            "15 | 00 | 01 08 | 02 0202 03 | 01 00004841 000010C0 00007A44 | AC02",
        ),
        (
            Message::ChassisState(ChassisState {
                mode: ChassisMode::Driving,
                stop: None,
                faults: Vec::new(),
                battery: None,
                discarded: 0,
            }),
            "15 | 01 | 00 | 00 | 00 | 00",
        ),
    ]
}

/// What a pile and the tool at its desk say to each other, and what a pile tells of a charge.
fn service() -> [(Message, &'static str); 10] {
    let mut faults = Vec::new();
    faults.extend([
        FaultState { code: FaultCode::OverCurrent, active: false, latched: true },
        FaultState { code: FaultCode::StoreFailed, active: true, latched: false },
    ]);
    let mut pending = Vec::new();
    pending.extend([
        PendingPass { tag: TAG, period: Some(23), passes: 128 },
        PendingPass { tag: TAG, period: None, passes: 5 },
    ]);
    let readings = PileReadings {
        voltage: Some(VoltageV::new(12.5).unwrap()),
        current: Some(CurrentA::new(-2.25).unwrap()),
        temperature: Some(TemperatureC::new(12.5).unwrap()),
        current_limit: CurrentA::new(12.5).unwrap(),
        contactor_closed: true,
        mated: true,
        emergency_stop: false,
        mains: true,
    };
    let blind = PileReadings { voltage: None, current: None, temperature: None, ..readings };
    let charge = ChargeReport {
        report: REPORT,
        lease: LEASE,
        tag: TAG,
        reason: EndReason::RobotLeft,
        began: SiteMillis(60_000),
        ended: Some(SiteMillis(250_000)),
        charged: DurationMs(1_000),
        energy: energy(),
    };
    let parameters = PileParameters {
        power: PowerW::new(1_000.0).unwrap(),
        eta: DurationMs(1_000),
        voltage_max: VoltageV::new(12.5).unwrap(),
        current_max: CurrentA::new(12.5).unwrap(),
        derate_from: TemperatureC::new(12.5).unwrap(),
        stop_at: TemperatureC::new(-2.25).unwrap(),
        dock_enter_dbm: -60,
        dock_leave_dbm: -66,
    };
    let provision = Provision {
        command: CommandId(300),
        pile: PileId(7),
        device_key: Key::new([0x11; 32]),
        site_key: Key::new([0x22; 32]),
        boot_floor: BootEpoch(300),
        parameters,
    };
    [
        // voltage, current, temperature | limit | closed, mated, emergency stop, mains
        (
            Message::PileReadings(readings),
            "16 | 01 00004841 | 01 000010C0 | 01 00004841 | 00004841 | 01 01 00 01",
        ),
        (Message::PileReadings(blind), "16 | 00 | 00 | 00 | 00004841 | 01 01 00 01"),
        // report | lease | tag | reason | began | ended | charged | energy
        (
            Message::ChargeReport(charge),
            "17 | 03 06 | 02 09 03 | 30751FEB705C5904E3D50D70 | 03 | E0D403 | 01 90A10F | E807 | 00007A44",
        ),
        (
            Message::ChargeReport(ChargeReport { ended: None, ..charge }),
            "17 | 03 06 | 02 09 03 | 30751FEB705C5904E3D50D70 | 03 | E0D403 | 00 | E807 | 00007A44",
        ),
        // topic
        (Message::Query(Query { topic: Topic::Table }), "18 | 03"),
        // two faults: code, active, latched
        (Message::PileFaults(PileFaults { faults }), "19 | 02 | 03 00 01 | 0D 01 00"),
        // two counts: tag, period or none, passes
        (
            Message::PendingPasses(PendingPasses { passes: pending }),
            "1A | 02 | 30751FEB705C5904E3D50D70 01 17 8001 | 30751FEB705C5904E3D50D70 00 05",
        ),
        // power | eta | voltage, current | derate from, stop at | enter, leave
        (
            Message::PileParameters(parameters),
            "1B | 00007A44 | E807 | 00004841 00004841 | 00004841 000010C0 | C4 BE",
        ),
        // command | code
        (
            Message::ClearFault(ClearFault { command: CommandId(300), code: FaultCode::OverCurrent }),
            "1C | AC02 | 03",
        ),
        // command | pile | device key | site key | boot floor | parameters
        (
            Message::Provision(provision),
            "1D | AC02 | 07 \
             | 1111111111111111111111111111111111111111111111111111111111111111 \
             | 2222222222222222222222222222222222222222222222222222222222222222 \
             | AC02 | 00007A44 E807 00004841 00004841 00004841 000010C0 C4 BE",
        ),
    ]
}

/// All of them.
pub fn messages() -> std::vec::Vec<(Message, &'static str)> {
    [&site()[..], &driving(), &chassis(), &service(), &rescue(), &claims()].concat()
}

/// What is said while no coordinator is heard, and before.
fn claims() -> [(Message, &'static str); 2] {
    let claim = ClaimPile {
        request: RequestId(1_000_000),
        pile: PileId(7),
        boot: BootEpoch(3),
        version: 300,
        tag: TAG,
        energy: EnergyJ::new(12.5).unwrap(),
        within: DurationMs(300_000),
    };
    [
        // request | pile | boot, version | tag | energy | within
        (
            Message::ClaimPile(claim),
            "20 | C0843D | 07 | 03 AC02 | 30751FEB705C5904E3D50D70 | 00004841 | E0A712",
        ),
        (Message::ClaimRule(ClaimRule { allowed: true }), "21 | 01"),
    ]
}

/// What piles, robots and the coordinator say to each other.
fn site() -> [(Message, &'static str); 18] {
    let hello = Hello { min: 1, current: 2, software: [0, 1, 2], epoch: Epoch(300) };
    let state = PileState {
        row: row(),
        elapsed: DurationMs(300_000),
        holder: Some(LEASE),
        energised: true,
        ended: Some(EndedLease { lease: LEASE, reason: EndReason::Revoked, charged: DurationMs(1_000) }),
        standing: Some(TAG),
        current: Some(CurrentA::new(12.5).unwrap()),
    };
    let idle_row = PileRow { stamp: None, availability: Availability::Free, ..row() };
    let idle = PileState {
        row: idle_row,
        elapsed: DurationMs(0),
        holder: None,
        energised: false,
        ended: None,
        standing: None,
        current: None,
    };
    let mut rows = Vec::new();
    rows.extend([row(), idle_row]);
    let mut passes = Vec::new();
    passes.extend([PassCount { tag: TAG, period: 23, passes: 128 }]);
    let mut waypoints = Vec::new();
    waypoints.extend([position(), position()]);
    let report = REPORT;
    let request = RequestId(1_000_000);
    [
        // versions from 1 | to 2 | software 0.1.2 | epoch 300
        (Message::Hello(hello), "00 | 01 | 02 | 000102 | AC02"),
        // row | elapsed | holder | energised | ended: lease, reason, charged | standing | current
        (
            Message::PileState(state),
            "01 | 07 03 2C 0190A10F 02 0000003F C0CF24 | E0A712 | 01 020903 | 01 | 01 020903 02 E807 \
             | 01 30751FEB705C5904E3D50D70 | 01 00004841",
        ),
        (Message::PileState(idle), "01 | 07 03 2C 00 00 0000003F C0CF24 | 00 | 00 | 00 | 00 | 00 | 00"),
        // two rows
        (
            Message::PileTable(PileTable { rows }),
            "02 | 02 | 07 03 2C 0190A10F 02 0000003F C0CF24 | 07 03 2C 00 00 0000003F C0CF24",
        ),
        // command, valid until | lease | tag | expiry | energy
        (
            Message::Grant(Grant {
                head: HEAD,
                lease: LEASE,
                tag: TAG,
                expiry: SiteMillis(1_700_000_000_000),
                energy: energy(),
            }),
            "03 | 0A E0D403 | 02 09 03 | 30751FEB705C5904E3D50D70 | 80D095FFBC31 | 00007A44",
        ),
        // command, valid until | lease
        (Message::Revoke(Revoke { head: HEAD, lease: LEASE }), "04 | 0A E0D403 | 02 09 03"),
        // report | one count: tag, period, passes
        (
            Message::PassReport(PassReport { report, passes }),
            "05 | 03 06 | 01 | 30751FEB705C5904E3D50D70 17 8001",
        ),
        // asked at
        (Message::TimeRequest(TimeRequest { asked_at: Millis(1_000) }), "06 | E807"),
        // asked at | site's time
        (
            Message::TimeSync(TimeSync { asked_at: Millis(1_000), site_now: SiteMillis(1_700_000_000_000) }),
            "07 | E807 | 80D095FFBC31",
        ),
        // of command 5, of report 3.6
        (Message::Ack(Ack { of: Reference::Command(CommandId(5)) }), "08 | 00 05"),
        (Message::Ack(Ack { of: Reference::Report(report) }), "08 | 01 03 06"),
        // of command 5 | reason
        (
            Message::Nack(Nack {
                of: Reference::Command(CommandId(5)),
                reason: NackReason::Held { by: LEASE },
            }),
            "09 | 00 05 | 03 020903",
        ),
        // report | code | active
        (
            Message::Fault(Fault { report, code: FaultCode::ContactorStuckOpen, active: true }),
            "0A | 03 06 | 02 | 01",
        ),
        // x, y | energy | activity | accepted
        (
            Message::RobotState(RobotState {
                position: position(),
                energy: energy(),
                activity: Activity::Approaching,
                accepted: Some(request),
            }),
            "0B | 00004841 000010C0 | 00007A44 | 02 | 01 C0843D",
        ),
        (
            Message::RobotState(RobotState {
                position: position(),
                energy: energy(),
                activity: Activity::Working,
                accepted: None,
            }),
            "0B | 00004841 000010C0 | 00007A44 | 00 | 00",
        ),
        // request | x, y | energy | task | priority
        (
            Message::ChargeRequest(ChargeRequest {
                request,
                position: position(),
                energy: energy(),
                task: Some(TaskId(300)),
                priority: TaskPriority::MAX,
            }),
            "0C | C0843D | 00004841 000010C0 | 00007A44 | 01 AC02 | 0A",
        ),
        // request | pile | total | first | two waypoints: x, y
        (
            Message::Assignment(Assignment { request, pile: PileId(300), total: 26, first: 24, waypoints }),
            "0D | C0843D | AC02 | 1A | 18 | 02 | 00004841 000010C0 | 00004841 000010C0",
        ),
        // request | reason
        (
            Message::Unassigned(Unassigned { request, reason: UnassignedReason::OutOfReach }),
            "0E | C0843D | 01",
        ),
    ]
}

/// What mobile chargers and the coordinator say to each other.
fn rescue() -> [(Message, &'static str); 2] {
    let mut waypoints = Vec::new();
    waypoints.extend([position(), position()]);
    let rescue = CommandId(300);
    let sent = Rescue { rescue, robot: RobotId(300), energy: energy(), total: 26, first: 24, waypoints };
    let state = RescueState { rescue, phase: RescuePhase::Charging, given: energy() };
    [
        // command | robot | energy | total | first | two waypoints: x, y
        (
            Message::Rescue(sent),
            "1E | AC02 | AC02 | 00007A44 | 1A | 18 | 02 | 00004841 000010C0 | 00004841 000010C0",
        ),
        // command | phase | given
        (Message::RescueState(state), "1F | AC02 | 01 | 00007A44"),
    ]
}

/// Whole frames: every kind of sender says hello.
pub fn frames() -> [(Frame, &'static str); 4] {
    let frame = |sender, boot, sequence| Frame {
        header: Header { version: 1, sender, boot, sequence },
        message: Message::Hello(Hello { min: 1, current: 1, software: [0, 1, 2], epoch: Epoch(300) }),
    };
    [
        // Before COBS: 01 | 00 | 0000 | 00000000 | 00000000 | 00 01 01 000102 AC02 | CRC-32 18591D50.
        (
            frame(DeviceId::Coordinator, BootEpoch(0), Sequence(0)),
            "00 | 02 01 01 01 01 01 01 01 01 01 01 01 01 03 01 01 09 01 02 AC 02 18 59 1D 50 | 00",
        ),
        // Before COBS: 01 | 01 | 0700 | 03000000 | 01000000 | 00 01 01 000102 AC02 | CRC-32 B92BBCD4.
        (
            frame(DeviceId::Pile(PileId(7)), BootEpoch(3), Sequence(1)),
            "00 | 04 01 01 07 02 03 01 01 02 01 01 01 01 03 01 01 09 01 02 AC 02 B9 2B BC D4 | 00",
        ),
        // Before COBS: 01 | 02 | 3412 | 78563412 | F0DEBC9A | 00 01 01 000102 AC02 | CRC-32 6B2F6B2B.
        (
            frame(DeviceId::Robot(RobotId(0x1234)), BootEpoch(0x1234_5678), Sequence(0x9ABC_DEF0)),
            "00 | 0D 01 02 34 12 78 56 34 12 F0 DE BC 9A 03 01 01 09 01 02 AC 02 6B 2F 6B 2B | 00",
        ),
        // Before COBS: 01 | 03 | 0700 | 03000000 | 01000000 | 00 01 01 000102 AC02 | CRC-32 482D08A0.
        (
            frame(DeviceId::Chassis(RobotId(7)), BootEpoch(3), Sequence(1)),
            "00 | 04 01 03 07 02 03 01 01 02 01 01 01 01 03 01 01 09 01 02 AC 02 48 2D 08 A0 | 00",
        ),
    ]
}

/// What a device is sealed with: bytes 0 to 31. What a site is: bytes 32 to 63.
pub fn keys() -> [Key; 2] {
    [0, 32].map(|first: u8| Key::new(core::array::from_fn(|at| first + at as u8)))
}

/// Sealed frames: pile 7 in its start 3 and the coordinator in its start 5 find each other, and go
/// on. In front of each: over what its MAC is computed, the receiver first.
pub fn conversation() -> [(Frame, Recipient, &'static str); 5] {
    let (pile, coordinator) = (DeviceId::Pile(PileId(7)), DeviceId::Coordinator);
    let from_pile =
        |sequence| Header { version: 1, sender: pile, boot: BootEpoch(3), sequence: Sequence(sequence) };
    let from_coordinator = |sequence| Header {
        version: 1,
        sender: coordinator,
        boot: BootEpoch(5),
        sequence: Sequence(sequence),
    };
    let hello = Message::Hello(Hello { min: 1, current: 1, software: [0, 1, 2], epoch: Epoch(300) });
    let asked_at = Millis(1_000);
    let asked = Message::TimeRequest(TimeRequest { asked_at });
    let told = Message::TimeSync(TimeSync { asked_at, site_now: SiteMillis(250_000) });
    let gossip = Message::PileTable(PileTable { rows: Vec::new() });
    let (to_coordinator, to_pile) = (Recipient::Device(coordinator), Recipient::Device(pile));
    [
        // 00 0000 00000000 | 01 41 0700 03000000 00000000 | 00 01 01 000102 AC02
        (
            Frame { header: from_pile(0), message: hello.clone() },
            to_coordinator,
            "00 | 04 01 41 07 02 03 01 01 01 01 01 01 01 03 01 01 06 01 02 AC 02 \
             0A 13 D8 7C F8 5A F4 5D 6E FC F7 23 D1 DF 4F 26 02 EB 5E 10 | 00",
        ),
        // 01 0700 00000000 | 01 40 0000 05000000 00000000 | 00 01 01 000102 AC02
        (
            Frame { header: from_coordinator(0), message: hello },
            to_pile,
            "00 | 03 01 40 01 02 05 01 01 01 01 01 01 01 03 01 01 06 01 02 AC 02 F8 13 1E \
             5A 63 12 11 27 B0 4D 30 C3 4F 0A 3E 1A 27 2D 12 FF | 00",
        ),
        // 00 0000 05000000 | 01 41 0700 03000000 01000000 | 06 E807
        (
            Frame { header: from_pile(1), message: asked },
            to_coordinator,
            "00 | 04 01 41 07 02 03 01 01 02 01 01 01 18 06 E8 07 \
             A6 3C E8 D8 61 B8 32 B6 62 72 41 51 41 9C 74 95 91 88 7A 11 | 00",
        ),
        // 01 0700 03000000 | 01 40 0000 05000000 01000000 | 07 E807 90A10F
        (
            Frame { header: from_coordinator(1), message: told },
            to_pile,
            "00 | 03 01 40 01 02 05 01 01 02 01 01 01 1B 07 E8 07 90 A1 0F \
             E9 EA 1F 02 F8 96 2A 04 DC EF 64 BB 76 07 F4 3F 66 71 A6 15 | 00",
        ),
        // FF FFFF 00000000 | 01 81 0700 03000000 00000000 | 02 00
        (
            Frame { header: from_pile(0), message: gossip },
            Recipient::Piles,
            "00 | 04 01 81 07 02 03 01 01 01 01 01 01 02 02 05 \
             5D DF 5A E5 10 3C 81 50 3E 02 0F E8 3C 61 C1 EE 2B 57 F0 83 | 00",
        ),
    ]
}
