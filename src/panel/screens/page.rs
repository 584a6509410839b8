//! Pages to read, rests, and text over the picture of a drive.

use super::style::{self, PageStyle};
use crate::study::{FormInput, ParticipantTexts};
use egui::{Align2, Color32, Id, Rect, Response, RichText, Role, ScrollArea, Sense, Ui, WidgetInfo, pos2, vec2};
use egui_commonmark::{CommonMarkCache, CommonMarkViewer};

/// Shows a Markdown page, vertically centred if it fits; with a button if the participant can continue. Returns
/// [`FormInput::Next`] on a click.
pub fn page(
    ui: &mut Ui,
    page_style: &PageStyle,
    cache: &mut CommonMarkCache,
    text: &str,
    button: Option<&str>,
) -> Option<FormInput> {
    let mut pressed = false;
    centred(ui, Id::unique("page"), |ui| {
        show_text(ui, page_style, cache, text);
        if let Some(word) = button {
            ui.add_space(0.8 * page_style.em);
            in_the_middle(ui, is_short(text), |ui| pressed = self::button(ui, page_style, word, true).clicked());
        }
    });
    pressed.then_some(FormInput::Next)
}

/// Shows a rest: a text, and the minutes and seconds left or, at the end, a button.
pub fn rest(
    ui: &mut Ui,
    page_style: &PageStyle,
    cache: &mut CommonMarkCache,
    text: &str,
    left_s: f64,
    texts: &ParticipantTexts,
) -> Option<FormInput> {
    let over = left_s <= 0.0;
    let mut pressed = false;
    centred(ui, Id::unique("rest"), |ui| {
        let text = if over { &texts.rest_over } else { text };
        show_text(ui, page_style, cache, text);
        ui.add_space(0.6 * page_style.em);
        in_the_middle(ui, is_short(text), |ui| {
            if over {
                pressed = button(ui, page_style, &texts.next, true).clicked();
            } else {
                let left = left_s.ceil() as u64;
                let time = RichText::new(format!("{}:{:02}", left / 60, left % 60));
                ui.label(time.font(page_style.font(4.0)).color(style::DIM));
            }
        });
    });
    pressed.then_some(FormInput::Next)
}

/// Returns true for a single sentence without markup.
fn is_short(text: &str) -> bool {
    text.chars().count() <= 90 && !text.trim().contains(['\n', '#', '*', '_', '[', '`', '>', '|'])
}

/// Shows Markdown aligned left; a single sentence is centred and larger.
fn show_text(ui: &mut Ui, page_style: &PageStyle, cache: &mut CommonMarkCache, text: &str) {
    if is_short(text) {
        in_the_middle(ui, true, |ui| drop(ui.label(RichText::new(text.trim()).font(page_style.font(1.35)))));
    } else {
        CommonMarkViewer::new().show(ui, cache, text);
    }
}

fn in_the_middle(ui: &mut Ui, is: bool, add: impl FnOnce(&mut Ui)) {
    if is { drop(ui.vertical_centered(add)) } else { add(ui) }
}

/// Centres the content vertically if it fits; otherwise it starts at the top and scrolls.
fn centred(ui: &mut Ui, id: Id, add: impl FnOnce(&mut Ui)) {
    let room = ui.available_height();
    let before: f32 = ui.data(|data| data.get_temp(id)).unwrap_or(0.0);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.add_space((0.5 * (room - before)).max(0.0));
        let height = ui.scope(add).response.rect.height();
        if (height - before).abs() > 0.5 {
            ui.data_mut(|data| data.insert_temp(id, height));
            ui.ctx().request_repaint();
        }
    });
}

/// Shows a large button at the cursor; `here` is true if it has the focus.
pub fn button(ui: &mut Ui, page_style: &PageStyle, word: &str, here: bool) -> Response {
    let (rect, response) = ui.allocate_exact_size(button_size(ui, page_style, word), Sense::click());
    paint_button(ui, page_style, word, here, rect, &response);
    response
}

/// Shows a large button at a given place.
pub fn button_at(ui: &Ui, page_style: &PageStyle, word: &str, here: bool, align: Align2, at: egui::Pos2) -> Response {
    let rect = align.anchor_size(at, button_size(ui, page_style, word));
    let response = ui.interact(rect, Id::unique(("button", word)), Sense::click());
    paint_button(ui, page_style, word, here, rect, &response);
    response
}

fn button_size(ui: &Ui, page_style: &PageStyle, word: &str) -> egui::Vec2 {
    let galley = ui.painter().layout_no_wrap(word.to_owned(), page_style.font(1.0), Color32::WHITE);
    galley.size() + vec2(2.0 * page_style.em, 0.7 * page_style.em)
}

fn paint_button(ui: &Ui, page_style: &PageStyle, word: &str, here: bool, rect: Rect, response: &Response) {
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, word));
    let fill = if here { style::CHOSEN } else { style::CARD };
    ui.painter().rect_filled(
        rect,
        page_style.round(),
        if response.hovered() { fill.gamma_multiply(1.15) } else { fill },
    );
    let (line, side) = if here {
        (page_style.ring(), egui::StrokeKind::Outside)
    } else {
        (page_style.edge(), egui::StrokeKind::Inside)
    };
    ui.painter().rect_stroke(rect, page_style.round(), line, side);
    ui.painter().text(rect.center(), Align2::CENTER_CENTER, word, page_style.font(1.0), Color32::WHITE);
}

/// Shows a text in a box over the picture.
pub fn text_over(ui: &Ui, page_style: &PageStyle, words: &str) {
    let whole = ui.max_rect();
    let painter = ui.painter();
    let galley = painter.layout(words.to_owned(), page_style.font(1.2), style::TEXT, 0.7 * whole.width());
    let at = pos2(whole.center().x, whole.top() + 0.38 * whole.height());
    let rect = Align2::CENTER_CENTER.anchor_size(at, galley.size());
    painter.rect_filled(
        rect.expand2(vec2(1.2 * page_style.em, 0.8 * page_style.em)),
        page_style.round(),
        Color32::from_black_alpha(185),
    );
    painter.galley(rect.min, galley, style::TEXT);
}

/// Shows the seconds to the start over the picture, below a text.
pub fn countdown(ui: &Ui, page_style: &PageStyle, words: &str, left: u32) {
    let whole = ui.max_rect();
    let painter = ui.painter();
    let galley = painter.layout(words.to_owned(), page_style.font(1.0), style::TEXT, 0.7 * whole.width());
    let number = painter.layout_no_wrap(left.to_string(), page_style.font(5.0), Color32::WHITE);
    let size = vec2(galley.size().x.max(number.size().x), galley.size().y + number.size().y);
    let rect = Align2::CENTER_CENTER.anchor_size(pos2(whole.center().x, whole.top() + 0.4 * whole.height()), size);
    painter.rect_filled(
        rect.expand2(vec2(1.2 * page_style.em, 0.8 * page_style.em)),
        page_style.round(),
        Color32::from_black_alpha(185),
    );
    let top = |galley: &egui::Galley, y: f32| pos2(rect.center().x - 0.5 * galley.size().x, y);
    painter.galley(top(&galley, rect.top()), galley.clone(), style::TEXT);
    painter.galley(top(&number, rect.top() + galley.size().y), number.clone(), Color32::WHITE);
    // The label makes the painted text accessible to screen readers.
    let spoken =
        ui.interact(Rect::from_center_size(rect.center(), size), egui::Id::unique("countdown"), Sense::hover());
    spoken.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{words} {left}")));
}
