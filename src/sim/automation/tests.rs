//! Tests of the automation with perceptions and controls set by hand.

use super::*;
use crate::{driver::LaneView, scenario::Automation, time::TICK_S};

/// Automation with a road that goes straight at a limit of 20 m/s, and what it has noted.
struct Bench {
    run: AutomationRun,
    tick: u64,
    now: Perception,
    noted: Vec<(u64, AutomationChange)>,
    driven: Controls,
}

impl Bench {
    fn new(settings: Automation) -> Self {
        let run = AutomationRun::new(&settings, &CarParams::default()).expect("a driver").expect("a system");
        let now = Perception { speed_mps: 15.0, speed_limit_mps: 20.0, ..Perception::default() };
        Self { run, tick: 0, now, noted: Vec::new(), driven: Controls::default() }
    }

    fn of(system: AutomationSystem) -> Self {
        Self::new(Automation { system, ..Automation::default() })
    }

    /// Drives for a time with these controls of the participant.
    fn drive(&mut self, seconds: f64, given: Controls) {
        for _ in 0..(seconds / TICK_S).round() as u64 {
            self.tick += 1;
            let mut events = Vec::new();
            self.driven = self.run.tick(Tick(self.tick), &given, &self.now, &mut events);
            self.noted.extend(events.iter().filter_map(|event| match event.kind {
                EventKind::Automation(change) => Some((event.tick.0, change)),
                _ => None,
            }));
        }
    }

    fn mode(&self) -> AutomationMode {
        self.run.state(Tick(self.tick)).mode
    }

    /// Returns the last change.
    fn last(&self) -> AutomationChange {
        self.noted.last().expect("a change").1
    }
}

const REST: Controls = Controls {
    throttle: 0.0,
    brake: 0.0,
    steering_wheel_rad: 0.0,
    selector: Selector::Drive,
    indicator: crate::controls::Indicator::Off,
    main_beam: false,
    task_button: crate::controls::TaskButton::None,
    automation_button: false,
    gap_button: false,
    hand_torque_nm: None,
};
const PRESS: Controls = Controls { automation_button: true, ..REST };
const BRAKE: Controls = Controls { brake: 0.3, ..REST };
const GAS: Controls = Controls { throttle: 0.9, ..REST };

#[test]
fn each_system_moves_the_controls_of_its_level() {
    // SAE J3016: a sustained control of speed or steering is level 1, of both level 2 or more.
    for (system, level, [keeps_speed, steers]) in [
        (AutomationSystem::AdaptiveCruiseControl, 1, [true, false]),
        (AutomationSystem::LaneKeeping, 1, [false, true]),
        (AutomationSystem::CruiseAndLaneKeeping, 2, [true, true]),
        (AutomationSystem::TrafficJamPilot, 3, [true, true]),
        (AutomationSystem::Policy, 3, [true, true]),
    ] {
        let mut bench = Bench::of(system);
        // Slower than the limit, on a lane whose middle is 0.5 m to the left.
        let lane = LaneView { offset_m: -0.5, aim: glam::dvec2(15.0, 0.5), ..LaneView::default() };
        bench.now = Perception { speed_mps: 10.0, lane, ..bench.now };
        bench.drive(1.0, REST);
        let moved = [bench.driven.throttle > 0.05, bench.driven.steering_wheel_rad > 0.01];
        assert_eq!((system.level(), moved), (level, [keeps_speed, steers]), "{system:?}");
        assert_eq!(bench.noted, [(1, AutomationChange::On(SwitchedOnBy::Start))]);
    }
}

#[test]
fn the_button_switches_it_on_and_off() {
    let mut bench = Bench::new(Automation {
        system: AutomationSystem::CruiseAndLaneKeeping,
        starts_on: false,
        ..Automation::default()
    });
    bench.drive(1.0, GAS);
    assert_eq!((bench.mode(), bench.driven.throttle), (AutomationMode::Off, 0.9));
    bench.drive(TICK_S, PRESS);
    assert_eq!(bench.mode(), AutomationMode::On);
    bench.drive(1.0, REST);
    bench.drive(TICK_S, PRESS);
    assert_eq!((bench.mode(), bench.last()), (AutomationMode::Off, AutomationChange::Off(SwitchedOffBy::Button)));
    // With the foot on the brake or in reverse it stays off.
    bench.drive(TICK_S, Controls { brake: 0.3, ..PRESS });
    bench.drive(TICK_S, Controls { selector: Selector::Reverse, ..PRESS });
    assert_eq!((bench.mode(), bench.noted.len()), (AutomationMode::Off, 2));
}

