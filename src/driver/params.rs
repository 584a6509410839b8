//! Parameters of simulated drivers. In: a preset's name or a scenario file. Out: [`DriverParams`]. SI units.

use crate::{idm::IdmParams, policy::DriverTraits, toml_text::did_you_mean};
use serde::{Deserialize, Serialize};

/// Error in the name or the numbers of a driver.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum DriverError {
    /// Unknown name of a preset.
    #[error(
        "no driver is called {name:?}{}\n  remedy: use one of {}, or numbers: \
         reaction=1,error=0.5,speed_bias=0,deadband=0",
        did_you_mean(name, &all_presets()),
        all_presets().join(", ")
    )]
    Unknown {
        /// Name of the requested preset.
        name: String,
    },
    /// Unknown name of a number.
    #[error("unknown driver parameter {key:?}{}\n  remedy: use some of {}", did_you_mean(key, &NUMBERS), NUMBERS.join(", "))]
    UnknownNumber {
        /// Given name of the number.
        key: String,
    },
    /// Unknown name of a population.
    #[error("no population of drivers is called {name:?}{near}\n  remedy: use one of {known}")]
    UnknownPopulation {
        /// Name of the requested population.
        name: String,
        /// Suggestion of a similar name, or nothing.
        near: String,
        /// Known names, separated by commas.
        known: String,
    },
    /// Text in the place of a number.
    #[error("driver: {key} is {value:?}\n  remedy: give a number, such as {key}=0.5")]
    NoNumber {
        /// Name of the number.
        key: String,
        value: String,
    },
    /// Number outside the range that can be simulated.
    #[error("driver: {name} = {value} is not allowed\n  remedy: give a number from {min} to {max}")]
    OutOfRange {
        /// Name of the number, as in a scenario file.
        name: &'static str,
        value: f64,
        min: f64,
        max: f64,
    },
}

/// Names of the numbers in a driver's `key=value` text; a missing number is 0.
pub(super) const NUMBERS: [&str; 4] = ["reaction", "error", "speed_bias", "deadband"];
/// Names of the presets that drive as people do.
pub const PRESETS: [&str; 4] = ["follow", "perfect", "idm", "sloppy"];
/// Names of the presets that follow advice exactly, as a machine would.
pub const MACHINES: [&str; 2] = ["exact", "guarded"];

fn all_presets() -> Vec<&'static str> {
    [PRESETS.as_slice(), &MACHINES].concat()
}

/// Behaviour towards the leader under advice; without advice the car-following model always drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LeaderRule {
    /// Keep the distance of the car-following model
    #[default]
    Model,
    /// Brake only to avoid a collision
    Guard,
    /// Ignore the leader while there is advice
    Ignore,
}

