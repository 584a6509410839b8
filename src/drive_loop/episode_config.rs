//! Settings of an episode: those of a drive ([`Scenario`]), and those of a learner, shared with training on rings
//! ([`TrainConfig`]). In: a map, settings by their keys. Out: an [`EpisodeConfig`], checked against its road, or the
//! invalid key and the allowed values.

use crate::{
    driver::{self, Population},
    map::RoadMap,
    policy::{Feature, Hold, LARGEST_LENGTH, LanesBeside, NetworkInput, Observation, RoadKind, length_out_of_scale},
    scenario::{PlanError, PlannedDrive, Scenario, StartLayout},
    settings::{self, Field, SettingsError, fields_of},
    sim::{CostlyInputs, road_kind},
    traffic::Demand,
    train::{DriverConfig, FollowKind, TrainConfig, inputs},
};
use serde_json::Value;
use std::sync::Arc;

/// Keys of training that episodes share: actions, observations and rewards of a policy.
const OF_TRAINING: [&str; 10] = [
    "action",
    "levels",
    "accel_limit_mps2",
    "top_speed_mps",
    "speed_change_mps",
    "sees",
    "horizon_s",
    "reward",
    "action_penalty",
    "collision_penalty",
];
/// Table of training that episodes share as a whole.
const SCALING: &str = "scaling";

/// Keys of a drive that an episode lacks, with the alternative.
const NOT_OF_EPISODES: [(&str, &str); 7] = [
    ("policy", "the actions of an episode are its advice"),
    ("policy_speed_mps", "built-in policies use it; the actions of an episode are its advice"),
    ("sham_advice", "sham advice comes from another drive; the actions of an episode are its advice"),
    ("duration_s", "horizon_s is the length of an episode"),
    ("seed", "each episode begins with its own seed"),
    ("residual_over", CORRECTS_NOTHING),
    ("residual_mps", CORRECTS_NOTHING),
];
/// Reason why an episode of a drive corrects no controller.
const CORRECTS_NOTHING: &str = "the action is the whole advice of a drive; only the rings of training add it to the \
    advice of a controller";

/// Name for late drivers: each with their own reaction time, error and habit, as in training by default.
pub const LATE: &str = "late";

/// Settings of an episode, except for its seed.
#[derive(Clone, Debug, PartialEq)]
pub struct EpisodeConfig {
    /// Settings of the drive. Its policy, duration and seed have no effect here.
    pub scenario: Scenario,
    /// Settings of actions, observations, rewards and drawn drivers; the others follow the drive.
    pub learning: TrainConfig,
    /// True if each advised vehicle of each episode has a driver drawn by `learning`; false if all have the scenario's
    /// driver.
    pub draws_drivers: bool,
    road: Arc<RoadMap>,
}

/// Default observation on a network, and on a closed route far longer or shorter than the rings of training.
const SEEN_ELSEWHERE: &str = "speed,leader_speed,gap,speed_limit";

