//! Markings along the sides of a lane. In: permissions, lane-change rules, and the adjacent lane. Out: a [`Marking`]. SUMO has no
//! markings: they are derived from its rules, as markings of a road follow from its rules.

use super::{EdgeId, LaneId, LaneSpread, Network, Side, VehicleClasses};

/// Largest distance between the inner borders of two directions that share one line, metres.
const APART_M: f64 = 0.5;

/// Separation of a lane from the surface on one side of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marking {
    /// No marking, as inside junctions.
    None,
    /// Solid line at the edge of the road.
    Edge,
    /// Kerb of a pavement.
    Kerb,
    /// Broken line: vehicles may change both ways.
    Broken,
    /// Solid line: no vehicle may change.
    Solid,
    /// Solid line with a broken one on this lane's side: vehicles may change from here only.
    ChangeFromHere,
    /// Solid line with a broken one on the other lane's side: vehicles may change to here only.
    ChangeToHere,
    /// Line between the two directions.
    Centre {
        /// True if vehicles may overtake across it.
        overtaking: bool,
    },
}

impl Network {
    /// Returns the marking along one side of a lane.
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

    /// Returns true for the side on which the opposite direction lies.
    fn is_inner(&self, side: Side) -> bool {
        (side == Side::Left) != self.is_left_hand()
    }

    /// Returns true if the opposite direction of the same road begins at the inner border of this lane.
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

    /// Returns the edge of the opposite direction: from the end of an edge to its start.
    pub fn other_direction(&self, edge: EdgeId) -> Option<EdgeId> {
        let here = self.edge(edge);
        let back = self.junction(here.from?).incoming.iter().map(|lane| self.lane(*lane).edge);
        back.into_iter()
            .find(|&other| other != edge && self.edge(other).from == here.to && self.edge(other).kind.is_street())
    }
}
