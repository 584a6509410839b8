//! Tests of monitors and the check screen on a real X server (Xvfb), whose one monitor is its screen.

use crate::{
    keys::{CTRL, ESC, Q},
    xserver::{Server, wait_for},
};
use std::process::{Command, Output, Stdio};

fn codrive(server: &Server, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env("DISPLAY", &server.display).env_remove("WAYLAND_DISPLAY").env("RUST_LOG", "error");
    command
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

#[test]
fn an_unknown_monitor_or_rate_is_refused_with_the_available_ones() {
    let server = Server::start([640, 400]);
    let small = ["drive", "--traffic", "native", "--trees", "0", "--quality", "low"];
    for (more, parts) in [
        (&["--monitor", "2"][..], ["there is no monitor 2; there are 1: screen, 640x400", "codrive doctor lists them"]),
        (&["--fullscreen", "--refresh", "37"], ["no mode of the monitor has 37 Hz", "1: screen, 640x400"]),
        (&["--refresh", "60"], ["--refresh needs --fullscreen", "a window cannot set the refresh rate of its screen"]),
    ] {
        let output = codrive(&server, &[&small[..], more].concat()).output().unwrap();
        let printed = text(&output);
        assert!(
            output.status.code() == Some(2) && parts.iter().all(|part| printed.contains(part)),
            "{more:?}: {printed}"
        );
    }
}

#[test]
fn on_a_single_monitor_the_picture_leaves_the_experimenter_visible() {
    let server = Server::start([800, 600]);
    server.manage();
    let drive = ["drive", "--traffic", "native", "--trees", "0", "--quality", "low", "--fullscreen", "--experimenter"];
    let mut program = codrive(&server, &drive);
    let program = program.env("RUST_LOG", "warn").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    server.window("codrive: ring-250");
    let experimenter = server.window("Experimenter");
    wait_for("lamps, plots, settings", || (server.colours_of(experimenter) > 100).then_some(()));
    server.strike(experimenter, &[CTRL, Q]);
    let output = program.wait_with_output().unwrap();
    let printed = text(&output);
    assert!(
        output.status.success() && printed.contains("there is only one monitor: the participant's window"),
        "{printed}"
    );
    assert_eq!(server.asked_to_fill(), None);
}

#[test]
fn the_check_screen_shows_its_ruler_until_escape() {
    let server = Server::start([900, 700]);
    let program = codrive(&server, &["doctor", "--display"]);
    let program = { program }.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let window = server.window("codrive: display");
    wait_for("lines and letters", || (server.colours_of(window) > 20).then_some(()));
    server.strike(window, &[ESC]);
    let output = program.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
}

#[test]
fn the_ruler_has_its_set_length_and_the_circle_is_round() {
    let server = Server::start([1000, 700]);
    // The window is 0.9 m wide. The ruler takes nine tenths of that in whole decimetres, 0.8 m; the circle takes half of the height.
    let program = codrive(&server, &["doctor", "--display", "--screen-width", "0.9"]);
    let program = { program }.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let window = server.window("codrive: display");
    wait_for("lines and letters", || (server.colours_of(window) > 20).then_some(()));
    let picture = server.picture(window);
    let [width, height] = picture.size;
    let ruler_px = 0.8 / 0.9 * width as f32;
    // The ruler lies at 16 % of the height; nothing else is as long.
    let line = (0..height / 3).find_map(|y| {
        let row: Vec<u32> = (0..width).filter(|x| picture.at(*x, y).iter().all(|v| *v > 120)).collect();
        (row.len() as f32 > 0.8 * ruler_px).then(|| (y, row[0], row[row.len() - 1]))
    });
    let (y, left, right) = line.unwrap_or_else(|| panic!("no ruler in {width} by {height} pixels"));
    assert!((y as f32 / height as f32 - 0.16).abs() < 0.01, "row {y} of {height}");
    assert!(((right - left) as f32 - ruler_px).abs() < 3.0, "{left} to {right}, not {ruler_px} pixels");
    // Only the circle is green. Its diameter is half the picture's height in whole decimetres; the height follows from 0.9 m and the shape.
    let green = |x: u32, y: u32| {
        let [r, g, b] = picture.at(x, y).map(i32::from);
        g > 120 && g > r + 40 && g > b + 20
    };
    let all: Vec<[u32; 2]> =
        (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).filter(|[x, y]| green(*x, *y)).collect();
    let span = |i: usize| all.iter().map(|p| p[i]).max().unwrap() - all.iter().map(|p| p[i]).min().unwrap() + 1;
    let half_m = 0.5 * 0.9 * height as f32 / width as f32;
    let circle_px = (half_m * 10.0).floor() / 10.0 / 0.9 * width as f32;
    assert!(span(0).abs_diff(span(1)) <= 2, "{} by {} pixels", span(0), span(1));
    // The nominal diameter is at the centre of a line of 2 pixels, whose edges may each cover one more pixel.
    assert!((span(0) as f32 - circle_px - 2.0).abs() < 3.0, "{} pixels, not {circle_px}", span(0));
    server.close(window);
    let output = program.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
}

#[test]
fn a_recorded_drive_names_its_screen_and_the_doctor_lists_it() {
    let server = Server::start([800, 600]);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drive");
    let drive = ["drive", "--traffic", "native", "--trees", "0", "--quality", "low", "--monitor", "1", "--out"];
    let program = codrive(&server, &[&drive[..], &[out.to_str().unwrap()]].concat()).spawn().unwrap();
    let window = server.window("codrive");
    wait_for("the manifest", || codrive::record::Manifest::load(&out).ok());
    server.close(window);
    assert!({ program }.wait().unwrap().success());
    let screen = codrive::record::Manifest::load(&out).unwrap().screen.unwrap();
    assert_eq!((screen.monitor.as_deref(), screen.present_mode.as_str()), (Some("screen"), "fifo"));
    // One picture may wait for the screen, with none queued behind it (docs/references.md: latency).
    assert_eq!(screen.frames_ahead, 1);
    let printed = text(&codrive(&server, &["doctor"]).output().unwrap());
    assert!(printed.contains("1: screen, 800x600"), "{printed}");
}
