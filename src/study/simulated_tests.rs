//! Tests of simulated participants: documented distributions, and answers that the questions allow.

use super::*;
use std::path::Path;

#[test]
fn every_answer_is_allowed_and_none_that_is_required_is_missing() {
    for name in ["ssq", "raw-tlx", "acceptance", "driving-experience"] {
        let questionnaire = Questionnaire::find(name, Path::new(".")).unwrap();
        for index in 0..20 {
            let participant = SimulatedParticipant::draw(5, index);
            assert_eq!(participant.driver.check(), Ok(()));
            let answered = participant.answer(&questionnaire, name);
            let map = as_map(&answered);
            for page in questionnaire.visible_pages(&map) {
                assert_eq!(page.missing(&map), Vec::<String>::new(), "{name}");
                for element in page.visible_elements(&map) {
                    for answer in element.answer_names() {
                        assert!(element.accepts(&map[&answer]), "{answer}: {}", map[&answer]);
                    }
                }
            }
            assert_eq!(answered, SimulatedParticipant::draw(5, index).answer(&questionnaire, name));
        }
    }
}

#[test]
fn traits_follow_their_documented_distributions() {
    let people: Vec<SimulatedParticipant> = (0..400).map(|i| SimulatedParticipant::draw(1, i)).collect();
    let mean_and_sd = |get: &dyn Fn(&SimulatedParticipant) -> f64| {
        let values: Vec<f64> = people.iter().map(get).collect();
        let mean = values.iter().sum::<f64>() / 400.0;
        (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 399.0).sqrt())
    };
    // Uniform between two limits: mean in the middle, SD of the width divided by the square root of 12. Tolerance: three standard errors.
    let width_to_sd = 12f64.sqrt();
    for (name, low, high) in
        [("reaction_s", 0.6, 1.6), ("error_mps", 0.1, 0.6), ("lane_error_m", 0.03, 0.10), ("level", 0.0, 1.0)]
    {
        assert!(people.iter().all(|p| (low..high).contains(&p.parameters()[name])), "{name}");
        let (mean, sd) = mean_and_sd(&|p| p.parameters()[name]);
        let expected = (high - low) / width_to_sd;
        assert!((mean - f64::midpoint(low, high)).abs() < 3.0 * expected / 20.0, "{name}: {mean}");
        assert!((sd / expected - 1.0).abs() < 0.1, "{name}: {sd}");
    }
    // Normal with SD 0.25 m/s, clamped to 0.6 m/s, which reduces the SD by 2 %.
    let (mean, sd) = mean_and_sd(&|p| p.parameters()["overspeed_mps"]);
    assert!(mean.abs() < 3.0 * 0.25 / 20.0 && (sd / 0.245 - 1.0).abs() < 0.12, "{mean}, {sd}");
    assert!(people.iter().all(|p| p.parameters()["overspeed_mps"].abs() <= 0.6));
    for p in &people {
        // The response to brake lamps ahead is faster than the response to a number on the dial.
        assert_eq!(p.driver.leader_reaction_s, 0.7 * p.driver.reaction_s);
        assert_eq!(p.parameters()["reaction_s"], p.driver.reaction_s);
    }
    assert_eq!(people[7].parameters(), SimulatedParticipant::draw(1, 7).parameters());
    assert_ne!(people[7].parameters(), SimulatedParticipant::draw(2, 7).parameters());
}

#[test]
fn answers_follow_the_participants_level_and_take_seconds() {
    let tlx = Questionnaire::find("raw-tlx", Path::new(".")).unwrap();
    let (mut low, mut high, mut waits) = (Vec::new(), Vec::new(), Vec::new());
    for index in 0..200 {
        let participant = SimulatedParticipant::draw(9, index);
        let answered = participant.answer(&tlx, "tlx");
        let mean = answered.iter().filter_map(|a| a.answer.as_f64()).sum::<f64>() / answered.len() as f64;
        let level = participant.parameters()["level"];
        if level < 0.3 {
            low.push(mean)
        } else if level > 0.7 {
            high.push(mean)
        }
        let times: BTreeMap<&str, f64> = answered.iter().map(|one| (one.question.as_str(), one.time_s)).collect();
        // Times of each page begin at 0.
        for page in &tlx.pages {
            let mut before = 0.0;
            for name in page.elements.iter().flat_map(QuestionElement::answer_names) {
                waits.push(times[name.as_str()] - before);
                before = times[name.as_str()];
            }
        }
    }
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
    // Mean levels of 0.15 and 0.85 on a scale from 0 to 100.
    assert!((mean(&low) - 15.0).abs() < 6.0 && (mean(&high) - 85.0).abs() < 6.0, "{} {}", mean(&low), mean(&high));
    // At least 1.5 s, plus an exponential time of mean 2 s; 1,200 answers, three standard errors.
    assert_eq!(waits.len(), 1200);
    assert!(waits.iter().all(|wait| *wait >= 1.499));
    assert!((mean(&waits) - 3.5).abs() < 3.0 * 2.0 / (waits.len() as f64).sqrt(), "{}", mean(&waits));
    let milliseconds = waits.iter().map(|wait| (wait * 1000.0 - (wait * 1000.0).round()).abs());
    assert!(milliseconds.fold(0.0, f64::max) < 1e-6);
}

