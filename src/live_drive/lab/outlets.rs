//! The drive's own LSL streams. In: rows as they are recorded, with the times of their events. Out: samples on the
//! network.
//!
//! ```text
//! codrive.advice    as it is issued: advised speed, range, hold; empty numbers (NaN) when advice is withheld
//! codrive.events    as they happen: kind and details, as text
//! codrive.controls  each tick, 100 Hz: pedals, steering wheel, selector
//! codrive.ego       each tick, 100 Hz: position, motion, gap
//! codrive.frames    each frame, when it was handed to the screen
//! ```
//! Ego and controls come each tick, not each step: that is what is recorded, an analysis of braking needs it, and a
//! sample costs only some microseconds.

use crate::{
    controls::Selector,
    lsl::{Channel, ChannelFormat, LslError, LslSettings, Outlet, OutletInterface, StreamDescription},
    record::{
        table::{ColumnValue, TableColumn},
        tables::{ADVICE, ADVICE_WITHHELD, AdviceRow, EGO, EgoRow, EventRow, FRAMES, FrameRow},
    },
    time::TICKS_PER_S,
};
use std::hash::{BuildHasher, RandomState};

const ADVICE_COLUMNS: [&str; 5] = ["tick", "target_mps", "range_low_mps", "range_high_mps", "hold_s"];
const CONTROL_COLUMNS: [&str; 5] = ["tick", "time_s", "throttle", "brake", "steering_wheel_rad"];
const EGO_COLUMNS: [&str; 14] = [
    "tick",
    "time_s",
    "x_m",
    "y_m",
    "z_m",
    "yaw_rad",
    "speed_mps",
    "accel_mps2",
    "lateral_accel_mps2",
    "yaw_rate_radps",
    "s_m",
    "lane_offset_m",
    "gap_m",
    "leader_speed_mps",
];
const FRAME_COLUMNS: [&str; 7] = ["frame", "tick", "fraction", "wall_s", "elapsed_s", "dropped_s", "flash"];

/// Columns of a table, in the order of a stream's channels.
struct Columns<R: 'static>(Vec<&'static TableColumn<R>>);

impl<R> Columns<R> {
    fn of(table: &'static [TableColumn<R>], names: &[&str]) -> Self {
        Self(names.iter().filter_map(|name| table.iter().find(|column| column.name == *name)).collect())
    }

    fn channels(&self) -> Vec<Channel> {
        let channel = |column: &&TableColumn<R>| Channel {
            label: column.name.into(),
            unit: column.unit.into(),
            about: column.about.into(),
        };
        self.0.iter().map(channel).collect()
    }

    fn values(&self, row: &R) -> Vec<f64> {
        let value = |column: &&TableColumn<R>| match column.get {
            ColumnValue::Number(get) => get(row).unwrap_or(f64::NAN),
            ColumnValue::Whole(get) => get(row) as f64,
            ColumnValue::Id(get) => get(row).map_or(f64::NAN, f64::from),
            ColumnValue::Flag(get) => get(row).map_or(f64::NAN, |flag| f64::from(u8::from(flag))),
            ColumnValue::Word(_) => f64::NAN,
        };
        self.0.iter().map(value).collect()
    }
}

/// Open streams of a drive.
pub struct DriveOutlets {
    advice: (Outlet, Columns<AdviceRow>),
    events: Outlet,
    controls: (Outlet, Columns<EgoRow>),
    ego: (Outlet, Columns<EgoRow>),
    frames: (Outlet, Columns<FrameRow>),
    /// First error of a push that has not been taken yet.
    trouble: Option<LslError>,
    is_told: bool,
}

