//! Places of street lamps along the streets of towns. In: a network, its paved surfaces. Out: the lamps' feet, metres.

use super::{
    road_surfaces::RoadSurfaces,
    town::{PAVEMENT_FREE_M, PAVEMENT_M, Town},
};
use crate::map::{
    SHOULDER_M,
    network::{LaneId, LanePosition, Network, Side},
};
use glam::{DVec2, Vec3};

/// Distance between the lamps on one side of a street, metres.
const EVERY_M: f64 = 48.0;
/// Length of the shortest street with lamps, metres.
const SHORTEST_M: f64 = 20.0;
/// Distance of a post from the kerb, or from the outer edge of a pavement of the network, metres.
const FROM_KERB_M: f32 = 0.45;

/// Lamp over the edge of a street.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreetLamp {
    /// Foot of its post.
    pub foot: Vec3,
    /// Unit vector from the post to the street.
    pub to_street: Vec3,
}

/// Returns the lamps of a town: on the outer side of each direction, those of two directions opposite the gaps.
pub fn street_lamps(net: &Network, town: &Town, surfaces: &RoadSurfaces) -> Vec<StreetLamp> {
    let outer = if net.is_left_hand() { Side::Left } else { Side::Right };
    let outermost = |lane: &LaneId| town.has_street(net.lane(*lane).edge) && net.neighbour(*lane, outer).is_none();
    net.lane_ids().filter(outermost).flat_map(|lane| beside(net, surfaces, lane, outer)).collect()
}

fn beside(net: &Network, surfaces: &RoadSurfaces, id: LaneId, outer: Side) -> Vec<StreetLamp> {
    let lane = net.lane(id);
    let drawn_m = lane.line.drawn_m();
    if drawn_m < SHORTEST_M {
        return Vec::new();
    }
    let half_m = lane.half_width_m() as f32;
    let (aside_m, edge_m) = match lane.is_footway() {
        true => (half_m - FROM_KERB_M, half_m),
        false => (half_m + SHOULDER_M as f32 + FROM_KERB_M, half_m + SHOULDER_M as f32 + PAVEMENT_M),
    };
    let count = (drawn_m / EVERY_M).round().max(1.0);
    let lamp = |k: usize| {
        // A quarter of the spacing from the street's start: that of the other direction is then half a spacing away.
        let row_m = drawn_m * (k as f64 + 0.25) / count;
        let road = net.pose(LanePosition { lane: id, s_m: row_m / drawn_m * lane.length_m, offset_m: 0.0 });
        let left = DVec2::from_angle(road.yaw_rad).perp().as_vec2().extend(0.0);
        let outwards = if outer == Side::Left { left } else { -left };
        let at = |beside_m: f32| road.position.as_vec3() + outwards * beside_m;
        let lamp = StreetLamp { foot: at(aside_m), to_street: -outwards };
        let is_free = lane.is_footway() || surfaces.border_m(at(edge_m).truncate()) > PAVEMENT_FREE_M;
        is_free.then_some(lamp)
    };
    (0..count as usize).filter_map(lamp).collect()
}
