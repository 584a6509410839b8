//! Last line of the participant's screens: the keys or buttons that act now, and their actions. In: a [`ScreenState`].
//! Out: paint.

use super::{
    ParticipantScreen, ScreenState,
    style::{self, PageStyle},
};
use crate::{
    controls::ControlSource,
    study::{NamedControl, QuestionnaireForm},
};
use egui::{Rect, Ui, pos2, vec2};
use std::sync::Arc;

/// A key or button and its action; a whole sentence has an empty key.
#[derive(Clone, Debug, PartialEq, Eq)]
struct KeyHint {
    key: String,
    action: String,
}

impl KeyHint {
    fn new(key: &str, action: &str) -> Self {
        Self { key: key.to_owned(), action: action.to_lowercase() }
    }
}

/// Returns the hints for this screen; only keys that do something.
fn hints(state: &ScreenState<'_>) -> Vec<KeyHint> {
    let texts = state.texts;
    let [choose, next, back, again] =
        [NamedControl::Choose, NamedControl::Answer, NamedControl::Back, NamedControl::Again]
            .map(|control| texts.control(control, state.source));
    let has_keys = state.source == ControlSource::Keyboard;
    let mut hints = match state.screen {
        ParticipantScreen::Questions(form) => {
            let is_at_button = form.focus() >= form.stops().len();
            let mut hints = Vec::new();
            if !is_at_button && !form.typing() {
                hints.push(KeyHint::new(choose, &texts.choose));
            }
            hints.push(KeyHint::new(next, if is_at_button { &texts.next } else { &texts.answer }));
            if goes_back(form, !has_keys) {
                hints.push(KeyHint::new(back, &texts.back));
            }
            hints
        }
        ParticipantScreen::Rest(_, left_s) if left_s > 0.0 => Vec::new(),
        ParticipantScreen::Page(_) | ParticipantScreen::Rest(..) if state.source == ControlSource::Wheel => {
            vec![KeyHint { key: String::new(), action: texts.go_on.replace("{button}", &texts.answer_button) }]
        }
        ParticipantScreen::Page(_) | ParticipantScreen::Rest(..) => vec![KeyHint::new(next, &texts.next)],
        _ => Vec::new(),
    };
    if state.spoken {
        hints.push(KeyHint::new(again, &texts.again));
    }
    hints
}

/// Checks whether Back goes anywhere from the focus. In a text with letters, Backspace deletes a letter instead; a
/// button still goes back.
fn goes_back(form: &QuestionnaireForm, by_button: bool) -> bool {
    let is_first = form.focus() == 0 && form.progress().0 == 0;
    !is_first && (by_button || !form.typing() || super::keys::has_no_answer(form))
}

