//! Counts of a network's parts. In: a network. Out: a [`NetworkCensus`], which shows people the content of a file and its dead ends and
//! islands.

use super::{EdgeKind, Network};

/// Counts of a network.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NetworkCensus {
    /// Edges from junction to junction.
    pub streets: usize,
    /// Lanes of these edges.
    pub lanes: usize,
    /// Declared length of these lanes together, metres.
    pub lanes_m: f64,
    /// Lanes of streets without a connection to another street: ends of roads.
    pub ends: usize,
    /// Internal lanes of junctions.
    pub insides: usize,
    /// Crossings of streets for pedestrians.
    pub crossings: usize,
    /// Walking areas for pedestrians.
    pub walking_areas: usize,
    /// Junctions, without internal ones.
    pub junctions: usize,
    /// Junctions with road signals.
    pub signalled: usize,
    /// Signals, railway signals included.
    pub signals: usize,
    /// Signals that control no connection: they have no effect.
    pub idle_signals: usize,
    /// Connections from street to street.
    pub connections: usize,
    /// Parts of the network that no connection joins, in either direction.
    pub islands: usize,
    /// Lowest and highest point of a centre line, metres.
    pub heights_m: (f64, f64),
}

impl NetworkCensus {
    /// Returns true if the lowest or highest point is not at height 0.
    pub fn has_heights(&self) -> bool {
        self.heights_m.0 != 0.0 || self.heights_m.1 != 0.0
    }
}

impl Network {
    /// Counts the parts of the network.
    pub fn census(&self) -> NetworkCensus {
        let (low, high) = self.bounds();
        let of_kind = |kind: EdgeKind| self.edges.iter().filter(move |edge| edge.kind == kind);
        let mut census = NetworkCensus {
            insides: of_kind(EdgeKind::Internal).map(|edge| edge.lanes().len()).sum(),
            crossings: of_kind(EdgeKind::Crossing).count(),
            walking_areas: of_kind(EdgeKind::WalkingArea).count(),
            junctions: self.junctions.iter().filter(|j| j.kind != super::JunctionKind::Internal).count(),
            signalled: self.junctions.iter().filter(|junction| junction.kind.has_signals()).count(),
            signals: self.signals.len(),
            idle_signals: self.signals.iter().filter(|signal| signal.rules_nothing()).count(),
            islands: self.islands(),
            heights_m: (low.z, high.z),
            ..NetworkCensus::default()
        };
        for lane in self.lane_ids().filter(|lane| self.edge_of(*lane).kind.is_street()) {
            census.lanes += 1;
            census.lanes_m += self.lane(lane).length_m;
            let ways = self.connections_from(lane).iter().filter(|way| self.edge_of(way.to).kind.is_street());
            let ways = ways.count();
            census.ends += usize::from(ways == 0);
            census.connections += ways;
        }
        census.streets = self.edges.iter().filter(|edge| edge.kind.is_street()).count();
        census
    }

    /// Counts the parts of the street network that no connection joins.
    fn islands(&self) -> usize {
        // Union-find: each edge points to another edge of its part; the last of the chain represents the part.
        let mut part: Vec<usize> = (0..self.edges.len()).collect();
        fn last(part: &mut [usize], mut edge: usize) -> usize {
            while part[edge] != edge {
                part[edge] = part[part[edge]];
                edge = part[edge];
            }
            edge
        }
        for connection in &self.connections {
            let (from, to) = (self.lane(connection.from).edge.index(), self.lane(connection.to).edge.index());
            let (from, to) = (last(&mut part, from), last(&mut part, to));
            part[from.max(to)] = from.min(to);
        }
        let mut seen = vec![false; self.edges.len()];
        let streets = (0..self.edges.len()).filter(|&edge| self.edges[edge].kind.is_street());
        streets.filter(|&edge| !std::mem::replace(&mut seen[last(&mut part, edge)], true)).count()
    }
}
