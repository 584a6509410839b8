//! The experimenter's window, used through the labels on it: with the mouse and by keyboard alone, at every scale.

use codrive::{
    ego::EgoState,
    panel::{
        DrivePhase, PanelCommand, PanelState, PresetList, Readings, SettingChoices, SettingsPanel, SingleStep,
        experimenter::{
            ContactHealth, DriveHealth, DriveLog, ExperimenterCommand as Command, ExperimenterPanel, ExperimenterState,
            ListedEvent, RecordingHealth, WheelHealth,
        },
        theme,
    },
    policy::{Action, Advice},
    scenario::Scenario,
    sim::{Leader, ScriptedState, Snapshot, VehicleSnapshot},
    space::Pose,
    time::Tick,
    traffic::VehicleId,
};
use egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::{
    Harness,
    kittest::{NodeT, Queryable},
};
use glam::{DVec2, DVec3, Quat};
use std::{f64::consts::TAU, time::Duration};

/// Length of the 250 m ring, m.
const LENGTH_M: f64 = 250.0;
const RADIUS_M: f64 = LENGTH_M / TAU;
const CARS: u32 = 21;

/// The window with the state that the program gives it.
pub struct Bench {
    experimenter: ExperimenterPanel,
    panel: SettingsPanel,
    scenario: Scenario,
    phase: DrivePhase,
    log: DriveLog,
    pub now: Snapshot,
    health: DriveHealth,
    events: Vec<ListedEvent>,
    picture: Option<egui::TextureHandle>,
    plan: Option<&'static str>,
    /// True before the first drive.
    before_drives: bool,
    folder: tempfile::TempDir,
    commands: Vec<Command>,
}

fn on_ring(s_m: f64) -> Pose {
    let angle = s_m / RADIUS_M;
    Pose::new(DVec2::from_angle(angle) * RADIUS_M, angle + TAU / 4.0)
}

/// Returns the ring at this step: a wave that travels upstream and that the ego damps.
fn snapshot(step: u64) -> Snapshot {
    let time_s = step as f64 * 0.1;
    let calm = (-time_s / 90.0).exp();
    let speed = |s_m: f64| 4.3 + 3.6 * calm * ((s_m + 4.5 * time_s) / LENGTH_M * TAU).sin();
    let place = |car: f64| (car * LENGTH_M / 22.0 + 4.0 * time_s) % LENGTH_M;
    let car = |id: u32| {
        let s_m = place(f64::from(id));
        let (pose, speed_mps) = (on_ring(s_m), speed(s_m));
        VehicleSnapshot {
            id: VehicleId(id),
            pose,
            pose_before: pose,
            s_m: Some(s_m),
            speed_mps,
            ..VehicleSnapshot::default()
        }
    };
    let cars: Vec<VehicleSnapshot> = (1..=CARS).map(car).collect();
    let (ego_s_m, pose) = (place(0.0), on_ring(place(0.0)));
    let ego = EgoState {
        position: DVec3::new(pose.position.x, pose.position.y, 0.0),
        rotation: Quat::from_rotation_z(pose.yaw_rad as f32),
        speed_mps: speed(ego_s_m),
        ..EgoState::default()
    };
    let advice = Advice {
        issued: Tick(step * 10),
        hold: codrive::policy::Hold::of_steps(10, 0.1),
        action: Action::Speed(4.3),
        target_mps: 4.3,
        range_mps: 0.447,
        is_fallback: false,
        driver: None,
        observed: None,
    };
    let mean = (ego.speed_mps + cars.iter().map(|car| car.speed_mps).sum::<f64>()) / 22.0;
    let leader = Some(Leader { id: VehicleId(1), gap_m: 6.4, speed_mps: cars[0].speed_mps });
    Snapshot {
        tick: Tick(step * 10),
        ego,
        ego_before: ego,
        ego_s_m,
        lane_offset_m: 0.0,
        cars,
        leader,
        advice: (step > 200).then_some(advice),
        mean_speed_mps: mean,
        ..Snapshot::default()
    }
}

