//! A questionnaire being answered. In: the participant's input from any device ([`FormInput`]), and the time in s. Out: the focus,
//! missing answers, and finally each answer with its time since its page was shown, in s.
//!
//! A page is a sequence of **stops**: each question, each row of a matrix, and last the button to the next page. One gesture moves the
//! choice within a stop, one answers and goes to the next stop, one goes back. Two arrow keys, Enter and Backspace are therefore enough,
//! as is a wheel with two buttons.

use super::{
    Questionnaire,
    questions::{AnswerChoice, Answers, ElementKind, QuestionElement, QuestionnairePage},
    session::TimedAnswer,
};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Input of a participant at a screen.
#[derive(Clone, Debug, PartialEq)]
pub enum FormInput {
    /// Answer or confirm, and go to the next stop.
    Next,
    /// One stop back; from the first stop to the previous page.
    Back,
    /// Move the choice by this many places; right and down are positive.
    Turn(i32),
    /// Go to a stop without answering; the index after the last stop is the button to the next page.
    Focus(usize),
    /// Choose an option of a stop, as with a mouse.
    Pick {
        /// Index of the stop.
        stop: usize,
        /// Index of the option.
        option: usize,
    },
    /// Set the text of a stop.
    Type {
        /// Index of the stop.
        stop: usize,
        /// Whole text, replacing the previous one.
        text: String,
    },
    /// Go to the next page.
    PageOn,
    /// Go to the previous page.
    PageBack,
    /// Play the spoken page again.
    Again,
    /// Mark this moment in the recording.
    Mark,
    /// Ask to end the drive or the session.
    Stop,
}

/// Stop on a page: a question, or one row of a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormPosition<'a> {
    /// Question of the stop.
    pub element: &'a QuestionElement,
    /// Row of a matrix; `None` for other questions.
    pub row: Option<&'a AnswerChoice>,
}

impl FormPosition<'_> {
    /// Returns the name of the answer in the data.
    pub fn name(&self) -> String {
        let names = self.element.answer_names();
        let place = self.row.and_then(|row| self.element.rows.iter().position(|other| std::ptr::eq(row, other)));
        names.into_iter().nth(place.unwrap_or(0)).unwrap_or_default()
    }

    /// Returns true if the participant types text here.
    pub fn is_typed(&self) -> bool {
        matches!(self.element.kind, ElementKind::Text | ElementKind::Comment)
    }

    /// Returns the options as values in the data. Yes is the first option of a boolean; the options of a checkbox are chosen one by one.
    pub fn options(&self) -> Vec<Value> {
        let values = |choices: &[AnswerChoice]| choices.iter().map(|choice| choice.value.clone()).collect();
        match self.element.kind {
            ElementKind::Radiogroup | ElementKind::Checkbox => values(&self.element.choices),
            ElementKind::Matrix => values(&self.element.columns),
            ElementKind::Rating => self.element.rates().into_iter().map(number).collect(),
            ElementKind::Boolean => vec![json!(true), json!(false)],
            ElementKind::Text | ElementKind::Comment | ElementKind::Html => Vec::new(),
        }
    }

    /// Returns the number of cursor places: the options, and for a checkbox one more to continue.
    fn places(&self) -> usize {
        self.options().len() + usize::from(self.element.kind == ElementKind::Checkbox)
    }

    /// Returns the cursor place after the first move. A scale begins in its middle, so that neither end is nearer; a list begins at one
    /// end.
    fn first_place(&self, by: i32) -> usize {
        let last = self.places().saturating_sub(1);
        match self.element.kind {
            ElementKind::Rating => last / 2,
            _ if by < 0 => last,
            _ => 0,
        }
    }
}

/// Converts to a JSON number, without a decimal point if whole.
fn number(value: f64) -> Value {
    if value.fract() == 0.0 { json!(value as i64) } else { json!(value) }
}

fn equal(a: &Value, b: &Value) -> bool {
    match (a.as_f64(), b.as_f64()) {
        (Some(a), Some(b)) => (a - b).abs() < 1e-9,
        _ => a == b,
    }
}

/// State of a questionnaire that is being answered.
#[derive(Clone, Debug)]
pub struct QuestionnaireForm {
    questionnaire: Questionnaire,
    /// Index of the page in the questionnaire.
    page: usize,
    focus: usize,
    cursor: Option<usize>,
    answers: Answers,
    /// Time of each answer since its page was seen, s.
    times_s: BTreeMap<String, f64>,
    seen_s: f64,
    missing: Vec<String>,
    over: bool,
}

impl QuestionnaireForm {
    /// Begins at the first visible page, seen from `now_s` on.
    pub fn new(questionnaire: &Questionnaire, now_s: f64) -> Self {
        let mut form = Self {
            questionnaire: questionnaire.clone(),
            page: 0,
            focus: 0,
            cursor: None,
            answers: Answers::new(),
            times_s: BTreeMap::new(),
            seen_s: now_s,
            missing: Vec::new(),
            over: false,
        };
        match form.visible().first() {
            Some(first) => form.page = *first,
            None => form.over = true,
        }
        form
    }

