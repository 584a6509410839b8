//! Sound of a recorded drive, off-line. In: a replay tick by tick, and the recording's events. Out: a sound file.

use super::Replay;
use crate::{
    audio::SoundFile,
    drive_loop::RunError,
    live_drive::sound::{DriveSound, HORN, SPOKEN_GUIDANCE, SPOKEN_SENTENCE},
    record::{RecordError, Table, TableReader},
};
use std::path::{Path, PathBuf};

/// Sound file of a recorded drive, written tick by tick.
pub struct SoundTrack {
    path: PathBuf,
    file: SoundFile,
    sound: DriveSound,
    /// Ticks at which the horn was pressed (true) or released, in descending order.
    horn: Vec<(u64, bool)>,
    held: bool,
    /// Ticks at which a sentence was spoken, in descending order.
    spoken: Vec<(u64, String)>,
}

impl SoundTrack {
    /// Begins the file at the scenario's sound levels; the horn, spoken guidance and sentences of events follow the recording's events.
    ///
    /// # Errors
    /// The file exists already, or the recording's events cannot be read.
    pub fn begin(path: &Path, replay: &Replay, recording: &Path) -> Result<Self, RunError> {
        let events = TableReader::parquet(&Table::Events.parquet(recording))?;
        let words: Vec<(String, String)> = events.words("event").into_iter().zip(events.words("detail")).collect();
        let rows: Vec<(u64, (String, String))> = events.wholes("tick").into_iter().zip(words).collect();
        let of = |kinds: &[&str]| {
            let of_kind = rows.iter().filter(|(_, (event, _))| kinds.contains(&event.as_str()));
            let mut found: Vec<(u64, String)> = of_kind.map(|(tick, (_, detail))| (*tick, detail.clone())).collect();
            found.sort_by_key(|(tick, _)| *tick);
            found.reverse();
            found
        };
        let horn = of(&[HORN]).into_iter().map(|(tick, how)| (tick, how == "on")).collect();
        let spoken = of(&[SPOKEN_GUIDANCE, SPOKEN_SENTENCE]);
        let scenario = replay.world().scenario();
        let refused = |why| RecordError::File { path: path.into(), why };
        let file = SoundFile::begin(path, &scenario.sound).map_err(refused)?;
        Ok(Self { path: path.into(), file, sound: DriveSound::new(scenario), horn, held: false, spoken })
    }

    /// Adds the sound of a tick of the replay.
    ///
    /// # Errors
    /// An I/O error, or no program that speaks a sentence.
    pub fn tick(&mut self, replay: &Replay) -> Result<(), RunError> {
        let world = replay.world();
        while let Some((_, held)) = self.horn.pop_if(|(tick, _)| *tick < world.snapshot().tick.0) {
            self.held = held;
        }
        while let Some((_, sentence)) = self.spoken.pop_if(|(tick, _)| *tick < world.snapshot().tick.0) {
            self.file.say(&sentence)?;
        }
        self.sound.tick(world, &replay.controls());
        let path = self.path.clone();
        let refused = |why| RecordError::File { path, why };
        Ok(self.file.tick(&self.sound.scene(true, self.held)).map_err(refused)?)
    }

    /// Completes the file at the end of the drive.
    ///
    /// # Errors
    /// An I/O error.
    pub fn end(self) -> Result<(), RunError> {
        let path = self.path;
        Ok(self.file.end().map_err(|why| RecordError::File { path, why })?)
    }
}
