//! What sets one driver apart from another, as far as it matters to advice. In: nothing. Out: five numbers, which a teacher
//! knows and a student estimates.

use serde::{Deserialize, Serialize};

/// Number of traits.
pub const TRAITS: usize = 5;

/// Traits of one driver. `driver::DriverParams` says how a simulated one comes by them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriverTraits {
    /// Time from a new advice to the first response, s.
    pub reaction_s: f64,
    /// Speed driven less speed advised, m/s.
    pub speed_bias_mps: f64,
    /// Standard deviation of the speed around what he aims at, m/s.
    pub error_mps: f64,
    /// Time gap kept to the leader, as a multiple of the other cars'.
    pub time_gap_factor: f64,
    /// Share of the time in which he follows the advice now, 0 to 1.
    pub willingness: f64,
}

impl Default for DriverTraits {
    /// Somebody who does to the letter what he is told.
    fn default() -> Self {
        Self { reaction_s: 0.0, speed_bias_mps: 0.0, error_mps: 0.0, time_gap_factor: 1.0, willingness: 1.0 }
    }
}

impl DriverTraits {
    /// Names of the traits in files and tables, in order.
    pub const NAMES: [&'static str; TRAITS] =
        ["reaction_s", "speed_bias_mps", "error_mps", "time_gap_factor", "willingness"];

    /// The numbers in that order.
    pub fn numbers(&self) -> [f64; TRAITS] {
        [self.reaction_s, self.speed_bias_mps, self.error_mps, self.time_gap_factor, self.willingness]
    }

    /// The nearest traits that a driver can have.
    pub fn possible(self) -> Self {
        Self {
            reaction_s: self.reaction_s.max(0.0),
            speed_bias_mps: self.speed_bias_mps,
            error_mps: self.error_mps.max(0.0),
            time_gap_factor: self.time_gap_factor.max(0.1),
            willingness: self.willingness.clamp(0.0, 1.0),
        }
    }

    /// The traits with these numbers.
    pub fn of([reaction_s, speed_bias_mps, error_mps, time_gap_factor, willingness]: [f64; TRAITS]) -> Self {
        Self { reaction_s, speed_bias_mps, error_mps, time_gap_factor, willingness }
    }
}
