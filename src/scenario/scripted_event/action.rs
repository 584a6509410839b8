//! Actions of a scenario's events: what happens on the road, in the car and on its displays. In: one entry of `actions`. Out: a checked [`Action`].
//! Seconds, metres, m/s.

use super::{
    Ask, DrivenRoad, EventLight, FASTEST_MPS, LATEST_S, LaneChange, Meeting, OffsetChange, SpeedChange, Teleport,
    VehicleName, Walk, check_vehicle,
    people::{CyclistRide, PedestrianCrossing},
    within,
};
use crate::{
    map::network::Side,
    snapshot::{Pictogram, ToneSeries},
};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Longest text for the participant, letters: it is read at a glance, beside the speedometer.
const TEXT_LETTERS: usize = 60;
/// Longest sentence to speak, letters: some 15 s of speech.
const SENTENCE_LETTERS: usize = 200;
/// Longest vibration of the wheel, s: a longer one hides the forces of the road.
const LONGEST_PULSE_S: f64 = 10.0;
/// Strongest wind, m/s: a hurricane.
const STRONGEST_WIND_MPS: f64 = 40.0;
/// Strongest acceleration and braking, m/s2: the bound of all vehicles of the traffic.
const HARDEST_MPS2: f64 = crate::traffic::HARDEST_MPS2;

