//! The studies that are shipped: what they compare, how long they take, that they are balanced.

use super::study::{load, shipped};
use codrive::{
    scenario::Scenario,
    study::{PlanItem, Study},
};
use std::{collections::BTreeMap, path::Path};

/// Names and scenarios of the drives of the first participant.
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
fn the_short_study_is_the_plan_of_the_paper_in_thirty_minutes() {
    // HC22: thirty minutes, seven of them to get used to the car, three trials of five.
    let study = load("congestion-short");
    let drives = drives(&study);
    assert_eq!(drives.iter().map(|d| d.1.duration_s).collect::<Vec<_>>(), [420.0, 300.0, 300.0, 300.0]);
    assert_eq!(
        drives.iter().map(|d| d.1.map.as_str()).collect::<Vec<_>>(),
        ["practice", "ring-250", "ring-250", "ring-250"]
    );
    assert!(study.plan(0).minutes() <= 30.0, "{} min", study.plan(0).minutes());
    assert!(study.file.participants.is_multiple_of(6), "every order of three as often");
}

/// HC22 varies range, density and the others' model; what counts is a person with advice against the same person without.
#[test]
fn the_shipped_study_compares_advice_with_none_and_with_a_sham_in_one_wave_from_a_standstill() {
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
    assert!(study.plan(0).minutes() < 75.0, "{} min", study.plan(0).minutes());
    for study in [study, load("congestion-short")] {
        study.check_ranges("it").unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn a_range_that_the_dial_cannot_tell_apart_is_refused_where_it_is_set() {
    let text = "title = \"t\"\nparticipants = 2\n[base]\ntraffic = \"native\"\n[[condition]]\nname = \"none\"\nset = { policy = \
                \"none\", range_mph = 0.5 }\n[[condition]]\nname = \"b\"\nset = { range_mph = 0.5 }\n[[segment]]\nkind = \
                \"trials\"\nname = \"trial\"\n";
    let check = |text: &str| Study::parse(text.into(), Path::new("t.toml")).unwrap().check_ranges("t.toml");
    let told = check(text).unwrap_err().0;
    assert!(
        told.starts_with("t.toml:10:21: range_mph is 0.5; allowed: 0.650 or more on a speedometer in mph"),
        "{told}"
    );
    // A dial in km/h has finer steps, and one without advice shows no range.
    assert!(check(&text.replace("[base]", "[base]\nunits = \"kmh\"")).is_ok());
    assert!(check(&text.replace("set = { range_mph = 0.5 }", "")).is_ok());
}

#[test]
fn every_condition_comes_as_often_at_every_place_and_every_drive_has_its_own_seed() {
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
