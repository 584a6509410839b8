//! The scene of a road network: all lanes with their markings, junctions, crossings and signals. In: a
//! [`Network`]. Out: meshes in world axes, heads of signals, and where the land may not be. Metres.
//!
//! `lanes` paves streets, `junctions` the areas between them, `strips` and `triangulation` are their tools; `paint` has stop lines and
//! crossings, `signals` the heads, `posts` the reflector posts; `road_surfaces` keeps land, grass and trees off all of it.
//!
//! Surfaces that overlap lie in layers, a few millimetres one over the other, so that nothing flickers: see [`Layer`].

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

/// Height of a surface over its lane's centre line, metres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layer {
    /// Stop lines and crossings.
    Paint,
    /// Pavements and the corners where people wait.
    Pavement,
    /// Ways across junctions where people walk on the same ground.
    SharedWay,
    /// Where people walk and vehicles cross.
    Shared,
    /// Lanes of streets, with their markings.
    Street,
    /// Areas of junctions.
    Junction,
    /// The shoulder around junctions.
    Apron,
    /// Ways across junctions, where areas leave a gap.
    Way,
    /// What closes seams between lanes.
    Seam,
    /// The upper edge of the verge, under the asphalt's edge.
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

/// Colour of asphalt where no wheel runs.
fn plain_asphalt() -> [f32; 3] {
    shade(ASPHALT, 1.04)
}

/// All that is paved, for the land around it.
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

/// The paved surfaces with their markings, and the verges beside them.
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

/// True of a way through a junction whose ways cross nowhere.
fn no_one_meets(net: &Network, inside: LaneId) -> bool {
    let junction = net.edge_of(inside).junction.map(|junction| net.junction(junction));
    junction.is_some_and(|junction| junction.links.iter().all(|link| link.crosses.iter().next().is_none()))
}

/// Asphalt beyond the edge of the outermost lane, metres.
const SHOULDER: f64 = map::SHOULDER_M;
/// The same for the picture, m.
pub(super) const SHOULDER_M: f32 = map::SHOULDER_M as f32;

/// Dark asphalt, linear albedo.
const ASPHALT: [f32; 3] = [0.082, 0.082, 0.086];
/// Paint of markings, linear albedo.
const PAINT: [f32; 3] = [0.70, 0.70, 0.67];

fn points(shape: &[DVec3]) -> Vec<Vec3> {
    shape.iter().map(|point| point.as_vec3()).collect()
}
