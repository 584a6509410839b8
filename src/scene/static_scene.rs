//! The static part of the scene, built once for a map. In: a map, or a network alone, and a seed. Out: a [`StaticScene`].

use super::{
    CarModel, Cockpit, ORIGIN_STEP_M, StaticScene,
    car::{self, wheel},
    land::{self, road, road_distance::RoadDistance, verge},
    network::{self, signals},
    trees::{self, forest, leaf_cards::ModelDetail},
    vehicles,
};
use crate::map::{RoadMap, Route, network::Network};
use crate::space::{Pose, Pose3};
use glam::DVec3;
use std::sync::Arc;

/// Distance of the curvatures kept in [`StaticScene::bends`], metres at most.
const BEND_STEP_M: f64 = 2.0;

impl StaticScene {
    /// Builds the place around a map's roads: same map and seed, same bits. Where the network is one closed chain of lanes, its route
    /// is drawn in one piece; any other network lane by lane.
    pub fn build(map: &RoadMap, seed: u64) -> Self {
        Self::with_trees(map, seed, forest::MOST_TREES)
    }

    /// The same with at most `most_trees` trees, those on the horizon included (weak machines, long maps).
    pub fn with_trees(map: &RoadMap, seed: u64, most_trees: usize) -> Self {
        if network::is_closed_route_alone(&map.network) {
            let origin = origin_near(map.bounds().0.extend(0.0));
            Self::around(origin, Roads::Route(&map.route.moved_by(-origin.truncate())), seed, most_trees)
        } else {
            Self::of_network(&map.network, seed, most_trees)
        }
    }

    /// The place around all roads of a network, with at most `most_trees` trees.
    pub fn of_network(network: &Arc<Network>, seed: u64, most_trees: usize) -> Self {
        let (low, high) = network.bounds();
        let origin = origin_near((low + high) / 2.0);
        if origin == DVec3::ZERO {
            return Self::around(origin, Roads::Network(network), seed, most_trees);
        }
        Self::around(origin, Roads::Network(&Arc::new(network.moved_by(-origin))), seed, most_trees)
    }

    fn around(origin: DVec3, roads: Roads, seed: u64, most_trees: usize) -> Self {
        let near = match roads {
            Roads::Route(route) => RoadDistance::new(route),
            Roads::Network(network) => RoadDistance::of_surfaces(network::surfaces(network)),
        };
        let relief = land::Relief::new(&near, seed);
        let (length_m, bends) = match roads {
            Roads::Route(route) => (route.length_m(), bends(route)),
            Roads::Network(_) => (0.0, Vec::new()),
        };
        let grown = |detail| move || trees::models(seed, detail);
        let woods = || {
            let trees = trees::models(seed, ModelDetail::Near);
            let places = forest::plant(&near, &relief, &trees, seed, most_trees);
            let distant = forest::horizon(&near, &relief, seed, most_trees - places.len());
            (trees, forest::grounds(&places, &relief), places, distant)
        };
        // Every part stands for itself and has its own random numbers: made side by side, they are the same.
        let vehicles = || rayon::join(models_of_vehicles, || rayon::join(Cockpit::new, wheel::wheels));
        let paved = || match roads {
            Roads::Route(route) => (road::road(route, &relief, seed), verge::posts(route), Vec::new()),
            Roads::Network(network) => {
                let (posts, heads) = near.surfaces().map(|roads| signals::heads(network, roads)).unwrap_or_default();
                (network::road(network, &near, &relief, seed), posts, heads)
            }
        };
        let ground = || rayon::join(paved, || land::land(&relief));
        let growth = || {
            rayon::join(
                || rayon::join(woods, || verge::sow(&near, &relief, seed)),
                || rayon::join(grown(ModelDetail::Mid), grown(ModelDetail::Shade)),
            )
        };
        let (
            ((woods, tuft_places), (trees_mid, trees_shade)),
            (((road, posts, signal_heads), land), (cars, (cockpit, wheels))),
        ) = rayon::join(growth, || rayon::join(ground, vehicles));
        let (trees, tree_grounds, tree_places, far_tree_places) = woods;
        Self {
            origin,
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
            posts,
            signal_heads,
            lit_lamp: signals::lit_lamp(),
            cars,
            cockpit,
            wheels,
            hubs: car::hubs(),
            centre: near.centre(),
            radius_m: near.radius_m(),
            bends,
            length_m: length_m as f32,
            highest_m: near.surfaces().map_or(0.0, |surfaces| surfaces.highest_m()),
            network: match roads {
                Roads::Route(_) => None,
                Roads::Network(network) => Some(Arc::clone(network)),
            },
        }
    }

    /// Height of the road at a place of a network where something is about `height_m` high, and its grade in a direction, counted from
    /// the local origin; 0 on a closed route, which is level.
    pub fn road_at(&self, place: Pose, height_m: f64) -> (f32, f32) {
        let on = |network: &Arc<Network>| {
            let pose = Pose3 { position: place.position.extend(height_m), yaw_rad: place.yaw_rad, grade: 0.0 };
            let road = network.pose(network.locate_pose(&pose, None)?);
            let along = (place.yaw_rad - road.yaw_rad).cos();
            Some((road.position.z as f32, (road.grade * along) as f32))
        };
        self.network.as_ref().and_then(on).unwrap_or((0.0, 0.0))
    }

    /// Curvature of the closed route at `s_m`, 1/m, positive to the left.
    pub fn bend_per_m(&self, s_m: f64) -> f32 {
        let n = self.bends.len();
        let place = (s_m / f64::from(self.length_m)).rem_euclid(1.0) * n as f64;
        let (index, fraction) = (place as usize % n, place.fract() as f32);
        self.bends[index] + (self.bends[(index + 1) % n] - self.bends[index]) * fraction
    }
}

/// The picture's origin for roads whose middle is at `centre`.
fn origin_near(centre: DVec3) -> DVec3 {
    (centre / ORIGIN_STEP_M).round() * ORIGIN_STEP_M
}

/// What the place is built around.
#[derive(Clone, Copy)]
enum Roads<'a> {
    Route(&'a Route),
    Network(&'a Arc<Network>),
}

/// Curvatures at equal distances along a route.
fn bends(route: &Route) -> Vec<f32> {
    let length_m = route.length_m();
    let n = (length_m / BEND_STEP_M).ceil().max(1.0);
    (0..n as usize).map(|k| route.curvature_at(k as f64 * length_m / n, 4.0) as f32).collect()
}

/// Cars, and after them vehicles of other kinds.
fn models_of_vehicles() -> Vec<CarModel> {
    let mut models = car::models();
    models.extend(vehicles::models());
    models
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
            // Windows of vehicles other than cars are part of their bodies.
            let glass =
                |car: &'_ CarModel| car.glass.iter().filter(|glass| !glass.indices.is_empty()).cloned().collect();
            let glass: Vec<Vec<crate::scene::Mesh>> = stage.cars.iter().map(glass).collect();
            assert_eq!(glass.iter().map(Vec::len).sum::<usize>(), 6, "three styles of cars at two levels");
            let cars = stage.cars.iter().flat_map(|car| &car.levels).chain(glass.iter().flatten());
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
