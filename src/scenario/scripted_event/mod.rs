//! Events of a scenario: what happens on the road, and when. In: the lists `[[event]]` of a scenario file. Out: checked [`ScriptedEvent`]s, each a
//! trigger and its actions; the world carries them out. The words are those of OpenSCENARIO XML where it has one. Seconds, metres, m/s.

mod action;
mod ask;
mod limits;
mod motion;
mod people;
mod trigger;
mod values;
mod vehicle_names;

use super::RoadUser;
use crate::{settings::SettingFault, toml_text::did_you_mean};
pub use action::{Action, AutomationSwitch};
pub use ask::Ask;
pub use limits::{DistanceAhead, TimeAhead};
pub use motion::{ChangeShape, LaneChange, Meeting, OffsetChange, SpeedChange, Teleport, Walk};
pub use people::{CyclistRide, PedestrianCrossing};
use serde::{Deserialize, Serialize};
pub use trigger::{DrivenRoad, DriverInput, EventLight, Trigger};
pub use values::{EGO_NAME, FOLLOWER, LEADER, LEFT_LEADER, PLACES, RIGHT_LEADER, VehicleName};
pub(super) use values::{FARTHEST_M, FASTEST_MPS, MOST_LANES, within};
use values::{LATEST_S, check_vehicle, is_zero};
use vehicle_names::KnownVehicles;

/// Fault of a part of an event, such as `trigger`: the part, the lists of the scenario because of which it is one, and a message.
type PartFault = (String, &'static [&'static str], String);

/// Key of the list of events in a scenario.
pub const KEY: &str = "event";
const EVENTS_KEYS: &[&str] = &[KEY];

/// Largest number of events of a scenario, and of actions of an event.
const MOST_EVENTS: usize = 200;
const MOST_ACTIONS: usize = 20;
/// Longest name, letters.
const NAME_LETTERS: usize = 40;
/// An event of a scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScriptedEvent {
    /// Name, unique in the scenario; the recording has it.
    #[schemars(length(min = 1, max = 40))]
    pub name: String,
    /// Condition at which the event begins.
    pub trigger: Trigger,
    /// Time for which the trigger has to be true before the event begins, s.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = LATEST_S), extend("unit" = "s"))]
    pub holds_s: f64,
    /// Time from its trigger to its begin, after that for which it has to be true, s.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = LATEST_S), extend("unit" = "s"))]
    pub delay_s: f64,
    /// Probability that the event begins when its trigger comes true, drawn from the scenario's seed.
    #[serde(default = "certain", skip_serializing_if = "is_certain")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub probability: f64,
    /// True for an event that begins anew each time its trigger comes true, false for one that begins once.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub repeats: bool,
    /// Largest number of times that an event that repeats begins; without it any number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub most_times: Option<u32>,
    /// Actions, which begin together; without any, the event is a mark in the recording.
    #[schemars(length(max = 20))]
    pub actions: Vec<Action>,
}

fn certain() -> f64 {
    1.0
}

fn is_certain(probability: &f64) -> bool {
    *probability >= 1.0
}

impl ScriptedEvent {
    /// Returns the event in words: name, trigger and actions, and its chance if it is not certain.
    pub fn in_words(&self) -> String {
        let actions: Vec<String> = self.actions.iter().map(Action::in_words).collect();
        let chance = if is_certain(&self.probability) {
            String::new()
        } else {
            format!(", with probability {}", self.probability)
        };
        let repeats = match (self.repeats, self.most_times) {
            (false, _) => String::new(),
            (true, None) => ", each time".into(),
            (true, Some(most)) => format!(", at most {most} times"),
        };
        let holds = if is_zero(&self.holds_s) { String::new() } else { format!(" for {} s", self.holds_s) };
        let delay = if is_zero(&self.delay_s) { String::new() } else { format!(", {} s later", self.delay_s) };
        let actions = if actions.is_empty() { "a mark".into() } else { actions.join(" and ") };
        format!("\"{}\" {}{holds}{delay}{repeats}{chance}: {actions}", self.name, self.trigger.in_words())
    }

