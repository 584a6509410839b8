//! Tests of buildings: where they stand, and their meshes.

use super::*;
use crate::{
    map::{RoadMap, network::Network},
    roadside::{land_use_map::LandUseMap, relief::Relief, road_surfaces::RoadSurfaces, town::Town},
    scene::{Material, StaticScene, mesh::tests::check, trees::forest::tests::crown_radius_m},
};

fn network(name: &str) -> Network {
    Network::load(&format!("tests/data/networks/{name}.net.xml")).expect("a network")
}

fn shipped(name: &str) -> RoadMap {
    RoadMap::load(name).expect("a shipped map")
}

fn built(net: &Network, roads: &RoadSurfaces, seed: u64) -> Buildings {
    Buildings::of(net, &Town::of(net), &LandUseMap::of(net.surroundings(), roads), roads, seed)
}

#[test]
fn models_are_sound_within_their_triangles_and_stand_on_the_ground() {
    let net = network("town");
    let roads = RoadSurfaces::of(&net);
    let land_use = LandUseMap::default();
    let relief = Relief::new(&roads, &land_use, 3);
    for plot in built(&net, &roads, 3).plots {
        let (model, _, at) = placed(&plot, &relief);
        check(&model, "building");
        // Several hundred are in a town, and a picture has a budget of some hundred thousand.
        assert!(model.triangles() < 700, "{} triangles of {plot:?}", model.triangles());
        let (low, high) = model.bounds();
        assert!(at.z + low.z < relief.height_m(plot.middle()) - 1.0, "{plot:?} floats");
        assert!((4.0..25.0).contains(&high.z), "{} m high", high.z);
        // Walls are upright, and tiles are on slopes that rain runs off.
        for vertex in &model.vertices {
            let up = vertex.normal[2];
            match vertex.material & 0xff {
                wall if wall == Material::Wall as u32 => assert!(up.abs() < 1e-3),
                roof if roof == Material::Roof as u32 => assert!((0.3..0.99).contains(&up), "{up}"),
                _ => {}
            }
        }
    }
}

#[test]
fn an_attic_window_is_as_large_as_its_opening_and_sill() {
    let shader = include_str!("../../../shaders/building.wgsl");
    // Half the width and height of the opening, and the height of its middle.
    let [half_m, half_high_m, middle_m] = [0.45, 0.52, 1.40];
    assert!(shader.contains(&format!("vec4f({half_m:.2}, {half_high_m:.2}, {middle_m:.2}, ")), "the smallest window");
    assert!(shader.contains("vec2f(half.x + 0.09, 0.05)"), "a sill 10 cm high, 9 cm wider on each side");
    let [wide_m, sill_m, top_m] = houses::ATTIC_WINDOW_M;
    let wanted = [half_m + 0.09, middle_m - half_high_m - 0.1, middle_m + half_high_m];
    assert!([wide_m, sill_m, top_m].iter().zip(wanted).all(|(is, wanted)| (is - wanted).abs() < 1e-6), "{wanted:?}");
}

#[test]
fn no_tree_and_no_tuft_grows_in_a_building() {
    let map = shipped("grid");
    let static_scene = StaticScene::build(&map, 1);
    let buildings = built(&map.network, &RoadSurfaces::of(&map.network), 1);
    for tree in &static_scene.tree_places {
        let beyond_m = buildings.distance_m(tree.position.truncate());
        let crown_m = crown_radius_m(&static_scene.trees[tree.kind]) * tree.scale;
        assert!(beyond_m > 0.75 * crown_m, "a tree of {crown_m} m is {beyond_m} m from a wall");
    }
    let roads = RoadSurfaces::of(&map.network);
    for tuft in &static_scene.tuft_places {
        let at = tuft.position.truncate();
        // The shoulder of 0.4 m and the pavement of 2.4 m, at all streets.
        assert!(buildings.distance_m(at) > 0.2 && roads.border_m(at) > 2.8, "a tuft at {at}");
    }
}

