//! A file that is said to be a map, or queries on one: read in words or refused in words, and bounded.

use planning::floor_plan::{FloorPlan, Lift, Scale};
use planning::formats::{image, lif, movingai, rmf, ros, scen};
use planning::grid::Cell;

use crate::tried::Tried;

/// Cells so long that what is drawn stays small; a plan that is larger is refused.
const SCALE: Scale = Scale { resolution_m: 1.0, wall_m: 0.1, lane_m: 1.0 };
/// Plans of more metres are not drawn here: by aliases of YAML a small file can hold 30 000 floors, and
/// to draw them all as large as a site takes longer than the fuzzer waits.
const SIDE_M: f64 = 100.0;

/// Reads the input as every kind of map, and as queries.
pub fn run(input: &[u8]) -> Tried {
    let mut tried = Tried::default();
    let picture = image::read(input);
    tried.add(picture.is_ok());
    if let Ok(picture) = &picture {
        assert_eq!(picture.pixels().count(), picture.width() as usize * picture.height() as usize);
    }
    let Ok(text) = str::from_utf8(input) else { return tried };
    let map = movingai::read_map(text);
    tried.add(map.is_ok());
    if let Ok(grid) = map {
        assert_eq!(movingai::read_map(&movingai::write_map(&grid)), Ok(grid));
    }
    let queries = scen::read_scen(text);
    tried.add(queries.is_ok());
    for scen::Query { width, height, from, to, optimal, .. } in queries.iter().flatten() {
        let inside =
            |cell: Cell| (0..*width as i32).contains(&cell.x) && (0..*height as i32).contains(&cell.y);
        assert!(inside(*from) && inside(*to) && optimal.is_finite());
    }
    tried.add(ros::Description::read(text).is_ok());
    for plans in [rmf::building::read(text).ok(), rmf::nav_graph::read(text).ok(), lif::read(text).ok()] {
        tried.add(plans.is_some());
        plans.iter().flatten().for_each(draw);
    }
    tried
}

fn draw(plan: &FloorPlan) {
    for lane in &plan.lanes {
        assert!(lane.length_m(&plan.places).is_finite());
    }
    for lift in &plan.lifts {
        assert!(
            lift.storeys.contains(&plan.name) && lift.places.iter().all(|&place| place < plan.places.len())
        );
    }
    let points = plan.walls.as_flattened().iter().chain(plan.floors.iter().flatten());
    let points = points.chain(plan.places.iter().map(|place| &place.at_m));
    let points = points.chain(plan.lanes.iter().flat_map(|lane| &lane.via_m)).copied();
    let mut points = points.chain(plan.lifts.iter().flat_map(Lift::corners_m));
    if points.all(|point| point.iter().all(|coordinate| coordinate.abs() < SIDE_M)) {
        if let Ok(layout) = plan.draw(SCALE) {
            assert_eq!(layout.frame.rows, layout.grid.height());
        }
    }
}
