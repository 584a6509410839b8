//! Positions in lanes and points in the world are each other's inverse, and overlapping lanes are resolved by hint, heading and height.

use super::*;
use crate::{map::RoadMap, rng, space::wrap_angle};
use glam::{DVec2, DVec3, dvec3};

/// Largest error of a position mapped to the world and back: 1 mm, as promised.
const MOST_M: f64 = 0.001;

/// Returns positions in a lane: over its length, and offsets over its width.
fn places(net: &Network, lane: LaneId) -> impl Iterator<Item = LanePosition> {
    let (length_m, half_m) = (net.lane(lane).length_m, net.lane(lane).half_width_m());
    (0..=24).flat_map(move |k| {
        [-0.98, -0.5, 0.0, 0.37, 0.98].map(move |share| LanePosition {
            lane,
            s_m: length_m * f64::from(k) / 24.0,
            offset_m: half_m * share,
        })
    })
}

fn is_walking_area(net: &Network, lane: LaneId) -> bool {
    net.edge_of(lane).kind == EdgeKind::WalkingArea
}

#[test]
fn a_lane_position_is_found_to_a_millimetre_with_its_lane_as_the_hint() {
    // Index 0: streets. Index 1: internal lanes and crossings.
    let (mut tried, mut folded) = ([0, 0], [0, 0]);
    for file in files() {
        let net = read(&file);
        for lane in net.lane_ids().filter(|lane| !is_walking_area(&net, *lane)) {
            let line = &net.lane(lane).line;
            let (right_m, left_m) = line.unfolded();
            let inside = usize::from(!net.edge_of(lane).kind.is_street());
            for at in places(&net, lane) {
                let point = net.pose(at).position;
                assert!(point.is_finite(), "{} {at:?}", file.display());
                tried[inside] += 1;
                let found = net.locate(point, Some(lane)).unwrap();
                // On the inside of a bend that is tighter than the lane is wide.
                if at.offset_m <= right_m || at.offset_m >= left_m {
                    folded[inside] += 1;
                    continue;
                }
                // Where the strip overlaps itself: another position with the same point, nearer to the line.
                let other = found.lane == lane && found.offset_m.abs() < at.offset_m.abs() - 1e-6;
                if other && net.pose(found).position.distance(point) < MOST_M {
                    folded[inside] += 1;
                    continue;
                }
                let same = found.lane == lane
                    && (found.s_m - at.s_m).abs() < MOST_M
                    && (found.offset_m - at.offset_m).abs() < MOST_M;
                assert!(same, "{}: {} {at:?}, found {found:?}", file.display(), net.lane(lane).id);
            }
        }
    }
    // Streets have no such bends. One in four internal lanes is a U-turn, where a third of the width lies on the inside.
    assert!(
        tried[0] > 25_000 && tried[1] > 25_000 && folded[0] == 0 && folded[1] * 12 < tried[1],
        "{folded:?} of {tried:?}"
    );
}

#[test]
fn a_lane_position_is_found_without_a_hint_on_a_lane_that_contains_it() {
    for file in files() {
        let net = read(&file);
        let (mut same, mut all) = (0, 0);
        for lane in net.lane_ids().filter(|lane| net.edge_of(*lane).kind.is_street()) {
            for at in places(&net, lane) {
                let point = net.pose(at).position;
                let found = net.locate(point, None).unwrap();
                let apart = net.pose(found).position - point;
                // Lanes that overlap on a slope differ in height.
                let same_place = apart.truncate().length() < MOST_M && apart.z.abs() < 0.5;
                assert!(same_place, "{}: {at:?}, found {found:?}, {apart} m off", file.display());
                assert!(found.offset_m.abs() < at.offset_m.abs() + 1e-9, "{}: {at:?}, found {found:?}", file.display());
                all += 1;
                same += usize::from(found.lane == lane);
            }
        }
        // Streets overlap at most at their ends, where the next one begins.
        assert!(same * 10 >= all * 9, "{}: {same} of {all}", file.display());
    }
}

