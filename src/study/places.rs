//! Check that each recording of a data set lies where it belongs. In: the folder, with the logs of its sessions, its plan and its tables.
//! Out: every recording with the wrong participant, trial, condition or time for its place, and every table that contradicts the log.

use super::{
    Completion, ParticipantCode, PlanItem, PlannedItem, SessionError, SessionPlan, Study, bids,
    checksums::WHAT_IF,
    dataset::{BASELINE, STUDY},
    scans,
    session_log::{self, ItemOutcome, ItemRun, SessionLog},
};
use crate::{
    file::read_text,
    map, policy,
    record::{AlteredFile, Manifest, RecordError, inputs, is_there, seals::OF_SYSTEMS},
    scenario::Scenario,
    traffic::{EngineChoice, is_population_path},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

/// Suffix of a baseline folder that is still being written.
const PART: &str = "-part";

/// Row of `participants.tsv` or of a list of scans: cells by column name.
type Row = BTreeMap<String, String>;

/// Lists the parts of a data set that are not where they belong.
///
/// # Errors
/// A file cannot be read.
pub fn misplaced(root: &Path) -> Result<Vec<AlteredFile>, SessionError> {
    let study = Study::load(&root.join(STUDY));
    if let Err(why) = &study {
        log::warn!(
            "the study cannot be read; trials are compared with the logs of the sessions, not with the plan: {why}"
        );
    }
    let people = rows(&root.join("participants.tsv"))?;
    let mut places = Places { root, study: study.ok(), found: Vec::new() };
    let with_raw = folders(&root.join("sourcedata"))?;
    for subject in &with_raw {
        places.check_participant(subject, &people)?;
    }
    let with_tables = folders(root)?;
    let named = people.iter().filter_map(|row| row.get("participant_id"));
    let named: BTreeSet<&String> = named.chain(&with_tables).filter(|name| !with_raw.contains(*name)).collect();
    for subject in named {
        places.add_fault(subject, format!("there is no folder sourcedata/{subject}"));
    }
    Ok(places.found)
}

/// Returns the names of the participants' folders in a folder.
fn folders(folder: &Path) -> Result<BTreeSet<String>, SessionError> {
    Ok(entries(folder)?.into_iter().filter(|name| name.starts_with("sub-") && folder.join(name).is_dir()).collect())
}

fn entries(folder: &Path) -> Result<BTreeSet<String>, SessionError> {
    if !is_there(folder)? {
        return Ok(BTreeSet::new());
    }
    let entries = fs::read_dir(folder).and_then(Iterator::collect::<std::io::Result<Vec<_>>>);
    let entries = entries.map_err(|why| RecordError::File { path: folder.into(), why })?;
    Ok(entries.into_iter().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect())
}

/// Returns the rows of a table; none if the table does not exist.
fn rows(path: &Path) -> Result<Vec<Row>, SessionError> {
    if !is_there(path)? {
        return Ok(Vec::new());
    }
    let text = read_text(path, super::bids::TABLE_BYTES).map_err(|why| RecordError::File { path: path.into(), why })?;
    let mut lines = text.lines().map(|line| line.split('\t').map(str::to_owned));
    let names: Vec<String> = lines.next().into_iter().flatten().collect();
    Ok(lines.map(|cells| names.iter().cloned().zip(cells).collect()).collect())
}

struct Places<'a> {
    root: &'a Path,
    study: Option<Study>,
    found: Vec<AlteredFile>,
}

