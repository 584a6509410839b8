//! Sidecars at the top of a data set, which tables of all participants inherit. In: a data set. Out: each is there while a table is that
//! it describes: BIDS takes one without a table for a mistake.

use super::{SessionError, event_table, motion};
use crate::{
    file::{SETTINGS_BYTES, read_text},
    record::{self, RecordError},
};
use serde_json::Value;
use std::{fs, io::ErrorKind, path::Path};

/// Writes the sidecars that describe something, and removes the others.
///
/// # Errors
/// The disk refuses.
pub(super) fn settle(root: &Path) -> Result<(), SessionError> {
    let about = read_text(&root.join("dataset_description.json"), SETTINGS_BYTES).unwrap_or_default();
    let about: Value = serde_json::from_str(&about).unwrap_or_default();
    let events = || event_table::sidecar(about["HEDVersion"].is_string());
    put(root, event_table::SIDECAR, has_table(root, "_events.tsv").then(events))?;
    put(root, motion::CHANNELS_JSON, has_table(root, "_channels.tsv").then(motion::reference_frames))
}

fn put(root: &Path, name: &str, text: Option<String>) -> Result<(), SessionError> {
    let path = root.join(name);
    if let Some(text) = text {
        return Ok(record::replace(&path, text.as_bytes())?);
    }
    match fs::remove_file(&path) {
        Err(why) if why.kind() != ErrorKind::NotFound => Err(RecordError::File { path, why }.into()),
        _ => Ok(()),
    }
}

/// True if any participant has a table whose name ends so.
fn has_table(root: &Path, ending: &str) -> bool {
    let names = |folder: &Path| fs::read_dir(folder).into_iter().flatten().flatten().collect::<Vec<_>>();
    let people = names(root).into_iter().filter(|entry| entry.file_name().to_string_lossy().starts_with("sub-"));
    let mut folders = people.flat_map(|person| ["beh", "motion"].map(|kind| person.path().join(kind)));
    folders.any(|folder| names(&folder).iter().any(|entry| entry.file_name().to_string_lossy().ends_with(ending)))
}
