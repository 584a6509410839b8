//! Tables of a recording and their columns. Vehicles are in `car_table` and `advised_table`, events in `event_table`, networks
//! in `network_tables`. In: the state of the loop at a tick or a frame. Out: rows. SI units; positions in world axes (x east, y
//! north).

pub use super::advised_table::{ADVISED, AdvisedRow};
pub use super::car_table::{CARS, CarRow, recorded_cars};
pub use super::event_table::{ADVICE_WITHHELD, EVENTS, EventRow, PUT_BACK};
pub use super::network_tables::{ARRIVALS, ArrivalRow, DEPARTURES, DepartureRow, PATH, PathRow, SIGNALS, SignalRow};

use super::{
    Manifest,
    network_tables::NetworkRows,
    table::{ColumnValue, TableColumn},
};
use crate::{
    controls::{Controls, Selector},
    ego::EgoState,
    policy::{Action, Advice},
    sim::Snapshot,
    space::CAR_LENGTH_M,
    time::{TICK_S, Tick},
};
use glam::EulerRot;
use std::path::{Path, PathBuf};

/// Table of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// One row for each tick.
    Ego,
    /// One row for each vehicle and step.
    Cars,
    /// One row for each advice.
    Advice,
    /// One row for each frame.
    Frames,
    /// One row for each event.
    Events,
    /// One row for each vehicle that has entered; only on a network.
    Departures,
    /// One row for each vehicle that has left; only on a network.
    Arrivals,
    /// One row for each signal at the start and for each change; only on a network.
    Signals,
    /// One row for each lane of the ego's path; only on a network.
    Path,
    /// One row for each step and advised vehicle other than the ego; only if there are such vehicles.
    Advised,
}

impl Table {
    /// All tables. Journals identify a table by its index here, so a new one goes to the end.
    pub const ALL: [Self; 10] = [
        Self::Ego,
        Self::Cars,
        Self::Advice,
        Self::Frames,
        Self::Events,
        Self::Departures,
        Self::Arrivals,
        Self::Signals,
        Self::Path,
        Self::Advised,
    ];
    /// Tables of every recording; the others belong to drives on networks or with several advised vehicles.
    pub const OF_EVERY_DRIVE: [Self; 5] = [Self::Ego, Self::Cars, Self::Advice, Self::Frames, Self::Events];
    /// Tables of drives on a network only.
    pub const OF_NETWORKS: [Self; 4] = [Self::Departures, Self::Arrivals, Self::Signals, Self::Path];

    /// Returns the tables that a recording has.
    pub fn of(manifest: &Manifest) -> Vec<Self> {
        let belongs = |table: &Self| match table {
            Self::Advised => manifest.advised_table,
            table => manifest.network_tables || !Self::OF_NETWORKS.contains(table),
        };
        Self::ALL.into_iter().filter(belongs).collect()
    }

    /// Returns the name of the table, as in its file name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ego => "ego",
            Self::Cars => "cars",
            Self::Advice => "advice",
            Self::Frames => "frames",
            Self::Events => "events",
            Self::Departures => "departures",
            Self::Arrivals => "arrivals",
            Self::Signals => "signals",
            Self::Path => "path",
            Self::Advised => "advised",
        }
    }

    /// Returns the path of the table's file in a finished recording.
    pub fn parquet(self, recording: &Path) -> PathBuf {
        recording.join(format!("{}.parquet", self.name()))
    }
}

/// Returns the tick of a row. Every table has a column `tick` except the path, which counts as tick 0.
pub(super) fn tick<R>(columns: &[TableColumn<R>], row: &R) -> Tick {
    let ticks = columns.iter().find(|column| column.name == "tick");
    Tick(ticks.map_or(0, |column| match column.get {
        ColumnValue::Whole(get) => get(row),
        _ => 0,
    }))
}

/// Rows to be written to the disk.
#[derive(Debug, Default)]
pub(super) struct RowBatch {
    pub ego: Vec<EgoRow>,
    pub cars: Vec<CarRow>,
    pub advice: Vec<AdviceRow>,
    pub frames: Vec<FrameRow>,
    pub events: Vec<EventRow>,
    pub network: NetworkRows,
    pub advised: Vec<AdvisedRow>,
}

/// Ego at a tick, with the controls that led to it.
#[derive(Clone, Copy, Debug)]
pub struct EgoRow {
    /// Tick of the row.
    pub tick: Tick,
    /// Hash chain over all snapshots up to this one.
    pub hash: u64,
    /// Controls that the driver gave in this tick.
    pub controls: Controls,
    /// State of the ego; `None` without a participant.
    pub ego: Option<EgoState>,
    /// Acceleration one tick before, m/s2.
    pub accel_before_mps2: f64,
    /// Front bumper along the route, metres.
    pub s_m: f64,
    /// Offset from the lane's centre line, metres, positive to the left.
    pub lane_offset_m: f64,
    /// Vehicle ahead: number, gap in metres, speed in m/s.
    pub leader: Option<(u32, f64, f64)>,
    /// Advice shown on the speedometer.
    pub advice: Option<Advice>,
    /// Mean speed of all vehicles, m/s.
    pub mean_speed_mps: f64,
    /// Torque sent to the wheel's motor, N m, positive to the left; `None` without force feedback.
    pub wheel_force_nm: Option<f64>,
}

