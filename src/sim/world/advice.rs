//! The policy of a drive, and the timing of each vehicle's advice. In: a planned drive; an observation, when the traffic engine is asked
//! for a step. Out: the advice, when that step begins; and the expected speeds of the drive. m/s.

use super::WorldError;
use crate::{
    driver::manoeuvres::lanes_beside,
    idm::IdmParams,
    map::Route,
    policy::{
        self, Action, Advice, Advisor, LanesBeside, Observation, Policy, PolicyError, PolicySettings, PolicySource,
        ReplayedAdvice, RoadKind,
    },
    scenario::{PlannedDrive, Scenario},
    space::CAR_LENGTH_M,
    time::Tick,
};

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

/// Contents of observations that cost time, which drives without them save.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CostlyInputs {
    /// True if observations include the lanes beside.
    pub lanes_beside: bool,
    /// True if observations include the vehicle behind.
    pub follower: bool,
    /// True if observations include the observed driver ([`DriverObserver`](crate::policy::DriverObserver)).
    pub driver: bool,
}

impl CostlyInputs {
    /// Returns true if observations include vehicles other than the leader.
    pub(super) fn has_others(self) -> bool {
        self.lanes_beside || self.follower
    }
}

/// Source of the advice of all vehicles of a drive.
pub(super) struct DriveAdvice {
    /// Name of the policy, and the reason if it differs from the request.
    pub policy: policy::ResolvedPolicy,
    pub expected: ExpectedSpeeds,
    road: RoadKind,
    /// Costly inputs of the policy, or of what advises from outside.
    sees: CostlyInputs,
    /// Each vehicle engages its own policy from this source; `None` if advice comes from outside.
    source: Option<PolicySource>,
    /// Advice of the participant's vehicle in place of the policy's: that of another drive.
    pub sham: Option<ReplayedAdvice>,
}

/// Advice of one vehicle.
pub(super) struct VehicleAdvice {
    /// Kind of road that the policy sees.
    pub road: RoadKind,
    /// Costly inputs of what advises.
    pub sees: CostlyInputs,
    advisor: Advisor,
    /// Advice to show when the step for which it was asked begins.
    next: Option<Advice>,
}

impl DriveAdvice {
    /// Builds the scenario's policy for this road.
    pub fn new(drive: &PlannedDrive) -> Result<Self, WorldError> {
        let (scenario, map) = (drive.scenario(), drive.map());
        let (settings, road) = (policy_settings(drive), road_kind(drive));
        let (resolved, source) = policy_of(drive)?;
        let policy = source.engage();
        // Do not warn about defaults of policy and hold.
        let is_chosen =
            resolved.name != policy::resolve(policy::AUTO, map).name || scenario.hold_s != Scenario::default().hold_s;
        if let Some(policy) = policy.as_deref().filter(|_| is_chosen) {
            warn_untrained(policy, drive);
        }
        let inputs = policy.as_deref().map_or(&[][..], Policy::inputs);
        let sees = CostlyInputs {
            lanes_beside: source.lacks(RoadKind::Network(LanesBeside::default())).is_some(),
            follower: inputs.iter().any(|input| input.feature.is_of_follower()),
            driver: policy.as_deref().is_some_and(Policy::observes_driver),
        };
        let expected = expected_speeds(drive, &settings);
        Ok(Self { policy: resolved, expected, road, sees, source: Some(source), sham: None })
    }

    /// Returns a source whose advice is set from outside, without a policy.
    pub fn from_outside(drive: &PlannedDrive, sees: CostlyInputs) -> Self {
        let policy = policy::ResolvedPolicy { name: OUTSIDE.into(), why: None };
        let expected = expected_speeds(drive, &policy_settings(drive));
        Self { policy, expected, road: road_kind(drive), sees, source: None, sham: None }
    }

    /// Returns the advice of the participant's vehicle.
    pub fn of_participant(&mut self, scenario: &Scenario) -> VehicleAdvice {
        match self.sham.take() {
            Some(sham) => self.advised_by(Advisor::new(Some(Box::new(sham)), scenario.hold(), scenario.range_mps())),
            None => self.of_vehicle(scenario),
        }
    }

