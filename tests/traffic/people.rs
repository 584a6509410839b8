//! Traffic of measured people: the same persons and speeds in both engines, and persons who keep their traits on a network.

use super::network::Town;
use super::*;
use codrive::traffic::{CarFollowing, Demand, DemandSetup, TrafficDriver, TrafficPopulation, sumo::SumoTraffic};
use std::fs;

fn people(name: &str) -> TrafficDrivers {
    TrafficDrivers::named(name, model(0.0)).expect("a shipped population")
}

#[test]
fn persons_move_alike_in_both_engines() {
    let _alone = alone();
    for name in ["safe-followers", "gap-closers"] {
        let setup = FixedSetup { drivers: people(name), ..even("ring-250", 20, model(0.0), 3.0) };
        let [native, sumo] = ENGINES.map(|engine| run_kicked(&engine, setup.clone(), 3000));
        // As for drivers who are alike: the rest is rounding.
        let (speed, place, position) = differences(&setup.map, &native, &sumo);
        println!("{name}: {speed:e} m/s, {place:e} m, {position:e} m");
        assert!(speed < 1e-10 && place < 1e-9 && position < 1e-9, "{name}: {speed:e} {place:e} {position:e}");
        assert!(smallest_gap_and_way(&setup.map, &native).0 > 0.0, "{name}");
        let other = FixedSetup { seed: 2, ..setup };
        assert!(bits(&run_free(&EngineChoice::Native, other, 100)) != bits(&native[..101].to_vec()), "{name}");
    }
}

/// Returns ten cars behind one that drives 5 m/s, after two minutes on a straight road; the first is that car.
fn platoon(text: &str) -> (DemandSetup, Vec<VehicleState>) {
    let nodes = "<node id=\"a\" x=\"0\" y=\"0\"/><node id=\"b\" x=\"2000\" y=\"0\"/>";
    let town = Town::of(nodes, "<edge id=\"ab\" from=\"a\" to=\"b\" numLanes=\"1\" speed=\"30\"/>", "");
    let kind = |id: &str, fastest: u32| {
        format!(
            "<vType id=\"{id}\" carFollowModel=\"IDM\" length=\"5\" maxSpeed=\"{fastest}\" speedFactor=\"1\" speedDev=\"0\" delta=\"4\" decel=\"1.5\"/>"
        )
    };
    let mut demand = format!("<routes>{}{}", kind("slow", 5), kind("car", 30));
    for k in 0..11 {
        let (id, depart) = (if k == 0 { "slow" } else { "car" }, 4 * k);
        demand += &format!(
            "<vehicle id=\"v{k}\" type=\"{id}\" depart=\"{depart}\" departSpeed=\"5\"><route edges=\"ab\"/></vehicle>"
        );
    }
    let file = town.folder.path().join("platoon.rou.xml");
    fs::write(&file, demand + "</routes>").expect("written");
    let drivers = TrafficDrivers::People(Arc::new(TrafficPopulation::parse(text, "mine.toml").expect("valid")));
    let setup = DemandSetup { drivers, ..town.setup(Demand { files: vec![file], ..Demand::default() }) };
    let mut traffic = SumoTraffic::start_with_demand(&setup).expect("it starts");
    for _ in 0..2400 {
        traffic.step(&[]).expect("a step");
    }
    let mut cars = traffic.vehicles().to_vec();
    cars.sort_by(|a, b| b.s_m.total_cmp(&a.s_m));
    (setup, cars)
}

/// Returns the persons of these cars.
fn persons(setup: &DemandSetup, cars: &[VehicleState]) -> Vec<TrafficDriver> {
    cars.iter().map(|car| setup.drivers.driver(setup.seed, car.id.0)).collect()
}

/// A population of the IDM whose persons differ in time gap and in the gap at a standstill; no noise.
const IDM: &str = "title = 't'\nsource = 's'\nmodel = 'idm'\n[parameters]\nv0 = { mean = 30, unit = 'm/s' }\n\
    T = { mean = 1.5, spread = 0.4, unit = 's' }\na = { mean = 1.2, spread = 0.1, unit = 'm/s2' }\nb = { mean = 1.5, unit = 'm/s2' }\n\
    delta = { mean = 4, unit = '' }\ns0 = { mean = 2, spread = 0.3, unit = 'm' }\nnoise_sd = { mean = 0, unit = 'm/s2' }\n\
    noise_memory = { mean = 1, unit = 's' }\n";

