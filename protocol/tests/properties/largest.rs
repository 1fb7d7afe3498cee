//! The largest value of every message: every list full, every option there, every number the one
//! with the longest encoding.

use heapless::Vec;
use protocol::*;

const LEASE: LeaseRef =
    LeaseRef { epoch: Epoch(u32::MAX), lease: LeaseId(u32::MAX), robot: RobotId(u16::MAX) };
const HEAD: CommandHead = CommandHead { id: CommandId(u32::MAX), valid_until: SiteMillis::MAX };
const POSITION: Position = Position { x: CoordinateM::MAX, y: CoordinateM::MAX };
const TWIST: Twist = Twist { vx: SpeedMps::MAX, vy: SpeedMps::MAX, wz: TurnRateRadps::MAX };
const TAG: TagId = TagId([0xFF; 12]);
const PARAMETERS: PileParameters = PileParameters {
    power: PowerW::MAX,
    eta: DurationMs::MAX,
    voltage_max: VoltageV::MAX,
    current_max: CurrentA::MAX,
    derate_from: TemperatureC::MAX,
    stop_at: TemperatureC::MAX,
    dock_enter_dbm: i8::MAX,
    dock_leave_dbm: i8::MAX,
};
const ROW: PileRow = PileRow {
    pile: PileId(u16::MAX),
    boot: BootEpoch(u32::MAX),
    version: u32::MAX,
    stamp: Some(SiteMillis::MAX),
    availability: Availability::Fault,
    remaining: Fraction::MAX,
    planned: DurationMs::MAX,
};

fn full<T: Clone, const N: usize>(item: T) -> Vec<T, N> {
    core::iter::repeat_n(item, N).collect()
}

