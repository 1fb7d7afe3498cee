//! A whole site on loopback: `chargehand demo`.
//!
//! The piles are the real firmware cores, each behind its own UDP socket; the robots are small
//! cores of their own, on the wire like any other. What is simulated is the floor between them:
//! bodies, batteries, contacts, the readers' fields. Everything but [`link`] and its two nodes is
//! pure and runs the same way for the same seed.
//!
//! | module | one idea |
//! |---|---|
//! | [`random`] | reproducible chance |
//! | [`ground`] | points on the floor and routes over it |
//! | [`world`] | the physics: bodies, batteries, charge contacts, reader fields |
//! | [`charger`] | a mobile charger: a robot that charges others |
//! | [`robot`] | a robot's own computer: works, asks, drives, charges |
//! | [`claiming`] | what a robot does while it hears piles and no coordinator |
//! | [`terrain`] | places of work, piles, and the ways to both |
//! | [`tasks`] | what robots work at |
//! | [`navigator`] | what a robot knows of the site |
//! | [`parts`] | a route that comes in parts |
//! | [`fleet`] | the demo's robots: how they are built, charged and placed |
//! | [`link`] | a device's socket: frames in datagrams |
//! | [`pile_node`] | a pile's firmware between its socket and the world |
//! | [`robot_node`] | a robot's computer between its socket and the world |
//! | [`simulation`] | all of them, step by step |
//! | [`pulse`] | how far the coordinator is behind the simulated time |
//! | [`auditor`] | watches from outside that no pile has two holders |
//! | [`report`] | what a run comes to |
//! | [`demo`] | the coordinator, the site and the clock they live by, in one process |

pub mod auditor;
pub mod charger;
pub mod claiming;
pub mod demo;
pub mod fleet;
pub mod ground;
pub mod link;
pub mod navigator;
pub mod parts;
pub mod pile_node;
pub mod pulse;
pub mod random;
pub mod report;
pub mod robot;
pub mod robot_node;
pub mod simulation;
pub mod tasks;
pub mod terrain;
#[cfg(test)]
mod tests;
pub mod trial;
pub mod world;
