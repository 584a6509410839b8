//! Tests with a virtual G29 on USB. The kernel's gadget side simulates the wheel (configfs, `usb_f_hid`, `dummy_hcd`). Its host side drives
//! it with hid-logitech (lg4ff), the driver of a real G29. The output is the bytes that a real wheel would be sent. The report descriptor
//! is written for this test from what is known of the wheel's reports: 4 bits hat, 25 buttons, 16 bits wheel, three pedals of one byte,
//! seven bytes out.

use super::kernel::{self, BEND, Driver, Kernel, alone, figure, spread, this_test};
use codrive::input::{AdviceState, ButtonAction, ForceInput, RigEvent, TimeStamp, profile::ForceBackend};
use std::{
    fs::{self, File, OpenOptions},
    io::{Read, Write},
    os::{fd::AsFd, unix::fs::symlink},
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    thread::{JoinHandle, sleep},
    time::Duration,
};

const GADGETS: &str = "/sys/kernel/config/usb_gadget";
/// Size of a report to the host: hat and buttons in bytes 0 to 3, wheel 4 and 5, accelerator 6, brake 7, clutch 8, three vendor bytes.
const INPUT: usize = 12;
/// Command to the wheel.
type Bytes = [u8; 7];

#[rustfmt::skip]
const DESCRIPTOR: &[u8] = &[
    0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0xa1, 0x02,                         // a joystick
    0x15, 0x00, 0x25, 0x07, 0x35, 0x00, 0x46, 0x3b, 0x01, 0x65, 0x14, 0x75, 0x04, 0x95, 0x01, 0x09, 0x39, 0x81, 0x42, // hat
    0x65, 0x00, 0x25, 0x01, 0x45, 0x01, 0x05, 0x09, 0x19, 0x01, 0x29, 0x19, 0x75, 0x01, 0x95, 0x19, 0x81, 0x02, // buttons
    0x06, 0x00, 0xff, 0x09, 0x01, 0x75, 0x01, 0x95, 0x03, 0x81, 0x02,       // three bits of the maker's
    0x05, 0x01, 0x27, 0xff, 0xff, 0x00, 0x00, 0x47, 0xff, 0xff, 0x00, 0x00, 0x75, 0x10, 0x95, 0x01, 0x09, 0x30, 0x81, 0x02, // X
    0x26, 0xff, 0x00, 0x46, 0xff, 0x00, 0x75, 0x08, 0x95, 0x03, 0x09, 0x32, 0x09, 0x35, 0x09, 0x31, 0x81, 0x02, // Z, Rz, Y
    0x06, 0x00, 0xff, 0x09, 0x01, 0x75, 0x08, 0x95, 0x03, 0x81, 0x02, 0xc0, // three bytes of the maker's
    0xa1, 0x02, 0x06, 0x00, 0xff, 0x09, 0x02, 0x26, 0xff, 0x00, 0x46, 0xff, 0x00, 0x75, 0x08, 0x95, 0x07, 0x91, 0x02, 0xc0, // out
    0xc0,
];

