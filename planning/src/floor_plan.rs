//! Floor plans of lines and points, as editors of buildings and of vehicles' tracks keep them, and
//! the grids that they become.

use crate::{
    frame::Frame,
    grid::{Cell, Grid, MAX_SIDE, TooLarge},
};

/// A point of a site's world: x to the right and y up, in metres.
pub type Point = [f64; 2];

/// What a place is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlaceKind {
    /// Robots charge there.
    Pile,
    /// Robots park there.
    Parking,
    /// Robots pass or stop there.
    #[default]
    Other,
}

/// A place that a plan names or that lanes lead to.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// What people call it, perhaps nothing.
    pub name: String,
    /// Where it is.
    pub at_m: Point,
    /// What it is for.
    pub kind: PlaceKind,
}

/// A door as a building has it, open or shut.
#[derive(Clone, Debug, PartialEq)]
pub struct Doorway {
    /// What people call it, perhaps nothing.
    pub name: String,
    /// Where its leaf begins and ends.
    pub ends_m: [Point; 2],
}

/// A way that robots drive along from place to place.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane {
    /// Where it leads from and to, as indices of the plan's places.
    pub ends: [usize; 2],
    /// Its corners between them; none if it is straight.
    pub via_m: Vec<Point>,
    /// Whether robots drive along it both ways.
    pub both_ways: bool,
}

impl Lane {
    /// Its ends and corners in order, where `places` are the plan's.
    pub fn points_m(&self, places: &[Place]) -> impl Iterator<Item = Point> {
        let [from, to] = self.ends.map(|end| places.get(end).map(|place| place.at_m));
        from.into_iter().chain(self.via_m.iter().copied()).chain(to)
    }

    /// How long it is, in metres.
    #[must_use]
    pub fn length_m(&self, places: &[Place]) -> f64 {
        let points = || self.points_m(places);
        points().zip(points().skip(1)).map(|(from, to)| (from[0] - to[0]).hypot(from[1] - to[1])).sum()
    }
}

/// A lift, on one of the storeys where it stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Lift {
    /// What people call it, the same on all storeys.
    pub name: String,
    /// The middle of its cabin.
    pub at_m: Point,
    /// How far its cabin is turned, in radians from the x axis to the y axis.
    pub yaw_rad: f64,
    /// Its cabin's width and depth: along x and along y when it is not turned, in metres.
    pub size_m: [f64; 2],
    /// The doors that open on this storey; none if the plan does not say them.
    pub doors: Vec<Doorway>,
    /// The places in its cabin, as indices of this storey's.
    pub places: Vec<usize>,
    /// The storeys where it stops by name, this one too.
    pub storeys: Vec<String>,
}

impl Lift {
    /// A point given from the middle of the cabin, in the world.
    #[must_use]
    pub fn world(&self, [x, y]: Point) -> Point {
        let (sin, cos) = (libm::sin(self.yaw_rad), libm::cos(self.yaw_rad));
        [self.at_m[0] + x * cos - y * sin, self.at_m[1] + x * sin + y * cos]
    }

    /// The corners of the cabin, in turn.
    #[must_use]
    pub fn corners_m(&self) -> [Point; 4] {
        let [x, y] = self.size_m.map(|side| side / 2.0);
        [[x, y], [-x, y], [-x, -y], [x, -y]].map(|corner| self.world(corner))
    }

    /// Whether a point is in the cabin.
    #[must_use]
    pub fn holds(&self, point: Point) -> bool {
        let [x, y] = [point[0] - self.at_m[0], point[1] - self.at_m[1]];
        let (sin, cos) = (libm::sin(self.yaw_rad), libm::cos(self.yaw_rad));
        let [across, along] = [x * cos + y * sin, y * cos - x * sin];
        across.abs() <= self.size_m[0] / 2.0 && along.abs() <= self.size_m[1] / 2.0
    }
}

/// One storey of a building, or one layout of tracks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FloorPlan {
    /// What people call it.
    pub name: String,
    /// Named places and the ends of lanes.
    pub places: Vec<Place>,
    /// Doors.
    pub doors: Vec<Doorway>,
    /// Lanes.
    pub lanes: Vec<Lane>,
    /// Lifts that stop here.
    pub lifts: Vec<Lift>,
    /// Walls, each from end to end.
    pub walls: Vec<[Point; 2]>,
    /// The corners of each floor, which robots do not leave.
    pub floors: Vec<Vec<Point>>,
    /// The corners of each hole in the floors.
    pub holes: Vec<Vec<Point>>,
}

