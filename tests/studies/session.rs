//! A rehearsed study: every order equally often, a data set with complete files, a cut that costs one drive, the same bits for the same
//! seed, and a message for each fault.

use crate::common::table;
use codrive::{
    record::{Table, TableReader},
    study::{
        DataSet, ItemOutcome, ParticipantCode, Session, SessionError, Study,
        session::{ParticipantKind, SessionLog},
    },
};
use serde_json::{Value, json};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};

/// Returns the text of the study of these tests.
fn short() -> String {
    let authors = "authors = [\"A. Lead\", \"B. Second\"]\nlicence = \"CC0\"\ninstitution = \"A laboratory\"\n";
    authors.to_owned() + &crate::common::study(6.0, 30.0, ["workload", "raw-tlx"])
}

fn study() -> Study {
    Study::parse(short(), Path::new("short.toml")).unwrap_or_else(|e| panic!("{e}"))
}

fn codrive(arguments: &[&str]) -> (i32, String) {
    let output = crate::common::codrive(arguments, "error");
    (output.status.code().unwrap(), crate::common::text(&output))
}

/// Returns a temporary folder with the study file, that file's path, and the path of the data set.
fn place() -> (tempfile::TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("short.toml"), folder.path().join("data"));
    fs::write(&file, short()).unwrap();
    (folder, file, out)
}

fn rehearse(file: &Path, out: &Path, participants: &str) -> (i32, String) {
    let [file, out] = [file, out].map(|path| path.to_str().unwrap());
    codrive(&["study", "rehearse", file, "--participants", participants, "--out", out])
}

/// Returns the paths of all files below a folder, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut list = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { list.extend(files(&path)) } else { list.push(path) }
    }
    list.sort();
    list
}

