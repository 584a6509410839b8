//! All settings of one drive. This struct **is** the command line, the scenario file and the panel: the doc comments below are the help and
//! the tooltips, the ranges are the limits ([`crate::settings`] reads them). Keys have their unit; the flag on the command line is the key
//! without it (`hold_s` is `--hold SECS`).

mod advised;
mod automation;
pub mod colour;
mod display;
mod event_chart;
mod files;
mod load;
mod logged_traffic;
pub mod openscenario;
mod planned_drive;
mod road_user;
pub mod scripted_event;
mod secondary_task;
pub mod sound;
mod sumo_config;

pub use advised::{AdvisedVehicles, UnknownShare};
pub use automation::{Automation, AutomationSystem};
pub use display::{CockpitView, DialPalette, GuidanceView, QualityLevel};
pub use event_chart::event_chart;
pub use files::NamedFiles;
pub use load::path_from;
pub use logged_traffic::LoggedTraffic;
pub use planned_drive::{PlanError, PlannedDrive};
pub use road_user::RoadUser;
pub use scripted_event::ScriptedEvent;
pub use secondary_task::{SearchPlace, SecondaryTask, SecondaryTaskKind, TaskSignal};
pub use sound::SoundLevels;

use crate::{
    idm::IdmParams,
    map::{MapError, RoadMap, Route},
    policy::{self, Hold},
    settings::flat_settings,
    traffic::{self, Demand, EngineChoice, FollowingModel},
    units::SpeedUnit,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

flat_settings! {
    /// All settings of one drive.
    pub struct Scenario, written as scenario_file {
        fields {
            /// Road: the name of a map, or the path of a SUMO net.xml; a path in a file is relative to that file's folder
            map: String = "ring-250".into(),
            /// Vehicles on the route, the ego and those of a file included
            #[schemars(range(min = 2, max = 1000))]
            vehicles: u32 = 22,
            /// Other vehicles: by sumo, by the native engine, or on an open lane as in a FILE.csv of trajectories, with simulated vehicles
            /// behind them
            traffic: EngineChoice = EngineChoice::Sumo,
            /// Vehicle of the file of `traffic` behind which the ego drives, by its name; empty: the last one, with simulated vehicles
            /// behind the ego
            traffic_leader: String = String::new(),
            /// Path of the ego on the road's network: edges, lanes or points X,Y (m) in order, separated by spaces; `...` between two
            /// stands for the quickest way. The drive ends at the end of the last edge; empty: the road's own route
            path: String = String::new(),
            /// Start of the ego's front along its path, or on a network along the closed route; values below 5 m count as 5 m
            #[schemars(range(min = 0.0, max = 100_000.0), extend("unit" = "m"))]
            path_start_m: f64 = 0.0,
            /// Speed of the ego at its start along its path; 0: standing, or after a warm-up that of the traffic
            #[schemars(range(min = 0.0, max = 70.0), extend("unit" = "m/s"))]
            start_speed_mps: f64 = 0.0,
            /// Include the participant's vehicle; `false` needs a demand or a file as traffic, and works in `codrive run` only
            participant: bool = true,
            /// Vehicles that enter the road's network: SUMO's demand files, or flows from edge to edge. With a demand the drive is on the
            /// network
            #[schemars(skip)]
            #[serde(skip_serializing_if = "Demand::is_empty")]
            demand: Demand = Demand::default(),
            /// Road users at their places at the start, which events move
            #[schemars(skip)]
            #[serde(rename = "road_user", skip_serializing_if = "Vec::is_empty")]
            road_users: Vec<RoadUser> = Vec::new(),
            /// Events: triggers, and what then happens on the road
            #[schemars(skip)]
            #[serde(rename = "event", skip_serializing_if = "Vec::is_empty")]
            events: Vec<ScriptedEvent> = Vec::new(),
            /// Drivers of the other vehicles: ring-study (all alike, with the model `idm`), people as they were measured (safe-followers,
            /// gap-closers), or a population's FILE.toml
            traffic_drivers: String = traffic::RING_STUDY.into(),
            /// Car-following model of the other vehicles with ring-study drivers: v0=30,T=1,a=1,b=1.5,delta=4,s0=2,noise=0.2
            idm: IdmParams = IdmParams::default(),
            /// Car-following model of a share of the other vehicles. Models other than idm are SUMO's, with SUMO's parameters and noise,
            /// and need traffic sumo
            other_model: FollowingModel = FollowingModel::Idm,
            /// Share of the other vehicles that use `other_model`
            #[schemars(range(min = 0.0, max = 1.0))]
            other_model_share: f64 = 1.0,
            /// Largest lateral acceleration of the other vehicles in bends; 0: automatic (3 m/s2, unlimited on rings); 100: unlimited
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/s2"))]
            lateral_accel_mps2: f64 = 0.0,
            /// Rain, and a wet road from the start: less grip for the ego and the advised vehicles, shorter sight, headlamps on
            #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm/h"))]
            // docs/references.md: rain: 50 mm/h is a violent shower.
            rain_mmph: f64 = 0.0,
            /// Initial placement of the vehicles
            start: StartLayout = StartLayout::Even,
            /// Time for which traffic runs before the drive; the ego is driven by the same model
            #[schemars(range(min = 0.0, max = 3600.0), extend("unit" = "s"))]
            warm_up_s: f64 = 0.0,
            /// Standard deviation of all vehicles' speeds that must last for 10 s before the hand-over; 0: no wait
            #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "m/s"))]
            wave_sd_mps: f64 = 0.0,
            /// Hand over only when the ego has stopped; the drive then begins with a foot on the brake
            standing_start: bool = false,
            /// Longest wait for the hand-over after the warm-up; the drive then begins anyway, and the recording notes it
            #[schemars(range(min = 0.0, max = 3600.0), extend("unit" = "s"))]
            wave_wait_s: f64 = 600.0,
            /// Length of a step of traffic and policy, a multiple of 0.01 s
            #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "s"))]
            step_s: f64 = 0.1,
            /// Length of the drive, at most 7 days; 0: until the window is closed
            #[schemars(range(min = 0.0, max = 604800.0), extend("unit" = "s"))]
            duration_s: f64 = 300.0,
            /// Seed of all random numbers
            #[schemars(range(min = 0, max = 9007199254740991_u64))]
            seed: u64 = 1,
            /// Advising policy: auto (the one shipped for the map, otherwise two-phase), none, constant, two-phase, follower-stopper, pi,
            /// linear-feedback, ring-250-speed or another of assets/policies, or a FILE.toml or FILE.onnx
            policy: String = policy::AUTO.into(),
            /// Advised vehicles, the participant's first: a share of all (5%, 0.05; on a network of the vehicles that enter) or a number
            /// (3); 0 is none. All have the same policy; the simulated driver drives the others
            advised: AdvisedVehicles = AdvisedVehicles::default(),
            /// Physics of the advised vehicles other than the participant's: light, with driver, pedals, engine and brakes, steered by the
            /// traffic engine; or full, as the participant's car
            advised_body: AdvisedBody = AdvisedBody::Light,
            /// Target speed of the built-in policies; 0 is 98.5 % of the equilibrium speed of the ring with even gaps, or of the mean speed
            /// of a file's vehicle ahead of the ego
            #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "m/s"))]
            policy_speed_mps: f64 = 0.0,
            /// Duration of one advice, a whole number of steps
            #[schemars(range(min = 0.01, max = 600.0), extend("unit" = "s"))]
            // HC22's hold is one step of 0.1 s; a person cannot follow ten new targets a second.
            hold_s: f64 = 1.0,
            /// Show the advice of another drive with these settings, another seed and a simulated driver. Frequency and size of the advice
            /// are equal, but it is unrelated to this traffic
            sham_advice: bool = false,
            /// Half width of the acceptable range around the target
            #[schemars(range(min = 0.1, max = 50.0), extend("unit" = "mph"))]
            // docs/references.md: band: a useful range on the 250 m ring is about ±1 mph.
            range_mph: f64 = 1.0,
        }
        /// The picture and the screen; these settings do not change how cars move.
        group display: DisplaySettings {
            /// Unit on the speedometer
            units: SpeedUnit = SpeedUnit::Mph,
            /// Width of the visible picture on the screen
            #[schemars(range(min = 0.1, max = 10.0), extend("unit" = "m"))]
            // A 55-inch TV at 1.0 m: 63 degrees (docs/references.md: display).
            screen_width_m: f64 = 1.218,
            /// Distance from the driver's eyes to the screen
            #[schemars(range(min = 0.2, max = 10.0), extend("unit" = "m"))]
            eye_distance_m: f64 = 1.0,
            /// Show the other vehicles in ordinary paints in the driver's view; otherwise, and always in the bird's-eye view, in
            /// `traffic_colour`
            ordinary_paints: bool = true,
            /// Solar time of day in late summer; the sun is highest at 12 and sets at 18:45, nights have a full moon
            #[schemars(range(min = 0.0, max = 24.0), extend("unit" = "h"))]
            time_h: f64 = 9.75,
            /// Range of sight; below 1 km there is fog
            #[schemars(range(min = 0.05, max = 100.0), extend("unit" = "km"))]
            visibility_km: f64 = 30.0,
            /// Wind speed, for the movement of trees
            #[schemars(range(min = 0.0, max = 15.0), extend("unit" = "m/s"))]
            wind_mps: f64 = 2.5,
            /// Largest number of trees around the road and on the horizon; those beside the road stop a car
            #[schemars(range(min = 0, max = 20_000))]
            trees: u32 = 5000,
            /// Paint of the own vehicle: a name or #rrggbb
            ego_colour: String = "red".into(),
            /// Paint of the other vehicles without ordinary paints: a name or #rrggbb
            traffic_colour: String = "green".into(),
            /// Visible parts of the own vehicle in the driver's view
            cockpit: CockpitView = CockpitView::default(),
            /// Colours of the speedometer
            palette: DialPalette = DialPalette::default(),
            /// Guidance along a path
            guidance: GuidanceView = GuidanceView::default(),
            /// Full scale of the speedometer in its unit, rounded up to 10, 15, 20, 25, 30, 40, 50, 60, 80, 100 and so on; 0: automatic for
            /// the drive, in a study for all trials
            #[schemars(range(min = 0.0, max = 240.0))]
            dial_full: f64 = 0.0,
            /// Mirror yaw; higher values show more of the left side behind the vehicle
            #[schemars(range(min = -30.0, max = 30.0), extend("unit" = "deg"))]
            mirror_yaw_deg: f64 = 0.0,
            /// Mirror pitch; higher values turn the view up
            #[schemars(range(min = -20.0, max = 20.0), extend("unit" = "deg"))]
            mirror_pitch_deg: f64 = -2.5,
            /// Horizontal field of view of a flat mirror
            #[schemars(range(min = 10.0, max = 60.0), extend("unit" = "deg"))]
            mirror_fov_deg: f64 = 30.0,
            /// Radius of a convex mirror, at least 0.8, for a wider view with smaller images; 0 is flat
            #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "m"))]
            mirror_radius_m: f64 = 0.0,
            /// Quality of the picture; sizes, positions and lamps are the same at all levels
            quality: QualityLevel = QualityLevel::Auto,
        }
        fields {
            /// Levels of all sounds
            sound: SoundLevels = SoundLevels::default(),
            /// Play a gentle tone when the advised speed changes
            advice_tone: bool = false,
            /// Speak the guidance along a path before each manoeuvre, in English, by the program espeak-ng
            spoken_guidance: bool = false,
            /// Show the speed relative to the advice on the wheel's rev lamps: one lamp below the range, three within, all above
            rev_lamps: bool = false,
            /// Black square in the upper left corner that turns white for one frame, for a photodiode or a phone's camera
            flash_patch: FlashPatch = FlashPatch::Off,
            /// Extra delay of the controls, a multiple of 0.01 s; recordings have the undelayed controls
            #[schemars(range(min = 0.0, max = 0.5), extend("unit" = "s"))]
            extra_delay_s: f64 = 0.0,
            /// Let the vehicle creep forward in gear when no pedal is pressed
            creep: bool = true,
            /// Help keyboard steering to stay in the lane
            lane_help: bool = true,
            /// Effect of a contact with another vehicle on the drive
            contact: OnContact = OnContact::Continue,
            /// Simulated driver of `codrive run` and of the other advised vehicles: follow, perfect, sloppy, idm (ignores advice), exact,
            /// guarded, or parameters such as reaction=1,error=0.5,speed_bias=0,deadband=0 (s, m/s)
            driver: String = "follow".into(),
            /// Secondary task of the participant, with its settings
            secondary_task: SecondaryTask = SecondaryTask::default(),
            /// Automation of the participant's vehicle, with its settings
            automation: Automation = Automation::default(),
        }
    }
}

/// Initial placement of the cars on the route.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum StartLayout {
    /// Evenly spaced, at a standstill
    #[default]
    Even,
    /// Close together with one long gap ahead of the ego's leader: a wave forms within about 75 s
    Bunched,
}

