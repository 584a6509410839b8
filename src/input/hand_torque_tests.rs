//! Estimate of the hands' torque: a closed form, and wheels of all kinds with a known hand while an automation steers.

use super::{super::simulated_wheel::SimulatedWheel, *};
use crate::{
    input::{
        force::{ForceInput, ForceModel},
        profile::ForceSettings,
    },
    scenario::Automation,
};

/// Period of the force thread, s.
const DT_S: f64 = 0.006;

/// Returns the estimates at each millisecond from 0 s on, on a wheel whose automation has the angle `to` and whose hand the torque `hand`, each 0 in the
/// second before.
fn estimates(mut wheel: SimulatedWheel, seconds: f64, to: impl Fn(f64) -> f64, hand: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut model = ForceModel::new(&ForceSettings::default(), 7.8);
    let (mut force_input, mut motor_nm, mut estimates) = (ForceInput::default(), 0.0, Vec::new());
    for ms in -1000..(seconds * 1e3) as i32 {
        let since = |value: &dyn Fn(f64) -> f64| if ms < 0 { 0.0 } else { value(f64::from(ms) / 1e3) };
        if ms % 17 == 0 {
            let held_rad = Some(since(&to));
            force_input = ForceInput { speed_mps: 10.0, running: true, held_rad, ..ForceInput::default() };
        }
        if ms % 6 == 0 {
            let torque_nm = model.step(DT_S, wheel.seen_rad(), &force_input, 0.0);
            motor_nm = SimulatedWheel::made_nm(&model, torque_nm);
        }
        wheel.step(motor_nm, since(&hand));
        if ms >= 0 {
            estimates.push(model.hand_torque_nm());
        }
    }
    estimates
}

fn most(estimates: &[f64]) -> f64 {
    estimates.iter().fold(0.0_f64, |most, torque_nm| most.max(torque_nm.abs()))
}

#[test]
fn a_wheel_held_against_its_motor_has_the_hands_torque_after_the_delay() {
    let mut observer = HandTorque::default();
    // Without the filter of the motor's torque: 0.8 N m to the left do not turn the wheel, so the hands give 0.8 N m to the right.
    let steps = (DELAY_S / 1e-4).round() as usize;
    (0..steps).for_each(|_| observer.step(1e-4, 1.0, 0.8, 0.0));
    let expected_nm = -0.8 * (1.0 - (-1.0_f64).exp());
    assert!((observer.torque_nm() - expected_nm).abs() < 1e-3, "{}", observer.torque_nm());
    (0..20 * steps).for_each(|_| observer.step(1e-4, 1.0, 0.8, 0.0));
    assert!((observer.torque_nm() + 0.8).abs() < 1e-6);
}

#[test]
fn a_hand_of_0_8_newton_metres_is_noticed_within_0_2_s() {
    let least_nm = Automation::default().hands_on_nm;
    for wheel in SimulatedWheel::of_all_kinds() {
        for hand_nm in [0.8, -1.0, 1.4] {
            let estimates = estimates(wheel.clone(), 2.0, |_| 0.0, |_| hand_nm);
            let noticed = estimates.iter().position(|torque_nm| torque_nm.abs() >= least_nm).expect("noticed");
            assert!(noticed < 200, "after {noticed} ms: {wheel:?}");
            // At rest the friction is on either side; the torque has 255 steps of 2.1 N m.
            let error_nm = (estimates[1999] - hand_nm).abs();
            assert!(error_nm < wheel.friction_nm + 2.1 / 255.0, "{error_nm} N m of {hand_nm}: {wheel:?}");
        }
    }
}

#[test]
fn neither_a_light_hand_nor_a_turn_of_the_automation_is_taken_for_hands() {
    let least_nm = Automation::default().hands_on_nm;
    let turn = |time_s: f64| 45.0_f64.to_radians() * (1.0 - (std::f64::consts::PI * time_s.min(1.0)).cos());
    for wheel in SimulatedWheel::of_all_kinds() {
        // A torque below the threshold less the friction cannot be noticed, one of 0.2 N m on no wheel.
        let touched = most(&estimates(wheel.clone(), 2.0, |_| 0.0, |_| 0.2));
        assert!(touched < least_nm - 0.04, "{touched} N m of a hand of 0.2: {wheel:?}");
        // A right angle in a second, without hands.
        let turned = most(&estimates(wheel.clone(), 1.5, turn, |_| 0.0));
        assert!(turned < 0.35, "{turned} N m without hands: {wheel:?}");
    }
}

#[test]
fn a_participant_who_steers_has_the_torque_that_the_wheel_gives() {
    // A wheel held by the hands in a bend: their torque is the opposite of the motor's, 0.35 of 3 N m.
    let mut model = ForceModel::new(&ForceSettings::default(), 7.8);
    let force_input = ForceInput { aligning_nm: -3.0, speed_mps: 10.0, running: true, ..ForceInput::default() };
    (0..400).for_each(|_| {
        model.step(DT_S, 1.0, &force_input, 0.0);
    });
    assert!((model.hand_torque_nm() - 1.05).abs() < 1e-3, "{}", model.hand_torque_nm());
}
