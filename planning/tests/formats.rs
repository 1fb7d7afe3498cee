//! Real maps of other programs, against what an independent reading of the same files says.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use planning::{
    floor_plan::{FloorPlan, PlaceKind, Scale},
    formats::{image, rmf::building, ros},
};

const SCALE: Scale = Scale { resolution_m: 0.05, wall_m: 0.1, lane_m: 1.0 };

fn ros_map(text: &str, picture: &[u8]) -> ros::RosMap {
    ros::Description::read(text).unwrap().map(&image::read(picture).unwrap()).unwrap()
}

fn piles(plan: &FloorPlan) -> Vec<&str> {
    let piles = plan.places.iter().filter(|place| place.kind == PlaceKind::Pile);
    piles.map(|pile| pile.name.as_str()).collect()
}

#[test]
fn the_depot_has_as_many_free_cells_as_counted_elsewhere() {
    let map = ros_map(include_str!("data/ros/depot.yaml"), include_bytes!("data/ros/depot.pgm"));
    assert_eq!((map.grid.width(), map.grid.height(), map.unknown), (604, 307, 0));
    assert_eq!(map.grid.free_cells().count(), 179_481);
}

#[test]
fn what_nobody_has_seen_of_the_sandbox_is_not_free() {
    let map = ros_map(include_str!("data/ros/tb3_sandbox.yaml"), include_bytes!("data/ros/tb3_sandbox.pgm"));
    assert_eq!((map.grid.free_cells().count(), map.unknown), (7903, 138_683));
    assert_eq!(map.frame.origin_m, [-10.0, -10.0]);
    assert!(map.grid.is_free(map.frame.cell_at([-2.0, -0.5])), "where its robot starts");
}

#[test]
fn the_office_is_read_whole_and_its_piles_are_on_the_floor() {
    let [office] =
        <[_; 1]>::try_from(building::read(include_str!("data/rmf/office.building.yaml")).unwrap()).unwrap();
    let counts = [&office.places.len(), &office.walls.len(), &office.doors.len(), &office.lanes.len()];
    assert_eq!(counts, [&73, &33, &3, &30]);
    assert_eq!(piles(&office), ["tinyRobot1_charger", "tinyRobot2_charger"]);
    let layout = office.draw(SCALE).unwrap();
    for place in office.places.iter().filter(|place| place.kind == PlaceKind::Pile) {
        assert!(layout.grid.is_free(layout.frame.cell_at(place.at_m)), "{}", place.name);
    }
    // Vertices 0 to 5 are the ends of the three measurements, which agree within a hundredth.
    for (from, to, metres) in [(1, 0, 9.315), (5, 4, 8.409), (2, 3, 20.089)] {
        let [from, to] = [from, to].map(|vertex: usize| office.places[vertex].at_m);
        let found = (from[0] - to[0]).hypot(from[1] - to[1]);
        assert!((found / metres - 1.0).abs() < 0.02, "{found} m instead of {metres} m");
    }
}

#[test]
fn the_storeys_of_the_hotel_lie_over_each_other() {
    let hotel = building::read(include_str!("data/rmf/hotel.building.yaml")).unwrap();
    assert_eq!(hotel.iter().map(|plan| plan.name.as_str()).collect::<Vec<_>>(), ["L1", "L2", "L3"]);
    assert_eq!(hotel.iter().map(|plan| plan.walls.len()).collect::<Vec<_>>(), [56, 99, 99]);
    assert_eq!(piles(&hotel[0]).len(), 4);
    for plan in &hotel {
        let [one, other] = plan.lifts.as_slice() else { panic!("{:?}", plan.lifts) };
        assert_eq!((one.name.as_str(), other.name.as_str()), ("Lift1", "Lift2"));
        assert_eq!(one.storeys, ["L1", "L2", "L3"]);
        let layout = plan.draw(SCALE).unwrap();
        for lift in [one, other] {
            // Where lanes lead into the cabin.
            assert_eq!(lift.places.len(), 1, "{}", plan.name);
            let [x, y] = plan.places[lift.places[0]].at_m;
            assert!((x - lift.at_m[0]).hypot(y - lift.at_m[1]) < 0.5, "({x}, {y}) in {lift:?}");
            assert!(layout.grid.is_free(layout.frame.cell_at([x, y])));
        }
    }
    let origins = hotel.iter().map(|plan| plan.draw(SCALE).unwrap().frame.origin_m);
    for [x, y] in origins {
        // The outer walls of all storeys are the same but for how exactly they were drawn.
        assert!((x - 2.2).abs() < 0.3 && (y + 40.6).abs() < 0.3, "({x}, {y})");
    }
}
