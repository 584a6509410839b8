//! An advised vehicle's response to advice in training: exact, or like a person's. In: an action for each ring, then the rings at each
//! step. Out: the vehicle's speed at the end of the step, m/s.
//!
//! A simulated driver responds `reaction_s` late, tracks with a wandering error (Ornstein and Uhlenbeck 1930) and has a habit of driving
//! faster or slower. They follow the speed on the speedometer (docs/decisions.md: 2), also if the policy advises an acceleration, and
//! keep the model's distance to their leader. An exactly following ego can be set to brake only where a collision must be avoided. The
//! driver is described by the [`DriverParams`] of whole drives.

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

/// Time constant with which a driver closes the difference to the target, s (`driver`'s presets).
const SPEED_RELAXATION_S: f32 = 1.5;

/// Gap that a guarded ego keeps when it stops, m.
const SAFE_GAP_M: f32 = 1.0;

/// Current advice of a ring.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum StandingAdvice {
    /// No advice yet: the ego's model drives.
    Model,
    /// Withdrawn advice, which a driver notices as late as a new one.
    Silence,
    /// Advised acceleration, m/s².
    Acceleration,
    /// Advised speed, m/s.
    Speed,
}

/// Declares a struct of one lane's quantities, and one that holds each quantity of all lanes in an array, as vector instructions need it.
macro_rules! by_lane {
    ($(#[$of_one:meta])* $one:ident, $(#[$of_all:meta])* $all:ident { $($(#[$doc:meta])* $field:ident: $kind:ty,)* }) => {
        $(#[$of_one])*
        #[derive(Clone, Copy, Debug)]
        struct $one { $($(#[$doc])* $field: $kind,)* }

        $(#[$of_all])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        struct $all { $($field: [$kind; LANES],)* }

        impl $all {
            fn all(one: $one) -> Self {
                Self { $($field: [one.$field; LANES],)* }
            }

            fn get(&self, l: usize) -> $one {
                $one { $($field: self.$field[l],)* }
            }

            fn set(&mut self, l: usize, one: $one) {
                $(self.$field[l] = one.$field;)*
            }
        }
    };
}

by_lane! {
    /// Driver of one lane.
    DriverLane,
    /// Drivers of all lanes, each quantity in an array over the lanes.
    DriverLanes {
        mode: StandingAdvice,
        /// Advised acceleration, m/s², or speed, m/s.
        advised: f32,
        /// Reaction time, steps.
        delay: u32,
        habit_mps: f32,
        error_mps: f32,
        /// Standard deviation of the random change of the error per step.
        error_step_mps: f32,
        deadband_mps: f32,
        /// Noise of the speed while the driver keeps the distance, m/s, and the standard deviation of its random change per step.
        noise_mps: f32,
        noise_step_mps: f32,
        /// Time gap to the leader as a multiple of the ring's time gap.
        gap_factor: f32,
        compliance: Compliance,
        /// Traits, with the willingness at the start; the current one comes from `compliance`.
        traits: DriverTraits,
        /// Steps under advice so far.
        advised_steps: u32,
        held_back_mps: f32,
        follows: bool,
        looks: bool,
        /// Advice in the driver's memory, m/s: the speed shown at the last glance at the speedometer; -1 before.
        followed_advice_mps: f32,
        driven_by: DrivenBy,
    }
}

impl DriverLane {
    /// Returns a driver without traits, before any advice.
    fn without_traits() -> Self {
        Self {
            mode: StandingAdvice::Model,
            advised: 0.0,
            delay: 0,
            habit_mps: 0.0,
            error_mps: 0.0,
            error_step_mps: 0.0,
            deadband_mps: 0.0,
            noise_mps: 0.0,
            noise_step_mps: 0.0,
            gap_factor: 1.0,
            compliance: Compliance::full(),
            traits: DriverTraits::default(),
            advised_steps: 0,
            held_back_mps: 0.0,
            follows: true,
            looks: true,
            followed_advice_mps: -1.0,
            driven_by: DrivenBy::Model,
        }
    }
}

/// Drivers of one advised vehicle, such as the ego, on each ring of a block.
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
    /// Share of the error kept per step.
    error_decay: f32,
    /// Share of the noise of measured people kept per step, and the standard deviation of its random change, m/s.
    noise_keeps: f32,
    noise_step_mps: f32,
    lanes: DriverLanes,
    all_comply: bool,
    /// True if the drivers follow as all vehicles of their rings; among measured people they follow as the average person.
    follows_alike: bool,
    /// Advised speeds of the last steps, a ring buffer with the latest at `newest`; -1 for a step without advice.
    shown_mps: Vec<SimdLanes>,
    newest: usize,
    rng: LaneRng,
    view: LateView,
}

/// Copies the quantities that a training's driver shares with the driver of whole drives.
macro_rules! copied {
    ($from:expr => $to:ident { $($more:tt)* }) => {
        $to {
            reaction_s: $from.reaction_s,
            leader_reaction_s: $from.leader_reaction_s,
            error_mps: $from.error_mps,
            error_time_s: $from.error_time_s,
            speed_bias_mps: $from.speed_bias_mps,
            deadband_mps: $from.deadband_mps,
            compliance: $from.compliance,
            compliance_fade_s: $from.compliance_fade_s,
            patience_mps: $from.patience_mps,
            inattention_per_min: $from.inattention_per_min,
            inattention_s: $from.inattention_s,
            $($more)*
        }
    };
}

impl TrainConfig {
    /// Returns the same rings with this driver in each. The ego's acceleration and deceleration limits still come from the configuration.
    pub fn driven_by(&self, driver: &DriverParams) -> Self {
        let brakes_for_leader = driver.leader_rule == LeaderRule::Guard;
        let follow = match driver.leader_rule {
            _ if !driver.follows_advice => FollowKind::Ignore,
            LeaderRule::Model => FollowKind::Driver,
            LeaderRule::Guard | LeaderRule::Ignore => FollowKind::Exact,
        };
        let driver = copied!(driver => DriverConfig {
            follow,
            brakes_for_leader,
            random_driver: false,
            population: Population::None,
            ..self.driver.clone()
        });
        Self { driver, ..self.clone() }
    }

    /// Returns the same rings, each with a driver drawn from this population.
    pub fn driven_by_some_of(&self, population: Population) -> Self {
        let driver = DriverConfig { follow: FollowKind::Driver, population, ..self.driver.clone() };
        Self { driver, ..self.clone() }
    }

    /// Returns the driver of these rings by name, if all rings have the same one.
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

    /// Draws the driver of one episode.
    pub fn draw_driver(&self, stream: &mut Stream) -> DriverParams {
        let driver = &self.driver;
        let set = copied!(driver => DriverParams { idm: self.ring.idm, ..DriverParams::default() });
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
    /// Returns drivers without traits; [`AdviceFollower::draw`] sets them.
    pub fn new(config: &TrainConfig) -> Self {
        let driver = &config.driver;
        let longest_s = match driver.population {
            Population::None => driver.reaction_s.max(driver.leader_reaction_s),
            Population::People | Population::Perp | Population::Anyone => LONGEST_REACTION_S,
        };
        let longest = (longest_s / config.ring.step_s).round() as usize;
        let people = config.ring.traffic_drivers().swap_remove(0);
        let (noise_keeps, noise_step_mps) = people.typical().noise.in_steps_of(config.ring.step_s);
        Self {
            step_s: config.ring.step_s as f32,
            is_driver: driver.follow == FollowKind::Driver,
            ignores: driver.follow == FollowKind::Ignore,
            brakes: driver.brakes_for_leader,
            accel_mps2: driver.ego_accel_mps2 as f32,
            decel_mps2: driver.ego_decel_mps2 as f32,
            guard_mps2: driver.guard_decel_mps2 as f32,
            response_s: driver.ego_response_s.max(config.ring.step_s) as f32,
            error_decay: (-config.ring.step_s / driver.error_time_s).exp() as f32,
            lanes: DriverLanes::all(DriverLane::without_traits()),
            noise_keeps: noise_keeps as f32,
            noise_step_mps: noise_step_mps as f32,
            all_comply: true,
            follows_alike: people.are_alike(),
            shown_mps: vec![splat(-1.0); longest + 1],
            newest: 0,
            rng: LaneRng::new(),
            view: LateView::new(longest_s, config.ring.step_s),
        }
    }

    /// Draws a new driver for lane `l`.
    pub fn draw(&mut self, l: usize, config: &TrainConfig, stream: &mut Stream) {
        let driver = config.draw_driver(stream);
        let error_decay = f64::from(self.error_decay);
        let error_mps = (driver.error_mps * stream.normal()) as f32;
        let seed = (stream.uniform(0.0, 1.0) * 9.0e15) as u64;
        let drawn = DriverLane {
            delay: (driver.reaction_s / config.ring.step_s).round() as u32,
            habit_mps: driver.speed_bias_mps as f32,
            error_mps,
            error_step_mps: (driver.error_mps * (1.0 - error_decay * error_decay).sqrt()) as f32,
            deadband_mps: driver.deadband_mps as f32,
            noise_step_mps: if driver.errs() { self.noise_step_mps } else { 0.0 },
            gap_factor: (driver.idm.t / config.ring.idm.t) as f32,
            compliance: if self.is_driver { Compliance::of(&driver, seed) } else { Compliance::full() },
            traits: if self.is_driver { driver.traits(config.ring.idm.t) } else { DriverTraits::default() },
            ..DriverLane::without_traits()
        };
        self.rng.seed(l, seed);
        // Only a simulated driver perceives with a delay; an exactly following ego does not. Among measured people, the driver follows as
        // they do: the lag that was measured is that of their model, without a further delay (docs/references.md: people).
        let sees_late = self.is_driver && self.follows_alike;
        self.view.set(l, if sees_late { driver.leader_reaction_s } else { 0.0 });
        self.set_lane(l, drawn);
    }

    /// Returns the traits of the driver on ring `l` with the current willingness, as a teacher sees them.
    pub fn traits(&self, l: usize) -> DriverTraits {
        let driver = self.lanes.get(l);
        let time_s = f64::from(driver.advised_steps) * f64::from(self.step_s);
        let willingness = driver.compliance.willingness(time_s, f64::from(driver.held_back_mps));
        DriverTraits { willingness, ..driver.traits }
    }

    /// Copies a driver, as they are before any advice, from another block's lane.
    pub fn copy_lane(&mut self, l: usize, from: &Self, from_lane: usize) {
        self.rng.copy_lane(l, &from.rng, from_lane);
        self.view.copy_lane(l, &from.view, from_lane);
        let DriverLane { advised_steps, held_back_mps, follows, looks, followed_advice_mps, driven_by, .. } =
            DriverLane::without_traits();
        let drawn = from.lanes.get(from_lane);
        self.set_lane(
            l,
            DriverLane { advised_steps, held_back_mps, follows, looks, followed_advice_mps, driven_by, ..drawn },
        );
    }

    fn set_lane(&mut self, l: usize, driver: DriverLane) {
        self.lanes.set(l, driver);
        // A new driver has seen nothing yet, so the position in the ring buffer does not matter.
        self.shown_mps.iter_mut().for_each(|shown| shown[l] = -1.0);
        self.all_comply = self.lanes.compliance.iter().all(Compliance::is_full);
    }

    /// Issues advice for ring `l`, where the vehicle drives at `own_mps`, in force for `hold`; `None` withdraws the advice.
    pub fn advise(&mut self, l: usize, action: Option<Action>, own_mps: f32, hold: Hold) {
        if self.ignores {
            return;
        }
        let Some(action) = action else {
            let has_been_advised = self.is_driver && self.lanes.mode[l] != StandingAdvice::Model;
            self.lanes.mode[l] = if has_been_advised { StandingAdvice::Silence } else { StandingAdvice::Model };
            return;
        };
        let before = (self.lanes.mode[l] == StandingAdvice::Speed).then(|| f64::from(self.lanes.advised[l]));
        (self.lanes.mode[l], self.lanes.advised[l]) = match action {
            Action::Speed(speed) => (StandingAdvice::Speed, speed.max(0.0) as f32),
            // A driver sees the speed to which the acceleration leads.
            Action::Acceleration(a) if self.is_driver => {
                (StandingAdvice::Speed, shown_mps(before, f64::from(own_mps), a, hold.seconds()) as f32)
            }
            Action::Acceleration(a) => (StandingAdvice::Acceleration, a as f32),
        };
    }

    /// Returns the speed advised to the driver of lane `l`, m/s.
    pub fn advised_mps(&self, l: usize) -> Option<f64> {
        (self.lanes.mode[l] == StandingAdvice::Speed).then(|| f64::from(self.lanes.advised[l]))
    }

    /// Returns the present deviation of the driver of lane `l` from the speed that they seek, m/s.
    pub fn deviation_mps(&self, l: usize) -> f64 {
        f64::from(self.lanes.habit_mps[l] + self.lanes.error_mps[l])
    }

    /// Returns the distance of speeds from the range around the advised ones, m/s; 0 if no speed is advised.
    #[inline(always)]
    pub fn missed_mps(&self, own_mps: &SimdLanes, range_mps: f32) -> SimdLanes {
        lane(|l| {
            let missed = ((own_mps[l] - self.lanes.advised[l]).abs() - range_mps).max(0.0);
            if self.lanes.mode[l] == StandingAdvice::Speed { missed } else { 0.0 }
        })
    }

    /// Returns the source of the vehicle's speed on each ring in the last step.
    pub fn driven_by(&self) -> &[DrivenBy; LANES] {
        &self.lanes.driven_by
    }

    /// Returns the speeds of the vehicles of slot `k` at the end of this step, m/s.
    #[inline(always)]
    pub fn step(&mut self, ring: &VectorizedRing, k: usize) -> SimdLanes {
        let (speed, leader_mps, gap_m) = (ring.speed_mps_of(k), ring.leader_mps_of(k), ring.gaps_m(k));
        let mut model = self.own_model(ring, k);
        if !self.all_comply {
            self.decide(leader_mps);
        }
        let wanted = if self.is_driver { self.driver(speed) } else { self.exact(speed) };
        let dt = self.step_s;
        if self.is_driver && !self.follows_alike {
            // Like every error, the noise fades below 1 m/s.
            model = lane(|l| model[l] + self.lanes.noise_mps[l] / dt * speed[l].min(1.0));
        }
        let mut driven = splat(0.0);
        let mut driven_by = [DrivenBy::Advice; LANES];
        for l in 0..LANES {
            let has_nothing_in_mind = self.is_driver && wanted[l] == f32::INFINITY;
            let is_free = self.lanes.mode[l] == StandingAdvice::Model || has_nothing_in_mind || !self.lanes.follows[l];
            let keeps_distance = self.is_driver && model[l] < wanted[l];
            let by_model = is_free || keeps_distance;
            driven[l] = (speed[l] + if by_model { model[l] } else { wanted[l] } * dt).max(0.0);
            let by_distance = if keeps_distance { DrivenBy::Distance } else { DrivenBy::Advice };
            driven_by[l] = if is_free { DrivenBy::Model } else { by_distance };
        }
        if self.brakes {
            for l in 0..LANES {
                let hardest = (speed[l] - self.guard_mps2 * dt).max(0.0);
                let safe = self.safe_mps(gap_m[l], leader_mps[l]).max(hardest);
                if driven_by[l] == DrivenBy::Advice && safe < driven[l] {
                    (driven[l], driven_by[l]) = (safe, DrivenBy::Guard);
                }
            }
        }
        self.lanes.driven_by = driven_by;
        self.view.drive(&driven);
        driven
    }

    /// Returns the acceleration of each driver's own model from what they perceive from slot `k`, m/s².
    #[inline(always)]
    fn own_model(&mut self, ring: &VectorizedRing, k: usize) -> SimdLanes {
        if self.follows_alike && self.view.is_prompt() && self.lanes.gap_factor == splat(1.0) {
            return ring.by_model(k, ring.gaps_m(k), ring.leader_mps_of(k), ring.time_gap_s());
        }
        let [gap_m, leader_mps] = self.view.see(ring.gaps_m(k), ring.leader_mps_of(k));
        let time_gap_s = lane(|l| ring.time_gap_s()[l] * self.lanes.gap_factor[l]);
        ring.by_model(k, &gap_m, &leader_mps, &time_gap_s)
    }

    /// Decides once a second which drivers look and which follow; updates each step how far the advice holds each driver back.
    fn decide(&mut self, leader_mps: &SimdLanes) {
        let steps_per_s = (1.0 / self.step_s).round().max(1.0) as u32;
        let fresh = self.step_s / HELD_BACK_S as f32;
        for (l, leader_mps) in leader_mps.iter().enumerate() {
            if self.lanes.mode[l] != StandingAdvice::Speed {
                continue;
            }
            if self.lanes.advised_steps[l].is_multiple_of(steps_per_s) {
                let time_s = f64::from(self.lanes.advised_steps[l]) * f64::from(self.step_s);
                self.lanes.follows[l] =
                    self.lanes.compliance[l].follows(time_s, f64::from(self.lanes.held_back_mps[l]));
                self.lanes.looks[l] = self.lanes.compliance[l].looks(time_s);
            }
            let behind_mps = leader_mps - self.lanes.advised[l];
            self.lanes.held_back_mps[l] += (behind_mps - self.lanes.held_back_mps[l]) * fresh;
            self.lanes.advised_steps[l] += 1;
        }
    }

    /// Returns the highest speed from which the ego can stop behind its leader if the leader brakes as hard as the ego can, m/s. This is
    /// the safe speed of Krauss 1998 with one step of delay, as in SUMO and Flow. Unlike the model's own distance it acts only where it
    /// must.
    #[inline(always)]
    fn safe_mps(&self, gap_m: f32, leader_mps: f32) -> f32 {
        let (b, delay_mps) = (self.decel_mps2, self.decel_mps2 * self.step_s);
        let room_m = (gap_m - SAFE_GAP_M).max(0.0);
        (delay_mps * delay_mps + leader_mps * leader_mps + 2.0 * b * room_m).sqrt() - delay_mps
    }

    #[inline(always)]
    fn exact(&self, speed: &SimdLanes) -> SimdLanes {
        lane(|l| {
            let reach =
                ((self.lanes.advised[l] - speed[l]) / self.response_s).max(-self.decel_mps2).min(self.accel_mps2);
            if self.lanes.mode[l] == StandingAdvice::Speed { reach } else { self.lanes.advised[l] }
        })
    }

    #[inline(always)]
    fn driver(&mut self, speed: &SimdLanes) -> SimdLanes {
        let size = self.shown_mps.len();
        self.newest = if self.newest + 1 == size { 0 } else { self.newest + 1 };
        for l in 0..LANES {
            let is_advised = self.lanes.mode[l] == StandingAdvice::Speed;
            if is_advised && (self.lanes.looks[l] || self.lanes.followed_advice_mps[l] < 0.0) {
                self.lanes.followed_advice_mps[l] = self.lanes.advised[l];
            }
            self.shown_mps[self.newest][l] = if is_advised { self.lanes.followed_advice_mps[l] } else { -1.0 };
        }
        let (fresh, fresh_noise) = self.rng.normal_pair();
        self.lanes.noise_mps =
            lane(|l| self.lanes.noise_mps[l] * self.noise_keeps + self.lanes.noise_step_mps[l] * fresh_noise[l]);
        self.lanes.error_mps =
            lane(|l| self.lanes.error_mps[l] * self.error_decay + self.lanes.error_step_mps[l] * fresh[l]);
        let seen_mps = lane(|l| {
            let at = self.newest + size - self.lanes.delay[l] as usize;
            self.shown_mps[if at >= size { at - size } else { at }][l]
        });
        lane(|l| {
            let seen = seen_mps[l];
            // Before an advice is perceived, and after its withdrawal is, the model alone drives the ego.
            if seen < 0.0 {
                return f32::INFINITY;
            }
            // Bias and error fade below 1 m/s: a driver makes no error about standing still.
            let target = seen + (self.lanes.habit_mps[l] + self.lanes.error_mps[l]) * seen.min(1.0);
            let off = target.max(0.0) - speed[l];
            let felt = off - off.max(-self.lanes.deadband_mps[l]).min(self.lanes.deadband_mps[l]);
            (felt / SPEED_RELAXATION_S).max(-self.decel_mps2).min(self.accel_mps2)
        })
    }
}
