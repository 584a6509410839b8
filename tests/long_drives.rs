//! Analysing a drive of hours takes no more memory than analysing a short one. The long drive repeats the tables of a short one. The test
//! counts the bytes requested from the allocator, not time.

#[path = "fuzz/memory.rs"]
mod memory;

use arrow_array::{Array, ArrayRef, RecordBatch, UInt64Array};
use codrive::{
    analysis::{
        StudyParticipants, analyse, find,
        report::{self, FileProof},
        tables,
    },
    record::Table,
};
use parquet::arrow::{ArrowWriter, arrow_reader::ParquetRecordBatchReaderBuilder};
use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::Command,
    sync::Arc,
};

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;

/// Ticks of the drive that is repeated.
const TICKS: u64 = 2_000;

/// Records a drive and repeats its ticks `times` times.
fn drive(folder: &Path, times: u64) -> PathBuf {
    let path = folder.join(format!("drive-{times}"));
    let arguments = ["run", "--traffic", "native", "--vehicles", "4", "--hold", "10", "--duration", "20", "--out"];
    let output = Command::new(env!("CARGO_BIN_EXE_codrive")).args(arguments).arg(&path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for table in [Table::Ego, Table::Cars, Table::Advice] {
        repeat(&table.parquet(&path), times);
    }
    path
}

fn repeat(file: &Path, times: u64) {
    let rows: Vec<RecordBatch> = {
        let reader = ParquetRecordBatchReaderBuilder::try_new(File::open(file).unwrap()).unwrap().build().unwrap();
        reader.map(Result::unwrap).collect()
    };
    fs::remove_file(file).unwrap();
    let mut writer = ArrowWriter::try_new(File::create(file).unwrap(), rows[0].schema(), None).unwrap();
    for time in 0..times {
        for batch in &rows {
            let place = batch.schema().index_of("tick").unwrap();
            let mut columns = batch.columns().to_vec();
            let ticks = columns[place].as_any().downcast_ref::<UInt64Array>().unwrap();
            let later = ticks.values().iter().map(|tick| tick + time * TICKS);
            let later: ArrayRef = Arc::new(UInt64Array::from_iter_values(later));
            assert_eq!(later.len(), batch.num_rows());
            columns[place] = later;
            writer.write(&RecordBatch::try_new(batch.schema(), columns).unwrap()).unwrap();
        }
    }
    writer.close().unwrap();
}

/// Returns the largest memory, bytes, of the measures and of the page of a drive, and the length of the drive, s.
fn analysed(path: &Path) -> (usize, usize, f64) {
    let found = find(path).unwrap().found;
    let start = memory::begin();
    let drives = analyse(&found, &[], &|| ()).unwrap();
    let (_, measures) = memory::since(start);
    let start = memory::begin();
    let page =
        report::report("long", &drives, &StudyParticipants::default(), &FileProof::default(), &[], None).unwrap();
    let (_, figures) = memory::since(start);
    assert!(page.html.contains("</html>") && tables::trials(&drives).lines().count() == 2);
    (measures, figures, drives[0].duration_s)
}

#[test]
fn measures_and_figures_of_long_drives_take_little_memory() {
    let folder = tempfile::tempdir().unwrap();
    let [(short, _, short_s), (long, figures, long_s)] = [150, 450].map(|times| analysed(&drive(folder.path(), times)));
    assert_eq!((short_s, long_s), (3_000.0, 9_000.0));
    println!("measures: {short} bytes for {short_s} s, {long} bytes for {long_s} s; figures: {figures} bytes");
    // One byte a tick is 60 MB for the seven days that a drive may last. Only one number a second and the results of each change of advice
    // may grow.
    let more = long.saturating_sub(short) as f64 / (100.0 * (long_s - short_s));
    assert!(more < 1.0, "{more:.2} bytes a tick: {short} and {long} bytes");
    // The limit of any input of the program.
    assert!(figures < memory::MOST, "{figures} bytes");
}
