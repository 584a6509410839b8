//! Fuel of petrol cars from their speeds and accelerations, by two models, on the flat. In: m/s, m/s2. Out: ml/s, l/100 km.
//!
//! * [`rate_ml_s`]: the polynomial of Kamal, Mukai, Murata and Kawabe, "Model predictive control of vehicles on urban roads for
//!   improved fuel economy" (IEEE Trans. Control Systems Technology 21, 2013): a term for cruising and one for accelerating.
//!   Idling uses 0.157 ml/s; braking saves nothing. It evaluates policies.
//! * [`sumo_rate_ml_s`]: SUMO's model, so that recordings of every engine compare with SUMO's outputs: its default for
//!   passenger cars, `HBEFA4/PC_petrol_Euro-4` of 1500 kg (HBEFA 4.2 as fitted by SUMO 1.28; docs/references.md). A car in gear
//!   that slows down by more than coasting uses nothing; idling uses 0.665 ml/s. `tests/traffic/fuel.rs` compares it with
//!   SUMO's program.
//!
//! The models may differ in sign. By Kamal's polynomial a wave uses more than the same distance at constant speed; by SUMO's
//! model it uses less at 4 m/s, because an idling engine costs more than accelerations do, and braking saves that. Neither
//! model was fitted to the car of a study.

/// Coefficients of cruising: 1, v, v^2, v^3; ml/s.
const CRUISE: [f32; 4] = [0.1569, 2.450e-2, -7.415e-4, 5.975e-5];
/// Coefficients of accelerating: a, a v, a v^2; ml/s.
const ACCELERATE: [f32; 3] = [0.07224, 9.681e-2, 1.075e-3];

/// Returns the fuel rate by the model of Kamal et al., ml/s.
#[inline(always)]
pub fn rate_ml_s(speed_mps: f32, accel_mps2: f32) -> f32 {
    let v = speed_mps;
    let cruise = CRUISE[0] + v * (CRUISE[1] + v * (CRUISE[2] + v * CRUISE[3]));
    let accelerate = ACCELERATE[0] + v * (ACCELERATE[1] + v * ACCELERATE[2]);
    cruise + accel_mps2.max(0.0) * accelerate
}

/// Coefficients of SUMO's model without acceleration: 1, v, v^3 (v^2 has none); mg/s.
const SUMO_CRUISE: [f32; 3] = [493.1, 5.054, 0.03887];
/// Coefficients of SUMO's model with acceleration: a, a v, a v^2; mg/s.
const SUMO_ACCELERATE: [f32; 3] = [225.3, 42.96, 1.113];
/// Speed up to which the engine idles however hard the car brakes, m/s.
const SUMO_IDLES_BELOW_MPS: f32 = 0.5;
/// Deceleration of a coasting car: a constant, m/s2, and an increase per speed, 1/s.
const SUMO_COASTING: [f32; 2] = [0.107_948_26, 0.012_976_641];
/// Speed below which the coasting deceleration is proportional to the speed, m/s (10 km/h).
const SUMO_LINE_FROM_MPS: f32 = 10.0 / 3.6;
/// Density of petrol in SUMO, mg/ml.
const SUMO_DENSITY_MG_ML: f32 = 742.0;

/// Returns the fuel rate by SUMO's emission model, ml/s.
#[inline]
pub fn sumo_rate_ml_s(speed_mps: f32, accel_mps2: f32) -> f32 {
    let (v, a) = (speed_mps, accel_mps2);
    let line = v.max(SUMO_LINE_FROM_MPS);
    let coasting_mps2 = -(SUMO_COASTING[0] + SUMO_COASTING[1] * line) * (v / line);
    let cruise = SUMO_CRUISE[0] + v * (SUMO_CRUISE[1] + v * v * SUMO_CRUISE[2]);
    let accelerate = a * (SUMO_ACCELERATE[0] + v * (SUMO_ACCELERATE[1] + v * SUMO_ACCELERATE[2]));
    let burns = v <= SUMO_IDLES_BELOW_MPS || a >= coasting_mps2;
    if burns { (cruise + accelerate).max(0.0) / SUMO_DENSITY_MG_ML } else { 0.0 }
}

