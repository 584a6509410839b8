//! Requirements on the ego as a whole: it accelerates, brakes, corners and stands like a mid-size saloon, stays outside other vehicles, and
//! repeats a drive exactly. Figures in the comments are measured.

use codrive::{
    controls::{Controls, STEERING_RATIO, Selector},
    ego::{CarParams, Contact, EgoCar, EgoState, GroundSurface, Obstacle, UniformGround},
    rng,
    space::{CAR_LENGTH_M, Pose},
    time::TICK_S,
};
use glam::{DVec2, EulerRot, dvec2};

pub const ROAD: UniformGround = UniformGround(GroundSurface::Asphalt);
const MEADOW: UniformGround = UniformGround(GroundSurface::Grass);

fn car(speed_mps: f64) -> EgoCar {
    EgoCar::new(&CarParams::default(), Pose::default(), speed_mps, 0).unwrap()
}

fn throttle(throttle: f32) -> Controls {
    Controls { throttle, ..Controls::default() }
}

pub fn brake(brake: f32) -> Controls {
    Controls { brake, ..Controls::default() }
}

fn gear(selector: Selector) -> Controls {
    Controls { selector, ..Controls::default() }
}

/// Runs `seconds` on asphalt and returns every state.
fn drive(ego: &mut EgoCar, controls: Controls, seconds: f64) -> Vec<EgoState> {
    drive_on(ego, controls, seconds, &ROAD)
}

fn drive_on(ego: &mut EgoCar, controls: Controls, seconds: f64, ground: &UniformGround) -> Vec<EgoState> {
    let ticks = (seconds / TICK_S).round() as usize;
    let tick = |_| {
        ego.tick(&controls, ground, &[]);
        *ego.state()
    };
    (0..ticks).map(tick).collect()
}

/// Returns the largest jerk, m/s3: the change of the mean acceleration from one tenth of a second to the next.
fn jerk(states: &[EgoState]) -> f64 {
    let mean = |w: &[EgoState]| w.iter().map(|s| s.accel_mps2).sum::<f64>() / w.len() as f64;
    let tenths: Vec<f64> = states.windows(10).map(mean).collect();
    tenths.windows(11).map(|w| (w[10] - w[0]).abs() / 0.1).fold(0.0, f64::max)
}

fn tilt(state: &EgoState) -> (f32, f32) {
    let (_, pitch, roll) = state.rotation.to_euler(EulerRot::ZYX);
    (pitch, roll)
}

/// Drives with a constant steering angle at `speed_mps` until the circle is steady; returns its radius, metres, and the last state.
fn circle(speed_mps: f64, road_wheel_rad: f64) -> (f64, EgoState) {
    let mut ego = car(speed_mps);
    let mut integral = 0.0;
    for _ in 0..2000 {
        let error = speed_mps - ego.state().speed_mps;
        integral += error * TICK_S;
        let controls = Controls {
            steering_wheel_rad: road_wheel_rad as f32 * STEERING_RATIO,
            ..throttle((0.25 + 0.3 * error + 0.1 * integral) as f32)
        };
        ego.tick(&controls, &ROAD, &[]);
    }
    let state = *ego.state();
    (f64::from(state.velocity.length()) / state.yaw_rate, state)
}

#[test]
fn the_car_settles_on_its_springs_and_stays() {
    let states = drive(&mut car(0.0), gear(Selector::Neutral), 10.0);
    let highest = states.iter().map(|s| s.position.z.abs()).fold(0.0, f64::max);
    assert!(highest < 1e-4, "{highest} m off the road");
    for s in &states {
        let (pitch, roll) = tilt(s);
        assert!(pitch.abs() < 1e-4 && roll.abs() < 1e-4, "{pitch} {roll}");
        for wheel in s.wheels {
            assert!((wheel.hub.z - 0.32).abs() < 1e-4 && wheel.compression_m > 0.1, "{wheel:?}");
        }
    }
}

