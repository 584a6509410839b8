//! The ego's table, tick by tick. In: the table of a recording. Out: an [`EgoSample`] per tick. SI units.

use crate::record::{RecordError, TableParts, TableReader};
use std::{collections::BTreeMap, path::PathBuf, vec::IntoIter};

/// Columns that are read from the ego's table.
pub(super) const EGO: [&str; 16] = [
    "tick",
    "throttle",
    "brake",
    "steering_wheel_rad",
    "speed_mps",
    "accel_mps2",
    "lane_offset_m",
    "gap_m",
    "headway_m",
    "ttc_s",
    "target_mps",
    "in_range",
    "mean_speed_mps",
    "s_m",
    "leader_speed_mps",
    "leader",
];

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
    /// Position of the front bumper along the route, metres.
    pub s_m: Option<f64>,
    /// Speed of the leader, m/s.
    pub leader_speed_mps: Option<f64>,
}

/// Iterator over the ego's rows, tick by tick.
pub struct EgoSamples {
    path: PathBuf,
    parts: TableParts,
    samples: IntoIter<EgoSample>,
    lengths_m: Option<LengthsM>,
}

/// Lengths of vehicles by their numbers, metres.
pub(super) type LengthsM = BTreeMap<u32, f64>;

/// Returns the headway to each row's leader, metres: from the gap and the leader's length. Without lengths all vehicles are cars, whose
/// length the table adds to the gap.
fn headways_m(part: &TableReader, gap_m: &[Option<f64>], lengths_m: Option<&LengthsM>) -> Vec<Option<f64>> {
    let Some(lengths_m) = lengths_m else { return part.numbers("headway_m") };
    let leaders = part.ids("leader");
    let headway_m = |(i, gap_m): (usize, &Option<f64>)| {
        let leader = leaders.get(i).copied().flatten()?;
        Some((*gap_m)? + lengths_m.get(&leader)?)
    };
    gap_m.iter().enumerate().map(headway_m).collect()
}

impl EgoSamples {
    /// Starts with the parts of the table at `path`, and the lengths of vehicles that are no cars.
    pub(super) fn new(path: PathBuf, parts: TableParts, lengths_m: Option<LengthsM>) -> Self {
        Self { path, parts, samples: Vec::new().into_iter(), lengths_m }
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
            match samples(&part, self.lengths_m.as_ref()) {
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
fn samples(part: &TableReader, lengths_m: Option<&LengthsM>) -> Result<Vec<EgoSample>, &'static str> {
    let whole = |name: &'static str| part.numbers(name).into_iter().collect::<Option<Vec<f64>>>().ok_or(name);
    let (tick, in_range) = (part.wholes("tick"), part.flags("in_range"));
    if tick.len() != part.rows() {
        return Err("tick");
    }
    if in_range.len() != part.rows() {
        return Err("in_range");
    }
    let [throttle, brake, wheel_rad] = [whole("throttle")?, whole("brake")?, whole("steering_wheel_rad")?];
    let [speed_mps, accel_mps2, lane_offset_m] = [whole("speed_mps")?, whole("accel_mps2")?, whole("lane_offset_m")?];
    let mean_speed_mps = whole("mean_speed_mps")?;
    let [gap_m, ttc_s, target_mps] = ["gap_m", "ttc_s", "target_mps"].map(|name| part.numbers(name));
    let [s_m, leader_speed_mps] = ["s_m", "leader_speed_mps"].map(|name| part.numbers(name));
    let headway_m = headways_m(part, &gap_m, lengths_m);
    // Where lanes of a network join, the next vehicle on the path may be beside the ego (a gap below 0): it is not a leader.
    let is_beside = |i: usize| lengths_m.is_some() && gap_m[i].is_some_and(|gap_m| gap_m < 0.0);
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
        s_m: s_m[i],
        leader_speed_mps: leader_speed_mps[i],
    };
    Ok((0..part.rows()).map(sample).collect())
}
