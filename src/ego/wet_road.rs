//! Grip of a wet road. In: the intensity of rain; depth of the water and speed. Out: that depth; the friction coefficient as a share of that on a
//! dry road. Sources: docs/references.md: rain.

use super::table::interpolated;

/// Depth of the water where only the texture of the asphalt is wet, mm, the least that measurements of grip state.
const WET_MM: f64 = 0.2;
/// Road of the depth: mean depth of its texture, mm, way of the water to the edge, m, and crossfall.
const TEXTURE_MM: f64 = 0.5;
const DRAINAGE_M: f64 = 5.5;
const CROSSFALL: f64 = 0.02;

/// Friction coefficients of new tyres on asphalt by the depth of the water, mm, at [`SPEEDS_MPS`].
const FRICTION: [(f64, [f64; 3]); 4] =
    [(0.0, [0.85, 0.80, 0.75]), (0.2, [0.65, 0.60, 0.55]), (1.0, [0.55, 0.30, 0.20]), (2.0, [0.50, 0.05, 0.0])];
/// Speeds of these coefficients: 50, 90 and 130 km/h.
const SPEEDS_MPS: [f64; 3] = [50.0 / 3.6, 90.0 / 3.6, 130.0 / 3.6];

/// Returns the depth of the water over the texture of a road in rain, mm, after Gallaway.
pub fn water_mm(rain_mmph: f64) -> f64 {
    if rain_mmph <= 0.0 {
        return 0.0;
    }
    let flowing = 0.01485 * TEXTURE_MM.powf(0.11) * DRAINAGE_M.powf(0.43) * rain_mmph.powf(0.59) / CROSSFALL.powf(0.42);
    (flowing - TEXTURE_MM).max(WET_MM)
}

/// Returns the friction coefficient of a tyre on asphalt under water as a share of that on dry asphalt.
pub(super) fn share_of_dry(water_mm: f64, speed_mps: f64) -> f64 {
    if water_mm == 0.0 {
        return 1.0;
    }
    let share_at_speed = |friction: [f64; 3]| {
        let shares: [_; 3] = std::array::from_fn(|k| (SPEEDS_MPS[k], friction[k] / FRICTION[0].1[k]));
        interpolated(&shares, speed_mps.abs())
    };
    interpolated(&FRICTION.map(|(depth_mm, friction)| (depth_mm, share_at_speed(friction))), water_mm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grip_on_a_wet_road_is_that_of_the_handbooks_table() {
        // Automotive handbook of Bosch, "Coefficients of static friction for pneumatic tires" (docs/references.md: rain).
        for (water_mm, kmh, wet, dry) in [
            (0.2, 50.0, 0.65, 0.85),
            (0.2, 130.0, 0.55, 0.75),
            (1.0, 50.0, 0.55, 0.85),
            (1.0, 90.0, 0.30, 0.80),
            (2.0, 90.0, 0.05, 0.80),
        ] {
            let share = share_of_dry(water_mm, kmh / 3.6);
            assert!((share - wet / dry).abs() < 1e-9, "{water_mm} mm, {kmh} km/h: {share}");
        }
        assert_eq!(share_of_dry(0.0, 30.0), 1.0);
        // Halfway between 0.2 and 1 mm at 90 km/h.
        assert!((share_of_dry(0.6, 25.0) - (0.60 + 0.30) / 2.0 / 0.80).abs() < 1e-9);
        assert_eq!(share_of_dry(0.5, 3.0), share_of_dry(0.5, 50.0 / 3.6), "slower than the table");
        assert_eq!(share_of_dry(5.0, 60.0), 0.0, "deeper and faster than the table: the tyre floats");
    }

    #[test]
    fn water_gathers_with_the_intensity_of_the_rain() {
        assert_eq!(water_mm(0.0), 0.0);
        assert_eq!(water_mm(2.0), WET_MM, "the texture holds the water of light rain");
        // By hand: 0.01485 x 0.5^0.11 x 5.5^0.43 x 50^0.59 / 0.02^0.42 - 0.5 = 0.99.
        assert!((water_mm(50.0) - 0.99).abs() < 0.02, "{}", water_mm(50.0));
    }
}
