//! Every message, every header and every noise there can be.

use heapless::Vec;
use proptest::{
    collection::vec,
    option,
    prelude::*,
    sample::{Index, select},
};
use protocol::*;

/// Any number of a type, of any size: half of them small.
macro_rules! ids {
    ($($function:ident: $name:ident($inner:ty);)*) => {$(
        fn $function() -> impl Strategy<Value = $name> {
            prop_oneof![0..=3 as $inner, any::<$inner>()].prop_map($name)
        }
    )*};
}

ids! {
    pile: PileId(u16);
    robot: RobotId(u16);
    lease_id: LeaseId(u32);
    epoch: Epoch(u32);
    boot: BootEpoch(u32);
    sequence: Sequence(u32);
    command: CommandId(u32);
    request: RequestId(u32);
    task: TaskId(u16);
}

/// Any value in range, both ends included.
macro_rules! quantities {
    ($($function:ident: $name:ident;)*) => {$(
        fn $function() -> impl Strategy<Value = $name> {
            let range = $name::MIN.get()..=$name::MAX.get();
            prop_oneof![Just(*range.start()), Just(*range.end()), range].prop_map(|value| $name::new(value).unwrap())
        }
    )*};
}

quantities! {
    energy: EnergyJ;
    fraction: Fraction;
    speed: SpeedMps;
    turn_rate: TurnRateRadps;
    angle: AngleRad;
    covariance: Covariance;
    voltage: VoltageV;
    current: CurrentA;
    power: PowerW;
    temperature: TemperatureC;
    coordinate: CoordinateM;
}

macro_rules! times {
    ($($function:ident: $name:ident;)*) => {$(
        fn $function() -> impl Strategy<Value = $name> {
            prop_oneof![Just($name::MAX), (0..=$name::MAX.0).prop_map($name)]
        }
    )*};
}

times! {
    millis: Millis;
    site_millis: SiteMillis;
    duration: DurationMs;
}

prop_compose! {
    fn tag()(bytes: [u8; 12]) -> TagId { TagId(bytes) }
}

prop_compose! {
    fn report()(boot in boot(), number: u32) -> ReportId { ReportId { boot, number } }
}

prop_compose! {
    fn lease()(epoch in epoch(), lease in lease_id(), robot in robot()) -> LeaseRef {
        LeaseRef { epoch, lease, robot }
    }
}

prop_compose! {
    fn position()(x in coordinate(), y in coordinate()) -> Position { Position { x, y } }
}

prop_compose! {
    fn head()(id in command(), valid_until in site_millis()) -> CommandHead {
        CommandHead { id, valid_until }
    }
}

prop_compose! {
    fn row()(
        pile in pile(), boot in boot(), version: u32, stamp in option::of(site_millis()),
        availability in select(&[
            Availability::Free, Availability::Reserved, Availability::Charging, Availability::Done,
            Availability::Fault,
        ][..]),
        remaining in fraction(), planned in duration(),
    ) -> PileRow {
        PileRow { pile, boot, version, stamp, availability, remaining, planned }
    }
}

fn end_reason() -> impl Strategy<Value = EndReason> {
    use EndReason::*;
    select(&[Completed, Expired, Revoked, RobotLeft, Fault][..])
}

prop_compose! {
    fn ended()(
        lease in lease(),
        reason in end_reason(),
        charged in duration(),
    ) -> EndedLease {
        EndedLease { lease, reason, charged }
    }
}

prop_compose! {
    fn pass_count()(tag in tag(), period: u16, passes: u32) -> PassCount {
        PassCount { tag, period, passes }
    }
}

prop_compose! {
    fn pending_pass()(tag in tag(), period: Option<u16>, passes: u32) -> PendingPass {
        PendingPass { tag, period, passes }
    }
}

/// As many as a message takes, or fewer.
fn some<T: Clone + core::fmt::Debug, const N: usize>(
    item: impl Strategy<Value = T>,
) -> impl Strategy<Value = Vec<T, N>> {
    vec(item, 0..=N).prop_map(|items| items.into_iter().collect())
}

fn reference() -> impl Strategy<Value = Reference> {
    prop_oneof![
        command().prop_map(Reference::Command),
        report().prop_map(Reference::Report),
        (robot(), request()).prop_map(|(robot, request)| Reference::Claim(ClaimRef { robot, request })),
    ]
}

