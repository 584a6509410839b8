//! Events of scenarios: vehicles of the traffic brake, accelerate and change lanes at their triggers, texts appear, advice disappears; all is recorded
//! and replayed to the bit.

use crate::world::one_at_a_time;
use codrive::{
    controls::{Controls, Indicator, Selector, TaskButton},
    drive_loop::offline::OfflineDrive,
    record::{self, Table, TableReader},
    replay::Replay,
    scenario::{PlannedDrive, Scenario},
    sim::{Event, EventKind, EventStage, NotDone, World},
    traffic::VehicleId,
};

/// Gap to the leader, m, speeds of ego and leader, m/s, and whether the ego brakes, at a step's end.
type SeenStep = (f64, f64, f64, bool);

/// Drives a scenario by its simulated driver for `seconds`; `look` sees the world at each step's end. Returns the events of the scenario: number, vehicle,
/// tick, stage.
pub(crate) fn drive(
    scenario: &Scenario,
    seconds: f64,
    mut look: impl FnMut(&World),
) -> Vec<(u16, Option<u32>, u64, EventStage)> {
    let mut run = OfflineDrive::new(scenario, [0.0, f64::INFINITY]).unwrap_or_else(|error| panic!("{error}"));
    let mut seen = Vec::new();
    let steps = (seconds / 0.01).round() as usize;
    for k in 1..=steps {
        run.until(k as f64 * 0.01).expect("the traffic goes on");
        seen.extend(run.world().events().iter().filter_map(|Event { tick, kind }| match kind {
            EventKind::Scripted { event, vehicle, stage } => Some((*event, vehicle.map(|id| id.0), tick.0, *stage)),
            _ => None,
        }));
        if k % 10 == 0 {
            look(run.world());
        }
    }
    seen
}

pub(crate) fn scenario(text: &str) -> Scenario {
    Scenario::from_toml(text, "events.toml").unwrap_or_else(|fault| panic!("{fault}"))
}

pub(crate) const RING: &str =
    "traffic = \"native\"\nwarm_up_s = 60\nidm = { noise = 0 }\npolicy = \"none\"\ntrees = 0\n";

/// Returns a scenario with these events on the ring of 22 vehicles, with a traffic engine.
fn on_ring(traffic: &str, events: &str) -> Scenario {
    scenario(&format!("{}{events}", RING.replace("native", traffic)))
}

/// Returns the speed of a vehicle, m/s.
fn speed_mps(world: &World, id: u32) -> f64 {
    world.snapshot().vehicle(VehicleId(id)).expect("on the ring").speed_mps
}

#[test]
fn the_leader_brakes_evenly_stands_and_drives_on() {
    let _alone = one_at_a_time();
    // On the ring with even gaps after a minute all have the same speed: 3.7 m/s or so. It brakes with 2 m/s² and stands for 3 s.
    let text = "[[event]]\nname = \"stop\"\ntrigger = { time_s = 2 }\nactions = [{ brake = { vehicle = \"leader\", decel_mps2 = 2, keep_s = 3 } }]\n";
    for traffic in ["native", "sumo"] {
        let mut speeds = Vec::new();
        let stages = drive(&on_ring(traffic, text), 12.0, |world| speeds.push(speed_mps(world, 1)));
        let [
            (0, None, 0, EventStage::Armed),
            (0, None, 200, EventStage::Triggered),
            (0, Some(1), 201, EventStage::Onset),
            (0, None, end, EventStage::Ended),
        ] = stages[..]
        else {
            panic!("{traffic}: {stages:?}")
        };
        let before_mps = speeds[19];
        assert!(before_mps > 2.0, "{traffic}: {before_mps}");
        // Steps of 0.1 s: 0.2 m/s less in each.
        for k in 1..=5 {
            assert!((speeds[19 + k] - (before_mps - 0.2 * k as f64)).abs() < 1e-9, "{traffic}, step {k}: {speeds:?}");
        }
        let braking_steps = (before_mps / 0.2).ceil() as u64;
        assert_eq!(end, 200 + 10 * braking_steps + 300, "{traffic}: it stands for 3 s from the end of braking on");
        let standing = speeds[19..].iter().filter(|speed| **speed == 0.0).count();
        assert!((30..=32).contains(&standing), "{traffic}: {standing} steps");
        assert!(*speeds.last().expect("speeds") > 0.5, "{traffic}: {speeds:?}");
    }
}

