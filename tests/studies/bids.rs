//! The data set of a rehearsed study before judges from outside: the validator of BIDS, and the shipped scripts for pandas and
//! R, as whoever analyses it would run them. `scripts/setup --test` installs all three.

use crate::common::text;
use serde_json::Value;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// The study with trials of this length, rehearsed.
    fn rehearsed(duration_s: f64, participants: usize) -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        let study = place.folder.path().join("short.toml");
        fs::write(&study, crate::common::study(duration_s, 10.0, ["experience", "driving-experience"])).unwrap();
        let participants = participants.to_string();
        place.codrive(&["study", study.to_str().unwrap(), "--rehearse", "--participants", &participants, "--out"]);
        place
    }

    fn data(&self) -> PathBuf {
        self.folder.path().join("data")
    }

    /// The program with these arguments and the data set. What it said on standard error.
    fn codrive(&self, arguments: &[&str]) -> String {
        let output = crate::common::codrive(&[arguments, &[self.data().to_str().unwrap()]].concat(), "warn");
        assert!(output.status.success(), "{}", text(&output));
        String::from_utf8_lossy(&output.stderr).into_owned()
    }

    fn script(&self, program: &str, script: &str) -> String {
        self.script_into(program, script, None)
    }

    /// The same with its second argument, where it writes tables.
    fn script_into(&self, program: &str, script: &str, out: Option<&Path>) -> String {
        let script = root().join("assets/analysis").join(script);
        let output = outside(program).arg(script).arg(self.data()).args(out).output();
        let output = output.unwrap_or_else(|e| panic!("{program}: {e}; scripts/setup --test installs it"));
        assert!(output.status.success(), "{}", text(&output));
        text(&output)
    }

    /// Rows of a table of the analysis by its columns' names.
    fn rows(&self, name: &str) -> Vec<BTreeMap<String, String>> {
        crate::common::table(&self.data().join("derivatives/codrive").join(name))
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A program with what `scripts/setup --test` installed for Python.
fn outside(program: &str) -> Command {
    let place = root().join(".test-python");
    assert!(place.join("wanted").exists(), ".test-python/ is not there; run scripts/setup --test");
    let mut command = Command::new(program);
    command.env("PYTHONPATH", &place).env("NO_COLOR", "1").env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// Errors that the validator finds in a data set; and how many participants and files it saw.
pub fn errors(data: &Path) -> (Vec<String>, usize, u64) {
    let arguments = ["-c", "from bids_validator_deno import cli; cli()", "--format", "json", "--max-rows", "-1"];
    let output = outside("python3").args(arguments).arg(data).output().unwrap();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", text(&output)));
    let issues = report["issues"]["issues"].as_array().unwrap();
    let found = issues.iter().filter(|issue| issue["severity"] == "error").map(Value::to_string).collect();
    let subjects = report["summary"]["subjects"].as_array().unwrap().len();
    (found, subjects, report["summary"]["totalFiles"].as_u64().unwrap())
}

#[test]
fn the_validator_of_bids_finds_no_error_and_the_scripts_read_what_has_no_reactions() {
    let place = Place::rehearsed(4.0, 3);
    let (found, subjects, files) = errors(&place.data());
    assert!(found.is_empty(), "{found:#?}");
    // Description, readme, participants and their sidecar, as much of two questionnaires; for each participant scans, 4 drives
    // and 2 answers with a sidecar each.
    assert_eq!((subjects, files), (3, 4 + 4 + 3 * 2 * (1 + 4 + 2)));
    let said = place.codrive(&["analyse"]);
    assert_eq!(said, "", "an analysis without any reaction has nothing to complain of");
    let (found, ..) = errors(&place.data());
    assert!(found.is_empty(), "with derivatives: {found:#?}");

    assert!(place.rows("advice.csv").iter().all(|row| row["reaction_s"].is_empty()), "too short for a reaction");
    let pandas = place.script("python3", "read_study.py");
    assert!(pandas.contains("3 participants, 9 trials"), "{pandas}");
    let r = place.script("Rscript", "read_study.R");
    assert!(r.contains("3 participants, 9 trials") && r.contains("too few observations for a model: 0 of 0"), "{r}");

    // The judge is awake: events without their onset are no events.
    let events = place.data().join("sub-R01/beh/sub-R01_task-trial_run-1_events.tsv");
    fs::write(&events, fs::read_to_string(&events).unwrap().replacen("onset", "when", 1)).unwrap();
    let (found, ..) = errors(&place.data());
    assert!(found.iter().any(|error| error.contains("sub-R01_task-trial_run-1_events.tsv")), "{found:#?}");
}

#[test]
fn pandas_and_r_find_the_means_that_stand_in_the_table_of_trials() {
    let place = Place::rehearsed(30.0, 4);
    place.codrive(&["analyse"]);
    let trials: Vec<_> = place.rows("trials.csv").into_iter().filter(|row| !row["condition"].is_empty()).collect();
    assert_eq!(trials.len(), 12);
    let [pandas, r] =
        [("python3", "read_study.py"), ("Rscript", "read_study.R")].map(|(program, name)| place.script(program, name));
    for said in [&pandas, &r] {
        assert!(said.contains("4 participants, 12 trials"), "{said}");
    }
    // The conditions in the study's order, by pandas as columns, by R as rows.
    let row = pandas.lines().find(|line| line.starts_with("mean_speed_mps  mean")).expect(&pandas);
    let by_pandas: Vec<f64> = row.split_whitespace().skip(2).map(|word| word.parse().unwrap()).collect();
    for (place, condition) in ["narrow", "middle", "wide"].into_iter().enumerate() {
        let of = trials.iter().filter(|row| row["condition"] == condition);
        let speeds: Vec<f64> = of.map(|row| row["mean_speed_mps"].parse().unwrap()).collect();
        assert_eq!(speeds.len(), 4, "{condition}");
        let mean = speeds.iter().sum::<f64>() / 4.0;
        assert!((by_pandas[place] - mean).abs() < 0.0006, "{condition}: {} {mean}", by_pandas[place]);
        // R numbers its rows: "1    narrow     3.79...".
        let row = r.lines().find(|line| line.split_whitespace().nth(1) == Some(condition)).expect(&r);
        let by_r: f64 = row.split_whitespace().nth(2).unwrap().parse().unwrap();
        assert!((by_r - mean).abs() < 1e-4, "{condition}: {by_r} {mean}");
    }
    // Each fitted a model, and pandas joined a recording of 30 s to its advices.
    assert!(pandas.contains("Mixed Linear Model") && pandas.contains("3000 ticks"), "{pandas}");
    assert!(r.contains("Satterthwaite") && r.contains("== reaction_s =="), "{r}");
}

#[test]
fn one_participant_is_read_and_said_to_be_too_few() {
    let place = Place::rehearsed(4.0, 1);
    place.codrive(&["analyse"]);
    // A folder that is not there is made.
    let out = place.data().with_file_name("new").join("tables");
    let pandas = place.script_into("python3", "read_study.py", Some(&out));
    assert!(pandas.contains("1 participants, 3 trials") && pandas.contains("too few participants"), "{pandas}");
    assert!(out.join("paired_differences.csv").exists() && out.join("trials_with_participants.csv").exists());
    let about = fs::read(place.data().join("derivatives/codrive/dataset_description.json")).unwrap();
    let about: serde_json::Value = serde_json::from_slice(&about).unwrap();
    assert_eq!((&about["DatasetType"], &about["GeneratedBy"][0]["Name"]), (&"derivative".into(), &"codrive".into()));
    let r = place.script("Rscript", "read_study.R");
    assert!(r.contains("too few observations for a model: 3 of 1 participants in 3 conditions"), "{r}");
}
