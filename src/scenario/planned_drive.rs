//! A scenario with its road: all that a drive is started from. In: a [`Scenario`] as written. Out: a [`PlannedDrive`]: the road, loaded
//! once, the settings that follow from it, and whether the number of vehicles is fixed.

use super::{
    AdvisedBody, AdvisedVehicles, AutomationSystem, RoadUser, Scenario, ScriptedEvent, logged_traffic::LoggedTraffic,
    scripted_event::DrivenRoad,
};
use crate::{
    map::{MapError, RoadMap},
    policy::PolicySource,
    roadside::LazyRoadside,
    traffic::TrafficDrivers,
};
use std::sync::Arc;

/// Reason why a scenario cannot be driven on its road.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The map cannot be used.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A setting is not allowed on this road.
    #[error("{message}")]
    Setting {
        /// Key of the setting in the scenario.
        key: &'static str,
        /// Part of its value, such as `.0.actions.1` of a list; empty for all of it.
        part: String,
        /// Value, allowed values and remedy.
        message: String,
    },
}

/// Settings without effect where vehicles enter and leave, with the reason.
const ONLY_WITH_FIXED_NUMBER: [(&str, &str); 6] = [
    ("vehicles", "the demand says which vehicles come"),
    ("start", "the demand says where vehicles start"),
    ("other_model", "the demand says which models vehicles have"),
    ("other_model_share", "the demand says which models vehicles have"),
    ("lateral_accel_mps2", "SUMO chooses the speeds in bends"),
    ("wave_sd_mps", "the drive begins when there is room for the ego"),
];
/// Settings without effect where the number of vehicles is fixed, with the reason.
const ONLY_ON_A_PATH: [(&str, &str); 2] = [
    ("path_start_m", "the ego starts at its place among the vehicles"),
    ("start_speed_mps", "the ego starts with the speed of its place among the vehicles"),
];

/// Settings without effect with traffic of a file, with the reason.
const NOT_BEHIND_A_LOG: [(&str, &str); 3] = [
    ("path_start_m", "the ego starts behind the vehicles of the file"),
    ("start_speed_mps", "the ego starts with the speed of the vehicle ahead"),
    ("start", "each vehicle starts at the gap of its own driver"),
];

/// A scenario resolved with its road. Clones share the road.
#[derive(Clone, Debug)]
pub struct PlannedDrive {
    scenario: Scenario,
    map: Arc<RoadMap>,
    roadside: LazyRoadside,
    fixed_vehicles: Option<u32>,
    traffic_drivers: TrafficDrivers,
    logged: Option<LoggedTraffic>,
    policy: Option<PolicySource>,
}

impl PlannedDrive {
    /// Loads the road of a scenario and sets what follows from it.
    ///
    /// # Errors
    /// The road cannot be loaded, or it does not allow a setting.
    pub fn new(scenario: &Scenario) -> Result<Self, PlanError> {
        Self::on(scenario, Arc::new(scenario.load_map()?))
    }

    /// Returns the drive of a scenario on its road, which is loaded already. The road's own demand is added if neither path nor demand is
    /// set. The path of an open road is set, as it is driven as a network; a path with other places than edges becomes one of edges.
    ///
    /// # Errors
    /// The road does not allow a setting.
    pub fn on(written: &Scenario, map: Arc<RoadMap>) -> Result<Self, PlanError> {
        let has_others = !written.demand.is_empty()
            || map.demand_file().is_some()
            || written.traffic.log_file().is_some()
            || !written.road_users.is_empty();
        if !written.participant && !has_others {
            let message = "participant is false; allowed without a demand: true, because no other vehicle enters\n  \
                remedy: a [demand], a map with one, such as merge, traffic FILE.csv, a [[road_user]], or participant = true";
            return Err(PlanError::Setting { key: "participant", part: String::new(), message: message.into() });
        }
        Self::of_learner(written, map)
    }

