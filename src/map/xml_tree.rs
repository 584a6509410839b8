//! XML document as elements and attributes in little memory. In: the text of an XML file. Out: an [`XmlTree`] that refers to the text: 16
//! bytes per element and 12 per attribute, where a general-purpose tree takes 72 and more. quick-xml splits the text into tags; the
//! remaining rules of XML are checked here. Document types and custom entities are refused. Text between tags is checked and dropped:
//! networks contain none.

use crate::sumo_xml::first_bad_character;
use quick_xml::{
    Reader, XmlVersion,
    escape::resolve_predefined_entity,
    events::{
        BytesRef, BytesStart, Event,
        attributes::{AttrError, Attribute, Attributes},
    },
};
use std::collections::BTreeMap;

/// Fault in a text, with its position in bytes from the start.
#[derive(Debug)]
pub(super) struct XmlFault {
    pub at: usize,
    pub message: String,
}

fn fault(at: usize, message: impl ToString) -> XmlFault {
    XmlFault { at, message: message.to_string() }
}

/// Document; elements and attributes are in the order of the text.
pub(super) struct XmlTree<'text> {
    text: &'text str,
    /// Values that differ from their source text, concatenated.
    decoded: String,
    names: Vec<Name<'text>>,
    elements: Vec<ElementData>,
    attributes: Vec<AttributeData>,
}

/// Name split into prefix and local part.
struct Name<'text> {
    prefix: &'text str,
    local: &'text str,
}

struct ElementData {
    name: u32,
    /// Position of `<` in the text, bytes.
    at: u32,
    /// Index behind the last descendant.
    end: u32,
    /// Index of the first attribute; the attributes end where those of the next element begin.
    first_attribute: u32,
}

struct AttributeData {
    name: u32,
    /// Start of the value in the text, or among the decoded values if `length` has the bit [`DECODED`].
    start: u32,
    length: u32,
}

/// Byte order mark, which may precede a text and is not part of it.
pub(super) const BYTE_ORDER_MARK: char = '\u{feff}';

/// Bit of `length` that marks a value in the decoded values.
const DECODED: u32 = 1 << 31;

/// Element of a tree.
#[derive(Clone, Copy)]
pub(super) struct Element<'t> {
    tree: &'t XmlTree<'t>,
    index: usize,
}

impl<'text> XmlTree<'text> {
    /// Parses a text of less than 2 GiB, without a byte order mark.
    ///
    /// # Errors
    /// The text is not XML; the error has the position of the first fault.
    pub fn parse(text: &'text str) -> Result<Self, XmlFault> {
        check_characters(text)?;
        // quick-xml would skip it, and count positions from behind it.
        if text.starts_with(BYTE_ORDER_MARK) {
            return Err(fault(0, "text outside the document's element"));
        }
        let tree = Self { text, decoded: String::new(), names: vec![], elements: vec![], attributes: vec![] };
        let mut builder = Builder { tree, known_names: BTreeMap::new(), open: Vec::new(), prefixes: Vec::new() };
        let mut reader = Reader::from_str(text);
        reader.config_mut().check_comments = true;
        loop {
            let from = reader.buffer_position() as usize;
            let event = reader.read_event().map_err(|error| fault(reader.error_position() as usize, error))?;
            let to = reader.buffer_position() as usize;
            match event {
                Event::Start(tag) => builder.open(to - tag.len() - 2, &tag)?,
                Event::Empty(tag) => {
                    builder.open(to - tag.len() - 3, &tag)?;
                    builder.close();
                }
                Event::End(_) => builder.close(),
                Event::Text(_) => builder.words(from, &text[from..to])?,
                Event::GeneralRef(reference) => builder.reference(from, &reference)?,
                Event::CData(_) => builder.inside(from)?,
                Event::Comment(_) => {}
                Event::PI(_) => drop(builder.name(from + 2, name_in(&text[from + 2..to - 2]))?),
                Event::Decl(declaration) => {
                    if from > 0 {
                        return Err(fault(from, "a declaration (<?xml ...?>) that is not at the start"));
                    }
                    declaration.version().map_err(|error| fault(from, error))?;
                    builder.attributes(from + 2, &text[from + 2..to - 2], "xml".len())?;
                    builder.tree.attributes.clear();
                }
                Event::DocType(_) => {
                    return Err(fault(from, "a document type (<!DOCTYPE ...>), which codrive does not read"));
                }
                Event::Eof => return builder.finish(),
            }
        }
    }

