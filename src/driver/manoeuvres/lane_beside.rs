//! Vehicles in a lane of a network, seen by an ego in the lane beside. In: a map, a lane and a snapshot. Out: the nearest vehicles ahead
//! and behind in that lane. Metres, m/s.
//!
//! Ahead, a lane goes on along the ego's path as far as it leads along it. Behind, all lanes that lead into it count. A vehicle is in the
//! lane of its front and, while it changes lanes, also in the lane that its body reaches into.

use crate::{
    map::{
        RoadMap,
        network::{Connection, LaneId, LanePosition, Network, Side},
    },
    policy::{LaneBeside, LanesBeside, NearVehicle},
    snapshot::{Leader, Snapshot, VehicleSnapshot},
    space::CAR_LENGTH_M,
    traffic::VehicleBody,
};

/// Range ahead and behind, metres: 6 s at 33 m/s.
const SEEN_M: f64 = 200.0;
/// A body reaches into a neighbouring lane if it overlaps that lane by more than this, metres: no vehicle drives exactly on the line.
const REACHES_M: f64 = 0.2;

/// Lateral distance of rear and front beyond which the rear's lane is looked up, metres; below, both count as in the same lane.
const TAIL_OUT_M: f64 = 0.4;

/// A lane with the lanes that lead into it and its continuation along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Corridor {
    lane: LaneId,
    /// Lanes, sorted, each with its start in metres from the start of `lane`.
    starts: Vec<(LaneId, f64)>,
}

impl Corridor {
    /// Returns the corridor of a lane on the edge of the route's lane `index`.
    pub fn new(map: &RoadMap, lane: LaneId, index: usize) -> Self {
        let mut starts = vec![(lane, 0.0)];
        add_ahead(map, lane, index, &mut starts);
        add_behind(&map.network, lane, &mut starts);
        starts.sort_by_key(|(lane, _)| *lane);
        Self { lane, starts }
    }

    /// Returns a position along the corridor, metres from the start of its lane; `None` off the corridor.
    pub fn place_m(&self, at: LanePosition) -> Option<f64> {
        let found = self.starts.binary_search_by_key(&at.lane, |(lane, _)| *lane).ok()?;
        Some(self.starts[found].1 + at.s_m)
    }

    /// Returns the nearest vehicles ahead of and behind an ego whose front is level with `own_m` of the lane.
    pub fn around(&self, net: &Network, snapshot: &Snapshot, own_m: f64) -> LaneBeside {
        let (leader, follower) = self.nearest(net, snapshot, own_m);
        let seen =
            |found: Option<Leader>| found.map(|Leader { gap_m, speed_mps, .. }| NearVehicle { gap_m, speed_mps });
        LaneBeside { leader: seen(leader), follower: seen(follower) }
    }

    /// Does the same as `around`, with the vehicles' ids.
    pub fn nearest(&self, net: &Network, snapshot: &Snapshot, own_m: f64) -> (Option<Leader>, Option<Leader>) {
        let mut found = (None, None);
        for car in &snapshot.cars {
            let Some(at) = car.lane.and_then(|at| self.place_m(reaches_into(net, car, at, self.lane))) else {
                continue;
            };
            let (gap_m, nearest) = match at >= own_m {
                true => (at - car.body.length_m - own_m, &mut found.0),
                false => (own_m - CAR_LENGTH_M - at, &mut found.1),
            };
            if gap_m < SEEN_M && nearest.is_none_or(|nearest: Leader| gap_m < nearest.gap_m) {
                *nearest = Some(Leader { id: car.id, gap_m, speed_mps: car.speed_mps });
            }
        }
        found
    }
}

