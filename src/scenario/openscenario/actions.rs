//! Actions of OpenSCENARIO. In: elements such as `<PrivateAction>`. Out: [`Deed`]s; actions that codrive does not have are reported with their line.
//! Seconds, metres, m/s.

use super::{fault::OpenScenarioError, parameters::Node, positions::Placement, reader::Reader};
use crate::scenario::scripted_event::{ChangeShape, EventLight};

/// Extent of a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Extent {
    /// Change without a duration.
    Step,
    /// Duration, s.
    Time(f64),
    /// Distance, m.
    Distance(f64),
    /// Change per time, m/s or m/s2.
    Rate(f64),
}

/// Shape and extent of a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dynamics {
    pub shape: ChangeShape,
    pub extent: Extent,
}

/// Speed at the end of a change.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum SpeedTarget {
    Absolute(f64),
    Like { entity: String, times: f64, plus_mps: f64, keeps: bool },
}

/// Lane at the end of a change.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum LaneTarget {
    /// Id in the road file.
    Absolute(i32),
    /// Number of lanes to the left of the lane of an entity.
    Beside { entity: String, lanes: i32 },
}

/// Speed at the end of a meeting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MeetingSpeed {
    Absolute(f64),
    /// Sum of the other entity's speed and this.
    Plus(f64),
    /// Product of the other entity's speed and this.
    Times(f64),
}

/// Action that codrive has.
#[derive(Clone, Debug)]
pub(super) enum Deed {
    Speed(Dynamics, SpeedTarget),
    Lane(Dynamics, LaneTarget),
    /// Offset from the middle of the lane, m, in the direction of the road's left, with the largest lateral acceleration, m/s2.
    Offset {
        shape: Option<ChangeShape>,
        most_mps2: Option<f64>,
        to_m: f64,
    },
    Meet {
        other: String,
        place: Placement,
        other_place: Placement,
        speed: Option<MeetingSpeed>,
    },
    Follow(Vec<Placement>),
    Teleport(Placement),
    Route(Vec<Placement>),
    Signal {
        name: String,
        light: EventLight,
    },
    /// New value of a parameter, for conditions on it.
    Parameter {
        name: String,
        value: String,
    },
}

const SHAPES: [(&str, Option<ChangeShape>); 4] = [
    ("linear", Some(ChangeShape::Linear)),
    ("cubic", Some(ChangeShape::Cubic)),
    ("sinusoidal", Some(ChangeShape::Sinusoidal)),
    ("step", None),
];

impl Reader {
    /// Reads an action of an entity; `None` if it is reported.
    ///
    /// # Errors
    /// A number or a name is missing or malformed.
    pub fn private_action(&mut self, node: &Node) -> Result<Option<Deed>, OpenScenarioError> {
        let kind = node.only()?;
        self.expect(node, &[], &[kind.name()])?;
        match kind.name() {
            "LongitudinalAction" | "LateralAction" | "RoutingAction" => {
                let action = kind.only()?;
                self.expect(&kind, &[], &[action.name()])?;
                match action.name() {
                    "SpeedAction" => self.speed_action(&action),
                    "LaneChangeAction" => self.lane_change(&action),
                    "LaneOffsetAction" => self.lane_offset(&action),
                    "AssignRouteAction" => Ok(Some(Deed::Route(self.route_of(&action)?))),
                    "FollowTrajectoryAction" => self.trajectory(&action),
                    _ => self.unknown(&action),
                }
            }
            "SynchronizeAction" => self.meeting(&kind),
            "TeleportAction" => Ok(self.position(&kind.child("Position")?)?.map(Deed::Teleport)),
            "ControllerAction" | "ActivateControllerAction" => {
                let place = kind.place();
                let (file, line) = (place.file.display(), place.line);
                self.problems.note(format!(
                    "{file}:{line}: <{}> has no effect: codrive moves all but the participant's vehicle",
                    kind.name()
                ));
                Ok(None)
            }
            _ => self.unknown(&kind),
        }
    }

    /// Reads an action that belongs to no entity; `None` if it is reported.
    ///
    /// # Errors
    /// A name is missing.
    pub fn global_action(&mut self, node: &Node) -> Result<Option<Deed>, OpenScenarioError> {
        let kind = node.only()?;
        if kind.name() == "ParameterAction" {
            self.expect(&kind, &["parameterRef"], &["SetAction", "ModifyAction"])?;
            let (name, change) = (kind.text("parameterRef")?, kind.only()?);
            kind.declared(&name)?;
            if change.name() != "SetAction" {
                self.leave_out(&change, "codrive sets parameters to stated values only; it stays as it is");
                return Ok(None);
            }
            self.expect(&change, &["value"], &[])?;
            return Ok(Some(Deed::Parameter { name, value: change.text("value")? }));
        }
        if kind.name() != "InfrastructureAction" {
            return self.unknown(&kind);
        }
        let action = kind.child("TrafficSignalAction")?.only()?;
        if action.name() != "TrafficSignalStateAction" {
            return self.unknown(&action);
        }
        self.expect(&action, &["name", "state"], &[])?;
        let light = self.light(&action)?;
        let name = action.text("name")?;
        Ok(light.map(|light| Deed::Signal { name, light }))
    }

