//! Pile fields: the way from every cell to every known target, without any search.
//!
//! A field knows the exact distance from each cell to its target, and the move that comes next with how
//! often it repeats, so that a path is a walk from waypoint to waypoint. The fields of a map lie cell by
//! cell, all targets of a cell side by side: the nearest of 13 piles is one cache line away.
//!
//! | | a cell and target | no way beyond |
//! |---|---|---|
//! | 8 neighbours | 5 bytes | 53,165 cells |
//! | 16 neighbours | 9 bytes | 65,533 cells |
//!
//! Of equally short ways the one is kept whose move has the lowest number in [`MoveSet::steps`], at every
//! cell: a function of the map alone.
//!
//! ```
//! use planning::{formats::movingai, memory::Fields, moves::MoveSet, path::Path};
//!
//! let grid = movingai::read_map("type octile\nheight 2\nwidth 4\nmap\n....\n....\n")?;
//! let piles = [(0, 0).into(), (3, 1).into()];
//! let fields = Fields::build(grid, MoveSet::Eight, &piles);
//! let robot = (2, 0).into();
//! let (pile, length) = fields.nearest(robot).ok_or("walled in")?;
//! assert_eq!((pile, length.diagonal), (1, 1));
//! let mut path = Path::default();
//! assert!(fields.walk(robot, pile, &mut path));
//! assert_eq!(path.waypoints(), [robot, (3, 1).into()]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::{
    build::build,
    image::{Image, Layout},
    metric::{Knight, Metric, Octile},
    repair::{Column, Repair},
};
use crate::{
    grid::{Cell, Grid},
    moves::{Length, MoveSet},
    path::Path,
    search::{Plan, Planner, SearchError, free_index},
};

/// The ways from everywhere on a map to a list of known targets.
/// Two are equal if they are to the bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fields {
    pub(super) grid: Grid,
    pub(super) moves: MoveSet,
    pub(super) targets: Vec<Cell>,
    /// The targets' cells with their numbers, sorted to be found.
    by_cell: Vec<(Cell, u32)>,
    pub(super) image: Image,
}

/// Does the same with the tables of either move set.
macro_rules! with_table {
    ($fields:expr, $table:ident => $answer:expr) => {
        match $fields.moves {
            MoveSet::Eight => {
                let $table = $fields.image.table::<Octile>();
                $answer
            }
            MoveSet::Sixteen => {
                let $table = $fields.image.table::<Knight>();
                $answer
            }
        }
    };
}

/// Once more fields than these have to be built, the others are not repaired: a door that so many ways lead
/// through is on the ways of nearly all.
const MANY: usize = 1;

/// What a change of the map did to the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repaired {
    /// Fields that were repaired, if only by finding that nothing was to be done.
    pub repaired: usize,
    /// Fields that were built anew, because that was cheaper.
    pub rebuilt: usize,
}

/// What a map's memory takes, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes {
    /// The distances of all fields.
    pub distances: usize,
    /// The run tables of all fields.
    pub runs: usize,
    /// The map itself.
    pub grid: usize,
    /// The list of targets.
    pub targets: usize,
}

impl Bytes {
    /// All together.
    #[must_use]
    pub const fn total(self) -> usize {
        self.distances + self.runs + self.grid + self.targets
    }
}

impl Fields {
    /// Builds the fields of `targets`, which are numbered from 0 in this order. There is no way to a target
    /// that is blocked or outside.
    #[must_use]
    pub fn build(grid: Grid, moves: MoveSet, targets: &[Cell]) -> Self {
        let layout = Layout::of(moves, grid.len(), targets.len());
        let mut fields = Self::over(grid, moves, targets, Image::blank(layout));
        fields.rebuild();
        fields
    }

    /// Fields whose tables are in `image`.
    pub(super) fn over(grid: Grid, moves: MoveSet, targets: &[Cell], image: Image) -> Self {
        let mut by_cell: Vec<_> = targets.iter().copied().zip(0..).collect();
        by_cell.sort_unstable();
        Self { grid, moves, targets: targets.to_vec(), by_cell, image }
    }

    /// Builds all fields.
    fn rebuild(&mut self) {
        let targets: Vec<_> = (0..).zip(self.places()).collect();
        match self.moves {
            MoveSet::Eight => build::<Octile>(&self.grid, &targets, &mut self.image.table_mut()),
            MoveSet::Sixteen => build::<Knight>(&self.grid, &targets, &mut self.image.table_mut()),
        }
    }

    /// The targets' places in the grid, `None` where one is blocked.
    fn places(&self) -> Vec<Option<usize>> {
        self.targets.iter().map(|&cell| free_index(&self.grid, cell).ok()).collect()
    }

    /// Frees (`true`) or blocks cells, such as those of a door. The fields are then what [`Self::build`]
    /// would make of the map as it is now, to the bit.
    ///
    /// Only what changed is looked at, unless that is so much of a field that building it is cheaper.
    pub fn change(&mut self, cells: impl IntoIterator<Item = (Cell, bool)>) -> Repaired {
        let before = self.grid.clone();
        let mut changed = Vec::new();
        for (cell, free) in cells {
            self.grid.set(cell, free);
            changed.push(cell);
        }
        changed.retain(|&cell| before.is_free(cell) != self.grid.is_free(cell));
        if changed.is_empty() {
            return Repaired::default();
        }
        match self.moves {
            MoveSet::Eight => self.repair::<Octile>(&before, &changed),
            MoveSet::Sixteen => self.repair::<Knight>(&before, &changed),
        }
    }

