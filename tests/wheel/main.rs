//! Tests with a G29 by umockdev (`tests/g29/`): its ids, axes, ranges and force bits as the kernel reports them, and replayed events.
//! umockdev cannot unplug a wheel while it is open, stamp events with the monotonic clock, or accept an uploaded force. Test ports and
//! devices in `src/input/` cover these, as do `uinput.rs` and `usb.rs` with a real kernel.
#![cfg(target_os = "linux")]

mod described;
mod haptic;
mod kernel;
mod other_devices;
mod uinput;
mod usb;

use codrive::{
    controls::Controls,
    input::{ButtonAction, Devices, RigEvent, WheelProfile, profiles},
};
use std::{
    fs,
    path::Path,
    process::{Command, Output},
    thread::sleep,
    time::Duration,
};

/// Environment variable that is set for the process within umockdev.
const WITHIN: &str = "CODRIVE_TEST_WITHIN_UMOCKDEV";

/// Runs a program with a virtual G29 of this product id, and with events.
fn with_wheel(product: &str, events: Option<&str>, program: &Path, arguments: &[&str]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/g29");
    let file = |name: &str| folder.path().join(name);
    let device = fs::read_to_string(here.join("wheel.umockdev")).unwrap().replace("c24f", product);
    fs::write(file("device"), device).unwrap();
    fs::write(file("events"), events.unwrap_or_default()).unwrap();
    let node = |what: &Path| format!("/dev/input/event0={}", what.display());
    let mut command = umockdev();
    command.arg("--device").arg(file("device")).arg("--ioctl").arg(node(&here.join("wheel.ioctl")));
    if events.is_some() {
        command.arg("--evemu-events").arg(node(&file("events")));
    }
    command.env(WITHIN, "1").env("XDG_CONFIG_HOME", folder.path()).env("RUST_LOG", "error");
    command.arg("--").arg(program).args(arguments).output().expect(UMOCKDEV)
}

const UMOCKDEV: &str =
    "umockdev-run is needed; scripts/setup --test installs it (Debian, Ubuntu: apt install umockdev)";

/// Returns a command with its own /sys and /dev, with no device plugged in yet.
fn umockdev() -> Command {
    Command::new("umockdev-run")
}

fn codrive() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_codrive"))
}

/// Runs one test of this program within umockdev and asserts its success.
fn again_within(test: &str, events: Option<&str>) {
    again(test, |this, arguments| with_wheel("c24f", events, this, arguments));
}

