//! Check of files in other formats before SUMO's converter reads them: OpenStreetMap and OpenDRIVE. In: the bytes. Out:
//! nothing, or the line at which the converter's parser would follow a reference to another file: a document type,
//! entities, an include. The files are not copied, because netconvert only reads roads from them; its command line
//! alone determines what it writes. Also opens such files and networks: compressed ones (`.gz`) are unpacked, within bounds, and
//! text in Latin-1 is decoded.

use crate::file::{open_regular, size_text, unpacked};
use std::{
    io::{self, BufRead, BufReader, Read},
    path::Path,
};

/// Opens a document of at most `limit` bytes, unpacked; compressed ones are unpacked.
///
/// # Errors
/// The file cannot be opened. The reader fails with [`io::ErrorKind::FileTooLarge`] after `limit` bytes.
pub fn open(path: &Path, limit: u64) -> io::Result<impl BufRead> {
    let file = open_regular(path)?;
    if file.metadata()?.len() > limit {
        return Err(too_large(limit));
    }
    Ok(BufReader::new(Unpacked { inner: unpacked(file)?, limit, left: limit }))
}

/// Reads a document as text: UTF-8, or Latin-1 if its head says so.
///
/// # Errors
/// As [`open`]; or the text has another encoding ([`io::ErrorKind::InvalidData`]).
pub fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    let mut bytes = Vec::new();
    open(path, limit)?.read_to_end(&mut bytes)?;
    let bytes = match String::from_utf8(bytes) {
        Ok(text) => return Ok(text),
        Err(error) => error.into_bytes(),
    };
    let head = bytes.split_inclusive(|byte| *byte == b'>').next().unwrap_or_default();
    let head = String::from_utf8_lossy(head).to_ascii_lowercase();
    match LATIN_1.iter().any(|name| head.contains(name)) {
        true => Ok(bytes.into_iter().map(char::from).collect()),
        false => Err(io::Error::new(
            io::ErrorKind::InvalidData,
            "it is not UTF-8 text, and its first line does not declare ISO-8859-1; save it as UTF-8",
        )),
    }
}

/// Names of Latin-1 and of encodings that differ from it in a few signs only.
const LATIN_1: [&str; 4] = ["iso-8859-1\"", "iso-8859-1'", "iso-8859-15", "windows-1252"];

/// Content of a file, which ends with an error after `limit` bytes.
struct Unpacked {
    inner: Box<dyn Read>,
    limit: u64,
    left: u64,
}

impl Read for Unpacked {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.left = self.left.checked_sub(n as u64).ok_or_else(|| too_large(self.limit))?;
        Ok(n)
    }
}

fn too_large(limit: u64) -> io::Error {
    let text = format!("it holds more than {}, unpacked, the most that is read", size_text(limit));
    io::Error::new(io::ErrorKind::FileTooLarge, text)
}

/// Part of a file that is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// Markup that begins with `<!DOCTYPE` or `<!ENTITY`.
    DocumentType,
    /// Element `<include`, in any case and with any prefix.
    Include,
    /// Bytes that are no text in an ASCII-compatible encoding, in which references could not be found.
    Encoding,
}

impl Reference {
    /// Returns a description of the refused part, with the reason.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::DocumentType => {
                "the document declares a type or entities (<!DOCTYPE ...>, <!ENTITY ...>); codrive reads none, because \
                 they can name other files and network addresses, or fill the memory"
            }
            Self::Include => "the document includes another file (<include ...>); codrive reads no includes here",
            Self::Encoding => {
                "the document is not text in UTF-8, ISO 8859 or a Windows code page; codrive reads no other encoding"
            }
        }
    }
}

/// Encodings that write markup as ASCII does.
const ENCODINGS: [&str; 5] = ["utf-8", "utf8", "us-ascii", "iso-8859-", "windows-125"];

/// Finds the first reference to another file, and its line from 1.
///
/// # Errors
/// The document cannot be read.
pub fn first_reference(mut document: impl BufRead) -> io::Result<Option<(u32, Reference)>> {
    let (mut line, mut is_first) = (1, true);
    let mut piece = Vec::new();
    // One markup at a time: a file may be a single line that is too large for the memory.
    while document.read_until(b'<', &mut piece)? > 0 {
        let found = match is_first {
            true if !is_text_start(&piece) => Some(Reference::Encoding),
            true => None,
            false => reference(&piece),
        };
        if let Some(found) = found.or(piece.contains(&0).then_some(Reference::Encoding)) {
            return Ok(Some((line, found)));
        }
        is_first = false;
        line += piece.iter().filter(|byte| **byte == b'\n').count() as u32;
        piece.clear();
    }
    Ok(None)
}

