//! Vehicles of a file of trajectories in whole drives. Expected: the file's positions and the integral of its speeds, the equilibrium of
//! the Intelligent Driver Model, and in closed form the way of a ramp of speed.

use codrive::{
    drive_loop::{episode::Episode, episode_config::EpisodeConfig, evaluation_drive, offline::OfflineDrive},
    idm::IdmParams,
    scenario::{AdvisedVehicles, DisplaySettings, Scenario},
    sim::{Snapshot, World},
    space::CAR_LENGTH_M,
    traffic::{Demand, EngineChoice, VehicleId},
};
use std::{fs, path::Path};

/// Returns the scenario of a drive without noise behind the vehicles of a file with these rows.
fn behind(folder: &Path, head: &str, rows: impl Iterator<Item = String>) -> Scenario {
    let file = folder.join("log.csv");
    fs::write(&file, format!("{head}\n{}", rows.collect::<String>())).expect("written");
    Scenario {
        map: "lane-10km".into(),
        traffic: EngineChoice::Log(file.to_str().expect("a name").into()),
        idm: IdmParams { noise: 0.0, ..IdmParams::default() },
        policy: "none".into(),
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    }
}

/// Speed of a leader, m/s: 10 m/s, from 10 s on 0.5 m/s2, from 30 s on 20 m/s.
fn ramp_mps(t: f64) -> f64 {
    10.0 + 0.5 * (t - 10.0).clamp(0.0, 20.0)
}

/// Way of that leader, m.
fn ramp_m(t: f64) -> f64 {
    let rising_s = (t - 10.0).clamp(0.0, 20.0);
    10.0 * t + 0.25 * rising_s * rising_s + 10.0 * (t - 30.0).max(0.0)
}

fn ramp(seconds: u32) -> impl Iterator<Item = String> {
    (0..=seconds).map(f64::from).map(|t| format!("{t},{}\n", ramp_mps(t)))
}

/// Returns where a vehicle is along the lane, m.
fn s_m(snapshot: &Snapshot, id: u32) -> f64 {
    snapshot.vehicle(VehicleId(id)).and_then(|car| car.s_m).expect("on the lane")
}

#[test]
fn the_leader_drives_the_integral_of_its_speeds_among_full_physics() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = Scenario { vehicles: 3, duration_s: 40.0, ..behind(folder.path(), "time_s,speed_mps", ramp(40)) };
    let mut run = OfflineDrive::new(&scenario, [0.0, f64::INFINITY]).expect("a drive");
    let start_m = s_m(run.world().snapshot(), 1);
    for step in 1..=400 {
        run.step().expect("driven");
        let (t, snapshot) = (f64::from(step) / 10.0, run.world().snapshot());
        let leader = snapshot.vehicle(VehicleId(1)).expect("the leader");
        assert!((s_m(snapshot, 1) - start_m - ramp_m(t)).abs() < 1e-6, "{t}");
        assert!((leader.speed_mps - ramp_mps(t)).abs() < 1e-9, "{t}");
        // The ego is behind the leader, and vehicle 2 behind the ego.
        assert_eq!(snapshot.leader.map(|leader| leader.id), Some(VehicleId(1)));
        assert!(s_m(snapshot, 2) < snapshot.ego_s_m && snapshot.ego_s_m < s_m(snapshot, 1));
    }
    assert_eq!(run.summary().contact_count, 0);
}

#[test]
fn followers_settle_at_the_equilibrium_gap_of_the_idm() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = behind(folder.path(), "time_s,speed_mps", ramp(300));
    let mut world = World::new(&Scenario { participant: false, vehicles: 4, ..scenario }).expect("a world");
    while world.ended().is_none() {
        world.step().expect("driven");
    }
    // (s0 + v T) / sqrt(1 - (v / v0)^4) at 20 m/s.
    let wanted_m = 22.0 / (1.0 - (2.0_f64 / 3.0).powi(4)).sqrt();
    let places: Vec<f64> = [1, 0, 2, 3].map(|id| s_m(world.snapshot(), id)).into();
    for pair in places.windows(2) {
        let gap_m = pair[0] - pair[1] - CAR_LENGTH_M;
        assert!((gap_m - wanted_m).abs() < 0.01, "{gap_m}, expected {wanted_m}");
    }
}

