//! Spoken instructions of a session's pages. In: the current page, and the status of the audio device. Out: orders to play or stop; notes
//! in the session log for when a text began, and whether it ended or was cut. This module opens no device.

use super::{LiveSession, SessionState};
use crate::{audio::VoiceStatus, drive_loop::RunError, study::SpokenText};

/// Order to the window that owns the audio device.
#[derive(Clone, Debug, PartialEq)]
pub enum VoiceOrder {
    /// Play this text from its beginning; stops any other text.
    Play(SpokenText),
    /// Stop the current text.
    Stop,
}

/// A text that is being spoken.
#[derive(Debug)]
struct SpeakingText {
    file: String,
    /// True once the device plays it.
    began: bool,
}

/// Voice of a session: pending order, current text, unwritten notes.
#[derive(Debug, Default)]
pub(super) struct SessionVoice {
    order: Option<VoiceOrder>,
    speaking: Option<SpeakingText>,
    /// Notes that are not yet in the log.
    notes: Vec<String>,
}

impl LiveSession {
    /// Stops the current text and starts the text of the current page; for a new page, or on request to hear it again.
    pub(super) fn play_spoken_text(&mut self) {
        self.stop_spoken_text();
        if let Some(text) = self.spoken_now().cloned() {
            self.voice.speaking = Some(SpeakingText { file: text.file.clone(), began: false });
            self.voice.order = Some(VoiceOrder::Play(text));
        }
    }

    /// Stops the current text.
    pub(super) fn stop_spoken_text(&mut self) {
        let Some(speaking) = self.voice.speaking.take() else { return };
        self.voice.order = Some(VoiceOrder::Stop);
        if speaking.began {
            self.voice.notes.push(format!("{} was cut", speaking.file));
        }
    }

    /// Returns the spoken text of the current page.
    fn spoken_now(&self) -> Option<&SpokenText> {
        let planned = self.running()?;
        let has_page = match &self.at {
            SessionState::Text(_) => true,
            // The text of a segment is shown only before its first drive.
            SessionState::Intro(_) | SessionState::Rest(..) => !planned.text.is_empty(),
            _ => false,
        };
        self.study.spoken.get(&planned.segment).filter(|_| has_page)
    }

    /// Returns true if the current page has a spoken text that may be played.
    pub fn is_spoken(&self) -> bool {
        self.asked.is_none() && self.spoken_now().is_some()
    }

    /// Takes the order issued since the last call.
    pub fn take_voice_order(&mut self) -> Option<VoiceOrder> {
        self.voice.order.take()
    }

    /// Processes the status of the audio device. Returns a warning for the experimenter if the text cannot be heard.
    pub fn hear_voice(&mut self, status: VoiceStatus) -> Option<String> {
        let SessionVoice { speaking, notes, .. } = &mut self.voice;
        let text = speaking.as_mut()?;
        match status {
            VoiceStatus::Opening => None,
            VoiceStatus::Playing | VoiceStatus::Ended if !text.began => {
                text.began = true;
                notes.push(format!("{} began", text.file));
                None
            }
            VoiceStatus::Playing => None,
            VoiceStatus::Ended => {
                notes.push(format!("{} ended", text.file));
                *speaking = None;
                None
            }
            VoiceStatus::Failed(why) => {
                let note = format!("{} cannot be played: {why}", text.file);
                notes.push(note.clone());
                *speaking = None;
                Some(note + "; the page shows the same text")
            }
        }
    }

    /// Writes pending notes to the session log.
    pub(super) fn write_voice(&mut self) -> Result<(), RunError> {
        let mut written = Ok(());
        for text in std::mem::take(&mut self.voice.notes) {
            written = self.session.note("spoken", &text, &(self.utc)());
        }
        Ok(written?)
    }
}
