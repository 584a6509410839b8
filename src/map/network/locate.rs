//! From the world to a lane. In: a point, with a heading if there is one, and the lane where it was last. Out: the place in a lane,
//! or nothing further than [`REACH_M`] from every centre line.
//!
//! Lanes overlap: inside junctions ways cross and part from each other, bridges lie above roads, and strips of narrow streets
//! reach into each other. Which of them it is, is decided so:
//! 1. The hint's lane, as long as the point is in its strip: a car that turns left stays on its way through the junction.
//! 2. Of the lanes that follow the hint's, lead into it or lie beside it, and of itself, the one whose line is nearest, if the point is in
//!    its strip or at most a metre beside it.
//! 3. Of all lanes whose strip has the point, the one whose line is nearest; else of all lanes. Heights count.
//!
//! Where a heading is given, 2 and 3 count a line that points elsewhere as further away: by 2 m if it points across and by 4 m if it
//! points back, more than a lane's width; and a strip that has the point goes first only if it points less than a right angle away. Of lanes that are equally near, the first in the file is taken. Walking areas are not found: their shape is an outline, not a line.

use super::{EdgeKind, LaneId, LanePosition, Network, Side, centre_line::Foot};
use crate::space::{Pose3, wrap_angle};
use glam::DVec3;

/// The furthest that a point may be from a centre line to be in its lane, metres: two lanes' widths and a verge.
pub const REACH_M: f64 = 10.0;
/// How far beside or beyond a lane near the hint a point may be, metres: wheels on the verge, or between declared ends.
const BESIDE_M: f64 = 1.0;
/// How far beyond its borders and ends a point still counts as in a lane's strip, metres: what numbers round to.
const TOUCH_M: f64 = 1e-6;
/// How far above or below its line a point is in a lane's strip, metres: less than what is kept clear below a bridge.
const HEIGHT_M: f64 = 2.5;
/// What a line across the heading counts more, metres.
const ACROSS_M: f64 = 2.0;

/// The best lane so far, for something that points somewhere or nowhere.
struct Best<'n> {
    net: &'n Network,
    yaw_rad: Option<f64>,
    /// True if the strip has the point and points as it does.
    fits: bool,
    cost_m: f64,
    found: Option<(LaneId, Foot)>,
}

impl Network {
    /// The place in a lane of a point, near the lane `hint` if there is one; the head of this file says which where lanes overlap.
    /// `None` if no centre line is within [`REACH_M`]. Takes no memory, and time that does not grow with the network.
    pub fn locate(&self, point: DVec3, hint: Option<LaneId>) -> Option<LanePosition> {
        self.locate_heading(point, None, hint)
    }

    /// As [`Network::locate`], for something that points somewhere.
    pub fn locate_pose(&self, pose: &Pose3, hint: Option<LaneId>) -> Option<LanePosition> {
        self.locate_heading(pose.position, Some(pose.yaw_rad), hint)
    }

    /// The place in one lane that is nearest to a point, however far.
    pub fn place_in(&self, lane: LaneId, point: DVec3) -> LanePosition {
        let Foot { s_m, offset_m, .. } = self.lane(lane).line.nearest(point);
        LanePosition { lane, s_m, offset_m }
    }

    fn locate_heading(&self, point: DVec3, yaw_rad: Option<f64>, hint: Option<LaneId>) -> Option<LanePosition> {
        let near_hint = hint.and_then(|hint| self.near_lane(hint, point, yaw_rad));
        let (lane, foot) = near_hint.or_else(|| self.anywhere(point, yaw_rad))?;
        Some(LanePosition { lane, s_m: foot.s_m, offset_m: foot.offset_m })
    }

    fn near_lane(&self, hint: LaneId, point: DVec3, yaw_rad: Option<f64>) -> Option<(LaneId, Foot)> {
        if self.edge_of(hint).kind == EdgeKind::WalkingArea {
            return None;
        }
        let own = self.lane(hint).line.nearest(point);
        if self.in_strip(hint, &own) {
            return Some((hint, own));
        }
        let mut best = Best::none(self, yaw_rad);
        best.offer(hint, own);
        let beside = [Side::Left, Side::Right].into_iter().filter_map(|side| self.neighbour(hint, side));
        let around = self.successors(hint).chain(self.predecessors(hint).iter().copied()).chain(beside);
        for lane in around.filter(|lane| self.edge_of(*lane).kind != EdgeKind::WalkingArea) {
            best.offer(lane, self.lane(lane).line.nearest(point));
        }
        best.found.filter(|(lane, foot)| self.near_strip(*lane, foot, BESIDE_M))
    }

    fn in_strip(&self, lane: LaneId, foot: &Foot) -> bool {
        self.near_strip(lane, foot, TOUCH_M)
    }

    fn near_strip(&self, lane: LaneId, foot: &Foot, beside_m: f64) -> bool {
        let border_m = self.lane(lane).half_width_m() + beside_m;
        foot.miss_m <= beside_m && foot.offset_m.abs() <= border_m && foot.above_m.abs() <= HEIGHT_M
    }

    fn anywhere(&self, point: DVec3, yaw_rad: Option<f64>) -> Option<(LaneId, Foot)> {
        let mut best = Best::none(self, yaw_rad);
        for run in self.grid.near(point.truncate()) {
            let line = &self.lane(run.lane).line;
            for k in run.segments() {
                let rough_m = line.rough_distance_m(k, point);
                // One that is further than four times the best cannot be nearer, but it may fit where the best does not.
                if rough_m <= REACH_M && (!best.fits || rough_m <= 4.0 * best.cost_m) {
                    best.offer(run.lane, line.foot(k, point));
                }
            }
        }
        best.found.filter(|(_, foot)| foot.distance_m <= REACH_M)
    }
}

impl<'n> Best<'n> {
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
