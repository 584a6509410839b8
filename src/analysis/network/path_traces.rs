//! All vehicles on the ego's path over time. In: a [`RecordedTrial`] on a network. Out: [`PathTraces`]: a piece from each full second to the
//! next of each vehicle that is on the path at both, and what the signals along it showed. Seconds, metres along the path, m/s.
//!
//! A vehicle is on the path in a lane that the path goes along (as the simulation has it: `s_m` of the table of the cars); where it turns
//! off there is a gap. So is one where the ego leaves its path.

use crate::{
    analysis::{
        AnalysisError, RecordedTrial,
        traffic_steps::{StepVehicle, TrafficStep},
        trial::ThinnedValues,
    },
    map::{
        RoadMap,
        network::{EdgeId, SignalLight},
        stop_lines,
    },
    metrics::SpeedTrace,
    record::{RecordError, Table, TableReader},
    time::{TICKS_PER_S, Tick},
    traffic::EGO,
};
use std::collections::{BTreeMap, BTreeSet};

/// Pieces that are kept at the most: a picture of more is gigabytes long, and black.
const MOST_PIECES: usize = 150_000;
/// Positions are shown for so long, seconds.
const SHOWN_S: f64 = 3600.0;
/// Speeds that are kept at the most.
const MOST_SPEEDS: usize = 100_000;
/// From one step of the speeds to the next, ticks.
const SPEED_TICKS: u64 = 10;
/// In a second a vehicle gets farther than its speed says by no more than this, metres; what does came to the path anew.
const JUMP_M: f64 = 10.0;
/// Backwards no more than this, metres.
const BACK_M: f64 = 5.0;
/// Of the path, so much is shown before and beyond what the ego drove, metres.
const AROUND_M: f64 = 100.0;

/// From one second to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracePiece {
    /// Seconds and metres along the path, of its start and its end.
    pub ends: [[f64; 2]; 2],
    /// Speed at its start, m/s.
    pub speed_mps: f64,
}

/// What a signal on the path showed.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalBar {
    /// Where its line is on the path, metres.
    pub s_m: f64,
    /// From when to when which light, seconds.
    pub spans: Vec<([f64; 2], SignalLight)>,
}

/// All vehicles on the ego's path over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathTraces {
    /// The drive, seconds.
    pub span_s: [f64; 2],
    /// What of the path is shown, metres.
    pub shown_m: [f64; 2],
    /// When positions end, seconds; `None` if they are those of the whole drive.
    pub ends_s: Option<f64>,
    /// The others.
    pub others: Vec<TracePiece>,
    /// The ego.
    pub ego: Vec<TracePiece>,
    /// Signals along the path, in driving order.
    pub signals: Vec<SignalBar>,
    /// Fastest of all that is shown, m/s.
    pub top_speed_mps: f64,
    /// Speed of the ego, advice and mean speed of all.
    pub speeds: SpeedTrace,
}

impl PathTraces {
    /// Reads a drive; `None` where its road is not here any more, or its ego was on its path for less than two seconds.
    ///
    /// # Errors
    /// A table cannot be read, or is not as this program writes it.
    pub fn of(trial: &RecordedTrial) -> Result<Option<Self>, AnalysisError> {
        let Some(map) = &trial.map else { return Ok(None) };
        let mut collector = TraceCollector::new(map);
        for step in trial.steps()? {
            collector.add(&step?);
        }
        let mut traces = collector.finish();
        if traces.ego.is_empty() {
            return Ok(None);
        }
        traces.speeds = speeds(trial)?;
        traces.span_s = traces.speeds.span_s();
        let end_s = traces.ends_s.unwrap_or(traces.span_s[1]);
        traces.signals = signal_bars(trial, map, end_s)?;
        let [low, high] = traces.shown_m;
        traces.signals.retain(|bar| (low..=high).contains(&bar.s_m));
        Ok(Some(traces))
    }
}

/// Speed of the ego, advice and mean speed of all vehicles, ten times a second or less often.
fn speeds(trial: &RecordedTrial) -> Result<SpeedTrace, RecordError> {
    let mut kept = ThinnedValues::new(MOST_SPEEDS);
    for ego in trial.ego()? {
        let ego = ego?;
        if ego.tick.is_multiple_of(SPEED_TICKS) {
            kept.push(ego);
        }
    }
    let mut trace = SpeedTrace::default();
    for ego in kept.values {
        trace.time_s.push(Tick(ego.tick).seconds());
        trace.ego_mps.push(ego.speed_mps);
        trace.shown_mps.push(ego.target_mps);
        trace.mean_mps.push(ego.mean_speed_mps);
    }
    Ok(trace)
}

/// Takes in the steps of a drive.
struct TraceCollector<'a> {
    map: &'a RoadMap,
    /// Edges that the path goes along.
    edges: BTreeSet<EdgeId>,
    /// Who was where at the full second before: seconds, metres, m/s. The ego from its first step on.
    before: BTreeMap<u32, (f64, f64, f64)>,
    /// The ego at the last step on its path that was no full second: seconds and metres.
    ego_last: Option<[f64; 2]>,
    traces: PathTraces,
}

impl<'a> TraceCollector<'a> {
    fn new(map: &'a RoadMap) -> Self {
        let edges = map.route.lanes().iter().filter_map(|lane| map.network.edge_named(&lane.edge)).collect();
        Self { map, edges, before: BTreeMap::new(), ego_last: None, traces: PathTraces::default() }
    }

