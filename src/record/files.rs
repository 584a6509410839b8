//! Files that are made once, for the user alone, and reach the disk. In: paths. Out: files, or the system's own words.

use super::RecordError;
use std::{
    fs::{self, DirBuilder, File, OpenOptions},
    io::Write,
    path::Path,
};

/// Makes a folder and those above it, private to the user. One that is there already is left as it is.
///
/// # Errors
/// The system refuses.
pub fn new_private_dir(path: &Path) -> Result<(), RecordError> {
    let mut builder = DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path).map_err(RecordError::file(path))
}

/// Room on the disk, GB, below which there is little, and too little: a session of an hour takes less than 1 GB.
pub const LITTLE_GB: f64 = 5.0;
/// See [`LITTLE_GB`].
pub const TOO_LITTLE_GB: f64 = 1.0;

/// Room on the disk of `folder` for this user, bytes; `None` where the system does not tell.
#[cfg(target_os = "linux")]
pub fn free_bytes(folder: &Path) -> Option<u64> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let stat = nix::sys::statvfs::statvfs(folder).ok()?;
    Some(stat.blocks_available().saturating_mul(stat.fragment_size()))
}

/// Room on the disk of `folder` for this user, bytes; `None` where the system does not tell.
#[cfg(not(target_os = "linux"))]
pub fn free_bytes(_folder: &Path) -> Option<u64> {
    None
}

/// A new file, private to the user.
///
/// # Errors
/// There is one already, or the system refuses.
pub(super) fn new_file(path: &Path) -> Result<File, RecordError> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path).map_err(RecordError::file(path))
}

/// Writes a whole new file, private to the user, that reaches the disk.
///
/// # Errors
/// There is one already, or the system refuses.
pub fn write_new(path: &Path, text: &[u8]) -> Result<(), RecordError> {
    let mut file = new_file(path)?;
    file.write_all(text).and_then(|()| file.sync_all()).map_err(RecordError::file(path))?;
    sync_dir(path)
}

/// Writes a whole file so that at every moment either the old one or the new one is there, also after a power cut.
///
/// # Errors
/// The system refuses.
pub fn replace(path: &Path, text: &[u8]) -> Result<(), RecordError> {
    let beside = path.with_extension("new");
    if beside.exists() {
        // What a cut left behind; it was never part of the recording.
        fs::remove_file(&beside).map_err(RecordError::file(&beside))?;
    }
    let mut file = new_file(&beside)?;
    file.write_all(text).and_then(|()| file.sync_all()).map_err(RecordError::file(&beside))?;
    fs::rename(&beside, path).map_err(RecordError::file(path))?;
    sync_dir(path)
}

/// Makes names in the folder of `path` last.
pub(super) fn sync_dir(path: &Path) -> Result<(), RecordError> {
    #[cfg(unix)]
    if let Some(folder) = path.parent() {
        File::open(folder).and_then(|folder| folder.sync_all()).map_err(RecordError::file(folder))?;
    }
    Ok(())
}