    /// Reads the state of a signal; `None` if it is reported.
    pub fn light(&mut self, node: &Node) -> Result<Option<EventLight>, OpenScenarioError> {
        let state = node.text("state")?;
        let light = light_of(&state);
        if light.is_none() {
            let known = "red, red and yellow, yellow or green, as on;off;off";
            self.leave_out_part(node, "state", format!("codrive has no light \"{state}\"; it has {known}"));
        }
        Ok(light)
    }

    fn unknown(&mut self, node: &Node) -> Result<Option<Deed>, OpenScenarioError> {
        self.leave_out_unknown(node);
        Ok(None)
    }

    fn dynamics(&mut self, node: &Node) -> Result<Dynamics, OpenScenarioError> {
        self.expect(node, &["dynamicsShape", "dynamicsDimension", "value", "followingMode"], &[])?;
        let shape = node.choice("dynamicsShape", &SHAPES)?;
        let value = node.number("value")?.abs();
        let dimensions =
            [("time", Extent::Time(value)), ("distance", Extent::Distance(value)), ("rate", Extent::Rate(value))];
        let extent = node.choice("dynamicsDimension", &dimensions)?;
        match shape {
            Some(shape) if value > 0.0 => Ok(Dynamics { shape, extent }),
            shape => Ok(Dynamics { shape: shape.unwrap_or_default(), extent: Extent::Step }),
        }
    }

    fn speed_action(&mut self, node: &Node) -> Result<Option<Deed>, OpenScenarioError> {
        self.expect(node, &[], &["SpeedActionDynamics", "SpeedActionTarget"])?;
        let dynamics = self.dynamics(&node.child("SpeedActionDynamics")?)?;
        let target = node.child("SpeedActionTarget")?.only()?;
        let speed = match target.name() {
            "AbsoluteTargetSpeed" => {
                self.expect(&target, &["value"], &[])?;
                SpeedTarget::Absolute(self.speed(&target)?)
            }
            "RelativeTargetSpeed" => {
                self.expect(&target, &["entityRef", "value", "speedTargetValueType", "continuous"], &[])?;
                let value = target.number("value")?;
                let is_factor = target.choice("speedTargetValueType", &[("delta", false), ("factor", true)])?;
                let (times, plus_mps) = if is_factor { (value, 0.0) } else { (1.0, value) };
                let (entity, keeps) = (target.text("entityRef")?, target.truth("continuous")?);
                SpeedTarget::Like { entity, times, plus_mps, keeps }
            }
            _ => return self.unknown(&target),
        };
        Ok(Some(Deed::Speed(dynamics, speed)))
    }

    fn speed(&mut self, target: &Node) -> Result<f64, OpenScenarioError> {
        let speed_mps = target.number("value")?;
        match speed_mps < 0.0 {
            true => {
                Err(target.fault(format!("value is {speed_mps}; allowed: 0 m/s or more, as nothing drives backwards")))
            }
            false => Ok(speed_mps),
        }
    }

    fn lane_change(&mut self, node: &Node) -> Result<Option<Deed>, OpenScenarioError> {
        self.expect(node, &["targetLaneOffset"], &["LaneChangeActionDynamics", "LaneChangeTarget"])?;
        if node.find_number("targetLaneOffset")?.is_some_and(|offset_m| offset_m != 0.0) {
            self.leave_out_part(node, "targetLaneOffset", "the change ends in the middle of the lane");
        }
        let dynamics = self.dynamics(&node.child("LaneChangeActionDynamics")?)?;
        let target = node.child("LaneChangeTarget")?.only()?;
        let lane = match target.name() {
            "AbsoluteTargetLane" => {
                self.expect(&target, &["value"], &[])?;
                LaneTarget::Absolute(target.whole("value")?)
            }
            "RelativeTargetLane" => {
                self.expect(&target, &["entityRef", "value"], &[])?;
                LaneTarget::Beside { entity: target.text("entityRef")?, lanes: target.whole("value")? }
            }
            _ => return self.unknown(&target),
        };
        Ok(Some(Deed::Lane(dynamics, lane)))
    }

