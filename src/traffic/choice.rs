//! Choice of the traffic engine, as a user writes it: `sumo`, `native` or `HOST:PORT`.

use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};

/// A traffic engine by name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String")]
pub enum EngineChoice {
    /// SUMO in this process.
    #[default]
    Sumo,
    /// The native IDM ring.
    Native,
    /// Remote SUMO that listens (`sumo -n NET --remote-port PORT`).
    Remote {
        /// Name or address of its machine.
        host: String,
        /// Port given by its `--remote-port`.
        port: u16,
    },
}

/// Text that names no engine.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown traffic engine \"{0}\"{near}: allowed are sumo, native, or HOST:PORT of a SUMO that listens (localhost:8813)",
    near = crate::toml_text::did_you_mean(.0, &["sumo", "native"])
)]
pub struct UnknownEngine(pub String);

impl EngineChoice {
    /// Returns the local engine that moves vehicles as this remote one does, for a remote that may no longer run; `None` for a local
    /// engine.
    pub fn stand_in(&self) -> Option<Self> {
        matches!(self, Self::Remote { .. }).then_some(Self::Sumo)
    }
}

impl FromStr for EngineChoice {
    type Err = UnknownEngine;

    fn from_str(text: &str) -> Result<Self, UnknownEngine> {
        let unknown = || UnknownEngine(text.to_string());
        match text {
            "sumo" => Ok(Self::Sumo),
            "native" => Ok(Self::Native),
            _ => {
                let (host, port) = text.rsplit_once(':').ok_or_else(unknown)?;
                let host = host.trim_start_matches('[').trim_end_matches(']');
                match port.parse() {
                    Ok(port) if port > 0 && !host.is_empty() => Ok(Self::Remote { host: host.to_string(), port }),
                    _ => Err(unknown()),
                }
            }
        }
    }
}

impl fmt::Display for EngineChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sumo => f.write_str("sumo"),
            Self::Native => f.write_str("native"),
            Self::Remote { host, port } if host.contains(':') => write!(f, "[{host}]:{port}"),
            Self::Remote { host, port } => write!(f, "{host}:{port}"),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_survives_the_way_to_text_and_back() {
        for text in ["sumo", "native", "localhost:8813", "10.0.0.7:1", "[::1]:65535"] {
            let choice: EngineChoice = text.parse().unwrap();
            assert_eq!(choice.to_string(), text);
            let json = serde_json::to_string(&choice).unwrap();
            assert_eq!(json, format!("\"{text}\""));
            assert_eq!(serde_json::from_str::<EngineChoice>(&json).unwrap(), choice);
        }
    }

    #[test]
    fn a_misspelt_engine_is_answered_with_the_one_that_was_meant() {
        let message = "natvie".parse::<EngineChoice>().unwrap_err().to_string();
        assert!(message.contains("\"natvie\" (did you mean native?): allowed are"), "{message}");
    }

    #[test]
    fn an_unknown_engine_is_refused_with_what_is_allowed() {
        for text in ["", "SUMO", "native ", "host:", ":8813", "host:0", "host:70000", "host:x"] {
            let message = text.parse::<EngineChoice>().unwrap_err().to_string();
            assert!(
                message.contains(&format!("\"{text}\"")) && message.contains("sumo, native, or HOST:PORT"),
                "{message}"
            );
        }
    }
}