/// Physics of the advised vehicles other than the participant's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum AdvisedBody {
    /// Driver, pedals, engine and brakes; the traffic engine steers
    #[default]
    Light,
    /// All physics of the participant's car
    Full,
}

/// Effect of a contact with another vehicle or a fixed object on the drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OnContact {
    /// Record it and continue
    #[default]
    Continue,
    /// Record it and end the drive
    End,
}

/// Trigger of the white frame of the square in the picture's corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FlashPatch {
    /// No square in the picture
    #[default]
    Off,
    /// White at the first tick that uses a newly pressed pedal
    Pedal,
    /// White at the first tick with a new advice
    Advice,
}

impl Scenario {
    /// Returns the number of ticks in a step.
    pub fn step_ticks(&self) -> u64 {
        (self.step_s / crate::time::TICK_S).round() as u64
    }

    /// Returns the duration of one advice, a whole number of steps.
    pub fn hold(&self) -> Hold {
        Hold::nearest(self.hold_s, self.step_s)
    }

    /// Returns the extra delay of the controls, ticks.
    pub fn extra_delay_ticks(&self) -> usize {
        (self.extra_delay_s / crate::time::TICK_S).round() as usize
    }

    /// Returns the largest lateral acceleration of the other cars in the bends of a route, m/s²; `None` if unlimited.
    pub fn lateral_accel_bound_mps2(&self, route: &Route) -> Option<f64> {
        /// Automatic value, m/s²: comfortable for the simulated drivers, too.
        const COMFORTABLE_MPS2: f64 = 3.0;
        /// Value of the setting that stands for no limit, m/s².
        const NONE_MPS2: f64 = 100.0;
        match self.lateral_accel_mps2 {
            set if set <= 0.0 => (!route.is_ring()).then_some(COMFORTABLE_MPS2),
            set => (set < NONE_MPS2).then_some(set),
        }
    }

