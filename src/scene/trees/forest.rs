//! Placement of trees: in clumps with glades between, close to the road but never on or over it. In: the road, the models'
//! crowns, a seed. Out: places. Distances in metres.

use crate::{
    rng::{self, Stream},
    scene::{
        Mesh, TreePlace,
        buildings::Buildings,
        land::{
            Relief,
            noise::{self, smoothstep},
        },
        network::road_surfaces::{HALF_LANE_M, RoadSurfaces},
        trees,
    },
};
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;

/// Least distance of a trunk from the lane's edge, metres.
pub const TRUNK_FREE_M: f32 = 4.0;
/// Least distance of a crown from the lane's edge, metres: beyond shoulder and verge.
pub const CROWN_FREE_M: f32 = 1.2;
/// Least distance of a crown from a wall, metres; crowns are narrower where they are low.
const WALL_FREE_M: f32 = 0.6;
/// Trees stand up to this far from the centre line, metres.
pub const FOREST_M: f32 = 120.0;
/// Maximum number of trees in a static scene.
pub const MOST_TREES: usize = 5000;

/// Maximum number of trees on the horizon.
const MOST_DISTANT: usize = 3200;

/// Side of the lattice squares, each with one seedling, metres.
const SEEDLING_M: f32 = 4.2;

struct Seedling {
    place: TreePlace,
    crown_m: f32,
    /// Rank in thinning; the lowest are kept.
    rank: f32,
}

/// Plants at most `most` trees.
pub(in crate::scene) fn plant(
    roads: &RoadSurfaces,
    buildings: &Buildings,
    relief: &Relief,
    models: &[Mesh],
    seed: u64,
    most: usize,
) -> Vec<TreePlace> {
    let crowns: Vec<f32> = models.iter().map(crown_radius_m).collect();
    let mut random = rng::stream(seed, "trees");
    let reach = ((roads.radius_m() + FOREST_M) / SEEDLING_M).ceil() as i32;
    let mut seedlings = Vec::new();
    for row in -reach..=reach {
        for column in -reach..=reach {
            // Each square draws the same number of random values, whether or not it gets a tree.
            let draw: [f32; 6] = std::array::from_fn(|_| random.uniform(0.0, 1.0) as f32);
            let jitter = Vec2::new(column as f32 + draw[0], row as f32 + draw[1]) - Vec2::splat(0.5);
            let point = roads.centre() + jitter * SEEDLING_M;
            let seedling = seedling(roads, relief, &crowns, seed, point, &draw);
            let is_free = |of: &Seedling| buildings.distance_m(point) > WALL_FREE_M + 0.8 * of.crown_m;
            seedlings.extend(seedling.filter(is_free));
        }
    }
    seedlings.sort_by(|a, b| a.rank.total_cmp(&b.rank));
    let mut grown = thin(seedlings, most);
    tint(&mut grown, &mut random);
    grown
}

/// Returns the largest distance of a leaf from the trunk, metres.
pub(in crate::scene) fn crown_radius_m(model: &Mesh) -> f32 {
    model.vertices.iter().map(|v| Vec3::from(v.position).truncate().length()).fold(0.0, f32::max)
}

