//! The ring as a reinforcement-learning environment. In: an [`Action`] per ring and hold. Out: the next observation, the reward of the
//! hold and its ending. One [`VecEnv`] is a block of [`LANES`] rings. Blocks are independent, so the number of threads changes no bit.
//!
//! An episode is a ring drawn from the configuration, warmed up by the model alone, then driven for the horizon. A ring whose episode
//! ends is replaced by a warmed-up one from the block's stock, which is made sixteen at a time.

use super::{
    config::{RewardKind, TrainConfig},
    corrected::CorrectedLanes,
    drawn_ring::{draw_ring, episode_stream},
    driver::AdviceFollower,
    hold_totals::Totals,
    identification::BlockSample,
    ring::VectorizedRing,
    ring_vehicles::{self, EndedRings, RingVehicle, RingWays},
    simd::{LANES, SimdLanes, VectorWork, in_wide_vectors, lane, splat},
};
use crate::{
    metrics::DrivenBy,
    policy::{
        Action, CorrectedAdvice, DriverObserver, DriverTraits, Hold, MeanSpeed, NetworkInput, Observation,
        ObservedDriver, Probe, WholeRing, identification::SAMPLE_S, residual,
    },
    rng::{self, Stream},
};
use serde::{Deserialize, Serialize};

/// Ending of a hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The episode continues after the hold.
    None,
    /// The episode reached its horizon; the traffic itself would continue.
    Horizon,
    /// Two vehicles collided, and the episode is over.
    Crash,
}

/// Result of one hold on one ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Mean reward over the steps, m/s, after penalties.
    pub reward: f32,
    /// Mean speed of all vehicles over the steps, m/s.
    pub mean_mps: f32,
    /// Ending of the hold.
    pub ending: Ending,
    /// Next observation of the ring; of an episode that has just ended, its final observation.
    pub last_seen: Observation,
    /// Whole state of the ring at `last_seen`.
    pub last_state: WholeState,
}

/// Number of entries of [`VecEnv::whole_state`].
pub const STATE_NUMBERS: usize = 10;

/// Inputs of the value network beyond the policy's inputs, each about -1 to 1.
pub type WholeState = [f32; STATE_NUMBERS];

/// A block of sixteen rings and their egos.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct VecEnv {
    config: TrainConfig,
    /// Index of the block's first ring among all rings.
    first_ring: u64,
    stream: String,
    ring: VectorizedRing,
    follower: AdviceFollower,
    ways: RingWays,
    /// Rings at the end of their last episodes.
    ended: EndedRings,
    /// Speed at which each ring flows evenly, m/s.
    equilibrium_mps: SimdLanes,
    hold_steps: u32,
    /// Moving mean of the ego's speed as the policy may see it, m/s.
    mean_ego_mps: SimdLanes,
    elapsed: [u32; LANES],
    /// Warmed-up rings in stock; `stock_m` are their lengths and `used` counts those taken.
    stock: VectorizedRing,
    stock_follower: AdviceFollower,
    stock_m: SimdLanes,
    stock_equilibrium_mps: SimdLanes,
    used: usize,
    batches: u64,
    /// Samples of the drivers, if kept; `unsampled_steps` counts steps since the last sample.
    samples: Option<Vec<BlockSample>>,
    unsampled_steps: u32,
    rings: usize,
    /// Advice that the policy corrects; `None` if the policy corrects no other advice.
    corrected: Option<CorrectedLanes>,
    /// Observers of the drivers, if the policy sees what they observe.
    observers: Option<Vec<DriverObserver>>,
    /// Probe of the drivers, if they are probed.
    probe: Option<Probe>,
    /// True if observations have the state of the whole ring.
    is_whole_shown: bool,
}

impl VecEnv {
    /// Returns block `index` of `config` with every ring at the end of its warm-up. `stream` names the random numbers: training and
    /// evaluation have separate rings. Each action is held for `hold`.
    pub fn new(config: &TrainConfig, stream: &str, index: usize, hold: Hold) -> Self {
        let config = &config.of_block(index);
        let room = config.ring.vehicles_max as usize;
        let ring = VectorizedRing::new(room, config.ring.step_s);
        let follower = AdviceFollower::new(config);
        let mut block = Self {
            config: config.clone(),
            first_ring: (index * LANES) as u64,
            stream: stream.to_owned(),
            stock: ring.clone(),
            stock_follower: follower.clone(),
            ended: EndedRings::new(ring.clone()),
            ring,
            follower,
            ways: RingWays::default(),
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
            observers: None,
            probe: config.probe(),
            is_whole_shown: config.inputs().iter().any(|input| input.feature.is_of_whole_ring()),
        };
        block.observe_drivers_for(&config.inputs());
        (0..LANES).for_each(|l| block.begin_episode(l));
        block
    }

