//! Experience of blocks of rings under a policy in training. In: the policy's parameters. Out: a [`Rollout`] for each block, with rows of
//! observations, actions and outcomes.

use super::{
    config::{ActionKind, TrainConfig},
    environment::VecEnv,
    identification::{EstimatorLearner, Seconds, Watcher},
    outcome::{Ending, Outcome, WholeState},
    simd::{LANES, LaneRng, SimdLanes},
    trpo::PolicyShape,
};
use crate::{
    policy::{Action, DriverTraits, Hold, NetworkInput, bounded},
    rng,
};
use serde::{Deserialize, Serialize};

/// A block of rings with the random numbers of its actions.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RolloutWorker {
    pub env: VecEnv,
    /// Random numbers of each advised vehicle, one lane for each ring.
    rngs: Vec<LaneRng>,
    /// The student beside it, once there is one.
    pub watcher: Option<Watcher>,
}

/// Experience of a block: rows are decisions in order of time, within each ring by ring and vehicle by vehicle.
pub struct Rollout {
    /// Scaled observations, one row per decision.
    pub inputs: Vec<f32>,
    /// Actions as the policy's family draws them.
    pub actions: Vec<f32>,
    /// Outcome of each decision.
    pub outcomes: Vec<Outcome>,
    /// Hold of each decision.
    pub hold: Hold,
    /// Scaled observation after the last decision.
    pub after: Vec<f32>,
    /// Whole state of the rings at each decision and after the last one.
    pub states: Vec<WholeState>,
    /// Number of rows of one decision: rings times advised vehicles.
    pub width: usize,
}

/// Means of a batch over time, so that a long hold has more weight than a short one.
pub struct BatchMeans {
    /// Number of steps of rings.
    pub steps: f64,
    /// Mean speed of all vehicles, m/s.
    pub mean_mps: f64,
    /// Mean reward, m/s.
    pub reward: f64,
    /// Episodes of rings that ended in a crash.
    pub crashes: u32,
}

impl BatchMeans {
    /// Returns the means of these rollouts.
    pub fn of(rollouts: &[Rollout]) -> Self {
        let timed = || rollouts.iter().flat_map(|t| t.outcomes.iter().map(|o| (f64::from(t.hold.steps()), o)));
        let steps: f64 = timed().map(|(steps, _)| steps).sum();
        let mean = |of: fn(&Outcome) -> f32| timed().map(|(steps, o)| steps * f64::from(of(o))).sum::<f64>() / steps;
        let crashes = timed().filter(|(_, o)| o.ending == Ending::Crash).count();
        // Each vehicle of a ring has a row.
        let advised = rollouts.first().map_or(1, |rollout| rollout.width / LANES);
        let crashes = (crashes / advised) as u32;
        Self { steps: steps / advised as f64, mean_mps: mean(|o| o.mean_mps), reward: mean(|o| o.reward), crashes }
    }
}

impl RolloutWorker {
    /// Returns block `index` of `count`, each ring at a random point of its episode.
    pub fn new(config: &TrainConfig, index: usize, count: usize) -> Self {
        let mut env = VecEnv::new(config, "train", index, config.hold_of(index, count));
        env.spread();
        let mut rngs = vec![LaneRng::new(); env.rows() / LANES];
        for l in 0..LANES {
            let mut stream = rng::stream(config.seed, &format!("train/actions/{}", index * LANES + l));
            rngs.iter_mut().for_each(|rng| rng.seed(l, (stream.uniform(0.0, 1.0) * 9.0e15) as u64));
        }
        Self { env, rngs, watcher: None }
    }

    /// Adds a student that observes the block's drivers from now on.
    pub fn is_watched_by(&mut self, student: &EstimatorLearner) {
        self.env.keep_samples();
        self.watcher = Some(Watcher::new(student));
    }

