//! Plan of a study's analysis, written before the first participant. In: the table `[analysis]` of a study's file. Out: an
//! [`AnalysisPlan`], checked, and its differences from the plan at the start of the data set.

pub use crate::analysis::data::statements::CHANGED;

use super::{exclusion_rules::ExclusionRules, one_or_more::OneOrMore};
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
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// Plan of the analysis: one model per outcome, response = condition + place + covariates + participant as random intercept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnalysisPlan {
    /// Primary measure, by its name in the table of trials, or a list of them.
    pub primary: OneOrMore<String>,
    /// Smallest difference of interest between two conditions, in the unit of the primary measure, above 0; with several primary
    /// measures a list, one for each.
    pub smallest_effect: OneOrMore<f64>,
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
    /// Sign that the difference of the primary measure is expected to have; with several primary measures a list, one for each.
    /// The test is two-sided in any case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<OneOrMore<ExpectedSign>>,
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

    /// Returns the expected sign of the difference of a primary measure, by its place among them.
    pub fn expected_sign(&self, primary: usize) -> Option<ExpectedSign> {
        self.expected.as_ref()?.all().get(primary).copied()
    }
}

/// Test of a plan: an outcome and a contrast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedTest<'a> {
    /// Outcome, by the name of its measure.
    pub outcome: &'a str,
    /// True for a primary outcome.
    pub is_primary: bool,
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

impl PlanFault {
    /// Makes the mistake at a key below `analysis`.
    fn new(key: &str, message: String) -> Self {
        Self { key: format!("analysis.{key}"), message }
    }
}

impl AnalysisPlan {
    /// Returns the mistakes of the plan for a study with these conditions.
    pub fn faults(&self, conditions: &[&str]) -> Vec<PlanFault> {
        let mut faults = [self.outcome_faults(), self.effect_faults()].concat();
        let mut add = |key: &str, message: String| faults.push(PlanFault::new(key, message));
        if !(0.001..=0.2).contains(&self.alpha) {
            add("alpha", format!("alpha is {}; allowed: a number from 0.001 to 0.2", self.alpha));
        }
        if self.contrasts.is_empty() {
            let text = "there is no contrast; name one or more: { condition = \"...\", reference = \"...\" }";
            add("contrasts", text.into());
        }
        for (i, contrast) in self.contrasts.iter().enumerate() {
            let ends = [("condition", &contrast.condition), ("reference", &contrast.reference)];
            for (key, name) in ends.into_iter().filter(|(_, name)| !conditions.contains(&name.as_str())) {
                let near = did_you_mean(name, conditions);
                let known = if conditions.is_empty() {
                    "none, as there are no conditions".into()
                } else {
                    conditions.join(", ")
                };
                let text = format!("there is no condition \"{name}\"{near}; allowed: {known}");
                add(&format!("contrasts.{i}.{key}"), text);
            }
            let pair = (&contrast.condition, &contrast.reference);
            let same = |other: &PlannedContrast| {
                pair == (&other.condition, &other.reference) || pair == (&other.reference, &other.condition)
            };
            if contrast.condition == contrast.reference {
                let text = format!("\"{}\" is compared with itself; name another condition", contrast.condition);
                add(&format!("contrasts.{i}.reference"), text);
            } else if self.contrasts[..i].iter().any(same) {
                add(&format!("contrasts.{i}"), format!("{} comes twice; name it once", contrast.label()));
            }
        }
        let shares = [
            ("least_recorded_share", self.exclude.least_recorded_share),
            ("most_dropped_share", self.exclude.most_dropped_share),
        ];
        for (key, share) in shares {
            if let Some(share) = share.filter(|share| !(0.0..=1.0).contains(share)) {
                add(&format!("exclude.{key}"), format!("{key} is {share}; allowed: a number from 0 to 1"));
            }
        }
        if let Some(least) = self.exclude.least_trials.filter(|least| *least as usize > conditions.len()) {
            let text = format!("least_trials is {least}; allowed: at most the {} conditions", conditions.len());
            add("exclude.least_trials", text);
        }
        faults
    }

