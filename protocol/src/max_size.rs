//! How large a message can get, computed from its parts.
//!
//! Every type on the wire has a [`MaxSize`]. Those of the messages are summed up below from lists of
//! their fields and variants. Each list is checked against its type by a pattern without `..`: who
//! adds a field or a variant and forgets it here gets a compiler error, not a frame that is too
//! large. That the sums are exact is tested with the largest value of every message.

use heapless::Vec;

#[allow(clippy::wildcard_imports, reason = "this is a table of all of them")]
use crate::message::*;

/// A type with a largest postcard encoding.
pub trait MaxSize {
    /// Bytes of that encoding.
    const MAX_SIZE: usize;
}

/// Bytes of `value` as a postcard varint: seven bits a byte.
#[must_use]
pub const fn varint(value: u64) -> usize {
    // Zero takes a byte too.
    (u64::BITS - (value | 1).leading_zeros()).div_ceil(7) as usize
}

macro_rules! primitives {
    ($($type:ty: $size:expr;)*) => {$(
        impl MaxSize for $type {
            const MAX_SIZE: usize = $size;
        }
    )*};
}

primitives! {
    bool: 1;
    u8: 1;
    i8: 1;
    u16: varint(u16::MAX as u64);
    u32: varint(u32::MAX as u64);
    f32: 4;
}

impl<T: MaxSize, const N: usize> MaxSize for [T; N] {
    const MAX_SIZE: usize = N * T::MAX_SIZE;
}

impl<T: MaxSize> MaxSize for Option<T> {
    const MAX_SIZE: usize = 1 + T::MAX_SIZE;
}

impl<T: MaxSize, const N: usize> MaxSize for Vec<T, N> {
    const MAX_SIZE: usize = varint(N as u64) + N * T::MAX_SIZE;
}

/// The size of the part that `_part` finds, whose type the compiler infers.
const fn of<Whole, Part: MaxSize>(_part: fn(&Whole) -> Option<&Part>) -> usize {
    Part::MAX_SIZE
}

const fn largest(sizes: &[usize]) -> usize {
    match sizes {
        [] => 0,
        [first, rest @ ..] => {
            let rest = largest(rest);
            if *first > rest { *first } else { rest }
        }
    }
}

/// A struct takes the sum of its fields.
macro_rules! structs {
    ($($name:ident { $($field:ident),* })*) => {$(
        impl MaxSize for $name {
            const MAX_SIZE: usize = {
                let _complete: fn(&Self) = |$name { $($field: _),* }| ();
                0 $(+ of(|whole: &Self| Some(&whole.$field)))*
            };
        }
    )*};
}

/// An enum takes its ordinal and the largest of its variants. A variant's fields are listed like a
/// struct's; the one of a tuple variant is called `0`.
macro_rules! enums {
    ($($name:ident { $($variant:ident $({ $($field:tt),* })?),* })*) => {$(
        impl MaxSize for $name {
            const MAX_SIZE: usize = {
                let _complete: fn(&Self) = |whole| match whole {
                    $($name::$variant { $($($field: _),*)? } => (),)*
                };
                let variants = [$(0 $($(+ of(|whole: &Self| match whole {
                    $name::$variant { $field: part } => Some(part),
                    _ => None,
                }))*)?),*];
                varint(variants.len() as u64 - 1) + largest(&variants)
            };
        }
    )*};
}

