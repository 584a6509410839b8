//! Search, force and messages of wheels, without a wheel.

use super::{super::parts::Place, *};

const G29: (u16, u16) = (0x046d, 0xc24f);
fn node(path: &str) -> DeviceNode {
    DeviceNode {
        path: path.into(),
        name: "Logitech G29".into(),
        id: G29,
        place: Place::default(),
        kind: DeviceKind::Wheel,
    }
}

fn g29() -> WheelProfile {
    profiles::named("g29").unwrap()
}

#[test]
fn a_refused_wheel_is_reported_with_the_udev_rule_other_errors_without_it() {
    let wheel = node("/dev/input/event7");
    let message = trouble(&wheel, &io::ErrorKind::PermissionDenied.into());
    assert!(message.starts_with("Logitech G29 may not be opened (/dev/input/event7: permission denied)\n  remedy: "));
    assert!(message.contains(UDEV_RULE) && message.contains(UDEV_FILE), "{message}");
    let message = trouble(&wheel, &io::Error::from_raw_os_error(nix::libc::ENODEV));
    assert!(message.starts_with("Logitech G29 cannot be opened (/dev/input/event7: No such device"), "{message}");
    assert!(message.contains("remedy: unplug it") && !message.contains(UDEV_FILE), "{message}");
}

#[test]
fn the_packaged_udev_rules_cover_all_shipped_wheels_and_their_lamps() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let rules = std::fs::read_to_string(root.join("assets/package/70-codrive-wheel.rules")).unwrap();
    let lines: Vec<&str> = rules.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).collect();
    let mut expected = vec![UDEV_RULE.to_owned(), crate::input::lamps::UDEV_RULE.to_owned()];
    for profile in std::fs::read_dir(root.join("assets/wheels")).unwrap() {
        let text = std::fs::read_to_string(profile.unwrap().path()).unwrap();
        let file: toml::Table = text.parse().unwrap();
        for product in file["products"].as_array().unwrap() {
            let (vendor, product) = product.as_str().unwrap().split_once(':').unwrap();
            expected.push(format!(
                r#"SUBSYSTEM=="input", KERNEL=="event*", ATTRS{{idVendor}}=="{vendor}", ATTRS{{idProduct}}=="{product}", TAG+="uaccess""#
            ));
        }
    }
    expected.sort();
    let mut found: Vec<String> = lines.into_iter().map(str::to_owned).collect();
    found.sort();
    assert_eq!(found, expected);
}

#[test]
fn without_strength_no_force_is_opened_and_with_it_a_failure_is_reported() {
    let nowhere = node("/nowhere/event0");
    let mut profile = g29();
    profile.force.strength = 0.0;
    assert!(matches!(force(&nowhere, &profile), Ok(None)));
    profile.force.strength = 0.3;
    let message = |profile: &WheelProfile| force(&nowhere, profile).err().expect("there is no such device").to_string();
    let text = message(&profile);
    assert!(text.starts_with("Logitech G29 gives no force (No such file"), "{text}");
    assert!(text.contains("the drive continues without force\n  remedy: codrive doctor"), "{text}");
    profile.force.backend = ForceBackend::Sdl;
    assert!(message(&profile).contains("SDL2"), "{}", message(&profile));
    assert_eq!(capabilities(&nowhere).unwrap_err().kind(), io::ErrorKind::NotFound);
}

#[test]
fn an_effect_pushes_along_the_wheel_and_has_no_end() {
    // linux/input.h: direction 0xC000 is right, a length of 0 is endless; strengths are 0 to 0xFFFF.
    let effect = constant(-21_760);
    assert_eq!((effect.direction, effect.replay.length, effect.replay.delay), (0xC000, 0, 0));
    let FFEffectKind::Constant { level, envelope } = effect.kind else { panic!("no constant force") };
    assert_eq!((level, envelope.attack_length, envelope.fade_length), (-21_760, 0, 0));
    assert_eq!([0.0, 0.5, 1.0].map(strength), [0, 0x7FFF, 0xFFFF]);
}

#[test]
fn a_new_profile_is_used_at_the_next_search() {
    let mut port = EvdevPort { asked: None, seen: Some(Vec::new()) };
    let learnt = WheelProfile { name: "Rig 1".into(), ..g29() };
    port.prefer(learnt.clone());
    assert_eq!((port.asked, port.seen), (Some(learnt), None));
}