/// Returns a lane of two parts at a right angle that climbs one metre in ten, declared twice as long as drawn.
fn corner() -> CentreLine {
    let rise = 100f64.sqrt() / 10.0;
    let shape = [dvec3(0.0, 0.0, 0.0), dvec3(10.0, 0.0, rise), dvec3(10.0, 10.0, 2.0 * rise)];
    CentreLine::new(&shape, 2.0 * 2.0 * 101f64.sqrt(), DVec2::X)
}

#[test]
fn the_nearest_place_of_a_winding_line_is_the_best_of_all_its_pieces() {
    let mut stream = rng::stream(1, "winding");
    for _ in 0..50 {
        let mut at = DVec3::ZERO;
        let shape: Vec<DVec3> = (0..40)
            .map(|_| {
                at += dvec3(stream.normal() * 6.0, stream.normal() * 6.0, stream.normal() * 0.3);
                at
            })
            .collect();
        let line = CentreLine::new(&shape, 500.0, DVec2::X);
        for _ in 0..40 {
            let point = shape[stream.index(40)] + dvec3(stream.normal() * 5.0, stream.normal() * 5.0, 0.0);
            let pieces = (0..line.points().len() - 1).map(|k| line.foot(k, point));
            let best = pieces.min_by(|a, b| a.distance_m.total_cmp(&b.distance_m)).expect("pieces");
            assert_eq!(line.nearest(point), best, "{point}");
        }
    }
}

#[test]
fn all_points_of_a_clear_circle_are_on_a_lane() {
    const BESIDE_M: f64 = 0.4;
    let mut stream = rng::stream(1, "circles");
    for file in ["tests/data/networks/grid-signals.net.xml", "tests/data/networks/roundabout.net.xml"] {
        let net = Network::load(file).expect("a network");
        let mut circles = 0;
        for lane in net.lane_ids().filter(|lane| !is_walking_area(&net, *lane)) {
            for at in places(&net, lane) {
                let middle = net.pose(at).position;
                let radius_m = net.clear_m(middle, BESIDE_M, Some(lane));
                circles += usize::from(radius_m > 0.5);
                for _ in 0..5 {
                    let way = DVec2::from_angle(stream.uniform(0.0, 7.0)) * radius_m * stream.uniform(0.9, 1.0);
                    let point = middle + way.extend(0.0);
                    assert!(radius_m < 0.0 || net.lane_under(point, BESIDE_M, Some(lane)).is_some(), "{at:?} {point}");
                }
            }
        }
        assert!(circles > 100, "{file}: {circles} circles");
    }
}

#[test]
fn the_strip_of_a_corner_is_mitred_and_positions_are_declared_metres() {
    let line = corner();
    let quarter_m = line.length_m() / 4.0;
    // By hand: half of the first part is at (5, 0), half a metre up; the line of the corner is the diagonal.
    for (s_m, offset_m, at) in [
        (quarter_m, 0.0, dvec3(5.0, 0.0, 0.5)),
        (2.0 * quarter_m, 0.0, dvec3(10.0, 0.0, 1.0)),
        (2.0 * quarter_m, 2.0, dvec3(8.0, 2.0, 1.0)),
        (2.0 * quarter_m, -2.0, dvec3(12.0, -2.0, 1.0)),
        (3.0 * quarter_m, -2.0, dvec3(12.0, 4.0, 1.5)),
        (4.0 * quarter_m, 1.0, dvec3(9.0, 10.0, 2.0)),
    ] {
        let pose = line.pose(s_m, offset_m);
        assert!(pose.position.distance(at) < 1e-9, "{s_m} {offset_m}: {pose:?}");
        assert!((pose.grade - 0.1).abs() < 1e-12);
    }
    // An arc that passes the corner at 1.5 m begins 1.5 m / tan 22.5 deg = 3.621 m before it, 7.279 m as declared (20.1 m for 10). At
    // 5.025 m before the corner, it has turned by (7.279 - 5.025) / 14.557 of the right angle.
    let yaw_deg = |s_m: f64| line.pose(s_m, 0.0).yaw_rad.to_degrees();
    assert!(yaw_deg(0.0).abs() < 1e-9 && (yaw_deg(2.0 * quarter_m) - 45.0).abs() < 1e-9);
    assert!((yaw_deg(1.5 * quarter_m) - 13.934).abs() < 0.001 && (yaw_deg(4.0 * quarter_m) - 90.0).abs() < 1e-9);
    assert_eq!(line.unfolded(), (f64::NEG_INFINITY, 10.0));
}

