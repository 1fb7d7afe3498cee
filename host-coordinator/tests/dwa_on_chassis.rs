//! The planner's chassis and the board's are one: what the dynamic window approach asks for, the real ramp
//! takes up in time, without clipping.
#![allow(clippy::unwrap_used)]

use firmware_chassis::{
    TICK_S, Velocity as BoardVelocity,
    kinematics::Kinematics,
    limits,
    parameters::Parameters,
    ramp::{INCREMENT_MPS, Ramp, RampRule},
};
use planning::{
    dwa::{Chassis, Command, Dwa, Obstacles, Pose, Progress, Route, Velocity},
    formats::movingai::read_map,
    moves::MoveSet,
    search::{AStar, Planner, Workspace},
};
use protocol::RobotId;

const CHASSIS: Chassis = Chassis::PAPER;

#[test]
fn the_planners_chassis_has_the_boards_limits() {
    let Parameters { geometry, limits, .. } = Parameters::new(RobotId(1));
    let board = [geometry.lever_arm_m(), INCREMENT_MPS, TICK_S, limits.forward_mps, limits.sideways_mps];
    let board = [board.as_slice(), &[limits.turn_radps, limits.wheel_mps]].concat();
    let Chassis { arm_m, increment_mps, tick_s, forward_mps, sideways_mps, turn_radps, wheel_mps } = CHASSIS;
    let planner = [arm_m, increment_mps, tick_s, forward_mps, sideways_mps, turn_radps, wheel_mps];
    assert_eq!(planner.map(|value| value as f32).as_slice(), board);
}

#[test]
fn the_boards_ramp_takes_up_every_command_by_the_next_and_slows_none_down() {
    let rows = [
        "....................",
        ".......@@@..........",
        "....@..@@@....@.....",
        "....@.........@.....",
        "....@.....@...@.....",
        "..........@.........",
    ];
    let grid = read_map(&format!("type octile\nheight 6\nwidth 20\nmap\n{}\n", rows.join("\n"))).unwrap();
    let mut workspace = Workspace::default();
    let planner = AStar::new(&grid, MoveSet::Eight);
    let path = planner.plan((0, 5).into(), (19, 5).into(), &mut workspace).unwrap().path;
    let obstacles = Obstacles { grid: &grid, cell_m: 0.5 };
    let route = Route::new(path, &obstacles);
    let Parameters { geometry, limits, .. } = Parameters::new(RobotId(1));
    let kinematics = Kinematics::new(geometry.wheelbase_m, geometry.track_m);
    let (dwa, mut ramp) = (Dwa::default(), Ramp::new(RampRule::Together));
    let (mut pose, mut progress) = (Pose { at: route.at(0.0), heading_rad: 0.0 }, Progress::default());
    let mut commands = 0;
    loop {
        // The board's own velocity is what the planner goes on from.
        let now = kinematics.twist(ramp.setpoints());
        let velocity =
            Velocity { forward_mps: now.x.into(), left_mps: now.y.into(), turn_radps: now.z.into() };
        let command;
        (command, progress) = dwa.step(&route, &obstacles, &[], (pose, velocity), progress);
        let Command::Drive(wanted) = command else {
            assert_eq!(command, Command::Arrived);
            break;
        };
        commands += 1;
        assert!(commands < 1_000);
        let wanted = [wanted.forward_mps, wanted.left_mps, wanted.turn_radps].map(|value| value as f32);
        assert!(wanted[0].abs() <= limits.forward_mps && wanted[1].abs() <= limits.sideways_mps);
        assert!(wanted[2].abs() <= limits.turn_radps);
        let target = kinematics.wheels(&BoardVelocity::from(wanted));
        assert!((limits::slow_down(&limits, target) - target).amax() < 1e-6, "slowed down: {target}");
        for _ in 0..dwa.ticks {
            ramp.advance(&target);
            let now = kinematics.twist(ramp.setpoints());
            let now =
                Velocity { forward_mps: now.x.into(), left_mps: now.y.into(), turn_radps: now.z.into() };
            pose = pose.moved(now, CHASSIS.tick_s);
            assert!(obstacles.clearance_m(pose.at, 1.0) >= dwa.radius_m);
        }
        assert_eq!(ramp.setpoints(), &target, "not taken up in time");
    }
    assert!(commands > 50);
}
