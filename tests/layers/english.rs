//! Checks of the English in comments, as far as a program can see it: doc comments name the thing first and add a fact, no comment has a
//! banned word, names of tests are short. In: the sources. Out: nothing, or each fault with its place.

use super::{root, sources};
use std::fs;

/// Words with which no doc comment and no text of help begins: they name nothing (CONTRIBUTING.md: English).
pub(super) const FIRST_WORDS: [&str; 36] = [
    "who",
    "whom",
    "whose",
    "whoever",
    "what",
    "whatever",
    "where",
    "wherever",
    "when",
    "whenever",
    "which",
    "whichever",
    "how",
    "however",
    "whether",
    "why",
    "it",
    "its",
    "they",
    "their",
    "them",
    "those",
    "these",
    "this",
    "that",
    "such",
    "he",
    "she",
    "his",
    "her",
    "of",
    "nobody",
    "somebody",
    "anybody",
    "everybody",
    "one's",
];
/// Words that no comment has: riddles, metaphors of an earlier vocabulary, and people who are not "they".
const BANNED_WORDS: [&str; 16] = [
    "whoever",
    "whosoever",
    "somebody",
    "anybody",
    "everybody",
    "nobody",
    "he",
    "him",
    "his",
    "she",
    "her",
    "verdict",
    "verdicts",
    "soup",
    "holdings",
    "darkroom",
];

/// Returns the doc comments of a Rust file: the first line's number and the text of each.
fn doc_comments(text: &str) -> Vec<(usize, String)> {
    let mut docs: Vec<(usize, String)> = Vec::new();
    let mut last = None;
    for (k, line) in text.lines().enumerate() {
        let line = line.trim_start();
        let is_doc = (line.starts_with("///") && !line.starts_with("////")) || line.starts_with("//!");
        if !is_doc {
            continue;
        }
        let (mark, said) = line.split_at(3);
        match docs.last_mut().filter(|_| last == Some((k, mark.to_owned()))) {
            Some((_, so_far)) => *so_far += &format!("\n{}", said.trim()),
            None => docs.push((k + 1, said.trim().to_owned())),
        }
        last = Some((k + 1, mark.to_owned()));
    }
    docs
}

/// Returns a word in lower case, without punctuation around it.
pub(super) fn plain(word: &str) -> String {
    word.trim_matches(|c: char| !c.is_alphanumeric() && c != '\'').to_lowercase()
}

/// Returns what is wrong with the English of a doc comment, as far as a program can see.
fn fault_of_english(doc: &str) -> Option<String> {
    let words: Vec<String> = doc.split_whitespace().map(plain).filter(|word| !word.is_empty()).collect();
    let first = words.first()?;
    if doc.to_lowercase().starts_with("the same") {
        return Some(format!("begins with \"{first}\""));
    }
    // A paragraph, the text below a heading and a sentence at the start of a line begin as the doc comment itself does.
    let mut before = "";
    for line in doc.lines() {
        let begins = before.is_empty() || before.starts_with('#') || before.ends_with('.');
        let word = line.split_whitespace().next().map(plain).unwrap_or_default();
        if begins && FIRST_WORDS.contains(&word.as_str()) {
            return Some(format!("begins with \"{word}\""));
        }
        before = line;
    }
    // A unit, a number or a name of the code is a fact. Texts of help have no full stop: short is good there.
    let adds_a_fact = |c: char| c == ',' || c == '`' || c == ':' || c.is_ascii_digit();
    (words.len() < 4 && doc.ends_with('.') && !doc.contains(adds_a_fact)).then(|| "repeats the name".to_owned())
}

#[test]
fn doc_comments_name_the_thing_first_and_add_a_fact() {
    let mut faults = Vec::new();
    for folder in ["src", "tests", "python/src", "benches"] {
        for file in sources(&root().join(folder)) {
            let text = fs::read_to_string(&file).unwrap();
            let place = |line: usize| format!("{}:{line}", file.strip_prefix(root()).unwrap().display());
            for (line, doc) in doc_comments(&text) {
                faults.extend(fault_of_english(&doc).map(|fault| format!("{}: {fault}: {doc}", place(line))));
            }
            for (k, line) in text.lines().enumerate() {
                let Some(at) = line.find("// ").or_else(|| line.find("/// ")) else { continue };
                let words = line[at..].split(|c: char| !c.is_alphabetic()).map(str::to_lowercase);
                let banned = words.into_iter().find(|word| BANNED_WORDS.contains(&word.as_str()));
                faults.extend(banned.map(|word| format!("{}: \"{word}\"", place(k + 1))));
            }
        }
    }
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn the_check_of_english_finds_riddles_and_lets_facts_pass() {
    let doc = "fn a() {}\n    /// Who stands so near\n    /// stands at it.\n    b: u8,\n/// Speed, m/s.\n//! Head.\n";
    let found = doc_comments(doc);
    assert_eq!(
        found,
        [(2, "Who stands so near\nstands at it.".into()), (5, "Speed, m/s.".into()), (6, "Head.".into())]
    );
    assert_eq!(fault_of_english(&found[0].1).as_deref(), Some("begins with \"who\""));
    assert_eq!(fault_of_english(&found[1].1), None);
    for bad in [
        "Its name.",
        "The same in metres.",
        "A name.",
        "Of the ego.",
        "Starts a drive.\n\n# Errors\nIts world cannot start.",
        "Starts a drive.\nIt has one world.",
    ] {
        assert!(fault_of_english(bad).is_some(), "{bad}");
    }
    for good in ["Returns the lane below\nwhich it lies.", "Look-ahead distance, m", "`None` after a stop.", "0: none."]
    {
        assert_eq!(fault_of_english(good), None, "{good}");
    }
}

#[test]
fn names_of_tests_have_at_most_70_letters() {
    let mut faults = Vec::new();
    for folder in ["src", "tests", "python/src"] {
        for file in sources(&root().join(folder)) {
            let text = fs::read_to_string(&file).unwrap();
            let mut is_test = false;
            for line in text.lines().map(str::trim) {
                if line.starts_with("#[test]") {
                    is_test = true;
                } else if let Some(rest) = line.strip_prefix("fn ").filter(|_| is_test) {
                    let name = rest.split('(').next().unwrap_or_default();
                    if name.len() > 70 {
                        faults.push(format!("{}: {name}", file.display()));
                    }
                    is_test = false;
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
