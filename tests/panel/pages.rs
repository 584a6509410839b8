//! Pages as a participant uses them: the order of keys, visible content, and letters that grow with the picture, from a laptop to a
//! television of 3840 x 2160.

use crate::screens::{Desk, harness, keys, save};
use codrive::{
    panel::{SCREEN_KEYS, key_list, room_sign},
    study::{FormInput, ParticipantTexts, questionnaire_form::FormPosition, questions::ElementKind},
};
use egui::{Event, Key, Modifiers, Rect};
use egui_kittest::kittest::Queryable;
use serde_json::json;

const SIZES: [[f32; 2]; 4] = [[640.0, 360.0], [1280.0, 720.0], [1920.0, 1080.0], [3840.0, 2160.0]];

const YES_NO: &str = r#"{ "title": "Two", "pages": [ { "elements": [
  { "type": "boolean", "name": "first", "title": "One?", "isRequired": true },
  { "type": "boolean", "name": "second", "title": "Two?", "isRequired": true },
  { "type": "comment", "name": "more", "title": "More?" } ] } ] }"#;

/// Questions of each kind that a page about a person has: text, choice, one that an answer brings to sight, required choice.
const ABOUT_YOU: &str = include_str!("../data/questionnaires/about-you.json");

fn event(key: Key, pressed: bool) -> Event {
    Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE }
}

/// A slow picture must not reorder responses: several keys of one pass act one after the other.
#[test]
fn keys_of_one_picture_act_in_the_order_of_pressing() {
    use Key::{ArrowRight, Enter};
    let mut harness = harness(Desk::questions(YES_NO), [900.0, 600.0], 1.0);
    let pressed = [ArrowRight, Enter, ArrowRight, ArrowRight, Enter];
    harness.input_mut().events.extend(pressed.into_iter().flat_map(|key| [event(key, true), event(key, false)]));
    harness.run();
    let form = harness.state().form();
    assert_eq!((form.answer("first"), form.answer("second")), (Some(&json!(true)), Some(&json!(false))));
}

/// Text and the keys after it arrive in one slow picture: the text is kept, and the keys act on the next question.
#[test]
fn keys_after_text_in_one_picture_act_on_the_next_question() {
    use Key::{ArrowRight, Enter};
    let mut harness = harness(Desk::questions(ABOUT_YOU), [900.0, 600.0], 1.0);
    let strokes = |key: Key| [event(key, true), event(key, false)];
    let words = ["3", "4"].map(|digit| Event::Text(digit.into()));
    let after = [Enter, ArrowRight, ArrowRight, Enter].into_iter().flat_map(strokes);
    harness.input_mut().events.extend(words.into_iter().chain(after));
    harness.run();
    let form = harness.state().form();
    assert_eq!((form.answer("age"), form.answer("gender")), (Some(&json!("34")), Some(&json!("man"))));
}

#[test]
fn a_key_that_is_held_down_answers_once() {
    let mut harness = harness(Desk { page: Some("# Welcome"), ..Desk::new() }, [900.0, 600.0], 1.0);
    for _ in 0..5 {
        // A key that is not released between two presses repeats.
        harness.event(event(Key::Enter, true));
        harness.run();
    }
    assert_eq!(harness.state().inputs, [FormInput::Next]);
    harness.event(event(Key::Enter, false));
    harness.event(event(Key::Enter, true));
    harness.run();
    assert_eq!(harness.state().inputs, [FormInput::Next, FormInput::Next]);
}

#[test]
fn shift_and_enter_begin_a_new_line_of_a_text() {
    let mut harness = harness(Desk::questions(YES_NO), [900.0, 600.0], 1.0);
    keys(&mut harness, &[Key::Tab, Key::Tab]);
    harness.event(Event::Text("one".into()));
    harness.run();
    harness.key_press_modifiers(Modifiers::SHIFT, Key::Enter);
    harness.run();
    harness.event(Event::Text("two".into()));
    harness.run();
    assert_eq!(harness.state().form().answer("more"), Some(&json!("one\ntwo")));
}

/// The focused question is visible as a whole, with the message that a response is missing.
#[test]
fn the_focused_question_is_visible_with_all_its_options() {
    use Key::{ArrowDown, ArrowRight, Enter};
    for size in SIZES {
        let em = size[1] / 25.0;
        let in_sight = Rect::from_min_max([0.0, 2.0 * em].into(), [size[0], size[1] - 2.5 * em].into());
        let mut harness = harness(Desk::questions(ABOUT_YOU), size, 1.0);
        let sees = |harness: &mut egui_kittest::Harness<'static, Desk>, labels: &[&str]| {
            harness.run_steps(40);
            for label in labels {
                let rect = harness.get_by_label(label).rect();
                assert!(in_sight.contains_rect(rect), "{label} at {rect:?} of {size:?}");
            }
        };
        sees(&mut harness, &["How old are you?"]);
        keys(&mut harness, &[Enter]);
        sees(&mut harness, &["What is your gender?", "Woman", "In my own words", "I would rather not say"]);
        keys(&mut harness, &[ArrowDown, ArrowDown, Enter, Enter]);
        sees(&mut harness, &["On how many days did you drive in the last week? *", "None", "4 to 7"]);
        keys(&mut harness, &[Enter]);
        sees(&mut harness, &["4 to 7", "Please answer this question."]);
        keys(&mut harness, &[ArrowRight, Enter, Enter]);
        assert!(harness.state().form().is_over());
    }
}