#[test]
fn the_gap_button_sets_the_next_longer_gap_and_begins_again() {
    // ISO 15622: the shortest gap is 0.8 s or more, and one lies between 1.5 and 2.2 s.
    assert!(TIME_GAPS_S[0] >= 0.8 && TIME_GAPS_S.iter().any(|gap_s| (1.5..=2.2).contains(gap_s)));
    let press = Controls { gap_button: true, ..REST };
    for (from_s, set_s) in [(1.5, [2.0, 1.0, 1.5, 2.0]), (0.8, [1.0, 1.5, 2.0, 1.0]), (3.0, [1.0, 1.5, 2.0, 1.0])] {
        let system = AutomationSystem::AdaptiveCruiseControl;
        let mut bench =
            Bench::new(Automation { system, time_gap_s: from_s, starts_on: false, ..Automation::default() });
        for gap_s in set_s {
            bench.drive(TICK_S, press);
            bench.drive(0.1, REST);
            assert_eq!(bench.last(), AutomationChange::TimeGap { time_gap_s: gap_s }, "from {from_s} s");
            assert_eq!(bench.run.state(Tick(bench.tick)).time_gap_s, Some(gap_s));
        }
    }
    // The policy and lane keeping have no time gap.
    for system in [AutomationSystem::Policy, AutomationSystem::LaneKeeping] {
        let mut bench = Bench::of(system);
        bench.drive(TICK_S, press);
        assert_eq!((bench.noted.len(), bench.run.state(Tick(1)).time_gap_s), (1, None), "{system:?}");
    }
}

#[test]
fn a_longer_gap_that_was_set_makes_the_vehicle_fall_back() {
    // At 15 m/s and 1.5 s the gap is 2 + 22.5 m.
    let mut bench = Bench::of(AutomationSystem::AdaptiveCruiseControl);
    bench.now.leader = Some(crate::driver::SeenLeader { gap_m: 24.5, speed_mps: 15.0 });
    bench.drive(3.0, REST);
    let kept = bench.driven;
    bench.drive(TICK_S, Controls { gap_button: true, ..REST });
    bench.drive(3.0, REST);
    assert!(bench.driven.throttle < kept.throttle || bench.driven.brake > kept.brake, "{kept:?} {:?}", bench.driven);
    assert!(bench.driven.brake > 0.05, "7.5 m are missing: {:?}", bench.driven);
}

#[test]
fn the_brake_switches_it_off_and_the_accelerator_overrides_it() {
    let mut bench = Bench::of(AutomationSystem::AdaptiveCruiseControl);
    bench.now.speed_mps = 20.0;
    bench.drive(1.0, REST);
    assert!(bench.driven.throttle < 0.5, "{}", bench.driven.throttle);
    bench.drive(1.0, GAS);
    assert_eq!((bench.driven.throttle, bench.mode()), (0.9, AutomationMode::On));
    bench.drive(0.5, BRAKE);
    assert_eq!((bench.driven.brake, bench.last()), (0.3, AutomationChange::Off(SwitchedOffBy::Brake)));
    // A foot that was on the brake when the drive began holds the vehicle until it is lifted.
    let mut bench = Bench::of(AutomationSystem::AdaptiveCruiseControl);
    bench.drive(1.0, BRAKE);
    assert_eq!((bench.driven.brake, bench.mode()), (0.3, AutomationMode::On));
    bench.drive(1.0, REST);
    assert!(bench.driven.brake < 0.3 && bench.mode() == AutomationMode::On);
    // Steering alone has no use for the brake.
    let mut bench = Bench::of(AutomationSystem::LaneKeeping);
    bench.drive(1.0, BRAKE);
    assert_eq!((bench.driven.brake, bench.mode()), (0.3, AutomationMode::On));
}

#[test]
fn a_turn_by_hand_takes_over_and_a_wheel_at_rest_does_not() {
    let turned = |degrees: f32| Controls { steering_wheel_rad: degrees.to_radians(), ..REST };
    let mut bench = Bench::of(AutomationSystem::CruiseAndLaneKeeping);
    // A wheel without a motor rests at 30 degrees.
    bench.drive(5.0, turned(30.0));
    bench.drive(1.0, turned(38.0));
    assert_eq!(bench.mode(), AutomationMode::On, "8 of 10 degrees");
    bench.drive(TICK_S, turned(49.0));
    assert_eq!(bench.last(), AutomationChange::Off(SwitchedOffBy::Wheel));
    // The system's angle was about 0: the wheel goes over to 49 degrees in a second.
    let share = |bench: &Bench| bench.driven.steering_wheel_rad.to_degrees() / 49.0;
    assert!(share(&bench).abs() < 0.05, "{}", share(&bench));
    bench.drive(0.5, turned(49.0));
    assert!((share(&bench) - 0.5).abs() < 0.05, "{}", share(&bench));
    bench.drive(0.5, turned(49.0));
    assert!((share(&bench) - 1.0).abs() < 1e-6);
}

