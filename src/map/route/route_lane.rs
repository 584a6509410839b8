//! A lane of a route. In: a lane of the network. Out: its place on the route, length, limit, width and shape on the ground plane. Metres, m/s.

use crate::map::network::{Edge, LaneId, Network};
use glam::DVec2;

/// One lane of the route.
#[derive(Clone, Debug, PartialEq)]
pub struct RouteLane {
    /// Lane of the network; `None` for a bridge over the gap between two of its lanes, as where internal lanes are missing.
    pub lane: Option<LaneId>,
    /// Position of the lane's start on the route, metres.
    pub start_s_m: f64,
    /// Declared length, metres. May differ slightly from the length of the shape.
    pub length_m: f64,
    /// Speed limit, m/s.
    pub speed_limit_mps: f64,
    /// Width of the lane, metres.
    pub width_m: f64,
    /// Centre line, world axes, at least two points.
    pub shape: Vec<DVec2>,
}

impl RouteLane {
    /// Returns true for a lane that bridges the gap between two lanes of the network.
    pub fn is_bridge(&self) -> bool {
        self.lane.is_none()
    }

    /// Returns SUMO's id of the lane, for example `e0_0`; empty for a bridge.
    pub fn id<'n>(&self, net: &'n Network) -> &'n str {
        self.lane.map_or("", |lane| &net.lane(lane).id)
    }

    /// Returns SUMO's id of the lane's edge; empty for a bridge.
    pub fn edge_id<'n>(&self, net: &'n Network) -> &'n str {
        self.edge(net).map_or("", |edge| &edge.id)
    }

    /// Returns true for a lane of a street: neither inside a junction nor a bridge.
    pub fn is_street(&self, net: &Network) -> bool {
        self.edge(net).is_some_and(|edge| edge.kind.is_street())
    }

    fn edge<'n>(&self, net: &'n Network) -> Option<&'n Edge> {
        self.lane.map(|lane| net.edge_of(lane))
    }

    /// Returns a lane of a network, projected onto the ground plane.
    pub(in crate::map) fn of(net: &Network, id: LaneId) -> Self {
        let lane = net.lane(id);
        Self {
            lane: Some(id),
            start_s_m: 0.0,
            length_m: lane.length_m,
            speed_limit_mps: lane.speed_limit_mps,
            width_m: lane.width_m,
            shape: lane.line.points().iter().map(|point| point.truncate()).collect(),
        }
    }
}
