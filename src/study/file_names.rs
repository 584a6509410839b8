//! Names of a participant's files in a data set, by BIDS. In: the participant's folder and an item of their plan. Out: the task's name, and
//! the stems of the names of files.

use super::{PlannedItem, bids, motion};

/// Suffix of the folder of a drive's baseline.
pub const BASELINE: &str = "-baseline";
/// Suffix of that folder until the baseline is complete.
pub const BASELINE_PART: &str = "-baseline-part";

/// Returns the BIDS task name: `trial`, and `trialTrust` for the questionnaire after it.
pub fn task(planned: &PlannedItem) -> String {
    match &planned.after {
        Some(after) => bids::label(&format!("{}-{}", planned.segment, after.questionnaire)),
        None => bids::label(&planned.segment),
    }
}

/// Returns the stem of a file name in `beh`: `sub-P03_task-trial_run-2`.
pub fn file_name(subject: &str, planned: &PlannedItem) -> String {
    let run = planned.run.map_or(String::new(), |run| format!("_run-{run}"));
    format!("{subject}_task-{}{run}", task(planned))
}

/// Returns the stem of a file name in `motion`: `sub-P03_task-trial_tracksys-codrive_run-2`.
pub fn motion_name(subject: &str, planned: &PlannedItem) -> String {
    let run = planned.run.map_or(String::new(), |run| format!("_run-{run}"));
    format!("{subject}_task-{}_tracksys-{}{run}", task(planned), motion::TRACKING_SYSTEM)
}
