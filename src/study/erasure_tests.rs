//! Tests of the erasure of a participant: removed data, remaining data, and completion of an erasure that was cut at any step.

use super::*;
use crate::study::{Session, Study, session::ParticipantKind};
use serde_json::json;

const STUDY: &str = r#"title = "Load"
participants = 2
[base]
traffic = "native"
[[segment]]
kind = "questions"
name = "load"
questionnaire = "raw-tlx"
"#;

struct ErasureFixture {
    folder: tempfile::TempDir,
    study: Study,
    data: DataSet,
}

fn code(text: &str) -> ParticipantCode {
    ParticipantCode::new(text).unwrap()
}

/// Makes a data set in which P1 and P2 have answered, with results of an analysis and a folder of another program.
fn place() -> ErasureFixture {
    let folder = tempfile::tempdir().unwrap();
    let study = Study::parse(STUDY.to_owned(), Path::new("load.toml")).unwrap_or_else(|e| panic!("{e}"));
    let data = DataSet::open(&folder.path().join("data"), &study).unwrap();
    for (index, name) in ["P1", "P2"].into_iter().enumerate() {
        let mut session = Session::open(&data, &study, &code(name), ParticipantKind::Person, index, "t0").unwrap();
        session.begin("2026-05-03T10:00:00Z").unwrap();
        let rated = ["mental", "physical", "temporal", "performance", "effort", "frustration"];
        let answer = |question: &&str| crate::study::session::TimedAnswer {
            question: (*question).into(),
            answer: json!(40),
            time_s: 1.0,
        };
        session.end_answered(rated.iter().map(answer).collect(), None, "t2").unwrap();
        session.finish("t3").unwrap();
        drop(session);
        data.publish(&study, &code(name)).unwrap();
    }
    for (name, text) in [
        ("derivatives/codrive/trials.csv", "participant,value\nsub-P1,1\nsub-P2,2\n"),
        ("derivatives/codrive/conditions.csv", "condition,mean\na,1.5\n"),
        ("analysis/conditions.csv", "condition,mean\na,1.5\n"),
        ("report/index.html", "<p>1.5</p>"),
        ("derivatives/other/sub-P1/x.txt", "P1"),
        ("derivatives/other/sub-P2/x.txt", "P2"),
        (
            "derivatives/other/notes.tsv",
            "at\tparticipant\ttext\nt1\tsub-P1\tfelt sick\nt2\tsub-P2\tfine\nt3\tP1\tagain\n",
        ),
        ("derivatives/other/deep/model.json", "{\"people\": [\"sub-P1\", \"sub-P2\"]}"),
        ("derivatives/other/figure_sub-P1.svg", "<svg/>"),
        ("derivatives/other/figure_sub-P12.svg", "<svg/>"),
        ("phenotype/older.new", "participant_id\nsub-P1"),
    ] {
        let path = data.root().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    ErasureFixture { folder, study, data }
}

/// Returns every file of the data set with its text.
fn all(root: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap().flatten() {
            if entry.path().is_dir() {
                folders.push(entry.path());
            } else {
                found.push((entry.path(), fs::read_to_string(entry.path()).unwrap()));
            }
        }
    }
    found
}

#[track_caller]
fn assert_erased(place: &ErasureFixture) {
    let root = place.data.root();
    for (path, text) in all(root) {
        let is_ledger = path.file_name().is_some_and(|name| name == "erased.tsv");
        assert!(is_ledger || !text.replace("P12", "").contains("P1"), "{}: {text}", path.display());
        // Checks only names below the data set: the path of the temporary folder is random.
        let name = path.strip_prefix(root).unwrap();
        assert!(!name.to_string_lossy().replace("P12", "").contains("P1"), "{}", name.display());
    }
    for name in [BEGUN, "derivatives/codrive", "analysis", "report"] {
        assert!(!root.join(name).exists(), "{name}");
    }
    let ledger = fs::read_to_string(root.join("erased.tsv")).unwrap();
    assert_eq!(ledger, "participant_id\treason\terased_at\nsub-P1\twithdrew consent\tt9\n");
    // P2 is complete: log, answers, rows, and all files as listed.
    assert!(
        root.join("sourcedata/sub-P2/session.json").exists() && root.join("derivatives/other/sub-P2/x.txt").exists()
    );
    assert!(root.join("derivatives/other/figure_sub-P12.svg").exists(), "another one");
    let notes = fs::read_to_string(root.join("derivatives/other/notes.tsv")).unwrap();
    assert_eq!(notes, "at\tparticipant\ttext\nt2\tsub-P2\tfine\n");
    let shift = fs::read_to_string(root.join("sourcedata/sub-P2/date-shift.json")).unwrap();
    assert!(shift.starts_with("{\"days\":-"), "{shift}");
    assert!(root.join("sub-P2/sub-P2_scans.tsv").exists());
    for table in ["participants.tsv", "phenotype/load.tsv"] {
        let text = fs::read_to_string(root.join(table)).unwrap();
        let rows: Vec<&str> = text.lines().map(|line| line.split('\t').next().unwrap()).collect();
        assert_eq!(rows, ["participant_id", "sub-P2"], "{table}");
    }
    assert_eq!(checksums::changes(root).unwrap(), []);
}

