//! The floor as robots know it: where to work, where the piles are, and the ways to both.
//!
//! It is the same for all robots of a site and does not change, so it is built once and shared. The
//! ways are recalled from fields and nothing is searched for, so there are a few dozen places of work
//! and not one on every cell.

use std::{collections::BTreeMap, sync::Arc};

use planning::{
    grid::Cell,
    memory::Fields,
    path::Path,
    search::{Dijkstra, Workspace},
};
use protocol::PileId;

use super::ground::{KEEP_CLEAR_M, Point, Route};
use crate::site::Site;

/// The most places of work.
const PLACES: usize = 48;
/// Cells times places, so that the fields of a large map stay small.
const MOST_ENTRIES: usize = 1 << 24;

/// Places of work and piles, with the ways from everywhere to each of them.
#[derive(Debug)]
pub struct Terrain {
    site: Arc<Site>,
    places: Vec<Point>,
    piles: Vec<Point>,
    /// To the places, then to the piles.
    fields: Fields,
}

impl Terrain {
    /// The floor of `site`, its places of work spread over it.
    #[must_use]
    pub fn new(site: &Arc<Site>) -> Self {
        let all = places_of_work(site);
        let count = (MOST_ENTRIES / site.grid.len().max(1)).clamp(1, PLACES);
        let cells: Vec<Cell> = all.iter().step_by(all.len().div_ceil(count).max(1)).copied().collect();
        let piles = site.piles.iter().map(|pile| pile.cell);
        let targets: Vec<Cell> = cells.iter().copied().chain(piles).collect();
        Self {
            fields: Fields::build(site.grid.clone(), site.moves, &targets),
            places: cells.iter().map(|&cell| site.position(cell).into()).collect(),
            piles: site.piles.iter().map(|pile| site.position(pile.cell).into()).collect(),
            site: Arc::clone(site),
        }
    }

    /// The site.
    #[must_use]
    pub const fn site(&self) -> &Arc<Site> {
        &self.site
    }

    /// Where robots may work.
    #[must_use]
    pub fn places(&self) -> &[Point] {
        &self.places
    }

    /// Where the piles' contacts are, in the site's order.
    #[must_use]
    pub fn piles(&self) -> &[Point] {
        &self.piles
    }

    /// The shortest way to a place of work by its number; `None` if there is none. `path` is a buffer.
    #[must_use]
    pub fn route_to_place(&self, from: Point, place: usize, path: &mut Path) -> Option<Route> {
        let from = self.site.cell_of(from.into())?;
        let found = place < self.places.len() && self.fields.walk(from, place, path);
        found.then(|| path.waypoints().iter().map(|&cell| self.site.position(cell).into()).collect())
    }

    /// The lengths of the shortest ways to the piles that can be reached, in cells.
    #[must_use]
    pub fn ways_to_piles(&self, from: Point) -> BTreeMap<PileId, f64> {
        let Some(from) = self.site.cell_of(from.into()) else { return BTreeMap::new() };
        let lengths = self.fields.lengths(from).skip(self.places.len());
        let ways = self.site.piles.iter().zip(lengths);
        ways.filter_map(|(pile, length)| Some((pile.id, length?.units()))).collect()
    }

    /// The shortest way to a pile's contacts; `None` if there is none. `path` is a buffer.
    #[must_use]
    pub fn route_to_pile(&self, from: Point, pile: PileId, path: &mut Path) -> Option<Route> {
        let from = self.site.cell_of(from.into())?;
        let index = self.site.piles.iter().position(|known| known.id == pile)?;
        let found = self.fields.walk(from, self.places.len() + index, path);
        found.then(|| path.waypoints().iter().map(|&cell| self.site.position(cell).into()).collect())
    }

    /// The length of the shortest way to the nearest pile in metres; `None` if no way leads to any.
    #[must_use]
    pub fn nearest_pile_m(&self, from: Point) -> Option<f64> {
        let from = self.site.cell_of(from.into())?;
        let lengths = self.fields.lengths(from).skip(self.places.len()).flatten();
        lengths.map(|length| length.units() * self.site.resolution_m).min_by(f64::total_cmp)
    }
}

/// Where robots may work on `site`: on every free cell that is not close to a pile and can be
/// reached from its first one.
fn places_of_work(site: &Site) -> Vec<Cell> {
    let piles: Vec<Point> = site.piles.iter().map(|pile| site.position(pile.cell).into()).collect();
    let mut workspace = Workspace::default();
    let Some(Ok(ways)) = site
        .piles
        .first()
        .map(|pile| Dijkstra::new(&site.grid, site.moves).ways(pile.cell, &[], &mut workspace))
    else {
        return Vec::new();
    };
    let clear = |cell: &Cell| {
        let point = Point::from(site.position(*cell));
        piles.iter().all(|pile| pile.distance_m(point) >= KEEP_CLEAR_M)
    };
    site.grid.free_cells().filter(clear).filter(|&cell| ways.leads_to(cell)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_of_work_is_clear_of_the_piles_and_has_a_way_to_every_other() {
        let terrain = Terrain::new(&Arc::new(Site::fig7().unwrap()));
        assert!((PLACES - 2..=PLACES).contains(&terrain.places().len()), "{}", terrain.places().len());
        let mut path = Path::default();
        for &from in terrain.places() {
            assert!(terrain.piles().iter().all(|pile| pile.distance_m(from) >= KEEP_CLEAR_M));
            for (place, &to) in terrain.places().iter().enumerate() {
                let route = terrain.route_to_place(from, place, &mut path).unwrap();
                assert_eq!((route.front(), route.back()), (Some(&from), Some(&to)));
            }
            assert!(terrain.nearest_pile_m(from).unwrap() >= KEEP_CLEAR_M);
        }
    }

    #[test]
    fn nothing_leads_anywhere_from_outside_the_map() {
        let terrain = Terrain::new(&Arc::new(Site::fig7().unwrap()));
        let outside = Point { x_m: -5.0, y_m: 3.0 };
        assert_eq!(terrain.route_to_place(outside, 0, &mut Path::default()), None);
        assert_eq!(terrain.nearest_pile_m(outside), None);
        let inside = terrain.places()[0];
        assert_eq!(terrain.route_to_place(inside, 1_000, &mut Path::default()), None);
    }
}
