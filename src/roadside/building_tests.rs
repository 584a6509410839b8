//! Tests of the places of buildings.

use super::*;
use crate::{
    map::{
        RoadMap,
        surroundings::{BuildingUse, Footprint, LandArea, Surroundings},
    },
    roadside::plots::PlotKind,
};
use glam::{DVec2, dvec2};

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
        let roads = RoadSurfaces::of(&net);
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
    let of_grid = built(&grid, &RoadSurfaces::of(&grid), 1).plots;
    assert!(of_grid.len() > 24 * 2 * 3, "{}", of_grid.len());
    let [houses, flats, shops] = [PlotKind::House, PlotKind::Flats, PlotKind::Shops]
        .map(|kind| of_grid.iter().filter(|plot| plot.kind == kind).count());
    assert!(houses.min(flats).min(shops) > 5, "{houses} houses, {flats} flats, {shops} shops");
    // A motorway, whose map states 31 houses, and roads without a junction at the same limit of 50 km/h.
    for name in ["motorway", "merge", "bottleneck", "practice", "ring-250"] {
        let network = shipped(name).network;
        let stated = if name == "motorway" { 31 } else { 0 };
        assert_eq!(built(&network, &RoadSurfaces::of(&network), 1).plots.len(), stated, "{name}");
    }
}

#[test]
fn a_map_that_states_its_surroundings_is_built_up_where_it_says_so() {
    // The grid's streets cross every 100 m between 0 and 200 m. Houses to the west of x = 100, a park to the east; the extract ends at
    // y = 150. One building stands at the street in the south.
    let outline = LandArea::rectangle(LandUse::Paved, [30.0, 65.0], [14.0, 14.0]).outline;
    let surroundings = Surroundings {
        buildings: vec![Footprint { outline, kind: BuildingUse::Flats, height_m: None }],
        areas: vec![
            LandArea::rectangle(LandUse::Residential, [-10.0, -10.0], [110.0, 160.0]),
            LandArea::rectangle(LandUse::Park, [100.0, -10.0], [110.0, 160.0]),
        ],
        ..Surroundings::default()
    };
    let net = network("grid-signals").with_surroundings(surroundings);
    let plots = built(&net, &RoadSurfaces::of(&net), 3).plots;
    let count = |x: std::ops::Range<f32>, y: std::ops::Range<f32>| {
        plots.iter().filter(|plot| x.contains(&plot.middle().x) && y.contains(&plot.middle().y)).count()
    };
    assert_eq!(count(100.0..210.0, -10.0..150.0), 0, "no house stands in the park");
    assert!(count(-10.0..100.0, -10.0..150.0) >= 4, "{plots:?}");
    assert_eq!(count(10.0..65.0, 45.0..115.0), 1, "beside a stated building all others are stated, too");
    assert!(count(-60.0..260.0, 150.0..300.0) >= 4, "where the extract has ended, streets are those of a town");
}

#[test]
fn footprints_of_a_map_stand_where_it_says() {
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
    let roads = RoadSurfaces::of(&net);
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
}
