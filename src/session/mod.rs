//! A participant's session, live: its states (page, questions, countdown, drive, rest) and their transitions. In: the participant's input
//! ([`FormInput`]), the experimenter's commands ([`SessionCommand`](crate::panel::SessionCommand)), elapsed time. Out: screens, drives on
//! a [`DriveBackend`], and every step on disk (`study::Session`). A closed window, a crash or a power cut therefore costs only the
//! running item.
//!
//! * [`LiveSession`]: the state machine, without window, devices or clock.
//! * `overview`: the state as the windows show it.
//! * [`wheel_navigation`]: wheel, pedals and buttons as form input.
//! * [`drives`]: drives in the participant's window.
//! * `rating`: the sickness scale that is asked while driving.
//! * [`voice`]: spoken instructions.
//! * `command`: the experimenter's commands. `disk_wait`: the wait for a disk that is full. `experimenter_view`: the experimenter's window.
//! * `admission`: checks before a session. [`window`]: the windows, and the only module that reads the clock.

mod admission;
mod command;
mod disk_wait;
pub mod drives;
mod experimenter_view;
mod overview;
mod practice;
mod rating;
pub mod voice;
pub mod wheel_navigation;
pub mod window;

use self::disk_wait::DiskWait;
use crate::{
    drive_loop::RunError,
    panel::StopRequest,
    scenario::Scenario,
    study::{
        FormInput, ItemOutcome, PlanItem, PlannedItem, PracticeProgress, QuestionnaireForm, Session, SessionError,
        Study, fms::FmsScale, session::as_map, skills::ShownSkills, stop_rule::SessionEnding,
    },
    units::SpeedUnit,
};
use std::{path::Path, path::PathBuf, time::Duration};

/// Minimum time that a page is shown, s, so that a double press does not skip a page.
const PAGE_S: f64 = 0.4;
/// Brake position that counts as pressed, 0 to 1: above the free travel of a pedal, and enough to hold the vehicle against creep.
const BRAKE_HELD: f64 = 0.08;
/// Maximum time that one frame takes off the countdown, s, so that a slow machine also shows the countdown to its end.
const MOST_FRAME_S: f64 = 0.25;

/// Simulation that runs the drives of a session.
pub trait DriveBackend {
    /// Puts a drive at its start and holds it there. Returns false while it is loading; the caller calls again, or gives up by
    /// [`DriveBackend::end`].
    ///
    /// # Errors
    /// The drive cannot start.
    fn prepare(&mut self, scenario: &Scenario) -> Result<bool, RunError>;
    /// Starts time and records the drive in `folder`.
    ///
    /// # Errors
    /// The recording cannot be written.
    fn begin(&mut self, folder: &Path) -> Result<(), RunError>;
    /// Pauses or resumes time.
    fn hold(&mut self, held: bool);
    /// Adds an event to the recording.
    fn note(&mut self, kind: &str, detail: &str);
    /// Adds an event with a value to the recording.
    fn note_value(&mut self, kind: &str, detail: &str, value: f64);
    /// Begins the event of this number in the drive's scenario by hand.
    fn begin_event(&mut self, event: usize);
    /// Plays a gentle sound for a question, if there is an audio device.
    fn chime(&mut self);
    /// Extends the drive by this many seconds.
    ///
    /// # Errors
    /// The recording cannot be written.
    fn extend(&mut self, seconds: f64) -> Result<(), RunError>;
    /// Ends the recording, if there is one, and the drive.
    ///
    /// # Errors
    /// The recording cannot be finished; its rows so far can be recovered.
    fn end(&mut self) -> Result<(), RunError>;
    /// Returns the present status of the drive.
    fn now(&self) -> BackendStatus;
}

/// Status of a drive at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BackendStatus {
    /// Time since the start of the drive, s.
    pub time_s: f64,
    /// Planned duration of the drive, s.
    pub duration_s: f64,
    /// Progress of the drive, if it is for practice.
    pub practice: PracticeProgress,
    /// Position of the brake pedal before the drive begins, 0 to 1.
    pub brake: f64,
    /// Signed speed of the ego, m/s.
    pub speed_mps: f64,
    /// Unit of the ego's speedometer.
    pub unit: SpeedUnit,
    /// True once the drive is over.
    pub ended: bool,
    /// True while time is paused.
    pub held: bool,
}

