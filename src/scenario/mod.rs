//! All settings that make one drive. This struct **is** the command line, the scenario file and the panel: the doc
//! comments below are the help and the tooltips, the ranges are the limits, written once ([`crate::settings`] reads them).
//! Keys carry their unit; the flag on the command line is the key without it (`hold_s` is `--hold SECS`).

mod advised;
pub mod colour;
mod display;
mod load;
pub mod sound;

pub use advised::{AdvisedVehicles, UnknownShare};
pub use display::{CockpitView, DialPalette, QualityLevel};
pub use load::path_from;
pub use sound::SoundLevels;

use crate::{
    idm::IdmParams,
    map::{MapError, RoadMap, Route},
    policy::{self, Hold},
    settings::flat_settings,
    traffic::{Demand, EngineChoice, FollowingModel},
    units::SpeedUnit,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

flat_settings! {
    /// One drive, complete.
    pub struct Scenario, written as scenario_file {
        fields {
            /// Road: the name of a map, or the path of a SUMO net.xml; a path in a file starts at that file's folder
            map: String = "ring-250".into(),
            /// Cars on the route, the ego included
            #[schemars(range(min = 2, max = 1000))]
            vehicles: u32 = 22,
            /// Traffic engine of the other cars
            traffic: EngineChoice = EngineChoice::Sumo,
            /// Edges of the road's network along which the ego drives, in order, spaces between their ids: the drive is on the network,
            /// and over at the end of the last; empty drives the route of the road
            path: String = String::new(),
            /// Where on its path, or on a network on the closed route, the ego's front starts; less than 5 starts a car's length from
            /// its beginning
            #[schemars(range(min = 0.0, max = 100_000.0), extend("unit" = "m"))]
            path_start_m: f64 = 0.0,
            /// There is a participant's vehicle. Without it, which needs a demand and `codrive run`, vehicles come and go alone, the advised
            /// ones among them, for the whole duration
            participant: bool = true,
            /// Who comes to the road's network, where from and where to: files of SUMO's, flows from edge to edge. With it the drive is
            /// on the network
            #[schemars(skip)]
            #[serde(skip_serializing_if = "Demand::is_empty")]
            demand: Demand = Demand::default(),
            /// Car-following model of the other cars: v0=30,T=1,a=1,b=1.5,delta=4,s0=2,noise=0.2
            idm: IdmParams = IdmParams::default(),
            /// Car-following model of a share of the other cars, SUMO's own with its own numbers and noise; all but idm need traffic sumo
            other_model: FollowingModel = FollowingModel::Idm,
            /// That share
            #[schemars(range(min = 0.0, max = 1.0))]
            other_model_share: f64 = 1.0,
            /// Largest lateral acceleration of the other cars in bends; 0 is automatic: 3, and no bound on a ring, whose models know
            /// none; 100 sets no bound anywhere
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/s2"))]
            lateral_accel_mps2: f64 = 0.0,
            /// Initial placement of the cars
            start: StartLayout = StartLayout::Even,
            /// Traffic runs this long before the drive, the ego driven by the same model
            #[schemars(range(min = 0.0, max = 3600.0), extend("unit" = "s"))]
            warm_up_s: f64 = 0.0,
            /// Hand-over waits until speeds have differed this much among all cars (standard deviation) for 10 s; 0 does not wait
            #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "m/s"))]
            wave_sd_mps: f64 = 0.0,
            /// Hand-over waits until the ego stands, so that the drive begins with a foot on the brake
            standing_start: bool = false,
            /// Longest that hand-over waits after the warm-up; then the drive begins as traffic is, and the recording says so
            #[schemars(range(min = 0.0, max = 3600.0), extend("unit" = "s"))]
            wave_wait_s: f64 = 600.0,
            /// Length of a step of traffic and policy, a multiple of 0.01 s
            #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "s"))]
            step_s: f64 = 0.1,
            /// Length of the drive, at most 7 days; 0 drives until the window is closed
            #[schemars(range(min = 0.0, max = 604800.0), extend("unit" = "s"))]
            duration_s: f64 = 300.0,
            /// Seed of everything random: noise, simulated driver, trees
            #[schemars(range(min = 0, max = 9007199254740991_u64))]
            seed: u64 = 1,
            /// Advising policy: auto (the one shipped for the map, two-phase where there is none), none, constant, two-phase,
            /// follower-stopper, pi, linear-feedback, ring-250-speed or another of assets/policies, or a FILE.toml or FILE.onnx
            policy: String = policy::AUTO.into(),
            /// How many vehicles are advised, the participant's the first: a share of all (5%, 0.05; on a network of the cars that come) or a
            /// number (3); 0 advises nobody. The others have the same policy and are driven by the simulated driver
            advised: AdvisedVehicles = AdvisedVehicles::default(),
            /// Speed that these policies aim for; 0 takes 98.5 % of the speed at which an even ring flows
            #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "m/s"))]
            policy_speed_mps: f64 = 0.0,
            /// How long one advice is held, a whole number of steps
            #[schemars(range(min = 0.01, max = 600.0), extend("unit" = "s"))]
            // HC22 holds for one step of 0.1 s; a person cannot follow ten new targets a second.
            hold_s: f64 = 1.0,
            /// Advice is that of another drive, with these settings, another seed and a simulated driver: as often and as large, but
            /// it has nothing to do with this traffic
            sham_advice: bool = false,
            /// Half width of the acceptable range around the target
            #[schemars(range(min = 0.1, max = 50.0), extend("unit" = "mph"))]
            // docs/references.md: band: a useful band on the 250 m ring is about +-1 mph.
            range_mph: f64 = 1.0,
        }
        /// What the participant sees, and on what: nothing of it moves a car.
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
            /// Other cars in ordinary paints in the driver's view (green otherwise; always green in the bird's-eye view)
            ordinary_paints: bool = true,
            /// Time of day by the sun, which is highest at 12, late in summer
            #[schemars(range(min = 6.0, max = 18.0), extend("unit" = "h"))]
            time_h: f64 = 9.75,
            /// Haze: how far one sees
            #[schemars(range(min = 1.0, max = 100.0), extend("unit" = "km"))]
            visibility_km: f64 = 30.0,
            /// Wind in the trees
            #[schemars(range(min = 0.0, max = 15.0), extend("unit" = "m/s"))]
            wind_mps: f64 = 2.5,
            /// Trees around the road and on the horizon, at most; a car drives through them
            #[schemars(range(min = 0, max = 20_000))]
            trees: u32 = 5000,
            /// Paint of the own car: a name or #rrggbb
            ego_colour: String = "red".into(),
            /// Paint of the other cars where they wear one colour: a name or #rrggbb
            traffic_colour: String = "green".into(),
            /// What is seen of the own car in the driver's view
            cockpit: CockpitView = CockpitView::default(),
            /// Colours of the speedometer
            palette: DialPalette = DialPalette::default(),
            /// Full scale of the speedometer in its unit, rounded up to a scale that it has (10, 15, 20, 25, 30, 40, 50, 60, 80, 100 and
            /// on); 0 takes one that suits the drive, in a study one that suits all trials
            #[schemars(range(min = 0.0, max = 240.0))]
            dial_full: f64 = 0.0,
            /// Mirror turned sideways; more shows more of what is behind on the left
            #[schemars(range(min = -30.0, max = 30.0), extend("unit" = "deg"))]
            mirror_yaw_deg: f64 = 0.0,
            /// Mirror tilted; more looks higher
            #[schemars(range(min = -20.0, max = 20.0), extend("unit" = "deg"))]
            mirror_pitch_deg: f64 = -2.5,
            /// Horizontal angle that the mirror shows if it is flat
            #[schemars(range(min = 10.0, max = 60.0), extend("unit" = "deg"))]
            mirror_fov_deg: f64 = 30.0,
            /// Radius of a convex mirror, at least 0.8: shows more, and smaller; 0 is flat
            #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "m"))]
            mirror_radius_m: f64 = 0.0,
            /// Effort put into the picture; sizes, positions and lamps are the same in all
            quality: QualityLevel = QualityLevel::Auto,
        }
        fields {
            /// How loud things are
            sound: SoundLevels = SoundLevels::default(),
            /// A gentle tone when another speed is advised
            advice_tone: bool = false,
            /// Rev lamps of the wheel show the speed against the advice: one below the range, three within, all above
            rev_lamps: bool = false,
            /// A square in the upper left corner, black, that is white for one frame: for a photodiode or a phone's camera
            flash_patch: FlashPatch = FlashPatch::Off,
            /// Controls reach the car so much later, a multiple of 0.01 s; recordings hold them as they were given
            #[schemars(range(min = 0.0, max = 0.5), extend("unit" = "s"))]
            extra_delay_s: f64 = 0.0,
            /// Car creeps forward in gear when no pedal is pressed
            creep: bool = true,
            /// Keyboard steering is helped to stay in the lane
            lane_help: bool = true,
            /// What a contact with another car does
            contact: OnContact = OnContact::Continue,
            /// Simulated driver of `codrive run`, and of advised vehicles that are not the participant's: follow, perfect, sloppy, idm (ignores advice), exact, guarded, or numbers such as
            /// reaction=1,error=0.5,speed_bias=0,deadband=0 (s, m/s)
            driver: String = "follow".into(),
        }
    }
}

