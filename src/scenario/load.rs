//! Scenario files and flags. In: TOML text and `(field, value)` pairs from the command line. Out: a checked [`Scenario`], or an error with
//! file, line, column, value and the allowed values.

use super::{AdvisedVehicles, RoadUser, Scenario, ScriptedEvent, colour, sumo_config};
use crate::{
    map,
    policy::{self, Hold},
    settings::{self, Field, SettingFault, Settings, SettingsError},
    time::is_whole_ticks,
    toml_text::{self, did_you_mean},
    traffic::{EngineChoice, FollowingModel, RING_STUDY, is_population_path},
};
use serde_json::Value;
use std::path::Path;

impl Scenario {
    /// Returns all settings in the order of the struct.
    pub fn fields() -> Vec<Field> {
        settings::fields_of::<Self>()
    }

    /// Reads a scenario file, or SUMO's configuration of a scenario (`.sumocfg`); missing settings keep their default. Paths in the file
    /// are relative to its folder.
    ///
    /// # Errors
    /// As [`settings::from_file`].
    pub fn from_file(path: &Path) -> Result<Self, SettingsError> {
        if sumo_config::is_sumo_config(path) {
            return sumo_config::read(path);
        }
        let scenario: Self = settings::from_file(path)?;
        Ok(scenario.paths_from(path.parent().unwrap_or(Path::new(""))))
    }

    /// Returns this scenario with the paths of its map, policy, population and demand resolved from `folder`. Names of what is shipped, and
    /// absolute paths, are unchanged.
    #[must_use]
    pub fn paths_from(mut self, folder: &Path) -> Self {
        self.map = path_from(folder, "map", &self.map);
        self.policy = path_from(folder, "policy", &self.policy);
        self.traffic_drivers = path_from(folder, "traffic_drivers", &self.traffic_drivers);
        if let EngineChoice::Log(file) = &mut self.traffic {
            *file = path_from(folder, "traffic", file);
        }
        for file in self.demand.input_files_mut() {
            *file = folder.join(&file);
        }
        self
    }

    /// Parses a scenario from TOML text; messages refer to it as `name`.
    ///
    /// # Examples
    ///
    /// ```
    /// # extern crate codrive_core as codrive;
    /// use codrive::scenario::Scenario;
    ///
    /// let scenario = Scenario::from_toml("format = 1\nvehicles = 12\n", "short.toml")?;
    /// assert_eq!(scenario.vehicles, 12);
    /// // Other settings keep their default.
    /// assert_eq!(scenario.map, "ring-250");
    /// // A fault names the file, the line and what is allowed.
    /// let fault = Scenario::from_toml("format = 1\nvehicles = 1\n", "short.toml").unwrap_err();
    /// assert!(fault.to_string().starts_with("short.toml:2"), "{fault}");
    /// # Ok::<(), codrive::settings::SettingsError>(())
    /// ```
    pub fn from_toml(text: &str, name: &str) -> Result<Self, SettingsError> {
        settings::from_toml(text, name)
    }

    /// Returns this scenario with some settings replaced, checked as a whole.
    ///
    /// # Errors
    /// As [`settings::changed`].
    ///
    /// # Examples
    ///
    /// ```
    /// # extern crate codrive_core as codrive;
    /// use codrive::scenario::Scenario;
    ///
    /// let field = |path: &str| Scenario::fields().into_iter().find(|field| field.path == path).expect("a setting");
    /// let scenario = Scenario::default();
    /// let longer = scenario.with(&[(field("vehicles"), 30.into()), (field("duration_s"), 90.0.into())])?;
    /// assert_eq!((longer.vehicles, longer.duration_s), (30, 90.0));
    /// assert_eq!(scenario.vehicles, 22);
    /// assert!(scenario.with(&[(field("vehicles"), 1.into())]).is_err());
    /// # Ok::<(), codrive::settings::SettingsError>(())
    /// ```
    pub fn with(&self, changes: &[(Field, Value)]) -> Result<Self, SettingsError> {
        settings::changed(self, changes)
    }

    /// Returns this scenario as text that [`Scenario::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        format!("format = {}\n", toml_text::FORMAT) + &toml::to_string(self).expect("settings are TOML values")
    }
}

