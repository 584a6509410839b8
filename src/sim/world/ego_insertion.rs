//! Insertion of the ego into a network with traffic. In: SUMO at its start, and the ego's start position. Out: SUMO after the warm-up, and
//! the ego's initial speed, or an error without room. Metres, m/s.
//!
//! No vehicle is removed to make room: the ego waits off the road until there is room, as SUMO's own vehicles wait. There is room if the
//! ego touches no vehicle, vehicles behind can slow down to its speed comfortably, and the ego need not brake hard.

use super::hand_over::HandOver;
use crate::{
    driver::{DriverParams, bend_speed_mps},
    map::{PathLanes, RoadMap, network::LaneId},
    scenario::Scenario,
    space::{CAR_LENGTH_M, CAR_WIDTH_M, is_one_road},
    traffic::{self, EGO, ExternalVehicleState, Traffic, TrafficError, VehicleLamps, VehicleReport, VehicleState},
};

/// Start position of the ego, with its map and scenario.
pub(super) struct Insertion<'a> {
    pub map: &'a RoadMap,
    pub lanes: &'a PathLanes,
    pub scenario: &'a Scenario,
    /// Front bumper along the route, metres.
    pub s_m: f64,
    /// True for a start at the highest fitting speed; false for a start at standstill.
    pub is_moving: bool,
}

