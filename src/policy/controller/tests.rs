//! Controllers by name and by file: the same bits, the same drive, and the messages for faulty files.

use super::*;
use crate::{
    policy::{Action, Advisor, Hold, NAMES, Observation, PolicySettings, build},
    time::Tick,
};
use std::fs;

const SETTINGS: PolicySettings = PolicySettings { aim_mps: 0.0, equilibrium_mps: 4.362, step_s: 0.1 };

/// Returns a controller with numbers within the limits that have no short decimal form.
fn odd(kind: ControllerKind) -> Controller {
    let shares = [1.0 / 3.0, 1.0 / 7.0, 1.0 / 11.0, 1.0 / 13.0, 1.0 / 17.0, 1.0 / 19.0, 1.0 / 23.0];
    let between = |(parameter, share): (&Parameter, f64)| {
        let [low, high] = parameter.limits;
        low + (high - low) * share
    };
    Controller::of_ordered(kind, &kind.parameters().iter().zip(shares).map(between).collect::<Vec<_>>())
}

#[test]
fn every_controllers_file_reads_back_to_the_same_bits() {
    for kind in CONTROLLERS {
        for controller in [Controller::by_name(kind, &SETTINGS), odd(kind)] {
            let text = ControllerFile::from(controller).to_toml("Made by a test\nof two lines");
            assert!(
                text.starts_with("# Made by a test\n# of two lines\nformat = \"codrive controller 1\"\n"),
                "{text}"
            );
            assert!(is_controller(&text));
            let read = ControllerFile::from_toml(&text, "own.toml").unwrap_or_else(|e| panic!("{e}\n{text}"));
            assert_eq!(read.advised_share, 0.0);
            let read = read.controller;
            let bits = |controller: &Controller| controller.numbers().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!((read.kind(), bits(&read)), (kind, bits(&controller)), "{text}");
        }
    }
}

#[test]
fn the_file_gives_the_unit_and_meaning_of_each_parameter() {
    let text = ControllerFile::from(Controller::by_name(ControllerKind::FollowerStopper, &SETTINGS)).to_toml("");
    // Numbers from docs/references.md: follower-stopper.
    assert!(text.contains("\n# Target speed if the gap allows it, m/s\naim_mps = 4.29"), "{text}");
    assert!(text.contains("\ndx0_m = [4.5, 5.25, 6.0]\n") && text.contains("\nd_mps2 = [1.5, 1.0, 0.5]\n"), "{text}");
    for kind in CONTROLLERS {
        for parameter in kind.parameters() {
            assert!(!parameter.key.is_empty() && !parameter.doc.is_empty());
            let [low, high] = parameter.search_range(4.362);
            assert!(low < high && parameter.allows(low) && parameter.allows(high), "{}", parameter.key);
        }
    }
}

/// Drives an ego that follows the advice behind a leader whose speed oscillates, and returns the advice.
fn drive(name: &str) -> Vec<(Tick, u64)> {
    let policy = build(name, &SETTINGS).unwrap_or_else(|e| panic!("{e}"));
    let mut advisor = Advisor::new(policy, Hold::of_steps(3, 0.1), 0.5);
    let (mut speed_mps, mut gap_m) = (3.0, 9.0);
    let step = |k: u64| {
        let leader_speed_mps = 3.0 + 3.0 * (k as f64 * 0.02).sin();
        let seen = Observation {
            speed_mps,
            leader_speed_mps,
            gap_m,
            circumference_m: 250.0,
            vehicles: 22,
            ..Default::default()
        };
        let issued = advisor.step(Tick(k * 10), &seen, 30.0);
        let target_mps = advisor.standing().map_or(speed_mps, |advice| advice.target_mps);
        speed_mps += (target_mps - speed_mps).clamp(-0.45, 0.15);
        gap_m = (gap_m + (leader_speed_mps - speed_mps) * 0.1_f64).clamp(0.5, 40.0);
        issued.map(|advice| (advice.issued, advice.target_mps.to_bits()))
    };
    (0..2000).filter_map(step).collect()
}

