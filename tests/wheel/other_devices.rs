//! Tests with devices that are no stock Logitech, by umockdev: pedals turned round, wheel bases of other makers, own profiles, mice and
//! pads.

use super::{
    WITHIN, codrive,
    described::{Device, GAMEPAD, JOYSTICK, MOUSE, again_with, movements, presses, run_with},
    wait,
};
use codrive::{
    controls::{Controls, Selector},
    input::{ButtonAction, Devices, ForceInput, RigEvent, profile::ForceBackend, profiles},
};
use std::{fs, path::Path, process::Command, thread::sleep, time::Duration};

const BYTE: [i32; 2] = [0, 255];
const WORD: [i32; 2] = [0, 65_535];

/// G923 whose driver reports 0 for a released pedal, with this value of the steering axis.
fn turned_round(steering: i32) -> Device {
    let axes = [(0, steering, WORD), (1, 0, BYTE), (2, 0, BYTE), (5, 0, BYTE)];
    Device::wheel("Logitech G923 Racing Wheel for PlayStation 4 and PC", (0x046d, 0xc266), &axes)
}

/// Wheel base with eight axes, of which pedals that are plugged into it use three.
fn moza() -> Device {
    let spare = [(3, 0, WORD), (4, 0, WORD), (6, 0, WORD), (7, 0, WORD)];
    let axes = [[(0, 32_768, WORD), (1, 0, WORD), (2, 0, WORD), (5, 0, WORD)], spare].concat();
    Device::wheel("Gudsen MOZA R5 Base", (0x346e, 0x0004), &axes)
}

fn mouse() -> Device {
    Device {
        buttons: MOUSE..MOUSE + 3,
        pushes: false,
        points: true,
        ..Device::wheel("Wheel Mouse", (0x045e, 0x0040), &[])
    }
}

fn pad() -> Device {
    let axes = [(0, 0, [-32_768, 32_767]), (1, 0, [-32_768, 32_767]), (2, 0, BYTE), (5, 0, BYTE)];
    let pad = Device::wheel("Microsoft X-Box 360 pad", (0x045e, 0x028e), &axes);
    Device { buttons: GAMEPAD..GAMEPAD + 8, pushes: false, ..pad }
}

/// Accelerator pressed to the floor and released, as a driver that turns pedals round reports it.
fn pressed_and_released() -> String {
    let press = [60, 150, 255, 255, 150, 60, 0].into_iter().enumerate();
    let moves: Vec<(f64, u16, i32)> = press.map(|(i, raw)| (1.0 + 0.1 * i as f64, 2, raw)).collect();
    movements(&[[(0.5, 0, 33_000)].to_vec(), moves, [(2.0, 0, 40_000)].to_vec()].concat())
}

/// Asserts that the pedals have no effect until the wheel turns right at the end of the events, and that people are told once.
fn assert_refused() {
    let mut devices = Devices::open();
    let (mut news, mut most) = (Vec::new(), 0.0_f32);
    for _ in 0..12_000 {
        news.extend(devices.poll());
        let controls = devices.controls(5.0, None);
        most = most.max(controls.throttle).max(controls.brake);
        if controls.steering_wheel_rad < -1.0 {
            break;
        }
        sleep(Duration::from_millis(5));
    }
    assert!(devices.controls(5.0, None).steering_wheel_rad < -1.0, "{news:?}");
    assert_eq!(most, 0.0, "a pedal had an effect");
    let told = |news: &&RigEvent| matches!(news, RigEvent::Trouble(text) if text.contains("driver turns them round"));
    let told: Vec<&RigEvent> = news.iter().filter(told).collect();
    assert!(
        matches!(told[..], [RigEvent::Trouble(text)] if text.contains("remedy: ") && text.contains("codrive calibrate")),
        "{told:?}"
    );
}

#[test]
fn pedals_turned_round_are_refused_aloud_and_never_full_throttle() {
    if std::env::var_os(WITHIN).is_none() {
        let config = tempfile::tempdir().unwrap();
        let test = "other_devices::pedals_turned_round_are_refused_aloud_and_never_full_throttle";
        again_with(test, &[(&turned_round(32_767), &pressed_and_released())], config.path(), &[]);
        return;
    }
    assert_refused();
}

