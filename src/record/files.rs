//! Files that are made once, for the user alone, and reach the disk. In: paths. Out: files, or the system's own words.

use super::RecordError;
use crate::private;
use fail::fail_point;
use std::{
    fs::{self, File},
    io::{ErrorKind, Write},
    path::{Path, PathBuf},
};

/// Waits until the disk has a file whole, its length included.
pub(super) fn sync_file(file: &File, path: &Path) -> Result<(), RecordError> {
    file.sync_all().map_err(RecordError::file(path))
}

/// Makes a folder and those above it, private to the user, so that the disk has their names. One that is there already is left as it is.
///
/// # Errors
/// The system refuses.
pub fn new_private_dir(path: &Path) -> Result<(), RecordError> {
    let missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.is_dir();
    let new: Vec<&Path> = path.ancestors().take_while(missing).collect();
    private::folder(path).map_err(RecordError::file(path))?;
    new.into_iter().rev().try_for_each(sync_dir)
}

/// True if there is such a file or folder. A disk that does not say is an error: what is only out of reach is not to be taken for missing.
///
/// # Errors
/// The system refuses to look.
pub fn is_there(path: &Path) -> Result<bool, RecordError> {
    path.try_exists().map_err(RecordError::file(path))
}

/// Files and folders in a folder; none where it is not there.
///
/// # Errors
/// The system refuses to list it: what is only out of reach is not to be taken for missing.
pub fn entries(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let listed = fs::read_dir(folder).and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
    match listed {
        Err(why) if why.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        listed => listed.map_err(RecordError::file(folder)),
    }
}

/// Removes a file or a whole folder, if it is there.
///
/// # Errors
/// The system refuses.
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

/// Ending of a file that is not whole yet.
pub const BESIDE: &str = "new";

/// A new file, private to the user.
///
/// # Errors
/// There is one already, or the system refuses.
pub(super) fn new_file(path: &Path) -> Result<File, RecordError> {
    private::file(path).map_err(RecordError::file(path))
}

/// Writes a whole new file, private to the user, that reaches the disk.
///
/// # Errors
/// There is one already, or the system refuses.
pub fn write_new(path: &Path, text: &[u8]) -> Result<(), RecordError> {
    let mut file = new_file(path)?;
    file.write_all(text).map_err(RecordError::file(path))?;
    sync_file(&file, path)?;
    sync_dir(path)
}

/// Writes a whole file so that at every moment either the old one or the new one is there, also after a power cut.
///
/// # Errors
/// The system refuses.
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

/// The same for a file that is too large to be held whole: `write` writes it part by part.
///
/// # Errors
/// `write` fails, and the old file is as it was; the system refuses.
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

/// A new file in which that at `path` is written, until it is whole and takes its place.
///
/// # Errors
/// The system refuses.
pub(super) fn new_beside(path: &Path) -> Result<(PathBuf, File), RecordError> {
    let beside = path.with_extension(BESIDE);
    let file = private::file_beside(&beside).map_err(RecordError::file(&beside))?;
    Ok((beside, file))
}

/// Gives a file or folder another name in its folder, so that the disk has it.
///
/// # Errors
/// The system refuses.
pub fn rename(from: &Path, to: &Path) -> Result<(), RecordError> {
    fs::rename(from, to).map_err(RecordError::file(to))?;
    sync_dir(to)
}

/// Makes names in the folder of `path` last.
pub(super) fn sync_dir(path: &Path) -> Result<(), RecordError> {
    #[cfg(unix)]
    if let Some(folder) = path.parent() {
        // The folder of a bare name is the one that the program stands in.
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let open = File::open(folder).map_err(RecordError::file(folder))?;
        sync_file(&open, folder)?;
    }
    Ok(())
}