    /// Returns the mistakes of numbers of effects and signs: each primary outcome has a smallest effect, each contrast as many expected
    /// signs or none.
    fn effect_faults(&self) -> Vec<PlanFault> {
        let primary = self.primary.all().len();
        // A measure that is missing or comes twice is a mistake of its own.
        let is_counted = primary > 0 && self.primary.all().iter().collect::<BTreeSet<_>>().len() == primary;
        let s = if primary == 1 { "" } else { "s" };
        let one_each = format!("one for each of the {primary} primary measure{s}");
        let effects = self.smallest_effect.all();
        let mut faults = Vec::new();
        let mut add = |key: &str, message: String| faults.push(PlanFault::new(key, message));
        if is_counted && effects.len() != primary {
            let text = format!("smallest_effect has the wrong length, {}; allowed: {one_each}", effects.len());
            add("smallest_effect", text);
        } else if let Some(effect) = effects.iter().find(|effect| !(effect.is_finite() && **effect > 0.0)) {
            add("smallest_effect", format!("smallest_effect is {effect}; allowed: a number above 0"));
        }
        for (i, contrast) in self.contrasts.iter().enumerate() {
            let signs = contrast.expected.as_ref().map_or(primary, |signs| signs.all().len());
            if is_counted && signs != primary {
                let text = format!("expected has the wrong length, {signs}; allowed: {one_each}");
                add(&format!("contrasts.{i}.expected"), text);
            }
        }
        faults
    }

    /// Returns the mistakes of outcomes and covariates, which are measures, each named once.
    fn outcome_faults(&self) -> Vec<PlanFault> {
        let names: Vec<&str> = MEASURES.iter().map(|measure| measure.name).collect();
        let primary = self.primary.all().len();
        let mut faults = Vec::new();
        let mut add = |key: &str, message: String| faults.push(PlanFault::new(key, message));
        if primary == 0 {
            add("primary", "there is no primary measure; name one or more".into());
        }
        let mut all = self.outcomes();
        let outcomes = all.len();
        all.extend(self.covariates.iter().map(String::as_str));
        for (i, name) in all.iter().enumerate() {
            let key = match (i, &self.primary) {
                (_, OneOrMore::One(_)) if i == 0 => "primary".into(),
                _ if i < primary => format!("primary.{i}"),
                _ if i < outcomes => format!("secondary.{}", i - primary),
                _ => format!("covariates.{}", i - outcomes),
            };
            if !names.contains(name) {
                let (near, known) = (did_you_mean(name, &names), names.join(", "));
                let list = format!("a column of measures of trials.csv: {known}");
                add(&key, format!("there is no measure \"{name}\"{near}; allowed: {list}"));
            } else if all[..i].contains(name) {
                add(&key, format!("the measure \"{name}\" comes twice; name it once"));
            }
        }
        faults
    }

    /// Returns the model's formula with the covariates: `measure ~ condition + place + (1 | participant)`.
    pub fn formula(&self) -> String {
        let covariates: String = self.covariates.iter().map(|name| format!(" + {name}")).collect();
        format!("measure ~ condition + place{covariates} + (1 | participant)")
    }

    /// Returns all outcomes, the primary ones first.
    pub fn outcomes(&self) -> Vec<&str> {
        self.primary.all().iter().chain(&self.secondary).map(String::as_str).collect()
    }

    /// Returns true for the name of a primary outcome.
    pub fn is_primary(&self, outcome: &str) -> bool {
        self.primary.all().iter().any(|name| name == outcome)
    }

    /// Returns the smallest difference of interest of a primary outcome, by its place among them.
    pub fn effect(&self, primary: usize) -> f64 {
        self.smallest_effect.all().get(primary).copied().unwrap_or(f64::NAN)
    }

