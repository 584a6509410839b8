//! Static part of the scene, built once per map. In: a map, or a network alone, and a seed. Out: a [`StaticScene`].

use super::{
    CarModel, Cockpit, Mesh, StaticScene, buildings,
    car::{self, wheel},
    land::{self, tufts},
    network::{self, barriers, guard_rails, noise_walls, posts, sign_kind::SignedRoads, signals, street_lamps},
    trees::{self, forest, leaf_cards::ModelDetail},
    vehicles,
};
use crate::map::{RoadMap, network::Network};
use crate::roadside::{LazyRoadside, Roadside, trees::forest::MOST_TREES};
use crate::scenario::{GuidanceView, PlannedDrive, Scenario};
use crate::space::{Pose, Pose3};
use glam::Vec3;
use std::{
    sync::{Arc, OnceLock},
    thread::JoinHandle,
};

impl StaticScene {
    /// Builds the scene around a map's roads; the same map and seed give the same bits.
    pub fn build(map: &RoadMap, seed: u64) -> Self {
        Self::with_trees(map, seed, MOST_TREES)
    }

    /// Builds the scene with at most `most_trees` trees, including those on the horizon (for weak machines, long maps).
    pub fn with_trees(map: &RoadMap, seed: u64, most_trees: usize) -> Self {
        Self::beside(LazyRoadside::new(map, seed, most_trees).get(), place(map), most_trees)
    }

    /// Builds the scene of a drive: with the trees of its scenario, and with a line along its path if the scenario asks for one.
    pub fn of_drive(map: &RoadMap, scenario: &Scenario, roadside: &LazyRoadside) -> Self {
        let most_trees = scenario.display.trees as usize;
        let mut scene = Self::beside(roadside.get(), place(map), most_trees);
        // A car that leaves the road then need not wait for them.
        roadside.fixed_objects();
        if scenario.display.guidance == GuidanceView::Road {
            scene.route_line = network::route_line(&map.route, scene.origin);
        }
        scene
    }

    /// Builds the scene of a planned drive on a thread of its own: a world starts on one core, and SUMO takes a third of a second for a town.
    /// The scene is ready when the thread ends.
    pub fn begin(drive: &PlannedDrive) -> JoinHandle<Self> {
        let (map, scenario, roadside) = (Arc::clone(drive.map()), drive.scenario().clone(), drive.roadside().clone());
        std::thread::spawn(move || Self::of_drive(&map, &scenario, &roadside))
    }

    /// Builds the scene around all roads of a network, with at most `most_trees` trees.
    pub fn of_network(network: &Arc<Network>, seed: u64, most_trees: usize) -> Self {
        Self::beside(&Roadside::of(network, &[], seed, most_trees), None, most_trees)
    }

