//! The event log: an SQLite file, and the only truth about the past.
//!
//! The table `events` has a row for each [`Event`]: its number, its time, and what happened as
//! JSON, so that a person can read the log with any SQLite tool while no coordinator runs. Rows
//! are only ever appended, a batch in one transaction, which is on the disk (WAL,
//! `synchronous = FULL`) before [`Store::append`] returns. The file is locked while it is open:
//! two coordinators cannot write one past.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, Read as _},
    path::{Path, PathBuf},
    time::Duration,
};

use protocol::SiteMillis;
use rusqlite::{Connection, ErrorCode, OpenFlags, params};

use crate::core::{Decision, Event, Fact};

/// Says that a file is one of ours (SQLite's `application_id`): "ChHd".
const APPLICATION: i32 = 0x4368_4864;
/// The version of the log's form (SQLite's `user_version`).
const VERSION: i32 = 1;
/// What every SQLite file begins with.
const MAGIC: &[u8; 16] = b"SQLite format 3\0";

/// An open event log.
#[derive(Debug)]
pub struct Store {
    file: PathBuf,
    connection: Connection,
    /// Which event each decision is.
    decisions: BTreeMap<u64, i64>,
}

/// Why an event log can't be read or written.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The file cannot be read at all.
    #[error("cannot open the event log {}: {cause}; check the path and its permissions", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// The file is something else.
    #[error(
        "{} is no event log of Chargehand ({what}); it was left untouched. Name another file as event_log",
        file.display()
    )]
    Foreign {
        /// The file.
        file: PathBuf,
        /// What it is instead.
        what: &'static str,
    },
    /// The log has a form that this program does not know.
    #[error(
        "the event log {} has version {version}, this program knows version {VERSION}; it was left \
         untouched. Use the newer program",
        file.display()
    )]
    Version {
        /// The file.
        file: PathBuf,
        /// The version in it.
        version: i32,
    },
    /// Another process has the log open.
    #[error("the event log {} is in use: stop the other coordinator, or name another file", file.display())]
    InUse {
        /// The file.
        file: PathBuf,
    },
    /// The log is damaged.
    #[error(
        "the event log {} is damaged: {cause}; it was left as it is. Restore a copy of it, or move \
         it away to begin a new one",
        file.display()
    )]
    Damaged {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        cause: String,
    },
    /// The log has no room.
    #[error("no room to write the event log {}: free space on its disk", file.display())]
    Full {
        /// The file.
        file: PathBuf,
    },
    /// Anything else that SQLite reports.
    #[error("cannot write the event log {}: {cause}", file.display())]
    Failed {
        /// The file.
        file: PathBuf,
        /// What SQLite says.
        cause: rusqlite::Error,
    },
}

impl Store {
    /// Opens the log in `file`, or begins one if there is none, and reads all events in it.
    ///
    /// # Errors
    /// [`StoreError`] if the file is no log, is damaged, in use, or cannot be opened. It is not
    /// changed then.
    pub fn open(file: &Path) -> Result<(Self, Vec<Event>), StoreError> {
        check_header(file)?;
        let failed = |cause| Self::error(file, cause);
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE;
        let connection = Connection::open_with_flags(file, flags).map_err(failed)?;
        connection.busy_timeout(Duration::from_millis(500)).map_err(failed)?;
        connection.pragma_update(None, "locking_mode", "EXCLUSIVE").map_err(failed)?;
        let mut store = Self { file: file.to_owned(), connection, decisions: BTreeMap::new() };
        store.prepare()?;
        let numbered = store.read()?;
        let decisions = numbered.iter().filter_map(|(number, event)| Some((decided(event)?, *number)));
        store.decisions = decisions.collect();
        Ok((store, numbered.into_iter().map(|(_, event)| event).collect()))
    }

    /// Reads all events in the log in `file`, which no coordinator has open, and changes nothing.
    ///
    /// # Errors
    /// [`StoreError`] if the file is not there, is no log, is damaged or in use.
    pub fn read_only(file: &Path) -> Result<Vec<Event>, StoreError> {
        let unreadable = |cause| StoreError::Unreadable { file: file.to_owned(), cause };
        std::fs::metadata(file).map_err(unreadable)?;
        check_header(file)?;
        let failed = |cause| Self::error(file, cause);
        let connection =
            Connection::open_with_flags(file, OpenFlags::SQLITE_OPEN_READ_ONLY).map_err(failed)?;
        let store = Self { file: file.to_owned(), connection, decisions: BTreeMap::new() };
        Ok(store.read()?.into_iter().map(|(_, event)| event).collect())
    }

    /// Appends events, all or none, and returns when they are on the disk.
    ///
    /// # Errors
    /// [`StoreError`]; nothing was appended then, and the same events can be tried again.
    pub fn append(&mut self, events: &[Event]) -> Result<(), StoreError> {
        let appended = self.try_append(events).map_err(|cause| Self::error(&self.file, cause))?;
        self.decisions.extend(appended);
        Ok(())
    }

