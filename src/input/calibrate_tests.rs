//! Calibrations: complete ones, movements at the wrong moment, noise, and the bars.

use super::*;

fn g29() -> UnprofiledDevice {
    let axes = [(0, [0, 65_535]), (1, [0, 255]), (2, [0, 255]), (5, [0, 255]), (16, [-1, 1])];
    let values = [(0, 32_900), (1, 255), (2, 255), (5, 255), (16, 0)];
    UnprofiledDevice {
        name: "G29".into(),
        id: (0x046d, 0xc24f),
        axes: axes.into(),
        values: values.into(),
        ..UnprofiledDevice::default()
    }
}

/// Moves an axis from one value to another within 0.5 s and holds it for 1 s.
fn hold(calibration: &mut Calibration, now_s: &mut f64, code: u16, from: i32, to: i32) {
    for i in 1..=20 {
        *now_s += 0.025;
        calibration.moved(code, from + (to - from) * i / 20, *now_s);
    }
    for _ in 0..20 {
        *now_s += 0.05;
        calibration.time(*now_s);
    }
}

#[test]
fn a_g29_is_calibrated_by_turning_and_pressing_alone() {
    let mut calibration = Calibration::new(g29(), 0.0).unwrap();
    let mut now_s = 0.0;
    calibration.moved(5, 254, 0.5);
    calibration.moved(5, 255, 0.6);
    calibration.time(1.9);
    assert_eq!(calibration.step(), CalibrationStep::Rest);
    now_s += 2.1;
    calibration.time(now_s);
    let moves = [
        (0, 32_900, 120, CalibrationStep::Left, CalibrationStep::Right),
        (0, 120, 65_400, CalibrationStep::Right, CalibrationStep::Straight),
        (0, 65_400, 32_700, CalibrationStep::Straight, CalibrationStep::Accelerator),
        (2, 255, 3, CalibrationStep::Accelerator, CalibrationStep::AcceleratorUp),
        (2, 3, 255, CalibrationStep::AcceleratorUp, CalibrationStep::Brake),
        (5, 255, 90, CalibrationStep::Brake, CalibrationStep::BrakeUp),
        (5, 90, 254, CalibrationStep::BrakeUp, CalibrationStep::Done),
    ];
    for (code, from, to, during, after) in moves {
        assert_eq!(calibration.step(), during);
        hold(&mut calibration, &mut now_s, code, from, to);
        assert_eq!(calibration.step(), after);
    }
    let profile = calibration.profile("Rig 1").unwrap();
    assert_eq!(
        (profile.steering.left, profile.steering.centre, profile.steering.right),
        (120, 32_700, 65_400),
        "{profile:?}"
    );
    let brake = profile.brake.as_ref().unwrap();
    assert_eq!((profile.accelerator.axis, brake.axis, brake.pressed), (2, 5, 90));
    assert_eq!((brake.effect(255), brake.effect(254), brake.effect(90)), (0.0, 0.0, 1.0), "noise at rest is no brake");
    assert_eq!(profile.buttons.reverse, [293], "as shipped for the same product");
    assert!(profile.is_for(0x046d, 0xc24f));
}

#[test]
fn reversed_axes_and_pedals_that_rest_low_are_calibrated_too() {
    let device = UnprofiledDevice {
        name: "Other".into(),
        id: (1, 2),
        axes: [(3, [-512, 511]), (6, [0, 1023]), (7, [0, 1023])].into(),
        values: [(3, 0), (6, 0), (7, 0)].into(),
        ..UnprofiledDevice::default()
    };
    let mut calibration = Calibration::new(device, 0.0).unwrap();
    calibration.moved(3, 2, 0.0);
    let mut now_s = 2.1;
    calibration.time(now_s);
    for (code, from, to) in
        [(3, 0, 511), (3, 511, -512), (3, -512, 2), (7, 0, 1000), (7, 1000, 0), (6, 0, 800), (6, 800, 0)]
    {
        hold(&mut calibration, &mut now_s, code, from, to);
    }
    let profile = calibration.profile("other").unwrap();
    assert!(profile.steering.wheel_rad(400) > 0.0 && profile.steering.wheel_rad(-400) < 0.0);
    assert_eq!((profile.accelerator.axis, profile.accelerator.pressed, profile.accelerator.released), (7, 1000, 0));
}

