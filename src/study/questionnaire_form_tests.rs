//! Tests of a form answered with wheel, keys and mouse; missing answers; branches; times.

use super::*;

const EVERY_KIND: &str = r#"{ "title": "Every kind", "pages": [
  { "name": "one", "elements": [
    { "type": "html", "name": "intro", "html": "Some words." },
    { "type": "boolean", "name": "licence", "title": "Do you have a licence?", "isRequired": true },
    { "type": "rating", "name": "effort", "title": "How hard?", "rateMin": 0, "rateMax": 100, "rateStep": 5 },
    { "type": "radiogroup", "name": "car", "title": "Which?", "choices": ["small", "large"], "visibleIf": "{licence} = true" }
  ] },
  { "name": "two", "visibleIf": "{licence} = true", "elements": [
    { "type": "matrix", "name": "often", "isRequired": true, "columns": ["never", "often"], "rows": ["rain", "night"] },
    { "type": "checkbox", "name": "uses", "choices": ["work", "home", "fun"] }
  ] },
  { "name": "three", "elements": [
    { "type": "text", "name": "year", "isRequired": true },
    { "type": "comment", "name": "more" }
  ] } ] }"#;

fn form() -> QuestionnaireForm {
    QuestionnaireForm::new(&Questionnaire::parse(EVERY_KIND, "every.json").unwrap(), 100.0)
}

fn names(form: &QuestionnaireForm) -> Vec<String> {
    form.stops().iter().map(FormPosition::name).collect()
}

#[test]
fn a_wheel_and_two_buttons_answer_every_kind_of_question() {
    let mut form = form();
    assert_eq!(names(&form), ["licence", "effort"], "html is no stop, and the car is not asked for yet");
    form.take(FormInput::Turn(1), 101.0);
    form.take(FormInput::Next, 102.5);
    assert_eq!((form.answer("licence"), form.focus()), (Some(&json!(true)), 1));
    assert_eq!(names(&form), ["licence", "effort", "car"], "the answer brings a question to sight");
    // The first move leads to the middle of the scale; later moves count from there.
    form.take(FormInput::Turn(1), 103.0);
    assert_eq!(form.cursor(), Some(10));
    form.take(FormInput::Turn(-3), 103.5);
    form.take(FormInput::Next, 104.0);
    assert_eq!(form.answer("effort"), Some(&json!(35)));
    form.take(FormInput::Turn(-1), 105.0);
    form.take(FormInput::Next, 105.5);
    assert_eq!((form.answer("car"), form.focus()), (Some(&json!("large")), 3));
    form.take(FormInput::Next, 106.0);
    assert_eq!((form.page().name.as_str(), form.progress()), ("two", (1, 3)));

    for turn in [1, 9] {
        form.take(FormInput::Turn(turn), 107.0);
        form.take(FormInput::Next, 108.0);
    }
    assert_eq!((form.answer("often.rain"), form.answer("often.night")), (Some(&json!("never")), Some(&json!("often"))));
    // Options of a checkbox are toggled; the place after the last option continues.
    for input in [
        FormInput::Turn(1),
        FormInput::Next,
        FormInput::Turn(2),
        FormInput::Next,
        FormInput::Turn(-2),
        FormInput::Next,
        FormInput::Turn(9),
    ] {
        form.take(input, 109.0);
    }
    assert_eq!((form.answer("uses"), form.focus()), (Some(&json!(["fun"])), 2));
    form.take(FormInput::Next, 110.0);
    form.take(FormInput::Next, 111.0);
    assert!(form.typing());
    form.take(FormInput::Type { stop: 0, text: "1999".into() }, 113.25);
    for _ in 0..3 {
        form.take(FormInput::Next, 120.0);
    }
    assert!(form.is_over());
    let times: Vec<(String, f64)> = form.answered().into_iter().map(|a| (a.question, a.time_s)).collect();
    let expected = [
        ("licence", 2.5),
        ("effort", 4.0),
        ("car", 5.5),
        ("often.rain", 2.0),
        ("often.night", 2.0),
        ("uses", 3.0),
        ("year", 2.25),
    ];
    assert_eq!(times, expected.map(|(name, time)| (name.to_owned(), time)), "each since its page was seen");
}

