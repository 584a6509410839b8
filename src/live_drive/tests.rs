//! A drive with a wheel, without window or GPU: contents of recording, lamps, flash patch and end card.

#[path = "automated_wheel_tests.rs"]
mod automated_wheel;

use super::{loop_health::LoopHealth, *};
use crate::{
    ego::GroundSurface,
    input::{
        AdviceState, Rig,
        force_thread::{ForceDevice, SharedAngle},
        lamps::Lamps,
        profiles::{self, UnprofiledDevice},
        wheel::{FoundWheel, WheelMessage},
    },
    panel::{calibration::CalibrationCommand, experimenter::WheelHealth},
    record::{Manifest, Recorder, Table, TableReader},
    scenario::{DisplaySettings, FlashPatch, SecondaryTask, SecondaryTaskKind, TaskSignal},
    scene::ViewKind,
    traffic::EngineChoice,
};
use std::{fs, io, sync::Arc, sync::mpsc::Sender};

/// A motor that accepts every level.
struct Motor;

impl ForceDevice for Motor {
    fn set(&mut self, _level: i16) -> io::Result<()> {
        Ok(())
    }

    fn end(&mut self) {}
}

/// Returns a drive on the native engine, and the sender of its wheel's messages.
fn show(scenario: Scenario) -> (LiveDrive, Sender<WheelMessage>) {
    let (to, messages) = std::sync::mpsc::channel();
    let scenario = Scenario {
        traffic: EngineChoice::Native,
        display: DisplaySettings { trees: 0, ..scenario.display },
        ..scenario
    };
    (LiveDrive::new(&scenario, Pace::RealTime, Devices::with_rig(Rig::fed_by(messages))).unwrap(), to)
}

fn g29(lamps: Lamps, force: bool) -> WheelMessage {
    let axes = [(0, [0, 65_535]), (1, [0, 255]), (2, [0, 255]), (5, [0, 255])];
    let values = [(0, 32_767), (1, 255), (2, 255), (5, 255)];
    let device = UnprofiledDevice {
        name: "G29".into(),
        id: (0x046d, 0xc24f),
        axes: axes.into(),
        values: values.into(),
        ..UnprofiledDevice::default()
    };
    let force = force.then(|| Box::new(Motor) as Box<dyn ForceDevice>);
    let profile = profiles::named("g29").unwrap();
    WheelMessage::Connected(Box::new(FoundWheel {
        device,
        profile,
        lamps,
        force,
        angle: Arc::new(SharedAngle::default()),
    }))
}

/// Runs a frame of 1/60 s. Returns the state of the flash patch.
fn frame(live: &mut LiveDrive) -> Option<bool> {
    let elapsed = Duration::from_nanos(16_666_667);
    let due = live.advance(elapsed, |_| ()).unwrap();
    let patch = live.view().patch;
    live.shown(Duration::from_secs(1), elapsed, &due);
    patch
}

/// Records into `folder` without a graphics device.
fn record(live: &mut LiveDrive, folder: &Path) {
    let manifest = Manifest { driver: "wheel".into(), seed: 1, ..Manifest::default() };
    live.recording.recorder = Some(Recorder::begin(folder, live.drive.world.scenario(), manifest).unwrap());
}

#[test]
fn pedal_force_flash_horn_and_latency_of_a_wheel_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("p1");
    let (mut live, to) = show(Scenario { flash_patch: FlashPatch::Pedal, ..Scenario::default() });
    record(&mut live, &recording);
    assert_eq!(frame(&mut live), Some(false));
    to.send(g29(Lamps::default(), true)).unwrap();
    frame(&mut live);
    // Half of the brake, and the horn.
    to.send(WheelMessage::Axis { code: 5, raw: 100, at: Some(TimeStamp::now()) }).unwrap();
    to.send(WheelMessage::Button { code: 289, down: true, at: None }).unwrap();
    assert_eq!(frame(&mut live), Some(true), "the frame of the tick that used the pedal");
    assert_eq!(frame(&mut live), Some(false), "and only that");
    to.send(WheelMessage::Button { code: 289, down: false, at: None }).unwrap();
    frame(&mut live);
    let spread = live.latency().input_to_frame().unwrap();
    assert_eq!(spread.count, 1);
    assert!(live.latency().input_to_tick().unwrap().median_s <= spread.median_s);
    live.finish_recording().unwrap();
    let table = |table: Table| TableReader::parquet(&table.parquet(&recording)).unwrap();
    let (ego, frames, events) = (table(Table::Ego), table(Table::Frames), table(Table::Events));
    let force = ego.numbers("wheel_force_nm");
    assert!(force[0].is_none() && force.last().unwrap().is_some(), "no wheel, then one with a motor: {force:?}");
    assert_eq!(frames.flags("flash"), [false, false, true, false, false].map(Some));
    assert_eq!(frames.numbers("latency_s").iter().flatten().count(), 1);
    assert_eq!(frames.numbers("input_to_tick_s").iter().flatten().count(), 1);
    let horn: Vec<String> = events
        .words("event")
        .into_iter()
        .zip(events.words("detail"))
        .filter(|(event, _)| event == "horn")
        .map(|(_, how)| how)
        .collect();
    assert_eq!(horn, ["on", "off"]);
    let rows = events.words("event").into_iter().zip(events.words("detail"));
    let profile = rows.into_iter().find_map(|(event, text)| (event == "wheel profile").then_some(text)).unwrap();
    let used = crate::input::WheelProfile::from_toml(&profile, "events").unwrap();
    assert_eq!(used, profiles::named("g29").unwrap(), "the whole profile is in the recording");
}

