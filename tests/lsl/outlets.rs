//! Tests of a drive's streams: pylsl and LabRecorder receive them, and they agree with the tables of the recording. Devices with known
//! samples are recorded with the drive.

use crate::{
    drive,
    programs::{self, Program},
    seconds,
};
use codrive::{
    live_drive::lab::{LabDevices, LabSettings},
    record::{Table, TableReader, streams},
};
use serde_json::Value;
use std::path::Path;

const NAMES: [&str; 5] = ["advice", "events", "controls", "ego", "frames"];
/// Promised maximum of clock offsets on one machine, s.
const MOST_JITTER_S: f64 = 1e-3;

/// Data of a stream as another program received it.
struct Received {
    stamps: Vec<f64>,
    values: Vec<Vec<Value>>,
    offsets: Vec<f64>,
}

fn received(all: &Value, name: &str) -> Received {
    let stream = &all[format!("codrive.{name}")];
    let numbers = |key: &str| stream[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let values = stream["values"].as_array().unwrap().iter().map(|sample| sample.as_array().unwrap().clone());
    Received { stamps: numbers("stamps"), values: values.collect(), offsets: numbers("offsets") }
}

/// Returns columns of a table as rows of JSON.
fn rows(table: &TableReader, columns: &[&str]) -> Vec<Vec<Value>> {
    let columns: Vec<Vec<Value>> = columns
        .iter()
        .map(|name| {
            let wholes = table.wholes(name);
            if !wholes.is_empty() {
                return wholes.iter().map(|v| Value::from(*v as f64)).collect();
            }
            table.numbers(name).iter().map(|v| v.map_or(Value::Null, Value::from)).collect()
        })
        .collect();
    (0..table.rows()).map(|row| columns.iter().map(|column| column[row].clone()).collect()).collect()
}

fn spread(values: &[f64]) -> f64 {
    let fold = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick).unwrap_or(f64::NAN);
    fold(f64::max) - fold(f64::min)
}

fn table(recording: &Path, name: &str) -> TableReader {
    TableReader::parquet(&recording.join(streams::FOLDER).join(format!("{name}.parquet"))).unwrap()
}

/// Checks that samples of ticks are 10 ms apart. The beginnings of frames, from which their times follow, jitter by less than the promise.
fn check_ticks(name: &str, stream: &Received) {
    let apart: Vec<f64> = stream.stamps.windows(2).map(|pair| pair[1] - pair[0] - 0.01).collect();
    let off = apart.iter().filter(|apart| apart.abs() >= MOST_JITTER_S).count();
    println!("{name}: {} samples, 10 ms apart but for {:.3} ms at most", stream.stamps.len(), 1e3 * spread(&apart));
    // A late frame skips ticks and their time; only there are stamps further apart.
    assert!(off <= apart.len() / 100, "{name}: {off} of {} are not 10 ms apart", apart.len());
    assert!(stream.stamps.is_sorted());
}

