//! Output of a benchmark. In: a [`BenchmarkResult`]. Out: a table as text, CSV, and JSON that names everything the results
//! depend on.

use super::{BenchmarkResult, Cell, CellMeasure, CliError, SEALED_STREAM};
use crate::{policy, rng::fnv_1a};
use serde_json::{Value, json};
use std::{collections::BTreeMap, fmt::Write};

/// Share of the advised time above which a mean speed is attributed to the guard or to car-following, not to the advice.
const MADE_BY_ANOTHER: f64 = 0.5;

/// Measures beside the mean speed, and their names in the files.
const MEASURES: [(&str, CellMeasure); 15] = [
    ("settled_speed_mps", |r| Some(r.settled_mps)),
    ("sd_over_cars_mps", |r| Some(r.sd_over_cars_mps)),
    ("sd_in_time_mps", |r| Some(r.sd_in_time_mps)),
    ("fuel_l_100km", |r| r.fuel_l_100km),
    ("throughput_per_h", |r| Some(r.throughput_per_h)),
    ("stops_per_km", |r| Some(r.conflicts?.stops_per_km)),
    ("hard_brakings_per_km", |r| Some(r.conflicts?.hard_brakings_per_km)),
    ("least_gap_m", |r| Some(r.least_gap_m)),
    ("least_ttc_s", |r| r.conflicts?.least_ttc_s),
    ("most_drac_mps2", |r| Some(r.conflicts?.most_drac_mps2)),
    ("near_misses", |r| Some(f64::from(r.conflicts?.near_misses))),
    ("in_range", |r| r.in_range),
    ("advice_share", |r| r.conflicts?.advice_share),
    ("distance_share", |r| r.conflicts?.distance_share),
    ("guard_share", |r| r.conflicts?.guard_share),
];

/// Header above the lines of a driver.
const HEAD: &str = "    policy                             mean m/s        gain m/s         worst  SD time  stops  hard  TTC s  in range  \
                    drove    crashes\n";

/// Returns the table as text: mean speeds of all vehicles, and each policy's gain over the same drivers without advice.
pub fn table(result: &BenchmarkResult<'_>) -> String {
    let benchmark = result.benchmark;
    let mut text = format!(
        "{}: {} rings a cell, seed {}, paired on rings; 95 % intervals over rings and training seeds\n",
        benchmark.title, benchmark.rings, benchmark.seed
    );
    for (road, state) in benchmark.roads.iter().zip(&result.roads) {
        let _ = writeln!(
            text,
            "\n{}: an even flow would have {:.2} m/s; a wave grows on {} of {} rings",
            road.name, state.equilibrium_mps, state.unstable, state.rings
        );
        if state.unstable < state.rings {
            let calm = state.rings - state.unstable;
            let _ = writeln!(text, "!!! {calm} rings are string stable: there is no wave to calm on them");
        }
        for condition in benchmark.conditions().iter().filter(|condition| std::ptr::eq(condition.road, road)) {
            let driver = condition.driver;
            let _ = writeln!(text, "\n  hold {} s, driver {} ({})", condition.hold_s, driver.name, driver.driver);
            text.push_str(HEAD);
            for cell in result.cells.iter().filter(|cell| cell.condition.is(condition)) {
                let _ = writeln!(text, "{}", line(result, cell));
                if let Some((fastest, gain)) = result.over_fastest_single(cell) {
                    let (name, half) = (&benchmark.rows[fastest.row].name, (gain.high - gain.low) / 2.0);
                    let _ =
                        writeln!(text, "      {:+.3} ± {half:.3} over the fastest single policy, {name}", gain.mean);
                }
                if let Some(words) = trait_recovery_line(cell) {
                    let _ = writeln!(text, "      {words}");
                }
            }
        }
    }
    text.push_str(
        "\nmean m/s: of all cars. gain: over the same drivers on the same rings without advice. worst: of the training seeds. SD time: of a \
         car's speed,\nm/s. stops, hard: stops of any car and brakings beyond 3 m/s2, each vehicle kilometre. TTC: least time to collision \
         of the ego with its\nleader and its follower with it. drove: per cent of the time with advice in which the advice, the distance to \
         the leader, the guard did.\nG, D: the guard or the distance drove for more than half of the time; such a mean speed is not the \
         advice's.\n",
    );
    let _ = writeln!(text, "{:.0} s", result.wall_s);
    text
}

