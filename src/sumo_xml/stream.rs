//! Demand and additional files at the gate, read tag by tag, because they may be larger than the memory. In: a file, and a check for
//! each element. Out: the canonical copy with all included files in it, or the first part that is refused, with its
//! file and line.

use super::{
    Dropped, Gate, GateError, Problem, Vocabulary, gate,
    source::{self, Budget, Metered},
};
use crate::file::size_text;
use quick_xml::{
    Reader, XmlVersion,
    events::{BytesStart, Event},
};
use std::{
    io::{self, Write},
    path::{Path, PathBuf},
    rc::Rc,
};

pub use source::{MOST_BYTES, MOST_TAG_BYTES};

/// Largest number of elements of a file with all its includes: a route, a stop and some parameters for each of 200,000
/// vehicles.
pub const MOST_ELEMENTS: u64 = 2_000_000;
/// Largest depth of nested includes.
pub const MOST_INCLUDE_DEPTH: usize = 8;
/// Largest number of files that a file includes, directly or not.
pub const MOST_INCLUDES: usize = 256;

/// Element as it is read.
#[derive(Debug)]
pub struct Tag {
    /// Name of the element.
    pub name: String,
    /// Names and values of the attributes.
    pub attributes: Vec<(String, String)>,
    /// Number of enclosing elements: 1 directly within the outermost one.
    pub depth: usize,
}

impl Tag {
    /// Returns the value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// Returns the element with its id, for messages.
    pub fn label(&self) -> String {
        gate::label(&self.name, self.pairs())
    }

    fn pairs(&self) -> impl Iterator<Item = (&str, &str)> + Clone {
        self.attributes.iter().map(|(name, value)| (name.as_str(), value.as_str()))
    }
}

/// Error that prevented the copy of a file.
#[derive(Debug)]
pub enum StreamError {
    /// Problem with the file as a whole.
    File {
        /// Path of the file.
        file: PathBuf,
        /// Description of the problem.
        problem: String,
    },
    /// Problem with an element.
    Element {
        /// Path of the file, which may be an included one.
        file: PathBuf,
        /// Line number, from 1.
        line: u32,
        /// Description of the problem.
        problem: Problem,
    },
}

/// Copies `file` to `out`, with all included files in place of the includes. `look` is called with every element that
/// passes the gate.
///
/// # Errors
/// The first part that is refused, by the gate or by `look`, or a file that cannot be read or written.
pub fn copy<W: Write>(
    file: &Path,
    vocabulary: &Vocabulary,
    out: W,
    look: &mut dyn FnMut(&Tag) -> Result<(), Problem>,
) -> Result<(W, Dropped), StreamError> {
    copy_with(file, vocabulary, out, look, false).map(|(out, dropped, _)| (out, dropped))
}

/// Elements that a lenient copy leaves out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Number of elements directly within the outermost one.
    pub count: usize,
    /// Place and fault of the first.
    pub first: String,
}

/// Copies `file` as [`copy`] does. If `is_lenient`, elements for which `look` returns a problem are left out with all around them up to the
/// outermost element, and parts that name files or devices of SUMO are dropped.
///
/// # Errors
/// As [`copy`].
pub fn copy_with<W: Write>(
    file: &Path,
    vocabulary: &Vocabulary,
    out: W,
    look: &mut dyn FnMut(&Tag) -> Result<(), Problem>,
    is_lenient: bool,
) -> Result<(W, Dropped, LeftOut), StreamError> {
    let pending = Pending { out: Bounded { out, left: MOST_BYTES }, element: Vec::new() };
    let mut copy = Copy {
        gate: Gate::new(vocabulary, pending),
        vocabulary,
        look,
        is_faulty: false,
        left_out: LeftOut::default(),
        budget: Budget::new(),
        elements: 0,
        includes: 0,
        open_files: Vec::new(),
    };
    copy.gate.is_lenient = is_lenient;
    let path = file.canonicalize().map_err(|error| of_file(file, error))?;
    copy.file(file, path, false)?;
    let left_out = copy.left_out;
    let (pending, dropped) = copy.gate.into_inner();
    Ok((pending.out.out, dropped, left_out))
}

/// Writer that keeps an element until it is known whether it is left out.
struct Pending<W> {
    out: W,
    element: Vec<u8>,
}

