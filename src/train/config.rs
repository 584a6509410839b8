//! Everything that makes one training. This struct **is** the file, the flags and their help: doc comments are the
//! help, the ranges the limits. Defaults are those of the field (docs/references.md: learning) where the field agrees.

use super::{inputs::inputs, lessons::EstimatorKind};
use crate::{
    driver::Population,
    idm::IdmParams,
    policy::{Hold, NetworkInput, PolicySettings},
    settings::flat_settings,
    space::CAR_LENGTH_M,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

flat_settings! {
    /// One training, complete.
    pub struct TrainConfig, written as config_file {
        fields {}
        /// What the policy puts out, and how long it stands.
        group advice: AdviceConfig {
            /// What the policy puts out
            action: ActionKind = ActionKind::Acceleration,
            /// Number of levels between the limits of the action; 0 is continuous
            #[schemars(range(min = 0, max = 1000))]
            levels: u32 = 0,
            /// Advice that the policy corrects: a controller or a speed policy, by name or by its FILE.toml; empty: none
            residual_over: String = String::new(),
            /// Largest correction, either way
            #[schemars(range(min = 0.1, max = 20.0), extend("unit" = "m/s"))]
            residual_mps: f64 = 2.0,
            /// Largest acceleration, either way, of acceleration advice
            #[schemars(range(min = 0.05, max = 5.0), extend("unit" = "m/s2"))]
            accel_limit_mps2: f64 = 0.5,
            /// Highest speed of speed advice; the lowest is 0
            #[schemars(range(min = 1.0, max = 60.0), extend("unit" = "m/s"))]
            top_speed_mps: f64 = 10.0,
            /// Largest change of speed, either way, that an acceleration leads to in one hold; 0 sets no bound
            #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "m/s"))]
            speed_change_mps: f64 = 0.0,
            /// How long one action stands, a whole number of steps
            #[schemars(range(min = 0.01, max = 600.0), extend("unit" = "s"))]
            hold_s: f64 = 1.0,
            /// Longest hold: blocks of rings then have holds from hold_s to this, in even ratios; 0 is hold_s
            #[schemars(range(min = 0.0, max = 600.0), extend("unit" = "s"))]
            hold_max_s: f64 = 0.0,
        }
        /// The rings that are drawn, and an episode on one.
        group ring: RingConfig {
            /// Fewest cars of a ring, the ego included
            #[schemars(range(min = 2, max = 200))]
            vehicles_min: u32 = 22,
            /// Most cars of a ring
            #[schemars(range(min = 2, max = 200))]
            vehicles_max: u32 = 22,
            /// Shortest ring
            #[schemars(range(min = 50.0, max = 5000.0), extend("unit" = "m"))]
            circumference_min_m: f64 = 200.0,
            /// Longest ring
            #[schemars(range(min = 50.0, max = 5000.0), extend("unit" = "m"))]
            circumference_max_m: f64 = 300.0,
            /// Road for each car below which the policy withholds advice, because advice would slow the ring; such rings are drawn longer
            #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
            least_spacing_m: f64 = 0.0,
            /// Car-following model of the other cars
            idm: IdmParams = IdmParams::default(),
            /// Share by which the model's parameters differ from ring to ring, either way
            #[schemars(range(min = 0.0, max = 0.9), extend("unit" = ""))]
            idm_spread: f64 = 0.0,
            /// Share by which each other car's parameters differ from those of its ring, either way
            #[schemars(range(min = 0.0, max = 0.9), extend("unit" = ""))]
            car_spread: f64 = 0.0,
            /// Share of trucks among the other cars: 7.1 m long, half the acceleration
            #[schemars(range(min = 0.0, max = 1.0), extend("unit" = ""))]
            truck_share: f64 = 0.0,
            /// Share of the rings whose cars start close together, so that the wave is there after the warm-up
            #[schemars(range(min = 0.0, max = 1.0), extend("unit" = ""))]
            bunched_share: f64 = 1.0,
            /// Length of a step
            #[schemars(range(min = 0.01, max = 1.0), extend("unit" = "s"))]
            step_s: f64 = 0.1,
            /// Traffic runs this long before the policy acts
            #[schemars(range(min = 0.0, max = 3600.0), extend("unit" = "s"))]
            warm_up_s: f64 = 120.0,
            /// Length of an episode, the warm-up not included
            #[schemars(range(min = 1.0, max = 36000.0), extend("unit" = "s"))]
            horizon_s: f64 = 800.0,
        }
        /// What is rewarded and what is taken from it.
        group reward: RewardConfig {
            /// Whose speed is the reward
            #[serde(rename = "reward")]
            kind: RewardKind = RewardKind::All,
            /// Taken from the reward for each unit of action (a share of its limit)
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/s"))]
            action_penalty: f64 = 0.0,
            /// Taken from the reward in proportion to the missing part of a time gap of 1 s
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/s"))]
            headway_penalty: f64 = 0.0,
            /// Taken from the reward for each m/s by which the ego misses the range of the advised speed
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = ""))]
            range_penalty: f64 = 0.0,
            /// Half width of that range
            #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "m/s"))]
            // docs/references.md: band: a useful band on the 250 m ring is about +-1 mph.
            range_mps: f64 = 0.447,
            /// Taken once when cars collide; from then on all stand
            #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m/s"))]
            collision_penalty: f64 = 100.0,
        }
        /// Who follows the advice.
        group driver: DriverConfig {
            /// How the ego follows the advice
            follow: FollowKind = FollowKind::Exact,
            /// Largest acceleration that the ego uses to reach an advised speed
            #[schemars(range(min = 0.1, max = 10.0), extend("unit" = "m/s2"))]
            ego_accel_mps2: f64 = 1.5,
            /// Largest deceleration that it uses
            #[schemars(range(min = 0.1, max = 10.0), extend("unit" = "m/s2"))]
            ego_decel_mps2: f64 = 4.5,
            /// Time in which an ego that follows to the letter closes a difference to the advised speed; 0 is one step
            #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "s"))]
            ego_response_s: f64 = 0.0,
            /// The ego brakes before it would hit its leader, whatever the advice (a simulated driver always keeps its distance)
            brakes_for_leader: bool = false,
            /// Largest deceleration with which the ego brakes before it would hit its leader
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
            /// Simulated driver: share of the time in which the advice is followed, decided anew every 20 s
            #[schemars(range(min = 0.0, max = 1.0), extend("unit" = ""))]
            compliance: f64 = 1.0,
            /// Simulated driver: time in which this share fades to 1/e of itself; 0: it does not
            #[schemars(range(min = 0.0, max = 1000000.0), extend("unit" = "s"))]
            compliance_fade_s: f64 = 0.0,
            /// Simulated driver: advice slower than the leader by this much, on average of half a minute, lowers this share to 1/e; 0: none does
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/s"))]
            patience_mps: f64 = 0.0,
            /// Simulated driver: spells without a look at the dial, each minute
            #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "1/min"))]
            inattention_per_min: f64 = 0.0,
            /// Simulated driver: length of such a spell
            #[schemars(range(min = 0.0, max = 60.0), extend("unit" = "s"))]
            inattention_s: f64 = 0.0,
            /// A driver is drawn from this population in each episode: people, perp or anyone; none takes the settings above
            population: Population = Population::None,
            /// Simulated driver: reaction and error are drawn from 0 to their value, the deviation from - to +, in each episode
            random_driver: bool = true,
        }
        /// What the policy sees, and the network that it is.
        group network: NetworkConfig {
            /// What the policy sees, of speed, leader_speed, relative_speed, gap, headway, circumference, spacing, mean_speed,
            /// log_hold, controller_speed, and of who drives: reaction, speed_bias, tracking_error, time_gap_factor, willingness, or
            /// latent_1 to latent_4 (estimator "variational")
            sees: String = "speed,leader_speed,gap,circumference".into(),
            /// How it is scaled
            scaling: Scaling = Scaling::default(),
            /// Units of each hidden layer
            #[schemars(range(min = 1, max = 1024))]
            hidden_width: u32 = 64,
            /// Hidden layers
            #[schemars(range(min = 1, max = 8))]
            hidden_layers: u32 = 2,
        }
        /// How much is driven and learned from.
        group run: RunConfig {
            /// Updates of the policy
            #[schemars(range(min = 1, max = 1000000))]
            iterations: u32 = 500,
            /// Decisions per update
            #[schemars(range(min = 64, max = 10000000))]
            batch: u32 = 16_000,
            /// Rings side by side, a multiple of 16
            #[schemars(range(min = 16, max = 65536))]
            rings: u32 = 64,
        }
        /// Who tells the policy who drives: a student that watches the driver, after the policy has learned from a teacher who knows,
        /// or, if he tells latents that no teacher has names for, after it has learned without asking.
        group student: StudentConfig {
            /// What the estimator of the driver learns to tell
            estimator: EstimatorKind = EstimatorKind::Traits,
            /// Rounds in which an estimator of the driver learns; 0: none, and what the policy sees of the driver is the truth
            #[schemars(range(min = 0, max = 100000))]
            estimator_rounds: u32 = 0,
            /// Units of its state
            #[schemars(range(min = 1, max = 512))]
            estimator_units: u32 = 48,
            /// Step of Adam for it at the beginning; it falls to a tenth of it
            #[schemars(range(min = 0.0000001, max = 1.0), extend("unit" = ""))]
            estimator_rate: f64 = 3e-3,
            /// Length of a round, each of the rings
            #[schemars(range(min = 10.0, max = 3600.0), extend("unit" = "s"))]
            estimator_round_s: f64 = 100.0,
            /// Latents of a variational estimator
            #[schemars(range(min = 1, max = 4))]
            latents: u32 = 2,
            /// What a nat of the latents' KL divergence from N(0, 1) counts beside a nat of what one second of driving surprises
            #[schemars(range(min = 0.0, max = 100.0), extend("unit" = ""))]
            // A latent speaks for about 20 s, the window of docs/references.md: perp.
            kl_weight: f64 = 0.05,
            /// Updates of the policy after that, on what the estimator says
            #[schemars(range(min = 0, max = 1000000))]
            student_iterations: u32 = 0,
        }
        /// Where nothing is advised: learned at the end, from drives with the policy's advice and without any.
        group silence: SilenceConfig {
            /// Rings that are driven twice, a multiple of 16, to learn where advice would slow them; 0: advice always stands
            #[schemars(range(min = 0, max = 1000000))]
            silence_rings: u32 = 0,
            /// Expected gain of advice below which nothing is advised
            #[schemars(range(min = -10.0, max = 10.0), extend("unit" = "m/s"))]
            silent_below_mps: f64 = 0.0,
        }
        /// How it is learned: TRPO for the policy, Adam for the value.
        group optimiser: OptimiserConfig {
            /// Time after which a reward counts 1/e: the paper's gamma of 0.999 a step of 0.1 s is 100 s
            #[schemars(range(min = 1.0, max = 100000.0), extend("unit" = "s"))]
            discount_s: f64 = 100.0,
            /// Lambda of generalised advantage estimation
            #[schemars(range(min = 0.0, max = 1.0), extend("unit" = ""))]
            gae_lambda: f64 = 1.0,
            /// Bound on the mean KL divergence of an update
            #[schemars(range(min = 0.000001, max = 1.0), extend("unit" = "nat"))]
            max_kl: f64 = 0.01,
            /// Share of that bound that is left at the last update; it falls in even ratios
            #[schemars(range(min = 0.001, max = 1.0), extend("unit" = ""))]
            max_kl_falls_to: f64 = 1.0,
            /// Steps of the conjugate gradient
            #[schemars(range(min = 1, max = 100))]
            cg_steps: u32 = 10,
            /// Damping of the Fisher matrix
            #[schemars(range(min = 0.0, max = 10.0), extend("unit" = ""))]
            damping: f64 = 0.1,
            /// That matrix is taken from every so manieth decision; the step that it leads to is checked with all of them
            #[schemars(range(min = 1, max = 1000))]
            fisher_every: u32 = 5,
            /// Halvings that the line search tries
            #[schemars(range(min = 1, max = 50))]
            backtracks: u32 = 10,
            /// Standard deviation of the first policy, as a share of the limit of a continuous action
            #[schemars(range(min = 0.01, max = 10.0), extend("unit" = ""))]
            first_sd: f64 = 1.0,
            /// The value knows the whole ring and its driver, which the policy does not see
            value_sees_all: bool = false,
            /// Step of Adam for the value
            #[schemars(range(min = 0.0000001, max = 1.0), extend("unit" = ""))]
            value_rate: f64 = 1e-3,
            /// Passes over the batch for the value
            #[schemars(range(min = 1, max = 1000))]
            value_epochs: u32 = 5,
            /// Decisions per step of Adam
            #[schemars(range(min = 16, max = 1000000))]
            value_batch: u32 = 1000,
        }
        fields {
            /// The policy is judged without noise, on rings of its own, every so many updates
            #[schemars(range(min = 1, max = 1000000))]
            judge_every: u32 = 10,
            /// Seed of everything random
            #[schemars(range(min = 0, max = 9007199254740991_u64))]
            seed: u64 = 1,
        }
    }
}

