//! Open route along places that the user names. In: a [`Network`], and the words of a path (see `path_places`). Out: the lanes to drive, internal lanes
//! included, as an open [`Route`]; or the fault, with the remedy. Deterministic: the fewest turns that are too tight for a car, then the
//! fewest lane changes, then the outermost lanes.

use super::{
    MapError, Route, RouteLane,
    joined_shapes::{change_lanes, with_bridges},
    limits::LONGEST_ROUTE_M,
    network::{EdgeId, LaneId, Network},
    path_places::{cars_lanes, edges_of},
    tight_turns::is_too_tight,
};
use std::{collections::BTreeMap, path::Path};

/// Best way to the end from the lane on which an edge is entered.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct WayOn {
    /// Connections from here to the end that a car cannot drive within its lane.
    tight: usize,
    /// Lane changes from here to the end.
    changes: usize,
    /// Lane changes on this edge.
    changes_here: usize,
    /// Lane on which the edge is left.
    exit: LaneId,
    /// Lane on which the next edge is entered; on the last edge, the lane itself.
    next: LaneId,
}

/// Returns the route along the path `edges` of the network of `file`; it begins on the lane `begins_on` if given.
pub(super) fn along_edges(
    file: &Path,
    net: &Network,
    edges: &[&str],
    begins_on: Option<LaneId>,
) -> Result<Route, MapError> {
    let chosen = edges_of(file, net, edges)?;
    let ways = ways_on(file, net, &chosen)?;
    let first = ways.first().and_then(|lanes| {
        let allowed = lanes.iter().filter(|(lane, _)| begins_on.is_none_or(|first| first == **lane));
        allowed.min_by_key(|(lane, way)| (way.tight, way.changes, **lane))
    });
    let Some((&first, _)) = first else {
        return Err(MapError::EmptyPath { file: file.into() });
    };
    let mut lanes = Vec::new();
    let mut entered = first;
    for (k, ways) in ways.iter().enumerate() {
        let WayOn { exit, next, .. } = ways[&entered];
        lanes.push(change_lanes(&RouteLane::of(net, entered), &RouteLane::of(net, exit)));
        if k + 1 < chosen.len() {
            lanes.extend(net.lanes_between(exit, next).map(|lane| RouteLane::of(net, lane)));
        }
        entered = next;
    }
    let length_m: f64 = lanes.iter().map(|lane| lane.length_m).sum();
    if length_m > LONGEST_ROUTE_M {
        let (what, value) = ("the length of the path".into(), format!("{length_m:.0} m"));
        return Err(MapError::Limit {
            file: file.into(),
            what,
            value,
            allowed: format!("at most {LONGEST_ROUTE_M} m"),
        });
    }
    Ok(Route::open(with_bridges(lanes)).with_heights(net))
}

