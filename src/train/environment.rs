//! The ring as a reinforcement-learning environment. In: an [`Action`] for each ring, held for a hold. Out: what the
//! policy may know next, the reward of the hold, and how it ended. One [`VecEnv`] is [`LANES`] rings; blocks know
//! nothing of each other, so that threads change no bit.
//!
//! An episode is a ring drawn from the configuration, warmed up by the model alone, then driven for the horizon. A ring
//! that ends takes a warmed-up one from the block's own stock, which is made sixteen at a time.

use super::{
    config::{RewardKind, TrainConfig},
    corrected::CorrectedLanes,
    drawn_ring::{draw_ring, episode_stream},
    driver::AdviceFollower,
    identification::BlockSample,
    ring::VectorizedRing,
    simd::{LANES, SimdLanes, VectorWork, in_wide_vectors, lane, splat},
};
use crate::{
    metrics::DrivenBy,
    policy::{Action, CorrectedAdvice, DriverTraits, Hold, MeanSpeed, Observation, identification::SAMPLE_S, residual},
    rng::{self, Stream},
};
use serde::{Deserialize, Serialize};

/// How a hold ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The episode goes on.
    None,
    /// The horizon is reached; the ring would go on.
    Horizon,
    /// Cars collided.
    Crash,
}

/// What one hold brought to one ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Mean over the steps, m/s, penalties taken.
    pub reward: f32,
    /// Mean speed of all cars over the steps, m/s.
    pub mean_mps: f32,
    /// How it ended.
    pub ending: Ending,
    /// What the policy would have seen next in the ring that has just ended; else what it sees next.
    pub last_seen: Observation,
    /// The whole state of the ring then.
    pub last_state: WholeState,
}

/// Numbers of [`VecEnv::whole_state`].
pub const STATE_NUMBERS: usize = 10;

/// What the value knows of a ring beyond what the policy sees, numbers of about -1 to 1.
pub type WholeState = [f32; STATE_NUMBERS];

/// Sixteen rings and their egos.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct VecEnv {
    config: TrainConfig,
    /// Number of the first ring, and which episode each lane will take next.
    first_ring: u64,
    stream: String,
    ring: VectorizedRing,
    follower: AdviceFollower,
    circumference_m: SimdLanes,
    /// Speed at which each ring flows evenly, m/s.
    equilibrium_mps: SimdLanes,
    hold_steps: u32,
    /// Own mean speed as the policy may see it, m/s.
    mean_ego_mps: SimdLanes,
    elapsed: [u32; LANES],
    /// Warmed-up rings, their lengths, and how many of them are used.
    stock: VectorizedRing,
    stock_follower: AdviceFollower,
    stock_m: SimdLanes,
    stock_equilibrium_mps: SimdLanes,
    used: usize,
    batches: u64,
    /// What is seen of the drivers, where somebody asks; and steps since the last sample.
    samples: Option<Vec<BlockSample>>,
    unsampled_steps: u32,
    /// Rings whose episodes count; those beyond go on for ever and take nothing from the stock.
    rings: usize,
    /// What the policy corrects, where it does.
    corrected: Option<CorrectedLanes>,
}

impl VecEnv {
    /// Block `index` of those of `config`, every ring at the end of its warm-up. `stream` names the random numbers:
    /// training and judging have rings of their own. An action stands for `hold`.
    pub fn new(config: &TrainConfig, stream: &str, index: usize, hold: Hold) -> Self {
        let room = config.ring.vehicles_max as usize;
        let ring = VectorizedRing::new(room, config.ring.step_s);
        let follower = AdviceFollower::new(config);
        let mut block = Self {
            config: config.clone(),
            first_ring: (index * LANES) as u64,
            stream: stream.to_owned(),
            stock: ring.clone(),
            stock_follower: follower.clone(),
            ring,
            follower,
            circumference_m: splat(0.0),
            equilibrium_mps: splat(0.0),
            hold_steps: hold.steps(),
            mean_ego_mps: splat(0.0),
            elapsed: [0; LANES],
            stock_m: splat(0.0),
            stock_equilibrium_mps: splat(0.0),
            used: LANES,
            batches: 0,
            samples: None,
            unsampled_steps: 0,
            rings: LANES,
            corrected: None,
        };
        (0..LANES).for_each(|l| block.begin_episode(l));
        block
    }

    /// The same block of which only the first `rings` count: the episodes of the others never end.
    #[must_use]
    pub fn with_rings(self, rings: usize) -> Self {
        Self { rings, ..self }
    }

