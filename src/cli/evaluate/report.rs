//! Output of an evaluation. In: rows of results. Out: a table as text, CSV by ring and by case (mean and 95 % bootstrap
//! interval of each measure), JSON, and figures. Windows and seeds are in the files.

use super::{
    CliError,
    plan::{Engine, EvaluationCase, EvaluationPlan, FollowingDriver},
};
use crate::{
    analysis::{quoted_cell, text_cell},
    driver::NamedDriver,
    metrics::{EVALUATED, Estimate, EvaluatedValue, EvaluationResult, Measure, SpeedTrace, evaluated, figures},
    private,
    scenario::AdvisedVehicles,
    train::{TrainConfig, evaluate, trajectories},
};
use serde_json::{Value, json};
use std::{fmt::Write, path::Path};

/// Case with its results.
pub struct EvaluationRow {
    /// Case that was driven.
    pub case: EvaluationCase,
    /// Results, one for each ring.
    pub results: Vec<EvaluationResult>,
}

impl EvaluationRow {
    /// Returns the number of rings on which vehicles collided.
    fn crashes(&self) -> usize {
        self.results.iter().filter(|v| v.crashed).count()
    }

    /// Returns the mean speed as a point at this abscissa of a figure.
    fn point(&self, at: f64) -> Option<figures::Point> {
        let mean = estimate(self, evaluated("mean_speed_mps"))?;
        Some(figures::Point { at, mean, crashes: [self.crashes(), self.results.len()] })
    }
}

fn estimate(row: &EvaluationRow, of: EvaluatedValue) -> Option<Estimate> {
    Estimate::of(&row.results.iter().filter_map(of).collect::<Vec<_>>())
}

/// Returns the table as text, for people.
pub fn table(plan: &EvaluationPlan, rows: &[EvaluationRow]) -> String {
    let mut text = String::new();
    for resolved in plan.resolved.iter().filter(|resolved| resolved.why.is_some()) {
        let _ = writeln!(text, "policy {}", resolved);
    }
    let mut before = None;
    for row in rows {
        let head = (row.case.label(), row.case.driver.label());
        if before.as_ref() != Some(&head) {
            let _ = writeln!(text, "{}, driver {}", head.0, head.1);
            let advised = plan.advised.as_ref().map_or("", |_| " advised");
            let _ = writeln!(
                text,
                "{advised}  hold s   mean m/s [95 % interval]   settled  SD veh.  SD time  calm for good  least gap  \
                 crashes  fuel   in range"
            );
            before = Some(head);
        }
        if plan.advised.is_some() {
            let _ = write!(text, " {:>7}", advised_text(plan, row));
        }
        let _ = writeln!(text, "{}{}", row_text(row), network_text(row));
        if let Some(warning) = crash_text(row) {
            let _ = writeln!(text, "  !!! {warning}");
        }
    }
    let driven: usize = rows.iter().map(|row| row.results.len()).sum();
    let crashed: usize = rows.iter().map(EvaluationRow::crashes).sum();
    if crashed > 0 {
        let _ = writeln!(
            text,
            "\n!!! {crashed} of {driven} drives ended in a crash: their speeds do not measure the advice."
        );
    }
    text
}

/// Returns the advised vehicles as text: a number of all vehicles, or a share.
fn advised_text(plan: &EvaluationPlan, row: &EvaluationRow) -> String {
    let vehicles = plan.most_advised();
    match row.case.advised {
        AdvisedVehicles::Count(_) => format!("{}/{vehicles}", row.case.advised.of(vehicles)),
        AdvisedVehicles::Share(_) => format!("{:.1} %", 100.0 * plan.advised_share(&row.case)),
    }
}

/// Returns the number of vehicles that were advised in a drive.
fn advised_in(plan: &EvaluationPlan, row: &EvaluationRow, result: &EvaluationResult) -> u32 {
    result.network.map_or_else(|| plan.advised_by(&row.case), |network| network.advised_vehicles)
}

