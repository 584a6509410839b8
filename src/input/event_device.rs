//! One event device of Linux, opened for reading. In: its file in `/dev/input`. Out: [`WheelMessage`]s with evdev's codes and the
//! kernel's monotonic time, and the angle of the wheel as soon as the profile is known.

use super::{
    clock::TimeStamp, force_thread::SharedAngle, nodes::DeviceNode, profile::WheelProfile, profiles::UnprofiledDevice,
    wheel::WheelMessage,
};
use evdev::{EventType, InputEvent, raw_stream::RawDevice};
use nix::poll::PollFlags;
use std::{
    collections::BTreeSet,
    io,
    os::fd::{AsFd, AsRawFd, BorrowedFd},
    sync::Arc,
    time::{Duration, SystemTime, UNIX_EPOCH},
};

nix::ioctl_write_ptr!(set_clock, b'E', 0xa0, nix::libc::c_int);

/// SYN_DROPPED: the kernel's queue overflowed. Events up to the next SYN_REPORT are an incomplete packet.
const SYN_DROPPED: u16 = 3;
const SYN_REPORT: u16 = 0;

/// An event device, opened for reading.
pub struct EventDevice {
    device: RawDevice,
    /// True if the kernel stamps events with the monotonic clock.
    monotonic: bool,
    /// True until the first movement if all values were 0 at the opening: the driver had not read the wheel yet.
    unread: bool,
    pub heard: WheelEvents,
}

/// Translation of kernel events to [`WheelMessage`], independent of the file they are read from.
#[derive(Default)]
pub struct WheelEvents {
    /// Buttons that are down, according to the events so far.
    down: BTreeSet<u16>,
    /// True from an overflow of the kernel's queue to the end of its packet.
    dropped: bool,
    /// Profile that gives the steering axis and its angle; `None` before the wheel is chosen.
    pub profile: Option<WheelProfile>,
    pub angle: Arc<SharedAngle>,
}

impl EventDevice {
    /// Opens an event device. Returns it with its name, ids, axes and values.
    ///
    /// # Errors
    /// The device cannot be opened or queried.
    pub fn open(node: &DeviceNode) -> io::Result<(Self, UnprofiledDevice)> {
        let device = RawDevice::open(&node.path)?;
        let clock = nix::time::ClockId::CLOCK_MONOTONIC.as_raw();
        // SAFETY: the file is open and the kernel reads one int.
        let monotonic = unsafe { set_clock(device.as_fd().as_raw_fd(), &raw const clock) }.is_ok();
        let (name, place) = (node.name.clone(), node.place.clone());
        let mut known = UnprofiledDevice { name, id: node.id, place, ..UnprofiledDevice::default() };
        for (code, info) in device.get_absinfo()? {
            known.axes.insert(code.0, [info.minimum(), info.maximum()]);
            known.values.insert(code.0, info.value());
        }
        let heard = WheelEvents { down: buttons(&device)?, ..WheelEvents::default() };
        let unread = known.values.values().all(|raw| *raw == 0);
        Ok((Self { device, monotonic, unread, heard }, known))
    }

    /// Returns the file, to wait for its events.
    pub fn file(&self) -> BorrowedFd<'_> {
        self.device.as_fd()
    }

    /// Reads the events that are there.
    ///
    /// # Errors
    /// The device is gone.
    pub fn read(&mut self, messages: &mut Vec<WheelMessage>) -> io::Result<()> {
        let now = TimeStamp::now();
        let real = (!self.monotonic).then(now_real);
        let events: Vec<InputEvent> = self.device.fetch_events()?.collect();
        if events.is_empty() {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        for event in events {
            let at = stamp(event.timestamp(), now, real);
            if self.heard.apply_event(&event, at, messages) {
                let axes: Vec<(u16, i32)> = self.device.get_absinfo()?.map(|(c, info)| (c.0, info.value())).collect();
                self.heard.catch_up(axes, &buttons(&self.device)?, at, messages);
            }
        }
        let moved: Vec<u16> = messages.iter().filter_map(WheelMessage::axis).collect();
        if self.unread && !moved.is_empty() {
            // The driver has read all axes now; the kernel sends no event for those that are still 0.
            self.unread = false;
            for (code, info) in self.device.get_absinfo()?.filter(|(code, _)| !moved.contains(&code.0)) {
                self.heard.moved(code.0, info.value(), None, messages);
            }
        }
        Ok(())
    }
}

