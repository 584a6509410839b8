//! How the ego follows the advice in training: to the letter, or as a person would. In: an action for each ring, then
//! once a step the rings. Out: the ego's speed at the end of the step, m/s.
//!
//! A simulated driver responds `reaction_s` late, tracks with an error that wanders (Ornstein and Uhlenbeck 1930) and has
//! a habit of driving faster or slower; what it follows is the speed on the dial (docs/decisions.md: 2), also where the
//! policy puts out an acceleration. It keeps the model's distance to its leader; an ego that follows to the letter
//! brakes, if it is set so, where it must to avoid a collision. Who drives is said by the [`DriverParams`] of whole
//! drives.

use super::{
    config::{DriverConfig, FollowKind, TrainConfig},
    late_view::LateView,
    ring::VectorizedRing,
    simd::{LANES, LaneRng, SimdLanes, lane, splat},
};
use crate::{
    driver::{Compliance, DriverParams, HELD_BACK_S, LONGEST_REACTION_S, LeaderRule, NamedDriver, Population, named},
    metrics::DrivenBy,
    policy::{Action, DriverTraits, Hold, shown_mps},
    rng::Stream,
};
use serde::{Deserialize, Serialize};

/// Time in which a driver closes the difference to the target, seconds (`driver`'s presets).
const SPEED_RELAXATION_S: f32 = 1.5;

/// Gap that an ego guarded against collisions keeps when it stops, metres.
const SAFE_GAP_M: f32 = 1.0;

/// What stands for a ring.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum StandingAdvice {
    /// The ego's model drives.
    Model,
    /// Nothing is advised any more, which a driver notices as late as an advice.
    Silence,
    /// An acceleration, m/s2.
    Acceleration,
    /// A speed, m/s.
    Speed,
}

/// The egos' followers of advice, one a lane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdviceFollower {
    step_s: f32,
    is_driver: bool,
    ignores: bool,
    brakes: bool,
    accel_mps2: f32,
    decel_mps2: f32,
    guard_mps2: f32,
    response_s: f32,
    mode: [StandingAdvice; LANES],
    /// What is advised, m/s2 or m/s.
    advised: SimdLanes,
    /// Advised speeds of the last steps, newest at `newest`; -1 where there was none.
    shown_mps: Vec<SimdLanes>,
    newest: usize,
    delay: [u32; LANES],
    habit_mps: SimdLanes,
    error_mps: SimdLanes,
    deadband_mps: SimdLanes,
    /// What is kept of the error in a step, and what is new.
    keep: f32,
    fresh_mps: SimdLanes,
    rng: LaneRng,
    view: LateView,
    /// Time gap to the leader as a multiple of the ring's.
    gap_factor: SimdLanes,
    compliance: [Compliance; LANES],
    all_comply: bool,
    /// Steps since the first advice.
    advised_steps: [u32; LANES],
    held_back_mps: SimdLanes,
    follows: [bool; LANES],
    looks: [bool; LANES],
    /// The advice that is in mind, m/s: what the dial showed when it was last looked at.
    in_mind_mps: SimdLanes,
    driven_by: [DrivenBy; LANES],
    /// Who drives; whether he is willing now is asked of `compliance`.
    traits: [DriverTraits; LANES],
}

impl TrainConfig {
    /// The same rings with this driver in each. How hard the ego can accelerate and brake stays the configuration's.
    pub fn driven_by(&self, driver: &DriverParams) -> Self {
        let brakes_for_leader = driver.leader_rule == LeaderRule::Guard;
        let follow = match driver.leader_rule {
            _ if !driver.follows_advice => FollowKind::Ignore,
            LeaderRule::Model => FollowKind::Driver,
            LeaderRule::Guard | LeaderRule::Ignore => FollowKind::Exact,
        };
        let driver = DriverConfig {
            follow,
            brakes_for_leader,
            random_driver: false,
            population: Population::None,
            reaction_s: driver.reaction_s,
            leader_reaction_s: driver.leader_reaction_s,
            error_mps: driver.error_mps,
            error_time_s: driver.error_time_s,
            speed_bias_mps: driver.speed_bias_mps,
            deadband_mps: driver.deadband_mps,
            compliance: driver.compliance,
            compliance_fade_s: driver.compliance_fade_s,
            patience_mps: driver.patience_mps,
            inattention_per_min: driver.inattention_per_min,
            inattention_s: driver.inattention_s,
            ..self.driver.clone()
        };
        Self { driver, ..self.clone() }
    }