fn seedling(
    roads: &RoadSurfaces,
    relief: &Relief,
    crowns: &[f32],
    seed: u64,
    point: Vec2,
    draw: &[f32; 6],
) -> Option<Seedling> {
    // Woods and glades about 40 m across; denser in a belt 10-40 m from the road, thin far out where few are visible.
    let wood = noise::fractal(seed ^ 0x7ee5, point / 42.0);
    let density = |far: f32| smoothstep(-0.30, 0.45, wood) * (1.0 - 0.82 * far) + 0.04;
    // Most seedlings do not grow at any distance.
    if draw[4] > density(0.0) {
        return None;
    }
    let distance = roads.middle_m(point);
    if !(HALF_LANE_M + TRUNK_FREE_M..=FOREST_M).contains(&distance) {
        return None;
    }
    let density = density(smoothstep(35.0, FOREST_M, distance));
    // Spruces grow in groups; bushes grow at the edges of woods and nearest the road.
    let conifers = noise::value(seed ^ 0x5b0c, point / 60.0);
    let kind = match draw[2] {
        d if d < 0.16 + 0.25 * smoothstep(14.0, 6.0, distance) => trees::BUSH,
        d if conifers > 0.15 && d < 0.85 => trees::SPRUCE,
        d if d < 0.45 => 0,
        d if d < 0.75 => 1,
        d if d < 0.95 => 2,
        _ => trees::SPRUCE,
    };
    let scale = 0.72 + 0.5 * draw[3];
    let crown_m = crowns[kind] * scale;
    if distance - crown_m < HALF_LANE_M + CROWN_FREE_M || draw[4] > density {
        return None;
    }
    // Slightly below the ground, so that no foot is in the air on a slope.
    let position = point.extend(relief.height_m(point) - 0.05);
    let place = TreePlace { position, yaw_rad: draw[5] * std::f32::consts::TAU, scale, tint: [1.0; 3], kind };
    Some(Seedling { place, crown_m, rank: draw[4] / density })
}

/// Keeps the seedlings of lowest rank, but none so close to a kept one that their crowns would merge.
fn thin(seedlings: Vec<Seedling>, most: usize) -> Vec<TreePlace> {
    const SQUARE_M: f32 = 12.0;
    let square = |p: Vec3| (p.truncate() / SQUARE_M).floor().as_ivec2();
    let mut standing: BTreeMap<[i32; 2], Vec<(Vec2, f32)>> = BTreeMap::new();
    let mut places = Vec::new();
    for Seedling { place, crown_m, .. } in seedlings {
        if places.len() == most {
            break;
        }
        let (here, at) = (square(place.position), place.position.truncate());
        let mut around = (-1..=1).flat_map(|x| (-1..=1).map(move |y| [here.x + x, here.y + y]));
        let crowded = around.any(|key| {
            standing.get(&key).is_some_and(|all| all.iter().any(|(p, r)| p.distance(at) < 0.62 * (r + crown_m)))
        });
        if !crowded {
            standing.entry(here.to_array()).or_default().push((at, crown_m));
            places.push(place);
        }
    }
    places
}

/// Returns the unit normals of the ground around trees, averaged over the width of a crown.
pub(in crate::scene) fn grounds(places: &[TreePlace], relief: &Relief) -> Vec<Vec3> {
    const SPAN_M: f32 = 1.5;
    let normal = |place: &TreePlace| {
        let at = place.position.truncate();
        let rise = |d: Vec2| (relief.height_m(at + d) - relief.height_m(at - d)) / (2.0 * SPAN_M);
        Vec3::new(-rise(Vec2::X * SPAN_M), -rise(Vec2::Y * SPAN_M), 1.0).normalize()
    };
    places.iter().map(normal).collect()
}

/// Places woods on the surrounding hills, in drifts with open land between them; none if the static scene has no trees at all.
pub(in crate::scene) fn horizon(roads: &RoadSurfaces, relief: &Relief, seed: u64, most: usize) -> Vec<TreePlace> {
    let mut random = rng::stream(seed, "horizon");
    let mut places = Vec::new();
    for _ in 0..MOST_DISTANT * 10 {
        let [far, turn, luck, size, yaw, pick] = std::array::from_fn(|_| random.uniform(0.0, 1.0) as f32);
        let beyond = 118.0 + 720.0 * far.powf(1.15);
        let point = roads.centre() + Vec2::from_angle(turn * std::f32::consts::TAU) * (roads.radius_m() + beyond);
        let wood = noise::fractal(seed ^ 7, point / 130.0) + 0.25 * smoothstep(300.0, 600.0, beyond);
        if luck > smoothstep(0.0, 0.22, wood) || places.len() == MOST_DISTANT.min(most) {
            continue;
        }
        let conifers = noise::value(seed ^ 0x5b0c, point / 90.0);
        let kind = match pick {
            p if p < 0.30 + 0.6 * smoothstep(-0.1, 0.3, conifers) => trees::SPRUCE,
            p if p < 0.72 => 0,
            p if p < 0.92 => 1,
            _ => 2,
        };
        // Distant trees are larger, because each stands for several.
        let scale = (0.85 + 0.5 * size) * (1.0 + beyond / 1300.0);
        let position = point.extend(relief.height_m(point) - 0.4);
        places.push(TreePlace { position, yaw_rad: yaw * std::f32::consts::TAU, scale, tint: [1.0; 3], kind });
    }
    tint(&mut places, &mut random);
    places
}