#[test]
fn a_name_and_its_file_advise_the_same_over_a_drive() {
    let folder = tempfile::tempdir().unwrap();
    for kind in CONTROLLERS {
        let file = folder.path().join(format!("{}.toml", kind.name()));
        fs::write(&file, ControllerFile::from(Controller::by_name(kind, &SETTINGS)).to_toml("")).unwrap();
        let (by_name, by_file) = (drive(kind.name()), drive(file.to_str().unwrap()));
        assert_eq!(by_name.len(), 667);
        assert_eq!(by_name, by_file, "{}", kind.name());
    }
}

#[test]
fn names_build_what_their_authors_published() {
    // docs/references.md: follower-stopper and pi; advice: 2.5 m/s for 60 s, and 98.5 % of 4.362 m/s.
    let aim_mps = 0.985 * 4.362;
    let numbers = |name| Controller::by_name(ControllerKind::named(name).unwrap(), &SETTINGS).numbers();
    assert_eq!(numbers("constant"), [aim_mps]);
    assert_eq!(numbers("two-phase"), [2.5, 60.0, aim_mps]);
    assert_eq!(numbers("follower-stopper"), [aim_mps, 4.5, 5.25, 6.0, 1.5, 1.0, 0.5]);
    assert_eq!(numbers("pi"), [38.0, 7.0, 30.0, 1.0, 4.0, 2.0, 2.0]);
    assert_eq!(NAMES[1..], CONTROLLERS.map(ControllerKind::name));
}

#[test]
fn a_faulty_file_is_refused_with_line_value_and_allowed_values() {
    const HEAD: &str = "format = \"codrive controller 1\"\n";
    let two_phase = |lines: &str| format!("{HEAD}kind = \"two-phase\"\n{lines}");
    let stopper = |lists: &str| format!("{HEAD}kind = \"follower-stopper\"\naim_mps = 4\n{lists}");
    let table: [(String, &[&str]); 16] = [
        ("kind = \"pi\"\n".into(), &["own.toml:1:1: format is missing; allowed: \"codrive controller 1\""]),
        ("format = \"codrive controller 2\"".into(), &["own.toml:1:10: format is \"codrive controller 2\"; allowed"]),
        (HEAD.into(), &["kind is missing; allowed: constant, two-phase, follower-stopper, pi, linear-feedback"]),
        (
            format!("{HEAD}kind = \"two-phsae\""),
            &["own.toml:2:8: kind is \"two-phsae\" (did you mean two-phase?); allowed: constant"],
        ),
        (format!("{HEAD}kind = 3"), &["own.toml:2:8: kind is 3; allowed: constant"]),
        (
            two_phase("slow_mps = 2\nslow_s = 40\nthan_mps = 4"),
            &["own.toml:5:1: unknown key `than_mps`; did you mean `then_mps`?", "5 | than_mps = 4\n  | ^^^^^^^^"],
        ),
        (
            two_phase("slow_mps = 2\nthen_mps = 4"),
            &["key `slow_s` is missing: Length of the first phase\n  remedy: give it a number from 0 to 36000 s"],
        ),
        (
            two_phase("slow_mps = 2\nslow_s = -1\nthen_mps = 4"),
            &["own.toml:4:10: slow_s is -1; allowed: a number from 0 to 36000 s"],
        ),
        (two_phase("slow_mps = 2\nslow_s = nan\nthen_mps = 4"), &["own.toml:4:10: slow_s is nan; allowed: a number"]),
        (
            two_phase("slow_mps = \"2\"\nslow_s = 1\nthen_mps = 4"),
            &["own.toml:3:12: slow_mps is \"2\"; allowed: a num"],
        ),
        (two_phase("slow_mps = = 2"), &["own.toml:3:12: "]),
        (
            two_phase("slow_mps = 2\nslow_s = 1\nthen_mps = 4\nadvised_share = 25"),
            &["own.toml:6:17: advised_share is 25; allowed: 0 (one vehicle) to 1 (all)"],
        ),
        (
            stopper("dx0_m = [4.5, 5.25]\nd_mps2 = [1.5, 1, 0.5]"),
            &["own.toml:4:9: dx0_m is [4.5, 5.25]; allowed: a list of 3 numbers, such as [0.5, 0.6, 0.7]"],
        ),
        (
            stopper("dx0_m = [4.5, 4.5, 6]\nd_mps2 = [1.5, 1, 0.5]"),
            &["own.toml:4:15: dx0_m.1 is 4.5; allowed: above dx0_m.0, which is 4.5"],
        ),
        (
            stopper("dx0_m = [4.5, 5.25, 6]\nd_mps2 = [1.5, 1, 1.25]"),
            &["own.toml:5:19: d_mps2.2 is 1.25; allowed: not above d_mps2.1, which is 1"],
        ),
        (
            stopper("dx0_m = [4.5, 5.25, 6]\nd_mps2 = [1.5, 0, 0.5]"),
            &["own.toml:5:16: d_mps2.1 is 0; allowed: a number from 0.01 to 20 m/s2"],
        ),
    ];
    for (text, parts) in table {
        let message = ControllerFile::from_toml(&text, "own.toml").unwrap_err().to_string();
        for part in parts {
            assert!(message.contains(part), "{text}\n---\n{message}\nlacks\n{part}");
        }
    }
}

