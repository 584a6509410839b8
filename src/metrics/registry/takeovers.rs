//! Measures of drives with takeover requests of the automation. In: nothing. Out: their names, units and definitions, in the order of the tables.

use super::measure::{Measure, ego};

/// Measures in the order of the tables.
pub(super) const MEASURES: &[Measure] = &[
    ego(
        "takeover_requests",
        "Takeover requests",
        "",
        "takeover requests of the automation; empty in drives without one, as are the next measures",
    )
    .by("automation"),
    ego("takeovers", "Takeovers", "", "takeover requests after which the participant switched the automation off")
        .by("automation"),
    ego(
        "takeover_time_s",
        "Takeover time",
        "s",
        "time from the tick of a takeover request to the takeover, by button, pedal or steering wheel: mean over the takeovers",
    )
    .by("automation"),
    ego(
        "takeover_first_input_s",
        "Time to the first input after a takeover request",
        "s",
        "time from a takeover request to the first press of button, brake or accelerator (5 % of its travel), turn of the steering wheel (2 degrees) \
         or torque of the hands on one with force feedback: mean over the requests with one",
    )
    .by("automation"),
    ego(
        "takeover_hands_on_s",
        "Hands-on time",
        "s",
        "time from a takeover request to the first turn of the steering wheel by 2 degrees within 0.5 s, away from the automation's, \
         or torque of the hands on one with force feedback: mean over the requests with one before the takeover",
    )
    .by("automation"),
    ego(
        "takeover_eyes_on_road_s",
        "Eyes-on-road time",
        "s",
        "time from a takeover request to the begin of the first glance of 0.12 s or more at the road, 0 if the eyes are there, by the stream of an eye \
         tracker: mean over the requests with one before the next request",
    )
    .by("automation"),
    ego(
        "takeover_min_ttc_s",
        "Smallest time to collision after takeovers",
        "s",
        "smallest time to collision with the leader in the 10 s after a takeover",
    )
    .by("automation"),
    ego(
        "takeover_lane_deviation_m",
        "Largest lane deviation after takeovers",
        "m",
        "largest distance from the lane's centre line in the 10 s after a takeover",
    )
    .by("automation"),
    ego(
        "minimal_risk_manoeuvres",
        "Minimal-risk manoeuvres",
        "",
        "stops by the automation after a takeover request without a takeover",
    )
    .by("automation"),
];