#[test]
fn a_frame_that_was_not_shown_loses_neither_flash_nor_latency() {
    // A former fault: the first picture drawn after the pedal used up the white square, even if it was never shown (an
    // outdated surface, a picture for another window).
    let (mut live, to) = show(Scenario { flash_patch: FlashPatch::Pedal, ..Scenario::default() });
    to.send(g29(Lamps::default(), false)).unwrap();
    frame(&mut live);
    to.send(WheelMessage::Axis { code: 5, raw: 100, at: Some(TimeStamp::now()) }).unwrap();
    for _ in 0..3 {
        live.advance(Duration::from_nanos(16_666_667), |_| ()).unwrap();
        assert_eq!(live.view().patch, Some(true));
    }
    assert_eq!(frame(&mut live), Some(true), "the first frame that is shown");
    assert_eq!(live.latency().input_to_frame().unwrap().count, 1);
    assert_eq!(frame(&mut live), Some(false));
    // A page over the picture has no square and must not use it up.
    to.send(WheelMessage::Axis { code: 5, raw: 255, at: None }).unwrap();
    frame(&mut live);
    to.send(WheelMessage::Axis { code: 5, raw: 100, at: None }).unwrap();
    let due = live.advance(Duration::from_nanos(16_666_667), |_| ()).unwrap();
    live.shown(Duration::from_secs(1), Duration::ZERO, &due);
    assert_eq!(frame(&mut live), Some(true));
}

#[test]
fn an_input_waits_for_a_tick_and_a_frame_at_most() {
    // A screen of 250 Hz: three of five frames have no tick.
    let (mut live, to) = show(Scenario::default());
    to.send(g29(Lamps::default(), false)).unwrap();
    let elapsed = Duration::from_millis(4);
    live.advance(elapsed, |_| ()).unwrap();
    for i in 0..50 {
        to.send(WheelMessage::Axis { code: 5, raw: 100 + i % 2 * 50, at: Some(TimeStamp::now()) }).unwrap();
        let mut frames = 0;
        while live.latency.used.is_none() {
            live.advance(elapsed, |_| ()).unwrap();
            frames += 1;
        }
        // 10 ms are 2.5 frames; the input came just after one.
        assert!(frames <= 3, "{frames} frames of 4 ms");
        live.shown(Duration::ZERO, elapsed, &DueTicks::default());
    }
}

