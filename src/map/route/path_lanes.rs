//! The network's lanes along the ego's route. In: a [`RoadMap`]. Out: the position on the route of a vehicle in a lane, the lane of the
//! ego, the lines at signals and the yield lines. Metres.
//!
//! A vehicle is on the route if it is in a lane of the route. Where the route changes lanes on an edge, a vehicle is on the route if its
//! front is less than half a lane from the route's line.

use super::{
    guidance::PathGuidance,
    lane_changes::{LaneChange, lane_changes},
    stop_lines::{StopLine, stop_lines},
    turns::Turns,
    yield_lines::{YieldLine, yield_lines},
};
use crate::{
    map::{
        RoadMap, Route,
        network::{LaneId, LanePosition, Network},
    },
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose, Pose3},
};
use glam::DVec2;
use std::collections::BTreeMap;

/// One of the route's lanes to which a network's lane belongs.
#[derive(Clone, Copy, Debug)]
struct RouteStretch {
    /// Index of the route's lane.
    index: usize,
    /// True if a position in the lane is a position on the route: the whole lane is the route's.
    is_same: bool,
}

/// Lanes of the network along a route.
pub struct PathLanes {
    /// The network's lane of each of the route's lanes; `None` if it has none of that id.
    lanes: Vec<Option<LaneId>>,
    by_lane: BTreeMap<LaneId, Vec<RouteStretch>>,
    stop_lines: Vec<StopLine>,
}

/// Returns the one of these places of a route, metres, that is nearest to `near_s_m`.
fn nearest(route: &Route, places: impl Iterator<Item = f64>, near_s_m: f64) -> Option<f64> {
    let away_m = |s_m: f64| route.difference(near_s_m, s_m).abs();
    places.min_by(|a, b| away_m(*a).total_cmp(&away_m(*b)))
}

impl PathLanes {
    /// Returns the lanes of a map's route.
    pub fn new(map: &RoadMap) -> Self {
        let (net, route) = (&map.network, &map.route);
        let lanes: Vec<Option<LaneId>> = route.lanes().iter().map(|lane| lane.lane).collect();
        let mut by_lane: BTreeMap<LaneId, Vec<RouteStretch>> = BTreeMap::new();
        for (index, (id, lane)) in lanes.iter().zip(route.lanes()).enumerate() {
            let Some(id) = *id else { continue };
            let begins = net.lane(id).line.points()[0].truncate();
            // A lane change begins on another lane; after a bridged gap a lane begins slightly beside.
            let changes = begins.distance(lane.shape[0]) > net.lane(id).half_width_m()
                && lane.shape.iter().all(|point| point.distance(begins) > net.lane(id).half_width_m());
            for other in net.edge_of(id).lanes() {
                by_lane.entry(other).or_default().push(RouteStretch { index, is_same: other == id && !changes });
            }
        }
        Self { lanes, by_lane, stop_lines: stop_lines(map) }
    }

    /// Returns where a front bumper is along the route, metres, by its lane position and its point on the ground plane. Of several places it
    /// is the one nearest to `near_s_m`; `None` off the route.
    pub fn s_at(&self, map: &RoadMap, at: LanePosition, front: DVec2, near_s_m: f64) -> Option<f64> {
        let route = &map.route;
        let places = self.by_lane.get(&at.lane)?.iter().filter_map(|stretch| {
            let lane = &route.lanes()[stretch.index];
            let along_m = lane.start_s_m + at.s_m.min(lane.length_m);
            if stretch.is_same {
                return Some(along_m);
            }
            let found = route.project(front, Some(along_m));
            let is_near = found.offset_m.abs() < lane.width_m / 2.0 && route.lane_at(found.s_m).0 == stretch.index;
            is_near.then_some(found.s_m)
        });
        nearest(route, places, near_s_m)
    }

    /// Returns where a vehicle is along the route, metres, in any lane of one of its edges; of several places the one nearest to `near_s_m`.
    pub fn s_on_edge(&self, map: &RoadMap, at: LanePosition, near_s_m: f64) -> Option<f64> {
        let route = &map.route;
        let places = self.by_lane.get(&at.lane)?.iter().map(|stretch| {
            let lane = &route.lanes()[stretch.index];
            lane.start_s_m + at.s_m.min(lane.length_m)
        });
        nearest(route, places, near_s_m)
    }

