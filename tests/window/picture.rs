//! Tests of the driver's window: its size where the processor draws, resizing by its corner, full screen by a key, and its copy in the
//! experimenter's window.

use crate::{
    keys::F11,
    xserver::{Picture, Server, wait_for},
};
use std::{
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

/// Starts a drive that waits for the space bar.
fn held(server: &Server, more: &[&str]) -> Child {
    held_with(server, more, &[])
}

/// Starts a drive that waits for the space bar, with these variables of the environment.
fn held_with(server: &Server, more: &[&str], variables: &[(&str, &str)]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_codrive"))
        .envs(variables.iter().copied())
        .args(["drive", "--paused", "--traffic", "native", "--quality", "low", "--trees", "0", "--policy", "none"])
        .args(["--cockpit", "off"])
        .args(more)
        .env("DISPLAY", &server.display)
        .env("RUST_LOG", "error")
        .env_remove("WAYLAND_DISPLAY")
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn end(server: &Server, window: u32, program: Child) {
    server.close(window);
    let output = program.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Returns true if the picture has this size and all its corners show sky or meadow instead of black.
fn is_full([width, height]: [u32; 2], picture: &Picture) -> bool {
    let corners = [[4, 4], [width - 5, 4], [4, height - 5], [width - 5, height - 5]];
    picture.size == [width, height] && corners.iter().all(|[x, y]| picture.at(*x, *y).iter().any(|v| *v > 24))
}

#[test]
fn software_rendering_opens_a_small_window_and_fills_every_size() {
    let server = Server::start([1000, 700]);
    let program = held(&server, &[]);
    let window = server.window("codrive");
    // Xvfb has no graphics card, so the window has 640 by 360 points on a screen of one pixel per point.
    wait_for("the small window", || (server.size_of(window) == [640, 360]).then_some(()));
    wait_for("its picture", || is_full([640, 360], &server.picture(window)).then_some(()));
    for size in [[900, 420], [400, 600]] {
        server.resize(window, size);
        wait_for("the picture at another size", || is_full(size, &server.picture(window)).then_some(()));
    }
    end(&server, window, program);
}

#[test]
fn full_screen_is_requested_by_flag_or_key_and_left_by_the_key() {
    let server = Server::start([640, 400]);
    server.manage();
    let asked = || wait_for("a word to the window manager", || server.asked_to_fill());
    let program = held(&server, &[]);
    let window = server.window("codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    for fill in [true, false, true] {
        server.strike(window, &[F11]);
        assert_eq!(asked(), fill);
    }
    end(&server, window, program);
    let program = held(&server, &["--fullscreen"]);
    let window = server.window("codrive");
    assert!(asked(), "it fills the screen at once");
    end(&server, window, program);
}

/// Finds a picture of 16 to 9 in the middle column of the experimenter's window; returns left, top and width, pixels.
fn found(shown: &Picture, within: &Picture) -> Option<[u32; 3]> {
    // Points of the picture as fractions of its sides, with their colours.
    let points: Vec<([f32; 2], [u8; 3])> = (0..60)
        .map(|i| {
            let at = [0.04 + 0.092 * (i % 10) as f32, 0.08 + 0.16 * (i / 10) as f32];
            (at, shown.at((at[0] * shown.size[0] as f32) as u32, (at[1] * shown.size[1] as f32) as u32))
        })
        .collect();
    let near = |a: [u8; 3], b: [u8; 3]| (0..3).all(|i| a[i].abs_diff(b[i]) < 24);
    for width in 240..=440 {
        for top in 0..120 {
            for left in 300..600 {
                let seen = |at: [f32; 2]| {
                    within.at(left + (at[0] * width as f32) as u32, top + (at[1] * width as f32 * 9.0 / 16.0) as u32)
                };
                // Up to 9 of 60 points may differ, as edges may be shifted; the comparison stops at the tenth.
                let differ = points.iter().filter(|(at, colour)| !near(seen(*at), *colour)).take(10).count();
                if differ < 10 {
                    return Some([left, top, width]);
                }
            }
        }
    }
    None
}

#[test]
fn the_experimenter_sees_the_drivers_view() {
    experimenter_sees_the_driver(&[]);
}

#[test]
fn opengl_alone_draws_both_windows() {
    // Without a driver for Vulkan nothing has to choose OpenGL.
    experimenter_sees_the_driver(&[("VK_DRIVER_FILES", "/nonexistent"), ("VK_ICD_FILENAMES", "/nonexistent")]);
}

fn experimenter_sees_the_driver(variables: &[(&str, &str)]) {
    let server = Server::start([2000, 820]);
    let program = held_with(&server, &["--experimenter"], variables);
    let window = server.window("codrive");
    let experimenter = server.window("Experimenter");
    server.move_to(experimenter, [700, 0]);
    wait_for("the driver's picture", || is_full([640, 360], &server.picture(window)).then_some(()));
    wait_for("the experimenter's window", || (server.size_of(experimenter) == [1280, 800]).then_some(()));
    // Where the processor draws, the copy is up to half a second old and the window is drawn twice a second. A busy machine needs several
    // looks.
    let place = (0..12).find_map(|_| {
        sleep(Duration::from_secs(1));
        found(&server.picture(window), &server.picture(experimenter))
    });
    assert!(place.is_some(), "the driver's picture is not in the experimenter's window");
    end(&server, experimenter, program);
}
