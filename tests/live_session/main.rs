//! A participant's session without a window: inputs of the participant and decisions of the experimenter, on a road that only counts time.
//! Every step must be on the disk.

mod drive;
mod force;
mod overview;
mod people;
mod practice;
mod rating;
mod rig;
mod standing_start;
mod stops;
mod voice;
mod wheel;

use codrive::{
    analysis::data::people::STATES,
    panel::{ItemState, ParticipantScreen, SessionCommand, SessionPhase},
    record::RecordError,
    session::BackendStatus,
    study::{Completion, DataSet, FormInput, ItemOutcome, ParticipantCode, Session, session::ParticipantKind},
};
use rig::Rig;

fn reason(text: &str) -> String {
    text.into()
}

#[test]
fn a_session_runs_from_welcome_to_thanks_with_every_step_on_the_disk() {
    let mut rig = Rig::new();
    assert!(matches!(rig.live_session().screen(BackendStatus::default()), ParticipantScreen::Page("# Hello")));
    assert_eq!(rig.running(), "welcome");
    rig.input(FormInput::Next);
    assert_eq!(rig.running(), "welcome", "a page is not pressed away before it can be read");
    rig.next();
    assert_eq!(rig.sees(), "text before before");
    rig.next();
    assert_eq!(rig.sees(), "questions before, page 1 of 2");
    rig.pass(2.0);
    rig.answer();
    let answers = &rig.log().answers["before"];
    assert_eq!(answers.len(), 6);
    assert!((answers[0].time_s - 2.0).abs() < 0.01, "{answers:?}: since the page was seen");

    assert_eq!((rig.running().as_str(), rig.sees().as_str()), ("practice", "text before practice"));
    rig.next();
    assert_eq!(rig.sees(), "practice is loading");
    rig.pass(0.1);
    assert_eq!(rig.sees(), "countdown to practice");
    assert_eq!(rig.road.scenario.as_ref().unwrap().duration_s, 30.0);
    assert!(matches!(rig.live_session().screen(BackendStatus::default()), ParticipantScreen::Countdown(3, 0, _)));
    rig.pass(2.5);
    assert!(
        matches!(rig.live_session().screen(BackendStatus::default()), ParticipantScreen::Countdown(1, 0, _))
            && rig.road.folder.is_none()
    );
    rig.pass(0.6);
    assert_eq!(rig.road.folder, Some(rig.out.join("sourcedata/sub-P03/practice")));
    // The practice ends by its criterion, before its 30 s.
    rig.pass(3.0);
    // 1.9 s in the range, a step out of it, and another 1.9 s are not 2 s without a break.
    (0..39).for_each(|k| rig.road.now.practice.in_range.add(k != 19, 0.1));
    rig.pass(0.1);
    assert_eq!(rig.sees(), "drive practice");
    let now = rig.road.now;
    let message = rig.live_session().practice(now);
    assert_eq!(message.as_deref(), Some("in the range without a break for 1.9 s of 2 s, at best 1.9 s"));
    rig.road.now.practice.in_range.add(true, 0.1);
    rig.pass(0.1);
    assert_eq!((rig.sees().as_str(), rig.running().as_str()), ("the drive is over", "nothing"));
    assert_eq!(rig.road.notes, ["criterion: 2 s in the range without a break"]);

    rig.next();
    assert_eq!(rig.sees(), "rest rest");
    rig.next();
    assert_eq!(rig.sees(), "rest rest", "the rest is not over");
    let phase = rig.live_session().phase(BackendStatus::default());
    assert_eq!(phase, SessionPhase::Resting);
    rig.pass(9.5);
    rig.next();
    for name in ["trial-1-narrow", "trial-2-wide"] {
        assert_eq!(rig.running(), name);
        rig.drive_off();
        assert_eq!(
            rig.live_session().left_s(BackendStatus { duration_s: 8.0, time_s: 3.0, ..BackendStatus::default() }),
            Some(5.0)
        );
        rig.pass(8.1);
        assert_eq!(rig.sees(), "the drive is over");
        rig.next();
    }
    assert!(rig.live_session().is_over() && rig.log().end.is_some_and(|end| end.complete));
    assert!(rig.item_runs().iter().all(|(_, outcome)| *outcome == ItemOutcome::Done));
    assert_eq!((rig.live_session().progress(), Completion::of(&rig.log())), ([6, 6], Completion::Complete));
    rig.refused(SessionCommand::Stop(reason("late")), "the session is over");
    rig.refused(SessionCommand::Skip(reason("late")), "the session is over");
}