    /// Returns the block with episodes on the first `rings` rings only; the others never end.
    #[must_use]
    pub fn with_rings(self, rings: usize) -> Self {
        Self { rings, ..self }
    }

    /// Starts each ring at a random point of its horizon, so that a batch covers all parts of an episode.
    pub fn spread(&mut self) {
        let horizon = self.config.horizon_decisions(self.hold_length());
        let mut stream = self.named(&format!("spread/{}", self.first_ring));
        self.elapsed.iter_mut().for_each(|elapsed| *elapsed = stream.index(horizon as usize) as u32);
    }

    /// Returns the complete observation of ring `l`, the driver's traits included.
    #[inline(always)]
    pub fn observe(&self, l: usize) -> Observation {
        let corrected_mps = self.corrected.as_ref().map(|lanes| lanes.advised_mps(l));
        let ring = self
            .is_whole_shown
            .then(|| WholeRing::of(self.ring.speeds_mps(l).map(f64::from), self.follower.deviation_mps(l)));
        Observation { driver: Some(self.follower.traits(l)), corrected_mps, ring, ..self.traffic(l) }
    }

    /// Returns the part of the observation that describes traffic.
    #[inline(always)]
    fn traffic(&self, l: usize) -> Observation {
        Observation {
            speed_mps: f64::from(self.ring.ego_mps()[l]),
            leader_speed_mps: f64::from(self.ring.leader_mps()[l]),
            gap_m: f64::from(self.ring.gap_m()[l]),
            circumference_m: f64::from(self.ways.circumference_m[l]),
            vehicles: self.ring.cars(l) as u32,
            hold_s: self.hold_length().seconds(),
            mean_speed_mps: f64::from(self.mean_ego_mps[l]),
            advised_mps: self.follower.advised_mps(l),
            observed: self.observed(l),
            ..Observation::default()
        }
    }

    /// Sets the advice that actions correct from now on.
    pub fn correct(&mut self, advice: &CorrectedAdvice) {
        self.corrected = Some(CorrectedLanes::new(advice, self.config.ring.step_s));
        if let CorrectedAdvice::Network(network) = advice {
            self.observe_drivers_for(&network.inputs);
        }
        (0..LANES).for_each(|l| self.tell_corrected(l, CorrectedLanes::engage));
    }

    /// Passes the current observation of ring `l` to the corrected advice.
    fn tell_corrected(&mut self, l: usize, tell: fn(&mut CorrectedLanes, usize, &Observation)) {
        if self.corrected.is_some() {
            let seen = self.traffic(l);
            self.corrected.iter_mut().for_each(|lanes| tell(lanes, l, &seen));
        }
    }

    /// Returns the state that the value network sees and the policy does not: speeds of all vehicles, equilibrium speed and the driver's
    /// traits (an asymmetric critic, Pinto 2018). All zeros unless `value_sees_all` is set.
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

    /// Returns the hold of an action.
    pub fn hold_length(&self) -> Hold {
        Hold::of_steps(self.hold_steps, self.config.ring.step_s)
    }

    /// Sets the number of iterations in the block's copy of the configuration.
    pub(super) fn set_iterations(&mut self, iterations: u32) {
        self.config.run.iterations = iterations;
    }

    /// Returns the source of each ego's speed in the last step.
    pub fn driven_by(&self) -> &[DrivenBy; LANES] {
        self.follower.driven_by()
    }

    /// Returns the simulated rings.
    pub fn rings(&self) -> &VectorizedRing {
        &self.ring
    }

    /// Adds the state of the whole ring to observations from now on.
    pub(super) fn show_whole_ring(&mut self) {
        self.is_whole_shown = true;
    }