#[test]
fn the_car_stands_for_a_minute_on_the_brake_within_a_millimetre() {
    // Measured: 0.59 mm, all in the first half second, when the creep torque loads the standing tyres; then nothing.
    for controls in [brake(1.0), brake(0.3), gear(Selector::Neutral)] {
        let states = drive(&mut car(0.0), controls, 60.0);
        let farthest = states.iter().map(|s| s.position.length()).fold(0.0, f64::max);
        assert!(farthest < 0.001, "{controls:?}: {farthest} m");
        let (a, b) = (states[1000], states[5999]);
        assert!((a.position - b.position).length() < 1e-6, "{} {}", a.position, b.position);
        assert!(states[1000..].iter().all(|s| s.velocity.length() < 1e-4));
    }
}

#[test]
fn the_car_stands_still_after_a_drive_as_well() {
    // Stops with steering leave tyres and springs loaded sideways.
    let mut ego = car(8.0);
    let turning = Controls { steering_wheel_rad: 2.0, ..throttle(0.2) };
    drive(&mut ego, turning, 2.0);
    drive(&mut ego, Controls { steering_wheel_rad: 2.0, ..brake(0.4) }, 8.0);
    let states = drive(&mut ego, Controls { steering_wheel_rad: 2.0, ..brake(0.4) }, 60.0);
    let farthest = states.iter().map(|s| (s.position - states[0].position).length()).fold(0.0, f64::max);
    assert!(farthest < 0.001, "{farthest} m");
}

#[test]
fn the_car_reaches_100_kmh_in_8_to_12_s_and_a_plausible_top_speed() {
    // Measured: 9.1 s and 214 km/h.
    let states = drive(&mut car(0.0), throttle(1.0), 90.0);
    let time_s = states.iter().position(|s| s.speed_mps > 100.0 / 3.6).unwrap() as f64 * TICK_S;
    assert!((8.0..12.0).contains(&time_s), "0-100 km/h in {time_s} s");
    let top_kmh = states.last().unwrap().speed_mps * 3.6;
    assert!((180.0..230.0).contains(&top_kmh), "{top_kmh} km/h");
}

#[test]
fn full_braking_from_50_kmh_takes_10_to_14_m_and_is_straight() {
    // Measured: 10.9 m, and 0.00 m to the side.
    let mut ego = car(50.0 / 3.6);
    let states = drive(&mut ego, brake(1.0), 4.0);
    let end = states.last().unwrap();
    assert!((10.0..14.0).contains(&end.position.x), "{} m", end.position.x);
    assert!(
        end.position.y.abs() < 0.01 && end.pose().yaw_rad.abs() < 0.001,
        "{} {}",
        end.position.y,
        end.pose().yaw_rad
    );
    assert!(states.iter().all(|s| s.braking));
}

#[test]
fn the_anti_lock_brake_leaves_grip_to_steer() {
    let mut ego = car(25.0);
    let states = drive(&mut ego, Controls { steering_wheel_rad: 0.8, ..brake(1.0) }, 4.0);
    let end = states.last().unwrap();
    assert!(end.position.y > 2.0 && end.position.x < 45.0, "{}", end.position);
}

#[test]
fn the_rings_circle_needs_the_bicycle_models_steering() {
    // delta = L / r + (1/c_f - 1/c_r) a_y / g, with c: cornering stiffness per load. On r = 39.8 m at 10 m/s: 4.03 degrees from geometry
    // and 0.20 from understeer.
    let p = CarParams::default();
    let gradient = 1.0 / p.tyres.front_cornering - 1.0 / p.tyres.rear_cornering;
    for (radius_m, speed_mps) in [(39.8, 3.0), (39.8, 10.0), (102.0, 10.0)] {
        let (mut low, mut high) = (0.01, 0.2);
        for _ in 0..14 {
            let middle = (low + high) / 2.0;
            if circle(speed_mps, middle).0 > radius_m { low = middle } else { high = middle }
        }
        let geometry = p.body.wheelbase_m / radius_m;
        let bicycle = geometry + gradient * speed_mps * speed_mps / radius_m / 9.81;
        // Measured: 0.998 to 1.007 of the model with understeer; 1.056 of the geometry alone at 10 m/s on 39.8 m.
        assert!((low / bicycle - 1.0).abs() < 0.03, "r {radius_m} v {speed_mps}: {} of the model", low / bicycle);
        assert!((low / geometry - 1.0).abs() < 0.1, "r {radius_m} v {speed_mps}: {} of L/r", low / geometry);
    }
}

