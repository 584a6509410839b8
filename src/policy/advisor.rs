//! Who asks the policy, or hears what is advised from outside. In: an observation each step. Out: each hold the advice that stands from
//! now on.

use super::{Action, Advice, Hold, MeanSpeed, Observation, OutsideAdvice, Policy, WhoDrives};
use crate::time::Tick;

/// The shown speed goes no further than this beyond what the driver has reached, m/s, before another hold adds to it.
const LEAD_MPS: f64 = 1.0;

/// The speed to show for an acceleration `a` held for `hold_s`, m/s: what it leads to (docs/decisions.md: 2), from the
/// speed that is shown already, so that the target keeps moving before a driver has begun to follow it. Started from the
/// driver's speed in each hold, an advice of 0.5 m/s2 held 0.1 s shows a standing driver 0.05 m/s for ever, and nobody
/// pulls away for that.
pub fn shown_mps(shown_before_mps: Option<f64>, speed_mps: f64, a: f64, hold_s: f64) -> f64 {
    let from = shown_before_mps.map_or(speed_mps, |shown| shown.clamp(speed_mps - LEAD_MPS, speed_mps + LEAD_MPS));
    (from + a * hold_s).max(0.0)
}

/// Who says what is advised.
enum AdviceOrigin {
    Nobody,
    /// It is asked once a hold.
    Policy(Box<dyn Policy>),
    /// Somebody who speaks before the step that an advice begins with.
    Outside(OutsideAdvice),
}

/// Asks a policy once a hold and turns its action into advice.
pub struct Advisor {
    origin: AdviceOrigin,
    hold: Hold,
    range_mps: f64,
    steps: u64,
    mean_speed: MeanSpeed,
    standing: Option<Advice>,
}

/// What is to be said of a hold that a policy was not trained for; it sees the nearest that it was.
pub fn untrained_hold(policy: &dyn Policy, hold: Hold) -> Option<String> {
    let hold_s = hold.seconds();
    let [low, high] = policy.trained_holds_s()?;
    let is_trained = (low - 1e-9..=high + 1e-9).contains(&hold_s);
    (!is_trained)
        .then(|| format!("the policy was trained for holds of {low} to {high} s and is asked to hold for {hold_s} s"))
}

impl Advisor {
    /// An advisor that asks `policy` (`None` never advises) every `hold` and allows `range_mps` on either side of the target.
    pub fn new(policy: Option<Box<dyn Policy>>, hold: Hold, range_mps: f64) -> Self {
        Self::of(policy.map_or(AdviceOrigin::Nobody, AdviceOrigin::Policy), hold, range_mps)
    }

    /// An advisor that asks nobody: what is advised is said by [`Advisor::say`], for `hold` each time.
    pub fn from_outside(hold: Hold, range_mps: f64) -> Self {
        Self::of(AdviceOrigin::Outside(OutsideAdvice::default()), hold, range_mps)
    }

    fn of(origin: AdviceOrigin, hold: Hold, range_mps: f64) -> Self {
        let mean_speed = MeanSpeed::default();
        Self { origin, hold, range_mps, steps: 0, mean_speed, standing: None }
    }

    /// Says from outside what is advised from the next step on; without effect where a policy is asked.
    pub fn say(&mut self, action: Action) {
        if let AdviceOrigin::Outside(outside) = &mut self.origin {
            outside.say(action);
        }
    }

    /// What whoever advises is told in the step that begins with this observation: beside it the hold, the mean speed and what stands.
    pub fn told(&self, observation: &Observation) -> Observation {
        let mut mean_speed = self.mean_speed;
        Observation {
            hold_s: self.hold.seconds(),
            mean_speed_mps: mean_speed.watch(observation.speed_mps, self.hold.step_s()),
            advised_mps: self.standing.map(|advice| advice.target_mps),
            ..*observation
        }
    }

