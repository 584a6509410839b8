//! Writer of one Parquet file. In: batches of rows. Out: a file that is whole on the disk beside its place, with its checksums.

use super::{
    RecordError,
    checksums::{ColumnSums, TableSums},
    files,
    sha256::{HashedFile, hex},
    table::table_fault,
};
use arrow_array::{Array, RecordBatch, UInt64Array};
use arrow_schema::Schema;
use parquet::{
    arrow::ArrowWriter,
    basic::{Compression, ZstdLevel},
    file::properties::WriterProperties,
};
use sha2::{Digest, Sha256};
use std::{path::PathBuf, sync::Arc};

/// Number of rows gathered before they go to the disk; it bounds the memory of long drives.
const ROW_GROUP: usize = 50_000;

/// Table being written beside its place.
pub(super) struct TableWriter {
    path: PathBuf,
    beside: PathBuf,
    writer: ArrowWriter<HashedFile>,
    columns: ColumnSums,
    rows: u64,
    ticks: Option<[u64; 2]>,
}

/// Table that is on the disk but not yet in its place.
pub(super) struct FinishedTable {
    pub path: PathBuf,
    pub beside: PathBuf,
    pub sums: TableSums,
    pub ticks: Option<[u64; 2]>,
}

impl TableWriter {
    pub fn new(path: PathBuf, schema: Arc<Schema>) -> Result<Self, RecordError> {
        // Each table has its own file name: all of them are beside their places at the same time.
        let (beside, file) = files::new_beside(&path)?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_max_row_group_row_count(Some(ROW_GROUP))
            .build();
        let file = HashedFile { file, hash: Sha256::new() };
        let writer = ArrowWriter::try_new(file, schema, Some(properties)).map_err(table_fault(&path))?;
        Ok(Self { path, beside, writer, columns: ColumnSums::default(), rows: 0, ticks: None })
    }

    pub fn write(&mut self, batch: &RecordBatch) -> Result<(), RecordError> {
        self.writer.write(batch).map_err(table_fault(&self.path))?;
        self.columns.push(batch);
        self.rows += batch.num_rows() as u64;
        let ticks = batch.column_by_name("tick").and_then(|column| column.as_any().downcast_ref::<UInt64Array>());
        if let Some(ticks) = ticks.filter(|ticks| !ticks.is_empty()) {
            let (first, last) = (ticks.value(0), ticks.value(ticks.len() - 1));
            self.ticks = Some([self.ticks.map_or(first, |[first, _]| first), last]);
        }
        Ok(())
    }

    pub fn finish(self) -> Result<FinishedTable, RecordError> {
        let Self { path, beside, writer, columns, rows, ticks } = self;
        let HashedFile { file, hash } = writer.into_inner().map_err(table_fault(&path))?;
        files::sync_file(&file, &beside)?;
        let sums = TableSums { rows, sha256: hex(&hash.finalize()), columns: columns.finish() };
        Ok(FinishedTable { path, beside, sums, ticks })
    }
}