#[test]
fn all_vehicles_of_a_file_are_at_its_positions_at_each_sample() {
    let folder = tempfile::tempdir().expect("a folder");
    // Two vehicles, sampled each 0.2 s, whose positions are no integral of their speeds to the millimetre.
    let place = |car: u32, k: u32| f64::from(car) * 30.0 + 3.0 * f64::from(k) + 0.1 * (f64::from(k) * 0.7).sin();
    let speed = |k: u32| 15.0 + 0.35 * (f64::from(k) * 0.7).cos();
    let rows = (0..=100)
        .flat_map(|k| [0, 1].map(|car| format!("{},car-{car},{},{}\n", f64::from(k) / 5.0, place(car, k), speed(k))));
    let scenario = behind(folder.path(), "time_s,vehicle,s_m,speed_mps", rows);
    let scenario = Scenario { vehicles: 2, duration_s: 20.0, advised: AdvisedVehicles::Count(0), ..scenario };
    let mut run = OfflineDrive::new(&scenario, [0.0, f64::INFINITY]).expect("a drive");
    assert_eq!(run.world().drive().fixed_vehicles(), Some(3), "two of the file and the ego");
    let start_m = s_m(run.world().snapshot(), 1) - place(0, 0);
    for k in 1..=100 {
        run.until(f64::from(k) / 5.0).expect("driven");
        for car in [0, 1] {
            let found_m = s_m(run.world().snapshot(), car + 1) - start_m;
            assert!((found_m - place(car, k)).abs() < 1e-9, "car {car} at sample {k}: {found_m}");
        }
    }
}

#[test]
fn advised_vehicles_of_a_platoon_are_light_and_the_leader_never_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = behind(folder.path(), "time_s,speed_mps", ramp(60));
    let advised = AdvisedVehicles::Share(1.0);
    let (policy, policy_speed_mps) = ("constant".into(), 15.0);
    let scenario = Scenario { vehicles: 4, duration_s: 30.0, advised, policy, policy_speed_mps, ..scenario };
    let mut run = OfflineDrive::new(&scenario, [0.0, f64::INFINITY]).expect("a drive");
    run.until(30.0).expect("driven");
    let advised: Vec<u32> = run.world().ever_advised().iter().map(|id| id.0).collect();
    assert_eq!(advised, [2, 3]);
    assert_eq!((run.advised().vehicles, run.advised().of), (vec![0, 2, 3], Some(3)));
    let leaders = run.world().advised_others().iter().map(|agent| agent.snapshot().leader.map(|leader| leader.id.0));
    assert_eq!(leaders.collect::<Vec<_>>(), [Some(0), Some(2)]);
}

#[test]
fn an_evaluation_behind_a_log_has_fuel_and_no_flow() {
    let folder = tempfile::tempdir().expect("a folder");
    let wave = (0..=60).map(|t| format!("{t},{}\n", 12.0 + 6.0 * (f64::from(t) * 0.3).sin()));
    let scenario = behind(folder.path(), "time_s,speed_mps", wave);
    let of = |policy: &str, advised: &str| {
        let advised = advised.parse().expect("a share");
        let scenario = Scenario { vehicles: 6, duration_s: 60.0, advised, policy: policy.into(), ..scenario.clone() };
        evaluation_drive::evaluate(&scenario).unwrap_or_else(|e| panic!("{e}"))
    };
    let (none, advised) = (of("none", "0"), of("follower-stopper", "20%"));
    for result in [none, advised] {
        assert!(result.fuel_l_100km.is_some_and(|fuel| fuel > 2.0) && result.flow_per_h.is_none() && !result.crashed);
    }
    // The leader's mean of 60 s, less what the vehicles behind it lag.
    assert!((none.mean_speed_mps - 12.0).abs() < 1.0, "{none:?}");
    assert_ne!(none.fuel_l_100km, advised.fuel_l_100km);
}

#[test]
fn an_episode_behind_a_log_advises_the_platoon_and_ends_with_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = behind(folder.path(), "time_s,speed_mps", ramp(20));
    let fields = EpisodeConfig::fields();
    let field = |key: &str| fields.iter().find(|field| field.path == key).expect("a setting").clone();
    let changes = [
        (field("traffic"), scenario.traffic.to_string().into()),
        (field("advised"), "50%".into()),
        (field("vehicles"), 5.into()),
        (field("hold_s"), 5.0.into()),
        (field("horizon_s"), 100.0.into()),
    ];
    let config = EpisodeConfig::new("lane-10km", Some("follow"), Demand::default(), &changes).expect("a configuration");
    let mut episode = Episode::begin(&config, 1).expect("an episode");
    // Half of the ego and three others: the ego, and the second vehicle behind it.
    assert_eq!(episode.agents().map(|id| id.0).collect::<Vec<_>>(), [0, 3]);
    let mut holds = 0;
    while episode.agents().count() > 0 {
        episode.hold(&[0.0, 0.0]).expect("a hold");
        holds += 1;
    }
    assert_eq!(holds, 4, "20 s in holds of 5 s");
}
