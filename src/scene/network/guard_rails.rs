//! Guard rails on both sides of fast roads with several lanes a direction. In: a network, its paved surfaces. Out: one mesh, metres. They are
//! for the picture alone. Places and sizes are the project's own (`docs/references.md: roads`).

use super::{layer::SHOULDER_M, road_surfaces::RoadSurfaces};
use crate::{
    map::network::{EdgeId, EdgeKind, LaneId, LanePosition, Network, Side},
    scene::{Material, Mesh, Vertex},
};
use glam::{DVec2, Vec2, Vec3};

/// Speed limit above which a road has guard rails, m/s: 80 km/h.
const GUARDED_MPS: f64 = 22.5;
/// Distance of a rail from the asphalt, metres: behind reflector posts.
const BESIDE_M: f64 = 0.95;
/// Distance between posts, metres.
const EVERY_M: f64 = 4.0;
/// Least distance of a post from any asphalt, and largest height of its road above the ground, metres: bridges have parapets.
const FREE_M: f32 = 0.6;
const BRIDGE_M: f32 = 1.5;
/// Section of the rail from its lower to its upper edge: towards the road, above the road; metres.
const SECTION_M: [[f32; 2]; 4] = [[0.0, 0.44], [0.08, 0.52], [0.08, 0.67], [0.0, 0.75]];
/// Height of a rail's end as a share: it is led into the ground.
const END_SHARE: f32 = 0.12;
/// Width of a post along its road's direction of view, metres.
const POST_M: f32 = 0.11;
/// Linear albedo of galvanised steel.
const ZINC: [f32; 3] = [0.40, 0.41, 0.42];

/// Point of a rail at a post: the point of the road's height under it, the unit vectors along the road and towards it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RailPost {
    foot: Vec3,
    along: Vec3,
    to_road: Vec3,
}

/// Returns the mesh of all guard rails.
pub(in crate::scene) fn guard_rails(net: &Network, surfaces: &RoadSurfaces) -> Mesh {
    let mut mesh = Mesh::default();
    for run in runs(net, surfaces) {
        add_rail(&mut mesh, &run);
    }
    mesh
}

/// Returns the posts of each rail without a gap, and for its two ends whether it is led into the ground there.
fn runs(net: &Network, surfaces: &RoadSurfaces) -> Vec<(Vec<RailPost>, [bool; 2])> {
    let mut runs = Vec::new();
    for lane in net.lane_ids().filter(|lane| is_guarded(net, *lane)) {
        for side in [Side::Right, Side::Left].into_iter().filter(|side| net.neighbour(lane, *side).is_none()) {
            let posts = beside(net, lane, side);
            let is_free = |post: &RailPost| {
                let at = post.foot.truncate();
                surfaces.border_m(at) > FREE_M && surfaces.height_m(at) > post.foot.z - BRIDGE_M
            };
            let last = posts.len() - 1;
            let mut start = 0;
            while start <= last {
                let length = posts[start..].iter().take_while(|post| is_free(post)).count();
                if length > 1 {
                    let end = start + length - 1;
                    runs.push((posts[start..=end].to_vec(), [start > 0, end < last]));
                }
                start += length + 1;
            }
        }
    }
    runs
}

/// Checks whether a lane belongs to a fast road with several lanes a direction; inside junctions, whether it leads on from one.
fn is_guarded(net: &Network, lane: LaneId) -> bool {
    let is_wide = |edge: EdgeId| net.edge(edge).lanes().filter(|lane| net.is_driven(*lane)).count() > 1;
    let of = net.lane(lane);
    let is_road = match net.edge(of.edge).kind {
        EdgeKind::Internal => net.predecessors(lane).iter().any(|before| is_wide(net.lane(*before).edge)),
        _ => net.is_driven(lane) && is_wide(of.edge),
    };
    is_road && of.admits_cars() && of.speed_limit_mps > GUARDED_MPS
}

