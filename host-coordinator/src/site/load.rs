//! Reads a site's files and reports every mistake in them.

use std::{io, path::Path};

use planning::{
    grid::{Cell, Grid},
    moves::MoveSet,
    rooms::{Door, DoorError, DoorId, Rooms, Subareas},
};
use protocol::PileId;

use super::{
    Site, SiteFrame, SitePile,
    files::{read_map, read_subareas},
};
use crate::{
    diagnostics::{Diagnostic, Diagnostics},
    document::{self, Document, Section, flag, number, one_number_of, pair, text, two_letters, whole},
};

/// How a file is opened: from the disk, or from within the program.
type Open<'a> = &'a dyn Fn(&Path) -> io::Result<String>;

/// From a door, a wall and both its subareas are at most this many cells away: five, so that doors
/// may lie a little before walls that are drawn three cells thick, or a metre of short cells, so that a
/// wide door has its middle.
#[must_use]
pub fn door_reach(resolution_m: f64) -> u32 {
    // `as` saturates.
    ((1.0 / resolution_m).round() as u32).max(5)
}

const NEIGHBOURS: &[(i64, MoveSet)] = &[(8, MoveSet::Eight), (16, MoveSet::Sixteen)];

/// Reads the site in `folder`.
pub(super) fn load(folder: &Path, open: Open<'_>) -> Result<Site, Diagnostics> {
    let file = folder.join("site.toml");
    document::read(&file, open(&file), |document, root| site(document, root, open))
}

fn site(document: &Document<'_>, mut root: Section<'_>, open: Open<'_>) -> Option<Site> {
    let name = root.required("name", &text());
    let map = root.required("map", &text());
    let subareas = root.required("subareas", &text());
    let resolution_m = root.required("resolution_m", &number(0.001..=1000.0));
    let moves = root.required("neighbours", &one_number_of(NEIGHBOURS));
    let frame = frame(root.table("frame"));
    let doors = placed("door", root.tables("door"), door);
    let piles = placed("pile", root.tables("pile"), pile);

    let (map, subareas) = (document.resolve(&map?), document.resolve(&subareas?));
    let grid = noted(document, read_map(&map, open(&map)))?;
    let subareas = noted(document, read_subareas(&subareas, open(&subareas), &grid));
    let piles = site_piles(document, &grid, frame, &piles);
    let (rooms, congestion) =
        rooms(document, &grid, subareas?, frame, &doors, door_reach(resolution_m.unwrap_or(1.0)))?;
    Some(Site {
        name: name?,
        grid,
        rooms,
        frame,
        resolution_m: resolution_m?,
        moves: moves?,
        piles,
        congestion,
    })
}

fn frame(mut section: Section<'_>) -> SiteFrame {
    SiteFrame {
        origin: section.optional("origin", &whole(0..=1)).unwrap_or_default(),
        y_up: section.optional("y_up", &flag()).unwrap_or_default(),
    }
}

/// What a `[[door]]` says besides its number and place.
struct DoorEntry {
    joins: [char; 2],
    joins_line: usize,
    congestion: f64,
}

fn door(section: &mut Section<'_>) -> Option<DoorEntry> {
    let joins = section.required("joins", &two_letters());
    let congestion = section.optional("congestion", &number(0.0..=1.0)).unwrap_or_default();
    Some(DoorEntry { joins: joins?, joins_line: section.line_of("joins"), congestion })
}

/// What a `[[pile]]` says besides its number and place.
struct PileEntry {
    power_w: f64,
    charged: Option<f64>,
}

fn pile(section: &mut Section<'_>) -> Option<PileEntry> {
    let power_w = section.required("power_w", &number(1.0..=1.0e6));
    let charged = section.optional("charged", &number(0.0..=1.0));
    Some(PileEntry { power_w: power_w?, charged })
}

/// A door or pile as it is written, with the line to complain of.
struct Placed<T> {
    entry: T,
    id: u16,
    at: [i32; 2],
    line: usize,
}

