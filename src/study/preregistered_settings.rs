//! Settings and hypotheses as a preregistration states them. In: a study and the plan of its analysis. Out: Markdown. Settings that a
//! condition or a segment changes are listed with the conditions.

use super::{Study, bids::markdown, file::ConditionLevel};
use crate::{
    analysis::{
        MEASURES,
        models::plan::{AnalysisPlan, ExpectedSign},
        text::joined_with_and,
    },
    policy::{self, Controller, Network},
    record::{inputs, manifest::NamedHash},
    scenario::{OnContact, PlannedDrive, Scenario, ScriptedEvent, StartLayout, scripted_event},
    sim::{self, WAVE_STANDS_S},
    traffic::{EngineChoice, TrafficDrivers},
};
use serde::Deserialize;
use serde_json::Value;
use std::fmt::Write;

/// Writes what every drive begins from: road, traffic with its model, start, advice, and what the participant sees.
pub(super) fn settings(out: &mut String, study: &Study) {
    let base = &study.base;
    out.push_str(
        "## Settings\n\nEvery drive has these settings, where its condition or segment changes none of them.\n\n",
    );
    let lines = [road(base), traffic(base), start(base), advice(base), drive(base)];
    lines.into_iter().chain(beside(base)).for_each(|line| {
        let _ = writeln!(out, "* {line}");
    });
    out.push('\n');
}

fn road(base: &Scenario) -> String {
    let drive = PlannedDrive::new(base);
    let length = drive.map_or(String::new(), |drive| {
        let kind = if drive.map().route.is_closed() { "closed route" } else { "path" };
        format!(
            ", a {kind} of {:.0} m, with {} (the participant's included)",
            drive.map().route.length_m(),
            drive.vehicles_text()
        )
    });
    format!("Road: `{}`{length}.", markdown(inputs::last(&base.map)))
}

fn traffic(base: &Scenario) -> String {
    let idm = &base.idm;
    let engine = match &base.traffic {
        EngineChoice::Sumo => "SUMO".to_owned(),
        EngineChoice::Native => "codrive's own engine".to_owned(),
        EngineChoice::Log(file) => {
            format!("codrive's own engine, behind the vehicles of `{}`,", markdown(inputs::last(file)))
        }
    };
    if let Some(persons) = persons(base, &base.traffic_drivers) {
        return format!("Traffic: {engine} in steps of {} s. The other vehicles are driven by {persons}", base.step_s);
    }
    format!(
        "Traffic: {engine} in steps of {} s. The other vehicles follow the Intelligent Driver Model (Treiber, Hennecke and Helbing 2000): desired \
         speed v0 = {} m/s, time gap T = {} s, acceleration a = {} m/s², deceleration b = {} m/s², exponent δ = {}, minimum gap s0 = {} m; \
         noise of the acceleration √Δt · N(0, {}).",
        base.step_s, idm.v0, idm.t, idm.a, idm.b, idm.delta, idm.s0, idm.noise
    )
}

/// Describes the population that drives the other vehicles; `None` if all are driven alike by the base's model.
fn persons(base: &Scenario, drivers: &str) -> Option<String> {
    let Ok(TrafficDrivers::People(population)) = TrafficDrivers::named(drivers, base.idm) else { return None };
    Some(format!("persons of the population `{}`, {}", inputs::last(drivers), markdown(&population.in_words())))
}

/// Describes a setting that a condition changes; sham advice, no advice and events in words.
pub(super) fn changed(key: &str, value: &Value) -> String {
    let text = match value.as_str() {
        Some(text) => markdown(inputs::last(text)),
        None => markdown(&value.to_string()),
    };
    match (key, text.as_str()) {
        (scripted_event::KEY, _) => events(&Vec::deserialize(value).unwrap_or_default()),
        ("sham_advice", "true") => {
            "sham advice (`sham_advice` = true): the advice that the policy gave to a simulated driver in another drive, which does not \
             answer this participant's traffic; the speedometer looks as with other advice"
                .into()
        }
        ("policy", "none") => format!("`{key}` = {text}: no speed is advised, and the speedometer shows neither line nor range"),
        _ => format!("`{key}` = {text}"),
    }
}

/// Describes events, one after the other.
fn events(events: &[ScriptedEvent]) -> String {
    if events.is_empty() {
        return "no events".into();
    }
    let words: Vec<String> = events.iter().map(|event| markdown(&event.in_words())).collect();
    format!("events {}", words.join("; "))
}

/// Describes what the drive has beside road, traffic and advice: events, a secondary task, an automation; empty without any.
fn beside(base: &Scenario) -> Vec<String> {
    let stated = serde_json::to_value(base).unwrap_or_default();
    let usual = serde_json::to_value(Scenario::default()).unwrap_or_default();
    let table = |key: &str, title: &str| {
        let values = stated[key].as_object()?.iter().filter(|(name, value)| usual[key][name.as_str()] != **value);
        let words: Vec<String> =
            values.map(|(name, value)| format!("`{name}` = {}", markdown(&value.to_string()))).collect();
        (!words.is_empty()).then(|| format!("{title}: {}.", words.join(", ")))
    };
    let scripted = (!base.events.is_empty()).then(|| format!("Events: {}.", events(&base.events)));
    [table("automation", "Automation"), table("secondary_task", "Secondary task"), scripted]
        .into_iter()
        .flatten()
        .collect()
}

