//! Source of advice: asks the policy, or takes advice from outside. In: an observation each step. Out: a new advice each hold.

use super::{
    Action, Advice, DriverObserver, Hold, MeanSpeed, Observation, OutsideAdvice, Policy, WhoDrives, length_out_of_scale,
};
use crate::time::Tick;

/// Largest difference between the shown speed, before the new hold is added, and the driver's speed, m/s.
const LEAD_MPS: f64 = 1.0;

/// Returns the speed to show for an acceleration `a` held for `hold_s`, m/s (docs/decisions.md: 2). It starts from the speed already
/// shown, so that the target moves before the driver follows. Starting from the driver's speed would show a stopped driver 0.05 m/s
/// forever for 0.5 m/s² held 0.1 s, and no driver starts for that.
pub fn shown_mps(shown_before_mps: Option<f64>, speed_mps: f64, a: f64, hold_s: f64) -> f64 {
    let from = shown_before_mps.map_or(speed_mps, |shown| shown.clamp(speed_mps - LEAD_MPS, speed_mps + LEAD_MPS));
    (from + a * hold_s).max(0.0)
}

/// Source of the advice.
enum AdviceOrigin {
    Nobody,
    /// A policy, asked once a hold.
    Policy(Box<dyn Policy>),
    /// An outside source that gives an action before the step in which the advice begins.
    Outside(OutsideAdvice),
}

/// Past of the ego and its driver that a policy sees.
#[derive(Clone)]
struct EgoHistory {
    mean_speed: MeanSpeed,
    /// Observer of the driver; `None` if the policy does not need one.
    observer: Option<DriverObserver>,
}

impl EgoHistory {
    /// Adds a step and completes its observation with the hold, the standing advice and what the past tells.
    fn completed(&mut self, observation: &Observation, hold: Hold, standing: Option<Advice>) -> Observation {
        let advised_mps = standing.map(|advice| advice.target_mps);
        let observed = self.observer.as_mut().map(|observer| {
            observer.watch(observation, advised_mps, hold.step_s());
            observer.observed()
        });
        Observation {
            hold_s: hold.seconds(),
            mean_speed_mps: self.mean_speed.watch(observation.speed_mps, hold.step_s()),
            advised_mps,
            observed: observed.unwrap_or_default(),
            ..*observation
        }
    }
}

/// Asks a policy once a hold and turns its action into advice.
pub struct Advisor {
    origin: AdviceOrigin,
    hold: Hold,
    range_mps: f64,
    steps: u64,
    history: EgoHistory,
    standing: Option<Advice>,
}

/// Returns a warning if the policy was not trained for this hold; the policy then sees the nearest trained hold.
pub fn untrained_hold(policy: &dyn Policy, hold: Hold) -> Option<String> {
    let hold_s = hold.seconds();
    let [low, high] = policy.trained_holds_s()?;
    let is_trained = (low - 1e-9..=high + 1e-9).contains(&hold_s);
    (!is_trained).then(|| format!("the hold is {hold_s} s; the policy was trained for holds of {low} to {high} s"))
}

/// Returns a warning if the policy was trained for roads of another length, or with other lengths per vehicle.
pub fn untrained_length(policy: &dyn Policy, road: &Observation) -> Option<String> {
    let input = length_out_of_scale(policy.inputs(), road)?;
    Some(format!(
        "`{}` is {:.1} m on this road; the policy was trained around {} to {} m, and its advice may be poor here",
        input.feature.name(),
        input.feature.of(road),
        input.from,
        input.to
    ))
}

/// Returns a warning if the policy was made for another share of advised vehicles than `share` of all, out of a fixed number of `vehicles` if
/// there is one. Shared, a policy for one vehicle can be worse than none (docs/results.md: several advised vehicles).
pub fn untrained_share(policy: &dyn Policy, share: f64, vehicles: Option<u32>) -> Option<String> {
    let made_for = policy.advised_share();
    let one = vehicles.map_or(0.0, |vehicles| 1.0 / f64::from(vehicles.max(1)));
    let made_for_text = match made_for {
        0.0 => "one vehicle".to_owned(),
        share => format!("{:.0} % of the vehicles", 100.0 * share),
    };
    // A share is rounded to whole vehicles. Without advised vehicles, a policy does nothing.
    let differs = share > 0.0 && (share - made_for.max(one)).abs() > 0.5 * one + 1e-9;
    differs.then(|| {
        format!(
            "{:.0} % of the vehicles are advised; the policy was made for {made_for_text}, and may slow the traffic with another share",
            100.0 * share
        )
    })
}

