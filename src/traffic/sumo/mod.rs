//! SUMO as a traffic engine, in this process (libsumo). In: a [`TrafficSetup`], then
//! reports. Out: [`CarState`]s. Metres, m/s, world axes; SUMO's front bumpers and compass headings stay in here.
//!
//! One call a step takes the commands, steps, and reads all cars. Before a step the ego is put where it is predicted to
//! be at its end, with the speed that it has now: a follower then differs by at most 4.3 mm/s from one behind a car
//! of SUMO's own (docs/decisions.md: 4). Noise is given as a change of the speed that the model starts from.

mod inputs;
mod lane_keeping;
mod locate;
mod network;
mod network_check;
mod network_shim;
mod options;
mod shim;
mod trial_process;

pub use locate::{home, program};
pub use network::{EgoReport, EgoStart, NetworkSetup, SumoNetwork};
pub use network_check::{COMMAND as CHECK_NETWORK, check_networks_by, try_network};
pub use trial_process::tell_waits_by;

use super::{
    CarState, Traffic, TrafficError, TrafficSetup, VehicleId, VehicleReport, bends::BendSpeeds, motion::SpeedStep,
    noise::Noise, reported,
};
use crate::{
    map::{RoadMap, RoutePosition},
    space::{CAR_LENGTH_M, Pose, SumoPose},
};
use glam::{DVec2, dvec2};
use inputs::Inputs;
use network_check::Trial;
use options::{DEFAULT_DELTA, OTHER_TYPE_IN_FILE, TYPE_IN_FILE, TypeFile};
use shim::{Command, CommandKind, Record, Shim};
use std::{path::Path, sync::Arc};

/// Name of the cars' type and route in SUMO.
const NAME: &str = "codrive";
/// Name of the type of cars with another model.
const OTHER_NAME: &str = "codrive.other-model";
/// SUMO sees a car whose front is up to 2.0 m off the centre of a lane of 3.2 m, on one side further. Whether others see
/// a reported car is decided in [`reported`]; SUMO is told no more than this.
const MAX_OFFSET_M: f64 = 1.5;
/// Lane lengths of a network and a map may differ by rounding, metres.
const LENGTH_TOLERANCE_M: f64 = 0.01;

/// SUMO.
pub struct SumoTraffic {
    shim: Shim,
    map: Arc<RoadMap>,
    step_s: f64,
    noise: Noise,
    /// Cars whose model has a noise of its own.
    has_other_model: Vec<bool>,
    commands: Vec<Command>,
    records: Vec<Record>,
    /// The speed that each car's model starts from in the next step, m/s: SUMO's own plus noise.
    start_mps: Vec<f64>,
    cars: Vec<CarState>,
    /// By id; false of a reported car that has left the lane.
    is_seen: Vec<bool>,
    /// Where cars are put while others do not see them.
    nowhere: DVec2,
    description: String,
    bends: Option<BendSpeeds>,
    /// The model's own highest speed, and each car's as SUMO knows it, m/s.
    v0_mps: f64,
    highest_mps: Vec<f64>,
    /// Reports of the present step, each with its place on the route.
    reported: Vec<(VehicleReport, RoutePosition)>,
}

impl SumoTraffic {
    /// SUMO in this process, found by [`home`].
    ///
    /// # Errors
    /// If SUMO is not here or in use, or the setup cannot be simulated.
    pub fn start(setup: TrafficSetup) -> Result<Self, TrafficError> {
        Self::start_from(&home()?, setup)
    }

    /// SUMO in this process, from the SUMO in the folder `home`.
    ///
    /// # Errors
    /// As [`SumoTraffic::start`].
    pub fn start_from(home: &Path, setup: TrafficSetup) -> Result<Self, TrafficError> {
        setup.check()?;
        // Absent is absent, whatever the network is.
        locate::library(home)?;
        let inputs = Inputs::of_network(&setup.map.network, &setup.map.net_file)?;
        network_check::check(home, &Trial::of_network(inputs.net()), &Trial::of_network(&setup.map.net_file))?;
        Self::start_with(home, setup, &inputs)
    }