    /// Returns the root element.
    pub fn root(&self) -> Element<'_> {
        Element { tree: self, index: 0 }
    }
}

impl<'t> Element<'t> {
    fn data(self) -> &'t ElementData {
        &self.tree.elements[self.index]
    }

    /// Returns the name without its prefix.
    pub fn name(self) -> &'t str {
        self.tree.names[self.data().name as usize].local
    }

    /// Returns the line of the element's start, from 1. For errors only: it counts from the start of the text.
    pub fn line(self) -> u32 {
        line_and_column(self.tree.text, self.data().at as usize).0
    }

    /// Returns the element and all its descendants, in the order of the text.
    pub fn descendants(self) -> impl Iterator<Item = Self> {
        (self.index..self.data().end as usize).map(move |index| Self { index, ..self })
    }

    /// Returns the index in the order of the text.
    pub fn place(self) -> usize {
        self.index
    }

    /// Returns the index behind the last descendant.
    pub fn end(self) -> usize {
        self.data().end as usize
    }

    /// Returns the child elements.
    pub fn children(self) -> impl Iterator<Item = Self> {
        let end = self.data().end as usize;
        let child = move |index: usize| (index < end).then_some(Self { index, ..self });
        std::iter::successors(child(self.index + 1), move |before| child(before.data().end as usize))
    }

    /// Returns the child elements with this name.
    pub fn children_named(self, name: &str) -> impl Iterator<Item = Self> {
        self.children().filter(move |child| child.name() == name)
    }

    fn attribute_data(self) -> &'t [AttributeData] {
        let end = self.tree.elements.get(self.index + 1).map(|next| next.first_attribute as usize);
        &self.tree.attributes[self.data().first_attribute as usize..end.unwrap_or(self.tree.attributes.len())]
    }

    fn value(self, attribute: &AttributeData) -> &'t str {
        let (start, length) = (attribute.start as usize, (attribute.length & !DECODED) as usize);
        let within: &'t str = if attribute.length & DECODED == 0 { self.tree.text } else { &self.tree.decoded };
        &within[start..start + length]
    }

    /// Returns the value of the attribute with this name and without a prefix.
    pub fn attribute(self, name: &str) -> Option<&'t str> {
        self.attributes().find(|(own, _)| *own == name).map(|(_, value)| value)
    }

    /// Returns true if the element has an attribute with this name and without a prefix.
    pub fn has_attribute(self, name: &str) -> bool {
        self.attribute(name).is_some()
    }

    /// Returns names and values of the attributes without a prefix.
    pub fn attributes(self) -> impl Iterator<Item = (&'t str, &'t str)> + Clone {
        let named = self.attribute_data().iter().map(move |data| (&self.tree.names[data.name as usize], data));
        named.filter(|(name, _)| name.prefix.is_empty()).map(move |(name, data)| (name.local, self.value(data)))
    }
}

/// Builder of a tree while the text is read.
struct Builder<'text> {
    tree: XmlTree<'text>,
    known_names: BTreeMap<&'text str, u32>,
    /// Indices of the elements that are not closed yet.
    open: Vec<u32>,
    /// Declared prefixes, with the number of open elements at their declaration.
    prefixes: Vec<(usize, &'text str)>,
}

