//! Criterion of a practice drive: the speed stays in the acceptable range for a given time without a break. In: for each step, whether
//! the speed was in the range. Out: the longest unbroken time, s. The session window and the rehearsal both use this rule.
//!
//! There is no grace period: a step out of the range, or one without advice, resets the time to zero. The number on the speedometer turns
//! from green to white at the same edge, so the participant sees the rule that the criterion applies. A grace period would need a length
//! of its own, and a participant at the edge of the range could meet the criterion without holding the range. A change of advice resets
//! nothing while the speed is in the new range.

/// Unbroken time in the range, current and longest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UnbrokenTime {
    now_s: f64,
    longest_s: f64,
}

impl UnbrokenTime {
    /// Adds a step of this length, in or out of the range.
    pub fn add(&mut self, is_in_range: bool, step_s: f64) {
        self.now_s = if is_in_range { self.now_s + step_s } else { 0.0 };
        self.longest_s = self.longest_s.max(self.now_s);
    }

    /// Returns the current unbroken time in the range, s.
    pub fn now_s(&self) -> f64 {
        self.now_s
    }

    /// Returns the longest unbroken time so far, s. A criterion that was met for a single frame stays met.
    pub fn longest_s(&self) -> f64 {
        self.longest_s
    }

    /// Returns true once `enough_s` seconds were reached, with 1 ns of tolerance for rounding.
    pub fn has_reached(&self, enough_s: f64) -> bool {
        self.longest_s >= enough_s - 1e-9
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaving_the_range_resets_the_time() {
        let mut time = UnbrokenTime::default();
        // Twice 1.9 s with one step between them: 3.8 s in total, but never 2 s without a break.
        for k in 0..39 {
            time.add(k != 19, 0.1);
        }
        assert!((time.longest_s() - 1.9).abs() < 1e-9 && !time.has_reached(2.0), "{time:?}");
        time.add(true, 0.1);
        assert!(time.has_reached(2.0) && (time.now_s() - 2.0).abs() < 1e-9, "{time:?}");
        time.add(false, 0.1);
        assert!(time.has_reached(2.0) && time.now_s() == 0.0, "what was reached stays reached: {time:?}");
    }
}
