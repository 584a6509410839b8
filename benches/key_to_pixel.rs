//! Measures the latency from a key to a changed pixel, through a real X server (Xvfb): `cargo bench --bench key_to_pixel`. XTEST presses
//! the brake's key, and the program reads the square in the picture's corner from the screen until it is white. Out: the distribution.

use std::{
    io::{BufRead, BufReader},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};
use x11rb::{
    connection::Connection,
    protocol::{
        xproto::{AtomEnum, ConnectionExt as _, ImageFormat, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, Window},
        xtest::ConnectionExt as _,
    },
    rust_connection::RustConnection,
};

/// X key code of S, the brake.
const KEY_S: u8 = 39;
/// Number of measured presses.
const PRESSES: u32 = 100;

/// Process that is killed when dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn main() {
    let mut server = Running(
        Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "640x400x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb is needed: scripts/setup --test installs it"),
    );
    let mut line = String::new();
    BufReader::new(server.0.stdout.take().expect("piped")).read_line(&mut line).expect("a display number");
    let display = format!(":{}", line.trim());
    let (x, screen) = RustConnection::connect(Some(&display)).expect("the X server");
    let root = x.setup().roots[screen].root;
    let arguments = ["drive", "--quality", "low", "--trees", "0", "--traffic", "native", "--duration", "0"];
    let _program = Running(
        Command::new(env!("CARGO_BIN_EXE_codrive"))
            .args(arguments)
            .args(["--flash-patch", "pedal", "--creep", "false"])
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("codrive"),
    );
    let window = loop {
        sleep(Duration::from_millis(50));
        if let Some(window) = window(&x, root) {
            break window;
        }
    };
    while x.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).unwrap().check().is_err() {
        sleep(Duration::from_millis(50));
    }
    let key = |down: bool| {
        let kind = if down { KEY_PRESS_EVENT } else { KEY_RELEASE_EVENT };
        x.xtest_fake_input(kind, KEY_S, x11rb::CURRENT_TIME, root, 0, 0, 0).unwrap().check().unwrap();
    };
    let white = || {
        let image = x.get_image(ImageFormat::Z_PIXMAP, root, 8, 8, 1, 1, !0).unwrap().reply().unwrap();
        image.data[..3].iter().all(|level| *level > 200)
    };
    let black = || {
        let image = x.get_image(ImageFormat::Z_PIXMAP, root, 8, 8, 1, 1, !0).unwrap().reply().unwrap();
        image.data[..3].iter().all(|level| *level < 20)
    };
    while !black() {
        sleep(Duration::from_millis(50));
    }
    sleep(Duration::from_secs(3));
    let mut times_ms = Vec::new();
    for press in 0..PRESSES {
        // At a different moment of a frame each time.
        sleep(Duration::from_micros(700_000 + u64::from(press * 7919 % 1000) * 100));
        let begin = now();
        key(true);
        while !white() {
            assert!(begin.elapsed() < Duration::from_secs(20), "the square stays black");
        }
        times_ms.push(begin.elapsed().as_secs_f64() * 1e3);
        key(false);
    }
    times_ms.sort_by(f64::total_cmp);
    let at = |share: f64| times_ms[((times_ms.len() - 1) as f64 * share).round() as usize];
    println!(
        "key to changed pixel, {PRESSES} presses: least {:.1}, quarter {:.1}, median {:.1}, three quarters {:.1}, 99 % {:.1}, \
         most {:.1} ms",
        at(0.0),
        at(0.25),
        at(0.5),
        at(0.75),
        at(0.99),
        at(1.0)
    );
}

fn window(x: &RustConnection, root: Window) -> Option<Window> {
    let children = x.query_tree(root).ok()?.reply().ok()?.children;
    children.into_iter().find(|window| {
        let name = x.get_property(false, *window, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 100);
        name.ok().and_then(|n| n.reply().ok()).is_some_and(|n| n.value.starts_with(b"codrive"))
    })
}

#[allow(clippy::disallowed_methods, reason = "a measurement of time is what this is")]
fn now() -> Instant {
    Instant::now()
}
