//! Requirements on simulated drivers in the ego. They keep their lane, reach and hold the advice, respond as late as a person would, and
//! keep behind their leader with few pedal changes. Figures in the comments are measured.

use codrive::{
    controls::Controls,
    driver::{DriverParams, PRESETS, Perception, SeenLeader, SimulatedDriver, preset},
    ego::{CarParams, EgoCar, EgoState, GroundSurface, Obstacle, UniformGround},
    idm::IdmParams,
    map::{Route, RouteLane},
    policy::{Action, Advice, Hold},
    space::{CAR_LENGTH_M, Pose},
    time::{TICK_S, Tick},
};
use glam::{DVec2, dvec2};
use std::f64::consts::{PI, TAU};

/// Returns the advice of a speed, m/s, for a step.
pub fn advice(issued: Tick, target_mps: f64) -> Advice {
    Advice {
        issued,
        hold: Hold::of_steps(1, 0.1),
        action: Action::Speed(target_mps),
        target_mps,
        range_mps: 0.5,
        is_fallback: false,
        driver: None,
        observed: None,
    }
}

/// Returns a closed route of one lane, as long as its shape.
fn closed(shape: Vec<DVec2>) -> Route {
    let length_m = shape.windows(2).map(|p| p[0].distance(p[1])).sum();
    Route::new(vec![RouteLane { lane: None, start_s_m: 0.0, length_m, speed_limit_mps: 30.0, width_m: 3.2, shape }])
}

/// Returns a ring of radius `r` with a point every 2.5 m, as in SUMO's networks.
fn ring(r: f64) -> Route {
    let n = (TAU * r / 2.5).ceil() as usize;
    closed((0..=n).map(|i| DVec2::from_angle(TAU * i as f64 / n as f64) * r).collect())
}

/// Returns two straights of 500 m and two bends of 50 m radius.
fn oval() -> Route {
    let bend = |centre: DVec2, from: f64| {
        (0..=63).map(move |i| centre + DVec2::from_angle(from + PI * f64::from(i) / 63.0) * 50.0)
    };
    let mut shape = vec![dvec2(0.0, -50.0)];
    shape.extend(bend(dvec2(500.0, 0.0), -PI / 2.0).chain(bend(DVec2::ZERO, PI / 2.0)));
    closed(shape)
}

/// Returns the route round a block with sides of 60 m, to the left or to the right. Its corners have a radius of 6 m, as netconvert makes
/// them for a turn between lanes of two streets.
fn block(to_right: bool) -> Route {
    let arc = |i: i32| DVec2::splat(24.0) + DVec2::from_angle(PI / 2.0 * f64::from(i) / 9.0) * 6.0;
    let corner = |k: i32| (0..=9).map(move |i| arc(i).rotate(DVec2::from_angle(PI / 2.0 * f64::from(k))));
    let mut shape: Vec<DVec2> = (0..4).flat_map(corner).collect();
    shape.push(shape[0]);
    if to_right {
        shape.iter_mut().for_each(|point| point.x = -point.x);
    }
    closed(shape)
}

/// Returns a straight road of two consecutive lanes with these limits, m/s.
fn limits_change(first_mps: f64, then_mps: f64) -> Route {
    let lane = |speed_limit_mps: f64, from: f64, to: f64| RouteLane {
        lane: None,
        start_s_m: 0.0,
        length_m: to - from,
        speed_limit_mps,
        width_m: 3.2,
        shape: vec![dvec2(from, 0.0), dvec2(to, 0.0)],
    };
    Route::open(vec![lane(first_mps, 0.0, 600.0), lane(then_mps, 600.0, 1500.0)])
}

/// Vehicle ahead: front bumper along the route and speed at a time in seconds.
type LeaderAt<'a> = &'a dyn Fn(f64) -> (f64, f64);

struct OfflineDrive<'a> {
    route: &'a Route,
    params: DriverParams,
    seed: u64,
    start_speed_mps: f64,
    /// Advised speed at a time in seconds.
    advised: &'a dyn Fn(f64) -> Option<f64>,
    leader: Option<LeaderAt<'a>>,
    /// Speed limit, m/s; `None` takes the route's.
    limit_mps: Option<f64>,
    seconds: f64,
}