    fn add(&mut self, step: &TrafficStep) {
        if self.traces.ends_s.is_some() {
            return;
        }
        let time_s = Tick(step.tick).seconds();
        if !step.has_all() {
            self.add_ego(step, time_s);
            return;
        }
        self.ego_last = None;
        let mut here = BTreeMap::new();
        for vehicle in &step.vehicles {
            let Some(s_m) = self.on_path(vehicle) else { continue };
            here.insert(vehicle.id, (time_s, s_m, vehicle.speed_mps));
            if let Some(before) = self.before.get(&vehicle.id).copied() {
                self.piece(vehicle.id == EGO.0, before, [time_s, s_m]);
            }
        }
        self.before = here;
        if time_s >= SHOWN_S || self.traces.others.len() + self.traces.ego.len() >= MOST_PIECES {
            self.traces.ends_s = Some(time_s);
        }
    }

    /// The ego has a row at every step: its line begins with the drive, and goes to its end.
    fn add_ego(&mut self, step: &TrafficStep, time_s: f64) {
        let Some(ego) = step.vehicles.first().filter(|vehicle| vehicle.id == EGO.0) else { return };
        let place = self.on_path(ego);
        self.ego_last = place.map(|s_m| [time_s, s_m]);
        match place {
            Some(s_m) => drop(self.before.entry(EGO.0).or_insert((time_s, s_m, ego.speed_mps))),
            None => drop(self.before.remove(&EGO.0)),
        }
    }

    /// Where a vehicle is on the path; the ego is always told a place along it, and is on it where its lane is one of its edges'.
    fn on_path(&self, vehicle: &StepVehicle) -> Option<f64> {
        let is_beside = || {
            let edge = vehicle.lane.map(|(lane, _)| self.map.network.lane(lane).edge);
            edge.is_none_or(|edge| !self.edges.contains(&edge))
        };
        vehicle.s_m.filter(|_| vehicle.id != EGO.0 || !is_beside())
    }

    fn piece(&mut self, is_ego: bool, (since_s, from_m, speed_mps): (f64, f64, f64), [time_s, to_m]: [f64; 2]) {
        let route = &self.map.route;
        let seconds = time_s - since_s;
        let moved_m = route.difference(from_m, to_m);
        let is_second = (seconds * f64::from(TICKS_PER_S)).round() as u32 == TICKS_PER_S;
        let is_known = is_second || (is_ego && seconds < 1.0);
        if !is_known || moved_m < -BACK_M || moved_m > 2.0 * speed_mps * seconds + JUMP_M {
            return;
        }
        let pieces = if is_ego { &mut self.traces.ego } else { &mut self.traces.others };
        let mut put = |from_m: f64, to_m: f64| {
            pieces.push(TracePiece { ends: [[since_s, from_m], [time_s, to_m]], speed_mps });
        };
        put(from_m, from_m + moved_m);
        // What runs over the end of a closed route comes in again at its beginning.
        if route.is_closed() && from_m + moved_m > route.length_m() {
            put(from_m - route.length_m(), from_m + moved_m - route.length_m());
        }
    }

    fn finish(mut self) -> PathTraces {
        if let (Some(before), Some(last)) = (self.before.get(&EGO.0).copied(), self.ego_last)
            && self.traces.ends_s.is_none()
        {
            self.piece(true, before, last);
        }
        let length_m = self.map.route.length_m();
        let places = || self.traces.ego.iter().flat_map(|piece| piece.ends.map(|end| end[1]));
        let (first, last) = (places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max));
        self.traces.shown_m = if self.map.route.is_closed() {
            [0.0, length_m]
        } else {
            [(first - AROUND_M).max(0.0), (last + AROUND_M).min(length_m)]
        };
        let speeds_mps = self.traces.others.iter().chain(&self.traces.ego).map(|piece| piece.speed_mps);
        self.traces.top_speed_mps = speeds_mps.fold(0.0, f64::max);
        self.traces
    }
}

/// What the signals of the path showed until `end_s`.
fn signal_bars(trial: &RecordedTrial, map: &RoadMap, end_s: f64) -> Result<Vec<SignalBar>, RecordError> {
    let lines = stop_lines(map);
    let path = Table::Signals.parquet(&trial.recording);
    let mut bars: Vec<SignalBar> = lines.iter().map(|line| SignalBar { s_m: line.s_m, spans: Vec::new() }).collect();
    for part in TableReader::parts(&path, &["tick", "signal", "state"])? {
        let part = part?;
        let (ticks, signals, states) = (part.wholes("tick"), part.words("signal"), part.words("state"));
        if [ticks.len(), signals.len(), states.len()] != [part.rows(); 3] {
            return Err(RecordError::Table { path, why: "a column is not as this program writes it".into() });
        }
        for ((tick, signal), state) in ticks.into_iter().zip(signals).zip(states) {
            let time_s = Tick(tick).seconds();
            for (line, bar) in lines.iter().zip(&mut bars) {
                if map.network.signal(line.signal).id != signal {
                    continue;
                }
                let letter = state.as_bytes().get(line.link as usize);
                bar.show(time_s, letter.and_then(|letter| SignalLight::from_letter(*letter)));
            }
        }
    }
    bars.iter_mut().for_each(|bar| bar.end(end_s));
    Ok(bars)
}

impl SignalBar {
    /// From now on it shows this.
    fn show(&mut self, time_s: f64, light: Option<SignalLight>) {
        if let Some(last) = self.spans.last_mut().filter(|last| last.0[1].is_infinite()) {
            if light == Some(last.1) {
                return;
            }
            last.0[1] = time_s;
        }
        self.spans.extend(light.map(|light| ([time_s, f64::INFINITY], light)));
    }

    fn end(&mut self, end_s: f64) {
        self.spans.retain(|span| span.0[0] < end_s);
        self.spans.iter_mut().for_each(|span| span.0[1] = span.0[1].min(end_s));
    }
}

#[cfg(test)]
#[path = "path_traces_tests.rs"]
mod tests;
