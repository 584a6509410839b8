//! Sound levels as settings. In: levels in decibels. Out: factors of amplitude. 0 dB is the program's own balance; [`SILENT_DB`] and below
//! is silence.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Lowest level, dB: silence.
pub const SILENT_DB: f64 = -60.0;

/// Levels of all sounds, dB.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SoundLevels {
    /// All sounds together; -60 is silence
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub master_db: f64,
    /// Engine of the own vehicle
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub engine_db: f64,
    /// Tyres of the own vehicle on road and grass
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub road_db: f64,
    /// Air around the own vehicle, and rain on it
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub wind_db: f64,
    /// Other vehicles near the own vehicle
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub others_db: f64,
    /// Horn and contacts of the own vehicle
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub horn_db: f64,
    /// Tone for new advice, if the scenario has one, and spoken guidance
    #[schemars(range(min = -60.0, max = 12.0), extend("unit" = "dB"))]
    pub tone_db: f64,
}

/// Returns the amplitude factor of a level in dB; 0 at [`SILENT_DB`] and below.
pub fn gain(level_db: f64) -> f32 {
    if level_db <= SILENT_DB { 0.0 } else { 10f64.powf(level_db / 20.0) as f32 }
}

impl SoundLevels {
    /// Returns the amplitude factor of spoken guidance.
    pub fn speech_gain(&self) -> f32 {
        gain(self.master_db) * gain(self.tone_db)
    }
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
