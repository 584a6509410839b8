//! From journal to tables, at the end of a drive or after it was cut. In: streams, whole or cut at any byte. Out: Parquet
//! files with every row of every whole batch.

use super::{Manifest, RecordError, Table, files, table, tables};
use arrow_array::RecordBatch;
use arrow_ipc::reader::StreamReader;
use arrow_schema::Schema;
use parquet::{
    arrow::ArrowWriter,
    basic::{Compression, ZstdLevel},
    file::properties::WriterProperties,
};
use std::{
    fs::{self, File},
    io::{BufReader, Read},
    path::Path,
    sync::Arc,
};

/// What was found in a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recovered {
    /// Rows of each table.
    pub rows: Vec<(Table, u64)>,
    /// True if the recording had ended by itself and there was nothing to do.
    pub was_whole: bool,
}

/// Makes tables of what a cut left of a recording. One that is whole stays as it is.
///
/// # Errors
/// There is no recording, or the disk refuses.
pub fn recover(recording: &Path) -> Result<Recovered, RecordError> {
    let mut manifest = Manifest::load(recording)?;
    let was_whole = !recording.join("journal").exists();
    let rows = if was_whole { count(recording)? } else { close(recording)? };
    if !was_whole {
        if manifest.ended.is_none() {
            manifest.ended = Some("cut".into());
            manifest.save(recording)?;
        }
        drop_journal(recording)?;
    }
    Ok(Recovered { rows, was_whole })
}

fn count(recording: &Path) -> Result<Vec<(Table, u64)>, RecordError> {
    Table::ALL
        .into_iter()
        .map(|table| Ok((table, table::Reader::parquet(&table.parquet(recording))?.rows() as u64)))
        .collect()
}

/// Writes a Parquet file for every stream of the journal.
pub(super) fn close(recording: &Path) -> Result<Vec<(Table, u64)>, RecordError> {
    let journal = recording.join("journal");
    let schemas = |table| match table {
        Table::Ego => table::schema(tables::EGO),
        Table::Cars => table::schema(tables::CARS),
        Table::Advice => table::schema(tables::ADVICE),
        Table::Frames => table::schema(tables::FRAMES),
        Table::Events => table::schema(tables::EVENTS),
    };
    let mut rows = Vec::new();
    for table in Table::ALL {
        rows.push((table, convert(&table.journal(&journal), &table.parquet(recording), schemas(table))?));
    }
    Ok(rows)
}

/// One stream to one file: every whole batch. Returns how many rows.
fn convert(stream: &Path, to: &Path, schema: Arc<Schema>) -> Result<u64, RecordError> {
    let beside = to.with_extension("new");
    if beside.exists() {
        // Of a conversion that was cut; the stream is still here.
        fs::remove_file(&beside).map_err(RecordError::file(&beside))?;
    }
    let fault = |e: parquet::errors::ParquetError| RecordError::Table { path: to.into(), why: e.to_string() };
    let properties = WriterProperties::builder().set_compression(Compression::ZSTD(ZstdLevel::default())).build();
    let file = files::new_file(&beside)?;
    // A stream whose very beginning was cut has no rows, but its table has columns.
    let batches = File::open(stream).ok().and_then(|file| StreamReader::try_new(BufReader::new(file), None).ok());
    let schema = batches.as_ref().map_or(schema, |stream| stream.schema());
    let mut writer = ArrowWriter::try_new(file, schema, Some(properties)).map_err(fault)?;
    let mut rows = 0;
    for batch in batches.into_iter().flat_map(whole) {
        writer.write(&batch).map_err(fault)?;
        rows += batch.num_rows() as u64;
    }
    let file = writer.into_inner().map_err(fault)?;
    file.sync_all().map_err(RecordError::file(&beside))?;
    fs::rename(&beside, to).map_err(RecordError::file(to))?;
    files::sync_dir(to)?;
    Ok(rows)
}

/// The batches of a stream until its end, or until it was cut.
fn whole<R: Read>(stream: StreamReader<R>) -> impl Iterator<Item = RecordBatch> {
    stream.map_while(Result::ok)
}

/// How many rows the whole batches of a stream hold.
#[cfg(test)]
pub(super) fn whole_rows(stream: &[u8]) -> usize {
    let batches = StreamReader::try_new(stream, None).ok();
    batches.into_iter().flat_map(whole).map(|batch| batch.num_rows()).sum()
}

/// The tables are on the disk: the journal has done its work.
pub(super) fn drop_journal(recording: &Path) -> Result<(), RecordError> {
    let journal = recording.join("journal");
    fs::remove_dir_all(&journal).map_err(RecordError::file(&journal))
}
