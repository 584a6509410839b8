//! One recorded drive, read from front to back. In: a recording's folder. Out: a [`RecordedTrial`], and its rows one by one: a
//! drive of days takes no more memory than one of minutes. SI units; seconds since the start of the drive.

use super::{
    AnalysisError, DriveSetup,
    driver_moments::FollowingSample,
    events::{AdviceChange, ChangeFinder, DriveOnsets, OnsetFinder},
    network::{RoadEvents, TripTable},
    traffic_steps::TrafficSteps,
};
use crate::{
    map::RoadMap,
    record::{self, RecordError, Table, TableParts, TableReader, tables::PUT_BACK},
    time::{TICKS_PER_S, Tick},
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
    vec::IntoIter,
};

/// Largest number of latencies that are kept: nine hours at 60 Hz. Of a longer drive every second, fourth, ... is kept.
const MOST_LATENCIES: usize = 2_000_000;
/// Time after a contact, or after the car was put back, in which the speed is not the driver's choice, seconds.
pub const AFTER_CONTACT_S: f64 = 2.0;
/// Largest number of contacts, red lights and marks that are listed one by one.
const MOST_MOMENTS: usize = 100;
/// Columns that are read from the ego's table.
const EGO: [&str; 14] = [
    "tick",
    "throttle",
    "brake",
    "steering_wheel_rad",
    "speed_mps",
    "accel_mps2",
    LANE_OFFSET,
    "gap_m",
    "headway_m",
    "ttc_s",
    "target_mps",
    "in_range",
    "mean_speed_mps",
    // Read on networks only, where vehicles differ in length.
    "leader",
];
const LANE_OFFSET: &str = "lane_offset_m";
/// Columns of the ego's table for the fit of the driver.
const FOLLOWING: [&str; 6] = ["tick", "speed_mps", "s_m", "target_mps", "gap_m", "leader_speed_mps"];

/// A recorded drive: short facts in memory, rows on disk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedTrial {
    /// Folder of the recording.
    pub recording: PathBuf,
    /// Setup: manifest, scenario and length of the route.
    pub setup: DriveSetup,
    /// Map of the drive; `None` if it is missing.
    pub map: Option<Arc<RoadMap>>,
    /// First advice of the drive; `None` without advice.
    pub first_advice: Option<IssuedAdvice>,
    /// Changes of the advice.
    pub changes: Vec<AdviceChange>,
    /// Number of contacts with other vehicles.
    pub contacts: usize,
    /// Time, seconds, and closing speed, m/s, of the first contacts.
    pub contacts_at: Vec<[f64; 2]>,
    /// Violations of traffic rules by the ego on a network.
    pub road_events: RoadEvents,
    /// Times of the first red lights that the ego drove over, seconds.
    pub red_lights_at: Vec<f64>,
    /// Times of the first marks of the experimenter, seconds.
    pub marks_at: Vec<f64>,
    /// Spans from a contact, or from a car put back on its lane, to [`AFTER_CONTACT_S`] later, ticks; sorted and disjoint.
    pub after_contacts: Vec<[u64; 2]>,
    /// Number of times that the middle of the car left its lane.
    pub left_road: usize,
    /// Latencies from an input to the frame that showed it, seconds, if the device has time stamps; sorted.
    pub latencies_s: Vec<f64>,
    /// Simulated time given up because frames came too late, seconds; `None` if no frame was shown.
    pub dropped_s: Option<f64>,
    /// Reason of the end, one word.
    pub ended: String,
}

/// Row of the ego at a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EgoSample {
    pub tick: u64,
    /// Accelerator, 0 to 1.
    pub throttle: f64,
    /// Brake pedal, 0 to 1.
    pub brake: f64,
    /// Angle of the steering wheel, radians.
    pub wheel_rad: f64,
    /// Speed of the ego, m/s.
    pub speed_mps: f64,
    /// Acceleration of the ego, m/s2.
    pub accel_mps2: f64,
    /// Offset of the middle of the car from the lane's middle, metres.
    pub lane_offset_m: f64,
    /// Gap to the leader, metres.
    pub gap_m: Option<f64>,
    /// Headway to the leader, metres.
    pub headway_m: Option<f64>,
    /// Time to collision, seconds, while the gap closes.
    pub ttc_s: Option<f64>,
    /// Advised speed, m/s.
    pub target_mps: Option<f64>,
    /// True for a speed in the acceptable range; `None` without advice.
    pub in_range: Option<bool>,
    /// Mean speed of all vehicles, m/s.
    pub mean_speed_mps: f64,
}

