//! Choice of the traffic, as a user writes it: `sumo`, `native`, or a file of trajectories.

use crate::toml_text::did_you_mean;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{fmt, path::Path, str::FromStr};

/// A traffic engine by name, or the native engine with the vehicles of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(into = "String", try_from = "String")]
#[schemars(with = "String")]
pub enum EngineChoice {
    /// SUMO, in this process.
    #[default]
    Sumo,
    /// Native engine, without SUMO.
    Native,
    /// Native engine on an open lane, with vehicles that drive as in this file of trajectories.
    Log(String),
}

/// Names of the engines.
const NAMES: [&str; 2] = ["sumo", "native"];

/// Text that names neither an engine nor a file of trajectories.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "traffic is \"{0}\"{near}; allowed: sumo, native, or a file of trajectories (.csv, .csv.gz)",
    near = did_you_mean(.0, &NAMES)
)]
pub struct UnknownEngine(pub String);

impl EngineChoice {
    /// Returns the file of trajectories; `None` for an engine alone.
    pub fn log_file(&self) -> Option<&Path> {
        match self {
            Self::Log(file) => Some(Path::new(file)),
            Self::Sumo | Self::Native => None,
        }
    }

    /// Returns the same traffic for a process that may not run SUMO: the native engine in its place.
    #[must_use]
    pub fn without_sumo(&self) -> Self {
        match self {
            Self::Log(file) => Self::Log(file.clone()),
            Self::Sumo | Self::Native => Self::Native,
        }
    }

    /// Returns true if a text is the path of a file of trajectories.
    pub fn is_log(text: &str) -> bool {
        [".csv", ".csv.gz"].iter().any(|end| text.ends_with(end))
    }
}

impl FromStr for EngineChoice {
    type Err = UnknownEngine;

    fn from_str(text: &str) -> Result<Self, UnknownEngine> {
        match text {
            "sumo" => Ok(Self::Sumo),
            "native" => Ok(Self::Native),
            file if Self::is_log(file) => Ok(Self::Log(file.to_owned())),
            _ => Err(UnknownEngine(text.to_owned())),
        }
    }
}

impl TryFrom<String> for EngineChoice {
    type Error = UnknownEngine;

    fn try_from(text: String) -> Result<Self, UnknownEngine> {
        text.parse()
    }
}

impl From<EngineChoice> for String {
    fn from(choice: EngineChoice) -> Self {
        choice.to_string()
    }
}

impl fmt::Display for EngineChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Sumo => "sumo",
            Self::Native => "native",
            Self::Log(file) => file,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_survives_the_way_to_text_and_back() {
        for text in ["sumo", "native", "logs/leader.csv", "platoon.csv.gz"] {
            let choice: EngineChoice = text.parse().unwrap();
            assert_eq!(choice.to_string(), text);
            assert_eq!(serde_json::to_string(&choice).unwrap(), format!("\"{text}\""));
        }
    }

    #[test]
    fn an_unknown_engine_is_refused_with_the_nearest_and_with_what_is_allowed() {
        let message = |text: &str| text.parse::<EngineChoice>().unwrap_err().to_string();
        assert_eq!(
            message("natvie"),
            "traffic is \"natvie\" (did you mean native?); allowed: sumo, native, or a file of trajectories (.csv, .csv.gz)"
        );
        for text in ["", "SUMO", "native ", "localhost:8813", "leader.xlsx"] {
            assert!(message(text).contains(&format!("\"{text}\"")), "{}", message(text));
        }
    }
}
