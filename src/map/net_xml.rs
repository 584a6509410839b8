//! SUMO's network file as data. In: the text of a `net.xml`. Out: a [`RoadNetwork`]: edges, lanes and the links between lanes, in
//! the order of the file, every number checked. Metres, m/s; heights (z) are left out: the world is flat.

use super::{
    MapError, RouteLane,
    limits::{self, FURTHEST_M, LENGTH_M, MOST_POINTS, MOST_POINTS_IN_ALL, SPEED_MPS, WIDTH_M},
    net_check,
};
use glam::{DVec2, dvec2};
use roxmltree::{Document, Node};
use std::{
    collections::BTreeMap,
    ops::{Range, RangeInclusive},
    path::Path,
};

/// Width of a lane that states none, metres (SUMO's default).
const DEFAULT_WIDTH_M: f64 = 3.2;

/// A network: lanes are named by their index in `lanes`, edges by theirs in `edges`.
#[derive(Debug)]
pub(super) struct RoadNetwork {
    pub edges: Vec<NetworkEdge>,
    pub lanes: Vec<NetLane>,
    pub links: Vec<Connection>,
    /// Indices of the links from each lane, in the order of the file.
    links_of: Vec<Vec<usize>>,
}

#[derive(Debug)]
pub(super) struct NetworkEdge {
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
    pub lane: RouteLane,
    /// Its edge.
    pub edge: usize,
    /// Open to passenger cars.
    pub passenger: bool,
}

/// A way from one lane to the next.
#[derive(Debug)]
pub(super) struct Connection {
    pub from: usize,
    pub to: usize,
    /// First lane on the junction's inside, if the network has insides.
    pub via: Option<usize>,
    /// A turn on the spot, back to where one came from.
    pub turnaround: bool,
}

impl RoadNetwork {
    /// Reads the text of `file`, which is named in errors only.
    pub fn parse(file: &Path, text: &str) -> Result<Self, MapError> {
        let document = limits::parse(file, text)?;
        let root = document.root_element();
        let reader = NetReader { file, document: &document };
        if root.tag_name().name() != "net" {
            let (line, found) = (reader.line(root), root.tag_name().name().to_owned());
            return Err(MapError::NotANet { file: file.into(), line, found });
        }
        net_check::check(&reader, root)?;
        let mut net = Self { edges: Vec::new(), lanes: Vec::new(), links: Vec::new(), links_of: Vec::new() };
        let mut points = 0;
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
                let lane = reader.lane(lane_node, id, net.edges.len(), internal)?;
                points += lane.lane.shape.len();
                if points > MOST_POINTS_IN_ALL {
                    return Err(reader.value(lane_node, "shape", "at most a million points in all lanes together"));
                }
                net.lanes.push(lane);
            }
            edge_of_id.insert(id, Some(net.edges.len()));
            net.edges.push(NetworkEdge { id: id.to_owned(), internal, to_junction, lanes: first..net.lanes.len() });
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
                net.links.push(Connection { from, to, via, turnaround: node.attribute("dir") == Some("t") });
            }
        }
        net.links_of = vec![Vec::new(); net.lanes.len()];
        for (k, link) in net.links.iter().enumerate() {
            net.links_of[link.from].push(k);
        }
        Ok(net)
    }

    /// The first link between two lanes.
    pub fn link(&self, from: usize, to: usize) -> Option<&Connection> {
        self.links_of[from].iter().map(|&k| &self.links[k]).find(|link| link.to == to)
    }
}

pub(super) struct NetReader<'a, 'input> {
    file: &'a Path,
    document: &'a Document<'input>,
}

impl<'input> NetReader<'_, 'input> {
    /// Counts lines from the start of the file, so it is called for errors only.
    fn line(&self, node: Node) -> u32 {
        self.document.text_pos_at(node.range().start).row
    }

    pub fn value(&self, node: Node, attribute: &str, allowed: &'static str) -> MapError {
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

    pub fn text<'n>(&self, node: Node<'n, 'input>, attribute: &str) -> Result<&'n str, MapError> {
        node.attribute(attribute).ok_or_else(|| self.value(node, attribute, "a name"))
    }

    /// A number within limits, which `allowed` says in words.
    pub fn within(
        &self,
        node: Node,
        attribute: &str,
        limits: &RangeInclusive<f64>,
        allowed: &'static str,
    ) -> Result<f64, MapError> {
        let number = node.attribute(attribute).and_then(|text| text.trim().parse().ok());
        number.filter(|x| limits.contains(x)).ok_or_else(|| self.value(node, attribute, allowed))
    }

    pub fn coordinate(&self, node: Node, attribute: &str) -> Result<f64, MapError> {
        self.within(node, attribute, &(-FURTHEST_M..=FURTHEST_M), "a number from -1e7 to 1e7 m")
    }

    /// The points of a shape, at least `least`.
    pub fn shape(&self, node: Node, least: usize) -> Result<Vec<DVec2>, MapError> {
        let points = node.attribute("shape").and_then(parse_shape);
        points.filter(|points| points.len() >= least).ok_or_else(|| {
            self.value(
                node,
                "shape",
                "two or more different points \"x,y\" or \"x,y,z\" of numbers from -1e7 to 1e7, in metres, at most 20000",
            )
        })
    }

    fn lane(&self, node: Node, edge_id: &str, edge: usize, internal: bool) -> Result<NetLane, MapError> {
        let shape = self.shape(node, 2)?;
        // netconvert writes the inside of a junction of no size as one point twice; `route_of` gives it an extent.
        if !internal && shape.iter().all(|point| *point == shape[0]) {
            return Err(self.value(node, "shape", "two or more different points \"x,y\" or \"x,y,z\""));
        }
        let width_m = match node.has_attribute("width") {
            true => self.within(node, "width", &WIDTH_M, "a number from 0.1 to 100 m")?,
            false => DEFAULT_WIDTH_M,
        };
        let lane = RouteLane {
            id: self.text(node, "id")?.to_owned(),
            edge: edge_id.to_owned(),
            start_s_m: 0.0,
            length_m: self.within(node, "length", &LENGTH_M, "a number from 0.001 to 100000 m")?,
            speed_limit_mps: self.within(node, "speed", &SPEED_MPS, "a number from 0.01 to 500 m/s")?,
            width_m,
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
        edges: &[NetworkEdge],
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

/// Points, if there are not too many and all numbers are within limits. One that lies within a micrometre of the one before
/// is taken for the same: the square of a smaller distance may be nothing.
fn parse_shape(text: &str) -> Option<Vec<DVec2>> {
    const SAME_M: f64 = 1e-6;
    let mut points: Vec<DVec2> = Vec::new();
    for point in text.split_whitespace() {
        let mut numbers = point.split(',').map(|x| x.parse().ok().filter(|x: &f64| x.abs() <= FURTHEST_M));
        let (x, y, z) = (numbers.next()??, numbers.next()??, numbers.next());
        if numbers.next().is_some() || z == Some(None) || points.len() == MOST_POINTS {
            return None;
        }
        let point = dvec2(x, y);
        points.push(points.last().copied().filter(|last| last.distance(point) < SAME_M).unwrap_or(point));
    }
    Some(points)
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