    /// Builds the scene with this roadside, whose town has this name.
    fn beside(roadside: &Roadside, place: Option<&str>, most_trees: usize) -> Self {
        // Views from above show the network's own roads, not what runs on beyond them.
        let Roadside { origin, network, own_surfaces: own, town, buildings, dead_ends, .. } = roadside;
        let seed = roadside.seed;
        let (drawn, roads) = (roadside.drawn_network(), roadside.surfaces());
        let relief = roadside.relief();
        let grown = |detail| move || trees::models(seed, detail);
        let woods = || {
            let trees = trees::models(seed, ModelDetail::Near);
            let places = forest::places(&roadside.woods().trees, &relief);
            let distant = forest::horizon(roads, &relief, seed, most_trees - places.len());
            (trees, forest::grounds(&places, &relief), places, distant)
        };
        // Parts are independent and have their own random numbers, so building them in parallel does not change them.
        let vehicles = VehicleModels::shared;
        let paved = || {
            let (mut posts, heads) = signals::heads(network, &roadside.signals);
            posts.append(&posts::posts(drawn, roads));
            let signed = SignedRoads { net: network, drawn, surfaces: roads, town, place };
            posts.append(&signed.mesh());
            posts.append(&guard_rails::mesh(&roadside.guard_rails));
            posts.append(&noise_walls::mesh(&roadside.noise_walls));
            posts.append(&barriers::barriers(dead_ends));
            posts.append(&street_lamps::mesh(&roadside.street_lamps));
            let lamp_heads: Vec<Vec3> = roadside.street_lamps.iter().map(street_lamps::head).collect();
            (network::road(drawn, town, roads, &relief, seed), posts, heads, lamp_heads)
        };
        let ground = || rayon::join(paved, || (land::land(&relief, own), buildings::mesh(buildings, &relief)));
        let growth = || {
            rayon::join(
                || rayon::join(woods, || tufts::sow(roads, buildings, &relief, seed)),
                || rayon::join(grown(ModelDetail::Mid), grown(ModelDetail::Shade)),
            )
        };
        let (
            ((woods, tuft_places), (trees_mid, trees_shade)),
            (((road, posts, signal_heads, street_lamps), (land, built)), VehicleModels { cars, cockpit, wheels }),
        ) = rayon::join(growth, || rayon::join(ground, vehicles));
        let (trees, tree_grounds, tree_places, far_tree_places) = woods;
        Self {
            origin: *origin,
            road,
            route_line: Mesh::default(),
            land,
            trees,
            trees_mid,
            trees_shade,
            tree_grounds,
            far_tree_places,
            tree_places,
            tuft: tufts::tuft(seed),
            tuft_places,
            posts,
            street_lamps,
            parked_cars: buildings::parked_cars(&roadside.parked_cars),
            buildings: built,
            signal_heads,
            lit_lamp: signals::lit_lamp(),
            cars,
            cockpit,
            wheels,
            hubs: car::hubs(),
            centre: own.centre(),
            radius_m: own.radius_m(),
            highest_m: roads.highest_m(),
            level_m: roads.level_m(),
            network: Arc::clone(network),
        }
    }

    /// Returns the height of the road, m, and its grade in the direction of `place`, in the local frame. `height_m` is the
    /// approximate height there, which selects among roads above each other. `None` beside all roads.
    pub fn road_at(&self, place: Pose, height_m: f64) -> Option<(f32, f32)> {
        if let Some(level_m) = self.level_m {
            return Some((level_m, 0.0));
        }
        let pose = Pose3 { position: place.position.extend(height_m), yaw_rad: place.yaw_rad, grade: 0.0 };
        self.network.locate_pose(&pose, None).map(|at| {
            let road = self.network.pose(at);
            let along = (place.yaw_rad - road.yaw_rad).cos();
            (road.position.z as f32, (road.grade * along) as f32)
        })
    }
}

/// Returns the name of a map's town: its title, or `None` for a map without one, whose title is its name.
fn place(map: &RoadMap) -> Option<&str> {
    (map.title != map.name).then_some(map.title.as_str())
}

/// Models that all scenes have in common.
#[derive(Clone, PartialEq)]
struct VehicleModels {
    /// Cars, then other kinds of vehicles.
    cars: Vec<CarModel>,
    cockpit: Cockpit,
    wheels: [Mesh; 3],
}

impl VehicleModels {
    /// Returns a copy of the models, which the first scene of a process builds: a session has many drives.
    fn shared() -> Self {
        static MODELS: OnceLock<VehicleModels> = OnceLock::new();
        // Not within `get_or_init`: a thread that waits there for others' parts could begin another scene, and wait for itself.
        MODELS.get().cloned().unwrap_or_else(|| {
            let built = Self::build();
            MODELS.get_or_init(|| built).clone()
        })
    }

