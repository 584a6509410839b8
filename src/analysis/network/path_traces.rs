//! All vehicles on the ego's path over time. In: a [`RecordedTrial`] on a network. Out: [`PathTraces`]: a piece from each full
//! second to the next for each vehicle on the path at both, and the signals along the path. Seconds, metres along the path,
//! m/s.
//!
//! A vehicle is on the path in a lane of the path (as in the simulation: `s_m` of the table of the vehicles). Its trace has a
//! gap where it turns off. The ego's has one where it leaves its path.

use crate::analysis::{
    data::{RecordedTrial, StepVehicle, ThinnedValues, TrafficStep},
    error::AnalysisError,
};
use crate::{
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

/// Largest number of pieces: a picture of more would be gigabytes large, and black.
const MOST_PIECES: usize = 150_000;
/// Longest time for which positions are shown, seconds.
const SHOWN_S: f64 = 3600.0;
/// Largest number of speeds.
const MOST_SPEEDS: usize = 100_000;
/// Interval of the speeds, ticks.
const SPEED_TICKS: u64 = 10;
/// Allowance beyond twice the distance at the current speed, metres; a vehicle that moved farther came to the path anew.
const JUMP_M: f64 = 10.0;
/// Largest move backwards, metres.
const BACK_M: f64 = 5.0;
/// Length of path shown before and beyond the part that the ego drove, metres.
const AROUND_M: f64 = 100.0;

/// Piece of a trace, from one second to the next; at the start and end of the ego's trace also shorter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracePiece {
    /// Start and end: seconds and metres along the path.
    pub ends: [[f64; 2]; 2],
    /// Speed at the start, m/s.
    pub speed_mps: f64,
}

/// Lights of a signal on the path over time.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalBar {
    /// Position of the stop line along the path, metres.
    pub s_m: f64,
    /// Start and end of each light, seconds.
    pub spans: Vec<([f64; 2], SignalLight)>,
}

/// All vehicles on the ego's path over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathTraces {
    /// Start and end of the drive, seconds.
    pub span_s: [f64; 2],
    /// Range of the path that is shown, metres.
    pub shown_m: [f64; 2],
    /// End of the positions, seconds; `None` if they cover the whole drive.
    pub ends_s: Option<f64>,
    /// Pieces of the other vehicles.
    pub others: Vec<TracePiece>,
    /// Pieces of the ego.
    pub ego: Vec<TracePiece>,
    /// Signals along the path, in driving order.
    pub signals: Vec<SignalBar>,
    /// Highest speed of the pieces, m/s.
    pub top_speed_mps: f64,
    /// Speed of the ego, advice and mean speed of all vehicles.
    pub speeds: SpeedTrace,
}

impl PathTraces {
    /// Reads a drive; `None` if its map is missing, or if there is no piece of the ego on its path.
    ///
    /// # Errors
    /// A table cannot be read, or does not have this program's format.
    pub fn of(trial: &RecordedTrial) -> Result<Option<Self>, AnalysisError> {
        let Some(map) = &trial.map else { return Ok(None) };
        let mut collector = PathTraceCollector::new(map);
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

/// Reads the ego's speed, the advice and the mean speed of all vehicles, at most ten times a second.
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

/// Collects traces from the steps of a drive.
struct PathTraceCollector<'a> {
    map: &'a RoadMap,
    /// Edges along the path.
    edges: BTreeSet<EdgeId>,
    /// Time, position (m) and speed (m/s) of each vehicle on the path at the last full second; of the ego from its first step
    /// on.
    before: BTreeMap<u32, (f64, f64, f64)>,
    /// Time and position of the ego at the last step on its path between full seconds.
    ego_last: Option<[f64; 2]>,
    traces: PathTraces,
}

impl<'a> PathTraceCollector<'a> {
    fn new(map: &'a RoadMap) -> Self {
        let lanes = map.route.lanes().iter().filter_map(|lane| lane.lane);
        let edges = lanes.map(|lane| map.network.lane(lane).edge).collect();
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

    /// Follows the ego between full seconds: it has a row at every step, so that its trace starts and ends with the drive.
    fn add_ego(&mut self, step: &TrafficStep, time_s: f64) {
        let Some(ego) = step.vehicles.first().filter(|vehicle| vehicle.id == EGO.0) else { return };
        let place = self.on_path(ego);
        self.ego_last = place.map(|s_m| [time_s, s_m]);
        match place {
            Some(s_m) => drop(self.before.entry(EGO.0).or_insert((time_s, s_m, ego.speed_mps))),
            None => drop(self.before.remove(&EGO.0)),
        }
    }

    /// Returns the position of a vehicle on the path. The ego always has one, but is on the path only in lanes of its edges.
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
        // A piece over the end of a closed route is repeated from its start.
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

/// Reads the lights of the signals on the path until `end_s`.
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
    /// Sets the light from `time_s` on; `None` if it is unknown.
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
