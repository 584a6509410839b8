//! Plan of a study's analysis, written before the first participant. In: the table `[analysis]` of a study's file. Out: an
//! [`AnalysisPlan`], checked, and its differences from the plan at the start of the data set.

pub use crate::analysis::data::statements::CHANGED;

use crate::analysis::{data::statements::BEGUN, error::AnalysisError, measures::MEASURES};
use crate::metrics::{Measure, RoadKinds};
use crate::{
    file::{SETTINGS_BYTES, read_text},
    scenario::Scenario,
    toml_text::{self, KeyPart, did_you_mean},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::{collections::BTreeMap, path::Path};

/// Plan of the analysis: one model per outcome, response = condition + place + covariates + participant as random intercept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnalysisPlan {
    /// Primary measure, by its name in the table of trials.
    pub primary: String,
    /// Smallest difference of interest between two conditions, in the unit of the primary measure, above 0.
    pub smallest_effect: f64,
    /// Differences to test: a condition less its reference.
    pub contrasts: Vec<PlannedContrast>,
    /// Secondary measures, by their names.
    #[serde(default)]
    pub secondary: Vec<String>,
    /// Measures of the state at the start of a trial, by their names; each is a covariate in every model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub covariates: Vec<String>,
    /// Two-sided level of significance over all tests of the plan (Holm's correction).
    #[serde(default = "alpha")]
    #[schemars(range(min = 0.001, max = 0.2))]
    pub alpha: f64,
    /// Rules that leave trials and participants out of the models.
    #[serde(default)]
    pub exclude: ExclusionRules,
}

fn alpha() -> f64 {
    0.05
}

/// Difference between two conditions: `condition` less `reference`, each by its name (levels joined by `+`).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlannedContrast {
    /// Condition that is compared, by its name.
    pub condition: String,
    /// Condition that it is compared with, by its name.
    pub reference: String,
    /// Sign that the difference of the primary measure is expected to have; the test is two-sided in any case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<ExpectedSign>,
}

/// Expected sign of a difference, condition less reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ExpectedSign {
    /// The measure is greater in the condition.
    Greater,
    /// The measure is less in the condition.
    Less,
}

impl PlannedContrast {
    /// Returns the difference in signs: `wide − narrow`.
    pub fn label(&self) -> String {
        format!("{} − {}", self.condition, self.reference)
    }
}

/// Rules that leave out trials and participants; a rule that is not given leaves nothing out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ExclusionRules {
    /// Smallest recorded share of a trial's planned length, 0 to 1; trials below it are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub least_recorded_share: Option<f64>,
    /// Largest number of contacts with other vehicles in a trial; trials above it are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most_contacts: Option<u32>,
    /// Largest share of a trial's length given up because frames came too late (`dropped_s`), 0 to 1; trials above it are left
    /// out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub most_dropped_share: Option<f64>,
    /// Smallest number of remaining trials of a participant; participants below it are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_trials: Option<u32>,
    /// Leave out participants whose session was not completed.
    pub only_complete_sessions: bool,
}

impl ExclusionRules {
    /// Returns a sentence for each rule that is given.
    pub fn sentences(&self) -> Vec<String> {
        let share = self.least_recorded_share.map(|share| {
            format!("A trial is left out if less than {} % of its planned length was recorded.", 100.0 * share)
        });
        let contacts = self.most_contacts.map(|most| match most {
            0 => "A trial is left out if there was a contact with another vehicle.".into(),
            1 => "A trial is left out if there was more than one contact with other vehicles.".into(),
            most => format!("A trial is left out if there were more than {most} contacts with other vehicles."),
        });
        let dropped = self.most_dropped_share.map(|share| {
            format!(
                "A trial is left out if more than {} % of its length was given up because pictures came too late.",
                100.0 * share
            )
        });
        let trials = self.least_trials.map(|least| match least {
            1 => "A participant is left out if no trial remains after these rules.".into(),
            least => format!("A participant is left out if fewer than {least} trials remain after these rules."),
        });
        let complete = self
            .only_complete_sessions
            .then(|| "A participant is left out if the session was not completed.".to_owned());
        [share, contacts, dropped, complete, trials].into_iter().flatten().collect()
    }
}

/// Test of a plan: an outcome and a contrast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedTest<'a> {
    /// Outcome, by the name of its measure.
    pub outcome: &'a str,
    /// Difference that is tested.
    pub contrast: &'a PlannedContrast,
}

