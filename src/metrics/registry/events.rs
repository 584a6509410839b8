//! Measures of drives with events: responses to the events of the scenario that were seen. In: nothing. Out: their names, units and definitions, in the
//! order of the tables.

use super::measure::{Measure, ego};

/// Measures in the order of the tables; `events.csv` of an analysis has each event by itself.
pub(super) const MEASURES: &[Measure] = &[
    ego("event_count", "Events", "", "events of the scenario that were seen; empty in drives without one, as are the next measures"),
    ego(
        "event_response_s",
        "Perception-response time to events",
        "s",
        "time from the onset of an event to the first movement of accelerator, brake or steering wheel, until 5 s after the event's end or until the \
         next onset: mean over the events with one",
    )
    .in_j2944("reaction time, 6.5.2"),
    ego(
        "event_release_s",
        "Accelerator release time after events",
        "s",
        "time from the onset of an event to an accelerator below 2 % of its travel: mean over the events with one",
    )
    .in_j2944("accelerator release time"),
    ego(
        "event_brake_s",
        "Brake response time after events",
        "s",
        "time from the onset of an event to a brake beyond 2 % of its travel: mean over the events with one",
    )
    .in_j2944("brake response time"),
    ego(
        "event_brake_share",
        "Share of events with a brake response",
        "",
        "share of the events with a brake response, of those at whose onset the brake was released",
    ),
    ego(
        "event_steering_s",
        "Time to first steering after events",
        "s",
        "time from the onset of an event to a steering wheel 2 degrees away from its angle at the onset: mean over the events with one",
    ),
    ego(
        "event_min_gap_m",
        "Minimum gap in events",
        "m",
        "least gap to the leader, bumper to bumper, while an event is watched: mean over the events",
    )
    .in_j2944("distance gap"),
    ego(
        "event_min_ttc_s",
        "Minimum time to collision in events",
        "s",
        "least time to collision with the leader while an event is watched: mean over the events in which the gap closed",
    )
    .in_j2944("time to collision"),
    ego(
        "event_max_decel_mps2",
        "Maximum deceleration in events",
        "m/s2",
        "largest deceleration of the ego vehicle while an event is watched: mean over the events",
    ),
    ego(
        "event_contact_share",
        "Share of events with a contact",
        "",
        "share of the events in which the ego vehicle touched another vehicle while they were watched",
    ),
    ego(
        "questions",
        "Questions while driving",
        "",
        "questions of events (`ask`) that were answered or had their whole time; empty in drives without questions",
    ),
    ego("questions_unanswered", "Questions without an answer", "", "questions of events without an answer in their time"),
    ego(
        "question_correct",
        "Share of right answers",
        "",
        "share of right answers among the answers to questions that have a right one; it may depend on whether the automation drives at the \
         answer",
    ),
    ego(
        "question_response_s",
        "Response time to questions",
        "s",
        "mean time from the frame that showed a question to its answer; in `summary.json` from the tick of the question",
    ),
];
