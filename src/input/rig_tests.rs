//! The wheel over a session with a simulated port: start, 500 disconnections, force to the device.

use super::*;
use crate::input::{
    force_thread::{ForceDevice, SharedAngle},
    profiles,
    reader::{WheelPort, WheelReader},
};
use std::{
    collections::BTreeMap,
    io,
    sync::{Arc, Mutex},
};

/// Values of a G29 at rest.
fn rest() -> BTreeMap<u16, i32> {
    [(0, 32_767), (1, 255), (2, 255), (5, 255)].into()
}

/// A G29 at rest as the reading thread reports it.
fn found(force: Option<Box<dyn ForceDevice>>) -> FoundWheel {
    let axes = [(0, [0, 65_535]), (1, [0, 255]), (2, [0, 255]), (5, [0, 255])];
    let device = UnprofiledDevice {
        name: "G29".into(),
        id: (0x046d, 0xc24f),
        axes: axes.into(),
        values: rest(),
        ..UnprofiledDevice::default()
    };
    let profile = profiles::named("g29").unwrap();
    FoundWheel { device, profile, lamps: Lamps::default(), force, angle: Arc::new(SharedAngle::default()) }
}

/// Levels sent to a wheel, in order; `None` is the end.
#[derive(Clone, Default)]
struct Log(Arc<Mutex<Vec<Option<i16>>>>);

impl ForceDevice for Log {
    fn set(&mut self, level: i16) -> io::Result<()> {
        self.0.lock().unwrap().push(Some(level));
        Ok(())
    }

    fn end(&mut self) {
        self.0.lock().unwrap().push(None);
    }
}

/// A simulated port whose wheel is unplugged after each batch of events.
struct Pulled {
    batches: Vec<Vec<(u16, i32)>>,
    force: Option<Log>,
}

impl WheelPort for Pulled {
    type Wheel = Option<Vec<(u16, i32)>>;

    fn find(&mut self, report: &mut dyn FnMut(String)) -> Option<(FoundWheel, Self::Wheel)> {
        if self.batches.is_empty() {
            report("nothing is plugged in".into());
            return None;
        }
        let force = self.force.clone().map(|log| Box::new(log) as Box<dyn ForceDevice>);
        let found = found(force);
        Some((found, Some(self.batches.remove(0))))
    }

    fn prefer(&mut self, _profile: WheelProfile) {}

    fn read(&mut self, wheel: &mut Self::Wheel, messages: &mut Vec<WheelMessage>) -> io::Result<()> {
        let events = wheel.take().ok_or(io::ErrorKind::NotConnected)?;
        messages.extend(events.into_iter().map(|(code, raw)| WheelMessage::Axis { code, raw, at: None }));
        Ok(())
    }
}

#[test]
fn a_wheel_works_after_each_of_500_disconnections() {
    let log = Log::default();
    let batches = vec![vec![(0, 40_000), (2, 100), (5, 30)]; 500];
    let (mut reader, messages) = WheelReader::new(Pulled { batches, force: Some(log.clone()) });
    let mut rig = Rig::fed_by(messages);
    for _ in 0..500 {
        assert!(reader.turn());
        assert_eq!(rig.poll(), (false, vec![RigEvent::Connected("G29".into())]));
        assert_eq!((rig.controls().throttle, rig.controls().brake), (0.0, 0.0), "at rest before any event");
        assert!(reader.turn());
        assert_eq!(rig.poll(), (true, vec![]));
        let driving = rig.controls();
        assert!(driving.throttle > 0.5 && driving.brake > 0.5 && driving.steering_wheel_rad < 0.0);
        assert!(reader.turn());
        assert_eq!(rig.poll(), (false, vec![RigEvent::Disconnected("G29".into())]));
        assert_eq!(
            rig.controls(),
            Controls { throttle: 0.0, brake: 0.0, ..driving },
            "pedals up, no jerk of the wheel"
        );
        assert_eq!(rig.describe(), "wheel unplugged");
    }
    assert!(!reader.turn() && !reader.turn());
    assert_eq!(rig.poll().1, [RigEvent::Trouble("nothing is plugged in".into())], "said once");
    let log = log.0.lock().unwrap();
    assert_eq!(log.iter().filter(|entry| entry.is_none()).count(), 500, "every force was ended");
}

