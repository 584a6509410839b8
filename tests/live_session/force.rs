//! Force feedback between the loop of a drive and the wheel: a [`LiveDrive`] as its window runs it, a reading thread, and a motor that
//! records the levels sent to it. `tests/wheel/` covers the kernel's part, `tests/window/wheel.rs` the window itself.

use codrive::{
    input::{
        Devices, Rig, WheelProfile,
        force_thread::{ForceDevice, SharedAngle},
        lamps::Lamps,
        profiles::{self, UnprofiledDevice},
        reader::{ReadingThread, WheelPort},
        wheel::{FoundWheel, WheelMessage},
    },
    live_drive::LiveDrive,
    scenario::{DisplaySettings, Scenario},
    time::Pace,
    traffic::EngineChoice,
};
use std::{
    io,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, Receiver, RecvTimeoutError, Sender},
    },
    thread::sleep,
    time::Duration,
};

const STEERING: u16 = 0;
const ACCELERATOR: u16 = 2;
/// Raw steering positions about 50 degrees to either side, roughly what the ring's bend takes.
const LEFT: i32 = 29_100;
const RIGHT: i32 = 36_400;
const STRAIGHT: i32 = 32_767;

/// Message to the motor. A positive level turns towards greater values of the axis: to the right.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sent {
    Level(i16),
    End,
}

#[derive(Clone, Default)]
struct Motor(Arc<Mutex<Vec<Sent>>>);

impl ForceDevice for Motor {
    fn set(&mut self, level: i16) -> io::Result<()> {
        self.0.lock().unwrap().push(Sent::Level(level));
        Ok(())
    }

    fn end(&mut self) {
        self.0.lock().unwrap().push(Sent::End);
    }
}

/// A system with one wheel, plugged in while the flag is set.
struct Desk {
    plugged: Arc<AtomicBool>,
    events: Receiver<(u16, i32)>,
    motor: Motor,
    profile: WheelProfile,
}

impl WheelPort for Desk {
    type Wheel = Arc<SharedAngle>;

    fn find(&mut self, _say: &mut dyn FnMut(String)) -> Option<(FoundWheel, Self::Wheel)> {
        if !self.plugged.load(Ordering::Relaxed) {
            return None;
        }
        let angle = Arc::new(SharedAngle::default());
        let axes = [(0, [0, 65_535]), (1, [0, 255]), (2, [0, 255]), (5, [0, 255])];
        let values = [(STEERING, STRAIGHT), (1, 255), (ACCELERATOR, 255), (5, 255)];
        let device = UnprofiledDevice {
            name: "G29".into(),
            id: (0x046d, 0xc24f),
            axes: axes.into(),
            values: values.into(),
            ..UnprofiledDevice::default()
        };
        let force: Option<Box<dyn ForceDevice>> = Some(Box::new(self.motor.clone()));
        let (profile, lamps) = (self.profile.clone(), Lamps::default());
        Some((FoundWheel { device, profile, lamps, force, angle: Arc::clone(&angle) }, angle))
    }

    fn prefer(&mut self, _profile: WheelProfile) {}

    fn read(&mut self, wheel: &mut Self::Wheel, messages: &mut Vec<WheelMessage>) -> io::Result<()> {
        if !self.plugged.load(Ordering::Relaxed) {
            return Err(io::ErrorKind::NotConnected.into());
        }
        match self.events.recv_timeout(Duration::from_millis(2)) {
            Ok((code, raw)) => {
                if code == STEERING {
                    wheel.set(self.profile.steering.wheel_rad(raw));
                }
                messages.push(WheelMessage::Axis { code, raw, at: None });
                Ok(())
            }
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Err(RecvTimeoutError::Disconnected) => Err(io::ErrorKind::NotConnected.into()),
        }
    }
}

/// A vehicle that rolls on the ring with the accelerator pressed, and the wheel that drives it.
struct Seat {
    // Declared above the reading thread so that the drive is dropped first, as in the program.
    live: LiveDrive,
    motor: Motor,
    plugged: Arc<AtomicBool>,
    hand: Sender<(u16, i32)>,
    _thread: ReadingThread,
}

impl Seat {
    fn new() -> Self {
        let (motor, plugged) = (Motor::default(), Arc::new(AtomicBool::new(true)));
        let (hand, events) = mpsc::channel();
        let profile = profiles::named("g29").unwrap();
        let desk = Desk { plugged: Arc::clone(&plugged), events, motor: motor.clone(), profile };
        let (thread, messages) = ReadingThread::start(desk).unwrap();
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            policy: "none".into(),
            vehicles: 6,
            warm_up_s: 5.0,
            duration_s: 0.0,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let live = LiveDrive::new(&scenario, Pace::RealTime, Devices::with_rig(Rig::fed_by(messages))).unwrap();
        let mut seat = Self { live, motor, plugged, hand, _thread: thread };
        seat.until("the wheel", |seat| seat.live.devices.wheel_profile().is_some());
        seat.put(ACCELERATOR, 100);
        seat
    }

    fn put(&self, code: u16, raw: i32) {
        self.hand.send((code, raw)).unwrap();
    }

    /// Advances the world and the wall clock by 10 ms each.
    fn frame(&mut self) {
        self.live.advance(Duration::from_millis(10), |_| ()).unwrap();
        sleep(Duration::from_millis(10));
    }

