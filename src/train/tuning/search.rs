//! Search for the best point of a box. A share of the points is spread over the whole box. CMA-ES starts from the best of them (Hansen
//! and Ostermeier 2001) and restarts with twice the population whenever it has converged (Auger and Hansen 2005), until the budget is
//! used. In: a box, an initial point and a function. Out: the best point. Points of a generation are evaluated in parallel; the
//! assignment to threads changes no bit.

use crate::rng;
use fcmaes_core::{Cmaes, CmaesParams, Fitness};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Smallest population: with few parameters the usual four would leave threads idle.
const LEAST_POPULATION: usize = 6;
/// Initial standard deviation, as a share of the box.
const FIRST_SD: f64 = 0.2;
/// One in this many points is spread over the box. The objective has many local maxima, and CMA-ES stays at a low one if it starts there
/// (linear feedback held 10 s reached 3.2 m/s, while constant gains of 0 reach 3.6).
const SPREAD: u32 = 5;
/// Scale of the optimiser's tolerances of 1e-11 of the first step and 1e-12 of the value. A difference in speed below a millionth is not
/// worth the points, which are better tried elsewhere.
const TOLERANCE_SCALE: f64 = 1e6;

/// Penalty per squared distance of a point beyond the box, in sides of the box: more than any possible gain in m/s.
const PENALTY: f64 = 10.0;

/// Space, start and budget of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchBox {
    /// Lowest and highest value of each coordinate, in ascending order.
    pub bounds: Vec<[f64; 2]>,
    /// Start of the search unless a better point is found; a coordinate out of bounds is moved to the nearer bound.
    pub start: Vec<f64>,
    /// Value of the function at the start.
    pub start_value: f64,
    /// Largest number of points to try.
    pub budget: u32,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchResult {
    /// Best point within the bounds and its value; `None` if no point was tried or no value was finite.
    pub best: Option<(Vec<f64>, f64)>,
    /// Number of points tried.
    pub tried: u32,
}

/// Returns the point with the greatest `value` found. `stop` ends the search with the best point so far.
pub fn maximum(space: &SearchBox, stop: &AtomicBool, value: impl Fn(&[f64]) -> f64 + Sync) -> SearchResult {
    let mut search = Search { space, stop, value: &value, result: SearchResult { best: None, tried: 0 } };
    let dimensions = space.bounds.len();
    let usual = 4.0 + 3.0 * (dimensions as f64).ln();
    let mut population = (usual as usize).max(LEAST_POPULATION);
    let spread = spread((space.budget / SPREAD) as usize, dimensions, space.seed);
    let costs = search.try_points(&spread);
    let lowest = spread.into_iter().zip(costs).min_by(|a, b| a.1.total_cmp(&b.1));
    let better = lowest.filter(|(_, cost)| -cost > space.start_value);
    let mut from = better.map_or_else(|| space.normalised(), |(point, _)| point);
    let mut run = 0;
    while search.goes_on() {
        let mut numbers = rng::stream(space.seed, &format!("tune/search/{run}"));
        search.run(&from, population, (numbers.uniform(0.0, 1.0) * 9.0e15) as u64);
        run += 1;
        population *= 2;
        from = space.bounds.iter().map(|_| numbers.uniform(0.0, 1.0)).collect();
    }
    search.result
}

/// Returns points of the unit cube, each in a separate slice along every side (a Latin hypercube).
fn spread(points: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut numbers = rng::stream(seed, "tune/spread");
    let mut side = |_| -> Vec<f64> {
        let slices = numbers.permutation(points);
        slices.into_iter().map(|slice| (slice as f64 + numbers.uniform(0.0, 1.0)) / points as f64).collect()
    };
    let sides: Vec<Vec<f64>> = (0..dimensions).map(&mut side).collect();
    (0..points).map(|i| sides.iter().map(|side| side[i]).collect()).collect()
}

/// A search in progress.
struct Search<'a, F> {
    space: &'a SearchBox,
    stop: &'a AtomicBool,
    value: &'a F,
    result: SearchResult,
}

