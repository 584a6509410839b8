//! Data derived from a network's elements once all are read: incoming lanes, links of connections, connections of signals, directions of
//! lanes that are points, and the grid. In: a network with its lists filled. Out: the complete network.

use super::{
    CentreLine, ConnectionId, EdgeId, EdgeKind, LaneId, Network, SumoText, Surroundings, gore, grid::SegmentGrid,
};
use glam::{DVec2, DVec3};

impl Network {
    /// Fills all derived fields from the lists.
    pub(super) fn derive(&mut self) {
        self.order_ids();
        self.chain_lanes();
        self.turn_points();
        self.name_links();
        self.list_signals();
        self.grid = SegmentGrid::new(self);
        self.gores = gore::gores(self);
        let (low, high) = self.bounds();
        self.level = low.z == high.z;
    }

    /// Returns what was added to the coordinates of the file that the network was made from, metres; 0 where it does not say so.
    pub fn offset(&self) -> DVec2 {
        let text = self.location.iter().find(|(name, _)| name == "netOffset").map(|(_, value)| value.as_str());
        let numbers = text.unwrap_or_default().split(',').map(str::parse).collect::<Result<Vec<f64>, _>>();
        match numbers.as_deref() {
            Ok([x, y]) if x.is_finite() && y.is_finite() => DVec2::new(*x, *y),
            _ => DVec2::ZERO,
        }
    }

    /// Returns the network with these surroundings.
    #[must_use]
    pub fn with_surroundings(self, surroundings: Surroundings) -> Self {
        Self { surroundings, ..self }
    }

    /// Returns a copy with every coordinate shifted by `by`, metres: for the picture, which is drawn near a local origin. SUMO's text is
    /// left out.
    pub fn moved_by(&self, by: DVec3) -> Self {
        let mut moved = Self { sumo: SumoText::default(), ..self.clone() };
        let all = |points: &mut [DVec3]| points.iter_mut().for_each(|point| *point += by);
        moved.edges.iter_mut().for_each(|edge| all(&mut edge.shape));
        let ways = moved.connections.iter_mut().filter_map(|connection| connection.options.as_mut());
        ways.for_each(|options| all(&mut options.shape));
        for junction in &mut moved.junctions {
            junction.position += by;
            all(&mut junction.shape);
        }
        for lane in &mut moved.lanes {
            lane.line = lane.line.moved_by(by);
            lane.drawn.iter_mut().for_each(|drawn| all(drawn));
            all(&mut lane.outline);
        }
        moved.surroundings.move_by(by.truncate());
        moved.grid = SegmentGrid::new(&moved);
        moved.gores = gore::gores(&moved);
        moved
    }

    /// Returns a copy in which some lanes have other centre lines, with lengths in proportion: for the picture. SUMO's text is left out.
    pub fn with_lines(&self, lines: impl IntoIterator<Item = (LaneId, Vec<DVec3>)>) -> Self {
        let mut changed = Self { sumo: SumoText::default(), ..self.clone() };
        for (id, points) in lines {
            let lane = &mut changed.lanes[id.index()];
            let drawn_m: f64 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
            lane.length_m *= drawn_m / lane.line.drawn_m();
            lane.line = CentreLine::new(&points, lane.length_m, lane.line.end_direction());
            lane.drawn = None;
        }
        changed.grid = SegmentGrid::new(&changed);
        changed.gores = gore::gores(&changed);
        changed
    }

    fn order_ids(&mut self) {
        let mut lanes: Vec<LaneId> = self.lane_ids().collect();
        lanes.sort_by_key(|lane| &self.lane(*lane).id);
        let mut edges: Vec<EdgeId> = self.edge_ids().collect();
        edges.sort_by_key(|edge| &self.edge(*edge).id);
        (self.lanes_by_id, self.edges_by_id) = (lanes, edges);
    }

