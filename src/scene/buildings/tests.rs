//! Tests of buildings: where they stand, and their meshes.

use super::{plots::PlotKind, *};
use crate::{
    map::RoadMap,
    scene::{Material, StaticScene, mesh::tests::check, network::surfaces, trees::forest::crown_radius_m},
};

fn network(name: &str) -> Network {
    Network::load(&format!("tests/data/networks/{name}.net.xml")).expect("a network")
}

fn shipped(name: &str) -> RoadMap {
    RoadMap::load(name).expect("a shipped map")
}

/// Returns points all over a building, half a metre from its walls.
fn points(plot: &Plot) -> Vec<Vec2> {
    let shares = [-0.5f32, -0.25, 0.0, 0.25, 0.5];
    let inner = Vec2::new(plot.width_m, plot.depth_m) - 1.0;
    let all = shares.iter().flat_map(|right| shares.map(|behind| (*right, behind)));
    all.map(|(right, behind)| plot.point(right * inner.x, plot.depth_m / 2.0 + behind * inner.y)).collect()
}

fn built(net: &Network, roads: &RoadSurfaces, seed: u64) -> Buildings {
    Buildings::of(net, &Town::of(net), &LandUseMap::of(net.surroundings(), roads), roads, seed)
}

#[test]
fn buildings_stand_beside_roads_and_apart_from_each_other() {
    for name in ["town", "town-left", "grid-signals", "hill", "roundabout"] {
        let net = network(name);
        let roads = surfaces(&net);
        let buildings = built(&net, &roads, 3);
        for (k, plot) in buildings.plots.iter().enumerate() {
            for point in points(plot) {
                assert!(roads.border_m(point) > 0.2, "{name}: {point} of {plot:?} is on a road");
                for other in &buildings.plots[..k] {
                    assert!(other.distance_m(point) > 0.0, "{name}: {plot:?} is in {other:?}");
                }
            }
            // A fence leaves the pavement free, but for 20 cm.
            let fence = |right_m: f32| roads.border_m(plot.point(right_m, -plot.garden_m));
            let middle_m = fence(0.0);
            let ends = [-0.5, 0.5].map(|share| fence(share * plot.width_m));
            assert!(!plot.has_fence || ends.iter().all(|end_m| *end_m > middle_m - 0.25), "{name}: {plot:?}");
            // A front faces the street it is built on.
            let before = |m: f32| roads.border_m(plot.front - plot.inwards * m);
            assert!(before(plot.garden_m + 3.0) < before(0.0), "{name}: {plot:?}");
        }
        assert!(buildings.plots == built(&net, &roads, 3).plots, "the same seed, the same town");
    }
}

#[test]
fn streets_of_towns_are_built_up_and_no_other_roads() {
    // Twelve streets of 200 m between nine crossings, and twelve at the edge: on both sides of each there is room for at least three buildings
    // of 22 m, the widest, with 12 m between them.
    let grid = shipped("grid").network;
    let of_grid = built(&grid, &surfaces(&grid), 1).plots;
    assert!(of_grid.len() > 24 * 2 * 3, "{}", of_grid.len());
    let [houses, flats, shops] = [PlotKind::House, PlotKind::Flats, PlotKind::Shops]
        .map(|kind| of_grid.iter().filter(|plot| plot.kind == kind).count());
    assert!(houses.min(flats).min(shops) > 5, "{houses} houses, {flats} flats, {shops} shops");
    // A motorway, and roads without a junction at the same limit of 50 km/h.
    for name in ["motorway", "merge", "bottleneck", "practice", "ring-250"] {
        let network = shipped(name).network;
        assert!(built(&network, &surfaces(&network), 1).plots.is_empty(), "{name}");
    }
}

