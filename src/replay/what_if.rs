//! Recorded drive with changes: the seed, road, traffic and length stay the same unless changed. In: a recording and changes.
//! Out: another recording, by a simulated driver, and the differences between the two.

use super::{Replay, recorded_scenario};
use crate::{
    drive_loop::{RunError, offline::OfflineDrive},
    record::{self, Manifest, Table, inputs},
    scenario::Scenario,
    settings::Field,
    sim::{Summary, SummaryAccumulator},
    time::Tick,
    toml_text::did_you_mean,
};
use serde_json::Value;
use std::{
    path::Path,
    sync::atomic::{AtomicBool, Ordering},
};

/// Summaries of the recorded drive and of the changed one.
#[derive(Clone, Debug, PartialEq)]
pub struct WhatIfComparison {
    /// Drivers of both drives: recorded, instead.
    pub drivers: [String; 2],
    /// Policies of both drives: recorded, instead.
    pub policies: [String; 2],
    /// True if the recorded drive could be driven again to the bit.
    pub is_proven: bool,
    /// Summary of the recorded drive, as driven again.
    pub recorded: Summary,
    /// Summary of the changed drive.
    pub instead: Summary,
}

/// Examples of changes, for messages.
const EXAMPLE: &str = "for example policy=none, driver=perfect, hold_s=5, or none for the baseline without advice";

/// Reason why a change cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ChangeFault {
    /// Text that is no setting and value.
    #[error("--what-if is {}; allowed: SETTING=VALUE, {}", .0, EXAMPLE)]
    NoPair(String),
    /// Name that no setting has.
    #[error("--what-if {pair}: there is no setting {key}{near}; {}", EXAMPLE)]
    UnknownSetting {
        /// Change that was asked for.
        pair: String,
        /// Name of the setting in it.
        key: String,
        /// Suggestion of the nearest name; empty if none is near.
        near: String,
    },
    /// Value that the setting does not allow.
    #[error("--what-if {pair}: {fault}")]
    Value {
        /// Change that was asked for.
        pair: String,
        /// Description of the fault, with the allowed values.
        fault: String,
    },
}

/// Parses changes such as `policy=none` or `driver=perfect`. `none` alone is the usual baseline: no advice and the
/// car-following model.
///
/// # Errors
/// A text names no setting, or a value is not allowed.
pub fn changes(asked: &[String]) -> Result<Vec<(Field, Value)>, ChangeFault> {
    let known = Scenario::fields();
    let mut changes = Vec::new();
    for text in asked {
        let pairs = if text == "none" { vec!["policy=none", "driver=idm"] } else { vec![text.as_str()] };
        for pair in pairs {
            let (key, value) = pair.split_once('=').ok_or_else(|| ChangeFault::NoPair(pair.into()))?;
            let field = known.iter().find(|field| field.path == key || field.flag() == key);
            let field = field.ok_or_else(|| {
                let names: Vec<&str> = known.iter().map(|field| field.path.as_str()).collect();
                ChangeFault::UnknownSetting { pair: pair.into(), key: key.into(), near: did_you_mean(key, &names) }
            })?;
            let value = match &field.default {
                Value::String(_) => Value::from(value),
                _ => serde_json::from_str(value).unwrap_or_else(|_| Value::from(value)),
            };
            if let Some(fault) = field.fault(&value) {
                return Err(ChangeFault::Value { pair: pair.into(), fault });
            }
            changes.push((field.clone(), value));
        }
    }
    Ok(changes)
}

/// Drives the recorded scenario with `changes` into the new folder `out`, for as long as it was driven; then drives the
/// recording again. Calls `driven` with the number of new ticks of either drive. Returns `None` if it was stopped.
///
/// # Errors
/// The recording cannot be driven again, the changed scenario cannot be driven, or an I/O error.
pub fn what_if(
    recording: &Path,
    changes: &[(Field, Value)],
    out: &Path,
    stop: &AtomicBool,
    driven: &impl Fn(u64),
) -> Result<Option<WhatIfComparison>, RunError> {
    let driver = Manifest::load(recording)?.driver;
    let scenario = recorded_scenario(recording)?;
    let length_s = Tick(record::count(recording, Table::Ego)?).seconds();
    // The length is that of the recording, which may have been stopped early: both means cover the same time.
    let changed = Scenario { duration_s: length_s, ..scenario.with(changes)? };
    // SUMO runs once per process, so one world ends before the next begins. The changed one is first: if it cannot be driven,
    // the error comes at once.
    let mut run = OfflineDrive::new(&changed, [0.0, f64::INFINITY])?;
    run.record(out)?;
    run.note(
        "what if",
        &format!("{} of {}", changes_text(changes), recording.file_name().unwrap_or_default().display()),
    );
    while run.world().ended().is_none() && !stop.load(Ordering::Relaxed) {
        let before = run.world().snapshot().tick.0;
        run.step()?;
        driven(run.world().snapshot().tick.0 - before);
    }
    run.finish_recording()?;
    let instead = run.summary();
    let other = (format!("simulated: {}", changed.driver), run.world().policy().name.clone());
    drop(run);
    let (mut replay, mut summary) = (Replay::of(recording, &scenario)?, SummaryAccumulator::new([0.0, f64::INFINITY]));
    while !replay.over() && !stop.load(Ordering::Relaxed) {
        replay.advance(1)?;
        summary.add(replay.world().snapshot(), replay.world().events());
        driven(1);
    }
    let is_proven = replay.report().is_proven();
    let policies = [replay.world().policy().name.clone(), other.1].map(|name| inputs::last(&name).to_owned());
    let pair =
        WhatIfComparison { drivers: [driver, other.0], policies, is_proven, recorded: summary.to_summary(), instead };
    Ok((!stop.load(Ordering::Relaxed)).then_some(pair))
}

