//! Edges of a path that names places. In: a [`Network`] and the words of a path: ids of edges or lanes, points `X,Y` of the network in
//! metres, and `...` for the quickest way between two of them. Out: the edges in driving order, or the fault with the remedy.

use super::{
    MapError, listed,
    network::{EdgeId, LaneId, LanePosition, Network},
};
use crate::toml_text::did_you_mean;
use glam::DVec3;
use petgraph::{
    algo::astar,
    graph::{DiGraph, NodeIndex},
};
use std::path::Path;

/// Word of a path that stands for the quickest way from the place before it to the place after it.
const QUICKEST_WAY: &str = "...";
/// Largest distance between a point of a path and the middle of its lane, m.
const REACH_M: f64 = 50.0;

/// Returns the words of a path that leads from each place to the next by the quickest way.
pub fn quickest_way_through(places: &[&str]) -> String {
    places.join(&format!(" {QUICKEST_WAY} "))
}

/// Returns the edges of a path in driving order; empty if it names none.
pub(super) fn edges_of(file: &Path, net: &Network, words: &[&str]) -> Result<Vec<EdgeId>, MapError> {
    let mut edges: Vec<EdgeId> = Vec::new();
    let mut is_joined = false;
    for (k, word) in words.iter().enumerate() {
        if *word == QUICKEST_WAY {
            if edges.is_empty() || is_joined || k + 1 == words.len() {
                return Err(MapError::PathJoint { file: file.into() });
            }
            is_joined = true;
            continue;
        }
        let edge = place(file, net, word)?;
        match edges.last().filter(|_| is_joined) {
            Some(&last) => edges.extend(quickest_way(file, net, last, edge)?.into_iter().skip(1)),
            None => edges.push(edge),
        }
        is_joined = false;
    }
    Ok(edges)
}

/// Returns the street that a word names: by its id, by that of one of its lanes, or by a point on it.
fn place(file: &Path, net: &Network, word: &str) -> Result<EdgeId, MapError> {
    let is_open = |edge: &EdgeId| cars_lanes(net, *edge).next().is_some();
    let named = net.edge_named(word).or_else(|| net.lane_named(word).map(|lane| net.lane(lane).edge));
    let found = named.filter(|edge| net.edge(*edge).kind.is_street());
    if let Some(edge) = found.filter(is_open) {
        return Ok(edge);
    }
    if let (None, Some(point)) = (found, point(word)) {
        return nearest(net, point).ok_or_else(|| MapError::PathPoint {
            file: file.into(),
            point: word.into(),
            reach_m: REACH_M,
        });
    }
    let streets = net.edge_ids().filter(|edge| net.edge(*edge).kind.is_street() && is_open(edge));
    let known: Vec<&str> = streets.map(|edge| net.edge(edge).id.as_str()).collect();
    let problem = if found.is_some() { "has no lane that is open to cars" } else { "does not exist" };
    let near = if found.is_some() { String::new() } else { did_you_mean(word, &known) };
    Err(MapError::PathEdge { file: file.into(), edge: word.into(), problem, near, known: listed(&known) })
}

/// Returns the lanes of an edge that are open to cars, the outermost first.
pub(super) fn cars_lanes(net: &Network, edge: EdgeId) -> impl Iterator<Item = LaneId> {
    net.edge(edge).lanes().filter(|lane| net.lane(*lane).admits_cars())
}

/// Parses a point `X,Y`.
fn point(word: &str) -> Option<DVec3> {
    let (x, y) = word.split_once(',')?;
    let point = DVec3::new(x.parse().ok()?, y.parse().ok()?, 0.0);
    point.is_finite().then_some(point)
}

/// Returns the street with the lane nearest to a point, seen from above; the first in the file among equals.
fn nearest(net: &Network, point: DVec3) -> Option<EdgeId> {
    let streets = net.edge_ids().filter(|edge| net.edge(*edge).kind.is_street());
    let lanes = streets.flat_map(|edge| cars_lanes(net, edge));
    let distance_m = |lane: LaneId| {
        let middle = LanePosition { offset_m: 0.0, ..net.place_in(lane, point) };
        net.pose(middle).position.truncate().distance(point.truncate())
    };
    let near = lanes.map(|lane| (distance_m(lane), lane)).filter(|(distance_m, _)| *distance_m <= REACH_M);
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, lane)| net.lane(lane).edge)
}

/// Returns the time over an edge at its speed limit, s, for cars.
pub(super) fn time_s(net: &Network, edge: EdgeId) -> f64 {
    let lanes = cars_lanes(net, edge).map(|lane| net.lane(lane));
    lanes.map(|lane| lane.length_m / lane.speed_limit_mps).fold(f64::INFINITY, f64::min)
}

