//! The participant's wheel over a whole session: plugged in, unplugged, plugged in again. In: what the reading thread tells.
//! Out: controls, news for people, and force while there is a wheel that takes it.

use super::{
    clock::Stamp,
    feel::{ForceLoop, ForceThread},
    force::Feel,
    profile::{Action, Profile},
    reader::ReadingThread,
    wheel::{Found, Told, WheelState},
};
use crate::ego::{Controls, Selector};
use std::sync::mpsc::Receiver;

/// What happened to the wheel that someone has to know.
#[derive(Clone, Debug, PartialEq)]
pub enum RigNews {
    /// A wheel is there, or there again: its name.
    Found(String),
    /// It was unplugged: its name.
    Lost(String),
    /// A button with a meaning was pressed.
    Pressed(Action),
    /// Something is wrong, and its remedy.
    Trouble(String),
}

/// The wheel, or the place for one.
pub struct Rig {
    told: Receiver<Told>,
    wheel: Option<Plugged>,
    /// What holds while there is none: pedals up, the wheel where it was.
    left: Controls,
    newest: Option<Stamp>,
    /// The last: its end is waited for after all else is let go.
    _thread: Option<ReadingThread>,
}

struct Plugged {
    name: String,
    state: WheelState,
    force: Option<ForceThread>,
}

impl Rig {
    /// Looks for wheels from now on; `asked` is a profile that a person named.
    pub fn open(asked: Option<Profile>) -> Self {
        let started = start(asked);
        let (thread, told) = match started {
            Some((thread, told)) => (Some(thread), told),
            None => (None, std::sync::mpsc::channel().1),
        };
        Self { _thread: thread, ..Self::fed_by(told) }
    }

    /// A wheel that is told of by whoever holds the other end.
    pub fn fed_by(told: Receiver<Told>) -> Self {
        Self { told, wheel: None, left: Controls::default(), newest: None, _thread: None }
    }

    /// Takes in what happened since the last call. True if a hand or foot moved something.
    pub fn poll(&mut self) -> (bool, Vec<RigNews>) {
        let (mut touched, mut news) = (false, Vec::new());
        while let Ok(told) = self.told.try_recv() {
            match told {
                Told::Found(found) => {
                    log::info!("found {} (profile {})", found.name, found.profile.name);
                    news.push(RigNews::Found(found.name.clone()));
                    self.plug(*found);
                }
                Told::Axis { code, raw, at } => {
                    if let Some(wheel) = &mut self.wheel {
                        touched |= wheel.state.moved(code, raw);
                        self.newest = self.newest.max(at);
                    }
                }
                Told::Button { code, at } => {
                    if let Some(action) = self.wheel.as_mut().and_then(|wheel| wheel.state.pressed(code)) {
                        touched = true;
                        self.newest = self.newest.max(at);
                        news.push(RigNews::Pressed(action));
                    }
                }
                Told::Lost => {
                    if let Some(wheel) = self.wheel.take() {
                        log::warn!("{} was unplugged: its pedals count as released", wheel.name);
                        self.left = Controls { throttle: 0.0, brake: 0.0, ..wheel.state.controls() };
                        news.push(RigNews::Lost(wheel.name));
                    }
                }
                Told::Trouble(text) => {
                    log::warn!("{text}");
                    news.push(RigNews::Trouble(text));
                }
            }
        }
        (touched, news)
    }

    fn plug(&mut self, found: Found) {
        let mut state = WheelState::new(found.profile, found.values);
        state.set_reverse(self.left.selector == Selector::Reverse);
        let force = found.force.map(|device| ForceLoop::new(device, state.profile()));
        let force = force.map(|force| ForceThread::start(force, found.angle));
        let force = force.and_then(|started| started.map_err(|e| log::warn!("no thread for the force: {e}")).ok());
        self.wheel = Some(Plugged { name: found.name, state, force });
    }

    /// What the wheel asks of the car; without one the pedals are released and the wheel stands where it was.
    pub fn controls(&self) -> Controls {
        self.wheel.as_ref().map_or(self.left, |wheel| wheel.state.controls())
    }

    /// What the hands are to feel.
    pub fn feel(&self, feel: Feel) {
        if let Some(force) = self.wheel.as_ref().and_then(|wheel| wheel.force.as_ref()) {
            force.tell(feel);
        }
    }

    /// The torque that was last sent, N m, positive to the left; `None` where none is.
    pub fn torque_nm(&self) -> Option<f64> {
        Some(self.wheel.as_ref()?.force.as_ref()?.torque_nm())
    }

    /// The selector is in drive.
    pub fn select_drive(&mut self) {
        self.left.selector = Selector::Drive;
        if let Some(wheel) = &mut self.wheel {
            wheel.state.set_reverse(false);
        }
    }

    /// When the newest input came that has not been asked for yet.
    pub fn newest_input(&mut self) -> Option<Stamp> {
        self.newest.take()
    }

    /// The profile of the wheel that is plugged in.
    pub fn profile(&self) -> Option<&Profile> {
        Some(self.wheel.as_ref()?.state.profile())
    }

    /// The wheel in words.
    pub fn describe(&self) -> String {
        let Some(wheel) = &self.wheel else { return "wheel unplugged".into() };
        let force = if wheel.force.is_some() { "with force" } else { "without force" };
        format!("{}, profile {}, {force}", wheel.name, wheel.state.profile().name)
    }
}

#[cfg(target_os = "linux")]
fn start(asked: Option<Profile>) -> Option<(ReadingThread, Receiver<Told>)> {
    let started = ReadingThread::start(super::linux::EvdevPort::new(asked));
    started.map_err(|e| log::warn!("wheels cannot be read: {e}")).ok()
}

#[cfg(not(target_os = "linux"))]
fn start(_asked: Option<Profile>) -> Option<(ReadingThread, Receiver<Told>)> {
    None
}

#[cfg(test)]
#[path = "rig_tests.rs"]
mod tests;
