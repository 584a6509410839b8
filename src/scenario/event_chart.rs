//! Picture of a scenario's events. In: the events, the road and the duration of the drive. Out: SVG of a timeline, from when on each event can begin, and
//! of the route with the places of triggers and people. Metres, seconds.

use super::{
    PlannedDrive, ScriptedEvent,
    scripted_event::{Action, LaneChange, OffsetChange, SpeedChange, Trigger},
};
use crate::plot::{Axis, COLOURS, Chart, LineStyle, PlotLine, PlotShape, picture};

/// End of the timeline of a drive without an end, s.
const USUAL_S: f64 = 600.0;
/// Largest height of the route's picture, units of the picture.
const TALLEST: f64 = 420.0;
/// Spacing of the points of the route, m.
const SPACING_M: f64 = 5.0;
const POSSIBLE: &str = "#cfe3f1";

/// Returns the picture of a drive's events, with the route if a trigger names a place on it; `None` without events.
pub fn event_chart(drive: &PlannedDrive) -> Option<String> {
    let events = &drive.scenario().events;
    let has_places = events.iter().any(|event| !places_m(&event.trigger, drive).is_empty());
    let charts = [timeline(drive), has_places.then(|| route(drive))];
    let charts: Vec<Chart> = charts.into_iter().flatten().collect();
    let note = "Pale: the time in which the event can begin, as far as its trigger tells it beforehand. Blue: the event, if it begins as early as possible.";
    (!events.is_empty()).then(|| picture(&charts, note))
}

/// Returns the earliest time at which a trigger can come true, s.
fn earliest_s(trigger: &Trigger, events: &[ScriptedEvent]) -> f64 {
    match trigger {
        Trigger::TimeS(time_s) => *time_s,
        Trigger::After { event, delay_s, .. } => {
            let before = events.iter().find(|other| other.name == *event);
            before.map_or(0.0, |before| begins_s(before, events) + lasts_s(before) + delay_s)
        }
        Trigger::Begun { event, delay_s } => {
            let before = events.iter().find(|other| other.name == *event);
            before.map_or(0.0, |before| begins_s(before, events) + delay_s)
        }
        Trigger::All(list) => list.iter().map(|trigger| earliest_s(trigger, events)).fold(0.0, f64::max),
        Trigger::Any(list) => list.iter().map(|trigger| earliest_s(trigger, events)).fold(f64::INFINITY, f64::min),
        _ => 0.0,
    }
}

/// Returns the earliest time at which an event can begin, s.
fn begins_s(event: &ScriptedEvent, events: &[ScriptedEvent]) -> f64 {
    earliest_s(&event.trigger, events) + event.holds_s + event.delay_s
}

/// Checks whether a trigger comes true at its earliest time for sure.
fn is_certain(trigger: &Trigger) -> bool {
    matches!(trigger, Trigger::TimeS(_))
}

/// Returns the shortest time that an event takes, s: its longest stated duration.
fn lasts_s(event: &ScriptedEvent) -> f64 {
    let of = |action: &Action| match action {
        Action::Brake { keep_s, .. } | Action::Accelerate { keep_s, .. } => *keep_s,
        Action::KeepSpeed { for_s, .. }
        | Action::BreakDown { for_s, .. }
        | Action::PowerLoss { for_s }
        | Action::SideWind { for_s, .. }
        | Action::Friction { for_s, .. }
        | Action::Message { for_s, .. }
        | Action::Pictogram { for_s, .. }
        | Action::Sound { for_s, .. }
        | Action::WheelPulse { for_s, .. }
        | Action::HideAdvice { for_s } => *for_s,
        Action::Ask(ask) => ask.for_s,
        Action::Weather { over_s, .. } => *over_s,
        Action::ChangeLane(LaneChange { in_s: Some(in_s), .. })
        | Action::Speed(SpeedChange { in_s: Some(in_s), .. })
        | Action::Offset(OffsetChange { in_s: Some(in_s), .. }) => *in_s,
        Action::CyclistRides(ride) => ride.for_m / ride.speed_mps,
        Action::CutIn { .. }
        | Action::ChangeLane(LaneChange { in_s: None, .. })
        | Action::Speed(SpeedChange { in_s: None, .. })
        | Action::Offset(OffsetChange { in_s: None, .. })
        | Action::Synchronise(_)
        | Action::Walk(_)
        | Action::Teleport(_)
        | Action::Signal { .. }
        | Action::EndDrive
        | Action::SignalAhead { .. }
        | Action::PedestrianCrosses(_)
        | Action::Speak { .. }
        | Action::TakeoverRequest { .. }
        | Action::Automation(_) => 0.0,
    };
    event.actions.iter().map(of).fold(0.0, f64::max)
}

