//! Steering wheels on Linux, through evdev. In: the devices of `nodes`, `/dev/input`. Out: a [`WheelPort`] for the reader,
//! and a [`ForceDevice`]. Events carry the kernel's monotonic time.

use super::{
    event_device::{EventDevice, gone},
    force_thread::ForceDevice,
    kinds::DeviceKind,
    lamps::Lamps,
    no_force::{NoForce, WheelWithoutForce},
    parts::{BUTTON_PART, PART},
    profile::{ForceBackend, WheelProfile},
    profiles::{self, UnprofiledDevice},
    reader::WheelPort,
    sdl_force::SdlForce,
    wheel::{FoundWheel, WheelMessage},
};
use evdev::{
    FFEffect, FFEffectCode, FFEffectData, FFEffectKind, FFEnvelope, FFReplay, FFTrigger, raw_stream::RawDevice,
};
use nix::poll::{PollFd, PollFlags, PollTimeout};
use std::{io, path::Path, sync::Arc, time::Duration};

pub use super::nodes::{DeviceNode, controllers, wheels};

/// udev rule that lets the user at the screen open wheels and set their range.
pub const UDEV_RULE: &str =
    r#"SUBSYSTEM=="input", KERNEL=="event*", ENV{ID_INPUT_JOYSTICK}=="1", TAG+="uaccess", MODE="0660", GROUP="input""#;
/// File for the rule: it must sort before 73-seat-late.rules, which acts on the tag.
pub const UDEV_FILE: &str = "/etc/udev/rules.d/70-codrive-wheel.rules";
/// Direction towards greater values of the first axis, see `ForceModel::level`.
const TO_GREATER: u16 = 0xC000;

/// A wheel of this computer and the further devices of the rig, opened for reading.
pub struct OpenWheel {
    base: EventDevice,
    parts: Vec<OpenPart>,
}

/// A further device of the rig, such as pedals, opened for reading.
struct OpenPart {
    /// Number of the device in the rig.
    number: u16,
    device: EventDevice,
    /// False if the profile names none of its axes and buttons. Its buttons are read all the same, so that a person can assign them.
    used: bool,
}

impl OpenWheel {
    /// Opens an event device. Returns it with its name, ids, axes and values.
    ///
    /// # Errors
    /// The device cannot be opened or queried.
    pub fn open(node: &DeviceNode) -> io::Result<(Self, UnprofiledDevice)> {
        let (base, known) = EventDevice::open(node)?;
        Ok((Self { base, parts: Vec::new() }, known))
    }

    /// Opens a wheel with all other devices that may be parts of its rig. One that cannot be opened is left out.
    ///
    /// # Errors
    /// The wheel cannot be opened or queried.
    pub fn open_rig(node: &DeviceNode, others: &[DeviceNode]) -> io::Result<(Self, UnprofiledDevice)> {
        let (mut rig, mut known) = Self::open(node)?;
        for other in others.iter().filter(|other| other.kind == DeviceKind::Controller && other.path != node.path) {
            match EventDevice::open(other) {
                Ok((device, part)) => {
                    known.add(&part);
                    rig.parts.push(OpenPart { number: known.parts.len() as u16, device, used: true });
                }
                Err(error) => log::warn!("{}", trouble(other, &error)),
            }
        }
        Ok((rig, known))
    }

    /// Takes the profile that was chosen.
    fn follow(&mut self, profile: &WheelProfile, device: &mut UnprofiledDevice) {
        device.keep_parts_of(profile);
        self.parts.iter_mut().for_each(|part| part.used = profile.uses_part(part.number));
        if let Some(raw) = device.values.get(&profile.steering.axis) {
            self.base.heard.angle.set(profile.steering.wheel_rad(*raw));
        }
        self.base.heard.profile = Some(profile.clone());
    }

    /// Waits up to `patience` for events, and adds them to `messages`. Axes and buttons of further devices have codes of their
    /// own; axes that the profile does not use are left out.
    ///
    /// # Errors
    /// A device is gone that the profile uses.
    pub fn read(&mut self, patience: Duration, messages: &mut Vec<WheelMessage>) -> io::Result<()> {
        let devices = || std::iter::once(&self.base).chain(self.parts.iter().map(|part| &part.device));
        let mut polled: Vec<PollFd> = devices().map(|device| PollFd::new(device.file(), PollFlags::POLLIN)).collect();
        let timeout = PollTimeout::try_from(patience).unwrap_or(PollTimeout::ZERO);
        match nix::poll::poll(&mut polled, timeout) {
            Ok(0) | Err(nix::errno::Errno::EINTR) => return Ok(()),
            Ok(_) => {}
            Err(error) => return Err(error.into()),
        }
        let states: Vec<PollFlags> =
            polled.iter().map(|polled| polled.revents().unwrap_or(PollFlags::empty())).collect();
        if gone(states[0]) {
            return Err(io::ErrorKind::NotConnected.into());
        }
        if !states[0].is_empty() {
            self.base.read(messages)?;
        }
        let mut outcome = Ok(());
        let mut states = states[1..].iter();
        self.parts.retain_mut(|part| match part.read(states.next().copied().unwrap_or(PollFlags::empty()), messages) {
            Err(error) if part.used => {
                outcome = Err(error);
                true
            }
            read => read.is_ok(),
        });
        outcome
    }
}

