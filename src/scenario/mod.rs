//! Everything that makes one drive. This struct **is** the command line, the scenario file and the panel: the doc
//! comments below are the help and the tooltips, the ranges are the limits, written once ([`crate::settings`] reads them).
//! Keys carry their unit; the flag on the command line is the key without it (`hold_s` is `--hold SECS`).

pub mod colour;
mod load;
pub mod sound;

pub use sound::SoundLevels;

use crate::{idm::IdmParams, map::Route, units::SpeedUnit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One drive, complete.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// Road: a folder of maps/, or a SUMO net.xml with a closed route
    pub map: String,
    /// Cars on the route, the ego included
    #[schemars(range(min = 2, max = 1000))]
    pub vehicles: u32,
    /// Who moves the other cars: sumo (in this program), native (our own IDM ring), or HOST:PORT of a SUMO elsewhere
    pub traffic: String,
    /// How long a SUMO elsewhere may take for the connection and for each answer; then the drive ends, and is kept
    #[schemars(range(min = 0.1, max = 600.0), extend("unit" = "s"))]
    pub traffic_timeout_s: f64,
    /// Car-following model of the other cars: v0=30,T=1,a=1,b=1.5,delta=4,s0=2,noise=0.2
    pub idm: IdmParams,
    /// Largest lateral acceleration of the other cars in bends; 0 is automatic: 3, and no bound on a ring, whose models know
    /// none; 100 sets no bound anywhere
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/s2"))]
    #[schemars(extend("formerly" = "bend_mps2"))]
    #[serde(alias = "bend_mps2")]
    pub lateral_accel_mps2: f64,
    /// How the cars stand at the start
    pub start: StartLayout,
    /// Traffic runs this long before the drive, the ego driven by the same model
    #[schemars(range(min = 0.0, max = 3600.0), extend("unit" = "s"))]
    pub warm_up_s: f64,
    /// Length of a step of traffic and policy, a multiple of 0.01 s
    #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "s"))]
    pub step_s: f64,
    /// Length of the drive, at most 7 days; 0 drives until the window is closed
    #[schemars(range(min = 0.0, max = 604800.0), extend("unit" = "s"))]
    pub duration_s: f64,
    /// Seed of everything random: noise, simulated driver, trees
    #[schemars(range(min = 0, max = 9007199254740991_u64))]
    pub seed: u64,

    /// Who advises: auto (the policy shipped for the map, two-phase where there is none), none, constant, two-phase,
    /// follower-stopper, pi, ring-250-speed or another of assets/policies, or a FILE.toml or FILE.onnx
    pub policy: String,
    /// Speed that these policies aim for; 0 takes 98.5 % of the speed at which an even ring flows
    #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "m/s"))]
    pub policy_speed_mps: f64,
    /// How long one advice stands, a whole number of steps
    #[schemars(range(min = 0.01, max = 600.0), extend("unit" = "s"))]
    pub hold_s: f64,
    /// Half width of the acceptable range around the target
    #[schemars(range(min = 0.1, max = 50.0), extend("unit" = "mph"))]
    pub range_mph: f64,

    /// Unit on the speedometer
    pub units: SpeedUnit,
    /// Width of the visible picture on the screen
    #[schemars(range(min = 0.1, max = 10.0), extend("unit" = "m"))]
    pub screen_width_m: f64,
    /// Distance from the driver's eyes to the screen
    #[schemars(range(min = 0.2, max = 10.0), extend("unit" = "m"))]
    pub eye_distance_m: f64,
    /// Other cars in ordinary paints in the driver's view (green otherwise; always green in the bird's-eye view)
    pub ordinary_paints: bool,
    /// Time of day by the sun, which is highest at 12, late in summer
    #[schemars(range(min = 6.0, max = 18.0), extend("unit" = "h"))]
    pub time_h: f64,
    /// Haze: how far one sees
    #[schemars(range(min = 1.0, max = 100.0), extend("unit" = "km"))]
    pub visibility_km: f64,
    /// Wind in the trees
    #[schemars(range(min = 0.0, max = 15.0), extend("unit" = "m/s"))]
    pub wind_mps: f64,
    /// Trees around the road and on the horizon, at most; a car drives through them
    #[schemars(range(min = 0, max = 20_000))]
    pub trees: u32,
    /// Paint of the own car: a name or #rrggbb
    pub ego_colour: String,
    /// Paint of the other cars where they wear one colour: a name or #rrggbb
    pub traffic_colour: String,
    /// What is seen of the own car in the driver's view
    pub cockpit: CockpitView,
    /// Colours of the speedometer
    pub palette: DialPalette,
    /// Full scale of the speedometer in its unit, rounded up to a scale that it has (10, 15, 20, 25, 30, 40, 50, 60, 80, 100 and
    /// on); 0 takes one that suits the drive, in a study one that suits all trials
    #[schemars(range(min = 0.0, max = 240.0))]
    pub dial_full: f64,
    /// Mirror turned sideways; more shows more of what is behind on the left
    #[schemars(range(min = -30.0, max = 30.0), extend("unit" = "deg"))]
    pub mirror_yaw_deg: f64,
    /// Mirror tilted; more looks higher
    #[schemars(range(min = -20.0, max = 20.0), extend("unit" = "deg"))]
    pub mirror_pitch_deg: f64,
    /// Horizontal angle that the mirror shows if it is flat
    #[schemars(range(min = 10.0, max = 60.0), extend("unit" = "deg"))]
    pub mirror_fov_deg: f64,
    /// Radius of a convex mirror, at least 0.8: shows more, and smaller; 0 is flat
    #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "m"))]
    pub mirror_radius_m: f64,
    /// Effort put into the picture; sizes, positions and lamps are the same in all
    pub quality: QualityLevel,

    /// How loud things are
    pub sound: SoundLevels,
    /// A gentle tone when another speed is advised
    pub advice_tone: bool,
    /// Rev lamps of the wheel show the speed against the advice: one below the range, three within, all above
    pub rev_lamps: bool,
    /// A square in the upper left corner, black, that is white for one frame: for a photodiode or a phone's camera
    pub flash_patch: FlashPatch,
    /// Controls reach the car so much later, a multiple of 0.01 s; recordings hold them as they were given
    #[schemars(range(min = 0.0, max = 0.5), extend("unit" = "s"))]
    pub extra_delay_s: f64,

    /// Car creeps forward in gear when no pedal is pressed
    pub creep: bool,
    /// Keyboard steering is helped to stay in the lane
    pub lane_help: bool,
    /// What a contact with another car does
    pub contact: OnContact,
    /// Simulated driver of `codrive run`: follow, perfect, sloppy, idm (ignores advice), exact, guarded, or numbers such as
    /// reaction=1,error=0.5,speed_bias=0,deadband=0 (s, m/s)
    pub driver: String,
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

/// What is seen of the own car in the driver's view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CockpitView {
    /// Nothing
    Off,
    /// Bonnet and scuttle: where the car ends, while the wheel and the dashboard are the rig's own
    #[default]
    Bonnet,
    /// Dashboard with instruments, pillars, three mirrors and a steering wheel that turns, too: for a screen without a wheel before it
    Full,
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

/// Colours of the speedometer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DialPalette {
    /// Red line, green band, as in HC22
    #[default]
    Standard,
    /// Orange line, blue band: for people who confuse red and green
    ColourBlindSafe,
}

