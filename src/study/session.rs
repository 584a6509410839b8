//! One participant's session as it goes. In: the plan, what the participant did, what the experimenter decides, and the time
//! as whoever has a clock reads it. Out: what comes next; a small file that says so after every step, so that a session
//! goes on at the right place after a crash, a power cut or a closed window.
//!
//! The file is `sourcedata/sub-CODE/session.json`; recordings lie beside it, each attempt in a folder of its own. An item
//! is settled when its last passage was done or skipped; the first that is not settled comes next. A lock keeps a second
//! program away.

use super::{Code, DataSet, Plan, Planned, SessionError, Study, lock, questions::Answers};
use crate::{
    file,
    record::{self, RecordError},
};
use fail::fail_point;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::{
    collections::BTreeMap,
    fs::{self, File},
    path::{Path, PathBuf},
};

/// Name of the file.
pub const FILE: &str = "session.json";
/// The most that is read of it, bytes: a note every ten seconds of a day takes less.
const MOST_BYTES: u64 = 8 << 20;

/// How a passage through an item ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// To its end.
    Done,
    /// Broken off; the item comes again.
    Aborted,
    /// The program or the power went away; the item comes again.
    Cut,
    /// Left out by the experimenter.
    Skipped,
    /// It was done, and the experimenter wants it once more.
    Repeat,
}

impl Outcome {
    fn settles(self) -> bool {
        matches!(self, Self::Done | Self::Skipped)
    }
}

/// One passage through an item.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SegmentRecord {
    /// Name of the item in the plan.
    pub item: String,
    /// How it ended.
    pub outcome: Outcome,
    /// Why, in the experimenter's words; empty where nothing is to be said.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// When it began and ended, UTC.
    pub began: String,
    /// When it ended, UTC.
    pub ended: String,
    /// Folder of its recording, beside the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// What had been answered of a questionnaire that did not come to its end.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<TimedAnswer>,
}

/// What happens now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Running {
    /// Name of the item.
    pub item: String,
    /// Folder for its recording, beside the file.
    pub recording: String,
    /// When it began, UTC.
    pub began: String,
    /// What has been answered, of a questionnaire.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<TimedAnswer>,
}

/// Something that an experimenter writes down: a note, a mark, an extension.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Note {
    /// When, UTC.
    pub at: String,
    /// The item that was running.
    pub item: Option<String>,
    /// note, mark, extend, ...
    pub kind: String,
    /// In words.
    pub text: String,
}

/// One answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimedAnswer {
    /// Name of the question; of a matrix `name.row`.
    pub question: String,
    /// The answer.
    pub answer: Value,
    /// From seeing the page to this answer, seconds.
    pub time_s: f64,
}

/// How a session ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct End {
    /// All items are settled, done or skipped; false: stopped before, as after sickness.
    pub complete: bool,
    /// Why it was stopped.
    pub reason: String,
    /// When, UTC.
    pub at: String,
    /// Why its data are excluded from the study, where they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub excluded: Option<String>,
}

/// Who drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Who {
    /// A person.
    Person,
    /// A simulated participant.
    Simulated,
}

/// What the file holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Log {
    /// Whose session.
    pub participant: Code,
    /// The participant's number in the study, from 0: which order of conditions.
    pub index: usize,
    /// A person, or a rehearsal.
    pub who: Who,
    /// Numbers of a simulated participant, by name with unit.
    #[serde(default)]
    pub traits: BTreeMap<String, f64>,
    /// Conditions in this participant's order.
    pub order: Vec<String>,
    /// Now running; what stands here when the file is opened was cut.
    #[serde(default)]
    pub running: Option<Running>,
    /// What was, in order.
    pub passages: Vec<SegmentRecord>,
    /// What was written down.
    #[serde(default)]
    pub notes: Vec<Note>,
    /// Answers by the item's name: of its last passage.
    #[serde(default)]
    pub answers: BTreeMap<String, Vec<TimedAnswer>>,
    /// Set once the session is over for good.
    #[serde(default)]
    pub end: Option<End>,
}

