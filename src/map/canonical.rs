//! Check of a network before SUMO reads it. In: the tree of a `net.xml`. Out: its canonical text, which SUMO reads, or the first element
//! that is refused. Networks that come with the program pass unchanged, byte by byte.

use super::{
    MapError,
    limits::{self, MOST_BYTES},
    xml_tree::{Element, XmlTree},
};
use crate::{
    data_folders,
    file::size_text,
    sumo_xml::{self, Dropped, Gate, GateError},
};
use std::{fmt, path::Path, sync::Arc};

/// Text of a network for SUMO. Comparison ignores the text: any two values are equal.
#[derive(Clone, Default)]
pub struct SumoText {
    text: Arc<str>,
    dropped: Arc<Dropped>,
}

impl SumoText {
    /// Checks the text of `file` and makes its canonical copy; `tree` is the parsed text.
    ///
    /// # Errors
    /// An element, an attribute or a parameter is refused.
    pub(super) fn of(file: &Path, text: &str, tree: &XmlTree) -> Result<Self, MapError> {
        if data_folders::is_shipped_for_sumo(text.as_bytes()) {
            return Ok(Self { text: text.into(), dropped: Arc::default() });
        }
        let (text, dropped) = canonical(file, tree.root(), text.len())?;
        Ok(Self { text: text.into(), dropped: Arc::new(dropped) })
    }

    /// Checks the text of `file` without reading its roads.
    ///
    /// # Errors
    /// The file is not a network, or a part of it is refused.
    pub(super) fn read(file: &Path, text: &str) -> Result<Self, MapError> {
        let tree = limits::parse(file, text)?;
        let root = tree.root();
        if root.name() != "net" {
            let (line, found) = (root.line(), root.name().to_owned());
            return Err(MapError::NotANet { file: file.into(), line, found });
        }
        Self::of(file, text, &tree)
    }

    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// Returns the counts of the parts that the copy leaves out.
    pub fn dropped(&self) -> &Dropped {
        &self.dropped
    }
}

impl PartialEq for SumoText {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for SumoText {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} bytes of text", self.text.len())
    }
}

/// Copies a tree; `bytes` is the initial capacity of the copy.
fn canonical(file: &Path, root: Element, bytes: usize) -> Result<(String, Dropped), MapError> {
    let mut gate = Gate::new(sumo_xml::network(), Vec::with_capacity(bytes));
    let at = |node: Element, error: GateError| match error {
        GateError::Refused(sumo_xml::Problem { element, problem }) => {
            MapError::Refused { file: file.into(), line: node.line(), element, problem }
        }
        GateError::Write(source) => MapError::Io { file: file.into(), source },
    };
    // End index of each open element.
    let mut ends: Vec<usize> = Vec::new();
    for node in root.descendants() {
        while ends.pop_if(|end| node.place() >= *end).is_some() {
            gate.close().map_err(|error| at(node, error))?;
        }
        gate.open(node.name(), node.attributes()).map_err(|error| at(node, error))?;
        ends.push(node.end());
    }
    for _ in ends {
        gate.close().map_err(|error| at(root, error))?;
    }
    let (text, dropped) = gate.into_inner();
    if text.len() as u64 > MOST_BYTES {
        let (what, value) = ("the size of its canonical copy".into(), size_text(text.len() as u64));
        let allowed = format!("at most {}", size_text(MOST_BYTES));
        return Err(MapError::Limit { file: file.into(), what, value, allowed });
    }
    Ok((String::from_utf8(text).expect("names and values are text"), dropped))
}