#[test]
fn an_unread_wheel_must_move_before_its_rest_is_measured() {
    // A former fault: the first report changed all axes from 0, and a pedal was taken for the wheel.
    let device = UnprofiledDevice { values: [(0, 0), (1, 0), (2, 0), (5, 0), (16, 0)].into(), ..g29() };
    let mut calibration = Calibration::new(device, 0.0).unwrap();
    calibration.time(10.0);
    assert_eq!(calibration.step(), CalibrationStep::Wake, "nobody knows where it rests");
    for (code, raw) in [(0, 32_800), (1, 255), (2, 255), (5, 255)] {
        calibration.moved(code, raw, 11.0);
    }
    assert_eq!(calibration.step(), CalibrationStep::Rest);
    calibration.time(13.1);
    assert_eq!(calibration.step(), CalibrationStep::Left);
    let mut now_s = 13.1;
    for (code, from, to) in
        [(0, 32_800, 0), (0, 0, 65_535), (0, 65_535, 32_700), (2, 255, 0), (2, 0, 255), (5, 255, 60), (5, 60, 255)]
    {
        hold(&mut calibration, &mut now_s, code, from, to);
    }
    let profile = calibration.profile("Rig 1").unwrap();
    assert_eq!((profile.steering.axis, profile.accelerator.axis), (0, 2));
    assert_eq!((profile.accelerator.released, profile.accelerator.pressed), (255, 0));
}

#[test]
fn a_movement_at_rest_restarts_the_rest_and_no_partial_profile_is_given() {
    let mut calibration = Calibration::new(g29(), 0.0).unwrap();
    calibration.moved(2, 100, 1.5);
    calibration.moved(2, 255, 1.6);
    calibration.time(2.5);
    assert_eq!(calibration.step(), CalibrationStep::Rest);
    calibration.time(3.7);
    assert_eq!(calibration.step(), CalibrationStep::Left);
    assert!(calibration.profile("x").unwrap_err().0.contains("the calibration is not complete"));
    let pad = UnprofiledDevice { axes: [(0, [0, 255])].into(), ..g29() };
    assert!(Calibration::new(pad, 0.0).unwrap_err().0.contains("fewer than two axes"));
}

/// Makes a device with 100 counts per axis: steering, and two pedals that rest at 0.
fn coarse() -> UnprofiledDevice {
    UnprofiledDevice {
        name: "Coarse".into(),
        id: (1, 2),
        axes: [(0, [0, 100]), (1, [0, 100]), (2, [0, 100])].into(),
        values: [(0, 50), (1, 0), (2, 0)].into(),
        ..UnprofiledDevice::default()
    }
}

#[test]
fn an_axis_is_still_within_one_percent_of_its_range() {
    let mut calibration = Calibration::new(coarse(), 0.0).unwrap();
    calibration.time(REST_S);
    assert_eq!(calibration.step(), CalibrationStep::Left);
    calibration.moved(0, 10, 3.0);
    // Within 1 % of the range of the value at which it came to rest.
    for (raw, at_s) in [(11, 3.2), (10, 3.4), (9, 3.6), (10, 3.79)] {
        calibration.moved(0, raw, at_s);
        assert_eq!(calibration.step(), CalibrationStep::Left, "not held yet");
    }
    calibration.time(3.001 + HOLD_S);
    assert_eq!(calibration.step(), CalibrationStep::Right);
    calibration.moved(0, 90, 4.0);
    calibration.moved(0, 92, 4.7);
    calibration.time(4.9);
    assert_eq!(calibration.step(), CalibrationStep::Right, "still turning at 4.7");
    calibration.time(4.701 + HOLD_S);
    assert_eq!(calibration.step(), CalibrationStep::Straight);
}

