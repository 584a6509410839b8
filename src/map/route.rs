//! A closed route of single lanes, and the two ways between it and the world. `s_m` is the distance along the route in
//! the network's *declared* lane lengths (SUMO's lane positions add up to it), 0 at the start of the first lane and
//! wrapping at [`Route::length_m`]; the lateral offset is positive to the left.

use crate::space::{Pose, wrap_angle};
use glam::DVec2;

/// One lane of the route.
#[derive(Clone, Debug, PartialEq)]
pub struct RouteLane {
    /// SUMO's lane id, for example `e0_0`.
    pub id: String,
    /// SUMO's edge id; begins with a colon on a junction's inside.
    pub edge: String,
    /// Where on the route the lane begins, metres.
    pub start_s_m: f64,
    /// Declared length, metres. May differ a little from the length of the shape.
    pub length_m: f64,
    /// Speed limit, m/s.
    pub speed_limit_mps: f64,
    /// Width, metres.
    pub width_m: f64,
    /// Centre line, world axes, at least two points.
    pub shape: Vec<DVec2>,
}

/// A point of the world as the route sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoutePosition {
    /// Distance along the route, metres, in `0..length_m`.
    pub s_m: f64,
    /// Lateral offset from the centre line, metres, positive to the left.
    pub offset_m: f64,
}

/// A closed chain of lanes: the end of the last is the start of the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    lanes: Vec<RouteLane>,
    /// All segments of all shapes in order, for searching.
    segments: Vec<ShapeSegment>,
    length_m: f64,
}

#[derive(Clone, Debug, PartialEq)]
struct ShapeSegment {
    start: DVec2,
    end: DVec2,
    /// Route distances of the ends.
    start_s_m: f64,
    end_s_m: f64,
}

impl Route {
    /// Joins lanes to a closed route; `start_s_m` of each is set here.
    ///
    /// # Panics
    /// If there is no lane, or a lane has fewer than two distinct points or a length that is not positive: readers of files check
    /// that first.
    pub fn new(mut lanes: Vec<RouteLane>) -> Self {
        assert!(!lanes.is_empty(), "a route has at least one lane");
        let mut segments = Vec::new();
        let mut length_m = 0.0;
        for lane in &mut lanes {
            let shape_length_m: f64 = lane.shape.windows(2).map(|p| p[0].distance(p[1])).sum();
            assert!(shape_length_m > 0.0 && lane.length_m > 0.0, "lane {} has no length", lane.id);
            let scale = lane.length_m / shape_length_m;
            lane.start_s_m = length_m;
            let mut s_m = length_m;
            for pair in lane.shape.windows(2).filter(|p| p[0] != p[1]) {
                let end_s_m = s_m + pair[0].distance(pair[1]) * scale;
                segments.push(ShapeSegment { start: pair[0], end: pair[1], start_s_m: s_m, end_s_m });
                s_m = end_s_m;
            }
            length_m += lane.length_m;
            if let Some(last) = segments.last_mut() {
                last.end_s_m = length_m;
            }
        }
        Self { lanes, segments, length_m }
    }

    /// The lanes in driving order.
    pub fn lanes(&self) -> &[RouteLane] {
        &self.lanes
    }

    /// Length of one lap, metres: the sum of the declared lane lengths.
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// `s_m` brought into `0..length_m`.
    pub fn wrap(&self, s_m: f64) -> f64 {
        // Nearly always; the remainder costs 10 ns.
        if (0.0..self.length_m).contains(&s_m) {
            return s_m;
        }
        let wrapped = s_m.rem_euclid(self.length_m);
        if wrapped < self.length_m { wrapped } else { 0.0 }
    }

    /// The way ahead from one route distance to another, metres, in `0..length_m`.
    pub fn ahead(&self, from_s_m: f64, to_s_m: f64) -> f64 {
        self.wrap(to_s_m - from_s_m)
    }