/// Parameters of a simulated driver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DriverParams {
    /// Follow the advice on the speedometer; if false, drive by the car-following model alone
    pub follows_advice: bool,
    /// Time from a change of the advice to the foot's first movement, s
    pub reaction_s: f64,
    /// Time from a change of the leader's speed to the foot's first movement, s; shorter than that for advice, because
    /// drivers look at the leader (Green 2000, "How long does it take to stop?": 0.7 to 0.75 s for an expected brake)
    pub leader_reaction_s: f64,
    /// Standard deviation of the speed around the advised one, m/s (an Ornstein-Uhlenbeck process)
    pub error_mps: f64,
    /// Time constant of the speed error, s
    pub error_time_s: f64,
    /// Constant deviation from the advised speed, m/s, positive for faster
    pub speed_bias_mps: f64,
    /// Time constant with which a speed difference is closed, s
    pub speed_relaxation_s: f64,
    /// Largest acceleration to reach an advised speed, m/s²
    pub accel_mps2: f64,
    /// Largest deceleration to reach an advised speed, m/s²; a leader may demand more
    pub decel_mps2: f64,
    /// Largest lateral acceleration in a bend, m/s²
    pub lateral_accel_mps2: f64,
    /// Half width of the band around the target within which the speed is not corrected, m/s
    pub deadband_mps: f64,
    /// Share of the time in which the driver follows the advice, decided every 20 s; otherwise they drive as without it
    pub compliance: f64,
    /// Time in which the compliance fades to 1/e, s; 0: no fading
    pub compliance_fade_s: f64,
    /// Mean speed by which advice below the leader's speed lowers the compliance to 1/e, m/s; 0: no effect
    pub patience_mps: f64,
    /// Spells without a look at the dial, 1/min
    pub inattention_per_min: f64,
    /// Length of a spell without a look at the dial, s
    pub inattention_s: f64,
    /// Behaviour towards the leader under advice
    pub leader_rule: LeaderRule,
    /// Car-following model (IDM)
    pub idm: IdmParams,
    /// Time of the foot from one pedal to the other, s
    pub foot_s: f64,
    /// Fastest movement of the accelerator, full pedals per second
    pub throttle_per_s: f64,
    /// Fastest movement of the brake pedal, full pedals per second
    pub brake_per_s: f64,
    /// Distance of the target point of the steering, s of driving
    pub preview_s: f64,
    /// Time constant of the arms, s
    pub arm_s: f64,
    /// Largest rate of the steering wheel, rad/s
    pub wheel_rad_s: f64,
    /// Standard deviation of the lateral position in the lane, m
    pub lane_error_m: f64,
}

impl Default for DriverParams {
    /// Returns `follow`: an attentive participant (reaction time 1 s, tracking error 0.3 m/s).
    fn default() -> Self {
        Self {
            follows_advice: true,
            reaction_s: 1.0,
            leader_reaction_s: 0.7,
            error_mps: 0.3,
            error_time_s: 5.0,
            speed_bias_mps: 0.0,
            speed_relaxation_s: 1.5,
            accel_mps2: 1.5,
            decel_mps2: 2.0,
            lateral_accel_mps2: 3.0,
            deadband_mps: 0.0,
            compliance: 1.0,
            compliance_fade_s: 0.0,
            patience_mps: 0.0,
            inattention_per_min: 0.0,
            inattention_s: 0.0,
            leader_rule: LeaderRule::Model,
            idm: IdmParams::default(),
            foot_s: 0.25,
            throttle_per_s: 1.0,
            brake_per_s: 3.0,
            preview_s: 1.0,
            arm_s: 0.12,
            wheel_rad_s: 6.0,
            lane_error_m: 0.05,
        }
    }
}

/// Returns the driver preset `name`.
///
/// * `follow`: follows the advice, with a reaction time of 1 s and a tracking error of 0.3 m/s;
/// * `perfect`: follows it without delay or error;
/// * `idm`: ignores it and drives by the car-following model, the human baseline;
/// * `sloppy`: follows it late (1.5 s), imprecisely (0.8 m/s) and a little too fast (0.3 m/s);
/// * `exact`: follows it exactly and ignores the leader;
/// * `guarded`: follows it exactly, but brakes to avoid a collision.
///
/// # Errors
/// The name is unknown; the message lists all presets.
pub fn preset(name: &str) -> Result<DriverParams, DriverError> {
    let follow = DriverParams::default();
    let exact = DriverParams {
        reaction_s: 0.0,
        leader_reaction_s: 0.0,
        error_mps: 0.0,
        lane_error_m: 0.0,
        foot_s: 0.1,
        ..follow.clone()
    };
    match name {
        "follow" => Ok(follow),
        "perfect" => Ok(exact),
        "idm" => Ok(DriverParams { follows_advice: false, ..exact }),
        "sloppy" => Ok(DriverParams {
            reaction_s: 1.5,
            leader_reaction_s: 1.0,
            error_mps: 0.8,
            speed_bias_mps: 0.3,
            lane_error_m: 0.08,
            ..follow
        }),
        "exact" | "guarded" => Ok(DriverParams {
            leader_rule: if name == "exact" { LeaderRule::Ignore } else { LeaderRule::Guard },
            speed_relaxation_s: 0.5,
            decel_mps2: 4.5,
            ..exact
        }),
        _ => Err(DriverError::Unknown { name: name.to_owned() }),
    }
}

