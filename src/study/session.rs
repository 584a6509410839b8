//! One participant's session in progress. In: the plan, the participant's results, the experimenter's decisions, and the time as text
//! from the caller. Out: the next item; and a small file, saved after every step, so that the session resumes at the right place after a
//! crash, a power cut or a closed window.
//!
//! The file is `sourcedata/sub-CODE/session.json`; recordings lie beside it, each attempt in a folder of its own. An item is settled if
//! its last run was done or skipped; the first unsettled item comes next. A lock keeps a second program away.

pub use super::session_log::{
    DriveRating, EndCause, FILE, ItemOutcome, ItemRun, ParticipantKind, RunningItem, SessionEnd, SessionLog,
    SessionNote, TimedAnswer, as_map,
};

use super::{
    DataSet, FmsRating, ParticipantCode, PlannedItem, SessionError, SessionPlan, Study, checksums,
    dataset::BASELINE_PART, lock, stop_rule::SessionEnding,
};
use crate::{
    private,
    record::{self, RecordError},
};
use fail::fail_point;
use std::{
    collections::BTreeMap,
    fs::File,
    path::{Path, PathBuf},
};

/// Session of one participant.
#[derive(Debug)]
pub struct Session {
    /// Folder of the data set.
    root: PathBuf,
    folder: PathBuf,
    plan: SessionPlan,
    log: SessionLog,
    /// Reason that the last state of the log is not on the disk; `None` if it is.
    unwritten: Option<String>,
    /// Held while the session is open; the system releases it when the program ends.
    _lock: File,
}

impl Session {
    /// Opens a participant's session, new or interrupted. `index` is the number in the study's orders for a new participant. An item left
    /// running by a cut is logged as cut, and its recording is repaired.
    ///
    /// # Errors
    /// The session is over, another program runs it, or its files do not belong to this study.
    pub fn open(
        data: &DataSet,
        study: &Study,
        code: &ParticipantCode,
        kind: ParticipantKind,
        index: usize,
        now: &str,
    ) -> Result<Self, SessionError> {
        data.check_new_code(code)?;
        let folder = data.source(code);
        record::new_dir_within(data.root(), &folder)?;
        let lock = lock::lock(&folder, code)?;
        let path = folder.join(FILE);
        let log = if record::is_there(&path)? {
            SessionLog::load(&path)?
        } else {
            Self::first(&folder, study, code, kind, index)?
        };
        let refused = |why: String| Err(SessionError::Refused(why));
        if log.participant != *code {
            return refused(format!("{}: is of participant {}", path.display(), log.participant));
        }
        if log.kind != kind {
            let is = if log.kind == ParticipantKind::Person { "a person" } else { "simulated" };
            return refused(format!("participant {code} is {is}; use another code"));
        }
        if let Some(end) = &log.end {
            return refused(if end.complete {
                format!("participant {code} has completed the whole study ({}) and cannot take part again", end.at)
            } else {
                format!("the session of participant {code} was stopped for good ({}, {})", end.reason, end.at)
            });
        }
        let root = data.root().to_path_buf();
        let mut session = Self { root, folder, plan: study.plan(log.index), log, unwritten: None, _lock: lock };
        session.mend(now)?;
        Ok(session)
    }

    /// Opens an existing session, over or not, while no window runs it.
    ///
    /// # Errors
    /// The session does not exist, a program runs it, or it cannot be read.
    pub(super) fn reopen(
        data: &DataSet,
        study: &Study,
        code: &ParticipantCode,
        now: &str,
    ) -> Result<Self, SessionError> {
        let folder = data.source(code);
        let lock = lock::lock(&folder, code)?;
        let log = SessionLog::load(&folder.join(FILE))?;
        let root = data.root().to_path_buf();
        let mut session = Self { root, folder, plan: study.plan(log.index), log, unwritten: None, _lock: lock };
        session.mend(now)?;
        Ok(session)
    }

