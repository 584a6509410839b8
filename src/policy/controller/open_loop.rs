//! Open-loop policies: a constant speed, or a slow phase first. In: seconds since the start. Out: a speed.

use super::parameters::{GAIN, Parameter, Parametric, SPEED};
use crate::policy::{Action, Observation, Policy};
use serde::{Deserialize, Serialize};

/// A constant advised speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConstantSpeed {
    /// Advised speed, m/s.
    pub speed_mps: f64,
}

impl Parametric for ConstantSpeed {
    const PARAMETERS: &'static [Parameter] = &[Parameter { key: "speed_mps", doc: "Advised speed", ..SPEED }];

    fn numbers(&self) -> Vec<f64> {
        vec![self.speed_mps]
    }

    fn of(x: &[f64]) -> Self {
        Self { speed_mps: x[0] }
    }
}

impl Policy for ConstantSpeed {
    fn act(&mut self, _time_s: f64, _observation: &Observation) -> Action {
        Action::Speed(self.speed_mps)
    }
}

/// Hand-designed advice (docs/references.md: advice): one slow minute opens a hole that absorbs the wave, then a speed just below
/// equilibrium follows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TwoPhase {
    /// Speed of the first phase, m/s.
    pub slow_mps: f64,
    /// Duration of the first phase, s.
    pub slow_s: f64,
    /// Speed after the first phase, m/s.
    pub then_mps: f64,
}

impl TwoPhase {
    /// Returns 2.5 m/s for 60 s on the 250 m ring, whose equilibrium is 4.362 m/s; on other rings in proportion to the equilibrium.
    pub fn for_ring(equilibrium_mps: f64, then_mps: f64) -> Self {
        Self { slow_mps: equilibrium_mps / 4.362 * 2.5, slow_s: 60.0, then_mps }
    }
}

impl Parametric for TwoPhase {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter { key: "slow_mps", doc: "Speed of the first phase", ..SPEED },
        Parameter {
            key: "slow_s",
            doc: "Length of the first phase",
            unit: "s",
            limits: [0.0, 36_000.0],
            search: [0.0, 200.0],
            ..GAIN
        },
        Parameter { key: "then_mps", doc: "Speed of the second phase", ..SPEED },
    ];

    fn numbers(&self) -> Vec<f64> {
        vec![self.slow_mps, self.slow_s, self.then_mps]
    }

    fn of(x: &[f64]) -> Self {
        Self { slow_mps: x[0], slow_s: x[1], then_mps: x[2] }
    }
}

impl TwoPhase {
    /// Returns the commanded speed `time_s` after the beginning, m/s.
    pub fn command_mps(&self, time_s: f64) -> f64 {
        if time_s < self.slow_s { self.slow_mps } else { self.then_mps }
    }
}

impl Policy for TwoPhase {
    fn act(&mut self, time_s: f64, _observation: &Observation) -> Action {
        Action::Speed(self.command_mps(time_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_phases_change_once_at_a_minute() {
        let mut policy = TwoPhase::for_ring(4.362, 4.3);
        let observation = Observation::default();
        assert_eq!(policy.act(59.9, &observation), Action::Speed(2.5));
        assert_eq!(policy.act(60.0, &observation), Action::Speed(4.3));
    }
}
