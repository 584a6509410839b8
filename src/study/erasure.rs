//! Erasure of one participant from a data set, for good. In: a data set, a code, a reason. Out: no file and no row of the participant
//! remains in raw data, tables or derived results; one line in `erased.tsv` has code, reason and time.
//!
//! `erasure.json` marks an erasure in progress, from the first step to the last. Every step can be repeated, so the next program that
//! opens the data set can finish an interrupted erasure.

use super::{
    DataSet, ParticipantCode, SessionError,
    bids::{TABLE_BYTES, TsvColumn, TsvTable},
    checksums, inherited, lock, mentions,
};
use crate::{
    file::{SETTINGS_BYTES, read_text},
    private,
    record::{self, RecordError},
    toml_text::did_you_mean,
};
use serde::{Deserialize, Serialize};
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// List of erased participants with reason and time; file name without extension.
pub const LEDGER: &str = "erased";
/// File that marks an erasure in progress.
const BEGUN: &str = "erasure.json";
/// Folders at the top with results that `codrive analyse` can make again.
const MADE_AGAIN: [&str; 3] = ["derivatives/codrive", "analysis", "report"];

/// An erasure in progress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Erasure {
    participant: ParticipantCode,
    reason: String,
    /// Time of the request, UTC.
    at: String,
}

/// A participant whose data were erased.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ErasedParticipant {
    /// Code, without `sub-`.
    pub code: String,
    /// Reason, as written by the person who erased the data.
    pub reason: String,
    /// Time of the erasure, UTC.
    pub at: String,
}

/// Data that an erasure cannot remove.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftBehind {
    /// Files outside `derivatives/` that name the participant, written by people.
    pub naming: Vec<PathBuf>,
    /// Folders of other programs' results, which may be computed from the participant's data.
    pub others: Vec<PathBuf>,
}

type Step = fn(&Erasure, &Path) -> Result<(), SessionError>;

/// Steps of an erasure, in order. The mark of the erasure in progress is removed last.
const STEPS: [Step; 6] =
    [Erasure::remove_data, Erasure::remove_derived, Erasure::remove_rows, Erasure::note, Erasure::list, Erasure::end];

impl DataSet {
    /// Erases a participant: recordings, answers, log, rows of every table, and all results computed from them. `now` is the time, UTC.
    /// Copies of the data elsewhere are not found. Returns files and folders that may still hold data of the participant.
    ///
    /// # Errors
    /// There is no such participant, the session is running, or a file cannot be removed; in the last case the next start continues.
    pub fn erase(&self, code: &ParticipantCode, reason: &str, now: &str) -> Result<LeftBehind, SessionError> {
        self.check_known(code)?;
        let folder = self.source(code);
        // Held until all data are removed. Without a session folder, no other program can hold the lock.
        let _lock = folder.is_dir().then(|| lock::lock(&folder, code)).transpose()?;
        let erasure = Erasure { participant: code.clone(), reason: reason.into(), at: now.into() };
        let text = serde_json::to_string_pretty(&erasure).expect("words");
        record::replace(&self.root().join(BEGUN), (text + "\n").as_bytes())?;
        finish(self.root())?;
        let mut others = record::entries(&self.root().join("derivatives"))?;
        others.retain(|path| path.is_dir());
        others.sort();
        Ok(LeftBehind { naming: mentions::files(self.root(), code)?, others })
    }

    /// Refuses a code without data here; the message lists the known codes, or says that the participant was erased.
    pub(super) fn check_known(&self, code: &ParticipantCode) -> Result<(), SessionError> {
        let known = self.codes()?;
        if known.contains(code) {
            return Ok(());
        }
        if let Some(was) = erased(self.root())?.into_iter().find(|was| was.code == code.as_str()) {
            return Err(SessionError::Refused(format!(
                "participant {code} was erased ({}, {}); no data of them are left",
                was.reason, was.at
            )));
        }
        let codes: Vec<&str> = known.iter().map(ParticipantCode::as_str).collect();
        let there = if codes.is_empty() { "none".into() } else { codes.join(", ") };
        Err(SessionError::Refused(format!(
            "there is no participant {code} in {}{}; there are: {there}",
            self.root().display(),
            did_you_mean(code.as_str(), &codes)
        )))
    }
}

/// Finishes an interrupted erasure in this data set, if there is one.
///
/// # Errors
/// The mark of the erasure cannot be read, or a file cannot be read, written or removed.
pub fn finish(root: &Path) -> Result<(), SessionError> {
    let path = root.join(BEGUN);
    let text = match read_text(&path, SETTINGS_BYTES) {
        Ok(text) => text,
        Err(why) if why.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(why) => return Err(RecordError::File { path, why }.into()),
    };
    let erasure: Erasure = serde_json::from_str(&text).map_err(|why| {
        let path = path.display();
        SessionError::Refused(format!(
            "{path}: not an erasure record of this program: {why}; delete it, and erase again"
        ))
    })?;
    // The lock keeps other programs from publishing tables during the erasure.
    let path = root.join("sourcedata").join(lock::FILE);
    for name in ["phenotype", "derivatives", "derivatives/codrive"] {
        let path = root.join(name);
        private::check_way(root, &path).map_err(|why| RecordError::File { path, why })?;
    }
    record::new_dir_within(root, &root.join("sourcedata"))?;
    let lock = lock::lock_file(&path)?;
    lock.lock().map_err(|why| RecordError::File { path, why })?;
    STEPS.iter().try_for_each(|step| step(&erasure, root))
}

