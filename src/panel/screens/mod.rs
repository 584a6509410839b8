//! What a participant sees between drives, and over them: pages, rests, questions, the countdown. In: a [`ScreenState`];
//! keys and mouse as egui has them. Out: [`FormInput`]s, the same that a wheel makes. Nothing of the experimenter's is here.
//!
//! One column, large and calm: text is a 25th of the window's height, 2.7 cm on a television of 55 inches, four times what
//! is needed at 1 m. What acts stands in the last line.

mod page;
mod questionnaire;
mod rating;
mod style;

use crate::{
    study::{FmsPrompt, FormInput, ParticipantTexts, QuestionnaireForm},
    units::SpeedUnit,
};
use egui::{Key, Modifiers, Rect, Ui, UiBuilder, pos2, vec2};
use egui_commonmark::CommonMarkCache;
use style::PageStyle;

/// What there is to show.
#[derive(Clone, Copy, Debug)]
pub struct ScreenState<'a> {
    /// The screen.
    pub screen: ParticipantScreen<'a>,
    /// What the program says.
    pub texts: &'a ParticipantTexts,
    /// How many points of the session are behind, and how many there are.
    pub progress: [usize; 2],
    /// A wheel is there: hints name its buttons, not keys.
    pub wheel: bool,
    /// The page is spoken, and can be heard again.
    pub spoken: bool,
}

