//! Summary of a drive as text, for a terminal. In: a [`Summary`]. Out: lines.

use super::offline::AdvisedSummary;
use crate::{
    metrics::{QuestionScore, TaskScores},
    scenario::PlannedDrive,
    sim::{EndReason, Summary},
    units::SpeedUnit,
};

/// Returns the summary of a drive, one line per figure; `driver` describes the driver, `policy` the advising policy.
pub fn summary(drive: &PlannedDrive, engine: &str, driver: &str, policy: &str, summary: &Summary) -> String {
    let scenario = drive.scenario();
    let unit = scenario.display.units;
    let speed = |value: Option<f64>| value.map_or("-".into(), |v| both(v, unit));
    let in_range = summary.time_in_range.map_or("- (no advice)".into(), |share| format!("{:.1} %", 100.0 * share));
    let mut lines = vec![
        format!("{} on {}, {engine}, driver {driver}, policy {policy}", drive.vehicles_text(), scenario.map),
        format!("window                   {:.1} s to {:.1} s", summary.window_s[0], summary.window_s[1]),
        format!("mean speed, all vehicles {}", speed(summary.mean_speed_mps)),
        format!("SD of all speeds         {}", speed(summary.speed_sd_over_vehicles_and_time_mps)),
        format!("mean speed, ego          {}", speed(summary.ego_mean_speed_mps)),
        format!("time in range            {in_range}"),
        format!("smallest gap             {}", summary.min_gap_m.map_or("-".into(), |gap| format!("{gap:.2} m"))),
        format!("contacts, off the road   {}, {}", summary.contact_count, summary.left_road),
    ];
    if let Some(space_mean_mps) = summary.space_mean_speed_mps {
        lines.insert(3, format!("space-mean speed, all    {}", both(space_mean_mps, unit)));
    }
    if summary.red_lights + summary.near_misses > 0 {
        lines.push(format!("red lights, near misses  {}, {}", summary.red_lights, summary.near_misses));
    }
    if summary.object_contacts > 0 {
        lines.push(format!("fixed objects touched    {}", summary.object_contacts));
    }
    lines.extend(task_line(&summary.secondary_task));
    lines.extend(summary.secondary_task.questions.as_ref().map(question_line));
    if let Some(contact) = summary.contacts.first() {
        let (at, car, closing) = (contact.time_s, contact.car, contact.closing_mps);
        lines.push(format!("first contact            at {at:.2} s with road user {car}, closing at {closing:.2} m/s"));
    }
    match &summary.failure {
        Some(_) => {
            lines.push(format!("broken off               at {:.1} s: {}", summary.duration_s, summary.end_text()))
        }
        None if summary.ended == Some(EndReason::PathEnd) => {
            lines.push(format!("at the end of its path   at {:.1} s", summary.duration_s));
        }
        None if summary.ended.is_none() => {
            lines.push(format!("stopped                  at {:.1} s", summary.duration_s));
        }
        None => {}
    }
    lines.join("\n") + "\n"
}

fn percent(share: Option<f64>) -> String {
    share.map_or("-".into(), |share| format!("{:.0} %", 100.0 * share))
}

fn mean_s(time_s: Option<f64>) -> String {
    time_s.map_or("-".into(), |time_s| format!("{time_s:.2} s"))
}

/// Returns a line on the questions of events.
fn question_line(score: &QuestionScore) -> String {
    let QuestionScore { questions, questions_unanswered, question_correct, question_response_s } = *score;
    let (right, after_s) = (percent(question_correct), mean_s(question_response_s));
    format!("questions                {questions}, {questions_unanswered} not answered, {right} right after {after_s}")
}

/// Returns a line on the secondary task; `None` without one.
fn task_line(scores: &TaskScores) -> Option<String> {
    let TaskScores { detection, n_back, search, occlusion, .. } = scores;
    let detection = detection.map(|score| {
        let (hits, after_s) = (percent(score.detection_hit_rate), mean_s(score.detection_response_s));
        let (signals, false_responses) = (score.detection_signals, score.detection_false_responses);
        format!("signals                  {signals}, {hits} hit after {after_s}, {false_responses} false responses")
    });
    let n_back = n_back.map(|score| {
        let (right, digits) = (percent(score.n_back_accuracy), score.n_back_digits);
        format!("n-back                   {digits} digits, {right} of the decisions right")
    });
    let search = search.map(|score| {
        let (right, after_s) = (percent(score.search_correct), mean_s(score.search_response_s));
        format!("surrogate reference      {} displays, {right} right after {after_s}", score.search_displays)
    });
    let occlusion = occlusion.map(|score| {
        format!("shutter                  {} openings, open for {:.1} s", score.shutter_openings, score.shutter_open_s)
    });
    detection.or(n_back).or(search).or(occlusion)
}

