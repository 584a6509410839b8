//! All vehicles as SUMO has them after a step. In: the columns of a [`Step`]. Out: [`VehicleState`]s by ascending id, which have come and
//! gone, what signals show. Metres, m/s, world axes; SUMO's front bumpers and compass headings stay in here.

use super::shim_data::{Command, RawCommand, Record, Step};
use crate::{
    map::network::LaneId,
    space::{Pose, SumoPose},
    traffic::{
        Articulation, Departure, LaneMotion, TrafficError, VehicleBody, VehicleChanges, VehicleId, VehicleKind,
        VehicleLamps, VehicleReport, VehicleState, articulation::FrontPath, motion::SpeedStep,
    },
};
use glam::dvec2;

/// SUMO's bits of lamps (docs: TraCI, vehicle signalling).
const RIGHT: u32 = 1;
const LEFT: u32 = 1 << 1;
const BOTH: u32 = 1 << 2;
const BRAKE: u32 = 1 << 3;
const EMERGENCY: u32 = (1 << 11) | (1 << 12) | (1 << 13);

/// Distance beyond twice what the speed explains that SUMO moves a vehicle at once, metres.
const JUMP_M: f64 = 1.0;

/// Difference between the wanted speed and SUMO's from which SUMO holds a vehicle back, m/s: far above rounding.
const HELD_BACK_MPS: f64 = 1e-6;

/// SUMO's bits of lamps that are lit.
pub(super) fn lamp_bits(lamps: VehicleLamps) -> u32 {
    let bits = [(lamps.brake, BRAKE), (lamps.left, LEFT), (lamps.right, RIGHT)];
    bits.into_iter().map(|(lit, bit)| if lit { bit } else { 0 }).sum()
}

/// The end of the last step. All lists are by ascending id.
#[derive(Debug, Default)]
pub(super) struct TrafficState {
    pub vehicles: Vec<VehicleState>,
    /// Vehicles at the end of the step before.
    before: Vec<VehicleState>,
    /// Vehicles whose speeds were not their model's in the last step.
    driven: Vec<VehicleId>,
    pub changes: VehicleChanges,
    /// States of all signals, one after the other, and where each begins; one more at the end.
    pub signals: Vec<u8>,
    pub signal_starts: Vec<u32>,
    /// All vehicles that are there, also those that are on no lane now.
    pub known: Vec<KnownVehicle>,
}

/// Vehicle with all that is known of it from its departure on.
#[derive(Debug)]
pub(super) struct KnownVehicle {
    pub id: VehicleId,
    pub body: VehicleBody,
    /// Path of the front of a long vehicle, from its first record on.
    path: Option<FrontPath>,
}

impl KnownVehicle {
    pub fn new(id: VehicleId, body: VehicleBody) -> Self {
        Self { id, body, path: None }
    }

    /// Returns the pose of the vehicle and the headings of its parts, given SUMO's pose after a step.
    fn pose(&mut self, of_sumo: Pose, before: Option<&VehicleState>, farthest_m: f64) -> (Pose, Option<Articulation>) {
        let body = &self.body;
        match (&mut self.path, before) {
            (Some(path), Some(_)) => path.follow(body, &of_sumo, farthest_m),
            (path, _) => *path = FrontPath::of(body, &of_sumo),
        }
        self.path.as_ref().map_or((of_sumo, None), |path| path.pose(body))
    }
}

impl TrafficState {
    /// Takes a step of a population in which vehicles come and go.
    pub fn take(&mut self, step: &Step<'_>, step_s: f64) -> Result<(), TrafficError> {
        self.changes.departed.clear();
        self.changes.arrived.clear();
        for new in step.departures() {
            let text = |text: &std::ffi::CStr| text.to_string_lossy().into_owned();
            let id = VehicleId(new.number);
            let kind = VehicleKind::of_sumo_class(&new.class.to_string_lossy());
            let body = VehicleBody { kind, length_m: new.length_m, width_m: new.width_m, height_m: new.height_m };
            self.known.push(KnownVehicle::new(id, body));
            self.changes.departed.push(Departure { id, name: text(new.name), kind: text(new.kind), body });
        }
        std::mem::swap(&mut self.vehicles, &mut self.before);
        self.vehicles.clear();
        // All three lists are by ascending id: one walk along them.
        let (mut known, mut before) = (self.known.iter_mut().peekable(), self.before.iter().peekable());
        for record in step.records {
            let id = VehicleId(record.number);
            while known.next_if(|other| other.id < id).is_some() {}
            while before.next_if(|other| other.id < id).is_some() {}
            let Some(known) = known.next_if(|other| other.id == id) else {
                return Err(TrafficError::Sumo(format!("vehicle {} appeared without a departure", id.0)));
            };
            let before = before.next_if(|other| other.id == id);
            self.vehicles.push(vehicle(record, known, before, step_s)?);
        }
        self.changes.arrived.extend(step.arrivals.iter().map(|number| VehicleId(*number)));
        if !step.arrivals.is_empty() {
            self.known.retain(|known| step.arrivals.binary_search(&known.id.0).is_err());
        }
        self.take_signals(step);
        Ok(())
    }

