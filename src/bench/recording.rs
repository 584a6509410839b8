//! Cost of recording in the drive loop. In: a scenario. Out: time of the recorder's part of a tick: its rows, its frame's row,
//! and a few times a second the hand-over of a batch to the writing thread. The time of the disk is not included.

use super::{TimeStatistics, now, simulation::native_of};
use crate::{
    controls::Controls,
    drive_loop::{RunError, recording_manifest},
    record::{RecordError, Recorder, tables::FrameRow},
    scenario::Scenario,
    sim::{SummaryAccumulator, World},
    temporary::TemporaryFolder,
};
use std::time::Duration;

/// Limit for the 99th percentile, microseconds.
pub const RECORDER_LIMIT_US: f64 = 50.0;

/// Number of measured ticks, and of ticks between two flushes (0.4 s).
const TICKS: u64 = 4000;
const BATCH: u64 = 40;

/// Measures the recorder in a temporary folder.
///
/// # Errors
/// The scenario cannot be simulated, or the temporary folder cannot be made.
pub fn recording(scenario: &Scenario) -> Result<TimeStatistics, RunError> {
    let native = native_of(scenario)?;
    let mut world = World::new(&native)?;
    let folder = TemporaryFolder::new().map_err(|why| RecordError::File { path: std::env::temp_dir(), why })?;
    record(&mut world, &folder.path().join("recording"))
}

fn record(world: &mut World, folder: &std::path::Path) -> Result<TimeStatistics, RunError> {
    let mut recorder =
        Recorder::begin(folder, world.scenario(), recording_manifest::manifest(world, "bench".into(), None))?;
    let controls = Controls { throttle: 0.1, ..Controls::default() };
    let mut summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
    let mut times = Vec::new();
    for tick in 0..TICKS {
        world.tick(&controls)?;
        summary.add(world.snapshot(), world.events());
        let begin = now();
        recorder.tick(world, &controls)?;
        recorder.frame(FrameRow { frame: tick, tick: world.snapshot().tick, ..FrameRow::default() });
        if tick % BATCH == BATCH - 1 {
            recorder.flush()?;
        }
        times.push(begin.elapsed());
        // This loop is far faster than a drive: waiting here keeps the queue from filling, while the thread works beside the
        // ticks.
        while recorder.writer_status().waiting()[0] > 4 {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
    recorder.finish(&summary.to_summary())?;
    Ok(TimeStatistics::of(times))
}
