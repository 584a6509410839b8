//! The list of a participant's files, `sub-CODE_scans.tsv`: drives and answers, with their conditions and start times. In: completed
//! items. Out: rows with dates shifted by a number of days of the participant's own.
//!
//! Session dates reveal where a person was on which day, so the tables have shifted dates, as BIDS advises. All times of a participant
//! are moved by the same whole number of days, drawn once, to the years 1902 to 1920. Intervals keep their length to the second. The time
//! of day, on which drowsiness depends, also stays. The number of days lies with the raw data, whose log has the true times. A reader of
//! the tables alone therefore cannot undo the shift, a new publication has the same dates, and erasing the participant removes the
//! number.

use super::{
    PlannedItem, SessionError, Study, answer_tables,
    bids::{TsvColumn, TsvTable},
    session_log::SessionLog,
};
use crate::{
    file::{SETTINGS_BYTES, read_text},
    record::{self, RecordError, inputs},
};
use jiff::{SignedDuration, Timestamp, civil::date, tz::TimeZone};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::{
    collections::BTreeMap,
    hash::{BuildHasher, Hasher, RandomState},
    io,
    path::Path,
};

/// File with the shift, beside the session file.
pub(super) const SHIFT_FILE: &str = "date-shift.json";

/// Columns that follow from a drive's place in the plan.
pub(super) const OF_DRIVE: [&str; 5] = ["segment", "place", "condition", "seed", "baseline"];

/// Number of days by which a participant's dates are moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DateShift {
    days: i64,
}

impl DateShift {
    /// Returns the shift of the participant whose raw data are in `folder`: the stored one, or one that is drawn now and stored. `None`
    /// while the log has no time.
    ///
    /// # Errors
    /// The file cannot be read or written.
    pub fn of(folder: &Path, log: &SessionLog) -> Result<Option<Self>, SessionError> {
        let path = folder.join(SHIFT_FILE);
        match read_text(&path, SETTINGS_BYTES) {
            Ok(text) => {
                return serde_json::from_str(&text).map(Some).map_err(|why| {
                    let path = path.display();
                    SessionError::Refused(format!(
                        "{path}: allowed is {{\"days\": -37000}}, the days by which dates are moved: {why}\n  remedy: \
                         restore a copy of the file, or delete it; new dates are then drawn"
                    ))
                });
            }
            Err(why) if why.kind() == io::ErrorKind::NotFound => {}
            Err(why) => return Err(RecordError::File { path, why }.into()),
        }
        let Some(first) = log.item_runs.iter().find_map(|item_run| item_run.began.parse().ok()) else {
            return Ok(None);
        };
        let Some(shift) = Self::drawn(first, RandomState::new().build_hasher().finish()) else { return Ok(None) };
        let text = serde_json::to_string(&shift).expect("a number");
        record::replace(&path, (text + "\n").as_bytes())?;
        Ok(Some(shift))
    }

    /// Returns a shift that moves `first` to a day of the years 1902 to 1920, each equally likely by `random`. BIDS marks shifted dates
    /// by years up to 1925, and a session that continues years later stays below. Programs that count seconds in 32 bits begin in 1901.
    fn drawn(first: Timestamp, random: u64) -> Option<Self> {
        let (begin, end) = (date(1902, 1, 1), date(1921, 1, 1));
        let days = |until: jiff::civil::Date| begin.until(until).map(|span| i64::from(span.get_days()));
        let count = days(end).ok()?;
        // The modulo bias over 6940 days is below one part in 10^15.
        let day = i64::try_from(random % u64::try_from(count).ok()?).ok()?;
        let now = days(first.to_zoned(TimeZone::UTC).date()).ok()?;
        Some(Self { days: day - now })
    }

    /// Returns a time, UTC, on its shifted day; empty if `at` is not a time.
    pub fn shifted(self, at: &str) -> String {
        let moved =
            at.parse::<Timestamp>().ok().and_then(|at| at.checked_add(SignedDuration::from_hours(24 * self.days)).ok());
        moved.map_or(String::new(), |at| at.strftime("%Y-%m-%dT%H:%M:%SZ").to_string())
    }
}

/// A file of a participant.
pub(super) struct ScannedFile<'a> {
    /// Name relative to the participant's folder.
    pub name: String,
    /// Time at which the file was begun, UTC.
    pub began: &'a str,
    /// Item of the plan that the file belongs to.
    pub planned: &'a PlannedItem,
    /// Data of a drive; `None` for answers.
    pub drive: Option<ScannedDrive<'a>>,
}

/// Columns that only a drive has.
pub(super) struct ScannedDrive<'a> {
    /// Level of each factor.
    pub levels: &'a BTreeMap<String, String>,
    /// Seed of all random streams of the drive.
    pub seed: u64,
    /// Folder of the recording, relative to the data set.
    pub recording: String,
    /// Folder of the baseline; empty if there is none.
    pub baseline: String,
}

/// Returns the row of a file.
pub(super) fn row(study: &Study, file: ScannedFile<'_>, shift: Option<DateShift>) -> Vec<String> {
    let planned = file.planned;
    let at = shift.map_or(String::new(), |shift| shift.shifted(file.began));
    let place = planned.run.map_or(String::new(), |run| run.to_string());
    let mut row = vec![file.name, at, planned.segment.clone(), place, planned.condition.clone().unwrap_or_default()];
    let level = |factor: &String| file.drive.as_ref().and_then(|drive| drive.levels.get(factor).cloned());
    row.extend(study.file.factors.keys().map(|factor| level(factor).unwrap_or_default()));
    let of_drive = file.drive.map(|drive| [drive.seed.to_string(), drive.recording, drive.baseline]);
    row.extend(of_drive.unwrap_or_default());
    row
}

/// Returns the table without rows.
pub(super) fn table(study: &Study) -> TsvTable {
    let mut columns = vec![
        TsvColumn::new("filename", "motion of a drive, or answers", ""),
        TsvColumn::new(
            "acq_time",
            "start of the recording or display of the first page, UTC. All dates of a participant are moved by the \
             same number of days to years before 1925; intervals are unchanged",
            "",
        ),
        TsvColumn::new("segment", "segment of the study", ""),
        answer_tables::place(),
        answer_tables::condition(study),
    ];
    for (factor, levels) in &study.file.factors {
        let words = levels.iter().map(|level| {
            let word = |value: &Value| match value {
                Value::String(text) => format!("\"{}\"", inputs::last(text)),
                other => other.to_string(),
            };
            let set: Vec<String> = level.set.iter().map(|(key, value)| format!("{key} = {}", word(value))).collect();
            (level.name.clone(), if set.is_empty() { "as in the base of the study".into() } else { set.join(", ") })
        });
        columns.push(TsvColumn::new(factor, &format!("level of the factor {factor}"), "").with(words));
    }
    columns.extend([
        TsvColumn::new("seed", "seed of everything random in the drive", ""),
        TsvColumn::new("recording", "folder of the recording; n/a for answers", ""),
        TsvColumn::new("baseline", "folder of the recording of the same drive without advice", ""),
    ]);
    TsvTable::new(columns)
}

#[cfg(test)]
#[path = "scans_tests.rs"]
mod tests;
