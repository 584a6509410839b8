//! Conversion of a journal to tables, at the end of a drive or after it was cut. In: a journal, whole, cut or damaged anywhere.
//! Out: Parquet files with every readable row.
//!
//! Nothing is destroyed on the way. Tables are written beside their places and renamed once they are on the disk; a table never
//! replaces one with more rows. Then the manifest is marked as complete. Then the journal is removed, or moved to `lost+found/`
//! if part of it could not be read. After a cut at any point, the next call continues.

use super::{
    Manifest, RecordError, Table,
    checksums::{Checksums, ColumnSums, TableSums},
    files,
    journal::{self, LOST_AND_FOUND},
    journal_reader::{self, LostRows},
    lock::{self, RecordingLock},
    manifest::{self, RecordingState},
    sha256::file_sha256,
    streams,
    table::TableReader,
    table_writer::{FinishedTable, TableWriter},
    tables::schema,
};
use crate::time::Tick;
use fail::fail_point;
use std::{
    fs,
    io::{self, ErrorKind},
    path::{Path, PathBuf},
};

/// Contents of a recording, as found by a recovery.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecoveryReport {
    /// Number of rows of each table.
    pub rows: Vec<(Table, u64)>,
    /// Ticks of the first and last row of each table with rows; only for tables recovered by this call.
    pub ticks: Vec<(Table, [Tick; 2])>,
    /// True if the recording was complete and there was nothing to do.
    pub was_whole: bool,
    /// Rows that could not be read.
    pub missing: Vec<LostRows>,
    /// Folder where the journal is kept, if part of it could not be read.
    pub kept: Option<PathBuf>,
}

/// Makes the tables of a recording that was cut. A complete recording stays as it is.
///
/// # Errors
/// There is no recording, its drive is still in progress, or an I/O error.
pub fn recover(recording: &Path) -> Result<RecoveryReport, RecordError> {
    Manifest::load(recording)?;
    lock::check_free(recording)?;
    let journal = recording.join(journal::FOLDER);
    // A complete recording may be read-only, so no lock is taken.
    if !files::is_there(&journal)? && Manifest::load(recording)?.is_complete() {
        return whole(recording);
    }
    let _lock = RecordingLock::take(recording)?;
    let mut manifest = Manifest::load(recording)?;
    if manifest.is_complete() && is_whole(recording, &Table::of(&manifest))? {
        // Only the journal was left to be removed.
        drop_journal(recording)?;
        remove_unfinished(recording)?;
        return whole(recording);
    }
    let written = write_tables(recording, &Table::of(&manifest))?;
    manifest.ended.get_or_insert_with(|| "cut".into());
    manifest.state = RecordingState::Recovered;
    manifest.checksums = Some(written.checksums.save(recording)?);
    manifest.seal(recording)?;
    let kept = settle_journal(recording, &written.holes)?;
    remove_unfinished(recording)?;
    Ok(RecoveryReport { rows: written.rows, ticks: written.ticks, was_whole: false, missing: written.holes, kept })
}

/// Removes unfinished files that a cut left behind; their contents have been written since.
fn remove_unfinished(recording: &Path) -> Result<(), RecordError> {
    for path in files::entries(recording)? {
        if path.extension().is_some_and(|ending| ending == files::BESIDE) {
            fs::remove_file(&path).map_err(RecordError::file(&path))?;
        }
    }
    Ok(())
}

/// Removes the folder of a recording that was cut before its manifest was in place; it holds no rows. A folder with anything
/// else in it stays.
///
/// # Errors
/// An I/O error.
pub fn remove_unbegun(recording: &Path) -> Result<(), RecordError> {
    let unless_missing = |done: io::Result<()>, path: &Path| match done {
        Err(why) if !matches!(why.kind(), ErrorKind::NotFound | ErrorKind::DirectoryNotEmpty) => {
            Err(RecordError::file(path)(why))
        }
        _ => Ok(()),
    };
    if files::is_there(&recording.join(manifest::FILE))? {
        return Ok(());
    }
    let begun = Path::new(manifest::FILE).with_extension(files::BESIDE);
    for path in [recording.join(begun), recording.join(lock::FILE)] {
        unless_missing(fs::remove_file(&path), &path)?;
    }
    unless_missing(fs::remove_dir(recording), recording)
}

/// Opens a recording that can be read: its drive is over and its tables are written. Returns its manifest.
///
/// # Errors
/// There is no recording, its drive is still in progress, or it was cut and not yet recovered.
///
/// # Examples
///
/// ```
/// use codrive::record::{self, Table};
/// use std::path::Path;
///
/// // A drive of 2 s with three vehicles.
/// let recording = Path::new("tests/data/format-1/recording");
/// let manifest = record::open(recording)?;
/// assert_eq!((manifest.seed, manifest.map.name.as_str()), (1, "ring-250"));
/// // A tick is 0.01 s, and the table of the ego has one row for each.
/// assert_eq!(record::count(recording, Table::Ego)?, 200);
/// # Ok::<(), record::RecordError>(())
/// ```
pub fn open(recording: &Path) -> Result<Manifest, RecordError> {
    let manifest = Manifest::load(recording)?;
    lock::check_free(recording)?;
    if manifest.is_complete() { Ok(manifest) } else { Err(RecordError::Cut(recording.into())) }
}

/// Returns the number of rows of a table.
///
/// # Errors
/// The table cannot be read.
pub fn count(recording: &Path, table: Table) -> Result<u64, RecordError> {
    TableReader::count(&table.parquet(recording))
}

