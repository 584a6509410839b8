//! SUMO's network file as data. In: the text of a `net.xml`. Out: a [`Net`]: edges, lanes and the links between lanes, in
//! the order of the file, every number checked. Metres, m/s; heights (z) are left out: the world is flat.

use super::{Lane, MapError};
use glam::{DVec2, dvec2};
use roxmltree::{Document, Node};
use std::{collections::BTreeMap, ops::Range, path::Path};

/// Width of a lane that states none, metres (SUMO's default).
const DEFAULT_WIDTH_M: f64 = 3.2;

/// A network: lanes are named by their index in `lanes`, edges by theirs in `edges`.
#[derive(Debug)]
pub(super) struct Net {
    pub edges: Vec<Edge>,
    pub lanes: Vec<NetLane>,
    pub links: Vec<Link>,
}

#[derive(Debug)]
pub(super) struct Edge {
    pub id: String,
    /// Inside of a junction.
    pub internal: bool,
    /// Number of the junction where it ends; edges that end together have the same.
    pub to_junction: usize,
    /// Its lanes, right-most first.
    pub lanes: Range<usize>,
}

#[derive(Debug)]
pub(super) struct NetLane {
    pub lane: Lane,
    /// Its edge.
    pub edge: usize,
    /// Open to passenger cars.
    pub passenger: bool,
}

/// A way from one lane to the next.
#[derive(Debug)]
pub(super) struct Link {
    pub from: usize,
    pub to: usize,
    /// First lane on the junction's inside, if the network has insides.
    pub via: Option<usize>,
    /// A turn on the spot, back to where one came from.
    pub turnaround: bool,
}

impl Net {
    /// Reads the text of `file`, which is named in errors only.
    pub fn parse(file: &Path, text: &str) -> Result<Self, MapError> {
        let document = Document::parse(text).map_err(|error| MapError::NotXml {
            file: file.into(),
            line: error.pos().row,
            column: error.pos().col,
            message: error.to_string(),
        })?;
        let root = document.root_element();
        let reader = Reader { file, document: &document };
        if root.tag_name().name() != "net" {
            let (line, found) = (reader.line(root), root.tag_name().name().to_owned());
            return Err(MapError::NotANet { file: file.into(), line, found });
        }
        let mut net = Self { edges: Vec::new(), lanes: Vec::new(), links: Vec::new() };
        let mut edge_of_id = BTreeMap::new();
        let mut junctions = BTreeMap::new();
        for node in root.children().filter(|node| node.has_tag_name("edge")) {
            let id = reader.text(node, "id")?;
            if matches!(node.attribute("function"), Some("crossing" | "walkingarea")) {
                // For people on foot; connections to it lead nowhere for a car.
                edge_of_id.insert(id, None);
                continue;
            }
            let internal = node.attribute("function") == Some("internal");
            let next_number = junctions.len();
            let to_junction = *junctions.entry(node.attribute("to").unwrap_or(id)).or_insert(next_number);
            let first = net.lanes.len();
            for lane_node in node.children().filter(|node| node.has_tag_name("lane")) {
                net.lanes.push(reader.lane(lane_node, id, net.edges.len(), internal)?);
            }
            edge_of_id.insert(id, Some(net.edges.len()));
            net.edges.push(Edge { id: id.to_owned(), internal, to_junction, lanes: first..net.lanes.len() });
        }
        let lane_of_id: BTreeMap<&str, usize> =
            net.lanes.iter().enumerate().map(|(index, lane)| (lane.lane.id.as_str(), index)).collect();
        for node in root.children().filter(|node| node.has_tag_name("connection")) {
            let from = reader.lane_of(node, "from", "fromLane", &edge_of_id, &net.edges)?;
            let to = reader.lane_of(node, "to", "toLane", &edge_of_id, &net.edges)?;
            let via = match node.attribute("via") {
                None => None,
                Some(id) => match lane_of_id.get(id) {
                    Some(index) => Some(*index),
                    None => return Err(reader.value(node, "via", "the id of a lane of this network")),
                },
            };
            if let (Some(from), Some(to)) = (from, to) {
                net.links.push(Link { from, to, via, turnaround: node.attribute("dir") == Some("t") });
            }
        }
        Ok(net)
    }

    /// The edge of this id that cars drive on outside junctions.
    pub fn edge(&self, id: &str) -> Option<usize> {
        self.edges.iter().position(|edge| edge.id == id && !edge.internal)
    }
}

struct Reader<'a, 'input> {
    file: &'a Path,
    document: &'a Document<'input>,
}

