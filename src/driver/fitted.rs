//! File of drivers fitted to participants (`drivers.toml`). In: TOML from `codrive analyse` or from a person. Out:
//! [`DriversFile`], or a message that names file, line, value and the allowed values. A number that could not be
//! estimated is absent.

use super::DriverParams;
use crate::{
    file::{SETTINGS_BYTES, read_text},
    idm::IdmParams,
    toml_text::{self, KeyPart},
};
use serde::{Deserialize, Serialize};
use std::{fmt::Write, path::Path};

/// Format name in the first line of the file.
pub const FORMAT: &str = "codrive drivers 1";

/// Reaction time to the leader over that to advice, as in the presets: people respond to brake lamps sooner than to a
/// dial.
const LEADER_SHARE: f64 = 0.7;

/// Error in a file of drivers; the message is complete.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct DriversFileError(pub String);

/// Estimated numbers of one driver.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FittedDriver {
    /// Code of the participant whose drives the numbers rest on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub participant: Option<String>,
    /// Time from a change of the advice to the foot's first movement, s.
    pub reaction_s: Option<f64>,
    /// Standard deviation of the speed around the advised one, m/s.
    pub error_mps: Option<f64>,
    /// Constant deviation from the advised speed, m/s, positive for faster.
    pub speed_bias_mps: Option<f64>,
    /// Desired time gap to the leader as a multiple of the other vehicles'.
    pub time_gap_factor: Option<f64>,
}

/// Drivers of one study.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriversFile {
    /// Format of the file, always [`FORMAT`].
    pub format: String,
    /// Title of the study of the drivers.
    #[serde(default)]
    pub study: String,
    /// Drivers in the order of the file.
    #[serde(default)]
    pub driver: Vec<FittedDriver>,
}

impl FittedDriver {
    /// Returns names, values, limits and units of the numbers. The limits are as for the simulated driver; the time gap
    /// has a range that every IDM supports.
    fn numbers(&self) -> [(&'static str, Option<f64>, [f64; 2], &'static str); 4] {
        [
            ("reaction_s", self.reaction_s, [0.0, 5.0], " s"),
            ("error_mps", self.error_mps, [0.0, 5.0], " m/s"),
            ("speed_bias_mps", self.speed_bias_mps, [-10.0, 10.0], " m/s"),
            ("time_gap_factor", self.time_gap_factor, [0.2, 5.0], ""),
        ]
    }

    /// Returns a driver with the known numbers, and the numbers of `base` elsewhere; `usual_time_gap_s` is the other
    /// vehicles' time gap.
    pub fn applied_to(&self, base: &DriverParams, usual_time_gap_s: f64) -> DriverParams {
        let time_gap_s = self.time_gap_factor.map_or(base.idm.t, |factor| factor * usual_time_gap_s);
        DriverParams {
            reaction_s: self.reaction_s.unwrap_or(base.reaction_s),
            leader_reaction_s: self.reaction_s.map_or(base.leader_reaction_s, |reaction_s| LEADER_SHARE * reaction_s),
            error_mps: self.error_mps.unwrap_or(base.error_mps),
            speed_bias_mps: self.speed_bias_mps.unwrap_or(base.speed_bias_mps),
            idm: IdmParams { t: time_gap_s, ..base.idm },
            ..base.clone()
        }
    }
}