/// On a television of 3840 x 2160 all letters have the same share of the height as at 1920 x 1080.
#[test]
fn letters_have_the_same_share_of_the_height_at_1080_and_2160_lines() {
    let shares = |size: [f32; 2]| {
        let share = |desk: Desk, label: &str| harness(desk, size, 1.0).get_by_label(label).rect().height() / size[1];
        let mut over = crate::harness((), size, 1.0, |ui, ()| {
            key_list(ui.ctx(), &SCREEN_KEYS);
            room_sign(ui, Some("the room is recorded"));
        });
        over.run();
        save(&mut over, &format!("keys-{}", size[1]));
        [
            share(Desk { page: Some("A page."), ..Desk::new() }, "A page."),
            share(Desk { rest_s: Some(75.0), ..Desk::new() }, "1:15"),
            share(
                Desk { countdown: Some(3), ..Desk::new() },
                "The drive begins soon. Hands on the arrow keys, ready to press the Down arrow key (brake). 3",
            ),
            share(Desk::shipped("trust"), "I could rely on the advice. *"),
            over.get_by_label("ask to stop").rect().height() / size[1],
            over.get_by_label("the room is recorded").rect().height() / size[1],
        ]
    };
    let [hd, uhd] = [shares([1920.0, 1080.0]), shares([3840.0, 2160.0])];
    for (i, (hd, uhd)) in hd.into_iter().zip(uhd).enumerate() {
        assert!((uhd / hd - 1.0).abs() < 0.03, "{i}: {hd} and {uhd} of the height");
        // 13 mm on a television of 55 inches (685 mm high): 30 minutes of arc at 1.5 m; letters have half that height.
        assert!(hd > 0.019, "{i}: {hd} of the height");
    }
}

/// Returns the accessible name of the last option at a stop.
fn last_option(stop: &FormPosition<'_>) -> String {
    let element = stop.element;
    match element.kind {
        ElementKind::Boolean => format!("{}: No", element.title),
        ElementKind::Rating => format!("{}: {}", element.title, stop.options().last().unwrap()),
        ElementKind::Matrix => format!("{}: {}", stop.row.unwrap().text, element.columns.last().unwrap().text),
        ElementKind::Radiogroup | ElementKind::Checkbox => element.choices.last().unwrap().text.clone(),
        ElementKind::Text | ElementKind::Comment | ElementKind::Html => element.title.clone(),
    }
}

/// The reader sees how much a page asks: each page of the shipped questionnaires is visible as a whole when it opens, from its first
/// question to the last option.
#[test]
fn every_page_of_the_shipped_questionnaires_is_visible_as_a_whole() {
    let mut cut = Vec::new();
    for name in [
        "consent",
        "screening",
        "sample",
        "ssq",
        "trust",
        "raw-tlx",
        "nasa-tlx",
        "acceptance",
        "van-der-laan",
        "driving-experience",
    ] {
        let mut harness = harness(Desk::shipped(name), [1280.0, 720.0], 1.0);
        while !harness.state().form().is_over() {
            harness.run_steps(30);
            let form = harness.state().form();
            let (page, stops) = (form.progress().0, form.stops());
            let last = last_option(stops.last().unwrap());
            let bottom = harness.get_all_by_label(&last).map(|node| node.rect().bottom()).fold(0.0, f32::max);
            // The words of its ends are below a scale.
            let is_scale = stops.last().unwrap().element.kind == ElementKind::Rating;
            let bottom = bottom + if is_scale { 0.95 / 25.0 * 720.0 } else { 0.0 };
            // The last line begins there.
            if bottom > 720.0 - 2.6 / 25.0 * 720.0 {
                cut.push(format!("{name}, page {}: {last} ends at {:.2} of the height", page + 1, bottom / 720.0));
            }
            let inputs: Vec<FormInput> = (0..stops.len()).map(|stop| FormInput::Pick { stop, option: 0 }).collect();
            let form = harness.state_mut().form.as_mut().unwrap();
            inputs.into_iter().chain([FormInput::PageOn]).for_each(|input| form.take(input, 1.0));
        }
    }
    assert!(cut.is_empty(), "{cut:#?}");
}

#[test]
fn the_programs_font_has_every_letter_of_the_programs_own_words() {
    let texts = serde_json::to_value(ParticipantTexts::default()).unwrap();
    let words: Vec<String> =
        texts.as_object().unwrap().values().map(|text| text.as_str().unwrap().to_owned()).collect();
    let harness = crate::harness((), [640.0, 360.0], 1.0, |_, ()| ());
    for text in words {
        let has =
            |letter: char| harness.ctx.fonts_mut(|fonts| fonts.has_glyph(&egui::FontId::proportional(20.0), letter));
        let missing: String = text.chars().filter(|letter| !has(*letter)).collect();
        assert!(missing.is_empty(), "{text:?} has {missing:?}, which the font has not");
    }
}