#[test]
fn the_shader_reads_the_facade_from_the_bits_it_is_written_to() {
    use crate::roadside::footprint_places::STOREY_M;
    use crate::roadside::house_plans::{GroundFloor, WindowKind};
    use facade::{Facade, SHOP_M};
    let shader = include_str!("../../../shaders/building.wgsl");
    let number = |name: &str| -> f32 {
        let line = shader.lines().find_map(|line| line.strip_prefix(&format!("const {name} = "))).expect(name);
        line.trim_end_matches(';').parse().expect(name)
    };
    assert_eq!([number("STOREY"), number("SHOP")], [STOREY_M, SHOP_M]);
    // Shift and mask of each number, as the shader writes them.
    let read = |name: &str, bits: u32| -> u32 {
        let line = shader.lines().find(|line| line.trim().starts_with(&format!("let {name} = "))).expect(name);
        let (shift, mask) = line.split_once("bits >> ").and_then(|(_, rest)| rest.split_once("u) & ")).expect(name);
        let mask = mask.split('u').next().and_then(|mask| mask.parse::<u32>().ok()).expect(name);
        bits >> shift.parse::<u32>().expect(name) & mask
    };
    let facade = Facade {
        bay_m: 3.4,
        storeys: 5,
        windows: WindowKind::Tall,
        is_brick: true,
        ground: GroundFloor::Shops,
        seed: 201,
    };
    let bits = facade.material();
    assert_eq!(bits & 255, Material::Wall as u32);
    let names = ["bay", "storeys", "kind", "brick", "ground_floor", "seed"];
    assert_eq!(names.map(|name| read(name, bits)), [34, 5, 2, 1, 2, 201]);
    assert!((facade.height_m() - (3.6 + 4.0 * 3.0)).abs() < 1e-4);
}

#[test]
fn cars_are_parked_beside_houses_and_off_the_road() {
    let map = shipped("town");
    let static_scene = StaticScene::with_trees(&map, 1, 0);
    let net = &static_scene.network;
    let roads = RoadSurfaces::of(net);
    let buildings = built(net, &roads, 1);
    assert!(static_scene.parked_cars.len() > 20, "{}", static_scene.parked_cars.len());
    for car in &static_scene.parked_cars {
        assert!(car.is_parked, "lamps on");
        for corner in [(2.3, 0.8), (2.3, -0.8), (-2.3, 0.8), (-2.3, -0.8)] {
            let at = car.position + car.rotation * Vec3::new(corner.0, corner.1, 0.0);
            let (wall_m, road_m) = (buildings.distance_m(at.truncate()), roads.border_m(at.truncate()));
            assert!(wall_m > 0.3 && road_m > 0.3, "{at} is {wall_m} m from a wall and {road_m} m from a road");
        }
    }
}

#[test]
fn a_block_is_as_high_as_its_map_says() {
    use crate::map::surroundings::{BuildingUse, Footprint, Surroundings};
    use glam::{DVec2, dvec2};
    let footprint = |kind: BuildingUse, height_m: Option<f64>, outline: &[[f64; 2]]| {
        let outline: Vec<DVec2> = outline.iter().map(|[x, y]| dvec2(*x, *y)).collect();
        Footprint { outline, kind, height_m }
    };
    // The street A1B1 of the grid leads east along y = 90; its southern lane has its edge at y = 83.6.
    let corner = [[50.0, 60.0], [66.0, 60.0], [66.0, 75.0], [58.0, 75.0], [58.0, 68.0], [50.0, 68.0]];
    let net = network("grid-signals").with_surroundings(Surroundings {
        buildings: vec![footprint(BuildingUse::Flats, Some(13.5), &corner)],
        ..Surroundings::default()
    });
    let roads = RoadSurfaces::of(&net);
    let buildings = built(&net, &roads, 1);
    let land_use = LandUseMap::default();
    let relief = Relief::new(&roads, &land_use, 1);
    let mesh = mesh(&buildings, &relief);
    check(&mesh, "buildings");
    let of_block = |vertex: &&crate::scene::Vertex| {
        (49.9..66.1).contains(&vertex.position[0]) && (59.9..75.1).contains(&vertex.position[1])
    };
    let top_m = mesh.vertices.iter().filter(of_block).map(|vertex| vertex.position[2]).fold(0.0, f32::max);
    assert!((top_m - 13.5).abs() < 0.8, "13.5 m over the ground beside it, whose height differs a little: {top_m}");
}
