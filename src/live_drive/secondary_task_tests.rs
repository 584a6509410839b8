//! A live drive with a secondary task: presses of keys and of the wheel's buttons reach one tick each, and none from a pause.

use super::*;
use crate::{
    analysis::data::trial::RecordedTrial,
    controls::TaskButton,
    input::{Rig, wheel::WheelMessage},
    record::{Manifest, Recorder, Table, TableReader},
    scenario::{DisplaySettings, SecondaryTask, SecondaryTaskKind, TaskSignal},
    sim::EventKind,
    snapshot::TaskPicture,
    traffic::EngineChoice,
};

fn live(kind: SecondaryTaskKind) -> LiveDrive {
    live_with(SecondaryTask { kind, ..SecondaryTask::default() }, Path::new("/nowhere"))
}

/// Returns a drive with this task and the LED of this folder.
fn live_with(secondary_task: SecondaryTask, led: &Path) -> LiveDrive {
    let scenario = Scenario {
        traffic: EngineChoice::Native,
        vehicles: 2,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        secondary_task,
        ..Scenario::default()
    };
    let (_, messages) = std::sync::mpsc::channel::<WheelMessage>();
    LiveDrive::new(&scenario, Pace::RealTime, Devices::with_rig(Rig::fed_by(messages)).with_led(Some(led)))
        .expect("the native engine")
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
fn an_led_is_lit_with_the_signal_which_is_on_the_screen_if_it_fails() {
    let folder = tempfile::tempdir().unwrap();
    let brightness = folder.path().join("brightness");
    std::fs::write(&brightness, "0").unwrap();
    let task = SecondaryTask {
        kind: SecondaryTaskKind::DetectionResponse,
        signal: TaskSignal::RemoteLed,
        ..SecondaryTask::default()
    };
    let mut live = live_with(task, folder.path());
    let out = folder.path().join("drive");
    let manifest = Manifest { driver: "keyboard".into(), seed: 1, ..Manifest::default() };
    live.recording.recorder = Some(Recorder::begin(&out, live.drive.world.scenario(), manifest).unwrap());
    let (mut is_gone, mut lit, mut signals, mut news) = (false, 0, Vec::new(), Vec::new());
    for _ in 0..120 {
        responses(&mut live, 0.1);
        news.extend(live.take_news());
        let is_on = live.drive.world.snapshot().task.shown == TaskPicture::Signal;
        signals.push(is_on);
        let is_lit = std::fs::read_to_string(&brightness).is_ok_and(|text| text == "1");
        assert_eq!(is_lit, is_on && !is_gone);
        assert_eq!(live.view().task == TaskPicture::Signal, is_on && is_gone, "in one place alone");
        lit += usize::from(is_lit);
        if !is_gone && lit > 0 && !is_on {
            std::fs::remove_file(&brightness).unwrap();
            is_gone = true;
        }
    }
    // Signals are 3 to 5 s apart, the second one within 10 s.
    assert!((9..=11).contains(&lit) && signals.iter().filter(|is_on| **is_on).count() >= 19, "{lit}");
    assert!(news.len() == 1 && news[0].starts_with("signals are on the screen: the LED stays as it is"), "{news:?}");
    let onset = signals.iter().position(|is_on| *is_on).unwrap() as u64;
    live.finish_recording().unwrap();
    let events = TableReader::parquet(&Table::Events.parquet(&out)).unwrap();
    let rows: Vec<(String, String, u64)> = events
        .words("event")
        .into_iter()
        .zip(events.words("detail"))
        .zip(events.wholes("tick"))
        .map(|((kind, detail), tick)| (kind, detail, tick))
        .filter(|row| row.0 == "remote_led")
        .collect();
    assert_eq!((rows[0].1.as_str(), rows[1].1.as_str(), &rows[2].1[..15]), ("on", "off", "on the screen: "));
    // Within the frame that shows the signal: after the tenth of a second before, at the end of one at most.
    assert!(
        (10 * onset..=10 * onset + 11).contains(&rows[0].2) && (rows[1].2 - rows[0].2).abs_diff(100) <= 2,
        "{rows:?}"
    );
}

#[test]
fn digits_count_once_a_picture_shows_them_and_have_no_score_before() {
    let score_with = |shown_from_s: f64| {
        let mut live = live(SecondaryTaskKind::NBack);
        let folder = tempfile::tempdir().unwrap();
        let manifest = Manifest { driver: "keyboard".into(), seed: 1, ..Manifest::default() };
        let recorder = Recorder::begin(&folder.path().join("drive"), live.drive.world.scenario(), manifest);
        live.recording.recorder = Some(recorder.unwrap());
        for frame in 0..240 {
            responses(&mut live, 0.1);
            let has_digit = matches!(live.view().task, TaskPicture::Digit { .. });
            assert_eq!(has_digit, matches!(live.drive.world.snapshot().task.shown, TaskPicture::Digit { .. }));
            if f64::from(frame) / 10.0 >= shown_from_s {
                live.shown(Duration::ZERO, Duration::ZERO, &DueTicks::default());
            }
        }
        let recording = live.finish_recording().unwrap().unwrap();
        let scores = live.summary().secondary_task.n_back.map(|n| (n.n_back_digits, n.n_back_accuracy.is_some()));
        let recorded = RecordedTrial::open(&recording).unwrap().task.scores(24.0);
        let recorded = recorded.n_back.map(|n| (n.n_back_digits, n.n_back_accuracy.is_some()));
        assert_eq!(scores, recorded, "as the analysis reads it");
        scores
    };
    // Digits come from 5 s on, every 2.25 s: 9 in 24 s, of which the first is compared with none.
    assert_eq!(score_with(0.0), Some((9, true)));
    assert_eq!(score_with(99.0), None, "neither heard nor shown: no score");
    // The first two are not shown, and the third is compared with the second.
    assert_eq!(score_with(9.0), Some((6, true)));
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
