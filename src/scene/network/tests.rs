//! Tests of a whole network's scene. In: networks of `tests/data/networks`. Out: nothing.

use super::*;
use crate::{
    map::network::{EdgeKind, LaneId, LanePosition, REACH_M, SignalStates, TurnDirection},
    rng,
    roadside::{
        outlines::{self, cleaned},
        trees::forest::TRUNK_FREE_M,
    },
    scene::{
        self, SignalHead, StaticScene, ViewKind, ViewOptions,
        mesh::tests::{check, faces},
        trees::forest::tests::crown_radius_m,
    },
    sim::{Snapshot, VehicleSnapshot},
    space::Pose,
};
use glam::{Vec2, Vec3};
use std::sync::Arc;

fn network(name: &str) -> Arc<Network> {
    Arc::new(Network::load(&format!("tests/data/networks/{name}.net.xml")).expect("a network of the tests"))
}

/// Returns the distance from the nearest lane's edge or junction by brute force, metres, for comparison.
fn border_m(net: &Network, point: Vec2) -> f32 {
    let lanes =
        net.lane_ids().filter(|id| !matches!(net.edge_of(*id).kind, EdgeKind::WalkingArea | EdgeKind::Crossing));
    let of_lane = |id: LaneId| {
        let lane = net.lane(id);
        let steps = (lane.length_m / 0.25).ceil() as usize;
        let place =
            |k: usize| lane.line.pose(lane.length_m * k as f64 / steps as f64, 0.0).position.as_vec3().truncate();
        let line_m = (0..=steps).map(|k| place(k).distance(point)).fold(f32::INFINITY, f32::min);
        line_m - lane.half_width_m() as f32
    };
    let lanes_m = lanes.map(of_lane).fold(f32::INFINITY, f32::min);
    let inside = junction_areas::areas(net).iter().any(|area| outlines::contains(&area.outline, point));
    if inside { 0.0 } else { lanes_m.max(0.0) }
}

#[test]
fn distances_are_those_of_all_lanes_and_junctions() {
    let mut random = rng::stream(1, "surfaces");
    for name in ["roundabout", "hill", "town-left"] {
        let net = network(name);
        let surfaces = RoadSurfaces::of(&net);
        // The corners of junctions are paved although no lane is near.
        for area in junction_areas::areas(&net) {
            let n = area.outline.len();
            let middle = area.outline.iter().map(|corner| corner.truncate()).sum::<Vec2>() / n as f32;
            for corner in &area.outline {
                let inside = corner.truncate().lerp(middle, 0.2);
                let paved = !outlines::contains(&area.outline, inside) || surfaces.border_m(inside) == 0.0;
                assert!(paved, "{name} {inside} is in a junction: {}", surfaces.border_m(inside));
            }
        }
        let (low, high) = net.bounds();
        for _ in 0..150 {
            let point = Vec2::new(
                random.uniform(low.x - 60.0, high.x + 60.0) as f32,
                random.uniform(low.y - 60.0, high.y + 60.0) as f32,
            );
            let (found, exact) = (surfaces.border_m(point), border_m(&net, point));
            // The brute-force points are 25 cm apart. Outlines of junctions and walking areas reach a little beyond lanes.
            if exact < 80.0 {
                assert!(found <= exact + 0.02 && found > exact - 9.0, "{name} {point}: {found}, {exact}");
            }
            let on_street = net.locate(point.as_dvec2().extend(0.0), None).is_some_and(|at: LanePosition| {
                let lane = net.lane(at.lane);
                net.edge_of(at.lane).kind.is_street()
                    && at.offset_m.abs() < lane.half_width_m() - 0.1
                    && (0.5..lane.length_m - 0.5).contains(&at.s_m)
            });
            assert!(!on_street || found == 0.0, "{name} {point} is on a street: {found}");
        }
    }
}