enums! {
    Message {
        Hello { 0 },
        PileState { 0 },
        PileTable { 0 },
        Grant { 0 },
        Revoke { 0 },
        PassReport { 0 },
        TimeRequest { 0 },
        TimeSync { 0 },
        Ack { 0 },
        Nack { 0 },
        Fault { 0 },
        RobotState { 0 },
        ChargeRequest { 0 },
        Assignment { 0 },
        Unassigned { 0 },
        Drive { 0 },
        Stop { 0 },
        Release { 0 },
        Task { 0 },
        TaskEnergy { 0 },
        Odometry { 0 },
        ChassisState { 0 },
        PileReadings { 0 },
        ChargeReport { 0 },
        Query { 0 },
        PileFaults { 0 },
        PendingPasses { 0 },
        PileParameters { 0 },
        ClearFault { 0 },
        Provision { 0 },
        Rescue { 0 },
        RescueState { 0 },
        ClaimPile { 0 },
        ClaimRule { 0 }
    }
    Availability { Free, Reserved, Charging, Done, Fault }
    EndReason { Completed, Expired, Revoked, RobotLeft, Fault }
    Reference { Command { 0 }, Report { 0 }, Claim { 0 } }
    NackReason {
        StaleEpoch { highest },
        TooLate,
        ClockUnknown,
        Held { by },
        Occupied,
        Faulted,
        Ended,
        Chassis { refusal },
        NotCleared,
        Provisioned,
        NotClaimable
    }
    FaultCode {
        ReaderSilent,
        ContactorWelded,
        ContactorStuckOpen,
        OverCurrent,
        OverVoltage,
        OverTemperature,
        ReversedPolarity,
        StrayCurrent,
        VoltageSensor,
        CurrentSensor,
        TemperatureSensor,
        EmergencyStop,
        MainsLost,
        StoreFailed
    }
    Topic { State, Faults, Passes, Table, Parameters }
    Activity { Working, Waiting, Approaching, Docked, Stranded, Charging }
    UnassignedReason { AllTaken, OutOfReach, Withdrawn }
    RescuePhase { Driving, Charging, Done, GaveUp }
    ChassisRefusal {
        ForwardSpeed,
        SidewaysSpeed,
        TurnRate,
        TimeToLive,
        Stopped { by },
        Moving,
        NotCleared,
        TooManyTasks
    }
    StopReason {
        Started,
        Watchdog,
        Commanded,
        LinkSilent,
        LinkCorrupted,
        Emergency,
        DriverFault,
        EncoderStuck,
        WheelStalled
    }
    ChassisMode { Braked, Driving, Stopping }
    Wheel { RearLeft, FrontLeft, FrontRight, RearRight }
    ChassisFault {
        Driver { wheel },
        EncoderStuck { wheel },
        Stalled { wheel },
        Slipping,
        GyroSilent,
        BatterySilent
    }
}

structs! {
    Hello { min, current, software, epoch }
    PileRow { pile, boot, version, stamp, availability, remaining, planned }
    PileState { row, elapsed, holder, energised, ended, standing, current }
    PileTable { rows }
    LeaseRef { epoch, lease, robot }
    EndedLease { lease, reason, charged }
    CommandHead { id, valid_until }
    Grant { head, lease, tag, expiry, energy }
    Revoke { head, lease }
    PassCount { tag, period, passes }
    PassReport { report, passes }
    TimeRequest { asked_at }
    TimeSync { asked_at, site_now }
    Ack { of }
    Nack { of, reason }
    Fault { report, code, active }
    Position { x, y }
    RobotState { position, energy, activity, accepted }
    ChargeRequest { request, position, energy, task, priority }
    Assignment { request, pile, total, first, waypoints }
    Unassigned { request, reason }
    Twist { vx, vy, wz }
    Pose { x, y, yaw }
    PoseCovariance { xx, xy, xyaw, yy, yyaw, yawyaw }
    TwistVariance { vx, vy, wz }
    Drive { command, ttl, twist }
    Stop { command, emergency }
    Release { command }
    Task { command, task }
    TaskEnergy { task, runs, last, mean }
    Odometry { stamp, pose, pose_covariance, measured, measured_variance, ramped, commanded }
    BatteryState { voltage, current, energy }
    ChassisState { mode, stop, faults, battery, discarded }
    PileReadings {
        voltage,
        current,
        temperature,
        current_limit,
        contactor_closed,
        mated,
        emergency_stop,
        mains
    }
    ChargeReport { report, lease, tag, reason, began, ended, charged, energy }
    Query { topic }
    FaultState { code, active, latched }
    PileFaults { faults }
    PendingPasses { passes }
    PendingPass { tag, period, passes }
    PileParameters {
        power,
        eta,
        voltage_max,
        current_max,
        derate_from,
        stop_at,
        dock_enter_dbm,
        dock_leave_dbm
    }
    ClearFault { command, code }
    Provision { command, pile, device_key, site_key, boot_floor, parameters }
    Rescue { rescue, robot, energy, total, first, waypoints }
    RescueState { rescue, phase, given }
    ClaimPile { request, pile, boot, version, tag, energy, within }
    ClaimRule { allowed }
    ClaimRef { robot, request }
}