impl Bench {
    /// Returns the state of a drive after this many steps.
    pub fn after(steps: u64) -> Self {
        let scenario = Scenario::default();
        let choices = SettingChoices::default().with("map", ["ring-250", "practice"], None);
        let folder = tempfile::tempdir().unwrap();
        let mut panel = SettingsPanel::new(&scenario, choices);
        panel.keep_presets(PresetList::in_folder(folder.path().join("scenarios")));
        let road = (0..120).map(|i| on_ring(f64::from(i) / 120.0 * LENGTH_M).position.to_array()).collect();
        let mut log = DriveLog::on(road, LENGTH_M, 4.0, 8.7);
        for step in 0..=steps {
            log.add(&snapshot(step), 10);
        }
        let health = DriveHealth {
            frame_ms: [16.7, 21.0],
            dropped_s: [0.0, 0.0],
            latency_ms: Some([31.0, 44.0]),
            will_record: false,
            recording: Some(RecordingHealth { waiting: [0, 32], free_gb: Some(61.4) }),
            wheel: WheelHealth::There("Logitech G29".into()),
            contacts: ContactHealth::default(),
            engine: "SUMO 1.24.0 (libsumo)".into(),
            error: None,
        };
        Self {
            experimenter: ExperimenterPanel::default(),
            panel,
            scenario,
            phase: DrivePhase::Running,
            log,
            now: snapshot(steps),
            health,
            events: Vec::new(),
            picture: None,
            plan: None,
            before_drives: false,
            folder,
            commands: Vec::new(),
        }
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        let picture = self.picture.get_or_insert_with(|| {
            // Sky over grass, in place of the driver's picture.
            let row = |y: usize| {
                if y < 90 { egui::Color32::from_rgb(120, 160, 210) } else { egui::Color32::from_rgb(70, 90, 50) }
            };
            let pixels = (0..320 * 180).map(|i| row(i / 320)).collect();
            ui.ctx().load_texture("driver", egui::ColorImage::new([320, 180], pixels), egui::TextureOptions::LINEAR)
        });
        let drive = PanelState {
            scenario: &self.scenario,
            phase: self.phase,
            readings: Some(Readings::from(&self.now)),
            history: &self.log.history,
            in_range: self.log.share_in_range(),
            engine: &self.health.engine,
            policy: "two-phase",
            dropped: Duration::ZERO,
            stalls: 0,
            frame_ms: 16.7,
            error: None,
            recorded_in: None,
        };
        let picture = Some((picture.id(), [320, 180]));
        let state =
            ExperimenterState { drive, snapshot: Some(&self.now), health: &self.health, picture, events: &self.events };
        let words = self.plan;
        let mut plan = |ui: &mut egui::Ui| {
            ui.label(words.unwrap_or_default());
        };
        let plan: Option<&mut dyn FnMut(&mut egui::Ui)> = if words.is_some() { Some(&mut plan) } else { None };
        let log = (!self.before_drives).then_some(&self.log);
        let asked = self.experimenter.show(ui, &state, log, &mut self.panel, plan);
        self.commands.extend(asked);
    }
}

pub fn harness(bench: Bench, size: [f32; 2], scale: f32) -> Harness<'static, Bench> {
    crate::harness(bench, size, scale, |ui, bench| bench.show(ui))
}

/// Returns a window as high as the settings.
fn tall(bench: Bench) -> Harness<'static, Bench> {
    harness(bench, [1400.0, 1900.0], 1.0)
}

fn click(harness: &mut Harness<'static, Bench>, button: &str) -> Vec<Command> {
    harness.get_by_role_and_label(Role::Button, button).click();
    harness.run();
    std::mem::take(&mut harness.state_mut().commands)
}

fn press(harness: &mut Harness<'static, Bench>, modifiers: Modifiers, key: Key) -> Vec<Command> {
    harness.key_press_modifiers(modifiers, key);
    harness.run();
    std::mem::take(&mut harness.state_mut().commands)
}

fn type_into(harness: &mut Harness<'static, Bench>, role: Role, label: &str, text: &str) {
    harness.get_by_role_and_label(role, label).click();
    harness.run();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text(text.into()));
    harness.run();
}

fn restarted(commands: &[Command]) -> &Scenario {
    match commands {
        [Command::Drive(PanelCommand::Restart(scenario))] => scenario,
        other => panic!("not one restart: {other:?}"),
    }
}

