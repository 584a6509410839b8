//! Messages about names of any kind. In: a name that the user typed and the known names, or a message of serde. Out: the nearest known
//! name, the list of known names, and the message in this program's terms.

use std::{fmt::Write, path::Path};

/// Maximum number of keys that are listed beside a suggestion.
const LISTED_KEYS: usize = 12;

/// Returns the message on an unknown key: the nearest known key, and the list of known keys.
pub fn unknown_key(key: &str, known: &[&str]) -> String {
    format!("unknown key `{key}`{}", advice(key, known))
}

/// Returns ` (did you mean ...?)` with the nearest known name; empty if none is near. For every message about a name that the
/// user typed.
pub fn did_you_mean(name: &str, known: &[impl AsRef<str>]) -> String {
    let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
    nearest(name, &known).map_or(String::new(), |near| format!(" (did you mean {near}?)"))
}

/// Returns such a suggestion for a missing file, from the names in its folder; empty if the file exists.
pub fn did_you_mean_file(path: &Path) -> String {
    let Some(name) = path.file_name().filter(|_| !path.exists()) else { return String::new() };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    did_you_mean(&name.to_string_lossy(), &names)
}

/// Returns `; did you mean ...?` with the nearest known word. Lists the known words if they are few or none is near.
fn advice(word: &str, known: &[&str]) -> String {
    let mut text = nearest(word, known).map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    if !known.is_empty() && (known.len() <= LISTED_KEYS || text.is_empty()) {
        let list: Vec<String> = known.iter().map(|known| format!("`{known}`")).collect();
        let _ = write!(text, "{} allowed: {}", if text.is_empty() { ";" } else { "" }, list.join(", "));
    }
    text
}

/// Returns the known word that was most likely meant: within a typing slip of a third of its letters, or with or without an
/// ending such as its unit. `None` if two known words are equally near.
pub fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let bare = |word: &str| word.to_lowercase().replace(['-', ' '], "_");
    let word = bare(word);
    let slip = |known: &str| {
        let known = bare(known);
        // Within one table only the last parts are compared.
        let (word, known) = match (word.rsplit_once('.'), known.rsplit_once('.')) {
            (Some((table, word)), Some((other, known))) if table == other => (word.to_owned(), known.to_owned()),
            _ => (word.clone(), known),
        };
        let distance = strsim::damerau_levenshtein(&word, &known);
        let (short, long) = if word.len() < known.len() { (&word, &known) } else { (&known, &word) };
        let is_ending = short.len() >= 3 && long.strip_prefix(short.as_str()).is_some_and(|rest| rest.starts_with('_'));
        (distance <= (word.chars().count() / 3).max(1) || is_ending).then_some(distance)
    };
    // A single letter is within one slip of every other.
    let is_letter = word.rsplit('.').next().is_some_and(|last| last.chars().count() < 2);
    let near = known.iter().filter(|known| !is_letter || bare(known) == word);
    let slips: Vec<(usize, &str)> = near.filter_map(|known| Some((slip(known)?, *known))).collect();
    let begins_alike = |known: &str| word.starts_with(&bare(known)) || bare(known).starts_with(&word);
    let rank = |(distance, known): &(usize, &str)| (*distance, !begins_alike(known));
    let best = slips.iter().map(rank).min()?;
    let mut nearest = slips.iter().filter(|slip| rank(slip) == best).map(|(_, known)| *known);
    // `kph` is as near to `mph` as to `kmh`: a guess would be wrong half the time.
    nearest.next().filter(|_| nearest.next().is_none())
}

/// Returns a serde parser's message in this program's terms, with the nearest word if it lists the expected ones.
pub fn in_words(message: &str) -> String {
    let message = message.replace("missing field", "missing key");
    for (theirs, ours) in [("field", "unknown key"), ("variant", "unknown value")] {
        let Some((word, known)) = unknown(&message, theirs) else { continue };
        return format!("{ours} `{word}`{}", advice(word, &known));
    }
    let Some((given, expected)) = message.rsplit_once(", expected ") else { return message };
    let allowed = match expected {
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number from 0",
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number",
        "f32" | "f64" => "a number",
        "a boolean" => "true or false",
        "a string" => "a text in quotation marks",
        "a sequence" => "a list in brackets",
        "a map" => "a table",
        table if table.starts_with("struct ") => "a table",
        _ => return message,
    };
    let quoted = given.strip_prefix("invalid type: string \"").and_then(|rest| rest.strip_suffix('"'));
    let remedy = match quoted {
        Some(value) if is_number_or_switch(value) && !allowed.contains("text") => {
            format!("\n  remedy: {value}, without quotation marks")
        }
        _ => String::new(),
    };
    format!("{given}; allowed: {allowed}{remedy}")
}

/// Returns the unknown word in a serde parser's message, and the known ones; `what` is its word for their kind.
fn unknown<'a>(message: &'a str, what: &str) -> Option<(&'a str, Vec<&'a str>)> {
    let (word, rest) = message.strip_prefix("unknown ")?.strip_prefix(what)?.strip_prefix(" `")?.split_once('`')?;
    // The expected words are between grave accents.
    Some((word, rest.split('`').skip(1).step_by(2).collect()))
}

/// Returns the key that was meant by the one that a serde parser's message calls unknown.
pub(super) fn meant_key(message: &str) -> Option<String> {
    let (word, known) = unknown(message, "field")?;
    nearest(word, &known).map(str::to_owned)
}

/// Returns the first word that a serde parser's message on an unknown one lists.
pub(super) fn first_word(message: &str) -> Option<String> {
    unknown(message, "variant")?.1.first().map(|word| (*word).to_owned())
}

fn is_number_or_switch(value: &str) -> bool {
    value.parse::<f64>().is_ok_and(f64::is_finite) || matches!(value, "true" | "false")
}