    /// Logs an item left running by a cut, and repairs its recording.
    fn mend(&mut self, now: &str) -> Result<(), SessionError> {
        let was = self.log.clone();
        if let Some(running) = self.log.running.take() {
            let recording = self.folder.join(&running.recording);
            match record::recover(&recording) {
                Ok(_) => {}
                Err(RecordError::Absent(_)) => record::remove_unbegun(&recording)?,
                Err(error) => return Err(error.into()),
            }
            // An incomplete baseline is never used: the item is driven again under its next name.
            record::remove(&self.folder.join(format!("{}{BASELINE_PART}", running.recording)))?;
            let recording = record::is_there(&recording)?.then_some(running.recording);
            let RunningItem { item, began, answers, .. } = running;
            let reason = "the program ended".into();
            let (outcome, ended) = (ItemOutcome::Cut, now.into());
            self.log.item_runs.push(ItemRun { item, outcome, reason, began, ended, recording, answers });
        }
        if self.log == was && record::is_there(&self.folder.join(FILE))? { Ok(()) } else { self.save() }
    }

    fn first(
        folder: &Path,
        study: &Study,
        code: &ParticipantCode,
        kind: ParticipantKind,
        index: usize,
    ) -> Result<SessionLog, SessionError> {
        // A cut during the first save leaves only the temporary file.
        let unfinished = Path::new(FILE).with_extension(record::BESIDE);
        let is_ours = |path: &&PathBuf| path.ends_with(lock::FILE) || path.ends_with(&unfinished);
        if let Some(left) = record::entries(folder)?.iter().find(|path| !is_ours(path)) {
            return Err(SessionError::Refused(format!(
                "{} holds {} but no {FILE}: restore that file, or begin with another participant code",
                folder.display(),
                left.file_name().unwrap_or_default().display()
            )));
        }
        Ok(SessionLog {
            participant: code.clone(),
            index,
            kind,
            traits: BTreeMap::new(),
            frames_per_s: None,
            order: study.plan(index).order,
            running: None,
            item_runs: Vec::new(),
            notes: Vec::new(),
            answers: BTreeMap::new(),
            fms: Vec::new(),
            end: None,
        })
    }

