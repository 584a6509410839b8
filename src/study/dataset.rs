//! The folder of a study. In: sessions and their recordings. Out: a BIDS data set, with `participants.tsv` and all other tables.
//!
//! ```text
//! dataset_description.json  README.md  .bidsignore  study.toml (a copy of the study file) study-changed.toml        the present study
//! file, if the plan of the analysis was changed after the first session participants.tsv          one row per participant: number, kind,
//! order, state of the session phenotype/SEGMENT.tsv     one row per participant: answers and scores of one questionnaire
//! phenotype/SEGMENT_2_NAME.tsv as above for the questionnaire NAME after the second trial, with its condition events.json meaning of the
//! columns and words of all tables of events, with HED tags
//! tracksys-codrive_channels.json       frames of reference of all motion
//! sub-CODE/sub-CODE_scans.tsv          drives and answers: time, condition, levels, folder of the recording
//! sub-CODE/beh/*_events.tsv, *_beh.tsv advice and events of a drive; answers with their times
//! sub-CODE/motion/*_motion.tsv         the ego's motion and pedals, 100 rows per second; its events, its channels erased.tsv erased
//! participants with reason and time: no data (see `erasure`) SHA256SUMS                all files except those of an analysis, for
//! `sha256sum --check` and `codrive analyse` sourcedata/sub-CODE/session.json     log of the session (see `session`)
//! sourcedata/sub-CODE/date-shift.json  number of days by which the dates in the tables are moved (see `scans`) sourcedata/sub-CODE/ITEM/
//! recording of a drive; ITEM-baseline is the same drive without advice
//! ```
//! Everything except `sourcedata` can be made again from it, and is after every participant. Only the user can read the files.

pub use super::file_names::{BASELINE, BASELINE_PART};

use super::{
    Completion, ParticipantCode, PlanItem, PlannedItem, SessionError, SessionPlan, Study,
    answer_tables::{phenotype, phenotype_of_trial, timed},
    bids::{self, TsvTable},
    checksums, erasure,
    event_table::{self, DriveEvents},
    file_names, fms_table, inherited, lock, motion,
    participant_table::participants,
    scans::{self, DateShift, ScannedDrive, ScannedFile},
    session_log::{self, SessionLog},
    source,
};
use crate::{
    analysis::models::plan,
    file::{SETTINGS_BYTES, read_bounded, read_text},
    record::{self, Manifest, RecordError, inputs},
};
use serde_json::{Value, json};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

/// Description of the data set, a file that BIDS requires.
const DESCRIPTION: &str = "dataset_description.json";
/// Copy of the study file.
pub(super) const STUDY: &str = "study.toml";

/// Files that BIDS validators must ignore. For a folder with a trailing slash, a validator ignores the files and reports the folder.
const BIDSIGNORE: &str = "study.toml\nstudy-changed.toml\nSHA256SUMS\nreport\nanalysis\n";

/// Returns true for one of `files`, complete or as an interrupted creation of the data set left it.
fn is_begun(path: &Path, files: &[(&str, String)]) -> bool {
    files.iter().any(|(name, text)| {
        let name = Path::new(name);
        let is_named = |name: &Path| path.file_name() == name.file_name();
        (is_named(name) || is_named(&name.with_extension(record::BESIDE)))
            && read_bounded(path, text.len() as u64).is_ok_and(|found| text.as_bytes().starts_with(&found))
    })
}

/// Folder of a study's data.
#[derive(Clone, Debug)]
pub struct DataSet {
    root: PathBuf,
}

impl DataSet {
    /// Opens the data set in `root`, or makes a new one if the folder is missing or empty.
    ///
    /// # Errors
    /// The folder holds something else, or another study.
    pub fn open(root: &Path, study: &Study) -> Result<Self, SessionError> {
        let data = Self { root: root.into() };
        record::new_private_dir(root)?;
        data.check_links()?;
        erasure::finish(root)?;
        let copy = root.join(STUDY);
        if record::is_there(&copy)? {
            let was = read_text(&copy, SETTINGS_BYTES).map_err(|why| RecordError::File { path: copy.clone(), why })?;
            if !source::is_same_study(&was, &study.source) {
                return Err(SessionError::Refused(format!(
                    "{} differs from the study of this data set; name a new folder, or restore the file",
                    copy.display()
                )));
            }
            data.keep_plan(&was, study)?;
            return Ok(data);
        }
        let files = [
            (DESCRIPTION, description(study)),
            ("README.md", readme(study)),
            (".bidsignore", BIDSIGNORE.to_owned() + erasure::BIDSIGNORE),
            // Written last: its presence marks a complete data set.
            (STUDY, source::portable(&study.source)),
        ];
        if let Some(other) = record::entries(root)?.iter().find(|path| !is_begun(path, &files)) {
            return Err(SessionError::Refused(format!(
                "{} holds {} and is not the data set of a study; name a new or an empty folder",
                root.display(),
                other.file_name().unwrap_or_default().display()
            )));
        }
        for (name, text) in &files {
            data.write(name, text)?;
        }
        Ok(data)
    }

