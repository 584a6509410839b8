//! Checksums of a recording, by which later changes of its files are found (`seals`). In: the rows and files as they are
//! written. Out: `checksums.json`.

use super::{
    RecordError, files, inputs,
    manifest::{self, hex},
    seals,
};
use crate::file;
use arrow_array::{Array, ArrayRef, BooleanArray, Float64Array, RecordBatch, StringArray, UInt32Array, UInt64Array};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, ErrorKind, Read, Write},
    path::Path,
};

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

    /// Adds the other files of a recording and saves all checksums. Returns the SHA-256 of the saved file.
    pub(super) fn save(mut self, recording: &Path) -> Result<String, RecordError> {
        let beside = seals::unsealed(recording, &self)?.into_iter().filter(|name| !name.contains('/'));
        for name in beside.chain(inputs::carried(recording)?) {
            let sum = file_sha256(&recording.join(&name))?;
            self.files.insert(name, sum);
        }
        let text = serde_json::to_string_pretty(&self).expect("numbers and words") + "\n";
        files::replace(&recording.join(FILE), text.as_bytes())?;
        Ok(manifest::sha256(text.as_bytes()))
    }
}

/// Returns the SHA-256 of a file, hexadecimal, in bounded memory.
///
/// # Errors
/// The file cannot be read.
pub fn file_sha256(path: &Path) -> Result<String, RecordError> {
    let mut file = file::open_regular(path).map_err(RecordError::file(path))?;
    let mut hash = Sha256::new();
    let mut piece = vec![0; 1 << 16];
    loop {
        match file.read(&mut piece) {
            Ok(0) => return Ok(hex(&hash.finalize())),
            Ok(n) => hash.update(&piece[..n]),
            // A signal interrupted the call before anything was read.
            Err(why) if why.kind() == ErrorKind::Interrupted => {}
            Err(why) => return Err(RecordError::file(path)(why)),
        }
    }
}

/// File with the running SHA-256 of the bytes written to it.
pub(super) struct HashedFile {
    pub file: File,
    pub hash: Sha256,
}

impl Write for HashedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.file.write(bytes)?;
        self.hash.update(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
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
            bytes.iter().map(|(name, bytes)| ((*name).to_owned(), manifest::sha256(bytes))).collect();
        for cuts in [vec![0, 3], vec![0, 1, 3], vec![0, 1, 2, 3]] {
            let mut sums = ColumnSums::default();
            cuts.windows(2).for_each(|pair| sums.push(&rows(pair[0], pair[1])));
            assert_eq!(sums.finish(), expected, "{cuts:?}");
        }
    }

    #[test]
    fn the_sha256_of_a_file_agrees_with_published_values() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file");
        // FIPS 180-2: "abc", and a million times the letter a, which is longer than one read.
        for (text, sum) in [
            (b"abc".to_vec(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"),
            (vec![b'a'; 1_000_000], "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"),
        ] {
            std::fs::write(&path, &text).expect("written");
            assert_eq!(file_sha256(&path).expect("there"), sum);
            let mut hashed = HashedFile { file: File::create(&path).expect("made"), hash: Sha256::new() };
            hashed.write_all(&text).expect("room");
            hashed.flush().expect("room");
            assert_eq!(hex(&hashed.hash.finalize()), sum);
        }
        assert!(file_sha256(&folder.path().join("gone")).is_err());
    }
}