    /// One step has begun at `now`. Returns the advice if it was issued in this step.
    pub fn step(&mut self, now: Tick, observation: &Observation, speed_limit_mps: f64) -> Option<Advice> {
        if matches!(self.origin, AdviceOrigin::Nobody) {
            return None;
        }
        let observation = &self.told(observation);
        self.mean_speed.watch(observation.speed_mps, self.hold.step_s());
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
            log::warn!("the policy answered {observation:?} with {number}; the last advice stands");
        }
        // What was advised before stands; at the beginning, the speed that is driven.
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
        self.standing = Some(Advice { issued: now, hold, action, target_mps, range_mps, is_fallback, driver });
        self.standing
    }

    /// What the policy makes of the driver now, if it asks.
    pub fn who_drives(&self) -> Option<WhoDrives> {
        match &self.origin {
            AdviceOrigin::Policy(policy) => policy.who_drives(),
            AdviceOrigin::Nobody | AdviceOrigin::Outside(_) => None,
        }
    }

    /// The advice that stands now.
    pub fn standing(&self) -> Option<Advice> {
        self.standing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::{ConstantSpeed, PolicySettings, build};

    struct Brake;
    impl Policy for Brake {
        fn act(&mut self, _: f64, _: &Observation) -> Action {
            Action::Acceleration(-0.5)
        }
    }

    fn at(speed_mps: f64) -> Observation {
        Observation { speed_mps, ..Observation::default() }
    }

    #[test]
    fn an_advice_stands_for_its_hold_and_no_longer() {
        let mut advisor = Advisor::new(Some(Box::new(ConstantSpeed { speed_mps: 4.0 })), Hold::of_steps(7, 0.1), 0.5);
        let issued: Vec<u64> = (0..22)
            .filter_map(|k| advisor.step(Tick(k * 10), &at(0.0), 30.0).map(|advice| advice.issued.0 / 10))
            .collect();
        assert_eq!(issued, [0, 7, 14, 21]);
    }

    #[test]
    fn what_is_said_outside_begins_in_the_next_step_whenever_that_is_and_stands_until_the_next_word() {
        let hold = Hold::of_steps(10, 0.1);
        let mut outside = Advisor::from_outside(hold, 0.5);
        let mut policy = Advisor::new(Some(Box::new(Brake)), hold, 0.5);
        let seen = |k: u64| at(4.0 - 0.01 * k as f64);
        for k in 0..35 {
            // The third step of an agent that came within a hold of the others.
            if k % 10 == 3 {
                assert_eq!(outside.told(&seen(k)).hold_s, 1.0);
                outside.say(Action::Acceleration(-0.5));
            }
            let issued = outside.step(Tick(k * 10), &seen(k), 30.0);
            assert_eq!(issued.is_some(), k % 10 == 3, "step {k}");
        }
        let first = 4.0 - 0.03 - 0.5;
        let advised: Vec<f64> = [first, first - 0.5, first - 1.0, first - 1.5].to_vec();
        // No further below the driver than an advisor goes: 1 m/s, before the hold adds to it.
        let expected = advised[3].max(4.0 - 0.33 - 1.0 - 0.5);
        assert!((outside.standing().unwrap().target_mps - expected).abs() < 1e-12, "{:?}", outside.standing());
        // Said when a policy is asked it is the policy's advice to the bit.
        let mut same = Advisor::from_outside(hold, 0.5);
        for k in 0..35 {
            if k % 10 == 0 {
                same.say(Action::Acceleration(-0.5));
            }
            let issued = (same.step(Tick(k * 10), &seen(k), 30.0), policy.step(Tick(k * 10), &seen(k), 30.0));
            assert_eq!(issued.0, issued.1, "step {k}");
            assert_eq!(same.told(&seen(k)), policy.told(&seen(k)));
        }
        policy.say(Action::Speed(9.0));
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
    fn the_shown_speed_of_an_acceleration_moves_on_before_the_driver_does_but_not_out_of_reach() {
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
    fn a_policy_that_answers_with_no_number_leaves_the_last_advice_standing_and_marks_it() {
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
    fn a_silent_policy_is_not_asked_and_nothing_stands() {
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
        // It is asked again a hold later.
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
    fn a_misspelt_policy_is_answered_with_the_names_that_exist() {
        let settings = PolicySettings { aim_mps: 0.0, equilibrium_mps: 4.362, step_s: 0.1 };
        let error = build("folower-stopper", &settings).err().unwrap().to_string();
        let begins = "policy `folower-stopper` is unknown (did you mean follower-stopper?); known are auto, none, constant, two-phase, follower-stopper, pi, linear-feedback, ring-250-";
        assert!(error.starts_with(begins) && error.contains("ring-250-speed, "), "{error}");
        assert!(
            error.ends_with("or the FILE.toml or FILE.onnx of a trained one, or a controller's FILE.toml"),
            "{error}"
        );
    }
    #[test]
    fn auto_is_the_shipped_speed_policy_of_the_map_and_two_phase_elsewhere() {
        use super::super::{file_of, resolve, resolve_among, shipped};
        use crate::{data_folders, map::RoadMap};
        let on = |policy: &str, map: &str| resolve(policy, &RoadMap::load(map).unwrap());
        assert_eq!(on("auto", "ring-250").words(), "ring-250-speed (auto: the policy that is shipped for ring-250)");
        assert_eq!(on("auto", "ring-641").name, "ring-641-speed");
        assert_eq!(on("auto", "practice").words(), "two-phase (auto: no policy is shipped for practice)");
        assert_eq!(on("pi", "ring-250").words(), "pi");
        // The same ring by its path, and as a copy of any name.
        let net = data_folders::root().join("maps/ring-250/net.xml");
        assert_eq!(on("auto", &net.to_string_lossy()).name, "ring-250-speed");
        assert_eq!(on("auto", &net.parent().unwrap().to_string_lossy()).name, "ring-250-speed");
        let folder = tempfile::tempdir().unwrap();
        let copy = folder.path().join("other.net.xml");
        std::fs::copy(&net, &copy).unwrap();
        assert_eq!(on("auto", &copy.to_string_lossy()).name, "ring-250-speed");
        // Another road that has the name of one that is shipped is not that one.
        let other = folder.path().join("ring-250");
        std::fs::create_dir(&other).unwrap();
        std::fs::copy(data_folders::root().join("maps/ring-641/net.xml"), other.join("net.xml")).unwrap();
        assert_eq!(on("auto", &other.to_string_lossy()).name, "ring-641-speed");
        let text = std::fs::read_to_string(&net).unwrap().replace("speed=\"30.000000\"", "speed=\"20.000000\"");
        std::fs::write(other.join("net.xml"), text).unwrap();
        assert_eq!(on("auto", &other.to_string_lossy()).words(), "two-phase (auto: no policy is shipped for ring-250)");
        let none = resolve_among(&[], "auto", &RoadMap::load("ring-250").unwrap());
        assert!(none.words().starts_with("two-phase (auto: no shipped policies at "), "{none:?}");
        let settings = PolicySettings { aim_mps: 0.0, equilibrium_mps: 4.362, step_s: 0.1 };
        for name in shipped() {
            assert!(file_of(&name).is_some_and(|file| file.exists()));
            assert!(build(&name, &settings).is_ok_and(|policy| policy.is_some()), "{name}");
        }
    }
}