    /// Keeps the present study file beside the first session's file if the plan of the analysis differs.
    fn keep_plan(&self, was: &str, study: &Study) -> Result<(), SessionError> {
        let now = source::portable(&study.source);
        if now != source::portable(was) {
            log::warn!(
                "the plan of the analysis differs from the plan of the first session; the report will name the changes"
            );
            self.write(plan::CHANGED, &now)?;
        } else {
            self.remove(plan::CHANGED)?;
        }
        checksums::list_changed_plan(&self.root)
    }

    /// Returns the folder of the data set.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Returns the folder of a participant's raw data.
    pub fn source(&self, code: &ParticipantCode) -> PathBuf {
        self.root.join("sourcedata").join(code.subject())
    }

    /// Refuses the code of an erased participant, and a code that differs from another one only by case: some systems would share the
    /// folder.
    pub(super) fn check_new_code(&self, code: &ParticipantCode) -> Result<(), SessionError> {
        let like = |other: &ParticipantCode| other != code && other.as_str().eq_ignore_ascii_case(code.as_str());
        if let Some(was) = erasure::erased(&self.root)?.iter().find(|was| was.code.eq_ignore_ascii_case(code.as_str()))
        {
            return Err(SessionError::Refused(format!(
                "participant {code} was erased ({}, {}); use another code",
                was.reason, was.at
            )));
        }
        match self.codes()?.into_iter().find(like) {
            Some(other) => Err(SessionError::Refused(format!(
                "participant {code} differs from {other} only by capital letters; use another code"
            ))),
            None => Ok(()),
        }
    }

    /// Refuses symbolic links in place of participants' folders: they lead data out of the data set, or foreign data into it.
    fn check_links(&self) -> Result<(), SessionError> {
        for folder in [self.root.clone(), self.root.join("sourcedata")] {
            let inner = ["sourcedata", "phenotype"].map(|name| folder.join(name));
            let mut paths = record::entries(&folder)?.into_iter().chain(inner);
            let planted = |path: &PathBuf| {
                let ours = |name: &str| name.starts_with("sub-") || ["sourcedata", "phenotype"].contains(&name);
                path.is_symlink() && path.file_name().and_then(|name| name.to_str()).is_some_and(ours)
            };
            if let Some(link) = paths.find(planted) {
                return Err(SessionError::Refused(format!(
                    "{} is a symbolic link; a data set needs the participant's folder itself\n  remedy: replace the \
                     link by the folder",
                    link.display()
                )));
            }
        }
        Ok(())
    }

    /// Returns the codes of all participants with data, sorted.
    ///
    /// # Errors
    /// The folder cannot be listed.
    pub(super) fn codes(&self) -> Result<Vec<ParticipantCode>, RecordError> {
        let folders = record::entries(&self.root.join("sourcedata"))?;
        let code = |folder: &PathBuf| ParticipantCode::new(folder.file_name()?.to_str()?.strip_prefix("sub-")?).ok();
        let mut codes: Vec<ParticipantCode> = folders.iter().filter_map(code).collect();
        codes.sort();
        Ok(codes)
    }

    /// Returns all sessions, sorted by number and code.
    ///
    /// # Errors
    /// A session cannot be read.
    pub fn logs(&self) -> Result<Vec<SessionLog>, SessionError> {
        self.check_links()?;
        let mut logs = Vec::new();
        for code in self.codes()? {
            let path = self.source(&code).join(session_log::FILE);
            if record::is_there(&path)? {
                logs.push(SessionLog::load(&path)?);
            }
        }
        logs.sort_by(|a, b| a.index.cmp(&b.index).then(a.participant.cmp(&b.participant)));
        Ok(logs)
    }