#[test]
fn all_mistakes_of_a_file_are_in_one_report() {
    let text = "format = \"codrive controller 1\"\nkind = \"two-phase\"\nslow_mps = 1000\nslow_s = true\nthan_mps = 4\nadvised_share = 2\n";
    let report = ControllerFile::from_toml(text, "own.toml").unwrap_err().to_string();
    let places: Vec<&str> = report.lines().filter(|line| line.starts_with("own.toml:")).collect();
    let wanted =
        ["3:12: slow_mps is 1000", "4:10: slow_s is true", "5:1: unknown key `than_mps`", "6:17: advised_share is 2"];
    assert_eq!(places.len(), wanted.len(), "{report}");
    for (place, wanted) in places.iter().zip(wanted) {
        assert!(place["own.toml:".len()..].starts_with(wanted), "{report}");
    }
}

#[test]
fn a_policy_knows_the_share_of_vehicles_that_its_file_states() {
    let controller = Controller::by_name(ControllerKind::Constant, &SETTINGS);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("own.toml");
    for advised_share in [0.0, 0.25, 1.0] {
        fs::write(&file, ControllerFile { controller, advised_share }.to_toml("")).unwrap();
        let policy = build(file.to_str().unwrap(), &SETTINGS).unwrap().unwrap();
        assert_eq!(policy.advised_share(), advised_share);
    }
}

#[test]
fn a_file_is_read_as_the_format_that_it_declares() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("own.toml");
    let message = |text: &str| {
        fs::write(&file, text).unwrap();
        build(file.to_str().unwrap(), &SETTINGS).err().map(|e| e.to_string()).unwrap_or_default()
    };
    let path = file.display();
    assert!(
        message("format = \"codrive controller 1\"\nkind = \"constnat\"").starts_with(&format!("policy {path}:2:8: "))
    );
    assert!(message("kind = \"constant\"\nspeed_mps = 4").contains(":1:1: format is missing"));
    assert!(message("format = \"codrive policy 1\"").contains("is not a policy file"));
    let right = "format = \"codrive controller 1\"\nkind = \"constant\"\nspeed_mps = 4";
    assert_eq!(message(right), "");
    let mut policy = build(file.to_str().unwrap(), &SETTINGS).ok().flatten().unwrap();
    assert_eq!(policy.act(0.0, &Observation::default()), Action::Speed(4.0));
    let gone = build(folder.path().join("owm.toml").to_str().unwrap(), &SETTINGS).err().unwrap().to_string();
    assert!(gone.contains("cannot be read") && gone.contains("did you mean own.toml?"), "{gone}");
}
