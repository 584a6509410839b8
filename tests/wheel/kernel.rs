//! Shared parts of the tests with a real kernel: permission to run, waiting, percentiles. These tests create wheels through /dev/uinput
//! (`uinput.rs`) or as a USB device of the kernel's gadget side (`usb.rs`). If the kernel has neither, they are recorded as not run (see
//! [`alone`]). `scripts/wheel-vm` runs them in a virtual machine that has both.

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

/// Environment variable that makes a process of this program a driver that the test kills.
pub const DRIVER: &str = "CODRIVE_TEST_DRIVER";
/// Environment variable that `scripts/wheel-vm` sets; then a test that does not run is a failure.
const MUST: &str = "CODRIVE_TEST_WHEEL_VM";

/// Environment variable with the path of a file that gets a line for each test that this kernel cannot run: reason and test name, separated
/// by a tab. `scripts/test` sets it and compares the lines with `tests/not-run-here/`.
const NOT_RUN: &str = "CODRIVE_TESTS_NOT_RUN";

/// Allows one wheel at a time, as all wheels share one /sys.
static ALONE: Mutex<()> = Mutex::new(());

/// Feature of the kernel that a test needs and no package provides.
#[derive(Clone, Copy, Debug)]
pub enum Kernel {
    /// Creation of virtual input devices.
    Uinput,
    /// Simulation of a USB device by the same machine.
    UsbGadget,
}

impl Kernel {
    /// Returns the name of the reason, which is also the name of its list of tests.
    fn reason(self) -> &'static str {
        match self {
            Self::Uinput => "uinput",
            Self::UsbGadget => "usb-gadget",
        }
    }

    /// Returns the missing feature, if any; `scripts/test` makes the same check.
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

/// Returns the path of the enclosing function without the crate: `wheel::uinput::two_wheels_are_told`.
macro_rules! this_test {
    () => {{
        fn here() {}
        let name = std::any::type_name_of_val(&here);
        name.strip_suffix("::here").unwrap_or(name)
    }};
}
pub(crate) use this_test;

/// Gives the permission to create a wheel. Returns `None` if the kernel cannot. The test is then recorded as not run, in the file of
/// [`NOT_RUN`], or else on standard error, which the test runner does not capture here.
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
            // The test runner captures the output of macros when a test passes.
            std::io::stderr().write_all(line.as_bytes()).unwrap();
        }
    }
    None
}

fn writable(path: &str, what: &fs::Metadata) -> std::io::Result<()> {
    if what.is_dir() {
        // Only root can create entries in a folder of the kernel.
        return if is_root() { Ok(()) } else { Err(std::io::ErrorKind::PermissionDenied.into()) };
    }
    fs::OpenOptions::new().read(true).write(true).open(path).map(drop)
}

/// Returns true if the process runs as root.
pub fn is_root() -> bool {
    // SAFETY: geteuid only returns a number.
    unsafe { nix::libc::geteuid() == 0 }
}

/// Prints a figure, which appears in the output of `scripts/wheel-vm`.
pub fn figure(what: &str, value: impl std::fmt::Display) {
    println!("figure: {what}: {value}");
}

/// Returns median, 99th percentile and maximum of some times as text.
pub fn spread(mut times: Vec<Duration>) -> String {
    times.sort();
    let at = |share: f64| times[((times.len() - 1) as f64 * share).round() as usize].as_secs_f64() * 1e3;
    format!("{:.2} / {:.2} / {:.2} ms (median, 99 %, most; n {})", at(0.5), at(0.99), at(1.0), times.len())
}

/// Returns a G29's profile that restores half of its autocentring at the end, so that the test can detect it.
pub fn profile() -> WheelProfile {
    let mut profile = profiles::named("g29").unwrap();
    profile.force.autocentre_after = 0.5;
    profile
}

/// Force input of a vehicle in a bend to the left at 10 m/s.
pub const BEND: ForceInput = ForceInput {
    aligning_nm: 4.0,
    speed_mps: 10.0,
    grass: 0.0,
    contact: 0.0,
    pulse: 0.0,
    held_rad: None,
    running: true,
};
/// Effect level for `BEND`: with strength 0.35 as shipped and 2.1 N m at the full level, 1.4 / 2.1 of 255 steps of 128. The sign is
/// negative, as left is the smaller end of the axis.
pub const BEND_LEVEL: i16 = -170 * 128;

/// Drive without a picture: a rig that is read every 5 ms.
pub struct Driver {
    pub rig: Rig,
    /// Events of the rig since the start.
    pub news: Vec<RigEvent>,
}

impl Driver {
    /// Opens a rig with the profile of these tests.
    pub fn new() -> Self {
        Self::with(profile())
    }

    /// Opens a rig with this profile.
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

    /// Sends a force input every 10 ms for a time, as the loop of a drive does.
    pub fn set_force_input(&mut self, force_input: ForceInput, time: Duration) {
        let end = TimeStamp(TimeStamp::now().0 + time);
        while TimeStamp::now() < end {
            self.rig.set_force_input(force_input);
            self.news.extend(self.rig.poll().1);
            sleep(Duration::from_millis(10));
        }
    }
}

/// Drives in a bend until killed, if this process is the driver.
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

/// Starts this program again as a driver that runs only the test `name`.
pub fn start_driver(name: &str) -> std::process::Child {
    let this = std::env::current_exe().unwrap();
    let mut command = std::process::Command::new(this);
    command.args(["--exact", name, "--nocapture"]).env(DRIVER, "1").stdout(std::process::Stdio::null());
    command.spawn().unwrap()
}
