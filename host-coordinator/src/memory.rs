//! The memory of a site's paths in a file, so that a restart does not plan it again.
//!
//! The file is `<event log>.fields`, beside the event log. It is made if it is not there, and made again if
//! it is damaged, of another version, or of another map, other doors, piles or moves: what is wrong with it
//! is said in the log and costs the time of planning, no more. It is mapped, not read: what no robot asks
//! for stays on the disk, and closed doors change the memory only.

use std::{
    ffi::OsString,
    fs::File,
    io::{self, Write},
    path::{Path, PathBuf},
    time::Instant,
};

use memmap2::{MmapMut, MmapOptions};
use planning::{lmpp::Lmpp, memory::FileError};
use tempfile::NamedTempFile;

use crate::site::Site;

/// Why the file is of no use.
#[derive(Debug, thiserror::Error)]
enum Unusable {
    #[error("{0}")]
    File(#[from] io::Error),
    #[error("{0}")]
    Content(#[from] FileError),
}

/// The memory of `site` with all doors open, from the file beside `event_log` or planned and kept there.
#[must_use]
pub fn recall_or_plan(site: &Site, event_log: &Path) -> Lmpp {
    let file = file_beside(event_log);
    let start = Instant::now();
    let millis = |start: Instant| start.elapsed().as_secs_f64() * 1e3;
    let why = match recall(site, &file) {
        Ok(lmpp) => {
            tracing::info!("paths recalled from {} in {:.1} ms", file.display(), millis(start));
            return lmpp;
        }
        Err(why) => why,
    };
    let start = Instant::now();
    let lmpp = site.lmpp(1.0);
    let planned = millis(start);
    match keep(&lmpp, &file) {
        Ok(()) => tracing::info!(
            "paths planned in {planned:.1} ms and kept in {}, which was of no use: {why}",
            file.display()
        ),
        Err(error) => tracing::warn!(
            "paths planned in {planned:.1} ms, and not kept: {} cannot be written: {error}; every start plans \
             them until it can",
            file.display()
        ),
    }
    lmpp
}

/// `<event log>.fields`.
fn file_beside(event_log: &Path) -> PathBuf {
    let mut name = OsString::from(event_log);
    name.push(".fields");
    name.into()
}

fn recall(site: &Site, file: &Path) -> Result<Lmpp, Unusable> {
    let bytes = map(&File::open(file)?)?;
    let (grid, rooms) = (site.grid.clone(), site.rooms.clone());
    Ok(Lmpp::restore(grid, site.moves, rooms, site.targets(), Box::new(bytes))?)
}

/// Maps a file privately: changes stay in memory.
fn map(file: &File) -> io::Result<MmapMut> {
    // SAFETY: nobody writes to the file once it has its name: `keep` writes another file and puts it in its
    // place, and the mapped one lives on without a name. Only a person who cuts off the file in place while
    // the coordinator runs could pull memory from under it.
    unsafe { MmapOptions::new().map_copy(file) }
}

/// Writes the file: whole or not at all.
fn keep(lmpp: &Lmpp, file: &Path) -> io::Result<()> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut written = NamedTempFile::new_in(folder.unwrap_or(Path::new(".")))?;
    written.write_all(&lmpp.fields().to_bytes())?;
    written.as_file().sync_all()?;
    written.persist(file)?;
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::fs;

    use super::*;

    /// All lengths from some cells.
    fn lengths(lmpp: &Lmpp) -> Vec<(u16, planning::moves::Length)> {
        let cells: Vec<_> = lmpp.grid().free_cells().step_by(97).collect();
        cells.iter().flat_map(|&cell| lmpp.survey(cell).unwrap().lengths().collect::<Vec<_>>()).collect()
    }

    #[test]
    fn a_restart_recalls_what_was_planned() {
        let site = Site::fig7().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("events.sqlite");
        let file = folder.path().join("events.sqlite.fields");
        assert!(recall(&site, &file).is_err());
        let planned = recall_or_plan(&site, &log);
        let kept = fs::read(&file).unwrap();
        let mut recalled = recall(&site, &file).unwrap();
        assert!(recalled.fields() == planned.fields());
        assert_eq!(lengths(&recalled), lengths(&planned));
        // Doors that close change nothing in the file.
        recalled.close(site.doors_to_avoid(0.3));
        assert_eq!(lengths(&recalled), lengths(&site.lmpp(0.3)));
        assert!(fs::read(&file).unwrap() == kept);
    }

    #[test]
    fn a_damaged_or_foreign_file_is_replaced() {
        let site = Site::fig7().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("events.sqlite");
        let file = folder.path().join("events.sqlite.fields");
        let planned = recall_or_plan(&site, &log);
        let good = fs::read(&file).unwrap();
        let mut flipped = good.clone();
        flipped[good.len() / 2] ^= 1;
        let mut fewer_piles = site.clone();
        fewer_piles.piles.pop();
        let of_another_site = fewer_piles.lmpp(1.0).fields().to_bytes();
        for bad in [&good[..good.len() / 2], &flipped, &of_another_site, b"no fields", b""] {
            fs::write(&file, bad).unwrap();
            assert!(recall(&site, &file).is_err());
            assert_eq!(lengths(&recall_or_plan(&site, &log)), lengths(&planned));
            assert!(fs::read(&file).unwrap() == good);
        }
    }

    #[test]
    fn without_a_place_to_write_the_paths_are_planned() {
        let site = Site::fig7().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("missing").join("events.sqlite");
        assert_eq!(lengths(&recall_or_plan(&site, &log)), lengths(&site.lmpp(1.0)));
    }
}