/// What becomes 1 in the network's input (and -1, where it is not 0).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scaling {
    /// Speed that becomes 1; standing is -1
    #[schemars(range(min = 0.1, max = 100.0), extend("unit" = "m/s"))]
    pub speed_to_mps: f64,
    /// Gap that becomes 1; none is -1
    #[schemars(range(min = 0.1, max = 10000.0), extend("unit" = "m"))]
    pub gap_to_m: f64,
    /// Circumference that becomes -1
    #[schemars(range(min = 0.0, max = 100000.0), extend("unit" = "m"))]
    pub circumference_from_m: f64,
    /// Circumference that becomes 1
    #[schemars(range(min = 1.0, max = 100000.0), extend("unit" = "m"))]
    pub circumference_to_m: f64,
    /// Length of road for a car that becomes -1
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m"))]
    pub spacing_from_m: f64,
    /// Length of road for a car that becomes 1
    #[schemars(range(min = 0.1, max = 10000.0), extend("unit" = "m"))]
    pub spacing_to_m: f64,
}

impl Default for Scaling {
    /// As docs/references.md: learning has it, but for the gap: the field's 300 m leaves a gap of 6 m and one of 12 m
    /// 0.04 apart; with 30 m the best of 150 updates was judged 4.59 against 4.46 m/s.
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

/// What a policy puts out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ActionKind {
    /// An acceleration, kept for the hold
    #[default]
    Acceleration,
    /// A speed, driven for the hold
    Speed,
}

