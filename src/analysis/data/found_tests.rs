//! Contents of folders, for data sets written by hand.

use super::*;
use std::fs;

const HEAD: &str = "filename\tsegment\tplace\tcondition\tdensity\tseed\trecording\tbaseline";

/// A data set of a study whose conditions are "loose" and "dense", in that order.
struct StudyFixture(tempfile::TempDir);

impl StudyFixture {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        fs::write(place.root().join("dataset_description.json"), r#"{ "Name": "Of two roads" }"#).unwrap();
        place
    }

    fn root(&self) -> &Path {
        self.0.path()
    }

    /// Writes the table of a participant's drives.
    fn scans(&self, subject: &str, rows: &[&str]) {
        let folder = self.root().join(subject);
        fs::create_dir_all(&folder).unwrap();
        let text = [HEAD].iter().chain(rows).fold(String::new(), |text, row| text + row + "\n");
        fs::write(folder.join(format!("{subject}_scans.tsv")), text).unwrap();
        let levels = r#"{ "condition": { "Levels": { "loose": "few cars", "dense": "many" } } }"#;
        fs::write(folder.join(format!("{subject}_scans.json")), levels).unwrap();
    }
}

fn fault(folder: &Path) -> String {
    find(folder).expect_err("nothing to analyse").to_string()
}

#[test]
fn drives_have_participant_place_condition_levels_and_baseline_in_order() {
    let place = StudyFixture::new();
    place.scans(
        "sub-P02",
        &["b1\ttrial\t1\tdense\thigh\t5\tsourcedata/sub-P02/trial-1-dense\tsourcedata/sub-P02/trial-1-dense-baseline"],
    );
    place.scans(
        "sub-P01",
        &[
            "a0\tpractice\tn/a\tn/a\tn/a\t3\tsourcedata/sub-P01/practice\tn/a",
            "a1\ttrial\t1\tloose\tlow\t4\tsourcedata/sub-P01/trial-1-loose\tn/a",
        ],
    );
    let held = find(place.root()).unwrap();
    assert_eq!((held.title.as_str(), held.out), ("Of two roads", place.root().join("derivatives/codrive")));
    let [practice, first, second] = &held.found[..] else { panic!("{:?}", held.found) };
    assert_eq!(
        *practice,
        FoundRecording {
            participant: "sub-P01".into(),
            segment: "practice".into(),
            // After all conditions of the study.
            rank: 2,
            levels: vec![("density".into(), String::new())],
            recording: place.root().join("sourcedata/sub-P01/practice"),
            ..FoundRecording::default()
        }
    );
    assert_eq!(practice.title(), "sub-P01 practice");
    assert_eq!((first.title().as_str(), first.rank, &first.baseline), ("sub-P01 trial 1 loose", 0, &None));
    assert_eq!((second.participant.as_str(), second.rank), ("sub-P02", 1));
    assert_eq!(second.levels, [("density".to_owned(), "high".to_owned())]);
    assert_eq!(second.baseline, Some(place.root().join("sourcedata/sub-P02/trial-1-dense-baseline")));

    // One participant alone, by the folder of the tables or by that of the recordings.
    let sources = place.root().join("sourcedata/sub-P01");
    fs::create_dir_all(&sources).unwrap();
    for folder in [place.root().join("sub-P01"), sources] {
        let held = find(&folder).unwrap();
        assert_eq!((held.title.as_str(), held.found.len()), ("sub-P01", 2));
        assert_eq!(held.out, place.root().join("derivatives/codrive/sub-P01"));
    }
}

#[test]
fn a_recording_is_found_with_the_baseline_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let [drive, baseline] = ["p1", "p1-baseline"].map(|name| folder.path().join(name));
    fs::create_dir(&drive).unwrap();
    fs::write(drive.join("manifest.json"), "{}").unwrap();
    let held = find(&drive).unwrap();
    assert_eq!((held.title.as_str(), held.out), ("p1", drive.join("analysis")));
    assert_eq!(held.found, [FoundRecording { recording: drive.clone(), ..FoundRecording::default() }]);
    fs::create_dir(&baseline).unwrap();
    assert_eq!(find(&drive).unwrap().found[0].baseline, Some(baseline));
}

