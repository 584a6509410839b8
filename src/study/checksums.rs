//! The list of a data set's files with their SHA-256, which reveals later changes of any file. In: the folder of the data set. Out:
//! `SHA256SUMS`, as `sha256sum --check` reads it; and the differences from it.
//!
//! The files of a participant are listed when the session is over. Files published again after every participant (`participants.tsv`,
//! `phenotype/`, `erased.tsv`, the changed plan) get a new entry each time. Figures and tables of an analysis (`derivatives/`) are not listed,
//! as they can be made again, and neither are unfinished baselines. Every other file must be on the list.

use super::{
    ParticipantCode, SessionError, event_table,
    file_names::BASELINE_PART,
    lock, motion,
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
/// Folders that hold no data, at any depth, except beside the recordings of a participant, where items have these names, too.
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
        _ if is_unfinished(name) => false,
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
    let others =
        |name: &String| !name.strip_prefix(folder).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
    edit(root, |list| {
        list.retain(|name, _| others(name));
        Ok(())
    })
}

/// Gives the copy of a changed study file a new entry, or removes its entry with it, if there is a list.
pub(super) fn list_changed_plan(root: &Path) -> Result<(), SessionError> {
    let name = CHANGED.to_owned();
    edit(root, |list| {
        list.remove(&name);
        let is_there = record::is_there(&root.join(&name))?;
        list.extend(sums(root, is_there.then_some(name).into_iter().collect())?);
        Ok(())
    })
}

/// Changes the list, if there is one and it differs afterwards, while no other program publishes a participant.
fn edit(root: &Path, change: impl FnOnce(&mut ChecksumList) -> Result<(), SessionError>) -> Result<(), SessionError> {
    if read(root)?.is_none() {
        return Ok(());
    }
    let path = root.join("sourcedata").join(LOCK);
    let lock = lock::lock_file(&path)?;
    lock.lock().map_err(|why| RecordError::File { path, why })?;
    let was = read(root)?.unwrap_or_default();
    let mut list = was.clone();
    change(&mut list)?;
    if list == was { Ok(()) } else { write(root, &list) }
}

/// Returns those of these participants whose log is not on the list: a program ended between the end of the session and the list.
pub(super) fn unlisted<'a>(
    root: &Path,
    codes: impl Iterator<Item = &'a ParticipantCode>,
) -> Result<Vec<&'a ParticipantCode>, SessionError> {
    let list = read(root)?.unwrap_or_default();
    Ok(codes
        .filter(|code| !list.contains_key(&format!("sourcedata/{}/{}", code.subject(), session_log::FILE)))
        .collect())
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
    let (there, links) = files_and_links(root)?;
    // A file that the disk cannot read is damaged, which must not keep the others from being compared.
    let compared = |(name, was): (&String, &String)| {
        let what = match there.binary_search(name).ok().map(|_| record::file_sha256(&root.join(name))) {
            None => "is missing".into(),
            Some(Err(why)) => format!("cannot be read any more: {why}"),
            Some(Ok(sha256)) if sha256 != *was => "is not as it was written: its SHA-256 differs".into(),
            Some(Ok(_)) => return None,
        };
        Some(AlteredFile { file: name.clone(), what })
    };
    let listed: Vec<(&String, &String)> = list.iter().filter(|(name, _)| !is_unfinished(name)).collect();
    let mut found: Vec<AlteredFile> = listed.into_par_iter().filter_map(compared).collect();
    let open = open_files(root, &list, &there)?;
    let unlisted = there.iter().filter(|name| !list.contains_key(*name) && !open.contains(*name) && !is_beside(name));
    let mut add = |name: &String, what: &str| found.push(AlteredFile { file: name.clone(), what: what.into() });
    unlisted.for_each(|name| add(name, "is not in SHA256SUMS: the file was added, or removed from the list"));
    links
        .iter()
        .for_each(|name| add(name, "is a symbolic link, which SHA256SUMS cannot cover: put the file in its place"));
    Ok(found)
}