/// How cars stand on the route at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum StartLayout {
    /// Evenly spaced, at a standstill
    #[default]
    Even,
    /// Close together with one long hole ahead of the ego's leader: a wave within about 75 s
    Bunched,
}

/// What a contact with another car does to the drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OnContact {
    /// It is recorded and the drive goes on
    #[default]
    Continue,
    /// It is recorded and the drive ends
    End,
}

/// What makes the square in the picture's corner white for one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FlashPatch {
    /// There is no square
    #[default]
    Off,
    /// A tick has used a pedal that left its rest
    Pedal,
    /// A tick has brought another advice
    Advice,
}

impl Scenario {
    /// Ticks in a step.
    pub fn step_ticks(&self) -> u64 {
        (self.step_s / crate::time::TICK_S).round() as u64
    }

    /// How long one advice stands.
    pub fn hold(&self) -> Hold {
        Hold::nearest(self.hold_s, self.step_s)
    }

    /// Ticks by which controls come later.
    pub fn extra_delay_ticks(&self) -> usize {
        (self.extra_delay_s / crate::time::TICK_S).round() as usize
    }

    /// The lateral acceleration that bounds the other cars' speed in the bends of a route, m/s2, if one does.
    pub fn lateral_accel_bound_mps2(&self, route: &Route) -> Option<f64> {
        /// What is taken for comfortable (the simulated drivers' own).
        const COMFORTABLE_MPS2: f64 = 3.0;
        /// The setting that says that there is no bound.
        const NONE_MPS2: f64 = 100.0;
        match self.lateral_accel_mps2 {
            set if set <= 0.0 => (!route.is_ring()).then_some(COMFORTABLE_MPS2),
            set => (set < NONE_MPS2).then_some(set),
        }
    }