    /// Lets each ring begin at another part of its horizon, so that a batch has all parts of an episode.
    pub fn spread(&mut self) {
        let horizon = self.config.horizon_decisions(self.hold_length());
        let mut stream = self.named(&format!("spread/{}", self.first_ring));
        self.elapsed.iter_mut().for_each(|elapsed| *elapsed = stream.index(horizon as usize) as u32);
    }

    /// What the policy of ring `l` may know now.
    #[inline(always)]
    pub fn observe(&self, l: usize) -> Observation {
        let corrected_mps = self.corrected.as_ref().map(|lanes| lanes.advised_mps(l));
        Observation { driver: Some(self.follower.traits(l)), corrected_mps, ..self.traffic(l) }
    }

    /// What it sees of the traffic.
    #[inline(always)]
    fn traffic(&self, l: usize) -> Observation {
        Observation {
            speed_mps: f64::from(self.ring.ego_mps()[l]),
            leader_speed_mps: f64::from(self.ring.leader_mps()[l]),
            gap_m: f64::from(self.ring.gap_m()[l]),
            circumference_m: f64::from(self.circumference_m[l]),
            vehicles: self.ring.cars(l) as u32,
            hold_s: self.hold_length().seconds(),
            mean_speed_mps: f64::from(self.mean_ego_mps[l]),
            advised_mps: self.follower.advised_mps(l),
            ..Observation::default()
        }
    }

    /// From now on actions correct this advice.
    pub fn correct(&mut self, advice: &CorrectedAdvice) {
        self.corrected = Some(CorrectedLanes::new(advice, self.config.ring.step_s));
        (0..LANES).for_each(|l| self.tell_corrected(l, CorrectedLanes::engage));
    }

    /// Shows ring `l` to what is corrected in it.
    fn tell_corrected(&mut self, l: usize, tell: fn(&mut CorrectedLanes, usize, &Observation)) {
        if self.corrected.is_some() {
            let seen = self.traffic(l);
            self.corrected.iter_mut().for_each(|lanes| tell(lanes, l, &seen));
        }
    }

    /// What the value may know and the policy may not: how all cars drive, how they could, and who the ego's driver is (an
    /// asymmetric critic, Pinto 2018). Nothing where the value sees what the policy does.
    pub fn whole_state(&self, l: usize) -> WholeState {
        if !self.config.optimiser.value_sees_all {
            return WholeState::default();
        }
        let count = self.ring.cars(l) as f32;
        let mean = self.ring.speeds_mps(l).sum::<f32>() / count;
        let variance = self.ring.speeds_mps(l).map(|v| (v - mean) * (v - mean)).sum::<f32>() / count;
        let least = self.ring.speeds_mps(l).fold(f32::MAX, f32::min);
        let even = self.equilibrium_mps[l];
        let [reaction, bias, error, time_gap, willingness] = self.follower.traits(l).numbers().map(|x| x as f32);
        let of_traffic = [mean / 2.5 - 1.0, variance.sqrt() - 1.0, least / 2.5 - 1.0, even / 2.5 - 1.0, mean - even];
        let of_driver = [reaction - 1.0, bias / 2.0, 2.0 * error - 1.0, 2.0 * time_gap - 2.0, 2.0 * willingness - 1.0];
        std::array::from_fn(|k| if k < 5 { of_traffic[k] } else { of_driver[k - 5] })
    }

    /// How long an action stands.
    pub fn hold_length(&self) -> Hold {
        Hold::of_steps(self.hold_steps, self.config.ring.step_s)
    }

    /// The configuration that the block keeps says so too.
    pub(super) fn set_iterations(&mut self, iterations: u32) {
        self.config.run.iterations = iterations;
    }

    /// What drove each ego in the last step.
    pub fn driven_by(&self) -> &[DrivenBy; LANES] {
        self.follower.driven_by()
    }

    /// The rings themselves.
    pub fn rings(&self) -> &VectorizedRing {
        &self.ring
    }

    /// New advice for the ego of ring `l`, to stand for `hold`: what is advised, no correction of anything. Before the first, and
    /// where there is none, its model drives it.
    pub fn advise(&mut self, l: usize, action: Option<Action>, hold: Hold) {
        self.follower.advise(l, action, self.ring.ego_mps()[l], hold);
    }

    /// One step under the advice that stands; no episode ends.
    pub fn step(&mut self) {
        in_wide_vectors(AdvisedStep(self));
    }

