//! The question of the motion sickness scale while driving: a small box in a corner of the picture. In: the current
//! number and the time left. Out: paint. Keys and wheel change the number elsewhere.

use super::style::{self, PageStyle};
use crate::{
    controls::ControlSource,
    study::{FmsPrompt, NamedControl, ParticipantTexts, fms},
};
use egui::{Align2, Color32, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};

/// Draws the question in the lower right corner, over the bonnet: clear of the road ahead, the mirror at the top and
/// the dial in the lower middle.
pub fn prompt(ui: &Ui, page_style: &PageStyle, texts: &ParticipantTexts, prompt: FmsPrompt, source: ControlSource) {
    let whole = ui.max_rect();
    let painter = ui.painter();
    let lay = |text: &str, size: f32, colour: Color32| {
        painter.layout(text.to_owned(), page_style.font(size), colour, 9.0 * page_style.em)
    };
    let question = lay(&texts.fms, 0.8, style::TEXT);
    let number = lay(&prompt.value.to_string(), 2.2, Color32::WHITE);
    let ends = lay(&format!("{}, {}", texts.fms_low, texts.fms_high), 0.6, style::DIM);
    let [change, answer] = [NamedControl::Rate, NamedControl::Answer].map(|control| texts.control(control, source));
    // The names of buttons are longer than a line.
    let between = if source == ControlSource::Keyboard { "   " } else { "\n" };
    let hand = lay(&format!("{change}: {}{between}{answer}: {}", texts.choose, texts.answer), 0.6, style::DIM);
    let parts = [&question, &number, &ends, &hand];
    let bar = 0.35 * page_style.em;
    let width = parts.iter().map(|part| part.size().x).fold(8.0 * page_style.em, f32::max);
    let height = parts.iter().map(|part| part.size().y).sum::<f32>() + 2.0 * bar;
    let edge = 0.7 * page_style.em;
    let rect =
        Align2::RIGHT_BOTTOM.anchor_size(whole.right_bottom() - vec2(1.5 * edge, 1.5 * edge), vec2(width, height));
    painter.rect_filled(rect.expand(edge), page_style.round(), Color32::from_black_alpha(185));
    let mut y = rect.top();
    for part in parts {
        painter.galley(pos2(rect.center().x - 0.5 * part.size().x, y), part.clone(), style::TEXT);
        y += part.size().y;
    }
    // Bar of the time left.
    let left = (prompt.left_s / fms::ANSWER_S) as f32;
    let line = Rect::from_min_size(pos2(rect.left(), rect.bottom() - 0.5 * bar), vec2(rect.width() * left, 0.4 * bar));
    painter.rect_filled(line, 0, style::CURSOR);
    // The label makes the painted text accessible to screen readers.
    let spoken = ui.interact(rect, egui::Id::unique("rating"), Sense::hover());
    spoken.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{} {}", texts.fms, prompt.value)));
}
