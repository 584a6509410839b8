//! Rules by which answers end a session: consent declined, screening not passed, a score above its limit. In: the keys of a segment, and
//! answers. Out: a [`SessionEnding`] with the reason for the log and the text for the participant; or an error in a rule, when the study
//! is read.

use super::{
    FmsRating, ParticipantTexts, PlanItem, PlannedItem, Study,
    bids::markdown,
    fms,
    question_fault::QuestionFault,
    questions::{Answers, Questionnaire, VisibilityCondition},
    segment::{ScoreLimit, SegmentKind, StudySegment, short_name},
    session_log::EndCause,
};
use crate::toml_text;
use std::collections::BTreeMap;

/// End of a session by a rule of the study.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionEnding {
    /// Kind of the rule.
    pub cause: EndCause,
    /// Reason, for the log and the experimenter.
    pub reason: String,
    /// Text for the participant.
    pub words: String,
}

/// Reason why a rule cannot be applied.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum RuleFault {
    /// A limit on an unknown score.
    #[error("the score is \"{score}\"; allowed here: {}{near}", list(.known))]
    UnknownScore {
        /// Score as written in the study file.
        score: String,
        /// Known scores of the segment.
        known: Vec<String>,
        /// Nearest known name, as a question ("did you mean ...?"); empty if none is near.
        near: String,
    },
    /// A limit on the fast motion sickness scale in a segment that does not ask it.
    #[error(
        "the score is \"fms\", but this segment does not ask for it; set fms_every_s = 60 in the segment, or name \
         another score"
    )]
    FmsNotAsked,
    /// A limit that no rating of the scale can exceed.
    #[error("value is {0}; allowed: a number from 0 to below {highest}, the upper end of the scale", highest = fms::HIGHEST)]
    FmsValue(f64),
    /// A limit that is not a finite number.
    #[error("value is {0}; allowed: a finite number")]
    Value(f64),
    /// A condition that cannot be parsed.
    #[error("\"{0}\" is not a condition; allowed: {{name}} = 'word' or {{name}} > 3, with = <> < <= > >= contains")]
    Condition(String),
    /// A condition on an unknown question.
    #[error("\"{condition}\" names \"{name}\", but no question of \"{questionnaire}\" has this name{near}")]
    UnknownQuestion {
        /// Condition as written in the study file.
        condition: String,
        /// Unknown name in the condition.
        name: String,
        /// Questionnaire of the segment.
        questionnaire: String,
        /// Nearest known name, as a question ("did you mean ...?"); empty if none is near.
        near: String,
    },
    /// A comparison of unlike types.
    #[error(transparent)]
    Unlike(QuestionFault),
    /// A consent questionnaire without the question that asks for agreement.
    #[error("the questionnaire \"{0}\" of a consent has no required question \"agree\" of type boolean")]
    NoAgreement(String),
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none, because no questionnaire here has scores".into() } else { names.join(", ") }
}

/// Name of the consent question.
const AGREE: &str = "agree";

impl ScoreLimit {
    /// Returns the score's name within the questionnaire `word`; `None` if the limit is about another questionnaire.
    fn score_of<'a>(&'a self, segment: &StudySegment, word: &str) -> Option<&'a str> {
        if segment.has_drives() {
            self.score.strip_prefix(&short_name(word))?.strip_prefix('.')
        } else {
            Some(&self.score)
        }
    }
}

impl StudySegment {
    /// Returns sentences for a plan: the rules that end a session in this segment, and the ratings asked while driving.
    pub fn early_end_sentences(&self, questionnaires: &BTreeMap<String, Questionnaire>) -> Vec<String> {
        let mut all = Vec::new();
        let mut add_sentence = |what: String| all.push(format!("`{}`: {what}", self.name));
        if self.kind == SegmentKind::Consent {
            add_sentence("the session ends if the participant does not consent.".into());
        }
        for condition in &self.ends_if {
            let asked = self.own_questionnaire().and_then(|word| questionnaires.get(word));
            let titles = asked.map_or(String::new(), |asked| titles(asked, condition));
            add_sentence(format!("the session ends if the answers fulfil `{condition}`{titles}."));
        }
        if let Some(every_s) = self.fms_every_s {
            add_sentence(format!(
                "every {every_s} s of a drive the participant rates sickness on the fast motion sickness scale, 0 to {} (Keshavarz and \
                 Hecht 2011), with {} s to answer.",
                fms::HIGHEST,
                fms::ANSWER_S
            ));
        }
        if let Some(ScoreLimit { score, value }) = &self.stop_above {
            let at_once = if score == fms::SCORE { " at that moment of the drive" } else { "" };
            add_sentence(format!("the session ends{at_once} if the score `{score}` is above {value}."));
        }
        all
    }
}

/// Returns the texts of the questions that a condition names: ` (How are you?)`.
fn titles(questionnaire: &Questionnaire, condition: &str) -> String {
    let Ok(condition) = VisibilityCondition::parse(condition) else { return String::new() };
    let elements = questionnaire.pages.iter().flat_map(|page| &page.elements);
    let named = elements.filter(|element| condition.names().any(|name| name == element.name));
    let titles: Vec<String> = named.map(|element| markdown(&element.title)).collect();
    if titles.is_empty() { String::new() } else { format!(" ({})", titles.join(" ")) }
}

