//! The native engine: car-following models on a route of one lane, for training and for fast runs. In: a [`FixedSetup`], on an open
//! route with a [`TrafficLog`], then reports. Out: [`VehicleState`]s. Metres, m/s.
//!
//! All accelerations are computed from one state; then `v' = max(v + a dt, 0)` and `x' = x + v' dt` (docs/references.md: idm), which is
//! also SUMO's update; then the noise is added. The desired speed is `min(v0, limit of the lane)`, as in SUMO.
//!
//! Measured against SUMO: agreement to 1e-11 m over 600 s on both rings, noise included (`tests/traffic`). Two things differ elsewhere:
//! SUMO brakes before a lane with a lower limit, and SUMO sees a leader on the lane after the next only within its braking distance,
//! whereas this engine always sees it.

use super::{
    FixedSetup, LaneMotion, Traffic, TrafficError, TrafficLog, VehicleId, VehicleReport, VehicleState,
    bends::BendSpeeds,
    crossings::self_crossing,
    lane_followers::LaneFollowers,
    motion::{SpeedStep, chosen_mps},
    noise::Noise,
    reported,
    route_vehicles::RouteVehicles,
};
use crate::{map::RoadMap, space::Pose};
use std::sync::Arc;

/// Vehicles on one lane. Nothing is allocated after the start.
#[derive(Clone, Debug)]
pub struct NativeTraffic {
    map: Arc<RoadMap>,
    step_s: f64,
    noise: Noise,
    /// Front bumpers along the route, by id.
    s_m: Vec<f64>,
    speed_mps: Vec<f64>,
    /// Acceleration that the model chose in the last step, without noise.
    accel_mps2: Vec<f64>,
    followers: LaneFollowers,
    /// Visibility to other vehicles, by id; false for an externally driven vehicle that has left the lane.
    is_seen: Vec<bool>,
    vehicles: RouteVehicles,
    /// Motions of the next step.
    motions: Vec<LaneMotion>,
    /// True if the drivers are persons, not all alike.
    has_people: bool,
    /// Vehicles of a log: numbers 1 up to as many as it has. Drivers' choices do not move them.
    log: Option<Arc<TrafficLog>>,
    /// Number of steps so far.
    steps: u64,
}

impl NativeTraffic {
    /// Starts the engine with all vehicles at their initial positions.
    ///
    /// # Errors
    /// The setup cannot be simulated.
    pub fn start(setup: FixedSetup) -> Result<Self, TrafficError> {
        setup.check()?;
        Self::of(setup, None)
    }

    /// Starts the engine on an open route with the vehicles of a log, whose time begins now. Vehicle `i + 1` is the log's vehicle `i`;
    /// the models drive the others.
    ///
    /// # Errors
    /// The setup cannot be simulated.
    pub fn behind(log: Arc<TrafficLog>, setup: FixedSetup) -> Result<Self, TrafficError> {
        setup.check_on_lane()?;
        Self::of(setup, Some(log))
    }

    fn of(setup: FixedSetup, log: Option<Arc<TrafficLog>>) -> Result<Self, TrafficError> {
        setup.check_has_one_model()?;
        if let Some((first_m, second_m)) = self_crossing(&setup.map.route) {
            return Err(TrafficError::RouteMeetsItself { first_m, second_m });
        }
        let n = setup.cars.len();
        let route = &setup.map.route;
        let drivers = setup.drivers.drivers(setup.seed, n);
        Ok(Self {
            noise: Noise::new(&drivers, setup.step_s, setup.seed),
            s_m: setup.cars.iter().map(|start| route.wrap(start.s_m)).collect(),
            speed_mps: setup.cars.iter().map(|start| start.speed_mps).collect(),
            accel_mps2: vec![0.0; n],
            followers: LaneFollowers::new(drivers, BendSpeeds::of(route, setup.lateral_accel_mps2)),
            is_seen: vec![true; n],
            vehicles: RouteVehicles::new(&setup.map, &setup.cars, setup.step_s),
            motions: Vec::with_capacity(n),
            has_people: !setup.drivers.are_alike(),
            log,
            steps: 0,
            map: setup.map,
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

    /// Draws the noise of every vehicle and moves all vehicles without a report.
    fn advance(&mut self, reports: &[VehicleReport]) {
        self.steps += 1;
        let time_s = self.steps as f64 * self.step_s;
        let route = &self.map.route;
        let mut reported = reports.iter().map(|report| report.id.0 as usize).peekable();
        let mut driven = self.motions.iter().peekable();
        for i in 0..self.s_m.len() {
            let before_mps = self.speed_mps[i];
            let chosen_mps = chosen_mps(before_mps, self.accel_mps2[i], self.step_s);
            let after_mps = self.noise.push(VehicleId(i as u32), chosen_mps);
            if reported.next_if_eq(&i).is_some() {
                continue;
            }
            if let Some(log) = self.log.as_ref().filter(|log| (1..=log.vehicles().len()).contains(&i)) {
                let (s_m, after_mps) = log.at(i - 1, time_s);
                (self.s_m[i], self.speed_mps[i]) = (s_m, after_mps);
                self.vehicles.set(i, s_m, SpeedStep { before_mps, chosen_mps: after_mps, after_mps });
                continue;
            }
            let (mean_mps, step) = match driven.next_if(|motion| motion.id.0 as usize == i) {
                Some(motion) => (motion.mean_mps, SpeedStep::driven(before_mps, motion)),
                None => (chosen_mps, SpeedStep { before_mps, chosen_mps, after_mps }),
            };
            self.s_m[i] = route.wrap(self.s_m[i] + mean_mps * self.step_s);
            self.speed_mps[i] = step.after_mps;
            self.vehicles.set(i, self.s_m[i], step);
        }
        self.motions.clear();
    }
}

impl Traffic for NativeTraffic {
    fn step(&mut self, reports: &[VehicleReport]) -> Result<(), TrafficError> {
        reported::check_reports(reports, &self.is_seen)?;
        for VehicleReport { id, state, .. } in reports {
            self.place(id.0 as usize, &state.pose, state.speed_mps);
        }
        let Self { followers, map, s_m, speed_mps, is_seen, accel_mps2, step_s, .. } = self;
        followers.choose(&map.route, *step_s, s_m, speed_mps, is_seen, accel_mps2);
        self.advance(reports);
        for VehicleReport { id, state, .. } in reports {
            let car = id.0 as usize;
            self.place(car, &state.next_pose, state.next_speed_mps);
            self.vehicles.follow(car, self.s_m[car], state);
        }
        Ok(())
    }

    fn drive(&mut self, motions: &[LaneMotion]) -> Result<(), TrafficError> {
        LaneMotion::check_all(motions)?;
        self.motions.clear();
        self.motions.extend_from_slice(motions);
        Ok(())
    }

    fn vehicles(&mut self) -> &[VehicleState] {
        self.vehicles.states()
    }

    fn name_and_version(&self) -> String {
        let model = if self.has_people { "native" } else { "native IDM" };
        if self.log.is_some() { format!("{model} with a log") } else { model.into() }
    }
}
