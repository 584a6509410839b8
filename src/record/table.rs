//! Table as a list of columns with name, unit, meaning and source of the value. In: rows of one type. Out: Arrow batches; in
//! reverse, columns by name from a file. A column is named in its list only.

use super::RecordError;
use crate::{file, foreign::guarded};
use arrow_array::{
    Array, ArrayRef, BooleanArray, Float64Array, RecordBatch, RecordBatchReader, StringArray, UInt32Array, UInt64Array,
};
use arrow_schema::{DataType, Field, Schema};
use parquet::{
    arrow::{
        ProjectionMask,
        arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder},
    },
    errors::ParquetError,
};
use std::{
    collections::BTreeMap,
    fmt::Display,
    fs::File,
    io,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Accessor of a row's value, by type.
pub enum ColumnValue<R> {
    /// Number; empty if the row has none.
    Number(fn(&R) -> Option<f64>),
    /// Count, tick or hash.
    Whole(fn(&R) -> u64),
    /// Small whole number, such as the number of a vehicle; empty if the row has none.
    Id(fn(&R) -> Option<u32>),
    /// Boolean; empty if the row has none.
    Flag(fn(&R) -> Option<bool>),
    /// Text; never empty as a cell.
    Word(fn(&R) -> String),
}

/// Column of a table.
pub struct TableColumn<R> {
    /// Name, with its unit as a suffix.
    pub name: &'static str,
    /// Unit as text; empty if it has none.
    pub unit: &'static str,
    /// Meaning, for the description in the file.
    pub about: &'static str,
    /// Accessor of the value in a row.
    pub get: ColumnValue<R>,
}

impl<R> TableColumn<R> {
    fn kind(&self) -> DataType {
        match self.get {
            ColumnValue::Number(_) => DataType::Float64,
            ColumnValue::Whole(_) => DataType::UInt64,
            ColumnValue::Id(_) => DataType::UInt32,
            ColumnValue::Flag(_) => DataType::Boolean,
            ColumnValue::Word(_) => DataType::Utf8,
        }
    }

    fn array(&self, rows: &[R]) -> ArrayRef {
        match self.get {
            ColumnValue::Number(get) => Arc::new(rows.iter().map(get).collect::<Float64Array>()),
            ColumnValue::Whole(get) => Arc::new(UInt64Array::from_iter_values(rows.iter().map(get))),
            ColumnValue::Id(get) => Arc::new(rows.iter().map(get).collect::<UInt32Array>()),
            ColumnValue::Flag(get) => Arc::new(rows.iter().map(get).collect::<BooleanArray>()),
            ColumnValue::Word(get) => Arc::new(StringArray::from_iter_values(rows.iter().map(get))),
        }
    }
}

/// Returns a column of numbers.
pub(super) const fn number<R>(
    name: &'static str,
    unit: &'static str,
    about: &'static str,
    get: fn(&R) -> Option<f64>,
) -> TableColumn<R> {
    TableColumn { name, unit, about, get: ColumnValue::Number(get) }
}

/// Returns a column with this accessor.
pub(super) const fn column<R>(
    name: &'static str,
    unit: &'static str,
    about: &'static str,
    get: ColumnValue<R>,
) -> TableColumn<R> {
    TableColumn { name, unit, about, get }
}

/// Returns the columns as an Arrow schema, with unit and meaning as metadata.
pub fn schema<R>(columns: &[TableColumn<R>]) -> Arc<Schema> {
    let field = |column: &TableColumn<R>| {
        let facts = [("unit", column.unit), ("description", column.about)];
        Field::new(column.name, column.kind(), true).with_metadata(facts)
    };
    Arc::new(Schema::new(columns.iter().map(field).collect::<Vec<_>>()))
}

/// Returns rows as an Arrow batch.
pub fn batch<R>(schema: &Arc<Schema>, columns: &[TableColumn<R>], rows: &[R]) -> RecordBatch {
    let arrays = columns.iter().map(|column| column.array(rows)).collect();
    RecordBatch::try_new(Arc::clone(schema), arrays).expect("columns of one list of rows are equally long")
}

/// Parquet file, read batch by batch: memory does not grow with the length of the drive.
pub(super) struct TableBatches {
    path: PathBuf,
    reader: ParquetRecordBatchReader,
}

impl TableBatches {
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        Self::build(path, Self::builder(path)?)
    }

    /// Opens a file for these columns only; the others are not read from the disk.
    fn columns(path: &Path, names: &[&str]) -> Result<Self, RecordError> {
        let builder = Self::builder(path)?;
        let mask = ProjectionMask::columns(builder.parquet_schema(), names.iter().copied());
        Self::build(path, builder.with_projection(mask))
    }

    fn build(path: &Path, builder: ParquetRecordBatchReaderBuilder<File>) -> Result<Self, RecordError> {
        Ok(Self { path: path.into(), reader: read(path, || builder.build())? })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the columns, also of a table without rows.
    pub fn schema(&self) -> Arc<Schema> {
        self.reader.schema()
    }

    fn builder(path: &Path) -> Result<ParquetRecordBatchReaderBuilder<File>, RecordError> {
        let file = file::open_regular(path).map_err(RecordError::file(path))?;
        read(path, || ParquetRecordBatchReaderBuilder::try_new(file))
    }
}

impl Iterator for TableBatches {
    type Item = Result<RecordBatch, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        let Self { path, reader } = self;
        read(path, || reader.next().transpose()).transpose()
    }
}