    /// One hold under these actions, which correct an advice where one is corrected; rings whose episode ended
    /// begin another.
    pub fn hold(&mut self, actions: &[Action; LANES]) -> [Outcome; LANES] {
        let (last_seen, last_state) = (Observation::default(), WholeState::default());
        let mut outcomes = [Outcome { reward: 0.0, mean_mps: 0.0, ending: Ending::None, last_seen, last_state }; LANES];
        self.hold_each(actions, |_, l, outcome| outcomes[l] = outcome);
        outcomes
    }

    /// The same, told ring by ring; one that ended has begun its next episode when it is told. Nothing is gathered, which
    /// takes longer than a step of the rings.
    #[inline(always)]
    pub fn hold_each(&mut self, actions: &[Action; LANES], mut each: impl FnMut(&Self, usize, Outcome)) {
        let (steps, hold) = (self.hold_steps, self.hold_length());
        for (l, action) in actions.iter().enumerate() {
            let corrected_mps = self.corrected.as_ref().map(|lanes| lanes.advised_mps(l));
            self.advise(l, Some(residual(corrected_mps, *action)), hold);
        }
        let range_mps = self.config.reward.range_mps as f32;
        let fresh = MeanSpeed::share(self.config.ring.step_s) as f32;
        let totals = in_wide_vectors(AdvisedHold { block: self, steps, range_mps, fresh });
        let horizon = self.config.horizon_decisions(hold);
        for (l, action) in actions.iter().enumerate() {
            let outcome = self.settle(l, *action, horizon, &totals);
            each(self, l, outcome);
        }
    }

    /// From now on what is seen of the drivers is kept; see [`VecEnv::take_samples`].
    pub fn keep_samples(&mut self) {
        self.samples = Some(Vec::new());
    }

    /// What has been seen of the drivers since the last call, a sample each [`SAMPLE_S`].
    pub fn take_samples(&mut self) -> Vec<BlockSample> {
        self.samples.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Who drives each ring.
    pub fn drivers(&self) -> [DriverTraits; LANES] {
        std::array::from_fn(|l| self.follower.traits(l))
    }

    fn sample(&mut self) {
        self.unsampled_steps += 1;
        if self.unsampled_steps < (SAMPLE_S / self.config.ring.step_s).round().max(1.0) as u32 {
            return;
        }
        self.unsampled_steps = 0;
        let advised = lane(|l| self.follower.advised_mps(l).map_or(-1.0, |advised| advised as f32));
        let now = [*self.ring.ego_mps(), *self.ring.leader_mps(), *self.ring.gap_m(), advised];
        if let Some(samples) = &mut self.samples {
            samples.push(now);
        }
    }

    /// Reward and ending of a hold of ring `l`, whose episode has `horizon` of them; one that ended is renewed.
    #[inline(always)]
    fn settle(&mut self, l: usize, action: Action, horizon: u32, totals: &Totals) -> Outcome {
        let share = 1.0 / self.hold_steps as f32;
        self.elapsed[l] += 1;
        let ending = if l >= self.rings {
            Ending::None
        } else if totals.least_gap_m[l] <= 0.0 {
            Ending::Crash
        } else if self.elapsed[l] >= horizon {
            Ending::Horizon
        } else {
            Ending::None
        };
        let mean_mps = totals.mean_mps[l] * share;
        let speed = if self.config.reward.kind == RewardKind::All { mean_mps } else { totals.ego_mps[l] * share };
        let headway = self.config.reward.headway_penalty as f32 * totals.short_headway[l] * share;
        let missed = self.config.reward.range_penalty as f32 * totals.missed_mps[l] * share;
        let mut reward = speed - headway - missed - self.action_penalty(action);
        if ending == Ending::Crash {
            reward -= self.config.reward.collision_penalty as f32;
        }
        self.tell_corrected(l, CorrectedLanes::decide);
        let (last_seen, last_state) = (self.observe(l), self.whole_state(l));
        if ending != Ending::None {
            self.begin_episode(l);
        }
        Outcome { reward, mean_mps, ending, last_seen, last_state }
    }

    fn action_penalty(&self, action: Action) -> f32 {
        let size = match action {
            Action::Acceleration(a) => a.abs() / self.config.advice.accel_limit_mps2,
            Action::Speed(_) => 0.0,
        };
        (self.config.reward.action_penalty * size) as f32
    }

    /// Begins another episode in ring `l`, whatever became of the one in it.
    pub fn begin_episode(&mut self, l: usize) {
        if self.used == LANES {
            self.restock();
        }
        self.ring.copy_lane(l, &self.stock, self.used);
        self.follower.copy_lane(l, &self.stock_follower, self.used);
        self.circumference_m[l] = self.stock_m[self.used];
        self.equilibrium_mps[l] = self.stock_equilibrium_mps[self.used];
        self.elapsed[l] = 0;
        self.mean_ego_mps[l] = self.ring.ego_mps()[l];
        self.tell_corrected(l, CorrectedLanes::engage);
        self.used += 1;
    }

    /// Draws sixteen rings and warms them up.
    fn restock(&mut self) {
        for l in 0..LANES {
            let number = (self.first_ring + l as u64) | (self.batches << 32);
            let mut stream = episode_stream(self.config.seed, &self.stream, number);
            let drawn = draw_ring(&self.config, &mut stream);
            self.stock.set(l, &drawn.start);
            self.stock_m[l] = drawn.length_m as f32;
            self.stock_equilibrium_mps[l] = drawn.start.idm.equilibrium_speed_mps(drawn.even_gap_m) as f32;
            self.stock_follower.draw(l, &self.config, &mut stream);
        }
        let steps = (self.config.ring.warm_up_s / self.config.ring.step_s).round() as usize;
        self.stock.run(steps);
        self.used = 0;
        self.batches += 1;
    }

    fn named(&self, name: &str) -> Stream {
        rng::stream(self.config.seed, &format!("{}/{name}", self.stream))
    }
}

/// What a hold adds up to, lane by lane.
struct Totals {
    mean_mps: SimdLanes,
    ego_mps: SimdLanes,
    least_gap_m: SimdLanes,
    short_headway: SimdLanes,
    missed_mps: SimdLanes,
}

/// One step of a block under the advice that stands.
struct AdvisedStep<'a>(&'a mut VecEnv);