#[test]
fn the_steering_wheel_pulls_back_and_lets_go_when_the_tyres_slide() {
    let torque = |steer: f64| f64::from(circle(12.0, steer).1.steering_torque_nm);
    let (small, medium) = (torque(0.02), torque(0.04));
    assert!(small < -0.2 && medium < 1.5 * small, "{small} {medium}");
    assert!((torque(-0.02) + small).abs() < 0.02, "left and right differ");
    // Far beyond the grip limit there is no pneumatic trail.
    let sliding = torque(0.35);
    assert!(sliding.abs() < torque(0.09).abs(), "{sliding}");
    let standing = drive(&mut car(0.0), Controls { steering_wheel_rad: 3.0, ..brake(1.0) }, 2.0);
    assert!(standing.last().unwrap().steering_torque_nm.abs() < 0.05);
}

#[test]
fn the_body_rolls_outwards_dives_and_squats_a_little() {
    let (_, state) = circle(10.0, 0.073);
    let (_, roll) = tilt(&state);
    // In a left turn the right side goes down: a positive rotation about x. The lateral acceleration is 0.25 g.
    assert!((0.008..0.03).contains(&roll), "roll {roll}");
    let dive = drive(&mut car(25.0), brake(0.5), 2.0);
    let (pitch, _) = tilt(dive.last().unwrap());
    assert!((0.005..0.04).contains(&pitch), "dive {pitch}");
    let squat = drive(&mut car(0.0), throttle(0.6), 2.0);
    let (pitch, _) = tilt(squat.last().unwrap());
    assert!((-0.04..-0.002).contains(&pitch), "squat {pitch}");
}

#[test]
fn the_pitch_after_a_stop_dies_within_a_second() {
    let mut ego = car(5.0);
    let states = drive(&mut ego, brake(0.3), 5.0);
    let stop = states.iter().position(|s| s.speed_mps < 0.01).unwrap();
    let rest = tilt(states.last().unwrap()).0;
    let swing = |from: usize| states[from..].iter().map(|s| (tilt(s).0 - rest).abs()).fold(0.0, f32::max);
    assert!(swing(stop) > 0.003, "{}", swing(stop));
    assert!(swing(stop + 100) < 0.1 * swing(stop), "{} of {}", swing(stop + 100), swing(stop));
}

#[test]
fn without_a_pedal_the_car_creeps_unless_creep_is_off() {
    // Measured: 1.71 m/s, 6.1 km/h.
    let states = drive(&mut car(0.0), throttle(0.0), 20.0);
    let creep = states.last().unwrap().speed_mps;
    assert!((1.5..2.0).contains(&creep), "{creep}");
    assert!(states.windows(2).all(|w| w[1].speed_mps > w[0].speed_mps - 0.002), "creeping is smooth");
    let mut params = CarParams::default();
    params.gearbox.creep = false;
    let mut ego = EgoCar::new(&params, Pose::default(), 0.0, 0).unwrap();
    let moved = drive(&mut ego, throttle(0.0), 20.0).last().unwrap().position.length();
    assert!(moved < 0.001, "{moved}");
    // The car still drives.
    assert!(drive(&mut ego, throttle(0.15), 5.0).last().unwrap().speed_mps > 1.5);
    drive(&mut ego, throttle(0.0), 60.0);
    assert!(ego.state().speed_mps.abs() < 0.01, "{}", ego.state().speed_mps);
}