/// Returns the heights of a mesh at a point, metres. Triangles larger than 64 m are left out.
fn heights(mesh: &Mesh) -> impl Fn(Vec2) -> Vec<f32> {
    // Triangles, sorted into squares of 8 m.
    let mut squares: std::collections::BTreeMap<[i32; 2], Vec<[Vec3; 3]>> = Default::default();
    for (corners, _) in faces(mesh) {
        let corners = corners.map(|corner| Vec3::from(corner.position));
        let square = |p: Vec3| (p.truncate() / 8.0).floor().as_ivec2();
        let low = square(corners[0].min(corners[1]).min(corners[2]));
        let high = square(corners[0].max(corners[1]).max(corners[2]));
        if (high - low).max_element() > 8 {
            continue;
        }
        for x in low.x..=high.x {
            (low.y..=high.y).for_each(|y| squares.entry([x, y]).or_default().push(corners));
        }
    }
    move |point: Vec2| {
        let square = (point / 8.0).floor().as_ivec2().to_array();
        let here = squares.get(&square).into_iter().flatten();
        let height_m = |[a, b, c]: &[Vec3; 3]| {
            let [u, v, w] = [a, b, c].map(|p| p.truncate() - point);
            let (wa, wb, wc) = (v.perp_dot(w), w.perp_dot(u), u.perp_dot(v));
            let all = wa + wb + wc;
            let inside = [wa, wb, wc].iter().all(|weight| weight * all.signum() >= -1e-4);
            (inside && all.abs() > 1e-6).then(|| (wa * a.z + wb * b.z + wc * c.z) / all)
        };
        here.filter_map(height_m).collect()
    }
}

#[test]
fn asphalt_goes_on_below_the_step_from_a_junction_to_its_lanes() {
    // The area of a junction lies 6 mm below the lanes. Who looks along the road from the junction sees below the edge of a lane.
    for name in ["town", "town-left", "roundabout", "spider", "random-3", "grid-signals"] {
        let net = network(name);
        let scene = StaticScene::of_network(&net, 1, 0);
        let heights_m = heights(&scene.road);
        let areas = junction_areas::areas(&net);
        let mut seen = 0;
        for id in net.lane_ids().filter(|id| net.is_driven(*id) && net.edge_of(*id).kind.is_street()) {
            let (lane, edge) = (net.lane(id), net.edge_of(id));
            for (junction, s_m) in [(edge.to, lane.length_m - 0.02), (edge.from, 0.02)] {
                if !areas.iter().any(|area| Some(area.junction) == junction) {
                    continue;
                }
                for share in [-0.9, -0.5, 0.0, 0.5, 0.9] {
                    let at = lane.line.pose(s_m, share * lane.half_width_m()).position.as_vec3();
                    let is_below = |height_m: &f32| (0.006..0.013).contains(&(at.z - height_m));
                    assert!(heights_m(at.truncate()).iter().any(is_below), "{name}: below {at} of {}", lane.id);
                    seen += 1;
                }
            }
        }
        assert!(seen > 50, "{name}: {seen}");
    }
}

#[test]
fn the_land_follows_roads_and_never_covers_one() {
    for name in ["hill", "town", "ramps"] {
        let net = network(name);
        let static_scene = StaticScene::of_network(&net, 1, 0);
        check(&static_scene.road, name);
        let heights_m = heights(&static_scene.land);
        let mut seen = 0;
        for id in net.lane_ids().filter(|id| net.edge_of(*id).kind.is_street()) {
            let lane = net.lane(id);
            let mut s_m = 1.0;
            while s_m < lane.length_m {
                for offset_m in [-1.0, 0.0, 1.0] {
                    let road = lane.line.pose(s_m, offset_m * lane.half_width_m()).position.as_vec3();
                    let land_m = heights_m(road.truncate()).into_iter().next().expect("there is land under every road");
                    assert!(land_m < road.z - 0.01, "{name}: land at {land_m} m on {} at {s_m} m, {road}", lane.id);
                    seen += 1;
                }
                s_m += 3.7;
            }
        }
        assert!(seen > 300, "{name}: {seen}");
    }
}

