//! SHA-256 of the files that runs read. In: a path. Out: the fingerprint of the file's content. Each process reads a file once, however
//! many runs name it, and again after the file has changed.

use crate::record::{RecordError, file_sha256};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    sync::{LazyLock, Mutex, PoisonError},
    time::{Duration, SystemTime},
};

/// Known files by path as given. Each entry is validated against the file, so that plans can share them.
static KNOWN: LazyLock<Mutex<BTreeMap<PathBuf, KnownFile>>> = LazyLock::new(Mutex::default);
/// Age below which a file may change again without a new modification time: clocks of file systems have steps of up to two seconds (FAT).
const STEP: Duration = Duration::from_secs(2);

/// A file that has been read.
#[derive(Clone)]
struct KnownFile {
    stamp: FileStamp,
    sha256: String,
}

/// Size and modification time, used to detect a change of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FileStamp {
    bytes: u64,
    modified: SystemTime,
}

impl FileStamp {
    /// Returns the stamp of a file; `None` if the system does not provide it.
    fn of(path: &Path) -> Option<Self> {
        let about = fs::metadata(path).ok()?;
        Some(Self { bytes: about.len(), modified: about.modified().ok()? })
    }

    /// Returns true if any later write gets another modification time.
    #[allow(clippy::disallowed_methods, reason = "the age of a file is a matter of wall time, and no run knows of it")]
    fn is_settled(&self) -> bool {
        SystemTime::now().duration_since(self.modified).is_ok_and(|age| age > STEP)
    }
}

/// Returns the SHA-256 of a file in hexadecimal.
///
/// # Errors
/// The file cannot be read.
pub(super) fn sha256_of(path: &Path) -> Result<String, RecordError> {
    let stamp = FileStamp::of(path);
    let known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner).get(path).cloned();
    if let Some(known) = known.filter(|known| Some(known.stamp) == stamp) {
        return Ok(known.sha256);
    }
    let sha256 = file_sha256(path)?;
    // The stamp was taken before reading, so that a write in between is noticed the next time.
    if let Some(stamp) = stamp.filter(FileStamp::is_settled) {
        let known = KnownFile { stamp, sha256: sha256.clone() };
        KNOWN.lock().unwrap_or_else(PoisonError::into_inner).insert(path.into(), known);
    }
    Ok(sha256)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SHA-256 of "abc" (FIPS 180-2, appendix B.1) and of "abd" (sha256sum).
    const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    const ABD: &str = "a52d159f262b2c6ddb724a61840befc36eb30c88877a4030b65cbe86298449c9";

    #[allow(clippy::disallowed_methods, reason = "files have the times of the clock on the wall")]
    fn put(path: &Path, text: &str, age_s: u64) {
        fs::write(path, text).expect("written");
        let time = SystemTime::now() - Duration::from_secs(age_s);
        fs::File::options().write(true).open(path).and_then(|file| file.set_modified(time)).expect("a time");
    }

    #[test]
    fn a_file_is_read_once_and_again_when_it_has_changed() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("policy.toml");
        put(&path, "abc", 100);
        assert_eq!(sha256_of(&path).expect("a file"), ABC);
        // Another text of the same length and modification time: a second read of the file would reveal it.
        let modified = fs::metadata(&path).and_then(|about| about.modified()).expect("a time");
        fs::write(&path, "abd").expect("written");
        let again = fs::File::options().write(true).open(&path).expect("a file");
        again.set_modified(modified).expect("a time");
        assert_eq!(sha256_of(&path).expect("a file"), ABC);
        put(&path, "abd", 50);
        assert_eq!(sha256_of(&path).expect("a file"), ABD);
        fs::remove_file(&path).expect("removed");
        assert!(sha256_of(&path).is_err());
    }

    #[test]
    fn a_file_that_was_just_written_is_read_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("policy.toml");
        put(&path, "abc", 0);
        let modified = fs::metadata(&path).and_then(|about| about.modified()).expect("a time");
        assert_eq!(sha256_of(&path).expect("a file"), ABC);
        fs::write(&path, "abd").expect("written");
        fs::File::options().write(true).open(&path).and_then(|file| file.set_modified(modified)).expect("a time");
        assert_eq!(sha256_of(&path).expect("a file"), ABD);
    }
}
