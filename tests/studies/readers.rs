//! The data set of a rehearsed study in outside readers: pandas and R read every table by its sidecar, MNE-BIDS finds the participants, MNE
//! reads the motion, and hedtools accepts the tags. Export and erasure of a participant include the motion.

use crate::{
    bids::{self, BidsFixture, outside},
    common::{table, text},
};
use codrive::record::{Manifest, Table, TableReader};
use serde_json::Value;
use std::{collections::BTreeMap, fs, path::Path};

/// Runs a script of `tests/studies/readers` on a data set and returns its standard output.
fn read(program: &str, script: &str, data: &Path) -> String {
    let scratch = tempfile::tempdir().unwrap();
    let script = bids::root().join("tests/studies/readers").join(script);
    // MNE keeps its settings in the home folder.
    let output = outside(program).env("HOME", scratch.path()).arg(script).arg(data).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    String::from_utf8(output.stdout).unwrap()
}

fn printed(script: &str, data: &Path) -> Value {
    serde_json::from_str(&read("python3", script, data)).unwrap()
}

/// Returns the drives of a participant: name of the motion table, and path of the recording.
fn drives(data: &Path, subject: &str) -> Vec<(String, std::path::PathBuf)> {
    let rows = table(&data.join(format!("{subject}/{subject}_scans.tsv")));
    let of_drive = rows.into_iter().filter(|row| row["recording"] != "n/a");
    of_drive.map(|row| (format!("{subject}/{}", row["filename"]), data.join(&row["recording"]))).collect()
}

#[test]
fn pandas_and_r_read_every_table_and_find_the_recorded_motion() {
    let place = BidsFixture::rehearsed(4.0, 2);
    let data = place.data();
    let pandas = printed("read_tables.py", &data);
    let r = read("Rscript", "read_tables.R", &data);
    let by_r: BTreeMap<&str, Vec<f64>> = r
        .lines()
        .filter_map(|line| line.strip_prefix("motion "))
        .map(|line| line.split_once(' ').unwrap())
        .map(|(name, rest)| (name, rest.split_whitespace().map(|word| word.parse().unwrap()).collect()))
        .collect();
    let recorded: Vec<_> = ["sub-R01", "sub-R02"].iter().flat_map(|subject| drives(&data, subject)).collect();
    assert_eq!((recorded.len(), by_r.len(), pandas["motion"].as_object().unwrap().len()), (8, 8, 8));
    for (name, recording) in &recorded {
        let ego = TableReader::parquet(&Table::Ego.parquet(recording)).unwrap();
        let speeds = ego.numbers("speed_mps");
        let mean = speeds.iter().map(|speed| speed.unwrap()).sum::<f64>() / speeds.len() as f64;
        for (rows, speed) in [
            (pandas["motion"][name][0].as_f64().unwrap(), pandas["motion"][name][1].as_f64().unwrap()),
            (by_r[name.as_str()][0], by_r[name.as_str()][1]),
        ] {
            // Every speed is rounded to 0.1 mm/s, so the mean of the speeds is off by at most half of that.
            assert!(rows == speeds.len() as f64 && (speed - mean).abs() < 5e-5, "{name}: {rows} {speed} {mean}");
        }
    }
    // Participants and two questionnaires; per participant scans, 2 sets of responses, and for each of 4 drives two tables of events and
    // one of channels.
    let others = 1 + 2 + 2 * (1 + 2 + 4 * 3);
    assert!(r.contains(&format!("others {others} \n")), "{r}");
    assert_eq!(pandas["tables"], others + 8);
}

#[test]
fn dates_are_shifted_by_years_and_times_between_files_stay_true() {
    let place = BidsFixture::rehearsed(4.0, 2);
    let data = place.data();
    let times = printed("read_tables.py", &data)["times"].clone();
    let at = |time: &str| time.parse::<jiff::Timestamp>().unwrap().as_second();
    for subject in ["sub-R01", "sub-R02"] {
        let log: Value =
            serde_json::from_slice(&fs::read(data.join(format!("sourcedata/{subject}/session.json"))).unwrap())
                .unwrap();
        let answered = log["item_runs"].as_array().unwrap().iter().find(|p| p["item"] == "ssq-before").unwrap();
        let answers =
            (format!("{subject}/beh/{subject}_task-ssqBefore_beh.tsv"), at(answered["began"].as_str().unwrap()));
        let mut true_times: Vec<(String, i64)> = drives(&data, subject)
            .into_iter()
            .map(|(name, recording)| (name, at(&Manifest::load(&recording).unwrap().began)))
            .collect();
        true_times.push(answers);
        let shifts: Vec<i64> = true_times.iter().map(|(name, t)| at(times[name].as_str().unwrap()) - t).collect();
        assert!(shifts.iter().all(|shift| *shift == shifts[0] && shift % 86_400 == 0), "{subject}: {shifts:?}");
        for (name, _) in &true_times {
            let year: i32 = times[name].as_str().unwrap()[..4].parse().unwrap();
            assert!((1902..1925).contains(&year), "{name}: {year}");
        }
    }
}