#[test]
fn six_participants_meet_every_order_once_and_the_data_set_is_complete() {
    let (_folder, file, out) = place();
    let (code, text) = rehearse(&file, &out, "6");
    assert!(code == 0 && text.contains("6 of 6 participants completed the study"), "{text}");

    let participants = table(&out.join("participants.tsv"));
    let orders: BTreeSet<&String> = participants.iter().map(|row| &row["order"]).collect();
    assert_eq!(orders.len(), 6, "Williams' square of three conditions has six orders: {orders:?}");
    assert!(participants.iter().all(|row| row["state"] == "complete" && row["kind"] == "simulated"));

    // The readme explains the data set, its study and its folders.
    let readme = fs::read_to_string(out.join("README.md")).or_else(|_| fs::read_to_string(out.join("README"))).unwrap();
    for has in ["# Short\n", "participants.tsv", "phenotype/", "sourcedata/", "study.toml", "codrive analyse"] {
        assert!(readme.contains(has), "{has}: {readme}");
    }
    let about: Value = serde_json::from_slice(&fs::read(out.join("dataset_description.json")).unwrap()).unwrap();
    assert_eq!((&about["Name"], &about["DatasetType"]), (&Value::from("Short"), &Value::from("raw")));
    assert_eq!((&about["Authors"], &about["License"]), (&json!(["A. Lead", "B. Second"]), &Value::from("CC0")));
    let sidecar = fs::read(out.join("sub-R01/beh/sub-R01_task-trial_run-1_events.json")).unwrap();
    let sidecar: Value = serde_json::from_slice(&sidecar).unwrap();
    assert_eq!(sidecar["InstitutionName"], "A laboratory");
    // Raw TLX: six ratings in steps of 5, and their mean.
    let workload = table(&out.join("phenotype/workload.tsv"));
    assert_eq!(workload.len(), 6);
    let rated = ["mental", "physical", "temporal", "performance", "effort", "frustration"];
    for row in &workload {
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        assert!(rated.iter().all(|name| (0.0..=100.0).contains(&number(name)) && number(name) % 5.0 == 0.0), "{row:?}");
        let mean = rated.iter().map(|name| number(name)).sum::<f64>() / 6.0;
        assert!((number("score_raw-tlx") - mean).abs() < 1e-6, "{row:?}");
    }
    let sidecar: Value = serde_json::from_slice(&fs::read(out.join("phenotype/workload.json")).unwrap()).unwrap();
    let tool = sidecar["MeasurementToolMetadata"]["Description"].as_str().unwrap();
    assert!(tool.starts_with("How demanding was the drive? NASA Task Load Index"), "{tool}");
    let mental = sidecar["mental"]["Description"].as_str().unwrap();
    assert!(mental.contains("From 0") && mental.contains("to 100"), "{mental}");
    let sickness: Value = serde_json::from_slice(&fs::read(out.join("phenotype/ssq_before.json")).unwrap()).unwrap();
    let levels = sickness.as_object().unwrap().values().find_map(|column| column["Levels"].as_object()).unwrap();
    assert_eq!(levels.keys().collect::<Vec<_>>(), ["0", "1", "2", "3"], "none, slight, moderate, severe");

    // Every table has a sidecar that describes each of its columns; only the user can read the files.
    for path in files(&out) {
        let mode = fs::metadata(&path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode & 0o077, 0, "{}: {mode:o}", path.display());
        // Motion has no header row, and BIDS itself describes its channels (tests/studies/readers).
        if path.extension().is_some_and(|e| e == "tsv") && !path.parent().unwrap().ends_with("motion") {
            let is_events = path.file_name().unwrap().to_str().unwrap().ends_with("_events.tsv");
            let sidecar = if is_events { out.join("events.json") } else { path.with_extension("json") };
            let sidecar: Value = serde_json::from_slice(&fs::read(sidecar).unwrap()).unwrap();
            for name in table(&path)[0].keys() {
                assert!(sidecar[name]["Description"].is_string(), "{}: {name}", path.display());
            }
        }
    }

    for (number, row) in participants.iter().enumerate() {
        let subject = &row["participant_id"];
        let mut scans = table(&out.join(subject).join(format!("{subject}_scans.tsv")));
        // Questionnaires have no recording.
        scans.retain(|scan| scan["recording"] != "n/a");
        let events_of = |scan: &BTreeMap<String, String>| {
            table(&out.join(subject).join(scan["filename"].replace("_motion.tsv", "_events.tsv")))
        };
        let driven: Vec<&str> = scans.iter().skip(1).map(|scan| scan["condition"].as_str()).collect();
        assert_eq!((scans.len(), driven.join(",")), (4, row["order"].clone()));
        for scan in &scans {
            let events = events_of(scan);
            let advice = TableReader::parquet(&Table::Advice.parquet(&out.join(&scan["recording"]))).unwrap();
            assert_eq!(events.iter().filter(|event| event["trial_type"] == "advice").count(), advice.rows());
        }
        // The practice ends by its criterion, before its 30 s.
        let ended = |event: &BTreeMap<String, String>| event["trial_type"] == "criterion";
        assert!(events_of(&scans[0]).iter().any(ended));
        // The baseline has the seed of its trial and no advice.
        let scenario = |name: &str| {
            let text = fs::read_to_string(out.join(&scans[1][name]).join("scenario.toml")).unwrap();
            toml::from_str::<toml::Table>(&text).unwrap()
        };
        let (trial, baseline) = (scenario("recording"), scenario("baseline"));
        assert!(trial["seed"] == baseline["seed"] && trial["range_mph"] == baseline["range_mph"]);
        assert_eq!((baseline["policy"].as_str(), baseline["driver"].as_str()), (Some("none"), Some("idm")));
        let manifest = fs::read_to_string(out.join(&scans[1]["recording"]).join("manifest.json")).unwrap();
        assert!(manifest.contains(&format!("\"participant\": \"R{:02}\"", number + 1)), "{manifest}");
    }
    let workload = table(&out.join("phenotype/workload.tsv"));
    for row in &workload {
        let rated = ["mental", "physical", "temporal", "performance", "effort", "frustration"];
        let mean = rated.iter().map(|name| row[*name].parse::<f64>().unwrap()).sum::<f64>() / 6.0;
        assert!((row["score_raw-tlx"].parse::<f64>().unwrap() - mean).abs() < 1e-6);
    }
    assert_eq!((workload.len(), table(&out.join("phenotype/ssq_before.tsv")).len()), (6, 6));

    // The list has every file with data, and another program confirms it.
    let checked = std::process::Command::new("sha256sum")
        .args(["--check", "--strict", "--quiet", "SHA256SUMS"])
        .current_dir(&out)
        .output()
        .unwrap();
    assert!(checked.status.success(), "{checked:?}");
    let listed = fs::read_to_string(out.join("SHA256SUMS")).unwrap();
    for path in files(&out) {
        let name = path.strip_prefix(&out).unwrap().to_str().unwrap().to_owned();
        let is_listed = listed.lines().any(|line| line.ends_with(&format!("  {name}")));
        assert_eq!(is_listed, !name.ends_with("lock") && name != "SHA256SUMS", "{name}");
    }

    // The analysis includes all drives.
    let (code, text) = codrive(&["analyse", out.to_str().unwrap()]);
    assert!(code == 0 && text.contains("24 drives"), "{text}");
    let report = out.join("derivatives/codrive");
    let trials = table(&report.join("trials.csv"));
    assert_eq!(trials.iter().filter(|row| row["condition"] == "wide").count(), 6);
    for row in trials.iter().filter(|row| row["segment"] == "trial") {
        let [with, without, gain] =
            ["mean_speed_mps", "baseline_speed_mps", "speed_gain_mps"].map(|n| row[n].parse::<f64>().unwrap());
        assert!((with - without - gain).abs() < 1e-9);
    }
    let figures = |ending: &str| {
        let names = fs::read_dir(report.join("figures")).unwrap().map(|entry| entry.unwrap().path());
        let mut names: Vec<_> = names.filter(|path| path.extension().is_some_and(|e| e == ending)).collect();
        names.sort();
        names.into_iter().map(|path| path.with_extension("")).collect::<Vec<_>>()
    };
    assert!(!figures("svg").is_empty());
    assert_eq!(figures("svg"), figures("png"), "every figure in both forms");
    let html = fs::read_to_string(report.join("report.html")).unwrap();
    // The page loads nothing: its only addresses are names of the SVG format.
    assert_eq!(html.matches("http").count(), html.matches("xmlns=\"http://www.w3.org/2000/svg\"").count());
    assert!(!html.contains("<script") && !html.contains("NaN") && html.contains("narrow (N = 6)"));
    // Every picture is a numbered figure with a caption; only the data dictionary names columns.
    let captions = html.matches("<figcaption><b>Figure ").count();
    assert!(captions == html.matches("<svg ").count() && captions == figures("svg").len(), "{captions}");
    let (page, dictionary) = html.split_once("<section id=\"data-dictionary\">").unwrap();
    let defined: Value = serde_json::from_slice(&fs::read(report.join("columns.json")).unwrap()).unwrap();
    for file in ["trials.csv", "advice.csv", "speed.csv", "conditions.csv"] {
        let head = fs::read_to_string(report.join(file)).unwrap().lines().next().unwrap().to_owned();
        for column in head.split(',') {
            assert!(dictionary.contains(&format!("<code>{column}</code>")), "{file}: {column}");
            assert!(!defined[file]["Columns"][column]["LongName"].as_str().unwrap().is_empty(), "{file}: {column}");
            assert!(!column.contains('_') || !page.contains(column), "{file}: {column}");
        }
    }
    // The methods file has the text of the page, with facts of the manifests.
    let methods = fs::read_to_string(report.join("methods.txt")).unwrap();
    for part in [
        "24 drives of 6 simulated participants were analysed.",
        "There were 3 conditions (narrow: half width of the advised range 0.75 mph; middle:",
        "There were 6 different orders.",
        "no person took part",
        "an advice was held for 2 s",
    ] {
        assert!(methods.contains(part) && page.contains(part), "{part}\n{methods}");
    }
    let (code, text) = codrive(&["analyse", out.join("sub-R02").to_str().unwrap()]);
    assert!(code == 0 && text.contains("4 drives"), "{text}");

    // A completed participant is not run again, and no file changes.
    let before = fs::read(out.join("sourcedata/sub-R01/session.json")).unwrap();
    let (code, _) = rehearse(&file, &out, "6");
    assert!(code == 0 && fs::read(out.join("sourcedata/sub-R01/session.json")).unwrap() == before);
}