/// How a floor plan is drawn on a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The length of a cell in metres, more than 0.
    pub resolution_m: f64,
    /// How thick walls are, in metres.
    pub wall_m: f64,
    /// How wide lanes are, in metres, where a plan has nothing but lanes.
    pub lane_m: f64,
}

/// A grid and what is known of it besides.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Which cells are free.
    pub grid: Grid,
    /// Where they are.
    pub frame: Frame,
    /// How many cells are blocked for nobody knows what is there.
    pub unknown: usize,
    /// Named places and the ends of lanes.
    pub places: Vec<Place>,
    /// Doors.
    pub doors: Vec<Doorway>,
    /// Lanes.
    pub lanes: Vec<Lane>,
    /// Lifts.
    pub lifts: Vec<Lift>,
}

impl Layout {
    /// One of which nothing is known but its cells.
    #[must_use]
    pub fn of_cells(grid: Grid, frame: Frame, unknown: usize) -> Self {
        let (places, doors, lanes, lifts) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { grid, frame, unknown, places, doors, lanes, lifts }
    }
}

/// A floor plan that makes no grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DrawError {
    /// There is nothing that a robot could drive on.
    #[error("`{0}` has neither floors nor walls nor lanes: expected one of them")]
    Empty(String),
    /// It would be too many cells.
    #[error(
        "`{name}` is {} m x {} m, too large for cells of {resolution_m} m: expected sides of at most \
         {MAX_SIDE} cells and {MAX_CELLS} in all; use longer cells",
        size_m[0].ceil(), size_m[1].ceil()
    )]
    TooLarge {
        /// The plan.
        name: String,
        /// How long and high it is, in metres.
        size_m: Point,
        /// How long cells should be, in metres.
        resolution_m: f64,
    },
    /// A side is too long.
    #[error(transparent)]
    Side(#[from] TooLarge),
}

/// The most cells that a plan becomes.
const MAX_CELLS: f64 = 67_108_864.0;

impl FloorPlan {
    /// Draws the plan on a grid. Cells are free if their middle is on a floor (anywhere between the
    /// walls if there are no floors, on lanes if there are no walls either), in no hole, and no nearer
    /// to a wall's line than half its thickness. Doors are open. A lift stands where it stops: its cabin is free
    /// and has walls, but for its doors on this storey.
    ///
    /// # Errors
    /// [`DrawError`] if there is nothing to draw, or too much.
    pub fn draw(&self, scale: Scale) -> Result<Layout, DrawError> {
        let (columns, frame) = self.frame(scale)?;
        let mut grid = Grid::blocked(columns, frame.rows)?;
        if !self.floors.is_empty() {
            self.floors.iter().for_each(|floor| fill(&mut grid, &frame, floor, true));
        } else if !self.walls.is_empty() {
            (0..frame.rows as i32).for_each(|y| grid.set_run(y, 0..columns, true));
        } else {
            self.tracks().for_each(|lane| stroke(&mut grid, &frame, lane, scale.lane_m, true));
        }
        self.holes.iter().for_each(|hole| fill(&mut grid, &frame, hole, false));
        self.walls.iter().for_each(|&wall| stroke(&mut grid, &frame, wall, scale.wall_m, false));
        self.lifts.iter().for_each(|lift| lift.draw(&mut grid, &frame, scale.wall_m));
        let (places, doors) = (self.places.clone(), self.doors.clone());
        let (lanes, lifts) = (self.lanes.clone(), self.lifts.clone());
        Ok(Layout { grid, frame, unknown: 0, places, doors, lanes, lifts })
    }

    /// The lines of the lanes, and every pile and parking spot as a short one.
    fn tracks(&self) -> impl Iterator<Item = [Point; 2]> + '_ {
        let lanes = self.lanes.iter().flat_map(|lane| {
            let points = || lane.points_m(&self.places);
            points().zip(points().skip(1)).map(|(from, to)| [from, to])
        });
        let spots = self.places.iter().filter(|place| place.kind != PlaceKind::Other);
        lanes.chain(spots.map(|spot| [spot.at_m; 2]))
    }

    /// The lowest and the highest coordinates of what is drawn, in metres.
    fn extent(&self, scale: Scale) -> Result<[Point; 2], DrawError> {
        let mut points: Vec<Point> = self.walls.as_flattened().to_vec();
        points.extend(self.floors.iter().flatten());
        let mut margin = scale.wall_m / 2.0;
        if points.is_empty() {
            points.extend(self.tracks().flatten());
            margin = scale.lane_m / 2.0;
        }
        if points.is_empty() {
            return Err(DrawError::Empty(self.name.clone()));
        }
        points.extend(self.lifts.iter().flat_map(Lift::corners_m));
        let bound = |keep: fn(f64, f64) -> f64, start: f64| {
            points.iter().fold([start; 2], |[x, y], point| [keep(x, point[0]), keep(y, point[1])])
        };
        let (low, high) = (bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY));
        let margin = margin + scale.resolution_m;
        Ok([low.map(|low| low - margin), high.map(|high| high + margin)])
    }

    /// The grid's columns, and where it lies.
    fn frame(&self, scale: Scale) -> Result<(u32, Frame), DrawError> {
        let [low, high] = self.extent(scale)?;
        let resolution_m = scale.resolution_m;
        let size_m = [high[0] - low[0], high[1] - low[1]];
        let [columns, rows] = size_m.map(|size| (size / resolution_m).ceil());
        if !(columns.max(rows) <= f64::from(MAX_SIDE) && columns * rows <= MAX_CELLS) {
            return Err(DrawError::TooLarge { name: self.name.clone(), size_m, resolution_m });
        }
        Ok((columns as u32, Frame { resolution_m, origin_m: low, yaw_rad: 0.0, rows: rows as u32 }))
    }
}

