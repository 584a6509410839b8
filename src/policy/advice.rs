//! Advice and its source. In: an [`Observation`] each step. Out: an [`Action`] from a [`Policy`] each hold, shown as [`Advice`].

use super::{DriverEstimate, Hold, NetworkInput, Observation, ObservedDriver, WhoDrives};
use crate::time::Tick;

/// Output of a policy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Acceleration to keep for the hold, m/s².
    Acceleration(f64),
    /// Speed to drive for the hold, m/s.
    Speed(f64),
}

/// One advice as shown on the speedometer.
///
/// # Examples
///
/// ```
/// # extern crate codrive_core as codrive;
/// use codrive::{
///     policy::{Action, Advice, Hold},
///     time::Tick,
/// };
///
/// let advice = Advice {
///     issued: Tick(0),
///     hold: Hold::nearest(10.0, 0.1),
///     action: Action::Speed(4.5),
///     target_mps: 4.5,
///     range_mps: 0.5,
///     is_fallback: false,
///     driver: None,
///     observed: None,
/// };
/// assert_eq!(advice.band_mps(), (4.0, 5.0));
/// assert!(advice.accepts(4.0) && !advice.accepts(5.1));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advice {
    /// Tick at which the advice was issued.
    pub issued: Tick,
    /// Time that the advice stays in force.
    pub hold: Hold,
    /// Action as the policy returned it.
    pub action: Action,
    /// Speed to drive, m/s, within 0 and the speed limit.
    pub target_mps: f64,
    /// Half width of the acceptable range, m/s: target +- this.
    pub range_mps: f64,
    /// True if the policy returned no finite number and the previous target stays in force.
    pub is_fallback: bool,
    /// Estimate of the driver's traits at the issue time, if the policy has an estimator.
    pub driver: Option<DriverEstimate>,
    /// Driver as observed from their own history up to the issue time, if the policy needs it.
    pub observed: Option<ObservedDriver>,
}

impl Advice {
    /// Returns the lowest and the highest acceptable speed, m/s, never below 0.
    pub fn band_mps(&self) -> (f64, f64) {
        ((self.target_mps - self.range_mps).max(0.0), self.target_mps + self.range_mps)
    }

    /// Returns true if `speed_mps` lies in the acceptable range, edges included.
    pub fn accepts(&self, speed_mps: f64) -> bool {
        let (low, high) = self.band_mps();
        (low..=high).contains(&speed_mps)
    }
}

/// A source of actions. It is `Send`: a world is created on one thread and driven on another.
///
/// # Examples
///
/// ```
/// # extern crate codrive_core as codrive;
/// use codrive::policy::{Action, Observation, Policy};
///
/// struct CloseUp;
///
/// impl Policy for CloseUp {
///     fn act(&mut self, _time_s: f64, observation: &Observation) -> Action {
///         let extra_mps = if observation.gap_m > 20.0 { 1.0 } else { 0.0 };
///         Action::Speed(observation.leader_speed_mps + extra_mps)
///     }
/// }
///
/// let observation = Observation { leader_speed_mps: 4.0, gap_m: 25.0, ..Observation::default() };
/// assert_eq!(CloseUp.act(0.0, &observation), Action::Speed(5.0));
/// assert!(!CloseUp.abstains(0.0, &observation));
/// ```
pub trait Policy: Send {
    /// Receives every step, also within a hold; called before [`Policy::act`] in the same step.
    fn watch(&mut self, observation: &Observation) {
        let _ = observation;
    }

    /// Returns the action for the hold that begins now, `time_s` after the policy was engaged.
    fn act(&mut self, time_s: f64, observation: &Observation) -> Action;

    /// Returns true if advice would not help. Nothing is shown for the hold that begins now, `time_s` after the policy was engaged, and
    /// the driver drives without advice.
    fn abstains(&mut self, time_s: f64, observation: &Observation) -> bool {
        let _ = (time_s, observation);
        false
    }

    /// Returns the current estimate of the driver, if the policy has an estimator.
    fn who_drives(&self) -> Option<WhoDrives> {
        None
    }

    /// Returns the estimated traits of the driver, if the policy estimates traits.
    fn driver_estimate(&self) -> Option<DriverEstimate> {
        self.who_drives().and_then(|driver| driver.traits())
    }

    /// Returns true if the policy needs the driver's traits or latents as input and has no estimator for them.
    fn needs_driver_traits(&self) -> bool {
        false
    }

    /// Returns true if the policy needs the driver as observed from their own history.
    fn observes_driver(&self) -> bool {
        self.inputs().iter().any(|input| input.feature.is_observed())
    }

    /// Inputs of a trained policy with their scales; empty for controllers.
    fn inputs(&self) -> &[NetworkInput] {
        &[]
    }

    /// Shortest and longest hold seen in training, s, if the policy was trained.
    fn trained_holds_s(&self) -> Option<[f64; 2]> {
        None
    }

    /// Largest share of advised vehicles that the policy was made for, 0 to 1; 0: one vehicle.
    fn advised_share(&self) -> f64 {
        0.0
    }
}
