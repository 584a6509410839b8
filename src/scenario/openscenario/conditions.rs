//! Conditions of OpenSCENARIO. In: elements such as `<StartTrigger>`. Out: [`Trigger`]s of those that codrive has; others are reported with their
//! line, and the group of conditions that contains them never comes true. Seconds, metres, m/s.

use super::{document::Place, fault::OpenScenarioError, parameters::Node, positions::Placement, reader::Reader};
use crate::scenario::scripted_event::EventLight;
use std::cmp::Ordering;

/// Groups of conditions: true if all conditions of one of them are. Without a group it never comes true.
#[derive(Clone, Debug)]
pub(super) struct Trigger {
    pub groups: Vec<Vec<Condition>>,
}

#[derive(Clone, Debug)]
pub(super) struct Condition {
    pub title: String,
    pub delay_s: f64,
    /// True where a condition that is true from the start on does not count.
    pub is_rising: bool,
    pub what: Demand,
    pub place: Place,
}

/// Side of a limit on which a value has to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    Above,
    Below,
}

/// Part of a storyboard that has a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Story,
    Act,
    Group,
    Maneuver,
    Event,
    Action,
}

/// State of a part of the storyboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    Begun,
    /// End of one execution.
    Ended,
    /// End of the last execution.
    Complete,
}

/// Comparison of a value with another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ValueRule {
    /// True where the first may be less than the other, equal to it, and greater.
    allowed: [bool; 3],
}

impl ValueRule {
    /// Checks whether a value compares so with another one: as numbers if both are, otherwise as texts. Texts are only equal or not.
    pub fn is_met(self, value: &str, other: &str) -> bool {
        let numbers = value.trim().parse::<f64>().ok().zip(other.trim().parse::<f64>().ok());
        let order = match numbers {
            Some((value, other)) => value.partial_cmp(&other),
            None if value == other => Some(Ordering::Equal),
            None => None,
        };
        match order {
            Some(order) => self.allowed[(order as i8 + 1) as usize],
            None => self.allowed == UNEQUAL,
        }
    }
}

/// State of the scene that a condition waits for.
#[derive(Clone, Debug)]
pub(super) enum Demand {
    /// Time since the start of the drive above this, s.
    Time(f64),
    /// State of one or all of several entities.
    Entity {
        names: Vec<String>,
        is_all: bool,
        what: EntityDemand,
    },
    /// Begin or end of a part of the storyboard.
    State {
        part: Part,
        name: String,
        state: State,
    },
    /// Value of a parameter, with the value that it has at the start.
    Parameter {
        name: String,
        declared: String,
        rule: ValueRule,
        value: String,
    },
    Signal {
        name: String,
        light: EventLight,
    },
}

/// Condition on an entity.
#[derive(Clone, Debug)]
pub(super) enum EntityDemand {
    /// Time over the distance to another entity.
    TimeGap(Ahead),
    TimeToCollision(Ahead),
    /// Distance to another entity, whichever is ahead.
    Distance(Ahead),
    /// Distance to a place ahead below this, m; true if it counts from the front.
    Near {
        at: Placement,
        below_m: f64,
        is_from_front: bool,
    },
    /// Distance of the reference point to a place at most this, m.
    Reach(Placement, f64),
    /// Distance since the start of the drive above this, m.
    Driven(f64),
    Speed(f64, Rule),
    /// Speed less that of another entity, m/s.
    RelativeSpeed(String, f64, Rule),
    Acceleration(f64, Option<Rule>),
    /// Standstill for this time, s.
    Standstill(f64),
    /// Place beside all lanes for this time, s.
    OffRoad(f64),
    /// Standstill at the end of the path for this time, s.
    RoadEnd(f64),
}

/// Limit of a distance or time to another entity.
#[derive(Clone, Debug)]
pub(super) struct Ahead {
    pub to: String,
    pub limit: f64,
    pub rule: Rule,
    /// True from bumper to bumper, false between reference points.
    pub is_freespace: bool,
}

