//! The fast ring: [`LANES`] independent closed lanes of IDM vehicles in one SIMD block. In: a layout and a model for each ring, then the
//! speeds of advised vehicles at each step. Out: speeds, gaps and the mean speed. Metres, m/s, m/s².
//!
//! The update is the same as in `traffic::native` (docs/references.md: idm): all accelerations from one state, `v' = max(v + a dt, 0)`,
//! `x' = x + v' dt`, then noise. The state is the gap ahead of each vehicle instead of its position, so nothing wraps and `f32` keeps its
//! precision. Slot 0 is the ego and slot `k` the `k`-th vehicle **behind** it, so that rings with different numbers of vehicles share one
//! loop. Slots beyond a ring's last vehicle hold ghosts, which follow it and affect no vehicle.

use super::{
    ring_models::{Kinds, Model, accel},
    simd::{LANES, LaneRng, SimdLanes, VectorWork, in_wide_vectors, lane, splat},
};
use crate::{
    idm::IdmParams,
    space::CAR_LENGTH_M,
    traffic::{self, TrafficDriver},
};
use serde::{Deserialize, Serialize};

/// Bound of the native engine in single precision.
const CREEP_MPS2: f32 = traffic::CREEP_MPS2 as f32;
/// Initial gap ahead of each ghost, m.
const GHOST_GAP_M: f32 = 100.0;

/// Initial state of one ring.
#[derive(Clone, Debug, PartialEq)]
pub struct RingStart {
    /// Gap ahead of each vehicle, m: the ego first, then backwards from its follower.
    pub gaps_m: Vec<f32>,
    /// Driver of all vehicles.
    pub driver: TrafficDriver,
    /// Driver of each vehicle, the ego's first, then backwards; empty if all vehicles have `driver`.
    pub own_drivers: Vec<TrafficDriver>,
    /// Seed of the acceleration noise.
    pub seed: u64,
}

impl RingStart {
    /// Returns `cars` vehicles evenly spaced over `length_m`.
    pub fn even(cars: usize, length_m: f64, idm: IdmParams, seed: u64) -> Self {
        let gap_m = (length_m / cars as f64 - CAR_LENGTH_M) as f32;
        Self { gaps_m: vec![gap_m; cars], driver: TrafficDriver::of_ring_study(idm), own_drivers: Vec::new(), seed }
    }

    /// Returns `cars` vehicles close together with one hole halfway round from the ego, as in [`traffic::start::bunched`].
    pub fn bunched(cars: usize, length_m: f64, idm: IdmParams, seed: u64) -> Self {
        let spacing_m = traffic::start::bunch_spacing_m(cars, length_m, idm.s0).min(length_m / cars as f64);
        let mut gaps_m = vec![(spacing_m - CAR_LENGTH_M) as f32; cars];
        gaps_m[cars / 2] += (length_m - spacing_m * cars as f64) as f32;
        Self { gaps_m, driver: TrafficDriver::of_ring_study(idm), own_drivers: Vec::new(), seed }
    }
}

/// Speed that the vehicle of a slot has at the end of a step on each ring, in place of the speed by its model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImposedSpeed {
    /// Slot of the vehicle; on every ring the slot of a vehicle.
    pub slot: usize,
    /// Speed on each ring, m/s.
    pub mps: SimdLanes,
}

/// A block of rings; the head of the file explains the slots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VectorizedRing {
    step_s: f32,
    cars: [u32; LANES],
    gap_m: Vec<SimdLanes>,
    speed_mps: Vec<SimdLanes>,
    model: Model,
    kinds: Kinds,
    /// The driver of each slot, where drivers of a ring differ; otherwise empty.
    own_models: Vec<Model>,
    /// Change of speed by each slot's noise in the last step, m/s, where drivers differ; otherwise empty.
    change_mps: Vec<SimdLanes>,
    rng: LaneRng,
    /// Speed of the ego's leader, m/s.
    leader_mps: SimdLanes,
    mean_mps: SimdLanes,
    #[serde(skip, default)]
    noise: Vec<SimdLanes>,
}

