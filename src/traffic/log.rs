//! Vehicles that drive as a file of trajectories says, whatever others do. In: positions and speeds at even steps. Out: position and speed
//! at any time. Metres, m/s, seconds.

/// Vehicle of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedVehicle {
    /// Name of the vehicle in the file.
    pub name: String,
    /// Front bumper along the lane at each step, m.
    pub s_m: Vec<f64>,
    /// Speed at each step, m/s.
    pub speed_mps: Vec<f64>,
}

/// Vehicles of a log, the nearest ahead of the ego first, each with as many steps.
#[derive(Clone, Debug, PartialEq)]
pub struct TrafficLog {
    step_s: f64,
    vehicles: Vec<LoggedVehicle>,
}

impl TrafficLog {
    /// Creates a log with steps of `step_s`. Every vehicle has at least two steps, and all have as many.
    pub fn new(step_s: f64, vehicles: Vec<LoggedVehicle>) -> Self {
        Self { step_s, vehicles }
    }

    /// Returns the vehicles, the nearest ahead of the ego first.
    pub fn vehicles(&self) -> &[LoggedVehicle] {
        &self.vehicles
    }

    /// Returns the time of the last step, s since the first.
    pub fn length_s(&self) -> f64 {
        let steps = self.vehicles.first().map_or(0, |vehicle| vehicle.s_m.len().saturating_sub(1));
        steps as f64 * self.step_s
    }

    /// Returns the log with all vehicles moved along the lane.
    #[must_use]
    pub fn moved(mut self, by_m: f64) -> Self {
        self.vehicles.iter_mut().flat_map(|vehicle| &mut vehicle.s_m).for_each(|s_m| *s_m += by_m);
        self
    }

    /// Returns position, m, and speed, m/s, of a vehicle at a time since the first step. Between two steps the speed is linear and the
    /// position its integral; a difference of the positions that the speeds do not explain is spread evenly. After the last step the
    /// vehicle keeps its speed.
    pub fn at(&self, vehicle: usize, time_s: f64) -> (f64, f64) {
        let LoggedVehicle { s_m, speed_mps, .. } = &self.vehicles[vehicle];
        let (h, last) = (self.step_s, s_m.len() - 1);
        // A time that is a step up to rounding is that step.
        let steps = time_s / h;
        let steps = if (steps - steps.round()).abs() < 1e-6 { steps.round() } else { steps };
        let k = (steps.max(0.0) as usize).min(last);
        let past_s = (steps - k as f64).max(0.0) * h;
        if k == last {
            return (s_m[last] + speed_mps[last] * past_s, speed_mps[last]);
        }
        if past_s == 0.0 {
            return (s_m[k], speed_mps[k]);
        }
        let [from_mps, to_mps] = [speed_mps[k], speed_mps[k + 1]];
        let unexplained_m = s_m[k + 1] - s_m[k] - (from_mps + to_mps) / 2.0 * h;
        let accel_mps2 = (to_mps - from_mps) / h;
        let way_m = from_mps * past_s + accel_mps2 * past_s * past_s / 2.0 + unexplained_m * past_s / h;
        (s_m[k] + way_m, from_mps + accel_mps2 * past_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(step_s: f64, s_m: &[f64], speed_mps: &[f64]) -> TrafficLog {
        let vehicle = LoggedVehicle { name: "1".into(), s_m: s_m.into(), speed_mps: speed_mps.into() };
        TrafficLog::new(step_s, vec![vehicle])
    }

    #[test]
    fn a_ramp_of_speed_gives_a_parabola_between_the_steps() {
        // v = 10 + 0.5 t, so s = 10 t + 0.25 t^2; steps of 1 s.
        let s_m: Vec<f64> = (0..=20).map(|k| 10.0 * f64::from(k) + 0.25 * f64::from(k * k)).collect();
        let speed_mps: Vec<f64> = (0..=20).map(|k| 10.0 + 0.5 * f64::from(k)).collect();
        let log = of(1.0, &s_m, &speed_mps);
        for t in [0.0, 0.1, 3.3, 7.0, 19.95, 20.0] {
            let (at_m, at_mps) = log.at(0, t);
            assert!((at_m - (10.0 * t + 0.25 * t * t)).abs() < 1e-9, "{t}: {at_m}");
            assert!((at_mps - (10.0 + 0.5 * t)).abs() < 1e-9, "{t}: {at_mps}");
        }
        // After the end of the log at 20 m/s.
        assert_eq!(log.at(0, 21.0), (320.0, 20.0));
        assert_eq!(log.length_s(), 20.0);
    }

    #[test]
    fn positions_that_the_speeds_do_not_explain_are_kept_at_the_steps() {
        // Positions of a sensor 0.3 m off the integral of the speeds.
        let log = of(0.5, &[0.0, 5.3, 10.0], &[10.0, 10.0, 10.0]);
        assert_eq!([0.0, 0.5, 1.0].map(|t| log.at(0, t).0), [0.0, 5.3, 10.0]);
        assert!((log.at(0, 0.25).0 - 2.65).abs() < 1e-12);
        assert_eq!(log.moved(7.0).at(0, 0.5), (12.3, 10.0));
    }
}
