//! Reader of a journal, whole, cut or damaged anywhere. In: its folder. Out: the rows of every good block, and the holes. The
//! last batch may never have reached the disk as a whole. It ends at its first missing block, since a row of one table is
//! useless without the rows of the others. Memory is bounded in advance: a number that exceeds what the file allows is
//! rejected.

use super::{
    RecordError, Table,
    block::{BlockHeader, JournalBlocks, JournalPart, MOST_PAYLOAD},
    files, journal,
};
use crate::{file, foreign::guarded, time::Tick};
use arrow_array::RecordBatch;
use arrow_buffer::Buffer;
use arrow_ipc::{MessageHeader, reader::StreamDecoder, root_as_message};
use arrow_schema::ArrowError;
use std::{
    fs::File,
    io::{self, BufReader, Read},
    num::TryFromIntError,
    path::{Path, PathBuf},
};

/// Maximum size of a decompressed block, bytes.
const MOST_BYTES: u64 = 256 << 20;

/// Rows that could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LostRows {
    /// File with the unreadable bytes.
    pub file: PathBuf,
    /// Range of bytes that are no block: first, end.
    pub bytes: [u64; 2],
    /// Table of the rows, if known.
    pub table: Option<Table>,
    /// Number of rows, if known.
    pub rows: Option<u32>,
    /// Ticks of the first and the last row, if known.
    pub ticks: Option<[Tick; 2]>,
}

impl std::fmt::Display for LostRows {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [from, to] = self.bytes;
        let name = self.file.file_name().unwrap_or_default().display();
        match (self.table, self.rows, self.ticks) {
            (Some(table), Some(rows), Some([first, last])) => {
                write!(f, "{rows} rows of {} ({:.2} to {:.2} s)", table.name(), first.seconds(), last.seconds())?;
            }
            (Some(table), ..) => write!(f, "rows of {}", table.name())?,
            _ => f.write_str("rows of an unknown table")?,
        }
        write!(f, ", bytes {from} to {to} of {name}")
    }
}

/// Passes every good batch of rows to `put`, in the order of the file, and returns the rows that could not be read.
///
/// # Errors
/// An I/O error, or an error of `put`.
pub(super) fn read(
    folder: &Path,
    put: &mut dyn FnMut(Table, RecordBatch) -> Result<(), RecordError>,
) -> Result<Vec<LostRows>, RecordError> {
    let mut holes = Vec::new();
    let path = folder.join(journal::FILE);
    if files::is_there(&path)? {
        read_blocks(&path, put, &mut holes)?;
    }
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        // The drive was cut before the folder was made.
        Err(why) if why.kind() == std::io::ErrorKind::NotFound => return Ok(holes),
        Err(why) => return Err(RecordError::file(folder)(why)),
    };
    for entry in entries {
        let entry = entry.map_err(RecordError::file(folder))?;
        if entry.file_name() != journal::FILE {
            let length = entry.metadata().map_or(0, |about| about.len());
            holes.push(LostRows { file: entry.path(), bytes: [0, length], table: None, rows: None, ticks: None });
        }
    }
    Ok(holes)
}

fn blocks(path: &Path) -> Result<JournalBlocks<BufReader<File>>, RecordError> {
    let file = file::open_regular(path).map_err(RecordError::file(path))?;
    JournalBlocks::new(BufReader::new(file)).map_err(RecordError::file(path))
}

/// Returns the number of the last batch with a readable block.
fn last_batch(path: &Path) -> Result<u64, RecordError> {
    let mut blocks = blocks(path)?;
    let mut last = 0;
    while let Some(part) = blocks.next().map_err(RecordError::file(path))? {
        if let JournalPart::Block(header, _) = part {
            last = last.max(header.batch);
        }
    }
    Ok(last)
}