#[test]
fn pedals_turned_round_are_refused_if_the_driver_reads_them_late() {
    if std::env::var_os(WITHIN).is_none() {
        let config = tempfile::tempdir().unwrap();
        let test = "other_devices::pedals_turned_round_are_refused_if_the_driver_reads_them_late";
        again_with(test, &[(&turned_round(0), &pressed_and_released())], config.path(), &[]);
        return;
    }
    assert_refused();
}

/// Responses of a person at the wheel: the ends, straight ahead, and these values of the pedals, each held for 1.5 s.
fn responses(pedals: [(u16, i32); 4]) -> String {
    let turns = [(0, 150), (0, 65_400), (0, 32_700)];
    let moves: Vec<(f64, u16, i32)> =
        turns.into_iter().chain(pedals).enumerate().map(|(i, (code, raw))| (3.5 + 1.5 * i as f64, code, raw)).collect();
    movements(&moves)
}

fn calibrate(device: &Device, config: &Path, answers: &str, more: &[&str]) -> String {
    let file = config.join("answers");
    fs::write(&file, answers).unwrap();
    let arguments = [&["calibrate", "--name", "Rig 1", "--replay", file.to_str().unwrap()], more].concat();
    let output = run_with(&[(device, "")], config, &[], codrive(), &arguments);
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    text
}

#[test]
fn calibrate_asks_about_pedals_turned_round_and_its_profile_drives() {
    if std::env::var_os(WITHIN).is_none() {
        let (config, device) = (tempfile::tempdir().unwrap(), turned_round(32_767));
        let answers = responses([(2, 255), (2, 0), (5, 250), (5, 0)]);
        let text = calibrate(&device, config.path(), &answers, &[]);
        assert!(text.contains("Is a foot on the pedals?") && text.contains("turns them round"), "{text}");
        assert!(text.contains("accelerator: axis 2, 0 released, 255 pressed"), "{text}");
        let test = "other_devices::calibrate_asks_about_pedals_turned_round_and_its_profile_drives";
        let press = movements(&[(0.5, 2, 255), (1.5, 0, 40_000)]);
        again_with(test, &[(&device, &press)], config.path(), &[]);
        return;
    }
    let (mut devices, mut news) = (Devices::open(), Vec::new());
    wait(&mut devices, &mut news, |c, _| c.steering_wheel_rad < -1.0);
    assert_eq!(devices.wheel_profile().map(|p| p.name.as_str()), Some("Rig 1"));
    assert_eq!(devices.controls(5.0, None).throttle, 1.0);
    assert!(!news.iter().any(|n| matches!(n, RigEvent::Trouble(text) if text.contains("round"))), "{news:?}");
}

/// Runs the doctor and returns its text.
fn doctor(devices: &[(&Device, &str)], config: &Path) -> String {
    let out = config.to_str().unwrap();
    let arguments = ["doctor", "--size", "64x36", "--trees", "0", "--quality", "low", "--out", out];
    String::from_utf8_lossy(&run_with(devices, config, &[], codrive(), &arguments).stdout).into_owned()
}

#[test]
fn doctor_reports_pedals_turned_round_as_a_fault() {
    let config = tempfile::tempdir().unwrap();
    let text = doctor(&[(&turned_round(32_767), "")], config.path());
    assert!(text.contains("driver turns them round") && text.contains("codrive calibrate"), "{text}");
    let at_rest =
        Device { axes: vec![(0, 32_767, WORD), (1, 255, BYTE), (2, 255, BYTE), (5, 255, BYTE)], ..turned_round(0) };
    let text = doctor(&[(&at_rest, "")], config.path());
    assert!(!text.contains("turns them round") && text.contains("profile Logitech G923"), "{text}");
}

#[test]
fn a_base_without_wheel_in_its_name_is_found_and_its_profile_obeyed() {
    if std::env::var_os(WITHIN).is_none() {
        let config = tempfile::tempdir().unwrap();
        let text = doctor(&[(&pad(), ""), (&moza(), "")], config.path());
        assert!(text.contains("Gudsen MOZA R5 Base (346e:0004), profile Gudsen MOZA R5 Base"), "{text}");
        assert!(
            text.contains("constant force yes") && text.contains("not taken for wheels: Microsoft X-Box 360 pad"),
            "{text}"
        );
        let answers = responses([(2, 65_000), (2, 0), (5, 60_000), (5, 0)]);
        let text = calibrate(&moza(), config.path(), &answers, &[]);
        assert!(text.starts_with("Gudsen MOZA R5 Base (346e:0004)\n"), "{text}");
        let test = "other_devices::a_base_without_wheel_in_its_name_is_found_and_its_profile_obeyed";
        again_with(test, &[(&moza(), &movements(&[(0.5, 2, 65_000), (1.5, 0, 0)]))], config.path(), &[]);
        return;
    }
    let (mut devices, mut news) = (Devices::open(), Vec::new());
    wait(&mut devices, &mut news, |c, _| c.steering_wheel_rad > 1.0);
    assert_eq!(devices.wheel_profile().map(|p| p.name.as_str()), Some("Rig 1"));
    assert_eq!(devices.controls(5.0, None).throttle, 1.0);
}

