//! `codrive evaluate --benchmark NAME`: policies judged on sealed rings, by one command. In: a [`Benchmark`]. Out: a table, CSV and
//! JSON with versions, seeds and a fingerprint. The rings come from random numbers that no training and no tuning uses.

mod definition;
mod report;

use super::CliError;
use crate::{
    cli::{out, stop_on_ctrl_c},
    metrics::{Estimate, EvaluationResult},
    policy, private,
    train::{TrainConfig, drawn_ring, evaluate},
};
use definition::{Benchmark, JudgedDriver, Road};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::{path::Path, sync::atomic::Ordering};

/// The random numbers of the rings: nothing else may use them.
pub const SEALED_STREAM: &str = "benchmark";

/// One policy with one driver on one road at one hold.
pub struct Cell<'a> {
    /// Where.
    pub road: &'a Road,
    /// Who follows.
    pub driver: &'a JudgedDriver,
    /// Seconds.
    pub hold_s: f64,
    /// Which row.
    pub row: usize,
    /// For each of the row's policies, one a training seed, the rings in order.
    pub results: Vec<Vec<EvaluationResult>>,
}

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

    /// Drives in which cars collided, and all.
    pub fn crashes(&self) -> [usize; 2] {
        let all = self.results.iter().flatten();
        [all.clone().filter(|r| r.crashed).count(), all.count()]
    }
}

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
        let row = self.benchmark.rows.iter().position(|row| row.policies == ["none"])?;
        self.cells.iter().find(|other| {
            other.row == row
                && other.hold_s == cell.hold_s
                && std::ptr::eq(other.road, cell.road)
                && std::ptr::eq(other.driver, cell.driver)
        })
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
    }
    if as_json {
        out::line(format_args!("{json:#}"))?;
    } else {
        out::text(report::table(&result))?;
    }
    if let Some(dir) = dir {
        out::line(format_args!("{}: benchmark.json, summary.csv, table.txt", dir.display()))?;
    }
    Ok(())
}

/// Drives all cells, in parallel; Ctrl-C ends it with what is done thrown away.
fn judge(benchmark: &Benchmark) -> Result<BenchmarkResult<'_>, CliError> {
    let mut todo = Vec::new();
    for road in &benchmark.roads {
        for hold_s in &benchmark.holds_s {
            for driver in &benchmark.drivers {
                for (row, judged) in benchmark.rows.iter().enumerate() {
                    for policy in &judged.policies {
                        todo.push((road, *hold_s, driver, row, policy));
                    }
                }
            }
        }
    }
    let stop = stop_on_ctrl_c();
    let style = ProgressStyle::with_template("{bar:24} {pos}/{len} {elapsed}  {eta} left");
    let bar = ProgressBar::new(todo.len() as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let drive = |(road, hold_s, driver, _, policy): &(&Road, f64, &JudgedDriver, usize, &String)| {
        if stop.load(Ordering::Relaxed) {
            return Err(CliError::Failed("stopped; nothing was written".into()));
        }
        let config = benchmark.config(road, driver, *hold_s)?;
        let settings = config.policy_settings(0.0);
        let name = benchmark.policy(policy, driver, *hold_s);
        let make = || policy::build(&name, &settings).ok().flatten();
        let results = evaluate(&config, SEALED_STREAM, benchmark.rings, make);
        bar.inc(1);
        Ok(results)
    };
    let results: Vec<Vec<EvaluationResult>> = todo.par_iter().map(drive).collect::<Result<_, _>>()?;
    bar.finish_and_clear();
    let mut cells: Vec<Cell<'_>> = Vec::new();
    for ((road, hold_s, driver, row, _), results) in todo.into_iter().zip(results) {
        let same = |cell: &&mut Cell<'_>| {
            cell.row == row
                && cell.hold_s == hold_s
                && std::ptr::eq(cell.road, road)
                && std::ptr::eq(cell.driver, driver)
        };
        match cells.iter_mut().find(same) {
            Some(cell) => cell.results.push(results),
            None => cells.push(Cell { road, driver, hold_s, row, results: vec![results] }),
        }
    }
    let roads = benchmark.roads.iter().map(|road| road_state(benchmark, road)).collect::<Result<_, _>>()?;
    Ok(BenchmarkResult { benchmark, cells, roads, wall_s: bar.elapsed().as_secs_f64() })
}

/// Whether the rings of a road have a wave at all.
fn road_state(benchmark: &Benchmark, road: &Road) -> Result<RoadState, CliError> {
    let config: TrainConfig = benchmark.config(road, &benchmark.drivers[0], benchmark.holds_s[0])?;
    let mut state = RoadState { unstable: 0, rings: benchmark.rings, equilibrium_mps: 0.0 };
    for ring in 0..benchmark.rings {
        let (idm, gap_m) = drawn_ring(&config, SEALED_STREAM, ring);
        state.unstable += usize::from(idm.string_stability(gap_m) < 0.0);
        state.equilibrium_mps += idm.equilibrium_speed_mps(gap_m) / benchmark.rings as f64;
    }
    Ok(state)
}
