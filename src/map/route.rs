//! Route of single lanes, closed or open, and the mappings between it and the world. `s_m` is the distance along the route in the
//! network's *declared* lane lengths (SUMO's lane positions add up to it), 0 at the start of the first lane. On a closed route it wraps
//! at [`Route::length_m`]. An open route continues straight beyond its ends, and positions before its start are negative. The lateral
//! offset is positive to the left.
//!
//! `path_lanes` has the network's lanes along a route, on which `stop_lines`, `yield_lines`, `lane_changes`, `turns` and
//! `guidance` lie.

mod guidance;
mod lane_changes;
mod path_lanes;
mod route_lane;
mod stop_lines;
mod turns;
mod yield_lines;

pub use guidance::{Manoeuvre, NextManoeuvre, PathGuidance};
pub use lane_changes::LaneChange;
pub use path_lanes::{PathLanes, is_against};
pub use route_lane::RouteLane;
pub use stop_lines::{StopLine, stop_lines};
pub use turns::Turns;
pub use yield_lines::{StopRule, YieldLine};

use super::network::{LaneId, Network, rounded_m};
use crate::space::{Pose, wrap_angle};
use glam::DVec2;

/// Returns the drawn length of one declared metre of a lane. A deviation of up to 5 %, which the corners of a bend's polygon may cut off,
/// counts as 1. So does a lane shorter than a car: points inside junctions are declared 0.1 m long and drawn without length.
fn drawn_scale(declared_m: f64, drawn_m: f64) -> f64 {
    const CUT_OFF: f64 = 0.05;
    const SHORT_M: f64 = 5.0;
    let scale = drawn_m / declared_m;
    let is_let_be = declared_m.min(drawn_m) < SHORT_M || (scale - 1.0).abs() <= CUT_OFF;
    if is_let_be { 1.0 } else { scale }
}

/// Position of a point of the world relative to the route.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoutePosition {
    /// Distance along the route, metres: in `0..length_m` on a closed route.
    pub s_m: f64,
    /// Lateral offset from the centre line, metres, positive to the left.
    pub offset_m: f64,
}

/// Chain of lanes. On a closed route, the end of the last lane is the start of the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    lanes: Vec<RouteLane>,
    /// Lanes of the network and their places in `lanes`, ascending.
    by_lane: Vec<(LaneId, u32)>,
    /// All segments of all shapes in order, for searching.
    segments: Vec<ShapeSegment>,
    /// Number of segments per metre, for the first guess of a search.
    segments_per_m: f64,
    length_m: f64,
    closed: bool,
    /// Positions along the route with their heights, ascending; empty for a flat route.
    heights: Vec<(f64, f64)>,
    /// Start of each lane and end of the route, in drawn metres; empty if all lanes are drawn as long as they are declared.
    drawn_starts_m: Vec<f64>,
}

#[derive(Clone, Debug, PartialEq)]
struct ShapeSegment {
    start: DVec2,
    end: DVec2,
    /// Route positions of the ends, metres.
    start_s_m: f64,
    end_s_m: f64,
    /// Drawn length of one declared metre of the segment's lane, see [`drawn_scale`].
    drawn_scale: f64,
    /// Length of the segment as drawn, metres.
    drawn_m: f64,
    /// Direction of the segment, radians from east.
    yaw_rad: f64,
    /// Joint to the next segment; unused for the last segment of an open route.
    joint: Joint,
    /// Way from the end of the segment to the next bend, declared metres; negative where the bend begins within the segment.
    straight_on_m: f64,
}

/// Turn from one segment to the next, spread evenly over the given length of either.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Joint {
    turn_rad: f64,
    before_m: f64,
    after_m: f64,
}

impl Joint {
    /// Returns true if the route turns here. Segments of a straight lane differ by rounding.
    fn is_bend(&self) -> bool {
        const STRAIGHT_RAD: f64 = 1e-9;
        self.turn_rad.abs() > STRAIGHT_RAD
    }
}