    /// Checks whether an action speaks a sentence.
    pub fn speaks(&self) -> bool {
        self.actions.iter().any(|action| matches!(action, Action::Speak { .. }))
    }

    /// Checks whether the trigger or an action names a signal.
    pub fn names_signal(&self) -> bool {
        self.trigger.names_signal() || self.actions.iter().any(|action| matches!(action, Action::Signal { .. }))
    }

    /// Returns the faults of the events of a scenario: of each alone, names that are not unique, events that wait for themselves, and actions for
    /// others that only road users can carry out.
    pub fn faults(events: &[Self], users: &[RoadUser]) -> Vec<SettingFault> {
        if events.len() > MOST_EVENTS {
            let message = format!("{} events; allowed: at most {MOST_EVENTS}", events.len());
            return vec![SettingFault::new(format!("{KEY}.{MOST_EVENTS}"), &[], message)];
        }
        let mut faults = Vec::new();
        for (k, event) in events.iter().enumerate() {
            let located = |(part, others, message): PartFault| {
                SettingFault::new(format!("{KEY}.{k}.{part}"), others, format!("event \"{}\": {message}", event.name))
            };
            let of_event = event.own_faults(&events[..k]).into_iter().chain(event.action_faults(users));
            faults.extend(of_event.chain(event.waiting_fault(events)).map(located));
        }
        faults
    }

    /// Returns the faults of the event's values, apart from its actions. Other events are before it.
    fn own_faults(&self, before: &[Self]) -> Vec<PartFault> {
        let mut faults: Vec<PartFault> = Vec::new();
        let mut add = |part: &str, message: String| faults.push((part.into(), &[], message));
        let letters = self.name.chars().count();
        if self.name.trim().is_empty() || letters > NAME_LETTERS {
            add("name", format!("the name has {letters} letters; allowed: 1 to {NAME_LETTERS}"));
        } else if before.iter().any(|other| other.name == self.name) {
            add("name", "another event has this name; allowed: one for each".into());
        }
        let numbers = [
            ("probability", self.probability, [0.0, 1.0]),
            ("holds_s", self.holds_s, [0.0, LATEST_S]),
            ("delay_s", self.delay_s, [0.0, LATEST_S]),
        ];
        let numbers = numbers.map(|(part, value, bounds)| (part, within(part, value, bounds)));
        for (part, checked) in [("trigger", self.trigger.check())].into_iter().chain(numbers) {
            if let Err(message) = checked {
                add(part, message);
            }
        }
        if let Some(most) = self.most_times
            && (most == 0 || !self.repeats)
        {
            add("most_times", format!("most_times is {most}; allowed: 1 or more, with repeats = true"));
        }
        faults
    }

    /// Returns the faults of the event's actions in a scenario with these road users.
    fn action_faults(&self, users: &[RoadUser]) -> Vec<PartFault> {
        if self.actions.len() > MOST_ACTIONS {
            let message = format!("{} actions; allowed: at most {MOST_ACTIONS}", self.actions.len());
            return vec![("actions".into(), &[], message)];
        }
        let mut faults: Vec<PartFault> = Vec::new();
        for (n, action) in self.actions.iter().enumerate() {
            let mut add = |others, message| faults.push((format!("actions.{n}"), others, message));
            if let Err(message) = action.check() {
                add(&[], message);
            }
            if let Err(message) = check_road_user(action, users) {
                add(&[super::road_user::KEY], message);
            }
            let is_user = |name: &VehicleName| users.iter().any(|user| user.name == *name);
            let same = |other: &&Action| other.vehicle().is_some() && other.vehicle() == action.vehicle();
            let twice = self.actions[..n].iter().find(same).and_then(|_| action.vehicle());
            if let Some(of) = twice.filter(|name| !is_user(name)) {
                let message = format!(
                    "two actions for the vehicle {of}; allowed: one at a time\n  remedy: a second event with trigger = {{ after = {{ event = \"{}\" }} }}",
                    self.name
                );
                add(&[super::road_user::KEY], message);
            }
        }
        faults
    }