    /// Resumes an interrupted questionnaire at the first page with an unanswered question. Times of new answers count from `now_s`.
    pub fn resume(questionnaire: &Questionnaire, answered: &[TimedAnswer], now_s: f64) -> Self {
        let mut form = Self::new(questionnaire, now_s);
        for TimedAnswer { question, answer, time_s } in answered {
            form.answers.insert(question.clone(), answer.clone());
            form.times_s.insert(question.clone(), *time_s);
        }
        let pages = form.visible();
        for page in pages {
            form.page = page;
            let open = form.stops().iter().position(|stop| !form.answers.contains_key(&stop.name()));
            form.go_to(open.unwrap_or_else(|| form.stops().len()));
            if open.is_some() {
                break;
            }
        }
        form
    }

    /// Returns the title of the questionnaire.
    pub fn title(&self) -> &str {
        &self.questionnaire.title
    }

    /// Returns the current page.
    pub fn page(&self) -> &QuestionnairePage {
        &self.questionnaire.pages[self.page]
    }

    /// Returns the index of the page among the pages visible with these answers, from 0, and the number of those pages.
    pub fn progress(&self) -> (usize, usize) {
        let visible = self.visible();
        (visible.iter().position(|page| *page == self.page).unwrap_or(0), visible.len())
    }

    /// Returns all elements of the page that are visible with these answers, including html.
    pub fn elements(&self) -> impl Iterator<Item = &QuestionElement> {
        self.page().visible_elements(&self.answers)
    }

