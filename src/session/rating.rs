//! The fast motion sickness scale of a session's drives. In: the time of the drive, what the participant's hand does. Out: the question
//! in the participant's picture; ratings in the session's log and in the recording; the end of the session where a rating is above its
//! limit.

use super::{BackendStatus, DriveBackend, LiveSession, SessionState};
use crate::{
    drive_loop::RunError,
    study::{
        FmsPrompt, FmsRating, FormInput,
        fms::{self, FmsEvent, FmsScale},
        session::DriveRating,
    },
};

/// Ratings that the experimenter sees at a time.
const SEEN: usize = 8;

impl LiveSession {
    /// A drive begins: whether and how often it asks is said by its segment; the first question begins at the last answer.
    pub(super) fn begin_ratings(&mut self) {
        let every_s = self.running().and_then(|planned| self.study.segment_of(planned)?.fms_every_s);
        let last = self.session.log().fms.iter().rev().find_map(|rated| rated.rating.value);
        self.fms = every_s.map(|every_s| FmsScale::new(every_s, last.unwrap_or(0)));
    }

    /// Time has passed in the drive.
    pub(super) fn ask_rating(&mut self, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let now = backend.now();
        let Some(scale) = self.fms.as_mut().filter(|_| !now.ended) else { return Ok(()) };
        match scale.time(now.time_s, now.duration_s) {
            None => Ok(()),
            Some(FmsEvent::Asked) => {
                backend.note(fms::ASKED, "");
                backend.chime();
                Ok(())
            }
            Some(FmsEvent::Unanswered(rating)) => {
                backend.note(fms::UNANSWERED, &rating.words());
                Ok(self.session.rate(rating, None, &(self.utc)())?)
            }
        }
    }

    /// The hand does something while the car drives. A drive that is held takes no answer.
    pub(super) fn rate(&mut self, input: &FormInput, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let now = backend.now();
        let Some(scale) = self.fms.as_mut().filter(|_| !now.held) else { return Ok(()) };
        match input {
            FormInput::Turn(by) => scale.turn(*by),
            FormInput::Next => {
                let Some(rating) = scale.confirm(now.time_s) else { return Ok(()) };
                backend.note_value(fms::ANSWERED, &rating.words(), rating.value.unwrap_or_default().into());
                self.rated(rating, backend)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// The answer goes into the log, and ends drive and session where it is above its limit.
    fn rated(&mut self, rating: FmsRating, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let ending = self.running().and_then(|planned| self.study.ending_of_rating(planned, &rating));
        if let Some(ending) = &ending {
            backend.note("stopped", &ending.reason);
            // A disk that refuses is no reason to drive on.
            if let Err(error) = backend.end() {
                log::error!("{error}");
            }
        }
        self.session.rate(rating, ending.as_ref(), &(self.utc)())?;
        if let Some(ending) = ending {
            self.stopped_by(ending);
        }
        Ok(())
    }

    /// The question that stands in the participant's picture.
    pub(super) fn rating_prompt(&self, now: BackendStatus) -> Option<FmsPrompt> {
        self.fms.as_ref().filter(|_| matches!(self.at, SessionState::Driving))?.prompt(now.time_s)
    }

    /// The last ratings in the experimenter's words; `None` before the first.
    pub fn ratings(&self) -> Option<String> {
        let all = &self.session.log().fms;
        let word = |rated: &DriveRating| rated.rating.value.map_or("no answer".into(), |value| value.to_string());
        let seen: Vec<String> = all[all.len().saturating_sub(SEEN)..].iter().map(word).collect();
        (!seen.is_empty()).then(|| format!("FMS (0 to {}) {}", fms::HIGHEST, seen.join(", ")))
    }
}