/// Gives each tree its own shade of green.
fn tint(places: &mut [TreePlace], random: &mut Stream) {
    for place in places {
        let (bright, warm) = (random.uniform(0.78, 1.15) as f32, random.uniform(-0.12, 0.12) as f32);
        place.tint = [bright * (1.0 + warm), bright, bright * (1.0 - 0.6 * warm)];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::RoadMap;
    use crate::scene::static_scene::tests::{circuit, ring};
    use crate::{
        map::SHOULDER_M,
        scene::{StaticScene, network},
    };

    fn static_scene(map: &RoadMap) -> (StaticScene, RoadSurfaces) {
        (StaticScene::build(map, 1), network::surfaces(&map.network))
    }

    #[test]
    fn no_tree_stands_on_or_over_the_road() {
        let shipped = crate::map::list();
        assert!(shipped.len() >= 3, "the maps of maps/");
        let shipped = shipped.iter().map(|info| RoadMap::load(&info.name).expect("a shipped map loads"));
        // Trees of networks follow another rule (scene::network).
        let shipped = shipped.filter(|map| map.route.is_closed());
        for map in shipped.chain([ring(250.0), circuit()]) {
            for seed in [1, 2] {
                let static_scene = StaticScene::build(&map, seed);
                for tree in &static_scene.tree_places {
                    let at = tree.position.truncate();
                    let distance = map.route.project(at.as_dvec2(), None).offset_m.abs() as f32;
                    let half = map.route.width_m(0.0) as f32 / 2.0;
                    let crown = crown_radius_m(&static_scene.trees[tree.kind]) * tree.scale;
                    assert!(distance >= half + TRUNK_FREE_M - 0.02, "trunk {distance} m from the centre line");
                    assert!(distance - crown >= half + SHOULDER_M as f32, "crown {} m from it", distance - crown);
                    assert!(distance <= FOREST_M + 0.1);
                }
            }
        }
    }

    #[test]
    fn a_ring_has_hundreds_of_trees_and_a_long_road_thousands_at_most() {
        let (small, roads) = static_scene(&ring(250.0));
        assert!((600..=1000).contains(&small.tree_places.len()), "{}", small.tree_places.len());
        let inside = small.tree_places.iter().filter(|t| t.position.truncate().length() < 39.0).count();
        assert!((15..150).contains(&inside), "{inside} inside the ring");
        assert!(small.tree_places.iter().any(|t| roads.middle_m(t.position.truncate()) < 9.0), "some near the road");
        for kind in 0..super::super::KINDS {
            assert!(small.tree_places.iter().filter(|t| t.kind == kind).count() > 20, "kind {kind}");
        }
        let (long, _) = static_scene(&ring(5000.0));
        assert!((2000..=MOST_TREES).contains(&long.tree_places.len()), "{}", long.tree_places.len());
    }

    #[test]
    fn trees_stand_in_clumps_and_glades() {
        // Counts in squares of 25 m vary more than in an even distribution, whose variance equals the mean.
        let (static_scene, _) = static_scene(&ring(641.0));
        let mut counts: BTreeMap<[i32; 2], usize> = BTreeMap::new();
        for x in -8..8 {
            for y in -8..8 {
                counts.insert([x, y], 0);
            }
        }
        for tree in &static_scene.tree_places {
            if let Some(n) = counts.get_mut(&(tree.position.truncate() / 25.0).floor().as_ivec2().to_array()) {
                *n += 1;
            }
        }
        let mean = counts.values().sum::<usize>() as f32 / counts.len() as f32;
        let variance = counts.values().map(|&n| (n as f32 - mean).powi(2)).sum::<f32>() / counts.len() as f32;
        assert!(variance > 1.5 * mean, "{variance} {mean}");
    }
}
