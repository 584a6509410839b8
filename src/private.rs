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

/// Makes a folder and its parents below `base`, which the user named and which may itself be a link. A link on the way from `base` to the
/// folder is not followed: another person's recording or data set can carry one that leads to the user's own files.
///
/// # Errors
/// A link is on the way; or an I/O error.
pub fn folder_within(base: &Path, path: &Path) -> io::Result<()> {
    check_way(base, path)?;
    folder(path)
}

/// Checks that no link is on the way from `base` to `path`, both included in the way except `base`. Names that do not exist are no links.
///
/// # Errors
/// A link is on the way; the message names it, with the remedy.
pub fn check_way(base: &Path, path: &Path) -> io::Result<()> {
    let mut at = base.to_path_buf();
    for part in path.strip_prefix(base).unwrap_or(Path::new("")) {
        at.push(part);
        if at.is_symlink() {
            let text = format!(
                "{} is a symbolic link, and results are not written through a link in a recording, a data set or a folder \
                 of results\n  remedy: remove the link, or put the folder itself in its place",
                at.display()
            );
            return Err(io::Error::new(ErrorKind::InvalidInput, text));
        }
    }
    Ok(())
}

/// Returns the folder from which on links to `path` are not followed: `owner`, if `path` lies in it under any name, else `path` itself.
pub fn base_of<'a>(path: &'a Path, owner: &Path) -> &'a Path {
    let same = |folder: &Path| {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        folder.canonicalize().ok().zip(owner.canonicalize().ok()).is_some_and(|(one, other)| one == other)
    };
    path.ancestors().find(|folder| same(folder)).unwrap_or(path)
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
        // A folder is not made through a link either, wherever the link is on the way; the base itself may be one.
        let (base, elsewhere) = (scratch.path().join("base"), scratch.path().join("elsewhere"));
        folder(&elsewhere.join("inner")).unwrap();
        symlink(&elsewhere, &base).unwrap();
        folder_within(&base, &base.join("a/b")).unwrap();
        folder_within(&base, &base).unwrap();
        symlink(&inner, elsewhere.join("inner/link")).unwrap();
        symlink("nowhere", elsewhere.join("broken")).unwrap();
        for (way, link) in [("inner/link", "inner/link"), ("inner/link/c/d", "inner/link"), ("broken/c", "broken")] {
            let error = folder_within(&base, &base.join(way)).unwrap_err().to_string();
            let named = base.join(link).display().to_string();
            assert!(error.starts_with(&named) && error.contains("remedy: remove the link"), "{error}");
        }
        assert!(!inner.join("c").exists() && !scratch.path().join("nowhere").exists());
        // A path in the owner's folder begins there, under whatever name; another path is its own base.
        let owner = scratch.path().join("elsewhere");
        assert_eq!(base_of(&base.join("inner/x"), &owner), base);
        assert_eq!(base_of(&inner, &owner), inner);

        // The temporary name may be a link, too.
        symlink(&victim, inner.join("file.txt.new")).unwrap();
        replace(&path, b"three").unwrap();
        assert_eq!((fs::read(&victim).unwrap(), fs::read(&path).unwrap()), (b"mine".to_vec(), b"three".to_vec()));
        assert_eq!(fs::read_dir(&inner).unwrap().count(), 2, "nothing is left beside");
    }
}
