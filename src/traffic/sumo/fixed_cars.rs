//! A fixed number of cars on a closed route in SUMO. In: a [`FixedSetup`], then reports. Out: commands before a step, and the cars after it.
//! Metres, m/s.
//!
//! SUMO's model drives them in their lanes. Before a step a reported car is put where it is predicted to be at its end, with the speed that
//! it has now: a follower then differs by at most 4.3 mm/s from one behind a car of SUMO's own (docs/decisions.md: 4). Noise is given as a
//! change of the speed that the model starts from. Where SUMO has not the drivers' model, their speeds are computed here and imposed.

use super::{
    lane_keeping,
    options::{self, OTHER_TYPE_IN_FILE},
    shim::Shim,
    shim_data::{Command, RawCommand, Record, Step},
};
use crate::{
    map::{RoadMap, RoutePosition, network::LaneId},
    space::{CAR_LENGTH_M, SumoPose},
    traffic::{
        CarFollowing, FixedSetup, LaneMotion, TrafficDriver, TrafficError, VehicleId, VehicleReport, VehicleState,
        bends::BendSpeeds,
        crossings::self_crossing,
        lane_followers::LaneFollowers,
        motion::{SpeedStep, chosen_mps},
        noise::Noise,
        reported,
        route_vehicles::RouteVehicles,
    },
};
use glam::DVec2;
use std::sync::Arc;

/// Name of the cars' route in SUMO, and of their type where they are alike.
pub(super) const NAME: &str = "codrive";
/// Name of the type of cars with another model.
const OTHER_NAME: &str = "codrive.other-model";
/// SUMO sees a car whose front is up to 2.0 m off the centre of a lane of 3.2 m, on one side further. Whether others see
/// a reported car is decided in [`reported`]; its place for SUMO is no further off than this.
const MAX_OFFSET_M: f64 = 1.5;
/// Lane lengths of a network and a map may differ by rounding, m.
const LENGTH_TOLERANCE_M: f64 = 0.01;

/// The cars and what their models start from.
pub(super) struct FixedCars {
    map: Arc<RoadMap>,
    vehicles: RouteVehicles,
    noise: Noise,
    /// Cars whose model has a noise of its own.
    has_other_model: Vec<bool>,
    /// The speed that SUMO chose for each car in the last step, m/s.
    chosen_mps: Vec<f64>,
    /// The speed that each car's model starts from in the next step, m/s: SUMO's own plus noise.
    start_mps: Vec<f64>,
    /// By number; false of a reported car that has left the lane.
    is_seen: Vec<bool>,
    bends: Option<BendSpeeds>,
    /// Each model's own highest speed, and each car's as SUMO knows it, m/s.
    v0_mps: Vec<f64>,
    highest_mps: Vec<f64>,
    /// Drivers with a model that SUMO has not.
    imposed: Option<ImposedDrivers>,
    /// Cars whose speed was imposed in the last step, by number. SUMO keeps an imposed speed, without regard to others, until it is taken back.
    is_imposed: Vec<bool>,
    /// Places of the reported cars on the route at the end of the present step.
    reported: Vec<RoutePosition>,
}

/// Drivers whose speeds are imposed in every step, and what they choose from.
struct ImposedDrivers {
    followers: LaneFollowers,
    step_s: f64,
    s_m: Vec<f64>,
    speed_mps: Vec<f64>,
    accel_mps2: Vec<f64>,
}

impl ImposedDrivers {
    /// Returns the drivers of a setup, unless SUMO has their model.
    fn of(setup: &FixedSetup, drivers: &[TrafficDriver]) -> Result<Option<Self>, TrafficError> {
        if drivers.iter().all(|driver| matches!(driver.model, CarFollowing::Idm(_))) {
            return Ok(None);
        }
        let route = &setup.map.route;
        if let Some((first_m, second_m)) = self_crossing(route) {
            return Err(TrafficError::RouteMeetsItself { first_m, second_m });
        }
        let zeros = || vec![0.0; drivers.len()];
        let followers = LaneFollowers::new(drivers.to_vec(), BendSpeeds::of(route, setup.lateral_accel_mps2));
        Ok(Some(Self { followers, step_s: setup.step_s, s_m: zeros(), speed_mps: zeros(), accel_mps2: zeros() }))
    }