/// Returns a line on vehicles that entered and left a network; empty on a ring.
fn network_text(row: &EvaluationRow) -> String {
    let value = |of: EvaluatedValue| estimate(row, of).map(|e| e.mean);
    let network = |v: &EvaluationResult| v.network;
    let Some(first) = row.results.iter().find_map(network) else { return String::new() };
    let refused = value(|v| v.network?.vehicles_refused).map_or(String::new(), |n| format!(", {n:.0} found no room"));
    format!(
        "\n          space-mean speed {:.3} m/s; in {:.0}, out {:.0} vehicles/h; {:.1} there{refused}; {} of {} advised in the first drive",
        value(|v| Some(v.network?.space_mean_speed_mps)).unwrap_or(0.0),
        value(|v| Some(v.network?.inflow_per_h)).unwrap_or(0.0),
        value(|v| Some(v.network?.outflow_per_h)).unwrap_or(0.0),
        value(|v| Some(v.network?.vehicles_present)).unwrap_or(0.0),
        first.advised_vehicles,
        first.vehicles
    )
}

/// Returns a warning for a row in which vehicles collided.
fn crash_text(row: &EvaluationRow) -> Option<String> {
    let first_s = row.results.iter().filter_map(|v| v.crash_s).reduce(f64::min)?;
    Some(format!(
        "CRASHED in {} of {} drives, first {first_s:.1} s after the first advice; all vehicles stand from then on and \
         count as 0 m/s",
        row.crashes(),
        row.results.len()
    ))
}

fn row_text(row: &EvaluationRow) -> String {
    let n = row.results.len();
    let value = |of: EvaluatedValue| estimate(row, of).map(|e| e.mean);
    let speed = estimate(row, evaluated("mean_speed_mps")).unwrap_or(Estimate { mean: 0.0, low: 0.0, high: 0.0 });
    let calm = row.results.iter().filter(|v| v.last_disturbance_s.is_some()).count();
    let after = value(|v| v.last_disturbance_s).map_or(String::new(), |s| format!(" {s:.0} s"));
    let least = row.results.iter().map(|v| v.min_gap_to_neighbours_m).fold(f64::INFINITY, f64::min);
    let crashes = row.crashes();
    format!(
        "  {:>6}   {:.3} [{:.3}, {:.3}]        {:>7.3}  {:>7.2}  {:>7.2}  {:<13}  {least:>6.2} m   {crashes:>5}    {:>5}  {:>6}",
        row.case.hold_s,
        speed.mean,
        speed.low,
        speed.high,
        value(|v| Some(v.settled_speed_mps)).unwrap_or(0.0),
        value(|v| Some(v.speed_sd_over_vehicles_mps)).unwrap_or(0.0),
        value(|v| Some(v.speed_sd_over_time_mps)).unwrap_or(0.0),
        format!("{calm}/{n}{after}"),
        value(|v| v.fuel_l_100km).map_or("-".into(), |f| format!("{f:.1}")),
        value(|v| v.time_in_range).map_or("-".into(), |s| format!("{:.0} %", s * 100.0)),
    )
}

/// Returns the results as JSON.
pub fn json(plan: &EvaluationPlan, config: &TrainConfig, rows: &[EvaluationRow]) -> Value {
    let row = |row: &EvaluationRow| {
        json!({
            "advised_vehicles": row.results.iter().map(|result| advised_in(plan, row, result)).max(), "advised_share": plan.advised_share(&row.case),
            "ignores_advice": row.case.ignores_advice, "policy": if row.case.ignores_advice { row.case.label() } else { row.case.policy.clone() }, "hold_s": row.case.hold_s, "driver": row.case.driver.label(), "crashes": row.crashes(),
            "mean_speed_mps": estimate(row, evaluated("mean_speed_mps")), "rings": row.results,
        })
    };
    json!({
        "program": concat!("codrive ", env!("CARGO_PKG_VERSION")),
        "traffic": plan.engine.to_string(),
        "resolved": plan.resolved.iter().filter_map(|r| Some(json!({ "name": r.name, "why": r.why.as_ref()? }))).collect::<Vec<_>>(),
        "policy_speed_mps": plan.settings.aim_or_automatic_mps(),
        "config": config,
        "rows": rows.iter().map(row).collect::<Vec<_>>(),
    })
}

