//! Planned analysis of trials made up by hand: exclusions and tests.

use super::*;
use crate::analysis::{
    data::{DriveSetup, DriverStretches, FoundRecording, StudyParticipant},
    measures::{DriveMeasures, index},
};
use crate::rng;

pub(crate) const PLAN: &str = "[analysis]\nprimary = \"mean_speed_mps\"\nsmallest_effect = 0.2\nsecondary = [\"speed_error_mps\", \"reaction_s\"]\n\
                    contrasts = [{ condition = \"b\", reference = \"a\" }, { condition = \"c\", reference = \"a\" }]\n[analysis.exclude]\n\
                    least_recorded_share = 0.9\nmost_contacts = 0\nleast_trials = 2\nonly_complete_sessions = true\n";

pub(crate) fn history(text: &str) -> PlanHistory {
    let plan = AnalysisPlan::in_study(text, "x").unwrap();
    PlanHistory { begun: plan.clone(), now: plan }
}

/// Returns trials of twelve participants in three conditions: speeds of 5 m/s, 0.5 faster in b, with 0.8 between and 0.2 m/s
/// within participants. The error is noise, and no participant has a reaction time.
pub(crate) fn drives() -> Vec<AnalysedRecording> {
    let mut stream = rng::stream(4, "planned");
    let mut all = Vec::new();
    for person in 0..12 {
        let own = 0.8 * stream.normal();
        for (rank, condition) in ["a", "b", "c"].into_iter().enumerate() {
            let mut values = vec![None; MEASURES.len()];
            let effect = if condition == "b" { 0.5 } else { 0.0 };
            values[index("mean_speed_mps")] = Some(5.0 + own + effect + 0.2 * stream.normal());
            values[index("speed_error_mps")] = Some(1.0 + 0.1 * stream.normal());
            values[index("contact_count")] = Some(0.0);
            let mut setup = DriveSetup::default();
            setup.scenario.duration_s = 60.0;
            all.push(AnalysedRecording {
                found: FoundRecording {
                    participant: format!("sub-P{person:02}"),
                    segment: "trial".into(),
                    place: ((rank + person) % 3 + 1).to_string(),
                    condition: condition.into(),
                    rank,
                    ..FoundRecording::default()
                },
                measures: DriveMeasures { values, responses: Vec::new() },
                per_second_mps: Vec::new(),
                baseline_per_second_mps: Vec::new(),
                duration_s: 60.0,
                ended: "duration".into(),
                setup,
                stretches: DriverStretches::default(),
                network: None,
                scripted_responses: Vec::new(),
            });
        }
    }
    all
}

#[test]
fn a_known_difference_is_found_and_all_tests_are_corrected_together() {
    let found = PlannedAnalysis::of(&history(PLAN), &drives(), &StudyParticipants::default()).unwrap();
    let roles: Vec<(&str, bool)> =
        found.outcomes.iter().map(|outcome| (MEASURES[outcome.measure].name, outcome.is_primary)).collect();
    assert_eq!(roles, [("mean_speed_mps", true), ("speed_error_mps", false), ("reaction_s", false)]);
    let primary = found.outcomes[0].fitted.as_ref().unwrap();
    let [b, c] = [0, 1].map(|k| primary.contrasts[k].found.unwrap());
    let [low, high] = b.interval(0.05);
    assert!(low < 0.5 && 0.5 < high && b.p < 1e-4, "{b:?}");
    assert!(c.p > 0.05, "{c:?}");
    assert!((0.4..1.6).contains(&primary.model.sd_participant), "{}", primary.model.sd_participant);
    // Three planned outcomes and two contrasts: the smallest p is multiplied by six, though one outcome has no numbers.
    assert!((primary.contrasts[0].p_holm - 6.0 * b.p).abs() < 1e-12);
    assert_eq!(found.outcomes[2].fitted, Err(ModelFault::TooFew { rows: 0, participants: 0 }));
    assert!(found.left_out.is_empty() && found.changes.is_empty());
    let table = found.models_csv();
    assert_eq!(table.lines().count(), 1 + 2 * 3, "two contrasts and the place, of two outcomes: {table}");
    let row = table.lines().nth(1).unwrap();
    assert!(row.starts_with("mean_speed_mps,primary,contrast,b,a,12,36,"), "{row}");
    assert!(PlannedAnalysis::of(&PlanHistory::default(), &drives(), &StudyParticipants::default()).is_none());
}

#[test]
fn each_exclusion_rule_reports_the_number_found() {
    let mut drives = drives();
    // Two of three trials of the first participant are bad, so that the participant is left out; one of the second's.
    drives[0].duration_s = 30.0;
    drives[1].measures.values[index("contact_count")] = Some(2.0);
    drives[4].measures.values[index("contact_count")] = Some(1.0);
    let person =
        |id: &str, state: &str| StudyParticipant { id: id.into(), state: state.into(), ..StudyParticipant::default() };
    let mut all = vec![person("sub-P02", "withdrawn"), person("sub-P03", "complete"), person("sub-P99", "excluded")];
    all[2].ends.excluded = Some("fell asleep".into());
    let people = StudyParticipants { all, ..StudyParticipants::default() };
    let found = PlannedAnalysis::of(&history(PLAN), &drives, &people).unwrap();
    let texts: Vec<(&str, &str, &str)> = found
        .left_out
        .iter()
        .map(|one| (one.participant.as_str(), one.condition.as_str(), one.reason.as_str()))
        .collect();
    assert_eq!(
        texts,
        [
            ("sub-P99", "", "excluded by the experimenter: fell asleep"),
            ("sub-P00", "a", "50.0 % of the planned length was recorded"),
            ("sub-P00", "b", "2 contacts with other vehicles"),
            ("sub-P01", "b", "1 contact with other vehicles"),
            ("sub-P02", "", "the session is withdrawn"),
            ("sub-P00", "", "1 trial remains"),
        ]
    );
    let primary = found.outcomes[0].fitted.as_ref().unwrap();
    assert_eq!((primary.participants.len(), primary.observations.len()), (10, 29));
    assert!(
        found.left_out_csv().contains("sub-P00,trial,2,b,2 contacts with other vehicles\n"),
        "{}",
        found.left_out_csv()
    );
}

