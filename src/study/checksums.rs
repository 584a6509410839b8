//! The list of a data set's files with their SHA-256, which reveals later changes of any file. In: the folder of the data set. Out:
//! `SHA256SUMS`, as `sha256sum --check` reads it; and the differences from it.
//!
//! The files of a participant are listed when the session is over. Files published again after every participant (`participants.tsv`,
//! `phenotype/`, `erased.tsv`) get a new entry each time. Figures and tables of an analysis (`derivatives/`) are not listed, as they can
//! be made again. Every other file must be on the list.

use super::{
    SessionError, event_table, motion,
    session_log::{self, SessionLog},
};
use crate::{
    analysis::models::plan::CHANGED,
    file::read_text,
    record::{
        self, AlteredFile, RecordError,
        seals::{OF_SYSTEMS, SIGNATURE},
    },
};
use rayon::prelude::*;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// File name of the list.
pub const FILE: &str = "SHA256SUMS";
/// Folders that hold no data, at any depth.
const MADE_AGAIN: [&str; 3] = ["derivatives", "analysis", "report"];
/// Maximum size of the list, bytes: 400,000 files, as of a thousand sessions of twenty drives.
const MOST_BYTES: u64 = 64 << 20;
/// Separator between the name of a recording and a changed setting, in a recording by `codrive replay --what-if` beside the original.
pub(super) const WHAT_IF: &str = "-what-if-";
/// File that only holds a lock.
const LOCK: &str = "lock";
/// File that marks an erasure in progress.
const ERASURE: &str = "erasure.json";

/// SHA-256 in hexadecimal, by file name relative to the data set, with slashes.
type ChecksumList = BTreeMap<String, String>;

/// Lists the files of a data set after a participant was published. The files of `subject` (`sub-P03`) get new entries if `is_over`, else
/// none; files of other participants keep their entries.
pub(super) fn list(root: &Path, subject: &str, is_over: bool) -> Result<(), SessionError> {
    let mut list = read(root)?.unwrap_or_default();
    // Raw data never change, so their entries stay. All other files were just made from them.
    list.retain(|name, _| match of_subject(name) {
        Some(of) => of != subject || (is_over && name.starts_with("sourcedata/")),
        None => !is_published_anew(name),
    });
    let wanted = |name: &String| !list.contains_key(name) && of_subject(name).is_none_or(|of| of == subject && is_over);
    let files: Vec<String> = files(root)?.into_iter().filter(wanted).collect();
    list.extend(sums(root, files)?);
    write(root, &list)
}

/// Removes a file, or a folder with its contents, from the list, if there is a list. `folder` is the name relative to the data set.
pub(super) fn forget(root: &Path, folder: &str) -> Result<(), SessionError> {
    let Some(mut list) = read(root)? else { return Ok(()) };
    list.retain(|name, _| !name.strip_prefix(folder).is_some_and(|rest| rest.is_empty() || rest.starts_with('/')));
    write(root, &list)
}

fn write(root: &Path, list: &ChecksumList) -> Result<(), SessionError> {
    let text: String = list.iter().map(|(name, sha256)| format!("{sha256}  {name}\n")).collect();
    Ok(record::replace(&root.join(FILE), text.as_bytes())?)
}

/// Lists the parts of a data set that differ from the list: changed files, missing files, and files not on the list.
///
/// # Errors
/// A file cannot be read.
pub fn changes(root: &Path) -> Result<Vec<AlteredFile>, SessionError> {
    let Some(list) = read(root)? else {
        let what =
            "is missing: every data set has this file after the start of its first session; codrive study makes it";
        return Ok(vec![AlteredFile { file: FILE.into(), what: what.into() }]);
    };
    let there = files(root)?;
    let now: ChecksumList = sums(root, there.iter().filter(|name| list.contains_key(*name)).cloned().collect())?;
    let listed = list.iter().filter_map(|(name, was)| match now.get(name) {
        None => Some((name, "is missing")),
        Some(sha256) if sha256 != was => Some((name, "is not as it was written: its SHA-256 differs")),
        Some(_) => None,
    });
    let going_on = sessions_that_go_on(root)?;
    let goes_on = |name: &&String| of_subject(name).is_some_and(|subject| going_on.contains(subject));
    let unlisted = there.iter().filter(|name| !list.contains_key(*name) && !goes_on(name) && !is_beside(name));
    let unlisted = unlisted.map(|name| (name, "is not in SHA256SUMS: the file was added, or removed from the list"));
    let found = listed.chain(unlisted).map(|(name, what)| AlteredFile { file: name.clone(), what: what.into() });
    Ok(found.collect())
}

