//! The experimenter's settings panel, used through the labels on it.

use codrive::{
    panel::{
        DrivePhase, PanelCommand, PanelState, Readings, SettingChoices, SettingsPanel, SingleStep, SpeedHistory, theme,
    },
    policy::{Action, Advice},
    scenario::Scenario,
    time::Tick,
    traffic::EngineChoice,
    units::SpeedUnit,
};
use egui::accesskit::Role;
use egui_kittest::{Harness, kittest::Queryable};
use std::{path::PathBuf, time::Duration};

const KEYS: [(&str, &str); 4] =
    [("Space", "start, pause"), ("F1", "this list"), ("Up, W", "accelerate"), ("Down, S", "brake")];

/// The panel with the state that the program gives it.
struct Bench {
    panel: SettingsPanel,
    scenario: Scenario,
    phase: DrivePhase,
    readings: Option<Readings>,
    history: SpeedHistory,
    error: Option<String>,
    recorded_in: Option<PathBuf>,
    commands: Vec<PanelCommand>,
}

impl Bench {
    fn new(scenario: Scenario, phase: DrivePhase) -> Self {
        let choices = SettingChoices::default()
            .with("map", ["practice", "ring-250", "ring-641"], Some("path of a net.xml"))
            .with("policy", codrive::policy::NAMES, None)
            .with("driver", ["follow", "perfect", "sloppy", "idm"], None);
        let mut panel = SettingsPanel::new(&scenario, choices);
        panel.open = true;
        let (readings, history, commands) = (None, SpeedHistory::default(), Vec::new());
        Self { panel, scenario, phase, readings, history, error: None, recorded_in: None, commands }
    }

    /// Returns the state after 150 s of a drive on the ring, with a wave that the ego damps.
    fn driving() -> Self {
        let mut bench = Self::new(Scenario::default(), DrivePhase::Running);
        for step in 0..1500 {
            let time_s = f64::from(step) * 0.1;
            let wave = (-time_s / 60.0).exp();
            let mean = 4.3 - 1.4 * wave;
            let ego = 4.3 + 4.0 * wave * (time_s * 0.19).sin();
            let target = (time_s > 20.0).then_some(if time_s < 80.0 { 2.5 } else { 4.3 });
            bench.history.push(time_s, mean, ego, target);
        }
        bench.readings = Some(Readings {
            time_s: 149.9,
            speed_mps: 4.45,
            advice: Some(Advice {
                issued: Tick(14_900),
                hold: codrive::policy::Hold::of_steps(10, 0.1),
                action: Action::Speed(4.3),
                target_mps: 4.3,
                range_mps: 0.447,
                is_fallback: false,
                driver: None,
                observed: None,
            }),
            leader: Some((6.31, 4.52)),
            mean_speed_mps: 4.18,
        });
        bench
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        let state = PanelState {
            scenario: &self.scenario,
            phase: self.phase,
            readings: self.readings,
            history: &self.history,
            in_range: None,
            engine: "SUMO 1.24.0 (libsumo)",
            policy: "two-phase",
            dropped: Duration::ZERO,
            stalls: 0,
            frame_ms: 16.7,
            error: self.error.as_deref(),
            recorded_in: self.recorded_in.as_deref(),
        };
        let asked = self.panel.show(ui, &state, &KEYS);
        self.commands.extend(asked);
    }
}

fn harness(bench: Bench, size: [f32; 2], scale: f32) -> Harness<'static, Bench> {
    crate::harness(bench, size, scale, |ui, bench| bench.show(ui))
}

/// Returns a window high enough for the whole panel, so that no test has to scroll.
fn tall(bench: Bench) -> Harness<'static, Bench> {
    harness(bench, [900.0, 3600.0], 1.0)
}

/// Opens a section that is closed at first.
fn open(harness: &mut Harness<'static, Bench>, section: &str) {
    harness.get_by_label(section).click();
    harness.run();
}

/// Types a number into the input with this label as a user does: click, select all, type, Enter.
fn type_number(harness: &mut Harness<'static, Bench>, label: &str, text: &str) {
    harness.get_by_role_and_label(Role::SpinButton, label).click();
    harness.run();
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    harness.event(egui::Event::Text(text.into()));
    harness.run();
    harness.key_press(egui::Key::Enter);
    harness.run();
}

