//! SI inside, mph and km/h outside. In: what a person typed or is to read. Out: m/s.

use serde::{Deserialize, Serialize};

/// Metres per second in one mile per hour (exact by definition: 1609.344 m / 3600 s).
pub const MPS_PER_MPH: f64 = 0.447_04;
/// Metres per second in one kilometre per hour.
pub const MPS_PER_KMH: f64 = 1.0 / 3.6;

/// The unit in which a driver reads speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SpeedUnit {
    /// Miles per hour, as in HC22.
    #[default]
    Mph,
    /// Kilometres per hour.
    Kmh,
}

impl SpeedUnit {
    /// A speed in m/s as a number of this unit.
    pub fn from_mps(self, speed_mps: f64) -> f64 {
        speed_mps / self.mps_per_unit()
    }

    /// A number of this unit in m/s.
    pub fn to_mps(self, speed: f64) -> f64 {
        speed * self.mps_per_unit()
    }

    /// Metres per second in one of this unit.
    pub fn mps_per_unit(self) -> f64 {
        match self {
            Self::Mph => MPS_PER_MPH,
            Self::Kmh => MPS_PER_KMH,
        }
    }

    /// As written on a dial.
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
    fn the_fields_own_figures_convert() {
        // docs/references.md: ring: 4.362 m/s is 9.76 mph, 17.88 m/s is 40 mph.
        assert!((SpeedUnit::Mph.from_mps(4.362) - 9.76).abs() < 0.005);
        assert!((SpeedUnit::Mph.to_mps(40.0) - 17.8816).abs() < 1e-12);
        assert!((SpeedUnit::Kmh.from_mps(10.0) - 36.0).abs() < 1e-12);
    }
}
