//! A questionnaire being answered. In: what a hand does, from any device ([`FormInput`]), and the time. Out: where the hand
//! stands, what is missing, in the end each answer with its time since the page was seen. Times in seconds.
//!
//! A page is a row of **stops**: each question is one, each row of a matrix too, and the last is the button that goes on.
//! One gesture moves the choice within a stop, one answers and goes to the next, one goes back: enough for two arrows,
//! Enter and Backspace, and for a wheel with two buttons.

use super::{
    Questionnaire,
    questions::{AnswerChoice, Answers, ElementKind, QuestionElement, QuestionnairePage},
    session::TimedAnswer,
};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// What a participant does at a screen.
#[derive(Clone, Debug, PartialEq)]
pub enum FormInput {
    /// Answer, confirm, go on.
    Next,
    /// One stop back; from the first to the page before.
    Back,
    /// Move the choice by so many places: right and down are positive.
    Turn(i32),
    /// Go to a stop without answering; the stop after the last is the button that goes on.
    Focus(usize),
    /// Take an option of a stop, as a mouse does.
    Pick {
        /// Which stop.
        stop: usize,
        /// Which option of it.
        option: usize,
    },
    /// A text stands in a stop now.
    Type {
        /// Which stop.
        stop: usize,
        /// The whole text.
        text: String,
    },
    /// The page is done.
    PageOn,
    /// The page before.
    PageBack,
    /// Hear the page once more.
    Again,
    /// Mark this moment.
    Mark,
    /// Ask for the end of the drive, or of the session.
    Stop,
}

/// A question, or a row of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormPosition<'a> {
    /// The question.
    pub element: &'a QuestionElement,
    /// Its row, of a matrix.
    pub row: Option<&'a AnswerChoice>,
}

impl FormPosition<'_> {
    /// Name of its answer in the data.
    pub fn name(&self) -> String {
        let names = self.element.answer_names();
        let place = self.row.and_then(|row| self.element.rows.iter().position(|other| std::ptr::eq(row, other)));
        names.into_iter().nth(place.unwrap_or(0)).unwrap_or_default()
    }

    /// True if words are typed here.
    pub fn is_typed(&self) -> bool {
        matches!(self.element.kind, ElementKind::Text | ElementKind::Comment)
    }

    /// What can be chosen, as it stands in the data. A boolean's first option is yes; several of a list are chosen one by
    /// one.
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

    /// Places at which a hand can stand: the options, and after those of a list of several the one that goes on.
    fn places(&self) -> usize {
        self.options().len() + usize::from(self.element.kind == ElementKind::Checkbox)
    }

    /// Where the first move leads: a scale begins in its middle, so that neither end is nearer; a list at its end.
    fn first_place(&self, by: i32) -> usize {
        let last = self.places().saturating_sub(1);
        match self.element.kind {
            ElementKind::Rating => last / 2,
            _ if by < 0 => last,
            _ => 0,
        }
    }
}

/// Whole numbers without a point, as people write them.
fn number(value: f64) -> Value {
    if value.fract() == 0.0 { json!(value as i64) } else { json!(value) }
}

fn equal(a: &Value, b: &Value) -> bool {
    match (a.as_f64(), b.as_f64()) {
        (Some(a), Some(b)) => (a - b).abs() < 1e-9,
        _ => a == b,
    }
}

/// A questionnaire that is being answered.
#[derive(Clone, Debug)]
pub struct QuestionnaireForm {
    questionnaire: Questionnaire,
    /// Place of the page in the questionnaire.
    page: usize,
    focus: usize,
    cursor: Option<usize>,
    answers: Answers,
    /// When each answer was given, seconds since its page was seen.
    times_s: BTreeMap<String, f64>,
    seen_s: f64,
    missing: Vec<String>,
    over: bool,
}

impl QuestionnaireForm {
    /// Begins at the first page, which is seen from `now_s` on.
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

    /// Goes on with a questionnaire of which this was answered before it was cut: at the first page on which something was
    /// not. Times of what is answered now count from `now_s`.
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

    /// The questionnaire's title.
    pub fn title(&self) -> &str {
        &self.questionnaire.title
    }

    /// The page that is seen.
    pub fn page(&self) -> &QuestionnairePage {
        &self.questionnaire.pages[self.page]
    }

    /// Its number from 0 among those that are to be seen with these answers, and how many they are.
    pub fn progress(&self) -> (usize, usize) {
        let visible = self.visible();
        (visible.iter().position(|page| *page == self.page).unwrap_or(0), visible.len())
    }

