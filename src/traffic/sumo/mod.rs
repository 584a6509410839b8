//! SUMO as a traffic engine, in this process (libsumo). In: a [`FixedSetup`] or a [`DemandSetup`], then once a step reports of the vehicles
//! that drivers outside SUMO move. Out: all vehicles, which have come and gone, what signals show. Metres, m/s, world axes; SUMO's front
//! bumpers and compass headings stay in here.
//!
//! One call a step takes the commands, steps, and reads everything. Before a step a reported vehicle is put where it is predicted to be at
//! its end, with the speed that it has now (docs/decisions.md: 4). Nothing is allocated in a step without departures once there were as
//! many vehicles before.
//!
//! `fixed_cars` has a fixed number of cars on a closed route, with noise and bends; `state` what SUMO has after a step; `shim` and
//! `shim_data` the C interface; `inputs`, `options` and `network_check` what SUMO is started with.

mod fixed_cars;
mod inputs;
mod lane_keeping;
mod locate;
mod network_check;
mod options;
mod people;
mod reading_check;
mod shim;
mod shim_data;
mod state;
mod trial_process;

pub use locate::{home, program, version};
pub use network_check::{COMMAND as CHECK_NETWORK, check_networks_by, try_network};
pub use reading_check::{EqualReading, compare_with_sumo};
pub use trial_process::tell_waits_by;

use super::{
    CanonicalDemand, Demand, DemandFault, DemandSetup, Departures, FixedSetup, GUARD, LaneMotion, Leader, Traffic,
    TrafficError, TrafficOrder, VehicleBody, VehicleChanges, VehicleId, VehicleReport, VehicleState, demand::EGO_TYPE,
};
use crate::{
    map::network::{EdgeKind, Network, SignalId, SignalLight},
    space::{CAR_LENGTH_M, Pose, SumoPose},
};
use fixed_cars::{FixedCars, NAME};
use glam::{DVec2, dvec2};
use inputs::Inputs;
use network_check::Trial;
use options::TypeFile;
use people::People;
use shim::Shim;
use shim_data::{Command, RawCommand, Reading};
use state::{KnownVehicle, TrafficState, lamp_bits};
use std::path::Path;

/// Duration of a lane change, s: 5 to 6 s are the mean of drivers (Toledo 2007).
const LANE_CHANGE_S: f64 = 5.0;
/// Place beside the network where vehicles are put that others must not see, m from its corner in both axes.
const AWAY_M: f64 = 1000.0;

/// SUMO in this process.
pub struct SumoTraffic {
    shim: Shim,
    step_s: f64,
    /// Place of a reported vehicle that others do not see.
    nowhere: DVec2,
    commands: Vec<RawCommand>,
    /// Motions of the next step.
    motions: Vec<LaneMotion>,
    state: TrafficState,
    /// The cars, where their number is fixed.
    fixed: Option<FixedCars>,
    /// Persons at the wheels of vehicles that come and go.
    people: Option<People>,
    description: String,
    /// SUMO reads on in the demand as the drive goes on.
    inputs: Inputs,
}

impl DemandSetup {
    /// Writes the files that SUMO reads.
    fn inputs(&self) -> Result<Inputs, TrafficError> {
        let normal = self.network.edges().iter().filter(|edge| edge.kind == EdgeKind::Normal);
        let edges: Vec<&str> = normal.map(|edge| edge.id.as_str()).collect();
        self.demand.check(&edges).map_err(|fault| TrafficError::Setup(fault.to_string()))?;
        Inputs::of_network(&self.network, &self.net_file)?.with_demand(&self.demand, &self.network, self.until_s)
    }

    /// Checks that a vehicle of the files departs within the drive, unless they have none at all.
    fn departs(&self, found: &CanonicalDemand) -> Result<(), TrafficError> {
        let Departures { is_some_due, first_s, last_s } = found.departures;
        let (nearest, at_s) = match (first_s, last_s) {
            (Some(first_s), _) => ("first", first_s),
            (None, Some(last_s)) => ("last", last_s),
            (None, None) => return Ok(()),
        };
        let Some(file) = self.demand.input_files().next().filter(|_| !is_some_due) else { return Ok(()) };
        let (file, begin_s) = (file.clone(), self.demand.begin_s);
        let fault = DemandFault::NoneDeparts { file, nearest, at_s, begin_s };
        Err(TrafficError::Setup(fault.to_string()))
    }
}

