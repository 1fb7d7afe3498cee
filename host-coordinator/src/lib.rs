//! The Chargehand coordinator: chooses a pile for every robot, plans, grants, explains.
