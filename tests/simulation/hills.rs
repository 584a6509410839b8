//! A drive on a hill: its grade acts on the car, and vehicles in the tunnel below do not interact with it.

use super::world::one_at_a_time;
use codrive::{
    controls::{Controls, Selector},
    driver::{LaneView, Perception, SimulatedDriver, preset},
    ego::{CarParams, EgoCar, GroundModel, GroundShape, GroundSurface},
    map::Route,
    scenario::Scenario,
    sim::{EventKind, World},
    space::{CAR_LENGTH_M, Pose},
    time::TICK_S,
    traffic::{Demand, Flow},
};
use glam::{DVec2, dvec2};

const HILL: &str = "tests/data/networks/hill.net.xml";

/// Returns a position on the steep section, metres, and its grade: the road rises evenly from 62 m to 112 m of the lane, as its shape in
/// the file says.
fn slope(route: &Route) -> (f64, f64) {
    let s_m = 90.0;
    (s_m, route.grade(s_m))
}

/// Returns a scenario for a drive up the hill that starts on the steep section.
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
    // The road rises from 5 m to 14 m over 62.52 m on the ground.
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
    // Drag reduces the acceleration by at most 1 % at 2 m/s.
    assert!((rate_mps2 / expected_mps2 - 1.0).abs() < 0.01, "{rate_mps2} {expected_mps2}");
    assert!(after.position.z < before.position.z, "downhill");
    // The car pitches with the road, nose up.
    let nose = (after.rotation * glam::Vec3::X).z;
    assert!((f64::from(nose) - sin).abs() < 0.01, "{nose} {sin}");
}

#[test]
fn on_a_hill_the_brake_holds_the_car_and_the_converter_pulls_at_idle() {
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
    // A stalled converter takes k w^2 at idle and multiplies it; first gear and final drive transmit it to the axle.
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

/// Road to the east that rises evenly.
struct Slope(f64);

impl GroundModel for Slope {
    fn surface(&self, _point: DVec2) -> GroundSurface {
        GroundSurface::Asphalt
    }

    fn shape(&self, middle: DVec2) -> GroundShape {
        GroundShape { height_m: self.0 * middle.x, gradient: dvec2(self.0, 0.0) }
    }
}

/// Returns the position of the front of a car in each tick, metres from a line. Its driver approaches the line at 10 m/s from 50 m away and
/// stops; the line opens after 30 s.
fn stops_at_a_line(grade: f64) -> Vec<f64> {
    let (car, line_m) = (CarParams::default(), 50.0);
    let start = Pose::new(dvec2(-CAR_LENGTH_M / 2.0, 0.0), 0.0);
    let mut ego = EgoCar::new(&car, start, 10.0, 0).expect("a car");
    let mut driver = SimulatedDriver::new(&preset("idm").expect("a preset"), &car, 1).expect("a driver");
    let fronts = (0..4000).map(|tick| {
        let state = *ego.state();
        let front_m = state.pose().front(CAR_LENGTH_M).x;
        let is_open = f64::from(tick) * TICK_S > 30.0;
        let controls = driver.controls(&Perception {
            speed_mps: state.speed_mps,
            lane: LaneView { grade, ..LaneView::default() },
            stop_ahead_m: (!is_open).then_some(line_m - front_m),
            speed_limit_mps: 13.9,
            ..Perception::default()
        });
        ego.tick(&controls, &Slope(grade), &[]);
        front_m - line_m
    });
    fronts.collect()
}

#[test]
fn a_driver_stops_at_a_line_on_a_hill_and_starts_without_rolling_back() {
    // Streets are as steep as 12 %; the steepest public roads have 20 % and more.
    for grade in [-0.2, -0.12, 0.0, 0.12, 0.2] {
        let fronts = stops_at_a_line(grade);
        let (stood_m, then_m) = (fronts[1500], fronts[3000]);
        assert!((-4.0..=0.0).contains(&stood_m), "{grade}: it stands {stood_m} m before the line");
        assert!((then_m - stood_m).abs() < 0.02, "{grade}: it moves by {} m in 15 s", then_m - stood_m);
        let back_m = fronts[3000..].iter().fold(f64::INFINITY, |least, front_m| front_m.min(least)) - then_m;
        // No vehicle behind is closer than a metre.
        assert!(
            back_m > -1.0 && fronts[3999] > 10.0,
            "{grade}: it rolls back {back_m} m and drives {} m",
            fronts[3999]
        );
    }
}

#[test]
fn vehicles_in_the_tunnel_below_do_not_touch_a_car_on_the_hill() {
    let _alone = one_at_a_time();
    // By its description, the road crosses above the tunnel at (139, 31.5), 17 m high; the tunnel lies 2.6 m below zero there. The network
    // begins at y = 0, 100 m south of the description's origin.
    let route = codrive::map::RoadMap::load_along(HILL, &["up"]).expect("the hill").route;
    let above_m = route.project(dvec2(140.3, 130.0), None).s_m;
    let flow = Flow { from: "tunnel".into(), to: "tunnel".into(), per_hour: 1200.0, mix: Vec::new() };
    let demand = Demand { flows: vec![flow], ..Demand::default() };
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
