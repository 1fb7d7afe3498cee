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
//! | [`parts`] | a route that comes in parts |
//! | [`link`] | a device's socket: frames in datagrams |
//! | [`pile_node`] | a pile's firmware between its socket and the world |
//! | [`auditor`] | watches from outside that no pile has two holders |

pub mod auditor;
pub mod ground;
pub mod link;
pub mod parts;
pub mod pile_node;
pub mod random;
pub mod world;
