//! Tests of the body's pitch and of the snapshot's hash.

use super::*;
use crate::policy::Action;

#[test]
fn a_body_pitches_smoothly_under_braking_and_settles() {
    let mut pitch = Pitch::default();
    let (mut lowest, mut largest_step) = (0f32, 0f32);
    for _ in 0..300 {
        pitch = pitch.step(-3.0, 0.01);
        lowest = lowest.min(pitch.now_rad);
        largest_step = largest_step.max((pitch.now_rad - pitch.before_rad).abs());
    }
    let rest = -3.0 * 0.0356 / 9.81;
    assert!((pitch.now_rad - rest).abs() < 0.02 * rest.abs(), "{}", pitch.now_rad);
    assert!(lowest > 1.35 * rest && lowest < 1.05 * rest, "a little over its rest: {lowest}");
    // The car is 5 m long: its bumper moves by less than 1.5 mm in 10 ms.
    assert!(largest_step * 2.5 < 0.0015, "{largest_step}");
}

fn car(id: u32) -> VehicleSnapshot {
    let s_m = 10.0 * f64::from(id);
    VehicleSnapshot { id: VehicleId(id), s_m: Some(s_m), speed_mps: 3.0, accel_mps2: 0.5, ..VehicleSnapshot::default() }
}

fn snapshot(cars: u32) -> Snapshot {
    let ego = EgoState { speed_mps: 4.0, gear: 1, ..EgoState::default() };
    Snapshot {
        tick: Tick(50),
        ego,
        ego_before: ego,
        ego_s_m: 0.0,
        lane_offset_m: 0.25,
        cars: (1..=cars).map(car).collect(),
        mean_speed_mps: 3.5,
        ..Snapshot::default()
    }
}

#[test]
fn the_first_difference_is_named_with_its_vehicle_and_both_values() {
    let one = snapshot(3);
    assert_eq!(one.first_difference(&one.clone()), None);
    let mut other = one.clone();
    other.cars[1].accel_mps2 = 0.75;
    other.cars[2].s_m = Some(99.0);
    assert_eq!(one.first_difference(&other), Some(("acceleration of car 2".into(), 0.5, 0.75)));
    assert_eq!(other.first_difference(&one), Some(("acceleration of car 2".into(), 0.75, 0.5)));
    // Equal as numbers, not as bits.
    let mut signed = one.clone();
    signed.ego.accel_mps2 = -0.0;
    let (name, mine, theirs) = one.first_difference(&signed).expect("a bit differs");
    assert_eq!(
        (name.as_str(), mine.is_sign_negative(), theirs.is_sign_negative()),
        ("acceleration of car 0", false, true)
    );
    // 15 numbers of the ego and its time, 4 of each car, 2 of an advice.
    assert_eq!(one.first_difference(&snapshot(2)), Some(("count of numbers".into(), 27.0, 23.0)));
    let advice = Advice {
        issued: Tick(50),
        hold: crate::policy::Hold::of_steps(1, 0.1),
        action: Action::Speed(4.0),
        target_mps: 4.0,
        range_mps: 1.0,
        is_fallback: false,
        driver: None,
        observed: None,
    };
    let advised = Snapshot { advice: Some(advice), ..one.clone() };
    assert_eq!(one.first_difference(&advised), Some(("count of numbers".into(), 27.0, 29.0)));
}

#[test]
fn hashes_are_chained_over_every_number() {
    // The offset of FNV-1a, and eight bytes of zero: the authors' test vectors for 64 bits (isthe.com/chongo, "FNV hash").
    assert_eq!(HASH_START, 0xcbf2_9ce4_8422_2325);
    assert_eq!(rng::fnv_1a(HASH_START, &[0; 8]), 0xa8c7_f832_281a_39c5);
    // The first three numbers of SplitMix64 with seed 0 (prng.di.unimi.it/splitmix64.c), whose state grows by its constant.
    let state = |k: u64| 0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(k);
    let outputs = [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4, 0x06c4_5d18_8009_454f];
    assert_eq!([1, 2, 3].map(|k| rng::chained(0, state(k))), outputs);
    let one = snapshot(2);
    assert_eq!(one.hash(HASH_START), one.clone().hash(HASH_START));
    assert_ne!(one.hash(HASH_START), one.hash(one.hash(HASH_START)), "what was before counts");
    let changes: [fn(&mut Snapshot); 17] = [
        |s| s.tick = Tick(51),
        |s| s.ego.position.y = 0.1,
        |s| s.ego.rotation.z = 0.1,
        |s| s.ego.speed_mps += 0.1,
        |s| s.ego.accel_mps2 += 0.1,
        |s| s.ego.yaw_rate += 0.1,
        |s| s.ego.gear = 2,
        |s| s.ego.engine_rpm += 1.0,
        |s| s.ego.steering_torque_nm += 0.1,
        |s| s.lane_offset_m += 0.1,
        |s| s.cars[1].s_m = s.cars[1].s_m.map(|s_m| s_m + 0.1),
        |s| s.cars[1].s_m = None,
        |s| s.cars[1].speed_mps += 0.1,
        |s| s.cars[0].accel_mps2 += 0.1,
        |s| s.cars[0].lamps.brake = true,
        |s| {
            s.stimuli =
                Some(Arc::new(EventStimuli { tones: vec![(ToneSeries::Gentle, Tick(50))], ..Default::default() }))
        },
        |s| {
            let sentence = Some(("Mind the gap".into(), Tick(50)));
            s.stimuli = Some(Arc::new(EventStimuli { sentence, ..Default::default() }));
        },
    ];
    for (i, change) in changes.iter().enumerate() {
        let mut other = one.clone();
        change(&mut other);
        assert_ne!(other.hash(HASH_START), one.hash(HASH_START), "change {i}");
    }
}
