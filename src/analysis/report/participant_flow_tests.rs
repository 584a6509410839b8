//! Flow of participants whose numbers are counted by hand.

use super::*;
use crate::analysis::{
    data::EndReasons,
    drives::test_drives,
    models::planned::{PlannedAnalysis, tests::PLAN, tests::history},
};

fn person(id: &str, order: &str, state: &str, ends: EndReasons) -> StudyParticipant {
    StudyParticipant { id: id.into(), order: order.into(), state: state.into(), ends, ..StudyParticipant::default() }
}

fn ended(end: &str, is_by_limit: bool) -> EndReasons {
    EndReasons { end: end.into(), is_by_limit, ..EndReasons::default() }
}

/// Returns a trial that lasted a share of its planned 60 s.
fn trial(participant: &str, condition: &str, place: usize, share: f64) -> AnalysedRecording {
    let mut drive = test_drives::drive(participant, condition, place, Some(0.0));
    drive.found.place = place.to_string();
    drive.setup.scenario.duration_s = 60.0;
    drive.duration_s = 60.0 * share;
    drive
}

/// Eleven sessions and one erased participant. Five sessions are completed or partial; of the others one person declined, one was
/// not eligible, one session goes on, one was excluded, and two ended early, one of them before the first trial was over.
fn people() -> StudyParticipants {
    let (ab, ba) = ("a,b", "b,a");
    let excluded = EndReasons { excluded: Some("the phone rang".into()), ..EndReasons::default() };
    let none = EndReasons::default;
    let all = vec![
        person("sub-P01", ab, "complete", none()),
        person("sub-P02", ba, "complete", none()),
        person("sub-P03", ab, "complete", none()),
        person("sub-P04", ba, "complete", none()),
        person("sub-P05", ab, "partial", none()),
        person("sub-P06", ba, "declined", ended("did not agree", false)),
        person("sub-P07", ab, "not_eligible", ended("screening: {licence} = false (ends_if)", false)),
        person("sub-P08", ba, "open", none()),
        person("sub-P09", ab, "excluded", excluded),
        person("sub-P10", ba, "withdrawn", ended("sickness", false)),
        person("sub-P11", ab, "withdrawn", ended("trial-1-a: fms is 12, above 10 (stop_above)", true)),
    ];
    StudyParticipants { all, erased: 1, ..StudyParticipants::default() }
}

/// Two trials each of P01 to P05, one of P10, none of P11. One of P04's is too short, so that one of two remains.
fn drives() -> Vec<AnalysedRecording> {
    let mut all = vec![trial("sub-P10", "b", 1, 1.0)];
    for (i, id) in ["sub-P01", "sub-P02", "sub-P03", "sub-P04", "sub-P05"].into_iter().enumerate() {
        let place = |first: bool| if first == (i % 2 == 0) { 1 } else { 2 };
        let share = if id == "sub-P04" { 0.5 } else { 1.0 };
        all.extend([trial(id, "a", place(true), 1.0), trial(id, "b", place(false), share)]);
    }
    // A practice drive is no trial.
    all.push(trial("sub-P11", "", 1, 1.0));
    all
}

