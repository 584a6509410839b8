//! Centre line of a lane, and the mappings between it and the world. In: the shape of a lane and its declared length. Out: the pose at a
//! position in the lane, and the position nearest to a point. Metres; s in declared metres, offset positive to the left.
//!
//! A lane is a strip. At a corner of its line the strip is mitred: both sides meet on the bisector of the angle, as the edges of a road
//! do. Each piece of the strip is a quadrilateral whose sides run along its segment. Both mappings are therefore a few multiplications,
//! and each is the exact inverse of the other. There are two exceptions. On the inside of a tight bend, beyond the
//! centre of its circle, the quadrilateral is turned inside out. On the inside of tight bends a strip may overlap itself, and a point has two positions; the one nearer to the
//! line is found.

use crate::space::{Pose3, wrap_angle};
use glam::{DVec2, DVec3};
use std::iter;

/// Points closer than this on the ground count as one, metres.
const SAME_M: f64 = 1e-6;
/// Number of segments that a search for the nearest one leaves out at once.
const BLOCK: usize = 8;
/// Extent given to a line that is one point, metres: netconvert writes internal lanes of a junction without extent as a point.
const EXTENT_M: f64 = 1e-4;
/// Largest lean of a mitre, as the tangent of half the turn: a corner of 150 degrees. Beyond it, the strip has a gap.
const MOST_LEAN: f64 = 3.732;

/// Returns the distance on either side of a corner over which a line is rounded at most, metres. An arc that begins there passes the
/// corner at 1.5 m; drivers do not cut more of a lane. Without this bound, a corner between two long pieces would look like a wide bend.
pub(in crate::map) fn rounded_m(turn_rad: f64) -> f64 {
    const CUT_M: f64 = 1.5;
    CUT_M / (turn_rad.abs() / 4.0).tan()
}

/// Centre line of a lane: points with their positions.
#[derive(Clone, Debug, PartialEq)]
pub struct CentreLine {
    /// At least two points; consecutive ones differ on the ground.
    points: Box<[DVec3]>,
    /// Position of each point, declared metres; the last is the lane's length.
    positions_m: Box<[f64]>,
    /// Directions and leans, which both mappings need in each tick.
    segments: Box<[Segment]>,
    /// Least and greatest corner, on the ground, of each [`BLOCK`] of segments.
    blocks: Box<[[DVec2; 2]]>,
    /// Largest ratio of [`CentreLine::rough_distance_m`] to the distance of [`CentreLine::foot`], at the sharpest corner: 1 to 4.
    pub(super) most_rough: f64,
}

/// Foot of a point: the place on a line that is nearest to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Foot {
    /// Position from the lane's start, declared metres.
    pub s_m: f64,
    /// Metres from the line, positive to the left.
    pub offset_m: f64,
    /// Distance on the ground between the place found and the point, metres: 0 except for points before the start or beyond the end.
    pub miss_m: f64,
    /// Height of the point above the line, metres.
    pub above_m: f64,
    /// Distance between the point and the line, metres; if no piece of the strip contains the point, the miss distance is added.
    pub distance_m: f64,
    /// Heading of the line at the foot, radians.
    pub yaw_rad: f64,
}

/// One segment: direction and length on the ground, heading, and the leans of the mitres at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    along: DVec2,
    length_m: f64,
    yaw_rad: f64,
    lean_start: f64,
    lean_end: f64,
}

impl Segment {
    /// Returns the length of the parallel at `offset_m`, metres; not positive where the piece is turned inside out.
    fn parallel_m(&self, offset_m: f64) -> f64 {
        self.length_m + offset_m * (self.lean_end - self.lean_start)
    }
}

impl CentreLine {
    /// Builds the line through `shape`. A single point gets an extent of 0.1 mm in the direction `heading`.
    pub(super) fn new(shape: &[DVec3], length_m: f64, heading: DVec2) -> Self {
        let mut points: Vec<DVec3> = Vec::with_capacity(shape.len());
        for point in shape {
            if points.last().is_none_or(|last| last.truncate().distance(point.truncate()) >= SAME_M) {
                points.push(*point);
            }
        }
        if points.len() < 2 {
            let point = points.first().copied().unwrap_or_default();
            points = vec![point - (heading * EXTENT_M).extend(0.0), point];
        }
        let drawn_m: f64 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        let mut positions_m = Vec::with_capacity(points.len());
        let mut so_far_m = 0.0;
        positions_m.push(0.0);
        for pair in points.windows(2) {
            so_far_m += pair[0].distance(pair[1]);
            positions_m.push(so_far_m / drawn_m * length_m);
        }
        if let Some(last) = positions_m.last_mut() {
            *last = length_m;
        }
        Self::through(points.into(), positions_m.into())
    }

