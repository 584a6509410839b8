//! Complete configuration of a training. This struct **is** the file, the flags and their help: doc comments are the help, ranges are the
//! limits. Defaults follow the field (docs/references.md: learning) where the field agrees.

use super::{inputs::inputs, lessons::EstimatorKind};
use crate::{
    driver::Population,
    idm::IdmParams,
    metrics::EvaluationResult,
    policy::{Hold, NetworkInput, PolicySettings, Probe},
    scenario::AdvisedVehicles,
    settings::flat_settings,
    space::CAR_LENGTH_M,
    traffic::{self, TrafficDrivers},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

flat_settings! {
    /// Complete configuration of one training.
    pub struct TrainConfig, written as config_file {
        fields {}
        /// Kind of advice and its hold.
        group advice: AdviceConfig {
            /// Quantity that the policy advises
            action: ActionKind = ActionKind::Acceleration,
            /// Number of levels between the limits of the action; 0: continuous
            #[schemars(range(min = 0, max = 1000))]
            levels: u32 = 0,
            /// Advice that the policy corrects: a controller or a speed policy, by name or by its FILE.toml; empty: none
            residual_over: String = String::new(),
            /// Largest correction in either direction
            #[schemars(range(min = 0.1, max = 20.0), extend("unit" = "m/s"))]
            residual_mps: f64 = 2.0,
            /// Largest advised acceleration and deceleration
            #[schemars(range(min = 0.05, max = 5.0), extend("unit" = "m/s2"))]
            accel_limit_mps2: f64 = 0.5,
            /// Highest advised speed; the lowest is 0
            #[schemars(range(min = 1.0, max = 60.0), extend("unit" = "m/s"))]
            top_speed_mps: f64 = 10.0,
            /// Largest change of speed that an advised acceleration causes within one hold; 0: no bound
            #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "m/s"))]
            speed_change_mps: f64 = 0.0,
            /// Duration of one advice, a whole number of steps
            #[schemars(range(min = 0.01, max = 600.0), extend("unit" = "s"))]
            hold_s: f64 = 1.0,
            /// Longest hold: blocks of rings have holds from hold_s to this in a geometric series; 0: hold_s
            #[schemars(range(min = 0.0, max = 600.0), extend("unit" = "s"))]
            hold_max_s: f64 = 0.0,
            /// Amplitude of a square wave that is added to the advised speed at first, so that the driver's response tells who drives; 0: no
            /// such probe
            #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "m/s"))]
            probe_mps: f64 = 0.0,
            /// Period of the probe; with long holds, two holds
            #[schemars(range(min = 0.2, max = 60.0), extend("unit" = "s"))]
            probe_period_s: f64 = 4.0,
            /// Time for which the driver is probed, from the first advice on
            #[schemars(range(min = 1.0, max = 3600.0), extend("unit" = "s"))]
            probe_time_s: f64 = 60.0,
        }
        /// Distribution of the rings, and an episode on one of them.
        group ring: RingConfig {
            /// Smallest number of vehicles on a ring, the ego included
            #[schemars(range(min = 2, max = 200))]
            vehicles_min: u32 = 22,
            /// Largest number of vehicles on a ring, the ego included
            #[schemars(range(min = 2, max = 200))]
            vehicles_max: u32 = 22,
            /// Advised vehicles, the participant's first: a share of all (5%, 0.05; on a network of the vehicles that enter) or a number
            /// (3); 0 is none. All have the same policy; the simulated driver drives the others
            advised: AdvisedVehicles = AdvisedVehicles::default(),
            /// Length of the shortest ring
            #[schemars(range(min = 50.0, max = 5000.0), extend("unit" = "m"))]
            circumference_min_m: f64 = 200.0,
            /// Length of the longest ring
            #[schemars(range(min = 50.0, max = 5000.0), extend("unit" = "m"))]
            circumference_max_m: f64 = 300.0,
            /// Road per vehicle below which the policy withholds advice because it would slow the ring; shorter rings are lengthened to
            /// it
            #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
            least_spacing_m: f64 = 0.0,
            /// Drivers of the other vehicles: ring-study (all alike, with the model `idm`), people as they were measured (safe-followers,
            /// gap-closers), or a population's FILE.toml
            traffic_drivers: String = traffic::RING_STUDY.into(),
            /// Car-following model of the other vehicles with ring-study drivers: v0=30,T=1,a=1,b=1.5,delta=4,s0=2,noise=0.2
            idm: IdmParams = IdmParams::default(),
            /// Largest relative deviation of a ring's model parameters, in either direction
            #[schemars(range(min = 0.0, max = 0.9), extend("unit" = ""))]
            idm_spread: f64 = 0.0,
            /// Largest relative deviation of a vehicle's parameters from its ring's, in either direction
            #[schemars(range(min = 0.0, max = 0.9), extend("unit" = ""))]
            car_spread: f64 = 0.0,
            /// Share of trucks among the other vehicles: 7.1 m long, half the acceleration
            #[schemars(range(min = 0.0, max = 1.0), extend("unit" = ""))]
            truck_share: f64 = 0.0,
            /// Share of rings whose vehicles start close together, so that the wave exists after the warm-up
            #[schemars(range(min = 0.0, max = 1.0), extend("unit" = ""))]
            bunched_share: f64 = 1.0,
            /// Length of a step of traffic and policy, a multiple of 0.01 s
            #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "s"))]
            step_s: f64 = 0.1,
            /// Time for which traffic runs before the drive; the ego is driven by the same model
            #[schemars(range(min = 0.0, max = 3600.0), extend("unit" = "s"))]
            warm_up_s: f64 = 120.0,
            /// Duration of an episode without the warm-up
            #[schemars(range(min = 1.0, max = 36000.0), extend("unit" = "s"))]
            horizon_s: f64 = 800.0,
        }
        /// Reward of a step and its penalties.
        group reward: RewardConfig {
            /// Speed that is rewarded
            #[serde(rename = "reward")]
            kind: RewardKind = RewardKind::All,
            /// Penalty per unit of acceleration advice, as a share of its limit; none for speed advice
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/s"))]
            action_penalty: f64 = 0.0,
            /// Penalty for a time gap below 1 s, in proportion to the missing part
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/s"))]
            headway_penalty: f64 = 0.0,
            /// Penalty per m/s by which the advised vehicle misses the acceptable range of the advised speed
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = ""))]
            range_penalty: f64 = 0.0,
            /// Penalty per m/s of the standard deviation of speed over all vehicles
            #[schemars(range(min = 0.0, max = 10.0), extend("unit" = ""))]
            speed_sd_penalty: f64 = 0.0,
            /// Half width of the acceptable range around the target
            #[schemars(range(min = 0.1, max = 50.0), extend("unit" = "mph"))]
            // docs/references.md: band: a useful band on the 250 m ring is about +-1 mph.
            range_mph: f64 = 1.0,
            /// Penalty for a collision, subtracted once; the episode ends, and its vehicles count as stopped forever
            #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m/s"))]
            collision_penalty: f64 = 100.0,
        }
        /// The driver who follows the advice.
        group driver: DriverConfig {
            /// Driver model of the ego
            follow: FollowKind = FollowKind::Exact,
            /// Largest acceleration of the ego towards an advised speed
            #[schemars(range(min = 0.1, max = 10.0), extend("unit" = "m/s2"))]
            ego_accel_mps2: f64 = 1.5,
            /// Largest deceleration of the ego towards an advised speed
            #[schemars(range(min = 0.1, max = 10.0), extend("unit" = "m/s2"))]
            ego_decel_mps2: f64 = 4.5,
            /// Time in which an exactly following ego closes a difference to the advised speed; 0: one step
            #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "s"))]
            ego_response_s: f64 = 0.0,
            /// Emergency braking of the ego before it hits its leader, whatever the advice (a simulated driver always keeps its distance)
            brakes_for_leader: bool = false,
            /// Largest deceleration of this emergency braking
            #[schemars(range(min = 0.1, max = 10.0), extend("unit" = "m/s2"))]
            guard_decel_mps2: f64 = 8.0,
            /// Simulated driver: time from a new advice to the first response
            #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "s"))]
            reaction_s: f64 = 1.0,
            /// Simulated driver: time from a change of the leader's speed to the first response
            #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "s"))]
            leader_reaction_s: f64 = 0.0,
            /// Simulated driver: standard deviation of the speed around the target
            #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "m/s"))]
            error_mps: f64 = 0.5,
            /// Simulated driver: time constant of that error
            #[schemars(range(min = 0.1, max = 100.0), extend("unit" = "s"))]
            error_time_s: f64 = 5.0,
            /// Simulated driver: constant deviation from the target
            #[schemars(range(min = -5.0, max = 5.0), extend("unit" = "m/s"))]
            speed_bias_mps: f64 = 0.0,
            /// Simulated driver: half width of the band around the target in which the speed is not corrected
            #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "m/s"))]
            deadband_mps: f64 = 0.0,
            /// Simulated driver: share of time in which the advice is followed, drawn again every 20 s
            #[schemars(range(min = 0.0, max = 1.0), extend("unit" = ""))]
            compliance: f64 = 1.0,
            /// Simulated driver: time in which compliance decays to 1/e; 0: no decay
            #[schemars(range(min = 0.0, max = 1000000.0), extend("unit" = "s"))]
            compliance_fade_s: f64 = 0.0,
            /// Simulated driver: half-minute mean of the leader's speed minus the advice that lowers compliance to 1/e; 0: no effect
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/s"))]
            patience_mps: f64 = 0.0,
            /// Simulated driver: periods without a glance at the speedometer, per minute
            #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "1/min"))]
            inattention_per_min: f64 = 0.0,
            /// Simulated driver: duration of such a period
            #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "s"))]
            inattention_s: f64 = 0.0,
            /// Population from which each episode draws its driver: people, perp or anyone; none: the settings above
            population: Population = Population::None,
            /// Simulated driver: in each episode, draw reaction and error from 0 to their value and the deviation from minus to plus its
            /// value
            random_driver: bool = true,
        }
        /// Inputs of the policy and its network.
        group network: NetworkConfig {
            /// Inputs of the policy. Traffic: speed, leader_speed, relative_speed, gap, headway, circumference, spacing, mean_speed,
            /// log_hold, controller_speed, advised. Driver, observed: observed_deviation, observed_reaction, observed_time_gap_factor.
            /// Driver, estimated: reaction, speed_bias, tracking_error, time_gap_factor, willingness, or latent_1 to latent_4 (estimator
            /// "variational"). Whole ring (only while training, and in evaluations on fast rings): ring_mean_speed, ring_speed_sd,
            /// wave_cos_1, wave_sin_1, wave_cos_2, wave_sin_2, deviation
            sees: String = "speed,leader_speed,gap,circumference".into(),
            /// Scaling of the inputs
            scaling: Scaling = Scaling::default(),
            /// Units per hidden layer
            #[schemars(range(min = 1, max = 1024))]
            hidden_width: u32 = 64,
            /// Number of hidden layers
            #[schemars(range(min = 1, max = 8))]
            hidden_layers: u32 = 2,
        }
        /// Amount of driving and learning.
        group run: RunConfig {
            /// Number of policy updates
            #[schemars(range(min = 1, max = 1000000))]
            iterations: u32 = 500,
            /// Number of decisions per update
            #[schemars(range(min = 64, max = 10000000))]
            batch: u32 = 16_000,
            /// Rings simulated in parallel, a multiple of 16
            #[schemars(range(min = 16, max = 65536))]
            rings: u32 = 64,
        }
        /// The driver estimator and the policy updates that use it. With traits, the policy first learns from the true traits; with
        /// latents, it first learns without them.
        group student: StudentConfig {
            /// Quantities that the driver estimator learns
            estimator: EstimatorKind = EstimatorKind::Traits,
            /// Training rounds of the driver estimator; 0: none, and the policy sees the driver's true traits
            #[schemars(range(min = 0, max = 100000))]
            estimator_rounds: u32 = 0,
            /// Units of the estimator's recurrent state
            #[schemars(range(min = 1, max = 512))]
            estimator_units: u32 = 48,
            /// Initial learning rate of Adam for the estimator; falls to a tenth
            #[schemars(range(min = 0.0000001, max = 1.0), extend("unit" = ""))]
            estimator_rate: f64 = 3e-3,
            /// Duration of a round on each ring
            #[schemars(range(min = 10.0, max = 3600.0), extend("unit" = "s"))]
            estimator_round_s: f64 = 100.0,
            /// Number of latents of a variational estimator
            #[schemars(range(min = 1, max = 4))]
            latents: u32 = 2,
            /// Weight of the latents' KL divergence from N(0, 1) relative to the prediction loss of one second of driving
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = ""))]
            // A latent describes about 20 s, the window of docs/references.md: perp.
            kl_weight: f64 = 0.05,
            /// Policy updates after the estimator's rounds, on the estimates
            #[schemars(range(min = 0, max = 1000000))]
            student_iterations: u32 = 0,
        }
        /// Withheld advice: learned at the end, from drives with the policy's advice and drives without any.
        group silence: SilenceConfig {
            /// Rings driven with and without advice to learn where advice slows them, a multiple of 16; 0: never withhold advice
            #[schemars(range(min = 0, max = 1000000))]
            silence_rings: u32 = 0,
            /// Expected gain of advice below which advice is withheld
            #[schemars(range(min = -10.0, max = 10.0), extend("unit" = "m/s"))]
            silent_below_mps: f64 = 0.0,
        }
        /// Optimisers: TRPO for the policy, Adam for the value network.
        group optimiser: OptimiserConfig {
            /// Time after which a reward counts 1/e; the paper's gamma of 0.999 per 0.1 s step is 100 s
            #[schemars(range(min = 1.0, max = 100000.0), extend("unit" = "s"))]
            discount_s: f64 = 100.0,
            /// Lambda of generalised advantage estimation
            #[schemars(range(min = 0.0, max = 1.0), extend("unit" = ""))]
            gae_lambda: f64 = 1.0,
            /// Bound on the mean KL divergence of an update
            #[schemars(range(min = 0.000001, max = 1.0), extend("unit" = "nat"))]
            max_kl: f64 = 0.01,
            /// Share of that bound left at the last update; the bound falls geometrically
            #[schemars(range(min = 0.001, max = 1.0), extend("unit" = ""))]
            max_kl_falls_to: f64 = 1.0,
            /// Number of conjugate-gradient steps
            #[schemars(range(min = 1, max = 100))]
            cg_steps: u32 = 10,
            /// Damping of the Fisher matrix
            #[schemars(range(min = 0.0, max = 10.0), extend("unit" = ""))]
            damping: f64 = 0.1,
            /// Stride of the decisions used for the Fisher matrix; all decisions check the resulting step
            #[schemars(range(min = 1, max = 1000))]
            fisher_every: u32 = 5,
            /// Largest number of halvings in the line search
            #[schemars(range(min = 1, max = 50))]
            backtracks: u32 = 10,
            /// Initial standard deviation of the policy, as a share of the limit of a continuous action
            #[schemars(range(min = 0.01, max = 10.0), extend("unit" = ""))]
            first_sd: f64 = 1.0,
            /// Input of the whole ring and of the driver's traits to the value network; the policy does not see them
            value_sees_all: bool = false,
            /// Learning rate of Adam for the value network
            #[schemars(range(min = 0.0000001, max = 1.0), extend("unit" = ""))]
            value_rate: f64 = 1e-3,
            /// Passes over the batch for the value network
            #[schemars(range(min = 1, max = 1000))]
            value_epochs: u32 = 5,
            /// Decisions per step of Adam
            #[schemars(range(min = 16, max = 1000000))]
            value_batch: u32 = 1000,
        }
        fields {
            /// Updates between evaluations of the policy without noise, on separate rings
            #[schemars(range(min = 1, max = 1000000))]
            judge_every: u32 = 10,
            /// Seed of all random numbers
            #[schemars(range(min = 0, max = 9007199254740991_u64))]
            seed: u64 = 1,
        }
    }
}

