//! A site: its map, rooms, doors and piles, read from a folder with a `site.toml`.
//!
//! ```toml
//! name = "Ward 3"
//! map = "ward.map"            # MovingAI octile, in this folder
//! subareas = "subareas.txt"   # a letter for every cell: its room
//! resolution_m = 0.5          # a cell is this long
//! neighbours = 16             # moves from a cell: 8 or 16
//!
//! [frame]                     # how this file counts cells; as the map does if left out
//! origin = 1
//! y_up = true
//!
//! [[door]]                    # where a robot passes from one subarea to another
//! id = 1
//! at = [24, 70]
//! joins = ["A", "K"]
//! congestion = 0.45           # LMPP's rho, 0 to 1; 0 if left out
//!
//! [[pile]]
//! id = 1
//! at = [1, 100]
//! power_w = 500
//! charged = 0.9               # it charges a robot, this far; free if left out
//! ```

mod files;
mod frame;
mod load;

use std::{collections::BTreeSet, fs, io, iter, path::Path};

use planning::{
    congestion,
    grid::{Cell, Grid},
    lmpp::{Lmpp, Survey},
    memory::Target,
    moves::{Length, MoveSet},
    rooms::{DoorId, Rooms},
};
use protocol::{Availability, CoordinateM, PileId, Position};

pub use self::{
    files::read_map,
    frame::{OutsideMap, SiteFrame},
    load::door_reach,
};
use crate::{
    diagnostics::Diagnostics,
    selection::{Candidate, Rule},
};

/// A site.
#[derive(Clone, Debug)]
pub struct Site {
    /// What people call it.
    pub name: String,
    /// Where robots can be.
    pub grid: Grid,
    /// Its subareas and the doors between them.
    pub rooms: Rooms,
    /// How its people count cells.
    pub frame: SiteFrame,
    /// The length of a cell in metres, more than 0.
    pub resolution_m: f64,
    /// How robots move from cell to cell.
    pub moves: MoveSet,
    /// Its charging piles, by number.
    pub piles: Vec<SitePile>,
    /// How congested each door is, 0 to 1 (LMPP's rho, eq. 11).
    pub congestion: Vec<(DoorId, f64)>,
}

/// A charging pile's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SitePile {
    /// Which pile.
    pub id: PileId,
    /// The free cell where a robot stands to be charged.
    pub cell: Cell,
    /// What it gives a robot, in watts.
    pub power_w: f32,
    /// How much of its charge a robot on it has, 0 to 1, for questions about the site without a
    /// coordinator; none if the pile is free. The state value of LMPP Table 3.
    pub charged: Option<f64>,
}

impl Site {
    /// Reads the site in `folder`: its `site.toml` and the files that it names.
    ///
    /// # Errors
    /// Every mistake in these files.
    pub fn load(folder: &Path) -> Result<Self, Diagnostics> {
        load::load(folder, &|file| fs::read_to_string(file))
    }

    /// The site of LMPP's Fig. 7, which is built into the program.
    ///
    /// # Errors
    /// None but in a program that was built with a faulty site.
    pub fn fig7() -> Result<Self, Diagnostics> {
        built_in(
            "sites/lmpp-fig7",
            &[
                ("site.toml", include_str!("../../../sites/lmpp-fig7/site.toml")),
                ("fig7.map", include_str!("../../../sites/lmpp-fig7/fig7.map")),
                ("subareas.txt", include_str!("../../../sites/lmpp-fig7/subareas.txt")),
            ],
        )
    }

    /// The site of Access's Experiments 1 and 2, which is built into the program.
    ///
    /// # Errors
    /// None but in a program that was built with a faulty site.
    pub fn access_fig1() -> Result<Self, Diagnostics> {
        built_in(
            "sites/access-fig1",
            &[
                ("site.toml", include_str!("../../../sites/access-fig1/site.toml")),
                ("depot.map", include_str!("../../../sites/access-fig1/depot.map")),
                ("subareas.txt", include_str!("../../../sites/access-fig1/subareas.txt")),
            ],
        )
    }

    /// The site of Access's Fig. 3, which is built into the program.
    ///
    /// # Errors
    /// None but in a program that was built with a faulty site.
    pub fn access_fig3() -> Result<Self, Diagnostics> {
        built_in(
            "sites/access-fig3",
            &[
                ("site.toml", include_str!("../../../sites/access-fig3/site.toml")),
                ("access.map", include_str!("../../../sites/access-fig3/access.map")),
                ("subareas.txt", include_str!("../../../sites/access-fig3/subareas.txt")),
            ],
        )
    }

    /// The cell at site coordinates `(x, y)`.
    ///
    /// # Errors
    /// [`OutsideMap`] if there is none.
    pub fn cell_at(&self, x: i32, y: i32) -> Result<Cell, OutsideMap> {
        self.frame.cell_at(&self.grid, x, y)
    }

    /// The site coordinates of `cell`.
    #[must_use]
    pub fn coordinates(&self, cell: Cell) -> (i32, i32) {
        self.frame.coordinates(&self.grid, cell)
    }

    /// The middle of `cell` in metres: site coordinates times the resolution.
    #[must_use]
    pub fn position(&self, cell: Cell) -> Position {
        let (x, y) = self.coordinates(cell);
        let metres =
            |coordinate: i32| CoordinateM::clamped((f64::from(coordinate) * self.resolution_m) as f32);
        Position { x: metres(x), y: metres(y) }
    }