    /// Returns the lane of the ego's front: the route's lane if the front is in it, otherwise the lane near `last` that the ego points
    /// along. `None` off all lanes. `height_m` is the road's height, `front_s_m` the front's position on the route.
    pub fn ego_lane(
        &self,
        map: &RoadMap,
        pose: &Pose,
        height_m: f64,
        front_s_m: f64,
        last: Option<LaneId>,
    ) -> Option<LanePosition> {
        let net = &map.network;
        let front = pose.front(CAR_LENGTH_M);
        let at = Pose3 { position: front.extend(height_m), yaw_rad: pose.yaw_rad, grade: 0.0 };
        let own = self.lanes[map.route.lane_at(front_s_m).0];
        let on_path = own.and_then(|own| {
            let found = net.locate(at.position, Some(own))?;
            let is_own_edge = net.lane(found.lane).edge == net.lane(own).edge;
            let road = net.pose(found);
            (is_own_edge && is_in(net, found, &road, &at) && !points_back(&road, pose)).then_some(found)
        });
        on_path.or_else(|| net.locate_pose(&at, last).filter(|found| is_in(net, *found, &net.pose(*found), &at)))
    }

    /// Returns the lane of a vehicle in a junction's area and in none of its lanes: the path's lane there, otherwise the last one. `None`
    /// off junctions.
    pub fn in_junction(&self, map: &RoadMap, front: DVec2, near_s_m: f64, last: Option<LaneId>) -> Option<LaneId> {
        let net = &map.network;
        let own = self.lanes[map.route.lane_at(map.route.project(front, Some(near_s_m)).s_m).0];
        own.into_iter().chain(last).find(|lane| {
            let edge = net.edge_of(*lane);
            let around = [edge.junction, edge.to, edge.from].into_iter().flatten();
            around.into_iter().any(|junction| net.junction(junction).covers(front))
        })
    }

    /// Returns the lines at signals, in driving order.
    pub fn stop_lines(&self) -> &[StopLine] {
        &self.stop_lines
    }

    /// Returns the yield lines, in driving order.
    pub fn yield_lines(&self, map: &RoadMap) -> Vec<YieldLine> {
        yield_lines(map, &self.lanes)
    }

    /// Returns the lane changes of the path, in driving order.
    pub fn lane_changes(&self, map: &RoadMap) -> Vec<LaneChange> {
        lane_changes(map, &self.lanes)
    }

    /// Returns the turns and lane changes of the path.
    pub fn turns(&self, map: &RoadMap, changes: &[LaneChange]) -> Turns {
        Turns::new(map, &self.lanes, changes)
    }

    /// Returns the guidance along the path.
    pub fn guidance(&self, map: &RoadMap) -> PathGuidance {
        PathGuidance::new(map, &self.lanes)
    }

    /// Returns the predecessors of the route's first edge and their predecessors.
    pub fn lanes_before(&self, net: &Network) -> Vec<LaneId> {
        let Some(first) = self.lanes.first().copied().flatten() else { return Vec::new() };
        let mut before: Vec<LaneId> =
            net.edge_of(first).lanes().flat_map(|lane| net.predecessors(lane).to_vec()).collect();
        before.extend(before.clone().into_iter().flat_map(|lane| net.predecessors(lane).to_vec()));
        before.sort_unstable();
        before.dedup();
        before
    }
}

/// Returns true if a part of the car's body is in the lane, as on a ring.
fn is_in(net: &Network, found: LanePosition, road: &Pose3, at: &Pose3) -> bool {
    let lane = net.lane(found.lane);
    let beyond_m = road.position.truncate().distance(at.position.truncate());
    found.offset_m.abs() <= (lane.width_m + CAR_WIDTH_M) / 2.0 && beyond_m < CAR_LENGTH_M
}

/// Returns true if a car heads against the direction of its lane.
pub fn is_against(net: &Network, at: LanePosition, pose: &Pose) -> bool {
    points_back(&net.pose(at), pose)
}

