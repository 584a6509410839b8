//! Tests of the preregistration against the study file, and of its power against theory.

use super::*;
use crate::{
    analysis::{
        AnalysedRecording, DriveMeasures, DriveSetup, FoundRecording, StudyParticipants,
        data::driver_moments::DriverStretches,
        models::{normality::NormalityTest, plan::PlanHistory, planned::PlannedAnalysis},
    },
    rng,
};
use std::path::Path;

fn study(more: &str) -> Study {
    study_with(more, "")
}

/// Parses a study; `trial` has lines of its only segment.
fn study_with(more: &str, trial: &str) -> Study {
    let text = format!(
        "title = \"Ranges\"\nparticipants = 12\n[base]\ntraffic = \"native\"\nduration_s = 60.0\n{more}\n[factors]\nrange = [{{ name = \
         \"narrow\", set = {{ range_mph = 0.5 }} }}, {{ name = \"middle\" }}, {{ name = \"wide\", set = {{ range_mph = 2.0 }} }}]\n\
         [[segment]]\nkind = \"trials\"\nname = \"trial\"\n{trial}"
    );
    Study::parse(text, Path::new("x.toml")).unwrap_or_else(|e| panic!("{e}"))
}

const PLAN: &str = "[analysis]\nprimary = \"mean_speed_mps\"\nsmallest_effect = 0.3\nsecondary = [\"reaction_s\"]\ncontrasts = [{ \
                    condition = \"wide\", reference = \"narrow\", expected = \"less\" }, { condition = \"middle\", reference = \"narrow\" }]\n\
                    [analysis.exclude]\nmost_contacts = 0\n";

