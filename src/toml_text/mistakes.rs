//! All mistakes of one text. In: mistakes of its reader, each at a key. Out: the report, or nothing. A mistake that may follow from another
//! one is left out: at the same key, at a table around it, or at a key that depends on it.

use super::{
    report::{MOST_SHOWN, TomlError, TomlMistake},
    tree::{self, KeyPart, KeyPath},
};
use std::ops::Range;

/// Mistakes of a text so far.
#[derive(Clone, Debug)]
pub struct Mistakes {
    text: String,
    name: String,
    found: Vec<Mistake>,
    /// Keys whose values are not those that the writer meant.
    pub(super) doubtful: Vec<KeyPath>,
    /// Tables below the root in which a missing value was guessed.
    pub(super) guessed: Vec<KeyPath>,
    /// Entries that the reader does not see: the path of their list, and their number in it.
    gone: Vec<(KeyPath, usize)>,
    /// Text without the places of syntax errors, in which keys are found.
    pub(super) sound: String,
    /// True if the text was not read to its end.
    pub(super) is_cut: bool,
    /// True if no further mistake counts.
    is_closed: bool,
}

#[derive(Clone, Debug)]
struct Mistake {
    place: Place,
    message: String,
}

#[derive(Clone, Debug)]
enum Place {
    Span(Range<usize>),
    Key(KeyPath, KeyPart),
}

impl Mistakes {
    /// Starts without mistakes; `name` is the name of the text in messages.
    pub(super) fn new(text: &str, name: &str) -> Self {
        Self {
            text: text.into(),
            name: name.into(),
            found: Vec::new(),
            doubtful: Vec::new(),
            guessed: Vec::new(),
            gone: Vec::new(),
            sound: text.into(),
            is_cut: false,
            is_closed: false,
        }
    }

    /// Adds the mistake at a key or its value. Dots separate tables and keys; entries of a list are numbers from 0, as the reader sees
    /// them. If the key is missing, the mark is at its parent.
    pub fn add(&mut self, key: &str, part: KeyPart, message: &str) {
        self.add_related(key, &[], part, message);
    }

    /// Adds the mistake at a key that is one because of the values of other keys; none if one of them has a mistake of its own.
    pub fn add_related(&mut self, key: &str, others: &[&str], part: KeyPart, message: &str) {
        let path = self.in_text(key);
        if self.is_closed
            || self.is_affected(&path)
            || others.iter().any(|other| self.is_affected(&self.in_text(other)))
        {
            return;
        }
        self.doubtful.push(path.clone());
        self.found.push(Mistake { place: Place::Key(path, part), message: message.into() });
    }

    /// Checks whether there is no mistake so far.
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Checks whether a key, a table around it or a value in it has a mistake.
    pub fn is_doubtful(&self, key: &str) -> bool {
        self.is_affected(&self.in_text(key))
    }

    /// Returns the report of all mistakes, if there is one.
    ///
    /// # Errors
    /// There are mistakes.
    pub fn finish(self) -> Result<(), TomlError> {
        if self.found.is_empty() {
            return Ok(());
        }
        let document = tree::document(&self.sound);
        let place = |mistake: &Mistake| match &mistake.place {
            Place::Span(span) => span.clone(),
            Place::Key(path, part) => tree::span_of(&document, path, *part).0,
        };
        let mut placed: Vec<(Range<usize>, String)> =
            self.found.iter().map(|mistake| (place(mistake), mistake.message.clone())).collect();
        // A key that is missing in the whole file has no place of its own, and follows what is wrong in the first line.
        let line_start = |at: usize| self.text.get(..at).and_then(|before| before.rfind('\n')).map_or(0, |end| end + 1);
        placed.sort_by_key(|(span, _)| (line_start(span.start), span.is_empty(), span.start));
        placed.dedup();
        let more = placed.len().saturating_sub(MOST_SHOWN);
        placed.truncate(MOST_SHOWN);
        let shown = placed.into_iter().map(|(span, message)| TomlMistake::new(&self.text, &self.name, span, &message));
        Err(TomlError { mistakes: shown.collect(), more, is_cut: self.is_cut })
    }

    /// Adds a mistake of the text itself.
    pub(super) fn add_at(&mut self, span: Range<usize>, message: String) {
        self.found.push(Mistake { place: Place::Span(span), message });
    }

    /// Makes a mistake the only one.
    pub(super) fn close_with(&mut self, span: Range<usize>, message: String) {
        self.found = vec![Mistake { place: Place::Span(span), message }];
        self.is_closed = true;
    }

    /// Notes that the reader does not see an entry of a list, whose path is that in the text.
    pub(super) fn drop_entry(&mut self, path: &[String]) {
        if let Some((number, list)) = path.split_last() {
            self.gone.push((list.to_vec(), number.parse().unwrap_or_default()));
            self.gone.sort();
        }
    }

    /// Returns the path in the text of a key as the reader sees it.
    fn in_text(&self, key: &str) -> KeyPath {
        self.path_in_text(&tree::path_of(key))
    }

    /// Returns the path in the text of a path as the reader sees it: entries behind one that is gone have a higher number in the text.
    pub(super) fn path_in_text(&self, seen: &[String]) -> KeyPath {
        let mut path = KeyPath::new();
        for name in seen {
            let gone = self.gone.iter().filter(|(list, _)| *list == path);
            let number = name.parse().ok().map(|number: usize| {
                gone.fold(number, |number, (_, entry)| if *entry <= number { number + 1 } else { number })
            });
            path.push(number.map_or_else(|| name.clone(), |number| number.to_string()));
        }
        path
    }

    /// Checks whether a mistake at this path may follow from another one.
    fn is_affected(&self, path: &[String]) -> bool {
        let is_related = |other: &KeyPath| path.starts_with(other) || other.starts_with(path);
        self.doubtful.iter().any(is_related) || self.guessed.iter().any(|table| path.starts_with(table))
    }
}
