//! A network that is told who drives by its own estimator. In: an [`Observation`] each step. Out: an [`Action`] each hold.

use super::{Action, DriverEstimate, DriverEstimator, Network, Observation, Policy, identification::Identification};

/// A network and what it knows of its driver.
#[derive(Clone, Debug)]
pub struct PersonalPolicy {
    network: Network,
    driver: Identification,
    step_s: f64,
}

impl PersonalPolicy {
    /// Engaged now with a driver of whom nothing is known, to be asked each `step_s` seconds.
    pub fn new(network: Network, estimator: DriverEstimator, step_s: f64) -> Self {
        Self { network, driver: Identification::new(estimator), step_s }
    }

    fn told(&self, observation: &Observation) -> Observation {
        Observation { driver: Some(self.driver.estimate().mean), ..*observation }
    }
}

impl Policy for PersonalPolicy {
    fn watch(&mut self, observation: &Observation) {
        self.driver.watch(observation, self.step_s);
    }

    fn act(&mut self, _time_s: f64, observation: &Observation) -> Action {
        self.network.action(&self.told(observation))
    }

    fn abstains(&self, observation: &Observation) -> bool {
        self.network.abstains(observation)
    }

    fn trained_holds_s(&self) -> Option<[f64; 2]> {
        self.network.trained_holds_s()
    }

    fn driver_estimate(&self) -> Option<DriverEstimate> {
        Some(self.driver.estimate())
    }
}
