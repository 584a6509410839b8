//! Street lamps along the streets of towns. In: a network, its paved surfaces. Out: the lamps' heads, one mesh of posts. Metres.

use super::{layer::SHOULDER_M, signals::pole};
use crate::{
    map::network::{LaneId, LanePosition, Network, Side},
    roadside::{
        road_surfaces::RoadSurfaces,
        town::{PAVEMENT_FREE_M, PAVEMENT_M, Town},
    },
    scene::{
        Material, Mesh,
        mesh::{SurfaceFinish, TriangleList},
    },
};
use glam::{DVec2, Quat, Vec3};

/// Distance between the lamps on one side of a street, metres.
const EVERY_M: f64 = 48.0;
/// Length of the shortest street with lamps, metres.
const SHORTEST_M: f64 = 20.0;
/// Height of a lamp over the street, metres.
pub const STREET_LAMP_M: f32 = 6.0;
/// Distance of a post from the kerb, or from the outer edge of a pavement of the network, metres.
const FROM_KERB_M: f32 = 0.45;
/// Distance of the head from the post, metres.
const ARM_M: f32 = 1.1;
const STEEL: SurfaceFinish = SurfaceFinish::grey(Material::Metal, 0.22);
/// Lamp of which only the lens shows by day, and which is lit while headlamps are.
const LENS: SurfaceFinish = SurfaceFinish::new(Material::HeadLamp, [0.7, 0.0, 1.0]);

/// Lamp over the edge of a street.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) struct StreetLamp {
    /// Foot of its post.
    foot: Vec3,
    /// Unit vector from the post to the street.
    to_street: Vec3,
}

impl StreetLamp {
    /// Returns the middle of the lamp's head.
    pub fn head(&self) -> Vec3 {
        self.foot + Vec3::Z * STREET_LAMP_M + self.to_street * ARM_M
    }
}

/// Returns the lamps of a town: on the outer side of each direction, those of two directions opposite the gaps.
pub(in crate::scene) fn street_lamps(net: &Network, town: &Town, surfaces: &RoadSurfaces) -> Vec<StreetLamp> {
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
        false => (half_m + SHOULDER_M + FROM_KERB_M, half_m + SHOULDER_M + PAVEMENT_M),
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

/// Returns the mesh of all lamps.
pub(in crate::scene) fn mesh(lamps: &[StreetLamp]) -> Mesh {
    let model = model();
    let mut mesh = Mesh::default();
    for lamp in lamps {
        let yaw_rad = lamp.to_street.y.atan2(lamp.to_street.x);
        mesh.append_placed(&model, Quat::from_rotation_z(yaw_rad), lamp.foot);
    }
    mesh
}

/// Returns one lamp, with its arm along x.
fn model() -> Mesh {
    let mut triangles = TriangleList::default();
    pole(&mut triangles, Vec3::ZERO, STREET_LAMP_M + 0.06);
    let middle = Vec3::new(ARM_M / 2.0, 0.0, STREET_LAMP_M + 0.1);
    triangles.cuboid(middle, Vec3::new(ARM_M / 2.0, 0.035, 0.035), STEEL);
    triangles.cuboid(Vec3::new(ARM_M, 0.0, STREET_LAMP_M + 0.08), Vec3::new(0.36, 0.13, 0.055), STEEL);
    triangles.cuboid(Vec3::new(ARM_M, 0.0, STREET_LAMP_M + 0.015), Vec3::new(0.30, 0.10, 0.015), LENS);
    triangles.into_mesh(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{map::RoadMap, scene::mesh::tests::check};

    #[test]
    fn lamps_stand_along_the_streets_of_a_town_beside_the_asphalt() {
        let grid = RoadMap::load("grid").unwrap().network;
        let roads = RoadSurfaces::of(&grid);
        let lamps = street_lamps(&grid, &Town::of(&grid), &roads);
        check(&mesh(&lamps), "lamps");
        // 24 streets of about 190 m between the junctions, with lamps 48 m apart on both sides.
        assert!((24 * 2 * 3..24 * 2 * 5).contains(&lamps.len()), "{}", lamps.len());
        for lamp in &lamps {
            let (post_m, head_m) = (roads.border_m(lamp.foot.truncate()), roads.border_m(lamp.head().truncate()));
            assert!((0.5..1.5).contains(&post_m) && head_m < 0.5, "{post_m} {head_m}");
        }
        for name in ["motorway", "merge", "practice", "ring-250"] {
            let network = RoadMap::load(name).unwrap().network;
            assert!(street_lamps(&network, &Town::of(&network), &RoadSurfaces::of(&network)).is_empty(), "{name}");
        }
    }
}
