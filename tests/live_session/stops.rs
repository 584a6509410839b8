//! Ends of a session and of its items: motion ends at the key, a stop stands on a full disk, and no word is lost.

use crate::rig::{Rig, STUDY};
use codrive::{
    panel::{ParticipantScreen, SessionCommand, SessionPhase, StopRequest},
    session::BackendStatus,
    study::{FormInput, ItemOutcome},
};
use std::{fs, path::Path};

/// Makes the log unwritable: a folder has the name of the new log. Returns that folder.
fn fill_disk(rig: &Rig) -> std::path::PathBuf {
    let in_the_way = rig.out.join("sourcedata/sub-P03/session.new");
    fs::create_dir(&in_the_way).unwrap();
    in_the_way
}

fn screen_text(rig: &mut Rig) -> String {
    let now = rig.road.now;
    match rig.live_session().screen(now) {
        ParticipantScreen::Wait(text) | ParticipantScreen::Drive(Some(text)) => text.to_owned(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn motion_ends_before_the_reason_for_a_stop_and_a_cancelled_one_stands() {
    let mut rig = Rig::new();
    let texts = rig.study.file.texts.clone();
    // On a page, too.
    rig.command(SessionCommand::Hold);
    assert_eq!(screen_text(&mut rig), texts.wait);
    rig.next();
    assert_eq!(rig.running(), "welcome", "the participant waits");
    rig.command(SessionCommand::Go);
    rig.until_practice();
    rig.drive_off();
    for time in 0..2 {
        rig.pass(1.0);
        let moved_s = rig.road.now.time_s;
        rig.command(SessionCommand::Hold);
        assert!(rig.road.now.held, "time {time}: at the key");
        let asked = rig.live_session().asked();
        assert_eq!((asked, screen_text(&mut rig)), (Some(StopRequest::Experimenter), texts.paused.clone()));
        // The question is cancelled: no command follows.
        rig.pass(20.0);
        rig.input(FormInput::Next);
        assert_eq!((rig.road.now.time_s, rig.sees().as_str()), (moved_s, "drive practice"));
        rig.command(if time == 0 { SessionCommand::Resume } else { SessionCommand::Go });
        assert!(!rig.road.now.held && rig.live_session().asked().is_none());
    }
    rig.input(FormInput::Stop);
    rig.command(SessionCommand::Hold);
    assert_eq!(rig.live_session().asked(), Some(StopRequest::Participant), "the first request stands");
    rig.command(SessionCommand::Stop("sickness".into()));
    assert!(rig.live_session().is_over() && rig.road.scenario.is_none());
    rig.command(SessionCommand::Hold);
    assert_eq!(rig.live_session().asked(), None, "there is nothing to hold");
    let kinds: Vec<String> = rig.log().notes.into_iter().map(|note| note.kind).collect();
    assert_eq!(kinds, ["paused", "resumed", "paused", "resumed", "paused", "resumed", "asked"]);
}

#[test]
fn a_stop_on_a_full_disk_stands_on_both_windows_until_it_is_written() {
    type End = fn(String) -> SessionCommand;
    let ends: [End; 3] = [SessionCommand::Stop, SessionCommand::StopTechnically, SessionCommand::Exclude];
    for end in ends {
        let mut rig = Rig::new();
        let texts = rig.study.file.texts.clone();
        rig.until_practice();
        rig.drive_off();
        let before = rig.log();
        let in_the_way = fill_disk(&rig);
        rig.command(SessionCommand::Hold);
        assert!(rig.road.now.held && rig.live_session().waits_for_disk());
        rig.command(end("feels ill".into()));
        assert!(rig.live_session().is_over() && rig.road.scenario.is_none(), "the drive is over");
        rig.command(SessionCommand::Note("pale".into()));
        rig.command(SessionCommand::Go);
        rig.pass(5.0);
        assert!(!rig.live_session().may_close() && rig.log() == before, "nothing is written");
        let shown = screen_text(&mut rig);
        assert!(shown.contains(&texts.stopped) && shown.contains(&texts.disk), "{shown}");
        let error = rig.live_session().error().unwrap().to_owned();
        assert!(
            error.contains("The session is stopped, and its log") && error.contains("make room on the disk"),
            "{error}"
        );
        fs::remove_dir(&in_the_way).unwrap();
        rig.pass(1.1);
        assert!(!rig.live_session().waits_for_disk() && rig.live_session().may_close());
        assert_eq!(screen_text(&mut rig), texts.stopped);
        let log = rig.log();
        let ended = log.end.unwrap();
        assert_eq!((ended.reason.as_str(), ended.complete), ("feels ill", false));
        assert_eq!(log.item_runs.last().map(|run| run.outcome), Some(ItemOutcome::Aborted));
        assert!(log.notes.iter().any(|note| note.text == "pale"), "{:?}", log.notes);
    }
}

#[test]
fn nothing_goes_on_while_the_log_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut rig = Rig::of(&with_texts(folder.path()));
    let in_the_way = fill_disk(&rig);
    rig.next();
    let texts = rig.study.file.texts.clone();
    assert_eq!(screen_text(&mut rig), texts.disk);
    assert_eq!(rig.live_session().phase(BackendStatus::default()), SessionPhase::Held);
    rig.next();
    fs::remove_dir(&in_the_way).unwrap();
    rig.pass(1.1);
    rig.next();
    assert_eq!((rig.sees().as_str(), rig.running().as_str()), ("text before before", "before"));
    rig.next();
    // The end of a questionnaire, which then goes on by itself.
    type_in(&mut rig, "why not");
    (0..2).for_each(|_| rig.input(FormInput::Next));
    let in_the_way = fill_disk(&rig);
    rig.input(FormInput::Next);
    rig.pass(2.0);
    assert_eq!(screen_text(&mut rig), texts.disk);
    fs::remove_dir(&in_the_way).unwrap();
    rig.pass(1.1);
    let log = rig.log();
    assert_eq!((log.answers["before"].len(), rig.sees().as_str()), (1, "text before practice"));
    assert_eq!(log.item_runs.iter().filter(|run| run.item == "before").count(), 1, "{log:?}");
    // A drive that is held for the disk stands until the experimenter continues.
    rig.drive_off();
    let in_the_way = fill_disk(&rig);
    rig.input(FormInput::Mark);
    assert!(rig.road.now.held);
    fs::remove_dir(&in_the_way).unwrap();
    rig.pass(1.1);
    assert!(rig.road.now.held);
    rig.command(SessionCommand::Resume);
    assert!(!rig.road.now.held);
    assert_eq!(rig.log().notes.iter().filter(|note| note.kind == "mark").count(), 1);
}

/// Returns a study whose questions are two texts.
fn with_texts(folder: &Path) -> String {
    let questions = r#"{ "title": "About", "pages": [ { "elements": [
        { "type": "comment", "name": "why", "title": "Why?" }, { "type": "text", "name": "more", "title": "More?" } ] } ] }"#;
    let path = folder.join("about.json");
    fs::write(&path, questions).unwrap();
    STUDY.replace("\"raw-tlx\"", &format!("{:?}", path.to_str().unwrap()))
}

