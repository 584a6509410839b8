//! Traffic: all other vehicles. In: a [`FixedSetup`] or a [`DemandSetup`], then once per step the reports of externally driven vehicles.
//! Out: the state of every vehicle at the end of the step. Two engines implement [`Traffic`]: SUMO and the native IDM ring. Only
//! `traffic::sumo` depends on SUMO.

mod bends;
mod choice;
mod crossings;
mod demand;
mod demand_count;
mod demand_file;
mod interrupt;
mod mixture;
mod motion;
mod native;
mod noise;
mod reported;
mod route_vehicles;
pub mod start;
pub mod sumo;
mod vehicles;

pub use choice::{EngineChoice, UnknownEngine};
pub use demand::{Demand, DemandFault, Flow, KindShare};
pub use demand_file::CanonicalDemand;
pub use interrupt::{Interruption, TrafficStart, go_on, interrupt, is_interrupted, starts_under_way};
pub use mixture::{FollowingModel, ModelMixture};
pub use native::NativeTraffic;
pub use reported::is_on_lane;
pub use vehicles::{Departure, VehicleBody, VehicleChanges, VehicleKind, VehicleLamps, VehicleState};

use crate::{
    idm::IdmParams,
    map::{
        RoadMap,
        network::{LaneId, Network},
    },
    space::Pose,
};
use std::{path::PathBuf, sync::Arc};

/// Hardest braking of any vehicle of the traffic, m/s2 (SUMO's default for passenger cars). The model is never clipped at `b`
/// (docs/references.md: idm); it reaches this bound only behind an ego that cuts in or stops suddenly.
pub const EMERGENCY_BRAKING_MPS2: f64 = 9.0;

/// Creep limit, m/s2: SUMO rounds a speed below this times the step length to 0. Without this rule, the two engines agree to 1e-5 m/s
/// instead of 1e-11 once a queue moves up in very small steps.
pub const CREEP_MPS2: f64 = 1e-4;

/// Number of a vehicle. On a ring the ego is 0, vehicle 1 starts ahead of it (its leader), and so on in driving direction; the last is the
/// ego's follower.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct VehicleId(pub u32);

/// Number of the participant's vehicle, in every engine.
pub const EGO: VehicleId = VehicleId(0);

/// Initial position and speed of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialVehicle {
    /// Front bumper along the route, metres.
    pub s_m: f64,
    pub speed_mps: f64,
}

/// Start settings of a fixed number of vehicles on a closed route.
#[derive(Clone, Debug)]
pub struct FixedSetup {
    pub map: Arc<RoadMap>,
    /// Initial vehicles; vehicle `i` has [`VehicleId`] `i`, vehicle 0 is the ego.
    pub cars: Vec<InitialVehicle>,
    /// Car-following parameters of every vehicle, noise included.
    pub idm: IdmParams,
    /// Other vehicles with a different car-following model.
    pub mixture: ModelMixture,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Seed of the noise, of the choice of vehicles with a different model, and of SUMO's random numbers.
    pub seed: u64,
    /// Largest lateral acceleration in a bend, m/s2; `None` sets no bound, as in the car-following model.
    pub lateral_accel_mps2: Option<f64>,
}

/// Start settings of vehicles that come and go on a network.
#[derive(Clone, Debug)]
pub struct DemandSetup {
    pub network: Arc<Network>,
    /// File of the network, which messages name.
    pub net_file: PathBuf,
    pub demand: Demand,
    /// Vehicles that drivers outside SUMO move from the start.
    pub egos: Vec<EgoStart>,
    /// Number of the first vehicle, that of the first ego if there is one. A drive without a participant begins with 1, as 0 is theirs.
    pub first_number: u32,
    /// Car-following parameters of the cars of the demand's flows.
    pub idm: IdmParams,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Time until which the demand's limit on vehicles counts, seconds ([`Demand::horizon_s`]).
    pub until_s: f64,
    /// Seed of everything random in SUMO.
    pub seed: u64,
}

/// Initial place of an ego on a network.
#[derive(Clone, Debug, PartialEq)]
pub struct EgoStart {
    pub lane: LaneId,
    /// Front bumper along the lane, metres.
    pub s_m: f64,
    /// Initial speed, m/s.
    pub speed_mps: f64,
    /// Edges along which it is expected to drive, that of the lane first: others give way to it, or take theirs, by where it will cross
    /// their path. Empty where only the lane is known.
    pub route: Vec<String>,
}

