//! A drive that begins at a standstill waits until the brake is pressed.

use super::rig::Rig;
use codrive::{controls::ControlSource, panel::ParticipantScreen};

#[test]
fn a_drive_from_a_standstill_counts_down_only_with_a_foot_on_the_brake() {
    let mut rig = Rig::with("standing_start = true");
    rig.until_practice();
    rig.next();
    rig.pass(10.0);
    assert_eq!(rig.sees(), "practice waits until the brake is pressed");
    let (now, texts) = (rig.road.now, rig.study.file.texts.clone());
    let ParticipantScreen::Drive(Some(words)) = rig.live_session().screen(now) else {
        panic!("words over the picture")
    };
    assert_eq!(texts.with_controls(words, ControlSource::Wheel), "Press the brake pedal and hold it.");
    assert_eq!(texts.with_controls(words, ControlSource::Keyboard), "Press the Down arrow key (brake) and hold it.");
    // Two of three seconds, then the foot leaves the brake: the countdown starts again.
    rig.road.now.brake = 0.3;
    rig.pass(2.0);
    assert_eq!(rig.sees(), "countdown to practice");
    rig.road.now.brake = 0.05;
    rig.pass(1.0);
    assert_eq!(rig.sees(), "practice waits until the brake is pressed");
    rig.road.now.brake = 0.3;
    rig.pass(2.5);
    assert_eq!(rig.sees(), "countdown to practice");
    rig.pass(1.0);
    assert_eq!(rig.sees(), "drive practice");
    rig.road.now.brake = 0.0;
    rig.pass(1.0);
    assert_eq!(rig.sees(), "drive practice", "from then on it is the driver's own");
}
