//! Reflector posts beside roads outside towns, at equal distances: a cue for speed. In: a network. Out: one mesh, metres.

use super::{lanes::no_one_meets, layer::SHOULDER_M};
use crate::{
    map::network::{LaneId, LanePosition, Network, Side},
    roadside::{road_surfaces::RoadSurfaces, town::TOWN_MPS},
    scene::{
        Material, Mesh,
        mesh::{SurfaceFinish, TriangleList},
    },
};
use glam::{DVec2, Quat, Vec3};
use std::collections::BTreeSet;

/// Distance between posts along the road, m (as on German roads in narrow bends).
pub const POST_EVERY_M: f64 = 25.0;
/// Distance between a post and the asphalt, m.
const POST_BESIDE_M: f32 = 0.75;
/// Height of a post, m.
const POST_HEIGHT_M: f32 = 1.0;
/// Depth of a post's foot in the ground, m.
const FOOT_M: f32 = 0.08;
/// Minimum distance between a post and any asphalt, m. Nearer posts are left out.
const FREE_M: f32 = 0.5;

/// Returns all posts, on the outer side of the outermost lanes: the right, or the left with left-hand traffic.
pub(in crate::scene) fn posts(net: &Network, surfaces: &RoadSurfaces) -> Mesh {
    let post = post();
    let mut mesh = Mesh::default();
    let outwards = if net.is_left_hand() { 1.0 } else { -1.0 };
    for (lanes, is_closed) in chains(net) {
        let length_m: f64 = lanes.iter().map(|lane| net.lane(*lane).line.drawn_m()).sum();
        let count = (length_m / POST_EVERY_M).round() as usize;
        // The ends of an open chain may be junctions with other roads: keep half a spacing from them.
        let first_m = if is_closed { 0.0 } else { POST_EVERY_M / 2.0 };
        let (mut lane, mut start_m) = (0, 0.0);
        for k in 0..count {
            let along_m = first_m + k as f64 * POST_EVERY_M;
            let end_m = |lane: usize, start_m: f64| start_m + net.lane(lanes[lane]).line.drawn_m();
            while lane + 1 < lanes.len() && along_m > end_m(lane, start_m) {
                start_m = end_m(lane, start_m);
                lane += 1;
            }
            let of = net.lane(lanes[lane]);
            let s_m = (along_m - start_m) / of.line.drawn_m() * of.length_m;
            let aside_m = of.half_width_m() + f64::from(SHOULDER_M + POST_BESIDE_M);
            let road = net.pose(LanePosition { lane: lanes[lane], s_m, offset_m: 0.0 });
            let left = DVec2::from_angle(road.yaw_rad).perp();
            let foot = (road.position + (left * outwards * aside_m).extend(0.0)).as_vec3();
            let is_free = surfaces.border_m(foot.truncate()) > FREE_M;
            // On bridges, posts would stand in the air.
            if !is_free || surfaces.is_on_bridge(foot) {
                continue;
            }
            let turn =
                Quat::from_rotation_z(road.yaw_rad as f32 + if outwards > 0.0 { std::f32::consts::PI } else { 0.0 });
            mesh.append_placed(&post, turn, foot - Vec3::Z * FOOT_M);
        }
    }
    mesh
}

/// Returns chains of outermost lanes that follow each other without a crossing, including the lanes inside junctions between them. The
/// flag is true if a chain is closed.
fn chains(net: &Network) -> Vec<(Vec<LaneId>, bool)> {
    let outermost = |lane: &LaneId| {
        let outer = if net.is_left_hand() { Side::Left } else { Side::Right };
        net.is_driven(*lane) && net.neighbour(*lane, outer).is_none() && net.lane(*lane).speed_limit_mps > TOWN_MPS
    };
    let streets: BTreeSet<LaneId> = net.lane_ids().filter(outermost).collect();
    // Lanes up to the next street, if the way there is unambiguous and no other lane crosses or joins it.
    let next = |lane: LaneId| -> Option<Vec<LaneId>> {
        let mut inside = Vec::new();
        let mut at = lane;
        loop {
            let mut after = net.successors(at);
            let (only, None) = (after.next()?, after.next()) else { return None };
            if net.predecessors(only) != [at] {
                return None;
            }
            inside.push(only);
            if streets.contains(&only) {
                return Some(inside);
            }
            if net.edge_of(only).kind.is_street() || !no_one_meets(net, only) || inside.len() > 16 {
                return None;
            }
            at = only;
        }
    };
    let has_before: BTreeSet<LaneId> = streets.iter().filter_map(|lane| next(*lane)?.last().copied()).collect();
    let mut seen = BTreeSet::new();
    let mut chains = Vec::new();
    // Open chains first; the remaining lanes form closed ones.
    for &start in streets.difference(&has_before).chain(&streets) {
        if !seen.insert(start) {
            continue;
        }
        let (mut lanes, mut is_closed) = (vec![start], false);
        while let Some(on) = next(lanes[lanes.len() - 1]) {
            let street = on[on.len() - 1];
            is_closed = street == start;
            if is_closed || !seen.insert(street) {
                lanes.extend(&on[..on.len() - 1]);
                break;
            }
            lanes.extend(on);
        }
        chains.push((lanes, is_closed));
    }
    chains
}