impl SumoTraffic {
    /// A fixed number of cars on a closed route, in the SUMO found by [`home`].
    ///
    /// # Errors
    /// If SUMO is not here or in use, or the setup cannot be simulated.
    pub fn start(setup: FixedSetup) -> Result<Self, TrafficError> {
        Self::start_from(&home()?, setup)
    }

    /// A fixed number of cars on a closed route, in the SUMO in the folder `home`.
    ///
    /// # Errors
    /// As [`SumoTraffic::start`].
    pub fn start_from(home: &Path, setup: FixedSetup) -> Result<Self, TrafficError> {
        setup.check()?;
        // Absent is absent, whatever the network is.
        locate::library(home)?;
        let inputs = Inputs::of_network(&setup.map.network, &setup.map.net_file)?;
        network_check::check(home, &Trial::of_network(inputs.net()), &Trial::of_network(&setup.map.net_file))?;
        Self::start_fixed(home, setup, inputs)
    }

    /// Vehicles that come and go on a network, in the SUMO found by [`home`].
    ///
    /// # Errors
    /// SUMO is not here or in use, or it refuses the network or the demand.
    pub fn start_with_demand(setup: &DemandSetup) -> Result<Self, TrafficError> {
        let home = home()?;
        locate::library(&home)?;
        let (inputs, has_ego) = (Self::read_demand(setup)?, !setup.egos.is_empty());
        let trial = Trial { net_file: inputs.net().into(), demand: inputs.demand().demand.clone(), has_ego };
        let named = Trial { net_file: setup.net_file.clone(), demand: setup.demand.clone(), has_ego };
        network_check::check(&home, &trial, &named)?;
        Self::start_demand(&home, setup, inputs, false)
    }

    /// Checks the files of a demand as [`SumoTraffic::start_with_demand`] does before it starts SUMO, which need not be here.
    ///
    /// # Errors
    /// A file is refused, or no vehicle departs.
    pub fn check_demand(setup: &DemandSetup) -> Result<(), TrafficError> {
        Self::read_demand(setup).map(drop)
    }

    fn read_demand(setup: &DemandSetup) -> Result<Inputs, TrafficError> {
        let inputs = setup.inputs()?;
        setup.departs(inputs.demand())?;
        Ok(inputs)
    }

    /// Starts SUMO without a trial in a process of its own, for tests that run in such a process themselves.
    ///
    /// # Errors
    /// As [`SumoTraffic::start_with_demand`]; where SUMO breaks down, so does this process.
    #[doc(hidden)]
    pub fn start_untried(setup: &DemandSetup) -> Result<Self, TrafficError> {
        Self::start_demand(&home()?, setup, setup.inputs()?, true)
    }

    /// Starts SUMO for a fixed number of cars without a trial: where SUMO breaks down on the network, so does this process.
    fn start_fixed_untried(setup: FixedSetup) -> Result<Self, TrafficError> {
        let inputs = Inputs::of_network(&setup.map.network, &setup.map.net_file)?;
        Self::start_fixed(&home()?, setup, inputs)
    }

    fn start_fixed(home: &Path, setup: FixedSetup, inputs: Inputs) -> Result<Self, TrafficError> {
        setup.check()?;
        let mut shim = Shim::open(home)?;
        let types = TypeFile::of(&setup)?;
        let net = inputs.net().display().to_string();
        let types = types.as_ref().map(TypeFile::path);
        shim.start(&options::options(&net, setup.step_s, types, setup.seed))?;
        number(&mut shim, &setup.map.network, Reading { first_number: 0, is_fixed: 1, lateral: 0 })?;
        let (step_s, map) = (setup.step_s, setup.map.clone());
        let commands = FixedCars::COMMANDS * setup.cars.len();
        let (fixed, models) = FixedCars::populate(&mut shim, setup)?;
        let mut traffic = Self::begun(shim, &map.network, step_s, inputs, Some(fixed))?;
        traffic.commands.reserve(commands);
        traffic.description += &models;
        Ok(traffic)
    }

