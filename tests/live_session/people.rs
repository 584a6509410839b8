//! Consent, screening, limits of scores, and questionnaires after every trial, as a participant meets them.

use crate::rig::Rig;
use codrive::{
    panel::{ParticipantScreen, SessionCommand, SessionPhase},
    session::BackendStatus,
    study::{Completion, FormInput, ItemOutcome, session::EndCause},
};

const STUDY: &str = r#"title = "People"
participants = 2
order = "fixed"
[base]
traffic = "native"
duration_s = 8.0
[[condition]]
name = "narrow"
[[condition]]
name = "wide"
[[segment]]
kind = "consent"
name = "consent"
text = "You will drive a car."
[[segment]]
kind = "questions"
name = "screening"
questionnaire = "screening"
ends_if = ["{licence} = false", "{vision} = 'uncorrected'", "{seizures} = true"]
[[segment]]
kind = "trials"
name = "trial"
after = ["raw-tlx"]
stop_above = { score = "raw-tlx.raw-tlx", value = 60.0 }
stop_text = "That was too much. We stop here."
[[segment]]
kind = "questions"
name = "end"
questionnaire = "acceptance"
"#;

/// Picks these options at the next stops in order, and turns the page.
fn pick(rig: &mut Rig, options: &[usize]) {
    for (stop, option) in options.iter().enumerate() {
        rig.input(FormInput::Pick { stop, option: *option });
    }
    rig.input(FormInput::PageOn);
}

fn screen_text(rig: &mut Rig) -> String {
    match rig.live_session().screen(BackendStatus::default()) {
        ParticipantScreen::Wait(text) => text.to_owned(),
        other => panic!("{other:?}"),
    }
}

/// Consents and passes the screening: yes, normal sight, never sick, and no to the rest.
fn until_trials(rig: &mut Rig) {
    rig.next();
    pick(rig, &[0]);
    pick(rig, &[0, 0]);
    pick(rig, &[0]);
    pick(rig, &[1, 1, 1]);
    assert_eq!(rig.running(), "trial-1-narrow");
}

#[test]
fn a_participant_who_declines_is_thanked_and_nothing_else_is_kept() {
    let mut rig = Rig::of(STUDY);
    assert!(matches!(
        rig.live_session().screen(BackendStatus::default()),
        ParticipantScreen::Page("You will drive a car.")
    ));
    rig.refused(SessionCommand::Skip("hurry".into()), "a participant without consent cannot take part");
    rig.next();
    assert_eq!(rig.sees(), "questions consent, page 1 of 1");
    rig.refused(SessionCommand::Skip("hurry".into()), "a participant without consent cannot take part");
    pick(&mut rig, &[1]);
    assert!(rig.live_session().is_over());
    assert_eq!(rig.live_session().phase(BackendStatus::default()), SessionPhase::Over);
    let declined = rig.study.file.texts.declined.clone();
    assert_eq!(screen_text(&mut rig), declined);
    let message = rig.live_session().error().unwrap_or_default().to_owned();
    assert!(message.contains("ended by a rule of the study: the participant did not agree"), "{message}");
    let log = rig.log();
    let end = log.end.as_ref().unwrap();
    assert_eq!(
        (end.complete, end.cause, Completion::of(&log)),
        (false, Some(EndCause::Declined), Completion::Declined)
    );
    assert_eq!(log.answers.keys().collect::<Vec<_>>(), ["consent"], "that, and nothing of the person");
    assert_eq!(rig.item_runs(), [("consent".into(), ItemOutcome::Done)]);
    rig.refused(SessionCommand::Repeat { item: "consent".into(), reason: "again".into() }, "the session is over");
}

#[test]
fn consent_holds_from_the_response_on_and_never_after_a_refusal() {
    for (answer, agrees) in [(0, true), (1, false)] {
        let mut rig = Rig::of(STUDY);
        assert!(!rig.live_session().has_consent(), "the first page");
        rig.next();
        assert!(!rig.live_session().has_consent(), "the question");
        pick(&mut rig, &[answer]);
        assert_eq!(rig.live_session().has_consent(), agrees);
    }
}

