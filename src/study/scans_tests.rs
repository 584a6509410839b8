//! Tests of shifted dates: range of the draw, and storage of the shift.

use super::*;
use std::fs;

fn log(began: &[&str]) -> SessionLog {
    let item_run = |at: &&str| serde_json::json!({ "item": "a", "outcome": "done", "began": at, "ended": "t" });
    let item_runs: Vec<Value> = began.iter().map(item_run).collect();
    serde_json::from_value(serde_json::json!({
        "participant": "P1", "index": 0, "kind": "person", "order": [], "item_runs": item_runs,
    }))
    .unwrap()
}

#[test]
fn shifted_dates_lie_in_1902_to_1920_and_intervals_stay() {
    let first = "2026-11-22T09:15:30Z";
    let drawn = |random| DateShift::drawn(first.parse().unwrap(), random).unwrap();
    // From 1902-01-01 there are 45,616 days to that day, and 6,940 to 1921-01-01 (Python, datetime).
    assert_eq!([0, 6939, 6940].map(|random| drawn(random).days), [-45_616, -38_677, -45_616]);
    let first_and_last = [0, 6939].map(|random| drawn(random).shifted(first));
    assert_eq!(first_and_last, ["1902-01-01T09:15:30Z", "1920-12-31T09:15:30Z"]);
    // By the calendar: 29 days and 14 h 44 min 35 s later, over the turn of the year; and eleven weeks later.
    let later = ["2026-12-22T00:00:05Z", "2027-02-07T09:15:30Z"].map(|at| drawn(0).shifted(at));
    assert_eq!(later, ["1902-01-31T00:00:05Z", "1902-03-19T09:15:30Z"]);
    assert_eq!(drawn(0).shifted("yesterday"), "");
    assert_eq!(drawn(0).shifted("-009999-01-02T01:59:59Z"), "", "no day before the first");
}

#[test]
fn a_shift_is_drawn_once_and_kept_with_the_raw_data() {
    let folder = tempfile::tempdir().unwrap();
    let of = |log: &SessionLog| DateShift::of(folder.path(), log);
    let path = folder.path().join(SHIFT_FILE);
    assert_eq!(of(&log(&["t0"])).unwrap(), None);
    assert!(!path.exists(), "without a time there is nothing to move");
    let log = log(&["t0", "2026-11-22T09:15:30Z"]);
    let shift = of(&log).unwrap().unwrap();
    let year: i32 = shift.shifted("2026-11-22T09:15:30Z")[..4].parse().unwrap();
    assert!((1902..=1920).contains(&year), "{year}");
    assert_eq!(of(&log).unwrap(), Some(shift), "the tables that are made again have the same dates");
    fs::write(&path, "{\"days\": -40000}\n").unwrap();
    // 2026-11-22 minus 40,000 days (Python, datetime).
    assert_eq!(of(&log).unwrap().unwrap().shifted("2026-11-22T09:15:30Z"), "1917-05-18T09:15:30Z");
    fs::write(&path, "{\"days\": 1.5}").unwrap();
    let message = of(&log).unwrap_err().to_string();
    for has in ["date-shift.json", "allowed is {\"days\": -37000}", "1.5", "delete it"] {
        assert!(message.contains(has), "{message}");
    }
}