/// Returns one post: white, with a black band near its top and a reflector at either end of the band. The reflectors face along ±x.
fn post() -> Mesh {
    let white = SurfaceFinish::grey(Material::Matt, 0.72);
    let black = SurfaceFinish::grey(Material::Matt, 0.015);
    let mut triangles = TriangleList::default();
    // A triangle with blunt corners, as moulded posts have. Its narrow edge points away from the road.
    let outline = [(-0.045, 0.055), (-0.012, -0.055), (0.012, -0.055), (0.045, 0.055), (0.03, 0.065), (-0.03, 0.065)];
    let bands = [(0.0, 0.66, white), (0.66, 0.88, black), (0.88, POST_HEIGHT_M, white)];
    for (low, high, finish) in bands {
        for k in 0..outline.len() {
            let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
            // The band and the top slope down towards the road.
            let at = |(x, y): (f32, f32), z: f32| Vec3::new(x, y, if z > 0.0 { z - y * 0.5 } else { z });
            triangles.quad([at(a, low), at(b, low), at(b, high), at(a, high)], finish);
        }
    }
    let top = |(x, y): (f32, f32)| Vec3::new(x, y, POST_HEIGHT_M - y * 0.5);
    for k in 1..outline.len() - 1 {
        triangles.triangle([top(outline[0]), top(outline[k]), top(outline[k + 1])], white);
    }
    for side in [-1.0, 1.0] {
        triangles.cuboid(
            Vec3::new(side * 0.034, 0.022, 0.765),
            Vec3::new(0.008, 0.016, 0.075),
            SurfaceFinish::grey(Material::Reflector, 0.8),
        );
    }
    triangles.into_mesh(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{
        mesh::tests::check,
        static_scene::tests::{circuit, ring},
    };
    use glam::Vec2;

    fn feet(net: &Network) -> Vec<Vec2> {
        let all = posts(net, &RoadSurfaces::of(net));
        if !all.indices.is_empty() {
            check(&all, "posts");
        }
        let one = post().vertices.len();
        all.vertices.chunks(one).map(|c| Vec3::from(c[0].position).truncate()).collect()
    }

    #[test]
    fn posts_stand_every_25_m_beside_the_road() {
        for map in [ring(250.0), ring(641.0), circuit()] {
            let feet = feet(&map.network);
            assert_eq!(feet.len(), (map.route.length_m() / POST_EVERY_M).round() as usize);
            for (k, foot) in feet.iter().enumerate() {
                let found = map.route.project(foot.as_dvec2(), None);
                let along = map.route.wrap(found.s_m - k as f64 * POST_EVERY_M + 1.0) - 1.0;
                assert!(along.abs() < 0.1, "post {k} is {along} m off");
                let beyond = -found.offset_m - map.route.width_m(found.s_m) / 2.0 - f64::from(SHOULDER_M);
                assert!((0.5..1.0).contains(&beyond), "{beyond} m beside the asphalt");
            }
        }
    }

    #[test]
    fn posts_stand_on_no_asphalt_and_in_no_town() {
        let net = |name: &str| Network::load(&format!("tests/data/networks/{name}.net.xml")).expect("a network");
        // A motorway with entry and exit ramps.
        let ramps = net("ramps");
        let (surfaces, feet_of_ramps) = (RoadSurfaces::of(&ramps), feet(&ramps));
        assert!(!feet_of_ramps.is_empty());
        assert!(feet_of_ramps.iter().all(|foot| surfaces.border_m(*foot) > FREE_M - 0.1));
        // All limits are 50 km/h.
        assert!(feet(&net("town")).is_empty());
    }
}
