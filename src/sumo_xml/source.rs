//! Reading of demand files. In: a path, or one that an `<include>` names. Out: the text, through a reader that fails
//! when too much is read. Compressed files (`.gz`) are read like others; the limits apply to their content.

use crate::file::{open_regular, size_text, unpacked};
use std::{
    cell::Cell,
    io::{self, BufRead, BufReader, Read},
    path::{Component, Path, PathBuf},
    rc::Rc,
};

/// Largest size of a file with all its includes, unpacked, bytes: enough for more vehicles than are allowed.
pub const MOST_BYTES: u64 = 256 << 20;
/// Largest size of one tag, comment or text, bytes: a route over 100,000 edges.
pub const MOST_TAG_BYTES: u64 = 4 << 20;

/// Numbers of bytes that may still be read.
#[derive(Debug)]
pub(super) struct Budget {
    bytes: Cell<u64>,
    tag: Cell<u64>,
}

impl Budget {
    pub fn new() -> Rc<Self> {
        Rc::new(Self { bytes: Cell::new(MOST_BYTES), tag: Cell::new(MOST_TAG_BYTES) })
    }

    /// Resets the limit for the next tag.
    pub fn next_tag(&self) {
        self.tag.set(MOST_TAG_BYTES);
    }
}

/// Text that is counted as it is read.
pub(super) struct Metered {
    inner: BufReader<Box<dyn Read>>,
    budget: Rc<Budget>,
}

impl Read for Metered {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.fill_buf()?.read(buffer)?;
        self.consume(n);
        Ok(n)
    }
}

impl BufRead for Metered {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        let Budget { bytes, tag } = &*self.budget;
        let text = self.inner.fill_buf()?;
        match () {
            () if text.is_empty() => Ok(text),
            () if bytes.get() == 0 => Err(io::Error::other(too_large())),
            () if tag.get() == 0 => Err(io::Error::other(format!(
                "a tag, comment or text is too long; allowed: at most {}",
                size_text(MOST_TAG_BYTES)
            ))),
            () => Ok(text),
        }
    }

    fn consume(&mut self, n: usize) {
        for left in [&self.budget.bytes, &self.budget.tag] {
            left.set(left.get().saturating_sub(n as u64));
        }
        self.inner.consume(n);
    }
}

fn too_large() -> String {
    format!(
        "the file is too large; allowed: at most {}, unpacked and with the files that it includes",
        size_text(MOST_BYTES)
    )
}

/// Opens a file, compressed or not.
///
/// # Errors
/// The file cannot be opened, is no regular file, or is too large.
pub(super) fn open(path: &Path, budget: &Rc<Budget>) -> io::Result<Metered> {
    let file = open_regular(path)?;
    if file.metadata()?.len() > budget.bytes.get() {
        return Err(io::Error::other(too_large()));
    }
    Ok(Metered { inner: BufReader::new(unpacked(file)?), budget: Rc::clone(budget) })
}

/// Returns the path of the file that an `<include>` in a file of `folder` names. The path of `folder` has no links.
///
/// # Errors
/// The name leads out of the folder, or there is no such file; as text.
pub(super) fn included(folder: &Path, href: &str) -> Result<PathBuf, String> {
    let remedy =
        "\n  remedy: put the file beside the one that includes it, or its elements in the place of the include";
    let is_plain = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
    let path = Path::new(href);
    if href.is_empty() || href.contains(['\\', ':']) || !path.components().all(is_plain) {
        return Err(format!(
            "href is not a file of this folder; allowed: the name of a file beside this one or below, without \
             \"..\"{remedy}"
        ));
    }
    let found = folder
        .join(path)
        .canonicalize()
        .map_err(|error| format!("{}: {error}{remedy}", folder.join(path).display()))?;
    if !found.starts_with(folder) {
        return Err(format!("href is a link that leads out of the folder, to {}{remedy}", found.display()));
    }
    Ok(found)
}