/// Reads the entries of one kind, whose numbers must differ.
fn placed<T>(
    kind: &str,
    sections: Vec<Section<'_>>,
    read: fn(&mut Section<'_>) -> Option<T>,
) -> Vec<Placed<T>> {
    let mut seen: Vec<(u16, usize)> = Vec::new();
    let mut all = Vec::new();
    for mut section in sections {
        let id = section.required("id", &whole(0..=u16::MAX.into()));
        let at = section.required("at", &pair("cells"));
        let entry = read(&mut section);
        if let Some((id, first)) = seen.iter().find(|&&(other, _)| Some(other) == id) {
            let problem = format!("{kind} {id} is there twice, first in line {first}");
            section.mistake("id", problem, format!("a number of its own for each {kind}"));
        }
        seen.extend(id.map(|id| (id, section.line_of("id"))));
        if let (Some(entry), Some(id), Some(at)) = (entry, id, at) {
            all.push(Placed { entry, id, at, line: section.line_of("at") });
        }
    }
    all
}

fn site_piles(
    document: &Document<'_>,
    grid: &Grid,
    frame: SiteFrame,
    entries: &[Placed<PileEntry>],
) -> Vec<SitePile> {
    let mut piles: Vec<SitePile> = Vec::new();
    for &Placed { ref entry, id, at, line } in entries {
        let Some(cell) = cell(document, grid, frame, ("pile", id), at, line) else { continue };
        if !grid.is_free(cell) {
            document.mistake(line, format!("pile {id} is in a wall"), "a free cell");
        }
        if let Some(other) = piles.iter().find(|other| other.cell == cell) {
            let problem = format!("pile {id} is where pile {} is", other.id);
            document.mistake(line, problem, "a cell of its own for each pile");
        }
        let power_w = entry.power_w as f32;
        piles.push(SitePile { id: PileId(id), cell, power_w, charged: entry.charged });
    }
    piles.sort_by_key(|pile| pile.id);
    piles
}

fn rooms(
    document: &Document<'_>,
    grid: &Grid,
    subareas: Subareas,
    frame: SiteFrame,
    entries: &[Placed<DoorEntry>],
    reach: u32,
) -> Option<(Rooms, Vec<(DoorId, f64)>)> {
    let mut doors = Vec::new();
    for &Placed { ref entry, id, at, line } in entries {
        let cell = cell(document, grid, frame, ("door", id), at, line);
        let subarea = |name: char| {
            let found = subareas.named(name);
            if found.is_none() {
                let known: String = subareas.iter().map(|(_, name)| name).collect();
                let problem = format!("door {id} joins subarea \"{name}\", which there is not");
                document.mistake(entry.joins_line, problem, format!("two of the letters {known}"));
            }
            found
        };
        let [one, other] = entry.joins.map(subarea);
        if let (Some(cell), Some(one), Some(other)) = (cell, one, other) {
            doors.push(Door { id: DoorId(id), cell, joins: [one, other] });
        }
    }
    let congestion = entries.iter().map(|door| (DoorId(door.id), door.entry.congestion)).collect();
    match Rooms::new(subareas, doors, reach) {
        Ok(rooms) => Some((rooms, congestion)),
        Err(errors) => {
            errors.iter().for_each(|error| note_door(document, entries, error));
            None
        }
    }
}

fn note_door(document: &Document<'_>, entries: &[Placed<DoorEntry>], error: &DoorError) {
    let (door, problem, expected) = match *error {
        // Noted where the numbers were read.
        DoorError::Twice(_) => return,
        DoorError::Blocked(door) => {
            (door, "is in a wall".to_owned(), "a free cell of the opening".to_owned())
        }
        DoorError::JoinsOne(door) => (door, "joins a subarea to itself".into(), "two subareas".into()),
        DoorError::FarFrom { door, subarea, reach } => (
            door,
            format!("does not lead to subarea \"{subarea}\", which it joins"),
            format!("an opening to it within {reach} cells"),
        ),
        DoorError::NoWall { door, reach } => {
            (door, "is in no wall".into(), format!("a blocked cell within {reach} cells of it"))
        }
    };
    let line = entries.iter().find(|entry| entry.id == door.0).map(|entry| entry.line);
    document.mistake(line, format!("door {door} {problem}"), expected);
}

/// The cell at `at` of the site.
fn cell(
    document: &Document<'_>,
    grid: &Grid,
    frame: SiteFrame,
    (kind, id): (&str, u16),
    [x, y]: [i32; 2],
    line: usize,
) -> Option<Cell> {
    let outside =
        |outside| document.mistake(line, format!("{kind} {id} at {outside}"), "a free cell of the map");
    frame.cell_at(grid, x, y).map_err(outside).ok()
}

fn noted<T>(document: &Document<'_>, read: Result<T, Diagnostic>) -> Option<T> {
    read.map_err(|mistake| document.mistake_elsewhere([mistake])).ok()
}

#[cfg(test)]
mod tests {
    use std::{collections::BTreeMap, path::PathBuf};

    use proptest::prelude::*;

    use super::*;

    const MAP: &str = "type octile\nheight 5\nwidth 3\nmap\n...\n@.@\n...\n@.@\n...\n";
    const SUBAREAS: &str = "aaa\n@a@\nbbb\n@b@\nccc\n";
    const SITE: &str = r#"
        name = "three rooms"
        map = "map"
        subareas = "rooms"
        resolution_m = 0.5
        neighbours = 8
        [[door]]
        id = 1
        at = [1, 1]
        joins = ["a", "b"]
        [[door]]
        id = 2
        at = [1, 3]
        joins = ["b", "c"]
        congestion = 0.5
        [[pile]]
        id = 1
        at = [0, 0]
        power_w = 100
    "#;

    fn read(site: String, map: String, subareas: String) -> Result<Site, Diagnostics> {
        let files: BTreeMap<PathBuf, String> = [("site.toml", site), ("map", map), ("rooms", subareas)]
            .map(|(name, text)| (name.into(), text))
            .into();
        load(Path::new(""), &|file| files.get(file).cloned().ok_or_else(|| io::ErrorKind::NotFound.into()))
    }

    #[test]
    fn a_site_without_a_frame_counts_as_its_map_does() {
        let site = read(SITE.into(), MAP.into(), SUBAREAS.into()).unwrap();
        assert_eq!(site.cell_at(0, 0), Ok((0, 0).into()));
        assert_eq!(site.piles.len(), 1);
        assert_eq!(site.congestion, [(DoorId(1), 0.0), (DoorId(2), 0.5)]);
    }

    #[test]
    fn mistakes_in_all_three_files_are_told_at_once() {
        let site = SITE.replace("power_w = 100", "power_w = inf");
        let found = read(site, MAP.into(), SUBAREAS.replace("bbb", "bb")).unwrap_err();
        let told: Vec<_> = found.mistakes().iter().map(ToString::to_string).collect();
        assert_eq!(
            told,
            [
                "site.toml:19: `power_w` is inf, expected a number from 1 to 1000000",
                "rooms:3: 2 cells, expected 3, as the map has",
            ]
        );
    }

    fn spoilt(text: &'static str) -> impl Strategy<Value = String> {
        let replacement = "[\\[\\]{}\"'=.,@#0-9a-z\n -]{0,4}";
        (any::<prop::sample::Index>(), 0usize..12, replacement).prop_map(
            move |(start, length, replacement)| {
                let start = start.index(text.len());
                let end = (start + length).min(text.len());
                [&text[..start], &replacement, &text[end..]].concat()
            },
        )
    }

    proptest! {
        #[test]
        fn spoilt_files_are_read_or_refused_without_panic(
            site in spoilt(SITE), map in spoilt(MAP), subareas in spoilt(SUBAREAS), which in 0..3,
        ) {
            let read = match which {
                0 => read(site, MAP.into(), SUBAREAS.into()),
                1 => read(SITE.into(), map, SUBAREAS.into()),
                _ => read(SITE.into(), MAP.into(), subareas),
            };
            match read {
                Ok(site) => prop_assert!(site.piles.iter().all(|pile| site.grid.is_free(pile.cell))),
                Err(found) => prop_assert!(!found.mistakes().is_empty()),
            }
        }
    }
}
