//! Choices of display settings. In: nothing. Out: the visible parts of the own car, the speedometer's colours, and the quality of the
//! picture.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Visible parts of the own vehicle in the driver's view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CockpitView {
    /// Nothing of the own vehicle
    Off,
    /// Bonnet and scuttle: for a rig with its own steering wheel and dashboard
    #[default]
    Bonnet,
    /// Also dashboard with instruments, pillars, three mirrors and a turning steering wheel: for a screen without a wheel in front of it
    Full,
}

/// Guidance along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum GuidanceView {
    /// None
    Off,
    /// Next turn and the distance to it on the speedometer, from 2 km on
    #[default]
    Dial,
    /// Also a blue line on the road, along the whole path
    Road,
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

/// Quality of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum QualityLevel {
    /// Low with software rendering, high on a dedicated graphics card, medium elsewhere
    #[default]
    Auto,
    /// For software rendering and old laptops
    Low,
    /// For ordinary computers
    Medium,
    /// For the rig's graphics card
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
