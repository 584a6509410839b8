//! A probe of the driver: a square wave added to the advised speed in the first minute. In: the time since the first advice. Out: an
//! offset, m/s. Steady advice tells nothing of a driver's reaction time; the response to steps of known size does.

use super::{Action, NetworkOutput, SettingFault};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// A square wave with mean 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Offset in the first half of each period, m/s; the second half has its negative.
    pub amplitude_mps: f64,
    /// Length of a period, s.
    pub period_s: f64,
    /// Time for which the driver is probed, s.
    pub duration_s: f64,
}

impl Probe {
    /// Returns the offset `time_s` after the first advice, m/s. A hold longer than half a period is half a period.
    pub fn offset_mps(&self, time_s: f64, hold_s: f64) -> f64 {
        if time_s >= self.duration_s {
            return 0.0;
        }
        // Tolerates rounding: a step that begins with a half period belongs to it.
        let halves = (time_s / hold_s.max(self.period_s / 2.0) + 1e-6).floor();
        if halves % 2.0 == 0.0 { self.amplitude_mps } else { -self.amplitude_mps }
    }

    /// Returns an advised speed with the probe's offset, never below 0. An acceleration is not probed.
    pub fn added_to(&self, action: Action, time_s: f64, hold_s: f64) -> Action {
        match action {
            Action::Speed(speed_mps) => Action::Speed((speed_mps + self.offset_mps(time_s, hold_s)).max(0.0)),
            Action::Acceleration(_) => action,
        }
    }

    /// Checks that the numbers are finite and positive, and that the policy's action is a speed.
    pub(super) fn check(&self, action: NetworkOutput) -> Result<(), SettingFault> {
        let numbers = [self.amplitude_mps, self.period_s, self.duration_s];
        let is_sound = numbers.iter().all(|number| number.is_finite() && *number > 0.0);
        if is_sound && action == NetworkOutput::Speed { Ok(()) } else { Err(SettingFault::Probe) }
    }

    /// Appends the probe to the text of a policy file.
    pub(super) fn write(&self, text: &mut String) {
        let table = toml::to_string(self).unwrap_or_default();
        let _ = write!(
            text,
            "\n# A square wave added to the advised speed, so that the response tells who drives.\n[probe]\n{table}"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probe_alternates_in_its_period_or_by_holds_and_ends() {
        let probe = Probe { amplitude_mps: 0.2, period_s: 4.0, duration_s: 12.0 };
        let signs = |hold_s: f64, times: &[f64]| -> Vec<i32> {
            times.iter().map(|time_s| (probe.offset_mps(*time_s, hold_s) / 0.2).round() as i32).collect()
        };
        assert_eq!(signs(1.0, &[0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 11.0, 12.0, 99.0]), [1, 1, -1, -1, 1, -1, -1, 0, 0]);
        assert_eq!(signs(4.0, &[0.0, 4.0, 8.0, 12.0]), [1, -1, 1, 0]);
        // 0.1 added twenty times is a little less than 2.
        let time_s = (0..20).fold(0.0, |sum, _| sum + 0.1);
        assert_eq!(signs(0.1, &[time_s]), [-1]);
    }
}