/// Makes the folder, and checks that it holds no evaluation yet.
///
/// # Errors
/// The folder holds an evaluation, or it cannot be made.
pub fn claim(dir: &Path) -> Result<(), CliError> {
    private::folder(dir).map_err(|e| CliError::Failed(format!("{}: {e}", dir.display())))?;
    match ["rings.csv", "summary.csv"].iter().find(|name| dir.join(name).exists()) {
        Some(name) => {
            let text =
                format!("{} already holds an evaluation ({name}); name another folder with --out", dir.display());
            Err(CliError::Input(text))
        }
        None => Ok(()),
    }
}

/// Writes tables, configuration and figures into the folder.
///
/// # Errors
/// A file cannot be written.
pub fn write(dir: &Path, plan: &EvaluationPlan, config: &TrainConfig, rows: &[EvaluationRow]) -> Result<(), CliError> {
    let put = |name: &str, text: &str| {
        let path = dir.join(name);
        private::replace(&path, text.as_bytes()).map_err(|e| CliError::Failed(format!("{}: {e}", path.display())))
    };
    put("rings.csv", &rings_csv(plan, config, rows))?;
    put("summary.csv", &summary_csv(plan, config, rows))?;
    put("config.toml", &toml::to_string(config).unwrap_or_default())?;
    for (name, svg) in pictures(plan, config, rows) {
        put_figure(dir, &name, &svg)?;
    }
    Ok(())
}

/// Writes a figure into the folder as SVG, and as PNG if this build can draw it.
///
/// # Errors
/// A file cannot be written.
pub fn put_figure(dir: &Path, name: &str, svg: &str) -> Result<(), CliError> {
    let failed = |path: &Path, why: String| CliError::Failed(format!("{}: {why}", path.display()));
    let path = dir.join(name);
    private::replace(&path, svg.as_bytes()).map_err(|e| failed(&path, e.to_string()))?;
    let path = path.with_extension("png");
    if let Some(png) = crate::cli::desktop::png(svg) {
        let png = png.map_err(|e| failed(&path, e.to_string()))?;
        private::replace(&path, &png).map_err(|e| failed(&path, e.to_string()))?;
    }
    Ok(())
}

/// Returns the first cells of a case's lines: policy, hold, driver and traffic.
fn key(case: &EvaluationCase, engine: &Engine) -> String {
    format!("{},{},{},{engine}", text_cell(&case.label()), case.hold_s, quoted_cell(&case.driver.label()))
}

/// Returns the head of `rings.csv`.
pub fn rings_head() -> String {
    let names: Vec<&str> = EVALUATED.iter().map(|(measure, _)| measure.name).collect();
    format!(
        "policy,hold_s,driver,traffic,seed,ring,window_from_s,window_to_s,{},advised_vehicles,advised_share\n",
        names.join(",")
    )
}

/// Returns the head of `summary.csv`: each measure with its interval.
pub fn summary_head() -> String {
    let with_interval =
        |(Measure { name, .. }, _): &(Measure, EvaluatedValue)| format!("{name},{name}_low,{name}_high");
    let names: Vec<String> = EVALUATED.iter().map(with_interval).collect();
    format!(
        "policy,hold_s,driver,traffic,seed,rings,calm_rings,window_from_s,window_to_s,{},advised_vehicles,advised_share\n",
        names.join(",")
    )
}

