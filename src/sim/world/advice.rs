//! The policy of a drive and when its advice appears. In: what it observes, when the traffic is asked for a step. Out: the
//! advice, when that step begins; and the speeds that the drive is about. m/s.

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

/// What stands for a policy's name where advice comes from outside.
const OUTSIDE: &str = "outside";

/// Speeds that this drive is about, m/s: the speedometer's scale follows from them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedSpeeds {
    /// Speed at which an even ring of these cars flows.
    pub equilibrium_mps: f64,
    /// Upper edge of the range around the policy's aim.
    pub advised_mps: f64,
    /// Highest speed limit of the route.
    pub limit_mps: f64,
}

/// The policy that advises, and its next advice.
pub(super) struct AdviceSource {
    /// The policy's name, and how it came to that one.
    pub policy: policy::ResolvedPolicy,
    pub expected: ExpectedSpeeds,
    /// It sees who drives in the lanes beside. Looking for them takes memory, which a drive does without.
    pub sees_lanes_beside: bool,
    /// Each vehicle has a policy of its own, engaged from this; `None` where advice comes from outside.
    source: Option<Arc<PolicySource>>,
    advisor: Advisor,
    /// Shown when the step begins that it was asked for.
    next: Option<Advice>,
}

impl AdviceSource {
    /// Builds the scenario's policy for this road.
    pub fn new(scenario: &Scenario, map: &RoadMap) -> Result<Self, WorldError> {
        let settings = policy_settings(scenario, &map.route);
        let resolved = resolve(scenario, map);
        let source = Arc::new(read(&resolved.name, scenario, map, &settings)?);
        let policy = source.engage();
        if policy.as_deref().is_some_and(Policy::must_be_told_who_drives) {
            return Err(PolicyError::MustBeTold { name: resolved.name }.into());
        }
        // What nobody chose, policy and hold, is no mistake of anybody's.
        let is_chosen =
            resolved.name != policy::resolve(policy::AUTO, map).name || scenario.hold_s != Scenario::default().hold_s;
        if let Some(policy) = policy.as_deref().filter(|_| is_chosen)
            && let Some(warning) = policy::untrained_hold(policy, scenario.hold())
        {
            // Once: a study begins hundreds of drives.
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

    /// Advice that is said from outside, and no policy.
    pub fn from_outside(scenario: &Scenario, map: &RoadMap, sees_lanes_beside: bool) -> Self {
        let policy = policy::ResolvedPolicy { name: OUTSIDE.into(), why: None };
        let expected = expected_speeds(scenario, map, &policy_settings(scenario, &map.route));
        let advisor = Advisor::from_outside(scenario.hold(), scenario.range_mps());
        Self { policy, expected, sees_lanes_beside, source: None, advisor, next: None }
    }

    /// The same once more for another vehicle: a policy is engaged anew.
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

    /// True if there is a policy.
    pub fn advises(&self) -> bool {
        self.policy.name != "none"
    }

    /// Asks the policy for the step that begins at `now`.
    pub fn ask(&mut self, now: Tick, observation: &Observation, limit_mps: f64) {
        self.next = self.advisor.step(now, observation, limit_mps);
    }

    /// What whoever advises is told of this observation ([`Advisor::told`]).
    pub fn told(&self, observation: &Observation) -> Observation {
        self.advisor.told(observation)
    }

    /// Says from outside what is advised from the next step on ([`Advisor::say`]).
    pub fn say(&mut self, action: Action) {
        self.advisor.say(action);
    }

    /// The advice that is new in the step that begins, once.
    pub fn issue(&mut self) -> Option<Advice> {
        self.next.take()
    }

    /// True while an advice stands.
    pub fn stands(&self) -> bool {
        self.advisor.standing().is_some()
    }
}

/// What a drive is about whose policies are built from these.
fn expected_speeds(scenario: &Scenario, map: &RoadMap, settings: &PolicySettings) -> ExpectedSpeeds {
    ExpectedSpeeds {
        equilibrium_mps: settings.equilibrium_mps,
        advised_mps: settings.aim_or_automatic_mps() + scenario.range_mps(),
        limit_mps: map.route.lanes().iter().map(|lane| lane.speed_limit_mps).fold(0.0, f64::max),
    }
}

/// Which policy a scenario asks for. `auto` is no advice on networks: nobody has trained a policy for them.
fn resolve(scenario: &Scenario, map: &RoadMap) -> policy::ResolvedPolicy {
    if scenario.advises_nobody() && scenario.policy != "none" {
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

/// The policy of this name, if the road of the scenario has what it needs.
fn read(name: &str, scenario: &Scenario, map: &RoadMap, settings: &PolicySettings) -> Result<PolicySource, WorldError> {
    let source = PolicySource::read(name, settings)?;
    if !scenario.is_on_network() {
        return match source.lacks(RoadKind::ClosedRoute) {
            Some(why) => Err(WorldError::PolicyNeedsNetwork { policy: name.into(), why }),
            None => Ok(source),
        };
    }
    // By their names alone they take the aim of an even ring.
    let aims = matches!(name, "constant" | "follower-stopper" | "linear-feedback") && scenario.policy_speed_mps <= 0.0;
    let aim = || aims.then(|| "aims for the speed at which an even ring flows".to_owned());
    match source.lacks(RoadKind::Network(lanes_beside(map))).or_else(aim) {
        Some(why) => Err(WorldError::PolicyNeedsRing { policy: name.into(), why }),
        None => Ok(source),
    }
}

/// The speed at which an even ring of this scenario's cars flows, m/s, and what else a policy is built from.
pub(super) fn policy_settings(scenario: &Scenario, route: &Route) -> PolicySettings {
    if scenario.is_on_network() {
        // A free road: its limit.
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

/// The scenario's IDM with the desired speed capped by the road's lowest speed limit, as the engines cap it lane by lane.
pub(super) fn limited_idm(scenario: &Scenario, route: &Route) -> IdmParams {
    let limit_mps = route.lanes().iter().map(|lane| lane.speed_limit_mps).fold(f64::INFINITY, f64::min);
    IdmParams { v0: scenario.idm.v0.min(limit_mps), ..scenario.idm }
}
