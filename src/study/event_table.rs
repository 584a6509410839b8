//! Advice and events of a drive as a BIDS table (`_events.tsv`), and the meaning of its columns and words as text and as HED tags
//! (Hierarchical Event Descriptors, schema 8.4.0). In: a recording. Out: rows; the sidecar at the top of a data set, which all tables of
//! events inherit.

use super::{
    bids::{TsvColumn, TsvTable, number},
    skills,
};
use crate::record::{RecordError, Table as Recorded, TableReader};
use serde_json::{Value, json};
use std::path::Path;

/// Version of the HED schema that the tags use.
pub const HED_VERSION: &str = "8.4.0";

/// Sidecar of all tables of events, at the top of a data set.
pub(super) const SIDECAR: &str = "events.json";

/// Events of a drive: word, meaning, tags.
const WORDS: [[&str; 3]; 69] = [
    [
        "advice",
        "a new target appears on the speedometer",
        "Sensory-event, Experimental-stimulus, Cue, Visual-presentation, Computer-screen, Label/Advice",
    ],
    [
        "advice_withheld",
        "the target disappears: from now on the policy advises nothing",
        "Sensory-event, Experimental-stimulus, Visual-presentation, Computer-screen, Label/Advice-withheld",
    ],
    [
        "contact",
        "the participant's vehicle began to touch another vehicle or a person",
        "Agent-action, Inappropriate-action, (Experiment-participant, Collide-with), Label/Contact",
    ],
    [
        "object_contact",
        "the participant's vehicle began to touch a fixed object beside the road",
        "Agent-action, Inappropriate-action, (Experiment-participant, (Collide-with, Object)), Label/Object-contact",
    ],
    [
        "left_road",
        "the middle of the participant's vehicle left its lane",
        "Agent-action, Inappropriate-action, (Experiment-participant, (Operate, Car)), Label/Left-road",
    ],
    [
        "back_on_road",
        "the middle of the participant's vehicle returned to the lane",
        "Agent-action, Correction, (Experiment-participant, (Operate, Car)), Label/Back-on-road",
    ],
    [
        "left_path",
        "the participant's vehicle has been on another street than the one of its path for a second",
        "Agent-action, Inappropriate-action, (Experiment-participant, (Operate, Car)), Label/Left-path",
    ],
    [
        "back_on_path",
        "the participant's vehicle is on a street of its path again",
        "Agent-action, Correction, (Experiment-participant, (Operate, Car)), Label/Back-on-path",
    ],
    [
        "stop_line",
        "the front of the participant's vehicle crossed the stop line at a red light",
        "Agent-action, Inappropriate-action, (Experiment-participant, (Operate, Car)), Label/Stop-line",
    ],
    [
        "red_light",
        "the middle of the participant's vehicle crossed the stop line, too, while the light was red",
        "Agent-action, Inappropriate-action, (Experiment-participant, (Operate, Car)), Label/Red-light",
    ],
    [
        "wrong_way",
        "the participant's vehicle drives against the direction of its lane",
        "Agent-action, Inappropriate-action, (Experiment-participant, (Operate, Car)), Label/Wrong-way",
    ],
    [
        "right_way",
        "the participant's vehicle drives in the direction of its lane again",
        "Agent-action, Correction, (Experiment-participant, (Operate, Car)), Label/Right-way",
    ],
    [
        "speeding",
        "the participant's vehicle is faster than the speed limit",
        "Agent-action, Inappropriate-action, (Experiment-participant, (Operate, Car)), Label/Speeding",
    ],
    [
        "within_limit",
        "the participant's vehicle keeps the speed limit again",
        "Agent-action, Correction, (Experiment-participant, (Operate, Car)), Label/Within-limit",
    ],
    [
        "near_miss",
        "the participant's vehicle and another vehicle were less than 1.5 s from a contact",
        "Data-feature, Label/Near-miss",
    ],
    [
        "put_back",
        "the participant's vehicle was put back on its lane",
        "Experiment-control, (Controller-agent, (Move, Car)), Label/Put-back",
    ],
    ["ended", "the drive is over", "Experiment-structure, Label/Drive-ended"],
    ["mark", "a mark by the experimenter or the participant", "Experiment-control, Label/Mark"],
    ["note", "a note by the experimenter", "Experiment-control, Experimental-note, Label/Note"],
    ["criterion", "the criterion of a practice drive is met", "Experiment-structure, Label/Criterion-met"],
    [skills::SKILL, "the participant showed a skill in a practice drive", "Experiment-structure, Label/Skill-shown"],
    [skills::SKILLS_MISSING, "skills that a practice drive did not show", "Experiment-structure, Label/Skills-missing"],
    [
        "asked",
        "the participant asked to stop",
        "Agent-action, (Experiment-participant, Communicate), Label/Asked-to-stop",
    ],
    ["paused", "the experimenter paused the drive", "Experiment-control, (Experimenter, Halt), Label/Paused"],
    ["resumed", "the drive continued", "Experiment-control, Label/Resumed"],
    [
        "fms_asked",
        "the question of the fast motion sickness scale appeared",
        "Sensory-event, Experimental-stimulus, Cue, Visual-presentation, Computer-screen, Label/FMS-asked",
    ],
    [
        "fms",
        "the participant answered the question, with a rating",
        "Agent-action, Participant-response, (Experiment-participant, (Press, Push-button)), Label/FMS-answered",
    ],
    [
        "fms_unanswered",
        "the question disappeared without an answer",
        "Experiment-structure, Omitted-action, Label/FMS-unanswered",
    ],
    [
        "extended",
        "the experimenter made the drive longer",
        "Experiment-control, (Experimenter, Modify), Label/Extended",
    ],
    [
        "aborted",
        "the experimenter stopped the drive before its end",
        "Experiment-control, (Experimenter, Halt), Label/Aborted",
    ],
    [
        "skipped",
        "the experimenter skipped the rest of the drive",
        "Experiment-control, (Experimenter, Halt), Label/Skipped",
    ],
    ["excluded", "the experimenter excluded the data", "Experiment-control, (Experimenter, Halt), Label/Excluded"],
    ["stopped", "the session was stopped", "Experiment-control, Halt, Label/Stopped"],
    ["closed", "the windows were closed", "Experiment-control, Halt, Label/Closed"],
    [
        "abort asked for",
        "the participant asked for the end of the drive, by a button of the wheel",
        "Agent-action, (Experiment-participant, (Press, Push-button)), Label/Abort-asked-for",
    ],
    [
        "answer",
        "the participant pressed the button for answers",
        "Agent-action, Participant-response, (Experiment-participant, (Press, Push-button)), Label/Answer",
    ],
    [
        "horn",
        "the horn was switched on or off",
        "Agent-action, (Experiment-participant, (Press, Push-button)), Label/Horn",
    ],
    [
        "spoken_guidance",
        "a voice began to say the way before a manoeuvre",
        "Sensory-event, Cue, Auditory-presentation, Loudspeaker, Label/Spoken-guidance",
    ],
    [
        "indicator",
        "the indicators were switched to left, right or off",
        "Agent-action, (Experiment-participant, (Press, Push-button)), Label/Indicator",
    ],
    [
        "main_beam",
        "the main beam was switched on or off",
        "Agent-action, (Experiment-participant, (Press, Push-button)), Label/Main-beam",
    ],
    [
        "event_armed",
        "an event of the scenario waits for its trigger from now on",
        "Experiment-structure, Label/Event-armed",
    ],
    [
        "event_triggered",
        "the trigger of an event of the scenario came true",
        "Experiment-structure, Label/Event-triggered",
    ],
    [
        "event_triggered_by_hand",
        "the experimenter began an event of the scenario",
        "Experiment-control, Label/Event-triggered-by-hand",
    ],
    [
        "event_onset",
        "the first tick that shows an action of an event of the scenario",
        "Sensory-event, Experimental-stimulus, Visual-presentation, Computer-screen, Label/Event-onset",
    ],
    ["event_ended", "all actions of an event of the scenario are over", "Experiment-structure, Label/Event-ended"],
    [
        "event_not_done",
        "an event of the scenario, or one of its actions, was not carried out",
        "Experiment-structure, Omitted-action, Label/Event-not-done",
    ],
    [
        "task_stimulus",
        "a stimulus of the secondary task appears: a signal, a digit or a display",
        "Sensory-event, Experimental-stimulus, Visual-presentation, Computer-screen, Label/Task-stimulus",
    ],
    [
        "task_response",
        "the participant pressed the button of the secondary task",
        "Agent-action, Participant-response, (Experiment-participant, (Press, Push-button)), Label/Task-response",
    ],
    [
        "shutter",
        "the shutter before the picture opened or closed",
        "Sensory-event, Experimental-stimulus, Visual-presentation, Computer-screen, Label/Shutter",
    ],
    [
        "spoken_digit",
        "a voice began to say a digit of the secondary task",
        "Sensory-event, Experimental-stimulus, Auditory-presentation, Loudspeaker, Label/Spoken-digit",
    ],
    [
        "not_scored",
        "a digit of the secondary task is not scored: it was neither heard nor shown, or follows such a digit; the value is its onset",
        "Experiment-structure, Omitted-action, Label/Not-scored",
    ],
    [
        "shown_sentence",
        "a sentence that cannot be heard appears above the speedometer",
        "Sensory-event, Experimental-stimulus, Visual-presentation, Computer-screen, Label/Shown-sentence",
    ],
    [
        "question_asked",
        "a question of an event appears above the speedometer, with its answers",
        "Sensory-event, Experimental-stimulus, Visual-presentation, Computer-screen, Label/Question-asked",
    ],
    [
        "question_answered",
        "the participant answered the question: right, wrong, or not scored; the value is the number of the answer from the left",
        "Agent-action, Participant-response, (Experiment-participant, (Press, Push-button)), Label/Question-answered",
    ],
    ["question_unanswered", "the time for an answer is over", "Omitted-action, Label/Question-unanswered"],
    [
        "remote_led",
        "the LED of the detection response task was lit or darkened, or could not be and its signal is on the screen",
        "Sensory-event, Experimental-stimulus, Visual-presentation, Label/Remote-led",
    ],
    [
        "automation_on",
        "the automation drives from now on",
        "Experiment-structure, Experimental-stimulus, Label/Automation-on",
    ],
    [
        "automation_off",
        "the participant drives from now on; the detail is the cause",
        "Agent-action, Participant-response, Label/Automation-off",
    ],
    [
        "automation_gap",
        "the participant set the time gap that the automation keeps to the vehicle ahead",
        "Agent-action, Participant-response, (Experiment-participant, (Press, Push-button)), Label/Automation-gap",
    ],
    [
        "takeover_request",
        "the automation asks the participant to take over, by text, tone and voice",
        "Sensory-event, Experimental-stimulus, Visual-presentation, Auditory-presentation, Label/Takeover-request",
    ],
    [
        "takeover_input",
        "the participant moved a control for the first time since the takeover request",
        "Agent-action, Participant-response, Label/Takeover-input",
    ],
    [
        "minimal_risk_manoeuvre",
        "the automation begins to stop in the lane",
        "Sensory-event, Experimental-stimulus, Label/Minimal-risk-manoeuvre",
    ],
    [
        "spoken_sentence",
        "a voice began to say a sentence of an event of the scenario",
        "Sensory-event, Experimental-stimulus, Auditory-presentation, Loudspeaker, Label/Spoken-sentence",
    ],
    [
        "spoken_request",
        "a voice began to say a takeover request",
        "Sensory-event, Experimental-stimulus, Auditory-presentation, Loudspeaker, Label/Spoken-request",
    ],
    ["wheel profile", "profile of the steering wheel in use from now on", "Experiment-control, Label/Wheel-profile"],
    ["wheel plugged in", "a steering wheel was plugged in", "Experiment-control, Input-device, Label/Wheel-plugged-in"],
    [
        "wheel unplugged",
        "the steering wheel was unplugged",
        "Experiment-control, Mishap, Input-device, Label/Wheel-unplugged",
    ],
    [
        "wheel trouble",
        "the steering wheel reports a fault",
        "Experiment-control, Mishap, Input-device, Label/Wheel-trouble",
    ],
    ["device", "state of a laboratory device: gone, back, silent, or not recorded", "Experiment-control, Label/Device"],
];

