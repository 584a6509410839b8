//! Properties of profiles: maps from raw values to wheel and pedals, and what is said of a wrong file.

use super::*;
use crate::rng::{self, Stream};

const G29: &str = include_str!("../../assets/wheels/g29.toml");

/// A whole number in `low..high`.
fn whole(random: &mut Stream, low: i32, high: i32) -> i32 {
    random.uniform(low.into(), high.into()) as i32
}

/// A profile of a device that nobody has built.
fn random_pedal(random: &mut Stream) -> Pedal {
    let released = whole(random, -70_000, 70_000);
    let way = whole(random, 2, 70_000);
    let pressed = if random.index(2) == 0 { released + way } else { released - way };
    let [dead, end] = [random.uniform(0.0, 0.4), random.uniform(0.0, 0.4)];
    Pedal { axis: 2, released, pressed, dead, end, curve: random.uniform(0.3, 4.0) }
}

#[test]
fn every_pedal_is_zero_at_rest_one_at_the_floor_and_never_goes_back_between() {
    let mut random = rng::stream(7, "pedals");
    for _ in 0..2000 {
        let pedal = random_pedal(&mut random);
        assert_eq!(pedal.effect(pedal.released), 0.0, "{pedal:?}");
        assert_eq!(pedal.effect(pedal.pressed), 1.0, "{pedal:?}");
        let at = |i: i32| {
            let raw = f64::from(pedal.released) + f64::from(pedal.pressed - pedal.released) * f64::from(i) / 400.0;
            pedal.effect(raw.round() as i32)
        };
        assert!((-40..440).all(|i| at(i + 1) >= at(i)), "{pedal:?}");
        assert!((0..=1).all(|i| (0.0..=1.0).contains(&at(i * 500 - 100))), "beyond the ends: {pedal:?}");
    }
}

#[test]
fn every_wheel_is_straight_at_its_centre_and_turns_through_its_full_range_without_a_step() {
    let mut random = rng::stream(8, "wheels");
    for _ in 0..2000 {
        let (half_left, half_right) = (whole(&mut random, 500, 40_000), whole(&mut random, 500, 40_000));
        let sign = if random.index(2) == 0 { 1 } else { -1 };
        let centre = whole(&mut random, -1000, 40_000);
        let wheel = Steering {
            axis: 0,
            left: centre - sign * half_left,
            centre,
            right: centre + sign * half_right,
            range_deg: random.uniform(180.0, 1440.0),
            ratio: 15.0,
            dead: random.uniform(0.0, 0.2),
        };
        let end = (wheel.range_deg / 2.0).to_radians();
        assert_eq!(wheel.wheel_rad(centre), 0.0);
        assert!((wheel.wheel_rad(wheel.left) - end).abs() < 1e-9, "{wheel:?}");
        assert!((wheel.wheel_rad(wheel.right) + end).abs() < 1e-9, "{wheel:?}");
        // A raw count is at least 1/500 of a half range, and the dead zone makes the rest steeper by 1/(1 - dead).
        let most = end / f64::from(half_left.min(half_right)) / (1.0 - wheel.dead) + 1e-9;
        for _ in 0..50 {
            let raw = whole(&mut random, centre - 45_000, centre + 45_000);
            let change = f64::from(sign) * (wheel.wheel_rad(raw + 1) - wheel.wheel_rad(raw));
            assert!((-most..=0.0).contains(&change), "{change} at {raw}: {wheel:?}");
        }
    }
}

#[test]
fn a_g29_reaches_the_cars_lock_on_both_sides() {
    let profile = Profile::from_toml(G29, "g29").unwrap();
    assert_eq!(profile.steering.car_rad(0), STEERING_LOCK_RAD);
    assert_eq!(profile.steering.car_rad(65_535), -STEERING_LOCK_RAD);
    assert_eq!(profile.steering.car_rad(32_767), 0.0);
    let quick = Steering { ratio: 7.5, ..profile.steering };
    let quarter = quick.car_rad(24_575);
    assert!((quarter - STEERING_LOCK_RAD / 2.0).abs() < 1e-3, "half the ratio, twice the answer: {quarter}");
}

#[test]
fn a_wrong_profile_is_named_with_file_line_value_and_remedy() {
    let told = |text: &str| Profile::from_toml(text, "mine.toml").unwrap_err().0;
    let text = told(&G29.replace("pressed = 0", "pressed = 255"));
    assert!(text.starts_with("mine.toml:15:11: accelerator.pressed: 255 is also the released value"), "{text}");
    assert!(text.contains("codrive calibrate"), "{text}");
    let text = told(&G29.replace("curve = 1.6", "curve = 9"));
    assert!(text.contains(": brake.curve: 9 is not allowed; allowed: 0.3 to 4"), "{text}");
    let text = told(&G29.replace("axis = 5", "axis = 2"));
    assert!(text.contains(": brake.axis: 2 has another task already"), "{text}");
    assert!(told("name = 3").starts_with("mine.toml:1:8: invalid type"), "{}", told("name = 3"));
    assert!(told(&G29.replace("[force]", "[forse]")).contains("unknown key `forse`"));
    assert!(told("name = \"x\"").contains("missing key `steering`"));
    assert!(told("steering = [[[").starts_with("mine.toml:1:"));
    let text = told(&G29.replace("full_nm = 2.1", "full_nm = 1.0"));
    assert!(text.contains("force.cap_nm: 1.8 is not allowed; allowed: 0 to 1"), "{text}");
}
