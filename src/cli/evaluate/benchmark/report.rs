//! Output of a benchmark. In: a [`BenchmarkResult`]. Out: a table as text, CSV, and JSON that names everything the results
//! depend on.

use super::{BenchmarkResult, Cell, CliError, SEALED_STREAM};
use crate::{
    analysis::{quoted_cell, text_cell},
    metrics::evaluated,
    policy,
    rng::fnv_1a,
};
use serde_json::{Value, json};
use std::{collections::BTreeMap, fmt::Write};

/// Share of the advised time above which a mean speed is attributed to the guard or to car-following, not to the advice.
const MADE_BY_ANOTHER: f64 = 0.5;

/// Names of the measures beside the mean speed in the files.
const MEASURES: [&str; 15] = [
    "settled_speed_mps",
    "speed_sd_over_vehicles_mps",
    "speed_sd_over_time_mps",
    "fuel_l_100km",
    "flow_per_h",
    "stops_per_km",
    "hard_brakings_per_km",
    "min_gap_to_neighbours_m",
    "min_ttc_to_neighbours_s",
    "max_drac_to_neighbours_mps2",
    "close_approaches",
    "time_in_range",
    "advice_share",
    "distance_share",
    "guard_share",
];

/// Header above the lines of a driver.
const HEAD: &str = "    policy                             mean m/s        gain m/s         worst  SD veh.  SD time   fuel  flow  stops  hard  TTC s  \
                    in range    drove  of limit  crashes\n";

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
            "\n{}: even flow has {:.2} m/s; a wave grows on {} of {} rings",
            road.name, state.equilibrium_mps, state.unstable, state.rings
        );
        if state.unstable < state.rings {
            let calm = state.rings - state.unstable;
            let _ = writeln!(text, "!!! {calm} rings are string stable: no wave forms on them");
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
        "\n\
         mean m/s: mean speed of all vehicles. gain: difference from the same drivers on the same rings without \
         advice.\n\
         worst: lowest mean speed of a training seed. SD veh., SD time: standard deviation of speed over the vehicles, \
         and of a vehicle's speed over time, m/s.\n\
         fuel: of all vehicles, l/100 km. flow: vehicles per hour.\n\
         stops, hard: stops, and brakings beyond 3 m/s2, per vehicle kilometre.\n\
         TTC: least time to collision of the ego with its leader, and of its follower with the ego.\n\
         drove: share of the time with advice in which the advice / the distance to the leader / the guard set the \
         speed, per cent.\n\
         of limit: share of the gain in value that a search with full knowledge found; value: mean speed minus \
         speed_sd_penalty times SD veh.\n\
         G, D: the guard or the distance set the speed for more than half of the time; the mean speed is then not due \
         to the advice.\n",
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
    let number = |name: &str, digits: usize| cell.mean(name).map_or("-".into(), |x| format!("{x:.digits$}"));
    let percent = |name: &str| cell.mean(name).map(|x| x * 100.0);
    let shares = ["advice_share", "distance_share", "guard_share"].map(percent);
    let words: Vec<String> = shares.iter().map(|share| share.map_or("-".into(), |x| format!("{x:.0}"))).collect();
    let made_by = match shares {
        [_, _, Some(guard)] if guard > 100.0 * MADE_BY_ANOTHER => " G",
        [_, Some(distance), _] if distance > 100.0 * MADE_BY_ANOTHER => " D",
        _ => "",
    };
    let least_ttc_s = cell.results.iter().flatten().filter_map(evaluated("min_ttc_to_neighbours_s")).reduce(f64::min);
    let [crashed, driven] = cell.crashes();
    let share = result.share_of_limit(cell).filter(|_| !is_none);
    let mean = format!("{:.3} ± {:.3}", speed.mean, (speed.high - speed.low) / 2.0);
    let cells = [
        format!("{:<34} {mean:<15} {gain:<16}", format!("{}{made_by}", result.benchmark.rows[cell.row].name)),
        format!("{:>5}", cell.worst_mps().map_or("-".into(), |x| format!("{x:.2}"))),
        format!("{:>7}", number("speed_sd_over_vehicles_mps", 2)),
        format!("{:>7}", number("speed_sd_over_time_mps", 2)),
        format!("{:>5}", number("fuel_l_100km", 1)),
        format!("{:>4}", number("flow_per_h", 0)),
        format!("{:>5}", number("stops_per_km", 1)),
        format!("{:>4}", number("hard_brakings_per_km", 2)),
        format!("{:>5}", least_ttc_s.map_or("-".into(), |s| format!("{s:.2}"))),
        format!("{:>8}", percent("time_in_range").map_or("-".into(), |x| format!("{x:.0} %"))),
        format!("{:>7}", words.join("/")),
        format!("{:>8}", share.map_or("-".into(), |share| format!("{:.0} %", share * 100.0))),
        format!("{crashed}/{driven}"),
    ];
    format!("    {}", cells.join("  "))
}

/// Returns the head of the CSV.
pub fn head() -> String {
    format!(
        "road,hold_s,driver,policy,rings,training_seeds,mean_speed_mps,mean_speed_mps_low,mean_speed_mps_high,speed_gain_mps,\
         speed_gain_mps_low,speed_gain_mps_high,worst_seed_mean_speed_mps,crashes,value_mps,share_of_limit,{}\n",
        MEASURES.join(",")
    )
}

/// Returns the results as CSV, one line for each cell.
pub fn csv(result: &BenchmarkResult<'_>) -> String {
    let mut text = head();
    for cell in &result.cells {
        let speed = cell.speed();
        let gain = result.without_advice(cell).and_then(|none| cell.gain_over(none));
        let gain = gain.map_or(",,".into(), |g| format!("{},{},{}", g.mean, g.low, g.high));
        let text_of = |number: Option<f64>| number.map_or(String::new(), |x| x.to_string());
        let values: Vec<String> = MEASURES.iter().map(|name| text_of(cell.mean(name))).collect();
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{gain},{},{},{},{},{}",
            quoted_cell(&cell.condition.road.name),
            cell.condition.hold_s,
            text_cell(&cell.condition.driver.name),
            quoted_cell(&result.benchmark.rows[cell.row].name),
            result.benchmark.rings,
            cell.results.len(),
            speed.mean,
            speed.low,
            speed.high,
            text_of(cell.worst_mps()),
            cell.crashes()[0],
            text_of(result.value_mps(cell)),
            text_of(result.share_of_limit(cell)),
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
            fingerprint = fnv_1a(fingerprint, &ring.mean_speed_mps.to_bits().to_le_bytes());
        }
    }
    let cell = |cell: &Cell<'_>| {
        let measures: serde_json::Map<String, Value> =
            MEASURES.iter().map(|name| ((*name).to_owned(), json!(cell.mean(name)))).collect();
        json!({
            "road": cell.condition.road.name, "hold_s": cell.condition.hold_s, "driver": cell.condition.driver.name,
            "policy": benchmark.rows[cell.row].name,
            "mean_speed_mps": cell.speed(),
            "speed_gain_mps": result.without_advice(cell).and_then(|none| cell.gain_over(none)),
            "worst_seed_mean_speed_mps": cell.worst_mps(),
            "value_mps": result.value_mps(cell), "share_of_limit": result.share_of_limit(cell),
            "over_fastest_single": result.over_fastest_single(cell).map(|(fastest, gain)| {
                json!({ "policy": benchmark.rows[fastest.row].name, "speed_gain_mps": gain })
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
        "speed_sd_penalty": benchmark.speed_sd_penalty,
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