    /// True if the drive is on a network, where vehicles come and go; false on a closed route with a fixed number of cars.
    pub fn is_on_network(&self) -> bool {
        !self.path.trim().is_empty() || !self.demand.is_empty()
    }

    /// True if no vehicle can be advised: none is to be, or only the participant's, which is not there.
    pub fn advises_nobody(&self) -> bool {
        let no_other = self.advised.of_those_that_come() == 0.0;
        self.advised.is_nobody() || (!self.participant && no_other)
    }

    /// The road of the drive, with the route along its path if it has one.
    ///
    /// # Errors
    /// As [`RoadMap::load`] and [`RoadMap::load_along`].
    pub fn load_map(&self) -> Result<RoadMap, MapError> {
        let edges: Vec<&str> = self.path.split_whitespace().collect();
        if edges.is_empty() { RoadMap::load(&self.map) } else { RoadMap::load_along(&self.map, &edges) }
    }

    /// The same with what its road says where it names neither path nor demand: who comes there, if the road has a demand of its own, and the
    /// path, if that is open: such a road is driven as a network.
    pub fn on(&self, map: &RoadMap) -> Self {
        let mut scenario = self.clone();
        if !scenario.is_on_network() {
            scenario.demand.files.extend(map.demand_file());
        }
        if scenario.path.is_empty() && !map.route.is_closed() {
            let streets = map.route.lanes().iter().filter(|lane| !lane.edge.starts_with(':'));
            scenario.path = streets.map(|lane| lane.edge.as_str()).collect::<Vec<_>>().join(" ");
        }
        scenario
    }

    /// Half width of the acceptable range, m/s.
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
    fn flags_of_the_contract_exist() {
        let flags: Vec<String> = Scenario::fields().iter().map(Field::flag).collect();
        for flag in ["map", "vehicles", "policy", "hold", "range", "units", "traffic", "seed", "duration", "idm.T"] {
            assert!(flags.iter().any(|f| f == flag), "no --{flag} among {flags:?}");
        }
    }

    #[test]
    fn the_order_is_that_of_the_struct() {
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
