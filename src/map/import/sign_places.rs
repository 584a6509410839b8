//! Places of signs at the roads of a network. In: a node of OpenStreetMap in the network's frame, with its neighbours on its ways, and those
//! for whom its signs hold. Out: signs beside the road, which face those drivers. Metres.

use super::sign_tags::HoldsFor;
use crate::map::{
    network::{JunctionId, LaneId, LanePosition, Network},
    surroundings::{BESIDE_M, StatedSign, StatedSignKind},
};
use glam::DVec2;
use std::collections::{BTreeMap, BTreeSet};

/// Largest distance between a node and the middle of a lane that its signs hold for: that of one on a way, and of one beside the road.
const ON_WAY_M: f64 = 15.0;
const NEAR_ROAD_M: f64 = 25.0;
/// Least distance of a sign from the end of its lane.
const BEFORE_END_M: f64 = 1.0;
/// Least distance between a sign beside the road and the road's edge, at which it keeps its own place.
const FREE_M: f64 = 0.4;
/// Largest number of streets that are followed to a junction.
const MOST_STREETS: usize = 20;
/// Least cosine of the angle between a lane and those for whom a sign holds: 60 degrees.
const ALONG: f64 = 0.5;

const NO_ROAD: &str = "no road of the network is near";
const NO_DIRECTION: &str = "the file does not say for which direction they hold";
const NOT_FOR_CARS: &str = "they stand at ways that are not for cars";

/// Node with signs in the network's frame.
#[derive(Debug)]
pub(super) struct NodeAtRoad {
    pub at: DVec2,
    /// Neighbours before and after it on each way for cars that it is on.
    pub around: Vec<[Option<DVec2>; 2]>,
    /// True if it is on another way.
    pub is_on_path: bool,
}

impl NodeAtRoad {
    /// Returns the direction of the way at the node, unit length; that of a way that goes on beyond the node comes first.
    fn direction(&self) -> Option<DVec2> {
        let through = self.around.iter().find(|[before, after]| before.is_some() && after.is_some());
        let [before, after] = through.or(self.around.first())?;
        (after.unwrap_or(self.at) - before.unwrap_or(self.at)).try_normalize()
    }

    /// Returns the number of roads that lead away from the node.
    fn arms(&self) -> usize {
        self.around.iter().flatten().flatten().count()
    }
}

/// Lanes for cars, to be looked up by their place on the ground whatever their height.
pub(super) struct CarLanes<'net> {
    net: &'net Network,
    /// Lanes of streets with the corners of the boxes around them.
    boxes: Vec<(LaneId, [DVec2; 2])>,
    /// Junctions at which streets lead to or from at least three others.
    meetings: BTreeSet<JunctionId>,
}

/// Place on a lane.
#[derive(Clone, Copy, Debug)]
struct LaneFoot {
    lane: LaneId,
    /// Direction of the lane there, unit length.
    along: DVec2,
    /// Distance of the place from the lane's start, as drawn.
    row_m: f64,
    /// Distance of the point from the place.
    off_m: f64,
}

impl<'net> CarLanes<'net> {
    /// Sorts the lanes of a network.
    pub fn of(net: &'net Network) -> Self {
        let driven = net.lane_ids().filter(|lane| net.is_driven(*lane) && net.lane(*lane).admits_cars());
        let bounds = |lane: LaneId| {
            let points = net.lane(lane).line.points().iter().map(|point| point.truncate());
            points.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
        };
        let mut around: BTreeMap<JunctionId, BTreeSet<JunctionId>> = BTreeMap::new();
        for edge in net.edges().iter().filter(|edge| edge.kind.is_street()) {
            if let (Some(from), Some(to)) = (edge.from, edge.to) {
                around.entry(from).or_default().insert(to);
                around.entry(to).or_default().insert(from);
            }
        }
        let meetings = around.into_iter().filter(|(_, others)| others.len() > 2).map(|(junction, _)| junction);
        Self { net, boxes: driven.map(|lane| (lane, bounds(lane))).collect(), meetings: meetings.collect() }
    }