/// Action of an event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Action {
    /// A vehicle brakes evenly.
    Brake {
        /// Vehicle by its place beside the ego, its number, or its name.
        vehicle: VehicleName,
        /// Deceleration, m/s2.
        #[schemars(range(min = 0.1, max = HARDEST_MPS2), extend("unit" = "m/s2"))]
        decel_mps2: f64,
        /// Speed at the end of braking, m/s.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = FASTEST_MPS), extend("unit" = "m/s"))]
        to_mps: f64,
        /// Time for which it keeps that speed, s.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = LATEST_S), extend("unit" = "s"))]
        keep_s: f64,
    },
    /// A vehicle accelerates evenly, as far as the vehicle ahead of it allows.
    Accelerate {
        /// Vehicle by its place beside the ego, its number, or its name.
        vehicle: VehicleName,
        /// Acceleration, m/s2.
        #[schemars(range(min = 0.1, max = HARDEST_MPS2), extend("unit" = "m/s2"))]
        accel_mps2: f64,
        /// Speed at the end, m/s.
        #[schemars(range(min = 0.0, max = FASTEST_MPS), extend("unit" = "m/s"))]
        to_mps: f64,
        /// Time for which it keeps that speed, s.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = LATEST_S), extend("unit" = "s"))]
        keep_s: f64,
    },
    /// A vehicle keeps the speed that it has, as far as the vehicle ahead of it allows.
    KeepSpeed {
        /// Vehicle by its place beside the ego, its number, or its name.
        vehicle: VehicleName,
        /// Duration, s.
        #[schemars(range(min = 0.1, max = LATEST_S), extend("unit" = "s"))]
        for_s: f64,
    },
    /// A vehicle brakes to a standstill and stands with its hazard lights on.
    BreakDown {
        /// Vehicle by its place beside the ego, its number, or its name.
        vehicle: VehicleName,
        /// Deceleration, m/s2.
        #[serde(default = "firm_mps2")]
        #[schemars(range(min = 0.1, max = HARDEST_MPS2), extend("unit" = "m/s2"))]
        decel_mps2: f64,
        /// Time for which it stands, s.
        #[schemars(range(min = 0.0, max = LATEST_S), extend("unit" = "s"))]
        for_s: f64,
    },
    /// A vehicle of a neighbouring lane drives beside the ego's way and changes into its lane close before it.
    CutIn {
        /// Vehicle by its place beside the ego, its number, or its name.
        vehicle: VehicleName,
        /// Gap from the ego's front to its rear when it begins to change lanes, m.
        #[schemars(range(min = 0.5, max = 200.0), extend("unit" = "m"))]
        gap_m: f64,
        /// Time in which the change has to begin, s.
        #[serde(default = "usual_cut_in_s")]
        #[schemars(range(min = 0.1, max = 600.0), extend("unit" = "s"))]
        within_s: f64,
    },
    /// A vehicle changes lanes as soon as there is room; a road user at once.
    ChangeLane(LaneChange),
    /// A road user changes its speed with a shape.
    Speed(SpeedChange),
    /// A road user shifts within its lane or beside it.
    Offset(OffsetChange),
    /// A road user changes its speed so that it meets another vehicle.
    Synchronise(Meeting),
    /// A road user moves along a line of points.
    Walk(Walk),
    /// A road user is at another place at once.
    Teleport(Teleport),
    /// A signal of the network goes to the phase of its program that shows the ego's path this light.
    Signal {
        /// Id of the signal in the network.
        name: String,
        light: EventLight,
    },
    /// End of the drive, before its duration is over.
    EndDrive,
    /// The next signal on the ego's path goes to the phase of its program that shows it this light.
    SignalAhead { light: EventLight },
    /// The accelerator of the ego has no effect.
    PowerLoss {
        /// Duration, s.
        #[schemars(range(min = 0.1, max = LATEST_S), extend("unit" = "s"))]
        for_s: f64,
    },
    /// Wind blows from the side, across the ego's heading.
    SideWind {
        /// Side that it comes from.
        from: Side,
        /// Speed of the wind, m/s.
        #[schemars(range(min = 0.1, max = STRONGEST_WIND_MPS), extend("unit" = "m/s"))]
        wind_mps: f64,
        /// Duration, s.
        #[schemars(range(min = 0.1, max = LATEST_S), extend("unit" = "s"))]
        for_s: f64,
    },
    /// The road is slippery under the ego.
    Friction {
        /// Friction as a share of that at other times.
        #[schemars(range(min = 0.05, max = 1.0))]
        share: f64,
        /// Duration, s.
        #[schemars(range(min = 0.1, max = LATEST_S), extend("unit" = "s"))]
        for_s: f64,
    },
    /// Weather and daylight change, and stay so; what is not stated stays as it is.
    Weather {
        /// Range of sight, km; below 1 km there is fog.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.05, max = 100.0), extend("unit" = "km"))]
        visibility_km: Option<f64>,
        /// Rain, mm/h; the road is wet with it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm/h"))]
        rain_mmph: Option<f64>,
        /// Solar time of day, h.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.0, max = 24.0), extend("unit" = "h"))]
        time_h: Option<f64>,
        /// Duration of the change, s.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = LATEST_S), extend("unit" = "s"))]
        over_s: f64,
    },
    /// A pedestrian crosses the ego's route.
    PedestrianCrosses(PedestrianCrossing),
    /// A cyclist rides along the edge of the ego's route.
    CyclistRides(CyclistRide),
    /// A text appears above the participant's speedometer.
    Message {
        text: String,
        /// Duration, s.
        #[schemars(range(min = 0.1, max = LATEST_S), extend("unit" = "s"))]
        for_s: f64,
    },
    /// A question appears above the participant's speedometer, with answers to choose from.
    Ask(Ask),
    /// A sign appears above the participant's speedometer.
    Pictogram {
        sign: Pictogram,
        /// Duration, s.
        #[schemars(range(min = 0.1, max = LATEST_S), extend("unit" = "s"))]
        for_s: f64,
    },
    /// The tone of a takeover request sounds again and again.
    Sound {
        tone: ToneSeries,
        /// Duration of the series, s.
        #[serde(default = "usual_tones_s")]
        #[schemars(range(min = 0.1, max = LATEST_S), extend("unit" = "s"))]
        for_s: f64,
    },
    /// A voice speaks a sentence.
    Speak { text: String },
    /// The steering wheel vibrates, by its force feedback.
    WheelPulse {
        /// Strength, up to 1.
        #[schemars(range(min = 0.05, max = 1.0))]
        strength: f64,
        /// Duration, s.
        #[schemars(range(min = 0.1, max = LONGEST_PULSE_S), extend("unit" = "s"))]
        for_s: f64,
    },
    /// The advice of the participant's speedometer disappears.
    HideAdvice {
        /// Duration, s.
        #[schemars(range(min = 0.1, max = LATEST_S), extend("unit" = "s"))]
        for_s: f64,
    },
    /// The automation asks the participant to take over.
    TakeoverRequest {
        /// Time after which the system stops by itself, or below level 3 switches off, s.
        #[schemars(range(min = 0.1, max = 600.0), extend("unit" = "s"))]
        lead_s: f64,
    },
    /// The automation is switched on or off, or fails.
    Automation(AutomationSwitch),
}

/// Change of the automation by an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AutomationSwitch {
    On,
    Off,
    /// Off without a request, for the rest of the drive.
    Fails,
}

fn usual_cut_in_s() -> f64 {
    20.0
}

/// Returns the duration of one gentle tone, or of four urgent ones, s.
fn usual_tones_s() -> f64 {
    2.0
}

fn firm_mps2() -> f64 {
    3.0
}

