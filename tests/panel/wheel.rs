//! The page of wheel and pedals and the check screen, used through their labels.

use codrive::{
    input::{
        ButtonAction,
        calibrate::{Calibration, CalibrationStep, HOLD_S, REST_S},
        profiles::{self, UnprofiledDevice},
    },
    panel::{
        self, DisplayTruth,
        calibration::{CalibrationCommand, CalibrationPage, CalibrationProgress, PluggedWheel},
        theme,
    },
};
use egui::accesskit::Role;
use egui_kittest::{Harness, kittest::Queryable};

/// The page with the state that the program gives it.
#[derive(Default)]
struct Bench {
    page: CalibrationPage,
    wheel: Option<PluggedWheel>,
    printed: Option<String>,
    commands: Vec<CalibrationCommand>,
}

fn device() -> UnprofiledDevice {
    let axes = [(0, [0, 65_535]), (1, [0, 255]), (2, [0, 255]), (5, [0, 255])];
    let values = [(0, 27_000), (1, 255), (2, 130), (5, 255)];
    UnprofiledDevice {
        name: "Logitech G29".into(),
        id: (0x046d, 0xc24f),
        axes: axes.into(),
        values: values.into(),
        ..UnprofiledDevice::default()
    }
}

fn wheel() -> PluggedWheel {
    let profile = profiles::named("g29").unwrap();
    let device = device();
    PluggedWheel { device: device.name, profile, raw: device.values, last_button: None, asked: None }
}

fn bench(wheel: Option<PluggedWheel>) -> Bench {
    let mut bench = Bench { wheel, ..Bench::default() };
    bench.page.open = true;
    bench
}

fn harness(bench: Bench) -> Harness<'static, Bench> {
    crate::harness(bench, [760.0, 600.0], 1.0, |ui, bench| {
        let asked = bench.page.show(ui, bench.wheel.as_ref(), bench.printed.as_deref());
        bench.commands.extend(asked);
    })
}

fn press(harness: &mut Harness<'static, Bench>, button: &str) -> Vec<CalibrationCommand> {
    harness.get_by_role_and_label(Role::Button, button).click();
    harness.run();
    std::mem::take(&mut harness.state_mut().commands)
}

/// Returns the picture of a window; writes it for visual checks only if the environment names a folder.
fn picture<S>(harness: &mut Harness<'static, S>, name: &str) -> image::RgbaImage {
    let picture = harness.render().expect("a picture");
    if let Ok(folder) = std::env::var("CODRIVE_PICTURES") {
        picture.save(std::path::Path::new(&folder).join(format!("{name}.png"))).expect("saved");
    }
    picture
}

/// Returns a calibration of a G29 with all steps done before `until`.
fn answered(until: CalibrationStep) -> Calibration {
    let mut calibration = Calibration::new(device(), 0.0).unwrap();
    let mut now_s = REST_S + 0.1;
    calibration.time(now_s);
    for (code, raw) in [(0, 150), (0, 65_400), (0, 32_700), (2, 3), (2, 130), (5, 90), (5, 255)] {
        if calibration.step() == until {
            break;
        }
        calibration.moved(code, raw, now_s + 0.1);
        now_s += 0.2 + HOLD_S;
        calibration.time(now_s);
    }
    assert_eq!(calibration.step(), until);
    calibration
}

fn asked(calibration: &Calibration) -> CalibrationProgress {
    let done = calibration.step() == CalibrationStep::Done;
    CalibrationProgress {
        step: calibration.step(),
        bars: calibration.bars(),
        learnt: done.then(|| calibration.profile("Rig 1")),
    }
}

#[test]
fn without_a_wheel_the_page_says_what_to_do() {
    let harness = harness(bench(None));
    harness.get_by_label_contains("No steering wheel is plugged in");
}

#[test]
fn the_page_shows_the_wheel_angle_the_pedals_and_the_last_button() {
    let mut shown = wheel();
    shown.last_button = Some(289.into());
    let mut harness = harness(bench(Some(shown)));
    // (32767 - 27000) / 32767 of 450 degrees to the left; the accelerator is half pressed, without its dead zones.
    harness.get_by_label_contains("+79.2°");
    harness.get_by_label("travel  49 %  effect  49 %");
    harness.get_by_label("travel   0 %  effect   0 %");
    harness.get_by_label("pressed last: 289, horn");
    picture(&mut harness, "wheel-live");
}