/// Key and error of a setting.
type Fault = (&'static str, String);

impl EpisodeConfig {
    /// Returns the settings of a map with some replaced, checked as a whole. By default the shipped rings have the
    /// traffic of training, other roads that of a drive. On a network, and on a closed route whose length is beyond the
    /// scale of circumferences, a learner observes the speed limit where a ring has its circumference. On all roads
    /// except the shipped rings, speeds are advised and scaled up to the highest limit of the route. `demand` gives the
    /// vehicles that enter a network. `driver` is one that [`driver::named`] knows, a population, or [`LATE`].
    ///
    /// # Errors
    /// There is no such map or driver, a value has the wrong type or is out of range, or the settings do not fit each
    /// other or the road.
    pub fn new(
        map: &str,
        driver: Option<&str>,
        demand: Demand,
        changes: &[(Field, Value)],
    ) -> Result<Self, SettingsError> {
        let of_ring = TrainConfig::of_ring(map);
        let is_ring = of_ring.is_some();
        let (base, mut learning) = of_ring.map_or_else(|| elsewhere(map), |ring| on_ring(map, ring));
        let known = Scenario::fields();
        let is_of_drive = |change: &&(Field, Value)| known.iter().any(|own| own.path == change.0.path);
        let of_drive: Vec<_> = changes.iter().filter(is_of_drive).cloned().collect();
        let scenario = settings::changed(&Scenario { demand, ..base }, &of_drive)?;
        let road = Arc::new(scenario.load_map().map_err(|error| fault("map", error))?);
        // An episode has the learner's horizon, and with a file of trajectories ends with the file at the latest.
        let endless = Scenario { duration_s: 0.0, ..scenario.clone() };
        let drive = PlannedDrive::of_learner(&endless, road).map_err(plan_fault)?;
        let road = Arc::clone(drive.map());
        if !is_ring {
            let limits_mps = road.route.lanes().iter().map(|lane| lane.speed_limit_mps);
            let limit_mps = limits_mps.fold(0.0, f64::max).clamp(1.0, 60.0);
            (learning.advice.top_speed_mps, learning.network.scaling.speed_to_mps) = (limit_mps, limit_mps);
        }
        // Constraints of rings do not apply to the learner's settings: each value is checked alone here, and all
        // together below.
        let mut json = serde_json::to_value(&learning).unwrap_or_default();
        for (field, value) in changes.iter().filter(|change| !is_of_drive(change)) {
            if let Some(message) = field.fault(value) {
                return Err(SettingsError { key: field.path.clone(), message });
            }
            field.set(&mut json, value.clone());
        }
        let learning = serde_json::from_value(json).map_err(|error| fault("", error))?;
        let mut whole = Self { scenario, learning, draws_drivers: false, road }.aligned();
        if whole.unseen_fault(&drive).is_some() && !changes.iter().any(|(field, _)| field.path == "sees") {
            whole.learning.network.sees = SEEN_ELSEWHERE.into();
        }
        let whole = match driver {
            Some(driver) => whole.driven_by(driver)?,
            None => whole,
        };
        whole.check(&drive).map_err(|(key, message)| SettingsError { key: key.into(), message })?;
        Ok(whole)
    }

    /// Returns the settings, those of the drive first.
    pub fn fields() -> Vec<Field> {
        let of_drive = Scenario::fields().into_iter().filter(|field| not_of_episodes(&field.path).is_none());
        let is_of_training = |field: &Field| {
            OF_TRAINING.contains(&field.path.as_str()) || field.table().is_some_and(|table| table == SCALING)
        };
        of_drive.chain(fields_of::<TrainConfig>().into_iter().filter(is_of_training)).collect()
    }

    /// Returns why a key of drives or of training is no setting of an episode, as text that follows the key; `None` for
    /// other keys.
    pub fn why_not(key: &str) -> Option<&'static str> {
        let of_rings = "it is a setting of rings only; whole drives use the settings of codrive run";
        not_of_episodes(key).or_else(|| {
            let is_known = |fields: &[Field]| fields.iter().any(|field| field.path == key);
            (!is_known(&Self::fields()) && is_known(&fields_of::<TrainConfig>())).then_some(of_rings)
        })
    }

    /// Sets the driver by its name.
    fn driven_by(self, name: &str) -> Result<Self, SettingsError> {
        if name == LATE {
            let driver = DriverConfig { follow: FollowKind::Driver, ..self.learning.driver };
            return Ok(Self { learning: TrainConfig { driver, ..self.learning }, draws_drivers: true, ..self });
        }
        if let Ok(population) = Population::named(name) {
            let learning = self.learning.driven_by_some_of(population);
            return Ok(Self { learning, draws_drivers: true, ..self });
        }
        let named = driver::named(name).map_err(|error| fault("driver", error))?;
        let scenario = Scenario { driver: named.text, ..self.scenario };
        Ok(Self { scenario, ..self })
    }

    /// Copies the settings that learner and drive share from the drive to the learner.
    fn aligned(self) -> Self {
        let Self { scenario, mut learning, .. } = self;
        learning.advice.hold_s = scenario.hold_s;
        learning.advice.hold_max_s = 0.0;
        learning.ring.step_s = scenario.step_s;
        learning.ring.warm_up_s = scenario.warm_up_s;
        learning.ring.traffic_drivers.clone_from(&scenario.traffic_drivers);
        learning.ring.idm = scenario.idm;
        (learning.ring.vehicles_min, learning.ring.vehicles_max) = (scenario.vehicles, scenario.vehicles);
        learning.reward.range_mph = scenario.range_mph;
        Self { scenario, learning, ..self }
    }

    /// Returns the time for which one action holds.
    pub fn hold(&self) -> Hold {
        self.scenario.hold()
    }

    /// Returns the scaled inputs of the learner's network.
    pub fn inputs(&self) -> Vec<NetworkInput> {
        self.learning.inputs()
    }

    /// Returns the drive of the episode of this seed, without an end of its own.
    ///
    /// # Errors
    /// The scenario was changed to one that its road does not allow.
    pub fn drive(&self, seed: u64) -> Result<PlannedDrive, PlanError> {
        let scenario = Scenario { policy: "none".into(), duration_s: 0.0, seed, ..self.scenario.clone() };
        PlannedDrive::of_learner(&scenario, Arc::clone(&self.road))
    }

    /// Checks the settings against each other and against the road; each alone is within its limits already.
    fn check(&self, drive: &PlannedDrive) -> Result<(), Fault> {
        let horizon_s = self.learning.ring.horizon_s;
        if self.scenario.hold_s > horizon_s {
            return Err((
                "hold_s",
                format!("hold_s is {}; allowed: at most the horizon of {horizon_s} s", self.scenario.hold_s),
            ));
        }
        if self.learning.advice.levels == 1 {
            return Err(("levels", "levels is 1; allowed: 0 (continuous) or at least 2".into()));
        }
        inputs::check_names(&self.learning.network.sees).map_err(|fault| ("sees", fault))?;
        if !self.inputs().iter().all(NetworkInput::is_sound) {
            return Err(("scaling", "scaling: each `to` must be above its `from`".into()));
        }
        if let Some(feature) =
            self.inputs().iter().map(|input| input.feature).find(|feature| is_of_rings_alone(*feature))
        {
            let why = match feature {
                Feature::ControllerSpeed => "there is no controller besides the action",
                _ => "the kind of driver cannot be observed; only the rings of training give it",
            };
            let text = format!("sees names `{}`, which whole drives do not have: {why}", feature.name());
            return Err(("sees", text));
        }
        // On a network without agents, orders to the traffic take the place of actions.
        if !drive.is_open() && drive.advised().is_no_vehicle() {
            let advised = drive.scenario().advised;
            let text =
                format!("advised is {advised}; allowed: at least one vehicle, so that the actions have a receiver");
            return Err(("advised", text));
        }
        self.unseen_fault(drive).map_or(Ok(()), |text| Err(("sees", text)))
    }

    /// Returns why an input cannot be observed on this road, or not in the scale of the settings: the length of a closed
    /// route, or its share per vehicle. The shipped rings are what the scale is made for.
    fn unseen_fault(&self, drive: &PlannedDrive) -> Option<String> {
        let road = road_kind(drive);
        if let Some(input) = self.inputs().iter().find(|input| !input.feature.is_seen_on(road)) {
            let kind = if road.is_network() { "path through a network" } else { "closed route" };
            return Some(format!("sees names `{}`; this {kind} has none", input.feature.name()));
        }
        if TrainConfig::RINGS.contains(&self.scenario.map.as_str()) {
            return None;
        }
        let (circumference_m, vehicles) = (drive.map().route.length_m(), drive.scenario().vehicles);
        let road = Observation { circumference_m, vehicles, ..Observation::default() };
        let inputs = self.inputs();
        let input = length_out_of_scale(&inputs, &road)?;
        let (name, scaled, length_m) = (input.feature.name(), input.scaled(&road), input.feature.of(&road));
        Some(format!(
            "sees names `{name}`, which is {length_m:.0} m here and {scaled:.1} in the scale of {} to {} m; allowed: \
             -{LARGEST_LENGTH} to {LARGEST_LENGTH}\n  remedy: set scaling.{name}_from_m and scaling.{name}_to_m around \
             this length, or use speed_limit instead",
            input.from, input.to
        ))
    }

    /// Returns what the learner observes beyond its own vehicle, the leader and the road.
    pub(super) fn costly_inputs(&self) -> CostlyInputs {
        let alone = RoadKind::Network(LanesBeside::default());
        let inputs = self.inputs();
        let any = |is_seen: &dyn Fn(Feature) -> bool| inputs.iter().any(|input| is_seen(input.feature));
        CostlyInputs {
            lanes_beside: any(&|feature| !feature.is_seen_on(alone) && !feature.is_seen_on(RoadKind::BareRing)),
            follower: any(&Feature::is_of_follower),
            driver: any(&Feature::is_observed),
        }
    }
}

