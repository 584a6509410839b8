//! The ring as a reinforcement-learning environment. In: an [`Action`] per advised vehicle and hold. Out: the next observation, the reward
//! of the hold and its ending. One [`VecEnv`] is a block of [`LANES`] rings. Blocks are independent, so the number of threads changes no bit.
//!
//! Each advised vehicle of each ring is a row, ring after ring, the ego first; with one advised vehicle the row is the number of the ring.
//!
//! An episode is a ring drawn from the configuration, warmed up by the model alone, then driven for the horizon. A ring whose episode
//! ends is replaced by a warmed-up one from the block's stock, which is made sixteen at a time.

mod hold;

use super::{
    advised_vehicle::AdvisedVehicle,
    config::TrainConfig,
    corrected::CorrectedLanes,
    drawn_ring::{draw_ring, episode_stream},
    identification::BlockSample,
    outcome::WholeState,
    ring::{ImposedSpeed, VectorizedRing},
    ring_vehicles::{self, EndedRings, RingVehicle, RingWays},
    simd::{LANES, SimdLanes, VectorWork, in_wide_vectors, lane, splat},
};
use crate::{
    metrics::DrivenBy,
    policy::{
        Action, CorrectedAdvice, DriverTraits, Hold, NetworkInput, Observation, ObservedDriver, Probe,
        identification::SAMPLE_S,
    },
    rng::{self, Stream},
};
use serde::{Deserialize, Serialize};

