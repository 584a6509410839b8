//! Tests of force through SDL2, against a library that logs its calls (`haptic.c`), and against the true SDL2 if it is installed.

use super::kernel::BEND;
use codrive::input::{
    force_thread::{ForceDevice, ForceLoop, ForceThread, SharedAngle},
    no_force::WheelWithoutForce,
    profiles,
    sdl_force::{self, SdlForce},
};
use std::{
    ffi::{CStr, c_char},
    path::{Path, PathBuf},
    process::Command,
    sync::Arc,
    thread::sleep,
    time::Duration,
};

const G29: (u16, u16) = (0x046d, 0xc24f);

/// Logging library, built anew for each test.
struct Recorder {
    path: PathBuf,
    library: Option<libloading::Library>,
    _folder: tempfile::TempDir,
}

impl Recorder {
    fn build(options: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("libSDL2.so");
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/wheel/haptic.c");
        let cc = Command::new("cc").args(["-shared", "-fPIC", "-o"]).args([&path, &source]).args(options).output();
        let built = cc.expect("no C compiler (cc)\n  remedy: scripts/setup, or apt install gcc");
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        // SAFETY: the library runs no code at load time.
        let library = Some(unsafe { libloading::Library::new(&path) }.unwrap());
        Self { path, library, _folder: folder }
    }

    fn taken(&self) -> Vec<String> {
        // SAFETY: the type is as in haptic.c, and the text is valid until the next call.
        let text = unsafe {
            let taken =
                self.library.as_ref().unwrap().get::<unsafe extern "C" fn() -> *const c_char>(b"taken\0").unwrap();
            CStr::from_ptr(taken()).to_string_lossy().into_owned()
        };
        text.lines().map(str::to_owned).collect()
    }

    fn set(&self, abilities: u32, motor: bool) {
        // SAFETY: the type is as in haptic.c.
        unsafe {
            let set = self.library.as_ref().unwrap().get::<unsafe extern "C" fn(u32, i32)>(b"set_abilities\0").unwrap();
            set(abilities, motor.into());
        }
    }

    fn open(&self) -> Result<SdlForce, WheelWithoutForce> {
        SdlForce::open_from(std::slice::from_ref(&self.path), G29, "Logitech G29", 0.5)
    }
}

