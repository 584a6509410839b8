//! The ego's motion for BIDS (Motion-BIDS [Jeung 2024]): a table without a header line, one row per tick. In: a recording. Out:
//! `_motion.tsv`, the description of its channels, and their frames of reference.
//!
//! Every row was recorded, and no recorded row is left out. Ticks missing from a recording show as a step in the channel `latency`.

use super::event_table::onset;
use crate::{
    record::{self, RecordError, Table, TableReader},
    time::TICK_S,
};
use serde_json::{Value, json};
use std::{io::Write, path::Path};

/// Name of the tracking system in file names.
pub(super) const TRACKING_SYSTEM: &str = "codrive";
/// Sidecar of all tables of channels, at the top of a data set.
pub(super) const CHANNELS_JSON: &str = "tracksys-codrive_channels.json";
/// Frames of reference: the map's, the ego's own, none.
const WORLD: &str = "world";
const CAR: &str = "car";
const NONE: &str = "n/a";

/// Channel: one column of the table.
struct MotionChannel {
    name: &'static str,
    component: &'static str,
    kind: &'static str,
    tracked_point: &'static str,
    units: &'static str,
    reference_frame: &'static str,
    about: &'static str,
    /// Column of the recording; empty for the time.
    source: &'static str,
    /// Digits after the decimal point, finer than the precision of the simulation. The recording has all digits.
    digits: i32,
}

const fn channel(
    [name, component, kind, tracked_point, units, reference_frame]: [&'static str; 6],
    about: &'static str,
    source: &'static str,
    digits: i32,
) -> MotionChannel {
    MotionChannel { name, component, kind, tracked_point, units, reference_frame, about, source, digits }
}

/// All channels, in the order of the columns. Types and components are BIDS terms; units follow CMIXF.
const CHANNELS: [MotionChannel; 14] = [
    channel(["latency", NONE, "LATENCY", NONE, "s", NONE], "simulation time since the first sample", "", 2),
    channel(["position_x", "x", "POS", "car", "m", WORLD], "centre of the vehicle, to the east", "x_m", 4),
    channel(["position_y", "y", "POS", "car", "m", WORLD], "centre of the vehicle, to the north", "y_m", 4),
    channel(["position_z", "z", "POS", "car", "m", WORLD], "centre of the vehicle, up from the ground", "z_m", 4),
    channel(["roll", "x", "ORNT", "car", "rad", WORLD], "roll of the body, positive right side down", "roll_rad", 6),
    channel(["pitch", "y", "ORNT", "car", "rad", WORLD], "pitch of the body, positive nose down", "pitch_rad", 6),
    channel(["yaw", "z", "ORNT", "car", "rad", WORLD], "heading, 0 east, positive to the left", "yaw_rad", 6),
    channel(["speed", "x", "VEL", "car", "m/s", CAR], "speed along the vehicle, negative in reverse", "speed_mps", 4),
    channel(["acceleration_x", "x", "ACCEL", "car", "m/s^2", CAR], "acceleration along the vehicle", "accel_mps2", 4),
    channel(["acceleration_y", "y", "ACCEL", "car", "m/s^2", CAR], "acceleration to the left", "lateral_accel_mps2", 4),
    channel(["yaw_rate", "z", "GYRO", "car", "rad/s", WORLD], "yaw rate, positive to the left", "yaw_rate_radps", 6),
    channel(
        ["accelerator", NONE, "MISC", "accelerator_pedal", NONE, NONE],
        "accelerator, 0 released to 1 floored",
        "throttle",
        4,
    ),
    channel(["brake", NONE, "MISC", "brake_pedal", NONE, NONE], "brake pedal, 0 released to 1 full force", "brake", 4),
    channel(
        ["steering_angle", NONE, "MISC", "steering_wheel", "rad", NONE],
        "angle of the steering wheel, positive to the left",
        "steering_wheel_rad",
        5,
    ),
];

/// Range of ticks in a table of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MotionSpan {
    /// Number of rows, one per tick.
    pub samples: u64,
    /// Tick of the first row.
    pub first: u64,
    /// Tick of the last row.
    pub last: u64,
}

impl MotionSpan {
    /// Returns the samples per second over the whole span, lost ticks included in the time; `None` for a single sample.
    fn effective_hz(self) -> Option<f64> {
        let duration_s = (self.last - self.first) as f64 * TICK_S;
        (self.samples > 1).then(|| ((self.samples - 1) as f64 / duration_s * 1e6).round() / 1e6)
    }
}

