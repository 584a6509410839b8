//! Episode: a whole drive that a learner advises from outside, hold by hold. In: an [`EpisodeConfig`], a seed, then at
//! each hold an action for each advised vehicle. Out: the vehicles that can be advised next with their observations,
//! the rewards of the hold as in training on rings, and the vehicles that have left.
//!
//! Vehicles that enter within a hold are advised from the next hold on; until then they drive as without advice. A
//! vehicle that leaves the road is done. The first contact of an advised vehicle ends the episode, as in evaluations:
//! for the rest of that hold all vehicles count as standing. While there is no vehicle to advise, the drive continues
//! without actions.

use super::{
    RunError,
    episode_config::EpisodeConfig,
    hold_measures::{HOLD_MEASURES, HoldMeasures},
};
use crate::{
    driver::{self, SimulatedDriver},
    policy::{Action, NetworkInput, Observation},
    rng,
    sim::{Agent, AgentDrivers, HASH_START, OutsideSettings, World, WorldError},
    traffic::{EGO, TrafficOrder, VehicleId},
    train::{RewardKind, rollout::action},
};
use std::sync::Arc;

/// Error of a hold.
#[derive(Debug, thiserror::Error)]
pub enum EpisodeError {
    /// The drive cannot start or go on.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The number of actions differs from the number of agents.
    #[error("{given} actions; allowed: {agents}, one for each present advised vehicle")]
    Count {
        /// Number of given actions.
        given: usize,
        /// Number of vehicles that can be advised.
        agents: usize,
    },
    /// Action that is not allowed.
    #[error("the action of {} is {value}; allowed: {allowed}", name(*agent))]
    Action {
        /// Vehicle of the action.
        agent: VehicleId,
        /// Value of the action.
        value: f32,
        /// Description of the allowed values.
        allowed: String,
    },
    /// Order to the traffic that it cannot carry out; nothing has changed.
    #[error("{0}")]
    Order(String),
    /// The episode is over.
    #[error("the episode is over; begin another one")]
    Over,
}

/// Outcome of one hold for an agent that was present at its beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgentOutcome {
    /// Identifier of the vehicle.
    pub id: VehicleId,
    /// Mean speed over the steps less penalties, m/s.
    pub reward: f64,
    /// True if the vehicle has left the road, or an advised vehicle has touched another.
    pub is_terminated: bool,
    /// Next observation of the vehicle; the last one if it has left.
    pub last_seen: Observation,
}

/// Outcome of one hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HoldOutcome {
    /// Agents that were present at the beginning of the hold.
    pub agents: Vec<AgentOutcome>,
    /// Values of [`HOLD_MEASURES`] over the steps. After a contact, all vehicles stand for the rest of the hold.
    pub measures: [f64; HOLD_MEASURES.len()],
    /// True if the horizon is reached or the participant's path has ended; no vehicle is advised any more.
    pub is_truncated: bool,
}

impl HoldOutcome {
    /// Returns the mean speed of all vehicles over the steps, m/s.
    pub fn mean_speed_mps(&self) -> f64 {
        let [mean_speed_mps, ..] = self.measures;
        mean_speed_mps
    }
}

/// State of an agent during a hold.
struct Advised {
    id: VehicleId,
    contacts: u32,
    way_mps: f64,
    steps: u32,
    last_seen: Observation,
}

/// Running episode of a learner.
pub struct Episode {
    config: EpisodeConfig,
    inputs: Vec<NetworkInput>,
    world: World,
    /// Simulated driver of the ego; `None` without a participant.
    driver: Option<SimulatedDriver>,
    holds: u32,
    horizon: u32,
    is_over: bool,
    /// True on a network on which no vehicle is ever advised: orders to the traffic take the place of actions.
    takes_orders_only: bool,
    fingerprint: u64,
}

impl Episode {
    /// Starts the episode of a seed: creates the world, drives its warm-up, and stops where the first advice is due.
    ///
    /// # Errors
    /// The world cannot start or go on, or a driver cannot be simulated.
    pub fn begin(config: &EpisodeConfig, seed: u64) -> Result<Self, RunError> {
        let drive = config.drive(seed).map_err(WorldError::from)?;
        let takes_orders_only = drive.is_open() && drive.scenario().advises_no_vehicle();
        let drivers = drivers(config, seed);
        let settings = OutsideSettings { sees: config.costly_inputs(), drivers: Some(Arc::clone(&drivers)) };
        let world = World::advised_from_outside(drive, settings)?;
        let scenario = world.scenario();
        let driver = match scenario.participant {
            true => {
                let driver = world.simulated_driver(&drivers(EGO)?, seed)?;
                Some(if scenario.standing_start { driver.with_foot_on_brake() } else { driver })
            }
            false => None,
        };
        let mut episode = Self {
            inputs: config.inputs(),
            horizon: config.learning.horizon_decisions(config.hold()),
            config: config.clone(),
            world,
            driver,
            holds: 0,
            is_over: false,
            takes_orders_only,
            fingerprint: HASH_START,
        };
        episode.world.sync_agents_now()?;
        episode.wait_for_agents()?;
        Ok(episode)
    }