    /// The same without a look at the network: where SUMO breaks down on it, so does this process.
    fn start_unchecked(home: &Path, setup: TrafficSetup) -> Result<Self, TrafficError> {
        let inputs = Inputs::of_network(&setup.map.network, &setup.map.net_file)?;
        Self::start_with(home, setup, &inputs)
    }

    /// Starts SUMO, which has read its files after that.
    fn start_with(home: &Path, setup: TrafficSetup, inputs: &Inputs) -> Result<Self, TrafficError> {
        setup.check()?;
        let mut shim = Shim::open(home)?;
        let types = TypeFile::of(&setup)?;
        let net = inputs.net().display().to_string();
        let types = types.as_ref().map(TypeFile::path);
        shim.start(&options::options(&net, setup.step_s, types, setup.seed))?;
        let description = format!("{} in process", shim.version()?);
        Self::populate(shim, setup, description)
    }

    /// Type, route and cars in a SUMO that has just begun.
    fn populate(mut shim: Shim, setup: TrafficSetup, description: String) -> Result<Self, TrafficError> {
        let route = &setup.map.route;
        lane_keeping::check(&setup.map)?;
        check_network(&mut shim, &setup.map)?;
        shim.close_lanes(&lane_keeping::lanes_beside(&setup.map)?)?;
        let base = if setup.idm.delta == DEFAULT_DELTA { "DEFAULT_VEHTYPE" } else { TYPE_IN_FILE };
        shim.add_type(base, NAME, &options::vehicle_type(&setup.idm))?;
        shim.add_route(NAME, &options::endless_edges(route))?;
        let n = setup.cars.len();
        let has_other_model = setup.mixture.members(n, setup.seed);
        let others = has_other_model.iter().filter(|has| **has).count();
        let mut description = description;
        if others > 0 {
            shim.add_type(OTHER_TYPE_IN_FILE, OTHER_NAME, &options::other_vehicle_type(&setup.idm))?;
            let model = setup.mixture.model.sumo_name();
            description += &format!(", {others} of {} other cars by {model}", n - 1);
        }
        for (i, car) in setup.cars.iter().enumerate() {
            let (lane, position_m) = route.lane_at(car.s_m);
            let kind = if has_other_model[i] { OTHER_NAME } else { NAME };
            shim.add_car((&format!("car{i}"), NAME, kind), lane, position_m, car.speed_mps)?;
        }
        let corner = route.lanes().iter().flat_map(|lane| &lane.shape).fold(DVec2::MAX, |low, point| low.min(*point));
        let mut traffic = Self {
            noise: Noise::new(&setup),
            has_other_model,
            commands: Vec::with_capacity(3 * n + 2),
            records: vec![Record::default(); n],
            start_mps: setup.cars.iter().map(|car| car.speed_mps).collect(),
            cars: (0..n as u32).map(|id| CarState { id: VehicleId(id), ..CarState::default() }).collect(),
            is_seen: vec![true; n],
            nowhere: corner - dvec2(1000.0, 1000.0),
            step_s: setup.step_s,
            bends: BendSpeeds::of(route, setup.lateral_accel_mps2),
            v0_mps: setup.idm.v0,
            highest_mps: vec![setup.idm.v0; n],
            map: setup.map,
            shim,
            description,
            reported: Vec::with_capacity(n),
        };
        traffic.shim.read(&mut traffic.records)?;
        for (i, start) in setup.cars.iter().enumerate() {
            let speed = start.speed_mps;
            traffic.publish(
                i,
                SpeedStep { before_mps: speed, chosen_mps: traffic.records[i].speed_mps, after_mps: speed },
            )?;
            let found = &traffic.cars[i];
            let miss_m = traffic.map.route.difference(start.s_m, found.s_m).abs();
            if miss_m > 1e-6 || traffic.records[i].speed_mps != start.speed_mps {
                return Err(TrafficError::Setup(format!(
                    "SUMO put car {i} at {:.6} m with {} m/s instead of {:.6} m with {} m/s",
                    found.s_m, traffic.records[i].speed_mps, start.s_m, start.speed_mps
                )));
            }
        }
        Ok(traffic)
    }

