//! Road users that a scenario places: the participant and the traffic see them, events move them, and all is recorded and replayed to the bit.

use crate::{people_of_events, world::one_at_a_time};
use codrive::{
    drive_loop::offline::OfflineDrive,
    record,
    replay::Replay,
    scenario::{PlannedDrive, Scenario},
    sim::{EndReason, EventKind, EventStage, World},
    traffic::{FIRST_OF_EVENTS, VehicleId},
};
use people_of_events::{contacts, drive, scenario};

/// A straight open lane of 3.6 m.
const LANE: &str = "map = \"lane-10km\"\npath = \"e0\"\npolicy = \"none\"\ntrees = 0\n";

fn on_lane(text: &str) -> Scenario {
    scenario(&format!("{LANE}{text}"))
}

#[test]
fn a_driver_stays_behind_a_road_user_that_an_event_stops() {
    let _alone = one_at_a_time();
    let text = "start_speed_mps = 15\npath_start_m = 20\n\
        [[road_user]]\nname = \"van\"\nkind = \"van\"\nplace_m = 70\nspeed_mps = 15\n\
        [[event]]\nname = \"stops\"\ntrigger = { time_s = 5 }\nactions = [{ speed = { vehicle = \"van\", to_mps = 0, rate_mps2 = 3 } }]\n\
        [[event]]\nname = \"goes on\"\ntrigger = { after = { event = \"stops\", delay_s = 5 } }\nactions = [{ accelerate = { vehicle = \"leader\", accel_mps2 = 2, to_mps = 10 } }]\n";
    let (mut least_m, mut slowest_mps, mut first) = (f64::INFINITY, f64::INFINITY, None);
    let events = drive(&on_lane(text), 25.0, |world| {
        let view = world.snapshot();
        let leader = view.leader.expect("the van is ahead");
        assert_eq!(leader.id, FIRST_OF_EVENTS);
        first.get_or_insert((leader.gap_m, view.ego.speed_mps));
        (least_m, slowest_mps) = (least_m.min(leader.gap_m), slowest_mps.min(view.ego.speed_mps));
    });
    // A van is 6.5 m long: 70 - 6.5 - 20 = 43.5 m at the start, where both drive 15 m/s.
    let (gap_m, speed_mps) = first.expect("steps");
    assert!((gap_m - 43.5).abs() < 0.5 && (speed_mps - 15.0).abs() < 1.0, "{gap_m} m at {speed_mps} m/s");
    assert!(contacts(&events) == 0 && least_m > 0.5 && slowest_mps < 0.5, "{least_m} m, {slowest_mps} m/s");
    let stages: Vec<_> = events
        .iter()
        .filter_map(|event| match event.kind {
            EventKind::Scripted { event: number, vehicle, stage } => Some((number, event.tick.0, vehicle, stage)),
            _ => None,
        })
        .collect();
    // From 15 m/s to 0 with 3 m/s2: 5 s, then 5 s of delay, then 5 s to 10 m/s with 2 m/s2.
    let van = Some(FIRST_OF_EVENTS);
    let expected = [
        (0, 500, None, EventStage::Triggered),
        (0, 501, van, EventStage::Onset),
        (0, 1000, None, EventStage::Ended),
        (1, 1500, None, EventStage::Triggered),
        (1, 1501, van, EventStage::Onset),
        (1, 2000, None, EventStage::Ended),
    ];
    let scripted: Vec<_> = stages.into_iter().filter(|stage| expected.iter().any(|known| known.3 == stage.3)).collect();
    assert_eq!(scripted, expected);
}

#[test]
fn a_driver_stops_for_a_road_user_where_the_path_changes_lanes() {
    let _alone = one_at_a_time();
    // Right at B1 from the outer lane, left at C1 from the inner one: the path changes lanes on B1C1, from 90 m to 159 m of the route. It is driven
    // from the outer lane into the inner one, whose middle is the route's there.
    let road =
        "map = \"tests/data/networks/grid-signals.net.xml\"\npath = \"B0B1 B1C1 C1C2\"\npolicy = \"none\"\ntrees = 0\n";
    let users = [
        // A car stands in the lane into which the path changes, and in the one from which it does; one stands across both.
        ("kind = \"car\"\nplace_m = 130\n", ""),
        ("kind = \"car\"\nplace_m = 112\nlanes_left = -1\n", ""),
        ("kind = \"car\"\nplace_m = 130\n", "walk = { vehicle = \"it\", points = [[130, -3], [130, -1]] }"),
        ("kind = \"pedestrian\"\nplace_m = 112\nlanes_left = -1\n", ""),
    ];
    for (user, action) in users {
        let acts = match action {
            "" => String::new(),
            _ => format!("[[event]]\nname = \"x\"\ntrigger = {{ time_s = 0.1 }}\nactions = [{{ {action} }}]\n"),
        };
        let text = format!("{road}[[road_user]]\nname = \"it\"\n{user}{acts}");
        let mut ends = (0.0, 0.0);
        let events = drive(&scenario(&text), 60.0, |world| {
            ends = (world.snapshot().ego_s_m, world.snapshot().ego.speed_mps);
        });
        assert_eq!(contacts(&events), 0, "{text}");
        // It drives up to it, and waits there or passes in the other lane.
        assert!(ends.0 > 95.0, "{ends:?} {text}");
    }
}

