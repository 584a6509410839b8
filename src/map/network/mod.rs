//! The road network: edges, lanes, junctions, connections and signals of a SUMO `net.xml`, with `lane <-> world` on every lane. In:
//! the file's text. Out: a [`Network`], which nothing changes any more: it is shared behind an [`Arc`](std::sync::Arc), and what it
//! holds is named by index. Metres, m/s, seconds; world axes as in [`crate::space`], heights included.
//!
//! `read` reads it; `edge`, `junction`, `connection` and `signal` are its data, `signal_states` what its signals show; `centre_line` has the geometry of a
//! lane, `grid` and `locate` find the lane at a point, `path` chains lanes, `marking` says what is painted between them and
//! `census` what a network has.

mod census;
mod centre_line;
mod connection;
mod derive;
mod edge;
mod grid;
mod ids;
mod junction;
mod locate;
mod marking;
mod path;
mod read;
mod signal;
mod signal_states;
#[cfg(test)]
mod tests;
mod vehicle_classes;
mod words;

pub use census::NetworkCensus;
pub use centre_line::CentreLine;
pub use connection::{Connection, ConnectionOptions, LinkState, SignalLink, TurnDirection};
pub use edge::{Edge, EdgeKind, Lane, LaneSpread};
pub use ids::{ConnectionId, EdgeId, JunctionId, LaneId, SignalId};
pub use junction::{Junction, JunctionKind, LinkRule, LinkSet, Roundabout};
pub use locate::REACH_M;
pub use marking::Marking;
pub use path::{Path, PathError};
pub use signal::{ProgramKind, Signal, SignalLight, SignalPhase, SignalProgram};
pub use signal_states::SignalStates;
pub use vehicle_classes::VehicleClasses;

use super::SumoText;
use crate::space::Pose3;
use glam::DVec3;
use grid::SegmentGrid;

/// A place in a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LanePosition {
    /// Which lane.
    pub lane: LaneId,
    /// Declared metres from the lane's start.
    pub s_m: f64,
    /// Metres from the centre line, positive to the left.
    pub offset_m: f64,
}

/// A side of a lane, seen in its direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// A road network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Network {
    edges: Vec<Edge>,
    lanes: Vec<Lane>,
    junctions: Vec<Junction>,
    /// Those of a lane stand together.
    connections: Vec<Connection>,
    signals: Vec<Signal>,
    roundabouts: Vec<Roundabout>,
    /// Attributes of the file's root, and of its `<location>`, as words.
    header: Vec<(String, String)>,
    location: Vec<(String, String)>,
    left_hand: bool,
    sumo: SumoText,
    /// Where the connections of each lane begin in `connections`; one more at the end.
    outgoing: Vec<u32>,
    /// Lanes that lead into each lane, and where those of each begin.
    incoming: Vec<LaneId>,
    incoming_starts: Vec<u32>,
    /// Lanes, edges and junctions in the order of their ids, for looking up.
    lanes_by_id: Vec<LaneId>,
    edges_by_id: Vec<EdgeId>,
    junctions_by_id: Vec<JunctionId>,
    grid: SegmentGrid,
}

impl Network {
    /// All edges, in the order of the file, insides of junctions included.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// All lanes, in the order of the file.
    pub fn lanes(&self) -> &[Lane] {
        &self.lanes
    }

    /// All junctions, in the order of the file.
    pub fn junctions(&self) -> &[Junction] {
        &self.junctions
    }

    /// All connections, by the lane that they leave.
    pub fn connections(&self) -> &[Connection] {
        &self.connections
    }

    /// All signals.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// All roundabouts.
    pub fn roundabouts(&self) -> &[Roundabout] {
        &self.roundabouts
    }

    /// The network as SUMO reads it: what was read, through the gate in front of SUMO.
    pub fn sumo_text(&self) -> &SumoText {
        &self.sumo
    }

    /// True where traffic keeps to the left.
    pub fn is_left_hand(&self) -> bool {
        self.left_hand
    }

    /// An edge.
    pub fn edge(&self, id: EdgeId) -> &Edge {
        &self.edges[id.index()]
    }

    /// A lane.
    pub fn lane(&self, id: LaneId) -> &Lane {
        &self.lanes[id.index()]
    }