#[test]
fn rev_lamps_show_the_advice_state_and_a_problem_is_reported_once() {
    let sys = tempfile::tempdir().unwrap();
    let lamp = |n| sys.path().join(format!("class/input/event3/device/device/leds/x::RPM{n}"));
    (1..=5).for_each(|n| {
        fs::create_dir_all(lamp(n)).unwrap();
        fs::write(lamp(n).join("brightness"), "0").unwrap();
    });
    let lit = || (1..=5).filter(|n| fs::read_to_string(lamp(*n).join("brightness")).unwrap() == "1").count();
    let scenario = Scenario { rev_lamps: true, policy: "constant".into(), hold_s: 0.1, ..Scenario::default() };
    let (mut live, to) = show(scenario);
    frame(&mut live);
    frame(&mut live);
    assert_eq!(live.take_news().len(), 1, "there is no wheel: messages once");
    to.send(g29(Lamps::find(sys.path(), "event3"), false)).unwrap();
    (0..12).for_each(|_| {
        frame(&mut live);
    });
    assert_eq!(lit(), 1, "standing, with 4.3 m/s advised: too slow");
    to.send(WheelMessage::Lost).unwrap();
    frame(&mut live);
    assert_eq!(lit(), 0, "dark when the wheel has gone");
    // As the signal of a detection response task they do not show the advice.
    let task = SecondaryTask {
        kind: SecondaryTaskKind::DetectionResponse,
        signal: TaskSignal::RemoteLed,
        ..SecondaryTask::default()
    };
    let (mut live, to) = show(Scenario { secondary_task: task, ..live.drive.world.scenario().clone() });
    to.send(g29(Lamps::find(sys.path(), "event3"), false)).unwrap();
    let mut shown = Vec::new();
    while live.drive.world.time_s() < 6.0 {
        frame(&mut live);
        let is_on = live.drive.world.snapshot().task.shown == TaskPicture::Signal;
        assert_eq!(lit(), if is_on { 5 } else { 0 });
        shown.push(is_on);
    }
    assert!(shown.contains(&true) && live.take_news().is_empty());
}

#[test]
fn a_calibration_pauses_the_drive_and_ends_when_the_wheel_is_unplugged() {
    let (mut live, to) = show(Scenario::default());
    let message = live.calibrate(CalibrationCommand::Begin).unwrap();
    assert!(message.contains("no steering wheel is plugged in"), "{message}");
    to.send(g29(Lamps::default(), false)).unwrap();
    frame(&mut live);
    assert_eq!(live.calibrate(CalibrationCommand::Begin), None);
    assert_eq!(live.drive.clock.pace(), Pace::Paused);
    let page = crate::live_drive::wheel_calibration::wheel(live.devices.rig()).unwrap();
    let asked = page.asked.unwrap();
    assert_eq!(asked.step, crate::input::calibrate::CalibrationStep::Rest);
    assert!(asked.learnt.is_none(), "nothing was asked yet");
    assert_eq!(live.calibrate(CalibrationCommand::Cancel), None);
    assert!(
        crate::live_drive::wheel_calibration::wheel(live.devices.rig()).unwrap().asked.is_none(),
        "it asks for nothing any more"
    );
    assert_eq!(live.calibrate(CalibrationCommand::Begin), None);
    to.send(WheelMessage::Lost).unwrap();
    frame(&mut live);
    assert!(crate::live_drive::wheel_calibration::wheel(live.devices.rig()).is_none());
}

#[test]
fn grass_in_the_force_input_is_the_share_of_front_wheels_on_grass() {
    let (mut live, to) = show(Scenario { policy: "none".into(), vehicles: 2, ..Scenario::default() });
    to.send(g29(Lamps::default(), true)).unwrap();
    frame(&mut live);
    // Off the ring to the left, with the accelerator pressed.
    for (code, raw) in [(2, 100), (0, 20_000)] {
        to.send(WheelMessage::Axis { code, raw, at: None }).unwrap();
    }
    let mut seen = Vec::new();
    for _ in 0..1200 {
        live.advance(Duration::from_millis(10), |_| ()).unwrap();
        let front =
            live.drive.world.snapshot().ego.wheels[..2].iter().map(|wheel| wheel.surface == GroundSurface::Grass);
        let share = match front.collect::<Vec<_>>()[..] {
            [false, false] => 0.0,
            [true, true] => 1.0,
            _ => 0.5,
        };
        let force_input = live.force_input();
        assert_eq!(force_input.grass, share);
        if seen.last() != Some(&share) {
            seen.push(share);
        }
        if share == 1.0 {
            break;
        }
    }
    assert_eq!(seen, [0.0, 0.5, 1.0], "from the road over one wheel to both");
    let (ego, force_input) = (&live.drive.world.snapshot().ego, live.force_input());
    assert_eq!((force_input.speed_mps, force_input.aligning_nm), (ego.speed_mps, f64::from(ego.steering_torque_nm)));
    assert!(force_input.running);
    live.toggle_pause();
    assert!(!live.force_input().running);
}

