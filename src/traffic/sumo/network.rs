//! SUMO in this process on a road network: vehicles come, change lanes, turn, wait at signals and go. In: a [`NetworkSetup`], then once a
//! step where the egos are. Out: all vehicles, who has come and gone, the signals. Metres, m/s, world axes; SUMO's front bumpers and
//! compass headings stay in here.
//!
//! One call a step takes the commands, steps, and reads everything. An ego is put where it is predicted to be at the step's end, with the
//! speed that it has now, as on a ring (docs/decisions.md: 4). Nothing is allocated in a step without departures once there were as many
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

/// A change of lanes takes so long, seconds: 5 to 6 s are the mean of drivers (Toledo 2007).
const LANE_CHANGE_S: f64 = 5.0;
/// SUMO's bits of lamps (docs: TraCI, vehicle signalling).
const RIGHT: u32 = 1;
const LEFT: u32 = 1 << 1;
const BOTH: u32 = 1 << 2;
const BRAKE: u32 = 1 << 3;
const EMERGENCY: u32 = (1 << 11) | (1 << 12) | (1 << 13);

/// Everything that traffic on a network needs to begin.
#[derive(Clone, Debug)]
pub struct NetworkSetup {
    /// The network.
    pub network: Arc<Network>,
    /// File of the network, which messages name.
    pub net_file: PathBuf,
    /// Who comes.
    pub demand: Demand,
    /// Vehicles that persons or simulated drivers move.
    pub egos: Vec<EgoStart>,
    /// Number of the first vehicle, that of the first ego if there is one. A drive without a participant begins with 1, as 0 is theirs.
    pub first_number: u32,
    /// Model of the cars of the demand's flows.
    pub idm: IdmParams,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Time until which the demand may bring so many vehicles and no more, s ([`Demand::horizon_s`]).
    pub until_s: f64,
    /// Seed of everything random in SUMO.
    pub seed: u64,
}

/// Where an ego starts. Its id is its place in the list.
#[derive(Clone, Debug, PartialEq)]
pub struct EgoStart {
    /// The lane.
    pub lane: LaneId,
    /// Front bumper along it, metres.
    pub s_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Edges along which it is expected to drive, that of the lane first: others give way to it, or take theirs, by where it will cross
    /// their path. Empty where nothing is known but the lane.
    pub route: Vec<String>,
}

/// What an ego does in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EgoReport {
    /// Which.
    pub id: VehicleId,
    /// Where it is and will be.
    pub state: ExternalVehicleState,
    /// The lane on which it will be: where lanes cross, SUMO cannot know. `None` beside all lanes: nobody sees it there.
    pub lane: Option<LaneId>,
    /// It heads against that lane's direction. Others are told of one that stands there: SUMO's vehicles know of none that comes towards them.
    pub is_wrong_way: bool,
    /// Its lamps.
    pub lamps: VehicleLamps,
}

/// SUMO on a road network.
pub struct SumoNetwork {
    shim: NetworkShim,
    step_s: f64,
    /// Where an ego is put that nobody shall see.
    nowhere: DVec2,
    commands: Vec<NetworkCommand>,
    state: NetworkState,
    description: String,
    /// SUMO reads on in the demand as the drive goes on.
    inputs: Inputs,
}

/// What there was at the end of the last step. All lists are by ascending id.
#[derive(Debug, Default)]
struct NetworkState {
    vehicles: Vec<NetworkVehicle>,
    /// Those of the step before.
    before: Vec<NetworkVehicle>,
    changes: VehicleChanges,
    /// States of all signals, one after the other, and where each begins; one more at the end.
    signals: Vec<u8>,
    signal_starts: Vec<u32>,
    /// Bodies of all vehicles that are there, those too that are on no lane now.
    bodies: Vec<(VehicleId, VehicleBody)>,
}

