//! Checksums of a recording, by which later changes of its files are found (`seals`). In: the rows and files as they are
//! written. Out: `checksums.json`.

use super::{RecordError, sha256::hex};
use crate::file;
use arrow_array::{Array, ArrayRef, BooleanArray, Float64Array, RecordBatch, StringArray, UInt32Array, UInt64Array};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::{collections::BTreeMap, path::Path};

/// File name of the checksums.
pub(super) const FILE: &str = "checksums.json";
/// Files beside the tables in every recording of a drive that was not cut.
pub(super) const OTHERS: [&str; 2] = ["scenario.toml", "summary.json"];

/// SHA-256 sums of a recording, hexadecimal.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Checksums {
    /// Sums of each table, by its name.
    pub tables: BTreeMap<String, TableSums>,
    /// Sums of the other files, by their names.
    pub files: BTreeMap<String, String>,
}

/// SHA-256 sums of a table.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableSums {
    /// Number of rows in the table.
    pub rows: u64,
    /// SHA-256 of the Parquet file.
    pub sha256: String,
    /// SHA-256 of the values of each column. Each row adds a byte 1 and the value, little-endian, or a byte 0 if it is empty.
    pub columns: BTreeMap<String, String>,
}

impl Checksums {
    /// Reads the checksums of a recording.
    ///
    /// # Errors
    /// The file is missing or cannot be read.
    pub fn load(recording: &Path) -> Result<Self, RecordError> {
        let path = recording.join(FILE);
        let text = file::read_text(&path, file::SETTINGS_BYTES).map_err(RecordError::file(&path))?;
        serde_json::from_str(&text).map_err(|e| RecordError::Table { path, why: e.to_string() })
    }
}

/// Running SHA-256 of each column, batch by batch.
#[derive(Default)]
pub(super) struct ColumnSums {
    columns: BTreeMap<String, Sha256>,
    bytes: Vec<u8>,
}

impl ColumnSums {
    pub fn push(&mut self, batch: &RecordBatch) {
        for (field, array) in batch.schema().fields().iter().zip(batch.columns()) {
            self.push_column(field.name(), array);
        }
    }

    fn push_column(&mut self, name: &str, array: &ArrayRef) {
        let Self { columns, bytes } = self;
        bytes.clear();
        let any = array.as_any();
        if let Some(values) = any.downcast_ref::<Float64Array>() {
            values.iter().for_each(|v| put(bytes, v.map(|v| v.to_bits().to_le_bytes())));
        } else if let Some(values) = any.downcast_ref::<UInt64Array>() {
            values.iter().for_each(|v| put(bytes, v.map(u64::to_le_bytes)));
        } else if let Some(values) = any.downcast_ref::<UInt32Array>() {
            values.iter().for_each(|v| put(bytes, v.map(u32::to_le_bytes)));
        } else if let Some(values) = any.downcast_ref::<BooleanArray>() {
            values.iter().for_each(|v| put(bytes, v.map(|v| [u8::from(v)])));
        } else if let Some(values) = any.downcast_ref::<StringArray>() {
            // Words are hashed with their length: "ab", "c" differs from "a", "bc".
            for word in values {
                put(bytes, word.map(|word| (word.len() as u64).to_le_bytes()));
                bytes.extend(word.unwrap_or_default().as_bytes());
            }
        }
        columns.entry(name.into()).or_default().update(&*bytes);
    }

    pub fn finish(self) -> BTreeMap<String, String> {
        self.columns.into_iter().map(|(name, hash)| (name, hex(&hash.finalize()))).collect()
    }
}

fn put<const N: usize>(bytes: &mut Vec<u8>, value: Option<[u8; N]>) {
    bytes.push(u8::from(value.is_some()));
    bytes.extend(value.into_iter().flatten());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::sha256::sha256;
    use arrow_schema::{Field, Schema};
    use std::sync::Arc;

    fn batch(columns: Vec<(&str, ArrayRef)>) -> RecordBatch {
        let fields: Vec<Field> =
            columns.iter().map(|(name, array)| Field::new(*name, array.data_type().clone(), true)).collect();
        let arrays = columns.into_iter().map(|(_, array)| array).collect();
        RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays).expect("equally long")
    }

    #[test]
    fn the_sum_of_a_column_does_not_depend_on_batches() {
        let rows = |from: usize, to: usize| {
            let of = from..to;
            let numbers: Float64Array = [Some(1.0), None, Some(-2.5)][of.clone()].iter().collect();
            let wholes = UInt64Array::from([258, 0, 7][of.clone()].to_vec());
            let ids: UInt32Array = [None, Some(3), None][of.clone()].iter().collect();
            let flags: BooleanArray = [Some(true), Some(false), None][of.clone()].iter().collect();
            let words: StringArray = [Some("ab"), None, Some("c")][of].iter().collect();
            batch(vec![
                ("number", Arc::new(numbers)),
                ("whole", Arc::new(wholes)),
                ("id", Arc::new(ids)),
                ("flag", Arc::new(flags)),
                ("word", Arc::new(words)),
            ])
        };
        // A byte 1 and the value, little-endian, or a byte 0. 1.0 is 0x3ff0_0000_0000_0000, -2.5 is 0xc004_0000_0000_0000.
        let bytes: [(&str, &[u8]); 5] = [
            ("flag", &[1, 1, 1, 0, 0]),
            ("id", &[0, 1, 3, 0, 0, 0, 0]),
            ("number", &[1, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 1, 0, 0, 0, 0, 0, 0, 4, 0xc0]),
            ("whole", &[1, 2, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 7, 0, 0, 0, 0, 0, 0, 0]),
            ("word", b"\x01\x02\0\0\0\0\0\0\0ab\0\x01\x01\0\0\0\0\0\0\0c"),
        ];
        let expected: BTreeMap<String, String> =
            bytes.iter().map(|(name, bytes)| ((*name).to_owned(), sha256(bytes))).collect();
        for cuts in [vec![0, 3], vec![0, 1, 3], vec![0, 1, 2, 3]] {
            let mut sums = ColumnSums::default();
            cuts.windows(2).for_each(|pair| sums.push(&rows(pair[0], pair[1])));
            assert_eq!(sums.finish(), expected, "{cuts:?}");
        }
    }
}