impl Action {
    /// Returns the vehicle that acts; `None` for an action on the participant.
    pub fn vehicle(&self) -> Option<&VehicleName> {
        match self {
            Self::Brake { vehicle, .. }
            | Self::Accelerate { vehicle, .. }
            | Self::KeepSpeed { vehicle, .. }
            | Self::BreakDown { vehicle, .. }
            | Self::CutIn { vehicle, .. }
            | Self::ChangeLane(LaneChange { vehicle, .. })
            | Self::Speed(SpeedChange { vehicle, .. })
            | Self::Offset(OffsetChange { vehicle, .. })
            | Self::Synchronise(Meeting { vehicle, .. })
            | Self::Walk(Walk { vehicle, .. })
            | Self::Teleport(Teleport { vehicle, .. }) => Some(vehicle),
            Self::SignalAhead { .. }
            | Self::Signal { .. }
            | Self::EndDrive
            | Self::PowerLoss { .. }
            | Self::SideWind { .. }
            | Self::Friction { .. }
            | Self::Weather { .. }
            | Self::PedestrianCrosses(_)
            | Self::CyclistRides(_)
            | Self::Message { .. }
            | Self::Ask(_)
            | Self::Pictogram { .. }
            | Self::Sound { .. }
            | Self::Speak { .. }
            | Self::WheelPulse { .. }
            | Self::HideAdvice { .. }
            | Self::TakeoverRequest { .. }
            | Self::Automation(_) => None,
        }
    }

    /// Returns the reason why this action is impossible on a road; `None` if it is possible.
    pub(super) fn impossible(&self, road: &DrivenRoad) -> Option<String> {
        match self {
            Self::ChangeLane(_) | Self::CutIn { .. } if !road.is_open() => Some(
                "allowed: on a network, as vehicles of a closed route keep their lane\n  remedy: a path or a [demand]"
                    .into(),
            ),
            Self::SignalAhead { .. } if road.map.network.signals().is_empty() => {
                Some("the road has no signals\n  remedy: a network with signals".into())
            }
            Self::Signal { name, .. } => road.no_signal(name),
            Self::TakeoverRequest { .. } | Self::Automation(_) if !road.has_automation => {
                Some("the participant's vehicle has no automation\n  remedy: [automation] with a system".into())
            }
            _ => None,
        }
    }

    /// Returns the action with its values, such as `brake (vehicle leader, decel_mps2 4)`.
    pub fn in_words(&self) -> String {
        if matches!(self, Self::EndDrive) {
            return self.name().into();
        }
        let word = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let values = serde_json::to_value(self).unwrap_or_default()[self.name()].take();
        let values = match &values {
            Value::Object(values) => values.iter().map(|(key, value)| format!("{key} {}", word(value))).collect(),
            value => vec![word(value)],
        };
        format!("{} ({})", self.name(), values.join(", "))
    }

