//! The road network as data. In: a map's name or a SUMO `net.xml`, and the edges to drive along if the user names them. Out: a
//! [`RoadMap`]: the whole [`Network`], and one [`Route`] of its lanes, closed or open, both with `lane <-> world` in both directions.
//! Lengths in metres, world axes as in [`crate::space`].
//!
//! [`network`] reads and writes networks. `xml_tree`, `canonical`, `net_xml`, `net_check` and [`limits`] define what a file may contain.
//! `loop_search` finds the closed route, and `longest_open_path` an open one where there is no loop; `tight_turns` lists the turns that both
//! avoid, and `joined_shapes` joins the lines of lanes. `path_places` reads the places of a path, and `edge_path` builds the open route along them; `way_back` leads back to it. `catalog` knows the folder `maps/`, of which `shipped` lists the program's own maps, and [`import()`] fills it from other formats. [`ring`] and [`circuit`] make
//! new networks, and `write` writes them in SUMO's format.

mod canonical;
mod catalog;
pub mod circuit;
mod circuit_fault;
mod edge_path;
mod error;
pub mod import;
mod joined_shapes;
pub mod lane;
#[cfg(test)]
mod limit_tests;
pub mod limits;
mod longest_open_path;
mod loop_search;
mod net_check;
#[cfg(test)]
mod net_tests;
mod net_xml;
pub mod network;
mod open_drive_roads;
mod path_places;
mod reference_line;
pub mod ring;
mod route;
mod shipped;
pub mod surroundings;
#[cfg(test)]
mod tests;
mod tight_turns;
mod way_back;
mod write;
mod xml_tree;
#[cfg(test)]
mod xml_tree_tests;

pub use canonical::SumoText;
pub use catalog::{MapFile, MapInfo, is_own, is_path, known_as, list, own_folder, scenario_file};
pub use error::MapError;
pub use import::{Imported, import, import_within};
pub use open_drive_roads::{OpenDriveRoad, OpenDriveRoads, OpenDriveSignal};
pub use path_places::quickest_way_through;
pub use route::{
    LaneChange, Manoeuvre, NextManoeuvre, PathGuidance, PathLanes, Route, RouteLane, RoutePosition, StopLine, StopRule,
    Turns, YieldLine, is_against, stop_lines,
};
pub use shipped::SHIPPED;
pub use write::{RoadEdge, net_xml};

use glam::DVec2;
use network::{LaneId, Network};
use std::{path::PathBuf, sync::Arc};

/// Width of the asphalt beyond the lane's edge on either side, metres: as drawn, and as the tyres feel it.
pub const SHOULDER_M: f64 = 0.4;

/// Road network with one route to drive.
///
/// # Examples
///
/// ```
/// # extern crate codrive_core as codrive;
/// use codrive::map::RoadMap;
///
/// let map = RoadMap::load("ring-250")?;
/// assert_eq!(map.title, "Ring, 250 m");
/// assert!(map.route.is_closed() && (map.route.length_m() - 250.0).abs() < 1e-6);
/// // A ring of 250 m has a radius of 250 m / 2 pi = 39.8 m around the origin.
/// let (centre, radius_m) = map.bounds();
/// assert!(centre.length() < 0.01 && (radius_m - 39.79).abs() < 0.01);
/// // Positions go round: from 240 m of a lap to 10 m of the next one.
/// assert!((map.route.ahead(240.0, 10.0) - 20.0).abs() < 1e-6);
/// // It begins in the east and turns left: a quarter of a lap later it is in the north. And back from the point to the route.
/// let north = map.route.point_at(62.5);
/// assert!(north.x.abs() < 0.01 && (north.y - 39.79).abs() < 0.01);
/// assert!((map.route.project(north, None).s_m - 62.5).abs() < 0.01);
/// # Ok::<(), codrive::map::MapError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RoadMap {
    /// Name of the map's folder in `maps/`, or the file's stem.
    pub name: String,
    /// Title in one line; the name if the map has none.
    pub title: String,
    /// File of the network. SUMO reads a checked copy of it ([`Network::sumo_text`]).
    pub net_file: PathBuf,
    /// Route to drive: closed, or open along the edges of a path.
    pub route: Route,
    /// Network with all roads of the file.
    pub network: Arc<Network>,
}

impl RoadMap {
    /// Returns the middle of the route's bounding box, and the radius around it that contains all centre lines, metres.
    pub fn bounds(&self) -> (DVec2, f64) {
        let points = || self.route.lanes().iter().flat_map(|lane| &lane.shape);
        let low = points().fold(DVec2::INFINITY, |low, point| low.min(*point));
        let high = points().fold(DVec2::NEG_INFINITY, |high, point| high.max(*point));
        let centre = (low + high) / 2.0;
        (centre, points().map(|point| point.distance(centre)).fold(0.0, f64::max))
    }

    /// Returns the speed limit of the street at `s_m` of the route, m/s. A junction's lanes have no limit but the speed of their bend: there
    /// the lower limit of the streets before and after counts.
    pub fn street_limit_mps(&self, s_m: f64) -> f64 {
        let (lanes, (here, _)) = (self.route.lanes(), self.route.lane_at(s_m));
        let is_street = |lane: &&RouteLane| lane.is_street(&self.network);
        let before = lanes[..=here].iter().rev().find(is_street);
        let after = lanes[here..].iter().find(is_street);
        let limits_mps = before.into_iter().chain(after).map(|lane| lane.speed_limit_mps);
        limits_mps.reduce(f64::min).unwrap_or(lanes[here].speed_limit_mps)
    }

    /// Returns the offset from the route of the middle of the lane that is a number of lanes to the left of the route's, m: lanes are side by
    /// side, and beyond those of the edge as wide as its last one.
    pub fn lane_middle_m(&self, s_m: f64, lanes_left: i32) -> f64 {
        let part = &self.route.lanes()[self.route.lane_at(s_m).0];
        let width_m = |lanes: i32| part.lane.map_or(part.width_m, |lane| self.width_beside_m(lane, lanes));
        let toward = lanes_left.signum();
        let between_m = |k: i32| (width_m(toward * k) + width_m(toward * (k - 1))) / 2.0;
        f64::from(toward) * (1..=lanes_left.abs()).map(between_m).sum::<f64>()
    }

    /// Returns the width of the lane that is a number of lanes to the left of another, m.
    fn width_beside_m(&self, lane: LaneId, lanes_left: i32) -> f64 {
        let network = &self.network;
        let lanes: Vec<LaneId> = network.edge_of(lane).lanes().collect();
        let here = lanes.iter().position(|other| *other == lane).unwrap_or(0) as i32;
        // Lanes are numbered from the outermost: from the right, with left-hand traffic from the left.
        let steps = if network.is_left_hand() { -lanes_left } else { lanes_left };
        let at = (here + steps).clamp(0, lanes.len() as i32 - 1);
        network.lane(lanes[at as usize]).width_m
    }
}

/// Joins names for a message: the first twenty, and the number of the others.
fn listed(names: &[&str]) -> String {
    const SHOWN: usize = 20;
    match names.len() {
        0 => "none".into(),
        n if n > SHOWN => format!("{} and {} more", names[..SHOWN].join(", "), n - SHOWN),
        _ => names.join(", "),
    }
}
