//! Changes in every column of every table, with all checksums recomputed: a replay finds each column that follows from the drive, on a ring
//! and on a network.

use super::{
    codrive, printed,
    resealed::{SUMO, is_found, replayed, tampered, whole},
    resealing::{edit_json, reseal, with_other_row},
    tampering::{rows, write},
};
use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, StringArray, UInt64Array};
use codrive::{record, time::Tick};
use serde_json::Value;
use std::{collections::BTreeSet, fs, path::Path, sync::Arc};

const CONTROLS: [&str; 10] = [
    "throttle",
    "brake",
    "steering_wheel_rad",
    "selector",
    "indicator",
    "task_button",
    "automation_button",
    "gap_button",
    "hand_torque_nm",
    "main_beam",
];
/// Columns that do not follow from the drive.
const OF_DEVICES: [&str; 3] = ["wheel_force_nm", "shown_frame", "shown_wall_s"];

/// Changes one row of these tables, in all columns but `keep`, and reseals. Returns the changed columns and those that a replay names.
fn changed_columns(of: &Path, tables: &[(&str, &[&str])]) -> [BTreeSet<(String, String)>; 2] {
    let mut changed = BTreeSet::new();
    let (_folder, drive) = tampered(of, |drive| {
        for (table, keep) in tables {
            let path = drive.join(format!("{table}.parquet"));
            let all = rows(&path);
            let names = all.schema().fields().iter().map(|field| field.name().clone()).collect::<Vec<_>>();
            changed.extend(
                names.into_iter().filter(|name| !keep.contains(&name.as_str())).map(|name| ((*table).into(), name)),
            );
            write(&path, &with_other_row(&all, all.num_rows() / 2, keep));
        }
    });
    assert!(record::changes(&drive).unwrap().len() >= changed.len(), "without new checksums");
    reseal(&drive);
    let found = replayed(&drive).unwrap().columns.into_keys().map(|(table, column)| (table.to_owned(), column));
    [changed, found.collect()]
}

#[test]
fn a_change_of_any_column_that_follows_from_the_drive_is_found() {
    let ego: Vec<&str> = ["tick"].into_iter().chain(CONTROLS).chain(OF_DEVICES).collect();
    let advice: Vec<&str> = ["tick"].into_iter().chain(OF_DEVICES).collect();
    let tables = [
        ("ego", &ego[..]),
        ("cars", &["tick"]),
        ("advice", &advice),
        ("events", &["tick", "event"]),
        ("advised", &["tick"]),
    ];
    let [changed, found] = changed_columns(whole(), &tables);
    assert_eq!(found, changed);
    // The tick is the row's position, a control is an input of the drive, and the kind of an event says who made it.
    let single: Vec<(&str, &str)> = ["ego", "cars", "advice", "events", "advised"]
        .map(|table| (table, "tick"))
        .into_iter()
        .chain(CONTROLS.map(|control| ("ego", control)))
        .chain([("events", "event")])
        .collect();
    for (table, column) in single {
        let (_folder, drive) = tampered(whole(), |drive| {
            let path = drive.join(format!("{table}.parquet"));
            let all = rows(&path);
            let names = all.schema().fields().iter().map(|field| field.name().clone()).collect::<Vec<_>>();
            let keep: Vec<&str> = names.iter().map(String::as_str).filter(|name| *name != column).collect();
            write(&path, &with_other_row(&all, all.num_rows() / 2, &keep));
            reseal(drive);
        });
        assert!(is_found(&drive), "{table}.{column}");
    }
    // Values of devices and frames are checked against the checksums only.
    for column in OF_DEVICES {
        let table = if column == "wheel_force_nm" { "ego" } else { "advice" };
        let (_folder, drive) = tampered(whole(), |drive| {
            let path = drive.join(format!("{table}.parquet"));
            let all = rows(&path);
            let names = all.schema().fields().iter().map(|field| field.name().clone()).collect::<Vec<_>>();
            let keep: Vec<&str> = names.iter().map(String::as_str).filter(|name| *name != column).collect();
            write(&path, &with_other_row(&all, 1, &keep));
        });
        assert!(record::changes(&drive).unwrap()[0].what.contains(column), "{column}: without new checksums");
        reseal(&drive);
        assert!(!is_found(&drive), "{column}");
    }
}

#[test]
fn a_missing_new_or_retyped_column_is_found() {
    for (change, what) in [
        ("gone", "column gap_m is missing"),
        ("new", "column more is new"),
        ("kind", "column gap_m has values of another kind"),
    ] {
        let (_folder, drive) = tampered(whole(), |drive| {
            let path = drive.join("ego.parquet");
            let all = rows(&path);
            let at = all.schema().index_of("gap_m").unwrap();
            let words: ArrayRef = Arc::new(StringArray::from(vec!["1"; all.num_rows()]));
            let mut columns: Vec<(String, ArrayRef)> =
                all.schema().fields().iter().map(|f| f.name().clone()).zip(all.columns().iter().cloned()).collect();
            match change {
                "gone" => drop(columns.remove(at)),
                "new" => columns.push(("more".into(), words)),
                _ => columns[at].1 = words,
            }
            write(
                &path,
                &RecordBatch::try_from_iter_with_nullable(columns.into_iter().map(|(n, c)| (n, c, true))).unwrap(),
            );
            reseal(drive);
        });
        let found = record::changes(&drive).unwrap();
        assert!(found.iter().any(|found| found.file == "ego.parquet" && found.what == what), "{change}: {found:?}");
        assert!(is_found(&drive), "{change}");
    }
}

