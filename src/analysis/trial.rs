//! One recorded drive as columns. In: a recording's folder. Out: a [`Trial`]. SI units; seconds since the start of the
//! drive.

use super::AnalysisError;
use crate::{
    map::RoadMap,
    record::{self, Reader, RecordError, Table},
    time::Tick,
};
use std::path::Path;

/// A drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trial {
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Length of the closed route, metres; 0 if its map is not here any more.
    pub route_m: f64,
    /// Rows of the ego, one a tick.
    pub ego: Ego,
    /// All cars at each step, the ego first.
    pub steps: Vec<Step>,
    /// Advice as it was issued.
    pub advice: Vec<Issued>,
    /// Contacts with other cars.
    pub contacts: usize,
    /// How often the middle of the car left its lane.
    pub left_road: usize,
    /// From an input to the frame that showed it, seconds, where the device told times.
    pub latencies_s: Vec<f64>,
    /// How the drive ended, a word.
    pub ended: String,
}

/// Columns of the ego. All are equally long.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ego {
    /// When.
    pub tick: Vec<u64>,
    /// Accelerator, 0 to 1.
    pub throttle: Vec<f64>,
    /// Brake pedal, 0 to 1.
    pub brake: Vec<f64>,
    /// Angle of the steering wheel, radians.
    pub wheel_rad: Vec<f64>,
    /// Speed, m/s.
    pub speed_mps: Vec<f64>,
    /// Acceleration, m/s2.
    pub accel_mps2: Vec<f64>,
    /// Offset of the middle of the car from the lane's middle, metres.
    pub lane_offset_m: Vec<f64>,
    /// Gap to the leader, metres.
    pub gap_m: Vec<Option<f64>>,
    /// Headway to the leader, metres.
    pub headway_m: Vec<Option<f64>>,
    /// Time to collision, seconds, while the gap closes.
    pub ttc_s: Vec<Option<f64>>,
    /// Advised speed, m/s.
    pub target_mps: Vec<Option<f64>>,
    /// Speed in the acceptable range.
    pub in_range: Vec<Option<bool>>,
    /// Mean speed of all vehicles, m/s.
    pub mean_speed_mps: Vec<f64>,
}

/// All cars at the end of a step, the ego first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Step {
    /// When.
    pub tick: u64,
    /// Front bumpers along the route, metres.
    pub s_m: Vec<f64>,
    /// Speeds, m/s.
    pub speed_mps: Vec<f64>,
}

/// An advice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Issued {
    /// When it was issued.
    pub tick: u64,
    /// When it could be seen: the tick of the first frame that showed it, or that of its issue where there was no screen.
    pub seen_tick: u64,
    /// Advised speed, m/s.
    pub target_mps: f64,
    /// Edges of the acceptable range, m/s.
    pub range_mps: [f64; 2],
}

impl Trial {
    /// Reads a recording.
    ///
    /// # Errors
    /// There is none, it was cut, or it is not as this program writes it.
    pub fn load(recording: &Path) -> Result<Self, AnalysisError> {
        let manifest = record::open(recording)?;
        let scenario = record::inputs::scenario(recording).map_err(|e| AnalysisError::Input(e.0))?;
        let read = |table: Table| Reader::parquet(&table.parquet(recording));
        let (ego, cars, advice) = (read(Table::Ego)?, read(Table::Cars)?, read(Table::Advice)?);
        let (frames, events) = (read(Table::Frames)?, read(Table::Events)?);
        let kinds = events.words("event");
        let count = |word: &str| kinds.iter().filter(|kind| *kind == word).count();
        Ok(Self {
            step_s: scenario.step_s,
            route_m: RoadMap::load(&scenario.map).map_or(0.0, |map| map.route.length_m()),
            ego: Ego::of(&ego).map_err(|column| RecordError::Table {
                path: Table::Ego.parquet(recording),
                why: format!("column {column} is not as this program writes it"),
            })?,
            steps: steps(&cars),
            advice: issued(&advice, &frames),
            contacts: count("contact"),
            left_road: count("left_road"),
            latencies_s: frames.numbers("latency_s").into_iter().flatten().collect(),
            ended: manifest.ended.unwrap_or_default(),
        })
    }

    /// Length of the drive, seconds.
    pub fn duration_s(&self) -> f64 {
        self.ego.tick.last().map_or(0.0, |tick| Tick(*tick).seconds())
    }
}

impl Ego {
    /// The columns of a table, or the name of one that is missing or has holes.
    fn of(table: &Reader) -> Result<Self, &'static str> {
        let whole = |name: &'static str| table.numbers(name).into_iter().collect::<Option<Vec<f64>>>().ok_or(name);
        let tick = table.wholes("tick");
        let in_range = table.flags("in_range");
        if tick.len() != table.rows() {
            return Err("tick");
        }
        if in_range.len() != table.rows() {
            return Err("in_range");
        }
        Ok(Self {
            tick,
            throttle: whole("throttle")?,
            brake: whole("brake")?,
            wheel_rad: whole("steering_wheel_rad")?,
            speed_mps: whole("speed_mps")?,
            accel_mps2: whole("accel_mps2")?,
            lane_offset_m: whole("lane_offset_m")?,
            gap_m: table.numbers("gap_m"),
            headway_m: table.numbers("headway_m"),
            ttc_s: table.numbers("ttc_s"),
            target_mps: table.numbers("target_mps"),
            in_range,
            mean_speed_mps: whole("mean_speed_mps")?,
        })
    }
}

/// Rows of one tick become a step; they stand one after the other in the table.
fn steps(cars: &Reader) -> Vec<Step> {
    let (ticks, places, speeds) = (cars.wholes("tick"), cars.numbers("s_m"), cars.numbers("speed_mps"));
    let mut steps: Vec<Step> = Vec::new();
    for (i, tick) in ticks.into_iter().enumerate() {
        if steps.last().is_none_or(|step| step.tick != tick) {
            steps.push(Step { tick, ..Step::default() });
        }
        if let (Some(step), Some(s_m), Some(speed_mps)) = (steps.last_mut(), places[i], speeds[i]) {
            step.s_m.push(s_m);
            step.speed_mps.push(speed_mps);
        }
    }
    steps
}

fn issued(advice: &Reader, frames: &Reader) -> Vec<Issued> {
    let (ticks, shown) = (advice.wholes("tick"), advice.ids("shown_frame"));
    let columns = ["target_mps", "range_low_mps", "range_high_mps"].map(|name| advice.numbers(name));
    let (numbers, frame_ticks) = (frames.wholes("frame"), frames.wholes("tick"));
    let tick_of = |frame: u32| {
        let at = numbers.binary_search(&frame.into()).ok()?;
        frame_ticks.get(at).copied()
    };
    let row = |i: usize| {
        let tick = ticks[i];
        Some(Issued {
            tick,
            seen_tick: shown.get(i).copied().flatten().and_then(tick_of).unwrap_or(tick),
            target_mps: columns[0][i]?,
            range_mps: [columns[1][i]?, columns[2][i]?],
        })
    };
    (0..ticks.len()).filter_map(row).collect()
}
