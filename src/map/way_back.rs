//! Way back to a path that a vehicle has left. In: the edge where it is, and the edges of the path that were still to come. Out: a [`RoadMap`]
//! whose route leads back and on along the path.

use super::{
    RoadMap,
    edge_path::along_edges,
    network::{EdgeId, Network},
    path_places::{quickest_of, streets_of_cars, time_s},
};
use petgraph::{algo::dijkstra, graph::NodeIndex};
use std::sync::Arc;

/// Time by which a way round must be longer than one that turns around, s: people do not like to turn around in a junction.
const TURNING_S: f64 = 60.0;
/// Number of the path's edges that the way back goes on along, for the manoeuvres behind the place where it meets the path.
const GOES_ON: usize = 4;

impl RoadMap {
    /// Returns the road with the quickest way back as its route, from an edge beside the path to the path behind `left_s_m`, metres, and on
    /// along it; `None` if no way leads back. It meets the path where the way there, and the part of the path that it leaves out, together
    /// take the least time.
    pub fn way_back(&self, from: EdgeId, left_s_m: f64) -> Option<Self> {
        let net = &self.network;
        let (here, _) = self.route.lane_at(left_s_m);
        let lanes = self.route.lanes()[here..].iter().filter(|lane| lane.is_street(net));
        let mut to_come: Vec<EdgeId> = lanes.filter_map(|lane| Some(net.lane(lane.lane?).edge)).collect();
        to_come.dedup();
        let edges = edges_back(net, from, &to_come)?;
        let ids: Vec<&str> = edges.iter().map(|edge| net.edge(*edge).id.as_str()).collect();
        let route = along_edges(&self.net_file, net, &ids, None).ok()?;
        let Self { name, title, net_file, network, .. } = self;
        Some(Self {
            name: name.clone(),
            title: title.clone(),
            net_file: net_file.clone(),
            route,
            network: Arc::clone(network),
        })
    }
}

/// Returns the edges of the way back, and the next ones of the path.
fn edges_back(net: &Network, from: EdgeId, to_come: &[EdgeId]) -> Option<Vec<EdgeId>> {
    let graph = streets_of_cars(net, TURNING_S);
    let times_s = dijkstra(&graph, NodeIndex::new(from.index()), None, |way| *way.weight());
    let mut left_out_s = 0.0;
    let meets = to_come.iter().enumerate().filter_map(|(k, edge)| {
        let so_far_s = left_out_s;
        left_out_s += time_s(net, *edge);
        Some((times_s.get(&NodeIndex::new(edge.index()))? + so_far_s, k))
    });
    let (_, meets) = meets.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut edges = quickest_of(&graph, from, to_come[meets])?;
    edges.extend(to_come[meets + 1..].iter().take(GOES_ON));
    Some(edges)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the edges of the way back from an edge to the path, left on its first edge.
    fn back(map: &str, path: &str, from: &str) -> Option<String> {
        let words: Vec<&str> = path.split_whitespace().collect();
        let map = RoadMap::load_along(map, &words).expect("a path");
        let back = map.way_back(map.network.edge_named(from).expect("an edge"), 1.0)?;
        let lanes = back.route.lanes().iter().filter(|lane| lane.is_street(&map.network));
        let mut edges: Vec<&str> = lanes.map(|lane| lane.edge_id(&map.network)).collect();
        edges.dedup();
        Some(edges.join(" "))
    }

    #[test]
    fn a_way_back_leads_round_a_block_and_on_along_the_path() {
        // A grid of three by three nodes, A to C from west to east, 0 to 2 from south to north, with streets of much the same
        // length. Straight on at B1 instead of right: left round the north-western block.
        let grid = "tests/data/networks/grid-signals.net.xml";
        let round = "B1B2 B2A2 A2A1 A1B1 B1C1 C1C2";
        assert_eq!(back(grid, "B0B1 B1C1 C1C2", "B1B2").as_deref(), Some(round));
        // Right at B0 instead of straight on: right round the block to where the path was left, not at once to its last edge.
        let again = "B0B1 B1C1 C1C0 C0B0 B0A0 A0A1 A1B1 B1B2";
        assert_eq!(back(grid, "C0B0 B0A0 A0A1 A1B1 B1B2", "B0B1").as_deref(), Some(again));
    }

    #[test]
    fn no_way_leads_back_from_a_motorway_after_its_exit() {
        assert_eq!(back("motorway", "south entry middle exit off", "beyond"), None);
    }
}