/// Values that the network's inputs map to 1 (and to -1, where that is not 0).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scaling {
    /// Speed that maps to 1; standstill maps to -1
    #[schemars(range(min = 0.1, max = 100.0), extend("unit" = "m/s"))]
    pub speed_to_mps: f64,
    /// Gap that maps to 1; a gap of 0 maps to -1
    #[schemars(range(min = 0.1, max = 10000.0), extend("unit" = "m"))]
    pub gap_to_m: f64,
    /// Circumference that maps to -1
    #[schemars(range(min = 0.0, max = 100000.0), extend("unit" = "m"))]
    pub circumference_from_m: f64,
    /// Circumference that maps to 1
    #[schemars(range(min = 1.0, max = 100000.0), extend("unit" = "m"))]
    pub circumference_to_m: f64,
    /// Road per vehicle that maps to -1
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m"))]
    pub spacing_from_m: f64,
    /// Road per vehicle that maps to 1
    #[schemars(range(min = 0.1, max = 10000.0), extend("unit" = "m"))]
    pub spacing_to_m: f64,
}

impl Default for Scaling {
    /// Returns the scaling of docs/references.md: learning, but for the gap. The field's 300 m separates gaps of 6 m and 12 m by 0.04
    /// only; with 30 m the best of 150 updates was evaluated at 4.59 instead of 4.46 m/s.
    fn default() -> Self {
        Self {
            speed_to_mps: 10.0,
            gap_to_m: 30.0,
            circumference_from_m: 200.0,
            circumference_to_m: 300.0,
            spacing_from_m: 8.0,
            spacing_to_m: 16.0,
        }
    }
}

