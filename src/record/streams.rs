//! Tables of other devices in a recording (`streams/`): LSL streams, triggers, and the drive's clock, which relates samples to
//! the drive. In: rows with time stamps of their device. Out: during the drive a journal of blocks for each stream, synced
//! after every batch. At the end it becomes a Parquet file with the drive time beside each time stamp.

use super::{
    RecordError,
    block::{self, BlockHeader, JournalBlocks, JournalPart},
    files,
    journal_reader::{LostRows, unpack},
    stream_clock::DriveClock,
    table_writer::{FinishedTable, TableWriter},
};
use crate::file;
use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray};
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{DataType, Field, Schema};
use std::{
    collections::BTreeSet,
    fs::{self, File},
    io::{self, BufReader, Write},
    path::{Path, PathBuf},
    sync::Arc,
};

/// Folder of these tables, in the recording.
pub const FOLDER: &str = "streams";
/// Table of the drive's clock.
pub const CLOCK: &str = "drive-clock";
/// Column of a device's own time stamps, s.
pub const STAMP: &str = "lsl_time_s";
/// Column of the clock offset to add to the time stamps, s: this machine's clock minus the device's, as last measured.
pub const OFFSET: &str = "clock_offset_s";
/// Column of the drive time, s.
pub const TIME: &str = "time_s";
/// File extension of a journal.
const JOURNAL: &str = "blocks";
/// Compression level of zstd, as in the journal of the drive.
const ZSTD_LEVEL: i32 = 1;
/// Maximum bytes of values in a block. Readers accept blocks of up to 64 MiB, including a description of each column.
const BLOCK_BYTES: usize = 8 << 20;
/// Maximum bytes of a row; a row is never split between blocks.
const ROW_BYTES: usize = 32 << 20;

/// Column of a stream's table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StreamColumn {
    pub name: String,
    /// Unit; empty if it has none.
    pub unit: String,
    /// Meaning, for the description in the file.
    pub about: String,
    /// True for texts, false for numbers.
    pub is_text: bool,
}

impl StreamColumn {
    /// Returns a column of numbers.
    pub fn number(name: &str, unit: &str, about: &str) -> Self {
        Self { name: name.into(), unit: unit.into(), about: about.into(), is_text: false }
    }

    /// Returns a column of texts.
    pub fn text(name: &str, about: &str) -> Self {
        Self { name: name.into(), unit: String::new(), about: about.into(), is_text: true }
    }

    pub(super) fn field(&self) -> Field {
        let kind = if self.is_text { DataType::Utf8 } else { DataType::Float64 };
        Field::new(&self.name, kind, true)
            .with_metadata([("unit", self.unit.as_str()), ("description", self.about.as_str())])
    }
}

/// Values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum StreamValues {
    /// Numbers; NaN for a missing value.
    Numbers(Vec<f64>),
    /// Texts, one for each row.
    Texts(Vec<String>),
}

impl StreamValues {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Texts(texts) => texts.len(),
        }
    }
}

/// Journal of a stream being recorded.
#[derive(Debug)]
pub struct StreamJournal {
    path: PathBuf,
    file: File,
    schema: Arc<Schema>,
    rows: u64,
    next: u64,
}

