//! A drive of a session on a real road: the experimenter extends it, and its recording agrees.

use codrive::{
    input::{
        ButtonAction, Devices, Rig,
        lamps::Lamps,
        profiles::{self, UnprofiledDevice},
        wheel::{FoundWheel, WheelMessage},
    },
    live_drive::LiveDrive,
    record::{Table, TableReader},
    render::Gpu,
    replay::Replay,
    scenario::{DisplaySettings, Scenario},
    session::drives::SessionResources,
    study::ParticipantCode,
    time::Pace,
    traffic::EngineChoice,
};
use std::time::Duration;

#[test]
fn an_extended_drive_is_recorded_whole_and_replays_to_the_bit() {
    let gpu = Gpu::shared().expect("a graphics adapter is needed");
    let scenario = Scenario {
        traffic: EngineChoice::Native,
        duration_s: 1.0,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("trial");
    let mut devices = Some(Devices::with_rig(Rig::fed_by(std::sync::mpsc::channel().1)));
    let mut live = LiveDrive::with_devices(&scenario, &mut devices).unwrap();
    assert!(devices.is_none() && live.drive.clock.pace() == Pace::Paused);
    live.record_of(&recording, gpu, Some(&ParticipantCode::new("P03").unwrap())).unwrap();
    live.drive.clock.set_pace(Pace::FullSpeed);
    live.advance(Duration::ZERO, |_| ()).unwrap();
    live.extend(0.75).unwrap();
    while live.drive.world.ended().is_none() {
        live.advance(Duration::ZERO, |_| ()).unwrap();
    }
    assert_eq!(live.drive.world.snapshot().tick.0, 175);
    live.finish_recording().unwrap();
    assert_eq!(Scenario::from_file(&recording.join("scenario.toml")).unwrap().duration_s, 1.75);
    let mut replay = Replay::open(&recording).unwrap();
    replay.advance(1000).unwrap();
    assert_eq!((replay.report().ticks, replay.report().first_difference), (175, None));
    let manifest = std::fs::read_to_string(recording.join("manifest.json")).unwrap();
    assert!(manifest.contains("\"participant\": \"P03\""), "{manifest}");
    // A scenario that cannot start leaves the devices with the caller.
    devices = Some(live.into_devices());
    assert!(
        LiveDrive::with_devices(&Scenario { vehicles: 400, ..scenario }, &mut devices).is_err() && devices.is_some()
    );
}

#[test]
fn buttons_in_a_session_only_ask_and_the_selector_begins_in_drive() {
    let (to, messages) = std::sync::mpsc::channel();
    let values = [(0, 32_767), (1, 255), (2, 255), (5, 255)].into_iter().collect();
    let profile = profiles::named("g29").unwrap();
    let device = UnprofiledDevice { name: "G29".into(), id: (0x046d, 0xc24f), values, ..Default::default() };
    let found = FoundWheel { device, profile, lamps: Lamps::default(), force: None, angle: Default::default() };
    to.send(WheelMessage::Connected(Box::new(found))).unwrap();
    let mut wheel = Devices::with_rig(Rig::fed_by(messages));
    // Reverse was pressed while questions were answered.
    to.send(WheelMessage::Button { code: 293, down: true, at: None }).unwrap();
    wheel.poll();
    assert_eq!(wheel.controls(0.0, None).selector, codrive::controls::Selector::Reverse);
    let mut devices = Some(wheel);
    let scenario = Scenario {
        traffic: EngineChoice::Native,
        duration_s: 5.0,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    };
    let mut live = LiveDrive::with_devices(&scenario, &mut devices).unwrap();
    assert_eq!(live.devices.controls(0.0, None).selector, codrive::controls::Selector::Drive);
    for code in [297, 292, 296] {
        to.send(WheelMessage::Button { code, down: true, at: None }).unwrap();
    }
    live.advance(Duration::from_millis(20), |_| ()).unwrap();
    assert_eq!(live.take_pressed(), [ButtonAction::Start, ButtonAction::Mark, ButtonAction::Abort]);
    assert_eq!((live.drive.clock.pace(), live.take_pressed().len()), (Pace::Paused, 0), "Start starts nothing");
}

#[test]
fn time_in_range_equals_that_of_the_recorded_speeds_and_advice() {
    let wide = Scenario {
        traffic: EngineChoice::Native,
        duration_s: 8.0,
        policy: "constant".into(),
        hold_s: 1.0,
        // The vehicle coasts from 4.6 m/s without pedals: into the range, and out of it below.
        vehicles: 12,
        warm_up_s: 5.0,
        policy_speed_mps: 3.8,
        range_mph: 1.0,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    };
    let gpu = Gpu::shared().expect("a graphics adapter is needed");
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("practice");
    let none = || Devices::with_rig(Rig::fed_by(std::sync::mpsc::channel().1));
    let mut kit = SessionResources::new(none(), &ParticipantCode::new("P03").unwrap());
    let mut live = LiveDrive::with_devices(&wide, &mut Some(none())).unwrap();
    live.record_of(&recording, gpu, None).unwrap();
    live.drive.clock.set_pace(Pace::FullSpeed);
    kit.live = Some(live);
    let ended = |kit: &SessionResources| kit.live.as_ref().is_some_and(|live| live.drive.world.ended().is_some());
    while !ended(&kit) {
        kit.frame(Duration::ZERO, |_| ()).unwrap();
    }
    kit.live.as_mut().unwrap().finish_recording().unwrap();
    // From the tables: the speed at the end of each step is within the range of the advice in force.
    let ego = TableReader::parquet(&Table::Ego.parquet(&recording)).unwrap();
    let advice = TableReader::parquet(&Table::Advice.parquet(&recording)).unwrap();
    let (ticks, low, high) = (advice.wholes("tick"), advice.numbers("range_low_mps"), advice.numbers("range_high_mps"));
    let steps = ego.wholes("tick").into_iter().zip(ego.numbers("speed_mps")).filter(|(tick, _)| tick % 10 == 0);
    let inside: Vec<bool> = steps
        .map(|(tick, speed)| {
            let stands = ticks.iter().rposition(|issued| *issued < tick).unwrap();
            let speed = speed.unwrap();
            low[stands].unwrap() - 1e-6 <= speed && speed <= high[stands].unwrap() + 1e-6
        })
        .collect();
    let longest = inside.split(|is_inside| !is_inside).map(<[bool]>::len).max().unwrap();
    let recorded_s = longest as f64 * 0.1;
    assert!(
        (kit.practice().in_range.longest_s() - recorded_s).abs() < 1e-6,
        "{:?} {recorded_s}",
        kit.practice().in_range
    );
    assert!((1.0..7.5).contains(&recorded_s), "{recorded_s}: the car is in it and out of it");
}
