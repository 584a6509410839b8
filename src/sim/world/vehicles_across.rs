//! Vehicles that block, or will block, an ego's way, and that no lane tells of: those within a junction where the ego has right of way, and those
//! that follow no lane. In: a map and snapshots. Out: the nearest such vehicle as a driver sees it. Metres, m/s, seconds.
//!
//! A driver with right of way waits at no line, but brakes for a vehicle that is already in the junction and will not have left it in time.
//! At a line to yield the driver judges the vehicles within the junction, too (`manoeuvres::RightOfWay`). A vehicle along a lane of a street
//! stays in it, and waits at its line. Any other is judged by its body and its motion: one that stands or drives across a street, or comes
//! from beside the road or against the lane.

use super::persons_ahead::{APART_S, BesideRoute, DrivenLine, is_near_line, look_ahead_m};
use crate::{
    driver::{SeenLeader, manoeuvres::RightOfWay},
    map::{RoadMap, network::LaneId},
    sim::{Snapshot, VehicleSnapshot},
    space::{CAR_WIDTH_M, is_one_road},
};
use glam::DVec2;

/// Smallest distance at which a car passes another.
const BESIDE_M: f64 = 0.3;
/// Time for which a driver foresees the way of a vehicle in a junction, which turns, s.
const LOOKS_AHEAD_S: f64 = 2.0;

/// Returns the nearest vehicle across the way of an ego that drives along this line.
pub(super) fn nearest(
    snapshot: &Snapshot,
    map: &RoadMap,
    line_m: DrivenLine,
    rules: &RightOfWay,
) -> Option<SeenLeader> {
    let ego = snapshot.ego.position.truncate();
    let ahead_m = look_ahead_m(snapshot.ego.speed_mps);
    let near = snapshot.vehicles().filter(|car| car.pose.position.distance(ego) < ahead_m);
    let across = near.filter_map(|car| {
        let at = BesideRoute::of(car, snapshot, &map.route, line_m);
        if !is_one_road(car.height_m, map.route.height_m(at.s_m)) {
            return None;
        }
        match car.lane {
            Some(on) => across_ahead(car, &at, snapshot, map, Some(LOOKS_AHEAD_S))
                .filter(|_| is_across_junction(car, on.lane, &at, map, rules)),
            // A vehicle of a closed route has a place on it instead of a lane.
            None if car.s_m.is_some() => None,
            None => across_ahead(car, &at, snapshot, map, None),
        }
    });
    across.min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
}

/// Checks whether a vehicle in a lane is within a junction where the ego has right of way, on another way than the ego's.
fn is_across_junction(
    car: &VehicleSnapshot,
    lane: LaneId,
    at: &BesideRoute,
    map: &RoadMap,
    rules: &RightOfWay,
) -> bool {
    let (route, Some(junction)) = (&map.route, map.network.edge_of(lane).junction) else { return false };
    // A vehicle that follows the ego's way is a leader. A way that crosses itself has the lanes of both ways, so only those around it count.
    let lanes = route.lanes();
    let [first, last] = [-1.0, 1.0].map(|side| route.lane_at(route.wrap(at.s_m + side * car.body.length_m)).0);
    let mut around = (0..=(last + lanes.len() - first) % lanes.len()).map(|k| &lanes[(first + k) % lanes.len()]);
    let is_leader = around.any(|on| on.lane == Some(lane));
    !is_leader && !rules.yields_at(junction, at.s_m, route)
}