#[test]
fn excluded_participants_are_left_out_and_incomplete_ones_are_named() {
    let place = StudyFixture::new();
    for subject in ["sub-P01", "sub-P02", "sub-P03", "sub-P04"] {
        place.scans(subject, &["a\ttrial\t1\tloose\tlow\t4\tx\tn/a"]);
    }
    let table = "participant_id\tkind\tstate\nsub-P01\tperson\tcomplete\nsub-P02\tperson\texcluded\n\
                 sub-P03\tperson\twithdrawn\nsub-P04\tperson\tpartial\nsub-P09\tperson\tcomplete\n";
    fs::write(place.root().join("participants.tsv"), table).unwrap();
    fs::create_dir(place.root().join("phenotype")).unwrap();
    let scores = "participant_id\tage\tscore_total\nsub-P01\t30\t7.48\nsub-P02\t31\t90\nsub-P03\t32\tn/a\n";
    fs::write(place.root().join("phenotype/ssq_after.tsv"), scores).unwrap();
    let held = find(place.root()).unwrap();
    let found: Vec<&str> = held.found.iter().map(|found| found.participant.as_str()).collect();
    assert_eq!(found, ["sub-P01", "sub-P03", "sub-P04"]);
    assert_eq!(held.people.to_string(), "1 complete, 1 partial (sub-P04), 1 withdrawn (sub-P03), 1 excluded (sub-P02)");
    assert!(!held.people.is_rehearsal());
    let [total] = &held.people.scores[..] else { panic!("{:?}", held.people.scores) };
    assert_eq!((total.questionnaire.as_str(), total.name.as_str(), &total.values), ("ssq_after", "total", &vec![7.48]));
    fs::write(place.root().join("participants.tsv"), table.replace("person", "simulated")).unwrap();
    assert!(find(place.root()).unwrap().people.is_rehearsal());
    // An excluded participant is not analysed alone either.
    assert!(fault(&place.root().join("sub-P02")).contains("is not excluded; look into participants.tsv"));
    fs::write(place.root().join("participants.tsv"), "participant_id\tkind\nsub-P01\tperson\n").unwrap();
    assert!(fault(place.root()).contains("participants.tsv: there is no column \"state\""));
}

#[test]
fn an_empty_folder_and_a_broken_table_are_errors_that_name_the_fault() {
    let place = StudyFixture::new();
    let outside = tempfile::tempdir().unwrap();
    assert!(fault(outside.path()).contains("holds nothing to analyse; name a recording"), "{}", fault(outside.path()));
    let other = place.root().join("phenotype");
    fs::create_dir(&other).unwrap();
    assert!(fault(&other).contains("holds nothing to analyse"));
    assert!(fault(place.root()).contains("holds no drive that came to its end"), "{}", fault(place.root()));
    place.scans("sub-P01", &["a\ttrial\t1\tloose\tlow\t4\tx\tn/a", "b\ttrial\t2"]);
    assert!(
        fault(place.root()).contains("sub-P01_scans.tsv: line 3 has 3 cells instead of 8"),
        "{}",
        fault(place.root())
    );
    let table = place.root().join("sub-P01/sub-P01_scans.tsv");
    fs::write(&table, HEAD.replace("recording", "recorded") + "\n").unwrap();
    assert!(fault(place.root()).contains("there is no column \"recording\""), "{}", fault(place.root()));
}

#[test]
fn a_list_of_drives_or_a_sidecar_that_cannot_be_read_is_an_error() {
    let place = StudyFixture::new();
    place.scans("sub-P01", &["a\ttrial\t1\tloose\tlow\t4\tx\tn/a"]);
    place.scans("sub-P02", &[]);
    fs::write(place.root().join("sub-P02/sub-P02_scans.tsv"), b"filename\n\xff\n").unwrap();
    assert!(
        fault(place.root()).contains("sub-P02_scans.tsv: cannot be read: it is no UTF-8 text"),
        "{}",
        fault(place.root())
    );
    place.scans("sub-P02", &[]);
    fs::write(place.root().join("sub-P02/sub-P02_scans.json"), "no JSON").unwrap();
    assert!(fault(place.root()).contains("sub-P02_scans.json: is not JSON"), "{}", fault(place.root()));
}
