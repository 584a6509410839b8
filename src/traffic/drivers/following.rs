//! A traffic driver: car-following model and noise of the acceleration. In: speed, leader's speed, gap, limit. Out: acceleration. SI units.

use crate::{idm::IdmParams, optimal_velocity::OptimalVelocityParams};

/// Car-following model with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CarFollowing {
    /// Intelligent Driver Model; its noise is not used.
    Idm(IdmParams),
    /// Optimal velocity with a follow-the-leader term.
    OptimalVelocity(OptimalVelocityParams),
}

/// Deceleration for a bend of a driver whose model has no comfortable one, m/s2: the ring study's.
const COMFORTABLE_MPS2: f64 = 1.5;

impl CarFollowing {
    /// Returns the acceleration, m/s2, at `gap_m` (bumper to bumper) behind a leader; the desired speed is at most `limit_mps`.
    pub fn acceleration(&self, speed_mps: f64, leader_speed_mps: f64, gap_m: f64, limit_mps: f64) -> f64 {
        match self {
            Self::Idm(idm) => {
                let limited = IdmParams { v0: idm.v0.min(limit_mps), ..*idm };
                limited.acceleration(speed_mps, leader_speed_mps, gap_m)
            }
            Self::OptimalVelocity(model) => model.acceleration(speed_mps, leader_speed_mps, gap_m, limit_mps),
        }
    }

    /// Returns the model of a driver whose time gap is this multiple of the usual one. With optimal velocity, they see each gap divided by it.
    #[must_use]
    pub fn with_time_gap(self, factor: f64) -> Self {
        match self {
            Self::Idm(idm) => Self::Idm(IdmParams { t: idm.t * factor, ..idm }),
            Self::OptimalVelocity(model) => Self::OptimalVelocity(OptimalVelocityParams {
                d0: model.d0 * factor,
                beta: model.beta * factor * factor,
                ..model
            }),
        }
    }

    /// Returns the speed on a free road without a limit, m/s.
    pub fn desired_speed_mps(&self) -> f64 {
        match self {
            Self::Idm(idm) => idm.v0,
            Self::OptimalVelocity(model) => model.v_max,
        }
    }

    /// Returns the deceleration that a driver of this model finds comfortable, m/s2.
    pub fn comfortable_mps2(&self) -> f64 {
        match self {
            Self::Idm(idm) => idm.b,
            Self::OptimalVelocity(_) => COMFORTABLE_MPS2,
        }
    }

    /// Returns the speed of an even ring with `gap_m` between the vehicles on a road with this limit, m/s.
    pub fn equilibrium_speed_mps(&self, gap_m: f64, limit_mps: f64) -> f64 {
        match self {
            Self::Idm(idm) => IdmParams { v0: idm.v0.min(limit_mps), ..*idm }.equilibrium_speed_mps(gap_m),
            Self::OptimalVelocity(model) => model.optimal_speed_mps(gap_m).clamp(0.0, limit_mps),
        }
    }

    /// Returns the string stability against long waves, 1/s2 ([`IdmParams::string_stability`]).
    pub fn string_stability(&self, gap_m: f64) -> f64 {
        match self {
            Self::Idm(idm) => idm.string_stability(gap_m),
            Self::OptimalVelocity(model) => model.string_stability(gap_m),
        }
    }
}

/// Random part of what a driver does, added to the model's choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AccelNoise {
    /// Flow's convention: `sqrt(step) N(0, noise)` in m/s2, unrelated from step to step.
    Flow(f64),
    /// Noise with a memory: what a driver does now resembles what they did just before.
    OrnsteinUhlenbeck {
        /// Standard deviation of the acceleration, m/s2.
        sd_mps2: f64,
        /// Time constant of the autocorrelation, seconds.
        memory_s: f64,
    },
}

impl AccelNoise {
    /// Returns the share of the noise that a step keeps, and the standard deviation of what it adds, as a change of speed in m/s. Steps
    /// of any length give the same process.
    pub fn in_steps_of(&self, step_s: f64) -> (f64, f64) {
        match *self {
            Self::Flow(noise) => (0.0, noise * step_s.sqrt() * step_s),
            Self::OrnsteinUhlenbeck { sd_mps2, memory_s } => {
                let keeps = (-step_s / memory_s).exp();
                (keeps, sd_mps2 * (1.0 - keeps * keeps).sqrt() * step_s)
            }
        }
    }
}

/// Driver of one of the other vehicles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrafficDriver {
    pub model: CarFollowing,
    pub noise: AccelNoise,
}

impl TrafficDriver {
    /// Returns a driver of the ring study: IDM with Flow's noise.
    pub fn of_ring_study(idm: IdmParams) -> Self {
        Self { model: CarFollowing::Idm(idm), noise: AccelNoise::Flow(idm.noise) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_with_memory_has_its_deviation_and_correlation_at_every_step() {
        let noise = AccelNoise::OrnsteinUhlenbeck { sd_mps2: 0.346, memory_s: 1.31 };
        for step_s in [0.05, 0.1, 0.5] {
            let (keeps, adds_mps) = noise.in_steps_of(step_s);
            // A stationary process of this kind has the variance adds^2 / (1 - keeps^2); after 1.31 s, 1/e of it is left.
            let sd_mps2 = adds_mps / (1.0 - keeps * keeps).sqrt() / step_s;
            assert!((sd_mps2 - 0.346).abs() < 1e-12, "{sd_mps2}");
            assert!((keeps.powf(1.31 / step_s) - 1.0 / std::f64::consts::E).abs() < 1e-12);
        }
    }

    #[test]
    fn twice_the_time_gap_is_kept_at_twice_the_equilibrium_gap() {
        // IDM far below its desired speed: s0 + v T. Optimal velocity: the gap of the speed, from its inverse by hand.
        let idm = CarFollowing::Idm(IdmParams { v0: 1e6, ..IdmParams::default() }).with_time_gap(2.0);
        assert!(idm.acceleration(5.0, 5.0, 2.0 + 5.0 * 2.0, f64::INFINITY).abs() < 1e-9);
        let usual = OptimalVelocityParams::default();
        let rise_mps = usual.v_max / (1.0 + usual.ds.tanh());
        let gap_m = usual.d0 * ((5.0 / rise_mps - usual.ds.tanh()).atanh() + usual.ds);
        let model = CarFollowing::OptimalVelocity(usual);
        assert!(model.acceleration(5.0, 5.0, gap_m, f64::INFINITY).abs() < 1e-9);
        let slow = model.with_time_gap(2.0);
        assert!(slow.acceleration(5.0, 5.0, 2.0 * gap_m, f64::INFINITY).abs() < 1e-9);
        let differ = |gap_m: f64| [5.0, 3.0].map(|leader| slow.acceleration(5.0, leader, gap_m, f64::INFINITY));
        let expected = [5.0, 3.0].map(|leader| model.acceleration(5.0, leader, 4.0, f64::INFINITY));
        assert!(differ(8.0).iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn a_limit_bounds_the_speed_of_both_models() {
        for model in
            [CarFollowing::Idm(IdmParams::default()), CarFollowing::OptimalVelocity(OptimalVelocityParams::default())]
        {
            assert!(model.acceleration(5.0, 5.0, 1e4, 5.0).abs() < 1e-3);
            assert!(model.acceleration(5.0, 5.0, 1e4, 6.0) > 0.1);
            assert!(model.equilibrium_speed_mps(1e4, 5.0) <= 5.0);
        }
    }
}