#[test]
fn models_are_sound_within_their_triangles_and_stand_on_the_ground() {
    let net = network("town");
    let roads = surfaces(&net);
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
fn no_tree_and_no_tuft_grows_in_a_building() {
    let map = shipped("grid");
    let static_scene = StaticScene::build(&map, 1);
    let buildings = built(&map.network, &surfaces(&map.network), 1);
    for tree in &static_scene.tree_places {
        let beyond_m = buildings.distance_m(tree.position.truncate());
        let crown_m = crown_radius_m(&static_scene.trees[tree.kind]) * tree.scale;
        assert!(beyond_m > 0.75 * crown_m, "a tree of {crown_m} m is {beyond_m} m from a wall");
    }
    let roads = surfaces(&map.network);
    for tuft in &static_scene.tuft_places {
        let at = tuft.position.truncate();
        // The shoulder of 0.4 m and the pavement of 2.4 m, at all streets.
        assert!(buildings.distance_m(at) > 0.2 && roads.border_m(at) > 2.8, "a tuft at {at}");
    }
}

#[test]
fn the_shader_reads_the_facade_from_the_bits_it_is_written_to() {
    use facade::{Facade, GroundFloor, SHOP_M, STOREY_M, WindowKind};
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
    let roads = surfaces(net);
    let buildings = built(net, &roads, 1);
    assert!(static_scene.parked_cars.len() > 20, "{}", static_scene.parked_cars.len());
    for car in &static_scene.parked_cars {
        for corner in [(2.3, 0.8), (2.3, -0.8), (-2.3, 0.8), (-2.3, -0.8)] {
            let at = car.position + car.rotation * Vec3::new(corner.0, corner.1, 0.0);
            let (wall_m, road_m) = (buildings.distance_m(at.truncate()), roads.border_m(at.truncate()));
            assert!(wall_m > 0.3 && road_m > 0.3, "{at} is {wall_m} m from a wall and {road_m} m from a road");
        }
    }
}

#[test]
fn footprints_of_a_map_stand_where_it_says() {
    use crate::map::surroundings::{BuildingUse, Footprint, Surroundings};
    use glam::{DVec2, dvec2};
    let footprint = |kind: BuildingUse, height_m: Option<f64>, outline: &[[f64; 2]]| {
        let outline: Vec<DVec2> = outline.iter().map(|[x, y]| dvec2(*x, *y)).collect();
        Footprint { outline, kind, height_m }
    };
    // The street A1B1 of the grid leads east along y = 90; its southern lane has its edge at y = 83.6.
    let house = [[30.0, 65.0], [42.0, 65.0], [42.0, 74.0], [36.0, 74.05], [30.0, 74.0]];
    let corner = [[50.0, 60.0], [66.0, 60.0], [66.0, 75.0], [58.0, 75.0], [58.0, 68.0], [50.0, 68.0]];
    let over = [[70.0, 80.0], [76.0, 80.0], [76.0, 95.0], [70.0, 95.0]];
    let far = [[30.0, -900.0], [42.0, -900.0], [42.0, -890.0], [30.0, -890.0]];
    let net = network("grid-signals").with_surroundings(Surroundings {
        buildings: vec![
            footprint(BuildingUse::House, Some(6.0), &house),
            footprint(BuildingUse::Flats, Some(13.5), &corner),
            footprint(BuildingUse::House, None, &over),
            footprint(BuildingUse::House, None, &far),
        ],
        ..Surroundings::default()
    });
    let roads = surfaces(&net);
    let buildings = built(&net, &roads, 1);
    let [plot, others @ ..] = &buildings.plots[..] else { panic!("no building") };
    assert!(others.iter().all(|other| other.distance_m(plot.middle()) > 20.0), "{others:?}");
    assert_eq!((plot.kind, plot.storeys), (PlotKind::House, Some(2)));
    assert!(plot.front.distance(Vec2::new(36.0, 74.0)) < 0.1 && plot.inwards.distance(Vec2::NEG_Y) < 0.01, "{plot:?}");
    assert!((plot.width_m - 12.0).abs() < 0.1 && (plot.depth_m - 9.0).abs() < 0.1, "{plot:?}");
    assert_eq!(buildings.blocks.len(), 1, "nothing stands over a road or out of sight");
    for (point, distance_m) in
        [((36.0, 70.0), 0.0), ((54.0, 64.0), 0.0), ((54.0, 71.0), 3.0), ((64.0, 72.0), 0.0), ((68.0, 70.0), 2.0)]
    {
        let found_m = buildings.distance_m(Vec2::from(point));
        assert!((found_m - distance_m).abs() < 0.01, "{point:?}: {found_m}");
    }
    let land_use = LandUseMap::default();
    let relief = Relief::new(&roads, &land_use, 1);
    let mesh = buildings.mesh(&relief);
    check(&mesh, "buildings");
    let of_block = |vertex: &&crate::scene::Vertex| {
        (49.9..66.1).contains(&vertex.position[0]) && (59.9..75.1).contains(&vertex.position[1])
    };
    let top_m = mesh.vertices.iter().filter(of_block).map(|vertex| vertex.position[2]).fold(0.0, f32::max);
    assert!((top_m - 13.5).abs() < 0.8, "13.5 m over the ground beside it, whose height differs a little: {top_m}");
}

#[test]
fn a_map_that_states_its_surroundings_is_built_up_where_it_says_so() {
    use crate::map::surroundings::{BuildingUse, Footprint, LandUse, Surroundings};
    use crate::scene::land::land_use_map::tests::rectangle;
    // The grid's streets cross every 100 m between 0 and 200 m. Houses to the west of x = 100, a park to the east; the extract ends at
    // y = 150. One building stands at the street in the south.
    let outline = rectangle(LandUse::Paved, [30.0, 65.0], [14.0, 14.0]).outline;
    let surroundings = Surroundings {
        buildings: vec![Footprint { outline, kind: BuildingUse::Flats, height_m: None }],
        areas: vec![
            rectangle(LandUse::Residential, [-10.0, -10.0], [110.0, 160.0]),
            rectangle(LandUse::Park, [100.0, -10.0], [110.0, 160.0]),
        ],
        trees: Vec::new(),
    };
    let net = network("grid-signals").with_surroundings(surroundings);
    let plots = built(&net, &surfaces(&net), 3).plots;
    let count = |x: std::ops::Range<f32>, y: std::ops::Range<f32>| {
        plots.iter().filter(|plot| x.contains(&plot.middle().x) && y.contains(&plot.middle().y)).count()
    };
    assert_eq!(count(100.0..210.0, -10.0..150.0), 0, "no house stands in the park");
    assert!(count(-10.0..100.0, -10.0..150.0) >= 4, "{plots:?}");
    assert_eq!(count(10.0..65.0, 45.0..115.0), 1, "beside a stated building all others are stated, too");
    assert!(count(-60.0..260.0, 150.0..300.0) >= 4, "where the extract has ended, streets are those of a town");
}