/// Quantity that a policy advises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ActionKind {
    /// Acceleration, kept for the hold
    #[default]
    Acceleration,
    /// Speed, driven for the hold
    Speed,
}

/// Speed that is rewarded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum RewardKind {
    /// Mean speed of all vehicles
    #[default]
    All,
    /// Own speed of the advised vehicle
    Ego,
}

/// Driver model of the ego.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FollowKind {
    /// Exact compliance within the ego's acceleration (HC22's training)
    #[default]
    Exact,
    /// Simulated driver with a delay, an error and a bias
    Driver,
    /// No compliance: the car-following model drives
    Ignore,
}

impl TrainConfig {
    /// Returns the settings from which built-in policies are built: the mean ring, and a target speed in m/s (0: automatic).
    pub fn policy_settings(&self, aim_mps: f64) -> PolicySettings {
        let length_m = (self.ring.circumference_min_m + self.ring.circumference_max_m) / 2.0;
        let cars = f64::from(self.ring.vehicles_min + self.ring.vehicles_max) / 2.0;
        let even_mps = |drivers: &TrafficDrivers| {
            drivers.typical().model.equilibrium_speed_mps(length_m / cars - CAR_LENGTH_M, f64::INFINITY)
        };
        let populations = self.ring.traffic_drivers();
        let equilibrium_mps = populations.iter().map(even_mps).sum::<f64>() / populations.len() as f64;
        PolicySettings { aim_mps, equilibrium_mps, step_s: self.ring.step_s }
    }

