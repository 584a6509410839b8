//! The gate in front of SUMO. In: a network, a demand or an additional file from outside. Out: a canonical copy that holds only what
//! [`vocabulary`] lists, which is all that SUMO is ever given; or the first part that is refused, with file, line and
//! remedy.
//!
//! SUMO obeys its input: `<edgeData file=..>` in a network and `<param key="device.ssm.file" ..>` in a demand write to
//! any file, and `<include>` reads any. So a copy is made element by element ([`gate`]) from an allow-list. Parts that
//! are not on it are refused by name, or dropped and counted ([`Dropped`]) if they have no effect on a drive. Networks
//! pass the gate as a tree (`map`), demand files as a stream (`stream`). [`document`] checks files for netconvert,
//! which are not copied.

pub mod document;
pub mod gate;
mod source;
pub mod stream;
#[cfg(test)]
mod tests;
pub mod vocabulary;

pub use gate::{Dropped, Gate, GateError, Problem};
pub use vocabulary::{Vocabulary, additional, demand, network};

use std::io::{self, Write};

/// Beginning of all canonical documents.
pub const DECLARATION: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

/// Writes an attribute's value with escapes, so that it is read back unchanged.
///
/// # Errors
/// Errors of `out`.
pub fn write_escaped(out: &mut impl Write, value: &str) -> io::Result<()> {
    let mut rest = value;
    if is_plain(value) {
        return out.write_all(value.as_bytes());
    }
    while let Some(at) = rest.find(['&', '<', '>', '"', '\n', '\r', '\t']) {
        out.write_all(&rest.as_bytes()[..at])?;
        match rest.as_bytes()[at] {
            b'&' => out.write_all(b"&amp;")?,
            b'<' => out.write_all(b"&lt;")?,
            b'>' => out.write_all(b"&gt;")?,
            b'"' => out.write_all(b"&quot;")?,
            space => write!(out, "&#{space};")?,
        }
        rest = &rest[at + 1..];
    }
    out.write_all(rest.as_bytes())
}

/// Checks whether a value needs no escapes, as almost all values of a network do.
fn is_plain(value: &str) -> bool {
    value.bytes().all(|byte| matches!(byte, b' '..=b'~') && !matches!(byte, b'&' | b'<' | b'>' | b'"'))
}

/// Finds the first character that XML cannot hold, as a byte position: a control character other than tab and line
/// ends, or one of two noncharacters.
pub fn first_bad_character(text: &str) -> Option<usize> {
    let control = |byte: u8| byte < b' ' && !matches!(byte, b'\t' | b'\n' | b'\r');
    text.bytes().position(control).or_else(|| text.find(['\u{fffe}', '\u{ffff}']))
}