#[test]
fn mne_bids_finds_participants_and_runs_and_mne_reads_the_motion() {
    let place = BidsFixture::rehearsed(4.0, 2);
    let data = place.data();
    let mne = printed("read_mne.py", &data);
    assert_eq!(mne["subjects"], serde_json::json!(["R01", "R02"]));
    assert_eq!(mne["tasks"], serde_json::json!(["experience", "practice", "ssqBefore", "trial"]));
    assert_eq!(mne["runs"], serde_json::json!(["1", "2", "3"]));
    assert_eq!(mne["events"].as_array().unwrap().len(), 4, "{mne}");
    let report = mne["report"].as_str().unwrap();
    assert!(report.contains("Short") && report.contains("2 participants"), "{report}");
    let motion = mne["motion"].as_array().unwrap();
    assert_eq!(motion.len(), 4);
    for (read, (name, recording)) in motion.iter().zip(drives(&data, "sub-R01")) {
        assert_eq!(read["tracking_system"], "codrive");
        assert!(name.contains(&format!("_task-{}_", read["task"].as_str().unwrap())), "{name} {read}");
        let rows = |table: Table| TableReader::parquet(&table.parquet(&recording)).unwrap().rows();
        assert_eq!(
            (&read["samples"], &read["advice"]),
            (&rows(Table::Ego).into(), &rows(Table::Advice).into()),
            "{name}"
        );
        assert!((1902..1925).contains(&read["year"].as_i64().unwrap()), "{read}");
        // The first sample is at tick 1; the first advice is at tick 0.
        assert_eq!(read["first_event"], -0.01, "{name}");
    }
}

#[test]
fn hedtools_accepts_the_tags_of_every_row_and_finds_an_unknown_tag() {
    let place = BidsFixture::rehearsed(4.0, 1);
    assert_eq!(read("python3", "check_hed.py", &place.data()), "");
    let path = place.data().join("events.json");
    let whole = fs::read_to_string(&path).unwrap();
    fs::write(&path, whole.replace("Visual-presentation", "Seen-somehow")).unwrap();
    let found = read("python3", "check_hed.py", &place.data());
    assert!(found.contains("TAG_INVALID") && found.contains("Seen-somehow"), "{found}");
}

#[test]
fn export_and_erasure_of_a_participant_include_motion_and_dates() {
    let place = BidsFixture::rehearsed(4.0, 2);
    let data = place.data();
    let given = data.with_file_name("given");
    let files_of = |root: &Path, subject: &str| {
        let mut names: Vec<String> = ["motion", "beh", ""]
            .iter()
            .flat_map(|folder| fs::read_dir(root.join(subject).join(folder)).into_iter().flatten().flatten())
            .filter(|entry| entry.path().is_file())
            .map(|entry| entry.file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    let study = data.with_file_name("short.toml");
    let study_command = |step: &str, last: [&str; 3]| {
        let output = crate::common::codrive(
            &[&["study", step, study.to_str().unwrap(), "--from", data.to_str().unwrap()][..], &last].concat(),
            "warn",
        );
        assert!(output.status.success(), "{}", text(&output));
    };
    study_command("export", ["R01", "--to", given.to_str().unwrap()]);
    let names = files_of(&data, "sub-R01");
    // For each of 4 drives: motion, its events and both sidecars, channels, and events with sidecar. For each of 2 questionnaires:
    // responses and sidecar. Then scans and their sidecar.
    assert_eq!((names.len(), names.clone()), (4 * 5 + 4 * 2 + 2 * 2 + 2, files_of(&given, "sub-R01")));
    for (name, recording) in drives(&data, "sub-R01") {
        assert_eq!(fs::read(data.join(&name)).unwrap(), fs::read(given.join(&name)).unwrap(), "{name}");
        assert!(recording.join("ego.parquet").exists());
    }
    let shift = "sourcedata/sub-R01/date-shift.json";
    assert_eq!(fs::read(data.join(shift)).unwrap(), fs::read(given.join(shift)).unwrap());
    let (found, subjects, _) = bids::errors(&given);
    assert!(found.is_empty() && subjects == 1, "{found:#?}");

    // The list has their checksums; erasing the participant removes them from it.
    let sums = |name: &str| fs::read_to_string(data.join("SHA256SUMS")).unwrap().matches(name).count();
    assert_eq!((sums("sub-R01_task-trial_tracksys-codrive_run-2_motion.tsv"), sums("sub-R01/date-shift.json")), (1, 1));
    let others = files_of(&data, "sub-R02");
    study_command("erase", ["R01", "--reason", "asked for it"]);
    assert!(!data.join("sub-R01").exists() && !data.join("sourcedata/sub-R01").exists());
    assert_eq!((sums("sub-R01"), files_of(&data, "sub-R02")), (0, others));
    let (found, subjects, _) = bids::errors(&data);
    assert!(found.is_empty() && subjects == 1, "{found:#?}");
    // The analysis reports no missing and no changed file.
    assert_eq!(place.codrive(&["analyse"]), "");
    // Motion can be made again from the recordings, and an analysis does not need it.
    fs::remove_dir_all(data.join("sub-R02/motion")).unwrap();
    let output = crate::common::codrive(&["analyse", "--accept-changes", data.to_str().unwrap()], "warn");
    let report = data.join("derivatives/codrive/report.html");
    assert!(output.status.code() == Some(1) && report.exists(), "{}", text(&output));
}
