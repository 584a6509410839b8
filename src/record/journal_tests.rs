//! Tests of journals that no writer makes: a duplicated block, and bytes behind the rows of a block.

use super::{
    LostRows, Table,
    block::{self, JournalBlocks, JournalPart},
    journal::{self, Journal},
    journal_reader,
    tables::{EventRow, RowBatch},
};
use crate::time::Tick;
use std::{fs, io::Cursor, path::Path, sync::mpsc};

/// Writes a journal of one block with three events. Returns its bytes.
fn written(folder: &Path) -> Vec<u8> {
    let event = |tick| EventRow {
        tick: Tick(tick),
        kind: "mark".into(),
        detail: String::new(),
        car: None,
        value: None,
        angle_rad: None,
    };
    let (batches, received) = mpsc::channel();
    batches.send(RowBatch { events: vec![event(1), event(2), event(3)], ..RowBatch::default() }).unwrap();
    drop(batches);
    Journal::begin(folder).unwrap().write(&received, || ()).unwrap();
    fs::read(folder.join(journal::FILE)).unwrap()
}

/// Reads a journal. Returns table and row count of each batch, and the lost rows.
fn read(folder: &Path, journal: &[u8]) -> (Vec<(Table, usize)>, Vec<LostRows>) {
    fs::write(folder.join(journal::FILE), journal).unwrap();
    let mut rows = Vec::new();
    let lost = journal_reader::read(folder, &mut |table, batch| {
        rows.push((table, batch.num_rows()));
        Ok(())
    });
    (rows, lost.unwrap())
}

#[test]
fn a_duplicated_block_gives_its_rows_once_and_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = written(folder.path());
    assert_eq!(read(folder.path(), &bytes), (vec![(Table::Events, 3)], vec![]));
    let (rows, lost) = read(folder.path(), &[&bytes[..], &bytes].concat());
    let length = bytes.len() as u64;
    assert_eq!(rows, [(Table::Events, 3)]);
    assert_eq!(lost.iter().map(|lost| lost.bytes).collect::<Vec<_>>(), [[length, 2 * length]]);
}

#[test]
fn bytes_behind_the_rows_of_a_block_make_it_invalid() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = written(folder.path());
    let part = JournalBlocks::new(Cursor::new(&bytes)).unwrap().next().unwrap();
    let Some(JournalPart::Block(header, payload)) = part else { panic!("{part:?}") };
    let mut stream = zstd::decode_all(payload.as_slice()).unwrap();
    stream.extend(b"more");
    let more = block::encode(&header, &zstd::bulk::compress(&stream, 1).unwrap());
    let (rows, lost) = read(folder.path(), &more);
    assert_eq!((rows, lost.len()), (vec![], 1));
}
