//! Keeps a second program away from a participant. In: the participant's folder. Out: a file that stays locked while it is open.

use super::{ParticipantCode, SessionError};
use crate::{private, record::RecordError};
use std::{
    fs::{self, File},
    path::Path,
};

/// Name of the lock file.
pub(super) const FILE: &str = "lock";

/// Locks a participant's folder against other programs until the returned file is dropped.
///
/// # Errors
/// Another program holds the lock, or the file system refuses.
pub fn lock(folder: &Path, code: &ParticipantCode) -> Result<File, SessionError> {
    let path = folder.join(FILE);
    let file = lock_file(&path)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(fs::TryLockError::WouldBlock) => Err(SessionError::Refused(format!(
            "another program runs the session of participant {code}; end that program first"
        ))),
        Err(fs::TryLockError::Error(why)) => Err(RecordError::File { path, why }.into()),
    }
}

/// Opens the lock file, empty and private to the user.
pub(super) fn lock_file(path: &Path) -> Result<File, RecordError> {
    private::lock_file(path).map_err(|why| RecordError::File { path: path.into(), why })
}
