//! Vehicles of a file on a lane, and the simulated vehicles behind them.

use super::*;
use crate::{
    idm::IdmParams,
    scenario::{AdvisedVehicles, PlannedDrive},
};
use std::fs;

/// Writes a leader at a constant speed for some seconds; the folder is deleted when it is dropped.
fn leader(speed_mps: f64, seconds: u32) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..=seconds).map(|t| format!("{t},{speed_mps}\n")).collect();
    let file = folder.path().join("leader.csv");
    fs::write(&file, format!("time_s,speed_mps\n{rows}")).unwrap();
    (folder, file.to_str().unwrap().to_owned())
}

fn scenario(file: &str) -> Scenario {
    let (map, traffic) = (LANE.into(), EngineChoice::Log(file.into()));
    Scenario { map, traffic, idm: IdmParams { noise: 0.0, ..IdmParams::default() }, ..Scenario::default() }
}

fn refused(scenario: &Scenario) -> String {
    PlannedDrive::new(scenario).unwrap_err().to_string()
}

#[test]
fn vehicles_start_behind_the_leader_at_the_gap_of_the_idm() {
    let (_folder, file) = leader(20.0, 300);
    let drive = PlannedDrive::new(&Scenario { vehicles: 5, ..scenario(&file) }).unwrap();
    let logged = drive.logged().expect("a log");
    assert_eq!((logged.logged(), logged.simulated(), drive.fixed_vehicles()), (1, 4, Some(5)));
    // (2 + 20 T) / sqrt(1 - (20/30)^4) with T = 1 s.
    let gap_m = 22.0 / (1.0 - (2.0_f64 / 3.0).powi(4)).sqrt();
    let places: Vec<f64> = [1, 0, 2, 3, 4].map(|id| logged.starts[id].s_m).into();
    for pair in places.windows(2) {
        assert!((pair[0] - pair[1] - CAR_LENGTH_M - gap_m).abs() < 1e-6, "{places:?}");
    }
    assert!((places[4] - CAR_LENGTH_M).abs() < 1e-9, "the rear of the last is at the lane's begin");
    assert!(logged.starts.iter().all(|start| start.speed_mps == 20.0));
}

#[test]
fn a_share_is_of_the_simulated_vehicles_and_spread_over_them() {
    let (_folder, file) = leader(20.0, 300);
    let advised = |text: &str, vehicles: u32| {
        let advised = text.parse::<AdvisedVehicles>().unwrap();
        PlannedDrive::new(&Scenario { vehicles, advised, ..scenario(&file) }).unwrap()
    };
    // 4 % of 100 are 4: the ego, and every 25th vehicle behind it. Vehicle 1 is the leader, so place k has number k + 1.
    assert_eq!(advised("4%", 101).advised_others(), [26, 51, 76]);
    assert_eq!(advised("4%", 101).advised(), AdvisedVehicles::Count(4));
    assert_eq!(advised("100%", 4).advised_others(), [2, 3]);
    assert!(advised("1", 101).advised_others().is_empty());
    let alone =
        Scenario { participant: false, advised: AdvisedVehicles::Share(0.04), vehicles: 101, ..scenario(&file) };
    assert_eq!(PlannedDrive::new(&alone).unwrap().advised_others(), [0, 26, 51, 76]);
    let most = refused(&Scenario { vehicles: 10, advised: AdvisedVehicles::Count(10), ..scenario(&file) });
    assert!(most.starts_with("advised is 10; allowed: 0 to 9"), "{most}");
}

#[test]
fn a_drive_without_a_duration_lasts_as_long_as_the_file() {
    let (_folder, file) = leader(20.0, 250);
    let drive = PlannedDrive::new(&Scenario { duration_s: 0.0, warm_up_s: 30.0, ..scenario(&file) }).unwrap();
    assert!((drive.scenario().duration_s - 220.0).abs() < 1e-9);
    let again = PlannedDrive::new(drive.scenario()).unwrap();
    assert_eq!(
        (again.scenario(), &again.logged().unwrap().starts),
        (drive.scenario(), &drive.logged().unwrap().starts)
    );
    assert!((drive.logged_mean_speed_mps() - 20.0).abs() < 1e-9);
}