#[test]
fn a_base_without_wheel_in_its_name_is_pushed() {
    if std::env::var_os(WITHIN).is_none() {
        let config = tempfile::tempdir().unwrap();
        let (library, log) = (config.path().join("libSDL2.so"), config.path().join("log"));
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/wheel/haptic.c");
        let ids = ["-DVENDOR=0x346e", "-DPRODUCT=0x0004"];
        let cc = Command::new("cc").args(["-shared", "-fPIC", "-o"]).args([&library, &source]).args(ids).status();
        assert!(cc.expect("no C compiler (cc)\n  remedy: scripts/setup").success());
        let mut profile = profiles::named("g29").unwrap();
        (profile.name, profile.products) = ("Rig 1".into(), vec!["346E:0004".into()]);
        (profile.accelerator.released, profile.accelerator.pressed) = (0, 65_535);
        profile.force.backend = ForceBackend::Sdl;
        let folder = config.path().join("codrive/wheels");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("rig-1.toml"), profile.to_toml()).unwrap();
        let variables = [("CODRIVE_SDL2", library.to_str().unwrap()), ("HAPTIC_LOG", log.to_str().unwrap())];
        let test = "other_devices::a_base_without_wheel_in_its_name_is_pushed";
        again_with(test, &[(&moza(), "")], config.path(), &variables);
        let asked = fs::read_to_string(&log).unwrap();
        let level = |line: &str| {
            let hex = line.strip_prefix("update 3 ")?;
            Some(i16::from_le_bytes([60, 62].map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap())))
        };
        let levels: Vec<i16> = asked.lines().filter_map(level).collect();
        // To the left in the bend, then to the right with the automation.
        let right = levels.iter().position(|level| *level < 0).expect("a level to the right");
        assert!(levels[..right].iter().any(|level| *level > 20_000), "{levels:?}");
        assert!(levels[right..].iter().any(|level| *level < -20_000), "{levels:?}");
        assert!(levels[right..].iter().all(|level| *level <= 0), "{levels:?}");
        assert_eq!(levels.last(), Some(&0));
        assert!(asked.contains("close haptic"), "{asked}");
        return;
    }
    let (mut devices, mut news) = (Devices::open(), Vec::new());
    wait(&mut devices, &mut news, |_, news| news.iter().any(|n| matches!(n, RigEvent::Connected(_))));
    assert!(devices.describe().ends_with("profile Rig 1, with force"), "{}", devices.describe());
    // A bend to the left; then an automation whose wheel is 0.5 rad to the right of this one, which rests.
    let bend = ForceInput { aligning_nm: 4.0, speed_mps: 10.0, running: true, ..ForceInput::default() };
    for (force_input, sign) in [(bend, 1.0), (ForceInput { held_rad: Some(-0.5), ..bend }, -1.0)] {
        let mut torque_nm = None;
        for _ in 0..100 {
            devices.poll();
            torque_nm = devices.take_torque_nm();
            devices.set_force_input(force_input);
            sleep(Duration::from_millis(10));
        }
        assert!(sign * torque_nm.unwrap() > 1.0, "{force_input:?}: {torque_nm:?}");
    }
}

#[test]
fn a_wheel_mouse_is_no_wheel_and_the_pad_beside_it_drives() {
    if std::env::var_os(WITHIN).is_none() {
        let config = tempfile::tempdir().unwrap();
        let text = doctor(&[(&mouse(), "")], config.path());
        assert!(text.contains("none is plugged in") && !text.contains("Mouse"), "{text}");
        let test = "other_devices::a_wheel_mouse_is_no_wheel_and_the_pad_beside_it_drives";
        let stick = movements(&[(2.0, 0, -20_000), (2.2, 0, -32_768)]);
        again_with(test, &[(&mouse(), ""), (&pad(), &stick)], config.path(), &[]);
        return;
    }
    let (mut devices, mut news) = (Devices::open(), Vec::new());
    wait(&mut devices, &mut news, |c: &Controls, _| c.steering_wheel_rad > 1.0);
    assert!(news.is_empty(), "{news:?}");
}

