//! Conditions of a study, and the drives that result. In: base settings, segments and factors of the study file. Out: the [`Scenario`] of
//! every drive, tested to start; or the setting at fault, with its place in the file.

use super::{
    Study, StudyError, dial,
    file::{ConditionLevel, StudyFile},
    segment::{SegmentKind, SettingChanges},
};
use crate::{
    analysis::models::plan::ConditionKind,
    driver,
    map::MapError,
    policy::ResolvedPolicy,
    scenario::{self, Scenario, scripted_event},
    settings::{self, Field},
    sim::CheckedDrive,
    toml_text::{self, KeyPart, Mistakes},
};
use serde_json::Value;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

/// One condition of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Name: the names of its levels, joined by `+`.
    pub name: String,
    /// Level of each factor, by the factor's name. The key is `condition` if there are no factors.
    pub levels: BTreeMap<String, String>,
    /// Changed settings, each with its key in the study file.
    changes: Vec<(String, SettingChanges)>,
}

/// A setting that cannot be used, with its key in the study file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WrongSetting {
    key: String,
    part: KeyPart,
    message: String,
    /// True for a setting that is wrong beside others only.
    is_relation: bool,
}

impl WrongSetting {
    /// Returns the whole message, with file, line and column.
    pub(super) fn located(&self, text: &str, name: &str) -> StudyError {
        StudyError(toml_text::at(text, name, &self.key, self.part, &self.message))
    }
}

/// Facts about a study's drives, collected by starting each drive once.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ExpectedDrives {
    /// Highest speed expected in any trial, m/s.
    pub top_mps: f64,
    /// Resolved policies, by the names of map and policy.
    pub policies: BTreeMap<[String; 2], ResolvedPolicy>,
    /// Drives of roads on which vehicles enter and leave, with the path and the traffic of the road itself, by the names of map and path.
    pub networks: BTreeMap<[String; 2], Scenario>,
    /// Kinds of the conditions, by their names.
    pub kinds: BTreeMap<String, ConditionKind>,
    /// Files that the drives read.
    pub files: BTreeSet<PathBuf>,
}

impl Study {
    /// Sets the scenario that all drives begin from, and checks the settings that segments and conditions change.
    pub(super) fn check_settings(&mut self, mistakes: &mut Mistakes) {
        let mut read = |scenario: &Scenario, key: &str, changes: &SettingChanges| {
            let changed = changed(scenario, key, changes, &self.folder);
            changed.unwrap_or_else(|faults| {
                for WrongSetting { key, part, message, is_relation } in faults {
                    // Settings may contradict others only because one of these is wrong.
                    let others: &[&str] =
                        if is_relation && !key.starts_with("base.") { &["base", "segment"] } else { &[] };
                    mistakes.add_related(&key, others, part, &message);
                }
                scenario.clone()
            })
        };
        let base = read(&Scenario::default(), "base", &self.file.base);
        for (i, segment) in self.file.segment.iter().enumerate() {
            let scenario = read(&base, &format!("segment.{i}.set"), &segment.set);
            if segment.kind == SegmentKind::Trials {
                for (key, changes) in self.conditions.iter().flat_map(|condition| &condition.changes) {
                    read(&scenario, key, changes);
                }
            }
        }
        self.base = base;
    }

