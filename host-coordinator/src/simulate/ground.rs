//! Points on the floor, and routes over it.

use std::collections::VecDeque;

use protocol::{CoordinateM, Position};

/// A robot that stands closer than this to a pile, in metres, may be in its reader's field or in
/// another robot's way: it parks farther off, and waits here while its dock is taken.
pub const KEEP_CLEAR_M: f64 = 4.0;

/// A point in metres, in the site's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Metres along x.
    pub x_m: f64,
    /// Metres along y.
    pub y_m: f64,
}

impl Point {
    /// The straight distance in metres.
    #[must_use]
    pub fn distance_m(self, other: Self) -> f64 {
        (self.x_m - other.x_m).hypot(self.y_m - other.y_m)
    }

    /// Whether `other` is nearer than `distance_m`, in metres.
    #[must_use]
    pub fn is_within(self, distance_m: f64, other: Self) -> bool {
        let (dx, dy) = (self.x_m - other.x_m, self.y_m - other.y_m);
        dx * dx + dy * dy < distance_m * distance_m
    }
}

impl From<Position> for Point {
    fn from(position: Position) -> Self {
        Self { x_m: position.x.get().into(), y_m: position.y.get().into() }
    }
}

impl From<Point> for Position {
    fn from(point: Point) -> Self {
        Self { x: CoordinateM::clamped(point.x_m as f32), y: CoordinateM::clamped(point.y_m as f32) }
    }
}

/// Waypoints still ahead.
pub type Route = VecDeque<Point>;

/// Moves `from` along `route` by up to `distance_m`, dropping the waypoints it reaches. Answers
/// where that is and how far it really was.
pub fn follow(from: Point, route: &mut Route, distance_m: f64) -> (Point, f64) {
    let mut at = from;
    let mut left_m = distance_m;
    while let Some(&next) = route.front() {
        let leg_m = at.distance_m(next);
        if leg_m > left_m {
            let share = left_m / leg_m;
            at.x_m += share * (next.x_m - at.x_m);
            at.y_m += share * (next.y_m - at.y_m);
            return (at, distance_m);
        }
        left_m -= leg_m;
        at = next;
        route.pop_front();
    }
    (at, distance_m - left_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x_m: f64, y_m: f64) -> Point {
        Point { x_m, y_m }
    }

    #[test]
    fn a_route_is_followed_around_its_corners_to_its_end() {
        let mut route = Route::from([point(0.0, 0.0), point(3.0, 0.0), point(3.0, 4.0)]);
        assert_eq!(follow(point(0.0, 0.0), &mut route, 5.0), (point(3.0, 2.0), 5.0));
        assert_eq!(route, [point(3.0, 4.0)]);
        assert_eq!(follow(point(3.0, 2.0), &mut route, 5.0), (point(3.0, 4.0), 2.0));
        assert!(route.is_empty());
        assert_eq!(follow(point(3.0, 4.0), &mut route, 5.0), (point(3.0, 4.0), 0.0));
    }
}