impl<'input> Reader<'_, 'input> {
    /// Counts lines from the start of the file, so it is called for errors only.
    fn line(&self, node: Node) -> u32 {
        self.document.text_pos_at(node.range().start).row
    }

    fn value(&self, node: Node, attribute: &str, allowed: &'static str) -> MapError {
        let tag = node.tag_name().name();
        let element = match (node.attribute("id"), node.attribute("from"), node.attribute("to")) {
            (Some(id), _, _) => format!("{tag} \"{id}\""),
            (None, Some(from), Some(to)) => format!("{tag} from \"{from}\" to \"{to}\""),
            _ => tag.to_owned(),
        };
        let value = node.attribute(attribute).map_or("absent".to_owned(), |value| format!("\"{value}\""));
        let (file, line, attribute) = (self.file.into(), self.line(node), attribute.to_owned());
        MapError::Value { file, line, element, attribute, value, allowed }
    }

    fn text<'n>(&self, node: Node<'n, 'input>, attribute: &str) -> Result<&'n str, MapError> {
        node.attribute(attribute).ok_or_else(|| self.value(node, attribute, "a name"))
    }

    fn positive(&self, node: Node, attribute: &str, default: Option<f64>) -> Result<f64, MapError> {
        let number = match (node.attribute(attribute), default) {
            (Some(text), _) => text.trim().parse().ok(),
            (None, default) => default,
        };
        number
            .filter(|x: &f64| x.is_finite() && *x > 0.0)
            .ok_or_else(|| self.value(node, attribute, "a finite number above 0"))
    }

    fn lane(&self, node: Node, edge_id: &str, edge: usize, internal: bool) -> Result<NetLane, MapError> {
        let shape = node
            .attribute("shape")
            .and_then(parse_shape)
            // netconvert writes the inside of a junction of no size as one point twice; `route_of` gives it an extent.
            .filter(|shape| shape.len() > 1 && (internal || shape.iter().any(|point| *point != shape[0])))
            .ok_or_else(|| {
                self.value(
                    node,
                    "shape",
                    "two or more different points \"x,y\" or \"x,y,z\" of finite numbers, in metres",
                )
            })?;
        let lane = Lane {
            id: self.text(node, "id")?.to_owned(),
            edge: edge_id.to_owned(),
            start_s_m: 0.0,
            length_m: self.positive(node, "length", None)?,
            speed_limit_mps: self.positive(node, "speed", None)?,
            width_m: self.positive(node, "width", Some(DEFAULT_WIDTH_M))?,
            shape,
        };
        Ok(NetLane { lane, edge, passenger: admits_passenger_cars(node) })
    }

    /// The lane that `connection` names by edge and index; `None` if it is no lane for cars.
    fn lane_of(
        &self,
        node: Node,
        edge_attribute: &str,
        lane_attribute: &str,
        edge_of_id: &BTreeMap<&str, Option<usize>>,
        edges: &[Edge],
    ) -> Result<Option<usize>, MapError> {
        let Some(edge) = edge_of_id.get(self.text(node, edge_attribute)?) else {
            return Err(self.value(node, edge_attribute, "the id of an edge of this network"));
        };
        let Some(edge) = *edge else { return Ok(None) };
        let index: Option<usize> = node.attribute(lane_attribute).and_then(|text| text.parse().ok());
        let lanes = &edges[edge].lanes;
        match index.filter(|index| *index < lanes.len()) {
            Some(index) => Ok(Some(lanes.start + index)),
            None => Err(self.value(node, lane_attribute, "the index of a lane of that edge, the right-most being 0")),
        }
    }
}

fn parse_shape(text: &str) -> Option<Vec<DVec2>> {
    text.split_whitespace()
        .map(|point| {
            let numbers: Option<Vec<f64>> =
                point.split(',').map(|x| x.parse().ok().filter(|x: &f64| x.is_finite())).collect();
            match numbers.as_deref() {
                Some([x, y] | [x, y, _]) => Some(dvec2(*x, *y)),
                _ => None,
            }
        })
        .collect()
}

/// SUMO's rule: `allow` lists the classes that may, else `disallow` those that may not, else all may.
fn admits_passenger_cars(node: Node) -> bool {
    let names = |list: &str, class: &str| list.split_whitespace().any(|word| word == class || word == "all");
    match (node.attribute("allow"), node.attribute("disallow")) {
        (Some(allow), _) if !allow.trim().is_empty() => names(allow, "passenger"),
        (_, Some(disallow)) => !names(disallow, "passenger"),
        _ => true,
    }
}
