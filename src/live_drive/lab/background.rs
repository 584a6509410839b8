//! A table that the loop of the drive fills and a thread of its own writes: a disk that takes its time is no hitch in the picture. In:
//! rows. Out: they are on the disk at the end, or why not.

use crate::record::{
    RecordError,
    streams::{StreamJournal, StreamValues},
};
use std::{
    sync::mpsc::{self, Sender},
    thread::JoinHandle,
};

/// The loop's side of the table.
pub struct BackgroundJournal {
    rows: Option<Sender<Vec<StreamValues>>>,
    thread: Option<JoinHandle<Result<(), RecordError>>>,
}

impl BackgroundJournal {
    /// Takes a table that has begun.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn new(mut journal: StreamJournal) -> Result<Self, RecordError> {
        let (rows, batches) = mpsc::channel();
        let write = move || batches.into_iter().try_for_each(|batch| journal.append(batch));
        let thread = std::thread::Builder::new().name("lab-writer".into()).spawn(write);
        let thread = thread.map_err(|why| RecordError::Stopped(why.to_string()))?;
        Ok(Self { rows: Some(rows), thread: Some(thread) })
    }

    /// Hands rows over, a list of values a column; does not wait.
    ///
    /// # Errors
    /// The disk has refused rows before these.
    pub fn append(&mut self, columns: Vec<StreamValues>) -> Result<(), RecordError> {
        match &self.rows {
            Some(rows) if rows.send(columns).is_ok() => Ok(()),
            _ => self.finish(),
        }
    }

    /// Waits until the disk has everything.
    ///
    /// # Errors
    /// It refuses; said once.
    pub fn finish(&mut self) -> Result<(), RecordError> {
        self.rows = None;
        let Some(thread) = self.thread.take() else { return Ok(()) };
        thread.join().unwrap_or_else(|_| Err(RecordError::Stopped("the thread of a table is gone".into())))
    }
}

impl Drop for BackgroundJournal {
    fn drop(&mut self) {
        if let Err(error) = self.finish() {
            log::error!("{error}");
        }
    }
}
