//! Connections as data: the ways from lane to lane, with direction, state and signal.

use super::{LaneId, SignalId, VehicleClasses, words::word_enum};
use glam::DVec3;

word_enum! {
    /// Where a connection leads, seen from the lane that it leaves.
    TurnDirection {
        /// Straight on.
        Straight = "s",
        /// Left.
        Left = "l",
        /// Right.
        Right = "r",
        /// Half left.
        PartLeft = "L",
        /// Half right.
        PartRight = "R",
        /// Back to where one came from.
        Turnaround = "t",
        /// The same with left-hand traffic.
        TurnaroundLeftHand = "T",
        /// None is stated.
        Unknown = "invalid",
    }
}

word_enum! {
    /// Who goes first on a connection; where a signal rules, the state that it begins with.
    LinkState {
        /// This one.
        Major = "M",
        /// Others.
        Minor = "m",
        /// Who comes from the right, or left.
        Equal = "=",
        /// Others, and this one stops first.
        Stop = "s",
        /// Who came first; all stop.
        AllwayStop = "w",
        /// One by one.
        Zipper = "Z",
        /// Nothing leads on.
        DeadEnd = "-",
        /// A signal that is off and blinks: yield.
        OffBlinking = "o",
        /// A signal that is off: the rule of the road.
        Off = "O",
        /// Red.
        Red = "r",
        /// Red, an old letter.
        RedCapital = "R",
        /// Yellow.
        Yellow = "y",
        /// Yellow for those that had priority.
        YellowMajor = "Y",
        /// Red and yellow.
        RedYellow = "u",
        /// Red and yellow, an old letter.
        RedYellowCapital = "U",
        /// Green, yielding.
        GreenMinor = "g",
        /// Green with priority.
        GreenMajor = "G",
        /// All-way stop, an old letter.
        AllwayStopOld = "a",
    }
}

/// The signal that rules a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignalLink {
    /// Which signal.
    pub signal: SignalId,
    /// Place of its letter in the states of the signal; `None` where the signal lets it be, as a railway at its level crossing.
    pub index: Option<u32>,
    /// Place of the letter for the second half of the way, where there is one.
    pub second: Option<u32>,
}

/// What a person set for a connection beside the usual.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConnectionOptions {
    /// True if it is never yielded on this way.
    pub pass: bool,
    /// True if the signal of the junction does not rule this way.
    pub uncontrolled: bool,
    /// Where vehicles wait inside the junction, metres.
    pub wait_at_m: Option<f64>,
    /// From how far other traffic is seen, metres.
    pub visibility_m: Option<f64>,
    /// Speed limit inside the junction, m/s.
    pub speed_mps: Option<f64>,
    /// Length inside the junction, metres.
    pub length_m: Option<f64>,
    /// Line inside the junction; empty if none was set.
    pub shape: Vec<DVec3>,
    /// Who may take this way, where it is not who may drive on both lanes.
    pub permissions: Option<VehicleClasses>,
    /// Who may change to the left inside the junction.
    pub change_left: Option<VehicleClasses>,
    /// Who may change to the right inside the junction.
    pub change_right: Option<VehicleClasses>,
    /// True of a left turn of bicycles in two parts.
    pub indirect: bool,
}

/// A way from one lane to the next, or into the inside of a junction and out of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// The lane that it leaves.
    pub from: LaneId,
    /// The lane where it leads in the end.
    pub to: LaneId,
    /// The first lane inside the junction on that way; `None` where none lies between.
    pub via: Option<LaneId>,
    /// Where it leads.
    pub direction: TurnDirection,
    /// Who goes first.
    pub state: LinkState,
    /// The signal that rules it.
    pub signal: Option<SignalLink>,
    /// Its place in the rules of its junction.
    pub link: Option<u32>,
    /// True if vehicles keep the junction clear where they could not leave it.
    pub keep_clear: bool,
    /// What else a person set.
    pub options: Option<Box<ConnectionOptions>>,
}

impl Connection {
    /// The lane that follows at once: the inside of the junction, or the lane beyond.
    pub fn next(&self) -> LaneId {
        self.via.unwrap_or(self.to)
    }

    /// True of a turn on the spot, back to where one came from.
    pub fn is_turnaround(&self) -> bool {
        matches!(self.direction, TurnDirection::Turnaround | TurnDirection::TurnaroundLeftHand)
    }
}
