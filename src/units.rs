//! Conversion of speeds: SI inside the program, mph and km/h for people. In: a number with its unit. Out: m/s; and back.

use serde::{Deserialize, Serialize};

/// Metres per second in one mile per hour (exact by definition: 1609.344 m / 3600 s).
pub const MPS_PER_MPH: f64 = 0.447_04;
/// Metres per second in one kilometre per hour.
pub const MPS_PER_KMH: f64 = 1.0 / 3.6;

/// Unit of displayed speeds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SpeedUnit {
    /// Miles per hour, as in HC22.
    #[default]
    Mph,
    /// Kilometres per hour (km/h).
    Kmh,
}

impl SpeedUnit {
    /// Converts from m/s to this unit.
    pub fn from_mps(self, speed_mps: f64) -> f64 {
        speed_mps / self.mps_per_unit()
    }

    /// Converts from this unit to m/s.
    pub fn to_mps(self, speed: f64) -> f64 {
        speed * self.mps_per_unit()
    }

    /// Returns the metres per second in one of this unit.
    pub fn mps_per_unit(self) -> f64 {
        match self {
            Self::Mph => MPS_PER_MPH,
            Self::Kmh => MPS_PER_KMH,
        }
    }

    /// Returns the label of the unit on a dial.
    pub fn label(self) -> &'static str {
        match self {
            Self::Mph => "mph",
            Self::Kmh => "km/h",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_speeds_convert() {
        // docs/references.md: ring: 4.362 m/s is 9.76 mph, 17.88 m/s is 40 mph.
        assert!((SpeedUnit::Mph.from_mps(4.362) - 9.76).abs() < 0.005);
        assert!((SpeedUnit::Mph.to_mps(40.0) - 17.8816).abs() < 1e-12);
        assert!((SpeedUnit::Kmh.from_mps(10.0) - 36.0).abs() < 1e-12);
    }
}
