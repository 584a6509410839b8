//! The participant's input devices. In: keys (told by the windows), wheels (read by evdev on Linux), pads (read by gilrs,
//! which also reads the wheels of other systems, whose force goes through SDL2). Out: [`Controls`], actions of buttons, time
//! of the newest input; and the force of the wheel. Nothing acts before it is known: a pedal that has not been read counts
//! as released. The device touched last drives.

mod buttons;
pub mod calibrate;
mod clock;
pub mod force;
pub mod force_thread;
mod keyboard;
pub mod lamps;
#[cfg(target_os = "linux")]
pub mod linux;
pub mod no_force;
mod other;
mod pads;
pub mod profile;
pub mod profiles;
pub mod reader;
mod rig;
pub mod sdl_force;
mod stalk;
pub mod wheel;

pub use buttons::ButtonAction;
pub use clock::TimeStamp;
pub use force::ForceInput;
pub use keyboard::{DriveKey, Keyboard};
pub use lamps::AdviceState;
pub use other::{WheelAxis, known_wheel};
pub use pads::Pads;
pub use profile::WheelProfile;
pub use rig::{Rig, RigEvent};

use crate::controls::{Controls, Indicator, LaneHint};
use stalk::Stalk;

/// All devices of the participant.
pub struct Devices {
    /// The keyboard, fed by the window.
    pub keyboard: Keyboard,
    pads: Pads,
    rig: Rig,
    source: ControlSource,
    stalk: Stalk,
}

/// Who drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlSource {
    /// The keyboard.
    Keyboard,
    /// A pad, or a wheel on a system without evdev.
    Pad,
    /// A wheel.
    Wheel,
}

impl Devices {
    /// Opens what is plugged in; a machine without any device is fine.
    pub fn open() -> Self {
        Self::open_with(None)
    }

    /// The same with the profile that a person named for the wheel.
    pub fn open_with(profile: Option<WheelProfile>) -> Self {
        let pads = Pads::open(profile.as_ref());
        Self::with(pads, Rig::open(profile))
    }

    /// The same with this wheel.
    pub fn with_rig(rig: Rig) -> Self {
        Self::with(Pads::open(None), rig)
    }

    fn with(pads: Pads, rig: Rig) -> Self {
        let source = ControlSource::Keyboard;
        Self { keyboard: Keyboard::default(), pads, rig, source, stalk: Stalk::default() }
    }

    /// Reads what happened since the last call; once a frame.
    pub fn poll(&mut self) -> Vec<RigEvent> {
        if self.pads.poll() {
            self.source = ControlSource::Pad;
        }
        let (touched, mut news) = self.rig.poll();
        news.extend(self.pads.take_pressed().into_iter().map(RigEvent::Pressed));
        news.extend(self.pads.take_troubles().into_iter().map(RigEvent::Trouble));
        for event in &news {
            match event {
                RigEvent::Pressed(ButtonAction::IndicateLeft) => self.indicate(Indicator::Left),
                RigEvent::Pressed(ButtonAction::IndicateRight) => self.indicate(Indicator::Right),
                _ => {}
            }
        }
        if touched || news.iter().any(|news| matches!(news, RigEvent::Connected(_))) {
            self.source = ControlSource::Wheel;
        }
        if self.keyboard.any_down() {
            self.source = ControlSource::Keyboard;
        }
        news
    }

    /// The controls of one tick. `hint` is what lane help needs, `None` where it is off.
    pub fn controls(&mut self, speed_mps: f64, hint: Option<LaneHint>) -> Controls {
        let typed = self.keyboard.tick(speed_mps, hint);
        let driven = match self.source {
            ControlSource::Keyboard => typed,
            ControlSource::Pad => self.pads.controls().unwrap_or(typed),
            ControlSource::Wheel => self.rig.controls(),
        };
        Controls { indicator: self.stalk.steered(driven.steering_wheel_rad), ..driven }
    }

    /// A hand pushes the stalk of the indicators to a side; to the side where it is, it goes back.
    pub fn indicate(&mut self, side: Indicator) {
        self.stalk.push(side);
    }

    /// Inputs of the force feedback from now on; at least ten times a second, or the force goes.
    pub fn set_force_input(&self, feel: ForceInput) {
        self.rig.set_force_input(feel);
        self.pads.set_force_input(feel);
    }

    /// The torque that was last sent to the wheel, N m, positive to the left; `None` where none is.
    pub fn torque_nm(&self) -> Option<f64> {
        self.rig.torque_nm().or_else(|| self.pads.torque_nm())
    }

    /// True while someone sounds the horn.
    pub fn horn(&self) -> bool {
        self.keyboard.horn() || self.rig.horn()
    }

    /// The wheel.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// The wheel, to be calibrated and to show the advice.
    pub fn rig_mut(&mut self) -> &mut Rig {
        &mut self.rig
    }

    /// When the newest input came that has not been asked for yet, where the device tells times.
    pub fn newest_input(&mut self) -> Option<TimeStamp> {
        self.rig.newest_input()
    }

    /// The profile of the wheel that is plugged in.
    pub fn wheel_profile(&self) -> Option<&WheelProfile> {
        self.rig.profile()
    }

    /// Which device was touched last.
    pub fn source(&self) -> ControlSource {
        self.source
    }

    /// Before a drive: keys are up, the indicators are off, and the selector is in drive whatever was pressed since the last one.
    pub fn rest(&mut self) {
        self.keyboard.rest();
        self.stalk = Stalk::default();
        self.rig.select_drive();
    }

    /// Who drives, as words.
    pub fn describe(&self) -> String {
        match self.source {
            ControlSource::Pad => self.pads.name().unwrap_or("pad unplugged").to_owned(),
            ControlSource::Keyboard => "keyboard".into(),
            ControlSource::Wheel => self.rig.describe(),
        }
    }
}
