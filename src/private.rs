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

/// Writes a whole file in the place of one that may be there: at every moment the old one or the new one is whole.
///
/// # Errors
/// The name is a link's or a folder's, or the system refuses.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    match fs::symlink_metadata(path) {
        Ok(there) if !there.is_file() => {
            let what = if there.is_symlink() { "a symbolic link" } else { "no file" };
            let text = format!("{what} is in its place\n  remedy: take it away, or name another file");
            return Err(io::Error::new(ErrorKind::AlreadyExists, text));
        }
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".new");
    let beside = path.with_file_name(name);
    match fs::remove_file(&beside) {
        // What a cut left behind.
        Ok(()) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    let written = file(&beside).and_then(|mut file| file.write_all(bytes)).and_then(|()| fs::rename(&beside, path));
    if written.is_err() {
        let _ = fs::remove_file(&beside);
    }
    written
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
