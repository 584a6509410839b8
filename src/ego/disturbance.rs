//! Disturbances of the ego: loss of power, wind from the side, a slippery road. In: what an event of the scenario does to the car. Out: the share of
//! the friction, and the side force. N, m/s.

/// Side force over dynamic pressure and angle of the air flow, m2/rad: the frontal area of a saloon, 2.2 m2, times a side force coefficient of 0.038 per
/// degree (docs/references.md: side-wind).
const SIDE_AREA_M2_PER_RAD: f64 = 2.2 * 0.038 * 180.0 / std::f64::consts::PI;

/// Angle of the air flow up to which the side force grows with it, radians: 30 degrees.
const MOST_ANGLE_RAD: f64 = std::f64::consts::PI / 6.0;

/// Disturbance of the car, which begins and ends at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// True while the accelerator has no effect.
    pub is_powerless: bool,
    /// Friction of the road as a share of that at other times.
    pub friction: f64,
    /// Depth of the water on the road, mm; `None` is that of the car's parameters.
    pub water_mm: Option<f64>,
    /// Wind across the heading, m/s, positive towards the left.
    pub side_wind_mps: f64,
}

impl Default for Disturbance {
    /// Returns a car that is not disturbed.
    fn default() -> Self {
        Self { is_powerless: false, friction: 1.0, water_mm: None, side_wind_mps: 0.0 }
    }
}

impl Disturbance {
    /// Returns the side force of the wind on a car at this speed, N, positive to the left.
    pub(super) fn side_force_n(&self, air_density_kgm3: f64, speed_mps: f64) -> f64 {
        if self.side_wind_mps == 0.0 {
            return 0.0;
        }
        let angle_rad = self.side_wind_mps.atan2(speed_mps.abs()).clamp(-MOST_ANGLE_RAD, MOST_ANGLE_RAD);
        let flow_mps2 = speed_mps * speed_mps + self.side_wind_mps * self.side_wind_mps;
        0.5 * air_density_kgm3 * SIDE_AREA_M2_PER_RAD * flow_mps2 * angle_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn side_wind_pushes_by_dynamic_pressure_area_and_angle() {
        let wind = |side_wind_mps: f64, speed_mps: f64| {
            Disturbance { side_wind_mps, ..Disturbance::default() }.side_force_n(1.2, speed_mps)
        };
        // By hand: 10 m/s across 30 m/s are 18.43 degrees and 1000 m2/s2: 0.6 x 2.2 x 0.038 x 18.43 x 1000 = 924.7 N.
        assert!((wind(10.0, 30.0) - 924.7).abs() < 0.5, "{}", wind(10.0, 30.0));
        assert_eq!(wind(-10.0, 30.0), -wind(10.0, 30.0));
        // A standing car feels 30 degrees: 0.6 x 2.2 x 0.038 x 30 x 400 = 601.9 N in 20 m/s.
        assert!((wind(20.0, 0.0) - 601.9).abs() < 0.5, "{}", wind(20.0, 0.0));
        assert_eq!((wind(0.0, 30.0), wind(10.0, -30.0)), (0.0, wind(10.0, 30.0)));
    }
}
