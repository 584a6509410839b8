//! A wheel with force feedback in a drive with an automation: the force turns it to the automation's angle, and what keeps it from turning counts as
//! hands.

use super::*;
use crate::{
    scenario::{Automation, AutomationSystem},
    snapshot::AutomationMode,
};

#[test]
fn a_wheel_with_force_is_turned_to_the_side_of_the_automation() {
    let system = AutomationSystem::CruiseAndLaneKeeping;
    let automation = Automation { system, ..Automation::default() };
    let (mut live, to) = show(Scenario { automation, ..Scenario::default() });
    to.send(g29(Lamps::default(), true)).unwrap();
    // The wheel rests at 0 and the ring's bend needs about a right angle. The force fades in within 0.4 s; a slow computer has 10 s.
    for _ in 0..500 {
        live.advance(Duration::from_millis(20), |_| ()).unwrap();
        let automation = live.drive.world.snapshot().automation;
        let held_rad = automation.driven.filter(|_| automation.steers_now()).map(|driven| driven.steering_wheel_rad);
        assert_eq!(live.force_input().held_rad, held_rad.map(f64::from));
        std::thread::sleep(Duration::from_millis(20));
        let torque_nm = live.devices.take_torque_nm().unwrap_or(0.0);
        if torque_nm.abs() > 0.5 {
            let wheel_rad = held_rad.expect("the automation is on");
            assert!(
                wheel_rad.abs() > 0.1 && torque_nm.signum() == f64::from(wheel_rad.signum()),
                "{wheel_rad} {torque_nm}"
            );
            break;
        }
    }
    // The wheel that does not turn is taken for one that is held, against the motor.
    for _ in 0..500 {
        live.advance(Duration::from_millis(20), |_| ()).unwrap();
        let world = &live.drive.world;
        if world.snapshot().automation.mode == AutomationMode::Off {
            let torque_nm = live.devices.controls(0.0, None).hand_torque_nm.expect("a wheel with force");
            assert!(torque_nm.abs() >= 1.0 && world.snapshot().automation.driven.is_some(), "{torque_nm}");
            return;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    panic!("no force or no takeover within 10 s: {:?}", live.force_input());
}
