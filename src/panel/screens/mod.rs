//! The participant's screens, between drives and over them: pages, rests, questions, the countdown. In: a
//! [`ScreenState`]; keys and mouse from egui. Out: [`FormInput`]s, as a wheel gives them. Nothing here is for the
//! experimenter.
//!
//! One column of large text: a letter is 1/25 of the window's height, 2.7 cm on a 55-inch television, four times the
//! size needed at 1 m. The last line names the keys or buttons that act.

mod hint;
mod keys;
mod page;
mod questionnaire;
mod rating;
mod style;

pub use keys::SCREEN_KEYS;

use crate::{
    controls::ControlSource,
    study::{FmsPrompt, FormInput, ParticipantTexts, QuestionnaireForm},
    units::SpeedUnit,
};
use egui::{Rect, Ui, UiBuilder, pos2};
use egui_commonmark::CommonMarkCache;
use style::PageStyle;

/// Content of a screen in one pass.
#[derive(Clone, Copy, Debug)]
pub struct ScreenState<'a> {
    /// Screen to be shown.
    pub screen: ParticipantScreen<'a>,
    /// Texts of the program, in the participant's language.
    pub texts: &'a ParticipantTexts,
    /// Number of finished items of the session, and of all items.
    pub progress: [usize; 2],
    /// Device in use: texts and hints name its keys, pedals or buttons.
    pub source: ControlSource,
    /// True if the page is spoken and can be heard again.
    pub spoken: bool,
}

/// One screen of a participant.
#[derive(Clone, Copy, Debug)]
pub enum ParticipantScreen<'a> {
    /// A page in Markdown; the participant continues.
    Page(&'a str),
    /// A text; the participant waits.
    Wait(&'a str),
    /// A rest: a text, and the seconds left; at 0 the participant continues.
    Rest(&'a str, f64),
    /// A page of questions.
    Questions(&'a QuestionnaireForm),
    /// Countdown over the picture: seconds to the start, and the starting speed in the given unit (0: standing start).
    Countdown(u32, u32, SpeedUnit),
    /// The drive, alone or with a text over the picture.
    Drive(Option<&'a str>),
    /// The drive, with the question of the motion sickness scale in a corner.
    Rating(FmsPrompt),
}

impl ParticipantScreen<'_> {
    /// Returns true if the drive's picture is behind the screen.
    pub fn is_over_picture(&self) -> bool {
        matches!(self, Self::Countdown(..) | Self::Drive(_) | Self::Rating(_))
    }
}

/// Draws a participant's screens.
#[derive(Default)]
pub struct ScreenPainter {
    /// Cache of Markdown pages with their layout.
    cache: CommonMarkCache,
}

impl ScreenPainter {
    /// Shows a screen in the root [`Ui`] of a pass, and returns the inputs of keys and mouse.
    pub fn show(&mut self, ui: &mut Ui, state: &ScreenState<'_>) -> Vec<FormInput> {
        let mut inputs = keys::inputs(ui, &state.screen);
        let whole = ui.max_rect();
        let page_style = PageStyle::of(whole.size());
        let named = |text| state.texts.with_controls(text, state.source);
        match state.screen {
            ParticipantScreen::Drive(None) => return inputs,
            ParticipantScreen::Drive(Some(words)) => {
                page::text_over(ui, &page_style, &named(words));
                return inputs;
            }
            ParticipantScreen::Rating(prompt) => {
                rating::prompt(ui, &page_style, state.texts, prompt, state.source);
                return inputs;
            }
            ParticipantScreen::Countdown(left, speed, unit) => {
                let rolling = state.texts.rolling.replace("{speed}", &format!("{speed} {}", unit.label()));
                page::countdown(ui, &page_style, &named(if speed > 0 { &rolling } else { &state.texts.ready }), left);
                return inputs;
            }
            _ => {}
        }
        ui.painter().rect_filled(whole, 0, style::BACK);
        page_style.apply_style(ui);
        dots(ui, &page_style, state.progress);
        hint::show(ui, &page_style, state);
        let width = (30.0 * page_style.em).min(0.9 * whole.width());
        let column = Rect::from_min_max(
            pos2(whole.center().x - 0.5 * width, whole.top() + 2.2 * page_style.em),
            pos2(whole.center().x + 0.5 * width, whole.bottom() - 2.6 * page_style.em),
        );
        ui.scope_builder(UiBuilder::new().max_rect(column), |ui| {
            ui.set_clip_rect(Rect::from_x_y_ranges(whole.x_range(), column.y_range()));
            match state.screen {
                ParticipantScreen::Page(text) => {
                    inputs.extend(page::page(ui, &page_style, &mut self.cache, &named(text), Some(&state.texts.next)));
                }
                ParticipantScreen::Wait(text) => drop(page::page(ui, &page_style, &mut self.cache, &named(text), None)),
                ParticipantScreen::Rest(text, left_s) => {
                    inputs.extend(page::rest(ui, &page_style, &mut self.cache, &named(text), left_s, state.texts));
                }
                ParticipantScreen::Questions(form) => {
                    inputs.extend(questionnaire::show(ui, &page_style, form, state.texts))
                }
                ParticipantScreen::Countdown(..) | ParticipantScreen::Drive(_) | ParticipantScreen::Rating(_) => {}
            }
        });
        if let ParticipantScreen::Questions(form) = state.screen {
            inputs.extend(questionnaire::buttons(ui, &page_style, form, state.texts));
        }
        inputs
    }
}

/// Draws one dot for each item of the session: finished, current, still to come.
fn dots(ui: &Ui, page_style: &PageStyle, [behind, all]: [usize; 2]) {
    let whole = ui.max_rect();
    let apart = (0.9 * page_style.em).min(0.8 * whole.width() / all.max(1) as f32);
    let left = whole.center().x - 0.5 * apart * (all.max(1) - 1) as f32;
    for i in 0..all {
        let at = pos2(left + apart * i as f32, whole.top() + 1.1 * page_style.em);
        let (radius, colour) = match i.cmp(&behind) {
            std::cmp::Ordering::Less => (0.16, style::DIM),
            std::cmp::Ordering::Equal => (0.26, style::CHOSEN),
            std::cmp::Ordering::Greater => (0.16, style::EDGE),
        };
        ui.painter().circle_filled(at, radius * page_style.em, colour);
    }
}
