//! What is to be driven: policies, holds and drivers, each with each. In: the command line. Out: a [`Plan`].

use super::{CliError, settings};
use crate::{
    driver,
    policy::{self, PolicySettings},
    train::{FollowKind, TrainConfig},
};
use clap::ArgMatches;
use std::path::PathBuf;

/// Who follows the advice.
#[derive(Clone, Debug, PartialEq)]
pub enum Driver {
    /// As the configuration says.
    Configured,
    /// To the letter.
    Exact,
    /// To the letter, but brakes where it must.
    Guarded,
    /// A preset of the whole drive's simulated drivers.
    Preset(String),
    /// Such numbers, in m/s and seconds.
    Numbers(Numbers),
}

/// A driver in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Numbers {
    /// Reaction time, seconds.
    pub reaction_s: f64,
    /// Tracking error, m/s.
    pub error_mps: f64,
    /// Constant deviation, m/s.
    pub trait_mps: f64,
    /// Half width of the range in which any speed is as good, m/s.
    pub slack_mps: f64,
}

/// Reads a driver from the command line.
pub fn driver(text: &str) -> Result<Driver, String> {
    match text {
        "exact" => return Ok(Driver::Exact),
        "guarded" => return Ok(Driver::Guarded),
        name if ["perfect", "follow", "sloppy", "idm"].contains(&name) => return Ok(Driver::Preset(name.into())),
        _ => {}
    }
    let mut numbers = Numbers::default();
    for pair in text.split(',') {
        let known = "known are exact, guarded, perfect, follow, sloppy, idm, or numbers as reaction=1,error=0.5,trait=0,slack=0";
        let (key, value) = pair.split_once('=').ok_or(format!("driver `{text}` is unknown; {known}"))?;
        let value: f64 = value.parse().map_err(|_| format!("`{value}` is not a number"))?;
        let (low, place) = match key {
            "reaction" => (0.0, &mut numbers.reaction_s),
            "error" => (0.0, &mut numbers.error_mps),
            "trait" => (-5.0, &mut numbers.trait_mps),
            "slack" => (0.0, &mut numbers.slack_mps),
            _ => return Err(format!("`{key}` is unknown; {known}")),
        };
        if !(low..=5.0).contains(&value) {
            return Err(format!("{key} is {value}; allowed: {low} to 5"));
        }
        *place = value;
    }
    Ok(Driver::Numbers(numbers))
}

impl Driver {
    /// Its name in tables and files.
    pub fn name(&self) -> String {
        match self {
            Self::Configured => "configured".into(),
            Self::Exact => "exact".into(),
            Self::Guarded => "guarded".into(),
            Self::Preset(name) => name.clone(),
            Self::Numbers(n) => {
                let mut text = format!("reaction {} s, error {} m/s", n.reaction_s, n.error_mps);
                for (what, value) in [("trait", n.trait_mps), ("slack", n.slack_mps)] {
                    if value != 0.0 {
                        text.push_str(&format!(", {what} {value} m/s"));
                    }
                }
                text
            }
        }
    }

    /// The configuration with this driver.
    pub fn of(&self, config: &TrainConfig) -> TrainConfig {
        let exact = TrainConfig { follow: FollowKind::Exact, brakes_for_leader: false, ..config.clone() };
        match self {
            Self::Configured => config.clone(),
            Self::Exact => exact,
            Self::Guarded => TrainConfig { brakes_for_leader: true, ..exact },
            Self::Preset(name) => {
                let p = driver::preset(name).unwrap_or_default();
                let numbers = Numbers {
                    reaction_s: p.reaction_s,
                    error_mps: p.error_mps,
                    trait_mps: p.trait_mps,
                    slack_mps: 0.0,
                };
                Self::Numbers(numbers).of(config)
            }
            Self::Numbers(n) => TrainConfig {
                follow: FollowKind::Driver,
                random_driver: false,
                reaction_s: n.reaction_s,
                error_mps: n.error_mps,
                trait_mps: n.trait_mps,
                slack_mps: n.slack_mps,
                ..exact
            },
        }
    }
}

/// One row of the evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Name or file of the policy.
    pub policy: String,
    /// Hold, seconds.
    pub hold_s: f64,
    /// Who follows.
    pub driver: Driver,
}

