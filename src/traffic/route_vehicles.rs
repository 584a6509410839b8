//! A fixed number of vehicles on a closed route, as both engines keep them. In: places along the route and speeds, step by step. Out:
//! [`VehicleState`]s. Poses cost more than the model itself: they are made when they are asked for. Metres, m/s.

use super::{ExternalVehicleState, InitialVehicle, VehicleId, VehicleState, motion::SpeedStep};
use crate::{map::RoadMap, space::CAR_LENGTH_M};
use std::sync::Arc;

/// A fixed number of vehicles, by number from 0.
#[derive(Clone, Debug)]
pub(super) struct RouteVehicles {
    map: Arc<RoadMap>,
    step_s: f64,
    /// Front bumpers along the route, in `0..length_m`.
    s_m: Vec<f64>,
    states: Vec<VehicleState>,
    /// True if lanes and poses in `states` belong to `s_m`.
    is_placed: bool,
}

impl RouteVehicles {
    /// Vehicles at their starting places, for steps of `step_s`.
    pub fn new(map: &Arc<RoadMap>, starts: &[InitialVehicle], step_s: f64) -> Self {
        let state = |id: u32| VehicleState { id: VehicleId(id), ..VehicleState::default() };
        let mut vehicles = Self {
            map: Arc::clone(map),
            step_s,
            s_m: vec![0.0; starts.len()],
            states: (0..starts.len() as u32).map(state).collect(),
            is_placed: false,
        };
        for (i, start) in starts.iter().enumerate() {
            let speed_mps = start.speed_mps;
            let still = SpeedStep { before_mps: speed_mps, chosen_mps: speed_mps, after_mps: speed_mps };
            vehicles.set(i, map.route.wrap(start.s_m), still);
        }
        vehicles
    }

    pub fn len(&self) -> usize {
        self.s_m.len()
    }

    /// Returns a vehicle's front bumper along the route, m.
    pub fn s_m(&self, i: usize) -> f64 {
        self.s_m[i]
    }

    /// Returns a vehicle's speed, m/s.
    pub fn speed_mps(&self, i: usize) -> f64 {
        self.states[i].speed_mps
    }

    /// Takes a vehicle to the end of a step, in which its speed changed so.
    pub fn set(&mut self, i: usize, s_m: f64, speed: SpeedStep) {
        self.s_m[i] = s_m;
        self.states[i].set_motion(speed, self.step_s);
        self.is_placed = false;
    }

    /// Takes a reported vehicle to the end of the step that its report describes, at `s_m`.
    pub fn follow(&mut self, i: usize, s_m: f64, report: &ExternalVehicleState) {
        let next_mps = report.next_speed_mps.max(0.0);
        let before_mps = report.speed_mps.max(0.0);
        self.set(i, s_m, SpeedStep { before_mps, chosen_mps: next_mps, after_mps: next_mps });
    }

    /// Returns all vehicles, with lanes and poses.
    pub fn states(&mut self) -> &[VehicleState] {
        if !self.is_placed {
            let route = &self.map.route;
            for (state, &s_m) in self.states.iter_mut().zip(&self.s_m) {
                let (k, on_lane_m) = route.lane_at(s_m);
                (state.lane, state.s_m) = (route.lanes()[k].lane, on_lane_m);
                state.pose = route.pose_of_front(s_m, CAR_LENGTH_M);
                state.height_m = route.height_m(s_m);
            }
            self.is_placed = true;
        }
        &self.states
    }
}