    /// Returns the lowest number that no counting participant has, which selects the next order of the balanced design. The replacement
    /// of a participant whose data do not count (excluded, withdrawn, declined, not eligible) takes the same order, so the design stays
    /// balanced.
    ///
    /// # Errors
    /// A session cannot be read.
    pub fn next_index(&self) -> Result<usize, SessionError> {
        let logs = self.logs()?;
        let counts = |log: &SessionLog| {
            matches!(Completion::of(log), Completion::Open | Completion::Complete | Completion::Partial)
        };
        Ok((0..).find(|index| logs.iter().all(|log| log.index != *index || !counts(log))).unwrap_or(0))
    }

    fn write(&self, name: &str, text: &str) -> Result<(), SessionError> {
        let path = self.root.join(name);
        if let Some(folder) = path.parent() {
            record::new_dir_within(&self.root, folder)?;
        }
        Ok(record::replace(&path, text.as_bytes())?)
    }

    fn write_table(&self, name: &str, table: &TsvTable, more: Value) -> Result<(), SessionError> {
        self.write(&format!("{name}.tsv"), &table.text())?;
        self.write(&format!("{name}.json"), &table.sidecar(more))
    }

    /// Makes the tables of the data set from the sessions: the tables of one participant's drives and answers, and the common tables.
    ///
    /// # Errors
    /// A recording or session cannot be read, or a table cannot be written.
    pub fn publish(&self, study: &Study, code: &ParticipantCode) -> Result<(), SessionError> {
        // Two programs may end a session at the same moment.
        let path = self.root.join("sourcedata").join("lock");
        let lock = lock::lock_file(&path)?;
        lock.lock().map_err(|why| RecordError::File { path, why })?;
        let logs = self.logs()?;
        if let Some(log) = logs.iter().find(|log| log.participant == *code) {
            self.publish_one(study, log)?;
        }
        let others = logs.iter().filter(|log| log.participant != *code && log.end.is_some());
        let mut late = checksums::unlisted(&self.root, others.map(|log| &log.participant))?;
        // A participant whose session is open in another window is published by that window.
        late.retain(|code| lock::lock(&self.source(code), code).is_ok());
        for log in logs.iter().filter(|log| late.contains(&&log.participant)) {
            log::info!("{}: the program ended before the data were listed; they are listed now", log.participant);
            self.publish_one(study, log)?;
        }
        inherited::settle(&self.root)?;
        self.write_table("participants", &participants(&logs), json!({}))?;
        // Questionnaires at one place differ between participants: after a drive without advice, none asks about advice.
        let plans: Vec<SessionPlan> = logs.iter().map(|log| study.plan(log.index)).chain([study.plan(0)]).collect();
        let mut named = BTreeSet::new();
        for planned in plans.iter().flat_map(|plan| &plan.items) {
            let PlanItem::Questions(word) = &planned.item else { continue };
            let Some(questionnaire) = study.questionnaires.get(word) else { continue };
            let about_trial = planned.after.as_ref().zip(planned.run);
            let name = about_trial.map_or(planned.name.clone(), |(after, run)| {
                format!("{}-{run}-{}", planned.segment, after.questionnaire)
            });
            if !named.insert(name.clone()) {
                continue;
            }
            let table = match about_trial {
                Some(_) => phenotype_of_trial(study, questionnaire, planned, &logs),
                None => phenotype(questionnaire, &planned.name, &logs),
            };
            let stop = if questionnaire.title.ends_with(['.', '?', '!']) { "" } else { "." };
            let about = format!("{}{stop} {}", questionnaire.title, questionnaire.description);
            let more = json!({ "MeasurementToolMetadata": { "Description": about } });
            self.write_table(&format!("phenotype/{}", name.replace('-', "_")), &table, more)?;
        }
        let is_over = logs.iter().any(|log| log.participant == *code && log.end.is_some());
        checksums::list(&self.root, &code.subject(), is_over)?;
        late.into_iter().try_for_each(|code| checksums::list(&self.root, &code.subject(), true))
    }

    /// Removes the baseline of this recording from the checksum list, because it is about to be made again. Publishing the participant
    /// lists it again.
    ///
    /// # Errors
    /// The list cannot be read or written.
    pub fn remakes_baseline(&self, code: &ParticipantCode, recording: &str) -> Result<(), SessionError> {
        checksums::forget(&self.root, &format!("sourcedata/{}/{recording}{BASELINE}", code.subject()))
    }

