//! Spoken instructions of a session's pages. In: which page is seen, how far the device is. Out: what is to be played or ended now; notes
//! in the session's log of when a text began, and whether it ended or was cut. No device is opened here.

use super::{LiveSession, SessionState};
use crate::{audio::VoiceStatus, drive_loop::RunError, study::SpokenText};

/// What the window is to do.
#[derive(Clone, Debug, PartialEq)]
pub enum VoiceOrder {
    /// Speak this from its beginning; whatever is spoken ends.
    Play(SpokenText),
    /// End what is spoken.
    Stop,
}

/// A text that is spoken.
#[derive(Debug)]
struct SpeakingText {
    file: String,
    /// It is heard.
    began: bool,
}

/// The voice of a session.
#[derive(Debug, Default)]
pub(super) struct SessionVoice {
    order: Option<VoiceOrder>,
    speaking: Option<SpeakingText>,
    /// What the log does not have yet.
    notes: Vec<String>,
}

impl LiveSession {
    /// Another page is seen, or the same text is wanted again: what is spoken ends, and the page's own text begins.
    pub(super) fn speak(&mut self) {
        self.hush();
        if let Some(text) = self.spoken_now().cloned() {
            self.voice.speaking = Some(SpeakingText { file: text.file.clone(), began: false });
            self.voice.order = Some(VoiceOrder::Play(text));
        }
    }

    /// What is spoken ends.
    pub(super) fn hush(&mut self) {
        let Some(speaking) = self.voice.speaking.take() else { return };
        self.voice.order = Some(VoiceOrder::Stop);
        if speaking.began {
            self.voice.notes.push(format!("{} was cut", speaking.file));
        }
    }

    /// The text that is spoken on the page that is seen.
    fn spoken_now(&self) -> Option<&SpokenText> {
        let planned = self.running()?;
        let has_page = match &self.at {
            SessionState::Text(_) => true,
            // The words of a segment stand before its first drive alone.
            SessionState::Intro(_) | SessionState::Rest(..) => !planned.text.is_empty(),
            _ => false,
        };
        self.study.spoken.get(&planned.segment).filter(|_| has_page)
    }

    /// True if the page can be heard, once more too.
    pub fn is_spoken(&self) -> bool {
        !self.asked && self.spoken_now().is_some()
    }

    /// What is to be done since the last call.
    pub fn take_voice_order(&mut self) -> Option<VoiceOrder> {
        self.voice.order.take()
    }

    /// How far the device is. Returns what the experimenter has to know: a text that is not heard.
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
                let said = format!("{} is not heard: {why}", text.file);
                notes.push(said.clone());
                *speaking = None;
                Some(said + "; the page shows the same text")
            }
        }
    }

    /// Writes down what was spoken.
    pub(super) fn write_voice(&mut self) -> Result<(), RunError> {
        for text in std::mem::take(&mut self.voice.notes) {
            self.session.note("spoken", &text, &(self.utc)())?;
        }
        Ok(())
    }
}
