//! The part of a large network that has a roadside and is drawn: the streets nearest to the ego's path. In: a network, points along the path.
//! Out: the part; none if the whole is small enough. A city of ten thousand streets would take gigabytes.

use crate::map::network::{JunctionId, Network};
use glam::DVec2;

/// Largest length of all lanes of streets that are drawn, metres: four times those of the shipped town.
const MOST_LANES_M: f64 = 150_000.0;
/// Distance between the points of a path, metres.
pub const PATH_STEP_M: f64 = 50.0;
/// Reach of what stands beside a street, metres.
const BESIDE_M: f64 = 150.0;

/// Checks whether a part of the network alone is drawn.
pub fn is_large(network: &Network) -> bool {
    lanes_m(network) > MOST_LANES_M
}

/// Returns the part of a large network near some points, or near its middle if there are none.
pub fn part_near(network: &Network, along: &[DVec2]) -> Network {
    part_up_to(network, along, MOST_LANES_M)
}

/// Returns the streets of the junctions nearest to some points, with at most this length of lanes.
fn part_up_to(network: &Network, along: &[DVec2], most_m: f64) -> Network {
    let (low, high) = network.bounds();
    let middle = [(low + high).truncate() / 2.0];
    let along = if along.is_empty() { &middle } else { along };
    let distance_m =
        |at: DVec2| along.iter().map(|point| point.distance_squared(at)).fold(f64::INFINITY, f64::min).sqrt();
    let mut lanes_m = vec![0.0; network.junctions().len()];
    for edge in network.edges().iter().filter(|edge| edge.kind.is_street()) {
        let length_m: f64 = edge.lanes().map(|lane| network.lane(lane).length_m).sum();
        for junction in [edge.from, edge.to].into_iter().flatten() {
            lanes_m[junction.index()] += length_m / 2.0;
        }
    }
    let places = network.junctions().iter().map(|junction| distance_m(junction.position.truncate()));
    let mut nearest: Vec<(f64, usize)> = places.zip(0..).collect();
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut drawn_m, mut reach_m, mut is_near) = (0.0, 0.0, vec![false; lanes_m.len()]);
    for (junction_m, junction) in nearest {
        drawn_m += lanes_m[junction];
        if drawn_m > most_m {
            break;
        }
        reach_m = junction_m;
        is_near[junction] = true;
    }
    let is_beside = |at: DVec2| distance_m(at) < reach_m + BESIDE_M;
    let surroundings = network.surroundings().within(is_beside);
    network.part(|junction: JunctionId| is_near[junction.index()]).with_surroundings(surroundings)
}

fn lanes_m(network: &Network) -> f64 {
    let streets = network.lanes().iter().filter(|lane| network.edge(lane.edge).kind.is_street());
    streets.map(|lane| lane.length_m).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{RoadMap, SHIPPED, network::JunctionKind};

    #[test]
    fn shipped_maps_are_drawn_as_a_whole() {
        for name in SHIPPED {
            let map = RoadMap::load(name).expect(name);
            assert!(!is_large(&map.network), "{name}: {} m", lanes_m(&map.network));
        }
    }

    #[test]
    fn the_nearest_junctions_are_kept_with_all_their_streets() {
        let net = Network::load("town").expect("a shipped map");
        let at = net.junctions().iter().find(|junction| junction.id == "M3").expect("in the town").position.truncate();
        let part = part_up_to(&net, &[at], lanes_m(&net) / 4.0);
        assert!(lanes_m(&part) > lanes_m(&net) / 8.0 && lanes_m(&part) < lanes_m(&net) / 2.0, "{}", lanes_m(&part));
        let streets = |net: &Network, id: &str| {
            let meets = |end: Option<JunctionId>| end.is_some_and(|junction| net.junction(junction).id == id);
            net.edges().iter().filter(|edge| edge.kind.is_street() && (meets(edge.from) || meets(edge.to))).count()
        };
        let of_roads = net.junctions().iter().filter(|junction| junction.kind != JunctionKind::Internal);
        let mut places: Vec<(f64, &str)> =
            of_roads.map(|junction| (junction.position.truncate().distance(at), junction.id.as_str())).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        // The nearest are whole, and of the farthest there is nothing.
        let (nearest, farthest) = (&places[..6], &places[places.len() - 6..]);
        assert!(nearest.iter().all(|(_, id)| streets(&part, id) == streets(&net, id)), "{nearest:?}");
        assert!(farthest.iter().all(|(_, id)| streets(&part, id) == 0 && streets(&net, id) > 0), "{farthest:?}");
    }
}