#[test]
fn where_lanes_cross_the_hint_decides_else_the_heading() {
    let net = named("figure-eight");
    let (one, other) = (lane(&net, ":x_0_0"), lane(&net, ":x_1_0"));
    let crossing = |lane: LaneId| net.lane(lane).line.pose(net.lane(lane).length_m / 2.0, 0.0);
    let (a, b) = (crossing(one), crossing(other));
    assert!(a.position.distance(b.position) < 0.5 && wrap_angle(a.yaw_rad - b.yaw_rad).abs() > 1.0, "{a:?} {b:?}");
    for hint in [one, other] {
        assert_eq!(net.locate(a.position, Some(hint)).unwrap().lane, hint);
        // With the predecessor as the hint, its successor is found.
        let before = net.predecessors(hint)[0];
        let inside = net.lane(hint).line.pose(1.0, 0.0);
        assert_eq!(net.locate(inside.position, Some(before)).unwrap().lane, hint);
    }
    assert_eq!(net.locate_pose(&a, None).unwrap().lane, one);
    assert_eq!(net.locate_pose(&b, None).unwrap().lane, other);
    // Back along a street with two directions: the lane of the opposite direction, not the nearer one.
    let net = named("spider");
    let (there, back) = net
        .edge_ids()
        .filter(|edge| net.edge(*edge).kind.is_street())
        .find_map(|edge| Some((edge, net.other_direction(edge)?)))
        .map(|(there, back)| (net.edge(there).lanes().next().unwrap(), net.edge(back).lanes().next().unwrap()))
        .unwrap();
    let mut pose = net.lane(there).line.pose(net.lane(there).length_m / 2.0, 0.3);
    assert_eq!(net.locate_pose(&pose, None).unwrap().lane, there);
    pose.yaw_rad = wrap_angle(pose.yaw_rad + std::f64::consts::PI);
    assert_eq!(net.locate_pose(&pose, None).unwrap().lane, back);
}

#[test]
fn a_bridge_and_the_road_below_are_distinguished_by_height() {
    let net = named("hill");
    let (up, tunnel) = (lane(&net, "up_0"), lane(&net, "tunnel_0"));
    let (over, under) = (&net.lane(up).line, &net.lane(tunnel).line);
    // The point where the two lines cross on the ground.
    let off_m = |s_m: f64| over.nearest(under.pose(s_m, 0.0).position).offset_m.abs();
    let places = (0..40_000).map(|k| under.length_m() * f64::from(k) / 40_000.0);
    let s_m = places.min_by(|a, b| off_m(*a).total_cmp(&off_m(*b))).unwrap();
    let above_s_m = over.nearest(under.pose(s_m, 0.0).position).s_m;
    let (above, below) = (over.pose(above_s_m, 0.0).position, under.pose(s_m, 0.0).position);
    assert!(above.truncate().distance(below.truncate()) < 0.02 && above.z - below.z > 10.0, "{above} {below}");
    // Here the other lane is nearer on the ground.
    assert_eq!(net.locate(over.pose(above_s_m, 0.5).position, None).unwrap().lane, up);
    assert_eq!(net.locate(under.pose(s_m, 0.5).position, None).unwrap().lane, tunnel);
    // Grade of the climb's first part by hand: 3 m up over 50 m along and 5 m across.
    let grade = net.lane(up).line.pose(1.0, 0.0).grade;
    assert!((grade - 3.0 / 2525f64.sqrt()).abs() < 0.002, "{grade}");
    let census = net.census();
    assert!(census.has_heights() && census.heights_m.0 < -3.0 && census.heights_m.1 > 20.0, "{census:?}");
}