    /// Returns the speed that a driver has chosen for the end of the step, m/s.
    fn chosen_mps(&self, i: usize) -> f64 {
        chosen_mps(self.speed_mps[i], self.accel_mps2[i], self.step_s)
    }
}

impl FixedCars {
    /// Largest number of commands for a car in a step.
    pub const COMMANDS: usize = 3;

    /// Makes type, route and cars in a SUMO that has just begun and numbered its lanes. Also returns the text that follows SUMO's name in
    /// descriptions.
    pub fn populate(shim: &mut Shim, setup: FixedSetup) -> Result<(Self, String), TrafficError> {
        let route = &setup.map.route;
        lane_keeping::check(&setup.map)?;
        check_lanes(shim, &setup.map)?;
        for lane in lane_keeping::lanes_beside(&setup.map)? {
            shim.close_lane(lane)?;
        }
        shim.add_route(NAME, &options::endless_edges(&setup.map))?;
        let n = setup.cars.len();
        let drivers = setup.drivers.drivers(setup.seed, n);
        let types = options::driver_types(&setup.drivers, &drivers);
        for (name, idm) in &types {
            let base = options::type_in_file(name, idm).unwrap_or_else(|| "DEFAULT_VEHTYPE".into());
            shim.add_type(&base, name, &options::vehicle_type(idm))?;
        }
        let has_other_model = setup.mixture.members(n, setup.seed);
        let others = has_other_model.iter().filter(|has| **has).count();
        let mut description = String::new();
        if others > 0 {
            shim.add_type(OTHER_TYPE_IN_FILE, OTHER_NAME, &options::other_vehicle_type(&types[0].1))?;
            let model = setup.mixture.model.sumo_name();
            description = format!(", {others} of {} other cars by {model}", n - 1);
        }
        for (i, car) in setup.cars.iter().enumerate() {
            let (k, position_m) = route.lane_at(car.s_m);
            let lane = route.lanes()[k].lane.ok_or_else(|| {
                TrafficError::Setup(format!(
                    "vehicle {i} would start at {:.1} m, where the route is not on a lane",
                    car.s_m
                ))
            })?;
            let kind = if has_other_model[i] { OTHER_NAME } else { &types[i.min(types.len() - 1)].0 };
            shim.add((&format!("car{i}"), NAME, kind), lane, position_m, car.speed_mps, true)?;
        }
        let v0_mps: Vec<f64> = drivers.iter().map(|driver| driver.model.desired_speed_mps()).collect();
        let starts_mps: Vec<f64> = setup.cars.iter().map(|car| car.speed_mps).collect();
        let cars = Self {
            vehicles: RouteVehicles::new(&setup.map, &setup.cars, setup.step_s),
            noise: Noise::new(&drivers, setup.step_s, setup.seed),
            imposed: ImposedDrivers::of(&setup, &drivers)?,
            has_other_model,
            chosen_mps: starts_mps.clone(),
            start_mps: starts_mps,
            is_seen: vec![true; n],
            is_imposed: vec![false; n],
            bends: BendSpeeds::of(route, setup.lateral_accel_mps2),
            highest_mps: v0_mps.clone(),
            v0_mps,
            map: setup.map,
            reported: Vec::with_capacity(n),
        };
        let step = shim.look()?;
        for (i, start) in setup.cars.iter().enumerate() {
            let record = record(&step, i)?;
            let (found_m, speed_mps) = (cars.s_of(record)?, record.speed_mps);
            if cars.map.route.difference(start.s_m, found_m).abs() > 1e-6 || speed_mps != start.speed_mps {
                return Err(TrafficError::Setup(format!(
                    "SUMO put vehicle {i} at {found_m:.6} m with {speed_mps} m/s instead of {:.6} m with {} m/s",
                    start.s_m, start.speed_mps
                )));
            }
        }
        Ok((cars, description))
    }