    /// Does the same as [`PlannedDrive::on`] for a drive that a learner advises, where a closed route needs no participant: the first vehicle
    /// is one of the traffic, too.
    ///
    /// # Errors
    /// As [`PlannedDrive::on`], and for advised vehicles with full bodies on a closed route without a participant.
    pub fn of_learner(written: &Scenario, map: Arc<RoadMap>) -> Result<Self, PlanError> {
        let mut scenario = written.clone();
        let fault = |(key, message)| PlanError::Setting { key, part: String::new(), message };
        let traffic_drivers = TrafficDrivers::named(&scenario.traffic_drivers, scenario.idm);
        let traffic_drivers = traffic_drivers.map_err(|error| fault(("traffic_drivers", error.0)))?;
        let logged = LoggedTraffic::of(written, &map, &traffic_drivers)?;
        if let Some(logged) = &logged {
            scenario.vehicles = logged.starts.len() as u32;
            if scenario.duration_s <= 0.0 {
                let steps = ((logged.lasts_s - scenario.warm_up_s) / scenario.step_s).round();
                scenario.duration_s = steps * scenario.step_s;
            }
        } else {
            scenario.add_own_traffic(&map);
        }
        let fixed_vehicles = (!scenario.has_path_or_demand()).then_some(scenario.vehicles);
        match &logged {
            Some(logged) => written.check_advised(Some(logged.simulated())).map_err(fault)?,
            None => written.check_on(fixed_vehicles).map_err(fault)?,
        }
        if !scenario.participant && scenario.demand.is_empty() {
            let is_fixed = fixed_vehicles.is_some();
            if (!is_fixed && scenario.road_users.is_empty()) || (is_fixed && scenario.advised_body == AdvisedBody::Full)
            {
                let (key, why) = if is_fixed { ("advised_body", "light") } else { ("demand", "one with vehicles") };
                let message = format!("participant is false; allowed on this road: with {key} = {why}, or true");
                return Err(fault((key, message)));
            }
        }
        let (start_m, length_m) = (scenario.path_start_m, map.route.length_m());
        if fixed_vehicles.is_none() && scenario.participant && scenario.path_start_m() >= length_m {
            return Err(MapError::PathStart { file: map.net_file.clone(), start_m, length_m }.into());
        }
        let road = DrivenRoad {
            map: &map,
            fixed_vehicles,
            road_users: &scenario.road_users,
            demand: &scenario.demand,
            duration_s: scenario.duration_s,
            has_automation: scenario.participant && scenario.automation.system != AutomationSystem::None,
        };
        let within = |key| move |(part, message)| PlanError::Setting { key, part, message };
        RoadUser::check_on(&scenario.road_users, &road).map_err(within("road_user"))?;
        ScriptedEvent::check_on(&scenario.events, &road).map_err(within("event"))?;
        let roadside = LazyRoadside::new(&map, scenario.seed, scenario.display.trees as usize);
        Ok(Self { scenario, map, roadside, fixed_vehicles, traffic_drivers, logged, policy: None })
    }

    /// Returns the drive with this policy in place of the one that the scenario names; `None` keeps the scenario's.
    #[must_use]
    pub fn advised_by(self, policy: Option<PolicySource>) -> Self {
        Self { policy, ..self }
    }

    /// Returns the policy in place of the one that the scenario names, if there is one.
    pub fn own_policy(&self) -> Option<&PolicySource> {
        self.policy.as_ref()
    }

    /// Returns the scenario with the settings that follow from its road.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Returns the road, with the route along the scenario's path.
    pub fn map(&self) -> &Arc<RoadMap> {
        &self.map
    }

    /// Returns what stands beside the roads; it is found at the first call that needs it.
    pub fn roadside(&self) -> &LazyRoadside {
        &self.roadside
    }

    /// Returns the number of vehicles of a closed route, the ego included; `None` on a network, where vehicles enter and leave.
    pub fn fixed_vehicles(&self) -> Option<u32> {
        self.fixed_vehicles
    }

    /// Returns the drivers of the other vehicles.
    pub fn traffic_drivers(&self) -> &TrafficDrivers {
        &self.traffic_drivers
    }

    /// Returns the vehicles of a file that drive as it says; `None` without such a file.
    pub fn logged(&self) -> Option<&LoggedTraffic> {
        self.logged.as_ref()
    }

    /// Returns the mean speed, during the drive, of the vehicle of a file ahead of the ego, m/s; 0 without a file.
    pub fn logged_mean_speed_mps(&self) -> f64 {
        let from_s = self.scenario.warm_up_s;
        self.logged.as_ref().map_or(0.0, |logged| logged.mean_speed_mps(from_s, from_s + self.scenario.duration_s))
    }

    /// Returns the vehicles as text: `22 cars`, or `vehicles that come and go`.
    pub fn vehicles_text(&self) -> String {
        self.fixed_vehicles.map_or("vehicles that enter and leave".into(), |vehicles| format!("{vehicles} vehicles"))
    }

    /// Returns the advised vehicles: a number of a fixed number of vehicles, or a share of those that enter. Vehicles of a file are not
    /// among those that can be advised.
    pub fn advised(&self) -> AdvisedVehicles {
        self.scenario.advised.among(self.advisable())
    }

    /// Returns the number of vehicles that can be advised, the ego included; `None` where vehicles enter and leave.
    pub fn advisable(&self) -> Option<u32> {
        self.logged.as_ref().map(LoggedTraffic::simulated).or(self.fixed_vehicles)
    }