    /// Checks that every drive of every condition can start, by starting each as far as it takes no time.
    pub(super) fn check_drives(&self, name: &str) -> Result<ExpectedDrives, StudyError> {
        let mut expected = ExpectedDrives::default();
        for (i, segment) in self.file.segment.iter().enumerate() {
            let none = [None];
            let all: Vec<Option<&Condition>> = self.conditions.iter().map(Some).collect();
            let conditions: &[Option<&Condition>] = match segment.kind {
                SegmentKind::Drive => &none,
                SegmentKind::Trials => &all,
                SegmentKind::Text | SegmentKind::Consent | SegmentKind::Questions | SegmentKind::Break => &[],
            };
            for condition in conditions {
                let begun = self.drive(i, *condition).and_then(|scenario| {
                    let checked = self.checked(i, *condition, &scenario)?;
                    self.check_skills(i, &checked)?;
                    let resolved = Scenario { policy: checked.policy.name.clone(), ..scenario.clone() };
                    let wrong = |why: MapError| self.wrong(i, *condition, &["map"], why.to_string());
                    expected.files.extend(resolved.files().map_err(wrong)?.into_iter().flat_map(|(_, files)| files));
                    Ok((scenario, checked))
                });
                let (Scenario { map, path, policy, .. }, checked) =
                    begun.map_err(|wrong| wrong.located(&self.source, name))?;
                if segment.kind == SegmentKind::Trials {
                    expected.top_mps = expected.top_mps.max(dial::top_mps(&checked.expected_speeds));
                }
                if let (SegmentKind::Trials, Some(condition)) = (segment.kind, condition) {
                    let known = expected.kinds.entry(condition.name.clone()).or_default();
                    *known = known.and(ConditionKind::of(&checked.policy.name, checked.drive.scenario()));
                }
                if checked.drive.is_open() {
                    expected.networks.insert([map.clone(), path], checked.drive.scenario().clone());
                }
                expected.policies.insert([map, policy], checked.policy);
            }
        }
        Ok(expected)
    }

    /// Returns the files that the drives read ([`Scenario::files`]), each once.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.expected.files.iter()
    }

    /// Returns the scenario of a drive: base settings, then the segment's, then the condition's.
    pub(super) fn drive(&self, segment: usize, condition: Option<&Condition>) -> Result<Scenario, WrongSetting> {
        let set = &self.file.segment[segment].set;
        let own = [(format!("segment.{segment}.set"), set.clone())];
        let changes = own.iter().chain(condition.iter().flat_map(|condition| &condition.changes));
        let mut scenario = self.base.clone();
        for (key, changes) in changes {
            scenario = changed(&scenario, key, changes, &self.folder).map_err(|mut faults| faults.swap_remove(0))?;
        }
        if scenario.duration_s <= 0.0 {
            let message = "duration_s is 0; a drive of a study needs an end".into();
            return Err(self.wrong(segment, condition, &["duration_s"], message));
        }
        Ok(scenario)
    }

    /// Checks that a drive can show each skill of its segment.
    fn check_skills(&self, segment: usize, checked: &CheckedDrive) -> Result<(), WrongSetting> {
        let (map, gives_advice) = (checked.drive.map(), checked.policy.gives_advice());
        let mut skills = self.file.segment[segment].skills.iter().enumerate();
        let lacking = skills.find_map(|(i, skill)| Some((i, skill, skill.lacks(map, gives_advice)?)));
        lacking.map_or(Ok(()), |(i, skill, why)| {
            let message = format!("the drive cannot show the skill \"{}\": {why}", skill.name());
            Err(WrongSetting {
                key: format!("segment.{segment}.skills.{i}"),
                part: KeyPart::Value,
                message,
                is_relation: false,
            })
        })
    }

    /// Checks that a drive can start.
    fn checked(
        &self,
        segment: usize,
        condition: Option<&Condition>,
        scenario: &Scenario,
    ) -> Result<CheckedDrive, WrongSetting> {
        let wrong = |keys: &[&str], message: String| self.wrong(segment, condition, keys, message);
        driver::named(&scenario.driver).map_err(|error| wrong(&["driver"], error.to_string()))?;
        CheckedDrive::new(scenario).map_err(|error| {
            let mut wrong = wrong(error.settings(), error.to_string());
            if error.settings().first().is_some_and(|first| wrong.key.ends_with(&format!(".{first}"))) {
                wrong.key += error.part();
            }
            wrong
        })
    }

    /// Returns an error about one of these settings, located where it was last set.
    pub(super) fn wrong(
        &self,
        segment: usize,
        condition: Option<&Condition>,
        keys: &[&str],
        message: String,
    ) -> WrongSetting {
        let own = (format!("segment.{segment}.set"), self.file.segment[segment].set.clone());
        let base = ("base".to_owned(), self.file.base.clone());
        let last_first = condition.iter().flat_map(|c| c.changes.iter().rev().cloned()).chain([own, base]);
        let mut set = last_first.flat_map(|(place, changes)| {
            keys.iter().filter(move |key| changes.contains_key(**key)).map(move |key| format!("{place}.{key}"))
        });
        let key = set.next().unwrap_or_else(|| format!("segment.{segment}"));
        WrongSetting { key, part: KeyPart::Value, message, is_relation: false }
    }
}