impl StreamJournal {
    /// Begins a table in a recording, under `name` or, if that is taken, `name-2` and so on. Characters that are not safe in
    /// file names become hyphens. A repeated column name gets a number.
    ///
    /// # Errors
    /// An I/O error.
    pub fn begin(recording: &Path, name: &str, columns: &[StreamColumn]) -> Result<Self, RecordError> {
        let folder = recording.join(FOLDER);
        files::new_dir_within(recording, &folder)?;
        let plain: String =
            name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' }).collect();
        let plain = if plain.trim_matches(['-', '.']).is_empty() { "stream".to_owned() } else { plain };
        let names = (1..).map(|n| if n == 1 { plain.clone() } else { format!("{plain}-{n}") });
        let path = names
            .map(|name| folder.join(format!("{name}.{JOURNAL}")))
            .find(|path| !path.exists() && !table_of(path).exists())
            .expect("numbers do not end");
        let (mut fields, mut taken): (Vec<Field>, BTreeSet<String>) = Default::default();
        for column in columns {
            let is_free = |name: &String| !taken.contains(name) && (name != TIME || fields.len() <= 1);
            let mut names = (1..).map(|n| if n == 1 { column.name.clone() } else { format!("{}-{n}", column.name) });
            let name = names.find(is_free).expect("numbers do not end");
            taken.insert(name.clone());
            fields.push(column.field().with_name(name));
        }
        let file = files::new_file(&path)?;
        files::sync_dir(&path)?;
        let mut journal = Self { path, file, schema: Arc::new(Schema::new(fields)), rows: 0, next: 0 };
        // A stream without samples still gets a table with its columns.
        let none = columns.iter().map(|column| match column.is_text {
            true => StreamValues::Texts(Vec::new()),
            false => StreamValues::Numbers(Vec::new()),
        });
        journal.append(none.collect())?;
        Ok(journal)
    }