#[test]
fn the_text_states_design_order_rules_model_and_power() {
    let study = study(PLAN);
    let outcome = RehearsedOutcome {
        counts: [12, 36],
        deviations: [0.2, 0.4],
        per_place: -0.01,
        residuals: Some(NormalityTest { w: 0.97, p: 0.2 }),
    };
    let rehearsed = |outcomes| OutcomeSpread::Rehearsed { title: "Rehearsed".into(), is_simulated: true, outcomes };
    let spread = rehearsed(vec![outcome]);
    let text = written(&study, 12, &spread, 200, &|_| ()).unwrap();
    assert!(!text.contains("far from normal"));
    for part in [
        "12 participants, each with 3 trials, one in each of 3 conditions",
        "1. Mean speed of all vehicles is less in `wide` than in `narrow`.",
        "2. Mean speed of all vehicles differs between `middle` and `narrow`; no direction is expected.",
        "* Road: `ring-250`, a closed route of 250 m, with 22 vehicles (the participant's included).",
        // The ring study's model (docs/references.md: idm).
        "v0 = 30 m/s, time gap T = 1 s, acceleration a = 1 m/s², deceleration b = 1.5 m/s², exponent δ = 4, minimum gap s0 = 2 m",
        "each advice stands for 1 s; the acceptable range is the target ±1 mph",
        "* `narrow` of range: `range_mph` = 0.5",
        "They repeat after 6 participants.",
        "1. narrow, middle, wide",
        "With 12 participants every order is used 2 times.",
        "A participant with the same order replaces",
        "A trial is left out if there was a contact",
        "* Primary: Mean speed of all vehicles",
        "measure ~ condition + place + (1 | participant)",
        "alpha = 0.05 over all 4 tests",
        "Smallest effect of interest: 0.3 m/s",
        "0.200 m/s between and 0.400 m/s within participants, and \u{2212}0.010 m/s from position to position",
        "0.0125 for the strictest step",
        "| **12** | 0.3 m/s | ",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert_eq!(text, written(&study, 12, &spread, 200, &|_| ()).unwrap());
    // In theory the power is 0.953 for 48 participants (R: pt with noncentrality 0.3/0.4 sqrt(48/2), 93 degrees of freedom). Three
    // standard errors of 200 studies are 4.6 points.
    let row = text.lines().find(|line| line.starts_with("| 48 |")).unwrap();
    let share: f64 = row.split('|').nth(3).unwrap().trim().split(' ').next().unwrap().parse().unwrap();
    assert!((share - 95.3).abs() < 4.6, "{row}");
    let skewed = rehearsed(vec![RehearsedOutcome { residuals: Some(NormalityTest { w: 0.81, p: 1e-6 }), ..outcome }]);
    let text = written(&study, 12, &skewed, 20, &|_| ()).unwrap();
    assert!(text.contains("far from normal** (Shapiro and Wilk's W = 0.810, p < 0.001)"), "{text}");
}

#[test]
fn each_primary_outcome_has_its_hypotheses_effect_and_power() {
    let plan = PLAN
        .replace("primary = \"mean_speed_mps\"", "primary = [\"mean_speed_mps\", \"speed_sd_over_vehicles_mps\"]")
        .replace("smallest_effect = 0.3", "smallest_effect = [0.3, 0.5]")
        .replace("expected = \"less\"", "expected = [\"greater\", \"less\"]");
    let outcome =
        |sd: f64| RehearsedOutcome { counts: [12, 36], deviations: [0.2, sd], per_place: 0.0, residuals: None };
    let outcomes = vec![outcome(0.4), outcome(5.0)];
    let spread = OutcomeSpread::Rehearsed { title: "Rehearsed".into(), is_simulated: true, outcomes };
    let text = written(&study(&plan), 12, &spread, 20, &|_| ()).unwrap();
    for part in [
        "About the primary outcomes; all tests are two-sided.",
        "1. Mean speed of all vehicles is greater in `wide` than in `narrow`.",
        "3. Standard deviation of speed over vehicles is less in `wide` than in `narrow`.",
        "* Primary: Standard deviation of speed over vehicles",
        "* Secondary: Reaction time",
        "Smallest effect of interest: 0.3 m/s of `mean_speed_mps`; 0.5 m/s of `speed_sd_over_vehicles_mps`.",
        // Three outcomes and two contrasts.
        "over all 6 tests of the plan",
        "| 4 | primary | `speed_sd_over_vehicles_mps` | `middle` | `narrow` |\n| 5 | secondary | `reaction_s` | `wide` |",
        "### Power for `mean_speed_mps`",
        "5.000 m/s within participants",
        "| **12** | 0.5 m/s | ",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn questionnaires_are_not_trials_and_absent_advice_is_not_tested() {
    let none = "set = { policy = \"none\" }";
    let text = study(PLAN).source.replace("set = { range_mph = 0.5 }", none).replace("reaction_s", "time_in_range")
        + "after = [\"raw-tlx\"]\n";
    let study = Study::parse(text, Path::new("x.toml")).unwrap_or_else(|e| panic!("{e}"));
    let text = written(&study, 12, &OutcomeSpread::Unknown, 20, &|_| ()).unwrap();
    for part in [
        "each with 3 trials",
        "over all 2 tests of the plan (outcomes times contrasts), by Holm's correction. No test, because one of the \
         conditions has no trial with the measure: Share of time in range: wide − narrow; Share of time in range: \
         middle − narrow.",
        "0.0250 for the strictest step",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn the_rules_that_end_a_session_are_planned() {
    let rules = "fms_every_s = 60\nstop_above = { score = \"fms\", value = 10 }\n";
    let text = written(&study_with(PLAN, rules), 12, &OutcomeSpread::Unknown, 20, &|_| ()).unwrap();
    for part in [
        "* `trial`: every 60 s of a drive the participant rates sickness on the fast motion sickness scale, 0 to 20",
        "* `trial`: the session ends at that moment of the drive if the score `fms` is above 10.",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(
        written(&study(PLAN), 12, &OutcomeSpread::Unknown, 20, &|_| ())
            .unwrap()
            .contains("may stop at any moment.\n\n## Outcomes")
    );
}

#[test]
fn an_unbalanced_number_is_reported_and_default_effects_are_cohens() {
    let text = written(&study(PLAN), 10, &OutcomeSpread::Unknown, 20, &|_| ()).unwrap();
    assert!(
        text.contains(
            "**With 10 participants some orders are more frequent than others; with 12 all are equally frequent.**"
        ),
        "{text}"
    );
    assert!(text.contains("Cohen (1988)") && text.contains("| **10** | 0.8 residual SD | "), "{text}");
    let none = written(&study(""), 12, &OutcomeSpread::Unknown, 20, &|_| ()).unwrap_err().to_string();
    assert!(none.contains("has no [analysis]") && none.contains("remedy"), "{none}");
}

/// Returns the planned trials of a study with random values for every outcome.
fn driven(study: &Study, participants: usize) -> Vec<AnalysedRecording> {
    let mut stream = rng::stream(7, "driven");
    let mut drives = Vec::new();
    for person in 0..participants {
        for planned in study.plan(person).items {
            let (Some(condition), Some(run), PlanItem::Drive { scenario, policy, .. }) =
                (planned.condition, planned.run, planned.item)
            else {
                continue;
            };
            let mut values = vec![None; MEASURES.len()];
            for (value, measure) in values.iter_mut().zip(MEASURES) {
                let is_there = policy.name != "none" || !measure.needs_advice;
                *value = is_there.then(|| 5.0 + stream.normal());
            }
            values[MEASURES.iter().position(|measure| measure.name == "contact_count").unwrap()] = Some(0.0);
            let mut setup = DriveSetup { scenario: *scenario, ..DriveSetup::default() };
            setup.manifest.policy.name = policy.name.clone();
            let rank = study.conditions.iter().position(|one| one.name == condition).unwrap();
            drives.push(AnalysedRecording {
                found: FoundRecording {
                    participant: format!("sub-P{person:02}"),
                    segment: planned.segment,
                    place: run.to_string(),
                    condition,
                    rank,
                    ..FoundRecording::default()
                },
                measures: DriveMeasures { values, responses: Vec::new() },
                per_second_mps: Vec::new(),
                baseline_per_second_mps: Vec::new(),
                duration_s: setup.scenario.duration_s,
                ended: "duration".into(),
                setup,
                stretches: DriverStretches::default(),
                network: None,
                scripted_responses: Vec::new(),
            });
        }
    }
    drives
}

#[test]
fn a_plan_states_events_tasks_and_automation_in_words() {
    let plan = |name: &str| {
        let study = Study::load(&crate::data_folders::root().join(format!("assets/studies/{name}.toml"))).unwrap();
        written(&study, 24, &OutcomeSpread::Unknown, 2, &|_| ()).unwrap()
    };
    let braking = plan("lead-braking");
    let first =
        "`gentle` of braking: events \"first\" at 40 s, faster than 20 m/s, time gap to leader below 2.5 s: brake";
    assert!(braking.contains(first), "{braking}");
    assert!(braking.contains("(vehicle leader, decel\\_mps2 6.0, to\\_mps 8.0, keep\\_s 0.0)"), "{braking}");
    let takeover = plan("takeover");
    assert!(takeover.contains("* Automation: `system` = \"traffic-jam-pilot\".\n"), "{takeover}");
    assert!(
        takeover.contains(
            "takeover\\_request (lead\\_s 4.0); \"pilot on again\" 30 s after \"first request\": automation (on)"
        ),
        "{takeover}"
    );
}

#[test]
fn a_shipped_plan_announces_the_tests_that_its_analysis_makes() {
    for (name, tests, trials) in [("congestion", 21, 16), ("congestion-short", 9, 3), ("congestion-people", 9, 6)] {
        let file = crate::data_folders::root().join(format!("assets/studies/{name}.toml"));
        let study = Study::load(&file).unwrap_or_else(|e| panic!("{e}"));
        let text = written(&study, 12, &OutcomeSpread::Unknown, 2, &|_| ()).unwrap();
        assert!(text.contains(&format!("each with {trials} trials, ")), "{name}: {text}");
        assert!(text.contains(&format!("over all {tests} tests of the plan")), "{name}: {text}");
        let drives = driven(&study, 12);
        assert_eq!(drives.len(), 12 * trials);
        let now = study.file.analysis.clone();
        let history = PlanHistory { begun: now.clone(), now };
        let found = PlannedAnalysis::of(&history, &drives, &StudyParticipants::default()).unwrap();
        let fitted = found.outcomes.iter().map(|outcome| outcome.fitted.as_ref().unwrap());
        let made = fitted.flat_map(|fitted| &fitted.contrasts).filter(|tested| tested.found.is_some()).count();
        assert_eq!((found.tests, made), (tests, tests), "{name}");
    }
}

#[test]
fn each_world_of_the_people_study_is_named_with_its_reason() {
    let study = Study::load(&crate::data_folders::root().join("assets/studies/congestion-people.toml"));
    let study = study.unwrap_or_else(|e| panic!("{e}"));
    let text = written(&study, 30, &OutcomeSpread::Unknown, 2, &|_| ()).unwrap();
    for part in [
        "* `ring-study` of world: `traffic_drivers` = ring-study. The other vehicles are all driven alike, by the Intelligent Driver Model",
        // Experiment A had 20 people (docs/references.md: people).
        "* `safe-followers` of world: `traffic_drivers` = safe-followers, `vehicles` = 20. The other vehicles are driven by persons of the \
         population `safe-followers`, \"People who follow safely",
        "Reason: 20 people were told to follow safely in experiment A of the Arizona ring",
        "persons of the population `gap-closers`, ",
        "its results are the least certain.",
        "a closed route of 260 m, with 21 vehicles (the participant's included)",
        "| 1 | primary | `mean_speed_mps` | `advice+ring-study` | `none+ring-study` |",
        "| 6 | primary | `speed_sd_over_vehicles_mps` | `advice+gap-closers` | `none+gap-closers` |",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn the_text_states_every_rule_outcome_contrast_covariate_and_level() {
    let rules = "least_recorded_share = 0.9\nmost_contacts = 1\nmost_dropped_share = 0.05\nleast_trials = 2\nonly_complete_sessions = true";
    let plan = PLAN
        .replace("most_contacts = 0", rules)
        .replace("= 0.3\n", "= 0.3\nalpha = 0.01\ncovariates = [\"hand_over_speed_sd_over_vehicles_mps\"]\n");
    let text = written(&study(&plan), 12, &OutcomeSpread::Unknown, 20, &|_| ()).unwrap();
    for part in [
        "* A trial is left out if less than 90 % of its planned length was recorded.",
        "* A trial is left out if there was more than one contact with other vehicles.",
        "* A trial is left out if more than 5 % of its length was given up",
        "* A participant is left out if fewer than 2 trials remain after these rules.",
        "* A participant is left out if the session was not completed.",
        "* Primary: Mean speed of all vehicles",
        "* Secondary: Reaction time",
        "Contrasts: wide − narrow; middle − narrow.",
        "    measure ~ condition + place + hand_over_speed_sd_over_vehicles_mps + (1 | participant)\n",
        "`hand_over_speed_sd_over_vehicles_mps` is a number: ",
        "* Level: alpha = 0.01 over all 4 tests of the plan",
        // 0.01 divided by four tests, with four decimals.
        "0.0025 for the strictest step",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn a_sham_is_described_in_words() {
    let text = std::fs::read_to_string("assets/studies/congestion-short.toml").unwrap();
    let study = Study::parse(text, Path::new("assets/studies/congestion-short.toml")).unwrap_or_else(|e| panic!("{e}"));
    let text = written(&study, 6, &OutcomeSpread::Unknown, 2, &|_| ()).unwrap();
    assert!(text.contains("* `sham`: sham advice (`sham_advice` = true): the advice that the policy gave"), "{text}");
    // The file's policy by its hash, as sha256sum prints it, and the gate at the start of a drive.
    assert!(text.contains(
        "policy `ring-250-speed` (file with SHA-256 `c7d8ae82626152837a035f7b67d82d917d9fb6c2b399523bf0b3acd5b0c2fa0c`)"
    ));
    let network = "a neural network of 3 layers whose speed is advised, from speed, leader speed, gap, spacing, mean speed and log hold;";
    assert!(text.contains(network), "{text}");
    // What a reviewer asks: who is told what, in which order, what was answered, and which file was meant.
    for part in [
        "* `none`: `policy` = none: no speed is advised, and the speedometer shows neither line nor range",
        "the experimenter is not blind",
        "Participants get them in turn, as their sessions begin.",
        "fulfil `{licence} = false` (Do you hold a driving licence that is valid now?).",
        "* `trust` (How far you trust the advice), asked after each drive of `trial` with advice. Four sentences",
        "no value is imputed",
        "SHA-256 of the study's file, as the data set keeps it (`study.toml`): `",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(text.contains(
        "the drive begins once the standard deviation of speed over the vehicles has been at least 2 m/s for 10 s"
    ));
}

#[test]
fn recruitment_ethics_and_apparatus_are_printed_or_said_to_be_missing() {
    let text = |study: &Study| written(study, 12, &OutcomeSpread::Unknown, 20, &|_| ()).unwrap();
    let stated = "[methods]\nethics = \"\"\"Approved by the *board*,\nNo. 7.\"\"\"\n";
    let text = text(&study(&format!("{stated}{PLAN}")));
    for part in [
        "* Recruitment: not stated (`recruitment` in `[methods]` of the study's file).\n",
        "* Ethics: Approved by the \\*board\\*, No. 7.\n",
        "* Apparatus: not stated",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn the_speed_that_a_constant_policy_advises_is_stated() {
    let text = |source: String| {
        let study = Study::parse(source, Path::new("x.toml")).unwrap_or_else(|e| panic!("{e}"));
        written(&study, 12, &OutcomeSpread::Unknown, 20, &|_| ()).unwrap()
    };
    let practice = "[[segment]]\nkind = \"drive\"\nname = \"practice\"\nset = { policy = \"constant\" }\n";
    let source = study(PLAN).source;
    // 98.5 % of the equilibrium speed of the ring of 250 m, 4.362 m/s (docs/references.md: ring).
    let automatic = text(source.clone() + practice);
    assert!(
        automatic.contains("`practice`: ") && automatic.contains(", which advises 4.30 m/s throughout"),
        "{automatic}"
    );
    let set = text(source + &practice.replace("\"constant\"", "\"constant\", policy_speed_mps = 3.5"));
    assert!(set.contains(", which advises 3.50 m/s throughout") && !set.contains("4.30 m/s throughout"), "{set}");
}
