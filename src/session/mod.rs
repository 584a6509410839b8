//! A participant's session, live: its states (page, questions, countdown, drive, rest) and how one follows another. In: what the participant does ([`FormInput`]), what the
//! experimenter decides ([`SessionCommand`](crate::panel::SessionCommand)), elapsed time. Out: screens, drives on a [`DriveBackend`], and every step on the disk
//! (`study::Session`), so that a closed window, a crash or a power cut costs the item that was running and no more.
//!
//! * [`LiveSession`]: the state machine, without window, devices or clock.
//! * `overview`: it as the windows show it.
//! * [`wheel_navigation`]: wheel, pedals and buttons as inputs.
//! * [`drives`]: drives as the window shows them.
//! * `rating`: the sickness scale that is asked while driving.
//! * [`voice`]: spoken instructions.
//! * `command`: what the experimenter decides. `experimenter_view`: what the experimenter sees.
//! * [`window`]: the two windows, and the one place that reads the clock.

mod command;
pub mod drives;
mod experimenter_view;
mod overview;
mod rating;
pub mod voice;
pub mod wheel_navigation;
pub mod window;

use crate::{
    drive_loop::RunError,
    scenario::Scenario,
    study::{
        FormInput, ItemOutcome, PlanItem, PlannedItem, QuestionnaireForm, Session, SessionError, Study, UnbrokenTime,
        fms::FmsScale, session::as_map, stop_rule::SessionEnding,
    },
    units::SpeedUnit,
};
use std::{path::Path, path::PathBuf, time::Duration};

/// A page is seen for so long at least: who presses twice does not miss one. Seconds.
const PAGE_S: f64 = 0.4;
/// The brake is held from this share of its travel on: well above the play of a pedal, and enough against the creep.
const BRAKE_HELD: f64 = 0.08;
/// The most that counts of one frame in the countdown, seconds: it is seen to its end on a slow machine too.
const MOST_FRAME_S: f64 = 0.25;

/// Where drives take place.
pub trait DriveBackend {
    /// Puts a drive at its start and holds it there. False while that goes on: it is asked again, until [`DriveBackend::end`] gives
    /// it up.
    ///
    /// # Errors
    /// It cannot start.
    fn prepare(&mut self, scenario: &Scenario) -> Result<bool, RunError>;
    /// Records the drive in `folder` and lets time run.
    ///
    /// # Errors
    /// The disk refuses.
    fn begin(&mut self, folder: &Path) -> Result<(), RunError>;
    /// Holds time, or lets it run again.
    fn hold(&mut self, held: bool);
    /// Notes something in the recording.
    fn note(&mut self, kind: &str, detail: &str);
    /// The same with a number.
    fn note_value(&mut self, kind: &str, detail: &str, value: f64);
    /// A gentle sound, where there is any: something is asked.
    fn chime(&mut self);
    /// The drive lasts so many seconds longer.
    ///
    /// # Errors
    /// The disk refuses.
    fn extend(&mut self, seconds: f64) -> Result<(), RunError>;
    /// Ends the recording, if there is one, and lets go of the drive.
    ///
    /// # Errors
    /// The disk refuses; what was recorded can be recovered.
    fn end(&mut self) -> Result<(), RunError>;
    /// How the drive stands.
    fn now(&self) -> BackendStatus;
}

/// A moment of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BackendStatus {
    /// Time since its start, seconds.
    pub time_s: f64,
    /// When it ends, seconds.
    pub duration_s: f64,
    /// How long the speed was in the range without a break.
    pub in_range: UnbrokenTime,
    /// How far the brake pedal is pressed, 0 to 1, while the drive has not begun.
    pub brake: f64,
    /// Speed of the participant's car, m/s, and the unit that it is read in.
    pub speed_mps: f64,
    /// Unit of its speedometer.
    pub unit: SpeedUnit,
    /// It is over.
    pub ended: bool,
    /// Time is held.
    pub held: bool,
}

