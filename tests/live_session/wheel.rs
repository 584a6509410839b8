//! A session operated with a wheel, from the messages of the reading thread to responses on the disk.

use crate::rig::Rig;
use codrive::{
    controls::ControlSource,
    input::{
        Devices, Rig as WheelRig,
        lamps::Lamps,
        profiles::{self, UnprofiledDevice},
        wheel::{FoundWheel, WheelMessage},
    },
    session::drives::SessionResources,
    study::{FormInput, ParticipantCode},
};
use std::time::Duration;

#[test]
fn a_wheel_and_its_buttons_operate_pages_and_questions() {
    const STEERING: u16 = 0;
    const CROSS: u16 = 288;
    const TRIANGLE: u16 = 291;
    const RIGHT_PADDLE: u16 = 292;
    let (to, messages) = std::sync::mpsc::channel();
    let values = [(0, 32_767), (1, 255), (2, 255), (5, 255)].into_iter().collect();
    let profile = profiles::named("g29").unwrap();
    let device = UnprofiledDevice { name: "G29".into(), id: (0x046d, 0xc24f), values, ..Default::default() };
    let found = FoundWheel { device, profile, lamps: Lamps::default(), force: None, angle: Default::default() };
    to.send(WheelMessage::Connected(Box::new(found))).unwrap();
    let mut kit =
        SessionResources::new(Devices::with_rig(WheelRig::fed_by(messages)), &ParticipantCode::new("P03").unwrap());
    let mut rig = Rig::new();
    let mut act = |rig: &mut Rig, messages: &[WheelMessage]| {
        rig.pass(0.5);
        for one in messages {
            let one = match one {
                WheelMessage::Axis { code, raw, .. } => WheelMessage::Axis { code: *code, raw: *raw, at: None },
                WheelMessage::Button { code, .. } => WheelMessage::Button { code: *code, down: true, at: None },
                _ => continue,
            };
            to.send(one).unwrap();
            let (_, inputs) = kit.frame(Duration::ZERO, |_| ()).unwrap();
            inputs.into_iter().for_each(|input| rig.input(input));
        }
    };
    let turn = |degrees: f64| {
        let raw = 32_767 - (degrees / 450.0 * 32_767.0) as i32;
        WheelMessage::Axis { code: STEERING, raw, at: None }
    };
    let press = |code: u16| WheelMessage::Button { code, down: true, at: None };
    act(&mut rig, &[turn(0.0), press(CROSS)]);
    act(&mut rig, &[press(CROSS)]);
    assert_eq!(rig.sees(), "questions before, page 1 of 2");
    // 13 degrees to the right are one place: the middle of the scale, and one more.
    act(&mut rig, &[turn(-13.0), turn(-26.0), press(CROSS)]);
    // Back to the first question, one place to the left, and on; the wheel continues from its present angle.
    act(&mut rig, &[press(TRIANGLE), turn(-11.0), press(CROSS), press(RIGHT_PADDLE)]);
    for step in 0..5 {
        act(&mut rig, &[turn(-40.0 - 20.0 * f64::from(step)), press(CROSS)]);
        if step == 1 {
            act(&mut rig, &[press(CROSS)]);
        }
    }
    act(&mut rig, &[press(CROSS)]);
    let answers = rig.log().answers["before"].clone();
    assert_eq!((answers.len(), &answers[0].answer), (6, &serde_json::json!(50)), "{answers:?}");
    assert_eq!(rig.running(), "practice");
    assert!(rig.log().notes.iter().any(|note| note.kind == "mark" && note.text == "by the participant"));
}