#[test]
fn walking_pace_is_smooth() {
    // Measured, m/s3: creep 3.9; gentle stop at 1.2 m/s2 4.4 (the last jolt of any car that stops on a constant pedal); pulling away 3.3.
    let mut ego = car(0.0);
    drive(&mut ego, brake(0.3), 3.0);
    let creep = drive(&mut ego, throttle(0.0), 10.0);
    assert!(jerk(&creep) < 5.0, "creep {}", jerk(&creep));
    let stop = drive(&mut car(5.0), brake(0.177), 10.0);
    assert!(jerk(&stop[20..]) < 5.0, "gentle stop {}", jerk(&stop[20..]));
    assert!(stop.iter().all(|s| s.speed_mps > -0.01), "hardly any rocking back");
    let away = drive(&mut car(0.0), throttle(0.2), 10.0);
    assert!(jerk(&away) < 4.5, "pulling away {}", jerk(&away));
}

#[test]
fn gear_changes_are_mild_and_never_taken_back() {
    for tenth in 1..=10 {
        let states = drive(&mut car(0.0), throttle(tenth as f32 / 10.0), 60.0);
        let gears: Vec<i8> = states.iter().map(|s| s.gear).collect();
        assert!(gears.windows(2).all(|w| w[1] == w[0] || w[1] == w[0] + 1), "throttle {tenth}: {gears:?}");
        // The first second is left out, because the pedal step itself causes jerk. Measured: 0.4 at 0.1, 1.5 at 0.3, 6.5 at 1.0.
        let (jerk, limit) = (jerk(&states[100..]), if tenth <= 3 { 2.0 } else { 8.0 });
        assert!(jerk < limit, "throttle {tenth}: {jerk} m/s3");
    }
    // Coasting to a stop shifts down one by one, just as mildly: 1.5 m/s3.
    let states = &drive(&mut car(25.0), throttle(0.0), 120.0)[200..];
    assert!(states.windows(2).all(|w| w[1].gear == w[0].gear || w[1].gear == w[0].gear - 1));
    assert!(states.last().unwrap().gear == 1 && jerk(states) < 3.0, "{}", jerk(states));
}

#[test]
fn coasting_slows_the_car_plausibly() {
    // Deceleration by drag, rolling resistance and the engine: 0.34 m/s2 at 25 m/s, 0.30 at 10 m/s.
    let decel = |speed: f64| -drive(&mut car(speed), throttle(0.0), 3.0).last().unwrap().accel_mps2;
    assert!((0.25..0.6).contains(&decel(25.0)), "{}", decel(25.0));
    assert!((0.1..0.5).contains(&decel(10.0)), "{}", decel(10.0));
}

#[test]
fn an_on_off_pedal_holds_4_mps() {
    // The target of the pedal is on or off, as with a key: 0.25 below 4 m/s, 0 above. The speed stays within 0.5 m/s.
    let mut ego = car(4.0);
    let mut pedal = 0.0f32;
    for i in 0..6000 {
        let wanted = if ego.state().speed_mps < 4.0 { 0.25 } else { 0.0 };
        pedal += (wanted - pedal).clamp(-0.01, 0.01);
        ego.tick(&throttle(pedal), &ROAD, &[]);
        let speed = ego.state().speed_mps;
        assert!((speed - 4.0).abs() < 0.5, "{speed} m/s after {} s", f64::from(i) * TICK_S);
    }
}

#[test]
fn grass_is_slow_and_slippery() {
    // Measured: 28.2 km/h at full throttle.
    let states = drive_on(&mut car(0.0), throttle(1.0), 60.0, &MEADOW);
    let top_kmh = states.last().unwrap().speed_mps * 3.6;
    assert!((22.0..32.0).contains(&top_kmh), "{top_kmh}");
    let way_m = drive_on(&mut car(50.0 / 3.6), brake(1.0), 6.0, &MEADOW).last().unwrap().position.x;
    assert!(way_m > 15.0, "{way_m}");
    let coast = drive_on(&mut car(20.0), throttle(0.0), 2.0, &MEADOW).last().unwrap().speed_mps;
    assert!(coast < 17.0, "{coast}");
    assert!(states.iter().all(|s| s.wheels.iter().all(|w| w.surface == GroundSurface::Grass)));
}