/// Runs a test of this program again by `run`, and requires that this one test was run and passed.
fn again(test: &str, run: impl FnOnce(&Path, &[&str]) -> Output) {
    let output = run(&std::env::current_exe().unwrap(), &["--exact", test, "--nocapture"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && text.contains("1 passed"), "{text}");
}

/// Polls until `what` holds, for up to 60 s: a slow machine is no failure.
fn wait(devices: &mut Devices, news: &mut Vec<RigEvent>, what: impl Fn(&Controls, &[RigEvent]) -> bool) {
    for _ in 0..12_000 {
        news.extend(devices.poll());
        if what(&devices.controls(5.0, None), news) {
            return;
        }
        sleep(Duration::from_millis(5));
    }
    panic!("it did not come within 60 s: {:?}, {news:?}", devices.controls(5.0, None));
}

#[test]
fn a_g29_drives_unasked() {
    if std::env::var_os(WITHIN).is_none() {
        again_within("a_g29_drives_unasked", Some(include_str!("../g29/drive.events")));
        return;
    }
    let mut devices = Devices::open();
    let mut news = Vec::new();
    assert_eq!(devices.controls(5.0, None), Controls::default(), "nothing acts before it is known");
    wait(&mut devices, &mut news, |c, _| c.steering_wheel_rad < 0.0 && c.throttle > 0.5 && c.brake == 1.0);
    assert!(news.iter().any(|n| matches!(n, RigEvent::Connected(name) if name.contains("G29"))), "{news:?}");
    assert!(news.contains(&RigEvent::Pressed(ButtonAction::Answer)), "{news:?}");
    assert_eq!(devices.wheel_profile().map(|p| p.name.as_str()), Some("Logitech G29"));
    // (40000 - 32767) / 32768 of 450 degrees to the right.
    let angle = devices.controls(5.0, None).steering_wheel_rad.to_degrees();
    assert!((angle + 99.33).abs() < 0.05, "{angle}");
    // umockdev accepts no uploaded effect. That is reported once, and the wheel still steers.
    let trouble_count =
        news.iter().filter(|n| matches!(n, RigEvent::Trouble(text) if text.contains("gives no force"))).count();
    assert_eq!(trouble_count, 1, "{news:?}");
    assert!(devices.describe().contains("without force"));
    // umockdev's events have the times of their file, which are no latencies.
    assert_eq!(devices.newest_input(), None);
}

#[test]
fn a_g29_at_rest_stays_at_rest_without_any_event() {
    if std::env::var_os(WITHIN).is_none() {
        again_within("a_g29_at_rest_stays_at_rest_without_any_event", None);
        return;
    }
    let mut devices = Devices::open();
    let mut news = Vec::new();
    wait(&mut devices, &mut news, |_, news| news.iter().any(|n| matches!(n, RigEvent::Connected(_))));
    for _ in 0..50 {
        devices.poll();
        assert_eq!(devices.controls(5.0, None), Controls::default());
        sleep(Duration::from_millis(2));
    }
}

#[test]
fn the_d_pad_of_a_g29_is_heard_as_its_hat_tells_it_and_drives_nothing() {
    if std::env::var_os(WITHIN).is_none() {
        // Up, release, left, release, then the cross button: ABS_HAT0X is 0010, ABS_HAT0Y is 0011.
        let events = "E: 0.1 0003 0011 -1\nE: 0.1 0000 0000 0\nE: 0.2 0003 0011 0\nE: 0.2 0000 0000 0\n\
                      E: 0.3 0003 0010 -1\nE: 0.3 0000 0000 0\nE: 0.4 0003 0010 0\nE: 0.4 0000 0000 0\n\
                      E: 0.5 0001 0120 1\nE: 0.5 0000 0000 0\n";
        again_within("the_d_pad_of_a_g29_is_heard_as_its_hat_tells_it_and_drives_nothing", Some(events));
        return;
    }
    let mut devices = Devices::open();
    let mut news = Vec::new();
    let answered = RigEvent::Pressed(ButtonAction::Answer);
    wait(&mut devices, &mut news, |_, news| news.contains(&answered));
    let pressed: Vec<&RigEvent> = news.iter().filter(|n| matches!(n, RigEvent::Pressed(_))).collect();
    assert_eq!(pressed, [&RigEvent::Pressed(ButtonAction::Up), &RigEvent::Pressed(ButtonAction::Left), &answered]);
    assert_eq!(devices.controls(5.0, None), Controls::default());
}

#[test]
fn a_horn_that_came_up_while_the_kernels_queue_ran_over_is_heard() {
    if std::env::var_os(WITHIN).is_none() {
        // The horn is pressed. Then events are lost (SYN_DROPPED and the rest of a packet), including the release. Asked for the state of
        // the buttons, umockdev reports none as pressed. Another button is pressed to mark the end.
        let events = "E: 0.1 0001 0121 1\nE: 0.1 0000 0000 0\nE: 1.5 0000 0003 0\nE: 1.5 0003 0002 100\nE: 1.5 0000 0000 0\n\
                      E: 1.6 0001 0120 1\nE: 1.6 0000 0000 0\n";
        again_within("a_horn_that_came_up_while_the_kernels_queue_ran_over_is_heard", Some(events));
        return;
    }
    let mut devices = Devices::open();
    let mut heard = false;
    let mut news = Vec::new();
    for _ in 0..12_000 {
        news.extend(devices.poll());
        heard |= devices.horn();
        if news.contains(&RigEvent::Pressed(ButtonAction::Answer)) {
            break;
        }
        sleep(Duration::from_millis(5));
    }
    assert!(heard && news.contains(&RigEvent::Pressed(ButtonAction::Answer)), "{news:?}");
    assert!(!devices.horn(), "the horn sounds for ever");
    assert_eq!(devices.controls(5.0, None).throttle, 0.0, "half a packet is no input");
}

/// Returns the responses of a person at the wheel, as evemu events, each held for 1.5 s.
fn answers() -> String {
    let mut text = String::new();
    let mut at_s = 3.5;
    for (code, raw) in [(0, 150), (0, 65_400), (0, 32_700), (2, 3), (2, 255), (5, 90), (5, 255)] {
        text += &format!("E: {at_s:.6} 0003 {code:04x} {raw}\nE: {at_s:.6} 0000 0000 0\n");
        at_s += 1.5;
    }
    text
}

#[test]
fn calibrate_learns_a_g29_and_saves_what_a_drive_can_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rig.toml");
    let answered = folder.path().join("answers.events");
    fs::write(&answered, answers()).unwrap();
    let [out, replay] = [&file, &answered].map(|path| path.to_str().unwrap());
    let arguments = ["calibrate", "--name", "Rig 1", "--out", out, "--replay", replay];
    let output = with_wheel("c24f", None, codrive(), &arguments);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    for question in
        ["hands and feet off", "fully to the left", "fully to the right", "straight ahead", "emergency stop"]
    {
        assert!(text.contains(question), "{text}");
    }
    let profile: WheelProfile = profiles::load(&file).unwrap();
    let s = &profile.steering;
    assert_eq!((s.axis, s.left, s.centre, s.right), (0, 150, 32_700, 65_400));
    let brake = profile.brake.as_ref().unwrap();
    assert_eq!((profile.accelerator.axis, profile.accelerator.pressed, brake.axis, brake.pressed), (2, 3, 5, 90));
    assert!(profile.name == "Rig 1" && profile.is_for(0x046d, 0xc24f));
}