#[test]
fn a_vehicle_is_given_back_after_each_action_on_a_ring() {
    let _alone = one_at_a_time();
    // The native engine forgets each motion after its step. In SUMO a speed stands until it is taken back. Vehicle 5 acts twice, and in the end the
    // traffic brakes for a pedestrian. Both engines have the same models. The follower of an ego differs by 4.3 mm/s at most (docs/decisions.md: 4),
    // which the wave amplifies; what remains of an action would be some m/s.
    let event = |at_s: f64, action: &str| {
        format!("[[event]]\nname = \"at {at_s}\"\ntrigger = {{ time_s = {at_s} }}\nactions = [{{ {action} }}]\n")
    };
    let text = event(1.0, "brake = { vehicle = \"5\", decel_mps2 = 3, to_mps = 2, keep_s = 1 }")
        + &event(1.5, "keep_speed = { vehicle = \"follower\", for_s = 3 }")
        + &event(2.0, "accelerate = { vehicle = \"12\", accel_mps2 = 1, to_mps = 4, keep_s = 1 }")
        + &event(8.0, "break_down = { vehicle = \"5\", decel_mps2 = 3, for_s = 2 }")
        + &event(14.0, "pedestrian_crosses = { place_m = 150, from = \"right\" }");
    let speeds = ["native", "sumo"].map(|traffic| {
        let mut speeds: Vec<Vec<f64>> = Vec::new();
        let stages = drive(&on_ring(traffic, &text), 40.0, |world| {
            speeds.push(world.snapshot().vehicles().map(|car| car.speed_mps).collect());
        });
        let ended = stages.iter().filter(|stage| stage.3 == EventStage::Ended).count();
        assert_eq!(ended, 5, "{traffic}: {stages:?}");
        speeds
    });
    for (k, [native, sumo]) in speeds[0].iter().zip(&speeds[1]).map(|(a, b)| [a, b]).enumerate() {
        assert_eq!((native.len(), sumo.len()), (21, 21));
        let apart = native.iter().zip(sumo).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 0.1, "step {k}: {apart} m/s\n{native:?}\n{sumo:?}");
    }
}

#[test]
fn the_follower_accelerates_only_as_far_as_the_ego_allows() {
    let text = format!(
        "{RING}[[event]]\nname = \"push\"\ntrigger = {{ time_s = 1 }}\nactions = [{{ accelerate = {{ vehicle = \"follower\", accel_mps2 = 3, to_mps = 20, keep_s = 1 }} }}]\n"
    );
    let mut fastest_mps = 0.0_f64;
    let stages = drive(&scenario(&text), 20.0, |world| {
        fastest_mps = fastest_mps.max(speed_mps(world, 21));
        let (ego, behind) = (world.snapshot(), world.snapshot().vehicle(VehicleId(21)).expect("on the ring"));
        let gap_m = (ego.ego_s_m - behind.s_m.expect("on the ring")).rem_euclid(world.map().route.length_m()) - 5.0;
        assert!(gap_m > 0.2, "{gap_m} m behind the ego");
    });
    assert_eq!(stages[2], (0, Some(21), 101, EventStage::Onset));
    assert!(fastest_mps > 3.8, "{fastest_mps}: faster than all others");
    assert_eq!(stages.len(), 3, "20 m/s are never reached: {stages:?}");
}

