//! Fit of a population of drivers to measured trajectories of a ring by simulated moments. In: trajectories, a population to start from and the
//! numbers to fit. Out: the population that is nearest to the people, 95 % intervals of its numbers, and distances on held-out minutes.
//!
//! * `numbers`: what is fitted, with bounds; `ring_target`: moments and distance; `bootstrap`: intervals.
//!
//! CMA-ES (`tuning`) searches the smallest distance on rings of the same seeds, so that two points differ in their numbers only. The first
//! fit takes the first half of the minutes and is judged on the second; the final one starts from it and takes all.

mod bootstrap;
mod numbers;
mod ring_target;

pub use numbers::FittedNumber;
pub use ring_target::{FITTED_MOMENTS, RingTarget, differences, distance};

use super::tuning::{SearchBox, maximum};
use crate::{
    idm::IdmParams,
    metrics::traffic_moments::VehicleTrajectories,
    traffic::{RING_STUDY, TrafficDrivers, TrafficPopulation},
};
use numbers::population_at;
use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicBool, Ordering},
};

/// Numbers that are fitted unless others are named.
pub const USUAL_NUMBERS: [&str; 6] = ["T", "T.spread", "a", "noise_sd", "noise_sd.spread", "noise_memory"];

/// One in this many sets of numbers is tried between all bounds, the others in a narrow box around the best of them.
const WIDE_SHARE: u32 = 3;

/// Sets of numbers for each sample of persons unless others are asked for.
pub const USUAL_SAMPLE_BUDGET: u32 = 30;

/// Task of a fit: the numbers to search, and the effort.
#[derive(Clone, Debug)]
pub struct FitTask {
    /// Population that has all numbers that are not fitted, and where the search starts.
    pub start: TrafficPopulation,
    pub numbers: Vec<FittedNumber>,
    /// Simulated rings for each set of numbers.
    pub runs: usize,
    /// Largest number of sets of numbers in each of the two fits.
    pub budget: u32,
    /// Number of samples of persons for the intervals; 0: no intervals.
    pub bootstrap: u32,
    /// Largest number of sets of numbers for each sample.
    pub sample_budget: u32,
    pub seed: u64,
}

/// Distances from the second half of the minutes after a fit to the first half.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOut {
    pub model: f64,
    /// Distance of the population from which the search started.
    pub start: f64,
    /// Distance of the people in the first half.
    pub people: f64,
    pub ring_study: f64,
}

/// Result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct PopulationFit {
    pub population: TrafficPopulation,
    /// Values of the fitted numbers, in their order.
    pub values: Vec<f64>,
    /// Lower and upper end of the 95 % interval of each value; `None` without samples.
    pub intervals: Option<Vec<[f64; 2]>>,
    /// Moments of the people and of the population in all minutes.
    pub moments: [Vec<f64>; 2],
    /// Distance of the two.
    pub distance: f64,
    /// `None` if the fit was stopped before the final one.
    pub held_out: Option<HeldOut>,
    /// Number of sets of numbers tried.
    pub tried: u32,
}

/// Points tried so far, each with its moments.
type Tried = Mutex<Vec<(Vec<f64>, Vec<f64>)>>;

/// Search for the numbers with moments nearest to given ones.
struct Nearest<'a> {
    target: &'a RingTarget,
    wanted: &'a [f64],
    bounds: Vec<[f64; 2]>,
    start: Vec<f64>,
    budget: u32,
    seed: u64,
}

impl FitTask {
    /// Returns the largest number of sets of numbers that are tried.
    pub fn most_tried(&self) -> u32 {
        2 * self.budget + self.bootstrap * self.sample_budget
    }

    /// Fits the population to a ring that was measured from `from_to_s` on, s since the start of the drive. `stop` ends the fit with the best so
    /// far; `watch` gets each distance, on any thread. `None` if it was stopped before anything was tried.
    ///
    /// # Errors
    /// A moment cannot be measured in one of the halves.
    pub fn run(
        &self,
        people: &VehicleTrajectories,
        [from_s, to_s]: [f64; 2],
        stop: &AtomicBool,
        watch: &(impl Fn(f64) + Sync),
    ) -> Result<Option<PopulationFit>, String> {
        let middle_s = (from_s + to_s) / 2.0;
        let [first, second] = people.halves();
        let first = RingTarget::new(&first, [from_s, middle_s])?;
        let second = RingTarget::new(&second, [middle_s, to_s])?;
        let all = RingTarget::new(people, [from_s, to_s])?;
        let [tried_first, tried_all] = [(); 2].map(|()| Tried::default());
        let start: Vec<f64> = self.numbers.iter().map(|number| number.coordinate(number.of(&self.start))).collect();
        let Some(begun) = self.fit(&first, start, &tried_first, stop, watch) else {
            return Ok(None);
        };
        let held_out = self.held_out([&first, &second], &begun);
        let found = self.fit(&all, begun.clone(), &tried_all, stop, watch);
        let best = found.unwrap_or(begun);
        let intervals = match self.bootstrap {
            0 => None,
            _ => self.intervals(&all, &best, &tried_all, stop, watch),
        };
        let count = |tried: &Tried| tried.lock().unwrap_or_else(PoisonError::into_inner).len() as u32;
        let mut fit = self.fit_at(&all, &best)?;
        (fit.intervals, fit.held_out) = (intervals, (!stop.load(Ordering::Relaxed)).then_some(held_out).flatten());
        fit.tried = count(&tried_first) + count(&tried_all);
        Ok(Some(fit))
    }

