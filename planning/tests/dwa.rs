//! A robot that follows its route with the dynamic window approach, driven by the chassis' ramp.
#![allow(clippy::unwrap_used)]

use planning::{
    dwa::{Command, Dwa, Moving, Obstacles, Point, Pose, Progress, Route, Velocity},
    formats::movingai::read_map,
    grid::{Cell, Grid},
    moves::MoveSet,
    path::Path,
    search::{AStar, Planner, Workspace},
};
use proptest::{prelude::*, sample::Index};

const CELL_M: f64 = 0.5;

/// How a drive went.
struct Drive {
    end: Command,
    pose: Pose,
    /// At every tick.
    velocities: Vec<Velocity>,
    least_clearance_m: f64,
    least_gap_m: f64,
}

/// Drives until it has arrived, is stuck, or a long time is over. What moves keeps its velocity.
fn drive(dwa: &Dwa, grid: &Grid, path: &Path, moving: &[Moving]) -> Drive {
    let obstacles = Obstacles { grid, cell_m: CELL_M };
    let route = Route::new(path, &obstacles);
    let mut moving = moving.to_vec();
    let mut pose = Pose { at: route.at(0.0), heading_rad: 0.0 };
    let (mut velocity, mut progress) = (Velocity::REST, Progress::default());
    let mut drive = Drive {
        end: Command::Drive(Velocity::REST),
        pose,
        velocities: vec![velocity],
        least_clearance_m: f64::INFINITY,
        least_gap_m: f64::INFINITY,
    };
    let periods = 200 + (route.length_m() * 40.0) as u32;
    for _ in 0..periods {
        (drive.end, progress) = dwa.step(&route, &obstacles, &moving, (pose, velocity), progress);
        for _ in 0..dwa.ticks {
            velocity = dwa.chassis.ramped(velocity, drive.end.velocity());
            pose = pose.moved(velocity, dwa.chassis.tick_s);
            for other in &mut moving {
                other.at.x_m += other.velocity_mps.0 * dwa.chassis.tick_s;
                other.at.y_m += other.velocity_mps.1 * dwa.chassis.tick_s;
                let gap_m = pose.at.distance_m(other.at) - dwa.radius_m - other.radius_m;
                drive.least_gap_m = drive.least_gap_m.min(gap_m);
            }
            drive.velocities.push(velocity);
            drive.least_clearance_m = drive.least_clearance_m.min(obstacles.clearance_m(pose.at, 1.0));
        }
        // Every command is taken up until the next.
        assert_eq!(velocity, drive.end.velocity());
        drive.pose = pose;
        if !matches!(drive.end, Command::Drive(_)) {
            break;
        }
    }
    drive
}

