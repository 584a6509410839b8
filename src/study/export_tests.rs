//! Tests of the export: all data of the participant, nothing of others, complete or absent.

use super::*;
use crate::study::{Session, Study, session::ParticipantKind};

const STUDY: &str = r#"title = "Pages"
participants = 2
[base]
traffic = "native"
[[segment]]
kind = "questions"
name = "load"
questionnaire = "raw-tlx"
"#;

fn code(text: &str) -> ParticipantCode {
    ParticipantCode::new(text).unwrap()
}

/// Makes a data set in which P1 and P2 have answered, with results of an analysis.
fn place() -> (tempfile::TempDir, DataSet) {
    let folder = tempfile::tempdir().unwrap();
    let study = Study::parse(STUDY.to_owned(), Path::new("pages.toml")).unwrap_or_else(|e| panic!("{e}"));
    let data = DataSet::open(&folder.path().join("data"), &study).unwrap();
    for (index, name) in ["P1", "P2"].into_iter().enumerate() {
        let mut session = Session::open(&data, &study, &code(name), ParticipantKind::Person, index, "t0").unwrap();
        session.begin("2026-05-03T10:00:00Z").unwrap();
        let answer = crate::study::session::TimedAnswer { question: "mental".into(), answer: 40.into(), time_s: 1.0 };
        session.end_answered(vec![answer], None, "t2").unwrap();
        session.finish("t3").unwrap();
        drop(session);
        data.publish(&study, &code(name)).unwrap();
    }
    let derived = data.root().join("derivatives/codrive");
    fs::create_dir_all(&derived).unwrap();
    fs::write(derived.join("trials.csv"), "participant,note\nsub-P1,\"two\nlines\"\nsub-P2,x\n").unwrap();
    fs::write(derived.join("README.md"), "# Pages\n").unwrap();
    fs::write(derived.join("conditions.csv"), "condition,mean\na,1.5\n").unwrap();
    (folder, data)
}

fn names(folder: &Path) -> Vec<String> {
    checksums::files(folder).unwrap()
}

#[test]
fn an_export_has_all_data_of_the_participant_and_none_of_others() {
    let (folder, data) = place();
    let to = folder.path().join("for-p1");
    // Locks and symbolic links are not data of a participant.
    let own = data.root().join("sourcedata/sub-P1");
    fs::write(own.join(lock::FILE), b"").unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(data.root().join("sourcedata/sub-P2/session.json"), own.join("other.json")).unwrap();
    let count = data.export(&code("P1"), &to).unwrap();
    let wanted = [
        ".bidsignore",
        "README.md",
        "dataset_description.json",
        "participants.json",
        "participants.tsv",
        "phenotype/load.json",
        "phenotype/load.tsv",
        "sourcedata/sub-P1/date-shift.json",
        "sourcedata/sub-P1/session.json",
        "study.toml",
        "sub-P1/beh/sub-P1_task-load_beh.json",
        "sub-P1/beh/sub-P1_task-load_beh.tsv",
        "sub-P1/sub-P1_scans.json",
        "sub-P1/sub-P1_scans.tsv",
    ];
    assert_eq!((names(&to).as_slice(), count), (wanted.map(str::to_owned).as_slice(), wanted.len()));
    for name in wanted.iter().filter(|name| **name != "README.md") {
        assert!(!fs::read_to_string(to.join(name)).unwrap().contains("P2"), "{name}");
    }
    let same = |name: &str| assert_eq!(fs::read(to.join(name)).unwrap(), fs::read(data.root().join(name)).unwrap());
    for name in ["sourcedata/sub-P1/session.json", "sub-P1/sub-P1_scans.tsv", "sourcedata/sub-P1/date-shift.json"] {
        same(name);
    }
    let rows = fs::read_to_string(to.join("phenotype/load.tsv")).unwrap();
    assert!(rows.lines().count() == 2 && rows.contains("\nsub-P1\t40\t"), "{rows}");
    let trials = fs::read_to_string(to.join("derivatives/codrive/trials.csv")).unwrap();
    assert_eq!(trials, "participant,note\nsub-P1,\"two\nlines\"\n");
    assert!(!to.join("derivatives/codrive/conditions.csv").exists(), "means are of all");
    assert_eq!(fs::read_to_string(to.join("derivatives/codrive/README.md")).unwrap(), "# Pages\n");
    assert_eq!(checksums::changes(&to).unwrap(), []);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = |name: &str| fs::metadata(to.join(name)).unwrap().permissions().mode() & 0o077;
        wanted.iter().for_each(|name| assert_eq!(mode(name), 0, "{name} is the user's alone"));
    }
}

#[test]
fn an_export_is_complete_or_absent_and_restarts_after_a_cut() {
    let (folder, data) = place();
    let to = folder.path().join("mine");
    fs::create_dir(&to).unwrap();
    let part = begin(&to).unwrap();
    fs::write(part.join("old"), "half").unwrap();
    assert!(names(&to).is_empty(), "a cut leaves the place empty");
    data.export(&code("P2"), &to).unwrap();
    assert!(!part.exists() && !to.join("old").exists() && !to.join(BEGUN).exists());
    // Existing data are left alone: a folder with contents, a folder that only looks like a cut export, a folder in the data set.
    let refused = |to: &Path, has: &str| {
        let message = data.export(&code("P2"), to).unwrap_err().to_string();
        assert!(message.contains(has), "{message}");
    };
    refused(&to, "already exists; name a new or an empty folder");
    refused(&data.root().join("mine"), "is in the data set");
    let strange = folder.path().join("other.part");
    fs::create_dir(&strange).unwrap();
    refused(&folder.path().join("other"), "is not an interrupted export");
    assert!(strange.exists());
}