#[test]
fn a_drive_keeps_its_selector_when_the_wheel_comes_back() {
    let (to, messages) = std::sync::mpsc::channel();
    let mut rig = Rig::fed_by(messages);
    let plug = || WheelMessage::Connected(Box::new(found(None)));
    to.send(plug()).unwrap();
    to.send(WheelMessage::Button { code: 293, down: true, at: None }).unwrap();
    to.send(WheelMessage::Button { code: 297, down: true, at: None }).unwrap();
    let (touched, news) = rig.poll();
    assert!(touched);
    assert_eq!(news[1..], [RigEvent::Pressed(ButtonAction::Reverse), RigEvent::Pressed(ButtonAction::Start)]);
    to.send(WheelMessage::Lost).unwrap();
    to.send(plug()).unwrap();
    rig.poll();
    assert_eq!(rig.controls().selector, Selector::Reverse);
    // Before the next drive the selector is put into drive, also for a wheel that comes later.
    rig.select_drive();
    assert_eq!(rig.controls().selector, Selector::Drive);
    to.send(WheelMessage::Lost).unwrap();
    to.send(plug()).unwrap();
    rig.poll();
    assert_eq!(rig.controls().selector, Selector::Drive);
}

#[test]
fn a_press_of_a_button_of_the_automation_lasts_one_tick() {
    let (to, messages) = std::sync::mpsc::channel();
    let mut devices = crate::input::Devices::with_rig(Rig::fed_by(messages));
    to.send(WheelMessage::Connected(Box::new(found(None)))).unwrap();
    // 299 is L3 and 707 the plus button of a G29.
    for (code, pressed) in [(299, [true, false]), (707, [false, true])] {
        to.send(WheelMessage::Button { code, down: true, at: None }).unwrap();
        devices.poll();
        let buttons = [(); 2].map(|()| {
            let controls = devices.controls(5.0, None);
            [controls.automation_button, controls.gap_button]
        });
        assert_eq!(buttons, [pressed, [false, false]], "{code}");
    }
}

#[test]
fn a_wheel_that_its_motor_turns_is_not_touched() {
    let (to, messages) = std::sync::mpsc::channel();
    let mut rig = Rig::fed_by(messages);
    to.send(WheelMessage::Connected(Box::new(found(Some(Box::new(Log::default())))))).unwrap();
    rig.poll();
    let mut touched = |held_rad, code, raw| {
        rig.set_force_input(ForceInput { held_rad, ..ForceInput::default() });
        to.send(WheelMessage::Axis { code, raw, at: None }).unwrap();
        rig.poll().0
    };
    // The steering axis by 14 degrees, then the accelerator, with an automation that steers and without one.
    assert_eq!([touched(Some(0.2), 0, 31_767), touched(Some(0.2), 2, 100)], [false, true]);
    assert!(touched(None, 0, 32_767));
}

#[test]
fn the_newest_time_stamp_is_returned_once() {
    let (to, messages) = std::sync::mpsc::channel();
    let mut rig = Rig::fed_by(messages);
    to.send(WheelMessage::Connected(Box::new(found(None)))).unwrap();
    let at = |ms| Some(TimeStamp(std::time::Duration::from_millis(ms)));
    for (raw, ms) in [(40_000, 500), (41_000, 510), (41_500, 505)] {
        to.send(WheelMessage::Axis { code: 0, raw, at: at(ms) }).unwrap();
    }
    rig.poll();
    assert_eq!(rig.newest_input(), at(510));
    assert_eq!(rig.newest_input(), None);
}

#[test]
fn the_force_thread_ends_the_force_when_it_is_dropped() {
    let log = Log::default();
    let profile = profiles::named("g29").unwrap();
    let force = ForceLoop::new(Box::new(log.clone()), &profile);
    let angle = Arc::new(SharedAngle::default());
    let thread = ForceThread::start(force, angle).unwrap();
    thread.set_input(ForceInput {
        aligning_nm: 4.0,
        speed_mps: 10.0,
        grass: 0.0,
        contact: 0.0,
        pulse: 0.0,
        held_rad: None,
        running: true,
    });
    drop(thread);
    assert_eq!(log.0.lock().unwrap().last(), Some(&None));
}

/// A simulated port whose wheel is always present and has the preferred profile; its force is logged.
struct Kept {
    profile: WheelProfile,
    log: Log,
}

