//! Table of the ego's advice. In: an [`Advice`], and the frame that showed it. Out: one row for each advice. SI units.

use crate::{
    policy::{Action, Advice},
    record::table::{ColumnValue, TableColumn, column, number},
};

/// Advice with the ego's speed and the frame that showed it first.
#[derive(Clone, Copy, Debug)]
pub struct AdviceRow {
    /// Advice that was issued.
    pub advice: Advice,
    /// Speed of the ego when the advice was issued, m/s.
    pub speed_mps: f64,
    /// Number of the first frame that showed it; `None` without a screen.
    pub shown_frame: Option<u32>,
    /// Time at which that frame was handed to the screen, s of wall time since the first frame.
    pub shown_wall_s: Option<f64>,
}

/// Columns: one row for each advice.
pub const ADVICE: &[TableColumn<AdviceRow>] = &[
    column("tick", "", "tick at which it was issued", ColumnValue::Whole(|r| r.advice.issued.0)),
    column(
        "action",
        "",
        "what the policy put out: speed or acceleration",
        ColumnValue::Word(|r| action(&r.advice).0.into()),
    ),
    number("action_value", "m/s or m/s2", "the policy's own number", |r| Some(action(&r.advice).1)),
    number("target_mps", "m/s", "advised speed", |r| Some(r.advice.target_mps)),
    number("range_low_mps", "m/s", "lower edge of the acceptable range", |r| Some(r.advice.band_mps().0)),
    number("range_high_mps", "m/s", "upper edge of the acceptable range", |r| Some(r.advice.band_mps().1)),
    number("hold_s", "s", "how long it stands; where no other follows at once, advice_withheld is an event", |r| {
        Some(r.advice.hold.seconds())
    }),
    number("speed_mps", "m/s", "the ego's speed at that tick", |r| Some(r.speed_mps)),
    column(
        "in_range",
        "",
        "that speed is in the new range",
        ColumnValue::Flag(|r| Some(r.advice.accepts(r.speed_mps))),
    ),
    column(
        "fallback",
        "",
        "the policy gave no number: what was advised before stands",
        ColumnValue::Flag(|r| Some(r.advice.is_fallback)),
    ),
    column("shown_frame", "", "number of the first frame that showed it", ColumnValue::Id(|r| r.shown_frame)),
    number("shown_wall_s", "s", "when that frame was handed over, wall time since the first frame", |r| r.shown_wall_s),
    number(
        "driver_reaction_s",
        "s",
        "the driver's reaction time as the policy makes it out; empty where it does not ask",
        |r| Some(r.advice.driver?.mean.reaction_s),
    ),
    number("driver_reaction_sd_s", "s", "standard deviation of that", |r| Some(r.advice.driver?.sd.reaction_s)),
    number("driver_speed_bias_mps", "m/s", "speed driven less speed advised, as the policy makes it out", |r| {
        Some(r.advice.driver?.mean.speed_bias_mps)
    }),
    number("driver_speed_bias_sd_mps", "m/s", "standard deviation of that", |r| {
        Some(r.advice.driver?.sd.speed_bias_mps)
    }),
    number(
        "driver_error_mps",
        "m/s",
        "standard deviation of the speed around what is aimed at, as the policy makes it out",
        |r| Some(r.advice.driver?.mean.error_mps),
    ),
    number("driver_error_sd_mps", "m/s", "standard deviation of that", |r| Some(r.advice.driver?.sd.error_mps)),
    number(
        "driver_time_gap_factor",
        "",
        "time gap as a multiple of the other cars', as the policy makes it out",
        |r| Some(r.advice.driver?.mean.time_gap_factor),
    ),
    number("driver_time_gap_factor_sd", "", "standard deviation of that", |r| {
        Some(r.advice.driver?.sd.time_gap_factor)
    }),
    number(
        "driver_willingness",
        "",
        "share of the time in which the driver follows, as the policy makes it out",
        |r| Some(r.advice.driver?.mean.willingness),
    ),
    number("driver_willingness_sd", "", "standard deviation of that", |r| Some(r.advice.driver?.sd.willingness)),
    number(
        "observed_deviation_mps",
        "m/s",
        "speed that the driver seeks less the advice of a reaction time ago, from their history; empty where the policy does not observe",
        |r| Some(r.advice.observed?.deviation_mps),
    ),
    number("observed_reaction_s", "s", "the driver's reaction time, from their history", |r| {
        Some(r.advice.observed?.reaction_s)
    }),
    number(
        "observed_time_gap_factor",
        "",
        "the driver's time gap as a multiple of the other vehicles', from their history",
        |r| Some(r.advice.observed?.time_gap_factor),
    ),
];

fn action(advice: &Advice) -> (&'static str, f64) {
    match advice.action {
        Action::Speed(value) => ("speed", value),
        Action::Acceleration(value) => ("acceleration", value),
    }
}
