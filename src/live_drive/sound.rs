//! Sound of a live drive. In: the world after each tick; pause and horn each frame. Out: the sound of the speaker, and spoken guidance.

use crate::{
    audio::{Listener, SoundScene, Speaker, Voice, VoiceStatus, speech_program},
    controls::Controls,
    hud::SpokenGuidance,
    metrics::TaskStimulus,
    scenario::{Scenario, ScriptedEvent},
    sim::{EventKind, World},
    snapshot::{AutomationMode, AutomationState},
};

/// Name of the recorded event for a horn that is pressed or released, with "on" or "off" as detail.
pub const HORN: &str = "horn";
/// Name of the recorded event for a sentence of the guidance, with the sentence as detail.
pub const SPOKEN_GUIDANCE: &str = "spoken_guidance";
/// Name of the recorded event for a spoken digit of the n-back task, with the digit as detail.
pub const SPOKEN_DIGIT: &str = "spoken_digit";

/// Name of the recorded event for a spoken sentence of an event of the scenario, with the sentence as detail.
pub const SPOKEN_SENTENCE: &str = "spoken_sentence";

/// Name of the recorded event for a spoken takeover request, with the sentence as detail.
pub const SPOKEN_REQUEST: &str = "spoken_request";
/// Sentences of a takeover request, of an urgent one, and of a minimal-risk manoeuvre.
const REQUESTS: [&str; 3] = ["Please take over.", "Take over now!", "Stopping. Take over!"];

/// Sound of a drive and, in a window, its speaker.
pub struct DriveSound {
    listener: Listener,
    speaker: Option<Speaker>,
    horn: bool,
    guidance: Option<SpokenGuidance>,
    /// True if the digits of the n-back task are spoken.
    speaks_digits: bool,
    /// True if takeover requests are spoken.
    speaks_requests: bool,
    /// True if sentences of events are spoken.
    speaks_events: bool,
    /// Takeover request that was spoken last, as an index of [`REQUESTS`].
    request: Option<usize>,
    /// Name of the event and sentence that is not yet spoken.
    due: Option<(&'static str, String)>,
    spoken: Option<SpokenSentence>,
    speech_gain: f32,
}

/// Sentence that is being spoken.
struct SpokenSentence {
    /// Name of its event.
    kind: &'static str,
    sentence: String,
    voice: Voice,
    /// True once the device plays it.
    began: bool,
}

impl DriveSound {
    /// Creates the sound; nothing is played until [`DriveSound::open`].
    pub fn new(scenario: &Scenario) -> Self {
        let guidance = scenario.spoken_guidance.then(|| SpokenGuidance::new(scenario.display.units));
        Self {
            listener: Listener::new(scenario),
            speaker: None,
            horn: false,
            guidance,
            speaks_digits: scenario.secondary_task.speaks(),
            speaks_requests: scenario.automation.speaks(),
            speaks_events: scenario.events.iter().any(ScriptedEvent::speaks),
            request: None,
            due: None,
            spoken: None,
            speech_gain: scenario.sound.speech_gain(),
        }
    }

    /// Starts playing at the scenario's levels.
    pub fn open(&mut self, scenario: &Scenario) {
        self.speaker = Some(Speaker::open(scenario.sound));
        if scenario.speaks() {
            let Err(why) = speech_program() else { return };
            log::warn!(
                "no speech: {why}; continuing without spoken guidance, requests and sentences of events, and with digits on the screen"
            );
            self.guidance = None;
            self.speaks_digits = false;
            self.speaks_requests = false;
            self.speaks_events = false;
        }
    }

    /// Switches to another drive; an open speaker continues at the new drive's levels.
    pub fn restart(&mut self, old: &Scenario, scenario: &Scenario) {
        let reopen = self.speaker.is_some() && old.sound != scenario.sound;
        if reopen {
            // The old speaker must release the audio device first.
            self.speaker = None;
        }
        let speaker = self.speaker.take();
        *self = Self { speaker, ..Self::new(scenario) };
        if reopen {
            self.open(scenario);
        }
    }