impl EgoRow {
    /// Returns the row of a snapshot; `wheel_force_nm` is the torque sent to the wheel's motor.
    pub fn of(snapshot: &Snapshot, controls: &Controls, wheel_force_nm: Option<f64>, hash: u64) -> Self {
        Self {
            tick: snapshot.tick,
            hash,
            controls: *controls,
            ego: (!snapshot.is_without_ego).then_some(snapshot.ego),
            accel_before_mps2: snapshot.ego_before.accel_mps2,
            s_m: snapshot.ego_s_m,
            lane_offset_m: snapshot.lane_offset_m,
            leader: snapshot.leader.map(|l| (l.id.0, l.gap_m, l.speed_mps)),
            advice: snapshot.advice,
            mean_speed_mps: snapshot.mean_speed_mps,
            wheel_force_nm,
        }
    }

    /// Returns the time to collision, s, while the gap closes (SAE J2944: gap over closing speed).
    fn ttc_s(&self) -> Option<f64> {
        let (_, gap_m, leader_mps) = self.leader?;
        let closing_mps = self.ego?.speed_mps - leader_mps;
        (closing_mps > 0.0).then(|| gap_m / closing_mps)
    }

    fn angles(&self) -> Option<[f64; 3]> {
        let (yaw, pitch, roll) = self.ego?.rotation.to_euler(EulerRot::ZYX);
        Some([yaw, pitch, roll].map(f64::from))
    }
}

/// Returns the selector position as a word.
pub fn selector_word(selector: Selector) -> &'static str {
    match selector {
        Selector::Drive => "drive",
        Selector::Neutral => "neutral",
        Selector::Reverse => "reverse",
    }
}

pub(super) const fn number<R>(
    name: &'static str,
    unit: &'static str,
    about: &'static str,
    get: fn(&R) -> Option<f64>,
) -> TableColumn<R> {
    TableColumn { name, unit, about, get: ColumnValue::Number(get) }
}

pub(super) const fn column<R>(
    name: &'static str,
    unit: &'static str,
    about: &'static str,
    get: ColumnValue<R>,
) -> TableColumn<R> {
    TableColumn { name, unit, about, get }
}

