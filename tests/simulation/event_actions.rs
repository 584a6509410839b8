//! Actions of events on vehicles, signals and the car: each has the effect that its numbers promise.

use crate::{
    events::{RING, drive, scenario},
    world::one_at_a_time,
};
use codrive::{
    controls::Controls,
    map::network::SignalLight,
    sim::{EventStage, NotDone, World},
    traffic::VehicleId,
};

/// Returns an event with one action.
fn event(name: &str, trigger: &str, action: &str) -> String {
    format!("[[event]]\nname = \"{name}\"\ntrigger = {trigger}\nactions = [{action}]\n")
}

#[test]
fn a_vehicle_that_breaks_down_stands_with_hazard_lights_and_drives_on() {
    let action = "{ break_down = { vehicle = \"leader\", decel_mps2 = 2, for_s = 4 } }";
    let text = RING.to_owned() + &event("stop", "{ time_s = 2 }", action);
    let mut seen = Vec::new();
    let stages = drive(&scenario(&text), 14.0, |world| {
        let car = world.snapshot().vehicle(VehicleId(1)).expect("on the ring");
        seen.push((car.speed_mps, car.lamps.left && car.lamps.right));
    });
    let end = stages.iter().find(|stage| stage.3 == EventStage::Ended).expect("it ends").2;
    let standing = seen.iter().filter(|(speed_mps, _)| *speed_mps == 0.0).count();
    assert!((40..=42).contains(&standing), "4 s: {standing} steps");
    // Steps end at 0.1 s, 0.2 s, …: the lights are on from 2.1 s to the end of the event.
    let lit: Vec<usize> = (0..seen.len()).filter(|k| seen[*k].1).collect();
    assert_eq!((lit[0], lit.len()), (20, (end as usize - 200) / 10), "{lit:?}");
    assert!(seen.last().expect("steps").0 > 0.5);
}

#[test]
fn a_vehicle_keeps_its_speed_among_others_that_do_not() {
    let noisy = RING.replace("idm = { noise = 0 }", "idm = { noise = 0.3 }\nvehicles = 4");
    let action = "{ keep_speed = { vehicle = \"1\", for_s = 5 } }";
    let mut speeds = Vec::new();
    drive(&scenario(&(noisy + &event("keep", "{ time_s = 5 }", action))), 14.0, |world| {
        speeds.push(world.snapshot().vehicle(VehicleId(1)).expect("on the ring").speed_mps);
    });
    let varies = |range: std::ops::Range<usize>| {
        let part = &speeds[range];
        part.iter().copied().fold(f64::MIN, f64::max) - part.iter().copied().fold(f64::MAX, f64::min)
    };
    assert!(varies(49..100) < 1e-9, "{} m/s within the event", varies(49..100));
    assert!(varies(0..49) > 0.01 && varies(101..140) > 0.01, "{} and {} m/s", varies(0..49), varies(101..140));
}

/// Drives the participant's car with constant controls; returns its speed, m/s, its lateral offset, m, each step, and its stages.
fn driven(text: &str, controls: &Controls, seconds: f64) -> Vec<(f64, f64)> {
    let mut world = World::new(&scenario(text)).unwrap_or_else(|error| panic!("{error}"));
    let mut seen = Vec::new();
    for k in 1..=(seconds * 100.0) as u64 {
        world.tick(controls).expect("the traffic goes on");
        if k % 10 == 0 {
            seen.push((world.snapshot().ego.speed_mps, world.snapshot().lane_offset_m));
        }
    }
    seen
}

#[test]
fn without_power_the_accelerator_has_no_effect() {
    let text = RING.to_owned() + &event("stall", "{ time_s = 2 }", "{ power_loss = { for_s = 3 } }");
    let floored = Controls { throttle: 0.5, ..Controls::default() };
    let (with, without) = (driven(&text, &floored, 5.0), driven(RING, &floored, 5.0));
    assert_eq!(with[..20], without[..20], "alike until the event");
    let fastest = with[20..50].iter().map(|seen| seen.0).fold(0.0, f64::max);
    // Half a pedal of a saloon brings 2 m/s2 or so; for a moment the engine still spins.
    assert!(fastest < with[19].0 + 0.5 && without[49].0 > with[49].0 + 3.0, "{fastest}, {:?}", without[49]);
}

#[test]
fn wind_from_the_right_pushes_the_car_to_the_left() {
    let action = "{ side_wind = { from = \"right\", wind_mps = 20, for_s = 2 } }";
    let text = RING.to_owned() + &event("gust", "{ time_s = 1 }", action);
    let rolling = Controls::default();
    let (with, without) = (driven(&text, &rolling, 3.0), driven(RING, &rolling, 3.0));
    assert_eq!(with[..10], without[..10], "alike until the event");
    let aside_m = with[29].1 - without[29].1;
    // 600 N on 1.5 t are 0.4 m/s2. The tyres take most of it; some centimetres remain.
    assert!((0.005..0.8).contains(&aside_m), "{aside_m} m");
}