/// Returns the places of posts beside a lane, the first and the last at its ends.
fn beside(net: &Network, lane: LaneId, side: Side) -> Vec<RailPost> {
    let of = net.lane(lane);
    let leftwards = if side == Side::Left { 1.0 } else { -1.0 };
    let offset_m = leftwards * (of.half_width_m() + f64::from(SHOULDER_M) + BESIDE_M);
    let count = (of.line.drawn_m() / EVERY_M).ceil().max(1.0);
    let post = |k: usize| {
        let at = net.pose(LanePosition { lane, s_m: of.length_m * k as f64 / count, offset_m });
        let ahead = DVec2::from_angle(at.yaw_rad);
        let to_road = (ahead.perp() * -leftwards).as_vec2().extend(0.0);
        RailPost { foot: at.position.as_vec3(), along: ahead.as_vec2().extend(0.0), to_road }
    };
    (0..=count as usize).map(post).collect()
}

/// Adds a rail along its posts.
fn add_rail(mesh: &mut Mesh, (posts, into_ground): &(Vec<RailPost>, [bool; 2])) {
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
    use crate::scene::{mesh::tests::check, network};

    #[test]
    fn rails_line_a_motorway_and_leave_its_ramps_free() {
        let net = Network::load("motorway").expect("a shipped map");
        let surfaces = network::surfaces(&net);
        let mesh = guard_rails(&net, &surfaces);
        check(&mesh, "guard rails");
        let runs = runs(&net, &surfaces);
        for post in runs.iter().flat_map(|(posts, _)| posts) {
            let beside_m = surfaces.border_m(post.foot.truncate());
            assert!((FREE_M..1.5).contains(&beside_m), "{post:?} is {beside_m} m from the asphalt");
        }
        let length_m: f32 =
            runs.iter().flat_map(|(posts, _)| posts.windows(2)).map(|pair| pair[0].foot.distance(pair[1].foot)).sum();
        let streets = net.edge_ids().filter(|edge| net.edge(*edge).kind.is_street());
        let wide = streets.filter_map(|edge| net.edge(edge).lanes().find(|lane| is_guarded(&net, *lane)));
        let both_sides_m: f64 = wide.map(|lane| 2.0 * net.lane(lane).line.drawn_m()).sum();
        let share = f64::from(length_m) / both_sides_m;
        assert!((0.9..1.02).contains(&share), "{length_m} m of rails for {both_sides_m} m");
        // Two triangles for each of the section's three faces and the back, and for both sides of a post, every 4 m.
        assert!(mesh.triangles() as f64 / f64::from(length_m) < 3.3, "{} triangles", mesh.triangles());
    }

    #[test]
    fn towns_and_circuits_have_no_rails() {
        for name in ["town", "grid", "ring-250", "practice", "figure-eight"] {
            let net = Network::load(name).expect("a shipped map");
            assert!(guard_rails(&net, &network::surfaces(&net)).indices.is_empty(), "{name}");
        }
    }

    #[test]
    fn a_rail_faces_its_road_and_ends_in_the_ground() {
        let net = Network::load("tests/data/networks/ramps.net.xml").expect("a network");
        let runs = runs(&net, &network::surfaces(&net));
        assert!(runs.iter().any(|(_, into_ground)| into_ground.contains(&true)), "beside the ramps");
        for run in runs {
            let mut mesh = Mesh::default();
            add_rail(&mut mesh, &run);
            for (corners, face) in crate::scene::mesh::tests::faces(&mesh) {
                assert!(face.dot(Vec3::from(corners[0].normal)) > 0.0, "{corners:?}");
            }
            // Six corners at each post, the fourth of which is the upper edge.
            let upper_m = |at: usize| mesh.vertices[6 * at + 3].position[2] - run.0[at].foot.z;
            for (at, is_end) in [(0, run.1[0]), (run.0.len() - 1, run.1[1])] {
                let expected_m = if is_end { 0.09 } else { 0.75 };
                assert!((upper_m(at) - expected_m).abs() < 0.001, "{}", upper_m(at));
            }
        }
    }
}
