//! A recording in the wrong place and a table that contradicts the log are found. The intended ways to change a data set are no alarm.

use crate::common::{codrive, text};
use codrive::{
    drive_loop::rehearsal::Rehearsal,
    record::file_sha256,
    study::{DataSet, ParticipantCode, Study, checksums, places},
};
use std::{
    fs,
    path::{Path, PathBuf},
    sync::{OnceLock, atomic::AtomicBool},
};

pub fn study() -> Study {
    let text = crate::common::study(2.0, 3.0, ["workload", "raw-tlx"]);
    Study::parse(text, Path::new("short.toml")).unwrap_or_else(|e| panic!("{e}"))
}

pub fn rehearse(root: &Path, participants: usize) {
    let study = study();
    let rehearsal = Rehearsal::open(&study, root, participants).unwrap();
    assert_eq!(rehearsal.run(&AtomicBool::new(false), &|_| ()).unwrap().complete, participants);
}

pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() { copy(&entry.path(), &to) } else { fs::copy(entry.path(), &to).map(drop).unwrap() }
    }
}

/// Returns a copy of a data set of two participants, rehearsed once.
pub fn data_set() -> (tempfile::TempDir, PathBuf) {
    static WHOLE: OnceLock<tempfile::TempDir> = OnceLock::new();
    let whole = WHOLE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        rehearse(&folder.path().join("data"), 2);
        folder
    });
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("data");
    copy(&whole.path().join("data"), &root);
    (folder, root)
}

/// Returns all faults of a data set, one per line.
pub fn wrong(root: &Path) -> Vec<String> {
    let listed = checksums::changes(root).unwrap();
    listed.iter().chain(&places::misplaced(root).unwrap()).map(ToString::to_string).collect()
}

/// Returns the faults that the check of places alone finds, as if all checksums had been recomputed.
fn misplaced(tamper: impl FnOnce(&Path)) -> String {
    let (_folder, root) = data_set();
    tamper(&root);
    assert!(!checksums::changes(&root).unwrap().is_empty(), "without new checksums");
    places::misplaced(&root).unwrap().iter().map(|found| format!("{found}\n")).collect()
}

/// Returns the folder of a participant's trial of this number.
pub fn trial(root: &Path, subject: &str, number: u32) -> PathBuf {
    let begins = format!("trial-{number}-");
    let is_it = |name: &str| name.starts_with(&begins) && !name.ends_with("-baseline");
    let folders = fs::read_dir(root.join("sourcedata").join(subject)).unwrap().map(|entry| entry.unwrap().path());
    folders.into_iter().find(|path| is_it(&path.file_name().unwrap().to_string_lossy())).unwrap()
}

fn swap(one: &Path, other: &Path) {
    let between = one.with_file_name("between");
    fs::rename(one, &between).unwrap();
    fs::rename(other, one).unwrap();
    fs::rename(between, other).unwrap();
}

