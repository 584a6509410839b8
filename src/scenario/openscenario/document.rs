//! OpenSCENARIO documents as elements with their lines. In: the path of a file. Out: a tree of [`Element`]s that owns its text, so that entries
//! of catalogs stand beside those of the scenario; or the fault with file, line and remedy.

use super::fault::OpenScenarioError;
use crate::{sumo_xml::document::read_text, toml_text::did_you_mean_file};
use roxmltree::{Document, Node, ParsingOptions};
use std::{io::ErrorKind, path::Path, rc::Rc};

/// Largest size of a file, bytes: fifty times the largest example of esmini.
const MOST_BYTES: u64 = 8 << 20;
/// Largest number of elements and texts of a file: they take about 100 MiB.
const MOST_NODES: u32 = 400_000;
/// Deepest nesting of elements; a trajectory within a story has 20.
const DEEPEST: usize = 60;

/// Element of a document.
#[derive(Debug, PartialEq)]
pub(super) struct Element {
    pub name: String,
    pub place: Place,
    attributes: Vec<(String, String)>,
    pub children: Vec<Rc<Element>>,
}

/// Line of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub file: Rc<Path>,
    pub line: u32,
}

impl Place {
    /// Returns an error at this place.
    pub fn fault(&self, message: impl Into<String>) -> OpenScenarioError {
        OpenScenarioError { file: self.file.to_path_buf(), line: self.line, message: message.into() }
    }
}

impl Element {
    /// Returns an attribute as it is written.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }

    /// Returns the names of all attributes.
    pub fn attribute_names(&self) -> impl Iterator<Item = &str> {
        self.attributes.iter().map(|(name, _)| name.as_str())
    }

    /// Returns the first child with this name.
    pub fn child(&self, name: &str) -> Option<&Rc<Element>> {
        self.children.iter().find(|child| child.name == name)
    }
}

/// Reads the outermost element of a file.
///
/// # Errors
/// The file is missing, too large or no XML, is nested too deeply, or its outermost element is not `<OpenSCENARIO>`.
pub(super) fn read(file: &Path) -> Result<Rc<Element>, OpenScenarioError> {
    let fault = |line: u32, message: String| OpenScenarioError { file: file.to_path_buf(), line, message };
    let text = read_text(file, MOST_BYTES).map_err(|error| match error.kind() {
        ErrorKind::NotFound => fault(0, format!("there is no such file{}", did_you_mean_file(file))),
        _ => fault(0, error.to_string()),
    })?;
    // The parser's own depth is bounded by the memory alone.
    if let Some(line) = too_deep(&text) {
        return Err(fault(line, format!("elements within elements; allowed: at most {DEEPEST} deep")));
    }
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let tree = Document::parse_with_options(&text, options).map_err(|error| match error {
        roxmltree::Error::NodesLimitReached => {
            fault(0, format!("more than {MOST_NODES} elements and texts; allowed: fewer"))
        }
        error => fault(error.pos().row, format!("this is not XML: {error}\n  remedy: export the scenario again")),
    })?;
    let (root, lines) = (tree.root_element(), LineStarts::of(&text));
    let found = root.tag_name().name();
    if found != "OpenSCENARIO" {
        let message = format!(
            "the outermost element is <{found}>; allowed: <OpenSCENARIO>\n  remedy: name a file of OpenSCENARIO XML, .xosc"
        );
        return Err(fault(lines.line(root.range().start), message));
    }
    Ok(element(root, &file.into(), &lines))
}

fn element(node: Node, file: &Rc<Path>, lines: &LineStarts) -> Rc<Element> {
    let plain = node.attributes().filter(|own| own.namespace().is_none());
    let attributes = plain.map(|own| (own.name().to_owned(), own.value().to_owned()));
    let children = node.children().filter(Node::is_element).map(|child| element(child, file, lines));
    Rc::new(Element {
        name: node.tag_name().name().to_owned(),
        place: Place { file: Rc::clone(file), line: lines.line(node.range().start) },
        attributes: attributes.collect(),
        children: children.collect(),
    })
}

/// Positions at which the lines of a text begin, bytes.
struct LineStarts(Vec<usize>);

impl LineStarts {
    fn of(text: &str) -> Self {
        let after = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1);
        Self(std::iter::once(0).chain(after).collect())
    }

    /// Returns the line of a position, from 1.
    fn line(&self, at: usize) -> u32 {
        self.0.partition_point(|start| *start <= at) as u32
    }
}

/// Returns the line of the first tag that lies deeper than [`DEEPEST`]. Tags in comments count as others.
fn too_deep(text: &str) -> Option<u32> {
    let bytes = text.as_bytes();
    let (mut depth, mut at) = (0_usize, 0);
    while let Some(found) = text.get(at..).and_then(|rest| rest.find('<')) {
        let start = at + found;
        let (mut end, mut quote) = (start + 1, None);
        while let Some(byte) = bytes.get(end) {
            match (quote, byte) {
                (None, b'>' | b'<') => break,
                (None, b'"' | b'\'') => quote = Some(byte),
                (Some(open), byte) if open == byte => quote = None,
                _ => {}
            }
            end += 1;
        }
        match bytes.get(start + 1) {
            Some(b'!' | b'?') => end = start + 1,
            Some(b'/') => depth = depth.saturating_sub(1),
            _ => depth += usize::from(bytes[end - 1] != b'/'),
        }
        if depth > DEEPEST {
            return Some(LineStarts::of(text).line(start));
        }
        at = end;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Rc<Element>, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("a.xosc");
        std::fs::write(&file, text).expect("written");
        read(&file).map_err(|error| error.to_string().replace(&folder.path().display().to_string(), ""))
    }

    #[test]
    fn elements_have_their_lines_and_attributes() {
        let text = "<?xml version=\"1.0\"?>\n<!-- < -->\n<OpenSCENARIO>\n\n  <A b='1>'\n c='&lt;'/></OpenSCENARIO>";
        let root = of(text).expect("a scenario");
        let a = root.child("A").expect("a child");
        assert_eq!((root.place.line, a.place.line), (3, 5));
        assert_eq!((a.attribute("b"), a.attribute("c"), a.attribute("d")), (Some("1>"), Some("<"), None));
    }

    #[test]
    fn files_that_are_no_scenario_are_refused_with_line_and_remedy() {
        let cases = [
            ("<OpenSCENARIO>\n<A></OpenSCENARIO>".to_owned(), "/a.xosc:2: this is not XML"),
            ("\n<OpenDRIVE/>".into(), "/a.xosc:2: the outermost element is <OpenDRIVE>; allowed: <OpenSCENARIO>"),
            ("<!DOCTYPE a [<!ENTITY b \"c\">]><OpenSCENARIO/>".into(), "/a.xosc:1: this is not XML"),
            (String::new(), "/a.xosc:1: this is not XML"),
            (
                format!("<OpenSCENARIO>\n{}", "<a>\n".repeat(200_000)),
                "/a.xosc:61: elements within elements; allowed: at most 60",
            ),
            (format!("<OpenSCENARIO>{}</OpenSCENARIO>", "<a/>".repeat(400_001)), "/a.xosc: more than 400000 elements"),
            (" ".repeat(9 << 20), "/a.xosc: it holds more than 8 MiB"),
        ];
        for (text, wanted) in cases {
            let fault = of(&text).expect_err("a fault");
            assert!(fault.starts_with(wanted), "{fault}\n{wanted}");
        }
        let missing = read(Path::new("/none/a.xosc")).unwrap_err().to_string();
        assert!(missing.starts_with("/none/a.xosc: there is no such file"), "{missing}");
    }
}
