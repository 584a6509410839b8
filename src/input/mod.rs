//! The participant's input devices. In: key events from the windows, wheels (read by evdev on Linux), gamepads (read by
//! gilrs). On other systems gilrs also reads the wheels, whose force goes through SDL2. Out: [`Controls`], button
//! actions, the time of the newest input, and the force of the wheel. An unknown input has no effect: a pedal that has
//! not been read counts as released. The device touched last drives.

mod buttons;
pub mod calibrate;
mod clock;
#[cfg(target_os = "linux")]
mod event_device;
pub mod force;
pub mod force_thread;
mod hand_torque;
mod hold;
mod keyboard;
pub mod kinds;
pub mod lamps;
#[cfg(target_os = "linux")]
pub mod linux;
pub mod no_force;
#[cfg(target_os = "linux")]
mod nodes;
mod other;
mod pads;
pub mod parts;
pub mod profile;
pub mod profiles;
pub mod reader;
mod rig;
pub mod sdl_force;
#[cfg(test)]
mod simulated_wheel;
mod stalk;
pub mod wheel;

pub use buttons::{ButtonAction, RigButton};
pub use clock::TimeStamp;
pub use force::ForceInput;
pub use keyboard::{DriveKey, Keyboard};
pub use lamps::AdviceState;
pub use other::{WheelAxis, known_wheel};
pub use pads::Pads;
pub use profile::WheelProfile;
pub use rig::{Rig, RigEvent};

use crate::controls::{ControlSource, Controls, Indicator, LaneHint, TaskButton};
use stalk::Stalk;
use std::{collections::VecDeque, path::Path};

/// All input devices of the participant.
pub struct Devices {
    /// Keyboard state, fed with key events by the window.
    pub keyboard: Keyboard,
    pads: Pads,
    rig: Rig,
    source: ControlSource,
    stalk: Stalk,
    /// True while the main beam is on.
    has_main_beam: bool,
    /// Presses for the secondary task that no tick has taken yet, oldest first.
    task_presses: VecDeque<TaskButton>,
    /// True if the button of the automation was pressed and no tick has taken the press yet.
    is_automation_pressed: bool,
    /// True if the button of the automation's time gap was pressed and no tick has taken the press yet.
    is_gap_pressed: bool,
}

impl Devices {
    /// Opens all devices that are plugged in; having none is no error.
    pub fn open() -> Self {
        Self::open_with(None)
    }

    /// Opens all devices; `profile` is the wheel profile that a person named.
    pub fn open_with(profile: Option<WheelProfile>) -> Self {
        let pads = Pads::open(profile.as_ref());
        Self::with(pads, Rig::open(profile))
    }

    /// Opens all devices with `rig` as the wheel.
    pub fn with_rig(rig: Rig) -> Self {
        Self::with(Pads::open(None), rig)
    }

    /// Returns the devices with the LED of this folder for signals, in place of the wheel's rev lamps.
    pub fn with_led(mut self, folder: Option<&Path>) -> Self {
        if let Some(folder) = folder {
            self.rig.set_led(lamps::Lamps::at(folder));
        }
        self
    }

    fn with(pads: Pads, rig: Rig) -> Self {
        let source = ControlSource::Keyboard;
        let (keyboard, stalk, task_presses) = (Keyboard::default(), Stalk::default(), VecDeque::new());
        let (has_main_beam, is_automation_pressed, is_gap_pressed) = (false, false, false);
        Self { keyboard, pads, rig, source, stalk, has_main_beam, task_presses, is_automation_pressed, is_gap_pressed }
    }

    /// Reads the events since the last call; to be called once a frame.
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
                RigEvent::Pressed(ButtonAction::MainBeam) => self.switch_main_beam(),
                RigEvent::Pressed(ButtonAction::Automation) => self.press_for_automation(),
                RigEvent::Pressed(ButtonAction::TimeGap) => self.press_for_time_gap(),
                RigEvent::Pressed(ButtonAction::Respond) => self.press_for_task(TaskButton::Respond),
                RigEvent::Pressed(ButtonAction::Left) => self.press_for_task(TaskButton::Left),
                RigEvent::Pressed(ButtonAction::Right) => self.press_for_task(TaskButton::Right),
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

