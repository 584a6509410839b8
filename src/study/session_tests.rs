//! Tests of a session on disk: saved data, resumption, refusals.

use super::{
    Completion, DataSet, ItemOutcome, ParticipantCode, Session, SessionError, Study, checksums, places,
    session::{EndCause, FILE, ParticipantKind, SessionLog, TimedAnswer},
};
use serde_json::json;
use std::{fs, os::unix::fs::MetadataExt, path::Path};

const STUDY: &str = r#"title = "Two pages"
participants = 2
[base]
traffic = "native"
[[segment]]
kind = "questions"
name = "before"
questionnaire = "raw-tlx"
[[segment]]
kind = "text"
name = "thanks"
text = "Thanks."
"#;

struct SessionFixture {
    folder: tempfile::TempDir,
    study: Study,
    data: DataSet,
}

fn place() -> SessionFixture {
    let folder = tempfile::tempdir().unwrap();
    let study = Study::parse(STUDY.to_owned(), Path::new("two.toml")).unwrap_or_else(|e| panic!("{e}"));
    let data = DataSet::open(&folder.path().join("data"), &study).unwrap();
    SessionFixture { folder, study, data }
}

impl SessionFixture {
    fn open(&self, code: &str, kind: ParticipantKind) -> Result<Session, SessionError> {
        Session::open(&self.data, &self.study, &ParticipantCode::new(code).unwrap(), kind, 0, "t0")
    }
}

fn answers(n: usize) -> Vec<TimedAnswer> {
    let one = |i| TimedAnswer { question: format!("q{i}"), answer: json!(i), time_s: 1.5 };
    (0..n).map(one).collect()
}

fn on_disk(session: &Session) -> SessionLog {
    SessionLog::load(&session.folder().join(FILE)).unwrap()
}

#[test]
fn answers_are_saved_at_once_and_unchanged_ones_are_not_rewritten() {
    let place = place();
    let mut session = place.open("P1", ParticipantKind::Person).unwrap();
    session.keep(answers(1)).unwrap();
    assert!(on_disk(&session).running.is_none(), "nothing runs that they could be of");
    session.begin("t1").unwrap();
    // A replaced file has another inode.
    let file = |session: &Session| fs::metadata(session.folder().join(FILE)).unwrap().ino();
    session.keep(answers(1)).unwrap();
    let written = (file(&session), on_disk(&session).running.unwrap().answers);
    assert_eq!(written.1, answers(1));
    session.keep(answers(1)).unwrap();
    assert_eq!(file(&session), written.0);
    session.keep(answers(2)).unwrap();
    assert_ne!(file(&session), written.0);
    assert_eq!(on_disk(&session).running.unwrap().answers, answers(2));
}

#[test]
fn answers_survive_a_cut_but_not_an_abort() {
    let place = place();
    let mut session = place.open("P1", ParticipantKind::Person).unwrap();
    session.begin("t1").unwrap();
    assert!(session.kept().is_empty());
    session.keep(answers(2)).unwrap();
    drop(session);
    let mut session = place.open("P1", ParticipantKind::Person).unwrap();
    let last = session.log().last("before").unwrap();
    assert_eq!(
        (last.outcome, last.began.as_str(), last.reason.as_str()),
        (ItemOutcome::Cut, "t1", "the program ended")
    );
    session.begin("t2").unwrap();
    assert_eq!((session.kept(), on_disk(&session).running.unwrap().answers), (&answers(2)[..], answers(2)));
    // Cut again before any new answer: the earlier answers remain.
    drop(session);
    let mut session = place.open("P1", ParticipantKind::Person).unwrap();
    session.begin("t2").unwrap();
    assert_eq!(session.kept(), answers(2));
    session.keep(answers(1)).unwrap();
    assert_eq!(session.kept(), answers(1));
    session.end(ItemOutcome::Aborted, "phone", "t3").unwrap();
    session.begin("t4").unwrap();
    assert!(session.kept().is_empty(), "they broke off themselves");
    session.end_answered(answers(3), None, "t5").unwrap();
    let log = on_disk(&session);
    assert_eq!((log.answers["before"].clone(), log.done("before").unwrap().answers.len()), (answers(3), 0));
    assert_eq!(session.next().map(|(place, planned)| (place, planned.name.as_str())), Some((1, "thanks")));
    session.skip("no time", "t6").unwrap();
    assert!(session.log().is_settled("thanks") && session.log().done("thanks").is_none());
    session.finish("t7").unwrap();
    assert!(on_disk(&session).end.is_some_and(|end| end.complete && end.at == "t7"));
}