#[test]
fn a_calibration_is_begun_asked_and_saved_with_its_own_name() {
    let mut harness = harness(bench(Some(wheel())));
    assert_eq!(press(&mut harness, "Calibrate"), [CalibrationCommand::Begin]);
    let half = answered(CalibrationStep::Accelerator);
    harness.state_mut().wheel.as_mut().unwrap().asked = Some(asked(&half));
    harness.run();
    harness.get_by_label("Press the accelerator to the floor and hold it.");
    harness.get_by_label("steering");
    picture(&mut harness, "wheel-question");
    let done = answered(CalibrationStep::Done);
    harness.state_mut().wheel.as_mut().unwrap().asked = Some(asked(&done));
    harness.run();
    let commands = press(&mut harness, "Save");
    let [CalibrationCommand::Save(profile)] = &commands[..] else { panic!("{commands:?}") };
    assert_eq!((profile.name.as_str(), profile.steering.left, profile.steering.centre), ("Rig 1", 150, 32_700));
    assert_eq!(profile.brake.as_ref().unwrap().pressed, 90);
    assert_eq!(press(&mut harness, "Calibrate"), [CalibrationCommand::Begin], "and once more");
}

#[test]
fn a_calibration_can_be_given_up() {
    let mut shown = wheel();
    shown.asked = Some(asked(&answered(CalibrationStep::Left)));
    let mut harness = harness(bench(Some(shown)));
    assert_eq!(press(&mut harness, "Cancel"), [CalibrationCommand::Cancel]);
}

#[test]
fn an_action_waits_for_its_button_and_takes_it_from_another() {
    let mut harness = harness(bench(Some(wheel())));
    press(&mut harness, "button for horn");
    // Button 288 is the cross, which confirms responses in the shipped profile.
    harness.state_mut().wheel.as_mut().unwrap().last_button = Some(288.into());
    harness.run();
    let commands = press(&mut harness, "Save");
    let [CalibrationCommand::Save(profile)] = &commands[..] else { panic!("{commands:?}") };
    assert_eq!(profile.buttons.action(288), Some(ButtonAction::Horn));
    assert!(profile.buttons.answer.is_empty() && profile.buttons.horn == [288]);
}

#[test]
fn an_edited_curve_can_be_discarded() {
    let mut harness = harness(bench(Some(wheel())));
    assert!(harness.query_by_label("Save").is_none(), "nothing to save yet");
    press(&mut harness, "button for horn");
    harness.state_mut().wheel.as_mut().unwrap().last_button = Some(288.into());
    harness.run();
    assert_eq!(press(&mut harness, "Discard"), [CalibrationCommand::Cancel]);
    assert!(harness.query_by_label("Save").is_none());
}

#[test]
fn the_ruler_of_the_check_screen_has_its_stated_length() {
    let truth = DisplayTruth {
        screen_width_m: 1.25,
        eye_distance_m: 1.0,
        screen: vec!["HDMI-1, picture of 1250 x 700 pixels".into()],
    };
    let mut harness = Harness::builder()
        .with_size(egui::vec2(1250.0, 700.0))
        .with_context_setup(theme::apply)
        .wgpu()
        .build_ui_state(|ui, truth: &mut DisplayTruth| panel::check(ui, truth), truth);
    harness.run();
    let picture = picture(&mut harness, "check-screen");
    // A millimetre is a pixel here: the line of 1.1 m begins at 75 and ends at 1175, in the row of the ruler.
    let row = (0.16 * 700.0) as u32;
    let line = |x: u32| (row - 1..=row + 1).any(|y| picture.get_pixel(x, y).0[0] > 150);
    let lit: Vec<u32> = (10..1240).filter(|x| line(*x)).collect();
    assert!(lit.first().unwrap().abs_diff(75) <= 1 && lit.last().unwrap().abs_diff(1175) <= 1, "{lit:?}");
    // The circle of 30 cm is 300 pixels high and wide.
    let green = |x: u32, y: u32| {
        let [r, g, b] = [0, 1, 2].map(|i| u16::from(picture.get_pixel(x, y).0[i]));
        g > 150 && g > r + 60 && g > b + 40
    };
    let all: Vec<(u32, u32)> =
        (0..700).flat_map(|y| (0..1250).map(move |x| (x, y))).filter(|(x, y)| green(*x, *y)).collect();
    let span = |of: fn(&(u32, u32)) -> u32| all.iter().map(of).max().unwrap() - all.iter().map(of).min().unwrap();
    assert!(
        span(|p| p.0).abs_diff(300) <= 3 && span(|p| p.1).abs_diff(300) <= 3,
        "{} {}",
        span(|p| p.0),
        span(|p| p.1)
    );
}