fn points_back(road: &Pose3, pose: &Pose) -> bool {
    (pose.yaw_rad - road.yaw_rad).cos() < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    const GRID: &str = "tests/data/networks/grid-signals.net.xml";

    /// Returns the position of a front bumper in the middle of a lane, and its point on the ground plane.
    fn front(map: &RoadMap, lane: &str, s_m: f64) -> (LanePosition, DVec2) {
        let at = LanePosition { lane: map.network.lane_named(lane).expect("a lane"), s_m, offset_m: 0.0 };
        (at, map.network.pose(at).position.truncate())
    }

    #[test]
    fn a_vehicle_is_on_the_path_in_its_lanes_and_near_its_line_in_a_change() {
        // Right at B1 from the outer lane, left at C1 from the inner one: the path changes lanes on B1C1.
        let map = RoadMap::load_along(GRID, &["B0B1", "B1C1", "C1C2"]).expect("a path");
        let lanes = PathLanes::new(&map);
        let starts = |edge: &str| {
            let lane = map.route.lanes().iter().find(|lane| lane.edge_id(&map.network) == edge).expect("on the path");
            (lane.start_s_m, lane.length_m)
        };
        let s_of = |lane: &str, s_m: f64| {
            let (at, point) = front(&map, lane, s_m);
            lanes.s_at(&map, at, point, 0.0)
        };
        assert_eq!(s_of("B0B1_0", 30.0), Some(30.0));
        assert_eq!((s_of("B0B1_1", 30.0), s_of("B1B2_0", 30.0)), (None, None));
        let (start_m, length_m) = starts("B1C1");
        let near = |found: Option<f64>, s_m: f64| found.is_some_and(|found| (found - start_m - s_m).abs() < 1.0);
        assert!(near(s_of("B1C1_0", 10.0), 10.0) && s_of("B1C1_1", 10.0).is_none(), "still in the outer lane");
        let late_m = length_m - 10.0;
        assert!(near(s_of("B1C1_1", late_m), late_m) && s_of("B1C1_0", late_m).is_none(), "in the inner one");
    }

    #[test]
    fn a_car_is_against_its_lane_if_it_heads_more_than_a_right_angle_away() {
        let map = RoadMap::load_along(GRID, &["B0B1", "B1C1"]).expect("a path");
        let net = &map.network;
        // B0B1 leads to the north.
        let at = LanePosition { lane: net.lane_named("B0B1_0").expect("a lane"), s_m: 30.0, offset_m: 0.0 };
        let heads = |degrees: f64| Pose { yaw_rad: degrees.to_radians(), ..net.pose(at).flat() };
        assert!([90.0, 2.0, 178.0, 450.0].iter().all(|degrees| !is_against(net, at, &heads(*degrees))));
        assert!([-90.0, -2.0, 182.0, 270.0].iter().all(|degrees| is_against(net, at, &heads(*degrees))));
    }

    #[test]
    fn without_internal_lanes_a_vehicle_is_on_the_path_where_it_is_drawn() {
        let map = RoadMap::load_along("tests/data/networks/random-8.net.xml", &["-54", "-3"]).expect("a path");
        let lanes = PathLanes::new(&map);
        // -54_0 has 126.07 m, and from its end to the start of -3_0 there are 32.8 m in a straight line.
        for (lane, s_m, least_m) in [("-54_0", 120.0, 120.0), ("-3_0", 10.0, 126.07 + 32.8 + 10.0)] {
            let (at, point) = front(&map, lane, s_m);
            let found_m = lanes.s_at(&map, at, point, 120.0).expect("on the path");
            assert!((least_m - 1e-6..least_m + 0.7).contains(&found_m), "{lane}: {found_m}");
            assert!(map.route.point_at(found_m).distance(point) < 0.01, "{lane}");
        }
    }

    #[test]
    fn an_ego_in_a_junction_is_in_its_paths_lane_and_off_all_lanes_in_none() {
        let map = RoadMap::load_along(GRID, &["B0B1", "B1C1"]).expect("a path");
        let lanes = PathLanes::new(&map);
        let inside =
            map.route.lanes().iter().find(|lane| lane.edge_id(&map.network).starts_with(':')).expect("a junction");
        let s_m = inside.start_s_m + inside.length_m / 2.0;
        let pose = map.route.pose_of_front(s_m, CAR_LENGTH_M);
        let found = lanes.ego_lane(&map, &pose, 0.0, s_m, None).expect("in a lane");
        assert_eq!(Some(found.lane), inside.lane);
        let away = Pose { position: pose.position + glam::DVec2::new(30.0, -30.0), ..pose };
        assert_eq!(lanes.ego_lane(&map, &away, 0.0, s_m, None), None);
        let back = Pose::new(pose.position, pose.yaw_rad + std::f64::consts::PI);
        assert!(lanes.ego_lane(&map, &back, 0.0, s_m, None).is_none_or(|at| at.lane != found.lane));
    }
}
