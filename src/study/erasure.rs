//! Takes everything of one participant out of a data set, for good. In: a data set, a code, a reason. Out: no file and no row of
//! the participant, in raw data, tables and what was derived from them; one line in `erased.tsv`: code, reason, when.
//!
//! `erasure.json` stands in the data set from the first step to the last. Every step can be done twice, so that a cut costs nothing:
//! whoever opens the data set next finishes what was begun.

use super::{
    DataSet, ParticipantCode, SessionError,
    bids::{TsvColumn, TsvTable},
    checksums, inherited, lock, mentions,
};
use crate::{
    file::{SETTINGS_BYTES, read_text},
    record::{self, RecordError},
    toml_text::did_you_mean,
};
use serde::{Deserialize, Serialize};
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// Who was erased, when and why; the name without its ending.
pub const LEDGER: &str = "erased";
/// What is being erased.
const BEGUN: &str = "erasure.json";
/// Folders at the top that hold what was made from the data; `codrive analyse` makes it again.
const MADE_AGAIN: [&str; 3] = ["derivatives/codrive", "analysis", "report"];
/// The most that a table may hold, bytes.
pub(super) const TABLE_BYTES: u64 = 64 << 20;

/// An erasure that has begun.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Erasure {
    participant: ParticipantCode,
    reason: String,
    /// When it was asked for, UTC.
    at: String,
}

/// One who was erased.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ErasedParticipant {
    /// The code, without `sub-`.
    pub code: String,
    /// Why, in the words of who erased.
    pub reason: String,
    /// When, UTC.
    pub at: String,
}

/// Parts that an erasure cannot take away.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftBehind {
    /// Files outside `derivatives/` that name the participant, written by people.
    pub naming: Vec<PathBuf>,
    /// Folders of other programs' results, which may be computed with the participant's data.
    pub others: Vec<PathBuf>,
}

type Step = fn(&Erasure, &Path) -> Result<(), SessionError>;

/// What is done in this order. The mark that it has begun goes last.
const STEPS: [Step; 6] =
    [Erasure::remove_data, Erasure::remove_derived, Erasure::remove_rows, Erasure::note, Erasure::list, Erasure::end];

impl DataSet {
    /// Erases a participant: recordings, answers, log, rows of every table, and all results that were made with them. `now` is the
    /// time, UTC. Those whose data were copied elsewhere are not found. Returns what may still hold something of the participant.
    ///
    /// # Errors
    /// There is no such participant, or the session is being run; the disk refuses, and the next start goes on.
    pub fn erase(&self, code: &ParticipantCode, reason: &str, now: &str) -> Result<LeftBehind, SessionError> {
        self.check_known(code)?;
        let folder = self.source(code);
        // Held until all is gone. A folder without a session has no other program either.
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

    /// Refuses a code that has no data here; says which there are, and who was erased.
    pub(super) fn check_known(&self, code: &ParticipantCode) -> Result<(), SessionError> {
        let known = self.codes()?;
        if known.contains(code) {
            return Ok(());
        }
        if let Some(was) = erased(self.root())?.into_iter().find(|was| was.code == code.as_str()) {
            return Err(SessionError::Refused(format!(
                "participant {code} was erased ({}, {}); nothing of them is left",
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

/// Finishes an erasure in this data set that was cut, if there is one.
///
/// # Errors
/// The mark of it cannot be read, or the disk refuses.
pub fn finish(root: &Path) -> Result<(), SessionError> {
    let path = root.join(BEGUN);
    let text = match read_text(&path, SETTINGS_BYTES) {
        Ok(text) => text,
        Err(why) if why.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(why) => return Err(RecordError::File { path, why }.into()),
    };
    let erasure: Erasure = serde_json::from_str(&text).map_err(|why| {
        let path = path.display();
        SessionError::Refused(format!("{path}: is no erasure of this program: {why}; delete it, and erase again"))
    })?;
    // Nobody publishes tables meanwhile.
    let path = root.join("sourcedata").join(lock::FILE);
    record::new_private_dir(&root.join("sourcedata"))?;
    let lock = lock::lock_file(&path)?;
    lock.lock().map_err(|why| RecordError::File { path, why })?;
    STEPS.iter().try_for_each(|step| step(&erasure, root))
}

/// The same for the data set that a folder is of or in: itself, a participant's, a recording's.
///
/// # Errors
/// As [`finish`].
pub fn finish_around(folder: &Path) -> Result<(), SessionError> {
    let whole = std::path::absolute(folder).map_err(|why| RecordError::File { path: folder.into(), why })?;
    whole.ancestors().filter(|root| root.join(BEGUN).is_file()).try_for_each(finish)
}

/// Who was erased from this data set, in the order of time.
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

    /// Means and figures have the participant in them: all results of this program go. Those of other programs, which it cannot make
    /// again, lose what names the participant.
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
        // What a cut left of a table that was being written.
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
            TsvColumn::new("reason", "why, in the words of who erased them", ""),
            TsvColumn::new("erased_at", "when, UTC", ""),
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

/// Files of an erasure, which BIDS does not know.
pub(super) const BIDSIGNORE: &str = "erased.tsv\nerased.json\nerasure.json\n";

/// Tables with a row for each participant: `participants.tsv`, `phenotype/*.tsv`.
///
/// # Errors
/// The disk does not say which there are.
pub(super) fn tables(root: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let mut tables = record::entries(&root.join("phenotype"))?;
    tables.retain(|path| path.extension().is_some_and(|e| e == "tsv"));
    tables.sort();
    tables.insert(0, root.join("participants.tsv"));
    tables.retain(|path| path.is_file());
    Ok(tables)
}

/// A table without the rows of one participant.
fn other_rows(text: &str, subject: &str) -> String {
    text.lines().filter(|line| line.split('\t').next() != Some(subject)).map(|line| format!("{line}\n")).collect()
}

/// Removes a file or a whole folder, if it is there.
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
