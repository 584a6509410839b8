//! Parquet tables in parts, as many runs write them. In: rows; files of equal columns. Out: Parquet as bytes; one file joined
//! from many.

use super::{
    RecordError, files,
    table::{TableBatches, TableColumn, batch, schema, table_fault},
};
use arrow_schema::Schema;
use parquet::{
    arrow::ArrowWriter,
    basic::{Compression, ZstdLevel},
    file::{
        metadata::KeyValue,
        properties::{WriterProperties, WriterPropertiesBuilder},
    },
};
use std::{
    io::Write,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Stand-in for the path of a table that has no file yet, in messages.
const UNWRITTEN: &str = "a part";

/// Returns rows as a Parquet file in memory, with `about` (key, value) in its metadata.
///
/// # Errors
/// The library rejects the rows.
pub fn parquet_bytes<R>(
    columns: &[TableColumn<R>],
    rows: &[R],
    about: &[(&str, String)],
) -> Result<Vec<u8>, RecordError> {
    let schema = schema(columns);
    let about = about.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone())).collect();
    let properties = properties().set_key_value_metadata(Some(about)).build();
    let fault = |why| table_fault(Path::new(UNWRITTEN))(why);
    let mut writer = ArrowWriter::try_new(Vec::new(), Arc::clone(&schema), Some(properties)).map_err(&fault)?;
    writer.write(&batch(&schema, columns, rows)).map_err(&fault)?;
    writer.into_inner().map_err(&fault)
}

/// Joins the rows of several files, in their order, into one file. The columns are those of the first; the metadata of the
/// parts is dropped. Returns the number of rows.
///
/// # Errors
/// A file is missing or has other columns, or an I/O error; an existing file at `out` then stays.
pub fn join(parts: &[PathBuf], out: &Path) -> Result<u64, RecordError> {
    let mut rows = 0;
    files::replace_streaming(out, |file| {
        let mut writer: Option<ArrowWriter<&mut (dyn Write + Send)>> = None;
        let mut file = Some(file);
        for path in parts {
            let batches = TableBatches::open(path)?;
            if let Some(file) = file.take() {
                // Columns only: the metadata of the first part does not apply to the whole.
                let columns = Arc::new(Schema::new(batches.schema().fields().clone()));
                let made = ArrowWriter::try_new(file, columns, Some(properties().build()));
                writer = Some(made.map_err(table_fault(out))?);
            }
            for batch in batches {
                let batch = batch?;
                rows += batch.num_rows() as u64;
                writer.iter_mut().try_for_each(|writer| writer.write(&batch)).map_err(table_fault(path))?;
            }
        }
        writer.map_or(Ok(()), |writer| writer.close().map(|_| ()).map_err(table_fault(out)))
    })?;
    Ok(rows)
}

fn properties() -> WriterPropertiesBuilder {
    WriterProperties::builder().set_compression(Compression::ZSTD(ZstdLevel::default()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{TableReader, table::ColumnValue};

    fn columns() -> [TableColumn<u64>; 1] {
        [TableColumn { name: "n", unit: "m", about: "a number", get: ColumnValue::Whole(|row| *row) }]
    }

    #[test]
    fn parts_are_joined_in_order_and_equal_rows_give_equal_bytes() {
        let folder = tempfile::tempdir().expect("a folder");
        let part =
            |rows: &[u64], about: &str| parquet_bytes(&columns(), rows, &[("about", about.into())]).expect("bytes");
        assert_eq!(part(&[1, 2], "x"), part(&[1, 2], "x"));
        assert_ne!(part(&[1, 2], "x"), part(&[1, 2], "y"));
        let put = |name: &str, bytes: Vec<u8>| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).expect("written");
            path
        };
        let parts = [put("a", part(&[5, 6], "a")), put("b", part(&[], "b")), put("c", part(&[7], "c"))];
        let out = folder.path().join("all.parquet");
        assert_eq!(join(&parts, &out).expect("joined"), 3);
        assert_eq!(TableReader::parquet(&out).expect("a table").wholes("n"), [5, 6, 7]);
        let whole = std::fs::read(&out).expect("bytes");
        // The metadata of the parts is not in the whole, so the same rows from other parts give the same file.
        let others = [put("d", part(&[5, 6], "d")), put("e", part(&[], "e")), put("f", part(&[7], "f"))];
        join(&others, &out).expect("joined");
        assert_eq!(std::fs::read(&out).expect("bytes"), whole);
        // Parts without rows give a table without rows.
        let empty = folder.path().join("empty.parquet");
        assert_eq!(join(&parts[1..2], &empty).expect("joined"), 0);
        assert_eq!(TableReader::parquet(&empty).expect("a table").rows(), 0);
        // An invalid part is named in the error, and the existing file stays.
        let broken = [parts[0].clone(), put("g", b"no table".into())];
        let why = join(&broken, &out).expect_err("no table").to_string();
        assert!(why.contains("/g: no Parquet file"), "{why}");
        assert_eq!(std::fs::read(&out).expect("bytes"), whole);
    }
}