impl OpenPart {
    /// Reads the events that are there, with the codes of the rig.
    fn read(&mut self, state: PollFlags, messages: &mut Vec<WheelMessage>) -> io::Result<()> {
        if gone(state) {
            return Err(io::ErrorKind::NotConnected.into());
        }
        let mut its = Vec::new();
        if !state.is_empty() {
            self.device.read(&mut its)?;
        }
        let in_the_rig = |message| match message {
            WheelMessage::Axis { code, raw, at } => {
                self.used.then_some(WheelMessage::Axis { code: code + PART * self.number, raw, at })
            }
            WheelMessage::Button { code, down, at } => {
                Some(WheelMessage::Button { code: code + BUTTON_PART * self.number, down, at })
            }
            _ => None,
        };
        messages.extend(its.into_iter().filter_map(in_the_rig));
        Ok(())
    }
}

/// The wheels of this computer, read through evdev.
pub struct EvdevPort {
    asked: Option<WheelProfile>,
    /// Devices of the last search without a result. They are searched again only when they change, or if one could not
    /// be opened.
    seen: Option<Vec<DeviceNode>>,
}

impl EvdevPort {
    /// Creates a port for all wheels; `asked` is the profile that a person named.
    pub fn new(asked: Option<WheelProfile>) -> Self {
        Self { asked, seen: None }
    }
}

impl EvdevPort {
    /// Reports own profiles that cannot be obeyed because no device is taken for a wheel.
    fn tell_why_none(&self, nodes: &[DeviceNode], report: &mut dyn FnMut(String)) {
        profiles::own_profiles().1.into_iter().for_each(&mut *report);
        let unfit = nodes.iter().any(|node| matches!(node.kind, DeviceKind::Unfit(_)));
        let Some(asked) = self.asked.as_ref().filter(|_| !unfit) else { return };
        let there: Vec<String> = nodes.iter().map(DeviceNode::described).collect();
        let there = if there.is_empty() { "none".into() } else { there.join(", ") };
        report(format!(
            "no device has an id of the profile \"{}\" ({}), and no other wheel is plugged in; devices with axes: {there}\n  \
             remedy: plug its wheel in, or correct its products",
            asked.name,
            asked.products.join(", ")
        ));
    }
}

impl WheelPort for EvdevPort {
    type Wheel = OpenWheel;

    fn find(&mut self, report: &mut dyn FnMut(String)) -> Option<(FoundWheel, OpenWheel)> {
        let nodes = controllers(self.asked.as_ref());
        if self.seen.as_ref() == Some(&nodes) {
            return None;
        }
        let mut again = false;
        let usable: Vec<&DeviceNode> = nodes.iter().filter(|node| node.kind == DeviceKind::Wheel).collect();
        for node in &nodes {
            if let DeviceKind::Unfit(text) = node.kind {
                report(text.to_owned());
            }
        }
        if let [first, second, ..] = usable[..] {
            report(format!(
                "two wheels are plugged in, {} and {}; the first one is used\n  remedy: unplug the other",
                first.name, second.name
            ));
        }
        if usable.is_empty() {
            self.tell_why_none(&nodes, report);
        }
        for node in usable {
            let opened = OpenWheel::open_rig(node, &nodes).map_err(|e| {
                again = true;
                trouble(node, &e)
            });
            let chosen = opened.and_then(|(wheel, device)| {
                let (profile, faults) = profiles::choose(&device, self.asked.as_ref()).map_err(|e| e.to_string())?;
                Ok((wheel, device, profile, faults))
            });
            match chosen {
                Ok((mut wheel, mut device, profile, faults)) => {
                    faults.into_iter().for_each(&mut *report);
                    let force = force(node, &profile).unwrap_or_else(|without| {
                        report(without.to_string());
                        None
                    });
                    wheel.follow(&profile, &mut device);
                    let event = node.path.file_name().unwrap_or_default().to_string_lossy();
                    let lamps = Lamps::find(Path::new("/sys"), &event);
                    let angle = Arc::clone(&wheel.base.heard.angle);
                    self.seen = None;
                    return Some((FoundWheel { device, profile, lamps, force, angle }, wheel));
                }
                Err(text) => report(text),
            }
        }
        self.seen = (!again).then_some(nodes);
        None
    }

    fn prefer(&mut self, profile: WheelProfile) {
        self.asked = Some(profile);
        self.seen = None;
    }

    fn read(&mut self, wheel: &mut OpenWheel, messages: &mut Vec<WheelMessage>) -> io::Result<()> {
        wheel.read(Duration::from_millis(100), messages)
    }
}

