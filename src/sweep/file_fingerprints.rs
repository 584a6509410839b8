//! SHA-256 of the files that runs read. In: a path. Out: the fingerprint of what is in the file. A file is read once a process, however many
//! runs name it, and again when it is no longer the file that was read.

use crate::record::{RecordError, file_sha256};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    sync::{LazyLock, Mutex, PoisonError},
    time::{Duration, SystemTime},
};

/// By the path as it was given; whether an entry still holds is seen by the file, so that plans share them.
static KNOWN: LazyLock<Mutex<BTreeMap<PathBuf, KnownFile>>> = LazyLock::new(Mutex::default);
/// A file that was written to so recently may be written to again without a new time: the clocks of file systems go in steps, of two
/// seconds at the most (FAT).
const STEP: Duration = Duration::from_secs(2);

/// A file that was read.
#[derive(Clone)]
struct KnownFile {
    stamp: FileStamp,
    sha256: String,
}

/// What changes when a file does.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FileStamp {
    bytes: u64,
    modified: SystemTime,
}

impl FileStamp {
    /// `None` where the system does not say.
    fn of(path: &Path) -> Option<Self> {
        let about = fs::metadata(path).ok()?;
        Some(Self { bytes: about.len(), modified: about.modified().ok()? })
    }

    /// True if whatever is written from now on gets another time.
    #[allow(clippy::disallowed_methods, reason = "the age of a file is a matter of wall time, and no run knows of it")]
    fn is_settled(&self) -> bool {
        SystemTime::now().duration_since(self.modified).is_ok_and(|age| age > STEP)
    }
}

/// SHA-256 of a file, hexadecimal.
///
/// # Errors
/// It cannot be read.
pub(super) fn sha256_of(path: &Path) -> Result<String, RecordError> {
    let stamp = FileStamp::of(path);
    let known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner).get(path).cloned();
    if let Some(known) = known.filter(|known| Some(known.stamp) == stamp) {
        return Ok(known.sha256);
    }
    let sha256 = file_sha256(path)?;
    // Taken before it was read: what was written meanwhile is seen the next time.
    if let Some(stamp) = stamp.filter(FileStamp::is_settled) {
        let known = KnownFile { stamp, sha256: sha256.clone() };
        KNOWN.lock().unwrap_or_else(PoisonError::into_inner).insert(path.into(), known);
    }
    Ok(sha256)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SHA-256 of "abc" and of "abd": FIPS 180-2, appendix B.1; the other by sha256sum.
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
        // Another text of the same length under the same time: whoever reads the file again sees it.
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