#[test]
fn a_point_far_from_every_road_is_in_no_lane() {
    let net = named("one-way");
    let (_, high) = net.bounds();
    assert_eq!(net.locate(high + dvec3(50.0, 50.0, 0.0), None), None);
    assert_eq!(net.locate(dvec3(1e7, -1e7, 0.0), Some(lane(&net, "ab_0"))), None);
    assert_eq!(Network::default().locate(DVec3::ZERO, None), None);
    // Beside the road, by less and by more than the reach.
    let beside = |offset_m: f64| net.locate(net.lane(lane(&net, "island_0")).line.pose(50.0, offset_m).position, None);
    assert_eq!(beside(REACH_M - 0.01).unwrap().lane, lane(&net, "island_0"));
    assert_eq!(beside(REACH_M + 0.01), None);
}

#[test]
fn the_neighbour_on_the_left_lies_on_the_left() {
    let mut pairs = 0;
    for file in files() {
        let net = read(&file);
        for here in net.lane_ids().filter(|lane| net.edge_of(*lane).kind.is_street()) {
            for (side, sign) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
                let Some(beside) = net.neighbour(here, side) else { continue };
                let back = if side == Side::Left { Side::Right } else { Side::Left };
                assert_eq!(net.neighbour(beside, back), Some(here));
                let (here_lane, beside_lane) = (net.lane(here), net.lane(beside));
                let middle = here_lane.line.pose(here_lane.length_m / 2.0, 0.0);
                let across = beside_lane.line.nearest(middle.position);
                // Half of both widths, as SUMO spreads lanes, with a tolerance for bends and ramps.
                let apart_m = here_lane.half_width_m() + beside_lane.half_width_m();
                assert!(
                    (-across.offset_m - sign * apart_m).abs() < 0.2 * apart_m,
                    "{} {}",
                    file.display(),
                    here_lane.id
                );
                pairs += 1;
            }
        }
    }
    assert!(pairs > 50, "{pairs}");
}

#[test]
fn the_route_of_a_ring_has_the_positions_and_the_line_of_its_lanes() {
    for name in ["ring-250", "ring-641", "practice"] {
        let map = RoadMap::load(name).unwrap();
        let (net, route) = (&map.network, &map.route);
        let lanes: Vec<LaneId> = route.lanes().iter().map(|of| of.lane.unwrap()).collect();
        let declared_m: f64 = lanes.iter().map(|lane| net.lane(*lane).length_m).sum();
        assert!((declared_m - route.length_m()).abs() < 1e-9 && route.is_closed());
        for (before, after) in lanes.iter().zip(lanes.iter().cycle().skip(1)) {
            assert!(net.successors(*before).any(|next| next == *after), "{name}");
        }
        for k in 0..500 {
            let s_m = route.length_m() * f64::from(k) / 499.0 * 1.5 - 40.0;
            let (index, along_m) = route.lane_at(s_m);
            assert!((route.s_on(lanes[index], along_m).unwrap() - route.wrap(s_m)).abs() < 1e-9);
            let at = LanePosition { lane: lanes[index], s_m: along_m, offset_m: 0.0 };
            let point = net.pose(at).position.truncate();
            assert!(point.distance(route.point_at(s_m)) < 1e-9, "{name} {s_m}");
        }
    }
}

#[test]
fn lanes_inside_a_junction_are_found_between_connected_lanes_only() {
    let net = named("figure-eight");
    let streets = ["xr_0", "rx_0", "xl_0", "lx_0"].map(|id| lane(&net, id));
    let after = streets.iter().cycle().skip(1);
    // Two lanes inside junction x and one in each of the others.
    let inside: usize = streets.iter().zip(after).map(|(from, to)| net.lanes_between(*from, *to).count()).sum();
    assert_eq!(streets.len() + inside, 8);
    assert_eq!(net.lanes_between(streets[0], streets[2]).count(), 0);
}
