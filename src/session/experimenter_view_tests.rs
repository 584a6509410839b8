//! Tests of the experimenter's window as egui draws it, without a real window: contents before, in and after a drive, and commands by
//! keys.

use super::*;
use crate::{
    input::{Devices, Rig},
    session::DriveBackend,
    study::{DataSet, ParticipantCode, Session, session::ParticipantKind},
    time::Pace,
};
use egui::{Event, Key, Modifiers, RawInput};
use std::path::Path;

const STUDY: &str = r#"title = "A short study"
participants = 2
countdown_s = 1.0
[base]
traffic = "native"
vehicles = 6
warm_up_s = 0.0
trees = 0
duration_s = 90.0
policy = "constant"
[[condition]]
name = "narrow"
[[segment]]
kind = "break"
name = "rest"
rest_s = 30.0
[[segment]]
kind = "trials"
name = "trial"
"#;

/// Drive backend that accepts everything and does nothing.
struct NoRoad;

impl DriveBackend for NoRoad {
    fn prepare(&mut self, _scenario: &Scenario) -> Result<bool, crate::drive_loop::RunError> {
        Ok(true)
    }

    fn begin(&mut self, _folder: &Path) -> Result<(), crate::drive_loop::RunError> {
        Ok(())
    }

    fn hold(&mut self, _held: bool) {}

    fn note(&mut self, _kind: &str, _detail: &str) {}

    fn note_value(&mut self, _kind: &str, _detail: &str, _value: f64) {}

    fn begin_event(&mut self, _event: usize) {}

    fn chime(&mut self) {}

    fn extend(&mut self, _seconds: f64) -> Result<(), crate::drive_loop::RunError> {
        Ok(())
    }

    fn end(&mut self) -> Result<(), crate::drive_loop::RunError> {
        Ok(())
    }

    fn now(&self) -> BackendStatus {
        BackendStatus::default()
    }
}

struct ViewFixture {
    _folder: tempfile::TempDir,
    study: Study,
    live_session: LiveSession,
    experimenter_view: ExperimenterView,
    ctx: egui::Context,
}

impl ViewFixture {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let study = Study::parse(STUDY.into(), Path::new("short.toml")).unwrap();
        let data = DataSet::open(&folder.path().join("data"), &study).unwrap();
        let session =
            Session::open(&data, &study, &ParticipantCode::new("P03").unwrap(), ParticipantKind::Person, 0, "then")
                .unwrap();
        let live_session = LiveSession::new(&study, session, || "2026-11-21T12:00:00Z".into()).unwrap();
        let experimenter_view = ExperimenterView::new(&study);
        let ctx = egui::Context::default();
        crate::panel::theme::apply(&ctx);
        Self { _folder: folder, study, live_session, experimenter_view, ctx }
    }

    /// Runs one egui pass with these keys. Returns all drawn text and the commands.
    fn pass(
        &mut self,
        keys: &[(Modifiers, Key)],
        live: Option<&LiveDrive>,
        now: BackendStatus,
    ) -> (String, Vec<SessionCommand>) {
        let screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1280.0, 800.0)));
        let press = |(modifiers, key): &(Modifiers, Key)| {
            let (key, modifiers) = (*key, *modifiers);
            [true, false].map(|pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers })
        };
        let events = keys.iter().flat_map(press).collect();
        let wheel = WheelHealth::There("Logitech G29".into());
        let Self { live_session, experimenter_view, ctx, .. } = self;
        let mut asked = Vec::new();
        let mut output = ctx.run_ui(RawInput { screen_rect, events, ..Default::default() }, |ui| {
            asked.extend(experimenter_view.show(ui, live_session, live, now, &wheel, Some("2 of 4 baselines"), None));
        });
        // Textures are discarded, as there is no graphics device.
        output.textures_delta.clear();
        let mut words = String::new();
        output.shapes.iter().for_each(|clipped| collect(&clipped.shape, &mut words));
        (words, asked)
    }
}

fn collect(shape: &egui::Shape, out: &mut String) {
    match shape {
        egui::Shape::Text(text) => {
            out.push_str(text.galley.text());
            out.push('\n');
        }
        egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, out)),
        _ => {}
    }
}

fn drive(study: &Study) -> LiveDrive {
    let devices = Devices::with_rig(Rig::fed_by(std::sync::mpsc::channel().1));
    LiveDrive::new(&study.base, Pace::Paused, devices).unwrap()
}

