//! The hold of an action. In: seconds from a user or a file, and the length of a step. Out: a whole number of steps, also given in
//! seconds.

/// A whole number of steps, at least one.
///
/// # Examples
///
/// ```
/// # extern crate codrive_core as codrive;
/// use codrive::policy::Hold;
///
/// let hold = Hold::new(2.5, 0.5)?;
/// assert_eq!((hold.steps(), hold.seconds()), (5, 2.5));
/// // Not a whole number of steps: refused, or taken to the nearest one.
/// assert!(Hold::new(0.7, 0.5).is_err());
/// assert_eq!(Hold::nearest(0.7, 0.5).seconds(), 0.5);
/// # Ok::<(), codrive::policy::HoldError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    steps: u32,
    step_s: f64,
}

/// Error for a duration that is not a whole number of steps.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("hold_s is {hold_s}; allowed: a whole number of steps of {step_s} s")]
pub struct HoldError {
    /// Hold as requested, s.
    pub hold_s: f64,
    /// Length of a step, s.
    pub step_s: f64,
}

impl Hold {
    /// Returns a hold of `hold_s` seconds.
    ///
    /// # Errors
    /// `hold_s` is not a whole number of steps of `step_s`, or is less than one step.
    pub fn new(hold_s: f64, step_s: f64) -> Result<Self, HoldError> {
        let steps = (hold_s / step_s).round();
        let is_whole = (steps * step_s - hold_s).abs() < 1e-9 && steps >= 1.0;
        if is_whole { Ok(Self::nearest(hold_s, step_s)) } else { Err(HoldError { hold_s, step_s }) }
    }

    /// Returns the hold nearest to `hold_s` seconds.
    pub fn nearest(hold_s: f64, step_s: f64) -> Self {
        Self::of_steps((hold_s / step_s).round().max(1.0) as u32, step_s)
    }

    /// Returns a hold of `steps` steps of `step_s` seconds; 0 steps become 1.
    pub const fn of_steps(steps: u32, step_s: f64) -> Self {
        Self { steps: if steps == 0 { 1 } else { steps }, step_s }
    }

    /// Returns the number of steps.
    pub fn steps(self) -> u32 {
        self.steps
    }

    /// Returns the length of a step, s.
    pub fn step_s(self) -> f64 {
        self.step_s
    }

    /// Returns the length of the hold, s.
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
        // 0.1 is not exact in binary, yet 0.7 s is seven steps.
        assert_eq!(Hold::new(0.7, 0.1).map(Hold::steps), Ok(7));
        for (hold_s, step_s) in [(0.25, 0.1), (0.1, 0.2), (0.0, 0.1), (-0.1, 0.1), (f64::NAN, 0.1)] {
            assert!(Hold::new(hold_s, step_s).is_err(), "{hold_s} of {step_s}");
        }
        let fault = Hold::new(0.25, 0.1).expect_err("two and a half").to_string();
        assert_eq!(fault, "hold_s is 0.25; allowed: a whole number of steps of 0.1 s");
    }

    #[test]
    fn a_duration_between_two_holds_becomes_the_nearer_one() {
        let steps = [0.0, 0.04, 0.24, 0.26].map(|hold_s| Hold::nearest(hold_s, 0.1).steps());
        assert_eq!(steps, [1, 1, 2, 3]);
        assert_eq!(Hold::of_steps(0, 0.1).steps(), 1);
    }
}