#[test]
fn a_wheel_that_turns_with_the_systems_takes_nothing_over() {
    let mut bench = Bench::of(AutomationSystem::CruiseAndLaneKeeping);
    let lane = LaneView { aim: glam::dvec2(15.0, 3.0), ..LaneView::default() };
    bench.now.lane = lane;
    for _ in 0..300 {
        let wheel_rad = bench.driven.steering_wheel_rad;
        bench.drive(TICK_S, Controls { steering_wheel_rad: wheel_rad, ..REST });
    }
    assert!(bench.driven.steering_wheel_rad > 20.0_f32.to_radians());
    assert_eq!(bench.mode(), AutomationMode::On);
}

#[test]
fn a_wheel_that_follows_late_is_not_turned_by_hand_and_one_held_back_is() {
    let mut turns = WheelTurns::default();
    let least_rad = 10.0_f64.to_radians();
    let mut add = |given_deg: f32, driven_deg: f32| {
        turns.add(given_deg.to_radians(), driven_deg.to_radians());
        turns.is_by_hand(least_rad)
    };
    // The system turns at once by 24 degrees, and the wheel is there five ticks later.
    assert!((0..6).all(|k| !add(0.0, if k == 0 { 0.0 } else { 24.0 })));
    assert!((0..60).all(|_| !add(24.0, 24.0)));
    // From there the participant turns it back by 2 degrees each tick: in the fifth it is 10 degrees away.
    let by_hand: Vec<bool> = (1..=5u8).map(|k| add(24.0 - 2.0 * f32::from(k) - 0.01, 24.0)).collect();
    assert_eq!(by_hand, [false, false, false, false, true]);
}

/// Returns the controls of a wheel with force that rests, with this torque of the hands, N m.
fn hands(torque_nm: f32) -> Controls {
    Controls { hand_torque_nm: Some(torque_nm), ..REST }
}

#[test]
fn the_torque_of_the_hands_takes_over_a_system_that_steers() {
    for (system, mode) in [
        (AutomationSystem::CruiseAndLaneKeeping, AutomationMode::Off),
        (AutomationSystem::AdaptiveCruiseControl, AutomationMode::On),
    ] {
        let mut bench = Bench::of(system);
        bench.drive(1.0, hands(0.0));
        // The defaults: hands are on the wheel from 0.5 N m on, and take over from 1 N m on, to either side.
        bench.drive(1.0, hands(0.99));
        assert_eq!(bench.mode(), AutomationMode::On);
        bench.drive(TICK_S, hands(-1.01));
        assert_eq!(bench.mode(), mode, "{system:?}");
    }
}

#[test]
fn hands_that_hold_the_wheel_when_it_is_switched_on_do_not_switch_it_off() {
    let system = AutomationSystem::LaneKeeping;
    let mut bench = Bench::new(Automation { system, starts_on: false, ..Automation::default() });
    bench.drive(1.0, hands(1.3));
    bench.drive(TICK_S, Controls { automation_button: true, ..hands(1.3) });
    bench.drive(1.0, hands(1.3));
    assert_eq!(bench.mode(), AutomationMode::On);
    bench.drive(0.1, hands(0.2));
    bench.drive(TICK_S, hands(1.3));
    assert_eq!(bench.last(), AutomationChange::Off(SwitchedOffBy::Wheel));
}

#[test]
fn a_turn_of_a_wheel_with_force_needs_a_torque_of_the_hands() {
    for (torque_nm, mode) in [(0.3, AutomationMode::On), (0.6, AutomationMode::Off)] {
        let mut bench = Bench::of(AutomationSystem::CruiseAndLaneKeeping);
        bench.drive(1.0, hands(torque_nm));
        // 11 of 10 degrees at once, as of a wheel that catches up with the system's.
        bench.drive(TICK_S, Controls { steering_wheel_rad: 11.0_f32.to_radians(), ..hands(torque_nm) });
        assert_eq!(bench.mode(), mode, "{torque_nm} N m");
    }
}

#[test]
fn hands_on_a_wheel_with_force_are_an_input_without_a_turn() {
    let inputs = |torque_nm| {
        let mut bench = Bench::of(AutomationSystem::TrafficJamPilot);
        bench.drive(1.0, hands(0.0));
        bench.run.order(AutomationOrder::Request(7.0));
        bench.drive(1.0, hands(0.0));
        bench.drive(1.0, hands(torque_nm));
        bench.noted[2..].to_vec()
    };
    assert_eq!(inputs(0.49), []);
    assert_eq!(inputs(-0.51), [(201, AutomationChange::Input(TakeoverInput::Hands))]);
}