/// Returns the changes as text, such as `policy=none, driver=idm`.
pub fn changes_text(changes: &[(Field, Value)]) -> String {
    let word = |(field, value): &(Field, Value)| match value {
        Value::String(text) => format!("{}={}", field.path, inputs::last(text)),
        other => format!("{}={other}", field.path),
    };
    changes.iter().map(word).collect::<Vec<_>>().join(", ")
}

impl WhatIfComparison {
    /// Returns a table of key figures: recorded, instead, and the difference (recorded minus instead).
    pub fn table(&self) -> String {
        /// Name, unit and value of a figure.
        type Row = (&'static str, &'static str, fn(&Summary) -> Option<f64>);
        let rows: [Row; 5] = [
            ("mean speed, all vehicles", "m/s", |s| s.mean_speed_mps),
            ("SD of all speeds", "m/s", |s| s.speed_sd_over_vehicles_and_time_mps),
            ("mean speed, ego", "m/s", |s| s.ego_mean_speed_mps),
            ("time in range", "%", |s| s.time_in_range.map(|share| 100.0 * share)),
            ("smallest gap", "m", |s| s.min_gap_m),
        ];
        let (less, mut text) = ("recorded less instead", String::new());
        for (i, which) in ["recorded", "instead"].into_iter().enumerate() {
            text += &format!("{which:<24} driver {}, policy {}\n", self.drivers[i], self.policies[i]);
        }
        text += &format!("{:<24} {:>10} {:>10} {less:>23}\n", "", "recorded", "instead");
        for (name, unit, of) in rows {
            let (a, b) = (of(&self.recorded), of(&self.instead));
            let cell = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.3}"));
            let difference = a.zip(b).map_or("-".into(), |(a, b)| format!("{:+.3}", a - b));
            text += &format!("{name:<24} {:>10} {:>10} {difference:>23} {unit}\n", cell(a), cell(b));
        }
        let contacts = [&self.recorded, &self.instead].map(|summary| summary.contact_count);
        text + &format!("{:<24} {:>10} {:>10}\n", "contacts", contacts[0], contacts[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_names_both_drivers_and_the_sign_of_the_difference() {
        let of = |mean_mps: f64| {
            let mut summary = SummaryAccumulator::new([0.0, 1.0]).to_summary();
            summary.mean_speed_mps = Some(mean_mps);
            summary
        };
        let pair = WhatIfComparison {
            drivers: ["Logitech G29".into(), "simulated: idm".into()],
            policies: ["pi".into(), "none".into()],
            is_proven: true,
            recorded: of(4.0),
            instead: of(3.0),
        };
        let table = pair.table();
        let lines: Vec<Vec<&str>> = table.lines().map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(lines[0].join(" "), "recorded driver Logitech G29, policy pi");
        assert_eq!(lines[1].join(" "), "instead driver simulated: idm, policy none");
        assert_eq!(lines[2], ["recorded", "instead", "recorded", "less", "instead"]);
        assert_eq!(lines[3], ["mean", "speed,", "all", "vehicles", "4.000", "3.000", "+1.000", "m/s"]);
    }

    #[test]
    fn changes_are_settings_with_allowed_values() {
        let read = |text: &str| changes(&[text.to_owned()]).map_err(|fault| fault.to_string());
        assert_eq!(changes_text(&read("none").unwrap()), "policy=none, driver=idm");
        assert_eq!(changes_text(&read("hold=5").unwrap()), "hold_s=5");
        assert_eq!(changes_text(&read("idm.T=1.5").unwrap()), "idm.T=1.5");
        assert!(read("perfect").unwrap_err().contains("SETTING=VALUE"));
        assert!(read("polcy=none").unwrap_err().contains("no setting polcy"));
        let why = read("vehicles=many").unwrap_err();
        assert!(why.contains("vehicles") && why.contains("allowed"), "{why}");
    }
}