/// Finishes an interrupted erasure in the data set that contains `folder`: its own folder, a participant's or a recording's.
///
/// # Errors
/// As [`finish`].
pub fn finish_around(folder: &Path) -> Result<(), SessionError> {
    let whole = std::path::absolute(folder).map_err(|why| RecordError::File { path: folder.into(), why })?;
    whole.ancestors().filter(|root| root.join(BEGUN).is_file()).try_for_each(finish)
}

/// Returns the participants erased from this data set, in the order of time.
///
/// # Errors
/// The list cannot be read.
pub fn erased(root: &Path) -> Result<Vec<ErasedParticipant>, SessionError> {
    let path = root.join(LEDGER).with_extension("tsv");
    let text = match read_text(&path, TABLE_BYTES) {
        Ok(text) => text,
        Err(why) if why.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(why) => return Err(RecordError::File { path, why }.into()),
    };
    let line = |(i, line): (usize, &str)| match line.split('\t').collect::<Vec<_>>()[..] {
        [id, reason, at] => {
            let code = id.strip_prefix("sub-").unwrap_or(id).into();
            Ok(ErasedParticipant { code, reason: reason.into(), at: at.into() })
        }
        _ => Err(SessionError::Refused(format!(
            "{}, line {}: allowed are three cells: participant_id, reason, erased_at",
            path.display(),
            i + 2
        ))),
    };
    text.lines().skip(1).enumerate().map(line).collect()
}

impl Erasure {
    fn remove_data(&self, root: &Path) -> Result<(), SessionError> {
        let subject = self.participant.subject();
        remove(&root.join("sourcedata").join(&subject))?;
        remove(&root.join(subject))
    }

    /// Removes all results of this program, because means and figures include the participant. From results of other programs, which this
    /// program cannot make again, only the parts that name the participant go.
    fn remove_derived(&self, root: &Path) -> Result<(), SessionError> {
        MADE_AGAIN.iter().try_for_each(|name| remove(&root.join(name)))?;
        mentions::remove_from_derived(root, &self.participant)
    }

    fn remove_rows(&self, root: &Path) -> Result<(), SessionError> {
        for path in tables(root)? {
            let text = read_text(&path, TABLE_BYTES).map_err(|why| RecordError::File { path: path.clone(), why })?;
            let kept = other_rows(&text, &self.participant.subject());
            if kept != text {
                record::replace(&path, kept.as_bytes())?;
            }
        }
        // Removes temporary files of tables whose writing was interrupted.
        for folder in [root.to_owned(), root.join("phenotype")] {
            let mut begun = record::entries(&folder)?;
            begun.retain(|path| path.extension().is_some_and(|e| e == record::BESIDE));
            begun.into_iter().try_for_each(|path| remove(&path))?;
        }
        inherited::settle(root)
    }

    fn note(&self, root: &Path) -> Result<(), SessionError> {
        let mut table = TsvTable::new(vec![
            TsvColumn::new("participant_id", "code of a participant whose data were erased", ""),
            TsvColumn::new("reason", "reason, as written by the person who erased them", ""),
            TsvColumn::new("erased_at", "time of the erasure, UTC", ""),
        ]);
        let before = erased(root)?;
        table.rows =
            before.iter().map(|was| vec![format!("sub-{}", was.code), was.reason.clone(), was.at.clone()]).collect();
        let own = vec![self.participant.subject(), self.reason.clone(), self.at.clone()];
        if !table.rows.iter().any(|row| row[0] == own[0] && row[2] == own[2]) {
            table.rows.push(own);
        }
        let put = |name: PathBuf, text: String| record::replace(&root.join(name), text.as_bytes());
        put(Path::new(LEDGER).with_extension("json"), table.sidecar(serde_json::Value::Null))?;
        put(Path::new(LEDGER).with_extension("tsv"), table.text())?;

        Ok(())
    }

    fn list(&self, root: &Path) -> Result<(), SessionError> {
        checksums::list(root, &self.participant.subject(), false)
    }

    fn end(&self, root: &Path) -> Result<(), SessionError> {
        remove(&root.join(BEGUN))
    }
}

/// Files of an erasure, which are not part of BIDS.
pub(super) const BIDSIGNORE: &str = "erased.tsv\nerased.json\nerasure.json\n";

/// Returns the tables with one row per participant: `participants.tsv`, `phenotype/*.tsv`.
///
/// # Errors
/// The folder of the tables cannot be listed.
pub(super) fn tables(root: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let mut tables = record::entries(&root.join("phenotype"))?;
    tables.retain(|path| path.extension().is_some_and(|e| e == "tsv"));
    tables.sort();
    tables.insert(0, root.join("participants.tsv"));
    tables.retain(|path| path.is_file());
    Ok(tables)
}

/// Returns a table without the rows of one participant.
fn other_rows(text: &str, subject: &str) -> String {
    text.lines().filter(|line| line.split('\t').next() != Some(subject)).map(|line| format!("{line}\n")).collect()
}

/// Removes a file or a whole folder, if it exists.
fn remove(path: &Path) -> Result<(), SessionError> {
    let removed = match fs::symlink_metadata(path) {
        Ok(there) if there.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
        Err(why) => Err(why),
    };
    match removed {
        Err(why) if why.kind() != io::ErrorKind::NotFound => Err(RecordError::File { path: path.into(), why }.into()),
        _ => Ok(()),
    }
}

#[cfg(test)]
#[path = "erasure_tests.rs"]
mod tests;
