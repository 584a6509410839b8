//! Folders for temporary files. In: a place. Out: a folder of mode 0700 with a name that cannot be guessed. It is removed when
//! dropped, by [`remove_all`] before the program ends early, or otherwise by the next program of this user that makes one.
//!
//! Each folder holds a file that its program keeps locked while it runs. The system releases the lock when the program ends, in
//! whatever way, so a folder with a free lock is abandoned. A process id would prove nothing: in containers every start has the
//! same one.

use crate::private;
use std::{
    collections::BTreeSet,
    env,
    fs::{self, File, Metadata},
    io::{self, ErrorKind, Write},
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

/// Prefix of the names of all temporary folders.
const PREFIX: &str = "codrive-tmp-";
/// Number of random characters in a name, about 95 bits.
const RANDOM_CHARACTERS: usize = 16;
/// Name of the locked file.
const LOCK: &str = "lock";
/// Maximum number of attempts: another program can take a new folder for an abandoned one before it is locked.
const ATTEMPTS: usize = 16;

/// Existing folders of this process.
static LIVE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
/// Places from which this process has removed abandoned folders.
static CLEANED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Private folder, removed with its contents when dropped.
#[derive(Debug)]
pub struct TemporaryFolder {
    path: PathBuf,
    _lock: File,
}

impl TemporaryFolder {
    /// Makes a folder in the system's place for temporary files (`TMPDIR`).
    ///
    /// # Errors
    /// An I/O error, with the place and a remedy.
    pub fn new() -> io::Result<Self> {
        let place = env::temp_dir();
        Self::within(&place).map_err(|error| {
            let text =
                format!("{}: {error}\n  remedy: set TMPDIR to a writable folder with free space", place.display());
            io::Error::new(error.kind(), text)
        })
    }

    /// Makes a folder in another place, for files that are then renamed within that place.
    ///
    /// # Errors
    /// An I/O error.
    pub fn within(place: &Path) -> io::Result<Self> {
        let made = (0..ATTEMPTS).find_map(|_| Self::attempt(place).transpose());
        let folder =
            made.unwrap_or_else(|| Err(io::Error::other("other programs remove each new temporary folder")))?;
        let is_first = CLEANED.lock().unwrap_or_else(PoisonError::into_inner).insert(place.into());
        if is_first {
            remove_abandoned(place, &fs::symlink_metadata(&folder.path)?);
        }
        Ok(folder)
    }

    /// Makes one attempt; `None` if another program took the new folder for an abandoned one.
    fn attempt(place: &Path) -> io::Result<Option<Self>> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).rand_bytes(RANDOM_CHARACTERS);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
        let path = builder.tempdir_in(place)?.keep();
        LIVE.lock().unwrap_or_else(PoisonError::into_inner).insert(path.clone());
        let lock = match lock_of(&path) {
            // A lock on a file that was removed before it was taken is worthless.
            Ok(Some(lock)) if path.join(LOCK).exists() => lock,
            Ok(_) => return Ok(None),
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                remove(&path);
                return Err(error);
            }
        };
        Ok(Some(Self { path, _lock: lock }))
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a new file of mode 0600 into the folder. Returns the file's path.
    ///
    /// # Errors
    /// A file of this name exists, or an I/O error; with the path.
    pub fn write(&self, name: &str, bytes: &[u8]) -> io::Result<PathBuf> {
        let path = self.path.join(name);
        let written = private::file(&path).and_then(|mut file| file.write_all(bytes));
        let named = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
        written.map_err(named)?;
        Ok(path)
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        remove(&self.path);
    }
}

/// Removes all temporary folders of this process. For a program that ends without running destructors.
pub fn remove_all() {
    let live: Vec<PathBuf> = LIVE.lock().unwrap_or_else(PoisonError::into_inner).iter().cloned().collect();
    live.iter().for_each(|path| remove(path));
}

