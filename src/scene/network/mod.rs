//! The scene of a road network: all lanes with their markings, junctions, crossings and signals. In: a
//! [`Network`]. Out: meshes in world axes, heads of signals, and where the land may not be. Metres.
//!
//! `lanes` paves streets, `junctions` the areas between them, `strips` and `triangulation` are their tools; `paint` has stop lines and
//! crossings, `signals` the heads; `road_surfaces` keeps land, grass and trees off all of it.
//!
//! Surfaces that overlap lie in layers, a few millimetres one over the other, so that nothing flickers: see [`Layer`].

mod junctions;
mod lanes;
mod paint;
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
    land::{
        Relief,
        noise::shade,
        road::{ASPHALT, SHOULDER_M},
        road_distance::RoadDistance,
    },
};
use crate::map::network::{EdgeKind, LaneId, Network};
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

/// True of a network that is one closed chain of single lanes on one level, without signals and crossings of any kind, or that has no
/// lane at all: its closed route is all there is to draw, and is drawn in one piece.
pub(super) fn is_closed_route_alone(net: &Network) -> bool {
    let Some(first) = net.lane_ids().next() else { return true };
    let level_m = net.lane(first).line.points()[0].z;
    let only_next = |lane: LaneId| {
        let mut next = net.successors(lane);
        let found = next.next();
        found.filter(|_| next.next().is_none())
    };
    let plain = |lane: LaneId| {
        let level = net.lane(lane).line.points().iter().all(|point| point.z == level_m);
        let alone = net.edge_of(lane).lanes().len() == 1 && net.predecessors(lane).len() == 1;
        level && alone && only_next(lane).is_some()
    };
    let crossed = net.junctions().iter().any(|junction| junction.incoming.len() > 1);
    if crossed || !net.signals().is_empty() || !net.lane_ids().all(plain) {
        return false;
    }
    let (mut lane, mut lanes) = (first, 0);
    loop {
        lanes += 1;
        match only_next(lane) {
            Some(next) if next != first && lanes < net.lanes().len() => lane = next,
            _ => return lanes == net.lanes().len(),
        }
    }
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
pub(super) fn road(net: &Network, near: &RoadDistance, relief: &Relief, seed: u64) -> Mesh {
    let Some(surfaces) = near.surfaces() else { return Mesh::default() };
    let roadside = verge::Roadside::new(surfaces);
    let mut paver = Paver::new(relief, seed, near.centre() - near.radius_m());
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

/// Asphalt beyond the edge of the outermost lane, metres.
const SHOULDER: f64 = SHOULDER_M as f64;

fn points(shape: &[DVec3]) -> Vec<Vec3> {
    shape.iter().map(|point| point.as_vec3()).collect()
}
