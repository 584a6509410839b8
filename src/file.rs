//! Reading of files that the user names. In: a path and the maximum size. Out: the bytes or the text, or a [`std::io::Error`]
//! with a specific kind and a text that says what is allowed. Only regular files are opened, so that nothing waits for a pipe;
//! no more than the limit is ever in memory. Compressed files are unpacked where a caller asks for it; limits apply to the content.

use std::{
    fs::{self, File, OpenOptions},
    io::{BufReader, Error, ErrorKind, Read, Seek, SeekFrom},
    path::Path,
};

/// Maximum size of a file of settings, bytes: fifty times the largest shipped one. Its worst text, a list of two million
/// numbers, takes less than 256 MiB once parsed.
pub const SETTINGS_BYTES: u64 = 1 << 20;

/// Opens a regular file for reading; refuses folders, pipes, sockets and devices. Never waits.
///
/// # Errors
/// An I/O error, or no regular file ([`ErrorKind::InvalidInput`]; a folder [`ErrorKind::IsADirectory`]).
pub fn open_regular(path: &Path) -> Result<File, Error> {
    // Checked before it is opened: opening a device may have effects, and opening a pipe waits for its other end.
    check_regular(&fs::metadata(path)?)?;
    let mut options = OpenOptions::new();
    options.read(true);
    // If the file is replaced by a pipe in between, this open returns at once and the second check finds it.
    #[cfg(target_os = "linux")]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, nix::libc::O_NONBLOCK | nix::libc::O_NOCTTY);
    let file = options.open(path)?;
    check_regular(&file.metadata()?)?;
    Ok(file)
}

/// Reads a whole regular file of at most `limit` bytes.
///
/// # Errors
/// As [`open_regular`]; or more than `limit` bytes ([`ErrorKind::FileTooLarge`]).
pub fn read_bounded(path: &Path, limit: u64) -> Result<Vec<u8>, Error> {
    let file = open_regular(path)?;
    let size = file.metadata()?.len();
    if size > limit {
        return Err(too_large(limit));
    }
    let bytes = Vec::with_capacity(usize::try_from(size).unwrap_or_default());
    // The file may grow while it is read, and files of the kernel report size 0.
    read_to_end(file, limit, bytes)
}

