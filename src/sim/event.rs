//! Events of a drive, for recordings, the panel and the end of a drive.

use crate::{
    controls::Indicator,
    metrics::{AutomationChange, QuestionChange, TaskLog, TaskResponse, TaskStimulus},
    policy::Advice,
    roadside::fixed_objects::FixedObjectKind,
    time::Tick,
    traffic::{VehicleId, VehicleKind},
};

/// An event at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Tick at which the event happened.
    pub tick: Tick,
    pub kind: EventKind,
}

impl Event {
    /// Adds the event to the log of the secondary task; other kinds have no effect.
    pub fn add_to(&self, log: &mut TaskLog) {
        match self.kind {
            EventKind::TaskStimulus(stimulus) => log.stimuli.push((self.tick, stimulus)),
            EventKind::TaskResponse(response) => log.responses.push((self.tick, response)),
            EventKind::Shutter(is_open) => log.shutter.push((self.tick, is_open)),
            EventKind::Question { change, .. } => log.questions.push((self.tick, change)),
            _ => {}
        }
    }
}

/// Text that the participant reads after a contact with a person.
pub const PERSON_TOUCHED: &str = "You have touched a person. The drive is over.";

impl EventKind {
    /// Checks for a contact with a person on foot or on a bicycle.
    pub fn touches_person(&self) -> bool {
        matches!(self, Self::Contact { kind: VehicleKind::Pedestrian | VehicleKind::Bicycle, .. })
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// A new advice appears on the speedometer.
    Advice(Advice),
    /// The advice disappears: the policy withholds advice from now on.
    AdviceWithheld,
    /// The ego begins to touch another vehicle or a person.
    Contact {
        /// Id of the other vehicle.
        car: VehicleId,
        /// Kind of the other vehicle, or `Pedestrian`.
        kind: VehicleKind,
        /// Speed of the ego just before, m/s.
        ego_speed_mps: f64,
        /// Speed of the other vehicle just before, m/s.
        car_speed_mps: f64,
        /// Closing speed, m/s.
        closing_mps: f64,
        /// Heading of the other vehicle relative to the ego's, radians in ±π: 0 is parallel, positive is to the left.
        angle_rad: f64,
    },
    /// The ego begins to touch a fixed object beside the road.
    ObjectContact {
        object: FixedObjectKind,
        /// Speed of the ego just before, m/s.
        ego_speed_mps: f64,
        /// Closing speed, m/s.
        closing_mps: f64,
    },
    /// The centre of the ego leaves the road: lanes, shoulders and junctions.
    LeftRoad {
        /// Ego's position along the route, metres.
        s_m: f64,
        /// Lateral offset, metres, positive to the left.
        offset_m: f64,
    },
    /// The centre of the ego is back on the road.
    BackOnRoad,
    /// The ego has been on another street than its path's for a second.
    LeftPath {
        /// Last position on the path, metres.
        s_m: f64,
    },
    /// The ego is on a street of its path again.
    BackOnPath {
        /// Ego's front bumper along the route, metres.
        s_m: f64,
    },
    /// The ego's front crosses the stop line of a red signal.
    StopLine {
        /// Ego's front bumper along the route, metres.
        s_m: f64,
        /// Speed of the ego, m/s.
        speed_mps: f64,
    },
    /// The ego's centre crosses the line, too, while the signal is red.
    RedLight {
        /// Ego's front bumper along the route, metres.
        s_m: f64,
        /// Speed of the ego, m/s.
        speed_mps: f64,
    },
    /// The ego drives against the direction of its lane.
    WrongWay {
        /// Ego's position along the route, metres.
        s_m: f64,
    },
    /// The ego no longer drives against the direction of its lane.
    RightWay,
    /// The ego is faster than the lane's speed limit.
    Speeding {
        /// Ego's position along the route, metres.
        s_m: f64,
        /// Excess over the limit, m/s.
        over_mps: f64,
    },
    /// The ego keeps the speed limit again.
    WithinLimit,
    /// The ego and another vehicle would collide within 1.5 s if both went on unchanged.
    NearMiss {
        /// Id of the other vehicle.
        car: VehicleId,
        /// Time to collision, s.
        time_s: f64,
    },
    /// The ego's indicators change.
    Indicator(Indicator),
    /// The ego's main beam is switched on or off.
    MainBeam(bool),
    /// A stimulus of the secondary task is shown.
    TaskStimulus(TaskStimulus),
    /// The driver responds to the secondary task.
    TaskResponse(TaskResponse),
    /// The shutter of an occlusion opens (true) or closes.
    Shutter(bool),
    /// A question of an event is asked or answered, or its time is over.
    Question {
        /// Number of the event in the scenario, from 0.
        event: u16,
        change: QuestionChange,
    },
    /// The automation changes, or the participant responds to it.
    Automation(AutomationChange),
    /// The ego is put back on its lane.
    PutBack {
        /// Ego's front bumper along the route, metres.
        s_m: f64,
    },
    /// An event of the scenario is armed, begins, is seen, ends, or is not carried out.
    Scripted {
        /// Number of the event in the scenario, from 0.
        event: u16,
        /// Vehicle of the traffic that acts.
        vehicle: Option<VehicleId>,
        stage: EventStage,
    },
    /// The drive is over.
    Ended(EndReason),
}

/// Stage of an event of the scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventStage {
    /// The event waits for its trigger from this tick on.
    Armed,
    /// The trigger came true.
    Triggered,
    /// The experimenter began the event by hand.
    TriggeredByHand,
    /// The tick is the first that shows an action of the event.
    Onset,
    /// All actions are over.
    Ended,
    /// The event, or one of its actions, is not carried out.
    NotDone(NotDone),
}