    /// From the next step on SUMO drives `car` at this speed without regard to others; `None` gives it back to its model.
    /// Reports do not pass through here: this is the car that they are measured against.
    ///
    /// # Errors
    /// [`TrafficError::NotFinite`].
    pub fn impose_speed(&mut self, car: VehicleId, speed_mps: Option<f64>) -> Result<(), TrafficError> {
        // Speed mode 0 drops every check; 31 is SUMO's default. A negative speed ends the order.
        let (mode, speed_mps) = speed_mps.map_or((31.0, -1.0), |speed_mps| (0.0, speed_mps));
        if !speed_mps.is_finite() {
            return Err(TrafficError::NotFinite { what: "imposed speed", car: car.0, value: speed_mps });
        }
        self.commands.push(Command { car: car.0, kind: CommandKind::SpeedMode, a: mode, b: 0.0, c: 0.0 });
        self.commands.push(Command { car: car.0, kind: CommandKind::Speed, a: speed_mps, b: 0.0, c: 0.0 });
        Ok(())
    }

    /// Where SUMO itself draws a car.
    ///
    /// # Errors
    /// If SUMO failed.
    pub fn drawn_pose(&mut self, car: VehicleId) -> Result<Pose, TrafficError> {
        Ok(Pose::from_sumo(self.shim.pose(car.0)?, CAR_LENGTH_M))
    }

    /// SUMO's step alone: no command, nothing read. For measuring what the rest of [`Traffic::step`] costs; the states
    /// are old until the next full step.
    ///
    /// # Errors
    /// If SUMO failed.
    pub fn bare_step(&mut self) -> Result<(), TrafficError> {
        self.shim.bare_step()
    }

    /// Tells SUMO where a reported car will be and how fast it is.
    fn command_reported(&mut self, report: &VehicleReport) -> RoutePosition {
        let (route, car) = (&self.map.route, report.id.0 as usize);
        let near = self.is_seen[car].then_some(self.cars[car].s_m);
        let point = reported::place(route, &report.state.next_pose, near);
        self.is_seen[car] = reported::is_on_lane(route, point);
        let SumoPose { mut front, angle_deg } = report.state.next_pose.to_sumo(CAR_LENGTH_M);
        if !self.is_seen[car] {
            front = self.nowhere;
        } else if point.offset_m.abs() > MAX_OFFSET_M {
            let left = DVec2::from_angle(route.yaw_at(point.s_m)).perp();
            front = route.point_at(point.s_m) + left * MAX_OFFSET_M.copysign(point.offset_m);
        }
        let kind = CommandKind::MoveToXy;
        self.commands.push(Command { car: report.id.0, kind, a: front.x, b: front.y, c: angle_deg });
        self.command_speed(car, report.state.speed_mps.max(0.0));
        point
    }

    fn command_speed(&mut self, car: usize, speed_mps: f64) {
        self.commands.push(Command { car: car as u32, kind: CommandKind::PreviousSpeed, a: speed_mps, b: 0.0, c: 0.0 });
    }

    /// Tells SUMO how fast the bends let car `i` drive, where that has changed.
    fn command_bend(&mut self, i: usize) {
        let Some(bends) = &self.bends else { return };
        let highest_mps = self.v0_mps.min(bends.at(self.cars[i].s_m));
        if highest_mps != self.highest_mps[i] {
            self.highest_mps[i] = highest_mps;
            self.commands.push(Command { car: i as u32, kind: CommandKind::MaxSpeed, a: highest_mps, b: 0.0, c: 0.0 });
        }
    }

