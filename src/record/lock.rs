//! Marks a folder while a drive is recorded into it. In: a recording's folder. Out: a lock that the system lets go of when
//! the program is gone, however it went; everybody else sees it and keeps away.

use super::RecordError;
use crate::{file::open_regular, private};
use std::{
    fs::{self, File, TryLockError},
    io::ErrorKind,
    path::Path,
    thread::sleep,
    time::Duration,
};

/// Name of the file that the lock is held on. It stays, empty: to remove it would let two programs hold one each.
pub(super) const FILE: &str = "lock";
/// Who only looks holds the lock for a moment; whoever wants it for long tries so often, 10 ms apart.
const TRIES: usize = 10;

/// Held as long as the drive lasts, or somebody makes it whole.
#[derive(Debug)]
pub(super) struct RecordingLock {
    _file: File,
}

impl RecordingLock {
    /// Takes the lock of a recording.
    ///
    /// # Errors
    /// [`RecordError::Running`] if somebody has it; the system refuses.
    pub fn take(recording: &Path) -> Result<Self, RecordError> {
        let path = recording.join(FILE);
        let file = private::lock_file(&path).map_err(RecordError::file(&path))?;
        for _ in 0..TRIES {
            match file.try_lock() {
                Ok(()) => return Ok(Self { _file: file }),
                Err(TryLockError::WouldBlock) => sleep(Duration::from_millis(10)),
                Err(TryLockError::Error(why)) => return Err(RecordError::file(&path)(why)),
            }
        }
        Err(RecordError::Running(recording.into()))
    }
}

/// Nobody records here now.
///
/// # Errors
/// [`RecordError::Running`]; the system refuses.
pub(super) fn check_free(recording: &Path) -> Result<(), RecordError> {
    let path = recording.join(FILE);
    // A copy may be without one; an archive may be for reading only.
    match fs::metadata(&path) {
        Ok(about) if about.is_file() => {}
        Err(why) if why.kind() != ErrorKind::NotFound => return Err(RecordError::file(&path)(why)),
        _ => return Ok(()),
    }
    let file = match open_regular(&path) {
        Ok(file) => file,
        Err(why) if why.kind() == ErrorKind::NotFound => return Ok(()),
        Err(why) => return Err(RecordError::file(&path)(why)),
    };
    match file.try_lock_shared() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(RecordError::Running(recording.into())),
        // Some file systems know no locks; nothing can be recorded on them either.
        Err(TryLockError::Error(why)) if why.kind() == ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(why)) => Err(RecordError::file(&path)(why)),
    }
}