    /// Returns the vehicles of ring `l` now, the ego first, then backwards.
    pub fn vehicles(&self, l: usize) -> impl Iterator<Item = RingVehicle> + '_ {
        ring_vehicles::vehicles(&self.ring, &self.ways, l)
    }

    /// Returns the rings at the end of their last episodes.
    pub fn ended(&self) -> &EndedRings {
        &self.ended
    }

    /// Returns the length of ring `l`, metres.
    pub fn circumference_m(&self, l: usize) -> f64 {
        self.ways.circumference_m[l].into()
    }

    /// Returns the time since the episode of ring `l` began, seconds.
    pub fn time_s(&self, l: usize) -> f64 {
        f64::from(self.elapsed[l]) * self.hold_length().seconds()
    }

    /// Issues advice to the ego of ring `l` for `hold`; `action` is the advice itself, not a correction. Before the first advice, and
    /// with `None`, the car-following model drives the ego.
    pub fn advise(&mut self, l: usize, action: Option<Action>, hold: Hold) {
        self.follower.advise(l, action, self.ring.ego_mps()[l], hold);
    }

    /// Runs one step under the current advice; no episode ends.
    pub fn step(&mut self) {
        in_wide_vectors(AdvisedStep(self));
    }

    /// Runs one hold with these actions, or corrections if an advice is corrected. Rings whose episode ended begin another.
    pub fn hold(&mut self, actions: &[Action; LANES]) -> [Outcome; LANES] {
        let (last_seen, last_state) = (Observation::default(), WholeState::default());
        let mut outcomes = [Outcome { reward: 0.0, mean_mps: 0.0, ending: Ending::None, last_seen, last_state }; LANES];
        self.hold_each(actions, |_, l, outcome| outcomes[l] = outcome);
        outcomes
    }

    /// Runs one hold and passes the outcome of each ring to `each`; an ended ring has already begun its next episode. Avoids collecting
    /// the outcomes, which takes longer than a step of the rings.
    #[inline(always)]
    pub fn hold_each(&mut self, actions: &[Action; LANES], mut each: impl FnMut(&Self, usize, Outcome)) {
        let (steps, hold) = (self.hold_steps, self.hold_length());
        for (l, action) in actions.iter().enumerate() {
            let corrected_mps = self.corrected.as_ref().map(|lanes| lanes.advised_mps(l));
            let advice = residual(corrected_mps, *action);
            let time_s = f64::from(self.elapsed[l]) * hold.seconds();
            let probed = self.probe.map_or(advice, |probe| probe.added_to(advice, time_s, hold.seconds()));
            self.advise(l, Some(probed), hold);
        }
        let range_mps = self.config.range_mps() as f32;
        let fresh = MeanSpeed::share(self.config.ring.step_s) as f32;
        let totals = in_wide_vectors(AdvisedHold { block: self, steps, range_mps, fresh });
        let horizon = self.config.horizon_decisions(hold);
        for (l, action) in actions.iter().enumerate() {
            let outcome = self.settle(l, *action, horizon, &totals);
            each(self, l, outcome);
        }
    }

    /// Starts to keep samples of the drivers; see [`VecEnv::take_samples`].
    pub fn keep_samples(&mut self) {
        self.samples = Some(Vec::new());
    }

    /// Returns the samples of the drivers since the last call, one per [`SAMPLE_S`].
    pub fn take_samples(&mut self) -> Vec<BlockSample> {
        self.samples.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Returns the driver's traits on each ring.
    pub fn drivers(&self) -> [DriverTraits; LANES] {
        std::array::from_fn(|l| self.follower.traits(l))
    }

    /// Starts the observers of the drivers if these inputs need them.
    fn observe_drivers_for(&mut self, inputs: &[NetworkInput]) {
        if inputs.iter().any(|input| input.feature.is_observed()) {
            self.observers = Some(vec![DriverObserver::default(); LANES]);
            (0..LANES).for_each(|l| self.begin_observing(l));
        }
    }

    /// Starts the observer of ring `l`, if there is one, for a new driver.
    fn begin_observing(&mut self, l: usize) {
        let seen = self.traffic(l);
        if let Some(lanes) = &mut self.observers {
            lanes[l] = DriverObserver::default();
            lanes[l].watch(&seen, None, self.config.ring.step_s);
        }
    }

    /// Passes the step just driven to the observers of the drivers.
    fn watch_drivers(&mut self) {
        let Some(mut lanes) = self.observers.take() else { return };
        for (l, observer) in lanes.iter_mut().enumerate() {
            observer.watch(&self.traffic(l), self.follower.advised_mps(l), self.config.ring.step_s);
        }
        self.observers = Some(lanes);
    }

    /// Returns the driver of ring `l` as observed.
    fn observed(&self, l: usize) -> ObservedDriver {
        self.observers.as_ref().map_or(ObservedDriver::default(), |lanes| lanes[l].observed())
    }

    fn sample(&mut self) {
        self.unsampled_steps += 1;
        if self.unsampled_steps < (SAMPLE_S / self.config.ring.step_s).round().max(1.0) as u32 {
            return;
        }
        self.unsampled_steps = 0;
        let advised = lane(|l| self.follower.advised_mps(l).map_or(-1.0, |advised| advised as f32));
        let observed: [ObservedDriver; LANES] = std::array::from_fn(|l| self.observed(l));
        let reaction_s = lane(|l| observed[l].reaction_s as f32);
        let time_gap_factor = lane(|l| observed[l].time_gap_factor as f32);
        let now =
            [*self.ring.ego_mps(), *self.ring.leader_mps(), *self.ring.gap_m(), advised, reaction_s, time_gap_factor];
        if let Some(samples) = &mut self.samples {
            samples.push(now);
        }
    }

    /// Returns the outcome of a hold on ring `l`, whose episodes last `horizon` holds, and begins a new episode if this one ended.
    #[inline(always)]
    fn settle(&mut self, l: usize, action: Action, horizon: u32, totals: &Totals) -> Outcome {
        let share = 1.0 / self.hold_steps as f32;
        self.elapsed[l] += 1;
        self.ways.ego_way_m[l] += totals.ego_mps[l] * self.config.ring.step_s as f32;
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
        let uneven = self.config.reward.speed_sd_penalty as f32 * totals.speed_sd_mps[l] * share;
        let mut reward = speed - headway - missed - uneven - self.action_penalty(action);
        if ending == Ending::Crash {
            reward -= self.config.reward.collision_penalty as f32;
        }
        self.tell_corrected(l, CorrectedLanes::decide);
        let (last_seen, last_state) = (self.observe(l), self.whole_state(l));
        if ending != Ending::None {
            self.ended.keep(l, &self.ring, &self.ways);
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

    /// Begins another episode on ring `l`, discarding the current one.
    pub fn begin_episode(&mut self, l: usize) {
        if self.used == LANES {
            self.restock();
        }
        self.ring.copy_lane(l, &self.stock, self.used);
        self.follower.copy_lane(l, &self.stock_follower, self.used);
        self.ways.circumference_m[l] = self.stock_m[self.used];
        self.ways.ego_way_m[l] = 0.0;
        self.equilibrium_mps[l] = self.stock_equilibrium_mps[self.used];
        self.elapsed[l] = 0;
        self.mean_ego_mps[l] = self.ring.ego_mps()[l];
        self.begin_observing(l);
        self.tell_corrected(l, CorrectedLanes::engage);
        self.used += 1;
    }

    /// Draws sixteen rings and warms them up.
    fn restock(&mut self) {
        let drivers = self.config.ring.traffic_drivers().swap_remove(0);
        for l in 0..LANES {
            let number = (self.first_ring + l as u64) | (self.batches << 32);
            let mut stream = episode_stream(self.config.seed, &self.stream, number);
            let drawn = draw_ring(&self.config, &drivers, &mut stream);
            self.stock.set(l, &drawn.start);
            self.stock_m[l] = drawn.length_m as f32;
            let model = drawn.start.driver.model;
            self.stock_equilibrium_mps[l] = model.equilibrium_speed_mps(drawn.even_gap_m, f64::INFINITY) as f32;
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

/// One step of a block under the current advice.
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

/// Steps of a hold with their sums.
struct AdvisedHold<'a> {
    block: &'a mut VecEnv,
    steps: u32,
    range_mps: f32,
    /// Weight of one step in the mean of the ego's speed.
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
            if block.config.reward.speed_sd_penalty > 0.0 {
                let sd_mps = block.ring.speed_sd_mps();
                totals.speed_sd_mps.iter_mut().zip(&sd_mps).for_each(|(total, now)| *total += now);
            }
            for (mean, now) in block.mean_ego_mps.iter_mut().zip(&ego_mps) {
                *mean += (now - *mean) * fresh;
            }
            block.watch_drivers();
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
