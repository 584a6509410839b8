//! The scale of the speedometer. In: the highest expected speed of a scenario. Out: full scale and ticks, in round
//! numbers and fixed for the whole scenario: a dial to 120 mph is useless at 10 mph.

use crate::units::SpeedUnit;

/// Full scale and ticks, in the dial's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedometerScale {
    /// Full scale, a multiple of `major_step`.
    pub full: f64,
    /// Distance between numbered ticks.
    pub major_step: f64,
    /// Intervals between two numbered ticks: the unnumbered ticks between them plus one.
    pub minor_per_major: u32,
}

/// Factor on the expected speed that keeps the needle off the end of the scale.
const HEADROOM: f64 = 1.15;

/// Scales to choose from: full scale, numbered step, intervals of a step. Each has 4 to 13 numerals.
const SCALES: [(f64, f64, u32); 15] = [
    (10.0, 2.0, 4),
    (15.0, 5.0, 5),
    (20.0, 5.0, 5),
    (25.0, 5.0, 5),
    (30.0, 5.0, 5),
    (40.0, 5.0, 5),
    (50.0, 10.0, 10),
    (60.0, 10.0, 10),
    (80.0, 10.0, 5),
    (100.0, 10.0, 5),
    (120.0, 20.0, 4),
    (140.0, 20.0, 4),
    (160.0, 20.0, 4),
    (200.0, 20.0, 4),
    (240.0, 20.0, 4),
];

impl SpeedometerScale {
    /// Returns the smallest scale with 15 % of room above `max_expected_mps`, at most 240. Beyond full scale the needle
    /// stays at its end; the number goes on.
    pub fn fitting(max_expected_mps: f64, unit: SpeedUnit) -> Self {
        Self::up_to(unit.from_mps(max_expected_mps) * HEADROOM)
    }

    /// Returns the smallest scale that holds `speed`, in the dial's unit, at most 240.
    pub fn up_to(speed: f64) -> Self {
        let (full, major_step, minor_per_major) =
            SCALES.into_iter().find(|scale| scale.0 >= speed).unwrap_or(SCALES[SCALES.len() - 1]);
        Self { full, major_step, minor_per_major }
    }
}

/// Returns the highest expected speed on a ring, m/s, at most the speed limit. It is 2.2 times the equilibrium speed,
/// the top of a saturated wave (250 m ring: 9.6 against 4.362 m/s, docs/references.md: ring), or the highest advised
/// speed, whichever is higher.
pub fn expected_top_mps(equilibrium_mps: f64, highest_advised_mps: f64, limit_mps: f64) -> f64 {
    (2.2 * equilibrium_mps).max(highest_advised_mps).min(limit_mps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_rings_get_scales_that_fit() {
        let paper = expected_top_mps(4.362, 4.9, 30.0);
        let successor = expected_top_mps(8.956, 10.0, 17.88);
        assert!((paper - 9.6).abs() < 0.01, "{paper}");
        assert_eq!(SpeedometerScale::fitting(paper, SpeedUnit::Mph).full, 25.0);
        assert_eq!(SpeedometerScale::fitting(paper, SpeedUnit::Kmh).full, 40.0);
        assert_eq!(SpeedometerScale::fitting(successor, SpeedUnit::Mph).full, 50.0);
        assert_eq!(SpeedometerScale::fitting(successor, SpeedUnit::Kmh).full, 80.0);
    }

    #[test]
    fn every_scale_is_whole_steps_and_holds_its_expected_speed() {
        for tenth in 1..700 {
            let top_mps = f64::from(tenth) * 0.1;
            for unit in [SpeedUnit::Mph, SpeedUnit::Kmh] {
                let scale = SpeedometerScale::fitting(top_mps, unit);
                let steps = scale.full / scale.major_step;
                assert_eq!(steps, steps.round());
                assert!((3.0..=12.0).contains(&steps), "{steps} steps at {top_mps} m/s");
                assert!(scale.full >= unit.from_mps(top_mps).min(240.0));
            }
        }
    }
}
