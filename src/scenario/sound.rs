//! Sound levels, as settings. In: decibels that a person sets. Out: factors. 0 dB is the balance as it was made; from
//! [`SILENT_DB`] down there is nothing.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The lowest level, which is none at all.
pub const SILENT_DB: f64 = -60.0;

/// Levels of all sounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SoundLevels {
    /// All sounds together; -60 is silence
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub master_db: f64,
    /// Own engine
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub engine_db: f64,
    /// Own tyres on road and grass
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub road_db: f64,
    /// Air around the own car
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub wind_db: f64,
    /// Other cars near by
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub others_db: f64,
    /// Own horn and contacts
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub horn_db: f64,
    /// Tone at a changed advice, where the scenario has one
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub tone_db: f64,
}

/// Amplitude of a level.
pub fn gain(level_db: f64) -> f32 {
    if level_db <= SILENT_DB { 0.0 } else { 10f64.powf(level_db / 20.0) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_decibels_are_twice_the_amplitude_and_the_lowest_level_is_silence() {
        assert!((gain(6.0206) - 2.0).abs() < 1e-3);
        assert_eq!((gain(0.0), gain(SILENT_DB)), (1.0, 0.0));
    }
}
