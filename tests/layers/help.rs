//! Checks of the English in help, settings and definitions of measures: no sentence begins with a pronoun or a question word. In: the texts
//! of the program. Out: nothing, or each fault with its place.

use super::english::{FIRST_WORDS, plain};
use clap::Command;
use codrive::{
    cli::{self, HelpListing},
    metrics::registry::measures,
    scenario::Scenario,
    settings::{Field, fields_of},
    train::TrainConfig,
};
use std::collections::BTreeSet;

/// Returns the pronoun or question word with which a sentence of a text for users begins.
fn riddle(text: &str) -> Option<String> {
    let sentences = text.lines().flat_map(|line| line.split(". "));
    let begins = |sentence: &str| {
        let word = sentence.split_whitespace().next().map(plain).unwrap_or_default();
        let is_riddle = FIRST_WORDS.contains(&word.as_str()) || sentence.trim().to_lowercase().starts_with("the same ");
        is_riddle.then(|| format!("\"{word}\" begins: {}", sentence.trim()))
    };
    sentences.into_iter().find_map(begins)
}

/// Collects the help of a command, of its arguments and of its subcommands, each with the place.
fn texts_of_help(command: &Command, before: &str, texts: &mut Vec<(String, String)>) {
    let place = format!("{before} {}", command.get_name());
    let own = [command.get_about(), command.get_long_about(), command.get_before_help(), command.get_after_help()];
    texts.extend(own.into_iter().flatten().map(|text| (place.trim().to_owned(), text.to_string())));
    for argument in command.get_arguments() {
        let helps = [argument.get_help(), argument.get_long_help()];
        let place = format!("{} {}", place.trim(), argument.get_id());
        texts.extend(helps.into_iter().flatten().map(|text| (place.clone(), text.to_string())));
    }
    command.get_subcommands().for_each(|sub| texts_of_help(sub, &place, texts));
}

#[test]
fn help_settings_and_measures_name_the_thing_first() {
    let mut texts = Vec::new();
    for listing in [HelpListing::Common, HelpListing::All] {
        texts_of_help(&cli::command(listing), "", &mut texts);
    }
    let settings = Scenario::fields().into_iter().chain(fields_of::<TrainConfig>());
    texts.extend(settings.map(|Field { path, doc, .. }| (path, doc)));
    texts.extend(measures().map(|measure| (measure.name.to_owned(), measure.about.to_owned())));
    // A walk that misses a source would pass: the settings, the measures and the flags are several hundred texts.
    assert!(texts.len() > 400, "{} texts", texts.len());
    let faults = texts.iter().filter_map(|(place, text)| Some(format!("{place}: {}", riddle(text)?)));
    let faults: BTreeSet<String> = faults.collect();
    assert!(
        faults.is_empty(),
        "{} faults:\n\
        {}",
        faults.len(),
        faults.into_iter().collect::<Vec<_>>().join("\n")
    );
}

#[test]
fn the_check_of_help_finds_riddles_and_lets_facts_pass() {
    for bad in [
        "How long it runs",
        "Time of it. Those that come later wait",
        "Table:\n  which is \
            there",
        "The same as before",
    ] {
        assert!(riddle(bad).is_some(), "{bad}");
    }
    assert_eq!(riddle("Longest run time, all attempts together, 1 to 86400 s\n\nExample: a. b"), None);
}