#[test]
fn persons_on_a_network_keep_their_own_gap() {
    let _alone = alone();
    let (setup, cars) = platoon(IDM);
    assert_eq!(cars.len(), 11);
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for (k, person) in persons(&setup, &cars).iter().enumerate().skip(1) {
        let CarFollowing::Idm(idm) = person.model else { panic!("another model") };
        let gap_m = cars[k - 1].s_m - cars[k].s_m - 5.0;
        // Closed form: (s0 + v T) / sqrt(1 - (v / v0)^4) at 5 m/s. A car still closes up by less than 1 % of it.
        let wanted_m = (idm.s0 + 5.0 * idm.t) / (1.0 - (5.0_f64 / 30.0).powi(4)).sqrt();
        assert!((gap_m / wanted_m - 1.0).abs() < 0.01, "car {k}: {gap_m} instead of {wanted_m}");
        (least, most) = (least.min(gap_m), most.max(gap_m));
    }
    assert!(most > 1.5 * least, "persons differ: {least} to {most} m");
}

#[test]
fn persons_with_a_model_that_sumo_lacks_drive_by_it_on_a_network() {
    let _alone = alone();
    let text = "title = 't'\nsource = 's'\nmodel = 'optimal-velocity'\n[parameters]\nalpha = { mean = 0.666, unit = '1/s' }\n\
        beta = { mean = 21.6, unit = 'm2/s' }\nv_max = { mean = 8.94, unit = 'm/s' }\nd0 = { mean = 2.2146, spread = 0.2, unit = 'm' }\n\
        ds = { mean = 2.815, unit = '' }\nnoise_sd = { mean = 0, unit = 'm/s2' }\nnoise_memory = { mean = 1, unit = 's' }\n";
    let (setup, cars) = platoon(text);
    assert_eq!(cars.len(), 11);
    for (k, person) in persons(&setup, &cars).iter().enumerate().skip(1) {
        let CarFollowing::OptimalVelocity(model) = person.model else { panic!("another model") };
        let gap_m = cars[k - 1].s_m - cars[k].s_m - 5.0;
        // By hand: at rest in the platoon the optimal velocity of the gap is the leader's speed.
        let rise = 5.0 / model.v_max * (1.0 + model.ds.tanh()) - model.ds.tanh();
        let wanted_m = model.d0 * (rise.atanh() + model.ds);
        assert!((gap_m / wanted_m - 1.0).abs() < 0.01, "car {k}: {gap_m} instead of {wanted_m}");
    }
}

#[test]
fn imposed_persons_stop_at_signals_and_hit_no_vehicle() {
    let _alone = alone();
    let town = Town::grid();
    let setup = DemandSetup { drivers: people("gap-closers"), ..town.setup(town.trips()) };
    let mut traffic = SumoTraffic::start_with_demand(&setup).expect("it starts");
    let (mut standing, mut looked) = (0, 0);
    for _ in 0..2400 {
        traffic.step(&[]).expect("a step");
        let mut cars: Vec<VehicleState> = traffic.vehicles().to_vec();
        standing += cars.iter().filter(|car| car.speed_mps < 0.1).count();
        looked += cars.len();
        cars.sort_by(|a, b| (a.lane, a.s_m).partial_cmp(&(b.lane, b.s_m)).expect("finite"));
        for pair in cars.windows(2).filter(|pair| pair[0].lane.is_some() && pair[0].lane == pair[1].lane) {
            let is_beside = (pair[0].offset_m - pair[1].offset_m).abs() > 1.8;
            let gap_m = pair[1].s_m - pair[1].body.length_m - pair[0].s_m;
            assert!(is_beside || gap_m > 0.0, "{:?} {:?}", pair[0], pair[1]);
        }
    }
    // Signals hold back a part of them, as they do everywhere.
    assert!(looked > 20_000 && standing > looked / 20 && standing < looked / 2, "{standing} of {looked}");
}