    fn lane_offset(&mut self, node: &Node) -> Result<Option<Deed>, OpenScenarioError> {
        self.expect(node, &["continuous"], &["LaneOffsetActionDynamics", "LaneOffsetTarget"])?;
        let dynamics = node.child("LaneOffsetActionDynamics")?;
        self.expect(&dynamics, &["dynamicsShape", "maxLateralAcc"], &[])?;
        let target = node.child("LaneOffsetTarget")?.only()?;
        if target.name() != "AbsoluteTargetLaneOffset" {
            return self.unknown(&target);
        }
        self.expect(&target, &["value"], &[])?;
        Ok(Some(Deed::Offset {
            shape: dynamics.choice("dynamicsShape", &SHAPES)?,
            most_mps2: dynamics.find_number("maxLateralAcc")?,
            to_m: target.number("value")?,
        }))
    }

    fn meeting(&mut self, node: &Node) -> Result<Option<Deed>, OpenScenarioError> {
        let attributes = ["masterEntityRef", "targetTolerance", "targetToleranceMaster"];
        self.expect(node, &attributes, &["TargetPosition", "TargetPositionMaster", "FinalSpeed"])?;
        let place = self.position(&node.child("TargetPosition")?)?;
        let other_place = self.position(&node.child("TargetPositionMaster")?)?;
        let mut speed = None;
        if let Some(of_end) = node.find("FinalSpeed")? {
            let kind = of_end.only()?;
            for child in kind.children()? {
                self.leave_out(&child, "the speeds need not be steady before the meeting");
            }
            speed = match kind.name() {
                "AbsoluteSpeed" => Some(MeetingSpeed::Absolute(self.speed(&kind)?)),
                "RelativeSpeedToMaster" => {
                    let value = kind.number("value")?;
                    let types = [("delta", MeetingSpeed::Plus(value)), ("factor", MeetingSpeed::Times(value))];
                    Some(kind.choice("speedTargetValueType", &types)?)
                }
                _ => return self.unknown(&kind),
            };
        }
        let other = node.text("masterEntityRef")?;
        let places = place.zip(other_place);
        Ok(places.map(|(place, other_place)| Deed::Meet { other, place, other_place, speed }))
    }

    fn trajectory(&mut self, node: &Node) -> Result<Option<Deed>, OpenScenarioError> {
        let children = ["Trajectory", "TrajectoryRef", "CatalogReference", "TimeReference", "TrajectoryFollowingMode"];
        self.expect(node, &["initialDistanceOffset"], &children)?;
        if node.find_number("initialDistanceOffset")?.is_some_and(|from_m| from_m != 0.0) {
            self.leave_out_part(node, "initialDistanceOffset", "the line is followed from its begin");
        }
        if let Some(timing) = node.find("TimeReference")?.map(|times| times.find("Timing")).transpose()?.flatten() {
            self.leave_out(&timing, "the line is followed at the entity's speed, not by its times");
        }
        let holder = node.find("TrajectoryRef")?.unwrap_or_else(|| node.clone());
        let points = match (holder.find("Trajectory")?, holder.find("CatalogReference")?) {
            (Some(own), _) => self.polyline(&own)?,
            (None, Some(reference)) => self.follow(&reference, |reader, entry| reader.polyline(entry))?,
            (None, None) => return Err(node.fault("<Trajectory> is missing")),
        };
        Ok(points.map(Deed::Follow))
    }

    fn polyline(&mut self, node: &Node) -> Result<Option<Vec<Placement>>, OpenScenarioError> {
        self.expect(node, &["name", "closed"], &["Shape"])?;
        if node.truth("closed")? {
            self.leave_out_part(node, "closed", "the line is followed once");
        }
        let shape = node.child("Shape")?.only()?;
        if shape.name() != "Polyline" {
            self.leave_out(&shape, "codrive follows lines from point to point only");
            return Ok(None);
        }
        let mut points = Vec::new();
        for vertex in shape.all("Vertex")? {
            self.expect(&vertex, &["time"], &["Position"])?;
            match self.position(&vertex.child("Position")?)? {
                Some(point) => points.push(point),
                None => return Ok(None),
            }
        }
        if points.len() < 2 {
            return Err(shape.fault(format!("{} points; allowed: two or more", points.len())));
        }
        Ok(Some(points))
    }
}

/// Returns the light of a signal's state: a word, or the state of each lamp from top to bottom.
fn light_of(state: &str) -> Option<EventLight> {
    let lamps: Vec<&str> = state.split(';').map(str::trim).collect();
    match lamps.as_slice() {
        ["on", "off", "off"] | ["on", "off"] | ["red"] => Some(EventLight::Red),
        ["on", "on", "off"] | ["red_yellow" | "redYellow" | "redAndYellow"] => Some(EventLight::RedYellow),
        ["off", "on", "off"] | ["yellow"] => Some(EventLight::Yellow),
        ["off", "off", "on"] | ["off", "on"] | ["green"] => Some(EventLight::Green),
        _ => None,
    }
}