/// Returns what a driver sees of a vehicle that is in the ego's way when the ego is there; `None` for any other. A vehicle that is in the way
/// later than `within_s`, if that is given, is not seen yet.
fn across_ahead(
    car: &VehicleSnapshot,
    at: &BesideRoute,
    snapshot: &Snapshot,
    map: &RoadMap,
    within_s: Option<f64>,
) -> Option<SeenLeader> {
    let route = &map.route;
    // Its body in the frame of the route there: along it and to the left.
    let turned = DVec2::from_angle(car.pose.yaw_rad - route.yaw_at(at.s_m));
    let half = DVec2::new(car.body.length_m, car.body.width_m) / 2.0;
    let reach = DVec2::new(
        turned.x.abs() * half.x + turned.y.abs() * half.y,
        turned.y.abs() * half.x + turned.x.abs() * half.y,
    );
    let gap_m = route.difference(snapshot.ego_s_m, at.s_m) - reach.x;
    let speed_mps = car.speed_mps.max(0.0);
    let offset_m = |time_s: f64| {
        let way_m = speed_mps * time_s + car.accel_mps2.max(0.0) * time_s * time_s / 2.0;
        at.offset_m + turned.y * way_m
    };
    let is_in_way = |times_s| is_near_line(offset_m, times_s, reach.y + CAR_WIDTH_M / 2.0 + BESIDE_M);
    let will_be = within_s.is_none_or(|within_s| is_in_way([0.0, within_s]));
    let arrives_s = gap_m / snapshot.ego.speed_mps.max(1.0);
    let stays = is_in_way([arrives_s - APART_S, arrives_s + APART_S]);
    (gap_m > 0.0 && will_be && stays).then_some(SeenLeader { gap_m, speed_mps: (turned.x * speed_mps).max(0.0) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        ego::EgoState,
        map::{PathLanes, network::LanePosition},
        space::{CAR_LENGTH_M, Pose},
        traffic::VehicleBody,
    };
    use glam::dvec2;

    /// Returns the gap to a vehicle that goes west, `before_m` before the middle of the crossing, for an ego that comes from the south with
    /// `ahead_m` to that middle. The ways are at x = 61.6 and y = 61.6.
    fn seen_m(ahead_m: f64, ego_mps: f64, lane: &str, before_m: f64, speed_mps: f64) -> Option<f64> {
        let map = RoadMap::load("figure-eight").expect("a map that ships");
        let named = |lane: &str| map.network.lane_named(lane).expect("a lane");
        let start_m = map.route.s_on(named("bottom_0"), 0.0).expect("a lane of the route");
        let ego = EgoState {
            position: dvec2(61.6, 61.6 - ahead_m - CAR_LENGTH_M / 2.0).extend(0.0),
            speed_mps: ego_mps,
            ..EgoState::default()
        };
        let car = VehicleSnapshot {
            pose: Pose::new(dvec2(61.6 + before_m, 61.6), std::f64::consts::PI),
            lane: (!lane.is_empty()).then(|| LanePosition { lane: named(lane), s_m: 0.0, offset_m: 0.0 }),
            speed_mps,
            body: VehicleBody::CAR,
            ..VehicleSnapshot::default()
        };
        // bottom_0 begins at y = 30.13.
        let ego_s_m = start_m + 61.6 - ahead_m - 30.13;
        let snapshot = Snapshot { ego, ego_s_m, cars: vec![car], ..Snapshot::default() };
        let rules = RightOfWay::new(PathLanes::new(&map).yield_lines(&map));
        nearest(&snapshot, &map, &|_| 0.0, &rules).map(|seen| seen.gap_m)
    }

    #[test]
    fn a_driver_brakes_for_who_is_in_the_crossing_and_stays_in_the_way() {
        // Its near side is half a width of 1.8 m before the middle.
        let near = |seen: Option<f64>| seen.is_some_and(|gap_m| (gap_m - (20.0 - 0.9)).abs() < 0.05);
        assert!(near(seen_m(20.0, 8.0, ":center_1_0", 0.0, 0.0)), "it stands across the way");
        assert_eq!(seen_m(20.0, 8.0, ":center_1_0", 0.0, 10.0), None, "3.7 m take it 0.4 s, and the ego needs 2.4 s");
        // Way from the middle at which the body is clear: half a length, half a car's width and 0.3 m, 3.7 m.
        assert_eq!(seen_m(20.0, 8.0, ":center_1_0", 3.8, 0.0), None, "it waits beside the way");
        assert!(
            near(seen_m(20.0, 8.0, ":center_1_0", 5.0, 1.0)),
            "in 2 s it is at 3 m, and at 2.6 m when the ego comes"
        );
        assert_eq!(seen_m(20.0, 8.0, ":center_1_0", 5.0, 5.0), None, "when the ego comes, after 2.4 s, it is at -7 m");
        assert_eq!(seen_m(20.0, 8.0, "right_0", 0.0, 0.0), None, "within a street it is no vehicle across");
        assert_eq!(seen_m(20.0, 8.0, ":center_2_0", 0.0, 0.0), None, "a vehicle in the ego's lane is its leader");
    }

    #[test]
    fn a_vehicle_that_follows_no_lane_is_judged_by_its_body_and_motion_alone() {
        let near = |seen: Option<f64>| seen.is_some_and(|gap_m| (gap_m - (20.0 - 0.9)).abs() < 0.05);
        assert!(near(seen_m(20.0, 8.0, "", 0.0, 0.0)), "it stands across the way");
        assert_eq!(seen_m(20.0, 8.0, "", 3.8, 0.0), None, "it stands beside the way");
        // The ego comes after 2.4 s. A vehicle in a junction turns, so that its way is foreseen for 2 s only.
        assert!(near(seen_m(20.0, 8.0, "", 24.0, 10.0)), "it comes together with the ego");
        assert_eq!(seen_m(20.0, 8.0, ":center_1_0", 24.0, 10.0), None, "after 2 s it is at 4 m");
        // Half a second before and after the ego it is 6.2 m before and beyond the middle: it passes in between.
        assert!(near(seen_m(20.0, 8.0, "", 29.9, 12.5)), "it is fast");
        assert_eq!(seen_m(20.0, 8.0, "", 33.0, 10.0), None, "after 2.9 s it is at 4.1 m");
        assert_eq!(seen_m(20.0, 8.0, "", 12.0, 10.0), None, "after 1.9 s it is at -7 m");
    }
}
