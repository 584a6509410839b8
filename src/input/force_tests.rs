//! The model of the force: signs, cap, continuity, watchdog, and a wheel of iron turned by it.

use super::*;
use crate::{
    ego::{CarParams, Controls, Ego, Everywhere, STEERING_LOCK_RAD},
    rng,
    space::Pose,
};

/// Period of the force thread.
const DT_S: f64 = 0.006;

fn model() -> ForceModel {
    ForceModel::new(&ForceSettings::default(), STEERING_LOCK_RAD.into())
}

fn rolling(aligning_nm: f64) -> Feel {
    Feel { aligning_nm, speed_mps: 10.0, grass: 0.0, running: true }
}

/// The torque after a second of the same.
fn settled(wheel_rad: f64, feel: &Feel) -> f64 {
    let mut model = model();
    (0..170).map(|_| model.step(DT_S, wheel_rad, feel, 0.0)).last().unwrap()
}

#[test]
fn every_part_pushes_to_its_side() {
    assert!(settled(0.0, &rolling(2.0)) > 0.5, "an aligning torque to the left turns left");
    assert!(settled(0.0, &rolling(-2.0)) < -0.5);
    let lock = f64::from(STEERING_LOCK_RAD);
    assert!(settled(lock, &rolling(0.0)) < -1.0, "the left end pushes back to the right");
    assert!(settled(-lock, &rolling(0.0)) > 1.0);
    assert_eq!(settled(1.0, &rolling(0.0)), 0.0, "a car has no spring in the middle");
    let mut turning = model();
    let torques: Vec<f64> = (0..200).map(|i| turning.step(DT_S, 0.01 * f64::from(i), &rolling(0.0), 0.0)).collect();
    assert!(torques[199] < -0.1, "turned to the left, friction and damping hold back: {}", torques[199]);
}

#[test]
fn a_standing_car_is_heavier_to_steer() {
    let effort = |speed_mps| {
        let mut model = model();
        let feel = Feel { speed_mps, ..rolling(0.0) };
        (0..200).map(|i| -model.step(DT_S, 0.01 * f64::from(i), &feel, 0.0)).last().unwrap()
    };
    assert!(effort(0.0) > effort(1.0) && effort(1.0) > effort(5.0));
    assert_eq!(effort(5.0), effort(30.0));
}

#[test]
fn a_positive_level_turns_towards_greater_values() {
    let model = model();
    assert_eq!((model.level(2.1, true), model.level(-2.1, true)), (-32_640, 32_640));
    assert_eq!((model.level(2.1, false), model.level(0.0, true)), (32_640, 0));
    assert_eq!(model.level(50.0, true), -32_640);
}

#[test]
fn whatever_comes_in_the_cap_holds_and_the_level_is_a_number() {
    let mut random = rng::stream(3, "force");
    let mut model = model();
    for i in 0..20_000 {
        let wild = [0.0, 1e9, -1e9, f64::NAN, f64::INFINITY, random.uniform(-20.0, 20.0)];
        let pick = |random: &mut rng::Stream| wild[random.index(wild.len())];
        let feel = Feel {
            aligning_nm: pick(&mut random),
            speed_mps: pick(&mut random),
            grass: random.uniform(0.0, 1.0),
            running: true,
        };
        let torque_nm = model.step(DT_S, random.uniform(-9.0, 9.0), &feel, 0.0);
        assert!(torque_nm.abs() <= ForceSettings::default().cap_nm, "{torque_nm} at {i}");
    }
}

#[test]
fn the_torque_has_no_steps_where_the_inputs_have_none() {
    // 2 Hz of steering over the whole range at changing speed, with grass on and off in ramps.
    let mut model = model();
    let torque = |i: i32, model: &mut ForceModel| {
        let t = f64::from(i) * DT_S;
        let feel = Feel {
            aligning_nm: 5.0 * (3.0 * t).sin(),
            speed_mps: 6.0 + 6.0 * (0.4 * t).sin(),
            grass: (0.5 + (0.7 * t).sin()).clamp(0.0, 1.0),
            running: true,
        };
        model.step(DT_S, 7.7 * (TAU * 0.25 * t).sin(), &feel, 0.0)
    };
    let torques: Vec<f64> = (0..6000).map(|i| torque(i, &mut model)).collect();
    let largest = torques.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    // Ends: cap 1.8 N m over 0.2 rad at 12 rad/s is 0.65 N m a period; all else is below 0.15.
    assert!(largest < 0.8, "{largest} N m from one period to the next");
}

