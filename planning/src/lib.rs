//! Occupancy grids, path planners and local memorial path planning (LMPP) for indoor robots.
//!
//! Pure functions over plain data: no I/O, no async, no clock, no global. The coordinator plans
//! with it; a robot's own computer may link it too.
//!
//! | module | one idea |
//! |---|---|
//! | [`grid`] | which cells are free |
//! | [`frame`] | where a grid lies in the world |
//! | [`clearance`] | how far cells are from what is blocked; room for a robot's radius |
//! | [`floor_plan`] | buildings and tracks as lines, and the grids they become |
//! | [`moves`] | how a robot steps from cell to cell, and the one corner rule |
//! | [`path`] | waypoints and exact lengths |
//! | [`search`] | shortest paths found on the map: jump point search, A*, Dijkstra |
//! | [`indexed`] | any start to any goal through an index of the map |
//! | [`rrt`] | trees that explore by chance, and paths along what they found |
//! | [`dwa`] | velocities for a Mecanum chassis that follow a path |
//! | [`rooms`] | subareas and the doors between them |
//! | [`segment`] | subareas and doors derived from a map |
//! | [`congestion`] | which doors to avoid when |
//! | [`memory`] | what never changes: banks of paths, fields of ways to known places |
//! | [`lmpp`] | paths put together from memory |
//! | [`parking`] | parking lots with cars at random |
//! | [`swarm`] | paths by wolves and particles |
//! | [`assign`] | which robot goes to which pile |
//! | [`virtual_obstacles`] | one robot keeps off another's path |
//! | [`formats`] | maps as other programs write them |
//!
//! ```
//! use planning::{formats::movingai, moves::MoveSet, search::{AStar, Planner, Workspace}};
//!
//! let grid = movingai::read_map("type octile\nheight 3\nwidth 4\nmap\n....\n.@@.\n....\n")?;
//! let (from, to) = ((0, 0).into(), (3, 2).into());
//! let mut workspace = Workspace::default();
//! let plan = AStar::new(&grid, MoveSet::Eight).plan(from, to, &mut workspace)?;
//! assert_eq!(plan.path.length().straight, 5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod assign;
pub mod clearance;
pub mod congestion;
pub mod dwa;
pub mod floor_plan;
pub mod formats;
pub mod frame;
pub mod grid;
pub mod indexed;
pub mod lmpp;
pub mod memory;
pub mod moves;
pub mod parking;
pub mod path;
pub mod rooms;
pub mod rrt;
pub mod search;
pub mod segment;
pub mod swarm;
pub mod virtual_obstacles;