#[test]
fn no_tree_and_no_tuft_stands_on_a_road() {
    for name in ["grid-signals", "town", "ramps", "roundabout"] {
        let net = network(name);
        let static_scene = StaticScene::of_network(&net, 3, 600);
        assert!(static_scene.tree_places.len() > 200, "{name}: {} trees", static_scene.tree_places.len());
        for tree in &static_scene.tree_places {
            let at = tree.position.truncate();
            let free_m = border_m(&net, at);
            assert!(free_m > TRUNK_FREE_M - 0.05, "{name}: a tree {free_m} m from a lane");
            let crown_m = crown_radius_m(&static_scene.trees[tree.kind]) * tree.scale;
            assert!(free_m - crown_m > 0.9, "{name}: a crown {} m from a lane", free_m - crown_m);
        }
        assert!(static_scene.tuft_places.len() > 5000, "{name}");
        for tuft in static_scene.tuft_places.iter().step_by(97) {
            let place = net.locate(tuft.position.as_dvec3(), None);
            let beside_m = place.map_or(REACH_M, |at| at.offset_m.abs() - net.lane(at.lane).half_width_m());
            assert!(beside_m > 0.5 || border_m(&net, tuft.position.truncate()) > 0.5, "{name}: {tuft:?}");
        }
    }
}

#[test]
fn surfaces_face_up_but_for_kerbs_and_fill_junctions() {
    for name in ["grid-signals", "town", "town-left", "random-3", "random-8", "spider", "roundabout", "track"] {
        let net = network(name);
        let static_scene = StaticScene::of_network(&net, 1, 0);
        check(&static_scene.road, name);
        // A ribbon folds over on the inside of tight bends, on a small area only.
        let (mut up, mut down) = (0.0, 0.0);
        faces(&static_scene.road).for_each(|(_, face)| if face.z > 0.0 { up += face.z } else { down -= face.z });
        assert!(down < 0.004 * up, "{name}: {down} of {up} m2 face down");
        // The triangles fill the area of each junction.
        for area in junction_areas::areas(&net) {
            let flat: Vec<Vec2> = area.outline.iter().map(|corner| corner.truncate()).collect();
            let of = |[a, b, c]: [usize; 3]| (flat[b] - flat[a]).perp_dot(flat[c] - flat[a]) / 2.0;
            let filled: f32 = triangulation::triangles(&flat).into_iter().map(of).sum();
            let round = cleaned(&flat);
            let doubled: f32 =
                (0..round.len()).map(|k| flat[round[k]].perp_dot(flat[round[(k + 1) % round.len()]])).sum();
            assert!((filled / (doubled / 2.0) - 1.0).abs() < 0.02, "{name}: {filled} of {} m2", doubled / 2.0);
        }
    }
}

#[test]
fn every_lane_with_a_signal_has_a_head_that_faces_it() {
    for name in ["grid-signals", "town", "town-left", "track", "bicycles"] {
        let net = network(name);
        let static_scene = StaticScene::of_network(&net, 1, 0);
        let mut ruled = 0;
        for id in net.lane_ids().filter(|id| net.is_driven(*id)) {
            let signals =
                net.connections_from(id).iter().any(|way| way.signal.is_some_and(|link| link.index.is_some()));
            let heads: Vec<_> = static_scene.signal_heads.iter().filter(|head| head.lane == id).collect();
            assert_eq!(signals, !heads.is_empty(), "{name}: {}", net.lane(id).id);
            ruled += usize::from(signals);
            let end = net.lane(id).line.end_direction().as_vec2().extend(0.0);
            for head in heads {
                assert!(head.facing.dot(-end) > 0.99, "{name}: {} faces {}", net.lane(id).id, head.facing);
                let middle = head.lamps[1];
                let beside_m = border_m(&net, middle.truncate());
                assert!(
                    beside_m > if net.lane(id).is_for_bicycles() { 0.15 } else { 0.4 }
                        || middle.z > 4.5
                        || name.starts_with("town"),
                    "{name}: {middle} stands in the road"
                );
                // The pole is on the left only with left-hand traffic.
                let stands = net.lane(id).line.pose(net.lane(id).length_m, 0.0).position.as_vec3();
                let left_m = end.truncate().perp_dot((middle - stands).truncate());
                let near = (middle - stands).truncate().length() < 8.0 && middle.z < 4.0;
                assert!(!near || (left_m > 0.0) == net.is_left_hand(), "{name}: {middle} is {left_m} m to the left");
            }
        }
        assert!(ruled > 0, "{name}");
    }
}