impl Route {
    /// Joins lanes to a closed route, and sets `start_s_m` of each.
    ///
    /// # Panics
    /// There is no lane, a lane has fewer than two distinct points, or a length is not positive: readers of files check that first.
    pub fn new(lanes: Vec<RouteLane>) -> Self {
        Self::chained(lanes, true)
    }

    /// Joins lanes to an open route, which ends with the last lane.
    ///
    /// # Panics
    /// As [`Route::new`].
    pub fn open(lanes: Vec<RouteLane>) -> Self {
        Self::chained(lanes, false)
    }

    /// Adds the heights of a network's lanes, found by lane id.
    #[must_use]
    pub fn with_heights(mut self, net: &Network) -> Self {
        self.heights.clear();
        for lane in &self.lanes {
            let Some(line) = lane.lane.map(|id| &net.lane(id).line) else { continue };
            let share = lane.length_m / line.length_m();
            let of = |(s_m, point): (&f64, &glam::DVec3)| (lane.start_s_m + s_m * share, point.z);
            self.heights.extend(line.positions_m().iter().zip(line.points()).map(of));
        }
        if self.heights.iter().all(|(_, z)| *z == 0.0) {
            self.heights.clear();
        }
        self
    }

    fn chained(mut lanes: Vec<RouteLane>, closed: bool) -> Self {
        assert!(!lanes.is_empty(), "a route has at least one lane");
        let mut segments = Vec::new();
        let mut length_m = 0.0;
        let (mut drawn_starts_m, mut is_to_scale) = (vec![0.0], true);
        for (k, lane) in lanes.iter_mut().enumerate() {
            let shape_length_m: f64 = lane.shape.windows(2).map(|p| p[0].distance(p[1])).sum();
            assert!(shape_length_m > 0.0 && lane.length_m > 0.0, "lane {k} has no length");
            let scale = lane.length_m / shape_length_m;
            let drawn_scale = drawn_scale(lane.length_m, shape_length_m);
            is_to_scale &= drawn_scale == 1.0;
            drawn_starts_m.push(drawn_starts_m[drawn_starts_m.len() - 1] + lane.length_m * drawn_scale);
            lane.start_s_m = length_m;
            let mut s_m = length_m;
            for pair in lane.shape.windows(2).filter(|p| p[0] != p[1]) {
                let segment = ShapeSegment::new([pair[0], pair[1]], s_m, scale, drawn_scale);
                s_m = segment.end_s_m;
                segments.push(segment);
            }
            length_m += lane.length_m;
            if let Some(last) = segments.last_mut() {
                last.end_s_m = length_m;
            }
        }
        let n = segments.len();
        for k in 0..n {
            segments[k].joint = segments[k].joint_to(&segments[(k + 1) % n]);
        }
        // Twice round, as a straight of a closed route can go over its end.
        for k in (0..2 * n).rev().map(|k| k % n) {
            let next = &segments[(k + 1) % n];
            let next_m = next.end_s_m - next.start_s_m + next.straight_on_m;
            segments[k].straight_on_m = match segments[k].joint {
                _ if k + 1 == n && !closed => f64::INFINITY,
                joint if joint.is_bend() => -joint.before_m,
                _ => next_m,
            };
        }
        let segments_per_m = segments.len() as f64 / length_m;
        if is_to_scale {
            drawn_starts_m.clear();
        }
        let numbered = (0..).zip(&lanes).filter_map(|(k, lane)| Some((lane.lane?, k)));
        let mut by_lane: Vec<(LaneId, u32)> = numbered.collect();
        by_lane.sort_unstable();
        Self { lanes, by_lane, segments, segments_per_m, length_m, closed, heights: Vec::new(), drawn_starts_m }
    }

