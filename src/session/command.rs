//! The experimenter's commands in a session. In: a [`SessionCommand`]. Out: the session's new state, and the decision with time and
//! reason in the session log; while a drive runs, also in its recording.

use super::{CommandRefusal, DriveBackend, LiveSession, SessionState};
use crate::{
    drive_loop::RunError,
    panel::SessionCommand,
    study::{ItemOutcome, Session, SessionError},
};

impl From<RunError> for CommandRefusal {
    fn from(error: RunError) -> Self {
        Self::Failure(error)
    }
}

impl LiveSession {
    /// Carries out a command of the experimenter. A refusal is shown in the panel.
    ///
    /// # Errors
    /// The session cannot be written.
    pub fn command(&mut self, command: SessionCommand, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        (self.error, self.drive_failed) = (None, false);
        match self.obey(command, backend) {
            Ok(()) => Ok(()),
            Err(CommandRefusal::Message(text)) => {
                self.error = Some(text);
                Ok(())
            }
            Err(CommandRefusal::Failure(error)) => Err(error),
        }
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
                    self.leave("excluded", &reason, backend)?;
                    self.session.stop(&reason, &(self.utc)())?;
                    self.asked = false;
                    self.enter(SessionState::Stopped(self.study.file.texts.stopped.clone()));
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
        self.stop_spoken_text();
        self.write_voice()?;
        self.leave("stopped", reason, backend)?;
        end(&mut self.session, reason, &(self.utc)())?;
        self.asked = false;
        self.enter(SessionState::Stopped(self.study.file.texts.stopped.clone()));
        Ok(())
    }

    fn not_over(&self) -> Result<(), CommandRefusal> {
        if self.is_over() { Err(CommandRefusal::Message("the session is over".into())) } else { Ok(()) }
    }

    fn go(&mut self, backend: &mut dyn DriveBackend) -> Result<(), CommandRefusal> {
        if self.asked {
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
        let asked = !held && std::mem::take(&mut self.asked);
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

    /// Ends the current drive, if there is one, with a note in its recording. Returns true if there was a drive or one was loading.
    pub(super) fn leave(&mut self, kind: &str, reason: &str, backend: &mut dyn DriveBackend) -> Result<bool, RunError> {
        let drives = self.drives() || matches!(self.at, SessionState::Loading(_));
        if matches!(self.at, SessionState::Driving) {
            backend.note(kind, reason);
        }
        if drives {
            backend.end()?;
        }
        Ok(drives)
    }

    fn abort(&mut self, reason: &str, backend: &mut dyn DriveBackend) -> Result<(), CommandRefusal> {
        if self.session.log().running.is_none() {
            return Err(CommandRefusal::Message("there is no item to break off".into()));
        }
        self.leave("aborted", reason, backend)?;
        self.session.end(ItemOutcome::Aborted, reason, &(self.utc)())?;
        self.asked = false;
        self.enter(SessionState::Hold);
        Ok(())
    }

    fn skip(&mut self, reason: &str, backend: &mut dyn DriveBackend) -> Result<(), CommandRefusal> {
        self.not_over()?;
        if self.session.next().is_some_and(|(_, planned)| self.study.is_consent(planned)) {
            let text = "a participant without consent cannot take part; Stop ends the session";
            return Err(CommandRefusal::Message(text.into()));
        }
        let runs = self.session.log().running.is_some();
        let drove = self.leave("skipped", reason, backend)?;
        self.session.skip(reason, &(self.utc)())?;
        self.asked = false;
        if drove {
            self.enter(SessionState::Hold);
        } else if runs {
            self.begin_next_item()?;
        }
        Ok(())
    }

    fn extend(&mut self, seconds: f64, reason: &str, backend: &mut dyn DriveBackend) -> Result<(), CommandRefusal> {
        if !(1.0..=3600.0).contains(&seconds) {
            return Err(CommandRefusal::Message(format!("the extension is {seconds} s; allowed: 1 to 3600 s")));
        }
        match &mut self.at {
            SessionState::Driving => backend.extend(seconds)?,
            SessionState::Rest(_, left_s) => *left_s += seconds,
            _ => return Err(CommandRefusal::Message("there is no drive or rest to extend".into())),
        }
        Ok(self.write("extended", &format!("by {seconds} s: {reason}"), backend)?)
    }
}