    /// Adds the commands before a step with these reports. A reported car that others do not see is `nowhere`.
    pub fn command(
        &mut self,
        reports: &[VehicleReport],
        motions: &[LaneMotion],
        nowhere: DVec2,
        commands: &mut Vec<RawCommand>,
    ) -> Result<(), TrafficError> {
        reported::check_reports(reports, &self.is_seen)?;
        self.choose_imposed(reports);
        self.reported.clear();
        for report in reports {
            let point = self.command_reported(report, nowhere, commands);
            self.reported.push(point);
        }
        let mut reported = reports.iter().map(|report| report.id.0 as usize).peekable();
        let mut driven = motions.iter().peekable();
        for i in 0..self.vehicles.len() {
            if reported.next_if_eq(&i).is_some() {
                continue;
            }
            let id = VehicleId(i as u32);
            let was_imposed = std::mem::replace(&mut self.is_imposed[i], true);
            if let Some(motion) = driven.next_if(|motion| motion.id == id) {
                commands.push(Command::ImposedSpeed(Some(motion.mean_mps)).encode(id));
                commands.push(Command::PreviousSpeed(self.start_mps[i]).encode(id));
                continue;
            }
            if let Some(imposed) = &self.imposed {
                commands.push(Command::ImposedSpeed(Some(imposed.chosen_mps(i))).encode(id));
                continue;
            }
            self.is_imposed[i] = false;
            if was_imposed {
                commands.push(Command::ImposedSpeed(None).encode(id));
            }
            if let Some(bends) = &self.bends {
                let highest_mps = self.v0_mps[i].min(bends.at(self.vehicles.s_m(i)));
                if highest_mps != self.highest_mps[i] {
                    self.highest_mps[i] = highest_mps;
                    commands.push(Command::MaxSpeed(highest_mps).encode(id));
                }
            }
            if self.start_mps[i] != self.chosen_mps[i] {
                commands.push(Command::PreviousSpeed(self.start_mps[i]).encode(id));
            }
        }
        Ok(())
    }

    /// Lets the drivers with a model that SUMO has not choose their accelerations, all from the present state.
    fn choose_imposed(&mut self, reports: &[VehicleReport]) {
        let Some(imposed) = &mut self.imposed else { return };
        let route = &self.map.route;
        for i in 0..self.vehicles.len() {
            (imposed.s_m[i], imposed.speed_mps[i]) = (self.vehicles.s_m(i), self.start_mps[i]);
        }
        for VehicleReport { id, state, .. } in reports {
            let car = id.0 as usize;
            let point = reported::place(route, &state.pose, self.is_seen[car].then_some(imposed.s_m[car]));
            self.is_seen[car] = reported::is_on_lane(route, point);
            (imposed.s_m[car], imposed.speed_mps[car]) = (point.s_m, state.speed_mps.max(0.0));
        }
        let ImposedDrivers { followers, step_s, s_m, speed_mps, accel_mps2 } = imposed;
        followers.choose(route, *step_s, s_m, speed_mps, &self.is_seen, accel_mps2);
    }

    /// Adds a reported car's commands; returns its place on the route at the step's end.
    fn command_reported(
        &mut self,
        report: &VehicleReport,
        nowhere: DVec2,
        commands: &mut Vec<RawCommand>,
    ) -> RoutePosition {
        let (route, car) = (&self.map.route, report.id.0 as usize);
        let near = self.is_seen[car].then_some(self.vehicles.s_m(car));
        let point = reported::place(route, &report.state.next_pose, near);
        self.is_seen[car] = reported::is_on_lane(route, point);
        let SumoPose { mut front, angle_deg } = report.state.next_pose.to_sumo(CAR_LENGTH_M);
        if !self.is_seen[car] {
            front = nowhere;
        } else if point.offset_m.abs() > MAX_OFFSET_M {
            let left = DVec2::from_angle(route.yaw_at(point.s_m)).perp();
            front = route.point_at(point.s_m) + left * MAX_OFFSET_M.copysign(point.offset_m);
        }
        commands.push(Command::MoveToXy { lane: None, front, angle_deg }.encode(report.id));
        commands.push(Command::PreviousSpeed(report.state.speed_mps.max(0.0)).encode(report.id));
        if std::mem::take(&mut self.is_imposed[car]) {
            commands.push(Command::ImposedSpeed(None).encode(report.id));
        }
        point
    }