/// Calls the library that reads tables. It panics on some invalid files; the reader is not used again then.
fn read<T, E: Display>(path: &Path, call: impl FnOnce() -> Result<T, E>) -> Result<T, RecordError> {
    let why = match guarded(call) {
        Ok(Ok(read)) => return Ok(read),
        Ok(Err(why)) => why.to_string(),
        Err(why) => why,
    };
    let no_parquet =
        || RecordError::Table { path: path.into(), why: format!("no Parquet file of this program: {why}") };
    Err(system_fault(path, &why).unwrap_or_else(no_parquet))
}

/// Converts an error of the library that writes tables.
pub(super) fn table_fault(path: &Path) -> impl FnOnce(ParquetError) -> RecordError {
    move |why| {
        let why = why.to_string();
        system_fault(path, &why).unwrap_or(RecordError::Table { path: path.into(), why })
    }
}

/// Returns the system's error if the library passes it on: a full or broken disk is no fault of the table. The library passes
/// it on as text only.
fn system_fault(path: &Path, why: &str) -> Option<RecordError> {
    let (_, number) = why.rsplit_once("(os error ")?;
    let number = number.split_once(')')?.0.parse().ok()?;
    Some(RecordError::file(path)(io::Error::from_raw_os_error(number)))
}

/// Parts of a table, as read by [`TableReader::parts`].
pub struct TableParts(TableBatches);

impl Iterator for TableParts {
    type Item = Result<TableReader, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        let part = |batch: RecordBatch| {
            let mut part = TableReader::default();
            part.push(&batch);
            part
        };
        self.0.next().map(|batch| batch.map(part))
    }
}

/// Table read from a file.
///
/// # Examples
///
/// ```
/// use codrive::record::{Table, TableReader};
/// use std::path::Path;
///
/// // A drive of 2 s with three vehicles, each with a row at every tenth tick.
/// let recording = Path::new("tests/data/format-1/recording");
/// let cars = TableReader::parquet(&Table::Cars.parquet(recording))?;
/// assert_eq!(cars.rows(), 3 * 20);
/// assert_eq!(cars.wholes("tick")[..4], [10, 10, 10, 20]);
/// assert_eq!(cars.words("lane")[..3], ["e0_0", "e1_0", "e2_0"]);
/// // A column that the table does not have is empty.
/// assert_eq!(cars.numbers("altitude_m")[0], None);
/// # Ok::<(), codrive::record::RecordError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct TableReader {
    columns: BTreeMap<String, Vec<ArrayRef>>,
    rows: usize,
}

