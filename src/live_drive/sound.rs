//! Sound of a live drive. In: the world after each tick, pause and horn a frame. Out: what the speaker plays.

use crate::{
    audio::{Listener, SoundScene, Speaker},
    controls::Controls,
    scenario::Scenario,
    sim::World,
};

/// Name of the event that a recording has where a hand came to the horn or went, with "on" or "off".
pub const HORN: &str = "horn";

/// What is audible of a drive and, in a window, its speaker.
pub struct DriveSound {
    listener: Listener,
    speaker: Option<Speaker>,
    horn: bool,
}

impl DriveSound {
    /// Nothing is played until [`DriveSound::open`].
    pub fn new(scenario: &Scenario) -> Self {
        Self { listener: Listener::new(scenario.advice_tone), speaker: None, horn: false }
    }

    /// Begins to play at the scenario's levels.
    pub fn open(&mut self, scenario: &Scenario) {
        self.speaker = Some(Speaker::open(scenario.sound));
    }

    /// Another drive begins: a speaker that was open plays it at its levels.
    pub fn restart(&mut self, old: &Scenario, scenario: &Scenario) {
        let reopen = self.speaker.is_some() && old.sound != scenario.sound;
        if reopen {
            // The old one lets the device go first.
            self.speaker = None;
        }
        let speaker = self.speaker.take();
        *self = Self { speaker, ..Self::new(scenario) };
        if reopen {
            self.open(scenario);
        }
    }

    /// The world has made a tick with these controls.
    pub fn tick(&mut self, world: &World, controls: &Controls) {
        self.listener.tick(world.snapshot(), world.events(), controls);
    }

    /// A frame: whether time runs, and a hand is on the horn. True if the hand came or went.
    pub fn frame(&mut self, running: bool, horn: bool) -> bool {
        if let Some(speaker) = &self.speaker {
            speaker.play(&self.scene(running, horn));
        }
        std::mem::replace(&mut self.horn, horn) != horn
    }

    /// Something is asked: a gentle tone, other than that of another advice.
    pub fn chime(&mut self) {
        self.listener.chime();
    }

    /// What there is to be heard.
    pub fn scene(&self, running: bool, horn: bool) -> SoundScene {
        self.listener.scene(running, horn)
    }
}
