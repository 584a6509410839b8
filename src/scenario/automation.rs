//! Settings of the automation. In: the table `[automation]` of a scenario. Out: an [`Automation`].

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Automation of the participant's vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Automation {
    /// System that drives in the participant's place
    pub system: AutomationSystem,
    /// The system is on when the drive begins; otherwise the participant switches it on
    pub starts_on: bool,
    /// Set speed; 0: the speed limit of the road. The traffic-jam pilot drives at most 60 km/h, the policy at the speed that it advises
    #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "m/s"))]
    pub set_speed_mps: f64,
    /// Time gap to the vehicle ahead, until the participant sets another one
    #[schemars(range(min = 0.8, max = 4.0), extend("unit" = "s"))]
    // Lower limit: ISO 15622 (docs/references.md: automation).
    pub time_gap_s: f64,
    /// Turn of the steering wheel, away from the system's, that takes over the steering
    #[schemars(range(min = 2.0, max = 90.0), extend("unit" = "deg"))]
    pub override_deg: f64,
    /// Torque of the hands from which they are on the steering wheel, where the wheel has force feedback
    #[schemars(range(min = 0.3, max = 5.0), extend("unit" = "N m"))]
    pub hands_on_nm: f64,
    /// Torque of the hands that takes over the steering, where the wheel has force feedback
    #[schemars(range(min = 0.5, max = 10.0), extend("unit" = "N m"))]
    pub override_nm: f64,
    /// Deceleration of a minimal-risk manoeuvre
    #[schemars(range(min = 0.5, max = 4.0), extend("unit" = "m/s2"))]
    // Upper limit: UN Regulation 157, 5.5.1 (docs/references.md: automation).
    pub minimal_risk_mps2: f64,
    /// Speak takeover requests in English, by the program espeak-ng
    pub spoken_requests: bool,
}

impl Default for Automation {
    fn default() -> Self {
        Self {
            system: AutomationSystem::None,
            starts_on: true,
            set_speed_mps: 0.0,
            time_gap_s: 1.5,
            override_deg: 10.0,
            hands_on_nm: 0.5,
            override_nm: 1.0,
            minimal_risk_mps2: 3.0,
            spoken_requests: true,
        }
    }
}

impl Automation {
    /// Returns true if the automation can speak.
    pub fn speaks(&self) -> bool {
        self.system != AutomationSystem::None && self.spoken_requests
    }
}

/// System of an automation, with its level of SAE J3016 (docs/references.md: automation).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AutomationSystem {
    /// Level 0: the participant drives
    #[default]
    None,
    /// Level 1: pedals
    AdaptiveCruiseControl,
    /// Level 1: steering wheel
    LaneKeeping,
    /// Level 2: pedals and steering wheel, without regard to signals and right of way
    CruiseAndLaneKeeping,
    /// Level 3: all driving up to 60 km/h
    TrafficJamPilot,
    /// Level 3: all driving, at the speed that the policy advises. That advice is not shown while the system is on
    Policy,
}

impl AutomationSystem {
    /// Returns the level of driving automation of SAE J3016, 0 to 3.
    pub fn level(self) -> u8 {
        match self {
            Self::None => 0,
            Self::AdaptiveCruiseControl | Self::LaneKeeping => 1,
            Self::CruiseAndLaneKeeping => 2,
            Self::TrafficJamPilot | Self::Policy => 3,
        }
    }

    /// Returns true if the system moves the pedals.
    pub fn keeps_speed(self) -> bool {
        !matches!(self, Self::None | Self::LaneKeeping)
    }

    /// Returns true if the system keeps a time gap to the vehicle ahead; the policy only avoids collisions.
    pub fn keeps_time_gap(self) -> bool {
        self.keeps_speed() && self != Self::Policy
    }

    /// Returns true if the system turns the steering wheel.
    pub fn steers(self) -> bool {
        !matches!(self, Self::None | Self::AdaptiveCruiseControl)
    }
}