impl VectorizedRing {
    /// Returns empty rings with room for `cars` vehicles each and steps of `step_s`; every lane must be set before the first step.
    pub fn new(cars: usize, step_s: f64) -> Self {
        Self {
            step_s: step_s as f32,
            cars: [0; LANES],
            gap_m: vec![splat(GHOST_GAP_M); cars + 1],
            speed_mps: vec![splat(0.0); cars],
            model: Model::new(),
            kinds: Kinds { are_fourth_powers: true, has_optimal: false },
            own_models: Vec::new(),
            change_mps: Vec::new(),
            rng: LaneRng::new(),
            leader_mps: splat(0.0),
            mean_mps: splat(0.0),
            noise: Vec::new(),
        }
    }

    /// Sets lane `l` to a ring at a standstill.
    ///
    /// # Panics
    /// Panics if the ring has more vehicles than the block has room for, or fewer than 2.
    pub fn set(&mut self, l: usize, start: &RingStart) {
        assert!((2..=self.speed_mps.len()).contains(&start.gaps_m.len()), "{} cars", start.gaps_m.len());
        self.cars[l] = start.gaps_m.len() as u32;
        for k in 0..self.gap_m.len() {
            self.gap_m[k][l] = start.gaps_m.get(k).copied().unwrap_or(GHOST_GAP_M);
        }
        self.speed_mps.iter_mut().for_each(|speed| speed[l] = 0.0);
        let step_s = f64::from(self.step_s);
        self.model.set(l, &start.driver, step_s);
        if !start.own_drivers.is_empty() {
            self.let_drivers_differ();
        }
        for (k, model) in self.own_models.iter_mut().enumerate() {
            model.set(l, start.own_drivers.get(k).unwrap_or(&start.driver), step_s);
        }
        self.change_mps.iter_mut().for_each(|change| change[l] = 0.0);
        self.note_kinds();
        self.rng.seed(l, start.seed);
        self.leader_mps[l] = 0.0;
        self.mean_mps[l] = 0.0;
    }

    /// Notes which kinds of models there are.
    fn note_kinds(&mut self) {
        let models = || self.own_models.iter().chain([&self.model]);
        self.kinds = Kinds {
            are_fourth_powers: models().all(|model| model.delta.iter().all(|delta| *delta == 4.0)),
            has_optimal: models().any(|model| model.optimal.is_model.contains(&1.0)),
        };
    }

    /// Gives each slot its own driver.
    fn let_drivers_differ(&mut self) {
        if self.own_models.is_empty() {
            self.own_models = vec![self.model.clone(); self.speed_mps.len()];
            self.change_mps = vec![splat(0.0); self.speed_mps.len()];
        }
    }

    /// Copies lane `from_lane` of a block of the same size into lane `l`.
    pub fn copy_lane(&mut self, l: usize, from: &Self, from_lane: usize) {
        let pairs = self.gap_m.iter_mut().zip(&from.gap_m).chain(self.speed_mps.iter_mut().zip(&from.speed_mps));
        pairs.for_each(|(to, from)| to[l] = from[from_lane]);
        self.cars[l] = from.cars[from_lane];
        self.model.copy_lane(l, &from.model, from_lane);
        if !from.own_models.is_empty() {
            self.let_drivers_differ();
        }
        for (k, model) in self.own_models.iter_mut().enumerate() {
            model.copy_lane(l, from.own_models.get(k).unwrap_or(&from.model), from_lane);
            self.change_mps[k][l] = from.change_mps.get(k).map_or(0.0, |change| change[from_lane]);
        }
        self.note_kinds();
        self.leader_mps[l] = from.leader_mps[from_lane];
        self.mean_mps[l] = from.mean_mps[from_lane];
        self.rng.copy_lane(l, &from.rng, from_lane);
    }

    /// Returns the number of vehicles on ring `l`.
    pub fn cars(&self, l: usize) -> usize {
        self.cars[l] as usize
    }

    /// Returns the ego's speed on each ring, m/s.
    #[inline(always)]
    pub fn ego_mps(&self) -> &SimdLanes {
        &self.speed_mps[0]
    }

    /// Returns the speed of the ego's leader on each ring, m/s.
    #[inline(always)]
    pub fn leader_mps(&self) -> &SimdLanes {
        &self.leader_mps
    }