    /// The same rings, each with a driver drawn from this population.
    pub fn driven_by_some_of(&self, population: Population) -> Self {
        let driver = DriverConfig { follow: FollowKind::Driver, population, ..self.driver.clone() };
        Self { driver, ..self.clone() }
    }

    /// The driver of these rings by name, where they all have the same.
    pub fn named_driver(&self) -> Option<NamedDriver> {
        let driver = &self.driver;
        match driver.follow {
            FollowKind::Ignore => named("idm").ok(),
            FollowKind::Exact if driver.brakes_for_leader => named("guarded").ok(),
            FollowKind::Exact => named("exact").ok(),
            FollowKind::Driver if driver.random_driver || driver.population != Population::None => None,
            FollowKind::Driver => NamedDriver::of_numbers([
                driver.reaction_s,
                driver.error_mps,
                driver.speed_bias_mps,
                driver.deadband_mps,
            ])
            .ok(),
        }
    }

    /// The driver of one episode.
    pub fn draw_driver(&self, stream: &mut Stream) -> DriverParams {
        let driver = &self.driver;
        let set = DriverParams {
            reaction_s: driver.reaction_s,
            leader_reaction_s: driver.leader_reaction_s,
            error_mps: driver.error_mps,
            error_time_s: driver.error_time_s,
            speed_bias_mps: driver.speed_bias_mps,
            deadband_mps: driver.deadband_mps,
            compliance: driver.compliance,
            compliance_fade_s: driver.compliance_fade_s,
            patience_mps: driver.patience_mps,
            inattention_per_min: driver.inattention_per_min,
            inattention_s: driver.inattention_s,
            idm: self.ring.idm,
            ..DriverParams::default()
        };
        if driver.population != Population::None {
            return driver.population.draw(&set, stream);
        }
        let mut share = |low: f64| if driver.random_driver { stream.uniform(low, 1.0) } else { 1.0 };
        let late = share(0.0);
        DriverParams {
            reaction_s: set.reaction_s * late,
            leader_reaction_s: set.leader_reaction_s * late,
            error_mps: set.error_mps * share(0.0),
            speed_bias_mps: set.speed_bias_mps * share(-1.0),
            ..set
        }
    }
}

impl AdviceFollower {
    /// Followers without habits; [`AdviceFollower::draw`] gives them some.
    pub fn new(config: &TrainConfig) -> Self {
        let driver = &config.driver;
        let longest_s = match driver.population {
            Population::None => driver.reaction_s.max(driver.leader_reaction_s),
            Population::People | Population::Perp | Population::Anyone => LONGEST_REACTION_S,
        };
        let longest = (longest_s / config.ring.step_s).round() as usize;
        Self {
            step_s: config.ring.step_s as f32,
            is_driver: driver.follow == FollowKind::Driver,
            ignores: driver.follow == FollowKind::Ignore,
            brakes: driver.brakes_for_leader,
            accel_mps2: driver.ego_accel_mps2 as f32,
            decel_mps2: driver.ego_decel_mps2 as f32,
            guard_mps2: driver.guard_decel_mps2 as f32,
            response_s: driver.ego_response_s.max(config.ring.step_s) as f32,
            mode: [StandingAdvice::Model; LANES],
            advised: splat(0.0),
            shown_mps: vec![splat(-1.0); longest + 1],
            newest: 0,
            delay: [0; LANES],
            habit_mps: splat(0.0),
            error_mps: splat(0.0),
            deadband_mps: splat(driver.deadband_mps as f32),
            keep: (-config.ring.step_s / driver.error_time_s).exp() as f32,
            fresh_mps: splat(0.0),
            rng: LaneRng::new(),
            view: LateView::new(longest_s, config.ring.step_s),
            gap_factor: splat(1.0),
            compliance: [Compliance::full(); LANES],
            all_comply: true,
            advised_steps: [0; LANES],
            held_back_mps: splat(0.0),
            follows: [true; LANES],
            looks: [true; LANES],
            in_mind_mps: splat(-1.0),
            driven_by: [DrivenBy::Model; LANES],
            traits: [DriverTraits::default(); LANES],
        }
    }

