//! X server for one test (Xvfb), with its windows, keyboard, mouse and screen contents.

use std::{
    collections::BTreeSet,
    io::{BufRead, BufReader, Read},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};
use x11rb::{
    connection::Connection,
    protocol::{
        Event,
        xproto::{
            AtomEnum, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ChangeWindowAttributesAux, ClientMessageEvent,
            ConfigureWindowAux, ConnectionExt as _, EventMask, ImageFormat, InputFocus, KEY_PRESS_EVENT,
            KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, Window,
        },
        xtest::ConnectionExt as _,
    },
    rust_connection::RustConnection,
};

/// Waits until `look` returns a value, with 20 looks a second for up to 60 s. A slow machine is no failure.
pub fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    for _ in 0..1200 {
        if let Some(found) = look() {
            return found;
        }
        sleep(Duration::from_millis(50));
    }
    panic!("{what} did not come within 60 s");
}

/// Contents of a window.
pub struct Picture {
    pub size: [u32; 2],
    pixels: Vec<u8>,
}

impl Picture {
    /// Returns red, green and blue of a pixel, from 0 to 255.
    pub fn at(&self, x: u32, y: u32) -> [u8; 3] {
        let i = 4 * (y * self.size[0] + x) as usize;
        [self.pixels[i + 2], self.pixels[i + 1], self.pixels[i]]
    }

    /// Returns the share of pixels with a different colour in another picture of the same size, from 0 to 1.
    pub fn differs(&self, other: &Self) -> f64 {
        assert_eq!(self.size, other.size);
        let pairs = self.pixels.chunks(4).zip(other.pixels.chunks(4));
        pairs.filter(|(a, b)| a[..3] != b[..3]).count() as f64 / (self.pixels.len() / 4) as f64
    }

    /// Returns the runs of one colour in a row of pixels that have at least `least` pixels, each as first pixel and length.
    pub fn stretches(&self, y: u32, colour: [u8; 3], least: u32) -> Vec<[u32; 2]> {
        let mut found: Vec<[u32; 2]> = Vec::new();
        for x in (0..self.size[0]).filter(|x| self.at(*x, y) == colour) {
            match found.last_mut() {
                Some([from, length]) if *from + *length == x => *length += 1,
                _ => found.push([x, 1]),
            }
        }
        found.retain(|[_, length]| *length >= least);
        found
    }
}

/// Waits for the end of a program; returns its exit code and output.
pub fn ended(mut program: Child) -> (i32, String) {
    let status = wait_for("the end of the program", || program.try_wait().unwrap());
    let mut text = String::new();
    program.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    program.stderr.take().unwrap().read_to_string(&mut text).unwrap();
    (status.code().unwrap_or(-1), text)
}

/// X server, killed when dropped.
pub struct Server {
    process: Child,
    pub display: String,
    connection: RustConnection,
    root: Window,
    size: [u16; 2],
}

impl Server {
    /// Starts a server with one screen of this size in pixels.
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

    /// Starts a program with its windows on this server.
    pub fn start_program(&self, command: &mut Command) -> Child {
        let command = command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY");
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Waits for the window of this title and returns it.
    pub fn window(&self, title: &str) -> Window {
        wait_for(title, || {
            let children = self.connection.query_tree(self.root).ok()?.reply().ok()?.children;
            children.into_iter().find(|window| {
                let name = self.connection.get_property(false, *window, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 100);
                name.ok().and_then(|n| n.reply().ok()).is_some_and(|n| n.value.starts_with(title.as_bytes()))
            })
        })
    }

    /// Gives the keyboard focus to a window.
    pub fn focus(&self, window: Window) {
        wait_for("the keyboard's focus", || {
            self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).ok()?.check().ok()
        });
    }

    /// Takes the keyboard focus from all windows.
    pub fn unfocus(&self) {
        self.connection.set_input_focus(InputFocus::NONE, x11rb::NONE, x11rb::CURRENT_TIME).unwrap().check().unwrap();
    }

