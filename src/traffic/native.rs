//! The native engine: the IDM on a closed route of one lane, for training and for fast runs. In: a [`FixedSetup`], then reports. Out:
//! [`VehicleState`]s. Metres, m/s.
//!
//! All accelerations are computed from one state; then `v' = max(v + a dt, 0)` and `x' = x + v' dt` (docs/references.md: idm), which is
//! also SUMO's update; then the noise is added. The desired speed is `min(v0, limit of the lane)`, as in SUMO.
//!
//! Measured against SUMO: agreement to 1e-11 m over 600 s on both rings, noise included (`tests/traffic`). Two things differ elsewhere:
//! SUMO brakes before a lane with a lower limit, and SUMO sees a leader on the lane after the next only within its braking distance,
//! whereas this engine always sees it.

use super::{
    CREEP_MPS2, EMERGENCY_BRAKING_MPS2, FixedSetup, Traffic, TrafficError, VehicleId, VehicleReport, VehicleState,
};
use super::{
    bends::BendSpeeds, crossings::self_crossing, motion::SpeedStep, noise::Noise, reported,
    route_vehicles::RouteVehicles,
};
use crate::{
    idm::IdmParams,
    map::RoadMap,
    space::{CAR_LENGTH_M, Pose},
};
use std::sync::Arc;

/// The native IDM ring. Nothing is allocated after the start.
#[derive(Clone, Debug)]
pub struct NativeTraffic {
    map: Arc<RoadMap>,
    idm: IdmParams,
    step_s: f64,
    noise: Noise,
    /// Front bumpers along the route, by id.
    s_m: Vec<f64>,
    speed_mps: Vec<f64>,
    /// Acceleration that the model chose in the last step, without noise.
    accel_mps2: Vec<f64>,
    /// Indices of the vehicles that others see, in driving order.
    order: Vec<usize>,
    /// Visibility to other vehicles, by id; false for an externally driven vehicle that has left the lane.
    is_seen: Vec<bool>,
    vehicles: RouteVehicles,
    bends: Option<BendSpeeds>,
}

impl NativeTraffic {
    /// Starts the engine with all vehicles at their initial positions.
    ///
    /// # Errors
    /// The setup cannot be simulated.
    pub fn start(setup: FixedSetup) -> Result<Self, TrafficError> {
        setup.check()?;
        setup.check_has_one_model()?;
        if let Some((first_m, second_m)) = self_crossing(&setup.map.route) {
            return Err(TrafficError::RouteMeetsItself { first_m, second_m });
        }
        let n = setup.cars.len();
        let route = &setup.map.route;
        Ok(Self {
            noise: Noise::new(&setup),
            s_m: setup.cars.iter().map(|start| route.wrap(start.s_m)).collect(),
            speed_mps: setup.cars.iter().map(|start| start.speed_mps).collect(),
            accel_mps2: vec![0.0; n],
            order: Vec::with_capacity(n),
            is_seen: vec![true; n],
            vehicles: RouteVehicles::new(&setup.map, &setup.cars, setup.step_s),
            bends: BendSpeeds::of(route, setup.lateral_accel_mps2),
            map: setup.map,
            idm: setup.idm,
            step_s: setup.step_s,
        })
    }

    /// Moves a vehicle to a pose and a speed.
    fn place(&mut self, car: usize, pose: &Pose, speed_mps: f64) {
        let near = self.is_seen[car].then_some(self.s_m[car]);
        let point = reported::place(&self.map.route, pose, near);
        self.is_seen[car] = reported::is_on_lane(&self.map.route, point);
        self.s_m[car] = point.s_m;
        self.speed_mps[car] = speed_mps.max(0.0);
    }

    /// Sorts the visible vehicles by position. Needed in every step: vehicles do not overtake, but one that left the lane may return
    /// anywhere.
    fn sort(&mut self) {
        self.order.clear();
        self.order.extend((0..self.s_m.len()).filter(|car| self.is_seen[*car]));
        let s_m = &self.s_m;
        self.order.sort_unstable_by(|&a, &b| s_m[a].total_cmp(&s_m[b]).then(a.cmp(&b)));
    }

    /// Computes the acceleration of every visible vehicle, all from the present state.
    fn choose(&mut self) {
        let route = &self.map.route;
        let mut idm = self.idm;
        for k in 0..self.order.len() {
            let (i, leader) = (self.order[k], self.order[(k + 1) % self.order.len()]);
            idm.v0 = self.idm.v0.min(route.speed_limit_mps(self.s_m[i]));
            let bend_mps = self.bends.as_ref().map_or(f64::INFINITY, |bends| bends.at(self.s_m[i]));
            idm.v0 = idm.v0.min(bend_mps);
            // The leader of the last vehicle in the order is one lap ahead; a single vehicle follows itself.
            let lap_m = if k + 1 == self.order.len() { route.length_m() } else { 0.0 };
            let gap_m = self.s_m[leader] + lap_m - self.s_m[i] - CAR_LENGTH_M;
            let accel = idm.acceleration(self.speed_mps[i], self.speed_mps[leader], gap_m);
            self.accel_mps2[i] = accel.max(-EMERGENCY_BRAKING_MPS2);
            if self.speed_mps[i] + accel * self.step_s > bend_mps {
                // The model approaches a lower desired speed slowly; a driver does not enter a bend too fast.
                let down_mps2 = (bend_mps - self.speed_mps[i]) / self.step_s;
                self.accel_mps2[i] = self.accel_mps2[i].min(down_mps2.max(-idm.b));
            }
        }
    }

    /// Draws the noise of every vehicle and moves all vehicles without a report.
    fn advance(&mut self, reports: &[VehicleReport]) {
        let route = &self.map.route;
        let mut driven = reports.iter().map(|report| report.id.0 as usize).peekable();
        for i in 0..self.s_m.len() {
            let before_mps = self.speed_mps[i];
            let wanted_mps = before_mps + self.accel_mps2[i] * self.step_s;
            let chosen_mps = if wanted_mps < CREEP_MPS2 * self.step_s { 0.0 } else { wanted_mps };
            let after_mps = self.noise.push(VehicleId(i as u32), chosen_mps);
            if driven.next_if_eq(&i).is_some() {
                continue;
            }
            self.s_m[i] = route.wrap(self.s_m[i] + chosen_mps * self.step_s);
            self.speed_mps[i] = after_mps;
            self.vehicles.set(i, self.s_m[i], SpeedStep { before_mps, chosen_mps, after_mps });
        }
    }
}

impl Traffic for NativeTraffic {
    fn step(&mut self, reports: &[VehicleReport]) -> Result<(), TrafficError> {
        reported::check_reports(reports, &self.is_seen)?;
        for VehicleReport { id, state, .. } in reports {
            self.place(id.0 as usize, &state.pose, state.speed_mps);
        }
        self.sort();
        self.choose();
        self.advance(reports);
        for VehicleReport { id, state, .. } in reports {
            let car = id.0 as usize;
            self.place(car, &state.next_pose, state.next_speed_mps);
            self.vehicles.follow(car, self.s_m[car], state);
        }
        Ok(())
    }

    fn vehicles(&mut self) -> &[VehicleState] {
        self.vehicles.states()
    }

    fn name_and_version(&self) -> String {
        "native IDM".to_string()
    }
}
