//! `codrive evaluate --benchmark NAME`: evaluates policies on sealed rings. In: a [`Benchmark`]. Out: a table, CSV, figures,
//! and JSON with versions, seeds and a fingerprint. The rings come from a random stream that no training and no tuning uses.

mod definition;
mod figure;
pub(super) mod report;

use super::CliError;
use crate::{
    cli::{out, stop_on_ctrl_c},
    metrics::{Estimate, EvaluationResult, correlation, evaluated},
    policy::{DriverTraits, PolicySource},
    private,
    train::{IdentifiedDriver, TrainConfig, drawn_ring, evaluate, identified},
};
use definition::{Benchmark, EvaluationCondition, JudgedPolicy, Road};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::{path::Path, sync::atomic::Ordering};

/// Random stream of the rings, reserved for benchmarks.
pub const SEALED_STREAM: &str = "benchmark";

/// Results of one policy with one driver on one road at one hold.
pub struct Cell<'a> {
    /// Road, hold and driver.
    pub condition: EvaluationCondition<'a>,
    /// Index of the row in the benchmark.
    pub row: usize,
    /// Results of each ring, for each of the row's policies (one for each training seed).
    pub results: Vec<Vec<EvaluationResult>>,
    /// True and estimated driver traits, for policies that estimate them.
    pub identified: Vec<IdentifiedDriver>,
}

/// Time after which the policy's trait estimate is read, s. The policies promise estimates within a minute.
const IDENTIFIED_AFTER_S: f64 = 60.0;

impl Cell<'_> {
    /// Returns the mean of a measure over rings and training seeds; `None` if no ring has the measure.
    pub fn mean(&self, name: &str) -> Option<f64> {
        let numbers: Vec<f64> = self.results.iter().flatten().filter_map(evaluated(name)).collect();
        (!numbers.is_empty()).then(|| numbers.iter().sum::<f64>() / numbers.len() as f64)
    }

    /// Returns the mean value of the drives, m/s: their mean speed minus `speed_sd_penalty` times the standard deviation over the
    /// vehicles.
    fn value_mps(&self, speed_sd_penalty: f64) -> Option<f64> {
        Some(self.mean("mean_speed_mps")? - speed_sd_penalty * self.mean("speed_sd_over_vehicles_mps")?)
    }

    /// Returns the mean speed with its interval over rings and training seeds, m/s.
    pub fn speed(&self) -> Estimate {
        let speeds: Vec<Vec<f64>> =
            self.results.iter().map(|rings| rings.iter().map(|r| r.mean_speed_mps).collect()).collect();
        Estimate::of_seeds(&speeds).unwrap_or(Estimate { mean: 0.0, low: 0.0, high: 0.0 })
    }

    /// Returns the gain over another cell, paired by ring, m/s. The other cell must have one policy.
    pub fn gain_over(&self, other: &Self) -> Option<Estimate> {
        let base = other.results.first()?;
        let gains: Vec<Vec<f64>> = self
            .results
            .iter()
            .map(|rings| rings.iter().zip(base).map(|(ring, base)| ring.mean_speed_mps - base.mean_speed_mps).collect())
            .collect();
        Estimate::of_seeds(&gains)
    }

    /// Returns the mean speed of the worst training seed, m/s; `None` with one seed.
    pub fn worst_mps(&self) -> Option<f64> {
        let means =
            self.results.iter().map(|rings| rings.iter().map(|r| r.mean_speed_mps).sum::<f64>() / rings.len() as f64);
        (self.results.len() > 1).then(|| means.fold(f64::INFINITY, f64::min))
    }

    /// Returns the correlation of each trait's estimate after a minute with the truth; traits that do not vary are left out.
    pub fn trait_correlations(&self) -> Vec<(&'static str, f64)> {
        let of = |(k, name): (usize, &'static str)| {
            let pair = |driver: &IdentifiedDriver| (driver.truth.numbers()[k], driver.estimate.mean.numbers()[k]);
            let pairs: Vec<(f64, f64)> = self.identified.iter().map(pair).collect();
            Some((name, correlation(&pairs)?))
        };
        DriverTraits::NAMES.into_iter().enumerate().filter_map(of).collect()
    }

    /// Returns, for the traits of [`Self::trait_correlations`], the share of drivers whose true value lies in the estimate's 95
    /// % interval.
    pub fn trait_coverages(&self) -> Vec<(&'static str, f64)> {
        let holds = |driver: &IdentifiedDriver, k: usize| {
            let off = driver.truth.numbers()[k] - driver.estimate.mean.numbers()[k];
            off.abs() <= NORMAL_95 * driver.estimate.sd.numbers()[k]
        };
        let count = self.identified.len() as f64;
        let share = |k: usize| self.identified.iter().filter(|driver| holds(driver, k)).count() as f64 / count;
        let named = |name: &str| DriverTraits::NAMES.into_iter().position(|other| other == name);
        let of = |(name, _): (&'static str, f64)| Some((name, share(named(name)?)));
        self.trait_correlations().into_iter().filter_map(of).collect()
    }

    /// Returns the number of drives in which vehicles collided, and of all drives.
    pub fn crashes(&self) -> [usize; 2] {
        let all = self.results.iter().flatten();
        [all.clone().filter(|r| r.crashed).count(), all.count()]
    }
}