/// Returns the columns of the table.
fn columns() -> Vec<TsvColumn> {
    let speed = |name: &str, about: &str, label: &str| {
        TsvColumn::new(name, about, "m/s").tagged(json!(format!("(Label/{label}, Speed/# m-per-s)")))
    };
    // The parentheses group the tags, so that two events at one moment do not repeat a tag.
    let tags = WORDS.iter().map(|[word, _, tags]| ((*word).to_owned(), Value::from(format!("({tags})")))).collect();
    vec![
        TsvColumn::new(
            "onset",
            "simulation time since the start of the drive; in the table beside motion data, since their first sample",
            "s",
        ),
        TsvColumn::new("duration", "duration of an advice; n/a for events without a duration", "s"),
        TsvColumn::new("trial_type", "kind of event", "")
            .with(WORDS.iter().map(|[word, about, _]| ((*word).to_owned(), (*about).to_owned())))
            .tagged(Value::Object(tags)),
        TsvColumn::new("tick", "tick of the recording, 10 ms each; key for joining with its tables", ""),
        speed("target_speed", "advised speed", "Advised-speed"),
        speed("range_low", "lower edge of the acceptable range", "Lowest-advised"),
        speed("range_high", "upper edge of the acceptable range", "Highest-advised"),
        speed("speed", "speed of the participant's vehicle at the event", "Own-speed"),
        TsvColumn::new(
            "value",
            "closing speed of a contact, lateral offset on leaving the road, rating of sickness (0 to 20), or digit or column of a \
             secondary task",
            "m/s, m or none",
        ),
        TsvColumn::new("detail", "details as text", ""),
    ]
}

