//! The number in the centre of the speedometer, without flicker. In: the speed each frame, in the dial's unit. Out: a
//! whole number, and the narrowest range in which a driver can hold it.

use crate::{
    scenario::Scenario,
    units::{MPS_PER_MPH, SpeedUnit},
};

/// Distance beyond the rounding point at which the number changes, in the dial's unit: a driver who holds 9.5 mph
/// within 0.1 mph sees one number.
const HYSTERESIS: f64 = 0.15;

/// Largest distance of the shown number from the speed, in the dial's unit.
const MOST_OFF: f64 = 0.5 + HYSTERESIS;

/// Error of a range too narrow for the number: it could show the advised speed while its colour says that the speed is
/// outside.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "range_mph is {range_mph}; allowed: {least_mph:.3} or more on a speedometer in {}. Its number may differ from the \
     speed by {MOST_OFF}; in a narrower range it could show the advised speed and not be green", unit.label()
)]
pub struct RangeTooNarrow {
    /// Requested half width, mph.
    pub range_mph: f64,
    /// Smallest allowed half width, mph.
    pub least_mph: f64,
    /// Unit of the speedometer.
    pub unit: SpeedUnit,
}

/// Checks that the range of the advice is not narrower than the speedometer's number can resolve.
///
/// # Errors
/// [`RangeTooNarrow`].
pub fn check_range(scenario: &Scenario) -> Result<(), RangeTooNarrow> {
    let unit = scenario.display.units;
    let least_mph = MOST_OFF * unit.mps_per_unit() / MPS_PER_MPH;
    let range_mph = scenario.range_mph;
    if range_mph < least_mph - 1e-9 { Err(RangeTooNarrow { range_mph, least_mph, unit }) } else { Ok(()) }
}

/// Rounds with hysteresis: the shown number is at most 0.65 away from the speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NumberFilter {
    shown: Option<u32>,
}

impl NumberFilter {
    /// Returns the number for `speed` (not negative).
    pub fn show(&mut self, speed: f64) -> u32 {
        let number = match self.shown {
            Some(shown) if (speed - f64::from(shown)).abs() <= MOST_OFF => shown,
            _ => speed.round() as u32,
        };
        self.shown = Some(number);
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_that_wavers_about_a_half_shows_one_number() {
        let mut filter = NumberFilter::default();
        let shown: Vec<u32> = (0..100).map(|i| filter.show(9.5 + 0.1 * f64::from(i).sin())).collect();
        assert!(shown.iter().all(|&number| number == shown[0]), "{shown:?}");
    }

    #[test]
    fn the_number_follows_a_change_of_speed() {
        let mut filter = NumberFilter::default();
        for i in 0..=3000 {
            let speed = f64::from(i) * 0.01;
            let off = (f64::from(filter.show(speed)) - speed).abs();
            assert!(off <= MOST_OFF + 1e-12, "{off} off at {speed}");
        }
        assert_eq!(filter.show(0.0), 0);
    }

    #[test]
    fn in_the_narrowest_range_the_advised_number_is_never_outside() {
        // The advised speed is a whole number; whenever that number is shown, the speed is within 0.65 of it.
        let mut filter = NumberFilter::default();
        for i in 0..4000 {
            let speed = 10.0 + 1.5 * (f64::from(i) * 0.01).sin();
            assert!(filter.show(speed) != 10 || (speed - 10.0).abs() <= 0.65 + 1e-12, "{speed}");
        }
        let range = |range_mph: f64, units: SpeedUnit| {
            let display = crate::scenario::DisplaySettings { units, ..Default::default() };
            check_range(&Scenario { range_mph, display, ..Scenario::default() })
        };
        assert_eq!(range(0.65, SpeedUnit::Mph), Ok(()));
        // 0.65 km/h is 0.404 mph.
        assert_eq!(range(0.404, SpeedUnit::Kmh), Ok(()));
        assert!(range(0.403, SpeedUnit::Kmh).is_err());
        let message = range(0.5, SpeedUnit::Mph).unwrap_err().to_string();
        assert!(message.starts_with("range_mph is 0.5; allowed: 0.650 or more on a speedometer in mph"), "{message}");
    }
}
