//! What is painted along the sides of a lane. In: permissions, who may change lanes, and what lies beside. Out: a [`Marking`]. SUMO
//! has no paint: what stands here follows from its rules as a road's paint does.

use super::{EdgeId, LaneId, LaneSpread, Network, Side, VehicleClasses};

/// How far the inner borders of two directions may be apart to be one line, metres.
const APART_M: f64 = 0.5;

/// What separates a lane from what lies on one side of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marking {
    /// Nothing, as inside junctions.
    None,
    /// The solid line at the edge of the road.
    Edge,
    /// The step up to a pavement.
    Kerb,
    /// A broken line: vehicles may change both ways.
    Broken,
    /// A solid line: none may change.
    Solid,
    /// A solid line with a broken one towards this lane: vehicles may change from here only.
    ChangeFromHere,
    /// A solid line with a broken one towards the other lane: vehicles may change to here only.
    ChangeToHere,
    /// The line between the two directions.
    Centre {
        /// True if vehicles may overtake across it.
        overtaking: bool,
    },
}

impl Network {
    /// What is painted along one side of a lane.
    pub fn marking(&self, lane: LaneId, side: Side) -> Marking {
        let edge = self.edge_of(lane);
        if !edge.kind.is_street() {
            return Marking::None;
        }
        let here = self.lane(lane);
        match self.neighbour(lane, side) {
            Some(beside) => self.between(lane, beside, side),
            None if here.is_footway() => Marking::None,
            None if self.is_inner(side) && self.meets_other_direction(lane) => {
                Marking::Centre { overtaking: here.opposite.is_some() }
            }
            None => Marking::Edge,
        }
    }

    fn between(&self, here: LaneId, beside: LaneId, side: Side) -> Marking {
        let (here, beside) = (self.lane(here), self.lane(beside));
        match (here.is_footway(), beside.is_footway()) {
            (true, true) => return Marking::None,
            (false, false) => {}
            _ => return Marking::Kerb,
        }
        let both = here.permissions.and(beside.permissions).without(VehicleClasses::PEDESTRIAN);
        let (from_here, to_here) = match side {
            Side::Left => (here.change_left, beside.change_right),
            Side::Right => (here.change_right, beside.change_left),
        };
        match (both.intersects(from_here), both.intersects(to_here)) {
            (true, true) => Marking::Broken,
            (true, false) => Marking::ChangeFromHere,
            (false, true) => Marking::ChangeToHere,
            (false, false) => Marking::Solid,
        }
    }

    /// True of the side where the other direction lies.
    fn is_inner(&self, side: Side) -> bool {
        (side == Side::Left) != self.is_left_hand()
    }

    /// True if the other direction of the same road begins at the inner border of this lane.
    fn meets_other_direction(&self, lane: LaneId) -> bool {
        let here = self.lane(lane);
        if here.opposite.is_some() {
            return true;
        }
        let Some(other) = self.other_direction(here.edge) else { return false };
        if self.edge(here.edge).spread == LaneSpread::Center {
            return false;
        }
        let middle = here.line.pose(here.length_m / 2.0, 0.0).position;
        let Some(innermost) = self.edge(other).lanes().next_back().map(|lane| self.lane(lane)) else { return false };
        let apart_m = innermost.line.nearest(middle).distance_m - (here.width_m + innermost.width_m) / 2.0;
        apart_m.abs() <= APART_M
    }

    /// The edge that leads back from where an edge ends to where it begins.
    pub fn other_direction(&self, edge: EdgeId) -> Option<EdgeId> {
        let here = self.edge(edge);
        let back = self.junction(here.from?).incoming.iter().map(|lane| self.lane(*lane).edge);
        back.into_iter()
            .find(|&other| other != edge && self.edge(other).from == here.to && self.edge(other).kind.is_street())
    }
}
