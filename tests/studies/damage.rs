//! A damaged participant is named and left out, and the others are analysed. What a signature does not cover is never called authentic.

use crate::{
    common::{codrive, table, text},
    places::{copy, data_set, rehearse, study, trial, wrong},
};
use codrive::{
    drive_loop::baselines,
    study::{DataSet, ParticipantCode},
};
use std::{
    fs,
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering},
};

fn run(arguments: &[&str]) -> (Option<i32>, String) {
    let output = codrive(arguments, "error");
    (output.status.code(), text(&output))
}

fn analysed(root: &Path) -> Vec<String> {
    let mut ids: Vec<String> =
        table(&root.join("derivatives/codrive/trials.csv")).into_iter().map(|row| row["participant"].clone()).collect();
    ids.dedup();
    ids
}

/// Name of a kind of damage, and what it does to the first participant's files of a data set.
type Damage = (&'static str, fn(&Path));

/// Losses that leave a participant unreadable: of whole files, of half of one, and of what lists or explains them.
const DAMAGE: [Damage; 6] = [
    ("no recording", |root| fs::remove_dir_all(trial(root, "sub-R01", 1)).unwrap()),
    ("no baseline", |root| {
        fs::remove_dir_all(format!("{}-baseline", trial(root, "sub-R01", 2).display())).unwrap();
    }),
    ("no manifest", |root| fs::remove_file(trial(root, "sub-R01", 1).join("manifest.json")).unwrap()),
    ("half a table", |root| {
        let path = trial(root, "sub-R01", 1).join("ego.parquet");
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    }),
    ("no list of drives", |root| fs::write(root.join("sub-R01/sub-R01_scans.tsv"), "?\n").unwrap()),
    ("no log", |root| fs::write(root.join("sourcedata/sub-R01/session.json"), "{").unwrap()),
];

#[test]
fn a_damaged_participant_is_named_and_the_others_are_analysed() {
    let one = |(kind, damage): &Damage| {
        let (_folder, root) = data_set();
        damage(&root);
        let (code, printed) = run(&["analyse", root.to_str().unwrap()]);
        assert_eq!(code, Some(1), "{kind}: {printed}");
        assert!(printed.contains("not as written: sub-R01 is left out: "), "{kind}: {printed}");
        assert!(printed.contains("sub-R01 is left out, because files cannot be read any more"), "{kind}: {printed}");
        assert!(!printed.contains("consistent") && printed.contains("codrive study exclude"), "{kind}: {printed}");
        assert_eq!(analysed(&root), ["sub-R02"], "{kind}");
        let report = fs::read_to_string(root.join("derivatives/codrive/report.html")).unwrap();
        assert!(report.contains("sub-R01 is left out: ") && report.contains("1 damaged (sub-R01)"), "{kind}");
    };
    // Each kind takes a second of an analysis.
    std::thread::scope(|scope| DAMAGE.iter().for_each(|kind| drop(scope.spawn(move || one(kind)))));
}

#[test]
fn a_participant_with_a_lost_recording_can_be_excluded() {
    let (folder, root) = data_set();
    let path = root.to_str().unwrap();
    fs::remove_dir_all(trial(&root, "sub-R01", 1)).unwrap();
    let tables = || fs::read_dir(root.join("sub-R01/motion")).unwrap().count();
    let before = tables();
    let file = folder.path().join("short.toml").to_str().unwrap().to_owned();
    fs::copy(root.join("study.toml"), &file).unwrap();
    let (code, printed) = run(&["study", "exclude", &file, "R01", "--from", path, "--reason", "disk broken"]);
    assert!(code == Some(0) && printed.contains("R01 excluded"), "{printed}");
    assert_eq!(tables(), before, "the tables of the lost drive stay");
    for flags in [&["analyse", path][..], &["analyse", path, "--accept-changes"]] {
        let (code, printed) = run(flags);
        assert!(
            code == Some(1) && printed.contains("sourcedata/sub-R01/trial-1-"),
            "the loss is still named: {printed}"
        );
        assert_eq!(analysed(&root), ["sub-R02"]);
    }
    let people = table(&root.join("participants.tsv"));
    assert_eq!((people[0]["state"].as_str(), people[1]["state"].as_str()), ("excluded", "complete"));
}

#[test]
fn a_signature_covers_participants_plan_and_losses() {
    let key = |name: &str| format!("{}/tests/data/signing/{name}", env!("CARGO_MANIFEST_DIR"));
    let (lab, signers) = (key("lab-key"), key("allowed_signers"));
    let (_folder, root) = data_set();
    let path = root.to_str().unwrap();
    let check = || run(&["analyse", path, "--signer", &signers]);
    assert_eq!(run(&["sign", path, "--key", &lab]).0, Some(0));
    let not_authentic = |what: &str| {
        let (code, printed) = check();
        assert!(code == Some(1) && printed.contains(what) && !printed.contains("authentic: signed"), "{printed}");
    };
    // A plan of an analysis that is written after the signature.
    let changed = root.join("study-changed.toml");
    fs::write(&changed, fs::read_to_string(root.join("study.toml")).unwrap()).unwrap();
    not_authentic("does not cover study-changed.toml");
    fs::remove_file(&changed).unwrap();
    assert_eq!(check().0, Some(0));
    // A questionnaire's table by a link.
    let link = root.join("phenotype/more.tsv");
    std::os::unix::fs::symlink(root.join("phenotype/workload.tsv"), &link).unwrap();
    not_authentic("phenotype/more.tsv: is a symbolic link");
    fs::remove_file(&link).unwrap();
    // A participant of another data set, as one whose session is not over.
    let other = root.with_file_name("other");
    rehearse(&other, 3);
    copy(&other.join("sourcedata/sub-R03"), &root.join("sourcedata/sub-R03"));
    copy(&other.join("sub-R03"), &root.join("sub-R03"));
    let log = root.join("sourcedata/sub-R03/session.json");
    let mut keys: serde_json::Value = serde_json::from_slice(&fs::read(&log).unwrap()).unwrap();
    keys["end"] = serde_json::Value::Null;
    fs::write(&log, keys.to_string()).unwrap();
    not_authentic("does not cover sub-R03 (the session is not over)");
    let (code, printed) = run(&["sign", path, "--key", &lab]);
    assert!(code == Some(1) && printed.contains("does not list sub-R03 (the session is not over)"), "{printed}");
    ["sourcedata/sub-R03", "sub-R03"].iter().for_each(|name| fs::remove_dir_all(root.join(name)).unwrap());
    assert_eq!(check().0, Some(0));
    // A loss leaves the others analysed, and the signature is of other files.
    fs::remove_dir_all(trial(&root, "sub-R01", 1)).unwrap();
    not_authentic("not authentic: lab (SHA256:");
    assert_eq!(analysed(&root), ["sub-R02"]);
}

#[test]
fn interrupted_baselines_are_counted_truly_and_are_no_alarm() {
    let (_folder, root) = data_set();
    let of = |number| PathBuf::from(format!("{}-baseline", trial(&root, "sub-R01", number).display()));
    [1, 2].iter().for_each(|number| fs::remove_dir_all(of(*number)).unwrap());
    let (study, code) = (study(), ParticipantCode::new("R01").unwrap());
    let data = DataSet::open(&root, &study).unwrap();
    // Ctrl-C after the first steps, and after so many ticks that one of the two is made.
    for (ticks, expected) in [(0, [0, 2]), (350, [1, 2]), (u64::MAX, [1, 1]), (0, [0, 0])] {
        let (stop, driven) = (AtomicBool::new(false), std::cell::Cell::new(0));
        let made = baselines::make_up(&data, &study, &code, &stop, &|more| {
            driven.set(driven.get() + more);
            stop.store(driven.get() > ticks, Ordering::Relaxed);
        });
        assert_eq!(made.unwrap(), expected, "stopped after {ticks} ticks");
        assert_eq!(wrong(&root), [""; 0], "stopped after {ticks} ticks");
        let parts = fs::read_dir(root.join("sourcedata/sub-R01")).unwrap().map(|entry| entry.unwrap().file_name());
        assert_eq!(parts.filter(|name| name.to_string_lossy().ends_with("-part")).count(), 0);
    }
    assert!(of(1).join("manifest.json").exists() && of(2).join("manifest.json").exists());
    // A lost trial has no baseline to make, and does not keep the others from theirs.
    [of(1), of(2), trial(&root, "sub-R01", 1)].iter().for_each(|folder| fs::remove_dir_all(folder).unwrap());
    let made = baselines::make_up(&data, &study, &code, &AtomicBool::new(false), &|_| ()).unwrap();
    assert_eq!(made, [1, 1]);
}
