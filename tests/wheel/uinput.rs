//! Tests with a virtual G29 through /dev/uinput, with force: the test logs the kernel's requests to the device with their times.

use super::kernel::{self, BEND, BEND_LEVEL, Driver, Kernel, alone, figure, spread, this_test};
use codrive::{
    input::{ButtonAction, Devices, ForceInput, RigEvent, TimeStamp, linux},
    live_drive::LiveDrive,
    scenario::{DisplaySettings, Scenario},
    time::Pace,
    traffic::EngineChoice,
};
use evdev::{
    AbsInfo, AbsoluteAxisCode, AttributeSet, BusType, EventSummary, FFEffectCode, FFEffectData, FFEffectKind,
    InputEvent, InputId, KeyCode, UInputCode, UinputAbsSetup, uinput::VirtualDevice,
};
use std::{
    os::fd::{AsRawFd, BorrowedFd},
    panic::{AssertUnwindSafe, catch_unwind},
    process::Command,
    sync::{
        Arc, Mutex,
        mpsc::{self, Receiver, Sender},
    },
    thread::{JoinHandle, sleep},
    time::Duration,
};

const NAME: &str = "Logitech G29 Driving Force Racing Wheel";
const SYN: u16 = 0;
const KEY: u16 = 1;
const ABS: u16 = 3;
/// Codes of the wheel's axis, accelerator, brake and horn button.
const STEERING: u16 = 0;
const ACCELERATOR: u16 = 2;
const BRAKE: u16 = 5;
const HORN: u16 = 289;

/// Request of the kernel to the wheel.
#[derive(Clone, Debug, PartialEq)]
enum Asked {
    /// Upload of an effect, which is new or replaces the one with its number.
    Upload {
        id: i16,
        level: i16,
        direction: u16,
        length_ms: u16,
    },
    Erase(u32),
    Play(u16, i32),
    Gain(i32),
    Autocentre(i32),
    Else(String),
}

/// Virtual wheel, unplugged when dropped.
struct Wheel {
    to: Option<Sender<Vec<InputEvent>>>,
    asked: Arc<Mutex<Vec<(TimeStamp, Asked)>>>,
    thread: Option<JoinHandle<()>>,
}

impl Wheel {
    /// Plugs a wheel in, at rest.
    fn plug() -> Self {
        Self::named(NAME)
    }

    fn named(name: &str) -> Self {
        let mut keys = AttributeSet::<KeyCode>::new();
        (288..=303).chain(704..=712).for_each(|code| keys.insert(KeyCode(code)));
        let mut force = AttributeSet::<FFEffectCode>::new();
        [FFEffectCode::FF_CONSTANT, FFEffectCode::FF_GAIN, FFEffectCode::FF_AUTOCENTER]
            .into_iter()
            .for_each(|code| force.insert(code));
        let mut builder = VirtualDevice::builder().unwrap().name(name).input_id(InputId::new(
            BusType::BUS_USB,
            0x046d,
            0xc24f,
            0x0111,
        ));
        for (code, value, [low, high]) in
            [(0, 32_767, [0, 65_535]), (1, 255, [0, 255]), (2, 255, [0, 255]), (5, 255, [0, 255]), (16, 0, [-1, 1])]
        {
            let axis = UinputAbsSetup::new(AbsoluteAxisCode(code), AbsInfo::new(value, low, high, 0, 0, 0));
            builder = builder.with_absolute_axis(&axis).unwrap();
        }
        let builder = builder.with_keys(&keys).unwrap().with_ff(&force).unwrap().with_ff_effects_max(16);
        let device = builder.build().unwrap();
        let (to, events) = mpsc::channel();
        let asked = Arc::default();
        let log = Arc::clone(&asked);
        let thread = std::thread::spawn(move || serve(device, &events, &log));
        Self { to: Some(to), asked, thread: Some(thread) }
    }

    fn send(&self, events: &[(u16, u16, i32)]) {
        let events = events.iter().map(|(kind, code, value)| InputEvent::new(*kind, *code, *value)).collect();
        self.to.as_ref().unwrap().send(events).unwrap();
    }