impl Lift {
    fn draw(&self, grid: &mut Grid, frame: &Frame, wall_m: f64) {
        let corners = self.corners_m();
        fill(grid, frame, &corners, true);
        if self.doors.is_empty() {
            return;
        }
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).for_each(|(&from, &to)| stroke(grid, frame, [from, to], wall_m, false));
        for Doorway { ends_m: [one, other], .. } in &self.doors {
            // From the door, which is a little outside, to the middle.
            let [x, y] = [0, 1].map(|axis| self.at_m[axis] - (one[axis] + other[axis]) / 2.0);
            let inside = |[door_x, door_y]: Point| [door_x + x, door_y + y];
            fill(grid, frame, &[*one, *other, inside(*other), inside(*one)], true);
            stroke(grid, frame, [*one, *other], wall_m, true);
        }
    }
}

/// Frees or blocks the cells whose middle is within half a `width_m` of the line from `from` to `to`.
fn stroke(grid: &mut Grid, frame: &Frame, [from, to]: [Point; 2], width_m: f64, free: bool) {
    // In cells from the lower left corner, as the rows below.
    let (from, to) = (frame.units(from), frame.units(to));
    // The line is at least as wide as a cell is long, so that it has no gaps.
    let half = (width_m / frame.resolution_m / 2.0).max(0.5);
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let squared = dx * dx + dy * dy;
    let (low, high) = (from[1].min(to[1]) - half, from[1].max(to[1]) + half);
    for row in whole(low, frame.rows)..whole(high + 1.0, frame.rows) {
        let y = f64::from(row) + 0.5;
        // Only this part of the line can be near the row.
        let part = |y: f64| if dy == 0.0 { 0.0 } else { ((y - from[1]) / dy).clamp(0.0, 1.0) };
        let ends = if dy == 0.0 { [0.0, 1.0] } else { [part(y - half), part(y + half)] };
        let xs = ends.map(|part| from[0] + part * dx);
        let (left, right) = (xs[0].min(xs[1]) - half, xs[0].max(xs[1]) + half);
        for column in whole(left, grid.width())..whole(right + 1.0, grid.width()) {
            let x = f64::from(column) + 0.5;
            let along = ((x - from[0]) * dx + (y - from[1]) * dy) / squared;
            let along = if squared > 0.0 { along.clamp(0.0, 1.0) } else { 0.0 };
            let (off_x, off_y) = (x - from[0] - along * dx, y - from[1] - along * dy);
            if off_x * off_x + off_y * off_y <= half * half {
                grid.set(cell(column, row, frame), free);
            }
        }
    }
}

/// Frees or blocks the cells whose middle is within a polygon, which may cross itself: even-odd.
fn fill(grid: &mut Grid, frame: &Frame, corners: &[Point], free: bool) {
    let corners: Vec<Point> = corners.iter().map(|&corner| frame.units(corner)).collect();
    let mut crossings = Vec::new();
    let [low, high] = [(f64::min as fn(_, _) -> _, f64::INFINITY), (f64::max, f64::NEG_INFINITY)]
        .map(|(keep, start)| corners.iter().fold(start, |bound, corner| keep(bound, corner[1])));
    for row in whole(low, frame.rows)..whole(high + 1.0, frame.rows) {
        let y = f64::from(row) + 0.5;
        crossings.clear();
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            if (from[1] <= y) != (to[1] <= y) {
                crossings.push(from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0]));
            }
        }
        crossings.sort_by(f64::total_cmp);
        for run in crossings.as_chunks::<2>().0 {
            let [left, right] = run.map(|edge| whole((edge - 0.5).ceil(), grid.width()));
            grid.set_run(cell(left, row, frame).y, left..right, free);
        }
    }
}

