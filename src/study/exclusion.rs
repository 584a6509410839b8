//! Leaves a participant out of a study once the windows are closed. In: a data set, a code, a reason. Out: the reason in the
//! participant's log, the word `excluded` in `participants.tsv`; nothing is deleted.

use super::{DataSet, ParticipantCode, Session, SessionError, Study, checksums, session};

impl DataSet {
    /// Excludes the data of a participant; a session that is not over ends by that. `now` is the time, UTC.
    ///
    /// # Errors
    /// There is no such participant, the session is being run, the data are excluded already; the disk refuses.
    pub fn exclude(&self, study: &Study, code: &ParticipantCode, reason: &str, now: &str) -> Result<(), SessionError> {
        self.check_known(code)?;
        let mut session = Session::reopen(self, study, code, now)?;
        if session.log().end.is_none() {
            session.stop(reason, now)?;
        }
        session.exclude(reason)?;
        // The log was listed as it was when the session ended.
        checksums::forget(self.root(), &format!("sourcedata/{}/{}", code.subject(), session::FILE))?;
        self.publish(study, code)
    }
}
