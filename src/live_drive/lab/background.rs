//! Table that the drive loop fills and a thread of its own writes, so that a slow disk does not delay the picture. In:
//! rows. Out: the rows on disk at the end, or the error.

use crate::record::{
    RecordError,
    streams::{StreamJournal, StreamValues},
};
use std::{
    sync::mpsc::{self, Sender},
    thread::JoinHandle,
};

/// The drive loop's end of the table.
pub struct BackgroundJournal {
    rows: Option<Sender<Vec<StreamValues>>>,
    thread: Option<JoinHandle<Result<(), RecordError>>>,
}

impl BackgroundJournal {
    /// Starts the writing thread for a table.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub fn new(mut journal: StreamJournal) -> Result<Self, RecordError> {
        let (rows, batches) = mpsc::channel();
        let write = move || batches.into_iter().try_for_each(|batch| journal.append(batch));
        let thread = std::thread::Builder::new().name("lab-writer".into()).spawn(write);
        let thread = thread.map_err(|why| RecordError::Stopped(why.to_string()))?;
        Ok(Self { rows: Some(rows), thread: Some(thread) })
    }

    /// Passes rows to the thread, one list of values per column; does not wait.
    ///
    /// # Errors
    /// Earlier rows could not be written.
    pub fn append(&mut self, columns: Vec<StreamValues>) -> Result<(), RecordError> {
        match &self.rows {
            Some(rows) if rows.send(columns).is_ok() => Ok(()),
            _ => self.finish(),
        }
    }

    /// Waits until all rows are on disk.
    ///
    /// # Errors
    /// Rows could not be written; reported once.
    pub fn finish(&mut self) -> Result<(), RecordError> {
        self.rows = None;
        let Some(thread) = self.thread.take() else { return Ok(()) };
        thread.join().unwrap_or_else(|_| Err(RecordError::Stopped("the thread that writes a table has ended".into())))
    }
}

impl Drop for BackgroundJournal {
    fn drop(&mut self) {
        if let Err(error) = self.finish() {
            log::error!("{error}");
        }
    }
}
