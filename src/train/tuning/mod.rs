//! Tuning of a controller's parameters with the same effort as a network's training. In: a configuration's rings with their driver, holds
//! and a controller. Out: the best parameters found for its kind, and its file with a record of the tuning in the head.
//!
//! The objective is the reward's [`TrainConfig::value_mps`] of the whole horizon with its transients, averaged over the holds: the mean
//! speed of all vehicles, minus the penalty for differences of speed; after a crash all vehicles count as stopped. The rings are drawn from a separate stream, [`STREAM`]: a controller is never evaluated on rings that it
//! was tuned on.

mod search;

pub use search::{SearchBox, SearchResult, maximum};

use super::{TrainConfig, evaluate};
use crate::{
    policy::{Controller, ControllerFile, PolicySettings},
    traffic::RING_STUDY,
};
use std::{
    fmt::Write,
    sync::atomic::{AtomicBool, Ordering},
};

/// Name of the random stream of the rings.
pub const STREAM: &str = "tune";

/// Controller, rings and budget of a tuning.
#[derive(Clone, Debug, PartialEq)]
pub struct TuningTask {
    /// Configuration of the rings and of the driver who follows the advice.
    pub config: TrainConfig,
    /// Name of the driver for the file.
    pub driver: String,
    /// Holds, s; the objective is the mean over them.
    pub holds_s: Vec<f64>,
    /// Number of rings per evaluation.
    pub rings: usize,
    /// Largest number of parameter sets to try, the initial one included.
    pub budget: u32,
    /// Controller with the initial parameters.
    pub start: Controller,
    /// Name of the initial controller for the file.
    pub start_name: String,
}

/// Result of a tuning.
#[derive(Clone, Debug, PartialEq)]
pub struct TuningResult {
    /// Best controller that was found.
    pub best: Controller,
    /// Value with the best controller, m/s.
    pub after_mps: f64,
    /// Value with the initial controller, m/s; `None` if the tuning was stopped before it was known.
    pub before_mps: Option<f64>,
    /// Number of parameter sets tried.
    pub tried: u32,
}

impl TuningTask {
    /// Returns the mean value of the drives with a controller, m/s.
    pub fn value_mps(&self, controller: &Controller) -> f64 {
        let of_hold = |hold_s: &f64| {
            let config = self.config.held(*hold_s);
            let step_s = config.ring.step_s;
            let results = evaluate(&config, STREAM, self.rings, || Some(controller.policy(step_s)));
            results.iter().map(|result| config.value_mps(result)).sum::<f64>() / results.len() as f64
        };
        self.holds_s.iter().map(of_hold).sum::<f64>() / self.holds_s.len() as f64
    }

    /// Runs the search. `stop` ends it with the best result so far; `watch` gets each value, on any thread.
    pub fn run(&self, stop: &AtomicBool, watch: impl Fn(f64) + Sync) -> TuningResult {
        let (kind, settings) = (self.start.kind(), self.config.policy_settings(0.0));
        let tried = |controller: &Controller| {
            let value_mps = self.value_mps(controller);
            watch(value_mps);
            value_mps
        };
        if stop.load(Ordering::Relaxed) || self.budget == 0 {
            return TuningResult { best: self.start, after_mps: f64::NAN, before_mps: None, tried: 0 };
        }
        let before_mps = tried(&self.start);
        let space = SearchBox {
            bounds: search_bounds(&self.start, &settings),
            start: self.start.numbers(),
            start_value: before_mps,
            budget: self.budget - 1,
            seed: self.config.seed,
        };
        let found = maximum(&space, stop, |numbers| tried(&Controller::of_ordered(kind, numbers)));
        let better = found.best.filter(|(_, value_mps)| *value_mps > before_mps);
        let (best, after_mps) = match better {
            Some((numbers, value_mps)) => (Controller::of_ordered(kind, &numbers), value_mps),
            None => (self.start, before_mps),
        };
        TuningResult { best, after_mps, before_mps: Some(before_mps), tried: found.tried + 1 }
    }

    /// Returns the best controller's file; its head records the task and the result.
    pub fn file(&self, result: &TuningResult) -> String {
        let ring = &self.config.ring;
        let range = |low: f64, high: f64| if low < high { format!("{low} to {high}") } else { low.to_string() };
        let cars = range(f64::from(ring.vehicles_min), f64::from(ring.vehicles_max));
        let length_m = range(ring.circumference_min_m, ring.circumference_max_m);
        let drivers = &ring.traffic_drivers;
        let among = if drivers == RING_STUDY { String::new() } else { format!(" among {drivers}") };
        let holds: Vec<String> = self.holds_s.iter().map(|hold_s| format!("{hold_s} s")).collect();
        let mut head = String::from("Tuned by `codrive tune`; `codrive drive --policy THIS_FILE` uses it.\n");
        let penalty = self.config.reward.speed_sd_penalty;
        let minus = format!(", minus {penalty} times the standard deviation of speed over them");
        let minus = if penalty > 0.0 { minus } else { String::new() };
        let _ = writeln!(
            head,
            "Objective: mean speed of all vehicles over {} s from the first advice{minus}; after a crash all vehicles \
             stand still.",
            ring.horizon_s
        );
        let _ = writeln!(head, "Driver: {}. Holds: {}.", self.driver, holds.join(", "));
        let _ = writeln!(
            head,
            "Rings: {} of the stream \"{STREAM}\", seed {}: {cars} vehicles on {length_m} m{among}, {} s of warm-up.",
            self.rings, self.config.seed, ring.warm_up_s
        );
        let _ = writeln!(head, "Parameter sets tried: {} of {}.", result.tried, self.budget);
        let before = result.before_mps.map_or("not known".into(), |v| format!("{v:.3} m/s"));
        let _ = writeln!(
            head,
            "{} on these rings: {before} before ({}), {:.3} m/s after. Other rings give lower speeds: see \
             codrive evaluate.",
            if penalty > 0.0 { "Objective" } else { "Mean speed" },
            self.start_name,
            result.after_mps
        );
        ControllerFile { controller: result.best, advised_share: ring.advised_share() }.to_toml(&head)
    }
}

/// Returns the search range of each parameter on these rings.
fn search_bounds(controller: &Controller, settings: &PolicySettings) -> Vec<[f64; 2]> {
    controller.kind().parameters().iter().map(|p| p.search_range(settings.equilibrium_mps)).collect()
}

#[cfg(test)]
mod tests;
