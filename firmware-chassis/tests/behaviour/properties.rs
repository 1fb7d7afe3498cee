//! What holds whatever is commanded, sensed and lost.

use firmware_chassis::{
    BatterySample, Chassis, Input, Messages, Motors, Parameters, Sensors, Velocity, WheelSpeeds,
    ramp::RampRule,
};
use proptest::{collection::vec, num::f32::ANY, prelude::*, sample::select};
use protocol::*;

use crate::bench::{Bench, Outputs, ROBOT, ROUNDING_MPS};

/// The paper's increment.
const INCREMENT_MPS: f32 = 0.01;

#[derive(Clone, Debug)]
enum Event {
    Tick(u8),
    /// Ticks that come late by so many periods.
    Gap(u8),
    Drive {
        command: u32,
        ttl: u32,
        twist: [f32; 3],
    },
    Stop {
        command: u32,
        emergency: bool,
    },
    Release {
        command: u32,
    },
    Task {
        command: u32,
        task: Option<u16>,
    },
    Damage,
    /// Something in the world breaks or is mended.
    Stick(usize),
    Block(usize),
    Fault(usize),
    Slip(usize),
}

/// Numbers of commands that mostly grow, so that most are new and some repeated or late.
fn events() -> impl Strategy<Value = Vec<Event>> {
    let twist = prop_oneof![
        6 => prop::array::uniform3(-1.0f32..1.0),
        2 => select(vec![[0.8, 0.0, 0.0], [-0.8, 0.0, 0.0], [0.0, 0.0, 4.0], [0.0, 0.0, -4.0], [0.8, 0.8, 4.0]]),
        // NaN and infinities among them; the wire's types make the nearest quantity of these.
        1 => prop::array::uniform3(ANY),
    ];
    let ttl = prop_oneof![4 => 50u32..1_000, 1 => any::<u32>()];
    let step = prop_oneof![6 => Just(1u32), 1 => Just(0), 1 => Just(u32::MAX)];
    let event = prop_oneof![
        8 => (1u8..80).prop_map(Event::Tick),
        1 => (2u8..30).prop_map(Event::Gap),
        8 => (step.clone(), ttl, twist).prop_map(|(command, ttl, twist)| Event::Drive { command, ttl, twist }),
        1 => (step.clone(), any::<bool>()).prop_map(|(command, emergency)| Event::Stop { command, emergency }),
        2 => step.clone().prop_map(|command| Event::Release { command }),
        1 => (step, prop::option::of(0u16..20)).prop_map(|(command, task)| Event::Task { command, task }),
        1 => Just(Event::Damage),
        1 => (0usize..4).prop_map(Event::Stick),
        1 => (0usize..4).prop_map(Event::Block),
        1 => (0usize..4).prop_map(Event::Fault),
        1 => (0usize..4).prop_map(Event::Slip),
    ];
    vec(event, 1..60)
}

/// Checks a step: set-points, duties and, by encoding them, messages.
fn check(bench: &Bench, before: WheelSpeeds, outputs: &Outputs) {
    let setpoints = *bench.chassis.setpoints();
    match outputs.motors {
        // While the motors brake there is no set-point; the next ramp begins at standstill.
        Motors::Brake => assert_eq!(setpoints, WheelSpeeds::zeros()),
        Motors::Drive(duties) => {
            assert!((setpoints - before).amax() <= INCREMENT_MPS + ROUNDING_MPS, "{before} {setpoints}");
            assert!(setpoints.amax() <= ROBOT.limits.wheel_mps + ROUNDING_MPS);
            assert!(duties.iter().all(|duty| (-1.0..=1.0).contains(duty)), "{duties:?}");
        }
    }
    check_messages(&outputs.messages);
}

/// What goes out can be read again, which no NaN and nothing out of range can.
fn check_messages(messages: &[Message]) {
    assert!(messages.len() < firmware_chassis::chassis::MESSAGES_PER_STEP + 1);
    let mut sessions = Sessions::insecure(DeviceId::Chassis(ROBOT.robot), BootEpoch(1));
    let computer = Recipient::Device(DeviceId::Robot(ROBOT.robot));
    let mut deframer = Deframer::new();
    for message in messages {
        let mut found = 0;
        let bytes = sessions.seal(computer, message).unwrap();
        deframer.feed(&bytes, |packet| {
            assert_eq!(&sessions.open(packet.unwrap()).unwrap().message, message);
            found += 1;
        });
        assert_eq!(found, 1);
    }
}

