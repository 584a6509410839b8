//! Messages about faults in the user's text: TOML, and names of any kind. In: the text, its name, the path of a key; or a name
//! and the known names. Out: messages with file, line and column, the line with a mark under the key or the value, and the
//! nearest known name.

use serde::de::DeserializeOwned;
use std::{fmt::Write, ops::Range, path::Path};
use toml::de::{DeTable, DeValue};

/// Maximum number of keys that are listed beside a suggestion.
const LISTED_KEYS: usize = 12;

/// Part of a key that a fault is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyPart {
    /// Name of the key.
    Key,
    /// Value of the key.
    Value,
}

/// Fault at a position in a text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}:{line}:{column}: {message}\n{excerpt}")]
pub struct TomlError {
    /// Name of the text, such as its file.
    pub name: String,
    /// Number of the line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Description of the fault.
    pub message: String,
    /// Line of the fault, with a mark under the position.
    pub excerpt: String,
}

/// Parses a text; `name` is its name in messages.
///
/// # Errors
/// The text is not TOML, has an unknown key, lacks a key, or a value has the wrong type.
pub fn parse<T: DeserializeOwned>(text: &str, name: &str) -> Result<T, TomlError> {
    toml::from_str(text).map_err(|e| {
        let message = other_kind(text, e.message()).unwrap_or_else(|| in_words(e.message()));
        located(text, name, e.span().unwrap_or(0..0), &message)
    })
}

/// Keys by which a kind of file is known, with its name and its use.
const KINDS: [(&str, &str, &str); 11] = [
    ("segment", "a study", "codrive study check FILE"),
    ("layer", "a policy", "--policy FILE"),
    ("vehicles_min", "the configuration of a training", "codrive train --config FILE"),
    ("drives", "the plan of a sweep", "codrive sweep FILE"),
    ("trainings", "the plan of a sweep", "codrive sweep FILE"),
    ("rehearsals", "the plan of a sweep", "codrive sweep FILE"),
    ("accelerator", "the profile of a wheel", "codrive drive --wheel FILE"),
    ("piece", "the shape of a circuit", "codrive map circuit FILE"),
    ("description", "the description of a map", "--map FOLDER"),
    ("map", "a scenario", "codrive run --scenario FILE"),
    ("vehicles", "a scenario", "codrive run --scenario FILE"),
];

/// Beginnings of the key `format` by which a kind of file is known, with its name and its use.
const FORMATS: [(&str, &str, &str); 4] = [
    ("codrive benchmark ", "a benchmark", "codrive evaluate --benchmark FILE"),
    ("codrive policy ", "a policy", "--policy FILE"),
    ("codrive controller ", "a policy", "--policy FILE"),
    ("codrive drivers ", "the drivers of an analysis", "codrive study rehearse STUDY --drivers FILE"),
];

/// Returns the message on an unknown key of a text that is a file of another kind; `message` is that of serde.
pub fn other_kind(text: &str, message: &str) -> Option<String> {
    let (key, rest) = message.strip_prefix("unknown field `")?.split_once('`')?;
    let is_known = |mark: &str| rest.contains(&format!("`{mark}`"));
    let (_, what, way) = KINDS.iter().find(|(mark, ..)| has(text, mark) && has(text, key) && !is_known(mark))?;
    Some(format!("unknown key `{key}`: the file is {what}\n  remedy: {way}"))
}

/// Format number of scenario, study and training files, as their key `format` says. A file without the key has format 1.
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
        let kind = FORMATS.iter().find(|(begin, ..)| written.trim_start_matches('"').starts_with(begin));
        let fault = match kind {
            Some((_, what, way)) => format!("the file is {what}\n  remedy: {way}"),
            None => format!(
                "the file has format {written}; allowed: {FORMAT}, the format of {}\n  remedy: use the program that \
                 wrote it",
                concat!("codrive ", env!("CARGO_PKG_VERSION"))
            ),
        };
        return Err(located(text, name, value.span(), &fault));
    }
    let (start, end) = (key.span().start, value.span().end);
    Ok(text[..start].to_owned() + &" ".repeat(end - start) + &text[end..])
}

