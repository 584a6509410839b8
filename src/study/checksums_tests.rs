//! Tests of the list of a data set's files: listed files, new entries, reported differences.

use super::*;

/// SHA-256 of the empty text and of "abc" (FIPS 180-2, appendix B.1).
const OF_NOTHING: &str = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
const OF_ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

/// Files of a data set with two participants, sorted by name.
const DATA: [&str; 10] = [
    "README.md",
    "participants.tsv",
    "phenotype/ssq.tsv",
    "sourcedata/sub-P1/drive-baseline/ego.parquet",
    "sourcedata/sub-P1/drive/ego.parquet",
    "sourcedata/sub-P1/session.json",
    "sourcedata/sub-P2/session.json",
    "sub-P1/beh/sub-P1_task-drive_events.tsv",
    "sub-P1/sub-P1_scans.tsv",
    "sub-P2/sub-P2_scans.tsv",
];

fn put(root: &Path, name: &str, text: &str) {
    fs::create_dir_all(root.join(name).parent().unwrap()).unwrap();
    fs::write(root.join(name), text).unwrap();
}

/// Makes a folder with these files, all empty.
fn data_set() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    DATA.iter().for_each(|name| put(folder.path(), name, ""));
    folder
}

/// Reads the list: SHA-256 by file name.
fn listed(root: &Path) -> ChecksumList {
    read(root).unwrap().expect("a list")
}

fn names(root: &Path) -> Vec<String> {
    listed(root).into_keys().collect()
}

/// Returns each reported file, with true if it is reported as missing.
fn found(root: &Path) -> Vec<(String, bool)> {
    changes(root).unwrap().into_iter().map(|change| (change.file, change.what == "is missing")).collect()
}

#[test]
fn every_file_that_holds_data_is_listed_and_nothing_else() {
    let folder = data_set();
    let root = folder.path();
    for none in [
        "lock",
        "sourcedata/lock",
        "sourcedata/sub-P1/lock",
        "participants.new",
        "sourcedata/sub-P1/session.new",
        "derivatives/codrive/trials.csv",
        "analysis/figure.svg",
        "report/index.html",
        "sub-P1/derivatives/x.tsv",
        "sourcedata/sub-P1/drive/analysis/trials.csv",
        "sourcedata/sub-P1/drive-baseline-part/ego.parquet",
    ] {
        put(root, none, "");
    }
    // A symbolic link is not listed; its target is listed if it lies in the data set.
    std::os::unix::fs::symlink(root.join("README.md"), root.join("link.md")).unwrap();
    assert_eq!(files(root).unwrap(), DATA);
    for subject in ["sub-P1", "sub-P2"] {
        list(root, subject, true).unwrap();
    }
    assert_eq!(names(root), DATA, "the list itself is not on it");
    assert!(listed(root).values().all(|sum| sum == OF_NOTHING));
    let text = fs::read_to_string(root.join(FILE)).unwrap();
    assert!(text.starts_with(&format!("{OF_NOTHING}  README.md\n")), "as sha256sum --check reads it: {text}");
}

#[test]
fn a_recording_is_listed_whatever_its_item_is_called() {
    let folder = data_set();
    let root = folder.path();
    let items =
        ["analysis", "derivatives", "lock", "report"].map(|item| format!("sourcedata/sub-P1/{item}/ego.parquet"));
    items.iter().for_each(|name| put(root, name, ""));
    list(root, "sub-P1", true).unwrap();
    assert!(items.iter().all(|name| names(root).contains(name)), "{:?}", names(root));
}

#[test]
fn an_unfinished_baseline_is_no_alarm_before_and_after_it_is_made() {
    let folder = data_set();
    let root = folder.path();
    let part = "sourcedata/sub-P1/drive-2-baseline-part/ego.parquet";
    put(root, part, "abc");
    ["sub-P1", "sub-P2"].iter().for_each(|subject| list(root, subject, true).unwrap());
    assert_eq!(found(root), []);
    // A list of an earlier version has the part, which then went.
    let text = fs::read_to_string(root.join(FILE)).unwrap();
    put(root, FILE, &format!("{text}{OF_ABC}  {part}\n"));
    fs::remove_file(root.join(part)).unwrap();
    assert_eq!(found(root), []);
    list(root, "sub-P1", true).unwrap();
    assert_eq!(fs::read_to_string(root.join(FILE)).unwrap(), text);
}