impl Places<'_> {
    fn add_fault(&mut self, file: &str, what: String) {
        self.found.push(AlteredFile { file: file.into(), what });
    }

    /// Checks one participant: log, row of `participants.tsv`, recordings, list of scans.
    fn check_participant(&mut self, subject: &str, people: &[Row]) -> Result<(), SessionError> {
        let source = format!("sourcedata/{subject}");
        let file = format!("{source}/{}", session_log::FILE);
        let log = match SessionLog::load(&self.root.join(&file)) {
            Ok(log) => log,
            Err(why) => {
                self.add_fault(&file, why.to_string());
                return Ok(());
            }
        };
        if log.participant.subject() != subject {
            self.add_fault(
                &file,
                format!("is the session of {}, but it is in the folder of {subject}", log.participant.subject()),
            );
            return Ok(());
        }
        self.check_row(&file, &log, people);
        let plan = self.study.as_ref().map(|study| study.plan(log.index));
        if plan.as_ref().is_some_and(|plan| plan.order != log.order) {
            let (number, order) = (log.index + 1, log.order.join(", "));
            self.add_fault(
                &file,
                format!("the order is {order}; {STUDY} has another order for participant number {number}"),
            );
        }
        for item_run in &log.item_runs {
            self.check_item_run(&source, &log.participant, item_run, plan.as_ref())?;
        }
        self.check_folders(&source, &log)?;
        if let Some(plan) = &plan {
            self.check_scans(subject, &log, plan)?;
        }
        Ok(())
    }

    fn check_row(&mut self, file: &str, log: &SessionLog, people: &[Row]) {
        let subject = log.participant.subject();
        let Some(row) = people.iter().find(|row| row.get("participant_id") == Some(&subject)) else {
            if log.end.is_some() {
                self.add_fault(
                    "participants.tsv",
                    format!("has no row for {subject}, but the session is over ({file})"),
                );
            }
            return;
        };
        let cells = [
            ("number", (log.index + 1).to_string()),
            ("order", log.order.join(",")),
            ("state", Completion::of(log).to_string()),
            ("frames_per_s", bids::number(log.frames_per_s)),
        ];
        for (column, is) in cells {
            let in_table = row.get(column).map_or("", String::as_str);
            if in_table != is && !(is.is_empty() && in_table == "n/a") {
                self.add_fault("participants.tsv", format!("{column} of {subject} is {in_table}; {file} has {is}"));
            }
        }
    }

    /// Checks one run of an item, if it was recorded.
    fn check_item_run(
        &mut self,
        source: &str,
        code: &ParticipantCode,
        item_run: &ItemRun,
        plan: Option<&SessionPlan>,
    ) -> Result<(), SessionError> {
        let Some(folder) = &item_run.recording else { return Ok(()) };
        let name = format!("{source}/{folder}");
        let is_done = item_run.outcome == ItemOutcome::Done;
        let manifest = match Manifest::load(&self.root.join(&name)) {
            Ok(manifest) => manifest,
            // The run was cut before its first file was written.
            Err(RecordError::Absent(_)) if !is_done => return Ok(()),
            Err(why) => {
                self.add_fault(&name, format!("there is no readable recording: {why}"));
                return Ok(());
            }
        };
        self.check_owner(&name, code, &manifest);
        if !is_done {
            return Ok(());
        }
        let is_of = folder == &item_run.item || folder.starts_with(&format!("{}-again-", item_run.item));
        if !is_of {
            self.add_fault(
                &name,
                format!(
                    "is not named after {}, although {} says that it is a recording of it",
                    item_run.item,
                    session_log::FILE
                ),
            );
        }
        if let Some(plan) = plan {
            self.check_trial(&name, &item_run.item, plan, &manifest)?;
        }
        let baseline = format!("{name}{BASELINE}");
        if is_there(&self.root.join(&baseline))? {
            self.check_baseline(&name, &baseline, code)?;
        }
        Ok(())
    }

    fn check_owner(&mut self, name: &str, code: &ParticipantCode, manifest: &Manifest) {
        if manifest.participant.as_deref() != Some(code.as_str()) {
            let of =
                manifest.participant.as_ref().map_or("an unknown participant".into(), |of| format!("participant {of}"));
            self.add_fault(name, format!("is a recording of {of}, but it is in the folder of {}", code.subject()));
        }
    }

    /// Checks that the drive is the one that the plan has for this item.
    fn check_trial(
        &mut self,
        name: &str,
        item: &str,
        plan: &SessionPlan,
        manifest: &Manifest,
    ) -> Result<(), SessionError> {
        let planned = plan.items.iter().find(|planned| planned.name == item);
        let Some(PlannedItem { item: PlanItem::Drive { scenario, policy, .. }, .. }) = planned else {
            self.add_fault(name, format!("{item} is not a drive of this participant in {STUDY}"));
            return Ok(());
        };
        let Some(driven) = self.scenario(name)? else { return Ok(()) };
        if let Some(what) = difference(scenario, &driven) {
            self.add_fault(name, format!("is not the drive that {STUDY} plans for {item}: {what}"));
        } else if inputs::last(&policy.name) != manifest.policy.name {
            let (is, planned) = (&manifest.policy.name, inputs::last(&policy.name));
            self.add_fault(
                name,
                format!("is not the drive that {STUDY} plans for {item}: the policy is {is}; planned: {planned}"),
            );
        }
        Ok(())
    }

    /// Returns the scenario of a recording. If it cannot be read, reports why and returns `None`.
    fn scenario(&mut self, name: &str) -> Result<Option<Scenario>, SessionError> {
        match inputs::scenario(&self.root.join(name)) {
            Ok(scenario) => Ok(Some(scenario)),
            Err(why) => {
                self.add_fault(&format!("{name}/{}", inputs::SCENARIO), why.message);
                Ok(None)
            }
        }
    }

    /// Checks that a baseline is the same drive without advice.
    fn check_baseline(&mut self, trial: &str, baseline: &str, code: &ParticipantCode) -> Result<(), SessionError> {
        let manifest = match Manifest::load(&self.root.join(baseline)) {
            Ok(manifest) => manifest,
            Err(why) => {
                self.add_fault(baseline, format!("there is no readable recording: {why}"));
                return Ok(());
            }
        };
        self.check_owner(baseline, code, &manifest);
        let (Some(driven), Some(without)) = (self.scenario(trial)?, self.scenario(baseline)?) else { return Ok(()) };
        let as_driven = Scenario { driver: driven.driver.clone(), traffic: driven.traffic.clone(), ..without };
        if let Some(what) = difference(&driven, &as_driven) {
            self.add_fault(baseline, format!("is not the drive of {trial} without advice: {what}"));
        } else if manifest.policy.name != policy::NAMES[0] {
            self.add_fault(baseline, format!("is not a drive without advice: its policy is {}", manifest.policy.name));
        }
        Ok(())
    }

    /// Checks that the log names every folder beside it.
    fn check_folders(&mut self, source: &str, log: &SessionLog) -> Result<(), SessionError> {
        let item_runs = log.item_runs.iter().filter_map(|item_run| item_run.recording.as_deref());
        let known: BTreeSet<&str> =
            item_runs.chain(log.running.iter().map(|running| running.recording.as_str())).collect();
        let is_known = |name: &str| {
            let own = name.strip_suffix(PART).unwrap_or(name);
            name.contains(WHAT_IF) || known.contains(name) || known.contains(own.strip_suffix(BASELINE).unwrap_or(own))
        };
        for name in entries(&self.root.join(source))? {
            let place = format!("{source}/{name}");
            if self.root.join(&place).is_dir() && !is_known(&name) && !OF_SYSTEMS.contains(&name.as_str()) {
                self.add_fault(&place, format!("{} of its participant does not name it", session_log::FILE));
            }
        }
        Ok(())
    }

    /// Checks the list of scans, by which an analysis finds the drives, against the log and the plan.
    fn check_scans(&mut self, subject: &str, log: &SessionLog, plan: &SessionPlan) -> Result<(), SessionError> {
        let name = format!("{subject}/{subject}_scans.tsv");
        // The list of a session that is not over does not exist yet.
        if log.end.is_none() {
            return Ok(());
        }
        let mut expected: BTreeMap<String, [String; 5]> = BTreeMap::new();
        for planned in &plan.items {
            let PlanItem::Drive { scenario, .. } = &planned.item else { continue };
            let Some(folder) = log.done(&planned.name).and_then(|item_run| item_run.recording.as_ref()) else {
                continue;
            };
            let recording = format!("sourcedata/{subject}/{folder}");
            let baseline = format!("{recording}{BASELINE}");
            let baseline = if is_there(&self.root.join(&baseline))? { baseline } else { "n/a".into() };
            let row = [
                planned.segment.clone(),
                planned.run.map_or("n/a".into(), |run| run.to_string()),
                planned.condition.clone().unwrap_or_else(|| "n/a".into()),
                scenario.seed.to_string(),
                baseline,
            ];
            expected.insert(recording, row);
        }
        for row in rows(&self.root.join(&name))? {
            let cell = |column: &str| row.get(column).cloned().unwrap_or_default();
            let recording = cell("recording");
            if recording == "n/a" {
                continue;
            }
            let Some(planned) = expected.remove(&recording) else {
                self.add_fault(&name, format!("names {recording}, which is not a completed drive of {subject}"));
                continue;
            };
            for (column, is) in scans::OF_DRIVE.into_iter().zip(planned) {
                if cell(column) != is {
                    self.add_fault(
                        &name,
                        format!("{column} of {recording} is {}; the log and {STUDY} have {is}", cell(column)),
                    );
                }
            }
        }
        for recording in expected.into_keys() {
            self.add_fault(&name, format!("does not name {recording}, a completed drive of {subject}"));
        }
        Ok(())
    }
}