    /// Runs `decisions` decisions of this block; `log` collects the seconds from which the student learns.
    pub fn live(
        &mut self,
        config: &TrainConfig,
        shape: &PolicyShape,
        theta: &[f32],
        decisions: usize,
        mut log: Option<&mut Seconds>,
    ) -> Rollout {
        let (net, log_sd) = shape.split(theta);
        let (width, advised) = (self.env.rows(), self.rngs.len());
        let rows = decisions * width;
        let seen = config.inputs();
        let hold = self.env.hold_length();
        let mut rollout = Rollout {
            hold,
            inputs: Vec::with_capacity(rows * seen.len()),
            actions: Vec::with_capacity(rows),
            outcomes: Vec::with_capacity(rows),
            after: Vec::new(),
            states: Vec::with_capacity(rows + width),
            width,
        };
        for _ in 0..decisions {
            let inputs = self.see(&seen);
            rollout.states.extend((0..width).map(|row| self.env.whole_state(row)));
            let here = shape.net.forward(net, &inputs);
            let random: Vec<[SimdLanes; 2]> =
                self.rngs.iter_mut().map(|rng| [rng.normal_pair().0, rng.uniform()]).collect();
            let outputs = here.output().chunks_exact(shape.net.outputs());
            let draw = |(row, out): (usize, &[f32])| {
                let ([normal, uniform], l) = (&random[row % advised], row / advised);
                shape.family.draw(out, log_sd, normal[l], uniform[l])
            };
            let drawn: Vec<f32> = outputs.enumerate().map(draw).collect();
            let actions: Vec<Action> = drawn.iter().map(|drawn| action(config, *drawn, hold)).collect();
            let drivers = self.env.drivers();
            let mut outcomes = self.env.hold(&actions);
            self.tell_student(&mut outcomes, &drivers, log.as_deref_mut());
            rollout.outcomes.extend(outcomes);
            rollout.inputs.extend(inputs);
            rollout.actions.extend(drawn);
        }
        rollout.after = self.see(&seen);
        rollout.states.extend((0..width).map(|row| self.env.whole_state(row)));
        rollout
    }

    /// Passes the samples of a hold to the student, and writes its estimates into `outcomes`.
    fn tell_student(&mut self, outcomes: &mut [Outcome], drivers: &[DriverTraits; LANES], log: Option<&mut Seconds>) {
        let Some(watcher) = &mut self.watcher else { return };
        watcher.watch(&self.env.take_samples(), drivers, log);
        for (l, outcome) in outcomes.iter_mut().enumerate() {
            outcome.last_seen = watcher.who_drives(l).complete_observation(&outcome.last_seen);
            if outcome.ending != Ending::None {
                watcher.begin(l);
            }
        }
    }

    /// Returns the scaled inputs of the policy, one row per advised vehicle.
    pub fn see(&self, inputs: &[NetworkInput]) -> Vec<f32> {
        let seen = |row| {
            let mut observation = self.env.observe(row);
            if let Some(watcher) = &self.watcher {
                // Only rings with one advised vehicle have a student.
                observation = watcher.who_drives(row).complete_observation(&observation);
            }
            inputs.iter().map(move |input| input.scaled(&observation))
        };
        (0..self.env.rows()).flat_map(seen).collect()
    }
}

/// Converts the family's draw into an action for a hold.
pub fn action(config: &TrainConfig, drawn: f32, hold: Hold) -> Action {
    let [low, high] = match config.advice.action {
        ActionKind::Acceleration => bounded(config.action_limits(), config.advice.speed_change_mps, hold.seconds()),
        ActionKind::Speed => config.action_limits(),
    };
    let share = match config.advice.levels {
        0 => (f64::from(drawn).clamp(-1.0, 1.0) + 1.0) / 2.0,
        levels => f64::from(drawn) / f64::from(levels - 1),
    };
    let value = low + (high - low) * share;
    match config.advice.action {
        ActionKind::Acceleration => Action::Acceleration(value),
        ActionKind::Speed => Action::Speed(value),
    }
}