#[test]
fn a_session_belongs_to_one_participant_program_andfolder() {
    let place = place();
    let message = |found: Result<Session, SessionError>| found.map(drop).map_err(|e| e.to_string());
    let session = place.open("P1", ParticipantKind::Person).unwrap();
    assert!(
        message(place.open("P1", ParticipantKind::Person))
            .unwrap_err()
            .contains("another program runs the session of participant")
    );
    drop(session);
    assert!(message(place.open("P1", ParticipantKind::Simulated)).unwrap_err().contains("participant P1 is a person"));
    drop(place.open("R1", ParticipantKind::Simulated).unwrap());
    assert!(message(place.open("R1", ParticipantKind::Person)).unwrap_err().contains("participant R1 is simulated"));
    // The session file of another participant in this folder.
    let [p1, p2] = ["P1", "P2"].map(|code| place.data.source(&ParticipantCode::new(code).unwrap()));
    fs::create_dir_all(&p2).unwrap();
    fs::copy(p1.join(FILE), p2.join(FILE)).unwrap();
    assert!(message(place.open("P2", ParticipantKind::Person)).unwrap_err().contains("is of participant P1"));
    // The temporary file of an interrupted first save is accepted; a recording without its session file is not.
    fs::remove_file(p2.join(FILE)).unwrap();
    fs::write(p2.join("session.new"), "{").unwrap();
    assert_eq!(message(place.open("P2", ParticipantKind::Person)), Ok(()));
    fs::remove_file(p2.join(FILE)).unwrap();
    fs::write(p2.join("trial"), "").unwrap();
    assert!(
        message(place.open("P2", ParticipantKind::Person)).unwrap_err().contains("holds trial but no session.json")
    );
}

#[test]
fn completion_follows_the_last_run_of_each_item() {
    let place = place();
    let is = |session: &Session| Completion::of(&on_disk(session));
    let whole = |code: &str, skip: bool| {
        let mut session = place.open(code, ParticipantKind::Person).unwrap();
        for item in ["before", "thanks"] {
            assert_eq!(
                (session.next().map(|(_, planned)| planned.name.as_str()), is(&session)),
                (Some(item), Completion::Open)
            );
            session.begin("t1").unwrap();
            session.end(if skip { ItemOutcome::Skipped } else { ItemOutcome::Done }, "", "t2").unwrap();
        }
        session
    };
    let mut complete = whole("P1", false);
    assert!(complete.exclude("late").unwrap_err().to_string().contains("the session is not over"));
    complete.finish("t3").unwrap();
    assert_eq!(is(&complete), Completion::Complete);
    complete.exclude("fell asleep").unwrap();
    assert_eq!(
        (is(&complete), on_disk(&complete).end.unwrap().excluded.as_deref()),
        (Completion::Excluded, Some("fell asleep"))
    );
    assert!(complete.exclude("once more").unwrap_err().to_string().contains("already excluded"));
    assert_eq!(on_disk(&complete).end.unwrap().excluded.as_deref(), Some("fell asleep"));

    let mut partial = whole("P2", true);
    partial.finish("t3").unwrap();
    assert_eq!(is(&partial), Completion::Partial);
    // An item that was skipped and then done counts as done.
    let mut after_all = whole("P3", true);
    for item in ["before", "thanks"] {
        after_all.repeat(item, "there is time", "t3").unwrap();
        after_all.begin("t4").unwrap();
        after_all.end(ItemOutcome::Done, "", "t5").unwrap();
    }
    after_all.finish("t6").unwrap();
    assert_eq!(is(&after_all), Completion::Complete);
    let mut withdrawn = place.open("P4", ParticipantKind::Person).unwrap();
    withdrawn.stop("sick", "t1").unwrap();
    assert_eq!(is(&withdrawn), Completion::Withdrawn);
    // With the windows closed: sessions that are over, and sessions that were left open.
    drop((complete, partial));
    let mut left = place.open("P5", ParticipantKind::Person).unwrap();
    left.begin("t1").unwrap();
    let exclude =
        |code: &str| place.data.exclude(&place.study, &ParticipantCode::new(code).unwrap(), "no licence", "t9");
    let refused = |code: &str| exclude(code).unwrap_err().to_string();
    assert!(refused("P5").contains("another program runs the session of participant"), "{}", refused("P5"));
    drop(left);
    assert!(refused("P6").contains("there is no participant P6") && refused("P6").ends_with("P1, P2, P3, P4, P5"));
    assert!(refused("P1").contains("already excluded"));
    // A log of another participant that cannot be read refuses the exclusion, which changes nothing.
    let log_of = |code: &str| place.data.source(&ParticipantCode::new(code).unwrap()).join(FILE);
    let [mine, other] = ["P2", "P4"].map(|code| fs::read_to_string(log_of(code)).unwrap());
    fs::write(log_of("P4"), &other[..9]).unwrap();
    assert!(refused("P2").contains("not a session of this program"), "{}", refused("P2"));
    assert_eq!(fs::read_to_string(log_of("P2")).unwrap(), mine);
    fs::write(log_of("P4"), other).unwrap();
    let table = || fs::read_to_string(place.data.root().join("participants.tsv")).unwrap();
    for (code, complete) in [("P2", true), ("P5", false)] {
        exclude(code).unwrap();
        let log = SessionLog::load(&place.data.source(&ParticipantCode::new(code).unwrap()).join(FILE)).unwrap();
        let end = log.end.as_ref().unwrap();
        assert_eq!((Completion::of(&log), end.complete), (Completion::Excluded, complete));
        assert_eq!(end.excluded.as_deref(), Some("no licence"));
        assert!(log.running.is_none());
        let row = table().lines().find(|row| row.starts_with(&format!("sub-{code}\t"))).unwrap().to_owned();
        assert!(row.contains("\texcluded"), "{row}");
    }
    let words = Completion::ALL.map(|completion| completion.to_string());
    assert_eq!(
        words,
        ["open", "complete", "partial", "withdrawn", "ended_technically", "declined", "not_eligible", "excluded"]
    );
    assert!(Completion::ALL.iter().all(|state| state.meaning().len() > 10));
}

