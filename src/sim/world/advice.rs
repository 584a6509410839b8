//! The policy of a drive and the timing of its advice. In: an observation, when the traffic engine is asked for a step. Out: the advice,
//! when that step begins; and the expected speeds of the drive. m/s.

use super::{WorldError, lane_beside::lanes_beside, sham};
use crate::{
    idm::IdmParams,
    map::{RoadMap, Route},
    policy::{
        self, Action, Advice, Advisor, LanesBeside, Observation, Policy, PolicyError, PolicySettings, PolicySource,
        RoadKind,
    },
    scenario::Scenario,
    space::CAR_LENGTH_M,
    time::Tick,
};
use std::sync::Arc;

/// Name in place of a policy's if advice comes from outside.
const OUTSIDE: &str = "outside";

/// Expected speeds of a drive, m/s; the speedometer's scale follows from them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedSpeeds {
    /// Equilibrium speed of the ring with even gaps; on a network the desired speed on a free road.
    pub equilibrium_mps: f64,
    /// Upper edge of the acceptable range around the policy's target.
    pub advised_mps: f64,
    /// Highest speed limit of the route.
    pub limit_mps: f64,
}

/// Source of one vehicle's advice, with its next advice.
pub(super) struct AdviceSource {
    /// Name of the policy, and the reason if it differs from the request.
    pub policy: policy::ResolvedPolicy,
    pub expected: ExpectedSpeeds,
    /// True if the policy observes the lanes beside; computing them takes memory, which other drives save.
    pub sees_lanes_beside: bool,
    /// Each vehicle engages its own policy from this source; `None` if advice comes from outside.
    source: Option<Arc<PolicySource>>,
    advisor: Advisor,
    /// Advice to show when the step for which it was asked begins.
    next: Option<Advice>,
}

impl AdviceSource {
    /// Builds the scenario's policy for this road.
    pub fn new(scenario: &Scenario, map: &RoadMap) -> Result<Self, WorldError> {
        let settings = policy_settings(scenario, &map.route);
        let resolved = resolve(scenario, map);
        let source = Arc::new(read(&resolved.name, scenario, map, &settings)?);
        let policy = source.engage();
        if policy.as_deref().is_some_and(Policy::needs_driver_traits) {
            return Err(PolicyError::MustBeTold { name: resolved.name }.into());
        }
        // Do not warn about defaults of policy and hold.
        let is_chosen =
            resolved.name != policy::resolve(policy::AUTO, map).name || scenario.hold_s != Scenario::default().hold_s;
        if let Some(policy) = policy.as_deref().filter(|_| is_chosen)
            && let Some(warning) = policy::untrained_hold(policy, scenario.hold())
        {
            // Warn once, as a study begins hundreds of drives.
            static SAID: std::sync::Once = std::sync::Once::new();
            SAID.call_once(|| log::warn!("{warning}"));
        }
        let expected = expected_speeds(scenario, map, &settings);
        let policy = match policy {
            Some(_) if scenario.sham_advice => Some(Box::new(sham::advice(scenario)?) as Box<dyn Policy>),
            policy => policy,
        };
        let advisor = Advisor::new(policy, scenario.hold(), scenario.range_mps());
        let sees_lanes_beside = source.lacks(RoadKind::Network(LanesBeside::default())).is_some();
        Ok(Self { policy: resolved, expected, sees_lanes_beside, source: Some(source), advisor, next: None })
    }

    /// Returns a source whose advice is set from outside, without a policy.
    pub fn from_outside(scenario: &Scenario, map: &RoadMap, sees_lanes_beside: bool) -> Self {
        let policy = policy::ResolvedPolicy { name: OUTSIDE.into(), why: None };
        let expected = expected_speeds(scenario, map, &policy_settings(scenario, &map.route));
        let advisor = Advisor::from_outside(scenario.hold(), scenario.range_mps());
        Self { policy, expected, sees_lanes_beside, source: None, advisor, next: None }
    }

    /// Returns a source of the same kind for another vehicle; its policy is newly engaged.
    pub fn another(&self, scenario: &Scenario) -> Self {
        let (hold, range_mps) = (scenario.hold(), scenario.range_mps());
        let advisor = match &self.source {
            Some(source) => Advisor::new(source.engage(), hold, range_mps),
            None => Advisor::from_outside(hold, range_mps),
        };
        Self {
            policy: self.policy.clone(),
            expected: self.expected,
            sees_lanes_beside: self.sees_lanes_beside,
            source: self.source.clone(),
            advisor,
            next: None,
        }
    }

    /// Returns true if the policy is not `none`.
    pub fn advises(&self) -> bool {
        self.policy.name != "none"
    }