    /// Returns the line shifted by `by`, metres.
    pub(super) fn moved_by(&self, by: DVec3) -> Self {
        let points: Box<[DVec3]> = self.points.iter().map(|point| *point + by).collect();
        Self::through(points, self.positions_m.clone())
    }

    fn through(points: Box<[DVec3]>, positions_m: Box<[f64]>) -> Self {
        let blocks = (0..points.len() - 1).step_by(BLOCK).map(|first| {
            let ends = points[first..].iter().take(BLOCK + 1).map(|point| point.truncate());
            ends.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[least, most], at| [least.min(at), most.max(at)])
        });
        let segments = segments(&points);
        let most_lean = segments.iter().map(|segment| segment.lean_start.abs()).fold(0.0, f64::max);
        // The side of a strip is as much longer than its width at a corner. The rest covers rounding.
        let most_rough = most_lean.hypot(1.0) + 1e-9;
        Self { segments, blocks: blocks.collect(), most_rough, points, positions_m }
    }

    /// Returns the points; no two consecutive ones coincide on the ground.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Returns the position of each point, declared metres; the last is the lane's length.
    pub fn positions_m(&self) -> &[f64] {
        &self.positions_m
    }

    /// Returns the declared length, metres.
    pub fn length_m(&self) -> f64 {
        self.positions_m[self.positions_m.len() - 1]
    }

    /// Returns the length as drawn, heights included, metres.
    pub fn drawn_m(&self) -> f64 {
        self.points.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }

    /// Returns the direction at the end on the ground, unit length.
    pub fn end_direction(&self) -> DVec2 {
        self.segments[self.segments.len() - 1].along
    }

    /// Returns the direction at the start on the ground, unit length.
    pub fn start_direction(&self) -> DVec2 {
        self.segments[0].along
    }

    fn segment_at(&self, s_m: f64) -> usize {
        let after = self.positions_m.partition_point(|position| *position <= s_m);
        after.clamp(1, self.segments.len()) - 1
    }

    /// Returns the pose at a position, clamped to the lane, and an offset.
    pub fn pose(&self, s_m: f64, offset_m: f64) -> Pose3 {
        let s_m = s_m.clamp(0.0, self.length_m());
        let k = self.segment_at(s_m);
        let (segment, start) = (&self.segments[k], self.points[k]);
        let rise_m = self.points[k + 1].z - start.z;
        let (from_m, to_m) = (self.positions_m[k], self.positions_m[k + 1]);
        let fraction = if to_m > from_m { ((s_m - from_m) / (to_m - from_m)).clamp(0.0, 1.0) } else { 0.0 };
        let along_m = offset_m * segment.lean_start + fraction * segment.parallel_m(offset_m);
        let ground = start.truncate() + segment.along * along_m + segment.along.perp() * offset_m;
        Pose3 {
            position: ground.extend(start.z + fraction * rise_m),
            yaw_rad: self.yaw_at(k, s_m),
            grade: rise_m / segment.length_m,
        }
    }

    /// Returns the direction at `s_m` in segment `here`, smooth across the joints as in [`Route`](crate::map::Route). Around each joint
    /// it turns evenly, over half of either segment, but no further than the other segment is long and cutting at most 1.5 m of the
    /// corner. At the lane's ends it is the direction of the segment.
    fn yaw_at(&self, here: usize, s_m: f64) -> f64 {
        let length_m = |k: usize| self.positions_m[k + 1] - self.positions_m[k];
        let yaw = |k: usize| self.segments[k].yaw_rad;
        let after_start_m = s_m - self.positions_m[here];
        let (from, to, past_joint_m) = if after_start_m < length_m(here) / 2.0 {
            if here == 0 {
                return yaw(here);
            }
            (here - 1, here, after_start_m)
        } else {
            if here + 1 == self.segments.len() {
                return yaw(here);
            }
            (here, here + 1, after_start_m - length_m(here))
        };
        let turn = wrap_angle(yaw(to) - yaw(from));
        let most_m = rounded_m(turn);
        let declared = |k: usize| most_m * length_m(k) / self.segments[k].length_m;
        let before_joint_m = (length_m(from) / 2.0).min(length_m(to)).min(declared(from));
        let after_joint_m = (length_m(to) / 2.0).min(length_m(from)).min(declared(to));
        let around_m = before_joint_m + after_joint_m;
        let fraction = if around_m > 0.0 { ((past_joint_m + before_joint_m) / around_m).clamp(0.0, 1.0) } else { 0.0 };
        wrap_angle(yaw(from) + turn * fraction)
    }

    /// Returns the distance on the ground between a point and segment `k`, metres. It is cheap, and at most four times the distance of
    /// [`CentreLine::foot`]: a mitre of 150 degrees is 3.9 times as long as its strip is wide.
    pub(super) fn rough_distance_m(&self, k: usize, point: DVec3) -> f64 {
        let (segment, there) = (&self.segments[k], (point - self.points[k]).truncate());
        let along_m = there.dot(segment.along).clamp(0.0, segment.length_m);
        (there - segment.along * along_m).length()
    }

    /// Returns the place in segment `k` that is nearest to a point.
    pub(super) fn foot(&self, k: usize, point: DVec3) -> Foot {
        let (segment, start) = (&self.segments[k], self.points[k]);
        let there = (point - start).truncate();
        let offset_m = segment.along.perp_dot(there);
        let along_m = segment.along.dot(there);
        let parallel_m = segment.parallel_m(offset_m);
        let fraction = if parallel_m > SAME_M * segment.length_m {
            (along_m - offset_m * segment.lean_start) / parallel_m
        } else {
            along_m / segment.length_m
        };
        let beside = (0.0..=1.0).contains(&fraction);
        let fraction = fraction.clamp(0.0, 1.0);
        let beyond_m = along_m - offset_m * segment.lean_start - fraction * parallel_m;
        let above_m = point.z - start.z - fraction * (self.points[k + 1].z - start.z);
        let (from_m, to_m) = (self.positions_m[k], self.positions_m[k + 1]);
        // In a piece, the distance is that to its line. Pieces of a wavy line overlap slightly; a piece that contains the point takes
        // precedence over one near it.
        let ground_m = if beside { offset_m.abs() } else { self.rough_distance_m(k, point) + beyond_m.abs() };
        Foot {
            s_m: from_m + fraction * (to_m - from_m),
            offset_m,
            miss_m: beyond_m.abs(),
            above_m,
            distance_m: DVec2::new(ground_m, above_m).length(),
            yaw_rad: segment.yaw_rad,
        }
    }

    /// Returns the place on the line that is nearest to a point.
    pub(super) fn nearest(&self, point: DVec3) -> Foot {
        let ground = point.truncate();
        let away_m2 = |block: usize| {
            let [least, most] = self.blocks[block];
            ground.distance_squared(ground.clamp(least, most))
        };
        // The search begins in the block that is nearest, so that almost all others are left out.
        let (first, _) = (0..self.blocks.len()).fold((0, f64::INFINITY), |nearest, block| {
            let here_m2 = away_m2(block);
            if here_m2 < nearest.1 { (block, here_m2) } else { nearest }
        });
        let (mut at, mut best) = (first * BLOCK, self.foot(first * BLOCK, point));
        let others = (0..self.blocks.len()).filter(|block| *block != first);
        for block in iter::once(first).chain(others) {
            let reach_m = self.most_rough * best.distance_m;
            if away_m2(block) > reach_m * reach_m {
                continue;
            }
            for k in block * BLOCK..self.segments.len().min((block + 1) * BLOCK) {
                if self.rough_distance_m(k, point) > self.most_rough * best.distance_m {
                    continue;
                }
                let foot = self.foot(k, point);
                // Of two places equally near, the first along the line counts.
                if foot.distance_m < best.distance_m || (foot.distance_m == best.distance_m && k < at) {
                    (at, best) = (k, foot);
                }
            }
        }
        best
    }
}