/// Returns the position in `lane` that is level with a vehicle's front if the vehicle is in a neighbouring lane and its front or rear
/// reaches into `lane`. Otherwise returns the vehicle's own position.
fn reaches_into(net: &Network, car: &VehicleSnapshot, at: LanePosition, lane: LaneId) -> LanePosition {
    let VehicleBody { length_m, width_m, .. } = car.body;
    let half_m = |lane: LaneId| net.lane(lane).half_width_m();
    // Lateral offset of the centre of `lane` from the centre of the vehicle's lane, positive to the left.
    let beside_m = [(Side::Left, 1.0), (Side::Right, -1.0)].into_iter().find_map(|(side, sign)| {
        (net.neighbour(at.lane, side) == Some(lane)).then(|| sign * (half_m(at.lane) + half_m(lane)))
    });
    let is_there =
        |beside_m: f64, offset_m: f64| (beside_m - offset_m).abs() < half_m(lane) + width_m / 2.0 - REACHES_M;
    // At a small angle to the lane, the rear is still where the front was.
    let has_tail_there = |beside_m: f64| {
        let out_m = (car.pose.yaw_rad - net.pose(at).yaw_rad).sin().abs() * length_m;
        let tail = || net.locate(car.pose.rear(length_m).extend(car.height_m), Some(at.lane));
        let is_beside =
            |tail: LanePosition| tail.lane == lane || (tail.lane == at.lane && is_there(beside_m, tail.offset_m));
        out_m > TAIL_OUT_M && tail().is_some_and(is_beside)
    };
    match beside_m.filter(|beside_m| is_there(*beside_m, at.offset_m) || has_tail_there(*beside_m)) {
        Some(_) => LanePosition { lane, s_m: level_m(net, at, lane), offset_m: 0.0 },
        None => at,
    }
}

/// Returns the nearest vehicles in the lane beside the one of the ego's front; `None` without a lane for cars there.
pub fn lane_beside(snapshot: &Snapshot, map: &RoadMap, side: Side) -> Option<LaneBeside> {
    let (net, own) = (&map.network, snapshot.ego_lane?);
    let lane = car_lane_beside(net, own.lane, side)?;
    let corridor = Corridor::new(map, lane, map.route.lane_at(snapshot.ego_s_m).0);
    Some(corridor.around(net, snapshot, level_m(net, own, lane)))
}

/// Returns the sides on which the route's lanes have other lanes for cars.
pub fn lanes_beside(map: &RoadMap) -> LanesBeside {
    let net = &map.network;
    let lanes = || map.route.lanes().iter().filter_map(|lane| lane.lane);
    let has = |side: Side| lanes().any(|lane| car_lane_beside(net, lane, side).is_some());
    LanesBeside { left: has(Side::Left), right: has(Side::Right) }
}

fn car_lane_beside(net: &Network, lane: LaneId, side: Side) -> Option<LaneId> {
    net.neighbour(lane, side).filter(|lane| net.lane(*lane).admits_cars())
}

/// Returns the position in another lane of the same edge that is level with `at`, metres from that lane's start.
pub fn level_m(net: &Network, at: LanePosition, other: LaneId) -> f64 {
    at.s_m * (net.lane(other).length_m / net.lane(at.lane).length_m)
}

/// Adds the continuation of a lane along the route, from the route's lane `index` on.
fn add_ahead(map: &RoadMap, lane: LaneId, index: usize, starts: &mut Vec<(LaneId, f64)>) {
    let (net, route) = (&map.network, map.route.lanes());
    let after = (1..route.len()).map(|k| index + k).take_while(|k| map.route.is_closed() || *k < route.len());
    let streets = after.map(|k| &route[k % route.len()]).filter(|lane| lane.is_street(net));
    let (mut here, mut start_m) = (lane, 0.0);
    for street in streets {
        // Through the junction, on at most two or three internal lanes in netconvert's networks, to the lane beyond.
        for _ in 0..16 {
            start_m += net.lane(here).length_m;
            let way = net.connections_from(here).iter().find(|way| net.edge_of(way.to).id == street.edge_id(net));
            let Some(way) = way.filter(|_| start_m < SEEN_M + net.lane(lane).length_m) else { return };
            here = way.next();
            if starts.iter().any(|(known, _)| *known == here) {
                return;
            }
            starts.push((here, start_m));
            if here == way.to {
                break;
            }
        }
    }
}

