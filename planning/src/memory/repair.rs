//! Builds fields, and repairs them where cells are blocked or freed, so that they are as if they had been
//! built anew.
//!
//! For up to [`LANES`] fields at once: (1) a cell without a neighbour that its distance is owed to any more
//! loses it, and so in turn do the cells that owed theirs to it; (2) cells take the shortest ways over their
//! neighbours until none is shorter; (3) around what changed, moves are chosen and their repeats counted
//! again. Each is a rule that is swept over the map. A field that is built has lost everything before.

use std::ops::Range;

use super::{
    fields::Repaired,
    lanes::{Lanes, division},
    metric::Metric,
    sweep::{Rule, Segments, Spread, Sweep, each},
    table::TableMut,
};
use crate::{
    grid::{Cell, Grid},
    search::neighbours::Moves,
};

/// Fields that are worked on together.
const LANES: usize = 16;
/// As many, where there are no more.
const FEW: usize = 4;

/// So many times the segments of a map may be visited to find what was lost, before building the fields anew
/// is taken to be cheaper.
const WORTHWHILE: (usize, usize) = (1, 1);

/// Builds the fields of targets in these places; there is no way to one without.
pub(super) fn build<M: Metric>(grid: &Grid, places: &[Option<usize>], mut table: TableMut<'_, M>) {
    for targets in groups(places.len()) {
        build_group(grid, places, &mut table, &targets);
    }
}

/// Repairs the fields of targets in these places where cells have changed.
pub(super) fn repair<M: Metric>(
    grid: &Grid,
    changed: &[Cell],
    places: &[Option<usize>],
    mut table: TableMut<'_, M>,
) -> Repaired {
    let division = division::<M>(grid);
    let mut near = division.none();
    let reach = division.reach as i32;
    for cell in changed {
        let around = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| cell.offset(dx, dy)));
        around.filter(|&cell| grid.index(cell).is_some()).for_each(|cell| division.put(cell, &mut near));
    }
    let mut repaired = Repaired::default();
    for targets in groups(places.len()) {
        let is_repaired = if targets.len() <= FEW {
            Work::<M, FEW>::over(grid, places, &mut table, &targets).repair(&near)
        } else {
            Work::<M, LANES>::over(grid, places, &mut table, &targets).repair(&near)
        };
        if is_repaired {
            repaired.repaired += targets.len();
        } else {
            build_group(grid, places, &mut table, &targets);
            repaired.rebuilt += targets.len();
        }
    }
    repaired
}

/// Targets that are worked on together.
fn groups(targets: usize) -> impl Iterator<Item = Range<usize>> {
    (0..targets).step_by(LANES).map(move |start| start..(start + LANES).min(targets))
}

fn build_group<M: Metric>(
    grid: &Grid,
    places: &[Option<usize>],
    table: &mut TableMut<'_, M>,
    targets: &Range<usize>,
) {
    if targets.len() <= FEW {
        Work::<M, FEW>::anew(grid, places, table, targets).build();
    } else {
        Work::<M, LANES>::anew(grid, places, table, targets).build();
    }
}

/// The work on a group of fields.
struct Work<'a, 't, M: Metric, const N: usize> {
    lanes: Lanes<'a, M, N>,
    table: &'a mut TableMut<'t, M>,
    targets: &'a Range<usize>,
    places: [Option<usize>; N],
}

impl<'a, 't, M: Metric, const N: usize> Work<'a, 't, M, N> {
    /// On fields as they are.
    fn over(
        grid: &'a Grid,
        places: &[Option<usize>],
        table: &'a mut TableMut<'t, M>,
        targets: &'a Range<usize>,
    ) -> Self {
        Self::on(Lanes::empty(grid), places, table, targets)
    }

    /// On fields from nothing.
    fn anew(
        grid: &'a Grid,
        places: &[Option<usize>],
        table: &'a mut TableMut<'t, M>,
        targets: &'a Range<usize>,
    ) -> Self {
        Self::on(Lanes::blank(grid), places, table, targets)
    }

    fn on(
        lanes: Lanes<'a, M, N>,
        places: &[Option<usize>],
        table: &'a mut TableMut<'t, M>,
        targets: &'a Range<usize>,
    ) -> Self {
        let mut own = [None; N];
        own.iter_mut().zip(&places[targets.clone()]).for_each(|(own, &place)| *own = place);
        Self { lanes, table, targets, places: own }
    }

