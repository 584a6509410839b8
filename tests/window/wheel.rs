//! Test of a drive in its window with a G29 by umockdev (`tests/g29/`), whose steering and pedals are evdev events. umockdev accepts no
//! uploaded force. Force therefore goes through a library that replaces SDL2 and logs its calls (`tests/wheel/haptic.c`). The log shows
//! what the program would have sent to the motor.

use crate::{
    keys::SPACE,
    xserver::{Server, wait_for},
};
use codrive::{
    input::{profile::ForceBackend, profiles},
    record::{Table, TableReader},
};
use std::{
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

/// Events before the drive begins: the steering wheel turns 50 degrees to the left and the accelerator is pressed.
const HELD: &str = "E: 0.1 0003 0002 100\nE: 0.1 0000 0000 0\nE: 0.2 0003 0000 29100\nE: 0.2 0000 0000 0\n";
/// Steering wheel angle at that value, radians: (32767 - 29100) / 32767 of 450 degrees.
const HELD_RAD: f64 = 3667.0 / 32_767.0 * 450.0 * std::f64::consts::PI / 180.0;

/// Folder of a drive with the wheel.
struct Rig {
    folder: tempfile::TempDir,
}

impl Rig {
    fn new() -> Self {
        let rig = Self { folder: tempfile::tempdir().unwrap() };
        let mut profile = profiles::named("g29").unwrap();
        profile.force.backend = ForceBackend::Sdl;
        fs::write(rig.file("rig.toml"), profile.to_toml()).unwrap();
        fs::write(rig.file("events"), HELD).unwrap();
        let cc = Command::new("cc")
            .args(["-shared", "-fPIC", "-o"])
            .args([rig.file("libSDL2.so"), root().join("tests/wheel/haptic.c")])
            .output();
        let built = cc.expect("a C compiler (cc) is needed: scripts/setup installs it");
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        rig
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Starts the program in its window, paused until Space.
    fn drive(&self, server: &Server) -> Child {
        let device = root().join("tests/g29");
        let node = |what: &Path| format!("/dev/input/event0={}", what.display());
        Command::new("umockdev-run")
            .arg("--device")
            .arg(device.join("wheel.umockdev"))
            .args(["--ioctl", &node(&device.join("wheel.ioctl")), "--evemu-events", &node(&self.file("events")), "--"])
            .arg(env!("CARGO_BIN_EXE_codrive"))
            .args(["drive", "--paused", "--quality", "low", "--trees", "0", "--duration", "0", "--traffic", "native"])
            .args(["--vehicles", "6", "--policy", "none", "--warm-up", "5", "--wheel"])
            .arg(self.file("rig.toml"))
            .arg("--out")
            .arg(self.file("drive"))
            .env("DISPLAY", &server.display)
            .env("CODRIVE_SDL2", self.file("libSDL2.so"))
            .env("HAPTIC_LOG", self.file("asked"))
            .env("XDG_CONFIG_HOME", self.folder.path())
            .env_remove("WAYLAND_DISPLAY")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("umockdev-run is needed: scripts/setup --test installs it")
    }

    /// Returns the logged calls of SDL2.
    fn asked(&self) -> Vec<String> {
        let text = fs::read_to_string(self.file("asked")).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }

    /// Returns the levels of the constant-force effect, in order. SDL2's levels are positive to the left.
    fn levels(&self) -> Vec<i16> {
        let level = |line: &String| {
            let hex = line.strip_prefix("update 3 ")?;
            let byte = |at: usize| u8::from_str_radix(&hex[2 * at..2 * at + 2], 16).ok();
            Some(i16::from_le_bytes([byte(30)?, byte(31)?]))
        };
        self.asked().iter().filter_map(level).collect()
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_wheel_pushes_only_while_the_drive_runs() {
    let (server, rig) = (Server::start([640, 400]), Rig::new());
    let program = rig.drive(&server);
    let window = server.window("codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    sleep(Duration::from_secs(1));
    assert!(rig.levels().iter().all(|level| *level == 0), "a push before the drive began: {:?}", rig.levels());

    // Held to the left, the wheel is pushed to the right only. The recording has one force per tick, and on a busy machine a picture lasts
    // many ticks. More than ten pushes are therefore sure to be in the recording.
    let pushes = |from: usize| (rig.levels()[from..].iter().filter(|level| **level < -1000).count() > 10).then_some(());
    server.strike(window, &[SPACE]);
    wait_for("pushes", || pushes(0));
    assert!(rig.levels().iter().all(|level| *level <= 0), "a push to the left: {:?}", rig.levels());

    server.strike(window, &[SPACE]);
    // A moment without calls may also be a lost frame, so a pause is more than ten looks without a new call.
    let (mut count, mut looks) = (0, 0);
    wait_for("no force in the pause", || {
        let now = rig.asked().len();
        looks = if now == count { looks + 1 } else { 0 };
        count = now;
        (looks > 10 && rig.levels().last() == Some(&0)).then_some(())
    });
    let before = rig.levels().len();
    sleep(Duration::from_secs(1));
    assert_eq!(rig.levels().len(), before, "a push in the pause: {:?}", rig.levels());

    server.strike(window, &[SPACE]);
    wait_for("pushes again", || pushes(before));
    server.close(window);
    let output = program.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(output.status.success() && text.contains("with force"), "{text}");

    // At the end there is no force, and the device is closed.
    let asked = rig.asked();
    let stop = asked.iter().rposition(|line| line == "stop 3").unwrap_or_else(|| panic!("{asked:?}"));
    assert_eq!(rig.levels().last(), Some(&0));
    assert!(!asked[stop..].iter().any(|line| line.starts_with("update") || line.starts_with("run")), "{asked:?}");
    assert!(asked[stop..].iter().any(|line| line == "close haptic"), "{asked:?}");

    // The recording has the wheel, its angle and its force.
    let recording = rig.file("drive");
    let events = TableReader::parquet(&Table::Events.parquet(&recording)).unwrap().words("event");
    assert!(events.iter().any(|event| event == "wheel profile"), "{events:?}");
    let ego = TableReader::parquet(&Table::Ego.parquet(&recording)).unwrap();
    let [steering, throttle, force] =
        ["steering_wheel_rad", "throttle", "wheel_force_nm"].map(|name| ego.numbers(name));
    assert!(steering.iter().all(|rad| (rad.unwrap() - HELD_RAD).abs() < 0.01), "{:?} {HELD_RAD}", steering[0]);
    assert!(throttle.iter().all(|share| share.unwrap() > 0.5), "{:?}", throttle[0]);
    let forces: Vec<f64> = force.into_iter().flatten().collect();
    // If pictures come more than 84 ms apart, the force fades out before the next one, and the mean between them is small.
    assert!(forces.iter().all(|nm| *nm <= 0.0) && forces.iter().any(|nm| *nm < 0.0), "{forces:?}");
}