/// Returns the segments between these points.
fn segments(points: &[DVec3]) -> Box<[Segment]> {
    let step = |k: usize| (points[k + 1] - points[k]).truncate();
    let direction = |k: usize| step(k) / step(k).length();
    let last = points.len() - 1;
    // The lean of the mitre at a point: the tangent of half the turn, positive to the left.
    let lean = |k: usize| {
        if k == 0 || k == last {
            return 0.0;
        }
        let (before, after) = (direction(k - 1), direction(k));
        let halved = 1.0 + before.dot(after);
        (before.perp_dot(after) / halved.max(1e-12)).clamp(-MOST_LEAN, MOST_LEAN)
    };
    let segment = |k: usize| Segment {
        along: direction(k),
        length_m: step(k).length(),
        yaw_rad: direction(k).to_angle(),
        lean_start: lean(k),
        lean_end: -lean(k + 1),
    };
    (0..last).map(segment).collect()
}

#[cfg(test)]
mod tests {
    use super::CentreLine;

    impl CentreLine {
        /// Returns the offsets between which no piece of the strip is turned inside out, metres: right (negative) and left. On the inside of
        /// a tight bend a wide lane extends beyond them; a place there has no unique position.
        pub fn unfolded(&self) -> (f64, f64) {
            let mut limits = (f64::NEG_INFINITY, f64::INFINITY);
            for segment in &self.segments {
                let leans = segment.lean_end - segment.lean_start;
                if leans < 0.0 {
                    limits.1 = limits.1.min(segment.length_m / -leans);
                } else if leans > 0.0 {
                    limits.0 = limits.0.max(-segment.length_m / leans);
                }
            }
            limits
        }
    }
}
