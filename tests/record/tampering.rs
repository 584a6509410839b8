//! A replay detects later changes of a recording: it names table, row, column and both values where the drive differs, and file and column
//! of values from devices.

use super::{codrive, printed};
use arrow_array::{Array, ArrayRef, BooleanArray, Float64Array, RecordBatch, StringArray, UInt32Array, UInt64Array};
use parquet::arrow::{ArrowWriter, arrow_reader::ParquetRecordBatchReaderBuilder};
use std::{
    fs::{self, File},
    path::Path,
    sync::Arc,
};

/// New value of a cell, by column type.
enum Cell {
    Number(f64),
    Whole(u64),
    Id(u32),
    Flag(bool),
    Word(&'static str),
}

pub fn replaced<T>(values: impl Iterator<Item = T>, row: usize, value: T) -> Vec<T> {
    let mut all: Vec<T> = values.collect();
    all[row] = value;
    all
}

pub fn rows(path: &Path) -> RecordBatch {
    let reader = ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap();
    let schema = Arc::clone(reader.schema());
    let batches: Vec<RecordBatch> = reader.with_batch_size(1 << 20).build().unwrap().map(Result::unwrap).collect();
    match &batches[..] {
        [batch] => batch.clone(),
        [] => RecordBatch::new_empty(schema),
        _ => panic!("{} batches", batches.len()),
    }
}

pub fn write(path: &Path, rows: &RecordBatch) {
    let mut writer = ArrowWriter::try_new(File::create(path).unwrap(), rows.schema(), None).unwrap();
    writer.write(rows).unwrap();
    writer.close().unwrap();
}

/// Changes one cell of a table. Returns the previous value as text.
fn change(path: &Path, row: usize, column: &str, cell: &Cell) -> String {
    let batch = rows(path);
    let at = batch.schema().index_of(column).unwrap();
    let array = batch.column(at);
    let any = array.as_any();
    let (new, was): (ArrayRef, String) = match cell {
        Cell::Number(value) => {
            let values = any.downcast_ref::<Float64Array>().unwrap();
            let was = if values.is_null(row) { "empty".into() } else { values.value(row).to_string() };
            (Arc::new(Float64Array::from(replaced(values.iter(), row, Some(*value)))), was)
        }
        Cell::Whole(value) => {
            let values = any.downcast_ref::<UInt64Array>().unwrap();
            (Arc::new(UInt64Array::from(replaced(values.iter(), row, Some(*value)))), values.value(row).to_string())
        }
        Cell::Id(value) => {
            let values = any.downcast_ref::<UInt32Array>().unwrap();
            let was = if values.is_null(row) { "empty".into() } else { values.value(row).to_string() };
            (Arc::new(UInt32Array::from(replaced(values.iter(), row, Some(*value)))), was)
        }
        Cell::Flag(value) => {
            let values = any.downcast_ref::<BooleanArray>().unwrap();
            (Arc::new(BooleanArray::from(replaced(values.iter(), row, Some(*value)))), values.value(row).to_string())
        }
        Cell::Word(value) => {
            let values = any.downcast_ref::<StringArray>().unwrap();
            let was = format!("{:?}", values.value(row));
            (Arc::new(StringArray::from(replaced(values.iter(), row, Some(*value)))), was)
        }
    };
    let mut columns = batch.columns().to_vec();
    columns[at] = new;
    write(path, &RecordBatch::try_new(batch.schema(), columns).unwrap());
    was
}

/// A drive of 6 s with advice every second; `copy` makes a named copy of it.
struct Drive {
    folder: tempfile::TempDir,
}

impl Drive {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("whole");
        let arguments =
            ["run", "--traffic", "native", "--duration", "6", "--hold", "1", "--policy", "pi", "--driver", "follow"];
        codrive(&arguments).arg("--out").arg(&out).assert().success();
        Self { folder }
    }

    fn copy(&self, name: &str) -> std::path::PathBuf {
        let (from, to) = (self.folder.path().join("whole"), self.folder.path().join(name));
        fs::create_dir(&to).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
        to
    }
}

fn replay(drive: &Path) -> (i32, String) {
    printed(&mut codrive(&["replay", drive.to_str().unwrap()]))
}