#[test]
fn calibrate_lists_devices_that_are_no_wheels_and_takes_one_by_its_id() {
    let config = tempfile::tempdir().unwrap();
    let axes = [(0, 32_768, WORD), (2, 0, WORD), (5, 0, WORD)];
    let plain = Device { pushes: false, ..Device::wheel("Home-made controller", (0x1209, 0x0001), &axes) };
    assert_eq!(plain.buttons.start, JOYSTICK);
    let output = run_with(&[(&mouse(), ""), (&plain, "")], config.path(), &[], codrive(), &["calibrate"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(
        text.contains("no steering wheel is plugged in") && text.contains("Home-made controller (1209:0001)"),
        "{text}"
    );
    assert!(text.contains("--device") && !text.contains("Mouse"), "{text}");
    let answers = responses([(2, 65_000), (2, 0), (5, 60_000), (5, 0)]);
    calibrate(&plain, config.path(), &answers, &["--device", "1209:0001"]);
    let text = doctor(&[(&plain, "")], config.path());
    assert!(text.contains("Home-made controller (1209:0001), profile Rig 1"), "an own profile's id decides: {text}");
    let output = run_with(&[(&plain, "")], config.path(), &[], codrive(), &["calibrate", "--device", "1:2"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("no device with axes has the id 1:2; there are: Home-made controller (1209:0001)"), "{text}");
}

#[test]
fn combined_pedals_are_calibrated_and_drive() {
    let combined = Device::wheel("Combined Racing Wheel", (0x1209, 0x0002), &[(0, 32_768, WORD), (1, 128, BYTE)]);
    if std::env::var_os(WITHIN).is_none() {
        let config = tempfile::tempdir().unwrap();
        let text = doctor(&[(&combined, "")], config.path());
        assert!(text.contains("rests in the middle") && text.contains("codrive calibrate"), "{text}");
        let text = calibrate(&combined, config.path(), &responses([(1, 2), (1, 128), (1, 253), (1, 128)]), &[]);
        assert!(text.contains("accelerator: axis 1, 128 released, 2 pressed"), "{text}");
        assert!(text.contains("brake: axis 1, 128 released, 253 pressed"), "{text}");
        let press = movements(&[(0.5, 1, 0), (1.5, 1, 255), (2.5, 1, 128), (2.6, 0, 0)]);
        again_with(
            "other_devices::combined_pedals_are_calibrated_and_drive",
            &[(&combined, &press)],
            config.path(),
            &[],
        );
        return;
    }
    let (mut devices, mut news) = (Devices::open(), Vec::new());
    wait(&mut devices, &mut news, |c, _| c.throttle == 1.0 && c.brake == 0.0);
    wait(&mut devices, &mut news, |c, _| c.throttle == 0.0 && c.brake == 1.0);
    wait(&mut devices, &mut news, |c, _| c.steering_wheel_rad > 1.0 && c.throttle == 0.0 && c.brake == 0.0);
}

#[test]
fn pedals_with_a_cable_of_their_own_are_calibrated_and_drive() {
    let base = Device::wheel("FANATEC Wheel", (0x0eb7, 0x0020), &[(0, 32_767, WORD)]);
    let range = [0, 4095];
    let pedals =
        Device::wheel("Fanatec ClubSport Pedals V3", (0x0eb7, 0x183b), &[(0, 0, range), (1, 0, range), (2, 0, range)]);
    let pedals = Device { pushes: false, ..pedals };
    if std::env::var_os(WITHIN).is_none() {
        let config = tempfile::tempdir().unwrap();
        let text = doctor(&[(&base, ""), (&pedals, "")], config.path());
        assert!(text.contains("fewer than two axes") && text.contains("codrive calibrate"), "{text}");
        // Three turns and four presses, each held for 2.5 s. umockdev plays the first event at once.
        let turns = movements(&[(0.0, 0, 32_700), (4.0, 0, 150), (6.5, 0, 65_400), (9.0, 0, 32_700)]);
        let presses = movements(&[(0.0, 2, 1), (11.5, 0, 4000), (14.0, 0, 0), (16.5, 1, 3000), (19.0, 1, 0)]);
        let arguments = ["60", codrive().to_str().unwrap(), "calibrate", "--name", "Rig 1"];
        let timeout = Path::new("/usr/bin/timeout");
        let output = run_with(&[(&pedals, &presses), (&base, &turns)], config.path(), &[], timeout, &arguments);
        let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(
            text.starts_with("FANATEC Wheel (0eb7:0020)\nwith Fanatec ClubSport Pedals V3 (0eb7:183b)\n"),
            "{text}"
        );
        assert!(text.contains("accelerator: axis 0 of 0eb7:183b, 0 released, 4000 pressed"), "{text}");
        assert!(text.contains("brake: axis 1 of 0eb7:183b, 0 released, 3000 pressed"), "{text}");
        let text = doctor(&[(&pedals, ""), (&base, "")], config.path());
        assert!(text.contains("FANATEC Wheel (0eb7:0020), profile Rig 1"), "{text}");
        let text = doctor(&[(&base, "")], config.path());
        assert!(text.contains("the device of the accelerator, 0eb7:183b, is not plugged in"), "{text}");
        let test = "other_devices::pedals_with_a_cable_of_their_own_are_calibrated_and_drive";
        let press = movements(&[(0.5, 0, 100), (0.6, 0, 2000), (0.7, 0, 4095)]);
        let turn = movements(&[(2.0, 0, 150)]);
        again_with(test, &[(&base, &turn), (&pedals, &press)], config.path(), &[]);
        return;
    }
    let (mut devices, mut news) = (Devices::open(), Vec::new());
    wait(&mut devices, &mut news, |c, _| c.throttle == 1.0 && c.steering_wheel_rad > 1.0);
    assert_eq!(devices.controls(5.0, None).brake, 0.0);
    assert_eq!(devices.wheel_profile().map(|p| p.name.as_str()), Some("Rig 1"));
}

/// Lever of a home-made board: one axis and the id that all boards of its kind have, at this port.
fn lever(port: &'static str) -> Device {
    let lever = Device::wheel("Arduino Leonardo", (0x2341, 0x8036), &[(0, 20, [0, 1023])]);
    Device { pushes: false, port, ..lever }
}

const PORTS: [&str; 2] = ["usb-0000:00:14.0-3/input0", "usb-0000:00:14.0-4/input0"];

#[test]
fn two_levers_of_one_id_are_told_apart_by_port_as_brake_and_handbrake() {
    let [brake, handbrake] = PORTS.map(lever);
    let axes = [(0, 32_767, WORD), (2, 0, [0, 4095])];
    let base = Device::wheel("FANATEC Wheel", (0x0eb7, 0x0020), &axes);
    if std::env::var_os(WITHIN).is_none() {
        let config = tempfile::tempdir().unwrap();
        // Three turns, then each pedal pressed and released, each held for 2.5 s.
        let turns =
            [(0.0, 0, 32_700), (4.0, 0, 150), (6.5, 0, 65_400), (9.0, 0, 32_700), (11.5, 2, 4000), (14.0, 2, 0)];
        let pull = |from_s: f64| movements(&[(0.0, 0, 21), (from_s, 0, 1000), (from_s + 2.5, 0, 20)]);
        let arguments = ["60", codrive().to_str().unwrap(), "calibrate", "--name", "Rig 1"];
        let devices = [(&base, &movements(&turns)[..]), (&handbrake, &pull(21.5)), (&brake, &pull(16.5))];
        let output = run_with(&devices, config.path(), &[], Path::new("/usr/bin/timeout"), &arguments);
        let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        let [brake_port, handbrake_port] = PORTS;
        assert!(text.contains(&format!("\nwith Arduino Leonardo (2341:8036 at {brake_port})\n")), "{text}");
        assert!(text.contains(&format!("\nbrake: axis 0 of 2341:8036 at {brake_port}, 21 released")), "{text}");
        assert!(text.contains(&format!("\nhandbrake: axis 0 of 2341:8036 at {handbrake_port}, 21 released")), "{text}");
        let text = doctor(&[(&base, ""), (&brake, "")], config.path());
        let missing = format!("the device of the handbrake, 2341:8036 at {handbrake_port}, is not plugged in");
        assert!(text.contains(&missing), "{text}");
        let test = "other_devices::two_levers_of_one_id_are_told_apart_by_port_as_brake_and_handbrake";
        // The order of the devices is another one now. First the brake is pulled a little, then the handbrake to its end.
        let little = movements(&[(0.5, 0, 300), (3.0, 0, 20), (4.0, 0, 21)]);
        let fully = movements(&[(0.0, 0, 21), (6.0, 0, 1000)]);
        again_with(test, &[(&brake, &little), (&handbrake, &fully), (&base, "")], config.path(), &[]);
        return;
    }
    let (mut devices, mut news) = (Devices::open(), Vec::new());
    wait(&mut devices, &mut news, |c, _| c.brake > 0.05 && c.brake < 0.4);
    wait(&mut devices, &mut news, |c, _| c.brake == 0.0);
    wait(&mut devices, &mut news, |c, _| c.brake == 1.0);
}

#[test]
fn two_devices_of_one_id_are_refused_if_the_profile_does_not_say_which() {
    let [one, two] = PORTS.map(lever);
    let base = Device::wheel("FANATEC Wheel", (0x0eb7, 0x0020), &[(0, 32_767, WORD), (2, 0, BYTE)]);
    let config = tempfile::tempdir().unwrap();
    let mut profile = profiles::named("g29").unwrap();
    (profile.name, profile.products) = ("Rig 1".into(), vec!["0eb7:0020".into()]);
    let brake = profile.brake.as_mut().unwrap();
    (brake.device, brake.axis, brake.released, brake.pressed) = (Some("2341:8036".into()), 0, 0, 1023);
    let folder = config.path().join("codrive/wheels");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("rig-1.toml"), profile.to_toml()).unwrap();
    let text = doctor(&[(&base, ""), (&one, "")], config.path());
    assert!(text.contains("FANATEC Wheel (0eb7:0020), profile Rig 1"), "{text}");
    let text = doctor(&[(&base, ""), (&one, ""), (&two, "")], config.path());
    assert!(text.contains("the device of the brake, 2341:8036, is plugged in twice"), "{text}");
}

#[test]
fn buttons_of_a_shifter_and_of_the_wheel_do_what_the_profile_says() {
    let base = turned_round(32_767);
    let base =
        Device { axes: base.axes.iter().map(|(code, raw, range)| (*code, 255.max(*raw), *range)).collect(), ..base };
    let shifter = Device { pushes: false, ..Device::wheel("TH8A Shifter", (0x044f, 0xb660), &[]) };
    if std::env::var_os(WITHIN).is_none() {
        let config = tempfile::tempdir().unwrap();
        let mut profile = profiles::named("g923").unwrap();
        (profile.name, profile.products) = ("Rig 1".into(), vec!["046d:c266".into()]);
        let button = |number| codrive::input::RigButton { device: Some("044f:b660".into()), ..u16::into(number) };
        (profile.buttons.reverse, profile.buttons.handbrake) = (vec![button(289)], vec![button(293)]);
        let folder = config.path().join("codrive/wheels");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("rig-1.toml"), profile.to_toml()).unwrap();
        let test = "other_devices::buttons_of_a_shifter_and_of_the_wheel_do_what_the_profile_says";
        // Button 289 is the wheel's horn and the shifter's reverse.
        let of_wheel = presses(&[(1.0, 289, 1), (4.0, 289, 0)]);
        let of_shifter = presses(&[(0.0, 290, 1), (6.0, 289, 1), (6.5, 289, 0), (7.0, 293, 1), (10.0, 293, 0)]);
        again_with(test, &[(&shifter, &of_shifter), (&base, &of_wheel)], config.path(), &[]);
        return;
    }
    let (mut devices, mut news) = (Devices::open(), Vec::new());
    let pressed = |news: &[RigEvent], action| news.contains(&RigEvent::Pressed(action));
    wait(&mut devices, &mut news, |_, news| pressed(news, ButtonAction::Horn));
    assert!(devices.horn() && !pressed(&news, ButtonAction::Reverse), "{news:?}");
    wait(&mut devices, &mut news, |c, _| c.selector == Selector::Reverse);
    wait(&mut devices, &mut news, |c, _| c.brake == 1.0);
    wait(&mut devices, &mut news, |c, _| c.brake == 0.0);
    let count = news.iter().filter(|news| **news == RigEvent::Pressed(ButtonAction::Horn)).count();
    assert_eq!(count, 1, "{news:?}");
}
