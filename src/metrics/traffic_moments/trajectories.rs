//! Trajectories of vehicles that follow each other in one lane. In: speed and gap at each step. Out: parts in time, positions on the ring.

use crate::metrics::waves::{VehicleSample, WaveTotals};

/// Speed and gap of a vehicle at each step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VehicleTrajectory {
    /// Name of the vehicle in its source.
    pub name: String,
    /// Index of the vehicle ahead; `None` for the first of a platoon.
    pub leader: Option<usize>,
    /// Length of the vehicle, m; `None` if unknown.
    pub length_m: Option<f64>,
    /// Speed at each step, m/s.
    pub speed_mps: Vec<f64>,
    /// Distance from the front bumper to the leader's rear at each step, m; empty without a leader.
    pub gap_m: Vec<f64>,
    /// Front bumper along the lane at each step, m; only of logs.
    pub s_m: Vec<f64>,
}

/// Vehicles that follow each other in one lane, each with as many steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VehicleTrajectories {
    /// Length of a step, s.
    pub step_s: f64,
    /// Length of the ring, m; `None` for a platoon, or if unknown.
    pub ring_m: Option<f64>,
    pub vehicles: Vec<VehicleTrajectory>,
}

impl VehicleTrajectories {
    /// Returns the number of steps.
    pub fn steps(&self) -> usize {
        self.vehicles.first().map_or(0, |vehicle| vehicle.speed_mps.len())
    }

    /// Returns the steps from a time on until before another, s since the first step, as far as there are any.
    #[must_use]
    pub fn between(&self, from_s: f64, to_s: f64) -> Self {
        let step = |time_s: f64| (time_s / self.step_s).round().clamp(0.0, self.steps() as f64) as usize;
        let (from, to) = (step(from_s), step(to_s).max(step(from_s)));
        let part = |values: &Vec<f64>| values.get(from..to).unwrap_or_default().to_vec();
        let vehicle = |vehicle: &VehicleTrajectory| VehicleTrajectory {
            name: vehicle.name.clone(),
            leader: vehicle.leader,
            length_m: vehicle.length_m,
            speed_mps: part(&vehicle.speed_mps),
            gap_m: part(&vehicle.gap_m),
            s_m: part(&vehicle.s_m),
        };
        Self { step_s: self.step_s, ring_m: self.ring_m, vehicles: self.vehicles.iter().map(vehicle).collect() }
    }

    /// Returns first and second half of the steps.
    pub fn halves(&self) -> [Self; 2] {
        let (middle_s, end_s) = ((self.steps() / 2) as f64 * self.step_s, self.steps() as f64 * self.step_s);
        [self.between(0.0, middle_s), self.between(middle_s, end_s)]
    }

    /// Returns every n-th step, the longest steps of at most `most_s` of which a whole number is a second; the same if there are none.
    #[must_use]
    pub fn thinned(&self, most_s: f64) -> Self {
        let divides = |n: &usize| {
            let per_s = 1.0 / (*n as f64 * self.step_s);
            (per_s - per_s.round()).abs() < 1e-3
        };
        let every = (1..=(most_s / self.step_s + 1e-6) as usize).rev().find(divides).unwrap_or(1);
        let part = |values: &Vec<f64>| values.iter().copied().step_by(every).collect();
        let vehicle = |vehicle: &VehicleTrajectory| VehicleTrajectory {
            name: vehicle.name.clone(),
            leader: vehicle.leader,
            length_m: vehicle.length_m,
            speed_mps: part(&vehicle.speed_mps),
            gap_m: part(&vehicle.gap_m),
            s_m: part(&vehicle.s_m),
        };
        let step_s = every as f64 * self.step_s;
        Self { step_s, ring_m: self.ring_m, vehicles: self.vehicles.iter().map(vehicle).collect() }
    }