const RULES: [(&str, Option<Rule>); 6] = [
    ("greaterThan", Some(Rule::Above)),
    ("greaterOrEqual", Some(Rule::Above)),
    ("lessThan", Some(Rule::Below)),
    ("lessOrEqual", Some(Rule::Below)),
    ("equalTo", None),
    ("notEqualTo", None),
];
/// Comparison of texts that differ.
const UNEQUAL: [bool; 3] = [true, false, true];
pub(super) const VALUE_RULES: [(&str, ValueRule); 6] = [
    ("greaterThan", ValueRule { allowed: [false, false, true] }),
    ("greaterOrEqual", ValueRule { allowed: [false, true, true] }),
    ("lessThan", ValueRule { allowed: [true, false, false] }),
    ("lessOrEqual", ValueRule { allowed: [true, true, false] }),
    ("equalTo", ValueRule { allowed: [false, true, false] }),
    ("notEqualTo", ValueRule { allowed: UNEQUAL }),
];
/// Speed below which an entity stands, m/s.
pub(super) const STANDING_MPS: f64 = 0.05;

impl Condition {
    /// Returns the time for which the condition has to be true, s.
    pub fn holds_s(&self) -> f64 {
        match &self.what {
            Demand::Entity {
                what: EntityDemand::Standstill(s) | EntityDemand::OffRoad(s) | EntityDemand::RoadEnd(s),
                ..
            } => s.max(0.0),
            _ => 0.0,
        }
    }
}

impl Reader {
    /// Reads a trigger; `None` without one, which begins at once.
    ///
    /// # Errors
    /// A number or a name is missing or malformed.
    pub fn trigger(&mut self, parent: &Node, name: &str) -> Result<Option<Trigger>, OpenScenarioError> {
        let Some(node) = parent.find(name)? else { return Ok(None) };
        self.expect(&node, &[], &["ConditionGroup"])?;
        let groups = node.all("ConditionGroup")?;
        if groups.is_empty() {
            return Ok(None);
        }
        let mut trigger = Trigger { groups: Vec::new() };
        for group in groups {
            self.expect(&group, &[], &["Condition"])?;
            let mut conditions = Some(Vec::new());
            for condition in group.all("Condition")? {
                let read = self.condition(&condition)?;
                conditions = conditions.zip(read).map(|(mut list, read)| {
                    list.push(read);
                    list
                });
            }
            trigger.groups.extend(conditions.filter(|list| !list.is_empty()));
        }
        Ok(Some(trigger))
    }

    fn condition(&mut self, node: &Node) -> Result<Option<Condition>, OpenScenarioError> {
        self.expect(node, &["name", "delay", "conditionEdge"], &["ByEntityCondition", "ByValueCondition"])?;
        let delay_s = node.find_number("delay")?.unwrap_or(0.0);
        if delay_s < 0.0 {
            return Err(node.fault(format!("delay is {delay_s}; allowed: 0 s or more")));
        }
        let edges = [("rising", Some(true)), ("none", Some(true)), ("risingOrFalling", Some(false)), ("falling", None)];
        let edge =
            if node.find_text("conditionEdge")?.is_some() { node.choice("conditionEdge", &edges)? } else { Some(true) };
        let kind = node.only()?;
        let what = if kind.name() == "ByEntityCondition" { self.by_entity(&kind)? } else { self.by_value(&kind)? };
        // Time only rises.
        let is_known = edge.unwrap_or(false) || (edge.is_some() && matches!(what, Some(Demand::Time(_))));
        if !is_known {
            self.leave_out_part(node, "conditionEdge", "codrive has rising conditions only; it never comes true");
            return Ok(None);
        }
        let place = node.place().clone();
        let is_rising = node.find_text("conditionEdge")?.is_some_and(|word| word == "rising");
        Ok(what.map(|what| Condition { title: node.title(), delay_s, is_rising, what, place }))
    }

    fn by_value(&mut self, node: &Node) -> Result<Option<Demand>, OpenScenarioError> {
        let condition = node.only()?;
        match condition.name() {
            "SimulationTimeCondition" => {
                self.expect(&condition, &["value", "rule"], &[])?;
                let rule = self.rule(&condition)?;
                if rule == Some(Rule::Below) {
                    self.leave_out_part(&condition, "rule", "codrive begins events above a time only");
                }
                Ok((rule == Some(Rule::Above)).then_some(Demand::Time(condition.number("value")?.max(0.0))))
            }
            "StoryboardElementStateCondition" => self.state(&condition),
            "ParameterCondition" => {
                self.expect(&condition, &["parameterRef", "value", "rule"], &[])?;
                let name = condition.text("parameterRef")?;
                let (rule, value) = (condition.choice("rule", &VALUE_RULES)?, condition.text("value")?);
                let declared = condition.declared(&name)?;
                Ok(Some(Demand::Parameter { name, declared, rule, value }))
            }
            "TrafficSignalCondition" => {
                self.expect(&condition, &["name", "state"], &[])?;
                let light = self.light(&condition)?;
                let name = condition.text("name")?;
                Ok(light.map(|light| Demand::Signal { name, light }))
            }
            _ => {
                self.leave_out_unknown(&condition);
                Ok(None)
            }
        }
    }

