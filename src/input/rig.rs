//! The participant's wheel over a session, in which it may be unplugged and plugged in again. In: messages of the
//! reading thread. Out: controls, events for people, and force while a wheel takes it.

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

/// Event of the wheel that concerns people.
#[derive(Clone, Debug, PartialEq)]
pub enum RigEvent {
    /// A wheel was plugged in, by name.
    Connected(String),
    /// The wheel was unplugged, by name.
    Disconnected(String),
    /// A button with an action was pressed.
    Pressed(ButtonAction),
    /// A problem, with its remedy.
    Trouble(String),
}

/// Wheel of the rig, connected or not.
pub struct Rig {
    messages: Receiver<WheelMessage>,
    wheel: Option<ConnectedWheel>,
    /// Controls while no wheel is connected: pedals released, steering as at the disconnection.
    left: Controls,
    newest: Option<TimeStamp>,
    /// Calibration in progress, and the time of its start.
    calibration: Option<(Calibration, TimeStamp)>,
    last_button: Option<u16>,
    /// True while the motor holds the wheel at the angle of an automation: a turn of it is not one by hand.
    is_held: bool,
    /// True once the message about missing lamps was sent.
    lamps_told: bool,
    /// LED for signals in place of the rev lamps.
    led: Option<Lamps>,
    /// Reading thread. The last field, so that it is dropped, and waited for, after all others.
    thread: Option<ReadingThread>,
}

struct ConnectedWheel {
    device: UnprofiledDevice,
    state: WheelState,
    lamps: Lamps,
    force: Option<ForceThread>,
    /// True once the direction of the pedals was checked, which takes a value of each axis.
    checked: bool,
}

impl ConnectedWheel {
    /// Checks the direction of the pedals once all are read. Returns the message for pedals that are refused.
    fn check_pedals(&mut self) -> Option<String> {
        let (profile, raw) = (self.state.profile(), self.state.raw());
        let is_read = profile.foot_pedals().all(|(_, pedal)| raw.contains_key(&pedal.code()));
        if self.checked || !is_read || !raw.contains_key(&profile.steering.axis) {
            return None;
        }
        self.checked = true;
        let text = profile.upside_down_message(&self.device.name);
        profile.pedals_upside_down(&self.device.axes, raw).then(|| {
            self.state.refuse_pedals();
            text
        })
    }
}

impl Rig {
    /// Opens the rig and starts the search for wheels; `asked` is the profile that a person named.
    pub fn open(asked: Option<WheelProfile>) -> Self {
        let started = start(asked);
        let (thread, messages) = match started {
            Some((thread, messages)) => (Some(thread), messages),
            None => (None, std::sync::mpsc::channel().1),
        };
        Self { thread, ..Self::fed_by(messages) }
    }

    /// Creates a rig whose messages come from the other end of this channel.
    pub fn fed_by(messages: Receiver<WheelMessage>) -> Self {
        Self {
            messages,
            wheel: None,
            left: Controls::default(),
            newest: None,
            calibration: None,
            last_button: None,
            is_held: false,
            lamps_told: false,
            led: None,
            thread: None,
        }
    }