/// Returns a line on how well a row's policies estimate the driver's traits, if they do.
fn trait_recovery_line(cell: &Cell<'_>) -> Option<String> {
    let both = cell.trait_correlations().into_iter().zip(cell.trait_coverages());
    let words = |((name, correlation), (_, covered)): ((&str, f64), (&str, f64))| {
        format!("{name} {correlation:.2} ({:.0} %)", covered * 100.0)
    };
    let traits: Vec<String> = both.map(words).collect();
    (!traits.is_empty()).then(|| {
        format!("drivers after a minute, correlation with the truth (truths in 95 % intervals): {}", traits.join(", "))
    })
}

fn line(result: &BenchmarkResult<'_>, cell: &Cell<'_>) -> String {
    let speed = cell.speed();
    let is_none = result.benchmark.rows[cell.row].is_no_advice();
    let gain = result.without_advice(cell).filter(|_| !is_none).and_then(|none| cell.gain_over(none));
    let gain = gain.map_or("-".into(), |g| format!("{:+.3} ± {:.3}", g.mean, (g.high - g.low) / 2.0));
    let number = |of: CellMeasure, digits: usize| cell.mean(of).map_or("-".into(), |x| format!("{x:.digits$}"));
    let percent = |of: CellMeasure| cell.mean(of).map(|x| x * 100.0);
    let shares = [
        percent(|r| r.conflicts?.advice_share),
        percent(|r| r.conflicts?.distance_share),
        percent(|r| r.conflicts?.guard_share),
    ];
    let words: Vec<String> = shares.iter().map(|share| share.map_or("-".into(), |x| format!("{x:.0}"))).collect();
    let made_by = match shares {
        [_, _, Some(guard)] if guard > 100.0 * MADE_BY_ANOTHER => " G",
        [_, Some(distance), _] if distance > 100.0 * MADE_BY_ANOTHER => " D",
        _ => "",
    };
    let least_ttc_s = cell.results.iter().flatten().filter_map(|r| r.conflicts?.least_ttc_s).reduce(f64::min);
    let [crashed, driven] = cell.crashes();
    let mean = format!("{:.3} ± {:.3}", speed.mean, (speed.high - speed.low) / 2.0);
    let cells = [
        format!("{:<34} {mean:<15} {gain:<16}", format!("{}{made_by}", result.benchmark.rows[cell.row].name)),
        format!("{:>5}", cell.worst_mps().map_or("-".into(), |x| format!("{x:.2}"))),
        format!("{:>7}", number(|r| Some(r.sd_in_time_mps), 2)),
        format!("{:>5}", number(|r| Some(r.conflicts?.stops_per_km), 1)),
        format!("{:>4}", number(|r| Some(r.conflicts?.hard_brakings_per_km), 2)),
        format!("{:>5}", least_ttc_s.map_or("-".into(), |s| format!("{s:.2}"))),
        format!("{:>8}", percent(|r| r.in_range).map_or("-".into(), |x| format!("{x:.0} %"))),
        format!("{:>7}", words.join("/")),
        format!("{crashed}/{driven}"),
    ];
    format!("    {}", cells.join("  "))
}