impl<'text> Builder<'text> {
    /// Adds an element whose tag begins at `at`.
    fn open(&mut self, at: usize, tag: &BytesStart) -> Result<(), XmlFault> {
        if self.open.is_empty() && !self.tree.elements.is_empty() {
            return Err(fault(at, "a second outermost element"));
        }
        let within = &self.tree.text[at + 1..at + 1 + tag.len()];
        let name = self.name(at + 1, &within[..tag.name().as_ref().len()])?;
        let index = self.tree.elements.len() as u32;
        let first_attribute = self.tree.attributes.len() as u32;
        self.tree.elements.push(ElementData { name, at: at as u32, end: index + 1, first_attribute });
        self.open.push(index);
        self.attributes(at + 1, within, tag.name().as_ref().len())?;
        let of_attributes = self.tree.attributes[first_attribute as usize..].iter().map(|attribute| attribute.name);
        for name in std::iter::once(name).chain(of_attributes) {
            let prefix = self.tree.names[name as usize].prefix;
            if !matches!(prefix, "" | "xml") && !self.prefixes.iter().any(|(_, known)| *known == prefix) {
                return Err(fault(at, format!("the prefix \"{prefix}\" is not declared")));
            }
        }
        Ok(())
    }

    /// Adds the attributes of a tag whose text begins at `base`, the first one after `from` bytes.
    fn attributes(&mut self, base: usize, tag: &'text str, from: usize) -> Result<(), XmlFault> {
        let first = self.tree.attributes.len();
        // Duplicate names are detected below, by comparing numbers.
        let mut attributes = Attributes::new(tag, from);
        for attribute in attributes.with_checks(false) {
            let attribute = attribute.map_err(|error| attribute_fault(base, tag, &error))?;
            let key = offset_in(tag, attribute.key.as_ref());
            let start = offset_in(tag, &attribute.value);
            let (name, value) =
                (&tag[key..key + attribute.key.as_ref().len()], &tag[start..start + attribute.value.len()]);
            if !tag.as_bytes()[key - 1].is_ascii_whitespace() {
                return Err(fault(base + key, "a space is missing before an attribute"));
            }
            if let Some(at) = value.find('<') {
                return Err(fault(base + start + at, "< in a value"));
            }
            let id = self.name(base + key, name)?;
            let (start, length) = self.value(base + start, &attribute)?;
            if name == "xmlns" {
                continue;
            }
            if let Some(prefix) = name.strip_prefix("xmlns:") {
                self.prefixes.push((self.open.len(), prefix));
                continue;
            }
            if self.tree.attributes[first..].iter().any(|other| other.name == id) {
                return Err(fault(base + key, format!("the attribute \"{name}\" is given twice")));
            }
            self.tree.attributes.push(AttributeData { name: id, start, length });
        }
        Ok(())
    }