    /// Everything on the page that is to be seen with these answers, html too.
    pub fn elements(&self) -> impl Iterator<Item = &QuestionElement> {
        self.page().visible_elements(&self.answers)
    }

    /// The page's stops.
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

    /// The stop at which the hand is; as many as there are stops means the button that goes on.
    pub fn focus(&self) -> usize {
        self.focus
    }

    /// Place of the hand within the stop, not yet an answer; `None` before the first move.
    pub fn cursor(&self) -> Option<usize> {
        self.cursor
    }

    /// True if words are typed at the stop where the hand is.
    pub fn typing(&self) -> bool {
        self.stops().get(self.focus).is_some_and(FormPosition::is_typed)
    }

    /// The answer of that name.
    pub fn answer(&self, name: &str) -> Option<&Value> {
        self.answers.get(name)
    }

    /// True if this option of a stop is an answer.
    pub fn is_chosen(&self, stop: &FormPosition<'_>, option: &Value) -> bool {
        match self.answers.get(&stop.name()) {
            Some(Value::Array(list)) => list.iter().any(|one| equal(one, option)),
            Some(answer) => equal(answer, option),
            None => false,
        }
    }

    /// True if that answer is missing and was asked for.
    pub fn is_missing(&self, name: &str) -> bool {
        self.missing.iter().any(|missing| missing == name)
    }

    /// True when the last page is done.
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// What was answered, of the pages and questions that are to be seen with these answers, in their order.
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

    /// A hand does something at this time.
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
                self.give(name, answer, now_s);
            }
            FormInput::PageOn => self.turn_on(now_s),
            FormInput::Mark | FormInput::Stop | FormInput::Again => {}
        }
    }

    /// Pages that are to be seen, as places in the questionnaire.
    fn visible(&self) -> Vec<usize> {
        let seen = |page: &QuestionnairePage| {
            self.questionnaire.visible_pages(&self.answers).any(|other| std::ptr::eq(page, other))
        };
        (0..self.questionnaire.pages.len()).filter(|i| seen(&self.questionnaire.pages[*i])).collect()
    }

    fn go_to(&mut self, stop: usize) {
        let stops = self.stops();
        let focus = stop.min(stops.len());
        // Who comes back finds the choice where the answer is.
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

    /// The gesture that answers.
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
                // Seen and passed by: none of them.
                self.give(name.clone(), Some(json!([])), now_s);
            }
            None => {}
        }
        if required && !self.answers.contains_key(&name) {
            if !self.is_missing(&name) {
                self.missing.push(name);
            }
            return;
        }
        self.go_to(self.focus + 1);
    }

    /// Takes an option of the stop where the hand is; one of several is taken or given back.
    fn choose(&mut self, option: usize, now_s: f64) {
        let stops = self.stops();
        let Some(stop) = stops.get(self.focus) else { return };
        let (name, options) = (stop.name(), stop.options());
        let Some(value) = options.get(option).cloned() else { return };
        if stop.element.kind != ElementKind::Checkbox {
            return self.give(name, Some(value), now_s);
        }
        let taken = |one: &Value| self.is_chosen(stop, one) != equal(one, &value);
        let list: Vec<Value> = options.iter().filter(|one| taken(one)).cloned().collect();
        let required = stop.element.is_required;
        self.give(name, (!required || !list.is_empty()).then_some(Value::Array(list)), now_s);
    }

    fn give(&mut self, name: String, answer: Option<Value>, now_s: f64) {
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

    /// To the next page, if nothing is missing on this one.
    fn turn_on(&mut self, now_s: f64) {
        self.missing = self.page().missing(&self.answers);
        if let Some(first) = self.missing.first() {
            let stop = self.stops().iter().position(|stop| stop.name() == *first);
            return self.go_to(stop.unwrap_or(0));
        }
        match self.visible().into_iter().find(|page| *page > self.page) {
            Some(page) => self.see(page, now_s),
            None => self.over = true,
        }
    }

    fn turn_back(&mut self, now_s: f64) {
        if let Some(page) = self.visible().into_iter().rfind(|page| *page < self.page) {
            self.see(page, now_s);
        }
    }

    fn see(&mut self, page: usize, now_s: f64) {
        (self.page, self.seen_s) = (page, now_s);
        self.missing.clear();
        self.go_to(0);
    }
}

#[cfg(test)]
#[path = "questionnaire_form_tests.rs"]
mod tests;
