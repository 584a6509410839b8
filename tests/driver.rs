//! What must hold of simulated drivers in the ego: they keep their lane, reach and hold what is advised, react when a
//! person would and not before, and keep behind their leader with calm feet. Figures in the comments are measured.

use codrive::{
    driver::{DriverParams, PRESETS, Perception, SeenLeader, SimulatedDriver, preset},
    ego::{CarParams, Controls, Ego, EgoState, Everywhere, Obstacle, Surface},
    map::{Lane, Route},
    policy::{Action, Advice},
    space::{CAR_LENGTH_M, Pose},
    time::{TICK_S, Tick},
};
use glam::{DVec2, dvec2};
use std::f64::consts::{PI, TAU};

/// One lane as a closed route; its length is that of its shape.
fn closed(shape: Vec<DVec2>) -> Route {
    let length_m = shape.windows(2).map(|p| p[0].distance(p[1])).sum();
    let (id, edge) = ("e0_0".to_owned(), "e0".to_owned());
    Route::new(vec![Lane { id, edge, start_s_m: 0.0, length_m, speed_limit_mps: 30.0, width_m: 3.2, shape }])
}

/// A ring of radius `r`, a point every 2.5 m as SUMO's nets have them.
fn ring(r: f64) -> Route {
    let n = (TAU * r / 2.5).ceil() as usize;
    closed((0..=n).map(|i| DVec2::from_angle(TAU * i as f64 / n as f64) * r).collect())
}

/// Two straights of 500 m and two bends of 50 m radius.
fn oval() -> Route {
    let bend = |centre: DVec2, from: f64| {
        (0..=63).map(move |i| centre + DVec2::from_angle(from + PI * f64::from(i) / 63.0) * 50.0)
    };
    let mut shape = vec![dvec2(0.0, -50.0)];
    shape.extend(bend(dvec2(500.0, 0.0), -PI / 2.0));
    shape.extend(bend(dvec2(0.0, 0.0), PI / 2.0));
    closed(shape)
}

/// The car ahead: front bumper along the route and speed at a time in seconds.
type LeaderAt<'a> = &'a dyn Fn(f64) -> (f64, f64);

struct Run<'a> {
    route: &'a Route,
    params: DriverParams,
    seed: u64,
    start_speed_mps: f64,
    /// Advised speed at a time in seconds.
    advised: &'a dyn Fn(f64) -> Option<f64>,
    leader: Option<LeaderAt<'a>>,
    seconds: f64,
}

/// What was seen of one tick.
struct Seen {
    controls: Controls,
    state: EgoState,
    /// Offset of the car's centre from the lane's, metres.
    offset_m: f64,
    gap_m: f64,
    contact: bool,
}

impl Run<'_> {
    fn go(&self) -> Vec<Seen> {
        let car = CarParams::default();
        let start_s = 10.0;
        let start = self.route.pose_of_front(start_s, CAR_LENGTH_M);
        let cars = usize::from(self.leader.is_some());
        let mut ego = Ego::new(&car, start, self.start_speed_mps, cars).unwrap();
        let mut driver = SimulatedDriver::new(&self.params, &car, self.seed).unwrap();
        let mut s_m = start_s;
        let leader_at = |t: f64| self.leader.map(|leader| leader(t));
        (0..(self.seconds / TICK_S) as u64)
            .map(|i| {
                let t = i as f64 * TICK_S;
                let state = *ego.state();
                s_m = self.route.project(state.pose().front(CAR_LENGTH_M), Some(s_m)).s_m;
                let gap_m = |(s, _): (f64, f64)| self.route.difference(s_m, self.route.wrap(s - CAR_LENGTH_M));
                let leader = leader_at(t);
                let advice = (self.advised)(t).map(|target_mps| Advice {
                    issued: Tick(i),
                    hold_steps: 1,
                    action: Action::Speed(target_mps),
                    target_mps,
                    range_mps: 0.5,
                });
                let controls = driver.controls(&Perception {
                    speed_mps: state.speed_mps,
                    lane: driver.look(self.route, &state, Some(s_m)),
                    leader: leader.map(|l| SeenLeader { gap_m: gap_m(l), speed_mps: l.1 }),
                    advice,
                    speed_limit_mps: 30.0,
                });
                let obstacles: Vec<Obstacle> = leader_at(t + TICK_S)
                    .map(|(s, speed_mps)| Obstacle { pose: self.route.pose_of_front(s, CAR_LENGTH_M), speed_mps })
                    .into_iter()
                    .collect();
                let contact = !ego.tick(&controls, &Everywhere(Surface::Asphalt), &obstacles).is_empty();
                let state = *ego.state();
                let offset_m = self.route.project(state.position.truncate(), Some(s_m)).offset_m;
                Seen { controls, state, offset_m, gap_m: leader.map_or(f64::INFINITY, gap_m), contact }
            })
            .collect()
    }
}

fn calm<'a>(route: &'a Route, name: &str) -> Run<'a> {
    Run {
        route,
        params: preset(name).unwrap(),
        seed: 1,
        start_speed_mps: 0.0,
        advised: &|_| None,
        leader: None,
        seconds: 60.0,
    }
}

