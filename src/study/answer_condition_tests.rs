//! Tests of conditions on answers: typed numbers, and comparisons of unlike types.

use super::*;

/// Questions of every kind; `{if}` is the condition of the last page.
const ALL: &str = r#"{ "title": "T", "pages": [ { "elements": [
    { "type": "text", "name": "age", "inputType": "number", "min": 1, "max": 99 },
    { "type": "text", "name": "words" },
    { "type": "comment", "name": "lines" },
    { "type": "rating", "name": "rate", "rateMin": 1, "rateMax": 7 },
    { "type": "boolean", "name": "yes" },
    { "type": "radiogroup", "name": "one", "choices": ["small", { "value": "large", "text": "a lot" }] },
    { "type": "radiogroup", "name": "count", "choices": [0, 1, 2] },
    { "type": "checkbox", "name": "some", "choices": ["a", "b"] },
    { "type": "matrix", "name": "grid", "columns": [0, 1, 2], "rows": ["x"] } ] },
  { "visibleIf": "{if}", "elements": [ { "type": "html", "name": "h", "html": "x" } ] } ] }"#;

fn questionnaire(condition: &str) -> Result<Questionnaire, String> {
    Questionnaire::checked(&ALL.replace("{if}", condition), "all.json").map_err(|error| error.0)
}

#[test]
fn a_typed_number_is_compared_as_a_number() {
    let holds = |by: &str, typed: &str| {
        let condition = VisibilityCondition::parse(&format!("{{age}} {by}")).unwrap();
        condition.holds(&[("age".to_owned(), Value::from(typed))].into())
    };
    for (by, expected) in [
        ("< 18", [true, false, false]),
        ("<= 18", [true, true, false]),
        ("> 18", [false, false, true]),
        (">= 18", [false, true, true]),
        ("= 18", [false, true, false]),
        ("<> 18", [true, false, true]),
    ] {
        // "9" and "100" are on the wrong side as words.
        assert_eq!(["9", "18", "100"].map(|typed| holds(by, typed)), expected, "{by}");
        assert_eq!([" 9 years", "18.0", "1,000"].map(|typed| holds(by, typed)), expected, "{by} with units and commas");
    }
    assert!(holds("< 0", "-3") && !holds("< 0", "3") && holds("= -3", "-3"));
    assert!(!holds("< 18", "nine") && !holds(">= 18", "nine") && !holds("< 18", ""), "a word has no order");
}

#[test]
fn comparisons_of_the_type_of_the_question_are_sound() {
    for condition in [
        "{age} < 18 and {age} >= 2.5 or {age} = 50",
        "{words} = 'x' or {lines} <> '18'",
        "{rate} < 18 and {rate} = 7",
        "{yes} = true or {yes} <> false",
        "{one} = 'large' or {one} <> 'small'",
        "{count} >= 1 and {count} = 2",
        "{some} contains 'b'",
        "{grid.x} = 0 or {grid.x} > 1",
    ] {
        assert_eq!(questionnaire(condition).map(|_| ()), Ok(()), "{condition}");
    }
}

#[test]
fn a_comparison_of_unlike_types_is_named_with_its_line_and_remedy() {
    for (condition, has) in [
        (
            "{words} < 18",
            "\"words\" is a text; allowed: = or <> with a word in quotes; or let a text ask for a number by",
        ),
        ("{words} = 18", "is a text"),
        ("{lines} >= 1", "is a text"),
        ("{words} contains 'x'", "is a text"),
        ("{age} < '18'", "\"age\" is a number; allowed: = <> < <= > >= with a number, without quotes"),
        ("{age} = 'young'", "is a number"),
        ("{age} = true", "is a number"),
        ("{age} contains 1", "is a number"),
        ("{rate} = 'often'", "\"rate\" is a rating; allowed: = <> < <= > >= with a number of its scale, 1 to 7"),
        ("{rate} < 'often'", "is a rating"),
        ("{rate} = 8", "1 to 7"),
        ("{rate} contains 1", "is a rating"),
        ("{yes} = 1", "is yes or no; allowed: = or <> with true or false"),
        ("{yes} < true", "is yes or no"),
        ("{yes} = 'true'", "is yes or no"),
        ("{one} = 'larg'", "one of its choices; allowed: = or <> with one of 'small', 'large' (did you mean large?)"),
        ("{one} < 3", "one of its choices"),
        ("{one} contains 'small'", "one of its choices"),
        ("{count} = 3", "allowed: = <> < <= > >= with one of 0, 1, 2"),
        ("{count} < 'two'", "one of its choices"),
        ("{some} = 'a'", "a list of choices; allowed: contains with one of 'a', 'b'"),
        ("{some} contains 'c'", "a list of choices"),
        ("{grid.x} = 'much'", "\"grid.x\" is one of its choices"),
        // The second comparison of two is found, too.
        ("{age} < 18 and {yes} = 3", "\"{yes} = 3\" does not fit"),
    ] {
        let message = questionnaire(condition).expect_err(condition);
        let column = if condition.contains(" and ") { 34 } else { 19 };
        assert!(message.starts_with(&format!("all.json:11:{column}: \"")) && message.contains(has), "{message}");
    }
    let message = questionnaire("{agee} < 18").unwrap_err();
    assert!(message.starts_with("all.json:11:19: ") && message.contains("did you mean age?"), "{message}");
}
