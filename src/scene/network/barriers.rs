//! Barriers across roads that end within a network: a board of red and white fields on posts (sign 600 of German roads). In: the ends.
//! Out: one mesh, metres.

use super::signals::STEEL;
use crate::{
    roadside::road_ends::{BARRIER_BEYOND_M, DeadEnd},
    scene::{
        Material, Mesh,
        mesh::{SurfaceFinish, TriangleList},
    },
};
use glam::{Quat, Vec3};

/// Lower and upper edge of a board, and the width of its fields, metres.
const BOARD_M: [f32; 2] = [0.75, 1.0];
const FIELD_M: f32 = 0.5;
/// Greatest distance between posts, metres.
const POST_EVERY_M: f32 = 2.5;
const RED: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.50, 0.012, 0.014]);
const WHITE: SurfaceFinish = SurfaceFinish::grey(Material::Reflector, 0.72);

/// Returns the mesh of the barriers at these ends.
pub(in crate::scene) fn barriers(ends: &[DeadEnd]) -> Mesh {
    let mut mesh = Mesh::default();
    for DeadEnd { middle, outwards, half_width_m } in ends {
        let at = *middle + (*outwards * BARRIER_BEYOND_M).extend(0.0);
        let turn = Quat::from_rotation_z(outwards.y.atan2(outwards.x) as f32);
        mesh.append_placed(&model(*half_width_m as f32), turn, at.as_vec3());
    }
    mesh
}

/// Returns a barrier across a road of this half width, which runs along x.
fn model(half_width_m: f32) -> Mesh {
    let mut triangles = TriangleList::default();
    let fields = (2.0 * half_width_m / FIELD_M).round().max(2.0);
    let edge = |k: f32| half_width_m * (2.0 * k / fields - 1.0);
    for k in 0..fields as usize {
        let [from, to] = [k as f32, k as f32 + 1.0].map(edge);
        let [low, high] = BOARD_M;
        let middle = Vec3::new(0.0, (from + to) / 2.0, (low + high) / 2.0);
        let half = Vec3::new(0.015, (to - from) / 2.0, (high - low) / 2.0);
        triangles.cuboid(middle, half, if k % 2 == 0 { RED } else { WHITE });
    }
    let posts = (2.0 * half_width_m / POST_EVERY_M).ceil().max(1.0);
    for k in 0..=posts as usize {
        let y = (half_width_m - 0.1) * (2.0 * k as f32 / posts - 1.0);
        triangles.cuboid(Vec3::new(0.05, y, 0.35), Vec3::new(0.03, 0.03, 0.65), STEEL);
    }
    triangles.into_mesh(0.3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        map::network::Network,
        roadside::{road_ends, road_surfaces::RoadSurfaces},
        scene::mesh::tests::check,
    };
    use std::path::Path;

    #[test]
    fn a_dead_end_in_a_town_has_a_barrier_and_an_end_that_runs_on_has_none() {
        // A street to the east that ends after 60 m, between two streets 20 m to its sides that begin where it does.
        let edge = |id: &str, [from, to]: [&str; 2], shape: &str| {
            format!(
                "<edge id=\"{id}\" from=\"{from}\" to=\"{to}\"><lane id=\"{id}_0\" index=\"0\" speed=\"9\" length=\"200\" shape=\"{shape}\"/></edge>"
            )
        };
        let node = |id: &str, [x, y]: [f64; 2]| {
            format!(
                "<junction id=\"{id}\" type=\"priority\" x=\"{x}\" y=\"{y}\" incLanes=\"\" intLanes=\"\" shape=\"\"/>"
            )
        };
        let text = [
            "<net version=\"1.20\">".to_owned(),
            edge("dead", ["a", "b"], "0,0 60,0"),
            edge("left", ["c", "d"], "0,20 120,20"),
            edge("right", ["e", "f"], "0,-20 120,-20"),
            edge("across", ["d", "f"], "120,20 120,-20"),
            [("a", [0.0, 0.0]), ("b", [60.0, 0.0]), ("c", [0.0, 20.0]), ("d", [120.0, 20.0]), ("e", [0.0, -20.0])]
                .map(|(id, at)| node(id, at))
                .concat(),
            node("f", [120.0, -20.0]),
            "<connection from=\"left\" to=\"across\" fromLane=\"0\" toLane=\"0\" dir=\"r\" state=\"M\"/></net>"
                .to_owned(),
        ];
        let net = Network::read(Path::new("t.net.xml"), &text.concat()).expect("a network");
        let (longer, dead) = road_ends::running_on(&net, &RoadSurfaces::of(&net));
        let [end] = dead[..] else { panic!("{dead:?}") };
        assert!(longer.is_some(), "all other ends run on");
        assert_eq!((end.middle.to_array(), end.outwards.to_array()), ([60.0, 0.0, 0.0], [1.0, 0.0]));
        let mesh = barriers(&dead);
        check(&mesh, "barriers");
        // Across the lane of 3.2 m, beyond its end.
        let of_end = mesh.vertices.iter().filter(|vertex| vertex.position[0] > 50.0);
        let reach = |axis: usize| of_end.clone().map(move |vertex| vertex.position[axis]);
        assert!(reach(0).all(|x| (60.3..61.0).contains(&x)), "beyond the end");
        assert!((reach(1).fold(0.0, f32::max) - 1.6).abs() < 0.01 && (reach(1).fold(0.0, f32::min) + 1.6).abs() < 0.01);
    }
}
