//! Tests of routes: closed ones wrap, open ones end; and the mappings between routes and the world.

use super::*;
use crate::map::network::LanePosition;
use std::f64::consts::TAU;

/// Returns a circle of 100 m declared length in two lanes, 200 points.
fn circle() -> Route {
    let r = 100.0 / TAU;
    let lane = |k: usize| RouteLane {
        lane: Some(LaneId::from_index(k)),
        start_s_m: 0.0,
        length_m: 50.0,
        speed_limit_mps: 30.0,
        width_m: 3.2,
        shape: (0..=100).map(|i| DVec2::from_angle(TAU * (k * 100 + i) as f64 / 200.0) * r).collect(),
    };
    Route::new(vec![lane(0), lane(1)])
}

#[test]
fn lengths_add_up_and_positions_wrap() {
    let route = circle();
    assert_eq!(route.length_m(), 100.0);
    assert_eq!(route.lane_at(-1.0), (1, 49.0));
    assert_eq!(route.difference(99.0, 2.0), 3.0);
    assert_eq!(route.difference(2.0, 99.0), -3.0);
    assert_eq!(route.wrap(-1e-18), 0.0);
}

#[test]
fn a_point_projects_back_to_its_route_position() {
    let route = circle();
    for i in 0..1000 {
        let s_m = i as f64 * 0.1;
        let left = DVec2::from_angle(route.yaw_at(s_m)).perp();
        for near in [None, Some(s_m + 20.0)] {
            let found = route.project(route.point_at(s_m) + left * 1.5, near);
            // Half a segment (0.25 m) seen from 1.5 m off a 15.9 m radius: 0.0236 m.
            assert!(route.difference(found.s_m, s_m).abs() < 0.024, "{s_m} {found:?}");
            assert!((found.offset_m - 1.5).abs() < 0.002, "{s_m} {found:?}");
        }
    }
}

#[test]
fn a_point_on_a_circle_shorter_than_the_search_window_is_found() {
    // 50 m radius, with a search window of 40 m on either side.
    let r = 50.0 / TAU;
    let shape = (0..=100).map(|i| DVec2::from_angle(TAU * f64::from(i) / 100.0) * r).collect();
    let route = Route::new(vec![RouteLane { length_m: 50.0, shape, ..circle().lanes()[0].clone() }]);
    assert_eq!(route.next_lane(0), Some(0), "its only lane leads to itself");
    for s_m in [0.0, 12.5, 25.0, 45.0] {
        let found = route.project(route.point_at(s_m), Some(s_m + 1.0));
        assert!(route.difference(found.s_m, s_m).abs() < 1e-6, "{s_m} {found:?}");
    }
}

#[test]
fn heading_and_curvature_of_a_circle_are_exact() {
    let route = circle();
    for i in 0..997 {
        let s_m = i as f64 * 0.1003;
        let expected = wrap_angle(TAU * s_m / 100.0 + TAU / 4.0);
        assert!(wrap_angle(route.yaw_at(s_m) - expected).abs() < 1e-6, "{s_m}");
        assert!((route.curvature_at(s_m, 4.0) - TAU / 100.0).abs() < 1e-6, "{s_m}");
    }
}

/// Returns an open route from the origin 60 m east and 40 m north, declared as 120 m and 40 m.
fn corner() -> Route {
    let lane = |length_m: f64, shape: [DVec2; 2]| RouteLane {
        lane: None,
        start_s_m: 0.0,
        length_m,
        speed_limit_mps: 10.0,
        width_m: 3.0,
        shape: shape.into(),
    };
    let [origin, turn, end] = [DVec2::ZERO, DVec2::new(60.0, 0.0), DVec2::new(60.0, 40.0)];
    Route::open(vec![lane(120.0, [origin, turn]), lane(40.0, [turn, end])])
}