/// An advice as the driver could see it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IssuedAdvice {
    /// Tick of the first frame that showed the advice, or of its issue without a screen.
    pub seen_tick: u64,
    /// Advised speed, m/s.
    pub target_mps: f64,
    /// Lower and upper edge of the acceptable range, m/s.
    pub range_mps: [f64; 2],
}

impl RecordedTrial {
    /// Opens a recording.
    ///
    /// # Errors
    /// There is none, it was cut, it does not have this program's format, it has no participant, or its advice changes more
    /// often than [`MOST_CHANGES`](super::events::MOST_CHANGES).
    pub fn open(recording: &Path) -> Result<Self, AnalysisError> {
        let manifest = record::open(recording)?;
        let scenario = record::inputs::scenario(recording).map_err(|e| AnalysisError::Input(e.message))?;
        if !scenario.participant {
            let text = format!(
                "{}: a drive without a participant, and what is analysed is how a participant drives\n  remedy: its tables cars and advised",
                recording.display()
            );
            return Err(AnalysisError::Input(text));
        }
        let map = scenario.load_map().ok().map(Arc::new);
        let route_m = map.as_ref().map_or(0.0, |map| map.route.length_m());
        let mut trial = Self {
            recording: recording.into(),
            ended: manifest.ended.clone().unwrap_or_default(),
            setup: DriveSetup { route_m, manifest, scenario },
            map,
            ..Self::default()
        };
        for part in trial.parts(Table::Events, &["tick", "event", "value"])? {
            let part = part?;
            let rows = part.wholes("tick").into_iter().zip(part.words("event").into_iter().zip(part.numbers("value")));
            for (tick, (kind, value)) in rows {
                trial.contacts += usize::from(kind == "contact");
                trial.left_road += usize::from(kind == "left_road");
                trial.road_events.add(tick, &kind);
                let time_s = Tick(tick).seconds();
                if kind == "contact" || kind == PUT_BACK {
                    trial.collided(tick);
                }
                if kind == "contact" && trial.contacts_at.len() < MOST_MOMENTS {
                    trial.contacts_at.push([time_s, value.unwrap_or_default()]);
                } else if kind == "red_light" && trial.red_lights_at.len() < MOST_MOMENTS {
                    trial.red_lights_at.push(time_s);
                } else if kind == "mark" && trial.marks_at.len() < MOST_MOMENTS {
                    trial.marks_at.push(time_s);
                }
            }
        }
        let mut finder = ChangeFinder::default();
        let mut frames = ShownFrames::open(&trial)?;
        for part in
            trial.parts(Table::Advice, &["tick", "target_mps", "range_low_mps", "range_high_mps", "shown_frame"])?
        {
            for advice in frames.advice(&part?)? {
                trial.first_advice.get_or_insert(advice);
                finder.add(&advice).map_err(|why| {
                    AnalysisError::Input(format!("{}: {why}", Table::Advice.parquet(recording).display()))
                })?;
            }
        }
        trial.changes = finder.changes;
        (trial.latencies_s, trial.dropped_s) = trial.frame_times()?;
        Ok(trial)
    }

    /// Checks for a drive on a network, where vehicles enter and leave.
    pub fn is_on_network(&self) -> bool {
        self.setup.scenario.has_path_or_demand()
    }

    /// Marks a collision: from this tick on, the driver does not choose the speed for [`AFTER_CONTACT_S`].
    pub(super) fn collided(&mut self, tick: u64) {
        let until = tick + (AFTER_CONTACT_S * f64::from(TICKS_PER_S)) as u64;
        match self.after_contacts.last_mut().filter(|last| last[1] >= tick) {
            Some(last) => last[1] = until,
            None => self.after_contacts.push([tick, until]),
        }
    }

