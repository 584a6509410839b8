//! The table of a participant's sickness ratings while driving, for `beh`. In: the log of the session. Out: one row per question, also of
//! drives that were broken off, because a rating that stops a session is its highest.

use super::{
    SessionPlan, Study, answer_tables,
    bids::{self, TsvColumn, TsvTable},
    session_log::{DriveRating, SessionLog},
};

/// Name of the task in BIDS.
pub(super) const TASK: &str = "fmsRatings";
/// Description of the scale, for the sidecar.
pub(super) const ABOUT: &str = "Fast motion sickness scale (Keshavarz and Hecht 2011, Human Factors 53(4), 415-426), asked while driving: \
                                0 no sickness at all to 20 frank sickness";

/// Returns the table of one participant's ratings.
pub(super) fn table(study: &Study, plan: &SessionPlan, log: &SessionLog) -> TsvTable {
    let mut table = TsvTable::new(vec![
        TsvColumn::new("recording", "folder of the recording in sourcedata; a repeated drive has several", ""),
        TsvColumn::new("segment", "segment of the study", ""),
        answer_tables::place(),
        answer_tables::condition(study),
        TsvColumn::new("onset", "time of the question, simulation time since the start of the drive", "s"),
        TsvColumn::new("value", "rating, 0 to 20; n/a without a rating within 15 s", ""),
        TsvColumn::new("response_time", "time from the question to the answer", "s"),
    ]);
    let row = |rated: &DriveRating| {
        let planned = plan.items.iter().find(|planned| planned.name == rated.item)?;
        let DriveRating { recording, rating, .. } = rated;
        Some(vec![
            recording.clone(),
            planned.segment.clone(),
            planned.run.map_or(String::new(), |run| run.to_string()),
            planned.condition.clone().unwrap_or_default(),
            bids::number(Some(rating.time_s)),
            bids::number(rating.value.map(f64::from)),
            bids::number(rating.answer_s),
        ])
    };
    table.rows = log.fms.iter().filter_map(row).collect();
    table
}
