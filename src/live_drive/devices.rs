//! Effect of the participant's devices on the drive, and feedback to them. In: the rig's events, the present moment.
//! Out: pauses, marks and requests of the participant; force, horn, rev lamps and the LED of the detection response task.

use super::{LiveDrive, sound};
use crate::{
    ego::GroundSurface,
    input::{AdviceState, ButtonAction, ForceInput, RigEvent},
    scene::ViewKind,
    snapshot::TaskPicture,
    time::Pace,
};

/// Name of the recorded event for the LED of the detection response task; the detail is `on`, `off`, or the reason why the signal is on the screen
/// instead.
pub const REMOTE_LED: &str = "remote_led";

/// Present signal of a detection response task with an LED.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum LedSignal {
    /// No signal is on.
    #[default]
    Off,
    /// The LED is lit.
    Lit,
    /// The LED could not be lit: the signal is on the screen.
    OnScreen,
}

impl LiveDrive {
    /// Updates force, sound and lamps for the present moment.
    pub(super) fn update_rig(&mut self) {
        let force_input = self.force_input();
        if force_input.pulse > 0.0 && !self.devices.has_force() && !std::mem::replace(&mut self.is_pulse_missed, true) {
            self.trouble("no wheel has force feedback: pulses of events are not felt".into());
        }
        self.devices.set_force_input(force_input);
        let horn = self.devices.horn();
        if self.sound.frame(self.running(), horn) {
            self.note(sound::HORN, if horn { "on" } else { "off" });
        }
        let world = &self.drive.world;
        let is_paused = self.drive.clock.pace() == Pace::Paused && world.ended().is_none();
        if let Some((kind, sentence)) = self.sound.speak(world.snapshot().tick, is_paused) {
            if kind == sound::SPOKEN_DIGIT {
                self.digits.heard();
            }
            self.note(kind, &sentence);
        }
        if let Some(fault) = self.sound.take_fault() {
            log::warn!("{fault}");
            self.news.push(fault);
        }
        let scenario = self.drive.world.scenario();
        let (shows_advice, has_led) = (scenario.rev_lamps, scenario.secondary_task.has_led());
        if has_led {
            self.show_signal();
        }
        // Rev lamps that are the task's signal do not show the advice.
        if shows_advice && (!has_led || self.devices.rig().has_led()) {
            let advice_state = self.advice_state();
            if let Some(trouble) = self.devices.rig_mut().show_advice_state(advice_state) {
                log::warn!("{trouble}");
                self.news.push(trouble);
            }
        }
    }

    /// Lights the LED while the signal of the detection response task is on, and records when it was written. A signal that cannot be lit is shown on
    /// the screen.
    fn show_signal(&mut self) {
        let world = &self.drive.world;
        let is_on = world.snapshot().task.shown == TaskPicture::Signal && world.ended().is_none();
        match (is_on, self.led_signal) {
            (false, LedSignal::Off) | (true, LedSignal::OnScreen) => {}
            (false, LedSignal::OnScreen) => self.led_signal = LedSignal::Off,
            (false, LedSignal::Lit) => {
                self.led_signal = LedSignal::Off;
                let dark = self.devices.rig_mut().show_signal(false);
                self.note(REMOTE_LED, &dark.err().unwrap_or_else(|| "off".into()));
            }
            // Also while it is lit: the wheel may have been unplugged.
            (true, before) => match self.devices.rig_mut().show_signal(true) {
                Ok(()) if before == LedSignal::Lit => {}
                Ok(()) => {
                    self.led_signal = LedSignal::Lit;
                    self.note(REMOTE_LED, "on");
                }
                Err(why) => {
                    self.led_signal = LedSignal::OnScreen;
                    self.note(REMOTE_LED, &format!("on the screen: {why}"));
                    if !std::mem::replace(&mut self.is_led_missed, true) {
                        self.news.push(format!("signals are on the screen: {why}"));
                    }
                }
            },
        }
    }

    /// Darkens the LED of a signal that is on, before another drive.
    pub(super) fn darken_led(&mut self) {
        if std::mem::take(&mut self.led_signal) == LedSignal::Lit {
            // A lamp that has gone is dark.
            let _ = self.devices.rig_mut().show_signal(false);
        }
    }

    /// Checks whether time runs.
    pub(super) fn running(&self) -> bool {
        let world = &self.drive.world;
        self.drive.clock.pace() != Pace::Paused && world.ended().is_none() && !world.is_stopped()
    }

    /// Compares the speed with the advised range.
    pub(super) fn advice_state(&self) -> AdviceState {
        let snapshot = self.drive.world.snapshot();
        match snapshot.advice {
            None => AdviceState::None,
            Some(advice) if advice.accepts(snapshot.ego.speed_mps) => AdviceState::Within,
            Some(advice) if snapshot.ego.speed_mps < advice.target_mps => AdviceState::Below,
            Some(_) => AdviceState::Above,
        }
    }

    /// Returns the inputs of the force feedback for the present tick.
    pub(super) fn force_input(&self) -> ForceInput {
        let world = &self.drive.world;
        let ego = &world.snapshot().ego;
        let automation = &world.snapshot().automation;
        let driven = automation.driven.filter(|_| automation.steers_now());
        let of_events = world.snapshot().stimuli.as_ref().map_or(0.0, |stimuli| stimuli.wheel_pulse);
        let on_grass = ego.wheels[..2].iter().filter(|wheel| wheel.surface == GroundSurface::Grass).count();
        ForceInput {
            aligning_nm: ego.steering_torque_nm.into(),
            speed_mps: ego.speed_mps,
            grass: on_grass as f64 / 2.0,
            contact: self.contacts.jolt().strength,
            pulse: of_events.max(automation.wheel_pulse(world.snapshot().tick)),
            held_rad: driven.map(|driven| driven.steering_wheel_rad.into()),
            running: self.running(),
        }
    }