#[test]
fn calibrate_without_a_wheel_says_what_to_do() {
    // Within umockdev nothing is plugged in, whatever devices this machine has.
    let output = umockdev().arg("--").arg(codrive()).arg("calibrate").output().expect(UMOCKDEV);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("no steering wheel is plugged in\n  remedy: plug it in"), "{text}");
}

/// Runs the doctor; returns for each check name, grade, finding and remedy.
fn doctor(product: &str) -> Vec<(String, String, String, String)> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let arguments = ["doctor", "--json", "--size", "64x36", "--trees", "0", "--quality", "low", "--out", out];
    let output = with_wheel(product, None, codrive(), &arguments);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| {
        panic!("{e}: {}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
    });
    let worst = json["grade"].as_str().unwrap();
    assert_eq!(output.status.code(), Some(i32::from(worst == "fault")), "exit 1 on a fault, and only then");
    let checks = json["checks"].as_array().unwrap();
    let text = |line: &serde_json::Value, key: &str| line[key].as_str().unwrap_or_default().to_owned();
    checks.iter().map(|l| (text(l, "what"), text(l, "grade"), text(l, "found"), text(l, "remedy"))).collect()
}

#[test]
fn doctor_finds_the_wheel_and_its_force_and_leaves_nothing_out() {
    let checks = doctor("c24f");
    let of = |what: &str| checks.iter().find(|line| line.0 == what).unwrap_or_else(|| panic!("no line on {what}"));
    assert_eq!((of("wheel").1.as_str(), of("force").1.as_str()), ("ok", "ok"));
    assert!(of("force").2.contains("constant force yes, gain yes, autocentre yes, 16 effects"), "{:?}", of("force"));
    for what in ["graphics", "frame time", "SUMO", "sound", "disk speed", "disk space", "clock", "power"] {
        let (_, grade, found, remedy) = of(what);
        assert!(!found.is_empty() && (grade == "ok") == remedy.is_empty(), "{what}: {grade}, {found}, {remedy}");
    }
}

#[test]
fn doctor_tells_a_g29_at_the_ps4_switch_to_be_moved() {
    let checks = doctor("c260");
    let (_, grade, found, remedy) = checks.iter().find(|line| line.0 == "wheel").unwrap();
    assert!(grade == "fault" && found.contains("is at PS4") && remedy.contains("to PS3"), "{found}, {remedy}");
}