    /// Returns the gap ahead of the ego on each ring, m.
    #[inline(always)]
    pub fn gap_m(&self) -> &SimdLanes {
        &self.gap_m[0]
    }

    /// Returns the gap ahead of the `k`-th vehicle behind the ego on each ring, m.
    #[inline(always)]
    pub fn gaps_m(&self, k: usize) -> &SimdLanes {
        &self.gap_m[k]
    }

    /// Returns the speed of the `k`-th vehicle behind the ego on each ring, m/s.
    #[inline(always)]
    pub fn speed_mps_of(&self, k: usize) -> &SimdLanes {
        &self.speed_mps[k]
    }

    /// Returns the speed of the leader of the `k`-th vehicle behind the ego on each ring, m/s.
    #[inline(always)]
    pub fn leader_mps_of(&self, k: usize) -> &SimdLanes {
        if k == 0 { &self.leader_mps } else { &self.speed_mps[k - 1] }
    }

    /// Returns the slot of the follower of slot `k`. The last slot is followed by the ego, on rings that fill all slots.
    #[inline(always)]
    pub fn follower_of(&self, k: usize) -> usize {
        if k + 1 < self.speed_mps.len() { k + 1 } else { 0 }
    }

    /// Returns the mean speed of all vehicles, the ego included, on each ring, m/s.
    #[inline(always)]
    pub fn mean_mps(&self) -> &SimdLanes {
        &self.mean_mps
    }

    /// Returns the standard deviation of speed over all vehicles on each ring, m/s.
    #[inline(always)]
    pub fn speed_sd_mps(&self) -> SimdLanes {
        let mut squares = splat(0.0);
        for (k, speed) in self.speed_mps.iter().enumerate() {
            for l in 0..LANES {
                let off = speed[l] - self.mean_mps[l];
                squares[l] += if (k as u32) < self.cars[l] { off * off } else { 0.0 };
            }
        }
        lane(|l| (squares[l] / self.cars[l] as f32).sqrt())
    }