#[test]
fn a_driver_brakes_for_what_crosses_and_for_nothing_that_does_not() {
    let _alone = one_at_a_time();
    // The ego starts at 100 m and is 22.9 m/s fast at 400 m.
    let crosses = |points: &str, speed_mps: f64| {
        format!(
            "path_start_m = 100\nduration_s = 40\n[[road_user]]\nname = \"it\"\nplace_m = 400\noffset_m = -50\nspeed_mps = {speed_mps}\n\
             [[event]]\nname = \"x\"\ntrigger = {{ place_m = 270 }}\nactions = [{{ walk = {{ vehicle = \"it\", points = [{points}] }} }}]\n"
        )
    };
    let standing = |rest: &str| {
        format!("path_start_m = 100\nduration_s = 40\n[[road_user]]\nname = \"it\"\nplace_m = 400\n{rest}\n")
    };
    let speeds_mps = |text: &str| {
        let mut speeds_mps = Vec::new();
        let events = drive(&on_lane(text), 40.0, |world| speeds_mps.push(world.snapshot().ego.speed_mps));
        assert_eq!(contacts(&events), 0, "{text}");
        speeds_mps
    };
    let undisturbed = speeds_mps(&standing("offset_m = -45"));
    let slower_mps = |speeds_mps: &[f64]| {
        undisturbed.iter().zip(speeds_mps).map(|(free, speed)| free - speed).fold(f64::NEG_INFINITY, f64::max)
    };
    // From the right and from the left at 8 m/s: when the ego would come, it is on the lane. Afterwards the ego drives on.
    for text in [crosses("[400, -50], [400, 50]", 8.0), crosses("[400, 50], [400, -50]", 8.0)] {
        let speeds = speeds_mps(&text);
        let last_mps = speeds.last().copied().unwrap_or_default();
        assert!(slower_mps(&speeds) > 3.0 && last_mps > 20.0, "{} {last_mps} {text}", slower_mps(&speeds));
    }
    // A pedestrian and a cyclist who are in view for long are not hit either: at 29 m/s the driver needs more than 100 m.
    for (kind, from_m, speed_mps) in [("pedestrian", 10.5, 1.4), ("bicycle", 37.5, 5.0), ("pedestrian", 0.0, 0.0)] {
        let text = format!(
            "path_start_m = 100\nduration_s = 40\n[[road_user]]\nname = \"it\"\nkind = \"{kind}\"\nplace_m = 800\noffset_m = {from_m}\nspeed_mps = {speed_mps}\n\
             [[event]]\nname = \"x\"\ntrigger = {{ place_m = 590 }}\nactions = [{{ walk = {{ vehicle = \"it\", points = [[800, {from_m}], [800, -60]] }} }}]\n"
        );
        let wet = format!("rain_mmph = 2\n{text}");
        for text in [text, wet] {
            // The run ends with a contact with a person.
            let speeds = speeds_mps(&text);
            assert!(slower_mps(&speeds) > 2.0, "{} {text}", slower_mps(&speeds));
        }
    }
    // The driver stops before one that stands across the lane.
    let speeds = speeds_mps(&crosses("[380, -1.5], [380, 0]", 0.0).replace("270", "110"));
    assert!(speeds.last().is_some_and(|last_mps| *last_mps < 0.1), "{speeds:?}");
    // The driver does not brake for what is over before the ego comes or comes after it, stands beside the road or passes in the other lane.
    let free = [
        crosses("[400, -20], [400, 80]", 20.0),
        crosses("[400, -50], [400, 50]", 2.0),
        crosses("[400, -50], [400, -10]", 1.0),
        standing("offset_m = -5"),
        standing("lanes_left = 1\nagainst = true\nspeed_mps = 15"),
    ];
    for text in free {
        let slower_mps = slower_mps(&speeds_mps(&text));
        assert!(slower_mps < 0.5, "{slower_mps} {text}");
    }
}