fn deviation(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (mean, (values.map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt())
}

#[test]
fn probe() {
    for r in [39.8, 102.0] {
        let route = ring(r);
        for v in [2.0, 3.0, 4.0, 6.0, 10.0, 15.0] {
            for name in ["perfect", "sloppy"] {
                let seen = Run { advised: &|_| Some(v), start_speed_mps: v, seconds: 80.0, ..calm(&route, name) }.go();
                let worst = seen.iter().map(|s| s.offset_m.abs()).fold(0.0, f64::max);
                let late = &seen[4000..];
                let (m, sd) = deviation(late.iter().map(|s| s.state.speed_mps));
                let om = deviation(late.iter().map(|s| s.offset_m));
                println!("{name} r {r} v {v}: worst {worst:.3} offset {om:?} speed {m:.3} sd {sd:.3} max dev {:.3}", late.iter().map(|s| (s.state.speed_mps - v).abs()).fold(0.0, f64::max));
            }
        }
    }
    let route = oval();
    let seen = Run { seconds: 300.0, ..calm(&route, "idm") }.go();
    println!("oval worst {:?} top {:?}", seen.iter().map(|s| s.offset_m.abs()).fold(0.0, f64::max), seen.iter().map(|s| s.state.speed_mps).fold(0.0, f64::max));
    println!("lat {:?}", seen.iter().map(|s| s.state.lateral_accel_mps2.abs()).fold(0.0, f64::max));
    // Step.
    let big = ring(2000.0);
    let seen = Run { advised: &|t| Some(if t < 20.0 { 4.0 } else { 6.0 }), params: DriverParams { error_mps: 0.0, ..preset("follow").unwrap() }, start_speed_mps: 4.0, seconds: 60.0, ..calm(&big, "follow") }.go();
    for i in (1900..3500).step_by(25) {
        let s = &seen[i];
        println!("step {:.2} v {:.3} a {:.2} th {:.3} br {:.3} gear {}", i as f64 * TICK_S, s.state.speed_mps, s.state.accel_mps2, s.controls.throttle, s.controls.brake, s.state.gear);
    }
    let seen = Run { advised: &|t| Some(if t < 20.0 { 6.0 } else if t < 40.0 { 3.0 } else if t < 60.0 { 1.0 } else { 0.0 }), start_speed_mps: 4.0, seconds: 80.0, ..calm(&big, "perfect") }.go();
    for i in (1900..8000).step_by(50) {
        let s = &seen[i];
        println!("down {:.2} v {:.3} a {:.2} th {:.3} br {:.3} gear {}", i as f64 * TICK_S, s.state.speed_mps, s.state.accel_mps2, s.controls.throttle, s.controls.brake, s.state.gear);
    }
    // Leader.
    for name in ["idm", "follow", "sloppy"] {
        for v in [4.0, 10.0, 20.0] {
            let leader = |t: f64| {
                let s0 = 10.0 + 5.0 + 2.0 + v * 1.1;
                let tb = (t - 10.0).clamp(0.0, v / 3.0);
                (s0 + v * t.min(10.0) + v * tb - 1.5 * tb * tb, v - 3.0 * tb)
            };
            let seen = Run { leader: Some(&leader), start_speed_mps: v, seconds: 60.0, ..calm(&big, name) }.go();
            println!("leader brakes {name} {v}: min gap {:.3} contact {} end gap {:.3} end v {:.4} max brake {:.2} min a {:.2}", seen.iter().map(|s| s.gap_m).fold(1e9, f64::min), seen.iter().any(|s| s.contact), seen.last().unwrap().gap_m, seen.last().unwrap().state.speed_mps, seen.iter().map(|s| s.controls.brake).fold(0.0, f32::max), seen.iter().map(|s| s.state.accel_mps2).fold(0.0, f64::min));
        }
    }
    for name in PRESETS {
        // Sawtooth 0..9 m/s, up 1 m/s2, down 1.5.
        let leader = |t: f64| {
            let period = 9.0 + 6.0 + 8.0;
            let (k, u) = ((t / period).floor(), t % period);
            let full = 9.0 * 9.0 / 2.0 + 9.0 * 6.0 / 2.0;
            let (x, v) = if u < 9.0 { (u * u / 2.0, u) } else if u < 15.0 { let w = u - 9.0; (40.5 + 9.0 * w - 0.75 * w * w, 9.0 - 1.5 * w) } else { (full, 0.0) };
            (20.0 + k * full + x, v)
        };
        let seen = Run { leader: Some(&leader), advised: &|_| Some(6.0), seconds: 240.0, ..calm(&big, name) }.go();
        let sw = seen.windows(2).filter(|w| (w[0].controls.brake > 0.0) != (w[1].controls.brake > 0.0)).count();
        println!("saw {name} min gap {:.3} contact {} both {} brake edges {} min a {:.2} max gap {:.1}", seen.iter().map(|s| s.gap_m).fold(1e9, f64::min), seen.iter().any(|s| s.contact), seen.iter().any(|s| s.controls.brake > 0.0 && s.controls.throttle > 0.0), sw, seen.iter().map(|s| s.state.accel_mps2).fold(0.0, f64::min), seen.iter().map(|s| s.gap_m).fold(0.0, f64::max));
        if name == "idm" { for i in (2300..4700).step_by(40) { let s = &seen[i]; println!("   {:.1} v {:.3} lead {:.2} gap {:.2} a {:.2} th {:.3} br {:.3} g {}", i as f64 * TICK_S, s.state.speed_mps, leader(i as f64 * TICK_S).1, s.gap_m, s.state.accel_mps2, s.controls.throttle, s.controls.brake, s.state.gear); } }
    }
    let _ = Pose::default();
}