    fn repair<M: Metric>(&mut self, before: &Grid, changed: &[Cell]) -> Repaired {
        let places = self.places();
        let targets = places.len();
        let table = &mut self.image.table_mut();
        let mut repair = Repair::<M>::new(before, &self.grid, changed);
        let mut given_up = Vec::new();
        for (target, place) in places.into_iter().enumerate() {
            // Where many are built, all others can be built with them.
            if given_up.len() > MANY || !repair.field(place, &mut Column { table, target }) {
                given_up.push((target, place));
            }
        }
        if !given_up.is_empty() {
            build(&self.grid, &given_up, table);
        }
        Repaired { repaired: targets - given_up.len(), rebuilt: given_up.len() }
    }

    /// The map.
    #[must_use]
    pub const fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The moves of the ways.
    #[must_use]
    pub const fn moves(&self) -> MoveSet {
        self.moves
    }

    /// The targets, in the order of their numbers.
    #[must_use]
    pub fn targets(&self) -> &[Cell] {
        &self.targets
    }

    /// The number of the first target at `cell`.
    #[must_use]
    pub fn target_at(&self, cell: Cell) -> Option<usize> {
        let first = self.by_cell.partition_point(|&(known, _)| known < cell);
        self.by_cell.get(first).filter(|(known, _)| *known == cell).map(|&(_, target)| target as usize)
    }

    /// The nearest target from `from` and how far it is; of equals the one with the lowest number.
    #[must_use]
    #[inline]
    pub fn nearest(&self, from: Cell) -> Option<(usize, Length)> {
        with_table!(self, table => table.nearest(&self.grid, from))
    }

    /// The length of the shortest way from `from` to a target; `None` if there is none.
    #[must_use]
    #[inline]
    pub fn length(&self, from: Cell, target: usize) -> Option<Length> {
        self.row(from).length(target)
    }

    /// The lengths of the shortest ways from `from` to each target, `None` where there is none. No items if
    /// `from` is outside the map.
    pub fn lengths(&self, from: Cell) -> impl Iterator<Item = Option<Length>> + '_ {
        let row = self.row(from);
        (0..row.len()).map(move |target| row.length(target))
    }

    /// As [`Self::lengths`], in cells and infinite where there is no way: a row of a cost matrix. For 8
    /// neighbours one multiplication each, and off the real length by less than its 10^-10th part.
    #[inline]
    pub fn distances(&self, from: Cell) -> impl Iterator<Item = f64> + '_ {
        let row = self.row(from);
        (0..row.len()).map(move |target| row.cells(target))
    }

    #[inline]
    pub(crate) fn row(&self, from: Cell) -> Row<'_> {
        match self.moves {
            MoveSet::Eight => Row::Eight(self.image.table::<Octile>().row(&self.grid, from)),
            MoveSet::Sixteen => Row::Sixteen(self.image.table::<Knight>().row(&self.grid, from)),
        }
    }

    /// Puts the shortest way from `from` to a target into `path`. Returns whether there is one; if not,
    /// `path` stays as it is.
    #[must_use]
    #[inline]
    pub fn walk(&self, from: Cell, target: usize, path: &mut Path) -> bool {
        with_table!(self, table => table.walk(&self.grid, from, target, path))
    }

    /// What the memory takes.
    #[must_use]
    pub fn bytes(&self) -> Bytes {
        Bytes {
            distances: self.image.layout.distances.len(),
            runs: self.image.layout.runs.len(),
            grid: size_of_val(self.grid.row(0)) * self.grid.height() as usize,
            targets: size_of_val(self.targets.as_slice()) + size_of_val(self.by_cell.as_slice()),
        }
    }
}

/// The distances of a cell to all targets.
#[derive(Clone, Copy)]
pub(crate) enum Row<'a> {
    Eight(&'a [<Octile as Metric>::Distance]),
    Sixteen(&'a [<Knight as Metric>::Distance]),
}

impl Row<'_> {
    fn len(self) -> usize {
        match self {
            Self::Eight(row) => row.len(),
            Self::Sixteen(row) => row.len(),
        }
    }

    #[inline]
    pub(crate) fn length(self, target: usize) -> Option<Length> {
        match self {
            Self::Eight(row) => known::<Octile>(row, target).map(Octile::length),
            Self::Sixteen(row) => known::<Knight>(row, target).map(Knight::length),
        }
    }

    #[inline]
    fn cells(self, target: usize) -> f64 {
        let cells = match self {
            Self::Eight(row) => known::<Octile>(row, target).map(Octile::cells),
            Self::Sixteen(row) => known::<Knight>(row, target).map(Knight::cells),
        };
        cells.unwrap_or(f64::INFINITY)
    }
}

#[inline]
fn known<M: Metric>(row: &[M::Distance], target: usize) -> Option<M::Distance> {
    row.get(target).copied().filter(|&distance| distance != M::FAR)
}

/// Plans to known targets only: another goal is [`SearchError::NoTarget`]. Nothing is searched, so that
/// nothing is expanded.
impl Planner for Fields {
    type Workspace = Path;

    fn plan<'w>(&self, from: Cell, to: Cell, path: &'w mut Path) -> Result<Plan<'w>, SearchError> {
        free_index(&self.grid, from)?;
        free_index(&self.grid, to)?;
        let target = self.target_at(to).ok_or(SearchError::NoTarget { cell: to })?;
        if self.walk(from, target, path) {
            Ok(Plan { path, expanded: 0 })
        } else {
            Err(SearchError::NoPath { from, to })
        }
    }
}
