//! Reading a network. In: the text of a net.xml, checked by `net_check` for errors on which SUMO would crash. Out: the whole [`Network`]:
//! names become indices, and elements keep the order of the file. Content other than roads is left out: parameters of edges, lanes and
//! connections, stop offsets for some classes, edge types, and prohibitions, which the junction rules already contain.

mod connections;
mod edges;
mod junctions;

use super::{EdgeId, JunctionId, LaneId, Network, SignalId};
use crate::{
    map::{MapError, SumoText, limits, net_check, net_xml::NetReader, xml_tree::Element},
    sumo_xml::{
        self,
        gate::{Pass, passes},
    },
};
use std::{collections::BTreeMap, path::Path};

/// Reader with the indices of all names read so far.
struct Names<'r> {
    reader: &'r NetReader<'r>,
    edges: BTreeMap<&'r str, EdgeId>,
    lanes: BTreeMap<&'r str, LaneId>,
    junctions: BTreeMap<&'r str, JunctionId>,
    signals: BTreeMap<&'r str, SignalId>,
}

impl Network {
    /// Reads the text of `file`, whose name appears in errors only.
    ///
    /// # Errors
    /// The text is not XML or not a network, exceeds the limits of [`limits`], or has an invalid value; the message names file, line,
    /// element and value.
    pub fn read(file: &Path, text: &str) -> Result<Self, MapError> {
        // The document is dropped before the grid is built: both together would take half as much memory again.
        let mut net = Self::elements(file, text)?;
        net.derive();
        Ok(net)
    }

    /// Reads the lists of a network, without the derived data.
    fn elements(file: &Path, text: &str) -> Result<Self, MapError> {
        let tree = limits::parse(file, text)?;
        let root = tree.root();
        let reader = NetReader { file };
        if root.name() != "net" {
            let (line, found) = (root.line(), root.name().to_owned());
            return Err(MapError::NotANet { file: file.into(), line, found });
        }
        let sumo = SumoText::of(file, text, &tree)?;
        net_check::check(&reader, root).map_err(|problem| of_version(file, root, problem))?;
        let mut names = Names {
            reader: &reader,
            edges: BTreeMap::new(),
            lanes: BTreeMap::new(),
            junctions: BTreeMap::new(),
            signals: BTreeMap::new(),
        };
        let mut net = Network {
            header: words_but(root, &[]),
            location: root.children_named("location").next().map(|node| words_but(node, &[])).unwrap_or_default(),
            left_hand: reader.truth(root, "lefthand", false)?,
            sumo,
            ..Network::default()
        };
        for (k, node) in root.children_named("junction").enumerate() {
            names.junctions.insert(reader.text(node, "id")?, JunctionId::from_index(k));
            net.junctions.push(names.junction(node)?);
        }
        let mut points = 0;
        for (k, node) in root.children_named("edge").enumerate() {
            names.edges.insert(reader.text(node, "id")?, EdgeId::from_index(k));
            names.edge(&mut net, node, &mut points)?;
        }
        for node in root.children_named("edge") {
            names.references_of_edge(&mut net, node)?;
        }
        for node in root.children_named("tlLogic") {
            names.signal(&mut net, node)?;
        }
        names.railway_signals(&mut net);
        for node in root.children_named("connection") {
            let connection = names.connection(node, &net)?;
            net.connections.push(connection);
        }
        // Sorted by lane; connections of one lane keep the order of the file.
        net.connections.sort_by_key(|connection| connection.from);
        for (k, node) in root.children_named("junction").enumerate() {
            names.lanes_of_junction(&mut net.junctions[k], node)?;
        }
        for node in root.children_named("roundabout") {
            let roundabout = names.roundabout(node)?;
            net.roundabouts.push(roundabout);
        }
        Ok(net)
    }
}

/// Returns the error for a network, with the remedy for one of an old version of SUMO.
fn of_version(file: &Path, root: Element, problem: MapError) -> MapError {
    let version = root.attribute("version").unwrap_or_default().to_owned();
    match version.starts_with("0.") {
        true => MapError::Outdated { file: file.into(), version, problem: Box::new(problem) },
        false => problem,
    }
}

/// Returns the attributes of an element that are passed to SUMO, except those in `known`, as name and value.
fn words_but(node: Element, known: &[&str]) -> Vec<(String, String)> {
    let Some(rule) = sumo_xml::network().rule(node.name()) else { return Vec::new() };
    let others = node.attributes().filter(|(name, _)| !known.contains(name));
    let kept = others.filter_map(|(name, value)| match passes(rule, name, value) {
        Pass::Value(value) => Some((name.to_owned(), value.into_owned())),
        Pass::Dropped | Pass::Refused => None,
    });
    kept.collect()
}

/// Returns the children `<param key=".." value=".."/>` of an element that are passed to SUMO.
fn parameters(node: Element) -> Vec<(String, String)> {
    let rule = sumo_xml::network().rule(node.name());
    let text = |node: Element, name: &str| node.attribute(name).unwrap_or_default().to_owned();
    let pairs = node.children_named("param").map(|node| (text(node, "key"), text(node, "value")));
    pairs.filter(|(key, _)| rule.is_some_and(|rule| rule.has_key(key))).collect()
}

impl<'r> Names<'r> {
    /// Returns the indices of the names in a list.
    fn listed<T: Copy>(
        &self,
        node: Element,
        attribute: &str,
        of: &BTreeMap<&'r str, T>,
        allowed: &'static str,
    ) -> Result<Vec<T>, MapError> {
        let words = node.attribute(attribute).unwrap_or_default().split_whitespace();
        words.map(|word| of.get(word).copied().ok_or_else(|| self.reader.value(node, attribute, allowed))).collect()
    }
}
