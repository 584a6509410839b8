//! SUMO in this process on a road network: vehicles enter, change lanes, turn, wait at signals and leave. In: a [`NetworkSetup`], then the
//! reports of the egos once per step. Out: all vehicles, departures and arrivals, and the signals. Metres, m/s, world axes; SUMO's front
//! bumper positions and compass headings do not leave this module.
//!
//! One call per step executes the commands, steps, and reads everything. An ego is put at its predicted position for the end of the step,
//! with its present speed, as on a ring (docs/decisions.md: 4). A step without departures allocates no memory once there were as many
//! vehicles before.

use super::{
    inputs::Inputs,
    locate,
    network_check::{self, Trial},
    network_shim::{NetworkCommand, NetworkCommandKind, NetworkRecord, NetworkShim, NetworkStep},
    options::{self, TypeFile},
    shim::Shim,
};
use crate::{
    idm::IdmParams,
    map::network::{EdgeKind, LaneId, Network, SignalId, SignalLight},
    space::{CAR_LENGTH_M, Pose, SumoPose},
    traffic::{
        Demand, Departure, ExternalVehicleState, NetworkVehicle, TrafficError, VehicleBody, VehicleChanges, VehicleId,
        VehicleKind, VehicleLamps,
    },
};
use glam::{DVec2, dvec2};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// Duration of a lane change, seconds: drivers take 5 to 6 s on average (Toledo 2007).
const LANE_CHANGE_S: f64 = 5.0;
/// SUMO's bits for vehicle lamps (docs: TraCI, vehicle signalling).
const RIGHT: u32 = 1;
const LEFT: u32 = 1 << 1;
const BOTH: u32 = 1 << 2;
const BRAKE: u32 = 1 << 3;
const EMERGENCY: u32 = (1 << 11) | (1 << 12) | (1 << 13);

/// Start settings of traffic on a network.
#[derive(Clone, Debug)]
pub struct NetworkSetup {
    pub network: Arc<Network>,
    /// File of the network, for messages.
    pub net_file: PathBuf,
    pub demand: Demand,
    /// Vehicles that people or simulated drivers move.
    pub egos: Vec<EgoStart>,
    /// Number of the first vehicle, which is the first ego if there is one. A drive without a participant starts at 1, because 0 is the
    /// participant's number.
    pub first_number: u32,
    /// Car-following parameters of the egos and of the cars in the demand's flows.
    pub idm: IdmParams,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Time until which the vehicles of the demand are counted and limited, s ([`Demand::horizon_s`]).
    pub until_s: f64,
    /// Seed of all random numbers in SUMO.
    pub seed: u64,
}

/// Start of an ego. Its id is its index in the list.
#[derive(Clone, Debug, PartialEq)]
pub struct EgoStart {
    pub lane: LaneId,
    /// Front bumper along the lane, metres.
    pub s_m: f64,
    pub speed_mps: f64,
    /// Ids of the edges of the expected route, starting with the edge of the lane. Other vehicles give way or go according to where the ego
    /// will cross their path. Empty if only the lane is known.
    pub route: Vec<String>,
}

/// Report of an ego in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EgoReport {
    pub id: VehicleId,
    /// State at present and as predicted for the end of the step.
    pub state: ExternalVehicleState,
    /// Lane at the end of the step: SUMO cannot determine it where lanes cross. `None` off all lanes: no vehicle sees the ego there.
    pub lane: Option<LaneId>,
    /// True if the ego heads against the lane's direction. SUMO then gets a speed of 0, because SUMO's vehicles do not react to oncoming
    /// ones.
    pub is_wrong_way: bool,
    pub lamps: VehicleLamps,
}

/// SUMO on a road network.
pub struct SumoNetwork {
    shim: NetworkShim,
    step_s: f64,
    /// Position outside the network for an ego that others must not see.
    nowhere: DVec2,
    commands: Vec<NetworkCommand>,
    state: NetworkState,
    description: String,
    /// Input files, kept because SUMO reads the demand as the drive goes on.
    inputs: Inputs,
}

/// State at the end of the last step. All lists are by ascending id.
#[derive(Debug, Default)]
struct NetworkState {
    vehicles: Vec<NetworkVehicle>,
    /// Vehicles at the end of the step before.
    before: Vec<NetworkVehicle>,
    changes: VehicleChanges,
    /// States of all signals in sequence. `signal_starts` has the start of each signal and, as its last entry, the total length.
    signals: Vec<u8>,
    signal_starts: Vec<u32>,
    /// Bodies of all vehicles in the simulation, including those that are on no lane now.
    bodies: Vec<(VehicleId, VehicleBody)>,
}