    /// The decision with this number; `None` if none has it.
    ///
    /// # Errors
    /// [`StoreError`] if the log can't be read.
    pub fn decision(&self, id: u64) -> Result<Option<Decision>, StoreError> {
        let Some(number) = self.decisions.get(&id) else { return Ok(None) };
        let fact: String = self
            .connection
            .query_row("SELECT fact FROM events WHERE number = ?1", [number], |row| row.get(0))
            .map_err(|cause| Self::error(&self.file, cause))?;
        match self.parse(*number, &fact)? {
            Fact::Decided(decision) => Ok(Some(decision)),
            _ => Ok(None),
        }
    }

    /// The file of the log.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Makes SQLite report a full disk beyond so many pages.
    #[cfg(test)]
    pub(crate) fn limit_pages(&self, pages: u32) {
        self.connection.pragma_update(None, "max_page_count", pages).unwrap();
    }

    /// Answers which decisions were appended as which events.
    fn try_append(&mut self, events: &[Event]) -> Result<Vec<(u64, i64)>, rusqlite::Error> {
        let transaction = self.connection.transaction()?;
        let mut decisions = Vec::new();
        let mut insert = transaction.prepare_cached("INSERT INTO events (at_ms, fact) VALUES (?1, ?2)")?;
        for event in events {
            let fact = serde_json::to_string(&event.fact)
                .map_err(|error| rusqlite::Error::ToSqlConversionFailure(error.into()))?;
            let at_ms = i64::try_from(event.at.0).unwrap_or(i64::MAX);
            let number = insert.insert(params![at_ms, fact])?;
            decisions.extend(decided(event).map(|id| (id, number)));
        }
        drop(insert);
        transaction.commit()?;
        Ok(decisions)
    }

    /// Checks a log, or makes the file one if it is empty. The marks of an event log are written
    /// in the same transaction as its table, before the change to WAL: whatever is cut short
    /// leaves an empty file or a whole log.
    fn prepare(&self) -> Result<(), StoreError> {
        let failed = |cause| Self::error(&self.file, cause);
        let tables: u32 = self
            .connection
            .query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0))
            .map_err(failed)?;
        if tables == 0 {
            self.connection
                .execute_batch(&format!(
                    "BEGIN IMMEDIATE;
                     PRAGMA application_id = {APPLICATION};
                     PRAGMA user_version = {VERSION};
                     CREATE TABLE events (
                         number INTEGER PRIMARY KEY,
                         at_ms INTEGER NOT NULL,
                         fact TEXT NOT NULL
                     ) STRICT;
                     COMMIT;"
                ))
                .map_err(failed)?;
        }
        self.connection.pragma_update(None, "journal_mode", "WAL").map_err(failed)?;
        self.connection.pragma_update(None, "synchronous", "FULL").map_err(failed)?;
        let verdict: String =
            self.connection.query_row("PRAGMA quick_check(1)", [], |row| row.get(0)).map_err(failed)?;
        if verdict != "ok" {
            return Err(StoreError::Damaged { file: self.file.clone(), cause: verdict });
        }
        Ok(())
    }

    /// All events with their numbers.
    fn read(&self) -> Result<Vec<(i64, Event)>, StoreError> {
        let failed = |cause| Self::error(&self.file, cause);
        let mut select = self
            .connection
            .prepare("SELECT number, at_ms, fact FROM events ORDER BY number")
            .map_err(failed)?;
        let rows = select
            .query_map([], |row| Ok((row.get::<_, i64>(0)?, row.get::<_, i64>(1)?, row.get::<_, String>(2)?)))
            .map_err(failed)?;
        rows.map(|row| {
            let (number, at, fact) = row.map_err(failed)?;
            let fact = self.parse(number, &fact)?;
            Ok((number, Event { at: SiteMillis(u64::try_from(at).unwrap_or(0)), fact }))
        })
        .collect()
    }

    fn parse(&self, number: i64, fact: &str) -> Result<Fact, StoreError> {
        serde_json::from_str(fact).map_err(|error| StoreError::Damaged {
            file: self.file.clone(),
            cause: format!("event {number} is not readable ({error})"),
        })
    }

    fn error(file: &Path, cause: rusqlite::Error) -> StoreError {
        let file = file.to_owned();
        match cause.sqlite_error_code() {
            Some(ErrorCode::DiskFull) => StoreError::Full { file },
            Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => StoreError::InUse { file },
            Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) => {
                StoreError::Damaged { file, cause: cause.to_string() }
            }
            _ => StoreError::Failed { file, cause },
        }
    }
}

/// The number of the decision that an event is.
const fn decided(event: &Event) -> Option<u64> {
    match &event.fact {
        Fact::Decided(decision) => Some(decision.id),
        _ => None,
    }
}

