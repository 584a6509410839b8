//! Supervision of the automation by a simulated driver. In: the automation's mode at each tick. Out: presses of its button. The driver lets it
//! drive, and switches it off a response time after a takeover request.

use crate::{rng, snapshot::AutomationMode, time::TICK_S};

/// Median, s, and standard deviation of the logarithm of the time from a takeover request to the takeover: orders of magnitude from memory
/// (docs/references.md: automation).
const TAKEOVER_S: f64 = 2.5;
const LOG_SD: f64 = 0.35;

/// Supervisor of the automation.
#[derive(Clone, Debug)]
pub(super) struct Supervisor {
    random: rng::Stream,
    /// Time left to the takeover, s; `None` without a request.
    left_s: Option<f64>,
}

impl Supervisor {
    pub fn new(seed: u64) -> Self {
        Self { random: rng::stream(seed, "driver/automation"), left_s: None }
    }

    /// Returns true if the button is pressed in this tick.
    pub fn presses(&mut self, mode: AutomationMode) -> bool {
        if !mode.asks() {
            self.left_s = None;
            return false;
        }
        let drawn_s = || TAKEOVER_S * (LOG_SD * self.random.normal()).exp();
        let left_s = self.left_s.unwrap_or_else(drawn_s) - TICK_S;
        self.left_s = Some(left_s);
        // One press is enough: the automation may be off only in the next tick.
        (-TICK_S..0.0).contains(&left_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the times from each of `count` requests to the presses, s.
    fn presses_s(seed: u64, count: usize) -> Vec<f64> {
        let mut supervisor = Supervisor::new(seed);
        let mut of_request = || {
            assert!(!supervisor.presses(AutomationMode::On));
            let asked = (1..3000).filter(|_| supervisor.presses(AutomationMode::TakeoverRequest)).collect::<Vec<_>>();
            assert_eq!(asked.len(), 1, "one press for a request");
            f64::from(asked[0]) * TICK_S
        };
        (0..count).map(|_| of_request()).collect()
    }

    #[test]
    fn takeovers_have_the_median_of_the_model() {
        let mut taken_s = presses_s(1, 999);
        assert_eq!(taken_s[..9], presses_s(1, 9)[..], "the same seed responds alike");
        taken_s.sort_by(f64::total_cmp);
        // The standard error of a median of 999 is 1.25 · 0.35 · 2.5 s / √999 = 0.035 s.
        assert!((taken_s[499] - 2.5).abs() < 0.12, "{}", taken_s[499]);
    }

    #[test]
    fn without_a_request_nothing_is_pressed() {
        let mut supervisor = Supervisor::new(1);
        for mode in [AutomationMode::None, AutomationMode::Off, AutomationMode::On] {
            assert!((0..2000).all(|_| !supervisor.presses(mode)), "{mode:?}");
        }
    }
}