/// Returns a coarse wheel that is calibrated up to the accelerator.
fn turned() -> (Calibration, f64) {
    let (mut calibration, mut now_s) = (Calibration::new(coarse(), 0.0).unwrap(), REST_S);
    calibration.time(now_s);
    for (from, to) in [(50, 0), (0, 100), (100, 50)] {
        hold(&mut calibration, &mut now_s, 0, from, to);
    }
    assert_eq!(calibration.step(), CalibrationStep::Accelerator);
    (calibration, now_s)
}

#[test]
fn the_wheel_is_no_pedal_and_a_pedal_is_assigned_only_once() {
    let (mut calibration, mut now_s) = turned();
    hold(&mut calibration, &mut now_s, 0, 50, 95);
    assert_eq!(calibration.step(), CalibrationStep::Accelerator, "the wheel has its task");
    hold(&mut calibration, &mut now_s, 0, 95, 50);
    hold(&mut calibration, &mut now_s, 1, 0, 80);
    assert_eq!(calibration.step(), CalibrationStep::AcceleratorUp);
    // A pedal is released below 0.15 of the travel to the floor.
    hold(&mut calibration, &mut now_s, 1, 80, 12);
    assert_eq!(calibration.step(), CalibrationStep::AcceleratorUp);
    hold(&mut calibration, &mut now_s, 1, 12, 11);
    assert_eq!(calibration.step(), CalibrationStep::Brake);
    hold(&mut calibration, &mut now_s, 1, 11, 80);
    hold(&mut calibration, &mut now_s, 0, 50, 5);
    assert_eq!(calibration.step(), CalibrationStep::Brake, "the accelerator again is no brake");
}

#[test]
fn a_lightly_pressed_pedal_that_rests_high_is_released_near_its_rest() {
    let device = UnprofiledDevice { values: [(0, 50), (1, 100), (2, 100)].into(), ..coarse() };
    let (mut calibration, mut now_s) = (Calibration::new(device, 0.0).unwrap(), REST_S);
    calibration.time(now_s);
    for (code, from, to) in [(0, 50, 0), (0, 0, 100), (0, 100, 50), (1, 100, 60)] {
        hold(&mut calibration, &mut now_s, code, from, to);
    }
    // 0.15 of the 40 counts of the press are 6.
    hold(&mut calibration, &mut now_s, 1, 60, 93);
    assert_eq!(calibration.step(), CalibrationStep::AcceleratorUp);
    hold(&mut calibration, &mut now_s, 1, 93, 95);
    assert_eq!(calibration.step(), CalibrationStep::Brake);
}

#[test]
fn a_quarter_of_the_range_is_a_response_and_less_is_none() {
    let (mut calibration, mut now_s) = turned();
    hold(&mut calibration, &mut now_s, 1, 0, 24);
    assert_eq!(calibration.step(), CalibrationStep::Accelerator);
    hold(&mut calibration, &mut now_s, 1, 24, 25);
    assert_eq!(calibration.step(), CalibrationStep::AcceleratorUp);
}

#[test]
fn the_right_end_is_opposite_the_left_and_straight_is_near_their_mean() {
    // The mean of 90 and 25 is 57.5; straight must be within 0.15 of the range of it, 43 to 72.
    for (outside, inside) in [(42, 43), (73, 72)] {
        let (mut calibration, mut now_s) = (Calibration::new(coarse(), 0.0).unwrap(), REST_S);
        calibration.time(now_s);
        let steps = [
            (50, 90, CalibrationStep::Right),
            (90, 100, CalibrationStep::Right),
            (100, 26, CalibrationStep::Right),
            // It was still at 26, and one count is no movement: taken at 25, the first value that is far enough.
            (26, 20, CalibrationStep::Straight),
            (20, outside, CalibrationStep::Straight),
            (outside, inside, CalibrationStep::Accelerator),
        ];
        for (from, to, after) in steps {
            hold(&mut calibration, &mut now_s, 0, from, to);
            assert_eq!(calibration.step(), after, "{from} to {to}");
        }
    }
}

