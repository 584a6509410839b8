//! Placement of trees: in clumps with glades between, close to the road but never on or over it. In: the road, the trees' crowns, a seed.
//! Out: places. Distances in metres.

use super::{BUSH, SPRUCE, Tree, Woods, forms};
use crate::{
    map::surroundings::{LandUse, StatedTree, Surroundings},
    rng::{self, Stream},
    roadside::{
        buildings::Buildings,
        land_use_map::LandUseMap,
        noise,
        road_surfaces::{HALF_LANE_M, RoadSurfaces},
    },
    space::smoothstep,
};
use glam::Vec2;
use rayon::prelude::*;
use std::{collections::BTreeMap, f32::consts::SQRT_2};

/// Least distance of a trunk from the lane's edge, metres.
pub const TRUNK_FREE_M: f32 = 4.0;
/// Least distance of a crown from the lane's edge, metres: beyond shoulder and verge.
const CROWN_FREE_M: f32 = 1.2;
/// Least distance of a crown from a wall, metres; crowns are narrower where they are low.
const WALL_FREE_M: f32 = 0.6;
/// Trees stand up to this far from the centre line, metres.
pub const FOREST_M: f32 = 120.0;
/// Maximum number of trees in a static scene.
pub const MOST_TREES: usize = 5000;

/// Least distance of a crown from a road where a map states the tree, and the least part of its full size that a tree is grown to.
const STATED_FREE_M: f32 = 0.2;
const SMALLEST_SCALE: f32 = 0.35;

/// Side of the lattice squares, each with one seedling, metres.
const SEEDLING_M: f32 = 4.2;
/// Side of the blocks that are looked at once whether roads are near, in squares.
const BLOCK: i32 = 16;

struct Seedling {
    tree: Tree,
    crown_m: f32,
    /// Rank in thinning; the lowest are kept.
    rank: f32,
}

/// Plants at most `most` trees: those that the map states, and others as its kinds of land have them; where it states nothing, by the
/// program's own rules.
pub fn plant(
    surroundings: &Surroundings,
    roads: &RoadSurfaces,
    buildings: &Buildings,
    land_use: &LandUseMap,
    seed: u64,
    most: usize,
) -> Woods {
    let forms = forms(seed);
    let crowns: Vec<f32> = forms.iter().map(|form| form.crown_m).collect();
    let mut random = rng::stream(seed, "trees");
    let reach = ((roads.radius_m() + FOREST_M) / SEEDLING_M).ceil() as i32;
    let mut seedlings = stated(surroundings, roads, buildings, &crowns, seed);
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
            let seedling = seedling(roads, land_use, &crowns, seed, point, &draw);
            let is_free = |of: &Seedling| buildings.distance_m(point) > WALL_FREE_M + 0.8 * of.crown_m;
            seedlings.extend(seedling.filter(is_free));
        }
    }
    seedlings.sort_by(|a, b| a.rank.total_cmp(&b.rank));
    let mut trees = thin(seedlings, most);
    trees.iter_mut().for_each(|tree| tree.tint = tint(&mut random));
    Woods { trees, forms }
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
    crowns: &[f32],
    seed: u64,
) -> Vec<Seedling> {
    let mut random = rng::stream(seed, "stated trees");
    let grown = |tree: &StatedTree| {
        let [pick, size, turn] = std::array::from_fn(|_| random.uniform(0.0, 1.0) as f32);
        let at = tree.position.as_vec2();
        let road_m = roads.border_m(at);
        let free_m = (road_m - STATED_FREE_M).min(1.6 * buildings.distance_m(at));
        let kind = if tree.is_conifer { SPRUCE } else { (pick * 3.0) as usize };
        let scale = (0.75 + 0.4 * size).min(free_m / crowns[kind]);
        if scale < SMALLEST_SCALE || road_m > FOREST_M {
            return None;
        }
        let tree = Tree { at, yaw_rad: turn * std::f32::consts::TAU, scale, tint: [1.0; 3], kind };
        Some(Seedling { tree, crown_m: crowns[kind] * scale, rank: f32::NEG_INFINITY })
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

fn seedling(
    roads: &RoadSurfaces,
    land_use: &LandUseMap,
    crowns: &[f32],
    seed: u64,
    point: Vec2,
    draw: &[f32; 6],
) -> Option<Seedling> {
    // Woods and glades about 40 m across; denser in a belt 10-40 m from the road, thin far out where few are visible.
    let wood = noise::fractal(seed ^ 0x7ee5, point / 42.0);
    let growth = land_use.is_stated().then(|| Growth::on(land_use.at(point)));
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
        (Some(growth), d) if d < growth.bushes => BUSH,
        (Some(growth), d) if d < growth.bushes + growth.spruces => SPRUCE,
        (Some(_), d) => (d * 1000.0) as usize % 3,
        (None, d) => own_kind(d, distance, conifers),
    };
    let scale = 0.72 + 0.5 * draw[3];
    let crown_m = crowns[kind] * scale;
    if distance - crown_m < HALF_LANE_M + CROWN_FREE_M || draw[4] > density {
        return None;
    }
    let tree = Tree { at: point, yaw_rad: draw[5] * std::f32::consts::TAU, scale, tint: [1.0; 3], kind };
    Some(Seedling { tree, crown_m, rank: draw[4] / density })
}

/// Returns a tree's kind by the program's own rules, from a random number of 0 to 1.
fn own_kind(random: f32, distance_m: f32, conifers: f32) -> usize {
    match random {
        d if d < 0.16 + 0.25 * smoothstep(14.0, 6.0, distance_m) => BUSH,
        d if conifers > 0.15 && d < 0.85 => SPRUCE,
        d if d < 0.45 => 0,
        d if d < 0.75 => 1,
        d if d < 0.95 => 2,
        _ => SPRUCE,
    }
}

/// Keeps the seedlings of lowest rank, but none so close to a kept one that their crowns would merge.
fn thin(seedlings: Vec<Seedling>, most: usize) -> Vec<Tree> {
    const SQUARE_M: f32 = 12.0;
    let square = |p: Vec2| (p / SQUARE_M).floor().as_ivec2();
    let mut standing: BTreeMap<[i32; 2], Vec<(Vec2, f32)>> = BTreeMap::new();
    let mut trees = Vec::new();
    for Seedling { tree, crown_m, .. } in seedlings {
        if trees.len() == most {
            break;
        }
        let (here, at) = (square(tree.at), tree.at);
        let mut around = (-1..=1).flat_map(|x| (-1..=1).map(move |y| [here.x + x, here.y + y]));
        let crowded = around.any(|key| {
            standing.get(&key).is_some_and(|all| all.iter().any(|(p, r)| p.distance(at) < 0.62 * (r + crown_m)))
        });
        if !crowded {
            standing.entry(here.to_array()).or_default().push((at, crown_m));
            trees.push(tree);
        }
    }
    trees
}

/// Returns the shade of green of a tree.
pub fn tint(random: &mut Stream) -> [f32; 3] {
    let (bright, warm) = (random.uniform(0.78, 1.15) as f32, random.uniform(-0.12, 0.12) as f32);
    [bright * (1.0 + warm), bright, bright * (1.0 - 0.6 * warm)]
}
