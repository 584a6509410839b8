//! Intervals of fitted numbers by a bootstrap over persons. In: the measured ring, the best point and all points tried. Out: 95 % intervals.
//!
//! Each sample draws as many persons as there are, with replacement; each keeps their own leader's series. Speed and share of the waves
//! stay those of the ring. The search for a sample starts at the point, of all tried so far, with moments nearest to the sample's, in a
//! narrow box around it. An interval is the fitted value, plus and minus 1.96 standard deviations of the samples' (of its logarithm for a
//! mean), within the bounds.

use super::{FitTask, Nearest, RingTarget, Tried, distance};
use crate::rng;
use std::sync::{
    PoisonError,
    atomic::{AtomicBool, Ordering},
};

/// Side of a narrow box, as a share of the whole box's.
const BOX_SHARE: f64 = 0.3;
/// Fewest samples that give an interval.
const LEAST_SAMPLES: usize = 5;

impl FitTask {
    /// Returns the interval of each number around the best point; `None` if the fit was stopped or too few samples have all moments.
    pub(super) fn intervals(
        &self,
        all: &RingTarget,
        best: &[f64],
        tried: &Tried,
        stop: &AtomicBool,
        watch: &(impl Fn(f64) + Sync),
    ) -> Option<Vec<[f64; 2]>> {
        let mut points: Vec<Vec<f64>> = Vec::new();
        for sample in 0..self.bootstrap {
            let mut stream = rng::stream(self.seed, &format!("population-fit/sample/{sample}"));
            let persons: Vec<usize> = (0..all.persons()).map(|_| stream.index(all.persons())).collect();
            let Some(wanted) = all.of_persons(&persons) else { continue };
            let start = nearest_tried(tried, &wanted).unwrap_or_else(|| best.to_vec());
            let (bounds, seed) = (self.narrow_box(&start), self.seed.wrapping_add(u64::from(sample) + 1));
            let nearest = Nearest { target: all, wanted: &wanted, bounds, start, budget: self.sample_budget, seed };
            points.push(self.search(&nearest, tried, stop, watch)?);
        }
        let is_enough = points.len() >= LEAST_SAMPLES && !stop.load(Ordering::Relaxed);
        is_enough.then(|| (0..best.len()).map(|k| self.interval(k, best[k], &points)).collect())
    }

    /// Returns the interval of the `k`-th number from the points of all samples.
    fn interval(&self, k: usize, best: f64, points: &[Vec<f64>]) -> [f64; 2] {
        let n = points.len() as f64;
        let mean = points.iter().map(|point| point[k]).sum::<f64>() / n;
        let sd = (points.iter().map(|point| (point[k] - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let [low, high] = self.numbers[k].bounds(&self.start);
        [best - 1.96 * sd, best + 1.96 * sd].map(|end| self.numbers[k].value(end.clamp(low, high)))
    }

    /// Returns a box around a point, within the bounds of the whole search.
    pub(super) fn narrow_box(&self, around: &[f64]) -> Vec<[f64; 2]> {
        let side = |(number, at): (&super::FittedNumber, &f64)| {
            let [low, high] = number.bounds(&self.start);
            let half = BOX_SHARE / 2.0 * (high - low);
            [(at - half).max(low), (at + half).min(high)]
        };
        self.numbers.iter().zip(around).map(side).collect()
    }
}

/// Returns the tried point with moments nearest to the wanted ones.
fn nearest_tried(tried: &Tried, wanted: &[f64]) -> Option<Vec<f64>> {
    let tried = tried.lock().unwrap_or_else(PoisonError::into_inner);
    let far = |(_, moments): &(Vec<f64>, Vec<f64>)| distance(moments, wanted);
    tried.iter().min_by(|a, b| far(a).total_cmp(&far(b))).map(|(point, _)| point.clone())
}