/// State of a session.
#[derive(Debug)]
enum SessionState {
    /// Nothing runs; waits for the experimenter.
    Hold,
    /// Page of the plan, Markdown.
    Text(String),
    /// Text before a drive or questions, Markdown.
    Intro(String),
    /// The drive is loading; true once the participant's waiting screen was shown.
    Loading(bool),
    /// Time to the start of the drive, s, and true if the countdown is paused.
    Countdown(f64, bool),
    Driving,
    /// Page after a drive.
    Over,
    /// Rest: its text and the remaining time, s.
    Rest(String, f64),
    Questions(Box<QuestionnaireForm>),
    /// All items are settled.
    End,
    /// Stopped for good; the text for the participant.
    Stopped(String),
}

/// State machine of a session.
#[derive(Debug)]
pub struct LiveSession {
    session: Session,
    study: Study,
    at: SessionState,
    /// Time since the program began, and the time when the current screen appeared, s.
    elapsed_s: f64,
    seen_s: f64,
    /// Folder for the recording of the running item.
    folder: PathBuf,
    /// Request to stop that holds everything until the experimenter decides, by the one who made it.
    asked: Option<StopRequest>,
    disk_wait: Option<DiskWait>,
    /// Sickness scale of the running drive, if its segment asks it.
    fms: Option<FmsScale>,
    /// Skills of the running drive that the log has.
    noted_skills: ShownSkills,
    /// Skills that the last drive asked for and that were not shown, by name; empty if there are none.
    missing_skills: String,
    voice: voice::SessionVoice,
    /// True while the countdown waits for the brake pedal.
    lacks_brake: bool,
    error: Option<String>,
    /// True if `error` is about a drive that could not go on.
    drive_failed: bool,
    /// Returns the time of day, UTC.
    utc: fn() -> String,
}

impl LiveSession {
    /// Continues a session: a new one begins at once, an interrupted one waits for the experimenter.
    ///
    /// # Errors
    /// The session cannot be written.
    pub fn new(study: &Study, session: Session, utc: fn() -> String) -> Result<Self, RunError> {
        let fresh = session.log().item_runs.is_empty();
        let mut live_session = Self {
            session,
            study: study.clone(),
            at: SessionState::Hold,
            elapsed_s: 0.0,
            seen_s: 0.0,
            folder: PathBuf::new(),
            asked: None,
            disk_wait: None,
            fms: None,
            noted_skills: ShownSkills::default(),
            missing_skills: String::new(),
            voice: voice::SessionVoice::default(),
            lacks_brake: false,
            error: None,
            drive_failed: false,
            utc,
        };
        if fresh {
            live_session.begin_next_item()?;
        }
        Ok(live_session)
    }

    /// Returns the session as stored on disk.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Returns the title of the study.
    pub fn title(&self) -> &str {
        &self.study.file.title
    }

    /// Returns true if no more items come.
    pub fn is_over(&self) -> bool {
        matches!(self.at, SessionState::End | SessionState::Stopped(_))
    }

    /// Returns true while the picture of a drive is shown.
    pub fn drives(&self) -> bool {
        matches!(self.at, SessionState::Countdown(..) | SessionState::Driving)
    }

    /// Returns the request to stop that the experimenter has not decided yet.
    pub fn asked(&self) -> Option<StopRequest> {
        self.asked
    }

    /// Advances the session by the elapsed time. Nothing goes on while the log cannot be written.
    ///
    /// # Errors
    /// The drive cannot go on.
    pub fn tick(&mut self, elapsed: Duration, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        self.elapsed_s += elapsed.as_secs_f64();
        if self.pass_disk_wait(elapsed) {
            return Ok(());
        }
        let advanced = self.advance(elapsed, backend);
        self.or_wait(advanced, backend)
    }