#[test]
fn a_change_of_any_network_column_is_found_and_no_flag_hides_a_table() {
    let _sumo = SUMO.lock();
    let folder = tempfile::tempdir().unwrap();
    let (scenario, drive) = (super::network::town(folder.path()), folder.path().join("town"));
    let arguments =
        ["run", "--scenario", scenario.to_str().unwrap(), "--policy", "pi", "--advised", "50%", "--duration", "30"];
    let (code, text) = printed(codrive(&arguments).arg("--out").arg(&drive));
    assert_eq!(code, 0, "{text}");
    let tables: Vec<(&str, &[&str])> = vec![
        ("departures", &["tick"]),
        ("arrivals", &["tick"]),
        ("signals", &["tick"]),
        ("path", &[]),
        ("cars", &["tick"]),
        ("advised", &["tick"]),
    ];
    let [changed, found] = changed_columns(&drive, &tables);
    assert_eq!(found, changed);
    // The last row of each table is removed.
    let (_folder, short) = tampered(&drive, |drive| {
        for (table, _) in &tables {
            let path = drive.join(format!("{table}.parquet"));
            let all = rows(&path);
            write(&path, &all.slice(0, all.num_rows() - 1));
        }
        reseal(drive);
    });
    let columns = replayed(&short).unwrap().columns;
    for (table, _) in &tables {
        let first = if *table == "path" { "order" } else { "tick" };
        assert_eq!(columns.get(&(*table, first.to_owned())), Some(&1), "{table}: {columns:?}");
    }
    // The manifest's flag and its tables are removed together.
    for (flag, gone) in
        [("network_tables", &["departures", "arrivals", "signals", "path"][..]), ("advised_table", &["advised"])]
    {
        let (_folder, hidden) = tampered(&drive, |drive| {
            edit_json(&drive.join("manifest.json"), |keys| drop(keys.as_object_mut().unwrap().shift_remove(flag)));
            gone.iter().for_each(|table| fs::remove_file(drive.join(format!("{table}.parquet"))).unwrap());
            reseal(drive);
        });
        assert!(is_found(&hidden), "{flag}");
    }
}

#[test]
fn a_difference_in_the_last_bit_alone_is_found() {
    for (table, column) in [("ego", "speed_mps"), ("cars", "x_m"), ("advised", "throttle")] {
        let (_folder, drive) = tampered(whole(), |drive| {
            let path = drive.join(format!("{table}.parquet"));
            let all = rows(&path);
            let at = all.schema().index_of(column).unwrap();
            let numbers = all.column(at).as_any().downcast_ref::<Float64Array>().unwrap();
            let middle = all.num_rows() / 2;
            let other =
                |(row, number): (usize, Option<f64>)| if row == middle { number.map(f64::next_up) } else { number };
            let mut columns = all.columns().to_vec();
            columns[at] = Arc::new(numbers.iter().enumerate().map(other).collect::<Float64Array>());
            write(&path, &RecordBatch::try_new(all.schema(), columns).unwrap());
            reseal(drive);
        });
        let columns = replayed(&drive).unwrap().columns;
        assert_eq!(columns.into_iter().collect::<Vec<_>>(), [((table, column.to_owned()), 1)]);
    }
}

#[test]
fn a_recovered_drive_is_proven_and_one_with_a_hole_is_not() {
    // Rows from this tick on are moved one tick later, so that the tick itself has no row.
    let without = |tick: u64| {
        let (_folder, drive) = tampered(whole(), |drive| {
            fs::remove_file(drive.join("summary.json")).unwrap();
            edit_json(&drive.join("manifest.json"), |keys| {
                (keys["state"], keys["ended"], keys["hash"]) = ("recovered".into(), "cut".into(), Value::Null);
            });
            let path = drive.join("ego.parquet");
            let all = rows(&path);
            let at = all.schema().index_of("tick").unwrap();
            let ticks = all.column(at).as_any().downcast_ref::<UInt64Array>().unwrap();
            let mut columns = all.columns().to_vec();
            columns[at] = Arc::new(ticks.values().iter().map(|t| t + u64::from(*t >= tick)).collect::<UInt64Array>());
            write(&path, &RecordBatch::try_new(all.schema(), columns).unwrap());
            reseal(drive);
        });
        replayed(&drive).unwrap()
    };
    let whole = without(u64::MAX);
    assert!(whole.is_proven() && whole.ticks == 300, "{whole:?}");
    let report = without(131);
    assert!(report.hole == Some(Tick(131)) && !report.is_proven(), "{report:?}");
}
