//! Street lamps as a mesh. In: their places. Out: one mesh of posts, the lamps' heads. Metres.

use super::signals::pole;
use crate::{
    roadside::street_lamps::StreetLamp,
    scene::{
        Material, Mesh,
        mesh::{SurfaceFinish, TriangleList},
    },
};
use glam::{Quat, Vec3};

/// Height of a lamp over the street, metres.
pub const STREET_LAMP_M: f32 = 6.0;
/// Distance of the head from the post, metres.
const ARM_M: f32 = 1.1;
const STEEL: SurfaceFinish = SurfaceFinish::grey(Material::Metal, 0.22);
/// Lamp of which only the lens shows by day, and which is lit while headlamps are.
const LENS: SurfaceFinish = SurfaceFinish::new(Material::HeadLamp, [0.7, 0.0, 1.0]);

/// Returns the middle of a lamp's head.
pub(in crate::scene) fn head(lamp: &StreetLamp) -> Vec3 {
    lamp.foot + Vec3::Z * STREET_LAMP_M + lamp.to_street * ARM_M
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
    use crate::{
        map::RoadMap,
        roadside::{road_surfaces::RoadSurfaces, street_lamps::street_lamps, town::Town},
        scene::mesh::tests::check,
    };

    #[test]
    fn lamps_stand_along_the_streets_of_a_town_beside_the_asphalt() {
        let grid = RoadMap::load("grid").unwrap().network;
        let roads = RoadSurfaces::of(&grid);
        let lamps = street_lamps(&grid, &Town::of(&grid), &roads);
        check(&mesh(&lamps), "lamps");
        // 24 streets of about 190 m between the junctions, with lamps 48 m apart on both sides.
        assert!((24 * 2 * 3..24 * 2 * 5).contains(&lamps.len()), "{}", lamps.len());
        for lamp in &lamps {
            let (post_m, head_m) = (roads.border_m(lamp.foot.truncate()), roads.border_m(head(lamp).truncate()));
            assert!((0.5..1.5).contains(&post_m) && head_m < 0.5, "{post_m} {head_m}");
        }
        for name in ["motorway", "merge", "practice", "ring-250"] {
            let network = RoadMap::load(name).unwrap().network;
            assert!(street_lamps(&network, &Town::of(&network), &RoadSurfaces::of(&network)).is_empty(), "{name}");
        }
    }
}
