//! Force-feedback model: signs, cap, continuity, watchdog, and a simulated wheel that the model turns.

use super::{
    super::simulated_wheel::{COUNTS_PER_RAD, SimulatedWheel},
    *,
};
use crate::{
    controls::{Controls, STEERING_LOCK_RAD},
    ego::{CarParams, EgoCar, UniformGround},
    rng,
    space::Pose,
};

/// Period of the force thread, s.
const DT_S: f64 = 0.006;

fn model() -> ForceModel {
    ForceModel::new(&ForceSettings::default(), STEERING_LOCK_RAD.into())
}

fn rolling(aligning_nm: f64) -> ForceInput {
    ForceInput { aligning_nm, speed_mps: 10.0, running: true, ..ForceInput::default() }
}

/// Returns the torque after 1 s of constant input.
fn settled(wheel_rad: f64, force_input: &ForceInput) -> f64 {
    let mut model = model();
    (0..170).map(|_| model.step(DT_S, wheel_rad, force_input, 0.0)).last().unwrap()
}

#[test]
fn every_part_of_the_torque_has_the_right_sign() {
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
fn steering_is_heavier_at_a_standstill() {
    let effort = |speed_mps| {
        let mut model = model();
        let force_input = ForceInput { speed_mps, ..rolling(0.0) };
        (0..200).map(|i| -model.step(DT_S, 0.01 * f64::from(i), &force_input, 0.0)).last().unwrap()
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
fn the_torque_is_finite_and_within_the_cap_for_any_input() {
    let mut random = rng::stream(3, "force");
    let mut model = model();
    for i in 0..20_000 {
        let wild = [0.0, 1e9, -1e9, f64::NAN, f64::INFINITY, random.uniform(-20.0, 20.0)];
        let pick = |random: &mut rng::Stream| wild[random.index(wild.len())];
        let force_input = ForceInput {
            aligning_nm: pick(&mut random),
            speed_mps: pick(&mut random),
            grass: random.uniform(0.0, 1.0),
            held_rad: (random.index(3) > 0).then(|| pick(&mut random)),
            running: true,
            ..ForceInput::default()
        };
        let torque_nm = model.step(DT_S, random.uniform(-9.0, 9.0), &force_input, 0.0);
        assert!(torque_nm.abs() <= ForceSettings::default().cap_nm, "{torque_nm} at {i}");
    }
}

#[test]
fn the_torque_has_no_steps_where_the_inputs_have_none() {
    // Steering of 0.25 Hz over the whole range at changing speed, with grass on and off in ramps.
    let mut model = model();
    let torque = |i: i32, model: &mut ForceModel| {
        let t = f64::from(i) * DT_S;
        let force_input = ForceInput {
            aligning_nm: 5.0 * (3.0 * t).sin(),
            speed_mps: 6.0 + 6.0 * (0.4 * t).sin(),
            grass: (0.5 + (0.7 * t).sin()).clamp(0.0, 1.0),
            running: true,
            ..ForceInput::default()
        };
        model.step(DT_S, 7.7 * (TAU * 0.25 * t).sin(), &force_input, 0.0)
    };
    let torques: Vec<f64> = (0..6000).map(|i| torque(i, &mut model)).collect();
    let largest = torques.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    // End stops: the cap of 1.8 N m over 0.2 rad at 12 rad/s is 0.65 N m a period; all other parts are below 0.15.
    assert!(largest < 0.8, "{largest} N m from one period to the next");
}

#[test]
fn the_force_is_zero_100_ms_after_a_stall_and_in_a_pause() {
    let strong = rolling(9.0);
    let run = |feel_after: &ForceInput, age: &dyn Fn(f64) -> f64| {
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
    let paused = run(&ForceInput { running: false, ..strong }, &|_| 0.0);
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

/// Returns a model with room below its cap, at full force after 1 s of this input at rest in the middle.
fn part(settings: ForceSettings, force_input: &ForceInput) -> ForceModel {
    let mut model = ForceModel::new(&ForceSettings { cap_nm: 20.0, full_nm: 20.0, ..settings }, 7.0);
    (0..170).for_each(|_| {
        model.step(DT_S, 0.0, force_input, 0.0);
    });
    model
}

/// Returns settings with all parts off except the aligning torque.
fn off() -> ForceSettings {
    ForceSettings {
        strength: 1.0,
        friction_nm: 0.0,
        standstill_nm: 0.0,
        damping_nms: 0.0,
        centring_nm: 0.0,
        grass_nm: 0.0,
        ..ForceSettings::default()
    }
}

/// Returns the torque after 0.5 s at this speed of the wheel, from the middle on.
fn turned_at(model: &mut ForceModel, radps: f64, force_input: &ForceInput) -> f64 {
    (1..=83).map(|i| model.step(DT_S, radps * DT_S * f64::from(i), force_input, 0.0)).last().unwrap()
}

fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-6, "{value}, not {expected}");
}

#[test]
fn each_part_alone_is_as_strong_as_its_setting_says() {
    let still = rolling(0.0);
    near(part(ForceSettings { strength: 0.5, ..off() }, &rolling(3.0)).step(DT_S, 0.0, &rolling(3.0), 0.0), 1.5);
    near(part(ForceSettings { centring_nm: 0.4, ..off() }, &still).step(DT_S, 1.5, &still, 0.0), -0.6);
    let mut damped = part(ForceSettings { damping_nms: 0.06, ..off() }, &still);
    near(turned_at(&mut damped, -2.0, &still), 0.12);
    // Dry friction is nearly full at 1 rad/s and full at 10; at a standstill the tyres add to it.
    let rubbed = ForceSettings { friction_nm: 0.1, standstill_nm: 0.4, ..off() };
    near(turned_at(&mut part(rubbed.clone(), &still), 10.0, &still), -0.1);
    near(turned_at(&mut part(rubbed.clone(), &still), 1.0, &still), -0.1 * 1.0_f64.tanh());
    let at_standstill = ForceInput { speed_mps: 0.0, ..still };
    near(turned_at(&mut part(rubbed.clone(), &at_standstill), 10.0, &at_standstill), -0.5);
    // At 1 of 2 m/s, halfway to free rolling, half of the standstill friction; backwards as well.
    for speed_mps in [1.0, -1.0] {
        let slow = ForceInput { speed_mps, ..still };
        near(turned_at(&mut part(rubbed.clone(), &slow), 10.0, &slow), -0.3);
    }
}

#[test]
fn a_soft_end_grows_to_the_cap_over_its_last_fifth_of_a_radian() {
    let still = rolling(0.0);
    let settings = ForceSettings { cap_nm: 1.8, ..off() };
    let at = |wheel_rad: f64| {
        let mut model = ForceModel::new(&settings, 7.0);
        (0..170).map(|_| model.step(DT_S, wheel_rad, &still, 0.0)).last().unwrap()
    };
    assert_eq!((at(6.8), at(-6.8)), (0.0, 0.0));
    near(at(6.9), -0.9);
    near(at(-6.9), 0.9);
    near(at(7.0), -1.8);
    near(at(7.5), -1.8);
}

#[test]
fn grass_shakes_in_two_waves_of_90_and_37_cm_and_a_road_does_not() {
    // 33.3 m are 37 waves of one kind and 90 of the other: at 5 m/s 1110 periods of the thread.
    const PERIODS: i32 = 1110;
    let force_input = ForceInput { speed_mps: 5.0, grass: 1.0, ..rolling(0.0) };
    let mut model = part(ForceSettings { grass_nm: 0.5, ..off() }, &force_input);
    let torques: Vec<f64> = (0..PERIODS).map(|_| model.step(DT_S, 0.0, &force_input, 0.0)).collect();
    let wave = |count: f64| {
        let turn = |i: i32| TAU * count * f64::from(i) / f64::from(PERIODS);
        let sum = |part: fn(f64) -> f64| (0..PERIODS).zip(&torques).map(|(i, nm)| nm * part(turn(i))).sum::<f64>();
        sum(f64::sin).hypot(sum(f64::cos)) * 2.0 / f64::from(PERIODS)
    };
    near(wave(37.0), 0.6 * 0.5);
    near(wave(90.0), 0.4 * 0.5);
    // There is nothing else: the mean square of sines is half the sum of their squared amplitudes.
    let mean_square = torques.iter().map(|nm| nm * nm).sum::<f64>() / f64::from(PERIODS);
    near(mean_square, (0.3_f64.powi(2) + 0.2_f64.powi(2)) / 2.0);
    // With half the share of grass, half the torque; without grass, or at a standstill, none.
    let half = ForceInput { grass: 0.5, ..force_input };
    let mut model = part(ForceSettings { grass_nm: 0.5, ..off() }, &half);
    let one: Vec<f64> = (0..PERIODS).map(|_| model.step(DT_S, 0.0, &half, 0.0)).collect();
    assert!(one.iter().zip(&torques).all(|(one, two)| (one - two / 2.0).abs() < 1e-9));
    // At half of the 3 m/s from which the amplitude is full, half the amplitude: 33.3 m in 3700 periods, forwards and
    // backwards.
    for speed_mps in [1.5, -1.5] {
        let slow = ForceInput { speed_mps, ..force_input };
        let mut model = part(ForceSettings { grass_nm: 0.5, ..off() }, &slow);
        let square = (0..3700).map(|_| model.step(DT_S, 0.0, &slow, 0.0).powi(2)).sum::<f64>();
        near(square / 3700.0, mean_square / 4.0);
    }
    for calm in [ForceInput { grass: 0.0, ..force_input }, ForceInput { speed_mps: 0.0, ..force_input }] {
        let mut model = part(ForceSettings { grass_nm: 0.5, ..off() }, &calm);
        near(model.step(DT_S, 0.0, &calm, 0.0), 0.0);
    }
}

#[test]
fn a_step_of_the_aligning_torque_has_the_stated_time_constant() {
    let mut model = part(off(), &rolling(0.0));
    let mut torque_nm = 0.0;
    // Five steps of 2 ms are one time constant.
    (0..5).for_each(|_| torque_nm = model.step(SMOOTH_S / 5.0, 0.0, &rolling(1.0), 0.0));
    near(torque_nm, 1.0 - (-1.0_f64).exp());
}

#[test]
fn the_force_fades_in_over_0_4_s_and_out_over_24_ms() {
    let force_input = rolling(1.0);
    let mut model = ForceModel::new(&off(), 7.0);
    // In steps of 0.01 s; the filter of the aligning torque settles long before.
    let torques: Vec<f64> = (0..60).map(|_| model.step(0.01, 0.0, &force_input, 0.0)).collect();
    assert!((torques[19] - 0.5).abs() < 1e-6 && (torques[29] - 0.75).abs() < 1e-6, "{torques:?}");
    near(torques[59], 1.0);
    near(model.step(0.006, 0.0, &force_input, 0.059), 1.0);
    near(model.step(0.006, 0.0, &force_input, STALE_S), 0.75);
    near(model.step(0.012, 0.0, &force_input, 0.2), 0.25);
    near(model.step(0.006, 0.0, &force_input, 0.2), 0.0);
    let mut weak = ForceModel::new(&ForceSettings { strength: 0.0, centring_nm: 1.0, ..off() }, 7.0);
    (0..100)
        .for_each(|_| assert_eq!(weak.step(0.01, 1.0, &force_input, 0.0), 0.0, "strength 0 switches all force off"));
}

#[test]
fn a_level_is_one_of_255_steps_to_a_side() {
    let model = model();
    // 2.1 N m is full scale: 1.05 N m is step 127.5, which rounds to 128.
    assert_eq!((model.level(1.05, false), model.level(1.05, true)), (128 * 128, -128 * 128));
    assert_eq!((model.level(0.004, false), model.level(0.005, false)), (0, 128));
}

/// Returns the angles, every millisecond, of a rigid wheel released at `from_rad` in an ego at `speed_mps`. The loop
/// sends an input 60 times a second.
fn let_go(speed_mps: f64, from_rad: f64, seconds: f64) -> Vec<f64> {
    let mut car = EgoCar::new(&CarParams::default(), Pose::default(), speed_mps, 0).unwrap();
    let (mut model, mut wheel) = (model(), SimulatedWheel::g29(from_rad));
    let (mut force_input, mut motor_nm) = (ForceInput::default(), 0.0);
    let mut angles = Vec::new();
    for ms in 0..(seconds * 1e3) as u64 {
        if ms % 10 == 0 {
            // The accelerator keeps the speed.
            let throttle = (0.15 + 0.3 * (speed_mps - car.state().speed_mps)).clamp(0.0, 1.0) as f32;
            let brake = if speed_mps == 0.0 { 1.0 } else { 0.0 };
            let throttle = if speed_mps == 0.0 { 0.0 } else { throttle };
            let steering_wheel_rad = wheel.angle_rad as f32;
            let controls = Controls { steering_wheel_rad, throttle, brake, ..Controls::default() };
            car.tick(&controls, &UniformGround::default(), &[]);
        }
        if ms % 17 == 0 {
            let state = car.state();
            let aligning_nm = state.steering_torque_nm.into();
            force_input = ForceInput { aligning_nm, speed_mps: state.speed_mps, running: true, ..force_input };
        }
        if ms % 6 == 0 {
            let torque_nm = model.step(DT_S, wheel.seen_rad(), &force_input, 0.0);
            motor_nm = SimulatedWheel::made_nm(&model, torque_nm);
        }
        // For the first second a hand holds the wheel, while the tyres build up their force.
        if ms >= 1000 {
            wheel.step(motor_nm, 0.0);
        }
        angles.push(wheel.angle_rad);
    }
    angles
}

#[test]
fn a_released_wheel_returns_at_30_kmh_and_does_not_oscillate() {
    let angles = let_go(30.0 / 3.6, 1.0, 6.0);
    let released = &angles[1000..];
    let end = *released.last().unwrap();
    assert!(end.abs() < 0.35, "it returns: {end:.3} rad");
    // A damping ratio of 0.5 overshoots by 16 %: exp(-pi z / sqrt(1 - z²)).
    let beyond = released.iter().fold(0.0_f64, |most, angle| most.max(-angle));
    assert!(beyond < 0.163, "overshoot {beyond:.3} of 1 rad");
    let last = &released[4000..];
    let swing = last.iter().fold(f64::MIN, |a, b| a.max(*b)) - last.iter().fold(f64::MAX, |a, b| a.min(*b));
    assert!(swing < 0.05, "and rests: swings by {swing:.3} rad");
}

#[test]
fn a_released_wheel_does_not_buzz_at_a_standstill() {
    let angles = let_go(0.0, 0.8, 4.0);
    let last = &angles[2000..];
    let swing = last.iter().fold(f64::MIN, |a, b| a.max(*b)) - last.iter().fold(f64::MAX, |a, b| a.min(*b));
    assert!(swing < 2.0 / COUNTS_PER_RAD, "{swing} rad");
}

#[test]
fn a_contact_is_felt_at_the_wheel_for_a_moment() {
    let mut model = model();
    for _ in 0..100 {
        model.step(DT_S, 0.0, &rolling(0.0), 0.0);
    }
    let torques: Vec<f64> = (0..100)
        .map(|i| {
            let force_input = ForceInput { contact: (-f64::from(i) * DT_S / 0.12).exp(), ..rolling(0.0) };
            model.step(DT_S, 0.0, &force_input, 0.0)
        })
        .collect();
    let most_nm = torques.iter().fold(0.0_f64, |most, torque_nm| most.max(torque_nm.abs()));
    assert!((0.3..0.8).contains(&most_nm), "{most_nm} N m");
    assert!(torques[10..30].iter().any(|nm| *nm < -0.1) && torques[..10].iter().any(|nm| *nm > 0.3), "to and fro");
    assert!(torques[90..].iter().all(|nm| nm.abs() < 0.02), "over after half a second: {torques:?}");
}

#[test]
fn a_pulse_vibrates_at_25_hertz_with_its_strength_and_ends() {
    let mut model = model();
    for _ in 0..100 {
        model.step(DT_S, 0.0, &rolling(0.0), 0.0);
    }
    let torques: Vec<f64> = (0..200)
        .map(|i| model.step(DT_S, 0.0, &ForceInput { pulse: if i < 100 { 0.5 } else { 0.0 }, ..rolling(0.0) }, 0.0))
        .collect();
    // Half of 1 N m, once the filter of 10 ms has let it in. 0.48 s have 12 periods with two changes of sign each.
    let most_nm = torques[20..100].iter().fold(0.0_f64, |most, torque_nm| most.max(torque_nm.abs()));
    assert!((0.45..0.5001).contains(&most_nm), "{most_nm} N m");
    let changes = torques[20..100].windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
    assert!((23..=25).contains(&changes), "{changes} changes of sign");
    assert!(torques[115..].iter().all(|nm| nm.abs() < 0.01), "over after 0.09 s: {torques:?}");
}
