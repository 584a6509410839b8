//! An X server of a test's own (Xvfb), and a keyboard on it.

use std::{
    io::{BufRead, BufReader},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};
use x11rb::{
    connection::Connection,
    protocol::{
        xproto::{AtomEnum, ConnectionExt as _, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, Window},
        xtest::ConnectionExt as _,
    },
    rust_connection::RustConnection,
};

/// Waits for `what` to become something, looking 20 times a second for up to 60 s: a slow machine is no failure.
pub fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    for _ in 0..1200 {
        if let Some(found) = look() {
            return found;
        }
        sleep(Duration::from_millis(50));
    }
    panic!("{what} did not come within 60 s");
}

/// Ends with the test.
pub struct Server {
    process: Child,
    pub display: String,
    connection: RustConnection,
    root: Window,
}

impl Server {
    pub fn start(size: &str) -> Self {
        let mut process = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &format!("{size}x24"), "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb is needed: scripts/setup --test installs it");
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let display = format!(":{}", line.trim());
        let (connection, screen) = wait_for("the X server", || RustConnection::connect(Some(&display)).ok());
        let root = connection.setup().roots[screen].root;
        Self { process, display, connection, root }
    }

    /// The window of this title once it is on the screen.
    pub fn window(&self, title: &str) -> Window {
        wait_for(title, || {
            let children = self.connection.query_tree(self.root).ok()?.reply().ok()?.children;
            children.into_iter().find(|window| {
                let name = self.connection.get_property(false, *window, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 100);
                name.ok().and_then(|n| n.reply().ok()).is_some_and(|n| n.value.starts_with(title.as_bytes()))
            })
        })
    }

    /// Presses keys together in a window, as a keyboard would: the first are held while the last is struck.
    pub fn strike(&self, window: Window, keys: &[u8]) {
        wait_for("the keyboard's focus", || {
            self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).ok()?.check().ok()
        });
        let fake = |kind: u8, key: u8| {
            let sent = self.connection.xtest_fake_input(kind, key, x11rb::CURRENT_TIME, self.root, 0, 0, 0);
            sent.unwrap().check().unwrap();
        };
        keys.iter().for_each(|key| fake(KEY_PRESS_EVENT, *key));
        sleep(Duration::from_millis(30));
        keys.iter().rev().for_each(|key| fake(KEY_RELEASE_EVENT, *key));
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
