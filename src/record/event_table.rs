//! The table of events. In: an [`Event`] of the world, or what a person or a window notes. Out: its row. Speeds in m/s.

use super::{
    table::{ColumnValue, TableColumn},
    tables::{column, number},
};
use crate::{
    sim::{Event, EventKind},
    time::Tick,
};

/// Something that happened.
#[derive(Clone, Debug)]
pub struct EventRow {
    /// When.
    pub tick: Tick,
    /// What kind, a word.
    pub kind: String,
    /// The rest, in words.
    pub detail: String,
    /// The other car.
    pub car: Option<u32>,
    /// Speed at which two cars closed in, m/s, or offset in metres.
    pub value: Option<f64>,
    /// Heading of the other car against the own one, radians, positive to the left.
    pub angle_rad: Option<f64>,
}

/// The event of a policy that falls silent: what was advised stands no longer.
pub const ADVICE_WITHHELD: &str = "advice_withheld";
/// The event of an ego that was put back on its lane: a replay obeys it.
pub const PUT_BACK: &str = "put_back";

impl EventRow {
    /// Kinds of events that the world makes; all others are made by people and windows.
    pub(super) const KINDS_OF_WORLD: [&str; 14] = [
        ADVICE_WITHHELD,
        "contact",
        "left_road",
        "back_on_road",
        "stop_line",
        "red_light",
        "wrong_way",
        "right_way",
        "speeding",
        "within_limit",
        "near_miss",
        "indicator",
        PUT_BACK,
        "ended",
    ];

    /// True for a kind that the world makes.
    pub fn is_of_world(kind: &str) -> bool {
        Self::KINDS_OF_WORLD.contains(&kind)
    }

    /// The row of an event of the world; advice has a table of its own.
    pub fn of(event: &Event) -> Option<Self> {
        let row = |kind: &str, detail: String, car: Option<u32>, value: Option<f64>| {
            Some(Self { tick: event.tick, kind: kind.into(), detail, car, value, angle_rad: None })
        };
        let at = |s_m: f64| format!("at {s_m:.2} m of the route");
        match event.kind {
            EventKind::Advice(_) => None,
            EventKind::AdviceWithheld => row(ADVICE_WITHHELD, String::new(), None, None),
            EventKind::Contact { car, ego_speed_mps, car_speed_mps, closing_mps, angle_rad } => {
                let detail = format!("ego at {ego_speed_mps:.3} m/s, car at {car_speed_mps:.3} m/s");
                let contact = row("contact", detail, Some(car.0), Some(closing_mps))?;
                Some(Self { angle_rad: Some(angle_rad), ..contact })
            }
            EventKind::LeftRoad { s_m, offset_m } => row("left_road", at(s_m), None, Some(offset_m)),
            EventKind::BackOnRoad => row("back_on_road", String::new(), None, None),
            EventKind::StopLine { s_m, speed_mps } => row("stop_line", at(s_m), None, Some(speed_mps)),
            EventKind::RedLight { s_m, speed_mps } => row("red_light", at(s_m), None, Some(speed_mps)),
            EventKind::WrongWay { s_m } => row("wrong_way", at(s_m), None, None),
            EventKind::RightWay => row("right_way", String::new(), None, None),
            EventKind::Indicator(side) => row("indicator", side.word().into(), None, None),
            EventKind::Speeding { s_m, over_mps } => row("speeding", at(s_m), None, Some(over_mps)),
            EventKind::WithinLimit => row("within_limit", String::new(), None, None),
            EventKind::NearMiss { car, time_s } => row("near_miss", String::new(), Some(car.0), Some(time_s)),
            EventKind::PutBack { s_m } => row(PUT_BACK, at(s_m), None, None),
            EventKind::Ended(reason) => row("ended", reason.name().into(), None, None),
        }
    }
}

/// One row an event.
pub const EVENTS: &[TableColumn<EventRow>] = &[
    column("tick", "", "when", ColumnValue::Whole(|r| r.tick.0)),
    column(
        "event",
        "",
        "advice_withheld, contact, left_road, back_on_road, stop_line, red_light, wrong_way, right_way, speeding, \
         within_limit, near_miss, indicator, put_back, ended, mark, note, pause, ...",
        ColumnValue::Word(|r| r.kind.clone()),
    ),
    column("detail", "", "the rest in words", ColumnValue::Word(|r| r.detail.clone())),
    column("car", "", "the other car", ColumnValue::Id(|r| r.car)),
    number(
        "value",
        "m/s, m or s",
        "closing speed of a contact, offset where the road was left, speed at a red light, speed over the limit, time to \
         collision of a near miss",
        |r| r.value,
    ),
    number(
        "angle_deg",
        "degrees",
        "contact: heading of the other car against the own one, 0 alike, 180 head-on, positive to the left",
        |r| r.angle_rad.map(f64::to_degrees),
    ),
];