/// Virtual wheel, unplugged and removed when dropped.
struct Wheel {
    folder: PathBuf,
    controller: String,
    device: Option<File>,
    sent: Arc<Mutex<Vec<(TimeStamp, Bytes)>>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Wheel {
    /// Builds the wheel and plugs it in.
    fn plug() -> Self {
        let controller = fs::read_dir("/sys/class/udc").unwrap().flatten().next().expect("a controller: dummy_hcd");
        let controller = controller.file_name().into_string().unwrap();
        let folder = Path::new(GADGETS).join("g29");
        let function = folder.join("functions/hid.0");
        let configuration = folder.join("configs/c.1");
        for made in [&folder, &function, &configuration, &folder.join("strings/0x409")] {
            fs::create_dir(made).unwrap();
        }
        // The device number marks the wheel as a G29 in its native mode.
        for (file, text) in [
            ("idVendor", "0x046d"),
            ("idProduct", "0xc24f"),
            ("bcdDevice", "0x8900"),
            ("bcdUSB", "0x0200"),
            ("strings/0x409/manufacturer", "Logitech"),
            ("strings/0x409/product", "G29 Driving Force Racing Wheel"),
            ("functions/hid.0/protocol", "0"),
            ("functions/hid.0/subclass", "0"),
            ("functions/hid.0/report_length", "12"),
        ] {
            fs::write(folder.join(file), text).unwrap();
        }
        fs::write(function.join("report_desc"), DESCRIPTOR).unwrap();
        symlink(&function, configuration.join("hid.0")).unwrap();
        fs::write(folder.join("UDC"), &controller).unwrap();
        let device = OpenOptions::new().read(true).write(true).open("/dev/hidg0").unwrap();
        let (sent, stop) = (Arc::default(), Arc::new(AtomicBool::new(false)));
        let (log, flag, read) = (Arc::clone(&sent), Arc::clone(&stop), device.try_clone().unwrap());
        let thread = std::thread::spawn(move || listen(read, &flag, &log));
        Self { folder, controller, device: Some(device), sent, stop, thread: Some(thread) }
    }

    /// Sends a report: buttons as bits, the first one lowest, then wheel, accelerator and brake.
    fn report(&mut self, buttons: u32, wheel: u16, [accelerator, brake]: [u8; 2]) {
        let mut bytes = [0; INPUT];
        // Value 8 of the hat is its centre.
        bytes[..4].copy_from_slice(&(8 | buttons << 4).to_le_bytes());
        bytes[4..6].copy_from_slice(&wheel.to_le_bytes());
        bytes[6..9].copy_from_slice(&[accelerator, brake, 255]);
        self.device.as_mut().unwrap().write_all(&bytes).unwrap();
    }

    /// Returns the commands to the wheel since the last call.
    fn sent(&self) -> Vec<(TimeStamp, Bytes)> {
        std::mem::take(&mut self.sent.lock().unwrap())
    }

    /// Waits for a matching command, at most 10 s. Returns all commands up to then.
    fn sent_until(&self, what: impl Fn(&Bytes) -> bool) -> Vec<(TimeStamp, Bytes)> {
        self.all_until(|all| all.iter().any(|(_, bytes)| what(bytes)))
    }

    /// Waits for the end: no force, and autocentre. The driver sends autocentre at once and the end of the force by its timer.
    fn sent_to_the_end(&self) -> (TimeStamp, Vec<(TimeStamp, Bytes)>) {
        let none = |all: &[(TimeStamp, Bytes)]| all.iter().find(|(_, b)| force(b) == Some(0x80)).map(|(at, _)| *at);
        let all = self.all_until(|all| none(all).is_some() && all.iter().any(|(_, b)| b[0] == AUTOCENTRE));
        (none(&all).unwrap(), all)
    }

    fn all_until(&self, what: impl Fn(&[(TimeStamp, Bytes)]) -> bool) -> Vec<(TimeStamp, Bytes)> {
        let mut all = Vec::new();
        for _ in 0..2000 {
            all.extend(self.sent());
            if what(&all) {
                return all;
            }
            sleep(Duration::from_millis(5));
        }
        panic!("it was not sent within 10 s: {}", hex(&all));
    }

    fn replug(&self) {
        fs::write(self.folder.join("UDC"), "\n").unwrap();
        sleep(Duration::from_millis(1200));
        fs::write(self.folder.join("UDC"), &self.controller).unwrap();
    }
}

impl Drop for Wheel {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        self.device.take();
        let _ = fs::write(self.folder.join("UDC"), "\n");
        let _ = fs::remove_file(self.folder.join("configs/c.1/hid.0"));
        for made in ["configs/c.1", "functions/hid.0", "strings/0x409", ""] {
            let _ = fs::remove_dir(self.folder.join(made));
        }
        // Time for the host to notice the removal.
        sleep(Duration::from_millis(500));
    }
}

