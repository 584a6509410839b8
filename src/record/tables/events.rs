//! Table of events. In: an [`Event`] of the world, or a mark or note of a person or a window. Out: its row. Speeds in m/s.

use crate::{
    record::table::{ColumnValue, TableColumn, column, number},
    scenario::ScriptedEvent,
    sim::{Event, EventKind, EventStage},
    time::Tick,
};

/// Row of an event.
#[derive(Clone, Debug)]
pub struct EventRow {
    /// Tick of the event.
    pub tick: Tick,
    /// Kind of event, one word.
    pub kind: String,
    /// Further details as text.
    pub detail: String,
    /// Number of the other vehicle.
    pub car: Option<u32>,
    /// Closing speed, m/s, offset, m, or time to collision, s, depending on the kind.
    pub value: Option<f64>,
    /// Heading of the other vehicle relative to the ego, radians, positive to the left.
    pub angle_rad: Option<f64>,
}

/// Event of a policy that stops advising: the former advice is no longer in force.
pub const ADVICE_WITHHELD: &str = "advice_withheld";
/// Event of an ego that was put back on its lane. A replay repeats it.
pub const PUT_BACK: &str = "put_back";
/// Event of a stimulus of the secondary task, which is seen from its tick on.
pub const TASK_STIMULUS: &str = "task_stimulus";
/// Event of a stimulus of the secondary task that is not scored, because the participant neither heard nor saw it or what it is compared with; the
/// value is its onset, s.
pub const NOT_SCORED: &str = "not_scored";
/// Event of a response to the secondary task.
pub const TASK_RESPONSE: &str = "task_response";
/// Event of a shutter that opens or closes; the detail is `open` or `closed`.
pub const SHUTTER: &str = "shutter";
/// Detail of a shutter that opens.
pub const SHUTTER_OPENS: &str = "open";

impl EventRow {
    /// Kinds of events made by the world; all others are made by people and windows.
    const KINDS_OF_WORLD: [&str; 36] = [
        ADVICE_WITHHELD,
        "contact",
        "object_contact",
        "left_road",
        "back_on_road",
        "left_path",
        "back_on_path",
        "stop_line",
        "red_light",
        "wrong_way",
        "right_way",
        "speeding",
        "within_limit",
        "near_miss",
        "indicator",
        "main_beam",
        TASK_STIMULUS,
        TASK_RESPONSE,
        SHUTTER,
        "question_asked",
        "question_answered",
        "question_unanswered",
        "automation_on",
        "automation_off",
        "automation_gap",
        "takeover_request",
        "takeover_input",
        "minimal_risk_manoeuvre",
        PUT_BACK,
        "event_armed",
        "event_triggered",
        "event_triggered_by_hand",
        "event_onset",
        "event_ended",
        "event_not_done",
        "ended",
    ];

    /// Checks whether the world makes events of this kind.
    pub fn is_of_world(kind: &str) -> bool {
        Self::KINDS_OF_WORLD.contains(&kind)
    }