/// Returns a participant with this level.
fn of_level(level: f64, index: usize) -> SimulatedParticipant {
    SimulatedParticipant { level, ..SimulatedParticipant::draw(3, index) }
}

/// Returns a questionnaire with one question of these keys, repeated `rows` times.
fn asked(keys: &str, rows: usize) -> Questionnaire {
    let elements: Vec<String> = (0..rows).map(|i| format!(r#"{{ "name": "q{i}", "title": "?", {keys} }}"#)).collect();
    let text = format!(r#"{{ "title": "T", "pages": [{{ "elements": [{}] }}] }}"#, elements.join(","));
    Questionnaire::parse(&text, "asked.json").unwrap_or_else(|e| panic!("{e}"))
}

/// Returns all answers of 20 participants with this level to 100 such questions.
fn answers(level: f64, keys: &str) -> Vec<Value> {
    let questionnaire = asked(keys, 100);
    let of = |index| of_level(level, index).answer(&questionnaire, "item").into_iter().map(|one| one.answer);
    (0..20).flat_map(of).collect()
}

fn mean_and_sd(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()]
}

fn numbers(answers: &[Value]) -> Vec<f64> {
    answers.iter().map(|answer| answer.as_f64().unwrap()).collect()
}

/// Returns three standard errors of the mean and of the SD of 2,000 answers with this SD.
fn three_errors(sd: f64) -> [f64; 2] {
    [3.0 * sd / 2000_f64.sqrt(), 3.0 * sd / 4000_f64.sqrt()]
}

#[test]
fn a_rating_has_a_normal_error_of_15_percent_of_the_scale() {
    let scale = r#""type": "rating", "rateMin": 0, "rateMax": 100, "rateStep": 1"#;
    for level in [0.4, 0.5] {
        // 2.7 and 3.3 SD from the nearer end: the effect of the clamp is below the error of the mean.
        let [mean, sd] = mean_and_sd(&numbers(&answers(level, scale)));
        let [of_mean, of_sd] = three_errors(15.0);
        assert!((mean - 100.0 * level).abs() < of_mean && (sd - 15.0).abs() < of_sd, "{level}: {mean}, {sd}");
    }
    // A level at an end gives that end in half of all answers, and no value beyond it.
    for (level, end) in [(0.0, 0.0), (1.0, 100.0)] {
        let all = numbers(&answers(level, scale));
        let there = all.iter().filter(|rate| **rate == end).count();
        assert!(all.iter().all(|rate| (0.0..=100.0).contains(rate)) && (900..1150).contains(&there), "{there}");
    }
}

#[test]
fn a_rating_is_an_integer_if_its_value_is_whole() {
    let all = answers(0.5, r#""type": "rating", "rateMin": 0, "rateMax": 2, "rateStep": 0.5"#);
    let words: std::collections::BTreeSet<String> = all.iter().map(Value::to_string).collect();
    assert_eq!(words.into_iter().collect::<Vec<_>>(), ["0", "0.5", "1", "1.5", "2"]);
}

#[test]
fn an_answer_of_a_matrix_is_around_half_the_square_of_the_level() {
    // 101 columns, each with its index as value.
    let columns: Vec<String> = (0..=100).map(|i| i.to_string()).collect();
    let keys = format!(r#""type": "matrix", "rows": ["r"], "columns": [{}]"#, columns.join(","));
    for (level, place) in [(1.0, 50.0), (0.9, 40.5)] {
        let [mean, sd] = mean_and_sd(&numbers(&answers(level, &keys)));
        let [of_mean, of_sd] = three_errors(12.0);
        assert!((mean - place).abs() < of_mean && (sd - 12.0).abs() < of_sd, "{level}: {mean}, {sd}");
    }
    // At level 0, half of the answers are 0; the others are the upper half of the error, with an overall mean of 12 / sqrt(2 pi).
    let none = numbers(&answers(0.0, &keys));
    let [mean, _] = mean_and_sd(&none);
    assert!((mean - 12.0 / (2.0 * std::f64::consts::PI).sqrt()).abs() < 0.5, "{mean}");
}

#[test]
fn the_error_is_added_to_the_participants_level() {
    // The same random numbers drawn by hand: the time of the answer, then its error.
    let participant = of_level(0.5, 4);
    let mut stream = rng::stream(3, "answers 4 item");
    let rating = asked(r#""type": "rating", "rateMin": 0, "rateMax": 100, "rateStep": 1"#, 30);
    for one in participant.answer(&rating, "item") {
        stream.uniform(0.0, 1.0);
        let by_hand = (100.0 * (0.5 + 0.15 * stream.normal())).round().clamp(0.0, 100.0);
        assert_eq!(one.answer.as_f64(), Some(by_hand));
    }
    let columns: Vec<String> = (0..=100).map(|i| i.to_string()).collect();
    let keys = format!(r#""type": "matrix", "rows": ["r"], "columns": [{}]"#, columns.join(","));
    let mut stream = rng::stream(3, "answers 4 item");
    for one in participant.answer(&asked(&keys, 30), "item") {
        stream.uniform(0.0, 1.0);
        let by_hand = (100.0 * (0.125 + 0.12 * stream.normal())).round().clamp(0.0, 100.0);
        assert_eq!(one.answer.as_f64(), Some(by_hand));
    }
}

#[test]
fn choices_are_uniform_checkboxes_at_30_percent_and_yes_at_70_percent() {
    let share = |n: usize, expected: f64, of: f64| {
        // Three standard errors of a share.
        let error = 3.0 * (expected * (1.0 - expected) / of).sqrt();
        assert!((n as f64 / of - expected).abs() < error, "{n} of {of}, not {expected}");
    };
    let all = answers(0.5, r#""type": "radiogroup", "choices": ["a", "b", "c", "d"]"#);
    for word in ["a", "b", "c", "d"] {
        share(all.iter().filter(|answer| *answer == word).count(), 0.25, 2000.0);
    }
    let all = answers(0.5, r#""type": "checkbox", "choices": ["a", "b"]"#);
    for word in ["a", "b"] {
        let taken = |answer: &&Value| answer.as_array().unwrap().contains(&json!(word));
        share(all.iter().filter(taken).count(), 0.3, 2000.0);
    }
    let all = answers(0.5, r#""type": "boolean""#);
    share(all.iter().filter(|answer| **answer == json!(true)).count(), 0.7, 2000.0);
    for kind in ["text", "comment"] {
        assert!(answers(0.5, &format!(r#""type": "{kind}""#)).iter().all(|answer| answer == "rehearsed"));
    }
}

#[test]
fn hidden_questions_are_not_answered() {
    let text = r#"{ "title": "T", "pages": [
        { "elements": [ { "type": "boolean", "name": "licence" },
                        { "type": "rating", "name": "years", "visibleIf": "{licence} = true" },
                        { "type": "html", "name": "note", "html": "x" } ] },
        { "visibleIf": "{licence} = false", "elements": [ { "type": "rating", "name": "bus" } ] } ] }"#;
    let questionnaire = Questionnaire::parse(text, "hidden.json").unwrap();
    let mut seen = [0; 2];
    for index in 0..60 {
        let answered = of_level(0.5, index).answer(&questionnaire, "item");
        let names: Vec<&str> = answered.iter().map(|one| one.question.as_str()).collect();
        let licence = answered[0].answer == json!(true);
        seen[usize::from(licence)] += 1;
        assert_eq!(names, if licence { ["licence", "years"] } else { ["licence", "bus"] });
    }
    assert!(seen[0] > 5 && seen[1] > 5, "both ways came: {seen:?}");
}

#[test]
fn sickness_rises_with_driving_time_and_is_reproducible() {
    let text = "title = \"t\"\nparticipants = 2\n[base]\ntraffic = \"native\"\nduration_s = 600.0\n[[condition]]\nname = \"a\"\n\
                [[condition]]\nname = \"b\"\n[[segment]]\nkind = \"trials\"\nname = \"trial\"\nfms_every_s = 60.0\n";
    let study = Study::parse(text.into(), Path::new("t.toml")).unwrap();
    let mean = |place: usize, time_s: f64| {
        let value = |index: usize| {
            let plan = study.plan(index);
            let rating = SimulatedParticipant::draw(3, index).rate(&plan, &plan.items[place].name, time_s);
            assert_eq!(rating, SimulatedParticipant::draw(3, index).rate(&plan, &plan.items[place].name, time_s));
            assert_eq!((rating.time_s, rating.value.is_some()), (time_s, rating.answer_s.is_some()));
            assert!(rating.answer_s.is_none_or(|s| (1.5..15.0).contains(&s)) && rating.value.is_none_or(|v| v <= 20));
            rating.value
        };
        let values: Vec<f64> = (0..2000).filter_map(value).map(f64::from).collect();
        // An answer takes 15 s or more with probability exp(-13.5 / 2) = 0.1 %.
        assert!(values.len() > 1985, "{}", values.len());
        values.iter().sum::<f64>() / values.len() as f64
    };
    // Slope 0.1 per minute: 1 after ten minutes and 2 after twenty. Negative values count as 0, which raises the mean by at most 0.5 /
    // sqrt(2 pi) = 0.2; three standard errors of an exponential mean of 2000 values are 6.7 % of it.
    let [one, ten, twenty] = [mean(0, 60.0), mean(0, 600.0), mean(1, 600.0)];
    assert!((0.1..0.35).contains(&one), "{one}");
    assert!((0.93..1.27).contains(&ten) && (1.86..2.34).contains(&twenty), "{ten} {twenty}");
}