    /// Searches the numbers nearest to a target's own moments, first between all bounds, then in a narrow box around the best.
    fn fit(
        &self,
        target: &RingTarget,
        start: Vec<f64>,
        tried: &Tried,
        stop: &AtomicBool,
        watch: &(impl Fn(f64) + Sync),
    ) -> Option<Vec<f64>> {
        let nearest = |start: Vec<f64>, bounds: Vec<[f64; 2]>, budget: u32| Nearest {
            target,
            wanted: &target.moments,
            bounds,
            start,
            budget,
            seed: self.seed,
        };
        let wide_budget = self.budget / WIDE_SHARE;
        let bounds = self.numbers.iter().map(|number| number.bounds(&self.start)).collect();
        let begun = self.search(&nearest(start, bounds, wide_budget), tried, stop, watch)?;
        let bounds = self.narrow_box(&begun);
        let found = self.search(&nearest(begun.clone(), bounds, self.budget - wide_budget), tried, stop, watch);
        Some(found.unwrap_or(begun))
    }

    /// Returns the drivers with these coordinates of the search; `None` if no persons can have them.
    fn drivers(&self, coordinates: &[f64]) -> Option<TrafficDrivers> {
        let population = population_at(&self.start, &self.numbers, coordinates).ok()?;
        Some(TrafficDrivers::People(Arc::new(population)))
    }

    /// Searches, and adds all points to those tried.
    fn search(
        &self,
        nearest: &Nearest,
        tried: &Tried,
        stop: &AtomicBool,
        watch: &(impl Fn(f64) + Sync),
    ) -> Option<Vec<f64>> {
        let value = |point: &[f64]| {
            let drivers = self.drivers(point);
            let moments = drivers.and_then(|drivers| nearest.target.simulated(&drivers, self.rings()));
            let distance = moments.as_ref().map_or(f64::NAN, |moments| distance(moments, nearest.wanted));
            watch(distance);
            if let Some(moments) = moments {
                tried.lock().unwrap_or_else(PoisonError::into_inner).push((point.to_vec(), moments));
            }
            -distance
        };
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        if nearest.budget == 0 {
            return Some(nearest.start.clone());
        }
        let start_value = value(&nearest.start);
        let space = SearchBox {
            bounds: nearest.bounds.clone(),
            start: nearest.start.clone(),
            start_value,
            budget: nearest.budget.saturating_sub(1),
            seed: nearest.seed,
        };
        let found = maximum(&space, stop, value).best.filter(|(_, value)| *value > start_value);
        Some(found.map_or_else(|| nearest.start.clone(), |(point, _)| point))
    }

    /// Returns the seeds of the simulated rings.
    fn rings(&self) -> (u64, usize) {
        (self.seed.wrapping_mul(1_000_003), self.runs)
    }

    /// Judges the fit to the first half on the second.
    fn held_out(&self, [first, second]: [&RingTarget; 2], fitted: &[f64]) -> Option<HeldOut> {
        // Rings with seeds that no search has used.
        let (first_seed, runs) = self.rings();
        let rings = (first_seed.wrapping_add(500_000), runs);
        let of = |drivers: &TrafficDrivers| Some(distance(&second.simulated(drivers, rings)?, &second.moments));
        let ring_study = TrafficDrivers::named(RING_STUDY, IdmParams::default()).ok()?;
        Some(HeldOut {
            model: of(&self.drivers(fitted)?)?,
            start: of(&TrafficDrivers::People(Arc::new(self.start.clone())))?,
            people: distance(&first.moments, &second.moments),
            ring_study: of(&ring_study)?,
        })
    }

    /// Returns the population at a point with its moments, on rings with seeds that no search has used.
    fn fit_at(&self, all: &RingTarget, best: &[f64]) -> Result<PopulationFit, String> {
        let population = population_at(&self.start, &self.numbers, best).map_err(|error| error.0)?;
        let drivers = TrafficDrivers::People(Arc::new(population.clone()));
        let (first_seed, runs) = self.rings();
        let moments = all.simulated(&drivers, (first_seed.wrapping_add(500_000), runs));
        let moments = moments.ok_or("a simulated ring lacks a moment")?;
        Ok(PopulationFit {
            population,
            values: self.numbers.iter().zip(best).map(|(number, coordinate)| number.value(*coordinate)).collect(),
            intervals: None,
            distance: distance(&moments, &all.moments),
            moments: [all.moments.clone(), moments],
            held_out: None,
            tried: 0,
        })
    }
}

#[cfg(test)]
mod people_tests;
#[cfg(test)]
mod tests;
