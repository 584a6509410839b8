//! Tests of triggers on a pseudo-terminal: bytes read at its other end, and their times.

use super::*;
use crate::lsl::local_clock_s;
use nix::poll::{PollFd, PollFlags, poll};
use std::{
    io::Read,
    os::fd::{AsFd, AsRawFd},
};

fn settings(device: PathBuf, return_to_zero_ms: f64) -> TriggerSettings {
    let codes = TriggerCodes { advice: Some(1), trial_start: Some(16), mark: Some(200), ..TriggerCodes::default() };
    TriggerSettings { device, baud: 115_200, return_to_zero_ms, codes }
}

/// Opens a pseudo-terminal: the amplifier's end, both ends, and the device file of the program's end.
fn terminal() -> (std::fs::File, nix::pty::OpenptyResult, PathBuf) {
    let ends = nix::pty::openpty(None, None).unwrap();
    let device = std::fs::read_link(format!("/proc/self/fd/{}", ends.slave.as_raw_fd())).unwrap();
    (ends.master.try_clone().unwrap().into(), ends, device)
}

/// Reads `count` bytes, each with its time of arrival; fails if a byte does not come within 5 s.
fn read(mut from: &std::fs::File, count: usize) -> Vec<(u8, f64)> {
    let mut byte = [0];
    let mut next = || {
        let mut waits = [PollFd::new(from.as_fd(), PollFlags::POLLIN)];
        assert_eq!(poll(&mut waits, 5_000_u16), Ok(1), "no byte came");
        from.read_exact(&mut byte).unwrap();
        (byte[0], local_clock_s())
    };
    (0..count).map(|_| next()).collect()
}

#[test]
fn each_event_has_its_byte_and_the_time_of_writing() {
    let (amplifier, _ends, device) = terminal();
    let mut port = TriggerPort::open(&settings(device, 0.0)).unwrap();
    let begun = local_clock_s();
    for event in ["trial_start", "advice", "contact", "mark"] {
        port.event(event, begun);
    }
    let read = read(&amplifier, 3);
    assert_eq!(read.iter().map(|(byte, _)| *byte).collect::<Vec<_>>(), [16, 1, 200], "contact has no code");
    let written = port.wait_written();
    assert_eq!(
        written.iter().map(|w| (w.event.as_str(), w.code)).collect::<Vec<_>>(),
        [("trial_start", 16), ("advice", 1), ("mark", 200)]
    );
    let times: Vec<f64> = written.iter().map(|w| w.written_s.unwrap()).collect();
    assert!(times.is_sorted() && times[0] >= begun && written.iter().all(|w| w.due_s == begun), "{written:?}");
}

#[test]
fn lines_return_to_zero_after_the_pulse_and_the_next_byte_waits() {
    let (amplifier, _ends, device) = terminal();
    let mut port = TriggerPort::open(&settings(device, 20.0)).unwrap();
    let due = local_clock_s();
    port.event("advice", due);
    port.event("mark", due);
    let read = read(&amplifier, 5);
    assert_eq!(read.iter().map(|(byte, _)| *byte).collect::<Vec<_>>(), [0, 1, 0, 200, 0], "0 from the start");
    let written: Vec<f64> = port.wait_written().iter().map(|w| w.written_s.unwrap()).collect();
    // A pulse is never shorter than requested; the operating system may lengthen it.
    assert!(written[1] - written[0] >= 0.020 && read[4].1 - written[1] >= 0.019, "{written:?} {read:?}");
}

#[test]
fn a_missing_or_wrong_device_is_named_in_the_error() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let message = TriggerPort::open(&settings(file.path().into(), 0.0)).err().unwrap().to_string();
    assert!(message.contains("is not a serial port") && message.contains(file.path().to_str().unwrap()), "{message}");
    let message = TriggerPort::open(&settings("/dev/no-such-port".into(), 0.0)).err().unwrap().to_string();
    assert!(message.contains("/dev/no-such-port") && message.contains("remedy: plug it in"), "{message}");
}

#[test]
fn invalid_settings_are_refused() {
    let with = |text: &str| toml::from_str::<TriggerSettings>(text).unwrap().check();
    assert_eq!(with("device = '/dev/ttyUSB0'\ncodes = { advice = 1, mark = 2 }"), Ok(()));
    assert_eq!(with("device = 'a'\nbaud = 1234"), Err(TriggerSettingsFault::Baud(1234)));
    assert_eq!(with("device = 'a'\nreturn_to_zero_ms = -1.0"), Err(TriggerSettingsFault::Return(-1.0)));
    assert_eq!(with("device = 'a'\ncodes = { mark = 0 }"), Err(TriggerSettingsFault::Zero("mark")));
    assert_eq!(
        with("device = 'a'\ncodes = { advice = 7, contact = 7 }"),
        Err(TriggerSettingsFault::Twice("advice", "contact", 7))
    );
}