impl NetworkSetup {
    /// Writes the files that SUMO reads.
    fn inputs(&self) -> Result<Inputs, TrafficError> {
        let normal = self.network.edges().iter().filter(|edge| edge.kind == EdgeKind::Normal);
        let edges: Vec<&str> = normal.map(|edge| edge.id.as_str()).collect();
        self.demand.check(&edges).map_err(|fault| TrafficError::Setup(fault.to_string()))?;
        Inputs::of_network(&self.network, &self.net_file)?.with_demand(&self.demand, &self.network, self.until_s)
    }
}

impl SumoNetwork {
    /// SUMO in this process, found by [`locate::home`].
    ///
    /// # Errors
    /// SUMO is not here or in use, or it refuses the network or the demand.
    pub fn start(setup: &NetworkSetup) -> Result<Self, TrafficError> {
        let home = locate::home()?;
        locate::library(&home)?;
        let (inputs, has_ego) = (setup.inputs()?, !setup.egos.is_empty());
        let trial = Trial { net_file: inputs.net().into(), demand: inputs.demand_of(&setup.demand), has_ego };
        let named = Trial { net_file: setup.net_file.clone(), demand: setup.demand.clone(), has_ego };
        network_check::check(&home, &trial, &named)?;
        Self::start_with(&home, setup, inputs)
    }

    /// Starts SUMO without a trial in a process of its own, for tests that run in such a process themselves.
    ///
    /// # Errors
    /// As [`SumoNetwork::start`]; where SUMO breaks down, so does this process.
    #[doc(hidden)]
    pub fn start_untried(setup: &NetworkSetup) -> Result<Self, TrafficError> {
        Self::start_unchecked(&locate::home()?, setup)
    }

    /// The same without a look at network and demand: where SUMO breaks down on them, so does this process.
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
            // An ego is where it says, whatever SUMO made of it.
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

    /// A vehicle of the demand becomes an ego: from the next step on it is reported. The edges of its route. One that is reported no more
    /// is given back to SUMO's model.
    ///
    /// # Errors
    /// It is not there.
    pub fn take_over(&mut self, id: VehicleId) -> Result<Vec<String>, TrafficError> {
        self.shim.take(id.0)
    }

    /// The canonical copies of the demand's files that SUMO reads, in their order.
    pub fn demand_files(&self) -> &[PathBuf] {
        &self.inputs.demand().files
    }

    /// All vehicles on the road at the end of the last step, by ascending id.
    pub fn vehicles(&self) -> &[NetworkVehicle] {
        &self.state.vehicles
    }

    /// Who has come and gone in the last step.
    pub fn changes(&self) -> &VehicleChanges {
        &self.state.changes
    }

    /// What the links of a signal are shown, one of SUMO's letters each.
    pub fn signal(&self, id: SignalId) -> &[u8] {
        let [from, to] = [id.index(), id.index() + 1].map(|k| self.state.signal_starts[k] as usize);
        &self.state.signals[from..to]
    }

    /// What all signals show: the letters of all, and where those of each begin; one more at the end.
    pub fn signals(&self) -> (&[u8], &[u32]) {
        (&self.state.signals, &self.state.signal_starts)
    }

    /// What one link of a signal is shown; `None` for one that it has not.
    pub fn light(&self, id: SignalId, link: u32) -> Option<SignalLight> {
        SignalLight::from_letter(*self.signal(id).get(link as usize)?)
    }

    /// Name and version, for recordings and messages.
    pub fn describe(&self) -> &str {
        &self.description
    }

    /// SUMO's step alone: no command, nothing read. For measuring what the rest costs; the states are old until the next full step.
    ///
    /// # Errors
    /// SUMO failed.
    pub fn bare_step(&mut self) -> Result<(), TrafficError> {
        self.shim.shim.bare_step()
    }

    /// All vehicles and signals as they are, without a step: what has come and gone in a bare one.
    ///
    /// # Errors
    /// SUMO failed.
    pub fn read(&mut self) -> Result<(), TrafficError> {
        let seen = self.shim.look()?;
        self.state.take(&seen, self.step_s)
    }

    /// From the next step on SUMO drives a vehicle at this speed without regard to others; `None` gives it back to its model.
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
        // All three lists are by ascending id: one walk along them.
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

/// A vehicle from its record.
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
