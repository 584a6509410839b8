//! Reasons why traffic cannot start or continue, with the remedy.

use super::mixture::FollowingModel;

/// Reason why traffic cannot start or continue.
#[derive(Debug, thiserror::Error)]
pub enum TrafficError {
    /// SUMO is not on this machine.
    #[error(
        "SUMO was not found: {0}\n  remedy: run scripts/setup in a checkout, or pip install eclipse-sumo and set SUMO_HOME to its folder, or drive with --traffic native"
    )]
    Absent(String),
    /// Another simulation of this process uses SUMO.
    #[error("SUMO is in use: one program runs one SUMO simulation at a time")]
    Busy,
    /// Two vehicles would overlap at the start.
    #[error(
        "vehicles {a} and {b} would overlap at the start, at x {x_m:.1} m, y {y_m:.1} m: the route passes there twice, \
         or is drawn much shorter than it is declared\n  remedy: choose another number of vehicles, or another route"
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
        "the route crosses or touches itself, at {first_m:.0} m and {second_m:.0} m; the built-in engine has no right \
         of way\n  remedy: drive with --traffic sumo, or choose a route that does not meet itself (route = [..] in \
         map.toml)"
    )]
    RouteMeetsItself {
        /// First position, metres along the route.
        first_m: f64,
        /// Second position, metres along the route.
        second_m: f64,
    },
    /// The route changes lanes, but SUMO's vehicles on a closed route keep their lanes.
    #[error(
        "the route changes from lane \"{from}\" to lane \"{to}\", but SUMO's vehicles on a closed route keep their \
         lanes\n  remedy: choose edges on which the route keeps its lane (route = [..] in map.toml), or drive with \
         --traffic native"
    )]
    RouteChangesLanes {
        /// Lane by which the route enters the edge.
        from: String,
        /// Lane by which the route leaves the edge.
        to: String,
    },
    /// A lane of the route leads to two lanes of the same edge, and both are on the route.
    #[error(
        "the route goes from lane \"{from}\" to lane \"{to}\", and elsewhere over lane \"{other}\" of the same edge; \
         lane \"{from}\" leads to both, and SUMO's vehicles on a closed route would take either\n  remedy: choose a \
         route that drives along each edge once (route = [..] in map.toml), or drive with --traffic native"
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
        "no room for the ego on edge \"{edge}\" within {waited_s:.0} s: other vehicles occupy it all the time\n  remedy: \
         set another place (--path-start), fewer vehicles in the demand, or a longer wait (--wave-wait)"
    )]
    NoRoom {
        /// Id of the start edge.
        edge: String,
        /// Duration of the wait, seconds.
        waited_s: f64,
    },
    /// A car-following model was chosen that only SUMO in this process has.
    #[error("the other vehicles cannot follow the model {}: only SUMO within this program has it\n  remedy: set --traffic sumo, or --other-model idm", .0.name())]
    NoSuchModel(FollowingModel),
    /// The setup cannot be simulated.
    #[error("{0}")]
    Setup(String),
    /// A number is NaN or infinite.
    #[error("{what} of vehicle {car} is not a finite number: {value}")]
    NotFinite {
        /// Name of the quantity.
        what: &'static str,
        /// Number of the vehicle.
        car: u32,
        /// Value of the quantity.
        value: f64,
    },
}