#[test]
fn a_link_in_place_of_a_file_is_named_beside_the_others() {
    let folder = data_set();
    let root = folder.path();
    ["sub-P1", "sub-P2"].iter().for_each(|subject| list(root, subject, true).unwrap());
    fs::remove_file(root.join("sub-P1/sub-P1_scans.tsv")).unwrap();
    std::os::unix::fs::symlink("/nowhere", root.join("sub-P1/sub-P1_scans.tsv")).unwrap();
    put(root, "README.md", "abc");
    let found = changes(root).unwrap();
    let texts: Vec<String> = found.iter().map(ToString::to_string).collect();
    assert_eq!(texts.len(), 3, "{texts:?}");
    assert!(texts[0].starts_with("README.md: is not as it was written"), "{texts:?}");
    assert_eq!(texts[1], "sub-P1/sub-P1_scans.tsv: is missing");
    assert!(
        texts[2].starts_with("sub-P1/sub-P1_scans.tsv: is a symbolic link, which SHA256SUMS cannot cover"),
        "{texts:?}"
    );
}

#[test]
fn open_sessions_and_an_unlisted_plan_are_named_as_open() {
    let folder = data_set();
    let root = folder.path();
    ["sub-P1", "sub-P2"].iter().for_each(|subject| list(root, subject, true).unwrap());
    let open = || open_parts(root).unwrap().into_iter().collect::<Vec<_>>();
    assert_eq!(open(), [""; 0]);
    put(root, CHANGED, "abc");
    put(root, "sub-P3/sub-P3_scans.tsv", "");
    assert_eq!(open(), [CHANGED]);
    let log = r#"{"participant": "P3", "index": 0, "kind": "person", "order": [], "item_runs": []}"#;
    put(root, "sourcedata/sub-P3/session.json", log);
    assert_eq!((open(), found(root)), (vec![CHANGED.into(), "sub-P3 (the session is not over)".into()], vec![]));
    // The program that writes the plan lists it, and takes it off the list when it goes.
    list_changed_plan(root).unwrap();
    assert_eq!((open(), listed(root)[CHANGED].as_str()), (vec!["sub-P3 (the session is not over)".into()], OF_ABC));
    put(root, CHANGED, "");
    assert_eq!(found(root), [(CHANGED.into(), false)]);
    fs::remove_file(root.join(CHANGED)).unwrap();
    list_changed_plan(root).unwrap();
    assert_eq!(found(root), []);
}

#[test]
fn a_folder_that_cannot_be_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let gone = folder.path().join("gone");
    let error = files(&gone).unwrap_err().to_string();
    assert!(error.contains(gone.to_str().unwrap()), "{error}");
}

#[test]
fn a_participant_is_listed_when_the_session_is_over() {
    let folder = data_set();
    let root = folder.path();
    list(root, "sub-P1", false).unwrap();
    assert_eq!(names(root), ["README.md", "participants.tsv", "phenotype/ssq.tsv"]);
    list(root, "sub-P2", true).unwrap();
    let of_p2 = ["sourcedata/sub-P2/session.json", "sub-P2/sub-P2_scans.tsv"];
    assert_eq!(names(root), ["README.md", "participants.tsv", "phenotype/ssq.tsv", of_p2[0], of_p2[1]]);
    list(root, "sub-P1", true).unwrap();
    assert_eq!(names(root), DATA);
    // The entries of a session that is continued are removed; the other participant's stay.
    list(root, "sub-P1", false).unwrap();
    assert_eq!(names(root), ["README.md", "participants.tsv", "phenotype/ssq.tsv", of_p2[0], of_p2[1]]);
}

#[test]
fn raw_data_keep_their_checksums_and_published_tables_get_new_ones() {
    let folder = data_set();
    let root = folder.path();
    let sidecars = ["events.json", "tracksys-codrive_channels.json"];
    sidecars.iter().for_each(|name| put(root, name, ""));
    for subject in ["sub-P1", "sub-P2"] {
        list(root, subject, true).unwrap();
    }
    // Every file was changed, and the data set is published again with another participant.
    DATA.iter().chain(&sidecars).for_each(|name| put(root, name, "abc"));
    list(root, "sub-P2", true).unwrap();
    let anew = ["participants.tsv", "phenotype/ssq.tsv", "sub-P2/sub-P2_scans.tsv", sidecars[0], sidecars[1]];
    for (name, sum) in listed(root) {
        assert_eq!(sum, if anew.contains(&name.as_str()) { OF_ABC } else { OF_NOTHING }, "{name}");
    }
    let differ: Vec<(String, bool)> =
        DATA.iter().filter(|name| !anew.contains(name)).map(|name| ((*name).to_owned(), false)).collect();
    assert_eq!(found(root), differ);
}

#[test]
fn missing_and_changed_files_are_told_apart() {
    let folder = data_set();
    let root = folder.path();
    assert_eq!(found(root), [(FILE.into(), false)], "there is no list");
    list(root, "sub-P1", true).unwrap();
    list(root, "sub-P2", true).unwrap();
    assert_eq!(found(root), []);
    put(root, "README.md", "abc");
    fs::remove_file(root.join("sub-P1/sub-P1_scans.tsv")).unwrap();
    let found = changes(root).unwrap();
    assert_eq!(
        found.iter().map(|change| change.file.as_str()).collect::<Vec<_>>()[..2],
        ["README.md", "sub-P1/sub-P1_scans.tsv"]
    );
    assert!(found[0].what.contains("SHA-256 differs") && found[1].what == "is missing", "{found:?}");
}

