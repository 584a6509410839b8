//! Events of a scenario for the storyboard of an OpenSCENARIO file. In: an [`OpenScenario`] and the network of its road. Out: an
//! [`ImportedScenario`]. Seconds, metres, m/s.

use super::{
    OpenScenario, ParticipantChoice,
    actions::Deed,
    casting::{Cast, Role, lead, unique_name},
    conditions::{Demand, Part},
    document::Place,
    fault::{OpenScenarioError, Problems, Unsupported},
    imported::{ImportedScenario, tidy},
    scene::Scene,
    storyboard::{Act, StoryEvent},
    triggers::{Begin, begun},
};
use crate::{
    map::{OpenDriveRoad, OpenDriveSignal, stop_lines},
    scenario::{
        PlannedDrive, Scenario, ScriptedEvent,
        scripted_event::{Action, EventLight, Trigger},
    },
    settings::Settings,
    toml_text::did_you_mean,
    traffic::EngineChoice,
};
use std::{collections::BTreeMap, sync::Arc};

/// Duration of a scene that names no time at which it ends, s.
const USUAL_S: f64 = 600.0;
/// Step at which triggers are looked at, s: one tick. Other programs look at them each time they draw.
const STEP_S: f64 = 0.01;
/// Largest distances of a light from its stop line and from the path, m.
const TO_LINE_M: f64 = 40.0;
const TO_PATH_M: f64 = 20.0;
/// Kind of lights for people on foot.
const FOR_PEOPLE: &str = "1000002";

/// Numbers of act, group, maneuver and event in the storyboard.
pub(super) type EventKey = [usize; 4];

/// Events in the making.
pub(super) struct Script<'s> {
    pub story: &'s OpenScenario,
    pub scene: &'s Scene<'s>,
    pub cast: &'s Cast,
    pub problems: Problems,
    pub events: Vec<ScriptedEvent>,
    /// Name of each event of the storyboard.
    names: BTreeMap<EventKey, String>,
    /// Trigger that is true from the start of each act on.
    starts: Vec<Option<Trigger>>,
    /// Signal, light, and the event that sets it.
    pub setters: Vec<(String, EventLight, String)>,
    /// Parameter, value, and the event that sets it.
    pub parameters: Vec<(String, String, String)>,
    /// Lane and offset from its middle of each entity, along its road, after the changes so far.
    pub lanes: BTreeMap<String, (i32, f64)>,
}

impl OpenScenario {
    /// Returns the scenario on the network of the file `map`, which was made of the road file.
    ///
    /// # Errors
    /// A name or a place does not exist, the path cannot be driven, or the scenario has values that codrive does not allow.
    pub fn on(&self, map: &str, choice: &ParticipantChoice) -> Result<ImportedScenario, OpenScenarioError> {
        let fault = |message: String| OpenScenarioError { file: self.file.clone(), line: 0, message };
        let (lead, is_driven) = lead(self, choice)?;
        let scene = Scene::new(self, map, &lead)?;
        let mut problems = self.reader.problems.clone();
        let cast = Cast::new(self, &scene, is_driven.then_some(lead.as_str()), &mut problems);
        let lanes = scene.spots.iter().filter_map(|(name, spot)| Some((name.clone(), scene.lane_of(spot)?)));
        let mut script = Script {
            story: self,
            scene: &scene,
            cast: &cast,
            problems,
            events: Vec::new(),
            names: BTreeMap::new(),
            starts: Vec::new(),
            setters: Vec::new(),
            parameters: Vec::new(),
            lanes: lanes.collect(),
        };
        let duration_s = script.write()?;
        let Script { mut events, mut problems, .. } = script;
        tidy(&mut events, duration_s, &mut problems);
        let start = cast.participant.as_ref().and_then(|name| cast.role_of(name, &self.entities[0].place).ok()?);
        let scenario = Scenario {
            map: map.to_owned(),
            path: scene.path.clone(),
            path_start_m: start.map_or(0.0, |role| super::casting::rounded(role.front_at_m(role.place.s_m))),
            start_speed_mps: start.map_or(0.0, |role| role.speed_mps),
            participant: is_driven,
            traffic: EngineChoice::Sumo,
            policy: "none".into(),
            step_s: STEP_S,
            duration_s,
            road_users: cast.users.clone(),
            events,
            ..Scenario::default()
        };
        scenario.check().map_err(|(_, message)| fault(message))?;
        PlannedDrive::on(&scenario, Arc::new(scene.map.clone())).map_err(|error| fault(error.to_string()))?;
        Ok(ImportedScenario { scenario, unsupported: problems.unsupported, notes: problems.notes })
    }
}

