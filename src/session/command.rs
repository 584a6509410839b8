//! The experimenter's commands in a session. In: a [`SessionCommand`]. Out: the session's new state, and the decision with time and
//! reason in the session log; while a drive runs, also in its recording.

use super::{CommandRefusal, DriveBackend, LiveSession, SessionState};
use crate::{
    drive_loop::RunError,
    panel::{SessionCommand, StopRequest},
    study::{ItemOutcome, Session, SessionError},
};

/// Kind of the notes with words that were typed in the panel and not entered.
pub const DRAFT: &str = "draft";

impl From<RunError> for CommandRefusal {
    fn from(error: RunError) -> Self {
        Self::Failure(error)
    }
}

impl LiveSession {
    /// Carries out a command of the experimenter. A refusal is shown in the panel. While the log cannot be written, commands that go on with the
    /// plan are not carried out.
    ///
    /// # Errors
    /// The drive cannot go on.
    pub fn command(&mut self, command: SessionCommand, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        self.write_again();
        if self.waits_for_disk() && !Self::may_wait(&command) {
            return Ok(());
        }
        (self.error, self.drive_failed) = (None, false);
        let done = match self.obey(command, backend) {
            Ok(()) => Ok(()),
            Err(CommandRefusal::Message(text)) => {
                self.error = Some(text);
                Ok(())
            }
            Err(CommandRefusal::Failure(error)) => Err(error),
        };
        self.or_wait(done, backend)
    }

    fn obey(&mut self, command: SessionCommand, backend: &mut dyn DriveBackend) -> Result<(), CommandRefusal> {
        match command {
            SessionCommand::Go => self.go(backend),
            SessionCommand::Abort(reason) => self.abort(&reason, backend),
            SessionCommand::Skip(reason) => self.skip(&reason, backend),
            SessionCommand::Repeat { item, reason } => {
                if self.session.log().running.as_ref().is_some_and(|running| running.item == item) {
                    return self.abort(&reason, backend);
                }
                self.not_over()?;
                Ok(self.session.repeat(&item, &reason, &(self.utc)())?)
            }
            SessionCommand::Extend { seconds, reason } => self.extend(seconds, &reason, backend),
            SessionCommand::Note(text) => Ok(self.write("note", &text, backend)?),
            SessionCommand::Draft(text) => Ok(self.session.note(DRAFT, &text, &(self.utc)())?),
            SessionCommand::Hold => Ok(self.hold_everything(StopRequest::Experimenter, backend)?),
            SessionCommand::Mark(text) => {
                let text = if text.is_empty() { "by the experimenter" } else { &text };
                Ok(self.write("mark", text, backend)?)
            }
            SessionCommand::BeginEvent(event) => {
                backend.begin_event(event);
                Ok(())
            }
            SessionCommand::Close | SessionCommand::Interrupt(_) => Ok(()),
            SessionCommand::Pause => self.hold(true, backend),
            SessionCommand::Resume => self.hold(false, backend),
            SessionCommand::Stop(reason) => self.stop(&reason, Session::stop, backend),
            SessionCommand::StopTechnically(reason) => self.stop(&reason, Session::stop_technically, backend),
            SessionCommand::Exclude(reason) => {
                if !self.is_over() {
                    self.end_for_good(["excluded", &reason], Session::stop, backend);
                }
                Ok(self.session.exclude(&reason)?)
            }
        }
    }

    /// Ends the session for good, in the log by `end`.
    fn stop(
        &mut self,
        reason: &str,
        end: fn(&mut Session, &str, &str) -> Result<(), SessionError>,
        backend: &mut dyn DriveBackend,
    ) -> Result<(), CommandRefusal> {
        self.not_over()?;
        self.end_for_good(["stopped", reason], end, backend);
        Ok(())
    }

    /// Ends drive and session, whatever the disk says: the end stands in memory until it is written.
    fn end_for_good(
        &mut self,
        [kind, reason]: [&str; 2],
        end: fn(&mut Session, &str, &str) -> Result<(), SessionError>,
        backend: &mut dyn DriveBackend,
    ) {
        self.stop_spoken_text();
        self.end_drive(kind, reason, backend);
        if let Err(error) =
            self.write_voice().and(end(&mut self.session, reason, &(self.utc)()).map_err(RunError::from))
        {
            log::error!("{error}");
        }
        self.asked = None;
        self.enter(SessionState::Stopped(self.study.file.texts.stopped.clone()));
    }

    fn not_over(&self) -> Result<(), CommandRefusal> {
        if self.is_over() { Err(CommandRefusal::Message("the session is over".into())) } else { Ok(()) }
    }