/// Returns two lines on the advised vehicles; empty with fewer than two of them.
pub fn advised(advised: &AdvisedSummary) -> String {
    let AdvisedSummary { vehicles, of, contacts_of_others } = advised;
    if vehicles.len() < 2 {
        return String::new();
    }
    let names: Vec<String> = vehicles.iter().map(u32::to_string).collect();
    let which = match of {
        Some(of) => {
            format!(" of {of} ({:.1} %): vehicles {}", 100.0 * vehicles.len() as f64 / *of as f64, names.join(", "))
        }
        None => " vehicles, in order of entry".into(),
    };
    format!("advised                  {}{which}\ncontacts of the others   {contacts_of_others}\n", vehicles.len())
}

fn both(speed_mps: f64, unit: SpeedUnit) -> String {
    format!("{speed_mps:.3} m/s ({:.2} {})", unit.from_mps(speed_mps), unit.label())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::{TaskLog, TaskResponse, TaskStimulus};
    use crate::scenario::{DisplaySettings, Scenario};
    use crate::sim::{ContactRecord, SummaryAccumulator};
    use crate::time::Tick;

    #[test]
    fn several_advised_vehicles_are_listed_and_a_single_one_is_not() {
        let of = |vehicles: Vec<u32>| advised(&AdvisedSummary { vehicles, of: Some(22), contacts_of_others: 1 });
        // Three of 22 are 13.6 %.
        let expected = "\
advised                  3 of 22 (13.6 %): vehicles 0, 7, 14
contacts of the others   1
";
        assert_eq!((of(vec![0, 7, 14]).as_str(), of(vec![0]).as_str(), of(vec![]).as_str()), (expected, "", ""));
    }

    #[test]
    fn a_secondary_task_has_a_line() {
        let at = Tick::at_seconds;
        let log = TaskLog {
            stimuli: vec![(at(4.0), TaskStimulus::Signal), (at(8.0), TaskStimulus::Signal)],
            responses: vec![(at(4.5), TaskResponse::Button), (at(7.0), TaskResponse::Button)],
            ..TaskLog::default()
        };
        let expected = "signals                  2, 50 % hit after 0.50 s, 1 false responses";
        assert_eq!(task_line(&log.scores(20.0)).as_deref(), Some(expected));
        let log = TaskLog { shutter: vec![(at(1.0), true), (at(2.5), false)], ..TaskLog::default() };
        let expected = "shutter                  1 openings, open for 1.5 s";
        assert_eq!(task_line(&log.scores(20.0)).as_deref(), Some(expected));
        assert_eq!(task_line(&TaskScores::default()), None);
    }

    fn planned(scenario: &Scenario) -> PlannedDrive {
        PlannedDrive::new(scenario).expect("a shipped map")
    }

    #[test]
    fn a_summary_has_one_line_per_figure_in_the_scenarios_units() {
        let scenario = Scenario {
            policy: "pi".into(),
            vehicles: 5,
            display: DisplaySettings { units: SpeedUnit::Mph, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let whole = Summary {
            window_s: [10.0, 60.0],
            // 10 m/s are 36,000 m per hour, or 22.37 miles of 1609.344 m.
            mean_speed_mps: Some(10.0),
            speed_sd_over_vehicles_and_time_mps: Some(0.5),
            ego_mean_speed_mps: None,
            time_in_range: Some(0.125),
            min_gap_m: Some(4.256),
            contacts: vec![],
            contact_count: 0,
            left_road: 2,
            ended: Some(EndReason::Duration),
            ..SummaryAccumulator::new([10.0, 60.0]).to_summary()
        };
        let expected = "\
5 vehicles on ring-250, native, driver idm, policy pi
window                   10.0 s to 60.0 s
mean speed, all vehicles 10.000 m/s (22.37 mph)
SD of all speeds         0.500 m/s (1.12 mph)
mean speed, ego          -
time in range            12.5 %
smallest gap             4.26 m
contacts, off the road   0, 2
";
        assert_eq!(summary(&planned(&scenario), "native", "idm", "pi", &whole), expected);

        // Without advice and without a leader; stopped after a contact.
        let contact = ContactRecord { time_s: 5.25, car: 3, ego_speed_mps: 4.0, car_speed_mps: 1.0, closing_mps: 3.0 };
        let kmh = Scenario { display: DisplaySettings { units: SpeedUnit::Kmh, ..scenario.display }, ..scenario };
        let stopped = Summary {
            time_in_range: None,
            min_gap_m: None,
            contacts: vec![contact],
            contact_count: 1,
            object_contacts: 2,
            duration_s: 7.5,
            ended: None,
            ..whole
        };
        let text = summary(&planned(&kmh), "native", "idm", "pi", &stopped);
        for line in [
            "mean speed, all vehicles 10.000 m/s (36.00 km/h)",
            "time in range            - (no advice)",
            "smallest gap             -",
            "contacts, off the road   1, 2",
            "fixed objects touched    2",
            "first contact            at 5.25 s with road user 3, closing at 3.00 m/s",
            "stopped                  at 7.5 s",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}: {text}");
        }
        let failed = Summary { failure: Some("the disk is full\n  remedy: make room".into()), ..stopped };
        let text = summary(&planned(&kmh), "native", "idm", "pi", &failed);
        assert!(text.ends_with("broken off               at 7.5 s: failed: the disk is full\n"), "{text}");
    }
}