/// Checks the text before the first `<`: it may hold a UTF-8 byte order mark and white space.
fn is_text_start(piece: &[u8]) -> bool {
    let piece = piece.strip_prefix("\u{feff}".as_bytes()).unwrap_or(piece);
    piece.strip_suffix(b"<").is_some_and(|before| before.iter().all(u8::is_ascii_whitespace))
}

/// Returns the reference in a markup, given its text from after `<` to the next one.
fn reference(markup: &[u8]) -> Option<Reference> {
    let begins = |with: &str| markup.get(..with.len()).is_some_and(|head| head.eq_ignore_ascii_case(with.as_bytes()));
    let is_end = |byte: &u8| byte.is_ascii_whitespace() || b">/<".contains(byte);
    let name = markup.split(is_end).next().unwrap_or_default();
    let local = name.rsplit(|byte| *byte == b':').next().unwrap_or_default();
    match () {
        () if begins("!doctype") || begins("!entity") => Some(Reference::DocumentType),
        () if local.eq_ignore_ascii_case(b"include") => Some(Reference::Include),
        () if begins("?xml") => {
            let text = String::from_utf8_lossy(markup).to_ascii_lowercase();
            let encoding =
                text.split("encoding").nth(1)?.trim_start_matches(|c: char| c.is_whitespace() || "=\"'".contains(c));
            (!ENCODINGS.iter().any(|known| encoding.starts_with(known))).then_some(Reference::Encoding)
        }
        () => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{fs, io::Write};

    fn found(text: &[u8]) -> Option<(u32, Reference)> {
        first_reference(text).unwrap()
    }

    #[test]
    fn compressed_documents_and_latin_1_are_read_within_bounds() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.xml.gz");
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packed.write_all("<net x='ä'/>".as_bytes()).unwrap();
        fs::write(&file, packed.finish().unwrap()).unwrap();
        assert_eq!(read_text(&file, 99).unwrap(), "<net x='ä'/>");
        // A thousand times its size once unpacked.
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packed.write_all(&vec![b' '; 1 << 20]).unwrap();
        fs::write(&file, packed.finish().unwrap()).unwrap();
        assert_eq!(read_text(&file, 1 << 19).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        fs::write(&file, b"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><net x='\xe4'/>").unwrap();
        assert!(read_text(&file, 99).unwrap().ends_with("<net x='ä'/>"));
        fs::write(&file, b"<?xml version=\"1.0\"?><net x='\xe4'/>").unwrap();
        let error = read_text(&file, 99).unwrap_err();
        assert!(error.kind() == io::ErrorKind::InvalidData && error.to_string().contains("save it as UTF-8"));
    }

    #[test]
    fn references_to_other_files_are_found_at_any_position() {
        assert_eq!(found(b"<?xml version='1.0' encoding='UTF-8'?>\n<osm><node id='1'/></osm>"), None);
        assert_eq!(found(b"\xef\xbb\xbf<osm/>"), None);
        assert_eq!(found(b"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><osm><tag v='\xe4'/></osm>"), None);
        // A former fault: a comment with a tag in it hid the following markup from the check.
        let hidden = b"<!-- <a> -->\n<!DOCTYPE osm SYSTEM 'http://127.0.0.1/x.dtd'>\n<osm/>";
        assert_eq!(found(hidden), Some((2, Reference::DocumentType)));
        assert_eq!(found(b"<osm>\n<node/>\n<include href='/etc/x.xml'/></osm>"), Some((3, Reference::Include)));
        assert_eq!(found(b"<OpenDRIVE><xi:include\nhref='a'/></OpenDRIVE>"), Some((1, Reference::Include)));
        assert_eq!(found(b"<osm><included/></osm>"), None);
        for text in
            [&b"\xff\xfe<\0o\0"[..], b"\0<\0o", b"Lo\xa7\x94", b"<?xml version='1.0' encoding='UTF-16'?><osm/>", b"<\0"]
        {
            assert_eq!(found(text).map(|(_, found)| found), Some(Reference::Encoding), "{text:?}");
        }
    }
}