#[test]
fn an_open_route_goes_straight_on_and_positions_behind_are_negative() {
    let route = corner();
    assert!(!route.is_closed() && circle().is_closed());
    assert_eq!([-3.0, 170.0].map(|s_m| route.wrap(s_m)), [-3.0, 170.0]);
    assert_eq!([route.ahead(30.0, 10.0), route.difference(150.0, 5.0)], [-20.0, -145.0]);
    // More than half of the length ahead still counts as ahead.
    assert_eq!([route.ahead(5.0, 150.0), route.difference(5.0, 150.0)], [145.0, 145.0]);
    assert_eq!([route.lane_at(-3.0), route.lane_at(170.0)], [(0, 0.0), (1, 40.0)]);
    // The first lane is drawn half as long as declared; beyond the ends, declared and drawn metres are equal.
    for (s_m, x, y) in [(-3.0, -3.0, 0.0), (60.0, 30.0, 0.0), (130.0, 60.0, 10.0), (165.0, 60.0, 45.0)] {
        assert!(route.point_at(s_m).distance(DVec2::new(x, y)) < 1e-12, "{s_m}");
        let left = if s_m < 120.0 { DVec2::Y } else { DVec2::NEG_X };
        for near in [None, Some(s_m + 15.0)] {
            let found = route.project(DVec2::new(x, y) + left * 1.5, near);
            assert!((found.s_m - s_m).abs() < 1e-12 && (found.offset_m - 1.5).abs() < 1e-12, "{s_m} {found:?}");
        }
    }
    // The heading at an end is that of the segment there: nothing is smoothed from one end to the other.
    let north = TAU / 4.0;
    assert_eq!([-5.0, 0.0, 160.0, 170.0].map(|s_m| route.yaw_at(s_m)), [0.0, 0.0, north, north]);
    assert!((route.yaw_at(120.0) - north / 2.0).abs() < 0.4, "in the corner");
    assert_eq!([route.curvature_at(0.0, 4.0), route.curvature_at(160.0, 4.0)], [0.0, 0.0]);
    let first = route.pose_of_front(0.0, 5.0);
    assert!(first.position.distance(DVec2::new(-2.5, 0.0)) < 1e-12 && first.yaw_rad == 0.0, "{first:?}");
    assert_eq!([route.height_m(50.0), route.grade(50.0)], [0.0, 0.0]);
}

#[test]
fn a_gap_has_its_drawn_length_where_lanes_are_declared_longer() {
    let route = corner();
    // 120 declared metres are drawn as 60, the next 40 as 40.
    let cases = [((20.0, 100.0), 40.0), ((100.0, 130.0), 20.0), ((130.0, 100.0), -20.0), ((-3.0, 0.0), 3.0)];
    for ((from_m, to_m), wanted_m) in cases.into_iter().chain([((120.0, 165.0), 45.0)]) {
        let found_m = route.drawn_ahead_m(from_m, to_m);
        assert!((found_m - wanted_m).abs() < 1e-9, "{from_m} {to_m}: {found_m}");
    }
    // The same route as a lap, with a third lane back to the start, drawn and declared 72.111 m long.
    let back_m = DVec2::new(60.0, 40.0).length();
    let back =
        RouteLane { length_m: back_m, shape: vec![DVec2::new(60.0, 40.0), DVec2::ZERO], ..route.lanes()[1].clone() };
    let lap = Route::new(route.lanes().iter().cloned().chain([back]).collect());
    assert!((lap.drawn_ahead_m(130.0, 100.0) - (60.0 + 40.0 + back_m - 20.0)).abs() < 1e-9);
    // Without scaling, the drawn distance equals the distance ahead to the bit.
    let ring = circle();
    assert_eq!(ring.drawn_ahead_m(0.1, 0.7), ring.ahead(0.1, 0.7));
}

#[test]
fn a_route_over_a_hill_has_the_heights_of_its_lanes() {
    let net = Network::load("tests/data/networks/hill.net.xml").expect("a network");
    let lane = net.lane_named("up_0").expect("a lane");
    let route = Route::open(vec![RouteLane::of(&net, lane)]).with_heights(&net);
    // The second and third point of the lane's shape in the file, 62.52 m apart on the ground.
    let (a, b) = (DVec2::new(50.8252, 100.2586), DVec2::new(111.4802, 115.4223));
    let [from, to] = [a, b].map(|point| route.project(point, None).s_m);
    let half_m = (from + to) / 2.0;
    assert!((route.height_m(half_m) - 9.5).abs() < 0.05, "{}", route.height_m(half_m));
    assert!((route.grade(half_m) - 9.0 / a.distance(b)).abs() < 1e-3, "{}", route.grade(half_m));
    assert!((route.height_m(-10.0) - 2.2372).abs() < 1e-9 && (route.height_m(1e4) - 21.7329).abs() < 1e-9);
    // The heights equal those of the network on every lane.
    for s_m in [0.0, 20.0, 100.0, 200.0] {
        let at = LanePosition { lane, s_m, offset_m: 0.0 };
        assert!((route.height_m(s_m) - net.pose(at).position.z).abs() < 1e-9, "{s_m}");
    }
}