impl Advisor {
    /// Returns an advisor that asks `policy` every `hold` and accepts `range_mps` on either side of the target. With `None` it never
    /// advises.
    pub fn new(policy: Option<Box<dyn Policy>>, hold: Hold, range_mps: f64) -> Self {
        let is_observed = policy.as_ref().is_some_and(|policy| policy.observes_driver());
        Self::of(policy.map_or(AdviceOrigin::Nobody, AdviceOrigin::Policy), is_observed, hold, range_mps)
    }

    /// Returns an advisor whose actions come from [`Advisor::set_action`], each in force for `hold`. `observes_driver`: its observations
    /// include the observed driver.
    pub fn from_outside(hold: Hold, range_mps: f64, observes_driver: bool) -> Self {
        Self::of(AdviceOrigin::Outside(OutsideAdvice::default()), observes_driver, hold, range_mps)
    }

    fn of(origin: AdviceOrigin, is_observed: bool, hold: Hold, range_mps: f64) -> Self {
        let history =
            EgoHistory { mean_speed: MeanSpeed::default(), observer: is_observed.then(DriverObserver::default) };
        Self { origin, hold, range_mps, steps: 0, history, standing: None }
    }

    /// Returns true if actions come from [`Advisor::set_action`] alone; their advice depends on no road ahead.
    pub fn is_from_outside(&self) -> bool {
        matches!(self.origin, AdviceOrigin::Outside(_))
    }

    /// Sets the action to advise from the next step on; no effect if a policy is asked.
    pub fn set_action(&mut self, action: Action) {
        if let AdviceOrigin::Outside(outside) = &mut self.origin {
            outside.set_action(action);
        }
    }

    /// Completes an observation with the hold, the mean speed, the current advice and the observed driver, as the policy gets it in
    /// this step.
    pub fn complete_observation(&self, observation: &Observation) -> Observation {
        self.history.clone().completed(observation, self.hold, self.standing)
    }

    /// Advances by one step that begins at `now`. Returns the advice if one was issued in this step.
    pub fn step(&mut self, now: Tick, observation: &Observation, speed_limit_mps: f64) -> Option<Advice> {
        if matches!(self.origin, AdviceOrigin::Nobody) {
            return None;
        }
        let observation = &self.history.completed(observation, self.hold, self.standing);
        let due = self.steps.is_multiple_of(u64::from(self.hold.steps()));
        let time_s = self.steps as f64 * self.hold.step_s();
        self.steps += 1;
        let (action, driver) = match &mut self.origin {
            AdviceOrigin::Nobody => return None,
            AdviceOrigin::Outside(outside) => (outside.take()?, None),
            AdviceOrigin::Policy(policy) => {
                policy.watch(observation);
                if !due {
                    return None;
                }
                if policy.abstains(time_s, observation) {
                    self.standing = None;
                    return None;
                }
                let action = policy.act(time_s, observation);
                (action, policy.driver_estimate())
            }
        };
        let (Action::Acceleration(number) | Action::Speed(number)) = action;
        let is_fallback = !number.is_finite();
        if is_fallback && !self.standing.is_some_and(|advice| advice.is_fallback) {
            log::warn!("the policy gave {number} for the observation {observation:?}; the last advice remains");
        }
        // Without a finite number the previous target stays in force; in the first hold it is the current speed.
        let action = match (is_fallback, self.standing) {
            (false, _) => action,
            (true, Some(before)) => Action::Speed(before.target_mps),
            (true, None) => Action::Speed(observation.speed_mps),
        };
        let speed_mps = match action {
            Action::Acceleration(a) => {
                let shown = self.standing.map(|advice| advice.target_mps);
                shown_mps(shown, observation.speed_mps, a, self.hold.seconds())
            }
            Action::Speed(v) => v,
        };
        let target_mps = speed_mps.clamp(0.0, speed_limit_mps.max(0.0));
        let (hold, range_mps) = (self.hold, self.range_mps);
        let observed = self.history.observer.is_some().then_some(observation.observed);
        self.standing =
            Some(Advice { issued: now, hold, action, target_mps, range_mps, is_fallback, driver, observed });
        self.standing
    }

    /// Returns the policy's current estimate of the driver, if it has an estimator.
    pub fn who_drives(&self) -> Option<WhoDrives> {
        match &self.origin {
            AdviceOrigin::Policy(policy) => policy.who_drives(),
            AdviceOrigin::Nobody | AdviceOrigin::Outside(_) => None,
        }
    }

