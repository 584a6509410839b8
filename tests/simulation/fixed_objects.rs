//! Walls, guard rails, parapets, trees and poles stop a car that leaves the road, and a drive that stays on it never looks for them.

use super::world::one_at_a_time;
use codrive::{
    controls::{Controls, STEERING_RATIO},
    driver::{SimulatedDriver, preset},
    roadside::fixed_objects::FixedObjectKind,
    scenario::{OnContact, Scenario},
    scene::StaticScene,
    sim::{EndReason, EventKind, World},
    space::{CAR_LENGTH_M, Pose, wrap_angle},
};
use glam::DVec2;
use std::{f64::consts::FRAC_PI_2, fs};

/// Contact with a fixed object.
#[derive(Clone, Copy, Debug)]
struct Hit {
    object: FixedObjectKind,
    ego_speed_mps: f64,
    closing_mps: f64,
}

/// Returns the controls of a driver who keeps a speed and turns to a heading.
fn towards(world: &World, yaw_rad: f64, speed_mps: f64) -> Controls {
    let ego = &world.snapshot().ego;
    let turn = wrap_angle(yaw_rad - ego.pose().yaw_rad);
    let steering_wheel_rad = (1.2 * turn - 0.2 * ego.yaw_rate).clamp(-0.5, 0.5) as f32 * STEERING_RATIO;
    let pedal = ((speed_mps - ego.speed_mps) * 0.5).clamp(-1.0, 1.0) as f32;
    Controls { steering_wheel_rad, throttle: pedal.max(0.0), brake: (-pedal).max(0.0), ..Controls::default() }
}

/// Drives towards a heading; returns the contacts with fixed objects and all positions of the ego.
fn driven(world: &mut World, ticks: usize, yaw_rad: f64, speed_mps: f64) -> (Vec<Hit>, Vec<DVec2>) {
    driven_by(world, ticks, |_| yaw_rad, speed_mps)
}

/// Drives as `driven`, towards a heading that depends on the pose.
fn driven_by(
    world: &mut World,
    ticks: usize,
    yaw_rad: impl Fn(&Pose) -> f64,
    speed_mps: f64,
) -> (Vec<Hit>, Vec<DVec2>) {
    let (mut hits, mut places) = (Vec::new(), Vec::new());
    for _ in 0..ticks {
        let controls = towards(world, yaw_rad(&world.snapshot().ego.pose()), speed_mps);
        world.tick(&controls).expect("a tick");
        hits.extend(world.events().iter().filter_map(|event| match event.kind {
            EventKind::ObjectContact { object, ego_speed_mps, closing_mps } => {
                Some(Hit { object, ego_speed_mps, closing_mps })
            }
            _ => None,
        }));
        places.push(world.snapshot().ego.position.truncate());
        if world.ended().is_some() {
            break;
        }
    }
    (hits, places)
}