    /// Takes what signals show.
    pub fn take_signals(&mut self, step: &Step<'_>) {
        self.signals.clear();
        self.signals.extend_from_slice(step.signals);
        self.signal_starts.clear();
        self.signal_starts.extend_from_slice(step.signal_starts);
    }

    /// Adds the commands for vehicles whose pedals are not SUMO's, and gives those back that have no motion any more. A vehicle that is not there has
    /// none.
    pub fn command(&mut self, motions: &[LaneMotion], commands: &mut Vec<RawCommand>) {
        let is_there = |id: &VehicleId| self.vehicles.binary_search_by_key(id, |vehicle| vehicle.id).is_ok();
        let is_driven = |id: &VehicleId| motions.binary_search_by_key(id, |motion| motion.id).is_ok();
        let ended = self.driven.iter().filter(|id| is_there(id) && !is_driven(id));
        commands.extend(ended.map(|id| Command::WantedSpeed(None).encode(*id)));
        self.driven.clear();
        self.driven.extend(motions.iter().map(|motion| motion.id));
        for motion in motions {
            if let Ok(at) = self.vehicles.binary_search_by_key(&motion.id, |vehicle| vehicle.id) {
                commands.push(Command::PreviousSpeed(self.vehicles[at].speed_mps).encode(motion.id));
                commands.push(Command::WantedSpeed(Some(motion.mean_mps)).encode(motion.id));
            }
        }
    }

    /// Sets the speeds at the end of the step of vehicles that have moved as their drivers wanted. Those that SUMO held back keep its speed.
    pub fn drive(&mut self, motions: &[LaneMotion], step_s: f64) {
        for motion in motions {
            let place = |list: &[VehicleState]| list.binary_search_by_key(&motion.id, |vehicle| vehicle.id);
            if let (Ok(at), Ok(before)) = (place(&self.vehicles), place(&self.before))
                && self.vehicles[at].speed_mps >= motion.mean_mps - HELD_BACK_MPS
            {
                let before_mps = self.before[before].speed_mps;
                self.vehicles[at].set_motion(SpeedStep::driven(before_mps, motion), step_s);
            }
        }
    }

    /// Puts reported vehicles where their reports say they are at the end of the step, wherever SUMO has them.
    pub fn follow(&mut self, reports: &[VehicleReport], step_s: f64) {
        for report in reports {
            if let Ok(at) = self.vehicles.binary_search_by_key(&report.id, |vehicle| vehicle.id) {
                let vehicle = &mut self.vehicles[at];
                vehicle.pose = report.state.next_pose;
                vehicle.speed_mps = report.state.next_speed_mps.max(0.0);
                vehicle.accel_mps2 = (vehicle.speed_mps - report.state.speed_mps.max(0.0)) / step_s;
                vehicle.lamps = report.lamps;
            }
        }
    }
}

/// A vehicle from its record.
fn vehicle(
    record: &Record,
    known: &mut KnownVehicle,
    before: Option<&VehicleState>,
    step_s: f64,
) -> Result<VehicleState, TrafficError> {
    let numbers = [("x", record.x), ("y", record.y), ("heading", record.angle_deg), ("speed", record.speed_mps)];
    if let Some((what, value)) = numbers.into_iter().find(|(_, value)| !value.is_finite()) {
        return Err(TrafficError::NotFinite { what, car: record.number, value });
    }
    let front = SumoPose { front: dvec2(record.x, record.y), angle_deg: record.angle_deg };
    let of_sumo = Pose::from_sumo(front, known.body.length_m);
    let (pose, articulation) = known.pose(of_sumo, before, 2.0 * record.speed_mps * step_s + JUMP_M);
    let lit = |bits: u32| record.lamps & bits != 0;
    Ok(VehicleState {
        id: VehicleId(record.number),
        body: known.body,
        lane: usize::try_from(record.lane).ok().map(LaneId::from_index),
        s_m: record.lane_pos_m,
        offset_m: record.lateral_m,
        pose,
        articulation,
        height_m: record.z,
        speed_mps: record.speed_mps,
        accel_mps2: before.map_or(0.0, |before| (record.speed_mps - before.speed_mps) / step_s),
        lamps: VehicleLamps {
            brake: lit(BRAKE),
            left: lit(LEFT | BOTH),
            right: lit(RIGHT | BOTH),
            emergency: lit(EMERGENCY),
        },
    })
}
