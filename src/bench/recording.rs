//! What recording costs the loop. In: a scenario. Out: time of the recorder's side of a tick: its rows, its frame's row, and
//! twice or so a second the batch that is handed to the writing thread. The disk is that thread's affair.

use super::{TimeStatistics, now};
use crate::{
    controls::Controls,
    drive_loop::{RunError, recording_manifest},
    record::{RecordError, Recorder, tables::FrameRow},
    scenario::Scenario,
    sim::{SummaryAccumulator, World},
    temporary::TemporaryFolder,
    traffic::EngineChoice,
};
use std::time::Duration;

/// The 99th percentile that the project asks for, microseconds.
pub const RECORDER_LIMIT_US: f64 = 50.0;

/// Ticks that are measured, and ticks from one batch to the next: as a window has it, every 0.4 s.
const TICKS: u64 = 4000;
const BATCH: u64 = 40;

/// Records a drive in a folder of its own, which goes again.
///
/// # Errors
/// The scenario cannot be simulated, or the folder for temporary files refuses.
pub fn recording(scenario: &Scenario) -> Result<TimeStatistics, RunError> {
    let native = Scenario { traffic: EngineChoice::Native, ..scenario.clone() };
    let mut world = World::new(&native)?;
    let folder = TemporaryFolder::new().map_err(|why| RecordError::File { path: std::env::temp_dir(), why })?;
    record(&mut world, &folder.path().join("recording"))
}

fn record(world: &mut World, folder: &std::path::Path) -> Result<TimeStatistics, RunError> {
    let mut recorder =
        Recorder::begin(folder, world.scenario(), recording_manifest::manifest(world, "bench".into(), None))?;
    let controls = Controls { throttle: 0.1, ..Controls::default() };
    let mut tally = SummaryAccumulator::new([0.0, f64::INFINITY]);
    let mut times = Vec::new();
    for tick in 0..TICKS {
        world.tick(&controls)?;
        tally.add(world.snapshot(), world.events());
        let begin = now();
        recorder.tick(world, &controls)?;
        recorder.frame(FrameRow { frame: tick, tick: world.snapshot().tick, ..FrameRow::default() });
        if tick % BATCH == BATCH - 1 {
            recorder.flush()?;
        }
        times.push(begin.elapsed());
        // A drive hands over far slower than this loop: the queue is never full, and the thread works beside the ticks.
        while recorder.writer_status().waiting()[0] > 4 {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
    recorder.finish(&tally.summary())?;
    Ok(TimeStatistics::of(times))
}
