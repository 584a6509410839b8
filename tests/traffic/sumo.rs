//! SUMO in this process: absent, in use, and started many times.

use super::*;
use codrive::traffic::{FollowingModel, TrafficError, sumo::SumoTraffic};

#[test]
fn without_sumo_the_error_names_the_remedy_and_the_native_engine_works() {
    let _alone = alone();
    let error = SumoTraffic::start_from("no/such/folder".as_ref(), ring(0.0)).err().expect("SUMO is not there");
    assert!(matches!(error, TrafficError::Absent(_)), "{error}");
    let message = error.to_string();
    for part in ["libsumocpp", "no/such/folder", "scripts/setup", "--traffic native"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(traffic::start(&EngineChoice::Native, ring(0.0)).is_ok());
}

#[test]
fn one_simulation_at_a_time_and_the_next_when_it_ends_even_by_a_panic() {
    let _alone = alone();
    let first = SumoTraffic::start(ring(0.0)).unwrap();
    assert!(matches!(SumoTraffic::start(ring(0.0)), Err(TrafficError::Busy)));
    assert!(first.name_and_version().starts_with("SUMO"), "{}", first.name_and_version());
    drop(first);
    let ended = std::thread::spawn(|| {
        let mut traffic = SumoTraffic::start(ring(0.0)).unwrap();
        traffic.step(&[]).unwrap();
        std::panic::resume_unwind(Box::new("the drive breaks"));
    })
    .join();
    assert!(ended.is_err());
    SumoTraffic::start(ring(0.0)).unwrap().step(&[]).unwrap();
}

#[test]
fn fifty_starts_in_one_process_are_alike() {
    let _alone = alone();
    let first = bits(&run_free(&EngineChoice::Sumo, ring(0.2), 20));
    for _ in 0..50 {
        assert!(first == bits(&run_free(&EngineChoice::Sumo, ring(0.2), 20)));
    }
}

#[test]
fn a_car_with_another_model_follows_that_model() {
    let _alone = alone();
    // Two vehicles at rest, each with 120 m of free road.
    let pair = |of_others, seed| {
        let mixture = ModelMixture { model: of_others, share: 1.0 };
        let setup = FixedSetup { mixture, seed, ..even("ring-250", 2, model(0.0), 0.0) };
        run_free(&EngineChoice::Sumo, setup, 30)
    };
    let after_3_s = |model, seed| {
        let history = pair(model, seed);
        [history[30][0].speed_mps, history[30][1].speed_mps]
    };
    // The IDM pulls away with 1 m/s2. Krauss's model pulls away with 2.6 m/s2, of which it loses a quarter on average by random slowdowns
    // (sigma is 0.5, chance uniform): 5.85 m/s after 3 s. The mean of ten cars deviates by less than 0.15.
    let [ego, other] = after_3_s(FollowingModel::Idm, 1);
    assert!((ego - 3.0).abs() < 0.1 && (other - 3.0).abs() < 0.1, "{ego} {other}");
    let mean = (1..=10).map(|seed| after_3_s(FollowingModel::Krauss, seed)[1]).sum::<f64>() / 10.0;
    assert!((mean - 5.85).abs() < 0.4, "{mean}");
    let beside = after_3_s(FollowingModel::Krauss, 1)[0];
    assert!((beside - 3.0).abs() < 0.1, "the ego has the drive's own model: {beside}");
    assert!((after_3_s(FollowingModel::Eidm, 1)[1] - other).abs() > 0.1);
    // The seed determines its random numbers.
    let bits_of = |seed| bits(&pair(FollowingModel::Krauss, seed));
    assert!(bits_of(1) == bits_of(1) && bits_of(1) != bits_of(2));
}

#[test]
fn engines_without_other_models_refuse_them() {
    let mixture = ModelMixture { model: FollowingModel::Krauss, share: 0.5 };
    let error = traffic::start(&EngineChoice::Native, FixedSetup { mixture, ..ring(0.0) }).err().expect("it has none");
    assert!(matches!(error, TrafficError::NoSuchModel(FollowingModel::Krauss)), "{error}");
    assert!(error.to_string().contains("remedy: set --traffic sumo"), "{error}");
}

#[test]
fn a_network_that_differs_from_the_maps_is_refused() {
    let _alone = alone();
    let mut setup = ring(0.0);
    let mut map = (*setup.map).clone();
    map.network = RoadMap::load("ring-641").unwrap().network;
    setup.map = Arc::new(map);
    let error = SumoTraffic::start(setup).err().expect("the lanes are longer").to_string();
    assert!(error.contains("lane e0_0 is 160.225 m long instead of 62.5 m"), "{error}");
}

#[test]
fn a_broken_network_file_is_an_error_and_the_next_start_works() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("net.xml");
    // SUMO 1.28 itself crashes on this file.
    std::fs::write(&file, "<net><edge id=").unwrap();
    let error = RoadMap::load(file.to_str().unwrap()).expect_err("the file is broken");
    assert!(error.to_string().contains("net.xml:"), "{error}");
    SumoTraffic::start(ring(0.0)).unwrap().step(&[]).unwrap();
}

#[test]
fn poses_are_where_sumo_draws_the_cars() {
    // Measured: 2e-12 m.
    let _alone = alone();
    for (name, n) in [("ring-250", 22), ("ring-641", 40), ("practice", 30)] {
        let setup = even(name, n, model(0.2), 5.0);
        let map = setup.map.clone();
        let mut traffic = SumoTraffic::start(setup).unwrap();
        let mut most_m: f64 = 0.0;
        let mut history = vec![cars(&map, &mut traffic)];
        for _ in 0..3000 {
            traffic.step(&[]).unwrap();
            history.push(cars(&map, &mut traffic));
            for car in cars(&map, &mut traffic) {
                let (drawn, own) = (traffic.drawn_pose(car.id).unwrap(), car.pose);
                most_m = most_m.max(drawn.position.distance(own.position));
                assert!(codrive::space::wrap_angle(drawn.yaw_rad - own.yaw_rad).abs() < 1e-9, "{own:?} {drawn:?}");
            }
        }
        println!("{name}: {most_m:e} m");
        assert!(most_m < 1e-9, "{name}: {most_m}");
        let (gap_m, way_m) = smallest_gap_and_way(&map, &history);
        assert!(gap_m > 1.0 && way_m >= 0.0, "{name}: {gap_m} {way_m}");
    }
}