fn nack_reason() -> impl Strategy<Value = NackReason> {
    prop_oneof![
        epoch().prop_map(|highest| NackReason::StaleEpoch { highest }),
        lease().prop_map(|by| NackReason::Held { by }),
        select(
            &[
                NackReason::TooLate,
                NackReason::ClockUnknown,
                NackReason::Occupied,
                NackReason::Faulted,
                NackReason::Ended,
                NackReason::NotCleared,
                NackReason::Provisioned,
                NackReason::NotClaimable
            ][..]
        ),
        chassis_refusal().prop_map(|refusal| NackReason::Chassis { refusal }),
    ]
}

fn activity() -> impl Strategy<Value = Activity> {
    use Activity::*;
    select(&[Working, Waiting, Approaching, Docked, Stranded, Charging][..])
}

fn stop_reason() -> impl Strategy<Value = StopReason> {
    use StopReason::*;
    select(
        &[
            Started,
            Watchdog,
            Commanded,
            LinkSilent,
            LinkCorrupted,
            Emergency,
            DriverFault,
            EncoderStuck,
            WheelStalled,
        ][..],
    )
}

fn chassis_refusal() -> impl Strategy<Value = ChassisRefusal> {
    use ChassisRefusal::*;
    let bare = [ForwardSpeed, SidewaysSpeed, TurnRate, TimeToLive, Moving, NotCleared, TooManyTasks];
    prop_oneof![select(bare.to_vec()), stop_reason().prop_map(|by| Stopped { by })]
}

fn chassis_fault() -> impl Strategy<Value = ChassisFault> {
    use {ChassisFault::*, Wheel::*};
    let wheel = || select(&[RearLeft, FrontLeft, FrontRight, RearRight][..]);
    prop_oneof![
        wheel().prop_map(|wheel| Driver { wheel }),
        wheel().prop_map(|wheel| EncoderStuck { wheel }),
        wheel().prop_map(|wheel| Stalled { wheel }),
        select(&[Slipping, GyroSilent, BatterySilent][..]),
    ]
}

prop_compose! {
    fn twist()(vx in speed(), vy in speed(), wz in turn_rate()) -> Twist { Twist { vx, vy, wz } }
}

prop_compose! {
    fn pose()(x in coordinate(), y in coordinate(), yaw in angle()) -> Pose { Pose { x, y, yaw } }
}

prop_compose! {
    fn pose_covariance()(
        xx in covariance(), xy in covariance(), xyaw in covariance(), yy in covariance(),
        yyaw in covariance(), yawyaw in covariance(),
    ) -> PoseCovariance {
        PoseCovariance { xx, xy, xyaw, yy, yyaw, yawyaw }
    }
}

prop_compose! {
    fn twist_variance()(vx in covariance(), vy in covariance(), wz in covariance()) -> TwistVariance {
        TwistVariance { vx, vy, wz }
    }
}

prop_compose! {
    fn odometry()(
        stamp in millis(), pose in pose(), pose_covariance in pose_covariance(), measured in twist(),
        measured_variance in twist_variance(), ramped in twist(), commanded in twist(),
    ) -> Odometry {
        Odometry { stamp, pose, pose_covariance, measured, measured_variance, ramped, commanded }
    }
}

prop_compose! {
    fn battery()(voltage in voltage(), current in current(), energy in energy()) -> BatteryState {
        BatteryState { voltage, current, energy }
    }
}

prop_compose! {
    fn chassis_state()(
        mode in select(&[ChassisMode::Braked, ChassisMode::Driving, ChassisMode::Stopping][..]),
        stop in option::of(stop_reason()), faults in some(chassis_fault()),
        battery in option::of(battery()), discarded: u32,
    ) -> ChassisState {
        ChassisState { mode, stop, faults, battery, discarded }
    }
}