fn rings_csv(plan: &EvaluationPlan, config: &TrainConfig, rows: &[EvaluationRow]) -> String {
    let mut text = rings_head();
    for row in rows {
        for (ring, result) in row.results.iter().enumerate() {
            let values: Vec<String> =
                EVALUATED.iter().map(|(_, of)| of(result).map_or(String::new(), |x| x.to_string())).collect();
            let _ = writeln!(
                text,
                "{},{},{ring},0,{},{},{},{}",
                key(&row.case, &plan.engine),
                config.seed,
                config.ring.horizon_s,
                values.join(","),
                advised_in(plan, row, result),
                plan.advised_share(&row.case)
            );
        }
    }
    text
}

fn summary_csv(plan: &EvaluationPlan, config: &TrainConfig, rows: &[EvaluationRow]) -> String {
    let mut text = summary_head();
    for row in rows {
        let values: Vec<String> = EVALUATED
            .iter()
            .map(|(_, of)| estimate(row, *of).map_or(",,".into(), |e| format!("{},{},{}", e.mean, e.low, e.high)))
            .collect();
        let calm = row.results.iter().filter(|v| v.last_disturbance_s.is_some()).count();
        let sum: u32 = row.results.iter().map(|result| advised_in(plan, row, result)).sum();
        let advised = f64::from(sum) / row.results.len().max(1) as f64;
        let _ = writeln!(
            text,
            "{},{},{},{calm},0,{},{},{},{}",
            key(&row.case, &plan.engine),
            config.seed,
            row.results.len(),
            config.ring.horizon_s,
            values.join(","),
            advised,
            plan.advised_share(&row.case)
        );
    }
    text
}

fn pictures(plan: &EvaluationPlan, config: &TrainConfig, rows: &[EvaluationRow]) -> Vec<(String, String)> {
    let mut out = Vec::new();
    let note = note(plan, config);
    let crashes =
        |row: &EvaluationRow| crash_text(row).map_or(String::new(), |words| format!("\n{}: {words}", row.case));
    let with_crashes = rows.iter().map(crashes).fold(note.clone(), |note, crash| note + &crash);
    if plan.holds_s.len() > 1 && plan.advised.is_none() {
        let equilibrium_mps = plan.settings.equilibrium_mps;
        let is_paper_ring = config.ring.circumference_min_m == 250.0
            && config.ring.circumference_max_m == 250.0
            && (config.ring.vehicles_min, config.ring.vehicles_max) == (22, 22);
        let text = figures::against_hold(&by_hold(plan, rows), equilibrium_mps, is_paper_ring, &with_crashes);
        out.push(("speed-against-hold.svg".into(), text));
    }
    if plan.advised.is_some() {
        let note = with_crashes
            + "\n\
                0 %: traffic alone. In the other rows simulated drivers drive the advised vehicles; each vehicle has \
                its own advice, or its driver ignores it"
            + &outflows(plan, rows);
        let even_mps = Some(plan.settings.equilibrium_mps).filter(|even_mps| *even_mps > 0.0);
        let text = figures::against_share(&by_share(plan, rows), even_mps, &note);
        out.push(("speed-against-share.svg".into(), text));
    }
    if plan.engine != Engine::FastRing {
        return out;
    }
    // Figures show the middle hold only; `--holds` with one hold shows another.
    let hold_s = plan.holds_s[plan.holds_s.len() / 2];
    for case in plan.cases().iter().filter(|case| case.policy != "none" && case.hold_s == hold_s) {
        let of_case = case.config(config);
        let before_s = 100.0_f64.min(config.ring.warm_up_s);
        let after_s = 500.0_f64.min(config.ring.horizon_s);
        let trace_of = |name: &str| trajectories(&of_case, "evaluate", [before_s, after_s], || plan.engage(name));
        let (without, with) = (trace_of("none"), trace_of(&case.policy));
        let title = case.to_string();
        let crash = rows.iter().find(|row| row.case == *case).map(crashes).unwrap_or_default();
        let note = format!("{note}; this is ring 0{crash}");
        let file = slug(&title);
        let top_mps = 2.2 * plan.settings.equilibrium_mps;
        let rings = [("No advice", &without), (title.as_str(), &with)];
        out.push((
            format!("space-time-{file}.svg"),
            figures::space_time(&rings, top_mps, figures::SINCE_ADVICE, &note),
        ));
        out.push((
            format!("speeds-{file}.svg"),
            figures::speeds(
                &title,
                &SpeedTrace::of(&with),
                config.range_mps(),
                figures::SINCE_ADVICE,
                &note,
                Vec::new(),
            ),
        ));
    }
    if plan.adherence {
        out.push(("adherence.svg".into(), adherence(plan, config)));
    }
    out
}

