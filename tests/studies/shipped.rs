//! The shipped studies: comparisons, duration and balance.

use super::study::{load, shipped};
use codrive::{
    scenario::{AutomationSystem, Scenario, SecondaryTaskKind, scripted_event::Action},
    study::{PlanItem, Study},
};
use std::{collections::BTreeMap, path::Path};

/// Returns names and scenarios of the first participant's drives.
fn drives(study: &Study) -> Vec<(String, Scenario)> {
    let items = study.plan(0).items.into_iter();
    items
        .filter_map(|planned| match planned.item {
            PlanItem::Drive { scenario, .. } => Some((planned.name, *scenario)),
            _ => None,
        })
        .collect()
}

#[test]
fn the_short_study_follows_the_paper_in_thirty_minutes_and_its_rests() {
    // HC22: thirty minutes, seven of them for practice, and three trials of five minutes.
    let study = load("congestion-short");
    let drives = drives(&study);
    assert_eq!(drives.iter().map(|d| d.1.duration_s).collect::<Vec<_>>(), [420.0, 300.0, 300.0, 300.0]);
    assert_eq!(
        drives.iter().map(|d| d.1.map.as_str()).collect::<Vec<_>>(),
        ["town", "ring-250", "ring-250", "ring-250"]
    );
    for index in 0..6 {
        // HC22 does not say how long its short breaks are. Two minutes between the trials come on top of the thirty.
        let plan = study.plan(index);
        let rests = plan.items.iter().filter_map(|planned| match planned.item {
            PlanItem::Break(seconds) => Some((planned.name.as_str(), seconds)),
            _ => None,
        });
        assert_eq!(rests.collect::<Vec<_>>(), [("trial-rest-1", 120.0), ("trial-rest-2", 120.0)]);
        let rests_min = 2.0 * 2.0;
        assert!(plan.minutes() <= 30.0 + rests_min, "{} min", plan.minutes());
    }
    assert!(study.file.participants.is_multiple_of(6), "every order of three as often");
}

