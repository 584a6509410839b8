//! Check that vehicles which keep their lane stay on a route. In: a map. Out: nothing, or the two lanes between which the route changes.
//! SUMO's vehicles on a closed route do not change lanes (they are one file of traffic), and would leave the route there. Also the lanes to
//! close so that vehicles stay on the route where a lane leads to several lanes of the next edge.

use crate::{
    map::{RoadMap, network::LaneId},
    traffic::TrafficError,
};
use std::collections::BTreeSet;

/// Checks that each lane of the route leads to the next lane of the route.
pub(super) fn check(map: &RoadMap) -> Result<(), TrafficError> {
    let lanes = map.route.lanes();
    let net = &map.network;
    let id = |k: usize| lanes[k % lanes.len()].lane;
    let pairs = if map.route.is_closed() { lanes.len() } else { lanes.len() - 1 };
    for k in 0..pairs {
        let (Some(before), Some(after)) = (id(k), id(k + 1)) else { continue };
        if !net.successors(before).any(|next| next == after) {
            // Vehicles enter another lane of the same edge.
            let entered = net.successors(before).find(|next| net.lane(*next).edge == net.lane(after).edge);
            let from = net.lane(entered.unwrap_or(before)).id.clone();
            return Err(TrafficError::RouteChangesLanes { from, to: net.lane(after).id.clone() });
        }
    }
    Ok(())
}

/// Returns the ids of the lanes beside the route to which a lane of the route also leads, in the order of the network. SUMO's vehicles know
/// the edges of their route and choose among such lanes by their own rules.
///
/// # Errors
/// The route uses such a lane elsewhere, so that it cannot be closed.
pub(super) fn lanes_beside(map: &RoadMap) -> Result<Vec<LaneId>, TrafficError> {
    let net = &map.network;
    let streets: Vec<LaneId> = map
        .route
        .lanes()
        .iter()
        .filter_map(|lane| lane.lane)
        .filter(|lane| net.edge_of(*lane).kind.is_street())
        .collect();
    let on_route: BTreeSet<LaneId> = streets.iter().copied().collect();
    let mut beside = BTreeSet::new();
    let ends = streets.first().filter(|_| map.route.is_closed());
    for (&from, &to) in streets.iter().zip(streets.iter().skip(1).chain(ends)) {
        let same_edge = |way: &LaneId| *way != to && net.lane(*way).edge == net.lane(to).edge;
        for other in net.connections_from(from).iter().map(|way| way.to).filter(same_edge) {
            if on_route.contains(&other) {
                let [from, to, other] = [from, to, other].map(|lane| net.lane(lane).id.clone());
                return Err(TrafficError::RouteForks { from, to, other });
            }
            beside.insert(other);
        }
    }
    Ok(beside.into_iter().filter(|lane| net.lane(*lane).admits_cars()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_route_that_changes_lanes_is_named_with_the_lanes_and_others_pass() {
        for name in ["ring-250", "ring-641", "practice"] {
            check(&RoadMap::load(name).unwrap()).unwrap();
        }
        // Vehicles enter edge ab on the left lane, and only its right lane leads on to bc.
        let folder = tempfile::tempdir().unwrap();
        let net = Path::new(env!("CODRIVE_ROOT")).join("tests/data/junctions-inside.net.xml");
        std::fs::copy(net, folder.path().join("net.xml")).unwrap();
        let map_file = "title = \"T\"\nroute = [\"ab\", \"bc\", \"cd\", \"da\"]\n";
        std::fs::write(folder.path().join("map.toml"), map_file).unwrap();
        let message = check(&RoadMap::load(folder.path().to_str().unwrap()).unwrap()).unwrap_err().to_string();
        assert!(
            message.contains("changes from lane \"ab_1\" to lane \"ab_0\"") && message.contains("remedy"),
            "{message}"
        );
    }

    /// Returns a map of four streets with one lane each, or two lanes for those in `two_lanes`. The streets ab and cd end in the same
    /// junction.
    fn block(two_lanes: &[&str], ways: &[(&str, u32, &str, u32)]) -> RoadMap {
        let corners = [
            ("bc", "x", "c", "95,5 95,90"),
            ("cd", "c", "x", "90,95 0,95"),
            ("da", "x", "a", "-5,90 -5,5"),
            ("ab", "a", "x", "0,0 90,0"),
        ];
        let edges: String = corners
            .iter()
            .map(|(id, from, to, shape)| {
                let lane = |k: u32| {
                    format!("<lane id=\"{id}_{k}\" index=\"{k}\" speed=\"9\" length=\"90\" shape=\"{shape}\"/>")
                };
                let lanes: String = (0..1 + u32::from(two_lanes.contains(id))).map(lane).collect();
                format!("<edge id=\"{id}\" from=\"{from}\" to=\"{to}\">{lanes}</edge>")
            })
            .collect();
        let way = |(from, lane, to, onto): &(&str, u32, &str, u32)| {
            format!("<connection from=\"{from}\" to=\"{to}\" fromLane=\"{lane}\" toLane=\"{onto}\" dir=\"s\"/>")
        };
        let ways: String = ways.iter().map(way).collect();
        let junctions =
            ["x", "c", "a"].map(|id| format!("<junction id=\"{id}\" type=\"priority\" x=\"0\" y=\"0\"/>")).concat();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("net.xml");
        std::fs::write(&file, format!("<net version=\"1.20\">{edges}{junctions}{ways}</net>")).unwrap();
        RoadMap::load(file.to_str().unwrap()).unwrap()
    }

    #[test]
    fn lanes_beside_the_route_are_found_and_one_on_the_route_is_a_fault() {
        for name in ["ring-250", "ring-641", "practice", "tests/data/networks/figure-eight.net.xml"] {
            assert!(lanes_beside(&RoadMap::load(name).unwrap()).unwrap().is_empty(), "{name}");
        }
        // bc_0 leads nowhere.
        let one = block(
            &["bc"],
            &[("ab", 0, "bc", 0), ("ab", 0, "bc", 1), ("bc", 1, "cd", 0), ("cd", 0, "da", 0), ("da", 0, "ab", 0)],
        );
        assert_eq!(lanes_beside(&one).unwrap(), [one.network.lane_named("bc_0").unwrap()]);
        // Twice round from bc_0, over one lane of each edge and then over the other; ab_0 leads to both lanes of bc.
        let twice = [
            ("ab", 0, "bc", 0),
            ("ab", 0, "bc", 1),
            ("bc", 0, "cd", 0),
            ("cd", 0, "da", 0),
            ("da", 0, "ab", 1),
            ("ab", 1, "bc", 1),
            ("bc", 1, "cd", 1),
            ("cd", 1, "da", 1),
            ("da", 1, "ab", 0),
        ];
        let message = lanes_beside(&block(&["ab", "bc", "cd", "da"], &twice)).unwrap_err().to_string();
        assert!(
            message.contains("from lane \"ab_0\" to lane \"bc_0\", and elsewhere over lane \"bc_1\"")
                && message.contains("remedy"),
            "{message}"
        );
    }
}