    fn build() -> Self {
        let cars = || {
            let mut models = car::models();
            models.extend(vehicles::models());
            models
        };
        let (cars, (cockpit, wheels)) = rayon::join(cars, || rayon::join(Cockpit::new, wheel::wheels));
        Self { cars, cockpit, wheels }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::map::{RoadEdge, net_xml};
    use glam::{DVec2, dvec2};
    use std::f64::consts::TAU;

    /// Creates a closed road of one lane along these points, the last of which is the first.
    fn closed_road(shape: Vec<DVec2>, width_m: f64) -> RoadMap {
        let half = shape.len() / 2;
        let edge = |shape: &[DVec2]| RoadEdge {
            length_m: shape.windows(2).map(|pair| pair[0].distance(pair[1])).sum(),
            speed_limit_mps: 30.0,
            width_m,
            shape: shape.to_vec(),
        };
        let text = net_xml("A road of the tests.", &[edge(&shape[..=half]), edge(&shape[half..])]);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("test.net.xml");
        std::fs::write(&file, text).unwrap();
        RoadMap::load(file.to_str().unwrap()).unwrap_or_else(|fault| panic!("{fault}"))
    }

    /// Creates a ring of this circumference, driven counter-clockwise, 3.2 m wide.
    pub fn ring(circumference_m: f64) -> RoadMap {
        let n = (circumference_m * 2.0) as usize;
        let r = circumference_m / TAU;
        closed_road((0..=n).map(|i| DVec2::from_angle(TAU * (i % n) as f64 / n as f64) * r).collect(), 3.2)
    }

    /// Creates a circuit of two 400 m straights and two half circles of 60 m radius, away from the origin.
    pub fn circuit() -> RoadMap {
        let bend = |centre: DVec2, from: f64| {
            (0..=180).map(move |i| centre + DVec2::from_angle(from + TAU / 2.0 * f64::from(i) / 180.0) * 60.0)
        };
        let mut shape: Vec<DVec2> = bend(dvec2(700.0, 80.0), -TAU / 4.0).collect();
        shape.extend(bend(dvec2(300.0, 80.0), TAU / 4.0));
        shape.push(shape[0]);
        closed_road(shape, 3.6)
    }

    #[test]
    fn the_same_seed_gives_the_same_scene_and_another_seed_another() {
        let map = ring(250.0);
        let static_scene = StaticScene::build(&map, 7);
        assert!(static_scene == StaticScene::build(&map, 7), "same seed, same stage");
        assert!(static_scene.tree_places != StaticScene::build(&map, 8).tree_places);
        assert_eq!(StaticScene::with_trees(&map, 7, 100).tree_places.len(), 100);
        // The second scene has copies of these; what it copies is the same each time, too.
        assert!(VehicleModels::build() == VehicleModels::shared(), "models of vehicles");
        for detail in [ModelDetail::Near, ModelDetail::Mid, ModelDetail::Shade] {
            assert!(trees::models(8, detail) != trees::models(7, detail), "another seed, other trees");
            assert!(trees::built(7, detail) == trees::models(7, detail), "models of trees");
        }
    }

    #[test]
    fn every_mesh_is_valid() {
        for map in [ring(250.0), circuit()] {
            let static_scene = StaticScene::build(&map, 1);
            // Windows of vehicles other than cars are part of their bodies.
            let glass =
                |car: &'_ CarModel| car.glass.iter().filter(|glass| !glass.indices.is_empty()).cloned().collect();
            let glass: Vec<Vec<crate::scene::Mesh>> = static_scene.cars.iter().map(glass).collect();
            assert_eq!(glass.iter().map(Vec::len).sum::<usize>(), 6, "three styles of cars at two levels");
            let cars = static_scene
                .cars
                .iter()
                .flat_map(|car| &car.levels)
                .map(|level| &**level)
                .chain(glass.iter().flatten());
            let all = [
                &static_scene.road,
                &static_scene.land,
                &static_scene.cockpit.bonnet,
                &static_scene.cockpit.shelf,
                &static_scene.tuft,
                &static_scene.posts,
            ];
            for mesh in all
                .into_iter()
                .chain(&static_scene.wheels)
                .chain(cars)
                .chain(&static_scene.trees)
                .chain(&static_scene.trees_mid)
                .chain(&static_scene.trees_shade)
            {
                crate::scene::mesh::tests::check(mesh, "stage");
            }
            assert!(static_scene.land.triangles() < 60_000, "{}", static_scene.land.triangles());
        }
    }

    #[test]
    fn the_circle_of_the_birds_eye_view_contains_the_road() {
        for map in [ring(250.0), circuit()] {
            let static_scene = StaticScene::build(&map, 1);
            for k in 0..200 {
                let point = map.route.point_at(map.route.length_m() * f64::from(k) / 200.0).as_vec2();
                assert!(point.distance(static_scene.centre) <= static_scene.radius_m - 1.5);
            }
        }
    }
}
