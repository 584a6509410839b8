//! Methods section of a paper, to copy. In: analysed drives with their manifests, and the participants. Out: paragraphs of
//! plain text in the past tense. They state only the content of manifests and tables, and the differences between drives.

use super::{
    drivers_section, network_text, ring_text, sample,
    setup_facts::{SetupValue, condition_differences, fact, joined_values},
    sickness_section,
    words::interval,
};
use crate::analysis::{
    data::{StudyParticipants, people::STATES},
    drivers::ParticipantDriver,
    drives::{AnalysedRecording, conditions, is_of_several_people, road_kinds},
    measures::MEASURES,
    text::{count, joined_with_and, number_text},
};
use crate::metrics::registry::unit_text;
use crate::{policy::AUTOMATIC_SHARE, time::TICK_S, units::MPS_PER_MPH};
use std::collections::{BTreeMap, BTreeSet};

/// Returns the paragraphs that are not empty.
pub fn paragraphs(
    drives: &[AnalysedRecording],
    people: &StudyParticipants,
    drivers: &[ParticipantDriver],
) -> Vec<String> {
    let trials: Vec<&AnalysedRecording> = drives.iter().filter(|drive| !drive.found.condition.is_empty()).collect();
    let all: Vec<&AnalysedRecording> = drives.iter().collect();
    // Drives that are the same for everyone, such as practice, are described apart from the trials.
    let main = if trials.is_empty() { &all } else { &trials };
    let others: Vec<&AnalysedRecording> =
        all.iter().filter(|drive| !trials.is_empty() && drive.found.condition.is_empty()).copied().collect();
    let on_rings: Vec<&AnalysedRecording> = main.iter().filter(|drive| drive.network.is_none()).copied().collect();
    let [recruitment, ethics, rig] =
        people.statements.all().map(|(.., text)| text.map_or(String::new(), |text| format!(" {text}")));
    let mut text = vec![
        took_part(&all, people) + &recruitment + &ethics,
        apparatus(&all) + &rig,
        ring_text::traffic(&on_rings),
        network_text::traffic(main),
        advice(main),
    ];
    text.push(design(drives, main, &others));
    text.push(sickness_section::paragraph(people));
    text.push(drivers_section::paragraph(drivers));
    text.push(statistics(drives, people));
    text.retain(|paragraph| !paragraph.is_empty());
    text
}

pub(super) fn joined_texts(drives: &[&AnalysedRecording], of: impl Fn(&AnalysedRecording) -> String) -> String {
    joined_values(drives.iter().map(|drive| SetupValue::Word(of(drive))))
}

/// Returns the verb of `1 drive was`, `3 drives were`.
fn were(n: usize) -> &'static str {
    if n == 1 { "was" } else { "were" }
}