/// Returns a note on the drives, for the foot of a figure.
fn note(plan: &EvaluationPlan, config: &TrainConfig) -> String {
    let span = |a: f64, b: f64| if a == b { format!("{a}") } else { format!("{a} to {b}") };
    let (ring, drive) = (&config.ring, &plan.drive);
    let cars = span(f64::from(ring.vehicles_min), f64::from(ring.vehicles_max));
    let cars_and_road = match &plan.engine {
        Engine::FastRing => {
            format!("{cars} vehicles on {} m", span(ring.circumference_min_m, ring.circumference_max_m))
        }
        Engine::Traffic(engine) => format!("{} on {} on {engine}", drive.vehicles_text(), drive.scenario().map),
    };
    format!(
        "{cars_and_road}, {} rings, seed {}; {} s after {} s of warm-up, transients included; bands: 95 % by bootstrap",
        plan.rings, config.seed, ring.horizon_s, ring.warm_up_s
    )
}

fn by_hold(plan: &EvaluationPlan, rows: &[EvaluationRow]) -> Vec<figures::Series> {
    let name = |row: &EvaluationRow| {
        let is_none = row.case.policy == "none";
        match plan.drivers.len() {
            1 if is_none => "no advice".into(),
            _ if is_none => format!("no advice, {}", row.case.driver.label()),
            1 => row.case.label(),
            _ => format!("{}, {}", row.case.label(), row.case.driver.label()),
        }
    };
    series(plan, rows, name, |row| row.case.hold_s)
}

/// Returns mean speed against the share of advised vehicles, percent.
fn by_share(plan: &EvaluationPlan, rows: &[EvaluationRow]) -> Vec<figures::Series> {
    let name = |row: &EvaluationRow| {
        if row.case.ignores_advice {
            return row.case.label();
        }
        let hold = (plan.holds_s.len() > 1).then(|| format!(", hold {} s", row.case.hold_s));
        let driver = (plan.drivers.len() > 1).then(|| format!(", {}", row.case.driver.label()));
        row.case.label() + &hold.unwrap_or_default() + &driver.unwrap_or_default()
    };
    series(plan, rows, name, |row| 100.0 * plan.advised_share(&row.case))
}

/// Returns the outflow of a network for the foot of a figure; empty on a ring. A high speed of few vehicles is no gain.
fn outflows(plan: &EvaluationPlan, rows: &[EvaluationRow]) -> String {
    let of_row = |row: &EvaluationRow| {
        let out = estimate(row, |v| Some(v.network?.outflow_per_h))?;
        let (label, share) = (row.case.label(), 100.0 * plan.advised_share(&row.case));
        Some(format!("{label} {share:.0} %: {:.0}", out.mean))
    };
    let rows: Vec<String> = rows.iter().filter_map(of_row).collect();
    if rows.is_empty() { String::new() } else { format!("\nvehicles that left, 1/h: {}", rows.join(", ")) }
}

