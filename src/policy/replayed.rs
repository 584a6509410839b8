//! Advice of another drive, repeated at the same times whatever the traffic does: the sham condition of a study. In: seconds since the
//! start. Out: the target at that time, or none.

use super::{Action, Observation, Policy};

/// Targets of a drive, one per hold.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayedAdvice {
    /// Target of each hold, m/s; `None` for a hold without advice. After the last target the first follows.
    targets_mps: Vec<Option<f64>>,
    hold_s: f64,
}

impl ReplayedAdvice {
    /// Returns a policy with these targets, each for `hold_s` seconds.
    pub fn new(targets_mps: Vec<Option<f64>>, hold_s: f64) -> Self {
        Self { targets_mps, hold_s }
    }

    /// Returns the target of the hold that contains `time_s`.
    fn at(&self, time_s: f64) -> Option<f64> {
        // The time of a hold's first step is a sum of steps; half a thousandth of a hold absorbs its rounding error.
        let hold = (time_s / self.hold_s + 5e-4).floor().max(0.0) as usize;
        *self.targets_mps.get(hold.checked_rem(self.targets_mps.len())?)?
    }
}

impl Policy for ReplayedAdvice {
    fn act(&mut self, time_s: f64, observation: &Observation) -> Action {
        Action::Speed(self.at(time_s).unwrap_or(observation.speed_mps))
    }

    fn abstains(&mut self, time_s: f64, _observation: &Observation) -> bool {
        self.at(time_s).is_none()
    }

    fn advised_share(&self) -> f64 {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_target_comes_in_its_hold_and_the_first_again_after_the_last() {
        let mut advice = ReplayedAdvice::new(vec![Some(3.0), None, Some(4.5)], 0.7);
        let seen = Observation { speed_mps: 9.0, ..Observation::default() };
        // 0.7 is not exact in binary: the second hold begins after seven steps of 0.1 s.
        let steps = |n: u32| f64::from(n) * 0.1;
        let actions: Vec<Option<Action>> = [0, 6, 7, 13, 14, 20, 21]
            .map(|n| (!advice.abstains(steps(n), &seen)).then(|| advice.act(steps(n), &seen)))
            .to_vec();
        let speed = |v: f64| Some(Action::Speed(v));
        assert_eq!(actions, [speed(3.0), speed(3.0), None, None, speed(4.5), speed(4.5), speed(3.0)]);
        assert!(ReplayedAdvice::new(Vec::new(), 1.0).abstains(0.0, &seen), "of nothing nothing is advised");
    }
}
