//! Export of all data that a data set holds of one participant. In: a data set, a code, a new or empty folder. Out: the folder with raw
//! data, log, the participant's rows of the tables, results of an analysis, and a list of checksums; nothing about other participants.
//!
//! The export is made in a folder beside the requested one and renamed when it is complete. After a cut, the requested folder is still
//! absent or empty, and the same command starts again.

use super::{
    DataSet, ParticipantCode, SessionError, bids::TABLE_BYTES, checksums, erasure::tables, event_table, lock, motion,
};
use crate::{
    file::read_text,
    record::{self, RecordError},
};
use std::{
    fs::{self, File},
    path::{Path, PathBuf},
};

/// Files at the top about no participant, which describe the rest.
const ABOUT: [&str; 6] = [
    "dataset_description.json",
    ".bidsignore",
    "study.toml",
    "participants.json",
    event_table::SIDECAR,
    motion::CHANNELS_JSON,
];
/// Files of an analysis about no participant.
const ABOUT_DERIVED: [&str; 4] = ["columns.json", "dataset_description.json", "README.md", ".bidsignore"];
/// Mark of an incomplete export.
const BEGUN: &str = "export-is-not-whole";

impl DataSet {
    /// Copies everything about a participant to the folder `to`. Returns the number of files.
    ///
    /// # Errors
    /// There is no such participant, the session is running, the folder is not empty or lies in the data set, or a file cannot be copied.
    pub fn export(&self, code: &ParticipantCode, to: &Path) -> Result<usize, SessionError> {
        self.check_known(code)?;
        let at = |path: &Path| std::path::absolute(path).map_err(|why| RecordError::File { path: path.into(), why });
        let (to, root) = (at(to)?, at(self.root())?);
        if to.starts_with(&root) {
            let text = format!("{} is in the data set; name a folder outside {}", to.display(), root.display());
            return Err(SessionError::Refused(text));
        }
        if to.exists() && fs::read_dir(&to).map_or(true, |mut entries| entries.next().is_some()) {
            return Err(SessionError::Refused(format!(
                "{} already exists; name a new or an empty folder",
                to.display()
            )));
        }
        let folder = self.source(code);
        let _lock = folder.is_dir().then(|| lock::lock(&folder, code)).transpose()?;
        let part = begin(&to)?;
        self.copy_all(code, &part)?;
        fs::remove_file(part.join(BEGUN)).map_err(|why| RecordError::File { path: part.join(BEGUN), why })?;
        checksums::list(&part, &code.subject(), true)?;
        let count = checksums::files(&part)?.len();
        if to.exists() {
            fs::remove_dir(&to).map_err(|why| RecordError::File { path: to.clone(), why })?;
        }
        record::rename(&part, &to)?;
        Ok(count)
    }

    fn copy_all(&self, code: &ParticipantCode, to: &Path) -> Result<(), SessionError> {
        let (root, subject) = (self.root(), code.subject());
        for name in ABOUT {
            let path = root.join(name);
            if path.is_file() {
                copy(&path, &to.join(name))?;
            }
        }
        let derived = Path::new("derivatives").join("codrive");
        for folder in [Path::new("sourcedata").join(&subject), PathBuf::from(&subject), derived.join(&subject)] {
            if root.join(&folder).is_dir() {
                copy_folder(&root.join(&folder), &to.join(folder))?;
            }
        }
        for path in tables(root)? {
            self.put_rows(&path, '\t', &subject, to)?;
            let sidecar = path.with_extension("json");
            if sidecar.is_file() && !sidecar.ends_with("participants.json") {
                copy(&sidecar, &to.join(sidecar.strip_prefix(root).unwrap_or(&sidecar)))?;
            }
        }
        let results = record::entries(&root.join(&derived))?;
        for path in results.into_iter().filter(|path| path.extension().is_some_and(|ending| ending == "csv")) {
            self.put_rows(&path, ',', &subject, to)?;
        }
        for name in ABOUT_DERIVED.map(|name| derived.join(name)) {
            if root.join(&name).is_file() {
                copy(&root.join(&name), &to.join(&name))?;
            }
        }
        Ok(record::replace(&to.join("README.md"), readme(code).as_bytes())?)
    }