    /// Applies a tick of the world with these controls.
    pub fn tick(&mut self, world: &World, controls: &Controls) {
        let snapshot = world.snapshot();
        self.listener.tick(snapshot, world.events(), controls);
        if let Some(guidance) = &mut self.guidance {
            let sentence = guidance.tick(snapshot.next_manoeuvre, snapshot.ego.speed_mps);
            self.due = sentence.map(|sentence| (SPOKEN_GUIDANCE, sentence)).or_else(|| self.due.take());
        }
        let sentence = snapshot.stimuli.as_ref().and_then(|stimuli| stimuli.sentence.as_ref());
        if let Some((sentence, first)) = sentence
            && self.speaks_events
            && *first == snapshot.tick
        {
            self.due = Some((SPOKEN_SENTENCE, sentence.to_string()));
        }
        self.hear_request(snapshot.automation);
        for event in world.events().iter().filter(|_| self.speaks_digits) {
            if let EventKind::TaskStimulus(TaskStimulus::Digit { digit, .. }) = event.kind {
                self.due = Some((SPOKEN_DIGIT, digit.to_string()));
            }
        }
    }

    /// Speaks a takeover request when it begins, when it becomes urgent, and when the vehicle stops.
    fn hear_request(&mut self, automation: AutomationState) {
        let request = match automation.mode {
            AutomationMode::TakeoverRequest => Some(usize::from(automation.is_urgent)),
            AutomationMode::MinimalRisk => Some(2),
            _ => None,
        };
        if std::mem::replace(&mut self.request, request) != request && self.speaks_requests {
            self.due =
                request.map(|request| (SPOKEN_REQUEST, REQUESTS[request].to_owned())).or_else(|| self.due.take());
        }
    }

    /// Returns true if the digits of the n-back task are spoken, and need not be shown.
    pub fn speaks_digits(&self) -> bool {
        self.speaks_digits && self.speaker.is_some()
    }

    /// Speaks the sentence that is due, if there is a speaker. Returns the name of the event and the sentence once the device plays it.
    pub fn speak(&mut self) -> Option<(&'static str, String)> {
        if let (Some((kind, sentence)), Some(_)) = (self.due.take(), &self.speaker) {
            let voice = Voice::say(sentence.clone(), self.speech_gain);
            self.spoken = Some(SpokenSentence { kind, voice, sentence, began: false });
        }
        let spoken = self.spoken.as_mut().filter(|spoken| !spoken.began)?;
        match spoken.voice.status() {
            VoiceStatus::Opening => return None,
            VoiceStatus::Playing | VoiceStatus::Ended => spoken.began = true,
            VoiceStatus::Failed(why) => {
                log::warn!("\"{}\" was not spoken: {why}", spoken.sentence);
                self.spoken = None;
            }
        }
        self.spoken.as_ref().map(|spoken| (spoken.kind, spoken.sentence.clone()))
    }

    /// Plays a frame; `running` is true while time runs, `horn` while the horn is held. Returns true if the horn
    /// changed.
    pub fn frame(&mut self, running: bool, horn: bool) -> bool {
        if let Some(speaker) = &self.speaker {
            speaker.play(&self.scene(running, horn));
        }
        std::mem::replace(&mut self.horn, horn) != horn
    }

    /// Plays a gentle tone for a question; it differs from the tone for advice.
    pub fn chime(&mut self) {
        self.listener.chime();
    }

    /// Returns the sounds of the present moment.
    pub fn scene(&self, running: bool, horn: bool) -> SoundScene {
        self.listener.scene(running, horn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_of_an_event_is_due_once_at_its_onset() {
        let text = "traffic = \"native\"\nvehicles = 2\ntrees = 0\n[[event]]\nname = \"a\"\ntrigger = { time_s = 1 }\n\
             actions = [{ speak = { text = \"Mind the gap\" } }, { message = { text = \"a\", for_s = 3 } }]\n";
        let scenario = Scenario::from_toml(text, "sentence.toml").expect("a scenario");
        let (mut world, mut sound) = (World::new(&scenario).expect("the native engine"), DriveSound::new(&scenario));
        let mut due = Vec::new();
        for _ in 0..500 {
            world.tick(&Controls::default()).expect("the native engine");
            sound.tick(&world, &Controls::default());
            due.extend(sound.due.take().map(|(kind, sentence)| (world.snapshot().tick.0, kind, sentence)));
        }
        // The first tick that an event shows is the one after its trigger.
        assert_eq!(due, [(101, SPOKEN_SENTENCE, "Mind the gap".into())]);
    }
}