/// Returns a line for each name, with its points in the order of the rows.
fn series(
    plan: &EvaluationPlan,
    rows: &[EvaluationRow],
    name: impl Fn(&EvaluationRow) -> String,
    at: impl Fn(&EvaluationRow) -> f64,
) -> Vec<figures::Series> {
    let mut series: Vec<figures::Series> = Vec::new();
    for row in rows {
        let name = name(row);
        let Some(point) = row.point(at(row)) else { continue };
        match series.iter_mut().find(|s| s.name == name) {
            Some(s) => s.points.push(point),
            None => {
                let of_policies = plan.policies.iter().position(|p| *p == row.case.policy).unwrap_or(0);
                let policy = if row.case.ignores_advice { plan.policies.len() } else { of_policies };
                let driver = plan.drivers.iter().position(|d| *d == row.case.driver).unwrap_or(0);
                series.push(figures::Series { name, look: [policy, driver], points: vec![point] });
            }
        }
    }
    series
}

/// Draws the mean speed of each policy at each hold against reaction, error and deadband of the driver.
fn adherence(plan: &EvaluationPlan, config: &TrainConfig) -> String {
    /// Reaction, error, speed_bias and deadband of an attentive participant (`driver`'s preset `follow`).
    const BASE: [f64; 4] = [1.0, 0.3, 0.0, 0.0];
    let driver_of = |numbers| {
        FollowingDriver::Named(Box::new(NamedDriver::of_numbers(numbers).expect("within the limits of a driver")))
    };
    // Shortest, middle and longest hold.
    let n = plan.holds_s.len();
    let mut holds_s = vec![plan.holds_s[0], plan.holds_s[n / 2], plan.holds_s[n - 1]];
    holds_s.dedup();
    let sweep = |values: &[f64], of: fn(f64) -> [f64; 4]| -> Vec<figures::Series> {
        let one = EvaluationPlan { drivers: vec![driver_of(BASE)], holds_s: holds_s.clone(), ..plan.clone() };
        let cases: Vec<EvaluationCase> =
            one.cases().into_iter().filter(|case| case.policy != "none" || case.hold_s == holds_s[0]).collect();
        let line = |case: &EvaluationCase| figures::Series {
            name: format!("{}, hold {} s", case.label(), case.hold_s),
            look: [
                plan.policies.iter().position(|p| *p == case.policy).unwrap_or(0),
                holds_s.iter().position(|h| *h == case.hold_s).unwrap_or(0),
            ],
            points: values
                .iter()
                .filter_map(|x| {
                    let case = EvaluationCase { driver: driver_of(of(*x)), ..case.clone() };
                    let results = evaluate(&case.config(config), "evaluate", plan.rings, || plan.engage(&case.policy));
                    EvaluationRow { case, results }.point(*x)
                })
                .collect(),
        };
        cases.iter().map(line).collect()
    };
    let reaction = sweep(&[0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0], |x| [x, BASE[1], 0.0, 0.0]);
    let error = sweep(&[0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0], |x| [BASE[0], x, 0.0, 0.0]);
    let deadband = sweep(&[0.0, 0.2, 0.447, 0.7, 1.0, 1.5, 2.24], |x| [BASE[0], BASE[1], 0.0, x]);
    let charts = [
        ("reaction time, s (tracking error 0.3 m/s)", reaction),
        ("tracking error, m/s (reaction 1 s)", error),
        (
            "deadband: half width of the range of speeds that the driver accepts, m/s (reaction 1 s, error 0.3 m/s)",
            deadband,
        ),
    ];
    figures::adherence(&charts, &note(plan, config))
}

/// Returns a title as a file name.
fn slug(title: &str) -> String {
    let words = title.to_lowercase().replace("m/s", "mps");
    let parts: Vec<&str> = words.split(|c: char| !c.is_alphanumeric() && c != '.').filter(|p| !p.is_empty()).collect();
    parts.join("-")
}

#[cfg(test)]
#[path = "report_tests.rs"]
mod tests;