/// Whose speed is rewarded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum RewardKind {
    /// The mean speed of all cars
    #[default]
    All,
    /// The ego's speed
    Ego,
}

/// How the ego follows the advice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FollowKind {
    /// To the letter, within the ego's acceleration (HC22's training)
    #[default]
    Exact,
    /// As a simulated driver: late, with an error and a habit
    Driver,
    /// Not at all: the car-following model drives
    Ignore,
}

impl TrainConfig {
    /// HC22's ring with the wave on it, for what names no configuration.
    pub fn paper_ring() -> Self {
        Self {
            ring: RingConfig {
                circumference_min_m: 250.0,
                circumference_max_m: 250.0,
                bunched_share: 1.0,
                ..RingConfig::default()
            },
            ..Self::default()
        }
    }

    /// The larger of the shipped rings: 40 cars, scaled as its shipped policies see it.
    pub fn larger_ring() -> Self {
        let paper = Self::paper_ring();
        Self {
            advice: AdviceConfig { top_speed_mps: 18.0, ..paper.advice.clone() },
            ring: RingConfig {
                vehicles_min: 40,
                vehicles_max: 40,
                circumference_min_m: 640.9,
                circumference_max_m: 640.9,
                warm_up_s: 300.0,
                idm: IdmParams { v0: 17.88, ..paper.ring.idm },
                ..paper.ring.clone()
            },
            network: NetworkConfig {
                scaling: Scaling {
                    speed_to_mps: 20.0,
                    gap_to_m: 60.0,
                    circumference_from_m: 560.0,
                    circumference_to_m: 720.0,
                    spacing_from_m: 12.0,
                    spacing_to_m: 20.0,
                },
                ..paper.network.clone()
            },
            ..paper
        }
    }