impl VectorWork for AdvisedStep<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let block = self.0;
        let ego_mps = block.follower.step(&block.ring);
        block.ring.step(Some(&ego_mps));
    }
}

/// The steps of a hold, with what is counted in them.
struct AdvisedHold<'a> {
    block: &'a mut VecEnv,
    steps: u32,
    range_mps: f32,
    /// Share of a step in the mean of the ego's speed.
    fresh: f32,
}

impl VectorWork for AdvisedHold<'_> {
    type Output = Totals;

    #[inline(always)]
    fn run(self) -> Totals {
        let Self { block, steps, range_mps, fresh } = self;
        let mut totals = Totals::default();
        for _ in 0..steps {
            let ego_mps = block.follower.step(&block.ring);
            block.ring.step(Some(&ego_mps));
            totals.add(&block.ring, &block.follower.missed_mps(&ego_mps, range_mps));
            for (mean, now) in block.mean_ego_mps.iter_mut().zip(&ego_mps) {
                *mean += (now - *mean) * fresh;
            }
            if block.samples.is_some() {
                block.sample();
            }
            if block.corrected.as_ref().is_some_and(CorrectedLanes::watches) {
                (0..LANES).for_each(|l| block.tell_corrected(l, CorrectedLanes::watch));
            }
        }
        totals
    }
}

impl Default for Totals {
    fn default() -> Self {
        Self {
            mean_mps: splat(0.0),
            ego_mps: splat(0.0),
            least_gap_m: splat(f32::MAX),
            short_headway: splat(0.0),
            missed_mps: splat(0.0),
        }
    }
}

impl Totals {
    /// The cars that can collide are the ego with its leader and its follower with it: the others keep behind theirs by
    /// their model.
    #[inline(always)]
    fn add(&mut self, ring: &VectorizedRing, missed_mps: &SimdLanes) {
        for (l, missed) in missed_mps.iter().enumerate() {
            let (gap_m, ego_mps) = (ring.gap_m()[l], ring.ego_mps()[l]);
            self.mean_mps[l] += ring.mean_mps()[l];
            self.ego_mps[l] += ego_mps;
            self.missed_mps[l] += missed;
            self.least_gap_m[l] = self.least_gap_m[l].min(gap_m).min(ring.gap_behind_m()[l]);
            // The missing part of a time gap of 1 s, as in Flow's environments.
            self.short_headway[l] += (1.0 - gap_m / ego_mps.max(0.1)).max(0.0);
        }
    }
}
