//! The native engine: the IDM on a closed route of one lane, for training and for speed. In: a [`TrafficSetup`], then
//! reports. Out: [`CarState`]s. Metres, m/s.
//!
//! All accelerations come from one state; then `v' = max(v + (a + noise) dt, 0)` and `x' = x + v' dt` (FACTS 2, Flow), which is
//! also SUMO's update. A car wants the speed `min(v0, limit of its lane)`, as SUMO has it; unlike SUMO it does not look
//! ahead to the next lane's limit.

use super::{CarId, CarState, EGO, EMERGENCY_BRAKING_MPS2, EgoReport, Traffic, TrafficError, TrafficSetup};
use super::{ego, lamps, noise::Noise};
use crate::{idm::IdmParams, map::RoadMap, space::CAR_LENGTH_M};
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
    /// What the model chose in the last step, noise left out.
    accel_mps2: Vec<f64>,
    /// Cars that others see, in driving order.
    order: Vec<usize>,
    ego_is_seen: bool,
    cars: Vec<CarState>,
}

impl NativeTraffic {
    /// All cars at their places.
    ///
    /// # Errors
    /// If the setup cannot be simulated.
    pub fn start(setup: TrafficSetup) -> Result<Self, TrafficError> {
        setup.check()?;
        let n = setup.cars.len();
        let mut traffic = Self {
            noise: Noise::new(&setup),
            s_m: setup.cars.iter().map(|car| setup.map.route.wrap(car.s_m)).collect(),
            speed_mps: setup.cars.iter().map(|car| car.speed_mps).collect(),
            accel_mps2: vec![0.0; n],
            order: Vec::with_capacity(n),
            ego_is_seen: true,
            cars: (0..n as u32).map(|id| CarState { id: CarId(id), ..CarState::default() }).collect(),
            map: setup.map,
            idm: setup.idm,
            step_s: setup.step_s,
        };
        for i in 0..n {
            traffic.publish(i, traffic.speed_mps[i]);
        }
        Ok(traffic)
    }

    /// Takes the ego to where the report says it is now.
    fn place_ego(&mut self, report: &EgoReport) {
        let near = self.ego_is_seen.then_some(self.s_m[0]);
        let point = ego::place(&self.map.route, &report.pose, near);
        self.ego_is_seen = ego::is_on_lane(&self.map.route, point);
        self.s_m[0] = point.s_m;
        self.speed_mps[0] = report.speed_mps.max(0.0);
    }

    /// Sorts anew each step: cars do not overtake, but an ego that left the lane may come back anywhere.
    fn sort(&mut self) {
        self.order.clear();
        self.order.extend(usize::from(!self.ego_is_seen)..self.s_m.len());
        let s_m = &self.s_m;
        self.order.sort_unstable_by(|&a, &b| s_m[a].total_cmp(&s_m[b]).then(a.cmp(&b)));
    }

    /// What the model wants of every car, all from the present state.
    fn choose(&mut self) {
        let route = &self.map.route;
        let mut idm = self.idm;
        for k in 0..self.order.len() {
            let (i, leader) = (self.order[k], self.order[(k + 1) % self.order.len()]);
            idm.v0 = self.idm.v0.min(route.speed_limit_mps(self.s_m[i]));
            // The last of the order has its leader one lap on; a car alone follows itself.
            let lap_m = if k + 1 == self.order.len() { route.length_m() } else { 0.0 };
            let gap_m = self.s_m[leader] + lap_m - self.s_m[i] - CAR_LENGTH_M;
            let accel = idm.acceleration(self.speed_mps[i], self.speed_mps[leader], gap_m);
            self.accel_mps2[i] = accel.max(-EMERGENCY_BRAKING_MPS2);
        }
    }

    /// The state of car `i` for others to use; `before_mps` is its speed before the step.
    fn publish(&mut self, i: usize, before_mps: f64) {
        let car = &mut self.cars[i];
        car.s_m = self.s_m[i];
        car.pose = self.map.route.pose_of_front(car.s_m, CAR_LENGTH_M);
        car.speed_mps = self.speed_mps[i];
        car.accel_mps2 = (car.speed_mps - before_mps) / self.step_s;
        car.braking = lamps::lit(before_mps, self.accel_mps2[i], self.step_s);
    }
}

impl Traffic for NativeTraffic {
    fn step(&mut self, report: Option<&EgoReport>) -> Result<(), TrafficError> {
        match report {
            Some(report) => {
                report.check()?;
                self.place_ego(report);
            }
            None if !self.ego_is_seen => return Err(ego::off_the_road()),
            None => {}
        }
        self.sort();
        self.choose();
        for i in 0..self.cars.len() {
            let change_mps = self.noise.draw_mps();
            if i == EGO.0 as usize && report.is_some() {
                continue;
            }
            let before_mps = self.speed_mps[i];
            self.speed_mps[i] = (before_mps + self.accel_mps2[i] * self.step_s + change_mps).max(0.0);
            self.s_m[i] = self.map.route.wrap(self.s_m[i] + self.speed_mps[i] * self.step_s);
            self.publish(i, before_mps);
        }
        if let Some(report) = report {
            let near = self.ego_is_seen.then_some(self.s_m[0]);
            let point = ego::place(&self.map.route, &report.next_pose, near);
            self.ego_is_seen = ego::is_on_lane(&self.map.route, point);
            self.s_m[0] = point.s_m;
            self.speed_mps[0] = report.next_speed_mps.max(0.0);
            self.cars[0] = ego::state(report, point.s_m, self.step_s);
        }
        Ok(())
    }

    fn cars(&self) -> &[CarState] {
        &self.cars
    }

    fn describe(&self) -> String {
        "native IDM".to_string()
    }
}
