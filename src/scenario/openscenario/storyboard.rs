//! Storyboard of OpenSCENARIO: what happens at the start, the acts with their events, and the end. In: the element `<Storyboard>`. Out: a
//! [`Storyboard`] of what codrive has; all else is reported with its line.

use super::{
    actions::Deed, conditions::Trigger, document::Place, fault::OpenScenarioError, parameters::Node, reader::Reader,
};

/// Largest number of events of a storyboard.
const MOST_EVENTS: usize = 200;

/// Course of a scenario.
#[derive(Clone, Debug, Default)]
pub(super) struct Storyboard {
    pub init: Vec<InitAction>,
    pub acts: Vec<Act>,
    pub stop: Option<Trigger>,
}

/// Action at the start.
#[derive(Clone, Debug)]
pub(super) struct InitAction {
    /// Entity that acts; `None` for a signal.
    pub entity: Option<String>,
    pub deed: Deed,
    pub place: Place,
}

#[derive(Clone, Debug)]
pub(super) struct Act {
    pub story: String,
    pub name: String,
    /// Trigger of the act; `None` where it begins with the drive.
    pub start: Option<Trigger>,
    pub groups: Vec<Group>,
}

/// Events of the same entities.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub name: String,
    pub actors: Vec<String>,
    pub maneuvers: Vec<Maneuver>,
}

#[derive(Clone, Debug)]
pub(super) struct Maneuver {
    pub name: String,
    pub events: Vec<StoryEvent>,
}

#[derive(Clone, Debug)]
pub(super) struct StoryEvent {
    pub name: String,
    /// True if it ends other events of its maneuver.
    pub is_overriding: bool,
    /// Largest number of times that it begins.
    pub most_times: u32,
    /// Trigger of the event; `None` where it begins with its act.
    pub start: Option<Trigger>,
    pub actions: Vec<StoryAction>,
    pub place: Place,
}

#[derive(Clone, Debug)]
pub(super) struct StoryAction {
    pub name: String,
    /// Action itself; `None` for one that is reported or has no effect.
    pub deed: Option<Deed>,
    pub place: Place,
}

impl Reader {
    /// Reads a storyboard.
    ///
    /// # Errors
    /// A part is missing or malformed, or there are too many events.
    pub fn storyboard(&mut self, node: &Node) -> Result<Storyboard, OpenScenarioError> {
        self.expect(node, &[], &["Init", "Story", "StopTrigger"])?;
        let mut storyboard = Storyboard::default();
        let init = node.child("Init")?;
        self.expect(&init, &[], &["Actions"])?;
        if let Some(actions) = init.find("Actions")? {
            for child in actions.children()? {
                self.init_actions(&child, &mut storyboard.init)?;
            }
        }
        for story in node.all("Story")? {
            self.expect(&story, &["name"], &["Act"])?;
            for act in story.all("Act")? {
                let act = self.act(&act, story.title())?;
                storyboard.acts.push(act);
            }
        }
        let groups = storyboard.acts.iter().flat_map(|act| &act.groups);
        let events: usize = groups.flat_map(|group| &group.maneuvers).map(|maneuver| maneuver.events.len()).sum();
        if events > MOST_EVENTS {
            return Err(node.fault(format!("{events} events; allowed: at most {MOST_EVENTS}")));
        }
        storyboard.stop = self.trigger(node, "StopTrigger")?;
        Ok(storyboard)
    }

    fn init_actions(&mut self, node: &Node, init: &mut Vec<InitAction>) -> Result<(), OpenScenarioError> {
        match node.name() {
            "Private" => {
                self.expect(node, &["entityRef"], &["PrivateAction"])?;
                let entity = Some(node.text("entityRef")?);
                for action in node.all("PrivateAction")? {
                    let deed = self.private_action(&action)?;
                    let (entity, place) = (entity.clone(), action.place().clone());
                    init.extend(deed.map(|deed| InitAction { entity, deed, place }));
                }
            }
            "GlobalAction" => {
                let deed = self.global_action(node)?;
                init.extend(deed.map(|deed| InitAction { entity: None, deed, place: node.place().clone() }));
            }
            _ => self.leave_out_unknown(node),
        }
        Ok(())
    }

    fn act(&mut self, node: &Node, story: String) -> Result<Act, OpenScenarioError> {
        self.expect(node, &["name"], &["ManeuverGroup", "StartTrigger", "StopTrigger"])?;
        let mut groups = Vec::new();
        for group in node.all("ManeuverGroup")? {
            groups.push(self.group(&group)?);
        }
        let stop = node.find("StopTrigger")?.filter(|stop| !stop.element.children.is_empty());
        if let Some(stop) = stop {
            self.leave_out(&stop, "the act goes on until its events are over");
        }
        Ok(Act { story, name: node.text("name")?, start: self.trigger(node, "StartTrigger")?, groups })
    }

