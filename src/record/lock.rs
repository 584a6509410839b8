//! Lock on a folder while a drive is recorded into it. In: a recording's folder. Out: a lock that the system releases when the
//! program ends, in whatever way. All others see it and leave the folder alone.

use super::RecordError;
use crate::{file::open_regular, private};
use std::{
    fs::{self, File, TryLockError},
    io::ErrorKind,
    path::Path,
    thread::sleep,
    time::Duration,
};

/// File name of the lock. The empty file stays: if it were removed, two programs could hold one lock each.
pub(super) const FILE: &str = "lock";
/// Maximum number of attempts to take the lock, 10 ms apart: readers hold it for a moment only.
const TRIES: usize = 10;

/// Lock of a recording, held during the drive or a recovery.
#[derive(Debug)]
pub(super) struct RecordingLock {
    _file: File,
}

impl RecordingLock {
    /// Takes the lock of a recording.
    ///
    /// # Errors
    /// [`RecordError::Running`] if the lock is held elsewhere; or an I/O error.
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

/// Checks that the recording is not locked.
///
/// # Errors
/// [`RecordError::Running`]; or an I/O error.
pub(super) fn check_free(recording: &Path) -> Result<(), RecordError> {
    let path = recording.join(FILE);
    // A copy may lack the lock file; an archive may be read-only.
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
        // Some file systems have no locks; nothing can be recorded on them either.
        Err(TryLockError::Error(why)) if why.kind() == ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(why)) => Err(RecordError::file(&path)(why)),
    }
}
