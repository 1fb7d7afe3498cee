//! The Chargehand coordinator: chooses a pile for every robot, plans, grants, explains.
//!
//! Decisions are pure; I/O stands in a thin shell around them.
//!
//! | module | one idea |
//! |---|---|
//! | [`selection`] | which pile a robot should use, and why |
//! | [`site`] | the map, rooms, doors and piles, and how the site counts its cells |
//! | [`config`] | what `chargehand run` is told by its configuration file |
//! | [`document`] | reads a TOML file and collects every mistake in it |
//! | [`diagnostics`] | mistakes in files, each with file, line and what was expected |
//! | [`core`] | what happens, what is known, what follows: pure |
//! | [`store`] | the event log |
//! | [`memory`] | the site's paths in a file |
//! | [`keys`] | the file of keys that piles, robots and the coordinator share |
//! | [`links`] | frames to and from piles and robots |
//! | [`line`](mod@line) | the line to one board: serial or TCP |
//! | [`chassis`] | a robot's chassis on the line to this computer: drive, watch, record, plot |
//! | [`provision`] | makes a board a pile: its identity and its keys |
//! | [`desk`] | a pile on the line to this computer: ask it, clear its faults |
//! | [`api`] | what programs and the dashboard can ask |
//! | [`daemon`] | the shell that runs the core: clock, sockets, log |
//! | [`reproduce`] | the papers' tables, computed again and compared |
//! | [`plot`] | pictures as PNG and SVG |
//! | [`ui`] | the dashboard's page and its files |
//! | [`simulate`] | a whole site on loopback: the real pile cores, simulated robots |

pub mod api;
pub mod chassis;
pub mod config;
pub mod core;
pub mod daemon;
pub mod desk;
pub mod diagnostics;
pub mod document;
pub mod keys;
pub mod line;
pub mod links;
pub mod memory;
pub mod plot;
pub mod provision;
pub mod reproduce;
pub mod selection;
pub mod simulate;
pub mod site;
pub mod store;
pub mod ui;
