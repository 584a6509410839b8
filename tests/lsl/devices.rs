//! Tests of devices that are missing, or that disappear and return.

use crate::{
    drive,
    programs::{self, Program},
};
use codrive::{
    live_drive::lab::{LabDevices, LabSettings},
    lsl::{self, Channel, ChannelFormat, LslError, Outlet, OutletInterface, SampleValues, StreamDescription, resolve},
    record::{TableReader, streams},
};
use serde_json::Value;

/// Longest wait for a stream that is there, s: on a busy machine one search of half a second may end before the response.
const PATIENCE_S: f64 = 20.0;

fn settings(record: &str, wait_s: f64) -> LabSettings {
    toml::from_str(&format!(
        "[lsl]\n\
        record = [\"{record}\"]\n\
        wait_s = {wait_s:?}"
    ))
    .unwrap()
}

/// Returns the source ids that `is_wanted` among all streams, when there are `number` of them or after [`PATIENCE_S`].
fn source_ids(number: usize, is_wanted: impl Fn(&String) -> bool) -> Vec<String> {
    let mut left_s = PATIENCE_S;
    loop {
        let streams = lsl::resolve_all(1.0).unwrap().into_iter().map(|stream| stream.source_id);
        let ids: Vec<String> = streams.filter(&is_wanted).collect();
        left_s -= 1.0;
        if ids.len() >= number || left_s <= 0.0 {
            return ids;
        }
    }
}

#[test]
fn a_missing_stream_is_named_with_the_available_ones() {
    programs::on_loopback();
    let mut heart = Program::python("send.py", &["heart", "100", "heart-1"]);
    heart.wait_for("READY", 1);
    let refused = |predicate: &str| LabDevices::open(&settings(predicate, 0.5)).err().unwrap().to_string();
    let device = "name='heart' type='Gaze' source_id='heart-1' (2 channels, 100 Hz, on ";
    // On a busy machine the device may answer after the one second of a search for all streams.
    let mut messages = (0..PATIENCE_S as u32).map(|_| refused("type='EEG'"));
    let message = messages.find(|message| message.contains(device)).expect("a message that names the device");
    assert!(message.starts_with("no LSL stream with type='EEG' was found within 0.5 s. Streams found: "), "{message}");
    let message = refused("type='EEG");
    assert!(message.contains("liblsl refused the predicate type='EEG"), "{message}");
}

#[test]
fn a_search_for_a_stream_ends_when_it_is_cancelled() {
    programs::on_loopback();
    let ended = resolve("name='nobody'", 2.0, &|| true).err().map(|error| error.to_string());
    assert_eq!(ended, Some(LslError::Interrupted.to_string()));
}

#[test]
fn a_device_that_returns_leaves_a_reported_gap() {
    programs::on_loopback();
    let place = tempfile::tempdir().unwrap();
    let recording = place.path().join("drive");
    let mut eyes = Program::python("send.py", &["tracker", "100", "tracker-1"]);
    eyes.wait_for("READY", 1);
    let lab = LabDevices::open(&settings("name='tracker'", PATIENCE_S)).unwrap();
    let again = std::thread::spawn(move || {
        std::thread::sleep(std::time::Duration::from_millis(1_500));
        eyes.kill();
        Program::python("send.py", &["tracker", "100", "tracker-1"])
    });
    let (lab, news) = drive(7.0, lab, &recording);
    drop(lab);
    again.join().unwrap().end();
    assert_eq!(news, ["the LSL stream tracker is gone; codrive searches for it", "the LSL stream tracker is back"]);
    let text = std::fs::read_to_string(recording.join(streams::FOLDER).join("tracker.json")).unwrap();
    let about: Value = serde_json::from_str(&text).unwrap();
    let gaps = about["gaps"].as_array().unwrap();
    let [lost, back] = ["lost_lsl_s", "back_lsl_s"].map(|key| gaps[0][key].as_f64().unwrap());
    assert!(gaps.len() == 1 && back > lost, "{text}");
    // One table holds the samples before and after the gap; the second run counts from 0 again.
    let table = TableReader::parquet(&recording.join(streams::FOLDER).join("tracker.parquet")).unwrap();
    let numbers: Vec<f64> = table.numbers("sample").into_iter().flatten().collect();
    assert_eq!(numbers.windows(2).filter(|pair| pair[1] != pair[0] + 1.0).count(), 1, "{numbers:?}");
    assert!(numbers.len() > 200, "{}", numbers.len());
}

