//! How long an action stands. In: the seconds that a person or a file names, and the length of a step. Out: a whole number of
//! steps, which is shown in seconds again.

/// A whole number of steps, at least one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    steps: u32,
    step_s: f64,
}

/// Seconds that are no hold.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("hold_s is {hold_s}; allowed: a whole number of steps of {step_s} s")]
pub struct HoldError {
    /// What was asked for, seconds.
    pub hold_s: f64,
    /// Length of a step, seconds.
    pub step_s: f64,
}

impl Hold {
    /// A hold of so many seconds.
    ///
    /// # Errors
    /// They are no whole number of steps of `step_s`, or none.
    pub fn new(hold_s: f64, step_s: f64) -> Result<Self, HoldError> {
        let steps = (hold_s / step_s).round();
        let is_whole = (steps * step_s - hold_s).abs() < 1e-9 && steps >= 1.0;
        if is_whole { Ok(Self::nearest(hold_s, step_s)) } else { Err(HoldError { hold_s, step_s }) }
    }

    /// The hold that is nearest to so many seconds.
    pub fn nearest(hold_s: f64, step_s: f64) -> Self {
        Self::of_steps((hold_s / step_s).round().max(1.0) as u32, step_s)
    }

    /// So many steps of `step_s` seconds; none counts as one.
    pub const fn of_steps(steps: u32, step_s: f64) -> Self {
        Self { steps: if steps == 0 { 1 } else { steps }, step_s }
    }

    /// How many steps it is.
    pub fn steps(self) -> u32 {
        self.steps
    }

    /// Length of one, seconds.
    pub fn step_s(self) -> f64 {
        self.step_s
    }

    /// How long it is.
    pub fn seconds(self) -> f64 {
        f64::from(self.steps) * self.step_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hold_is_a_whole_number_of_steps_and_at_least_one() {
        let hold = Hold::new(3.0, 0.1).expect("thirty steps");
        assert_eq!((hold.steps(), hold.step_s(), hold.seconds()), (30, 0.1, 3.0));
        // 0.1 has no end in binary: 0.7 is seven steps all the same.
        assert_eq!(Hold::new(0.7, 0.1).map(Hold::steps), Ok(7));
        for (hold_s, step_s) in [(0.25, 0.1), (0.1, 0.2), (0.0, 0.1), (-0.1, 0.1), (f64::NAN, 0.1)] {
            assert!(Hold::new(hold_s, step_s).is_err(), "{hold_s} of {step_s}");
        }
        let fault = Hold::new(0.25, 0.1).expect_err("two and a half").to_string();
        assert_eq!(fault, "hold_s is 0.25; allowed: a whole number of steps of 0.1 s");
    }

    #[test]
    fn what_is_between_two_holds_is_the_nearer_one() {
        let steps = [0.0, 0.04, 0.24, 0.26].map(|hold_s| Hold::nearest(hold_s, 0.1).steps());
        assert_eq!(steps, [1, 1, 2, 3]);
        assert_eq!(Hold::of_steps(0, 0.1).steps(), 1);
    }
}