/// Checks whether a polled device is gone; remaining events are read first.
pub fn gone(state: PollFlags) -> bool {
    !state.contains(PollFlags::POLLIN) && state.intersects(PollFlags::POLLERR | PollFlags::POLLHUP)
}

impl WheelEvents {
    /// Adds the message of an event. Returns true if earlier events were lost and the device's state must be queried.
    fn apply_event(&mut self, event: &InputEvent, at: Option<TimeStamp>, messages: &mut Vec<WheelMessage>) -> bool {
        match (event.event_type(), event.code()) {
            (EventType::SYNCHRONIZATION, SYN_DROPPED) => self.dropped = true,
            (EventType::SYNCHRONIZATION, SYN_REPORT) => return std::mem::take(&mut self.dropped),
            _ if self.dropped => {}
            (EventType::ABSOLUTE, code) => self.moved(code, event.value(), at, messages),
            // Value 2 is the kernel's key repetition.
            (EventType::KEY, code) if event.value() < 2 => self.pressed(code, event.value() == 1, at, messages),
            _ => {}
        }
        false
    }

    /// Adds messages for the device's present state after events were lost: a missed release would sound the horn for
    /// ever.
    fn catch_up(
        &mut self,
        axes: Vec<(u16, i32)>,
        down: &BTreeSet<u16>,
        at: Option<TimeStamp>,
        messages: &mut Vec<WheelMessage>,
    ) {
        axes.into_iter().for_each(|(code, raw)| self.moved(code, raw, at, messages));
        let changed: Vec<u16> = self.down.symmetric_difference(down).copied().collect();
        changed.into_iter().for_each(|code| self.pressed(code, down.contains(&code), at, messages));
    }

    fn pressed(&mut self, code: u16, down: bool, at: Option<TimeStamp>, messages: &mut Vec<WheelMessage>) {
        if down {
            self.down.insert(code);
        } else {
            self.down.remove(&code);
        }
        messages.push(WheelMessage::Button { code, down, at });
    }

    fn moved(&self, code: u16, raw: i32, at: Option<TimeStamp>, messages: &mut Vec<WheelMessage>) {
        if let Some(steering) = self.profile.as_ref().map(|p| &p.steering).filter(|s| s.axis == code) {
            self.angle.set(steering.wheel_rad(raw));
        }
        messages.push(WheelMessage::Axis { code, raw, at });
    }
}

/// Returns the buttons that are down now.
fn buttons(device: &RawDevice) -> io::Result<BTreeSet<u16>> {
    Ok(device.get_key_state()?.iter().map(|key| key.0).collect())
}

/// Returns the kernel's time stamp of an event on the monotonic clock. For a device that still stamps with the clock of
/// the day, `real` is that clock's present time: the age of the event is the same on both clocks.
fn stamp(event: SystemTime, now: TimeStamp, real: Option<Duration>) -> Option<TimeStamp> {
    let event = event.duration_since(UNIX_EPOCH).ok()?;
    match real {
        None => TimeStamp::plausible(event, now),
        Some(real) => TimeStamp::plausible(now.0.checked_sub(real.checked_sub(event)?)?, now),
    }
}

fn now_real() -> Duration {
    nix::time::clock_gettime(nix::time::ClockId::CLOCK_REALTIME).map(Duration::from).unwrap_or_default()
}

#[cfg(test)]
#[path = "event_device_tests.rs"]
mod tests;