    /// Returns the speeds of the vehicles on ring `l`, m/s, the ego first, then backwards.
    pub fn speeds_mps(&self, l: usize) -> impl Iterator<Item = f32> + Clone + '_ {
        self.speed_mps[..self.cars(l)].iter().map(move |speed| speed[l])
    }

    /// Returns the acceleration of the `k`-th vehicle behind the ego by the model of its ring, with the time gap, s, the gap and the
    /// leader's speed that its driver perceives, m/s².
    #[inline(always)]
    pub fn by_model(&self, k: usize, gap_m: &SimdLanes, leader_mps: &SimdLanes, time_gap_s: &SimdLanes) -> SimdLanes {
        self.accel(&self.model, &self.speed_mps[k], leader_mps, gap_m, time_gap_s)
    }

    /// Returns the acceleration by a model, m/s².
    #[inline(always)]
    fn accel(
        &self,
        m: &Model,
        mps: &SimdLanes,
        leader_mps: &SimdLanes,
        gap_m: &SimdLanes,
        time_gap_s: &SimdLanes,
    ) -> SimdLanes {
        let seen = |l: usize| [mps[l], leader_mps[l], gap_m[l], time_gap_s[l]];
        match (self.kinds.are_fourth_powers, self.kinds.has_optimal) {
            (true, false) => lane(|l| accel::<true, false>(m, l, seen(l))),
            (false, false) => lane(|l| accel::<false, false>(m, l, seen(l))),
            (true, true) => lane(|l| accel::<true, true>(m, l, seen(l))),
            (false, true) => lane(|l| accel::<false, true>(m, l, seen(l))),
        }
    }

    /// Returns the time gap of each ring's model, s.
    pub fn time_gap_s(&self) -> &SimdLanes {
        &self.model.time_gap_s
    }

    /// Runs `steps` steps in which the model drives every vehicle: the warm-up and the baseline without advice.
    pub fn run(&mut self, steps: usize) {
        in_wide_vectors(UndisturbedSteps { ring: self, steps });
    }

    /// Runs one step, at the end of which some vehicles have imposed speeds, by ascending slot; the model drives all others.
    #[inline(always)]
    pub fn step(&mut self, imposed: &[ImposedSpeed]) {
        match (self.kinds.are_fourth_powers, self.own_models.is_empty(), self.kinds.has_optimal) {
            (true, true, _) => self.step_with::<true, false, false>(imposed),
            (false, true, _) => self.step_with::<false, false, false>(imposed),
            (true, false, false) => self.step_with::<true, true, false>(imposed),
            (false, false, false) => self.step_with::<false, true, false>(imposed),
            (true, false, true) => self.step_with::<true, true, true>(imposed),
            (false, false, true) => self.step_with::<false, true, true>(imposed),
        }
    }

    #[inline(always)]
    fn step_with<const FOURTH: bool, const DRIVERS_DIFFER: bool, const OPTIMAL: bool>(
        &mut self,
        imposed: &[ImposedSpeed],
    ) {
        self.draw_noise();
        let mut imposed = imposed.iter().rev().peekable();
        let (dt, creep_mps) = (self.step_s, CREEP_MPS2 * self.step_s);
        let slots = self.speed_mps.len();
        let leader_mps = self.leader_mps;
        let (mut tail_chosen, mut tail_after) = (splat(0.0), splat(0.0));
        let (mut sum, mut behind_chosen) = (splat(0.0), splat(0.0));
        // From the last slot to the ego, so that the speed ahead is still that of the old state.
        for k in (0..slots).rev() {
            let mut ahead_mps = leader_mps;
            if k > 0 {
                ahead_mps = self.speed_mps[k - 1];
            }
            let given = imposed.next_if(|imposed| imposed.slot == k);
            let (speed, gap, noise) = (&mut self.speed_mps[k], &self.gap_m[k], &self.noise[k]);
            let model = if DRIVERS_DIFFER { &self.own_models[k] } else { &self.model };
            let mut chosen = splat(0.0);
            let mut change_mps = lane(|l| noise[l] * model.noise_mps[l]);
            if DRIVERS_DIFFER {
                let before_mps = &self.change_mps[k];
                change_mps = lane(|l| model.noise_keeps[l] * before_mps[l] + change_mps[l]);
                self.change_mps[k] = change_mps;
            }
            if let Some(given) = given {
                (chosen, *speed) = (given.mps, given.mps);
            } else {
                for l in 0..LANES {
                    let seen = [speed[l], ahead_mps[l], gap[l], model.time_gap_s[l]];
                    let wanted = speed[l] + accel::<FOURTH, OPTIMAL>(model, l, seen) * dt;
                    chosen[l] = if wanted < creep_mps { 0.0 } else { wanted };
                    let noisy = (chosen[l] + change_mps[l]).max(0.0);
                    speed[l] = if chosen[l] > 0.0 { noisy } else { 0.0 };
                }
            }
            for l in 0..LANES {
                let last = self.cars[l] == k as u32 + 1;
                tail_chosen[l] = if last { chosen[l] } else { tail_chosen[l] };
                tail_after[l] = if last { speed[l] } else { tail_after[l] };
                sum[l] += if (k as u32) < self.cars[l] { speed[l] } else { 0.0 };
            }
            // The gap behind this vehicle changes by the difference of the two displacements; slot `slots` belongs to no vehicle.
            let behind = &mut self.gap_m[k + 1];
            for l in 0..LANES {
                behind[l] += (chosen[l] - behind_chosen[l]) * dt;
            }
            behind_chosen = chosen;
        }
        for l in 0..LANES {
            self.gap_m[0][l] += (tail_chosen[l] - behind_chosen[l]) * dt;
            self.mean_mps[l] = sum[l] / self.cars[l] as f32;
        }
        self.leader_mps = tail_after;
    }

    #[inline(always)]
    fn draw_noise(&mut self) {
        let slots = self.speed_mps.len();
        if self.noise.len() < slots {
            self.noise.resize(slots + 1, splat(0.0));
        }
        for pair in self.noise[..slots.next_multiple_of(2)].chunks_exact_mut(2) {
            (pair[0], pair[1]) = self.rng.normal_pair();
        }
    }
}

/// Steps in which the model drives every vehicle.
struct UndisturbedSteps<'a> {
    ring: &'a mut VectorizedRing,
    steps: usize,
}

impl VectorWork for UndisturbedSteps<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for _ in 0..self.steps {
            self.ring.step(&[]);
        }
    }
}