/// Returns the value of a setting (`map`, `policy`, `traffic` or `traffic_drivers`) in a text from `folder`. A path is resolved from that folder; a name, and the value
/// of any other setting, is unchanged.
pub fn path_from(folder: &Path, setting: &str, value: &str) -> String {
    let is_path = match setting {
        "map" => map::is_path(value),
        "policy" => policy::is_path(value),
        "traffic" => EngineChoice::is_log(value),
        "traffic_drivers" => is_population_path(value),
        _ => false,
    };
    if is_path { folder.join(value).to_string_lossy().into_owned() } else { value.to_owned() }
}

impl Settings for Scenario {
    fn faults(&self) -> Vec<SettingFault> {
        let users = RoadUser::faults(&self.road_users);
        let events = ScriptedEvent::faults(&self.events, &self.road_users);
        self.relation_faults().into_iter().chain(users).chain(events).collect()
    }
}

/// Settings because of which a number of advised vehicles, an engine or sham advice is not possible.
const TRAFFIC_KEYS: [&str; 6] = ["map", "path", "demand", "traffic", "vehicles", "sham_advice"];

impl Scenario {
    /// Returns the faults of relations between settings.
    fn relation_faults(&self) -> Vec<SettingFault> {
        let mut faults = Vec::new();
        let mut add = |key: &str, others, message: String| faults.push(SettingFault::new(key, others, message));
        for (key, value) in [("step_s", self.step_s), ("extra_delay_s", self.extra_delay_s)] {
            if !is_whole_ticks(value) {
                add(key, &[], format!("{key} is {value}; allowed: a multiple of 0.01 s"));
            }
        }
        let model = self.other_model.name();
        if self.other_model != FollowingModel::Idm && self.traffic != EngineChoice::Sumo {
            let engine = &self.traffic;
            let text = format!(
                "other_model is {model}; allowed: idm with traffic {engine}; only traffic sumo has other models"
            );
            add("other_model", &["traffic"], text);
        } else if self.other_model != FollowingModel::Idm && self.traffic_drivers != RING_STUDY {
            let text = format!(
                "other_model is {model}; allowed with traffic_drivers {}: idm; a share of other models is for ring-study",
                self.traffic_drivers
            );
            add("other_model", &["traffic_drivers"], text);
        }
        if let Err(fault) = self.demand.check_numbers() {
            add("demand", &[], fault.to_string());
        }
        let on_road = self.check_logged().and_then(|()| match self.traffic {
            EngineChoice::Log(_) => self.check_advised(Some(self.vehicles)),
            _ => self.check_on((!self.has_path_or_demand()).then_some(self.vehicles)),
        });
        if let Err((key, message)) = on_road {
            add(key, &TRAFFIC_KEYS, message);
        }
        if let Err(fault) = Hold::new(self.hold_s, self.step_s) {
            add("hold_s", &["step_s"], format!("{fault}, at least one"));
        }
        for (key, value) in [("ego_colour", &self.display.ego_colour), ("traffic_colour", &self.display.traffic_colour)]
        {
            if let Err(allowed) = colour::srgb(value) {
                let near = did_you_mean(value, &colour::names());
                add(key, &[], format!("{key} is \"{value}\"{near}; allowed: {allowed}"));
            }
        }
        if self.display.mirror_radius_m > 0.0 && self.display.mirror_radius_m < 0.8 {
            let text = format!("mirror_radius_m is {}; allowed: 0 (flat) or 0.8 to 20 m", self.display.mirror_radius_m);
            add("mirror_radius_m", &[], text);
        }
        faults
    }

    /// Checks that the settings are possible with this number of vehicles; `None` if they enter and leave.
    ///
    /// # Errors
    /// The first fault: its key, and a message with value and remedy.
    pub(super) fn check_on(&self, fixed_vehicles: Option<u32>) -> Result<(), (&'static str, String)> {
        if fixed_vehicles.is_none() {
            self.check_on_network(matches!(self.advised, AdvisedVehicles::Count(count) if count > 1))?;
        }
        self.check_advised(fixed_vehicles)
    }

