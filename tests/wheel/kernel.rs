//! What the tests with a real kernel share: who may run, waiting, percentiles. These tests make wheels out of nothing, through
//! /dev/uinput (`uinput.rs`) or as a USB device of the kernel's own (`usb.rs`). Where the kernel has neither they are noted as not
//! run (see [`alone`]); `scripts/wheel-vm` runs them in a virtual machine that has both.

use codrive::{
    controls::Controls,
    input::{ForceInput, Rig, RigEvent, TimeStamp, WheelProfile, profiles},
};
use std::{
    fs,
    io::Write as _,
    sync::{Mutex, MutexGuard, PoisonError},
    thread::sleep,
    time::Duration,
};

/// Set for a process of this program that is a driver to be killed.
pub const DRIVER: &str = "CODRIVE_TEST_DRIVER";
/// Set by `scripts/wheel-vm`, where a test that does not run is a failure.
const MUST: &str = "CODRIVE_TEST_WHEEL_VM";

/// Names a file that takes a line for each test that this kernel cannot run: the reason's name and the test's, with a tab
/// between. `scripts/test` sets it and compares the lines with `tests/not-run-here/`.
const NOT_RUN: &str = "CODRIVE_TESTS_NOT_RUN";

/// One wheel at a time: all of them show in one /sys.
static ALONE: Mutex<()> = Mutex::new(());

/// What of a kernel a test needs, which no package brings.
#[derive(Clone, Copy, Debug)]
pub enum Kernel {
    /// To make input devices out of nothing.
    Uinput,
    /// To play a USB device to itself.
    UsbGadget,
}

impl Kernel {
    /// Name of the reason, and of the list of tests that are not run for it.
    fn reason(self) -> &'static str {
        match self {
            Self::Uinput => "uinput",
            Self::UsbGadget => "usb-gadget",
        }
    }

    /// What is missing here; `scripts/test` asks the same.
    fn lacking(self) -> Option<String> {
        let path = match self {
            Self::Uinput => "/dev/uinput",
            Self::UsbGadget => "/sys/kernel/config/usb_gadget",
        };
        if let Err(error) = fs::metadata(path).and_then(|m| writable(path, &m)) {
            return Some(format!("{path} cannot be used ({error})"));
        }
        let controllers = || fs::read_dir("/sys/class/udc").is_ok_and(|mut found| found.next().is_some());
        let alone = matches!(self, Self::UsbGadget) && !controllers();
        alone.then(|| "/sys/class/udc has no controller (dummy_hcd)".to_owned())
    }
}

/// The name of the function that this stands in, from its program on: `wheel::uinput::two_wheels_are_told`.
macro_rules! this_test {
    () => {{
        fn here() {}
        let name = std::any::type_name_of_val(&here);
        name.strip_suffix("::here").unwrap_or(name)
    }};
}
pub(crate) use this_test;

/// The right to make a wheel. `None` where the kernel cannot: the test is then noted as not run, in the file that
/// [`NOT_RUN`] names or else, past the test runner's silence, on standard error.
pub fn alone(kernel: Kernel, test: &str) -> Option<MutexGuard<'static, ()>> {
    let guard = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(lacking) = kernel.lacking() else {
        assert!(codrive::input::linux::wheels().is_empty(), "a wheel is plugged in; unplug it and run this again");
        return Some(guard);
    };
    assert!(std::env::var_os(MUST).is_none(), "{lacking}");
    match std::env::var_os(NOT_RUN) {
        Some(file) => {
            let line = format!("{}\t{test}\n", kernel.reason());
            let file = fs::OpenOptions::new().append(true).create(true).open(file);
            file.and_then(|mut file| file.write_all(line.as_bytes())).unwrap();
        }
        None => {
            let line = format!("NOT RUN HERE: {test}, because {lacking}; scripts/wheel-vm runs it\n");
            // The macros' output is kept from the screen when a test passes.
            std::io::stderr().write_all(line.as_bytes()).unwrap();
        }
    }
    None
}