    /// Returns the start of the ego's front along its path, metres: a whole car has room behind it.
    pub fn path_start_m(&self) -> f64 {
        self.path_start_m.max(crate::space::CAR_LENGTH_M)
    }

    /// Returns true if a path or a demand is set. In the scenario of a [`PlannedDrive`] it is set where vehicles enter and leave.
    pub fn has_path_or_demand(&self) -> bool {
        !self.path.trim().is_empty() || !self.demand.is_empty()
    }

    /// Returns true if no vehicle can be advised: none is to be, or only the participant's in a drive without a participant.
    pub fn advises_no_vehicle(&self) -> bool {
        let no_other = self.advised.among(None).is_no_vehicle();
        self.advised.is_no_vehicle() || (!self.participant && no_other)
    }

    /// Adds the traffic and the path that the road itself has: its own demand if neither path nor demand is set, and the path of an open
    /// road, which is driven as a network. A path with other places than edges becomes one of edges.
    fn add_own_traffic(&mut self, map: &RoadMap) {
        if !self.has_path_or_demand() {
            self.demand.files.extend(map.demand_file());
        }
        let names_places = self.path.split_whitespace().any(|word| map.network.edge_named(word).is_none());
        if names_places || (self.path.is_empty() && !map.route.is_closed()) {
            let streets = map.route.lanes().iter().filter(|lane| lane.is_street(&map.network));
            let mut words: Vec<&str> = streets.map(|lane| lane.edge_id(&map.network)).collect();
            // The lane on which the path begins.
            let lane = self.path.split_whitespace().next().filter(|word| map.network.lane_named(word).is_some());
            if let (Some(first), Some(lane)) = (words.first_mut(), lane) {
                *first = lane;
            }
            self.path = words.join(" ");
        }
    }

