//! Holds of a block of rings. In: an action for each row. Out: the rewards of the hold, the next observations and the endings.

use super::VecEnv;
use crate::{
    policy::{Action, MeanSpeed, residual},
    train::{
        config::RewardKind,
        corrected::CorrectedLanes,
        hold_totals::{RingTotals, VehicleTotals},
        outcome::{Ending, Outcome},
        simd::{LANES, VectorWork, in_wide_vectors},
    },
};

impl VecEnv {
    /// Runs one hold with these actions, or corrections if an advice is corrected, one for each row. Rings whose episode ended begin
    /// another.
    pub fn hold(&mut self, actions: &[Action]) -> Vec<Outcome> {
        let mut outcomes = Vec::with_capacity(actions.len());
        self.hold_each(actions, |_, _, outcome| outcomes.extend(outcome));
        outcomes
    }

    /// Runs one hold and passes each row with its outcome to `each`, and once more without one if the ring has then begun another episode.
    /// Avoids collecting the outcomes, which takes longer than a step of the rings.
    #[inline(always)]
    pub fn hold_each(&mut self, actions: &[Action], mut each: impl FnMut(&Self, usize, Option<Outcome>)) {
        let (steps, hold) = (self.hold_steps, self.hold_length());
        for (row, action) in actions.iter().enumerate() {
            let (l, number) = self.place(row);
            let advice = residual(self.advised[number].corrected_mps(l), *action);
            let time_s = f64::from(self.elapsed[l]) * hold.seconds();
            let probed = self.probe.map_or(advice, |probe| probe.added_to(advice, time_s, hold.seconds()));
            self.advise(row, Some(probed), hold);
        }
        let range_mps = self.config.range_mps() as f32;
        let fresh = MeanSpeed::share(self.config.ring.step_s) as f32;
        let totals = in_wide_vectors(AdvisedHold { block: self, steps, range_mps, fresh });
        let horizon = self.config.horizon_decisions(hold);
        for l in 0..LANES {
            self.settle(l, actions, horizon, &totals, &mut each);
        }
    }

    /// Reports the outcomes of a hold on ring `l`, whose episodes last `horizon` holds, and begins a new episode if this one ended.
    #[inline(always)]
    fn settle(
        &mut self,
        l: usize,
        actions: &[Action],
        horizon: u32,
        totals: &RingTotals,
        each: &mut impl FnMut(&Self, usize, Option<Outcome>),
    ) {
        self.elapsed[l] += 1;
        self.ways.ego_way_m[l] += self.advised[0].totals.own_mps[l] * self.config.ring.step_s as f32;
        let ending = if l >= self.rings {
            Ending::None
        } else if self.advised.iter().any(|vehicle| vehicle.totals.least_gap_m[l] <= 0.0) {
            Ending::Crash
        } else if self.elapsed[l] >= horizon {
            Ending::Horizon
        } else {
            Ending::None
        };
        self.tell_corrected(l, CorrectedLanes::decide);
        let mean_mps = totals.mean_mps[l] * (1.0 / self.hold_steps as f32);
        for number in 0..self.advised() {
            let row = self.row(l, number);
            let reward = self.reward(l, number, actions[row], totals, ending);
            let (last_seen, last_state) = (self.observe_from(l, number), self.whole_state(row));
            each(self, row, Some(Outcome { reward, mean_mps, ending, last_seen, last_state }));
        }
        if ending != Ending::None {
            self.ended.keep(l, &self.ring, &self.ways);
            self.begin_episode(l);
            (0..self.advised()).for_each(|number| each(self, self.row(l, number), None));
        }
    }

    /// Returns the reward of an advised vehicle of ring `l` for a hold, m/s: the speed less its own penalties.
    #[inline(always)]
    fn reward(&self, l: usize, number: usize, action: Action, totals: &RingTotals, ending: Ending) -> f32 {
        let (share, own, settings) = (1.0 / self.hold_steps as f32, &self.advised[number].totals, &self.config.reward);
        let speed = if settings.kind == RewardKind::All { totals.mean_mps[l] * share } else { own.own_mps[l] * share };
        let headway = settings.headway_penalty as f32 * own.short_headway[l] * share;
        let missed = settings.range_penalty as f32 * own.missed_mps[l] * share;
        let uneven = settings.speed_sd_penalty as f32 * totals.speed_sd_mps[l] * share;
        let reward = speed - headway - missed - uneven - self.action_penalty(action);
        if ending == Ending::Crash && own.least_gap_m[l] <= 0.0 {
            return reward - settings.collision_penalty as f32;
        }
        reward
    }

    fn action_penalty(&self, action: Action) -> f32 {
        let size = match action {
            Action::Acceleration(a) => a.abs() / self.config.advice.accel_limit_mps2,
            Action::Speed(_) => 0.0,
        };
        (self.config.reward.action_penalty * size) as f32
    }
}

/// Steps of a hold with their sums.
struct AdvisedHold<'a> {
    block: &'a mut VecEnv,
    steps: u32,
    range_mps: f32,
    /// Weight of one step in the mean of the own speed.
    fresh: f32,
}

impl VectorWork for AdvisedHold<'_> {
    type Output = RingTotals;

    #[inline(always)]
    fn run(self) -> RingTotals {
        let Self { block, steps, range_mps, fresh } = self;
        let mut totals = RingTotals::new();
        block.advised.iter_mut().for_each(|vehicle| vehicle.totals = VehicleTotals::default());
        for _ in 0..steps {
            block.drive();
            totals.add(&block.ring);
            for (vehicle, driven) in block.advised.iter_mut().zip(&block.driven) {
                vehicle.add(&block.ring, &driven.mps, range_mps, fresh);
            }
            if block.config.reward.speed_sd_penalty > 0.0 {
                let sd_mps = block.ring.speed_sd_mps();
                totals.speed_sd_mps.iter_mut().zip(&sd_mps).for_each(|(total, now)| *total += now);
            }
            block.watch_drivers();
            if block.samples.is_some() {
                block.sample();
            }
            if block.advised[0].watches_advice() {
                (0..LANES).for_each(|l| block.tell_corrected(l, CorrectedLanes::watch));
            }
        }
        totals
    }
}