#[test]
fn a_changed_cell_of_any_table_is_named_with_row_column_and_both_values() {
    let drive = Drive::new();
    let cells = [
        ("ego", 299, "3.00", "speed_mps", Cell::Number(4.25), "4.25"),
        ("ego", 0, "0.01", "ttc_s", Cell::Number(1e9), "1000000000"),
        ("ego", 599, "6.00", "in_range", Cell::Flag(false), "false"),
        ("ego", 100, "1.01", "hash", Cell::Whole(7), "7"),
        ("ego", 450, "4.51", "leader", Cell::Id(3), "3"),
        ("cars", 22 * 9 + 21, "1.00", "accel_mps2", Cell::Number(-0.5), "-0.5"),
        ("cars", 22 * 30, "3.10", "s_m", Cell::Number(-0.0), "-0"),
        ("advice", 2, "2.10", "target_mps", Cell::Number(3.0), "3"),
        ("events", 0, "6.00", "detail", Cell::Word("contact"), "\"contact\""),
    ];
    for (table, row, time_s, column, cell, recorded) in cells {
        let copy = drive.copy(&format!("{table}-{column}"));
        let was = change(&copy.join(format!("{table}.parquet")), row, column, &cell);
        let (code, text) = replay(&copy);
        let place = format!("{table}.parquet, row {row} (");
        assert!(code == 1 && text.contains(&place), "{text}");
        assert!(text.contains(&format!(" s), column {column}: recorded {recorded}, driven again {was}")), "{text}");
        assert!(text.contains(&format!("({time_s} s)")) || table == "advice", "{time_s}: {text}");
        assert!(text.contains(&format!("{table}.parquet: column {column} is not as it was written")), "{text}");
        assert!(!text.contains("cells and rows that differ"), "one cell: {text}");
    }
}

#[test]
fn a_changed_input_is_named_by_its_column_and_by_what_it_changes() {
    let drive = Drive::new();
    let copy = drive.copy("input");
    change(&copy.join("ego.parquet"), 200, "throttle", &Cell::Number(1.0));
    change(&copy.join("ego.parquet"), 200, "brake", &Cell::Number(0.0));
    let (code, text) = replay(&copy);
    assert!(code == 1 && text.contains("ego.parquet: column throttle is not as it was written"), "{text}");
    assert!(
        text.contains("first difference: ego.parquet, row 20") && text.contains("cells and rows that differ: "),
        "{text}"
    );
}

#[test]
fn changed_values_of_devices_are_named_by_file_and_column() {
    let drive = Drive::new();
    for (table, column, cell) in [
        ("ego", "wheel_force_nm", Cell::Number(0.5)),
        ("advice", "shown_frame", Cell::Id(3)),
        ("advice", "shown_wall_s", Cell::Number(1.5)),
    ] {
        let copy = drive.copy(column);
        change(&copy.join(format!("{table}.parquet")), 1, column, &cell);
        let (code, text) = replay(&copy);
        assert!(code == 1 && text.contains(&format!("{table}.parquet: column {column} is not as it was")), "{text}");
        assert!(!text.contains("first difference"), "nothing that a drive makes: {text}");
    }
}