#[test]
fn events_follow_each_other_repeat_and_are_drawn_by_chance() {
    let word = |name: &str, rest: &str| {
        format!(
            "[[event]]\nname = \"{name}\"\nactions = [{{ message = {{ text = \"{name}\", for_s = 0.5 }} }}]\n{rest}\n"
        )
    };
    let text = RING.to_owned()
        + &word("first", "trigger = { any = [{ time_s = 1 }, { speed_above_mps = 60 }] }")
        + &word("second", "trigger = { after = { event = \"first\", delay_s = 0.7 } }")
        + &word("never", "trigger = { all = [{ time_s = 1 }, { speed_above_mps = 60 }] }")
        + &word("unlikely", "trigger = { time_s = 1 }\nprobability = 0")
        + &word("lap", "trigger = { place_m = 100 }\nrepeats = true");
    let mut shown = Vec::new();
    let mut laps = 0;
    let mut before_m = f64::INFINITY;
    let stages = drive(&scenario(&text), 150.0, |world| {
        shown.push(world.snapshot().message.clone());
        let here_m = world.snapshot().ego_s_m;
        laps += usize::from(before_m < 100.0 && here_m >= 100.0);
        before_m = here_m;
    });
    let of = |event: u16| {
        stages.iter().filter(move |stage| stage.0 == event).map(|stage| (stage.2, stage.3)).collect::<Vec<_>>()
    };
    use EventStage::{Armed, Ended, NotDone as Not, Onset, Triggered};
    assert_eq!(of(0), [(0, Armed), (100, Triggered), (101, Onset), (150, Ended)]);
    assert_eq!(of(1), [(0, Armed), (220, Triggered), (221, Onset), (270, Ended)]);
    assert_eq!(of(2), [(0, Armed)]);
    assert_eq!(of(3), [(0, Armed), (100, Not(NotDone::ByChance))]);
    let lap: Vec<_> = of(4).into_iter().map(|(_, stage)| stage).collect();
    let each: Vec<_> = std::iter::repeat_n([Triggered, Onset, Ended, Armed], laps).flatten().collect();
    assert!(laps >= 2 && lap == [vec![Armed], each].concat(), "{laps} laps: {lap:?}");
    // Steps end at 0.1 s, 0.2 s, …: the text is there from 1.01 to 1.5 s.
    let texts =
        |range: std::ops::Range<usize>| shown[range].iter().filter(|text| text.as_deref() == Some("first")).count();
    assert_eq!([texts(0..10), texts(10..15), texts(15..40)], [0, 5, 0]);
}

#[test]
fn triggers_on_speeds_gaps_and_the_brake_come_true_at_their_step() {
    let word = |name: &str, trigger: &str| {
        format!("[[event]]\nname = \"{name}\"\ntrigger = {trigger}\nactions = [{{ hide_advice = {{ for_s = 1 }} }}]\n")
    };
    let text = format!("{RING}vehicles = 12\nduration_s = 60\n")
        + "[[event]]\nname = \"stop\"\ntrigger = { time_s = 5 }\nactions = [{ brake = { vehicle = \"leader\", decel_mps2 = 5 } }]\n"
        + &word("collision", "{ time_to_collision = { to = \"leader\", below_s = 4 } }")
        + &word("gap", "{ all = [{ time_s = 5 }, { time_gap = { to = \"leader\", below_s = 2.1 } }] }")
        + &word("slow", "{ all = [{ time_s = 5 }, { speed_below_mps = 5 }] }")
        + &word("brakes", "{ all = [{ time_s = 5 }, { pressed = \"brake\" }] }");
    let mut seen: Vec<SeenStep> = Vec::new();
    let stages = drive(&scenario(&text), 20.0, |world| {
        let view = world.snapshot();
        let leader = view.leader.expect("a leader");
        seen.push((leader.gap_m, view.ego.speed_mps, leader.speed_mps, view.ego.braking));
    });
    let first = |holds: &dyn Fn(&SeenStep) -> bool, from: usize| {
        let at = seen.iter().skip(from).position(holds).expect("it comes true");
        // The steps end at 0.1 s, 0.2 s, ...
        10 * (from + at + 1) as u64
    };
    let expected = [
        first(&|(gap_m, own, leader, _)| gap_m / (own - leader) < 4.0 && own > leader, 0),
        first(&|(gap_m, own, ..)| gap_m / own < 2.1, 49),
        first(&|(_, own, ..)| *own < 5.0, 49),
        first(&|(.., braking)| *braking, 49),
    ];
    assert!(expected.iter().all(|tick| (500..1500).contains(tick)), "all by the leader's stop: {expected:?}");
    for (event, tick) in (1..).zip(expected) {
        assert!(stages.contains(&(event, None, tick, EventStage::Triggered)), "{event} at {tick}: {stages:?}");
    }
}