fn read_blocks(
    path: &Path,
    put: &mut dyn FnMut(Table, RecordBatch) -> Result<(), RecordError>,
    holes: &mut Vec<LostRows>,
) -> Result<(), RecordError> {
    let last_batch = last_batch(path)?;
    let mut blocks = blocks(path)?;
    // True once a block of the last batch is missing.
    let mut is_torn = false;
    let mut next = 0;
    let mut at = 0;
    while let Some(part) = blocks.next().map_err(RecordError::file(path))? {
        match part {
            JournalPart::Hole { header, bytes } => {
                at = bytes[1];
                // The damaged block has used its number, so it is not counted as missing again.
                next = header.map_or(next, |header| header.number.saturating_add(1));
                is_torn |= header.is_some_and(|header| header.batch == last_batch);
                holes.push(hole(path, header.as_ref(), bytes));
            }
            JournalPart::Block(header, payload) => {
                let bytes = [at, at + (super::block::HEADER + payload.len()) as u64];
                is_torn |= header.batch == last_batch && header.number > next.max(last_batch);
                let follows_a_hole = holes.last().is_some_and(|hole| hole.file == path && hole.bytes[1] == at);
                if header.number > next && !follows_a_hole {
                    holes.push(LostRows { bytes: [at, at], ..hole(path, None, bytes) });
                }
                at = bytes[1];
                let known = Table::ALL.get(header.table as usize).copied();
                // An earlier number marks a copy of a block; an unknown table comes from a later version.
                match (known, header.number >= next && !is_torn, unpack(&payload)) {
                    (Some(table), true, Ok(batches)) => {
                        for batch in batches {
                            put(table, batch)?;
                        }
                    }
                    _ => holes.push(hole(path, Some(&header), bytes)),
                }
                next = next.max(header.number.saturating_add(1));
            }
        }
    }
    Ok(())
}

fn hole(path: &Path, header: Option<&BlockHeader>, bytes: [u64; 2]) -> LostRows {
    LostRows {
        file: path.into(),
        bytes,
        table: header.and_then(|header| Table::ALL.get(header.table as usize).copied()),
        rows: header.map(|header| header.rows),
        ticks: header.map(|header| header.ticks.map(Tick)),
    }
}

