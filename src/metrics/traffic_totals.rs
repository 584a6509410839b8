//! Sums over the speeds of all vehicles, step by step. In: numbers and speeds of the vehicles present at each step, since they may
//! enter and leave. Out: means, deviations, fuel, stops and hard brakings. Evaluations and recordings use the same sums. SI units.

use super::{fuel, motion_phases::MotionPhase};

/// Standard deviation of speed over the vehicles at which a wave begins, m/s; below it traffic is calm (docs/references.md:
/// advice).
const CALM_SD_MPS: f64 = 0.5;

/// Sums over the speeds of one vehicle.
#[derive(Clone, Debug)]
struct VehicleTotals {
    id: u32,
    steps: u64,
    sum_mps: f64,
    square: f64,
    phase: MotionPhase,
    /// Number of the last step in which the vehicle was present.
    last_step: u64,
}

/// Sums over the speeds of all vehicles; memory grows with the number of vehicles, not with the time.
#[derive(Clone, Debug, Default)]
pub struct TrafficTotals {
    step_s: f64,
    steps: u64,
    /// Vehicles by ascending number.
    vehicles: Vec<VehicleTotals>,
    /// Number of the last step that had vehicles or none, without the steps in which all stand.
    driven_steps: u64,
    /// Number of steps with vehicles.
    steps_with_vehicles: u64,
    /// Number of vehicles present now.
    present: usize,
    /// Sum over the steps of the number of vehicles.
    vehicle_steps: u64,
    /// Sum of the speeds of all vehicles at all steps, m/s.
    sum_mps: f64,
    sum_sd_mps: f64,
    fuel_ml: f64,
    /// Number of steps up to the last with a wave.
    last_disturbance: u64,
    /// Number of stops that began.
    pub stops: u64,
    /// Time of all vehicles at a stop, seconds.
    pub stopped_s: f64,
    /// Number of hard brakings that began.
    pub hard_brakings: u64,
    /// Time of all vehicles in hard brakings, seconds.
    pub hard_braking_s: f64,
}

/// Values of a step, returned by [`TrafficTotals::add`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepSpeeds {
    /// Mean over the vehicles, m/s; `None` without vehicles.
    pub mean_mps: Option<f64>,
    /// Speed of the first vehicle, m/s; 0 without vehicles.
    pub first_mps: f64,
}

impl TrafficTotals {
    /// Starts with steps of `step_s`.
    pub fn new(step_s: f64) -> Self {
        Self { step_s, ..Self::default() }
    }

    /// Sets the speeds of the vehicles that are present before the first step.
    pub fn start(&mut self, vehicles: impl Iterator<Item = (u32, f64)>) {
        for (k, (id, speed_mps)) in vehicles.enumerate() {
            self.place(k, id, speed_mps as f32);
            self.present = k + 1;
        }
    }

    /// Adds a step: numbers and speeds of the vehicles present at its end. A vehicle seen first has no acceleration.
    pub fn add(&mut self, vehicles: impl Iterator<Item = (u32, f64)>) -> StepSpeeds {
        let step_s = self.step_s as f32;
        self.steps += 1;
        self.driven_steps = self.steps;
        let (mut n, mut sum, mut square, mut fuel_ml_s, mut first_mps) = (0, 0.0, 0.0, 0.0, 0.0);
        let mut next = 0;
        for (id, v) in vehicles {
            let speed_mps = v as f32;
            let at = self.place(next, id, speed_mps);
            next = at + 1;
            let vehicle = &mut self.vehicles[at];
            let accel_mps2 = (speed_mps - vehicle.phase.before_mps()) / step_s;
            fuel_ml_s += f64::from(fuel::rate_ml_s(speed_mps, accel_mps2));
            let begun = vehicle.phase.add(speed_mps, step_s);
            self.stops += u64::from(begun.stop);
            self.hard_brakings += u64::from(begun.hard);
            self.stopped_s += if vehicle.phase.is_standing { self.step_s } else { 0.0 };
            self.hard_braking_s += if vehicle.phase.is_hard { self.step_s } else { 0.0 };
            if n == 0 {
                first_mps = v;
            }
            (vehicle.steps, vehicle.last_step) = (vehicle.steps + 1, self.steps);
            vehicle.sum_mps += v;
            vehicle.square += v * v;
            (n, sum, square) = (n + 1, sum + v, square + v * v);
        }
        self.present = n;
        self.vehicle_steps += n as u64;
        self.sum_mps += sum;
        self.fuel_ml += fuel_ml_s * self.step_s;
        if n == 0 {
            return StepSpeeds::default();
        }
        let mean_mps = sum / n as f64;
        let sd_mps = (square / n as f64 - mean_mps * mean_mps).max(0.0).sqrt();
        self.steps_with_vehicles += 1;
        self.sum_sd_mps += sd_mps;
        if sd_mps >= CALM_SD_MPS {
            self.last_disturbance = self.steps;
        }
        StepSpeeds { mean_mps: Some(mean_mps), first_mps }
    }

