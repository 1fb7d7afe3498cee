//! The floor, its piles and its robots.

use host_coordinator::{
    config::RobotConfig,
    site::{Site, SitePile},
};
use planning::grid::Cell;
use protocol::{EnergyJ, PileId, Position, RobotId, TagId};

pub const PILES: u16 = 200;
pub const ROBOTS: u16 = 500;
pub const POWER_W: f32 = 500.0;
pub const FULL_J: f32 = 100_000.0;

/// The floor of Fig. 7 with piles all over it.
pub fn site() -> Site {
    let mut site = Site::fig7().unwrap();
    let free: Vec<Cell> = site.grid.free_cells().collect();
    let pile = |number: u16| SitePile {
        id: PileId(number),
        cell: free[usize::from(number) * free.len() / usize::from(PILES + 1)],
        power_w: POWER_W,
        charged: None,
    };
    site.piles = (1..=PILES).map(pile).collect();
    site
}

pub fn robots() -> Vec<RobotConfig> {
    let robot = |number: u16| {
        let [low, high] = number.to_le_bytes();
        RobotConfig {
            id: RobotId(number),
            tag: TagId([low, high, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3]),
            full: EnergyJ::clamped(FULL_J),
            energy_per_metre_j: 20.0,
            speed_mps: 1.0,
            gives_w: None,
        }
    };
    (1..=ROBOTS).map(robot).collect()
}

/// Where robots can stand.
pub fn places(site: &Site) -> Vec<Position> {
    site.grid.free_cells().map(|cell| site.position(cell)).collect()
}

/// Where a robot stands when it asks for the `turn`th time.
pub fn place(places: &[Position], robot: RobotId, turn: u32) -> Position {
    places[(usize::from(robot.0) * 577 + turn as usize * 1_201) % places.len()]
}