    /// Returns the advice of a vehicle; its policy is newly engaged.
    pub fn of_vehicle(&self, scenario: &Scenario) -> VehicleAdvice {
        let (hold, range_mps) = (scenario.hold(), scenario.range_mps());
        self.advised_by(match &self.source {
            Some(source) => Advisor::new(source.engage(), hold, range_mps),
            None => Advisor::from_outside(hold, range_mps, self.sees.driver),
        })
    }

    fn advised_by(&self, advisor: Advisor) -> VehicleAdvice {
        VehicleAdvice { road: self.road, sees: self.sees, advisor, next: None }
    }

    /// Returns true if the policy is not `none`.
    pub fn advises(&self) -> bool {
        self.policy.name != "none"
    }
}

impl VehicleAdvice {
    /// Asks the policy for the step that begins at `now`.
    pub fn ask(&mut self, now: Tick, observation: &Observation, limit_mps: f64) {
        self.next = self.advisor.step(now, observation, limit_mps);
    }

    /// Completes an observation as the policy gets it ([`Advisor::complete_observation`]).
    pub fn complete_observation(&self, observation: &Observation) -> Observation {
        self.advisor.complete_observation(observation)
    }

    /// Returns true if no policy is asked ([`Advisor::is_from_outside`]).
    pub fn is_from_outside(&self) -> bool {
        self.advisor.is_from_outside()
    }

    /// Sets the action to advise from the next step on ([`Advisor::set_action`]).
    pub fn set_action(&mut self, action: Action) {
        self.advisor.set_action(action);
    }

    /// Takes the advice that is new in the step that begins.
    pub fn issue(&mut self) -> Option<Advice> {
        self.next.take()
    }

    /// Returns the advice in force; between [`VehicleAdvice::ask`] and the step's beginning that of the step.
    pub fn standing(&self) -> Option<Advice> {
        self.advisor.standing()
    }
}

/// Warns about a hold, a road or a share that the policy was not made for; once, as a study begins hundreds of drives.
fn warn_untrained(policy: &dyn Policy, drive: &PlannedDrive) {
    static SAID: std::sync::Once = std::sync::Once::new();
    let length = drive.fixed_vehicles().filter(|_| drive.logged().is_none()).and_then(|vehicles| {
        let circumference_m = drive.map().route.length_m();
        policy::untrained_length(policy, &Observation { circumference_m, vehicles, ..Observation::default() })
    });
    let vehicles = drive.fixed_vehicles();
    let share = policy::untrained_share(policy, drive.advised().share_of(vehicles.unwrap_or(1)), vehicles);
    let hold = policy::untrained_hold(policy, drive.scenario().hold());
    let warnings: Vec<String> = [hold, length, share].into_iter().flatten().collect();
    if !warnings.is_empty() {
        SAID.call_once(|| warnings.iter().for_each(|warning| log::warn!("{warning}")));
    }
}

/// Returns the expected speeds of a drive with these settings of the policy.
fn expected_speeds(drive: &PlannedDrive, settings: &PolicySettings) -> ExpectedSpeeds {
    ExpectedSpeeds {
        equilibrium_mps: settings.equilibrium_mps,
        advised_mps: settings.aim_or_automatic_mps() + drive.scenario().range_mps(),
        limit_mps: drive.map().route.lanes().iter().map(|lane| lane.speed_limit_mps).fold(0.0, f64::max),
    }
}

/// Resolves and reads the policy of a drive.
///
/// # Errors
/// The policy is unknown, its file cannot be used, or it needs what this road or a whole drive lacks.
pub fn policy_of(drive: &PlannedDrive) -> Result<(policy::ResolvedPolicy, PolicySource), WorldError> {
    let (settings, road) = (policy_settings(drive), road_kind(drive));
    let resolved = resolve(drive, road);
    let source = read(&resolved.name, drive, road, &settings)?;
    if source.engage().as_deref().is_some_and(Policy::needs_driver_traits) {
        return Err(PolicyError::MustBeTold { name: resolved.name }.into());
    }
    Ok((resolved, source))
}

