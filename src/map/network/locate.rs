//! Lane below a point. In: a point, with a heading if known, and the lane of the previous query as a hint. Out: the position in a lane,
//! or `None` if every centre line is further away than [`REACH_M`].
//!
//! Lanes overlap: inside junctions lanes cross and diverge, bridges lie above roads, and strips of narrow streets overlap. The lane is
//! chosen in this order:
//! 1. The hint's lane, as long as the point is in its strip: a vehicle that turns left stays on its lane through the junction.
//! 2. The nearest of the hint's lane, its successors, its predecessors and its neighbours, if the point is in its strip or at most a
//!    metre beside it.
//! 3. The nearest of all lanes whose strip contains the point; else the nearest of all lanes. Heights count.
//!
//! If a heading is given, steps 2 and 3 add a penalty to a line that points elsewhere: 2 m if it points across and 4 m if it points back,
//! more than a lane's width. A strip that contains the point then takes precedence only if it points less than a right angle away. Among
//! lanes equally near, the first in the file is taken. Walking areas are never found: their shape is an outline, not a line.

use super::{EdgeKind, LaneId, LanePosition, Network, Side, centre_line::Foot};
use crate::space::{Pose3, is_along, wrap_angle};
use glam::DVec3;

/// Largest distance between a point and the centre line of its lane, metres: the width of two lanes and a verge.
pub const REACH_M: f64 = 10.0;
/// Tolerance beside and beyond lanes near the hint, metres: for wheels on the verge, and for points between declared ends.
const BESIDE_M: f64 = 1.0;
/// Tolerance at the borders and ends of a lane's strip, metres: covers rounding.
const TOUCH_M: f64 = 1e-6;
/// Largest height difference between a point and a strip that contains it, metres: less than the clearance below a bridge.
const HEIGHT_M: f64 = 2.5;
/// Penalty of a line across the heading, metres.
const ACROSS_M: f64 = 2.0;

/// Best lane so far, with or without a heading to match.
struct NearestLane<'n> {
    net: &'n Network,
    yaw_rad: Option<f64>,
    /// True if the strip contains the point and, if a heading is given, points less than a right angle away.
    fits: bool,
    cost_m: f64,
    found: Option<(LaneId, Foot)>,
}

impl Network {
    /// Returns the position of a point in a lane, preferably near the lane `hint`. The head of this file defines the choice among
    /// overlapping lanes. `None` if no centre line is within [`REACH_M`]. Allocates nothing; the time does not grow with the network.
    pub fn locate(&self, point: DVec3, hint: Option<LaneId>) -> Option<LanePosition> {
        self.locate_heading(point, None, hint)
    }

    /// As [`Network::locate`], with the heading of the pose taken into account.
    pub fn locate_pose(&self, pose: &Pose3, hint: Option<LaneId>) -> Option<LanePosition> {
        self.locate_heading(pose.position, Some(pose.yaw_rad), hint)
    }

    /// Returns the position of a pose in the lane whose strip contains it and along which it points; `None` beside all lanes, or across them.
    pub fn lane_along(&self, pose: &Pose3, hint: Option<LaneId>) -> Option<LanePosition> {
        let (lane, foot) = self.foot(pose.position, Some(pose.yaw_rad), hint)?;
        let is_in = self.in_strip(lane, &foot) && is_along(pose.yaw_rad, foot.yaw_rad);
        is_in.then_some(LanePosition { lane, s_m: foot.s_m, offset_m: foot.offset_m })
    }

    /// Returns the position in one lane that is nearest to a point, at any distance.
    pub fn place_in(&self, lane: LaneId, point: DVec3) -> LanePosition {
        let Foot { s_m, offset_m, .. } = self.lane(lane).line.nearest(point);
        LanePosition { lane, s_m, offset_m }
    }

    fn locate_heading(&self, point: DVec3, yaw_rad: Option<f64>, hint: Option<LaneId>) -> Option<LanePosition> {
        let (lane, foot) = self.foot(point, yaw_rad, hint)?;
        Some(LanePosition { lane, s_m: foot.s_m, offset_m: foot.offset_m })
    }

    /// Returns the lane that [`Network::locate`] finds for a point, if the point is at most `beside_m` beside it or beyond an end of it.
    pub fn lane_under(&self, point: DVec3, beside_m: f64, hint: Option<LaneId>) -> Option<LaneId> {
        let is_under = |(lane, foot): &(LaneId, Foot)| {
            foot.offset_m.abs() <= self.lane(*lane).half_width_m() + beside_m && foot.miss_m <= beside_m
        };
        self.foot(point, None, hint).filter(is_under).map(|(lane, _)| lane)
    }