#[test]
fn between_drives_it_shows_participant_plan_wheel_and_background_work() {
    let mut fixture = ViewFixture::new();
    let (words, _) = fixture.pass(&[], None, BackendStatus::default());
    // 30 s of rest and 90 s of driving take two minutes.
    for part in [
        "P03",
        "A short study",
        "rest rest",
        "resting",
        "0:30",
        "Plan: 0 of 2 done; about 2 min left",
        "trial-1-narrow",
        "90 s on ring-250, 6 vehicles, policy constant",
        "Logitech G29",
        "2 of 4 baselines",
        "no drive yet",
        "no picture yet",
    ] {
        assert!(words.contains(part), "{part:?} is not among\n{words}");
    }
}

#[test]
fn a_drive_is_shown_with_engine_and_log_which_stay_after_its_end() {
    let mut fixture = ViewFixture::new();
    let mut live = drive(&fixture.study);
    fixture.experimenter_view.drive_begins(&live);
    live.drive.clock.set_pace(Pace::FullSpeed);
    let ViewFixture { experimenter_view, .. } = &mut fixture;
    for _ in 0..8 {
        live.advance(Duration::ZERO, |world| experimenter_view.watch(world)).unwrap();
    }
    // 8 frames with 25 ticks each.
    assert_eq!(live.drive.world.snapshot().tick.0, 200);
    let (words, _) = fixture.pass(&[], Some(&live), BackendStatus::default());
    assert!(words.contains(&live.drive.world.traffic_engine()) && !words.contains("no drive yet"), "{words}");
    let log = fixture.experimenter_view.log.as_ref().unwrap();
    // First tick, and one sample per step of 0.1 s.
    assert_eq!(log.history.samples().len(), 1 + 20);
    // After the end, the road stays visible until the next drive begins. Only the lamps of the recorder and of contacts say that there is
    // no drive.
    let (words, _) = fixture.pass(&[], None, BackendStatus::default());
    assert_eq!(words.matches("no drive yet").count(), 2, "{words}");
    fixture.experimenter_view.drive_begins(&drive(&fixture.study));
    assert!(
        fixture.experimenter_view.log.as_ref().unwrap().history.samples().is_empty(),
        "another drive begins with nothing"
    );
}

/// A refused command is reported once, beside the commands. The traffic lamp is for drives that could not go on.
#[test]
fn a_refused_command_is_not_a_traffic_fault() {
    let mut fixture = ViewFixture::new();
    let refused = SessionCommand::Repeat { item: "nothing".into(), reason: "x".into() };
    fixture.live_session.command(refused, &mut NoRoad).unwrap();
    let error = fixture.live_session.error().unwrap().to_owned();
    let (words, _) = fixture.pass(&[], None, BackendStatus::default());
    assert_eq!(words.matches(error.lines().next().unwrap()).count(), 1, "{words}");
}

#[test]
fn marks_and_notes_are_the_sessions_and_no_key_pauses_the_drive() {
    let mut fixture = ViewFixture::new();
    let mut live = drive(&fixture.study);
    fixture.experimenter_view.drive_begins(&live);
    let now = BackendStatus::default();
    fixture.pass(&[], Some(&live), now);
    let mark = |number: u32| SessionCommand::Mark(format!("by the experimenter, {number}"));
    let ctrl = Modifiers::COMMAND;
    assert_eq!(fixture.pass(&[(ctrl, Key::M)], Some(&live), now).1, [mark(1)]);
    assert_eq!(fixture.pass(&[(ctrl, Key::M)], Some(&live), now).1, [mark(2)]);
    assert!(fixture.pass(&[], Some(&live), now).0.contains("mark 2"), "among the notes, too");
    assert_eq!(fixture.pass(&[(ctrl, Key::P)], Some(&live), now).1, [], "the session alone lets time run");
    assert_eq!(fixture.pass(&[(Modifiers::COMMAND, Key::G)], Some(&live), now).1, [SessionCommand::Go]);
    live.drive.clock.set_pace(Pace::Paused);
    fixture.experimenter_view.add_note(BackendStatus { time_s: 61.0, ..now }, "the wheel was unplugged");
    let (words, _) = fixture.pass(&[], Some(&live), now);
    assert!(words.contains("the wheel was unplugged") && words.contains("1:01"), "{words}");
}

#[test]
fn an_error_is_shown_in_the_plan_until_the_next_command() {
    let mut fixture = ViewFixture::new();
    let late = SessionCommand::Extend { seconds: 7200.0, reason: "t".into() };
    fixture.live_session.command(late, &mut NoRoad).unwrap();
    let (words, _) = fixture.pass(&[], None, BackendStatus::default());
    assert!(words.contains("the extension is 7200 s; allowed: 1 to 3600 s"), "{words}");
    fixture.live_session.command(SessionCommand::Note("well".into()), &mut NoRoad).unwrap();
    let (words, _) = fixture.pass(&[], None, BackendStatus::default());
    assert!(!words.contains("the extension is"), "{words}");
}