    /// Returns true if the route is closed.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Returns the index of the next lane of the network after lane `k`; bridges are skipped. `None` at the end of an open route.
    pub fn next_lane(&self, k: usize) -> Option<usize> {
        let n = self.lanes.len();
        let after = (k + 1..if self.closed { k + 1 + n } else { n }).map(|k| k % n);
        after.into_iter().find(|k| !self.lanes[*k].is_bridge())
    }

    /// Returns the lanes in driving order.
    pub fn lanes(&self) -> &[RouteLane] {
        &self.lanes
    }

    /// Returns the length of the route, or of a lap, metres: the sum of the declared lane lengths.
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// Wraps `s_m` into `0..length_m` on a closed route; returns it unchanged on an open one, beyond the ends too.
    #[inline]
    pub fn wrap(&self, s_m: f64) -> f64 {
        // The common case; the remainder costs 10 ns.
        if !self.closed || (0.0..self.length_m).contains(&s_m) {
            return s_m;
        }
        let wrapped = s_m.rem_euclid(self.length_m);
        if wrapped < self.length_m { wrapped } else { 0.0 }
    }

    /// Returns the distance ahead from one position to another, metres: in `0..length_m` on a closed route; on an open one negative for
    /// positions behind.
    pub fn ahead(&self, from_s_m: f64, to_s_m: f64) -> f64 {
        self.wrap(to_s_m - from_s_m)
    }

    /// Returns the signed distance from one position to another, metres, positive ahead; on a closed route the shorter way round.
    pub fn difference(&self, from_s_m: f64, to_s_m: f64) -> f64 {
        let ahead = self.ahead(from_s_m, to_s_m);
        if self.closed && ahead > self.length_m / 2.0 { ahead - self.length_m } else { ahead }
    }

    /// Returns the index of the lane at `s_m` and the position on it, metres; beyond an end of an open route, the lane and position of
    /// that end.
    pub fn lane_at(&self, s_m: f64) -> (usize, f64) {
        let s_m = self.within(s_m);
        let index = self.lanes.partition_point(|lane| lane.start_s_m <= s_m) - 1;
        (index, (s_m - self.lanes[index].start_s_m).min(self.lanes[index].length_m))
    }

    /// Returns `s_m` wrapped on a closed route, or clamped to the ends of an open one.
    #[inline]
    fn within(&self, s_m: f64) -> f64 {
        if self.closed { self.wrap(s_m) } else { s_m.clamp(0.0, self.length_m) }
    }

    /// Returns the route position of a place along a lane of the network, in declared metres; `None` if the route does not go over that
    /// lane. On a route that goes over it twice it is the first place.
    pub fn s_on(&self, lane: LaneId, along_m: f64) -> Option<f64> {
        let first = self.by_lane.partition_point(|(other, _)| *other < lane);
        let (found, k) = self.by_lane.get(first)?;
        (*found == lane).then(|| self.wrap(self.lanes[*k as usize].start_s_m + along_m))
    }

    /// Returns the speed limit at `s_m`, m/s.
    pub fn speed_limit_mps(&self, s_m: f64) -> f64 {
        self.lanes[self.lane_at(s_m).0].speed_limit_mps
    }

    /// Returns the lane width at `s_m`, metres.
    pub fn width_m(&self, s_m: f64) -> f64 {
        self.lanes[self.lane_at(s_m).0].width_m
    }

    /// Returns the point of the centre line, world axes; beyond the ends of an open route straight on.
    #[inline]
    pub fn point_at(&self, s_m: f64) -> DVec2 {
        let s_m = self.wrap(s_m);
        let here = self.segment_at(self.within(s_m));
        let segment = &self.segments[here];
        let fraction = (s_m - segment.start_s_m) / (segment.end_s_m - segment.start_s_m);
        if self.is_beyond(here, fraction) {
            let beyond_m = if fraction < 0.0 { s_m } else { s_m - self.length_m };
            let beyond = DVec2::from_angle(segment.yaw_rad) * beyond_m;
            return if fraction < 0.0 { segment.start } else { segment.end } + beyond;
        }
        segment.start.lerp(segment.end, fraction.clamp(0.0, 1.0))
    }

