//! `codrive evaluate --benchmark NAME`: policies judged on sealed rings, by one command. In: a [`Benchmark`]. Out: a table, CSV,
//! figures, and JSON with versions, seeds and a fingerprint. The rings come from random numbers that no training and no tuning uses.

mod definition;
mod figure;
mod report;

use super::CliError;
use crate::{
    cli::{out, stop_on_ctrl_c},
    metrics::{Estimate, EvaluationResult, correlation},
    policy::{DriverTraits, PolicySource},
    private,
    train::{IdentifiedDriver, TrainConfig, drawn_ring, evaluate, identified},
};
use definition::{Benchmark, JudgedPolicy, Place, Road};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::{path::Path, sync::atomic::Ordering};

/// The random numbers of the rings: nothing else may use them.
pub const SEALED_STREAM: &str = "benchmark";

/// One policy with one driver on one road at one hold.
pub struct Cell<'a> {
    /// Where: road, hold and driver.
    pub place: Place<'a>,
    /// Which row.
    pub row: usize,
    /// For each of the row's policies, one a training seed, the rings in order.
    pub results: Vec<Vec<EvaluationResult>>,
    /// Drivers as they are and as the row's policies make them out, where these ask.
    pub identified: Vec<IdentifiedDriver>,
}

/// Time after which a policy is asked who drives, s: the promise is a trait told within a minute.
const IDENTIFIED_AFTER_S: f64 = 60.0;

/// A number of a ring; `None` where it has none.
pub type CellMeasure = fn(&EvaluationResult) -> Option<f64>;

impl Cell<'_> {
    /// Mean of a measure over rings and training seeds, where there is one.
    pub fn mean(&self, of: CellMeasure) -> Option<f64> {
        let numbers: Vec<f64> = self.results.iter().flatten().filter_map(of).collect();
        (!numbers.is_empty()).then(|| numbers.iter().sum::<f64>() / numbers.len() as f64)
    }

    /// Mean speed with its interval over rings and training seeds, m/s.
    pub fn speed(&self) -> Estimate {
        let speeds: Vec<Vec<f64>> =
            self.results.iter().map(|rings| rings.iter().map(|r| r.mean_mps).collect()).collect();
        Estimate::of_seeds(&speeds).unwrap_or(Estimate { mean: 0.0, low: 0.0, high: 0.0 })
    }

    /// What it gains over another on the same rings, ring by ring, m/s. The other has one policy.
    pub fn gain_over(&self, other: &Self) -> Option<Estimate> {
        let base = other.results.first()?;
        let gains: Vec<Vec<f64>> = self
            .results
            .iter()
            .map(|rings| rings.iter().zip(base).map(|(ring, base)| ring.mean_mps - base.mean_mps).collect())
            .collect();
        Estimate::of_seeds(&gains)
    }

    /// Mean speed of the worst training seed, m/s, where there are several.
    pub fn worst_mps(&self) -> Option<f64> {
        let means = self.results.iter().map(|rings| rings.iter().map(|r| r.mean_mps).sum::<f64>() / rings.len() as f64);
        (self.results.len() > 1).then(|| means.fold(f64::INFINITY, f64::min))
    }

    /// Of each trait the correlation of what is made out after a minute with the truth, where drivers differ in it.
    pub fn trait_correlations(&self) -> Vec<(&'static str, f64)> {
        let of = |(k, name): (usize, &'static str)| {
            let pair = |driver: &IdentifiedDriver| (driver.truth.numbers()[k], driver.estimate.mean.numbers()[k]);
            let pairs: Vec<(f64, f64)> = self.identified.iter().map(pair).collect();
            Some((name, correlation(&pairs)?))
        };
        DriverTraits::NAMES.into_iter().enumerate().filter_map(of).collect()
    }

    /// Of the same traits the share of drivers whose truth lies in the interval that is said to hold it with 95 %.
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

    /// Drives in which cars collided, and all.
    pub fn crashes(&self) -> [usize; 2] {
        let all = self.results.iter().flatten();
        [all.clone().filter(|r| r.crashed).count(), all.count()]
    }
}

/// Standard deviations on either side of the mean that hold 95 % of a normal distribution.
const NORMAL_95: f64 = 1.96;