/// Standard deviations on either side of the mean that hold 95 % of a normal distribution.
const NORMAL_95: f64 = 1.96;

/// Stability and equilibrium of a road's rings.
pub struct RoadState {
    /// Number of rings on which small disturbances grow into a wave.
    pub unstable: usize,
    /// Number of all rings.
    pub rings: usize,
    /// Mean equilibrium speed of the rings, m/s.
    pub equilibrium_mps: f64,
}

/// Results of a benchmark.
pub struct BenchmarkResult<'a> {
    /// Definition of the benchmark.
    pub benchmark: &'a Benchmark,
    /// Cells, ordered by road, hold, driver and row.
    pub cells: Vec<Cell<'a>>,
    /// State of each road, in the order of the roads.
    pub roads: Vec<RoadState>,
    /// Wall time of the evaluation, s.
    pub wall_s: f64,
}

impl BenchmarkResult<'_> {
    /// Returns the cell without advice in the same condition.
    pub fn without_advice(&self, cell: &Cell<'_>) -> Option<&Cell<'_>> {
        let row = self.benchmark.rows.iter().position(JudgedPolicy::is_no_advice)?;
        self.cells.iter().find(|other| other.row == row && other.condition.is(&cell.condition))
    }

    /// Returns the cell of the limit in the same condition.
    fn limit_of(&self, cell: &Cell<'_>) -> Option<&Cell<'_>> {
        let row = self.benchmark.rows.iter().position(|row| row.is_limit)?;
        self.cells.iter().find(|other| other.row == row && other.condition.is(&cell.condition))
    }

    /// Returns the mean value of a cell's drives, m/s.
    pub fn value_mps(&self, cell: &Cell<'_>) -> Option<f64> {
        cell.value_mps(self.benchmark.speed_sd_penalty)
    }

    /// Returns the gain of a cell's value over no advice as a share of the gain of the limit; `None` without a limit that gains.
    pub fn share_of_limit(&self, cell: &Cell<'_>) -> Option<f64> {
        let none = self.value_mps(self.without_advice(cell)?)?;
        let most = self.value_mps(self.limit_of(cell)?)? - none;
        (most > 0.0).then_some((self.value_mps(cell)? - none) / most)
    }

    /// Compares a row of several training seeds with the fastest advising row of one policy in the same condition. Returns that
    /// row's cell and the gain over it, paired by ring, m/s. The fastest row is chosen on the evaluated rings, which favours
    /// it.
    pub fn over_fastest_single(&self, cell: &Cell<'_>) -> Option<(&Cell<'_>, Estimate)> {
        if cell.results.len() < 2 {
            return None;
        }
        let beside = self.cells.iter().filter(|other| other.results.len() == 1 && other.condition.is(&cell.condition));
        let advising = beside.filter(|other| !self.benchmark.rows[other.row].is_no_advice());
        let fastest = advising.max_by(|a, b| a.speed().mean.total_cmp(&b.speed().mean))?;
        Some((fastest, cell.gain_over(fastest)?))
    }
}

/// Runs a benchmark and writes the results.
///
/// # Errors
/// The benchmark is wrong, a policy cannot be used, or a file cannot be written.
pub fn main(name: &str, rings: Option<u32>, dir: Option<&Path>, as_json: bool) -> Result<(), CliError> {
    let mut benchmark = Benchmark::load(name)?;
    if let Some(rings) = rings {
        benchmark.rings = rings as usize;
    }
    if let Some(dir) = dir {
        super::report::claim(dir)?;
    }
    let result = judge(&benchmark)?;
    let json = report::json(&result)?;
    if let Some(dir) = dir {
        let put = |file: &str, text: &str| {
            let path = dir.join(file);
            private::replace(&path, text.as_bytes()).map_err(|e| CliError::Failed(format!("{}: {e}", path.display())))
        };
        put("benchmark.json", &format!("{json:#}\n"))?;
        put("summary.csv", &report::csv(&result))?;
        put("table.txt", &report::table(&result))?;
        for (name, svg) in figure::figures(&result) {
            super::report::put_figure(dir, &name, &svg)?;
        }
    }
    if as_json {
        out::line(format_args!("{json:#}"))?;
    } else {
        out::text(report::table(&result))?;
    }
    if let Some(dir) = dir {
        out::line(format_args!("{}: benchmark.json, summary.csv, table.txt and figures", dir.display()))?;
    }
    Ok(())
}

/// Drives all cells in parallel. Ctrl-C ends it and discards what was driven.
fn judge(benchmark: &Benchmark) -> Result<BenchmarkResult<'_>, CliError> {
    let conditions = benchmark.conditions();
    let mut cells: Vec<Cell<'_>> = Vec::new();
    for condition in &conditions {
        for (row, judged) in benchmark.rows.iter().enumerate().filter(|(_, row)| benchmark.judges(row, condition)) {
            let results = vec![Vec::new(); judged.policies.len()];
            cells.push(Cell { condition: *condition, row, results, identified: Vec::new() });
        }
    }
    let mut todo = Vec::new();
    for (cell, of) in cells.iter().enumerate() {
        // Without advice the hold has no effect: it is driven once.
        let is_first = |before: &Cell<'_>| before.row == of.row && before.condition.is_beside(&of.condition);
        if !benchmark.rows[of.row].is_no_advice() || !cells[..cell].iter().any(is_first) {
            todo.extend((0..of.results.len()).map(|policy| (cell, policy)));
        }
    }
    let stop = stop_on_ctrl_c();
    let style = ProgressStyle::with_template("{bar:24} {pos}/{len} {elapsed}  {eta} left");
    let bar = ProgressBar::new(todo.len() as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let drive = |&(cell, policy): &(usize, usize)| {
        if stop.load(Ordering::Relaxed) {
            return Err(CliError::Failed("stopped; nothing was written".into()));
        }
        let Cell { condition, row, .. } = &cells[cell];
        let config = benchmark.config(condition)?;
        let settings = config.policy_settings(0.0);
        let name = benchmark.policy(&benchmark.rows[*row].policies[policy], condition);
        let source = PolicySource::for_rings(&name, &settings).map_err(|e| CliError::Input(e.to_string()))?;
        let make = || source.engage();
        let results = evaluate(&config, SEALED_STREAM, benchmark.rings, make);
        let asks = make().is_some_and(|policy| policy.who_drives().is_some());
        let drivers = match asks {
            true => identified(&config, SEALED_STREAM, benchmark.rings, IDENTIFIED_AFTER_S, make),
            false => Vec::new(),
        };
        bar.inc(1);
        Ok((results, drivers))
    };
    let results: Vec<(Vec<EvaluationResult>, Vec<IdentifiedDriver>)> =
        todo.par_iter().map(drive).collect::<Result<_, _>>()?;
    bar.finish_and_clear();
    for ((cell, policy), (results, identified)) in todo.into_iter().zip(results) {
        cells[cell].results[policy] = results;
        cells[cell].identified.extend(identified);
    }
    for cell in 0..cells.len() {
        if cells[cell].results[0].is_empty() {
            let same = |of: &&Cell<'_>| of.row == cells[cell].row && of.condition.is_beside(&cells[cell].condition);
            cells[cell].results = cells.iter().find(same).map(|of| of.results.clone()).unwrap_or_default();
        }
    }
    let roads = benchmark.roads.iter().map(|road| road_state(benchmark, road)).collect::<Result<_, _>>()?;
    Ok(BenchmarkResult { benchmark, cells, roads, wall_s: bar.elapsed().as_secs_f64() })
}

/// Counts the string-unstable rings of a road, and averages the equilibrium speed.
fn road_state(benchmark: &Benchmark, road: &Road) -> Result<RoadState, CliError> {
    let condition = EvaluationCondition { road, hold_s: benchmark.holds_s[0], driver: &benchmark.drivers[0] };
    let config: TrainConfig = benchmark.config(&condition)?;
    let mut state = RoadState { unstable: 0, rings: benchmark.rings, equilibrium_mps: 0.0 };
    for ring in 0..benchmark.rings {
        let (model, gap_m) = drawn_ring(&config, SEALED_STREAM, ring);
        state.unstable += usize::from(model.string_stability(gap_m) < 0.0);
        state.equilibrium_mps += model.equilibrium_speed_mps(gap_m, f64::INFINITY) / benchmark.rings as f64;
    }
    Ok(state)
}