    /// Reads the devices. An unplugged wheel pauses the drive until it is plugged in again; buttons perform their
    /// actions.
    pub(super) fn poll_devices(&mut self) {
        if self.drive.clock.pace() != Pace::Paused {
            self.waiting = false;
        }
        for news in self.devices.poll() {
            match news {
                RigEvent::Connected(name) => {
                    self.note("wheel plugged in", &self.devices.describe());
                    self.note_profile();
                    if std::mem::take(&mut self.waiting) {
                        self.drive.clock.set_pace(Pace::RealTime);
                        self.news.push(format!("{name} is back: the drive continues"));
                    }
                }
                RigEvent::Disconnected(name) => {
                    self.note("wheel unplugged", &name);
                    self.news.push(format!("{name} was unplugged: pedals are released"));
                    if self.drive.clock.pace() == Pace::RealTime {
                        self.drive.clock.set_pace(Pace::Paused);
                        self.waiting = true;
                    }
                }
                RigEvent::Pressed(action) => self.pressed(action),
                RigEvent::Trouble(text) => self.trouble(text),
            }
        }
        if !self.running() {
            self.devices.forget_presses();
        }
        self.latency.read(self.devices.newest_input());
    }

    /// Records what a wheel does not do, and says so.
    fn trouble(&mut self, text: String) {
        self.note("wheel trouble", &text);
        self.news.push(text);
    }

    /// Puts the ego back on its lane, if it has left it and there is room.
    pub fn put_back(&mut self) {
        let result = self.drive.world.put_back();
        self.news.push(result.map_or_else(|why| why.to_string(), |()| "the vehicle is back on its lane".into()));
    }

    /// Performs the action of a button, or collects it in a session.
    fn pressed(&mut self, action: ButtonAction) {
        if action == ButtonAction::Recentre && self.drive.world.is_astray() {
            return self.put_back();
        }
        if self.led {
            if action == ButtonAction::Abort {
                // Before the ticks of this frame.
                self.hold(true);
            }
            self.pressed.push(action);
            return;
        }
        match action {
            // The devices have applied these already.
            ButtonAction::Reverse | ButtonAction::Horn | ButtonAction::Handbrake => {}
            ButtonAction::IndicateLeft | ButtonAction::IndicateRight | ButtonAction::MainBeam => {}
            ButtonAction::Respond | ButtonAction::Automation | ButtonAction::TimeGap => {}
            ButtonAction::Up | ButtonAction::Down | ButtonAction::Left | ButtonAction::Right => {}
            ButtonAction::Start => self.drive.clock.set_pace(Pace::RealTime),
            ButtonAction::Recentre => self.picture.kind = ViewKind::Driver,
            ButtonAction::Mark => {
                self.note("mark", "by the participant");
                self.news.push("marked".into());
            }
            ButtonAction::Answer => self.note("answer", "button"),
            ButtonAction::Abort => {
                self.note("abort asked for", "button");
                self.drive.clock.set_pace(Pace::Paused);
                self.news.push("the participant asks to end the drive: Esc ends it, Space continues".into());
            }
        }
    }

    /// Records the wheel's whole profile.
    pub(super) fn note_profile(&mut self) {
        if let Some(profile) = self.devices.wheel_profile().map(crate::input::WheelProfile::to_toml) {
            self.note("wheel profile", &profile);
        }
    }

    /// Checks whether the drive is paused because the wheel was unplugged.
    pub fn waits_for_wheel(&self) -> bool {
        self.waiting && self.drive.clock.pace() == Pace::Paused
    }

    /// Returns the messages for the overlay since the last call.
    pub fn take_news(&mut self) -> Vec<String> {
        std::mem::take(&mut self.news)
    }

    /// Returns the button actions since the last call, in a session.
    pub fn take_pressed(&mut self) -> Vec<ButtonAction> {
        std::mem::take(&mut self.pressed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        input::{Devices, Rig, wheel::WheelMessage},
        scenario::Scenario,
    };
    use std::time::Duration;

    #[test]
    fn a_pulse_reaches_the_force_and_without_force_is_reported_once() {
        let text = "traffic = \"native\"\nvehicles = 2\ntrees = 0\n[[event]]\nname = \"a\"\ntrigger = { time_s = 0.5 }\n\
             actions = [{ wheel_pulse = { strength = 0.5, for_s = 1 } }]\n";
        let scenario = Scenario::from_toml(text, "pulse.toml").expect("a scenario");
        let (_, messages) = std::sync::mpsc::channel::<WheelMessage>();
        let devices = Devices::with_rig(Rig::fed_by(messages));
        let mut live = LiveDrive::new(&scenario, Pace::RealTime, devices).expect("the native engine");
        let (mut pulses, mut news) = (Vec::new(), Vec::new());
        for _ in 0..20 {
            live.advance(Duration::from_millis(100), |_| ()).expect("the native engine");
            pulses.push(live.force_input().pulse);
            news.extend(live.take_news());
        }
        assert_eq!(pulses.iter().filter(|pulse| **pulse == 0.5).count(), 10, "1 s: {pulses:?}");
        assert_eq!(news, ["no wheel has force feedback: pulses of events are not felt"]);
    }
}
