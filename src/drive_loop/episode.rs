//! An episode: a whole drive that is advised from outside, hold by hold, as a learner needs it. In: an [`EpisodeConfig`], a seed, then at each
//! hold an action for each advised vehicle. Out: who can be advised next and what each of them sees, the rewards of the hold as in training
//! on rings, who has come to an end.
//!
//! Vehicles that come within a hold are advised from the next one on; until then they drive as without advice. Whoever leaves the road is
//! done. The first contact of an advised vehicle ends the episode, as in evaluations: in the rest of that hold all count as standing. While
//! nobody is there to be advised the drive goes on by itself.

use super::{RunError, episode_config::EpisodeConfig};
use crate::{
    controls::Controls,
    driver::{self, SimulatedDriver},
    policy::{Action, NetworkInput, Observation},
    rng,
    sim::{Agent, AgentDrivers, HASH_START, OutsideSettings, World},
    traffic::{EGO, VehicleId},
    train::{RewardKind, rollout::action},
};
use std::sync::Arc;

/// Why a hold cannot be driven.
#[derive(Debug, thiserror::Error)]
pub enum EpisodeError {
    /// The drive cannot begin or go on.
    #[error(transparent)]
    Run(#[from] RunError),
    /// There must be an action for each agent.
    #[error("{given} actions; allowed: {agents}, one for each advised vehicle that is there")]
    Count {
        /// How many were given.
        given: usize,
        /// How many vehicles there are to be advised.
        agents: usize,
    },
    /// An action that is none.
    #[error("the action of {} is {value}; allowed: {allowed}", name(*agent))]
    Action {
        /// Whose.
        agent: VehicleId,
        /// Its value.
        value: f32,
        /// What is allowed.
        allowed: String,
    },
    /// It has ended.
    #[error("the episode is over: begin another")]
    Over,
}

/// What one hold brought to an agent that was there at its beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgentOutcome {
    /// Which.
    pub id: VehicleId,
    /// Mean over the steps, m/s, penalties taken.
    pub reward: f64,
    /// It has left the road, or an advised vehicle has touched another.
    pub is_terminated: bool,
    /// What it sees next; of one that has left, what it saw last.
    pub last_seen: Observation,
}

/// What one hold brought.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HoldOutcome {
    /// Agents that were there at its beginning.
    pub agents: Vec<AgentOutcome>,
    /// Mean speed of all vehicles over the steps, m/s.
    pub mean_speed_mps: f64,
    /// The horizon is reached, or the participant's way is over: nobody is advised any more.
    pub is_truncated: bool,
}

/// An agent during a hold.
struct Advised {
    id: VehicleId,
    contacts: u32,
    way_mps: f64,
    steps: u32,
    last_seen: Observation,
}

/// An episode that has begun.
pub struct Episode {
    config: EpisodeConfig,
    inputs: Vec<NetworkInput>,
    world: World,
    /// The participant's; `None` where there is none.
    driver: Option<SimulatedDriver>,
    holds: u32,
    horizon: u32,
    is_over: bool,
    fingerprint: u64,
}