    /// Starts SUMO with a demand. A trial reads all of it at once, and does not go on without a faulty vehicle.
    fn start_demand(home: &Path, setup: &DemandSetup, inputs: Inputs, is_trial: bool) -> Result<Self, TrafficError> {
        let (network, demand) = (&setup.network, inputs.demand());
        let mut shim = Shim::open(home)?;
        let flows = TypeFile::of_demand(&setup.demand, &setup.drivers, demand.defines_default_type)?;
        let files = options::DemandFiles {
            additional: &demand.demand.additional_files,
            routes: &[&[flows.path().to_owned()], demand.demand.files.as_slice()].concat(),
            begin_s: demand.demand.begin_s,
            is_trial,
            ends_at_faults: is_trial && !demand.demand.leave_out_faults,
        };
        let net = inputs.net().display().to_string();
        shim.start(&options::network_options(&net, setup.step_s, &files, LANE_CHANGE_S, setup.seed))?;
        shim.add_type(EGO_TYPE, NAME, &options::vehicle_type(&options::idm_of(&setup.drivers.typical())))?;
        let lateral = u32::from(LANE_CHANGE_S > 0.0);
        number(&mut shim, network, Reading { first_number: setup.first_number, is_fixed: 0, lateral })?;
        let mut known = Vec::new();
        for (k, ego) in setup.egos.iter().enumerate() {
            let name = format!("ego{k}");
            let edge = network.edge_of(ego.lane).id.clone();
            let route = if ego.route.is_empty() { vec![edge] } else { ego.route.clone() };
            shim.add_route(&name, &route)?;
            let id = shim.add((&name, &name, NAME), ego.lane, ego.s_m, ego.speed_mps, false)?;
            known.push(KnownVehicle::new(id, VehicleBody::CAR));
        }
        let mut traffic = Self::begun(shim, network, setup.step_s, inputs, None)?;
        traffic.state.known = known;
        traffic.people = People::of(&setup.drivers, network, setup.step_s, setup.seed);
        traffic.read()?;
        Ok(traffic)
    }

    fn begun(
        shim: Shim,
        network: &Network,
        step_s: f64,
        inputs: Inputs,
        fixed: Option<FixedCars>,
    ) -> Result<Self, TrafficError> {
        let mut state = TrafficState::default();
        state.signal_starts.resize(network.signals().len() + 1, 0);
        Ok(Self {
            description: format!("{} in process", shim.version()?),
            nowhere: network.bounds().0.truncate() - dvec2(AWAY_M, AWAY_M),
            shim,
            step_s,
            commands: Vec::new(),
            motions: Vec::new(),
            state,
            fixed,
            people: None,
            inputs,
        })
    }

    /// Letters that the links of a signal show, one of SUMO's each.
    pub fn signal(&self, id: SignalId) -> &[u8] {
        let [from, to] = [id.index(), id.index() + 1].map(|k| self.state.signal_starts[k] as usize);
        &self.state.signals[from..to]
    }

    /// Light that one link of a signal shows; `None` for a link that it has not.
    pub fn light(&self, id: SignalId, link: u32) -> Option<SignalLight> {
        SignalLight::from_letter(*self.signal(id).get(link as usize)?)
    }

    /// SUMO's step alone: no command, nothing read. For measuring what the rest of [`Traffic::step`] costs; the states
    /// are old until the next full step.
    ///
    /// # Errors
    /// SUMO failed.
    pub fn bare_step(&mut self) -> Result<(), TrafficError> {
        self.shim.bare_step()
    }

    /// Reads all vehicles and signals as they are, without a step: those that have come and gone in a bare one.
    ///
    /// # Errors
    /// SUMO failed.
    pub fn read(&mut self) -> Result<(), TrafficError> {
        let seen = self.shim.look()?;
        match &mut self.fixed {
            Some(_) => self.state.take_signals(&seen),
            None => {
                self.state.take(&seen, self.step_s)?;
                self.come_and_go()?;
            }
        }
        Ok(())
    }

    /// From the next step on SUMO drives a vehicle at this speed without regard to others; `None` gives it back to its model. Reports do
    /// not pass through here: this is the vehicle that they are measured against.
    ///
    /// # Errors
    /// [`TrafficError::NotFinite`].
    pub fn impose_speed(&mut self, id: VehicleId, speed_mps: Option<f64>) -> Result<(), TrafficError> {
        if let Some(value) = speed_mps.filter(|speed_mps| !speed_mps.is_finite()) {
            return Err(TrafficError::NotFinite { what: "imposed speed", car: id.0, value });
        }
        self.commands.push(Command::ImposedSpeed(speed_mps).encode(id));
        Ok(())
    }

    /// Pose at which SUMO itself draws a car.
    ///
    /// # Errors
    /// SUMO failed.
    pub fn drawn_pose(&self, id: VehicleId) -> Result<Pose, TrafficError> {
        Ok(Pose::from_sumo(self.shim.pose(id)?, CAR_LENGTH_M))
    }

