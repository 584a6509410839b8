//! A live drive with a secondary task: presses of keys and of the wheel's buttons reach one tick each, and none from a pause.

use super::*;
use crate::{
    controls::TaskButton,
    input::{Rig, wheel::WheelMessage},
    scenario::{DisplaySettings, SecondaryTask, SecondaryTaskKind},
    sim::EventKind,
    snapshot::TaskPicture,
    traffic::EngineChoice,
};

fn live(kind: SecondaryTaskKind) -> LiveDrive {
    let scenario = Scenario {
        traffic: EngineChoice::Native,
        vehicles: 2,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        secondary_task: SecondaryTask { kind, ..SecondaryTask::default() },
        ..Scenario::default()
    };
    let (_, messages) = std::sync::mpsc::channel::<WheelMessage>();
    LiveDrive::new(&scenario, Pace::RealTime, Devices::with_rig(Rig::fed_by(messages))).expect("the native engine")
}

/// Runs frames of 1/60 s for some seconds. Returns the number of responses.
fn responses(live: &mut LiveDrive, seconds: f64) -> usize {
    let mut count = 0;
    for _ in 0..(60.0 * seconds) as usize {
        let is_response = |world: &World| {
            world.events().iter().filter(|event| matches!(event.kind, EventKind::TaskResponse(_))).count()
        };
        live.advance(Duration::from_nanos(16_666_667), |world| count += is_response(world)).expect("the native engine");
    }
    count
}

#[test]
fn each_press_is_one_response_and_presses_in_a_pause_are_none() {
    let mut live = live(SecondaryTaskKind::DetectionResponse);
    assert_eq!(responses(&mut live, 0.5), 0);
    live.devices.press_for_task(TaskButton::Respond);
    assert_eq!(responses(&mut live, 0.5), 1);
    live.hold(true);
    live.devices.press_for_task(TaskButton::Respond);
    assert_eq!(responses(&mut live, 0.5), 0);
    live.hold(false);
    assert_eq!(responses(&mut live, 0.5), 0);
    live.devices.press_for_task(TaskButton::Left);
    live.devices.press_for_task(TaskButton::Respond);
    assert_eq!(responses(&mut live, 0.5), 1);
}

#[test]
fn the_view_shows_the_signal_while_it_is_on() {
    let mut live = live(SecondaryTaskKind::DetectionResponse);
    // The first signal is on within 3 to 5 s, for 1 s.
    let mut shown = Vec::new();
    for _ in 0..55 {
        responses(&mut live, 0.1);
        shown.push(live.view().task == TaskPicture::Signal);
    }
    assert!(!shown[..29].contains(&true) && shown[29..].contains(&true), "{shown:?}");
}
