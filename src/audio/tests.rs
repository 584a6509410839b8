//! Tests of the sound offline: pitch, levels, continuity, full scale, sides.

use super::*;
use crate::{
    controls::Controls,
    ego::{CarParams, GroundSurface},
    scenario::{Scenario, SoundLevels, sound::SILENT_DB},
    sim::World,
    traffic::EngineChoice,
};
use std::f64::consts::{PI, TAU};

pub(super) const RATE: f32 = 48_000.0;

/// Returns levels with everything silent except what `set` changes.
pub(super) fn only(set: impl Fn(&mut SoundLevels)) -> SoundLevels {
    let s = SILENT_DB;
    let mut levels =
        SoundLevels { master_db: 0.0, engine_db: s, road_db: s, wind_db: s, others_db: s, horn_db: s, tone_db: s };
    set(&mut levels);
    levels
}

pub(super) fn driving(speed_mps: f32, engine_rpm: f32) -> SoundScene {
    SoundScene { running: true, speed_mps, engine_rpm, throttle: 0.3, ..SoundScene::default() }
}

/// Returns the samples of this many seconds of a constant scene, after its first 0.3 s.
pub(super) fn steady(levels: &SoundLevels, sound_scene: &SoundScene, seconds: f32) -> Vec<[f32; 2]> {
    let mut mixer = Mixer::new(levels, RATE);
    let mut out = vec![[0.0; 2]; ((0.3 + seconds) * RATE) as usize];
    mixer.render(sound_scene, &mut out);
    out.split_off((0.3 * RATE) as usize)
}

pub(super) fn left(samples: &[[f32; 2]]) -> Vec<f64> {
    samples.iter().map(|sample| sample[0].into()).collect()
}

/// Returns the RMS value.
pub(super) fn level(samples: &[f64]) -> f64 {
    (samples.iter().map(|s| s * s).sum::<f64>() / samples.len() as f64).sqrt()
}

/// Returns the amplitude at a frequency, by Goertzel with a Hann window.
pub(super) fn amplitude(samples: &[f64], frequency_hz: f64) -> f64 {
    let (step, n) = (TAU * frequency_hz / f64::from(RATE), samples.len() as f64);
    let (mut a, mut b) = (0.0, 0.0);
    for (i, sample) in samples.iter().enumerate() {
        let window = 1.0 - (TAU * i as f64 / n).cos();
        (a, b) = (b, sample * window + 2.0 * step.cos() * b - a);
    }
    2.0 / n * (a * a + b * b - 2.0 * step.cos() * a * b).max(0.0).sqrt()
}

/// Returns the root of the summed power in a band, in steps of 20 Hz.
fn band(samples: &[f64], from_hz: u32, to_hz: u32) -> f64 {
    (from_hz..to_hz).step_by(20).map(|hz| amplitude(samples, hz.into()).powi(2)).sum::<f64>().sqrt()
}

/// Returns the strongest frequency below 250 Hz, to half a hertz.
fn pitch_hz(samples: &[f64]) -> f64 {
    let all = (40..500).map(|half| f64::from(half) / 2.0);
    all.max_by(|a, b| amplitude(samples, *a).total_cmp(&amplitude(samples, *b))).unwrap()
}

/// Returns the largest change from one sample to the next.
fn largest_step(samples: &[[f32; 2]]) -> f32 {
    samples.windows(2).flat_map(|w| [0, 1].map(|side| (w[1][side] - w[0][side]).abs())).fold(0.0, f32::max)
}

#[test]
fn the_engines_pitch_rises_with_the_speed_within_every_gear() {
    let car = CarParams::default();
    for ratio in &car.gearbox.ratios {
        let mut before_hz = 0.0;
        for rpm in [1100.0, 1900.0, 2700.0, 4300.0] {
            let speed_mps = rpm * PI / 30.0 / (ratio * car.gearbox.final_drive) * car.body.wheel_radius_m;
            let sound_scene = driving(speed_mps as f32, rpm as f32);
            let hz = pitch_hz(&left(&steady(&only(|l| l.engine_db = 0.0), &sound_scene, 0.25)));
            // Two of four cylinders fire in a turn.
            assert!((hz - rpm / 30.0).abs() < 2.0, "{rpm} 1/min sounds as {hz} Hz");
            assert!(hz > before_hz, "at {speed_mps:.1} m/s");
            before_hz = hz;
        }
    }
}

