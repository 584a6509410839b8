//! Moments that a fit compares. In: measured trajectories of a ring, and drivers whose rings are simulated. Out: the moments of both in
//! the same minutes and steps, and the distance between them.
//!
//! Each difference is divided by a scale from outside: half the band that counts as like people, or the difference of the people's two
//! halves where there is no band, and at least [`LEAST_SHARE`] of their value (`metrics::traffic_moments::EXPERIMENT_A`). The distance is the
//! square root of the mean of the squares.

use crate::{
    metrics::traffic_moments::{EXPERIMENT_A, VehicleTrajectories, moments_of_persons},
    space::CAR_LENGTH_M,
    traffic::TrafficDrivers,
    train::ring_trajectories,
};

/// Moments that a fit compares: those with a band on both sides, and five quantiles and the variation of the gaps. Extremes, correlations
/// and growth are left out, as 20 persons say too little of them; kurtosis, as it has no criterion.
pub const FITTED_MOMENTS: [&str; 22] = [
    "mean_speed_mps",
    "speed_sd_over_vehicles_mps",
    "accel_sd_mps2",
    "accel_p01_mps2",
    "accel_p99_mps2",
    "brakings_per_km",
    "gap_p05_m",
    "gap_p25_m",
    "gap_median_m",
    "gap_p75_m",
    "gap_p95_m",
    "person_gap_sd_m",
    "person_time_gap_s",
    "person_time_gap_ln_sd",
    "person_accel_ln_sd",
    "lag_s",
    "gain_at_0_03_hz",
    "gain_at_0_06_hz",
    "gain_at_0_1_hz",
    "gain_at_0_15_hz",
    "wave_speed_mps",
    "wave_share",
];

/// Smallest scale of a moment, as a share of its value for people.
const LEAST_SHARE: f64 = 0.05;
/// Longest step of the compared trajectories, s: lags are refined between steps, and shorter ones take most of the time.
const STEP_S: f64 = 0.5;
/// Shortest time from the standstill of a simulated ring to its compared part, s.
const WARM_UP_S: f64 = 30.0;

/// Part of a measured ring with its moments.
#[derive(Clone, Debug)]
pub struct RingTarget {
    /// Measured trajectories in the steps of the comparison.
    people: VehicleTrajectories,
    /// Compared part of a simulated drive, s since its start.
    from_to_s: [f64; 2],
    /// Values of the people, in the order of [`FITTED_MOMENTS`].
    pub moments: Vec<f64>,
}

impl RingTarget {
    /// Takes the part that lasts `from_to_s` since the start of the measured drive.
    ///
    /// # Errors
    /// A moment cannot be measured in the part.
    pub fn new(part: &VehicleTrajectories, [from_s, to_s]: [f64; 2]) -> Result<Self, String> {
        let late_s = (WARM_UP_S - from_s).max(0.0);
        let people = part.thinned(STEP_S);
        let moments = moments_of_persons(&people, None, &FITTED_MOMENTS).ok_or_else(|| {
            let missing = FITTED_MOMENTS.iter().find(|name| moments_of_persons(&people, None, &[name]).is_none());
            format!("{:.0} to {:.0} s: no {}", from_s, to_s, missing.copied().unwrap_or_default())
        })?;
        Ok(Self { people, from_to_s: [from_s + late_s, to_s + late_s], moments })
    }

    /// Returns the moments if these persons had been measured, each as often as named, with their leaders.
    pub fn of_persons(&self, persons: &[usize]) -> Option<Vec<f64>> {
        moments_of_persons(&self.people, Some(persons), &FITTED_MOMENTS)
    }

    /// Returns the number of persons.
    pub fn persons(&self) -> usize {
        self.people.vehicles.len()
    }

    /// Returns the mean moments of `runs` simulated rings; `None` if a run has a contact or lacks a moment. The vehicles have the mean gap
    /// of the measured ones.
    pub fn simulated(&self, drivers: &TrafficDrivers, (first_seed, runs): (u64, usize)) -> Option<Vec<f64>> {
        let vehicles = self.persons();
        let gaps_m = self.people.vehicles.iter().flat_map(|vehicle| &vehicle.gap_m).sum::<f64>();
        let ring_m = gaps_m / self.people.steps() as f64 + vehicles as f64 * CAR_LENGTH_M;
        let [from_s, to_s] = self.from_to_s;
        let mut sums = vec![0.0; FITTED_MOMENTS.len()];
        for run in ring_trajectories(drivers, (vehicles, ring_m), to_s, (first_seed, runs)) {
            if run.vehicles.iter().any(|vehicle| vehicle.gap_m.iter().any(|gap_m| *gap_m <= 0.0)) {
                return None;
            }
            let part = run.between(from_s, to_s).thinned(STEP_S);
            let moments = moments_of_persons(&part, None, &FITTED_MOMENTS)?;
            sums.iter_mut().zip(moments).for_each(|(sum, moment)| *sum += moment / runs as f64);
        }
        Some(sums)
    }
}

/// Returns the scale of each of [`FITTED_MOMENTS`].
fn scale(name: &str) -> f64 {
    let criterion = EXPERIMENT_A.criterion(name).expect("a fitted moment has a criterion");
    let halves = criterion.halves.map_or(0.0, |[first, second]| (first - second).abs());
    let scale = criterion.band.map_or(halves, |[low, high]| (high - low) / 2.0);
    scale.max(LEAST_SHARE * criterion.people.abs())
}

/// Returns the distance of moments from others, in scales.
pub fn distance(moments: &[f64], others: &[f64]) -> f64 {
    let squares = differences(moments, others).iter().map(|difference| difference.powi(2)).sum::<f64>();
    (squares / FITTED_MOMENTS.len() as f64).sqrt()
}

/// Returns the difference of each moment from another's, in scales.
pub fn differences(moments: &[f64], others: &[f64]) -> Vec<f64> {
    let pairs = moments.iter().zip(others).zip(FITTED_MOMENTS);
    pairs.map(|((moment, other), name)| (moment - other) / scale(name)).collect()
}
