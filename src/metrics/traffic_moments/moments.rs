//! List of the moments of traffic. In: trajectories. Out: each moment's number with its definition, in the order of the tables.

use super::{
    criteria,
    persons::{ACCEL_S, PersonMoments, accels_mps2, persons_of},
    trajectories::{VehicleTrajectories, VehicleTrajectory},
};
use crate::metrics::{
    Measure, correlation,
    distribution::{deviation, deviation_of_logs, distance_to_quantiles, kurtosis, mean, median, quantile},
    registry::measure,
    waves::WaveTotals,
};
use std::{array::from_fn, cell::OnceCell};

/// Acceleration over 1 s below which a braking is counted, m/s².
const BRAKING_MPS2: f64 = -1.0;
/// Speed below which a vehicle counts as standing, m/s.
const STANDING_MPS: f64 = 0.5;

/// Data that the moments are computed from.
struct MomentInputs<'a> {
    all: &'a VehicleTrajectories,
    /// Vehicles whose persons count, each as often as named.
    chosen: Vec<usize>,
    /// Waves of the whole ring.
    waves: WaveTotals,
    /// Waves of the chosen persons behind their leaders; `None` if these are all.
    pairs: Option<WaveTotals>,
    persons: Vec<PersonMoments>,
    /// Numbers of the persons in first and second half of the time, computed when they are needed.
    halves: OnceCell<[Vec<PersonMoments>; 2]>,
    /// Speeds of all vehicles at all steps, m/s.
    speeds_mps: Vec<f64>,
    /// Accelerations over 1 s of all vehicles, m/s², sorted.
    accels_mps2: Vec<f64>,
    /// Gaps of all vehicles at all steps, m, sorted.
    gaps_m: Vec<f64>,
}

type Moment = (Measure, fn(&MomentInputs) -> Option<f64>);

const OF_TRAFFIC: &[Moment] = &[
    (measure("mean_speed_mps"), |m| mean(&m.speeds_mps)),
    (measure("speed_sd_over_vehicles_mps"), |m| m.speed_sd_over_vehicles_mps()),
    (measure("speed_sd_growth_per_min"), |m| m.waves.growth_per_min()),
    (measure("accel_sd_mps2"), |m| deviation(&m.accels_mps2)),
    (measure("accel_p01_mps2"), |m| quantile(&m.accels_mps2, 0.01)),
    (measure("accel_p99_mps2"), |m| quantile(&m.accels_mps2, 0.99)),
    (measure("accel_kurtosis"), |m| kurtosis(&m.accels_mps2)),
    (measure("brakings_per_km"), |m| m.brakings_per_km()),
    (measure("standing_share"), |m| m.standing_share()),
    (measure("gap_p05_m"), |m| quantile(&m.gaps_m, 0.05)),
    (measure("gap_p25_m"), |m| quantile(&m.gaps_m, 0.25)),
    (measure("gap_median_m"), |m| quantile(&m.gaps_m, 0.5)),
    (measure("gap_p75_m"), |m| quantile(&m.gaps_m, 0.75)),
    (measure("gap_p95_m"), |m| quantile(&m.gaps_m, 0.95)),
    (measure("smallest_gap_m"), |m| m.gaps_m.first().copied()),
    (measure("gap_distance_to_experiment_a"), |m| distance_to_quantiles(&m.gaps_m, &criteria::GAP_QUANTILES_M)),
    (measure("person_gap_sd_m"), |m| mean(&m.each(|person| person.gap_sd_m))),
    (measure("person_time_gap_s"), |m| median(m.each(|person| person.time_gap_s))),
    (measure("shortest_person_time_gap_s"), |m| m.each(|person| person.time_gap_s).into_iter().reduce(f64::min)),
    (measure("longest_person_time_gap_s"), |m| m.each(|person| person.time_gap_s).into_iter().reduce(f64::max)),
    (measure("person_time_gap_ln_sd"), |m| deviation_of_logs(&m.each(|person| person.time_gap_s))),
    (measure("person_accel_ln_sd"), |m| deviation_of_logs(&m.each(|person| person.accel_sd_mps2))),
    (measure("lag_s"), |m| median(m.each(|person| person.lag_s))),
    (measure("shortest_person_lag_s"), |m| m.each(|person| person.lag_s).into_iter().reduce(f64::min)),
    (measure("longest_person_lag_s"), |m| m.each(|person| person.lag_s).into_iter().reduce(f64::max)),
    (measure("gain_at_0_03_hz"), |m| m.gain(0.03)),
    (measure("gain_at_0_06_hz"), |m| m.gain(0.06)),
    (measure("gain_at_0_1_hz"), |m| m.gain(0.10)),
    (measure("gain_at_0_15_hz"), |m| m.gain(0.15)),
    (measure("wave_speed_mps"), |m| Some(m.waves.wave()?.speed_mps)),
    (measure("wave_share"), |m| Some(m.waves.wave()?.share)),
    (measure("gap_split_half_r"), |m| m.split_half(|person| person.mean_gap_m)),
    (measure("time_gap_split_half_r"), |m| m.split_half(|person| person.time_gap_s)),
    (measure("accel_split_half_r"), |m| m.split_half(|person| person.accel_sd_mps2)),
    (measure("noise_split_half_r"), |m| m.split_half(|person| person.noise_mps2)),
    (measure("lag_split_half_r"), |m| m.split_half(|person| person.lag_s)),
];

/// Definitions of all moments, in order.
pub const MOMENTS: [Measure; OF_TRAFFIC.len()] = {
    let mut all = [OF_TRAFFIC[0].0; OF_TRAFFIC.len()];
    let mut i = 0;
    while i < all.len() {
        all[i] = OF_TRAFFIC[i].0;
        i += 1;
    }
    all
};