/// Returns the first setting in which a drive differs from the plan, as text. Ignores the names of files, which have other paths in a
/// recording, the policy, which is compared by its name, and the duration, which may have been extended.
fn difference(planned: &Scenario, driven: &Scenario) -> Option<String> {
    let bare = |scenario: &Scenario| {
        let mut bare = Scenario { policy: String::new(), duration_s: 0.0, ..scenario.clone() };
        if map::is_own(&bare.map) {
            bare.map = "a map of the study".into();
        }
        if is_population_path(&bare.traffic_drivers) {
            bare.traffic_drivers = "a population of the study".into();
        }
        if let EngineChoice::Log(file) = &mut bare.traffic {
            *file = "a log of the study.csv".into();
        }
        bare.demand.input_files_mut().for_each(|file| *file = "a file of the study".into());
        bare
    };
    let (planned, driven) = (bare(planned), bare(driven));
    let value = |scenario: &Scenario| serde_json::to_value(scenario).unwrap_or_default();
    let (planned_keys, driven_keys) = (value(&planned), value(&driven));
    let keys = planned_keys.as_object()?;
    let key = keys.keys().find(|key| planned_keys[key.as_str()] != driven_keys[key.as_str()])?;
    Some(format!("{key} is {}; planned: {}", driven_keys[key.as_str()], planned_keys[key.as_str()]))
}
