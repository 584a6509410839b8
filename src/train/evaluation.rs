//! Evaluation of a policy over whole episodes on the fast ring. In: a configuration's rings and a policy for each. Out: an
//! [`EvaluationResult`] for each, over the whole horizon with its transients; or the [`Trajectories`] of one. The policy acts through a
//! drive's own [`Advisor`], so that hold and observation are the same as in a drive.

use super::{
    config::{RingConfig, TrainConfig},
    environment::VecEnv,
    latent_traits::LatentTraits,
    simd::LANES,
};
use crate::{
    metrics::{AdvisedStep, Approach, EpisodeMetrics, EpisodeStep, EvaluationResult, Trajectories},
    policy::{Action, Advice, Advisor, DriverEstimate, DriverTraits, Hold, Observation, Policy, WhoDrives},
    space::CAR_LENGTH_M,
    time::Tick,
};
use rayon::prelude::*;
use std::ops::Range;

/// Evaluates `rings` rings drawn from `config` with the random stream `stream`, each advised vehicle with its own policy from `make` (`None`:
/// the model drives).
pub fn evaluate(
    config: &TrainConfig,
    stream: &str,
    rings: usize,
    make: impl Fn() -> Option<Box<dyn Policy>> + Sync,
) -> Vec<EvaluationResult> {
    evaluate_part(config, stream, 0..rings, rings, make)
}

/// Evaluates some of the `of` rings of [`evaluate`], so that a caller can act between parts. `rings` must start at a multiple of 16.
pub fn evaluate_part(
    config: &TrainConfig,
    stream: &str,
    rings: Range<usize>,
    of: usize,
    make: impl Fn() -> Option<Box<dyn Policy>> + Sync,
) -> Vec<EvaluationResult> {
    debug_assert!(rings.start.is_multiple_of(LANES), "a part begins at {}", rings.start);
    let blocks = of.div_ceil(LANES);
    let one = |index| {
        let mut block = EvaluatedBlock::new(config, stream, index, config.hold_of(index, blocks), &make);
        (0..steps(config, config.ring.horizon_s)).for_each(|_| block.step());
        block.results().collect::<Vec<_>>()
    };
    let part = rings.start / LANES..rings.end.div_ceil(LANES);
    let results: Vec<Vec<EvaluationResult>> = part.into_par_iter().map(one).collect();
    results.into_iter().flatten().take(rings.len()).collect()
}

/// A block of [`evaluate`]'s rings in progress.
pub(super) struct EvaluatedBlock {
    pub env: VecEnv,
    pub advisors: Advisors,
    metrics: Vec<EpisodeMetrics>,
    step: u64,
}

impl EvaluatedBlock {
    /// Returns block `index`, each ring with its own policy from `make`, asked every `hold`.
    pub fn new(
        config: &TrainConfig,
        stream: &str,
        index: usize,
        hold: Hold,
        make: impl FnMut() -> Option<Box<dyn Policy>>,
    ) -> Self {
        let env = VecEnv::new(config, stream, index, hold);
        let metrics = |l| EpisodeMetrics::new(config.ring.step_s, env.circumference_m(l));
        let metrics = (0..LANES).map(metrics).collect();
        Self { advisors: Advisors::new(config, hold, make), env, metrics, step: 0 }
    }

    /// Runs one step: issues due advice and updates the metrics.
    pub fn step(&mut self) {
        self.advisors.advise(&mut self.env, self.step);
        self.step += 1;
        self.env.step();
        let (ring, advised) = (self.env.rings(), self.env.advised());
        for (l, metrics) in self.metrics.iter_mut().enumerate() {
            let rows = l * advised..(l + 1) * advised;
            let pair = |gap_m: f32, behind_mps: f32, ahead_mps: f32| {
                Some(Approach { gap_m: gap_m.into(), closing_mps: f64::from(behind_mps) - f64::from(ahead_mps) })
            };
            let ego_mps = ring.ego_mps()[l];
            let now = EpisodeStep {
                ahead: pair(ring.gap_m()[l], ego_mps, ring.leader_mps()[l]),
                behind: pair(ring.gaps_m(1)[l], ring.speed_mps_of(1)[l], ego_mps),
                advice: self.advisors.standing(rows.start),
                driven_by: Some(self.env.driven_by()[l]),
                others: self.advisors.others(&self.env, rows.clone()),
            };
            // The gap behind the ego is in the step.
            if rows.clone().skip(1).any(|row| self.env.speed_and_gaps(row)[2] <= 0.0) {
                metrics.crash();
            }
            metrics.add((0..).zip(ring.speeds_mps(l).map(f64::from)), now);
        }
    }