    /// A new driver in lane `l`.
    pub fn draw(&mut self, l: usize, config: &TrainConfig, stream: &mut Stream) {
        let driver = config.draw_driver(stream);
        self.mode[l] = StandingAdvice::Model;
        self.shown_mps.iter_mut().for_each(|shown| shown[l] = -1.0);
        self.delay[l] = (driver.reaction_s / config.ring.step_s).round() as u32;
        self.habit_mps[l] = driver.speed_bias_mps as f32;
        self.error_mps[l] = (driver.error_mps * stream.normal()) as f32;
        self.deadband_mps[l] = driver.deadband_mps as f32;
        let keep = f64::from(self.keep);
        self.fresh_mps[l] = (driver.error_mps * (1.0 - keep * keep).sqrt()) as f32;
        let seed = (stream.uniform(0.0, 1.0) * 9.0e15) as u64;
        self.rng.seed(l, seed);
        // Only a driver sees late; a machine follows to the letter.
        self.view.set(l, if self.is_driver { driver.leader_reaction_s } else { 0.0 });
        self.gap_factor[l] = (driver.idm.t / config.ring.idm.t) as f32;
        self.compliance[l] = if self.is_driver { Compliance::of(&driver, seed) } else { Compliance::full() };
        self.traits[l] = if self.is_driver { driver.traits(config.ring.idm.t) } else { DriverTraits::default() };
        self.sit_down(l);
    }

    /// Who drives ring `l`, and how willing he is now: what only a teacher knows.
    pub fn traits(&self, l: usize) -> DriverTraits {
        let time_s = f64::from(self.advised_steps[l]) * f64::from(self.step_s);
        let willingness = self.compliance[l].willingness(time_s, f64::from(self.held_back_mps[l]));
        DriverTraits { willingness, ..self.traits[l] }
    }

    /// Nothing has been advised to the driver of lane `l` yet.
    fn sit_down(&mut self, l: usize) {
        self.advised_steps[l] = 0;
        self.held_back_mps[l] = 0.0;
        (self.follows[l], self.looks[l]) = (true, true);
        self.in_mind_mps[l] = -1.0;
        self.driven_by[l] = DrivenBy::Model;
        self.all_comply = self.compliance.iter().all(Compliance::is_full);
    }

    /// Copies a driver from another block's lane.
    pub fn copy_lane(&mut self, l: usize, from: &Self, from_lane: usize) {
        self.mode[l] = from.mode[from_lane];
        self.advised[l] = from.advised[from_lane];
        // A fresh driver has seen nothing yet, so that the place in the ring buffer does not matter.
        self.shown_mps.iter_mut().for_each(|shown| shown[l] = -1.0);
        self.delay[l] = from.delay[from_lane];
        self.habit_mps[l] = from.habit_mps[from_lane];
        self.error_mps[l] = from.error_mps[from_lane];
        self.deadband_mps[l] = from.deadband_mps[from_lane];
        self.fresh_mps[l] = from.fresh_mps[from_lane];
        self.rng.copy_lane(l, &from.rng, from_lane);
        self.view.copy_lane(l, &from.view, from_lane);
        self.gap_factor[l] = from.gap_factor[from_lane];
        self.compliance[l] = from.compliance[from_lane];
        self.traits[l] = from.traits[from_lane];
        self.sit_down(l);
    }