#[test]
fn the_experimenters_lamps_show_frames_drops_latency_disk_and_wheel() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("p1");
    let (mut live, to) = show(Scenario::default());
    let mut loop_health = LoopHealth::default();
    let health = loop_health.health(&live, "native", None);
    assert_eq!((health.wheel, health.latency_ms), (WheelHealth::None, None));
    assert!(health.recording.is_none() && health.error.is_none());
    assert_eq!((health.frame_ms, health.dropped_s), ([0.0; 2], [0.0; 2]), "no frame yet");

    record(&mut live, &recording);
    to.send(g29(Lamps::default(), false)).unwrap();
    frame(&mut live);
    to.send(WheelMessage::Axis { code: 5, raw: 100, at: Some(TimeStamp::now()) }).unwrap();
    std::thread::sleep(Duration::from_millis(5));
    frame(&mut live);
    loop_health.frame(Duration::from_millis(20), Duration::ZERO);
    loop_health.frame(Duration::from_millis(40), Duration::from_millis(250));
    let health = loop_health.health(&live, "SUMO 1.20", Some("it failed"));
    assert_eq!(health.wheel, WheelHealth::There("Logitech G29".into()));
    assert_eq!((health.engine.as_str(), health.error.as_deref()), ("SUMO 1.20", Some("it failed")));
    assert_eq!((health.frame_ms, health.dropped_s), ([30.0, 40.0], [0.25; 2]));
    // One input, which waited for between 5 ms and 1 minute: its median and its worst value are the same.
    let [median_ms, worst_ms] = health.latency_ms.unwrap();
    assert!(median_ms == worst_ms && (5.0..60_000.0).contains(&median_ms), "{median_ms} ms");
    let seconds = live.latency().input_to_frame().unwrap().median_s;
    assert!((median_ms / 1e3 - seconds).abs() < 1e-9, "{median_ms} ms are {seconds} s");
    let disk = health.recording.unwrap();
    let free_gb = crate::record::free_bytes(&recording).map(|bytes| bytes as f64 / 1e9);
    // Other programs write to the same disk meanwhile.
    let near = disk.free_gb.zip(free_gb).is_none_or(|(shown, free)| (shown - free).abs() < 0.1 * free + 1.0);
    assert!(near && disk.free_gb.is_some() == free_gb.is_some(), "{:?}, not {free_gb:?} GB", disk.free_gb);

    // The window for frame times is 1.5 s; dropped time is recent for 10 s.
    (0..80).for_each(|_| loop_health.frame(Duration::from_millis(20), Duration::ZERO));
    assert_eq!(loop_health.health(&live, "", None).frame_ms, [20.0; 2]);
    (0..500).for_each(|_| loop_health.frame(Duration::from_millis(20), Duration::ZERO));
    assert_eq!(loop_health.health(&live, "", None).dropped_s, [0.25, 0.0]);
    to.send(WheelMessage::Lost).unwrap();
    frame(&mut live);
    assert_eq!(loop_health.health(&live, "", None).wheel, WheelHealth::Lost);
}

/// Returns kind and detail of every event in the recording.
fn events(recording: &Path) -> Vec<(String, String)> {
    let events = TableReader::parquet(&Table::Events.parquet(recording)).unwrap();
    events.words("event").into_iter().zip(events.words("detail")).collect()
}