    /// Applies the messages since the last call. Returns true if a hand or foot moved something, and the events for
    /// people.
    pub fn poll(&mut self) -> (bool, Vec<RigEvent>) {
        let (mut touched, mut news) = (false, Vec::new());
        while let Ok(message) = self.messages.try_recv() {
            match message {
                WheelMessage::Connected(found) => {
                    log::info!("found {} (profile {})", found.device.name, found.profile.name);
                    news.push(RigEvent::Connected(found.device.name.clone()));
                    self.plug(*found);
                    news.extend(self.check_pedals());
                }
                WheelMessage::Axis { code, raw, at } => {
                    if let Some(wheel) = &mut self.wheel {
                        let is_by_motor = self.is_held && code == wheel.state.profile().steering.axis;
                        touched |= wheel.state.moved(code, raw) && !is_by_motor;
                        if let Some(action) = wheel.state.hat(code, raw) {
                            news.push(RigEvent::Pressed(action));
                        }
                        self.newest = self.newest.max(at);
                        if let Some((calibration, began)) = &mut self.calibration {
                            let at_s = began.until(at.unwrap_or_else(TimeStamp::now)).as_secs_f64();
                            calibration.moved(code, raw, at_s);
                        }
                    }
                    news.extend(self.check_pedals());
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

    fn check_pedals(&mut self) -> Option<RigEvent> {
        let text = self.wheel.as_mut()?.check_pedals()?;
        log::warn!("{text}");
        Some(RigEvent::Trouble(text))
    }

    fn plug(&mut self, found: FoundWheel) {
        // The old wheel's force ends before the new one's begins.
        self.calibration = None;
        if let Some(old) = self.wheel.take() {
            self.left = old.state.controls();
        }
        let mut state = WheelState::new(found.profile, found.device.values.clone());
        state.set_reverse(self.left.selector == Selector::Reverse);
        let force = found.force.map(|device| ForceLoop::new(device, state.profile()));
        let force = force.map(|force| ForceThread::start(force, found.angle));
        let force = force
            .and_then(|started| started.map_err(|e| log::warn!("the thread for the force cannot start: {e}")).ok());
        self.wheel = Some(ConnectedWheel { device: found.device, state, lamps: found.lamps, force, checked: false });
    }

    /// Returns the controls that the wheel asks for; without a wheel the pedals are released and the steering stays.
    pub fn controls(&self) -> Controls {
        self.wheel.as_ref().map_or(self.left, |wheel| wheel.state.controls())
    }

    /// Sets the inputs of the force feedback.
    pub fn set_force_input(&mut self, force_input: ForceInput) {
        self.is_held = force_input.held_rad.is_some() && self.has_force();
        if let Some(force) = self.wheel.as_ref().and_then(|wheel| wheel.force.as_ref()) {
            force.set_input(force_input);
        }
    }

    /// Checks whether a force can be felt now.
    pub fn has_force(&self) -> bool {
        self.wheel.as_ref().is_some_and(|wheel| wheel.force.is_some())
    }

    /// Returns the mean torque that was sent since the last call, N m, positive to the left; `None` without force feedback.
    pub fn take_torque_nm(&self) -> Option<f64> {
        Some(self.wheel.as_ref()?.force.as_ref()?.take_torque_nm())
    }

    /// Returns the estimated torque of the hands, N m, positive to the left; `None` without force feedback.
    pub fn hand_torque_nm(&self) -> Option<f64> {
        self.wheel.as_ref()?.force.as_ref()?.hand_torque_nm()
    }

    /// Puts the selector into drive.
    pub fn select_drive(&mut self) {
        self.left.selector = Selector::Drive;
        if let Some(wheel) = &mut self.wheel {
            wheel.state.set_reverse(false);
        }
    }

    /// Checks whether the horn is held on the wheel.
    pub fn horn(&self) -> bool {
        self.wheel.as_ref().is_some_and(|wheel| wheel.state.horn())
    }

    /// Returns the wheel's rev lamps, or the reason why there are none.
    fn rev_lamps(&mut self) -> Result<&mut Lamps, String> {
        match &mut self.wheel {
            Some(wheel) if wheel.lamps.count() == 0 => Err(format!("{} has no rev lamps", wheel.device.name)),
            Some(wheel) => Ok(&mut wheel.lamps),
            None => Err("no wheel with rev lamps is plugged in".into()),
        }
    }

    /// Shows the advice state on the wheel's rev lamps. Returns the reason the first time that this is impossible.
    pub fn show_advice_state(&mut self, advice_state: AdviceState) -> Option<String> {
        let lamps = self.rev_lamps();
        let shown = lamps.and_then(|lamps| lamps.show(advice_state).map_err(|error| unwritable(&error)));
        shown.err().filter(|_| !std::mem::replace(&mut self.lamps_told, true))
    }

    /// Uses this LED for signals in place of the rev lamps.
    pub fn set_led(&mut self, led: Lamps) {
        self.led = Some(led);
    }

    /// Returns true if signals light an LED other than the rev lamps.
    pub fn has_led(&self) -> bool {
        self.led.is_some()
    }

    /// Lights the LED for signals, or without one all rev lamps; or darkens them.
    ///
    /// # Errors
    /// There is no such lamp, or it cannot be written; the message says why.
    pub fn show_signal(&mut self, is_on: bool) -> Result<(), String> {
        match &mut self.led {
            Some(led) => led.signal(is_on).map_err(|error| {
                format!("the LED stays as it is ({error})\n  remedy: let every user write this file (docs/rig.md)")
            }),
            None => self.rev_lamps()?.signal(is_on).map_err(|error| unwritable(&error)),
        }
    }

    /// Starts the calibration of the connected wheel.
    ///
    /// # Errors
    /// No wheel is connected, or it has too few axes.
    pub fn calibrate(&mut self) -> Result<(), ProfileError> {
        let text = "no steering wheel is plugged in\n  remedy: plug it in, wait until it has turned, and begin again";
        let wheel = self.wheel.as_ref().ok_or_else(|| ProfileError(text.into()))?;
        let mut device = wheel.device.clone();
        device.values.extend(wheel.state.raw());
        self.calibration = Some((Calibration::new(device, 0.0)?, TimeStamp::now()));
        Ok(())
    }

    /// Returns the calibration in progress.
    pub fn calibration(&self) -> Option<&Calibration> {
        self.calibration.as_ref().map(|(calibration, _)| calibration)
    }

    /// Ends the calibration without a result.
    pub fn end_calibration(&mut self) {
        self.calibration = None;
    }

    /// Reopens the wheel with this profile.
    pub fn take(&mut self, profile: WheelProfile) {
        self.calibration = None;
        if let Some(wheel) = &mut self.wheel {
            // Its end sets the device's own centring, and must not come after the start of the new force.
            wheel.force = None;
        }
        if let Some(thread) = &self.thread {
            thread.prefer(profile);
        }
    }

    /// Returns the wheel's device, its last raw values, and the button that was pressed last.
    pub fn raw(&self) -> Option<(&UnprofiledDevice, &std::collections::BTreeMap<u16, i32>, Option<u16>)> {
        let wheel = self.wheel.as_ref()?;
        Some((&wheel.device, wheel.state.raw(), self.last_button))
    }

    /// Returns the time stamp of the newest input since the last call; `None` without input or time stamp.
    pub fn newest_input(&mut self) -> Option<TimeStamp> {
        self.newest.take()
    }

    /// Returns the profile of the connected wheel.
    pub fn profile(&self) -> Option<&WheelProfile> {
        Some(self.wheel.as_ref()?.state.profile())
    }

    /// Returns a description of the wheel for display.
    pub fn describe(&self) -> String {
        let Some(wheel) = &self.wheel else { return "wheel unplugged".into() };
        let force = if wheel.force.is_some() { "with force" } else { "without force" };
        format!("{}, profile {}, {force}", wheel.device.name, wheel.state.profile().name)
    }
}

/// Returns the message for rev lamps that cannot be written.
fn unwritable(error: &std::io::Error) -> String {
    format!(
        "the rev lamps stay as they are ({error})\n  remedy: add this line to the wheel's udev rules\n    {}",
        lamps::UDEV_RULE
    )
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
