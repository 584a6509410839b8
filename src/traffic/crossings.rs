//! Self-crossings of a route, and overlapping vehicles. In: a route, or poses of vehicles. Out: the two positions on the route, or the two
//! vehicles. Metres.

use crate::{
    map::Route,
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose, is_one_road},
};
use glam::DVec2;
use std::collections::BTreeMap;

/// Distance between compared positions, metres: a crossing is no narrower than a vehicle.
const EVERY_M: f64 = 1.0;
/// Positions no further apart along the route than this count as one, metres: two vehicle lengths.
const SAME_PLACE_M: f64 = 2.0 * CAR_LENGTH_M;

/// Returns two positions of a route, far apart along it, at which vehicles would touch: the route crosses or touches itself there. `None`
/// if it keeps clear of itself, also by a bridge.
pub(super) fn self_crossing(route: &Route) -> Option<(f64, f64)> {
    let n = (route.length_m() / EVERY_M).ceil().max(1.0) as usize;
    let s_m = |k: usize| route.length_m() * k as f64 / n as f64;
    let cell = |point: DVec2| ((point.x / CAR_WIDTH_M).floor() as i64, (point.y / CAR_WIDTH_M).floor() as i64);
    let mut cells: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
    for k in 0..n {
        let point = route.point_at(s_m(k));
        let (x, y) = cell(point);
        let around = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y)));
        let near = around.filter_map(|cell| cells.get(&cell)).flatten();
        let meets = |other: &&usize| {
            route.difference(s_m(**other), s_m(k)).abs() > SAME_PLACE_M
                && route.point_at(s_m(**other)).distance(point) < CAR_WIDTH_M
                && is_one_road(route.height_m(s_m(**other)), route.height_m(s_m(k)))
        };
        if let Some(first) = near.filter(meets).min() {
            return Some((s_m(*first), s_m(k)));
        }
        cells.entry((x, y)).or_default().push(k);
    }
    None
}

/// Returns the indices of two vehicles that overlap. Vehicles that only touch do not count.
pub(super) fn overlapping(cars: &[Pose]) -> Option<(usize, usize)> {
    let pairs = (1..cars.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    let mut near =
        pairs.filter(|&(a, b)| cars[a].position.distance(cars[b].position) < CAR_LENGTH_M.hypot(CAR_WIDTH_M));
    near.find(|&(a, b)| overlap(&cars[a], &cars[b]))
}

/// Checks whether two vehicles overlap, by the separating axis test.
fn overlap(a: &Pose, b: &Pose) -> bool {
    /// Overlap that still counts as touching, metres: vehicles bumper to bumper in a bend overlap by less.
    const TOUCH_M: f64 = 0.2;
    let apart = b.position - a.position;
    let axes = [a.forward(), a.left(), b.forward(), b.left()];
    axes.iter().all(|axis| {
        let reach = |car: &Pose| {
            CAR_LENGTH_M / 2.0 * car.forward().dot(*axis).abs() + CAR_WIDTH_M / 2.0 * car.left().dot(*axis).abs()
        };
        apart.dot(*axis).abs() < reach(a) + reach(b) - TOUCH_M
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{RoadMap, RouteLane};
    use std::f64::consts::TAU;

    fn route(shape: Vec<DVec2>) -> Route {
        let length_m = shape.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        Route::new(vec![RouteLane { lane: None, start_s_m: 0.0, length_m, speed_limit_mps: 30.0, width_m: 3.2, shape }])
    }

    #[test]
    fn a_figure_of_eight_meets_itself_in_the_middle_and_rings_nowhere() {
        // Lemniscate of Gerono: x = 60 cos t, y = 60 sin t cos t. It passes the origin at a quarter and at three quarters of its length.
        let eight = route(
            (0..=400)
                .map(|k| f64::from(k) / 400.0 * TAU)
                .map(|t| DVec2::new(t.cos(), t.sin() * t.cos()) * 60.0)
                .collect(),
        );
        let (first_m, second_m) = self_crossing(&eight).unwrap();
        for (found_m, share) in [(first_m, 0.25), (second_m, 0.75)] {
            assert!((found_m / eight.length_m() - share).abs() < 0.02, "{first_m} {second_m} of {}", eight.length_m());
        }
        // North, and round to north again, half a vehicle's width further west.
        let beside = [(0.0, 0.0), (0.0, 60.0), (40.0, 60.0), (40.0, -60.0), (-0.9, -60.0), (-0.9, 30.0), (-40.0, 30.0)];
        assert!(self_crossing(&route(beside.map(DVec2::from).to_vec())).is_some());
        for name in ["ring-250", "ring-641", "practice"] {
            assert_eq!(self_crossing(&RoadMap::load(name).unwrap().route), None, "{name}");
        }
        // There and back on neighbouring lanes of 3.2 m.
        let strip = [(0.0, 0.0), (100.0, 0.0), (103.0, 1.6), (100.0, 3.2), (0.0, 3.2), (-3.0, 1.6), (0.0, 0.0)];
        assert_eq!(self_crossing(&route(strip.map(DVec2::from).to_vec())), None);
    }

    #[test]
    fn cars_across_each_other_overlap_and_cars_beside_each_other_do_not() {
        let at = |x, y, yaw| Pose::new(DVec2::new(x, y), yaw);
        let here = at(0.0, 0.0, 0.0);
        assert_eq!(overlapping(&[here, at(50.0, 0.0, 0.0), at(1.0, 1.0, TAU / 4.0)]), Some((0, 2)));
        // A car is 5 m long and 1.8 m wide.
        assert_eq!(overlapping(&[here, at(5.0, 0.0, 0.0), at(0.0, 1.8, 0.0)]), None);
        assert_eq!(overlapping(&[here, at(0.0, 3.4, TAU / 4.0)]), None);
        assert_eq!(overlapping(&[here, at(0.0, 3.1, TAU / 4.0)]), Some((0, 1)));
    }
}