/// A screen.
#[derive(Clone, Copy, Debug)]
pub enum ParticipantScreen<'a> {
    /// A page to read, Markdown; the participant goes on.
    Page(&'a str),
    /// Words; the participant waits.
    Wait(&'a str),
    /// A rest: words, and the seconds that are left; at 0 the participant goes on.
    Rest(&'a str, f64),
    /// Questions.
    Questions(&'a QuestionnaireForm),
    /// The drive begins in so many seconds, and the car has this speed then (0 stands); over the picture.
    Countdown(u32, u32, SpeedUnit),
    /// The drive, alone or with words over the picture.
    Drive(Option<&'a str>),
    /// The drive, with the question of the sickness scale in a corner of the picture.
    Rating(FmsPrompt),
}

impl ParticipantScreen<'_> {
    /// True if the picture of the drive is behind it.
    pub fn is_over_picture(&self) -> bool {
        matches!(self, Self::Countdown(..) | Self::Drive(_) | Self::Rating(_))
    }
}

/// Draws screens.
#[derive(Default)]
pub struct ScreenPainter {
    /// Pages that were laid out.
    cache: CommonMarkCache,
}

impl ScreenPainter {
    /// Shows a screen in the root [`Ui`] of a pass, and tells what keys and mouse did.
    pub fn show(&mut self, ui: &mut Ui, state: &ScreenState<'_>) -> Vec<FormInput> {
        let mut inputs = keys(ui, &state.screen);
        let whole = ui.max_rect();
        let look = PageStyle::of(whole.size());
        match state.screen {
            ParticipantScreen::Drive(None) => return inputs,
            ParticipantScreen::Drive(Some(words)) => {
                page::words_over(ui, &look, words);
                return inputs;
            }
            ParticipantScreen::Rating(prompt) => {
                rating::prompt(ui, &look, state.texts, prompt, state.wheel);
                return inputs;
            }
            ParticipantScreen::Countdown(left, speed, unit) => {
                let rolling = state.texts.rolling.replace("{speed}", &format!("{speed} {}", unit.label()));
                page::countdown(ui, &look, if speed > 0 { &rolling } else { &state.texts.ready }, left);
                return inputs;
            }
            _ => {}
        }
        ui.painter().rect_filled(whole, 0, style::BACK);
        look.apply_style(ui);
        dots(ui, &look, state.progress);
        hint(ui, &look, state);
        let width = (30.0 * look.em).min(0.9 * whole.width());
        let column = Rect::from_min_max(
            pos2(whole.center().x - 0.5 * width, whole.top() + 2.2 * look.em),
            pos2(whole.center().x + 0.5 * width, whole.bottom() - 2.6 * look.em),
        );
        ui.scope_builder(UiBuilder::new().max_rect(column), |ui| {
            ui.set_clip_rect(Rect::from_x_y_ranges(whole.x_range(), column.y_range()));
            match state.screen {
                ParticipantScreen::Page(text) => {
                    inputs.extend(page::page(ui, &look, &mut self.cache, text, Some(&state.texts.next)));
                }
                ParticipantScreen::Wait(text) => drop(page::page(ui, &look, &mut self.cache, text, None)),
                ParticipantScreen::Rest(text, left_s) => {
                    inputs.extend(page::rest(ui, &look, &mut self.cache, text, left_s, state.texts));
                }
                ParticipantScreen::Questions(form) => inputs.extend(questionnaire::show(ui, &look, form, state.texts)),
                ParticipantScreen::Countdown(..) | ParticipantScreen::Drive(_) | ParticipantScreen::Rating(_) => {}
            }
        });
        if let ParticipantScreen::Questions(form) = state.screen {
            inputs.extend(questionnaire::buttons(ui, &look, form, state.texts));
        }
        inputs
    }
}

/// Keys of the screens, and what they do.
pub const SCREEN_KEYS: [(&str, &str); 8] = [
    ("Enter, Space", "next"),
    ("Arrow keys", "choose an answer"),
    ("Tab", "next question"),
    ("Backspace", "back"),
    ("Page Up, Page Down, Enter", "while driving: more, less, answer"),
    ("R", "hear a spoken page again"),
    ("M", "mark this moment"),
    ("Esc", "ask to stop"),
];

/// What the keys ask for. Letters and arrows belong to a text while one is typed.
fn keys(ui: &Ui, screen: &ParticipantScreen<'_>) -> Vec<FormInput> {
    let form = if let ParticipantScreen::Questions(form) = screen { Some(*form) } else { None };
    let typing = form.is_some_and(QuestionnaireForm::typing);
    let text_is_empty = form.is_some_and(|form| {
        let stops = form.stops();
        stops.get(form.focus()).is_some_and(|stop| form.answer(&stop.name()).is_none())
    });
    let focus = form.map_or(0, QuestionnaireForm::focus);
    // The arrows drive while the picture of a drive is seen.
    let drives = matches!(screen, ParticipantScreen::Drive(_) | ParticipantScreen::Rating(_));
    ui.input_mut(|input| {
        let mut inputs = Vec::new();
        let mut on = |key: Key, made: &dyn Fn() -> FormInput| {
            inputs.extend((0..input.count_and_consume_key(Modifiers::NONE, key)).map(|_| made()));
        };
        if drives {
            for key in [Key::PageUp, Key::Plus] {
                on(key, &|| FormInput::Turn(1));
            }
            for key in [Key::PageDown, Key::Minus] {
                on(key, &|| FormInput::Turn(-1));
            }
            on(Key::M, &|| FormInput::Mark);
        } else if !typing {
            on(Key::ArrowLeft, &|| FormInput::Turn(-1));
            on(Key::ArrowUp, &|| FormInput::Turn(-1));
            on(Key::ArrowRight, &|| FormInput::Turn(1));
            on(Key::ArrowDown, &|| FormInput::Turn(1));
            on(Key::R, &|| FormInput::Again);
            on(Key::Space, &|| FormInput::Next);
            on(Key::M, &|| FormInput::Mark);
        }
        if !typing || text_is_empty {
            on(Key::Backspace, &|| FormInput::Back);
        }
        on(Key::Enter, &|| FormInput::Next);
        on(Key::Escape, &|| FormInput::Stop);
        on(Key::PageDown, &|| FormInput::PageOn);
        on(Key::PageUp, &|| FormInput::PageBack);
        if form.is_some() {
            on(Key::Tab, &|| FormInput::Focus(focus + 1));
            if input.consume_key(Modifiers::SHIFT, Key::Tab) {
                inputs.push(FormInput::Focus(focus.saturating_sub(1)));
            }
        }
        inputs
    })
}

/// One dot a point of the session: behind, here, ahead.
fn dots(ui: &Ui, look: &PageStyle, [behind, all]: [usize; 2]) {
    let whole = ui.max_rect();
    let apart = (0.9 * look.em).min(0.8 * whole.width() / all.max(1) as f32);
    let left = whole.center().x - 0.5 * apart * (all.max(1) - 1) as f32;
    for i in 0..all {
        let at = pos2(left + apart * i as f32, whole.top() + 1.1 * look.em);
        let (radius, colour) = match i.cmp(&behind) {
            std::cmp::Ordering::Less => (0.16, style::DIM),
            std::cmp::Ordering::Equal => (0.26, style::CHOSEN),
            std::cmp::Ordering::Greater => (0.16, style::CARD),
        };
        ui.painter().circle_filled(at, radius * look.em, colour);
    }
}

/// The last line: which keys and buttons act, and how.
fn hint(ui: &Ui, look: &PageStyle, state: &ScreenState<'_>) {
    let texts = state.texts;
    let whole = ui.max_rect();
    let y = whole.bottom() - 1.2 * look.em;
    let [turn, next, back] = if state.wheel {
        [texts.wheel.as_str(), texts.answer_button.as_str(), texts.back_button.as_str()]
    } else {
        [texts.arrows.as_str(), "Enter", "Backspace"]
    };
    let mut acts: Vec<(&str, &str)> = match state.screen {
        ParticipantScreen::Questions(form) if form.typing() => vec![("Enter", &texts.answer)],
        ParticipantScreen::Questions(_) => vec![(turn, &texts.choose), (next, &texts.answer), (back, &texts.back)],
        ParticipantScreen::Page(_) if state.wheel => vec![("", &texts.go_on)],
        ParticipantScreen::Rest(_, left_s) if left_s <= 0.0 && state.wheel => vec![("", &texts.go_on)],
        ParticipantScreen::Page(_) => vec![(next, &texts.next)],
        ParticipantScreen::Rest(_, left_s) if left_s <= 0.0 => vec![(next, &texts.next)],
        _ => Vec::new(),
    };
    if state.spoken {
        acts.push((if state.wheel { back } else { "R" }, &texts.again));
    }
    // Laid out first, so that the line stands in the middle.
    let font = look.font(0.7);
    let lay = |text: &str, colour| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), colour);
    let parts: Vec<_> = acts
        .iter()
        .map(|(key, what)| (lay(key, style::TEXT), lay(&small(key, what), style::DIM), key.is_empty()))
        .collect();
    let (cap, gap, between) = (0.35 * look.em, 0.4 * look.em, 1.4 * look.em);
    let wide = |(key, what, bare): &(std::sync::Arc<egui::Galley>, std::sync::Arc<egui::Galley>, bool)| {
        if *bare { what.size().x } else { key.size().x + 2.0 * cap + gap + what.size().x }
    };
    let sum: f32 = parts.iter().map(wide).sum::<f32>() + between * parts.len().saturating_sub(1) as f32;
    let mut x = whole.center().x - 0.5 * sum;
    for part in parts {
        let width = wide(&part);
        let (key, what, bare) = part;
        let mut text_x = x;
        if !bare {
            let size = key.size();
            let rect = Rect::from_min_size(pos2(x, y - 0.5 * size.y), size + vec2(2.0 * cap, 0.0));
            ui.painter().rect_filled(rect.expand2(vec2(0.0, 0.12 * look.em)), look.round(), style::CARD);
            ui.painter().galley(pos2(x + cap, y - 0.5 * size.y), key, style::TEXT);
            text_x = rect.right() + gap;
        }
        ui.painter().galley(pos2(text_x, y - 0.5 * what.size().y), what, style::DIM);
        x += width + between;
    }
}

/// What a key does, in small letters as a hint; a sentence stays as it is.
fn small(key: &str, what: &str) -> String {
    if key.is_empty() { what.to_owned() } else { what.to_lowercase() }
}
