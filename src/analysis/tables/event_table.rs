//! Table of responses to the events of scenarios. In: analysed drives. Out: `events.csv`, a row for each time that an event was seen, with its columns.

use super::key::{key, key_columns};
use crate::{
    analysis::{
        columns::{ColumnTexts, TableColumns, cell, columns, line},
        drives::AnalysedRecording,
    },
    time::Tick,
};

/// Name of the table.
pub const EVENTS_FILE: &str = "events.csv";

const EVENTS: [ColumnTexts; 15] = [
    ("event", "Event", "", "name of the event in the scenario"),
    ("vehicle", "Vehicle", "", "number of the vehicle that acted; empty without one"),
    (
        "onset_s",
        "Onset",
        "s",
        "time from the start of the drive to the first frame that showed an action of the event, or to the first action without a screen",
    ),
    (
        "watched_s",
        "Time watched",
        "s",
        "time from the onset to 5 s after the event's end, to the next event or to the end of the drive; all times and extremes are of this time",
    ),
    ("speed_mps", "Speed at the onset", "m/s", "speed of the ego vehicle at the onset"),
    (
        "response_s",
        "Perception-response time",
        "s",
        "time from the onset to the first movement of accelerator, brake or steering wheel (SAE J2944); empty without one",
    ),
    (
        "release_s",
        "Accelerator release time",
        "s",
        "time from the onset to an accelerator below 2 % of its travel; empty if it was not pressed at the onset or not released",
    ),
    (
        "brake_s",
        "Brake response time",
        "s",
        "time from the onset to a brake beyond 2 % of its travel; empty if it was pressed at the onset or never",
    ),
    (
        "steering_s",
        "Time to first steering",
        "s",
        "time from the onset to a steering wheel 2 degrees away from its angle at the onset; empty without it",
    ),
    ("min_gap_m", "Minimum gap", "m", "least gap to the leader, bumper to bumper"),
    (
        "min_ttc_s",
        "Minimum time to collision",
        "s",
        "least time to collision with the leader; empty if the gap never closed",
    ),
    ("max_decel_mps2", "Maximum deceleration", "m/s2", "largest deceleration of the ego vehicle"),
    (
        "sdlp_m",
        "Standard deviation of the lane position",
        "m",
        "standard deviation of the lateral offset of the ego vehicle from the middle of its lane",
    ),
    ("contact", "Contact", "", "true if the ego vehicle touched another vehicle"),
    (
        "contact_mps",
        "Closing speed of the contact",
        "m/s",
        "closing speed of the first contact with another vehicle; empty without one",
    ),
];

/// Returns the columns of `events.csv`.
pub(crate) fn event_columns(drives: &[AnalysedRecording]) -> TableColumns {
    let columns = key_columns(drives).into_iter().chain(columns(&EVENTS)).collect();
    TableColumns { file: EVENTS_FILE, row: "an event of the scenario each time that it was seen", columns }
}

/// Checks whether an event of a scenario was seen in any of these drives; the table is left out where none was.
pub fn have_events(drives: &[AnalysedRecording]) -> bool {
    drives.iter().any(|drive| !drive.scripted_responses.is_empty())
}

/// Returns `events.csv`.
pub fn events(drives: &[AnalysedRecording]) -> String {
    let mut text = event_columns(drives).head();
    for drive in drives {
        for response in &drive.scripted_responses {
            let own = [
                response.moment.name.clone(),
                response.moment.vehicle.map_or(String::new(), |vehicle| vehicle.to_string()),
                cell(Some(Tick(response.moment.onset).seconds())),
                cell(Some(response.watched_s)),
                cell(Some(response.speed_mps)),
                cell(response.perception_response_s()),
                cell(response.release_s),
                cell(response.brake_s),
                cell(response.steering_s),
                cell(response.min_gap_m),
                cell(response.min_ttc_s),
                cell(Some(response.max_decel_mps2)),
                cell(Some(response.sdlp_m)),
                response.contact_mps.is_some().to_string(),
                cell(response.contact_mps),
            ];
            text += &line(key(drive).into_iter().chain(own));
        }
    }
    text
}
