//! Tests of stream tables: the Parquet file has the appended rows with the drive time, by hand, also after a cut.

use super::*;
use crate::record::TableReader;
use std::fs::OpenOptions;

fn stream(recording: &Path, name: &str) -> StreamJournal {
    let columns = [
        StreamColumn::number(STAMP, "s", "its own time stamp"),
        StreamColumn::number(OFFSET, "s", "offset"),
        StreamColumn::number("pupil", "mm", ""),
        StreamColumn::text("eye", ""),
        StreamColumn::number("pupil", "mm", "a name that comes twice"),
        StreamColumn::number(TIME, "s", "a name that is the table's own"),
    ];
    StreamJournal::begin(recording, name, &columns).expect("room")
}

fn rows(stamps: &[f64], offset: f64) -> Vec<StreamValues> {
    let n = stamps.len();
    let numbers = |value: f64| StreamValues::Numbers(vec![value; n]);
    vec![
        StreamValues::Numbers(stamps.to_vec()),
        numbers(offset),
        numbers(3.5),
        StreamValues::Texts(vec!["left".into(); n]),
        numbers(f64::NAN),
        numbers(7.0),
    ]
}

/// Writes a clock that starts at 100 s, pauses from 102 to 104 s and continues.
fn clock(recording: &Path) {
    let columns = [StreamColumn::number(STAMP, "s", ""), StreamColumn::number(TIME, "s", "")];
    let mut journal = StreamJournal::begin(recording, CLOCK, &columns).expect("room");
    for (stamp, time) in [(100.0, 0.0), (102.0, 2.0), (104.0, 2.0), (105.0, 3.0)] {
        journal.append(vec![StreamValues::Numbers(vec![stamp]), StreamValues::Numbers(vec![time])]).expect("room");
    }
}

fn table(recording: &Path, name: &str) -> TableReader {
    TableReader::parquet(&recording.join(FOLDER).join(format!("{name}.parquet"))).expect("a table")
}

#[test]
fn samples_have_the_time_of_the_drive_at_which_they_were_taken() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path();
    clock(recording);
    let mut journal = stream(recording, "eyes/left");
    // The device's clock is 50 s behind: 100, 101, 102 on this machine's clock. Then the measured offset is one millisecond
    // larger.
    journal.append(rows(&[49.9, 50.0, 51.0, 52.0], 50.0)).expect("room");
    journal.append(rows(&[52.999, 54.499, 55.1], 50.001)).expect("room");
    journal.append(rows(&[50.0], f64::NAN)).expect("room");
    assert_eq!((journal.name().as_str(), journal.rows()), ("eyes-left", 8));
    drop(journal);
    let mut holes = Vec::new();
    settle(recording, &mut holes).expect("room");
    assert!(holes.is_empty(), "{holes:?}");
    let eyes = table(recording, "eyes-left");
    let times: Vec<Option<f64>> = eyes.numbers(TIME).iter().map(|t| t.map(|t| (t * 1e6).round() / 1e6)).collect();
    // Before the start; 0, 1, 2; paused at 103 s; half a second after the pause; after the end; no offset.
    assert_eq!(times, [None, Some(0.0), Some(1.0), Some(2.0), Some(2.0), Some(2.5), None, None]);
    assert_eq!(eyes.numbers("pupil"), vec![Some(3.5); 8]);
    assert_eq!((eyes.words("eye"), eyes.numbers("pupil-2")), (vec!["left".to_owned(); 8], vec![None; 8]));
    assert_eq!(eyes.numbers("time_s-2"), vec![Some(7.0); 8], "the device's own column of that name");
    assert_eq!(table(recording, CLOCK).numbers(TIME), [0.0, 2.0, 2.0, 3.0].map(Some));
    let left: Vec<_> =
        fs::read_dir(recording.join(FOLDER)).expect("there").map(|e| e.expect("there").file_name()).collect();
    assert_eq!(left.len(), 2, "no journals: {left:?}");
}

