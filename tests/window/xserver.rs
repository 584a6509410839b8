//! An X server of a test's own (Xvfb): its windows, a keyboard on it, what is on its screen.

use std::{
    collections::BTreeSet,
    io::{BufRead, BufReader},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};
use x11rb::{
    connection::Connection,
    protocol::{
        xproto::{
            AtomEnum, ClientMessageEvent, ConnectionExt as _, EventMask, ImageFormat, InputFocus, KEY_PRESS_EVENT,
            KEY_RELEASE_EVENT, Window,
        },
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
    size: [u16; 2],
}

impl Server {
    /// One screen of so many pixels.
    pub fn start(size: [u16; 2]) -> Self {
        let mut process = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &format!("{}x{}x24", size[0], size[1]), "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb is needed: scripts/setup --test installs it");
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let display = format!(":{}", line.trim());
        let (connection, screen) = wait_for("the X server", || RustConnection::connect(Some(&display)).ok());
        let root = connection.setup().roots[screen].root;
        Self { process, display, connection, root, size }
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

    /// The keyboard is this window's.
    pub fn focus(&self, window: Window) {
        wait_for("the keyboard's focus", || {
            self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).ok()?.check().ok()
        });
    }

    /// Presses or releases a key, as a keyboard would.
    pub fn key(&self, code: u8, down: bool) {
        let kind = if down { KEY_PRESS_EVENT } else { KEY_RELEASE_EVENT };
        self.connection.xtest_fake_input(kind, code, x11rb::CURRENT_TIME, self.root, 0, 0, 0).unwrap().check().unwrap();
    }

    /// Presses keys together in a window: the first are held while the last is struck.
    pub fn strike(&self, window: Window, keys: &[u8]) {
        self.focus(window);
        keys.iter().for_each(|key| self.key(*key, true));
        sleep(Duration::from_millis(30));
        keys.iter().rev().for_each(|key| self.key(*key, false));
    }

    /// Pixels of the screen, four bytes each.
    pub fn screen(&self) -> Vec<u8> {
        let [width, height] = self.size;
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, width, height, !0).unwrap();
        image.reply().unwrap().data
    }

    /// How many colours are on the screen.
    pub fn colours(&self) -> usize {
        colours(&self.screen())
    }

    /// How many colours are in the upper left corner of a window; none while it is not to be seen.
    pub fn colours_of(&self, window: Window) -> usize {
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, 600, 380, !0).unwrap().reply();
        image.map_or(0, |image| colours(&image.data))
    }

    /// What a window manager does when someone clicks the cross.
    pub fn close(&self, window: Window) {
        let atom = |name: &str| self.connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
        let data = [atom("WM_DELETE_WINDOW"), x11rb::CURRENT_TIME, 0, 0, 0];
        let event = ClientMessageEvent::new(32, window, atom("WM_PROTOCOLS"), data);
        self.connection.send_event(false, window, EventMask::NO_EVENT, event).unwrap().check().unwrap();
    }
}

fn colours(pixels: &[u8]) -> usize {
    pixels.chunks(4).collect::<BTreeSet<_>>().len()
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