impl<F: Fn(&[f64]) -> f64 + Sync> Search<'_, F> {
    fn goes_on(&self) -> bool {
        self.result.tried < self.space.budget && !self.stop.load(Ordering::Relaxed)
    }

    /// Runs CMA-ES until it has converged or the budget is used.
    fn run(&mut self, from: &[f64], population: usize, seed: u64) {
        let unbounded = Fitness::new(from.len(), 1, Vec::new(), Vec::new());
        let parameters = CmaesParams {
            popsize: population as i32,
            max_evaluations: u64::from(self.space.budget),
            accuracy: TOLERANCE_SCALE,
            seed,
            ..CmaesParams::default()
        };
        let mut optimiser = Cmaes::new(unbounded, from, &[FIRST_SD], &parameters);
        while self.goes_on() {
            let costs = self.try_points(&optimiser.ask());
            // The optimiser takes whole generations only; the last one may be incomplete.
            if costs.len() < population || optimiser.tell(&costs) != 0 {
                return;
            }
        }
    }

    /// Evaluates points in coordinates where the box is 0 to 1, as far as the budget permits. Returns the values to minimise, one per
    /// point evaluated.
    fn try_points(&mut self, asked: &[Vec<f64>]) -> Vec<f64> {
        let left = (self.space.budget - self.result.tried) as usize;
        let points: Vec<(Vec<f64>, f64)> = asked.iter().take(left).map(|point| self.space.point(point)).collect();
        let tried = |(point, _): &(Vec<f64>, f64)| (!self.stop.load(Ordering::Relaxed)).then(|| (self.value)(point));
        let values: Vec<Option<f64>> = points.par_iter().map(tried).collect();
        let mut costs: Vec<f64> = Vec::with_capacity(asked.len());
        for ((point, penalty), value) in points.into_iter().zip(values) {
            let Some(value) = value else { continue };
            self.result.tried += 1;
            costs.push(if value.is_finite() { penalty - value } else { f64::INFINITY });
            if value.is_finite() && self.result.best.as_ref().is_none_or(|(_, best)| value > *best) {
                self.result.best = Some((point, value));
            }
        }
        costs
    }
}

impl SearchBox {
    /// Returns the start in coordinates of 0 to 1.
    fn normalised(&self) -> Vec<f64> {
        let share = |(x, [low, high]): (&f64, &[f64; 2])| ((x - low) / (high - low)).clamp(0.0, 1.0);
        self.start.iter().zip(&self.bounds).map(share).collect()
    }