impl NetworkSetup {
    /// Checks the flows and writes the files that SUMO reads.
    fn inputs(&self) -> Result<Inputs, TrafficError> {
        let normal = self.network.edges().iter().filter(|edge| edge.kind == EdgeKind::Normal);
        let edges: Vec<&str> = normal.map(|edge| edge.id.as_str()).collect();
        self.demand.check(&edges).map_err(|fault| TrafficError::Setup(fault.to_string()))?;
        Inputs::of_network(&self.network, &self.net_file)?.with_demand(&self.demand, &self.network, self.until_s)
    }
}

impl SumoNetwork {
    /// Starts SUMO in this process, from the folder that [`locate::home`] finds.
    ///
    /// # Errors
    /// SUMO is absent or in use, or it refuses the network or the demand.
    pub fn start(setup: &NetworkSetup) -> Result<Self, TrafficError> {
        let home = locate::home()?;
        locate::library(&home)?;
        let (inputs, has_ego) = (setup.inputs()?, !setup.egos.is_empty());
        let trial = Trial { net_file: inputs.net().into(), demand: inputs.demand_of(&setup.demand), has_ego };
        let named = Trial { net_file: setup.net_file.clone(), demand: setup.demand.clone(), has_ego };
        network_check::check(&home, &trial, &named)?;
        Self::start_with(&home, setup, inputs)
    }

    /// Starts SUMO without a trial in a child process, for tests that run in such a process themselves.
    ///
    /// # Errors
    /// As [`SumoNetwork::start`]. If SUMO crashes, so does this process.
    #[doc(hidden)]
    pub fn start_untried(setup: &NetworkSetup) -> Result<Self, TrafficError> {
        Self::start_unchecked(&locate::home()?, setup)
    }

    /// Starts SUMO without a trial of network and demand in a child process: if SUMO crashes on them, so does this process.
    pub(super) fn start_unchecked(home: &Path, setup: &NetworkSetup) -> Result<Self, TrafficError> {
        Self::start_with(home, setup, setup.inputs()?)
    }

    fn start_with(home: &Path, setup: &NetworkSetup, inputs: Inputs) -> Result<Self, TrafficError> {
        let (network, demand) = (&setup.network, inputs.demand());
        let mut shim = Shim::open(home)?;
        let flows = TypeFile::of_demand(&setup.demand, &setup.idm, demand.defines_default_type)?;
        let routes: Vec<&Path> =
            std::iter::once(flows.path()).chain(demand.files.iter().map(PathBuf::as_path)).collect();
        let net = inputs.net().display().to_string();
        shim.start(&options::network_options(&net, setup.step_s, &routes, LANE_CHANGE_S, setup.seed))?;
        let description = format!("{} in process", shim.version()?);
        shim.add_type("DEFAULT_VEHTYPE", super::NAME, &options::vehicle_type(&setup.idm))?;
        let lanes: Vec<String> = network.lanes().iter().map(|lane| lane.id.clone()).collect();
        let signals: Vec<String> = network.signals().iter().map(|signal| signal.id.clone()).collect();
        let mut shim = NetworkShim::begin(shim, &lanes, &signals, (LANE_CHANGE_S > 0.0, setup.first_number))?;
        for (k, ego) in setup.egos.iter().enumerate() {
            let name = format!("ego{k}");
            let edge = network.edge_of(ego.lane).id.clone();
            let route = if ego.route.is_empty() { vec![edge] } else { ego.route.clone() };
            shim.shim.add_route(&name, &route)?;
            shim.add((&name, &name, super::NAME), ego.lane.index(), ego.s_m, ego.speed_mps)?;
        }
        let mut traffic = Self {
            step_s: setup.step_s,
            nowhere: network.bounds().0.truncate() - dvec2(1000.0, 1000.0),
            commands: Vec::new(),
            state: NetworkState {
                bodies: (0..setup.egos.len() as u32).map(|k| (VehicleId(k), VehicleBody::CAR)).collect(),
                ..NetworkState::default()
            },
            description,
            inputs,
            shim,
        };
        traffic.read()?;
        Ok(traffic)
    }

