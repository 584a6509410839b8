//! Skills that a practice drive asks for.

use super::rig::{Rig, STUDY};
use codrive::study::skills::Skill;

#[test]
fn skills_of_a_practice_are_noted_once_and_missing_ones_at_its_end() {
    let mut rig = Rig::of(&STUDY.replace("until_in_range_s = 2.0", "skills = [\"start\", \"dial\"]"));
    rig.until_practice();
    rig.drive_off();
    let practice = |rig: &mut Rig| {
        let now = rig.road.now;
        rig.live_session().practice(now)
    };
    assert_eq!(practice(&mut rig).as_deref(), Some("skills to come: start, dial"));
    rig.road.now.practice.shown.add(Skill::Start);
    rig.road.now.practice.shown.add(Skill::Turn);
    rig.pass(0.1);
    rig.pass(0.1);
    assert_eq!(rig.road.notes, ["skill: start"], "once, and none that is not asked for");
    assert_eq!(practice(&mut rig).as_deref(), Some("skills to come: dial"));
    rig.pass(30.0);
    assert_eq!(rig.road.notes, ["skill: start", "skills_missing: dial"]);
    let missing = "skills not shown: dial (Repeat brings the drive again)";
    assert_eq!((rig.sees().as_str(), practice(&mut rig).as_deref()), ("the drive is over", Some(missing)));
}
