//! The observer of a drive, whose view of all vehicles is recorded and drawn, and from which the other agents' views are copied: the
//! participant's vehicle, or none. In: the vehicles of the traffic, and the agents. Out: a [`Snapshot`] and events.

use super::{agent::Agent, derived_state, traffic_coupling::TrafficCoupling};
use crate::{
    ego::EgoState,
    map::RoadMap,
    sim::{Event, Snapshot, VehicleSnapshot, automation::AutomationOrder},
};
use glam::DVec2;
use std::sync::Arc;

/// Position of the ego in views without a participant, metres south and west of the network's bounds.
const AWAY_M: f64 = 1000.0;

/// View of all vehicles in a drive without a participant.
pub(super) struct Spectator {
    view: Snapshot,
    events: Vec<Event>,
}

/// Observer of a drive.
pub(super) enum Observer {
    /// Vehicle of the participant, with its view.
    Participant(Box<Agent>),
    /// View of a drive without a participant, from no vehicle.
    Spectator(Box<Spectator>),
}

impl Observer {
    /// Returns the observer of a drive without a participant.
    pub fn spectator(map: &RoadMap) -> Self {
        let position = (map.network.bounds().0.truncate() - DVec2::splat(AWAY_M)).extend(0.0);
        let ego = EgoState { position, ..EgoState::default() };
        let view = Snapshot { is_without_ego: true, ..derived_state::first_snapshot(&ego, 0.0) };
        Self::Spectator(Box::new(Spectator { view, events: Vec::new() }))
    }

    /// Returns the view of all vehicles.
    pub fn view(&self) -> &Snapshot {
        match self {
            Self::Participant(agent) => &agent.view,
            Self::Spectator(spectator) => &spectator.view,
        }
    }

    pub fn view_mut(&mut self) -> &mut Snapshot {
        match self {
            Self::Participant(agent) => &mut agent.view,
            Self::Spectator(spectator) => &mut spectator.view,
        }
    }

    pub fn events(&self) -> &[Event] {
        match self {
            Self::Participant(agent) => &agent.events,
            Self::Spectator(spectator) => &spectator.events,
        }
    }

    pub fn events_mut(&mut self) -> &mut Vec<Event> {
        match self {
            Self::Participant(agent) => &mut agent.events,
            Self::Spectator(spectator) => &mut spectator.events,
        }
    }

    /// Gives the participant's automation an order of an event.
    pub fn order_automation(&mut self, order: Option<AutomationOrder>) {
        if let (Some(order), Some(participant)) = (order, self.participant_mut()) {
            participant.order_automation(order);
        }
    }

    pub fn participant(&self) -> Option<&Agent> {
        match self {
            Self::Participant(agent) => Some(agent),
            Self::Spectator(_) => None,
        }
    }

    pub fn participant_mut(&mut self) -> Option<&mut Agent> {
        match self {
            Self::Participant(agent) => Some(agent),
            Self::Spectator(_) => None,
        }
    }

    /// Updates another agent in the view to its image.
    pub fn insert_image(&mut self, other: &Agent, traffic: &TrafficCoupling) {
        let s_m = match self {
            Self::Participant(agent) => agent.s_of(&other.image, &other.map),
            Self::Spectator(_) => traffic.s_of(&other.image),
        };
        let cars = &mut self.view_mut().cars;
        if let Ok(at) = cars.binary_search_by_key(&other.id(), |car| car.id) {
            cars[at] = VehicleSnapshot { s_m, ..other.image };
        }
    }

    /// Copies the view, plus the participant's vehicle if present, to an agent of a drive on this map.
    pub fn copy_view_to(&self, agent: &mut Agent, map: &Arc<RoadMap>) {
        agent.copy_view(self.view(), self.participant().map(|participant| &participant.image), map);
    }

    /// Updates the state that follows from all vehicles' poses.
    pub fn update_derived(&mut self) {
        match self {
            Self::Participant(agent) => agent.update_derived(),
            Self::Spectator(spectator) => derived_state::look_at_all(&mut spectator.view),
        }
    }
}