#[test]
fn a_loaded_engine_is_louder_and_brighter() {
    let of =
        |throttle| left(&steady(&only(|l| l.engine_db = 0.0), &SoundScene { throttle, ..driving(10.0, 2400.0) }, 0.25));
    let (coasting, floored) = (of(0.0), of(1.0));
    assert!(level(&floored) > 1.5 * level(&coasting));
    let bright = |samples: &[f64]| amplitude(samples, 320.0) / amplitude(samples, 80.0);
    assert!(bright(&floored) > 1.5 * bright(&coasting), "{} {}", bright(&floored), bright(&coasting));
}

#[test]
fn engine_off_lowest_levels_and_pauses_are_silent_and_idle_is_quiet() {
    let all = SoundLevels::default();
    let loudest = |levels: &SoundLevels, sound_scene: &SoundScene| {
        steady(levels, sound_scene, 0.1).iter().flatten().fold(0f32, |most, s| most.max(s.abs()))
    };
    assert_eq!(loudest(&all, &driving(0.0, 0.0)), 0.0, "engine off, standing");
    assert_eq!(loudest(&only(|_| ()), &driving(20.0, 3000.0)), 0.0, "every level at its lowest");
    let idle = loudest(&all, &driving(0.0, 750.0));
    assert!((0.005..0.15).contains(&idle), "{idle}");
    let mut mixer = Mixer::new(&all, RATE);
    let mut out = vec![[0.0; 2]; RATE as usize];
    mixer.render(&driving(20.0, 3000.0), &mut out);
    mixer.render(&SoundScene { running: false, ..driving(20.0, 3000.0) }, &mut out);
    assert!(largest_step(&out) < 0.1, "faded");
    // A device's block of 512 samples later nothing is heard.
    assert!(out[512..].iter().all(|sample| *sample == [0.0; 2]), "the block after that of the pause");
}

#[test]
fn six_decibels_double_and_every_level_is_its_own() {
    let sound_scene = driving(14.0, 2000.0);
    let sets: [fn(&mut SoundLevels, f64); 3] =
        [|l, db| l.engine_db = db, |l, db| l.road_db = db, |l, db| l.wind_db = db];
    for set in sets {
        let of = |db| level(&left(&steady(&only(|l| set(l, db)), &sound_scene, 0.5)));
        let (usual, louder) = (of(0.0), of(6.0206));
        assert!((louder / usual - 2.0).abs() < 0.01, "{usual} {louder}");
    }
}

#[test]
fn wind_and_tyres_grow_with_speed_and_grass_sounds_different() {
    let of = |levels: &SoundLevels, sound_scene: &SoundScene| left(&steady(levels, sound_scene, 1.0));
    let (road, wind) = (only(|l| l.road_db = 0.0), only(|l| l.wind_db = 0.0));
    let at = |levels, speed| level(&of(levels, &driving(speed, 0.0)));
    // 30 dB a decade: twice the speed is 9 dB, 2.8 times the pressure.
    let ratio = at(&road, 20.0) / at(&road, 10.0);
    assert!((2.0..3.2).contains(&ratio), "{ratio}");
    let ratio = at(&wind, 20.0) / at(&wind, 10.0);
    assert!((4.5..7.0).contains(&ratio), "{ratio}");
    assert!(at(&wind, 4.0) < 0.2 * at(&road, 4.0), "on the ring wind is no matter");
    let grass = of(&road, &SoundScene { grass: 1.0, ..driving(8.0, 0.0) });
    let asphalt = of(&road, &driving(8.0, 0.0));
    let tilt = |samples: &[f64]| band(samples, 60, 200) / band(samples, 400, 1000);
    assert!(tilt(&grass) > 1.8 * tilt(&asphalt), "deeper: {} {}", tilt(&grass), tilt(&asphalt));
    assert!(level(&grass) > 1.3 * level(&asphalt), "and louder");
}

#[test]
fn spectra_of_two_speeds_differ_as_expected() {
    let all = SoundLevels::default();
    // In the same gear: 12 m/s at 1500 1/min, 24 m/s at 3000.
    let slow = left(&steady(&all, &driving(12.0, 1500.0), 1.0));
    let fast = left(&steady(&all, &driving(24.0, 3000.0), 1.0));
    assert!((pitch_hz(&slow) - 50.0).abs() < 1.0 && (pitch_hz(&fast) - 100.0).abs() < 1.0);
    let high = |samples: &[f64]| band(samples, 600, 2000);
    assert!(high(&fast) > 2.5 * high(&slow), "{} {}", high(&slow), high(&fast));
}

