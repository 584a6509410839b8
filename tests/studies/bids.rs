//! The data set of a rehearsed study, read by outside programs: the BIDS validator, and the shipped scripts for pandas and R as an analyst
//! would run them. `scripts/setup --test` installs all three.

use crate::common::text;
use serde_json::Value;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// A rehearsed study in a temporary folder.
pub struct BidsFixture {
    folder: tempfile::TempDir,
}

impl BidsFixture {
    /// Rehearses a study with trials of this length, s.
    pub fn rehearsed(duration_s: f64, participants: usize) -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        let study = place.folder.path().join("short.toml");
        fs::write(&study, crate::common::study(duration_s, 10.0, ["experience", "driving-experience"])).unwrap();
        let participants = participants.to_string();
        place.codrive(&["study", "rehearse", study.to_str().unwrap(), "--participants", &participants, "--out"]);
        place
    }

    pub fn data(&self) -> PathBuf {
        self.folder.path().join("data")
    }

    /// Runs the program with these arguments and the data set. Returns its standard error.
    pub fn codrive(&self, arguments: &[&str]) -> String {
        let output = crate::common::codrive(&[arguments, &[self.data().to_str().unwrap()]].concat(), "warn");
        assert!(output.status.success(), "{}", text(&output));
        String::from_utf8_lossy(&output.stderr).into_owned()
    }

    fn script(&self, program: &str, script: &str) -> String {
        self.script_into(program, script, None)
    }

    /// Runs a shipped script on the data set, with `out` as its second argument if it writes tables. Returns its output.
    fn script_into(&self, program: &str, script: &str, out: Option<&Path>) -> String {
        let script = root().join("assets/analysis").join(script);
        let output = outside(program).arg(script).arg(self.data()).args(out).output();
        let output = output.unwrap_or_else(|e| panic!("{program}: {e}; scripts/setup --test installs it"));
        assert!(output.status.success(), "{}", text(&output));
        text(&output)
    }

    /// Returns the rows of an analysis table, keyed by column name.
    fn rows(&self, name: &str) -> Vec<BTreeMap<String, String>> {
        crate::common::table(&self.data().join("derivatives/codrive").join(name))
    }
}

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the command of a program with the Python packages that `scripts/setup --test` installed.
pub fn outside(program: &str) -> Command {
    let place = root().join(".test-python");
    assert!(place.join("wanted").exists(), ".test-python/ is not there; run scripts/setup --test");
    let mut command = Command::new(program);
    command.env("PYTHONPATH", &place).env("NO_COLOR", "1").env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// Returns the validator's report of a data set.
fn issues(data: &Path) -> Value {
    let arguments = ["-c", "from bids_validator_deno import cli; cli()", "--format", "json", "--max-rows", "-1"];
    let output = outside("python3").args(arguments).arg(data).output().unwrap();
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", text(&output)))
}

/// Returns the validator's errors of a data set, and the number of participants and of files that it saw.
pub fn errors(data: &Path) -> (Vec<String>, usize, u64) {
    let report = issues(data);
    let issues = report["issues"]["issues"].as_array().unwrap();
    let found = issues.iter().filter(|issue| issue["severity"] == "error").map(Value::to_string).collect();
    let subjects = report["summary"]["subjects"].as_array().unwrap().len();
    (found, subjects, report["summary"]["totalFiles"].as_u64().unwrap())
}

/// Validator warnings that remain, each with its reason. They concern recommended entries that only the laboratory knows, or that do not
/// exist here.
const WARNINGS: [(&str, &str, &str); 8] = [
    ("JSON_KEY_RECOMMENDED", "License", "`licence` of the study's file, which the study of this test has not"),
    ("TOO_FEW_AUTHORS", "", "`authors` of the study's file, which the study of this test has not"),
    (
        "SIDECAR_KEY_RECOMMENDED",
        "InstitutionName",
        "`institution` of the study's file, which the study of this test has not",
    ),
    (
        "SIDECAR_KEY_RECOMMENDED",
        "InstitutionAddress",
        "the study's file does not ask for it: the name is enough to be found",
    ),
    ("SIDECAR_KEY_RECOMMENDED", "InstitutionalDepartmentName", "as the address"),
    (
        "SIDECAR_KEY_RECOMMENDED",
        "DeviceSerialNumber",
        "what tracks is a program: its version is in the sidecar, and it has no number",
    ),
    ("SIDECAR_KEY_RECOMMENDED", "CogAtlasID", "the Cognitive Atlas has no task of driving with advice"),
    ("SIDECAR_KEY_RECOMMENDED", "CogPOID", "neither has the Cognitive Paradigm Ontology"),
];

#[test]
fn the_bids_validator_finds_no_error_and_scripts_read_data_without_events() {
    let place = BidsFixture::rehearsed(4.0, 3);
    let (found, subjects, files) = errors(&place.data());
    assert!(found.is_empty(), "{found:#?}");
    // Four files: description, readme, participants and their sidecar. Two questionnaires have a table and a sidecar each; two sidecars are
    // of events and channels. Each participant has scans, 4 drives and 2 sets of responses with a sidecar each; each drive also has motion
    // and its events with a sidecar each, and channels.
    assert_eq!((subjects, files), (3, 4 + 4 + 2 + 3 * (2 * (1 + 4 + 2) + 4 * (2 + 2 + 1))));
    let report = issues(&place.data());
    let key = |issue: &Value| ["code", "subCode"].map(|key| issue[key].as_str().unwrap_or_default().to_owned());
    let printed: BTreeSet<[String; 2]> = report["issues"]["issues"].as_array().unwrap().iter().map(key).collect();
    let explained = WARNINGS.map(|(code, sub, _)| [code.to_owned(), sub.to_owned()]);
    assert_eq!(printed, BTreeSet::from(explained), "warnings that are not explained, or explained and not there");
    // Result folders beside the data are not part of BIDS.
    for folder in ["report", "analysis"] {
        fs::create_dir(place.data().join(folder)).unwrap();
        fs::write(place.data().join(folder).join("report.html"), "none of BIDS").unwrap();
    }
    let printed = place.codrive(&["analyse"]);
    assert_eq!(printed, "", "an analysis without any reaction has nothing to complain of");
    for (folder, what) in [("", "with derivatives"), ("derivatives/codrive", "the derivatives themselves")] {
        let (found, ..) = errors(&place.data().join(folder));
        assert!(found.is_empty(), "{what}: {found:#?}");
    }

    assert!(place.rows("advice.csv").iter().all(|row| row["reaction_s"].is_empty()), "too short for a reaction");
    let pandas = place.script("python3", "read_study.py");
    assert!(pandas.contains("3 participants, 9 trials"), "{pandas}");
    let r = place.script("Rscript", "read_study.R");
    assert!(r.contains("3 participants, 9 trials") && r.contains("too few observations for a model: 0 of 0"), "{r}");

    // The validator does detect faults: events without onset, motion without sampling rate, and a tag that HED does not have.
    let motion = "sub-R02/motion/sub-R02_task-trial_tracksys-codrive_run-2_motion.json";
    for (file, from, to, printed) in [
        ("sub-R01/beh/sub-R01_task-trial_run-1_events.tsv", "onset", "when", "sub-R01_task-trial_run-1_events.tsv"),
        (motion, "\"SamplingFrequency\"", "\"Rate\"", "SamplingFrequency"),
        ("events.json", "Collide-with", "Bump-into", "HED"),
    ] {
        let path = place.data().join(file);
        let whole = fs::read_to_string(&path).unwrap();
        assert!(whole.contains(from), "{file}: {whole}");
        fs::write(&path, whole.replacen(from, to, 1)).unwrap();
        let (found, ..) = errors(&place.data());
        assert!(found.iter().any(|error| error.contains(printed)), "{file}: {found:#?}");
        fs::write(&path, whole).unwrap();
    }
}

#[test]
fn pandas_and_r_find_the_means_of_the_table_of_trials() {
    let place = BidsFixture::rehearsed(30.0, 4);
    place.codrive(&["analyse"]);
    let trials: Vec<_> = place.rows("trials.csv").into_iter().filter(|row| !row["condition"].is_empty()).collect();
    assert_eq!(trials.len(), 12);
    let [pandas, r] =
        [("python3", "read_study.py"), ("Rscript", "read_study.R")].map(|(program, name)| place.script(program, name));
    for printed in [&pandas, &r] {
        assert!(printed.contains("4 participants, 12 trials"), "{printed}");
    }
    // The conditions are in the study's order: columns in pandas, rows in R.
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
    // Both scripts fitted a model, and pandas joined a recording of 30 s to its advice.
    assert!(pandas.contains("Mixed Linear Model") && pandas.contains("3000 ticks"), "{pandas}");
    assert!(r.contains("Satterthwaite") && r.contains("== reaction_s =="), "{r}");
}

#[test]
fn one_participant_is_read_and_reported_as_too_few() {
    let place = BidsFixture::rehearsed(4.0, 1);
    place.codrive(&["analyse"]);
    // A missing output folder is created.
    let out = place.data().with_file_name("new").join("tables");
    let pandas = place.script_into("python3", "read_study.py", Some(&out));
    assert!(pandas.contains("1 participants, 3 trials") && pandas.contains("too few participants"), "{pandas}");
    assert!(out.join("paired_differences.csv").exists() && out.join("trials_with_participants.csv").exists());
    let about = fs::read(place.data().join("derivatives/codrive/dataset_description.json")).unwrap();
    let about: serde_json::Value = serde_json::from_slice(&about).unwrap();
    assert_eq!((&about["DatasetType"], &about["GeneratedBy"][0]["Name"]), (&"derivative".into(), &"codrive".into()));
    let source = about["SourceDatasets"][0]["URL"].as_str().unwrap();
    let source = place.data().join("derivatives/codrive").join(source).join("participants.tsv");
    assert!(source.is_file(), "{}", source.display());
    let r = place.script("Rscript", "read_study.R");
    assert!(r.contains("too few observations for a model: 3 of 1 participants in 3 conditions"), "{r}");
}