#[test]
fn each_input_of_the_driver_triggers_its_event() {
    let inputs = ["accelerator", "brake", "respond", "indicator_left", "indicator_right", "main_beam"];
    let event = |input| format!("[[event]]\nname = \"{input}\"\ntrigger = {{ pressed = \"{input}\" }}\nactions = []\n");
    let mut world = World::new(&scenario(&(RING.to_owned() + &inputs.map(event).concat()))).expect("a world");
    let mut begun = Vec::new();
    let rest = Controls { selector: Selector::Drive, ..Controls::default() };
    for tick in 1..=720 {
        // Each input for one tick, 0.05 s after the full second.
        let given = match tick {
            105 => Controls { throttle: 0.5, ..rest },
            205 => Controls { brake: 0.5, ..rest },
            305 => Controls { task_button: TaskButton::Respond, ..rest },
            405 => Controls { indicator: Indicator::Left, ..rest },
            505 => Controls { indicator: Indicator::Right, ..rest },
            605 => Controls { main_beam: true, ..rest },
            _ => rest,
        };
        world.tick(&given).expect("the native engine");
        begun.extend(world.events().iter().filter_map(|event| match event.kind {
            EventKind::Scripted { event: number, stage: EventStage::Triggered, .. } => Some((number, event.tick.0)),
            _ => None,
        }));
    }
    // Where the next step of 0.1 s begins.
    assert_eq!(begun, [(0, 110), (1, 210), (2, 310), (3, 410), (4, 510), (5, 610)]);
}

#[test]
fn an_event_begins_at_each_new_advice() {
    let text = RING.replace("policy = \"none\"", "policy = \"ring-250-speed\"")
        + "[[event]]\nname = \"new\"\ntrigger = \"advice_changes\"\nrepeats = true\nactions = []\n";
    let mut targets = Vec::new();
    let stages =
        drive(&scenario(&text), 30.0, |world| targets.push(world.snapshot().advice.map(|advice| advice.target_mps)));
    let begun: Vec<u64> = stages.iter().filter(|stage| stage.3 == EventStage::Triggered).map(|stage| stage.2).collect();
    // Steps end at 0.1 s, 0.2 s, …; an advice of the step that ends is seen where the next one begins, at the same tick.
    let changes = (1..targets.len()).filter(|k| targets[*k].is_some() && targets[*k] != targets[k - 1]);
    let expected: Vec<u64> = changes.map(|k| 10 * (k as u64 + 1)).filter(|tick| *tick < 3000).collect();
    assert!(expected.len() > 5, "{targets:?}");
    let late: Vec<u64> = begun.into_iter().filter(|tick| *tick > 20).collect();
    assert_eq!(late, expected.into_iter().filter(|tick| *tick > 20).collect::<Vec<_>>());
}

#[test]
fn hidden_advice_appears_again() {
    let text = format!(
        "{}policy = \"constant\"\npolicy_speed_mps = 4\n[[event]]\nname = \"hide\"\ntrigger = {{ time_s = 5 }}\nactions = [{{ hide_advice = {{ for_s = 2 }} }}]\n",
        RING.replace("policy = \"none\"\n", "")
    );
    let mut advised = Vec::new();
    drive(&scenario(&text), 10.0, |world| advised.push(world.snapshot().advice.map(|advice| advice.target_mps)));
    assert_eq!([advised[48], advised[52], advised[68], advised[72]], [Some(4.0), None, None, Some(4.0)]);
}

#[test]
fn an_event_without_its_vehicle_is_recorded_as_not_done() {
    // On a ring no vehicle is in a lane to the left.
    let text = format!(
        "{RING}[[event]]\nname = \"ghost\"\ntrigger = {{ time_s = 1 }}\nactions = [{{ brake = {{ vehicle = \"left_leader\", decel_mps2 = 2 }} }}]\n\
         [[event]]\nname = \"one\"\ntrigger = {{ time_s = 2 }}\nactions = [{{ brake = {{ vehicle = \"5\", decel_mps2 = 2, keep_s = 5 }} }}]\n\
         [[event]]\nname = \"two\"\ntrigger = {{ time_s = 3 }}\nactions = [{{ brake = {{ vehicle = \"5\", decel_mps2 = 2 }} }}]\n"
    );
    let stages = drive(&scenario(&text), 4.0, |_| ());
    assert!(stages.contains(&(0, None, 100, EventStage::NotDone(NotDone::NoVehicle))), "{stages:?}");
    assert!(stages.contains(&(2, Some(5), 300, EventStage::NotDone(NotDone::OtherEvent))), "{stages:?}");
}