#[test]
fn every_number_of_the_flow_is_that_counted_by_hand() {
    let (people, drives) = (people(), drives());
    let planned = PlannedAnalysis::of(&history(PLAN), &drives, &people).unwrap();
    let flow = ParticipantFlow::of(&people, &drives, Some(&planned)).unwrap();
    let counts: Vec<(&str, usize, Option<usize>)> = flow
        .stages
        .iter()
        .map(|stage| (stage.title, stage.count(), stage.leave.as_ref().map(|leave| leave.1)))
        .collect();
    assert_eq!(
        counts,
        [
            ("Sessions begun", 12, Some(4)),
            ("Took part", 8, Some(1)),
            ("Not excluded", 7, Some(1)),
            ("Analysed", 6, Some(3)),
            ("In the planned models", 3, None),
        ]
    );
    // Those of a stage are those of the next and those who leave.
    for pair in counts.windows(2) {
        assert_eq!(pair[0].1, pair[1].1 + pair[0].2.unwrap(), "{pair:?}");
    }
    // 11 trials: P10's 1, P05's 2 and P04's other one go with them, one is too short, 6 remain.
    let text = flow.paragraph();
    for part in [
        "Sessions begun: 12. Without data to use: 4 (data erased: 1; did not agree to take part: 1; not eligible: \
         screening: {licence} = false: 1; session not over: 1).",
        "Took part: 8. Excluded by the experimenter: 1 (the phone rang: 1).",
        "Not excluded: 7 (session completed: 4; session completed, with parts skipped: 1; ended early: sickness: 1; ended early by a \
         limit: fms above 10: 1). Without a completed trial: 1 (ended early by a limit: fms above 10: 1).",
        "Analysed: 6 (trials: 11). Left out by rules of the plan: 3 (too few trials remained: 1; the session was not completed: 2; trials \
         left out with participants: 4; trials left out one by one, too little of the planned length was recorded: 1).",
        "In the planned models: 3 (trials: 6).",
        "a, b: 6, 5, 4, 3, 2; b, a: 5, 3, 3, 3, 1.",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let mut page = ReportPage::default();
    flow.section(&mut page);
    assert_eq!(page.figures[0].0, "participant-flow.svg");
    // The sums of the table are the numbers of the diagram, less the participant whose data were erased.
    assert!(
        page.html.contains("<tr><td>All</td><td>11</td><td>8</td><td>7</td><td>6</td><td>3</td></tr>"),
        "{}",
        page.html
    );
}

#[test]
fn the_flow_without_a_plan_ends_with_the_analysed_participants() {
    let people = people();
    let drives = drives();
    let flow = ParticipantFlow::of(&people, &drives, None).unwrap();
    assert_eq!(flow.stages.last().map(|stage| (stage.title, stage.count())), Some(("Analysed", 6)));
    let text = flow.paragraph();
    assert!(text.contains("Analysed: 6 (trials: 11). By order"), "{text}");
    assert_eq!(ParticipantFlow::of(&StudyParticipants::default(), &drives, None), None, "drives of no study");
}

#[test]
fn a_limit_is_named_without_the_value_that_was_found() {
    for (reason, text) in [
        ("ssq: total is 78.54, above 60 (stop_above)", "ended early by a limit: ssq total above 60"),
        ("trial-2-b: fms is 12, above 10 (stop_above)", "ended early by a limit: fms above 10"),
        ("trial-2-b-trust: trust.trust is 5, above 4.5 (stop_above)", "ended early by a limit: trust.trust above 4.5"),
        ("by hand", "ended early by a limit: by hand"),
        ("", "ended early by a limit"),
    ] {
        assert_eq!(limit(reason), text);
    }
}

#[test]
fn long_orders_have_a_number_and_orders_of_one_person_each_are_not_listed() {
    let long = "none+usual+brisk,wide+usual+brisk,sham+usual+brisk,narrow+usual+brisk";
    let orders = |orders: [&str; 3]| {
        let one = |(i, order): (usize, &&str)| person(&format!("sub-P{i}"), order, "complete", EndReasons::default());
        StudyParticipants { all: orders.iter().enumerate().map(one).collect(), ..StudyParticipants::default() }
    };
    let drives = [trial("sub-P0", "a", 1, 1.0)];
    let text = |orders: &StudyParticipants| ParticipantFlow::of(orders, &drives, None).unwrap().paragraph();
    let listed = text(&orders([long, long, "a,b"]));
    assert!(listed.ends_with("a, b: 1, 1, 1, 0; order 2, which begins with none+usual+brisk: 2, 2, 2, 1."), "{listed}");
    assert!(!text(&orders(["a,b", "b,a", long])).contains("By order"));
}

#[test]
fn technical_ends_are_told_apart_from_early_ends_and_open_sessions() {
    let cut = EndReasons { is_cut: true, ..EndReasons::default() };
    let all = vec![
        person("sub-P01", "a,b", "complete", EndReasons::default()),
        person("sub-P02", "b,a", "ended_technically", ended("the wheel was lost", false)),
        person("sub-P03", "a,b", "withdrawn", ended("sickness", false)),
        person("sub-P04", "b,a", "open", cut),
        person("sub-P05", "a,b", "open", EndReasons::default()),
    ];
    let people = StudyParticipants { all, ..StudyParticipants::default() };
    let drives = vec![trial("sub-P01", "a", 1, 1.0), trial("sub-P02", "b", 1, 1.0)];
    let text = ParticipantFlow::of(&people, &drives, None).unwrap().paragraph();
    let begun = "Sessions begun: 5. Without data to use: 2 (session not over, cut by a failure of the program or the computer: 1; session \
                 not over: 1).";
    assert!(text.contains(begun), "{text}");
    assert!(text.contains("ended early for a technical reason: the wheel was lost: 1"), "{text}");
    assert!(text.contains("Without a completed trial: 1 (ended early: sickness: 1)."), "{text}");
}