#[test]
fn a_device_with_one_pedal_is_done_without_a_brake() {
    let mut device = coarse();
    device.axes.remove(&2);
    device.values.remove(&2);
    let (mut calibration, mut now_s) = (Calibration::new(device, 0.0).unwrap(), REST_S);
    calibration.time(now_s);
    for (code, from, to) in [(0, 50, 0), (0, 0, 100), (0, 100, 50), (1, 0, 80), (1, 80, 0)] {
        hold(&mut calibration, &mut now_s, code, from, to);
    }
    let profile = calibration.profile("one").unwrap();
    assert_eq!((profile.accelerator.axis, profile.brake), (1, None));
}

#[test]
fn a_combined_axis_is_calibrated_as_accelerator_and_brake() {
    for further_axis in [false, true] {
        let mut device = coarse();
        device.values.insert(1, 50);
        if !further_axis {
            device.axes.remove(&2);
            device.values.remove(&2);
        }
        let (mut calibration, mut now_s) = (Calibration::new(device, 0.0).unwrap(), REST_S);
        calibration.time(now_s);
        for (code, from, to) in [(0, 50, 0), (0, 0, 100), (0, 100, 50), (1, 50, 5), (1, 5, 50)] {
            hold(&mut calibration, &mut now_s, code, from, to);
        }
        assert_eq!(calibration.step(), CalibrationStep::Brake);
        hold(&mut calibration, &mut now_s, 1, 50, 5);
        assert_eq!(calibration.step(), CalibrationStep::Brake, "the accelerator again is no brake");
        for (from, to) in [(5, 50), (50, 95), (95, 50)] {
            hold(&mut calibration, &mut now_s, 1, from, to);
        }
        assert_eq!(calibration.bars()[1].1, "accelerator, brake");
        let profile = calibration.profile("combined").unwrap();
        let pedals: Vec<_> = profile.pedals().map(|(_, pedal)| (pedal.axis, pedal.released, pedal.pressed)).collect();
        assert_eq!(pedals, [(1, 50, 5), (1, 50, 95)]);
    }
}

#[test]
fn bars_show_the_share_from_rest_or_from_the_wheels_lower_end() {
    let names = |calibration: &Calibration| calibration.bars().into_iter().map(|bar| bar.1).collect::<Vec<_>>();
    let (mut calibration, mut now_s) = turned();
    calibration.moved(0, 30, now_s);
    calibration.moved(1, 20, now_s);
    assert_eq!(names(&calibration), ["steering", "axis 1", "axis 2"]);
    let shares: Vec<(u16, f64)> = calibration.bars().into_iter().map(|bar| (bar.0, bar.2)).collect();
    assert_eq!(shares, [(0, 0.3), (1, 0.2), (2, 0.0)]);
    for (code, from, to) in [(2, 0, 80), (2, 80, 0), (1, 20, 70)] {
        hold(&mut calibration, &mut now_s, code, from, to);
    }
    assert_eq!(names(&calibration), ["steering", "brake", "accelerator"]);
    let mut untold = Calibration::new(g29(), 0.0).unwrap();
    untold.moved(5, 0, 0.1);
    assert_eq!(untold.bars()[3], (5, "axis 5".into(), 1.0), "downwards is a way, too");
}

