//! Input of a policy at each step: the traffic around the ego, the advice in force, the driver and the road ahead. In: plain numbers, SI.
//! Out: an [`Observation`].

use super::{DriverTraits, ObservedDriver, RoadAhead, identification::MOST_LATENTS};
use std::f64::consts::TAU;

/// Inputs available to a policy; the first four are HC22's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Own speed, m/s.
    pub speed_mps: f64,
    /// Leader's speed, m/s.
    pub leader_speed_mps: f64,
    /// Own front bumper to the leader's rear bumper, m.
    pub gap_m: f64,
    /// Length of the closed route, m.
    pub circumference_m: f64,
    /// Number of vehicles on the closed route, the ego included.
    pub vehicles: u32,
    /// Hold of the action, s; set by [`Advisor`](super::Advisor).
    pub hold_s: f64,
    /// Own mean speed over about the last half minute, m/s ([`MeanSpeed`](super::MeanSpeed)); set by [`Advisor`](super::Advisor).
    pub mean_speed_mps: f64,
    /// Target of the current advice, m/s; set by [`Advisor`](super::Advisor).
    pub advised_mps: Option<f64>,
    /// Driver as observed from their own history; set by [`Advisor`](super::Advisor) for policies that need it.
    pub observed: ObservedDriver,
    /// Traits of the driver, if known or estimated.
    pub driver: Option<DriverTraits>,
    /// Latents of the driver from a variational encoder, dimensionless; 0 if unknown.
    pub latents: [f64; MOST_LATENTS],
    /// Speed that the policy corrects, m/s, if it corrects one.
    pub corrected_mps: Option<f64>,
    /// State of all vehicles and of the driver; on simulated rings only, for policies that see it.
    pub ring: Option<WholeRing>,
    /// Road ahead; absent on training rings.
    pub road: RoadAhead,
}

/// State of a whole ring and of the ego's driver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WholeRing {
    /// Mean speed of all vehicles, m/s.
    pub mean_speed_mps: f64,
    /// Standard deviation of speed over all vehicles, m/s.
    pub speed_sd_mps: f64,
    /// Cosine and sine parts of the first two harmonics of speed over the vehicles, counted from the ego backwards, m/s.
    pub waves_mps: [[f64; 2]; 2],
    /// Driver's present deviation from the speed that they seek, m/s.
    pub deviation_mps: f64,
}

impl WholeRing {
    /// Returns the state of a ring with these speeds, the ego's first, then backwards, m/s.
    pub fn of(speeds_mps: impl Iterator<Item = f64> + Clone, deviation_mps: f64) -> Self {
        let count = speeds_mps.clone().count().max(1) as f64;
        let mean_speed_mps = speeds_mps.clone().sum::<f64>() / count;
        let variance = speeds_mps.clone().map(|speed| (speed - mean_speed_mps).powi(2)).sum::<f64>() / count;
        let part = |harmonic: f64, of: fn(f64) -> f64| {
            let angle = |k: usize| TAU * harmonic * k as f64 / count;
            speeds_mps.clone().enumerate().map(|(k, speed)| speed * of(angle(k))).sum::<f64>() * 2.0 / count
        };
        let waves_mps = [1.0, 2.0].map(|harmonic| [part(harmonic, f64::cos), part(harmonic, f64::sin)]);
        Self { mean_speed_mps, speed_sd_mps: variance.sqrt(), waves_mps, deviation_mps }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_of_speeds_has_its_own_amplitude_and_phase_only() {
        // 4 + 3 cos(phase) - 0.5 sin(2 phase), the ego at phase 0.
        let phase = |k: usize| TAU * k as f64 / 22.0;
        let speeds = (0..22).map(|k| 4.0 + 3.0 * phase(k).cos() - 0.5 * (2.0 * phase(k)).sin());
        let ring = WholeRing::of(speeds, 0.3);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(ring.mean_speed_mps, 4.0) && ring.deviation_mps == 0.3, "{ring:?}");
        assert!(near(ring.speed_sd_mps, ((9.0 + 0.25_f64) / 2.0).sqrt()), "{ring:?}");
        let expected = [[3.0, 0.0], [0.0, -0.5]];
        assert!(ring.waves_mps.iter().flatten().zip(expected.iter().flatten()).all(|(a, b)| near(*a, *b)), "{ring:?}");
    }
}