impl PlannedTest<'_> {
    /// Returns these tests in words: `Reaction time: advice − none`.
    pub fn list(tests: &[Self]) -> String {
        let title = |name: &str| {
            MEASURES.iter().find(|measure| measure.name == name).map_or(name.to_owned(), |one| one.title.into())
        };
        let words = |test: &Self| format!("{}: {}", title(test.outcome), test.contrast.label());
        tests.iter().map(words).collect::<Vec<_>>().join("; ")
    }
}

/// Properties of a condition that decide which measures its trials can have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConditionKind {
    /// True if a speed is advised.
    pub has_advice: bool,
    /// Roads of the condition.
    pub roads: RoadKinds,
}

impl ConditionKind {
    /// Returns the kind of a trial with this policy on this scenario, that of a planned drive.
    pub fn of(policy: &str, scenario: &Scenario) -> Self {
        let has_advice = policy != "none" && !scenario.advises_no_vehicle();
        Self { has_advice, roads: RoadKinds::of_drive(scenario.has_path_or_demand()) }
    }

    /// Returns the kind of a condition with trials of both kinds.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { has_advice: self.has_advice || other.has_advice, roads: self.roads.and(other.roads) }
    }

    fn may_have(&self, measure: &Measure) -> bool {
        (self.has_advice || !measure.needs_advice) && measure.is_on(self.roads)
    }
}

/// A mistake in a plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct PlanFault {
    /// Key of the mistake, such as `analysis.primary`.
    pub key: String,
    /// Message with value, allowed values, and remedy.
    pub message: String,
}

impl AnalysisPlan {
    /// Checks the plan for a study with these conditions.
    ///
    /// # Errors
    /// Returns the first mistake.
    pub fn check(&self, conditions: &[&str]) -> Result<(), PlanFault> {
        let fault = |key: String, message: String| Err(PlanFault { key: format!("analysis.{key}"), message });
        self.check_outcomes()?;
        if !(self.smallest_effect.is_finite() && self.smallest_effect > 0.0) {
            let text = format!("smallest_effect is {}; allowed: a number above 0", self.smallest_effect);
            return fault("smallest_effect".into(), text);
        }
        if !(0.001..=0.2).contains(&self.alpha) {
            return fault("alpha".into(), format!("alpha is {}; allowed: a number from 0.001 to 0.2", self.alpha));
        }
        if self.contrasts.is_empty() {
            let text = "there is no contrast; name one or more: { condition = \"...\", reference = \"...\" }";
            return fault("contrasts".into(), text.into());
        }
        for (i, contrast) in self.contrasts.iter().enumerate() {
            for (key, name) in [("condition", &contrast.condition), ("reference", &contrast.reference)] {
                if !conditions.contains(&name.as_str()) {
                    let near = did_you_mean(name, conditions);
                    let known = if conditions.is_empty() {
                        "none, as there are no conditions".into()
                    } else {
                        conditions.join(", ")
                    };
                    let text = format!("there is no condition \"{name}\"{near}; allowed: {known}");
                    return fault(format!("contrasts.{i}.{key}"), text);
                }
            }
            if contrast.condition == contrast.reference {
                let text = format!("\"{}\" is compared with itself; name another condition", contrast.condition);
                return fault(format!("contrasts.{i}.reference"), text);
            }
            let pair = (&contrast.condition, &contrast.reference);
            let same = |other: &PlannedContrast| {
                pair == (&other.condition, &other.reference) || pair == (&other.reference, &other.condition)
            };
            if self.contrasts[..i].iter().any(same) {
                return fault(format!("contrasts.{i}"), format!("{} comes twice; name it once", contrast.label()));
            }
        }
        let shares = [
            ("least_recorded_share", self.exclude.least_recorded_share),
            ("most_dropped_share", self.exclude.most_dropped_share),
        ];
        for (key, share) in shares {
            if let Some(share) = share.filter(|share| !(0.0..=1.0).contains(share)) {
                return fault(format!("exclude.{key}"), format!("{key} is {share}; allowed: a number from 0 to 1"));
            }
        }
        if let Some(least) = self.exclude.least_trials.filter(|least| *least as usize > conditions.len()) {
            let text = format!("least_trials is {least}; allowed: at most the {} conditions", conditions.len());
            return fault("exclude.least_trials".into(), text);
        }
        Ok(())
    }

