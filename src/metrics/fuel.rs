//! Fuel of a mid-sized petrol car from its speed and acceleration. In: m/s, m/s2. Out: ml/s. The polynomial of Kamal,
//! Mukai, Murata and Kawabe, "Model predictive control of vehicles on urban roads for improved fuel economy" (IEEE
//! Trans. Control Systems Technology 21, 2013): what cruising takes, and what accelerating adds. Idling takes 0.157 ml/s;
//! braking saves nothing. A relative measure: the same model for all cars and all policies, no measured car of a study.

/// Cruising: 1, v, v^2, v^3.
const CRUISE: [f32; 4] = [0.1569, 2.450e-2, -7.415e-4, 5.975e-5];
/// Accelerating: a, a v, a v^2.
const ACCELERATE: [f32; 3] = [0.07224, 9.681e-2, 1.075e-3];

/// Fuel rate, ml/s.
#[inline(always)]
pub fn rate_ml_s(speed_mps: f32, accel_mps2: f32) -> f32 {
    let v = speed_mps;
    let cruise = CRUISE[0] + v * (CRUISE[1] + v * (CRUISE[2] + v * CRUISE[3]));
    let accelerate = ACCELERATE[0] + v * (ACCELERATE[1] + v * ACCELERATE[2]);
    cruise + accel_mps2.max(0.0) * accelerate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cruise_at_50_kmh_takes_what_cars_take_and_standing_takes_the_idle() {
        let v: f32 = 50.0 / 3.6;
        let litres_per_100_km = rate_ml_s(v, 0.0) / v * 100.0;
        assert!((3.0..5.0).contains(&litres_per_100_km), "{litres_per_100_km}");
        assert_eq!(rate_ml_s(0.0, -2.0), 0.1569);
    }

    #[test]
    fn stop_and_go_takes_more_than_the_same_way_at_an_even_speed() {
        // A sine of 4 +- 4 m/s with a period of 30 s, against 4 m/s.
        let steps = 300;
        let omega = std::f32::consts::TAU / 30.0;
        let wave: f32 = (0..steps)
            .map(|i| {
                let t = i as f32 * 0.1;
                rate_ml_s(4.0 + 4.0 * (omega * t).sin(), 4.0 * omega * (omega * t).cos())
            })
            .sum();
        assert!(wave > 1.5 * steps as f32 * rate_ml_s(4.0, 0.0));
    }
}