impl WheelPort for Kept {
    type Wheel = ();

    fn find(&mut self, _say: &mut dyn FnMut(String)) -> Option<(FoundWheel, ())> {
        Some((FoundWheel { profile: self.profile.clone(), ..found(Some(Box::new(self.log.clone()))) }, ()))
    }

    fn prefer(&mut self, profile: WheelProfile) {
        self.profile = profile;
    }

    fn read(&mut self, (): &mut (), _told: &mut Vec<WheelMessage>) -> io::Result<()> {
        std::thread::sleep(std::time::Duration::from_millis(1));
        Ok(())
    }
}

#[test]
fn a_new_profile_reopens_the_wheel_after_the_old_force_has_ended() {
    let log = Log::default();
    let (thread, messages) =
        ReadingThread::start(Kept { profile: profiles::named("g29").unwrap(), log: log.clone() }).unwrap();
    let mut rig = Rig { thread: Some(thread), ..Rig::fed_by(messages) };
    // Up to 10 s, for slow computers.
    let until = |rig: &mut Rig, name: &str| {
        let there = |rig: &Rig| rig.profile().is_some_and(|profile| profile.name == name);
        for _ in 0..1000 {
            rig.poll();
            if there(rig) {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        panic!("no wheel with the profile {name}");
    };
    until(&mut rig, "Logitech G29");
    rig.calibrate().unwrap();
    assert!(rig.calibration().is_some() && rig.take_torque_nm().is_some());
    rig.take(WheelProfile { name: "Rig 1".into(), ..profiles::named("g29").unwrap() });
    assert!(rig.calibration().is_none() && rig.take_torque_nm().is_none());
    assert_eq!(log.0.lock().unwrap().last(), Some(&None), "the old force has ended before the new one begins");
    until(&mut rig, "Rig 1");
    assert!(rig.take_torque_nm().is_some());
    rig.calibrate().unwrap();
    rig.end_calibration();
    assert!(rig.calibration().is_none());
}

#[test]
fn a_thread_without_a_wheel_searches_every_half_second() {
    #[derive(Clone, Default)]
    struct Looks(Arc<Mutex<usize>>);
    impl WheelPort for Looks {
        type Wheel = ();

        fn find(&mut self, _say: &mut dyn FnMut(String)) -> Option<(FoundWheel, ())> {
            *self.0.lock().unwrap() += 1;
            None
        }

        fn prefer(&mut self, _profile: WheelProfile) {}

        fn read(&mut self, (): &mut (), _told: &mut Vec<WheelMessage>) -> io::Result<()> {
            Ok(())
        }
    }
    let looks = Looks::default();
    let (thread, _told) = ReadingThread::start(looks.clone()).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(400));
    let seen = *looks.0.lock().unwrap();
    drop(thread);
    assert!((1..=2).contains(&seen), "{seen} looks in 0.4 s");
}

#[test]
fn each_push_of_the_d_pad_is_one_action_and_drives_nothing() {
    let (to, messages) = std::sync::mpsc::channel();
    let mut rig = Rig::fed_by(messages);
    to.send(WheelMessage::Connected(Box::new(found(None)))).unwrap();
    rig.poll();
    let before = rig.controls();
    // The G29's d-pad is a hat: ABS_HAT0X and ABS_HAT0Y, -1 left and up, 0 released. The kernel may report a value
    // twice.
    for (code, raw) in [(16, -1), (16, -1), (16, 0), (16, 1), (16, 0), (17, -1), (17, 0), (17, 1), (17, 0)] {
        to.send(WheelMessage::Axis { code, raw, at: None }).unwrap();
    }
    let (touched, news) = rig.poll();
    use ButtonAction as B;
    assert_eq!(news, [B::Left, B::Right, B::Up, B::Down].map(RigEvent::Pressed));
    assert!(!touched, "whoever drives by keys goes on");
    assert_eq!(rig.controls(), before);
    // A d-pad that consists of buttons has the same actions.
    for code in [546, 547, 544, 545] {
        to.send(WheelMessage::Button { code, down: true, at: None }).unwrap();
        to.send(WheelMessage::Button { code, down: false, at: None }).unwrap();
    }
    assert_eq!(rig.poll().1, [B::Left, B::Right, B::Up, B::Down].map(RigEvent::Pressed));
    assert_eq!(rig.controls(), before);
}
