//! A drive as it is heard. In: the world after each tick, pause and horn a frame. Out: what the speaker plays; for a
//! recording that is driven again, a file.

use super::{AppError, replay::Replay};
use crate::{
    audio::{Hear, Listener, SoundFile, Speaker},
    ego::Controls,
    record::{Reader, RecordError, Table},
    sim::{Scenario, World},
};
use std::path::{Path, PathBuf};

/// Name of the event that a recording has where a hand came to the horn or went, with "on" or "off".
pub const HORN: &str = "horn";

/// Ears of a drive and, in a window, its speaker.
pub struct Sound {
    listener: Listener,
    speaker: Option<Speaker>,
    horn: bool,
}

impl Sound {
    /// Nothing is played until [`Sound::open`].
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
            speaker.hear(&self.hear(running, horn));
        }
        std::mem::replace(&mut self.horn, horn) != horn
    }

    /// What there is to be heard.
    pub fn hear(&self, running: bool, horn: bool) -> Hear {
        self.listener.hear(running, horn)
    }
}

/// The sound of a recorded drive, tick by tick into a file.
pub struct Track {
    path: PathBuf,
    file: SoundFile,
    sound: Sound,
    /// Ticks at which a hand came to the horn (true) or went, in order.
    horn: Vec<(u64, bool)>,
    held: bool,
}

impl Track {
    /// Begins the file, at the scenario's levels; the recording tells when the horn was held.
    ///
    /// # Errors
    /// There is such a file already, or the recording's events cannot be read.
    pub fn begin(path: &Path, replay: &Replay, recording: &Path) -> Result<Self, AppError> {
        let events = Reader::parquet(&Table::Events.parquet(recording))?;
        let rows = events.wholes("tick").into_iter().zip(events.words("event").into_iter().zip(events.words("detail")));
        let mut horn: Vec<(u64, bool)> =
            rows.filter(|(_, (event, _))| event == HORN).map(|(tick, (_, how))| (tick, how == "on")).collect();
        horn.sort_by_key(|(tick, _)| *tick);
        horn.reverse();
        let scenario = replay.world().scenario();
        let refused = |why| RecordError::File { path: path.into(), why };
        let file = SoundFile::begin(path, &scenario.sound).map_err(refused)?;
        Ok(Self { path: path.into(), file, sound: Sound::new(scenario), horn, held: false })
    }

    /// The replay has made a tick.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn tick(&mut self, replay: &Replay) -> Result<(), AppError> {
        let world = replay.world();
        while let Some((_, held)) = self.horn.pop_if(|(tick, _)| *tick < world.snapshot().tick.0) {
            self.held = held;
        }
        self.sound.tick(world, &replay.controls());
        let path = self.path.clone();
        let refused = |why| RecordError::File { path, why };
        Ok(self.file.tick(&self.sound.hear(true, self.held)).map_err(refused)?)
    }

    /// The end of the drive.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn end(self) -> Result<(), AppError> {
        let path = self.path;
        Ok(self.file.end().map_err(|why| RecordError::File { path, why })?)
    }
}