impl<W: Write> Pending<W> {
    /// Writes the element, or the end of the start tag before it if it is left out.
    fn end(&mut self, is_left_out: bool) -> io::Result<()> {
        const END_OF_TAG: &[u8] = b">\n";
        let kept = match self.element.strip_prefix(END_OF_TAG) {
            Some(_) if is_left_out => END_OF_TAG,
            None if is_left_out => &[],
            _ => &self.element,
        };
        self.out.write_all(kept)?;
        self.element.clear();
        Ok(())
    }
}

impl<W: Write> Write for Pending<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.element.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Writer that limits the copy to the size that can be read again.
struct Bounded<W> {
    out: W,
    left: u64,
}

impl<W: Write> Write for Bounded<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.left = self.left.checked_sub(written as u64).ok_or_else(|| {
            io::Error::other(format!(
                "the copy is too large; allowed: at most {}, with the files that it includes",
                size_text(MOST_BYTES)
            ))
        })?;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

fn of_file(file: &Path, problem: impl ToString) -> StreamError {
    StreamError::File { file: file.into(), problem: problem.to_string() }
}

/// Name of the element that includes a file.
const INCLUDE: &str = "include";

struct Copy<'a, W> {
    gate: Gate<'a, Pending<Bounded<W>>>,
    vocabulary: &'a Vocabulary,
    look: &'a mut dyn FnMut(&Tag) -> Result<(), Problem>,
    /// True if the present element within the outermost one is left out.
    is_faulty: bool,
    left_out: LeftOut,
    budget: Rc<Budget>,
    elements: u64,
    includes: usize,
    /// Files that are being read, each included by the one before.
    open_files: Vec<PathBuf>,
}

/// Position in a file that is read.
struct ReadPosition<'f> {
    file: &'f Path,
    line: u32,
    /// Number of open elements in this file.
    depth: usize,
    has_root: bool,
    is_included: bool,
    /// True while the last tag is an `<include>` that is not closed yet.
    is_in_include: bool,
}

impl ReadPosition<'_> {
    fn fault(&self, element: impl ToString, problem: impl ToString) -> StreamError {
        let problem = Problem { element: element.to_string(), problem: problem.to_string() };
        StreamError::Element { file: self.file.into(), line: self.line, problem }
    }
}