fn whole(recording: &Path) -> Result<RecoveryReport, RecordError> {
    let counted = |table: Table| Ok((table, count(recording, table)?));
    let tables = Table::of(&Manifest::load(recording)?);
    let rows = tables.into_iter().map(counted).collect::<Result<_, RecordError>>()?;
    Ok(RecoveryReport { rows, ticks: Vec::new(), was_whole: true, missing: Vec::new(), kept: None })
}

/// Checks whether every table is there with all rows that were written.
fn is_whole(recording: &Path, tables: &[Table]) -> Result<bool, RecordError> {
    let sums = match Checksums::load(recording) {
        Ok(sums) => sums,
        Err(RecordError::File { why, .. }) if why.kind() == ErrorKind::NotFound => return Ok(false),
        Err(error @ RecordError::File { .. }) => return Err(error),
        Err(_) => return Ok(false),
    };
    for table in tables {
        let rows = rows_there(&table.parquet(recording))?;
        let written = sums.tables.get(table.name()).map(|sums| sums.rows);
        if rows.is_none() || rows != written {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Returns the number of rows of a table; `None` if it is missing or not whole. A disk error is passed on: a table that cannot
/// be read now must not be replaced.
fn rows_there(path: &Path) -> Result<Option<u64>, RecordError> {
    match TableReader::count(path) {
        Ok(rows) => Ok(Some(rows)),
        Err(RecordError::File { why, .. }) if why.kind() == ErrorKind::NotFound => Ok(None),
        Err(error @ RecordError::File { .. }) => Err(error),
        Err(_) => Ok(None),
    }
}

/// Tables made of a journal.
pub(super) struct RecoveredJournal {
    pub rows: Vec<(Table, u64)>,
    pub ticks: Vec<(Table, [Tick; 2])>,
    pub holes: Vec<LostRows>,
    pub checksums: Checksums,
}

/// Writes a Parquet file for each of these tables and for every other table with rows in the journal. All are whole on the disk
/// before the first is put in place.
pub(super) fn write_tables(recording: &Path, tables: &[Table]) -> Result<RecoveredJournal, RecordError> {
    let mut writers: Vec<Option<TableWriter>> = Table::ALL.iter().map(|_| None).collect();
    let holes = journal_reader::read(&recording.join(journal::FOLDER), &mut |table, batch| {
        let place = Table::ALL.iter().position(|t| *t == table).unwrap_or_default();
        let writer = match &mut writers[place] {
            Some(writer) => writer,
            empty => empty.insert(TableWriter::new(table.parquet(recording), batch.schema())?),
        };
        writer.write(&batch)
    })?;
    let mut written = Vec::new();
    for (table, writer) in Table::ALL.into_iter().zip(writers) {
        let writer = match writer {
            Some(writer) => writer,
            None if tables.contains(&table) => TableWriter::new(table.parquet(recording), schema(table))?,
            None => continue,
        };
        written.push((table, writer.finish()?));
    }
    fail_point!("finish.tables_written");
    let mut all = RecoveredJournal { rows: Vec::new(), ticks: Vec::new(), holes, checksums: Checksums::default() };
    for (table, file) in written {
        let FinishedTable { path, beside, mut sums, ticks } = file;
        let there = rows_there(&path)?.unwrap_or(0);
        if there > sums.rows {
            sums = sums_of(&path)?;
            fs::remove_file(&beside).map_err(RecordError::file(&beside))?;
        } else {
            fs::rename(&beside, &path).map_err(RecordError::file(&path))?;
            all.ticks.extend(ticks.map(|ticks| (table, ticks.map(Tick))));
        }
        fail_point!("finish.table_renamed");
        all.rows.push((table, sums.rows));
        all.checksums.tables.insert(table.name().into(), sums);
    }
    streams::settle(recording, &mut all.holes)?;
    files::sync_dir(&recording.join(journal::FOLDER))?;
    fail_point!("finish.tables");
    Ok(all)
}

/// Returns the checksums of an existing table.
fn sums_of(path: &Path) -> Result<TableSums, RecordError> {
    let mut columns = ColumnSums::default();
    let rows = TableReader::each_batch(path, &mut |batch| columns.push(batch))?;
    Ok(TableSums { rows, sha256: file_sha256(path)?, columns: columns.finish() })
}

/// Removes the journal once tables and manifest are on the disk, or keeps it in `lost+found/` if it has holes. Returns the
/// folder where it is kept.
pub(super) fn settle_journal(recording: &Path, holes: &[LostRows]) -> Result<Option<PathBuf>, RecordError> {
    if holes.is_empty() {
        drop_journal(recording)?;
        return Ok(None);
    }
    let journal = recording.join(journal::FOLDER);
    let folder = recording.join(LOST_AND_FOUND);
    files::new_dir_within(recording, &folder)?;
    let names = (1..).map(|n| if n == 1 { journal::FOLDER.into() } else { format!("{}-{n}", journal::FOLDER) });
    let kept = names.map(|name| folder.join(name)).find(|path| !path.exists()).expect("numbers do not end");
    fs::rename(&journal, &kept).map_err(RecordError::file(&journal))?;
    files::sync_dir(&kept)?;
    files::sync_dir(&folder)?;
    Ok(Some(kept))
}

fn drop_journal(recording: &Path) -> Result<(), RecordError> {
    let journal = recording.join(journal::FOLDER);
    if files::is_there(&journal)? {
        fs::remove_dir_all(&journal).map_err(RecordError::file(&journal))?;
        files::sync_dir(&journal)?;
    }
    Ok(())
}