    /// Adds a step in which all present vehicles stand, as after a crash.
    pub fn add_standing(&mut self) {
        let last_step = self.driven_steps;
        self.steps += 1;
        self.steps_with_vehicles += 1;
        self.vehicle_steps += self.present as u64;
        self.vehicles
            .iter_mut()
            .filter(|vehicle| vehicle.last_step == last_step)
            .for_each(|vehicle| vehicle.steps += 1);
    }

    /// Returns the index of a vehicle, which is added if it is new; `next` is the index if it follows the vehicle before it.
    fn place(&mut self, next: usize, id: u32, speed_mps: f32) -> usize {
        if self.vehicles.get(next).is_some_and(|vehicle| vehicle.id == id) {
            return next;
        }
        self.vehicles.binary_search_by_key(&id, |vehicle| vehicle.id).unwrap_or_else(|at| {
            let phase = MotionPhase::new(speed_mps);
            self.vehicles.insert(at, VehicleTotals { id, steps: 0, sum_mps: 0.0, square: 0.0, phase, last_step: 0 });
            at
        })
    }

    /// Returns the length of a step, seconds.
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Returns the number of steps so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Returns the number of vehicles that were present at any time.
    pub fn vehicles(&self) -> usize {
        self.vehicles.len()
    }

    /// Returns the number of vehicles that are present now.
    pub fn present(&self) -> usize {
        self.present
    }

    /// Returns the number of vehicles present, mean over the steps.
    pub fn mean_present(&self) -> f64 {
        self.vehicle_steps as f64 / self.steps.max(1) as f64
    }

    /// Returns the highest number of a vehicle so far; 0 without any.
    pub fn newest(&self) -> u32 {
        self.vehicles.last().map_or(0, |vehicle| vehicle.id)
    }

    /// Returns the distance of all vehicles, metres.
    pub fn way_m(&self) -> f64 {
        self.sum_mps * self.step_s
    }

    /// Returns the distance of all vehicles over their time, m/s (Edie 1963); `None` without a vehicle.
    pub fn space_mean_speed_mps(&self) -> Option<f64> {
        (self.vehicle_steps > 0).then(|| self.sum_mps / self.vehicle_steps as f64)
    }

    /// Returns the standard deviation of speed over the vehicles, mean over the steps with vehicles, m/s.
    pub fn speed_sd_over_vehicles_mps(&self) -> f64 {
        self.sum_sd_mps / self.steps_with_vehicles.max(1) as f64
    }

    /// Returns the standard deviation of a vehicle's speed over its steps, mean over the vehicles, m/s.
    pub fn speed_sd_over_time_mps(&self) -> f64 {
        let driven = self.vehicles.iter().filter(|vehicle| vehicle.steps > 0);
        let sd = |vehicle: &VehicleTotals| {
            let (n, sum) = (vehicle.steps as f64, vehicle.sum_mps);
            (vehicle.square / n - (sum / n).powi(2)).max(0.0).sqrt()
        };
        driven.clone().map(sd).sum::<f64>() / (driven.count() as f64).max(1.0)
    }