/// Returns true if a file of a data set is on the list with its present SHA-256.
///
/// # Errors
/// The list or the file cannot be read.
pub fn lists(root: &Path, file: &Path) -> Result<bool, SessionError> {
    let Ok(within) = file.strip_prefix(root) else { return Ok(false) };
    let name = within.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/");
    let list = read(root)?.unwrap_or_default();
    Ok(list.get(&name) == Some(&record::file_sha256(file)?))
}

/// Returns the participants whose session is not over; their files are not listed yet.
fn sessions_that_go_on(root: &Path) -> Result<BTreeSet<String>, RecordError> {
    let mut folders = record::entries(&root.join("sourcedata"))?;
    folders.retain(|folder| SessionLog::load(&folder.join(session_log::FILE)).is_ok_and(|log| log.end.is_none()));
    let name = |folder: &PathBuf| folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(folders.iter().map(name).collect())
}

/// Returns true for files that belong to no list: signatures, files that operating systems create, and recordings by `codrive replay
/// --what-if`.
fn is_beside(name: &str) -> bool {
    let last = name.rsplit('/').next().unwrap_or(name);
    let is_signature = last.ends_with(&format!(".{SIGNATURE}"));
    is_signature || OF_SYSTEMS.contains(&last) || name.split('/').any(|part| part.contains(WHAT_IF))
}

/// Returns the participant that a file belongs to.
fn of_subject(name: &str) -> Option<&str> {
    name.split('/').find(|part| part.starts_with("sub-")).filter(|_| name.contains('/'))
}

fn is_published_anew(name: &str) -> bool {
    let begins = ["participants.", "phenotype/", "erased.", ".bidsignore", event_table::SIDECAR, motion::CHANNELS_JSON];
    begins.iter().any(|begin| name.starts_with(begin))
}

fn read(root: &Path) -> Result<Option<ChecksumList>, SessionError> {
    let path = root.join(FILE);
    let text = match read_text(&path, MOST_BYTES) {
        Ok(text) => text,
        Err(why) if why.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(why) => return Err(RecordError::File { path, why }.into()),
    };
    let line = |(i, line): (usize, &str)| match line.split_once("  ") {
        Some((sha256, name)) if sha256.len() == 64 => Ok((name.to_owned(), sha256.to_owned())),
        _ => Err(SessionError::Refused(format!(
            "{}, line {}: allowed is SHA-256, two spaces, name",
            path.display(),
            i + 1
        ))),
    };
    text.lines().enumerate().map(line).collect::<Result<_, _>>().map(Some)
}

/// Returns the names of all data files relative to the data set, sorted.
pub(super) fn files(root: &Path) -> Result<Vec<String>, SessionError> {
    let mut found = Vec::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        let path = root.join(&folder);
        let entries = fs::read_dir(&path).and_then(Iterator::collect::<std::io::Result<Vec<_>>>);
        for entry in entries.map_err(|why| RecordError::File { path: path.clone(), why })? {
            let name = folder.join(entry.file_name());
            let kind = entry.file_type().map_err(|why| RecordError::File { path: entry.path(), why })?;
            let text = name.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/");
            let is_skipped = [LOCK, FILE, CHANGED, ERASURE].iter().any(|skipped| entry.file_name() == *skipped)
                || name.extension().is_some_and(|ending| ending == record::BESIDE)
                || MADE_AGAIN.iter().any(|folder| entry.file_name() == *folder);
            match kind {
                _ if is_skipped => {}
                kind if kind.is_dir() => folders.push(name),
                kind if kind.is_file() => found.push(text),
                _ => {}
            }
        }
    }
    found.sort();
    Ok(found)
}

fn sums(root: &Path, files: Vec<String>) -> Result<ChecksumList, SessionError> {
    let sum = |name: String| Ok((name.clone(), record::file_sha256(&root.join(&name))?));
    files.into_par_iter().map(sum).collect::<Result<_, RecordError>>().map_err(Into::into)
}

#[cfg(test)]
#[path = "checksums_tests.rs"]
mod tests;
