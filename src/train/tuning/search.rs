//! The search: the best point of a box. A share of the points is spread over all of it; from the best of them CMA-ES begins
//! (Hansen and Ostermeier 2001), and anew with twice the population whenever it has converged (Auger and Hansen 2005), until
//! so many points are tried. In: a box, a point to begin with, a function. Out: the best point. Points of a generation are tried in parallel; which threads do changes no bit.

use crate::rng;
use fcmaes_core::{Cmaes, CmaesParams, Fitness};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Fewest points of a generation: with few parameters the usual four would leave threads idle.
const LEAST_POPULATION: usize = 6;
/// First standard deviation, as a share of the box.
const FIRST_SD: f64 = 0.2;
/// One in so many points is spread over the box: a drive's value has many hills, and begun on a low one CMA-ES stays there
/// (linear feedback held 10 s came to 3.2 m/s where standing gains of 0 have 3.6).
const SPREAD: u32 = 5;
/// Scales the optimiser's tolerances of 1e-11 of the first step and 1e-12 of the value: closer than a millionth no speed is
/// worth knowing, and the points are better tried elsewhere.
const TOLERANCE_SCALE: f64 = 1e6;

/// Taken from the value of a point for each squared side of the box that it lies beyond it: more than any m/s that could be won.
const PENALTY: f64 = 10.0;

/// What is searched.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchBox {
    /// Lowest and highest value of each coordinate; the first below the second.
    pub bounds: Vec<[f64; 2]>,
    /// Where the search begins unless a better point is known; a coordinate out of bounds begins at the nearer one.
    pub start: Vec<f64>,
    /// The value there.
    pub start_value: f64,
    /// Most points to try.
    pub budget: u32,
    /// Seed of its random numbers.
    pub seed: u64,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchResult {
    /// The best point, within the bounds; `None` if nothing was tried or no value was a number.
    pub best: Option<(Vec<f64>, f64)>,
    /// Points tried.
    pub tried: u32,
}

/// The point where `value` is greatest. `stop` ends it with the best so far.
pub fn maximum(space: &SearchBox, stop: &AtomicBool, value: impl Fn(&[f64]) -> f64 + Sync) -> SearchResult {
    let mut search = Search { space, stop, value: &value, result: SearchResult { best: None, tried: 0 } };
    let dimensions = space.bounds.len();
    let usual = 4.0 + 3.0 * (dimensions as f64).ln();
    let mut population = (usual as usize).max(LEAST_POPULATION);
    let spread = spread((space.budget / SPREAD) as usize, dimensions, space.seed);
    let told = search.try_points(&spread);
    let lowest = spread.into_iter().zip(told).min_by(|a, b| a.1.total_cmp(&b.1));
    let better = lowest.filter(|(_, told)| -told > space.start_value);
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

/// So many points of the unit cube, each in a slice of its own along every side (a Latin hypercube).
fn spread(points: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut numbers = rng::stream(seed, "tune/spread");
    let mut side = |_| -> Vec<f64> {
        let slices = numbers.permutation(points);
        slices.into_iter().map(|slice| (slice as f64 + numbers.uniform(0.0, 1.0)) / points as f64).collect()
    };
    let sides: Vec<Vec<f64>> = (0..dimensions).map(&mut side).collect();
    (0..points).map(|i| sides.iter().map(|side| side[i]).collect()).collect()
}

/// A search under way.
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

    /// CMA-ES until it has converged, or the budget is used.
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
            let told = self.try_points(&optimiser.ask());
            // It takes whole generations only; the last one may have been cut.
            if told.len() < population || optimiser.tell(&told) != 0 {
                return;
            }
        }
    }

    /// Tries these points, in coordinates of which 0 to 1 is the box, as far as the budget goes. Returns what is to be least
    /// of each that was tried.
    fn try_points(&mut self, asked: &[Vec<f64>]) -> Vec<f64> {
        let left = (self.space.budget - self.result.tried) as usize;
        let points: Vec<(Vec<f64>, f64)> = asked.iter().take(left).map(|point| self.space.point(point)).collect();
        let tried = |(point, _): &(Vec<f64>, f64)| (!self.stop.load(Ordering::Relaxed)).then(|| (self.value)(point));
        let values: Vec<Option<f64>> = points.par_iter().map(tried).collect();
        let mut told: Vec<f64> = Vec::with_capacity(asked.len());
        for ((point, penalty), value) in points.into_iter().zip(values) {
            let Some(value) = value else { continue };
            self.result.tried += 1;
            told.push(if value.is_finite() { penalty - value } else { f64::INFINITY });
            if value.is_finite() && self.result.best.as_ref().is_none_or(|(_, best)| value > *best) {
                self.result.best = Some((point, value));
            }
        }
        told
    }
}

impl SearchBox {
    /// The start in coordinates of 0 to 1.
    fn normalised(&self) -> Vec<f64> {
        let share = |(x, [low, high]): (&f64, &[f64; 2])| ((x - low) / (high - low)).clamp(0.0, 1.0);
        self.start.iter().zip(&self.bounds).map(share).collect()
    }

    /// The point of the box that is nearest to coordinates of which 0 to 1 is the box, and what is taken from its value for
    /// being beyond it. Only cut off at the bounds, points would differ from those that the optimiser thinks of, and it
    /// loses its way along a side; folded back as by a mirror, it hesitates between a hill and its image.
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

    /// Sums of squares about a centre, the greatest value 0 there, on a box of three unlike sides.
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
            // The centre is outside of two sides, by a fifth and by a quarter of them: the nearest point of the box.
            let (best, value) = sphere([12.0, -0.25, 50.0], seed, 400).0.best.expect("a best point");
            assert!(best[0] > 9.99 && (best[1] + 0.25).abs() < 0.002 && best[2] < 100.2, "{best:?}");
            assert!((-1e-6..=0.0).contains(&(value + 0.04 + 0.0625)), "{value}");
        }
    }

    #[test]
    fn the_first_points_are_in_all_slices_of_each_side() {
        let points = spread(10, 3, 7);
        for side in 0..3 {
            let mut slices: Vec<usize> = points.iter().map(|point| (point[side] * 10.0) as usize).collect();
            slices.sort_unstable();
            assert_eq!(slices, (0..10).collect::<Vec<_>>());
        }
        assert!(spread(0, 3, 7).is_empty() && points != spread(10, 3, 8));
    }

    #[test]
    fn a_valley_that_bends_is_followed() {
        // Rosenbrock's function: 0 at (1, 1) alone.
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
    fn a_search_that_has_converged_on_a_hill_begins_anew_and_finds_the_mountain() {
        // A hill of height 1 where it begins (and is told that it is 3), a mountain of height 2 at the other end.
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
    fn a_stop_ends_it_with_the_best_so_far_and_what_is_no_number_is_never_best() {
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
