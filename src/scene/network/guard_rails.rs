//! Guard rails as a mesh. In: their posts. Out: one mesh, metres. Sizes are the project's own (`docs/references.md: roads`).

use crate::{
    roadside::guard_rails::{GuardRail, RailPost},
    scene::{Material, Mesh, Vertex},
};
use glam::{Vec2, Vec3};

/// Section of the rail from its lower to its upper edge: towards the road, above the road; metres.
const SECTION_M: [[f32; 2]; 4] = [[0.0, 0.44], [0.08, 0.52], [0.08, 0.67], [0.0, 0.75]];
/// Height of a rail's end as a share: it is led into the ground.
const END_SHARE: f32 = 0.12;
/// Width of a post along its road's direction of view, metres.
const POST_M: f32 = 0.11;
/// Linear albedo of galvanised steel.
const ZINC: [f32; 3] = [0.40, 0.41, 0.42];

/// Returns the mesh of guard rails.
pub(in crate::scene) fn mesh(rails: &[GuardRail]) -> Mesh {
    let mut mesh = Mesh::default();
    rails.iter().for_each(|rail| add_rail(&mut mesh, rail));
    mesh
}

/// Adds a rail along its posts.
fn add_rail(mesh: &mut Mesh, GuardRail { posts, into_ground }: &GuardRail) {
    let vertex = |mesh: &mut Mesh, position: Vec3, normal: Vec3| {
        mesh.vertex(Vertex::new(position, normal, ZINC, Vec2::ZERO, Material::Matt))
    };
    // The front's corners at a post, then the two of the back.
    let row = |mesh: &mut Mesh, post: &RailPost, share: f32| -> Vec<u32> {
        let at = |[out_m, up_m]: [f32; 2]| post.foot + post.to_road * out_m + Vec3::Z * up_m * share;
        let tilts = [-0.7, -0.3, 0.3, 0.7];
        let front = SECTION_M.iter().zip(tilts);
        let mut corners: Vec<u32> =
            front.map(|(of, tilt)| vertex(mesh, at(*of), (post.to_road + Vec3::Z * tilt).normalize())).collect();
        corners.extend([0, 3].map(|k| vertex(mesh, at(SECTION_M[k]), -post.to_road)));
        corners
    };
    let last = posts.len() - 1;
    let share = |k: usize| if k == 0 && into_ground[0] || k == last && into_ground[1] { END_SHARE } else { 1.0 };
    let rows: Vec<Vec<u32>> = posts.iter().enumerate().map(|(k, post)| row(mesh, post, share(k))).collect();
    // Seen from the road, a rail to the left runs from left to right.
    let is_left = posts[0].along.cross(Vec3::Z).dot(posts[0].to_road) > 0.0;
    let quad = |mesh: &mut Mesh, [a, b, c, d]: [u32; 4], faces_road: bool| {
        let corners = if faces_road == is_left { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] };
        mesh.indices.extend(corners);
    };
    for pair in rows.windows(2) {
        for k in 0..3 {
            quad(mesh, [pair[0][k], pair[1][k], pair[1][k + 1], pair[0][k + 1]], true);
        }
        quad(mesh, [pair[0][4], pair[1][4], pair[1][5], pair[0][5]], false);
    }
    for post in posts.iter().enumerate().filter(|(k, _)| share(*k) > END_SHARE).map(|(_, post)| post) {
        for facing in [-1.0, 1.0] {
            let (back, low, high) = (-post.to_road * POST_M, Vec3::NEG_Z * 0.4, Vec3::Z * 0.7);
            let corners = [low, back + low, back + high, high];
            let [a, b, c, d] = corners.map(|corner| vertex(mesh, post.foot + corner, post.along * facing));
            let faces_ahead = back.cross(Vec3::Z).dot(post.along) > 0.0;
            mesh.indices.extend(if faces_ahead == (facing > 0.0) { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        map::network::Network,
        roadside::{guard_rails::guard_rails, road_surfaces::RoadSurfaces},
        scene::mesh::tests::check,
    };

    #[test]
    fn the_rails_of_a_motorway_are_sound_and_have_few_triangles() {
        let net = Network::load("motorway").expect("a shipped map");
        let rails = guard_rails(&net, &RoadSurfaces::of(&net));
        let mesh = mesh(&rails);
        check(&mesh, "guard rails");
        let spans = rails.iter().flat_map(|rail| rail.posts.windows(2));
        let length_m: f32 = spans.map(|pair| pair[0].foot.distance(pair[1].foot)).sum();
        // Two triangles for each of the section's three faces and the back, and for both sides of a post, every 4 m.
        assert!(mesh.triangles() as f32 / length_m < 3.3, "{} triangles", mesh.triangles());
    }

    #[test]
    fn a_rail_faces_its_road_and_ends_in_the_ground() {
        let net = Network::load("tests/data/networks/ramps.net.xml").expect("a network");
        let rails = guard_rails(&net, &RoadSurfaces::of(&net));
        assert!(rails.iter().any(|rail| rail.into_ground.contains(&true)), "beside the ramps");
        for rail in rails {
            let mut mesh = Mesh::default();
            add_rail(&mut mesh, &rail);
            for (corners, face) in crate::scene::mesh::tests::faces(&mesh) {
                assert!(face.dot(Vec3::from(corners[0].normal)) > 0.0, "{corners:?}");
            }
            // Six corners at each post, the fourth of which is the upper edge.
            let upper_m = |at: usize| mesh.vertices[6 * at + 3].position[2] - rail.posts[at].foot.z;
            for (at, is_end) in [(0, rail.into_ground[0]), (rail.posts.len() - 1, rail.into_ground[1])] {
                let expected_m = if is_end { 0.09 } else { 0.75 };
                assert!((upper_m(at) - expected_m).abs() < 0.001, "{}", upper_m(at));
            }
        }
    }
}
