//! Puts the participant's vehicle back on its lane, for a driver who cannot drive back: off the road, or turned around. In: the request,
//! between two ticks. Out: in the next tick the vehicle is on the lane, in the gap where it left the lane, at the speed of the slower one
//! of its two neighbours. An event records it, so that a replay puts it back at the same tick.

use super::{
    World, WorldError,
    agent::{Agent, AgentBody},
    traffic_start::StartPlace,
};
use crate::{
    scenario::Scenario,
    sim::{Event, EventKind},
    space::CAR_LENGTH_M,
    time::Tick,
};

/// Minimum gap to the vehicles ahead and behind, metres.
const MARGIN_M: f64 = 1.0;
/// Heading error beyond which a vehicle counts as astray, radians.
const ASTRAY_RAD: f64 = 1.0;

/// Reason for not putting the ego back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotPutBack {
    /// The ego is on its lane.
    #[error("the vehicle is on its lane")]
    OnLane,
    /// The gap where the ego left the lane is too short.
    #[error("there is no room on the lane here: try again when the other vehicles have moved on")]
    NoRoom,
    /// The drive is over.
    #[error("the drive is over")]
    Over,
}

impl World {
    /// Returns true if the ego is off its lane or heads away from it.
    pub fn is_astray(&self) -> bool {
        self.observer.participant().is_some_and(Agent::is_astray)
    }

    /// Puts the ego back on its lane in the next tick.
    ///
    /// # Errors
    /// The ego is on its lane, there is no room, or the drive is over.
    pub fn put_back(&mut self) -> Result<(), NotPutBack> {
        if self.ended.is_some() {
            return Err(NotPutBack::Over);
        }
        let astray = self.observer.participant_mut().filter(|agent| agent.is_astray());
        let participant = astray.ok_or(NotPutBack::OnLane)?;
        participant.room().ok_or(NotPutBack::NoRoom)?;
        participant.wants_back = true;
        Ok(())
    }
}

impl Agent {
    fn is_astray(&self) -> bool {
        !self.lane.is_in_lane() || self.lane_hint().heading_error_rad.abs() > ASTRAY_RAD
    }

    /// Puts the vehicle back on its lane if that was requested. Called with the other vehicles at their poses of this tick's end.
    pub(super) fn place_on_lane(&mut self, scenario: &Scenario) -> Result<(), WorldError> {
        if !std::mem::take(&mut self.wants_back) {
            return Ok(());
        }
        let Some((s_m, speed_mps)) = self.room() else { return Ok(()) };
        let start = StartPlace { s_m, speed_mps };
        self.body = AgentBody::full(scenario, &self.map, start, self.view.cars.len())?;
        self.view.ego_s_m = s_m;
        let tick = Tick(self.view.tick.0 + 1);
        self.events.push(Event { tick, kind: EventKind::PutBack { s_m } });
        Ok(())
    }

    /// Returns the position along the route with room for the ego's front, nearest to the present one, and the speed to start with there.
    fn room(&self) -> Option<(f64, f64)> {
        let (route, here_m) = (&self.map.route, self.view.ego_s_m);
        let cars = || self.view.cars.iter().filter_map(|car| Some((car, car.s_m?)));
        // On an open route the distance ahead to vehicles behind is negative.
        let nearest = |ways: &mut dyn Iterator<Item = (f64, f64, f64)>| {
            ways.filter(|(way_m, ..)| *way_m >= 0.0).min_by(|a, b| (a.0 - a.2).total_cmp(&(b.0 - b.2)))
        };
        let ahead = nearest(&mut cars().map(|(car, s_m)| (route.ahead(here_m, s_m), car.speed_mps, car.body.length_m)));
        let behind = nearest(&mut cars().map(|(car, s_m)| (route.ahead(s_m, here_m), car.speed_mps, 0.0)));
        if ahead.is_none() && behind.is_none() {
            return Some((here_m, 0.0));
        }
        // On an open route there may be no vehicle ahead, or none behind.
        let (ahead_m, ahead_mps) = ahead.map_or((f64::INFINITY, 0.0), |(way_m, mps, length_m)| (way_m - length_m, mps));
        let (behind_m, behind_mps) = behind.map_or((f64::INFINITY, 0.0), |(way_m, mps, _)| (way_m, mps));
        let [first_m, last_m] = [CAR_LENGTH_M + MARGIN_M - behind_m, ahead_m - MARGIN_M];
        let s_m = route.wrap(here_m + 0.0_f64.clamp(first_m.min(last_m), last_m));
        (first_m <= last_m).then_some((s_m, ahead_mps.min(behind_mps)))
    }
}