/// Fuel of some vehicles by SUMO's model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SumoFuelTotals {
    before_mps: Vec<f32>,
    fuel_ml: f64,
    way_m: f64,
}

impl SumoFuelTotals {
    /// Adds a step of `step_s`: speeds of the vehicles in a fixed order. A vehicle seen first has no acceleration.
    pub fn add(&mut self, speeds_mps: impl Iterator<Item = f32>, step_s: f64) {
        for (k, speed_mps) in speeds_mps.enumerate() {
            if k == self.before_mps.len() {
                self.before_mps.push(speed_mps);
            }
            let accel_mps2 = (speed_mps - self.before_mps[k]) / step_s as f32;
            self.before_mps[k] = speed_mps;
            self.fuel_ml += f64::from(sumo_rate_ml_s(speed_mps, accel_mps2)) * step_s;
            self.way_m += f64::from(speed_mps) * step_s;
        }
    }

    /// Returns the fuel per 100 km of a vehicle, litres; `None` if no vehicle moved.
    pub fn l_100km(&self) -> Option<f64> {
        // 1 ml/m is 100 l per 100 km.
        (self.way_m > 0.0).then(|| self.fuel_ml / self.way_m * 100.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cruise_at_50_kmh_uses_3_to_5_l_per_100_km_and_standing_idles() {
        let v: f32 = 50.0 / 3.6;
        let litres_per_100_km = rate_ml_s(v, 0.0) / v * 100.0;
        assert!((3.0..5.0).contains(&litres_per_100_km), "{litres_per_100_km}");
        assert_eq!(rate_ml_s(0.0, -2.0), 0.1569);
    }

    /// Returns the fuel of a sine of 4 +- 4 m/s with a period of 30 s, relative to a constant 4 m/s.
    fn wave_over_even(rate_ml_s: impl Fn(f32, f32) -> f32) -> f32 {
        let steps = 300;
        let omega = std::f32::consts::TAU / 30.0;
        let wave = (0..steps).map(|i| {
            let t = i as f32 * 0.1;
            rate_ml_s(4.0 + 4.0 * (omega * t).sin(), 4.0 * omega * (omega * t).cos())
        });
        wave.sum::<f32>() / (steps as f32 * rate_ml_s(4.0, 0.0))
    }

    #[test]
    fn stop_and_go_uses_more_than_even_speed_except_by_sumos_model() {
        assert!(wave_over_even(rate_ml_s) > 1.5);
        // SUMO's emissionsDrivingCycle gives 0.8306.
        let by_sumo = wave_over_even(sumo_rate_ml_s);
        assert!((by_sumo - 0.8306).abs() < 0.001, "{by_sumo}");
    }

    #[test]
    fn totals_by_sumos_model_match_its_program() {
        // emissionsDrivingCycle at a steady 10 m/s prints 582.51 mg/s: 0.78505 ml/s at 742 g/l, 7.8505 l / 100 km.
        let mut totals = SumoFuelTotals::default();
        assert_eq!(totals.l_100km(), None);
        for _ in 0..100 {
            totals.add([10.0, 10.0].into_iter(), 0.1);
        }
        assert!((totals.l_100km().unwrap() - 7.8505).abs() < 1e-4, "{totals:?}");
        // Braking from 10 to 8 m/s uses nothing, on 8 m.
        let mut totals = SumoFuelTotals::default();
        totals.add([10.0].into_iter(), 1.0);
        totals.add([8.0].into_iter(), 1.0);
        assert!((totals.l_100km().unwrap() - 0.78505 / 18.0 * 100.0).abs() < 1e-4, "{totals:?}");
    }
}