/// Observations of one tick.
struct Seen {
    controls: Controls,
    state: EgoState,
    /// Offset of the ego's centre from the lane's centre line, metres.
    offset_m: f64,
    gap_m: f64,
    contact: bool,
}

impl OfflineDrive<'_> {
    fn go(&self) -> Vec<Seen> {
        let car = CarParams::default();
        let start_s = 10.0;
        let start = self.route.pose_of_front(start_s, CAR_LENGTH_M);
        let cars = usize::from(self.leader.is_some());
        let mut ego = EgoCar::new(&car, start, self.start_speed_mps, cars).unwrap();
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
                let advice = (self.advised)(t).map(|target_mps| advice(Tick(i), target_mps));
                let controls = driver.controls(&Perception {
                    speed_mps: state.speed_mps,
                    lane: driver.look(self.route, &state, Some(s_m)),
                    leader: leader.map(|l| SeenLeader { gap_m: gap_m(l), speed_mps: l.1 }),
                    stop_ahead_m: None,
                    advice,
                    speed_limit_mps: self.limit_mps.unwrap_or_else(|| self.route.speed_limit_mps(s_m)),
                    ..Perception::default()
                });
                let obstacles: Vec<Obstacle> = leader_at(t + TICK_S)
                    .map(|(s, speed_mps)| Obstacle {
                        pose: self.route.pose_of_front(s, CAR_LENGTH_M),
                        speed_mps,
                        ..Obstacle::default()
                    })
                    .into_iter()
                    .collect();
                let contact = !ego.tick(&controls, &UniformGround(GroundSurface::Asphalt), &obstacles).is_empty();
                let state = *ego.state();
                let offset_m = self.route.project(state.position.truncate(), Some(s_m)).offset_m;
                Seen { controls, state, offset_m, gap_m: leader.map_or(f64::INFINITY, gap_m), contact }
            })
            .collect()
    }
}

fn calm<'a>(route: &'a Route, name: &str) -> OfflineDrive<'a> {
    OfflineDrive {
        route,
        params: preset(name).unwrap(),
        seed: 1,
        start_speed_mps: 0.0,
        advised: &|_| None,
        leader: None,
        limit_mps: Some(60.0),
        seconds: 60.0,
    }
}

#[test]
fn a_driver_brakes_before_a_lower_limit_and_speeds_up_at_a_higher_one() {
    for (first_mps, then_mps) in [(25.0, 8.33), (8.33, 25.0)] {
        let route = limits_change(first_mps, then_mps);
        let drive = OfflineDrive { start_speed_mps: first_mps, limit_mps: None, seconds: 130.0, ..calm(&route, "idm") };
        let seen = drive.go();
        let speed_at = |m: f64| {
            let there = seen.iter().find(|seen| seen.state.position.x >= m).expect("it comes there");
            there.state.speed_mps
        };
        // Police tolerate 3 km/h above the limit; smaller excesses are not fined.
        let over_mps = speed_at(600.0 - CAR_LENGTH_M / 2.0) - first_mps.min(then_mps);
        assert!(over_mps < 3.0 / 3.6, "{first_mps} {then_mps}: {over_mps}");
        // No driver slows down half a kilometre before the sign.
        assert!(speed_at(300.0) > 0.8 * first_mps, "{}", speed_at(300.0));
        assert!(speed_at(1100.0) > 0.75 * then_mps, "{}", speed_at(1100.0));
    }
}

