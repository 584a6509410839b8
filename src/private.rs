//! Files and folders for the user alone, as data about people should be. In: paths. Out: folders of mode 0700 and files of
//! mode 0600, never through a link that someone has put in their place; or the system's own words.

use std::{
    fs::{self, DirBuilder, File, OpenOptions},
    io::{self, ErrorKind, Write},
    path::Path,
};

/// Makes a folder and those above it. One that is there already is left as it is.
///
/// # Errors
/// The system refuses.
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
/// Something of this name is there already, be it a link to nothing; or the system refuses.
pub fn file(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

/// Opens a file that only holds a lock; makes it if it is not there. Never waits.
///
/// # Errors
/// Its name is a link's, a folder's or a pipe's, or the system refuses.
pub fn lock_file(path: &Path) -> io::Result<File> {
    check_place(path)?;
    let mut options = OpenOptions::new();
    options.create(true).truncate(false).write(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

/// Nothing is at `path`, or a file.
fn check_place(path: &Path) -> io::Result<()> {
    match fs::symlink_metadata(path) {
        Ok(there) if !there.is_file() => {
            let what = if there.is_symlink() { "a symbolic link" } else { "no file" };
            let text = format!("{what} is in its place\n  remedy: take it away, or name another file");
            Err(io::Error::new(ErrorKind::AlreadyExists, text))
        }
        Ok(_) => Ok(()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error),
    }
}

/// Writes a whole file in the place of one that may be there: at every moment the old one or the new one is whole.
///
/// # Errors
/// The name is a link's or a folder's, or the system refuses.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    check_place(path)?;
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".new");
    replace_by(path, &path.with_file_name(name), bytes, |_| Ok(()))
}

/// The same in any place, written `beside` it first; `written` sees the new file before it takes its place, as to wait for
/// the disk.
///
/// # Errors
/// The system or `written` refuses; the old file is as it was.
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

/// A new file that is to take the place of another once it is whole; what a cut has left in its name is removed.
///
/// # Errors
/// The system refuses.
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
    fn what_is_written_is_the_users_alone_and_never_behind_a_link() {
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
        // Nor behind one that waits where the new file is made.
        symlink(&victim, inner.join("file.txt.new")).unwrap();
        replace(&path, b"three").unwrap();
        assert_eq!((fs::read(&victim).unwrap(), fs::read(&path).unwrap()), (b"mine".to_vec(), b"three".to_vec()));
        assert_eq!(fs::read_dir(&inner).unwrap().count(), 2, "nothing is left beside");
    }
}
