//! Traffic: all other vehicles. In: a [`FixedSetup`] or a [`DemandSetup`], then once per step the reports of externally driven vehicles.
//! Out: the state of every vehicle at the end of the step. Two engines implement [`Traffic`]: SUMO and the native one, which can also
//! move the vehicles of a [`TrafficLog`]. Only `traffic::sumo` depends on SUMO.

mod articulation;
mod bends;
mod choice;
mod crossings;
mod demand;
mod demand_count;
mod demand_file;
mod demand_names;
mod demand_references;
mod drivers;
mod engine;
mod error;
pub mod gait;
mod interrupt;
mod lane_followers;
mod log;
mod mixture;
mod motion;
mod native;
mod noise;
mod reported;
mod route_vehicles;
pub mod start;
pub mod sumo;
mod vehicles;

pub use articulation::{Articulation, VehiclePart};
pub use choice::{EngineChoice, UnknownEngine};
pub use demand::{Demand, DemandFault, Flow, KindShare};
pub use demand_count::{Departures, time_of_day_s};
pub use demand_file::CanonicalDemand;
pub use demand_names::DemandNames;
pub use drivers::{
    AccelNoise, CarFollowing, PersonCorrelation, PersonParameter, PopulationError, PopulationModel, RING_STUDY,
    TrafficDriver, TrafficDrivers, TrafficPopulation, is_path as is_population_path, names as population_names,
};
pub use engine::{
    CREEP_MPS2, DemandSetup, EgoStart, ExternalVehicleState, FixedSetup, GUARD, HARDEST_MPS2, InitialVehicle,
    LaneMotion, Leader, Traffic, TrafficOrder, VehicleReport,
};
pub use error::TrafficError;
pub use interrupt::{Interruption, TrafficStart, go_on, interrupt, is_interrupted, starts_under_way};
pub use log::{LoggedVehicle, TrafficLog};
pub use mixture::{FollowingModel, ModelMixture};
pub use native::NativeTraffic;
pub use reported::is_on_lane;
pub use vehicles::{
    Departure, EGO, FIRST_OF_EVENTS, VehicleBody, VehicleChanges, VehicleId, VehicleKind, VehicleLamps, VehicleState,
};

/// Starts the chosen engine with all vehicles at their initial positions. A log needs [`NativeTraffic::behind`] instead.
///
/// # Errors
/// The setup cannot be simulated, or SUMO is absent or in use.
pub fn start(engine: &EngineChoice, setup: FixedSetup) -> Result<Box<dyn Traffic>, TrafficError> {
    Ok(match engine {
        EngineChoice::Native | EngineChoice::Log(_) => Box::new(NativeTraffic::start(setup)?),
        EngineChoice::Sumo => Box::new(sumo::SumoTraffic::start(setup)?),
    })
}