    fn parts(&self, table: Table, columns: &[&str]) -> Result<TableParts, RecordError> {
        TableReader::parts(&table.parquet(&self.recording), columns)
    }

    /// Returns the sorted latencies, and the time given up, seconds.
    fn frame_times(&self) -> Result<(Vec<f64>, Option<f64>), RecordError> {
        let (mut kept, mut dropped_s) = (ThinnedValues::new(MOST_LATENCIES), None);
        for part in self.parts(Table::Frames, &["latency_s", "dropped_s"])? {
            let part = part?;
            part.numbers("latency_s").into_iter().flatten().for_each(|latency_s| kept.push(latency_s));
            let dropped = part.numbers("dropped_s").into_iter().flatten();
            dropped.for_each(|one_s| *dropped_s.get_or_insert(0.0) += one_s);
        }
        kept.values.sort_by(f64::total_cmp);
        Ok((kept.values, dropped_s))
    }

    /// Reads the ego's rows at every tick, in order.
    ///
    /// # Errors
    /// The table cannot be read, or does not have this program's format; each row can fail in the same way.
    pub fn ego(&self) -> Result<EgoSamples, RecordError> {
        let path = Table::Ego.parquet(&self.recording);
        let columns = if self.is_on_network() { &EGO[..] } else { &EGO[..EGO.len() - 1] };
        let headways = if !self.is_on_network() {
            Headways::Recorded
        } else {
            let vehicles = TripTable::read(&self.recording)?.trips;
            Headways::ByLength(vehicles.into_iter().filter_map(|(id, trip)| Some((id, trip.length_m?))).collect())
        };
        let parts = TableReader::parts(&path, columns)?;
        Ok(EgoSamples { parts, path, samples: Vec::new().into_iter(), headways })
    }

    /// Returns the onsets of events and changes, and the pedal movements while no event is pending.
    ///
    /// # Errors
    /// The same as for [`RecordedTrial::ego`].
    pub fn onsets(&self) -> Result<DriveOnsets, RecordError> {
        let mut finder = OnsetFinder::new(self.changes.clone());
        for ego in self.ego()? {
            finder.add(&ego?);
        }
        Ok(finder.finish())
    }

    /// Reads the offset from the lane's middle at every tick, metres.
    ///
    /// # Errors
    /// The same as for [`RecordedTrial::ego`].
    pub fn lane_offsets_m(&self) -> Result<impl Iterator<Item = Result<f64, RecordError>>, RecordError> {
        let values = |part: Result<TableReader, RecordError>| {
            let (values, error) =
                part.map_or_else(|error| (Vec::new(), Some(Err(error))), |part| (part.numbers(LANE_OFFSET), None));
            values.into_iter().flatten().map(Ok).chain(error)
        };
        Ok(self.parts(Table::Ego, &[LANE_OFFSET])?.flat_map(values))
    }

    /// Reads the ego's rows for the fit of the driver, at every tick.
    ///
    /// # Errors
    /// The same as for [`RecordedTrial::ego`].
    pub fn following(&self) -> Result<impl Iterator<Item = Result<FollowingSample, RecordError>>, RecordError> {
        let values = |part: Result<TableReader, RecordError>| {
            let (samples, error) =
                part.map_or_else(|error| (Vec::new(), Some(Err(error))), |part| (following_samples(&part), None));
            samples.into_iter().map(Ok).chain(error)
        };
        Ok(self.parts(Table::Ego, &FOLLOWING)?.flat_map(values))
    }

    /// Reads all vehicles with a row, at every step in order.
    ///
    /// # Errors
    /// The table cannot be read; each step can fail in the same way.
    pub fn steps(&self) -> Result<TrafficSteps, RecordError> {
        let map = self.map.as_ref().filter(|_| self.is_on_network());
        TrafficSteps::open(&Table::Cars.parquet(&self.recording), map.map(|map| Arc::clone(&map.network)))
    }
}

/// Evenly spaced values out of many: half of them are dropped whenever there are too many.
#[derive(Debug)]
pub(super) struct ThinnedValues<T> {
    /// Values that are kept, in order: the first, and every `stride`-th after it.
    pub values: Vec<T>,
    most: usize,
    seen: usize,
    /// One in so many values is kept.
    stride: usize,
}