/// Reads a file's first bytes, before SQLite could change anything in it.
fn check_header(file: &Path) -> Result<(), StoreError> {
    let unreadable = |cause| StoreError::Unreadable { file: file.to_owned(), cause };
    let opened = match File::open(file) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        opened => opened.map_err(unreadable)?,
    };
    let mut header = Vec::new();
    opened.take(100).read_to_end(&mut header).map_err(unreadable)?;
    if header.is_empty() {
        return Ok(());
    }
    let foreign = |what| Err(StoreError::Foreign { file: file.to_owned(), what });
    let number =
        |at: usize| -> Option<i32> { Some(i32::from_be_bytes(header.get(at..at + 4)?.try_into().ok()?)) };
    let (Some(version), Some(application)) = (number(60), number(68)) else {
        return foreign("it is not an SQLite file");
    };
    if !header.starts_with(MAGIC) {
        foreign("it is not an SQLite file")
    } else if application != APPLICATION {
        foreign("it is another program's SQLite file")
    } else if version != VERSION {
        Err(StoreError::Version { file: file.to_owned(), version })
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use protocol::{Epoch, LeaseId, RobotId};

    use super::*;
    use crate::core::Fact;

    fn event(number: u64) -> Event {
        let fact = match number % 2 {
            0 => Fact::Stranded { robot: RobotId(number as u16) },
            _ => Fact::EpochStarted { epoch: Epoch(number as u32), next_lease: LeaseId(7) },
        };
        Event { at: SiteMillis(number), fact }
    }

    fn log() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("events.sqlite");
        (folder, file)
    }

    #[test]
    fn what_was_appended_is_read_back() {
        let (_folder, file) = log();
        let events: Vec<_> = (0..5).map(event).collect();
        let (mut store, before) = Store::open(&file).unwrap();
        assert!(before.is_empty());
        store.append(&events[..2]).unwrap();
        store.append(&events[2..]).unwrap();
        drop(store);
        assert_eq!(Store::open(&file).unwrap().1, events);
    }

    #[test]
    fn one_log_has_one_writer() {
        let (_folder, file) = log();
        let (_store, _) = Store::open(&file).unwrap();
        let error = Store::open(&file).unwrap_err();
        assert!(matches!(error, StoreError::InUse { .. }), "{error}");
    }

    #[test]
    fn a_full_disk_loses_nothing_and_says_so() {
        let (_folder, file) = log();
        let (mut store, _) = Store::open(&file).unwrap();
        store.limit_pages(4);
        let mut kept = Vec::new();
        let error = loop {
            let batch: Vec<_> = (0..50).map(event).collect();
            match store.append(&batch) {
                Ok(()) => kept.extend(batch),
                Err(error) => break error,
            }
        };
        assert!(matches!(error, StoreError::Full { .. }), "{error}");
        assert!(error.to_string().contains("events.sqlite"), "{error}");
        store.limit_pages(1_000_000);
        store.append(&[event(1)]).unwrap();
        kept.push(event(1));
        drop(store);
        assert_eq!(Store::open(&file).unwrap().1, kept);
    }

    #[test]
    fn a_foreign_file_is_refused_and_untouched() {
        let (_folder, file) = log();
        let other = file.with_file_name("other.sqlite");
        Connection::open(&other).unwrap().execute_batch("CREATE TABLE precious (x)").unwrap();
        let database = fs::read(&other).unwrap();
        for content in [b"not a database at all".to_vec(), vec![0; 4096], database] {
            fs::write(&file, &content).unwrap();
            let error = Store::open(&file).unwrap_err();
            assert!(matches!(error, StoreError::Foreign { .. }), "{error}");
            assert_eq!(fs::read(&file).unwrap(), content);
        }
    }

    #[test]
    fn a_log_of_a_later_version_is_refused_and_untouched() {
        let (_folder, file) = log();
        drop(Store::open(&file).unwrap());
        Connection::open(&file).unwrap().pragma_update(None, "user_version", VERSION + 1).unwrap();
        let content = fs::read(&file).unwrap();
        let error = Store::open(&file).unwrap_err();
        assert!(matches!(error, StoreError::Version { version: 2, .. }), "{error}");
        assert_eq!(fs::read(&file).unwrap(), content);
    }

    #[test]
    fn a_damaged_log_is_refused() {
        let (_folder, file) = log();
        let (mut store, _) = Store::open(&file).unwrap();
        store.append(&(0..2_000).map(event).collect::<Vec<_>>()).unwrap();
        drop(store);
        let mut content = fs::read(&file).unwrap();
        content[4096..].fill(0xA5);
        fs::write(&file, &content).unwrap();
        let error = Store::open(&file).unwrap_err();
        assert!(matches!(error, StoreError::Damaged { .. }), "{error}");
        assert_eq!(fs::read(&file).unwrap(), content);
    }

    #[test]
    fn an_event_that_nobody_understands_is_named() {
        let (_folder, file) = log();
        drop(Store::open(&file).unwrap());
        let row = "INSERT INTO events (at_ms, fact) VALUES (1, '{\"sung\":{}}')";
        Connection::open(&file).unwrap().execute_batch(row).unwrap();
        let error = Store::open(&file).unwrap_err();
        assert!(error.to_string().contains("event 1 "), "{error}");
    }
}