fn press(harness: &mut Harness<'static, Bench>, button: &str) -> Vec<PanelCommand> {
    harness.get_by_role_and_label(Role::Button, button).click();
    harness.run();
    std::mem::take(&mut harness.state_mut().commands)
}

fn restarted(commands: &[PanelCommand]) -> &Scenario {
    match commands {
        [PanelCommand::Restart(scenario)] => scenario,
        other => panic!("not one restart: {other:?}"),
    }
}

#[test]
fn an_edited_number_comes_with_the_restart() {
    let mut harness = tall(Bench::driving());
    type_number(&mut harness, "Vehicles", "18");
    harness.get_by_label("Edited: restart to apply.");
    assert_eq!(harness.state().commands, [], "editing alone asks for nothing");
    let commands = press(&mut harness, "Restart");
    assert_eq!(*restarted(&commands), Scenario { vehicles: 18, ..Scenario::default() });

    // The program now drives the edited scenario: nothing is left to apply.
    harness.state_mut().scenario.vehicles = 18;
    harness.run();
    assert!(harness.query_by_label("Edited: restart to apply.").is_none());
}

#[test]
fn a_number_out_of_range_becomes_the_nearest_allowed() {
    let mut harness = tall(Bench::driving());
    type_number(&mut harness, "Vehicles", "5000");
    type_number(&mut harness, "Hold", "-3");
    type_number(&mut harness, "T  Desired time gap to the leader", "99");
    type_number(&mut harness, "Range", "nan");
    // A hold of one tick does not fit steps of 0.1 s; the panel says so and does not restart.
    harness.get_by_label_contains("hold_s is 0.01; allowed: a whole number of steps");
    assert_eq!(press(&mut harness, "Restart"), []);
    type_number(&mut harness, "Hold", "2");
    let commands = press(&mut harness, "Restart");
    let scenario = restarted(&commands);
    assert_eq!((scenario.vehicles, scenario.hold_s, scenario.idm.t, scenario.range_mph), (1000, 2.0, 5.0, 1.0));
}

#[test]
fn words_are_chosen_from_lists() {
    let mut harness = tall(Bench::driving());
    harness.get_by_label("Policy").click();
    harness.run();
    harness.get_by_label("follower-stopper").click();
    harness.run();
    harness.get_by_label("Map").click();
    harness.run();
    harness.get_by_label("ring-641").click();
    harness.run();
    let commands = press(&mut harness, "Restart");
    let scenario = restarted(&commands);
    assert_eq!((scenario.policy.as_str(), scenario.map.as_str()), ("follower-stopper", "ring-641"));
}

#[test]
fn values_outside_the_list_can_be_typed() {
    let mut harness = tall(Bench::driving());
    harness.get_by_label("Map").click();
    harness.run();
    harness.get_by_label("path of a net.xml …").click();
    harness.run();
    harness.get_by_label("Map").click();
    harness.run();
    harness.get_by_label("Map").type_text("town/net.xml");
    harness.run();
    let commands = press(&mut harness, "Restart");
    assert_eq!(restarted(&commands).map, "town/net.xml");
    press(&mut harness, "list");
    let commands = press(&mut harness, "Restart");
    assert_eq!(restarted(&commands).map, "practice");
}

#[test]
fn edits_can_be_taken_back() {
    let mut harness = tall(Bench::driving());
    let before = harness.get_by_label("Seed").rect();
    press(&mut harness, "Discard");
    assert_eq!(*restarted(&press(&mut harness, "Restart")), Scenario::default(), "there is nothing to take back yet");
    type_number(&mut harness, "Seed", "7");
    assert_eq!(harness.get_by_label("Seed").rect(), before, "nothing moves under the pointer");
    press(&mut harness, "Discard");
    let commands = press(&mut harness, "Restart");
    assert_eq!(*restarted(&commands), Scenario::default());
}

