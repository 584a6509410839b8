//! Triggers of a scenario's events: the conditions at which an event begins. In: the setting `trigger`. Out: a checked [`Trigger`]. Seconds, metres,
//! m/s.

use super::{
    limits::{DistanceAhead, TimeAhead, check_limit, limit_in_words},
    values::{FARTHEST_M, FASTEST_MPS, LATEST_S, VehicleName, check_subject, within},
};
use crate::{
    controls::{Controls, Indicator, PEDAL_PRESSED, TaskButton},
    map::{RoadMap, SHOULDER_M, network::SignalLight},
    scenario::RoadUser,
    toml_text::did_you_mean,
    traffic::Demand,
};
use serde::{Deserialize, Serialize};

/// Largest limit of an acceleration, m/s2: ten times that of a full braking, for scenes from other programs.
const STRONGEST_MPS2: f64 = 100.0;

/// Condition at which an event begins, evaluated at each step of the traffic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Trigger {
    /// Time since the start of the drive, s.
    TimeS(#[schemars(range(min = 0.0, max = LATEST_S))] f64),
    /// Place on the ego's route that its front has reached, m; on a closed route anew in each lap.
    PlaceM(#[schemars(range(min = 0.0, max = FARTHEST_M))] f64),
    /// Speed of the ego above this, m/s.
    SpeedAboveMps(#[schemars(range(min = 0.0, max = FASTEST_MPS))] f64),
    /// Speed of the ego below this, m/s.
    SpeedBelowMps(#[schemars(range(min = 0.0, max = FASTEST_MPS))] f64),
    /// Distance from the ego's front, or that of another vehicle, to a vehicle ahead.
    Distance(DistanceAhead),
    /// Time gap to a vehicle ahead: the distance over the speed of the one behind.
    TimeGap(TimeAhead),
    /// Time to collision with a vehicle ahead: the distance over the closing speed.
    TimeToCollision(TimeAhead),
    /// Place on the ego's route that the front of a road user has reached.
    Reaches {
        /// Vehicle by its place beside the ego, its number, or its name.
        vehicle: VehicleName,
        /// Place, m.
        #[schemars(range(min = 0.0, max = FARTHEST_M), extend("unit" = "m"))]
        place_m: f64,
    },
    /// Speed of a vehicle above or below a limit.
    Speed {
        /// Vehicle by its place beside the ego, its number, or its name.
        vehicle: VehicleName,
        /// Vehicle whose speed is subtracted.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        than: Option<VehicleName>,
        /// Lower limit, m/s.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = -FASTEST_MPS, max = FASTEST_MPS), extend("unit" = "m/s"))]
        above_mps: Option<f64>,
        /// Upper limit, m/s.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = -FASTEST_MPS, max = FASTEST_MPS), extend("unit" = "m/s"))]
        below_mps: Option<f64>,
    },
    /// Acceleration of a vehicle above or below a limit.
    Acceleration {
        /// Vehicle by its place beside the ego, its number, or its name.
        vehicle: VehicleName,
        /// Lower limit, m/s2.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = -STRONGEST_MPS2, max = STRONGEST_MPS2), extend("unit" = "m/s2"))]
        above_mps2: Option<f64>,
        /// Upper limit, m/s2.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = -STRONGEST_MPS2, max = STRONGEST_MPS2), extend("unit" = "m/s2"))]
        below_mps2: Option<f64>,
    },
    /// Place of a vehicle beside all lanes of the road.
    OffRoad {
        /// Vehicle by its place beside the ego, its number, or its name.
        vehicle: VehicleName,
        /// Distance from the outermost lane that still counts as road, m.
        #[serde(default = "shoulder_m")]
        #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "m"))]
        beyond_m: f64,
    },
    /// Distance that a vehicle has driven since the start of the drive.
    Driven {
        /// Vehicle by its place beside the ego, its number, or its name.
        vehicle: VehicleName,
        /// Distance, m.
        #[schemars(range(min = 0.0, max = FARTHEST_M), extend("unit" = "m"))]
        above_m: f64,
    },
    /// Light of a signal, by its id in the network, for the ego's path.
    Signal { name: String, light: EventLight },
    /// Begin of another event, and a delay.
    Begun {
        /// Name of the other event.
        event: String,
        /// Delay after its begin, s.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = LATEST_S), extend("unit" = "s"))]
        delay_s: f64,
    },
    /// End of another event, and a delay.
    After {
        /// Name of the other event.
        event: String,
        /// Delay after its end, s.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = LATEST_S), extend("unit" = "s"))]
        delay_s: f64,
        /// Number of times that it has to have ended, for one that repeats.
        #[serde(default = "once", skip_serializing_if = "is_once")]
        times: u32,
    },
    /// Edge of a network, or one lane of it, that the ego's front is on, at a place of it or beyond.
    Edge {
        /// Edge by its id in the network.
        id: String,
        /// Lane by its number from 0 on the right, as in SUMO; any lane without it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lane: Option<usize>,
        /// Distance from the begin of the edge, m.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = FARTHEST_M), extend("unit" = "m"))]
        at_m: f64,
    },
    /// Light of the next signal on the ego's path, from a distance on.
    SignalAhead {
        light: EventLight,
        /// Distance from the ego's front to the stop line, m.
        #[schemars(range(min = 0.1, max = FARTHEST_M), extend("unit" = "m"))]
        below_m: f64,
    },
    /// Change of the advice on the speedometer.
    AdviceChanges,
    /// Pedal, button or stalk that the driver presses.
    Pressed(DriverInput),
    /// One or more of these conditions.
    Any(Vec<Trigger>),
    /// All of these conditions at once.
    All(Vec<Trigger>),
}

fn shoulder_m() -> f64 {
    SHOULDER_M
}

fn once() -> u32 {
    1
}

fn is_once(times: &u32) -> bool {
    *times == 1
}

/// Light of a signal, as events name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EventLight {
    Red,
    /// Red and yellow together, before green.
    RedYellow,
    Yellow,
    /// Green with or without priority.
    Green,
}

impl EventLight {
    fn name(self) -> &'static str {
        match self {
            Self::Red => "red",
            Self::RedYellow => "red and yellow",
            Self::Yellow => "yellow",
            Self::Green => "green",
        }
    }

    /// Checks whether a signal shows this light.
    pub fn is(self, light: SignalLight) -> bool {
        match self {
            Self::Red => light == SignalLight::Red,
            Self::RedYellow => light == SignalLight::RedYellow,
            Self::Yellow => light == SignalLight::Yellow,
            Self::Green => matches!(light, SignalLight::GreenMinor | SignalLight::GreenMajor),
        }
    }
}

/// Input of the driver that can trigger an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DriverInput {
    Accelerator,
    Brake,
    /// Button of the secondary task.
    Respond,
    IndicatorLeft,
    IndicatorRight,
    MainBeam,
}