    /// Returns the name of the action in a scenario.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Brake { .. } => "brake",
            Self::Accelerate { .. } => "accelerate",
            Self::KeepSpeed { .. } => "keep_speed",
            Self::BreakDown { .. } => "break_down",
            Self::CutIn { .. } => "cut_in",
            Self::ChangeLane(_) => "change_lane",
            Self::Speed(_) => "speed",
            Self::Offset(_) => "offset",
            Self::Synchronise(_) => "synchronise",
            Self::Walk(_) => "walk",
            Self::Teleport(_) => "teleport",
            Self::Signal { .. } => "signal",
            Self::EndDrive => "end_drive",
            Self::SignalAhead { .. } => "signal_ahead",
            Self::PowerLoss { .. } => "power_loss",
            Self::SideWind { .. } => "side_wind",
            Self::Friction { .. } => "friction",
            Self::Weather { .. } => "weather",
            Self::PedestrianCrosses(_) => "pedestrian_crosses",
            Self::CyclistRides(_) => "cyclist_rides",
            Self::Message { .. } => "message",
            Self::Ask(_) => "ask",
            Self::Pictogram { .. } => "pictogram",
            Self::Sound { .. } => "sound",
            Self::Speak { .. } => "speak",
            Self::WheelPulse { .. } => "wheel_pulse",
            Self::HideAdvice { .. } => "hide_advice",
            Self::TakeoverRequest { .. } => "takeover_request",
            Self::Automation(_) => "automation",
        }
    }

    /// Returns the place on the ego's route at which a person waits, or to which a road user is moved; `None` for other actions.
    pub fn place_m(&self) -> Option<f64> {
        match self {
            Self::PedestrianCrosses(crossing) => Some(crossing.place_m),
            Self::CyclistRides(ride) => Some(ride.place_m),
            Self::Teleport(to) => Some(to.place_m),
            _ => None,
        }
    }

    /// Checks whether only road users can carry the action out.
    pub(super) fn needs_road_user(&self) -> bool {
        match self {
            Self::ChangeLane(change) => change.is_for_road_users(),
            _ => matches!(
                self,
                Self::Speed(_) | Self::Offset(_) | Self::Synchronise(_) | Self::Walk(_) | Self::Teleport(_)
            ),
        }
    }

    /// Returns the vehicles other than the acting one that the action names.
    pub(super) fn others(&self) -> Option<&VehicleName> {
        match self {
            Self::ChangeLane(change) => change.of.as_ref(),
            Self::Speed(change) => change.like.as_ref(),
            Self::Synchronise(meeting) => Some(&meeting.with),
            _ => None,
        }
    }

    /// Checks the values of the action.
    pub(super) fn check(&self) -> Result<(), String> {
        match self {
            Self::Brake { decel_mps2: rate_mps2, to_mps, keep_s, .. }
            | Self::Accelerate { accel_mps2: rate_mps2, to_mps, keep_s, .. } => {
                let rate = if matches!(self, Self::Brake { .. }) { "decel_mps2" } else { "accel_mps2" };
                within(rate, *rate_mps2, [0.1, HARDEST_MPS2])?;
                within("to_mps", *to_mps, [0.0, FASTEST_MPS])?;
                within("keep_s", *keep_s, [0.0, LATEST_S])?;
            }
            Self::ChangeLane(change) => change.check()?,
            Self::Speed(change) => change.check()?,
            Self::Offset(change) => change.check()?,
            Self::Synchronise(meeting) => meeting.check()?,
            Self::Walk(walk) => walk.check()?,
            Self::Teleport(to) => to.check()?,
            Self::PedestrianCrosses(crossing) => crossing.check()?,
            Self::CyclistRides(ride) => ride.check()?,
            Self::Ask(ask) => ask.check()?,
            Self::Message { text, for_s } => {
                check_text("text", text, TEXT_LETTERS)?;
                within("for_s", *for_s, [0.1, LATEST_S])?;
            }
            Self::SideWind { wind_mps, for_s, .. } => {
                within("wind_mps", *wind_mps, [0.1, STRONGEST_WIND_MPS])?;
                within("for_s", *for_s, [0.1, LATEST_S])?;
            }
            Self::Friction { share, for_s } => {
                within("share", *share, [0.05, 1.0])?;
                within("for_s", *for_s, [0.1, LATEST_S])?;
            }
            Self::Weather { visibility_km, rain_mmph, time_h, over_s } => {
                if [visibility_km, rain_mmph, time_h].iter().all(|value| value.is_none()) {
                    return Err(
                        "weather changes nothing; allowed: one or more of visibility_km, rain_mmph, time_h".into()
                    );
                }
                // The bounds of the settings of these names.
                visibility_km.map_or(Ok(()), |km| within("visibility_km", km, [0.05, 100.0]))?;
                rain_mmph.map_or(Ok(()), |mmph| within("rain_mmph", mmph, [0.0, 50.0]))?;
                time_h.map_or(Ok(()), |hour| within("time_h", hour, [0.0, 24.0]))?;
                within("over_s", *over_s, [0.0, LATEST_S])?;
            }
            Self::BreakDown { decel_mps2, for_s, .. } => {
                within("decel_mps2", *decel_mps2, [0.1, HARDEST_MPS2])?;
                within("for_s", *for_s, [0.0, LATEST_S])?;
            }
            Self::CutIn { gap_m, within_s, .. } => {
                within("gap_m", *gap_m, [0.5, 200.0])?;
                within("within_s", *within_s, [0.1, 600.0])?;
            }
            Self::WheelPulse { strength, for_s } => {
                within("strength", *strength, [0.05, 1.0])?;
                within("for_s", *for_s, [0.1, LONGEST_PULSE_S])?;
            }
            Self::Speak { text } => check_text("text", text, SENTENCE_LETTERS)?,
            Self::KeepSpeed { for_s, .. }
            | Self::PowerLoss { for_s }
            | Self::Pictogram { for_s, .. }
            | Self::Sound { for_s, .. }
            | Self::HideAdvice { for_s } => {
                within("for_s", *for_s, [0.1, LATEST_S])?;
            }
            Self::TakeoverRequest { lead_s } => within("lead_s", *lead_s, [0.1, 600.0])?,
            Self::SignalAhead { .. } | Self::Signal { .. } | Self::EndDrive | Self::Automation(_) => {}
        }
        self.vehicle().map_or(Ok(()), |name| check_vehicle("vehicle", name))
    }
}

/// Checks the length of the text of a key.
pub(super) fn check_text(key: &str, text: &str, most: usize) -> Result<(), String> {
    let letters = text.chars().count();
    match text.trim().is_empty() || letters > most {
        true => Err(format!("{key} has {letters} letters; allowed: 1 to {most}")),
        false => Ok(()),
    }
}
