//! Reading on after a mistake. In: a text with mistakes. Out: all its mistakes, and the value without what is wrong, for further checks. A wrong
//! key or value is taken out of the document, which is then read again; a missing value is guessed.

use super::{
    kinds::kind_of,
    mistakes::Mistakes,
    names::{first_word, in_words, meant_key},
    tree::{self, KeyPart, KeyPath, NOWHERE, Node},
};
use serde::de::DeserializeOwned;
use std::ops::Range;
use toml::{
    Spanned,
    de::{DeArray, DeString, DeTable, DeValue, Error, ValueDeserializer},
};

/// Text that is read again in all, bytes, so that long files take no more than a second; and limits of the number of times.
const READ_BYTES: usize = 8 << 20;
const LEAST_READINGS: usize = 30;
const MOST_READINGS: usize = 400;
/// Number of guesses for a missing value.
const MOST_GUESSES: usize = 30;
/// Levels of missing tables that are guessed within each other.
const DEEPEST_GUESS: usize = 3;

/// Finds the mistakes of a text that cannot be read, and returns the value that it has without them.
pub(super) fn recover<T: DeserializeOwned>(mistakes: &mut Mistakes) -> Option<T> {
    if !without_syntax_errors(mistakes) {
        return None;
    }
    let sound = mistakes.sound.clone();
    let mut reading = Reading {
        document: tree::document(&sound),
        left: (READ_BYTES / (sound.len() + 1)).clamp(LEAST_READINGS, MOST_READINGS),
        has_syntax_errors: !mistakes.is_empty(),
        mistakes,
    };
    reading.value()
}

/// Adds the syntax errors and replaces their lines by blanks; returns false if the rest has no meaning then.
fn without_syntax_errors(mistakes: &mut Mistakes) -> bool {
    let text = mistakes.sound.clone();
    let (document, errors) = DeTable::parse_recoverable(&text);
    if errors.is_empty() {
        return true;
    }
    let document = tree::root(document);
    let mut extents: Vec<(Range<usize>, Range<usize>, String)> = Vec::new();
    for error in errors {
        let span = error.span().unwrap_or(0..0);
        let message = in_words(error.message());
        // Each further line in a list that was never closed is an error of its own to the parser.
        let open = tree::unclosed(&document, span.start).filter(|_| message.starts_with("unclosed"));
        match open {
            Some(whole) => extents.push((whole.start..whole.start + 1, whole, message)),
            None => extents.push((span.clone(), span, message)),
        }
    }
    extents.sort_by_key(|(place, whole, _)| (place.start, std::cmp::Reverse(whole.end)));
    let mut behind = 0;
    let mut sound = text.clone().into_bytes();
    let mut is_clear = true;
    for (place, whole, message) in extents {
        if place.start < behind {
            continue;
        }
        let from = text[..place.start.min(text.len())].rfind('\n').map_or(0, |i| i + 1);
        let to = whole.end.max(place.start).min(text.len());
        let to = text[to..].find('\n').map_or(text.len(), |i| to + i);
        behind = to + 1;
        is_clear &= !text[from..to].trim_start().starts_with('[');
        let written = text[from..to].split('=').next().unwrap_or_default().trim();
        mistakes.doubtful.push(vec![written.to_owned()]);
        mistakes.add_at(place, message);
        sound[from..to].fill(b' ');
    }
    mistakes.sound = String::from_utf8(sound).unwrap_or_default();
    // Without the heading of a table its keys are those of another one.
    is_clear && DeTable::parse(&mistakes.sound).is_ok()
}

struct Reading<'a, 'm> {
    document: Node<'a>,
    /// Number of readings left.
    left: usize,
    has_syntax_errors: bool,
    mistakes: &'m mut Mistakes,
}