#[test]
fn what_cannot_happen_on_a_road_is_said_before_the_drive() {
    let fault = |trigger: &str, action: &str| {
        let text = format!("{RING}[[event]]\nname = \"e\"\ntrigger = {trigger}\nactions = [{action}]\n");
        PlannedDrive::new(&scenario(&text)).map(drop).expect_err("it cannot happen").to_string()
    };
    let word = "{ message = { text = \"a\", for_s = 1 } }";
    assert!(fault("{ time_s = 400 }", word).contains("can never begin: time_s is 400, and the drive ends at 300 s"));
    assert!(fault("{ edge = { id = \"nowhere\" } }", word).contains("the network has no edge \"nowhere\""));
    let signal = "{ signal_ahead = { light = \"red\", below_m = 50 } }";
    assert!(fault(signal, word).contains("can never begin: signal_ahead, and the road has no signals"));
    assert!(fault("{ place_m = 260 }", word).contains("place_m is 260, and the route is 250.0 m long"));
    let lane = fault("{ time_s = 1 }", "{ change_lane = { vehicle = \"leader\", to_the_left = 1 } }");
    assert!(lane.contains("change_lane; allowed: on a network"), "{lane}");
    let light = fault("{ time_s = 1 }", "{ signal_ahead = { light = \"red\" } }");
    assert!(light.contains("signal_ahead; the road has no signals"), "{light}");
}

#[test]
fn a_vehicle_that_cannot_be_there_is_said_before_the_drive() {
    let fault = |road: &str, trigger: &str, action: &str| {
        let text = format!("{road}[[event]]\nname = \"x\"\ntrigger = {trigger}\nactions = [{action}]\n");
        PlannedDrive::new(&scenario(&text)).map(drop).map_err(|error| error.to_string())
    };
    let brake = |vehicle: &str| format!("{{ brake = {{ vehicle = \"{vehicle}\", decel_mps2 = 3 }} }}");
    let (at_2_s, word) = ("{ time_s = 2 }", "{ message = { text = \"a\", for_s = 1 } }");
    let typo = fault(RING, at_2_s, &brake("leadr")).expect_err("no such vehicle");
    assert_eq!(
        typo,
        "event \"x\": brake: no vehicle of this drive can be \"leadr\" (did you mean leader?); allowed: leader, follower, left_leader, \
         right_leader, the number of another vehicle, 1 to 21"
    );
    // The last of 22 vehicles has number 21.
    assert_eq!([fault(RING, at_2_s, &brake("21")), fault(RING, at_2_s, &brake("right_leader"))], [Ok(()), Ok(())]);
    assert!(fault(RING, at_2_s, &brake("22")).is_err_and(|fault| fault.contains("can be \"22\"; allowed:")));
    assert!(fault(RING, at_2_s, &brake("ego")).is_err_and(|fault| fault.contains("can be \"ego\"")));
    let near = |to: &str| format!("{{ all = [{{ time_s = 1 }}, {{ distance = {{ to = \"{to}\", below_m = 9 }} }}] }}");
    let trigger = fault(RING, &near("lader"), word).expect_err("no such vehicle");
    assert!(
        trigger.contains("event \"x\": trigger: no vehicle of this drive can be \"lader\" (did you mean leader?)"),
        "{trigger}"
    );
    assert_eq!(fault(RING, &near("leader"), word), Ok(()));
    assert_eq!(fault(RING, "{ reaches = { vehicle = \"ego\", place_m = 9 } }", word), Ok(()));
    // The demand of the motorway is in a file, with a flow `lorries`.
    let motorway = "map = \"motorway\"\ntrees = 0\n[[road_user]]\nname = \"wreck\"\nplace_m = 40\n";
    for name in ["wreck", "7", "leader", "lorries.3"] {
        assert_eq!(fault(motorway, at_2_s, &brake(name)), Ok(()), "{name}");
    }
    let user = fault(motorway, at_2_s, &brake("wrek")).expect_err("no such vehicle");
    assert!(user.contains("\"wrek\" (did you mean wreck?); allowed: leader, follower, left_leader, right_leader, wreck, the number of a vehicle, its name in the demand"), "{user}");
    let lorry = fault(motorway, at_2_s, &brake("lories.3")).expect_err("no such flow");
    assert!(lorry.contains("(did you mean lorries.3?)"), "{lorry}");
    // Without a demand only road users are there.
    let empty = "map = \"lane-10km\"\npath = \"e0\"\ntrees = 0\n[[road_user]]\nname = \"wreck\"\nplace_m = 40\n";
    assert_eq!(fault(empty, at_2_s, &brake("wreck")), Ok(()));
    assert!(
        fault(empty, at_2_s, &brake("7"))
            .is_err_and(|fault| fault.ends_with("allowed: leader, follower, left_leader, right_leader, wreck"))
    );
}