/// The shipped sickness questionnaire and a page after it, with the d-pad and two buttons alone: no key, no mouse, no turn of the wheel.
#[test]
fn d_pad_and_two_buttons_answer_correct_and_leave_a_questionnaire() {
    const STUDY: &str = r#"title = "Pad"
participants = 1
order = "fixed"
[base]
traffic = "native"
duration_s = 8.0
[[condition]]
name = "only"
[[segment]]
kind = "questions"
name = "ssq"
text = "How do you feel?"
questionnaire = "ssq"
[[segment]]
kind = "text"
name = "done"
text = "The drives come next."
[[segment]]
kind = "trials"
name = "trial"
"#;
    // ABS_HAT0X and ABS_HAT0Y, BTN_TRIGGER and BTN_TOP2 of Linux's input-event-codes.h: the G29's d-pad, cross and triangle.
    const HAT_X: u16 = 16;
    const HAT_Y: u16 = 17;
    const CROSS: u16 = 288;
    const TRIANGLE: u16 = 291;
    let (to, messages) = std::sync::mpsc::channel();
    let values = [(0, 32_767), (1, 255), (2, 255), (5, 255)].into_iter().collect();
    let device = UnprofiledDevice { name: "G29".into(), id: (0x046d, 0xc24f), values, ..Default::default() };
    let profile = profiles::named("g29").unwrap();
    let found = FoundWheel { device, profile, lamps: Lamps::default(), force: None, angle: Default::default() };
    to.send(WheelMessage::Connected(Box::new(found))).unwrap();
    let mut kit =
        SessionResources::new(Devices::with_rig(WheelRig::fed_by(messages)), &ParticipantCode::new("P03").unwrap());
    let mut rig = Rig::of(STUDY);
    let mut push = |rig: &mut Rig, code: u16, way: i32| {
        rig.pass(0.5);
        let down = |down: bool| match code {
            CROSS | TRIANGLE => WheelMessage::Button { code, down, at: None },
            _ => WheelMessage::Axis { code, raw: if down { way } else { 0 }, at: None },
        };
        for one in [down(true), down(false)] {
            to.send(one).unwrap();
            let (_, inputs) = kit.frame(Duration::ZERO, |_| ()).unwrap();
            inputs.into_iter().for_each(|input| rig.input(input));
        }
    };
    push(&mut rig, CROSS, 0);
    assert_eq!(rig.sees(), "questions ssq, page 1 of 2");
    // Without a response the question stays.
    push(&mut rig, CROSS, 0);
    // Response "none": right selects the first of the list. One too far, and back.
    for (code, way) in [(HAT_X, 1), (HAT_X, 1), (HAT_X, -1), (CROSS, 0)] {
        push(&mut rig, code, way);
    }
    // "Slight" for fatigue, where down acts as right; then corrected: back, and "none".
    for (code, way) in [(HAT_Y, 1), (HAT_Y, 1), (CROSS, 0), (TRIANGLE, 0), (HAT_Y, -1), (CROSS, 0)] {
        push(&mut rig, code, way);
    }
    // The six remaining questions of the first page, its button, and the eight of the second: "severe", which left selects at once.
    for page in [6, 8] {
        for _ in 0..page {
            push(&mut rig, HAT_X, -1);
            push(&mut rig, CROSS, 0);
        }
        push(&mut rig, CROSS, 0);
    }
    assert_eq!(rig.running(), "done");
    let answers: Vec<String> = rig.log().answers["ssq"].iter().map(|a| a.answer.to_string()).collect();
    assert_eq!(answers.len(), 16);
    assert!(answers[..2].iter().all(|answer| *answer == answers[0]), "none twice: {answers:?}");
    assert!(answers[2..].iter().all(|answer| *answer == answers[2]) && answers[2] != answers[0], "severe: {answers:?}");
    push(&mut rig, CROSS, 0);
    assert!(rig.sees().starts_with("text before trial"), "{}", rig.sees());
}

#[test]
fn between_drives_plugging_is_reported_and_pedals_stand_in_for_buttons() {
    let (to, messages) = std::sync::mpsc::channel();
    let mut kit =
        SessionResources::new(Devices::with_rig(WheelRig::fed_by(messages)), &ParticipantCode::new("P03").unwrap());
    assert!(kit.frame(Duration::ZERO, |_| ()).unwrap().1.is_empty() && kit.source() != ControlSource::Wheel);
    let mut profile = profiles::named("g29").unwrap();
    (profile.buttons.answer, profile.buttons.start) = (Vec::new(), Vec::new());
    let values = [(0, 32_767), (1, 255), (2, 255), (5, 255)].into_iter().collect();
    let device = UnprofiledDevice { name: "G29".into(), id: (0x046d, 0xc24f), values, ..Default::default() };
    let found = FoundWheel { device, profile, lamps: Lamps::default(), force: None, angle: Default::default() };
    let mut after = |message: WheelMessage| {
        to.send(message).unwrap();
        let inputs = kit.frame(Duration::ZERO, |_| ()).unwrap().1;
        (inputs, kit.take_news(), kit.source() == ControlSource::Wheel)
    };
    let (inputs, news, _) = after(WheelMessage::Connected(Box::new(found)));
    assert!(inputs.is_empty() && news.len() == 1 && news[0].ends_with("is plugged in"), "{inputs:?} {news:?}");
    // The accelerator fully pressed is Enter, once; the brake goes back. 255 is released, 0 fully pressed.
    let pedal = |code: u16, raw: i32| WheelMessage::Axis { code, raw, at: None };
    let moved = after(WheelMessage::Axis { code: 0, raw: 30_000, at: None });
    assert!(moved.2, "whoever turns the wheel has it in hands");
    for (message, input) in [
        (pedal(2, 0), Some(FormInput::Next)),
        (pedal(2, 0), None),
        (pedal(2, 255), None),
        (pedal(5, 0), Some(FormInput::Back)),
    ] {
        assert_eq!(after(message).0, input.into_iter().collect::<Vec<_>>());
    }
    let (_, news, wheel) = after(WheelMessage::Lost);
    assert!(news.len() == 1 && news[0].ends_with("was unplugged") && !wheel, "{news:?}");
}