    /// Checks that as many vehicles as are to be advised can be, out of a fixed number or of those that enter.
    ///
    /// # Errors
    /// The key, and a message with value and remedy.
    pub(super) fn check_advised(&self, of: Option<u32>) -> Result<(), (&'static str, String)> {
        let advised = |text: &str| Err(("advised", format!("advised is {}; {text}", self.advised)));
        match (self.advised, of) {
            (AdvisedVehicles::Count(count), Some(most)) if count > most => {
                advised(&format!("allowed: 0 to {most}, as many as there are vehicles that can be advised"))?;
            }
            _ => {}
        }
        if self.sham_advice && self.advised != AdvisedVehicles::default() && !self.advised.is_no_vehicle() {
            let why = "sham advice comes from another drive of the participant's vehicle";
            return advised(&format!("allowed with sham_advice: 1; {why}"));
        }
        Ok(())
    }

    /// Checks the settings that are not for roads where vehicles enter and leave; `is_counted` if several vehicles are advised.
    fn check_on_network(&self, is_counted: bool) -> Result<(), (&'static str, String)> {
        let (opener, closer) = match self.has_path_or_demand() {
            true => ("with a path or a demand".to_owned(), "neither path nor [demand]"),
            false => {
                (format!("on map {}, where vehicles enter and leave", self.map), "a closed route such as ring-250")
            }
        };
        let sumo = format!("sumo; only SUMO moves vehicles on a network\n  remedy: traffic sumo, or {closer}");
        let settings = [
            ("traffic", self.traffic != EngineChoice::Sumo, self.traffic.to_string(), sumo.as_str()),
            (
                "sham_advice",
                self.sham_advice,
                "true".into(),
                "false; sham advice comes from another drive on a closed route",
            ),
            ("advised", is_counted, self.advised.to_string(), "a share, such as 20%, or 1, or 0"),
        ];
        match settings.into_iter().find(|(_, is_fault, ..)| *is_fault) {
            Some((key, _, value, allowed)) => Err((key, format!("{key} is {value}; allowed {opener}: {allowed}"))),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::DisplaySettings;

    fn fault(text: &str) -> String {
        Scenario::from_toml(text, "trial.toml").unwrap_err().message
    }

    #[test]
    fn a_scenario_reads_back_from_its_own_text() {
        let scenario = Scenario { vehicles: 18, hold_s: 5.0, ..Scenario::default() };
        assert_eq!(Scenario::from_toml(&scenario.to_toml(), "x").unwrap(), scenario);
        assert_eq!(Scenario::from_toml("", "x").unwrap(), Scenario::default());
    }

    #[test]
    fn paths_in_a_scenario_start_at_its_folder_and_names_are_unchanged() {
        let home = tempfile::tempdir().unwrap();
        let file = home.path().join("trial.toml");
        let read = |map: &str, policy: &str| {
            let text = format!("map = '{map}'\npolicy = '{policy}'\n[demand]\nfiles = ['trips.rou.xml']\n");
            std::fs::write(&file, text).unwrap();
            let read = Scenario::from_file(&file).unwrap();
            assert_eq!(read.demand.files, [home.path().join("trips.rou.xml")]);
            [read.map, read.policy]
        };
        let within = |name: &str| home.path().join(name).to_str().unwrap().to_owned();
        assert_eq!(read("ring-250", "ring-250-speed"), ["ring-250", "ring-250-speed"]);
        assert_eq!(read("town.net.xml", "calm.toml"), [within("town.net.xml"), within("calm.toml")]);
        assert_eq!(read("towns/one", "../calm.onnx"), [within("towns/one"), within("../calm.onnx")]);
        assert_eq!(read("/roads/net.xml", "/calm.toml"), ["/roads/net.xml", "/calm.toml"]);
        let message = read("town.net.xml", "pi")[0].clone();
        let message = crate::map::RoadMap::load(&message).unwrap_err().to_string();
        assert!(message.contains(&within("town.net.xml")), "{message}");
    }

    #[test]
    fn an_unknown_key_is_named_with_line_and_column() {
        let text = fault("vehicles = 22\n  vehicels = 3\n");
        assert!(text.starts_with("trial.toml:2:3: unknown key `vehicels`"), "{text}");
        assert!(text.ends_with("  |\n2 |   vehicels = 3\n  |   ^^^^^^^^"), "{text}");
        assert!(fault("[idm]\nT = 1\ntau = 2\n").starts_with("trial.toml:3:1: unknown key `tau`; allowed: `v0`, `T`"));
        assert!(
            fault("hold_sec = 1\n").starts_with("trial.toml:1:1: unknown key `hold_sec`; did you mean `hold_s`?\n")
        );
    }

    #[test]
    fn a_wrong_type_is_named_with_line_and_column() {
        assert!(fault("seed = 1\nvehicles = \"many\"").starts_with("trial.toml:2:12: invalid type: string \"many\""));
        assert!(fault("units = \"knots\"").starts_with("trial.toml:1:9: unknown value `knots`; allowed: `mph`, `kmh`"));
    }

    #[test]
    fn a_model_that_the_engine_does_not_have_is_refused() {
        let text = fault("traffic = \"native\"\nother_model = \"krauss\"\n");
        assert!(text.contains("trial.toml:2:") && text.contains("allowed: idm with traffic native"), "{text}");
        let of = |text: &str| Scenario::from_toml(text, "x").unwrap().other_model;
        assert_eq!(of("other_model = \"eidm\"\nother_model_share = 0.5"), FollowingModel::Eidm);
    }

    #[test]
    fn impossible_numbers_of_advised_vehicles_are_refused_with_position() {
        assert!(
            fault("vehicles = 10\nadvised = 11")
                .starts_with("trial.toml:2:11: advised is 11; allowed: 0 to 10, as many")
        );
        assert!(
            fault("sham_advice = true\nadvised = \"20%\"").starts_with("trial.toml:2:11: advised is 0.2; allowed with")
        );
        assert!(fault("path = \"a b\"\nadvised = 2").contains("2:11: advised is 2; allowed with a path"));
        let on_network = "path = \"a b\"\nadvised = \"20%\"";
        for allowed in ["advised = 22", "advised = 0", "sham_advice = true\nadvised = 1", on_network] {
            assert!(Scenario::from_toml(allowed, "x").is_ok(), "{allowed}");
        }
    }

    #[test]
    fn a_value_out_of_range_is_named_with_its_limits() {
        assert!(
            fault("hold_s = 0").starts_with("trial.toml:1:10: hold_s is 0.0; allowed: a number from 0.01 to 600 s")
        );
        assert!(
            fault("\n[idm]\na = -1").starts_with("trial.toml:3:5: idm.a is -1.0; allowed: a number from 0.1 to 5 m/s2")
        );
        assert!(fault("range_mph = nan").starts_with("trial.toml:1:13: range_mph is not a finite number"));
        assert!(
            fault("hold_s = 0.25").starts_with("trial.toml:1:10: hold_s is 0.25; allowed: a whole number of steps")
        );
        assert!(
            fault("seed = 2\nego_colour = \"rde\"")
                .starts_with("trial.toml:2:14: ego_colour is \"rde\" (did you mean red?); allowed: #rrggbb")
        );
        assert!(
            fault("extra_delay_s = 0.015")
                .starts_with("trial.toml:1:17: extra_delay_s is 0.015; allowed: a multiple of 0.01 s")
        );
        assert!(
            fault("[sound]\nengine_db = 20")
                .starts_with("trial.toml:2:13: sound.engine_db is 20.0; allowed: a number from -60 to 12 dB")
        );
        assert!(
            fault("mirror_radius_m = 0.3").starts_with("trial.toml:1:19: mirror_radius_m is 0.3; allowed: 0 (flat)")
        );
        assert!(fault("mirror_radius_m = 0.79").contains("0 (flat) or 0.8 to 20 m"));
        for allowed in ["0", "0.8", "20"] {
            assert!(Scenario::from_toml(&format!("mirror_radius_m = {allowed}"), "x").is_ok(), "{allowed}");
        }
        // The shortest hold is one step.
        assert!(Scenario::from_toml("step_s = 0.1\nhold_s = 0.1", "x").is_ok());
        assert!(
            fault("step_s = 0.2\nhold_s = 0.1").contains("allowed: a whole number of steps of 0.2 s, at least one")
        );
        assert!(fault("step_s = 0.025").contains("step_s is 0.025; allowed: a multiple of 0.01 s"));
        assert!(fault("duration_s = 604801").contains("allowed: a number from 0 to 604800 s"));
        assert!(Scenario::from_toml("duration_s = 604800", "x").is_ok(), "seven days");

        assert!(fault("cockpit = \"none\"").contains("`off`, `bonnet`, `full`"));
        assert!(
            fault("vehicles = 1").starts_with("trial.toml:1:12: vehicles is 1; allowed: a whole number from 2 to 1000")
        );
    }

    #[test]
    fn an_unknown_traffic_engine_is_named_with_line_and_column() {
        let text = fault("seed = 1\ntraffic = \"sumoo\"");
        let allowed = "allowed: sumo, native, or a file of trajectories (.csv, .csv.gz)";
        assert!(
            text.starts_with(&format!("trial.toml:2:11: traffic is \"sumoo\" (did you mean sumo?); {allowed}")),
            "{text}"
        );
        let traffic = Scenario::fields().into_iter().find(|field| field.path == "traffic").expect("a setting");
        let error = Scenario::default().with(&[(traffic, "natvie".into())]).unwrap_err();
        assert_eq!(error.message, format!("traffic is \"natvie\" (did you mean native?); {allowed}"));
    }

    #[test]
    fn all_mistakes_of_a_scenario_are_in_one_report() {
        let text = "map = \"ring-250\"\nvehicels = 10\nhold_s = 2000\nunits = \"knots\"\nextra_delay_s = 0.015\nvehicles = \"30\"\n\
                    advised = 40\n[idm]\nT = 1.2\n[[event]]\nname = \"a\"\ntrigger = { time_s = -1 }\nactions = []\n";
        let report = fault(text);
        let places = report.lines().filter(|line| line.starts_with("trial.toml:"));
        let places: Vec<&str> = places.map(|line| line.split("; ").next().unwrap_or_default()).collect();
        let wanted = [
            "trial.toml:2:1: unknown key `vehicels`",
            "trial.toml:3:10: hold_s is 2000.0",
            "trial.toml:4:9: unknown value `knots`",
            "trial.toml:5:17: extra_delay_s is 0.015",
            "trial.toml:6:12: invalid type: string \"30\"",
            // The number of advised vehicles is not judged beside a wrong number of vehicles.
            "trial.toml:12:11: event \"a\": time_s is -1",
        ];
        assert_eq!(places, wanted, "{report}");
    }

    #[test]
    fn groups_of_settings_do_not_appear_in_the_file() {
        let display = DisplaySettings { trees: 7, ..DisplaySettings::default() };
        let text = Scenario { display, ..Scenario::default() }.to_toml();
        assert!(text.contains("\ntrees = 7\n") && !text.contains("[display]"), "{text}");
        assert_eq!(Scenario::from_toml(&text, "x").expect("its own file").display.trees, 7);
        assert!(fault("[display]\ntrees = 7").starts_with("trial.toml:1:2: unknown key `display`"));
        // The settings of a group keep their position among the others.
        let paths: Vec<String> = Scenario::fields().into_iter().map(|f| f.path).collect();
        let place = |path: &str| paths.iter().position(|p| p == path).expect("a setting");
        assert!(place("range_mph") + 1 == place("units") && place("quality") + 1 == place("sound.master_db"));
    }

    #[test]
    fn a_syntax_error_is_shown_with_line_and_column() {
        assert!(fault("map = \n").starts_with("trial.toml:1:7: "), "{}", fault("map = \n"));
    }

    #[test]
    fn by_default_bends_limit_speeds_except_on_rings() {
        let bound = |map: &str, lateral_accel_mps2| {
            let route = crate::map::RoadMap::load(map).unwrap().route;
            Scenario { lateral_accel_mps2, ..Scenario::default() }.lateral_accel_bound_mps2(&route)
        };
        for ring in ["ring-250", "ring-641"] {
            assert_eq!([bound(ring, 0.0), bound(ring, 2.5), bound(ring, 100.0)], [None, Some(2.5), None], "{ring}");
        }
        assert_eq!([0.0, 99.0, 100.0].map(|set| bound("practice", set)), [Some(3.0), Some(99.0), None]);
    }

    #[test]
    fn flags_replace_values_of_the_file() {
        let list = Scenario::fields();
        let field = |path: &str| list.iter().find(|f| f.path == path).unwrap().clone();
        let changed =
            Scenario::default().with(&[(field("idm.T"), 1.5.into()), (field("vehicles"), 20.into())]).unwrap();
        assert_eq!((changed.idm.t, changed.vehicles), (1.5, 20));
        let error = Scenario::default().with(&[(field("vehicles"), 5000.into())]).unwrap_err();
        assert_eq!(error.message, "vehicles is 5000; allowed: a whole number from 2 to 1000");
    }
}