/// What a road is like.
pub struct RoadState {
    /// Rings on which small disturbances grow into a wave.
    pub unstable: usize,
    /// All rings.
    pub rings: usize,
    /// Mean over the rings of the speed at which they would flow evenly, m/s.
    pub equilibrium_mps: f64,
}

/// Everything that was judged.
pub struct BenchmarkResult<'a> {
    /// What was asked for.
    pub benchmark: &'a Benchmark,
    /// Road by road, hold by hold, driver by driver, row by row.
    pub cells: Vec<Cell<'a>>,
    /// In the order of the roads.
    pub roads: Vec<RoadState>,
    /// How long it took, s.
    pub wall_s: f64,
}

impl BenchmarkResult<'_> {
    /// The cell without advice that belongs to another.
    pub fn without_advice(&self, cell: &Cell<'_>) -> Option<&Cell<'_>> {
        let row = self.benchmark.rows.iter().position(JudgedPolicy::is_no_advice)?;
        self.cells.iter().find(|other| other.row == row && other.place.is(&cell.place))
    }

    /// The fastest cell of those of one policy at the place of one of several training seeds, no advice aside; and what the latter
    /// gains over it, ring by ring, m/s. It is chosen on the rings that are judged, to its own advantage.
    pub fn over_fastest_single(&self, cell: &Cell<'_>) -> Option<(&Cell<'_>, Estimate)> {
        if cell.results.len() < 2 {
            return None;
        }
        let beside = self.cells.iter().filter(|other| other.results.len() == 1 && other.place.is(&cell.place));
        let advising = beside.filter(|other| !self.benchmark.rows[other.row].is_no_advice());
        let fastest = advising.max_by(|a, b| a.speed().mean.total_cmp(&b.speed().mean))?;
        Some((fastest, cell.gain_over(fastest)?))
    }
}

/// Judges everything and writes what came of it.
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

/// Drives all cells, in parallel; Ctrl-C ends it with what is done thrown away.
fn judge(benchmark: &Benchmark) -> Result<BenchmarkResult<'_>, CliError> {
    let places = benchmark.places();
    let mut cells: Vec<Cell<'_>> = Vec::new();
    for place in &places {
        for (row, judged) in benchmark.rows.iter().enumerate().filter(|(_, row)| benchmark.judges(row, place)) {
            let results = vec![Vec::new(); judged.policies.len()];
            cells.push(Cell { place: *place, row, results, identified: Vec::new() });
        }
    }
    let mut todo = Vec::new();
    for (cell, of) in cells.iter().enumerate() {
        // Without advice the hold is nothing: it is driven once.
        let is_first = |before: &Cell<'_>| before.row == of.row && before.place.is_beside(&of.place);
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
        let Cell { place, row, .. } = &cells[cell];
        let config = benchmark.config(place)?;
        let settings = config.policy_settings(0.0);
        let name = benchmark.policy(&benchmark.rows[*row].policies[policy], place);
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
            let same = |of: &&Cell<'_>| of.row == cells[cell].row && of.place.is_beside(&cells[cell].place);
            cells[cell].results = cells.iter().find(same).map(|of| of.results.clone()).unwrap_or_default();
        }
    }
    let roads = benchmark.roads.iter().map(|road| road_state(benchmark, road)).collect::<Result<_, _>>()?;
    Ok(BenchmarkResult { benchmark, cells, roads, wall_s: bar.elapsed().as_secs_f64() })
}

/// Whether the rings of a road have a wave at all.
fn road_state(benchmark: &Benchmark, road: &Road) -> Result<RoadState, CliError> {
    let place = Place { road, hold_s: benchmark.holds_s[0], driver: &benchmark.drivers[0] };
    let config: TrainConfig = benchmark.config(&place)?;
    let mut state = RoadState { unstable: 0, rings: benchmark.rings, equilibrium_mps: 0.0 };
    for ring in 0..benchmark.rings {
        let (idm, gap_m) = drawn_ring(&config, SEALED_STREAM, ring);
        state.unstable += usize::from(idm.string_stability(gap_m) < 0.0);
        state.equilibrium_mps += idm.equilibrium_speed_mps(gap_m) / benchmark.rings as f64;
    }
    Ok(state)
}