/// Returns the sentences after the settings of a level: who drives the other vehicles, if the level says so, and what the study's file
/// says about the level.
pub(super) fn about_level(study: &Study, level: &ConditionLevel) -> String {
    let drivers = level.set.get("traffic_drivers").and_then(Value::as_str);
    let driven = drivers.map(|drivers| match persons(&study.base, drivers) {
        Some(persons) => format!("The other vehicles are driven by {persons}"),
        None => "The other vehicles are all driven alike, by the Intelligent Driver Model with the parameters of the settings.".into(),
    });
    let about = (!level.about.is_empty()).then(|| markdown(level.about.trim()));
    driven.into_iter().chain(about).map(|sentences| format!(" {sentences}")).collect()
}

fn start(base: &Scenario) -> String {
    let layout = match base.start {
        StartLayout::Even => "evenly spaced",
        StartLayout::Bunched => "bunched, with one long gap",
    };
    let mut text = format!(
        "Start: the vehicles stand {layout}; the traffic runs for {} s before the participant takes over",
        base.warm_up_s
    );
    if base.wave_sd_mps > 0.0 {
        let _ = write!(
            text,
            "; the drive begins once the standard deviation of speed over the vehicles has been at least {} m/s for {WAVE_STANDS_S} s, or \
             after a further {} s as the traffic then is",
            base.wave_sd_mps, base.wave_wait_s
        );
    }
    let stands = if base.standing_start { "; the participant's vehicle stands" } else { "" };
    text + stands + "."
}

fn advice(base: &Scenario) -> String {
    let file = policy::file_of(&base.policy);
    let NamedHash { name, sha256 } = NamedHash::of(inputs::last(&base.policy), file.as_deref());
    let hash = sha256.map_or(String::new(), |hash| format!(" (file with SHA-256 `{hash}`)"));
    let network = file.and_then(|file| Network::from_file(&file).ok()).map_or(String::new(), |network| about(&network));
    let name = markdown(&name);
    if name == "none" {
        return "Advice: none.".into();
    }
    format!(
        "Advice: policy `{name}`{hash}{network}{}; each advice stands for {} s; the acceptable range is the target ±{} mph.",
        constant_speed(base),
        base.hold_s,
        base.range_mph
    )
}

/// Returns the speed that a drive's policy advises throughout, as a part of a sentence; empty if it advises more than one.
pub(super) fn constant_speed(scenario: &Scenario) -> String {
    let speed = || {
        let settings = sim::policy_settings(&PlannedDrive::new(scenario).ok()?);
        match policy::controller(&scenario.policy, &settings).ok()? {
            Controller::Constant(constant) => Some(constant.speed_mps),
            _ => None,
        }
    };
    speed().map_or(String::new(), |mps| format!(", which advises {mps:.2} m/s throughout"))
}

/// Writes what the study's file states about recruitment, ethics and apparatus, and what it does not state.
pub(super) fn statements(out: &mut String, study: &Study) {
    out.push_str("## Participants and apparatus\n\n");
    for (key, title, stated) in study.file.methods.all() {
        let text = stated.map_or_else(
            || format!("not stated (`{key}` in `[methods]` of the study's file)."),
            |text| markdown(&text),
        );
        let _ = writeln!(out, "* {title}: {text}");
    }
    out.push('\n');
}

/// Returns what a network advises, and from what.
fn about(network: &Network) -> String {
    let word = |value: Value| Some(value.as_str()?.replace('_', " "));
    let advised = serde_json::to_value(network.action).ok().and_then(word).unwrap_or_default();
    let input = |input| word(serde_json::to_value(input).ok()?["feature"].take());
    let inputs: Vec<String> = network.inputs.iter().filter_map(input).collect();
    let layers = network.layers.len();
    format!(", a neural network of {layers} layers whose {advised} is advised, from {}", joined_with_and(&inputs))
}

fn drive(base: &Scenario) -> String {
    let length = if base.duration_s > 0.0 { format!("{} s", base.duration_s) } else { "until it is ended".into() };
    let contact = match base.contact {
        OnContact::Continue => "is recorded, and the drive goes on",
        OnContact::End => "ends the drive",
    };
    format!(
        "Drive: {length}; the speedometer shows {}; a contact with another vehicle {contact}.",
        base.display.units.label()
    )
}

/// Writes one hypothesis about each primary outcome for each contrast.
pub(super) fn hypotheses(out: &mut String, plan: &AnalysisPlan) {
    let about = if plan.primary.all().len() == 1 { "the primary outcome" } else { "the primary outcomes" };
    let _ = writeln!(
        out,
        "## Hypotheses\n\nAbout {about}; all tests are two-sided. A hypothesis with a direction is supported if its p is below \
         the level after correction and the difference has this direction.\n"
    );
    let mut number = 0;
    for (place, name) in plan.primary.all().iter().enumerate() {
        let Some(primary) = MEASURES.iter().find(|measure| measure.name == *name) else { continue };
        for contrast in &plan.contrasts {
            let (condition, reference) = (&contrast.condition, &contrast.reference);
            let says = match contrast.expected_sign(place) {
                Some(ExpectedSign::Greater) => format!("is greater in `{condition}` than in `{reference}`"),
                Some(ExpectedSign::Less) => format!("is less in `{condition}` than in `{reference}`"),
                None => format!("differs between `{condition}` and `{reference}`; no direction is expected"),
            };
            number += 1;
            let _ = writeln!(out, "{number}. {} {says}.", primary.title);
        }
    }
    out.push('\n');
}