impl<T> ThinnedValues<T> {
    /// Starts a list of at most `most` values.
    pub fn new(most: usize) -> Self {
        Self { values: Vec::new(), most: most.max(1), seen: 0, stride: 1 }
    }

    /// Checks whether the next value is kept for now.
    pub fn takes_next(&self) -> bool {
        self.seen.is_multiple_of(self.stride)
    }

    /// Adds the next value.
    pub fn push(&mut self, value: T) {
        if self.takes_next() {
            self.values.push(value);
        }
        self.seen += 1;
        if self.values.len() > self.most {
            let mut keep = [false, true].into_iter().cycle();
            self.values.retain(|_| keep.next() == Some(false));
            self.stride *= 2;
        }
    }
}

/// Reader of the frames alongside the advices that they showed first; both are in order of time.
struct ShownFrames {
    parts: TableParts,
    frames: IntoIter<(u64, u64)>,
    /// Number and tick of the frame that was read last.
    last: Option<(u64, u64)>,
    seen_tick: u64,
}

impl ShownFrames {
    fn open(trial: &RecordedTrial) -> Result<Self, RecordError> {
        let parts = trial.parts(Table::Frames, &["frame", "tick"])?;
        Ok(Self { parts, frames: Vec::new().into_iter(), last: None, seen_tick: 0 })
    }

    /// Returns the tick of a frame; `None` if it has no row.
    fn tick_of(&mut self, frame: u64) -> Result<Option<u64>, RecordError> {
        while self.last.is_none_or(|last| last.0 < frame) {
            if let Some(next) = self.frames.next() {
                self.last = Some(next);
                continue;
            }
            let Some(part) = self.parts.next().transpose()? else { return Ok(None) };
            self.frames = part.wholes("frame").into_iter().zip(part.wholes("tick")).collect::<Vec<_>>().into_iter();
        }
        Ok(self.last.filter(|last| last.0 == frame).map(|last| last.1))
    }

    /// Returns the advices of a part of their table.
    fn advice(&mut self, part: &TableReader) -> Result<Vec<IssuedAdvice>, RecordError> {
        let (ticks, shown) = (part.wholes("tick"), part.ids("shown_frame"));
        let [targets, lows, highs] = ["target_mps", "range_low_mps", "range_high_mps"].map(|name| part.numbers(name));
        let mut advice = Vec::with_capacity(ticks.len());
        for (i, tick) in ticks.into_iter().enumerate() {
            let frame_tick = match shown.get(i).copied().flatten() {
                Some(frame) => self.tick_of(frame.into())?,
                None => None,
            };
            // A later advice is never seen before an earlier one.
            self.seen_tick = self.seen_tick.max(frame_tick.unwrap_or(tick));
            if let (Some(target_mps), Some(low), Some(high)) = (targets[i], lows[i], highs[i]) {
                advice.push(IssuedAdvice { seen_tick: self.seen_tick, target_mps, range_mps: [low, high] });
            }
        }
        Ok(advice)
    }
}

/// Iterator over the ego's rows, tick by tick.
pub struct EgoSamples {
    path: PathBuf,
    parts: TableParts,
    samples: IntoIter<EgoSample>,
    headways: Headways,
}

/// Source of the headway to the leader.
enum Headways {
    /// From the table, which adds the length of a car to the gap: on closed routes all vehicles are cars.
    Recorded,
    /// From the gap and the leader's length, metres by vehicle number: on a network.
    ByLength(BTreeMap<u32, f64>),
}

impl Headways {
    /// Returns the headway to each row's leader, metres.
    fn of(&self, part: &TableReader, gap_m: &[Option<f64>]) -> Vec<Option<f64>> {
        let Self::ByLength(lengths_m) = self else { return part.numbers("headway_m") };
        let leaders = part.ids("leader");
        let headway_m = |(i, gap_m): (usize, &Option<f64>)| {
            let leader = leaders.get(i).copied().flatten()?;
            Some((*gap_m)? + lengths_m.get(&leader)?)
        };
        gap_m.iter().enumerate().map(headway_m).collect()
    }
}

