//! Choice of the traffic engine, as a user writes it: `sumo` or `native`.

use crate::toml_text::did_you_mean;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};

/// A traffic engine by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EngineChoice {
    /// SUMO, in this process
    #[default]
    Sumo,
    /// The built-in IDM ring, without SUMO
    Native,
}

/// Text that names no engine.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown traffic engine \"{0}\"{near}: allowed are sumo, native", near = did_you_mean(.0, &["sumo", "native"]))]
pub struct UnknownEngine(pub String);

impl FromStr for EngineChoice {
    type Err = UnknownEngine;

    fn from_str(text: &str) -> Result<Self, UnknownEngine> {
        match text {
            "sumo" => Ok(Self::Sumo),
            "native" => Ok(Self::Native),
            _ => Err(UnknownEngine(text.to_owned())),
        }
    }
}

impl fmt::Display for EngineChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Sumo => "sumo",
            Self::Native => "native",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_survives_the_way_to_text_and_back() {
        for text in ["sumo", "native"] {
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
            "unknown traffic engine \"natvie\" (did you mean native?): allowed are sumo, native"
        );
        for text in ["", "SUMO", "native ", "localhost:8813"] {
            assert!(message(text).contains(&format!("\"{text}\"")), "{}", message(text));
        }
    }
}