impl DriversFile {
    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read or is invalid; the message gives the place and the allowed values.
    pub fn load(path: &Path) -> Result<Self, DriversFileError> {
        let text = read_text(path, SETTINGS_BYTES).map_err(|why| {
            DriversFileError(format!(
                "{}: cannot be read: {why}{}\n  remedy: name the drivers.toml that `codrive analyse` wrote for a study's folder",
                path.display(),
                toml_text::did_you_mean_file(path)
            ))
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Reads the text of a file; `name` is its name for messages.
    ///
    /// # Errors
    /// The text is invalid; the message gives the place and the allowed values.
    pub fn parse(text: &str, name: &str) -> Result<Self, DriversFileError> {
        let (file, mut mistakes) = toml_text::read::<Self>(text, name);
        if let Some(file) = &file {
            let mut add = |key: &str, message: &str| mistakes.add(key, KeyPart::Value, message);
            if file.format != FORMAT {
                add("format", &format!("format is {:?}; allowed: {FORMAT:?}", file.format));
            }
            if file.driver.is_empty() {
                add("format", "there is no [[driver]]; allowed: one or more");
            }
            for (i, driver) in file.driver.iter().enumerate() {
                for (key, value, [low, high], unit) in driver.numbers() {
                    if let Some(value) = value.filter(|value| !(low..=high).contains(value)) {
                        let message = format!("{key} is {value}; allowed: a number from {low} to {high}{unit}");
                        add(&format!("driver.{i}.{key}"), &message);
                    }
                }
            }
        }
        toml_text::finished((file, mistakes)).map_err(|e| DriversFileError(e.to_string()))
    }

    /// Returns the text of the file. Numbers are rounded to 0.001, which is finer than any estimate.
    pub fn text(&self) -> String {
        let quoted = |word: &str| toml::Value::String(word.into()).to_string();
        let mut text = format!("format = {}\nstudy = {}\n", quoted(&self.format), quoted(&self.study));
        for driver in &self.driver {
            text.push_str("\n[[driver]]\n");
            if let Some(participant) = &driver.participant {
                let _ = writeln!(text, "participant = {}", quoted(participant));
            }
            for (key, value, ..) in driver.numbers() {
                if let Some(value) = value {
                    // Adding 0 avoids "-0".
                    let _ = writeln!(text, "{key} = {:?}", (value * 1e3).round() / 1e3 + 0.0);
                }
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> String {
        DriversFile::parse(text, "drivers.toml").unwrap_err().to_string()
    }

    #[test]
    fn a_written_file_reads_back_and_missing_numbers_stay_unknown() {
        let driver = FittedDriver {
            participant: Some("sub-P03".into()),
            reaction_s: Some(1.234),
            speed_bias_mps: Some(-0.25),
            ..FittedDriver::default()
        };
        let file = DriversFile {
            format: FORMAT.into(),
            study: "A \"quoted\" study".into(),
            driver: vec![driver.clone(), FittedDriver { time_gap_factor: Some(1.5), ..FittedDriver::default() }],
        };
        let text = file.text();
        assert!(text.starts_with("format = \"codrive drivers 1\"\n") && !text.contains("error_mps"), "{text}");
        assert_eq!(DriversFile::parse(&text, "drivers.toml"), Ok(file));
        let base = DriverParams::default();
        let applied = driver.applied_to(&base, 1.4);
        assert_eq!((applied.reaction_s, applied.speed_bias_mps), (1.234, -0.25));
        assert!((applied.leader_reaction_s - 0.7 * 1.234).abs() < 1e-12);
        assert_eq!((applied.error_mps, applied.idm), (base.error_mps, base.idm), "what is unknown is as it was");
        let wide = FittedDriver { time_gap_factor: Some(1.5), ..FittedDriver::default() };
        assert!((wide.applied_to(&base, 1.4).idm.t - 2.1).abs() < 1e-12);
    }

    #[test]
    fn an_error_names_line_value_and_allowed_values() {
        let head = "format = \"codrive drivers 1\"\n";
        let far = fault(&format!("{head}[[driver]]\nreaction_s = 0.9\n[[driver]]\nreaction_s = 7\n"));
        assert!(far.starts_with("drivers.toml:5:14: reaction_s is 7; allowed: a number from 0 to 5 s"), "{far}");
        let none = fault(&format!("{head}[[driver]]\nspeed_bias_mps = nan\n"));
        assert!(none.contains(":3:") && none.contains("speed_bias_mps is NaN"), "{none}");
        let key = fault(&format!("{head}[[driver]]\nreaction = 1.0\n"));
        assert!(key.contains(":3:1: unknown key `reaction`; did you mean `reaction_s`?"), "{key}");
        let format = fault("format = \"codrive controller 1\"\n[[driver]]\n");
        assert!(format.contains("format is \"codrive controller 1\"; allowed: \"codrive drivers 1\""), "{format}");
        assert!(fault(head).contains("there is no [[driver]]"));
        let missing = DriversFile::load(Path::new("/nowhere/drivers.toml")).unwrap_err().to_string();
        assert!(
            missing.starts_with("/nowhere/drivers.toml: cannot be read") && missing.contains("remedy"),
            "{missing}"
        );
    }
}