fn deviation(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (mean, (values.map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt())
}

/// Returns the largest offset from the lane's centre line, metres.
fn farthest(seen: &[Seen]) -> f64 {
    seen.iter().map(|s| s.offset_m.abs()).fold(0.0, f64::max)
}

/// Returns the smallest gap to the leader, metres.
fn smallest_gap(seen: &[Seen]) -> f64 {
    seen.iter().map(|s| s.gap_m).fold(f64::INFINITY, f64::min)
}

/// Returns the times at which the brake was applied or released, s.
fn brake_edges(seen: &[Seen]) -> Vec<f64> {
    let on = |i: usize| seen[i].controls.brake > 0.0;
    (1..seen.len()).filter(|&i| on(i) != on(i - 1)).map(|i| i as f64 * TICK_S).collect()
}

/// Returns a leader that drives at `v` m/s for 10 s and then brakes at 3 m/s2 to a standstill, from an equilibrium gap.
fn braking_leader(v: f64) -> impl Fn(f64) -> (f64, f64) {
    move |t: f64| {
        let braked_s = (t - 10.0).clamp(0.0, v / 3.0);
        let start_m = 10.0 + CAR_LENGTH_M + 2.0 + 1.1 * v;
        (start_m + v * t.min(10.0) + v * braked_s - 1.5 * braked_s * braked_s, v - 3.0 * braked_s)
    }
}

/// Returns a leader that accelerates at 1 m/s2 to 9 m/s, brakes at 1.5 m/s2, stands for 8 s, and repeats this.
fn sawtooth_leader(t: f64) -> (f64, f64) {
    let (round, u) = ((t / 23.0).floor(), t % 23.0);
    let (way_m, v) = if u < 9.0 {
        (u * u / 2.0, u)
    } else {
        let w = (u - 9.0).min(6.0);
        (40.5 + 9.0 * w - 0.75 * w * w, 9.0 - 1.5 * w)
    };
    (20.0 + 67.5 * round + way_m, v)
}

#[test]
fn drivers_stay_within_30_cm_of_the_rings_centre_line() {
    // The preset `perfect` has 0.08 m from 2 to 6 m/s and 0.18 m at 10 m/s (while it finds the line; 0.02 m later); `follow` has 0.24 m.
    let route = ring(39.8);
    for speed in [2.0, 4.0, 7.0, 10.0] {
        for name in ["perfect", "follow", "idm"] {
            let run = OfflineDrive { advised: &|_| Some(speed), start_speed_mps: speed, ..calm(&route, name) };
            let offset_m = farthest(&run.go());
            assert!(offset_m < 0.3, "{name} at {speed} m/s: {offset_m} m");
        }
    }
}

#[test]
fn a_driver_keeps_to_the_line_of_a_motorway_at_its_speeds() {
    // 130 km/h are 36 m/s; 45 m/s occur where there is no limit. A car of 1.8 m in a lane of 3.2 m has 0.7 m on either side, of which the
    // driver may use half.
    let route = ring(5000.0);
    for speed in [27.0, 36.0, 45.0] {
        for name in ["perfect", "follow", "idm"] {
            let params = preset(name).unwrap();
            let params = DriverParams { idm: IdmParams { v0: speed, ..params.idm }, ..params };
            let run = OfflineDrive {
                params,
                advised: &|_| Some(speed),
                start_speed_mps: speed,
                seconds: 120.0,
                ..calm(&route, name)
            };
            let seen = run.go();
            assert!((seen[11_999].state.speed_mps - speed).abs() < 2.0, "{name}: {} m/s", seen[11_999].state.speed_mps);
            let offset_m = farthest(&seen);
            assert!(offset_m < 0.35, "{name} at {speed} m/s: {offset_m} m");
        }
    }
}

#[test]
fn a_driver_turns_round_street_corners_within_the_lane() {
    // The centre of the car stays over its lane of 3.2 m: 1.6 m to either side.
    for to_right in [false, true] {
        let route = block(to_right);
        for name in ["perfect", "follow", "idm"] {
            let seen = calm(&route, name).go();
            let offset_m = farthest(&seen);
            assert!(offset_m < 1.6, "{name}, to the right: {to_right}: {offset_m} m");
            let driven_m: f64 = seen.iter().map(|s| s.state.speed_mps * TICK_S).sum();
            assert!(driven_m > 200.0, "{name}: once round in a minute, not {driven_m} m");
        }
    }
}

/// Returns 60 m straight, an arc to the right with this radius and angle, and 60 m straight.
fn right_turn(radius_m: f64, turn_deg: f64) -> Route {
    let part = |i: i32| DVec2::from_angle(-turn_deg.to_radians() * f64::from(i) / 6.0);
    let arc = (0..=6).map(|i| dvec2(60.0, -radius_m) + part(i).rotate(DVec2::Y) * radius_m);
    let mut shape = vec![DVec2::ZERO];
    shape.extend(arc);
    shape.push(shape[shape.len() - 1] + part(6) * 60.0);
    Route::open(vec![closed(shape).lanes()[0].clone()])
}

#[test]
fn a_driver_who_turns_right_does_not_swing_out_into_the_lane_beside() {
    // The turn leads from the outer lane of a street to that of another, with lanes of 3.2 m and kerbs of 1.5 m. The arc of netconvert has
    // 3.1 m, less than the car's 4.7 m. A car of 1.8 m touches the line 0.7 m off the centre. At 1.1 m its wheels reach the end of the 0.4
    // m shoulder.
    for (radius_m, turn_deg) in [(3.1, 90.0), (4.0, 90.0), (6.0, 90.0), (4.0, 70.0)] {
        let route = right_turn(radius_m, turn_deg);
        for name in ["perfect", "follow", "idm"] {
            let run = OfflineDrive { start_speed_mps: 8.0, seconds: 20.0, ..calm(&route, name) };
            let seen = run.go();
            let out_m = seen.iter().map(|seen| seen.offset_m).fold(0.0, f64::max);
            let in_m = seen.iter().map(|seen| -seen.offset_m).fold(0.0, f64::max);
            assert!(
                out_m < 1.0 && in_m < 1.6,
                "{name}, {turn_deg} degrees on {radius_m} m: {out_m} m out, {in_m} m in"
            );
        }
    }
}

#[test]
fn a_driver_slows_down_for_a_corner_between_two_long_straights() {
    // The street of 5 m has a corner of 93 degrees, as in OpenStreetMap data: 2.5 m to either side, and the shoulder of 0.4 m.
    let shape = vec![DVec2::ZERO, dvec2(60.0, 0.0), dvec2(60.0, 0.0) + DVec2::from_angle(-1.62) * 60.0];
    let route = Route::open(vec![closed(shape).lanes()[0].clone()]);
    for name in ["perfect", "follow", "idm"] {
        let seen = OfflineDrive { start_speed_mps: 8.9, seconds: 25.0, ..calm(&route, name) }.go();
        assert!(seen[2_499].state.position.y < -20.0, "{name}: it came round");
        let offset_m = farthest(&seen);
        assert!(offset_m < 2.9, "{name}: {offset_m} m");
    }
}

/// Returns 200 m straight, then left and right by the same angle on arcs of this radius, and straight on.
fn s_bend(radius_m: f64, turn_deg: f64) -> Route {
    let part = |i: i32| DVec2::from_angle(turn_deg.to_radians() * f64::from(i) / 6.0);
    let first = (0..=6).map(|i| dvec2(0.0, radius_m) + part(i).rotate(DVec2::NEG_Y) * radius_m);
    let centre = dvec2(0.0, radius_m) + part(6).rotate(DVec2::NEG_Y) * 2.0 * radius_m;
    let second = (1..=6).map(|i| centre + part(6 - i).rotate(DVec2::Y) * radius_m);
    let mut shape = vec![dvec2(-200.0, 0.0)];
    shape.extend(first.chain(second));
    shape.push(shape[shape.len() - 1] + dvec2(300.0, 0.0));
    let lane = closed(shape).lanes()[0].clone();
    Route::open(vec![lane])
}

#[test]
fn a_driver_slows_down_for_an_s_bend_that_ends_in_its_old_direction() {
    for (radius_m, turn_deg) in [(4.0, 75.0), (6.0, 90.0), (15.0, 45.0)] {
        let route = s_bend(radius_m, turn_deg);
        for name in ["perfect", "follow", "idm"] {
            let run = OfflineDrive { start_speed_mps: 14.0, seconds: 45.0, ..calm(&route, name) };
            let seen = run.go();
            let text = format!("{name}, {turn_deg} degrees on {radius_m} m");
            assert!(seen[4_499].state.position.x > 40.0, "{text}: it came through");
            let offset_m = farthest(&seen);
            assert!(offset_m < 1.6, "{text}: {offset_m} m");
        }
    }
}

#[test]
fn the_drawn_shape_counts_on_a_road_declared_twice_as_long() {
    // The route is a road of 60 m, a right angle with a radius of 6 m, and a road of 60 m.
    let arc = (0..=9).map(|i| dvec2(60.0, 6.0) + DVec2::from_angle(PI / 2.0 * f64::from(i) / 9.0 - PI / 2.0) * 6.0);
    let mut shape = vec![DVec2::ZERO];
    shape.extend(arc);
    shape.push(dvec2(66.0, 66.0));
    let lane = closed(shape).lanes()[0].clone();
    for share in [1.0, 2.0, 0.5] {
        let route = Route::open(vec![RouteLane { length_m: lane.length_m * share, ..lane.clone() }]);
        let run = OfflineDrive { start_speed_mps: 8.0, seconds: 14.0, ..calm(&route, "perfect") };
        let seen = run.go();
        assert!(seen[1_399].state.position.y > 20.0, "declared {share} times as long: it came round");
        let offset_m = farthest(&seen);
        assert!(offset_m < 1.0, "declared {share} times as long: {offset_m} m");
    }
}

#[test]
fn a_perfect_driver_holds_the_advised_speed() {
    // Measured: an error of 0.000 m/s after 40 s.
    let route = ring(39.8);
    for speed in [1.0, 2.0, 4.0, 4.43, 8.0] {
        let seen = OfflineDrive { advised: &|_| Some(speed), ..calm(&route, "perfect") }.go();
        for s in &seen[3000..] {
            assert!((s.state.speed_mps - speed).abs() < 0.1, "{} instead of {speed} m/s", s.state.speed_mps);
        }
    }
}

#[test]
fn a_follower_wanders_about_the_advised_speed_by_its_error() {
    // With an error of 0.3 m/s: measured 4.01 +- 0.30 m/s.
    let route = ring(102.0);
    let seen =
        OfflineDrive { advised: &|_| Some(4.0), start_speed_mps: 4.0, seconds: 600.0, ..calm(&route, "follow") }.go();
    let (mean, sd) = deviation(seen.iter().map(|s| s.state.speed_mps));
    assert!((mean - 4.0).abs() < 0.12 && (0.2..0.36).contains(&sd), "{mean} +- {sd}");
}

#[test]
fn a_changed_advice_moves_the_pedals_only_after_the_reaction_time() {
    let route = ring(2000.0);
    let params = DriverParams { error_mps: 0.0, ..preset("follow").unwrap() };
    let reaction = (params.reaction_s / TICK_S) as usize;
    for (before, after) in [(4.0, 6.0), (6.0, 4.0)] {
        let run = |change: bool| {
            let advised = |t: f64| Some(if change && t >= 20.0 - 1e-9 { after } else { before });
            let params = params.clone();
            OfflineDrive { params, advised: &advised, start_speed_mps: before, seconds: 40.0, ..calm(&route, "follow") }
                .go()
        };
        let (changed, same) = (run(true), run(false));
        let differs = (0..changed.len()).find(|&i| changed[i].controls != same[i].controls).unwrap();
        assert_eq!(differs, 2000 + reaction, "{before} to {after} m/s");
        // 80 % of the step is done 2 s after the response, all of it within 10 s, with an overshoot of 0.6 %.
        let reached = |i: usize| (changed[i].state.speed_mps - before) / (after - before);
        assert!(
            reached(differs + 200) > 0.5 && (reached(differs + 1000) - 1.0).abs() < 0.05,
            "{}",
            reached(differs + 200)
        );
        let most = (differs..changed.len()).map(reached).fold(0.0, f64::max);
        assert!(most < 1.06, "overshoot {most}");
    }
}

#[test]
fn drivers_of_each_kind_stop_behind_a_braking_leader() {
    // Measured gaps: 1.62 m (`sloppy` at 4 m/s) to 1.80 m, where the model stops at 2 m.
    let route = ring(2000.0);
    for name in PRESETS {
        for speed in [4.0, 10.0, 20.0] {
            let leader = braking_leader(speed);
            let seen = OfflineDrive { leader: Some(&leader), start_speed_mps: speed, ..calm(&route, name) }.go();
            assert!(!seen.iter().any(|s| s.contact), "{name} at {speed} m/s");
            assert!(smallest_gap(&seen) > 1.0, "{name} at {speed} m/s: {} m", smallest_gap(&seen));
            let end = seen.last().unwrap();
            assert!(end.gap_m < 3.0 && end.state.speed_mps.abs() < 0.01 && end.state.braking, "{name}: {}", end.gap_m);
        }
    }
}

#[test]
fn stop_and_go_is_driven_with_few_pedal_changes_and_no_contact() {
    let route = ring(2000.0);
    for name in PRESETS {
        let run = OfflineDrive { advised: &|_| Some(6.0), seconds: 230.0, ..calm(&route, name) };
        let seen = OfflineDrive { leader: Some(&sawtooth_leader), ..run }.go();
        assert!(!seen.iter().any(|s| s.contact) && smallest_gap(&seen) > 1.0, "{name}: {} m", smallest_gap(&seen));
        assert!(!seen.iter().any(|s| s.controls.throttle > 0.0 && s.controls.brake > 0.0), "{name}: both pedals");
        // Ten rounds, each with one application and one release of the brake: 19 to 21 changes.
        let edges = brake_edges(&seen);
        assert!(edges.len() <= 24, "{name}: {} changes to or from the brake", edges.len());
        assert!(edges.windows(2).all(|w| w[1] - w[0] > 0.3), "{name}: the foot dances: {edges:?}");
        // The ego stands while the leader stands.
        let standing = seen.iter().filter(|s| s.state.speed_mps.abs() < 0.02).count() as f64 * TICK_S;
        assert!(standing > 40.0, "{name}: stood for {standing} s");
    }
}

#[test]
fn without_advice_the_model_drives_and_slows_for_bends() {
    let route = oval();
    let seen = OfflineDrive { seconds: 200.0, ..calm(&route, "idm") }.go();
    let top = seen.iter().map(|s| s.state.speed_mps).fold(0.0, f64::max);
    let sideways = seen.iter().map(|s| s.state.lateral_accel_mps2.abs()).fold(0.0, f64::max);
    // On 500 m of straight the ego reaches 24.4 m/s from the bend's 12.2 m/s, at the model's 1 m/s2. Measured: 3.9 m/s2 where the bend of
    // this oval begins without a transition, 0.37 m inside its line.
    assert!(top > 20.0, "{top}");
    assert!(sideways < 4.5 && farthest(&seen) < 0.5, "{sideways} {}", farthest(&seen));
}

#[test]
fn a_driver_handles_a_car_without_creep() {
    let mut car = CarParams::default();
    car.gearbox.creep = false;
    let mut ego = EgoCar::new(&car, Pose::default(), 0.0, 0).unwrap();
    let mut driver = SimulatedDriver::new(&preset("perfect").unwrap(), &car, 1).unwrap();
    for target in [2.0, 0.0, 4.0] {
        for _ in 0..2000 {
            let speed_mps = ego.state().speed_mps;
            let advice = Some(advice(Tick(0), target));
            let now = Perception { speed_mps, advice, speed_limit_mps: 30.0, ..Perception::default() };
            ego.tick(&driver.controls(&now), &UniformGround(GroundSurface::Asphalt), &[]);
        }
        assert!((ego.state().speed_mps - target).abs() < 0.1, "{} instead of {target}", ego.state().speed_mps);
    }
}

#[test]
fn advice_as_fast_as_the_limit_is_no_advice() {
    let pedals = |advised_mps: Option<f64>| -> Vec<Controls> {
        let mut driver = SimulatedDriver::new(&DriverParams::default(), &CarParams::default(), 1).unwrap();
        let advice = advised_mps.map(|target_mps| advice(Tick(0), target_mps));
        let at = |speed_mps| Perception { speed_mps, advice, speed_limit_mps: 30.0, ..Perception::default() };
        (0..3200).map(|k| driver.pedals(&at(0.01 * f64::from(k)))).collect()
    };
    assert!(pedals(Some(30.0)) == pedals(None), "the limit");
    assert!(pedals(Some(40.0)) == pedals(None), "above it");
    assert!(pedals(Some(15.0)) != pedals(None), "below it");
}

#[test]
fn the_same_seed_drives_alike_and_another_seed_does_not() {
    let route = ring(39.8);
    let run = |seed| {
        let seen = OfflineDrive { seed, advised: &|_| Some(4.0), seconds: 20.0, ..calm(&route, "sloppy") }.go();
        seen.iter().map(|s| format!("{:?}", s.controls)).collect::<Vec<_>>()
    };
    assert!(run(1) == run(1), "same seed, same pedals");
    assert!(run(1) != run(2), "another seed, another drive");
}