impl Script<'_> {
    /// Writes all events. Returns the duration of the drive, s.
    fn write(&mut self) -> Result<f64, OpenScenarioError> {
        let story = self.story;
        self.name_events();
        self.find_setters();
        for (k, act) in story.storyboard.acts.iter().enumerate() {
            let start = self.start_of(act, k)?;
            self.starts.push(start);
        }
        self.write_init()?;
        for key in self.names.keys().copied().collect::<Vec<_>>() {
            self.write_event(key)?;
        }
        self.write_stop()
    }

    /// Returns the acts of the storyboard.
    fn acts(&self) -> &[Act] {
        &self.story.storyboard.acts
    }

    /// Returns an event of the storyboard.
    pub fn event(&self, [act, group, maneuver, event]: EventKey) -> Option<&StoryEvent> {
        self.acts().get(act)?.groups.get(group)?.maneuvers.get(maneuver)?.events.get(event)
    }

    fn name_events(&mut self) {
        let acts = &self.story.storyboard.acts;
        for (a, act) in acts.iter().enumerate() {
            for (g, group) in act.groups.iter().enumerate() {
                for (m, maneuver) in group.maneuvers.iter().enumerate() {
                    for (e, event) in maneuver.events.iter().enumerate() {
                        let taken: Vec<&str> = self.names.values().map(String::as_str).collect();
                        let wanted = if event.name.trim().is_empty() { "event" } else { &event.name };
                        let name = unique_name(wanted, &taken);
                        self.names.insert([a, g, m, e], name);
                    }
                }
            }
        }
    }

    fn find_setters(&mut self) {
        let init = self.init_name();
        let at_start = self.story.storyboard.init.iter().map(|action| (&action.deed, &init));
        let in_events = self.names.iter().flat_map(|(key, event)| {
            let actions = self.event(*key).into_iter().flat_map(|event| &event.actions);
            actions.filter_map(move |action| Some((action.deed.as_ref()?, event)))
        });
        let (mut setters, mut parameters) = (Vec::new(), Vec::new());
        for (deed, event) in at_start.chain(in_events) {
            match deed {
                Deed::Signal { name, light } => setters.push((name.clone(), *light, event.clone())),
                Deed::Parameter { name, value } => parameters.push((name.clone(), value.clone(), event.clone())),
                _ => {}
            }
        }
        self.parameters = parameters;
        self.setters = setters;
    }

    /// Returns the name of the event for actions at the start.
    pub(super) fn init_name(&self) -> String {
        let taken: Vec<&str> = self.names.values().map(String::as_str).collect();
        unique_name("at the start", &taken)
    }

    /// Returns the trigger that is true from the start of an act on; `None` where it never starts.
    fn start_of(&mut self, act: &Act, k: usize) -> Result<Option<Trigger>, OpenScenarioError> {
        let at_once = Trigger::TimeS(0.0);
        let Some(begin) = self.trigger(act.start.as_ref(), &at_once, [k, usize::MAX, 0, 0])? else {
            return Ok(None);
        };
        // A time stays reached.
        if let Trigger::TimeS(time_s) = begin.trigger {
            return Ok(Some(Trigger::TimeS(time_s + begin.delay_s)));
        }
        let name = self.add_mark(&act.name, begin, false);
        Ok(Some(begun(&name)))
    }

    /// Returns the trigger that is true from the start of an act on; `None` where it never starts.
    pub fn act_start(&self, act: usize) -> Option<Trigger> {
        // An act that waits for a later one waits for its own conditions.
        self.starts.get(act).cloned().flatten()
    }

    /// Adds an event without actions. Returns its name.
    pub fn add_mark(&mut self, title: &str, begin: Begin, repeats: bool) -> String {
        let title = if title.trim().is_empty() { "mark" } else { title };
        let name = self.free_name(title);
        let most_times = if repeats { u32::MAX } else { 1 };
        self.add(&name, begin, most_times, vec![]);
        name
    }

    fn free_name(&self, title: &str) -> String {
        let of_events = self.events.iter().map(|event| event.name.as_str());
        let init = self.init_name();
        let mut taken: Vec<&str> = self.names.values().map(String::as_str).chain(of_events).collect();
        taken.push(&init);
        unique_name(title, &taken)
    }

    fn add(&mut self, name: &str, Begin { trigger, holds_s, delay_s }: Begin, most_times: u32, actions: Vec<Action>) {
        self.events.push(ScriptedEvent {
            name: name.to_owned(),
            trigger,
            holds_s,
            delay_s,
            probability: 1.0,
            repeats: most_times > 1,
            most_times: (most_times > 1 && most_times < u32::MAX).then_some(most_times),
            actions,
        });
    }

    /// Writes the actions at the start that are no places, routes or plain speeds.
    fn write_init(&mut self) -> Result<(), OpenScenarioError> {
        let story = self.story;
        let mut actions = Vec::new();
        for init in &story.storyboard.init {
            let entity = init.entity.as_deref();
            if let Some(entity) = entity {
                self.role(entity, &init.place)?;
            }
            if matches!(init.deed, Deed::Teleport(_) | Deed::Route(_)) || init.is_plain_speed() {
                if matches!(init.deed, Deed::Route(_)) && entity.is_some_and(|name| !self.leads(name)) {
                    self.leave_out(&init.place, "AssignRouteAction", "it goes along the path of the ego");
                }
                continue;
            }
            actions.extend(self.action(&init.deed, entity, &init.place)?);
        }
        if !actions.is_empty() {
            let name = self.init_name();
            self.add(&name, Begin::at(Trigger::TimeS(0.0)), 1, actions);
        }
        Ok(())
    }

    fn leads(&self, name: &str) -> bool {
        self.scene.lead == name
    }

    fn write_event(&mut self, key: EventKey) -> Result<(), OpenScenarioError> {
        let story = self.story;
        let [act, group, maneuver, number] = key;
        let group = &story.storyboard.acts[act].groups[group];
        let event = &group.maneuvers[maneuver].events[number];
        let mut actions = Vec::new();
        for action in &event.actions {
            let Some(deed) = &action.deed else { continue };
            if matches!(deed, Deed::Signal { .. } | Deed::Parameter { .. }) {
                actions.extend(self.action(deed, None, &action.place)?);
                continue;
            }
            for actor in &group.actors {
                actions.extend(self.action(deed, Some(actor), &action.place)?);
            }
        }
        let earlier = &group.maneuvers[maneuver].events[..number];
        if event.is_overriding && earlier.iter().any(StoryEvent::keeps_a_speed) && !event.changes_speed() {
            // It ends the other event, and the entity keeps the speed that it has.
            for actor in &group.actors {
                let role = self.role(actor, &event.place)?.filter(|_| !self.cast.is_participant(actor));
                actions.extend(role.map(|role| Action::KeepSpeed { vehicle: role.name, for_s: 0.1 }));
            }
        }
        let start = self.act_start(act);
        let trigger = match &start {
            Some(start) => self.trigger(event.start.as_ref(), start, key)?,
            None => None,
        };
        match trigger {
            Some(trigger) => {
                let name = self.names[&key].clone();
                self.add(&name, trigger, event.most_times, actions);
            }
            None => self.leave_out(&event.place, &format!("Event {}", event.name), "it never begins"),
        }
        Ok(())
    }

    /// Writes the end of the drive. Returns its duration, s.
    fn write_stop(&mut self) -> Result<f64, OpenScenarioError> {
        let story = self.story;
        let mut duration_s: Option<f64> = None;
        let mut others = super::conditions::Trigger { groups: Vec::new() };
        for group in story.storyboard.stop.iter().flat_map(|stop| &stop.groups) {
            match group.as_slice() {
                [only] if matches!(only.what, Demand::Time(_)) => {
                    let Demand::Time(time_s) = only.what else { continue };
                    let end_s = time_s + only.delay_s;
                    duration_s = Some(duration_s.map_or(end_s, |before| before.min(end_s)));
                }
                _ => others.groups.push(group.clone()),
            }
        }
        if !others.groups.is_empty() {
            let at = [usize::MAX; 4];
            if let Some(trigger) = self.trigger(Some(&others), &Trigger::TimeS(0.0), at)? {
                let name = self.free_name("the scene ends");
                self.add(&name, trigger, 1, vec![Action::EndDrive]);
            }
        }
        Ok(duration_s.filter(|end_s| *end_s > 0.0).unwrap_or_else(|| {
            self.problems.note(format!("the scenario names no time of its end: the drive lasts at most {USUAL_S} s"));
            USUAL_S
        }))
    }

    /// Returns the role of an entity; `None` for one that is not there.
    ///
    /// # Errors
    /// The file has no such entity.
    pub fn role(&self, name: &str, place: &Place) -> Result<Option<Role>, OpenScenarioError> {
        Ok(self.cast.role_of(name, place)?.cloned())
    }

    /// Reports a part of the file.
    pub fn leave_out(&mut self, place: &Place, element: &str, meaning: &str) {
        let (file, line) = (place.file.to_path_buf(), place.line);
        self.problems.add(Unsupported { file, line, element: element.to_owned(), meaning: meaning.to_owned() });
    }

    /// Returns the parts of the storyboard of a kind and a name, each with its place and the names of its events. Of a name such as `act::event` the last
    /// part counts.
    pub fn parts(&self, part: Part, name: &str) -> Vec<(EventKey, Vec<String>)> {
        let last = name.rsplit("::").next().unwrap_or(name);
        let mut found: BTreeMap<EventKey, Vec<String>> = BTreeMap::new();
        for (key, event) in &self.names {
            let [a, g, m, _] = *key;
            let own = self.titles(part, *key);
            let of_part = match part {
                Part::Story | Part::Act => [a, 0, 0, 0],
                Part::Group => [a, g, 0, 0],
                Part::Maneuver => [a, g, m, 0],
                Part::Event | Part::Action => *key,
            };
            if own.iter().any(|own| own == name || own == last) {
                found.entry(of_part).or_default().push(event.clone());
            }
        }
        found.into_iter().collect()
    }

    /// Returns the largest number of times that the event of a name begins.
    pub fn most_times(&self, name: &str) -> u32 {
        let key = self.names.iter().find(|(_, own)| *own == name).map(|(key, _)| *key);
        key.and_then(|key| self.event(key)).map_or(1, |event| event.most_times)
    }

    /// Returns the names of all parts of a kind.
    pub fn part_names(&self, part: Part) -> Vec<String> {
        self.names.keys().flat_map(|key| self.titles(part, *key)).collect()
    }

    /// Returns the names of the part of a kind that an event belongs to; of actions all names.
    fn titles(&self, part: Part, key: EventKey) -> Vec<String> {
        let [a, g, m, _] = key;
        let act = &self.acts()[a];
        let (group, event) = (&act.groups[g], self.event(key));
        match part {
            Part::Story => vec![act.story.clone()],
            Part::Act => vec![act.name.clone()],
            Part::Group => vec![group.name.clone()],
            Part::Maneuver => vec![group.maneuvers[m].name.clone()],
            Part::Event => event.map(|event| event.name.clone()).into_iter().collect(),
            Part::Action => event.into_iter().flat_map(|event| &event.actions).map(|own| own.name.clone()).collect(),
        }
    }

    /// Returns the signal of the network that a light of the road file stands for, if it is on the path, and the lights that it can show there.
    ///
    /// # Errors
    /// The road file has no such light.
    pub fn path_signal(
        &self,
        name: &str,
        place: &Place,
    ) -> Result<Option<(String, Vec<EventLight>)>, OpenScenarioError> {
        let all = || self.scene.roads.roads().iter().flat_map(|road| road.signals.iter().map(move |own| (road, own)));
        let Some((road, signal)) = all().find(|(_, signal)| signal.id == name) else {
            let known: Vec<&str> = all().map(|(_, signal)| signal.id.as_str()).collect();
            let near = did_you_mean(name, &known);
            return Err(
                place.fault(format!("the road file has no signal \"{name}\"{near}; it has {}", known.join(", ")))
            );
        };
        Ok(self.signal_on_path(road, signal))
    }

    fn signal_on_path(&self, road: &OpenDriveRoad, signal: &OpenDriveSignal) -> Option<(String, Vec<EventLight>)> {
        let (map, network) = (&self.scene.map, &self.scene.map.network);
        let (point, line_rad) = road.place(signal.s_m, signal.t_m)?;
        let at = map.route.project(point + network.offset(), None);
        let is_along = (line_rad - map.route.yaw_at(at.s_m)).cos() >= 0.0;
        let is_for_path = signal.is_along.is_none_or(|of_signal| of_signal == is_along);
        if signal.kind == FOR_PEOPLE || !is_for_path || at.offset_m.abs() > TO_PATH_M {
            return None;
        }
        let lines = stop_lines(map).into_iter().map(|line| ((line.s_m - at.s_m).abs(), line));
        let near = lines.filter(|(distance_m, _)| *distance_m <= TO_LINE_M).min_by(|a, b| a.0.total_cmp(&b.0));
        let (_, line) = near?;
        let of_network = network.signal(line.signal);
        let phases = of_network.programs.first().map(|program| program.phases.as_slice()).unwrap_or_default();
        let shown =
            |light: &EventLight| phases.iter().any(|phase| phase.light(line.link).is_some_and(|own| light.is(own)));
        let all = [EventLight::Red, EventLight::RedYellow, EventLight::Yellow, EventLight::Green];
        Some((of_network.id.clone(), all.into_iter().filter(shown).collect()))
    }
}