impl DriverParams {
    /// Returns the traits that matter for advice; `usual_time_gap_s` is the other vehicles' time gap. The willingness
    /// is the one at the start, before it fades.
    pub fn traits(&self, usual_time_gap_s: f64) -> DriverTraits {
        DriverTraits {
            reaction_s: self.reaction_s,
            speed_bias_mps: self.speed_bias_mps,
            error_mps: self.error_mps,
            time_gap_factor: self.idm.t / usual_time_gap_s,
            willingness: if self.follows_advice { self.compliance } else { 0.0 },
        }
    }

    /// Returns true for a driver who errs. One who does not follows advice and leaders exactly.
    pub fn errs(&self) -> bool {
        self.error_mps > 0.0
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first number that is not finite or lies outside the range that can be simulated.
    pub fn check(&self) -> Result<(), DriverError> {
        let ranges = [
            ("reaction_s", self.reaction_s, 0.0, 5.0),
            ("leader_reaction_s", self.leader_reaction_s, 0.0, 5.0),
            ("error_mps", self.error_mps, 0.0, 5.0),
            ("error_time_s", self.error_time_s, 0.1, 100.0),
            ("speed_bias_mps", self.speed_bias_mps, -10.0, 10.0),
            ("speed_relaxation_s", self.speed_relaxation_s, 0.5, 10.0),
            ("accel_mps2", self.accel_mps2, 0.1, 5.0),
            ("decel_mps2", self.decel_mps2, 0.1, 9.0),
            ("lateral_accel_mps2", self.lateral_accel_mps2, 0.5, 8.0),
            ("deadband_mps", self.deadband_mps, 0.0, 5.0),
            ("compliance", self.compliance, 0.0, 1.0),
            ("compliance_fade_s", self.compliance_fade_s, 0.0, 1e6),
            ("patience_mps", self.patience_mps, 0.0, 100.0),
            ("inattention_per_min", self.inattention_per_min, 0.0, 60.0),
            ("inattention_s", self.inattention_s, 0.0, 60.0),
            ("idm.v0", self.idm.v0, 1.0, 60.0),
            ("idm.T", self.idm.t, 0.1, 5.0),
            ("idm.a", self.idm.a, 0.1, 5.0),
            ("idm.b", self.idm.b, 0.1, 9.0),
            ("idm.delta", self.idm.delta, 0.5, 10.0),
            ("idm.s0", self.idm.s0, 0.1, 20.0),
            ("foot_s", self.foot_s, 0.0, 1.0),
            ("throttle_per_s", self.throttle_per_s, 0.1, 20.0),
            ("brake_per_s", self.brake_per_s, 0.5, 20.0),
            ("preview_s", self.preview_s, 0.3, 5.0),
            ("arm_s", self.arm_s, 0.0, 0.5),
            ("wheel_rad_s", self.wheel_rad_s, 0.5, 30.0),
            ("lane_error_m", self.lane_error_m, 0.0, 0.5),
        ];
        for (name, value, min, max) in ranges {
            if !(min..=max).contains(&value) {
                return Err(DriverError::OutOfRange { name, value, min, max });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_valid_and_an_unknown_name_lists_them() {
        for name in all_presets() {
            assert_eq!(preset(name).unwrap().check(), Ok(()), "{name}");
        }
        let message = preset("folow").unwrap_err().to_string();
        assert!(message.contains("\"folow\"") && message.contains("follow, perfect, idm, sloppy"), "{message}");
    }

    #[test]
    fn a_nonsense_driver_is_refused_by_name() {
        let driver = DriverParams { reaction_s: f64::NAN, ..DriverParams::default() };
        assert!(driver.check().unwrap_err().to_string().contains("reaction_s = NaN"));
    }
}