#[test]
fn a_page_waits_for_required_answers_and_focuses_the_first_missing() {
    let mut form = form();
    form.take(FormInput::Next, 101.0);
    assert!(form.is_missing("licence") && form.focus() == 0, "a press without a choice is no answer");
    form.take(FormInput::PageOn, 101.0);
    assert_eq!((form.page().name.as_str(), form.focus()), ("one", 0));
    form.take(FormInput::Pick { stop: 0, option: 1 }, 102.0);
    assert!(!form.is_missing("licence") && form.answer("licence") == Some(&json!(false)));
    // Without a licence, the second page is left out.
    form.take(FormInput::PageOn, 103.0);
    assert_eq!((form.page().name.as_str(), form.progress()), ("three", (1, 2)));
    form.take(FormInput::Type { stop: 0, text: "  ".into() }, 104.0);
    form.take(FormInput::PageOn, 105.0);
    assert!(form.is_missing("year") && !form.is_over(), "blanks are no text");
}

#[test]
fn going_back_keeps_answers_and_hidden_ones_are_not_reported() {
    let mut form = form();
    form.take(FormInput::Pick { stop: 0, option: 0 }, 101.0);
    form.take(FormInput::Pick { stop: 2, option: 0 }, 102.0);
    form.take(FormInput::PageOn, 103.0);
    form.take(FormInput::Back, 104.0);
    assert_eq!((form.page().name.as_str(), form.focus(), form.cursor()), ("one", 0, Some(0)));
    form.take(FormInput::Back, 104.0);
    assert_eq!((form.page().name.as_str(), form.focus()), ("one", 0), "nothing is before the first");
    form.take(FormInput::Focus(9), 104.0);
    assert_eq!(form.focus(), 3, "the button");
    form.take(FormInput::Back, 104.0);
    assert_eq!((form.focus(), form.cursor()), (2, Some(0)));
    form.take(FormInput::Pick { stop: 0, option: 1 }, 105.0);
    assert_eq!(form.answered().iter().map(|a| a.question.as_str()).collect::<Vec<_>>(), ["licence"]);
    form.take(FormInput::Pick { stop: 0, option: 0 }, 106.0);
    assert_eq!(form.answered().len(), 2, "it is there again with its answer");
}

#[test]
fn shipped_questionnaires_yield_only_answers_that_their_kinds_accept() {
    for name in ["ssq", "raw-tlx", "acceptance", "driving-experience"] {
        let questionnaire = Questionnaire::find(name, std::path::Path::new(".")).unwrap();
        let mut form = QuestionnaireForm::new(&questionnaire, 0.0);
        for step in 0..500 {
            let stop = form.focus();
            if form.typing() {
                form.take(FormInput::Type { stop, text: "some words".into() }, 1.0);
            } else {
                let answered = form.stops().get(stop).is_some_and(|s| form.answer(&s.name()).is_some());
                form.take(FormInput::Turn(if answered { 99 } else { 1 + step % 4 }), 1.0);
            }
            form.take(FormInput::Next, 1.0);
        }
        assert!(form.is_over(), "{name} stands at {:?} {}", form.page().name, form.focus());
        let answers = crate::study::session::as_map(&form.answered());
        for page in questionnaire.visible_pages(&answers) {
            assert_eq!(page.missing(&answers), Vec::<String>::new(), "{name}");
            for element in page.visible_elements(&answers) {
                let given = element.answer_names().into_iter().filter_map(|name| answers.get(&name));
                given.for_each(|answer| assert!(element.accepts(answer), "{name} {}: {answer}", element.name));
            }
        }
    }
}

#[test]
fn a_resumed_form_starts_at_the_first_question_without_an_answer() {
    let questionnaire = Questionnaire::parse(EVERY_KIND, "every.json").unwrap();
    let mut form = QuestionnaireForm::new(&questionnaire, 100.0);
    assert_eq!(QuestionnaireForm::resume(&questionnaire, &[], 100.0).answered(), form.answered());
    for input in [
        FormInput::Pick { stop: 0, option: 0 },
        FormInput::Pick { stop: 1, option: 4 },
        FormInput::Pick { stop: 2, option: 1 },
    ] {
        form.take(input, 103.0);
    }
    form.take(FormInput::PageOn, 104.0);
    form.take(FormInput::Pick { stop: 0, option: 1 }, 105.5);
    let before = form.answered();
    assert_eq!(before.len(), 4);

    let mut again = QuestionnaireForm::resume(&questionnaire, &before, 500.0);
    assert_eq!((again.page().name.as_str(), again.focus(), again.answered()), ("two", 1, before));
    again.take(FormInput::Pick { stop: 1, option: 0 }, 502.0);
    let times: Vec<f64> = again.answered().into_iter().map(|a| a.time_s).collect();
    assert_eq!(times, [3.0, 3.0, 3.0, 1.5, 2.0], "each since its page was seen, before the cut or after it");
}