    /// Returns the row of an event of the world, in a drive with these events of the scenario; `None` for advice, which has its own table.
    pub fn of(event: &Event, scripted: &[ScriptedEvent]) -> Option<Self> {
        let row = |kind: &str, detail: String, car: Option<u32>, value: Option<f64>| {
            Some(Self { tick: event.tick, kind: kind.into(), detail, car, value, angle_rad: None })
        };
        let at = |s_m: f64| format!("at {s_m:.2} m of the route");
        let name_of = |event: u16| scripted.get(usize::from(event)).map_or("", |event| event.name.as_str());
        match event.kind {
            EventKind::Advice(_) => None,
            EventKind::AdviceWithheld => row(ADVICE_WITHHELD, String::new(), None, None),
            EventKind::Contact { car, kind, ego_speed_mps, car_speed_mps, closing_mps, angle_rad } => {
                let detail = format!("ego at {ego_speed_mps:.3} m/s, {} at {car_speed_mps:.3} m/s", kind.name());
                let contact = row("contact", detail, Some(car.0), Some(closing_mps))?;
                Some(Self { angle_rad: Some(angle_rad), ..contact })
            }
            EventKind::ObjectContact { object, ego_speed_mps, closing_mps } => {
                let detail = format!("{}, ego at {ego_speed_mps:.3} m/s", object.name());
                row("object_contact", detail, None, Some(closing_mps))
            }
            EventKind::LeftRoad { s_m, offset_m } => row("left_road", at(s_m), None, Some(offset_m)),
            EventKind::BackOnRoad => row("back_on_road", String::new(), None, None),
            EventKind::LeftPath { s_m } => row("left_path", at(s_m), None, None),
            EventKind::BackOnPath { s_m } => row("back_on_path", at(s_m), None, None),
            EventKind::StopLine { s_m, speed_mps } => row("stop_line", at(s_m), None, Some(speed_mps)),
            EventKind::RedLight { s_m, speed_mps } => row("red_light", at(s_m), None, Some(speed_mps)),
            EventKind::WrongWay { s_m } => row("wrong_way", at(s_m), None, None),
            EventKind::RightWay => row("right_way", String::new(), None, None),
            EventKind::MainBeam(is_on) => row("main_beam", if is_on { "on" } else { "off" }.into(), None, None),
            EventKind::Indicator(side) => row("indicator", side.name().into(), None, None),
            EventKind::Speeding { s_m, over_mps } => row("speeding", at(s_m), None, Some(over_mps)),
            EventKind::WithinLimit => row("within_limit", String::new(), None, None),
            EventKind::NearMiss { car, time_s } => row("near_miss", String::new(), Some(car.0), Some(time_s)),
            EventKind::TaskStimulus(stimulus) => {
                let (detail, value) = stimulus.words();
                row(TASK_STIMULUS, detail.into(), None, value)
            }
            EventKind::TaskResponse(response) => {
                let (detail, value) = response.words();
                row(TASK_RESPONSE, detail.into(), None, value)
            }
            EventKind::Shutter(is_open) => {
                row(SHUTTER, if is_open { SHUTTER_OPENS } else { "closed" }.into(), None, None)
            }
            EventKind::Automation(change) => {
                let (kind, detail, value) = change.words();
                row(kind, detail.into(), None, value)
            }
            EventKind::PutBack { s_m } => row(PUT_BACK, at(s_m), None, None),
            EventKind::Question { event, change } => {
                let (kind, detail, value) = change.words();
                row(kind, detail.unwrap_or_else(|| name_of(event)).into(), None, value)
            }
            EventKind::Scripted { event, vehicle, stage } => {
                let name = name_of(event);
                let detail = match stage {
                    EventStage::NotDone(why) => format!("{name}: {}", why.name()),
                    _ => name.to_owned(),
                };
                row(stage.name(), detail, vehicle.map(|id| id.0), None)
            }
            EventKind::Ended(reason) => row("ended", reason.name().into(), None, None),
        }
    }
}

/// Columns: one row for each event.
pub const EVENTS: &[TableColumn<EventRow>] = &[
    column("tick", "", "when", ColumnValue::Whole(|r| r.tick.0)),
    column(
        "event",
        "",
        "advice_withheld, contact, object_contact, left_road, back_on_road, left_path, back_on_path, stop_line, \
         red_light, wrong_way, right_way, speeding, within_limit, near_miss, indicator, main_beam, task_stimulus, task_response, \
         shutter, automation_on, automation_off, automation_gap, takeover_request, takeover_input, minimal_risk_manoeuvre, put_back, event_armed, event_triggered, event_triggered_by_hand, event_onset, event_ended, event_not_done, ended, mark, note, pause, ...",
        ColumnValue::Word(|r| r.kind.clone()),
    ),
    column("detail", "", "the rest in words", ColumnValue::Word(|r| r.detail.clone())),
    column("car", "", "the other car", ColumnValue::Id(|r| r.car)),
    number(
        "value",
        "m/s, m or s; digit or column",
        "closing speed of a contact, offset where the road was left, speed at a red light, speed over the limit, time to \
         collision of a near miss, digit or target column of a stimulus, column of a response, lead time of a takeover request, time gap of the automation",
        |r| r.value,
    ),
    number(
        "angle_deg",
        "degrees",
        "contact: heading of the other car against the own one, 0 alike, 180 head-on, positive to the left",
        |r| r.angle_rad.map(f64::to_degrees),
    ),
];