#[test]
fn a_request_becomes_urgent_and_ends_in_a_stop_in_the_lane() {
    let mut bench = Bench::of(AutomationSystem::TrafficJamPilot);
    bench.drive(1.0, REST);
    bench.run.order(AutomationOrder::Request(7.0));
    bench.drive(3.0, REST);
    let urgent = |bench: &Bench| bench.run.state(Tick(bench.tick)).is_urgent;
    assert_eq!((bench.mode(), urgent(&bench)), (AutomationMode::TakeoverRequest, false));
    bench.drive(0.6, REST);
    assert!(urgent(&bench), "half of 7 s are over");
    bench.drive(3.41, REST);
    assert_eq!((bench.mode(), bench.last()), (AutomationMode::MinimalRisk, AutomationChange::MinimalRisk));
    // The request came in the first tick after 1 s, and the lead time is 7 s.
    assert_eq!(bench.noted[1..].iter().map(|(tick, _)| *tick).collect::<Vec<_>>(), [101, 801]);
    bench.drive(1.0, REST);
    assert!(bench.driven.brake > 0.1);
    // At a standstill it holds the brake until the participant takes over.
    bench.now.speed_mps = 0.0;
    bench.drive(20.0, REST);
    assert!(bench.driven.brake > 0.1 && bench.mode() == AutomationMode::MinimalRisk);
    bench.drive(TICK_S, GAS);
    assert_eq!(bench.last(), AutomationChange::Off(SwitchedOffBy::Accelerator));
    assert!(bench.noted.contains(&(bench.tick, AutomationChange::Input(TakeoverInput::Accelerator))));
}

#[test]
fn below_level_3_a_request_without_a_takeover_switches_the_system_off() {
    let mut bench = Bench::of(AutomationSystem::CruiseAndLaneKeeping);
    bench.drive(1.0, REST);
    bench.run.order(AutomationOrder::Request(4.0));
    bench.drive(5.0, REST);
    assert_eq!(bench.noted[2..], [(501, AutomationChange::Off(SwitchedOffBy::NoTakeover))]);
}

#[test]
fn a_system_that_failed_stays_off() {
    let mut bench = Bench::of(AutomationSystem::LaneKeeping);
    bench.drive(1.0, REST);
    bench.run.order(AutomationOrder::Fail);
    bench.drive(1.0, REST);
    assert_eq!(bench.last(), AutomationChange::Off(SwitchedOffBy::Failure));
    bench.drive(TICK_S, PRESS);
    bench.run.order(AutomationOrder::On);
    bench.drive(1.0, REST);
    assert_eq!((bench.mode(), bench.noted.len()), (AutomationMode::Off, 2));
}

#[test]
fn the_traffic_jam_pilot_starts_at_60_kmh_or_less() {
    for (kmh, mode) in [(59.0, AutomationMode::On), (61.0, AutomationMode::Off)] {
        let system = AutomationSystem::TrafficJamPilot;
        let mut bench = Bench::new(Automation { system, starts_on: false, ..Automation::default() });
        bench.now.speed_mps = kmh / 3.6;
        bench.drive(TICK_S, PRESS);
        assert_eq!(bench.mode(), mode, "{kmh} km/h");
    }
}

#[test]
fn an_order_that_cannot_be_carried_out_is_refused() {
    let mut bench =
        Bench::new(Automation { system: AutomationSystem::TrafficJamPilot, starts_on: false, ..Automation::default() });
    let takes = |bench: &Bench, order| bench.run.takes(order);
    let request = AutomationOrder::Request(7.0);
    bench.drive(0.1, REST);
    assert_eq!(takes(&bench, AutomationOrder::On), Ok(()));
    assert_eq!(takes(&bench, AutomationOrder::Off), Err(NotDone::AutomationOff));
    assert_eq!(takes(&bench, request), Err(NotDone::AutomationOff));
    // A foot on the brake, 61 km/h, and a failure.
    bench.drive(0.1, BRAKE);
    assert_eq!(takes(&bench, AutomationOrder::On), Err(NotDone::AutomationNotReady));
    bench.now.speed_mps = 61.0 / 3.6;
    bench.drive(0.1, REST);
    assert_eq!(takes(&bench, AutomationOrder::On), Err(NotDone::AutomationNotReady));
    bench.now.speed_mps = 10.0;
    bench.run.order(AutomationOrder::On);
    bench.drive(0.1, REST);
    assert_eq!((bench.mode(), takes(&bench, request)), (AutomationMode::On, Ok(())));
    assert_eq!(takes(&bench, AutomationOrder::On), Err(NotDone::AutomationNotReady), "it is on");
    bench.run.order(AutomationOrder::Fail);
    bench.drive(0.1, REST);
    assert_eq!(takes(&bench, AutomationOrder::On), Err(NotDone::AutomationNotReady));
}