/// Returns the results as CSV, one line for each cell.
pub fn csv(result: &BenchmarkResult<'_>) -> String {
    let names: Vec<&str> = MEASURES.iter().map(|measure| measure.0).collect();
    let mut text = format!(
        "road,hold_s,driver,policy,rings,training_seeds,mean_speed_mps,mean_speed_mps_low,mean_speed_mps_high,gain_mps,gain_mps_low,\
         gain_mps_high,worst_seed_mps,crashes,{}\n",
        names.join(",")
    );
    for cell in &result.cells {
        let speed = cell.speed();
        let gain = result.without_advice(cell).and_then(|none| cell.gain_over(none));
        let gain = gain.map_or(",,".into(), |g| format!("{},{},{}", g.mean, g.low, g.high));
        let values: Vec<String> =
            MEASURES.iter().map(|(_, of)| cell.mean(*of).map_or(String::new(), |x| x.to_string())).collect();
        let _ = writeln!(
            text,
            "\"{}\",{},{},\"{}\",{},{},{},{},{},{gain},{},{},{}",
            cell.condition.road.name,
            cell.condition.hold_s,
            cell.condition.driver.name,
            result.benchmark.rows[cell.row].name,
            result.benchmark.rings,
            cell.results.len(),
            speed.mean,
            speed.low,
            speed.high,
            cell.worst_mps().map_or(String::new(), |x| x.to_string()),
            cell.crashes()[0],
            values.join(",")
        );
    }
    text
}

/// Returns everything as JSON, with a fingerprint of the ring results in place of the rings.
///
/// # Errors
/// A policy's file cannot be read again.
pub fn json(result: &BenchmarkResult<'_>) -> Result<Value, CliError> {
    let benchmark = result.benchmark;
    let mut fingerprint = 0;
    for cell in &result.cells {
        for ring in cell.results.iter().flatten() {
            fingerprint = fnv_1a(fingerprint, &ring.mean_mps.to_bits().to_le_bytes());
        }
    }
    let cell = |cell: &Cell<'_>| {
        let measures: serde_json::Map<String, Value> =
            MEASURES.iter().map(|(name, of)| ((*name).to_owned(), json!(cell.mean(*of)))).collect();
        json!({
            "road": cell.condition.road.name, "hold_s": cell.condition.hold_s, "driver": cell.condition.driver.name,
            "policy": benchmark.rows[cell.row].name,
            "mean_speed_mps": cell.speed(),
            "gain_mps": result.without_advice(cell).and_then(|none| cell.gain_over(none)),
            "worst_seed_mps": cell.worst_mps(),
            "over_fastest_single": result.over_fastest_single(cell).map(|(fastest, gain)| {
                json!({ "policy": benchmark.rows[fastest.row].name, "gain_mps": gain })
            }),
            "crashes": cell.crashes()[0], "drives": cell.crashes()[1],
            "trait_correlation": cell.trait_correlations().into_iter().collect::<BTreeMap<_, _>>(),
            "trait_coverage_95": cell.trait_coverages().into_iter().collect::<BTreeMap<_, _>>(),
            "measures": measures,
        })
    };
    let mut policies = serde_json::Map::new();
    for cell in &result.cells {
        for name in &benchmark.rows[cell.row].policies {
            let Some(file) = policy::file_of(&benchmark.policy(name, &cell.condition)) else { continue };
            let bytes = std::fs::read(&file).map_err(|e| CliError::Failed(format!("{}: {e}", file.display())))?;
            policies.insert(cell.condition.written_in(name), json!(format!("{:016x}", fnv_1a(0, &bytes))));
        }
    }
    Ok(json!({
        "program": concat!("codrive ", env!("CARGO_PKG_VERSION")),
        "benchmark": benchmark.title,
        "traffic": "ring",
        "random_numbers": SEALED_STREAM,
        "seed": benchmark.seed,
        "rings": benchmark.rings,
        "policies": policies,
        "roads": benchmark.roads.iter().zip(&result.roads).map(|(road, state)| json!({
            "name": road.name, "circumference_m": road.circumference_m, "vehicles": road.vehicles, "idm_spread": road.idm_spread, "car_spread": road.car_spread,
            "truck_share": road.truck_share, "desired_speed_mps": road.desired_speed_mps, "warm_up_s": road.warm_up_s,
            "equilibrium_mps": state.equilibrium_mps, "rings_with_a_wave": state.unstable,
        })).collect::<Vec<_>>(),
        "cells": result.cells.iter().map(cell).collect::<Vec<_>>(),
        "wall_s": result.wall_s,
        "fingerprint": format!("{fingerprint:016x}"),
    }))
}