impl DriverInput {
    fn name(self) -> &'static str {
        match self {
            Self::Accelerator => "accelerator",
            Self::Brake => "brake",
            Self::Respond => "response button",
            Self::IndicatorLeft => "left indicator",
            Self::IndicatorRight => "right indicator",
            Self::MainBeam => "main beam",
        }
    }

    /// Checks whether the driver gives this input.
    pub fn is_given(self, controls: &Controls) -> bool {
        match self {
            Self::Accelerator => controls.throttle > PEDAL_PRESSED,
            Self::Brake => controls.brake > PEDAL_PRESSED,
            Self::Respond => controls.task_button == TaskButton::Respond,
            Self::IndicatorLeft => controls.indicator == Indicator::Left,
            Self::IndicatorRight => controls.indicator == Indicator::Right,
            Self::MainBeam => controls.main_beam,
        }
    }
}

/// Road of a drive, as far as events depend on it.
#[derive(Clone, Copy, Debug)]
pub struct DrivenRoad<'a> {
    pub map: &'a RoadMap,
    /// Number of vehicles of a closed route, the ego included; `None` where vehicles enter and leave.
    pub fixed_vehicles: Option<u32>,
    /// Road users and demand of the drive, for the names of vehicles.
    pub road_users: &'a [RoadUser],
    pub demand: &'a Demand,
    /// Length of the drive, s; 0 without an end.
    pub duration_s: f64,
    /// True if the participant's vehicle has an automation.
    pub has_automation: bool,
}

impl DrivenRoad<'_> {
    /// Checks whether vehicles enter and leave.
    pub fn is_open(&self) -> bool {
        self.fixed_vehicles.is_none()
    }

    /// Returns the reason why the ego's path has no such place; `None` if it has.
    fn no_place(&self, id: &str, lane: Option<usize>, at_m: f64) -> Option<String> {
        let network = &self.map.network;
        let Some(edge) = network.edge_named(id) else {
            let ids: Vec<&str> = network.edges().iter().map(|edge| edge.id.as_str()).collect();
            return Some(format!("the network has no edge {id:?}{}", did_you_mean(id, &ids)));
        };
        let edge = network.edge(edge);
        let length_m = edge.lanes().map(|lane| network.lane(lane).length_m).fold(0.0, f64::max);
        let lanes = edge.lanes().len();
        if !self.map.route.lanes().iter().any(|part| part.edge_id(network) == id) {
            Some(format!("edge {id:?} is not on the path"))
        } else if lane.is_some_and(|lane| lane >= lanes) {
            Some(format!("lane is {}, and the edge {id:?} has lanes 0 to {}", lane.unwrap_or(0), lanes - 1))
        } else {
            (at_m >= length_m).then(|| format!("at_m is {at_m}, and the edge {id:?} is {length_m:.1} m long"))
        }
    }
}