#[test]
fn a_screening_ends_the_session_by_the_answer_that_its_file_names() {
    let mut rig = Rig::of(STUDY);
    rig.next();
    pick(&mut rig, &[0]);
    pick(&mut rig, &[0, 2]);
    pick(&mut rig, &[0]);
    pick(&mut rig, &[1, 1, 1]);
    assert!(rig.live_session().is_over());
    let log = rig.log();
    let end = log.end.as_ref().unwrap();
    assert_eq!((end.cause, Completion::of(&log)), (Some(EndCause::NotEligible), Completion::NotEligible));
    assert_eq!(end.reason, "screening: {vision} = 'uncorrected' (ends_if)");
    let not_eligible = rig.study.file.texts.not_eligible.clone();
    assert_eq!(screen_text(&mut rig), not_eligible);
}

#[test]
fn questions_follow_trials_and_a_score_above_the_limit_ends_the_session() {
    let mut rig = Rig::of(STUDY);
    until_trials(&mut rig);
    rig.drive_off();
    rig.pass(8.1);
    rig.next();
    assert_eq!(rig.sees(), "questions trial-1-narrow-raw-tlx, page 1 of 2");
    // Twelve steps of five are sixty, the limit itself.
    pick(&mut rig, &[12, 12, 12]);
    pick(&mut rig, &[12, 12, 12]);
    assert_eq!(rig.running(), "trial-2-wide");
    rig.drive_off();
    rig.pass(8.1);
    rig.next();
    pick(&mut rig, &[12, 12, 12]);
    pick(&mut rig, &[12, 12, 13]);
    assert!(rig.live_session().is_over());
    assert_eq!(screen_text(&mut rig), "That was too much. We stop here.");
    let log = rig.log();
    let end = log.end.as_ref().unwrap();
    assert_eq!((end.cause, Completion::of(&log)), (Some(EndCause::ScoreLimit), Completion::Withdrawn));
    assert_eq!(end.reason, "trial-2-wide-raw-tlx: raw-tlx.raw-tlx is 60.833333, above 60 (stop_above)");
    assert_eq!(log.answers.len(), 4, "consent, screening, and two trials: {:?}", log.answers.keys());
}

#[test]
fn a_repeated_or_skipped_trial_includes_its_questions() {
    let mut rig = Rig::of(STUDY);
    until_trials(&mut rig);
    rig.drive_off();
    rig.pass(8.1);
    rig.next();
    pick(&mut rig, &[1, 1, 1]);
    pick(&mut rig, &[1, 1, 1]);
    assert_eq!(rig.running(), "trial-2-wide");
    rig.command(SessionCommand::Abort("the wheel slipped".into()));
    rig.command(SessionCommand::Repeat { item: "trial-1-narrow".into(), reason: "the same".into() });
    rig.command(SessionCommand::Go);
    assert_eq!(rig.running(), "trial-1-narrow");
    rig.drive_off();
    rig.pass(8.1);
    rig.next();
    assert_eq!(rig.running(), "trial-1-narrow-raw-tlx", "what was said of the first drive is not of this one");
    pick(&mut rig, &[2, 2, 2]);
    pick(&mut rig, &[2, 2, 2]);
    assert_eq!(rig.log().answers["trial-1-narrow-raw-tlx"][0].answer, 10);
    // A skipped drive skips its questionnaires.
    assert_eq!(rig.running(), "trial-2-wide");
    rig.command(SessionCommand::Skip("no time".into()));
    assert_eq!(rig.running(), "end");
    let skipped = ("trial-2-wide-raw-tlx".into(), ItemOutcome::Skipped);
    assert!(rig.item_runs().contains(&skipped), "{:?}", rig.item_runs());
}
