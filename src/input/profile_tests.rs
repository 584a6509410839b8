//! Properties of profiles: conversions from raw values to wheel and pedals, and messages about invalid files.

use super::{super::buttons::ButtonAction, *};
use proptest::{
    prelude::*,
    test_runner::{Config, RngSeed},
};

const G29: &str = include_str!("../../assets/wheels/g29.toml");

/// Returns a configuration with the same cases in every run.
fn config() -> Config {
    Config { cases: 2000, failure_persistence: None, rng_seed: RngSeed::Fixed(7), ..Config::default() }
}

prop_compose! {
    /// Draws a pedal from the whole range of allowed values.
    fn pedals()(
        released in -70_000..70_000_i32,
        way in 2..70_000_i32,
        up in any::<bool>(),
        dead in 0.0..0.4,
        end in 0.0..0.4,
        curve in 0.3..4.0,
    ) -> Pedal {
        let pressed = if up { released + way } else { released - way };
        Pedal { axis: 2, released, pressed, dead, end, curve, device: None, part: 0 }
    }
}

prop_compose! {
    /// Draws a wheel from a wide range of values, with unequal halves.
    fn wheels()(
        centre in -1000..40_000_i32,
        half_left in 500..40_000_i32,
        half_right in 500..40_000_i32,
        sign in prop::sample::select(vec![-1, 1]),
        range_deg in 180.0..1440.0,
        ratio in 5.0..40.0,
        dead in 0.0..0.2,
    ) -> Steering {
        let (left, right) = (centre - sign * half_left, centre + sign * half_right);
        Steering { axis: 0, left, centre, right, range_deg, ratio, dead }
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn a_pedal_rises_without_a_step_from_zero_at_rest_to_one_at_the_floor(
        pedal in pedals(),
        share in -0.1..1.1,
        foot in 0.0..1.0,
    ) {
        prop_assert_eq!(pedal.effect(pedal.released), 0.0);
        prop_assert_eq!(pedal.effect(pedal.pressed), 1.0);
        let towards_floor = (pedal.pressed - pedal.released).signum();
        let raw = |share: f64| pedal.released + (f64::from(pedal.pressed - pedal.released) * share).round() as i32;
        let (here, next) = (pedal.effect(raw(share)), pedal.effect(raw(share) + towards_floor));
        prop_assert!((0.0..=1.0).contains(&here));
        // The live travel per count of the device. A power below 1 rises most over the first count, a power above 1 at
        // the end.
        let count = 1.0 / (f64::from((pedal.pressed - pedal.released).abs()) * (1.0 - pedal.dead - pedal.end));
        let most = count.powf(pedal.curve).max(count * pedal.curve) + 1e-6;
        let rise = f64::from(next) - f64::from(here);
        prop_assert!((0.0..=most).contains(&rise), "{} of at most {}", rise, most);
        // No raw value within the dead zone has an effect, noise of a worn sensor included.
        prop_assert_eq!(pedal.effect(raw(foot * (pedal.dead - 0.5 * count).max(0.0))), 0.0);
    }

    #[test]
    fn a_wheel_turns_through_its_full_range_without_a_step(
        wheel in wheels(),
        share in -1.2..1.2,
    ) {
        let end = (wheel.range_deg / 2.0).to_radians();
        prop_assert_eq!(wheel.wheel_rad(wheel.centre), 0.0);
        prop_assert_eq!(wheel.car_rad(wheel.centre), 0.0);
        prop_assert!((wheel.wheel_rad(wheel.left) - end).abs() < 1e-9);
        prop_assert!((wheel.wheel_rad(wheel.right) + end).abs() < 1e-9);
        let half = (wheel.left - wheel.centre).abs().min((wheel.right - wheel.centre).abs());
        // A raw count is 1 / half of the smaller side, and the dead zone makes the rest steeper by 1 / (1 - dead).
        let most = end / f64::from(half) / (1.0 - wheel.dead) + 1e-9;
        let raw = wheel.centre + (share * f64::from((wheel.left - wheel.centre).abs())) as i32;
        let to_right = (wheel.right - wheel.centre).signum();
        let change = wheel.wheel_rad(raw + to_right) - wheel.wheel_rad(raw);
        prop_assert!((-most..=0.0).contains(&change), "{} of at most {}", change, most);
        let car = wheel.car_rad(raw + to_right) - wheel.car_rad(raw);
        prop_assert!((-1e-6..=1e-6).contains(&car) || car < 0.0, "the car's wheel turns the same way");
        prop_assert!(wheel.car_rad(raw).abs() <= STEERING_LOCK_RAD);
    }
}

#[test]
fn a_g29_reaches_the_cars_lock_on_both_sides() {
    let profile = WheelProfile::from_toml(G29, "g29").unwrap();
    assert_eq!(profile.steering.car_rad(0), STEERING_LOCK_RAD);
    assert_eq!(profile.steering.car_rad(65_535), -STEERING_LOCK_RAD);
    assert_eq!(profile.steering.car_rad(32_767), 0.0);
    let quick = Steering { ratio: 7.5, ..profile.steering };
    let quarter = quick.car_rad(24_575);
    assert!((quarter - STEERING_LOCK_RAD / 2.0).abs() < 1e-3, "half the ratio, twice the answer: {quarter}");
}

#[test]
fn a_wrong_profile_is_named_with_file_line_value_and_remedy() {
    let message = |text: &str| WheelProfile::from_toml(text, "mine.toml").unwrap_err().0;
    let text = message(&G29.replace("pressed = 0", "pressed = 255"));
    assert!(text.starts_with("mine.toml:16:11: accelerator.pressed: 255 is also the released value"), "{text}");
    assert!(text.contains("codrive calibrate"), "{text}");
    let text = message(&G29.replace("curve = 1.6", "curve = 9"));
    assert!(text.contains(": brake.curve: 9 is not allowed; allowed: 0.3 to 4"), "{text}");
    let text = message(&G29.replace("axis = 5", "axis = 2"));
    assert!(text.contains(": brake.axis: axis 2 already has another task"), "{text}");
    assert!(message("name = 3").starts_with("mine.toml:1:8: invalid type"), "{}", message("name = 3"));
    assert!(message(&G29.replace("[force]", "[forse]")).contains("unknown key `forse`; did you mean `force`?"));
    let text = message(&G29.replace("curve = 1.6", "cruve = 1.6"));
    assert!(text.contains("unknown key `cruve`; did you mean `curve`?") && text.ends_with("| ^^^^^"), "{text}");
    let text = message(&G29.replace("curve = 1.6", "curve = 9"));
    assert!(text.ends_with(" | curve = 9\n   |         ^"), "{text}");
    assert!(message("name = \"x\"").contains("missing key `steering`"));
    assert!(message("steering = [[[").starts_with("mine.toml:1:"));
    let text = message(&G29.replace("full_nm = 2.1", "full_nm = 1.0"));
    assert!(text.contains("force.cap_nm: 1.8 is not allowed; allowed: 0 to 1"), "{text}");
}

#[test]
fn all_mistakes_of_a_profile_are_in_one_report() {
    let text = "name = \"x\"\nproducts = [\"G29\"]\n[steering]\naxis = 0\nleft = 0\ncentre = 500\nright = 100\nrange_deg = 9000\n\
                [accelerator]\naxes = 1\nreleased = 7\npressed = 7\n[force]\nfull_nm = 99\ncap_nm = 200\ninvert = \"no\"\n";
    let report = WheelProfile::from_toml(text, "mine.toml").unwrap_err().0;
    let places: Vec<&str> = report.lines().filter_map(|line| line.strip_prefix("mine.toml:")).collect();
    let wanted = [
        "2:12: products: \"G29\" is no USB id",
        "6:10: steering.centre: 500 is not between",
        "8:13: steering.range_deg: 9000 is not allowed",
        "10:1: unknown key `axes`; did you mean `axis`?",
        // Nothing else is said about an accelerator without an axis, nor about a cap beside a wrong limit.
        "14:11: force.full_nm: 99 is not allowed",
        "16:10: invalid type: string \"no\"",
    ];
    assert!(
        places.len() == wanted.len() && places.iter().zip(wanted).all(|(one, begin)| one.starts_with(begin)),
        "{report}"
    );
}

#[test]
fn missing_keys_default_to_a_wheel_of_900_degrees_and_small_dead_zones() {
    let short = "name = \"x\"\n[steering]\naxis = 0\nleft = 0\ncentre = 50\nright = 100\n[accelerator]\naxis = 1\nreleased = 0\npressed = 100\n";
    let profile = WheelProfile::from_toml(short, "x").unwrap();
    let s = &profile.steering;
    assert_eq!((s.range_deg, s.ratio, s.dead), (900.0, f64::from(STEERING_RATIO), 0.0));
    let pedal = &profile.accelerator;
    assert_eq!((pedal.dead, pedal.end, pedal.curve), (0.02, 0.02, 1.0));
    assert!(profile.brake.is_none() && profile.products.is_empty());
    assert_eq!((profile.buttons, profile.force), (Buttons::default(), ForceSettings::default()));
}

#[test]
fn the_centre_lies_between_both_ends_and_on_neither() {
    let ends = |left: i32, centre: i32, right: i32| {
        let mut profile = WheelProfile::from_toml(G29, "g29").unwrap();
        (profile.steering.left, profile.steering.centre, profile.steering.right) = (left, centre, right);
        WheelProfile::from_toml(&profile.to_toml(), "x").map(|_| ())
    };
    assert!(ends(0, 1, 2).is_ok() && ends(2, 1, 0).is_ok());
    for (left, centre, right) in [(0, 0, 2), (0, 2, 2), (2, 2, 0), (2, 0, 0), (0, 3, 2), (2, 3, 0), (0, -1, 2)] {
        let text = ends(left, centre, right).unwrap_err().0;
        let message = format!("steering.centre: {centre} is not between left ({left}) and right ({right})");
        assert!(text.contains(&message), "{text}");
    }
}

#[test]
fn assigning_a_button_removes_its_old_action_and_the_actions_old_button() {
    let mut buttons = WheelProfile::from_toml(G29, "g29").unwrap().buttons;
    // As in g29.toml.
    let tasks = [
        (293, ButtonAction::Reverse),
        (297, ButtonAction::Start),
        (292, ButtonAction::Mark),
        (288, ButtonAction::Answer),
        (294, ButtonAction::IndicateRight),
        (295, ButtonAction::IndicateLeft),
        (290, ButtonAction::MainBeam),
        (298, ButtonAction::Respond),
        (299, ButtonAction::Automation),
        (707, ButtonAction::TimeGap),
    ];
    for (code, action) in
        tasks.into_iter().chain([(291, ButtonAction::Recentre), (296, ButtonAction::Abort), (289, ButtonAction::Horn)])
    {
        assert_eq!(buttons.action(code), Some(action));
    }
    assert_eq!(buttons.action(300), None);
    buttons.give(293, ButtonAction::Horn);
    assert_eq!((buttons.action(293), buttons.action(289)), (Some(ButtonAction::Horn), None));
    assert_eq!(buttons.reverse, [0; 0]);
    assert_eq!(buttons.start, [297]);
}

#[test]
fn a_product_matches_in_either_case_and_by_both_its_numbers() {
    let mut profile = WheelProfile::from_toml(G29, "g29").unwrap();
    profile.products = vec!["046D:C24F".into(), "0001:000a".into()];
    assert!(profile.is_for(0x046d, 0xc24f) && profile.is_for(1, 10));
    assert!(!profile.is_for(0x046d, 10) && !profile.is_for(1, 0xc24f));
}

#[test]
fn a_product_that_is_no_usb_id_is_refused() {
    for id in ["346e:4", "0x346e:0x0004", "MOZA R5", "346e", "346e:00g4"] {
        let text = WheelProfile::from_toml(&G29.replace("046d:c24f", id), "mine.toml").unwrap_err().0;
        assert!(text.contains(&format!("products: \"{id}\" is no USB id")) && text.contains("046d:c24f"), "{text}");
    }
}

#[test]
fn pedals_are_upside_down_if_all_are_pressed_and_no_further_one_rests() {
    let profile = WheelProfile::from_toml(G29, "g29").unwrap();
    let axes = [(0, [0, 65_535]), (1, [0, 255]), (2, [0, 255]), (5, [0, 255]), (16, [-1, 1])].into();
    let turned = |values: &[(u16, i32)]| profile.pedals_upside_down(&axes, &values.iter().copied().collect());
    assert!(turned(&[(0, 32_767), (1, 0), (2, 0), (5, 0), (16, 0)]));
    assert!(turned(&[(0, 32_767), (1, 3), (2, 20), (5, 9)]), "near the end");
    assert!(!turned(&[(0, 32_767), (1, 255), (2, 255), (5, 255)]));
    assert!(!turned(&[(0, 32_767), (1, 255), (2, 0), (5, 0)]), "two feet on two pedals, and a clutch at rest");
    assert!(!turned(&[(0, 32_767), (1, 0), (2, 0), (5, 255)]));
    assert!(!turned(&[(0, 0), (1, 0), (2, 0), (5, 0)]), "not read yet");
    assert!(!turned(&[(0, 32_767), (2, 0)]), "one is unknown");
}

#[test]
fn two_pedals_share_an_axis_only_on_its_two_sides() {
    let sides = |accelerator: [i32; 2], brake: [i32; 2]| {
        let mut profile = WheelProfile::from_toml(G29, "g29").unwrap();
        let pedal = |[released, pressed]: [i32; 2]| Pedal { axis: 2, released, pressed, ..profile.accelerator.clone() };
        (profile.accelerator, profile.brake) = (pedal(accelerator), Some(pedal(brake)));
        WheelProfile::from_toml(&profile.to_toml(), "x").is_ok()
    };
    assert!(sides([128, 0], [128, 255]) && sides([128, 255], [128, 0]) && sides([140, 255], [120, 0]));
    assert!(!sides([255, 0], [255, 0]) && !sides([120, 255], [140, 0]) && !sides([128, 0], [0, 128]));
}

#[test]
fn a_guess_uses_axes_with_a_range_that_are_no_hats() {
    let guess = |axes: &[(u16, [i32; 2])], now: &[(u16, i32)]| {
        WheelProfile::generic("x", &axes.iter().copied().collect(), &now.iter().copied().collect())
    };
    // Axis 0 has no range, and 16 is the first hat: axis 1 steers, 15 is the accelerator, and there is no brake.
    let axes = [(0, [5, 5]), (1, [-100, 300]), (15, [10, 20]), (16, [-1, 1])];
    let profile = guess(&axes, &[(15, 20)]).unwrap();
    let s = &profile.steering;
    assert_eq!((s.axis, s.left, s.centre, s.right), (1, -100, 100, 300));
    assert_eq!((profile.accelerator.axis, profile.brake), (15, None));
    // A pedal in the middle or without a value is taken to rest high, as the pedals of most wheels do.
    for (raw, released) in [(10, 10), (14, 10), (15, 20), (16, 20), (20, 20)] {
        let pedal = guess(&axes, &[(15, raw)]).unwrap().accelerator;
        assert_eq!((pedal.released, pedal.pressed), (released, 30 - released), "at {raw}");
    }
    assert_eq!(guess(&axes, &[]).unwrap().accelerator.released, 20);
    let three = guess(&[(0, [0, 9]), (1, [0, 9]), (2, [0, 9]), (3, [0, 9])], &[]).unwrap();
    assert_eq!((three.accelerator.axis, three.brake.map(|brake| brake.axis)), (1, Some(2)));
    for few in [&axes[..2], &[(1, [0, 9]), (16, [-1, 1])], &[]] {
        assert!(guess(few, &[]).unwrap_err().0.starts_with("x has fewer than two axes"));
    }
}

#[test]
fn each_action_has_a_description() {
    let words = ButtonAction::ALL.map(|action| action.to_string());
    let expected = [
        "start, continue",
        "drive, reverse",
        "indicate left",
        "indicate right",
        "main beam",
        "respond to the secondary task",
        "automation on, off",
        "time gap of the automation",
        "horn",
        "mark this moment",
        "answer",
        "driver's view, back onto the lane",
        "ask to end the drive",
        "handbrake",
    ];
    assert_eq!(words, expected);
}

const WITH_PARTS: &str = "[buttons]
reverse = [293]
horn = [289, \"288 of 0eb7:183b\", \"288 of 2341:8036 at usb-1/input0\"]";

#[test]
fn buttons_of_further_devices_are_read_and_written_with_their_device() {
    let text = G29[..G29.find("# evdev codes").unwrap()].to_owned() + WITH_PARTS;
    let mut profile = WheelProfile::from_toml(&text, "rig").unwrap();
    assert_eq!(WheelProfile::from_toml(&profile.to_toml(), "again").unwrap(), profile);
    assert!(profile.to_toml().contains("reverse = [293]"), "{}", profile.to_toml());
    assert!(!profile.to_toml().contains("handbrake"), "{}", profile.to_toml());
    let place = |port: &str| parts::Place { port: port.into(), ..parts::Place::default() };
    let part = |id, port| Part { id, place: place(port) };
    let there =
        [part((0x2341, 0x8036), "usb-2/input0"), part((0x2341, 0x8036), "usb-1/input0"), part((0x0eb7, 0x183b), "")];
    profile.find_parts(&there).unwrap();
    let codes: Vec<u16> = profile.buttons.horn.iter().map(super::super::buttons::RigButton::code).collect();
    assert_eq!(codes, [289, 288 + 3 * parts::BUTTON_PART, 288 + 2 * parts::BUTTON_PART]);
    assert_eq!(profile.buttons.action(288 + 2 * parts::BUTTON_PART), Some(ButtonAction::Horn));
    assert_eq!((profile.buttons.action(288), profile.buttons.action(288 + parts::BUTTON_PART)), (None, None));
    assert!(profile.uses_part(0) && !profile.uses_part(1) && profile.uses_part(2) && profile.uses_part(3));
    let message = profile.find_parts(&there[..2]).unwrap_err().0;
    assert!(message.contains("the device of the button \"horn\", 0eb7:183b, is not plugged in"), "{message}");
}

#[test]
fn a_text_that_is_no_button_is_refused_with_the_form_that_is_allowed() {
    let text = |button: &str| G29.replace("horn = [289]", &format!("horn = [{button}]"));
    for button in ["\"square\"", "\"768 of 0eb7:183b\"", "\"288 of\"", "768"] {
        let message = WheelProfile::from_toml(&text(button), "mine.toml").unwrap_err().0;
        assert!(message.contains("is no button; allowed: a number up to 767"), "{message}");
    }
    let message = WheelProfile::from_toml(&text("true"), "mine.toml").unwrap_err().0;
    assert!(message.contains("expected the number of a button"), "{message}");
    let message = WheelProfile::from_toml(&text("\"288 of shifter\""), "mine.toml").unwrap_err().0;
    assert!(message.contains("buttons: \"shifter\" is no USB id; allowed: VENDOR:PRODUCT"), "{message}");
}

#[test]
fn a_handbrake_needs_an_axis_of_its_own() {
    let mut profile = WheelProfile::from_toml(G29, "g29").unwrap();
    let on = |profile: &mut WheelProfile, axis| {
        profile.handbrake = Some(Pedal { axis, ..profile.accelerator.clone() });
        WheelProfile::from_toml(&profile.to_toml(), "x").map_err(|error| error.0)
    };
    assert_eq!(on(&mut profile, 1).unwrap(), profile);
    let message = on(&mut profile, 5).unwrap_err();
    assert!(message.contains("handbrake.axis: axis 5 already has another task"), "{message}");
    let combined = |pressed| Pedal { released: 128, pressed, ..profile.accelerator.clone() };
    (profile.accelerator, profile.brake) = (combined(0), Some(combined(255)));
    assert!(on(&mut profile, 2).is_err(), "two pedals may share an axis, a lever may not");
}

#[test]
fn a_handbrake_does_not_hide_pedals_that_are_upside_down() {
    let mut profile = WheelProfile::from_toml(G29, "g29").unwrap();
    profile.handbrake = Some(Pedal { axis: 0, released: 0, pressed: 255, part: 1, ..profile.accelerator.clone() });
    let axes = [(0, [0, 65_535]), (1, [0, 255]), (2, [0, 255]), (5, [0, 255]), (PART, [0, 255])].into();
    let values = [(0, 32_767), (1, 0), (2, 0), (5, 0), (PART, 0)].into();
    assert!(profile.pedals_upside_down(&axes, &values));
}