/// Returns the contents that must be equal between two runs: all files except those with times of day.
fn contents(out: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let timed = |path: &Path| {
        ["session.json", "manifest.json", "SHA256SUMS", "date-shift.json"].iter().any(|name| path.ends_with(name))
    };
    let list = files(out).into_iter().filter(|path| !timed(path));
    let read = |path: &Path| match fs::read(path).unwrap() {
        scans if path.to_string_lossy().ends_with("_scans.tsv") => without_time(&String::from_utf8(scans).unwrap()),
        bytes => bytes,
    };
    list.map(|path| (path.strip_prefix(out).unwrap().to_owned(), read(&path))).collect()
}

/// Returns a list of files without its second column, the start times.
fn without_time(scans: &str) -> Vec<u8> {
    let row = |line: &str| {
        let mut cells: Vec<&str> = line.split('\t').collect();
        cells.remove(1);
        cells.join("\t") + "\n"
    };
    assert!(scans.starts_with("filename\tacq_time\t"), "{scans}");
    scans.lines().map(row).collect::<String>().into_bytes()
}

#[test]
fn a_changed_data_set_is_analysed_only_on_request_and_the_report_says_so() {
    let (_folder, file, out) = place();
    assert_eq!(rehearse(&file, &out, "2").0, 0);
    let analyse = |more: &[&str]| codrive(&[&["analyse", out.to_str().unwrap()], more].concat());
    assert_eq!(analyse(&[]).0, 0);
    // A second analysis finds its own files, and a what-if lies beside the recordings: neither is a change.
    let trial = out.join("sourcedata/sub-R01/trial-1-narrow");
    assert_eq!(codrive(&["replay", trial.to_str().unwrap(), "--what-if", "none"]).0, 0);
    assert_eq!(analyse(&[]).0, 0);
    let session = out.join("sourcedata/sub-R01/session.json");
    let changed = fs::read_to_string(&session).unwrap().replacen("\"done\"", "\"skipped\"", 1);
    fs::write(&session, changed).unwrap();
    let (code, text) = analyse(&[]);
    assert!(code == 1 && text.contains("sourcedata/sub-R01/session.json: is not as it was written"), "{text}");
    assert!(text.contains("state of sub-R01 is complete; sourcedata/sub-R01/session.json has partial"), "{text}");
    // Publishing again does not repair the change.
    assert_eq!(rehearse(&file, &out, "2").0, 0);
    let (code, text) = analyse(&[]);
    assert!(code == 1 && text.contains("sourcedata/sub-R01/session.json: is not as it was written"), "{text}");
    let mut advice = fs::read(trial.join("advice.parquet")).unwrap();
    advice[100] ^= 1;
    fs::write(trial.join("advice.parquet"), advice).unwrap();
    fs::remove_file(trial.join("summary.json")).unwrap();
    let (code, text) = analyse(&[]);
    let names = ["advice.parquet: is not as it was written", "summary.json: is missing"];
    assert!(code == 1 && names.iter().all(|name| text.contains(name)) && text.contains("--accept-changes"), "{text}");
    // With `--accept-changes` the readable part is analysed.
    fs::copy(out.join("sourcedata/sub-R02/trial-1-middle/advice.parquet"), trial.join("advice.parquet")).unwrap();
    let (code, text) = analyse(&["--accept-changes"]);
    assert!(code == 1 && text.contains("analysed although"), "{text}");
    assert!(text.starts_with("not as written: "), "first what differs: {text}");
    let report = fs::read_to_string(out.join("derivatives/codrive/report.html")).unwrap();
    assert!(
        report.contains("Files that were changed, are missing or are out of place")
            && report.contains("trial-1-narrow/summary.json: is missing")
    );
    // A recording alone is checked against its own checksums.
    let (code, text) = codrive(&["analyse", trial.to_str().unwrap()]);
    assert!(code == 1 && text.contains("advice.parquet: ") && text.contains("--accept-changes"), "{text}");
}