fn type_in(rig: &mut Rig, text: &str) {
    rig.input(FormInput::Type { stop: 0, text: text.into() });
}

#[test]
fn typed_words_are_kept_at_each_orderly_end_and_back_in_their_field() {
    let folder = tempfile::tempdir().unwrap();
    let reason = || "late".to_owned();
    let close = |rig: &mut Rig| {
        let Rig { live_session, road, .. } = rig;
        live_session.as_mut().unwrap().close("the window was closed", road).unwrap();
    };
    let ends: [&dyn Fn(&mut Rig); 6] = [
        &close,
        &|rig| rig.command(SessionCommand::Abort(reason())),
        &|rig| rig.command(SessionCommand::Skip(reason())),
        &|rig| rig.command(SessionCommand::Stop(reason())),
        &|rig| rig.command(SessionCommand::StopTechnically(reason())),
        &|rig| rig.command(SessionCommand::Exclude(reason())),
    ];
    for (k, end) in ends.into_iter().enumerate() {
        let mut rig = Rig::of(&with_texts(folder.path()));
        rig.next();
        rig.next();
        type_in(&mut rig, "the first dri");
        end(&mut rig);
        let log = rig.log();
        let run = log.last("before").unwrap();
        let kept: Vec<_> = run.answers.iter().map(|a| (a.question.as_str(), a.answer.as_str().unwrap())).collect();
        assert_eq!(kept, [("why", "the first dri")], "end {k}");
        assert!(!log.answers.contains_key("before"), "it was not completed");
        if k == 0 {
            rig.open();
            rig.command(SessionCommand::Go);
            rig.next();
            let ParticipantScreen::Questions(form) = rig.live_session().screen(BackendStatus::default()) else {
                panic!("questions")
            };
            assert_eq!(form.answer("why").and_then(|answer| answer.as_str()), Some("the first dri"));
        }
    }
}

#[test]
fn each_run_of_a_repeated_questionnaire_keeps_its_answers() {
    let folder = tempfile::tempdir().unwrap();
    let mut rig = Rig::of(&with_texts(folder.path()));
    rig.next();
    for (k, words) in ["first", "second", "third"].into_iter().enumerate() {
        if k > 0 {
            rig.command(SessionCommand::Repeat { item: "before".into(), reason: "once more".into() });
            rig.command(SessionCommand::Abort("it comes first".into()));
            rig.command(SessionCommand::Go);
        }
        rig.next();
        type_in(&mut rig, words);
        (0..3).for_each(|_| rig.input(FormInput::Next));
        assert_eq!(rig.sees(), "text before practice");
    }
    let log = rig.log();
    let words = |answers: &[codrive::study::session::TimedAnswer]| {
        answers.iter().map(|a| a.answer.as_str().unwrap_or_default().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(words(&log.answers["before"]), ["third"], "the last completed run counts");
    let done = log.item_runs.iter().filter(|run| run.item == "before" && run.outcome == ItemOutcome::Done);
    let runs: Vec<Vec<String>> = done.map(|run| words(&run.answers)).collect();
    assert_eq!(runs, [vec!["first".to_owned()], vec!["second".to_owned()], Vec::new()]);
}