    /// Loads the road of the drive, with the route along its path if it has one.
    ///
    /// # Errors
    /// As [`RoadMap::load`] and [`RoadMap::load_along`].
    pub fn load_map(&self) -> Result<RoadMap, MapError> {
        let edges: Vec<&str> = self.path.split_whitespace().collect();
        if edges.is_empty() { RoadMap::load(&self.map) } else { RoadMap::load_along(&self.map, &edges) }
    }

    /// Returns true if the drive has spoken sentences.
    pub fn speaks(&self) -> bool {
        let speak_events = self.events.iter().any(ScriptedEvent::speaks);
        self.spoken_guidance || self.secondary_task.speaks() || self.automation.speaks() || speak_events
    }

    /// Returns the half width of the acceptable range, m/s.
    pub fn range_mps(&self) -> f64 {
        self.range_mph * crate::units::MPS_PER_MPH
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Field, SettingKind};
    use serde_json::Value;

    #[test]
    fn every_setting_has_a_doc_a_valid_default_and_limits() {
        for field in Scenario::fields() {
            assert!(!field.doc.is_empty(), "{} has no doc comment", field.path);
            assert_eq!(field.fault(&field.default), None);
            if let SettingKind::Number { min, max } = field.kind {
                assert!(min > f64::MIN && max < f64::MAX, "{} has no limits", field.path);
            }
            if let SettingKind::Choice(words) = &field.kind {
                assert!(words.len() >= 2, "{}: {words:?}", field.path);
            }
        }
    }

    #[test]
    fn the_documented_flags_exist() {
        let flags: Vec<String> = Scenario::fields().iter().map(Field::flag).collect();
        for flag in ["map", "vehicles", "policy", "hold", "range", "units", "traffic", "seed", "duration", "idm.T"] {
            assert!(flags.iter().any(|f| f == flag), "no --{flag} among {flags:?}");
        }
    }

    #[test]
    fn settings_are_in_the_order_of_the_struct() {
        let paths: Vec<String> = Scenario::fields().into_iter().map(|f| f.path).collect();
        assert_eq!(paths[..3], ["map", "vehicles", "traffic"]);
    }

    #[test]
    fn nan_and_out_of_range_are_faults() {
        let list = Scenario::fields();
        let hold = list.iter().find(|f| f.path == "hold_s").unwrap();
        for bad in [Value::from(0.0), Value::from(-1.0), Value::from(f64::NAN), Value::from("1"), Value::Null] {
            assert!(hold.fault(&bad).is_some(), "{bad}");
        }
        assert_eq!(hold.fault(&Value::from(2)), None, "a whole number is a number");
    }
}