#[test]
fn the_same_seed_gives_the_same_files_also_after_a_cut() {
    let (_folder, file, out) = place();
    let second = out.with_file_name("second");
    assert_eq!((rehearse(&file, &out, "2").0, rehearse(&file, &second, "1").0), (0, 0));
    // The second participant is cut within the first trial: the journal is left, and the session says running.
    let (study, code) = (study(), ParticipantCode::new("R02").unwrap());
    let data = DataSet::open(&second, &study).unwrap();
    let mut session = Session::open(&data, &study, &code, ParticipantKind::Simulated, 1, "then").unwrap();
    let names: Vec<String> = session.plan().items.iter().map(|planned| planned.name.clone()).collect();
    assert_eq!(names[..4], ["welcome", "ssq-before", "practice", "trial-1-middle"]);
    for _ in 0..1 {
        session.begin("then").unwrap();
        session.end(ItemOutcome::Done, "", "then").unwrap();
    }
    session.begin("then").unwrap();
    drop(session);
    let (code, text) = rehearse(&file, &second, "2");
    assert!(code == 0 && text.contains("2 of 2"), "{text}");
    let log = SessionLog::load(&second.join("sourcedata/sub-R02/session.json")).unwrap();
    let item_runs: Vec<(&str, ItemOutcome)> = log.item_runs.iter().map(|p| (p.item.as_str(), p.outcome)).collect();
    assert_eq!(
        item_runs[..3],
        [("welcome", ItemOutcome::Done), ("ssq-before", ItemOutcome::Cut), ("ssq-before", ItemOutcome::Done)]
    );
    let (a, b) = (contents(&out), contents(&second));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (path, bytes) in &a {
        assert!(b[path] == *bytes, "{}", path.display());
    }
}