    /// Returns the numbers of the advised vehicles other than the participant's, ascending, where the number of vehicles is fixed. Without
    /// a participant, the first simulated vehicle is one of them.
    pub fn advised_others(&self) -> Vec<u32> {
        let (advised, of) = (self.advised(), self.advisable().unwrap_or(0));
        let first = (!self.scenario.participant && !advised.is_no_vehicle()).then_some(0);
        let places = first.into_iter().chain(advised.others(of));
        places.map(|k| self.logged.as_ref().map_or(k, |logged| logged.id_of(k))).collect()
    }

    /// Returns true if vehicles enter and leave; their number is fixed otherwise.
    pub fn is_open(&self) -> bool {
        self.fixed_vehicles.is_none()
    }

    /// Returns a sentence for each setting that differs from its default and has no effect on this road.
    pub fn settings_without_effect(&self) -> Vec<String> {
        let (settings, road): (&[_], _) = match (self.fixed_vehicles, &self.logged) {
            (None, _) => (&ONLY_WITH_FIXED_NUMBER, "vehicles enter and leave"),
            (Some(_), Some(_)) => (&NOT_BEHIND_A_LOG, "vehicles follow those of a file"),
            (Some(_), None) => (&ONLY_ON_A_PATH, "the number of vehicles is fixed"),
        };
        let [written, default] =
            [&self.scenario, &Scenario::default()].map(|s| serde_json::to_value(s).unwrap_or_default());
        let is_changed = |key: &str| written[key] != default[key];
        let sentence = |(key, why): &(&str, &str)| {
            let value = written[*key].to_string();
            format!(
                "{key} is {}: it has no effect on map {}, where {road}: {why}",
                value.trim_matches('"'),
                self.scenario.map
            )
        };
        let mut sentences: Vec<String> = settings.iter().filter(|(key, _)| is_changed(key)).map(sentence).collect();
        let drivers = &self.scenario.traffic_drivers;
        if !self.traffic_drivers.are_alike() && is_changed("idm") {
            sentences
                .push(format!("idm has no effect with traffic_drivers {drivers}: the population has its own model"));
        }
        for key in ["secondary_task", "automation"] {
            if !self.scenario.participant && is_changed(key) {
                sentences.push(format!("{key} has no effect with participant false: it is the participant's"));
            }
        }
        sentences
    }

    /// Extends the drive by `seconds`, with traffic of a file not beyond its end; no effect on a drive without an end.
    pub fn extend(&mut self, seconds: f64) {
        if self.scenario.duration_s > 0.0 {
            let most_s = self.logged.as_ref().map_or(f64::INFINITY, |own| own.lasts_s - self.scenario.warm_up_s);
            self.scenario.duration_s = (self.scenario.duration_s + seconds).min(most_s.max(self.scenario.duration_s));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::EngineChoice;

    fn planned(map: &str) -> PlannedDrive {
        PlannedDrive::new(&Scenario { map: map.into(), ..Scenario::default() }).expect("a shipped map")
    }

    #[test]
    fn the_number_of_vehicles_is_fixed_on_closed_routes_alone() {
        assert_eq!([planned("ring-250").fixed_vehicles(), planned("practice").fixed_vehicles()], [Some(22); 2]);
        let merge = planned("merge");
        assert!(merge.is_open() && merge.scenario().demand.files.len() == 1 && !merge.scenario().path.is_empty());
    }

    #[test]
    fn a_planned_scenario_is_planned_to_itself() {
        let merge = planned("merge");
        let again = PlannedDrive::new(merge.scenario()).expect("its own scenario");
        assert_eq!(again.scenario(), merge.scenario());
    }

    #[test]
    fn a_setting_without_effect_on_the_road_is_named() {
        let said = |map: &str| {
            let scenario = Scenario { map: map.into(), vehicles: 5, path_start_m: 20.0, ..Scenario::default() };
            PlannedDrive::new(&scenario).expect("a shipped map").settings_without_effect()
        };
        let why = "it has no effect on map merge, where vehicles enter and leave: the demand says which vehicles come";
        assert_eq!(said("merge"), [format!("vehicles is 5: {why}")]);
        let on_ring = said("ring-250");
        assert!(on_ring.len() == 1 && on_ring[0].starts_with("path_start_m is 20.0: it has no effect on map ring-250"));
        assert!(planned("merge").settings_without_effect().is_empty());
    }

    #[test]
    fn a_refusal_names_what_made_the_drive_open() {
        let native = |map: &str, path: &str| {
            let (map, path) = (map.into(), path.into());
            let scenario = Scenario { map, path, traffic: EngineChoice::Native, ..Scenario::default() };
            PlannedDrive::new(&scenario).unwrap_err().to_string()
        };
        let of_map = native("merge", "");
        assert!(
            of_map.starts_with("traffic is native; allowed on map merge, where vehicles enter and leave: sumo"),
            "{of_map}"
        );
        let merge = planned("merge");
        let of_path = native("merge", &merge.scenario().path);
        assert!(of_path.starts_with("traffic is native; allowed with a path or a demand: sumo"), "{of_path}");
    }
}
