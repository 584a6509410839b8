//! Placement of trees: in clumps with glades between, close to the road but never on or over it. In: the road, the models'
//! crowns, a seed. Out: places. Distances in metres.

use crate::{
    map::surroundings::{LandUse, StatedTree, Surroundings},
    rng::{self, Stream},
    roadside::{
        buildings::Buildings,
        road_surfaces::{HALF_LANE_M, RoadSurfaces},
    },
    scene::{
        Mesh, TreePlace,
        land::{Relief, noise},
        trees,
    },
    space::smoothstep,
};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::{collections::BTreeMap, f32::consts::SQRT_2};

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

/// Least distance of a crown from a road where a map states the tree, and the least part of its full size that a tree is grown to.
const STATED_FREE_M: f32 = 0.2;
const SMALLEST_SCALE: f32 = 0.35;

/// Maximum number of trees on the horizon.
const MOST_DISTANT: usize = 3200;

/// Side of the lattice squares, each with one seedling, metres.
const SEEDLING_M: f32 = 4.2;
/// Side of the blocks that are looked at once whether roads are near, in squares.
const BLOCK: i32 = 16;

struct Seedling {
    place: TreePlace,
    crown_m: f32,
    /// Rank in thinning; the lowest are kept.
    rank: f32,
}

/// Plants at most `most` trees: those that the map states, and others as its kinds of land have them; where it states nothing, by the
/// program's own rules.
pub(in crate::scene) fn plant(
    surroundings: &Surroundings,
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
    let mut seedlings = stated(surroundings, roads, buildings, relief, &crowns, seed);
    let near = near_blocks(roads, reach);
    for row in -reach..=reach {
        let blocks = &near[((row + reach) / BLOCK) as usize];
        for column in -reach..=reach {
            // Each square draws the same number of random values, whether or not it gets a tree.
            let draw: [f32; 6] = std::array::from_fn(|_| random.uniform(0.0, 1.0) as f32);
            if !blocks[((column + reach) / BLOCK) as usize] {
                continue;
            }
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

/// Returns for each block of squares, by row and column, whether a road may be within the reach of its trees. On a long road most are far away.
fn near_blocks(roads: &RoadSurfaces, reach: i32) -> Vec<Vec<bool>> {
    let middle_m = |block: i32| (block * BLOCK + BLOCK / 2 - reach) as f32 * SEEDLING_M;
    // Half of a block's diagonal, with the squares' jitter at its edge.
    let half_m = (BLOCK / 2 + 1) as f32 * SEEDLING_M * SQRT_2;
    let is_near = |row: i32, column: i32| {
        roads.may_be_within(roads.centre() + Vec2::new(middle_m(column), middle_m(row)), FOREST_M + half_m)
    };
    let blocks = 2 * reach / BLOCK + 1;
    (0..blocks).into_par_iter().map(|row| (0..blocks).map(|column| is_near(row, column)).collect()).collect()
}

/// Returns the trees that the map states, as large as the road and the walls beside them allow.
fn stated(
    surroundings: &Surroundings,
    roads: &RoadSurfaces,
    buildings: &Buildings,
    relief: &Relief,
    crowns: &[f32],
    seed: u64,
) -> Vec<Seedling> {
    let mut random = rng::stream(seed, "stated trees");
    let grown = |tree: &StatedTree| {
        let [pick, size, turn] = std::array::from_fn(|_| random.uniform(0.0, 1.0) as f32);
        let at = tree.position.as_vec2();
        let road_m = roads.border_m(at);
        let free_m = (road_m - STATED_FREE_M).min(1.6 * buildings.distance_m(at));
        let kind = if tree.is_conifer { trees::SPRUCE } else { (pick * 3.0) as usize };
        let scale = (0.75 + 0.4 * size).min(free_m / crowns[kind]);
        if scale < SMALLEST_SCALE || road_m > FOREST_M {
            return None;
        }
        let position = at.extend(relief.height_m(at) - 0.05);
        let place = TreePlace { position, yaw_rad: turn * std::f32::consts::TAU, scale, tint: [1.0; 3], kind };
        Some(Seedling { place, crown_m: crowns[kind] * scale, rank: f32::NEG_INFINITY })
    };
    surroundings.trees.iter().filter_map(grown).collect()
}

/// Share of the squares in which a tree grows, and of bushes and spruces among them.
struct Growth {
    density: f32,
    bushes: f32,
    spruces: f32,
}

impl Growth {
    /// Returns the growth on land that a map states to be of this kind; `None` stands for land of which it states nothing.
    fn on(land_use: Option<LandUse>) -> Self {
        let [density, bushes, spruces] = match land_use {
            Some(LandUse::Wood) => [0.75, 0.12, 0.2],
            Some(LandUse::Scrub) => [0.5, 1.0, 0.0],
            Some(LandUse::Park) => [0.09, 0.3, 0.04],
            Some(LandUse::Residential) => [0.07, 0.55, 0.04],
            Some(LandUse::Grass | LandUse::Commercial) => [0.012, 0.4, 0.0],
            Some(LandUse::Field | LandUse::Paved | LandUse::Water) => [0.0; 3],
            None => [0.045, 0.5, 0.04],
        };
        Self { density, bushes, spruces }
    }
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
    let growth = relief.land_use().is_stated().then(|| Growth::on(relief.land_use().at(point)));
    let density = |far: f32| match &growth {
        Some(growth) => growth.density * (1.0 - 0.6 * far),
        None => smoothstep(-0.30, 0.45, wood) * (1.0 - 0.82 * far) + 0.04,
    };
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
    let kind = match (&growth, draw[2]) {
        (Some(growth), d) if d < growth.bushes => trees::BUSH,
        (Some(growth), d) if d < growth.bushes + growth.spruces => trees::SPRUCE,
        (Some(_), d) => (d * 1000.0) as usize % 3,
        (None, d) => own_kind(d, distance, conifers),
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

/// Returns a tree's kind by the program's own rules, from a random number of 0 to 1.
fn own_kind(random: f32, distance_m: f32, conifers: f32) -> usize {
    match random {
        d if d < 0.16 + 0.25 * smoothstep(14.0, 6.0, distance_m) => trees::BUSH,
        d if conifers > 0.15 && d < 0.85 => trees::SPRUCE,
        d if d < 0.45 => 0,
        d if d < 0.75 => 1,
        d if d < 0.95 => 2,
        _ => trees::SPRUCE,
    }
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
    use crate::{map::SHOULDER_M, scene::StaticScene};

    fn static_scene(map: &RoadMap) -> (StaticScene, RoadSurfaces) {
        (StaticScene::build(map, 1), RoadSurfaces::of(&map.network))
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

    #[test]
    fn trees_stand_where_a_map_states_them_and_as_its_land_has_them() {
        use crate::map::surroundings::LandArea;
        use glam::DVec2;
        // Inside the circuit, between its straights at y = 20 m and y = 140 m.
        let kinds = [LandUse::Wood, LandUse::Field, LandUse::Water, LandUse::Paved, LandUse::Park];
        let left_m = |k: usize| 310.0 + 76.0 * k as f64;
        let areas: Vec<LandArea> = kinds
            .iter()
            .enumerate()
            .map(|(k, kind)| LandArea::rectangle(*kind, [left_m(k), 40.0], [70.0, 80.0]))
            .collect();
        // On the paved land, one in the field, and one on the road.
        let places = [[560.0, 80.0], [420.0, 80.0], [420.0, 20.0]];
        let tree = |at: [f64; 2]| StatedTree { position: DVec2::from(at), is_conifer: at[0] > 500.0 };
        let surroundings = Surroundings { areas, trees: places.map(tree).to_vec(), ..Surroundings::default() };
        let network = (*circuit().network).clone().with_surroundings(surroundings);
        let scene = StaticScene::of_network(&network.into(), 1, MOST_TREES);
        let origin = scene.origin.truncate();
        let of_kind = |k: usize| {
            let inside = |place: &&TreePlace| {
                let [x, y] = (place.position.truncate().as_dvec2() + origin).to_array();
                (left_m(k)..left_m(k) + 70.0).contains(&x) && (40.0..120.0).contains(&y)
            };
            scene.tree_places.iter().filter(inside).count()
        };
        // 70 x 80 m of wood with crowns of about 5 m have some hundred trees.
        assert!((60..400).contains(&of_kind(0)), "{} in the wood", of_kind(0));
        assert_eq!([1, 2, 3].map(of_kind), [1, 0, 1], "those that the map states, and no other");
        assert!((2..of_kind(0) / 3).contains(&of_kind(4)), "{} in the park", of_kind(4));
        let at = |place: [f64; 2]| {
            let near =
                |of: &&TreePlace| (of.position.truncate().as_dvec2() + origin).distance(DVec2::from(place)) < 0.1;
            scene.tree_places.iter().find(near).map(|of| of.kind == trees::SPRUCE)
        };
        assert_eq!(places.map(at), [Some(true), Some(false), None]);
    }
}