    /// New advice for ring `l`, whose ego drives at `ego_mps`, to stand for `hold`; `None` advises nothing.
    pub fn advise(&mut self, l: usize, action: Option<Action>, ego_mps: f32, hold: Hold) {
        if self.ignores {
            return;
        }
        let Some(action) = action else {
            let has_been_advised = self.is_driver && self.mode[l] != StandingAdvice::Model;
            self.mode[l] = if has_been_advised { StandingAdvice::Silence } else { StandingAdvice::Model };
            return;
        };
        let before = (self.mode[l] == StandingAdvice::Speed).then(|| f64::from(self.advised[l]));
        (self.mode[l], self.advised[l]) = match action {
            Action::Speed(speed) => (StandingAdvice::Speed, speed.max(0.0) as f32),
            // What a driver sees is the speed that it leads to.
            Action::Acceleration(a) if self.is_driver => {
                (StandingAdvice::Speed, shown_mps(before, f64::from(ego_mps), a, hold.seconds()) as f32)
            }
            Action::Acceleration(a) => (StandingAdvice::Acceleration, a as f32),
        };
    }

    /// The speed that is advised to the driver of lane `l`, m/s.
    pub fn advised_mps(&self, l: usize) -> Option<f64> {
        (self.mode[l] == StandingAdvice::Speed).then(|| f64::from(self.advised[l]))
    }

    /// By how much speeds lie outside of the range around the advised ones, m/s; 0 where an acceleration is followed to
    /// the letter.
    #[inline(always)]
    pub fn missed_mps(&self, ego_mps: &SimdLanes, range_mps: f32) -> SimdLanes {
        lane(|l| {
            let missed = ((ego_mps[l] - self.advised[l]).abs() - range_mps).max(0.0);
            if self.mode[l] == StandingAdvice::Speed { missed } else { 0.0 }
        })
    }

    /// What drove each ego in the last step.
    pub fn driven_by(&self) -> &[DrivenBy; LANES] {
        &self.driven_by
    }

    /// The egos' speeds at the end of this step, m/s.
    #[inline(always)]
    pub fn step(&mut self, ring: &VectorizedRing) -> SimdLanes {
        let speed = ring.ego_mps();
        let model = self.own_model(ring);
        if !self.all_comply {
            self.decide(ring.leader_mps());
        }
        let wanted = if self.is_driver { self.driver(speed) } else { self.exact(speed) };
        let dt = self.step_s;
        let mut driven = splat(0.0);
        let mut driven_by = [DrivenBy::Advice; LANES];
        for l in 0..LANES {
            let has_nothing_in_mind = self.is_driver && wanted[l] == f32::INFINITY;
            let is_free = self.mode[l] == StandingAdvice::Model || has_nothing_in_mind || !self.follows[l];
            let keeps_distance = self.is_driver && model[l] < wanted[l];
            let by_model = is_free || keeps_distance;
            driven[l] = (speed[l] + if by_model { model[l] } else { wanted[l] } * dt).max(0.0);
            let by_distance = if keeps_distance { DrivenBy::Distance } else { DrivenBy::Advice };
            driven_by[l] = if is_free { DrivenBy::Model } else { by_distance };
        }
        if self.brakes {
            for l in 0..LANES {
                let hardest = (speed[l] - self.guard_mps2 * dt).max(0.0);
                let safe = self.safe_mps(ring.gap_m()[l], ring.leader_mps()[l]).max(hardest);
                if driven_by[l] == DrivenBy::Advice && safe < driven[l] {
                    (driven[l], driven_by[l]) = (safe, DrivenBy::Guard);
                }
            }
        }
        self.driven_by = driven_by;
        self.view.drive(&driven);
        driven
    }