/// Columns: one row for each tick (100 Hz). Without a participant the cells of the ego are empty, and the row holds the hash.
pub const EGO: &[TableColumn<EgoRow>] = &[
    column("tick", "", "tick, 10 ms each, since the start of the drive", ColumnValue::Whole(|r| r.tick.0)),
    number("time_s", "s", "time since the start of the drive", |r| Some(r.tick.seconds())),
    column("hash", "", "fingerprint of every snapshot up to this tick", ColumnValue::Whole(|r| r.hash)),
    number(
        "throttle",
        "",
        "accelerator, 0 released to 1 floored, as given: the scenario's extra delay comes after",
        |r| Some(r.controls.throttle.into()),
    ),
    number("brake", "", "brake pedal, 0 released to 1 full force", |r| Some(r.controls.brake.into())),
    number("steering_wheel_rad", "rad", "angle of the steering wheel, positive to the left", |r| {
        Some(r.controls.steering_wheel_rad.into())
    }),
    column(
        "selector",
        "",
        "selector: drive, neutral or reverse",
        ColumnValue::Word(|r| selector_word(r.controls.selector).into()),
    ),
    column(
        "indicator",
        "",
        "indicators as given: off, left or right",
        ColumnValue::Word(|r| r.controls.indicator.name().into()),
    ),
    number("x_m", "m", "centre of the car, to the east", |r| Some(r.ego?.position.x)),
    number("y_m", "m", "centre of the car, to the north", |r| Some(r.ego?.position.y)),
    number("z_m", "m", "centre of the car, up from the ground", |r| Some(r.ego?.position.z)),
    number("yaw_rad", "rad", "heading, 0 east, positive to the left", |r| Some(r.angles()?[0])),
    number("pitch_rad", "rad", "pitch of the body, positive nose down", |r| Some(r.angles()?[1])),
    number("roll_rad", "rad", "roll of the body, positive right side down", |r| Some(r.angles()?[2])),
    number("speed_mps", "m/s", "speed along the car, negative in reverse", |r| Some(r.ego?.speed_mps)),
    number("accel_mps2", "m/s2", "acceleration along the car", |r| Some(r.ego?.accel_mps2)),
    number("lateral_accel_mps2", "m/s2", "acceleration to the left", |r| Some(r.ego?.lateral_accel_mps2)),
    number("jerk_mps3", "m/s3", "change of accel_mps2 since the tick before, over the tick", |r| {
        Some((r.ego?.accel_mps2 - r.accel_before_mps2) / TICK_S)
    }),
    number("yaw_rate_radps", "rad/s", "yaw rate, positive to the left", |r| Some(r.ego?.yaw_rate)),
    number("gear", "", "gear: -1 reverse, 0 neutral, 1.. forwards", |r| Some(r.ego?.gear.into())),
    number("engine_rpm", "1/min", "engine speed", |r| Some(r.ego?.engine_rpm.into())),
    number("steering_torque_nm", "N m", "self-aligning torque at the wheel, positive to the left", |r| {
        Some(r.ego?.steering_torque_nm.into())
    }),
    column("braking", "", "the brake lamps are lit", ColumnValue::Flag(|r| Some(r.ego?.braking))),
    number("s_m", "m", "front bumper along the route", |r| r.ego.map(|_| r.s_m)),
    number("lane_offset_m", "m", "offset of the middle from the lane's middle, positive to the left", |r| {
        r.ego.map(|_| r.lane_offset_m)
    }),
    column("leader", "", "number of the car ahead", ColumnValue::Id(|r| r.leader.map(|l| l.0))),
    number("gap_m", "m", "own front bumper to the leader's rear bumper", |r| r.leader.map(|l| l.1)),
    number("headway_m", "m", "own front bumper to the leader's front bumper (SAE J2944)", |r| {
        r.leader.map(|l| l.1 + CAR_LENGTH_M)
    }),
    number("leader_speed_mps", "m/s", "speed of the leader", |r| r.leader.map(|l| l.2)),
    number("ttc_s", "s", "time to collision, gap over closing speed; empty while the gap does not close", |r| {
        r.ttc_s()
    }),
    number("target_mps", "m/s", "advised speed", |r| r.advice.map(|a| a.target_mps)),
    number("range_low_mps", "m/s", "lower edge of the acceptable range", |r| r.advice.map(|a| a.band_mps().0)),
    number("range_high_mps", "m/s", "upper edge of the acceptable range", |r| r.advice.map(|a| a.band_mps().1)),
    column(
        "in_range",
        "",
        "the speed is in the acceptable range",
        ColumnValue::Flag(|r| Some(r.advice?.accepts(r.ego?.speed_mps))),
    ),
    number("mean_speed_mps", "m/s", "mean speed of all vehicles, the ego included", |r| Some(r.mean_speed_mps)),
    number(
        "wheel_force_nm",
        "N m",
        "torque that the steering wheel's motor was sent, positive to the left; empty where there is no force",
        |r| r.wheel_force_nm,
    ),
];

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
];

fn action(advice: &Advice) -> (&'static str, f64) {
    match advice.action {
        Action::Speed(value) => ("speed", value),
        Action::Acceleration(value) => ("acceleration", value),
    }
}

/// Frame on the screen.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameRow {
    /// Number of the frame, from 0.
    pub frame: u64,
    /// Last tick before the frame.
    pub tick: Tick,
    /// Interpolation between that tick and the next, 0..1.
    pub fraction: f64,
    /// Time at which it was handed to the screen, s of wall time since the first frame.
    pub wall_s: f64,
    /// Time since the previous frame, s.
    pub elapsed_s: f64,
    /// Simulated time dropped because the frame came too late, s.
    pub dropped_s: f64,
    /// Time from the newest input used to the hand-over to the screen, s, if the device reports times.
    pub latency_s: Option<f64>,
    /// Time from that input to the tick that used it, s.
    pub input_to_tick_s: Option<f64>,
    /// True if the square in the corner was white; `None` without a square.
    pub flash: Option<bool>,
}

/// Columns: one row for each frame.
pub const FRAMES: &[TableColumn<FrameRow>] = &[
    column("frame", "", "number of the frame", ColumnValue::Whole(|r| r.frame)),
    column("tick", "", "last tick before it", ColumnValue::Whole(|r| r.tick.0)),
    number("fraction", "", "how far it stands from that tick to the next", |r| Some(r.fraction)),
    number("wall_s", "s", "when it was handed to the screen, wall time since the first frame", |r| Some(r.wall_s)),
    number("elapsed_s", "s", "time since the frame before", |r| Some(r.elapsed_s)),
    number("dropped_s", "s", "simulation that was given up because the frame came too late", |r| Some(r.dropped_s)),
    number("latency_s", "s", "newest input to handing over, where the device tells times", |r| r.latency_s),
    number("input_to_tick_s", "s", "that input to the tick that used it", |r| r.input_to_tick_s),
    column("flash", "", "the square in the corner was white; empty without a square", ColumnValue::Flag(|r| r.flash)),
];

#[cfg(test)]
#[path = "tables_tests.rs"]
mod tests;