    /// What built-in policies are built from: the middle of these rings, and an aim in m/s, 0 for the automatic one.
    pub fn policy_settings(&self, aim_mps: f64) -> PolicySettings {
        let length_m = (self.ring.circumference_min_m + self.ring.circumference_max_m) / 2.0;
        let cars = f64::from(self.ring.vehicles_min + self.ring.vehicles_max) / 2.0;
        let equilibrium_mps = self.ring.idm.equilibrium_speed_mps(length_m / cars - CAR_LENGTH_M);
        PolicySettings { aim_mps, equilibrium_mps, step_s: self.ring.step_s }
    }

    /// The same with this one hold, seconds.
    pub fn held(&self, hold_s: f64) -> Self {
        Self { advice: AdviceConfig { hold_s, hold_max_s: 0.0, ..self.advice.clone() }, ..self.clone() }
    }

    /// The shortest hold.
    pub fn hold(&self) -> Hold {
        Hold::nearest(self.advice.hold_s, self.ring.step_s)
    }

    /// Shortest and longest hold, seconds.
    pub fn holds_s(&self) -> [f64; 2] {
        [self.advice.hold_s, self.advice.hold_max_s.max(self.advice.hold_s)]
    }

    /// The hold of block `index` of so many.
    pub fn hold_of(&self, index: usize, blocks: usize) -> Hold {
        let [low, high] = self.holds_s();
        let share = index as f64 / (blocks as f64 - 1.0).max(1.0);
        Hold::nearest(low * (high / low).powf(share), self.ring.step_s)
    }

