//! The observation as a network sees it: one code for the drive and for training. In: an [`Observation`], SI. Out: four
//! numbers of about -1 to 1: own speed, leader's speed, gap, circumference (HC22's four, scaled as FACTS 3 lists them).

use super::Observation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What becomes -1 and what becomes 1. The default is the field's: v/10, v_lead/10, gap/300, (L-200)/100, each 0..1 taken
/// to -1..1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scaling {
    /// Speed that becomes 1; standing is -1
    #[schemars(range(min = 0.1, max = 100.0), extend("unit" = "m/s"))]
    pub speed_to_mps: f64,
    /// Gap that becomes 1; none is -1
    #[schemars(range(min = 0.1, max = 10000.0), extend("unit" = "m"))]
    pub gap_to_m: f64,
    /// Circumference that becomes -1
    #[schemars(range(min = 0.0, max = 100000.0), extend("unit" = "m"))]
    pub circumference_from_m: f64,
    /// Circumference that becomes 1
    #[schemars(range(min = 1.0, max = 100000.0), extend("unit" = "m"))]
    pub circumference_to_m: f64,
}

impl Default for Scaling {
    fn default() -> Self {
        Self { speed_to_mps: 10.0, gap_to_m: 300.0, circumference_from_m: 200.0, circumference_to_m: 300.0 }
    }
}

impl Scaling {
    /// The four numbers.
    #[inline(always)]
    pub fn scaled(&self, observation: &Observation) -> [f32; 4] {
        let unit = |x: f64, from: f64, to: f64| (2.0 * (x - from) / (to - from) - 1.0) as f32;
        [
            unit(observation.speed_mps, 0.0, self.speed_to_mps),
            unit(observation.leader_speed_mps, 0.0, self.speed_to_mps),
            unit(observation.gap_m, 0.0, self.gap_to_m),
            unit(observation.circumference_m, self.circumference_from_m, self.circumference_to_m),
        ]
    }

    /// True if every number can be scaled.
    pub fn is_sound(&self) -> bool {
        self.speed_to_mps > 0.0 && self.gap_to_m > 0.0 && self.circumference_to_m > self.circumference_from_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_the_scaling_of_the_field() {
        let seen = Observation { speed_mps: 5.0, leader_speed_mps: 10.0, gap_m: 75.0, circumference_m: 250.0 };
        assert_eq!(Scaling::default().scaled(&seen), [0.0, 1.0, -0.5, 0.0]);
        let seen = Observation { circumference_m: 200.0, ..Observation::default() };
        assert_eq!(Scaling::default().scaled(&seen), [-1.0; 4]);
    }

    #[test]
    fn a_range_without_width_is_unsound() {
        assert!(Scaling::default().is_sound());
        assert!(!Scaling { circumference_to_m: 200.0, ..Scaling::default() }.is_sound());
    }
}
