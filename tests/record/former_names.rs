//! Files of 2026, written before settings and columns got the names of the field, are read as they were meant:
//! `bend_mps2` (`lateral_accel_mps2`), `trait_mps` (`speed_bias_mps`), `slack_mps` (`deadband_mps`), `calm_s`
//! (`last_disturbance_s`), and the drivers in numbers of recordings.

use super::{codrive, said};
use codrive::{
    driver::named,
    metrics::EvaluationResult,
    record::{Manifest, inputs},
    replay, settings,
    study::Study,
    traffic::NoiseStreams,
    train::TrainConfig,
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// A data set of one participant and one trial, recorded under the former names, and a training of that time.
fn earlier(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/earlier").join(name)
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() { copy(&entry.path(), &to) } else { fs::copy(entry.path(), &to).map(drop).unwrap() }
    }
}

#[test]
fn a_recording_of_2026_is_driven_again_with_what_it_was_driven_with() {
    let drive = earlier("study/sourcedata/sub-R01/trial-1-bends");
    assert!(fs::read_to_string(drive.join("scenario.toml")).unwrap().contains("bend_mps2 = 4.0"));
    let scenario = inputs::scenario(&drive).unwrap();
    assert_eq!(scenario.lateral_accel_mps2, 4.0);
    assert_eq!(Manifest::load(&drive).unwrap().lateral_accel_mps2, Some(4.0));
    let driver = named(&scenario.driver).unwrap().params;
    assert_eq!((driver.reaction_s, driver.speed_bias_mps, driver.deadband_mps), (1.0, 0.3, 0.1));
    let changes = replay::changes(&["bend_mps2=2.0".into(), "lateral-accel=2.0".into()]).unwrap();
    assert_eq!(changes[0], changes[1]);
}

#[test]
fn a_recording_of_2026_replays_to_the_bit() {
    // From before every car had a stream of noise of its own.
    let drive = earlier("study/sourcedata/sub-R01/trial-1-bends");
    assert_eq!(inputs::scenario(&drive).unwrap().noise_streams, NoiseStreams::Shared);
    let (code, text) = said(&mut codrive(&["replay", drive.to_str().unwrap()]));
    assert!(code == 0 && text.contains("all 200 ticks are the same to the bit"), "{code}: {text}");
}

#[test]
fn a_study_and_a_data_set_of_2026_are_read() {
    let study = Study::load(&earlier("study/study.toml")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(study.base.lateral_accel_mps2, 2.5);
    let codrive::study::PlanItem::Drive { scenario, .. } = &study.plan(0).items[0].item else { panic!("a drive") };
    assert_eq!(scenario.lateral_accel_mps2, 4.0, "the condition's");

    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    copy(&earlier("study"), &data);
    let (code, text) = said(&mut codrive(&["analyse", data.to_str().unwrap()]));
    assert!(code == 0 && !text.contains("warning") && !text.contains("changed since"), "{code}: {text}");
    let tables: Vec<String> = walk(&data);
    let trials = tables.iter().find(|name| name.ends_with("trials.csv")).unwrap_or_else(|| panic!("{tables:?}"));
    let trials = fs::read_to_string(trials).unwrap();
    assert!(trials.contains("last_disturbance_s") && !trials.contains("calm_after_s"), "{trials}");
}

fn walk(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| if path.is_dir() { walk(&path) } else { vec![path.to_string_lossy().into_owned()] })
        .collect()
}

#[test]
fn a_training_of_2026_has_the_driver_that_it_names_and_its_flags_are_taken() {
    let config: TrainConfig = settings::from_file(&earlier("train.toml")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((config.driver.speed_bias_mps, config.driver.deadband_mps), (0.3, 0.1));
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("judged");
    let (old, out) = (earlier("train.toml"), out.to_str().unwrap());
    let flags =
        ["--vehicles-min", "8", "--vehicles-max", "8", "--warm-up", "1", "--horizon", "2", "--random-driver=false"];
    let words = ["evaluate", "--config", old.to_str().unwrap(), "--policy", "none", "--over", "2", "--holds", "1"];
    let former = ["--trait", "0.2", "--slack", "0.4", "--least-spacing", "0", "--out", out];
    let (code, text) = said(&mut codrive(&[&words[..], &flags, &former].concat()));
    assert_eq!(code, 0, "{text}");
    let written = fs::read_to_string(Path::new(out).join("config.toml")).unwrap();
    assert!(written.contains("speed_bias_mps = 0.2") && written.contains("deadband_mps = 0.4"), "{written}");
    let rings = fs::read_to_string(Path::new(out).join("rings.csv")).unwrap();
    assert!(rings.lines().next().unwrap().contains(",last_disturbance_s,"), "{rings}");
}

#[test]
fn a_result_of_an_evaluation_of_2026_is_read() {
    let text = r#"{"mean_mps":4.3,"settled_mps":4.4,"sd_over_cars_mps":0.6,"sd_in_time_mps":0.5,"calm_s":85.0,"least_gap_m":1.0,
        "crashed":false,"crash_s":null,"fuel_l_100km":6.5,"throughput_per_h":1300.0,"in_range":null}"#;
    assert_eq!(serde_json::from_str::<EvaluationResult>(text).unwrap().last_disturbance_s, Some(85.0));
}