#[test]
fn the_range_is_set_and_comes_with_the_restart() {
    let mut harness = tall(Bench::after(600));
    type_into(&mut harness, Role::SpinButton, "Range", "2.5");
    harness.key_press(Key::Enter);
    harness.run();
    harness.get_by_label("Edited: restart to apply.");
    let commands = click(&mut harness, "Restart");
    assert_eq!(restarted(&commands).range_mph, 2.5);
}

#[test]
fn settings_are_saved_and_loaded_by_name_and_overwritten_only_on_request() {
    let mut harness = tall(Bench::after(10));
    type_into(&mut harness, Role::SpinButton, "Vehicles", "18");
    harness.key_press(Key::Enter);
    harness.run();
    type_into(&mut harness, Role::TextInput, "Save as", "dense ring");
    click(&mut harness, "Save");
    harness.get_by_label_contains("\"dense ring\" cannot be a name; allowed: 1 to 60 letters, digits");
    type_into(&mut harness, Role::TextInput, "Save as", "dense");
    click(&mut harness, "Save");
    harness.get_by_label_contains("saved as ");
    let file = harness.state().folder.path().join("scenarios/dense.toml");
    assert_eq!(Scenario::from_file(&file).unwrap().vehicles, 18);

    // Back to the driven scenario, and a second save under the same name: refused until confirmed.
    click(&mut harness, "Discard");
    type_into(&mut harness, Role::TextInput, "Save as", "dense");
    click(&mut harness, "Save");
    harness.get_by_label_contains("dense.toml exists: choose another name, or replace it");
    assert_eq!(Scenario::from_file(&file).unwrap().vehicles, 18);
    click(&mut harness, "Load");
    harness.get_by_label("dense is loaded");
    let commands = click(&mut harness, "Restart");
    assert_eq!(restarted(&commands).vehicles, 18);
    click(&mut harness, "Discard");
    click(&mut harness, "Replace");
    assert_eq!(Scenario::from_file(&file).unwrap(), Scenario::default());
}

#[test]
fn a_preset_that_is_wrong_is_named_with_its_line() {
    let bench = Bench::after(10);
    let scenarios = bench.folder.path().join("scenarios");
    std::fs::create_dir(&scenarios).unwrap();
    std::fs::write(scenarios.join("old.toml"), "vehicles = 22\nhold = 3\n").unwrap();
    let mut bench = bench;
    bench.panel.keep_presets(PresetList::in_folder(scenarios));
    let mut harness = tall(bench);
    click(&mut harness, "Load");
    harness.get_by_label_contains("old.toml:2");
    assert!(harness.query_by_label("Edited: restart to apply.").is_none());
}

#[test]
fn a_drive_is_paused_stepped_and_started_with_mouse_and_keys() {
    let mut harness = tall(Bench::after(10));
    assert_eq!(click(&mut harness, "Pause"), [Command::Drive(PanelCommand::Pause)]);
    assert_eq!(press(&mut harness, Modifiers::COMMAND, Key::P), [Command::Drive(PanelCommand::Pause)]);
    harness.state_mut().phase = DrivePhase::Paused;
    harness.run();
    assert_eq!(click(&mut harness, "+1 tick"), [Command::Drive(PanelCommand::SingleStep(SingleStep::Tick))]);
    assert_eq!(press(&mut harness, Modifiers::COMMAND, Key::P), [Command::Drive(PanelCommand::Start)]);
}

#[test]
fn nothing_moves_under_the_pointer_when_the_first_setting_is_changed() {
    let mut harness = tall(Bench::after(10));
    let places = |harness: &Harness<'static, Bench>| {
        ["Vehicles", "Hold", "Discard", "Restart"].map(|name| {
            harness.get_all_by_label(name).map(|node| node.rect().min).min_by(|a, b| a.y.total_cmp(&b.y)).unwrap()
        })
    };
    let before = places(&harness);
    harness.get_by_label("No edits.");
    type_into(&mut harness, Role::SpinButton, "Vehicles", "18");
    harness.key_press(Key::Enter);
    harness.run();
    harness.get_by_label("Edited: restart to apply.");
    assert_eq!(places(&harness), before);
}

