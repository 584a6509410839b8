//! Tests of drives and replays in their windows. A key pressed through X moves the car, the screen shows a picture, and closing a window or
//! Ctrl-C ends the program with exit code 0. Keys typed in the experimenter's window do not drive.

use crate::{
    keys::{BACKSPACE, CTRL, ESC, F1, F11, M, Q, SPACE, U, V, W},
    xserver::{Server, ended, wait_for},
};
use codrive::record::{Manifest, Table, TableReader};
use std::{
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

/// Size of the screen in most of these tests, pixels.
const SIZE: [u16; 2] = [640, 400];
const PIXELS: usize = 640 * 400;

/// Starts the program in a window on `server`.
fn drive(server: &Server, more: &[&str]) -> Child {
    let still = ["drive", "--quality", "low", "--duration", "0", "--creep", "false", "--policy", "constant"];
    let mut program = Command::new(env!("CARGO_BIN_EXE_codrive"));
    // Maps of the user's own would lengthen the lists of the panel.
    program.env("XDG_DATA_HOME", std::env::temp_dir().join("codrive-without-own-maps"));
    server.start_program(program.args(still).args(more))
}

/// Returns the window of this title, with the keyboard focus.
fn focused(server: &Server, title: &str) -> u32 {
    let window = server.window(title);
    server.focus(window);
    window
}

/// Returns the mean speed of the ego that the program prints at its end, m/s.
fn ego_speed_mps(text: &str) -> f64 {
    let line = text.lines().find(|line| line.starts_with("mean speed, ego")).unwrap_or_else(|| panic!("{text}"));
    line.split_whitespace().nth(3).and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{line}"))
}

#[test]
fn a_key_moves_the_car_and_closing_the_window_ends_with_0() {
    let server = Server::start(SIZE);
    let program = drive(&server, &[]);
    let window = focused(&server, "codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    let standing = server.screen();
    server.key(W, true);
    sleep(Duration::from_secs(3));
    server.key(W, false);
    let moved = wait_for("a moved picture", || {
        let now = server.screen();
        let differ = now.chunks(4).zip(standing.chunks(4)).filter(|(a, b)| a != b).count();
        (differ > PIXELS / 4).then_some(differ)
    });
    assert!(moved > 0);
    server.key(V, true);
    server.key(V, false);
    server.close(window);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("SUMO") && text.contains("driver keyboard"), "{text}");
    assert!(ego_speed_mps(&text) > 0.05, "{text}");
}

#[test]
fn closing_the_window_ends_its_recording_complete() {
    let server = Server::start(SIZE);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drive");
    let program = drive(&server, &["--traffic", "native", "--out", out.to_str().unwrap()]);
    let window = server.window("codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    // During the drive, rows are in the journal and not in tables.
    assert!(Manifest::load(&out).unwrap().ended.is_none() && !Table::Ego.parquet(&out).exists());
    sleep(Duration::from_secs(2));
    server.close(window);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains(&format!("recorded in              {}\n", out.display())), "{text}");
    let manifest = Manifest::load(&out).unwrap();
    assert!(manifest.is_complete() && manifest.screen.is_some(), "{manifest:?}");
    assert_eq!(manifest.ended.as_deref(), Some("stopped"));
    let ticks = TableReader::parquet(&Table::Ego.parquet(&out)).unwrap().wholes("tick");
    // The drive lasted 2 s; a processor that draws beside other tests may start late by most of that.
    assert!(ticks.len() > 50 && ticks.windows(2).all(|pair| pair[1] == pair[0] + 1), "{} ticks", ticks.len());
    let frames = TableReader::parquet(&Table::Frames.parquet(&out)).unwrap();
    assert!(frames.rows() > 0 && frames.numbers("wall_s").into_iter().flatten().is_sorted());
    assert!(codrive::record::changes(&out).unwrap().is_empty());
}

#[test]
fn a_task_in_its_own_window_moves_with_its_keys_and_ends_the_drive() {
    // Colour of the band.
    const BAND: [u8; 3] = [70, 84, 108];
    let server = Server::start([1300, 800]);
    let task = ["--traffic", "native", "--secondary-task", "kind=surrogate-reference,display=window"];
    let program = drive(&server, &task);
    server.window("codrive: ring-250");
    let window = server.window("codrive: secondary task");
    let [width, height] = server.size_of(window);
    // The band's uppermost row is above all circles.
    let band = || {
        let picture = server.picture(window);
        (0..height).find_map(|y| picture.stretches(y, BAND, width / 10).first().map(|stretch| stretch[0]))
    };
    // A key in this window starts the drive.
    server.focus(window);
    server.key(W, true);
    let at_first = wait_for("a display", band);
    server.key(W, false);
    server.strike(window, &[U]);
    let left = wait_for("a moved band", || band().filter(|left| *left < at_first));
    // One of six columns of a field that is at most as wide as the window.
    assert!((width / 12..=width / 6).contains(&(at_first - left)), "from {at_first} to {left} of {width}");
    server.close(window);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
}

#[test]
fn esc_ends_a_drive_but_not_one_with_an_experimenters_window() {
    let server = Server::start(SIZE);
    server.manage();
    let program = drive(&server, &["--traffic", "native"]);
    let window = server.window("codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    server.strike(window, &[ESC]);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");

    let program = drive(&server, &["--traffic", "native", "--experimenter"]);
    server.window("Experimenter");
    let window = server.window("codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    server.strike(window, &[ESC]);
    server.strike(window, &[F11]);
    assert!(
        wait_for("a word to the window manager", || server.asked_to_fill()),
        "it is still there, and heard the key"
    );
    // One keystroke is one command: releasing the key is not another.
    sleep(Duration::from_millis(700));
    assert_eq!(server.asked_to_fill(), None);
    server.close(window);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
}

#[test]
fn esc_closes_an_open_list_of_the_panel_and_then_the_drive() {
    // Place of the list of maps in the panel of a window of this size, and of the fill of its chosen map.
    const LIST: [u32; 2] = [1190, 669];
    const CHOSEN: [u32; 2] = [1250, 903];
    // Place in the panel beside that list.
    const BESIDE: [u32; 2] = [1060, 669];
    let server = Server::start([1300, 1020]);
    let program = drive(&server, &["--traffic", "native", "--panel", "--paused", "--trees", "0"]);
    let window = focused(&server, "codrive");
    // Where the processor draws, the window starts small.
    wait_for("the small window", || (server.size_of(window) == [640, 360]).then_some(()));
    server.resize(window, [1280, 1000]);
    let blue = || {
        let [r, _, b] = server.picture(window).at(CHOSEN[0], CHOSEN[1]);
        b > r.saturating_add(40)
    };
    wait_for("the large window with its panel", || {
        let picture = server.picture(window);
        let is_drawn = || picture.at(LIST[0], LIST[1]) != picture.at(BESIDE[0], BESIDE[1]);
        (picture.size == [1280, 1000] && is_drawn()).then_some(())
    });
    sleep(Duration::from_secs(2));
    assert!(!blue(), "no list hangs open");
    server.click(LIST);
    wait_for("the list of maps, 669 points below the top", || blue().then_some(()));
    server.strike(window, &[ESC]);
    wait_for("the list to close", || (!blue()).then_some(()));
    server.strike(window, &[ESC]);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
}

#[test]
fn a_window_that_loses_the_keyboard_releases_held_keys() {
    let server = Server::start(SIZE);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drive");
    let program = drive(&server, &["--traffic", "native", "--out", out.to_str().unwrap()]);
    let window = focused(&server, "codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    server.key(W, true);
    sleep(Duration::from_secs(2));
    server.unfocus();
    sleep(Duration::from_secs(2));
    server.close(window);
    let (code, text) = ended(program);
    server.key(W, false);
    assert_eq!(code, 0, "{text}");
    let throttle: Vec<f64> =
        TableReader::parquet(&Table::Ego.parquet(&out)).unwrap().numbers("throttle").into_iter().flatten().collect();
    assert!(throttle.iter().any(|way| *way > 0.1), "the key was held");
    assert_eq!(throttle.last(), Some(&0.0), "nobody holds a key of a window that hears none");
}

#[test]
fn repeated_stalls_are_reported_once() {
    let server = Server::start(SIZE);
    let still = ["drive", "--traffic", "native", "--quality", "low", "--duration", "0", "--policy", "constant"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    let program = server.start_program(command.args(still).env("RUST_LOG", "warn"));
    let window = server.window("codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    // A free drive waits for its driver.
    server.strike(window, &[SPACE]);
    // Simulates a machine that is busy for longer than frames can make up for.
    for signal in ["STOP", "CONT"].repeat(3) {
        let sent = Command::new("sh").args(["-c", &format!("kill -{signal} {}", program.id())]).status().unwrap();
        assert!(sent.success());
        sleep(Duration::from_millis(700));
    }
    server.close(window);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    assert_eq!(text.matches("a frame was late").count(), 1, "{text}");
}

#[test]
fn without_a_key_the_car_stands_and_ctrl_c_ends_with_0() {
    let server = Server::start(SIZE);
    let program = drive(&server, &["--traffic", "native"]);
    let window = server.window("codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    // A free drive waits for its driver.
    server.strike(window, &[SPACE]);
    sleep(Duration::from_secs(1));
    // The shell's built-in kill: a minimal Debian has no other.
    let sent = Command::new("sh").args(["-c", &format!("kill -INT {}", program.id())]).status().unwrap();
    assert!(sent.success());
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    assert_eq!(ego_speed_mps(&text), 0.0, "{text}");
}

#[test]
fn keys_in_the_experimenters_window_do_not_drive_but_set_marks() {
    let server = Server::start(SIZE);
    server.manage();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drive");
    let program = drive(&server, &["--traffic", "native", "--experimenter", "--out", out.to_str().unwrap()]);
    server.window("codrive");
    let experimenter = focused(&server, "Experimenter");
    wait_for("lamps, plots, settings", || (server.colours_of(experimenter) > 100).then_some(()));
    for keys in [&[W][..], &[CTRL, M]] {
        keys.iter().for_each(|key| server.key(*key, true));
        sleep(Duration::from_millis(700));
        keys.iter().rev().for_each(|key| server.key(*key, false));
    }
    server.strike(experimenter, &[F11]);
    assert!(wait_for("a word to the window manager", || server.asked_to_fill()));
    sleep(Duration::from_millis(500));
    server.close(experimenter);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    assert_eq!(ego_speed_mps(&text), 0.0, "{text}");
    let events = TableReader::parquet(&Table::Events.parquet(&out)).unwrap();
    let kinds = events.words("event");
    assert_eq!(kinds.iter().filter(|kind| *kind == "mark").count(), 1, "{kinds:?}");
}

#[test]
fn the_driver_drives_beside_the_experimenter_and_ctrl_q_ends_with_0() {
    let server = Server::start(SIZE);
    let program = drive(&server, &["--traffic", "native", "--experimenter"]);
    server.window("Experimenter");
    let window = focused(&server, "codrive");
    // The processor draws both windows, beside other tests: one second of the drive takes many seconds.
    server.key(W, true);
    sleep(Duration::from_secs(8));
    server.key(W, false);
    server.strike(window, &[CTRL, Q]);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    assert!(ego_speed_mps(&text) > 0.05, "{text}");
}

#[test]
fn a_recording_plays_in_a_window_with_keys_and_is_proven_meanwhile() {
    let server = Server::start(SIZE);
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("drive");
    let drive = drive.to_str().unwrap();
    let codrive = || Command::new(env!("CARGO_BIN_EXE_codrive"));
    let run = ["run", "--traffic", "native", "--duration", "6", "--quality", "low", "--out", drive];
    assert!(codrive().args(run).stdout(Stdio::null()).status().unwrap().success());
    let program = server.start_program(codrive().args(["replay", drive, "--window", "--at", "3"]));
    let window = focused(&server, "codrive replay");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    // Space pauses the replay or, if it is over already, restarts it; V shows the chase view.
    let before = server.screen();
    for key in [SPACE, V] {
        server.key(key, true);
        server.key(key, false);
    }
    wait_for("another view", || {
        let now = server.screen();
        (now.chunks(4).zip(before.chunks(4)).filter(|(a, b)| a != b).count() > PIXELS / 4).then_some(())
    });
    // The list of keys covers most of the picture with its dark panel. Esc closes it, and Ctrl+Q ends the program.
    let dark = || server.screen().chunks(4).filter(|pixel| pixel[..3].iter().all(|v| *v < 40)).count();
    let usual = dark();
    server.strike(window, &[F1]);
    wait_for("the list of keys", || (dark() > usual + PIXELS / 8).then_some(()));
    server.strike(window, &[ESC]);
    wait_for("the picture again", || (dark() < usual + PIXELS / 16).then_some(()));
    server.strike(window, &[CTRL, Q]);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("all 600 ticks are the same to the bit"), "{text}");
}

#[test]
fn a_full_disk_stops_the_drive_and_is_the_reason_in_the_recording() {
    let server = Server::start(SIZE);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drive");
    // A limit on file sizes simulates a full disk: 200 blocks of 512 bytes, which the journal reaches within seconds.
    let mut command = Command::new("sh");
    command
        .args(["-c", "trap '' XFSZ; ulimit -f 200; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_codrive")])
        .args(["drive", "--traffic", "native", "--quality", "low", "--duration", "0", "--policy", "constant", "--out"])
        .arg(&out)
        .env("MESA_SHADER_CACHE_DISABLE", "true");
    let program = server.start_program(&mut command);
    let window = focused(&server, "codrive");
    let ended_as = || Manifest::load(&out).ok().and_then(|manifest| manifest.ended);
    let reason = wait_for("the end of the recording", ended_as);
    assert!(reason.starts_with("recording failed: File too large"), "{reason}");
    // The picture does not move, even after Space.
    sleep(Duration::from_millis(500));
    let standing = server.screen();
    server.key(SPACE, true);
    server.key(SPACE, false);
    sleep(Duration::from_secs(1));
    let differ = server.screen().chunks(4).zip(standing.chunks(4)).filter(|(a, b)| a != b).count();
    assert!(differ < PIXELS / 50, "{differ} pixels moved");
    server.close(window);
    let (code, text) = ended(program);
    assert_eq!(code, 1, "{text}");
    assert!(text.contains(out.to_str().unwrap()) && text.contains("make room on the disk"), "{text}");
    codrive::record::recover(&out).unwrap();
    assert_eq!(ended_as().unwrap(), reason);
    assert!(TableReader::parquet(&Table::Ego.parquet(&out)).unwrap().rows() > 100);
}

#[test]
fn every_drive_of_a_window_is_recorded_and_the_summary_names_its_drive() {
    let server = Server::start(SIZE);
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let program = drive(&server, &["--traffic", "native", "--trees", "0", "--out", out("d1").to_str().unwrap()]);
    focused(&server, "codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    let press = |key| {
        server.key(key, true);
        server.key(key, false);
    };
    for name in ["d1-2", "d1-3"] {
        sleep(Duration::from_secs(1));
        press(BACKSPACE);
        wait_for(name, || out(name).join("manifest.json").exists().then_some(()));
    }
    sleep(Duration::from_secs(1));
    press(ESC);
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    for (k, name) in ["d1", "d1-2", "d1-3"].into_iter().enumerate() {
        assert_eq!(Manifest::load(&out(name)).unwrap().ended.as_deref(), Some("stopped"), "{name}");
        let ticks = TableReader::parquet(&Table::Ego.parquet(&out(name))).unwrap().wholes("tick");
        assert!(ticks[0] == 1 && ticks.len() > 20, "{name} begins anew: {} rows from {}", ticks.len(), ticks[0]);
        let head = format!("drive {} of 3", k + 1);
        let line = text.lines().find(|line| line.starts_with(&head)).unwrap_or_else(|| panic!("{text}"));
        assert!(line.ends_with(out(name).to_str().unwrap()) && line.contains("below") == (k == 2), "{text}");
    }
}
