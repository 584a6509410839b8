//! Files of format 1 are read for ever: a recording, a study and a scenario as this format's first version wrote them.

use super::printed;
use codrive::{replay::Replay, scenario::Scenario, study::Study};
use std::{fs, path::Path};

fn written(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/format-1").join(name)
}

#[test]
fn a_recording_of_format_1_is_proven() {
    let folder = tempfile::tempdir().unwrap();
    // A copy: a replay locks what it reads.
    for entry in fs::read_dir(written("recording")).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let mut replay = Replay::open(folder.path()).unwrap();
    replay.advance(u64::MAX).unwrap();
    let report = replay.report();
    assert!(report.is_proven() && report.ticks == 200 && report.facts.is_empty(), "{report:?}");
}

#[test]
fn every_setting_of_a_scenario_of_format_1_is_read() {
    let text = fs::read_to_string(written("scenario.toml")).unwrap();
    let scenario = Scenario::from_file(&written("scenario.toml")).unwrap();
    assert_eq!((scenario.seed, scenario.vehicles, scenario.policy.as_str()), (7, 12, "pi"));
    let again = scenario.to_toml();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        assert!(again.lines().any(|own| own == line), "{line} is lost");
    }
}

#[test]
fn a_study_of_format_1_is_read() {
    let study = Study::load(&written("study.toml")).unwrap();
    let names: Vec<&str> = study.conditions.iter().map(|condition| condition.name.as_str()).collect();
    assert_eq!(names, ["none+narrow", "none+wide", "pi+narrow", "pi+wide"]);
    assert_eq!((study.file.participants, study.base.vehicles, study.file.segment.len()), (4, 12, 3));
}

#[test]
fn another_format_is_refused_with_file_place_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    for (name, arguments) in [("scenario.toml", ["run", "--scenario"]), ("study.toml", ["study", "check"])] {
        let text = fs::read_to_string(written(name)).unwrap().replace("format = 1\n", "format = 2\n");
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let mut command = super::codrive(&arguments);
        let (code, words) = printed(command.arg(&path));
        assert_eq!(code, 2, "{words}");
        for part in [name, "the file has format 2; allowed: 1", "remedy: use the program that wrote it"] {
            assert!(words.contains(part), "{words}");
        }
    }
}
