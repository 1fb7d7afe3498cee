//! What a chassis says, in words for a person.

use protocol::{
    ChassisFault, ChassisMode, ChassisRefusal, ChassisState, NackReason, Odometry, StopReason, Wheel,
};

/// Why a command was refused, and what to do.
#[must_use]
pub fn refusal(reason: NackReason) -> String {
    match reason {
        NackReason::Chassis { refusal } => match refusal {
            ChassisRefusal::ForwardSpeed => "vx is beyond its limit; ask for less".into(),
            ChassisRefusal::SidewaysSpeed => "vy is beyond its limit; ask for less".into(),
            ChassisRefusal::TurnRate => "wz is beyond its limit; ask for less".into(),
            ChassisRefusal::TimeToLive => {
                "its limit for a command's time to live is below 200 ms; raise that limit".into()
            }
            ChassisRefusal::Stopped { by } => {
                format!("it is held stopped because {}; see to that, then release it", stop(by))
            }
            ChassisRefusal::Moving => "its wheels still turn; wait until they stand".into(),
            ChassisRefusal::NotCleared => {
                "the cause of the stop is still there; `watch` names the fault".into()
            }
            ChassisRefusal::TooManyTasks => "it has no room for another kind of task".into(),
        },
        NackReason::TooLate => {
            "the command came after a newer one; does another program drive it too?".into()
        }
        other => format!("{other:?}, which no chassis should say; is its software the right one?"),
    }
}

/// Why it does not drive; completes "because ...".
#[must_use]
pub const fn stop(reason: StopReason) -> &'static str {
    match reason {
        StopReason::Started => "it has just started",
        StopReason::Watchdog => "its watchdog has restarted it",
        StopReason::Commanded => "it was told to stop",
        StopReason::LinkSilent => "its line went silent",
        StopReason::LinkCorrupted => "what came over its line was damaged",
        StopReason::Emergency => "of an emergency stop",
        StopReason::DriverFault => "a motor's driver reports a fault",
        StopReason::EncoderStuck => "an encoder does not count",
        StopReason::WheelStalled => "a wheel is driven and does not turn",
    }
}

/// What is wrong with it.
#[must_use]
pub fn fault(fault: ChassisFault) -> String {
    match fault {
        ChassisFault::Driver { wheel } => format!("fault of the {} motor's driver", name(wheel)),
        ChassisFault::EncoderStuck { wheel } => format!("{} encoder does not count", name(wheel)),
        ChassisFault::Stalled { wheel } => format!("{} wheel does not turn", name(wheel)),
        ChassisFault::Slipping => "a wheel slips".into(),
        ChassisFault::GyroSilent => "gyroscope silent".into(),
        ChassisFault::BatterySilent => "battery not measured".into(),
    }
}

/// What it does, and why it does not drive.
#[must_use]
pub fn standing(state: &ChassisState) -> String {
    let mode = match state.mode {
        ChassisMode::Braked => "braked",
        ChassisMode::Driving => "driving",
        ChassisMode::Stopping => "stopping",
    };
    state.stop.map_or_else(|| mode.into(), |reason| format!("{mode} because {}", stop(reason)))
}

/// A status line.
#[must_use]
pub fn status(odometry: &Odometry, state: Option<&ChassisState>) -> String {
    let (v, p) = (odometry.measured, odometry.pose);
    let mut line = format!(
        "vx {:+.3} m/s  vy {:+.3} m/s  wz {:+.3} rad/s  at {:+.2}, {:+.2} m, {:+.2} rad",
        v.vx.get(),
        v.vy.get(),
        v.wz.get(),
        p.x.get(),
        p.y.get(),
        p.yaw.get()
    );
    if let Some(state) = state {
        line += &format!("  {}", standing(state));
        line.extend(state.battery.map(|battery| {
            format!(
                "  {:.1} V {:.1} A {:.0} kJ",
                battery.voltage.get(),
                battery.current.get(),
                battery.energy.get() / 1e3
            )
        }));
        line.extend(state.faults.iter().map(|&it| format!("  ! {}", fault(it))));
    }
    line
}

const fn name(wheel: Wheel) -> &'static str {
    match wheel {
        Wheel::RearLeft => "rear left",
        Wheel::FrontLeft => "front left",
        Wheel::FrontRight => "front right",
        Wheel::RearRight => "rear right",
    }
}