impl<W: Write> Copy<'_, W> {
    /// Copies one file; `name` is its name for messages.
    fn file(&mut self, name: &Path, path: PathBuf, is_included: bool) -> Result<(), StreamError> {
        let text = source::open(&path, &self.budget).map_err(|error| of_file(name, error))?;
        self.open_files.push(path);
        let mut position =
            ReadPosition { file: name, line: 1, depth: 0, has_root: false, is_included, is_in_include: false };
        let mut reader = Reader::from_reader(text);
        let mut buffer = Vec::new();
        while self.event(&mut reader, &mut buffer, &mut position)? {
            position.line += buffer.iter().filter(|byte| **byte == b'\n').count() as u32;
            buffer.clear();
        }
        self.open_files.pop();
        Ok(())
    }

    /// Processes the next part of a file. Returns false at its end.
    fn event(
        &mut self,
        reader: &mut Reader<Metered>,
        buffer: &mut Vec<u8>,
        position: &mut ReadPosition,
    ) -> Result<bool, StreamError> {
        self.budget.next_tag();
        match reader.read_event_into(buffer) {
            Ok(Event::Start(tag)) => self.open(&tag, position)?,
            Ok(Event::Empty(tag)) => {
                self.open(&tag, position)?;
                self.close(position)?;
            }
            Ok(Event::End(_)) => self.close(position)?,
            Ok(Event::DocType(_)) => {
                return Err(position.fault(
                    "<!DOCTYPE>",
                    "a document type can name other files and declare entities; codrive reads none\n  remedy: remove \
                     it from the file",
                ));
            }
            Ok(Event::Eof) if !position.has_root => return Err(of_file(position.file, "the file has no element")),
            Ok(Event::Eof) if position.depth > 0 => {
                return Err(position.fault("this is not XML", "the file ends before its last element is closed"));
            }
            Ok(Event::Eof) => return Ok(false),
            Ok(_) => {}
            Err(quick_xml::Error::Io(error)) => return Err(of_file(position.file, error)),
            Err(error) => return Err(position.fault("this is not XML", error)),
        }
        Ok(true)
    }

    fn open(&mut self, tag: &BytesStart, position: &mut ReadPosition) -> Result<(), StreamError> {
        self.elements += 1;
        if self.elements > MOST_ELEMENTS {
            let problem =
                format!("too many elements; allowed: at most {MOST_ELEMENTS}, with the files that it includes");
            return Err(of_file(position.file, problem));
        }
        let tag = read_tag(tag, self.gate.depth(), position)?;
        let is_root = position.depth == 0;
        if position.is_in_include {
            return Err(position
                .fault(tag.label(), "an include contains no element\n  remedy: put this element after the include"));
        }
        if is_root && position.has_root {
            return Err(position.fault("this is not XML", "a second outermost element"));
        }
        position.has_root = true;
        position.depth += 1;
        if is_root && position.is_included {
            // The elements of an included file take the place of the include.
            let roots = [&[self.vocabulary.root], self.vocabulary.other_roots].concat();
            let problem = || format!("allowed as the outermost element of an included file: {}", roots.join(", "));
            return if roots.contains(&tag.name.as_str()) {
                Ok(())
            } else {
                Err(position.fault(tag.label(), problem()))
            };
        }
        if tag.name == INCLUDE && tag.depth == 1 {
            position.is_in_include = true;
            return self.include(&tag, position);
        }
        self.gate.open(&tag.name, tag.pairs()).map_err(|error| at(error, position))?;
        if self.gate.depth() == 1 {
            return self.end_element(position);
        }
        if self.gate.is_omitting() || self.is_faulty {
            return Ok(());
        }
        match (self.look)(&tag) {
            Err(Problem { element, problem }) if self.gate.is_lenient => {
                self.is_faulty = true;
                if self.left_out.count == 0 {
                    self.left_out.first =
                        format!("{}:{}: {element}: {problem}", position.file.display(), position.line);
                }
                self.left_out.count += 1;
                Ok(())
            }
            looked => looked.map_err(|problem| at(problem.into(), position)),
        }
    }

    /// Ends an element within the outermost one, or the outermost one's start tag.
    fn end_element(&mut self, position: &ReadPosition) -> Result<(), StreamError> {
        let is_left_out = std::mem::take(&mut self.is_faulty);
        self.gate.writer().end(is_left_out).map_err(|error| at(error.into(), position))
    }

    fn close(&mut self, position: &mut ReadPosition) -> Result<(), StreamError> {
        position.depth -= 1;
        if std::mem::take(&mut position.is_in_include) || position.depth == 0 && position.is_included {
            return Ok(());
        }
        self.gate.close().map_err(|error| at(error, position))?;
        if self.gate.depth() <= 1 { self.end_element(position) } else { Ok(()) }
    }

    /// Copies the elements of the file that an include names.
    fn include(&mut self, tag: &Tag, position: &ReadPosition) -> Result<(), StreamError> {
        let refused = |problem: String| position.fault(tag.label(), problem);
        let Some(around) = self.open_files.last().and_then(|file| file.parent()) else {
            return Err(refused("the include is not in a file".into()));
        };
        let href = tag.attribute("href").unwrap_or_default();
        let found = source::included(around, href).map_err(refused)?;
        self.includes += 1;
        let (depth, includes) = (self.open_files.len(), self.includes);
        if self.open_files.contains(&found) {
            return Err(refused(
                "the file includes itself, directly or through other files\n  remedy: remove the include".into(),
            ));
        }
        if depth > MOST_INCLUDE_DEPTH || includes > MOST_INCLUDES {
            return Err(refused(format!(
                "this is include {includes} of the file, at depth {depth}; allowed: {MOST_INCLUDES} includes, depth \
                 {MOST_INCLUDE_DEPTH}"
            )));
        }
        self.file(&position.file.with_file_name(href), found, true)
    }
}

fn at(error: GateError, position: &ReadPosition) -> StreamError {
    match error {
        GateError::Refused(Problem { element, problem }) => position.fault(element, problem),
        GateError::Write(error) => of_file(position.file, format!("the copy for SUMO cannot be written: {error}")),
    }
}

/// Reads a tag. Attributes with a prefix belong to no vocabulary of SUMO and are left out.
fn read_tag(tag: &BytesStart, depth: usize, position: &ReadPosition) -> Result<Tag, StreamError> {
    let no_text =
        |error: std::str::Utf8Error| position.fault("this is not UTF-8 text", format!("{error}; save it as UTF-8"));
    let name = std::str::from_utf8(tag.name().into_inner()).map_err(no_text)?.to_owned();
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|error| position.fault(&name, error))?;
        let key = std::str::from_utf8(attribute.key.into_inner()).map_err(no_text)?;
        if key == "xmlns" || key.contains(':') {
            continue;
        }
        let value =
            attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|error| position.fault(&name, error))?;
        attributes.push((key.to_owned(), value.into_owned()));
    }
    Ok(Tag { name, attributes, depth })
}
