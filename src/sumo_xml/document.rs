//! Files of other formats before SUMO's converter reads them: OpenStreetMap and OpenDRIVE. In: the bytes. Out: nothing, or the line that the
//! converter's parser would follow to another file: a document type, entities, an include. They are not copied, for netconvert only reads
//! roads from them; what it writes is given by its command line alone.

use std::io::{self, BufRead};

/// Something that is refused in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// `<!DOCTYPE` or `<!ENTITY`.
    DocumentType,
    /// `<include`, in any case and with any prefix.
    Include,
    /// Bytes that are no text in an encoding that has ASCII in it, so that nobody can look for the others.
    Encoding,
}

impl Reference {
    /// The part of the file that is refused, and why.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::DocumentType => {
                "the document has a type or entities of its own (<!DOCTYPE ...>, <!ENTITY ...>), which can name other files and the net, and fill \
                 the memory in a few lines; none is read"
            }
            Self::Include => "the document includes another file (<include ...>); none is read",
            Self::Encoding => "the document is no text in UTF-8, ISO 8859 or a Windows code page; no other is read",
        }
    }
}

/// Encodings that write markup as ASCII does.
const ENCODINGS: [&str; 5] = ["utf-8", "utf8", "us-ascii", "iso-8859-", "windows-125"];

/// Finds the first reference to another file, and its line from 1.
///
/// # Errors
/// The system's.
pub fn first_reference(mut document: impl BufRead) -> io::Result<Option<(u32, Reference)>> {
    let (mut line, mut is_first) = (1, true);
    let mut piece = Vec::new();
    // Markup by markup: a file may be one line, and larger than what is wanted in memory.
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

/// Text before the first `<`: nothing, or the mark of UTF-8, and spaces.
fn is_text_start(piece: &[u8]) -> bool {
    let piece = piece.strip_prefix("\u{feff}".as_bytes()).unwrap_or(piece);
    piece.strip_suffix(b"<").is_some_and(|before| before.iter().all(u8::is_ascii_whitespace))
}

/// Reference in a markup: its text from behind `<` to the next one.
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

    fn found(text: &[u8]) -> Option<(u32, Reference)> {
        first_reference(text).unwrap()
    }

    #[test]
    fn references_to_other_files_are_found_wherever_they_stand() {
        assert_eq!(found(b"<?xml version='1.0' encoding='UTF-8'?>\n<osm><node id='1'/></osm>"), None);
        assert_eq!(found(b"\xef\xbb\xbf<osm/>"), None);
        assert_eq!(found(b"<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><osm><tag v='\xe4'/></osm>"), None);
        // A comment with a tag in it hid what follows from the first look.
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