    /// Returns true for a place before the first segment of an open route or beyond its last, by the fraction along that segment.
    #[inline]
    fn is_beyond(&self, segment: usize, fraction: f64) -> bool {
        !self.closed && ((segment == 0 && fraction < 0.0) || (segment + 1 == self.segments.len() && fraction > 1.0))
    }

    /// Returns the height of the centre line at `s_m`, metres; 0 on a route without heights.
    pub fn height_m(&self, s_m: f64) -> f64 {
        let s_m = self.within(s_m);
        self.heights_around(s_m).map_or(0.0, |[from, to]| {
            let fraction = if to.0 > from.0 { ((s_m - from.0) / (to.0 - from.0)).clamp(0.0, 1.0) } else { 0.0 };
            from.1 + (to.1 - from.1) * fraction
        })
    }

    /// Returns the grade at `s_m`, the tangent of the slope's angle, positive uphill.
    pub fn grade(&self, s_m: f64) -> f64 {
        let around = self.heights_around(self.within(s_m)).filter(|[from, to]| to.0 > from.0);
        around.map_or(0.0, |[from, to]| {
            let ground_m = self.point_at(from.0).distance(self.point_at(to.0));
            if ground_m > 0.0 { (to.1 - from.1) / ground_m } else { 0.0 }
        })
    }

    /// Returns the two neighbouring positions with known heights around a position within the route, and these heights.
    fn heights_around(&self, s_m: f64) -> Option<[(f64, f64); 2]> {
        let last = self.heights.len().checked_sub(1)?;
        let after = self.heights.partition_point(|(at_m, _)| *at_m <= s_m).clamp(1, last.max(1));
        Some([self.heights[after - 1], *self.heights.get(after)?])
    }

    /// Returns the direction of the centre line at `s_m`, radians from east, smooth across the joints of the shape. Around each joint it
    /// turns evenly from one segment's direction to the next, over half of either segment. The turn extends no further than the other
    /// segment is long, so that a bend of short chords does not reach far into a straight, and cuts at most 1.5 m of the corner. At the
    /// ends of an open route, and beyond, it is the direction of the first or last segment.
    pub fn yaw_at(&self, s_m: f64) -> f64 {
        let s_m = self.within(s_m);
        let n = self.segments.len();
        let here = self.segment_at(s_m);
        let after_start_m = s_m - self.segments[here].start_s_m;
        let length_m = self.segments[here].end_s_m - self.segments[here].start_s_m;
        let in_first_half = after_start_m < length_m / 2.0;
        if !self.closed && ((in_first_half && here == 0) || (!in_first_half && here + 1 == n)) {
            return self.segments[here].yaw_rad;
        }
        let (from, past_joint_m) =
            if in_first_half { ((here + n - 1) % n, after_start_m) } else { (here, after_start_m - length_m) };
        let ShapeSegment { yaw_rad, joint: Joint { turn_rad, before_m, after_m }, .. } = self.segments[from];
        let fraction = ((past_joint_m + before_m) / (before_m + after_m)).clamp(0.0, 1.0);
        wrap_angle(yaw_rad + turn_rad * fraction)
    }

    /// Returns the distance from `s_m` within which [`Route::yaw_at`] stays the same up to rounding, metres; 0 in a bend.
    pub fn straight_ahead_m(&self, s_m: f64) -> f64 {
        let s_m = self.within(s_m);
        let (n, k) = (self.segments.len(), self.segment_at(s_m));
        let here = &self.segments[k];
        let (before, from_start_m) = (self.segments[(k + n - 1) % n].joint, s_m - here.start_s_m);
        let is_in_bend = (self.closed || k > 0) && before.is_bend() && from_start_m < before.after_m;
        if is_in_bend { 0.0 } else { (here.end_s_m - s_m + here.straight_on_m).max(0.0) }
    }

