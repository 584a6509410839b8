//! The journal: one Arrow IPC stream a table, appended to by one thread, on the disk after every batch. In: batches from a
//! bounded queue. Out: files that are whole up to their last batch, whenever the power fails.

use super::{
    RecordError, files,
    table::{Column, batch, schema},
    tables::{self, Batch, Table},
};
use arrow_ipc::{
    CompressionType,
    writer::{IpcWriteOptions, StreamWriter},
};
use arrow_schema::Schema;
use std::{
    fs::File,
    path::{Path, PathBuf},
    sync::{Arc, mpsc::Receiver},
};

/// One table's stream.
struct Stream<R: 'static> {
    path: PathBuf,
    columns: &'static [Column<R>],
    schema: Arc<Schema>,
    writer: StreamWriter<File>,
}

impl<R> Stream<R> {
    fn begin(path: PathBuf, file: File, columns: &'static [Column<R>]) -> Result<Self, RecordError> {
        let schema = schema(columns);
        let options = IpcWriteOptions::default()
            .try_with_compression(Some(CompressionType::ZSTD))
            .map_err(RecordError::table(&path))?;
        let writer = StreamWriter::try_new_with_options(file, &schema, options).map_err(RecordError::table(&path))?;
        Ok(Self { path, columns, schema, writer })
    }

    /// Appends rows and waits until the disk has them.
    fn append(&mut self, rows: &[R]) -> Result<(), RecordError> {
        if rows.is_empty() {
            return Ok(());
        }
        let fault = RecordError::table(&self.path);
        self.writer.write(&batch(&self.schema, self.columns, rows)).map_err(fault)?;
        self.writer.get_ref().sync_data().map_err(RecordError::file(&self.path))
    }

    fn end(mut self) -> Result<(), RecordError> {
        self.writer.finish().map_err(RecordError::table(&self.path))?;
        self.writer.get_ref().sync_all().map_err(RecordError::file(&self.path))
    }
}

/// All streams of one recording.
pub(super) struct Journal {
    ego: Stream<tables::EgoRow>,
    cars: Stream<tables::CarRow>,
    advice: Stream<tables::AdviceRow>,
    frames: Stream<tables::FrameRow>,
    events: Stream<tables::EventRow>,
}

impl Journal {
    /// Makes the files in `folder`, which is there; `open` makes one (tests hand in a disk that is full).
    pub fn begin(folder: &Path, open: impl Fn(&Path) -> Result<File, RecordError>) -> Result<Self, RecordError> {
        let place = |table: Table| {
            let path = table.journal(folder);
            open(&path).map(|file| (path, file))
        };
        let (ego, cars) = (place(Table::Ego)?, place(Table::Cars)?);
        let (advice, frames, events) = (place(Table::Advice)?, place(Table::Frames)?, place(Table::Events)?);
        Ok(Self {
            ego: Stream::begin(ego.0, ego.1, tables::EGO)?,
            cars: Stream::begin(cars.0, cars.1, tables::CARS)?,
            advice: Stream::begin(advice.0, advice.1, tables::ADVICE)?,
            frames: Stream::begin(frames.0, frames.1, tables::FRAMES)?,
            events: Stream::begin(events.0, events.1, tables::EVENTS)?,
        })
    }

    /// Appends every batch that comes until there are no more. The ego last: where its row is, the others are too. `done` is
    /// told of every batch that is on the disk.
    pub fn write(mut self, batches: &Receiver<Batch>, mut done: impl FnMut()) -> Result<(), RecordError> {
        for batch in batches {
            self.cars.append(&batch.cars)?;
            self.advice.append(&batch.advice)?;
            self.frames.append(&batch.frames)?;
            self.events.append(&batch.events)?;
            self.ego.append(&batch.ego)?;
            done();
        }
        self.cars.end()?;
        self.advice.end()?;
        self.frames.end()?;
        self.events.end()?;
        self.ego.end()
    }
}

/// Makes a file of the journal.
pub(super) fn new_stream(path: &Path) -> Result<File, RecordError> {
    files::new_file(path)
}
