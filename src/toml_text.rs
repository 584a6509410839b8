//! Mistakes in what a person wrote: in TOML, and in any name. In: the text, what it is called, the path of a key; a name and
//! those that exist. Out: messages that say file, line and column, show the line with a mark under the key or the value, and
//! name the nearest that exists.

use serde::de::DeserializeOwned;
use std::{fmt::Write, ops::Range, path::Path};
use toml::de::{DeTable, DeValue};

/// So many keys are still listed beside a suggestion.
const LISTED_KEYS: usize = 12;

/// What of a key a mistake is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyPart {
    /// Its name.
    Key,
    /// What it is set to.
    Value,
}

/// A mistake at a place of a text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}:{line}:{column}: {message}\n{excerpt}")]
pub struct TomlError {
    /// What the text is called.
    pub name: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in letters, from 1.
    pub column: usize,
    /// What is wrong.
    pub message: String,
    /// The line, and a mark under the place.
    pub excerpt: String,
}

/// Reads a text; `name` is what messages call it.
///
/// # Errors
/// The text is not TOML, names a key that does not exist, lacks one, or a value has the wrong type.
pub fn parse<T: DeserializeOwned>(text: &str, name: &str) -> Result<T, TomlError> {
    toml::from_str(text).map_err(|e| located(text, name, e.span().unwrap_or(0..0), &in_words(e.message())))
}

/// Number of the format of scenario, study and training files, which their key `format` names. A file without the key has format 1.
pub const FORMAT: i64 = 1;

/// Checks the key `format` of a text and returns the text with blanks in its place, so that every other place stays where it is.
///
/// # Errors
/// The file is of another format.
pub fn without_format(text: &str, name: &str) -> Result<String, TomlError> {
    let document = DeTable::parse(text).ok();
    let Some((key, value)) = document.as_ref().and_then(|document| document.get_ref().get_key_value("format")) else {
        return Ok(text.to_owned());
    };
    let written = text[value.span()].to_owned();
    if written != FORMAT.to_string() {
        let fault = format!(
            "the file has format {written}; allowed: {FORMAT}, which is that of {}\n  remedy: use the program that wrote it",
            concat!("codrive ", env!("CARGO_PKG_VERSION"))
        );
        return Err(located(text, name, value.span(), &fault));
    }
    let (start, end) = (key.span().start, value.span().end);
    Ok(text[..start].to_owned() + &" ".repeat(end - start) + &text[end..])
}

/// `message` with file, line and column of a key or of its value and a mark under it. Keys in tables are joined by dots,
/// entries of a list are numbers from 0; what is not in the file is marked at what holds it.
pub fn at(text: &str, name: &str, key: &str, part: KeyPart, message: &str) -> String {
    located(text, name, span_of(text, key, part).0, message).to_string()
}

/// True if a key stands in the text; its path as in [`at`].
pub fn has(text: &str, key: &str) -> bool {
    span_of(text, key, KeyPart::Key).1
}

/// What is said of a key that does not exist: the nearest that does, and which there are.
pub fn unknown_key(key: &str, known: &[&str]) -> String {
    format!("unknown key `{key}`{}", advice(key, known))
}

/// ` (did you mean ...?)` where one of the known names is near, otherwise nothing. Every message about a name that a person
/// typed has it.
pub fn did_you_mean(name: &str, known: &[impl AsRef<str>]) -> String {
    let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
    nearest(name, &known).map_or(String::new(), |near| format!(" (did you mean {near}?)"))
}

/// The same for a file that is not there: the nearest name of those that lie beside it.
pub fn did_you_mean_file(path: &Path) -> String {
    let Some(name) = path.file_name().filter(|_| !path.exists()) else { return String::new() };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    did_you_mean(&name.to_string_lossy(), &names)
}

/// `; did you mean ...?`, and which words there are where they are few or none is near.
fn advice(word: &str, known: &[&str]) -> String {
    let mut text = nearest(word, known).map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    if !known.is_empty() && (known.len() <= LISTED_KEYS || text.is_empty()) {
        let list: Vec<String> = known.iter().map(|known| format!("`{known}`")).collect();
        let _ = write!(text, "{} allowed: {}", if text.is_empty() { ";" } else { "" }, list.join(", "));
    }
    text
}

