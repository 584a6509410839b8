//! A page of questions. In: a [`QuestionnaireForm`]. Out: the inputs of the mouse and of text fields. The focused
//! answer has a ring, the chosen answer is filled; a required question without an answer is marked in its place.

use super::{
    page::{button, button_at},
    style::{self, PageStyle},
};
use crate::study::{
    FormInput, ParticipantTexts, QuestionnaireForm,
    questionnaire_form::FormPosition,
    questions::{ElementKind, InputType, QuestionElement},
};
use egui::{
    Align, Align2, Color32, Id, Key, KeyboardShortcut, Modifiers, Rect, Response, RichText, Role, ScrollArea, Sense,
    TextEdit, Ui, WidgetInfo, pos2, vec2,
};
use serde_json::Value;

/// Largest number of rates shown as numbers; more are ticks on a line.
const MOST_NUMBERS: usize = 11;

/// Shows the current page of a form, and returns its inputs.
pub fn show(ui: &mut Ui, page_style: &PageStyle, form: &QuestionnaireForm, texts: &ParticipantTexts) -> Vec<FormInput> {
    let mut page = QuestionsPage { page_style, form, texts, inputs: Vec::new(), here: None };
    let (number, pages) = form.progress();
    ui.horizontal(|ui| {
        ui.label(RichText::new(form.title()).font(page_style.font(0.75)).color(style::DIM));
        ui.with_layout(egui::Layout::right_to_left(Align::Center), |ui| {
            let text = format!("{} / {pages}", number + 1);
            ui.label(RichText::new(text).font(page_style.font(0.75)).color(style::DIM));
            if form.elements().any(|element| element.is_required) {
                ui.add_space(page_style.em);
                ui.label(RichText::new(&texts.star).font(page_style.font(0.75)).color(style::DIM));
            }
        });
    });
    let mut area = ScrollArea::vertical().auto_shrink(false).id_salt(("page", number));
    if page.is_fresh(ui) {
        // Each page starts at its top, however far the one before was scrolled.
        area = area.vertical_scroll_offset(0.0);
    }
    area.show(ui, |ui| {
        // Room for the ring at the edges.
        ui.add_space(0.2 * page_style.em);
        if !form.page().title.is_empty() {
            ui.label(RichText::new(&form.page().title).font(page_style.font(1.25)));
            ui.add_space(0.2 * page_style.em);
        }
        let stops = form.stops();
        for element in form.elements() {
            let of = stops.iter().enumerate().filter(|(_, stop)| std::ptr::eq(stop.element, element));
            page.question(ui, element, &of.collect::<Vec<_>>());
            ui.add_space(0.4 * page_style.em);
        }
        page.follow(ui);
    });
    page.inputs
}

/// Shows the buttons for the previous and the next page, at both ends of the last line: always visible.
pub fn buttons(ui: &Ui, page_style: &PageStyle, form: &QuestionnaireForm, texts: &ParticipantTexts) -> Vec<FormInput> {
    let mut inputs = Vec::new();
    let whole = ui.max_rect();
    let y = whole.bottom() - 1.2 * page_style.em;
    let back = pos2(whole.left() + page_style.em, y);
    if form.progress().0 > 0 && button_at(ui, page_style, &texts.back, false, Align2::LEFT_CENTER, back).clicked() {
        inputs.push(FormInput::PageBack);
    }
    let here = form.focus() >= form.stops().len();
    let next = pos2(whole.right() - page_style.em, y);
    if button_at(ui, page_style, &texts.next, here, Align2::RIGHT_CENTER, next).clicked() {
        inputs.push(FormInput::PageOn);
    }
    inputs
}

/// Returns the note at a question without an answer, or with an answer that is not the number that it asks for.
fn required(texts: &ParticipantTexts, element: &QuestionElement) -> String {
    match element.input_type {
        InputType::Number => {
            let ends = [("{low}", element.min), ("{high}", element.max)];
            ends.iter().fold(texts.number.clone(), |text, (name, end)| text.replace(name, &end.to_string()))
        }
        InputType::Text => texts.required.clone(),
    }
}