/// Removes a folder of this process. Anything that cannot be removed is left to the next program.
fn remove(path: &Path) {
    // The lock file is removed last, so that no other program removes the rest meanwhile.
    for entry in fs::read_dir(path).into_iter().flatten().flatten().filter(|entry| entry.file_name() != LOCK) {
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        let _ = if is_folder { fs::remove_dir_all(entry.path()) } else { fs::remove_file(entry.path()) };
    }
    let _ = fs::remove_dir_all(path);
    LIVE.lock().unwrap_or_else(PoisonError::into_inner).remove(path);
}

/// Takes the lock of a folder; `None` if a program holds it.
fn lock_of(folder: &Path) -> io::Result<Option<File>> {
    let file = private::lock_file(&folder.join(LOCK))?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(fs::TryLockError::WouldBlock) => Ok(None),
        Err(fs::TryLockError::Error(error)) => Err(error),
    }
}

/// Removes abandoned folders in `place` that belong to the same user as `own`, a new folder of this process.
fn remove_abandoned(place: &Path, own: &Metadata) {
    for entry in fs::read_dir(place).into_iter().flatten().flatten() {
        let path = entry.path();
        let is_named = entry.file_name().to_string_lossy().starts_with(PREFIX);
        // Links are skipped: another user may have put them there.
        if !is_named || !fs::symlink_metadata(&path).is_ok_and(|found| found.is_dir() && is_of_same_user(&found, own)) {
            continue;
        }
        // New folders of this process are locked and thus stay.
        if let Ok(Some(_lock)) = lock_of(&path) {
            remove(&path);
        }
    }
}

#[cfg(unix)]
fn is_of_same_user(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    one.uid() == other.uid()
}

#[cfg(not(unix))]
fn is_of_same_user(_: &Metadata, _: &Metadata) -> bool {
    true
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    fn names(place: &Path) -> Vec<String> {
        let entries = fs::read_dir(place).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_temporary_folder_is_private_unguessable_and_gone_when_dropped() {
        let place = tempfile::tempdir().unwrap();
        let [one, other] = [0, 1].map(|_| TemporaryFolder::within(place.path()).unwrap());
        let file = one.write("a.xml", b"text").unwrap();
        assert!(one.write("a.xml", b"again").is_err(), "a name is used once");
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!([mode(one.path()), mode(&file)], [0o700, 0o600]);
        let [name, other_name] = [&one, &other].map(|folder| folder.path().file_name().unwrap().to_owned());
        assert_ne!(name, other_name);
        assert!(!name.to_string_lossy().contains(&std::process::id().to_string()));
        drop((one, other));
        assert_eq!(names(place.path()), [""; 0]);
    }

    #[test]
    fn only_abandoned_folders_are_removed_at_the_next_start() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        // A folder of an ended program, one that ended before it locked, one of a running program, and another name.
        for name in ["codrive-tmp-dead", "codrive-tmp-early", "codrive-tmp-alive", "other"] {
            fs::create_dir(at(name)).unwrap();
            fs::write(at(name).join("demand.rou.xml"), "<routes/>").unwrap();
        }
        fs::write(at("codrive-tmp-dead").join(LOCK), "").unwrap();
        let alive = lock_of(&at("codrive-tmp-alive")).unwrap().expect("free");
        // A link of another user leads to files that must stay.
        let victim = tempfile::tempdir().unwrap();
        fs::write(victim.path().join("mine.txt"), "mine").unwrap();
        symlink(victim.path(), at("codrive-tmp-link")).unwrap();
        fs::write(at("codrive-tmp-file"), "a file").unwrap();

        let own = TemporaryFolder::within(place.path()).unwrap();
        assert!(own.path().is_dir(), "the new one stays");
        drop(own);
        assert_eq!(names(place.path()), ["codrive-tmp-alive", "codrive-tmp-file", "codrive-tmp-link", "other"]);
        assert_eq!(names(victim.path()), ["mine.txt"]);
        assert_eq!(names(&at("codrive-tmp-alive")), ["demand.rou.xml", LOCK]);
        drop(alive);
    }

    #[test]
    fn a_place_that_cannot_be_written_is_named() {
        let place = tempfile::tempdir().unwrap();
        let error = TemporaryFolder::within(&place.path().join("nowhere")).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::NotFound);
    }
}
