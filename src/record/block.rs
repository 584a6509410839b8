//! Blocks of a journal. A block is rows of one table behind a header with table, row count and tick span; each part has a
//! checksum (CRC32C). In: bytes of a payload. Out: bytes of a block. In reverse: every good block of a file that was cut or
//! damaged anywhere, with the holes between them.
//!
//! ```text
//! 0   8  MAGIC                    32  8  tick of the first row
//! 8   4  table                    40  8  tick of the last row
//! 12  4  rows                     48  4  length of the payload, bytes
//! 16  8  number of the block      52  4  CRC32C of the payload
//! 24  8  number of the batch      56  4  CRC32C of the header up to here
//! 60  .. payload; all numbers little-endian
//! ```

use crc32c::crc32c;
use std::io::{self, Read, Seek, SeekFrom};

/// First bytes of a block: neither text nor part of zstd's output.
const MAGIC: [u8; 8] = *b"\x93CDBLK\r\n";
/// Length of a header, bytes.
pub(super) const HEADER: usize = 60;
/// Maximum payload that is read, bytes: a batch of 2,000 ticks with 1,000 vehicles stays below it.
pub(super) const MOST_PAYLOAD: u32 = 64 << 20;

/// Contents of a block's header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct BlockHeader {
    /// Table, by its index in [`super::Table::ALL`].
    pub table: u32,
    /// Rows in the payload.
    pub rows: u32,
    /// Number of the block in its journal, from 0; a gap means missing blocks.
    pub number: u64,
    /// Number of the first block of its batch: all blocks of a batch go to the disk in one write and one sync.
    pub batch: u64,
    /// Ticks of the first and the last row.
    pub ticks: [u64; 2],
}

/// Returns the bytes of a block.
pub(super) fn encode(header: &BlockHeader, payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + payload.len());
    bytes.extend(MAGIC);
    bytes.extend(header.table.to_le_bytes());
    bytes.extend(header.rows.to_le_bytes());
    bytes.extend(header.number.to_le_bytes());
    bytes.extend(header.batch.to_le_bytes());
    bytes.extend(header.ticks[0].to_le_bytes());
    bytes.extend(header.ticks[1].to_le_bytes());
    bytes.extend(u32::try_from(payload.len()).unwrap_or(u32::MAX).to_le_bytes());
    bytes.extend(crc32c(payload).to_le_bytes());
    bytes.extend(crc32c(&bytes).to_le_bytes());
    bytes.extend(payload);
    bytes
}

/// Decodes a header. Returns it with length and checksum of the payload; `None` if its own checksum is wrong.
fn decode(bytes: &[u8; HEADER]) -> Option<(BlockHeader, u32, u32)> {
    let small = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    let large = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"));
    if bytes[..8] != MAGIC || small(56) != crc32c(&bytes[..56]) {
        return None;
    }
    let header = BlockHeader {
        table: small(8),
        rows: small(12),
        number: large(16),
        batch: large(24),
        ticks: [large(32), large(40)],
    };
    Some((header, small(48), small(52)))
}

/// Next part of a journal.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum JournalPart {
    /// Block with correct checksums.
    Block(BlockHeader, Vec<u8>),
    /// Bytes that are no block, with the header if it can be read.
    Hole {
        /// Header of the damaged block.
        header: Option<BlockHeader>,
        /// Range of bytes in the file: first, end.
        bytes: [u64; 2],
    },
}

/// Reader of a journal from start to end; each byte is in exactly one part.
pub(super) struct JournalBlocks<R> {
    file: R,
    length: u64,
    at: u64,
}

impl<R: Read + Seek> JournalBlocks<R> {
    /// Starts at the first byte of `file`.
    ///
    /// # Errors
    /// An I/O error.
    pub fn new(mut file: R) -> io::Result<Self> {
        let length = file.seek(SeekFrom::End(0))?;
        Ok(Self { file, length, at: 0 })
    }

    /// Returns the next part; `None` at the end.
    ///
    /// # Errors
    /// An I/O error.
    pub fn next(&mut self) -> io::Result<Option<JournalPart>> {
        if self.at >= self.length {
            return Ok(None);
        }
        let from = self.at;
        match self.header_at(from)? {
            Some((header, length, sum)) => {
                let end = from + HEADER as u64 + u64::from(length);
                if length <= MOST_PAYLOAD && end <= self.length {
                    let mut payload = vec![0; length as usize];
                    self.file.read_exact(&mut payload)?;
                    if crc32c(&payload) == sum {
                        self.at = end;
                        return Ok(Some(JournalPart::Block(header, payload)));
                    }
                }
                // The length in the header may be wrong: another block may begin within it.
                self.at = self.find_from(from + 1)?;
                Ok(Some(JournalPart::Hole { header: Some(header), bytes: [from, self.at] }))
            }
            None => {
                self.at = self.find_from(from + 1)?;
                Ok(Some(JournalPart::Hole { header: None, bytes: [from, self.at] }))
            }
        }
    }

