//! When practice has been enough: the speed was in the acceptable range for a stated time without a break. In: whether it was, step by
//! step. Out: the longest unbroken time, seconds. The window and the rehearsal count by this one rule.
//!
//! There is no grace: a step out of the range, or one without advice, sets the time back to nothing. The number on the
//! speedometer turns from green to white at the same edge, so that participant and criterion see one rule; a grace would need a
//! length and a number of its own, and a participant who drives along an edge would meet the criterion without holding the range.
//! Advice that changes sets nothing back while the speed is in the new range.

/// The time in the range without a break, and the longest so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UnbrokenTime {
    now_s: f64,
    longest_s: f64,
}

impl UnbrokenTime {
    /// A step of this length was in the range, or was not.
    pub fn add(&mut self, is_in_range: bool, step_s: f64) {
        self.now_s = if is_in_range { self.now_s + step_s } else { 0.0 };
        self.longest_s = self.longest_s.max(self.now_s);
    }

    /// How long the speed has been in the range without a break until now, seconds.
    pub fn now_s(&self) -> f64 {
        self.now_s
    }

    /// The longest of these so far, seconds: a criterion that was met within a frame stays met.
    pub fn longest_s(&self) -> f64 {
        self.longest_s
    }

    /// True once `enough_s` seconds were reached; sums of steps are off by rounding.
    pub fn has_reached(&self, enough_s: f64) -> bool {
        self.longest_s >= enough_s - 1e-9
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaving_the_range_sets_the_time_back_and_a_sum_of_parts_is_not_enough() {
        let mut time = UnbrokenTime::default();
        // Twice 1.9 s with one step between them: 3.8 s in all, and never 2 s on end.
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