    /// Returns the signs of one kind at a node: one, or one for each direction.
    ///
    /// # Errors
    /// The reason why it is left out.
    pub fn signs(
        &self,
        node: &NodeAtRoad,
        kind: StatedSignKind,
        holds: HoldsFor,
    ) -> Result<Vec<StatedSign>, &'static str> {
        if node.around.is_empty() {
            if node.is_on_path {
                return Err(NOT_FOR_CARS);
            }
            return self.beside(node.at, kind, holds).map(|sign| vec![sign]);
        }
        let Some(forward) = node.direction() else { return Err(NO_DIRECTION) };
        let foot = |travel: DVec2| self.nearest(node.at, Some(travel), ON_WAY_M);
        let feet: Vec<LaneFoot> = match holds {
            HoldsFor::Forward => foot(forward).into_iter().collect(),
            HoldsFor::Backward => foot(-forward).into_iter().collect(),
            HoldsFor::Facing(facing_rad) => foot(-DVec2::from_angle(facing_rad)).into_iter().collect(),
            HoldsFor::Both => [forward, -forward].into_iter().filter_map(foot).collect(),
            HoldsFor::Unstated if node.arms() > 2 => return Err(NO_DIRECTION),
            HoldsFor::Unstated => match [foot(forward), foot(-forward)] {
                [Some(there), Some(back)] => vec![self.unstated(kind, there, back)?],
                one_way => one_way.into_iter().flatten().collect(),
            },
        };
        let at_road = |foot: LaneFoot| self.at_road(self.outermost(foot, node.at), kind);
        let signs: Vec<StatedSign> = feet.into_iter().map(at_road).collect();
        if signs.is_empty() { Err(NO_ROAD) } else { Ok(signs) }
    }

    /// Returns the direction for which a sign on a two-way road holds: one of right of way for those who come to the nearer junction.
    fn unstated(&self, kind: StatedSignKind, there: LaneFoot, back: LaneFoot) -> Result<LaneFoot, &'static str> {
        use StatedSignKind::{Priority, Roundabout, Stop, Yield};
        let [there_m, back_m] = [there, back].map(|foot| self.to_junction_m(foot));
        match (matches!(kind, Stop | Yield | Priority | Roundabout), there_m.min(back_m).is_finite()) {
            (true, true) => Ok(if there_m <= back_m { there } else { back }),
            _ => Err(NO_DIRECTION),
        }
    }

    /// Returns the sign of a node beside a road, which keeps its place if that is not on the road.
    fn beside(&self, at: DVec2, kind: StatedSignKind, holds: HoldsFor) -> Result<StatedSign, &'static str> {
        let travel = match holds {
            HoldsFor::Facing(facing_rad) => Some(-DVec2::from_angle(facing_rad)),
            _ => None,
        };
        let foot = self.nearest(at, travel, NEAR_ROAD_M).ok_or(NO_ROAD)?;
        let road = self.nearest(at, None, NEAR_ROAD_M).unwrap_or(foot);
        if road.off_m < self.net.lane(road.lane).half_width_m() + FREE_M {
            return Ok(self.at_road(self.outermost(foot, at), kind));
        }
        let facing = travel.unwrap_or(foot.along);
        Ok(StatedSign { position: at, facing_rad: (-facing).to_angle(), kind })
    }

    /// Returns the sign beside a lane, on the side of the road on which people drive.
    fn at_road(&self, foot: LaneFoot, kind: StatedSignKind) -> StatedSign {
        let net = self.net;
        let of = net.lane(foot.lane);
        let drawn_m = of.line.drawn_m();
        let s_m = foot.row_m.min(drawn_m - BEFORE_END_M).max(0.0) / drawn_m.max(0.01) * of.length_m;
        let side = if net.is_left_hand() { 1.0 } else { -1.0 };
        let pose = net.pose(LanePosition { lane: foot.lane, s_m, offset_m: side * (of.half_width_m() + BESIDE_M) });
        let facing = -DVec2::from_angle(pose.yaw_rad);
        StatedSign { position: pose.position.truncate(), facing_rad: facing.to_angle(), kind }
    }

    /// Returns the place beside a point on the outermost lane of a street.
    fn outermost(&self, foot: LaneFoot, at: DVec2) -> LaneFoot {
        let lane = self.net.edge_of(foot.lane).lanes().next();
        lane.and_then(|lane| self.foot(lane, at)).unwrap_or(foot)
    }

    /// Returns the nearest place on a lane within a distance; of those that lead along a direction of travel, if one is given.
    fn nearest(&self, at: DVec2, travel: Option<DVec2>, within_m: f64) -> Option<LaneFoot> {
        let is_near = |[low, high]: &[DVec2; 2]| at.cmpge(*low - within_m).all() && at.cmple(*high + within_m).all();
        let near = self.boxes.iter().filter(|(_, bounds)| is_near(bounds));
        let feet = near.filter_map(|(lane, _)| self.foot(*lane, at)).filter(|foot| foot.off_m <= within_m);
        let along = feet.filter(|foot| travel.is_none_or(|travel| foot.along.dot(travel) >= ALONG));
        along.min_by(|a, b| a.off_m.total_cmp(&b.off_m))
    }

    fn foot(&self, lane: LaneId, at: DVec2) -> Option<LaneFoot> {
        let mut start_m = 0.0;
        let feet = self.net.lane(lane).line.points().windows(2).map(|pair| {
            let [from, to] = [pair[0].truncate(), pair[1].truncate()];
            let (length_m, drawn_m) = (from.distance(to), pair[0].distance(pair[1]));
            let along = (to - from) / length_m.max(1e-9);
            let row_m = (at - from).dot(along).clamp(0.0, length_m);
            let foot = LaneFoot {
                lane,
                along,
                row_m: start_m + row_m / length_m.max(1e-9) * drawn_m,
                off_m: at.distance(from + along * row_m),
            };
            start_m += drawn_m;
            foot
        });
        feet.min_by(|a, b| a.off_m.total_cmp(&b.off_m))
    }

    /// Returns the distance to the next junction at which roads meet; infinite if none comes.
    fn to_junction_m(&self, foot: LaneFoot) -> f64 {
        let net = self.net;
        let (mut lane, mut distance_m) = (foot.lane, -foot.row_m);
        for _ in 0..MOST_STREETS {
            distance_m += net.lane(lane).line.drawn_m();
            if net.junction_after(lane).is_some_and(|junction| self.meetings.contains(&junction)) {
                return distance_m;
            }
            let Some(on) = net.connections_from(lane).iter().find(|way| !way.is_turnaround()) else { break };
            lane = on.to;
        }
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;

    #[test]
    fn a_sign_stands_beside_the_lane_of_those_for_whom_it_holds() {
        let net = Network::load("tests/data/networks/crossing.net.xml").expect("a network");
        let lanes = CarLanes::of(&net);
        for lane in net.lane_ids().filter(|lane| net.is_driven(*lane)) {
            let of = net.lane(lane);
            let middle = of.line.pose(of.length_m / 2.0, 0.0);
            let (at, along) = (middle.position.truncate(), DVec2::from_angle(middle.yaw_rad));
            // The way's line is to the left of the lane.
            let on_line = at + along.perp() * of.half_width_m();
            let around = vec![[Some(on_line - along), Some(on_line + along)]];
            let node = NodeAtRoad { at: on_line, around, is_on_path: false };
            let stop = |holds| lanes.signs(&node, StatedSignKind::Stop, holds);
            let [sign] = stop(HoldsFor::Forward).expect("a sign")[..] else { panic!("{}", of.id) };
            let expected = at - along.perp() * (of.half_width_m() + 0.95);
            assert!(sign.position.distance(expected) < 0.01, "{}: {sign:?} at {expected}", of.id);
            assert!(DVec2::from_angle(sign.facing_rad).distance(-along) < 1e-6, "{sign:?}");
            // Two lanes of the crossing lead to it, and it is the only one: the nearer junction is ahead or behind.
            let stated =
                if net.junction_after(lane).is_some_and(|it| lanes.meetings.contains(&it)) { along } else { -along };
            let [sign] = stop(HoldsFor::Unstated).expect("a sign")[..] else { panic!("{}", of.id) };
            assert!(DVec2::from_angle(sign.facing_rad).distance(-stated) < 1e-6, "{}: {sign:?}", of.id);
            assert_eq!(lanes.signs(&node, StatedSignKind::SpeedLimit(30), HoldsFor::Unstated), Err(NO_DIRECTION));
            assert_eq!(stop(HoldsFor::Both).expect("signs").len(), 2);
            // Beside the road it keeps its place, and one on it is moved to its side.
            let beside = |off_m: f64, holds| {
                let at = at - along.perp() * off_m;
                let node = NodeAtRoad { at, around: Vec::new(), is_on_path: false };
                (at, lanes.signs(&node, StatedSignKind::Stop, holds).expect("a sign")[0])
            };
            let (at, sign) = beside(4.0, HoldsFor::Unstated);
            assert!(sign.position == at && DVec2::from_angle(sign.facing_rad).distance(-along) < 1e-6, "{sign:?}");
            let back = along.to_angle();
            assert_eq!(beside(4.0, HoldsFor::Facing(back)).1.facing_rad, back);
            assert!(beside(0.5, HoldsFor::Unstated).1.position.distance(expected) < 0.01);
        }
        let far = NodeAtRoad { at: dvec2(9e3, 9e3), around: Vec::new(), is_on_path: false };
        assert_eq!(lanes.signs(&far, StatedSignKind::Stop, HoldsFor::Unstated), Err(NO_ROAD));
        let on_path = NodeAtRoad { is_on_path: true, ..far };
        assert_eq!(lanes.signs(&on_path, StatedSignKind::Stop, HoldsFor::Unstated), Err(NOT_FOR_CARS));
    }
}
