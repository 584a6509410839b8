//! Devices that umockdev plays from a description: name, ids, axes and abilities. In: [`Device`]s and events. Out: the files of umockdev,
//! and a process that sees these devices and no others.

use super::{UMOCKDEV, WITHIN, again, umockdev};
use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

/// Input device as its driver would describe it.
#[derive(Clone)]
pub struct Device {
    pub name: &'static str,
    pub id: (u16, u16),
    /// Code, present value, smallest and largest value of each absolute axis.
    pub axes: Vec<(u16, i32, [i32; 2])>,
    pub buttons: std::ops::Range<u16>,
    /// True for a constant force.
    pub pushes: bool,
    /// True for the relative axes of a mouse.
    pub points: bool,
    /// USB port, as the kernel names it in `phys`.
    pub port: &'static str,
}

/// First button of joysticks and wheels (BTN_JOYSTICK), of mice and of gamepads.
pub const JOYSTICK: u16 = 0x120;
pub const MOUSE: u16 = 0x110;
pub const GAMEPAD: u16 = 0x130;

impl Device {
    /// Makes a wheel with a constant force and 16 buttons.
    pub fn wheel(name: &'static str, id: (u16, u16), axes: &[(u16, i32, [i32; 2])]) -> Self {
        Self { name, id, axes: axes.into(), buttons: JOYSTICK..JOYSTICK + 16, pushes: true, points: false, port: "" }
    }

    fn kind(&self) -> &'static str {
        if self.points { "ID_INPUT_MOUSE" } else { "ID_INPUT_JOYSTICK" }
    }

    fn axis_bits(&self) -> u64 {
        self.axes.iter().fold(0, |bits, (code, ..)| bits | 1 << code)
    }

    fn key_words(&self) -> [u64; 12] {
        let mut words = [0; 12];
        self.buttons.clone().for_each(|code| words[usize::from(code / 64)] |= 1 << (code % 64));
        words
    }

    /// Event types: EV_SYN and EV_KEY, EV_REL, EV_ABS, EV_FF.
    fn types(&self) -> u32 {
        0x3 | u32::from(self.points) << 2 | u32::from(!self.axes.is_empty()) << 3 | u32::from(self.pushes) << 21
    }

    /// Returns the device as umockdev's description, as number `number` of the system.
    fn description(&self, number: usize) -> String {
        let keys: Vec<String> = self.key_words()[..5].iter().rev().map(|word| format!("{word:x}")).collect();
        let (vendor, product) = self.id;
        let mut abilities = format!("E: EV={:x}\nE: KEY={}\n", self.types(), keys.join(" "));
        if !self.axes.is_empty() {
            abilities += &format!("E: ABS={:x}\n", self.axis_bits());
        }
        if self.points {
            abilities += "E: REL=903\n";
        }
        if self.pushes {
            // FF_CONSTANT is bit 0x52, FF_GAIN and FF_AUTOCENTER are 0x60 and 0x61.
            abilities += "E: FF=300040000 0\n";
        }
        let (name, kind, minor) = (self.name, self.kind(), 64 + number);
        format!(
            "P: /devices/pci0000:00/usb1/1-{n}/input/input{number}/event{number}\nN: input/event{number}\n\
             E: DEVNAME=/dev/input/event{number}\nE: ID_INPUT=1\nE: {kind}=1\nE: MAJOR=13\nE: MINOR={minor}\nE: SUBSYSTEM=input\n\
             A: dev=13:{minor}\nL: device=../../input{number}\n\n\
             P: /devices/pci0000:00/usb1/1-{n}/input/input{number}\n{abilities}E: ID_INPUT=1\nE: {kind}=1\nE: NAME=\"{name}\"\n\
             E: PRODUCT=3/{vendor:x}/{product:x}/111\nE: SUBSYSTEM=input\nA: name={name}\nA: id/vendor={vendor:04x}\n\
             A: id/product={product:04x}\nA: phys={port}\nA: uniq=\n\n",
            port = self.port,
            n = number + 1,
        )
    }

    /// Returns the kernel's answers to questions about the device, as umockdev's recording.
    fn answers(&self, number: usize) -> String {
        let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02X}")).collect::<String>();
        let [vendor, product] = [self.id.0, self.id.1].map(|id| hex(&id.to_le_bytes()));
        let mut name = self.name.as_bytes().to_vec();
        name.resize(256, 0);
        let types = hex(&self.types().to_le_bytes());
        let keys: Vec<u8> = self.key_words().iter().flat_map(|word| word.to_le_bytes()).collect();
        let mut text = format!(
            "@DEV /dev/input/event{number}\nEVIOCGVERSION 0 01000100\nEVIOCGID 0 0300{vendor}{product}1101\nEVIOCGNAME(0) {} {}\n\
             EVIOCGBIT(0) 8 {types}{}\nEVIOCGBIT(1) 96 {}\nEVIOCGKEY(0) 96 {}\n",
            self.name.len() + 1,
            hex(&name),
            "00".repeat(28),
            hex(&keys),
            "00".repeat(96),
        );
        if !self.axes.is_empty() {
            text += &format!("EVIOCGBIT(3) 8 {}\n", hex(&self.axis_bits().to_le_bytes()));
        }
        if self.points {
            text += "EVIOCGBIT(2) 2 0309\n";
        }
        for (code, value, [low, high]) in &self.axes {
            let which = if *code == 0 { String::new() } else { format!("({code})") };
            let numbers = [*value, *low, *high, 0, 0, 0].map(|number| hex(&number.to_le_bytes())).concat();
            text += &format!("EVIOCGABS{which} 0 {numbers}\n");
        }
        let force = if self.pushes { "00000000000000000000040003000000" } else { "00000000000000000000000000000000" };
        text + &format!(
            "EVIOCGBIT(0) 4 {types}\nEVIOCGBIT(21) 16 {force}\nEVIOCGPROP 4 00000000\nEVIOCGEFFECTS 0 10000000\n"
        )
    }
}

