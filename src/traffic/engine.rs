//! Interface of traffic engines: the trait [`Traffic`], the setups that they start with, and the reports of externally driven vehicles.
//! Metres, m/s, seconds.

use super::{
    demand::Demand,
    drivers::TrafficDrivers,
    error::TrafficError,
    mixture::ModelMixture,
    vehicles::{EGO, VehicleChanges, VehicleId, VehicleLamps, VehicleState},
};
use crate::{
    idm::IdmParams,
    map::{
        RoadMap,
        network::{LaneId, Network, SignalId},
    },
    space::Pose,
};
use std::{path::PathBuf, sync::Arc};

/// Hardest braking of any vehicle of the traffic, m/s2 (SUMO's default for passenger cars), and its hardest acceleration: tyres hold no
/// more. The model is never clipped at `b` (docs/references.md: idm); it reaches this bound only behind an ego that cuts in, stops or
/// pulls away suddenly.
pub const HARDEST_MPS2: f64 = 9.0;

/// Model of a vehicle whose speed is chosen by another one or from outside, which it bounds. Its gaps are below, and its accelerations above what
/// drivers have in flowing traffic, so that their choice decides until a collision is near.
pub const GUARD: IdmParams = IdmParams { v0: 30.0, t: 0.5, s0: 1.0, a: 6.0, b: 4.5, delta: 4.0, noise: 0.0 };

/// Creep limit, m/s2: SUMO rounds a speed below this times the step length to 0. Without this rule, the two engines agree to 1e-5 m/s
/// instead of 1e-11 once a queue moves up in very small steps.
pub const CREEP_MPS2: f64 = 1e-4;

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
    /// Drivers of all vehicles: car-following models and noise.
    pub drivers: TrafficDrivers,
    /// Other vehicles with a different car-following model.
    pub mixture: ModelMixture,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Seed of the drivers and their noise, of the choice of vehicles with a different model, and of SUMO's random numbers.
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
    /// Drivers of the cars: of the demand's flows where they are alike, of all where they are people.
    pub drivers: TrafficDrivers,
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

/// Motion in one step of a vehicle with a driver outside of the engine, who has the pedals; the engine steers it along its lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneMotion {
    pub id: VehicleId,
    /// Mean speed over the step, m/s, not negative: the way along the lane over the length of the step.
    pub mean_mps: f64,
    /// Speed at the end of the step, m/s, not negative.
    pub end_mps: f64,
}

impl LaneMotion {
    /// Checks that these motions are of different vehicles, by ascending id, and that their numbers are finite.
    pub(super) fn check_all(motions: &[Self]) -> Result<(), TrafficError> {
        if let Some(pair) = motions.windows(2).find(|pair| pair[0].id >= pair[1].id) {
            let [first, second] = [pair[0].id.0, pair[1].id.0];
            return Err(TrafficError::Setup(format!("motions of vehicle {first} before {second}; allowed: in order")));
        }
        let numbers = motions.iter().flat_map(|motion| [(motion.id, motion.mean_mps), (motion.id, motion.end_mps)]);
        match numbers.into_iter().find(|(_, value)| !value.is_finite()) {
            Some((id, value)) => Err(TrafficError::NotFinite { what: "motion", car: id.0, value }),
            None => Ok(()),
        }
    }
}

/// Order from outside to the traffic of a network.
#[derive(Clone, Debug, PartialEq)]
pub enum TrafficOrder {
    /// The vehicle changes to the lane this many to the left as soon as there is room, within `duration_s`, and stays there. From then on it
    /// changes lanes by order only, also where its route needs another. No effect where there is no such lane, as inside a junction.
    ChangeLane {
        /// Vehicle of the order.
        id: VehicleId,
        /// Number of lanes, positive to the left; 0 is to stay.
        to_the_left: i32,
        /// Time in which the change has to begin, s.
        duration_s: f64,
        /// False for a vehicle that changes into a gap that is too short for others, as long as it touches none.
        keeps_gaps: bool,
    },
    /// The vehicle drives along these edges, the first of which is its own.
    Route {
        /// Vehicle of the order.
        id: VehicleId,
        /// Edges by SUMO's ids.
        edges: Vec<String>,
    },
    /// The signal shows the phase of this number of its programme, which goes on from there.
    Phase {
        /// Signal of the order.
        signal: SignalId,
        /// Number of the phase, from 0.
        phase: u32,
    },
    /// The signal shows these letters, one for each of its links, until the next order.
    State {
        /// Signal of the order.
        signal: SignalId,
        /// SUMO's letters of lights, one for each link.
        letters: String,
    },
    /// The vehicle changes its speed evenly within a time, as far as its checks allow. Then its model drives on.
    Speed {
        /// Vehicle of the order.
        id: VehicleId,
        /// Speed at the end of that time, m/s.
        speed_mps: f64,
        /// Time of the change, s; 0 is the next step.
        duration_s: f64,
    },
    /// The model of the vehicle drives at this speed at most.
    MaxSpeed {
        /// Vehicle of the order.
        id: VehicleId,
        /// Highest speed, m/s.
        speed_mps: f64,
    },
    /// The vehicle keeps its lane and moves as an event says, within safe distances, right of way and signals, but beyond the limits of its type.
    TakeOver {
        /// Vehicle of the order.
        id: VehicleId,
    },
    /// The vehicle's own model has speed and lane again, with all checks.
    GiveBack {
        /// Vehicle of the order.
        id: VehicleId,
    },
    /// The vehicle obeys the checks of SUMO's speed mode.
    SpeedMode {
        /// Vehicle of the order.
        id: VehicleId,
        /// Sum of SUMO's bits: 1 safe speed, 2 and 4 limits of acceleration and braking, 8 right of way, 16 red lights; 31 is all.
        mode: u32,
    },
}

