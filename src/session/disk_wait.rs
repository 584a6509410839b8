//! Wait for the disk. In: results of writes of the session's log. Out: nothing goes on, the drive stands, both windows say why, and the log is written
//! again each second until it is on the disk. Stops and notes of the experimenter stand in memory meanwhile.

use super::{DriveBackend, LiveSession, SessionState};
use crate::{drive_loop::RunError, panel::SessionCommand, study::SessionError};
use std::time::Duration;

/// Time between two attempts to write the log, s.
const RETRY_S: f64 = 1.0;

/// Wait for the disk, with its texts for both windows.
#[derive(Debug)]
pub(super) struct DiskWait {
    /// Time until the next attempt, s.
    retry_s: f64,
    participant: String,
    experimenter: String,
}

impl LiveSession {
    /// Returns true while the log in memory is not on the disk. The program must not end then.
    pub fn waits_for_disk(&self) -> bool {
        self.disk_wait.is_some()
    }

    /// Returns true if the windows may close: the log is on the disk, or can be written now. Otherwise both windows say what they wait for.
    pub fn may_close(&mut self) -> bool {
        self.write_again();
        !self.waits_for_disk()
    }

    /// Passes on the result of a step, unless the log could not be written: the session then waits for the disk, and a drive stands.
    pub(super) fn or_wait(
        &mut self,
        done: Result<(), RunError>,
        backend: &mut dyn DriveBackend,
    ) -> Result<(), RunError> {
        let failed = matches!(done, Err(RunError::Session(SessionError::Record(_))));
        if let Some(why) = self.session.unwritten().map(str::to_owned) {
            if self.disk_wait.is_none() && matches!(self.at, SessionState::Driving) {
                backend.hold(true);
            }
            self.disk_wait = Some(self.wait_for(&why));
        }
        if failed { Ok(()) } else { done }
    }

    /// Returns a new wait, with its texts for the present state.
    fn wait_for(&self, why: &str) -> DiskWait {
        let disk = &self.study.file.texts.disk;
        let (stopped, kept) = match &self.at {
            SessionState::Stopped(words) => (format!("{words}\n\n"), "The session is stopped, and its log"),
            _ => (String::new(), "The session's log"),
        };
        let error = self.error.as_ref().map_or(String::new(), |error| format!("{error}\n"));
        DiskWait {
            retry_s: RETRY_S,
            participant: format!("{stopped}{disk}"),
            experimenter: format!(
                "{error}{kept} is complete in memory alone, as it cannot be written: {why}\nLeave the program running and make room on \
                 the disk: it tries again every second, and nothing goes on before. Marks, notes and stops are kept meanwhile."
            ),
        }
    }

    /// Counts the time to the next attempt to write the log. Returns true while the session waits.
    pub(super) fn pass_disk_wait(&mut self, elapsed: Duration) -> bool {
        let Some(wait) = &mut self.disk_wait else { return false };
        wait.retry_s -= elapsed.as_secs_f64();
        if wait.retry_s <= 0.0 {
            self.write_again();
        }
        self.waits_for_disk()
    }

    /// Writes the log again, if it is not on the disk.
    pub(super) fn write_again(&mut self) {
        let Some(wait) = &mut self.disk_wait else { return };
        wait.retry_s = RETRY_S;
        if self.session.save().is_ok() {
            self.disk_wait = None;
            log::info!("the session's log is written");
        }
    }

    /// Returns true for a command that is carried out while the session waits for the disk: it adds to the log, ends something, or holds it.
    pub(super) fn may_wait(command: &SessionCommand) -> bool {
        matches!(
            command,
            SessionCommand::Note(_)
                | SessionCommand::Draft(_)
                | SessionCommand::Mark(_)
                | SessionCommand::Pause
                | SessionCommand::Hold
                | SessionCommand::Stop(_)
                | SessionCommand::StopTechnically(_)
                | SessionCommand::Exclude(_)
        )
    }

    /// Returns the text for the participant while the session waits for the disk.
    pub(super) fn disk_text(&self) -> Option<&str> {
        self.disk_wait.as_ref().map(|wait| wait.participant.as_str())
    }

    /// Returns the last error, or the reason why the session ended; while the session waits for the disk, the reason and the remedy.
    pub fn error(&self) -> Option<&str> {
        self.disk_wait.as_ref().map(|wait| wait.experimenter.as_str()).or(self.error.as_deref())
    }
}