    /// Returns the curvature at `s_m`, 1/m, positive to the left, as the turn over `window_m` around it.
    pub fn curvature_at(&self, s_m: f64, window_m: f64) -> f64 {
        let half = window_m / 2.0;
        wrap_angle(self.yaw_at(s_m + half) - self.yaw_at(s_m - half)) / window_m
    }

    /// Returns the drawn length of a declared metre at `s_m`: 1 unless the network declares the lane longer or shorter than it draws it.
    pub fn drawn_scale(&self, s_m: f64) -> f64 {
        self.segments[self.segment_at(self.within(s_m))].drawn_scale
    }

    /// Returns [`Route::ahead`] in metres as drawn: the distance that a driver sees and a brake needs.
    pub fn drawn_ahead_m(&self, from_s_m: f64, to_s_m: f64) -> f64 {
        let Some(lap_m) = self.drawn_starts_m.last() else { return self.ahead(from_s_m, to_s_m) };
        let drawn_m = |s_m: f64| {
            let (within_m, (lane, _)) = (self.within(s_m), self.lane_at(s_m));
            let on_lane_m = within_m - self.lanes[lane].start_s_m;
            // Beyond the ends of an open route, declared and drawn metres are equal.
            self.drawn_starts_m[lane] + on_lane_m * self.drawn_scale(s_m) + (self.wrap(s_m) - within_m)
        };
        let ahead_m = drawn_m(to_s_m) - drawn_m(from_s_m);
        if self.closed && ahead_m < 0.0 { ahead_m + lap_m } else { ahead_m }
    }

    /// Returns true for a ring: the curvature is constant to 5 %.
    pub fn is_ring(&self) -> bool {
        const SPAN_M: f64 = 10.0;
        let mean = std::f64::consts::TAU / self.length_m;
        let places = (self.length_m / SPAN_M).ceil() as usize * 2;
        (0..places).all(|i| {
            let bend = self.curvature_at(self.length_m * i as f64 / places as f64, SPAN_M).abs();
            (bend / mean - 1.0).abs() < 0.05
        })
    }

    /// Returns the centre pose of a vehicle of `length_m` with its front bumper at `s_m` on the centre line. Its rear points to the
    /// centre line `length_m` before, as SUMO places vehicles.
    #[inline]
    pub fn pose_of_front(&self, s_m: f64, length_m: f64) -> Pose {
        let front = self.point_at(s_m);
        let along = front - self.point_at(s_m - length_m);
        Pose::new(front - along.normalize() * (length_m / 2.0), along.y.atan2(along.x))
    }

    /// Returns the route position nearest to `point`. With `near_s_m`, only the stretch within 40 m of it is searched: this is faster,
    /// and correct where the route passes close to itself.
    pub fn project(&self, point: DVec2, near_s_m: Option<f64>) -> RoutePosition {
        const WINDOW_M: f64 = 40.0;
        let n = self.segments.len();
        let (first, count) = match near_s_m {
            Some(s_m) if self.length_m > 2.0 * WINDOW_M => {
                let first = self.segment_at(self.within(s_m - WINDOW_M));
                let last = self.segment_at(self.within(s_m + WINDOW_M));
                (first, (last + n - first) % n + 1)
            }
            _ => (0, n),
        };
        let mut best = (f64::INFINITY, 0, 0.0);
        // Segments further away than a known distance are skipped, except the end segments of an open route, which continue straight on.
        let known_m =
            near_s_m.map_or(f64::INFINITY, |s_m| self.segments[self.segment_at(self.within(s_m))].nearest(point).0);
        for index in (0..count).map(|i| (first + i) % n) {
            let may_go_on = !self.closed && (index == 0 || index + 1 == n);
            if !may_go_on && self.segments[index].is_beyond_reach(point, known_m.min(best.0)) {
                continue;
            }
            let (mut distance, mut fraction) = self.segments[index].nearest(point);
            let segment = &self.segments[index];
            let straight_on = if self.closed { fraction } else { segment.foot(point) };
            if self.is_beyond(index, straight_on) {
                (distance, fraction) = (point.distance(segment.start.lerp(segment.end, straight_on)), straight_on);
            }
            if distance < best.0 {
                best = (distance, index, fraction);
            }
        }
        let segment = &self.segments[best.1];
        let along = segment.end - segment.start;
        let side = along.perp_dot(point - segment.start).signum();
        let declared_m = if self.is_beyond(best.1, best.2) {
            // Beyond the ends, declared and drawn metres are equal.
            if best.2 < 0.0 { best.2 * along.length() } else { segment.end_s_m + (best.2 - 1.0) * along.length() }
        } else {
            segment.start_s_m + best.2 * (segment.end_s_m - segment.start_s_m)
        };
        RoutePosition { s_m: self.wrap(declared_m), offset_m: side * best.0 }
    }

