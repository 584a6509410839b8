//! Changes to recordings by someone who knows the format: a copy with another value, and all checksums recomputed. In: a recording's
//! folder. Out: the same folder, changed.

use super::tampering::{replaced, rows};
use arrow_array::{Array, ArrayRef, BooleanArray, Float64Array, RecordBatch, StringArray, UInt32Array, UInt64Array};
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};
use std::{fs, path::Path, sync::Arc};

pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() { copy(&entry.path(), &to) } else { fs::copy(entry.path(), &to).map(drop).unwrap() }
    }
}

pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns the SHA-256 of a column: for each row a byte 1 and the value, little-endian, texts with their length; or a byte 0 without a
/// value.
pub fn column_sha256(column: &ArrayRef) -> String {
    let (any, mut bytes) = (column.as_any(), Vec::new());
    let mut put = |value: Option<Vec<u8>>| {
        bytes.push(u8::from(value.is_some()));
        bytes.extend(value.unwrap_or_default());
    };
    if let Some(values) = any.downcast_ref::<Float64Array>() {
        values.iter().for_each(|v| put(v.map(|v| v.to_bits().to_le_bytes().to_vec())));
    } else if let Some(values) = any.downcast_ref::<UInt64Array>() {
        values.iter().for_each(|v| put(v.map(|v| v.to_le_bytes().to_vec())));
    } else if let Some(values) = any.downcast_ref::<UInt32Array>() {
        values.iter().for_each(|v| put(v.map(|v| v.to_le_bytes().to_vec())));
    } else if let Some(values) = any.downcast_ref::<BooleanArray>() {
        values.iter().for_each(|v| put(v.map(|v| vec![u8::from(v)])));
    } else if let Some(values) = any.downcast_ref::<StringArray>() {
        values.iter().for_each(|v| put(v.map(|v| [&(v.len() as u64).to_le_bytes(), v.as_bytes()].concat())));
    }
    sha256(&bytes)
}

pub fn files(folder: &Path, within: &str) -> Vec<String> {
    let entries = fs::read_dir(folder.join(within)).unwrap().map(|entry| entry.unwrap());
    let names = entries.flat_map(|entry| {
        let name = format!("{within}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() { files(folder, &format!("{name}/")) } else { vec![name] }
    });
    names.collect()
}

/// Recomputes every checksum of a recording.
pub fn reseal(drive: &Path) {
    let (mut tables, mut others) = (Map::new(), Map::new());
    for name in files(drive, "") {
        let bytes = fs::read(drive.join(&name)).unwrap();
        match name.strip_suffix(".parquet").filter(|name| !name.contains('/')) {
            Some(table) => {
                let all = if bytes.is_empty() { None } else { Some(rows(&drive.join(&name))) };
                let columns = all.iter().filter(|all| all.num_rows() > 0).flat_map(|all| {
                    all.schema()
                        .fields()
                        .iter()
                        .map(|f| f.name().clone())
                        .zip(all.columns().iter().map(column_sha256))
                        .collect::<Vec<_>>()
                });
                let columns: Map<String, Value> = columns.map(|(name, sum)| (name, sum.into())).collect();
                let count = all.as_ref().map_or(0, RecordBatch::num_rows);
                tables.insert(table.into(), json!({ "rows": count, "sha256": sha256(&bytes), "columns": columns }));
            }
            None if ["manifest.json", "checksums.json", "lock"].contains(&name.as_str()) => {}
            None => drop(others.insert(name, sha256(&bytes).into())),
        }
    }
    let text = format!("{:#}\n", json!({ "tables": tables, "files": others }));
    fs::write(drive.join("checksums.json"), &text).unwrap();
    edit_json(&drive.join("manifest.json"), |manifest| {
        manifest["checksums"] = sha256(text.as_bytes()).into();
        manifest.as_object_mut().unwrap().shift_remove("sha256");
        let own = sha256(format!("{manifest:#}\n").as_bytes());
        manifest["sha256"] = own.into();
    });
}

pub fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Changes a JSON file and keeps its formatting.
pub fn edit_json(path: &Path, change: impl FnOnce(&mut Value)) {
    let mut value = read_json(path);
    change(&mut value);
    let end = if fs::read_to_string(path).unwrap().ends_with('\n') { "\n" } else { "" };
    fs::write(path, format!("{value:#}{end}")).unwrap();
}

/// Returns the rows with another value at `row` in each column but `keep`.
pub fn with_other_row(all: &RecordBatch, row: usize, keep: &[&str]) -> RecordBatch {
    let schema = all.schema();
    let columns = schema.fields().iter().zip(all.columns()).map(|(field, column)| {
        if keep.contains(&field.name().as_str()) { Arc::clone(column) } else { with_other_cell(column, row) }
    });
    let columns = columns.collect();
    RecordBatch::try_new(all.schema(), columns).unwrap()
}

fn with_other_cell(column: &ArrayRef, row: usize) -> ArrayRef {
    let any = column.as_any();
    let was = column.is_valid(row);
    if let Some(values) = any.downcast_ref::<Float64Array>() {
        let value = if was { values.value(row) + 1.0 } else { 1e9 };
        Arc::new(Float64Array::from(replaced(values.iter(), row, Some(value))))
    } else if let Some(values) = any.downcast_ref::<UInt64Array>() {
        Arc::new(UInt64Array::from(replaced(values.iter(), row, Some(values.value(row) + 1))))
    } else if let Some(values) = any.downcast_ref::<UInt32Array>() {
        let value = if was { values.value(row) + 1 } else { 9 };
        Arc::new(UInt32Array::from(replaced(values.iter(), row, Some(value))))
    } else if let Some(values) = any.downcast_ref::<BooleanArray>() {
        Arc::new(BooleanArray::from(replaced(values.iter(), row, Some(!(was && values.value(row))))))
    } else {
        let values = any.downcast_ref::<StringArray>().unwrap();
        let word = format!("{}x", if was { values.value(row) } else { "" });
        let all: Vec<Option<String>> = values.iter().map(|word| word.map(str::to_owned)).collect();
        Arc::new(StringArray::from(replaced(all.into_iter(), row, Some(word))))
    }
}
