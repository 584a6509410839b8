//! Table of the frames. In: a frame on the screen. Out: one row for each. Times in seconds.

use crate::{
    record::table::{ColumnValue, TableColumn, column, number},
    time::Tick,
};

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