    /// Returns a copy with this single hold, s.
    pub fn held(&self, hold_s: f64) -> Self {
        Self { advice: AdviceConfig { hold_s, hold_max_s: 0.0, ..self.advice.clone() }, ..self.clone() }
    }

    /// Returns the probe of the driver, if they are probed.
    pub fn probe(&self) -> Option<Probe> {
        let advice = &self.advice;
        let (amplitude_mps, period_s, duration_s) = (advice.probe_mps, advice.probe_period_s, advice.probe_time_s);
        (amplitude_mps > 0.0).then_some(Probe { amplitude_mps, period_s, duration_s })
    }

    /// Returns the shortest hold.
    pub fn hold(&self) -> Hold {
        Hold::nearest(self.advice.hold_s, self.ring.step_s)
    }

    /// Returns the shortest and the longest hold, s.
    pub fn holds_s(&self) -> [f64; 2] {
        [self.advice.hold_s, self.advice.hold_max_s.max(self.advice.hold_s)]
    }

    /// Returns the hold of block `index` of `blocks`, in a geometric series.
    pub fn hold_of(&self, index: usize, blocks: usize) -> Hold {
        let [low, high] = self.holds_s();
        let share = index as f64 / (blocks as f64 - 1.0).max(1.0);
        Hold::nearest(low * (high / low).powf(share), self.ring.step_s)
    }