#[test]
fn traffic_of_sumo_stops_behind_a_road_user() {
    let _alone = one_at_a_time();
    let text = "[[road_user]]\nname = \"wreck\"\nplace_m = 600\n\
        [demand]\n[[demand.flows]]\nfrom = \"e0\"\nto = \"e0\"\nper_hour = 400\n";
    let scenario = Scenario { participant: false, ..on_lane(text) };
    let (mut stopped, mut nearest_m) = (0, f64::INFINITY);
    let mut world = World::new(&scenario).unwrap_or_else(|error| panic!("{error}"));
    for _ in 0..900 {
        world.step().expect("the traffic goes on");
        let view = world.snapshot();
        let wreck = view.vehicle(FIRST_OF_EVENTS).expect("it stands");
        assert_eq!(wreck.speed_mps, 0.0);
        let behind = view.vehicles().filter(|car| car.id != FIRST_OF_EVENTS);
        let gaps = behind.map(|car| {
            (car.pose.rear(-car.body.length_m).distance(wreck.pose.rear(wreck.body.length_m)), car.speed_mps)
        });
        for (gap_m, speed_mps) in gaps {
            nearest_m = nearest_m.min(gap_m);
            stopped += usize::from(speed_mps < 0.1 && gap_m < 12.0);
        }
    }
    assert!(stopped > 50 && nearest_m > 0.5, "{stopped} steps of standstill, {nearest_m} m");
}

#[test]
fn a_parked_car_pulls_out_and_an_oncoming_one_passes() {
    let _alone = one_at_a_time();
    let text = "participant = false\n\
        [[road_user]]\nname = \"parked\"\nplace_m = 100\noffset_m = -3\n\
        [[road_user]]\nname = \"oncoming\"\nplace_m = 300\nlanes_left = 1\nagainst = true\nspeed_mps = 10\n\
        [[event]]\nname = \"pulls out\"\ntrigger = { reaches = { vehicle = \"oncoming\", place_m = 200 } }\ndelay_s = 2\n\
        actions = [{ offset = { vehicle = \"parked\", to_m = 0, in_s = 4 } }, { speed = { vehicle = \"parked\", to_mps = 8, in_s = 4 } }]\n";
    let mut world = World::new(&on_lane(text)).unwrap_or_else(|error| panic!("{error}"));
    let [parked, oncoming] = [FIRST_OF_EVENTS, VehicleId(FIRST_OF_EVENTS.0 + 1)];
    let beside_m = |world: &World, id| {
        let car = *world.snapshot().vehicle(id).expect("placed");
        let at = world.map().route.project(car.pose.front(car.body.length_m), None);
        (at.s_m, at.offset_m, car)
    };
    // 10 m/s for 100 m, 2 s, and half of 4 s.
    for _ in 0..140 {
        world.step().expect("the traffic goes on");
    }
    let (s_m, offset_m, car) = beside_m(&world, oncoming);
    assert!((s_m - 160.0).abs() < 0.1 && (offset_m - 3.6).abs() < 0.1, "{s_m} {offset_m}");
    assert!(car.s_m.is_none() && car.pose.forward().x < -0.99, "it drives against the path: {:?}", car.pose);
    let (s_m, _, car) = beside_m(&world, parked);
    // Half of the way aside in half of the time, turned to the left; 4 m/s, 4 m further.
    let axle_m = world.map().route.project(car.pose.position - car.pose.forward() * 1.4, None).offset_m;
    assert!((axle_m + 1.5).abs() < 0.15 && (s_m - 104.0).abs() < 0.3, "{axle_m} {s_m}");
    assert!((car.speed_mps - 4.0).abs() < 0.1 && car.pose.forward().y > 0.1, "{:?}", car.pose);
    for _ in 0..30 {
        world.step().expect("the traffic goes on");
    }
    let (_, offset_m, car) = beside_m(&world, parked);

    assert!(offset_m.abs() < 1e-6 && car.speed_mps == 8.0 && car.s_m.is_some(), "{offset_m} {}", car.speed_mps);
    // The oncoming one is at the path's begin after 30 s, and stands there.
    for _ in 0..200 {
        world.step().expect("the traffic goes on");
    }
    let (_, _, car) = beside_m(&world, oncoming);
    let axle_m = car.pose.position.x + 0.28 * car.body.length_m;
    assert!(car.speed_mps == 0.0 && axle_m.abs() < 0.05, "{axle_m}");
}