#[test]
fn a_fixed_order_has_no_place_term_and_an_empty_condition_no_test() {
    let mut drives = drives();
    for drive in &mut drives {
        drive.found.place = (drive.found.rank + 1).to_string();
        if drive.found.condition == "c" {
            drive.measures.values[index("mean_speed_mps")] = None;
        }
    }
    let found = PlannedAnalysis::of(&history(PLAN), &drives, &StudyParticipants::default()).unwrap();
    let primary = found.outcomes[0].fitted.as_ref().unwrap();
    assert!(primary.place.is_none() && primary.contrasts[0].found.is_some() && primary.contrasts[1].found.is_none());
    assert_eq!(primary.conditions, ["a", "b"]);
}

#[test]
fn covariates_are_held_constant_and_constant_ones_are_dropped() {
    let with = |name: &str| history(&PLAN.replace("= 0.2", &format!("= 0.2\ncovariates = [\"{name}\"]")));
    let mut drives = drives();
    let mut stream = rng::stream(9, "planned");
    for drive in &mut drives {
        // A strong wave, even stronger in condition b: without the covariate, the wave would hide most of the effect.
        let wave = 2.5 + 0.3 * stream.normal() + if drive.found.condition == "b" { 0.6 } else { 0.0 };
        drive.measures.values[index("hand_over_speed_sd_over_vehicles_mps")] = Some(wave);
        *drive.measures.values[index("mean_speed_mps")].as_mut().unwrap() -= 0.7 * wave;
    }
    let without = PlannedAnalysis::of(&history(PLAN), &drives, &StudyParticipants::default()).unwrap();
    let found =
        PlannedAnalysis::of(&with("hand_over_speed_sd_over_vehicles_mps"), &drives, &StudyParticipants::default())
            .unwrap();
    let [b_without, b] =
        [&without, &found].map(|all| all.outcomes[0].fitted.as_ref().unwrap().contrasts[0].found.unwrap());
    assert!(b_without.estimate < 0.4, "0.5 - 0.7 x 0.6 = 0.08, within two standard errors: {b_without:?}");
    assert!(b.interval(0.05)[0] < 0.5 && 0.5 < b.interval(0.05)[1], "{b:?}");
    let primary = found.outcomes[0].fitted.as_ref().unwrap();
    let (name, slope) = primary.covariates[0].clone();
    let [low, high] = slope.unwrap().interval(0.05);
    assert!(name == "hand_over_speed_sd_over_vehicles_mps" && low < -0.7 && -0.7 < high && high < 0.0, "{slope:?}");
    assert!(primary.place.is_some());
    let table = found.models_csv();
    assert!(table.contains("mean_speed_mps,primary,covariate,hand_over_speed_sd_over_vehicles_mps,,12,36,"), "{table}");
    // A trial without the number is in no model. A number that never varies is dropped, and the rest is as without it.
    drives[0].measures.values[index("hand_over_speed_sd_over_vehicles_mps")] = None;
    let found =
        PlannedAnalysis::of(&with("hand_over_speed_sd_over_vehicles_mps"), &drives, &StudyParticipants::default())
            .unwrap();
    assert_eq!(found.outcomes[0].fitted.as_ref().unwrap().observations.len(), 35);
    let found = PlannedAnalysis::of(&with("contact_count"), &drives, &StudyParticipants::default()).unwrap();
    let primary = found.outcomes[0].fitted.as_ref().unwrap();
    assert_eq!(primary.covariates, [("contact_count".to_owned(), None)]);
    assert_eq!(primary.contrasts, without.outcomes[0].fitted.as_ref().unwrap().contrasts);
    assert!(primary.place.is_some() && primary.means == without.outcomes[0].fitted.as_ref().unwrap().means);
}

#[test]
fn a_trial_in_slow_motion_is_left_out_with_the_share_that_was_given_up() {
    let mut drives = drives();
    drives[4].measures.values[index("dropped_s")] = Some(6.0);
    drives[5].measures.values[index("dropped_s")] = Some(2.9);
    let rules = PLAN.replace("most_contacts = 0", "most_dropped_share = 0.05");
    let found = PlannedAnalysis::of(&history(&rules), &drives, &StudyParticipants::default()).unwrap();
    let texts: Vec<(&str, &str)> =
        found.left_out.iter().map(|one| (one.participant.as_str(), one.reason.as_str())).collect();
    assert_eq!(texts, [("sub-P01", "10.0 % of its length was given up")]);
    assert!(
        found.plan.exclude.sentences().iter().any(|rule| rule.contains("more than 5 % of its length was given up"))
    );
}
