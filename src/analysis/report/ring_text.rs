//! Closed routes in the methods section: road, vehicles, their drivers, and the hand-over. In: analysed drives. Out: a paragraph.

use super::{
    methods::joined_texts,
    setup_facts::{SetupValue, fact, joined_values},
};
use crate::{
    analysis::{
        drives::AnalysedRecording,
        text::{count, joined_with_and, number_text},
    },
    sim::WAVE_STANDS_S,
    traffic::{RING_STUDY, TrafficDrivers},
};
use std::collections::{BTreeMap, BTreeSet};

/// Returns the paragraph on road, vehicles and their drivers; empty without a drive on a closed route.
pub(super) fn traffic(drives: &[&AnalysedRecording]) -> String {
    if drives.is_empty() {
        return String::new();
    }
    let lengths = joined_values(
        drives.iter().map(|d| d.setup.route_m).filter(|m| *m > 0.0).map(|m| SetupValue::Number(m.round(), "m")),
    );
    let logged = drives.iter().filter(|drive| drive.setup.scenario.traffic.log_file().is_some()).count();
    let kind = match logged {
        0 => "a closed route",
        n if n == drives.len() => "an open lane",
        _ => "a closed route or an open lane",
    };
    let length = if lengths.is_empty() { String::new() } else { format!(", {kind} of {lengths}") };
    let engine = joined_texts(drives, |drive| match drive.setup.manifest.traffic.as_str() {
        named if named.starts_with("native") => "codrive's own engine".into(),
        named => named.replace(" in process", ", run within codrive"),
    });
    let mut text = format!(
        "The road was {}{length}, with {} vehicles, the ego vehicle included. The traffic was computed by {engine}.{}{}",
        fact(drives, "road"),
        fact(drives, "number of vehicles"),
        log_files(drives),
        drivers(drives),
    );
    let bends = joined_values(
        drives.iter().filter_map(|d| Some(SetupValue::Number(d.setup.manifest.lateral_accel_mps2?, "m/s2"))),
    );
    if !bends.is_empty() {
        text += &format!(" In bends, a lateral acceleration of {bends} limited the speed of the other vehicles.");
    }
    let warm_up = if drives.iter().all(|drive| drive.setup.scenario.warm_up_s == 0.0) {
        String::new()
    } else {
        format!(
            ", and the traffic ran for {} before the drive, the ego vehicle driven by the same model",
            fact(drives, "warm-up")
        )
    };
    if logged == drives.len() {
        let start = "All simulated vehicles started at the speed of the vehicle ahead of the ego vehicle";
        return text + &format!(" {start}, each at the gap that its driver keeps{warm_up}.");
    }
    text + &format!(
        " At the start the vehicles stood {}{warm_up}.{}",
        fact(drives, "start of the vehicles"),
        gate(drives)
    )
}

/// Returns a sentence on the files whose vehicles drove ahead of the ego vehicle; empty without one.
fn log_files(drives: &[&AnalysedRecording]) -> String {
    let files = drives.iter().filter_map(|drive| drive.setup.scenario.traffic.log_file());
    let names: BTreeSet<String> =
        files.filter_map(|file| Some(file.file_name()?.to_string_lossy().into_owned())).collect();
    if names.is_empty() {
        return String::new();
    }
    let names: Vec<String> = names.into_iter().collect();
    format!(" The vehicles of {} drove as recorded, whatever others did.", joined_with_and(&names))
}

/// Returns the conditions for handing the car over to the driver, and the number of drives that began without them.
fn gate(drives: &[&AnalysedRecording]) -> String {
    let with_wave = drives.iter().filter(|drive| drive.setup.scenario.wave_sd_mps > 0.0);
    let wave = joined_values(with_wave.map(|drive| SetupValue::Number(drive.setup.scenario.wave_sd_mps, "m/s")));
    let stands = drives.iter().any(|drive| drive.setup.scenario.standing_start);
    let mut conditions = Vec::new();
    if !wave.is_empty() {
        conditions.push(format!(
            "the standard deviation of speed over the vehicles had been {wave} or more for {} s",
            number_text(WAVE_STANDS_S)
        ));
    }
    if stands {
        conditions.push("the ego vehicle stood still".into());
    }
    if conditions.is_empty() {
        return String::new();
    }
    let longest = joined_values(drives.iter().map(|drive| SetupValue::Number(drive.setup.scenario.wave_wait_s, "s")));
    let late = drives.iter().filter(|drive| !drive.setup.manifest.hand_over.is_as_asked).count();
    let late = match late {
        0 => "no drive began otherwise".to_owned(),
        n => format!("{} began otherwise", count(n)),
    };
    format!(
        " The driver then took over as soon as {}, or after a further {longest} at the latest; {late}.",
        joined_with_and(&conditions)
    )
}

/// Returns a sentence for each kind of drivers of the other vehicles.
fn drivers(drives: &[&AnalysedRecording]) -> String {
    let mut by_name: BTreeMap<&str, Vec<&AnalysedRecording>> = BTreeMap::new();
    for drive in drives {
        by_name.entry(&drive.setup.scenario.traffic_drivers).or_default().push(drive);
    }
    let is_only = by_name.len() == 1;
    let sentence = |(name, of): (&&str, &Vec<&AnalysedRecording>)| {
        let which = if is_only { String::new() } else { format!("In {} drives, ", of.len()) };
        let the = if is_only { "The" } else { "the" };
        match TrafficDrivers::named(name, of[0].setup.scenario.idm) {
            Ok(TrafficDrivers::People(population)) => {
                format!(
                    " {which}{the} other vehicles were driven by persons of a population, {}",
                    population.in_words()
                )
            }
            Ok(TrafficDrivers::Alike(_)) => format!(" {which}{the} other vehicles followed {}", ring_study(of)),
            Err(_) => format!(" {which}{the} other vehicles were driven by persons of the population {name}."),
        }
    };
    // The ring study's drivers first, by which a reader knows the others.
    let mut kinds: Vec<(&&str, &Vec<&AnalysedRecording>)> = by_name.iter().collect();
    kinds.sort_by_key(|(name, _)| **name != RING_STUDY);
    kinds.into_iter().map(sentence).collect()
}

/// Returns the model of drivers who are all alike, with its numbers.
fn ring_study(drives: &[&AnalysedRecording]) -> String {
    format!(
        "the Intelligent Driver Model with a desired speed v0 = {}, a desired time gap T = {}, a maximum acceleration a = {}, a comfortable deceleration \
         b = {}, an exponent δ = {} and a minimum gap s0 = {}, and noise of the acceleration of √Δt · N(0, {}) with a step Δt of {}.",
        fact(drives, "desired speed v0"),
        fact(drives, "desired time gap T"),
        fact(drives, "maximum acceleration a"),
        fact(drives, "comfortable deceleration b"),
        fact(drives, "acceleration exponent δ"),
        fact(drives, "minimum gap s0"),
        fact(drives, "acceleration noise"),
        joined_values(drives.iter().map(|drive| SetupValue::Number(drive.setup.scenario.step_s, "s"))),
    )
}
