//! Words that settings of the picture choose from. In: nothing. Out: what is drawn of the own car, the speedometer's colours, the
//! effort put into the picture.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