    /// Advances by one step, with a report of each ego that a person or a simulated driver moves; SUMO's model drives the others.
    ///
    /// # Errors
    /// SUMO failed, or a number is not finite; the drive cannot go on.
    pub fn step(&mut self, egos: &[EgoReport]) -> Result<(), TrafficError> {
        for ego in egos {
            self.command(ego)?;
        }
        let seen = self.shim.step(&self.commands, self.step_s)?;
        self.commands.clear();
        self.state.take(&seen, self.step_s)?;
        for ego in egos {
            // The report determines the state of an ego, whatever SUMO computed.
            let vehicles = &mut self.state.vehicles;
            if let Ok(at) = vehicles.binary_search_by_key(&ego.id, |vehicle| vehicle.id) {
                let vehicle = &mut vehicles[at];
                vehicle.pose = ego.state.next_pose;
                vehicle.speed_mps = ego.state.next_speed_mps.max(0.0);
                vehicle.accel_mps2 = (vehicle.speed_mps - ego.state.speed_mps.max(0.0)) / self.step_s;
                vehicle.lamps = ego.lamps;
            }
        }
        Ok(())
    }

    /// Makes a vehicle of the demand an ego, reported from the next step on, and returns the edges of its route. SUMO's model drives it
    /// again when its reports end.
    ///
    /// # Errors
    /// The vehicle is not in the simulation.
    pub fn take_over(&mut self, id: VehicleId) -> Result<Vec<String>, TrafficError> {
        self.shim.take(id.0)
    }

    /// Returns the canonical copies of the demand's files that SUMO reads, in the order of the files.
    pub fn demand_files(&self) -> &[PathBuf] {
        &self.inputs.demand().files
    }

    /// Returns all vehicles on the road at the end of the last step, by ascending id.
    pub fn vehicles(&self) -> &[NetworkVehicle] {
        &self.state.vehicles
    }

    /// Returns the departures and arrivals of the last step.
    pub fn changes(&self) -> &VehicleChanges {
        &self.state.changes
    }

    /// Returns the state of a signal, one of SUMO's letters per link.
    pub fn signal(&self, id: SignalId) -> &[u8] {
        let [from, to] = [id.index(), id.index() + 1].map(|k| self.state.signal_starts[k] as usize);
        &self.state.signals[from..to]
    }

    /// Returns the states of all signals in sequence, and the start of each signal with the total length as the last entry.
    pub fn signals(&self) -> (&[u8], &[u32]) {
        (&self.state.signals, &self.state.signal_starts)
    }

    /// Returns the light for one link of a signal; `None` if the signal has no such link.
    pub fn light(&self, id: SignalId, link: u32) -> Option<SignalLight> {
        SignalLight::from_letter(*self.signal(id).get(link as usize)?)
    }

    /// Returns name and version, for recordings and messages.
    pub fn describe(&self) -> &str {
        &self.description
    }

    /// Runs SUMO's step alone: no command, no reading. Serves to measure the cost of the rest. The states are outdated until the next full
    /// step.
    ///
    /// # Errors
    /// SUMO failed.
    pub fn bare_step(&mut self) -> Result<(), TrafficError> {
        self.shim.shim.bare_step()
    }

    /// Reads all vehicles and signals without a step, with the departures and arrivals of a bare step.
    ///
    /// # Errors
    /// SUMO failed.
    pub fn read(&mut self) -> Result<(), TrafficError> {
        let seen = self.shim.look()?;
        self.state.take(&seen, self.step_s)
    }

    /// Makes SUMO drive a vehicle at this speed from the next step on, regardless of others; `None` returns it to its model.
    ///
    /// # Errors
    /// [`TrafficError::NotFinite`].
    pub fn impose_speed(&mut self, id: VehicleId, speed_mps: Option<f64>) -> Result<(), TrafficError> {
        let (mode, speed_mps) = speed_mps.map_or((31.0, -1.0), |speed_mps| (0.0, speed_mps));
        if !speed_mps.is_finite() {
            return Err(TrafficError::NotFinite { what: "imposed speed", car: id.0, value: speed_mps });
        }
        self.push(id, NetworkCommandKind::SpeedMode, -1, [mode, 0.0, 0.0]);
        self.push(id, NetworkCommandKind::Speed, -1, [speed_mps, 0.0, 0.0]);
        Ok(())
    }