#[test]
fn after_a_cut_the_session_resumes_at_the_cut_item_on_command() {
    let mut rig = Rig::new();
    // At each kind of item: a page, questions, the text before a drive, the drive itself, a rest.
    type Step = (&'static str, fn(&mut Rig));
    let steps: [Step; 5] = [
        ("welcome", |_| ()),
        ("before", |rig| {
            rig.next();
            rig.next();
            rig.input(FormInput::Turn(1));
            rig.input(FormInput::Next);
        }),
        ("practice", |rig| {
            rig.next();
            rig.answer();
        }),
        ("practice", |rig| {
            rig.drive_off();
            rig.pass(2.0);
        }),
        ("rest", |rig| {
            rig.drive_off();
            rig.pass(30.5);
            rig.next();
            rig.pass(5.0);
        }),
    ];
    for (cut, (name, go)) in steps.into_iter().enumerate() {
        go(&mut rig);
        assert_eq!(rig.running(), name);
        rig.open();
        let last = rig.log().item_runs.pop().unwrap();
        assert_eq!((last.item.as_str(), last.outcome, rig.running().as_str()), (name, ItemOutcome::Cut, "nothing"));
        let screen = rig.live_session().screen(BackendStatus::default());
        assert!(matches!(screen, ParticipantScreen::Wait(_)), "cut {cut}: {screen:?}");
        assert!(rig.live_session().items().iter().any(|item| item.name == name && item.state == ItemState::Again));
        rig.next();
        assert_eq!(rig.running(), "nothing", "the participant waits");
        rig.command(SessionCommand::Go);
        assert_eq!(rig.running(), name);
    }
    assert_eq!(rig.live_session().left_s(BackendStatus::default()), Some(10.0), "a rest begins again");
    let recordings: Vec<String> = rig.log().item_runs.into_iter().filter_map(|p| p.recording).collect();
    assert_eq!(recordings, ["practice", "practice-again-1"]);
}

#[test]
fn responses_survive_a_cut_and_a_repeated_questionnaire_starts_empty() {
    let mut rig = Rig::new();
    rig.next();
    rig.next();
    let answers = |rig: &mut Rig, options: &[usize]| {
        for (stop, option) in options.iter().enumerate() {
            rig.input(FormInput::Pick { stop, option: *option });
        }
    };
    answers(&mut rig, &[3, 7]);
    rig.open();
    let cut = rig.log().item_runs.pop().unwrap();
    let given: Vec<(String, f64)> =
        cut.answers.iter().map(|a| (a.question.clone(), a.answer.as_f64().unwrap())).collect();
    assert_eq!(given, [("mental".to_owned(), 15.0), ("physical".to_owned(), 35.0)]);

    rig.command(SessionCommand::Go);
    rig.next();
    let ParticipantScreen::Questions(form) = rig.live_session().screen(BackendStatus::default()) else {
        panic!("questions")
    };
    assert_eq!((form.answered(), form.focus()), (cut.answers.clone(), 2));
    // A second cut before any new response: the responses are kept.
    rig.open();
    assert_eq!(rig.log().item_runs.pop().unwrap().answers, cut.answers);

    rig.command(SessionCommand::Go);
    rig.next();
    rig.answer();
    let log = rig.log();
    assert_eq!(log.answers["before"].len(), 6);
    assert_eq!(log.answers["before"][..2], cut.answers);
    assert!(log.last("before").unwrap().answers.is_empty(), "they stand with the answers");

    rig.command(SessionCommand::Repeat { item: "before".into(), reason: reason("once more") });
    rig.command(SessionCommand::Abort(reason("it comes first")));
    rig.command(SessionCommand::Go);
    rig.next();
    let ParticipantScreen::Questions(form) = rig.live_session().screen(BackendStatus::default()) else {
        panic!("questions")
    };
    assert!(form.answered().is_empty());
}

#[test]
fn items_broken_off_or_called_back_are_run_again() {
    let mut rig = Rig::new();
    rig.until_practice();
    rig.drive_off();
    rig.pass(1.0);
    rig.command(SessionCommand::Abort(reason("the phone rang")));
    assert_eq!(rig.road.notes, ["aborted: the phone rang"]);
    assert!(
        rig.road.scenario.is_none() && rig.live_session().phase(BackendStatus::default()) == SessionPhase::Experimenter
    );
    let last = rig.log().item_runs.pop().unwrap();
    assert_eq!((last.outcome, last.reason.as_str()), (ItemOutcome::Aborted, "the phone rang"));
    rig.refused(SessionCommand::Abort(reason("again")), "there is no item to break off");
    rig.command(SessionCommand::Go);
    assert_eq!(rig.sees(), "text before practice");
    let practice = rig.live_session().items().into_iter().find(|item| item.name == "practice").unwrap();
    assert_eq!((practice.earlier.as_str(), practice.state), ("broken off", ItemState::Now));

    // A repeat while another item runs: the repeated item comes next. A repeat of the running item breaks it off.
    rig.command(SessionCommand::Repeat { item: "welcome".into(), reason: reason("did not read it") });
    assert_eq!(rig.running(), "practice");
    rig.command(SessionCommand::Repeat { item: "practice".into(), reason: reason("wrong seat") });
    assert_eq!(rig.running(), "nothing");
    rig.command(SessionCommand::Go);
    assert_eq!(rig.running(), "welcome");
    rig.refused(SessionCommand::Repeat { item: "rest".into(), reason: reason("x") }, "cannot be repeated");
    rig.next();
    assert_eq!(rig.running(), "practice");
}

#[test]
fn skipping_omits_the_running_or_the_next_item() {
    let mut rig = Rig::new();
    rig.command(SessionCommand::Skip(reason("knows it")));
    assert_eq!(rig.running(), "before", "on to the next");
    rig.command(SessionCommand::Skip(reason("no time")));
    rig.drive_off();
    rig.command(SessionCommand::Skip(reason("no time")));
    assert_eq!(
        (rig.road.notes.as_slice(), rig.running().as_str()),
        (["skipped: no time".to_owned()].as_slice(), "nothing")
    );
    // No item runs: the next item is skipped, and the participant keeps waiting.
    rig.command(SessionCommand::Skip(reason("not tired")));
    assert_eq!(rig.running(), "nothing");
    rig.command(SessionCommand::Go);
    assert_eq!(rig.running(), "trial-1-narrow");
    assert!(rig.item_runs().iter().all(|(_, outcome)| *outcome == ItemOutcome::Skipped));
    for _ in 0..2 {
        rig.command(SessionCommand::Skip(reason("enough")));
    }
    assert!(rig.live_session().is_over());
}

#[test]
fn drives_and_rests_are_extended_held_and_resumed() {
    let mut rig = Rig::new();
    rig.refused(SessionCommand::Extend { seconds: 5.0, reason: reason("x") }, "no drive or rest to extend");
    rig.refused(SessionCommand::Pause, "there is no drive to pause");
    rig.until_practice();
    rig.next();
    rig.pass(0.1);
    rig.command(SessionCommand::Pause);
    rig.pass(5.0);
    assert_eq!(rig.live_session().phase(BackendStatus::default()), SessionPhase::Held, "a countdown is held too");
    rig.command(SessionCommand::Resume);
    rig.pass(3.2);
    rig.command(SessionCommand::Pause);
    let now = rig.road.now;
    assert!(now.held && matches!(rig.live_session().screen(now), ParticipantScreen::Drive(Some(_))));
    rig.pass(60.0);
    rig.command(SessionCommand::Go);
    assert!(!rig.road.now.held && rig.sees() == "drive practice");
    rig.refused(SessionCommand::Extend { seconds: 0.0, reason: reason("x") }, "1 to 3600 s");
    rig.command(SessionCommand::Extend { seconds: 20.0, reason: reason("came late") });
    rig.pass(40.0);
    assert_eq!(rig.sees(), "drive practice");
    rig.pass(10.5);
    assert_eq!(rig.sees(), "the drive is over");
    let message = ["paused: by the experimenter", "resumed: by the experimenter", "extended: by 20 s: came late"];
    assert_eq!(rig.road.notes, message);
    let kinds: Vec<String> = rig.log().notes.into_iter().map(|note| note.kind).collect();
    assert_eq!(kinds, ["paused", "resumed", "paused", "resumed", "extended"]);

    rig.next();
    rig.command(SessionCommand::Extend { seconds: 30.0, reason: reason("needs air") });
    rig.pass(20.0);
    assert_eq!(rig.live_session().phase(BackendStatus::default()), SessionPhase::Resting);
    rig.command(SessionCommand::Go);
    assert_eq!(rig.running(), "trial-1-narrow", "the experimenter ends a rest");
    assert!(rig.log().notes.last().is_some_and(|note| note.kind == "go" && note.text.contains("20 s sooner")));
}

#[test]
fn notes_and_marks_are_in_the_session_and_during_drives_in_the_recording() {
    let mut rig = Rig::new();
    rig.command(SessionCommand::Note(reason("left-handed")));
    rig.until_practice();
    rig.drive_off();
    rig.command(SessionCommand::Mark(String::new()));
    rig.input(FormInput::Mark);
    rig.command(SessionCommand::Note(reason("coughs")));
    let Rig { live_session, road, .. } = &mut rig;
    live_session.as_mut().unwrap().note_contact("contact with car 3, closing at 4.2 m/s", road).unwrap();
    assert_eq!(rig.road.notes, ["mark: by the experimenter", "mark: by the participant", "note: coughs"]);
    let notes = rig.log().notes;
    let list: Vec<(&str, Option<&str>)> = notes.iter().map(|n| (n.text.as_str(), n.item.as_deref())).collect();
    let practice = Some("practice");
    assert_eq!(list[0], ("left-handed", Some("welcome")));
    let contact = ("contact with car 3, closing at 4.2 m/s", practice);
    assert_eq!(
        list[1..],
        [("by the experimenter", practice), ("by the participant", practice), ("coughs", practice), contact]
    );
    assert_eq!(notes.last().map(|note| note.kind.as_str()), Some("contact"), "the recording has an event of its own");
}

#[test]
fn a_request_to_stop_holds_the_drive_and_sickness_ends_the_session() {
    let mut rig = Rig::new();
    rig.until_practice();
    rig.drive_off();
    rig.input(FormInput::Stop);
    assert!(rig.road.now.held && rig.live_session().asked().is_some());
    let words = rig.study.file.texts.asked.clone();
    let now = rig.road.now;
    assert!(matches!(rig.live_session().screen(now), ParticipantScreen::Drive(Some(text)) if text == words));
    rig.command(SessionCommand::Go);
    assert!(!rig.road.now.held && rig.live_session().asked().is_none());
    rig.input(FormInput::Stop);
    rig.command(SessionCommand::Stop(reason("sickness")));
    assert!(rig.live_session().is_over() && rig.road.scenario.is_none());
    assert!(rig.road.notes.contains(&"stopped: sickness".into()), "{:?}", rig.road.notes);
    let end = rig.log().end.unwrap();
    assert_eq!((end.complete, end.reason.as_str()), (false, "sickness"));
    rig.live_session = None;
    let data = DataSet::open(&rig.out, &rig.study).unwrap();
    let again =
        Session::open(&data, &rig.study, &ParticipantCode::new("P03").unwrap(), ParticipantKind::Person, 0, "later");
    assert!(again.unwrap_err().to_string().contains("stopped for good (sickness"));
}

#[test]
fn a_request_to_stop_holds_every_screen_until_the_experimenter_decides() {
    let mut rig = Rig::new();
    // Screen before each request, and the participant's inputs that lead to it.
    type Step = (&'static str, fn(&mut Rig));
    let steps: [Step; 7] = [
        ("page welcome", |_| ()),
        ("text before before", Rig::next),
        ("questions before, page 1 of 2", Rig::next),
        ("text before practice", Rig::answer),
        ("practice is loading", Rig::next),
        ("countdown to practice", |rig| rig.pass(0.5)),
        ("rest rest", |rig| {
            rig.pass(4.0);
            (0..20).for_each(|_| rig.road.now.practice.in_range.add(true, 0.1));
            rig.pass(0.1);
            rig.next();
        }),
    ];
    let words = rig.study.file.texts.asked.clone();
    for (sees, go) in steps {
        go(&mut rig);
        assert_eq!(rig.sees(), sees);
        rig.pass(0.1);
        let (before, left_s) = (rig.sees(), rig.live_session().left_s(BackendStatus::default()));
        let answered = rig.log().running.map(|running| running.answers);
        rig.input(FormInput::Stop);
        rig.pass(60.0);
        for input in [FormInput::Next, FormInput::PageOn, FormInput::Pick { stop: 0, option: 3 }, FormInput::Next] {
            rig.input(input);
        }
        rig.pass(60.0);
        assert_eq!(
            (rig.sees(), rig.live_session().left_s(BackendStatus::default())),
            (before, left_s),
            "nothing went on"
        );
        assert_eq!(rig.log().running.map(|running| running.answers), answered);
        let screen = rig.live_session().screen(BackendStatus::default());
        let (ParticipantScreen::Wait(message) | ParticipantScreen::Drive(Some(message))) = screen else {
            panic!("{screen:?}")
        };
        assert_eq!(message, words);
        assert_eq!(rig.live_session().phase(BackendStatus::default()), SessionPhase::Held, "Go and Resume are offered");
        rig.command(SessionCommand::Go);
        assert!(
            rig.live_session().asked().is_none() && rig.sees() == sees || sees == "practice is loading",
            "as it was"
        );
    }
    let kinds: Vec<String> = rig.log().notes.into_iter().map(|note| note.kind).collect();
    assert_eq!(kinds, ["asked", "resumed"].repeat(7), "each with the experimenter's answer");
    // The other decisions of the experimenter.
    rig.input(FormInput::Stop);
    rig.command(SessionCommand::Skip(reason("enough rest")));
    assert!(rig.live_session().asked().is_none() && rig.sees() == "text before trial-1-narrow");
    rig.input(FormInput::Stop);
    rig.command(SessionCommand::Abort(reason("coffee")));
    assert!(rig.live_session().asked().is_none() && rig.sees() == "please wait");
}

#[test]
fn a_session_is_complete_partial_withdrawn_or_excluded() {
    let state = |rig: &Rig| Completion::of(&rig.log());
    let to_the_end = |rig: &mut Rig| {
        rig.next();
        rig.next();
        rig.answer();
        for skip in 0..4 {
            assert_eq!(state(rig), Completion::Open, "{skip} skipped");
            rig.command(SessionCommand::Skip(reason("no time")));
        }
        assert!(rig.live_session().is_over());
    };
    let words = Completion::ALL.map(|completion| completion.to_string());
    let others: Vec<&str> = STATES.into_iter().filter(|state| !words.iter().any(|word| word == state)).collect();
    assert_eq!(others, ["damaged"], "analyse knows them all, and that of a participant whose files cannot be read");
    assert_eq!(words.len() + 1, STATES.len());
    // All drives were skipped, and the first was broken off before: such a session is not complete.
    let mut rig = Rig::new();
    to_the_end(&mut rig);
    assert_eq!((rig.log().end.unwrap().complete, state(&rig)), (true, Completion::Partial));
    assert!(rig.live_session().items().iter().all(|item| item.earlier.is_empty()), "each was skipped once");
    rig.command(SessionCommand::Exclude(reason("wrong glasses")));
    assert_eq!(
        (state(&rig), rig.log().end.unwrap().excluded.as_deref()),
        (Completion::Excluded, Some("wrong glasses"))
    );
    rig.refused(SessionCommand::Exclude(reason("again")), "already excluded");

    let mut rig = Rig::new();
    rig.until_practice();
    rig.drive_off();
    rig.command(SessionCommand::Stop(reason("sickness")));
    assert_eq!(state(&rig), Completion::Withdrawn);
    let mut rig = Rig::new();
    rig.until_practice();
    rig.drive_off();
    rig.command(SessionCommand::StopTechnically(reason("the wheel was lost")));
    assert_eq!(
        (state(&rig), rig.log().end.unwrap().reason.as_str()),
        (Completion::EndedTechnically, "the wheel was lost")
    );
    rig.refused(SessionCommand::StopTechnically(reason("again")), "the session is over");

    // An exclusion during a drive also ends the session.
    let mut rig = Rig::new();
    rig.until_practice();
    rig.drive_off();
    rig.command(SessionCommand::Exclude(reason("no licence")));
    assert!(
        rig.live_session().is_over()
            && rig.road.scenario.is_none()
            && rig.road.notes.contains(&"excluded: no licence".into())
    );
    assert_eq!((rig.log().end.unwrap().complete, state(&rig)), (false, Completion::Excluded));
}

#[test]
fn a_failing_drive_is_reported_and_comes_again() {
    let mut rig = Rig::new();
    rig.until_practice();
    rig.road.fails = true;
    rig.next();
    rig.pass(0.2);
    assert!(rig.live_session().error().is_some_and(|error| error.contains("no road")));
    assert_eq!(rig.live_session().phase(BackendStatus::default()), SessionPhase::Experimenter);
    rig.road.fails = false;
    rig.command(SessionCommand::Go);
    assert!(rig.live_session().error().is_none());
    rig.drive_off();
    let Rig { live_session, road, .. } = &mut rig;
    live_session.as_mut().unwrap().fail(&RecordError::Full(8).into(), road);
    let last = rig.log().item_runs.pop().unwrap();
    assert!(last.outcome == ItemOutcome::Aborted && last.reason.contains("the disk writer stalled"), "{last:?}");
    assert_eq!(rig.sees(), "please wait");
}

#[test]
fn on_a_full_disk_the_session_waits_says_why_and_keeps_its_log() {
    let mut rig = Rig::new();
    rig.until_practice();
    rig.drive_off();
    // Nothing can be written: a folder has the name of the new log.
    let source = rig.out.join("sourcedata/sub-P03");
    let in_the_way = source.join("session.new");
    std::fs::create_dir(&in_the_way).unwrap();
    let path = rig.road.folder.clone().unwrap().join("journal/rows.blocks");
    let full = RecordError::File { path: path.clone(), why: std::io::Error::from_raw_os_error(28) };
    let Rig { live_session, road, .. } = &mut rig;
    live_session.as_mut().unwrap().fail(&full.into(), road);
    let error = rig.live_session().error().unwrap().to_owned();
    assert!(error.contains(path.to_str().unwrap()) && error.contains("make room on the disk"), "{error}");
    assert!(error.contains("The session's log: ") && error.contains("session"), "{error}");
    assert_eq!(rig.sees(), "please wait");
    std::fs::remove_dir(&in_the_way).unwrap();
    rig.command(SessionCommand::Go);
    let last = rig.log().item_runs.pop().unwrap();
    assert_eq!(last.outcome, ItemOutcome::Aborted);
    assert!(last.reason.starts_with("journal/rows.blocks: No space left"), "{}", last.reason);
}