fn took_part(drives: &[&AnalysedRecording], people: &StudyParticipants) -> String {
    let codes: BTreeSet<&str> =
        drives.iter().map(|drive| drive.found.participant.as_str()).filter(|code| !code.is_empty()).collect();
    let is_simulated = drives.iter().all(|drive| drive.setup.is_simulated());
    let (n, kind) = (codes.len(), if is_simulated { "simulated participant" } else { "participant" });
    let plural = if n == 1 { "" } else { "s" };
    let mut text = match (n, is_simulated) {
        (0, true) => format!(
            "{} {} driven by a simulated driver ({}); no person took part.",
            capital(&count(drives.len())),
            were(drives.len()),
            joined_texts(drives, |drive| drive.setup.manifest.driver.replace("simulated: ", "model "))
        ),
        (0, false) => format!(
            "{} {} analysed; the driver's controls were: {}.",
            capital(&count(drives.len())),
            were(drives.len()),
            joined_texts(drives, |drive| drive.setup.manifest.driver.clone())
        ),
        _ => format!("{} of {n} {kind}{plural} {} analysed.", capital(&count(drives.len())), were(drives.len())),
    };
    if n > 0 && is_simulated {
        text += " The study was a rehearsal: every participant was a simulated driver with its own parameters, and no \
                 person took part.";
    } else if n > 0 {
        text += &format!(
            " Participants drove with: {}.",
            joined_texts(drives, |drive| drive.setup.manifest.driver.clone())
        );
    }
    let states: Vec<String> = STATES
        .iter()
        .filter_map(|state| {
            let n = people.all.iter().filter(|person| person.state == *state).count();
            (n > 0).then(|| format!("{n} {}", state.replace('_', " ")))
        })
        .collect();
    if !states.is_empty() {
        text += &format!(" Sessions by state: {}.", joined_with_and(&states));
    }
    let excluded: Vec<String> =
        people.all.iter().filter(|person| person.is_excluded()).map(|person| person.id.clone()).collect();
    if !excluded.is_empty() {
        let s = if excluded.len() == 1 { "" } else { "s" };
        text += &format!(
            " Drives and answers of {} participant{s} ({}) were excluded from the analysis.",
            excluded.len(),
            joined_with_and(&excluded)
        );
    } else if !people.all.is_empty() {
        text += " No participant was excluded.";
    }
    let sample = sample(drives, people);
    if !sample.is_empty() {
        text += &format!(" {sample}");
    }
    text
}

/// Returns the sentences on the participants of these drives who have a trial; empty outside of a study.
pub(super) fn sample(drives: &[&AnalysedRecording], people: &StudyParticipants) -> String {
    let has_conditions = drives.iter().any(|drive| !drive.found.condition.is_empty());
    let trials = drives.iter().filter(|drive| !has_conditions || !drive.found.condition.is_empty());
    let ids: BTreeSet<&str> = trials.map(|drive| drive.found.participant.as_str()).collect();
    sample::sentences(people, &ids.into_iter().filter(|id| !id.is_empty()).collect::<Vec<_>>())
}

fn capital(text: &str) -> String {
    let mut signs = text.chars();
    signs.next().map_or(String::new(), |first| first.to_uppercase().collect::<String>() + signs.as_str())
}

fn apparatus(drives: &[&AnalysedRecording]) -> String {
    let mut text = format!(
        "The drive{} made with {} and analysed with codrive {}.",
        if drives.len() == 1 { " was" } else { "s were" },
        joined_texts(drives, |drive| drive.setup.manifest.program.clone()),
        env!("CARGO_PKG_VERSION")
    );
    let screens: Vec<&AnalysedRecording> =
        drives.iter().filter(|drive| drive.setup.manifest.screen.is_some()).copied().collect();
    if screens.is_empty() {
        text += " No picture was shown.";
    } else {
        let screen = |drive: &AnalysedRecording| {
            let screen = drive.setup.manifest.screen.clone().unwrap_or_default();
            let rate = screen.refresh_hz.map_or(String::new(), |hz| format!(" at {} Hz", number_text(hz)));
            let name = screen.monitor.unwrap_or_else(|| "a monitor".into());
            format!("{name}, {} × {} pixels{rate}", screen.size[0], screen.size[1])
        };
        let view = |drive: &AnalysedRecording| {
            let [wide_m, away_m] = drive.setup.manifest.display_m;
            format!("{} m wide at {} m from the eyes", number_text(wide_m), number_text(away_m))
        };
        text += &format!(
            " The road was shown on {}; the visible picture was {}.",
            joined_texts(&screens, screen),
            joined_texts(&screens, view)
        );
        text += &slow_motion(&screens);
    }
    let steps = joined_values(drives.iter().map(|drive| SetupValue::Number(1.0 / drive.setup.scenario.step_s, "Hz")));
    text + &format!(
        " The ego vehicle and its controls were simulated and recorded at {} Hz, all vehicles at {steps}.",
        number_text(1.0 / TICK_S)
    )
}

/// Share of a drive's length lost to late frames above which the text mentions slow motion.
pub(super) const SLOW_SHARE: f64 = 0.01;