    fn frames(&mut self, count: usize) {
        (0..count).for_each(|_| self.frame());
    }

    /// Drives until a condition holds, for at most 3000 frames, about 30 s.
    fn until(&mut self, what: &str, holds: impl Fn(&Self) -> bool) {
        for _ in 0..3000 {
            if holds(self) {
                return;
            }
            self.frame();
        }
        panic!("{what} did not come: {:?}", self.sent());
    }

    fn sent(&self) -> Vec<Sent> {
        self.motor.0.lock().unwrap().clone()
    }

    fn last(&self) -> Option<Sent> {
        self.motor.0.lock().unwrap().last().copied()
    }

    /// Discards the recorded levels.
    fn forget(&self) {
        self.motor.0.lock().unwrap().clear();
    }

    /// Holds the wheel to the left until the motor pushes.
    fn bend(&mut self) {
        self.put(STEERING, LEFT);
        self.until("a push", |seat| matches!(seat.last(), Some(Sent::Level(level)) if level != 0));
        self.frames(40);
    }
}

fn is_force(sent: &Sent) -> bool {
    matches!(sent, Sent::Level(level) if *level != 0)
}

#[test]
fn a_wheel_that_is_held_to_one_side_is_pushed_to_the_other() {
    let mut seat = Seat::new();
    seat.until("some speed", |seat| seat.live.drive.world.snapshot().ego.speed_mps > 4.0);
    for (held, to_the) in [(LEFT, 1), (RIGHT, -1), (LEFT, 1)] {
        seat.put(STEERING, held);
        seat.until(
            "a push back",
            |seat| matches!(seat.last(), Some(Sent::Level(level)) if level.signum() == to_the && level.abs() > 1000),
        );
        // The direction stays the same while the wheel is held still.
        seat.forget();
        seat.frames(40);
        let sent = seat.sent();
        assert!(sent.iter().all(|sent| matches!(sent, Sent::Level(level) if level.signum() != -to_the)), "{sent:?}");
        let torque_nm = seat.live.devices.take_torque_nm().unwrap();
        assert_eq!(torque_nm.signum(), -f64::from(to_the), "{torque_nm}: positive turns to the left");
    }
}

#[test]
fn no_force_during_a_pause_even_if_the_wheel_is_turned() {
    let mut seat = Seat::new();
    seat.bend();
    seat.live.toggle_pause();
    seat.frame();
    seat.until("no force", |seat| seat.last() == Some(Sent::Level(0)));
    seat.forget();
    for held in [RIGHT, LEFT, 1000, STRAIGHT] {
        seat.put(STEERING, held);
        seat.frames(15);
    }
    assert!(!seat.sent().iter().any(is_force), "{:?}", seat.sent());
    assert_eq!(seat.live.devices.take_torque_nm(), Some(0.0));
    seat.live.toggle_pause();
    seat.bend();
}

#[test]
fn time_stops_while_the_wheel_is_unplugged_and_force_fades_in_afterwards() {
    let mut seat = Seat::new();
    seat.bend();
    let full = seat.live.devices.take_torque_nm().unwrap().abs();
    seat.plugged.store(false, Ordering::Relaxed);
    seat.until("the pause", |seat| seat.live.waits_for_wheel());
    assert_eq!((seat.last(), seat.live.devices.take_torque_nm()), (Some(Sent::End), None), "{:?}", seat.sent());
    let stood = seat.live.drive.world.snapshot().tick;
    seat.forget();
    seat.frames(30);
    assert_eq!((seat.live.drive.world.snapshot().tick, seat.sent()), (stood, vec![]));
    // The wheel is back and turned at once: the force must not jump.
    seat.plugged.store(true, Ordering::Relaxed);
    seat.put(STEERING, LEFT);
    seat.put(ACCELERATOR, 100);
    seat.until("the drive", |seat| seat.live.drive.clock.pace() == Pace::RealTime);
    seat.until("a push", |seat| seat.sent().iter().any(is_force));
    let first = seat.sent().into_iter().find(is_force);
    let Some(Sent::Level(first)) = first else { panic!("{first:?}") };
    let first_nm = f64::from(first).abs() / 32_640.0 * profiles::named("g29").unwrap().force.full_nm;
    assert!(first_nm < 0.5 * full, "{first_nm} of {full} N m at once");
    assert!(seat.live.drive.world.snapshot().tick > stood);
}

#[test]
fn the_end_of_a_drive_and_a_panic_both_remove_the_force() {
    for panics in [false, true] {
        let mut seat = Seat::new();
        seat.bend();
        let motor = seat.motor.clone();
        let ended = catch_unwind(AssertUnwindSafe(move || {
            let watch = |_: &codrive::sim::World| assert!(!panics, "on purpose");
            seat.live.advance(Duration::from_millis(20), watch).unwrap();
        }));
        assert_eq!(ended.is_err(), panics);
        sleep(Duration::from_millis(50));
        let sent = motor.0.lock().unwrap();
        assert_eq!(sent.last(), Some(&Sent::End), "panics: {panics}");
        assert_eq!(sent.iter().filter(|sent| **sent == Sent::End).count(), 1);
    }
    // A panic that aborts would skip this cleanup.
    let profiles = include_str!("../../Cargo.toml");
    assert!(!profiles.contains("panic ="), "profiles of Cargo.toml unwind");
}