    /// Takes the vehicles that have come and gone in the last step.
    fn come_and_go(&mut self) -> Result<(), TrafficError> {
        let VehicleChanges { departed, arrived } = &self.state.changes;
        match &mut self.people {
            Some(people) => people.come_and_go(&mut self.shim, departed, arrived),
            None => Ok(()),
        }
    }

    /// The commands for a reported vehicle on a network.
    fn command(&mut self, report: &VehicleReport) -> Result<(), TrafficError> {
        report.state.check(report.id)?;
        let SumoPose { front, angle_deg } = report.state.next_pose.to_sumo(CAR_LENGTH_M);
        let front = if report.lane.is_some() { front } else { self.nowhere };
        let present_mps = if report.is_wrong_way { 0.0 } else { report.state.speed_mps.max(0.0) };
        let commands = [
            Command::MoveToXy { lane: report.lane, front, angle_deg },
            Command::PreviousSpeed(present_mps),
            Command::Lamps(lamp_bits(report.lamps)),
        ];
        self.commands.extend(commands.map(|command| command.encode(report.id)));
        Ok(())
    }
}

/// Numbers the lanes and signals of a network as it numbers them itself.
fn number(shim: &mut Shim, network: &Network, reading: Reading) -> Result<(), TrafficError> {
    let lanes: Vec<String> = network.lanes().iter().map(|lane| lane.id.clone()).collect();
    let signals: Vec<String> = network.signals().iter().map(|signal| signal.id.clone()).collect();
    shim.number(&lanes, &signals, reading)
}

impl Traffic for SumoTraffic {
    fn step(&mut self, reports: &[VehicleReport]) -> Result<(), TrafficError> {
        match &mut self.fixed {
            Some(fixed) => fixed.command(reports, &self.motions, self.nowhere, &mut self.commands)?,
            None => {
                reports.iter().try_for_each(|report| self.command(report))?;
                self.state.command(&self.motions, &mut self.commands);
            }
        }
        if let Some(people) = &mut self.people {
            people.command(&self.shim, &self.state.vehicles, (reports, &self.motions), &mut self.commands)?;
        }
        let stepped = self.shim.step(&self.commands, self.step_s);
        self.commands.clear();
        let seen = stepped?;
        if let Some(fixed) = &mut self.fixed {
            self.state.take_signals(&seen);
            fixed.take(&seen, reports, &self.motions)?;
            self.motions.clear();
            return Ok(());
        }
        self.state.take(&seen, self.step_s)?;
        self.state.follow(reports, self.step_s);
        self.state.drive(&self.motions, self.step_s);
        self.motions.clear();
        self.come_and_go()
    }

    fn drive(&mut self, motions: &[LaneMotion]) -> Result<(), TrafficError> {
        LaneMotion::check_all(motions)?;
        self.motions.clear();
        self.motions.extend_from_slice(motions);
        Ok(())
    }

    fn vehicles(&mut self) -> &[VehicleState] {
        match &mut self.fixed {
            Some(fixed) => fixed.states(),
            None => &self.state.vehicles,
        }
    }

    fn changes(&self) -> &VehicleChanges {
        &self.state.changes
    }

    fn signals(&self) -> (&[u8], &[u32]) {
        (&self.state.signals, &self.state.signal_starts)
    }

    fn take_over(&mut self, id: VehicleId) -> Result<Vec<String>, TrafficError> {
        self.shim.take(id)
    }

    fn take_pedals(&mut self, id: VehicleId) -> Result<Vec<String>, TrafficError> {
        if let Some(people) = &mut self.people {
            people.leave(id);
        }
        self.shim.set_driver(id, &GUARD)?;
        self.shim.take_pedals(id)
    }

    fn leader(&self, id: VehicleId, reach_m: f64) -> Result<Option<Leader>, TrafficError> {
        self.shim.leader(id, reach_m)
    }

    fn names(&self, id: VehicleId) -> Result<[String; 2], TrafficError> {
        self.shim.names(id)
    }

    fn order(&mut self, order: &TrafficOrder) -> Result<(), TrafficError> {
        match &self.fixed {
            None => self.shim.order(order),
            Some(_) => Err(TrafficError::Setup(
                "a closed route with a fixed number of vehicles takes no orders; a network with a demand does".into(),
            )),
        }
    }

    fn name_and_version(&self) -> String {
        self.description.clone()
    }

    fn demand(&self) -> Option<&Demand> {
        Some(&self.inputs.demand().demand)
    }
}