    /// The state of car `i` from its record.
    fn publish(&mut self, i: usize, speed: SpeedStep) -> Result<(), TrafficError> {
        let record = &self.records[i];
        if record.present == 0 {
            return Err(TrafficError::Sumo(format!("car {i} is no longer in the simulation")));
        }
        let route = &self.map.route;
        let Some(lane) = usize::try_from(record.lane).ok().and_then(|lane| route.lanes().get(lane)) else {
            let at = self.shim.pose(i as u32)?.front;
            return Err(TrafficError::Sumo(format!(
                "car {i} is no longer on the route: its front is at x = {:.1}, y = {:.1} m on another lane\n  remedy: choose edges \
                 that one lane each leads along (route = [..] in map.toml)",
                at.x, at.y
            )));
        };
        let car = &mut self.cars[i];
        car.s_m = route.wrap(lane.start_s_m + record.lane_pos_m);
        car.set_motion(speed, self.step_s);
        self.start_mps[i] = speed.after_mps;
        Ok(())
    }
}

/// Numbers the lanes and compares them with the map's.
fn check_network(shim: &mut Shim, map: &RoadMap) -> Result<(), TrafficError> {
    let lanes = map.route.lanes();
    let ids: Vec<String> = lanes.iter().map(|lane| lane.id.clone()).collect();
    shim.set_lanes(&ids)?;
    for (i, lane) in lanes.iter().enumerate() {
        let differs = |what: String| {
            TrafficError::Setup(format!(
                "SUMO's network is not that of map {}: lane {} {what}\n  remedy: report this, with {}",
                map.name,
                lane.id,
                map.net_file.display()
            ))
        };
        let (length_m, limit_mps) = shim.lane(i).map_err(|error| match error {
            TrafficError::Sumo(why) => differs(format!("is missing ({why})")),
            other => other,
        })?;
        if (length_m - lane.length_m).abs() > LENGTH_TOLERANCE_M {
            return Err(differs(format!("is {length_m} m long instead of {} m", lane.length_m)));
        }
        if (limit_mps - lane.speed_limit_mps).abs() > 1e-3 {
            return Err(differs(format!("has a limit of {limit_mps} m/s instead of {} m/s", lane.speed_limit_mps)));
        }
    }
    Ok(())
}

impl Traffic for SumoTraffic {
    fn step(&mut self, reports: &[VehicleReport]) -> Result<(), TrafficError> {
        reported::check_reports(reports, &self.is_seen)?;
        self.reported.clear();
        for report in reports {
            let point = self.command_reported(report);
            self.reported.push((*report, point));
        }
        let mut driven = reports.iter().map(|report| report.id.0 as usize).peekable();
        for i in 0..self.cars.len() {
            if driven.next_if_eq(&i).is_some() {
                continue;
            }
            self.command_bend(i);
            if self.start_mps[i] != self.records[i].speed_mps {
                self.command_speed(i, self.start_mps[i]);
            }
        }
        let stepped = self.shim.frame(&self.commands, self.step_s, &mut self.records);
        self.commands.clear();
        stepped?;
        let mut next = 0;
        for i in 0..self.cars.len() {
            let chosen_mps = self.records[i].speed_mps;
            let noisy_mps = self.noise.push(self.cars[i].id, chosen_mps);
            let after_mps = if self.has_other_model[i] { chosen_mps } else { noisy_mps };
            match self.reported.get(next) {
                Some((report, point)) if i == report.id.0 as usize => {
                    reported::follow(&mut self.cars[i], &report.state, point.s_m, self.step_s);
                    self.start_mps[i] = self.cars[i].speed_mps;
                    next += 1;
                }
                _ => self.publish(i, SpeedStep { before_mps: self.start_mps[i], chosen_mps, after_mps })?,
            }
        }
        Ok(())
    }

    fn cars(&self) -> &[CarState] {
        &self.cars
    }

    fn describe(&self) -> String {
        self.description.clone()
    }
}