#[test]
fn ctrl_c_and_a_kill_cost_one_drive_and_the_same_command_resumes() {
    let (_folder, file, out) = place();
    let long = short().replace("duration_s = 6.0", "duration_s = 600.0");
    fs::write(&file, long).unwrap();
    let rehearse = || {
        let [file, out] = [&file, &out].map(|path| path.to_str().unwrap());
        std::process::Command::new(env!("CARGO_BIN_EXE_codrive"))
            .args(["study", "rehearse", file, "--participants", "1", "--out", out])
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap()
    };
    let until = |child: &mut std::process::Child, path: &Path| {
        while !path.exists() {
            assert!(child.try_wait().unwrap().is_none(), "ended by itself");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    };
    let mut child = rehearse();
    let source = out.join("sourcedata/sub-R01");
    until(&mut child, &source.join("trial-1-narrow/journal/rows.blocks"));
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success() && child.wait().unwrap().code() == Some(1));
    let log = SessionLog::load(&source.join("session.json")).unwrap();
    let last = log.item_runs.last().unwrap();
    assert_eq!(
        (last.item.as_str(), last.outcome, log.running.is_none()),
        ("trial-1-narrow", ItemOutcome::Aborted, true)
    );
    let rows = TableReader::parquet(&Table::Ego.parquet(&source.join("trial-1-narrow"))).unwrap().rows();
    assert!(rows < 60_000 && !source.join("trial-1-narrow/journal").exists());
    // The next attempt has its own folder.
    let long = fs::read_to_string(&file).unwrap();
    let study = Study::parse(long, &file).unwrap();
    let data = DataSet::open(&out, &study).unwrap();
    let mut session =
        Session::open(&data, &study, &ParticipantCode::new("R01").unwrap(), ParticipantKind::Simulated, 0, "now")
            .unwrap();
    let again = source.join("trial-1-narrow-again-1");
    assert_eq!(session.begin("now").unwrap(), again);
    drop(session);

    // After a kill within the drive the recording is recovered, and the next attempt again has its own folder.
    let mut child = rehearse();
    until(&mut child, &again.join("journal/rows.blocks"));
    child.kill().unwrap();
    child.wait().unwrap();
    let mut session =
        Session::open(&data, &study, &ParticipantCode::new("R01").unwrap(), ParticipantKind::Simulated, 0, "now")
            .unwrap();
    let cut = session.log().item_runs.last().unwrap();
    assert_eq!((cut.outcome, cut.recording.as_deref()), (ItemOutcome::Cut, Some("trial-1-narrow-again-1")));
    TableReader::parquet(&Table::Ego.parquet(&again)).unwrap();
    assert_eq!(session.begin("later").unwrap(), source.join("trial-1-narrow-again-2"));
}