impl Study {
    /// Returns the faults of rules that cannot be applied, each with its key. All questionnaires of the study have been read.
    pub(super) fn rule_faults(&self) -> Vec<(String, RuleFault)> {
        let mut faults = Vec::new();
        for (i, segment) in self.file.segment.iter().enumerate() {
            let mut add = |key: &str, fault: RuleFault| faults.push((format!("segment.{i}.{key}"), fault));
            let asked: Vec<(&str, &Questionnaire)> =
                segment.questionnaires().into_iter().map(|(_, word)| (word, &self.questionnaires[word])).collect();
            if let Some(limit) = &segment.stop_above {
                let named = |word: &str, score: &str| {
                    if segment.has_drives() { format!("{}.{score}", short_name(word)) } else { score.into() }
                };
                let scores = asked
                    .iter()
                    .flat_map(|(word, questionnaire)| questionnaire.scores.iter().map(|s| named(word, &s.name)));
                let known: Vec<String> = scores.chain(segment.fms_every_s.map(|_| fms::SCORE.to_owned())).collect();
                let is_fms = segment.has_drives() && limit.score == fms::SCORE;
                if is_fms && segment.fms_every_s.is_none() {
                    add("stop_above.score", RuleFault::FmsNotAsked);
                } else if !known.contains(&limit.score) {
                    let near = toml_text::did_you_mean(&limit.score, &known);
                    let score = limit.score.clone();
                    add("stop_above.score", RuleFault::UnknownScore { score, known, near });
                }
                if is_fms && !(0.0..f64::from(fms::HIGHEST)).contains(&limit.value) {
                    add("stop_above.value", RuleFault::FmsValue(limit.value));
                } else if !limit.value.is_finite() {
                    add("stop_above.value", RuleFault::Value(limit.value));
                }
            }
            let Some((word, questionnaire)) = asked.first().filter(|_| !segment.has_drives()) else { continue };
            for (k, condition) in segment.ends_if.iter().enumerate() {
                let key = format!("ends_if.{k}");
                let Ok(parsed) = VisibilityCondition::parse(condition) else {
                    add(&key, RuleFault::Condition(condition.clone()));
                    continue;
                };
                let names = questionnaire.answer_names();
                if let Some(name) = parsed.names().find(|name| !names.iter().any(|known| known == name)) {
                    let near = toml_text::did_you_mean(name, &names);
                    let (condition, name) = (condition.clone(), name.to_owned());
                    let questionnaire = (*word).to_owned();
                    add(&key, RuleFault::UnknownQuestion { condition, name, questionnaire, near });
                } else if let Some(fault) = questionnaire.unlike(&parsed) {
                    add(&key, RuleFault::Unlike(fault));
                }
            }
            if segment.kind == SegmentKind::Consent && !questionnaire.asks_agreement(AGREE) {
                add("questionnaire", RuleFault::NoAgreement((*word).to_owned()));
            }
        }
        faults
    }

    /// Returns the segment of an item.
    pub fn segment_of(&self, planned: &PlannedItem) -> Option<&StudySegment> {
        self.file.segment.iter().find(|segment| segment.name == planned.segment)
    }

    /// Returns true if the item asks for consent, which the experimenter cannot skip.
    pub fn is_consent(&self, planned: &PlannedItem) -> bool {
        self.segment_of(planned).is_some_and(|segment| segment.kind == SegmentKind::Consent)
    }

    /// Returns the end of the session if this rating is above the segment's limit.
    pub fn ending_of_rating(&self, planned: &PlannedItem, rating: &FmsRating) -> Option<SessionEnding> {
        let segment = self.segment_of(planned)?;
        let limit = segment.stop_above.as_ref().filter(|limit| limit.score == fms::SCORE)?;
        let value = rating.value.filter(|value| f64::from(*value) > limit.value)?;
        let reason = format!("{}: {} is {value}, above {} (stop_above)", planned.name, limit.score, limit.value);
        let words = segment.stop_text.clone().unwrap_or_else(|| self.file.texts.score_limit.clone());
        Some(SessionEnding { cause: EndCause::ScoreLimit, reason, words })
    }

    /// Returns the end of the session if these answers to an item meet a rule.
    pub fn ending(&self, planned: &PlannedItem, answers: &Answers) -> Option<SessionEnding> {
        let segment = self.segment_of(planned)?;
        let PlanItem::Questions(word) = &planned.item else { return None };
        let texts: &ParticipantTexts = &self.file.texts;
        let ending = |cause: EndCause, reason: String, usual: &String| {
            let words = segment.stop_text.clone().unwrap_or_else(|| usual.clone());
            Some(SessionEnding { cause, reason, words })
        };
        if segment.kind == SegmentKind::Consent {
            let agrees = answers.get(AGREE).and_then(serde_json::Value::as_bool) == Some(true);
            let reason = format!("the participant did not agree ({})", planned.name);
            return if agrees { None } else { ending(EndCause::Declined, reason, &texts.declined) };
        }
        let holds = |condition: &&String| VisibilityCondition::parse(condition).is_ok_and(|c| c.holds(answers));
        if let Some(condition) = segment.ends_if.iter().find(holds) {
            let reason = format!("{}: {condition} (ends_if)", planned.name);
            return ending(EndCause::NotEligible, reason, &texts.not_eligible);
        }
        let limit = segment.stop_above.as_ref()?;
        let score = limit.score_of(segment, word)?;
        let scores = self.questionnaires.get(word)?.scores(answers);
        let value = scores.into_iter().find(|(name, _)| name == score)?.1?;
        if value <= limit.value {
            return None;
        }
        // Rounding removes floating-point residues such as 3e-15 from sums of decimal weights.
        let value = (value * 1e6).round() / 1e6;
        let reason = format!("{}: {} is {value}, above {} (stop_above)", planned.name, limit.score, limit.value);
        ending(EndCause::ScoreLimit, reason, &texts.score_limit)
    }
}

#[cfg(test)]
#[path = "stop_rule_tests.rs"]
mod tests;