#[test]
fn keys_end_the_window_and_list_its_keys() {
    let mut harness = tall(Bench::after(10));
    assert_eq!(press(&mut harness, Modifiers::COMMAND, Key::Q), [Command::End]);
    press(&mut harness, Modifiers::NONE, Key::F1);
    for (key, what) in codrive::panel::experimenter::KEYS {
        harness.get_by_label(key);
        harness.get_by_label(what);
    }
    // Esc closes the list and does not end the session.
    assert_eq!(press(&mut harness, Modifiers::NONE, Key::Escape), []);
    assert!(harness.query_by_label("Keys").is_none());
    let mut bench = Bench::after(10);
    bench.plan = Some("trial 2 of 3");
    let mut harness = tall(bench);
    press(&mut harness, Modifiers::NONE, Key::F1);
    harness.get_by_label("Ctrl+G");
    harness.get_by_label("Skip the current or next item");
}

#[test]
fn moments_are_marked_and_notes_written_with_mouse_and_keys() {
    let mut harness = tall(Bench::after(1250));
    assert_eq!(click(&mut harness, "Mark"), [Command::Mark(1)]);
    assert_eq!(press(&mut harness, Modifiers::COMMAND, Key::M), [Command::Mark(2)]);
    harness.get_by_label("mark 2");
    press(&mut harness, Modifiers::COMMAND, Key::N);
    harness.event(egui::Event::Text("yawned".into()));
    harness.run();
    assert_eq!(press(&mut harness, Modifiers::NONE, Key::Enter), [Command::Note("yawned".into())]);
    // The input is empty again and still has the cursor.
    harness.event(egui::Event::Text("twice".into()));
    harness.run();
    assert_eq!(press(&mut harness, Modifiers::NONE, Key::Enter), [Command::Note("twice".into())]);
    harness.get_by_label("yawned");
    assert_eq!(harness.get_all_by_label("2:05.0").count(), 5, "the clock above and four lines");
}

#[test]
fn an_event_that_waits_is_begun_by_hand() {
    let mut bench = Bench::after(300);
    let event = |name: &str, state: ScriptedState| ListedEvent { name: name.into(), state };
    bench.events = vec![event("leader brakes", ScriptedState::Over), event("cut-in", ScriptedState::Armed)];
    let mut harness = tall(bench);
    harness.run();
    let buttons: Vec<_> = harness.get_all_by_role_and_label(Role::Button, "Begin").collect();
    assert_eq!(buttons.len(), 2);
    assert!(buttons[0].accesskit_node().is_disabled(), "it is over");
    buttons[1].click();
    drop(buttons);
    harness.run();
    assert_eq!(std::mem::take(&mut harness.state_mut().commands), [Command::BeginEvent(1)]);
    assert!(harness.query_by_label("over").is_some() && harness.query_by_label("armed").is_some());
}

#[test]
fn tab_reaches_every_widget_and_the_focus_is_visible() {
    let mut harness = tall(Bench::after(10));
    let mut seen = Vec::new();
    let before = harness.render().unwrap();
    // All widgets once, and on to the vehicles.
    for _ in 0..66 {
        harness.key_press(Key::Tab);
        harness.run();
        let Some(node) = harness.query_all(egui_kittest::kittest::by().predicate(|node| node.is_focused())).next()
        else {
            continue;
        };
        seen.push(node.accesskit_node().label().unwrap_or_default());
    }
    for name in ["Pause", "Restart", "Preset", "Save as", "Vehicles", "Range", "Policy", "by speed", "Mark", "Note"] {
        assert!(seen.iter().any(|label| label == name), "{name} is not reached: {seen:?}");
    }
    let after = harness.render().unwrap();
    let changed = before.pixels().zip(after.pixels()).filter(|(a, b)| a != b).count();
    assert!(changed > 100, "{changed} pixels show where the keyboard is");
    // Space and Enter press the focused button.
    harness.get_by_role_and_label(Role::Button, "Pause").focus();
    harness.run();
    assert_eq!(press(&mut harness, Modifiers::NONE, Key::Space), [Command::Drive(PanelCommand::Pause)]);
}