#[test]
fn in_sumo_a_vehicle_brakes_harder_than_its_model_and_changes_lanes() {
    let _alone = one_at_a_time();
    let text = "map = \"motorway\"\npolicy = \"none\"\ntrees = 0\nwarm_up_s = 60\n\
         [[event]]\nname = \"brake\"\ntrigger = { all = [{ time_s = 1 }, { distance = { to = \"leader\", below_m = 500 } }] }\n\
         actions = [{ brake = { vehicle = \"leader\", decel_mps2 = 6, to_mps = 5, keep_s = 1 } }]\n\
         [[event]]\nname = \"aside\"\ntrigger = { after = { event = \"brake\" } }\n\
         actions = [{ change_lane = { vehicle = \"leader\", to_the_left = 1 } }, { message = { text = \"Mind the gap\", for_s = 2 } }]\n";
    let scenario = scenario(text);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("drive");
    let mut run = OfflineDrive::new(&scenario, [0.0, f64::INFINITY]).unwrap_or_else(|error| panic!("{error}"));
    run.record(&path).expect("a recording");
    let (mut speeds, mut lanes, mut acting) = (Vec::new(), Vec::new(), None);
    for k in 1..=400 {
        run.until(f64::from(k) * 0.1).expect("SUMO goes on");
        let world = run.world();
        let vehicle = acting.and_then(|id| world.snapshot().vehicle(id));
        speeds.extend(vehicle.map(|car| car.speed_mps));
        lanes.extend(vehicle.and_then(|car| car.lane).map(|at| at.lane));
        acting = acting.or_else(|| world.snapshot().leader.filter(|_| k >= 10).map(|leader| leader.id));
    }
    drop(run);
    record::recover(&path).expect("it is recovered");
    let events = TableReader::parquet(&Table::Events.parquet(&path)).expect("a table");
    let (kinds, details) = (events.words("event"), events.words("detail"));
    let of: Vec<(&str, &str)> = kinds
        .iter()
        .zip(&details)
        .filter(|(kind, _)| kind.starts_with("event_"))
        .map(|(a, b)| (a.as_str(), b.as_str()))
        .collect();
    assert_eq!(of[..2], [("event_armed", "brake"), ("event_armed", "aside")], "{of:?}");
    assert_eq!(of[2..5], [("event_triggered", "brake"), ("event_onset", "brake"), ("event_ended", "brake")], "{of:?}");
    assert_eq!(of[5..7], [("event_triggered", "aside"), ("event_onset", "aside")], "{of:?}");
    // 0.6 m/s less in each step of 0.1 s, though the model brakes with 1.5 m/s² when it is comfortable.
    let hardest = speeds.windows(2).map(|pair| pair[0] - pair[1]).fold(0.0, f64::max);
    assert!((hardest - 0.6).abs() < 1e-6, "{hardest}");
    assert!(speeds.iter().filter(|speed| (**speed - 5.0).abs() < 1e-6).count() >= 10, "a second at 5 m/s: {speeds:?}");
    // Its model would change lanes 2.4 s after the start.
    assert!(lanes[..40].iter().all(|lane| *lane == lanes[0]), "{lanes:?}");
    // Its own model accelerates with 1 m/s² or more afterwards.
    assert!(speeds.last().is_some_and(|speed| *speed > 15.0), "it drives on: {:?}", speeds.last());
    assert!(lanes.windows(2).any(|pair| pair[0] != pair[1]), "{lanes:?}");
    let mut replay = Replay::open(&path).expect("it can be driven");
    replay.advance(u64::MAX).expect("SUMO goes on");
    assert!(replay.report().is_proven() && replay.report().ticks == 4000, "{:?}", replay.report());
}
