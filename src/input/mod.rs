//! Devices. In: keys (told by `app`), pads and wheels (read by gilrs). Out: [`Controls`]. Nothing acts before its first
//! event: a pedal that has not been read counts as released. The device touched last drives.

mod keyboard;
mod pads;
mod wheel;

pub use keyboard::{DriveKey, Keyboard, LaneHint};
pub use pads::Pads;
pub use wheel::{WheelAxis, WheelState, known_wheel};

use crate::ego::Controls;

/// All devices of the participant.
pub struct Devices {
    /// The keyboard, fed by the window.
    pub keyboard: Keyboard,
    pads: Pads,
    source: Source,
}

/// Who drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The keyboard.
    Keyboard,
    /// A pad or wheel.
    Pad,
}

impl Devices {
    /// Opens what is plugged in; a machine without any device is fine.
    pub fn open() -> Self {
        Self { keyboard: Keyboard::default(), pads: Pads::open(), source: Source::Keyboard }
    }

    /// Reads what happened since the last call; once a frame.
    pub fn poll(&mut self) {
        if self.pads.poll() {
            self.source = Source::Pad;
        }
        if self.keyboard.any_down() {
            self.source = Source::Keyboard;
        }
    }

    /// The controls of one tick. `hint` is what lane help needs, `None` where it is off.
    pub fn controls(&mut self, speed_mps: f64, hint: Option<LaneHint>) -> Controls {
        let typed = self.keyboard.tick(speed_mps, hint);
        match self.source {
            Source::Keyboard => typed,
            Source::Pad => self.pads.controls().unwrap_or(typed),
        }
    }

    /// Who drives, as words.
    pub fn describe(&self) -> String {
        match self.source {
            Source::Pad => self.pads.name().unwrap_or("pad unplugged").to_owned(),
            Source::Keyboard => "keyboard".into(),
        }
    }
}