fn listen(mut device: File, stop: &AtomicBool, log: &Mutex<Vec<(TimeStamp, Bytes)>>) {
    while !stop.load(Ordering::Relaxed) {
        let mut polled = [nix::poll::PollFd::new(device.as_fd(), nix::poll::PollFlags::POLLIN)];
        if nix::poll::poll(&mut polled, 20_u8).unwrap() == 0 {
            continue;
        }
        let mut bytes = [0; 64];
        // An unplugged wheel has nothing to read until it is plugged in again.
        let Ok(count) = device.read(&mut bytes) else {
            sleep(Duration::from_millis(5));
            continue;
        };
        if count > 0 {
            let mut report = Bytes::default();
            report[..count.min(7)].copy_from_slice(&bytes[..count.min(7)]);
            log.lock().unwrap().push((TimeStamp::now(), report));
        }
    }
}

fn hex(all: &[(TimeStamp, Bytes)]) -> String {
    all.iter().map(|(_, bytes)| one(bytes)).collect::<Vec<_>>().join(", ")
}

fn one(bytes: &Bytes) -> String {
    bytes.map(|byte| format!("{byte:02x}")).join(" ")
}

/// First bytes of commands, as the driver sends them.
const FORCE: [u8; 2] = [0x11, 0x08];
const NO_FORCE: u8 = 0x13;
const RANGE: [u8; 2] = [0xf8, 0x81];
const LAMPS: [u8; 2] = [0xf8, 0x12];
const NO_AUTOCENTRE: u8 = 0xf5;
const AUTOCENTRE: u8 = 0x14;

/// Returns the force of a command in the wheel's steps, 0 to 255; 128 is no force.
fn force(bytes: &Bytes) -> Option<u8> {
    match bytes {
        [NO_FORCE, ..] => Some(0x80),
        [a, b, force, ..] if [*a, *b] == FORCE => Some(*force),
        _ => None,
    }
}

