//! Tests of the variables of the environment that choose graphics, scale and display: a value that chooses nothing is refused by name.

use crate::xserver::{Server, ended};
use std::process::{Command, Stdio};

const DRIVE: &[&str] = &["drive", "--paused", "--traffic", "native", "--quality", "low", "--trees", "0"];
const RENDER: &[&str] = &["render", "--traffic", "native", "--at", "0", "--size", "64x36", "--out"];
const DOCTOR: &[&str] = &["doctor"];
const BENCH: &[&str] = &["bench", "--small", "--frames", "1", "--traffic", "native"];

/// Runs a command with a variable on a server; returns its exit code and output.
fn run(server: &Server, arguments: &[&str], variable: &str, value: &str) -> (i32, String) {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env_remove("RUST_LOG").env_remove("WAYLAND_DISPLAY");
    match arguments[0] {
        "render" => command.arg(folder.path().join("a.png")),
        "drive" => command.arg("--out").arg(folder.path().join("drive")),
        _ => &mut command,
    };
    command.env("DISPLAY", &server.display).env(variable, value);
    ended(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap())
}

#[test]
fn a_variable_that_chooses_nothing_is_named_with_its_value_and_a_remedy() {
    let server = Server::start([640, 400]);
    let graphics = [DRIVE, RENDER, DOCTOR, BENCH];
    let window = [DRIVE, DOCTOR];
    for (variable, value, commands, remedy) in [
        ("WGPU_ADAPTER_NAME", "nothing", &graphics[..], "unset WGPU_ADAPTER_NAME, or set it to a part of the name"),
        ("WGPU_BACKEND", "nonsense", &graphics, "unset WGPU_BACKEND, or set it to vulkan ("),
        ("WGPU_BACKEND", "dx12", &graphics, "unset WGPU_BACKEND, or set it to vulkan ("),
        ("WGPU_POWER_PREF", "x", &graphics, "unset WGPU_POWER_PREF, or set it to low"),
        ("WINIT_X11_SCALE_FACTOR", "-1", &window, "unset WINIT_X11_SCALE_FACTOR"),
        ("WINIT_X11_SCALE_FACTOR", "0", &window, "unset WINIT_X11_SCALE_FACTOR"),
        ("WINIT_X11_SCALE_FACTOR", "abc", &window, "unset WINIT_X11_SCALE_FACTOR"),
        ("WINIT_X11_SCALE_FACTOR", "1e9", &window, "unset WINIT_X11_SCALE_FACTOR"),
        ("DISPLAY", ":77", &window, "start it on a computer with a display"),
    ] {
        for arguments in commands {
            let (code, text) = run(&server, arguments, variable, value);
            let given = format!("{variable}={value}: ");
            assert_eq!(code, 1, "{arguments:?} {given}{text}");
            let mut lines = text.lines().skip_while(|line| !line.contains(&given));
            let (message, then) = (lines.next().unwrap_or_default(), lines.next().unwrap_or_default());
            assert!(message.contains(&given), "{arguments:?} {given}{text}");
            assert!(then.trim_start().starts_with("remedy: ") && then.contains(remedy), "{arguments:?} {given}{text}");
            assert!(!text.contains("panicked") && !text.contains("[WARN"), "{arguments:?} {given}{text}");
            assert!(!text.contains("warning: "), "{arguments:?} {given}{text}");
            if *arguments != DOCTOR {
                assert_eq!(text.lines().count(), 2, "{arguments:?} {given}{text}");
            }
        }
    }
    // A picture needs no window.
    for (variable, value) in [("WINIT_X11_SCALE_FACTOR", "-1"), ("DISPLAY", ":77"), ("WGPU_BACKEND", "")] {
        let (code, text) = run(&server, RENDER, variable, value);
        assert!(code == 0 && text.lines().count() == 1, "{variable}={value}: {text}");
    }
}