#[test]
fn a_drive_with_road_users_is_replayed_to_the_bit_and_ended_by_an_event() {
    let _alone = one_at_a_time();
    let text = "start_speed_mps = 12\n\
        [[road_user]]\nname = \"walker\"\nkind = \"pedestrian\"\nplace_m = 90\noffset_m = -4\n\
        [[road_user]]\nname = \"car\"\nplace_m = 40\nspeed_mps = 12\n\
        [[event]]\nname = \"walks\"\ntrigger = { distance = { of = \"car\", to = \"walker\", below_m = 30 } }\n\
        actions = [{ speed = { vehicle = \"walker\", to_mps = 1.5, rate_mps2 = 2 } }, { walk = { vehicle = \"walker\", points = [[90, -4], [90, 4], [110, 4]] } }]\n\
        [[event]]\nname = \"gives way\"\ntrigger = { time_to_collision = { of = \"car\", to = \"walker\", below_s = 2 } }\nactions = [{ speed = { vehicle = \"car\", to_mps = 0, in_m = 15, shape = \"sinusoidal\" } }]\n\
        [[event]]\nname = \"over\"\ntrigger = { driven = { vehicle = \"walker\", above_m = 8 } }\nactions = [\"end_drive\"]\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("drive");
    let mut run = OfflineDrive::new(&on_lane(text), [0.0, f64::INFINITY]).unwrap_or_else(|error| panic!("{error}"));
    run.record(&path).expect("a recording");
    run.until(60.0).expect("the drive goes on");
    assert_eq!(run.world().ended(), Some(EndReason::Event));
    let walker = *run.world().snapshot().vehicle(FIRST_OF_EVENTS).expect("the walker");
    let ticks = run.world().snapshot().tick.0;
    drop(run);
    assert!(walker.is_person() && (walker.odometer_m - 8.0).abs() < 0.2, "{}", walker.odometer_m);
    record::recover(&path).expect("it is recovered");
    let mut replay = Replay::open(&path).expect("it can be driven");
    replay.advance(u64::MAX).expect("the drive goes on");
    assert!(replay.report().is_proven() && replay.report().ticks == ticks, "{:?}", replay.report());
}

#[test]
fn road_users_that_cannot_be_are_faults_with_line_and_remedy() {
    let fault = |text: &str| {
        let read = Scenario::from_toml(&format!("{LANE}{text}"), "trial.toml");
        let planned = read
            .map_err(|fault| fault.to_string())
            .and_then(|scenario| PlannedDrive::new(&scenario).map(drop).map_err(|error| error.to_string()));
        planned.expect_err("a fault")
    };
    let user = "[[road_user]]\nname = \"van\"\nplace_m = 70\n";
    let event =
        |action: &str| format!("{user}[[event]]\nname = \"a\"\ntrigger = {{ time_s = 1 }}\nactions = [{action}]\n");
    for (text, words) in [
        (user.replace("70", "1001"), ["place_m is 1001", "1000.0 m long"]),
        (user.replace("van", "leader"), ["trial.toml:6", "a name other than a number"]),
        (user.to_owned() + "speed_mps = 71\n", ["trial.toml:8", "speed_mps is 71; allowed: 0 to 70"]),
        (event("{ speed = { vehicle = \"vam\", to_mps = 3 } }"), ["trial.toml:11", "did you mean van"]),
        (event("{ speed = { vehicle = \"van\", like = \"leader\" } }"), ["trial.toml:11", "allowed: ego, van"]),
        (event("{ cut_in = { vehicle = \"van\", gap_m = 0 } }"), ["trial.toml:11", "gap_m is 0; allowed: 0.5 to 200"]),
        (event("{ signal = { name = \"5\", light = \"red\" } }"), ["the network has no signal \"5\"", "event \"a\""]),
    ] {
        let fault = fault(&text);
        assert!(words.iter().all(|word| fault.contains(word)), "{text}: {fault}");
    }
    let ring = Scenario::from_toml("[[road_user]]\nname = \"van\"\nplace_m = 70\n", "trial.toml").expect("settings");
    let fault = PlannedDrive::new(&ring).map(drop).expect_err("a ring").to_string();
    assert!(
        fault.contains("a closed route is full of its own vehicles") && fault.contains("remedy: a path"),
        "{fault}"
    );
}