    /// Returns the vehicles from the first one backwards round the ring, each with its leader before it; `None` if they do not
    /// form one ring of known length.
    fn round(&self) -> Option<Vec<usize>> {
        self.ring_m?;
        let mut order = vec![0];
        while order.len() <= self.vehicles.len() {
            let last = *order.last()?;
            let follower = self.vehicles.iter().position(|vehicle| vehicle.leader == Some(last))?;
            if follower == 0 {
                break;
            }
            order.push(follower);
        }
        (order.len() == self.vehicles.len()).then_some(order)
    }

    /// Returns the length of vehicles without one, m: that with which gaps and lengths add up to the ring.
    fn unknown_length_m(&self) -> f64 {
        let steps = self.steps().max(1) as f64;
        let gaps_m: f64 = self.vehicles.iter().flat_map(|vehicle| &vehicle.gap_m).sum::<f64>() / steps;
        let known_m: f64 = self.vehicles.iter().filter_map(|vehicle| vehicle.length_m).sum();
        let unknown = self.vehicles.iter().filter(|vehicle| vehicle.length_m.is_none()).count();
        (self.ring_m.unwrap_or_default() - gaps_m - known_m) / unknown.max(1) as f64
    }

    /// Returns the position of each vehicle along the ring, m, not wrapped, a row per step: the first vehicle's follows from its
    /// speed, the others' from gaps and lengths. `None` if the vehicles do not form one ring of known length.
    pub fn positions_m(&self) -> Option<Vec<Vec<f64>>> {
        let (round, unknown_m) = (self.round()?, self.unknown_length_m());
        let length_m = |vehicle: usize| self.vehicles[vehicle].length_m.unwrap_or(unknown_m);
        let mut first_m = 0.0;
        let row = |step: usize| {
            let mut row = vec![first_m; self.vehicles.len()];
            for pair in round.windows(2) {
                row[pair[1]] = row[pair[0]] - self.vehicles[pair[1]].gap_m[step] - length_m(pair[0]);
            }
            first_m += self.vehicles[0].speed_mps[step] * self.step_s;
            row
        };
        Some((0..self.steps()).map(row).collect())
    }

    /// Returns the sums of the waves; off a ring of known length there is no wave speed.
    pub fn waves(&self) -> WaveTotals {
        let positions_m = self.positions_m();
        let leaders = self.vehicles.iter().map(|vehicle| vehicle.leader).collect();
        let ring_m = self.ring_m.filter(|_| positions_m.is_some());
        let mut waves = WaveTotals::with_leaders(self.step_s, ring_m, leaders);
        for step in 0..self.steps() {
            let position_m = |vehicle: usize| positions_m.as_ref().map_or(f64::NAN, |rows| rows[step][vehicle]);
            let sample = |(i, vehicle): (usize, &VehicleTrajectory)| VehicleSample {
                speed_mps: vehicle.speed_mps[step],
                position_m: position_m(i),
            };
            waves.add(self.vehicles.iter().enumerate().map(sample));
        }
        waves
    }

    /// Returns the sums of these followers, each with their leader and as often as named, as pairs without a ring.
    pub(super) fn waves_of_pairs(&self, followers: &[usize]) -> WaveTotals {
        let pairs: Vec<[usize; 2]> =
            followers.iter().filter_map(|follower| Some([*follower, self.vehicles[*follower].leader?])).collect();
        let leaders = (0..pairs.len()).map(|k| Some(pairs.len() + k)).chain(pairs.iter().map(|_| None)).collect();
        let mut waves = WaveTotals::with_leaders(self.step_s, None, leaders);
        for step in 0..self.steps() {
            let sample = |vehicle: usize| VehicleSample {
                speed_mps: self.vehicles[vehicle].speed_mps[step],
                position_m: f64::NAN,
            };
            let side = |k: usize| pairs.iter().map(move |pair| sample(pair[k]));
            waves.add(side(0).chain(side(1)));
        }
        waves
    }
}