#[test]
fn a_drive_is_received_whole_and_devices_are_recorded_whole_with_it() {
    programs::on_loopback();
    let place = tempfile::tempdir().unwrap();
    let (recording, xdf) = (place.path().join("drive"), place.path().join("drive.xdf"));
    let mut eyes = Program::python("send.py", &["eyes", "200", "eyes-7"]);
    let mut keys = Program::python("send.py", &["keys", "0", "keys-7"]);
    eyes.wait_for("READY", 1);
    keys.wait_for("READY", 1);
    let settings: LabSettings = toml::from_str(
        "[lsl]\noutlets = true\nsource = 'P07'\nrecord = [\"name='eyes'\", \"type='Markers' and name='keys'\"]",
    )
    .unwrap();
    let mut lab = LabDevices::open(&settings).unwrap();
    lab.open_outlets().unwrap();
    let named: Vec<String> = NAMES.iter().map(|name| format!("codrive.{name}")).collect();
    let mut pylsl = Program::python(
        "receive.py",
        &[&["P07"], named.iter().map(String::as_str).collect::<Vec<_>>().as_slice()].concat(),
    );
    let predicates: Vec<String> = named.iter().map(|name| format!("source_id='{name}.P07'")).collect();
    let mut recorder = Program::lab_recorder(&xdf, &predicates);
    pylsl.wait_for("READY", 1);
    recorder.wait_for("Started data collection", NAMES.len());
    // Wait until the receivers have their queues, before the first sample.
    std::thread::sleep(std::time::Duration::from_millis(500));
    let (lab, news) = drive(seconds(), lab, &recording);
    assert!(news.is_empty(), "{news:?}");
    std::thread::sleep(std::time::Duration::from_millis(500));
    let by_pylsl: Value = serde_json::from_str(&pylsl.end()).unwrap();
    recorder.end();
    let by_recorder: Value =
        serde_json::from_str(&Program::python("read_xdf.py", &[xdf.to_str().unwrap()]).end()).unwrap();
    drop(lab);

    let ego = TableReader::parquet(&Table::Ego.parquet(&recording)).unwrap();
    let advice = TableReader::parquet(&Table::Advice.parquet(&recording)).unwrap();
    let frames = TableReader::parquet(&Table::Frames.parquet(&recording)).unwrap();
    let events = TableReader::parquet(&Table::Events.parquet(&recording)).unwrap();
    assert_eq!(ego.rows(), (seconds() * 100.0).round() as usize);
    for (program, all) in [("pylsl", &by_pylsl), ("LabRecorder", &by_recorder)] {
        let stream = |name: &str| received(all, name);
        let place = ["tick", "time_s", "x_m", "y_m", "z_m", "yaw_rad", "speed_mps", "accel_mps2", "lateral_accel_mps2"];
        let motion = ["yaw_rate_radps", "s_m", "lane_offset_m", "gap_m", "leader_speed_mps"];
        assert_eq!(stream("ego").values, rows(&ego, &[&place[..], &motion].concat()), "{program}: ego");
        check_ticks(&format!("{program}, ego"), &stream("ego"));
        let controls = stream("controls").values;
        let pedals: Vec<Vec<Value>> = controls.iter().map(|sample| sample[..5].to_vec()).collect();
        assert_eq!(
            pedals,
            rows(&ego, &["tick", "time_s", "throttle", "brake", "steering_wheel_rad"]),
            "{program}: controls"
        );
        assert!(controls.iter().all(|sample| sample[5] == 1.0), "in drive");
        let issued = rows(&advice, &["tick", "target_mps", "range_low_mps", "range_high_mps", "hold_s"]);
        assert!(issued.len() >= seconds() as usize);
        assert_eq!(stream("advice").values, issued, "{program}: advice");
        let shown = stream("frames");
        let numbers = ["frame", "tick", "fraction", "wall_s", "elapsed_s", "dropped_s"];
        let values: Vec<Vec<Value>> = shown.values.iter().map(|sample| sample[..6].to_vec()).collect();
        assert_eq!(values, rows(&frames, &numbers), "{program}: frames");
        // A frame reaches the screen after its last tick was due.
        let ticks = stream("ego").stamps;
        for (sample, stamp) in shown.values.iter().zip(&shown.stamps) {
            let tick = sample[1].as_f64().unwrap() as usize;
            assert!(tick == 0 || ticks[tick - 1] <= *stamp, "{program}: {sample:?} at {stamp}");
        }
        let rows = stream("events").values;
        let (first, last) = (&rows[0], &rows[rows.len() - 1]);
        assert_eq!(
            (&first[..], &last[..]),
            (&["trial_start".into(), "trial-1-wide".into()][..], &["trial_end".into(), "trial-1-wide".into()][..])
        );
        let between: Vec<(&str, &str)> =
            rows[1..rows.len() - 1].iter().map(|e| (e[0].as_str().unwrap(), e[1].as_str().unwrap())).collect();
        let (kinds, details) = (events.words("event"), events.words("detail"));
        let written: Vec<(&str, &str)> =
            kinds.iter().map(String::as_str).zip(details.iter().map(String::as_str)).collect();
        let mut sorted = [between, written];
        sorted.iter_mut().for_each(|list| list.sort());
        assert_eq!(sorted[0], sorted[1], "{program}: events");
        for name in NAMES {
            let Received { stamps, offsets, .. } = stream(name);
            println!(
                "{program}, {name}: {} samples, offsets {:.1} us apart ({} measured)",
                stamps.len(),
                1e6 * spread(&offsets),
                offsets.len()
            );
            assert!(offsets.is_empty() || spread(&offsets) < MOST_JITTER_S, "{program}, {name}: {offsets:?}");
        }
    }
    // An advice has the time at which its tick began, which is the stamp of the tick before.
    let (advices, ticks) = (received(&by_pylsl, "advice"), received(&by_pylsl, "ego"));
    for (sample, stamp) in advices.values.iter().zip(&advices.stamps).skip(1) {
        let before = sample[0].as_f64().unwrap() as usize - 1;
        assert!((ticks.stamps[before] - stamp).abs() < MOST_JITTER_S, "{sample:?}");
    }
    let xml = by_pylsl["codrive.ego"]["xml"].as_str().unwrap();
    assert!(xml.contains("<label>speed_mps</label>") && xml.contains("<unit>m/s</unit>"), "{xml}");

    check_device(&recording, "eyes", 200.0, eyes.end(), |row, table| {
        // The known series of the sender.
        let (k, pupil) = (table.numbers("sample")[row].unwrap(), table.numbers("pupil")[row].unwrap());
        assert!((pupil - (k / 50.0).sin()).abs() < 1e-12);
        k
    });
    check_device(&recording, "keys", 20.0, keys.end(), |row, table| {
        assert_eq!(table.words("pupil")[row], "left, \"right\"; über");
        table.words("sample")[row].parse().unwrap()
    });
    let changes = || codrive::record::changes(&recording).unwrap();
    assert!(changes().is_empty(), "{:?}", changes());
    std::fs::write(recording.join(streams::FOLDER).join("eyes.json"), "{}").unwrap();
    let altered = changes();
    assert!(altered.len() == 1 && altered[0].file == "streams/eyes.json", "checksums know the streams: {altered:?}");
}

