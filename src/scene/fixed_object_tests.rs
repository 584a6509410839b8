//! Tests that what stops a car stands where it is drawn.

use super::{
    Material, Mesh, StaticScene,
    network::signals,
    trees::{leaf_cards::ModelDetail, models},
};
use crate::{
    map::network::Network,
    roadside::{
        Roadside,
        fixed_objects::{FixedObject, FixedObjectKind, FixedObjects},
        trees::{BUSH, SPRUCE},
    },
    space::{CAR_LENGTH_M, CAR_WIDTH_M},
};
use glam::{DVec2, Vec2, Vec3};
use std::{collections::BTreeSet, f64::consts::PI, sync::Arc};

/// Seed of the scenes, and their number of trees.
const SEED: u64 = 3;
const TREES: usize = 600;

fn roadside(name: &str) -> Roadside {
    let network = Network::load(&format!("tests/data/networks/{name}.net.xml")).expect("a network of the tests");
    Roadside::of(&Arc::new(network), &[], SEED, TREES)
}

fn scene(roadside: &Roadside) -> StaticScene {
    StaticScene::of_network(&roadside.network, SEED, TREES)
}

/// Returns the objects of a kind, with their middles in the frame of the picture.
fn objects(roadside: &Roadside, kind: FixedObjectKind) -> Vec<(DVec2, FixedObject)> {
    let all = FixedObjects::of(roadside);
    let of_kind = all.iter().filter(|object| object.kind == kind);
    of_kind.map(|object| (object.pose.position - roadside.origin.truncate(), *object)).collect()
}

/// Returns the middle and the radius of a model's trunk at a height over its foot: the first rings of bark, each of `sides` corners.
fn drawn_trunk(model: &Mesh, sides: usize, height_m: f32) -> (Vec2, f32) {
    let bark: Vec<Vec3> =
        model.vertices.iter().filter(|v| v.material == Material::Bark as u32).map(|v| v.position.into()).collect();
    let [low, high] = [0, sides].map(|first| {
        let ring = &bark[first..first + sides];
        let middle = ring.iter().sum::<Vec3>() / sides as f32;
        (middle, ring[0].distance(middle))
    });
    let share = (height_m - low.0.z) / (high.0.z - low.0.z);
    (low.0.lerp(high.0, share).truncate(), low.1 + (high.1 - low.1) * share)
}

#[test]
fn trunks_stop_cars_where_they_are_drawn_and_bushes_do_not() {
    let roadside = roadside("town");
    let (scene, models) = (scene(&roadside), models(SEED, ModelDetail::Near));
    let trunks = objects(&roadside, FixedObjectKind::Tree);
    let drawn: Vec<_> = scene.tree_places.iter().filter(|place| place.kind != BUSH).collect();
    assert!(drawn.len() > 200 && drawn.len() < scene.tree_places.len(), "{} trees and some bushes", drawn.len());
    assert_eq!(trunks.len(), drawn.len());
    for ((middle, trunk), place) in trunks.iter().zip(drawn) {
        let sides = if place.kind == SPRUCE { 7 } else { 8 };
        // A bumper is half a metre above the ground.
        let (off, radius_m) = drawn_trunk(&models[place.kind], sides, 0.5 / place.scale);
        let at = place.position.truncate() + Vec2::from_angle(place.yaw_rad).rotate(off) * place.scale;
        assert!(middle.distance(at.as_dvec2()) < 2e-3, "{middle} {at}");
        let area_m2 = PI * f64::from(radius_m * place.scale).powi(2);
        assert!((trunk.length_m * trunk.width_m / area_m2 - 1.0).abs() < 0.02, "{trunk:?}");
    }
}

/// Returns the middles of the poles of a mesh: of what reaches into the ground, each a hexagon of 6 cm.
fn drawn_poles(mesh: &Mesh) -> Vec<DVec2> {
    let underground = mesh.vertices.iter().map(|v| Vec3::from(v.position)).filter(|at| at.z < -0.4);
    let corners: BTreeSet<[i64; 2]> =
        underground.map(|at| [at.x, at.y].map(|m| (f64::from(m) * 1000.0).round() as i64)).collect();
    let corners: Vec<DVec2> = corners.into_iter().map(|[x, y]| DVec2::new(x as f64, y as f64) / 1000.0).collect();
    let mut poles: Vec<Vec<DVec2>> = Vec::new();
    for corner in corners {
        match poles.iter_mut().find(|pole| pole[0].distance(corner) < 0.13) {
            Some(pole) => pole.push(corner),
            None => poles.push(vec![corner]),
        }
    }
    poles.iter().map(|pole| pole.iter().sum::<DVec2>() / pole.len() as f64).collect()
}

#[test]
fn poles_of_lamps_and_signals_stop_cars_where_they_are_drawn() {
    let roadside = roadside("grid-signals");
    let signals = drawn_poles(&signals::heads(&roadside.network, &roadside.signals).0);
    let lamps = drawn_poles(&super::network::street_lamps::mesh(&roadside.street_lamps));
    for (kind, drawn) in [(FixedObjectKind::SignalPole, signals), (FixedObjectKind::StreetLamp, lamps)] {
        let mut poles: Vec<DVec2> = objects(&roadside, kind).into_iter().map(|(middle, _)| middle).collect();
        // Two heads may share a place.
        poles.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        poles.dedup_by(|a, b| a.distance(*b) < 0.01);
        assert!(drawn.len() > 8, "{} of {kind:?}", drawn.len());
        assert_eq!(poles.len(), drawn.len(), "{kind:?}");
        for pole in poles {
            assert!(drawn.iter().any(|at| at.distance(pole) < 2e-3), "{kind:?} at {pole}");
        }
    }
}

#[test]
fn parked_cars_stop_cars_where_they_are_drawn() {
    let roadside = roadside("town");
    let (drawn, cars) = (scene(&roadside).parked_cars, objects(&roadside, FixedObjectKind::ParkedCar));
    assert!(drawn.len() > 10, "{}", drawn.len());
    assert_eq!(cars.len(), drawn.len());
    for ((middle, car), drawn) in cars.iter().zip(drawn) {
        let ahead = (drawn.rotation * Vec3::X).truncate().as_dvec2();
        assert!(middle.distance(drawn.position.truncate().as_dvec2()) < 1e-3, "{middle}");
        assert!(car.pose.forward().dot(ahead) > 0.999_99, "{car:?}");
        assert_eq!([car.length_m, car.width_m], [CAR_LENGTH_M, CAR_WIDTH_M]);
    }
}

#[test]
fn garden_fences_stop_cars_where_they_are_drawn() {
    let roadside = roadside("town");
    let vertices: Vec<DVec2> =
        scene(&roadside).buildings.vertices.iter().map(|v| Vec3::from(v.position).truncate().as_dvec2()).collect();
    for kind in [FixedObjectKind::Fence, FixedObjectKind::GardenWall] {
        let fences = objects(&roadside, kind);
        assert!(fences.len() > 5, "{} of {kind:?}", fences.len());
        for (middle, fence) in fences {
            let (along, aside) = (fence.pose.forward(), fence.pose.forward().perp());
            for (x, y) in [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)] {
                let corner = middle + along * x * fence.length_m + aside * y * fence.width_m;
                assert!(vertices.iter().any(|at| at.distance(corner) < 2e-3), "{kind:?} at {corner}");
            }
        }
    }
}