#[test]
fn removed_and_added_rows_are_named() {
    let drive = Drive::new();
    for (table, row) in [("cars", 60 * 22), ("advice", 6), ("events", 1)] {
        let path = |copy: &Path| copy.join(format!("{table}.parquet"));
        let copy = drive.copy(&format!("{table}-out"));
        let all = rows(&path(&copy));
        assert_eq!(all.num_rows(), row, "{table}");
        write(&path(&copy), &all.slice(0, row - 1));
        let (code, text) = replay(&copy);
        assert!(code == 1 && text.contains(&format!("{table}.parquet, row {}", row - 1)), "{text}");
        assert!(text.contains(": recorded nothing, driven again "), "{text}");
        assert!(text.contains(&format!("{table}.parquet: has {} rows; {row} were written", row - 1)), "{text}");

        let copy = drive.copy(&format!("{table}-in"));
        let twice = joined(&all, &all.slice(row - 1, 1));
        write(&path(&copy), &twice);
        let (code, text) = replay(&copy);
        assert!(code == 1 && text.contains(", driven again nothing"), "{text}");
        assert!(text.contains(&format!("{table}.parquet: has {} rows; {row} were written", row + 1)), "{text}");
    }
    // A step removed from the middle changes its own rows only.
    let copy = drive.copy("step-out");
    let all = rows(&copy.join("cars.parquet"));
    write(&copy.join("cars.parquet"), &joined(&all.slice(0, 22 * 20), &all.slice(22 * 21, 22 * 39)));
    let (code, text) = replay(&copy);
    assert!(
        code == 1 && text.contains("cars.parquet, row 440 (2.10 s), column tick: recorded nothing, driven again 210"),
        "{text}"
    );
    assert!(text.contains("cells and rows that differ: 22 in 600 ticks"), "{text}");
    // A step written twice adds its own rows only.
    let copy = drive.copy("step-twice");
    let all = rows(&copy.join("cars.parquet"));
    write(&copy.join("cars.parquet"), &joined(&all.slice(0, 22 * 21), &all.slice(22 * 20, 22 * 40)));
    let (code, text) = replay(&copy);
    assert!(
        code == 1 && text.contains("cars.parquet, row 462 (2.10 s), column tick: recorded 210, driven again nothing"),
        "{text}"
    );
    assert!(text.contains("cells and rows that differ: 22 in 600 ticks"), "{text}");
    // The last step is repeated at the end.
    let copy = drive.copy("step-after");
    let all = rows(&copy.join("cars.parquet"));
    write(&copy.join("cars.parquet"), &joined(&all, &all.slice(all.num_rows() - 22, 22)));
    let (code, text) = replay(&copy);
    assert!(code == 1 && text.contains("cells and rows that differ: 22 in 600 ticks"), "{text}");
    // An ego row is removed from the middle: the ticks after it cannot be driven.
    let copy = drive.copy("ego-out");
    let all = rows(&copy.join("ego.parquet"));
    write(&copy.join("ego.parquet"), &joined(&all.slice(0, 50), &all.slice(51, 549)));
    let (code, text) = replay(&copy);
    assert!(code == 1 && text.contains("ego.parquet: rows are missing from 0.51 s on"), "{text}");
}

/// Concatenates two batches column by column.
fn joined(first: &RecordBatch, second: &RecordBatch) -> RecordBatch {
    let columns = first.columns().iter().zip(second.columns()).map(|(a, b)| -> ArrayRef {
        let (a, b) = (a.as_any(), b.as_any());
        macro_rules! of_kind {
            ($kind:ty) => {
                if let (Some(a), Some(b)) = (a.downcast_ref::<$kind>(), b.downcast_ref::<$kind>()) {
                    return Arc::new(a.iter().chain(b.iter()).collect::<$kind>());
                }
            };
        }
        of_kind!(Float64Array);
        of_kind!(UInt64Array);
        of_kind!(UInt32Array);
        of_kind!(BooleanArray);
        of_kind!(StringArray);
        panic!("a column of another kind")
    });
    RecordBatch::try_new(first.schema(), columns.collect()).unwrap()
}

#[test]
fn a_changed_manifest_scenario_summary_or_checksum_list_is_named() {
    let drive = Drive::new();
    for (file, from, to, also) in [
        ("manifest.json", "\"seed\": 1", "\"seed\": 2", "its own SHA-256 differs"),
        ("manifest.json", "\"driver\": \"simulated: follow\"", "\"driver\": \"keyboard\"", "its own SHA-256 differs"),
        ("manifest.json", "\"program\"", "\"added\": 1,\n  \"program\"", "its own SHA-256 differs"),
        ("summary.json", "\"mean_speed_mps\": ", "\"mean_speed_mps\": 1", "its SHA-256 differs"),
        ("checksums.json", "\"rows\": 600", "\"rows\": 601", "manifest.json has another SHA-256 of it"),
        ("scenario.toml", "seed = 1\n", "seed = 2\n", "its SHA-256 differs"),
    ] {
        let copy = drive.copy(&format!("{file}-{}", to.len()));
        let path = copy.join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file}: {text}");
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let (code, text) = replay(&copy);
        assert!(code == 1 && text.contains(&format!("{file}: is not as it was written: {also}")), "{text}");
        // Another seed changes the world from the first step with noise on.
        assert_eq!(text.contains("first difference"), file == "scenario.toml", "{text}");
    }
    let copy = drive.copy("gone");
    fs::remove_file(copy.join("checksums.json")).unwrap();
    let (code, text) = replay(&copy);
    assert!(code == 1 && text.contains("checksums.json: is missing"), "{text}");
}