    /// Makes the tables of one participant's drives and answers.
    fn publish_one(&self, study: &Study, log: &SessionLog) -> Result<(), SessionError> {
        let subject = log.participant.subject();
        let plan = study.plan(log.index);
        let mut table = scans::table(study);
        let shift = DateShift::of(&self.source(&log.participant), log)?;
        let institution = study.file.institution.as_deref();
        let mut stems = BTreeSet::new();
        for planned in &plan.items {
            let Some(item_run) = log.done(&planned.name) else { continue };
            let name = format!("{subject}/beh/{}", file_names::file_name(&subject, planned));
            stems.extend([name.clone(), format!("{subject}/motion/{}", file_names::motion_name(&subject, planned))]);
            match &planned.item {
                PlanItem::Drive { scenario, levels, .. } => {
                    let Some(folder) = &item_run.recording else { continue };
                    let about = format!(
                        "Driving on {} in traffic of {} vehicles",
                        inputs::last(&scenario.map),
                        scenario.vehicles
                    );
                    let facts = bids::task(&bids::label(&planned.segment), &about, &planned.text, institution);
                    let place = self.source(&log.participant).join(folder);
                    let moved = match self.put_drive(&subject, planned, &place, &facts) {
                        Ok(moved) => moved,
                        // The tables of a lost recording stay as they are; the list of files keeps its checksums.
                        Err(why) if is_damaged(&place) => {
                            log::warn!("the tables of a drive cannot be made again: {why}");
                            let table = format!("motion/{}_motion.tsv", file_names::motion_name(&subject, planned));
                            self.root.join(&subject).join(&table).is_file().then_some(table)
                        }
                        Err(why) => return Err(why),
                    };
                    let recording = format!("sourcedata/{subject}/{folder}");
                    let baseline = format!("{recording}{BASELINE}");
                    let baseline = if record::is_there(&self.root.join(&baseline))? { baseline } else { String::new() };
                    let began = Manifest::load(&place).map_or(String::new(), |manifest| manifest.began);
                    let began = if began.is_empty() { item_run.began.as_str() } else { began.as_str() };
                    let name = moved.unwrap_or(format!("beh/{}_events.tsv", file_names::file_name(&subject, planned)));
                    let drive = ScannedDrive { levels, seed: scenario.seed, recording, baseline };
                    let file = ScannedFile { name, began, planned, drive: Some(drive) };
                    table.rows.push(scans::row(study, file, shift));
                }
                PlanItem::Questions(word) => {
                    let (Some(answers), Some(q)) = (log.answers.get(&planned.name), study.questionnaires.get(word))
                    else {
                        continue;
                    };
                    let facts = bids::task(&file_names::task(planned), &q.title, &planned.text, institution);
                    self.write_table(&format!("{name}_beh"), &timed(study, planned, answers), facts)?;
                    let name = format!("beh/{}_beh.tsv", file_names::file_name(&subject, planned));
                    let file = ScannedFile { name, began: &item_run.began, planned, drive: None };
                    table.rows.push(scans::row(study, file, shift));
                }
                PlanItem::Text(_) | PlanItem::Break(_) => {}
            }
        }
        if !log.fms.is_empty() {
            let facts = bids::task(fms_table::TASK, fms_table::ABOUT, &study.file.texts.fms, institution);
            let name = format!("{subject}/beh/{subject}_task-{}_beh", fms_table::TASK);
            self.write_table(&name, &fms_table::table(study, &plan, log), facts)?;
            stems.insert(name.trim_end_matches("_beh").to_owned());
        }
        self.remove_others(&subject, &stems)?;
        let scans = format!("{subject}/{subject}_scans");
        if table.rows.is_empty() {
            return ["tsv", "json"].into_iter().try_for_each(|ending| self.remove(&format!("{scans}.{ending}")));
        }
        self.write_table(&scans, &table, json!({}))
    }

    /// Removes tables of items that are no longer done, such as a drive that was begun again and then skipped. `stems` are the names to
    /// keep, relative to the data set, without the suffix for the kind of table.
    fn remove_others(&self, subject: &str, stems: &BTreeSet<String>) -> Result<(), SessionError> {
        for folder in ["beh", "motion"].map(|kind| format!("{subject}/{kind}")) {
            for path in record::entries(&self.root.join(&folder))? {
                let name = format!("{folder}/{}", path.file_name().unwrap_or_default().display());
                if name.rsplit_once('_').is_none_or(|(stem, _)| !stems.contains(stem)) {
                    self.remove(&name)?;
                }
            }
        }
        Ok(())
    }

    /// Removes a file of the data set, if it exists.
    fn remove(&self, name: &str) -> Result<(), SessionError> {
        Ok(record::remove(&self.root.join(name))?)
    }