impl Reading<'_, '_> {
    /// Reads until nothing is wrong any more.
    fn value<T: DeserializeOwned>(&mut self) -> Option<T> {
        loop {
            let error = match self.read::<T>() {
                Ok(value) => return Some(value),
                Err(error) => error,
            };
            if self.left == 0 {
                self.mistakes.is_cut = true;
                return None;
            }
            let span = error.span().unwrap_or(0..0);
            if let Some(message) = kind_of(&self.document, error.message()) {
                self.mistakes.close_with(span, message);
                return None;
            }
            let seen = tree::path_at(&self.document, &span);
            let path = self.mistakes.path_in_text(&seen);
            let is_known = match missing(error.message()) {
                Some(key) => {
                    let whole: KeyPath = path.iter().cloned().chain([key.to_owned()]).collect();
                    let is_known = self.has_syntax_errors || self.mistakes.doubtful.contains(&whole);
                    self.mistakes.doubtful.push(whole);
                    if !is_known {
                        self.mistakes.add_at(span.clone(), in_words(error.message()));
                    }
                    if self.guess::<T>(&seen, key, DEEPEST_GUESS) {
                        if !path.is_empty() {
                            self.mistakes.guessed.push(path);
                        }
                        continue;
                    }
                    true
                }
                // What is left of a list or table without its wrong part may be wrong itself.
                None => self.mistakes.doubtful.iter().any(|other| other.starts_with(&path)),
            };
            if !is_known || path.is_empty() && self.mistakes.is_empty() {
                self.mistakes.add_at(span, in_words(error.message()));
            }
            if path.is_empty() {
                return None;
            }
            if let Some(meant) = meant_key(error.message()) {
                let sibling = |path: &[String]| path[..path.len() - 1].iter().cloned().chain([meant.clone()]).collect();
                let (seen, meant): (KeyPath, KeyPath) = (sibling(&seen), sibling(&path));
                // A key that is there, too, has a value of its own.
                if !tree::span_of(&self.document, &seen, KeyPart::Key).1 {
                    self.mistakes.doubtful.push(meant);
                }
            }
            if tree::remove(&mut self.document, &seen) {
                self.mistakes.drop_entry(&path);
            }
            self.mistakes.doubtful.push(path);
        }
    }

    fn read<T: DeserializeOwned>(&mut self) -> Result<T, Error> {
        self.left = self.left.saturating_sub(1);
        T::deserialize(ValueDeserializer::from(self.document.clone()))
    }

    /// Puts a value of any fitting kind in the place of a missing one; returns false if none fits.
    fn guess<T: DeserializeOwned>(&mut self, table: &[String], key: &str, levels: usize) -> bool {
        let mut guesses = vec![
            DeValue::Table(DeTable::new()),
            DeValue::Array(DeArray::new()),
            DeValue::Boolean(false),
            integer(),
            DeValue::String(DeString::Borrowed("")),
        ];
        let whole: KeyPath = table.iter().cloned().chain([key.to_owned()]).collect();
        while let Some(value) = guesses.pop() {
            let is_table = value.is_table();
            tree::insert(&mut self.document, table, key, value);
            for _ in 0..MOST_GUESSES {
                if self.left == 0 {
                    return false;
                }
                let Err(error) = self.read::<T>() else { return true };
                if error.span() != Some(NOWHERE) {
                    return true;
                }
                if let Some(word) = first_word(error.message()) {
                    tree::insert(&mut self.document, table, key, DeValue::String(DeString::Owned(word)));
                    continue;
                }
                match missing(error.message()) {
                    Some(inner) if is_table && levels > 0 && self.guess::<T>(&whole, inner, levels - 1) => {}
                    _ => break,
                }
            }
        }
        tree::remove(&mut self.document, &whole);
        false
    }
}

fn integer() -> DeValue<'static> {
    let one = DeTable::parse("one = 1").ok().and_then(|table| table.into_inner().remove("one"));
    one.map_or(DeValue::Boolean(true), Spanned::into_inner)
}

/// Returns the key that serde's message calls missing.
fn missing(message: &str) -> Option<&str> {
    message.strip_prefix("missing field `")?.strip_suffix('`')
}
