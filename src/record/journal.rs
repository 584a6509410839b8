//! Journal of a recording: one file, appended to by one thread, synced after every batch. In: batches from a bounded queue.
//! Out: blocks (see [`block`]) that are whole up to the last batch, whenever the power fails.
//!
//! Each block is an Arrow IPC stream of its own, compressed by zstd, so it can be read if earlier blocks are damaged. All
//! blocks of a batch go to the disk in one write and one sync.

use super::{
    RecordError,
    block::{self, BlockHeader},
    files,
    table::{TableColumn, batch, schema},
    tables::{self, RowBatch, Table},
};
use arrow_ipc::writer::StreamWriter;
use fail::fail_point;
use std::{
    fs::File,
    io::{self, Write},
    path::{Path, PathBuf},
    sync::mpsc::Receiver,
};

/// Folder of the journal, in the recording.
pub(super) const FOLDER: &str = "journal";
/// Folder of unreadable journals, in the recording.
pub const LOST_AND_FOUND: &str = "lost+found";
/// File name, in the journal's folder.
pub(super) const FILE: &str = "rows.blocks";
/// Compression level of zstd: fast, and on a second of rows within a tenth of the size at higher levels.
const ZSTD_LEVEL: i32 = 1;

/// File that rows are appended to; tests substitute one that notes the calls.
pub(super) trait DurableFile: Write + Send + 'static {
    /// Waits until the disk has all that was written.
    fn sync(&mut self) -> io::Result<()>;
}

impl DurableFile for File {
    fn sync(&mut self) -> io::Result<()> {
        self.sync_data()
    }
}

/// Journal of one recording.
pub(super) struct Journal<F> {
    path: PathBuf,
    file: F,
    /// Number of the next block.
    next: u64,
    /// Number of the first block of the batch being written.
    batch: u64,
}

impl Journal<File> {
    /// Makes the file in `folder`, which must exist.
    pub fn begin(folder: &Path) -> Result<Self, RecordError> {
        let path = folder.join(FILE);
        let file = files::new_file(&path)?;
        files::sync_dir(&path)?;
        Ok(Self::over(path, file))
    }
}

impl<F: DurableFile> Journal<F> {
    /// Starts a journal in a new and empty file; `path` is for messages.
    pub fn over(path: PathBuf, file: F) -> Self {
        Self { path, file, next: 0, batch: 0 }
    }

    /// Appends every batch received until the channel closes; calls `done` after each batch on the disk.
    pub fn write(mut self, batches: &Receiver<RowBatch>, mut done: impl FnMut()) -> Result<(), RecordError> {
        for batch in batches {
            self.append(&batch)?;
            done();
        }
        Ok(())
    }

    /// Appends one batch and waits until the disk has it. The ego comes last: if its row is there, all others are too.
    fn append(&mut self, batch: &RowBatch) -> Result<(), RecordError> {
        let mut bytes = Vec::new();
        self.batch = self.next;
        self.block(&mut bytes, Table::Cars, tables::CARS, &batch.cars)?;
        self.block(&mut bytes, Table::Advice, tables::ADVICE, &batch.advice)?;
        self.block(&mut bytes, Table::Frames, tables::FRAMES, &batch.frames)?;
        self.block(&mut bytes, Table::Events, tables::EVENTS, &batch.events)?;
        self.block(&mut bytes, Table::Departures, tables::DEPARTURES, &batch.network.departures)?;
        self.block(&mut bytes, Table::Arrivals, tables::ARRIVALS, &batch.network.arrivals)?;
        self.block(&mut bytes, Table::Signals, tables::SIGNALS, &batch.network.signals)?;
        self.block(&mut bytes, Table::Path, tables::PATH, &batch.network.path)?;
        self.block(&mut bytes, Table::Advised, tables::ADVISED, &batch.advised)?;
        self.block(&mut bytes, Table::Ego, tables::EGO, &batch.ego)?;
        if bytes.is_empty() {
            return Ok(());
        }
        fail_point!("flush.begin");
        self.file.write_all(&bytes).map_err(RecordError::file(&self.path))?;
        fail_point!("flush.written");
        self.file.sync().map_err(RecordError::file(&self.path))?;
        fail_point!("flush.synced");
        Ok(())
    }

    /// Appends the rows of one table to `bytes` as a block; nothing if there are none.
    fn block<R>(
        &mut self,
        bytes: &mut Vec<u8>,
        table: Table,
        columns: &[TableColumn<R>],
        rows: &[R],
    ) -> Result<(), RecordError> {
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return Ok(()) };
        let payload = payload(columns, rows).map_err(RecordError::file(&self.path))?;
        let header = BlockHeader {
            table: Table::ALL.iter().position(|t| *t == table).unwrap_or_default() as u32,
            rows: rows.len() as u32,
            number: self.next,
            batch: self.batch,
            ticks: [tables::tick(columns, first).0, tables::tick(columns, last).0],
        };
        self.next += 1;
        bytes.extend(block::encode(&header, &payload));
        Ok(())
    }
}

/// Returns rows as a compressed Arrow stream with its schema.
fn payload<R>(columns: &[TableColumn<R>], rows: &[R]) -> io::Result<Vec<u8>> {
    let schema = schema(columns);
    let mut stream = StreamWriter::try_new(Vec::new(), &schema).map_err(io::Error::other)?;
    stream.write(&batch(&schema, columns, rows)).map_err(io::Error::other)?;
    stream.finish().map_err(io::Error::other)?;
    zstd::bulk::compress(stream.get_ref(), ZSTD_LEVEL)
}