#[test]
fn a_stalled_loop_has_no_force_after_100_ms_and_a_pause_is_a_stall() {
    let strong = rolling(9.0);
    let run = |feel_after: &Feel, age: &dyn Fn(f64) -> f64| {
        let mut model = model();
        (0..170).for_each(|_| {
            model.step(DT_S, 0.0, &strong, 0.0);
        });
        let mut t = 0.0;
        let mut torques = Vec::new();
        while t + DT_S < 0.100 {
            t += DT_S;
            torques.push(model.step(DT_S, 0.0, feel_after, age(t)));
        }
        torques
    };
    let stalled = run(&strong, &|t| t);
    assert!(stalled[0] > 1.5);
    assert_eq!(stalled.last(), Some(&0.0), "{stalled:?}");
    let paused = run(&Feel { running: false, ..strong }, &|_| 0.0);
    assert_eq!(paused[5], 0.0, "{paused:?}");
    let largest = stalled.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    assert!(largest < 0.5, "faded, not cut: {largest}");
}

#[test]
fn the_force_comes_back_slowly() {
    let mut model = model();
    let first = model.step(DT_S, 0.0, &rolling(9.0), 0.0);
    assert!(first < 0.05, "{first}");
}

/// Inertia of a G29's rim with its geared motors, kg m2, its own dry friction, N m, and the counts of its sensor a radian.
const RIM_KGM2: f64 = 0.05;
const RIM_NM: f64 = 0.08;
const COUNTS_PER_RAD: f64 = 65_536.0 / (5.0 * std::f64::consts::PI);

/// A wheel of iron let go at `from_rad`, in a car at `speed_mps`: its angle every millisecond. The loop speaks 60 times a
/// second, the force comes 6 ms late, the sensor has counts.
fn let_go(speed_mps: f64, from_rad: f64, seconds: f64) -> Vec<f64> {
    let mut car = Ego::new(&CarParams::default(), Pose::default(), speed_mps, 0).unwrap();
    let mut model = model();
    let (mut angle, mut rate) = (from_rad, 0.0_f64);
    let (mut feel, mut torque_nm, mut next_nm) = (Feel::default(), 0.0, 0.0);
    let mut angles = Vec::new();
    for ms in 0..(seconds * 1e3) as u64 {
        // For the first second a hand holds the wheel, while the tyres build up their force.
        let held = ms < 1000;
        if ms % 10 == 0 {
            // The pedal keeps the speed.
            let throttle = (0.15 + 0.3 * (speed_mps - car.state().speed_mps)).clamp(0.0, 1.0) as f32;
            let brake = if speed_mps == 0.0 { 1.0 } else { 0.0 };
            let throttle = if speed_mps == 0.0 { 0.0 } else { throttle };
            let controls = Controls { steering_wheel_rad: angle as f32, throttle, brake, ..Controls::default() };
            car.tick(&controls, &Everywhere::default(), &[]);
        }
        if ms % 17 == 0 {
            let state = car.state();
            feel = Feel {
                aligning_nm: state.steering_torque_nm.into(),
                speed_mps: state.speed_mps,
                grass: 0.0,
                running: true,
            };
        }
        if ms % 6 == 0 {
            torque_nm = next_nm;
            let seen = (angle * COUNTS_PER_RAD).round() / COUNTS_PER_RAD;
            let sent = model.step(DT_S, seen, &feel, 0.0);
            next_nm = -f64::from(model.level(sent, true)) / 32_767.0 * 2.1;
        }
        if !held {
            let friction = if rate.abs() < 1e-3 && torque_nm.abs() < RIM_NM {
                rate = 0.0;
                -torque_nm
            } else {
                -RIM_NM * (rate / 0.02).clamp(-1.0, 1.0)
            };
            rate += (torque_nm + friction) / RIM_KGM2 * 1e-3;
            angle += rate * 1e-3;
        }
        angles.push(angle);
    }
    angles
}

#[test]
fn let_go_at_30_kmh_the_wheel_returns_and_does_not_oscillate() {
    let angles = let_go(30.0 / 3.6, 1.0, 6.0);
    let released = &angles[1000..];
    let end = *released.last().unwrap();
    assert!(end.abs() < 0.35, "it returns: {end:.3} rad");
    // Damping ratio 0.5 overshoots by 16 %: exp(-pi z / sqrt(1 - z^2)).
    let beyond = released.iter().fold(0.0_f64, |most, angle| most.max(-angle));
    assert!(beyond < 0.163, "overshoot {beyond:.3} of 1 rad");
    let last = &released[4000..];
    let swing = last.iter().fold(f64::MIN, |a, b| a.max(*b)) - last.iter().fold(f64::MAX, |a, b| a.min(*b));
    assert!(swing < 0.05, "and rests: swings by {swing:.3} rad");
}

#[test]
fn at_a_standstill_nothing_buzzes() {
    let angles = let_go(0.0, 0.8, 4.0);
    let last = &angles[2000..];
    let swing = last.iter().fold(f64::MIN, |a, b| a.max(*b)) - last.iter().fold(f64::MAX, |a, b| a.min(*b));
    assert!(swing < 2.0 / COUNTS_PER_RAD, "{swing} rad");
}
