//! Sound of a live drive. In: the world after each tick; pause and horn each frame. Out: the sound of the speaker, spoken sentences, and those to be
//! shown because they cannot be heard.

use crate::{
    audio::{Listener, SoundScene, Speaker, Voice, VoiceStatus},
    controls::Controls,
    hud::SpokenGuidance,
    metrics::TaskStimulus,
    scenario::{Scenario, ScriptedEvent},
    sim::{EventKind, World},
    snapshot::{AutomationMode, AutomationState},
    time::{TICKS_PER_S, Tick},
};
use std::sync::Arc;

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
/// Name of the recorded event for a sentence that is shown because it cannot be heard, with the sentence as detail.
pub const SHOWN_SENTENCE: &str = "shown_sentence";
/// Time for which a sentence is shown, s: at least, and more for each letter.
const SHOWN_S: f64 = 3.0;
const SHOWN_S_PER_LETTER: f64 = 0.06;

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
    /// Reason that no sentence can be spoken; `None` while none has failed.
    speech_fault: Option<String>,
    /// Message for the experimenter about the first sentence that is not heard, and true once there was one.
    fault_news: Option<String>,
    is_told: bool,
    /// Sentence that is shown, and the first tick without it.
    shown: Option<(Arc<str>, Tick)>,
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
            speech_fault: None,
            fault_news: None,
            is_told: false,
            shown: None,
        }
    }

    /// Starts playing at the scenario's levels.
    pub fn open(&mut self, scenario: &Scenario) {
        self.speaker = Some(Speaker::open(scenario.sound));
    }

    /// Returns the reason that a sentence cannot be heard now; `None` while one can.
    fn unheard(&self) -> Option<&str> {
        match &self.speech_fault {
            Some(why) => Some(why),
            None if self.speech_gain == 0.0 => Some("its level is silence"),
            None => (!self.speaker.as_ref().is_some_and(Speaker::plays)).then_some("no sound device plays"),
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

    /// Returns true while the digits of the n-back task are heard, and need not be shown.
    pub fn speaks_digits(&self) -> bool {
        self.speaks_digits && self.unheard().is_none()
    }

    /// Speaks the sentence that is due, or shows it from `now` on if it cannot be heard. A sentence that a pause interrupts is spoken again after
    /// it. Returns the name of the event and the sentence once the device plays it, or the picture shows it.
    pub fn speak(&mut self, now: Tick, is_paused: bool) -> Option<(&'static str, String)> {
        if is_paused {
            let cut = self.spoken.take().filter(|spoken| spoken.voice.status() != VoiceStatus::Ended);
            self.due = self.due.take().or(cut.map(|spoken| (spoken.kind, spoken.sentence)));
            return None;
        }
        if let Some((kind, sentence)) = self.due.take() {
            if self.unheard().is_some() {
                return self.show(kind, sentence, now);
            }
            let voice = Voice::say(sentence.clone(), self.speech_gain);
            self.spoken = Some(SpokenSentence { kind, voice, sentence, began: false });
        }
        let spoken = self.spoken.as_mut()?;
        match spoken.voice.status() {
            VoiceStatus::Playing | VoiceStatus::Ended if !spoken.began => {
                spoken.began = true;
                Some((spoken.kind, spoken.sentence.clone()))
            }
            VoiceStatus::Opening | VoiceStatus::Playing | VoiceStatus::Ended => None,
            VoiceStatus::Failed(why) => {
                self.speech_fault = Some(why);
                let SpokenSentence { kind, sentence, .. } = self.spoken.take()?;
                self.show(kind, sentence, now)
            }
        }
    }

    /// Shows a sentence that cannot be heard. Digits have a place of their own in the picture, and requests are always shown.
    fn show(&mut self, kind: &'static str, sentence: String, now: Tick) -> Option<(&'static str, String)> {
        if !std::mem::replace(&mut self.is_told, true) {
            self.fault_news =
                self.unheard().map(|why| format!("speech is shown on the screen, as it cannot be heard: {why}"));
        }
        if matches!(kind, SPOKEN_DIGIT | SPOKEN_REQUEST) {
            return None;
        }
        let seconds = SHOWN_S + SHOWN_S_PER_LETTER * sentence.chars().count() as f64;
        let until = Tick(now.0 + (seconds * f64::from(TICKS_PER_S)) as u64);
        self.shown = Some((sentence.as_str().into(), until));
        Some((SHOWN_SENTENCE, sentence))
    }

    /// Returns the sentence that is shown at a tick because it cannot be heard.
    pub fn shown_sentence(&self, now: Tick) -> Option<Arc<str>> {
        self.shown.as_ref().filter(|(_, until)| now < *until).map(|(sentence, _)| Arc::clone(sentence))
    }

    /// Returns the message about the first sentence that could not be heard, once.
    pub fn take_fault(&mut self) -> Option<String> {
        self.fault_news.take()
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
    use crate::scenario::{SecondaryTask, SecondaryTaskKind};

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

    /// Returns a sound without a device, with this sentence due.
    fn due(kind: &'static str, sentence: &str) -> DriveSound {
        DriveSound { due: Some((kind, sentence.to_owned())), ..DriveSound::new(&Scenario::default()) }
    }

    #[test]
    fn a_sentence_that_cannot_be_heard_is_shown_for_its_length() {
        for kind in [SPOKEN_SENTENCE, SPOKEN_GUIDANCE] {
            let mut sound = due(kind, "Turn left.");
            assert_eq!(sound.speak(Tick(500), true), None, "not in a pause");
            assert_eq!(sound.speak(Tick(500), false), Some((SHOWN_SENTENCE, "Turn left.".into())));
            let fault = sound.take_fault();
            assert!(fault.is_some_and(|why| why.ends_with("no sound device plays")) && sound.take_fault().is_none());
            assert_eq!(sound.speak(Tick(501), false), None, "once");
            // 3 s and 10 letters of 0.06 s.
            let seen = [Tick(500), Tick(859), Tick(860)].map(|tick| sound.shown_sentence(tick).is_some());
            assert_eq!(seen, [true, true, false]);
        }
        for kind in [SPOKEN_DIGIT, SPOKEN_REQUEST] {
            let mut sound = due(kind, "7");
            assert_eq!(
                (sound.speak(Tick(500), false), sound.shown_sentence(Tick(500))),
                (None, None),
                "shown elsewhere"
            );
        }
    }

    #[test]
    fn digits_are_shown_whenever_no_device_plays() {
        let secondary_task = SecondaryTask { kind: SecondaryTaskKind::NBack, ..SecondaryTask::default() };
        let scenario = Scenario { secondary_task, ..Scenario::default() };
        let with = |plays| DriveSound { speaker: Some(Speaker::stand_in(plays)), ..DriveSound::new(&scenario) };
        assert!(!DriveSound::new(&scenario).speaks_digits() && !with(false).speaks_digits(), "a program is no sound");
        let sound = with(true);
        let plays = |plays| sound.speaker.as_ref().expect("a stand-in").set_plays(plays);
        assert!(sound.speaks_digits());
        plays(false);
        assert!(!sound.speaks_digits(), "the device is lost");
        plays(true);
        assert!(sound.speaks_digits(), "and back");
        let quiet = DriveSound { speech_gain: 0.0, ..with(true) };
        assert_eq!((quiet.speaks_digits(), quiet.unheard()), (false, Some("its level is silence")));
    }

    #[test]
    fn a_sentence_that_fails_while_it_is_spoken_is_shown_and_the_next_too() {
        let mut sound = due(SPOKEN_SENTENCE, "Mind the gap");
        // The program that speaks is there, a device is not.
        let (kind, sentence) = sound.due.take().expect("due");
        sound.spoken = Some(SpokenSentence { kind, voice: Voice::play(Arc::from([])), sentence, began: true });
        let shown = loop {
            if let Some(shown) = sound.speak(Tick(7), false) {
                break shown;
            }
        };
        assert_eq!(shown, (SHOWN_SENTENCE, "Mind the gap".into()));
        assert!(sound.unheard().is_some_and(|why| why != "no sound device plays"), "{:?}", sound.unheard());
    }

    #[test]
    fn a_pause_cuts_a_sentence_which_is_due_again_afterwards() {
        let mut sound = due(SPOKEN_SENTENCE, "");
        let voice = Voice::play(Arc::from([]));
        sound.due = None;
        sound.spoken =
            Some(SpokenSentence { kind: SPOKEN_SENTENCE, voice, sentence: "Turn around".into(), began: true });
        assert_eq!(sound.speak(Tick(7), true), None);
        assert_eq!((sound.spoken.is_none(), sound.due.take()), (true, Some((SPOKEN_SENTENCE, "Turn around".into()))));
    }
}