    fn group(&mut self, node: &Node) -> Result<Group, OpenScenarioError> {
        self.expect(node, &["name", "maximumExecutionCount"], &["Actors", "CatalogReference", "Maneuver"])?;
        self.once(node)?;
        let actors = node.child("Actors")?;
        self.expect(&actors, &["selectTriggeringEntities"], &["EntityRef"])?;
        if actors.truth("selectTriggeringEntities")? {
            self.leave_out_part(&actors, "selectTriggeringEntities", "the entities that are named act, and no others");
        }
        let names = actors.all("EntityRef")?;
        let actors = names.iter().map(|entity| entity.text("entityRef")).collect::<Result<Vec<_>, _>>()?;
        let mut maneuvers = Vec::new();
        for child in node.children()? {
            match child.name() {
                "Maneuver" => maneuvers.push(self.maneuver(&child)?),
                "CatalogReference" => maneuvers.push(self.follow(&child, Self::maneuver)?),
                _ => {}
            }
        }
        Ok(Group { name: node.text("name")?, actors, maneuvers })
    }

    fn maneuver(&mut self, node: &Node) -> Result<Maneuver, OpenScenarioError> {
        if node.name() != "Maneuver" {
            return Err(node.fault("the entry is no maneuver"));
        }
        self.expect(node, &["name"], &["Event"])?;
        let mut events = Vec::new();
        for event in node.all("Event")? {
            events.push(self.event(&event)?);
        }
        Ok(Maneuver { name: node.text("name")?, events })
    }

    fn event(&mut self, node: &Node) -> Result<StoryEvent, OpenScenarioError> {
        self.expect(node, &["name", "priority", "maximumExecutionCount"], &["Action", "StartTrigger"])?;
        let most_times = match node.find_number("maximumExecutionCount")? {
            Some(count) if count.fract() != 0.0 || !(1.0..=1e6).contains(&count) => {
                return Err(node.fault(format!("maximumExecutionCount is {count}; allowed: a whole number from 1 on")));
            }
            count => count.unwrap_or(1.0) as u32,
        };
        let priorities =
            [("override", Some(true)), ("overwrite", Some(true)), ("parallel", Some(false)), ("skip", None)];
        let priority = node.choice("priority", &priorities)?;
        if priority.is_none() {
            self.leave_out_part(node, "priority", "the event begins beside others of its maneuver");
        }
        let mut actions = Vec::new();
        for action in node.all("Action")? {
            self.expect(&action, &["name"], &["PrivateAction", "GlobalAction", "UserDefinedAction"])?;
            let kind = action.only()?;
            let deed = match kind.name() {
                "PrivateAction" => self.private_action(&kind)?,
                "GlobalAction" => self.global_action(&kind)?,
                _ => {
                    self.leave_out_unknown(&kind);
                    None
                }
            };
            let meaning = match &deed {
                Some(Deed::Route(_)) => Some("codrive knows routes at the start only"),
                Some(Deed::Teleport(to)) if to.is_beside_entity() => {
                    Some("codrive knows places beside entities at the start only")
                }
                _ => None,
            };
            if let Some(meaning) = meaning {
                self.leave_out(&kind.only()?, meaning);
            }
            let deed = deed.filter(|_| meaning.is_none());
            actions.push(StoryAction { name: action.title(), deed, place: action.place().clone() });
        }
        let start = self.trigger(node, "StartTrigger")?;
        let begins_anew = start.is_some() || most_times == 1;
        if !begins_anew {
            let meaning = "the event begins once: without a condition it would begin again at once";
            self.leave_out_part(node, "maximumExecutionCount", meaning);
        }
        let most_times = if begins_anew { most_times } else { 1 };
        let place = node.place().clone();
        let (name, is_overriding) = (node.text("name")?, priority == Some(true));
        Ok(StoryEvent { name, is_overriding, most_times, start, actions, place })
    }

    /// Reports a group that a file wants to be carried out several times.
    fn once(&mut self, node: &Node) -> Result<(), OpenScenarioError> {
        let count = node.find_number("maximumExecutionCount")?.unwrap_or(1.0);
        if count != 1.0 {
            let meaning = format!("it is carried out once, not {count} times");
            self.leave_out_part(node, "maximumExecutionCount", meaning);
        }
        Ok(())
    }
}