    /// Returns the vehicles that can be advised now: the ego ([`EGO`]) first, then the others by ascending id; none
    /// after the end.
    pub fn agents(&self) -> impl ExactSizeIterator<Item = VehicleId> {
        let ids: Vec<VehicleId> = self.advised().map(Agent::id).collect();
        ids.into_iter()
    }

    /// Returns the observation of each vehicle that can be advised.
    pub fn observations(&self) -> Vec<Observation> {
        self.advised().map(|agent| self.world.complete_observation(agent)).collect()
    }

    /// Returns the agents that can be advised now; none after the end.
    fn advised(&self) -> impl Iterator<Item = &Agent> {
        self.world.agents().filter(|_| !self.is_over)
    }

    /// Scales observations as for training, one row per observation.
    pub fn scaled(&self, seen: impl IntoIterator<Item = Observation>) -> Vec<f32> {
        let row = |seen: Observation| self.inputs.iter().map(move |input| input.scaled(&seen));
        seen.into_iter().flat_map(row).collect()
    }

    /// Runs one hold with these actions, one for each of [`Episode::agents`]: -1 to 1 spans the limits; with levels it
    /// is the number of a level.
    ///
    /// # Errors
    /// The episode is over, an action is invalid, or the traffic engine failed, after which the drive cannot go on.
    pub fn hold(&mut self, actions: &[f32]) -> Result<HoldOutcome, EpisodeError> {
        self.check(actions)?;
        let hold = self.config.hold();
        let actions: Vec<Action> = actions.iter().map(|drawn| action(&self.config.learning, *drawn, hold)).collect();
        for (index, action) in actions.iter().enumerate() {
            self.world.advise(index, *action);
        }
        let begin = |agent: &Agent| Advised {
            id: agent.id(),
            contacts: agent.contact_count(),
            way_mps: 0.0,
            steps: 0,
            // Set when the vehicle leaves or the hold ends.
            last_seen: Observation::default(),
        };
        let mut agents: Vec<Advised> = self.world.agents().map(begin).collect();
        let (measures, has_crashed) = self.drive(&mut agents).inspect_err(|_| self.is_over = true)?;
        let has_left = |id: VehicleId| {
            let is_there = self.world.agents().any(|agent| agent.id() == id);
            !is_there || (id == EGO && self.world.ended().is_some())
        };
        // After a contact, the rest of the hold counts as a standstill.
        let counted = |driven: u32| f64::from(if has_crashed { hold.steps() } else { driven.max(1) });
        let [mean_speed_mps, ..] = measures;
        let reward = &self.config.learning.reward;
        let outcome = |(agent, action): (&Advised, &Action)| {
            let speed_mps = match reward.kind {
                RewardKind::All => mean_speed_mps,
                RewardKind::Ego => agent.way_mps / counted(agent.steps),
            };
            let has_touched = self.contacts_of(agent.id).is_some_and(|contacts| contacts > agent.contacts);
            let collision = if has_touched { reward.collision_penalty } else { 0.0 };
            AgentOutcome {
                id: agent.id,
                reward: speed_mps - self.action_penalty(*action) - collision,
                is_terminated: has_crashed || has_left(agent.id),
                last_seen: agent.last_seen,
            }
        };
        let outcomes: Vec<AgentOutcome> = agents.iter().zip(&actions).map(outcome).collect();
        self.holds += 1;
        let ended = self.world.ended().is_some();
        let mut is_truncated = !has_crashed && (ended || self.holds >= self.horizon);
        self.is_over = has_crashed || is_truncated;
        if !self.is_over {
            self.wait_for_agents()?;
            is_truncated = self.is_over;
        }
        Ok(HoldOutcome { agents: outcomes, measures, is_truncated })
    }

    /// Gives the traffic an order, from the next hold on.
    ///
    /// # Errors
    /// The episode is over, or the order cannot be carried out, in which case nothing has changed.
    pub fn order(&mut self, order: &TrafficOrder) -> Result<(), EpisodeError> {
        if self.is_over {
            return Err(EpisodeError::Over);
        }
        self.world.order(order).map_err(|why| EpisodeError::Order(why.to_string()))
    }