/// Resolves the scenario's policy. On networks `auto` is `none`, as no policy is shipped for them.
fn resolve(drive: &PlannedDrive, road: RoadKind) -> policy::ResolvedPolicy {
    let scenario = drive.scenario();
    if scenario.advises_no_vehicle() && scenario.policy != "none" {
        let alone =
            if scenario.participant { "" } else { ", only the participant's vehicle, which this drive does not have" };
        let why = format!("{}: no vehicle is advised (advised is {}{alone})", scenario.policy, scenario.advised);
        return policy::ResolvedPolicy { name: "none".into(), why: Some(why) };
    }
    if road.is_network() && scenario.policy == policy::AUTO {
        let road = if drive.logged().is_some() { "an open lane" } else { "networks" };
        let why = format!("{}: no policy is shipped for {road}", policy::AUTO);
        return policy::ResolvedPolicy { name: "none".into(), why: Some(why) };
    }
    policy::resolve(&scenario.policy, drive.map())
}

/// Reads the policy of this name; fails if the scenario's road lacks a property that the policy needs.
fn read(
    name: &str,
    drive: &PlannedDrive,
    road: RoadKind,
    settings: &PolicySettings,
) -> Result<PolicySource, WorldError> {
    let source = match drive.own_policy() {
        Some(own) if name != "none" => own.clone(),
        _ => PolicySource::read(name, settings)?,
    };
    let policy = source.engage();
    let inputs = policy.as_deref().map_or(&[][..], Policy::inputs);
    if let Some(input) = inputs.iter().find(|input| input.feature.is_of_whole_ring()) {
        return Err(PolicyError::SeesWholeRing { name: name.into(), feature: input.feature.name() }.into());
    }
    // Without a set speed these controllers aim for a ring's equilibrium speed.
    let aims =
        matches!(name, "constant" | "follower-stopper" | "linear-feedback") && drive.scenario().policy_speed_mps <= 0.0;
    let aim = (aims && drive.is_open()).then(|| "aims for the equilibrium speed of a ring".to_owned());
    let Some(why) = source.lacks(road).or(aim) else { return Ok(source) };
    let policy = name.into();
    Err(match road.is_network() {
        true => WorldError::PolicyNeedsRing { policy, why },
        false => WorldError::PolicyNeedsNetwork { policy, why },
    })
}

/// Returns the kind of road that policies see in this drive. An open lane with a fixed number of vehicles is a path without junctions.
pub fn road_kind(drive: &PlannedDrive) -> RoadKind {
    let is_closed = drive.map().route.is_closed() && !drive.is_open();
    if is_closed { RoadKind::ClosedRoute } else { RoadKind::Network(lanes_beside(drive.map())) }
}

/// Returns the settings that policies are built from: target speed, equilibrium speed, m/s, and step, s. The equilibrium speed is that of
/// the ring with even gaps, with traffic of a file the mean speed of the vehicle ahead of the ego; where vehicles enter and leave, a free
/// road is driven at its limit.
pub fn policy_settings(drive: &PlannedDrive) -> PolicySettings {
    let (scenario, route) = (drive.scenario(), &drive.map().route);
    let (model, limit_mps) = (drive.traffic_drivers().typical().model, limited_idm(scenario, route).v0);
    let equilibrium_mps = match drive.fixed_vehicles() {
        _ if drive.logged().is_some() => drive.logged_mean_speed_mps(),
        Some(vehicles) => model.equilibrium_speed_mps(route.length_m() / f64::from(vehicles) - CAR_LENGTH_M, limit_mps),
        None => limit_mps,
    };
    PolicySettings { aim_mps: scenario.policy_speed_mps, equilibrium_mps, step_s: scenario.step_s }
}

/// Returns the scenario's IDM with the desired speed capped at the road's lowest speed limit; the engines cap it lane by lane.
pub(super) fn limited_idm(scenario: &Scenario, route: &Route) -> IdmParams {
    let limit_mps = route.lanes().iter().map(|lane| lane.speed_limit_mps).fold(f64::INFINITY, f64::min);
    IdmParams { v0: scenario.idm.v0.min(limit_mps), ..scenario.idm }
}
