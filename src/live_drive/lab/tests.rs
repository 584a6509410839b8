//! Triggers of a drive: the bytes that the amplifier reads, and the table of the recording. Streams are tested in
//! `tests/lsl`, with other programs at the other ends.

use super::*;
use crate::record::{TableReader, streams::FOLDER};

#[test]
fn lab_settings_are_the_tables_of_a_study() {
    let text = "[lsl]\noutlets = true\nrecord = [\"type='EEG'\"]\n[triggers]\ndevice = '/dev/ttyUSB0'\n[triggers.codes]\nadvice = 1";
    let settings: LabSettings = toml::from_str(text).unwrap();
    assert!(settings.lsl.outlets && settings.triggers.unwrap().codes.advice == Some(1));
    assert!(LabDevices::open(&LabSettings::default()).unwrap().is_empty(), "nothing asked for, nothing needed");
}

#[test]
fn delayed_readings_of_the_clock_do_not_delay_time_stamps() {
    // Frames begin every 16 ms from 7.000 s. Their clock is read after these delays, ms.
    let delays = [9.0, 0.0, 0.1, 14.0, 0.0, 30.0];
    let (mut start_s, mut late_ms) = (0.0, Vec::new());
    for (frame, delay) in delays.into_iter().enumerate() {
        let due_s = 7.0 + 0.016 * frame as f64;
        start_s = frame_start_s(start_s, Duration::from_millis(16), due_s + 1e-3 * delay);
        late_ms.push((1e3 * (start_s - due_s)).round());
    }
    assert_eq!(late_ms, [9.0, 0.0, 0.0, 0.0, 0.0, 0.0], "only the first reading has nothing to be compared with");
    assert_eq!(frame_start_s(start_s, Duration::from_millis(16), 9.0), 9.0, "a pause between the frames");
}

#[cfg(target_os = "linux")]
#[test]
fn triggers_of_a_trial_are_on_the_wire_and_in_its_recording() {
    use std::{io::Read, os::fd::AsRawFd};
    let ends = nix::pty::openpty(None, None).unwrap();
    let device = std::fs::read_link(format!("/proc/self/fd/{}", ends.slave.as_raw_fd())).unwrap();
    let text = format!(
        "[triggers]\ndevice = '{}'\n[triggers.codes]\ntrial_start = 16\ntrial_end = 32\nmark = 4",
        device.display()
    );
    let folder = tempfile::tempdir().unwrap();
    let mut lab = LabDevices::open(&toml::from_str(&text).unwrap()).unwrap();
    lab.begin_trial(Some(folder.path()), "trial-1-wide").unwrap();
    lab.note("mark", "by the participant");
    lab.note("horn", "on");
    lab.begin_frame(Duration::ZERO);
    lab.end_frame(Tick(3), 0.5).unwrap();
    lab.end_trial().unwrap();
    lab.note("mark", "after the drive");
    assert!(lab.take_news().is_empty());
    let (sent, read) = std::sync::mpsc::channel();
    let amplifier: std::fs::File = ends.master.try_clone().unwrap().into();
    std::thread::spawn(move || {
        std::io::BufReader::new(amplifier).bytes().map_while(Result::ok).try_for_each(|byte| sent.send(byte))
    });
    let next = || read.recv_timeout(std::time::Duration::from_secs(5)).unwrap();
    assert_eq!([next(), next(), next(), next()], [16, 4, 32, 4]);
    crate::record::streams::settle(folder.path(), &mut Vec::new()).unwrap();
    let table = |name: &str| TableReader::parquet(&folder.path().join(FOLDER).join(name)).unwrap();
    let triggers = table("triggers.parquet");
    assert_eq!(triggers.words("event"), ["trial_start", "mark", "trial_end"]);
    assert_eq!(triggers.numbers("code"), [16.0, 4.0, 32.0].map(Some));
    let (due, written) = (triggers.numbers(STAMP), triggers.numbers("written_lsl_s"));
    assert!(due.iter().zip(&written).all(|(due, written)| written.unwrap() >= due.unwrap()), "{due:?} {written:?}");
    assert_eq!(table("drive-clock.parquet").numbers(TIME), [Some(0.035)]);
}