/// The known word that was most likely meant: within a typing slip of a third of its letters, or with an ending (its unit)
/// more or less.
pub fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let bare = |word: &str| word.to_lowercase().replace(['-', ' '], "_");
    let word = bare(word);
    let slip = |known: &str| {
        let known = bare(known);
        // In one table only what stands behind its name is compared.
        let (word, known) = match (word.rsplit_once('.'), known.rsplit_once('.')) {
            (Some((table, word)), Some((other, known))) if table == other => (word.to_owned(), known.to_owned()),
            _ => (word.clone(), known),
        };
        let distance = strsim::damerau_levenshtein(&word, &known);
        let (short, long) = if word.len() < known.len() { (&word, &known) } else { (&known, &word) };
        let is_ending = short.len() >= 3 && long.strip_prefix(short.as_str()).is_some_and(|rest| rest.starts_with('_'));
        (distance <= (word.chars().count() / 3).max(1) || is_ending).then_some(distance)
    };
    // A letter is within one slip of every other.
    let is_letter = word.rsplit('.').next().is_some_and(|last| last.chars().count() < 2);
    let near = known.iter().filter(|known| !is_letter || bare(known) == word);
    near.filter_map(|known| Some((slip(known)?, *known))).min_by_key(|(distance, _)| *distance).map(|(_, known)| known)
}

/// What a parser (of serde's family) says, in the words of this program, with the nearest word where it lists what it
/// expected.
pub fn in_words(message: &str) -> String {
    let message = message.replace("missing field", "missing key");
    for (theirs, ours) in [("unknown field `", "unknown key"), ("unknown variant `", "unknown value")] {
        let Some((word, rest)) = message.strip_prefix(theirs).and_then(|rest| rest.split_once('`')) else { continue };
        // Between grave accents stand the words that it expected.
        let known: Vec<&str> = rest.split('`').skip(1).step_by(2).collect();
        return format!("{ours} `{word}`{}", advice(word, &known));
    }
    message
}

/// Where a key or its value stands in the text, and that it does; else where what holds it stands.
fn span_of(text: &str, path: &str, part: KeyPart) -> (Range<usize>, bool) {
    let Ok(document) = DeTable::parse(text) else { return (0..0, false) };
    let mut span = 0..0;
    let mut table = Some(document.get_ref());
    let mut list = None;
    for name in path.split('.') {
        let entry = table.and_then(|table| table.get_key_value(name)).map(|(key, value)| (key.span(), value));
        let item = |list: &'_ toml::de::DeArray<'_>| name.parse::<usize>().ok().filter(|i| *i < list.len());
        let found = match (entry, list) {
            (Some((key, value)), _) => Some((if part == KeyPart::Key { key } else { value.span() }, value)),
            (None, Some(list)) => item(list).map(|i| (list[i].span(), &list[i])),
            (None, None) => None,
        };
        let Some((here, value)) = found else { return (span, false) };
        span = here;
        (table, list) = match value.get_ref() {
            DeValue::Table(inner) => (Some(inner), None),
            DeValue::Array(items) => (None, Some(items)),
            _ => (None, None),
        };
    }
    (span, true)
}