    fn command(&mut self, ego: &EgoReport) -> Result<(), TrafficError> {
        ego.state.check(ego.id)?;
        let SumoPose { mut front, angle_deg } = ego.state.next_pose.to_sumo(CAR_LENGTH_M);
        let lane = ego.lane.map_or(-1, |lane| lane.index() as i32);
        if ego.lane.is_none() {
            front = self.nowhere;
        }
        self.push(ego.id, NetworkCommandKind::MoveToXy, lane, [front.x, front.y, angle_deg]);
        let told_mps = if ego.is_wrong_way { 0.0 } else { ego.state.speed_mps.max(0.0) };
        self.push(ego.id, NetworkCommandKind::PreviousSpeed, -1, [told_mps, 0.0, 0.0]);
        let VehicleLamps { brake, left, right, .. } = ego.lamps;
        let bits = [(brake, BRAKE), (left, LEFT), (right, RIGHT)];
        let lamps: u32 = bits.into_iter().map(|(lit, bit)| if lit { bit } else { 0 }).sum();
        self.push(ego.id, NetworkCommandKind::Lamps, -1, [lamps.into(), 0.0, 0.0]);
        Ok(())
    }

    fn push(&mut self, id: VehicleId, kind: NetworkCommandKind, lane: i32, [a, b, c]: [f64; 3]) {
        self.commands.push(NetworkCommand { vehicle: id.0, kind, lane, a, b, c });
    }
}

impl NetworkState {
    fn take(&mut self, seen: &NetworkStep<'_>, step_s: f64) -> Result<(), TrafficError> {
        self.changes.departed.clear();
        self.changes.arrived.clear();
        for new in seen.departures() {
            let text = |text: &std::ffi::CStr| text.to_string_lossy().into_owned();
            let id = VehicleId(new.number);
            let kind = VehicleKind::of_sumo_class(&new.class.to_string_lossy());
            let body = VehicleBody { kind, length_m: new.length_m, width_m: new.width_m, height_m: new.height_m };
            self.bodies.push((id, body));
            self.changes.departed.push(Departure { id, name: text(new.name), kind: text(new.kind), body });
        }
        std::mem::swap(&mut self.vehicles, &mut self.before);
        self.vehicles.clear();
        // All three lists are by ascending id, so one pass is enough.
        let (mut bodies, mut before) = (self.bodies.iter().peekable(), self.before.iter().peekable());
        for record in seen.records {
            let id = VehicleId(record.number);
            while bodies.next_if(|(other, _)| *other < id).is_some() {}
            while before.next_if(|other| other.id < id).is_some() {}
            let Some((_, body)) = bodies.next_if(|(other, _)| *other == id) else {
                return Err(TrafficError::Sumo(format!("vehicle {} was never told of", id.0)));
            };
            let before = before.next_if(|other| other.id == id);
            self.vehicles.push(vehicle(record, *body, before, step_s)?);
        }
        self.changes.arrived.extend(seen.arrivals.iter().map(|number| VehicleId(*number)));
        if !seen.arrivals.is_empty() {
            self.bodies.retain(|(id, _)| seen.arrivals.binary_search(&id.0).is_err());
        }
        self.signals.clear();
        self.signals.extend_from_slice(seen.signals);
        self.signal_starts.clear();
        self.signal_starts.extend_from_slice(seen.signal_starts);
        Ok(())
    }
}

/// Converts a record to a vehicle.
fn vehicle(
    record: &NetworkRecord,
    body: VehicleBody,
    before: Option<&NetworkVehicle>,
    step_s: f64,
) -> Result<NetworkVehicle, TrafficError> {
    let numbers = [("x", record.x), ("y", record.y), ("heading", record.angle_deg), ("speed", record.speed_mps)];
    if let Some((what, value)) = numbers.into_iter().find(|(_, value)| !value.is_finite()) {
        return Err(TrafficError::NotFinite { what, car: record.number, value });
    }
    let front = SumoPose { front: dvec2(record.x, record.y), angle_deg: record.angle_deg };
    let lit = |bits: u32| record.lamps & bits != 0;
    Ok(NetworkVehicle {
        id: VehicleId(record.number),
        body,
        lane: usize::try_from(record.lane).ok().map(LaneId::from_index),
        s_m: record.lane_pos_m,
        offset_m: record.lateral_m,
        pose: Pose::from_sumo(front, body.length_m),
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