    /// Returns all outcomes with all contrasts: first the tests that can be made in conditions of these kinds, then those that
    /// cannot, because no trial of one of the two conditions has the measure. A condition of unknown kind may have every
    /// measure. The preregistration lists these tests, and the analysis makes them, in this order.
    pub fn tests(&self, kinds: &BTreeMap<String, ConditionKind>) -> [Vec<PlannedTest<'_>>; 2] {
        let each = self.outcomes().into_iter();
        let all = each.flat_map(|outcome| {
            let is_primary = self.is_primary(outcome);
            self.contrasts.iter().map(move |contrast| PlannedTest { outcome, is_primary, contrast })
        });
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
    /// The file is not TOML, its plan does not have this program's format, or names a measure that does not exist. The message has all
    /// mistakes.
    pub fn in_study(text: &str, name: &str) -> Result<Option<Self>, AnalysisError> {
        #[derive(Deserialize)]
        struct StudyPart {
            analysis: Option<AnalysisPlan>,
        }
        let (part, mut mistakes) = toml_text::read::<StudyPart>(text, name);
        let plan = part.map(|part| part.analysis);
        for wrong in plan.iter().flatten().flat_map(Self::outcome_faults) {
            mistakes.add(&wrong.key, KeyPart::Value, &wrong.message);
        }
        toml_text::finished((plan, mistakes)).map_err(|why| AnalysisError::Input(why.to_string()))
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
            AnalysisPlan::in_study(&text, &name)
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
                let keys: BTreeSet<&String> = was.keys().chain(is.keys()).collect();
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
        text.parse::<toml::Table>().unwrap()["analysis"].clone().try_into().unwrap()
    }

    const GOOD: &str = "title = \"any\"\n[analysis]\nprimary = \"mean_speed_mps\"\nsmallest_effect = 0.2\nsecondary = \
                        [\"reaction_s\"]\ncontrasts = [{ condition = \"wide\", reference = \"narrow\" }]\n[analysis.exclude]\n\
                        most_contacts = 0\n";

    #[test]
    fn every_mistake_has_its_key_and_says_what_is_allowed() {
        let conditions = ["narrow", "wide"];
        assert_eq!(plan(GOOD).faults(&conditions), []);
        assert_eq!(plan(&GOOD.replace("most_contacts = 0", "least_trials = 2")).faults(&conditions), []);
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
            ("= 0.2", "= [0.2, 0.2]", "analysis.smallest_effect", "length, 2; allowed: one for each of the 1 primary"),
            (
                "\"narrow\" }",
                "\"narrow\", expected = [\"less\", \"less\"] }",
                "analysis.contrasts.0.expected",
                "length, 2; allowed: one for each",
            ),
            ("\"mean_speed_mps\"", "[]", "analysis.primary", "there is no primary measure"),
            (
                "\"mean_speed_mps\"",
                "[\"mean_speed_mps\", \"mean_speed_mps\"]",
                "analysis.primary.1",
                "comes twice; name it once",
            ),
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
            let faults = plan(&GOOD.replacen(from, to, 1)).faults(&conditions);
            assert!(faults.len() == 1 && faults[0].key == key && faults[0].message.contains(has), "{faults:?}");
        }
    }

    #[test]
    fn a_plan_with_several_mistakes_names_all() {
        let many = [
            ("\"mean_speed_mps\"", "\"mean_sped_mps\""),
            ("= 0.2", "= 0.0\nalpha = 0.5"),
            ("contacts = 0", "dropped_share = 2"),
        ];
        let text = many.iter().fold(GOOD.to_owned(), |text, (from, to)| text.replacen(from, to, 1));
        let faults = plan(&text).faults(&["narrow"]);
        let keys: Vec<&str> = faults.iter().map(|fault| fault.key.trim_start_matches("analysis.")).collect();
        assert_eq!(
            keys,
            ["primary", "smallest_effect", "alpha", "contrasts.0.condition", "exclude.most_dropped_share"]
        );
        let report =
            AnalysisPlan::in_study(&text.replace("reaction_s", "reaction_ms"), "x.toml").unwrap_err().to_string();
        assert!(report.contains("x.toml:3:11: ") && report.contains("x.toml:6:"), "{report}");
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