impl DriveOutlets {
    /// Opens the streams on the interface in the settings. Their ids end in the settings' `source`, or in a random
    /// number, and reveal nothing about the participant.
    ///
    /// # Errors
    /// liblsl is missing, or refuses a stream.
    pub fn open(settings: &LslSettings) -> Result<Self, LslError> {
        let interface = OutletInterface::of(&settings.interface);
        let random = || format!("{:016x}", RandomState::new().hash_one(std::process::id()));
        let source = if settings.source.is_empty() { random() } else { settings.source.clone() };
        let outlet = |name: &str, content: &str, rate_hz: f64, format, channels: Vec<Channel>| {
            let description = StreamDescription {
                name: format!("codrive.{name}"),
                content: content.into(),
                rate_hz,
                format,
                source_id: format!("codrive.{name}.{source}"),
                channels,
            };
            Outlet::open(description, &interface)
        };
        let numbers = ChannelFormat::Numbers;
        let tick_hz = f64::from(TICKS_PER_S);
        let advice = Columns::of(ADVICE, &ADVICE_COLUMNS);
        let controls = Columns::of(EGO, &CONTROL_COLUMNS);
        let ego = Columns::of(EGO, &EGO_COLUMNS);
        let frames = Columns::of(FRAMES, &FRAME_COLUMNS);
        let mut control_channels = controls.channels();
        let about = "1 drive, 0 neutral, -1 reverse";
        control_channels.push(Channel { label: "selector".into(), unit: String::new(), about: about.into() });
        let word =
            |label: &str, about: &str| Channel { label: label.into(), about: about.into(), ..Channel::default() };
        let words = vec![word("event", "kind of event, a word"), word("detail", "details as text")];
        Ok(Self {
            advice: (outlet("advice", "Advice", 0.0, numbers, advice.channels())?, advice),
            events: outlet("events", "Markers", 0.0, ChannelFormat::Texts, words)?,
            controls: (outlet("controls", "Controls", tick_hz, numbers, control_channels)?, controls),
            ego: (outlet("ego", "Vehicle", tick_hz, numbers, ego.channels())?, ego),
            frames: (outlet("frames", "Frames", 0.0, numbers, frames.channels())?, frames),
            trouble: None,
            is_told: false,
        })
    }

    /// Sends the row of a tick that was due at `stamp_s`.
    pub fn tick(&mut self, row: &EgoRow, stamp_s: f64) {
        let (outlet, columns) = &self.ego;
        let ego = outlet.push(&columns.values(row), stamp_s);
        let (outlet, columns) = &self.controls;
        let mut values = columns.values(row);
        values.push(match row.controls.selector {
            Selector::Drive => 1.0,
            Selector::Neutral => 0.0,
            Selector::Reverse => -1.0,
        });
        let pushed = ego.and(outlet.push(&values, stamp_s));
        self.note(pushed);
    }

    /// Sends an advice that was issued at `stamp_s`.
    pub fn advice(&mut self, row: &AdviceRow, stamp_s: f64) {
        let (outlet, columns) = &self.advice;
        let pushed = outlet.push(&columns.values(row), stamp_s);
        self.note(pushed);
    }

    /// Sends an event of the world; withheld advice also goes to the advice stream.
    pub fn event(&mut self, row: &EventRow, stamp_s: f64) {
        if row.kind == ADVICE_WITHHELD {
            let mut values = [f64::NAN; ADVICE_COLUMNS.len()];
            values[0] = row.tick.0 as f64;
            let pushed = self.advice.0.push(&values, stamp_s);
            self.note(pushed);
        }
        self.announce(&row.kind, &row.detail, stamp_s);
    }

    /// Sends an event from outside the world.
    pub fn announce(&mut self, kind: &str, detail: &str, stamp_s: f64) {
        let pushed = self.events.push_texts(&[kind, detail], stamp_s);
        self.note(pushed);
    }

    /// Sends a frame that was handed to the screen at `stamp_s`.
    pub fn frame(&mut self, row: &FrameRow, stamp_s: f64) {
        let (outlet, columns) = &self.frames;
        let pushed = outlet.push(&columns.values(row), stamp_s);
        self.note(pushed);
    }

    fn note(&mut self, pushed: Result<(), LslError>) {
        if let Err(error) = pushed
            && self.trouble.is_none()
            && !self.is_told
        {
            log::error!("{error}");
            self.trouble = Some(error);
        }
    }

    /// Returns the error of the first sample that could not be sent, once.
    pub fn take_trouble(&mut self) -> Option<String> {
        let trouble = self.trouble.take()?;
        self.is_told = true;
        Some(format!("LSL: {trouble}"))
    }
}
