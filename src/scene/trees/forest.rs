//! Trees in the picture: those of the roadside on their ground, and others on the horizon. In: their places, the ground, a seed. Out: places
//! with heights, metres.

use crate::{
    rng,
    roadside::{
        noise,
        relief::Relief,
        road_surfaces::RoadSurfaces,
        trees::{SPRUCE, Tree, forest::tint},
    },
    scene::TreePlace,
    space::smoothstep,
};
use glam::{Vec2, Vec3};

/// Maximum number of trees on the horizon.
const MOST_DISTANT: usize = 3200;

/// Returns the places of trees on the ground.
pub(in crate::scene) fn places(trees: &[Tree], relief: &Relief) -> Vec<TreePlace> {
    let place = |&Tree { at, yaw_rad, scale, tint, kind }: &Tree| {
        // Slightly below the ground, so that no foot is in the air on a slope.
        TreePlace { position: at.extend(relief.height_m(at) - 0.05), yaw_rad, scale, tint, kind }
    };
    trees.iter().map(place).collect()
}

/// Returns the unit normals of the ground around trees, averaged over the width of a crown.
pub(in crate::scene) fn grounds(places: &[TreePlace], relief: &Relief) -> Vec<Vec3> {
    const SPAN_M: f32 = 1.5;
    places.iter().map(|place| relief.normal(place.position.truncate(), SPAN_M)).collect()
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
            p if p < 0.30 + 0.6 * smoothstep(-0.1, 0.3, conifers) => SPRUCE,
            p if p < 0.72 => 0,
            p if p < 0.92 => 1,
            _ => 2,
        };
        // Distant trees are larger, because each stands for several.
        let scale = (0.85 + 0.5 * size) * (1.0 + beyond / 1300.0);
        let position = point.extend(relief.height_m(point) - 0.4);
        places.push(TreePlace { position, yaw_rad: yaw * std::f32::consts::TAU, scale, tint: [1.0; 3], kind });
    }
    places.iter_mut().for_each(|place| place.tint = tint(&mut random));
    places
}

#[cfg(test)]
pub(in crate::scene) mod tests {
    use super::*;
    use crate::{
        map::{
            RoadMap, SHOULDER_M,
            surroundings::{LandUse, StatedTree, Surroundings},
        },
        roadside::trees::{
            KINDS,
            forest::{FOREST_M, MOST_TREES, TRUNK_FREE_M},
            forms,
        },
        scene::{
            Mesh, StaticScene,
            static_scene::tests::{circuit, ring},
            trees::{leaf_cards::ModelDetail, models},
        },
    };
    use std::collections::BTreeMap;

    /// Returns the largest distance of a leaf from the trunk, metres.
    pub fn crown_radius_m(model: &Mesh) -> f32 {
        model.vertices.iter().map(|v| Vec3::from(v.position).truncate().length()).fold(0.0, f32::max)
    }

    #[test]
    fn crowns_that_place_trees_are_those_of_the_drawn_trees() {
        for seed in 0..20 {
            let drawn: Vec<f32> = models(seed, ModelDetail::Near).iter().map(crown_radius_m).collect();
            let placed: Vec<f32> = forms(seed).iter().map(|form| form.crown_m).collect();
            assert_eq!(placed, drawn, "seed {seed}");
        }
    }

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
        for kind in 0..KINDS {
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
            scene.tree_places.iter().find(near).map(|of| of.kind == SPRUCE)
        };
        assert_eq!(places.map(at), [Some(true), Some(false), None]);
    }
}
