//! Every column that a command writes is a key or a measure of the registry, and every measure is written by a command.

use super::{benchmark, report};
use crate::{
    analysis::MEASURES,
    metrics::{registry::measures, traffic_moments::MOMENTS},
    sim::SummaryAccumulator,
    sweep::rows::{drive_columns, training_columns},
    train::learning_curve,
};
use std::collections::BTreeSet;

/// Columns and keys that are no measures: what was driven, and lists and texts of a summary.
const KEYS: [&str; 22] = [
    "contacts",
    "driver",
    "ended",
    "env_steps",
    "hash",
    "hold_s",
    "iteration",
    "map",
    "policy",
    "ring",
    "rings",
    "road",
    "run",
    "seed",
    "table",
    "traffic",
    "training_seeds",
    "varied",
    "window_from_s",
    "window_s",
    "window_to_s",
    "failure",
];

fn columns(head: &str) -> Vec<String> {
    let measure = |name: &str| name.trim_end_matches("_low").trim_end_matches("_high").to_owned();
    head.lines().next().unwrap_or_default().split(',').map(measure).collect()
}

#[test]
fn columns_of_all_commands_are_the_registry() {
    let summary = serde_json::to_value(SummaryAccumulator::new([0.0, 1.0]).to_summary()).unwrap();
    let mut written: Vec<String> = summary.as_object().unwrap().keys().cloned().collect();
    for head in [report::rings_head(), report::summary_head(), benchmark::report::head(), learning_curve::csv(&[])] {
        written.extend(columns(&head));
    }
    written.extend(drive_columns().iter().map(|column| column.name.to_owned()));
    written.extend(training_columns().iter().map(|column| column.name.to_owned()));
    written.extend(MEASURES.iter().map(|measure| measure.name.to_owned()));
    written.extend(MOMENTS.iter().map(|measure| measure.name.to_owned()));
    let written: BTreeSet<&str> = written.iter().map(String::as_str).filter(|name| !KEYS.contains(name)).collect();
    let registry: BTreeSet<&str> = measures().map(|measure| measure.name).collect();
    assert_eq!(written, registry);
}