/// Runs a program that sees these devices. `events` are those of each device, `config` is the folder of own profiles' settings, and
/// `variables` are further environment variables.
pub fn run_with(
    devices: &[(&Device, &str)],
    config: &Path,
    variables: &[(&str, &str)],
    program: &Path,
    arguments: &[&str],
) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let mut command: Command = umockdev();
    for (number, (device, events)) in devices.iter().enumerate() {
        let file = |what: &str, text: String| {
            let path = folder.path().join(format!("{what}-{number}"));
            fs::write(&path, text).unwrap();
            path
        };
        let node = |path: &Path| format!("/dev/input/event{number}={}", path.display());
        command.arg("--device").arg(file("device", device.description(number)));
        command.arg("--ioctl").arg(node(&file("ioctl", device.answers(number))));
        if !events.is_empty() {
            command.arg("--evemu-events").arg(node(&file("events", (*events).to_owned())));
        }
    }
    command.env(WITHIN, "1").env("XDG_CONFIG_HOME", config).env("RUST_LOG", "error");
    command.envs(variables.iter().copied()).arg("--").arg(program).args(arguments).output().expect(UMOCKDEV)
}

/// Runs one test of this program again with these devices, and asserts its success.
pub fn again_with(test: &str, devices: &[(&Device, &str)], config: &Path, variables: &[(&str, &str)]) {
    again(test, |this, arguments| run_with(devices, config, variables, this, arguments));
}

/// Returns presses and releases of buttons as events of evemu: time in seconds, button, 1 for down.
pub fn presses(buttons: &[(f64, u16, i32)]) -> String {
    buttons
        .iter()
        .map(|(at_s, code, down)| format!("E: {at_s:.6} 0001 {code:04x} {down}\nE: {at_s:.6} 0000 0000 0\n"))
        .collect()
}

/// Returns movements as events of evemu: time in seconds, axis, value.
pub fn movements(moves: &[(f64, u16, i32)]) -> String {
    moves
        .iter()
        .map(|(at_s, code, raw)| format!("E: {at_s:.6} 0003 {code:04x} {raw}\nE: {at_s:.6} 0000 0000 0\n"))
        .collect()
}
