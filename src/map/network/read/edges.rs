//! Edges and lanes of a net.xml. In: an `<edge>`. Out: the edge and its lanes, appended to the network's lists.

use super::{Names, words_but};
use crate::map::{
    MapError,
    limits::{LENGTH_M, MOST_POINTS_IN_ALL, SPEED_MPS, WIDTH_M},
    network::{
        CentreLine, Edge, EdgeId, EdgeKind, Junction, JunctionId, JunctionKind, Lane, LaneId, LaneSpread, Network,
        VehicleClasses,
    },
    xml_tree::Element,
};
use glam::{DVec2, DVec3};

/// Width of a lane for which the file states none, metres (SUMO's default).
pub(in crate::map::network) const DEFAULT_WIDTH_M: f64 = 3.2;

const LENGTH_ALLOWED: &str = "a number from 0.001 to 100000 m";

impl<'r> Names<'r> {
    /// Appends an edge and its lanes to the lists. `points` counts the points of all shapes.
    pub fn edge(&mut self, net: &mut Network, node: Element<'r>, points: &mut usize) -> Result<(), MapError> {
        let reader = self.reader;
        let id = reader.text(node, "id")?;
        let kind = node.attribute("function").map_or(Some(EdgeKind::Normal), EdgeKind::from_name);
        let kind = kind.ok_or_else(|| reader.value(node, "function", "a function of SUMO's edges"))?;
        let edge = EdgeId::from_index(net.edges.len());
        let first = net.lanes.len();
        for lane_node in node.children_named("lane") {
            let lane = self.lane(lane_node, edge, kind)?;
            *points += lane.shape().len();
            if *points > MOST_POINTS_IN_ALL {
                return Err(reader.value(lane_node, "shape", "at most a million points in all lanes together"));
            }
            self.lanes.insert(reader.text(lane_node, "id")?, LaneId::from_index(net.lanes.len()));
            net.lanes.push(lane);
        }
        // Names of edges at junction n: ":n_0" internal, ":n_c0" crossing, ":n_w0" walking area.
        let around = id.strip_prefix(':').and_then(|rest| rest.rsplit_once('_')).map(|(junction, _)| junction);
        let ends = kind.is_street();
        let last = net.lanes.len() - 1;
        let from = self.end(net, node.attribute("from").filter(|_| ends), first, false);
        let to = self.end(net, node.attribute("to").filter(|_| ends), last, true);
        let text = |attribute: &str| node.attribute(attribute).map(str::to_owned);
        let spread = node.attribute("spreadType").map_or(Some(LaneSpread::Right), LaneSpread::from_name);
        let edge = Edge {
            id: id.to_owned(),
            kind,
            from,
            to,
            junction: around.filter(|_| !ends).and_then(|junction| self.junctions.get(junction)).copied(),
            lanes: first as u32..net.lanes.len() as u32,
            name: text("name"),
            road_type: text("type"),
            priority: node.attribute("priority").and_then(|text| text.trim().parse().ok()),
            spread: spread.ok_or_else(|| reader.value(node, "spreadType", "right, center or roadCenter"))?,
            shape: if node.has_attribute("shape") { reader.shape(node, 2)? } else { Vec::new() },
            length_m: reader.within_if_any(node, "length", &LENGTH_M, LENGTH_ALLOWED)?,
            distance_m: reader.within_if_any(node, "distance", &(-1e7..=1e7), "a number from -1e7 to 1e7 m")?,
            bidi: None,
            crosses: Vec::new(),
        };
        *points += edge.shape.len();
        net.edges.push(edge);
        Ok(())
    }

    /// Returns the junction at the start or end of an edge. A junction that the file lacks is created at that end of the lane: in
    /// networks without junctions, these names define which edges meet.
    fn end(&mut self, net: &mut Network, name: Option<&'r str>, lane: usize, at_end: bool) -> Option<JunctionId> {
        let name = name?;
        if let Some(known) = self.junctions.get(name) {
            return Some(*known);
        }
        let id = JunctionId::from_index(net.junctions.len());
        let points = net.lanes[lane].line.points();
        let position = if at_end { points[points.len() - 1] } else { points[0] };
        net.junctions.push(Junction::new(name.to_owned(), JunctionKind::Unknown, position, false));
        self.junctions.insert(name, id);
        Some(id)
    }