#[test]
fn reverse_goes_in_only_near_a_standstill() {
    let mut ego = car(10.0);
    let states = drive(&mut ego, gear(Selector::Reverse), 1.0);
    assert!(states.iter().all(|s| s.gear > 0), "no reverse gear at 10 m/s");
    let braked = Controls { selector: Selector::Reverse, ..brake(0.4) };
    let states = drive(&mut ego, braked, 6.0);
    for w in states.windows(2) {
        assert!(w[1].gear > 0 || w[0].gear < 0 || w[1].speed_mps < 1.0, "{} at {}", w[1].gear, w[1].speed_mps);
    }
    let back = Controls { selector: Selector::Reverse, ..throttle(0.2) };
    let states = drive(&mut ego, back, 4.0);
    let end = states.last().unwrap();
    assert!(end.speed_mps < -1.5 && end.gear == -1 && end.position.x < states[0].position.x, "{}", end.speed_mps);
    // A forward gear is also refused while the car rolls back.
    assert_eq!(drive(&mut ego, throttle(0.0), 0.1).last().unwrap().gear, -1);
}

#[test]
fn the_lamps_are_lit_with_the_pedal() {
    let mut ego = car(10.0);
    assert!(!drive(&mut ego, brake(0.0), 0.1)[5].braking);
    assert!(!drive(&mut ego, brake(0.015), 0.1)[5].braking);
    assert!(drive(&mut ego, brake(0.03), 0.01)[0].braking);
}

#[test]
fn wheels_roll_as_far_as_the_car_drives() {
    let states = drive(&mut car(10.0), throttle(0.2), 10.0);
    let end = states.last().unwrap();
    for wheel in end.wheels {
        assert!((f64::from(wheel.spin_rad) * 0.32 - end.position.x).abs() < 0.05, "{wheel:?}");
    }
}

#[test]
fn the_prediction_meets_the_future() {
    // The prediction is a tenth of a second ahead, as the traffic needs it: straight braking, a bend, a stop.
    let mut ego = car(10.0);
    let bend = Controls { steering_wheel_rad: 1.0, ..throttle(0.2) };
    drive(&mut ego, bend, 3.0);
    for controls in [bend, Controls { steering_wheel_rad: 1.0, ..brake(0.3) }] {
        for _ in 0..30 {
            let (pose, speed) = ego.predict(0.1);
            let now = drive(&mut ego, controls, 0.1).pop().unwrap();
            let miss = (pose.position - now.pose().position).length();
            // At pedal steps the acceleration is not constant: 2.2 m/s2 for 0.1 s are 11 mm and 0.2 m/s.
            assert!(miss < 0.013 && (speed - now.speed_mps).abs() < 0.25, "{miss} {speed} {}", now.speed_mps);
        }
        let (pose, _) = ego.predict(0.1);
        let miss = (pose.position - drive(&mut ego, controls, 0.1)[9].pose().position).length();
        assert!(miss < 0.002, "{miss} in a steady moment");
    }
    let mut ego = car(0.4);
    drive(&mut ego, brake(0.5), 0.08);
    let (pose, speed) = ego.predict(10.0);
    assert!(speed == 0.0 && pose.position.x < 0.2, "a braked car stops and stays: {speed} {pose:?}");
}

/// Drives into a standing car at 30 m, rotated by `yaw_rad`. Returns the ego and the contacts with their ticks.
fn run_into(speed_mps: f64, yaw_rad: f64) -> (EgoCar, Vec<(usize, Contact)>) {
    let mut ego = EgoCar::new(&CarParams::default(), Pose::default(), speed_mps, 1).unwrap();
    let obstacle = [Obstacle { pose: Pose::new(dvec2(30.0, 0.2), yaw_rad), speed_mps: 0.0, ..Obstacle::default() }];
    let mut contacts = Vec::new();
    for i in 0..800 {
        contacts.extend(ego.tick(&throttle(0.3), &ROAD, &obstacle).iter().map(|c| (i, *c)));
    }
    (ego, contacts)
}