#[test]
fn a_vehicle_is_heard_on_its_side_and_louder_if_near_or_fast() {
    let others = only(|l| l.others_db = 0.0);
    let ears = |ahead_m, left_m, speed_mps| {
        let mut sound_scene = driving(0.0, 0.0);
        sound_scene.near[2] = Some(NearbyVehicle { ahead_m, left_m, speed_mps, ..Default::default() });
        let samples = steady(&others, &sound_scene, 0.5);
        [0, 1].map(|side| level(&samples.iter().map(|s| s[side].into()).collect::<Vec<f64>>()))
    };
    let [left, right] = ears(0.0, 4.0, 8.0);
    assert!(left > 2.0 * right, "on the left: {left} {right}");
    let [left, right] = ears(1.0, -4.0, 8.0);
    assert!(right > 2.0 * left, "on the right: {left} {right}");
    let [left, right] = ears(12.0, 0.0, 8.0);
    assert!((left / right - 1.0).abs() < 0.01, "ahead");
    let (near, far) = (ears(6.0, 0.0, 8.0)[0], ears(24.0, 0.0, 8.0)[0]);
    assert!((near / far - 4.0).abs() < 0.6, "four times as far: {near} {far}");
    assert!(ears(6.0, 0.0, 12.0)[0] > 1.5 * ears(6.0, 0.0, 4.0)[0]);
}

#[test]
fn rain_patters_on_a_standing_vehicle_and_wet_tyres_hiss() {
    let rain = |levels: &SoundLevels, rain_mmph, speed_mps| {
        left(&steady(levels, &SoundScene { rain_mmph, ..driving(speed_mps, 0.0) }, 0.5))
    };
    let roof = only(|l| l.wind_db = 0.0);
    assert_eq!(level(&rain(&roof, 0.0, 0.0)), 0.0);
    // Ten times the rain is 6 dB louder.
    let louder = level(&rain(&roof, 20.0, 0.0)) / level(&rain(&roof, 2.0, 0.0));
    assert!((louder - 2.0).abs() < 0.05, "{louder}");
    let tyres = only(|l| l.road_db = 0.0);
    let [dry, wet] = [0.0, 5.0].map(|rain_mmph| band(&rain(&tyres, rain_mmph, 20.0), 2000, 4000));
    assert!(wet > 2.0 * dry, "{dry} {wet}");
}

/// Renders this many seconds of everything at once: gears, grass, horn, contacts, tones, vehicles that come and go.
fn wild(levels: &SoundLevels, seconds: u32) -> Vec<[f32; 2]> {
    let mut mixer = Mixer::new(levels, RATE);
    let mut all = Vec::new();
    let mut chunk = vec![[0.0; 2]; 480];
    for tick in 0..seconds * 100 {
        let t = tick as f32 / 100.0;
        let gear_rpm = 1200.0 + 3800.0 * (t * 0.7).fract();
        let mut sound_scene = SoundScene {
            // A gear up within a tick: no gearbox is as quick.
            engine_rpm: gear_rpm,
            throttle: if tick % 90 < 45 { 1.0 } else { 0.0 },
            grass: if tick % 130 < 40 { 1.0 } else { 0.0 },
            horn: tick % 70 < 20,
            contacts: tick / 37,
            contact_mps: 1.0 + (tick % 9) as f32,
            advices: tick / 53,
            ..driving(40.0 * (0.5 + 0.5 * t.sin()), 0.0)
        };
        for (i, near) in sound_scene.near.iter_mut().enumerate() {
            let there = !(tick / 20 + i as u32).is_multiple_of(3);
            // A car, a person who makes a step in each half second, a bicycle, and so on.
            let source = [SoundSource::Motor, SoundSource::Feet, SoundSource::Bicycle][i % 3];
            let (ahead_m, left_m, steps) = (3.0 - i as f32, 3.0, tick / 50);
            *near = there.then_some(NearbyVehicle { source, ahead_m, left_m, speed_mps: 30.0, steps });
        }
        mixer.render(&sound_scene, &mut chunk);
        all.extend_from_slice(&chunk);
    }
    all
}

#[test]
fn no_sample_reaches_full_scale_even_at_the_highest_levels() {
    let loud = 12.0;
    let levels = SoundLevels {
        master_db: loud,
        engine_db: loud,
        road_db: loud,
        wind_db: loud,
        others_db: loud,
        horn_db: loud,
        tone_db: loud,
    };
    let samples = wild(&levels, 6);
    let most = samples.iter().flatten().fold(0f32, |most, s| most.max(s.abs()));
    assert!((0.9..1.0).contains(&most), "{most}");
    let mut mixer = Mixer::new(&levels, RATE);
    let mut out = [[0.0; 2]; 480];
    mixer.render(&SoundScene { engine_rpm: f32::NAN, speed_mps: f32::INFINITY, ..driving(0.0, 0.0) }, &mut out);
    assert!(out.iter().flatten().all(|s| s.abs() < 1.0), "what is no number is no sound");
}