#[test]
fn buttons_act_outside_a_session_and_are_only_collected_in_one() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("p1");
    let (mut live, to) = show(Scenario::default());
    record(&mut live, &recording);
    to.send(g29(Lamps::default(), false)).unwrap();
    frame(&mut live);
    live.take_news();
    let press = |live: &mut LiveDrive, code| {
        to.send(WheelMessage::Button { code, down: true, at: None }).unwrap();
        live.advance(Duration::ZERO, |_| ()).unwrap();
        (live.drive.clock.pace(), live.take_news())
    };
    let (share, options, mark, answer, recentre) = (296, 297, 292, 288, 291);
    let (pace, news) = press(&mut live, share);
    assert_eq!(pace, Pace::Paused, "who asks for the end is not driven on");
    assert!(news.len() == 1 && news[0].contains("asks to end the drive"), "{news:?}");
    assert_eq!(press(&mut live, options), (Pace::RealTime, vec![]));
    assert_eq!(press(&mut live, mark), (Pace::RealTime, vec!["marked".into()]));
    assert_eq!(press(&mut live, answer), (Pace::RealTime, vec![]));
    live.picture.next_view();
    assert_eq!((live.picture.kind, live.view().dial.is_some()), (ViewKind::Chase, ViewKind::Chase.has_dial()));
    press(&mut live, recentre);
    assert!(live.picture.kind == ViewKind::Driver && live.view().dial.is_some());
    assert!(live.take_pressed().is_empty(), "outside a session nobody is asked");
    assert_eq!(live.finish_recording().unwrap().as_deref(), Some(recording.as_path()));
    assert_eq!(live.finish_recording().unwrap(), None, "it has ended");
    let pressed: Vec<(String, String)> =
        events(&recording).into_iter().filter(|(kind, how)| how == "button" || kind == "mark").collect();
    let expected = [("abort asked for", "button"), ("mark", "by the participant"), ("answer", "button")]
        .map(|(kind, how)| (kind.to_owned(), how.to_owned()));
    assert_eq!(pressed, expected);

    let (sender, messages) = std::sync::mpsc::channel();
    let mut devices = Some(Devices::with_rig(Rig::fed_by(messages)));
    let scenario = Scenario {
        traffic: EngineChoice::Native,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    };
    let mut led = LiveDrive::with_devices(&scenario, &mut devices).unwrap();
    assert!(devices.is_none() && led.drive.clock.pace() == Pace::Paused);
    sender.send(g29(Lamps::default(), false)).unwrap();
    for code in [options, share, mark] {
        sender.send(WheelMessage::Button { code, down: true, at: None }).unwrap();
    }
    led.advance(Duration::from_millis(30), |_| ()).unwrap();
    assert_eq!(led.take_pressed(), [ButtonAction::Start, ButtonAction::Abort, ButtonAction::Mark]);
    assert!(led.take_pressed().is_empty() && led.drive.clock.pace() == Pace::Paused);
    assert_eq!(led.drive.world.snapshot().tick.0, 0, "whoever leads it lets time run");
    assert!(led.into_devices().describe().contains("Logitech G29"), "they are there for what comes next");
}

#[test]
fn an_unplugged_wheel_pauses_only_a_running_drive() {
    let (mut live, to) = show(Scenario::default());
    let tell = |live: &mut LiveDrive, message: WheelMessage| {
        to.send(message).unwrap();
        live.advance(Duration::ZERO, |_| ()).unwrap();
        (live.drive.clock.pace(), live.waits_for_wheel(), live.take_news().len())
    };
    assert_eq!(tell(&mut live, g29(Lamps::default(), false)), (Pace::RealTime, false, 0));
    assert_eq!(tell(&mut live, WheelMessage::Lost), (Pace::Paused, true, 1));
    assert_eq!(tell(&mut live, g29(Lamps::default(), false)), (Pace::RealTime, false, 1), "it is said to be back");
    // The drive is resumed without the wheel: its return causes no message.
    tell(&mut live, WheelMessage::Lost);
    live.toggle_pause();
    assert!(live.drive.clock.pace() == Pace::RealTime && !live.waits_for_wheel());
    assert_eq!(tell(&mut live, g29(Lamps::default(), false)), (Pace::RealTime, false, 0));
    // Paused by a person before the wheel was unplugged: the drive stays paused when the wheel is back.
    live.toggle_pause();
    assert_eq!(tell(&mut live, WheelMessage::Lost), (Pace::Paused, false, 1));
    assert_eq!(tell(&mut live, g29(Lamps::default(), false)), (Pace::Paused, false, 0));
    // Paused by a person while the wheel was unplugged, as after a request to stop: the drive stays paused too.
    live.toggle_pause();
    assert_eq!(tell(&mut live, WheelMessage::Lost), (Pace::Paused, true, 1));
    live.hold(true);
    assert_eq!(tell(&mut live, g29(Lamps::default(), false)), (Pace::Paused, false, 0));
    // Resumed by a button or the panel meanwhile, and paused again: that pause is a person's.
    live.toggle_pause();
    tell(&mut live, WheelMessage::Lost);
    live.drive.clock.set_pace(Pace::RealTime);
    live.advance(Duration::ZERO, |_| ()).unwrap();
    live.drive.clock.set_pace(Pace::Paused);
    assert!(!live.waits_for_wheel());
    assert_eq!(tell(&mut live, g29(Lamps::default(), false)), (Pace::Paused, false, 0));
}