/// Where a session is.
#[derive(Debug)]
enum SessionState {
    /// Nothing runs; the experimenter says when it goes on.
    Hold,
    /// A page of the plan.
    Text(String),
    /// The words before a drive or questions.
    Intro(String),
    /// The drive is being put in place; true once the participant has been told.
    Loading(bool),
    /// Seconds to the start, and whether they are held.
    Countdown(f64, bool),
    Driving,
    /// After a drive.
    Over,
    /// A rest: words and seconds that are left.
    Rest(String, f64),
    Questions(Box<QuestionnaireForm>),
    /// All is settled.
    End,
    /// Stopped for good: the words that the participant reads.
    Stopped(String),
}

/// A session as it goes.
#[derive(Debug)]
pub struct LiveSession {
    session: Session,
    study: Study,
    at: SessionState,
    /// Since the program began, and when the screen came, seconds.
    elapsed_s: f64,
    seen_s: f64,
    /// Folder for the recording of what runs.
    folder: PathBuf,
    asked: bool,
    /// The sickness scale of the drive that runs, where its segment asks it.
    fms: Option<FmsScale>,
    voice: voice::SessionVoice,
    /// The countdown waits for a foot on the brake.
    lacks_brake: bool,
    error: Option<String>,
    /// That was a drive which could not go on.
    drive_failed: bool,
    /// The time of day, UTC.
    utc: fn() -> String,
}