    /// Returns the radius of a circle around a point on the ground, metres, in which each point is at most `beside_m` beside a lane found
    /// near the lane `hint`; negative if there is none.
    pub fn clear_m(&self, point: DVec3, beside_m: f64, hint: Option<LaneId>) -> f64 {
        let Some((lane, foot)) = hint.and_then(|hint| self.near_lane(hint, point, None)) else { return -1.0 };
        let (line, border_m) = (&self.lane(lane).line, self.lane(lane).half_width_m() + beside_m);
        let points = line.points();
        let to_end_m = [points[0], points[points.len() - 1]].map(|end| (end - point).truncate().length());
        // Within it, no distance from the line differs by more than the radius, and no end of the line is nearest.
        let aside_m = line.most_rough * foot.offset_m.abs() + foot.miss_m;
        (border_m - aside_m).min(to_end_m[0].min(to_end_m[1]) - border_m)
    }

    fn foot(&self, point: DVec3, yaw_rad: Option<f64>, hint: Option<LaneId>) -> Option<(LaneId, Foot)> {
        let near_hint = hint.and_then(|hint| self.near_lane(hint, point, yaw_rad));
        near_hint.or_else(|| self.anywhere(point, yaw_rad))
    }

    fn near_lane(&self, hint: LaneId, point: DVec3, yaw_rad: Option<f64>) -> Option<(LaneId, Foot)> {
        if self.edge_of(hint).kind == EdgeKind::WalkingArea {
            return None;
        }
        let own = self.lane(hint).line.nearest(point);
        if self.in_strip(hint, &own) {
            return Some((hint, own));
        }
        let mut nearest = NearestLane::none(self, yaw_rad);
        nearest.offer(hint, own);
        let beside = [Side::Left, Side::Right].into_iter().filter_map(|side| self.neighbour(hint, side));
        let around = self.successors(hint).chain(self.predecessors(hint).iter().copied()).chain(beside);
        for lane in around.filter(|lane| self.edge_of(*lane).kind != EdgeKind::WalkingArea) {
            nearest.offer(lane, self.lane(lane).line.nearest(point));
        }
        nearest.found.filter(|(lane, foot)| self.near_strip(*lane, foot, BESIDE_M))
    }

    fn in_strip(&self, lane: LaneId, foot: &Foot) -> bool {
        self.near_strip(lane, foot, TOUCH_M)
    }

    fn near_strip(&self, lane: LaneId, foot: &Foot, beside_m: f64) -> bool {
        let border_m = self.lane(lane).half_width_m() + beside_m;
        foot.miss_m <= beside_m && foot.offset_m.abs() <= border_m && foot.above_m.abs() <= HEIGHT_M
    }

    fn anywhere(&self, point: DVec3, yaw_rad: Option<f64>) -> Option<(LaneId, Foot)> {
        let mut nearest = NearestLane::none(self, yaw_rad);
        for run in self.grid.near(point.truncate()) {
            let line = &self.lane(run.lane).line;
            for k in run.segments() {
                let rough_m = line.rough_distance_m(k, point);
                // A segment further away than four times the best cost cannot be nearer; it may still fit where the best does not.
                if rough_m <= REACH_M && (!nearest.fits || rough_m <= 4.0 * nearest.cost_m) {
                    nearest.offer(run.lane, line.foot(k, point));
                }
            }
        }
        nearest.found.filter(|(_, foot)| foot.distance_m <= REACH_M)
    }
}

impl<'n> NearestLane<'n> {
    fn none(net: &'n Network, yaw_rad: Option<f64>) -> Self {
        Self { net, yaw_rad, fits: false, cost_m: f64::INFINITY, found: None }
    }

    fn offer(&mut self, lane: LaneId, foot: Foot) {
        // 0 along the line, 1 across, 2 back.
        let turned = self.yaw_rad.map_or(0.0, |yaw_rad| 1.0 - wrap_angle(yaw_rad - foot.yaw_rad).cos());
        let fits = turned < 1.0 && self.net.in_strip(lane, &foot);
        let cost_m = foot.distance_m + ACROSS_M * turned;
        let first = self.found.is_none_or(|(found, _)| lane < found);
        let nearer = cost_m < self.cost_m || (cost_m == self.cost_m && first);
        if (fits && !self.fits) || (fits == self.fits && nearer) {
            (self.fits, self.cost_m, self.found) = (fits, cost_m, Some((lane, foot)));
        }
    }
}