impl Log {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn load(path: &Path) -> Result<Self, SessionError> {
        let refused = |why: String| {
            SessionError::Refused(format!(
                "{}: {why}; put back a copy of it, or begin with another participant code",
                path.display()
            ))
        };
        let text = file::read_text(path, MOST_BYTES).map_err(|e| refused(format!("cannot be read: {e}")))?;
        serde_json::from_str(&text).map_err(|e| refused(format!("is no session of this program: {e}")))
    }

    /// The last passage through an item.
    pub fn last(&self, item: &str) -> Option<&SegmentRecord> {
        self.passages.iter().rfind(|passage| passage.item == item)
    }

    /// True if the item was done or skipped and not called back.
    pub fn settled(&self, item: &str) -> bool {
        self.last(item).is_some_and(|passage| passage.outcome.settles())
    }

    /// The last passage through an item that went to its end, unless it was called back or skipped.
    pub fn done(&self, item: &str) -> Option<&SegmentRecord> {
        self.last(item).filter(|passage| passage.outcome == Outcome::Done)
    }
}

/// A session.
#[derive(Debug)]
pub struct Session {
    folder: PathBuf,
    plan: Plan,
    log: Log,
    /// Held as long as the session is open; the system lets go of it when the program is gone.
    _lock: File,
}

impl Session {
    /// Opens a participant's session, a new one or one that was interrupted. `index` is the place in the study's orders
    /// that a new participant takes. What a cut left running is noted as cut and its recording is made whole.
    ///
    /// # Errors
    /// The session is over, another program runs it, or its files are not of this study.
    pub fn open(
        data: &DataSet,
        study: &Study,
        code: &Code,
        who: Who,
        index: usize,
        now: &str,
    ) -> Result<Self, SessionError> {
        data.check_new_code(code)?;
        let folder = data.source(code);
        record::new_private_dir(&folder)?;
        let lock = lock::lock(&folder, code)?;
        let path = folder.join(FILE);
        let log = if path.exists() { Log::load(&path)? } else { Self::first(&folder, study, code, who, index)? };
        let refused = |why: String| Err(SessionError::Refused(why));
        if log.participant != *code {
            return refused(format!("{}: is of participant {}", path.display(), log.participant));
        }
        if log.who != who {
            let is = if log.who == Who::Person { "a person" } else { "simulated" };
            return refused(format!("participant {code} is {is}; take another code"));
        }
        if let Some(end) = &log.end {
            return refused(if end.complete {
                format!("participant {code} has been through the whole study ({}); nobody takes part twice", end.at)
            } else {
                format!("the session of participant {code} was stopped for good ({}, {})", end.reason, end.at)
            });
        }
        let mut session = Self { folder, plan: study.plan(log.index), log, _lock: lock };
        session.mend(now)?;
        Ok(session)
    }

    /// Opens a session that has begun, over or not, while its windows are closed.
    ///
    /// # Errors
    /// There is none, or a program runs it; it cannot be read.
    pub(super) fn reopen(data: &DataSet, study: &Study, code: &Code, now: &str) -> Result<Self, SessionError> {
        let folder = data.source(code);
        let lock = lock::lock(&folder, code)?;
        let log = Log::load(&folder.join(FILE))?;
        let mut session = Self { folder, plan: study.plan(log.index), log, _lock: lock };
        session.mend(now)?;
        Ok(session)
    }

    /// Notes what a cut left running, and makes its recording whole.
    fn mend(&mut self, now: &str) -> Result<(), SessionError> {
        if let Some(running) = self.log.running.take() {
            let recording = self.folder.join(&running.recording);
            match record::recover(&recording) {
                Ok(_) | Err(RecordError::Absent(_)) => {}
                Err(error) => return Err(error.into()),
            }
            let recording = recording.exists().then_some(running.recording);
            let Running { item, began, answers, .. } = running;
            let reason = "the program ended".into();
            let (outcome, ended) = (Outcome::Cut, now.into());
            self.log.passages.push(SegmentRecord { item, outcome, reason, began, ended, recording, answers });
        }
        self.save()
    }