impl Iterator for EgoSamples {
    type Item = Result<EgoSample, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(sample) = self.samples.next() {
                return Some(Ok(sample));
            }
            let part = match self.parts.next()? {
                Ok(part) => part,
                Err(error) => return Some(Err(error)),
            };
            match samples(&part, &self.headways) {
                Ok(samples) => self.samples = samples.into_iter(),
                Err(column) => {
                    let why = format!("column {column} is not as this program writes it");
                    return Some(Err(RecordError::Table { path: self.path.clone(), why }));
                }
            }
        }
    }
}

/// Returns the rows of a part of the ego's table, or the name of a column that is missing or has gaps.
fn samples(part: &TableReader, headways: &Headways) -> Result<Vec<EgoSample>, &'static str> {
    let whole = |name: &'static str| part.numbers(name).into_iter().collect::<Option<Vec<f64>>>().ok_or(name);
    let (tick, in_range) = (part.wholes("tick"), part.flags("in_range"));
    if tick.len() != part.rows() {
        return Err("tick");
    }
    if in_range.len() != part.rows() {
        return Err("in_range");
    }
    let [throttle, brake, wheel_rad] = [whole("throttle")?, whole("brake")?, whole("steering_wheel_rad")?];
    let [speed_mps, accel_mps2, lane_offset_m] = [whole("speed_mps")?, whole("accel_mps2")?, whole(LANE_OFFSET)?];
    let mean_speed_mps = whole("mean_speed_mps")?;
    let [gap_m, ttc_s, target_mps] = ["gap_m", "ttc_s", "target_mps"].map(|name| part.numbers(name));
    let headway_m = headways.of(part, &gap_m);
    // Where lanes of a network join, the next vehicle on the path may be beside the ego (a gap below 0): it is not a leader.
    let is_beside = |i: usize| matches!(headways, Headways::ByLength(_)) && gap_m[i].is_some_and(|gap_m| gap_m < 0.0);
    let of_leader = |values: &[Option<f64>], i: usize| values[i].filter(|_| !is_beside(i));
    let sample = |i: usize| EgoSample {
        tick: tick[i],
        throttle: throttle[i],
        brake: brake[i],
        wheel_rad: wheel_rad[i],
        speed_mps: speed_mps[i],
        accel_mps2: accel_mps2[i],
        lane_offset_m: lane_offset_m[i],
        gap_m: of_leader(&gap_m, i),
        headway_m: of_leader(&headway_m, i),
        ttc_s: of_leader(&ttc_s, i),
        target_mps: target_mps[i],
        in_range: in_range[i],
        mean_speed_mps: mean_speed_mps[i],
    };
    Ok((0..part.rows()).map(sample).collect())
}

/// Returns the rows of a part of the ego's table that have a speed and a position.
fn following_samples(part: &TableReader) -> Vec<FollowingSample> {
    let ticks = part.wholes("tick");
    let [speeds, places, targets, gaps, leaders] = [1, 2, 3, 4, 5].map(|k| part.numbers(FOLLOWING[k]));
    let sample = |i: usize| {
        Some(FollowingSample {
            tick: ticks[i],
            speed_mps: (*speeds.get(i)?)?,
            s_m: (*places.get(i)?)?,
            advised_mps: targets.get(i).copied().flatten(),
            leader: gaps.get(i).copied().flatten().zip(leaders.get(i).copied().flatten()).map(<[f64; 2]>::from),
        })
    };
    (0..ticks.len()).filter_map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinned_values_are_evenly_spaced_and_never_exceed_the_limit() {
        let mut kept = ThinnedValues::new(100);
        for value in 0..100 {
            kept.push(value);
        }
        assert_eq!(kept.values, (0..100).collect::<Vec<_>>(), "few are kept all");
        for value in 100..1_000_000 {
            kept.push(value);
            assert!(kept.values.len() <= 100);
        }
        let stride = kept.values[1];
        assert!(kept.values.len() > 50 && kept.values.iter().enumerate().all(|(i, value)| *value == i as i32 * stride));
        assert!(kept.values[kept.values.len() - 1] > 1_000_000 - 2 * stride, "to the end");
    }
}