/// Reason why bytes of a journal hold no rows.
#[derive(Debug, thiserror::Error)]
pub(super) enum RowsFault {
    /// Read or decompression error.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// Message longer than the bytes left, or than the maximum.
    #[error("{wanted} bytes needed, {left} left")]
    Length { wanted: u64, left: u64 },
    /// Bytes after the last message.
    #[error("{0} bytes too many")]
    Rest(u64),
    /// Message without the continuation marker.
    #[error("no message begins here")]
    NoMessage,
    /// Message with an invalid header.
    #[error("{0}")]
    Head(String),
    /// Negative length of a body.
    #[error(transparent)]
    Body(#[from] TryFromIntError),
    /// Announced batch that is missing.
    #[error("no batch")]
    NoBatch,
    /// Buffer of the batch outside the body.
    #[error("a buffer {0} nowhere")]
    Buffer(&'static str),
    /// Buffer larger than the maximum.
    #[error("a buffer of {0} bytes")]
    LargeBuffer(i64),
    /// Batch that the library rejects.
    #[error(transparent)]
    Batch(#[from] ArrowError),
    /// Panic of the library, with its message.
    #[error("{0}")]
    BrokeOff(String),
}

/// Returns the batches of rows in a payload.
pub(super) fn unpack(payload: &[u8]) -> Result<Vec<RecordBatch>, RowsFault> {
    let decoder = zstd::stream::read::Decoder::new(payload)?;
    let mut bytes = Vec::new();
    decoder.take(MOST_BYTES).read_to_end(&mut bytes)?;
    let left = bytes.len() as u64;
    let mut stream = IpcStream { from: bytes.as_slice(), left, decoder: StreamDecoder::new() };
    let mut batches = Vec::new();
    while let Some(batch) = stream.next()? {
        batches.push(batch);
    }
    if stream.left > 0 { Err(RowsFault::Rest(stream.left)) } else { Ok(batches) }
}

/// Arrow IPC stream, read message by message.
struct IpcStream<R> {
    from: R,
    /// Number of bytes left.
    left: u64,
    decoder: StreamDecoder,
}

impl<R: Read> IpcStream<R> {
    fn take(&mut self, count: u64) -> Result<Vec<u8>, RowsFault> {
        if count > self.left || count > u64::from(MOST_PAYLOAD) {
            return Err(RowsFault::Length { wanted: count, left: self.left });
        }
        let mut bytes = vec![0; count as usize];
        self.from.read_exact(&mut bytes)?;
        self.left -= count;
        Ok(bytes)
    }

    /// Returns the next batch; `None` at an end marker or at the end of the bytes.
    fn next(&mut self) -> Result<Option<RecordBatch>, RowsFault> {
        while self.left > 0 {
            let mut bytes = self.take(8)?;
            let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
            let (mark, length) = (word(0), word(4));
            if mark != u32::MAX {
                return Err(RowsFault::NoMessage);
            }
            if length == 0 {
                return Ok(None);
            }
            let about = self.take(length.into())?;
            let message = root_as_message(&about).map_err(|e| RowsFault::Head(e.to_string()))?;
            let body = self.take(u64::try_from(message.bodyLength())?)?;
            check_buffers(&message, &body)?;
            bytes.extend(&about);
            bytes.extend(body);
            let mut buffer = Buffer::from_vec(bytes);
            let decoder = &mut self.decoder;
            // The library checks much and panics on the rest; a decoder that panicked is not used again.
            let decoded = guarded(|| decoder.decode(&mut buffer)).map_err(RowsFault::BrokeOff)??;
            if decoded.is_some() {
                return Ok(decoded);
            }
        }
        Ok(None)
    }
}

/// Checks the declared size of each compressed buffer, since the library allocates it at once.
fn check_buffers(message: &arrow_ipc::Message<'_>, body: &[u8]) -> Result<(), RowsFault> {
    if message.header_type() != MessageHeader::RecordBatch {
        return Ok(());
    }
    let batch = message.header_as_record_batch().ok_or(RowsFault::NoBatch)?;
    if batch.compression().is_none() {
        return Ok(());
    }
    for buffer in batch.buffers().iter().flatten() {
        let (offset, length) = (usize::try_from(buffer.offset()), usize::try_from(buffer.length()));
        let (Ok(offset), Ok(length)) = (offset, length) else { return Err(RowsFault::Buffer("begins")) };
        let bytes =
            offset.checked_add(length).and_then(|end| body.get(offset..end)).ok_or(RowsFault::Buffer("ends"))?;
        let Some(first) = bytes.first_chunk::<8>() else { continue };
        let plain = i64::from_le_bytes(*first);
        if plain > MOST_BYTES as i64 {
            return Err(RowsFault::LargeBuffer(plain));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hole_is_described_as_exactly_as_it_is_known() {
        let whole = LostRows {
            file: "drive/journal/rows.blocks".into(),
            bytes: [5, 90],
            table: Some(Table::Ego),
            rows: Some(7),
            ticks: Some([Tick(10), Tick(120)]),
        };
        let place = ", bytes 5 to 90 of rows.blocks";
        assert_eq!(whole.to_string(), format!("7 rows of ego (0.10 to 1.20 s){place}"));
        assert_eq!(LostRows { rows: None, ..whole.clone() }.to_string(), format!("rows of ego{place}"));
        assert_eq!(LostRows { ticks: None, ..whole.clone() }.to_string(), format!("rows of ego{place}"));
        assert_eq!(LostRows { table: None, ..whole }.to_string(), format!("rows of an unknown table{place}"));
    }

    #[test]
    fn reads_are_limited_by_the_bytes_left_and_the_maximum_block() {
        let stream = |left: u64| IpcStream { from: std::io::repeat(7), left, decoder: StreamDecoder::new() };
        let mut ten = stream(10);
        assert_eq!(ten.take(4).unwrap(), [7; 4]);
        assert_eq!(ten.take(7).unwrap_err().to_string(), "7 bytes needed, 6 left");
        assert_eq!((ten.take(6).unwrap(), ten.left, ten.take(0).unwrap()), (vec![7; 6], 0, vec![]));
        let most = u64::from(MOST_PAYLOAD);
        assert!(stream(u64::MAX).take(most + 1).is_err());
        let mut large = stream(most + 1);
        assert_eq!((large.take(most).unwrap().len() as u64, large.left), (most, 1));
        // A file that is shorter than its declared length.
        let mut short = IpcStream { from: &[1, 2][..], left: 3, decoder: StreamDecoder::new() };
        assert!(short.take(3).is_err());
    }
}