    #[inline]
    fn segment_at(&self, wrapped_s_m: f64) -> usize {
        // Segments of about equal length are found at the first guess.
        let guess = (wrapped_s_m * self.segments_per_m) as usize;
        if self.segments.get(guess).is_some_and(|here| (here.start_s_m..here.end_s_m).contains(&wrapped_s_m)) {
            return guess;
        }
        self.segment_sought_at(wrapped_s_m)
    }

    #[cold]
    fn segment_sought_at(&self, wrapped_s_m: f64) -> usize {
        (self.segments.partition_point(|segment| segment.start_s_m <= wrapped_s_m) - 1).min(self.segments.len() - 1)
    }
}

impl ShapeSegment {
    /// Creates a segment that begins at `start_s_m`; `scale` is the number of declared metres per drawn metre.
    fn new([start, end]: [DVec2; 2], start_s_m: f64, scale: f64, drawn_scale: f64) -> Self {
        let drawn_m = start.distance(end);
        let along = end - start;
        let (end_s_m, yaw_rad) = (start_s_m + drawn_m * scale, along.y.atan2(along.x));
        Self {
            start,
            end,
            start_s_m,
            end_s_m,
            drawn_scale,
            drawn_m,
            yaw_rad,
            joint: Joint::default(),
            straight_on_m: 0.0,
        }
    }

    /// Returns the joint to the next segment: the turn takes half of either segment, but no more than the length of the other one and
    /// [`rounded_m`].
    fn joint_to(&self, next: &Self) -> Joint {
        let length_m = |segment: &Self| segment.end_s_m - segment.start_s_m;
        let turn_rad = wrap_angle(next.yaw_rad - self.yaw_rad);
        let most_m = rounded_m(turn_rad);
        let declared = |segment: &Self| most_m * length_m(segment) / segment.drawn_m;
        Joint {
            turn_rad,
            before_m: (length_m(self) / 2.0).min(length_m(next)).min(declared(self)),
            after_m: (length_m(next) / 2.0).min(length_m(self)).min(declared(next)),
        }
    }

    /// Returns true if no point of the segment is within `distance_m`. Rounding errs towards false.
    #[inline]
    fn is_beyond_reach(&self, point: DVec2, distance_m: f64) -> bool {
        let reach_m = (distance_m + self.drawn_m) * (1.0 + 1e-9);
        point.distance_squared(self.start) > reach_m * reach_m
    }

    /// Returns the fraction along the segment of a point's foot on its line, negative before the segment and above 1 beyond it.
    fn foot(&self, point: DVec2) -> f64 {
        let along = self.end - self.start;
        (point - self.start).dot(along) / along.length_squared()
    }

    /// Returns the distance to `point`, and the fraction along the segment of the nearest point.
    fn nearest(&self, point: DVec2) -> (f64, f64) {
        let along = self.end - self.start;
        let fraction = self.foot(point).clamp(0.0, 1.0);
        (point.distance(self.start + along * fraction), fraction)
    }
}

#[cfg(test)]
#[path = "route_tests.rs"]
mod tests;