fn world(scenario: &Scenario) -> World {
    World::new(&Scenario { policy: "none".into(), creep: false, lane_help: false, ..scenario.clone() })
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Returns a scenario on the grid of the tests with one building to the south of its street A1B1, whose northern wall is at y = 76 m, and the
/// folder that must outlive it. `outline` is that of the building, metres.
fn with_building(outline: &str) -> (Scenario, tempfile::TempDir) {
    with_surroundings(&format!("<poly id=\"b\" type=\"building.house\" height=\"6\" shape=\"{outline}\"/>"))
}

/// Returns a scenario on the grid of the tests with these elements in its surroundings, and the folder that must outlive it.
fn with_surroundings(elements: &str) -> (Scenario, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let net = folder.path().join("net.xml");
    fs::copy("tests/data/networks/grid-signals.net.xml", &net).unwrap();
    fs::write(folder.path().join("surroundings.xml"), format!("<additional>{elements}</additional>")).unwrap();
    let scenario =
        Scenario { map: net.to_str().unwrap().into(), path: "A1B1".into(), path_start_m: 30.0, ..Scenario::default() };
    (scenario, folder)
}

#[test]
fn a_wall_stops_a_car_where_its_map_states_it() {
    let _alone = one_at_a_time();
    // A rectangle, and an outline of six walls.
    for outline in ["30,60 80,60 80,76 30,76", "30,60 80,60 80,76 30,76 30,70 34,68"] {
        let (scenario, _folder) = with_building(outline);
        let mut world = world(&scenario);
        let (hits, places) = driven(&mut world, 1200, -FRAC_PI_2, 8.0);
        let [first, ..] = hits[..] else { panic!("no contact: {:?}", places.last()) };
        assert_eq!(first.object, FixedObjectKind::Building);
        // The car meets the wall almost at a right angle.
        assert!(first.closing_mps > 0.8 * first.ego_speed_mps && first.ego_speed_mps > 4.0, "{first:?}");
        let lowest_m = places.iter().map(|at| at.y).fold(f64::INFINITY, f64::min);
        // The physics lets a car in by a few centimetres before it pushes it out.
        assert!((lowest_m - CAR_LENGTH_M / 2.0 - 76.0).abs() < 0.15, "the middle came to y = {lowest_m} m");
        assert_eq!(world.snapshot().ego.speed_mps.abs().round(), 0.0, "it stands before the wall");
    }
}

#[test]
fn a_tree_stops_a_car_where_its_map_states_it() {
    let _alone = one_at_a_time();
    // No house stands on a field, and no tree that the map does not state.
    let field = "<poly id=\"f\" type=\"landuse.farmland\" shape=\"-50,-50 250,-50 250,250 -50,250\"/>";
    let tree = DVec2::new(75.0, 72.0);
    let (scenario, _folder) =
        with_surroundings(&format!("{field}<poi id=\"t\" type=\"natural.tree\" x=\"{}\" y=\"{}\"/>", tree.x, tree.y));
    let mut world = world(&scenario);
    let (hits, places) = driven_by(&mut world, 1500, |ego| (tree - ego.position).to_angle(), 8.0);
    let [first, ..] = hits[..] else { panic!("no contact: {:?}", places.last()) };
    assert_eq!((first.object, first.object.name()), (FixedObjectKind::Tree, "tree"));
    // The car meets the tree head on.
    assert!(first.closing_mps > 0.9 * first.ego_speed_mps && first.ego_speed_mps > 4.0, "{first:?}");
    let nearest_m = places.iter().map(|at| at.distance(tree)).fold(f64::INFINITY, f64::min);
    // The trunk is some 0.3 m thick, and leans by as much at most.
    assert!((CAR_LENGTH_M / 2.0 - 0.2..CAR_LENGTH_M / 2.0 + 0.6).contains(&nearest_m), "{nearest_m} m");
    assert_eq!(world.snapshot().ego.speed_mps.abs().round(), 0.0, "it stands before the tree");
}

/// Returns the picture of a network of the tests without trees, as with the default seed.
fn picture(map: &str) -> StaticScene {
    let map = codrive::map::RoadMap::load(map).expect("a map");
    StaticScene::with_trees(&map, Scenario::default().seed, 0)
}

#[test]
fn the_pole_of_a_lamp_stops_a_car_where_it_is_drawn() {
    let _alone = one_at_a_time();
    let map = "tests/data/networks/grid-signals.net.xml";
    // South of the street A1B1, whose lanes are at y = 85.2 and 88.4 m and 3.2 m wide.
    let south = |at: &&glam::Vec3| (20.0..75.0).contains(&at.x) && (78.0..88.0).contains(&at.y);
    let lamps = picture(map).street_lamps;
    let head = lamps.iter().find(south).unwrap_or_else(|| panic!("no lamp on the south side: {lamps:?}"));
    // The lamp is over the street, 1.1 m before its pole.
    let pole = head.truncate().as_dvec2() - DVec2::Y * 1.1;
    assert!(pole.y < 85.2 - 1.6, "{pole}");
    let mut world = world(&Scenario { map: map.into(), path: "A1B1".into(), path_start_m: 1.0, ..Scenario::default() });
    let (hits, places) = driven_by(&mut world, 1500, |ego| (pole - ego.position).to_angle(), 6.0);
    let [first, ..] = hits[..] else { panic!("no contact: {pole}, {:?}", places.last()) };
    assert_eq!((first.object, first.object.name()), (FixedObjectKind::StreetLamp, "street lamp"));
    assert!(first.closing_mps > 0.9 * first.ego_speed_mps, "{first:?}");
    let nearest_m = places.iter().map(|at| at.distance(pole)).fold(f64::INFINITY, f64::min);
    assert!((nearest_m - CAR_LENGTH_M / 2.0).abs() < 0.3, "{nearest_m} m");
}

#[test]
fn the_pole_of_a_lamp_stops_a_car_on_a_pavement() {
    let _alone = one_at_a_time();
    // The pavement of the street cn is 2 m wide around x = 124.2, and its lamps are 0.45 m from the edge, at x = 124.75.
    let map = "tests/data/networks/town.net.xml".into();
    let mut world = world(&Scenario { map, path: "cn".into(), path_start_m: 2.0, ..Scenario::default() });
    let along_pavement = |ego: &Pose| FRAC_PI_2 + (0.2 * (ego.position.x - 124.1)).clamp(-0.4, 0.4);
    let (hits, places) = driven_by(&mut world, 2000, along_pavement, 6.0);
    let [first, ..] = hits[..] else { panic!("no contact: {:?}", places.last()) };
    assert_eq!(first.object, FixedObjectKind::StreetLamp);
    // The pole is 0.65 m to the right of the car's middle: it is hit by the bumper, not by a door.
    assert!(first.closing_mps > 0.8 * first.ego_speed_mps, "{first:?}");
}

#[test]
fn a_drive_ends_at_a_wall_if_it_ends_at_a_contact() {
    let _alone = one_at_a_time();
    let (scenario, _folder) = with_building("30,60 80,60 80,76 30,76");
    let mut world = world(&Scenario { contact: OnContact::End, ..scenario });
    let (hits, _) = driven(&mut world, 1200, -FRAC_PI_2, 8.0);
    assert_eq!((hits.len(), world.ended()), (1, Some(EndReason::Contact)));
}

#[test]
fn a_drive_that_stays_on_the_road_looks_for_no_object() {
    let _alone = one_at_a_time();
    // Round corners, over crossings and past the kerbs of the town, by the simulated driver.
    let scenario = Scenario { map: "town".into(), policy: "none".into(), duration_s: 60.0, ..Scenario::default() };
    let mut world = World::new(&scenario).unwrap_or_else(|error| panic!("{error}"));
    let params = preset("follow").expect("a shipped driver");
    let mut driver = SimulatedDriver::new(&params, world.ego_params(), 1).expect("a driver");
    while world.ended().is_none() {
        let controls = driver.controls(&world.perceived_by(&driver));
        world.tick(&controls).expect("a tick");
    }
    assert!(world.snapshot().ego_s_m > 200.0 && !world.drive().roadside().is_found());
}

#[test]
fn a_guard_rail_keeps_a_fast_car_on_a_motorway() {
    let _alone = one_at_a_time();
    let mut world = world(&Scenario { map: "motorway".into(), path_start_m: 300.0, ..Scenario::default() });
    let net = world.map().network.clone();
    let start = world.snapshot().ego.pose();
    // Ten degrees to the right of the road, at 30 m/s.
    let (hits, places) = driven(&mut world, 1800, start.yaw_rad - 10f64.to_radians(), 30.0);
    let [first, ..] = hits[..] else { panic!("no contact") };
    assert_eq!(first.object, FixedObjectKind::GuardRail);
    // Much of the speed is along the rail: the closing speed is the sine of the angle's share.
    assert!(first.closing_mps < 0.3 * first.ego_speed_mps, "{first:?}");
    // The rail stands 1.35 m beside the outer lane of 3.75 m at most; half of the car is 0.9 m wide.
    for at in places {
        let lane = net.locate(at.extend(0.0), None).unwrap_or_else(|| panic!("{at} is far off the road"));
        let beyond_m = lane.offset_m.abs() - net.lane(lane.lane).half_width_m();
        assert!(beyond_m < 1.35, "{at} is {beyond_m} m beside the lane");
    }
}

#[test]
fn a_parapet_keeps_a_car_on_a_bridge() {
    let _alone = one_at_a_time();
    let mut world = world(&Scenario {
        map: "tests/data/networks/hill.net.xml".into(),
        path: "up".into(),
        path_start_m: 130.0,
        ..Scenario::default()
    });
    let height_m = world.snapshot().ego.position.z;
    let right = world.snapshot().ego.pose().yaw_rad - 0.5;
    let (hits, places) = driven(&mut world, 1000, right, 6.0);
    assert_eq!(hits.first().map(|hit| hit.object), Some(FixedObjectKind::Parapet), "{height_m} m: {:?}", places.last());
    // The parapet stands where the shoulder of 0.4 m ends, so that the middle of the car is within it.
    let net = world.map().network.clone();
    for at in places {
        let lane = net.locate(at.extend(height_m), None).unwrap_or_else(|| panic!("{at} is far off the road"));
        let beyond_m = lane.offset_m.abs() - net.lane(lane.lane).half_width_m();
        assert!(beyond_m < 0.4, "{at} is {beyond_m} m beside the lane");
    }
}
