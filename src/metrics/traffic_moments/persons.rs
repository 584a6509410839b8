//! Numbers of one person at the wheel. In: a vehicle's speed and gap, and its leader's speed. Out: time gap, acceleration, lag and noise.

use super::trajectories::VehicleTrajectories;
use crate::metrics::{
    correlation,
    distribution::{deviation, mean, median},
};
use glam::{DMat3, DVec3};

/// Time over which an acceleration is taken, s.
pub(super) const ACCEL_S: f64 = 1.0;
/// Smallest speed for a time gap, m/s: at a standstill it is infinite.
const MOVING_MPS: f64 = 1.0;
/// Largest lag that is tried, s.
const MOST_LAG_S: f64 = 6.0;

/// Numbers of one person; `None` where there is nothing to measure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PersonMoments {
    pub mean_gap_m: Option<f64>,
    pub gap_sd_m: Option<f64>,
    /// Median of gap over speed at 1 m/s or more, s.
    pub time_gap_s: Option<f64>,
    /// SD of the acceleration over 1 s, m/s².
    pub accel_sd_mps2: Option<f64>,
    /// SD of the acceleration over 1 s that no linear function of gap, own and leader's speed at its start explains, m/s².
    pub noise_mps2: Option<f64>,
    /// Lag at which speed and leader's speed correlate most, s.
    pub lag_s: Option<f64>,
}

/// Computes the numbers of every person, in the order of the vehicles.
pub fn persons(all: &VehicleTrajectories) -> Vec<PersonMoments> {
    (0..all.vehicles.len()).map(|vehicle| PersonMoments::of(all, vehicle)).collect()
}

/// Computes the numbers of the persons in these vehicles, each as often as named.
pub(super) fn persons_of(all: &VehicleTrajectories, chosen: &[usize]) -> Vec<PersonMoments> {
    let every = persons(all);
    chosen.iter().map(|vehicle| every[*vehicle].clone()).collect()
}

impl PersonMoments {
    fn of(all: &VehicleTrajectories, vehicle: usize) -> Self {
        let own = &all.vehicles[vehicle];
        let accels = accels_mps2(&own.speed_mps, all.step_s);
        let alone = Self { accel_sd_mps2: deviation(&accels), ..Self::default() };
        let Some(leader) = own.leader else { return alone };
        let leader_mps = &all.vehicles[leader].speed_mps;
        let moving = own.gap_m.iter().zip(&own.speed_mps).filter(|(_, speed)| **speed >= MOVING_MPS);
        Self {
            mean_gap_m: mean(&own.gap_m),
            gap_sd_m: deviation(&own.gap_m),
            time_gap_s: median(moving.map(|(gap, speed)| gap / speed).collect()),
            noise_mps2: unexplained(&accels, [&own.gap_m, &own.speed_mps, leader_mps]),
            lag_s: lag_s(&own.speed_mps, leader_mps, all.step_s),
            ..alone
        }
    }
}

/// Returns the change of speed over 1 s from each step on, m/s².
pub(super) fn accels_mps2(speeds_mps: &[f64], step_s: f64) -> Vec<f64> {
    let steps = (ACCEL_S / step_s).round().max(1.0) as usize;
    let later = speeds_mps.get(steps..).unwrap_or_default();
    speeds_mps.iter().zip(later).map(|(now, later)| (later - now) / (steps as f64 * step_s)).collect()
}

/// Returns the SD of the residuals of a linear regression of `values` on three series; `None` if these determine no regression.
fn unexplained(values: &[f64], series: [&[f64]; 3]) -> Option<f64> {
    let n = values.len();
    let [a, b, c] = series.map(|all| all.get(..n).and_then(mean));
    let (middle, means) = (mean(values)?, DVec3::new(a?, b?, c?));
    let at = |i: usize| DVec3::new(series[0][i], series[1][i], series[2][i]) - means;
    let (mut squares, mut products) = (DMat3::ZERO, DVec3::ZERO);
    for (i, value) in values.iter().enumerate() {
        let x = at(i);
        squares += DMat3::from_cols(x * x.x, x * x.y, x * x.z);
        products += x * (value - middle);
    }
    let scale = squares.x_axis.x * squares.y_axis.y * squares.z_axis.z;
    if squares.determinant() <= 1e-9 * scale {
        return None;
    }
    let slopes = squares.inverse() * products;
    let residuals: Vec<f64> = values.iter().enumerate().map(|(i, value)| value - middle - slopes.dot(at(i))).collect();
    deviation(&residuals)
}

/// Returns the lag from 0 to 6 s at which a speed correlates most with the leader's earlier speed, s, refined by a parabola; `None` if
/// one of them does not vary.
fn lag_s(own_mps: &[f64], leader_mps: &[f64], step_s: f64) -> Option<f64> {
    let n = own_mps.len();
    let most = ((MOST_LAG_S / step_s).round() as usize).min(n / 2);
    let at = |lag: usize| {
        let pairs: Vec<(f64, f64)> = own_mps[lag..].iter().copied().zip(leader_mps.iter().copied()).collect();
        correlation(&pairs)
    };
    let correlations: Vec<f64> = (0..=most).map(at).collect::<Option<_>>()?;
    let best = (0..=most).max_by(|a, b| correlations[*a].total_cmp(&correlations[*b]))?;
    if best == 0 || best == most {
        return Some(best as f64 * step_s);
    }
    let [before, peak, after] = [-1, 0, 1].map(|k| correlations[best.wrapping_add_signed(k)]);
    let shift = (before - after) / (2.0 * (before - 2.0 * peak + after));
    Some((best as f64 + shift) * step_s)
}
