//! A drive along a path of the improved A*, by the dynamic window approach and the chassis' ramp.

use planning::{
    dwa::{Chassis, Command, Dwa, Obstacles, Pose, Progress, Route, Velocity},
    rrt::ImprovedWorkspace,
    search::{Planner, SearchError},
};

use super::{
    maps::{Drawn, drawn},
    measure::improved,
};

/// The side of a cell, in m; the paper prints none.
const CELL_M: f64 = 0.5;
/// A drive is over after so many periods.
const PERIODS: u32 = 2_000;
/// The seed of the map and the tree.
pub const SEED: u64 = 1;

/// What was driven.
pub struct Drive {
    /// The robot's velocity at every tick.
    pub velocities: Vec<Velocity>,
    /// Where it was at every tick, in cells.
    pub track: Vec<(f64, f64)>,
    /// How near the robot's middle came to a blocked cell.
    pub least_clearance_m: f64,
    /// How long the route was.
    pub route_m: f64,
}

/// The map of the drive and of the figures: of Fig. 12's size and density.
pub fn map() -> Result<Drawn, SearchError> {
    drawn(20, 20, 80, SEED)
}

/// Drives from start to goal.
pub fn drive() -> Result<Drive, SearchError> {
    let Drawn { grid, from, to } = map()?;
    let mut workspace = ImprovedWorkspace::default();
    let path = improved(&grid, SEED).plan(from, to, &mut workspace)?.path;
    let obstacles = Obstacles { grid: &grid, cell_m: CELL_M };
    let route = Route::new(path, &obstacles);
    let dwa = Dwa::default();
    let mut pose = Pose { at: route.at(0.0), heading_rad: 0.0 };
    let (mut velocity, mut progress) = (Velocity::REST, Progress::default());
    let mut drive = Drive {
        velocities: vec![velocity],
        track: Vec::new(),
        least_clearance_m: f64::INFINITY,
        route_m: route.length_m(),
    };
    for _ in 0..PERIODS {
        let command;
        (command, progress) = dwa.step(&route, &obstacles, &[], (pose, velocity), progress);
        if !matches!(command, Command::Drive(_)) {
            break;
        }
        for _ in 0..dwa.ticks {
            velocity = dwa.chassis.ramped(velocity, command.velocity());
            pose = pose.moved(velocity, dwa.chassis.tick_s);
            drive.velocities.push(velocity);
            drive.track.push((pose.at.x_m / CELL_M, -pose.at.y_m / CELL_M));
            drive.least_clearance_m = drive.least_clearance_m.min(obstacles.clearance_m(pose.at, 1.0));
        }
    }
    Ok(drive)
}

impl Drive {
    /// How long it took.
    pub fn seconds(&self) -> f64 {
        self.track.len() as f64 * Chassis::PAPER.tick_s
    }

    /// The most that a wheel's speed changed in a tick.
    pub fn largest_change_mps(&self) -> f64 {
        let pairs = self.velocities.iter().zip(self.velocities.iter().skip(1));
        pairs.map(|(&one, &next)| Chassis::PAPER.wheel_change_mps(one, next)).fold(0.0, f64::max)
    }
}