    /// Returns the results of the rings so far.
    pub fn results(&self) -> impl Iterator<Item = EvaluationResult> + '_ {
        self.metrics.iter().map(EpisodeMetrics::result)
    }
}

/// A driver's true traits and a policy's estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdentifiedDriver {
    /// True traits of the driver.
    pub truth: DriverTraits,
    /// Traits estimated by the policy, or derived from its latents.
    pub estimate: DriverEstimate,
}

/// Runs the rings of [`evaluate`] for `after_s` and returns the true and estimated traits; rings whose policy has no estimator are left
/// out. Latents are converted to traits by `LatentTraits`, fitted to as many other rings with the stream `stream` and `/latents`.
pub fn identified(
    config: &TrainConfig,
    stream: &str,
    rings: usize,
    after_s: f64,
    make: impl Fn() -> Option<Box<dyn Policy>> + Sync,
) -> Vec<IdentifiedDriver> {
    let drivers = watched_drivers(config, stream, rings, after_s, &make);
    let latents = |(truth, driver): &(DriverTraits, WhoDrives)| Some((*truth, driver.latents()?));
    let fit = drivers.iter().any(|driver| latents(driver).is_some()).then(|| {
        let others = watched_drivers(config, &format!("{stream}/latents"), rings, after_s, &make);
        LatentTraits::of(&others.iter().filter_map(latents).collect::<Vec<_>>())
    });
    let of = |(truth, driver): (DriverTraits, WhoDrives)| {
        let estimate = match driver {
            WhoDrives::Traits(estimate) => estimate,
            WhoDrives::Latents(latents) => fit?.traits(&latents),
        };
        Some(IdentifiedDriver { truth, estimate })
    };
    drivers.into_iter().filter_map(of).collect()
}

/// Returns the true traits of each ring's driver and the policy's estimate after `after_s`.
fn watched_drivers(
    config: &TrainConfig,
    stream: &str,
    rings: usize,
    after_s: f64,
    make: &(impl Fn() -> Option<Box<dyn Policy>> + Sync),
) -> Vec<(DriverTraits, WhoDrives)> {
    let blocks = rings.div_ceil(LANES);
    let of_block = |index| {
        let hold = config.hold_of(index, blocks);
        let mut block = VecEnv::new(config, stream, index, hold);
        let mut drivers = Advisors::new(config, hold, make);
        for step in 0..=steps(config, after_s) {
            drivers.advise(&mut block, step);
            block.step();
        }
        // Of rings with several advised vehicles, the ego.
        let of = |(l, truth): (usize, DriverTraits)| Some((truth, drivers.who_drives(l * block.advised())?));
        block.drivers().into_iter().enumerate().map(of).collect::<Vec<_>>()
    };
    let drivers: Vec<Vec<Option<(DriverTraits, WhoDrives)>>> = (0..blocks).into_par_iter().map(of_block).collect();
    drivers.into_iter().flatten().take(rings).flatten().collect()
}

/// Returns the number of steps in a time.
pub(super) fn steps(config: &TrainConfig, time_s: f64) -> u64 {
    (time_s / config.ring.step_s).round() as u64
}

/// Advisors of a block, one per advised vehicle of each ring.
pub(super) struct Advisors {
    of: Vec<Advisor>,
    ticks: u64,
    limit_mps: f64,
    /// True if a policy sees the whole ring.
    see_whole_ring: bool,
}

impl Advisors {
    /// Returns advisors with separate policies from `make`, asked every `hold`.
    pub fn new(config: &TrainConfig, hold: Hold, mut make: impl FnMut() -> Option<Box<dyn Policy>>) -> Self {
        let rows = LANES * config.ring.advised_slots().count();
        let policies: Vec<Option<Box<dyn Policy>>> = (0..rows).map(|_| make()).collect();
        let sees = |policy: &dyn Policy| policy.inputs().iter().any(|input| input.feature.is_of_whole_ring());
        Self {
            see_whole_ring: policies.iter().flatten().any(|policy| sees(policy.as_ref())),
            of: policies.into_iter().map(|policy| Advisor::new(policy, hold, config.range_mps())).collect(),
            ticks: (config.ring.step_s / crate::time::TICK_S).round() as u64,
            limit_mps: config.ring.idm.v0,
        }
    }