    /// Takes the cars after the step that these reports and motions were for.
    pub fn take(
        &mut self,
        step: &Step<'_>,
        reports: &[VehicleReport],
        motions: &[LaneMotion],
    ) -> Result<(), TrafficError> {
        let mut driven = motions.iter().peekable();
        let mut reports = reports.iter().zip(&self.reported).peekable();
        for i in 0..self.vehicles.len() {
            let record = record(step, i)?;
            let chosen_mps = record.speed_mps;
            self.chosen_mps[i] = chosen_mps;
            let noisy_mps = self.noise.push(VehicleId(i as u32), chosen_mps);
            let after_mps = if self.has_other_model[i] { chosen_mps } else { noisy_mps };
            if let Some((report, point)) = reports.next_if(|(report, _)| report.id.0 as usize == i) {
                self.vehicles.follow(i, point.s_m, &report.state);
            } else {
                let (s_m, before_mps) = (self.s_of(record)?, self.start_mps[i]);
                let step = match driven.next_if(|motion| motion.id.0 as usize == i) {
                    Some(motion) => SpeedStep::driven(before_mps, motion),
                    None => SpeedStep { before_mps, chosen_mps, after_mps },
                };
                self.vehicles.set(i, s_m, step);
            }
            self.start_mps[i] = self.vehicles.speed_mps(i);
        }
        Ok(())
    }

    /// Returns a car's front bumper along the route, m.
    fn s_of(&self, record: &Record) -> Result<f64, TrafficError> {
        let lane = usize::try_from(record.lane).ok().map(LaneId::from_index);
        lane.and_then(|lane| self.map.route.s_on(lane, record.lane_pos_m)).ok_or_else(|| {
            let lane = lane.map_or("none", |lane| &self.map.network.lane(lane).id);
            TrafficError::Sumo(format!(
                "vehicle {} is no longer on the route: its front is on lane \"{lane}\", {:.1} m from the start of the \
                 lane\n  remedy: choose edges on which the route keeps its lane (route = [..] in map.toml)",
                record.number, record.lane_pos_m
            ))
        })
    }

    /// Returns all cars, with lanes and poses.
    pub fn states(&mut self) -> &[VehicleState] {
        self.vehicles.states()
    }
}

/// Returns SUMO's record of car `i`.
fn record<'a>(step: &Step<'a>, i: usize) -> Result<&'a Record, TrafficError> {
    let found = step.records.get(i).filter(|record| record.number as usize == i);
    found.ok_or_else(|| TrafficError::Sumo(format!("vehicle {i} is no longer in the simulation")))
}

/// Compares the lanes of the route with SUMO's.
fn check_lanes(shim: &Shim, map: &RoadMap) -> Result<(), TrafficError> {
    for lane in map.route.lanes() {
        let Some(id) = lane.lane else { continue };
        let (length_m, limit_mps) = shim.lane(id)?;
        let differs = |what: String| {
            let name = lane.id(&map.network);
            TrafficError::Setup(format!("SUMO's network differs from map {}: lane {name} {what}", map.name))
        };
        if (length_m - lane.length_m).abs() > LENGTH_TOLERANCE_M {
            return Err(differs(format!("is {length_m} m long instead of {} m", lane.length_m)));
        }
        if (limit_mps - lane.speed_limit_mps).abs() > 1e-3 {
            return Err(differs(format!("has a limit of {limit_mps} m/s instead of {} m/s", lane.speed_limit_mps)));
        }
    }
    Ok(())
}
