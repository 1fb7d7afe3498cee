//! The way a robot shall follow, and how far it has come.

use super::{clearance::Obstacles, motion::Point};
use crate::path::Path;

/// A line of straight pieces, in m.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// Each with how far along the line it is, in m; at least one.
    points: Vec<(f64, Point)>,
}

impl Route {
    /// Along the middles of a path's cells.
    #[must_use]
    pub fn new(path: &Path, obstacles: &Obstacles<'_>) -> Self {
        let mut points: Vec<(f64, Point)> = Vec::new();
        for &cell in path.waypoints() {
            let point = obstacles.point(cell);
            let along_m = points.last().map_or(0.0, |&(along_m, before)| along_m + before.distance_m(point));
            points.push((along_m, point));
        }
        Self { points }
    }

    /// How long it is, in m.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.points.last().map_or(0.0, |&(along_m, _)| along_m)
    }

    /// Where it ends.
    #[must_use]
    pub fn goal(&self) -> Point {
        self.points.last().map_or_else(Point::default, |&(_, point)| point)
    }

    /// The place so far along it, or its nearer end.
    #[must_use]
    pub fn at(&self, along_m: f64) -> Point {
        let after = self.points.partition_point(|&(start_m, _)| start_m <= along_m).max(1);
        match (self.points.get(after - 1), self.points.get(after)) {
            (Some(&(start_m, start)), Some(&(end_m, end))) => {
                start.towards(end, ((along_m - start_m) / (end_m - start_m)).max(0.0))
            }
            _ => self.goal(),
        }
    }
}