#[test]
fn the_ego_cannot_pass_through_a_standing_car() {
    for speed in [5.0, 30.0, 60.0] {
        for yaw in [0.0, 0.3, 1.57] {
            let (ego, contacts) = run_into(speed, yaw);
            let (_, first) = contacts[0];
            assert!((first.closing_mps - first.ego_speed_mps).abs() < 0.5, "{first:?}");
            assert!(first.ego_speed_mps > 0.9 * speed && first.car_speed_mps == 0.0, "{first:?}");
            // Contact is at 25 m, bumper to bumper, if the other car stands straight, and at 26.6 m if its side faces the ego.
            let nearest = if yaw > 1.0 { 26.7 } else { 25.5 };
            let s = ego.state();
            let passed = s.position.x > nearest && s.position.y.abs() < 1.5;
            assert!(!passed && s.position.is_finite() && s.velocity.length() < 12.0, "{speed} {yaw}: {s:?}");
        }
    }
    let (ego, contacts) = run_into(30.0, 0.0);
    let end = ego.state().position.x;
    assert!((end - (30.0 - CAR_LENGTH_M)).abs() < 0.1, "it leans on the other's bumper: {end}");
    assert!(contacts.windows(2).all(|w| w[0].0 < w[1].0), "one contact a tick");
}

#[test]
fn a_car_that_drives_into_the_ego_pushes_it() {
    for speed in [2.0, 15.0, 30.0] {
        let mut ego = EgoCar::new(&CarParams::default(), Pose::default(), 0.0, 1).unwrap();
        let mut first = None;
        let mut fastest = 0.0f32;
        for i in 0..2500 {
            let x = (-8.0 + speed * f64::from(i) * TICK_S).min(5.0);
            let pose = Pose::new(dvec2(x, 0.3), 0.0);
            let pusher = [Obstacle { pose, speed_mps: if x < 5.0 { speed } else { 0.0 }, ..Obstacle::default() }];
            first = first.or(ego.tick(&brake(0.3), &ROAD, &pusher).first().copied());
            fastest = fastest.max(ego.state().velocity.length());
        }
        let (first, s) = (first.unwrap(), ego.state());
        assert!((first.closing_mps - speed).abs() < 0.05 && (first.car_speed_mps - speed).abs() < 1e-9, "{first:?}");
        assert!(s.position.x > 9.9 && f64::from(fastest) < 1.15 * speed + 0.5, "{speed}: {} {fastest}", s.position);
        assert!(s.position.z.abs() < 0.01 && s.velocity.length() < 0.01, "{speed}: {s:?}");
    }
}

#[test]
fn a_car_that_appears_on_top_of_the_ego_does_no_harm() {
    let mut ego = EgoCar::new(&CarParams::default(), Pose::default(), 0.0, 1).unwrap();
    for i in 0..500 {
        let x = if i < 50 { 400.0 } else { 3.0 };
        let jumper = [Obstacle { pose: Pose::new(dvec2(x, 0.0), 0.0), speed_mps: 0.0, ..Obstacle::default() }];
        ego.tick(&brake(0.5), &ROAD, &jumper);
        assert!(ego.state().velocity.length() < 6.0, "{}", ego.state().velocity);
    }
    let (s, (pitch, roll)) = (ego.state(), tilt(ego.state()));
    assert!(s.position.truncate().distance(dvec2(3.0, 0.0)) > 3.5, "{}", s.position);
    assert!(s.position.z.abs() < 0.01 && pitch.abs() < 0.01 && roll.abs() < 0.02, "{s:?}");
}

