//! Tests of single questions: accepted answers, scales, refused definitions, visibility.

use super::*;
use serde_json::json;

/// Parses a question with these keys.
fn element(keys: &str) -> QuestionElement {
    serde_json::from_str(&format!(r#"{{ "name": "q", {keys} }}"#)).unwrap_or_else(|e| panic!("{keys}: {e}"))
}

#[test]
fn each_kind_accepts_its_own_answers_alone() {
    let words = json!(["a", 2]);
    let list = r#""choices": ["a", {"value": 2, "text": "two"}]"#;
    for (keys, good, bad) in [
        (
            format!(r#""type": "radiogroup", {list}"#),
            vec![json!("a"), json!(2)],
            vec![json!("b"), json!("two"), words.clone()],
        ),
        (
            format!(r#""type": "checkbox", {list}"#),
            vec![words, json!([]), json!([2])],
            vec![json!("a"), json!(["a", "b"]), json!(["two"])],
        ),
        (
            r#""type": "rating", "rateMin": -1, "rateMax": 1, "rateStep": 0.5"#.into(),
            vec![json!(-1), json!(0.5), json!(1.0)],
            vec![json!(0.25), json!(1.5), json!("1"), json!(-1.5)],
        ),
        (r#""type": "boolean""#.into(), vec![json!(true), json!(false)], vec![json!("yes"), json!(1)]),
        (
            r#""type": "matrix", "columns": [0, 1], "rows": ["x"]"#.into(),
            vec![json!(0), json!(1)],
            vec![json!(2), json!("x")],
        ),
        (r#""type": "text""#.into(), vec![json!("words")], vec![json!(3)]),
        (r#""type": "comment""#.into(), vec![json!("words")], vec![json!(["words"])]),
        (r#""type": "html""#.into(), vec![], vec![json!("words"), json!(true)]),
    ] {
        let element = element(&keys);
        good.iter().for_each(|answer| assert!(element.accepts(answer), "{keys}: {answer}"));
        bad.iter().for_each(|answer| assert!(!element.accepts(answer), "{keys}: {answer}"));
    }
}

#[test]
fn a_scale_has_its_steps_and_goes_from_1_to_5_by_default() {
    assert_eq!(element(r#""type": "rating""#).rates(), [1.0, 2.0, 3.0, 4.0, 5.0]);
    let rates = element(r#""type": "rating", "rateMin": -1, "rateMax": 0.5, "rateStep": 0.5"#).rates();
    assert_eq!(rates, [-1.0, -0.5, 0.0, 0.5]);
    for (keys, is_right) in [
        (r#""rateMin": 0, "rateMax": 100, "rateStep": 1"#, true),
        (r#""rateMin": 0, "rateMax": 101, "rateStep": 1"#, false),
        (r#""rateMin": 0, "rateMax": 1, "rateStep": 1"#, true),
        (r#""rateMin": 0, "rateMax": 1, "rateStep": 2"#, false),
        (r#""rateMin": 1, "rateMax": 1, "rateStep": 1"#, false),
        (r#""rateMin": 5, "rateMax": 1, "rateStep": -1"#, false),
        (r#""rateMin": 0, "rateMax": 1, "rateStep": 0"#, false),
        (r#""rateMin": 0, "rateMax": 1, "rateStep": 0.1"#, true),
        (r#""rateMin": 0, "rateMax": 1, "rateStep": 0.3"#, false),
    ] {
        let message = element(&format!(r#""type": "rating", {keys}"#)).check();
        assert_eq!(message.is_ok(), is_right, "{keys}: {message:?}");
    }
}

#[test]
fn questions_without_choices_are_refused() {
    for (keys, has) in [
        (r#""type": "radiogroup""#, "no choices"),
        (r#""type": "checkbox""#, "no choices"),
        (r#""type": "matrix", "rows": ["x"]"#, "no columns"),
        (r#""type": "matrix", "columns": ["x"]"#, "no rows"),
    ] {
        let message = element(keys).check().expect_err(keys).to_string();
        assert!(message.contains(has) && message.contains("\"q\""), "{message}");
    }
    for fine in
        [r#""type": "boolean""#, r#""type": "html", "html": "x""#, r#""type": "matrix", "columns": [1], "rows": [2]"#]
    {
        assert_eq!(element(fine).check(), Ok(()), "{fine}");
    }
}

#[test]
fn a_choice_is_a_word_a_number_or_both_and_nothing_else() {
    let choice = |text: &str| serde_json::from_str::<AnswerChoice>(text).map_err(|e| e.to_string());
    let is = |value: Value, text: &str| Ok(AnswerChoice { value, text: text.into() });
    assert_eq!(choice(r#""small""#), is(json!("small"), "small"));
    assert_eq!(choice("3"), is(json!(3), "3"));
    assert_eq!(choice(r#"{ "value": 3, "text": "severe" }"#), is(json!(3), "severe"));
    for bad in ["true", "null", "[1]"] {
        assert!(choice(bad).unwrap_err().contains("allowed: a word, a number or value and text"), "{bad}");
    }
    assert!(choice(r#"{ "value": 3, "words": "severe" }"#).is_err());
}

#[test]
fn answers_are_named_by_question_and_row_and_html_has_none() {
    assert_eq!(element(r#""type": "text""#).answer_names(), ["q"]);
    assert_eq!(element(r#""type": "matrix", "columns": [1], "rows": ["rain", 2]"#).answer_names(), ["q.rain", "q.2"]);
    assert_eq!(element(r#""type": "html""#).answer_names(), Vec::<String>::new());
}

const TWO_PAGES: &str = r#"{ "title": "T", "pages": [
    { "name": "one", "elements": [ { "type": "boolean", "name": "a", "isRequired": true },
                                   { "type": "rating", "name": "b" } ] },
    { "name": "two", "visibleIf": "{a} = true", "elements": [ { "type": "rating", "name": "c", "isRequired": true } ] },
    { "name": "three", "elements": [ { "type": "rating", "name": "d", "isRequired": true, "visibleIf": "{b} > 3" } ] } ],
  "scores": [ { "name": "sum", "method": "sum", "of": ["a", "b"], "weight": 2 },
              { "name": "mean", "method": "mean", "of": ["a", "b"] } ] }"#;

fn answers(list: &[(&str, Value)]) -> Answers {
    list.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect()
}

#[test]
fn a_page_is_visible_if_its_condition_holds_and_it_has_elements() {
    let q = Questionnaire::parse(TWO_PAGES, "two.json").unwrap();
    let seen = |list: &[(&str, Value)]| -> Vec<String> {
        let answers = answers(list);
        q.visible_pages(&answers).map(|page| page.name.clone()).collect()
    };
    assert_eq!(seen(&[]), ["one"]);
    assert_eq!(seen(&[("a", json!(true))]), ["one", "two"]);
    assert_eq!(seen(&[("a", json!(false)), ("b", json!(3))]), ["one"]);
    assert_eq!(seen(&[("a", json!(true)), ("b", json!(4))]), ["one", "two", "three"]);
    // Missing required answers, of visible questions only.
    assert_eq!(q.pages[0].missing(&answers(&[])), ["a"]);
    assert_eq!(q.pages[0].missing(&answers(&[("a", json!(false))])), Vec::<String>::new());
    assert_eq!(q.pages[2].missing(&answers(&[("b", json!(3))])), Vec::<String>::new());
    assert_eq!(q.pages[2].missing(&answers(&[("b", json!(5))])), ["d"]);
}

#[test]
fn a_score_is_a_weighted_sum_or_mean_and_empty_without_an_answer() {
    let q = Questionnaire::parse(TWO_PAGES, "two.json").unwrap();
    let scores =
        |list: &[(&str, Value)]| q.scores(&answers(list)).into_iter().map(|(_, score)| score).collect::<Vec<_>>();
    assert_eq!(scores(&[("a", json!(true)), ("b", json!(4))]), [Some(10.0), Some(2.5)]);
    assert_eq!(scores(&[("a", json!(false)), ("b", json!(4))]), [Some(8.0), Some(2.0)]);
    assert_eq!(scores(&[("a", json!(true))]), [None, None]);
    assert_eq!(scores(&[("a", json!("often")), ("b", json!(4))]), [None, None], "a word is no number");
}

#[test]
fn a_condition_may_use_only_earlier_or_same_page_questions() {
    let with = |first: &str, second: &str| {
        let text = format!(
            r#"{{ "title": "T", "pages": [ {{ "elements": [ {{ "type": "boolean", "name": "a" {first} }} ] }},
                {{ "elements": [ {{ "type": "matrix", "name": "m", "columns": [1], "rows": ["x"] {second} }} ] }} ] }}"#
        );
        Questionnaire::parse(&text, "order.json").map(|_| ()).map_err(|e| e.0)
    };
    assert_eq!(with("", r#", "visibleIf": "{a} = true""#), Ok(()));
    assert_eq!(with("", r#", "visibleIf": "{m.x} = 1""#), Ok(()), "beside it");
    let message = with(r#", "visibleIf": "{m.x} = 1""#, "").unwrap_err();
    assert!(message.contains("names \"m.x\", but no earlier question and none on its page has this name"), "{message}");
    assert!(with("", r#", "visibleIf": "{m} = 1""#).is_err(), "a matrix is answered by its rows");
}

#[test]
fn shipped_questionnaires_are_listed_in_order() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["b.json", "a.json", "notes.txt", "c.json.new"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    assert_eq!(words(folder.path()), ["a", "b"]);
    assert_eq!(words(&folder.path().join("nothing")), Vec::<String>::new());
}

#[test]
fn words_between_the_comparisons_of_a_condition_may_stand_in_its_answers() {
    let condition =
        VisibilityCondition::parse("{a} = 'red or green' or {b} = 'black and white' and {c} = true").unwrap();
    let answers = |a: &str, b: &str, c: bool| {
        [("a", Value::from(a)), ("b", Value::from(b)), ("c", Value::from(c))]
            .map(|(name, value)| (name.to_owned(), value))
            .into()
    };
    assert!(condition.holds(&answers("red or green", "", false)));
    assert!(condition.holds(&answers("", "black and white", true)));
    assert!(!condition.holds(&answers("red", "black and white", false)));
}

#[test]
fn a_score_counts_typed_numbers_and_a_word_is_none() {
    let text = r#"{ "title": "T", "pages": [ { "elements": [ { "type": "rating", "name": "a" },
        { "type": "text", "name": "b", "inputType": "number", "min": -9, "max": 9000 } ] } ],
        "scores": [ { "name": "sum", "method": "sum", "of": ["a", "b"] } ] }"#;
    let number = Questionnaire::parse(text, "score.json").unwrap();
    for (typed, sum) in [("3", Some(5.0)), ("1,200 km", Some(1202.0)), ("-3", Some(-1.0)), ("three", None)] {
        let scores = number.scores(&answers(&[("a", json!(2)), ("b", json!(typed))]));
        assert_eq!(scores, [("sum".to_owned(), sum)], "{typed}");
    }
}

#[test]
fn a_number_below_0_is_accepted_where_its_range_has_it() {
    let number = element(r#""type": "text", "inputType": "number", "min": -5, "max": 5"#);
    for (typed, is_fine) in [("-3", true), ("-5.0", true), ("-6", false), ("--3", false), ("5", true), ("-", false)] {
        assert_eq!(number.accepts(&json!(typed)), is_fine, "{typed}");
    }
}
