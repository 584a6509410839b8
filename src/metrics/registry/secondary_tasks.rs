//! Measures of drives with a secondary task. In: nothing. Out: their names, units and definitions, in the order of the tables.

use super::measure::{Measure, ego};

/// Measures in the order of the tables.
pub(super) const MEASURES: &[Measure] = &[
    ego(
        "detection_signals",
        "Signals of the detection response task",
        "",
        "signals of the detection response task that had 2.5 s for a response, or a hit before the end of the drive; empty in \
         drives without the task",
    )
    .by("secondary-tasks"),
    ego(
        "detection_misses",
        "Missed signals",
        "",
        "signals without a hit: a press from 0.1 to 2.5 s after the frame that showed the signal",
    )
    .by("secondary-tasks"),
    ego("detection_hit_rate", "Share of signals with a hit", "", "share of the signals with a hit").by("secondary-tasks"),
    ego(
        "detection_response_s",
        "Response time to signals",
        "s",
        "mean time of the hits, from the frame that showed the signal to the press; in `summary.json` from the tick of the signal",
    )
    .by("secondary-tasks"),
    ego(
        "detection_false_responses",
        "False responses to signals",
        "",
        "presses that are no hit: earlier than 0.1 s, later than 2.5 s, or repeated",
    )
    .by("secondary-tasks"),
    ego("n_back_digits", "Digits of the n-back task", "", "digits of the n-back task that count: heard or shown, without those compared with one that was not; empty without such digits")
        .by("secondary-tasks"),
    ego(
        "n_back_accuracy",
        "Accuracy in the n-back task",
        "",
        "share of the digits that can match with the right decision: pressed before the next digit at a match, not pressed at \
         others; empty with spoken responses",
    )
    .by("secondary-tasks"),
    ego("n_back_hit_rate", "Share of matches with a press", "", "share of the matches of the n-back task with a press")
        .by("secondary-tasks"),
    ego("n_back_false_alarms", "Presses without a match", "", "digits of the n-back task without a match, but with a press")
        .by("secondary-tasks"),
    ego(
        "search_displays",
        "Displays of the surrogate reference task",
        "",
        "displays of the surrogate reference task with a confirmed column; empty in drives without the task",
    )
    .by("secondary-tasks"),
    ego(
        "search_correct",
        "Share of right columns",
        "",
        "share of these displays whose target was in the confirmed column",
    )
    .by("secondary-tasks"),
    ego(
        "search_response_s",
        "Time for a display",
        "s",
        "mean time from the frame that showed a display to its confirmation; in `summary.json` from the tick of the display",
    )
    .by("secondary-tasks"),
    ego("shutter_openings", "Openings of the shutter", "", "number of times the shutter of an occlusion opened")
        .by("secondary-tasks"),
    ego("shutter_open_s", "Total shutter open time", "s", "time for which the shutter of an occlusion was open")
        .by("secondary-tasks"),
];