/// Returns all combinations of levels, the last factor varying fastest; without factors, the conditions of the file.
pub(super) fn conditions(file: &StudyFile) -> Vec<Condition> {
    let condition = |key: String, factor: &str, level: &ConditionLevel| Condition {
        name: level.name.clone(),
        levels: BTreeMap::from([(factor.to_owned(), level.name.clone())]),
        changes: vec![(key, level.set.clone())],
    };
    if file.factors.is_empty() {
        let list = file.condition.iter().enumerate();
        return list.map(|(i, level)| condition(format!("condition.{i}.set"), "condition", level)).collect();
    }
    let mut all: Vec<Condition> = Vec::new();
    for (factor, levels) in &file.factors {
        let each: Vec<Condition> = levels
            .iter()
            .enumerate()
            .map(|(i, level)| condition(format!("factors.{factor}.{i}.set"), factor, level))
            .collect();
        if all.is_empty() {
            all = each;
            continue;
        }
        let both = |a: &Condition, b: &Condition| Condition {
            name: format!("{}+{}", a.name, b.name),
            levels: a.levels.iter().chain(&b.levels).map(|(k, v)| (k.clone(), v.clone())).collect(),
            changes: a.changes.iter().chain(&b.changes).cloned().collect(),
        };
        all = all.iter().flat_map(|a| each.iter().map(move |b| both(a, b))).collect();
    }
    all
}

/// Returns `scenario` with the changed settings. `key` is their place in the study file; relative paths start in `folder`. A list of events replaces
/// the former one.
///
/// # Errors
/// All settings that are wrong by themselves, or the one that contradicts others.
pub(super) fn changed(
    scenario: &Scenario,
    key: &str,
    changes: &SettingChanges,
    folder: &Path,
) -> Result<Scenario, Vec<WrongSetting>> {
    let known = Scenario::fields();
    let (mut list, mut faults): (Vec<(Field, Value)>, Vec<WrongSetting>) = Default::default();
    let mut scenario = scenario.clone();
    for (name, value) in changes {
        if name == scripted_event::KEY {
            match serde_json::from_value(value.clone()) {
                Ok(events) => scenario.events = events,
                Err(error) => faults.push(WrongSetting {
                    key: format!("{key}.{name}"),
                    part: KeyPart::Value,
                    message: error.to_string(),
                    is_relation: false,
                }),
            }
            continue;
        }
        let inner: Vec<(String, &Value)> = match value {
            Value::Object(table) => table.iter().map(|(k, v)| (format!("{name}.{k}"), v)).collect(),
            value => vec![(name.clone(), value)],
        };
        for (path, value) in inner {
            let wrong =
                |part, message| WrongSetting { key: format!("{key}.{path}"), part, message, is_relation: false };
            let Some(field) = known.iter().find(|field| field.path == path) else {
                let names: Vec<&str> = known.iter().map(|field| field.path.as_str()).collect();
                faults.push(wrong(KeyPart::Key, toml_text::unknown_key(&path, &names)));
                continue;
            };
            match field.written(value) {
                Err(fault) => faults.push(wrong(KeyPart::Value, fault)),
                Ok(Value::String(word)) => {
                    list.push((field.clone(), scenario::path_from(folder, &field.path, &word).into()));
                }
                Ok(value) => list.push((field.clone(), value)),
            }
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    settings::changed(&scenario, &list).map_err(|fault| {
        let key = format!("{key}.{}", fault.key);
        vec![WrongSetting { key, part: KeyPart::Value, message: fault.message, is_relation: true }]
    })
}
