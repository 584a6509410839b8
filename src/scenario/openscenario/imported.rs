//! Scenario of an OpenSCENARIO file. In: its settings, road users and events. Out: an [`ImportedScenario`] without events that cannot begin, and the text of
//! its file.

use super::{
    fault::{Problems, Unsupported},
    triggers::any,
};
use crate::{
    scenario::{
        Scenario, ScriptedEvent, road_user,
        scripted_event::{self, Trigger},
    },
    toml_text::FORMAT,
};
use serde::Serialize;
use std::fmt::Write;

/// Keys of road users and events in the order of the text; others follow.
const ORDER: [&str; 12] = [
    "name",
    "kind",
    "place_m",
    "lanes_left",
    "offset_m",
    "against",
    "speed_mps",
    "trigger",
    "holds_s",
    "delay_s",
    "repeats",
    "most_times",
];

/// Scenario of codrive for an OpenSCENARIO file.
#[derive(Debug)]
pub struct ImportedScenario {
    pub scenario: Scenario,
    /// Parts of the file that the scenario does not have.
    pub unsupported: Vec<Unsupported>,
    /// Facts that the user should know.
    pub notes: Vec<String>,
}

impl ImportedScenario {
    /// Returns the text of the scenario's file: a head that names its `source` and what is left out, the settings that differ from their defaults, and the
    /// lists of road users and events.
    pub fn to_toml(&self, source: &str) -> String {
        let mut text = format!("# Imported from {source} (OpenSCENARIO) by codrive scenario import.\n");
        let mut comment = |title: &str, lines: Vec<String>| {
            if !lines.is_empty() {
                let lines = lines.iter().flat_map(|line| line.lines()).map(|line| format!("#   {line}\n"));
                text += &format!("# {title}\n{}", lines.collect::<String>());
            }
        };
        comment("Left out:", self.unsupported.iter().map(ToString::to_string).collect());
        comment("Notes:", self.notes.clone());
        let _ = writeln!(text, "format = {FORMAT}");
        let usual = Scenario::default().to_toml();
        let own = self.scenario.to_toml();
        for line in own.lines().take_while(|line| !line.starts_with('[')) {
            if !line.is_empty() && !usual.lines().any(|other| other == line) {
                text += &format!("{line}\n");
            }
        }
        write_list(&mut text, road_user::KEY, &self.scenario.road_users);
        write_list(&mut text, scripted_event::KEY, &self.scenario.events);
        text
    }
}

/// Adds a list of tables to a text, each value in one line.
fn write_list<T: Serialize>(text: &mut String, key: &str, list: &[T]) {
    let rank = |key: &str| ORDER.iter().position(|own| *own == key).unwrap_or(ORDER.len());
    for entry in list {
        let mut values: Vec<(String, toml::Value)> =
            toml::Table::try_from(entry).unwrap_or_default().into_iter().collect();
        values.sort_by_key(|(key, _)| rank(key));
        let _ = writeln!(text, "\n[[{key}]]");
        for (key, value) in values {
            let _ = writeln!(text, "{key} = {value}");
        }
    }
}

/// Removes events that nothing needs, and those that can never begin, which are noted.
pub(super) fn tidy(events: &mut Vec<ScriptedEvent>, duration_s: f64, problems: &mut Problems) {
    loop {
        let before = events.len();
        let names: Vec<String> = events.iter().map(|event| event.name.clone()).collect();
        let needed: Vec<String> =
            events.iter().flat_map(|event| event.trigger.events_before()).map(str::to_owned).collect();
        events.retain_mut(|event| {
            let is_needed = !event.actions.is_empty() || needed.contains(&event.name);
            let trigger = is_needed.then(|| possible(&event.trigger, &names, duration_s)).flatten();
            if is_needed && trigger.is_none() {
                problems.note(format!("event \"{}\" is left out: it cannot begin before the drive's end", event.name));
            }
            if let Some(trigger) = &trigger {
                event.trigger = trigger.clone();
            }
            trigger.is_some()
        });
        if events.len() == before {
            return;
        }
    }
}

/// Returns the part of a trigger that can come true with these events and before the end; `None` if it cannot.
fn possible(trigger: &Trigger, names: &[String], duration_s: f64) -> Option<Trigger> {
    let of = |one: &Trigger| possible(one, names, duration_s);
    match trigger {
        Trigger::After { event, .. } | Trigger::Begun { event, .. } => names.contains(event).then(|| trigger.clone()),
        Trigger::TimeS(time_s) => (*time_s < duration_s).then_some(Trigger::TimeS(*time_s)),
        Trigger::Any(list) => any(list.iter().filter_map(of).collect()),
        Trigger::All(list) => list.iter().map(of).collect::<Option<Vec<_>>>().map(Trigger::All),
        _ => Some(trigger.clone()),
    }
}