#[test]
fn wheels_turn_with_a_vehicles_heading_and_its_body_follows_the_slope() {
    let net = network("hill");
    let static_scene = StaticScene::of_network(&net, 1, 0);
    let at = net.lane(net.lane_named("up_0").expect("a lane")).line.pose(80.0, 0.0);
    let drawn = |turn_rad: f64| {
        let pose = at.flat();
        let before = Pose::new(pose.position - pose.forward() * 0.1, pose.yaw_rad - turn_rad);
        let car = VehicleSnapshot { pose, pose_before: before, height_m: at.position.z, ..VehicleSnapshot::default() };
        let snapshot = Snapshot { cars: vec![car], ..Snapshot::default() };
        let view = scene::view(&snapshot, 1.0, ViewKind::Chase, &ViewOptions::default(), &static_scene);
        view.cars[1]
    };
    // 2 mrad in 0.1 m is a bend with a radius of 50 m. The wheelbase is 2.8 m.
    assert!((drawn(0.002).steer_rad - (2.8f32 / 50.0).atan()).abs() < 1e-3, "{}", drawn(0.002).steer_rad);
    assert!((drawn(-0.002).steer_rad + (2.8f32 / 50.0).atan()).abs() < 1e-3);
    assert_eq!(drawn(0.0).steer_rad, 0.0);
    // The network's file has this lane from (50.8252, 100.2586, 5) to (111.4802, 115.4223, 14): 9 m up in 62.52 m.
    let forward = drawn(0.0).rotation * Vec3::X;
    assert!((forward.z / forward.truncate().length() - 9.0 / 62.52).abs() < 2e-3, "{forward}");
    // The mean of four wheels, in single precision.
    assert!((drawn(0.0).position.z - at.position.z as f32).abs() < 1e-4, "{}", drawn(0.0).position.z);
}

#[test]
fn signals_show_arrows_for_protected_turns_and_persons_at_crossings() {
    use super::signal_faces::SignalFace;
    // Counted in the file: each of the four lanes from B1 that only turn right has a `G` in all its green phases, and two heads.
    let grid = StaticScene::of_network(&network("grid-signals"), 1, 0);
    let arrows: Vec<_> = grid.signal_heads.iter().filter(|head| head.face != SignalFace::Full).collect();
    assert_eq!(arrows.len(), 8);
    for head in arrows {
        assert_eq!(head.face, SignalFace::Arrow(-std::f32::consts::FRAC_PI_2));
        let ways = grid.network.connections_from(head.lane);
        assert!(ways.iter().all(|way| way.direction == TurnDirection::Right), "{ways:?}");
    }
    // The town of the tests has two crossings with a signal.
    let town = StaticScene::of_network(&network("town"), 1, 0);
    let walkers: Vec<_> = town.signal_heads.iter().filter(|head| head.face == SignalFace::Walkers).collect();
    assert_eq!(walkers.len(), 4);
    for pair in walkers.chunks(2) {
        let [one, other] = [pair[0], pair[1]];
        assert_eq!((one.lane, one.link), (other.lane, other.link));
        // Each faces the other across the road.
        let across = (other.lamps[0] - one.lamps[0]).with_z(0.0).normalize();
        assert!(one.facing.dot(across) > 0.7 && other.facing.dot(across) < -0.7, "{pair:?}");
    }
}