    fn build(mut self) {
        let all = self.lanes.division.all();
        let mut sweep = Sweep::new(self.lanes.division);
        self.find(&mut sweep);
        self.finish(&mut sweep, &all);
    }

    /// Repairs them where the moves of cells have changed; returns whether that was worth its while. If not,
    /// they are as they were.
    fn repair(mut self, near: &Segments) -> bool {
        let division = self.lanes.division;
        let mut sweep = Sweep::new(division);
        sweep.visit(near);
        if sweep.run(&mut Lose(&mut self), division.len() * WORTHWHILE.0 / WORTHWHILE.1).is_none() {
            return false;
        }
        let lost = sweep.changed.clone();
        sweep.visit(&lost);
        sweep.visit(near);
        self.find(&mut sweep);
        let mut stale = sweep.changed.clone();
        stale.iter_mut().zip(near).for_each(|(stale, near)| *stale |= near);
        self.finish(&mut sweep, &division.heightened(&stale));
        true
    }

    /// Gives distances, from the targets and from what is to be visited.
    fn find(&mut self, sweep: &mut Sweep) {
        let division = self.lanes.division;
        let mut starts = division.none();
        for (lane, place) in self.places.into_iter().enumerate() {
            let Some(place) = place else { continue };
            let (y, segment) = division.segment_of(place);
            self.lanes.load(self.table, self.targets, y, segment);
            if self.lanes.distances[place][lane] != M::HERE {
                self.lanes.distances[place][lane] = M::HERE;
                starts[y] |= division.widened(segment);
            }
        }
        sweep.visit(&division.heightened(&starts));
        sweep.changed.iter_mut().zip(starts).for_each(|(changed, start)| *changed |= start);
        sweep.run(&mut Find(self), usize::MAX);
    }

    /// Chooses moves and counts runs in these segments and wherever it matters to, and puts all into the
    /// tables.
    fn finish(mut self, sweep: &mut Sweep, stale: &Segments) {
        let division = self.lanes.division;
        for (y, &segments) in stale.iter().enumerate() {
            for segment in each(segments) {
                self.lanes.load(self.table, self.targets, y, segment);
                division.columns(segment).for_each(|x| self.lanes.choose(y * division.width + x));
            }
        }
        let wide: Segments = stale.iter().map(|&segments| division.widened(segments)).collect();
        sweep.visit(&division.heightened(&wide));
        sweep.run(&mut Count(&mut self), usize::MAX);
        let mut changed = std::mem::take(&mut sweep.changed);
        changed.iter_mut().zip(stale).for_each(|(changed, stale)| *changed |= stale);
        self.lanes.store(self.table, self.targets, &changed);
    }
}

/// Step 1: no cell has a distance that no neighbour leads to.
struct Lose<'w, 'a, 't, M: Metric, const N: usize>(&'w mut Work<'a, 't, M, N>);
/// Step 2: no cell has a longer distance than over a neighbour.
struct Find<'w, 'a, 't, M: Metric, const N: usize>(&'w mut Work<'a, 't, M, N>);
/// Step 3: every move repeats once more often than the next, if that is the same.
struct Count<'w, 'a, 't, M: Metric, const N: usize>(&'w mut Work<'a, 't, M, N>);

macro_rules! rule {
    ($rule:ident, $spread:ident, |$lanes:ident, $places:ident, $index:ident, $moves:ident| $look:expr) => {
        impl<M: Metric, const N: usize> Rule for $rule<'_, '_, '_, M, N> {
            const SPREAD: Spread = Spread::$spread;

            #[inline]
            fn enter(&mut self, y: usize, segment: u64) {
                let Work { lanes, table, targets, .. } = &mut *self.0;
                lanes.load(table, targets, y, segment);
            }

            #[inline(always)]
            fn look<const $moves: Moves>(&mut self, $index: usize) -> bool {
                let Work { lanes: $lanes, places: $places, .. } = &mut *self.0;
                $look
            }
        }
    };
}

rule!(Lose, Anywhere, |lanes, places, index, MOVES| lanes.lose(index, places));
rule!(Find, Around, |lanes, _places, index, MOVES| lanes.find::<MOVES>(index));
rule!(Count, Onward, |lanes, _places, index, MOVES| lanes.count::<MOVES>(index));