    fn state(&mut self, node: &Node) -> Result<Option<Demand>, OpenScenarioError> {
        self.expect(node, &["storyboardElementType", "storyboardElementRef", "state"], &[])?;
        let parts = [
            ("story", Part::Story),
            ("act", Part::Act),
            ("maneuverGroup", Part::Group),
            ("maneuver", Part::Maneuver),
            ("event", Part::Event),
            ("action", Part::Action),
        ];
        let states = [
            ("startTransition", Some(State::Begun)),
            ("runningState", Some(State::Begun)),
            ("endTransition", Some(State::Ended)),
            ("completeState", Some(State::Complete)),
            ("stopTransition", None),
            ("skipTransition", None),
            ("standbyState", None),
        ];
        let part = node.choice("storyboardElementType", &parts)?;
        let name = node.text("storyboardElementRef")?;
        let Some(state) = node.choice("state", &states)? else {
            self.leave_out_part(node, "state", "codrive knows begins and ends only; the condition never comes true");
            return Ok(None);
        };
        Ok(Some(Demand::State { part, name, state }))
    }

    fn rule(&mut self, node: &Node) -> Result<Option<Rule>, OpenScenarioError> {
        let rule = node.choice("rule", &RULES)?;
        if rule.is_none() {
            self.leave_out_part(node, "rule", "codrive compares by above and below; the condition never comes true");
        }
        Ok(rule)
    }

    fn by_entity(&mut self, node: &Node) -> Result<Option<Demand>, OpenScenarioError> {
        self.expect(node, &[], &["TriggeringEntities", "EntityCondition"])?;
        let who = node.child("TriggeringEntities")?;
        let is_all = who.choice("triggeringEntitiesRule", &[("any", false), ("all", true), ("none", false)])?;
        if who.text("triggeringEntitiesRule")? == "none" {
            self.leave_out(&who, "codrive has no condition that is true for no entity; it never comes true");
            return Ok(None);
        }
        let names =
            who.all("EntityRef")?.iter().map(|entity| entity.text("entityRef")).collect::<Result<Vec<_>, _>>()?;
        if names.is_empty() {
            return Err(who.fault("it names no entity"));
        }
        let condition = node.child("EntityCondition")?.only()?;
        let what = self.entity_demand(&condition)?;
        Ok(what.map(|what| Demand::Entity { names, is_all, what }))
    }