#[test]
fn an_unlisted_file_is_reported_unless_its_session_is_open() {
    let folder = data_set();
    let root = folder.path();
    for subject in ["sub-P1", "sub-P2"] {
        list(root, subject, true).unwrap();
    }
    assert_eq!(found(root), []);
    // Files of an analysis, a what-if recording, a signature or an operating system are not data.
    for beside in [
        "derivatives/codrive/trials.csv",
        "sourcedata/sub-P1/drive-what-if-none/ego.parquet",
        "SHA256SUMS.sig",
        "sourcedata/sub-P1/drive/manifest.json.sig",
        "sub-P1/.DS_Store",
    ] {
        put(root, beside, "abc");
    }
    assert_eq!(found(root), []);
    for added in ["notes.txt", "sub-P1/beh/more.tsv", "sourcedata/sub-P2/drive/ego.parquet"] {
        put(root, added, "abc");
        let found = changes(root).unwrap();
        assert!(
            found.len() == 1 && found[0].file == added && found[0].what.contains("is not in SHA256SUMS"),
            "{found:?}"
        );
        fs::remove_file(root.join(added)).unwrap();
    }
    // Only beside recordings is a what-if no data.
    for added in ["phenotype/ssq-what-if-x.tsv", "sub-P1/a-what-if-b.tsv", "sourcedata/sub-P1/what-if-x"] {
        put(root, added, "abc");
        assert_eq!(found(root), [(added.to_owned(), false)]);
        fs::remove_file(root.join(added)).unwrap();
    }
    // Remove one entry after another from the list.
    let whole = fs::read_to_string(root.join(FILE)).unwrap();
    for name in DATA {
        let text: String =
            whole.lines().filter(|line| !line.ends_with(&format!("  {name}"))).map(|l| format!("{l}\n")).collect();
        put(root, FILE, &text);
        assert_eq!(found(root), [(name.to_owned(), false)]);
    }
    put(root, FILE, &whole);
    // The session of P1 is open: its files may change until it is over; those of others may not.
    let log = r#"{"participant": "P1", "index": 0, "kind": "person", "order": [], "item_runs": []}"#;
    put(root, "sourcedata/sub-P1/session.json", log);
    forget(root, "sourcedata/sub-P1").unwrap();
    forget(root, "sub-P1").unwrap();
    assert_eq!(found(root), []);
    put(root, "sourcedata/sub-P2/more.txt", "abc");
    assert_eq!(found(root), [("sourcedata/sub-P2/more.txt".into(), false)]);
}

#[test]
fn a_folder_is_taken_off_the_list_and_its_neighbours_stay() {
    let folder = data_set();
    let root = folder.path();
    forget(root, "sourcedata").unwrap();
    assert!(!root.join(FILE).exists(), "no list is made where there was none");
    list(root, "sub-P1", true).unwrap();
    let before = names(root);
    forget(root, "sourcedata/sub-P1/drive").unwrap();
    let off = "sourcedata/sub-P1/drive/ego.parquet";
    let left: Vec<String> = before.into_iter().filter(|name| name != off).collect();
    assert_eq!(names(root), left, "drive-baseline begins with the same letters and stays");
    // Publishing the participant lists the file again.
    list(root, "sub-P1", true).unwrap();
    assert!(names(root).contains(&off.to_owned()));
}

#[test]
fn a_file_belongs_to_the_participant_of_its_folder() {
    for (name, of) in [
        ("sub-P1/beh/x.tsv", Some("sub-P1")),
        ("sourcedata/sub-P1/session.json", Some("sub-P1")),
        ("README.md", None),
        ("phenotype/ssq.tsv", None),
        ("sub-notes.txt", None),
    ] {
        assert_eq!(of_subject(name), of, "{name}");
    }
}

#[test]
fn a_malformed_list_is_refused_with_its_line() {
    let folder = data_set();
    for (line, is_list) in [
        (format!("{OF_ABC}  a"), true),
        (format!("{OF_ABC} a"), false),
        ("abc  a".to_owned(), false),
        (format!("{OF_ABC}0  a"), false),
    ] {
        put(folder.path(), FILE, &format!("{OF_NOTHING}  b\n{line}\n"));
        match read(folder.path()) {
            Ok(_) => assert!(is_list, "{line}"),
            Err(error) => assert!(!is_list && error.to_string().contains("SHA256SUMS, line 2: allowed is"), "{error}"),
        }
    }
    // A folder of that name is an error, not a missing list.
    let folder = data_set();
    fs::create_dir(folder.path().join(FILE)).unwrap();
    assert!(read(folder.path()).is_err());
}
