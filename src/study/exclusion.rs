//! Leaves a participant out of a study once the windows are closed. In: a data set, a code, a reason. Out: the reason in the
//! participant's log, the word `excluded` in `participants.tsv`; nothing is deleted.

use super::{DataSet, ParticipantCode, Session, SessionError, Study, checksums, session};

impl DataSet {
    /// Excludes the data of a participant; a session that is not over ends by that. `now` is the time, UTC.
    ///
    /// # Errors
    /// There is no such participant, the session is being run, the data are excluded already for another reason; the disk
    /// refuses, and the same call goes on.
    pub fn exclude(&self, study: &Study, code: &ParticipantCode, reason: &str, now: &str) -> Result<(), SessionError> {
        self.check_known(code)?;
        let mut session = Session::reopen(self, study, code, now)?;
        if session.log().end.is_none() {
            session.stop(reason, now)?;
        }
        let before = session.log().end.as_ref().and_then(|end| end.excluded.clone());
        if before.is_none() {
            // The log was listed as it was when the session ended.
            checksums::forget(self.root(), &format!("sourcedata/{}/{}", code.subject(), session::FILE))?;
            session.exclude(reason)?;
        }
        // A cut between the log and the tables leaves them to be made here.
        self.publish(study, code)?;
        match before {
            Some(before) if before != reason => {
                Err(SessionError::Refused(format!("participant {code}: the data are excluded already ({before})")))
            }
            _ => Ok(()),
        }
    }
}