impl LiveSession {
    /// Goes on where `session` is: a new one begins at once, one that was interrupted when the experimenter says so.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn new(study: &Study, session: Session, utc: fn() -> String) -> Result<Self, RunError> {
        let fresh = session.log().passages.is_empty();
        let mut live_session = Self {
            session,
            study: study.clone(),
            at: SessionState::Hold,
            elapsed_s: 0.0,
            seen_s: 0.0,
            folder: PathBuf::new(),
            asked: false,
            fms: None,
            voice: voice::SessionVoice::default(),
            lacks_brake: false,
            error: None,
            drive_failed: false,
            utc,
        };
        if fresh {
            live_session.go_on()?;
        }
        Ok(live_session)
    }

    /// What is on the disk.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// What the study is called.
    pub fn title(&self) -> &str {
        &self.study.file.title
    }

    /// True when nothing comes any more.
    pub fn is_over(&self) -> bool {
        matches!(self.at, SessionState::End | SessionState::Stopped(_))
    }

    /// True while the picture of a drive is seen.
    pub fn drives(&self) -> bool {
        matches!(self.at, SessionState::Countdown(..) | SessionState::Driving)
    }

    /// True if the participant asked to stop and nobody has answered.
    pub fn asked(&self) -> bool {
        self.asked
    }

    /// Time passes.
    ///
    /// # Errors
    /// The session cannot be written.
    pub fn tick(&mut self, elapsed: Duration, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        self.elapsed_s += elapsed.as_secs_f64();
        self.write_voice()?;
        if self.asked {
            // Whatever it is, it waits: the page, the loading, the countdown, the drive, the rest.
            return Ok(());
        }
        let frame_s = elapsed.as_secs_f64().min(MOST_FRAME_S);
        self.lacks_brake = self.waits_for_brake(backend.now());
        if self.lacks_brake {
            self.at = SessionState::Countdown(self.study.file.countdown_s, false);
            return Ok(());
        }
        match &mut self.at {
            SessionState::Loading(told @ false) => *told = true,
            SessionState::Loading(true) => {
                let Some(PlanItem::Drive { scenario, .. }) = self.running().map(|planned| planned.item.clone()) else {
                    return Ok(());
                };
                match backend.prepare(&scenario) {
                    Ok(true) => self.see(SessionState::Countdown(self.study.file.countdown_s, false)),
                    Ok(false) => {}
                    Err(error) => self.fail(&error, backend),
                }
            }
            SessionState::Countdown(left_s, false) => {
                *left_s -= frame_s;
                if *left_s <= 0.0 {
                    match backend.begin(&self.folder) {
                        Ok(()) => {
                            self.begin_ratings();
                            self.see(SessionState::Driving);
                        }
                        Err(error) => self.fail(&error, backend),
                    }
                }
            }
            SessionState::Driving => {
                self.ask_rating(backend)?;
                self.watch(backend)?;
            }
            SessionState::Rest(_, left_s) => *left_s = (*left_s - elapsed.as_secs_f64()).max(0.0),
            _ => {}
        }
        Ok(())
    }

    /// True while a drive that begins at a standstill has no foot on the brake: the countdown begins anew with it.
    fn waits_for_brake(&self, now: BackendStatus) -> bool {
        let is_asked_for = match self.running().map(|planned| &planned.item) {
            Some(PlanItem::Drive { scenario, .. }) => scenario.standing_start,
            _ => false,
        };
        is_asked_for && matches!(self.at, SessionState::Countdown(_, false)) && now.brake < BRAKE_HELD
    }

    /// The drive: is its criterion met, is it over?
    fn watch(&mut self, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let now = backend.now();
        let criterion_s = self.criterion_s().filter(|enough_s| now.in_range.has_reached(*enough_s));
        if let Some(enough_s) = criterion_s {
            backend.note("criterion", &format!("{enough_s} s in the range without a break"));
        }
        if criterion_s.is_none() && !now.ended {
            return Ok(());
        }
        match backend.end() {
            Ok(()) => {
                self.session.end(ItemOutcome::Done, "", &(self.utc)())?;
                self.see(SessionState::Over);
                Ok(())
            }
            Err(error) => {
                self.fail(&error, backend);
                Ok(())
            }
        }
    }

    /// The drive came to an end by an error: it comes again when the experimenter says so. On a full disk the log cannot be
    /// written either, until there is room: it is whole in memory, and a window that is gone explains nothing.
    pub fn fail(&mut self, error: &RunError, backend: &mut dyn DriveBackend) {
        let text = error.to_string();
        log::error!("{text}");
        if let Err(also) = backend.end() {
            log::error!("{also}");
        }
        // The log goes where the data goes: it does not say where that was.
        let reason = match self.folder.to_str() {
            Some(folder) if !folder.is_empty() => text.replace(&format!("{folder}/"), ""),
            _ => text.clone(),
        };
        let kept = self.session.end(ItemOutcome::Aborted, &reason, &(self.utc)());
        self.drive_failed = true;
        self.error = Some(match kept {
            Ok(()) => text,
            Err(also) => format!("{text}\nThe session's log: {also}"),
        });
        self.see(SessionState::Hold);
    }

    /// The program ends before the session: what runs is broken off and comes again.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn close(&mut self, reason: &str, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        self.hush();
        self.write_voice()?;
        self.leave("closed", reason, backend)?;
        Ok(self.session.end(ItemOutcome::Cut, reason, &(self.utc)())?)
    }

    /// The participant does something. After they asked to stop nothing goes on until the experimenter has decided.
    ///
    /// # Errors
    /// The session cannot be written.
    pub fn input(&mut self, input: FormInput, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let seen_for_s = self.elapsed_s - self.seen_s;
        match input {
            FormInput::Stop => return self.ask_to_stop(backend),
            FormInput::Mark => return self.write("mark", "by the participant", backend),
            _ if self.asked => return Ok(()),
            _ => {}
        }
        match &mut self.at {
            SessionState::Questions(form) => {
                // A text is on the disk when the hand goes on, not with each letter.
                let typed = matches!(input, FormInput::Type { .. });
                form.take(input, self.elapsed_s);
                if !form.is_over() && !typed {
                    self.session.keep(form.answered())?;
                } else if form.is_over() {
                    let answers = form.answered();
                    let planned = self.running();
                    let ending = planned.and_then(|planned| self.study.ending(planned, &as_map(&answers)));
                    self.session.end_answered(answers, ending.as_ref(), &(self.utc)())?;
                    match ending {
                        Some(ending) => self.stopped_by(ending),
                        None => self.go_on()?,
                    }
                }
            }
            SessionState::Driving => self.rate(&input, backend)?,
            // A page has nothing to go back to: that button hears it again.
            SessionState::Text(_) | SessionState::Intro(_) | SessionState::Rest(..)
                if matches!(input, FormInput::Again | FormInput::Back) =>
            {
                self.speak();
            }
            _ if !matches!(input, FormInput::Next | FormInput::PageOn) || seen_for_s < PAGE_S => {}
            SessionState::Rest(_, left_s) if *left_s > 0.0 => {}
            SessionState::Text(_) | SessionState::Intro(_) | SessionState::Over | SessionState::Rest(..) => {
                self.turn_page()?
            }
            _ => {}
        }
        Ok(())
    }

    /// A rule of the study has ended the session.
    fn stopped_by(&mut self, ending: SessionEnding) {
        log::info!("the session ends by a rule: {}", ending.reason);
        self.error = Some(format!("the session has ended by a rule of the study: {}", ending.reason));
        self.see(SessionState::Stopped(ending.words));
    }

    /// What comes after a page, a rest or the end of a drive.
    fn turn_page(&mut self) -> Result<(), RunError> {
        match &self.at {
            SessionState::Intro(_) => match self.running().map(|planned| planned.item.clone()) {
                Some(PlanItem::Questions(word)) => self.ask(&word)?,
                _ => self.see(SessionState::Loading(false)),
            },
            SessionState::Text(_) | SessionState::Rest(..) => {
                self.session.end(ItemOutcome::Done, "", &(self.utc)())?;
                self.go_on()?;
            }
            _ => self.go_on()?,
        }
        Ok(())
    }

    fn ask(&mut self, word: &str) -> Result<(), RunError> {
        let Some(questionnaire) = self.study.questionnaires.get(word) else {
            self.see(SessionState::Hold);
            return Ok(());
        };
        let form = QuestionnaireForm::resume(questionnaire, self.session.kept(), self.elapsed_s);
        self.see(SessionState::Questions(Box::new(form)));
        Ok(())
    }

    /// The next item of the plan begins; after the last the session is over.
    fn go_on(&mut self) -> Result<(), RunError> {
        let Some((_, planned)) = self.session.next() else {
            self.session.finish(&(self.utc)())?;
            self.see(SessionState::End);
            return Ok(());
        };
        let PlannedItem { item, text, .. } = planned.clone();
        self.folder = self.session.begin(&(self.utc)())?;
        let texts = &self.study.file.texts;
        let said = |text: String, usual: &String| if text.is_empty() { usual.clone() } else { text };
        match item {
            PlanItem::Text(page) => self.see(SessionState::Text(page)),
            PlanItem::Break(seconds) => {
                let words = said(text, &texts.rest);
                self.see(SessionState::Rest(words, seconds));
            }
            PlanItem::Questions(word) if text.is_empty() => self.ask(&word)?,
            PlanItem::Questions(_) => self.see(SessionState::Intro(text)),
            PlanItem::Drive { .. } => {
                let words = said(text, &texts.ready);
                self.see(SessionState::Intro(words));
            }
        }
        Ok(())
    }

    fn see(&mut self, at: SessionState) {
        self.at = at;
        self.seen_s = self.elapsed_s;
        self.speak();
    }

    /// What runs, as planned.
    fn running(&self) -> Option<&PlannedItem> {
        let name = &self.session.log().running.as_ref()?.item;
        self.session.plan().items.iter().find(|planned| planned.name == *name)
    }

    fn criterion_s(&self) -> Option<f64> {
        match &self.running()?.item {
            PlanItem::Drive { until_in_range_s, .. } => *until_in_range_s,
            _ => None,
        }
    }

    fn ask_to_stop(&mut self, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        if self.asked || self.is_over() {
            return Ok(());
        }
        self.asked = true;
        self.hush();
        if matches!(self.at, SessionState::Driving) {
            backend.hold(true);
        }
        self.write("asked", "the participant asks to stop", backend)
    }

    /// A contact with another car marks its moment in the session's log; the recording has it with its speeds.
    ///
    /// # Errors
    /// The session cannot be written.
    pub fn note_contact(&mut self, words: &str) -> Result<(), RunError> {
        Ok(self.session.note("contact", words, &(self.utc)())?)
    }

    /// Writes something down in the session, and in the recording while one runs.
    fn write(&mut self, kind: &str, text: &str, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        if matches!(self.at, SessionState::Driving) {
            backend.note(kind, text);
        }
        Ok(self.session.note(kind, text, &(self.utc)())?)
    }
}

impl From<SessionError> for CommandRefusal {
    fn from(error: SessionError) -> Self {
        match error {
            SessionError::Refused(text) => Self::Say(text),
            other => Self::End(other.into()),
        }
    }
}

/// Why a command is not obeyed: something to say, or an end.
enum CommandRefusal {
    Say(String),
    End(RunError),
}