    /// Checks that outcomes and covariates are measures, each named once.
    fn check_outcomes(&self) -> Result<(), PlanFault> {
        let fault = |key: String, message: String| Err(PlanFault { key: format!("analysis.{key}"), message });
        let names: Vec<&str> = MEASURES.iter().map(|measure| measure.name).collect();
        let mut all = self.outcomes();
        let outcomes = all.len();
        all.extend(self.covariates.iter().map(String::as_str));
        for (i, name) in all.iter().enumerate() {
            let key = match i {
                0 => "primary".into(),
                i if i < outcomes => format!("secondary.{}", i - 1),
                i => format!("covariates.{}", i - outcomes),
            };
            if !names.contains(name) {
                let near = did_you_mean(name, &names);
                return fault(
                    key,
                    format!(
                        "there is no measure \"{name}\"{near}; allowed: a column of measures of trials.csv: {}",
                        names.join(", ")
                    ),
                );
            }
            if all[..i].contains(name) {
                return fault(key, format!("the measure \"{name}\" comes twice; name it once"));
            }
        }
        Ok(())
    }

    /// Returns the model's formula with the covariates: `measure ~ condition + place + (1 | participant)`.
    pub fn formula(&self) -> String {
        let covariates: String = self.covariates.iter().map(|name| format!(" + {name}")).collect();
        format!("measure ~ condition + place{covariates} + (1 | participant)")
    }

    /// Returns all outcomes, the primary one first.
    pub fn outcomes(&self) -> Vec<&str> {
        [self.primary.as_str()].into_iter().chain(self.secondary.iter().map(String::as_str)).collect()
    }

    /// Returns all outcomes with all contrasts: first the tests that can be made in conditions of these kinds, then those that
    /// cannot, because no trial of one of the two conditions has the measure. A condition of unknown kind may have every
    /// measure.
    pub fn tests(&self, kinds: &BTreeMap<String, ConditionKind>) -> [Vec<PlannedTest<'_>>; 2] {
        let each = self.outcomes().into_iter();
        let all = each.flat_map(|outcome| self.contrasts.iter().map(move |contrast| PlannedTest { outcome, contrast }));
        let (made, impossible) = all.partition(|test| {
            let measure = MEASURES.iter().find(|measure| measure.name == test.outcome);
            let names = [&test.contrast.condition, &test.contrast.reference];
            names
                .into_iter()
                .filter_map(|name| kinds.get(name))
                .all(|kind| measure.is_some_and(|one| kind.may_have(one)))
        });
        [made, impossible]
    }

    /// Reads the plan from a study's file, ignoring its other tables; `name` is the file in messages.
    ///
    /// # Errors
    /// The file is not TOML, or its plan does not have this program's format.
    pub fn in_study(text: &str, name: &str) -> Result<Option<Self>, AnalysisError> {
        #[derive(Deserialize)]
        struct StudyPart {
            analysis: Option<AnalysisPlan>,
        }
        let part: StudyPart = toml_text::parse(text, name).map_err(|why| AnalysisError::Input(why.to_string()))?;
        Ok(part.analysis)
    }
}

/// Plan of a data set at its first session, and now.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanHistory {
    /// Plan at the first session.
    pub begun: Option<AnalysisPlan>,
    /// Current plan, of the last session or a given file.
    pub now: Option<AnalysisPlan>,
}

impl PlanHistory {
    /// Reads the plans of the data set in `root`. The current plan is from the file `study` if given, else from the
    /// last session.
    ///
    /// # Errors
    /// A file cannot be read, or names a measure that does not exist.
    pub fn of(root: &Path, study: Option<&Path>) -> Result<Self, AnalysisError> {
        let read = |path: &Path| -> Result<Option<AnalysisPlan>, AnalysisError> {
            let name = path.display().to_string();
            let text = read_text(path, SETTINGS_BYTES)
                .map_err(|why| AnalysisError::Input(format!("{name}: cannot be read: {why}")))?;
            let plan = AnalysisPlan::in_study(&text, &name)?;
            let fault = |wrong: PlanFault| {
                AnalysisError::Input(toml_text::at(&text, &name, &wrong.key, KeyPart::Value, &wrong.message))
            };
            plan.as_ref().map_or(Ok(()), AnalysisPlan::check_outcomes).map_err(fault)?;
            Ok(plan)
        };
        let begun = root.join(BEGUN);
        let begun = if begun.exists() { read(&begun)? } else { None };
        let changed = root.join(CHANGED);
        let now = match study {
            Some(path) => read(path)?,
            None if changed.exists() => read(&changed)?,
            None => begun.clone(),
        };
        Ok(Self { begun, now })
    }

