//! The participant's wheel over a whole session: plugged in, unplugged, plugged in again. In: what the reading thread tells.
//! Out: controls, news for people, and force while there is a wheel that takes it.

use super::{
    buttons::ButtonAction,
    calibrate::Calibration,
    clock::TimeStamp,
    force::ForceInput,
    force_thread::{ForceLoop, ForceThread},
    lamps::{self, AdviceState, Lamps},
    profile::{ProfileError, WheelProfile},
    profiles::UnprofiledDevice,
    reader::ReadingThread,
    wheel::{FoundWheel, WheelMessage, WheelState},
};
use crate::controls::{Controls, Selector};
use std::sync::mpsc::Receiver;

/// What happened to the wheel that someone has to know.
#[derive(Clone, Debug, PartialEq)]
pub enum RigEvent {
    /// A wheel is there, or there again: its name.
    Connected(String),
    /// It was unplugged: its name.
    Disconnected(String),
    /// A button with a meaning was pressed.
    Pressed(ButtonAction),
    /// Something is wrong, and its remedy.
    Trouble(String),
}

/// The wheel, or the place for one.
pub struct Rig {
    told: Receiver<WheelMessage>,
    wheel: Option<ConnectedWheel>,
    /// What holds while there is none: pedals up, the wheel where it was.
    left: Controls,
    newest: Option<TimeStamp>,
    /// Questions that are being asked, and since when.
    calibration: Option<(Calibration, TimeStamp)>,
    last_button: Option<u16>,
    /// True once it was said that there are no lamps.
    lamps_told: bool,
    /// The last: its end is waited for after all else is let go.
    thread: Option<ReadingThread>,
}

struct ConnectedWheel {
    device: UnprofiledDevice,
    state: WheelState,
    lamps: Lamps,
    force: Option<ForceThread>,
}

impl Rig {
    /// Looks for wheels from now on; `asked` is a profile that a person named.
    pub fn open(asked: Option<WheelProfile>) -> Self {
        let started = start(asked);
        let (thread, told) = match started {
            Some((thread, told)) => (Some(thread), told),
            None => (None, std::sync::mpsc::channel().1),
        };
        Self { thread, ..Self::fed_by(told) }
    }

    /// A wheel that is told of by whoever holds the other end.
    pub fn fed_by(told: Receiver<WheelMessage>) -> Self {
        Self {
            told,
            wheel: None,
            left: Controls::default(),
            newest: None,
            calibration: None,
            last_button: None,
            lamps_told: false,
            thread: None,
        }
    }

    /// Takes in what happened since the last call. True if a hand or foot moved something.
    pub fn poll(&mut self) -> (bool, Vec<RigEvent>) {
        let (mut touched, mut news) = (false, Vec::new());
        while let Ok(told) = self.told.try_recv() {
            match told {
                WheelMessage::Connected(found) => {
                    log::info!("found {} (profile {})", found.device.name, found.profile.name);
                    news.push(RigEvent::Connected(found.device.name.clone()));
                    self.plug(*found);
                }
                WheelMessage::Axis { code, raw, at } => {
                    if let Some(wheel) = &mut self.wheel {
                        touched |= wheel.state.moved(code, raw);
                        if let Some(action) = wheel.state.hat(code, raw) {
                            news.push(RigEvent::Pressed(action));
                        }
                        self.newest = self.newest.max(at);
                        if let Some((calibration, began)) = &mut self.calibration {
                            let at_s = began.until(at.unwrap_or_else(TimeStamp::now)).as_secs_f64();
                            calibration.moved(code, raw, at_s);
                        }
                    }
                }
                WheelMessage::Button { code, down: false, .. } => {
                    if let Some(wheel) = &mut self.wheel {
                        wheel.state.released(code);
                    }
                }
                WheelMessage::Button { code, at, .. } => {
                    self.last_button = Some(code);
                    if let Some(action) = self.wheel.as_mut().and_then(|wheel| wheel.state.pressed(code)) {
                        touched = true;
                        self.newest = self.newest.max(at);
                        news.push(RigEvent::Pressed(action));
                    }
                }
                WheelMessage::Lost => {
                    self.calibration = None;
                    if let Some(wheel) = self.wheel.take() {
                        log::warn!("{} was unplugged: its pedals count as released", wheel.device.name);
                        self.left = Controls { throttle: 0.0, brake: 0.0, ..wheel.state.controls() };
                        news.push(RigEvent::Disconnected(wheel.device.name.clone()));
                    }
                }
                WheelMessage::Trouble(text) => {
                    log::warn!("{text}");
                    news.push(RigEvent::Trouble(text));
                }
            }
        }
        if let Some((calibration, began)) = &mut self.calibration {
            calibration.time(began.until(TimeStamp::now()).as_secs_f64());
        }
        (touched, news)
    }