impl DrivenRoad<'_> {
    /// Returns the reason why the network has no signal of this name; `None` if it has.
    pub(super) fn no_signal(&self, name: &str) -> Option<String> {
        let names: Vec<&str> = self.map.network.signals().iter().map(|signal| signal.id.as_str()).collect();
        let is_there = names.contains(&name);
        (!is_there).then(|| format!("the network has no signal \"{name}\"{}", did_you_mean(name, &names)))
    }
}

impl Trigger {
    /// Returns the reason why this trigger cannot come true on a road; `None` if it can.
    pub(super) fn unreachable(&self, road: &DrivenRoad) -> Option<String> {
        match self {
            Self::TimeS(time_s) if road.duration_s > 0.0 && *time_s >= road.duration_s => {
                Some(format!("time_s is {time_s}, and the drive ends at {} s", road.duration_s))
            }
            Self::PlaceM(place_m) if *place_m >= road.map.route.length_m() => {
                Some(format!("place_m is {place_m}, and the route is {:.1} m long", road.map.route.length_m()))
            }
            Self::Edge { id, lane, at_m } => road.no_place(id, *lane, *at_m),
            Self::Reaches { place_m, .. } if *place_m >= road.map.route.length_m() => {
                Some(format!("place_m is {place_m}, and the route is {:.1} m long", road.map.route.length_m()))
            }
            Self::Signal { name, .. } => road.no_signal(name),
            Self::SignalAhead { .. } if road.map.network.signals().is_empty() => {
                Some("signal_ahead, and the road has no signals".into())
            }
            Self::All(list) => list.iter().find_map(|trigger| trigger.unreachable(road)),
            Self::Any(list) => {
                let whys: Option<Vec<String>> = list.iter().map(|trigger| trigger.unreachable(road)).collect();
                whys.map(|whys| whys.join("; "))
            }
            _ => None,
        }
    }

    /// Checks whether the trigger looks at the begin of an event.
    pub fn waits_for_begin_of(&self, name: &str) -> bool {
        match self {
            Self::Begun { event, .. } => event == name,
            Self::Any(list) | Self::All(list) => list.iter().any(|trigger| trigger.waits_for_begin_of(name)),
            _ => false,
        }
    }

    /// Returns the names of the events after which this trigger can come true.
    pub fn events_before(&self) -> Vec<&str> {
        match self {
            Self::After { event, .. } | Self::Begun { event, .. } => vec![event],
            Self::Any(list) | Self::All(list) => list.iter().flat_map(Self::events_before).collect(),
            _ => vec![],
        }
    }

    /// Returns the vehicles that the trigger looks at.
    pub fn vehicles(&self) -> Vec<&VehicleName> {
        match self {
            Self::Distance(ahead) => vec![&ahead.of, &ahead.to],
            Self::TimeGap(ahead) | Self::TimeToCollision(ahead) => vec![&ahead.of, &ahead.to],
            Self::Speed { vehicle, than, .. } => std::iter::once(vehicle).chain(than).collect(),
            Self::Reaches { vehicle, .. }
            | Self::Driven { vehicle, .. }
            | Self::Acceleration { vehicle, .. }
            | Self::OffRoad { vehicle, .. } => vec![vehicle],
            Self::Any(list) | Self::All(list) => list.iter().flat_map(Self::vehicles).collect(),
            _ => vec![],
        }
    }

    /// Checks whether the trigger looks at a signal by its name.
    pub(super) fn names_signal(&self) -> bool {
        match self {
            Self::Signal { .. } => true,
            Self::Any(list) | Self::All(list) => list.iter().any(Self::names_signal),
            _ => false,
        }
    }

