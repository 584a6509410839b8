//! The fast motion sickness scale while driving, as a participant and an experimenter meet it.

use crate::rig::Rig;
use codrive::{
    panel::{ParticipantScreen, SessionCommand},
    study::{Completion, FmsPrompt, FmsRating, FormInput, ItemOutcome, session::EndCause},
};

const STUDY: &str = r#"title = "Sickness"
participants = 2
order = "fixed"
[base]
traffic = "native"
duration_s = 200.0
[[condition]]
name = "narrow"
[[condition]]
name = "wide"
[[segment]]
kind = "trials"
name = "trial"
fms_every_s = 60.0
stop_above = { score = "fms", value = 10.0 }
[[segment]]
kind = "questions"
name = "end"
questionnaire = "acceptance"
"#;

fn prompt(rig: &mut Rig) -> Option<FmsPrompt> {
    let now = rig.road.now;
    match rig.live_session().screen(now) {
        ParticipantScreen::Rating(prompt) => Some(prompt),
        ParticipantScreen::Drive(_) => None,
        other => panic!("{other:?}"),
    }
}

/// Changes the number by `turn` and confirms, `after_s` after the question appeared.
fn answer(rig: &mut Rig, turn: i32, after_s: f64) {
    rig.pass(after_s);
    rig.input(FormInput::Turn(turn));
    rig.input(FormInput::Next);
}

fn ratings(rig: &Rig) -> Vec<(String, f64, Option<u8>)> {
    let round = |time_s: f64| (time_s * 10.0).round() / 10.0;
    rig.log().fms.into_iter().map(|r| (r.recording, round(r.rating.time_s), r.rating.value)).collect()
}

#[test]
fn a_question_comes_each_minute_and_every_response_is_recorded_and_logged() {
    let mut rig = Rig::of(STUDY);
    rig.drive_off();
    rig.pass(59.0);
    assert_eq!((prompt(&mut rig), rig.road.notes.len()), (None, 0));
    // No question is open, so the keys of the scale do nothing.
    rig.input(FormInput::Turn(5));
    rig.input(FormInput::Next);
    rig.pass(1.1);
    assert_eq!(prompt(&mut rig).map(|prompt| prompt.value), Some(0));
    assert_eq!(rig.road.notes, ["fms_asked: ", "chime"]);
    // A held drive takes no response, and the time of the question stops.
    rig.command(SessionCommand::Pause);
    rig.input(FormInput::Turn(9));
    rig.pass(30.0);
    rig.command(SessionCommand::Resume);
    answer(&mut rig, 3, 2.0);
    assert_eq!(prompt(&mut rig), None);
    let message = rig.road.notes.last().unwrap().clone();
    assert!(message.starts_with("fms 3: 3 of 20 after 2."), "{message}");
    // The next question starts at the last response and disappears after 15 s.
    rig.pass(60.0);
    assert_eq!(prompt(&mut rig).map(|prompt| prompt.value), Some(3));
    rig.input(FormInput::Turn(1));
    rig.pass(14.0);
    assert_eq!(rig.road.notes.last().unwrap(), "fms_unanswered: no answer in 15 s");
    assert_eq!(prompt(&mut rig), None);
    // The third question comes at 180 s; the drive ends at 200 s.
    rig.pass(46.0);
    answer(&mut rig, -1, 1.0);
    let of = |time_s: f64, value: Option<u8>| ("trial-1-narrow".to_owned(), time_s, value);
    assert_eq!(ratings(&rig), [of(60.0, Some(3)), of(120.0, None), of(180.0, Some(2))]);
    assert_eq!(rig.live_session().ratings().as_deref(), Some("FMS (0 to 20) 3, no answer, 2"));
    rig.pass(20.0);
    rig.next();
    // In the next drive the question starts at the last response of this drive.
    rig.drive_off();
    rig.pass(60.1);
    assert_eq!(prompt(&mut rig).map(|prompt| prompt.value), Some(2));
    // A cut loses the drive, but no rating.
    rig.open();
    assert_eq!(ratings(&rig).len(), 3);
    rig.command(SessionCommand::Go);
    rig.drive_off();
    rig.pass(60.1);
    assert_eq!(prompt(&mut rig).map(|prompt| prompt.value), Some(2));
    answer(&mut rig, 0, 1.0);
    let again = rig.log().fms.pop().unwrap();
    assert_eq!((again.item.as_str(), again.recording.as_str()), ("trial-2-wide", "trial-2-wide-again-1"));
    assert!(matches!(again.rating, FmsRating { value: Some(2), .. }));
}

#[test]
fn a_rating_above_its_limit_ends_drive_and_session_and_gives_the_reason() {
    let mut rig = Rig::of(STUDY);
    rig.drive_off();
    rig.pass(60.1);
    answer(&mut rig, 10, 1.0);
    assert_eq!(rig.sees(), "drive trial-1-narrow", "at the limit the drive goes on");
    rig.pass(60.0);
    answer(&mut rig, 1, 1.0);
    assert!(rig.live_session().is_over() && rig.road.folder.is_none(), "the recording has ended");
    let reason = "trial-1-narrow: fms is 11, above 10 (stop_above)";
    assert_eq!(rig.road.notes.last().unwrap(), &format!("stopped: {reason}"));
    let log = rig.log();
    let end = log.end.as_ref().unwrap();
    assert_eq!((end.cause, end.reason.as_str()), (Some(EndCause::ScoreLimit), reason));
    assert_eq!((end.complete, Completion::of(&log)), (false, Completion::Withdrawn));
    assert_eq!(rig.item_runs(), [("trial-1-narrow".into(), ItemOutcome::Aborted)]);
    assert_eq!(log.fms.last().map(|rated| rated.rating.value), Some(Some(11)));
    let (now, words) = (rig.road.now, rig.study.file.texts.score_limit.clone());
    assert!(matches!(rig.live_session().screen(now), ParticipantScreen::Wait(message) if message == words));
    let message = rig.live_session().error().unwrap_or_default().to_owned();
    assert!(message.contains(reason), "{message}");
    // The session is over for every input of participant and experimenter.
    rig.input(FormInput::Next);
    rig.refused(SessionCommand::Skip("late".into()), "the session is over");
}