    /// A junction.
    pub fn junction(&self, id: JunctionId) -> &Junction {
        &self.junctions[id.index()]
    }

    /// A connection.
    pub fn connection(&self, id: ConnectionId) -> &Connection {
        &self.connections[id.index()]
    }

    /// A signal.
    pub fn signal(&self, id: SignalId) -> &Signal {
        &self.signals[id.index()]
    }

    /// All ids of lanes.
    pub fn lane_ids(&self) -> impl ExactSizeIterator<Item = LaneId> {
        (0..self.lanes.len()).map(LaneId::from_index)
    }

    /// All ids of edges.
    pub fn edge_ids(&self) -> impl ExactSizeIterator<Item = EdgeId> {
        (0..self.edges.len()).map(EdgeId::from_index)
    }

    /// The lane of SUMO's id.
    pub fn lane_named(&self, id: &str) -> Option<LaneId> {
        let found = self.lanes_by_id.binary_search_by_key(&id, |lane| &self.lane(*lane).id);
        found.ok().map(|k| self.lanes_by_id[k])
    }

    /// The edge of SUMO's id.
    pub fn edge_named(&self, id: &str) -> Option<EdgeId> {
        let found = self.edges_by_id.binary_search_by_key(&id, |edge| &self.edge(*edge).id);
        found.ok().map(|k| self.edges_by_id[k])
    }

    /// The junction of SUMO's id.
    pub fn junction_named(&self, id: &str) -> Option<JunctionId> {
        let found = self.junctions_by_id.binary_search_by_key(&id, |junction| &self.junction(*junction).id);
        found.ok().map(|k| self.junctions_by_id[k])
    }

    /// The edge that a lane belongs to.
    pub fn edge_of(&self, lane: LaneId) -> &Edge {
        self.edge(self.lane(lane).edge)
    }

    /// The connections that leave a lane, in the order of the file; none at the end of a road.
    pub fn connections_from(&self, lane: LaneId) -> &[Connection] {
        let k = lane.index();
        &self.connections[self.outgoing[k] as usize..self.outgoing[k + 1] as usize]
    }

    /// The lanes that follow a lane at once: insides of junctions, or the lanes beyond where there are none.
    pub fn successors(&self, lane: LaneId) -> impl ExactSizeIterator<Item = LaneId> {
        self.connections_from(lane).iter().map(Connection::next)
    }

    /// The lanes that lead into a lane at once.
    pub fn predecessors(&self, lane: LaneId) -> &[LaneId] {
        let k = lane.index();
        &self.incoming[self.incoming_starts[k] as usize..self.incoming_starts[k + 1] as usize]
    }

    /// Place of a lane in its edge, from the outside: SUMO's index.
    pub fn index_in_edge(&self, lane: LaneId) -> usize {
        lane.index() - self.edge_of(lane).lanes.start as usize
    }

    /// The lane beside a lane in the same edge.
    pub fn neighbour(&self, lane: LaneId, side: Side) -> Option<LaneId> {
        let lanes = &self.edge_of(lane).lanes;
        // Lanes are counted from the outside, which is the right, or with left-hand traffic the left.
        let inwards = (side == Side::Left) != self.left_hand;
        let k = lane.index() as u32;
        let beside = if inwards { k.checked_add(1) } else { k.checked_sub(1) };
        beside.filter(|k| lanes.contains(k)).map(|k| LaneId::from_index(k as usize))
    }

    /// The junction that a lane leads into; for lanes inside a junction, that junction.
    pub fn junction_after(&self, lane: LaneId) -> Option<JunctionId> {
        let edge = self.edge_of(lane);
        edge.to.or(edge.junction)
    }

    /// The pose at a place in a lane; positions beyond its ends are those of the ends.
    pub fn pose(&self, at: LanePosition) -> Pose3 {
        self.lane(at.lane).line.pose(at.s_m, at.offset_m)
    }

    /// The corners of the box around all centre lines: lowest and highest coordinates, metres; zero for a network without lanes.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let points = || self.lanes.iter().flat_map(|lane| lane.line.points());
        if points().next().is_none() {
            return (DVec3::ZERO, DVec3::ZERO);
        }
        let low = points().fold(DVec3::INFINITY, |low, point| low.min(*point));
        (low, points().fold(DVec3::NEG_INFINITY, |high, point| high.max(*point)))
    }
}