    /// Resolves the references of an edge to other edges and lanes, once all are read.
    pub fn references_of_edge(&self, net: &mut Network, node: Element<'r>) -> Result<(), MapError> {
        let reader = self.reader;
        let Some(edge) = self.edges.get(reader.text(node, "id")?).copied() else { return Ok(()) };
        if let Some(bidi) = node.attribute("bidi") {
            let known = self.edges.get(bidi).copied();
            net.edges[edge.index()].bidi =
                Some(known.ok_or_else(|| reader.value(node, "bidi", "the id of an edge of this network"))?);
        }
        if node.has_attribute("crossingEdges") {
            net.edges[edge.index()].crosses =
                self.listed(node, "crossingEdges", &self.edges, "ids of edges of this network")?;
        }
        let first = net.edges[edge.index()].lanes.start as usize;
        for (k, lane) in node.children_named("lane").enumerate() {
            // "<neigh lane=".."/>"; SUMO uses the first only.
            let Some(neigh) = lane.children_named("neigh").next() else { continue };
            let opposite = self.lanes.get(neigh.attribute("lane").unwrap_or_default()).copied();
            net.lanes[first + k].opposite =
                Some(opposite.ok_or_else(|| reader.value(neigh, "lane", "the id of a lane of this network"))?);
        }
        Ok(())
    }

    fn lane(&self, node: Element<'r>, edge: EdgeId, kind: EdgeKind) -> Result<Lane, MapError> {
        let reader = self.reader;
        let shape = reader.shape(node, if kind == EdgeKind::WalkingArea { 1 } else { 2 })?;
        // netconvert writes an internal lane of a junction without extent as one point twice.
        if kind.is_street() && shape.iter().all(|point| point.truncate() == shape[0].truncate()) {
            return Err(reader.value(node, "shape", "two or more different points \"x,y\" or \"x,y,z\""));
        }
        let length_m = reader.within(node, "length", &LENGTH_M, LENGTH_ALLOWED)?;
        let line = CentreLine::new(&shape, length_m, DVec2::X);
        let drawn: Option<Box<[DVec3]>> = (line.points() != shape).then(|| shape.into());
        let may_change = |attribute: &str| self.classes(node, attribute).unwrap_or(VehicleClasses::ALL);
        Ok(Lane {
            id: reader.text(node, "id")?.to_owned(),
            edge,
            length_m,
            speed_limit_mps: reader.within(node, "speed", &SPEED_MPS, "a number from 0.01 to 500 m/s")?,
            width_m: reader
                .within_if_any(node, "width", &WIDTH_M, "a number from 0.001 to 100 m")?
                .unwrap_or(DEFAULT_WIDTH_M),
            line,
            drawn,
            permissions: self.permissions(node).unwrap_or(VehicleClasses::ALL),
            change_left: may_change("changeLeft"),
            change_right: may_change("changeRight"),
            opposite: None,
            end_offset_m: reader
                .within_if_any(node, "endOffset", &(0.0..=1e5), "a number from 0 to 100000 m")?
                .unwrap_or(0.0),
            acceleration: reader.truth(node, "acceleration", false)?,
            custom_shape: reader.truth(node, "customShape", false)?,
            lane_type: node.attribute("type").map(str::to_owned),
            outline: match node.attribute("outlineShape") {
                Some(text) if !text.trim().is_empty() => reader.shape_of(node, "outlineShape", 1)?,
                _ => Vec::new(),
            },
            friction: reader.within_if_any(node, "friction", &(0.0..=10.0), "a number from 0 to 10")?,
        })
    }

    /// Returns a list of classes; `None` if the attribute is absent or empty, as in SUMO.
    pub fn classes(&self, node: Element, attribute: &str) -> Option<VehicleClasses> {
        node.attribute(attribute).filter(|list| !list.trim().is_empty()).map(VehicleClasses::parse)
    }

    /// Returns the permissions by SUMO's rule: `allow` lists the permitted classes, else `disallow` the excluded ones; `None` if both are
    /// absent.
    pub fn permissions(&self, node: Element) -> Option<VehicleClasses> {
        let refused = || self.classes(node, "disallow").map(|refused| VehicleClasses::ALL.without(refused));
        self.classes(node, "allow").or_else(refused)
    }

    /// Returns the attributes of an element that are not in `known`, as name and value.
    pub fn others(&self, node: Element, known: &[&str]) -> Vec<(String, String)> {
        words_but(node, known)
    }
}