    /// The shorter signed way from one route distance to another, metres, positive ahead.
    pub fn difference(&self, from_s_m: f64, to_s_m: f64) -> f64 {
        let ahead = self.ahead(from_s_m, to_s_m);
        if ahead > self.length_m / 2.0 { ahead - self.length_m } else { ahead }
    }

    /// Index of the lane at `s_m` and the position on it, metres.
    pub fn lane_at(&self, s_m: f64) -> (usize, f64) {
        let s_m = self.wrap(s_m);
        let index = self.lanes.partition_point(|lane| lane.start_s_m <= s_m) - 1;
        (index, (s_m - self.lanes[index].start_s_m).min(self.lanes[index].length_m))
    }

    /// Route distance of a position on a lane, if the lane, or another lane of its edge, belongs to the route.
    pub fn s_of(&self, lane_id: &str, position_m: f64) -> Option<f64> {
        // SUMO's lane ids are `<edge>_<index>`, the index having no underscore.
        let edge = lane_id.rsplit_once('_')?.0;
        let same_lane = self.lanes.iter().find(|lane| lane.id == lane_id);
        let lane = same_lane.or_else(|| self.lanes.iter().find(|lane| lane.edge == edge))?;
        Some(self.wrap(lane.start_s_m + position_m))
    }

    /// Speed limit at `s_m`, m/s.
    pub fn speed_limit_mps(&self, s_m: f64) -> f64 {
        self.lanes[self.lane_at(s_m).0].speed_limit_mps
    }

    /// Lane width at `s_m`, metres.
    pub fn width_m(&self, s_m: f64) -> f64 {
        self.lanes[self.lane_at(s_m).0].width_m
    }

    /// Point of the centre line, world axes.
    pub fn point_at(&self, s_m: f64) -> DVec2 {
        let s_m = self.wrap(s_m);
        let segment = &self.segments[self.segment_at(s_m)];
        let fraction = (s_m - segment.start_s_m) / (segment.end_s_m - segment.start_s_m);
        segment.start.lerp(segment.end, fraction.clamp(0.0, 1.0))
    }

    /// Direction of the centre line at `s_m`, radians from east, smooth across the joints of the shape: around each joint
    /// it turns evenly from one segment's direction to the next, over half of either segment but no further than the
    /// other one is long, so that a bend of short chords does not reach far into a straight.
    pub fn yaw_at(&self, s_m: f64) -> f64 {
        let s_m = self.wrap(s_m);
        let n = self.segments.len();
        let here = self.segment_at(s_m);
        let length_m = |i: usize| self.segments[i].end_s_m - self.segments[i].start_s_m;
        let after_start_m = s_m - self.segments[here].start_s_m;
        let (from, to) =
            if after_start_m < length_m(here) / 2.0 { ((here + n - 1) % n, here) } else { (here, (here + 1) % n) };
        let before_joint_m = (length_m(from) / 2.0).min(length_m(to));
        let after_joint_m = (length_m(to) / 2.0).min(length_m(from));
        let past_joint_m = if to == here { after_start_m } else { after_start_m - length_m(here) };
        let fraction = ((past_joint_m + before_joint_m) / (before_joint_m + after_joint_m)).clamp(0.0, 1.0);
        let turn = wrap_angle(self.segments[to].yaw() - self.segments[from].yaw());
        wrap_angle(self.segments[from].yaw() + turn * fraction)
    }

    /// Curvature at `s_m`, 1/m, positive to the left, as the turn over `window_m` around it.
    pub fn curvature_at(&self, s_m: f64, window_m: f64) -> f64 {
        let half = window_m / 2.0;
        wrap_angle(self.yaw_at(s_m + half) - self.yaw_at(s_m - half)) / window_m
    }

    /// True of a ring: the curvature is the same everywhere, to 5 %.
    pub fn is_ring(&self) -> bool {
        const SPAN_M: f64 = 10.0;
        let mean = std::f64::consts::TAU / self.length_m;
        let places = (self.length_m / SPAN_M).ceil() as usize * 2;
        (0..places).all(|i| {
            let bend = self.curvature_at(self.length_m * i as f64 / places as f64, SPAN_M).abs();
            (bend / mean - 1.0).abs() < 0.05
        })
    }

