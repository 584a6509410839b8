//! Sound of a recorded drive, off-line. In: a replay tick by tick, and the recording's events. Out: a sound file.

use super::Replay;
use crate::{
    audio::SoundFile,
    drive_loop::RunError,
    live_drive::sound::{DriveSound, HORN},
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
}

impl SoundTrack {
    /// Begins the file at the scenario's sound levels; the horn follows the recording's events.
    ///
    /// # Errors
    /// The file exists already, or the recording's events cannot be read.
    pub fn begin(path: &Path, replay: &Replay, recording: &Path) -> Result<Self, RunError> {
        let events = TableReader::parquet(&Table::Events.parquet(recording))?;
        let rows = events.wholes("tick").into_iter().zip(events.words("event").into_iter().zip(events.words("detail")));
        let mut horn: Vec<(u64, bool)> =
            rows.filter(|(_, (event, _))| event == HORN).map(|(tick, (_, how))| (tick, how == "on")).collect();
        horn.sort_by_key(|(tick, _)| *tick);
        horn.reverse();
        let scenario = replay.world().scenario();
        let refused = |why| RecordError::File { path: path.into(), why };
        let file = SoundFile::begin(path, &scenario.sound).map_err(refused)?;
        Ok(Self { path: path.into(), file, sound: DriveSound::new(scenario), horn, held: false })
    }

    /// Adds the sound of a tick of the replay.
    ///
    /// # Errors
    /// An I/O error.
    pub fn tick(&mut self, replay: &Replay) -> Result<(), RunError> {
        let world = replay.world();
        while let Some((_, held)) = self.horn.pop_if(|(tick, _)| *tick < world.snapshot().tick.0) {
            self.held = held;
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