    fn plug(&mut self, found: FoundWheel) {
        // The old one's force ends before the new one's begins.
        self.calibration = None;
        if let Some(old) = self.wheel.take() {
            self.left = old.state.controls();
        }
        let mut state = WheelState::new(found.profile, found.device.values.clone());
        state.set_reverse(self.left.selector == Selector::Reverse);
        let force = found.force.map(|device| ForceLoop::new(device, state.profile()));
        let force = force.map(|force| ForceThread::start(force, found.angle));
        let force = force.and_then(|started| started.map_err(|e| log::warn!("no thread for the force: {e}")).ok());
        self.wheel = Some(ConnectedWheel { device: found.device, state, lamps: found.lamps, force });
    }

    /// What the wheel asks of the car; without one the pedals are released and the wheel stands where it was.
    pub fn controls(&self) -> Controls {
        self.wheel.as_ref().map_or(self.left, |wheel| wheel.state.controls())
    }

    /// Inputs of the force feedback.
    pub fn set_force_input(&self, feel: ForceInput) {
        if let Some(force) = self.wheel.as_ref().and_then(|wheel| wheel.force.as_ref()) {
            force.set_input(feel);
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

    /// True while the horn is held on the wheel.
    pub fn horn(&self) -> bool {
        self.wheel.as_ref().is_some_and(|wheel| wheel.state.horn())
    }

    /// Shows on the wheel's rev lamps how the speed stands to the advice. The first time that this cannot be done: why.
    pub fn show_advice_state(&mut self, advice_state: AdviceState) -> Option<String> {
        let trouble = match &mut self.wheel {
            Some(wheel) if wheel.lamps.count() == 0 => format!("{} has no rev lamps", wheel.device.name),
            Some(wheel) => match wheel.lamps.show(advice_state) {
                Ok(()) => return None,
                Err(error) => format!(
                    "the rev lamps stay as they are ({error})\n  remedy: add this line to the wheel's udev rules\n    {}",
                    lamps::UDEV_RULE
                ),
            },
            None => "no wheel with rev lamps is plugged in".into(),
        };
        (!std::mem::replace(&mut self.lamps_told, true)).then_some(trouble)
    }

    /// Begins to ask about the wheel that is plugged in.
    ///
    /// # Errors
    /// There is none, or it has too few axes.
    pub fn calibrate(&mut self) -> Result<(), ProfileError> {
        let text = "no steering wheel is plugged in\n  remedy: plug it in, wait for its turn, and begin again";
        let wheel = self.wheel.as_ref().ok_or_else(|| ProfileError(text.into()))?;
        let mut device = wheel.device.clone();
        device.values.extend(wheel.state.raw());
        self.calibration = Some((Calibration::new(device, 0.0)?, TimeStamp::now()));
        Ok(())
    }

    /// The questions, while they are asked.
    pub fn calibration(&self) -> Option<&Calibration> {
        self.calibration.as_ref().map(|(calibration, _)| calibration)
    }

    /// Asks no more.
    pub fn end_calibration(&mut self) {
        self.calibration = None;
    }

    /// Takes the wheel anew with this profile.
    pub fn take(&mut self, profile: WheelProfile) {
        self.calibration = None;
        if let Some(wheel) = &mut self.wheel {
            // Its end sets the device's own centring, which must not come after the new one's beginning.
            wheel.force = None;
        }
        if let Some(thread) = &self.thread {
            thread.prefer(profile);
        }
    }

    /// The wheel's last raw values, and the button that was pressed last.
    pub fn raw(&self) -> Option<(&UnprofiledDevice, &std::collections::BTreeMap<u16, i32>, Option<u16>)> {
        let wheel = self.wheel.as_ref()?;
        Some((&wheel.device, wheel.state.raw(), self.last_button))
    }

    /// When the newest input came that has not been asked for yet.
    pub fn newest_input(&mut self) -> Option<TimeStamp> {
        self.newest.take()
    }

    /// The profile of the wheel that is plugged in.
    pub fn profile(&self) -> Option<&WheelProfile> {
        Some(self.wheel.as_ref()?.state.profile())
    }

    /// The wheel in words.
    pub fn describe(&self) -> String {
        let Some(wheel) = &self.wheel else { return "wheel unplugged".into() };
        let force = if wheel.force.is_some() { "with force" } else { "without force" };
        format!("{}, profile {}, {force}", wheel.device.name, wheel.state.profile().name)
    }
}

#[cfg(target_os = "linux")]
fn start(asked: Option<WheelProfile>) -> Option<(ReadingThread, Receiver<WheelMessage>)> {
    let started = ReadingThread::start(super::linux::EvdevPort::new(asked));
    started.map_err(|e| log::warn!("wheels cannot be read: {e}")).ok()
}

#[cfg(not(target_os = "linux"))]
fn start(_asked: Option<WheelProfile>) -> Option<(ReadingThread, Receiver<WheelMessage>)> {
    None
}

#[cfg(test)]
#[path = "rig_tests.rs"]
mod tests;