impl TrafficOrder {
    /// Returns the vehicle of the order; `None` for a signal.
    pub fn vehicle(&self) -> Option<VehicleId> {
        match self {
            Self::ChangeLane { id, .. }
            | Self::Route { id, .. }
            | Self::Speed { id, .. }
            | Self::MaxSpeed { id, .. }
            | Self::TakeOver { id }
            | Self::GiveBack { id }
            | Self::SpeedMode { id, .. } => Some(*id),
            Self::Phase { .. } | Self::State { .. } => None,
        }
    }

    /// Returns true for an order to the model that drives the vehicle, which a vehicle with a driver of its own does not have.
    pub fn is_for_model(&self) -> bool {
        matches!(self, Self::Speed { .. } | Self::MaxSpeed { .. } | Self::SpeedMode { .. })
    }
}

/// Vehicle ahead of another on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leader {
    pub id: VehicleId,
    /// Gap from bumper to bumper, m.
    pub gap_m: f64,
    pub speed_mps: f64,
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

    /// Sets the motions in the next step of vehicles whose pedals are not the engine's, by ascending id; none of them has a report. Where
    /// others, signals or right of way forbid it, an engine of networks moves them more slowly: [`Traffic::vehicles`] has the speed.
    ///
    /// # Errors
    /// A number is not finite, or the motions are not of different vehicles in order.
    fn drive(&mut self, motions: &[LaneMotion]) -> Result<(), TrafficError>;

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

    /// Gives the pedals of a vehicle of the demand to a driver outside of the engine ([`Traffic::drive`]), from the next step on; returns the
    /// edges of its route. The engine steers, chooses lanes, keeps to signals and right of way, and brakes before a collision.
    ///
    /// # Errors
    /// The vehicle is not there, or the engine has no vehicles with routes.
    fn take_pedals(&mut self, _id: VehicleId) -> Result<Vec<String>, TrafficError> {
        Err(TrafficError::Setup("only vehicles of a demand are driven along their routes".into()))
    }

    /// Returns the vehicle ahead of another one on its way on a network; `None` without one within `reach_m`.
    ///
    /// # Errors
    /// The vehicle is not there, or the engine has no vehicles with routes.
    fn leader(&self, _id: VehicleId, _reach_m: f64) -> Result<Option<Leader>, TrafficError> {
        Err(TrafficError::Setup("only vehicles of a demand have a way on a network".into()))
    }

    /// Returns the name of a vehicle in the demand, and that of its type.
    ///
    /// # Errors
    /// The vehicle is not there, or the engine has no demand.
    fn names(&self, _id: VehicleId) -> Result<[String; 2], TrafficError> {
        Err(TrafficError::Setup("only vehicles of a demand have names".into()))
    }

    /// Carries out an order, from the next step on.
    ///
    /// # Errors
    /// The order cannot be carried out, and nothing has changed; or the engine takes no orders.
    fn order(&mut self, _order: &TrafficOrder) -> Result<(), TrafficError> {
        Err(TrafficError::Setup("the native engine takes no orders; traffic of SUMO on a network does".into()))
    }

    /// Returns the demand with the canonical copies that SUMO reads in place of its files.
    fn demand(&self) -> Option<&Demand> {
        None
    }

    /// Returns name and version of the engine, for recordings and messages.
    fn name_and_version(&self) -> String;
}
