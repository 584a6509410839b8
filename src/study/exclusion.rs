//! Excludes a participant from a study after the session windows are closed. In: a data set, a code, a reason. Out: the reason in the
//! participant's log, and `excluded` in `participants.tsv`. Nothing is deleted.

use super::{DataSet, ParticipantCode, Session, SessionError, Study};

impl DataSet {
    /// Excludes the data of a participant; ends the session if it is not over. `now` is the time, UTC.
    ///
    /// # Errors
    /// There is no such participant, a program runs the session, or the data are already excluded for another reason. Also if a file
    /// cannot be written; then the same call completes the exclusion. A log that cannot be read, of any participant, changes nothing.
    pub fn exclude(&self, study: &Study, code: &ParticipantCode, reason: &str, now: &str) -> Result<(), SessionError> {
        self.check_known(code)?;
        // The tables need the logs of all: one that cannot be read refuses the exclusion before anything is written.
        self.logs()?;
        let mut session = Session::reopen(self, study, code, now)?;
        if session.log().end.is_none() {
            session.stop(reason, now)?;
        }
        let before = session.log().end.as_ref().and_then(|end| end.excluded.clone());
        if before.is_none() {
            session.exclude(reason)?;
        }
        // Publishes in any case: an earlier call may have been cut between the log and the tables.
        self.publish(study, code)?;
        match before {
            Some(before) if before != reason => {
                Err(SessionError::Refused(format!("participant {code}: the data are already excluded ({before})")))
            }
            _ => Ok(()),
        }
    }
}