    /// Presses or releases a key, as a keyboard does.
    pub fn key(&self, code: u8, down: bool) {
        let kind = if down { KEY_PRESS_EVENT } else { KEY_RELEASE_EVENT };
        self.connection.xtest_fake_input(kind, code, x11rb::CURRENT_TIME, self.root, 0, 0, 0).unwrap().check().unwrap();
    }

    /// Presses keys together in a window: the first are held while the last is pressed.
    pub fn strike(&self, window: Window, keys: &[u8]) {
        self.focus(window);
        self.press(keys);
    }

    /// Presses keys like `strike` if the window is on the screen, else does nothing.
    pub fn strike_if_there(&self, window: Window, keys: &[u8]) {
        let focus = self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME);
        if focus.is_ok_and(|asked| asked.check().is_ok()) {
            self.press(keys);
        }
    }

    fn press(&self, keys: &[u8]) {
        keys.iter().for_each(|key| self.key(*key, true));
        sleep(Duration::from_millis(30));
        keys.iter().rev().for_each(|key| self.key(*key, false));
    }

    /// Returns width and height of a window, pixels.
    pub fn size_of(&self, window: Window) -> [u32; 2] {
        let place = self.connection.get_geometry(window).unwrap().reply().unwrap();
        [place.width.into(), place.height.into()]
    }

    /// Moves a window, as dragging it does.
    pub fn move_to(&self, window: Window, [x, y]: [i32; 2]) {
        self.connection.configure_window(window, &ConfigureWindowAux::new().x(x).y(y)).unwrap().check().unwrap();
    }

    /// Resizes a window, as dragging its corner does.
    pub fn resize(&self, window: Window, [width, height]: [u32; 2]) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.connection.configure_window(window, &size).unwrap().check().unwrap();
    }

    /// Clicks at a point of the screen, pixels from its upper left corner.
    pub fn click(&self, [x, y]: [u32; 2]) {
        let act = |kind: u8, detail: u8| {
            let now = x11rb::CURRENT_TIME;
            self.connection
                .xtest_fake_input(kind, detail, now, self.root, x as i16, y as i16, 0)
                .unwrap()
                .check()
                .unwrap();
            sleep(Duration::from_millis(30));
        };
        act(MOTION_NOTIFY_EVENT, 0);
        act(BUTTON_PRESS_EVENT, 1);
        act(BUTTON_RELEASE_EVENT, 1);
    }

    /// Makes this test receive what windows ask of a window manager; the server has no other.
    pub fn manage(&self) {
        let hears = ChangeWindowAttributesAux::new().event_mask(EventMask::SUBSTRUCTURE_NOTIFY);
        self.connection.change_window_attributes(self.root, &hears).unwrap().check().unwrap();
    }

    /// Returns the next request of a window to enter (true) or leave (false) full screen.
    pub fn asked_to_fill(&self) -> Option<bool> {
        loop {
            let Event::ClientMessage(message) = self.connection.poll_for_event().unwrap()? else { continue };
            let name = |atom| self.connection.get_atom_name(atom).unwrap().reply().map_or(Vec::new(), |name| name.name);
            let [action, state, ..] = message.data.as_data32();
            if name(message.type_) == b"_NET_WM_STATE" && name(state) == b"_NET_WM_STATE_FULLSCREEN" {
                return Some(action == 1);
            }
        }
    }

    /// Returns the contents of a window, which must be visible.
    pub fn picture(&self, window: Window) -> Picture {
        let size = self.size_of(window);
        let [width, height] = size.map(|side| side as u16);
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, width, height, !0).unwrap();
        Picture { size, pixels: image.reply().unwrap().data }
    }

    /// Returns the pixels of the screen, four bytes each.
    pub fn screen(&self) -> Vec<u8> {
        let [width, height] = self.size;
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, width, height, !0).unwrap();
        image.reply().unwrap().data
    }

    /// Counts the colours on the screen.
    pub fn colours(&self) -> usize {
        colours(&self.screen())
    }

    /// Counts the colours in the upper left corner of a window, 600 by 380 pixels; 0 while the window is not visible.
    pub fn colours_of(&self, window: Window) -> usize {
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, 600, 380, !0).unwrap().reply();
        image.map_or(0, |image| colours(&image.data))
    }

    /// Asks a window to close, as a window manager does when the user clicks its close button.
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