impl Case {
    /// The configuration of its rings.
    pub fn config(&self, config: &TrainConfig) -> TrainConfig {
        TrainConfig { hold_s: self.hold_s, hold_max_s: 0.0, ..self.driver.of(config) }
    }

    /// The policy's name without what is the same for all shipped ones.
    pub fn label(&self) -> String {
        let bare = self.policy.trim_end_matches("/policy.toml").trim_end_matches("/policy.onnx");
        bare.rsplit('/').next().unwrap_or(bare).to_owned()
    }
}

/// All of it.
pub struct Plan {
    /// Names or files.
    pub policies: Vec<String>,
    /// Seconds.
    pub holds_s: Vec<f64>,
    /// Who follows.
    pub drivers: Vec<Driver>,
    /// ring, native or sumo.
    pub engine: String,
    /// Road of whole drives.
    pub map: String,
    /// How many rings for each case.
    pub rings: usize,
    /// What policies known by name are built from.
    pub settings: PolicySettings,
    /// Where to write.
    pub out: Option<PathBuf>,
    /// Figures of adherence too.
    pub adherence: bool,
}

impl Plan {
    /// From the command line.
    ///
    /// # Errors
    /// A hold is no whole number of steps, or a driver cannot drive on this engine.
    pub fn new(matches: &ArgMatches, config: &TrainConfig) -> Result<Self, CliError> {
        let list = |id: &str| matches.get_many::<String>(id).map(|names| names.cloned().collect::<Vec<_>>());
        let holds_s: Vec<f64> = match matches.get_many::<f64>("holds") {
            Some(holds) => holds.copied().collect(),
            None => vec![config.hold_s],
        };
        for hold_s in &holds_s {
            let changed = TrainConfig { hold_s: *hold_s, hold_max_s: 0.0, ..config.clone() };
            changed.check().map_err(|(_, fault)| CliError::Input(fault))?;
        }
        let engine = matches.get_one::<String>("engine").cloned().unwrap_or_default();
        let drivers = matches.get_many::<Driver>("driver").map(|d| d.cloned().collect::<Vec<_>>());
        let drivers = drivers.unwrap_or_else(|| {
            vec![if engine == "ring" { Driver::Configured } else { Driver::Preset("follow".into()) }]
        });
        if engine != "ring"
            && let Some(other) = drivers.iter().find(|d| !matches!(d, Driver::Preset(_)))
        {
            let text = format!(
                "driver `{}` exists on the fast ring only; whole drives know {}",
                other.name(),
                driver::PRESETS.join(", ")
            );
            return Err(CliError::Input(text));
        }
        let map = matches.get_one::<String>("map").cloned().unwrap_or_default();
        let policies = list("policy").unwrap_or_else(|| policy::NAMES.iter().map(|name| (*name).into()).collect());
        Ok(Self {
            // Tables and figures name the policy that drove.
            policies: policies.iter().map(|name| policy::meant(name, &map)).collect(),
            holds_s,
            drivers,
            engine,
            map,
            rings: matches.get_one::<u32>("over").copied().unwrap_or(20) as usize,
            settings: settings(config, matches.get_one::<f64>("aim").copied().unwrap_or_default()),
            out: matches.get_one::<PathBuf>("out").cloned(),
            adherence: matches.get_flag("adherence"),
        })
    }

    /// Each policy with each hold and each driver.
    pub fn cases(&self) -> Vec<Case> {
        let mut cases = Vec::new();
        for policy in &self.policies {
            for driver in &self.drivers {
                for hold_s in &self.holds_s {
                    cases.push(Case { policy: policy.clone(), hold_s: *hold_s, driver: driver.clone() });
                }
            }
        }
        cases
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drivers_are_read_by_name_and_by_numbers() {
        assert_eq!(driver("guarded"), Ok(Driver::Guarded));
        let numbers = Numbers { reaction_s: 1.0, error_mps: 0.5, ..Numbers::default() };
        assert_eq!(driver("reaction=1,error=0.5"), Ok(Driver::Numbers(numbers)));
        assert!(driver("folow").unwrap_err().starts_with("driver `folow` is unknown; known are exact, guarded"));
        assert_eq!(driver("error=9").unwrap_err(), "error is 9; allowed: 0 to 5");
    }
}
