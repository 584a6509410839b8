//! All other cars. In: a [`TrafficSetup`], then once a step what those do that somebody drives. Out: the state of every car at the end
//! of that step. Two engines behind one trait: SUMO and the native IDM ring. Only `traffic::sumo` knows
//! SUMO.

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
pub use vehicles::{Departure, NetworkVehicle, VehicleBody, VehicleChanges, VehicleKind, VehicleLamps};

use crate::{idm::IdmParams, map::RoadMap, space::Pose};
use std::sync::Arc;

/// The hardest that any car of the traffic brakes, m/s2 (SUMO's default for passenger cars). The model is never clipped at
/// `b` (docs/references.md: idm); it reaches this bound only behind an ego that cuts in or stops dead.
pub const EMERGENCY_BRAKING_MPS2: f64 = 9.0;

/// A speed that an acceleration below this leads to is none, m/s2: SUMO rounds such creeping to a stop. Without it the two
/// engines agree to 1e-5 m/s instead of 1e-11 once a queue moves up by hairs.
pub const CREEP_MPS2: f64 = 1e-4;

/// Number of a car: the ego is 0, car 1 starts ahead of it (its leader), and so on in driving direction, so that the last is
/// the ego's follower.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct VehicleId(pub u32);

/// The participant's car, in every engine.
pub const EGO: VehicleId = VehicleId(0);

/// One car at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CarState {
    /// Which car.
    pub id: VehicleId,
    /// Front bumper along the route, metres, in `0..length_m`.
    pub s_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration over the step, m/s2.
    pub accel_mps2: f64,
    /// True while the brake lamps are lit.
    pub braking: bool,
}

/// Where a car starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialVehicle {
    /// Front bumper along the route, metres.
    pub s_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
}

/// Everything an engine needs to begin.
#[derive(Clone, Debug)]
pub struct TrafficSetup {
    /// The road.
    pub map: Arc<RoadMap>,
    /// All cars; car `i` has [`VehicleId`] `i`, car 0 is the ego.
    pub cars: Vec<InitialVehicle>,
    /// Model of every car, noise included.
    pub idm: IdmParams,
    /// Other cars that have another one.
    pub mixture: ModelMixture,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Largest lateral acceleration in a bend, m/s2; `None` sets no bound, as the car-following model knows none.
    pub lateral_accel_mps2: Option<f64>,
}

/// What somebody's vehicle does in one step: as it is now and as it will be at the end of the step.
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

/// A vehicle that does not follow its model in a step, because somebody drives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleReport {
    /// Which.
    pub id: VehicleId,
    /// What it does.
    pub state: ExternalVehicleState,
}

impl VehicleReport {
    /// That of the ego.
    pub fn of_ego(state: ExternalVehicleState) -> Self {
        Self { id: EGO, state }
    }
}

/// A traffic engine. One call is one step; all cars move at once from one state. It is begun on one thread and may be
/// driven on another, so that a window hears its keys meanwhile.
pub trait Traffic: Send {
    /// Advances by one step. The cars of these reports, by ascending id, are where the reports say; every other is driven by its
    /// own model, from where its last report left it. A reported car whose body has left the lane is not seen by the others.
    ///
    /// # Errors
    /// If the engine failed, a number is not finite, or the reports are not of cars that are here, each once and in order; the drive
    /// cannot go on. Also if a car that is reported no more was left beside the road.
    fn step(&mut self, reports: &[VehicleReport]) -> Result<(), TrafficError>;

    /// All cars at the end of the last step, by ascending id, the ego first.
    fn cars(&self) -> &[CarState];

    /// Name and version, for recordings and messages.
    fn describe(&self) -> String;
}

/// Starts the engine chosen, all cars at their places.
///
/// # Errors
/// If the setup cannot be simulated, or SUMO is not here or in use.
pub fn start(engine: EngineChoice, setup: TrafficSetup) -> Result<Box<dyn Traffic>, TrafficError> {
    Ok(match engine {
        EngineChoice::Native => Box::new(NativeTraffic::start(setup)?),
        EngineChoice::Sumo => Box::new(sumo::SumoTraffic::start(setup)?),
    })
}

/// Why traffic cannot start or go on.
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
    /// Two cars would stand inside each other at the start.
    #[error(
        "cars {a} and {b} would stand inside each other at the start, at x {x_m:.1} m, y {y_m:.1} m: the route passes there twice, or is drawn much shorter than it is declared\n  remedy: another number of vehicles, or another route"
    )]
    CarsOverlap {
        /// One car, counted from 0, the ego.
        a: usize,
        /// The other.
        b: usize,
        /// Where, metres to the east.
        x_m: f64,
        /// Where, metres to the north.
        y_m: f64,
    },
    /// The built-in engine cannot drive a route that meets itself.
    #[error(
        "the route crosses or touches itself: at {first_m:.0} m it comes to where it is at {second_m:.0} m, and the built-in engine knows no right of way\n  remedy: drive with --traffic sumo, or choose a route that does not meet itself (route = [..] in map.toml)"
    )]
    RouteMeetsItself {
        /// The first place, metres along the route.
        first_m: f64,
        /// The second.
        second_m: f64,
    },
    /// The route changes lanes, which cars of a closed file do not.
    #[error(
        "the route changes from lane \"{from}\" to lane \"{to}\", and SUMO's cars of a closed route keep their lanes\n  remedy: choose edges that one lane each leads along (route = [..] in map.toml), or drive with --traffic native"
    )]
    RouteChangesLanes {
        /// The lane that is entered.
        from: String,
        /// The lane that is left.
        to: String,
    },
    /// A lane of the route leads to two lanes of the same edge that are both on it.
    #[error(
        "the route goes from lane \"{from}\" to lane \"{to}\", and elsewhere over lane \"{other}\" of the same edge, to which \"{from}\" leads, too: SUMO's cars of a closed route would take either\n  remedy: choose edges of which each is driven once (route = [..] in map.toml), or drive with --traffic native"
    )]
    RouteForks {
        /// The lane that leads to both.
        from: String,
        /// The one that the route takes there.
        to: String,
        /// The other.
        other: String,
    },
    /// SUMO reported an error.
    #[error("SUMO: {0}")]
    Sumo(String),
    /// The program was told to end while it waited.
    #[error("interrupted while waiting for SUMO")]
    Interrupted,
    /// There is no room for the ego where it shall start.
    #[error(
        "no room for the ego on edge \"{edge}\" within {waited_s} s: other vehicles are there all the time\n  remedy: another place \
         (--path-start), fewer vehicles in the demand, or a longer wait (--wave-wait)"
    )]
    NoRoom {
        /// Where it starts.
        edge: String,
        /// How long it was waited, seconds.
        waited_s: f64,
    },
    /// Other models are SUMO's, and this engine is not SUMO.
    #[error("other cars cannot follow by {}: only SUMO has that model\n  remedy: --traffic sumo, or --other-model idm", .0.name())]
    NoSuchModel(FollowingModel),
    /// The road has an open path, and vehicles come and go there.
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
        /// Which quantity.
        what: &'static str,
        /// Which car.
        car: u32,
        /// Its value.
        value: f64,
    },
}