impl TableReader {
    /// Reads a Parquet file.
    ///
    /// # Errors
    /// The file is missing or no Parquet file.
    pub fn parquet(path: &Path) -> Result<Self, RecordError> {
        let mut table = Self::default();
        Self::each_batch(path, &mut |batch| table.push(batch))?;
        Ok(table)
    }

    /// Reads these columns of a Parquet file in parts of some thousand rows, so that memory does not grow with the length of
    /// the drive. Columns missing from the file are empty, as in a table read whole.
    ///
    /// # Errors
    /// The file is missing or no Parquet file; an unreadable part is an error when it is read.
    pub fn parts(path: &Path, columns: &[&str]) -> Result<TableParts, RecordError> {
        Ok(TableParts(TableBatches::columns(path, columns)?))
    }

    /// Reads a Parquet file batch by batch. Returns the number of rows.
    pub(super) fn each_batch(path: &Path, put: &mut dyn FnMut(&RecordBatch)) -> Result<u64, RecordError> {
        let mut rows = 0;
        for batch in TableBatches::open(path)? {
            let batch = batch?;
            rows += batch.num_rows() as u64;
            put(&batch);
        }
        Ok(rows)
    }

    /// Returns the number of rows according to the file's metadata.
    ///
    /// # Errors
    /// The file is missing or no Parquet file.
    pub(super) fn count(path: &Path) -> Result<u64, RecordError> {
        let rows = TableBatches::builder(path)?.metadata().file_metadata().num_rows();
        u64::try_from(rows).map_err(|_| RecordError::Table { path: path.into(), why: format!("{rows} rows") })
    }

    pub(super) fn push(&mut self, batch: &RecordBatch) {
        for (field, array) in batch.schema().fields().iter().zip(batch.columns()) {
            self.columns.entry(field.name().clone()).or_default().push(Arc::clone(array));
        }
        self.rows += batch.num_rows();
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    fn column<A: Array + 'static>(&self, name: &str) -> Option<Vec<&A>> {
        self.columns.get(name)?.iter().map(|array| array.as_any().downcast_ref()).collect()
    }

    /// Returns a column of numbers; `None` for empty cells. A missing column is all empty.
    pub fn numbers(&self, name: &str) -> Vec<Option<f64>> {
        let parts = self.column::<Float64Array>(name).unwrap_or_default();
        let mut values: Vec<_> = parts.iter().flat_map(|part| part.iter()).collect();
        values.resize(self.rows, None);
        values
    }

    /// Returns a column of counts; a missing column gives an empty list.
    pub fn wholes(&self, name: &str) -> Vec<u64> {
        let parts = self.column::<UInt64Array>(name).unwrap_or_default();
        parts.iter().flat_map(|part| part.values().iter().copied()).collect()
    }

    /// Returns a column of ids; `None` for empty cells. A missing column gives an empty list.
    pub fn ids(&self, name: &str) -> Vec<Option<u32>> {
        let parts = self.column::<UInt32Array>(name).unwrap_or_default();
        parts.iter().flat_map(|part| part.iter()).collect()
    }

    /// Returns a column of flags; `None` for empty cells. A missing column gives an empty list.
    pub fn flags(&self, name: &str) -> Vec<Option<bool>> {
        let parts = self.column::<BooleanArray>(name).unwrap_or_default();
        parts.iter().flat_map(|part| part.iter()).collect()
    }

    /// Returns a column of words; a missing column gives an empty list.
    pub fn words(&self, name: &str) -> Vec<String> {
        let parts = self.column::<StringArray>(name).unwrap_or_default();
        parts.iter().flat_map(|part| part.iter()).map(|word| word.unwrap_or_default().to_owned()).collect()
    }
}
