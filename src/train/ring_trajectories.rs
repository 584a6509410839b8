//! Trajectories of traffic on rings, for a comparison with measured people. In: drivers, ring and seeds. Out: speed and gap of each vehicle
//! at each step, a run for each seed. Metres, m/s.

use super::{
    ring::{RingStart, VectorizedRing},
    simd::LANES,
};
use crate::{
    idm::IdmParams,
    metrics::traffic_moments::{VehicleTrajectories, VehicleTrajectory},
    space::CAR_LENGTH_M,
    traffic::TrafficDrivers,
};

/// Length of a step, s.
const STEP_S: f64 = 0.1;

/// Runs `runs` rings of `ring_m` with `vehicles` for `duration_s`, from an even start at a standstill; run `k` has the seed `first_seed + k`.
pub fn ring_trajectories(
    drivers: &TrafficDrivers,
    (vehicles, ring_m): (usize, f64),
    duration_s: f64,
    (first_seed, runs): (u64, usize),
) -> Vec<VehicleTrajectories> {
    let seeds: Vec<u64> = (first_seed..).take(runs).collect();
    seeds.chunks(LANES).flat_map(|seeds| block(drivers, (vehicles, ring_m), duration_s, seeds)).collect()
}

/// Runs a ring for each of at most sixteen seeds.
fn block(
    drivers: &TrafficDrivers,
    (vehicles, ring_m): (usize, f64),
    duration_s: f64,
    seeds: &[u64],
) -> Vec<VehicleTrajectories> {
    let mut rings = VectorizedRing::new(vehicles, STEP_S);
    let idm = match drivers {
        TrafficDrivers::Alike(idm) => *idm,
        TrafficDrivers::People(_) => IdmParams::default(),
    };
    for l in 0..LANES {
        let seed = seeds.get(l).copied().unwrap_or_default();
        let own_drivers = if drivers.are_alike() { Vec::new() } else { drivers.drivers(seed, vehicles) };
        rings.set(l, &RingStart { own_drivers, ..RingStart::even(vehicles, ring_m, idm, seed) });
    }
    // Vehicle k is the k-th behind the first, so that its leader is the one before it.
    let vehicle = |k: usize| VehicleTrajectory {
        name: (k + 1).to_string(),
        leader: Some((k + vehicles - 1) % vehicles),
        length_m: Some(CAR_LENGTH_M),
        ..VehicleTrajectory::default()
    };
    let run =
        || VehicleTrajectories { step_s: STEP_S, ring_m: Some(ring_m), vehicles: (0..vehicles).map(vehicle).collect() };
    let mut all: Vec<VehicleTrajectories> = seeds.iter().map(|_| run()).collect();
    for _ in 0..(duration_s / STEP_S).round() as usize {
        rings.run(1);
        for (l, run) in all.iter_mut().enumerate() {
            for (k, (vehicle, speed_mps)) in run.vehicles.iter_mut().zip(rings.speeds_mps(l)).enumerate() {
                vehicle.speed_mps.push(f64::from(speed_mps));
                vehicle.gap_m.push(f64::from(rings.gaps_m(k)[l]));
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_and_vehicles_add_up_to_the_ring_and_a_seed_is_a_run() {
        let drivers = TrafficDrivers::named("safe-followers", IdmParams::default()).unwrap();
        let runs = ring_trajectories(&drivers, (20, 260.0), 60.0, (1, 18));
        assert!(runs.len() == 18 && runs.iter().all(|run| run.steps() == 600));
        for run in &runs {
            let gaps_m: f64 = run.vehicles.iter().map(|vehicle| vehicle.gap_m[599]).sum();
            assert!((gaps_m + 20.0 * CAR_LENGTH_M - 260.0).abs() < 0.01, "{gaps_m}");
        }
        assert_eq!(ring_trajectories(&drivers, (20, 260.0), 60.0, (17, 2)), runs[16..]);
        assert_ne!(runs[0], runs[1]);
        // The leader of each vehicle is the one whose gap grows when it is faster.
        let vehicle = &runs[0].vehicles[7];
        let leader = &runs[0].vehicles[vehicle.leader.unwrap()];
        let grown_m = vehicle.gap_m[599] - vehicle.gap_m[0];
        let driven_m = |speed: &[f64]| speed[1..].iter().sum::<f64>() * STEP_S;
        assert!((driven_m(&leader.speed_mps) - driven_m(&vehicle.speed_mps) - grown_m).abs() < 0.5, "{grown_m}");
    }
}
