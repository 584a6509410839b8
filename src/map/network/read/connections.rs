//! Connections of a net.xml. In: a `<connection>`. Out: its two lanes, the internal lane between them, right of way and signal.

use super::Names;
use crate::map::{
    MapError,
    limits::{LENGTH_M, SPEED_MPS},
    network::{Connection, ConnectionOptions, LaneId, LinkState, Network, SignalLink, TurnDirection},
    xml_tree::Element,
};

impl<'r> Names<'r> {
    pub fn connection(&self, node: Element<'r>, net: &Network) -> Result<Connection, MapError> {
        let reader = self.reader;
        let direction = node.attribute("dir").map_or(Some(TurnDirection::Unknown), TurnDirection::from_name);
        let state = node.attribute("state").map_or(Some(LinkState::Major), LinkState::from_name);
        let via = match node.attribute("via") {
            None => None,
            Some(id) => match self.lanes.get(id) {
                Some(lane) => Some(*lane),
                None => return Err(reader.value(node, "via", "the id of a lane of this network")),
            },
        };
        let options = self.options(node)?;
        Ok(Connection {
            from: self.lane_of(node, "from", "fromLane", net)?,
            to: self.lane_of(node, "to", "toLane", net)?,
            via,
            direction: direction.ok_or_else(|| reader.value(node, "dir", "a direction of SUMO's connections"))?,
            state: state.ok_or_else(|| reader.value(node, "state", "a state of SUMO's connections"))?,
            signal: self.signal_link(node)?,
            link: None,
            keep_clear: reader.truth(node, "keepClear", true)?,
            options: (options != ConnectionOptions::default()).then(|| Box::new(options)),
        })
    }

    fn signal_link(&self, node: Element<'r>) -> Result<Option<SignalLink>, MapError> {
        let Some(id) = node.attribute("tl") else { return Ok(None) };
        let Some(signal) = self.signals.get(id) else {
            return Err(self.reader.value(node, "tl", "the id of a tlLogic of this network"));
        };
        let place = |attribute: &str| node.attribute(attribute).and_then(|text| text.trim().parse().ok());
        Ok(Some(SignalLink { signal: *signal, index: place("linkIndex"), second: place("linkIndex2") }))
    }

    fn options(&self, node: Element<'r>) -> Result<ConnectionOptions, MapError> {
        let reader = self.reader;
        let metres =
            |attribute: &str| reader.within_if_any(node, attribute, &(-1e5..=1e5), "a number from -100000 to 100000 m");
        Ok(ConnectionOptions {
            pass: reader.truth(node, "pass", false)?,
            uncontrolled: reader.truth(node, "uncontrolled", false)?,
            wait_at_m: metres("contPos")?,
            visibility_m: metres("visibility")?,
            speed_mps: reader.within_if_any(node, "speed", &SPEED_MPS, "a number from 0.01 to 500 m/s")?,
            length_m: reader.within_if_any(node, "length", &LENGTH_M, "a number from 0.001 to 100000 m")?,
            shape: match node.attribute("shape") {
                Some(text) if !text.trim().is_empty() => reader.shape(node, 1)?,
                _ => Vec::new(),
            },
            permissions: self.permissions(node),
            change_left: self.classes(node, "changeLeft"),
            change_right: self.classes(node, "changeRight"),
            indirect: reader.truth(node, "indirect", false)?,
        })
    }

    /// Returns the lane that the element names by edge and lane index.
    fn lane_of(
        &self,
        node: Element<'r>,
        edge_attribute: &str,
        lane_attribute: &str,
        net: &Network,
    ) -> Result<LaneId, MapError> {
        let Some(edge) = self.edges.get(self.reader.text(node, edge_attribute)?) else {
            return Err(self.reader.value(node, edge_attribute, "the id of an edge of this network"));
        };
        let index: Option<usize> = node.attribute(lane_attribute).and_then(|text| text.parse().ok());
        let lane = index.and_then(|index| net.edges[edge.index()].lanes().nth(index));
        lane.ok_or_else(|| {
            self.reader.value(node, lane_attribute, "the index of a lane of that edge, the right-most being 0")
        })
    }
}