/// State of an event of the scenario in a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScriptedState {
    /// Event that waits for its trigger.
    Armed,
    /// Event that has begun.
    Running,
    /// Event that is over, or against which the draw was.
    Over,
}

/// Reason why an event, or an action of it, is not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotDone {
    /// The draw of its probability was against it.
    ByChance,
    /// There is no such vehicle now.
    NoVehicle,
    /// The vehicle has a driver of its own, as advised vehicles have.
    OwnDriver,
    /// Another event moves the vehicle.
    OtherEvent,
    /// The automation does not drive, or asks for a takeover already.
    AutomationOff,
    /// The automation is on already, or cannot be switched on: the brake is pressed, the selector is not in drive, the vehicle is too fast, or it has failed.
    AutomationNotReady,
    /// The traffic engine refuses the order.
    Refused,
    /// The vehicle has left the road before the end.
    HasLeft,
    /// No chance came within the time of the action.
    TooLate,
    /// There is no signal ahead on the path.
    NoSignal,
    /// The signal's program has no phase with this light.
    NoPhase,
}

impl EventStage {
    /// Returns the kind of event in recordings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Armed => "event_armed",
            Self::Triggered => "event_triggered",
            Self::TriggeredByHand => "event_triggered_by_hand",
            Self::Onset => "event_onset",
            Self::Ended => "event_ended",
            Self::NotDone(_) => "event_not_done",
        }
    }
}

impl NotDone {
    /// Returns the reason in words, as in recordings and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::ByChance => "not drawn",
            Self::NoVehicle => "no such vehicle",
            Self::OwnDriver => "the vehicle has a driver of its own",
            Self::OtherEvent => "another event moves the vehicle",
            Self::AutomationOff => "the automation does not drive",
            Self::AutomationNotReady => "the automation cannot be switched on",
            Self::Refused => "refused by the traffic",
            Self::HasLeft => "the vehicle has left",
            Self::TooLate => "not possible in its time",
            Self::NoSignal => "no signal ahead",
            Self::NoPhase => "no phase of the signal has this light",
        }
    }
}

/// Reason for the end of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EndReason {
    /// The scenario's duration has passed.
    Duration,
    /// A contact with a person; or with another vehicle or a fixed object, in a scenario that ends at the first one.
    Contact,
    /// The ego is at the end of its path.
    PathEnd,
    /// An event of the scenario has ended it.
    Event,
    /// The traffic engine failed; see [`super::Summary::failure`].
    Failed,
}

impl EndReason {
    /// Returns the reason in words, as in recordings and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Duration => "duration",
            Self::Contact => "contact",
            Self::PathEnd => "end of the path",
            Self::Event => "event",
            Self::Failed => "failed",
        }
    }
}