    /// Returns the current advice of a row.
    pub fn standing(&self, row: usize) -> Option<Advice> {
        self.of[row].standing()
    }

    /// Returns the combined state of the advised vehicles of a ring without its ego; `rows` are those of all.
    fn others(&self, block: &VecEnv, rows: Range<usize>) -> AdvisedStep {
        let mut step = AdvisedStep::default();
        for row in rows.skip(1) {
            let [speed_mps, gap_m, _] = block.speed_and_gaps(row).map(f64::from);
            step.min_gap_m = Some(step.min_gap_m.map_or(gap_m, |least_m| gap_m.min(least_m)));
            let Some(advice) = self.standing(row) else { continue };
            step.advised += 1;
            step.in_range += u64::from(advice.accepts(speed_mps));
        }
        step
    }

    /// Returns the current estimate of the driver by the policy of a row, if it has an estimator.
    pub fn who_drives(&self, row: usize) -> Option<WhoDrives> {
        self.of[row].who_drives()
    }

    /// Returns the observation that the advisor of a row is about to give its policy.
    pub fn complete_observation(&self, row: usize, observation: &Observation) -> Observation {
        self.of[row].complete_observation(observation)
    }

    /// Begins step number `step`: issues due advice.
    pub fn advise(&mut self, block: &mut VecEnv, step: u64) {
        if self.see_whole_ring {
            block.show_whole_ring();
        }
        for (row, advisor) in self.of.iter_mut().enumerate() {
            let seen = block.observe(row);
            if let Some(advice) = advisor.step(Tick(step * self.ticks), &seen, self.limit_mps) {
                let within = match advice.action {
                    Action::Speed(_) => Action::Speed(advice.target_mps),
                    acceleration => acceleration,
                };
                block.advise(row, Some(within), block.hold_length());
            } else if advisor.standing().is_none() {
                block.advise(row, None, block.hold_length());
            }
        }
    }
}

/// Returns the trajectories on ring 0 of [`evaluate`] with the same arguments, from `before_s` before the first advice to `after_s` after
/// it.
pub fn trajectories(
    config: &TrainConfig,
    stream: &str,
    [before_s, after_s]: [f64; 2],
    make: impl Fn() -> Option<Box<dyn Policy>>,
) -> Trajectories {
    let warm_up_s = (config.ring.warm_up_s - before_s).max(0.0);
    let hold = config.hold();
    let mut block = VecEnv::new(
        &TrainConfig { ring: RingConfig { warm_up_s, ..config.ring.clone() }, ..config.clone() },
        stream,
        0,
        hold,
    );
    let mut drivers = Advisors::new(config, hold, &make);
    let mut trace = Trajectories {
        circumference_m: block.circumference_m(0),
        span_s: Some([warm_up_s - config.ring.warm_up_s, after_s]),
        ..Trajectories::default()
    };
    let before = steps(config, config.ring.warm_up_s - warm_up_s);
    let mut ego_m = 0.0;
    for step in 0..before + steps(config, after_s) {
        if step >= before {
            drivers.advise(&mut block, step - before);
        }
        block.step();
        let ring = block.rings();
        ego_m += ring.ego_mps()[0] * config.ring.step_s as f32;
        let mut place_m = ego_m;
        let place = |k: usize| {
            if k > 0 {
                place_m -= ring.gaps_m(k)[0] + CAR_LENGTH_M as f32;
            }
            place_m
        };
        trace.way_m.push((0..ring.cars(0)).map(place).collect());
        trace.speed_mps.push(ring.speeds_mps(0).collect());
        trace.time_s.push((step + 1) as f64 * config.ring.step_s - before as f64 * config.ring.step_s);
        trace.shown_mps.push(drivers.of[0].standing().map(|advice| advice.target_mps));
        if block.least_gap_m(0) <= 0.0 {
            trace.crash_s = trace.time_s.last().copied();
            break;
        }
    }
    trace
}
