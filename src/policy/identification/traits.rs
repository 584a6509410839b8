//! Traits and latents that distinguish drivers for advice. In: nothing. Out: five numbers, which a teacher is given and a student
//! estimates, and the number and names of the latents.

use serde::{Deserialize, Serialize};

/// Number of traits, the length of [`DriverTraits::NAMES`].
pub const TRAITS: usize = 5;

/// Traits of one driver. `driver::DriverParams` defines the traits of a simulated driver.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriverTraits {
    /// Time from a new advice to the first response, s.
    pub reaction_s: f64,
    /// Driven speed minus advised speed, m/s.
    pub speed_bias_mps: f64,
    /// Standard deviation of the speed around the driver's target speed, m/s.
    pub error_mps: f64,
    /// Time gap to the leader as a multiple of the other vehicles' time gap.
    pub time_gap_factor: f64,
    /// Share of time in which the driver currently follows the advice, 0 to 1.
    pub willingness: f64,
}

impl Default for DriverTraits {
    /// Returns the traits of a driver who follows the advice exactly.
    fn default() -> Self {
        Self { reaction_s: 0.0, speed_bias_mps: 0.0, error_mps: 0.0, time_gap_factor: 1.0, willingness: 1.0 }
    }
}

impl DriverTraits {
    /// Names of the traits in files and tables, in order.
    pub const NAMES: [&'static str; TRAITS] =
        ["reaction_s", "speed_bias_mps", "error_mps", "time_gap_factor", "willingness"];

    /// Returns the traits in the order of [`DriverTraits::NAMES`].
    pub fn numbers(&self) -> [f64; TRAITS] {
        [self.reaction_s, self.speed_bias_mps, self.error_mps, self.time_gap_factor, self.willingness]
    }

    /// Returns the nearest traits within the possible ranges.
    pub fn possible(self) -> Self {
        Self {
            reaction_s: self.reaction_s.max(0.0),
            speed_bias_mps: self.speed_bias_mps,
            error_mps: self.error_mps.max(0.0),
            time_gap_factor: self.time_gap_factor.max(0.1),
            willingness: self.willingness.clamp(0.0, 1.0),
        }
    }

    /// Returns the traits with these numbers, in the order of [`DriverTraits::NAMES`].
    pub fn of([reaction_s, speed_bias_mps, error_mps, time_gap_factor, willingness]: [f64; TRAITS]) -> Self {
        Self { reaction_s, speed_bias_mps, error_mps, time_gap_factor, willingness }
    }
}

/// Largest number of latents, each of which a policy can take as input.
pub const MOST_LATENTS: usize = 4;

/// Returns the name of latent `k` in files; `k` counts from 0 and the first name is `latent_1`.
pub fn latent_name(k: usize) -> String {
    format!("latent_{}", k + 1)
}