    /// Returns the controls of one tick. `hint` is the input of lane help, `None` where lane help is off.
    pub fn controls(&mut self, speed_mps: f64, hint: Option<LaneHint>) -> Controls {
        let typed = self.keyboard.tick(speed_mps, hint);
        let (driven, hand_torque_nm) = match self.source {
            ControlSource::Keyboard => (typed, None),
            ControlSource::Pad => (self.pads.controls().unwrap_or(typed), self.pads.hand_torque_nm()),
            ControlSource::Wheel => (self.rig.controls(), self.rig.hand_torque_nm()),
        };
        let hand_torque_nm = hand_torque_nm.map(|torque_nm| torque_nm as f32);
        let indicator = self.stalk.steered(driven.steering_wheel_rad);
        let task_button = self.task_presses.pop_front().unwrap_or_default();
        let automation_button = std::mem::take(&mut self.is_automation_pressed);
        let gap_button = std::mem::take(&mut self.is_gap_pressed);
        let main_beam = self.has_main_beam;
        Controls { indicator, main_beam, task_button, automation_button, gap_button, hand_torque_nm, ..driven }
    }

    /// Pushes the indicator stalk to a side; a push to the side where it is puts it back to the middle.
    pub fn indicate(&mut self, side: Indicator) {
        self.stalk.push(side);
    }

    /// Switches the main beam on or off.
    pub fn switch_main_beam(&mut self) {
        self.has_main_beam = !self.has_main_beam;
    }

    /// Presses a button of the secondary task; the next tick takes it.
    pub fn press_for_task(&mut self, button: TaskButton) {
        self.task_presses.push_back(button);
    }

    /// Presses the button of the automation; the next tick takes it.
    pub fn press_for_automation(&mut self) {
        self.is_automation_pressed = true;
    }

    /// Presses the button of the automation's time gap; the next tick takes it.
    pub fn press_for_time_gap(&mut self) {
        self.is_gap_pressed = true;
    }

    /// Forgets presses for the secondary task and the automation that no tick has taken, as in a pause.
    pub fn forget_presses(&mut self) {
        self.task_presses.clear();
        (self.is_automation_pressed, self.is_gap_pressed) = (false, false);
    }

    /// Sets the inputs of the force feedback. The force fades out when no input comes for [`force::STALE_S`].
    pub fn set_force_input(&mut self, force_input: ForceInput) {
        self.rig.set_force_input(force_input);
        self.pads.set_force_input(force_input);
    }

    /// Checks whether a force can be felt now.
    pub fn has_force(&self) -> bool {
        self.rig.has_force() || self.pads.has_force()
    }

    /// Returns the mean torque that was sent to the wheel since the last call, N m, positive to the left; `None` without
    /// force feedback.
    pub fn take_torque_nm(&self) -> Option<f64> {
        self.rig.take_torque_nm().or_else(|| self.pads.take_torque_nm())
    }

    /// Checks whether the horn is held, on the keyboard or on the wheel.
    pub fn horn(&self) -> bool {
        self.keyboard.horn() || self.rig.horn()
    }

    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Returns the wheel, for calibration and for the rev lamps.
    pub fn rig_mut(&mut self) -> &mut Rig {
        &mut self.rig
    }

    /// Returns the time stamp of the wheel's newest input since the last call; `None` without input or time stamp.
    pub fn newest_input(&mut self) -> Option<TimeStamp> {
        self.rig.newest_input()
    }

    /// Returns the profile of the connected wheel.
    pub fn wheel_profile(&self) -> Option<&WheelProfile> {
        self.rig.profile()
    }

    /// Returns the device that was touched last.
    pub fn source(&self) -> ControlSource {
        self.source
    }

    /// Resets keyboard, wheel and pads before a drive: pedals up, indicators and main beam off, selector in Drive.
    pub fn rest(&mut self) {
        self.keyboard.rest();
        self.stalk = Stalk::default();
        self.has_main_beam = false;
        self.forget_presses();
        self.rig.select_drive();
        self.pads.select_drive();
    }

    /// Returns a short description of the driving device, for display.
    pub fn describe(&self) -> String {
        match self.source {
            ControlSource::Pad => self.pads.name().unwrap_or("pad unplugged").to_owned(),
            ControlSource::Keyboard => "keyboard".into(),
            ControlSource::Wheel => self.rig.describe(),
        }
    }
}