struct QuestionsPage<'a> {
    page_style: &'a PageStyle,
    form: &'a QuestionnaireForm,
    texts: &'a ParticipantTexts,
    inputs: Vec<FormInput>,
    /// Rectangle of the focused question or matrix row.
    here: Option<Rect>,
}

impl QuestionsPage<'_> {
    fn question(&mut self, ui: &mut Ui, element: &QuestionElement, stops: &[(usize, &FormPosition<'_>)]) {
        let page_style = *self.page_style;
        let top = ui.cursor().top();
        if element.kind == ElementKind::Html {
            ui.label(without_tags(&element.html));
            return;
        }
        let needed = if element.is_required { " *" } else { "" };
        let title = ui.label(RichText::new(format!("{}{needed}", element.title)).font(page_style.font(1.0)));
        if !element.description.is_empty() {
            // Closer, because the description belongs to its title.
            ui.add_space(-0.25 * page_style.em);
            ui.label(RichText::new(&element.description).font(page_style.font(0.8)).color(style::DIM));
        }
        let usual = ui.spacing().item_spacing.y;
        if element.kind == ElementKind::Matrix {
            // Eight rows with their headings fit a 16:9 window, so that answers can be compared at a glance.
            ui.spacing_mut().item_spacing.y = 0.28 * page_style.em;
        }
        for (index, stop) in stops {
            let begin = ui.cursor().top();
            match element.kind {
                ElementKind::Radiogroup if element.choices.len() == 2 => self.pair(ui, *index, stop),
                ElementKind::Radiogroup | ElementKind::Checkbox => self.list(ui, *index, stop),
                ElementKind::Boolean => self.yes_or_no(ui, *index, stop),
                ElementKind::Rating => self.scale(ui, *index, stop),
                ElementKind::Matrix => self.row(ui, *index, stop),
                ElementKind::Text | ElementKind::Comment => self.text(ui, *index, stop, title.id),
                ElementKind::Html => {}
            }
            if self.form.is_missing(&stop.name()) {
                let text = required(self.texts, element);
                ui.label(RichText::new(text).font(page_style.font(0.8)).color(style::MISSING));
            }
            if *index == self.form.focus() {
                // Only the first row of a matrix includes the title.
                let first = stops.first().is_some_and(|(first, _)| first == index);
                let from = if element.kind == ElementKind::Matrix && !first { begin } else { top };
                self.is_here(ui, Rect::from_x_y_ranges(ui.max_rect().x_range(), from..=ui.cursor().top()));
            }
        }
        ui.spacing_mut().item_spacing.y = usual;
    }

    /// Marks the focused part of the page with a bar at its left.
    fn is_here(&mut self, ui: &Ui, rect: Rect) {
        let x = rect.left() - 0.45 * self.page_style.em;
        let bar = Rect::from_min_max(
            pos2(x, rect.top()),
            pos2(x + 0.14 * self.page_style.em, rect.bottom() - 0.3 * self.page_style.em),
        );
        // The column's own clip ends at its edge.
        ui.ctx()
            .layer_painter(ui.layer_id())
            .with_clip_rect(ui.clip_rect().expand2(vec2(self.page_style.em, 0.0)))
            .rect_filled(bar, 2, style::CURSOR);
        self.here = Some(rect);
    }

    /// Shows an option as a card with a text. `many`: check box (true), radio button (false), or a cell without a mark.
    fn option(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        place: (usize, usize),
        label: &str,
        spoken_label: &str,
        many: Option<bool>,
    ) {
        let (stop, option) = place;
        let page_style = self.page_style;
        let response = ui.interact(rect, Id::unique(("option", stop, option)), Sense::click());
        let stops = self.form.stops();
        let chosen =
            stops.get(stop).is_some_and(|s| s.options().get(option).is_some_and(|value| self.form.is_chosen(s, value)));
        let at = self.form.focus() == stop && self.form.cursor() == Some(option);
        let role = if many == Some(true) { Role::CheckBox } else { Role::RadioButton };
        response.widget_info(|| WidgetInfo::selected(role, true, chosen, spoken_label));
        let fill = match (chosen, response.hovered()) {
            (true, _) => style::CHOSEN,
            (false, true) => style::CARD_HOVERED,
            (false, false) => style::CARD,
        };
        let painter = ui.painter();
        painter.rect_filled(rect, page_style.round(), fill);
        let (line, side) = if at {
            (page_style.ring(), egui::StrokeKind::Outside)
        } else {
            (page_style.edge(), egui::StrokeKind::Inside)
        };
        painter.rect_stroke(rect, page_style.round(), line, side);
        let colour = if chosen { Color32::WHITE } else { style::TEXT };
        let Some(many) = many else {
            // A cell: its text is centred, and smaller if it would not fit.
            let mut galley = painter.layout_no_wrap(label.to_owned(), page_style.font(0.85), colour);
            if galley.size().x > rect.width() - 4.0 {
                let times = 0.85 * (rect.width() - 4.0) / galley.size().x;
                galley = painter.layout_no_wrap(label.to_owned(), page_style.font(times.max(0.4)), colour);
            }
            painter.galley(rect.center() - 0.5 * galley.size(), galley, colour);
            return self.picked(&response, stop, option);
        };
        let mark = pos2(rect.left() + 0.95 * page_style.em, rect.center().y);
        let line = egui::Stroke::new(0.08 * page_style.em, if chosen { Color32::WHITE } else { style::DIM });
        if many {
            let square = Rect::from_center_size(mark, vec2(0.7, 0.7) * page_style.em);
            painter.rect_stroke(square, 2, line, egui::StrokeKind::Middle);
            if chosen {
                painter.rect_filled(square.shrink(0.16 * page_style.em), 1, Color32::WHITE);
            }
        } else {
            painter.circle_stroke(mark, 0.35 * page_style.em, line);
            if chosen {
                painter.circle_filled(mark, 0.19 * page_style.em, Color32::WHITE);
            }
        }
        let galley =
            painter.layout(label.to_owned(), page_style.font(0.95), colour, rect.width() - 2.2 * page_style.em);
        painter.galley(
            pos2(rect.left() + 1.8 * page_style.em, rect.center().y - 0.5 * galley.size().y),
            galley,
            colour,
        );
        self.picked(&response, stop, option);
    }

    fn picked(&mut self, response: &Response, stop: usize, option: usize) {
        if response.clicked() {
            self.inputs.push(FormInput::Pick { stop, option });
        }
    }

    /// Shows the options one below the other.
    fn list(&mut self, ui: &mut Ui, index: usize, stop: &FormPosition<'_>) {
        let many = stop.element.kind == ElementKind::Checkbox;
        for (i, choice) in stop.element.choices.iter().enumerate() {
            let rect = ui.allocate_space(vec2(ui.available_width(), 1.65 * self.page_style.em)).1;
            self.option(ui, rect, (index, i), &choice.text, &choice.text, Some(many));
        }
        let places = stop.element.choices.len();
        if many && self.form.focus() == index {
            // The button by which a participant without a mouse leaves the list.
            let word = self.texts.no_more.clone();
            if button(ui, self.page_style, &word, self.form.cursor() == Some(places)).clicked() {
                self.inputs.push(FormInput::Focus(index + 1));
            }
        }
    }

    /// Shows cells of equal width side by side.
    fn cells(&mut self, ui: &mut Ui, rect: Rect, index: usize, labels: &[(String, String)]) {
        let gap = 0.25 * self.page_style.em;
        let width = (rect.width() - gap * (labels.len().max(1) - 1) as f32) / labels.len().max(1) as f32;
        for (i, (label, spoken_label)) in labels.iter().enumerate() {
            let left = rect.left() + (width + gap) * i as f32;
            let cell = Rect::from_min_size(pos2(left, rect.top()), vec2(width, rect.height()));
            self.option(ui, cell, (index, i), label, spoken_label, None);
        }
    }

    /// Shows two options side by side, for comparison.
    fn pair(&mut self, ui: &mut Ui, index: usize, stop: &FormPosition<'_>) {
        let rect = ui.allocate_space(vec2(ui.available_width(), 1.65 * self.page_style.em)).1;
        let labels: Vec<_> =
            stop.element.choices.iter().map(|choice| (choice.text.clone(), choice.text.clone())).collect();
        self.cells(ui, rect, index, &labels);
    }

    fn yes_or_no(&mut self, ui: &mut Ui, index: usize, stop: &FormPosition<'_>) {
        let width = (14.0 * self.page_style.em).min(ui.available_width());
        let rect = ui.allocate_space(vec2(width, 1.65 * self.page_style.em)).1;
        let labelled = |word: &String| (word.clone(), format!("{}: {word}", stop.element.title));
        let labels = [labelled(&self.texts.yes), labelled(&self.texts.no)];
        self.cells(ui, rect, index, &labels);
    }

    fn row(&mut self, ui: &mut Ui, index: usize, stop: &FormPosition<'_>) {
        let rect = ui.allocate_space(vec2(ui.available_width(), 1.4 * self.page_style.em)).1;
        let name = stop.row.map_or("", |row| row.text.as_str());
        let share = 0.36;
        let missing = self.form.is_missing(&stop.name());
        let colour = if missing { style::MISSING } else { style::TEXT };
        let painter = ui.painter();
        let galley = painter.layout(
            name.to_owned(),
            self.page_style.font(0.85),
            colour,
            share * rect.width() - 0.3 * self.page_style.em,
        );
        painter.galley(pos2(rect.left(), rect.center().y - 0.5 * galley.size().y), galley, colour);
        let columns = &stop.element.columns;
        let labels: Vec<_> = columns.iter().map(|c| (c.text.clone(), format!("{name}: {}", c.text))).collect();
        let right = Rect::from_min_max(pos2(rect.left() + share * rect.width(), rect.top()), rect.max);
        self.cells(ui, right, index, &labels);
    }

    /// Shows the rates as numbers, or as ticks on a line if there are many, with the texts of both ends below.
    fn scale(&mut self, ui: &mut Ui, index: usize, stop: &FormPosition<'_>) {
        let rates = stop.options();
        let labels: Vec<_> =
            rates.iter().map(|rate| (rate.to_string(), format!("{}: {rate}", stop.element.title))).collect();
        let rect = ui.allocate_space(vec2(ui.available_width(), 1.65 * self.page_style.em)).1;
        if rates.len() <= MOST_NUMBERS {
            self.cells(ui, rect, index, &labels);
        } else {
            self.ticks(ui, rect, index, stop, &rates, &labels);
        }
        let (low, high) = (&stop.element.min_rate_description, &stop.element.max_rate_description);
        if low.is_empty() && high.is_empty() {
            return;
        }
        // Closer, because the texts belong to their scale: three scales with texts fit a page.
        ui.add_space(-0.4 * self.page_style.em);
        let rect = ui.allocate_space(vec2(ui.available_width(), 0.9 * self.page_style.em)).1;
        let font = self.page_style.font(0.75);
        ui.painter().text(rect.left_center(), Align2::LEFT_CENTER, low, font.clone(), style::DIM);
        ui.painter().text(rect.right_center(), Align2::RIGHT_CENTER, high, font, style::DIM);
    }

    fn ticks(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        index: usize,
        stop: &FormPosition<'_>,
        rates: &[Value],
        labels: &[(String, String)],
    ) {
        let em = self.page_style.em;
        let inner = rect.shrink2(vec2(0.6 * em, 0.0));
        let apart = inner.width() / (rates.len() - 1) as f32;
        let y = rect.center().y;
        ui.painter().rect_filled(rect, self.page_style.round(), style::CARD);
        ui.painter().rect_stroke(rect, self.page_style.round(), self.page_style.edge(), egui::StrokeKind::Inside);
        ui.painter().hline(inner.x_range(), y, (0.06 * em, style::DIM));
        for (i, rate) in rates.iter().enumerate() {
            let at = pos2(inner.left() + apart * i as f32, y);
            let cell = Rect::from_center_size(at, vec2(apart, rect.height()));
            let response = ui.interact(cell, Id::unique(("option", index, i)), Sense::click());
            let chosen = self.form.is_chosen(stop, rate);
            response.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, chosen, &labels[i].1));
            let painter = ui.painter();
            let half = if i == 0 || i + 1 == rates.len() || 2 * i + 1 == rates.len() { 0.42 } else { 0.24 };
            let colour = if response.hovered() { style::TEXT } else { style::DIM };
            painter.vline(at.x, (y - half * em)..=(y + half * em), (0.06 * em, colour));
            if chosen {
                painter.circle_filled(at, 0.42 * em, style::CHOSEN);
                painter.circle_stroke(at, 0.42 * em, (0.08 * em, Color32::WHITE));
            }
            if self.form.focus() == index && self.form.cursor() == Some(i) {
                painter.circle_stroke(at, 0.6 * em, self.page_style.ring());
            }
            self.picked(&response, index, i);
        }
    }

    fn text(&mut self, ui: &mut Ui, index: usize, stop: &FormPosition<'_>, title: Id) {
        let name = stop.name();
        let mut text = self.form.answer(&name).and_then(Value::as_str).unwrap_or_default().to_owned();
        let several = stop.element.kind == ElementKind::Comment;
        let edit = if several { TextEdit::multiline(&mut text) } else { TextEdit::singleline(&mut text) };
        let edit = edit
            .id(Id::unique(("text", index)))
            .desired_width(ui.available_width() - 0.6 * self.page_style.em)
            .desired_rows(if several { 3 } else { 1 })
            .return_key(KeyboardShortcut::new(Modifiers::SHIFT, Key::Enter))
            .margin(egui::Margin::same((0.4 * self.page_style.em).min(120.0) as i8));
        let response = ui.add(edit).labelled_by(title);
        if response.changed() {
            self.inputs.push(FormInput::Type { stop: index, text });
        }
        let here = self.form.focus() == index;
        if here {
            ui.painter().rect_stroke(
                response.rect,
                self.page_style.round(),
                self.page_style.ring(),
                egui::StrokeKind::Outside,
            );
        } else {
            ui.painter().rect_stroke(
                response.rect,
                self.page_style.round(),
                self.page_style.edge(),
                egui::StrokeKind::Inside,
            );
        }
        match (here, response.has_focus()) {
            (false, true) if response.gained_focus() => self.inputs.push(FormInput::Focus(index)),
            (false, true) => response.surrender_focus(),
            (true, false) => response.request_focus(),
            _ => {}
        }
    }

    /// Returns the page and focus of the pass before.
    fn before(ui: &Ui) -> Option<PageSeen> {
        ui.data(|data| data.get_temp(Id::unique("questionnaire")))
    }

    /// Returns true if the pass before showed another page or another questionnaire.
    fn is_fresh(&self, ui: &Ui) -> bool {
        Self::before(ui).is_none_or(|before| before.title != self.form.title() || before.page != self.form.progress().0)
    }

    /// Scrolls to the focus if it has moved, or if the note on a missing answer has appeared there. The first stop of a
    /// new page is visible anyway, with the headings above it.
    fn follow(&self, ui: &Ui) {
        let (title, page, focus) = (self.form.title().to_owned(), self.form.progress().0, self.form.focus());
        let is_missing = self.form.stops().get(focus).is_some_and(|stop| self.form.is_missing(&stop.name()));
        let now = PageSeen { title, page, focus, is_missing };
        let fresh = self.is_fresh(ui);
        if Self::before(ui).as_ref() != Some(&now) {
            ui.data_mut(|data| data.insert_temp(Id::unique("questionnaire"), now));
            if let (Some(rect), true) = (self.here, !fresh || focus > 0) {
                ui.scroll_to_rect(rect.expand(self.page_style.em), None);
            }
        }
    }
}

/// Page and focus in one pass, to detect changes.
#[derive(Clone, Debug, PartialEq)]
struct PageSeen {
    title: String,
    page: usize,
    /// Index of the focused stop.
    focus: usize,
    /// True if the focused stop lacks a required answer.
    is_missing: bool,
}

/// Returns the text of an HTML fragment without its tags.
fn without_tags(html: &str) -> String {
    let mut text = String::new();
    let mut within = false;
    for letter in html.chars() {
        match letter {
            '<' => within = true,
            '>' if within => within = false,
            other if !within => text.push(other),
            _ => {}
        }
    }
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", " ").replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn html_is_read_without_its_tags() {
        assert_eq!(without_tags("<p>One <b>two</b></p> 3 &lt; 4 &amp;c"), "One two 3 < 4 &c");
    }
}
