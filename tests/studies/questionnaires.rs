//! Scores of shipped questionnaires against worked examples, and faulty scores.

use codrive::study::{Questionnaire, questions::Answers};
use serde_json::json;
use std::{collections::BTreeMap, path::Path};

fn questionnaire(name: &str) -> Questionnaire {
    Questionnaire::find(name, Path::new(".")).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn tlx_weights_count_the_choices_of_each_demand() {
    let tlx = questionnaire("nasa-tlx");
    let names = ["mental", "physical", "temporal", "performance", "effort", "frustration"];
    let pairs: Vec<String> = tlx.answer_names().into_iter().filter(|name| name.contains("-or-")).collect();
    // Every pair of six occurs once.
    let mut seen: Vec<[&str; 2]> =
        pairs.iter().map(|p| p.split_once("-or-").map(|(a, b)| if a < b { [a, b] } else { [b, a] }).unwrap()).collect();
    seen.sort();
    seen.dedup();
    assert_eq!((pairs.len(), seen.len()), (15, 15));
    // Worked by hand: mental beats all, then temporal, effort, frustration, performance, physical: weights 5, 0, 4, 1, 3, 2.
    let rank = ["mental", "temporal", "effort", "frustration", "performance", "physical"];
    let place = |name: &str| rank.iter().position(|r| *r == name).unwrap();
    let mut answers: Answers =
        names.iter().zip([70, 20, 60, 30, 50, 40]).map(|(n, v)| ((*n).into(), json!(v))).collect();
    for pair in &pairs {
        let (a, b) = pair.split_once("-or-").unwrap();
        answers.insert(pair.clone(), json!(if place(a) < place(b) { a } else { b }));
    }
    // (5 * 70 + 4 * 60 + 1 * 30 + 3 * 50 + 2 * 40) / 15 = 850 / 15; the mean without weights is 270 / 6.
    let scores: BTreeMap<String, Option<f64>> = tlx.scores(&answers).into_iter().collect();
    assert!(
        (scores["weighted-tlx"].unwrap() - 850.0 / 15.0).abs() < 1e-9 && scores["raw-tlx"] == Some(45.0),
        "{scores:?}"
    );
    answers.remove(&pairs[3]);
    assert_eq!(tlx.scores(&answers)[0].1, None, "a pair is missing");
}

#[test]
fn the_acceptance_scale_reverses_its_third_sixth_and_eighth_pair() {
    let scale = questionnaire("van-der-laan");
    let elements: Vec<_> = scale.pages.iter().flat_map(|page| &page.elements).collect();
    // Van der Laan, Heino and De Waard (1997): nine pairs in this order, the left word first.
    let pairs = [
        ["Useful", "Useless"],
        ["Pleasant", "Unpleasant"],
        ["Bad", "Good"],
        ["Nice", "Annoying"],
        ["Effective", "Superfluous"],
        ["Irritating", "Likeable"],
        ["Assisting", "Worthless"],
        ["Undesirable", "Desirable"],
        ["Raising alertness", "Sleep-inducing"],
    ];
    let shown: Vec<[&str; 2]> =
        elements.iter().map(|e| [e.min_rate_description.as_str(), e.max_rate_description.as_str()]).collect();
    assert_eq!(shown, pairs);
    let scored = |places: [i64; 9]| -> Vec<f64> {
        let answers: Answers = elements.iter().zip(places).map(|(e, place)| (e.name.clone(), json!(place))).collect();
        scale.scores(&answers).into_iter().map(|(_, figure)| (figure.unwrap() * 1e9).round() / 1e9).collect()
    };
    // The favourable word in every pair: the left one except in the third, sixth and eighth.
    assert_eq!(scored([1, 1, 5, 1, 1, 5, 1, 5, 1]), [2.0, 2.0]);
    assert_eq!(scored([5, 5, 1, 5, 5, 1, 5, 1, 5]), [-2.0, -2.0]);
    assert_eq!(scored([3; 9]), [0.0, 0.0]);
    // By hand: usefulness (2 + 1 + 0 - 1 + 1) / 5, satisfaction (1 - 1 + 2 + 0) / 4.
    assert_eq!(scored([1, 2, 4, 4, 3, 5, 4, 3, 2]), [0.6, 0.5]);
}

#[test]
fn wariness_counts_against_trust() {
    let trust = questionnaire("trust");
    let scored = |values: [i64; 4]| {
        let names = ["reliable", "understandable", "wary", "follow"];
        let answers: Answers = names.iter().zip(values).map(|(name, value)| ((*name).into(), json!(value))).collect();
        trust.scores(&answers)[0].1
    };
    assert_eq!((scored([7, 7, 1, 7]), scored([1, 1, 7, 1])), (Some(7.0), Some(1.0)));
    // (6 + 5 + (8 - 3) + 4) / 4
    assert_eq!(scored([6, 5, 3, 4]), Some(5.0));
}

#[test]
fn a_mistake_in_a_score_is_named() {
    let text = |score: &str| {
        format!(
            r#"{{ "title": "T", "pages": [ {{ "elements": [ {{"type":"rating","name":"a"}}, {{"type":"text","name":"b"}} ] }} ],
            "scores": [{{ "name": "s", {score} }}] }}"#
        )
    };
    for (score, has) in [
        (r#""method": "weighted", "of": ["a"]"#, "weighting without `by`"),
        (r#""method": "mean", "of": ["a"], "by": ["b"]"#, "has `by` without weighting"),
        (r#""method": "sum", "of": ["a"], "turned": ["b"]"#, "reverses \"b\""),
        (r#""method": "sum", "of": ["a", "b"], "turned": ["b"]"#, "reverses \"b\"; allowed: a rating"),
        (r#""method": "weighted", "of": ["a"], "by": ["c"]"#, "uses \"c\", but no question has this name"),
    ] {
        let printed = Questionnaire::parse(&text(score), "t.json").expect_err(score).to_string();
        assert!(printed.contains(has), "{score}: {printed}");
    }
}