#[test]
fn lanes_for_bicycles_have_small_heads_of_their_own() {
    use super::signal_faces::SignalFace;
    let scene = StaticScene::of_network(&network("bicycles"), 1, 0);
    let net = &scene.network;
    let of_lane =
        |id: &str| -> Vec<_> { scene.signal_heads.iter().filter(|head| net.lane(head.lane).id == id).collect() };
    // The lanes for bicycles alone, as the file's description has them, and the heights of the middle lamps: beside the outermost lane, and over
    // one between lanes for cars.
    for (id, height_m) in [("EC_0", 2.35), ("WC_0", 2.35), ("SC_1", 5.6)] {
        let [head] = of_lane(id)[..] else { panic!("{id}: {:?}", of_lane(id)) };
        assert_eq!(head.face, SignalFace::Bicycles);
        let apart_m = head.lamps[0].distance(head.lamps[1]);
        assert!((head.lamps[1].z - height_m).abs() < 0.01 && apart_m < 0.3, "{id}: {head:?}");
    }
    let cycling: Vec<_> = scene.signal_heads.iter().filter(|head| head.face == SignalFace::Bicycles).collect();
    assert_eq!(cycling.len(), 3);
    // The heads of cars beside them stand as without them: on the pole, and across.
    for id in ["EC_1", "WC_1", "NC_0", "SC_0"] {
        assert!(of_lane(id).iter().all(|head| head.lamps[1].z < 3.0) && !of_lane(id).is_empty(), "{id}");
    }
    // Two wheels beside each other, on the lens.
    let lit: Vec<_> = cycling[0].lit(&SignalStates::uniform(net, b'y'), 0.0).collect();
    let right = Vec3::Z.cross(cycling[0].facing);
    let off = |lamp: &scene::LitLamp| lamp.position - cycling[0].lamps[1];
    assert!(lit.iter().all(|lamp| off(lamp).length() + lamp.radius_m < 0.1), "within the lens");
    let wheels = [-1.0, 1.0].map(|side| lit.iter().filter(|lamp| off(lamp).dot(right) * side > 0.04).count());
    assert!(wheels[0] >= 4 && wheels[1] >= 4, "{wheels:?}");
}

#[test]
fn a_lit_lamp_shows_its_picture_to_those_whom_it_faces() {
    use super::signal_faces::SignalFace;
    let net = network("grid-signals");
    let head = StaticScene::of_network(&net, 1, 0).signal_heads[0];
    let lit = |face: SignalFace, letter: u8| -> Vec<scene::LitLamp> {
        SignalHead { face, ..head }.lit(&SignalStates::uniform(&net, letter), 0.0).collect()
    };
    assert_eq!(lit(SignalFace::Full, b'G').iter().map(|lamp| lamp.position).collect::<Vec<_>>(), [head.lamps[2]]);
    // An arrow to the left: its head's discs are to the left of its middle as seen against the direction that it shines in.
    let arrow = lit(SignalFace::Arrow(std::f32::consts::FRAC_PI_2), b'G');
    let left = Vec3::Z.cross(-head.facing);
    let off = |lamp: &scene::LitLamp| lamp.position - head.lamps[2];
    let wings: Vec<_> = arrow.iter().filter(|lamp| off(lamp).z.abs() > 0.02).collect();
    assert!(wings.len() == 4 && wings.iter().all(|lamp| off(lamp).dot(left) > -0.01), "{wings:?}");
    assert!(arrow.iter().all(|lamp| off(lamp).length() + lamp.radius_m < 0.15), "within the lens");
    // Those who walk see red until it is green.
    let colours = [b'r', b'y', b'u', b'G'].map(|letter| lit(SignalFace::Walkers, letter)[0].light);
    assert!(colours[..3].iter().all(|light| light[0] > light[1]) && colours[3][1] > colours[3][0], "{colours:?}");
    assert!(lit(SignalFace::Walkers, b'o').is_empty());
    let from = |face: SignalFace, away_m: f32| {
        SignalHead { face, ..head }.seen_from(head.lamps[0] + head.facing * away_m).map(|seen| seen.face)
    };
    let [arrow, walkers] = [SignalFace::Arrow(1.0), SignalFace::Walkers];
    assert_eq!([from(arrow, 140.0), from(walkers, 140.0)], [Some(arrow), Some(walkers)]);
    assert_eq!([from(arrow, 160.0), from(walkers, 160.0)], [Some(SignalFace::Full), None]);
}
