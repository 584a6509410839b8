//! The session as the windows show it: the plan with the state of each item, the remaining time, the participant's screen and the reason
//! for waiting.

use crate::rig::Rig;
use codrive::{
    panel::{ItemState, ParticipantScreen, SessionCommand, SessionPhase},
    session::BackendStatus,
};

fn states(rig: &mut Rig) -> Vec<(String, ItemState, String)> {
    rig.live_session().items().into_iter().map(|item| (item.name, item.state, item.earlier)).collect()
}

fn one(rig: &mut Rig, name: &str) -> (ItemState, String) {
    states(rig).into_iter().find(|(item, ..)| item == name).map(|(_, state, earlier)| (state, earlier)).unwrap()
}

#[test]
fn each_item_of_the_plan_shows_its_present_and_earlier_states() {
    use ItemState::{Again, Ahead, Broken, Done, Now, Skipped};
    let is = |state: ItemState, earlier: &str| (state, earlier.to_owned());
    let mut rig = Rig::new();
    let plan = ["welcome", "before", "practice", "rest", "trial-1-narrow", "trial-2-wide"];
    let expected = plan.map(|name| (name.to_owned(), Ahead, String::new()));
    assert_eq!(states(&mut rig)[1..], expected[1..]);
    assert_eq!(one(&mut rig, "welcome"), is(Now, ""));
    rig.next();
    assert_eq!((one(&mut rig, "welcome"), one(&mut rig, "before")), (is(Done, ""), is(Now, "")));
    rig.command(SessionCommand::Skip("no time".into()));
    assert_eq!(one(&mut rig, "before"), is(Skipped, ""));
    rig.drive_off();
    rig.command(SessionCommand::Abort("the phone".into()));
    assert_eq!(one(&mut rig, "practice"), is(Again, "broken off"));
    rig.command(SessionCommand::Go);
    assert_eq!(one(&mut rig, "practice"), is(Now, "broken off"));
    rig.command(SessionCommand::Repeat { item: "welcome".into(), reason: "not read".into() });
    assert_eq!(one(&mut rig, "welcome"), is(Again, "done"));
    rig.drive_off();
    rig.command(SessionCommand::Stop("sickness".into()));
    assert_eq!((one(&mut rig, "practice"), one(&mut rig, "rest")), (is(Broken, "broken off"), is(Ahead, "")));
    let what: Vec<String> = rig.live_session().items().into_iter().map(|item| item.what).collect();
    assert_eq!(what[3], "rest, 10 s");
    assert!(
        what[2].starts_with("30 s on ring-250, 22 vehicles")
            && what[2].ends_with("or until 2 s in range without a break"),
        "{what:?}"
    );
}

#[test]
fn remaining_time_sums_the_open_items_and_is_zero_after_the_end() {
    let mut rig = Rig::new();
    let all_s = rig.live_session().to_come_s();
    rig.next();
    rig.command(SessionCommand::Skip("no time".into()));
    // Left are the practice of 30 s with three words to read (238 a minute, and 3 s for the page), the rest of 10 s and two trials of 8 s.
    let left_s = rig.live_session().to_come_s();
    assert!((left_s - (56.0 + 3.0 + 3.0 * 60.0 / 238.0)).abs() < 1e-9, "{left_s}");
    assert!(all_s > 56.0, "{all_s}");
    assert_eq!(rig.live_session().progress(), [2, 6]);
    rig.command(SessionCommand::Skip("no time".into()));
    assert_eq!((rig.live_session().to_come_s(), rig.live_session().progress()), (26.0, [3, 6]));
    rig.command(SessionCommand::Stop("sickness".into()));
    assert_eq!((rig.live_session().to_come_s(), rig.live_session().progress()), (0.0, [3, 6]));
}

#[test]
fn the_experimenter_is_told_what_the_participant_sees() {
    let mut rig = Rig::new();
    let texts = rig.study.file.texts.clone();
    let none = BackendStatus::default();
    rig.until_practice();
    assert!(matches!(rig.live_session().screen(none), ParticipantScreen::Page("Try the car.")));
    assert_eq!((rig.live_session().phase(none), rig.live_session().left_s(none)), (SessionPhase::Participant, None));
    rig.next();
    assert!(
        matches!(rig.live_session().screen(none), ParticipantScreen::Wait(text) if text == texts.ready),
        "it is loading"
    );
    assert_eq!(rig.live_session().phase(none), SessionPhase::Driving);
    // 3 s of countdown, less one frame.
    rig.pass(0.15);
    let left_s = rig.live_session().left_s(none).unwrap();
    assert!((2.85..3.0).contains(&left_s), "{left_s}");
    assert!(matches!(rig.live_session().screen(none), ParticipantScreen::Countdown(3, 0, _)));
    // In moving traffic the ego starts at its speed, and the countdown shows it: 4 m/s are 8.9 mph.
    let flowing = BackendStatus { speed_mps: 4.0, ..none };
    assert!(matches!(
        rig.live_session().screen(flowing),
        ParticipantScreen::Countdown(3, 9, codrive::units::SpeedUnit::Mph)
    ));
    rig.command(SessionCommand::Pause);
    assert!(matches!(rig.live_session().screen(none), ParticipantScreen::Drive(Some(text)) if text == texts.paused));
    rig.command(SessionCommand::Resume);
    rig.pass(3.0);
    let driving = BackendStatus { time_s: 12.5, duration_s: 30.0, ..none };
    assert!(matches!(rig.live_session().screen(driving), ParticipantScreen::Drive(None)), "the road alone");
    assert_eq!(
        (rig.live_session().phase(driving), rig.live_session().left_s(driving)),
        (SessionPhase::Driving, Some(17.5))
    );
    let held = BackendStatus { held: true, ..driving };
    assert!(matches!(rig.live_session().screen(held), ParticipantScreen::Drive(Some(text)) if text == texts.paused));
    assert_eq!(rig.live_session().phase(held), SessionPhase::Held);
    rig.command(SessionCommand::Skip("enough".into()));
    assert!(matches!(rig.live_session().screen(none), ParticipantScreen::Wait(text) if text == texts.wait));
    assert_eq!((rig.sees().as_str(), rig.live_session().phase(none)), ("please wait", SessionPhase::Experimenter));
    rig.command(SessionCommand::Go);
    rig.pass(4.0);
    assert!(
        matches!(rig.live_session().screen(none), ParticipantScreen::Rest(text, left_s) if text == texts.rest && (5.9..6.1).contains(&left_s))
    );
    assert_eq!(rig.live_session().phase(none), SessionPhase::Resting);
    rig.pass(6.5);
    assert!(matches!(rig.live_session().screen(none), ParticipantScreen::Rest(_, 0.0)));
    assert_eq!(rig.live_session().phase(none), SessionPhase::Participant);
    rig.command(SessionCommand::Stop("sickness".into()));
    assert!(matches!(rig.live_session().screen(none), ParticipantScreen::Wait(text) if text == texts.stopped));
    assert_eq!((rig.sees().as_str(), rig.live_session().phase(none)), ("stopped, thanks", SessionPhase::Over));
}
