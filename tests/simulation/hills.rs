//! A drive on a hill: its grade acts on the car, and who drives in the tunnel below is not there for it.

use super::world::one_at_a_time;
use codrive::{
    controls::{Controls, Selector},
    map::Route,
    scenario::Scenario,
    sim::{EventKind, World},
    space::CAR_LENGTH_M,
    traffic::{Demand, Flow},
};

const HILL: &str = "tests/data/networks/hill.net.xml";

/// The hill's steep piece: from 62 m to 112 m of the lane the road rises evenly, as its shape in the file says.
fn slope(route: &Route) -> (f64, f64) {
    let s_m = 90.0;
    (s_m, route.grade(s_m))
}

/// A drive up the hill that begins on the steep piece.
fn on_slope() -> Scenario {
    let route = codrive::map::RoadMap::load_along(HILL, &["up"]).expect("the hill").route;
    let path_start_m = slope(&route).0 + CAR_LENGTH_M / 2.0;
    Scenario { map: HILL.into(), path: "up".into(), path_start_m, creep: false, ..Scenario::default() }
}

#[test]
fn a_car_on_a_hill_in_neutral_rolls_back_by_g_times_the_sine_of_the_grade() {
    let _alone = one_at_a_time();
    let mut world = World::new(&on_slope()).unwrap_or_else(|error| panic!("{error}"));
    let (_, grade) = slope(&world.map().route);
    // 5 m to 14 m high over 62.52 m on the ground.
    assert!((grade - 9.0 / 62.52).abs() < 0.002, "{grade}");
    let z = world.snapshot().ego.position.z;
    assert!((5.0..14.0).contains(&z), "it stands on the hill: {z}");
    let neutral = Controls { selector: Selector::Neutral, ..Controls::default() };
    for _ in 0..100 {
        world.tick(&neutral).expect("a tick");
    }
    let before = world.snapshot().ego;
    for _ in 0..100 {
        world.tick(&neutral).expect("a tick");
    }
    let after = world.snapshot().ego;
    let params = world.ego_params();
    let (sin, cos) = (grade / grade.hypot(1.0), 1.0 / grade.hypot(1.0));
    let rolling = params.tyres.asphalt_rolling;
    let expected_mps2 = -9.81 * (sin - rolling * cos);
    let rate_mps2 = after.speed_mps - before.speed_mps;
    println!("{rate_mps2} {expected_mps2}, z {} {}", before.position.z, after.position.z);
    // Air holds back by 1 % at 2 m/s at most.
    assert!((rate_mps2 / expected_mps2 - 1.0).abs() < 0.01, "{rate_mps2} {expected_mps2}");
    assert!(after.position.z < before.position.z, "downhill");
    // It leans with the road, nose up.
    let nose = (after.rotation * glam::Vec3::X).z;
    assert!((f64::from(nose) - sin).abs() < 0.01, "{nose} {sin}");
}

#[test]
fn on_a_hill_the_brake_holds_a_car_and_the_engine_at_idle_holds_it_with_the_pull_of_its_converter() {
    let _alone = one_at_a_time();
    let mut world = World::new(&Scenario { creep: true, ..on_slope() }).unwrap_or_else(|error| panic!("{error}"));
    let (_, grade) = slope(&world.map().route);
    let held = Controls { brake: 0.5, ..Controls::default() };
    let start = world.snapshot().ego.position;
    for _ in 0..300 {
        world.tick(&held).expect("a tick");
    }
    let moved_m = world.snapshot().ego.position.distance(start);
    assert!(moved_m < 0.05, "the brake holds it: {moved_m}");
    let speeds: Vec<f64> = (0..200)
        .map(|_| {
            world.tick(&Controls::default()).expect("a tick");
            world.snapshot().ego.speed_mps
        })
        .collect();
    // A standing converter takes k w^2 at idle and multiplies it; first gear and final drive carry it to the axle.
    let p = world.ego_params();
    let idle_rad_s = p.engine.idle_rpm * std::f64::consts::TAU / 60.0;
    let turbine_nm = p.gearbox.pump_nms2 * idle_rad_s * idle_rad_s * p.gearbox.stall_ratio * p.gearbox.efficiency;
    let pull_n = turbine_nm * p.gearbox.ratios[0] * p.gearbox.final_drive / p.body.wheel_radius_m;
    let (sin, cos) = (grade / grade.hypot(1.0), 1.0 / grade.hypot(1.0));
    let expected_mps2 = -9.81 * (sin - p.tyres.asphalt_rolling * cos) + pull_n / p.body.mass_kg;
    let rate_mps2 = speeds[199] - speeds[99];
    println!("{rate_mps2} {expected_mps2}, pull {pull_n} N");
    assert!(pull_n > 0.1 * 9.81 * p.body.mass_kg * sin, "it holds a good part");
    assert!((rate_mps2 / expected_mps2 - 1.0).abs() < 0.02, "{rate_mps2} {expected_mps2}");
}

#[test]
fn a_car_on_a_hill_is_not_touched_by_those_in_the_tunnel_below() {
    let _alone = one_at_a_time();
    // By its description the road up crosses above the tunnel at (139, 31.5), 17 m high; the tunnel lies 2.6 m below zero there. The network
    // begins at y = 0, 100 m to the south of the description's.
    let route = codrive::map::RoadMap::load_along(HILL, &["up"]).expect("the hill").route;
    let above_m = route.project(glam::dvec2(140.3, 130.0), None).s_m;
    let flow = Flow { from: "tunnel".into(), to: "tunnel".into(), per_hour: 1200.0, mix: Vec::new() };
    let demand = Demand { files: Vec::new(), flows: vec![flow] };
    let scenario = Scenario { path_start_m: above_m + CAR_LENGTH_M / 2.0, demand, ..on_slope() };
    let mut world = World::new(&scenario).unwrap_or_else(|error| panic!("{error}"));
    let held = Controls { brake: 0.5, ..Controls::default() };
    let start = world.snapshot().ego.position;
    assert!((start.z - 17.0).abs() < 1.0, "{start}");
    let (mut below, mut contacts) = (0, 0);
    for _ in 0..6000 {
        world.tick(&held).expect("a tick");
        let snapshot = world.snapshot();
        let ego = snapshot.ego.position;
        let passes = snapshot.cars.iter().filter(|car| car.pose.position.distance(ego.truncate()) < 2.0);
        below += passes.filter(|car| car.height_m < ego.z - 10.0).count();
        contacts += world.events().iter().filter(|event| matches!(event.kind, EventKind::Contact { .. })).count();
    }
    assert!(below > 50, "vehicles pass below it: {below} ticks");
    assert_eq!(contacts, 0);
    assert!(world.snapshot().ego.position.distance(start) < 0.5, "it stands where it stood");
}