    /// Centre pose of a car of `length_m` whose front bumper is at `s_m` on the centre line and whose rear points to where the
    /// line was `length_m` before, as SUMO places cars.
    pub fn pose_of_front(&self, s_m: f64, length_m: f64) -> Pose {
        let front = self.point_at(s_m);
        let along = front - self.point_at(s_m - length_m);
        Pose::new(front - along.normalize() * (length_m / 2.0), along.y.atan2(along.x))
    }

    /// The route point nearest to `point`. With `near_s_m`, only the stretch within 40 m of it is searched: faster, and
    /// the right one where the route passes close to itself.
    pub fn project(&self, point: DVec2, near_s_m: Option<f64>) -> RoutePosition {
        const WINDOW_M: f64 = 40.0;
        let n = self.segments.len();
        let (first, count) = match near_s_m {
            Some(s_m) if self.length_m > 2.0 * WINDOW_M => {
                let first = self.segment_at(self.wrap(s_m - WINDOW_M));
                let last = self.segment_at(self.wrap(s_m + WINDOW_M));
                (first, (last + n - first) % n + 1)
            }
            _ => (0, n),
        };
        let mut best = (f64::INFINITY, 0, 0.0);
        for index in (0..count).map(|i| (first + i) % n) {
            let (distance, fraction) = self.segments[index].nearest(point);
            if distance < best.0 {
                best = (distance, index, fraction);
            }
        }
        let segment = &self.segments[best.1];
        let along = segment.end - segment.start;
        let side = along.perp_dot(point - segment.start).signum();
        RoutePosition {
            s_m: self.wrap(segment.start_s_m + best.2 * (segment.end_s_m - segment.start_s_m)),
            offset_m: side * best.0,
        }
    }

    fn segment_at(&self, wrapped_s_m: f64) -> usize {
        // Segments of about equal length are found at the first guess.
        let guess = (wrapped_s_m / self.length_m * self.segments.len() as f64) as usize;
        if self.segments.get(guess).is_some_and(|here| (here.start_s_m..here.end_s_m).contains(&wrapped_s_m)) {
            return guess;
        }
        (self.segments.partition_point(|segment| segment.start_s_m <= wrapped_s_m) - 1).min(self.segments.len() - 1)
    }
}

impl ShapeSegment {
    fn yaw(&self) -> f64 {
        let along = self.end - self.start;
        along.y.atan2(along.x)
    }

    /// Distance of `point` and the fraction along the segment of its foot.
    fn nearest(&self, point: DVec2) -> (f64, f64) {
        let along = self.end - self.start;
        let fraction = ((point - self.start).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (point.distance(self.start + along * fraction), fraction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A circle of 100 m declared length in two lanes, 200 points.
    fn circle() -> Route {
        let r = 100.0 / TAU;
        let lane = |k: usize| RouteLane {
            id: format!("e{k}_0"),
            edge: format!("e{k}"),
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
        assert_eq!(route.s_of("e1_0", 3.0), Some(53.0));
        assert_eq!(route.difference(99.0, 2.0), 3.0);
        assert_eq!(route.difference(2.0, 99.0), -3.0);
        assert_eq!(route.wrap(-1e-18), 0.0);
    }

    #[test]
    fn a_point_projects_back_to_where_it_came_from() {
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
    fn heading_and_curvature_of_a_circle_are_the_circles() {
        let route = circle();
        for i in 0..997 {
            let s_m = i as f64 * 0.1003;
            let expected = wrap_angle(TAU * s_m / 100.0 + TAU / 4.0);
            assert!(wrap_angle(route.yaw_at(s_m) - expected).abs() < 1e-6, "{s_m}");
            assert!((route.curvature_at(s_m, 4.0) - TAU / 100.0).abs() < 1e-6, "{s_m}");
        }
    }
}
