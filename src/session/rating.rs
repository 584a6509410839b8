//! The fast motion sickness scale in a session's drives. In: time of the drive and the participant's input. Out: the question in the
//! participant's picture; ratings in the session log and the recording; the end of the session if a rating is above its limit.

use super::{BackendStatus, DriveBackend, LiveSession, SessionState};
use crate::{
    drive_loop::RunError,
    study::{
        FmsPrompt, FmsRating, FormInput,
        fms::{self, FmsEvent, FmsScale},
        session::DriveRating,
    },
};

/// Maximum number of recent ratings shown to the experimenter.
const SEEN: usize = 8;

impl LiveSession {
    /// Prepares the scale for a new drive, if its segment asks for it; the first question starts at the last answer.
    pub(super) fn begin_ratings(&mut self) {
        let every_s = self.running().and_then(|planned| self.study.segment_of(planned)?.fms_every_s);
        let last = self.session.log().fms.iter().rev().find_map(|rated| rated.rating.value);
        self.fms = every_s.map(|every_s| FmsScale::new(every_s, last.unwrap_or(0)));
    }

    /// Advances the scale to the present time of the drive; asks a question or lets one expire.
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
                backend.note(fms::UNANSWERED, &rating.to_string());
                Ok(self.session.rate(rating, None, &(self.utc)())?)
            }
        }
    }

    /// Applies the participant's input to the question while driving; ignored while the drive is paused.
    pub(super) fn rate(&mut self, input: &FormInput, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let now = backend.now();
        let Some(scale) = self.fms.as_mut().filter(|_| !now.held) else { return Ok(()) };
        match input {
            FormInput::Turn(by) => scale.turn(*by),
            FormInput::Next => {
                let Some(rating) = scale.confirm(now.time_s) else { return Ok(()) };
                backend.note_value(fms::ANSWERED, &rating.to_string(), rating.value.unwrap_or_default().into());
                self.rated(rating, backend)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Stores a rating in the log; ends drive and session if it is above the limit.
    fn rated(&mut self, rating: FmsRating, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let ending = self.running().and_then(|planned| self.study.ending_of_rating(planned, &rating));
        if let Some(ending) = &ending {
            backend.note("stopped", &ending.reason);
            // The drive must end even if the recording cannot be finished.
            if let Err(error) = backend.end() {
                log::error!("{error}");
            }
        }
        let rated = self.session.rate(rating, ending.as_ref(), &(self.utc)());
        if let Some(ending) = ending {
            self.stopped_by(ending);
        }
        Ok(rated?)
    }

    /// Returns the question to show in the participant's picture.
    pub(super) fn rating_prompt(&self, now: BackendStatus) -> Option<FmsPrompt> {
        self.fms.as_ref().filter(|_| matches!(self.at, SessionState::Driving))?.prompt(now.time_s)
    }

    /// Describes the last ratings for the experimenter; `None` before the first.
    pub fn ratings(&self) -> Option<String> {
        let all = &self.session.log().fms;
        let word = |rated: &DriveRating| rated.rating.value.map_or("no answer".into(), |value| value.to_string());
        let seen: Vec<String> = all[all.len().saturating_sub(SEEN)..].iter().map(word).collect();
        (!seen.is_empty()).then(|| format!("FMS (0 to {}) {}", fms::HIGHEST, seen.join(", ")))
    }
}