    fn entity_demand(&mut self, node: &Node) -> Result<Option<EntityDemand>, OpenScenarioError> {
        match node.name() {
            "TimeHeadwayCondition" => Ok(self.ahead(node, None)?.map(EntityDemand::TimeGap)),
            "RelativeDistanceCondition" => Ok(self.ahead(node, None)?.map(EntityDemand::Distance)),
            "TimeToCollisionCondition" => {
                let target = node.child("TimeToCollisionConditionTarget")?.only()?;
                if target.name() != "EntityRef" {
                    self.leave_out(&target, "codrive knows the time to collision with an entity only");
                    return Ok(None);
                }
                Ok(self.ahead(node, Some(target.text("entityRef")?))?.map(EntityDemand::TimeToCollision))
            }
            "DistanceCondition" => self.near(node),
            "ReachPositionCondition" => {
                self.expect(node, &["tolerance"], &["Position"])?;
                let tolerance_m = node.number("tolerance")?;
                Ok(self.position(&node.child("Position")?)?.map(|at| EntityDemand::Reach(at, tolerance_m)))
            }
            "TraveledDistanceCondition" => {
                self.expect(node, &["value"], &[])?;
                Ok(Some(EntityDemand::Driven(node.number("value")?)))
            }
            "SpeedCondition" => {
                self.expect(node, &["value", "rule", "direction"], &[])?;
                if node.find_text("direction")?.is_some_and(|word| word != "longitudinal") {
                    self.leave_out_part(node, "direction", "codrive knows the speed along the road only");
                    return Ok(None);
                }
                let value_mps = node.number("value")?;
                if value_mps == 0.0 && node.text("rule")? == "equalTo" {
                    return Ok(Some(EntityDemand::Speed(STANDING_MPS, Rule::Below)));
                }
                Ok(self.rule(node)?.map(|rule| EntityDemand::Speed(value_mps, rule)))
            }
            "RelativeSpeedCondition" => {
                self.expect(node, &["entityRef", "value", "rule", "direction"], &[])?;
                if node.find_text("direction")?.is_some_and(|word| word != "longitudinal") {
                    self.leave_out_part(node, "direction", "codrive knows the speed along the road only");
                    return Ok(None);
                }
                let (to, value_mps) = (node.text("entityRef")?.to_owned(), node.number("value")?);
                Ok(self.rule(node)?.map(|rule| EntityDemand::RelativeSpeed(to, value_mps, rule)))
            }
            "AccelerationCondition" => {
                self.expect(node, &["value", "rule", "direction"], &[])?;
                if node.find_text("direction")?.is_some_and(|word| word != "longitudinal") {
                    self.leave_out_part(node, "direction", "codrive knows the acceleration along the road only");
                    return Ok(None);
                }
                let value_mps2 = node.number("value")?;
                if node.text("rule")? == "equalTo" {
                    return Ok(Some(EntityDemand::Acceleration(value_mps2, None)));
                }
                Ok(self.rule(node)?.map(|rule| EntityDemand::Acceleration(value_mps2, Some(rule))))
            }
            "OffroadCondition" => {
                self.expect(node, &["duration"], &[])?;
                Ok(Some(EntityDemand::OffRoad(node.number("duration")?)))
            }
            "StandStillCondition" => {
                self.expect(node, &["duration"], &[])?;
                Ok(Some(EntityDemand::Standstill(node.number("duration")?)))
            }
            "EndOfRoadCondition" => {
                self.expect(node, &["duration"], &[])?;
                Ok(Some(EntityDemand::RoadEnd(node.number("duration")?)))
            }
            _ => {
                self.leave_out_unknown(node);
                Ok(None)
            }
        }
    }

    /// Reads a limit of a distance or time along the road; `None` if it is reported.
    fn ahead(&mut self, node: &Node, to: Option<String>) -> Result<Option<Ahead>, OpenScenarioError> {
        let attributes = [
            "entityRef",
            "value",
            "freespace",
            "alongRoute",
            "coordinateSystem",
            "relativeDistanceType",
            "routingAlgorithm",
            "rule",
        ];
        self.expect(node, &attributes, &["TimeToCollisionConditionTarget"])?;
        let (kind, system) = (node.find_text("relativeDistanceType")?, node.find_text("coordinateSystem")?);
        if kind.is_some_and(|kind| !["longitudinal", "cartesianDistance", "euclidianDistance"].contains(&kind.as_str()))
        {
            self.leave_out_part(node, "relativeDistanceType", "codrive measures along the road; it never comes true");
            return Ok(None);
        }
        if system.is_some_and(|system| system == "trajectory") {
            self.leave_out_part(node, "coordinateSystem", "codrive measures along the road; it never comes true");
            return Ok(None);
        }
        let to = match to {
            Some(to) => to,
            None => node.text("entityRef")?,
        };
        let (limit, is_freespace) = (node.number("value")?, node.truth("freespace")?);
        Ok(self.rule(node)?.map(|rule| Ahead { to, limit, rule, is_freespace }))
    }

    fn near(&mut self, node: &Node) -> Result<Option<EntityDemand>, OpenScenarioError> {
        let attributes = [
            "value",
            "freespace",
            "alongRoute",
            "coordinateSystem",
            "relativeDistanceType",
            "routingAlgorithm",
            "rule",
        ];
        self.expect(node, &attributes, &["Position"])?;
        let is_from_front = node.truth("freespace")?;
        let at = self.position(&node.child("Position")?)?;
        if self.rule(node)? != Some(Rule::Below) {
            self.leave_out_part(node, "rule", "codrive knows places that are nearer than a distance only");
            return Ok(None);
        }
        let below_m = node.number("value")?;
        Ok(at.map(|at| EntityDemand::Near { at, below_m, is_from_front }))
    }
}