    /// Asks the policy for the step that begins at `now`.
    pub fn ask(&mut self, now: Tick, observation: &Observation, limit_mps: f64) {
        self.next = self.advisor.step(now, observation, limit_mps);
    }

    /// Completes an observation as the policy gets it ([`Advisor::complete_observation`]).
    pub fn complete_observation(&self, observation: &Observation) -> Observation {
        self.advisor.complete_observation(observation)
    }

    /// Sets the action to advise from the next step on ([`Advisor::set_action`]).
    pub fn set_action(&mut self, action: Action) {
        self.advisor.set_action(action);
    }

    /// Takes the advice that is new in the step that begins.
    pub fn issue(&mut self) -> Option<Advice> {
        self.next.take()
    }

    /// Returns true while an advice is in force.
    pub fn stands(&self) -> bool {
        self.advisor.standing().is_some()
    }
}

/// Returns the expected speeds of a drive with these settings of the policy.
fn expected_speeds(scenario: &Scenario, map: &RoadMap, settings: &PolicySettings) -> ExpectedSpeeds {
    ExpectedSpeeds {
        equilibrium_mps: settings.equilibrium_mps,
        advised_mps: settings.aim_or_automatic_mps() + scenario.range_mps(),
        limit_mps: map.route.lanes().iter().map(|lane| lane.speed_limit_mps).fold(0.0, f64::max),
    }
}

/// Resolves the scenario's policy. On networks `auto` is `none`, as no policy is shipped for them.
fn resolve(scenario: &Scenario, map: &RoadMap) -> policy::ResolvedPolicy {
    if scenario.advises_no_vehicle() && scenario.policy != "none" {
        let alone = if scenario.participant { "" } else { ", the participant's alone, which is not there" };
        let why = format!("{}: nobody is advised (advised is {}{alone})", scenario.policy, scenario.advised);
        return policy::ResolvedPolicy { name: "none".into(), why: Some(why) };
    }
    if !scenario.is_on_network() {
        return policy::resolve(&scenario.policy, map);
    }
    if scenario.policy == policy::AUTO {
        let why = format!("{}: no policy is shipped for networks", policy::AUTO);
        return policy::ResolvedPolicy { name: "none".into(), why: Some(why) };
    }
    policy::ResolvedPolicy { name: scenario.policy.clone(), why: None }
}

/// Reads the policy of this name; fails if the scenario's road lacks a property that the policy needs.
fn read(name: &str, scenario: &Scenario, map: &RoadMap, settings: &PolicySettings) -> Result<PolicySource, WorldError> {
    let source = PolicySource::read(name, settings)?;
    if !scenario.is_on_network() {
        return match source.lacks(RoadKind::ClosedRoute) {
            Some(why) => Err(WorldError::PolicyNeedsNetwork { policy: name.into(), why }),
            None => Ok(source),
        };
    }
    // Without a set speed these controllers aim for a ring's equilibrium speed.
    let aims = matches!(name, "constant" | "follower-stopper" | "linear-feedback") && scenario.policy_speed_mps <= 0.0;
    let aim = || aims.then(|| "aims for the speed at which an even ring flows".to_owned());
    match source.lacks(RoadKind::Network(lanes_beside(map))).or_else(aim) {
        Some(why) => Err(WorldError::PolicyNeedsRing { policy: name.into(), why }),
        None => Ok(source),
    }
}

/// Returns the settings that policies are built from: target speed, equilibrium speed of the ring with even gaps, m/s, and step, s.
pub(super) fn policy_settings(scenario: &Scenario, route: &Route) -> PolicySettings {
    if scenario.is_on_network() {
        // A free road is driven at its limit.
        let equilibrium_mps = limited_idm(scenario, route).v0;
        return PolicySettings { aim_mps: scenario.policy_speed_mps, equilibrium_mps, step_s: scenario.step_s };
    }
    let gap_m = route.length_m() / f64::from(scenario.vehicles) - CAR_LENGTH_M;
    PolicySettings {
        aim_mps: scenario.policy_speed_mps,
        equilibrium_mps: limited_idm(scenario, route).equilibrium_speed_mps(gap_m),
        step_s: scenario.step_s,
    }
}

/// Returns the scenario's IDM with the desired speed capped at the road's lowest speed limit; the engines cap it lane by lane.
pub(super) fn limited_idm(scenario: &Scenario, route: &Route) -> IdmParams {
    let limit_mps = route.lanes().iter().map(|lane| lane.speed_limit_mps).fold(f64::INFINITY, f64::min);
    IdmParams { v0: scenario.idm.v0.min(limit_mps), ..scenario.idm }
}