/// Returns `message` with file, line and column of a key or its value and a mark under it. Dots separate tables and keys;
/// entries of a list are numbers from 0. If the key is missing, the mark is at its parent.
pub fn at(text: &str, name: &str, key: &str, part: KeyPart, message: &str) -> String {
    located(text, name, span_of(text, key, part).0, message).to_string()
}

/// Checks whether a key is in the text; its path as in [`at`].
pub fn has(text: &str, key: &str) -> bool {
    span_of(text, key, KeyPart::Key).1
}

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
    for (theirs, ours) in [("unknown field `", "unknown key"), ("unknown variant `", "unknown value")] {
        let Some((word, rest)) = message.strip_prefix(theirs).and_then(|rest| rest.split_once('`')) else { continue };
        // The expected words are between grave accents.
        let known: Vec<&str> = rest.split('`').skip(1).step_by(2).collect();
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

fn is_number_or_switch(value: &str) -> bool {
    value.parse::<f64>().is_ok_and(f64::is_finite) || matches!(value, "true" | "false")
}

/// Returns the span of a key or its value in the text, and true; or the span of its nearest existing parent, and false.
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

/// Makes the error with the line and a mark under the span.
fn located(text: &str, name: &str, span: Range<usize>, message: &str) -> TomlError {
    let start = span.start.min(text.len());
    let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
    let number = text[..start].matches('\n').count() + 1;
    let line = text[line_start..].lines().next().unwrap_or_default();
    let column = text[line_start..start].chars().count() + 1;
    let end = span.end.min(line_start + line.len());
    let width = text.get(start..end).map_or(1, |s| s.chars().count().max(1));
    let margin = number.to_string();
    // A tab is shown as one blank, so that the mark is under the right character.
    let mut excerpt = format!("  {margin} | {}\n  {:2$} | ", line.replace('\t', " "), "", margin.len());
    let _ = write!(excerpt, "{:1$}{2}", "", column - 1, "^".repeat(width));
    TomlError { name: name.into(), line: number, column, message: message.into(), excerpt }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "title = \"t\"\n[idm]\n  T = 1.5\n[[segment]]\nkind = \"text\"\n[[segment]]\n\tset = { hold_sec = 2, policy = \"x\" }\n";

    #[test]
    fn the_mark_is_under_the_key_or_the_value() {
        let place = |key, part| at(TEXT, "a.toml", key, part, "wrong");
        assert_eq!(place("idm.T", KeyPart::Value), "a.toml:3:7: wrong\n  3 |   T = 1.5\n    |       ^^^");
        assert_eq!(place("idm.T", KeyPart::Key), "a.toml:3:3: wrong\n  3 |   T = 1.5\n    |   ^");
        let set = "  7 |  set = { hold_sec = 2, policy = \"x\" }\n    |          ";
        assert_eq!(place("segment.1.set.hold_sec", KeyPart::Key), format!("a.toml:7:10: wrong\n{set}^^^^^^^^"));
        let policy = place("segment.1.set.policy", KeyPart::Value);
        assert!(policy.starts_with("a.toml:7:33: wrong") && policy.ends_with(" ^^^"), "{policy}");
    }

    #[test]
    fn a_missing_key_is_marked_at_its_parent() {
        assert!(at(TEXT, "a", "segment.1.name", KeyPart::Value, "m").starts_with("a:6:1: m"));
        assert!(at(TEXT, "a", "segment.7.name", KeyPart::Value, "m").starts_with("a:4:1: m"));
        assert!(at(TEXT, "a", "nothing", KeyPart::Key, "m").starts_with("a:1:1: m"));
        assert!(at("no = = toml", "a", "no", KeyPart::Key, "m").starts_with("a:1:1: m"));
        assert!(has(TEXT, "idm.T") && has(TEXT, "title") && has(TEXT, "idm"));
        assert!(!has(TEXT, "idm.a") && !has(TEXT, "title.x") && !has("= =", "title"));
    }

    #[test]
    fn a_misspelt_key_and_a_missing_unit_are_recognised() {
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
    fn a_missing_file_gets_the_nearest_name_in_its_folder_as_suggestion() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("trial.toml"), "").unwrap();
        let suggestion = |name: &str| did_you_mean_file(&folder.path().join(name));
        assert_eq!(suggestion("trail.toml"), " (did you mean trial.toml?)");
        assert_eq!(
            [suggestion("trial.toml"), suggestion("something-else.toml"), suggestion("no/trial.toml")],
            ["", "", ""]
        );
    }

    #[test]
    fn a_file_of_another_kind_is_named_with_the_command_that_reads_it() {
        #[derive(Debug, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        #[allow(dead_code, reason = "only the error counts")]
        struct Sheet {
            vehicles: u32,
        }
        let message = |text: &str| parse::<Sheet>(text, "a.toml").unwrap_err().message;
        let study = "unknown key `segment`: the file is a study\n  remedy: codrive study check FILE";
        assert_eq!(
            message(
                "title = \"t\"\n\
            [[segment]]\n\
            kind = \"text\"\n"
            ),
            study
        );
        let wheel = message("[accelerator]\naxis = 1");
        assert_eq!(
            wheel,
            "unknown key `accelerator`: the file is the profile of a wheel\n  remedy: codrive drive --wheel FILE"
        );
        assert!(message("description = \"a ring\"").contains("the file is the description of a map"));
        let fault = |text: &str| without_format(text, "a.toml").unwrap_err().message;
        assert_eq!(
            fault("format = \"codrive benchmark 1\""),
            "the file is a benchmark\n  remedy: codrive evaluate --benchmark FILE"
        );
        assert!(fault("format = 2").starts_with("the file has format 2; allowed: 1, the format of codrive "));
        assert_eq!(message("vehicle = 2"), "unknown key `vehicle`; did you mean `vehicles`? allowed: `vehicles`");
    }

    #[test]
    fn no_word_is_suggested_where_two_are_equally_near() {
        assert_eq!(did_you_mean("kph", &["mph", "kmh"]), "");
        assert_eq!(did_you_mean("mhp", &["mph", "kmh"]), " (did you mean mph?)");
        assert_eq!(did_you_mean("g290", &["g29", "g920"]), " (did you mean g29?)");
    }

    #[test]
    fn a_wrong_type_is_named_in_plain_words() {
        #[derive(Debug, serde::Deserialize)]
        #[allow(dead_code, reason = "only the error counts")]
        struct Sheet {
            vehicles: u32,
            is_on: bool,
            title: String,
        }
        let message = |text: &str| parse::<Sheet>(text, "a.toml").unwrap_err().message;
        let remedy =
            "invalid type: string \"22\"; allowed: a whole number from 0\n  remedy: 22, without quotation marks";
        assert_eq!(message("vehicles = \"22\""), remedy);
        assert_eq!(message("vehicles = -1"), "invalid value: integer `-1`; allowed: a whole number from 0");
        assert_eq!(message("is_on = \"many\""), "invalid type: string \"many\"; allowed: true or false");
        assert_eq!(message("title = 5"), "invalid type: integer `5`; allowed: a text in quotation marks");
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
            let message = without_format(text, "trial.toml").unwrap_err().to_string();
            let line = text.lines().count();
            let wanted =
                format!("trial.toml:{line}:10: the file has format {written}; allowed: 1, the format of codrive");
            assert!(
                message.starts_with(&wanted) && message.contains("remedy: use the program that wrote it"),
                "{message}"
            );
        }
    }
}