/// Returns a constant effect of `SDL_haptic.h` as its 72 bytes: type 1, direction 3 (the steering axis), without end, with this level.
fn bytes(level: i16) -> String {
    let mut bytes = [0_u8; 72];
    bytes[0] = 1;
    bytes[4] = 3;
    bytes[20..24].copy_from_slice(&u32::MAX.to_le_bytes());
    bytes[30..32].copy_from_slice(&level.to_le_bytes());
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn sdl_gets_one_constant_effect_updated_in_place_and_stopped_at_the_end() {
    let recorder = Recorder::build(&[]);
    let mut force = recorder.open().unwrap();
    let begun = recorder.taken();
    let hints = ["hint SDL_NO_SIGNAL_HANDLERS 1", "hint SDL_JOYSTICK_THREAD 1", "ready", "init 1200"];
    assert_eq!(begun[..4], hints);
    // The second effect, without force, plays all the time.
    let [new, rest] = [3, 4].map(|id| format!("new {id} {}", bytes(0)));
    let made = [&new, &rest, "run 4 ffffffff", "run 3 ffffffff"];
    assert_eq!(begun[4..8], ["joystick 1", "haptic of 1", "gain 100", "autocentre 0"]);
    assert_eq!(begun[8..], made);
    // Right, left, and both extremes.
    for (level, sent) in [(21_760, -21_760), (-21_760, 21_760), (i16::MIN, 32_767), (i16::MAX, -32_767)] {
        force.set(level).unwrap();
        assert_eq!(recorder.taken(), [format!("update 3 {}", bytes(sent))]);
    }
    drop(force);
    let zero = format!("update 3 {}", bytes(0));
    let ended = recorder.taken();
    assert_eq!(ended[..5], [&zero, "stop 3", "autocentre 50", "destroy 3", "destroy 4"]);
    assert_eq!(ended[5..], ["close haptic", "close joystick 1", "quit 1200"]);
}

#[test]
fn a_wheel_without_strength_or_centring_is_asked_for_neither() {
    let recorder = Recorder::build(&[]);
    // SDL_haptic.h: constant force is bit 0, strength bit 12, centring bit 13.
    for (abilities, asked) in [(1, None), (1 | 1 << 12, Some("gain 100")), (1 | 1 << 13, Some("autocentre 0"))] {
        recorder.set(abilities, true);
        let force = recorder.open().unwrap();
        let state_updates = |what: &[&str]| {
            let all = recorder.taken();
            all.into_iter().filter(|line| what.iter().any(|what| line.starts_with(what))).collect::<Vec<_>>()
        };
        assert_eq!(state_updates(&["gain", "autocentre"]), Vec::from_iter(asked));
        drop(force);
        let at_the_end = (abilities & 1 << 13 != 0).then_some("autocentre 50");
        assert_eq!(state_updates(&["gain", "autocentre"]), Vec::from_iter(at_the_end));
    }
}

#[test]
fn a_wheel_with_room_for_one_effect_works_and_effect_ids_may_start_at_0() {
    let recorder = Recorder::build(&["-DROOM=1", "-DFIRST=0"]);
    let mut force = recorder.open().unwrap();
    assert_eq!(recorder.taken()[8..], [format!("new 0 {}", bytes(0)), "run 0 ffffffff".into()]);
    force.set(128).unwrap();
    assert_eq!(recorder.taken(), [format!("update 0 {}", bytes(-128))]);
    drop(force);
    assert_eq!(recorder.taken()[1..4], ["stop 0", "autocentre 50", "destroy 0"]);
    let two = Recorder::build(&["-DROOM=2", "-DFIRST=0"]);
    drop(two.open().unwrap());
    let ended = two.taken();
    assert!(["run 1 ffffffff", "destroy 1"].iter().all(|asked| ended.contains(&(*asked).to_owned())), "{ended:?}");
}

#[test]
fn a_wheel_that_takes_or_plays_no_effect_is_reported_and_closed() {
    for (option, why) in [("-DROOM=0", "SDL2 makes no constant force"), ("-DSTUCK", "SDL2 does not run the force")] {
        let recorder = Recorder::build(&[option]);
        let text = recorder.open().err().expect("no force").to_string();
        assert!(text.contains(&format!("({why}: the recorder says no)")), "{text}");
        let ended = recorder.taken();
        assert_eq!(ended[ended.len() - 3..], ["close haptic", "close joystick 1", "quit 1200"]);
    }
}

#[test]
fn the_force_thread_drives_sdl_like_a_wheel() {
    let recorder = Recorder::build(&[]);
    let profile = profiles::named("g29").unwrap();
    let force = ForceLoop::new(Box::new(recorder.open().unwrap()), &profile);
    recorder.taken();
    let thread = ForceThread::start(force, Arc::new(SharedAngle::default())).unwrap();
    let hold_bend = |times: usize| {
        for _ in 0..times {
            thread.set_input(BEND);
            sleep(Duration::from_millis(10));
        }
    };
    hold_bend(100);
    let sent = recorder.taken();
    // 1.4 of 2.1 N m to the left.
    assert_eq!(sent.last(), Some(&format!("update 3 {}", bytes(170 * 128))), "{sent:?}");
    assert!(sent.windows(2).all(|pair| pair[0] != pair[1] && pair[1].starts_with("update 3 ")), "{sent:?}");
    thread.take_torque_nm();
    hold_bend(30);
    assert_eq!(recorder.taken(), [""; 0], "unchanged is not sent");
    assert!((thread.take_torque_nm() - 1.4).abs() < 0.01);
    // No further input arrives.
    sleep(Duration::from_millis(200));
    assert_eq!(recorder.taken().last(), Some(&format!("update 3 {}", bytes(0))));
    drop(thread);
    let ended = recorder.taken();
    assert_eq!(ended[1..5], ["stop 3", "autocentre 50", "destroy 3", "destroy 4"]);
    assert_eq!(ended[5..], ["close haptic", "close joystick 1", "quit 1200"]);
}

#[test]
fn errors_of_sdl_name_their_remedy() {
    let text = |opened: Result<SdlForce, WheelWithoutForce>| opened.err().expect("no force").to_string();
    let nowhere = [PathBuf::from("/nowhere/libSDL2.so")];
    let missing = text(SdlForce::open_from(&nowhere, G29, "Logitech G29", 0.0));
    assert!(missing.starts_with("Logitech G29 gives no force (SDL2 cannot be used: /nowhere/libSDL2.so"), "{missing}");
    assert!(
        missing.contains("the drive continues without force\n  remedy: ") && missing.contains("CODRIVE_SDL2"),
        "{missing}"
    );

    let old = Recorder::build(&["-DLACKING"]);
    let lacking = text(old.open());
    assert!(lacking.contains("libSDL2.so has no SDL_HapticRunEffect"), "{lacking}");
    assert_eq!(old.taken(), [""; 0], "nothing of it was used");

    let recorder = Recorder::build(&[]);
    let other = text(SdlForce::open_from(std::slice::from_ref(&recorder.path), (0x046d, 0xc29b), "Logitech G27", 0.0));
    assert!(other.contains("SDL2 lists 2 joysticks, and none of them is 046d:c29b"), "{other}");
    assert_eq!(recorder.taken().last().map(String::as_str), Some("quit 1200"));
    recorder.set(1 << 12, true);
    assert!(text(recorder.open()).contains("its driver has no constant force"));
    assert_eq!(recorder.taken()[4..], ["joystick 1", "haptic of 1", "close haptic", "close joystick 1", "quit 1200"]);
    recorder.set(0, false);
    assert!(text(recorder.open()).contains("SDL2 finds no motor in it: the recorder says no"));
}

#[test]
fn the_true_sdl_reports_a_missing_wheel() {
    let id = (0x046d, 0xcfff);
    let text = SdlForce::open(id, "A wheel", 0.0).err().expect("there is no such wheel").to_string();
    assert!(text.contains("joysticks, and none of them is 046d:cfff"), "{text}\nscripts/setup --test installs SDL2");
    assert!(sdl_force::look().is_ok(), "doctor says the same");
    assert!(text.contains("the drive continues without force\n  remedy: "), "{text}");
}
