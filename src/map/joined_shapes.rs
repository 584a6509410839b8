//! Shapes of consecutive lanes in a route. In: lanes as a network draws them. Out: the same lanes without gaps between them, and without a
//! step at a lane change. Metres.

use super::RouteLane;
use glam::DVec2;

/// Gap above which lanes are joined by a curve, metres: netconvert rounds to 0.01 m.
const GAP_M: f64 = 0.05;
/// Gap in an open route that becomes a lane of its own, metres: narrower than the narrowest street that may cross there.
const BRIDGE_M: f64 = 1.0;

/// Returns the length of a shape as drawn, metres.
pub(super) fn shape_length_m(shape: &[DVec2]) -> f64 {
    shape.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// Returns the lane driven on an edge that is entered on one lane and left on another, with a smooth lane change over the whole length.
/// The result names the lane that is left.
pub(super) fn change_lanes(entered: &RouteLane, left: &RouteLane) -> RouteLane {
    if entered.lane == left.lane {
        return entered.clone();
    }
    let n = (entered.length_m / 2.0).ceil().max(8.0);
    let point = |i: usize| {
        let fraction = i as f64 / n;
        let over = fraction * fraction * (3.0 - 2.0 * fraction);
        along_shape(&entered.shape, fraction).lerp(along_shape(&left.shape, fraction), over)
    };
    RouteLane { shape: (0..=n as usize).map(point).collect(), ..left.clone() }
}

/// Returns the point at `fraction` (0..1) of a shape's length.
fn along_shape(shape: &[DVec2], fraction: f64) -> DVec2 {
    let mut rest_m = fraction * shape_length_m(shape);
    for pair in shape.windows(2) {
        let length_m = pair[0].distance(pair[1]);
        if rest_m < length_m {
            return pair[0].lerp(pair[1], rest_m / length_m);
        }
        rest_m -= length_m;
    }
    shape[shape.len() - 1]
}

/// Closes the gaps of a closed route. Without internal lanes, lanes may end short of each other; each lane gets half of a connecting
/// curve. SUMO's declared lengths stay as they are.
pub(super) fn bridge_gaps(lanes: &mut [RouteLane]) {
    for k in 0..lanes.len() {
        bridge_gap(lanes, k, (k + 1) % lanes.len());
    }
}

/// Closes the gaps of an open route. A gap that a driver would notice becomes a lane of its own, so that positions on all other lanes
/// remain those of the network. Smaller gaps are added to the adjacent lanes.
pub(super) fn with_bridges(lanes: Vec<RouteLane>) -> Vec<RouteLane> {
    let mut joined: Vec<RouteLane> = Vec::with_capacity(lanes.len());
    for lane in lanes {
        if let Some(before) = joined.last() {
            let (from, to) = (before.shape[before.shape.len() - 1], lane.shape[0]);
            if from.distance(to) >= BRIDGE_M {
                joined.push(bridge(before, &lane));
            }
        }
        joined.push(lane);
        let last = joined.len() - 1;
        if last > 0 {
            bridge_gap(&mut joined, last - 1, last);
        }
    }
    joined
}

/// Returns the curve over the gap between two lanes, as a lane with its drawn length.
fn bridge(before: &RouteLane, after: &RouteLane) -> RouteLane {
    let (first, second) = curve_across(&before.shape, &after.shape);
    let start = before.shape[before.shape.len() - 1];
    let shape: Vec<DVec2> = [start].into_iter().chain(first).chain(second).chain([after.shape[0]]).collect();
    RouteLane {
        lane: None,
        start_s_m: 0.0,
        length_m: shape_length_m(&shape),
        speed_limit_mps: before.speed_limit_mps.min(after.speed_limit_mps),
        width_m: before.width_m.min(after.width_m),
        shape,
    }
}

/// Adds half of a curve over the gap to each of two lanes.
fn bridge_gap(lanes: &mut [RouteLane], k: usize, next: usize) {
    let (from, to) = (lanes[k].shape[lanes[k].shape.len() - 1], lanes[next].shape[0]);
    let gap_m = from.distance(to);
    if gap_m < GAP_M {
        return;
    }
    let (first, second) = curve_across(&lanes[k].shape, &lanes[next].shape);
    lanes[k].shape.extend(first);
    lanes[next].shape.splice(0..0, second);
}

/// Returns the points of the curve from the end of one shape to the start of another, without these two: the first half up to the middle,
/// and the second half from there.
fn curve_across(before: &[DVec2], after: &[DVec2]) -> (Vec<DVec2>, Vec<DVec2>) {
    let (from, to) = (before[before.len() - 1], after[0]);
    let gap_m = from.distance(to);
    let reversed: Vec<DVec2> = after.iter().rev().copied().collect();
    let (out, back) = (end_direction(before), end_direction(&reversed));
    let (a, b) = (from + out * gap_m * 0.4, to + back * gap_m * 0.4);
    let halves = gap_m.ceil() as usize;
    let point = |i: usize| {
        let t = i as f64 / (2 * halves) as f64;
        let u = 1.0 - t;
        from * (u * u * u) + a * (3.0 * u * u * t) + b * (3.0 * u * t * t) + to * (t * t * t)
    };
    ((1..=halves).map(point).collect(), (halves..2 * halves).map(point).collect())
}

/// Returns the unit direction at the end of a shape.
fn end_direction(shape: &[DVec2]) -> DVec2 {
    let end = shape[shape.len() - 1];
    shape.iter().rev().find(|point| **point != end).map_or(DVec2::X, |point| (end - *point).normalize())
}