/// Opens the force feedback of this wheel; `None` if the profile's strength is 0.
fn force(node: &DeviceNode, profile: &WheelProfile) -> Result<Option<Box<dyn ForceDevice>>, WheelWithoutForce> {
    let settings = &profile.force;
    if settings.strength == 0.0 {
        return Ok(None);
    }
    Ok(Some(match settings.backend {
        ForceBackend::System => Box::new(EvdevForce::open(node, settings.autocentre_after)?),
        ForceBackend::Sdl => Box::new(SdlForce::open(node.id, &node.name, settings.autocentre_after)?),
    }))
}

/// Returns the message for a wheel that cannot be opened, with the remedy.
pub fn trouble(node: &DeviceNode, error: &io::Error) -> String {
    let (path, name) = (node.path.display(), &node.name);
    if error.kind() == io::ErrorKind::PermissionDenied {
        return format!(
            "{name} may not be opened ({path}: permission denied)\n  remedy: write this line into {UDEV_FILE}\n    \
             {UDEV_RULE}\n  then: sudo udevadm control --reload && sudo udevadm trigger, and plug the wheel in again"
        );
    }
    format!("{name} cannot be opened ({path}: {error})\n  remedy: unplug it and plug it in again")
}

/// Force-feedback capabilities of a wheel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    pub constant: bool,
    /// Common gain of all effects.
    pub gain: bool,
    /// Centring spring of the device itself.
    pub autocentre: bool,
    /// Number of effects at the same time.
    pub effects: usize,
}

/// Queries the force-feedback capabilities of a wheel.
///
/// # Errors
/// The device cannot be opened.
pub fn capabilities(node: &DeviceNode) -> io::Result<Capabilities> {
    Ok(capabilities_of(&RawDevice::open(&node.path)?))
}

fn capabilities_of(device: &RawDevice) -> Capabilities {
    let has = |code| device.supported_ff().is_some_and(|all| all.contains(code));
    Capabilities {
        constant: has(FFEffectCode::FF_CONSTANT),
        gain: has(FFEffectCode::FF_GAIN),
        autocentre: has(FFEffectCode::FF_AUTOCENTER),
        effects: device.max_ff_effects(),
    }
}

/// Force feedback of a wheel: one constant effect, updated in place. It has its own open file, because a write waits
/// for the USB frame.
///
/// A second effect of zero force plays all the time. Kernel drivers based on `ff-memless` (such as hid-lg4ff) apply an
/// update by a timer. If the effect is stopped before that, also by a close or SIGKILL, they do not update the wheel,
/// which keeps pulling. With a second effect playing they recompute the sum, which is zero, and send it
/// (`tests/wheel/usb.rs` shows it).
struct EvdevForce {
    device: RawDevice,
    can: Capabilities,
    effect: FFEffect,
    rest: Option<FFEffect>,
    autocentre_after: f64,
}

impl EvdevForce {
    /// Opens the device, switches its own centring off and uploads the effects at level 0.
    fn open(node: &DeviceNode, autocentre_after: f64) -> Result<Self, WheelWithoutForce> {
        let refuse = |why| WheelWithoutForce {
            wheel: node.name.clone(),
            why,
            remedy: "codrive doctor shows the details".into(),
        };
        let mut device = RawDevice::open(&node.path).map_err(|e| refuse(e.into()))?;
        let can = capabilities_of(&device);
        if !can.constant {
            return Err(refuse(NoForce::NoConstantForce));
        }
        let upload = device.upload_ff_effect(constant(0)).map_err(|e| refuse(NoForce::Upload(e)))?;
        // Optional: a device may have room for only one effect.
        let rest = device.upload_ff_effect(constant(0)).ok();
        let mut force = Self { device, can, effect: upload, rest, autocentre_after };
        force.prepare().map_err(|e| refuse(e.into()))?;
        Ok(force)
    }

    fn prepare(&mut self) -> io::Result<()> {
        if self.can.gain {
            self.device.set_ff_gain(u16::MAX)?;
        }
        if self.can.autocentre {
            self.device.set_ff_autocenter(0)?;
        }
        if let Some(rest) = &mut self.rest {
            rest.play(1)?;
        }
        self.effect.play(1)
    }
}

impl ForceDevice for EvdevForce {
    fn set(&mut self, level: i16) -> io::Result<()> {
        self.effect.update(constant(level))
    }

    fn end(&mut self) {
        let _ = self.effect.update(constant(0));
        let _ = self.effect.stop();
        if self.can.autocentre {
            // The kernel does not report the previous strength; the profile gives the strength to restore.
            let _ = self.device.set_ff_autocenter(strength(self.autocentre_after));
        }
    }
}

/// Makes an endless constant force.
fn constant(level: i16) -> FFEffectData {
    let envelope = FFEnvelope { attack_length: 0, attack_level: 0, fade_length: 0, fade_level: 0 };
    FFEffectData {
        direction: TO_GREATER,
        trigger: FFTrigger::default(),
        replay: FFReplay { length: 0, delay: 0 },
        kind: FFEffectKind::Constant { level, envelope },
    }
}

/// Converts a share, 0 to 1, to the kernel's unit of strength.
fn strength(share: f64) -> u16 {
    (share * f64::from(u16::MAX)) as u16
}

#[cfg(test)]
#[path = "linux_tests.rs"]
mod tests;