#[test]
fn a_running_drive_can_be_paused_and_a_paused_one_stepped_and_started() {
    let mut harness = tall(Bench::driving());
    assert_eq!(press(&mut harness, "+1 step"), [], "not while time runs");
    assert_eq!(press(&mut harness, "Pause"), [PanelCommand::Pause]);
    harness.state_mut().phase = DrivePhase::Paused;
    harness.run();
    assert_eq!(press(&mut harness, "+1 tick"), [PanelCommand::SingleStep(SingleStep::Tick)]);
    assert_eq!(press(&mut harness, "+1 step"), [PanelCommand::SingleStep(SingleStep::Step)]);
    assert_eq!(press(&mut harness, "Start"), [PanelCommand::Start]);
    harness.state_mut().phase = DrivePhase::Ended;
    harness.run();
    assert_eq!(press(&mut harness, "Start"), [], "what is over only restarts");
}

#[test]
fn every_setting_for_windows_is_in_the_panel_with_its_tooltip() {
    let mut harness = tall(Bench::driving());
    for section in ["Display", "Sound", "Rig", "Surroundings", "Secondary task", "Automation"] {
        open(&mut harness, section);
    }
    for (name, path) in [("Range", "range_mph"), ("Screen width", "screen_width_m"), ("Creep", "creep")] {
        let field = Scenario::fields().into_iter().find(|field| field.path == path).expect("a setting");
        assert!(harness.query_by_label_contains(&field.doc).is_none());
        let input = if path == "creep" { Role::CheckBox } else { Role::SpinButton };
        harness.get_by_role_and_label(input, name).hover();
        harness.run_steps(60);
        harness.get_by_label_contains(&field.doc);
        harness.remove_cursor();
        harness.run_steps(60);
    }
    // A drive in a window always has a participant, so the panel lacks this setting.
    for field in Scenario::fields().into_iter().filter(|field| field.path != "participant") {
        let flag = field.flag().replace('-', " ");
        let found = match field.table() {
            Some(_) => {
                harness.query_all_by_label_contains(field.doc.split([',', ';', ':']).next().unwrap_or_default()).count()
            }
            None => harness.query_all_by_label(&(flag[..1].to_uppercase() + &flag[1..])).count(),
        };
        assert!(found >= 1, "{} is not on the panel", field.path);
    }
}

#[test]
fn the_readings_are_those_of_the_drive() {
    let mut harness = tall(Bench::driving());
    let shows = |harness: &Harness<'static, Bench>, text: &str| {
        assert!(harness.query_by_label_contains(text).is_some(), "no {text}");
    };
    // 4.45 m/s are 9.95 mph, 4.3 are 9.62; the range is 1 mph to either side.
    for text in ["2:29.9", "10.0 mph    4.45 m/s", "9.6 mph    4.30 m/s", "8.6 – 10.6 mph  in range", "6.3 m"] {
        shows(&harness, text);
    }
    harness.state_mut().scenario.display.units = SpeedUnit::Kmh;
    harness.state_mut().readings.as_mut().expect("readings").speed_mps = 5.0;
    harness.run();
    shows(&harness, "18.0 km/h    5.00 m/s");
    shows(&harness, "too fast");
}

#[test]
fn an_error_is_shown_in_full() {
    let mut bench = Bench::new(Scenario::default(), DrivePhase::Ended);
    let message = "SUMO is not here: no libsumocpp.so\n  remedy: run scripts/setup, or drive with --traffic native";
    bench.error = Some(message.into());
    let harness = tall(bench);
    harness.get_by_label(message);
    harness.get_by_label("not started");
}

#[test]
fn a_closed_panel_leaves_no_pixel() {
    let mut bench = Bench::driving();
    bench.panel.open = false;
    let mut harness = tall(bench);
    assert!(harness.query_by_label("Restart").is_none());
    let picture = harness.render().expect("a picture");
    let first = *picture.get_pixel(0, 0);
    assert!(picture.pixels().all(|pixel| *pixel == first));
}

/// Returns the areas in which the panel paints in a window of 1280 x 720 points.
fn painted(mut bench: Bench) -> Vec<egui::Rect> {
    let ctx = egui::Context::default();
    theme::apply(&ctx);
    let mut areas = Vec::new();
    // The second pass uses the sizes that the first one found.
    for _ in 0..2 {
        let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1280.0, 720.0));
        let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
        let mut output = ctx.run_ui(input, |ui| bench.show(ui));
        let shapes = std::mem::take(&mut output.shapes);
        output.drop_without_applying_deltas();
        let rect =
            |clipped: egui::epaint::ClippedShape| clipped.shape.visual_bounding_rect().intersect(clipped.clip_rect);
        areas = shapes.into_iter().map(rect).filter(egui::Rect::is_positive).collect();
    }
    areas
}