    /// Decisions of each ring in a batch, at least 1.
    pub fn decisions(&self) -> usize {
        ((self.run.batch as f64 / f64::from(self.run.rings)).round() as usize).max(1)
    }

    /// Decisions in an episode of such holds, at least 1.
    pub fn horizon_decisions(&self, hold: Hold) -> u32 {
        (self.ring.horizon_s / hold.seconds()).round().max(1.0) as u32
    }

    /// Discount of a hold.
    pub fn gamma(&self, hold: Hold) -> f64 {
        (-hold.seconds() / self.optimiser.discount_s).exp()
    }

    /// True where the policy corrects another advice.
    pub fn is_residual(&self) -> bool {
        !self.advice.residual_over.is_empty()
    }

    /// Lowest and highest action, m/s2 or m/s.
    pub fn action_limits(&self) -> [f64; 2] {
        match self.advice.action {
            ActionKind::Acceleration => [-self.advice.accel_limit_mps2, self.advice.accel_limit_mps2],
            ActionKind::Speed if self.is_residual() => [-self.advice.residual_mps, self.advice.residual_mps],
            ActionKind::Speed => [0.0, self.advice.top_speed_mps],
        }
    }

    /// What the policy sees, scaled; unknown names are left out (its check refuses them).
    pub fn inputs(&self) -> Vec<NetworkInput> {
        inputs(&self.network.sees, &self.network.scaling)
    }

    /// Sizes of a network's layers with `outputs` outputs.
    pub fn layers(&self, outputs: usize) -> Vec<usize> {
        let hidden = vec![self.network.hidden_width as usize; self.network.hidden_layers as usize];
        [vec![self.inputs().len()], hidden, vec![outputs]].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings;

    #[test]
    fn the_file_knows_nothing_of_the_groups() {
        let reward = RewardConfig { kind: RewardKind::Ego, ..RewardConfig::default() };
        let text = toml::to_string(&TrainConfig { reward, ..TrainConfig::default() }).expect("a file");
        let tables: Vec<&str> = text.lines().filter(|line| line.starts_with('[')).collect();
        assert_eq!(tables, ["[idm]", "[scaling]"]);
        assert!(text.starts_with("action = \"acceleration\"\nlevels = 0\n"), "{text}");
        assert!(text.contains("\nreward = \"ego\"\naction_penalty = 0.0\n"), "{text}");
        let read: TrainConfig = settings::from_toml(&text, "train.toml").expect("its own file");
        assert_eq!(read.reward.kind, RewardKind::Ego);
        let refused = |text: &str| settings::from_toml::<TrainConfig>(text, "train.toml").expect_err(text).message;
        assert!(refused("seed = 1\n[ring]\n").starts_with("train.toml:2:2: unknown key `ring`; did you mean `rings`?"));
        assert!(refused("kind = \"ego\"").starts_with("train.toml:1:1: unknown key `kind`"));
        assert!(refused("estimator_rounds = 5").contains("estimator_rounds is 5; allowed: 0 where sees names nothing"));
        assert!(refused("\nhold_s = 0.25").starts_with("train.toml:2:10: hold_s is 0.25; allowed: a whole number"));
    }
}