fn timeline(drive: &PlannedDrive) -> Option<Chart> {
    let (events, duration_s) = (&drive.scenario().events, drive.scenario().duration_s);
    let end_s = if duration_s > 0.0 { duration_s } else { USUAL_S };
    let names = events.iter().map(|event| format!("{}: {}", event.name, event.trigger.in_words())).collect();
    let mut chart = Chart::new("Events over time", Axis::names(names), Axis::even("time, s", [0.0, end_s]), 0.0);
    for (row, event) in (1..).zip(events) {
        let row = f64::from(row);
        let begin_s = begins_s(event, events);
        let piece = |to_s: f64, colour: &str, width: f64| PlotShape::Pieces {
            pieces: vec![[[row, begin_s.min(end_s)], [row, to_s.min(end_s)]]],
            colour: colour.into(),
            width,
        };
        if !is_certain(&event.trigger) {
            chart.shapes.push(piece(end_s, POSSIBLE, 12.0));
        }
        // A short event is still seen.
        chart.shapes.push(piece(begin_s + lasts_s(event).max(end_s / 150.0), COLOURS[0], 12.0));
    }
    (!events.is_empty()).then(|| chart.transposed())
}

fn route(drive: &PlannedDrive) -> Chart {
    let route = &drive.map().route;
    let point = |s_m: f64| route.point_at(s_m).to_array();
    let steps = (route.length_m() / SPACING_M).ceil() as usize;
    let points: Vec<[f64; 2]> =
        (0..=steps).map(|k| point((k as f64 * SPACING_M).min(route.length_m() - 0.01))).collect();
    let range = |axis: usize| {
        let all = points.iter().map(|point| point[axis]);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        [low - 20.0, high + 20.0]
    };
    let [[west, east], [south, north]] = [range(0), range(1)];
    let height = (600.0 * (north - south) / (east - west)).clamp(90.0, TALLEST);
    // One scale for both axes: the shorter one shows more than the route.
    let wide = (600.0 / height * (north - south) - (east - west)).max(0.0) / 2.0;
    let mut chart = Chart::new(
        "Places on the route",
        Axis::even("east, m", [west - wide, east + wide]),
        Axis::even("north, m", [south, north]),
        height,
    );
    let line = |name: String, style: LineStyle, points: Vec<[f64; 2]>| PlotLine { name, style, points, band: vec![] };
    chart.lines.push(line("route".into(), LineStyle::solid("#999999"), points));
    for (k, event) in drive.scenario().events.iter().enumerate() {
        let style = LineStyle { dots: true, ..LineStyle::solid(COLOURS[k % COLOURS.len()]) };
        let of_people = event.actions.iter().filter_map(Action::place_m);
        for place_m in places_m(&event.trigger, drive).into_iter().chain(of_people) {
            chart.lines.push(line(format!("{}: {place_m:.0} m", event.name), style, vec![point(place_m)]));
        }
    }
    chart
}

/// Returns the places on the route that a trigger names, m.
fn places_m(trigger: &Trigger, drive: &PlannedDrive) -> Vec<f64> {
    match trigger {
        Trigger::PlaceM(place_m) | Trigger::Reaches { place_m, .. } => vec![*place_m],
        Trigger::Edge { id, at_m, .. } => {
            let (route, network) = (&drive.map().route, &drive.map().network);
            let on_edge = route.lanes().iter().filter(|part| part.edge_id(network) == id);
            on_edge.map(|part| part.start_s_m + at_m).collect()
        }
        Trigger::Any(list) | Trigger::All(list) => list.iter().flat_map(|part| places_m(part, drive)).collect(),
        _ => vec![],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    fn planned(text: &str) -> PlannedDrive {
        let text = format!("traffic = \"native\"\nduration_s = 100\n{text}");
        PlannedDrive::new(&Scenario::from_toml(&text, "trial.toml").unwrap_or_else(|fault| panic!("{fault}"))).unwrap()
    }

    const WORD: &str = "actions = [{ message = { text = \"a\", for_s = 4 } }]\n";

    #[test]
    fn the_earliest_time_of_an_event_follows_from_those_before_it() {
        let drive = planned(&format!(
            "[[event]]\nname = \"a\"\ntrigger = {{ time_s = 20 }}\n{WORD}[[event]]\nname = \"b\"\ntrigger = {{ all = [{{ after = {{ event = \"a\", delay_s = 6 }} }}, {{ speed_above_mps = 3 }}] }}\n{WORD}\
             [[event]]\nname = \"c\"\ntrigger = {{ any = [{{ time_s = 50 }}, {{ place_m = 100 }}] }}\n{WORD}"
        ));
        let events = &drive.scenario().events;
        let earliest: Vec<f64> = events.iter().map(|event| begins_s(event, events)).collect();
        // "b" waits for the four seconds of "a" and six more; "c" can begin at its place at once.
        assert_eq!(earliest, [20.0, 30.0, 0.0]);
        let svg = event_chart(&drive).expect("events");
        for words in ["a: at 20 s", "6 s after", "faster than 3 m/s", "c: at 50 s or at 100 m", "c: 100 m"] {
            assert!(svg.contains(words), "{words}: {svg}");
        }
        assert_eq!(event_chart(&planned("")), None);
    }
}