    /// Returns the header at this byte, if there is one; the file position is then behind it.
    fn header_at(&mut self, at: u64) -> io::Result<Option<(BlockHeader, u32, u32)>> {
        if self.length - at < HEADER as u64 {
            return Ok(None);
        }
        let mut bytes = [0; HEADER];
        self.file.seek(SeekFrom::Start(at))?;
        self.file.read_exact(&mut bytes)?;
        Ok(decode(&bytes))
    }

    /// Finds the first byte from `from` on at which a header with a correct checksum begins; the file's end if there is none.
    fn find_from(&mut self, from: u64) -> io::Result<u64> {
        const PIECE: usize = 1 << 16;
        let mut at = from;
        let mut piece = vec![0; PIECE];
        while at + HEADER as u64 <= self.length {
            let n = PIECE.min((self.length - at) as usize);
            self.file.seek(SeekFrom::Start(at))?;
            self.file.read_exact(&mut piece[..n])?;
            for (offset, _) in piece[..n].windows(MAGIC.len()).enumerate().filter(|(_, bytes)| **bytes == MAGIC) {
                let found = at + offset as u64;
                if self.header_at(found)?.is_some() {
                    return Ok(found);
                }
            }
            // Pieces overlap, so that a magic number across their border is found.
            at += (n - (MAGIC.len() - 1)) as u64;
        }
        Ok(self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn three() -> (Vec<u8>, [usize; 4]) {
        let mut bytes = Vec::new();
        let mut ends = [0; 4];
        for (number, payload) in [&b"first"[..], &[0x93; 300], b"the third"].into_iter().enumerate() {
            let number = number as u64;
            let header =
                BlockHeader { table: number as u32, rows: 7, number, batch: 0, ticks: [10 * number, 10 * number + 9] };
            bytes.extend(encode(&header, payload));
            ends[number as usize + 1] = bytes.len();
        }
        (bytes, ends)
    }

    /// Returns the numbers of the good blocks, and the byte ranges that are in none.
    fn read(bytes: &[u8]) -> (Vec<u64>, Vec<[u64; 2]>) {
        let mut blocks = JournalBlocks::new(Cursor::new(bytes)).expect("memory");
        let (mut good, mut holes) = (Vec::new(), Vec::new());
        while let Some(part) = blocks.next().expect("memory") {
            match part {
                JournalPart::Block(header, _) => good.push(header.number),
                JournalPart::Hole { bytes, .. } => holes.push(bytes),
            }
        }
        (good, holes)
    }

    #[test]
    fn the_checksum_is_crc32c() {
        // RFC 3720, B.4: 32 bytes of zeroes, and the bytes 0 to 31.
        assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
        assert_eq!(crc32c(&(0..32).collect::<Vec<u8>>()), 0x46dd_794e);
    }

    #[test]
    fn a_flipped_bit_loses_its_own_block_only_and_is_reported() {
        let (bytes, ends) = three();
        assert_eq!(read(&bytes), (vec![0, 1, 2], vec![]));
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let hit = (0..3).find(|block| bit / 8 < ends[block + 1]).expect("inside");
            let kept: Vec<u64> = (0..3).filter(|block| *block != hit as u64).collect();
            let hole = [ends[hit] as u64, ends[hit + 1] as u64];
            assert_eq!(read(&flipped), (kept, vec![hole]), "bit {bit}");
        }
    }

    #[test]
    fn a_cut_at_every_byte_keeps_the_blocks_before_it_and_reports_the_rest() {
        let (bytes, ends) = three();
        for end in 0..=bytes.len() {
            let whole = ends[1..].iter().filter(|block_end| **block_end <= end).count();
            let rest = (ends[whole] < end).then_some([ends[whole] as u64, end as u64]);
            assert_eq!(read(&bytes[..end]), ((0..whole as u64).collect(), rest.into_iter().collect()), "{end}");
        }
    }

    #[test]
    fn reading_goes_on_after_bytes_of_any_length_that_are_no_block() {
        let (bytes, ends) = three();
        for length in [1, 7, 8, 59, 60, 65_535, 65_536, 65_537, 200_000] {
            let mut text = bytes[..ends[1]].to_vec();
            text.extend((0..length).map(|i| MAGIC[i % 8]));
            text.extend(&bytes[ends[1]..]);
            let hole = [ends[1] as u64, (ends[1] + length) as u64];
            assert_eq!(read(&text), (vec![0, 1, 2], vec![hole]), "{length} bytes between");
        }
    }
}