/// Writes the motion of a recorded drive to `path`, part by part. Returns `None` and writes no file for a drive without a tick.
///
/// # Errors
/// The recording cannot be read, or the file cannot be written.
pub(super) fn write(recording: &Path, path: &Path) -> Result<Option<MotionSpan>, RecordError> {
    let columns: Vec<&str> = std::iter::once("tick").chain(CHANNELS.iter().map(|c| c.source)).collect();
    let mut parts = TableReader::parts(&Table::Ego.parquet(recording), &columns)?.peekable();
    let has_rows = |part: &Result<TableReader, RecordError>| part.as_ref().map_or(true, |part| part.rows() > 0);
    while parts.peek().is_some_and(|part| !has_rows(part)) {
        parts.next();
    }
    if parts.peek().is_none() {
        return Ok(None);
    }
    let mut span: Option<MotionSpan> = None;
    record::replace_streaming(path, |out| {
        for part in parts {
            write_part(&part?, &mut span, out).map_err(|why| RecordError::File { path: path.into(), why })?;
        }
        Ok(())
    })?;
    Ok(span)
}

fn write_part(part: &TableReader, span: &mut Option<MotionSpan>, out: &mut dyn Write) -> std::io::Result<()> {
    let values: Vec<(f64, Vec<Option<f64>>)> =
        CHANNELS[1..].iter().map(|c| (10f64.powi(c.digits), part.numbers(c.source))).collect();
    for (row, tick) in part.wholes("tick").into_iter().enumerate() {
        let span = span.get_or_insert(MotionSpan { samples: 0, first: tick, last: tick });
        (span.samples, span.last) = (span.samples + 1, tick);
        out.write_all(onset(tick, span.first).as_bytes())?;
        for (scale, column) in &values {
            match column[row].filter(|value| value.is_finite()) {
                // Adding zero turns minus zero into zero.
                Some(value) => write!(out, "\t{}", (value * scale).round() / scale + 0.0)?,
                None => out.write_all(b"\tn/a")?,
            }
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// Returns the sidecar of a table of motion: the `facts` of its task, and how it was sampled.
pub(super) fn sidecar(span: MotionSpan, mut facts: Value) -> Value {
    let count = |kind: &str| CHANNELS.iter().filter(|c| c.kind == kind).count();
    let mut points: Vec<&str> = CHANNELS.iter().map(|c| c.tracked_point).filter(|point| *point != NONE).collect();
    points.sort_unstable();
    points.dedup();
    let nominal_hz = (1.0 / TICK_S).round();
    let more = json!({
        "SamplingFrequency": nominal_hz,
        "SamplingFrequencyEffective": span.effective_hz().unwrap_or(nominal_hz),
        "RecordingDuration": span.samples as f64 / nominal_hz,
        "TrackingSystemName": TRACKING_SYSTEM,
        "Manufacturer": "codrive",
        "ManufacturersModelName": "codrive",
        "SoftwareVersions": env!("CARGO_PKG_VERSION"),
        "TrackedPointsCount": points.len(),
        "MotionChannelCount": CHANNELS.len(),
        "POSChannelCount": count("POS"),
        "ORNTChannelCount": count("ORNT"),
        "VELChannelCount": count("VEL"),
        "ACCELChannelCount": count("ACCEL"),
        "ANGACCELChannelCount": count("ANGACCEL"),
        "GYROChannelCount": count("GYRO"),
        "JNTANGChannelCount": count("JNTANG"),
        "MAGNChannelCount": count("MAGN"),
        "LATENCYChannelCount": count("LATENCY"),
        "MISCChannelCount": count("MISC"),
        "MissingValues": NONE,
        // A simulated vehicle has no artefacts of a body.
        "SubjectArtefactDescription": NONE,
    });
    if let (Some(facts), Value::Object(more)) = (facts.as_object_mut(), more) {
        facts.extend(more);
    }
    facts
}

/// Returns the table of channels, `_channels.tsv`.
pub(super) fn channels() -> String {
    let head = "name\tcomponent\ttype\ttracked_point\tunits\treference_frame\tdescription\n".to_owned();
    CHANNELS.iter().fold(head, |table, c| {
        let cells = [c.name, c.component, c.kind, c.tracked_point, c.units, c.reference_frame, c.about];
        table + &cells.join("\t") + "\n"
    })
}

/// Returns the sidecar of all tables of channels, which describes the frames of reference.
pub(super) fn reference_frames() -> String {
    // Rotations about fixed axes: roll first, then pitch, then yaw.
    let frame = |about: &str| json!({ "SpatialAxes": "ALS", "RotationOrder": "XYZ", "RotationRule": "right-hand", "Description": about });
    let world = "frame of the road network: x east, y north, z up from the ground, metres of the simulated world; \
        origin of the map. A vehicle of heading 0 points along x; its axes are then ahead, left and up";
    let car = "frame that moves with the vehicle and turns with its heading: x ahead, y to the left, z up";
    let frames = json!({
        "reference_frame": {
            "Description": "frame of reference of the channel; n/a for channels without one",
            "Levels": { WORLD: frame(world), CAR: frame(car) },
        },
    });
    format!("{frames:#}\n")
}

#[cfg(test)]
#[path = "motion_tests.rs"]
mod tests;