    /// Writes the log. A log that cannot be written stays complete in memory; each later call writes all of it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&mut self) -> Result<(), SessionError> {
        if self.log.end.is_some() {
            // The list may have the log as it was at the end of the session; publishing the participant lists it again.
            let name = format!("sourcedata/{}/{FILE}", self.log.participant.subject());
            if let Err(why) = checksums::forget(&self.root, &name) {
                // The log matters more than the list.
                log::warn!("{why}");
            }
        }
        let text = serde_json::to_string_pretty(&self.log).expect("numbers and words");
        let saved = record::replace(&self.folder.join(FILE), (text + "\n").as_bytes());
        self.unwritten = saved.as_ref().err().map(ToString::to_string);
        Ok(saved?)
    }

    /// Returns the reason that the log in memory is not on the disk; `None` if it is.
    pub fn unwritten(&self) -> Option<&str> {
        self.unwritten.as_deref()
    }

    /// Returns the log so far.
    pub fn log(&self) -> &SessionLog {
        &self.log
    }

    /// Returns the plan of the session.
    pub fn plan(&self) -> &SessionPlan {
        &self.plan
    }

    /// Returns the folder of the participant's recordings.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the next item and its index in the plan; `None` if all items are settled.
    pub fn next(&self) -> Option<(usize, &PlannedItem)> {
        self.plan.items.iter().enumerate().find(|(_, planned)| !self.log.is_settled(&planned.name))
    }

    /// Begins the next item. Returns the folder for its recording, which does not exist yet.
    ///
    /// # Errors
    /// Nothing is left to do, or the file cannot be written.
    pub fn begin(&mut self, now: &str) -> Result<PathBuf, SessionError> {
        let Some((_, planned)) = self.next() else { return Err(nothing_left(&self.log.participant)) };
        let item = planned.name.clone();
        let before = self.log.item_runs.iter().filter(|p| p.item == item && p.recording.is_some()).count();
        let recording = if before == 0 { item.clone() } else { format!("{item}-again-{before}") };
        let folder = self.folder.join(&recording);
        private::check_way(&self.root, &folder).map_err(|why| RecordError::File { path: folder.clone(), why })?;
        // Answers from before a cut must survive a second cut before the first new answer.
        let cut = self.log.last(&item).filter(|item_run| item_run.outcome == ItemOutcome::Cut);
        let answers = cut.map_or(Vec::new(), |item_run| item_run.answers.clone());
        self.log.running = Some(RunningItem { item, recording, began: now.into(), answers });
        if let Err(error) = self.save() {
            // An item whose beginning is not on the disk has not begun.
            self.log.running = None;
            return Err(error);
        }
        fail_point!("session.begin");
        Ok(folder)
    }

    /// Ends the running item.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn end(&mut self, outcome: ItemOutcome, reason: &str, now: &str) -> Result<(), SessionError> {
        if self.pass(outcome, reason, now) {
            self.save()?;
        }
        Ok(())
    }

    /// Ends the running item in memory only. Returns false if nothing runs.
    fn pass(&mut self, outcome: ItemOutcome, reason: &str, now: &str) -> bool {
        let Some(running) = self.log.running.take() else { return false };
        let recording = self.folder.join(&running.recording).exists().then_some(running.recording);
        self.log.item_runs.push(ItemRun {
            item: running.item,
            outcome,
            reason: reason.into(),
            began: running.began,
            ended: now.into(),
            recording,
            answers: running.answers,
        });
        true
    }

    /// Stores the answers to the running questionnaire so far; writes the file if they changed.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn keep(&mut self, answers: Vec<TimedAnswer>) -> Result<(), SessionError> {
        match &mut self.log.running {
            Some(running) if running.answers != answers => running.answers = answers,
            _ => return Ok(()),
        }
        self.save()
    }

    /// Returns the answers to the running questionnaire so far, including those from before a cut.
    pub fn kept(&self) -> &[TimedAnswer] {
        self.log.running.as_ref().map_or(&[], |running| &running.answers)
    }

    /// Ends the running questionnaire with its answers; an `ending` also ends the session. Both are written in one step, as a cut between
    /// them would continue a session that must end.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn end_answered(
        &mut self,
        answers: Vec<TimedAnswer>,
        ending: Option<&SessionEnding>,
        now: &str,
    ) -> Result<(), SessionError> {
        if let Some(running) = &mut self.log.running {
            running.answers.clear();
            let before = self.log.answers.insert(running.item.clone(), answers);
            // The run that gave the answers before keeps them.
            let mut runs = self.log.item_runs.iter_mut().rev();
            let earlier = runs.find(|run| run.item == running.item && run.outcome == ItemOutcome::Done);
            if let (Some(answers), Some(earlier)) = (before, earlier) {
                earlier.answers = answers;
            }
        }
        if let Some(SessionEnding { cause, reason, .. }) = ending {
            self.pass(ItemOutcome::Done, "", now);
            return self.close(false, reason, Some(*cause), now);
        }
        self.end(ItemOutcome::Done, "", now)
    }

    /// Stores a rating of the running drive, answered or not. An `ending` breaks off the drive and ends the session, in one write as in
    /// [`Session::end_answered`].
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn rate(&mut self, rating: FmsRating, ending: Option<&SessionEnding>, now: &str) -> Result<(), SessionError> {
        let Some(RunningItem { item, recording, .. }) = self.log.running.clone() else { return Ok(()) };
        self.log.fms.push(DriveRating { item, recording, rating });
        if let Some(SessionEnding { cause, reason, .. }) = ending {
            self.pass(ItemOutcome::Aborted, reason, now);
            return self.close(false, reason, Some(*cause), now);
        }
        self.save()
    }

    /// Skips the running or else the next item; with a drive also the questionnaires about it.
    ///
    /// # Errors
    /// Nothing is left to do, or the file cannot be written.
    pub fn skip(&mut self, reason: &str, now: &str) -> Result<(), SessionError> {
        if self.log.running.is_none() {
            self.begin(now)?;
        }
        let item = self.log.running.as_ref().map(|running| running.item.clone()).unwrap_or_default();
        for about in self.asked_about(&item, false) {
            self.settle(&about, ItemOutcome::Skipped, &format!("{item} was skipped"), now);
        }
        self.end(ItemOutcome::Skipped, reason, now)
    }

    /// Returns the questionnaires about a drive that are settled, or those that are not.
    fn asked_about(&self, drive: &str, settled: bool) -> Vec<String> {
        let about = self.plan.items.iter().filter(|planned| planned.after.as_ref().is_some_and(|a| a.drive == drive));
        about.map(|planned| planned.name.clone()).filter(|name| self.log.is_settled(name) == settled).collect()
    }

    /// Logs a decision about an item that is not running, in memory only.
    fn settle(&mut self, item: &str, outcome: ItemOutcome, reason: &str, now: &str) {
        self.log.item_runs.push(ItemRun {
            item: item.into(),
            outcome,
            reason: reason.into(),
            began: now.into(),
            ended: now.into(),
            recording: None,
            answers: Vec::new(),
        });
    }

    /// Repeats an item of the plan, which becomes the next one; after a drive also the questionnaires about it.
    ///
    /// # Errors
    /// There is no such item, it is not settled, or the file cannot be written.
    pub fn repeat(&mut self, item: &str, reason: &str, now: &str) -> Result<(), SessionError> {
        if !self.log.is_settled(item) {
            let done: Vec<&str> =
                self.plan.items.iter().map(|p| p.name.as_str()).filter(|n| self.log.is_settled(n)).collect();
            let list = if done.is_empty() { "nothing yet".into() } else { done.join(", ") };
            return Err(SessionError::Refused(format!("{item:?} cannot be repeated; done so far: {list}")));
        }
        self.settle(item, ItemOutcome::Repeat, reason, now);
        for about in self.asked_about(item, true) {
            self.settle(&about, ItemOutcome::Repeat, &format!("{item} is repeated"), now);
        }
        self.save()
    }

    /// Adds a note by the experimenter: `kind` is note, mark, extend or another word.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn note(&mut self, kind: &str, text: &str, now: &str) -> Result<(), SessionError> {
        let item = self.log.running.as_ref().map(|running| running.item.clone());
        self.log.notes.push(SessionNote { at: now.into(), item, kind: kind.into(), text: text.into() });
        self.save()
    }

    /// Stores the parameters of a simulated participant.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn set_parameters(&mut self, traits: BTreeMap<String, f64>) -> Result<(), SessionError> {
        self.log.traits = traits;
        self.save()
    }

    /// Keeps the frame rate that was measured before the first page, or the lower one of an earlier opening.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn set_frames_per_s(&mut self, frames_per_s: f64) -> Result<(), SessionError> {
        let before = self.log.frames_per_s.unwrap_or(f64::INFINITY);
        self.log.frames_per_s = Some(frames_per_s.min(before));
        self.save()
    }

    /// Ends a session whose items are all settled.
    ///
    /// # Errors
    /// Something is left to do, or the file cannot be written.
    pub fn finish(&mut self, now: &str) -> Result<(), SessionError> {
        if let Some((_, planned)) = self.next() {
            return Err(SessionError::Refused(format!("\"{}\" is left to do", planned.name)));
        }
        self.close(true, "", None, now)
    }

    /// Ends the session early and for good, as after sickness. Aborts the running item.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn stop(&mut self, reason: &str, now: &str) -> Result<(), SessionError> {
        self.pass(ItemOutcome::Aborted, reason, now);
        self.close(false, reason, None, now)
    }

    /// Ends the session early and for good for a technical reason, as after a failure of the computer. Aborts the running item.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn stop_technically(&mut self, reason: &str, now: &str) -> Result<(), SessionError> {
        self.pass(ItemOutcome::Aborted, reason, now);
        self.close(false, reason, Some(EndCause::Technical), now)
    }

    fn close(&mut self, complete: bool, reason: &str, cause: Option<EndCause>, now: &str) -> Result<(), SessionError> {
        self.log.end = Some(SessionEnd { complete, reason: reason.into(), at: now.into(), cause, excluded: None });
        self.save()
    }

    /// Excludes the data of a session that is over.
    ///
    /// # Errors
    /// The session is not over, the data are already excluded, or the file cannot be written.
    pub fn exclude(&mut self, reason: &str) -> Result<(), SessionError> {
        match &mut self.log.end {
            Some(SessionEnd { excluded: excluded @ None, .. }) => *excluded = Some(reason.into()),
            Some(_) => return Err(SessionError::Refused("the data are already excluded".into())),
            None => return Err(SessionError::Refused("the session is not over".into())),
        }
        self.save()
    }
}

fn nothing_left(code: &ParticipantCode) -> SessionError {
    SessionError::Refused(format!("nothing is left to do for participant {code}"))
}
