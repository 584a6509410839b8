//! Scene of a road network: all lanes with their markings, junctions, crossings and signals. In: a [`Network`]. Out: meshes in world axes,
//! signal heads, and the paved surfaces that land must not cover. All lengths are in metres.
//!
//! `lanes` paves lanes and `junctions` the areas between them, both with `strips` and `triangulation`. `gores` paves and hatches the wedges
//! between roads that part or meet. `paint` adds stop lines and crossings, `symbols` arrows and bicycles, `verge` the roadside, `signals` the
//! signal heads with the pictures of `signal_faces`, `signs` the road signs with `sign_kind`, `name_signs`, `speed_limits` and `sign_plates`,
//! `posts` the reflector posts, `guard_rails` guard rails, `noise_walls` noise walls, `barriers` barriers at dead ends, `street_lamps` lamps. `town` says
//! which streets have pavements and lamps. `road_surfaces` keeps land, grass and trees off the pavement. `road_ends` lets roads run on at the network's
//! edge. `route_line` leads along the ego's path.

pub(super) mod barriers;
mod gores;
pub(super) mod guard_rails;
mod junctions;
mod lanes;
pub(super) mod layer;
mod name_signs;
pub(super) mod noise_walls;
mod paint;
pub(super) mod posts;
mod route_line;
pub(super) mod sign_kind;
mod sign_plates;
mod signal_faces;
pub(super) mod signals;
pub(super) mod signs;
mod speed_limits;
mod stated_signs;
pub(super) mod street_lamps;
mod strips;
mod symbols;
#[cfg(test)]
mod tests;
pub(super) mod triangulation;
mod verge;

pub(super) use route_line::{route_line, visible_part};

use self::strips::Paver;
use super::Mesh;
use crate::{
    map::network::Network,
    roadside::{junction_areas, relief::Relief, road_surfaces::RoadSurfaces, town::Town},
};

/// Returns the mesh of paved surfaces, markings, verges and bridges.
pub(super) fn road(net: &Network, town: &Town, surfaces: &RoadSurfaces, relief: &Relief, seed: u64) -> Mesh {
    let verges = verge::VergePaver::new(surfaces, town);
    let mut paver = Paver::new(relief, seed, surfaces.centre() - surfaces.radius_m());
    let areas = junction_areas::areas(net);
    areas.iter().for_each(|area| junctions::pave(area, &mut paver, verges));
    let shared = lanes::shared_areas(net);
    let area_of = areas.iter().map(|area| (area.junction, area)).collect();
    for lane in net.lane_ids() {
        lanes::pave(net, lane, &shared, &mut paver, verges);
        lanes::pave_ends(net, lane, &area_of, &mut paver);
    }
    gores::pave(net, &mut paver);
    paint::stop_lines(net, &mut paver);
    paint::crossings(net, &mut paver);
    symbols::paint(net, &mut paver);
    paver.mesh
}
