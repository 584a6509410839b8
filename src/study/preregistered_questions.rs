//! Questionnaires and early ends as a preregistration states them. In: a study. Out: Markdown.

use super::{Study, bids::markdown, questions::Questionnaire, segment::StudySegment};
use std::fmt::Write;

/// Writes each questionnaire with its source, its scores, and the parts of the session that ask it.
pub(super) fn questionnaires(out: &mut String, study: &Study) {
    if study.questionnaires.is_empty() {
        return;
    }
    out.push_str("## Questionnaires\n\n");
    for (name, questionnaire) in &study.questionnaires {
        let asked: Vec<String> = study.file.segment.iter().filter_map(|segment| place(segment, name)).collect();
        if !asked.is_empty() {
            let _ = writeln!(
                out,
                "* {}, asked {}. {}",
                title(name, questionnaire),
                asked.join(" and "),
                about(questionnaire)
            );
        }
    }
    out.push('\n');
}

fn title(name: &str, questionnaire: &Questionnaire) -> String {
    format!("`{name}` ({})", markdown(&questionnaire.title))
}

fn about(questionnaire: &Questionnaire) -> String {
    let scores: Vec<String> = questionnaire.scores.iter().map(|score| format!("`{}`", score.name)).collect();
    let scores = if scores.is_empty() { "No score.".into() } else { format!("Scores: {}.", scores.join(", ")) };
    format!("{} {scores}", markdown(&questionnaire.description)).trim_start().to_owned()
}

/// Returns the moment at which a segment asks a questionnaire; `None` if it does not.
fn place(segment: &StudySegment, name: &str) -> Option<String> {
    let key = segment.questionnaires().into_iter().find(|(_, word)| *word == name)?.0;
    Some(match key.split('.').next() {
        Some("after") => format!("after each drive of `{}`", segment.name),
        Some("after_advice") => format!("after each drive of `{}` with advice", segment.name),
        _ => format!("in `{}`", segment.name),
    })
}

/// Writes the rules that end a session early, and the ratings asked for them while driving.
pub(super) fn early_ends(out: &mut String, study: &Study) {
    let of = |segment: &StudySegment| segment.early_end_sentences(&study.questionnaires);
    let rules: Vec<String> = study.file.segment.iter().flat_map(of).collect();
    out.push_str("## When a session ends early\n\nA participant may stop at any moment.\n\n");
    rules.iter().for_each(|rule| {
        let _ = writeln!(out, "* {rule}");
    });
    if !rules.is_empty() {
        out.push('\n');
    }
}