impl Insertion<'_> {
    /// Runs traffic for the warm-up without the ego, then until there is room on this lane. Returns the ego's speed, m/s, and the waiting
    /// time, seconds.
    ///
    /// SUMO lets a vehicle depart into one that enters in the same step. Therefore the ego is already in place during the last step, and
    /// starts from there if there is still room.
    pub fn warm_up(&self, engine: &mut dyn Traffic, lane: LaneId) -> Result<(f64, f64), TrafficError> {
        let pose = self.map.route.pose_of_front(self.s_m, CAR_LENGTH_M);
        // An ego off all lanes is invisible to the traffic.
        let at = |lane: Option<LaneId>, speed_mps: f64| {
            let state = ExternalVehicleState { pose, speed_mps, next_pose: pose, next_speed_mps: speed_mps };
            [VehicleReport { id: EGO, state, lane, is_wrong_way: false, lamps: VehicleLamps::default() }]
        };
        let (steps, step_s) = (warm_up_steps(self.scenario), self.scenario.step_s);
        for _ in 1..steps {
            traffic::go_on()?;
            engine.step(&at(None, 0.0))?;
        }
        let mut waited_s = 0.0;
        loop {
            traffic::go_on()?;
            let room_mps = self.speed_mps(engine.vehicles());
            engine.step(&at(room_mps.map(|_| lane), room_mps.unwrap_or(0.0)))?;
            if let Some(still_mps) = room_mps.and_then(|_| self.speed_mps(engine.vehicles())) {
                return Ok((still_mps, waited_s));
            }
            if waited_s >= self.scenario.wave_wait_s {
                let edge = self.map.network.edge_of(lane).id.clone();
                return Err(TrafficError::NoRoom { edge, waited_s });
            }
            waited_s += step_s;
        }
    }

    /// Returns the speed at which the ego fits in among these vehicles; `None` without room.
    fn speed_mps(&self, vehicles: &[VehicleState]) -> Option<f64> {
        let (route, idm) = (&self.map.route, &self.scenario.idm);
        let middle = route.pose_of_front(self.s_m, CAR_LENGTH_M).position;
        let mut fits_mps = if self.is_moving { self.free_mps() } else { 0.0 };
        let others = || vehicles.iter().filter(|vehicle| vehicle.id != EGO);
        for vehicle in others() {
            // Longest distance of the centres at which the bumpers touch, for a vehicle at any angle.
            let reach_m = (CAR_LENGTH_M + vehicle.body.length_m) / 2.0;
            let is_level = is_one_road(vehicle.height_m, route.height_m(self.s_m));
            let is_beside = self.offset_m(vehicle) > (CAR_WIDTH_M + vehicle.body.width_m) / 2.0;
            if is_level && !is_beside && vehicle.pose.position.distance(middle) < reach_m + idm.s0 {
                return None;
            }
            if let Some(gap_m) = self.gap_ahead_m(vehicle) {
                let room_m = (gap_m - idm.s0).max(0.0);
                fits_mps = fits_mps.min(room_m / idm.t).min((vehicle.speed_mps.powi(2) + 2.0 * idm.b * room_m).sqrt());
            }
        }
        let is_clear = |vehicle: &VehicleState| {
            let Some(gap_m) = self.gap_behind_m(vehicle) else { return true };
            let slows_m = (vehicle.speed_mps.powi(2) - fits_mps * fits_mps).max(0.0) / (2.0 * idm.b);
            gap_m >= idm.s0 + vehicle.speed_mps * idm.t / 2.0 + slows_m
        };
        others().all(is_clear).then_some(fits_mps)
    }

    /// Returns the initial speed on an empty road: within the limit, comfortable in the bends ahead, and low enough for a comfortable stop
    /// before the first junction.
    fn free_mps(&self) -> f64 {
        let (route, idm) = (&self.map.route, &self.scenario.idm);
        let limit_mps = route.speed_limit_mps(self.s_m).min(idm.v0);
        let (index, at_m) = route.lane_at(self.s_m);
        let to_junction_m = route.lanes()[index].length_m - at_m;
        let bend_mps = bend_speed_mps(&DriverParams::default(), route, self.s_m, limit_mps);
        limit_mps.min(bend_mps).min((2.0 * idm.b * to_junction_m).sqrt())
    }

    /// Returns the lateral distance of a vehicle's centre from the route, metres.
    fn offset_m(&self, vehicle: &VehicleState) -> f64 {
        self.map.route.project(vehicle.pose.position, Some(self.s_m)).offset_m.abs()
    }

    /// Returns the gap to a vehicle ahead on the route, metres.
    fn gap_ahead_m(&self, vehicle: &VehicleState) -> Option<f64> {
        let s_m = vehicle.s_on(self.map, self.lanes, self.s_m)?;
        let ahead_m = self.map.route.difference(self.s_m, s_m);
        (ahead_m >= 0.0).then_some(ahead_m - vehicle.body.length_m)
    }

    /// Returns the gap to a vehicle behind, metres, on the route or on a lane that leads to its start; the latter in a straight line.
    fn gap_behind_m(&self, vehicle: &VehicleState) -> Option<f64> {
        let route = &self.map.route;
        if let Some(s_m) = vehicle.s_on(self.map, self.lanes, self.s_m) {
            let behind_m = -route.difference(self.s_m, s_m);
            return (behind_m > 0.0).then_some(behind_m - CAR_LENGTH_M);
        }
        let before = self.lanes.lanes_before(&self.map.network);
        let leads_here = vehicle.lane.is_some_and(|lane| before.binary_search(&lane).is_ok());
        let rear = route.pose_of_front(self.s_m, CAR_LENGTH_M).rear(CAR_LENGTH_M);
        leads_here.then(|| vehicle.pose.front(vehicle.body.length_m).distance(rear))
    }
}

/// Runs the warm-up of a drive without a participant.
pub(super) fn warm_up_alone(scenario: &Scenario, engine: &mut dyn Traffic) -> Result<(), TrafficError> {
    (0..warm_up_steps(scenario)).try_for_each(|_| {
        traffic::go_on()?;
        engine.step(&[])
    })
}

pub(super) fn warm_up_steps(scenario: &Scenario) -> usize {
    (scenario.warm_up_s / scenario.step_s).round() as usize
}

/// Returns the state of traffic at the ego's insertion.
pub(super) fn hand_over(vehicles: &[VehicleState], speed_mps: f64, waited_s: f64) -> HandOver {
    let speeds = || vehicles.iter().filter(|vehicle| vehicle.id != EGO).map(|vehicle| vehicle.speed_mps);
    let n = speeds().count().max(1) as f64;
    let mean = speeds().sum::<f64>() / n;
    let speed_sd_mps = (speeds().map(|speed| (speed - mean).powi(2)).sum::<f64>() / n).sqrt();
    HandOver { waited_s, speed_sd_mps, speed_mps, is_as_asked: true }
}