    /// Returns the stops of the page.
    pub fn stops(&self) -> Vec<FormPosition<'_>> {
        let stops = self.elements().flat_map(|element| -> Vec<FormPosition<'_>> {
            match element.kind {
                ElementKind::Html => Vec::new(),
                ElementKind::Matrix => {
                    element.rows.iter().map(|row| FormPosition { element, row: Some(row) }).collect()
                }
                _ => vec![FormPosition { element, row: None }],
            }
        });
        stops.collect()
    }

    /// Returns the index of the focused stop; the number of stops stands for the button to the next page.
    pub fn focus(&self) -> usize {
        self.focus
    }

    /// Returns the cursor place within the stop, which is not yet an answer; `None` before the first move.
    pub fn cursor(&self) -> Option<usize> {
        self.cursor
    }

    /// Returns true if the participant types text at the focused stop.
    pub fn typing(&self) -> bool {
        self.stops().get(self.focus).is_some_and(FormPosition::is_typed)
    }

    /// Returns the answer of this name.
    pub fn answer(&self, name: &str) -> Option<&Value> {
        self.answers.get(name)
    }

    /// Returns true if this option of a stop is chosen.
    pub fn is_chosen(&self, stop: &FormPosition<'_>, option: &Value) -> bool {
        match self.answers.get(&stop.name()) {
            Some(Value::Array(list)) => list.iter().any(|one| equal(one, option)),
            Some(answer) => equal(answer, option),
            None => false,
        }
    }

    /// Returns true if this answer is marked as missing.
    pub fn is_missing(&self, name: &str) -> bool {
        self.missing.iter().any(|missing| missing == name)
    }

    /// Returns true when the last page is done.
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// Returns the answers to all pages and questions visible with these answers, in order.
    pub fn answered(&self) -> Vec<TimedAnswer> {
        let names = self
            .questionnaire
            .visible_pages(&self.answers)
            .flat_map(|page| page.visible_elements(&self.answers))
            .flat_map(QuestionElement::answer_names);
        names
            .filter_map(|question| {
                let answer = self.answers.get(&question)?.clone();
                let time_s = self.times_s.get(&question).copied().unwrap_or(0.0);
                Some(TimedAnswer { question, answer, time_s })
            })
            .collect()
    }

    /// Applies an input at this time.
    pub fn take(&mut self, input: FormInput, now_s: f64) {
        if self.over {
            return;
        }
        match input {
            FormInput::Next => self.next(now_s),
            FormInput::Back if self.focus > 0 => self.go_to(self.focus - 1),
            FormInput::Back | FormInput::PageBack => self.turn_back(now_s),
            FormInput::Turn(by) => self.turn(by),
            FormInput::Focus(stop) => self.go_to(stop),
            FormInput::Pick { stop, option } => {
                self.go_to(stop);
                self.cursor = Some(option);
                self.choose(option, now_s);
            }
            FormInput::Type { stop, text } => {
                if self.focus != stop {
                    self.go_to(stop);
                }
                let Some(name) = self.stops().get(stop).filter(|s| s.is_typed()).map(FormPosition::name) else {
                    return;
                };
                let answer = (!text.trim().is_empty()).then(|| Value::from(text));
                self.set_answer(name, answer, now_s);
            }
            FormInput::PageOn => self.turn_on(now_s),
            FormInput::Mark | FormInput::Stop | FormInput::Again => {}
        }
    }

    /// Returns the indices of the visible pages in the questionnaire.
    fn visible(&self) -> Vec<usize> {
        let seen = |page: &QuestionnairePage| {
            self.questionnaire.visible_pages(&self.answers).any(|other| std::ptr::eq(page, other))
        };
        (0..self.questionnaire.pages.len()).filter(|i| seen(&self.questionnaire.pages[*i])).collect()
    }

    fn go_to(&mut self, stop: usize) {
        let stops = self.stops();
        let focus = stop.min(stops.len());
        // On return to an answered stop, the cursor is on the answer.
        let at = stops.get(focus).and_then(|stop| {
            let several = stop.element.kind == ElementKind::Checkbox;
            stop.options().iter().position(|option| !several && self.is_chosen(stop, option))
        });
        self.focus = focus;
        self.cursor = at;
    }

    fn turn(&mut self, by: i32) {
        let stops = self.stops();
        let Some(stop) = stops.get(self.focus) else { return };
        let places = stop.places();
        if by == 0 || places == 0 {
            return;
        }
        let last = places as i64 - 1;
        let (from, rest) = match self.cursor {
            Some(cursor) => (cursor as i64, i64::from(by)),
            None => (stop.first_place(by) as i64, i64::from(by - by.signum())),
        };
        let to = (from + rest).clamp(0, last) as usize;
        self.cursor = Some(to);
    }

    /// Applies [`FormInput::Next`]: answers the focused stop and goes to the next one.
    fn next(&mut self, now_s: f64) {
        let stops = self.stops();
        let Some(stop) = stops.get(self.focus) else { return self.turn_on(now_s) };
        let (name, kind, options) = (stop.name(), stop.element.kind, stop.options().len());
        let required = stop.element.is_required;
        let at = self.cursor.filter(|at| *at < options);
        match at {
            Some(at) if kind == ElementKind::Checkbox => return self.choose(at, now_s),
            Some(at) => self.choose(at, now_s),
            None if kind == ElementKind::Checkbox && !required && !self.answers.contains_key(&name) => {
                // Passed without a choice: the answer is an empty list.
                self.set_answer(name.clone(), Some(json!([])), now_s);
            }
            None => {}
        }
        if self.page().missing(&self.answers).contains(&name) {
            if !self.is_missing(&name) {
                self.missing.push(name);
            }
            return;
        }
        self.go_to(self.focus + 1);
    }

    /// Chooses an option of the focused stop; for a checkbox, toggles it.
    fn choose(&mut self, option: usize, now_s: f64) {
        let stops = self.stops();
        let Some(stop) = stops.get(self.focus) else { return };
        let (name, options) = (stop.name(), stop.options());
        let Some(value) = options.get(option).cloned() else { return };
        if stop.element.kind != ElementKind::Checkbox {
            return self.set_answer(name, Some(value), now_s);
        }
        let taken = |one: &Value| self.is_chosen(stop, one) != equal(one, &value);
        let list: Vec<Value> = options.iter().filter(|one| taken(one)).cloned().collect();
        let required = stop.element.is_required;
        self.set_answer(name, (!required || !list.is_empty()).then_some(Value::Array(list)), now_s);
    }

    fn set_answer(&mut self, name: String, answer: Option<Value>, now_s: f64) {
        self.missing.retain(|missing| *missing != name);
        match answer {
            Some(answer) => {
                let time_s = ((now_s - self.seen_s) * 1000.0).round() / 1000.0;
                self.times_s.insert(name.clone(), time_s);
                self.answers.insert(name, answer);
            }
            None => {
                self.times_s.remove(&name);
                self.answers.remove(&name);
            }
        }
    }

    /// Goes to the next page, or to the first missing answer of this one.
    fn turn_on(&mut self, now_s: f64) {
        self.missing = self.page().missing(&self.answers);
        if let Some(first) = self.missing.first() {
            let stop = self.stops().iter().position(|stop| stop.name() == *first);
            return self.go_to(stop.unwrap_or(0));
        }
        match self.visible().into_iter().find(|page| *page > self.page) {
            Some(page) => self.show_page(page, now_s),
            None => self.over = true,
        }
    }

    fn turn_back(&mut self, now_s: f64) {
        if let Some(page) = self.visible().into_iter().rfind(|page| *page < self.page) {
            self.show_page(page, now_s);
        }
    }

    fn show_page(&mut self, page: usize, now_s: f64) {
        (self.page, self.seen_s) = (page, now_s);
        self.missing.clear();
        self.go_to(0);
    }
}

#[cfg(test)]
#[path = "questionnaire_form_tests.rs"]
mod tests;