/// Adds the lanes that lead into a lane.
fn add_behind(net: &Network, lane: LaneId, starts: &mut Vec<(LaneId, f64)>) {
    let mut open = vec![(lane, 0.0)];
    while let Some((lane, start_m)) = open.pop() {
        // U-turns are ignored as rare.
        let leads_here = |way: &Connection| way.next() == lane && !way.is_turnaround();
        let near = net.predecessors(lane).iter().filter(|_| -start_m < SEEN_M);
        for &before in near.filter(|before| net.connections_from(**before).iter().any(leads_here)) {
            let start_m = start_m - net.lane(before).length_m;
            if starts.iter().all(|(known, _)| *known != before) {
                starts.push((before, start_m));
                open.push((before, start_m));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: &str = "tests/data/networks/grid-signals.net.xml";

    fn at(map: &RoadMap, lane: &str, s_m: f64, offset_m: f64) -> LanePosition {
        LanePosition { lane: map.network.lane_named(lane).expect("a lane"), s_m, offset_m }
    }

    /// Returns the view to the left of an ego 30 m along B0B1_0, on its way to B1B2, of these vehicles, each 5 m long and 1.8 m wide.
    fn seen(cars: &[(&str, f64, f64)]) -> LaneBeside {
        let map = RoadMap::load_along(GRID, &["B0B1", "B1B2"]).expect("a path");
        let car = |(speed, (lane, s_m, offset_m)): (usize, &(&str, f64, f64))| VehicleSnapshot {
            lane: Some(at(&map, lane, *s_m, *offset_m)),
            speed_mps: speed as f64,
            body: VehicleBody::CAR,
            ..VehicleSnapshot::default()
        };
        let cars = cars.iter().enumerate().map(car).collect();
        let ego_lane = Some(at(&map, "B0B1_0", 30.0, 0.0));
        let snapshot = Snapshot { ego_s_m: 30.0, ego_lane, cars, ..Snapshot::default() };
        assert_eq!(lane_beside(&snapshot, &map, Side::Right), None, "B0B1_0 is the outermost lane");
        lane_beside(&snapshot, &map, Side::Left).expect("B0B1_1")
    }

    fn near(gap_m: f64, speed_mps: f64) -> Option<NearVehicle> {
        Some(NearVehicle { gap_m, speed_mps })
    }

    #[test]
    fn only_the_nearest_vehicles_in_the_lane_beside_are_seen_with_their_gaps() {
        assert_eq!(seen(&[]), LaneBeside::default());
        // 45 m less 5 m and the ego's 30 m; 30 m less the ego's 5 m and 20 m. Each vehicle's speed in m/s is its index in the list.
        let cars = [("B0B1_0", 40.0, 0.0), ("B0B1_1", 60.0, 0.0), ("B0B1_1", 45.0, 0.0), ("B1B0_1", 31.0, 0.0)];
        assert_eq!(seen(&cars), LaneBeside { leader: near(10.0, 2.0), follower: None });
        let cars = [("B0B1_1", 20.0, 0.0), ("B0B1_1", 12.0, 0.0), ("B0B1_0", 22.0, 0.0)];
        assert_eq!(seen(&cars), LaneBeside { leader: None, follower: near(5.0, 0.0) });
        // Side by side: a vehicle that is level counts as ahead; the front of one that is 1 m behind is 4 m ahead of the ego's rear.
        assert_eq!(seen(&[("B0B1_1", 30.0, 0.0)]).leader, near(-5.0, 0.0));
        assert_eq!(seen(&[("B0B1_1", 29.0, 0.0)]).follower, near(-4.0, 0.0));
    }

    #[test]
    fn only_the_path_counts_ahead_and_every_connection_counts_behind() {
        // B0B1_1 has 69.20 m and :B1_11_1 20.80 m: at 96 m, less 5 m and 30 m.
        assert!((seen(&[("B1B2_1", 6.0, 0.0)]).leader.expect("on the path").gap_m - 61.0).abs() < 1e-9);
        assert_eq!(seen(&[("B1A1_1", 6.0, 0.0), (":B1_13_0", 2.0, 0.0), ("B1B2_0", 6.0, 0.0)]), LaneBeside::default());
        // From A0B0_1 the path turns left into B0B1_1 on 5.01 m and 14.34 m inside: 25 m, 19.35 m and the 3.2 m to the end of 73.20 m.
        let behind = seen(&[("A0B0_1", 70.0, 0.0)]).follower.expect("it leads here");
        assert!((behind.gap_m - 47.55).abs() < 1e-9, "{behind:?}");
        assert_eq!(seen(&[("A0B0_0", 70.0, 0.0), ("C0B0_1", 70.0, 0.0)]), LaneBeside::default(), "they lead elsewhere");
    }

    #[test]
    fn a_vehicle_that_changes_lanes_is_in_both_as_far_as_its_body_reaches() {
        // Lanes are 3.2 m wide: a body of 1.8 m whose centre is 1 m left of the lane's reaches 0.3 m over the line, at 0.8 m 0.1 m.
        assert_eq!(seen(&[("B0B1_0", 45.0, 1.0)]).leader, near(10.0, 0.0));
        assert_eq!(seen(&[("B0B1_0", 45.0, 0.8), ("B0B1_0", 45.0, -1.0)]).leader, None);
    }

    #[test]
    fn a_vehicle_across_two_lanes_is_also_in_the_lane_of_its_rear() {
        let map = RoadMap::load_along(GRID, &["B0B1", "B1B2"]).expect("a path");
        let front = at(&map, "B0B1_0", 45.0, 0.5);
        let pose = map.network.pose(front);
        // Leaving the left lane at 30 degrees: the rear is 2.5 m to the left of the front, 3 m left of the centre of B0B1_0, which is 3.2 m
        // wide.
        for (turned_deg, wanted) in [(-30.0, near(10.0, 0.0)), (0.0, None)] {
            let yaw_rad = pose.yaw_rad + f64::to_radians(turned_deg);
            let middle = pose.position.truncate() - glam::DVec2::from_angle(yaw_rad) * 2.5;
            let car = VehicleSnapshot {
                lane: Some(front),
                pose: crate::space::Pose::new(middle, yaw_rad),
                body: VehicleBody::CAR,
                ..VehicleSnapshot::default()
            };
            let ego_lane = Some(at(&map, "B0B1_0", 30.0, 0.0));
            let snapshot = Snapshot { ego_s_m: 30.0, ego_lane, cars: vec![car], ..Snapshot::default() };
            assert_eq!(lane_beside(&snapshot, &map, Side::Left).expect("B0B1_1").leader, wanted, "{turned_deg}");
        }
    }

    #[test]
    fn a_path_has_lanes_beside_if_its_edges_have_several_lanes_for_cars() {
        let of = |file: &str, edges: &[&str]| {
            let found = lanes_beside(&RoadMap::load_along(file, edges).expect("a path"));
            (found.left, found.right)
        };
        assert_eq!(of(GRID, &["B0B1", "B1B2"]), (true, false));
        assert_eq!(of(GRID, &["B0B1", "B1C1", "C1C2"]), (true, true), "it goes over to the inner lane");
        assert_eq!(of("tests/data/networks/roundabout.net.xml", &["Ss", "se", "eE"]), (false, false));
        // Lane 0 of cn is a pavement; only lane 1 of cn is for cars.
        assert_eq!(of("tests/data/networks/town.net.xml", &["cn", "nne"]), (false, false));
    }
}