    /// Returns the point of the box nearest to normalised coordinates (the box is 0 to 1), and the penalty for the distance beyond it.
    /// Clamping alone gives points that differ from the optimiser's, which then fails along a side; reflection at the bounds makes it
    /// oscillate between a maximum and its mirror image.
    fn point(&self, normalised: &[f64]) -> (Vec<f64>, f64) {
        let of = |(x, [low, high]): (&f64, &[f64; 2])| (low + (high - low) * x).clamp(*low, *high);
        let beyond: f64 = normalised.iter().map(|x| (x - x.clamp(0.0, 1.0)).powi(2)).sum();
        (normalised.iter().zip(&self.bounds).map(of).collect(), PENALTY * beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU32;

    /// Searches the maximum 0 of a sum of squares around a centre, on a box with three different sides; returns the result and the number
    /// of calls.
    fn sphere(centre: [f64; 3], seed: u64, budget: u32) -> (SearchResult, u32) {
        let space = SearchBox {
            bounds: vec![[0.0, 10.0], [-1.0, 1.0], [100.0, 300.0]],
            start: vec![1.0, 0.9, 999.0],
            start_value: f64::NEG_INFINITY,
            budget,
            seed,
        };
        let calls = AtomicU32::new(0);
        let value = |x: &[f64]| {
            calls.fetch_add(1, Ordering::Relaxed);
            assert!(x.iter().zip(&space.bounds).all(|(x, [low, high])| (low..=high).contains(&x)), "{x:?}");
            let part = |i: usize| ((x[i] - centre[i]) / (space.bounds[i][1] - space.bounds[i][0])).powi(2);
            -(part(0) + part(1) + part(2))
        };
        let result = maximum(&space, &AtomicBool::new(false), value);
        (result, calls.into_inner())
    }

    #[test]
    fn the_top_of_a_shifted_sphere_is_found_within_the_bounds() {
        for seed in 1..6 {
            let (best, value) = sphere([7.0, -0.25, 130.0], seed, 400).0.best.expect("a best point");
            assert!((best[0] - 7.0).abs() < 0.01 && (best[1] + 0.25).abs() < 0.002 && (best[2] - 130.0).abs() < 0.2);
            assert!((-1e-6..=0.0).contains(&value), "{value}");
            // The centre lies beyond two sides, by a fifth and a quarter of them; the best point is the nearest one of the box.
            let (best, value) = sphere([12.0, -0.25, 50.0], seed, 400).0.best.expect("a best point");
            assert!(best[0] > 9.99 && (best[1] + 0.25).abs() < 0.002 && best[2] < 100.2, "{best:?}");
            assert!((-1e-6..=0.0).contains(&(value + 0.04 + 0.0625)), "{value}");
        }
    }

    #[test]
    fn the_first_points_fill_all_slices_of_each_side() {
        let points = spread(10, 3, 7);
        for side in 0..3 {
            let mut slices: Vec<usize> = points.iter().map(|point| (point[side] * 10.0) as usize).collect();
            slices.sort_unstable();
            assert_eq!(slices, (0..10).collect::<Vec<_>>());
        }
        assert!(spread(0, 3, 7).is_empty() && points != spread(10, 3, 8));
    }

    #[test]
    fn a_curved_valley_is_followed() {
        // Rosenbrock's function: 0 only at (1, 1).
        let space = SearchBox {
            bounds: vec![[-2.0, 2.0]; 2],
            start: vec![-1.2, 1.0],
            start_value: -24.2,
            budget: 1500,
            seed: 1,
        };
        let valley = |x: &[f64]| -(100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2));
        let (best, value) = maximum(&space, &AtomicBool::new(false), valley).best.expect("a best point");
        assert!(value > -1e-4 && (best[0] - 1.0).abs() < 0.02, "{best:?} {value}");
    }

    #[test]
    fn a_search_restarts_after_a_local_maximum_and_finds_the_global_one() {
        // A maximum of 1 at the start (whose value is given as 3) and a maximum of 2 at the other end.
        let space =
            SearchBox { bounds: vec![[0.0, 1.0]; 2], start: vec![0.1, 0.1], start_value: 3.0, budget: 2000, seed: 1 };
        let value = |x: &[f64]| {
            let hill = |top: f64, at: f64| top * (-((x[0] - at).powi(2) + (x[1] - at).powi(2)) / 0.02).exp();
            hill(1.0, 0.1).max(hill(2.0, 0.85))
        };
        let (best, height) = maximum(&space, &AtomicBool::new(false), value).best.expect("a best point");
        assert!((height - 2.0).abs() < 1e-3, "{best:?} {height}");
    }

    #[test]
    fn the_budget_is_used_and_never_exceeded() {
        for budget in [0, 1, 7, 100] {
            let (result, calls) = sphere([7.0, -0.25, 130.0], 3, budget);
            assert_eq!((result.tried, calls), (budget, budget));
            assert_eq!(result.best.is_some(), budget > 0);
        }
    }

    #[test]
    fn a_stopped_search_returns_the_best_so_far_and_never_a_nan() {
        let space = SearchBox { bounds: vec![[0.0, 1.0]], start: vec![0.5], start_value: 0.5, budget: 1000, seed: 1 };
        let (stop, calls) = (AtomicBool::new(false), AtomicU32::new(0));
        let value = |x: &[f64]| {
            let call = calls.fetch_add(1, Ordering::Relaxed);
            stop.fetch_or(call >= 20, Ordering::Relaxed);
            if x[0] > 0.5 { f64::NAN } else { x[0] }
        };
        let result = maximum(&space, &stop, value);
        assert!((21..40).contains(&result.tried), "{result:?}");
        assert!(result.best.expect("a best point").1 <= 0.5);
    }
}