    /// Runs a hold, or less if the drive ends or there is a contact. Returns its measures, and true after a contact.
    fn drive(&mut self, agents: &mut [Advised]) -> Result<([f64; HOLD_MEASURES.len()], bool), RunError> {
        let (mut steps, mut has_crashed) = (0, false);
        let mut measures = HoldMeasures::begin(self.world.scenario().step_s, self.world.snapshot());
        while steps < self.config.hold().steps() && !has_crashed && self.world.ended().is_none() {
            self.step()?;
            steps += 1;
            measures.add(self.world.snapshot());
            self.note(agents);
            has_crashed = self.world.contacts_of_others() + self.contacts_of(EGO).unwrap_or(0) > 0;
        }
        self.see(agents, self.world.agents());
        if has_crashed {
            measures.stand_until(self.config.hold().steps().into());
        } else {
            // Vehicles at the end of their path leave and new ones enter before the next advice is due.
            self.world.sync_agents_now()?;
        }
        Ok((measures.values(), has_crashed))
    }

    /// Adds the speeds of the hold's agents that are still present, and the last observations of those that have left in this step.
    fn note(&self, agents: &mut [Advised]) {
        for now in self.world.agents() {
            let Some(agent) = agents.iter_mut().find(|agent| agent.id == now.id()) else { continue };
            agent.way_mps += now.snapshot().ego.speed_mps.max(0.0);
            agent.steps += 1;
        }
        self.see(agents, self.world.left_others().iter());
    }

    /// Sets what the hold's agents observe last.
    fn see<'a>(&self, agents: &mut [Advised], present: impl Iterator<Item = &'a Agent>) {
        for now in present {
            if let Some(agent) = agents.iter_mut().find(|agent| agent.id == now.id()) {
                agent.last_seen = self.world.complete_observation(now);
            }
        }
    }

    /// Runs one step of the world.
    fn step(&mut self) -> Result<(), RunError> {
        match &mut self.driver {
            Some(driver) => {
                for _ in 0..self.world.scenario().step_ticks() {
                    let controls = driver.controls(&self.world.perceived_by(driver));
                    self.world.tick(&controls)?;
                }
            }
            None => self.world.step()?,
        }
        let others = self.world.advised_others().iter().map(|agent| agent.snapshot());
        self.fingerprint = others.fold(self.world.snapshot().hash(self.fingerprint), |hash, view| view.hash(hash));
        Ok(())
    }

    /// Continues the drive, hold by hold, while there is no vehicle to advise, to the horizon at most; not where none is ever advised.
    fn wait_for_agents(&mut self) -> Result<(), RunError> {
        if self.takes_orders_only {
            return Ok(());
        }
        while self.world.agents().next().is_none() && !self.is_over {
            let (_, has_crashed) = self.drive(&mut [])?;
            self.holds += 1;
            self.is_over = has_crashed || self.world.ended().is_some() || self.holds >= self.horizon;
        }
        Ok(())
    }

    /// Returns the number of contacts that an agent has had, if it is present.
    fn contacts_of(&self, id: VehicleId) -> Option<u32> {
        self.world.agents().find(|agent| agent.id() == id).map(|agent| agent.contact_count())
    }

    /// Returns the penalty for an action, m/s.
    fn action_penalty(&self, action: Action) -> f64 {
        match action {
            Action::Acceleration(a) => {
                self.config.learning.reward.action_penalty * a.abs() / self.config.learning.advice.accel_limit_mps2
            }
            Action::Speed(_) => 0.0,
        }
    }

    fn check(&self, actions: &[f32]) -> Result<(), EpisodeError> {
        if self.is_over {
            return Err(EpisodeError::Over);
        }
        let agents = self.agents();
        if actions.len() != agents.len() {
            return Err(EpisodeError::Count { given: actions.len(), agents: agents.len() });
        }
        let levels = self.config.learning.advice.levels;
        let is_action = |value: f32| match levels {
            0 => value.is_finite(),
            levels => value.fract() == 0.0 && (0.0..levels as f32).contains(&value),
        };
        let Some((agent, value)) = agents.zip(actions.iter().copied()).find(|(_, value)| !is_action(*value)) else {
            return Ok(());
        };
        let allowed = match levels {
            0 => "a finite number; -1 to 1 spans the limits".into(),
            levels => format!("0 to {}", levels - 1),
        };
        Err(EpisodeError::Action { agent, value, allowed })
    }

    /// Checks whether the episode is over, so that no vehicle can be advised any more.
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// Returns the present world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns a hash of all states of all steps so far: equal hashes mean equal bits, except by chance.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }
}

/// Returns the name of an agent; `ego` is the participant's vehicle.
pub fn name(agent: VehicleId) -> String {
    if agent == EGO { "ego".into() } else { format!("vehicle_{}", agent.0) }
}

/// Returns the drivers of the advised vehicles of an episode.
fn drivers(config: &EpisodeConfig, seed: u64) -> AgentDrivers {
    let config = config.clone();
    if !config.draws_drivers {
        return Arc::new(move |_| Ok(driver::named(&config.scenario.driver)?.params));
    }
    Arc::new(move |id| {
        let mut stream = rng::stream(seed, &format!("vehicle/{}/who drives", id.0));
        Ok(config.learning.draw_driver(&mut stream))
    })
}