#[test]
fn a_slippery_road_makes_the_way_to_a_stop_longer() {
    let action = "{ friction = { share = 0.1, for_s = 20 } }";
    let text = RING.to_owned() + &event("ice", "{ time_s = 0 }", action);
    let braking = Controls { brake: 1.0, ..Controls::default() };
    let way_m = |text: &str| driven(text, &braking, 10.0).iter().map(|seen| 0.1 * seen.0.max(0.0)).sum::<f64>();
    let (icy_m, dry_m) = (way_m(&text), way_m(RING));
    // v²/2μg: with a tenth of the friction ten times as far, less the time in which the brake builds up.
    assert!((3.0..10.5).contains(&(icy_m / dry_m)), "{icy_m} m and {dry_m} m");
}

#[test]
fn a_vehicle_of_the_next_lane_cuts_in_at_its_gap() {
    let _alone = one_at_a_time();
    let action = "{ cut_in = { vehicle = \"left_leader\", gap_m = 12, within_s = 40 } }";
    let text = "map = \"motorway\"\npolicy = \"none\"\ntrees = 0\nwarm_up_s = 60\nduration_s = 90\n".to_owned()
        + &event("cut in", "{ time_s = 5 }", action);
    let mut seen = Vec::new();
    let stages = drive(&scenario(&text), 60.0, |world| {
        let view = world.snapshot();
        seen.push((view.tick.0, view.leader, view.lane_offset_m));
    });
    let onset = stages.iter().find(|stage| stage.3 == EventStage::Onset).unwrap_or_else(|| panic!("{stages:?}"));
    let who = onset.1.expect("a vehicle");
    assert!(!stages.iter().any(|stage| matches!(stage.3, EventStage::NotDone(_))), "{stages:?}");
    let end = stages.iter().find(|stage| stage.3 == EventStage::Ended).unwrap_or_else(|| panic!("{stages:?}")).2;
    let first = seen
        .iter()
        .filter(|seen| seen.0 > onset.2)
        .find(|(_, leader, _)| leader.is_some_and(|leader| leader.id.0 == who))
        .expect("it is the leader");
    let gap_m = first.1.expect("a leader").gap_m;
    // Within a metre of its gap, and the ego may brake while it comes over.
    assert!((10.5..16.0).contains(&gap_m), "{gap_m} m at {} of {end}", first.0);
    assert!(first.0 <= end + 10, "{first:?}, {end}");
}

#[test]
fn a_cut_in_without_a_vehicle_beside_is_recorded_as_not_done() {
    let _alone = one_at_a_time();
    let action = "{ cut_in = { vehicle = \"right_leader\", gap_m = 10 } }";
    let text = "map = \"lane-10km\"\npolicy = \"none\"\ntrees = 0\nwarm_up_s = 1\nduration_s = 10\n".to_owned()
        + &event("cut in", "{ time_s = 1 }", action);
    let stages = drive(&scenario(&text), 2.0, |_| ());
    assert!(stages.iter().any(|stage| stage.3 == EventStage::NotDone(NotDone::NoVehicle)), "{stages:?}");
}

#[test]
fn the_next_signal_turns_red_before_the_ego() {
    let _alone = one_at_a_time();
    let text = "map = \"tests/data/networks/grid-signals.net.xml\"\npath = \"B0B1 B1B2\"\npolicy = \"none\"\ntrees = 0\nwarm_up_s = 0\n\
         duration_s = 40\n"
        .to_owned()
        + &event("green", "{ all = [{ edge = { id = \"B0B1\", at_m = 10 } }] }", "{ signal_ahead = { light = \"green\" } }")
        + &event(
            "red",
            "{ all = [{ signal_ahead = { light = \"green\", below_m = 40 } }, { after = { event = \"green\" } }] }",
            "{ signal_ahead = { light = \"red\" } }",
        );
    let mut lights = Vec::new();
    let stages = drive(&scenario(&text), 30.0, |world| {
        let line = world.snapshot().signals.all_letters().to_vec();
        lights.push((world.snapshot().tick.0, line));
    });
    let onset = |number: u16| {
        stages.iter().find(|stage| stage.0 == number && stage.3 == EventStage::Onset).map(|stage| stage.2)
    };
    let (Some(green), Some(red)) = (onset(0), onset(1)) else { panic!("{stages:?}") };
    assert!(red > green, "{stages:?}");
    let at = |tick: u64| lights.iter().find(|light| light.0 > tick + 10).expect("a step").1.clone();
    let is = |letters: &[u8], wanted: fn(SignalLight) -> bool| {
        letters.iter().filter_map(|letter| SignalLight::from_letter(*letter)).any(wanted)
    };
    assert_ne!(at(green), at(red), "the signal changes");
    assert!(is(&at(red), |light| light == SignalLight::Red));
}