/// The mistake with the line and a mark under the span.
fn located(text: &str, name: &str, span: Range<usize>, message: &str) -> TomlError {
    let start = span.start.min(text.len());
    let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
    let number = text[..start].matches('\n').count() + 1;
    let line = text[line_start..].lines().next().unwrap_or_default();
    let column = text[line_start..start].chars().count() + 1;
    let end = span.end.min(line_start + line.len());
    let width = text.get(start..end).map_or(1, |s| s.chars().count().max(1));
    let margin = number.to_string();
    // Tabs are shown as one blank, so that the mark stands under what it means.
    let mut excerpt = format!("  {margin} | {}\n  {:2$} | ", line.replace('\t', " "), "", margin.len());
    let _ = write!(excerpt, "{:1$}{2}", "", column - 1, "^".repeat(width));
    TomlError { name: name.into(), line: number, column, message: message.into(), excerpt }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "title = \"t\"\n[idm]\n  T = 1.5\n[[segment]]\nkind = \"text\"\n[[segment]]\n\tset = { hold_sec = 2, policy = \"x\" }\n";

    #[test]
    fn a_mark_stands_under_the_key_or_under_the_value() {
        let place = |key, part| at(TEXT, "a.toml", key, part, "wrong");
        assert_eq!(place("idm.T", KeyPart::Value), "a.toml:3:7: wrong\n  3 |   T = 1.5\n    |       ^^^");
        assert_eq!(place("idm.T", KeyPart::Key), "a.toml:3:3: wrong\n  3 |   T = 1.5\n    |   ^");
        let set = "  7 |  set = { hold_sec = 2, policy = \"x\" }\n    |          ";
        assert_eq!(place("segment.1.set.hold_sec", KeyPart::Key), format!("a.toml:7:10: wrong\n{set}^^^^^^^^"));
        let policy = place("segment.1.set.policy", KeyPart::Value);
        assert!(policy.starts_with("a.toml:7:33: wrong") && policy.ends_with(" ^^^"), "{policy}");
    }

    #[test]
    fn what_is_not_in_the_text_is_marked_at_what_holds_it() {
        assert!(at(TEXT, "a", "segment.1.name", KeyPart::Value, "m").starts_with("a:6:1: m"));
        assert!(at(TEXT, "a", "segment.7.name", KeyPart::Value, "m").starts_with("a:4:1: m"));
        assert!(at(TEXT, "a", "nothing", KeyPart::Key, "m").starts_with("a:1:1: m"));
        assert!(at("no = = toml", "a", "no", KeyPart::Key, "m").starts_with("a:1:1: m"));
        assert!(has(TEXT, "idm.T") && has(TEXT, "title") && has(TEXT, "idm"));
        assert!(!has(TEXT, "idm.a") && !has(TEXT, "title.x") && !has("= =", "title"));
    }

    #[test]
    fn the_key_that_was_meant_is_found_by_a_slip_or_by_its_unit() {
        let known =
            ["hold_s", "range_mph", "map", "vehicles", "T", "a", "b", "duration_s", "warm_up_s", "idm.T", "idm.a"];
        for (word, meant) in [
            ("hold_sec", Some("hold_s")),
            ("range_mhp", Some("range_mph")),
            ("range", Some("range_mph")),
            ("vehicels", Some("vehicles")),
            ("Map", Some("map")),
            ("t", Some("T")),
            ("warm-up", Some("warm_up_s")),
            ("x", None),
            ("tau", None),
            ("idm.tau", None),
            ("idm.t", Some("idm.T")),
            ("idm.x", None),
            ("colour", None),
        ] {
            assert_eq!(nearest(word, &known), meant, "{word}");
        }
    }

    #[test]
    fn a_file_that_is_not_there_is_answered_with_the_nearest_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("trial.toml"), "").unwrap();
        let told = |name: &str| did_you_mean_file(&folder.path().join(name));
        assert_eq!(told("trail.toml"), " (did you mean trial.toml?)");
        assert_eq!([told("trial.toml"), told("something-else.toml"), told("no/trial.toml")], ["", "", ""]);
    }

    #[test]
    fn many_keys_are_listed_only_where_none_is_near() {
        let many: Vec<String> = (0..40).map(|i| format!("setting_{i}")).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        let near = unknown_key("seting_3", &many);
        assert_eq!(near, "unknown key `seting_3`; did you mean `setting_3`?");
        assert!(unknown_key("far_away", &many).contains("allowed: `setting_0`, `setting_1`"));
        let few = unknown_key("hold", &["hold_s", "map"]);
        assert_eq!(few, "unknown key `hold`; did you mean `hold_s`? allowed: `hold_s`, `map`");
    }

    #[test]
    fn another_format_is_refused_and_a_known_one_moves_nothing() {
        assert_eq!(without_format("seed = 2\n", "x").unwrap(), "seed = 2\n");
        let kept = without_format("# A drive.\nformat = 1 # of the first version\nseed = 2\n", "x").unwrap();
        assert_eq!(kept, "# A drive.\n           # of the first version\nseed = 2\n");
        for (text, written) in [("format = 2", "2"), ("\nformat = \"1\"\n", "\"1\"")] {
            let said = without_format(text, "trial.toml").unwrap_err().to_string();
            let line = text.lines().count();
            let wanted =
                format!("trial.toml:{line}:10: the file has format {written}; allowed: 1, which is that of codrive");
            assert!(said.starts_with(&wanted) && said.contains("remedy: use the program that wrote it"), "{said}");
        }
    }
}
