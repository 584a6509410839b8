//! Measurements of this program on this machine. In: a scenario. Out: medians and percentiles. No test asserts them: timings
//! depend on the machine and its load.

mod force;
mod graphics_card;
mod learning;
mod network;
mod picture;
mod recording;
mod simulation;

pub use force::{ForceTimes, force};
pub use graphics_card::{CARD_SIZES, CardReport, CardTimes, card_times};
pub use learning::{LearningTimes, learning};
pub use network::{NetworkLoading, network_loading, network_step};
pub use picture::{CostGrowth, DrawnDrive, DriveTimes, FrameTimes, SIZES, StartupTimes, growth, startup};
pub use recording::{RECORDER_LIMIT_US, recording};
pub use simulation::{SimulationReport, SumoTimes, simulation};

use serde::Serialize;
use std::time::{Duration, Instant};

/// Statistics of repeated times, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeStatistics {
    pub min_us: f64,
    pub median_us: f64,
    /// 99th percentile of the times.
    pub p99_us: f64,
    pub max_us: f64,
    /// Number of times measured.
    pub samples: usize,
}

impl TimeStatistics {
    /// Returns the statistics of a list of durations, which must not be empty.
    pub fn of(mut samples: Vec<Duration>) -> Self {
        samples.sort();
        let at = |share: f64| samples[((samples.len() - 1) as f64 * share).round() as usize].as_secs_f64() * 1e6;
        Self { min_us: at(0.0), median_us: at(0.5), p99_us: at(0.99), max_us: at(1.0), samples: samples.len() }
    }
}

/// Returns the peak memory of this process, MB; `None` if the system does not report it.
pub fn peak_memory_mb() -> Option<f64> {
    memory_mb("VmHWM:")
}

/// Returns the present memory of this process, MB; `None` if the system does not report it.
fn present_memory_mb() -> Option<f64> {
    memory_mb("VmRSS:")
}

fn memory_mb(name: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    // The kernel counts in units of 1024 bytes.
    let line = status.lines().find(|line| line.starts_with(name))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024.0 / 1e6)
}

/// Returns the size of the program's own file, with all that is built in, MB; `None` if it cannot be read.
pub fn program_mb() -> Option<f64> {
    let file = std::fs::metadata(std::env::current_exe().ok()?).ok()?;
    Some(file.len() as f64 / 1e6)
}

#[allow(clippy::disallowed_methods, reason = "a measurement of time is what this is")]
fn now() -> Instant {
    Instant::now()
}
