//! What the windows show of a visit: the plan with what became of each point, how long it still lasts, what is seen and what
//! is waited for.

use crate::rig::Rig;
use codrive::{
    app::visit::RoadNow,
    panel::{ItemState, Screen, VisitCommand, VisitPhase},
};

fn states(rig: &mut Rig) -> Vec<(String, ItemState, String)> {
    rig.visit().items().into_iter().map(|item| (item.name, item.state, item.earlier)).collect()
}

fn one(rig: &mut Rig, name: &str) -> (ItemState, String) {
    states(rig).into_iter().find(|(item, ..)| item == name).map(|(_, state, earlier)| (state, earlier)).unwrap()
}

#[test]
fn each_point_of_the_plan_says_what_became_of_it_now_and_earlier() {
    use ItemState::{Again, Ahead, Broken, Done, Now, Skipped};
    let is = |state: ItemState, earlier: &str| (state, earlier.to_owned());
    let mut rig = Rig::new();
    let plan = ["welcome", "before", "practice", "rest", "trial-1-narrow", "trial-2-wide"];
    let expected = plan.map(|name| (name.to_owned(), Ahead, String::new()));
    assert_eq!(states(&mut rig)[1..], expected[1..]);
    assert_eq!(one(&mut rig, "welcome"), is(Now, ""));
    rig.next();
    assert_eq!((one(&mut rig, "welcome"), one(&mut rig, "before")), (is(Done, ""), is(Now, "")));
    rig.command(VisitCommand::Skip("no time".into()));
    assert_eq!(one(&mut rig, "before"), is(Skipped, ""));
    rig.drive_off();
    rig.command(VisitCommand::Abort("the phone".into()));
    assert_eq!(one(&mut rig, "practice"), is(Again, "broken off"));
    rig.command(VisitCommand::Go);
    assert_eq!(one(&mut rig, "practice"), is(Now, "broken off"));
    rig.command(VisitCommand::Repeat { item: "welcome".into(), reason: "not read".into() });
    assert_eq!(one(&mut rig, "welcome"), is(Again, "done"));
    rig.drive_off();
    rig.command(VisitCommand::Stop("sickness".into()));
    assert_eq!((one(&mut rig, "practice"), one(&mut rig, "rest")), (is(Broken, "broken off"), is(Ahead, "")));
    let what: Vec<String> = rig.visit().items().into_iter().map(|item| item.what).collect();
    assert_eq!(what[3], "rest, 10 s");
    assert!(
        what[2].starts_with("30 s on ring-250, 22 cars") && what[2].ends_with("sooner after 2 s in range"),
        "{what:?}"
    );
}

#[test]
fn what_is_to_come_is_the_sum_of_what_is_not_behind_and_nothing_after_the_end() {
    let mut rig = Rig::new();
    let all_s = rig.visit().to_come_s();
    rig.next();
    rig.command(VisitCommand::Skip("no time".into()));
    // Left are the practice of 30 s, the rest of 10 s and two trials of 8 s.
    assert_eq!(rig.visit().to_come_s(), 56.0);
    assert!(all_s > 56.0, "{all_s}");
    assert_eq!(rig.visit().progress(), [2, 6]);
    rig.command(VisitCommand::Skip("no time".into()));
    assert_eq!((rig.visit().to_come_s(), rig.visit().progress()), (26.0, [3, 6]));
    rig.command(VisitCommand::Stop("sickness".into()));
    assert_eq!((rig.visit().to_come_s(), rig.visit().progress()), (0.0, [3, 6]));
}

#[test]
fn the_participant_sees_what_the_experimenter_is_told_they_see() {
    let mut rig = Rig::new();
    let texts = rig.study.file.texts.clone();
    let none = RoadNow::default();
    rig.until_practice();
    assert!(matches!(rig.visit().screen(none), Screen::Page("Try the car.")));
    assert_eq!((rig.visit().phase(none), rig.visit().left_s(none)), (VisitPhase::Participant, None));
    rig.next();
    assert!(matches!(rig.visit().screen(none), Screen::Wait(text) if text == texts.ready), "it is being loaded");
    assert_eq!(rig.visit().phase(none), VisitPhase::Driving);
    // 3 s of countdown, of which one frame is over.
    rig.pass(0.15);
    let left_s = rig.visit().left_s(none).unwrap();
    assert!((2.85..3.0).contains(&left_s), "{left_s}");
    assert!(matches!(rig.visit().screen(none), Screen::Countdown(3, 0, _)));
    // In flowing traffic the car begins with its speed, and the countdown says which: 4 m/s are 8.9 mph.
    let flowing = RoadNow { speed_mps: 4.0, ..none };
    assert!(matches!(rig.visit().screen(flowing), Screen::Countdown(3, 9, codrive::units::SpeedUnit::Mph)));
    rig.command(VisitCommand::Pause);
    assert!(matches!(rig.visit().screen(none), Screen::Drive(Some(text)) if text == texts.paused));
    rig.command(VisitCommand::Resume);
    rig.pass(3.0);
    let driving = RoadNow { time_s: 12.5, duration_s: 30.0, ..none };
    assert!(matches!(rig.visit().screen(driving), Screen::Drive(None)), "the road alone");
    assert_eq!((rig.visit().phase(driving), rig.visit().left_s(driving)), (VisitPhase::Driving, Some(17.5)));
    let held = RoadNow { held: true, ..driving };
    assert!(matches!(rig.visit().screen(held), Screen::Drive(Some(text)) if text == texts.paused));
    assert_eq!(rig.visit().phase(held), VisitPhase::Held);
    rig.command(VisitCommand::Skip("enough".into()));
    assert!(matches!(rig.visit().screen(none), Screen::Wait(text) if text == texts.wait));
    assert_eq!((rig.sees().as_str(), rig.visit().phase(none)), ("please wait", VisitPhase::Experimenter));
    rig.command(VisitCommand::Go);
    rig.pass(4.0);
    assert!(
        matches!(rig.visit().screen(none), Screen::Rest(text, left_s) if text == texts.rest && (5.9..6.1).contains(&left_s))
    );
    assert_eq!(rig.visit().phase(none), VisitPhase::Resting);
    rig.pass(6.5);
    assert!(matches!(rig.visit().screen(none), Screen::Rest(_, 0.0)));
    assert_eq!(rig.visit().phase(none), VisitPhase::Participant);
    rig.command(VisitCommand::Stop("sickness".into()));
    assert!(matches!(rig.visit().screen(none), Screen::Wait(text) if text == texts.stopped));
    assert_eq!((rig.sees().as_str(), rig.visit().phase(none)), ("stopped, thanks", VisitPhase::Over));
}
