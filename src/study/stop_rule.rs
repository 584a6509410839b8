//! Rules by which answers end a session: consent that is not given, a screening that is not passed, a score above its limit. In:
//! a segment's keys, answers. Out: a [`SessionEnding`] with its reason for the log and the words that the participant reads; or a
//! mistake in a rule, when the study is read.

use super::{
    FmsRating, PlanItem, PlannedItem, Study,
    file::ParticipantTexts,
    fms,
    questions::{Answers, Questionnaire, VisibilityCondition},
    segment::{SegmentKind, StudySegment, short_name},
    session_log::EndCause,
};
use crate::toml_text;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A limit of a score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScoreLimit {
    /// The score's name in its questionnaire (questions), `QUESTIONNAIRE.SCORE` for a questionnaire in `after` (drive, trials), or `fms`
    /// for the scale that is asked while driving (`fms_every_s`).
    pub score: String,
    /// The highest value with which the session goes on, in the score's own unit.
    pub value: f64,
}

/// An end of a session by a rule of the study.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionEnding {
    /// Which kind of rule.
    pub cause: EndCause,
    /// Why, for the log and the experimenter.
    pub reason: String,
    /// What the participant reads.
    pub words: String,
}

/// Why a rule cannot be followed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum RuleFault {
    /// A limit of a score that nothing has.
    #[error("the score is \"{score}\"; allowed here: {}{near}", list(.known))]
    UnknownScore {
        /// As it is written.
        score: String,
        /// Scores of the segment's questionnaires.
        known: Vec<String>,
        /// The nearest that exists, as a question; empty where none is near.
        near: String,
    },
    /// A limit of the scale that is asked while driving, which is not asked.
    #[error(
        "the score is \"fms\", and nothing asks for it here; give the segment fms_every_s = 60, or name another score"
    )]
    FmsNotAsked,
    /// A limit that no answer of the scale is above.
    #[error("value is {0}; allowed: a number from 0 to below {highest}, the upper end of the scale", highest = fms::HIGHEST)]
    FmsValue(f64),
    /// A limit that is no number.
    #[error("value is {0}; allowed: a finite number")]
    Value(f64),
    /// A condition that is none.
    #[error("\"{0}\" is no condition; allowed: {{name}} = 'word' or {{name}} > 3, with = <> < <= > >= contains")]
    Condition(String),
    /// A condition on what is not asked.
    #[error("\"{condition}\" asks for \"{name}\", which no question of \"{questionnaire}\" has{near}")]
    UnknownQuestion {
        /// As it is written.
        condition: String,
        /// The name in it.
        name: String,
        /// The segment's questionnaire.
        questionnaire: String,
        /// The nearest that exists, as a question; empty where none is near.
        near: String,
    },
    /// A consent whose questionnaire does not ask for it.
    #[error("the questionnaire \"{0}\" of a consent has no required question \"agree\" of type boolean")]
    NoAgreement(String),
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none, for no questionnaire here has scores".into() } else { names.join(", ") }
}

/// The question of a consent.
const AGREE: &str = "agree";

impl ScoreLimit {
    /// The limit as it stands for the questionnaire `word`: the name of the score in it.
    fn score_of<'a>(&'a self, segment: &StudySegment, word: &str) -> Option<&'a str> {
        if segment.has_drives() {
            self.score.strip_prefix(&short_name(word))?.strip_prefix('.')
        } else {
            Some(&self.score)
        }
    }
}

impl StudySegment {
    /// What ends a session here, and what is asked for it while driving, in sentences for a plan.
    pub fn early_end_words(&self) -> Vec<String> {
        let mut all = Vec::new();
        let mut say = |what: String| all.push(format!("`{}`: {what}", self.name));
        if self.kind == SegmentKind::Consent {
            say("the session ends if the participant does not consent.".into());
        }
        for condition in &self.ends_if {
            say(format!("the session ends if the answers say `{condition}`."));
        }
        if let Some(every_s) = self.fms_every_s {
            say(format!(
                "every {every_s} s of a drive the participant rates sickness on the fast motion sickness scale, 0 to {} (Keshavarz and \
                 Hecht 2011), with {} s to answer.",
                fms::HIGHEST,
                fms::ANSWER_S
            ));
        }
        if let Some(ScoreLimit { score, value }) = &self.stop_above {
            let at_once = if score == fms::SCORE { " at that moment of the drive" } else { "" };
            say(format!("the session ends{at_once} if the score `{score}` is above {value}."));
        }
        all
    }
}

