//! Tests of a session plan: seeds, rests, texts, expected durations, by hand.

use super::*;
use std::path::Path;

/// Parses a study of two conditions in fixed order; `trials` has keys of its trials.
fn study(seed: u64, trials: &str) -> Study {
    let text = format!(
        r#"title = "Two"
participants = 2
seed = {seed}
order = "fixed"
[base]
traffic = "native"
duration_s = 60.0
[[condition]]
name = "a"
[[condition]]
name = "b"
set = {{ hold_s = 5.0 }}
[[segment]]
kind = "drive"
name = "practice"
text = "Try it."
until_in_range_s = 20.0
[[segment]]
kind = "break"
name = "pause"
rest_s = 45.0
text = "Sit back."
[[segment]]
kind = "trials"
name = "trial"
{trials}
"#
    );
    Study::parse(text, Path::new("two.toml")).unwrap_or_else(|e| panic!("{e}"))
}

fn names(plan: &SessionPlan) -> Vec<&str> {
    plan.items.iter().map(|planned| planned.name.as_str()).collect()
}

fn seeds(plan: &SessionPlan) -> Vec<u64> {
    let seed = |planned: &PlannedItem| match &planned.item {
        PlanItem::Drive { scenario, .. } => Some(scenario.seed),
        _ => None,
    };
    plan.items.iter().filter_map(seed).collect()
}

#[test]
fn rests_come_between_trials_unless_their_length_is_zero() {
    let with = study(1, "rest_s = 10.0").plan(0);
    assert_eq!(names(&with), ["practice", "pause", "trial-1-a", "trial-rest-1", "trial-2-b"]);
    assert_eq!(with.items[3].item, PlanItem::Break(10.0));
    for none in ["rest_s = 0.0", ""] {
        assert_eq!(names(&study(1, none).plan(0)), ["practice", "pause", "trial-1-a", "trial-2-b"], "{none:?}");
    }
}

#[test]
fn a_segment_named_like_a_rest_between_trials_is_refused() {
    let parsed = |rest: &str| {
        let text = study(1, rest).source.replace("\"pause\"", "\"trial-rest-1\"");
        Study::parse(text, Path::new("two.toml"))
    };
    let message = parsed("rest_s = 10.0").expect_err("two items of one name").to_string();
    assert!(message.contains("trial-rest-1"), "{message}");
    assert!(parsed("rest_s = 0.0").is_ok() && parsed("").is_ok(), "without a rest the name is free");
}

#[test]
fn the_text_of_trials_is_shown_only_before_the_first() {
    let plan = study(1, "text = \"Drive.\"\nrest_s = 5.0").plan(0);
    let texts: Vec<&str> = plan.items.iter().map(|planned| planned.text.as_str()).collect();
    assert_eq!(texts, ["Try it.", "Sit back.", "Drive.", "", ""]);
    let runs: Vec<(Option<usize>, Option<&str>)> =
        plan.items.iter().map(|planned| (planned.run, planned.condition.as_deref())).collect();
    assert_eq!(runs, [(None, None), (None, None), (Some(1), Some("a")), (None, None), (Some(2), Some("b"))]);
    let PlanItem::Drive { practice, levels, .. } = &plan.items[0].item else { panic!("a drive") };
    assert!(practice.until_in_range_s == Some(20.0) && levels.is_empty());
}

#[test]
fn a_seed_joins_the_numbers_of_study_participant_and_drive() {
    // Six digits of the study's seed, four of the participant's number, two of the drive's number from 1.
    assert_eq!(seeds(&study(7, "").plan(0)), [7_000_001, 7_000_002, 7_000_003]);
    assert_eq!(seeds(&study(7, "").plan(31)), [7_003_101, 7_003_102, 7_003_103]);
    assert_eq!(seeds(&study(999_999, "").plan(9_999)), [999_999_999_901, 999_999_999_902, 999_999_999_903]);
    // Leading digits that do not fit are dropped.
    assert_eq!(seeds(&study(2_000_007, "").plan(10_031)), seeds(&study(7, "").plan(31)));
}

#[test]
fn a_session_lasts_as_long_as_its_parts() {
    let plan = study(1, "rest_s = 10.0").plan(0);
    // Three drives of a minute; two words before the first (238 words per minute, plus 3 s for the page); rests of 45 s and 10 s.
    let seconds: Vec<f64> = plan.items.iter().map(|planned| planned.seconds).collect();
    let read_s = 3.0 + 2.0 * 60.0 / 238.0;
    assert_eq!(seconds, [60.0 + read_s, 45.0, 60.0, 10.0, 60.0]);
    assert!((plan.minutes() - (235.0 + read_s) / 60.0).abs() < 1e-9);
    let words: Vec<String> = plan.items.iter().map(|planned| planned.item.to_string()).collect();
    assert!(
        words[0].ends_with(", or until 20 s in range without a break") && !words[2].contains("sooner"),
        "{words:?}"
    );
    assert_eq!(words[1], "rest, 45 s");
    assert_eq!(PlanItem::Text(String::new()).to_string(), "a page to read");
    assert_eq!(PlanItem::Questions("tlx".into()).to_string(), "questions: tlx");
}

