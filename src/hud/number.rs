//! The number in the centre of the speedometer, without flicker. In: the speed each frame, in the dial's unit. Out: a whole
//! number.

/// How far beyond the point of rounding the speed must go before the number changes, in the dial's unit: a foot that
/// holds 9.5 mph to a tenth shows one number.
const HYSTERESIS: f64 = 0.15;

/// Rounds with hysteresis: the shown number is at most 0.65 away from the speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NumberFilter {
    shown: Option<u32>,
}

impl NumberFilter {
    /// The number for `speed` (not negative).
    pub fn show(&mut self, speed: f64) -> u32 {
        let number = match self.shown {
            Some(shown) if (speed - f64::from(shown)).abs() <= 0.5 + HYSTERESIS => shown,
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
    fn a_speed_that_trembles_about_a_half_shows_one_number() {
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
            assert!(off <= 0.5 + HYSTERESIS + 1e-12, "{off} off at {speed}");
        }
        assert_eq!(filter.show(0.0), 0);
    }
}
