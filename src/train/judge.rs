//! How good a policy is. In: a configuration's rings and a policy for each. Out: mean speed of all cars over the whole
//! horizon, transients included, smallest gap, crash, time until the wave is calm. The policy acts through the drive's own
//! [`Advisor`], so that hold and observation are those of a drive.

use super::{
    config::TrainConfig,
    environment::EnvBlock,
    lanes::{LANES, Lane, splat},
};
use crate::{
    policy::{Advisor, Policy},
    time::Tick,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The wave is calm where the standard deviation of speed over the cars stays below this, m/s (FACTS 3).
const CALM_SD_MPS: f64 = 0.5;

/// One ring, driven to the horizon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Mean speed of all cars over the horizon, m/s; cars stand from a crash on.
    pub mean_mps: f64,
    /// Smallest gap of the ego to its leader or its follower to it, metres.
    pub least_gap_m: f64,
    /// Cars collided.
    pub crashed: bool,
    /// Seconds from the first advice until the wave is calm for good; `None` if it never is.
    pub calm_s: Option<f64>,
}

/// Mean over rings and its 95 % interval (1.96 standard errors), m/s.
pub fn mean_and_interval(verdicts: &[Verdict]) -> (f64, f64) {
    let n = verdicts.len() as f64;
    let mean = verdicts.iter().map(|v| v.mean_mps).sum::<f64>() / n;
    let square = verdicts.iter().map(|v| (v.mean_mps - mean).powi(2)).sum::<f64>();
    (mean, 1.96 * (square / (n - 1.0).max(1.0) / n).sqrt())
}

/// Drives `rings` rings drawn from `config` by the random numbers named `stream`, each with a policy of its own from
/// `make` (`None`: the ego's model drives).
pub fn judge(
    config: &TrainConfig,
    stream: &str,
    rings: usize,
    make: impl Fn() -> Option<Box<dyn Policy>> + Sync,
) -> Vec<Verdict> {
    let blocks = rings.div_ceil(LANES);
    let verdicts: Vec<Vec<Verdict>> = (0..blocks)
        .into_par_iter()
        .map(|index| judge_block(config, stream, index, config.hold_steps_of(index, blocks), &make))
        .collect();
    verdicts.into_iter().flatten().take(rings).collect()
}

fn judge_block(
    config: &TrainConfig,
    stream: &str,
    index: usize,
    hold_steps: u32,
    make: &(impl Fn() -> Option<Box<dyn Policy>> + Sync),
) -> Vec<Verdict> {
    let mut block = EnvBlock::new(config, stream, index, hold_steps);
    let advisor = |_| Advisor::new(make(), config.step_s, hold_steps, 0.0);
    let mut advisors: Vec<Advisor> = (0..LANES).map(advisor).collect();
    let steps = (config.horizon_s / config.step_s).round() as u64;
    let ticks = (config.step_s / crate::time::TICK_S).round() as u64;
    let mut tally = Tally { sum: [0.0; LANES], least_gap_m: splat(f32::MAX), uncalm: [0; LANES] };
    for step in 0..steps {
        for (l, advisor) in advisors.iter_mut().enumerate() {
            let seen = block.observe(l);
            if let Some(advice) = advisor.step(Tick(step * ticks), &seen, config.idm.v0) {
                block.advise(l, advice.action, block.hold_s());
            }
        }
        block.step();
        tally.add(&block, step);
    }
    (0..LANES).map(|l| tally.verdict(l, steps, config.step_s)).collect()
}

struct Tally {
    sum: [f64; LANES],
    least_gap_m: Lane,
    /// The first step after which the wave has been calm.
    uncalm: [u64; LANES],
}

impl Tally {
    fn add(&mut self, block: &EnvBlock, step: u64) {
        let ring = block.rings();
        for l in 0..LANES {
            self.least_gap_m[l] = self.least_gap_m[l].min(ring.gap_m()[l]).min(ring.gap_behind_m()[l]);
            if self.least_gap_m[l] <= 0.0 {
                continue;
            }
            let mean = f64::from(ring.mean_mps()[l]);
            self.sum[l] += mean;
            let square = ring.speeds_mps(l).map(|v| (f64::from(v) - mean).powi(2)).sum::<f64>() / ring.cars(l) as f64;
            if square >= CALM_SD_MPS * CALM_SD_MPS {
                self.uncalm[l] = step + 1;
            }
        }
    }

    fn verdict(&self, l: usize, steps: u64, step_s: f64) -> Verdict {
        let crashed = self.least_gap_m[l] <= 0.0;
        let calm = !crashed && self.uncalm[l] < steps;
        Verdict {
            mean_mps: self.sum[l] / steps as f64,
            least_gap_m: f64::from(self.least_gap_m[l]),
            crashed,
            calm_s: calm.then_some(self.uncalm[l] as f64 * step_s),
        }
    }
}