/// State of an externally driven vehicle in one step: at present, and as predicted for the end of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExternalVehicleState {
    /// Present pose of its centre.
    pub pose: Pose,
    /// Present speed, m/s, not negative.
    pub speed_mps: f64,
    /// Pose predicted for the end of the step with constant acceleration (docs/decisions.md: 4).
    pub next_pose: Pose,
    /// Speed predicted for the end of the step, m/s.
    pub next_speed_mps: f64,
}

/// Report of an externally driven vehicle, which does not follow its model in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleReport {
    pub id: VehicleId,
    pub state: ExternalVehicleState,
    /// Lane on which it will be at the end of the step: where lanes cross, SUMO cannot know. `None` off all lanes, where others do not see
    /// it. On a closed route with a fixed number of vehicles the engines find the place by the pose.
    pub lane: Option<LaneId>,
    /// True if it heads against that lane's direction. SUMO's vehicles know of none that comes towards them: for them it stands there.
    pub is_wrong_way: bool,
    pub lamps: VehicleLamps,
}

impl VehicleReport {
    /// Creates the report of a vehicle on a closed route, its lamps dark.
    pub fn on_route(id: VehicleId, state: ExternalVehicleState) -> Self {
        Self { id, state, lane: None, is_wrong_way: false, lamps: VehicleLamps::default() }
    }

    /// Creates the report of the ego on a closed route, its lamps dark.
    pub fn of_ego(state: ExternalVehicleState) -> Self {
        Self::on_route(EGO, state)
    }
}

/// Traffic engine. One call is one step; all vehicles move at once from one state. An engine may start on one thread and run on another, so
/// that a window stays responsive.
pub trait Traffic: Send {
    /// Advances by one step. Vehicles with a report, by ascending id, move as reported; the model drives every other vehicle, from the
    /// position of its last report if it had one. Other vehicles do not see an externally driven vehicle whose body has left the lane.
    ///
    /// # Errors
    /// The engine failed, after which the drive cannot continue; a number is not finite; the reports are not of existing vehicles, each
    /// once and in order; or a vehicle that was left off the lane has no report.
    fn step(&mut self, reports: &[VehicleReport]) -> Result<(), TrafficError>;

    /// Returns all vehicles at the end of the last step, by ascending id, the ego first. Poses that follow from places along a route are
    /// computed here, once a step.
    fn vehicles(&mut self) -> &[VehicleState];

    /// Returns the vehicles that have come and gone in the last step; none of a fixed number.
    fn changes(&self) -> &VehicleChanges {
        static NONE: VehicleChanges = VehicleChanges { departed: Vec::new(), arrived: Vec::new() };
        &NONE
    }

    /// Returns the letters that all signals show, and where those of each signal begin, with one more at the end. An engine without
    /// signals has none.
    fn signals(&self) -> (&[u8], &[u32]) {
        (&[], &[])
    }

    /// Makes a vehicle of the demand one with reports, from the next step on; returns the edges of its route. Without a report its model
    /// drives it again.
    ///
    /// # Errors
    /// The vehicle is not there, or the engine has no vehicles with routes.
    fn take_over(&mut self, _id: VehicleId) -> Result<Vec<String>, TrafficError> {
        Err(TrafficError::Setup("only vehicles of a demand are taken over along their routes".into()))
    }

    /// Returns the canonical copies of the demand's files that SUMO reads, in their order.
    fn demand_files(&self) -> &[PathBuf] {
        &[]
    }

    /// Returns name and version of the engine, for recordings and messages.
    fn describe(&self) -> String;
}

/// Starts the chosen engine with all vehicles at their initial positions.
///
/// # Errors
/// The setup cannot be simulated, or SUMO is absent or in use.
pub fn start(engine: EngineChoice, setup: FixedSetup) -> Result<Box<dyn Traffic>, TrafficError> {
    Ok(match engine {
        EngineChoice::Native => Box::new(NativeTraffic::start(setup)?),
        EngineChoice::Sumo => Box::new(sumo::SumoTraffic::start(setup)?),
    })
}