/// The sidecar of all tables of events of a data set.
pub(super) fn sidecar() -> String {
    TsvTable::new(columns()).sidecar(Value::Null)
}

/// Events of a drive, in the order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct DriveEvents {
    /// Tick, and all cells except the onset.
    rows: Vec<(u64, Vec<String>)>,
}

impl DriveEvents {
    /// Reads the events from a recording.
    ///
    /// # Errors
    /// A table of the recording cannot be read.
    pub fn of(recording: &Path) -> Result<Self, RecordError> {
        let mut rows: Vec<(u64, Vec<String>)> = Vec::new();
        let advice = TableReader::parquet(&Recorded::Advice.parquet(recording))?;
        let columns = ["hold_s", "target_mps", "range_low_mps", "range_high_mps", "speed_mps"];
        let columns = columns.map(|name| advice.numbers(name));
        for (i, tick) in advice.wholes("tick").into_iter().enumerate() {
            let [hold, target, low, high, speed] = [0, 1, 2, 3, 4].map(|k: usize| number(columns[k][i]));
            let cells =
                [hold, "advice".into(), tick.to_string(), target, low, high, speed, String::new(), String::new()];
            rows.push((tick, cells.into()));
        }
        let events = TableReader::parquet(&Recorded::Events.parquet(recording))?;
        let (kinds, details, values) = (events.words("event"), events.words("detail"), events.numbers("value"));
        for (i, tick) in events.wholes("tick").into_iter().enumerate() {
            let mut cells = vec![String::new(), kinds[i].clone(), tick.to_string()];
            cells.extend([const { String::new() }; 4]);
            cells.extend([number(values[i]), details[i].clone()]);
            rows.push((tick, cells));
        }
        rows.sort_by_key(|row| row.0);
        Ok(Self { rows })
    }

    /// Returns the events as a table whose onsets count from tick `first`.
    pub fn since(&self, first: u64) -> TsvTable {
        let mut table = TsvTable::new(columns());
        let row = |(tick, cells): &(u64, Vec<String>)| [vec![onset(*tick, first)], cells.clone()].concat();
        table.rows = self.rows.iter().map(row).collect();
        table
    }
}

/// Formats the time from one tick to another in seconds with two decimals, as ticks are 10 ms; negative before `first`.
pub(super) fn onset(tick: u64, first: u64) -> String {
    let (sign, ticks) = if tick < first { ("-", first - tick) } else { ("", tick - first) };
    format!("{sign}{}.{:02}", ticks / 100, ticks % 100)
}

#[cfg(test)]
#[path = "event_table_tests.rs"]
mod tests;