/// What a robot's computer and its chassis say to each other.
fn driving() -> impl Strategy<Value = Message> {
    prop_oneof![
        (command(), duration(), twist()).prop_map(|(command, ttl, twist)| Message::Drive(Drive {
            command,
            ttl,
            twist
        })),
        (command(), any::<bool>())
            .prop_map(|(command, emergency)| Message::Stop(Stop { command, emergency })),
        command().prop_map(|command| Message::Release(Release { command })),
        (command(), option::of(task())).prop_map(|(command, task)| Message::Task(Task { command, task })),
        (task(), any::<u32>(), energy(), energy())
            .prop_map(|(task, runs, last, mean)| Message::TaskEnergy(TaskEnergy { task, runs, last, mean })),
        odometry().prop_map(Message::Odometry),
        chassis_state().prop_map(Message::ChassisState),
    ]
}

/// What piles, robots and the coordinator say to each other.
fn site() -> impl Strategy<Value = Message> {
    use UnassignedReason::*;
    prop_oneof![
        (any::<(u8, u8, [u8; 3])>(), epoch()).prop_map(|((min, current, software), epoch)| Message::Hello(
            Hello { min, current, software, epoch }
        )),
        (
            (row(), duration(), option::of(lease()), any::<bool>(), option::of(ended())),
            option::of(tag()),
            option::of(current())
        )
            .prop_map(|((row, elapsed, holder, energised, ended), standing, current)| {
                Message::PileState(PileState { row, elapsed, holder, energised, ended, standing, current })
            }),
        some(row()).prop_map(|rows| Message::PileTable(PileTable { rows })),
        (head(), lease(), tag(), site_millis(), energy()).prop_map(|(head, lease, tag, expiry, energy)| {
            Message::Grant(Grant { head, lease, tag, expiry, energy })
        }),
        (head(), lease()).prop_map(|(head, lease)| Message::Revoke(Revoke { head, lease })),
        (report(), some(pass_count()))
            .prop_map(|(report, passes)| Message::PassReport(PassReport { report, passes })),
        millis().prop_map(|asked_at| Message::TimeRequest(TimeRequest { asked_at })),
        (millis(), site_millis())
            .prop_map(|(asked_at, site_now)| Message::TimeSync(TimeSync { asked_at, site_now })),
        reference().prop_map(|of| Message::Ack(Ack { of })),
        (reference(), nack_reason()).prop_map(|(of, reason)| Message::Nack(Nack { of, reason })),
        (report(), select(&FaultCode::ALL[..]), any::<bool>())
            .prop_map(|(report, code, active)| Message::Fault(Fault { report, code, active })),
        (position(), energy(), activity(), option::of(request())).prop_map(
            |(position, energy, activity, accepted)| Message::RobotState(RobotState {
                position,
                energy,
                activity,
                accepted
            })
        ),
        (request(), position(), energy(), option::of(any::<u16>().prop_map(TaskId)), 0u8..=10).prop_map(
            |(request, position, energy, task, priority)| {
                let priority = TaskPriority::new(priority).unwrap();
                Message::ChargeRequest(ChargeRequest { request, position, energy, task, priority })
            }
        ),
        (request(), pile(), any::<(u16, u16)>(), some(position())).prop_map(
            |(request, pile, (total, first), waypoints)| Message::Assignment(Assignment {
                request,
                pile,
                total,
                first,
                waypoints
            })
        ),
        (request(), select(&[AllTaken, OutOfReach, Withdrawn][..]))
            .prop_map(|(request, reason)| Message::Unassigned(Unassigned { request, reason })),
    ]
}

prop_compose! {
    fn readings()(
        voltage in option::of(voltage()), current in option::of(current()),
        temperature in option::of(temperature()), current_limit in current(), contactor_closed: bool,
        mated: bool, emergency_stop: bool, mains: bool,
    ) -> PileReadings {
        PileReadings {
            voltage, current, temperature, current_limit, contactor_closed, mated, emergency_stop, mains,
        }
    }
}

prop_compose! {
    fn charge_report()(
        report in report(), lease in lease(), tag in tag(), reason in end_reason(), began in site_millis(),
        ended in option::of(site_millis()), charged in duration(), energy in energy(),
    ) -> ChargeReport {
        ChargeReport { report, lease, tag, reason, began, ended, charged, energy }
    }
}

prop_compose! {
    fn parameters()(
        power in power(), eta in duration(), voltage_max in voltage(), current_max in current(),
        derate_from in temperature(), stop_at in temperature(), dock_enter_dbm: i8, dock_leave_dbm: i8,
    ) -> PileParameters {
        PileParameters {
            power, eta, voltage_max, current_max, derate_from, stop_at, dock_enter_dbm, dock_leave_dbm,
        }
    }
}