#[test]
#[allow(clippy::disallowed_methods, reason = "the cost of a call is wall time")]
fn a_push_with_a_listener_takes_at_most_a_tenth_of_a_millisecond() {
    programs::on_loopback();
    let channels = (0..14).map(|k| Channel { label: format!("c{k}"), ..Channel::default() }).collect();
    let description = StreamDescription {
        name: "cost".into(),
        content: "Test".into(),
        rate_hz: 100.0,
        format: ChannelFormat::Numbers,
        source_id: "cost-1".into(),
        channels,
    };
    let outlet = Outlet::open(description, &OutletInterface::Loopback).unwrap();
    let mut inlet = lsl::resolve("name='cost'", PATIENCE_S, &|| false).unwrap();
    assert!(
        outlet.push(&[1.0], 1.0).is_err() && outlet.push_texts(&["a"; 14], 1.0).is_err(),
        "the library would read on"
    );
    while !outlet.is_heard() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let (mut costs_us, mut got) = (Vec::new(), Vec::new());
    let value = |k: usize, channel: usize| (k * 14 + channel) as f64 / 3.0;
    for k in 0..500 {
        let sample: Vec<f64> = (0..14).map(|channel| value(k, channel)).collect();
        let begun = std::time::Instant::now();
        outlet.push(&sample, 1000.0 + k as f64).unwrap();
        costs_us.push(begun.elapsed().as_secs_f64() * 1e6);
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    while got.len() < 500 {
        let chunk = inlet.pull().unwrap();
        let SampleValues::Numbers(numbers) = chunk.values else { panic!("numbers were sent") };
        got.extend(chunk.stamps_s.into_iter().zip(numbers.chunks(14).map(<[f64]>::to_vec).collect::<Vec<_>>()));
    }
    for (k, (stamp, sample)) in got.iter().enumerate() {
        assert_eq!(*stamp, 1000.0 + k as f64);
        assert!(sample.iter().enumerate().all(|(channel, got)| *got == value(k, channel)), "{sample:?}");
    }
    costs_us.sort_by(f64::total_cmp);
    println!(
        "a push of 14 numbers: median {:.1} us, 99 % below {:.1}, longest {:.0}",
        costs_us[250], costs_us[495], costs_us[499]
    );
    // A hundredth of a tick. The median is used, as a busy machine has pauses of its own.
    assert!(costs_us[250] < 100.0, "{} us", costs_us[250]);
}

#[test]
fn a_missing_library_is_reported_before_the_drive_if_it_is_needed() {
    let codrive = |arguments: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_codrive"));
        let output = command.args(arguments).env("CODRIVE_LSL", "/nowhere/liblsl.so").output().unwrap();
        (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (is_well, printed) = codrive(&["drive", "--lsl", "--traffic", "native"]);
    assert!(!is_well && printed.contains("liblsl was not found: /nowhere/liblsl.so"), "{printed}");
    assert!(printed.contains("remedy: run scripts/setup --lsl in a checkout, or set CODRIVE_LSL"), "{printed}");
    let (is_well, printed) = codrive(&["run", "--duration", "1", "--traffic", "native"]);
    assert!(is_well, "{printed}");
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), "[triggers]\ndevice = '/dev/ttyUSB0'\nbaud = 12\n").unwrap();
    let (is_well, printed) = codrive(&["drive", "--lab", file.path().to_str().unwrap()]);
    assert!(!is_well && printed.contains(":3:8: baud is 12; allowed: 9600"), "{printed}");
}