/// A block of sixteen rings and their advised vehicles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct VecEnv {
    config: TrainConfig,
    /// Index of the block's first ring among all rings.
    first_ring: u64,
    stream: String,
    ring: VectorizedRing,
    /// Advised vehicles by ascending slot, the ego first.
    advised: Vec<AdvisedVehicle>,
    /// Speeds of the advised vehicles at the end of a step.
    driven: Vec<ImposedSpeed>,
    ways: RingWays,
    /// Rings at the end of their last episodes.
    ended: EndedRings,
    /// Speed at which each ring flows evenly, m/s.
    equilibrium_mps: SimdLanes,
    hold_steps: u32,
    elapsed: [u32; LANES],
    /// Warmed-up rings in stock; `stock_m` are their lengths and `used` counts those taken.
    stock: VectorizedRing,
    stock_m: SimdLanes,
    stock_equilibrium_mps: SimdLanes,
    used: usize,
    batches: u64,
    /// Samples of the egos' drivers, if kept; `unsampled_steps` counts steps since the last sample.
    samples: Option<Vec<BlockSample>>,
    unsampled_steps: u32,
    rings: usize,
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
        let advised: Vec<_> = config.ring.advised_slots().map(|slot| AdvisedVehicle::new(slot, config)).collect();
        let mut block = Self {
            config: config.clone(),
            first_ring: (index * LANES) as u64,
            stream: stream.to_owned(),
            stock: ring.clone(),
            ended: EndedRings::new(ring.clone()),
            ring,
            driven: advised.iter().map(|vehicle| ImposedSpeed { slot: vehicle.slot, mps: splat(0.0) }).collect(),
            advised,
            ways: RingWays::default(),
            equilibrium_mps: splat(0.0),
            hold_steps: hold.steps(),
            elapsed: [0; LANES],
            stock_m: splat(0.0),
            stock_equilibrium_mps: splat(0.0),
            used: LANES,
            batches: 0,
            samples: None,
            unsampled_steps: 0,
            rings: LANES,
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

    /// Returns the number of rows: the rings of the block times the advised vehicles of each.
    pub fn rows(&self) -> usize {
        LANES * self.advised()
    }

    /// Returns the row of an advised vehicle of ring `l`.
    fn row(&self, l: usize, number: usize) -> usize {
        l * self.advised() + number
    }

    /// Returns the ring of a row, and the number of its advised vehicle.
    fn place(&self, row: usize) -> (usize, usize) {
        (row / self.advised(), row % self.advised())
    }

    /// Returns the complete observation of a row, the driver's traits included.
    #[inline(always)]
    pub fn observe(&self, row: usize) -> Observation {
        let (l, number) = self.place(row);
        self.observe_from(l, number)
    }

    #[inline(always)]
    fn observe_from(&self, l: usize, number: usize) -> Observation {
        let vehicle = &self.advised[number];
        let (driver, corrected_mps) = (Some(vehicle.follower.traits(l)), vehicle.corrected_mps(l));
        let ring = self.is_whole_shown.then(|| vehicle.whole_ring(&self.ring, l));
        Observation { driver, corrected_mps, ring, ..self.traffic(l, number) }
    }

    /// Returns the part of the observation that describes traffic.
    #[inline(always)]
    fn traffic(&self, l: usize, number: usize) -> Observation {
        Observation {
            circumference_m: f64::from(self.ways.circumference_m[l]),
            vehicles: self.ring.cars(l) as u32,
            hold_s: self.hold_length().seconds(),
            ..self.advised[number].traffic(&self.ring, l)
        }
    }

    /// Sets the advice that actions correct from now on.
    pub fn correct(&mut self, advice: &CorrectedAdvice) {
        self.advised.iter_mut().for_each(|vehicle| vehicle.correct(advice, self.config.ring.step_s));
        if let CorrectedAdvice::Network(network) = advice {
            self.observe_drivers_for(&network.inputs);
        }
        (0..LANES).for_each(|l| self.tell_corrected(l, CorrectedLanes::engage));
    }

    /// Passes the current observations of ring `l` to the corrected advice.
    fn tell_corrected(&mut self, l: usize, tell: fn(&mut CorrectedLanes, usize, &Observation)) {
        for number in 0..self.advised() {
            if self.advised[number].is_corrected() {
                let seen = self.traffic(l, number);
                self.advised[number].tell_corrected(l, &seen, tell);
            }
        }
    }

    /// Returns the state that the value network sees and the policy does not: speeds of all vehicles, equilibrium speed and the driver's
    /// traits (an asymmetric critic, Pinto 2018). All zeros unless `value_sees_all` is set.
    pub fn whole_state(&self, row: usize) -> WholeState {
        if !self.config.optimiser.value_sees_all {
            return WholeState::default();
        }
        let (l, number) = self.place(row);
        let count = self.ring.cars(l) as f32;
        let mean = self.ring.speeds_mps(l).sum::<f32>() / count;
        let variance = self.ring.speeds_mps(l).map(|v| (v - mean) * (v - mean)).sum::<f32>() / count;
        let least = self.ring.speeds_mps(l).fold(f32::MAX, f32::min);
        let even = self.equilibrium_mps[l];
        let [reaction, bias, error, time_gap, willingness] =
            self.advised[number].follower.traits(l).numbers().map(|x| x as f32);
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

    /// Returns the sources of the egos' speeds in the last step.
    pub fn driven_by(&self) -> &[DrivenBy; LANES] {
        self.advised[0].follower.driven_by()
    }

    /// Returns the number of advised vehicles of each ring.
    pub fn advised(&self) -> usize {
        self.advised.len()
    }

    /// Returns the slots of the advised vehicles, the ego's first.
    pub fn advised_slots(&self) -> impl Iterator<Item = usize> + '_ {
        self.advised.iter().map(|vehicle| vehicle.slot)
    }

    /// Returns the speed, m/s, of the vehicle of a row, and the gaps before and behind it, m.
    pub(super) fn speed_and_gaps(&self, row: usize) -> [f32; 3] {
        let (l, number) = self.place(row);
        let slot = self.advised[number].slot;
        let gap_m = |slot: usize| self.ring.gaps_m(slot)[l];
        [self.ring.speed_mps_of(slot)[l], gap_m(slot), gap_m(self.ring.follower_of(slot))]
    }

    /// Returns the smallest gap before or behind an advised vehicle of ring `l`, m.
    pub(super) fn least_gap_m(&self, l: usize) -> f32 {
        let gaps_m = (0..self.advised()).map(|number| self.speed_and_gaps(self.row(l, number)));
        gaps_m.fold(f32::MAX, |least_m, [_, gap_m, behind_m]| least_m.min(gap_m).min(behind_m))
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

    /// Issues advice to the vehicle of a row for `hold`; `action` is the advice itself, not a correction. Before the first advice, and with
    /// `None`, the car-following model drives the vehicle.
    pub fn advise(&mut self, row: usize, action: Option<Action>, hold: Hold) {
        let (l, number) = self.place(row);
        let vehicle = &mut self.advised[number];
        vehicle.follower.advise(l, action, self.ring.speed_mps_of(vehicle.slot)[l], hold);
    }

    /// Runs one step under the current advice; no episode ends.
    pub fn step(&mut self) {
        in_wide_vectors(AdvisedStep(self));
    }

    /// Starts to keep samples of the drivers; see [`VecEnv::take_samples`].
    pub fn keep_samples(&mut self) {
        self.samples = Some(Vec::new());
    }

    /// Returns the samples of the drivers since the last call, one per [`SAMPLE_S`].
    pub fn take_samples(&mut self) -> Vec<BlockSample> {
        self.samples.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Returns the traits of the ego's driver on each ring.
    pub fn drivers(&self) -> [DriverTraits; LANES] {
        std::array::from_fn(|l| self.advised[0].follower.traits(l))
    }

    /// Starts the observers of the drivers if these inputs need them.
    fn observe_drivers_for(&mut self, inputs: &[NetworkInput]) {
        if inputs.iter().any(|input| input.feature.is_observed()) {
            self.advised.iter_mut().for_each(AdvisedVehicle::observe_drivers);
            (0..LANES).for_each(|l| self.begin_observing(l));
        }
    }

    /// Starts the observers of ring `l`, if there are any, for new drivers.
    fn begin_observing(&mut self, l: usize) {
        for number in 0..self.advised() {
            if self.advised[number].is_observed() {
                let seen = self.traffic(l, number);
                self.advised[number].begin_observing(l, &seen, self.config.ring.step_s);
            }
        }
    }

    /// Passes the step just driven to the observers of the drivers.
    fn watch_drivers(&mut self) {
        for number in 0..self.advised() {
            if self.advised[number].is_observed() {
                for l in 0..LANES {
                    let seen = self.traffic(l, number);
                    self.advised[number].watch_driver(l, &seen, self.config.ring.step_s);
                }
            }
        }
    }

    fn sample(&mut self) {
        self.unsampled_steps += 1;
        if self.unsampled_steps < (SAMPLE_S / self.config.ring.step_s).round().max(1.0) as u32 {
            return;
        }
        self.unsampled_steps = 0;
        let ego = &self.advised[0];
        let advised = lane(|l| ego.follower.advised_mps(l).map_or(-1.0, |advised| advised as f32));
        let observed: [ObservedDriver; LANES] = std::array::from_fn(|l| ego.observed(l));
        let reaction_s = lane(|l| observed[l].reaction_s as f32);
        let time_gap_factor = lane(|l| observed[l].time_gap_factor as f32);
        let now =
            [*self.ring.ego_mps(), *self.ring.leader_mps(), *self.ring.gap_m(), advised, reaction_s, time_gap_factor];
        if let Some(samples) = &mut self.samples {
            samples.push(now);
        }
    }

    /// Begins another episode on ring `l`, discarding the current one.
    pub fn begin_episode(&mut self, l: usize) {
        if self.used == LANES {
            self.restock();
        }
        self.ring.copy_lane(l, &self.stock, self.used);
        self.advised.iter_mut().for_each(|vehicle| vehicle.begin(l, self.used, &self.ring));
        self.ways.circumference_m[l] = self.stock_m[self.used];
        self.ways.ego_way_m[l] = 0.0;
        self.equilibrium_mps[l] = self.stock_equilibrium_mps[self.used];
        self.elapsed[l] = 0;
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
            self.advised.iter_mut().for_each(|vehicle| vehicle.draw(l, &self.config, &mut stream));
        }
        let steps = (self.config.ring.warm_up_s / self.config.ring.step_s).round() as usize;
        self.stock.run(steps);
        self.used = 0;
        self.batches += 1;
    }

    /// Drives all rings one step under the current advice.
    #[inline(always)]
    fn drive(&mut self) {
        for (vehicle, driven) in self.advised.iter_mut().zip(&mut self.driven) {
            driven.mps = vehicle.follower.step(&self.ring, vehicle.slot);
        }
        self.ring.step(&self.driven);
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
        self.0.drive();
    }
}