    fn go(&mut self, backend: &mut dyn DriveBackend) -> Result<(), CommandRefusal> {
        if self.asked.is_some() {
            return self.hold(false, backend);
        }
        match &self.at {
            SessionState::Hold => self.begin_next_item()?,
            SessionState::Rest(_, left_s) => {
                if *left_s > 0.0 {
                    let text = format!("the rest ends {left_s:.0} s sooner");
                    self.write("go", &text, backend)?;
                }
                self.turn_page()?;
            }
            SessionState::Text(_) | SessionState::Intro(_) | SessionState::Over => self.turn_page()?,
            SessionState::Countdown(..) | SessionState::Driving => return self.hold(false, backend),
            SessionState::Questions(_) => {
                let text = "the participant must answer the questions first; Skip skips them";
                return Err(CommandRefusal::Message(text.into()));
            }
            SessionState::Loading(_) | SessionState::End | SessionState::Stopped(_) => {}
        }
        Ok(())
    }

    /// Pauses or resumes a drive or its countdown. Resuming also clears a participant's request to stop, in any state.
    fn hold(&mut self, held: bool, backend: &mut dyn DriveBackend) -> Result<(), CommandRefusal> {
        let asked = !held && self.asked.take().is_some();
        let was = match &mut self.at {
            SessionState::Countdown(_, now) => std::mem::replace(now, held),
            SessionState::Driving => {
                let was = backend.now().held;
                backend.hold(held);
                was
            }
            _ if asked => true,
            _ => return Err(CommandRefusal::Message("there is no drive to pause".into())),
        };
        if asked || was != held {
            self.write(if held { "paused" } else { "resumed" }, "by the experimenter", backend)?;
        }
        Ok(())
    }

    /// Leaves the current item: ends its drive, if there is one, with a note in its recording, and keeps what was typed in its questionnaire.
    ///
    /// # Errors
    /// The recording cannot be finished, or the session cannot be written.
    pub(super) fn leave(&mut self, kind: &str, reason: &str, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        if let SessionState::Questions(form) = &self.at {
            self.session.keep(form.answered())?;
        }
        if matches!(self.at, SessionState::Driving) {
            backend.note(kind, reason);
        }
        if self.drives() || matches!(self.at, SessionState::Loading(_)) {
            backend.end()?;
        }
        Ok(())
    }

    /// Leaves the current item, also if its recording cannot be finished: the experimenter then sees the reason. Returns true if there was a drive or
    /// one was loading.
    fn end_drive(&mut self, kind: &str, reason: &str, backend: &mut dyn DriveBackend) -> bool {
        let drives = self.drives() || matches!(self.at, SessionState::Loading(_));
        if let Err(error) = self.leave(kind, reason, backend) {
            log::error!("{error}");
            self.error = drives.then(|| error.to_string());
        }
        drives
    }

    fn abort(&mut self, reason: &str, backend: &mut dyn DriveBackend) -> Result<(), CommandRefusal> {
        if self.session.log().running.is_none() {
            return Err(CommandRefusal::Message("there is no item to break off".into()));
        }
        self.end_drive("aborted", reason, backend);
        let ended = self.session.end(ItemOutcome::Aborted, reason, &(self.utc)());
        self.asked = None;
        self.enter(SessionState::Hold);
        Ok(ended?)
    }

    fn skip(&mut self, reason: &str, backend: &mut dyn DriveBackend) -> Result<(), CommandRefusal> {
        self.not_over()?;
        if self.session.next().is_some_and(|(_, planned)| self.study.is_consent(planned)) {
            let text = "a participant without consent cannot take part; Stop ends the session";
            return Err(CommandRefusal::Message(text.into()));
        }
        let runs = self.session.log().running.is_some();
        let drove = self.end_drive("skipped", reason, backend);
        let skipped = self.session.skip(reason, &(self.utc)());
        self.asked = None;
        if drove || (runs && skipped.is_err()) {
            self.enter(SessionState::Hold);
        } else if runs {
            self.begin_next_item()?;
        }
        Ok(skipped?)
    }

    fn extend(&mut self, seconds: f64, reason: &str, backend: &mut dyn DriveBackend) -> Result<(), CommandRefusal> {
        if !(1.0..=3600.0).contains(&seconds) {
            return Err(CommandRefusal::Message(format!("the extension is {seconds} s; allowed: 1 to 3600 s")));
        }
        match &mut self.at {
            SessionState::Driving => {
                if let Err(error) = backend.extend(seconds) {
                    self.fail(&error, backend);
                    return Ok(());
                }
            }
            SessionState::Rest(_, left_s) => *left_s += seconds,
            _ => return Err(CommandRefusal::Message("there is no drive or rest to extend".into())),
        }
        Ok(self.write("extended", &format!("by {seconds} s: {reason}"), backend)?)
    }
}