/// HC22 varies range, density and the others' model. This comparison is within participants: with advice against without.
#[test]
fn the_shipped_study_compares_advice_with_none_and_with_a_sham() {
    let study = shipped();
    let drives = drives(&study);
    assert_eq!(drives.len(), 1 + 4 * 2 * 2);
    let trials = &drives[1..];
    let with = |level: &str| trials.iter().filter(|(name, _)| name.contains(level)).map(|(_, drive)| drive).collect();
    let [none, sham, dense, hesitant]: [Vec<&Scenario>; 4] = ["none", "sham", "dense", "hesitant"].map(with);
    assert!(none.len() == 4 && none.iter().all(|drive| drive.policy == "none"));
    assert!(sham.len() == 4 && sham.iter().all(|drive| drive.sham_advice && drive.policy != "none"));
    assert!(dense.len() == 8 && dense.iter().all(|drive| drive.vehicles == 24));
    assert!(hesitant.len() == 8 && hesitant.iter().all(|drive| (drive.idm.t, drive.idm.a) == (1.2, 0.8)));
    assert!(trials.iter().all(|(_, drive)| drive.standing_start && drive.wave_sd_mps >= 2.0));
    assert!(study.file.participants.is_multiple_of(16), "every order as often");
    // A visit is booked for two hours: twenty minutes are for arrival, the information sheet and problems.
    assert!(study.plan(0).minutes() < 100.0, "{} min", study.plan(0).minutes());
    for study in [study, load("congestion-short"), load("congestion-people")] {
        study.check_ranges("it").unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn the_study_of_automation_has_the_same_car_with_and_without_it() {
    let study = load("advice-or-automation");
    study.check_ranges("it").unwrap_or_else(|e| panic!("{e}"));
    let drives = drives(&study);
    let trials: Vec<(AutomationSystem, &str, f64)> = drives[1..]
        .iter()
        .map(|(_, drive)| (drive.automation.system, drive.policy.as_str(), drive.warm_up_s))
        .collect();
    let expected = [
        (AutomationSystem::None, "none", 300.0),
        (AutomationSystem::None, "ring-250-speed", 300.0),
        (AutomationSystem::Policy, "ring-250-speed", 300.0),
    ];
    assert_eq!(trials, expected);
    assert!(study.file.participants.is_multiple_of(6), "every order of three as often");
}

#[test]
fn the_people_study_compares_advice_with_none_in_three_worlds() {
    let study = load("congestion-people");
    let drives = drives(&study);
    assert_eq!(drives.len(), 1 + 2 * 3);
    for (world, vehicles) in [("ring-study", 21), ("safe-followers", 20), ("gap-closers", 21)] {
        let of: Vec<&Scenario> =
            drives.iter().filter(|(name, _)| name.ends_with(world)).map(|(_, drive)| drive).collect();
        assert_eq!(of.iter().filter(|drive| drive.policy == "none").count(), 1, "{world}");
        assert_eq!(of.len(), 2, "{world}");
        // The rings of the field experiments: 260 m with 20 and 21 people (docs/references.md: people).
        let is_as_measured = |drive: &&Scenario| {
            (drive.map.as_str(), drive.vehicles, drive.traffic_drivers.as_str()) == ("ring-260", vehicles, world)
        };
        assert!(of.iter().all(is_as_measured), "{world}");
    }
    let plan = study.file.analysis.as_ref().unwrap();
    for contrast in &plan.contrasts {
        let world = |name: &str| name.split_once('+').unwrap().1.to_owned();
        assert_eq!(world(&contrast.condition), world(&contrast.reference), "{}", contrast.label());
    }
    assert!(study.file.participants.is_multiple_of(6), "every order as often");
    // A visit is booked for two hours: twenty minutes are for arrival, the information sheet and problems.
    assert!(study.plan(0).minutes() < 100.0, "{} min", study.plan(0).minutes());
}

#[test]
fn studies_of_events_vary_one_number_of_them_and_the_task() {
    let numbers = |drive: &Scenario| -> Vec<f64> {
        let actions = drive.events.iter().flat_map(|event| &event.actions);
        let number = |action: &Action| match action {
            Action::Brake { decel_mps2, .. } => Some(*decel_mps2),
            Action::TakeoverRequest { lead_s, .. } => Some(*lead_s),
            _ => None,
        };
        actions.filter_map(number).collect()
    };
    for (name, levels, events) in
        [("lead-braking", [("gentle", 3.0), ("hard", 6.0)], 3), ("takeover", [("4-s", 4.0), ("8-s", 8.0)], 2)]
    {
        let study = load(name);
        study.check_ranges("it").unwrap_or_else(|e| panic!("{e}"));
        let drives = drives(&study);
        assert_eq!(drives.len(), 1 + 2 * 2, "{name}");
        for (level, expected) in levels {
            let of: Vec<_> = drives.iter().filter(|(item, _)| item.contains(level)).collect();
            assert_eq!(of.len(), 2, "{name}: {level}");
            for (item, drive) in of {
                assert_eq!(numbers(drive), vec![expected; events], "{name}: {item}");
                let has_task = drive.secondary_task.kind == SecondaryTaskKind::NBack;
                assert_eq!(has_task, item.contains("two-back"), "{name}: {item}");
            }
        }
        assert!(study.file.participants.is_multiple_of(4), "every order as often");
        // A visit is booked for an hour: half of it is for arrival, the information sheet and problems.
        assert!(study.plan(0).minutes() < 30.0, "{name}: {} min", study.plan(0).minutes());
    }
}

#[test]
fn mean_speed_and_its_deviation_are_primary_in_each_shipped_study() {
    for name in ["congestion", "congestion-short", "congestion-people", "advice-or-automation"] {
        let plan = load(name).file.analysis.unwrap();
        assert_eq!(plan.primary.all(), ["mean_speed_mps", "speed_sd_over_vehicles_mps"], "{name}");
    }
}

#[test]
fn all_studies_begin_with_consent_and_ask_about_conditions_and_sickness() {
    for name in
        ["congestion", "congestion-short", "congestion-people", "advice-or-automation", "lead-braking", "takeover"]
    {
        let study = load(name);
        let plan = study.plan(0);
        let begin: Vec<&str> = plan.items.iter().take(3).map(|planned| planned.name.as_str()).collect();
        assert_eq!(begin, ["consent", "screening", "demographics"]);
        assert!(study.is_consent(&plan.items[0]));
        for segment in study.file.segment.iter().filter(|segment| segment.has_drives()) {
            assert_eq!(segment.fms_every_s, Some(60.0), "{name}: {}", segment.name);
            assert_eq!(segment.stop_above.as_ref().map(|limit| limit.score.as_str()), Some("fms"));
        }
        // Each participant fills in the SSQ before the trials, and a score above the limit ends the session.
        let at = |name: &str| plan.items.iter().position(|planned| planned.segment == name).unwrap();
        let ssq = study.file.segment.iter().find(|segment| segment.questionnaire.as_deref() == Some("ssq")).unwrap();
        assert!(ssq.stop_above.is_some() && at(&ssq.name) < at("trial"), "{name}");
        for trial in drives(&study).into_iter().filter(|(item, _)| item.starts_with("trial-")) {
            let asked = |word: &str| plan.items.iter().any(|planned| planned.name == format!("{}-{word}", trial.0));
            // Participants without advice cannot rate their trust in it.
            assert_eq!((asked("raw-tlx"), asked("trust")), (true, trial.1.policy != "none"), "{name}: {}", trial.0);
        }
    }
}

#[test]
fn a_range_too_small_for_the_dial_is_refused_where_it_is_set() {
    let text = "title = \"t\"\nparticipants = 2\n[base]\ntraffic = \"native\"\n[[condition]]\nname = \"none\"\nset = { policy = \
                \"none\", range_mph = 0.5 }\n[[condition]]\nname = \"b\"\nset = { range_mph = 0.5 }\n[[segment]]\nkind = \
                \"trials\"\nname = \"trial\"\n";
    let check = |text: &str| Study::parse(text.into(), Path::new("t.toml")).unwrap().check_ranges("t.toml");
    let message = check(text).unwrap_err().0;
    assert!(
        message.starts_with("t.toml:10:21: range_mph is 0.5; allowed: 0.650 or more on a speedometer in mph"),
        "{message}"
    );
    // A dial in km/h has finer steps, and a condition without advice shows no range.
    assert!(check(&text.replace("[base]", "[base]\nunits = \"kmh\"")).is_ok());
    assert!(check(&text.replace("set = { range_mph = 0.5 }", "")).is_ok());
}

#[test]
fn conditions_are_balanced_over_places_and_every_drive_has_its_own_seed() {
    let study = shipped();
    let mut places: BTreeMap<(usize, String), usize> = BTreeMap::new();
    let mut seeds = Vec::new();
    for index in 0..32 {
        let plan = study.plan(index);
        for (place, name) in plan.order.iter().enumerate() {
            *places.entry((place, name.clone())).or_default() += 1;
        }
        seeds.extend(plan.items.iter().filter_map(|p| match &p.item {
            PlanItem::Drive { scenario, .. } => Some(scenario.seed),
            _ => None,
        }));
        assert_eq!(plan, study.plan(index), "the same number, the same plan");
    }
    assert!(places.len() == 16 * 16 && places.values().all(|n| *n == 2), "{places:?}");
    let count = seeds.len();
    seeds.sort_unstable();
    seeds.dedup();
    assert_eq!(seeds.len(), count);
}