prop_compose! {
    fn provision()(
        command in command(), pile in pile(), device_key: [u8; 32], site_key: [u8; 32],
        boot_floor in boot(), parameters in parameters(),
    ) -> Provision {
        let (device_key, site_key) = (Key::new(device_key), Key::new(site_key));
        Provision { command, pile, device_key, site_key, boot_floor, parameters }
    }
}

/// What a pile and the tool at its desk say to each other, and what a pile tells of a charge.
fn service() -> impl Strategy<Value = Message> {
    use Topic::*;
    let fault = (select(&FaultCode::ALL[..]), any::<(bool, bool)>())
        .prop_map(|(code, (active, latched))| FaultState { code, active, latched });
    prop_oneof![
        readings().prop_map(Message::PileReadings),
        charge_report().prop_map(Message::ChargeReport),
        select(&[State, Faults, Passes, Table, Parameters][..])
            .prop_map(|topic| Message::Query(Query { topic })),
        some(fault).prop_map(|faults| Message::PileFaults(PileFaults { faults })),
        some(pending_pass()).prop_map(|passes| Message::PendingPasses(PendingPasses { passes })),
        parameters().prop_map(Message::PileParameters),
        (command(), select(&FaultCode::ALL[..]))
            .prop_map(|(command, code)| Message::ClearFault(ClearFault { command, code })),
        provision().prop_map(Message::Provision),
        (request(), pile(), any::<(u32, u32)>(), tag(), energy(), duration()).prop_map(
            |(request, pile, (boot, version), tag, energy, within)| Message::ClaimPile(ClaimPile {
                request,
                pile,
                boot: BootEpoch(boot),
                version,
                tag,
                energy,
                within
            })
        ),
        any::<bool>().prop_map(|allowed| Message::ClaimRule(ClaimRule { allowed })),
    ]
}

/// What mobile chargers and the coordinator say to each other.
fn rescue() -> impl Strategy<Value = Message> {
    use RescuePhase::*;
    let sent = (command(), robot(), energy(), any::<(u16, u16)>(), some(position()));
    prop_oneof![
        sent.prop_map(|(rescue, robot, energy, (total, first), waypoints)| Message::Rescue(Rescue {
            rescue,
            robot,
            energy,
            total,
            first,
            waypoints
        })),
        (command(), select(&[Driving, Charging, Done, GaveUp][..]), energy())
            .prop_map(|(rescue, phase, given)| Message::RescueState(RescueState { rescue, phase, given })),
    ]
}

/// Every message.
pub fn message() -> impl Strategy<Value = Message> {
    // Boxed: together their trees of values are too large for a test's stack.
    prop_oneof![2 => site().boxed(), 1 => driving().boxed(), 1 => service().boxed(), 1 => rescue().boxed()]
}

/// Everyone.
pub fn device() -> impl Strategy<Value = DeviceId> {
    prop_oneof![
        Just(DeviceId::Coordinator),
        pile().prop_map(DeviceId::Pile),
        robot().prop_map(DeviceId::Robot),
        robot().prop_map(DeviceId::Chassis),
        Just(DeviceId::Service),
        Just(DeviceId::Factory)
    ]
}

prop_compose! {
    /// Every frame of the current version.
    pub fn frame()(sender in device(), boot in boot(), sequence in sequence(), message in message()) -> Frame {
        Frame { header: Header::new(sender, boot, sequence), message }
    }
}

/// Noise: any bytes, with more delimiters among them than chance would give.
pub fn noise() -> impl Strategy<Value = std::vec::Vec<u8>> {
    vec(prop_oneof![1 => Just(0), 9 => any::<u8>()], 0..2 * limits::FRAME)
}

/// Noise without a delimiter.
pub fn dirt() -> impl Strategy<Value = std::vec::Vec<u8>> {
    vec(1..=u8::MAX, 0..2 * limits::FRAME)
}

/// Places in a stream.
pub fn places() -> impl Strategy<Value = std::vec::Vec<Index>> {
    vec(any::<Index>(), 0..8)
}
