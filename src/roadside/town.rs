//! Streets of towns: those with kerbs, pavements and buildings. In: a network. Out: a [`Town`].
//!
//! Networks of SUMO do not say where a town is. Streets count as built up if their limit is at most that of towns and the network has a
//! junction where streets meet; a circuit without junctions has none.

use super::road_surfaces::{SurfaceCollector, points};
use crate::map::network::{EdgeId, EdgeKind, JunctionId, Network};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum speed limit of streets in towns, m/s: just above 50 km/h.
pub const TOWN_MPS: f64 = 14.0;
/// Minimum distance between a pavement's outer edge and any other road, metres. Where there is less, there is none.
pub const PAVEMENT_FREE_M: f32 = 2.0;
/// Width of the pavement beside streets whose network has none, metres, with its kerb.
pub const PAVEMENT_M: f32 = 2.4;

/// Streets of a town.
#[derive(Clone, Debug, Default)]
pub struct Town {
    streets: BTreeSet<EdgeId>,
    /// Junctions that a street leads to or from.
    junctions: BTreeSet<JunctionId>,
    /// Junctions with walking areas of the network.
    walked: BTreeSet<JunctionId>,
}

impl Town {
    /// Finds the streets of a town in a network.
    pub fn of(net: &Network) -> Self {
        let streets: BTreeSet<EdgeId> = net.edge_ids().filter(|edge| is_built_up(net, *edge)).collect();
        let mut beside: BTreeMap<JunctionId, BTreeSet<JunctionId>> = BTreeMap::new();
        for edge in &streets {
            if let (Some(from), Some(to)) = (net.edge(*edge).from, net.edge(*edge).to) {
                beside.entry(from).or_default().insert(to);
                beside.entry(to).or_default().insert(from);
            }
        }
        let streets_meet = beside.values().any(|others| others.len() >= 3);
        if !streets_meet {
            return Self::default();
        }
        let areas = net.edge_ids().map(|edge| net.edge(edge)).filter(|edge| edge.kind == EdgeKind::WalkingArea);
        let walked = areas.filter_map(|edge| edge.junction).collect();
        Self { streets, junctions: beside.into_keys().collect(), walked }
    }

    /// Checks whether an edge is a street of a town.
    pub fn has_street(&self, edge: EdgeId) -> bool {
        self.streets.contains(&edge)
    }

    /// Checks whether a street of a town leads to or from a junction.
    pub fn has_junction(&self, junction: JunctionId) -> bool {
        self.junctions.contains(&junction)
    }

    /// Checks whether a junction's corners have pavements here: those of a town, where the network has no areas for walking.
    pub fn paves_corners(&self, junction: JunctionId) -> bool {
        self.has_junction(junction) && !self.walked.contains(&junction)
    }

    /// Returns the lanes of streets and their junctions; `None` without a town.
    pub fn surfaces(&self, net: &Network) -> Option<SurfaceCollector> {
        let mut collector = SurfaceCollector::default();
        for id in net.lane_ids() {
            let (lane, edge) = (net.lane(id), net.edge_of(id));
            let is_inside = edge.kind == EdgeKind::Internal && edge.junction.is_some_and(|at| self.has_junction(at));
            if is_inside || self.has_street(lane.edge) && net.is_driven(id) {
                collector.line(&points(lane.line.points()), lane.half_width_m() as f32);
            }
        }
        (!self.streets.is_empty()).then_some(collector)
    }

    /// Checks whether a street belongs to the town's centre: it has two lanes, or leads to or from signals.
    pub fn is_centre(&self, net: &Network, edge: EdgeId) -> bool {
        let street = net.edge(edge);
        let at_signals = |end: Option<JunctionId>| end.is_some_and(|end| net.junction(end).kind.has_signals());
        at_signals(street.from)
            || at_signals(street.to)
            || street.lanes().filter(|lane| net.is_driven(*lane)).count() >= 2
    }
}

/// Checks whether cars drive on an edge, and nothing faster than in a town.
fn is_built_up(net: &Network, edge: EdgeId) -> bool {
    let driven = || net.edge(edge).lanes().filter(|lane| net.is_driven(*lane));
    driven().any(|lane| net.lane(lane).admits_cars()) && driven().all(|lane| net.lane(lane).speed_limit_mps <= TOWN_MPS)
}
