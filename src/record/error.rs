//! Reasons why a recording cannot begin, continue or be read. In: a path and an error of the system. Out: a message with a remedy.

use std::path::PathBuf;

/// Reason why a recording cannot begin, continue or be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// Folder that holds a recording already.
    #[error("{folder} holds a recording already ({file}); nothing is overwritten: name another folder")]
    Taken {
        folder: PathBuf,
        /// Name of the file found in it.
        file: String,
    },
    /// File that the system refused.
    #[error("{path}: {why}{}", remedy(why))]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        why: std::io::Error,
    },
    /// Writer too slow for the drive, seconds of rows in the queue.
    #[error("recording stopped: the disk writer stalled ({0} s of rows wait); everything before is kept")]
    Full(u64),
    /// Writing thread that stopped, with the reason.
    #[error("recording stopped: {0}; everything before is kept")]
    Stopped(String),
    /// Table that is not as this program writes it.
    #[error("{path}: {why}")]
    Table {
        /// Path of the file.
        path: PathBuf,
        /// Description of the fault.
        why: String,
    },
    /// Recording of a drive still in progress.
    #[error(
        "{0}: the drive is still running and is being recorded\n  remedy: end it first (Esc in its window, or Ctrl-C \
         without a window)"
    )]
    Running(PathBuf),
    /// Recording that was cut and not yet recovered.
    #[error("{0}: the recording was cut before its end\n  remedy: codrive recover {0}")]
    Cut(PathBuf),
    /// Journal that the disk did not return as it was written.
    #[error(
        "{folder}: the recording ended, but the disk lost part of it: {missing}. All that can be read is in the tables, the journal is kept in {kept}\n  remedy: check this disk before you record on it again"
    )]
    Damaged {
        /// Folder of the recording.
        folder: PathBuf,
        /// Description of the missing rows.
        missing: String,
        /// Folder where the journal is kept.
        kept: PathBuf,
    },
    /// Folder without a recording.
    #[error("{0} holds no recording: there is no manifest.json in it")]
    Absent(PathBuf),
}

/// Remedy for a full disk.
const FULL: &str = "; what was written before is kept\n  remedy: make room on the disk; codrive recover FOLDER completes the \
                    recording of a drive that was cut";

fn remedy(why: &std::io::Error) -> &'static str {
    match why.kind() {
        std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => FULL,
        // A file over the program's own size limit is no full disk; the system's EFBIG is.
        std::io::ErrorKind::FileTooLarge if why.raw_os_error().is_some() => FULL,
        std::io::ErrorKind::AlreadyExists => "; nothing is overwritten: name another",
        std::io::ErrorKind::PermissionDenied => "; choose a folder that you may write to",
        _ => "",
    }
}

impl RecordError {
    pub(super) fn file(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |why| Self::File { path, why }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Error, ErrorKind};

    #[test]
    fn a_refused_file_is_reported_with_a_remedy() {
        for (kind, remedy) in [
            (ErrorKind::StorageFull, "make room on the disk; codrive recover FOLDER"),
            (ErrorKind::QuotaExceeded, "make room on the disk; codrive recover FOLDER"),
            (ErrorKind::AlreadyExists, "nothing is overwritten: name another"),
            (ErrorKind::PermissionDenied, "choose a folder that you may write to"),
        ] {
            let message = RecordError::file("drives/p1")(Error::from(kind)).to_string();
            assert!(message.contains("drives/p1") && message.contains(remedy), "{message}");
        }
        let full = RecordError::file("drives/p1")(Error::from_raw_os_error(nix::libc::EFBIG)).to_string();
        assert!(full.contains("make room on the disk; codrive recover FOLDER"), "{full}");
        let large = RecordError::file("in.rou.xml")(Error::new(ErrorKind::FileTooLarge, "it holds more than 64 MiB"));
        assert_eq!(
            large.to_string(),
            "in.rou.xml: it holds more than 64 MiB",
            "an input that is too large fills no disk"
        );
        let other = RecordError::file("drives/p1")(Error::from(ErrorKind::NotFound)).to_string();
        assert!(!other.contains("; "), "there is none: {other}");
    }
}