#[test]
fn a_fully_answered_form_resumes_at_the_button_of_the_last_page() {
    let questionnaire = Questionnaire::parse(EVERY_KIND, "every.json").unwrap();
    let answer = |question: &str, answer: Value| TimedAnswer { question: question.into(), answer, time_s: 1.0 };
    // Without a licence there is no second page.
    let all = [
        answer("licence", json!(false)),
        answer("effort", json!(5)),
        answer("year", json!("1999")),
        answer("more", json!("no")),
    ];
    let mut form = QuestionnaireForm::resume(&questionnaire, &all, 0.0);
    assert_eq!((form.page().name.as_str(), form.focus()), ("three", 2));
    form.take(FormInput::Next, 1.0);
    assert!(form.is_over());
    assert_eq!(form.answered(), all);
}

#[test]
fn a_checkbox_takes_several_options_and_needs_one_if_required() {
    let form = |required: bool| {
        let text = format!(
            r#"{{"title":"Uses","pages":[{{"elements":[{{"type":"checkbox","name":"uses","title":"?","isRequired":{required},"choices":["work","fun"]}}]}}]}}"#
        );
        QuestionnaireForm::new(&Questionnaire::parse(&text, "uses.json").unwrap(), 0.0)
    };
    let mut free = form(false);
    assert_eq!(free.title(), "Uses");
    for option in [0, 1] {
        free.take(FormInput::Pick { stop: 0, option }, 1.0);
    }
    assert_eq!(free.answer("uses"), Some(&json!(["work", "fun"])), "in the order of the list");
    for option in [0, 1] {
        free.take(FormInput::Pick { stop: 0, option }, 2.0);
    }
    assert_eq!(free.answer("uses"), Some(&json!([])), "none of them is an answer here");
    // Passed without a choice: an empty list.
    let mut passed = form(false);
    passed.take(FormInput::Turn(9), 1.0);
    passed.take(FormInput::Next, 1.0);
    assert_eq!((passed.answer("uses"), passed.focus()), (Some(&json!([])), 1));

    let mut required = form(true);
    required.take(FormInput::Turn(9), 1.0);
    required.take(FormInput::Next, 1.0);
    assert!(required.is_missing("uses") && required.answer("uses").is_none() && required.focus() == 0);
    required.take(FormInput::Pick { stop: 0, option: 1 }, 2.0);
    assert_eq!(required.answer("uses"), Some(&json!(["fun"])));
    required.take(FormInput::Pick { stop: 0, option: 1 }, 3.0);
    assert_eq!(required.answer("uses"), None, "none of them is no answer here");
}

#[test]
fn a_turn_of_zero_moves_nothing() {
    let mut form = form();
    form.take(FormInput::Turn(0), 101.0);
    assert_eq!(form.cursor(), None);
    form.take(FormInput::Turn(1), 101.0);
    form.take(FormInput::Turn(0), 101.0);
    assert_eq!(form.cursor(), Some(0));
    // A first move backwards starts at the end of a list.
    let mut back = self::form();
    back.take(FormInput::Turn(-1), 101.0);
    assert_eq!(back.cursor(), Some(1));
}

#[test]
fn typing_moves_the_focus_to_that_question() {
    let mut form = form();
    form.take(FormInput::Pick { stop: 0, option: 1 }, 101.0);
    form.take(FormInput::PageOn, 102.0);
    assert_eq!((names(&form), form.focus()), (vec!["year".into(), "more".into()], 0));
    form.take(FormInput::Type { stop: 1, text: "much".into() }, 103.0);
    assert_eq!((form.focus(), form.answer("more")), (1, Some(&json!("much"))));
    form.take(FormInput::Type { stop: 1, text: "more".into() }, 104.5);
    assert_eq!((form.focus(), form.answer("more"), form.answered()[1].time_s), (1, Some(&json!("more")), 2.5));
    form.take(FormInput::Type { stop: 1, text: String::new() }, 105.0);
    assert_eq!((form.answer("more"), form.answered().len()), (None, 1), "what is rubbed out is no answer");
    // Typing is ignored at a stop with options and beyond the last stop.
    form.take(FormInput::PageBack, 106.0);
    for stop in [0, 9] {
        form.take(FormInput::Type { stop, text: "yes".into() }, 107.0);
    }
    assert_eq!(form.answer("licence"), Some(&json!(false)));
}

