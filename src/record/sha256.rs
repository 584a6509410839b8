//! SHA-256 sums of bytes and files. In: bytes, or a file as it is read or written. Out: the sum, hexadecimal.

use super::RecordError;
use crate::file;
use sha2::{Digest, Sha256};
use std::{
    fs::File,
    io::{self, ErrorKind, Read, Write},
    path::Path,
};

/// Returns the SHA-256 of bytes, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn bytes_are_two_digits_each() {
        assert_eq!(hex(&[0x0f, 0xa0, 0]), "0fa000");
    }
}