/// Returns, for each edge, the best way to the end from each of its lanes.
fn ways_on(file: &Path, net: &Network, chosen: &[EdgeId]) -> Result<Vec<BTreeMap<LaneId, WayOn>>, MapError> {
    let mut ways: Vec<BTreeMap<LaneId, WayOn>> = Vec::new();
    for (k, edge) in chosen.iter().enumerate().rev() {
        let here: BTreeMap<LaneId, WayOn> = match ways.last() {
            None => cars_lanes(net, *edge)
                .map(|lane| (lane, WayOn { tight: 0, changes: 0, changes_here: 0, exit: lane, next: lane }))
                .collect(),
            Some(on) => {
                let exits = cars_lanes(net, *edge).flat_map(|exit| net.connections_from(exit));
                let exits: Vec<(LaneId, LaneId, usize, usize)> = exits
                    .filter_map(|way| {
                        let beyond = on.get(&way.to)?;
                        let tight = beyond.tight + usize::from(is_too_tight(net, way));
                        Some((way.from, way.to, tight, beyond.changes))
                    })
                    .collect();
                let best = |lane: LaneId| {
                    let ways = exits.iter().map(|&(exit, next, tight, changes)| {
                        let changes_here = exit.index().abs_diff(lane.index());
                        WayOn { tight, changes: changes + changes_here, changes_here, exit, next }
                    });
                    Some((lane, ways.min()?))
                };
                cars_lanes(net, *edge).filter_map(best).collect()
            }
        };
        if here.is_empty() {
            let name = |edge: EdgeId| net.edge(edge).id.clone();
            let beyond = net.edge(*edge).lanes().flat_map(|lane| net.connections_from(lane));
            let mut onwards: Vec<&str> = beyond
                .filter(|connection| {
                    net.lane(connection.to).admits_cars() && net.edge_of(connection.to).kind.is_street()
                })
                .map(|connection| net.edge_of(connection.to).id.as_str())
                .collect();
            onwards.sort_unstable();
            onwards.dedup();
            return Err(MapError::PathGap {
                file: file.into(),
                from: name(*edge),
                to: name(chosen[k + 1]),
                onwards: super::listed(&onwards),
            });
        }
        ways.push(here);
    }
    ways.reverse();
    Ok(ways)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::RoadMap;
    use glam::DVec2;

    const GRID: &str = "tests/data/networks/grid-signals.net.xml";

    fn along(edges: &[&str]) -> Result<Route, String> {
        RoadMap::load_along(GRID, edges).map(|map| map.route).map_err(|error| error.to_string())
    }

    #[test]
    fn a_path_starts_on_the_outermost_lane_that_leads_to_its_end() {
        let net = Network::load(GRID).unwrap();
        let route = along(&["A0B0", "B0C0", "C0C1"]).unwrap();
        let ids: Vec<&str> = route.lanes().iter().map(|lane| lane.id(&net)).collect();
        let streets: Vec<&str> = ids.iter().copied().filter(|id| !id.starts_with(':')).collect();
        assert_eq!(streets.len(), 3);
        // Both lanes lead all the way. At C1 only the inner lane turns left: it is used from the start, without a lane change.
        assert_eq!(streets, ["A0B0_0", "B0C0_0", "C0C1_0"]);
        assert_eq!(along(&["A1B1", "B1C1", "C1C2"]).unwrap().lanes()[0].id(&net), "A1B1_1");
        // Unless it names another one.
        for first in ["A0B0_0", "A0B0_1"] {
            assert_eq!(along(&[first, "B0C0"]).unwrap().lanes()[0].id(&net), first);
        }
        // Each lane leads to the next by SUMO's own connections.
        for pair in route.lanes().windows(2) {
            let [from, to] = [&pair[0], &pair[1]].map(|lane| lane.lane.unwrap());
            assert!(net.successors(from).any(|next| next == to), "{ids:?}");
            assert!(pair[0].shape.last().unwrap().distance(pair[1].shape[0]) < 0.05, "{ids:?}");
        }
        assert!(!route.is_closed());
    }

    #[test]
    fn a_path_that_needs_another_lane_changes_to_it_smoothly() {
        // Right at B1, then left at C1 from the inner lane: one edge has a lane change, whichever lane is entered.
        let net = Network::load(GRID).unwrap();
        let turns = |lane: &str, to: &str| {
            net.connections_from(net.lane_named(lane).unwrap()).iter().any(|way| net.edge_of(way.to).id == to)
        };
        assert!(turns("B0B1_0", "B1C1") && !turns("B1C1_0", "C1C2") && turns("B1C1_1", "C1C2"), "what SUMO says");
        let route = along(&["B0B1", "B1C1", "C1C2"]).unwrap();
        let change = route.lanes().iter().position(|lane| lane.edge_id(&net) == "B1C1").unwrap();
        let lane = &route.lanes()[change];
        assert_eq!(lane.id(&net), "B1C1_1");
        let entered = net.lane(net.lane_named("B1C1_0").unwrap()).line.points()[0].truncate();
        let left = net.lane(net.lane_named("B1C1_1").unwrap()).line.points().last().unwrap().truncate();
        assert!(lane.shape[0].distance(entered) < 1e-9 && lane.shape.last().unwrap().distance(left) < 1e-9);
        // No corner exceeds 20 degrees.
        let sharpest = lane.shape.windows(3).map(|p| (p[1] - p[0]).angle_to(p[2] - p[1]).abs()).fold(0.0, f64::max);
        assert!(sharpest < 0.35, "{sharpest}");
        let heading: DVec2 = lane.shape[1] - lane.shape[0];
        assert!(heading.length() > 0.0);
    }

    #[test]
    fn of_several_lanes_a_path_takes_one_that_a_car_can_follow() {
        // Two lanes lead to two; the outer lane of the second edge begins `aside_m` further out, right where the first edge ends.
        let first_lane = |aside_m: f64| {
            let edge = |id: &str, lanes: [(f64, f64); 2]| {
                let lane = |k: usize, (x, y): (f64, f64)| {
                    format!(
                        "<lane id=\"{id}_{k}\" index=\"{k}\" speed=\"9\" length=\"40\" width=\"3.2\" shape=\"{x},{y} {},{y}\"/>",
                        x + 40.0
                    )
                };
                format!("<edge id=\"{id}\">{}{}</edge>", lane(0, lanes[0]), lane(1, lanes[1]))
            };
            let way = |k: usize| format!("<connection from=\"a\" to=\"b\" fromLane=\"{k}\" toLane=\"{k}\"/>");
            let (a, b) = (edge("a", [(0.0, -1.6), (0.0, 1.6)]), edge("b", [(40.0, -1.6 - aside_m), (40.0, 1.6)]));
            let text = format!("<net>{a}{b}{}{}</net>", way(0), way(1));
            let net = Network::read(Path::new("t.net.xml"), &text).unwrap();
            let route = along_edges(Path::new("t.net.xml"), &net, &["a", "b"], None).unwrap();
            let ids: Vec<String> = route.lanes().iter().map(|lane| lane.id(&net).to_owned()).collect();
            ids
        };
        assert_eq!(first_lane(0.0), ["a_0", "b_0"]);
        // A step of 3.2 m over no distance cannot be driven.
        assert_eq!(first_lane(3.2), ["a_1", "b_1"]);
    }

    #[test]
    fn an_unknown_edge_and_a_gap_in_a_path_are_named_with_the_remedy() {
        let text = along(&["A0B0", "B0C9"]).unwrap_err();
        assert!(text.contains("path: edge \"B0C9\" does not exist (did you mean B0C0?)"), "{text}");
        let text = along(&["A0B0", "B1C1"]).unwrap_err();
        assert!(text.contains("path: edge \"A0B0\" does not lead to edge \"B1C1\"") && text.contains("B0B1"), "{text}");
        assert!(text.contains("remedy"), "{text}");
        assert!(along(&[":B1_0"]).unwrap_err().contains("does not exist"));
        assert!(along(&[]).unwrap_err().contains("names no edge"));
    }
}
