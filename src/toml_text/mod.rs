//! Messages about faults in the user's text: TOML, and names of any kind. In: the text, its name, the path of a key; or a name
//! and the known names. Out: all mistakes of the text in one report, each with file, line and column, the line with a mark under the
//! key or the value, and the nearest known name.
//!
//! [`parse`] reads a text. A reader with checks of its own uses [`read`], adds what it finds to the [`Mistakes`] and ends with
//! [`Mistakes::finish`], so that one report has the mistakes of both.

mod kinds;
mod mistakes;
mod names;
mod recover;
mod report;
mod tree;

pub use mistakes::Mistakes;
pub use names::{did_you_mean, did_you_mean_file, in_words, nearest, unknown_key};
pub use report::{TomlError, TomlMistake};
pub use tree::KeyPart;

use kinds::FORMATS;
use serde::de::DeserializeOwned;
use std::ops::Range;
use toml::de::DeTable;

/// Parses a text; `name` is its name in messages.
///
/// # Errors
/// The text is not TOML, has an unknown key, lacks a key, or a value has the wrong type. The report has all mistakes.
pub fn parse<T: DeserializeOwned>(text: &str, name: &str) -> Result<T, TomlError> {
    finished(read(text, name))
}

/// Returns the value that was read, if the text has no mistakes.
///
/// # Errors
/// The report of all mistakes.
pub fn finished<T>((value, mistakes): (Option<T>, Mistakes)) -> Result<T, TomlError> {
    mistakes.finish()?;
    Ok(value.expect("a text without mistakes has a value"))
}

/// Reads a text and returns its mistakes so far, and its value for further checks: without what is wrong, and with a guess for what is
/// missing. There is none if that makes no sense.
pub fn read<T: DeserializeOwned>(text: &str, name: &str) -> (Option<T>, Mistakes) {
    read_checked(text, name, None)
}

/// Reads a text as [`read`], whose key `format` may name the [`FORMAT`]; the value has no such key.
pub fn read_formatted<T: DeserializeOwned>(text: &str, name: &str) -> (Option<T>, Mistakes) {
    match without_format(text) {
        Ok(body) => read_checked(text, name, Some(body)),
        Err((span, message)) => {
            let mut mistakes = Mistakes::new(text, name);
            mistakes.close_with(span, message);
            (None, mistakes)
        }
    }
}

fn read_checked<T: DeserializeOwned>(text: &str, name: &str, body: Option<String>) -> (Option<T>, Mistakes) {
    let mut mistakes = Mistakes::new(text, name);
    mistakes.sound = body.unwrap_or_else(|| text.to_owned());
    let value = toml::from_str(&mistakes.sound).ok().or_else(|| recover::recover(&mut mistakes));
    (value, mistakes)
}

/// Format number of scenario, study and training files, as their key `format` says. A file without the key has format 1.
pub const FORMAT: i64 = 1;

/// Checks the key `format` of a text and returns the text with blanks in its place, so that every other place stays where it is; or the
/// mistake that the file is of another format.
fn without_format(text: &str) -> Result<String, (Range<usize>, String)> {
    let (document, _) = DeTable::parse_recoverable(text);
    let Some((key, value)) = document.get_ref().get_key_value("format") else { return Ok(text.to_owned()) };
    let (start, end) = (key.span().start, value.span().end);
    let Some(written) = text.get(value.span()).filter(|written| !written.is_empty()) else {
        return Ok(text.to_owned());
    };
    if written != FORMAT.to_string() {
        let kind = FORMATS.iter().find(|(begin, ..)| written.trim_start_matches('"').starts_with(begin));
        let fault = match kind {
            Some((_, what, way)) => format!("the file is {what}\n  remedy: {way}"),
            None => format!(
                "the file has format {written}; allowed: {FORMAT}, the format of {}\n  remedy: use the program that \
                 wrote it",
                concat!("codrive ", env!("CARGO_PKG_VERSION"))
            ),
        };
        return Err((value.span(), fault));
    }
    Ok(text[..start].to_owned() + &" ".repeat(end - start) + &text[end..])
}

/// Returns `message` with file, line and column of a key or its value and a mark under it. Dots separate tables and keys;
/// entries of a list are numbers from 0. If the key is missing, the mark is at its parent.
pub fn at(text: &str, name: &str, key: &str, part: KeyPart, message: &str) -> String {
    let span = tree::span_of(&tree::document(text), &tree::path_of(key), part).0;
    TomlMistake::new(text, name, span, message).to_string()
}

/// Checks whether a key is in the text; its path as in [`at`].
pub fn has(text: &str, key: &str) -> bool {
    tree::span_of(&tree::document(text), &tree::path_of(key), KeyPart::Key).1
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