/// Returns the sentence on drives that ran in slow motion; empty if there are none.
fn slow_motion(drives: &[&AnalysedRecording]) -> String {
    let slow: Vec<f64> = drives.iter().map(|drive| drive.dropped_share()).filter(|share| *share > SLOW_SHARE).collect();
    if slow.is_empty() {
        return String::new();
    }
    format!(
        " In {} of {}, pictures came too late, and more than {} % of the time was given up ({:.0} % at the most): the \
         participant saw these drives in slow motion.",
        slow.len(),
        count(drives.len()),
        100.0 * SLOW_SHARE,
        100.0 * slow.iter().copied().fold(0.0, f64::max)
    )
}

fn advice(drives: &[&AnalysedRecording]) -> String {
    let advised: Vec<&AnalysedRecording> =
        drives.iter().filter(|d| d.setup.manifest.policy.name != "none").copied().collect();
    if advised.is_empty() {
        return "No speed was advised.".into();
    }
    let hashes: BTreeSet<&str> =
        advised.iter().filter_map(|drive| drive.setup.manifest.policy.sha256.as_deref()).collect();
    let sum = match hashes.len() {
        1 => format!(" (SHA-256 {}…)", hashes.iter().next().map_or("", |hash| &hash[..hash.len().min(12)])),
        _ => String::new(),
    };
    let asked = joined_texts(&advised, |drive| drive.setup.manifest.policy_asked.clone().unwrap_or_default());
    let asked = if asked.is_empty() { asked } else { format!(", chosen by {asked}") };
    let mps =
        joined_values(advised.iter().map(|d| SetupValue::Number(d.setup.scenario.range_mph * MPS_PER_MPH, "m/s")));
    let dial = joined_texts(&advised, |drive| {
        let (units, dial) = (drive.setup.scenario.display.units.label(), &drive.setup.manifest.dial);
        format!("{units} (full scale {} {})", number_text(dial.full), dial.unit)
    });
    let mut text = format!(
        "A speed was advised by the policy {}{sum}{asked}; an advice was held for {}. The acceptable range reached {} ({mps}) to either \
         side of the advised speed. The speedometer showed {dial}.",
        fact(&advised, "policy"),
        fact(&advised, "hold"),
        fact(&advised, "half width of the advised range"),
    );
    text += &constant_speed(&advised);
    let shams: Vec<&AnalysedRecording> = advised.iter().filter(|d| d.setup.scenario.sham_advice).copied().collect();
    if !shams.is_empty() {
        text += &format!(
            " In {}{}, the advice was a sham: the speedometer showed line and range as with other advice, but the advised speeds had \
             been given to a simulated driver in another drive, so that they had no relation to the traffic around the participant.",
            of_all(&shams, drives),
            in_conditions(&shams)
        );
    }
    let without: Vec<&AnalysedRecording> =
        drives.iter().filter(|d| d.setup.manifest.policy.name == "none").copied().collect();
    if !without.is_empty() {
        text += &format!(
            " In {}{}, no speed was advised, and the speedometer showed neither line nor range.",
            of_all(&without, drives),
            in_conditions(&without)
        );
    }
    text
}

/// Returns the sentence on the speed that the policy `constant` advises; empty if no drive has it.
fn constant_speed(drives: &[&AnalysedRecording]) -> String {
    let speed = |drive: &&AnalysedRecording| match drive.setup.scenario.policy_speed_mps {
        set if set > 0.0 => SetupValue::Number(set, "m/s"),
        _ => SetupValue::Word(format!(
            "{} % of the speed at which evenly spaced vehicles flow on this road",
            number_text(100.0 * AUTOMATIC_SHARE)
        )),
    };
    let constant = drives.iter().filter(|drive| drive.setup.manifest.policy.name == "constant");
    let speeds = joined_values(constant.map(speed));
    if speeds.is_empty() {
        speeds
    } else {
        format!(" The policy constant advised one speed throughout a drive: {speeds}.")
    }
}

