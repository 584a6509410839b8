//! An externally driven ego in both engines: the behaviour of the other vehicles.

use super::*;
use codrive::space::Pose;

/// Returns the speed at the end of a step, m/s, in a drive of 90 s that is slower than the others: swings of 1.5 m/s2, and twice braking at
/// 3 m/s2 to a stop with a restart.
fn trace(step: usize, speed_mps: f64) -> f64 {
    let t = step as f64 * STEP_S;
    let accel = match t {
        t if t < 30.0 => -1.5 * (t * 1.1).sin(),
        t if t < 40.0 => -3.0,
        t if t < 42.0 => 1.5,
        t if t < 70.0 => 1.5 * ((t - 42.0) * 0.7).cos(),
        t if t < 76.0 => -3.0,
        _ => 0.8,
    };
    (speed_mps + accel * STEP_S).clamp(0.0, 3.5)
}

/// Returns a pose along the road with the front at `s_m`, `offset_m` to the left of the lane.
fn beside(map: &RoadMap, s_m: f64, offset_m: f64) -> Pose {
    let pose = map.route.pose_of_front(s_m, CAR_LENGTH_M);
    let left = Pose::new(pose.position, map.route.yaw_at(s_m)).left();
    Pose::new(pose.position + left * offset_m, pose.yaw_rad)
}

#[test]
fn a_follower_of_the_ego_drives_as_behind_one_of_sumos_own_cars() {
    let _alone = alone();
    let setup = ring(0.0);
    let map = setup.map.clone();
    // The reference is a vehicle that SUMO itself drives along the trace.
    let mut sumo = traffic::sumo::SumoTraffic::start(setup.clone()).unwrap();
    let mut reference = vec![cars(&map, &mut sumo)];
    for step in 0..900 {
        let next = trace(step, cars(&map, &mut sumo)[0].speed_mps);
        sumo.impose_speed(traffic::EGO, Some(next)).unwrap();
        sumo.step(&[]).unwrap();
        reference.push(cars(&map, &mut sumo));
    }
    drop(sumo);
    let (gap_m, _) = smallest_gap_and_way(&map, &reference);
    assert!(gap_m > 1.0, "the trace keeps off its leader: {gap_m}");
    for engine in ENGINES {
        let mut traffic = traffic::start(&engine, setup.clone()).unwrap();
        let (mut most, mut sum): (f64, f64) = (0.0, 0.0);
        for step in 0..900 {
            let now = reference[step][0];
            let before = reference[step.saturating_sub(1)][0];
            // Only the present is known: the next speed is a guess by constant acceleration.
            let next = (2.0 * now.speed_mps - before.speed_mps).max(0.0);
            traffic.step(&[VehicleReport::of_ego(report(&map, &now, next))]).unwrap();
            let now = cars(&map, traffic.as_mut());
            let pairs = now.iter().zip(&reference[step + 1]).skip(1);
            let differences: Vec<f64> = pairs.map(|(car, own)| (car.speed_mps - own.speed_mps).abs()).collect();
            most = differences.iter().fold(most, |most, difference| most.max(*difference));
            sum += differences[20];
        }
        println!("{engine}: largest {most:.6} m/s, mean of the follower {:.6} m/s", sum / 900.0);
        assert!(most < 0.005, "{engine}: {most}");
    }
}

#[test]
fn behind_a_stopped_ego_a_queue_forms_and_no_vehicle_passes() {
    let _alone = alone();
    for engine in ENGINES {
        let setup = ring(0.2);
        let map = setup.map.clone();
        let mut traffic = traffic::start(&engine, setup).unwrap();
        let history = run(&map, traffic.as_mut(), 1200, |_, cars| {
            Some(report(&map, &cars[0], (cars[0].speed_mps - 0.3).max(0.0)))
        });
        let (gap_m, way_m) = smallest_gap_and_way(&map, &history);
        assert!(gap_m > 1.0 && way_m >= 0.0, "{engine}: {gap_m} {way_m}");
        let last = &history[1200];
        assert!(last.iter().all(|car| car.speed_mps == 0.0), "{engine}: all stand: {last:?}");
        for i in 2..22 {
            let gap_m = map.route.difference(last[i].s_m, last[(i + 1) % 22].s_m) - CAR_LENGTH_M;
            assert!((1.5..2.1).contains(&gap_m), "{engine}: car {i} stands {gap_m} m behind its leader");
        }
        assert!(last.iter().all(|car| car.braking), "{engine}: a queue stands with its lamps lit");
    }
}

