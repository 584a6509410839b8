//! Sound of a live drive. In: the world after each tick; pause and horn each frame. Out: the sound of the speaker.

use crate::{
    audio::{Listener, SoundScene, Speaker},
    controls::Controls,
    scenario::Scenario,
    sim::World,
};

/// Name of the recorded event for a horn that is pressed or released, with "on" or "off" as detail.
pub const HORN: &str = "horn";

/// Sound of a drive and, in a window, its speaker.
pub struct DriveSound {
    listener: Listener,
    speaker: Option<Speaker>,
    horn: bool,
}

impl DriveSound {
    /// Creates the sound; nothing is played until [`DriveSound::open`].
    pub fn new(scenario: &Scenario) -> Self {
        Self { listener: Listener::new(scenario), speaker: None, horn: false }
    }

    /// Starts playing at the scenario's levels.
    pub fn open(&mut self, scenario: &Scenario) {
        self.speaker = Some(Speaker::open(scenario.sound));
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
        self.listener.tick(world.snapshot(), world.events(), controls);
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