    /// Returns a sentence for each change after the first session: key, planned and current value.
    pub fn changes(&self) -> Vec<String> {
        match (&self.begun, &self.now) {
            (None, Some(_)) => {
                vec!["There was no analysis plan at the first session; the plan was written later.".into()]
            }
            (Some(_), None) => vec!["The analysis plan was removed after the first session.".into()],
            (begun, now) => {
                let [was, is] = [begun, now].map(|plan| flat(&serde_json::to_value(plan).unwrap_or_default()));
                let keys: std::collections::BTreeSet<&String> = was.keys().chain(is.keys()).collect();
                let value_text = |value: Option<&String>| value.map_or("not given".to_owned(), Clone::clone);
                let changed = keys.into_iter().filter(|key| was.get(*key) != is.get(*key));
                changed
                    .map(|key| format!("{key}: planned {}, now {}.", value_text(was.get(key)), value_text(is.get(key))))
                    .collect()
            }
        }
    }
}

/// Returns values by their keys, with keys of nested tables joined by a dot; lists stay as they are.
fn flat(value: &Value) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    let Value::Object(table) = value else { return all };
    for (key, value) in table {
        if value.is_object() {
            all.extend(flat(value).into_iter().map(|(inner, text)| (format!("{key}.{inner}"), text)));
        } else {
            all.insert(key.clone(), value.to_string());
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(text: &str) -> AnalysisPlan {
        AnalysisPlan::in_study(text, "x.toml").unwrap().unwrap()
    }

    const GOOD: &str = "title = \"any\"\n[analysis]\nprimary = \"mean_speed_mps\"\nsmallest_effect = 0.2\nsecondary = \
                        [\"reaction_s\"]\ncontrasts = [{ condition = \"wide\", reference = \"narrow\" }]\n[analysis.exclude]\n\
                        most_contacts = 0\n";

    #[test]
    fn every_mistake_has_its_key_and_says_what_is_allowed() {
        let conditions = ["narrow", "wide"];
        plan(GOOD).check(&conditions).unwrap();
        plan(&GOOD.replace("most_contacts = 0", "least_trials = 2")).check(&conditions).unwrap();
        for (from, to, key, has) in [
            ("\"mean_speed_mps\"", "\"mean_sped_mps\"", "analysis.primary", "did you mean mean_speed_mps"),
            ("\"reaction_s\"", "\"mean_speed_mps\"", "analysis.secondary.0", "comes twice"),
            (
                "= 0.2",
                "= 0.2\ncovariates = [\"hand_over_speed_sd_over_vehicles\"]",
                "analysis.covariates.0",
                "did you mean hand_over_speed_sd_over_vehicles_mps",
            ),
            ("= 0.2", "= 0.2\ncovariates = [\"reaction_s\"]", "analysis.covariates.0", "comes twice"),
            ("= 0.2", "= 0.0", "analysis.smallest_effect", "a number above 0"),
            ("= 0.2", "= 0.2\nalpha = 0.5", "analysis.alpha", "allowed: a number from 0.001 to 0.2"),
            (
                "reference = \"narrow\"",
                "reference = \"narow\"",
                "analysis.contrasts.0.reference",
                "did you mean narrow",
            ),
            ("reference = \"narrow\"", "reference = \"wide\"", "analysis.contrasts.0.reference", "with itself"),
            (
                "}]",
                "}, { condition = \"narrow\", reference = \"wide\" }]",
                "analysis.contrasts.1",
                "narrow − wide comes twice",
            ),
            ("most_contacts = 0", "least_trials = 3", "analysis.exclude.least_trials", "at most the 2 conditions"),
            ("most_contacts = 0", "least_recorded_share = 1.5", "analysis.exclude.least_recorded_share", "from 0 to 1"),
        ] {
            assert!(GOOD.contains(from), "{from}");
            let fault = plan(&GOOD.replacen(from, to, 1)).check(&conditions).unwrap_err();
            assert!(fault.key == key && fault.message.contains(has), "{fault:?}");
        }
    }

    #[test]
    fn changes_after_the_first_session_are_listed_by_key() {
        let begun = Some(plan(GOOD));
        let now = Some(plan(&GOOD.replace("= 0.2", "= 0.3").replace("most_contacts = 0", "least_trials = 2")));
        let history = PlanHistory { begun: begun.clone(), now };
        assert_eq!(
            history.changes(),
            [
                "exclude.least_trials: planned not given, now 2.",
                "exclude.most_contacts: planned 0, now not given.",
                "smallest_effect: planned 0.2, now 0.3."
            ]
        );
        assert!(PlanHistory { begun: begun.clone(), now: begun.clone() }.changes().is_empty());
        assert!(PlanHistory { now: begun, ..PlanHistory::default() }.changes()[0].contains("no analysis plan"));
        assert!(PlanHistory::default().changes().is_empty());
    }
}