/// Reason why traffic cannot start or continue.
#[derive(Debug, thiserror::Error)]
pub enum TrafficError {
    /// SUMO is not on this machine.
    #[error(
        "SUMO was not found: {0}\n  remedy: run scripts/setup, which puts SUMO into .sumo/, or drive with --traffic native"
    )]
    Absent(String),
    /// Another simulation of this process uses SUMO.
    #[error("SUMO is in use: one program runs one SUMO simulation at a time")]
    Busy,
    /// Two vehicles would overlap at the start.
    #[error(
        "cars {a} and {b} would stand inside each other at the start, at x {x_m:.1} m, y {y_m:.1} m: the route passes there twice, or is drawn much shorter than it is declared\n  remedy: another number of vehicles, or another route"
    )]
    CarsOverlap {
        /// Number of one vehicle; 0 is the ego.
        a: usize,
        /// Number of the other vehicle.
        b: usize,
        /// Position of the overlap, metres to the east.
        x_m: f64,
        /// Position of the overlap, metres to the north.
        y_m: f64,
    },
    /// The built-in engine cannot drive a route that meets itself.
    #[error(
        "the route crosses or touches itself: at {first_m:.0} m it comes to where it is at {second_m:.0} m, and the built-in engine knows no right of way\n  remedy: drive with --traffic sumo, or choose a route that does not meet itself (route = [..] in map.toml)"
    )]
    RouteMeetsItself {
        /// First position, metres along the route.
        first_m: f64,
        /// Second position, metres along the route.
        second_m: f64,
    },
    /// The route changes lanes, but SUMO's vehicles on a closed route keep their lanes.
    #[error(
        "the route changes from lane \"{from}\" to lane \"{to}\", and SUMO's cars of a closed route keep their lanes\n  remedy: choose edges that one lane each leads along (route = [..] in map.toml), or drive with --traffic native"
    )]
    RouteChangesLanes {
        /// Lane by which the route enters the edge.
        from: String,
        /// Lane by which the route leaves the edge.
        to: String,
    },
    /// A lane of the route leads to two lanes of the same edge, and both are on the route.
    #[error(
        "the route goes from lane \"{from}\" to lane \"{to}\", and elsewhere over lane \"{other}\" of the same edge, to which \"{from}\" leads, too: SUMO's cars of a closed route would take either\n  remedy: choose edges of which each is driven once (route = [..] in map.toml), or drive with --traffic native"
    )]
    RouteForks {
        /// Lane that leads to both.
        from: String,
        /// Lane that the route takes there.
        to: String,
        /// Other lane, which the route takes elsewhere.
        other: String,
    },
    /// SUMO reported an error.
    #[error("SUMO: {0}")]
    Sumo(String),
    /// The program was interrupted while it waited for SUMO.
    #[error("interrupted while waiting for SUMO")]
    Interrupted,
    /// The start edge has no room for the ego.
    #[error(
        "no room for the ego on edge \"{edge}\" within {waited_s} s: other vehicles are there all the time\n  remedy: another place \
         (--path-start), fewer vehicles in the demand, or a longer wait (--wave-wait)"
    )]
    NoRoom {
        /// Id of the start edge.
        edge: String,
        /// Duration of the wait, seconds.
        waited_s: f64,
    },
    /// A car-following model was chosen that only SUMO in this process has.
    #[error("other cars cannot follow by {}: only SUMO in this program has that model\n  remedy: --traffic sumo, or --other-model idm", .0.name())]
    NoSuchModel(FollowingModel),
    /// The engine cannot drive a road with an open path, on which vehicles enter and leave.
    #[error(
        "traffic is {0}; allowed on a road whose path is open: sumo; only SUMO moves vehicles on a network\n  \
         remedy: --traffic sumo"
    )]
    NotOnNetworks(String),
    /// The setup cannot be simulated.
    #[error("{0}")]
    Setup(String),
    /// A number is NaN or infinite.
    #[error("{what} of car {car} is not a finite number: {value}")]
    NotFinite {
        /// Name of the quantity.
        what: &'static str,
        /// Number of the vehicle.
        car: u32,
        /// Value of the quantity.
        value: f64,
    },
}
