//! A wheel with force feedback in a drive with an automation: the force turns it to the automation's angle.

use super::*;
use crate::scenario::{Automation, AutomationSystem};

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
            return;
        }
    }
    panic!("no force within 10 s: {:?}", live.force_input());
}