    /// Returns the fault of an event that waits for an unknown one, or for one that waits for it.
    fn waiting_fault(&self, events: &[Self]) -> Option<PartFault> {
        let names: Vec<&str> = events.iter().map(|event| event.name.as_str()).collect();
        self.trigger.events_before().into_iter().find_map(|before| {
            let message = if !names.contains(&before) {
                let nearest = did_you_mean(before, &names);
                format!("no event has the name \"{before}\"{nearest}")
            } else if Self::waits_for(events, before, &self.name) {
                format!("it waits for \"{before}\", which waits for it; neither can begin")
            } else {
                return None;
            };
            // Names of other events may be at fault.
            Some(("trigger".into(), EVENTS_KEYS, message))
        })
    }

    /// Checks that each event can begin on the road of its drive, and that its actions are possible there.
    ///
    /// # Errors
    /// The first fault: the part of the list, such as `.0.actions.1`, and a message with value and remedy.
    pub fn check_on(events: &[Self], road: &DrivenRoad) -> Result<(), (String, String)> {
        let known = KnownVehicles::new(road);
        for (k, event) in events.iter().enumerate() {
            let of_trigger = |why| (format!(".{k}.trigger"), format!("event \"{}\"{why}", event.name));
            if let Some(why) = event.trigger.unreachable(road) {
                return Err(of_trigger(format!(" can never begin: {why}")));
            }
            known.check_trigger(&event.trigger).map_err(|why| of_trigger(format!(": trigger: {why}")))?;
            let length_m = road.map.route.length_m();
            for (n, action) in event.actions.iter().enumerate() {
                let fault = |why| Err((format!(".{k}.actions.{n}"), format!("event \"{}\": {why}", event.name)));
                if let Some(place_m) = action.place_m().filter(|m| *m >= length_m) {
                    return fault(format!("place_m is {place_m}, and the route is {length_m:.1} m long"));
                }
                if let Some(why) = action.impossible(road) {
                    return fault(format!("{}; {why}", action.name()));
                }
                known.check_action(action).or_else(|why| fault(format!("{}: {why}", action.name())))?;
            }
        }
        Ok(())
    }

    /// Checks whether an event can begin only after another has ended.
    fn waits_for(events: &[Self], name: &str, other: &str) -> bool {
        let (mut known, mut todo) = (vec![name], vec![name]);
        while let Some(name) = todo.pop() {
            if name == other {
                return true;
            }
            let event = events.iter().find(|event| event.name == name);
            for before in event.into_iter().flat_map(|event| event.trigger.events_before()) {
                if !known.contains(&before) {
                    known.push(before);
                    todo.push(before);
                }
            }
        }
        false
    }
}