#[test]
fn a_session_can_be_skipped_repeated_noted_stopped_and_never_run_twice() {
    let (_folder, _, out) = place();
    let study = study();
    let data = DataSet::open(&out, &study).unwrap();
    let code = ParticipantCode::new("P03").unwrap();
    let open =
        |kind, code: &ParticipantCode| Session::open(&data, &study, code, kind, data.next_index().unwrap_or(0), "t0");
    let refused = |found: Result<Session, SessionError>, has: &str| {
        let text = found.expect_err(has).to_string();
        assert!(text.contains(has), "{text}");
    };
    let mut session = open(ParticipantKind::Person, &code).unwrap();
    refused(open(ParticipantKind::Person, &code), "another program runs the session of participant");
    refused(open(ParticipantKind::Person, &ParticipantCode::new("p03").unwrap()), "only by capital letters");
    assert!(session.repeat("welcome", "", "t1").unwrap_err().to_string().contains("nothing yet"));
    session.begin("t1").unwrap();
    session.note("mark", "coughs", "t2").unwrap();
    session.end(ItemOutcome::Done, "", "t3").unwrap();
    session.skip("no time", "t4").unwrap();
    assert_eq!(session.next().unwrap().1.name, "practice");
    session.repeat("welcome", "did not read it", "t5").unwrap();
    assert_eq!(session.next().unwrap().1.name, "welcome");
    session.begin("t6").unwrap();
    session.end(ItemOutcome::Aborted, "phone", "t7").unwrap();
    assert_eq!(session.next().unwrap().1.name, "welcome", "what was broken off comes again");
    assert!(session.finish("t8").unwrap_err().to_string().contains("\"welcome\" is left to do"));
    drop(session);

    let mut session = open(ParticipantKind::Person, &code).unwrap();
    assert_eq!((session.log().index, session.log().notes[0].item.as_deref()), (0, Some("welcome")));
    session.stop("sick", "t9").unwrap();
    drop(session);
    refused(open(ParticipantKind::Person, &code), "stopped for good (sick, t9)");
    data.publish(&study, &code).unwrap();
    assert_eq!(table(&out.join("participants.tsv"))[0]["state"], "withdrawn");

    let other = ParticipantCode::new("P04").unwrap();
    let mut session = open(ParticipantKind::Person, &other).unwrap();
    assert_eq!(session.log().index, 0, "the order of the one who was stopped, who is replaced");
    while session.next().is_some() {
        session.skip("", "t").unwrap();
    }
    assert!(session.skip("", "t").unwrap_err().to_string().contains("nothing is left to do"));
    session.finish("t").unwrap();
    drop(session);
    refused(open(ParticipantKind::Person, &other), "cannot take part again");
    refused(open(ParticipantKind::Simulated, &other), "is a person");

    let file = out.join("sourcedata/sub-P04/session.json");
    fs::write(&file, "{").unwrap();
    refused(open(ParticipantKind::Person, &other), "not a session of this program");
    fs::remove_file(&file).unwrap();
    fs::write(out.join("sourcedata/sub-P04/trial"), "").unwrap();
    refused(open(ParticipantKind::Person, &other), "but no session.json");
}