/// Reads `length` bytes from `offset` on of a regular file, which must hold them.
///
/// # Errors
/// As [`open_regular`]; or the file ends before ([`ErrorKind::UnexpectedEof`]).
pub fn read_part(path: &Path, offset: u64, length: u64) -> Result<Vec<u8>, Error> {
    let mut file = open_regular(path)?;
    let size = file.metadata()?.len();
    let fits = offset.checked_add(length).is_some_and(|end| end <= size);
    if !fits {
        let text = format!("the file has {size} bytes; {length} bytes from {offset} on are needed");
        return Err(Error::new(ErrorKind::UnexpectedEof, text));
    }
    file.seek(SeekFrom::Start(offset))?;
    let mut bytes = vec![0; usize::try_from(length).map_err(|_| too_large(u64::from(u32::MAX)))?];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Reads text of at most `limit` bytes from a stream, such as the standard input, to its end.
///
/// # Errors
/// As [`read_text`].
pub fn read_text_from(source: impl Read, limit: u64) -> Result<String, Error> {
    text_of(read_to_end(source, limit, Vec::new())?)
}

fn read_to_end(source: impl Read, limit: u64, mut bytes: Vec<u8>) -> Result<Vec<u8>, Error> {
    source.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { Err(too_large(limit)) } else { Ok(bytes) }
}

/// Reads a whole regular file of at most `limit` bytes as text.
///
/// # Errors
/// As [`read_bounded`]; or no UTF-8 text ([`ErrorKind::InvalidData`], with the line of the first bad byte).
pub fn read_text(path: &Path, limit: u64) -> Result<String, Error> {
    text_of(read_bounded(path, limit)?)
}

/// Returns the content of a file, compressed (gzip) or not, whatever its name is.
///
/// # Errors
/// The file cannot be read.
pub fn unpacked(mut file: File) -> Result<Box<dyn Read>, Error> {
    let mut head = Vec::new();
    file.by_ref().take(2).read_to_end(&mut head)?;
    file.rewind()?;
    Ok(match head[..] {
        [0x1f, 0x8b] => Box::new(flate2::bufread::MultiGzDecoder::new(BufReader::new(file))),
        _ => Box::new(file),
    })
}

fn text_of(bytes: Vec<u8>) -> Result<String, Error> {
    String::from_utf8(bytes).map_err(|e| {
        let good = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = good.split(|byte| *byte == b'\n').count();
        Error::new(ErrorKind::InvalidData, format!("not UTF-8 text (line {line}); save the file as UTF-8"))
    })
}

/// Returns a size as text, in bytes, KiB or MiB, rounded down.
pub fn size_text(bytes: u64) -> String {
    match bytes {
        0..1024 => format!("{bytes} bytes"),
        1024..1_048_576 => format!("{} KiB", bytes >> 10),
        _ => format!("{} MiB", bytes >> 20),
    }
}

fn too_large(limit: u64) -> Error {
    Error::new(ErrorKind::FileTooLarge, format!("it holds more than {}, the most that is read", size_text(limit)))
}

fn check_regular(facts: &fs::Metadata) -> Result<(), Error> {
    let kind = facts.file_type();
    if kind.is_file() {
        return Ok(());
    }
    if kind.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is a folder; name a file"));
    }
    #[cfg(unix)]
    let what = {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            "a pipe"
        } else if kind.is_socket() {
            "a socket"
        } else {
            "a device"
        }
    };
    #[cfg(not(unix))]
    let what = "no file";
    Err(Error::new(
        ErrorKind::InvalidInput,
        format!("it is {what}; save its data in a regular file, and name that file"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_the_limit_is_read_and_a_larger_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "12345678").unwrap();
        assert_eq!(read_text(&path, 8).unwrap(), "12345678");
        let error = read_bounded(&path, 7).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        assert_eq!(error.to_string(), "it holds more than 7 bytes, the most that is read");
    }

    #[test]
    fn a_part_is_read_only_if_the_file_holds_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "12345678").unwrap();
        assert_eq!(read_part(&path, 2, 3).unwrap(), b"345");
        assert_eq!(read_part(&path, 8, 0).unwrap(), b"");
        for (offset, length) in [(6, 3), (9, 0), (u64::MAX, 2), (0, u64::MAX)] {
            assert_eq!(read_part(&path, offset, length).unwrap_err().kind(), ErrorKind::UnexpectedEof, "{offset}");
        }
    }

    #[test]
    fn a_file_that_reports_size_0_is_still_bounded() {
        // Files of the kernel have size 0 and contents.
        let error = read_bounded(Path::new("/proc/self/maps"), 100).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
    }

    #[test]
    fn missing_files_and_invalid_text_give_different_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        assert_eq!(read_text(&path, 8).unwrap_err().kind(), ErrorKind::NotFound);
        fs::write(&path, b"ab\nc\xff").unwrap();
        let error = read_text(&path, 8).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidData);
        assert_eq!(error.to_string(), "not UTF-8 text (line 2); save the file as UTF-8");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn folders_pipes_and_devices_are_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(read_bounded(folder.path(), 8).unwrap_err().kind(), ErrorKind::IsADirectory);
        let pipe = folder.path().join("pipe");
        nix::unistd::mkfifo(&pipe, nix::sys::stat::Mode::S_IRWXU).unwrap();
        let error = read_bounded(&pipe, 8).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
        assert!(error.to_string().starts_with("it is a pipe; save"), "{error}");
        let error = open_regular(Path::new("/dev/zero")).unwrap_err();
        assert!(error.to_string().starts_with("it is a device"), "{error}");
    }
}