/// Checks for a feature that can be observed on the rings of training, and in no whole drive.
fn is_of_rings_alone(feature: Feature) -> bool {
    feature.is_of_driver() || feature == Feature::ControllerSpeed
}

/// Returns the settings of a drive and of a learner on a ring of training.
fn on_ring(map: &str, learning: TrainConfig) -> (Scenario, TrainConfig) {
    let ring = &learning.ring;
    let scenario = Scenario {
        map: map.into(),
        vehicles: ring.vehicles_min,
        traffic_drivers: ring.traffic_drivers.clone(),
        idm: ring.idm,
        start: if ring.bunched_share >= 0.5 { StartLayout::Bunched } else { StartLayout::Even },
        warm_up_s: ring.warm_up_s,
        step_s: ring.step_s,
        hold_s: learning.advice.hold_s,
        ..Scenario::default()
    };
    (scenario, learning)
}

/// Returns the settings of a drive and of a learner on any other road.
fn elsewhere(map: &str) -> (Scenario, TrainConfig) {
    let scenario = Scenario { map: map.into(), ..Scenario::default() };
    let mut learning = TrainConfig::default();
    learning.ring.horizon_s = scenario.duration_s;
    (scenario, learning)
}

/// Returns the fault of a drive that its road does not allow.
fn plan_fault(error: PlanError) -> SettingsError {
    match error {
        PlanError::Map(error) => fault("map", error),
        PlanError::Setting { key, message, .. } => fault(key, message),
    }
}

fn not_of_episodes(key: &str) -> Option<&'static str> {
    NOT_OF_EPISODES.iter().find(|(refused, _)| *refused == key).map(|(_, instead)| *instead)
}

fn fault(key: &str, message: impl ToString) -> SettingsError {
    SettingsError { key: key.into(), message: message.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_of_drives_and_training_is_defined_alike_in_both() {
        let of_drives = Scenario::fields();
        let of_both: Vec<(Field, &Field)> = fields_of::<TrainConfig>()
            .into_iter()
            .filter_map(|field| of_drives.iter().find(|other| other.path == field.path).map(|other| (field, other)))
            .collect();
        for (field, other) in &of_both {
            let [defined, in_drives] = [field, *other]
                .map(|field| (field.path.clone(), field.doc.clone(), field.unit.clone(), field.kind.clone()));
            assert_eq!(defined, in_drives);
        }
        let mut names: Vec<&str> = of_both.iter().map(|(field, _)| field.path.as_str()).collect();
        names.retain(|name| !name.starts_with("idm."));
        assert_eq!(names, ["hold_s", "advised", "traffic_drivers", "step_s", "warm_up_s", "range_mph", "seed"]);
    }
}