    /// Returns the seconds from the first step to the last with a wave; `None` if the drive ends in one.
    pub fn last_disturbance_s(&self) -> Option<f64> {
        (self.last_disturbance < self.steps).then_some(self.last_disturbance as f64 * self.step_s)
    }

    /// Returns the fuel of all vehicles per 100 km ([`fuel`]), litres; `None` if no vehicle moved.
    pub fn fuel_l_100km(&self) -> Option<f64> {
        // 1 ml/m is 100 l per 100 km.
        (self.way_m() > 0.0).then(|| self.fuel_ml / self.way_m() * 100.0)
    }

    /// Returns a count per kilometre of any vehicle; 0 if no vehicle moved.
    pub fn per_km(&self, count: u64) -> f64 {
        if self.way_m() > 0.0 { count as f64 / self.way_m() * 1000.0 } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stops_and_brakings_match_a_hand_count() {
        let mut totals = TrafficTotals::new(0.1);
        // Vehicle 0: 4 m/s2 for 2.5 s to a standstill of 1 s, then off. Vehicle 7 stands for 1 s from the start, which is not a
        // stop, and goes.
        let braked = (0..=25).map(|k| 10.0 - 0.4 * f64::from(k));
        let first: Vec<f64> = braked.chain([0.0; 9]).chain([2.0; 10]).collect();
        for (k, speed) in first.iter().enumerate() {
            totals.add([(0, speed.max(0.0)), (7, if k < 10 { 0.0 } else { 3.0 })].into_iter());
        }
        assert_eq!((totals.stops, totals.hard_brakings, totals.vehicles()), (1, 1, 2));
        // Ten steps of standing each; 25 steps of braking.
        assert!((totals.stopped_s - 2.0).abs() < 1e-9, "{totals:?}");
        assert!((totals.hard_braking_s - 2.5).abs() < 1e-9, "{totals:?}");
    }

    #[test]
    fn a_car_in_the_place_of_another_has_not_braked_from_its_speed() {
        let mut totals = TrafficTotals::new(0.1);
        // By position in the list, vehicle 8 would stop from 10 m/s, with about 100 m/s2.
        totals.add([(0, 5.0), (7, 10.0)].into_iter());
        totals.add([(0, 5.0), (8, 0.05)].into_iter());
        assert_eq!((totals.stops, totals.hard_brakings, totals.vehicles()), (0, 0, 3));
        // Vehicle 8 stands when first seen, and creeps at its next row.
        totals.add([(8, 0.5)].into_iter());
        assert!((totals.stopped_s - 0.2).abs() < 1e-9, "{totals:?}");
    }

    #[test]
    fn stops_and_hard_brakings_are_counted_once_each() {
        let mut totals = TrafficTotals::new(0.1);
        // 10 m/s, then 0.4 m/s less per step (4 m/s2) to a standstill, creeping, and off again.
        let mut speeds = vec![10.0_f64; 100];
        speeds.extend((1..=25).map(|k| 10.0 - 0.4 * f64::from(k)));
        speeds.extend([0.0, 0.05, 0.5, 0.0, 2.0, 0.0]);
        for v in &speeds {
            totals.add([(0, v.max(0.0))].into_iter());
        }
        let way_km = speeds.iter().map(|v| v.max(0.0) * 0.1).sum::<f64>() / 1000.0;
        // Braking to a standstill, from 0.5 to 0 in a step (5 m/s2), and from 2 to 0.
        assert!((totals.per_km(totals.hard_brakings) - 3.0 / way_km).abs() < 1e-3, "{totals:?}");
        // 0.5 m/s in between is not a start; 2 m/s is.
        assert!((totals.per_km(totals.stops) - 2.0 / way_km).abs() < 1e-3, "{totals:?}");
    }
}