/// Returns, for each socket of this process that listens for connections, the number of instructions of its filter.
fn listeners() -> Vec<u32> {
    use nix::libc;
    let names = std::fs::read_dir("/proc/self/fd").unwrap().flatten().map(|entry| entry.file_name());
    let files: Vec<i32> = names.filter_map(|name| name.to_str()?.parse().ok()).collect();
    let asked = |file: i32, option: i32, value: *mut libc::c_void, size: u32| {
        let mut size = size;
        // SAFETY: the value has the given size; a null value asks only for the size.
        (unsafe { libc::getsockopt(file, libc::SOL_SOCKET, option, value, &mut size) } == 0).then_some(size)
    };
    let listens = |file: &i32| {
        let mut flag = 0_i32;
        asked(*file, libc::SO_ACCEPTCONN, (&raw mut flag).cast(), 4).is_some() && flag == 1
    };
    let filter = |file: i32| asked(file, libc::SO_ATTACH_FILTER, std::ptr::null_mut(), 0).unwrap_or(0);
    files.into_iter().filter(listens).map(filter).collect()
}

#[test]
fn streams_open_on_request_and_are_visible_on_this_machine_only() {
    programs::on_loopback();
    let settings = |more: &str| toml::from_str(&format!("[lsl]\noutlets = true\n{more}")).unwrap();
    let is_ours = |id: &String| id.ends_with(".quiet");
    let mut lab = LabDevices::open(&settings("source = 'quiet'")).unwrap();
    let streams = lsl::resolve_all(1.0).unwrap();
    assert!(!streams.iter().any(|stream| is_ours(&stream.source_id)), "before consent there is nothing to be heard");
    lab.open_outlets().unwrap();
    assert_eq!(source_ids(5, is_ours).len(), 5);
    let listeners = listeners();
    assert!(listeners.len() >= 5 && listeners.iter().all(|filter| *filter > 0), "{listeners:?}");
    let message = LabDevices::open(&settings("interface = 'eth77'")).err().unwrap().to_string();
    assert!(
        message.starts_with("there is no network interface \"eth77\"; allowed: loopback, all, or one of "),
        "{message}"
    );
}

#[test]
fn streams_without_an_id_get_a_random_one() {
    programs::on_loopback();
    let ids = || {
        let mut lab = LabDevices::open(&toml::from_str("[lsl]\noutlets = true").unwrap()).unwrap();
        lab.open_outlets().unwrap();
        let is_random = |id: &str| id.rsplit('.').next().is_some_and(|end| end.len() == 16);
        source_ids(1, |id| id.starts_with("codrive.ego.") && is_random(id))
    };
    let (first, second) = (ids(), ids());
    assert!(!first.is_empty() && !second.is_empty() && first[0] != second[0], "{first:?} {second:?}");
}

#[test]
#[allow(clippy::disallowed_methods, reason = "the end of a program is wall time")]
fn a_dead_stream_does_not_delay_the_end_of_a_drive() {
    programs::on_loopback();
    let place = tempfile::tempdir().unwrap();
    let mut eyes = Program::python("send.py", &["frozen", "100", "frozen-1"]);
    eyes.wait_for("READY", 1);
    let mut lab = LabDevices::open(&settings("name='frozen'", PATIENCE_S)).unwrap();
    lab.begin_trial(Some(place.path()), "trial-1-wide").unwrap();
    // The system still accepts connections for the stream, but the stopped program does not respond. The stream is thus found again and
    // queried in vain.
    eyes.stop_answering();
    std::thread::sleep(std::time::Duration::from_secs(6));
    let begun = std::time::Instant::now();
    drop(lab);
    let took_s = begun.elapsed().as_secs_f64();
    assert!(took_s < 1.0, "{took_s} s");
    eyes.kill();
}