#[test]
fn erasing_leaves_one_line_and_changes_no_other_participant() {
    let place = place();
    let left = place.data.erase(&code("P1"), "withdrew consent", "t9").unwrap();
    assert_eq!(left, LeftBehind { naming: Vec::new(), others: vec![place.data.root().join("derivatives/other")] });
    assert_erased(&place);
    // An unreadable list is an error, not an empty list.
    let list = place.data.root().join(LEDGER).with_extension("tsv");
    let written = fs::read(&list).unwrap();
    fs::write(&list, [0xff, b'\n']).unwrap();
    assert!(erased(place.data.root()).is_err());
    fs::write(&list, written).unwrap();
    let ignored = fs::read_to_string(place.data.root().join(".bidsignore")).unwrap();
    assert!(ignored.contains("erased.tsv\n"), "{ignored}");
    // The place in the balanced orders is free again; the code is not.
    assert_eq!(place.data.next_index().unwrap(), 0);
    let again = |name: &str| Session::open(&place.data, &place.study, &code(name), ParticipantKind::Person, 0, "t10");
    for name in ["P1", "p1"] {
        let message = again(name).unwrap_err().to_string();
        assert!(message.contains("was erased (withdrew consent, t9); use another code"), "{message}");
    }
    again("P3").unwrap();
    let message = place.data.erase(&code("P1"), "x", "t11").unwrap_err().to_string();
    assert!(
        message.contains("participant P1 was erased (withdrew consent, t9); no data of them are left"),
        "{message}"
    );
}

#[test]
fn an_erasure_cut_after_any_step_is_finished_by_the_next_start() {
    for done in 0..STEPS.len() {
        for by_analysis in [false, true] {
            let place = place();
            let root = place.data.root();
            let erasure = Erasure { participant: code("P1"), reason: "withdrew consent".into(), at: "t9".into() };
            fs::write(root.join(BEGUN), serde_json::to_string(&erasure).unwrap()).unwrap();
            STEPS[..done].iter().for_each(|step| step(&erasure, root).unwrap());
            if by_analysis {
                finish_around(&root.join("sub-P2")).unwrap();
            } else {
                DataSet::open(root, &place.study).unwrap();
            }
            assert_erased(&place);
        }
    }
}

#[test]
fn unknown_codes_and_running_sessions_are_refused() {
    let place = place();
    let message = place.data.erase(&code("P7"), "x", "t9").unwrap_err().to_string();
    assert!(message.contains("there is no participant P7") && message.contains("there are: P1, P2"), "{message}");
    let message = place.data.export(&code("P7"), &place.folder.path().join("to")).unwrap_err().to_string();
    assert!(message.contains("there are: P1, P2"), "{message}");
    let _session = Session::open(&place.data, &place.study, &code("P3"), ParticipantKind::Person, 2, "t0").unwrap();
    let message = place.data.erase(&code("P3"), "x", "t9").unwrap_err().to_string();
    assert!(message.contains("another program runs the session of participant P3"), "{message}");
    assert!(!place.data.root().join(BEGUN).exists(), "what is refused is not begun");
}

#[test]
fn a_lab_file_that_names_the_erased_participant_is_reported_and_stays() {
    let place = place();
    let readme = place.data.root().join("NOTES.md");
    fs::write(&readme, "sub-P1 came late.\n").unwrap();
    let left = place.data.erase(&code("P1"), "withdrew consent", "t9").unwrap();
    assert_eq!(left.naming, std::slice::from_ref(&readme));
    assert_eq!(fs::read_to_string(readme).unwrap(), "sub-P1 came late.\n");
}

#[test]
fn an_unreadable_folder_stops_an_erasure_that_can_be_resumed() {
    let place = place();
    let (phenotype, aside) = (place.data.root().join("phenotype"), place.folder.path().join("aside"));
    fs::rename(&phenotype, &aside).unwrap();
    fs::write(&phenotype, "no folder").unwrap();
    let message = place.data.erase(&code("P1"), "withdrew consent", "t9").unwrap_err().to_string();
    assert!(message.contains(phenotype.to_str().unwrap()), "{message}");
    fs::remove_file(&phenotype).unwrap();
    fs::rename(&aside, &phenotype).unwrap();
    finish(place.data.root()).unwrap();
    assert_erased(&place);
}