    /// Returns start and length of a value that begins at `at` in the text; a value that needs decoding is added to the decoded values.
    fn value(&mut self, at: usize, attribute: &Attribute) -> Result<(u32, u32), XmlFault> {
        if !attribute.value.iter().any(|byte| matches!(byte, b'&' | b'\t' | b'\n' | b'\r')) {
            return Ok((at as u32, attribute.value.len() as u32));
        }
        let read = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|error| fault(at, error))?;
        check_characters(&read).map_err(|wrong| fault(at, wrong.message))?;
        let start = self.tree.decoded.len() as u32;
        self.tree.decoded.push_str(&read);
        Ok((start, read.len() as u32 | DECODED))
    }

    /// Returns the number of a name, and adds the name if it is new.
    fn name(&mut self, at: usize, name: &'text str) -> Result<u32, XmlFault> {
        if let Some(known) = self.known_names.get(name) {
            return Ok(*known);
        }
        let (prefix, local) = name.split_once(':').unwrap_or(("", name));
        if !is_name(local) || (!prefix.is_empty() && !is_name(prefix)) {
            return Err(fault(at, format!("\"{}\" is no name", name.chars().take(40).collect::<String>())));
        }
        let number = self.tree.names.len() as u32;
        self.tree.names.push(Name { prefix, local });
        self.known_names.insert(name, number);
        Ok(number)
    }

    fn close(&mut self) {
        let end = self.tree.elements.len() as u32;
        if let Some(closed) = self.open.pop() {
            self.tree.elements[closed as usize].end = end;
        }
        let depth = self.open.len();
        self.prefixes.retain(|(declared, _)| *declared <= depth);
    }

    /// Checks that an element is open: outside the root only white space is allowed.
    fn inside(&self, at: usize) -> Result<(), XmlFault> {
        if self.open.is_empty() { Err(fault(at, "text outside the document's element")) } else { Ok(()) }
    }

    /// Checks text between tags that begins at `at`.
    fn words(&self, at: usize, words: &str) -> Result<(), XmlFault> {
        if let Some(end) = words.find("]]>") {
            return Err(fault(at + end, "]]> outside a CDATA section"));
        }
        match words.trim_matches(is_space) {
            "" => Ok(()),
            _ => self.inside(at),
        }
    }

    /// Checks a reference such as `&lt;` between tags.
    fn reference(&self, at: usize, reference: &BytesRef) -> Result<(), XmlFault> {
        self.inside(at)?;
        let character = reference.resolve_char_ref().map_err(|error| fault(at, error))?;
        let name = reference.decode().map_err(|error| fault(at, error))?;
        match character {
            Some(character) => check_characters(character.encode_utf8(&mut [0; 4])),
            None if resolve_predefined_entity(&name).is_some() => Ok(()),
            None => Err(fault(at, format!("the entity \"&{name};\" is not defined"))),
        }
        .map_err(|wrong| fault(at, wrong.message))
    }

    fn finish(mut self) -> Result<XmlTree<'text>, XmlFault> {
        let end = self.tree.text.len();
        if self.tree.elements.is_empty() {
            return Err(fault(end, "the document has no element"));
        }
        if let Some(open) = self.open.last() {
            let name = self.tree.names[self.tree.elements[*open as usize].name as usize].local;
            return Err(fault(end, format!("the text ends before </{name}>")));
        }
        self.tree.elements.shrink_to_fit();
        self.tree.attributes.shrink_to_fit();
        Ok(self.tree)
    }
}

/// Builds the error for faulty attributes of a tag whose text begins at `base`. A `<` in the tag means that the tag is not closed.
fn attribute_fault(base: usize, tag: &str, error: &AttrError) -> XmlFault {
    if let Some(at) = tag.find('<') {
        return fault(base + at, "a tag begins before the previous tag is closed (>)");
    }
    let (AttrError::ExpectedEq(at)
    | AttrError::ExpectedValue(at)
    | AttrError::UnquotedValue(at)
    | AttrError::ExpectedQuote(at, _)
    | AttrError::Duplicated(at, _)) = error;
    fault(base + at, error)
}

/// Returns line and column of a position, from 1; a column is a character. For errors only: it counts from the start of the text.
pub(super) fn line_and_column(text: &str, at: usize) -> (u32, u32) {
    let before = &text[..text.floor_char_boundary(at)];
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    (line as u32, column as u32)
}

/// Returns the position of a part of a text in that text, bytes.
fn offset_in(text: &str, part: &[u8]) -> usize {
    part.as_ptr() as usize - text.as_ptr() as usize
}

/// Refuses characters that XML forbids: control characters and two noncharacters.
fn check_characters(text: &str) -> Result<(), XmlFault> {
    first_bad_character(text).map_or(Ok(()), |at| Err(fault(at, "a character that XML does not allow")))
}

fn is_space(c: char) -> bool {
    matches!(c, ' ' | '\t' | '\n' | '\r')
}

/// Returns true if a text is an XML name without a prefix. All characters beyond ASCII are accepted.
fn is_name(text: &str) -> bool {
    !text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '.'))
        && !text.is_empty()
        && text.chars().all(in_name)
}

fn in_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.') || !c.is_ascii()
}

/// Returns the beginning of a text, up to the first character not allowed in a name.
fn name_in(text: &str) -> &str {
    text.split(|c| !in_name(c)).next().unwrap_or_default()
}