impl Study {
    /// Whether the rules of every segment can be followed. The key at fault and what is wrong.
    pub(super) fn check_rules(&self) -> Result<(), (String, RuleFault)> {
        for (i, segment) in self.file.segment.iter().enumerate() {
            let fault = |key: &str, fault: RuleFault| (format!("segment.{i}.{key}"), fault);
            let asked: Vec<(&str, &Questionnaire)> =
                segment.questionnaires().into_iter().map(|(_, word)| (word, &self.questionnaires[word])).collect();
            if let Some(limit) = &segment.stop_above {
                let named = |word: &str, score: &str| {
                    if segment.has_drives() { format!("{}.{score}", short_name(word)) } else { score.into() }
                };
                let known: Vec<String> = asked
                    .iter()
                    .flat_map(|(word, questionnaire)| questionnaire.scores.iter().map(|s| named(word, &s.name)))
                    .collect();
                let is_fms = segment.has_drives() && limit.score == fms::SCORE;
                if is_fms && segment.fms_every_s.is_none() {
                    return Err(fault("stop_above.score", RuleFault::FmsNotAsked));
                }
                if is_fms && !(0.0..f64::from(fms::HIGHEST)).contains(&limit.value) {
                    return Err(fault("stop_above.value", RuleFault::FmsValue(limit.value)));
                }
                let known: Vec<String> =
                    known.into_iter().chain(segment.fms_every_s.map(|_| fms::SCORE.to_owned())).collect();
                if !known.contains(&limit.score) {
                    let near = toml_text::did_you_mean(&limit.score, &known);
                    return Err(fault(
                        "stop_above.score",
                        RuleFault::UnknownScore { score: limit.score.clone(), known, near },
                    ));
                }
                if !limit.value.is_finite() {
                    return Err(fault("stop_above.value", RuleFault::Value(limit.value)));
                }
            }
            let Some((word, questionnaire)) = asked.first().filter(|_| !segment.has_drives()) else { continue };
            for (k, condition) in segment.ends_if.iter().enumerate() {
                let key = format!("ends_if.{k}");
                let parsed = VisibilityCondition::parse(condition)
                    .map_err(|_| fault(&key, RuleFault::Condition(condition.clone())))?;
                let names = questionnaire.answer_names();
                if let Some(name) = parsed.names().find(|name| !names.iter().any(|known| known == name)) {
                    let near = toml_text::did_you_mean(name, &names);
                    let (condition, name) = (condition.clone(), name.to_owned());
                    let questionnaire = (*word).to_owned();
                    return Err(fault(&key, RuleFault::UnknownQuestion { condition, name, questionnaire, near }));
                }
            }
            if segment.kind == SegmentKind::Consent && !questionnaire.asks_agreement(AGREE) {
                return Err(fault("questionnaire", RuleFault::NoAgreement((*word).to_owned())));
            }
        }
        Ok(())
    }

    /// The segment of an item.
    pub fn segment_of(&self, planned: &PlannedItem) -> Option<&StudySegment> {
        self.file.segment.iter().find(|segment| segment.name == planned.segment)
    }

    /// True if the item asks for consent: the experimenter cannot leave it out.
    pub fn is_consent(&self, planned: &PlannedItem) -> bool {
        self.segment_of(planned).is_some_and(|segment| segment.kind == SegmentKind::Consent)
    }

    /// The end of the session that an answer while driving means, if it means one.
    pub fn ending_of_rating(&self, planned: &PlannedItem, rating: &FmsRating) -> Option<SessionEnding> {
        let segment = self.segment_of(planned)?;
        let limit = segment.stop_above.as_ref().filter(|limit| limit.score == fms::SCORE)?;
        let value = rating.value.filter(|value| f64::from(*value) > limit.value)?;
        let reason = format!("{}: {} is {value}, above {} (stop_above)", planned.name, limit.score, limit.value);
        let words = segment.stop_text.clone().unwrap_or_else(|| self.file.texts.score_limit.clone());
        Some(SessionEnding { cause: EndCause::ScoreLimit, reason, words })
    }

    /// The end of the session that these answers to an item mean, if they mean one.
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
        // Sums of decimal weights end in 3e-15 otherwise.
        let value = (value * 1e6).round() / 1e6;
        let reason = format!("{}: {} is {value}, above {} (stop_above)", planned.name, limit.score, limit.value);
        ending(EndCause::ScoreLimit, reason, &texts.score_limit)
    }
}

#[cfg(test)]
#[path = "stop_rule_tests.rs"]
mod tests;