/// Checks the table of a device: no sample is missing between the first and the last, they span the drive, and each has the time that the
/// device gave it.
fn check_device(recording: &Path, name: &str, rate: f64, printed: String, number: impl Fn(usize, &TableReader) -> f64) {
    let table = table(recording, name);
    let mut printed = printed.split_whitespace();
    let (sent, begun) = (printed.next().unwrap().parse::<f64>().unwrap(), hex_float(printed.next().unwrap()));
    let numbers: Vec<f64> = [0, table.rows() - 1].map(|row| number(row, &table)).into();
    let samples = table.rows() as f64;
    assert!(
        numbers[1] - numbers[0] + 1.0 == samples && numbers[1] < sent,
        "{name}: {numbers:?} in {samples} rows of {sent}"
    );
    let (stamps, times) = (table.numbers(streams::STAMP), table.numbers(streams::TIME));
    for (row, stamp) in stamps.iter().enumerate() {
        let due = begun + (numbers[0] + row as f64) / rate;
        assert!((stamp.unwrap() - due).abs() < 1e-9, "{name}: sample {row} of {due} has {stamp:?}");
    }
    let inside: Vec<f64> = times.into_iter().flatten().collect();
    assert!(
        inside.is_sorted() && inside.len() as f64 >= (seconds() - 0.1) * rate,
        "{name}: {} in the drive",
        inside.len()
    );
    let text = std::fs::read_to_string(recording.join(streams::FOLDER).join(format!("{name}.json"))).unwrap();
    let about: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((about["samples"].as_f64(), about["stream"]["name"].as_str()), (Some(samples), Some(name)));
    assert_eq!(about["stream"]["channels"][1]["unit"], "mm");
    let offsets: Vec<f64> =
        about["clock_offsets"].as_array().unwrap().iter().map(|o| o["offset_s"].as_f64().unwrap()).collect();
    // Offsets are measured at the beginning and every 5 s.
    assert!(offsets.len() as f64 >= (seconds() / 5.0).floor() && spread(&offsets) < MOST_JITTER_S, "{offsets:?}");
    assert!(offsets.iter().all(|offset| offset.abs() < MOST_JITTER_S), "one machine has one clock: {offsets:?}");
    println!(
        "{name}: {samples} samples, none lost, offsets {:.1} us apart ({} measured)",
        1e6 * spread(&offsets),
        offsets.len()
    );
}

/// Parses a number as Python's float.hex writes it: 0x1.8p+3.
fn hex_float(text: &str) -> f64 {
    let (mantissa, power) = text.trim_start_matches("0x1.").split_once('p').unwrap();
    let digits = u64::from_str_radix(mantissa, 16).unwrap() as f64 / 16_f64.powi(mantissa.len() as i32);
    (1.0 + digits) * 2_f64.powi(power.parse().unwrap())
}