#[test]
fn no_click_when_gears_horn_contacts_tones_and_vehicles_change() {
    // Without noise, whose samples jump by nature: steps then come from partials alone. Horn: 14 partials of 0.14/k at
    // 392 k and 494 k Hz give at most 14 x 0.14 x 2 pi 443 / 48000 = 0.114; engine, thump and tone 0.035 more.
    let levels = only(|l| (l.engine_db, l.horn_db, l.tone_db) = (0.0, 0.0, 0.0));
    let step = largest_step(&wild(&levels, 6));
    assert!(step < 0.15, "{step} of full scale from one sample to the next");
    let engine = only(|l| l.engine_db = 0.0);
    let step = largest_step(&wild(&engine, 6));
    assert!(step < 0.035, "the engine alone, a gear in a tick: {step}");
    // A click spreads over all frequencies; the engine ends at 24 x 5000 / 120 = 1000 Hz, the tone at 1480 Hz.
    let quiet = left(&wild(&only(|l| (l.engine_db, l.tone_db) = (0.0, 0.0)), 4));
    let high = (6000..20_000).step_by(500).map(|hz| amplitude(&quiet, hz.into())).fold(0.0, f64::max);
    assert!(high < 1e-4, "{:.0} dB", 20.0 * high.log10());
}

#[test]
fn a_contact_thumps_and_a_change_of_advice_rings_once() {
    let mut mixer = Mixer::new(&only(|l| (l.horn_db, l.tone_db) = (0.0, 0.0)), RATE);
    let mut half = vec![[0.0; 2]; 24_000];
    let mut after = |sound_scene: &SoundScene| {
        mixer.render(sound_scene, &mut half);
        left(&half)
    };
    assert_eq!(
        level(&after(&SoundScene { contacts: 7, advices: 3, ..driving(5.0, 0.0) })),
        0.0,
        "those before are over"
    );
    let soft = after(&SoundScene { contacts: 8, contact_mps: 1.0, advices: 3, ..driving(5.0, 0.0) });
    let hard = after(&SoundScene { contacts: 9, contact_mps: 6.0, advices: 3, ..driving(5.0, 0.0) });
    assert!(level(&hard) > 2.0 * level(&soft) && level(&soft) > 0.003);
    assert!(band(&hard, 30, 150) > 3.0 * band(&hard, 400, 2000), "dull");
    let rung = after(&SoundScene { contacts: 9, advices: 4, ..driving(5.0, 0.0) });
    assert!(amplitude(&rung, 740.0) > 0.01 && level(&rung[20_000..]) < 1e-4);
    let silent = after(&SoundScene { contacts: 9, advices: 4, ..driving(5.0, 0.0) });
    assert!(level(&silent) < 1e-6);
    let asked = after(&SoundScene { contacts: 9, advices: 4, questions: 1, ..driving(5.0, 0.0) });
    assert!(amplitude(&asked, 440.0) > 0.01 && amplitude(&asked, 740.0) < 1e-3, "another tone than that of advice");
}

/// Returns the scenes of a drive with full throttle, then none.
fn listened(scenario: &Scenario, ticks: usize) -> Vec<SoundScene> {
    let mut world = World::new(scenario).unwrap();
    let mut listener = Listener::new(scenario);
    (0..ticks)
        .map(|tick| {
            let throttle = if tick < ticks / 2 { 1.0 } else { 0.0 };
            let controls = Controls { throttle, steering_wheel_rad: 0.9, ..Controls::default() };
            world.tick(&controls).unwrap();
            listener.tick(world.snapshot(), world.events(), &controls);
            listener.scene(true, false)
        })
        .collect()
}

#[test]
fn speed_engine_vehicles_contacts_and_changed_advice_are_heard() {
    let scenario =
        Scenario { traffic: EngineChoice::Native, policy: "constant".into(), hold_s: 0.1, ..Scenario::default() };
    let with_tone = listened(&Scenario { advice_tone: true, ..scenario.clone() }, 700);
    let last = with_tone.last().unwrap();
    assert!(with_tone.iter().any(|h| h.speed_mps > 4.0 && h.engine_rpm > 1500.0 && h.throttle == 1.0));
    assert_eq!(with_tone[0].near.iter().flatten().count(), 6, "a full ring is all around");
    let ahead = with_tone[0].near.iter().flatten().filter(|car| car.ahead_m > 0.0).count();
    assert_eq!(ahead, 3);
    assert!(last.contacts >= 1 && last.contact_mps > 0.5, "a floored car meets its leader: {last:?}");
    assert_eq!(last.advices, 1, "the same speed, advised ten times a second, rings once");
    let without = listened(&scenario, 100);
    assert_eq!(without.last().unwrap().advices, 0, "and not at all unless it is asked for");
}

