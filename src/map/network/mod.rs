//! Road network: edges, lanes, junctions, connections and signals of a SUMO `net.xml`, with `lane <-> world` on every lane. In: the
//! file's text. Out: a [`Network`], immutable once read and shared behind an [`Arc`](std::sync::Arc); its parts are referred to by index.
//! Metres, m/s, seconds; world axes as in [`crate::space`], heights included.
//!
//! `read` reads a network and `write` writes it; `part` cuts a piece out of it. `edge`, `junction`, `connection` and `signal` are its data;
//! `signal_states` holds what its signals show. `centre_line` is the geometry of a lane; `grid` and `locate` find the lane at a point. `marking`
//! derives the markings between them, `gore` the paved wedges between roads that part or meet, and `census` counts the parts of a network.

mod census;
mod centre_line;
mod connection;
mod derive;
mod edge;
mod gore;
mod grid;
mod ids;
mod junction;
mod locate;
mod marking;
mod named_enum;
mod part;
mod read;
mod signal;
mod signal_states;
#[cfg(test)]
mod tests;
mod vehicle_classes;

pub use census::NetworkCensus;
pub use centre_line::CentreLine;
pub(super) use centre_line::rounded_m;
pub use connection::{Connection, ConnectionOptions, LinkState, SignalLink, TurnDirection};
pub use edge::{Edge, EdgeKind, Lane, LaneSpread};
pub use gore::Gore;
pub use ids::{ConnectionId, EdgeId, JunctionId, LaneId, SignalId};
pub use junction::{Junction, JunctionKind, LinkRule, LinkSet, Roundabout};
pub use locate::REACH_M;
pub use marking::Marking;
pub use signal::{ProgramKind, Signal, SignalLight, SignalPhase, SignalProgram};
pub use signal_states::SignalStates;
pub use vehicle_classes::VehicleClasses;

use super::{SumoText, surroundings::Surroundings};
use crate::space::Pose3;
use glam::DVec3;
use grid::SegmentGrid;

/// Position in a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LanePosition {
    pub lane: LaneId,
    /// Declared metres from the lane's start.
    pub s_m: f64,
    /// Metres from the centre line, positive to the left.
    pub offset_m: f64,
}

/// Side of a lane, seen in its direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    Left,
    Right,
}

/// Road network, immutable once read.
///
/// # Examples
///
/// ```
/// # extern crate codrive_core as codrive;
/// use codrive::map::network::{LanePosition, Network};
///
/// let network = Network::load("ring-250")?;
/// assert_eq!((network.edges().len(), network.lanes().len()), (4, 4));
/// let lane = network.lane_named("e0_0").expect("a lane of this file");
/// assert_eq!(network.lane(lane).length_m, 62.5);
/// // A pose 10 m along the lane, on its centre line; and from the pose back to the lane.
/// let at = LanePosition { lane, s_m: 10.0, offset_m: 0.0 };
/// let pose = network.pose(at);
/// let found = network.locate_pose(&pose, None).expect("a lane is there");
/// assert!(found.lane == lane && (found.s_m - 10.0).abs() < 0.01 && found.offset_m.abs() < 0.01);
/// # Ok::<(), codrive::map::MapError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Network {
    edges: Vec<Edge>,
    lanes: Vec<Lane>,
    junctions: Vec<Junction>,
    /// Connections sorted by the lane that they leave.
    connections: Vec<Connection>,
    signals: Vec<Signal>,
    roundabouts: Vec<Roundabout>,
    /// Attributes of the file's root and of its `<location>`, as name and value.
    header: Vec<(String, String)>,
    location: Vec<(String, String)>,
    left_hand: bool,
    /// All lanes have one height.
    level: bool,
    sumo: SumoText,
    /// Index in `connections` of the first connection of each lane; one more entry at the end.
    outgoing: Vec<u32>,
    /// Lanes that lead into each lane, grouped by that lane; `incoming_starts` holds the start of each group.
    incoming: Vec<LaneId>,
    incoming_starts: Vec<u32>,
    /// Lanes and edges in the order of their ids, for lookup by id.
    lanes_by_id: Vec<LaneId>,
    edges_by_id: Vec<EdgeId>,
    grid: SegmentGrid,
    gores: Vec<Gore>,
    surroundings: Surroundings,
}

impl Network {
    /// Returns all edges, in the order of the file, internal edges included.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Returns all lanes, in the order of the file.
    pub fn lanes(&self) -> &[Lane] {
        &self.lanes
    }

    /// Returns the buildings, land and trees beside the network; empty if its map states none.
    pub fn surroundings(&self) -> &Surroundings {
        &self.surroundings
    }

    /// Returns all junctions, in the order of the file.
    pub fn junctions(&self) -> &[Junction] {
        &self.junctions
    }

    /// Returns all connections, sorted by the lane that they leave.
    pub fn connections(&self) -> &[Connection] {
        &self.connections
    }

    /// Returns all signals, by index.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// Returns all roundabouts of the file.
    pub fn roundabouts(&self) -> &[Roundabout] {
        &self.roundabouts
    }

    /// Returns all paved wedges between roads that part or meet.
    pub fn gores(&self) -> &[Gore] {
        &self.gores
    }

    /// Returns the network's text as SUMO reads it, after the checks of [`SumoText`].
    pub fn sumo_text(&self) -> &SumoText {
        &self.sumo
    }

    /// Returns true if traffic keeps to the left.
    pub fn is_left_hand(&self) -> bool {
        self.left_hand
    }

