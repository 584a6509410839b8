//! Position controller: closed forms at rest, and wheels of all kinds that follow the automation.

use super::{super::simulated_wheel::SimulatedWheel, *};
use crate::input::{
    force::{ForceInput, ForceModel},
    profile::ForceSettings,
};

/// Period of the force thread, s.
const DT_S: f64 = 0.006;

fn held(held_rad: Option<f64>) -> ForceInput {
    ForceInput { speed_mps: 10.0, running: true, held_rad, ..ForceInput::default() }
}

/// Returns the angles of a wheel at each millisecond from 0 s on, whose automation has stood at 0 for a second and has the angle `to` from then on. The
/// loop sends an input 60 times a second.
fn angles(mut wheel: SimulatedWheel, seconds: f64, to: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut model = ForceModel::new(&ForceSettings::default(), 7.8);
    let (mut force_input, mut motor_nm, mut angles) = (held(Some(0.0)), 0.0, Vec::new());
    for ms in -1000..(seconds * 1e3) as i32 {
        if ms % 17 == 0 {
            force_input = held(Some(if ms < 0 { 0.0 } else { to(f64::from(ms) / 1e3) }));
        }
        if ms % 6 == 0 {
            let torque_nm = model.step(DT_S, wheel.seen_rad(), &force_input, 0.0);
            motor_nm = SimulatedWheel::made_nm(&model, torque_nm);
        }
        wheel.step(motor_nm, 0.0);
        if ms >= 0 {
            angles.push(wheel.angle_rad);
        }
    }
    angles
}

#[test]
fn a_wheel_reaches_30_degrees_in_0_4_s_without_swinging() {
    let step_rad = 30.0_f64.to_radians();
    for wheel in SimulatedWheel::of_all_kinds() {
        let angles = angles(wheel.clone(), 2.0, |_| step_rad);
        let far = angles.iter().rposition(|angle| (angle - step_rad).abs() > 0.1 * step_rad).expect("it begins at 0");
        assert!(far < 400, "within 10 % after {far} ms: {wheel:?}");
        let most_rad = angles.iter().fold(0.0_f64, |most, angle| most.max(*angle));
        assert!(most_rad < 1.05 * step_rad, "overshoot to {most_rad}: {wheel:?}");
        // At rest the spring holds no more than the friction; the torque has 255 steps of 2.1 N m.
        let rest_rad = (wheel.friction_nm + 2.1 / 255.0) / STIFFNESS_NM;
        let end_rad = angles[1999];
        assert!((end_rad - step_rad).abs() < rest_rad, "{end_rad} of {step_rad}: {wheel:?}");
        assert!(angles[1500..].iter().all(|angle| *angle == end_rad), "it rests: {wheel:?}");
    }
}

#[test]
fn a_wheel_follows_a_turn_of_a_right_angle_in_a_second() {
    let turn = |time_s: f64| 45.0_f64.to_radians() * (1.0 - (std::f64::consts::PI * time_s.min(1.0)).cos());
    for wheel in SimulatedWheel::of_all_kinds() {
        let angles = angles(wheel.clone(), 1.5, turn);
        let late_rad = (0..).zip(&angles).map(|(ms, angle)| (turn(f64::from(ms) / 1e3) - angle).abs());
        let most_deg = late_rad.fold(0.0_f64, f64::max).to_degrees();
        // Below the 10 degrees that override the system; the turn has 141 degrees per second at most.
        assert!(most_deg < 9.0, "{most_deg} degrees late: {wheel:?}");
    }
}

#[test]
fn at_rest_the_torque_is_that_of_the_spring_alone() {
    let settings = ForceSettings { cap_nm: 20.0, full_nm: 20.0, ..ForceSettings::default() };
    let mut model = ForceModel::new(&settings, 7.0);
    let force_input = ForceInput { aligning_nm: 5.0, ..held(Some(0.5)) };
    let torque_nm = (0..300).map(|_| model.step(DT_S, 0.2, &force_input, 0.0)).last().unwrap();
    // 0.3 rad of 8 N m/rad; the tyres' torque, and friction at a standstill, are not felt.
    assert!((torque_nm - 2.4).abs() < 1e-6, "{torque_nm}");
    // An angle beyond the soft end is held at its beginning, 0.2 rad before 7 rad.
    let beyond = held(Some(9.0));
    let torque_nm = (0..300).map(|_| model.step(DT_S, 6.7, &beyond, 0.0)).last().unwrap();
    assert!((torque_nm - 0.8).abs() < 1e-6, "{torque_nm}");
}

#[test]
fn the_force_goes_over_without_a_jump_and_back_in_0_2_s() {
    let mut model = ForceModel::new(&ForceSettings { strength: 1.0, ..ForceSettings::default() }, 7.0);
    let steered = ForceInput { aligning_nm: 1.0, ..held(None) };
    let automated = ForceInput { aligning_nm: 1.0, ..held(Some(0.0)) };
    let mut torques = Vec::new();
    for (force_input, count) in [(&steered, 170), (&automated, 170), (&steered, 170)] {
        torques.extend((0..count).map(|_| model.step(DT_S, 0.1, force_input, 0.0)));
    }
    // 1 N m of the tyres; -0.8 N m of the spring over 0.1 rad; the tyres again.
    for (at, expected_nm) in [(169, 1.0), (339, -0.8), (339 + 34, 1.0), (509, 1.0)] {
        assert!((torques[at] - expected_nm).abs() < 1e-6, "{} at {at}", torques[at]);
    }
    let most_nm = torques[100..].windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    // 1.8 N m in 0.2 s are 0.054 N m in a period; the spring stretches meanwhile.
    assert!(most_nm < 0.06, "{most_nm} N m from one period to the next");
}

#[test]
fn a_held_wheel_is_released_100_ms_after_a_stall_and_in_a_pause() {
    for (paused, age_s) in [(false, 0.1), (true, 0.0)] {
        let mut model = ForceModel::new(&ForceSettings::default(), 7.0);
        let before = (0..170).map(|_| model.step(DT_S, 0.0, &held(Some(1.0)), 0.0)).last().unwrap();
        let force_input = ForceInput { running: !paused, ..held(Some(1.0)) };
        let torques: Vec<f64> = (0..5).map(|_| model.step(DT_S, 0.0, &force_input, age_s)).collect();
        assert_eq!((before, torques[4]), (1.8, 0.0), "{torques:?}");
    }
}
