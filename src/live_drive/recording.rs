//! Recording of a live drive. In: ticks, frames, notes. Out: files if there is a recorder, otherwise nothing.

use crate::{
    controls::Controls,
    drive_loop::{RunError, recording_manifest},
    record::{Manifest, RecordError, Recorder, WriterStatus, manifest::ScreenInfo, tables::FrameRow},
    render::Gpu,
    scenario::Scenario,
    sim::{Summary, World},
    study::ParticipantCode,
    time::Tick,
};
use std::path::{Path, PathBuf};

/// Recorder of a drive, if it is recorded, with the number of its frames and its screen.
#[derive(Default)]
pub(super) struct DriveRecording {
    pub(super) recorder: Option<Recorder>,
    /// Number of frames recorded so far.
    frames: u64,
    screen: Option<ScreenInfo>,
}

impl DriveRecording {
    pub(super) fn begin(
        &mut self,
        folder: &Path,
        world: &World,
        driver: String,
        gpu: &Gpu,
        participant: Option<&ParticipantCode>,
    ) -> Result<(), RunError> {
        let participant = participant.map(|code| code.as_str().to_owned());
        let drive = recording_manifest::manifest(world, driver, Some(gpu.description()));
        let manifest = Manifest { participant, screen: self.screen.clone(), ..drive };
        self.recorder = Some(recording_manifest::begin(folder, world, manifest)?);
        Ok(())
    }

    pub(super) fn set_screen(&mut self, screen: ScreenInfo) {
        self.screen = Some(screen);
    }

    /// Replaces the scenario in the recording, after a change during the drive.
    pub(super) fn set_scenario(&self, scenario: &Scenario) -> Result<(), RunError> {
        Ok(self.recorder.as_ref().map_or(Ok(()), |recorder| recorder.set_scenario(scenario))?)
    }

    pub(super) fn force(&mut self, torque_nm: Option<f64>) {
        if let Some(recorder) = &mut self.recorder {
            recorder.force(torque_nm);
        }
    }

    pub(super) fn tick(&mut self, world: &World, controls: &Controls) -> Result<(), RecordError> {
        self.recorder.as_mut().map_or(Ok(()), |recorder| recorder.tick(world, controls))
    }

    /// Records a frame that was shown. Returns its number, or `None` without a recorder.
    pub(super) fn frame(&mut self, row: FrameRow) -> Option<u64> {
        let recorder = self.recorder.as_mut()?;
        let frame = self.frames;
        recorder.frame(FrameRow { frame, ..row });
        self.frames += 1;
        Some(frame)
    }

    pub(super) fn note(&mut self, tick: Tick, kind: &str, detail: &str) {
        if let Some(recorder) = &mut self.recorder {
            recorder.event(tick, kind, detail);
        }
    }

    pub(super) fn note_value(&mut self, tick: Tick, kind: &str, detail: &str, value: f64) {
        if let Some(recorder) = &mut self.recorder {
            recorder.event_with_value(tick, kind, detail, value);
        }
    }

    pub(super) fn writer_status(&self) -> Option<&WriterStatus> {
        self.recorder.as_ref().map(Recorder::writer_status)
    }

    pub(super) fn folder(&self) -> Option<&Path> {
        self.recorder.as_ref().map(Recorder::folder)
    }

    pub(super) fn flush(&mut self) -> Result<(), RunError> {
        Ok(self.recorder.as_mut().map_or(Ok(()), Recorder::flush)?)
    }

    pub(super) fn finish(&mut self, summary: &Summary) -> Result<Option<PathBuf>, RunError> {
        Ok(self.recorder.take().map(|recorder| recorder.finish(summary)).transpose()?)
    }
}