fn cell(column: u32, row: u32, frame: &Frame) -> Cell {
    // A side has at most 65535 cells.
    Cell { x: column as i32, y: frame.rows as i32 - 1 - row as i32 }
}

/// The whole number below, from 0 to `end`.
fn whole(number: f64, end: u32) -> u32 {
    // `as` saturates.
    (number.floor() as u32).min(end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::movingai::write_map;

    const SCALE: Scale = Scale { resolution_m: 1.0, wall_m: 1.0, lane_m: 1.0 };

    fn drawn(plan: &FloorPlan) -> Vec<String> {
        let layout = plan.draw(SCALE).unwrap();
        write_map(&layout.grid).lines().skip(4).map(str::to_owned).collect()
    }

    #[test]
    fn floors_are_free_but_for_walls_and_holes() {
        let floors = vec![vec![[0.0, 0.0], [7.0, 0.0], [7.0, 4.0], [0.0, 4.0]]];
        let walls = vec![[[3.5, 4.0], [3.5, 2.0]]];
        let holes = vec![vec![[6.0, 0.0], [7.0, 0.0], [7.0, 1.0], [6.0, 1.0]]];
        let plan = FloorPlan { floors, walls, holes, ..FloorPlan::default() };
        let layout = plan.draw(SCALE).unwrap();
        let at = |x, y| layout.grid.is_free(layout.frame.cell_at([x, y]));
        assert!(at(0.6, 0.6) && at(5.0, 3.0) && at(3.5, 1.0), "{:#?}", drawn(&plan));
        assert!(!at(3.5, 3.0) && !at(6.5, 0.5) && !at(-0.6, 2.0) && !at(7.6, 2.0), "{:#?}", drawn(&plan));
    }

    #[test]
    fn a_slanting_wall_has_no_gap_that_a_robot_could_pass() {
        let floors = vec![vec![[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]]];
        let plan = FloorPlan { floors, walls: vec![[[-1.0, 3.0], [21.0, 15.0]]], ..FloorPlan::default() };
        let thin = Scale { wall_m: 0.0, ..SCALE };
        let layout = plan.draw(thin).unwrap();
        let (below, above) = (layout.frame.cell_at([10.0, 1.0]), layout.frame.cell_at([10.0, 19.0]));
        let mut workspace = crate::search::Workspace::default();
        let planner = crate::search::AStar::new(&layout.grid, crate::moves::MoveSet::Eight);
        let found = crate::search::Planner::plan(&planner, below, above, &mut workspace);
        assert!(found.is_err(), "{:#?}", drawn(&plan));
    }

    #[test]
    fn a_plan_of_lanes_is_free_along_them_only() {
        let place = |x, y| Place { name: String::new(), at_m: [x, y], kind: PlaceKind::Other };
        let places = vec![place(0.5, 0.5), place(4.5, 0.5), place(9.5, 9.5)];
        let lanes = vec![Lane { ends: [0, 1], via_m: Vec::new(), both_ways: true }];
        let plan = FloorPlan { places, lanes, ..FloorPlan::default() };
        assert_eq!(
            drawn(&plan),
            ["@@@@@@@@", "@.....@@", "@@@@@@@@"].map(|row| &row[..drawn(&plan)[0].len()])
        );
    }

    #[test]
    fn as_many_floors_as_a_small_file_can_name_are_drawn_without_going_through_every_cell_of_each() {
        let floors = vec![vec![[0.0, 0.0], [4000.0, 0.0], [4000.0, 4000.0], [0.0, 4000.0]]; 250];
        let layout = FloorPlan { floors, ..FloorPlan::default() }.draw(SCALE).unwrap();
        assert_eq!(layout.grid.free_cells().count(), 4000 * 4000);
    }

    #[test]
    fn a_plan_of_nothing_and_one_of_too_much_are_refused() {
        assert!(matches!(FloorPlan::default().draw(SCALE), Err(DrawError::Empty(_))));
        let walls = vec![[[0.0, 0.0], [1e7, 5.0]]];
        let error = FloorPlan { walls, name: "L1".into(), ..FloorPlan::default() }.draw(SCALE).unwrap_err();
        assert!(
            error.to_string().starts_with("`L1` is 10000003 m x 8 m, too large for cells of 1 m"),
            "{error}"
        );
        let walls = vec![[[0.0, 0.0], [f64::NAN, f64::INFINITY]]];
        assert!(FloorPlan { walls, ..FloorPlan::default() }.draw(SCALE).is_err());
    }
}
