//! Monitors and the check screen on a real X server (Xvfb), whose one monitor is its screen.

use crate::xserver::{Server, wait_for};
use std::process::{Command, Output, Stdio};

const ESCAPE: u8 = 9;

fn codrive(server: &Server, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env("DISPLAY", &server.display).env_remove("WAYLAND_DISPLAY").env("RUST_LOG", "error");
    command
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

#[test]
fn a_monitor_or_a_rate_that_is_not_there_is_answered_with_those_that_are() {
    let server = Server::start([640, 400]);
    let small = ["drive", "--traffic", "native", "--trees", "0", "--quality", "low"];
    for (more, parts) in [
        (&["--monitor", "2"][..], ["there is no monitor 2; there are 1: screen, 640x400", "codrive doctor lists them"]),
        (&["--fullscreen", "--refresh", "37"], ["no mode of the monitor has 37 Hz", "1: screen, 640x400"]),
        (&["--refresh", "60"], ["--refresh needs --fullscreen", "a window cannot choose its screen's rate"]),
    ] {
        let output = codrive(&server, &[&small[..], more].concat()).output().unwrap();
        let said = text(&output);
        assert!(output.status.code() == Some(2) && parts.iter().all(|part| said.contains(part)), "{more:?}: {said}");
    }
}

#[test]
fn the_check_screen_shows_its_ruler_until_escape() {
    let server = Server::start([900, 700]);
    let program = codrive(&server, &["doctor", "--display"]);
    let program = { program }.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let window = server.window("codrive: display");
    wait_for("lines and letters", || (server.colours_of(window) > 20).then_some(()));
    server.strike(window, &[ESCAPE]);
    let output = program.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
}