    /// What each driver's own model would do, by what he sees, m/s2.
    #[inline(always)]
    fn own_model(&mut self, ring: &VectorizedRing) -> SimdLanes {
        if self.view.is_prompt() && self.gap_factor == splat(1.0) {
            return ring.ego_idm();
        }
        let [gap_m, leader_mps] = self.view.see(ring.gap_m(), ring.leader_mps());
        let time_gap_s = lane(|l| ring.time_gap_s()[l] * self.gap_factor[l]);
        ring.ego_idm_seen(&gap_m, &leader_mps, &time_gap_s)
    }

    /// Who looks and who follows, once a second; and how far the advice holds each back.
    fn decide(&mut self, leader_mps: &SimdLanes) {
        let steps_per_s = (1.0 / self.step_s).round().max(1.0) as u32;
        let fresh = self.step_s / HELD_BACK_S as f32;
        for (l, leader_mps) in leader_mps.iter().enumerate() {
            if self.mode[l] != StandingAdvice::Speed {
                continue;
            }
            if self.advised_steps[l].is_multiple_of(steps_per_s) {
                let time_s = f64::from(self.advised_steps[l]) * f64::from(self.step_s);
                self.follows[l] = self.compliance[l].follows(time_s, f64::from(self.held_back_mps[l]));
                self.looks[l] = self.compliance[l].looks(time_s);
            }
            let behind_mps = leader_mps - self.advised[l];
            self.held_back_mps[l] += (behind_mps - self.held_back_mps[l]) * fresh;
            self.advised_steps[l] += 1;
        }
    }

    /// The highest speed from which the ego can still stop behind its leader if that brakes as hard as the ego can (the
    /// safe speed of Krauss 1998 with one step of delay; SUMO, and with it Flow, guards its cars alike). Unlike the
    /// model's own distance it binds only where it must.
    #[inline(always)]
    fn safe_mps(&self, gap_m: f32, leader_mps: f32) -> f32 {
        let (b, delay_mps) = (self.decel_mps2, self.decel_mps2 * self.step_s);
        let room_m = (gap_m - SAFE_GAP_M).max(0.0);
        (delay_mps * delay_mps + leader_mps * leader_mps + 2.0 * b * room_m).sqrt() - delay_mps
    }

    #[inline(always)]
    fn exact(&self, speed: &SimdLanes) -> SimdLanes {
        lane(|l| {
            let reach = ((self.advised[l] - speed[l]) / self.response_s).max(-self.decel_mps2).min(self.accel_mps2);
            if self.mode[l] == StandingAdvice::Speed { reach } else { self.advised[l] }
        })
    }

    #[inline(always)]
    fn driver(&mut self, speed: &SimdLanes) -> SimdLanes {
        let size = self.shown_mps.len();
        self.newest = if self.newest + 1 == size { 0 } else { self.newest + 1 };
        for l in 0..LANES {
            let is_advised = self.mode[l] == StandingAdvice::Speed;
            if is_advised && (self.looks[l] || self.in_mind_mps[l] < 0.0) {
                self.in_mind_mps[l] = self.advised[l];
            }
            self.shown_mps[self.newest][l] = if is_advised { self.in_mind_mps[l] } else { -1.0 };
        }
        let (fresh, _) = self.rng.normal_pair();
        self.error_mps = lane(|l| self.error_mps[l] * self.keep + self.fresh_mps[l] * fresh[l]);
        let seen_mps = lane(|l| {
            let at = self.newest + size - self.delay[l] as usize;
            self.shown_mps[if at >= size { at - size } else { at }][l]
        });
        lane(|l| {
            let seen = seen_mps[l];
            // Until an advice is perceived, and once silence is, the ego is driven by its model alone.
            if seen < 0.0 {
                return f32::INFINITY;
            }
            // Bias and error fade below 1 m/s: nobody errs about a standstill.
            let target = seen + (self.habit_mps[l] + self.error_mps[l]) * seen.min(1.0);
            let off = target.max(0.0) - speed[l];
            let felt = off - off.max(-self.deadband_mps[l]).min(self.deadband_mps[l]);
            (felt / SPEED_RELAXATION_S).max(-self.decel_mps2).min(self.accel_mps2)
        })
    }
}