#[test]
fn an_ego_beside_the_road_is_passed_and_one_at_its_edge_is_not() {
    let _alone = alone();
    for engine in ENGINES {
        for (offset_m, seen) in [(-2.6, true), (2.6, true), (0.0, true), (-2.8, false), (2.8, false), (-30.0, false)] {
            let mut setup = even("ring-250", 3, model(0.0), 0.0);
            setup.cars = standing_at(&[100.0, 200.0, 60.0]);
            let map = setup.map.clone();
            let mut traffic = traffic::start(&engine, setup).unwrap();
            let pose = beside(&map, 100.0, offset_m);
            let parked = ExternalVehicleState { pose, speed_mps: 0.0, next_pose: pose, next_speed_mps: 0.0 };
            let history = run(&map, traffic.as_mut(), 300, |_, _| Some(parked));
            let way_m: f64 = (1..=300).map(|k| map.route.difference(history[k - 1][2].s_m, history[k][2].s_m)).sum();
            assert_eq!(way_m < 34.0, seen, "{engine}: at {offset_m} m the follower went {way_m} m");
            assert!(way_m > 30.0);
            assert_eq!(traffic.step(&[]).is_ok(), seen, "{engine}: its model drives it from the road only");
        }
    }
}

#[test]
fn an_ego_comes_back_to_the_road_and_its_model_takes_over() {
    let _alone = alone();
    for engine in ENGINES {
        let setup = even("ring-250", 10, IdmParams { v0: 6.0, ..model(0.0) }, 0.0);
        let map = setup.map.clone();
        let mut traffic = traffic::start(&engine, setup).unwrap();
        // Leaves the road by 12 m to the left within 20 s, drives on at 3 m/s, returns where there is room, and follows its own model 5 s
        // later.
        let mut back = None;
        let history = run(&map, traffic.as_mut(), 1500, |step, cars| {
            let way_m = |step: usize| 3.0 * step as f64 * STEP_S;
            let room = cars[1..].iter().all(|car| map.route.difference(way_m(step), car.s_m).abs() > 12.0);
            if step > 300 && back.is_none() && room {
                back = Some(step);
            }
            let at = |step: usize| {
                let offset_m = if back.is_some_and(|back| step > back) { 0.0 } else { (step as f64 * 0.06).min(12.0) };
                beside(&map, way_m(step), offset_m)
            };
            let report =
                ExternalVehicleState { pose: at(step), speed_mps: 3.0, next_pose: at(step + 1), next_speed_mps: 3.0 };
            back.is_none_or(|back| step < back + 50).then_some(report)
        });
        let back = back.expect("there is room within 150 s");
        for (step, cars) in history.iter().enumerate().skip(back + 1) {
            let gap_m = |to: &CarState| map.route.difference(cars[0].s_m, to.s_m).abs() - CAR_LENGTH_M;
            assert!(cars[1..].iter().all(|car| gap_m(car) > 0.5), "{engine}: step {step}: {cars:?}");
        }
        let last = &history[1500];
        assert!(last.iter().all(|car| car.speed_mps > 4.0), "{engine}: all drive on: {last:?}");
    }
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let _alone = alone();
    for engine in ENGINES {
        let setup = ring(0.0);
        let map = setup.map.clone();
        let mut traffic = traffic::start(&engine, setup).unwrap();
        let mut report = report(&map, &cars(&map, traffic.as_mut())[0], 4.0);
        report.next_pose.position.x = f64::NAN;
        let error = traffic.step(&[VehicleReport::of_ego(report)]).unwrap_err().to_string();
        assert_eq!(error, "predicted x of vehicle 0 is not a finite number: NaN", "{engine}");
        let drivers = TrafficDrivers::Alike(IdmParams { a: f64::NAN, ..model(0.0) });
        let broken = FixedSetup { drivers, ..ring(0.0) };
        drop(traffic);
        let error = traffic::start(&engine, broken).err().expect("NaN is refused").to_string();
        assert_eq!(error, "IDM parameter a is NaN; allowed: above 0", "{engine}");
    }
}
