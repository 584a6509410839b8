//! Keys of the participant's screens. In: the keys of a pass, in the order in which they were pressed. Out:
//! [`FormInput`]s in that order. Keys that a text field needs are left to it. Keys pressed after text, or after a key
//! that may leave the text field, wait for the next pass: by then the form has the text and the new focus.

use super::ParticipantScreen;
use crate::study::{FormInput, QuestionnaireForm};
use egui::{Event, Id, Key, Modifiers, Ui};

/// Keys of the screens, and their actions.
pub const SCREEN_KEYS: [(&str, &str); 8] = [
    ("Enter, Space", "next"),
    ("Arrow keys", "choose an answer"),
    ("Tab", "next question"),
    ("Backspace", "back"),
    ("Page Up, Page Down, Enter", "while driving: higher, lower, answer"),
    ("R", "play a spoken page again"),
    ("M", "mark this moment"),
    ("Esc", "ask to stop"),
];

/// State on which the meaning of a key depends.
struct KeyContext {
    /// True during a drive: the arrow keys drive.
    drives: bool,
    /// True in a text field: letters and arrow keys belong to it.
    types: bool,
    /// True while the focused stop has no answer.
    is_empty: bool,
    /// Index of the focused stop; `None` without questions.
    focus: Option<usize>,
}

impl KeyContext {
    fn of(screen: &ParticipantScreen<'_>) -> Self {
        let form = if let ParticipantScreen::Questions(form) = screen { Some(*form) } else { None };
        Self {
            drives: matches!(screen, ParticipantScreen::Drive(_) | ParticipantScreen::Rating(_)),
            types: form.is_some_and(QuestionnaireForm::typing),
            is_empty: form.is_some_and(has_no_answer),
            focus: form.map(QuestionnaireForm::focus),
        }
    }

    fn meaning(&self, key: Key, modifiers: Modifiers) -> Option<FormInput> {
        let on_page = !self.drives && !self.types;
        Some(match key {
            Key::PageUp | Key::Plus if self.drives => FormInput::Turn(1),
            Key::PageDown | Key::Minus if self.drives => FormInput::Turn(-1),
            Key::ArrowLeft | Key::ArrowUp if on_page => FormInput::Turn(-1),
            Key::ArrowRight | Key::ArrowDown if on_page => FormInput::Turn(1),
            Key::R if on_page => FormInput::Again,
            Key::Space if on_page => FormInput::Next,
            Key::M if !self.types => FormInput::Mark,
            Key::Backspace if !self.types || self.is_empty => FormInput::Back,
            // Shift+Enter is a line break in a text.
            Key::Enter if !(self.types && modifiers.shift) => FormInput::Next,
            Key::Escape => FormInput::Stop,
            Key::PageDown => FormInput::PageOn,
            Key::PageUp => FormInput::PageBack,
            Key::Tab => {
                let focus = self.focus?;
                FormInput::Focus(if modifiers.shift { focus.saturating_sub(1) } else { focus + 1 })
            }
            _ => return None,
        })
    }
}

/// Checks whether the focused stop has no answer.
pub fn has_no_answer(form: &QuestionnaireForm) -> bool {
    form.stops().get(form.focus()).is_some_and(|stop| form.answer(&stop.name()).is_none())
}

/// Returns the inputs for the keys of this pass. A key held down repeats a choice ([`FormInput::Turn`]), but nothing
/// else.
pub fn inputs(ui: &Ui, screen: &ParticipantScreen<'_>) -> Vec<FormInput> {
    let context = KeyContext::of(screen);
    let waiting = Id::unique("keys for the next pass");
    let mut events: Vec<Event> = ui.data_mut(|data| data.remove_temp(waiting)).unwrap_or_default();
    let mut inputs = Vec::new();
    let mut later = Vec::new();
    ui.input_mut(|input| {
        events.append(&mut input.events);
        let (mut has_words, mut has_left) = (false, false);
        for event in events {
            if !matches!(event, Event::Key { .. } | Event::Text(_) | Event::Paste(_) | Event::Cut | Event::Ime(_)) {
                input.events.push(event);
                continue;
            }
            if has_left {
                later.push(event);
                continue;
            }
            let asked = match &event {
                Event::Key { key, pressed: true, modifiers, .. } if !modifiers.command => {
                    context.meaning(*key, *modifiers)
                }
                _ => None,
            };
            match (asked, &event) {
                (Some(_), _) if has_words => {
                    has_left = true;
                    later.push(event);
                }
                (Some(asked), Event::Key { repeat, .. }) => {
                    has_left = context.types;
                    inputs.extend((!repeat || matches!(asked, FormInput::Turn(_))).then_some(asked));
                }
                _ => {
                    has_words |= context.types && !matches!(event, Event::Key { pressed: false, .. });
                    input.events.push(event);
                }
            }
        }
    });
    if !later.is_empty() {
        ui.data_mut(|data| data.insert_temp(waiting, later));
        ui.ctx().request_repaint();
    }
    inputs
}