    fn advance(&mut self, elapsed: Duration, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        self.write_voice()?;
        if self.asked.is_some() {
            // A request to stop holds every state: page, loading, countdown, drive, rest.
            return Ok(());
        }
        let frame_s = elapsed.as_secs_f64().min(MOST_FRAME_S);
        self.lacks_brake = self.waits_for_brake(backend.now());
        if self.lacks_brake {
            self.at = SessionState::Countdown(self.study.file.countdown_s, false);
            return Ok(());
        }
        match &mut self.at {
            SessionState::Loading(is_shown @ false) => *is_shown = true,
            SessionState::Loading(true) => {
                let Some(PlanItem::Drive { scenario, .. }) = self.running().map(|planned| planned.item.clone()) else {
                    return Ok(());
                };
                match backend.prepare(&scenario) {
                    Ok(true) => self.enter(SessionState::Countdown(self.study.file.countdown_s, false)),
                    Ok(false) => {}
                    Err(error) => self.fail(&error, backend),
                }
            }
            SessionState::Countdown(left_s, false) => {
                *left_s -= frame_s;
                if *left_s <= 0.0 {
                    match backend.begin(&self.folder) {
                        Ok(()) => {
                            self.begin_practice();
                            self.begin_ratings();
                            self.enter(SessionState::Driving);
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
            // Its end waited for the disk.
            SessionState::Questions(_) if self.session.log().running.is_none() => self.begin_next_item()?,
            _ => {}
        }
        Ok(())
    }

    /// Returns true during the countdown to a standing start while the brake is not pressed; the countdown then restarts.
    fn waits_for_brake(&self, now: BackendStatus) -> bool {
        let is_asked_for = match self.running().map(|planned| &planned.item) {
            Some(PlanItem::Drive { scenario, .. }) => scenario.standing_start,
            _ => false,
        };
        is_asked_for && matches!(self.at, SessionState::Countdown(_, false)) && now.brake < BRAKE_HELD
    }

    /// Ends a drive because of an error; it comes again on the experimenter's command. If the disk is full, the log stays complete in
    /// memory until it can be written. The window stays open to show the error.
    pub fn fail(&mut self, error: &RunError, backend: &mut dyn DriveBackend) {
        let text = error.to_string();
        log::error!("{text}");
        if let Err(also) = backend.end() {
            log::error!("{also}");
        }
        // The log must not contain the path of the data folder.
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
        self.enter(SessionState::Hold);
        // An error in writing stays with the session, which waits for the disk.
        let _ = self.or_wait(Ok(()), backend);
    }

    /// Interrupts the running item because the program ends; it comes again.
    ///
    /// # Errors
    /// The session or the recording cannot be written.
    pub fn close(&mut self, reason: &str, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        self.stop_spoken_text();
        self.write_voice()?;
        self.leave("closed", reason, backend)?;
        Ok(self.session.end(ItemOutcome::Cut, reason, &(self.utc)())?)
    }

    /// Handles the participant's input. After a request to stop, and while the log cannot be written, only marks and requests to stop are taken.
    ///
    /// # Errors
    /// The drive cannot go on.
    pub fn input(&mut self, input: FormInput, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let done = match input {
            FormInput::Stop => self.hold_everything(StopRequest::Participant, backend),
            FormInput::Mark => self.write("mark", "by the participant", backend),
            _ if self.asked.is_some() || self.waits_for_disk() => return Ok(()),
            input => self.go_on(input, backend),
        };
        self.or_wait(done, backend)
    }

    /// Applies input to the present screen.
    fn go_on(&mut self, input: FormInput, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let seen_for_s = self.elapsed_s - self.seen_s;
        match &mut self.at {
            SessionState::Questions(form) => {
                // Text is saved when the participant moves on, not with each letter.
                let typed = matches!(input, FormInput::Type { .. });
                form.take(input, self.elapsed_s);
                if !form.is_over() && !typed {
                    self.session.keep(form.answered())?;
                } else if form.is_over() {
                    let answers = form.answered();
                    let planned = self.running();
                    let ending = planned.and_then(|planned| self.study.ending(planned, &as_map(&answers)));
                    let ended = self.session.end_answered(answers, ending.as_ref(), &(self.utc)());
                    if let Some(ending) = ending {
                        self.stopped_by(ending);
                    } else if ended.is_ok() {
                        self.begin_next_item()?;
                    }
                    ended?;
                }
            }
            SessionState::Driving => self.rate(&input, backend)?,
            // A page has no previous stop, so the back button plays the spoken text again.
            SessionState::Text(_) | SessionState::Intro(_) | SessionState::Rest(..)
                if matches!(input, FormInput::Again | FormInput::Back) =>
            {
                self.play_spoken_text();
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

    /// Shows the end of the session by a rule of the study.
    fn stopped_by(&mut self, ending: SessionEnding) {
        log::info!("the session ends by a rule: {}", ending.reason);
        self.error = Some(format!("the session has ended by a rule of the study: {}", ending.reason));
        self.enter(SessionState::Stopped(ending.words));
    }

    /// Continues after a page, a rest or the end of a drive.
    fn turn_page(&mut self) -> Result<(), RunError> {
        match &self.at {
            SessionState::Intro(_) => match self.running().map(|planned| planned.item.clone()) {
                Some(PlanItem::Questions(word)) => self.show_questionnaire(&word)?,
                _ => self.enter(SessionState::Loading(false)),
            },
            SessionState::Text(_) | SessionState::Rest(..) => {
                self.session.end(ItemOutcome::Done, "", &(self.utc)())?;
                self.begin_next_item()?;
            }
            _ => self.begin_next_item()?,
        }
        Ok(())
    }

    fn show_questionnaire(&mut self, word: &str) -> Result<(), RunError> {
        let Some(questionnaire) = self.study.questionnaires.get(word) else {
            self.enter(SessionState::Hold);
            return Ok(());
        };
        let form = QuestionnaireForm::resume(questionnaire, self.session.kept(), self.elapsed_s);
        self.enter(SessionState::Questions(Box::new(form)));
        Ok(())
    }

    /// Begins the next item of the plan; after the last, ends the session.
    fn begin_next_item(&mut self) -> Result<(), RunError> {
        let Some((_, planned)) = self.session.next() else {
            self.session.finish(&(self.utc)())?;
            self.enter(SessionState::End);
            return Ok(());
        };
        let PlannedItem { item, text, .. } = planned.clone();
        self.folder = self.session.begin(&(self.utc)())?;
        let texts = &self.study.file.texts;
        let text_or = |text: String, usual: &String| if text.is_empty() { usual.clone() } else { text };
        match item {
            PlanItem::Text(page) => self.enter(SessionState::Text(page)),
            PlanItem::Break(seconds) => {
                let words = text_or(text, &texts.rest);
                self.enter(SessionState::Rest(words, seconds));
            }
            PlanItem::Questions(word) if text.is_empty() => self.show_questionnaire(&word)?,
            PlanItem::Questions(_) => self.enter(SessionState::Intro(text)),
            PlanItem::Drive { .. } => {
                let words = text_or(text, &texts.ready);
                self.enter(SessionState::Intro(words));
            }
        }
        Ok(())
    }

    fn enter(&mut self, at: SessionState) {
        self.at = at;
        self.seen_s = self.elapsed_s;
        self.play_spoken_text();
    }

    /// Returns the running item as planned.
    fn running(&self) -> Option<&PlannedItem> {
        let name = &self.session.log().running.as_ref()?.item;
        self.session.plan().items.iter().find(|planned| planned.name == *name)
    }

    /// Holds drive, voice and screens before any question is asked, until the experimenter decides.
    fn hold_everything(&mut self, by: StopRequest, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        if self.asked.is_some() || self.is_over() {
            return Ok(());
        }
        self.asked = Some(by);
        self.stop_spoken_text();
        if matches!(self.at, SessionState::Driving) {
            backend.hold(true);
        }
        match by {
            StopRequest::Participant => self.write("asked", "the participant asks to stop", backend),
            StopRequest::Experimenter => self.write("paused", "by the experimenter, who may stop", backend),
        }
    }

    /// Notes a contact with another vehicle in the session log. The recording has the contact with its speeds.
    ///
    /// # Errors
    /// The session refuses notes.
    pub fn note_contact(&mut self, words: &str, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let noted = self.session.note("contact", words, &(self.utc)());
        self.or_wait(noted.map_err(RunError::from), backend)
    }

    /// Writes a note to the session log, and to the recording while a drive runs.
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
            SessionError::Refused(text) => Self::Message(text),
            other => Self::Failure(other.into()),
        }
    }
}

/// Reason why a command is not carried out: a message for the experimenter, or an error that ends the session.
enum CommandRefusal {
    Message(String),
    Failure(RunError),
}