    /// Copies the header and the participant's rows of a table; skips a table without such rows, as one of means.
    fn put_rows(&self, path: &Path, separator: char, subject: &str, to: &Path) -> Result<(), SessionError> {
        let text = read_text(path, TABLE_BYTES).map_err(|why| RecordError::File { path: path.into(), why })?;
        let mut rows = rows(&text, separator == ',').into_iter();
        let head = rows.next().unwrap_or_default();
        let own: String = rows.filter(|row| row.trim_end().split(separator).next() == Some(subject)).collect();
        if own.is_empty() {
            return Ok(());
        }
        let place = to.join(path.strip_prefix(self.root()).unwrap_or(path));
        place.parent().map_or(Ok(()), record::new_private_dir)?;
        Ok(record::replace(&place, (head.to_owned() + &own).as_bytes())?)
    }
}

/// Splits a table into rows with their line ends. If `quoted`, a line end between quotes is part of a CSV cell.
fn rows(text: &str, quoted: bool) -> Vec<&str> {
    let mut within = false;
    let ends = text.bytes().enumerate().filter_map(|(i, byte)| {
        within ^= quoted && byte == b'"';
        (byte == b'\n' && !within).then_some(i + 1)
    });
    let mut begin = 0;
    let mut rows: Vec<&str> = ends.map(|end| &text[std::mem::replace(&mut begin, end)..end]).collect();
    if begin < text.len() {
        rows.push(&text[begin..]);
    }
    rows
}

/// Makes an empty folder beside `to`, after removing what an interrupted export left.
fn begin(to: &Path) -> Result<PathBuf, SessionError> {
    let mut name = to.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let part = to.with_file_name(name);
    if part.exists() {
        if !part.join(BEGUN).exists() {
            let text =
                format!("{} already exists and is not an interrupted export; name another folder", part.display());
            return Err(SessionError::Refused(text));
        }
        fs::remove_dir_all(&part).map_err(|why| RecordError::File { path: part.clone(), why })?;
    }
    record::new_private_dir(&part)?;
    record::write_new(&part.join(BEGUN), b"")?;
    Ok(part)
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), SessionError> {
    record::new_private_dir(to)?;
    let entries = fs::read_dir(from).and_then(Iterator::collect::<std::io::Result<Vec<_>>>);
    for entry in entries.map_err(|why| RecordError::File { path: from.into(), why })? {
        let kind = entry.file_type().map_err(|why| RecordError::File { path: entry.path(), why })?;
        let place = to.join(entry.file_name());
        if kind.is_dir() {
            copy_folder(&entry.path(), &place)?;
        } else if kind.is_file() && entry.file_name() != lock::FILE {
            copy(&entry.path(), &place)?;
        }
    }
    Ok(())
}

/// Copies a file, private to the user, and syncs it to disk.
fn copy(from: &Path, to: &Path) -> Result<(), SessionError> {
    to.parent().map_or(Ok(()), record::new_private_dir)?;
    record::write_new(to, b"")?;
    let copied = fs::copy(from, to).and_then(|_| File::open(to)?.sync_all());
    Ok(copied.map_err(|why| RecordError::File { path: to.into(), why })?)
}

fn readme(code: &ParticipantCode) -> String {
    format!(
        "# All data of participant {code}\n\n\
         This folder holds all data of this participant in the study, and no data of others.\n\n\
         * `sourcedata/{0}/session.json`: course of the session with times, answers and notes. The folders beside it \
         are the recorded drives (Parquet tables).\n\
         * `{0}/`: drives, events, answers and motion of the vehicle as tables. The JSON file beside a table defines \
         its columns; `events.json` and `*_channels.tsv` define those of events and motion. Dates in `{0}_scans.tsv` \
         are moved by the days in `sourcedata/{0}/date-shift.json`.\n\
         * `participants.tsv`, `phenotype/`: the participant's rows of the study's tables.\n\
         * `derivatives/codrive/`: the participant's rows of the analysis, if there was one; `columns.json` defines \
         the columns.\n\
         * `study.toml`: the plan of the study.\n\
         * `SHA256SUMS`: the files of the data, for `sha256sum --check`.\n",
        code.subject()
    )
}

#[cfg(test)]
#[path = "export_tests.rs"]
mod tests;