fn edit(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{text}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

#[test]
fn intended_changes_of_a_data_set_are_no_alarm() {
    let (_folder, root) = data_set();
    assert_eq!(wrong(&root), [""; 0]);
    let (data, code) = (DataSet::open(&root, &study()).unwrap(), |text: &str| ParticipantCode::new(text).unwrap());
    data.exclude(&study(), &code("R01"), "asleep", "2026-11-25T10:00:00Z").unwrap();
    assert_eq!(wrong(&root), [""; 0], "after an exclusion");
    let analysed = codrive(&["analyse", root.to_str().unwrap()], "error");
    assert!(analysed.status.success(), "{}", text(&analysed));
    assert_eq!(wrong(&root), [""; 0], "after an analysis");
    rehearse(&root, 3);
    assert_eq!(wrong(&root), [""; 0], "with another participant");
    data.erase(&code("R02"), "asked for it", "2026-11-25T11:00:00Z").unwrap();
    assert_eq!(wrong(&root), [""; 0], "after an erasure");
}

#[test]
fn a_recording_in_the_folder_of_another_participant_is_found() {
    let found = misplaced(|root| swap(&trial(root, "sub-R01", 1), &trial(root, "sub-R02", 1)));
    let (_folder, root) = data_set();
    let name = trial(&root, "sub-R01", 1).file_name().unwrap().to_string_lossy().into_owned();
    let line =
        format!("sourcedata/sub-R01/{name}: is a recording of participant R02, but it is in the folder of sub-R01");
    assert!(found.contains(&line), "{found}");
    assert!(found.contains("is a recording of participant R01, but it is in the folder of sub-R02"), "{found}");
    let found = misplaced(|root| {
        let session = |subject: &str| root.join("sourcedata").join(subject).join("session.json");
        swap(&session("sub-R01"), &session("sub-R02"));
    });
    assert!(
        found.contains("sub-R01/session.json: is the session of sub-R02, but it is in the folder of sub-R01"),
        "{found}"
    );
}

#[test]
fn swapped_trials_and_baselines_are_found() {
    let found = misplaced(|root| swap(&trial(root, "sub-R01", 1), &trial(root, "sub-R01", 2)));
    assert_eq!(found.matches(": is not the drive that study.toml plans for trial-").count(), 2, "{found}");
    let baseline =
        |root: &Path, number| PathBuf::from(format!("{}-baseline", trial(root, "sub-R01", number).display()));
    let found = misplaced(|root| swap(&baseline(root, 1), &baseline(root, 2)));
    assert_eq!(found.matches("without advice: seed is ").count(), 2, "{found}");
    let found = misplaced(|root| {
        fs::remove_dir_all(baseline(root, 1)).unwrap();
        copy(&trial(root, "sub-R01", 1), &baseline(root, 1));
    });
    assert!(found.contains("is not a drive without advice: its policy is ring-250-speed"), "{found}");
    let found = misplaced(|root| {
        swap(&baseline(root, 1), &PathBuf::from(format!("{}-baseline", trial(root, "sub-R02", 1).display())))
    });
    assert!(
        found.contains("-baseline: is a recording of participant R02, but it is in the folder of sub-R01"),
        "{found}"
    );
    // Driven with another policy than the condition's in the plan.
    let found = misplaced(|root| {
        let manifest = trial(root, "sub-R01", 1).join("manifest.json");
        edit(&manifest, "\"name\": \"ring-250-speed\"", "\"name\": \"pi\"");
    });
    assert!(found.contains(": the policy is pi; planned: ring-250-speed"), "{found}");
    // In a folder that is named after another item.
    let found = misplaced(|root| {
        let from = trial(root, "sub-R01", 1);
        let name = from.file_name().unwrap().to_string_lossy().into_owned();
        fs::rename(&from, from.with_file_name("trial-9-wide")).unwrap();
        let (was, is) = (format!("\"recording\": \"{name}\""), "\"recording\": \"trial-9-wide\"");
        edit(&from.with_file_name("session.json"), &was, is);
    });
    assert!(found.contains("sourcedata/sub-R01/trial-9-wide: is not named after trial-1-"), "{found}");
}

#[test]
fn a_clock_that_was_set_back_before_a_drive_is_no_fault() {
    // The log has the start of the page before the drive, the recording its own, an earlier one.
    let found = misplaced(|root| {
        let manifest = trial(root, "sub-R01", 1).join("manifest.json");
        let keys: serde_json::Value = serde_json::from_slice(&fs::read(&manifest).unwrap()).unwrap();
        edit(&manifest, keys["began"].as_str().unwrap(), "2020-01-01T00:00:00Z");
    });
    assert_eq!(found, "");
}

#[test]
fn tables_that_contradict_the_log_are_found() {
    let of_scans = |from: &'static str, to: &'static str| {
        misplaced(|root| edit(&root.join("sub-R01/sub-R01_scans.tsv"), from, to))
    };
    let found = of_scans("\twide\t", "\tnarrow\t");
    assert!(found.contains("sub-R01_scans.tsv: condition of sourcedata/sub-R01/trial-"), "{found}");
    assert!(found.contains(" is narrow; the log and study.toml have wide"), "{found}");
    let found = of_scans("sourcedata/sub-R01/trial-1", "sourcedata/sub-R02/trial-1");
    assert!(
        found.contains("names sourcedata/sub-R02/trial-1")
            && found.contains("does not name sourcedata/sub-R01/trial-1"),
        "{found}"
    );
    let of_people =
        |from: &'static str, to: &'static str| misplaced(|root| edit(&root.join("participants.tsv"), from, to));
    let found = of_people("sub-R01\t1\t", "sub-R01\t2\t");
    assert!(found.contains("number of sub-R01 is 2; sourcedata/sub-R01/session.json has 1"), "{found}");
    let found = of_people("complete", "excluded");
    assert!(found.contains("state of sub-R01 is excluded; sourcedata/sub-R01/session.json has complete"), "{found}");
    let found = misplaced(|root| {
        let path = root.join("participants.tsv");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(
            &path,
            text.lines().filter(|line| !line.starts_with("sub-R02")).map(|l| format!("{l}\n")).collect::<String>(),
        )
        .unwrap();
    });
    assert!(found.contains("has no row for sub-R02, but the session is over"), "{found}");
    let found = misplaced(|root| edit(&root.join("sourcedata/sub-R01/session.json"), "\"index\": 0", "\"index\": 1"));
    assert!(
        found.contains("the order is ") && found.contains("study.toml has another order for participant number 2"),
        "{found}"
    );
}

#[test]
fn an_extra_or_missing_folder_is_found() {
    let found = misplaced(|root| copy(&trial(root, "sub-R02", 1), &root.join("sourcedata/sub-R01/trial-9-wide")));
    assert!(
        found.contains("sourcedata/sub-R01/trial-9-wide: session.json of its participant does not name it"),
        "{found}"
    );
    let found = misplaced(|root| fs::remove_dir_all(root.join("sourcedata/sub-R02")).unwrap());
    assert!(found.contains("sub-R02: there is no folder sourcedata/sub-R02"), "{found}");
    let found = misplaced(|root| fs::remove_dir_all(trial(root, "sub-R01", 1)).unwrap());
    assert!(found.contains("there is no readable recording"), "{found}");
}

#[test]
fn an_analysis_names_faults_first_and_fails_with_its_exit_code() {
    let (_folder, root) = data_set();
    let path = root.to_str().unwrap();
    swap(&trial(&root, "sub-R01", 1), &trial(&root, "sub-R01", 2));
    let refused = codrive(&["analyse", path], "error");
    assert!(
        refused.status.code() == Some(1)
            && text(&refused).contains("is not the drive that study.toml plans for trial-"),
        "{}",
        text(&refused)
    );
    let accepted = codrive(&["analyse", path, "--accept-changes"], "error");
    assert_eq!(accepted.status.code(), Some(1));
    assert!(text(&accepted).starts_with("not as written: "), "{}", text(&accepted));
    let page = fs::read_to_string(root.join("derivatives/codrive/report.html")).unwrap();
    let at = |what: &str| page.find(what).unwrap_or_else(|| panic!("{what}"));
    assert!(
        at("is not the drive that study.toml plans for trial-") < at("Participants: "),
        "before all that is said of the drives"
    );
    assert!(!page.contains("Files: consistent"), "files that differ are not called consistent");
}

#[test]
fn a_signed_data_set_and_each_of_its_recordings_are_authentic() {
    let (_folder, root) = data_set();
    let path = root.to_str().unwrap();
    let key = |name: &str| format!("{}/tests/data/signing/{name}", env!("CARGO_MANIFEST_DIR"));
    let (lab, signers) = (key("lab-key"), key("allowed_signers"));
    let run = |arguments: &[&str]| {
        let output = codrive(arguments, "error");
        (output.status.code(), text(&output))
    };
    let (code, printed) = run(&["sign", path, "--key", &lab]);
    assert!(code == Some(0) && root.join("SHA256SUMS.sig").exists(), "{printed}");
    let (code, printed) = run(&["analyse", path, "--signer", &signers]);
    assert!(code == Some(0) && printed.starts_with("authentic: signed by lab (SHA256:"), "{printed}");
    let drive = trial(&root, "sub-R01", 1);
    let (code, printed) = run(&["replay", drive.to_str().unwrap(), "--signer", &signers]);
    assert!(code == Some(0) && printed.contains("authentic: signed by lab"), "{printed}");
    // The list of the data set is rewritten after it was signed.
    let list = fs::read_to_string(root.join("SHA256SUMS")).unwrap();
    fs::write(root.join("SHA256SUMS"), list.lines().rev().map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    let (code, printed) = run(&["analyse", path, "--signer", &signers]);
    assert!(
        code == Some(1)
            && printed.contains("SHA256SUMS: the signature does not match: the file was changed after lab signed it"),
        "{printed}"
    );
    fs::write(root.join("SHA256SUMS"), list).unwrap();
    // A recording that the list does not have.
    let manifest = drive.join("manifest.json");
    let other = fs::read(trial(&root, "sub-R01", 2).join("manifest.json")).unwrap();
    fs::write(&manifest, other).unwrap();
    let (code, printed) = run(&["replay", drive.to_str().unwrap(), "--signer", &signers]);
    assert!(code == Some(1) && !printed.contains("authentic: signed"), "{printed}");
    // The recording itself, with a changed fact that no drive can prove, and its own checksum recomputed.
    copy(&data_set().1.join(drive.strip_prefix(&root).unwrap()), &drive);
    let mut keys: serde_json::Map<String, serde_json::Value> =
        serde_json::from_slice(&fs::read(&manifest).unwrap()).unwrap();
    keys["graphics"] = "other".into();
    keys.shift_remove("sha256");
    fs::write(&manifest, serde_json::to_string_pretty(&keys).unwrap() + "\n").unwrap();
    keys.insert("sha256".into(), file_sha256(&manifest).unwrap().into());
    fs::write(&manifest, serde_json::to_string_pretty(&keys).unwrap() + "\n").unwrap();
    let (code, printed) = run(&["replay", drive.to_str().unwrap(), "--signer", &signers]);
    assert!(
        code == Some(1) && printed.contains("signed the data set with another version of this recording"),
        "{printed}"
    );
}