/// Draws the line, centred at the bottom of the window.
pub fn show(ui: &Ui, page_style: &PageStyle, state: &ScreenState<'_>) {
    let whole = ui.max_rect();
    let y = whole.bottom() - 1.2 * page_style.em;
    // Laid out first, because the width is needed for centring.
    let font = page_style.font(0.7);
    let lay = |text: &str, colour| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), colour);
    let parts: Vec<_> = hints(state)
        .iter()
        .map(|hint| (lay(&hint.key, style::TEXT), lay(&hint.action, style::DIM), hint.key.is_empty()))
        .collect();
    let (cap, gap, between) = (0.35 * page_style.em, 0.4 * page_style.em, 1.4 * page_style.em);
    let wide = |(key, action, bare): &(Arc<egui::Galley>, Arc<egui::Galley>, bool)| {
        if *bare { action.size().x } else { key.size().x + 2.0 * cap + gap + action.size().x }
    };
    let sum: f32 = parts.iter().map(wide).sum::<f32>() + between * parts.len().saturating_sub(1) as f32;
    let mut x = whole.center().x - 0.5 * sum;
    for part in parts {
        let width = wide(&part);
        let (key, action, bare) = part;
        let mut text_x = x;
        if !bare {
            let size = key.size();
            let rect = Rect::from_min_size(pos2(x, y - 0.5 * size.y), size + vec2(2.0 * cap, 0.0));
            let cap_rect = rect.expand2(vec2(0.0, 0.12 * page_style.em));
            ui.painter().rect_filled(cap_rect, page_style.round(), style::CARD);
            ui.painter().rect_stroke(cap_rect, page_style.round(), page_style.edge(), egui::StrokeKind::Inside);
            ui.painter().galley(pos2(x + cap, y - 0.5 * size.y), key, style::TEXT);
            text_x = rect.right() + gap;
        }
        ui.painter().galley(pos2(text_x, y - 0.5 * action.size().y), action, style::DIM);
        x += width + between;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{FormInput, ParticipantTexts, Questionnaire};

    const QUESTIONS: &str = r#"{ "title": "T", "pages": [
      { "elements": [ { "type": "text", "name": "age", "title": "Age" },
                      { "type": "boolean", "name": "well", "title": "Well?", "isRequired": true } ] },
      { "elements": [ { "type": "text", "name": "more", "title": "More" } ] } ] }"#;

    /// Returns the wheel or the keyboard.
    fn device(wheel: bool) -> ControlSource {
        if wheel { ControlSource::Wheel } else { ControlSource::Keyboard }
    }

    fn hint_text(form: &QuestionnaireForm, wheel: bool) -> String {
        let texts = ParticipantTexts::default();
        let screen = ParticipantScreen::Questions(form);
        let state = ScreenState { screen, texts: &texts, progress: [0, 1], source: device(wheel), spoken: false };
        let hints = hints(&state);
        hints.iter().map(|hint| format!("{}: {}", hint.key, hint.action)).collect::<Vec<_>>().join("; ")
    }

    #[test]
    fn a_key_or_button_is_named_only_where_it_does_something() {
        let mut form = QuestionnaireForm::new(&Questionnaire::parse(QUESTIONS, "test.json").unwrap(), 0.0);
        let mut after = |inputs: &[FormInput]| {
            inputs.iter().for_each(|input| form.take(input.clone(), 1.0));
            [hint_text(&form, false), hint_text(&form, true)]
        };
        // Nothing comes before the first question; a text is typed, not chosen.
        assert_eq!(after(&[]), ["Enter: answer", "× (cross): answer"]);
        assert_eq!(
            after(&[FormInput::Next]),
            [
                "arrow keys: choose; Enter: answer; Backspace: back",
                "turn the wheel: choose; × (cross): answer; Δ (triangle): back"
            ]
        );
        assert_eq!(
            after(&[FormInput::Turn(1), FormInput::Next]),
            ["Enter: next; Backspace: back", "× (cross): next; Δ (triangle): back"]
        );
        assert_eq!(after(&[FormInput::Next])[0], "Enter: answer; Backspace: back", "an empty text of the second page");
        // Backspace now deletes a letter; the wheel's button still goes back.
        let typed = FormInput::Type { stop: 0, text: "a".into() };
        assert_eq!(after(&[typed]), ["Enter: answer", "× (cross): answer; Δ (triangle): back"]);
    }

    #[test]
    fn a_page_names_its_button_and_a_rest_none_before_its_end() {
        let texts = ParticipantTexts::default();
        let of = |screen, wheel| {
            hints(&ScreenState { screen, texts: &texts, progress: [0, 1], source: device(wheel), spoken: false })
        };
        assert_eq!(of(ParticipantScreen::Page("x"), false), [KeyHint::new("Enter", "next")]);
        let sentence = KeyHint { key: String::new(), action: "Press × (cross) on the wheel to continue.".into() };
        assert_eq!(of(ParticipantScreen::Page("x"), true), std::slice::from_ref(&sentence));
        assert_eq!(of(ParticipantScreen::Rest("x", 0.0), true), [sentence]);
        assert_eq!(of(ParticipantScreen::Rest("x", 3.0), false), []);
        assert_eq!(of(ParticipantScreen::Wait("x"), false), []);
    }
}