    /// Returns the requests since the last call.
    fn asked(&self) -> Vec<(TimeStamp, Asked)> {
        std::mem::take(&mut self.asked.lock().unwrap())
    }

    /// Waits for a matching request, at most 10 s. Returns all requests up to then.
    fn asked_until(&self, what: impl Fn(&Asked) -> bool) -> Vec<(TimeStamp, Asked)> {
        let mut all = Vec::new();
        for _ in 0..2000 {
            all.extend(self.asked());
            if all.iter().any(|(_, asked)| what(asked)) {
                return all;
            }
            sleep(Duration::from_millis(5));
        }
        panic!("the kernel did not ask for it within 10 s: {all:?}");
    }
}

impl Drop for Wheel {
    fn drop(&mut self) {
        self.to.take();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Runs the device on its thread: takes force and sends events until the other end is closed.
fn serve(mut device: VirtualDevice, events: &Receiver<Vec<InputEvent>>, log: &Mutex<Vec<(TimeStamp, Asked)>>) {
    loop {
        match events.try_recv() {
            Ok(batch) => device.emit(&batch).unwrap(),
            Err(mpsc::TryRecvError::Disconnected) => return,
            Err(mpsc::TryRecvError::Empty) => {}
        }
        // SAFETY: the device outlives the poll.
        let fd = unsafe { BorrowedFd::borrow_raw(device.as_raw_fd()) };
        let mut polled = [nix::poll::PollFd::new(fd, nix::poll::PollFlags::POLLIN)];
        if nix::poll::poll(&mut polled, 1_u8).unwrap() == 0 {
            continue;
        }
        let asked: Vec<InputEvent> = device.fetch_events().unwrap().collect();
        for event in asked {
            let at = TimeStamp::now();
            let asked = match event.destructure() {
                EventSummary::UInput(event, UInputCode::UI_FF_UPLOAD, _) => {
                    let upload = device.process_ff_upload(event).unwrap();
                    effect(upload.effect_id(), &upload.effect())
                }
                EventSummary::UInput(event, UInputCode::UI_FF_ERASE, _) => {
                    Asked::Erase(device.process_ff_erase(event).unwrap().effect_id())
                }
                EventSummary::ForceFeedback(_, FFEffectCode::FF_GAIN, value) => Asked::Gain(value),
                EventSummary::ForceFeedback(_, FFEffectCode::FF_AUTOCENTER, value) => Asked::Autocentre(value),
                EventSummary::ForceFeedback(_, code, value) => Asked::Play(code.0, value),
                other => Asked::Else(format!("{other:?}")),
            };
            log.lock().unwrap().push((at, asked));
        }
    }
}

fn effect(id: i16, data: &FFEffectData) -> Asked {
    match data.kind {
        FFEffectKind::Constant { level, .. } => {
            Asked::Upload { id, level, direction: data.direction, length_ms: data.replay.length }
        }
        _ => Asked::Else(format!("{data:?}")),
    }
}

fn levels(asked: &[(TimeStamp, Asked)]) -> Vec<(TimeStamp, i16)> {
    let level = |(at, asked): &(TimeStamp, Asked)| match asked {
        Asked::Upload { id: 0, level, direction: 0xC000, length_ms: 0 } => Some((*at, *level)),
        _ => None,
    };
    asked.iter().filter_map(level).collect()
}

fn is_level(level: i16) -> impl Fn(&Asked) -> bool {
    move |asked| matches!(asked, Asked::Upload { level: l, .. } if *l == level)
}

#[test]
fn force_is_one_effect_updated_in_place_and_ends_on_stall_pause_and_exit() {
    let Some(_alone) = alone(Kernel::Uinput, this_test!()) else { return };
    let wheel = Wheel::plug();
    let mut driver = Driver::new();
    driver.find();
    let begun = wheel.asked_until(|asked| *asked == Asked::Play(0, 1));
    let begun: Vec<Asked> = begun.into_iter().map(|(_, asked)| asked).collect();
    let [zero, rest] = [0, 1].map(|id| Asked::Upload { id, level: 0, direction: 0xC000, length_ms: 0 });
    // The second effect, without force, plays all the time.
    let made = [zero.clone(), rest, Asked::Gain(0xFFFF), Asked::Autocentre(0), Asked::Play(1, 1), Asked::Play(0, 1)];
    assert_eq!(begun, made);

    // In a bend the force fades in, has the right level, and is not sent again while it is constant.
    driver.set_force_input(BEND, Duration::from_millis(900));
    let sent = wheel.asked();
    let sent_levels = levels(&sent);
    assert_eq!(sent.len(), sent_levels.len(), "nothing but the one effect: {sent:?}");
    assert!(
        sent_levels.windows(2).all(|pair| pair[1].1 < pair[0].1),
        "fades in, never twice the same: {sent_levels:?}"
    );
    assert_eq!(sent_levels.last().unwrap().1, BEND_LEVEL);
    driver.set_force_input(BEND, Duration::from_millis(500));
    assert_eq!(wheel.asked(), [], "unchanged is not sent");

    // A moving wheel, to measure the rate: at most one update in 6 ms.
    let steering = |i: u32| (ABS, STEERING, 32_767 + (9000.0 * (f64::from(i) * 0.05).sin()) as i32);
    for i in 0..300 {
        wheel.send(&[steering(i)]);
        driver.set_force_input(BEND, Duration::from_millis(8));
    }
    let moving = levels(&wheel.asked());
    let paces: Vec<Duration> = moving.windows(2).map(|pair| pair[0].0.until(pair[1].0)).collect();
    let seconds = moving[0].0.until(moving[moving.len() - 1].0).as_secs_f64();
    let rate = (moving.len() - 1) as f64 / seconds;
    figure("updates of the effect a second, wheel moving", format!("{rate:.0}"));
    figure("time from one update to the next", spread(paces));
    assert!(rate < 170.0, "{rate} a second");
    assert!(moving.windows(2).all(|pair| pair[0].1 != pair[1].1));

    // The loop stalls, so no further input arrives.
    wheel.send(&[(ABS, STEERING, 32_767)]);
    driver.set_force_input(BEND, Duration::from_millis(800));
    wheel.asked();
    driver.rig.set_force_input(BEND);
    let stalled = TimeStamp::now();
    let gone = wheel.asked_until(is_level(0));
    let after = stalled.until(gone.last().unwrap().0);
    figure("no force after the loop stalled", format!("{:.1} ms", after.as_secs_f64() * 1e3));
    assert!(after < Duration::from_millis(100), "{after:?}");
    assert!(levels(&gone).len() > 2, "faded, not cut: {gone:?}");

    // Pause of the drive.
    driver.set_force_input(BEND, Duration::from_millis(800));
    wheel.asked();
    let paused = TimeStamp::now();
    driver.rig.set_force_input(ForceInput { running: false, ..BEND });
    let after = paused.until(wheel.asked_until(is_level(0)).last().unwrap().0);
    figure("no force after a pause", format!("{:.1} ms", after.as_secs_f64() * 1e3));
    assert!(after < Duration::from_millis(100), "{after:?}");

    // End of the drive with force on.
    driver.set_force_input(BEND, Duration::from_millis(800));
    wheel.asked();
    let ended = TimeStamp::now();
    drop(driver);
    let last = wheel.asked_until(|asked| *asked == Asked::Erase(1));
    let after = ended.until(last.iter().find(|(_, asked)| is_level(0)(asked)).unwrap().0);
    figure("no force after the end of the program", format!("{:.1} ms", after.as_secs_f64() * 1e3));
    assert!(after < Duration::from_millis(100), "{after:?}");
    let last: Vec<Asked> = last.into_iter().map(|(_, asked)| asked).skip_while(|asked| !is_level(0)(asked)).collect();
    let (end, erased) = last.split_at(3);
    assert_eq!(end, [zero, Asked::Play(0, 0), Asked::Autocentre(32_767)], "its own centring as the profile wants it");
    assert!(erased.iter().all(|a| matches!(a, Asked::Play(_, 0) | Asked::Erase(_))), "{erased:?}");
}

#[test]
fn a_drive_pushes_against_the_hand_but_not_in_a_pause_or_after_a_panic() {
    let Some(_alone) = alone(Kernel::Uinput, this_test!()) else { return };
    let wheel = Wheel::plug();
    let devices = Devices::open_with(Some(kernel::profile()));
    let scenario =
        Scenario { traffic: EngineChoice::Native, policy: "none".into(), vehicles: 6, ..Scenario::default() };
    let scenario = Scenario {
        warm_up_s: 5.0,
        duration_s: 0.0,
        display: DisplaySettings { trees: 0, ..scenario.display },
        ..scenario
    };
    let mut live = LiveDrive::new(&scenario, Pace::RealTime, devices).unwrap();
    let frames = |live: &mut LiveDrive, count: usize| {
        for _ in 0..count {
            live.advance(Duration::from_millis(10), |_| ()).unwrap();
            sleep(Duration::from_millis(10));
        }
    };
    while live.devices.take_torque_nm().is_none() {
        frames(&mut live, 1);
    }
    // Held to the left, with the accelerator pressed, the wheel is pushed to the right.
    wheel.send(&[(ABS, ACCELERATOR, 100), (SYN, 0, 0), (ABS, STEERING, 29_100), (SYN, 0, 0)]);
    frames(&mut live, 200);
    wheel.asked();
    frames(&mut live, 100);
    live.toggle_pause();
    frames(&mut live, 20);
    let pushed: Vec<i16> = levels(&wheel.asked()).into_iter().map(|(_, level)| level).collect();
    assert!(pushed.iter().all(|level| *level >= 0) && pushed.iter().any(|level| *level > 1000), "{pushed:?}");
    assert_eq!(pushed.last(), Some(&0));
    frames(&mut live, 50);
    assert_eq!(wheel.asked(), [], "in the pause");
    live.toggle_pause();
    frames(&mut live, 100);
    let panicked = catch_unwind(AssertUnwindSafe(move || {
        live.advance(Duration::from_millis(20), |_| panic!("on purpose")).map(drop)
    }));
    assert!(panicked.is_err());
    let last = wheel.asked_until(|asked| *asked == Asked::Erase(1));
    assert_eq!(levels(&last).last().unwrap().1, 0, "{last:?}");
    assert!(last.iter().any(|(_, asked)| *asked == Asked::Play(0, 0)), "{last:?}");
}

#[test]
fn a_killed_program_leaves_no_force_on_the_wheel() {
    kernel::drive_until_killed();
    let Some(_alone) = alone(Kernel::Uinput, this_test!()) else { return };
    let wheel = Wheel::plug();
    let mut child = kernel::start_driver("uinput::a_killed_program_leaves_no_force_on_the_wheel");
    wheel.asked_until(is_level(BEND_LEVEL));
    sleep(Duration::from_millis(200));
    assert_eq!(wheel.asked(), [], "it stands at full force");
    let killed = TimeStamp::now();
    child.kill().unwrap();
    let asked = wheel.asked_until(|asked| *asked == Asked::Erase(1));
    child.wait().unwrap();
    let times: Vec<String> =
        asked.iter().map(|(at, asked)| format!("{asked:?} {:.1} ms", killed.until(*at).as_secs_f64() * 1e3)).collect();
    figure("the kernel after SIGKILL", times.join(", "));
    // The kernel closes the file, stops the effect and removes it. The autocentre stays off, as nothing requests it.
    assert_eq!(asked[0].1, Asked::Play(0, 0));
    assert!(killed.until(asked[0].0) < Duration::from_millis(100), "{asked:?}");
    sleep(Duration::from_millis(300));
    assert_eq!(wheel.asked(), [], "and nothing after that");
}

#[test]
fn it_drives_from_rest_and_stamps_come_from_the_kernel() {
    let Some(_alone) = alone(Kernel::Uinput, this_test!()) else { return };
    let wheel = Wheel::plug();
    let mut driver = Driver::new();
    driver.find();
    let rest = driver.rig.controls();
    assert_eq!((rest.throttle, rest.brake), (0.0, 0.0), "without any event");
    assert!(rest.steering_wheel_rad.abs() < 1e-3);
    wheel.send(&[(ABS, STEERING, 40_000), (ABS, ACCELERATOR, 0), (ABS, BRAKE, 128), (KEY, 297, 1)]);
    driver.until("the pedals", |c, _| c.throttle == 1.0 && c.brake > 0.3);
    let angle = driver.rig.controls().steering_wheel_rad.to_degrees();
    assert!((angle + 99.33).abs() < 0.05, "{angle}");
    driver.until("the button", |_, news| news.contains(&RigEvent::Pressed(ButtonAction::Start)));

    // Measures the age of an input when a tick of 10 ms uses it.
    let mut ages = Vec::new();
    // On a slow machine an input is read one round later.
    let mut earlier = TimeStamp::now();
    for i in 0..300_u16 {
        // Between two ticks, at a different moment each time.
        sleep(Duration::from_micros(u64::from(i * 37 % 97) * 100));
        let sent = TimeStamp::now();
        wheel.send(&[(ABS, STEERING, 30_000 + i32::from(i) * 10)]);
        sleep(Duration::from_millis(10));
        driver.news.extend(driver.rig.poll().1);
        if let Some(at) = driver.rig.newest_input() {
            let now = TimeStamp::now();
            assert!(at >= earlier && at <= now, "the kernel's time lies between: {earlier:?}, {at:?}, {now:?}");
            ages.push(at.until(now));
        }
        earlier = sent;
    }
    assert!(ages.len() > 250, "{} of 300 inputs had a time", ages.len());
    figure("kernel's time of an input to the tick that used it, a tick after 10 ms", spread(ages));
}

#[test]
fn a_queue_that_ran_over_does_not_leave_the_horn_on() {
    let Some(_alone) = alone(Kernel::Uinput, this_test!()) else { return };
    let wheel = Wheel::plug();
    let nodes = linux::wheels();
    let (mut open, _) = linux::OpenWheel::open(&nodes[0]).unwrap();
    let mut messages = Vec::new();
    wheel.send(&[(KEY, HORN, 1)]);
    for _ in 0..200 {
        open.read(Duration::from_millis(10), &mut messages).unwrap();
    }
    assert_eq!(buttons(&messages), [(HORN, true)]);
    // The queue runs over, as nothing reads it.
    for i in 0..400 {
        wheel.send(&[(ABS, STEERING, i), (ABS, BRAKE, i % 256), (SYN, 0, 0)]);
    }
    wheel.send(&[(KEY, HORN, 0)]);
    for i in 400..800 {
        wheel.send(&[(ABS, STEERING, i), (ABS, BRAKE, i % 256), (SYN, 0, 0)]);
    }
    sleep(Duration::from_secs(3));
    let mut messages = Vec::new();
    for _ in 0..200 {
        open.read(Duration::from_millis(10), &mut messages).unwrap();
    }
    assert_eq!(buttons(&messages), [(HORN, false)]);
    let steering = messages.iter().rev().find_map(|message| match message {
        codrive::input::wheel::WheelMessage::Axis { code: STEERING, raw, .. } => Some(*raw),
        _ => None,
    });
    assert_eq!(steering, Some(799), "and the axes are where they are");
}

fn buttons(messages: &[codrive::input::wheel::WheelMessage]) -> Vec<(u16, bool)> {
    let button = |message: &codrive::input::wheel::WheelMessage| match message {
        codrive::input::wheel::WheelMessage::Button { code, down, .. } => Some((*code, *down)),
        _ => None,
    };
    messages.iter().filter_map(button).collect()
}

#[test]
fn unplugged_and_plugged_in_again_and_again() {
    let Some(_alone) = alone(Kernel::Uinput, this_test!()) else { return };
    // Each takes up to half a second, the period of the search for wheels.
    let times: usize = std::env::var("CODRIVE_TEST_REPLUGS").ok().and_then(|text| text.parse().ok()).unwrap_or(5);
    let mut driver = Driver::new();
    let began = TimeStamp::now();
    for i in 0..times {
        let wheel = Wheel::plug();
        driver.find();
        assert!(driver.rig.describe().ends_with("with force"), "{i}: {}", driver.rig.describe());
        assert_eq!(driver.rig.controls().throttle, 0.0, "{i}");
        wheel.send(&[(ABS, STEERING, 45_000), (ABS, ACCELERATOR, 60)]);
        driver.until("the pedal", |c, _| c.throttle > 0.5);
        driver.set_force_input(BEND, Duration::from_millis(20));
        drop(wheel);
        driver.until("the loss", |_, news| news.iter().any(|n| matches!(n, RigEvent::Disconnected(_))));
        let left = driver.rig.controls();
        assert!(left.throttle == 0.0 && left.brake == 0.0 && left.steering_wheel_rad < -1.0, "{i}: {left:?}");
        let trouble: Vec<&RigEvent> = driver.news.iter().filter(|n| matches!(n, RigEvent::Trouble(_))).collect();
        assert!(trouble.is_empty(), "{i}: {trouble:?}");
        driver.news.clear();
    }
    let open = std::fs::read_dir("/proc/self/fd").unwrap().count();
    figure(
        "unplugged and plugged in again",
        format!("{times} times in {:.0} s", began.until(TimeStamp::now()).as_secs_f64()),
    );
    assert!(open < 60, "{open} files are open");
}

#[test]
fn two_wheels_are_told() {
    let Some(_alone) = alone(Kernel::Uinput, this_test!()) else { return };
    let wheels = [Wheel::plug(), Wheel::named("Another Racing Wheel")];
    let mut driver = Driver::new();
    driver.find();
    let two = |n: &RigEvent| matches!(n, RigEvent::Trouble(text) if text.contains("two wheels are plugged in"));
    assert_eq!(driver.news.iter().filter(|n| two(n)).count(), 1, "{:?}", driver.news);
    drop(wheels);
}

#[test]
fn doctor_reports_the_wheels_abilities_and_missing_permission() {
    let Some(_alone) = alone(Kernel::Uinput, this_test!()) else { return };
    let _wheel = Wheel::plug();
    let doctor = |user: Option<u32>| {
        let folder = tempfile::tempdir().unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
        command.args(["doctor", "--json", "--size", "64x36", "--trees", "0", "--quality", "low", "--out"]);
        command.arg(folder.path()).env("RUST_LOG", "error").env("XDG_CONFIG_HOME", folder.path()).current_dir("/");
        if let Some(user) = user {
            std::os::unix::process::CommandExt::uid(&mut command, user);
        }
        let output = command.output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let page: serde_json::Value = serde_json::from_str(&text)
            .unwrap_or_else(|e| panic!("{e}: {text}{}", String::from_utf8_lossy(&output.stderr)));
        page["checks"].as_array().unwrap().clone()
    };
    let line = |checks: &[serde_json::Value], what: &str| {
        let line = checks.iter().find(|line| line["what"] == what).unwrap_or_else(|| panic!("no line on {what}"));
        ["grade", "found", "remedy"].map(|key| line[key].as_str().unwrap_or_default().to_owned())
    };
    let checks = doctor(None);
    assert_eq!(line(&checks, "wheel")[0], "ok", "{:?}", line(&checks, "wheel"));
    let force = line(&checks, "force");
    assert!(force[1].contains("constant force yes, gain yes, autocentre yes, 16 effects"), "{force:?}");
    for what in ["wheel", "force", "clock", "power", "disk speed"] {
        figure("doctor", format!("{what}: {}", line(&checks, what).join(" | ").replace('\n', " ")));
    }
    if super::kernel::is_root() {
        // An unprivileged user may not open the wheel, as on a machine without the udev rule.
        let checks = doctor(Some(65_534));
        let [grade, found, remedy] = line(&checks, "wheel");
        figure("doctor, without permission", format!("{found} | {remedy}").replace('\n', " "));
        assert!(grade == "fault" && (found + &remedy).contains(linux::UDEV_RULE), "{remedy}");
    }
}