    /// Returns the condition in words, such as `at 60 s`.
    pub fn in_words(&self) -> String {
        let joined = |list: &[Self], word: &str| list.iter().map(Self::in_words).collect::<Vec<_>>().join(word);
        match self {
            Self::TimeS(time_s) => format!("at {time_s} s"),
            Self::PlaceM(place_m) => format!("at {place_m} m"),
            Self::SpeedAboveMps(speed_mps) => format!("faster than {speed_mps} m/s"),
            Self::SpeedBelowMps(speed_mps) => format!("slower than {speed_mps} m/s"),
            Self::Distance(ahead) => ahead.in_words(),
            Self::TimeGap(ahead) => format!("time gap {}", ahead.in_words("to")),
            Self::TimeToCollision(ahead) => format!("time to collision {}", ahead.in_words("with")),
            Self::Reaches { vehicle, place_m } => format!("{vehicle} at {place_m} m"),
            Self::Speed { vehicle, than, above_mps, below_mps } => {
                let than = than.as_ref().map_or(String::new(), |than| format!(" less that of {than}"));
                format!("speed of {vehicle}{than} {}", limit_in_words((*below_mps, *above_mps), "m/s"))
            }
            Self::Acceleration { vehicle, above_mps2, below_mps2 } => {
                format!("acceleration of {vehicle} {}", limit_in_words((*below_mps2, *above_mps2), "m/s2"))
            }
            Self::OffRoad { vehicle, .. } => format!("{vehicle} off the road"),
            Self::Driven { vehicle, above_m } => format!("{vehicle} driven {above_m} m"),
            Self::Signal { name, light } => format!("signal {name} {}", light.name()),
            Self::Begun { event, delay_s } => format!("{delay_s} s after the begin of \"{event}\""),
            Self::After { event, delay_s, times: 1 } => format!("{delay_s} s after \"{event}\""),
            Self::After { event, delay_s, times } => {
                format!("{delay_s} s after \"{event}\" has ended {times} times")
            }
            Self::Edge { id, lane: None, at_m } => format!("on edge {id} from {at_m} m"),
            Self::Edge { id, lane: Some(lane), at_m } => format!("on lane {lane} of edge {id} from {at_m} m"),
            Self::SignalAhead { light, below_m } => format!("{} signal nearer than {below_m} m", light.name()),
            Self::AdviceChanges => "advice changes".into(),
            Self::Pressed(input) => format!("{} pressed", input.name()),
            Self::Any(list) => joined(list, " or "),
            Self::All(list) => joined(list, ", "),
        }
    }

    /// Returns the inputs of the driver that the trigger looks at.
    pub fn inputs(&self) -> Vec<DriverInput> {
        match self {
            Self::Pressed(input) => vec![*input],
            Self::Any(list) | Self::All(list) => list.iter().flat_map(Self::inputs).collect(),
            _ => vec![],
        }
    }

    /// Checks the values of the condition.
    pub(super) fn check(&self) -> Result<(), String> {
        match self {
            Self::TimeS(time_s) => within("time_s", *time_s, [0.0, LATEST_S]),
            Self::PlaceM(place_m) => within("place_m", *place_m, [0.0, FARTHEST_M]),
            Self::SpeedAboveMps(speed_mps) => within("speed_above_mps", *speed_mps, [0.0, FASTEST_MPS]),
            Self::SpeedBelowMps(speed_mps) => within("speed_below_mps", *speed_mps, [0.0, FASTEST_MPS]),
            Self::Distance(ahead) => ahead.check(),
            Self::TimeGap(ahead) | Self::TimeToCollision(ahead) => ahead.check(),
            Self::Reaches { vehicle, place_m } => {
                within("place_m", *place_m, [0.0, FARTHEST_M]).and_then(|()| check_subject("vehicle", vehicle))
            }
            Self::Speed { vehicle, than, above_mps, below_mps } => {
                let least_mps = if than.is_some() { -FASTEST_MPS } else { 0.0 };
                check_limit((*below_mps, *above_mps), "mps", [least_mps, FASTEST_MPS])?;
                than.as_ref().map_or(Ok(()), |than| check_subject("than", than))?;
                check_subject("vehicle", vehicle)
            }
            Self::Driven { vehicle, above_m } => {
                within("above_m", *above_m, [0.0, FARTHEST_M]).and_then(|()| check_subject("vehicle", vehicle))
            }
            Self::Acceleration { vehicle, above_mps2, below_mps2 } => {
                check_limit((*below_mps2, *above_mps2), "mps2", [-STRONGEST_MPS2, STRONGEST_MPS2])?;
                check_subject("vehicle", vehicle)
            }
            Self::OffRoad { vehicle, beyond_m } => {
                within("beyond_m", *beyond_m, [0.0, 20.0]).and_then(|()| check_subject("vehicle", vehicle))
            }
            Self::Signal { .. } => Ok(()),
            Self::After { times: 0, .. } => Err("times is 0; allowed: 1 or more".into()),
            Self::After { delay_s, .. } | Self::Begun { delay_s, .. } => within("delay_s", *delay_s, [0.0, LATEST_S]),
            Self::Edge { at_m, .. } => within("at_m", *at_m, [0.0, FARTHEST_M]),
            Self::SignalAhead { below_m, .. } => within("below_m", *below_m, [0.1, FARTHEST_M]),
            Self::AdviceChanges | Self::Pressed(_) => Ok(()),
            Self::Any(list) | Self::All(list) if list.is_empty() => {
                Err("a list of conditions is empty; allowed: one or more".into())
            }
            Self::Any(list) | Self::All(list) => list.iter().try_for_each(Self::check),
        }
    }
}
