//! What happened at a tick, for recordings, the panel and the end of a drive.

use crate::{controls::Indicator, policy::Advice, time::Tick, traffic::VehicleId};

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When.
    pub tick: Tick,
    /// What.
    pub kind: EventKind,
}

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// A new advice stands on the speedometer.
    Advice(Advice),
    /// The advice that stood is gone: the policy withholds advice from now on.
    AdviceWithheld,
    /// The ego began to touch another car.
    Contact {
        /// Which car.
        car: VehicleId,
        /// Ego's speed just before, m/s.
        ego_speed_mps: f64,
        /// The other's speed just before, m/s.
        car_speed_mps: f64,
        /// Speed at which they closed in, m/s.
        closing_mps: f64,
        /// The other's heading against the ego's, radians within +-pi: 0 alike, positive to the left.
        angle_rad: f64,
    },
    /// The middle of the ego left its lane.
    LeftRoad {
        /// Where along the route, metres.
        s_m: f64,
        /// Lateral offset, metres, positive to the left.
        offset_m: f64,
    },
    /// The middle of the ego is back in the lane.
    BackOnRoad,
    /// The ego's front came over the line at a signal that shows it red.
    StopLine {
        /// Where along the route, metres.
        s_m: f64,
        /// Its speed, m/s.
        speed_mps: f64,
    },
    /// The ego's middle followed while the signal was red.
    RedLight {
        /// Where along the route its front is, metres.
        s_m: f64,
        /// Its speed, m/s.
        speed_mps: f64,
    },
    /// The ego drives against the direction of its lane.
    WrongWay {
        /// Where along the route, metres.
        s_m: f64,
    },
    /// It does so no longer.
    RightWay,
    /// The ego is faster than the lane's limit.
    Speeding {
        /// Where along the route, metres.
        s_m: f64,
        /// By how much, m/s.
        over_mps: f64,
    },
    /// It keeps the limit again.
    WithinLimit,
    /// The ego and another vehicle would have touched within 1.5 s, had both gone on as they were.
    NearMiss {
        /// Which vehicle.
        car: VehicleId,
        /// Time to collision, s.
        time_s: f64,
    },
    /// The driver indicates, or no longer.
    Indicator(Indicator),
    /// Somebody has put the ego back on its lane.
    PutBack {
        /// Where its front stands along the route, metres.
        s_m: f64,
    },
    /// The drive is over.
    Ended(EndReason),
}

/// Why a drive is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EndReason {
    /// Its duration has passed.
    Duration,
    /// A contact, and the scenario ends with it.
    Contact,
    /// The ego has come to the end of its path.
    PathEnd,
    /// The traffic engine failed: see [`super::Summary::failure`].
    Failed,
}

impl EndReason {
    /// In a word or two, as recordings and messages have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Duration => "duration",
            Self::Contact => "contact",
            Self::PathEnd => "end of the path",
            Self::Failed => "failed",
        }
    }
}
