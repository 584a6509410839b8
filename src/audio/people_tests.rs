//! Tests of the sound of people on foot and on bicycles.

use super::{tests::*, *};
use crate::{
    controls::Controls,
    scenario::Scenario,
    sim::{Snapshot, VehicleSnapshot},
    traffic::{VehicleBody, VehicleId, VehicleKind},
};
use glam::dvec2;

/// Returns the samples of the left ear, without the ego's sounds, of a person who moves along the ego's left side.
fn heard(kind: VehicleKind, aside_m: f64, speed_mps: f64, seconds: usize) -> Vec<f64> {
    let mut listener = Listener::new(&Scenario::default());
    let mut mixer = Mixer::new(&only(|levels| levels.others_db = 0.0), RATE);
    let mut samples = Vec::new();
    let mut tick = vec![[0.0; 2]; RATE as usize / 100];
    for k in 0..100 * seconds {
        let odometer_m = speed_mps * k as f64 / 100.0;
        // On the spot: the distance stays the same.
        let mut person = VehicleSnapshot {
            id: VehicleId(4),
            body: VehicleBody::of_kind(kind),
            speed_mps,
            odometer_m,
            ..VehicleSnapshot::default()
        };
        person.pose.position = dvec2(0.0, aside_m);
        let snapshot = Snapshot { cars: vec![person], ..Snapshot::default() };
        listener.tick(&snapshot, &[], &Controls::default());
        mixer.render(&listener.scene(true, false), &mut tick);
        samples.extend_from_slice(&tick);
    }
    left(&samples)
}

/// Returns the number of bursts: 20 ms above the level, after 20 ms below a tenth of it.
fn bursts(samples: &[f64], loud: f64) -> usize {
    let levels: Vec<f64> = samples.chunks(RATE as usize / 50).map(level).collect();
    levels.windows(2).filter(|pair| pair[0] < 0.1 * loud && pair[1] > loud).count()
}

#[test]
fn a_walker_is_heard_once_at_each_step_of_the_gait() {
    let samples = heard(VehicleKind::Pedestrian, 2.0, 1.4, 10);
    // By hand: a person of 1.79 m makes two steps in 0.76 times the height, and begins at 1.48 cycles (4 times 0.37): 10.29 cycles later the steps 3 to
    // 23 have sounded.
    let steps = (2.0 * (4.0 * 0.37 + 14.0 / (0.76 * 1.79_f64))).floor() - (2.0 * 4.0 * 0.37_f64).floor();
    assert_eq!(steps, 21.0);
    assert_eq!(bursts(&samples, 2.5e-4), steps as usize);
    // The one after the next is a cycle later: 0.97 s at 1.4 m/s, of which the begin is known to 20 ms.
    let begins: Vec<usize> = {
        let levels: Vec<f64> = samples.chunks(RATE as usize / 50).map(level).collect();
        (1..levels.len()).filter(|k| levels[k - 1] < 2.5e-5 && levels[*k] > 2.5e-4).collect()
    };
    for pair in begins.windows(3) {
        let cycle_s = (pair[2] - pair[0]) as f64 / 50.0;
        assert!((cycle_s - 0.76 * 1.79 / 1.4).abs() < 0.041, "{cycle_s} s");
    }
}

#[test]
fn a_person_who_stands_and_one_far_away_are_silent() {
    assert_eq!(level(&heard(VehicleKind::Pedestrian, 2.0, 0.0, 3)), 0.0);
    assert_eq!(level(&heard(VehicleKind::Pedestrian, 20.5, 1.4, 3)), 0.0);
    assert!(level(&heard(VehicleKind::Pedestrian, 19.5, 1.4, 3)) > 0.0);
    assert_eq!(level(&heard(VehicleKind::Bicycle, 2.0, 0.0, 3)), 0.0);
    assert_eq!(level(&heard(VehicleKind::Bicycle, 35.5, 5.0, 3)), 0.0);
}

#[test]
fn people_are_half_as_loud_at_twice_the_distance() {
    for (kind, speed_mps) in [(VehicleKind::Pedestrian, 1.4), (VehicleKind::Bicycle, 5.0)] {
        let [at_2_m, at_4_m, at_16_m] = [2.0, 4.0, 16.0].map(|aside_m| level(&heard(kind, aside_m, speed_mps, 4)));
        assert!((at_2_m / at_4_m - 2.0).abs() < 0.01, "{kind:?}: {at_2_m} {at_4_m}");
        assert!((at_2_m / at_16_m - 8.0).abs() < 0.05, "{kind:?}: {at_2_m} {at_16_m}");
    }
}

#[test]
fn a_cyclist_has_no_engine_and_is_far_quieter_than_a_passing_car() {
    let [bicycle, car] = [VehicleKind::Bicycle, VehicleKind::Car].map(|kind| heard(kind, 4.0, 5.0, 4));
    // The firing of an engine and its first harmonics are between 26 and 160 Hz (`traffic.rs`).
    let engine = |samples: &[f64]| (30..160).step_by(2).map(|hz| amplitude(samples, hz.into())).fold(0.0, f64::max);
    assert!(engine(&car) > 0.005 && engine(&bicycle) < 0.01 * engine(&car), "{} {}", engine(&car), engine(&bicycle));
    // Beside a car at 50 km/h, 7.5 m away: a step is 20 dB quieter at 1 m, and a bicycle 16 dB (docs/references.md, footsteps).
    let passing = level(&heard(VehicleKind::Car, 7.5, 50.0 / 3.6, 4));
    let db = |samples: f64| 20.0 * (samples / passing).log10();
    let riding_db = db(level(&heard(VehicleKind::Bicycle, 1.0, 5.0, 4)));
    // The loudest 125 ms, which is the time constant "fast" of a sound level meter.
    let walking = heard(VehicleKind::Pedestrian, 1.0, 1.4, 4);
    let loudest = walking.chunks(RATE as usize / 8).map(level).fold(0.0, f64::max);
    assert!((riding_db + 16.0).abs() < 2.0 && (db(loudest) + 20.0).abs() < 3.0, "{riding_db} dB, {} dB", db(loudest));
}