/// Every message with its name and [`MaxSize`].
pub fn messages() -> [(Message, &'static str, usize); 34] {
    macro_rules! sized {
        ($($name:ident($value:expr),)*) => {
            [$((Message::$name($value), stringify!($name), $name::MAX_SIZE)),*]
        };
    }
    let request = RequestId(u32::MAX);
    let report = ReportId { boot: BootEpoch(u32::MAX), number: u32::MAX };
    let command = CommandId(u32::MAX);
    let task = TaskId(u16::MAX);
    let of = Reference::Report(report);
    sized![
        Hello(Hello { min: 255, current: 255, software: [255; 3], epoch: Epoch(u32::MAX) }),
        PileState(PileState {
            row: ROW,
            elapsed: DurationMs::MAX,
            holder: Some(LEASE),
            energised: true,
            ended: Some(EndedLease { lease: LEASE, reason: EndReason::Fault, charged: DurationMs::MAX }),
            standing: Some(TAG),
            current: Some(CurrentA::MAX),
        }),
        PileTable(PileTable { rows: full(ROW) }),
        Grant(Grant { head: HEAD, lease: LEASE, tag: TAG, expiry: SiteMillis::MAX, energy: EnergyJ::MAX }),
        Revoke(Revoke { head: HEAD, lease: LEASE }),
        PassReport(PassReport {
            report,
            passes: full(PassCount { tag: TAG, period: u16::MAX, passes: u32::MAX }),
        }),
        TimeRequest(TimeRequest { asked_at: Millis::MAX }),
        TimeSync(TimeSync { asked_at: Millis::MAX, site_now: SiteMillis::MAX }),
        Ack(Ack { of }),
        Nack(Nack { of, reason: NackReason::Held { by: LEASE } }),
        Fault(Fault { report, code: FaultCode::StoreFailed, active: true }),
        RobotState(RobotState {
            position: POSITION,
            energy: EnergyJ::MAX,
            activity: Activity::Stranded,
            accepted: Some(request),
        }),
        ChargeRequest(ChargeRequest {
            request,
            position: POSITION,
            energy: EnergyJ::MAX,
            task: Some(TaskId(u16::MAX)),
            priority: TaskPriority::MAX,
        }),
        Assignment(Assignment {
            request,
            pile: PileId(u16::MAX),
            total: u16::MAX,
            first: u16::MAX,
            waypoints: full(POSITION),
        }),
        Unassigned(Unassigned { request, reason: UnassignedReason::OutOfReach }),
        Drive(Drive { command, ttl: DurationMs::MAX, twist: TWIST }),
        Stop(Stop { command, emergency: true }),
        Release(Release { command }),
        Task(Task { command, task: Some(task) }),
        TaskEnergy(TaskEnergy { task, runs: u32::MAX, last: EnergyJ::MAX, mean: EnergyJ::MAX }),
        Odometry(Odometry {
            stamp: Millis::MAX,
            pose: Pose { x: CoordinateM::MAX, y: CoordinateM::MAX, yaw: AngleRad::MAX },
            pose_covariance: PoseCovariance {
                xx: Covariance::MAX,
                xy: Covariance::MAX,
                xyaw: Covariance::MAX,
                yy: Covariance::MAX,
                yyaw: Covariance::MAX,
                yawyaw: Covariance::MAX,
            },
            measured: TWIST,
            measured_variance: TwistVariance {
                vx: Covariance::MAX,
                vy: Covariance::MAX,
                wz: Covariance::MAX,
            },
            ramped: TWIST,
            commanded: TWIST,
        }),
        ChassisState(ChassisState {
            mode: ChassisMode::Stopping,
            stop: Some(StopReason::WheelStalled),
            faults: full(ChassisFault::Stalled { wheel: Wheel::RearRight }),
            battery: Some(BatteryState {
                voltage: VoltageV::MAX,
                current: CurrentA::MAX,
                energy: EnergyJ::MAX,
            }),
            discarded: u32::MAX,
        }),
        PileReadings(PileReadings {
            voltage: Some(VoltageV::MAX),
            current: Some(CurrentA::MAX),
            temperature: Some(TemperatureC::MAX),
            current_limit: CurrentA::MAX,
            contactor_closed: true,
            mated: true,
            emergency_stop: true,
            mains: true,
        }),
        ChargeReport(ChargeReport {
            report,
            lease: LEASE,
            tag: TAG,
            reason: EndReason::Fault,
            began: SiteMillis::MAX,
            ended: Some(SiteMillis::MAX),
            charged: DurationMs::MAX,
            energy: EnergyJ::MAX,
        }),
        Query(Query { topic: Topic::Parameters }),
        PileFaults(PileFaults {
            faults: full(FaultState { code: FaultCode::StoreFailed, active: true, latched: true }),
        }),
        PendingPasses(PendingPasses {
            passes: full(PendingPass { tag: TAG, period: Some(u16::MAX), passes: u32::MAX }),
        }),
        PileParameters(PARAMETERS),
        ClearFault(ClearFault { command, code: FaultCode::StoreFailed }),
        Provision(Provision {
            command,
            pile: PileId(u16::MAX),
            device_key: Key::new([0xFF; 32]),
            site_key: Key::new([0xFF; 32]),
            boot_floor: BootEpoch(u32::MAX),
            parameters: PARAMETERS,
        }),
        Rescue(Rescue {
            rescue: command,
            robot: RobotId(u16::MAX),
            energy: EnergyJ::MAX,
            total: u16::MAX,
            first: u16::MAX,
            waypoints: full(POSITION),
        }),
        RescueState(RescueState { rescue: command, phase: RescuePhase::GaveUp, given: EnergyJ::MAX }),
        ClaimPile(ClaimPile {
            request,
            pile: PileId(u16::MAX),
            boot: BootEpoch(u32::MAX),
            version: u32::MAX,
            tag: TAG,
            energy: EnergyJ::MAX,
            within: DurationMs::MAX,
        }),
        ClaimRule(ClaimRule { allowed: true }),
    ]
}