#[test]
fn the_kernel_driver_sends_a_g29_force_range_lamps_and_autocentre() {
    let Some(_alone) = alone(Kernel::UsbGadget, this_test!()) else { return };
    let mut wheel = Wheel::plug();
    let begun = wheel.sent_until(|bytes| bytes[..2] == RANGE);
    figure("lg4ff at the start", hex(&begun));
    assert!(begun.iter().any(|(_, b)| b[..4] == [0xf8, 0x81, 0x84, 0x03]), "900 degrees, unasked");
    let mut driver = Driver::new();
    driver.find();
    // The driver has read nothing yet and reports 0 for all axes: full left, both pedals fully pressed.
    assert_eq!(driver.rig.controls(), codrive::controls::Controls::default(), "nothing acts before it is known");
    wheel.report(0, 32_767, [255, 255]);
    driver.set_force_input(ForceInput::default(), Duration::from_millis(100));
    figure("lg4ff as force begins", hex(&wheel.sent()));
    let rest = driver.rig.controls();
    assert!(rest.throttle == 0.0 && rest.brake == 0.0 && rest.steering_wheel_rad.abs() < 1e-3, "{rest:?}");
    wheel.report(0x1, 40_000, [0, 100]);
    driver.until("the pedals", |c, _| c.throttle == 1.0 && c.brake > 0.4 && c.steering_wheel_rad < -1.7);
    driver.until("the button", |_, news| news.contains(&RigEvent::Pressed(ButtonAction::Answer)));
    wheel.report(0, 32_767, [255, 255]);

    // Bend to the left.
    driver.set_force_input(BEND, Duration::from_millis(900));
    let sent = wheel.sent();
    figure("lg4ff, force fades in to 1.4 N m to the left", hex(&sent));
    let forces: Vec<u8> = sent.iter().filter_map(|(_, bytes)| force(bytes)).collect();
    assert_eq!(forces.len(), sent.len(), "nothing but force: {}", hex(&sent));
    assert_eq!(*forces.last().unwrap(), LEFT_BEND, "{forces:?}");
    driver.set_force_input(BEND, Duration::from_millis(500));
    assert_eq!(hex(&wheel.sent()), "", "unchanged is not sent");
    let right = ForceInput { aligning_nm: -4.0, ..BEND };
    driver.set_force_input(right, Duration::from_millis(900));
    let sent = wheel.sent();
    assert_eq!(
        sent.last().and_then(|(_, bytes)| force(bytes)),
        Some((256 - u16::from(LEFT_BEND)) as u8),
        "{}",
        hex(&sent)
    );

    // Moving wheel.
    for i in 0..250 {
        wheel.report(0, (32_767.0 + 9000.0 * (f64::from(i) * 0.05).sin()) as u16, [255, 255]);
        driver.set_force_input(BEND, Duration::from_millis(8));
    }
    let moving = wheel.sent();
    let paces: Vec<Duration> = moving.windows(2).map(|pair| pair[0].0.until(pair[1].0)).collect();
    let seconds = moving[0].0.until(moving[moving.len() - 1].0).as_secs_f64();
    figure("reports to the wheel a second, wheel moving", format!("{:.0}", (moving.len() - 1) as f64 / seconds));
    figure("time from one report to the next", spread(paces));

    // Lamps for engine speed.
    wheel.report(0, 32_767, [255, 255]);
    driver.set_force_input(BEND, Duration::from_millis(800));
    wheel.sent();
    for (advice_state, lamps) in
        [(AdviceState::Below, 0x01), (AdviceState::Within, 0x07), (AdviceState::Above, 0x1f), (AdviceState::None, 0)]
    {
        assert_eq!(driver.rig.show_advice_state(advice_state), None);
        driver.set_force_input(BEND, Duration::from_millis(100));
        let sent = wheel.sent();
        figure("lg4ff, lamps", format!("{advice_state:?}: {}", hex(&sent)));
        let shown = sent.iter().rev().find(|(_, bytes)| bytes[..2] == LAMPS).map(|(_, bytes)| bytes[2]);
        assert_eq!(shown, Some(lamps), "{}", hex(&sent));
    }

    // Stall, pause and end: the driver's timers add at most one tick of the kernel.
    driver.rig.set_force_input(BEND);
    let stalled = TimeStamp::now();
    let gone = wheel.sent_until(|bytes| force(bytes) == Some(0x80));
    let after = stalled.until(gone.last().unwrap().0);
    figure("no force at the wheel after a stall", format!("{:.1} ms: {}", after.as_secs_f64() * 1e3, hex(&gone)));
    assert!(after < Duration::from_millis(100), "{after:?}");
    driver.set_force_input(BEND, Duration::from_millis(800));
    wheel.sent();
    let paused = TimeStamp::now();
    driver.rig.set_force_input(ForceInput { running: false, ..BEND });
    let after = paused.until(wheel.sent_until(|bytes| force(bytes) == Some(0x80)).last().unwrap().0);
    figure("no force at the wheel after a pause", format!("{:.1} ms", after.as_secs_f64() * 1e3));
    assert!(after < Duration::from_millis(100), "{after:?}");
    driver.set_force_input(BEND, Duration::from_millis(800));
    wheel.sent();
    let ended = TimeStamp::now();
    drop(driver);
    // Half of the autocentring, as the profile requests.
    let (none, last) = wheel.sent_to_the_end();
    figure("lg4ff at the end", format!("{:.1} ms: {}", ended.until(none).as_secs_f64() * 1e3, hex(&last)));
    assert!(ended.until(none) < Duration::from_millis(100));
    sleep(Duration::from_millis(200));
    figure("lg4ff after the end", hex(&wheel.sent()));
}

/// Byte for 170 of 255 steps to the left; the driver has 127 steps per side.
const LEFT_BEND: u8 = 0x80 + 85;

