//! Scene of a road network: all lanes with their markings, junctions, crossings and signals. In: a [`Network`]. Out: meshes in world axes,
//! signal heads, and the paved surfaces that land must not cover. All lengths are in metres.
//!
//! `lanes` paves lanes and `junctions` the areas between them, both with `strips` and `triangulation`. `paint` adds stop lines and
//! crossings, `verge` the roadside, `signals` the signal heads, `posts` the reflector posts. `road_surfaces` keeps land, grass and trees
//! off the pavement.
//!
//! Overlapping surfaces lie in layers a few millimetres apart, which prevents z-fighting: see [`Layer`].

mod junctions;
mod lanes;
mod paint;
pub(super) mod posts;
pub(super) mod road_surfaces;
pub(super) mod signals;
mod strips;
#[cfg(test)]
mod tests;
mod triangulation;
pub(super) mod verge;

use self::{
    road_surfaces::{RoadSurfaces, SurfaceCollector},
    strips::Paver,
};
use super::{
    Mesh,
    land::{Relief, noise::shade},
};
use crate::map::{
    self,
    network::{EdgeKind, LaneId, Network},
};
use glam::{DVec3, Vec3};

/// Layer of a surface. Its height above the lane's centre line is [`Layer::z_m`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layer {
    /// Stop lines and crossings.
    Paint,
    /// Pavements, and walking areas that no vehicle crosses.
    Pavement,
    /// Lanes inside a junction that has a shared walking area.
    SharedWay,
    /// Walking areas that vehicles drive across.
    Shared,
    /// Lanes of streets, with their markings.
    Street,
    /// Area of a junction, inside its outline.
    Junction,
    /// Shoulder around the areas of junctions.
    Apron,
    /// Lanes inside junctions, visible where the junction's area has a gap.
    Way,
    /// Strips of asphalt under the seams between lanes.
    Seam,
    /// Upper edge of the verge, under the asphalt's edge.
    Verge,
}

impl Layer {
    fn z_m(self) -> f32 {
        match self {
            Self::Paint => 0.006,
            Self::Pavement => 0.03,
            Self::Street => 0.0,
            Self::SharedWay => -0.002,
            Self::Shared => -0.004,
            Self::Junction => -0.006,
            Self::Apron => -0.009,
            Self::Way => -0.012,
            Self::Seam => -0.015,
            Self::Verge => -0.020,
        }
    }
}

/// Returns the colour of asphalt outside wheel tracks, linear albedo.
fn plain_asphalt() -> [f32; 3] {
    shade(ASPHALT, 1.04)
}

/// Returns all paved surfaces of a network, for the land around them.
pub(super) fn surfaces(net: &Network) -> RoadSurfaces {
    let mut collector = SurfaceCollector::default();
    for id in net.lane_ids() {
        let lane = net.lane(id);
        match net.edge_of(id).kind {
            EdgeKind::WalkingArea => collector.area(&points(lane.shape())),
            EdgeKind::Crossing => {}
            _ => collector.line(&points(lane.line.points()), lane.half_width_m() as f32),
        }
    }
    for area in junctions::areas(net) {
        collector.area(&area.outline);
    }
    RoadSurfaces::new(collector)
}

/// Returns the mesh of paved surfaces, markings, verges and bridges.
pub(super) fn road(net: &Network, surfaces: &RoadSurfaces, relief: &Relief, seed: u64) -> Mesh {
    let roadside = verge::Roadside::new(surfaces);
    let mut paver = Paver::new(relief, seed, surfaces.centre() - surfaces.radius_m());
    let areas = junctions::areas(net);
    areas.iter().for_each(|area| junctions::pave(area, &mut paver, roadside));
    let shared = lanes::shared_areas(net);
    for lane in net.lane_ids() {
        lanes::pave(net, lane, &shared, &mut paver, roadside);
    }
    paint::stop_lines(net, &mut paver);
    paint::crossings(net, &mut paver);
    paver.mesh
}

/// Checks whether a lane is inside a junction that has no crossing connections.
fn no_one_meets(net: &Network, inside: LaneId) -> bool {
    let junction = net.edge_of(inside).junction.map(|junction| net.junction(junction));
    junction.is_some_and(|junction| junction.links.iter().all(|link| link.crosses.iter().next().is_none()))
}

/// Width of the shoulder: asphalt beyond the edge of the outermost lane, metres.
const SHOULDER: f64 = map::SHOULDER_M;
/// Width of the shoulder in single precision, for meshes, metres.
pub(super) const SHOULDER_M: f32 = map::SHOULDER_M as f32;

/// Base colour of asphalt, linear albedo.
const ASPHALT: [f32; 3] = [0.082, 0.082, 0.086];
/// Paint of markings, linear albedo.
const PAINT: [f32; 3] = [0.70, 0.70, 0.67];

fn points(shape: &[DVec3]) -> Vec<Vec3> {
    shape.iter().map(|point| point.as_vec3()).collect()
}