    /// Returns the advice in force.
    pub fn standing(&self) -> Option<Advice> {
        self.standing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::{ConstantSpeed, PolicySettings, build};

    /// Policy that was made for this share of advised vehicles.
    struct Shared(f64);
    impl Policy for Shared {
        fn act(&mut self, _: f64, _: &Observation) -> Action {
            Action::Speed(0.0)
        }

        fn advised_share(&self) -> f64 {
            self.0
        }
    }

    #[test]
    fn a_share_that_a_policy_was_not_made_for_is_warned_of() {
        let warned = |made_for, share, vehicles| untrained_share(&Shared(made_for), share, vehicles);
        // One of 22 vehicles is what all policies are made for; a share is rounded to whole vehicles.
        assert_eq!(
            [warned(0.0, 1.0 / 22.0, Some(22)), warned(0.2, 4.0 / 22.0, Some(22)), warned(1.0, 1.0, Some(22))],
            [None, None, None]
        );
        let text = warned(0.0, 11.0 / 22.0, Some(22)).expect("a warning");
        assert!(text.starts_with("50 % of the vehicles are advised; the policy was made for one vehicle,"), "{text}");
        let text = warned(0.2, 0.25, None).expect("a warning");
        assert!(
            text.starts_with("25 % of the vehicles are advised; the policy was made for 20 % of the vehicles,"),
            "{text}"
        );
        let text = warned(0.5, 1.0 / 22.0, Some(22)).expect("a warning");
        assert!(
            text.starts_with("5 % of the vehicles are advised; the policy was made for 50 % of the vehicles,"),
            "{text}"
        );
        assert!(
            warned(0.0, 0.01, None).is_some() && warned(0.0, 0.0, None).is_none() && warned(0.5, 0.0, None).is_none()
        );
    }

    struct Brake;
    impl Policy for Brake {
        fn act(&mut self, _: f64, _: &Observation) -> Action {
            Action::Acceleration(-0.5)
        }

        fn observes_driver(&self) -> bool {
            true
        }
    }

    fn at(speed_mps: f64) -> Observation {
        Observation { speed_mps, ..Observation::default() }
    }

    #[test]
    fn an_advice_is_in_force_for_its_hold_and_no_longer() {
        let mut advisor = Advisor::new(Some(Box::new(ConstantSpeed { speed_mps: 4.0 })), Hold::of_steps(7, 0.1), 0.5);
        let issued: Vec<u64> = (0..22)
            .filter_map(|k| advisor.step(Tick(k * 10), &at(0.0), 30.0).map(|advice| advice.issued.0 / 10))
            .collect();
        assert_eq!(issued, [0, 7, 14, 21]);
    }

    #[test]
    fn outside_advice_begins_in_the_next_step_and_stays_until_it_is_replaced() {
        let hold = Hold::of_steps(10, 0.1);
        let mut outside = Advisor::from_outside(hold, 0.5, true);
        let mut policy = Advisor::new(Some(Box::new(Brake)), hold, 0.5);
        let seen = |k: u64| at(4.0 - 0.01 * k as f64);
        for k in 0..35 {
            // Given at step 3 of each ten, as to an agent that entered in the middle of the others' hold.
            if k % 10 == 3 {
                assert_eq!(outside.complete_observation(&seen(k)).hold_s, 1.0);
                outside.set_action(Action::Acceleration(-0.5));
            }
            let issued = outside.step(Tick(k * 10), &seen(k), 30.0);
            assert_eq!(issued.is_some(), k % 10 == 3, "step {k}");
        }
        let first = 4.0 - 0.03 - 0.5;
        let advised: Vec<f64> = [first, first - 0.5, first - 1.0, first - 1.5].to_vec();
        // The target is at most 1 m/s below the driver's speed before the hold is added.
        let expected = advised[3].max(4.0 - 0.33 - 1.0 - 0.5);
        assert!((outside.standing().unwrap().target_mps - expected).abs() < 1e-12, "{:?}", outside.standing());
        // Outside advice given at the steps at which a policy is asked equals the policy's advice bit for bit.
        let mut same = Advisor::from_outside(hold, 0.5, true);
        for k in 0..35 {
            if k % 10 == 0 {
                same.set_action(Action::Acceleration(-0.5));
            }
            let issued = (same.step(Tick(k * 10), &seen(k), 30.0), policy.step(Tick(k * 10), &seen(k), 30.0));
            assert_eq!(issued.0, issued.1, "step {k}");
            assert_eq!(same.complete_observation(&seen(k)), policy.complete_observation(&seen(k)));
        }
        policy.set_action(Action::Speed(9.0));
        assert!(policy.step(Tick(400), &seen(35), 30.0).is_none(), "a policy is asked, and nobody else");
    }

    #[test]
    fn an_acceleration_is_shown_as_the_speed_it_leads_to() {
        let mut advisor = Advisor::new(Some(Box::new(Brake)), Hold::of_steps(50, 0.1), 0.5);
        let advice = advisor.step(Tick(0), &at(4.0), 30.0).unwrap();
        assert_eq!((advice.action, advice.target_mps), (Action::Acceleration(-0.5), 1.5));
        let mut advisor = Advisor::new(Some(Box::new(Brake)), Hold::of_steps(100, 0.1), 0.5);
        assert_eq!(advisor.step(Tick(0), &at(4.0), 30.0).unwrap().target_mps, 0.0, "never backwards");
    }

    #[test]
    fn the_shown_speed_moves_before_the_driver_does_but_stays_within_reach() {
        struct Pull;
        impl Policy for Pull {
            fn act(&mut self, _: f64, _: &Observation) -> Action {
                Action::Acceleration(0.5)
            }
        }
        let mut advisor = Advisor::new(Some(Box::new(Pull)), Hold::of_steps(1, 0.1), 0.5);
        let shown: Vec<f64> =
            (0..40).filter_map(|k| advisor.step(Tick(k * 10), &at(0.0), 30.0)).map(|a| a.target_mps).collect();
        assert!((shown[9] - 0.5).abs() < 1e-12, "{shown:?}");
        assert!((shown[39] - 1.05).abs() < 1e-12, "{shown:?}");
    }

    #[test]
    fn a_target_never_exceeds_the_speed_limit() {
        let mut advisor = Advisor::new(Some(Box::new(ConstantSpeed { speed_mps: 99.0 })), Hold::of_steps(1, 0.1), 0.5);
        assert_eq!(advisor.step(Tick(0), &at(0.0), 17.88).unwrap().target_mps, 17.88);
    }

    #[test]
    fn a_policy_that_returns_nan_leaves_the_last_advice_in_force_and_marked() {
        struct Broken(u32);
        impl Policy for Broken {
            fn act(&mut self, _: f64, _: &Observation) -> Action {
                self.0 += 1;
                Action::Acceleration(if self.0 == 2 { 0.5 } else { f64::NAN })
            }
        }
        let mut advisor = Advisor::new(Some(Box::new(Broken(0))), Hold::of_steps(10, 0.1), 0.5);
        let issued: Vec<(f64, bool)> = (0..40)
            .filter_map(|k| advisor.step(Tick(k * 10), &at(3.0), 30.0))
            .map(|advice| (advice.target_mps, advice.is_fallback))
            .collect();
        assert_eq!(issued, [(3.0, true), (3.5, false), (3.5, true), (3.5, true)]);
    }

    #[test]
    fn a_policy_that_abstains_is_not_asked_and_no_advice_is_in_force() {
        struct Shy;
        impl Policy for Shy {
            fn abstains(&mut self, _: f64, observation: &Observation) -> bool {
                observation.speed_mps < 1.0
            }
            fn act(&mut self, _: f64, observation: &Observation) -> Action {
                Action::Speed(observation.speed_mps)
            }
        }
        let mut advisor = Advisor::new(Some(Box::new(Shy)), Hold::of_steps(10, 0.1), 0.5);
        assert!(advisor.step(Tick(0), &at(0.5), 30.0).is_none() && advisor.standing().is_none());
        // The policy is asked again one hold later.
        let issued: Vec<u64> =
            (1..20).filter_map(|k| advisor.step(Tick(k * 10), &at(3.0), 30.0)).map(|a| a.issued.0).collect();
        assert_eq!(issued, [100]);
        assert!(advisor.step(Tick(200), &at(0.5), 30.0).is_none() && advisor.standing().is_none());
    }

    #[test]
    fn the_edges_of_the_range_belong_to_it() {
        let mut advisor = Advisor::new(Some(Box::new(ConstantSpeed { speed_mps: 4.0 })), Hold::of_steps(1, 0.1), 0.5);
        let advice = advisor.step(Tick(0), &at(0.0), 30.0).unwrap();
        assert!(advice.accepts(3.5) && advice.accepts(4.5) && !advice.accepts(3.499) && !advice.accepts(4.501));
    }

    #[test]
    fn a_misspelt_policy_name_is_answered_with_the_existing_names() {
        let settings = PolicySettings { aim_mps: 0.0, equilibrium_mps: 4.362, step_s: 0.1 };
        let error = build("folower-stopper", &settings).err().unwrap().to_string();
        let begins = "policy `folower-stopper` is unknown (did you mean follower-stopper?); allowed: auto, none, constant, \
             two-phase, follower-stopper, pi, linear-feedback, ring-250-";
        assert!(error.starts_with(begins) && error.contains("ring-250-speed, "), "{error}");
        assert!(
            error.ends_with("the FILE.toml or FILE.onnx of a trained policy, or the FILE.toml of a controller"),
            "{error}"
        );
    }
}
