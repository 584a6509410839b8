//! A network with helpers: an estimator of the driver, an advice that it corrects, a probe, and a predictor of gain that withholds advice.
//! In: an [`Observation`] each step. Out: an [`Action`] each hold.
//!
//! A network that corrects a controller or another network is a residual policy (Silver 2018; PeRP 2023 has one over a piecewise-constant
//! policy). Its output is added to the other's speed, so that an untrained network is as good as the advice that it corrects.

use super::{CorrectedAdvice, EngagedAdvice, ExpectedGain, Network};
use crate::policy::{
    Action, DriverEstimator, NetworkInput, Observation, Policy, Probe, WhoDrives, identification::Identification,
};

/// Time for which withheld advice stays withheld, s. Without advice the driver reveals nothing, the estimate of the driver decays, and
/// advice that returns too soon does its harm again.
const SILENCE_STANDS_S: f64 = 600.0;

/// A policy with its estimator, corrected advice, probe and predictor of gain.
pub struct AssistedPolicy {
    network: Box<dyn Policy>,
    driver: Option<Identification>,
    corrected: Option<EngagedAdvice>,
    probe: Option<Probe>,
    expected_gain: Option<ExpectedGain>,
    silent_until_s: f64,
    step_s: f64,
}

impl AssistedPolicy {
    /// Returns a newly engaged policy with steps of `step_s` seconds, before anything is known of the driver.
    pub fn new(
        network: Box<dyn Policy>,
        estimator: Option<DriverEstimator>,
        corrected: Option<CorrectedAdvice>,
        probe: Option<Probe>,
        expected_gain: Option<ExpectedGain>,
        step_s: f64,
    ) -> Self {
        let corrected = corrected.map(|advice| EngagedAdvice::new(&advice, step_s));
        Self {
            network,
            driver: estimator.map(Identification::new),
            corrected,
            probe,
            expected_gain,
            silent_until_s: 0.0,
            step_s,
        }
    }

    /// Returns the observation with the corrected advice's speed and the estimate of the driver.
    fn assisted(&self, time_s: f64, observation: &Observation) -> Observation {
        let corrected_mps = self.corrected.as_ref().map(|advice| advice.speed_mps(time_s, observation));
        let seen = self.who_drives().map_or(*observation, |driver| driver.complete_observation(observation));
        Observation { corrected_mps, ..seen }
    }
}

impl Policy for AssistedPolicy {
    fn watch(&mut self, observation: &Observation) {
        if let Some(driver) = &mut self.driver {
            driver.watch(observation, self.step_s);
        }
        if let Some(advice) = &mut self.corrected {
            advice.watch(observation);
        }
    }

    fn act(&mut self, time_s: f64, observation: &Observation) -> Action {
        let seen = self.assisted(time_s, observation);
        let action = residual(seen.corrected_mps, self.network.act(time_s, &seen));
        self.probe.map_or(action, |probe| probe.added_to(action, time_s, observation.hold_s))
    }

    fn abstains(&mut self, time_s: f64, observation: &Observation) -> bool {
        let seen = self.assisted(time_s, observation);
        if self.network.abstains(time_s, &seen) {
            return true;
        }
        if time_s >= self.silent_until_s && self.expected_gain.as_ref().is_some_and(|gain| gain.asks_for_silence(&seen))
        {
            self.silent_until_s = time_s + SILENCE_STANDS_S;
        }
        time_s < self.silent_until_s
    }

    fn needs_driver_traits(&self) -> bool {
        self.driver.is_none() && self.network.needs_driver_traits()
    }

    fn observes_driver(&self) -> bool {
        self.network.observes_driver()
            || self.corrected.as_ref().is_some_and(EngagedAdvice::observes_driver)
            || self.driver.as_ref().is_some_and(Identification::observes_driver)
    }

    fn inputs(&self) -> &[NetworkInput] {
        self.network.inputs()
    }

    fn trained_holds_s(&self) -> Option<[f64; 2]> {
        self.network.trained_holds_s()
    }

    fn advised_share(&self) -> f64 {
        self.network.advised_share()
    }

    fn who_drives(&self) -> Option<WhoDrives> {
        self.driver.as_ref().map(Identification::who_drives)
    }
}

impl Network {
    /// Returns a newly engaged policy with steps of `step_s` seconds.
    pub fn policy(self, step_s: f64) -> Box<dyn Policy> {
        let (estimator, gain) = (self.estimator.clone(), self.expected_gain.clone());
        let (corrected, probe) = (self.corrected.clone(), self.probe);
        match (&estimator, &corrected, &probe, &gain) {
            (None, None, None, None) => Box::new(self),
            _ => Box::new(AssistedPolicy::new(Box::new(self), estimator, corrected, probe, gain, step_s)),
        }
    }
}

/// Returns the advised speed plus the correction, never below 0; without corrected advice, or for an acceleration, the action itself.
pub fn residual(corrected_mps: Option<f64>, action: Action) -> Action {
    match (corrected_mps, action) {
        (Some(advised_mps), Action::Speed(correction_mps)) => Action::Speed((advised_mps + correction_mps).max(0.0)),
        _ => action,
    }
}