/// Returns the parts of a data set that an analysis may use although the list does not cover them: the files of sessions that are not
/// over, named by their participant, and a changed plan that is not listed.
///
/// # Errors
/// A folder or the list cannot be read.
pub fn open_parts(root: &Path) -> Result<BTreeSet<String>, SessionError> {
    let list = read(root)?.unwrap_or_default();
    let open = open_files(root, &list, &files(root)?)?;
    let part = |name: &String| match of_subject(name) {
        Some(subject) => format!("{subject} (the session is not over)"),
        None => name.clone(),
    };
    Ok(open.iter().map(part).collect())
}

/// Returns the unlisted files that are no alarm: those of sessions that are not over, and a changed plan of a version that did not list it.
fn open_files(root: &Path, list: &ChecksumList, there: &[String]) -> Result<BTreeSet<String>, RecordError> {
    let going_on = sessions_that_go_on(root)?;
    let is_open = |name: &&String| {
        let goes_on = of_subject(name).is_some_and(|subject| going_on.contains(subject));
        !list.contains_key(*name) && !is_beside(name) && (goes_on || *name == CHANGED)
    };
    Ok(there.iter().filter(is_open).cloned().collect())
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
    is_signature || OF_SYSTEMS.contains(&last) || recording(name).is_some_and(|recording| recording.contains(WHAT_IF))
}

/// Returns the recording that a file belongs to: the folder beside the log of a participant.
fn recording(name: &str) -> Option<&str> {
    let mut parts = name.strip_prefix("sourcedata/sub-")?.split('/').skip(1);
    let recording = parts.next()?;
    parts.next().is_some().then_some(recording)
}

/// Returns true for files of a baseline that is not finished.
fn is_unfinished(name: &str) -> bool {
    recording(name).is_some_and(|recording| recording.ends_with(BASELINE_PART))
}

/// Returns the participant that a file of a data set belongs to, such as `sub-P03`, or whose folder it is.
pub fn subject(name: &str) -> Option<String> {
    name.split('/').find(|part| part.starts_with("sub-")).map(str::to_owned)
}

/// Returns the participant that a file belongs to.
fn of_subject(name: &str) -> Option<&str> {
    name.split('/').find(|part| part.starts_with("sub-")).filter(|_| name.contains('/'))
}

fn is_published_anew(name: &str) -> bool {
    let begins =
        ["participants.", "phenotype/", "erased.", ".bidsignore", CHANGED, event_table::SIDECAR, motion::CHANNELS_JSON];
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
    Ok(files_and_links(root)?.0)
}

/// Returns the names of all data files, sorted, and those of symbolic links in their places.
fn files_and_links(root: &Path) -> Result<(Vec<String>, Vec<String>), SessionError> {
    let (mut found, mut links) = (Vec::new(), Vec::new());
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        let path = root.join(&folder);
        let entries = fs::read_dir(&path).and_then(Iterator::collect::<std::io::Result<Vec<_>>>);
        for entry in entries.map_err(|why| RecordError::File { path: path.clone(), why })? {
            let name = folder.join(entry.file_name());
            let kind = entry.file_type().map_err(|why| RecordError::File { path: entry.path(), why })?;
            let text = name.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/");
            let is_own = |names: &[&str]| names.iter().any(|own| entry.file_name() == *own);
            let is_item = folder.parent() == Some(Path::new("sourcedata"));
            let is_skipped = if kind.is_dir() {
                is_own(&MADE_AGAIN) && !is_item || is_unfinished(&format!("{text}/"))
            } else {
                is_own(&[LOCK, FILE, ERASURE])
                    || is_own(&MADE_AGAIN)
                    || name.extension().is_some_and(|e| e == record::BESIDE)
            };
            match kind {
                _ if is_skipped => {}
                kind if kind.is_dir() => folders.push(name),
                kind if kind.is_file() => found.push(text),
                kind if kind.is_symlink() => links.push(text),
                _ => {}
            }
        }
    }
    found.sort();
    links.sort();
    Ok((found, links))
}

fn sums(root: &Path, files: Vec<String>) -> Result<ChecksumList, SessionError> {
    let sum = |name: String| Ok((name.clone(), record::file_sha256(&root.join(&name))?));
    files.into_par_iter().map(sum).collect::<Result<_, RecordError>>().map_err(Into::into)
}

#[cfg(test)]
#[path = "checksums_tests.rs"]
mod tests;
