//! SUMO in this process: that it is absent, in use, started often.

use super::*;
use codrive::traffic::{TrafficError, sumo::SumoTraffic};

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
    assert!(first.describe().starts_with("SUMO"), "{}", first.describe());
    drop(first);
    let ended = std::thread::spawn(|| {
        let mut traffic = SumoTraffic::start(ring(0.0)).unwrap();
        traffic.step(None).unwrap();
        std::panic::resume_unwind(Box::new("the drive breaks"));
    })
    .join();
    assert!(ended.is_err());
    SumoTraffic::start(ring(0.0)).unwrap().step(None).unwrap();
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
fn a_network_that_is_not_the_maps_is_refused() {
    let _alone = alone();
    let mut setup = ring(0.0);
    let mut map = (*setup.map).clone();
    map.net_file = RoadMap::load("ring-641").unwrap().net_file;
    setup.map = Arc::new(map);
    let error = SumoTraffic::start(setup).err().expect("the lanes are longer").to_string();
    assert!(error.contains("lane e0_0 is 160.225 m long instead of 62.5 m"), "{error}");
}

#[test]
fn a_broken_network_file_is_an_error_and_the_next_start_works() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("net.xml");
    // SUMO 1.28 itself breaks down on this one.
    std::fs::write(&file, "<net><edge id=").unwrap();
    let mut setup = ring(0.0);
    let mut map = (*setup.map).clone();
    map.net_file = file;
    setup.map = Arc::new(map);
    let error = SumoTraffic::start(setup).err().expect("the file is broken");
    assert!(error.to_string().contains("net.xml: "), "{error}");
    SumoTraffic::start(ring(0.0)).unwrap().step(None).unwrap();
}

#[test]
fn a_drive_on_the_practice_circuit_keeps_to_the_route() {
    let _alone = alone();
    let setup = even("practice", 30, model(0.2), 5.0);
    let map = setup.map.clone();
    let history = run_free(&EngineChoice::Sumo, setup, 3000);
    let (gap_m, way_m) = smallest_gap_and_way(&map, &history);
    assert!(gap_m > 1.0 && way_m >= 0.0, "{gap_m} {way_m}");
    for car in history.iter().flatten() {
        let expected = map.route.pose_of_front(car.s_m, CAR_LENGTH_M);
        let miss_m = car.pose.position.distance(expected.position);
        assert!(miss_m < 0.01, "{car:?} instead of {expected:?}");
        assert!(car.speed_mps < 14.0, "{car:?}");
    }
}
