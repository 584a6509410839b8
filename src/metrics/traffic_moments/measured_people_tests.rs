//! Moments of measured people against published and known values (docs/references.md: people). The data have licences of their own and
//! are not part of codrive: tests look for them in `../shared/data/people` or `CODRIVE_PEOPLE_DATA`, and are recorded as not run where they are
//! absent (`tests/not-run-here/people-data.txt`).

use super::*;
use std::{fs, io::Write as _, path::PathBuf, process::Command};

/// Environment variable with the folder of the data.
const DATA: &str = "CODRIVE_PEOPLE_DATA";
/// Environment variable with the path of a file that gets a line for each test that is not run here; see `tests/wheel/kernel.rs`.
const NOT_RUN: &str = "CODRIVE_TESTS_NOT_RUN";

/// Reads a file of the data through `scripts/measured-trajectories`; `None`, and a record of it with the test's module and name, where the
/// data are absent.
pub(crate) fn measured(file: &str, ring_m: Option<f64>, test: [&str; 2]) -> Option<VehicleTrajectories> {
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let folder = std::env::var_os(DATA).map_or_else(|| root.join("../shared/data/people"), PathBuf::from);
    if !folder.is_dir() {
        return not_run(test);
    }
    let made = Command::new("python3")
        .arg(root.join("scripts/measured-trajectories"))
        .arg(folder.join(file))
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let kept = tempfile::tempdir().unwrap();
    let path = kept.path().join("people.csv");
    fs::write(&path, made.stdout).unwrap();
    Some(read_trajectories(&path, ring_m).unwrap())
}

/// Records that a test is not run.
fn not_run<T>(test: [&str; 2]) -> Option<T> {
    let name = test.join("::");
    match std::env::var_os(NOT_RUN) {
        Some(file) => {
            let file = fs::OpenOptions::new().append(true).create(true).open(file);
            // One write, as tests beside this one write to the same file.
            file.and_then(|mut file| file.write_all(format!("people-data\t{name}\n").as_bytes())).unwrap();
        }
        None => {
            // The test runner captures the output of macros when a test passes.
            let line =
                format!("NOT RUN HERE: {name}, because there are no data of people; {DATA} names their folder\n");
            std::io::stderr().write_all(line.as_bytes()).unwrap();
        }
    }
    None
}

/// Checks that a value rounds to the known one: half a unit of its last digit, and a little for what a double cannot hold.
fn near(found: &TrafficMoments, name: &str, wanted: f64, digit: f64) {
    let value = found.get(name).unwrap_or_else(|| panic!("{name}"));
    assert!((value - wanted).abs() <= 0.5001 * digit, "{name}: {value}, known {wanted}");
}

#[test]
fn the_moments_of_experiment_a_are_the_known_ones() {
    let Some(all) = measured(
        "ared/ared_a_10hz.csv.gz",
        Some(260.0),
        [module_path!(), "the_moments_of_experiment_a_are_the_known_ones"],
    ) else {
        return;
    };
    let [from_s, to_s] = EXPERIMENT_A.from_to_s;
    let found = moments(&all.between(from_s, to_s));
    let known = [
        ("mean_speed_mps", 3.13, 0.01),
        ("speed_sd_over_vehicles_mps", 0.71, 0.01),
        ("speed_sd_growth_per_min", 0.08, 0.01),
        ("accel_sd_mps2", 0.29, 0.01),
        ("accel_p01_mps2", -0.81, 0.01),
        ("accel_p99_mps2", 0.80, 0.01),
        ("accel_kurtosis", 6.0, 0.1),
        ("brakings_per_km", 1.24, 0.01),
        ("standing_share", 0.0004, 0.0001),
        ("gap_p05_m", 4.0, 0.1),
        ("gap_p25_m", 5.9, 0.1),
        ("gap_median_m", 7.4, 0.1),
        ("gap_p75_m", 9.3, 0.1),
        ("gap_p95_m", 13.7, 0.1),
        ("smallest_gap_m", 1.94, 0.01),
        ("person_time_gap_s", 2.44, 0.01),
        ("shortest_person_time_gap_s", 1.66, 0.01),
        ("longest_person_time_gap_s", 4.38, 0.01),
        ("person_time_gap_ln_sd", 0.25, 0.01),
        ("person_accel_ln_sd", 0.27, 0.01),
        ("lag_s", 1.81, 0.01),
        ("shortest_person_lag_s", 1.25, 0.01),
        ("longest_person_lag_s", 2.82, 0.01),
        ("gain_at_0_03_hz", 0.94, 0.01),
        ("gain_at_0_06_hz", 0.82, 0.01),
        ("gain_at_0_1_hz", 0.66, 0.01),
        ("gain_at_0_15_hz", 0.49, 0.01),
        ("wave_speed_mps", -4.25, 0.01),
        ("wave_share", 0.48, 0.01),
        ("gap_split_half_r", 0.89, 0.01),
        ("time_gap_split_half_r", 0.87, 0.01),
        ("accel_split_half_r", 0.85, 0.01),
        ("noise_split_half_r", 0.82, 0.01),
        ("lag_split_half_r", 0.52, 0.01),
    ];
    known.iter().for_each(|(name, wanted, digit)| near(&found, name, *wanted, *digit));
    // The table of criteria has the same values, and people are like themselves.
    for judged in judge(&EXPERIMENT_A, &[found]) {
        let model = judged.model.unwrap();
        let close = (model - judged.people).abs() <= 0.01 * judged.people.abs().max(0.5) || judged.people == 0.0;
        assert!(close && judged.within != Some(false), "{judged:?}");
    }
}

#[test]
fn the_halves_of_experiment_a_are_in_the_table_of_criteria() {
    let Some(all) = measured(
        "ared/ared_a_10hz.csv.gz",
        Some(260.0),
        [module_path!(), "the_halves_of_experiment_a_are_in_the_table_of_criteria"],
    ) else {
        return;
    };
    let [from_s, to_s] = EXPERIMENT_A.from_to_s;
    let [first, second] = all.between(from_s, to_s).halves().map(|half| moments(&half));
    for criterion in EXPERIMENT_A.criteria {
        let Some([a, b]) = criterion.halves else { continue };
        let found = [&first, &second].map(|half| half.get(criterion.moment).unwrap());
        let close = |found: f64, known: f64| (found - known).abs() <= 0.01 * known.abs().max(0.5);
        assert!(close(found[0], a) && close(found[1], b), "{}: {found:?}", criterion.moment);
    }
}

#[test]
fn deviations_down_the_platoons_of_openacc_are_the_known_ones() {
    for (run, known) in ["run3", "run10"].into_iter().zip(OPENACC_SPEED_SD_MPS) {
        let file = format!("openacc_people/asta_040719_{run}_people_10hz.csv.gz");
        let Some(all) =
            measured(&file, None, [module_path!(), "deviations_down_the_platoons_of_openacc_are_the_known_ones"])
        else {
            return;
        };
        let found = platoon_speed_sd_mps(&all);
        assert_eq!(found.len(), 5);
        assert!(found[1..].iter().zip(known).all(|(found, known)| (found - known).abs() < 0.0051), "{run}: {found:?}");
    }
}