    /// Returns the name under which the table was begun.
    pub fn name(&self) -> String {
        self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Writes a file of the same name with this ending; replaces an earlier one.
    ///
    /// # Errors
    /// An I/O error.
    pub fn describe(&self, ending: &str, text: &str) -> Result<(), RecordError> {
        files::replace(&self.path.with_file_name(format!("{}.{ending}", self.name())), text.as_bytes())
    }

    /// Returns the number of rows so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Appends rows, one list of values for each column, and waits until they are on the disk. Many bytes are split into
    /// several blocks.
    ///
    /// # Errors
    /// An I/O error, and all earlier rows are kept; columns that differ from the table's or in length; or a row that is too
    /// large to be read back.
    pub fn append(&mut self, columns: Vec<StreamValues>) -> Result<(), RecordError> {
        let fault = |why: String| RecordError::Table { path: self.path.clone(), why };
        let sizes = row_sizes(&columns);
        if let Some(size) = sizes.iter().find(|size| **size > ROW_BYTES) {
            return Err(fault(format!("a sample has {size} bytes; allowed: {ROW_BYTES}")));
        }
        let arrays: Vec<ArrayRef> = columns
            .into_iter()
            .map(|values| -> ArrayRef {
                match values {
                    StreamValues::Numbers(numbers) => {
                        Arc::new(numbers.into_iter().map(|v| (!v.is_nan()).then_some(v)).collect::<Float64Array>())
                    }
                    StreamValues::Texts(texts) => Arc::new(StringArray::from_iter_values(texts)),
                }
            })
            .collect();
        let batch = RecordBatch::try_new(Arc::clone(&self.schema), arrays).map_err(|e| fault(e.to_string()))?;
        let mut from = 0;
        for rows in pieces(&sizes) {
            self.append_block(&batch.slice(from, rows))?;
            from += rows;
        }
        Ok(())
    }

    fn append_block(&mut self, batch: &RecordBatch) -> Result<(), RecordError> {
        let rows = batch.num_rows();
        let payload = payload(batch).map_err(RecordError::file(&self.path))?;
        let header =
            BlockHeader { table: u32::MAX, rows: rows as u32, number: self.next, batch: self.next, ticks: [0, 0] };
        let bytes = block::encode(&header, &payload);
        self.file.write_all(&bytes).and_then(|()| self.file.sync_data()).map_err(RecordError::file(&self.path))?;
        self.next += 1;
        self.rows += rows as u64;
        Ok(())
    }
}

/// Returns the number of bytes of each row.
fn row_sizes(columns: &[StreamValues]) -> Vec<usize> {
    let rows = columns.iter().map(StreamValues::len).max().unwrap_or(0);
    let mut sizes = vec![0; rows];
    for column in columns {
        match column {
            StreamValues::Numbers(numbers) => {
                sizes[..numbers.len()].iter_mut().for_each(|size| *size += size_of::<f64>())
            }
            StreamValues::Texts(texts) => sizes.iter_mut().zip(texts).for_each(|(size, text)| *size += text.len()),
        }
    }
    sizes
}

/// Splits rows into blocks. Returns the number of rows of each block; one block of 0 rows for no rows.
fn pieces(sizes: &[usize]) -> Vec<usize> {
    let (mut pieces, mut bytes) = (vec![0], 0);
    for size in sizes {
        if bytes > 0 && bytes + size > BLOCK_BYTES {
            pieces.push(0);
            bytes = 0;
        }
        bytes += size;
        *pieces.last_mut().expect("never empty") += 1;
    }
    pieces
}

fn payload(batch: &RecordBatch) -> io::Result<Vec<u8>> {
    let mut stream = StreamWriter::try_new(Vec::new(), &batch.schema()).map_err(io::Error::other)?;
    stream.write(batch).map_err(io::Error::other)?;
    stream.finish().map_err(io::Error::other)?;
    zstd::bulk::compress(stream.get_ref(), ZSTD_LEVEL)
}

/// Returns the path of the table that a journal becomes.
fn table_of(journal: &Path) -> PathBuf {
    journal.with_extension("parquet")
}

/// Makes tables of all journals of a recording and removes the journals. A journal with unreadable parts stays, and these parts
/// are added to `holes`. After a cut, the next call continues.
///
/// # Errors
/// An I/O error.
pub fn settle(recording: &Path, holes: &mut Vec<LostRows>) -> Result<(), RecordError> {
    let folder = recording.join(FOLDER);
    if !files::is_there(&folder)? {
        return Ok(());
    }
    let mut journals = Vec::new();
    for entry in fs::read_dir(&folder).map_err(RecordError::file(&folder))? {
        let path = entry.map_err(RecordError::file(&folder))?.path();
        if path.extension().is_some_and(|ending| ending == JOURNAL) {
            journals.push(path);
        }
    }
    let clock = folder.join(format!("{CLOCK}.{JOURNAL}"));
    // The clock's journal goes last: it is needed until all tables are there, also after a cut.
    journals.sort_by_key(|path| (*path == clock, path.clone()));
    let clock = DriveClock::read(&clock)?;
    let mut whole = Vec::new();
    for journal in journals {
        let known = holes.len();
        let mut writer: Option<TableWriter> = None;
        each_batch(&journal, holes, &mut |batch| {
            let batch = clock.with_time(&batch, &journal)?;
            let writer = match &mut writer {
                Some(writer) => writer,
                empty => empty.insert(TableWriter::new(table_of(&journal), batch.schema())?),
            };
            writer.write(&batch)
        })?;
        if let Some(writer) = writer {
            let FinishedTable { path, beside, .. } = writer.finish()?;
            fs::rename(&beside, &path).map_err(RecordError::file(&path))?;
        }
        if holes.len() == known {
            whole.push(journal);
        }
    }
    files::sync_dir(&folder.join(CLOCK))?;
    for journal in whole {
        // Each removal is synced before the next, so that the order holds after a power cut.
        files::sync_dir(&journal)?;
        fs::remove_file(&journal).map_err(RecordError::file(&journal))?;
    }
    files::sync_dir(&folder.join(CLOCK))
}

pub(super) fn each_batch(
    journal: &Path,
    holes: &mut Vec<LostRows>,
    put: &mut dyn FnMut(RecordBatch) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    let file = file::open_regular(journal).map_err(RecordError::file(journal))?;
    let mut blocks = JournalBlocks::new(BufReader::new(file)).map_err(RecordError::file(journal))?;
    let lost =
        |bytes: [u64; 2], rows: Option<u32>| LostRows { file: journal.into(), bytes, table: None, rows, ticks: None };
    let mut at = 0;
    while let Some(part) = blocks.next().map_err(RecordError::file(journal))? {
        match part {
            JournalPart::Hole { header, bytes } => {
                at = bytes[1];
                holes.push(lost(bytes, header.map(|header| header.rows)));
            }
            JournalPart::Block(header, payload) => {
                let bytes = [at, at + (block::HEADER + payload.len()) as u64];
                at = bytes[1];
                match unpack(&payload) {
                    Ok(batches) => batches.into_iter().try_for_each(&mut *put)?,
                    Err(_) => holes.push(lost(bytes, Some(header.rows))),
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "streams_tests.rs"]
mod tests;
