//! Scores of questionnaires. In: definitions from a questionnaire's file, answers. Out: numbers; none while an answer is missing.

use super::{
    question_fault::QuestionFault,
    questions::{Answers, ElementKind, Questionnaire, number, one},
};
use crate::toml_text;
use serde::{Deserialize, Serialize};

/// Score computed from answers: `weight` times the sum, mean or weighted mean of the answers to `of`, plus `offset`. Missing while one of
/// the answers is missing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScoreDefinition {
    /// Name of the score in the data.
    pub name: String,
    /// Sum, mean or weighted mean.
    pub method: ScoreMethod,
    /// Names of questions; `name.row` for a row of a matrix.
    pub of: Vec<String>,
    /// Reverse-scored items of `of`: each counts as the scale's lowest plus highest point minus the answer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub turned: Vec<String>,
    /// Questions whose answers are names of questions in `of` (weighted only): each answer adds one to the weight of that question.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by: Vec<String>,
    /// Factor of the sum or mean.
    #[serde(default = "one")]
    pub weight: f64,
    /// Constant that is added last.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub offset: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Method that combines the answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ScoreMethod {
    /// Sum of the answers.
    Sum,
    /// Mean of the answers.
    Mean,
    /// Mean weighted by the participant: each answer times the number of `by` answers that name its question, summed, divided by the
    /// number of questions in `by`.
    Weighted,
}

impl std::fmt::Display for ScoreDefinition {
    /// Describes the computation, for a sidecar.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let how = match self.method {
            ScoreMethod::Sum => "sum",
            ScoreMethod::Mean => "mean",
            ScoreMethod::Weighted => "weighted mean",
        };
        let mut text = format!("score: {} times the {how} of {}", self.weight, self.of.join(", "));
        if !self.turned.is_empty() {
            text += &format!("; turned round: {}", self.turned.join(", "));
        }
        if !self.by.is_empty() {
            text += &format!("; weight: number of times that each is the answer to {}", self.by.join(", "));
        }
        if self.offset != 0.0 {
            text += &format!("; {} added", self.offset);
        }
        f.write_str(&text)
    }
}

impl Questionnaire {
    /// Checks that every score can be computed.
    pub(super) fn check_scores(&self) -> Result<(), QuestionFault> {
        let answers = self.answer_names();
        for score in &self.scores {
            if let Some(missing) = score.of.iter().chain(&score.by).find(|name| !answers.contains(name)) {
                let near = toml_text::did_you_mean(missing, &answers);
                return Err(QuestionFault::UnknownScore { score: score.name.clone(), name: missing.clone(), near });
            }
            if (score.method == ScoreMethod::Weighted) == score.by.is_empty() {
                return Err(QuestionFault::Weights(score.name.clone()));
            }
            let no_end = |name: &&String| !score.of.contains(name) || self.ends(name).is_none();
            if let Some(name) = score.turned.iter().find(no_end) {
                return Err(QuestionFault::Turned { score: score.name.clone(), name: name.clone() });
            }
        }
        Ok(())
    }

    /// Returns the lowest and highest point of an answer's scale; `None` if the scale has no numbers.
    fn ends(&self, name: &str) -> Option<[f64; 2]> {
        let mut elements = self.pages.iter().flat_map(|page| &page.elements);
        let element = elements.find(|element| element.answer_names().iter().any(|answer| answer == name))?;
        match element.kind {
            ElementKind::Rating => Some([element.rate_min, element.rate_max]),
            ElementKind::Matrix => {
                let numbers: Option<Vec<f64>> = element.columns.iter().map(|column| column.value.as_f64()).collect();
                let end = |pick: fn(f64, f64) -> f64| numbers.iter().flatten().copied().reduce(pick);
                Some([end(f64::min)?, end(f64::max)?])
            }
            _ => None,
        }
    }

    /// Returns the scores of these answers by name; `None` while an answer is missing or not a number.
    pub fn scores(&self, answers: &Answers) -> Vec<(String, Option<f64>)> {
        self.scores.iter().map(|score| (score.name.clone(), self.score(score, answers))).collect()
    }

    fn score(&self, score: &ScoreDefinition, answers: &Answers) -> Option<f64> {
        let value = |name: &String| {
            let value = answers.get(name).and_then(|v| number(v).or_else(|| v.as_bool().map(f64::from)))?;
            if !score.turned.contains(name) {
                return Some(value);
            }
            self.ends(name).map(|[low, high]| low + high - value)
        };
        let values: Vec<f64> = score.of.iter().map(value).collect::<Option<_>>()?;
        let count = values.len().max(1) as f64;
        let figure = match score.method {
            ScoreMethod::Sum => values.iter().sum(),
            ScoreMethod::Mean => values.iter().sum::<f64>() / count,
            ScoreMethod::Weighted => {
                let named: Vec<&str> =
                    score.by.iter().map(|name| answers.get(name)?.as_str()).collect::<Option<_>>()?;
                let weight = |name: &String| named.iter().filter(|word| *word == name).count() as f64;
                let sum: f64 = score.of.iter().zip(&values).map(|(name, value)| weight(name) * value).sum();
                sum / named.len() as f64
            }
        };
        Some(score.weight * figure + score.offset)
    }
}