    /// Returns true if all lanes have one height.
    pub fn is_level(&self) -> bool {
        self.level
    }

    /// Returns the edge of an id.
    pub fn edge(&self, id: EdgeId) -> &Edge {
        &self.edges[id.index()]
    }

    /// Returns the lane of an id.
    pub fn lane(&self, id: LaneId) -> &Lane {
        &self.lanes[id.index()]
    }

    /// Returns the junction of an id.
    pub fn junction(&self, id: JunctionId) -> &Junction {
        &self.junctions[id.index()]
    }

    /// Returns the connection of an id.
    pub fn connection(&self, id: ConnectionId) -> &Connection {
        &self.connections[id.index()]
    }

    /// Returns the signal of an id.
    pub fn signal(&self, id: SignalId) -> &Signal {
        &self.signals[id.index()]
    }

    /// Returns the ids of all lanes.
    pub fn lane_ids(&self) -> impl ExactSizeIterator<Item = LaneId> {
        (0..self.lanes.len()).map(LaneId::from_index)
    }

    /// Returns the ids of all edges.
    pub fn edge_ids(&self) -> impl ExactSizeIterator<Item = EdgeId> {
        (0..self.edges.len()).map(EdgeId::from_index)
    }

    /// Returns the lane with a SUMO id.
    pub fn lane_named(&self, id: &str) -> Option<LaneId> {
        let found = self.lanes_by_id.binary_search_by_key(&id, |lane| &self.lane(*lane).id);
        found.ok().map(|k| self.lanes_by_id[k])
    }

    /// Returns the edge with a SUMO id.
    pub fn edge_named(&self, id: &str) -> Option<EdgeId> {
        let found = self.edges_by_id.binary_search_by_key(&id, |edge| &self.edge(*edge).id);
        found.ok().map(|k| self.edges_by_id[k])
    }

    /// Returns the edge that a lane belongs to.
    pub fn edge_of(&self, lane: LaneId) -> &Edge {
        self.edge(self.lane(lane).edge)
    }

    /// Returns the connections that leave a lane, in the order of the file; none at the end of a road.
    pub fn connections_from(&self, lane: LaneId) -> &[Connection] {
        let k = lane.index();
        &self.connections[self.outgoing[k] as usize..self.outgoing[k + 1] as usize]
    }

    /// Returns the lanes that directly follow a lane: internal lanes, or the lanes beyond the junction if it has none.
    pub fn successors(&self, lane: LaneId) -> impl ExactSizeIterator<Item = LaneId> {
        self.connections_from(lane).iter().map(Connection::next)
    }

    /// Returns the internal lanes between two connected lanes, in driving order. netconvert makes two or three of them; internal lanes
    /// that form a loop are not followed further.
    pub fn lanes_between(&self, from: LaneId, to: LaneId) -> impl Iterator<Item = LaneId> {
        let next = move |at: LaneId| {
            let connection = self.connections_from(at).iter().find(|connection| connection.to == to);
            connection.map(Connection::next).filter(|lane| *lane != to)
        };
        std::iter::successors(next(from), move |at| next(*at)).take(16)
    }

    /// Returns the lanes that lead directly into a lane.
    pub fn predecessors(&self, lane: LaneId) -> &[LaneId] {
        let k = lane.index();
        &self.incoming[self.incoming_starts[k] as usize..self.incoming_starts[k + 1] as usize]
    }

    /// Checks whether a lane is a street's lane for road vehicles: not a footway or railway, and not inside a junction.
    pub fn is_driven(&self, lane: LaneId) -> bool {
        let of = self.lane(lane);
        self.edge_of(lane).kind.is_street() && !of.is_footway() && !of.is_railway()
    }

    /// Returns the index of a lane in its edge as SUMO counts it, 0 for the outermost lane.
    pub fn index_in_edge(&self, lane: LaneId) -> usize {
        lane.index() - self.edge_of(lane).lanes.start as usize
    }

    /// Returns the lane beside a lane in its edge; `None` at the border of the edge.
    pub fn neighbour(&self, lane: LaneId, side: Side) -> Option<LaneId> {
        let lanes = &self.edge_of(lane).lanes;
        // Lane indices count from the outside: from the right, or with left-hand traffic from the left.
        let inwards = (side == Side::Left) != self.left_hand;
        let k = lane.index() as u32;
        let beside = if inwards { k.checked_add(1) } else { k.checked_sub(1) };
        beside.filter(|k| lanes.contains(k)).map(|k| LaneId::from_index(k as usize))
    }

    /// Returns the junction that a lane leads into; for an internal lane, its own junction.
    pub fn junction_after(&self, lane: LaneId) -> Option<JunctionId> {
        let edge = self.edge_of(lane);
        edge.to.or(edge.junction)
    }

    /// Returns the pose at a position in a lane; positions beyond its ends are clamped to them.
    pub fn pose(&self, at: LanePosition) -> Pose3 {
        self.lane(at.lane).line.pose(at.s_m, at.offset_m)
    }

    /// Returns the corners of the box around all centre lines: lowest and highest coordinates, metres. Zero for a network without lanes.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let points = || self.lanes.iter().flat_map(|lane| lane.line.points());
        if points().next().is_none() {
            return (DVec3::ZERO, DVec3::ZERO);
        }
        let low = points().fold(DVec3::INFINITY, |low, point| low.min(*point));
        (low, points().fold(DVec3::NEG_INFINITY, |high, point| high.max(*point)))
    }
}