/// The sign of a quaternion changes when a heading passes west. When this was taken for a rotation, it threw the ego away at 300 m/s.
#[test]
fn a_car_that_turns_past_west_pushes_no_harder() {
    for heading in [0.0, std::f64::consts::PI] {
        let mut ego = EgoCar::new(&CarParams::default(), Pose::default(), 0.0, 1).unwrap();
        for i in 0..200 {
            let pose = Pose::new(dvec2(5.1, 0.0), heading - 0.2 + 0.002 * f64::from(i));
            ego.tick(&brake(0.5), &ROAD, &[Obstacle { pose, speed_mps: 0.0, ..Obstacle::default() }]);
            assert!(ego.state().velocity.length() < 0.6, "{heading} tick {i}: {}", ego.state().velocity);
        }
    }
}

/// Runs a drive with random pedals and steering, and a car that appears and disappears.
fn random_drive(seed: u64, ticks: usize, start: DVec2) -> Vec<EgoState> {
    let mut draw = rng::stream(seed, "fuzz");
    let speed = draw.uniform(0.0, 40.0);
    let mut ego = EgoCar::new(&CarParams::default(), Pose::new(start, 0.3), speed, 1).unwrap();
    let mut controls = Controls::default();
    let mut states = Vec::with_capacity(ticks);
    for i in 0..ticks {
        if i % 20 == 0 {
            let odd = [f32::NAN, f32::INFINITY, -5.0, 7.0];
            let mut pedal = || match draw.index(20) {
                0 => odd[draw.index(4)],
                1..8 => 0.0,
                _ => draw.uniform(0.0, 1.0) as f32,
            };
            let (throttle, brake) = (pedal(), pedal());
            controls = Controls {
                throttle,
                brake,
                steering_wheel_rad: draw.uniform(-9.0, 9.0) as f32,
                selector: [Selector::Drive, Selector::Neutral, Selector::Reverse, Selector::Drive][draw.index(4)],
                ..Controls::default()
            };
        }
        let ground = if draw.index(5) == 0 { MEADOW } else { ROAD };
        let near = start + dvec2(i as f64 * 0.05, 4.0 * (i as f64 * 0.01).sin());
        let other = [Obstacle { pose: Pose::new(near, i as f64 * 0.02), speed_mps: 5.0, ..Obstacle::default() }];
        ego.tick(&controls, &ground, &other);
        states.push(*ego.state());
    }
    states
}

#[test]
fn no_controls_can_break_the_ego() {
    for seed in 0..500 {
        for s in random_drive(seed, 200, DVec2::ZERO) {
            let numbers = [s.speed_mps, s.accel_mps2, s.lateral_accel_mps2, s.yaw_rate, f64::from(s.engine_rpm)];
            let finite = s.position.is_finite() && s.rotation.is_finite() && numbers.iter().all(|x| x.is_finite());
            assert!(finite && s.steering_torque_nm.is_finite(), "seed {seed}: {s:?}");
            assert!(s.velocity.length() < 70.0 && s.position.z.abs() < 1.0, "seed {seed}: {s:?}");
            assert!(s.wheels.iter().all(|w| w.hub.is_finite() && w.spin_rad.is_finite()), "seed {seed}: {s:?}");
        }
    }
}

#[test]
fn the_same_drive_has_the_same_bits() {
    let (a, b) = (random_drive(7, 3000, DVec2::ZERO), random_drive(7, 3000, DVec2::ZERO));
    let differs = a.iter().zip(&b).position(|(a, b)| format!("{a:?}") != format!("{b:?}"));
    assert_eq!(differs, None, "first differing tick");
}

#[test]
fn a_far_corner_of_the_world_drives_like_its_middle() {
    let (a, b) = (random_drive(3, 2000, DVec2::ZERO), random_drive(3, 2000, dvec2(40_000.0, -25_000.0)));
    for (tick, (a, b)) in a.iter().zip(&b).enumerate() {
        assert!((a.speed_mps - b.speed_mps).abs() < 1e-3, "tick {tick}: {} {}", a.speed_mps, b.speed_mps);
    }
}
