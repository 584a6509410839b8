//! Reading a network. In: the text of a net.xml, checked by `net_check` for what SUMO would break down on. Out: the whole
//! [`Network`]: names become indices, each element in the order of the file. What a network says of other things than its roads
//! is left out: parameters of edges, lanes and connections, places to stop before a line for some classes, kinds of roads, and
//! prohibitions, which its rules have already.

mod connections;
mod edges;
mod junctions;

pub(super) use edges::DEFAULT_WIDTH_M;

use super::{EdgeId, JunctionId, LaneId, Network, SignalId};
use crate::map::{MapError, limits, net_check, net_xml::NetReader};
use roxmltree::Node;
use std::{collections::BTreeMap, path::Path};

/// A reader with what names stand for, as far as it has read.
struct Names<'r, 'a, 'input> {
    reader: &'r NetReader<'a, 'input>,
    edges: BTreeMap<&'r str, EdgeId>,
    lanes: BTreeMap<&'r str, LaneId>,
    junctions: BTreeMap<&'r str, JunctionId>,
    signals: BTreeMap<&'r str, SignalId>,
}

/// The elements below the root with a name.
fn elements<'a, 'input: 'a>(root: Node<'a, 'input>, name: &'static str) -> impl Iterator<Item = Node<'a, 'input>> {
    root.children().filter(move |node| node.has_tag_name(name))
}

impl Network {
    /// Reads the text of `file`, which is named in errors only.
    ///
    /// # Errors
    /// If it is not XML or not a network, is larger than the limits of [`limits`], or has a value that cannot be; the message names
    /// file, line, element and value.
    pub fn read(file: &Path, text: &str) -> Result<Self, MapError> {
        // The document is gone before the grid is made: together they would take half as much again.
        let mut net = Self::elements(file, text)?;
        net.derive();
        Ok(net)
    }

    /// The lists of a network, without what follows from them.
    fn elements(file: &Path, text: &str) -> Result<Self, MapError> {
        let document = limits::parse(file, text)?;
        let root = document.root_element();
        let reader = NetReader { file, document: &document };
        if root.tag_name().name() != "net" {
            let (line, found) = (reader.line(root), root.tag_name().name().to_owned());
            return Err(MapError::NotANet { file: file.into(), line, found });
        }
        net_check::check(&reader, root)?;
        let mut names = Names {
            reader: &reader,
            edges: BTreeMap::new(),
            lanes: BTreeMap::new(),
            junctions: BTreeMap::new(),
            signals: BTreeMap::new(),
        };
        let mut net = Network {
            header: words_but(root, &[]),
            location: elements(root, "location").next().map(|node| words_but(node, &[])).unwrap_or_default(),
            left_hand: reader.truth(root, "lefthand", false)?,
            ..Network::default()
        };
        for (k, node) in elements(root, "junction").enumerate() {
            names.junctions.insert(reader.text(node, "id")?, JunctionId::from_index(k));
            net.junctions.push(names.junction(node)?);
        }
        let mut points = 0;
        for (k, node) in elements(root, "edge").enumerate() {
            names.edges.insert(reader.text(node, "id")?, EdgeId::from_index(k));
            names.edge(&mut net, node, &mut points)?;
        }
        for node in elements(root, "edge") {
            names.references_of_edge(&mut net, node)?;
        }
        for node in elements(root, "tlLogic") {
            names.signal(&mut net, node)?;
        }
        names.railway_signals(&mut net);
        for node in elements(root, "connection") {
            let connection = names.connection(node, &net)?;
            net.connections.push(connection);
        }
        // Those of a lane stand together, in the order of the file.
        net.connections.sort_by_key(|connection| connection.from);
        for (k, node) in elements(root, "junction").enumerate() {
            names.lanes_of_junction(&mut net.junctions[k], node)?;
        }
        for node in elements(root, "roundabout") {
            let roundabout = names.roundabout(node)?;
            net.roundabouts.push(roundabout);
        }
        Ok(net)
    }
}

/// The attributes of an element but some, as words.
fn words_but(node: Node, known: &[&str]) -> Vec<(String, String)> {
    let others =
        node.attributes().filter(|attribute| attribute.namespace().is_none() && !known.contains(&attribute.name()));
    others.map(|attribute| (attribute.name().to_owned(), attribute.value().to_owned())).collect()
}

/// The children `<param key=".." value=".."/>` of an element.
fn parameters(node: Node) -> Vec<(String, String)> {
    let pairs = node.children().filter(|child| child.has_tag_name("param"));
    pairs.filter_map(|node| Some((node.attribute("key")?.to_owned(), node.attribute("value")?.to_owned()))).collect()
}

impl<'r> Names<'r, '_, '_> {
    /// What the words of a list stand for.
    fn listed<T: Copy>(
        &self,
        node: Node,
        attribute: &str,
        of: &BTreeMap<&'r str, T>,
        allowed: &'static str,
    ) -> Result<Vec<T>, MapError> {
        let words = node.attribute(attribute).unwrap_or_default().split_whitespace();
        words.map(|word| of.get(word).copied().ok_or_else(|| self.reader.value(node, attribute, allowed))).collect()
    }
}