    /// Returns the configuration of block `index`, which has one population of drivers.
    pub fn of_block(&self, index: usize) -> Self {
        let traffic_drivers = self.ring.populations().nth(index % self.ring.populations().count()).unwrap_or_default();
        Self { ring: RingConfig { traffic_drivers: traffic_drivers.into(), ..self.ring.clone() }, ..self.clone() }
    }

    /// Returns the value of an evaluated drive: its mean speed minus the penalty for differences of speed, m/s.
    pub fn value_mps(&self, drive: &EvaluationResult) -> f64 {
        drive.mean_speed_mps - self.reward.speed_sd_penalty * drive.speed_sd_over_vehicles_mps
    }

    /// Returns the number of decisions of each advised vehicle in a batch, at least 1.
    pub fn decisions(&self) -> usize {
        let vehicles = f64::from(self.run.rings) * self.ring.advised_slots().count() as f64;
        ((f64::from(self.run.batch) / vehicles).round() as usize).max(1)
    }

    /// Returns the number of decisions in an episode with such holds, at least 1.
    pub fn horizon_decisions(&self, hold: Hold) -> u32 {
        (self.ring.horizon_s / hold.seconds()).round().max(1.0) as u32
    }

    /// Returns the half width of the acceptable range, m/s.
    pub fn range_mps(&self) -> f64 {
        self.reward.range_mph * crate::units::MPS_PER_MPH
    }

