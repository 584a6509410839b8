//! The road network as data. In: a map's name or a SUMO `net.xml`. Out: a [`RoadMap`]: one closed [`Route`] of lanes
//! with `lane <-> world` in both directions. Lengths in metres, world axes as in [`crate::space`].

mod route;

pub use route::{Lane, Route, RoutePoint};

use std::path::PathBuf;

/// A road network with one closed route to drive.
#[derive(Clone, Debug, PartialEq)]
pub struct RoadMap {
    /// Name of its folder in `maps/`, or the file's stem.
    pub name: String,
    /// The network as SUMO reads it.
    pub net_file: PathBuf,
    /// The closed route.
    pub route: Route,
}