#[test]
fn a_technical_end_is_a_state_of_its_own_until_the_data_are_excluded() {
    let place = place();
    let mut session = place.open("P1", ParticipantKind::Person).unwrap();
    session.begin("t1").unwrap();
    session.stop_technically("the computer broke down", "t2").unwrap();
    let log = on_disk(&session);
    assert_eq!(Completion::of(&log), Completion::EndedTechnically);
    let end = log.end.unwrap();
    assert_eq!(
        (end.complete, end.reason.as_str(), end.cause),
        (false, "the computer broke down", Some(EndCause::Technical))
    );
    assert_eq!(log.item_runs.last().map(|run| run.outcome), Some(ItemOutcome::Aborted));
    session.exclude("no data").unwrap();
    assert_eq!(Completion::of(&on_disk(&session)), Completion::Excluded);
}

impl SessionFixture {
    /// Takes a participant to the end of the plan.
    fn whole(&self, code: &str) -> Session {
        let mut session = self.open(code, ParticipantKind::Person).unwrap();
        for _ in 0..2 {
            session.begin("2026-01-01T10:00:00Z").unwrap();
            session.end(ItemOutcome::Done, "", "2026-01-01T10:00:01Z").unwrap();
        }
        session.finish("2026-01-01T10:00:02Z").unwrap();
        session
    }

    fn publish(&self, code: &str) {
        self.data.publish(&self.study, &ParticipantCode::new(code).unwrap()).unwrap();
    }

    /// Returns the differences from the list of files and from the log.
    fn faults(&self) -> Vec<String> {
        let root = self.data.root();
        let (listed, placed) = (checksums::changes(root).unwrap(), places::misplaced(root).unwrap());
        listed.iter().chain(&placed).map(ToString::to_string).collect()
    }
}

#[test]
fn a_note_a_mark_and_an_exclusion_after_the_end_are_sealed_again() {
    let place = place();
    let mut session = place.whole("P1");
    place.publish("P1");
    assert_eq!(place.faults(), [""; 0]);
    for kind in ["note", "mark", "note"] {
        session.note(kind, "late", "2026-01-01T10:05:00Z").unwrap();
        place.publish("P1");
        assert_eq!(place.faults(), [""; 0], "after a {kind}");
    }
    session.exclude("asleep").unwrap();
    place.publish("P1");
    assert_eq!(place.faults(), [""; 0], "after an exclusion");
    // What another program writes is no late note, and stays a change.
    drop(session);
    let path = place.data.root().join("sourcedata/sub-P1/session.json");
    fs::write(&path, fs::read_to_string(&path).unwrap().replacen("late", "soon", 1)).unwrap();
    place.publish("P1");
    let faults = place.faults();
    assert!(faults.len() == 1 && faults[0].contains("session.json: is not as it was written"), "{faults:?}");
}

#[test]
fn a_session_that_was_killed_at_its_end_is_listed_with_the_next() {
    let place = place();
    // The program ends before it publishes the participant.
    drop(place.whole("P1"));
    let open_elsewhere = place.whole("P3");
    drop(place.whole("P2"));
    place.publish("P2");
    let of_p3 = place.faults().into_iter().filter(|fault| fault.contains("sub-P3")).count();
    assert_eq!(place.faults().len(), of_p3, "P1 is sealed, and P3's own window still has to: {:?}", place.faults());
    drop(open_elsewhere);
    place.publish("P3");
    assert_eq!(place.faults(), [""; 0]);
}

#[test]
fn an_item_is_not_recorded_through_a_link() {
    let place = place();
    let mut session = place.open("P1", ParticipantKind::Person).unwrap();
    let mine = place.folder.path().join("mine");
    fs::create_dir(&mine).unwrap();
    std::os::unix::fs::symlink(&mine, session.folder().join("before")).unwrap();
    let error = session.begin("t1").unwrap_err().to_string();
    assert!(error.contains("sub-P1/before is a symbolic link") && error.contains("remedy"), "{error}");
}
