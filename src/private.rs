//! Files and folders that are private to the user, as data about people must be. In: paths. Out: folders of mode 0700 and files
//! of mode 0600, never through a link put in their place; or the system's error.

use std::{
    fs::{self, DirBuilder, File, OpenOptions},
    io::{self, ErrorKind, Write},
    path::Path,
};

/// Makes a folder and its parents. Existing folders are left as they are.
///
/// # Errors
/// An I/O error.
pub fn folder(path: &Path) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

/// Makes a new, empty file.
///
/// # Errors
/// A file, folder or link of this name exists, even a broken link; or an I/O error.
pub fn file(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

/// Opens a file that only holds a lock; makes it if it does not exist. Never waits.
///
/// # Errors
/// The name is that of a link, folder or pipe, or an I/O error.
pub fn lock_file(path: &Path) -> io::Result<File> {
    check_place(path)?;
    let mut options = OpenOptions::new();
    options.create(true).truncate(false).write(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

/// Checks that `path` is a regular file or does not exist.
fn check_place(path: &Path) -> io::Result<()> {
    match fs::symlink_metadata(path) {
        Ok(there) if !there.is_file() => {
            let what = if there.is_symlink() { "a symbolic link" } else { "no file" };
            let text = format!("{what} is in its place\n  remedy: remove it, or name another file");
            Err(io::Error::new(ErrorKind::AlreadyExists, text))
        }
        Ok(_) => Ok(()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error),
    }
}

/// Replaces a file atomically: at every moment the old or the new file is whole.
///
/// # Errors
/// The name is that of a link or folder, or an I/O error.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    check_place(path)?;
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".new");
    replace_by(path, &path.with_file_name(name), bytes, |_| Ok(()))
}

/// Replaces a file atomically through the temporary file `beside`. `written` is called with the new file before the rename, for
/// example to sync it.
///
/// # Errors
/// An I/O error or an error of `written`; the old file stays.
pub fn replace_by(
    path: &Path,
    beside: &Path,
    bytes: &[u8],
    written: impl FnOnce(&File) -> io::Result<()>,
) -> io::Result<()> {
    let mut file = file_beside(beside)?;
    let done = file.write_all(bytes).and_then(|()| written(&file)).and_then(|()| fs::rename(beside, path));
    if done.is_err() {
        let _ = fs::remove_file(beside);
    }
    done
}

/// Makes a new file that will replace another once it is whole. Removes a file of this name that a cut left behind.
///
/// # Errors
/// An I/O error.
pub fn file_beside(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Ok(()) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    file(path)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn files_are_private_and_never_written_through_a_link() {
        let scratch = tempfile::tempdir().unwrap();
        let inner = scratch.path().join("a/b");
        folder(&inner).unwrap();
        let path = inner.join("file.txt");
        replace(&path, b"one").unwrap();
        replace(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!([mode(&inner), mode(inner.parent().unwrap()), mode(&path)], [0o700, 0o700, 0o600]);

        let (victim, link) = (inner.join("victim"), inner.join("link"));
        fs::write(&victim, "mine").unwrap();
        for target in [&victim, &inner.join("nothing")] {
            symlink(target, &link).unwrap();
            let error = replace(&link, b"theirs").unwrap_err().to_string();
            assert!(error.contains("symbolic link") && error.contains("remedy"), "{error}");
            assert_eq!(file(&link).unwrap_err().kind(), ErrorKind::AlreadyExists);
            fs::remove_file(&link).unwrap();
        }
        // The temporary name may be a link, too.
        symlink(&victim, inner.join("file.txt.new")).unwrap();
        replace(&path, b"three").unwrap();
        assert_eq!((fs::read(&victim).unwrap(), fs::read(&path).unwrap()), (b"mine".to_vec(), b"three".to_vec()));
        assert_eq!(fs::read_dir(&inner).unwrap().count(), 2, "nothing is left beside");
    }
}
