//! Connections as data: links from lane to lane, with direction, state and signal.

use super::{LaneId, SignalId, VehicleClasses, named_enum::named_enum};
use glam::DVec3;

named_enum! {
    /// Direction of a connection, seen from the lane that it leaves.
    TurnDirection {
        Straight = "s",
        Left = "l",
        Right = "r",
        PartLeft = "L",
        PartRight = "R",
        /// U-turn, back to where the lane came from.
        Turnaround = "t",
        /// U-turn with left-hand traffic.
        TurnaroundLeftHand = "T",
        /// No direction in the file.
        Unknown = "invalid",
    }
}

named_enum! {
    /// Right of way of a connection; at a signal, the state in which it begins.
    LinkState {
        /// Priority over other connections.
        Major = "M",
        /// Yields to other connections.
        Minor = "m",
        /// Right before left, or left before right.
        Equal = "=",
        /// Stop sign: stops, then yields.
        Stop = "s",
        /// All-way stop: vehicles go in the order of arrival.
        AllwayStop = "w",
        /// Zipper merge: vehicles merge alternately.
        Zipper = "Z",
        /// Dead end: no lane follows.
        DeadEnd = "-",
        /// Signal off and blinking: yield.
        OffBlinking = "o",
        /// Signal off: the junction's rule applies.
        Off = "O",
        Red = "r",
        /// Red, in an older notation.
        RedCapital = "R",
        /// Yellow, for a link without priority.
        Yellow = "y",
        /// Yellow, for a link with priority.
        YellowMajor = "Y",
        /// Red and yellow, before green.
        RedYellow = "u",
        /// Red and yellow, in an older notation.
        RedYellowCapital = "U",
        /// Green without priority: yields to others.
        GreenMinor = "g",
        /// Green with priority over other links.
        GreenMajor = "G",
        /// All-way stop, in an older notation.
        AllwayStopOld = "a",
    }
}

/// Signal that controls a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignalLink {
    pub signal: SignalId,
    /// Index of the connection's letter in the states of the signal; `None` if the signal does not control it, such as a railway at its
    /// level crossing.
    pub index: Option<u32>,
    /// Index of the letter for the second part of the way through the junction, if there is one.
    pub second: Option<u32>,
}

/// Settings of a connection that differ from netconvert's defaults.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConnectionOptions {
    /// True if vehicles on this connection never yield.
    pub pass: bool,
    /// True if the junction's signal does not control this connection.
    pub uncontrolled: bool,
    /// Waiting position inside the junction, metres.
    pub wait_at_m: Option<f64>,
    /// Distance at which other traffic becomes visible, metres.
    pub visibility_m: Option<f64>,
    /// Speed limit inside the junction, m/s.
    pub speed_mps: Option<f64>,
    /// Length inside the junction, metres.
    pub length_m: Option<f64>,
    /// Line inside the junction; empty if none was set.
    pub shape: Vec<DVec3>,
    /// Vehicle classes that may use the connection, if they differ from the classes of both lanes.
    pub permissions: Option<VehicleClasses>,
    /// Vehicle classes that may change to the left inside the junction.
    pub change_left: Option<VehicleClasses>,
    /// Vehicle classes that may change to the right inside the junction.
    pub change_right: Option<VehicleClasses>,
    /// True for an indirect left turn of bicycles, in two parts.
    pub indirect: bool,
}

/// Connection from one lane to the next, or into a junction and out of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// Lane that the connection leaves.
    pub from: LaneId,
    /// Lane that the connection leads to, beyond the junction.
    pub to: LaneId,
    /// First internal lane on the way; `None` if there is none.
    pub via: Option<LaneId>,
    /// Direction of the turn.
    pub direction: TurnDirection,
    /// Right of way of the connection.
    pub state: LinkState,
    /// Signal that controls the connection.
    pub signal: Option<SignalLink>,
    /// Index among the links of the junction.
    pub link: Option<u32>,
    /// True if vehicles keep the junction clear when they could not leave it.
    pub keep_clear: bool,
    /// Settings that differ from the defaults.
    pub options: Option<Box<ConnectionOptions>>,
}

impl Connection {
    /// Returns the lane that directly follows: the internal lane, or the lane beyond the junction.
    pub fn next(&self) -> LaneId {
        self.via.unwrap_or(self.to)
    }

    /// Returns true for a U-turn.
    pub fn is_turnaround(&self) -> bool {
        matches!(self.direction, TurnDirection::Turnaround | TurnDirection::TurnaroundLeftHand)
    }
}