fn tell(bench: &mut Bench, newest: &mut u32, event: &Event) {
    let mut number = |step: u32| {
        *newest = newest.wrapping_add(step);
        CommandId(*newest)
    };
    let before = *bench.chassis.setpoints();
    let outputs = match *event {
        Event::Tick(ticks) => {
            for _ in 0..ticks {
                let before = *bench.chassis.setpoints();
                let outputs = bench.tick();
                check(bench, before, &outputs);
            }
            return;
        }
        Event::Gap(periods) => {
            for _ in 0..periods {
                bench.sensors = bench.plant.advance(bench.motors);
                bench.now.0 += 10;
            }
            bench.step(Input::Tick(bench.sensors))
        }
        Event::Drive { command, ttl, twist: [x, y, z] } => {
            let twist =
                Twist { vx: SpeedMps::clamped(x), vy: SpeedMps::clamped(y), wz: TurnRateRadps::clamped(z) };
            bench.hear(Message::Drive(Drive { command: number(command), ttl: DurationMs(ttl), twist }))
        }
        Event::Stop { command, emergency } => {
            bench.hear(Message::Stop(Stop { command: number(command), emergency }))
        }
        Event::Release { command } => bench.hear(Message::Release(Release { command: number(command) })),
        Event::Task { command, task } => {
            bench.hear(Message::Task(Task { command: number(command), task: task.map(TaskId) }))
        }
        Event::Damage => bench.step(Input::Discarded(FrameError::Crc)),
        Event::Stick(wheel) => return toggle(&mut bench.plant.encoder_stuck[wheel]),
        Event::Block(wheel) => return toggle(&mut bench.plant.blocked[wheel]),
        Event::Fault(wheel) => return toggle(&mut bench.plant.driver_faults[wheel]),
        Event::Slip(wheel) => {
            bench.plant.grip[wheel] = 1.5 - bench.plant.grip[wheel];
            return;
        }
    };
    check(bench, before, &outputs);
}

fn toggle(broken: &mut bool) {
    *broken = !*broken;
}

fn any_sensors() -> impl Strategy<Value = Sensors> {
    let battery = (ANY, ANY).prop_map(|(voltage_v, current_a)| BatterySample { voltage_v, current_a });
    (any::<[u16; 4]>(), any::<[bool; 4]>(), prop::option::of(ANY), prop::option::of(battery)).prop_map(
        |(encoders, faults, gyro_radps, battery)| Sensors {
            encoders,
            // Rarely a fault, or it would never drive.
            driver_faults: if faults == [true; 4] { faults } else { [false; 4] },
            gyro_radps,
            battery,
        },
    )
}

proptest! {
    #[test]
    fn no_set_point_steps_by_more_than_the_increment_whatever_is_commanded(
        events in events(), ramp in select(vec![RampRule::Together, RampRule::PerWheel]),
    ) {
        let mut bench = Bench::with(Parameters { ramp, ..ROBOT });
        let mut newest = 0;
        for event in &events {
            tell(&mut bench, &mut newest, event);
        }
        // Whatever it was, left alone the robot comes to rest and says why.
        bench.wait(3.0);
        let (mode, stop) = bench.told();
        prop_assert_eq!(mode, ChassisMode::Braked);
        prop_assert!(stop.is_some());
        prop_assert_eq!(bench.plant.velocity(), &Velocity::zeros());
    }

    #[test]
    fn whatever_sensors_say_all_that_comes_out_is_in_range(
        ticks in vec((any_sensors(), 0u64..2_000, prop::array::uniform3(-0.8f32..0.8)), 1..200),
    ) {
        let mut bench = Bench::new();
        let mut newest = 100;
        for (sensors, gap, [x, y, z]) in ticks {
            newest += 1;
            bench.now.0 += gap;
            let twist =
                Twist { vx: SpeedMps::clamped(x), vy: SpeedMps::clamped(y), wz: TurnRateRadps::clamped(z) };
            bench.hear(Message::Release(Release { command: CommandId(newest) }));
            newest += 1;
            bench.hear(Message::Drive(Drive { command: CommandId(newest), ttl: DurationMs(500), twist }));
            let before = *bench.chassis.setpoints();
            let outputs = bench.step(Input::Tick(sensors));
            check(&bench, before, &outputs);
            prop_assert!(bench.chassis.velocity().iter().all(|value| value.is_finite()));
        }
    }

    #[test]
    fn a_clock_that_jumps_anywhere_stops_nothing_but_commands(times in vec(0..=Millis::MAX.0, 1..50)) {
        let mut chassis = Chassis::new(ROBOT).unwrap();
        let mut messages = Messages::new();
        for now in times {
            chassis.step(Millis(now), Input::Tick(Sensors::default()), &mut messages);
            check_messages(&messages);
        }
    }
}