    fn first(folder: &Path, study: &Study, code: &Code, who: Who, index: usize) -> Result<Log, SessionError> {
        let left = fs::read_dir(folder).map_err(|why| RecordError::File { path: folder.into(), why })?;
        // Cut while it was saved for the first time, it is there under the name of a file that is not whole.
        let unfinished = Path::new(FILE).with_extension(record::BESIDE);
        let left = left.flatten().map(|entry| entry.file_name()).find(|name| name != lock::FILE && *name != unfinished);
        if let Some(left) = left {
            return Err(SessionError::Refused(format!(
                "{} holds {} but no {FILE}: put that back, or begin with another participant code",
                folder.display(),
                left.display()
            )));
        }
        Ok(Log {
            participant: code.clone(),
            index,
            who,
            traits: BTreeMap::new(),
            order: study.plan(index).order,
            running: None,
            passages: Vec::new(),
            notes: Vec::new(),
            answers: BTreeMap::new(),
            end: None,
        })
    }

    fn save(&self) -> Result<(), SessionError> {
        let text = serde_json::to_string_pretty(&self.log).expect("numbers and words");
        Ok(record::replace(&self.folder.join(FILE), (text + "\n").as_bytes())?)
    }

    /// What was so far.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// The whole session.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Folder of the participant's recordings.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What comes next, and its place in the plan; `None` when all is settled.
    pub fn next(&self) -> Option<(usize, &Planned)> {
        self.plan.items.iter().enumerate().find(|(_, planned)| !self.log.settled(&planned.name))
    }

    /// The next item begins. Returns the folder for its recording, which is not there yet.
    ///
    /// # Errors
    /// Nothing is left to do, or the disk refuses.
    pub fn begin(&mut self, now: &str) -> Result<PathBuf, SessionError> {
        let Some((_, planned)) = self.next() else { return Err(nothing_left(&self.log.participant)) };
        let item = planned.name.clone();
        let before = self.log.passages.iter().filter(|p| p.item == item && p.recording.is_some()).count();
        let recording = if before == 0 { item.clone() } else { format!("{item}-again-{before}") };
        let folder = self.folder.join(&recording);
        // What was answered before a cut is not lost by another one before the first new answer.
        let cut = self.log.last(&item).filter(|passage| passage.outcome == Outcome::Cut);
        let answers = cut.map_or(Vec::new(), |passage| passage.answers.clone());
        self.log.running = Some(Running { item, recording, began: now.into(), answers });
        self.save()?;
        fail_point!("session.begin");
        Ok(folder)
    }