/// Returns the ways of cars from edge to edge, each with the time over the edge that it leads to, s, and `turning_s` more where it turns
/// around. A node's index is that of its edge.
pub(super) fn streets_of_cars(net: &Network, turning_s: f64) -> DiGraph<EdgeId, f64> {
    let mut graph = DiGraph::<EdgeId, f64>::new();
    let nodes: Vec<_> = net.edge_ids().map(|edge| graph.add_node(edge)).collect();
    for edge in net.edge_ids().filter(|edge| net.edge(*edge).kind.is_street()) {
        for connection in cars_lanes(net, edge).flat_map(|lane| net.connections_from(lane)) {
            let next = net.lane(connection.to).edge;
            if net.lane(connection.to).admits_cars() && net.edge(next).kind.is_street() {
                let more_s = if connection.is_turnaround() { turning_s } else { 0.0 };
                graph.add_edge(nodes[edge.index()], nodes[next.index()], time_s(net, next) + more_s);
            }
        }
    }
    graph
}

/// Returns the edges of the quickest way between two edges of these streets, both included; `None` if no way leads there.
pub(super) fn quickest_of(graph: &DiGraph<EdgeId, f64>, from: EdgeId, to: EdgeId) -> Option<Vec<EdgeId>> {
    let [start, goal] = [from, to].map(|edge| NodeIndex::new(edge.index()));
    let (_, way) = astar(graph, start, |node| node == goal, |way| *way.weight(), |_| 0.0)?;
    Some(way.into_iter().map(|node| graph[node]).collect())
}

/// Returns the edges of the quickest way for cars from one edge to another, both included: each edge takes its length at its speed limit.
fn quickest_way(file: &Path, net: &Network, from: EdgeId, to: EdgeId) -> Result<Vec<EdgeId>, MapError> {
    let name = |edge: EdgeId| net.edge(edge).id.clone();
    let found = quickest_of(&streets_of_cars(net, 0.0), from, to);
    found.ok_or_else(|| MapError::NoWay { file: file.into(), from: name(from), to: name(to) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(net: &Network, name: &str, path: &str) -> Result<String, String> {
        let words: Vec<&str> = path.split_whitespace().collect();
        let found = edges_of(Path::new(name), net, &words).map_err(|error| error.to_string())?;
        Ok(found.iter().map(|edge| net.edge(*edge).id.as_str()).collect::<Vec<_>>().join(" "))
    }

    fn edges(name: &str, path: &str) -> Result<String, String> {
        let net = Network::load(&format!("tests/data/networks/{name}.net.xml")).expect("a network");
        found(&net, name, path)
    }

    #[test]
    fn the_quickest_way_is_that_of_sumo() {
        // By sumolib's getOptimalPath(fastest=True, vClass="passenger") of SUMO 1.28.
        assert_eq!(edges("random-8", "77 ... -40"), Ok("77 -77 -26 -3 23 74 -40".into()));
        assert_eq!(edges("town", "eend ... wn"), Ok("eend ende ec cw wn".into()));
        assert_eq!(edges("town", "eend ... cs ... cw"), Ok("eend ende ec cs sc cw".into()));
        assert_eq!(edges("town", "eend ende ... wn"), Ok("eend ende ec cw wn".into()));
    }

    #[test]
    fn a_longer_way_is_taken_where_it_is_quicker() {
        // From a to d: 100 m at 5 m/s take 20 s, 200 m at 20 m/s take 10 s.
        let edge = |id: &str, y: f64, length_m: f64, speed_mps: f64| {
            format!(
                "<edge id=\"{id}\"><lane id=\"{id}_0\" index=\"0\" speed=\"{speed_mps}\" length=\"{length_m}\" \
                 shape=\"0,{y} {length_m},{y}\"/></edge>"
            )
        };
        let streets = [
            edge("a", 0.0, 50.0, 10.0),
            edge("b", 10.0, 100.0, 5.0),
            edge("c", 20.0, 200.0, 20.0),
            edge("d", 30.0, 50.0, 10.0),
        ];
        let ways = [("a", "b"), ("b", "d"), ("a", "c"), ("c", "d")]
            .map(|(from, to)| format!("<connection from=\"{from}\" to=\"{to}\" fromLane=\"0\" toLane=\"0\"/>"));
        let text = format!("<net>{}{}</net>", streets.concat(), ways.concat());
        let net = Network::read(Path::new("t.net.xml"), &text).expect("a network");
        assert_eq!(found(&net, "t", "a ... d"), Ok("a c d".into()));
        let back = "t: path: no way for cars leads from edge \"d\" to edge \"a\"";
        assert_eq!(found(&net, "t", "d ... a"), Err(back.into()));
    }

    #[test]
    fn a_place_is_an_edge_a_lane_or_the_nearest_point() {
        assert_eq!(edges("town", "ec_0 cw_0"), Ok("ec cw".into()));
        // Two metres beside `ec`, which runs along y = 124.8 from x = 232.8 to 127.28.
        assert_eq!(edges("town", "180,126.8 ... 60,122"), Ok("ec cw".into()));
        let far = edges("town", "180,900").unwrap_err();
        assert!(far.starts_with("town: path: no street for cars is within 50 m of the point 180,900"), "{far}");
        for path in ["...", "... ec", "ec ...", "ec ... ... cw"] {
            assert!(edges("town", path).unwrap_err().contains("`...` stands between two places"), "{path}");
        }
    }
}