#[test]
fn noise_at_rest_is_the_dead_zone_of_wheel_and_pedals() {
    let device = UnprofiledDevice {
        axes: [(0, [0, 10_000]), (1, [0, 1000]), (2, [0, 1000])].into(),
        values: [(0, 5000), (1, 1000), (2, 0)].into(),
        ..coarse()
    };
    let mut calibration = Calibration::new(device, 0.0).unwrap();
    for (i, code, raw) in [(1, 0, 4980), (2, 0, 5030), (3, 0, 5000), (4, 1, 990), (5, 1, 995), (6, 1, 1000)] {
        calibration.moved(code, raw, 0.1 * f64::from(i));
    }
    let mut now_s = 3.5;
    calibration.time(now_s);
    assert_eq!(calibration.step(), CalibrationStep::Left);
    for (code, from, to) in
        [(0, 5000, 0), (0, 0, 10_000), (0, 10_000, 5000), (1, 1000, 200), (1, 200, 1000), (2, 0, 1000), (2, 1000, 0)]
    {
        hold(&mut calibration, &mut now_s, code, from, to);
    }
    let profile = calibration.profile("noisy").unwrap();
    // 4980 to 5030 out of half of 10,000 counts; twice 990 to 1000 out of the 800 from rest to floor; at least 0.02.
    assert_eq!(profile.steering.dead, 0.01);
    assert_eq!((profile.accelerator.dead, profile.accelerator.end), (0.025, 0.03));
    assert_eq!(profile.brake.map(|brake| (brake.dead, brake.curve)), Some((0.02, 1.6)));
    assert_eq!(
        (profile.accelerator.curve, profile.steering.range_deg, profile.products),
        (1.0, 900.0, vec!["0001:0002".into()])
    );
}

/// Returns a coarse wheel with two further devices of one id at two ports, each with one axis, calibrated up to the brake.
fn with_levers() -> (Calibration, f64) {
    let mut device = coarse();
    for port in ["usb-1/input0", "usb-2/input0"] {
        device.add(&UnprofiledDevice {
            id: (0x2341, 0x8036),
            place: parts::Place { port: port.into(), ..parts::Place::default() },
            axes: [(0, [0, 1000])].into(),
            values: [(0, 20)].into(),
            ..UnprofiledDevice::default()
        });
    }
    let (mut calibration, mut now_s) = (Calibration::new(device, 0.0).unwrap(), REST_S);
    calibration.time(now_s);
    for (code, from, to) in
        [(0, 50, 0), (0, 0, 100), (0, 100, 50), (1, 0, 80), (1, 80, 0), (PART, 20, 900), (PART, 900, 20)]
    {
        hold(&mut calibration, &mut now_s, code, from, to);
    }
    assert_eq!(calibration.step(), CalibrationStep::Handbrake, "the second device has no task yet");
    (calibration, now_s)
}

#[test]
fn a_handbrake_is_calibrated_on_a_device_that_has_no_task_yet() {
    let (mut calibration, mut now_s) = with_levers();
    hold(&mut calibration, &mut now_s, 2, 0, 90);
    assert_eq!(calibration.step(), CalibrationStep::Handbrake, "a clutch of the wheel is no handbrake");
    hold(&mut calibration, &mut now_s, 2 * PART, 20, 700);
    assert_eq!(calibration.step(), CalibrationStep::HandbrakeUp);
    assert_eq!(calibration.bars()[4].1, "handbrake");
    hold(&mut calibration, &mut now_s, 2 * PART, 700, 20);
    let profile = calibration.profile("levers").unwrap();
    let [brake, lever] = [profile.brake, profile.handbrake].map(Option::unwrap);
    assert_eq!((brake.axis, brake.device.as_deref()), (0, Some("2341:8036 at usb-1/input0")));
    assert_eq!((lever.axis, lever.device.as_deref()), (0, Some("2341:8036 at usb-2/input0")));
    assert_eq!((lever.released, lever.pressed, lever.curve), (20, 700, 1.0));
}

#[test]
fn the_accelerator_says_that_there_is_no_handbrake() {
    let (mut calibration, mut now_s) = with_levers();
    hold(&mut calibration, &mut now_s, 1, 0, 80);
    assert_eq!(calibration.step(), CalibrationStep::Done);
    assert_eq!(calibration.profile("levers").unwrap().handbrake, None);
}