impl Episode {
    /// Begins the episode of a seed: the world is made, its warm-up driven, and the first advice is due.
    ///
    /// # Errors
    /// The world cannot start or go on, or a driver cannot be simulated.
    pub fn begin(config: &EpisodeConfig, seed: u64) -> Result<Self, RunError> {
        let scenario = config.scenario(seed);
        let drivers = drivers(config, seed);
        let settings =
            OutsideSettings { sees_lanes_beside: config.sees_lanes_beside(), drivers: Some(Arc::clone(&drivers)) };
        let world = World::advised_from_outside(&scenario, settings)?;
        let driver = match scenario.participant {
            true => {
                let driver = SimulatedDriver::new(&drivers(EGO)?, world.ego_params(), seed)?;
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
            fingerprint: HASH_START,
        };
        episode.world.meet_agents()?;
        episode.wait_for_agents()?;
        Ok(episode)
    }

    /// Who can be advised now: the participant's vehicle ([`EGO`]) first, then the others by ascending id; nobody once the episode is over.
    pub fn agents(&self) -> impl ExactSizeIterator<Item = VehicleId> {
        let agents = self.world.agents();
        agents[..if self.is_over { 0 } else { agents.len() }].iter().map(|agent| agent.id())
    }

    /// What each of them sees.
    pub fn observations(&self) -> Vec<Observation> {
        let agents = if self.is_over { &[] } else { self.world.agents() };
        agents.iter().map(|agent| self.world.told(agent)).collect()
    }

    /// Scales what is seen as for training, a row for each.
    pub fn scaled(&self, seen: impl IntoIterator<Item = Observation>) -> Vec<f32> {
        let row = |seen: Observation| self.inputs.iter().map(move |input| input.scaled(&seen));
        seen.into_iter().flat_map(row).collect()
    }

    /// One hold under these actions, one for each of [`Episode::agents`]: -1 to 1 spans the limits, or numbers of levels.
    ///
    /// # Errors
    /// The episode is over, the actions are none, or the traffic engine failed; after that the drive cannot go on.
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
            last_seen: self.world.told(agent),
        };
        let mut agents: Vec<Advised> = self.world.agents().iter().map(begin).collect();
        let (mean_mps, steps, has_crashed) = self.drive(&mut agents).inspect_err(|_| self.is_over = true)?;
        let has_left = |id: VehicleId| {
            let is_there = self.world.agents().iter().any(|agent| agent.id() == id);
            !is_there || (id == EGO && self.world.ended().is_some())
        };
        // What is left of a hold after a contact counts as standing.
        let counted = |driven: u32| f64::from(if has_crashed { hold.steps() } else { driven.max(1) });
        let mean_speed_mps = mean_mps / counted(steps);
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
        Ok(HoldOutcome { agents: outcomes, mean_speed_mps, is_truncated })
    }

    /// Drives a hold, or less where the drive ends or somebody is touched. The sum of the mean speeds of its steps, m/s, how many there
    /// were, and true after a contact.
    fn drive(&mut self, agents: &mut [Advised]) -> Result<(f64, u32, bool), RunError> {
        let (mut sum_mps, mut steps, mut has_crashed) = (0.0, 0, false);
        while steps < self.config.hold().steps() && !has_crashed && self.world.ended().is_none() {
            self.step()?;
            steps += 1;
            sum_mps += self.world.snapshot().mean_speed_mps;
            self.note(agents);
            has_crashed = self.world.contacts_of_others() + self.contacts_of(EGO).unwrap_or(0) > 0;
        }
        if !has_crashed {
            // Whoever has come to the end of the way leaves, and others come, before the next advice is due.
            self.world.meet_agents()?;
        }
        Ok((sum_mps, steps, has_crashed))
    }

    /// Notes how those of a hold drive that are still there, and what they see.
    fn note(&self, agents: &mut [Advised]) {
        for now in self.world.agents() {
            let Some(agent) = agents.iter_mut().find(|agent| agent.id == now.id()) else { continue };
            agent.way_mps += now.snapshot().ego.speed_mps.max(0.0);
            agent.steps += 1;
            agent.last_seen = self.world.told(now);
        }
    }

    /// One step of the world.
    fn step(&mut self) -> Result<(), RunError> {
        for _ in 0..self.world.scenario().step_ticks() {
            let controls = match &mut self.driver {
                Some(driver) => driver.controls(&self.world.perceived_by(driver)),
                None => Controls::default(),
            };
            self.world.tick(&controls)?;
        }
        let others = self.world.advised_others().iter().map(|agent| agent.snapshot());
        self.fingerprint = others.fold(self.world.snapshot().hash(self.fingerprint), |hash, view| view.hash(hash));
        Ok(())
    }

    /// While nobody is there to be advised the drive goes on, hold by hold, to the horizon.
    fn wait_for_agents(&mut self) -> Result<(), RunError> {
        while self.world.agents().is_empty() && !self.is_over {
            let (_, _, has_crashed) = self.drive(&mut [])?;
            self.holds += 1;
            self.is_over = has_crashed || self.world.ended().is_some() || self.holds >= self.horizon;
        }
        Ok(())
    }

    /// How often an agent has begun to touch another, if it is there.
    fn contacts_of(&self, id: VehicleId) -> Option<u32> {
        self.world.agents().iter().find(|agent| agent.id() == id).map(|agent| agent.contact_count())
    }

    /// Taken from the reward for an action, m/s.
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

    /// True once nobody can be advised any more.
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// The world as it is now.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Of all states of all steps so far: equal if and only if (but for chance) every bit of them is.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }
}

/// What an agent is called: `ego` is the participant's vehicle.
pub fn name(agent: VehicleId) -> String {
    if agent == EGO { "ego".into() } else { format!("vehicle_{}", agent.0) }
}

/// Who drives the advised vehicles of an episode.
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