    /// Returns the discount factor of one hold.
    pub fn gamma(&self, hold: Hold) -> f64 {
        (-hold.seconds() / self.optimiser.discount_s).exp()
    }

    /// Returns true if the policy corrects other advice.
    pub fn is_residual(&self) -> bool {
        !self.advice.residual_over.is_empty()
    }

    /// Returns the lowest and the highest action, m/s² or m/s.
    pub fn action_limits(&self) -> [f64; 2] {
        match self.advice.action {
            ActionKind::Acceleration => [-self.advice.accel_limit_mps2, self.advice.accel_limit_mps2],
            ActionKind::Speed if self.is_residual() => [-self.advice.residual_mps, self.advice.residual_mps],
            ActionKind::Speed => [0.0, self.advice.top_speed_mps],
        }
    }

    /// Returns the scaled inputs of the policy; unknown names are skipped (the configuration's check refuses them).
    pub fn inputs(&self) -> Vec<NetworkInput> {
        inputs(&self.network.sees, &self.network.scaling)
    }

    /// Returns the layer sizes of a network with `outputs` outputs, inputs first.
    pub fn layers(&self, outputs: usize) -> Vec<usize> {
        let hidden = vec![self.network.hidden_width as usize; self.network.hidden_layers as usize];
        [vec![self.inputs().len()], hidden, vec![outputs]].concat()
    }
}

#[cfg(test)]
#[path = "config_tests.rs"]
mod tests;