    /// Writes a table of events; a sidecar at the top of the data set describes its columns.
    fn put_events(&self, name: &str, events: &TsvTable, facts: &Value) -> Result<(), SessionError> {
        self.write(&format!("{name}_events.tsv"), &events.text())?;
        self.write(&format!("{name}_events.json"), &format!("{facts:#}\n"))
    }

    /// Writes the events and the motion of a drive. Returns the name of the motion table as [`Self::put_motion`].
    fn put_drive(
        &self,
        subject: &str,
        planned: &PlannedItem,
        recording: &Path,
        facts: &Value,
    ) -> Result<Option<String>, SessionError> {
        let events = DriveEvents::of(recording)?;
        let name = format!("{subject}/beh/{}", file_names::file_name(subject, planned));
        self.put_events(&name, &events.since(0), facts)?;
        self.put_motion(subject, planned, recording, &events, facts)
    }

    /// Writes the motion of a drive, and its events counted from the first sample. Returns the name of the motion table relative to the
    /// participant's folder; `None` for a drive without a tick.
    fn put_motion(
        &self,
        subject: &str,
        planned: &PlannedItem,
        recording: &Path,
        events: &DriveEvents,
        facts: &Value,
    ) -> Result<Option<String>, SessionError> {
        let stem = file_names::motion_name(subject, planned);
        let (within, name) = (format!("motion/{stem}"), format!("{subject}/motion/{stem}"));
        record::new_dir_within(&self.root, &self.root.join(subject).join("motion"))?;
        let table = format!("{within}_motion.tsv");
        let Some(span) = motion::write(recording, &self.root.join(subject).join(&table))? else { return Ok(None) };
        self.put_events(&name, &events.since(span.first), facts)?;
        self.write(&format!("{name}_channels.tsv"), &motion::channels())?;
        self.write(&format!("{name}_motion.json"), &format!("{:#}\n", motion::sidecar(span, facts.clone())))?;
        Ok(Some(table))
    }
}

/// Returns true for a recording that is lost or not as it was written.
fn is_damaged(recording: &Path) -> bool {
    record::open(recording).and_then(|_| record::changes(recording)).map_or(true, |changes| !changes.is_empty())
}

fn description(study: &Study) -> String {
    let mut text = json!({
        "Name": study.file.title,
        "BIDSVersion": bids::VERSION,
        "DatasetType": "raw",
        // Written even if empty: some readers stop at a data set without this key.
        "Authors": study.file.authors,
        "HEDVersion": event_table::HED_VERSION,
        "SourceDatasets": [{ "URL": "bids::sourcedata" }],
        "GeneratedBy": [{ "Name": "codrive", "Version": env!("CARGO_PKG_VERSION") }],
    });
    if let Some(licence) = &study.file.licence {
        text["License"] = licence.clone().into();
    }
    format!("{text:#}\n")
}

fn readme(study: &Study) -> String {
    format!(
        "# {}\n\n\
         Drives and answers of a study in the driving simulator codrive, as a BIDS data set (`beh`, `motion`).\n\n\
         * `participants.tsv`: codes of the participants, order of conditions, and progress of each session.\n\
         * `phenotype/`: answers and scores of the questionnaires, one row per participant. A questionnaire after \
         every trial has one table per trial (`trial_2_NAME.tsv`), with the condition.\n\
         * `sub-*/sub-*_scans.tsv`: drives and answers with condition, date and folder of the recording. All dates of \
         a participant are moved by the same number of days to years before 1925; `sourcedata/` has the true dates.\n\
         * `sub-*/beh/`: advice and events of every drive; answers with the time for each.\n\
         * `sub-*/motion/`: motion and pedals of the participant's vehicle, 100 rows per second, rounded to 0.1 mm, \
         0.1 mm/s and 1 urad. The recordings have all digits and the other vehicles. `*_channels.tsv` defines the \
         columns, `tracksys-codrive_channels.json` their frames of reference.\n\
         * `events.json`: definitions of the columns and words of all `*_events.tsv`, with HED tags.\n\
         * `sourcedata/`: recordings as Parquet tables (units in each column's metadata), and the log of every \
         session.\n  \
         A folder that ends in `{BASELINE}` has the same drive from the same seed, without advice.\n\
         * `study.toml`: the study file.\n\n\
         `codrive analyse` makes tables of measures and a report from this data set.\n",
        bids::markdown(&study.file.title)
    )
}

#[cfg(test)]
#[path = "dataset_tests.rs"]
mod tests;
