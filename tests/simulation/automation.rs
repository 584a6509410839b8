//! The automation drives the participant's vehicle in traffic: speeds, gaps and lane as stated, a stop in the lane without a takeover, and a takeover by
//! the simulated driver.

use codrive::{
    controls::Controls,
    drive_loop::offline::OfflineDrive,
    metrics::{AutomationChange, SwitchedOffBy},
    scenario::Scenario,
    sim::{EventKind, EventStage, NotDone, World},
    snapshot::AutomationMode,
};

const RING: &str = "traffic = \"native\"\nvehicles = 16\nidm = { noise = 0 }\ntrees = 0\nduration_s = 0\n";

fn scenario(text: &str) -> Scenario {
    Scenario::from_toml(&format!("{RING}{text}"), "automation.toml").unwrap_or_else(|fault| panic!("{fault}"))
}

/// Drives for `seconds` with the hands off; `look` sees each tick.
fn hands_off(text: &str, seconds: u32, mut look: impl FnMut(&World)) -> World {
    let mut world = World::new(&scenario(text)).unwrap_or_else(|error| panic!("{error}"));
    for _ in 0..seconds * 100 {
        world.tick(&Controls::default()).expect("the native engine");
        look(&world);
    }
    world
}

#[test]
fn a_car_on_its_own_keeps_lane_and_time_gap() {
    let text =
        "policy = \"none\"\n[automation]\nsystem = \"cruise-and-lane-keeping\"\ntime_gap_s = 2\nset_speed_mps = 20\n";
    let (mut offset_m, mut gap_m): (f64, f64) = (0.0, f64::INFINITY);
    let world = hands_off(text, 120, |world| {
        let snapshot = world.snapshot();
        offset_m = offset_m.max(snapshot.lane_offset_m.abs());
        gap_m = gap_m.min(snapshot.leader.expect("fifteen others").gap_m);
    });
    let ego = world.snapshot();
    let leader = ego.leader.expect("fifteen others");
    // 2 m at a standstill and 2 s. Sixteen vehicles leave 10.6 m to each on average, too little for the speed that the bend allows.
    let expected_m = 2.0 + 2.0 * ego.ego.speed_mps;
    assert!((leader.gap_m - expected_m).abs() < 2.5, "{} m at {} m/s", leader.gap_m, ego.ego.speed_mps);
    assert!(offset_m < 0.4 && gap_m > 2.0, "{offset_m} m beside the middle, {gap_m} m behind the leader");
    assert_eq!((ego.automation.mode, world.contacts_of_others()), (AutomationMode::On, 0));
}

#[test]
fn without_a_takeover_it_stops_in_the_lane_with_hazard_lights() {
    let text = "policy = \"none\"\n[automation]\nsystem = \"traffic-jam-pilot\"\nminimal_risk_mps2 = 2\n\
                [[event]]\nname = \"ask\"\ntrigger = { time_s = 20 }\nactions = [{ takeover_request = { lead_s = 7 } }]\n";
    let mut changes = Vec::new();
    let mut braking = Vec::new();
    let world = hands_off(text, 40, |world| {
        changes.extend(world.events().iter().filter_map(|event| match event.kind {
            EventKind::Automation(change) => Some((event.tick.0, change)),
            _ => None,
        }));
        let snapshot = world.snapshot();
        if snapshot.automation.mode == AutomationMode::MinimalRisk && snapshot.ego.speed_mps > 0.1 {
            braking.push(snapshot.ego.speed_mps);
        }
    });
    let ego = world.snapshot();
    assert_eq!(
        changes[1..],
        [(2001, AutomationChange::Request { lead_s: 7.0 }), (2701, AutomationChange::MinimalRisk)]
    );
    // Even braking takes v / b; the foot needs a moment for the brake.
    let expected_s = braking[0] / 2.0;
    let taken_s = braking.len() as f64 / 100.0;
    assert!((taken_s - expected_s).abs() < 0.6, "{taken_s} s from {} m/s", braking[0]);
    let lamps = ego.ego_lamps();
    assert!(lamps.left && lamps.right && lamps.brake && ego.ego.speed_mps.abs() < 0.05);
    assert!(ego.lane_offset_m.abs() < 0.4, "{}", ego.lane_offset_m);
}