#[test]
fn a_plan_names_the_policy_that_auto_selects() {
    let text = study(1, "").source.replace("[base]", "[base]\npolicy = \"auto\"");
    let plan = Study::parse(text, Path::new("two.toml")).unwrap_or_else(|e| panic!("{e}")).plan(0);
    let own = "policy ring-250-speed (auto: the policy that is shipped for ring-250)";
    assert!(plan.items[0].item.to_string().contains(own), "{}", plan.items[0].item);
}

#[test]
fn all_trials_share_a_dial_scale_unless_a_condition_sets_its_own() {
    // On the ring of 250 m, 22 vehicles flow at 4.4 m/s; 8 vehicles drive several times as fast.
    let text = |own: &str| {
        format!(
            r#"title = "Density"
participants = 2
order = "fixed"
[base]
traffic = "native"
duration_s = 60.0
[[condition]]
name = "dense"
set = {{ vehicles = 22 }}
[[condition]]
name = "loose"
set = {{ vehicles = 8{own} }}
[[segment]]
kind = "drive"
name = "practice"
set = {{ vehicles = 22 }}
[[segment]]
kind = "trials"
name = "trial"
"#
        )
    };
    let scales = |own: &str| -> Vec<f64> {
        let study = Study::parse(text(own), Path::new("density.toml")).unwrap_or_else(|e| panic!("{e}"));
        let full = |planned: PlannedItem| match planned.item {
            PlanItem::Drive { scenario, .. } => Some(scenario.display.dial_full),
            _ => None,
        };
        study.plan(0).items.into_iter().filter_map(full).collect()
    };
    let [practice, dense, loose] = scales("")[..] else { panic!("three drives") };
    assert_eq!((practice, dense), (0.0, loose), "a practice has the scale that suits it");
    // The scale is in mph and includes the equilibrium speed of 8 vehicles of 5 m on the ring, more than 10 m/s (22 mph) by the IDM.
    assert!(dense > 22.0, "{dense}");
    assert_eq!(scales(", dial_full = 100.0"), [0.0, dense, 100.0]);
}

#[test]
fn questionnaires_follow_each_trial_before_the_rest() {
    let plan = study(1, "rest_s = 10.0\nafter = [\"raw-tlx\", \"acceptance\"]").plan(0);
    let after = |drive: &str| [format!("{drive}-raw-tlx"), format!("{drive}-acceptance")];
    let [[a1, a2], [b1, b2]] = [after("trial-1-a"), after("trial-2-b")];
    let wanted = ["practice", "pause", "trial-1-a", &a1, &a2, "trial-rest-1", "trial-2-b", &b1, &b2];
    assert_eq!(names(&plan), wanted);
    let asked = &plan.items[8];
    assert_eq!((asked.run, asked.condition.as_deref(), asked.segment.as_str()), (Some(2), Some("b"), "trial"));
    let about = AskedAfter { drive: "trial-2-b".into(), questionnaire: "acceptance".into() };
    assert_eq!((&asked.after, &asked.item), (&Some(about), &PlanItem::Questions("acceptance".into())));
    assert!(plan.items[6].after.is_none() && plan.items[5].after.is_none(), "the drive and the rest ask nothing");
    // Two questionnaires after each of two trials lengthen the session. The first has 86 words, six questions and two pages.
    let without = study(1, "rest_s = 10.0").plan(0);
    let [tlx_s, other_s] = [plan.items[3].seconds, plan.items[4].seconds];
    assert!((tlx_s - (86.0 * 60.0 / 238.0 + 6.0 * 4.0 + 2.0 * 3.0)).abs() < 1e-9, "{tlx_s}");
    assert!((plan.minutes() - without.minutes() - 2.0 * (tlx_s + other_s) / 60.0).abs() < 1e-9);
    assert_eq!(seeds(&plan), seeds(&without), "the drives stay as they were");
}

#[test]
fn a_drive_without_a_condition_can_have_questionnaires() {
    let text = r#"title = "One"
participants = 1
[base]
traffic = "native"
duration_s = 10.0
[[segment]]
kind = "drive"
name = "practice"
after = ["ssq"]
"#;
    let plan = Study::parse(text.to_owned(), Path::new("one.toml")).unwrap_or_else(|e| panic!("{e}")).plan(0);
    assert_eq!(names(&plan), ["practice", "practice-ssq"]);
    assert_eq!((plan.items[1].run, &plan.items[1].condition), (None, &None));
}

#[test]
fn questions_about_advice_come_only_after_drives_with_advice() {
    let plan = study(1, "rest_s = 10.0\nafter = [\"raw-tlx\"]\nafter_advice = [\"trust\"]").plan(0);
    for drive in ["trial-1-a", "trial-2-b"] {
        assert!(names(&plan).contains(&format!("{drive}-trust").as_str()), "{drive}");
    }
    let none = study(1, "set = { policy = \"none\" }\nafter = [\"raw-tlx\"]\nafter_advice = [\"trust\"]").plan(0);
    assert_eq!(names(&none), ["practice", "pause", "trial-1-a", "trial-1-a-raw-tlx", "trial-2-b", "trial-2-b-raw-tlx"]);
}