#[test]
fn triggers_hold_for_their_time_and_events_repeat_so_often() {
    let _alone = one_at_a_time();
    let mark = |name: &str, rest: &str| format!("[[event]]\nname = \"{name}\"\nactions = []\n{rest}\n");
    let text = "participant = false\n[[road_user]]\nname = \"car\"\nplace_m = 100\nspeed_mps = 10\n\
        [[event]]\nname = \"brakes\"\ntrigger = { time_s = 2 }\nactions = [{ speed = { vehicle = \"car\", to_mps = 4, rate_mps2 = 3 } }]\n\
        [[event]]\nname = \"aside\"\ntrigger = { time_s = 6 }\nactions = [{ offset = { vehicle = \"car\", to_m = -5, in_s = 2, shape = \"linear\" } }]\n\
        [[event]]\nname = \"back\"\ntrigger = { reaches = { vehicle = \"car\", place_m = 160 } }\nrepeats = true\nmost_times = 2\n\
        actions = [{ teleport = { vehicle = \"car\", place_m = 100 } }]\n"
        .to_owned()
        + &mark("hard", "trigger = { acceleration = { vehicle = \"car\", below_mps2 = -2 } }\nholds_s = 0.5")
        + &mark("too long", "trigger = { acceleration = { vehicle = \"car\", below_mps2 = -2 } }\nholds_s = 3")
        + &mark("off", "trigger = { off_road = { vehicle = \"car\" } }\nholds_s = 1\ndelay_s = 2")
        + &mark("each", "trigger = { begun = { event = \"back\" } }\nrepeats = true")
        + &mark("twice", "trigger = { after = { event = \"back\", times = 2 } }");
    let mut world = World::new(&on_lane(&text)).unwrap_or_else(|error| panic!("{error}"));
    let (mut begun, mut places_m) = (Vec::new(), Vec::new());
    for _ in 0..450 {
        world.step().expect("the traffic goes on");
        begun.extend(world.events().iter().filter_map(|event| match event.kind {
            EventKind::Scripted { event: number, stage: EventStage::Triggered, .. } => Some((number, event.tick.0)),
            _ => None,
        }));
        let car = world.snapshot().vehicle(FIRST_OF_EVENTS).expect("placed");
        places_m.push(world.map().route.project(car.pose.front(car.body.length_m), None).s_m);
    }
    let of = |number: u16| begun.iter().filter(|event| event.0 == number).map(|event| event.1).collect::<Vec<_>>();
    // It brakes from 2 to 4 s, which is seen a step later. From 134 m on it drives 4 m/s: 6.5 s to 160 m, and 15 s from 100 m.
    assert_eq!([of(0), of(1), of(2)], [vec![200], vec![600], vec![1050, 2550]]);
    assert_eq!([of(3), of(4)], [vec![260], vec![]]);
    // Off the lane of 3.6 m and its shoulder of 0.4 m from 2.2 m on: 0.88 s after the begin, and at the next step. It holds for 1 s.
    assert_eq!(of(5), [690 + 100 + 200]);
    assert_eq!(
        [of(6), of(7)],
        [vec![1050, 2550], vec![2570]],
        "the end of an event is seen in the second step after its begin"
    );
    // A third time it goes on.
    assert!(places_m[104] > 159.0 && places_m[105] < 101.0 && places_m[449] > 170.0, "{places_m:?}");
}

#[test]
fn a_road_user_cuts_in_at_the_gap_that_is_stated() {
    let _alone = one_at_a_time();
    let text = "start_speed_mps = 15\npath_start_m = 20\n\
        [[road_user]]\nname = \"passer\"\nplace_m = 15\nlanes_left = 1\nspeed_mps = 17\n\
        [[event]]\nname = \"cuts in\"\ntrigger = { time_s = 1 }\nactions = [{ cut_in = { vehicle = \"passer\", gap_m = 9, within_s = 20 } }]\n";
    let (mut at_change, mut in_lane) = (None, None);
    let events = drive(&on_lane(text), 30.0, |world| {
        let view = world.snapshot();
        let car = *view.vehicle(FIRST_OF_EVENTS).expect("placed");
        let at = world.map().route.project(car.pose.position, None);
        let gap_m = at.s_m - car.body.length_m / 2.0 - view.ego_s_m;
        if car.lamps.right {
            at_change.get_or_insert((gap_m, car.speed_mps - view.ego.speed_mps));
        }
        if at.offset_m.abs() < 0.1 {
            in_lane.get_or_insert((view.leader.map(|leader| leader.id), gap_m));
        }
    });
    // The controller begins within 1 m and 1 m/s of its place.
    let (gap_m, faster_mps) = at_change.expect("it indicates and changes lanes");
    assert!((gap_m - 9.0).abs() < 1.2 && faster_mps.abs() < 1.2, "{gap_m} m, {faster_mps} m/s");
    let (leader, gap_m) = in_lane.expect("it is in the lane");
    assert!(leader == Some(FIRST_OF_EVENTS) && gap_m > 3.0, "{leader:?} {gap_m}");
    assert_eq!(contacts(&events), 0);
}