/// Checks that an action that only road users can carry out is for one of these, and that it names no vehicle of the traffic.
fn check_road_user(action: &Action, users: &[RoadUser]) -> Result<(), String> {
    let names: Vec<&str> = users.iter().map(|user| user.name.as_str()).collect();
    let Some(name) = action.vehicle().filter(|_| action.needs_road_user()) else { return Ok(()) };
    let fault = |name: &str, more: &str, remedy: &str| {
        let allowed = if names.is_empty() { "none in this scenario".to_owned() } else { names.join(", ") };
        Err(format!(
            "{}: \"{name}\" is no road user{}; allowed: {more}{allowed}\n  remedy: a [[road_user]] of this name{remedy}",
            action.name(),
            did_you_mean(name, &names)
        ))
    };
    if !names.contains(&name.as_str()) {
        return fault(
            name,
            "",
            ", or brake, accelerate and a plain change_lane, which are for vehicles of the traffic",
        );
    }
    match action.others().filter(|other| *other != EGO_NAME && !names.contains(&other.as_str())) {
        Some(other) => fault(other, "ego, ", ""),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use crate::scenario::Scenario;

    const BRAKES: &str = "[[event]]\nname = \"brakes\"\ntrigger = { time_s = 30 }\nactions = [{ brake = { vehicle = \"leader\", decel_mps2 = 4 } }]\n";

    fn fault(text: &str) -> String {
        Scenario::from_toml(text, "trial.toml").unwrap_err().message
    }

    #[test]
    fn events_read_back_from_the_text_of_a_scenario() {
        let text = format!(
            "{BRAKES}[[event]]\nname = \"word\"\nprobability = 0.5\nrepeats = true\n\
             trigger = {{ all = [{{ pressed = \"brake\" }}, {{ after = {{ event = \"brakes\", delay_s = 2 }} }}, {{ distance = {{ to = \"7\", below_m = 25 }} }}] }}\n\
             actions = [{{ message = {{ text = \"Well done\", for_s = 3 }} }}, {{ change_lane = {{ vehicle = \"bus\", to_the_left = -1 }} }}]\n"
        );
        let scenario = Scenario::from_toml(&text, "trial.toml").unwrap_or_else(|fault| panic!("{fault}"));
        assert_eq!(scenario.events.len(), 2);
        assert_eq!((scenario.events[0].probability, scenario.events[1].repeats), (1.0, true));
        assert_eq!(Scenario::from_toml(&scenario.to_toml(), "x").unwrap(), scenario);
    }

    #[test]
    fn a_fault_names_line_value_and_what_is_allowed() {
        let change = |from: &str, to: &str| fault(&BRAKES.replace(from, to));
        let cases = [
            ("= 4 }", "= 40 }", ["trial.toml:4", "decel_mps2 is 40; allowed: 0.1 to 9"]),
            ("time_s = 30", "time_s = -1", ["trial.toml:3", "time_s is -1; allowed: 0 to 604800"]),
            ("time_s", "tim_s", ["trial.toml:3", "time_s"]),
            ("\"leader\"", "\"0\"", ["trial.toml:4", "vehicle is \"0\""]),
            ("\"brakes\"", "\"\"", ["trial.toml:2", "0 letters"]),
            ("brake = {", "brak = {", ["trial.toml:4", "did you mean `brake`"]),
            (
                "time_s = 30",
                "distance = { to = \"follower\", below_m = 9 }",
                ["trial.toml:3", "to is \"follower\"; allowed: a vehicle that can be ahead"],
            ),
        ];
        for (from, to, words) in cases {
            let fault = change(from, to);
            assert!(words.iter().all(|word| fault.contains(word)), "{to}: {fault}");
        }
        assert!(
            fault(&format!("{BRAKES}{BRAKES}")).contains("trial.toml:6"),
            "{}",
            fault(&format!("{BRAKES}{BRAKES}"))
        );
    }

    #[test]
    fn events_that_wait_for_each_other_and_for_unknown_ones_are_faults() {
        let after = |name: &str, before: &str| {
            BRAKES
                .replace("\"brakes\"", &format!("\"{name}\""))
                .replace("time_s = 30", &format!("after = {{ event = \"{before}\" }}"))
        };
        let circle = fault(&(after("a", "b") + &after("b", "c") + &after("c", "a")));
        assert!(circle.contains("trial.toml:3") && circle.contains("neither can begin"), "{circle}");
        assert!(fault(&after("a", "a")).contains("neither can begin"));
        let unknown = fault(&(BRAKES.to_owned() + &after("b", "brake")));
        assert!(unknown.contains("trial.toml:7") && unknown.contains("did you mean brakes?"), "{unknown}");
        assert!(Scenario::from_toml(&(BRAKES.to_owned() + &after("b", "brakes") + &after("c", "b")), "x").is_ok());
    }
}
