//! An ego that somebody drives, in both engines: how others react to it.

use super::*;

/// A drive of 90 s: swings of 1.5 m/s2, a braking of 3 m/s2 to a stop, a restart. Speed at the end of each step, m/s.
fn trace(step: usize, speed_mps: f64) -> f64 {
    let t = step as f64 * STEP_S;
    let accel = match t {
        t if t < 30.0 => 1.5 * (t * 1.1).sin(),
        t if t < 40.0 => -3.0,
        t if t < 48.0 => 1.5,
        t if t < 70.0 => 1.5 * (t * 0.7).cos() - 0.1,
        t if t < 76.0 => -3.0,
        _ => 0.8,
    };
    (speed_mps + accel * STEP_S).clamp(0.0, 9.0)
}

#[test]
fn a_follower_of_the_ego_drives_as_behind_one_of_sumos_own_cars() {
    let _alone = alone();
    let setup = ring(0.0);
    let map = setup.map.clone();
    // The reference: a car that SUMO itself drives along the trace.
    let mut sumo = traffic::sumo::SumoTraffic::start(setup.clone()).unwrap();
    let mut reference = vec![sumo.cars().to_vec()];
    for step in 0..900 {
        let next = trace(step, sumo.cars()[0].speed_mps);
        sumo.impose_speed(traffic::EGO, Some(next)).unwrap();
        sumo.step(None).unwrap();
        reference.push(sumo.cars().to_vec());
    }
    drop(sumo);
    for engine in ENGINES {
        let mut traffic = traffic::start(&engine, setup.clone()).unwrap();
        let (mut most, mut sum): (f64, f64) = (0.0, 0.0);
        for step in 0..900 {
            let now = reference[step][0];
            let before = reference[step.saturating_sub(1)][0];
            // What is known at this moment: the next speed is a guess by constant acceleration.
            let next = (2.0 * now.speed_mps - before.speed_mps).max(0.0);
            traffic.step(Some(&report(&map, &now, next))).unwrap();
            for i in 1..22 {
                let difference = (traffic.cars()[i].speed_mps - reference[step + 1][i].speed_mps).abs();
                most = most.max(difference);
                if i == 21 {
                    sum += difference;
                }
            }
        }
        println!("{engine}: largest {most:.6} m/s, mean of the follower {:.6} m/s", sum / 900.0);
        assert!(most < 0.005, "{engine}: {most}");
    }
}

#[test]
fn behind_a_stopped_ego_a_queue_forms_and_nobody_passes() {
    let _alone = alone();
    for engine in ENGINES {
        let setup = ring(0.2);
        let map = setup.map.clone();
        let mut traffic = traffic::start(&engine, setup).unwrap();
        let history =
            run(traffic.as_mut(), 1200, |_, cars| Some(report(&map, &cars[0], (cars[0].speed_mps - 0.3).max(0.0))));
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
            let mut pose = map.route.pose_of_front(100.0, CAR_LENGTH_M);
            pose.position += codrive::space::Pose::new(pose.position, map.route.yaw_at(100.0)).left() * offset_m;
            let parked = EgoReport { pose, speed_mps: 0.0, next_pose: pose, next_speed_mps: 0.0 };
            let history = run(traffic.as_mut(), 300, |_, _| Some(parked));
            let way_m: f64 = (1..=300).map(|k| map.route.difference(history[k - 1][2].s_m, history[k][2].s_m)).sum();
            assert_eq!(way_m < 34.0, seen, "{engine}: at {offset_m} m the follower went {way_m} m");
            assert!(way_m > 30.0);
            assert_eq!(traffic.step(None).is_ok(), seen, "{engine}: its model drives it from the road only");
        }
    }
}

#[test]
fn an_ego_comes_back_to_the_road_and_its_model_takes_over() {
    let _alone = alone();
    let histories = ENGINES.map(|engine| {
        let mut setup = even("ring-250", 5, model(0.0), 0.0);
        setup.cars = standing_at(&[100.0, 150.0, 200.0, 30.0, 60.0]);
        let map = setup.map.clone();
        let mut traffic = traffic::start(&engine, setup).unwrap();
        run(traffic.as_mut(), 900, |step, cars| {
            // Off the road to the left at 3 m/s, along it, back on it after 20 s; from 30 s on by its own model.
            let s_m = 100.0 + 3.0 * step as f64 * STEP_S;
            let offset_m = match step {
                0..100 => step as f64 * 0.06,
                100..200 => 12.0 - step as f64 * 0.06,
                _ => 0.0,
            };
            let at = |s_m: f64| {
                let mut pose = map.route.pose_of_front(s_m, CAR_LENGTH_M);
                pose.position += codrive::space::Pose::new(pose.position, map.route.yaw_at(s_m)).left() * offset_m;
                pose
            };
            let report = EgoReport { pose: at(s_m), speed_mps: 3.0, next_pose: at(s_m + 0.3), next_speed_mps: 3.0 };
            let _ = cars;
            (step < 300).then_some(report)
        })
    });
    let map = RoadMap::load("ring-250").unwrap();
    let (speed, place, position) = differences(&map, &histories[0], &histories[1]);
    println!("{speed:e} {place:e} {position:e}");
    let last = &histories[1][900];
    assert!(last.iter().all(|car| car.speed_mps > 5.0), "all drive on: {last:?}");
    assert!(map.route.project(last[0].pose.front(CAR_LENGTH_M), None).offset_m.abs() < 0.01, "{last:?}");
}

#[test]
fn numbers_that_are_none_are_refused() {
    let _alone = alone();
    for engine in ENGINES {
        let setup = ring(0.0);
        let map = setup.map.clone();
        let mut traffic = traffic::start(&engine, setup).unwrap();
        let mut report = report(&map, &traffic.cars()[0].clone(), 4.0);
        report.next_pose.position.x = f64::NAN;
        let error = traffic.step(Some(&report)).unwrap_err().to_string();
        assert_eq!(error, "predicted x of car 0 is not a finite number: NaN", "{engine}");
        let broken = TrafficSetup { idm: IdmParams { a: f64::NAN, ..model(0.0) }, ..ring(0.0) };
        drop(traffic);
        let error = traffic::start(&engine, broken).err().expect("NaN is refused").to_string();
        assert_eq!(error, "IDM parameter a = NaN: it must be above 0", "{engine}");
    }
}