    fn chain_lanes(&mut self) {
        let n = self.lanes.len();
        let starts = |of: &dyn Fn(usize) -> usize| {
            let mut starts = vec![0u32; n + 1];
            (0..self.connections.len()).for_each(|k| starts[of(k) + 1] += 1);
            for lane in 0..n {
                starts[lane + 1] += starts[lane];
            }
            starts
        };
        let (outgoing, incoming_starts) =
            (starts(&|k| self.connections[k].from.index()), starts(&|k| self.connections[k].next().index()));
        let mut free = incoming_starts.clone();
        let mut incoming = vec![LaneId::from_index(0); self.connections.len()];
        for connection in &self.connections {
            let place = &mut free[connection.next().index()];
            incoming[*place as usize] = connection.from;
            *place += 1;
        }
        (self.outgoing, self.incoming, self.incoming_starts) = (outgoing, incoming, incoming_starts);
    }

    /// Gives a lane that is one point the direction of its first predecessor, or else of its first successor.
    fn turn_points(&mut self) {
        for lane in 0..self.lanes.len() {
            let id = LaneId::from_index(lane);
            let shape = self.lanes[lane].shape();
            if shape.iter().any(|point| point.truncate() != shape[0].truncate()) {
                continue;
            }
            let before = self.predecessors(id).first().map(|lane| self.lane(*lane).line.end_direction());
            let after = || self.successors(id).next().map(|lane| self.lane(lane).line.start_direction());
            let heading = before.or_else(after).unwrap_or(DVec2::X);
            let line = CentreLine::new(self.lanes[lane].shape(), self.lanes[lane].length_m, heading);
            self.lanes[lane].line = line;
        }
    }

    /// Assigns link numbers to connections. SUMO numbers the links of a junction by incoming lane, then by connection; connections onto
    /// walking areas are skipped. If that count differs from the junction's number of rules, the internal lanes identify the links.
    fn name_links(&mut self) {
        for junction in 0..self.junctions.len() {
            let n = self.junctions[junction].links.len();
            if n == 0 {
                continue;
            }
            let kind = |lane: LaneId| self.edge_of(lane).kind;
            let is_link = |k: usize| {
                let (from, to) = (kind(self.connections[k].from), kind(self.connections[k].to));
                to != EdgeKind::WalkingArea && (from != EdgeKind::WalkingArea || to == EdgeKind::Crossing)
            };
            let ways = |lane: &LaneId| self.outgoing[lane.index()] as usize..self.outgoing[lane.index() + 1] as usize;
            let counted: Vec<usize> =
                self.junctions[junction].incoming.iter().flat_map(ways).filter(|k| is_link(*k)).collect();
            let links: Vec<Option<usize>> = if counted.len() == n {
                counted.into_iter().map(Some).collect()
            } else {
                let inside = |link: usize| self.junctions[junction].inside.get(link).copied();
                let find = |link| {
                    inside(link).and_then(|lane| counted.iter().copied().find(|&k| self.connections[k].next() == lane))
                };
                (0..n).map(find).collect()
            };
            for (link, k) in links.into_iter().enumerate() {
                self.junctions[junction].links[link].connection = k.map(ConnectionId::from_index);
                if let Some(k) = k {
                    self.connections[k].link = u32::try_from(link).ok();
                }
            }
        }
    }

    fn list_signals(&mut self) {
        for signal in &mut self.signals {
            let letters =
                signal.programs.iter().filter_map(|program| program.phases.first()).map(|phase| phase.state.len());
            signal.links = vec![Vec::new(); letters.min().unwrap_or(0)];
        }
        for (k, connection) in self.connections.iter().enumerate() {
            let Some(ruled) = connection.signal else { continue };
            let signal = &mut self.signals[ruled.signal.index()];
            for link in [ruled.index, ruled.second].into_iter().flatten().map(|link| link as usize) {
                // A signal without a program, as SUMO makes it for railways, has as many links as connections name: 256 at most.
                if signal.programs.is_empty() && link >= signal.links.len() {
                    signal.links.resize(link + 1, Vec::new());
                }
                if let Some(connections) = signal.links.get_mut(link) {
                    connections.push(ConnectionId::from_index(k));
                }
            }
        }
    }
}
