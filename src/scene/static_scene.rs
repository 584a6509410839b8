//! The static part of the scene, built once for a map. In: a map and a seed. Out: a [`StaticScene`].

use super::{
    Cockpit, StaticScene,
    car::{self, wheel},
    land::{self, road, road_distance::RoadDistance, verge},
    trees::{self, forest, leaf_cards::ModelDetail},
};
use crate::map::RoadMap;

/// Distance of the curvatures kept in [`StaticScene::bends`], metres at most.
const BEND_STEP_M: f64 = 2.0;

impl StaticScene {
    /// Builds the place around a map's route: same map and seed, same bits.
    pub fn build(map: &RoadMap, seed: u64) -> Self {
        Self::with_trees(map, seed, forest::MOST_TREES)
    }

    /// The same with at most `most_trees` trees, those on the horizon included (weak machines, long maps).
    pub fn with_trees(map: &RoadMap, seed: u64, most_trees: usize) -> Self {
        let near = RoadDistance::new(&map.route);
        let relief = land::Relief::new(&near, seed);
        let length_m = map.route.length_m();
        let n = (length_m / BEND_STEP_M).ceil().max(1.0);
        let bends = (0..n as usize).map(|k| map.route.curvature_at(k as f64 * length_m / n, 4.0) as f32).collect();
        let grown = |detail| move || trees::models(seed, detail);
        let woods = || {
            let trees = trees::models(seed, ModelDetail::Near);
            let places = forest::plant(&near, &relief, &trees, seed, most_trees);
            let distant = forest::horizon(&near, &relief, seed, most_trees - places.len());
            (trees, forest::grounds(&places, &relief), places, distant)
        };
        // Every part stands for itself and has its own random numbers: made side by side, they are the same.
        let vehicles = || rayon::join(car::models, || rayon::join(Cockpit::new, wheel::wheels));
        let ground = || rayon::join(|| road::road(&map.route, &relief, seed), || land::land(&relief));
        let growth = || {
            rayon::join(
                || rayon::join(woods, || verge::sow(&near, &relief, seed)),
                || rayon::join(grown(ModelDetail::Mid), grown(ModelDetail::Shade)),
            )
        };
        let (((woods, tuft_places), (trees_mid, trees_shade)), ((road, land), (cars, (cockpit, wheels)))) =
            rayon::join(growth, || rayon::join(ground, vehicles));
        let (trees, tree_grounds, tree_places, far_tree_places) = woods;
        Self {
            road,
            land,
            trees,
            trees_mid,
            trees_shade,
            tree_grounds,
            far_tree_places,
            tree_places,
            tuft: verge::tuft(seed),
            tuft_places,
            posts: verge::posts(&map.route),
            cars,
            cockpit,
            wheels,
            hubs: car::hubs(),
            centre: near.centre(),
            radius_m: near.radius_m(),
            bends,
            length_m: length_m as f32,
        }
    }

    /// Curvature of the route at `s_m`, 1/m, positive to the left.
    pub fn bend_per_m(&self, s_m: f64) -> f32 {
        let n = self.bends.len();
        let place = (s_m / f64::from(self.length_m)).rem_euclid(1.0) * n as f64;
        let (index, fraction) = (place as usize % n, place.fract() as f32);
        self.bends[index] + (self.bends[(index + 1) % n] - self.bends[index]) * fraction
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::map::{Route, RouteLane};
    use glam::{DVec2, dvec2};
    use std::{f64::consts::TAU, sync::Arc};

    fn map(name: &str, shape: Vec<DVec2>, width_m: f64) -> RoadMap {
        let lane = RouteLane {
            id: "e0_0".into(),
            edge: "e0".into(),
            start_s_m: 0.0,
            length_m: shape.windows(2).map(|p| p[0].distance(p[1])).sum(),
            speed_limit_mps: 30.0,
            width_m,
            shape,
        };
        RoadMap {
            name: name.into(),
            title: name.into(),
            net_file: "none".into(),
            route: Route::new(vec![lane]),
            network: Arc::default(),
        }
    }

    /// A ring of this circumference, driven counter-clockwise, 3.2 m wide.
    pub fn ring(circumference_m: f64) -> RoadMap {
        let n = (circumference_m * 2.0) as usize;
        let r = circumference_m / TAU;
        map("ring", (0..=n).map(|i| DVec2::from_angle(TAU * (i % n) as f64 / n as f64) * r).collect(), 3.2)
    }

    /// Two straights of 400 m and two half circles of 60 m radius, away from the origin.
    pub fn circuit() -> RoadMap {
        let bend = |centre: DVec2, from: f64| {
            (0..=180).map(move |i| centre + DVec2::from_angle(from + TAU / 2.0 * f64::from(i) / 180.0) * 60.0)
        };
        let mut shape: Vec<DVec2> = bend(dvec2(700.0, 80.0), -TAU / 4.0).collect();
        shape.extend(bend(dvec2(300.0, 80.0), TAU / 4.0));
        shape.push(shape[0]);
        map("circuit", shape, 3.6)
    }

    #[test]
    fn one_seed_makes_one_stage_and_another_seed_another() {
        let map = ring(250.0);
        let stage = StaticScene::build(&map, 7);
        assert!(stage == StaticScene::build(&map, 7), "same seed, same stage");
        assert!(stage.tree_places != StaticScene::build(&map, 8).tree_places);
        assert_eq!(StaticScene::with_trees(&map, 7, 100).tree_places.len(), 100);
    }

    #[test]
    fn every_mesh_is_sound() {
        for map in [ring(250.0), circuit()] {
            let stage = StaticScene::build(&map, 1);
            let cars = stage.cars.iter().flat_map(|car| car.levels.iter().chain(&car.glass));
            let all =
                [&stage.road, &stage.land, &stage.cockpit.bonnet, &stage.cockpit.shelf, &stage.tuft, &stage.posts];
            for mesh in all
                .into_iter()
                .chain(&stage.wheels)
                .chain(cars)
                .chain(&stage.trees)
                .chain(&stage.trees_mid)
                .chain(&stage.trees_shade)
            {
                crate::scene::mesh::tests::check(mesh, "stage");
            }
            assert!(stage.land.triangles() < 60_000, "{}", stage.land.triangles());
        }
    }

    #[test]
    fn the_circle_of_the_birds_eye_view_holds_the_road() {
        for map in [ring(250.0), circuit()] {
            let stage = StaticScene::build(&map, 1);
            for k in 0..200 {
                let point = map.route.point_at(map.route.length_m() * f64::from(k) / 200.0).as_vec2();
                assert!(point.distance(stage.centre) <= stage.radius_m - 1.5);
            }
        }
    }

    #[test]
    fn bends_are_the_routes_own() {
        let stage = StaticScene::build(&ring(250.0), 1);
        for s_m in [0.0, 17.3, 249.9, 260.0] {
            assert!((stage.bend_per_m(s_m) - (TAU / 250.0) as f32).abs() < 1e-5);
        }
    }
}