/// Moments of one traffic; `None` where there is nothing to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct TrafficMoments {
    /// Values in the order of [`MOMENTS`].
    pub values: [Option<f64>; MOMENTS.len()],
}

impl TrafficMoments {
    /// Returns a moment by its name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.values[MOMENTS.iter().position(|moment| moment.name == name)?]
    }
}

/// Computes all moments of the given steps.
pub fn moments(all: &VehicleTrajectories) -> TrafficMoments {
    let inputs = MomentInputs::of(all, None);
    TrafficMoments { values: from_fn(|i| OF_TRAFFIC[i].1(&inputs).filter(|value| value.is_finite())) }
}

/// Computes some moments of the persons in these vehicles, each as often as named, behind their own leaders; `None` if one has no value.
/// Speed, share and growth of the waves are always those of all vehicles.
pub fn moments_of_persons(all: &VehicleTrajectories, persons: Option<&[usize]>, names: &[&str]) -> Option<Vec<f64>> {
    let inputs = MomentInputs::of(all, persons);
    let value = |name: &&str| OF_TRAFFIC.iter().find(|moment| moment.0.name == *name)?.1(&inputs);
    names.iter().map(|name| value(name).filter(|value| value.is_finite())).collect()
}

/// Returns the SD of speed over time of each vehicle of a platoon, m/s, the first vehicle first; empty if the vehicles form none.
pub fn platoon_speed_sd_mps(all: &VehicleTrajectories) -> Vec<f64> {
    let follower = |leader: Option<usize>| all.vehicles.iter().position(|vehicle| vehicle.leader == leader);
    let order = std::iter::successors(follower(None), |last| follower(Some(*last)));
    order.filter_map(|vehicle| deviation(&all.vehicles[vehicle].speed_mps)).collect()
}

impl<'a> MomentInputs<'a> {
    fn of(all: &'a VehicleTrajectories, chosen: Option<&[usize]>) -> Self {
        let pairs = chosen.map(|chosen| all.waves_of_pairs(chosen));
        let chosen: Vec<usize> = chosen.map_or_else(|| (0..all.vehicles.len()).collect(), <[usize]>::to_vec);
        let sorted = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values
        };
        let vehicles = || chosen.iter().map(|vehicle| &all.vehicles[*vehicle]);
        Self {
            all,
            waves: all.waves(),
            pairs,
            persons: persons_of(all, &chosen),
            halves: OnceCell::new(),
            speeds_mps: vehicles().flat_map(|vehicle| vehicle.speed_mps.clone()).collect(),
            accels_mps2: sorted(vehicles().flat_map(|vehicle| accels_mps2(&vehicle.speed_mps, all.step_s)).collect()),
            gaps_m: sorted(vehicles().flat_map(|vehicle| vehicle.gap_m.clone()).collect()),
            chosen,
        }
    }

    /// Returns the chosen vehicles.
    fn vehicles(&self) -> impl Iterator<Item = &VehicleTrajectory> {
        self.chosen.iter().map(|vehicle| &self.all.vehicles[*vehicle])
    }

    fn gain(&self, hz: f64) -> Option<f64> {
        self.pairs.as_ref().unwrap_or(&self.waves).gain(hz)
    }

    /// Returns a number of each person who has it.
    fn each(&self, of: fn(&PersonMoments) -> Option<f64>) -> Vec<f64> {
        self.persons.iter().filter_map(of).collect()
    }

    /// Returns the correlation over persons of a number in the first half of the time and in the second.
    fn split_half(&self, of: fn(&PersonMoments) -> Option<f64>) -> Option<f64> {
        let [first, second] = self.halves.get_or_init(|| self.all.halves().map(|half| persons_of(&half, &self.chosen)));
        let pairs: Vec<(f64, f64)> =
            first.iter().zip(second).filter_map(|(first, second)| Some((of(first)?, of(second)?))).collect();
        correlation(&pairs)
    }

    fn speed_sd_over_vehicles_mps(&self) -> Option<f64> {
        let at = |step: usize| {
            let speeds: Vec<f64> = self.vehicles().map(|vehicle| vehicle.speed_mps[step]).collect();
            deviation(&speeds)
        };
        mean(&(0..self.all.steps()).filter_map(at).collect::<Vec<f64>>())
    }

    fn standing_share(&self) -> Option<f64> {
        let standing = self.speeds_mps.iter().filter(|speed| **speed < STANDING_MPS).count();
        (!self.speeds_mps.is_empty()).then(|| standing as f64 / self.speeds_mps.len() as f64)
    }

    /// Returns the number of brakings per vehicle kilometre: a braking begins at an acceleration over 1 s below -1 m/s².
    fn brakings_per_km(&self) -> Option<f64> {
        let of_vehicle = |speeds_mps: &Vec<f64>| {
            let brakes: Vec<bool> =
                accels_mps2(speeds_mps, self.all.step_s).iter().map(|accel| *accel < BRAKING_MPS2).collect();
            brakes.iter().enumerate().filter(|(i, brake)| **brake && (*i == 0 || !brakes[i - 1])).count()
        };
        let brakings: usize = self.vehicles().map(|vehicle| of_vehicle(&vehicle.speed_mps)).sum();
        let way_km = self.speeds_mps.iter().sum::<f64>() * self.all.step_s / 1000.0;
        (way_km > 0.0 && self.all.steps() as f64 * self.all.step_s > ACCEL_S).then(|| brakings as f64 / way_km)
    }
}