    /// The cell that `position` is in, if it is on the map.
    #[must_use]
    pub fn cell_of(&self, position: Position) -> Option<Cell> {
        // `as` saturates; what is far out is outside the map.
        let whole = |metres: CoordinateM| (f64::from(metres.get()) / self.resolution_m).round() as i32;
        self.cell_at(whole(position.x), whole(position.y)).ok()
    }

    /// Where `position` is in the map's picture: in cells from the middle of the upper left one,
    /// x to the right and y down, with fractions.
    #[must_use]
    pub fn picture_of(&self, position: Position) -> [f64; 2] {
        let cells =
            |metres: CoordinateM| f64::from(metres.get()) / self.resolution_m - f64::from(self.frame.origin);
        let (x, y) = (cells(position.x), cells(position.y));
        [x, if self.frame.y_up { f64::from(self.grid.height()) - 1.0 - y } else { y }]
    }

    /// Ways to all piles from memory, by the doors that are no more congested than `theta`.
    #[must_use]
    pub fn lmpp(&self, theta: f64) -> Lmpp {
        let mut lmpp = Lmpp::new(self.grid.clone(), self.moves, self.rooms.clone(), self.targets());
        lmpp.close(self.doors_to_avoid(theta));
        lmpp
    }

    /// The doors that are more congested than `theta` (LMPP eq. 11).
    #[must_use]
    pub fn doors_to_avoid(&self, theta: f64) -> BTreeSet<DoorId> {
        congestion::avoided(self.congestion.iter().copied(), theta)
    }

    /// Whether a door leads to the subarea of `pile`.
    #[must_use]
    pub fn has_door_to(&self, pile: &SitePile) -> bool {
        let subarea = self.rooms.find_subarea(pile.cell);
        subarea.is_some_and(|subarea| self.rooms.doors_of(subarea).next().is_some())
    }

    /// The piles as targets of a planner.
    #[must_use]
    pub fn targets(&self) -> Vec<Target> {
        self.piles.iter().map(|pile| Target { id: pile.id.0, cell: pile.cell }).collect()
    }

    /// What the site file and `survey` say of every pile, with the `probabilities` of the piles
    /// in their order, 0 where there are not enough.
    ///
    /// The site file has the state value of LMPP Table 3, the share of a charge that is done.
    /// The paper takes it for q, which eq. 1 defines as the share still ahead; so does
    /// [`Rule::PaperLiteral`].
    #[must_use]
    pub fn candidates(&self, survey: &Survey<'_>, probabilities: &[f64], rule: Rule) -> Vec<Candidate> {
        let probabilities = probabilities.iter().copied().chain(iter::repeat(0.0));
        let candidate = |(pile, probability): (&SitePile, f64)| Candidate {
            pile: pile.id,
            availability: Some(pile.charged.map_or(Availability::Free, |_| Availability::Charging)),
            remaining: match (rule, pile.charged) {
                (_, None) => 0.0,
                (Rule::PaperLiteral, Some(charged)) => charged,
                (Rule::Corrected, Some(charged)) => 1.0 - charged,
            },
            distance: survey.length_to(pile.id.0).map(Length::units),
            probability,
        };
        self.piles.iter().zip(probabilities).map(candidate).collect()
    }

    /// The pile with this number.
    #[must_use]
    pub fn pile(&self, id: PileId) -> Option<&SitePile> {
        self.piles.binary_search_by_key(&id, |pile| pile.id).ok().and_then(|at| self.piles.get(at))
    }
}

/// Reads a site from files within the program.
fn built_in(folder: &str, files: &[(&str, &str)]) -> Result<Site, Diagnostics> {
    load::load(Path::new(folder), &|file| {
        let named = files.iter().find(|(name, _)| file.ends_with(name));
        named.map(|(_, text)| (*text).to_owned()).ok_or_else(|| io::ErrorKind::NotFound.into())
    })
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn the_built_in_site_is_the_one_in_the_repository() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../sites/lmpp-fig7");
        let (built_in, read) = (Site::fig7().unwrap(), Site::load(&folder).unwrap());
        assert_eq!((built_in.grid, built_in.rooms), (read.grid, read.rooms));
        assert_eq!((built_in.piles.len(), built_in.congestion.len()), (13, 7));
    }

    #[test]
    fn every_built_in_site_can_be_read() {
        assert_eq!(Site::access_fig1().unwrap().piles.len(), 6);
        assert_eq!(Site::access_fig3().unwrap().piles.len(), 12);
    }

    #[test]
    fn the_middle_of_every_cell_is_in_that_cell() {
        let site = Site { resolution_m: 0.05, ..Site::fig7().unwrap() };
        for cell in site.grid.free_cells() {
            assert_eq!(site.cell_of(site.position(cell)), Some(cell));
            let [x, y] = site.picture_of(site.position(cell));
            assert!((x - f64::from(cell.x)).abs() < 1e-3 && (y - f64::from(cell.y)).abs() < 1e-3, "{cell}");
        }
    }

    #[test]
    fn a_position_far_out_is_on_no_cell() {
        let site = Site { resolution_m: 0.001, ..Site::fig7().unwrap() };
        for far in [CoordinateM::MIN, CoordinateM::MAX] {
            assert_eq!(site.cell_of(Position { x: far, y: far }), None);
        }
    }

    #[test]
    fn doors_more_congested_than_theta_are_closed() {
        let site = Site::fig7().unwrap();
        let start = site.cell_at(40, 64).unwrap();
        let nearest = |theta| {
            let lmpp = site.lmpp(theta);
            lmpp.survey(start).unwrap().nearest().unwrap().0
        };
        assert_eq!((nearest(1.0), nearest(0.3)), (5, 2), "door 1 is congested");
    }
}