    /// The running item has ended.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn end(&mut self, outcome: Outcome, reason: &str, now: &str) -> Result<(), SessionError> {
        let Some(running) = self.log.running.take() else { return Ok(()) };
        let recording = self.folder.join(&running.recording).exists().then_some(running.recording);
        self.log.passages.push(SegmentRecord {
            item: running.item,
            outcome,
            reason: reason.into(),
            began: running.began,
            ended: now.into(),
            recording,
            answers: running.answers,
        });
        self.save()?;
        fail_point!("session.end");
        Ok(())
    }

    /// What has been answered of the running questionnaire; it is on the disk at once, if it is new.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn keep(&mut self, answers: Vec<TimedAnswer>) -> Result<(), SessionError> {
        match &mut self.log.running {
            Some(running) if running.answers != answers => running.answers = answers,
            _ => return Ok(()),
        }
        self.save()
    }

    /// What has been answered of the running questionnaire, also before it was cut: the participant goes on with it.
    pub fn kept(&self) -> &[TimedAnswer] {
        self.log.running.as_ref().map_or(&[], |running| &running.answers)
    }

    /// The running questionnaire was answered.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn end_answered(&mut self, answers: Vec<TimedAnswer>, now: &str) -> Result<(), SessionError> {
        if let Some(running) = &mut self.log.running {
            running.answers.clear();
            self.log.answers.insert(running.item.clone(), answers);
        }
        self.end(Outcome::Done, "", now)
    }

    /// The experimenter leaves out what comes next, or what runs.
    ///
    /// # Errors
    /// Nothing is left to do, or the disk refuses.
    pub fn skip(&mut self, reason: &str, now: &str) -> Result<(), SessionError> {
        if self.log.running.is_none() {
            self.begin(now)?;
        }
        self.end(Outcome::Skipped, reason, now)
    }

    /// The experimenter wants an item of the plan once more; it comes next.
    ///
    /// # Errors
    /// There is no such item, it has not been yet, or the disk refuses.
    pub fn repeat(&mut self, item: &str, reason: &str, now: &str) -> Result<(), SessionError> {
        if !self.log.settled(item) {
            let done: Vec<&str> =
                self.plan.items.iter().map(|p| p.name.as_str()).filter(|n| self.log.settled(n)).collect();
            let list = if done.is_empty() { "nothing yet".into() } else { done.join(", ") };
            return Err(SessionError::Refused(format!("{item:?} cannot be repeated; what has been is {list}")));
        }
        self.log.passages.push(SegmentRecord {
            item: item.into(),
            outcome: Outcome::Repeat,
            reason: reason.into(),
            began: now.into(),
            ended: now.into(),
            recording: None,
            answers: Vec::new(),
        });
        self.save()
    }

    /// The experimenter writes something down: `kind` is note, mark, extend or another word.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn note(&mut self, kind: &str, text: &str, now: &str) -> Result<(), SessionError> {
        let item = self.log.running.as_ref().map(|running| running.item.clone());
        self.log.notes.push(Note { at: now.into(), item, kind: kind.into(), text: text.into() });
        self.save()
    }

    /// Numbers of a simulated participant.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn set_traits(&mut self, traits: BTreeMap<String, f64>) -> Result<(), SessionError> {
        self.log.traits = traits;
        self.save()
    }

    /// All is settled: the session is over.
    ///
    /// # Errors
    /// Something is left to do, or the disk refuses.
    pub fn finish(&mut self, now: &str) -> Result<(), SessionError> {
        if let Some((_, planned)) = self.next() {
            return Err(SessionError::Refused(format!("\"{}\" is left to do", planned.name)));
        }
        self.close(true, "", now)
    }

    /// The session is over before its end and cannot go on, as after sickness. What runs is aborted.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn stop(&mut self, reason: &str, now: &str) -> Result<(), SessionError> {
        self.end(Outcome::Aborted, reason, now)?;
        self.close(false, reason, now)
    }

    fn close(&mut self, complete: bool, reason: &str, now: &str) -> Result<(), SessionError> {
        self.log.end = Some(End { complete, reason: reason.into(), at: now.into(), excluded: None });
        self.save()
    }

    /// The data of a session that is over are not to be used.
    ///
    /// # Errors
    /// It is not over, or they are excluded already; the disk refuses.
    pub fn exclude(&mut self, reason: &str) -> Result<(), SessionError> {
        match &mut self.log.end {
            Some(End { excluded: excluded @ None, .. }) => *excluded = Some(reason.into()),
            Some(_) => return Err(SessionError::Refused("the data are excluded already".into())),
            None => return Err(SessionError::Refused("the session is not over".into())),
        }
        self.save()
    }
}

/// Answers as scores want them.
pub fn as_map(answered: &[TimedAnswer]) -> Answers {
    answered.iter().map(|a| (a.question.clone(), a.answer.clone())).collect()
}

fn nothing_left(code: &Code) -> SessionError {
    SessionError::Refused(format!("nothing is left to do for participant {code}"))
}
