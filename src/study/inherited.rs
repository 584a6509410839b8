//! Sidecars at the top of a data set, which the tables of all participants inherit. In: a data set. Out: each sidecar exists while a
//! table exists that it describes; for BIDS, a sidecar without a table is an error.

use super::{SessionError, event_table, motion};
use crate::record::{self, RecordError};
use std::{fs, io::ErrorKind, path::Path};

/// Writes the sidecars that describe a table, and removes the others.
///
/// # Errors
/// A file cannot be read, written or removed.
pub(super) fn settle(root: &Path) -> Result<(), SessionError> {
    write_or_remove(root, event_table::SIDECAR, has_table(root, "_events.tsv")?.then(event_table::sidecar))?;
    write_or_remove(root, motion::CHANNELS_JSON, has_table(root, "_channels.tsv")?.then(motion::reference_frames))
}

fn write_or_remove(root: &Path, name: &str, text: Option<String>) -> Result<(), SessionError> {
    let path = root.join(name);
    if let Some(text) = text {
        return Ok(record::replace(&path, text.as_bytes())?);
    }
    match fs::remove_file(&path) {
        Err(why) if why.kind() != ErrorKind::NotFound => Err(RecordError::File { path, why }.into()),
        _ => Ok(()),
    }
}

/// Returns true if any participant has a table whose name ends in `ending`.
fn has_table(root: &Path, ending: &str) -> Result<bool, RecordError> {
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    for person in record::entries(root)?.into_iter().filter(|path| path.is_dir() && name(path).starts_with("sub-")) {
        for kind in ["beh", "motion"] {
            if record::entries(&person.join(kind))?.iter().any(|path| name(path).ends_with(ending)) {
                return Ok(true);
            }
        }
    }
    Ok(false)
}
