//! Whether cars that keep their lane stay on a route. In: a map. Out: nothing, or the two lanes between which its route changes:
//! SUMO's cars of a closed route have no wish to change lanes (they are one file of traffic), and would leave it there.

use crate::{map::RoadMap, traffic::TrafficError};

/// Fails where the route goes on from a lane that the lane before does not lead to.
pub(super) fn check(map: &RoadMap) -> Result<(), TrafficError> {
    let lanes = map.route.lanes();
    let net = &map.network;
    let id = |k: usize| net.lane_named(&lanes[k % lanes.len()].id);
    let pairs = if map.route.is_closed() { lanes.len() } else { lanes.len() - 1 };
    for k in 0..pairs {
        let (Some(before), Some(after)) = (id(k), id(k + 1)) else { continue };
        if !net.successors(before).any(|next| next == after) {
            // The lane that is entered is another one of the same edge.
            let entered = net.successors(before).find(|next| net.lane(*next).edge == net.lane(after).edge);
            let from = net.lane(entered.unwrap_or(before)).id.clone();
            return Err(TrafficError::RouteChangesLanes { from, to: net.lane(after).id.clone() });
        }
    }
    Ok(())
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
        // Its edge ab is entered by the left lane, and its right lane alone leads on to bc.
        let folder = tempfile::tempdir().unwrap();
        let net = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/junctions-inside.net.xml");
        std::fs::copy(net, folder.path().join("net.xml")).unwrap();
        let map_file = "title = \"T\"\nroute = [\"ab\", \"bc\", \"cd\", \"da\"]\n";
        std::fs::write(folder.path().join("map.toml"), map_file).unwrap();
        let said = check(&RoadMap::load(folder.path().to_str().unwrap()).unwrap()).unwrap_err().to_string();
        assert!(said.contains("changes from lane \"ab_1\" to lane \"ab_0\"") && said.contains("remedy"), "{said}");
    }
}