fn writable(path: &str, what: &fs::Metadata) -> std::io::Result<()> {
    if what.is_dir() {
        // A folder of the kernel's: only root makes things there.
        return if is_root() { Ok(()) } else { Err(std::io::ErrorKind::PermissionDenied.into()) };
    }
    fs::OpenOptions::new().read(true).write(true).open(path).map(drop)
}

/// True for the one who may do all.
pub fn is_root() -> bool {
    // SAFETY: it reads a number.
    unsafe { nix::libc::geteuid() == 0 }
}

/// Says a figure, so that it can be read in the output of `scripts/wheel-vm`.
pub fn figure(what: &str, value: impl std::fmt::Display) {
    println!("figure: {what}: {value}");
}

/// Median, 99th percentile and largest of some times.
pub fn spread(mut times: Vec<Duration>) -> String {
    times.sort();
    let at = |share: f64| times[((times.len() - 1) as f64 * share).round() as usize].as_secs_f64() * 1e3;
    format!("{:.2} / {:.2} / {:.2} ms (median, 99 %, most; n {})", at(0.5), at(0.99), at(1.0), times.len())
}

/// A G29's profile that leaves half of its own centring on at the end, so that it shows.
pub fn profile() -> WheelProfile {
    let mut profile = profiles::named("g29").unwrap();
    profile.force.autocentre_after = 0.5;
    profile
}

/// A car in a bend to the left at 10 m/s.
pub const BEND: ForceInput = ForceInput { aligning_nm: 4.0, speed_mps: 10.0, grass: 0.0, running: true };
/// The level that this comes to, by the shipped strength 0.35 and 2.1 N m at the full level: 1.4 / 2.1 of 255 steps of 128,
/// against the axis, whose left is the smaller end.
pub const BEND_LEVEL: i16 = -170 * 128;

/// A drive without a picture: a rig, read every 5 ms.
pub struct Driver {
    /// The rig.
    pub rig: Rig,
    /// All that it told.
    pub news: Vec<RigEvent>,
}

impl Driver {
    /// Sits down.
    pub fn new() -> Self {
        Self::with(profile())
    }

    /// The same with this profile.
    pub fn with(profile: WheelProfile) -> Self {
        Self { rig: Rig::open(Some(profile)), news: Vec::new() }
    }

    /// Polls until `what` holds, for up to 30 s.
    pub fn until(&mut self, what: &str, holds: impl Fn(&Controls, &[RigEvent]) -> bool) {
        for _ in 0..6000 {
            self.news.extend(self.rig.poll().1);
            if holds(&self.rig.controls(), &self.news) {
                return;
            }
            sleep(Duration::from_millis(5));
        }
        panic!("{what} did not come within 30 s: {:?}, {:?}", self.rig.controls(), self.news);
    }

    /// Polls until a wheel was found.
    pub fn find(&mut self) {
        self.until("a wheel", |_, news| news.iter().any(|n| matches!(n, RigEvent::Connected(_))));
    }

    /// Feels this for a time, told every 10 ms, as the loop of a drive does.
    pub fn set_force_input(&mut self, feel: ForceInput, time: Duration) {
        let end = TimeStamp(TimeStamp::now().0 + time);
        while TimeStamp::now() < end {
            self.rig.set_force_input(feel);
            self.news.extend(self.rig.poll().1);
            sleep(Duration::from_millis(10));
        }
    }
}

/// If this process is the driver that is to be killed: drives in a bend until then.
pub fn drive_until_killed() {
    if std::env::var_os(DRIVER).is_none() {
        return;
    }
    let mut driver = Driver::new();
    driver.find();
    println!("driving");
    loop {
        driver.set_force_input(BEND, Duration::from_secs(1));
    }
}

/// Starts this program anew as a driver that runs the test `name` only.
pub fn start_driver(name: &str) -> std::process::Child {
    let this = std::env::current_exe().unwrap();
    let mut command = std::process::Command::new(this);
    command.args(["--exact", name, "--nocapture"]).env(DRIVER, "1").stdout(std::process::Stdio::null());
    command.spawn().unwrap()
}