/// How often a value changes its sign, what is nearly zero left out.
fn sign_changes(values: impl Iterator<Item = f64>) -> usize {
    let signs: Vec<bool> = values.filter(|value| value.abs() > 0.02).map(|value| value > 0.0).collect();
    signs.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

fn maps() -> impl Strategy<Value = Grid> {
    (4u32..16, 4u32..16).prop_flat_map(|(width, height)| {
        prop::collection::vec(prop::bool::weighted(0.8), (width * height) as usize).prop_map(move |cells| {
            let mut grid = Grid::blocked(width, height).unwrap();
            for (index, free) in cells.into_iter().enumerate() {
                grid.set(grid.cell(index), free);
            }
            grid
        })
    })
}

fn grid(rows: &[&str]) -> Grid {
    read_map(&format!(
        "type octile\nheight {}\nwidth {}\nmap\n{}\n",
        rows.len(),
        rows[0].len(),
        rows.join("\n")
    ))
    .unwrap()
}

fn path(grid: &Grid, from: (i32, i32), to: (i32, i32)) -> Path {
    AStar::new(grid, MoveSet::Eight)
        .plan(from.into(), to.into(), &mut Workspace::default())
        .unwrap()
        .path
        .clone()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn it_arrives_on_every_map_that_has_a_path_touches_nothing_and_does_not_swing(
        grid in maps(), from in any::<Index>(), to in any::<Index>(),
    ) {
        let cells: Vec<Cell> = grid.free_cells().collect();
        prop_assume!(!cells.is_empty());
        let (from, to) = (cells[from.index(cells.len())], cells[to.index(cells.len())]);
        let mut workspace = Workspace::default();
        let Ok(found) = AStar::new(&grid, MoveSet::Eight).plan(from, to, &mut workspace) else { return Ok(()) };
        let dwa = Dwa::default();
        let driven = drive(&dwa, &grid, found.path, &[]);
        prop_assert_eq!(driven.end, Command::Arrived, "at {:?} with {:?}, from {} along {:?}", driven.pose, driven.velocities.last(), from, found.path.waypoints());
        prop_assert!(driven.least_clearance_m >= dwa.radius_m);
        let goal = Obstacles { grid: &grid, cell_m: CELL_M }.point(to);
        prop_assert!(driven.pose.at.distance_m(goal) <= 1.1 * dwa.tolerance_m);
        for pair in driven.velocities.windows(2) {
            let change = dwa.chassis.wheel_change_mps(pair[0], pair[1]);
            prop_assert!(change <= dwa.chassis.increment_mps + 1e-12 && dwa.chassis.can(pair[1]));
        }
        // A turn of the route can turn each component once or twice, and nothing else does.
        let turns = found.path.waypoints().len();
        for component in [
            |velocity: &Velocity| velocity.forward_mps,
            |velocity: &Velocity| velocity.left_mps,
            |velocity: &Velocity| velocity.turn_radps,
        ] {
            let changes = sign_changes(driven.velocities.iter().map(component));
            prop_assert!(changes <= 2 * turns, "{} changes in {} turns", changes, turns);
        }
    }
}

#[test]
fn a_straight_way_is_driven_straight_and_fast() {
    let grid = grid(&[".........................."; 3]);
    let driven = drive(&Dwa::default(), &grid, &path(&grid, (1, 1), (24, 1)), &[]);
    assert_eq!(driven.end, Command::Arrived);
    assert!(
        driven.velocities.iter().all(|v| v.forward_mps >= 0.0 && v.left_mps == 0.0 && v.turn_radps == 0.0)
    );
    let fastest = driven.velocities.iter().map(|v| v.forward_mps).fold(0.0, f64::max);
    assert!(fastest > 0.79, "{fastest}");
}

#[test]
fn a_route_that_is_blocked_ends_in_saying_so_and_not_in_orbits() {
    let open = grid(&["............"; 5]);
    let path = path(&open, (1, 2), (10, 2));
    let mut blocked = open.clone();
    (0..5).for_each(|y| blocked.set(Cell { x: 6, y }, false));
    let dwa = Dwa::default();
    let driven = drive(&dwa, &blocked, &path, &[]);
    assert_eq!(driven.end, Command::Stuck);
    assert!(driven.least_clearance_m >= dwa.radius_m);
    // It stands where the route is blocked, and has stood for a while.
    assert!((driven.pose.at.x_m - (5.5 * CELL_M - dwa.radius_m)).abs() < 0.1, "{:?}", driven.pose);
    let last = &driven.velocities[driven.velocities.len() - 200..];
    assert!(last.iter().all(|velocity| velocity.speed_mps() < 0.02));
}

#[test]
fn it_gives_way_to_another_robot_and_arrives() {
    let grid = grid(&["...................."; 9]);
    let path = path(&grid, (1, 4), (18, 4));
    let dwa = Dwa::default();
    // One crosses the way, one comes the other way a little aside.
    let crossing = Moving { at: Point { x_m: 4.0, y_m: 0.5 }, velocity_mps: (0.0, -0.4), radius_m: 0.2 };
    let oncoming = Moving { at: Point { x_m: 9.0, y_m: -1.9 }, velocity_mps: (-0.5, 0.0), radius_m: 0.2 };
    for moving in [[crossing].as_slice(), &[oncoming], &[crossing, oncoming]] {
        let driven = drive(&dwa, &grid, &path, moving);
        assert_eq!(driven.end, Command::Arrived, "{moving:?}");
        assert!(driven.least_gap_m > 0.0 && driven.least_clearance_m >= dwa.radius_m, "{moving:?}");
    }
}

#[test]
fn what_is_no_place_or_velocity_makes_it_brake_and_never_hang() {
    let grid = grid(&["......"; 3]);
    let obstacles = Obstacles { grid: &grid, cell_m: CELL_M };
    let route = Route::new(&path(&grid, (1, 1), (4, 1)), &obstacles);
    let dwa = Dwa::default();
    let at = |x_m, heading_rad| Pose { at: Point { x_m, y_m: -CELL_M }, heading_rad };
    let turning = |turn_radps| Velocity { turn_radps, ..Velocity::REST };
    for nonsense in [f64::NAN, f64::INFINITY, -1e300] {
        for (pose, velocity) in [
            (at(nonsense, 0.0), Velocity::REST),
            (at(CELL_M, nonsense), Velocity::REST),
            (at(CELL_M, 0.0), turning(nonsense)),
            (at(CELL_M, 0.0), Velocity { forward_mps: nonsense, ..Velocity::REST }),
        ] {
            let mut progress = Progress::default();
            for _ in 0..60 {
                let command;
                (command, progress) = dwa.step(&route, &obstacles, &[], (pose, velocity), progress);

                assert!(!matches!(command, Command::Arrived), "{pose:?} {velocity:?}");
            }
        }
    }
}