/// Effort put into the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum QualityLevel {
    /// Low where graphics run in software, high on a graphics card of its own, medium elsewhere
    #[default]
    Auto,
    /// For software rendering and old laptops
    Low,
    /// For ordinary computers
    Medium,
    /// For the rig
    High,
}

impl Default for Scenario {
    /// HC22's ring: 250 m, 22 cars, advice on the speedometer.
    fn default() -> Self {
        Self {
            map: "ring-250".into(),
            vehicles: 22,
            traffic: "sumo".into(),
            traffic_timeout_s: 5.0,
            idm: IdmParams::default(),
            lateral_accel_mps2: 0.0,
            start: StartLayout::Even,
            warm_up_s: 0.0,
            step_s: 0.1,
            duration_s: 300.0,
            seed: 1,
            policy: crate::policy::AUTO.into(),
            policy_speed_mps: 0.0,
            // HC22 holds for one step of 0.1 s; a person cannot follow ten new targets a second.
            hold_s: 1.0,
            // docs/references.md: band: a useful band on the 250 m ring is about +-1 mph.
            range_mph: 1.0,
            units: SpeedUnit::Mph,
            // A 55-inch TV at 1.0 m: 63 degrees (docs/references.md: display).
            screen_width_m: 1.218,
            eye_distance_m: 1.0,
            ordinary_paints: true,
            wind_mps: 2.5,
            trees: 5000,
            ego_colour: "red".into(),
            traffic_colour: "green".into(),
            cockpit: CockpitView::default(),
            palette: DialPalette::default(),
            dial_full: 0.0,
            mirror_yaw_deg: 0.0,
            mirror_pitch_deg: -2.5,
            mirror_fov_deg: 30.0,
            mirror_radius_m: 0.0,
            time_h: 9.75,
            visibility_km: 30.0,
            quality: QualityLevel::Auto,
            sound: SoundLevels::default(),
            advice_tone: false,
            rev_lamps: false,
            flash_patch: FlashPatch::Off,
            extra_delay_s: 0.0,
            creep: true,
            lane_help: true,
            contact: OnContact::Continue,
            driver: "follow".into(),
        }
    }
}

impl Scenario {
    /// Ticks in a step.
    pub fn step_ticks(&self) -> u64 {
        (self.step_s / crate::time::TICK_S).round() as u64
    }

    /// Steps in a hold, at least 1.
    pub fn hold_steps(&self) -> u32 {
        (self.hold_s / self.step_s).round().max(1.0) as u32
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

    /// Half width of the acceptable range, m/s.
    pub fn range_mps(&self) -> f64 {
        self.range_mph * crate::units::MPS_PER_MPH
    }
}

impl std::fmt::Display for QualityLevel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Auto => "auto",
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Field, Kind};
    use serde_json::Value;

    #[test]
    fn every_setting_has_a_doc_a_valid_default_and_limits() {
        for field in Scenario::fields() {
            assert!(!field.doc.is_empty(), "{} has no doc comment", field.path);
            assert_eq!(field.fault(&field.default), None);
            if let Kind::Number { min, max } = field.kind {
                assert!(min > f64::MIN && max < f64::MAX, "{} has no limits", field.path);
            }
            if let Kind::Choice(words) = &field.kind {
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
