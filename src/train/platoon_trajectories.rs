//! Simulated followers behind a recorded first vehicle, for a comparison with the people of the platoon. In: a recorded platoon, drivers and a
//! seed. Out: the platoon with simulated followers. Metres, m/s.

use crate::{
    metrics::traffic_moments::VehicleTrajectories,
    rng,
    traffic::{TrafficDriver, TrafficDrivers},
};

/// Replaces every vehicle with a leader by a driver of the seed, from its recorded speed and gap on; the others stay as recorded.
pub fn platoon_trajectories(
    recorded: &VehicleTrajectories,
    drivers: &TrafficDrivers,
    seed: u64,
) -> VehicleTrajectories {
    let mut all = recorded.clone();
    let follower = |leader: Option<usize>| recorded.vehicles.iter().position(|vehicle| vehicle.leader == leader);
    let mut leader = follower(None);
    while let Some((leading, following)) = leader.and_then(|leading| Some((leading, follower(Some(leading))?))) {
        let person = drivers.driver(seed, following as u32);
        let mut noise = rng::stream(seed, &format!("platoon/{following}"));
        let own = &recorded.vehicles[following];
        let start = [own.speed_mps[0], own.gap_m[0]];
        let leader_mps = &all.vehicles[leading].speed_mps;
        let driven = driven(&person, leader_mps, start, recorded.step_s, || noise.normal());
        (all.vehicles[following].speed_mps, all.vehicles[following].gap_m) = driven;
        leader = Some(following);
    }
    all
}

/// Returns speed and gap of a driver behind a leader at each step.
fn driven(
    person: &TrafficDriver,
    leader_mps: &[f64],
    [mut speed_mps, mut gap_m]: [f64; 2],
    step_s: f64,
    mut normal: impl FnMut() -> f64,
) -> (Vec<f64>, Vec<f64>) {
    let (keeps, adds_mps) = person.noise.in_steps_of(step_s);
    let mut change_mps = 0.0;
    let (mut speeds_mps, mut gaps_m) = (vec![speed_mps], vec![gap_m]);
    for (leader_now, leader_next) in leader_mps.iter().zip(&leader_mps[1..]) {
        let accel_mps2 = person.model.acceleration(speed_mps, *leader_now, gap_m, f64::INFINITY);
        change_mps = keeps * change_mps + adds_mps * normal();
        speed_mps = (speed_mps + accel_mps2 * step_s + change_mps).max(0.0);
        gap_m += (leader_next - speed_mps) * step_s;
        speeds_mps.push(speed_mps);
        gaps_m.push(gap_m);
    }
    (speeds_mps, gaps_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{idm::IdmParams, metrics::traffic_moments::VehicleTrajectory, traffic::RING_STUDY};

    #[test]
    fn followers_settle_at_the_leaders_speed_and_the_gap_of_their_model() {
        let idm = IdmParams { noise: 0.0, ..IdmParams::default() };
        let vehicle = |leader: Option<usize>| VehicleTrajectory {
            leader,
            speed_mps: vec![10.0; 3000],
            gap_m: if leader.is_some() { vec![30.0; 3000] } else { Vec::new() },
            ..VehicleTrajectory::default()
        };
        let vehicles = vec![vehicle(Some(2)), vehicle(Some(0)), vehicle(None)];
        let recorded = VehicleTrajectories { step_s: 0.1, ring_m: None, vehicles };
        let drivers = TrafficDrivers::named(RING_STUDY, idm).unwrap();
        let all = platoon_trajectories(&recorded, &drivers, 1);
        assert_eq!(all.vehicles[2], recorded.vehicles[2]);
        for vehicle in &all.vehicles[..2] {
            let (speed_mps, gap_m) = (vehicle.speed_mps[2999], vehicle.gap_m[2999]);
            assert!((speed_mps - 10.0).abs() < 1e-3, "{speed_mps}");
            assert!((idm.equilibrium_speed_mps(gap_m) - 10.0).abs() < 1e-2, "{gap_m}");
        }
    }
}
