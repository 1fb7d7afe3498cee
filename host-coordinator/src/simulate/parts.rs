//! A route that comes in parts, in any order and any number of times.

use protocol::{Assignment, PileId, RequestId};

use super::ground::{Point, Route};

/// The parts of one assignment's route that have come so far.
#[derive(Clone, Debug)]
pub struct Parts {
    request: RequestId,
    pile: PileId,
    waypoints: Vec<Option<Point>>,
}

impl Parts {
    /// Nothing yet of the assignment that `part` is of.
    #[must_use]
    pub fn of(part: &Assignment) -> Self {
        Self { request: part.request, pile: part.pile, waypoints: vec![None; part.total.into()] }
    }

    /// Whether `part` is of this assignment.
    #[must_use]
    pub fn belongs(&self, part: &Assignment) -> bool {
        (self.request, self.pile, self.waypoints.len()) == (part.request, part.pile, part.total.into())
    }

    /// Puts `part` in its place; answers the whole route when nothing is missing any more. What
    /// lies outside the route is dropped.
    pub fn add(&mut self, part: &Assignment) -> Option<Route> {
        let places = self.waypoints.iter_mut().skip(part.first.into());
        for (place, &waypoint) in places.zip(&part.waypoints) {
            *place = Some(waypoint.into());
        }
        self.waypoints.iter().copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use protocol::{CoordinateM, Position, limits};

    use super::*;

    fn assignment(total: u16, first: u16) -> Assignment {
        let waypoints = (first..total)
            .take(limits::WAYPOINTS_PER_PART)
            .map(|index| Position { x: CoordinateM::clamped(f32::from(index)), y: CoordinateM::clamped(0.0) })
            .collect();
        Assignment { request: RequestId(1), pile: PileId(2), total, first, waypoints }
    }

    proptest! {
        #[test]
        fn a_route_is_whole_when_every_part_has_come_in_any_order(
            total in 1_u16..200,
            order in proptest::collection::vec(any::<proptest::sample::Index>(), 0..40),
        ) {
            let firsts: Vec<u16> = (0..total).step_by(limits::WAYPOINTS_PER_PART).collect();
            let mut parts = Parts::of(&assignment(total, 0));
            let mut come = std::collections::BTreeSet::new();
            for first in order.iter().map(|index| *index.get(&firsts)).chain(firsts.iter().copied()) {
                come.insert(first);
                let route = parts.add(&assignment(total, first));
                prop_assert_eq!(route.is_some(), come.len() == firsts.len());
                if let Some(route) = route {
                    prop_assert!(route.iter().map(|point| point.x_m as u16).eq(0..total));
                }
            }
        }
    }

    #[test]
    fn waypoints_beyond_the_end_are_dropped() {
        let mut part = assignment(3, 0);
        let mut parts = Parts::of(&part);
        part.first = 60_000;
        assert_eq!(parts.add(&part), None);
        part.first = 2;
        assert_eq!(parts.add(&part), None);
    }
}