#[test]
fn a_clock_that_is_set_back_changes_no_order_and_stays_in_the_stamps() {
    let (_folder, _, out) = place();
    let study = study();
    let data = DataSet::open(&out, &study).unwrap();
    let code = ParticipantCode::new("P03").unwrap();
    let mut session = Session::open(&data, &study, &code, ParticipantKind::Person, 0, "2026-03-29T10:00:00Z").unwrap();
    session.begin("2026-03-29T10:00:01Z").unwrap();
    session.end(ItemOutcome::Done, "", "2026-03-29T09:00:30Z").unwrap();
    session.begin("2026-03-29T09:00:31Z").unwrap();
    drop(session);
    // Cut, and opened at an earlier time than all of its entries.
    let mut session = Session::open(&data, &study, &code, ParticipantKind::Person, 0, "2025-01-01T00:00:00Z").unwrap();
    let item_runs = &session.log().item_runs;
    assert_eq!(item_runs.iter().map(|p| p.outcome).collect::<Vec<_>>(), [ItemOutcome::Done, ItemOutcome::Cut]);
    assert!(item_runs[0].began > item_runs[0].ended && item_runs[1].ended.starts_with("2025"));
    let cut = item_runs[1].item.clone();
    assert_eq!(session.next().unwrap().1.name, cut, "what was done is not done again, what was cut is");
    session.stop("test", "2025-01-01T00:00:01Z").unwrap();
    drop(session);
    data.publish(&study, &code).unwrap();
    assert_eq!(table(&out.join("participants.tsv"))[0]["state"], "withdrawn");
}

#[test]
fn other_folders_are_refused_and_left_alone() {
    let (folder, file, out) = place();
    let (code, text) = rehearse(&file, folder.path(), "1");
    assert!(code == 2 && text.contains("is not the data set of a study"), "{text}");
    assert_eq!(files(folder.path()), std::slice::from_ref(&file));

    let data = DataSet::open(&out, &study()).unwrap();
    drop(
        Session::open(&data, &study(), &ParticipantCode::new("P01").unwrap(), ParticipantKind::Person, 0, "t").unwrap(),
    );
    let (code, text) = rehearse(&file, &out, "1");
    assert!(code == 2 && text.contains("holds data of a person (P01)"), "{text}");
    fs::write(&file, short().replace("seed = 7", "seed = 8")).unwrap();
    let (code, text) = rehearse(&file, &out, "1");
    assert!(code == 2 && text.contains("differs from the study of this data set"), "{text}");
    let (code, text) = codrive(&["study", "rehearse", file.to_str().unwrap()]);
    assert!(code == 2 && text.contains("--out"), "{text}");

    for (path, has) in [(folder.path(), "contains nothing to analyse"), (&out, "contains no complete drive")] {
        let (code, text) = codrive(&["analyse", path.to_str().unwrap()]);
        assert!(code == 2 && text.contains(has), "{text}");
    }
    let cut = folder.path().join("cut");
    let drive = ["run", "--traffic", "native", "--duration", "1", "--out", cut.to_str().unwrap()];
    assert_eq!(codrive(&drive).0, 0);
    // A manifest that does not say how the drive ended: it was cut.
    let manifest = fs::read_to_string(cut.join("manifest.json")).unwrap();
    fs::write(cut.join("manifest.json"), manifest.replace("\"complete\"", "\"running\"")).unwrap();
    let (code, text) = codrive(&["analyse", cut.to_str().unwrap()]);
    assert!(code == 2 && text.contains("codrive recover"), "{text}");
    fs::write(cut.join("manifest.json"), manifest).unwrap();
    let (code, text) = codrive(&["analyse", cut.to_str().unwrap()]);
    assert!(code == 0 && text.contains("of 1 drive\n"), "{text}");
    fs::write(cut.join("ego.parquet"), "no").unwrap();
    let (code, text) = codrive(&["analyse", cut.to_str().unwrap()]);
    assert!(code == 1 && text.contains("ego.parquet: no Parquet file"), "{text}");
}