#[test]
fn tones_of_events_sound_at_their_rates_from_the_onset_on() {
    let text = "traffic = \"native\"\nvehicles = 2\ntrees = 0\n\
         [[event]]\nname = \"a\"\ntrigger = { time_s = 1 }\nactions = [{ sound = { tone = \"gentle\", for_s = 4.5 } }]\n\
         [[event]]\nname = \"b\"\ntrigger = { time_s = 7 }\nactions = [{ sound = { tone = \"urgent\" } }]\n";
    let heard = listened(&Scenario::from_toml(text, "tones.toml").unwrap(), 1000);
    let counts: Vec<u32> = heard.iter().map(|sound_scene| sound_scene.questions).collect();
    let begins: Vec<usize> = (1..counts.len()).filter(|k| counts[*k] > counts[k - 1]).map(|k| k + 1).collect();
    // The first tick that an event shows is the one after its trigger. A gentle tone each 2 s, an urgent one each 0.6 s for 2 s.
    assert_eq!(begins, [101, 301, 501, 701, 761, 821, 881]);
}

#[test]
fn a_vehicle_keeps_its_place_while_it_is_heard() {
    let scenario = Scenario { traffic: EngineChoice::Native, ..Scenario::default() };
    let heard = listened(&scenario, 600);
    // A vehicle moves by less than a metre in a tick; another one in its place would be a jump.
    for pair in heard.windows(2) {
        for (a, b) in pair[0].near.iter().zip(&pair[1].near) {
            if let (Some(a), Some(b)) = (a, b) {
                assert!((a.ahead_m - b.ahead_m).hypot(a.left_m - b.left_m) < 2.0, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn wheels_on_grass_are_heard_by_their_share() {
    let scenario = Scenario { traffic: EngineChoice::Native, ..Scenario::default() };
    let world = World::new(&scenario).unwrap();
    let mut snapshot = world.snapshot().clone();
    snapshot.ego.wheels[1].surface = GroundSurface::Grass;
    let mut listener = Listener::new(&Scenario::default());
    listener.tick(&snapshot, &[], &Controls::default());
    assert_eq!(listener.scene(true, true).grass, 0.25);
    assert!(listener.scene(true, true).horn && !listener.scene(false, false).running);
}

#[test]
fn a_file_is_as_long_as_the_drive_and_the_same_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str| {
        let path = folder.path().join(name);
        let mut file = SoundFile::begin(&path, &SoundLevels::default()).unwrap();
        (0..50).for_each(|i| file.tick(&driving(i as f32 * 0.5, 900.0 + 40.0 * i as f32)).unwrap());
        file.end().unwrap();
        std::fs::read(&path).unwrap()
    };
    let bytes = write("a.wav");
    assert_eq!(bytes.len(), 44 + 50 * 480 * 4);
    assert_eq!(bytes, write("b.wav"));
    assert!(SoundFile::begin(&folder.path().join("a.wav"), &SoundLevels::default()).is_err(), "nothing is overwritten");
}

#[test]
fn a_sentence_is_heard_in_a_file_from_its_tick_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    let mut file = SoundFile::begin(&path, &SoundLevels::default()).unwrap();
    let silent = SoundScene::default();
    let mut ticks = |count: usize, sentence: Option<&str>| {
        sentence.into_iter().for_each(|sentence| file.say(sentence).unwrap());
        (0..count).for_each(|_| file.tick(&silent).unwrap());
    };
    // Half a second before, three seconds from the sentence on, which takes a second.
    ticks(50, None);
    ticks(300, Some("Turn left."));
    file.end().unwrap();
    let samples: Vec<i16> = hound::WavReader::open(&path).unwrap().samples().collect::<Result<_, _>>().unwrap();
    assert_eq!(samples.len(), 350 * 480 * 2);
    let loudest = |from_s: f64, to_s: f64| {
        let at = |s: f64| (s * 48_000.0) as usize * 2;
        samples[at(from_s)..at(to_s)].iter().map(|sample| sample.unsigned_abs()).max()
    };
    assert_eq!((loudest(0.0, 0.5), loudest(2.5, 3.5)), (Some(0), Some(0)));
    assert!(loudest(0.5, 1.5) > Some(3000), "{:?}", loudest(0.5, 1.5));
}
