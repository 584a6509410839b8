//! Ends of the sessions of a study. In: the logs of the sessions (`sourcedata/*/session.json`) and `erased.tsv` of a data set. Out: the
//! reasons of each end and exclusion, and the number of participants whose data were erased.

use super::tsv::TsvFile;
use crate::analysis::error::AnalysisError;
use crate::file::{SETTINGS_BYTES, read_text};
use serde_json::Value;
use std::path::Path;

/// Reasons of the end of a session and of an exclusion, as the experimenter or a rule of the study gave them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EndReasons {
    /// Reason why the session ended before the end of its plan; empty if it did not.
    pub end: String,
    /// True if a limit on a score ended the session, such as that on ratings of sickness.
    pub is_by_limit: bool,
    /// True if the session is not over, and the program or the computer failed in its last item.
    pub is_cut: bool,
    /// Reason why the experimenter excluded the data; `None` if they are not excluded.
    pub excluded: Option<String>,
}

impl EndReasons {
    /// Reads the reasons from a participant's log; a log that cannot be read has none.
    pub(super) fn of(root: &Path, subject: &str) -> Self {
        let text = read_text(&root.join("sourcedata").join(subject).join("session.json"), SETTINGS_BYTES);
        let log: Value = text.ok().and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default();
        let end = &log["end"];
        let last = log["item_runs"].as_array().and_then(|runs| runs.last());
        let is_cut = end.is_null() && (log["running"].is_object() || last.is_some_and(|last| last["outcome"] == "cut"));
        Self {
            is_cut,
            end: end["reason"].as_str().unwrap_or_default().to_owned(),
            is_by_limit: end["cause"] == "score_limit",
            excluded: end["excluded"].as_str().map(str::to_owned),
        }
    }
}

/// Returns the number of participants whose data were erased from a data set.
pub(super) fn erased(root: &Path) -> Result<usize, AnalysisError> {
    Ok(TsvFile::read(&root.join("erased.tsv"))?.map_or(0, |table| table.rows.len()))
}