/// Returns `8 of 24 drives`.
fn of_all(some: &[&AnalysedRecording], all: &[&AnalysedRecording]) -> String {
    format!("{} of {}", some.len(), count(all.len()))
}

/// Returns the conditions of these drives: ` (condition sham)`; empty for drives without a condition.
fn in_conditions(drives: &[&AnalysedRecording]) -> String {
    let mut names: Vec<String> = Vec::new();
    for name in drives.iter().map(|drive| &drive.found.condition).filter(|name| !name.is_empty()) {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    match names.len() {
        0 => String::new(),
        1 => format!(" (condition {})", names[0]),
        _ => format!(" (conditions {})", joined_with_and(&names)),
    }
}

fn design(drives: &[AnalysedRecording], main: &[&AnalysedRecording], others: &[&AnalysedRecording]) -> String {
    let kind = if others.is_empty() && conditions(drives).is_empty() { "drive" } else { "trial" };
    let lasted =
        joined_values(main.iter().map(|drive| SetupValue::Number((10.0 * drive.duration_s).round() / 10.0, "s")));
    let mut text = match main.len() {
        1 => format!("The {kind} lasted {lasted}."),
        _ => format!("The {kind}s lasted {lasted}."),
    };
    let conditions = conditions(drives);
    if conditions.len() > 1 {
        let each = condition_differences(drives);
        let names: Vec<String> = conditions.iter().map(|(name, _)| name.clone()).collect();
        text += &format!(" There were {} conditions", names.len());
        text += &if each.is_empty() {
            format!(": {}.", joined_with_and(&names))
        } else {
            format!(" ({}).", each.join("; "))
        };
        let orders: BTreeSet<Vec<(&str, &str)>> = by_place(drives).into_values().collect();
        text += &match orders.len() {
            1 => " The order was the same for all participants.".into(),
            n => format!(" There were {n} different orders."),
        };
    } else if let [(name, _)] = &conditions[..] {
        text += &format!(" There was one condition ({name}).");
    }
    let seeds: BTreeSet<u64> = main.iter().map(|drive| drive.setup.scenario.seed).collect();
    text += &match (seeds.len(), main.len()) {
        (1, 1) => format!(" The seed was {}.", seeds.first().unwrap_or(&0)),
        (1, _) => format!(" All drives had the seed {}.", seeds.first().unwrap_or(&0)),
        (n, drives) if n == drives => format!(
            " Each drive had its own seed, from {} to {}.",
            seeds.first().unwrap_or(&0),
            seeds.last().unwrap_or(&0)
        ),
        (n, _) => {
            format!(
                " The drives had {n} seeds, from {} to {}.",
                seeds.first().unwrap_or(&0),
                seeds.last().unwrap_or(&0)
            )
        }
    };
    let paired = main.iter().filter(|drive| drive.found.baseline.is_some()).count();
    if paired > 0 {
        let all =
            if paired == main.len() { "each of them".into() } else { format!("{paired} of {}", count(main.len())) };
        text += &format!(
            " For comparison, {} computed again without advice from the same seed, with the car-following model in \
             place of the driver.",
            if main.len() == 1 { "it was".into() } else { format!("{all} was") }
        );
    }
    if !others.is_empty() {
        let mut segments: Vec<&str> = others.iter().map(|drive| drive.found.segment.as_str()).collect();
        segments.dedup();
        let segments: BTreeSet<&str> = segments.into_iter().collect();
        for segment in segments {
            let of: Vec<&AnalysedRecording> =
                others.iter().filter(|drive| drive.found.segment == segment).copied().collect();
            text += &format!(
                " The segment {segment} ({}) was the same for all participants: {} on {}{} with the policy {}.",
                count(of.len()),
                joined_values(of.iter().map(|drive| SetupValue::Number(drive.duration_s.round(), "s"))),
                fact(&of, "road"),
                vehicles(&of),
                fact(&of, "policy"),
            );
        }
    }
    let hit = drives.iter().filter(|drive| drive.measures.get("contact_count").is_some_and(|n| n > 0.0)).count();
    text += &match (hit, drives.len()) {
        (0, 1) => " There was no contact with another vehicle.".into(),
        (0, _) => " There was no contact with another vehicle in any drive.".into(),
        (_, 1) => " There was contact with another vehicle.".into(),
        (hit, all) => format!(" Contacts with other vehicles happened in {hit} of {}.", count(all)),
    };
    text
}

/// Returns ` with 22 vehicles`; empty on networks, where vehicles enter and leave.
fn vehicles(drives: &[&AnalysedRecording]) -> String {
    if drives.iter().any(|drive| drive.network.is_some()) {
        return String::new();
    }
    format!(" with {} vehicles", fact(drives, "number of vehicles"))
}

/// Returns the trials of each participant in the order of their places: segment and condition.
fn by_place(drives: &[AnalysedRecording]) -> BTreeMap<&str, Vec<(&str, &str)>> {
    let mut trials: Vec<&AnalysedRecording> = drives.iter().filter(|drive| !drive.found.condition.is_empty()).collect();
    trials.sort_by_key(|drive| (&drive.found.segment, drive.found.place.parse::<usize>().unwrap_or(0)));
    let mut orders: BTreeMap<&str, Vec<(&str, &str)>> = BTreeMap::new();
    for drive in trials {
        let found = &drive.found;
        orders.entry(&found.participant).or_default().push((&found.segment, &found.condition));
    }
    orders
}

/// Returns the file's text: the paragraphs, and the measures that a drive has as a table in Markdown.
pub fn text(paragraphs: &[String], drives: &[AnalysedRecording]) -> String {
    let has_value = |k: usize| drives.iter().any(|drive| drive.measures.values.get(k).copied().flatten().is_some());
    let roads = road_kinds(drives);
    let row = |cells: [&str; 3]| format!("| {} |\n", cells.map(|cell| cell.replace('|', "\\|")).join(" | "));
    let measures = MEASURES.iter().enumerate().filter(|(k, _)| has_value(*k));
    let defined: String = measures
        .map(|(_, measure)| row([measure.title, &unit_text(measure.unit), &measure.definition(roads)]))
        .collect();
    let text = paragraphs.join("\n\n") + "\n";
    if defined.is_empty() {
        return text;
    }
    text + "\nMeasures of a drive:\n\n" + &row(["Measure", "Unit", "Definition"]) + &row(["---"; 3]) + &defined
}

fn statistics(drives: &[AnalysedRecording], people: &StudyParticipants) -> String {
    let mut text = String::new();
    let conditions = conditions(drives);
    if is_of_several_people(drives) && !conditions.is_empty() {
        text = format!(
            "For each condition the mean over participants was computed with the {}. Several drives of a participant \
             in a condition counted once, by their mean.",
            interval()
        );
        if conditions.len() > 1 {
            text += " Differences between conditions were computed within participants. The smallest difference \
                     detectable with a power of 80 % at a two-sided level of 5 % was 2.80 standard errors of the \
                     difference (normal approximation, no correction for several comparisons).";
        }
    }
    let mut asked: Vec<&String> = people.scores.iter().map(|score| &score.questionnaire).collect();
    asked.dedup();
    let named = |name: &&String| {
        let about = people.questionnaires.get(*name).map_or("", |about| about.trim_end_matches('.'));
        let about = if about.is_empty() { String::new() } else { format!(" ({about})") };
        format!("{}{about}", name.replace('_', " "))
    };
    if !asked.is_empty() {
        let asked: Vec<String> = asked.iter().map(named).collect();
        text += &format!(" Questionnaires were scored by their own rules: {}.", joined_with_and(&asked));
    }
    text.trim_start().to_owned()
}

#[cfg(test)]
#[path = "methods_tests.rs"]
mod tests;