#[test]
fn returning_to_a_scale_puts_the_cursor_on_the_given_answer() {
    let mut form = form();
    form.take(FormInput::Pick { stop: 0, option: 1 }, 101.0);
    // 35 on a scale of 0 to 100 in steps of 5 is the eighth option.
    form.take(FormInput::Pick { stop: 1, option: 7 }, 102.0);
    assert_eq!(form.answer("effort"), Some(&json!(35)));
    form.take(FormInput::Focus(0), 103.0);
    form.take(FormInput::Focus(1), 103.0);
    assert_eq!(form.cursor(), Some(7));
    let stops = form.stops();
    let chosen: Vec<Value> =
        stops[1].options().into_iter().filter(|option| form.is_chosen(&stops[1], option)).collect();
    assert_eq!(chosen, [json!(35)]);
}

#[test]
fn turning_moves_nothing_at_a_text_field_or_the_button() {
    let mut form = form();
    form.take(FormInput::Pick { stop: 0, option: 1 }, 101.0);
    form.take(FormInput::PageOn, 102.0);
    for stop in [0, 2] {
        form.take(FormInput::Focus(stop), 103.0);
        assert_eq!(form.typing(), stop == 0);
        for by in [1, -1] {
            form.take(FormInput::Turn(by), 103.0);
            assert_eq!((form.focus(), form.cursor()), (stop, None));
        }
    }
}

#[test]
fn missing_answers_stay_marked_and_the_first_gets_the_focus() {
    let mut form = form();
    form.take(FormInput::Pick { stop: 0, option: 0 }, 101.0);
    form.take(FormInput::PageOn, 102.0);
    form.take(FormInput::Focus(2), 103.0);
    form.take(FormInput::PageOn, 103.0);
    let missing = |form: &QuestionnaireForm| ["often.rain", "often.night"].map(|name| form.is_missing(name));
    assert_eq!((form.focus(), missing(&form)), (0, [true, true]));
    form.take(FormInput::Pick { stop: 1, option: 0 }, 104.0);
    assert_eq!(missing(&form), [true, false]);
    form.take(FormInput::Pick { stop: 0, option: 0 }, 105.0);
    assert_eq!(missing(&form), [false, false]);
    // Only the second answer of a page is missing.
    let mut second = self::form();
    second.take(FormInput::Pick { stop: 0, option: 0 }, 101.0);
    second.take(FormInput::PageOn, 102.0);
    second.take(FormInput::Pick { stop: 0, option: 0 }, 103.0);
    second.take(FormInput::PageOn, 103.0);
    assert_eq!((second.page().name.as_str(), second.focus(), missing(&second)), ("two", 1, [false, true]));
    // Back from the last page leads to the page before it, not to the first.
    form.take(FormInput::PageOn, 106.0);
    assert_eq!(form.page().name, "three");
    form.take(FormInput::PageBack, 107.0);
    assert_eq!((form.page().name.as_str(), form.progress()), ("two", (1, 3)));
}

#[test]
fn a_question_for_a_number_refuses_other_answers_and_may_stay_empty() {
    let text = r#"{ "title": "t", "pages": [{ "elements": [
        { "type": "text", "name": "age", "inputType": "number", "min": 16, "max": 110 },
        { "type": "text", "name": "more" }] }] }"#;
    let questionnaire = Questionnaire::parse(text, "t.json").unwrap();
    for (answer, goes_on) in [
        ("34", true),
        ("34 years", true),
        ("34.5", true),
        ("twenty", false),
        ("15", false),
        ("1200", false),
        ("", true),
    ] {
        let mut form = QuestionnaireForm::new(&questionnaire, 0.0);
        form.take(FormInput::Type { stop: 0, text: answer.into() }, 1.0);
        form.take(FormInput::Next, 2.0);
        assert_eq!((form.focus(), form.is_missing("age")), if goes_on { (1, false) } else { (0, true) }, "{answer}");
        form.take(FormInput::PageOn, 3.0);
        assert_eq!(form.is_over(), goes_on, "{answer}");
        // A better answer goes on.
        form.take(FormInput::Type { stop: 0, text: "40".into() }, 4.0);
        form.take(FormInput::PageOn, 5.0);
        assert!(form.is_over());
    }
    let message = Questionnaire::parse(&text.replace("110", "16"), "t.json").unwrap_err().0;
    assert!(message.contains("asks for a number from 16 to 16"), "{message}");
}
