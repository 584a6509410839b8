//! Files and folders that are private to the user and reach the disk. In: paths. Out: files, or the system's error.

use super::RecordError;
use crate::private;
use fail::fail_point;
use std::{
    fs::{self, File},
    io::{ErrorKind, Write},
    path::{Path, PathBuf},
};

/// Waits until the disk has the whole file, including its length.
pub(super) fn sync_file(file: &File, path: &Path) -> Result<(), RecordError> {
    file.sync_all().map_err(RecordError::file(path))
}

/// Makes a folder and its parents, private to the user, and syncs their names to the disk. Existing folders are left as they
/// are.
///
/// # Errors
/// An I/O error.
pub fn new_private_dir(path: &Path) -> Result<(), RecordError> {
    let missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.is_dir();
    let new: Vec<&Path> = path.ancestors().take_while(missing).collect();
    private::folder(path).map_err(RecordError::file(path))?;
    new.into_iter().rev().try_for_each(sync_dir)
}

/// Makes a folder and its parents below `base`, as [`new_private_dir`], and follows no link below `base` ([`private::folder_within`]).
///
/// # Errors
/// A link is on the way; or an I/O error.
pub fn new_dir_within(base: &Path, path: &Path) -> Result<(), RecordError> {
    private::check_way(base, path).map_err(RecordError::file(path))?;
    new_private_dir(path)
}

/// Checks whether a file or folder exists. If the disk cannot tell, the result is an error: an unreachable file must not pass
/// for a missing one.
///
/// # Errors
/// An I/O error.
pub fn is_there(path: &Path) -> Result<bool, RecordError> {
    path.try_exists().map_err(RecordError::file(path))
}

/// Returns the files and folders in a folder; none if the folder does not exist.
///
/// # Errors
/// The folder cannot be listed: unreachable entries must not pass for missing ones.
pub fn entries(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let listed = fs::read_dir(folder).and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
    match listed {
        Err(why) if why.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        listed => listed.map_err(RecordError::file(folder)),
    }
}

/// Removes a file or a whole folder, if it exists.
///
/// # Errors
/// An I/O error.
pub fn remove(path: &Path) -> Result<(), RecordError> {
    let removed = match fs::symlink_metadata(path) {
        Ok(there) if there.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
        Err(why) => Err(why),
    };
    match removed {
        Err(why) if why.kind() != ErrorKind::NotFound => Err(RecordError::file(path)(why)),
        _ => Ok(()),
    }
}

/// Free space on the disk below which the program warns, GB. A session of an hour takes less than 1 GB.
pub const LITTLE_GB: f64 = 5.0;
/// Free space on the disk below which a rig counts as unfit, GB.
pub const TOO_LITTLE_GB: f64 = 1.0;

/// Returns the free space for this user on the disk of `folder`, bytes; `None` if the system does not report it.
#[cfg(target_os = "linux")]
pub fn free_bytes(folder: &Path) -> Option<u64> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let stat = nix::sys::statvfs::statvfs(folder).ok()?;
    Some(stat.blocks_available().saturating_mul(stat.fragment_size()))
}

/// Returns `None`: the free space is not read on this system.
#[cfg(not(target_os = "linux"))]
pub fn free_bytes(_folder: &Path) -> Option<u64> {
    None
}

/// File extension of a file that is being written.
pub const BESIDE: &str = "new";

/// Makes a new file, private to the user.
///
/// # Errors
/// The file exists already, or an I/O error.
pub(super) fn new_file(path: &Path) -> Result<File, RecordError> {
    private::file(path).map_err(RecordError::file(path))
}

/// Writes a new file, private to the user, and syncs it to the disk.
///
/// # Errors
/// The file exists already, or an I/O error.
pub fn write_new(path: &Path, text: &[u8]) -> Result<(), RecordError> {
    let mut file = new_file(path)?;
    file.write_all(text).map_err(RecordError::file(path))?;
    sync_file(&file, path)?;
    sync_dir(path)
}

/// Replaces a file atomically: at every moment the old or the new file is there, also after a power cut.
///
/// # Errors
/// An I/O error.
pub fn replace(path: &Path, text: &[u8]) -> Result<(), RecordError> {
    let on_disk = |file: &File| {
        file.sync_all()?;
        fail_point!("replace.written");
        Ok(())
    };
    private::replace_by(path, &path.with_extension(BESIDE), text, on_disk).map_err(RecordError::file(path))?;
    sync_dir(path)?;
    fail_point!("replace.renamed");
    Ok(())
}

/// Replaces a file atomically, like [`replace`], if it is too large for memory: `write` writes it part by part.
///
/// # Errors
/// `write` fails, and the old file stays; or an I/O error.
pub fn replace_streaming(
    path: &Path,
    write: impl FnOnce(&mut (dyn Write + Send)) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    let (beside, file) = new_beside(path)?;
    let mut out = std::io::BufWriter::with_capacity(1 << 16, &file);
    let written = write(&mut out).and_then(|()| out.flush().map_err(RecordError::file(&beside)));
    drop(out);
    if let Err(error) = written.and_then(|()| sync_file(&file, &beside)) {
        let _ = fs::remove_file(&beside);
        return Err(error);
    }
    fail_point!("replace.written");
    rename(&beside, path)?;
    fail_point!("replace.renamed");
    Ok(())
}

/// Makes a new file beside `path`, to be renamed to `path` when it is complete.
///
/// # Errors
/// An I/O error.
pub(super) fn new_beside(path: &Path) -> Result<(PathBuf, File), RecordError> {
    let beside = path.with_extension(BESIDE);
    let file = private::file_beside(&beside).map_err(RecordError::file(&beside))?;
    Ok((beside, file))
}

/// Renames a file or folder within its folder and syncs the new name to the disk.
///
/// # Errors
/// An I/O error.
pub fn rename(from: &Path, to: &Path) -> Result<(), RecordError> {
    fs::rename(from, to).map_err(RecordError::file(to))?;
    sync_dir(to)
}

/// Syncs the names in the parent folder of `path` to the disk.
pub(super) fn sync_dir(path: &Path) -> Result<(), RecordError> {
    #[cfg(unix)]
    if let Some(folder) = path.parent() {
        // A bare name lies in the working folder.
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let open = File::open(folder).map_err(RecordError::file(folder))?;
        sync_file(&open, folder)?;
    }
    Ok(())
}
