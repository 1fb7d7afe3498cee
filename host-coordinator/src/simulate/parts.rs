//! A route that comes in parts, in any order and any number of times.

use protocol::Position;

use super::ground::{Point, Route};

/// The parts that have come so far of the one route that `K` names.
#[derive(Clone, Debug)]
pub struct Parts<K> {
    of: K,
    waypoints: Vec<Option<Point>>,
}

impl<K: PartialEq> Parts<K> {
    /// Nothing yet of a route of `total` waypoints.
    #[must_use]
    pub fn new(of: K, total: u16) -> Self {
        Self { of, waypoints: vec![None; total.into()] }
    }

    /// Whether this is that route.
    #[must_use]
    pub fn is(&self, of: &K, total: u16) -> bool {
        self.of == *of && self.waypoints.len() == usize::from(total)
    }

    /// Puts a part in its place, from waypoint `first` on; answers the whole route when nothing is missing
    /// any more. What lies outside the route is dropped.
    pub fn add(&mut self, first: u16, waypoints: &[Position]) -> Option<Route> {
        let places = self.waypoints.iter_mut().skip(first.into());
        for (place, &waypoint) in places.zip(waypoints) {
            *place = Some(waypoint.into());
        }
        self.waypoints.iter().copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use protocol::{CoordinateM, limits};

    use super::*;

    fn part(total: u16, first: u16) -> Vec<Position> {
        let at = |index| Position { x: CoordinateM::clamped(f32::from(index)), y: CoordinateM::clamped(0.0) };
        (first..total).take(limits::WAYPOINTS_PER_PART).map(at).collect()
    }

    proptest! {
        #[test]
        fn a_route_is_whole_when_every_part_has_come_in_any_order(
            total in 1_u16..200,
            order in proptest::collection::vec(any::<proptest::sample::Index>(), 0..40),
        ) {
            let firsts: Vec<u16> = (0..total).step_by(limits::WAYPOINTS_PER_PART).collect();
            let mut parts = Parts::new((), total);
            let mut come = std::collections::BTreeSet::new();
            for first in order.iter().map(|index| *index.get(&firsts)).chain(firsts.iter().copied()) {
                come.insert(first);
                let route = parts.add(first, &part(total, first));
                prop_assert_eq!(route.is_some(), come.len() == firsts.len());
                if let Some(route) = route {
                    prop_assert!(route.iter().map(|point| point.x_m as u16).eq(0..total));
                }
            }
        }
    }

    #[test]
    fn waypoints_beyond_the_end_are_dropped() {
        let mut parts = Parts::new((), 3);
        assert_eq!(parts.add(60_000, &part(3, 0)), None);
        assert_eq!(parts.add(2, &part(3, 0)), None);
    }
}