#[test]
fn the_simulated_driver_takes_over_when_asked_and_drives_on() {
    let text = "policy = \"none\"\ndriver = \"follow\"\n[automation]\nsystem = \"cruise-and-lane-keeping\"\n\
                [[event]]\nname = \"ask\"\ntrigger = { time_s = 10 }\nactions = [{ takeover_request = { lead_s = 15 } }]\n";
    let mut run = OfflineDrive::new(&scenario(text), [0.0, f64::INFINITY]).unwrap();
    run.until(10.0).unwrap();
    assert_eq!(run.world().snapshot().automation.mode, AutomationMode::On);
    let (mut taken, mut offset_m) = (None, 0.0f64);
    while run.world().time_s() < 60.0 {
        run.until(run.world().time_s() + 0.01).unwrap();
        let by_button = |kind: &EventKind| *kind == EventKind::Automation(AutomationChange::Off(SwitchedOffBy::Button));
        if run.world().events().iter().any(|event| by_button(&event.kind)) {
            taken = Some(run.world().time_s());
        }
        offset_m = offset_m.max(run.world().snapshot().lane_offset_m.abs());
    }
    // The response time is lognormal about 2.5 s with a deviation of the logarithm of 0.35: within four of them.
    let after_s = taken.expect("a takeover") - 10.0;
    assert!((0.6..10.0).contains(&after_s), "{after_s}");
    assert!(offset_m < 0.6 && run.world().snapshot().ego.speed_mps > 3.0, "{offset_m}");
    let scores = run.summary().takeovers.expect("a request");
    assert_eq!((scores.takeovers, scores.minimal_risk_manoeuvres), (1, 0));
    assert!((scores.takeover_time_s.unwrap() - after_s).abs() < 0.03, "{scores:?} {after_s}");
}

#[test]
fn the_policys_speed_is_driven_and_its_advice_is_not_shown() {
    let text = "policy = \"constant\"\npolicy_speed_mps = 4\n[automation]\nsystem = \"policy\"\n\
                [[event]]\nname = \"end\"\ntrigger = { time_s = 40 }\nactions = [{ automation = \"off\" }]\n";
    let mut shown = 0;
    let world = hands_off(text, 40, |world| shown += u32::from(world.snapshot().advice.is_some()));
    assert_eq!(shown, 0);
    let speed_mps = world.snapshot().ego.speed_mps;
    assert!((speed_mps - 4.0).abs() < 0.1, "{speed_mps} m/s of 4");
    // Once it is off, the advice is for the participant.
    let world = hands_off(text, 42, |_| ());
    assert_eq!(world.snapshot().advice.map(|advice| advice.target_mps), Some(4.0));
}

#[test]
fn a_request_to_take_over_from_a_system_that_is_off_is_noted_as_not_done() {
    let text = "policy = \"none\"\n[automation]\nsystem = \"lane-keeping\"\nstarts_on = false\n\
                [[event]]\nname = \"ask\"\ntrigger = { time_s = 1 }\nactions = [{ takeover_request = { lead_s = 7 } }]\n";
    let mut stages = Vec::new();
    hands_off(text, 2, |world| {
        stages.extend(world.events().iter().filter_map(|event| match event.kind {
            EventKind::Scripted { stage, .. } => Some(stage),
            _ => None,
        }));
    });
    let not_done = EventStage::NotDone(NotDone::AutomationOff);
    let expected = [EventStage::Armed, EventStage::Triggered, not_done, EventStage::Ended];
    assert_eq!(stages, expected);
}

#[test]
fn an_event_for_a_car_without_an_automation_is_refused() {
    let text =
        "[[event]]\nname = \"ask\"\ntrigger = { time_s = 1 }\nactions = [{ takeover_request = { lead_s = 7 } }]\n";
    let message = World::new(&scenario(text)).err().expect("no automation").to_string();
    assert!(message.contains("event \"ask\"") && message.contains("[automation]"), "{message}");
}