#[test]
fn the_panel_paints_on_its_own_side_only_and_nothing_when_closed() {
    let open = painted(Bench::driving());
    assert!(!open.is_empty());
    let left = open.iter().map(|area| area.left()).fold(f32::INFINITY, f32::min);
    assert!((900.0..940.0).contains(&left), "{left}: the picture to the left of the panel stays");
    let mut closed = Bench::driving();
    closed.panel.open = false;
    assert_eq!(painted(closed), []);
}

#[test]
fn the_list_of_keys_shows_what_it_was_given() {
    let mut bench = Bench::driving();
    bench.panel.open = false;
    bench.panel.help_open = true;
    let harness = tall(bench);
    for (key, what) in KEYS {
        harness.get_by_label(key);
        harness.get_by_label(what);
    }
}

/// Pictures for visual checks are written only if the environment names a folder.
#[test]
fn the_panel_fits_a_laptop_at_every_scale() {
    for (name, size, scale) in
        [("1x", [1280.0, 900.0], 1.0), ("2x", [800.0, 900.0], 2.0), ("tall", [900.0, 1700.0], 1.0)]
    {
        let mut bench = Bench::driving();
        bench.panel.help_open = name == "1x";
        if name == "tall" {
            bench.error = Some("22 cars of 5 m and the gaps between them need 154 m; ring-150 has 150 m".into());
        }
        let mut harness = harness(bench, size, scale);
        type_number(&mut harness, "Vehicles", "18");
        if name == "2x" {
            harness.get_by_role_and_label(Role::SpinButton, "Vehicles").hover();
            harness.run_steps(60);
        }
        let panel = harness.get_by_label("Restart").rect().union(harness.get_by_label("codrive").rect());
        assert!(panel.right() <= size[0] && panel.left() > size[0] - 400.0, "{panel:?}");
        let picture = harness.render().expect("a picture");
        if let Ok(folder) = std::env::var("CODRIVE_PICTURES") {
            picture.save(std::path::Path::new(&folder).join(format!("panel-{name}.png"))).expect("saved");
        }
    }
}

/// Returns the panel's output, open or hidden, as drawn over the picture of a drive.
fn picture_with(open: bool) -> image::RgbaImage {
    use codrive::{
        render::{Gpu, OFFSCREEN, PanelOutput as Output, Quality, Renderer, render_with_panel},
        scene::view_options,
        scene::{StaticScene, ViewKind, view},
        sim::World,
    };
    const SIZE: [u32; 2] = [320, 180];
    let gpu = Gpu::shared().expect("a graphics adapter is needed");
    let world = World::new(&Scenario { traffic: EngineChoice::Native, ..Scenario::default() }).unwrap();
    let static_scene = StaticScene::build(world.map(), 1);
    let mut renderer = Renderer::new(gpu, &static_scene, OFFSCREEN, Quality::LOW);
    let view = view(world.snapshot(), 1.0, ViewKind::Driver, &view_options(world.scenario()), &static_scene);
    let mut bench = Bench::driving();
    bench.panel.open = open;
    let ctx = egui::Context::default();
    theme::apply(&ctx);
    let size = egui::vec2(SIZE[0] as f32, SIZE[1] as f32);
    let input =
        egui::RawInput { screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size)), ..Default::default() };
    let output = ctx.run_ui(input, |ui| bench.show(ui));
    let panel = Some(Output { ctx: &ctx, output });
    let with = render_with_panel(gpu, &mut renderer, &view, panel, SIZE).unwrap();
    let without = render_with_panel(gpu, &mut renderer, &view, None, SIZE).unwrap();
    let mut difference = with;
    for (pixel, plain) in difference.pixels_mut().zip(without.pixels()) {
        pixel.0 = std::array::from_fn(|i| pixel.0[i].abs_diff(plain.0[i]));
    }
    difference
}

#[test]
fn a_hidden_panel_leaves_no_pixel_on_the_picture() {
    let changed = |open| picture_with(open).pixels().filter(|pixel| pixel.0 != [0; 4]).count();
    assert_eq!(changed(false), 0);
    assert!(changed(true) > 5000, "an open one is seen");
}
