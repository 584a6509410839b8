//! Road ahead of the ego as a policy may see it, and the kinds of road that provide it. In: metres and m/s. Out: a [`RoadAhead`].

/// Distance reported if there is nothing to measure to, m.
pub const FAR_M: f64 = 1000.0;

/// A vehicle behind the ego, or ahead or behind in a lane beside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearVehicle {
    /// Front bumper of the rear vehicle to the rear bumper of the front vehicle, m; negative if they are side by side.
    pub gap_m: f64,
    /// Speed of the vehicle, m/s.
    pub speed_mps: f64,
}

/// A lane beside the ego's in the same direction, with its nearest vehicles. A vehicle side by side with the ego is the leader if its
/// front bumper is level with the ego's or ahead of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaneBeside {
    /// Nearest vehicle ahead in this lane.
    pub leader: Option<NearVehicle>,
    /// Nearest vehicle behind in this lane.
    pub follower: Option<NearVehicle>,
}

/// Next signal on the ego's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignalAhead {
    /// Ego's front bumper to the signal's stop line, m.
    pub distance_m: f64,
    /// True if the signal shows green.
    pub is_green: bool,
}

/// Road ahead in a whole drive; training rings have none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoadAhead {
    /// Speed limit at the ego, m/s.
    pub speed_limit_mps: f64,
    /// Curvature of the path at the ego's position in three seconds, 1/m, positive to the left.
    pub bend_per_m: f64,
    /// Vehicle behind the ego.
    pub follower: Option<NearVehicle>,
    /// Lane to the left, if cars may drive there.
    pub left: Option<LaneBeside>,
    /// Lane to the right, if cars may drive there.
    pub right: Option<LaneBeside>,
    /// Next signal on the path.
    pub signal: Option<SignalAhead>,
    /// Ego's front bumper to the next yield line on the path without a stop sign, m.
    pub yield_line_m: Option<f64>,
    /// Ego's front bumper to the next stop-sign line, m.
    pub stop_line_m: Option<f64>,
    /// Ego's front bumper to the point by which the path must have changed lanes (for example before an exit), m.
    pub lane_end_m: Option<f64>,
    /// Distance to the end of the path, m; `None` on a closed route.
    pub path_left_m: Option<f64>,
}

/// Kind of road on which a policy advises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoadKind {
    /// A training or evaluation ring: vehicles and a length, nothing else.
    BareRing,
    /// A whole drive on a closed route with a fixed number of vehicles.
    ClosedRoute,
    /// A whole drive along a path through a network.
    Network(LanesBeside),
}

/// Sides on which other lanes lie beside a path's own lanes, anywhere along it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LanesBeside {
    /// True if a lane lies to the left.
    pub left: bool,
    /// True if a lane lies to the right.
    pub right: bool,
}

impl RoadKind {
    /// Returns true for a path through a network.
    pub fn is_network(self) -> bool {
        matches!(self, Self::Network(_))
    }

    /// Returns gap, m, and speed, m/s, that stand for the leader where there is none. On a closed route of this length a stopped one is a
    /// full lap ahead, as in training; on a network one is far ahead at the ego's speed.
    pub fn without_leader(self, route_m: f64, speed_mps: f64) -> (f64, f64) {
        if self.is_network() { (FAR_M, speed_mps) } else { (route_m, 0.0) }
    }

    /// Returns the lanes beside a path; none on rings and closed routes.
    pub(super) fn lanes_beside(self) -> LanesBeside {
        if let Self::Network(beside) = self { beside } else { LanesBeside::default() }
    }
}