#[test]
fn every_frame_is_in_the_recording_with_its_number_and_times() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("p1");
    let (mut live, _to) = show(Scenario::default());
    assert!(live.writer_status().is_none());
    live.flush().unwrap();
    record(&mut live, &recording);
    assert!(live.writer_status().is_some());
    for (i, elapsed_ms) in [4, 16, 16].into_iter().enumerate() {
        let elapsed = Duration::from_millis(elapsed_ms);
        let due = live.advance(elapsed, |_| ()).unwrap();
        live.view();
        live.shown(Duration::from_millis(100 * (i as u64 + 1)), elapsed, &due);
    }
    // The rows are written by another thread, a moment later.
    live.flush().unwrap();
    let rows = || fs::metadata(recording.join("journal/rows.blocks")).map_or(0, |about| about.len());
    let begun = TimeStamp::now();
    while rows() == 0 {
        assert!(begun.until(TimeStamp::now()) < Duration::from_secs(20), "nothing is written");
        std::thread::sleep(Duration::from_millis(2));
    }
    // A frame of a whole minute.
    let elapsed = Duration::from_secs(60);
    let due = live.advance(elapsed, |_| ()).unwrap();
    live.shown(Duration::from_secs(1), elapsed, &due);
    live.finish_recording().unwrap();
    let frames = TableReader::parquet(&Table::Frames.parquet(&recording)).unwrap();
    assert_eq!(frames.wholes("frame"), [0, 1, 2, 3]);
    assert_eq!(frames.wholes("tick")[..3], [0, 2, 3], "at 4, 20 and 36 ms");
    for (name, expected) in [("wall_s", [0.1, 0.2, 0.3, 1.0]), ("elapsed_s", [0.004, 0.016, 0.016, 60.0])] {
        assert_eq!(frames.numbers(name), expected.map(Some), "{name}");
    }
    let fractions: Vec<f64> = frames.numbers("fraction").into_iter().flatten().collect();
    for (fraction, expected) in fractions.iter().zip([0.4, 0.0, 0.6]) {
        assert!((fraction - expected).abs() < 1e-6, "{fractions:?}");
    }
    // At most 0.25 s is made up for.
    assert_eq!(
        (frames.wholes("tick")[3], frames.numbers("dropped_s")),
        (3 + 25, [0.0, 0.0, 0.0, 59.75].map(Some).to_vec())
    );
    assert!(frames.flags("flash").iter().all(Option::is_none), "there is no square");
}

#[test]
fn advice_state_is_below_within_or_above_the_advised_range() {
    let slow = Scenario { policy: "constant".into(), policy_speed_mps: 2.0, hold_s: 0.1, ..Scenario::default() };
    let (mut live, to) = show(Scenario { vehicles: 2, ..slow });
    assert_eq!(live.advice_state(), AdviceState::None, "before the first advice");
    to.send(g29(Lamps::default(), false)).unwrap();
    frame(&mut live);
    to.send(WheelMessage::Axis { code: 2, raw: 0, at: None }).unwrap();
    let mut seen = Vec::new();
    while seen.len() < 3 {
        live.advance(Duration::from_millis(10), |_| ()).unwrap();
        let snapshot = live.drive.world.snapshot();
        assert!(snapshot.tick.seconds() < 20.0, "{seen:?}");
        let advice = snapshot.advice.unwrap();
        let [low, high] = <[f64; 2]>::from(advice.band_mps());
        let expected = match snapshot.ego.speed_mps {
            slow if slow < low => AdviceState::Below,
            fast if fast > high => AdviceState::Above,
            _ => AdviceState::Within,
        };
        assert_eq!(live.advice_state(), expected, "{} m/s, advised {low} to {high}", snapshot.ego.speed_mps);
        if seen.last() != Some(&expected) {
            seen.push(expected);
        }
    }
    assert_eq!(seen, [AdviceState::Below, AdviceState::Within, AdviceState::Above], "from a stand with the foot down");
}

#[test]
fn an_extended_drive_records_its_new_duration() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("p1");
    let (mut live, _to) = show(Scenario { duration_s: 0.5, policy: "none".into(), ..Scenario::default() });
    record(&mut live, &recording);
    live.extend(0.25).unwrap();
    while live.drive.world.ended().is_none() {
        live.advance(Duration::from_millis(20), |_| ()).unwrap();
    }
    assert_eq!(live.drive.world.snapshot().tick.0, 75);
    live.finish_recording().unwrap();
    assert_eq!(crate::record::inputs::scenario(&recording).unwrap().duration_s, 0.75);
    let words = live.summary_text();
    for has in
        ["22 vehicles on ring-250, native", "driver keyboard, policy none", "window                   0.0 s to 0.8 s"]
    {
        assert!(words.contains(has), "{words}");
    }
}