#[test]
fn faults_of_a_log_on_a_lane_name_value_and_remedy() {
    let (folder, file) = leader(35.0, 300);
    let short = refused(&Scenario { warm_up_s: 60.0, ..scenario(&file) });
    assert!(
        short.contains("leader.csv ends after 300.0 s; the drive needs 360.0 s (warm_up 60 s, duration 300 s)"),
        "{short}"
    );
    assert!(
        short.contains("remedy: duration 240 (in evaluations the horizon), or 0 for as long as file and lane allow"),
        "{short}"
    );
    // 35 m/s for 300 s are 10,500 m, behind 21 vehicles. Without a duration the drive ends at the end of the lane.
    let endless = PlannedDrive::new(&Scenario { duration_s: 0.0, vehicles: 2, ..scenario(&file) }).unwrap();
    let start_m = endless.logged().unwrap().starts[1].s_m;
    assert!((endless.scenario().duration_s - (10_000.0 - start_m) / 35.0).abs() < 0.1);
    let far = refused(&scenario(&file));
    assert!(
        far.starts_with("map lane-10km is 10000 m long; vehicle \"1\" of ")
            && far.contains("codrive map lane --length"),
        "{far}"
    );
    let ring = refused(&Scenario { map: "ring-250".into(), ..scenario(&file) });
    assert!(ring.starts_with("map is ring-250, a closed route;") && ring.contains("remedy: map lane-10km"), "{ring}");
    let missing = refused(&scenario(folder.path().join("nobody.csv").to_str().unwrap()));
    assert!(missing.contains("nobody.csv: cannot be read"), "{missing}");
    let with = |changed: Scenario| Scenario::from_toml(&changed.to_toml(), "x").unwrap_err().message;
    let path = with(Scenario { path: "e0".into(), ..scenario(&file) });
    assert!(path.contains("path is e0; allowed with traffic") && path.contains("empty"), "{path}");
    let wave = with(Scenario { wave_sd_mps: 1.0, ..scenario(&file) });
    assert!(wave.contains("wave_sd_mps is 1; allowed with traffic"), "{wave}");
}

#[test]
fn the_ego_drives_in_the_gap_behind_a_named_vehicle() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("platoon.csv");
    // Three vehicles at 20 m/s: c leads, a is the last, with gaps of 45 m and 6 m from bumper to bumper.
    let places = [("a", 0.0), ("b", 50.0), ("c", 61.0)];
    let rows =
        (0..=300).flat_map(|t| places.map(|(name, s_m)| format!("{t},{name},{},20\n", s_m + 20.0 * f64::from(t))));
    fs::write(&file, format!("time_s,vehicle,s_m,speed_mps\n{}", rows.collect::<String>())).unwrap();
    let behind = |name: &str| Scenario { traffic_leader: name.into(), ..scenario(file.to_str().unwrap()) };
    let drive = PlannedDrive::new(&behind("b")).unwrap();
    let starts: Vec<f64> = drive.logged().unwrap().starts.iter().map(|start| start.s_m).collect();
    // The rear of the last is at the lane's begin; the ego of 5 m has 20 m before and behind it, less than the model's gap.
    assert_eq!(starts, [30.0, 5.0, 55.0, 66.0]);
    assert_eq!((drive.advisable(), drive.scenario().vehicles), (Some(1), 4));
    let tight = refused(&behind("c"));
    assert!(tight.starts_with("traffic_leader is \"c\"; the gap from it to vehicle \"b\" is 6.0 m"), "{tight}");
    let unknown = refused(&behind("d"));
    assert!(unknown.contains("traffic_leader is \"d\"") && unknown.contains("platoon.csv: a, b, c"), "{unknown}");
    // Behind the last vehicle there is room for others.
    assert_eq!(PlannedDrive::new(&Scenario { vehicles: 10, ..behind("a") }).unwrap().advisable(), Some(7));
    let none = Scenario::from_toml("traffic_leader = \"a\"", "x").unwrap_err().message;
    assert!(none.starts_with("x:1:18: traffic_leader is \"a\"; allowed: empty"), "{none}");
}