#[test]
fn streams_of_one_name_get_a_table_each_even_without_samples() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path();
    let mut first = stream(recording, "eyes");
    first.append(rows(&[1.0], 0.0)).expect("room");
    assert_eq!(stream(recording, "eyes").name(), "eyes-2");
    assert_eq!(stream(recording, "..").name(), "stream");
    settle(recording, &mut Vec::new()).expect("room");
    assert_eq!(["eyes", "eyes-2"].map(|name| table(recording, name).rows()), [1, 0]);
    assert_eq!(stream(recording, "eyes").name(), "eyes-3", "a table is not written over");
    assert!(first.append(vec![StreamValues::Numbers(vec![1.0])]).is_err(), "columns that are not the table's");
}

#[test]
fn a_cut_loses_the_last_batch_only() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path();
    let mut journal = stream(recording, "eeg");
    (0..3).for_each(|k| journal.append(rows(&[f64::from(k)], 0.0)).expect("room"));
    let path = journal.path.clone();
    let length = fs::metadata(&path).expect("there").len();
    OpenOptions::new().write(true).open(&path).and_then(|file| file.set_len(length - 5)).expect("cut");
    let mut holes = Vec::new();
    settle(recording, &mut holes).expect("room");
    assert_eq!(table(recording, "eeg").numbers(STAMP), [Some(0.0), Some(1.0)]);
    assert!(holes.len() == 1 && path.exists(), "what cannot be read is kept: {holes:?}");
}

#[test]
fn a_wide_stream_and_long_texts_are_read_back_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path();
    let stamps = || StreamValues::Numbers((0..300).map(f64::from).collect());
    let wide: Vec<StreamColumn> = (0..4096).map(|k| StreamColumn::number(&format!("c{k}"), "uV", "")).collect();
    let columns = [vec![StreamColumn::number(STAMP, "s", "")], wide].concat();
    let mut journal = StreamJournal::begin(recording, "wide", &columns).expect("room");
    let value = |row: usize, k: usize| (row * 5000 + k) as f64 / 7.0;
    let channel = |k: usize| StreamValues::Numbers((0..300).map(|row| value(row, k)).collect());
    journal.append([stamps()].into_iter().chain((0..4096).map(channel)).collect()).expect("room");
    // 300 texts of a megabyte that does not compress into nothing.
    let text = |row: usize| -> String {
        (0..1 << 17).map(|k: usize| format!("{:08x}", k.wrapping_mul(2654435761 + row) as u32)).collect()
    };
    let columns = [StreamColumn::number(STAMP, "s", ""), StreamColumn::text("word", "")];
    let mut journal = StreamJournal::begin(recording, "texts", &columns).expect("room");
    let twelve = |column: Vec<f64>| StreamValues::Numbers(column[..12].to_vec());
    let StreamValues::Numbers(all) = stamps() else { panic!("numbers") };
    for _ in 0..6 {
        journal.append(vec![twelve(all.clone()), StreamValues::Texts((0..12).map(text).collect())]).expect("room");
    }
    let mut holes = Vec::new();
    settle(recording, &mut holes).expect("room");
    assert!(holes.is_empty(), "{holes:?}");
    let wide = table(recording, "wide");
    for k in [0, 1, 4095] {
        assert_eq!(wide.numbers(&format!("c{k}")), (0..300).map(|row| Some(value(row, k))).collect::<Vec<_>>());
    }
    let words = table(recording, "texts").words("word");
    assert!(words.len() == 72 && words.iter().enumerate().all(|(row, word)| *word == text(row % 12)));
}

#[test]
fn a_row_too_large_for_a_block_is_refused_and_earlier_rows_are_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let columns = [StreamColumn::number(STAMP, "s", ""), StreamColumn::text("word", "")];
    let mut journal = StreamJournal::begin(folder.path(), "texts", &columns).expect("room");
    let row = |text: String| vec![StreamValues::Numbers(vec![1.0]), StreamValues::Texts(vec![text])];
    journal.append(row("short".into())).expect("room");
    let message = journal.append(row("x".repeat((32 << 20) + 1))).unwrap_err().to_string();
    assert!(message.contains("a sample has 33554441 bytes; allowed: 33554432"), "{message}");
    settle(folder.path(), &mut Vec::new()).expect("room");
    assert_eq!(table(folder.path(), "texts").words("word"), ["short"]);
}