#[test]
fn in_a_study_the_plan_is_on_the_left_and_the_panel_commands_no_drive() {
    let mut bench = Bench::after(100);
    bench.plan = Some("trial 2 of 3");
    let mut harness = tall(bench);
    harness.get_by_label("trial 2 of 3");
    for gone in ["Restart", "Pause", "Vehicles"] {
        assert!(harness.query_by_label(gone).is_none(), "{gone}");
    }
    for key in [Key::P, Key::M, Key::Q] {
        assert_eq!(press(&mut harness, Modifiers::COMMAND, key), [], "the session's own commands are the only ones");
    }
    assert!(harness.query_by_label("Mark").is_none() && harness.query_by_label("Note").is_none());
}

/// Before the first drive the window shows only the participant's pages, as large as it permits.
#[test]
fn the_participants_pages_are_shown_large_until_the_first_drive() {
    let seen = |before_drives: bool| {
        let bench = Bench { before_drives, plan: Some("consent"), ..Bench::after(100) };
        let harness = harness(bench, [1920.0, 1080.0], 1.0);
        assert_eq!(harness.query_by_label("From above").is_some(), !before_drives);
        harness.get_by_label("The driver's picture").rect().width()
    };
    let [page, drive] = [seen(true), seen(false)];
    // Half of the window: letters of 1/25 of the page's height are then 22 points high, as readable as the window's own.
    assert!(page > 0.5 * 1920.0 && drive < 0.35 * 1920.0, "{page} {drive}");
}

#[test]
fn a_narrow_window_has_pages_turned_by_keys_and_shows_the_worst_lamp() {
    let mut bench = Bench::after(600);
    bench.health.recording = Some(RecordingHealth { waiting: [20, 32], free_gb: Some(61.4) });
    let mut harness = harness(bench, [640.0, 400.0], 2.0);
    harness.get_by_label("Recorder: recording, 20 of 32 batches waiting");
    harness.get_by_label("Restart");
    press(&mut harness, Modifiers::COMMAND, Key::Num2);
    harness.get_by_label("View of the participant");
    assert!(harness.query_by_label("Restart").is_none());
    press(&mut harness, Modifiers::COMMAND, Key::Num3);
    harness.get_by_label("Space and time, metres along the road");
    press(&mut harness, Modifiers::COMMAND, Key::N);
    harness.event(egui::Event::Text("from any page".into()));
    harness.run();
    assert_eq!(press(&mut harness, Modifiers::NONE, Key::Enter), [Command::Note("from any page".into())]);
    harness.get_by_label("Plots").click();
    harness.run();
    harness.get_by_label("Space and time, metres along the road");
}

/// Counts the pixels of these colours. Pictures for visual checks are written only if the environment names a folder.
#[test]
fn cars_lines_and_lamps_are_on_the_picture_at_every_scale() {
    for (name, size, scale) in
        [("1x", [1280.0, 800.0], 1.0), ("2x", [1280.0, 800.0], 2.0), ("laptop-2x", [640.0, 400.0], 2.0)]
    {
        let mut bench = Bench::after(2600);
        bench.health.wheel = WheelHealth::Lost;
        bench.health.latency_ms = Some([61.0, 75.0]);
        let mut harness = harness(bench, size, scale);
        press(&mut harness, Modifiers::COMMAND, Key::M);
        press(&mut harness, Modifiers::COMMAND, Key::Num2);
        let picture = harness.render().expect("a picture");
        let count = |rgb: [u8; 3]| picture.pixels().filter(|p| p.0[..3] == rgb).count() as f32 / (scale * scale);
        let ego = count([235, 64, 52]);
        assert!(ego > 15.0, "{name}: {ego} points of the ego");
        let others = count([70, 180, 90]);
        assert!(others > 21.0 * 15.0, "{name}: {others} points of the other cars");
        let red = count([theme::RED.r(), theme::RED.g(), theme::RED.b()]);
        assert!(red > 60.0, "{name}: {red} points of the red lamp");
        save(&picture, name);
        press(&mut harness, Modifiers::COMMAND, Key::Num3);
        save(&harness.render().expect("a picture"), &format!("{name}-plots"));
        press(&mut harness, Modifiers::COMMAND, Key::Num4);
        save(&harness.render().expect("a picture"), &format!("{name}-state"));
    }
}

pub fn save(picture: &image::RgbaImage, name: &str) {
    if let Ok(folder) = std::env::var("CODRIVE_PICTURES") {
        picture.save(std::path::Path::new(&folder).join(format!("experimenter-{name}.png"))).expect("saved");
    }
}