#[test]
fn after_sigkill_the_kernels_own_driver_stops_the_force() {
    kernel::drive_until_killed();
    let Some(_alone) = alone(Kernel::UsbGadget, this_test!()) else { return };
    let mut wheel = Wheel::plug();
    wheel.sent_until(|bytes| bytes[..2] == RANGE);
    let name = "usb::after_sigkill_the_kernels_own_driver_stops_the_force";
    // First with a constant force, then with one that changes all the time and is never zero (1.4 N m with damping). An update that the
    // kernel had not yet taken over once made it forget to stop the wheel, before there was a second effect without force.
    let mut times = Vec::new();
    for round in 0..12_u32 {
        let mut child = kernel::start_driver(name);
        wheel.sent_until(|bytes| bytes[0] == NO_AUTOCENTRE);
        wheel.report(0, 32_767, [255, 255]);
        wheel.sent_until(|bytes| force(bytes) == Some(LEFT_BEND));
        sleep(Duration::from_millis(300));
        for i in 0..round * 7 {
            wheel.report(0, (32_767.0 + 900.0 * (f64::from(i) * 0.3).sin()) as u16, [255, 255]);
            sleep(Duration::from_millis(8));
        }
        let before = wheel.sent();
        assert!(before.iter().all(|(_, bytes)| force(bytes).is_some()), "{}", hex(&before));
        let killed = TimeStamp::now();
        child.kill().unwrap();
        wheel.sent_until(|bytes| force(bytes) == Some(0x80));
        let none = TimeStamp::now();
        child.wait().unwrap();
        sleep(Duration::from_millis(200));
        let rest = wheel.sent();
        assert!(rest.iter().all(|(_, b)| force(b).is_none_or(|f| f == 0x80)), "and it stays so: {}", hex(&rest));
        assert!(killed.until(none) < Duration::from_millis(100), "round {round}: {:?}", killed.until(none));
        times.push(killed.until(none));
    }
    figure("no force at the wheel after SIGKILL", spread(times));
}

#[test]
fn through_sdl_a_g29_is_sent_the_same_bytes() {
    let Some(_alone) = alone(Kernel::UsbGadget, this_test!()) else { return };
    let mut wheel = Wheel::plug();
    wheel.sent_until(|bytes| bytes[..2] == RANGE);
    let mut profile = kernel::profile();
    profile.force.backend = ForceBackend::Sdl;
    let mut driver = Driver::with(profile);
    driver.find();
    let trouble = driver.news.iter().find(|news| matches!(news, RigEvent::Trouble(_)));
    assert_eq!(trouble, None, "the true SDL2 is needed; scripts/setup --test installs it");
    assert!(driver.rig.describe().ends_with("with force"), "{}", driver.rig.describe());
    wheel.report(0, 32_767, [255, 255]);
    driver.set_force_input(ForceInput::default(), Duration::from_millis(200));
    figure("SDL2 and lg4ff as force begins", hex(&wheel.sent()));
    driver.set_force_input(BEND, Duration::from_millis(900));
    let sent = wheel.sent();
    figure("SDL2 and lg4ff, force fades in to 1.4 N m to the left", hex(&sent));
    assert_eq!(sent.last().and_then(|(_, bytes)| force(bytes)), Some(LEFT_BEND), "{}", hex(&sent));
    driver.set_force_input(BEND, Duration::from_millis(300));
    assert_eq!(hex(&wheel.sent()), "", "unchanged is not sent");
    let ended = TimeStamp::now();
    drop(driver);
    let (none, last) = wheel.sent_to_the_end();
    figure("SDL2 and lg4ff at the end", format!("{:.1} ms: {}", ended.until(none).as_secs_f64() * 1e3, hex(&last)));
    assert!(ended.until(none) < Duration::from_millis(100));
}

#[test]
fn a_usb_wheel_that_was_pulled_out_drives_again_with_force() {
    let Some(_alone) = alone(Kernel::UsbGadget, this_test!()) else { return };
    let mut wheel = Wheel::plug();
    let mut driver = Driver::new();
    for _ in 0..3 {
        driver.find();
        wheel.report(0, 32_767, [255, 255]);
        driver.set_force_input(BEND, Duration::from_millis(700));
        wheel.report(0, 45_000, [60, 255]);
        driver.until("the pedal", |c, _| c.throttle > 0.5);
        assert!(driver.rig.describe().ends_with("with force"));
        assert!(wheel.sent().iter().any(|(_, bytes)| bytes[..2] == FORCE));
        driver.news.clear();
        wheel.replug();
        driver.until("the loss", |_, news| news.iter().any(|n| matches!(n, RigEvent::Disconnected(_))));
        assert_eq!(driver.rig.controls().throttle, 0.0);
    }
}
