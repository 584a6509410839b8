//! Starting a drive on a thread of its own while the loop runs. In: a scenario. Out: the drive and what stands still in it,
//! once they are there. Checking a foreign network, reading it, the warm-up and the trees may take seconds, and a
//! window hears its keys meanwhile.

use crate::{
    drive_loop::{Drive, RunError},
    scenario::Scenario,
    scene::StaticScene,
    sim::World,
    time::Pace,
    traffic::Interruption,
};
use std::{
    sync::mpsc::{self, Receiver, RecvTimeoutError},
    thread::{self, JoinHandle},
    time::Duration,
};

/// How long a frame of a window waits for a drive that is being started: a window that hears its keys 20 times a second does not
/// feel hung.
pub const PATIENCE: Duration = Duration::from_millis(50);
/// Interval at which the thread of an unwanted drive is looked at, and the longest wait for it: half a second.
const LOOK: Duration = Duration::from_millis(10);
const LOOKS: usize = 50;

/// A drive that has begun.
pub struct ReadyDrive {
    /// World and clock, which stands.
    pub drive: Drive,
    /// What stands still, unless the one before is kept.
    pub stage: Option<StaticScene>,
}

/// A drive that is being begun on a thread of its own. Dropped before it is there, it ends within a tenth of a second where
/// it waits for another program, and otherwise once SUMO has read its files.
pub struct PendingDrive {
    scenario: Scenario,
    interruption: Interruption,
    done: Receiver<Result<ReadyDrive, RunError>>,
    thread: Option<JoinHandle<()>>,
}

impl PendingDrive {
    /// Begins; with its own stage unless one is there that fits.
    ///
    /// # Errors
    /// The system has no thread left.
    pub fn begin(scenario: &Scenario, with_stage: bool) -> Result<Self, RunError> {
        let interruption = Interruption::default();
        let (to, done) = mpsc::sync_channel(1);
        let (heard, wanted) = (interruption.clone(), scenario.clone());
        let begin = move || {
            heard.obey();
            let started = start(&wanted, with_stage);
            // Nobody takes it if it is no longer wanted.
            let _ = to.send(started);
        };
        let thread = thread::Builder::new().name("starting".into()).spawn(begin);
        let thread = thread.map_err(|error| RunError::Ended(format!("the thread that begins a drive: {error}")))?;
        Ok(Self { scenario: scenario.clone(), interruption, done, thread: Some(thread) })
    }

    /// What is being begun.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The drive, or why it cannot begin; `None` while it is on its way, after `patience` at most.
    pub fn wait(&mut self, patience: Duration) -> Option<Result<ReadyDrive, RunError>> {
        match self.done.recv_timeout(patience) {
            Ok(done) => Some(done),
            Err(RecvTimeoutError::Timeout) => None,
            // It panicked, and has told why.
            Err(RecvTimeoutError::Disconnected) => Some(Err(RunError::Ended("the thread that begins a drive".into()))),
        }
    }
}

impl Drop for PendingDrive {
    fn drop(&mut self) {
        self.interruption.interrupt();
        let Some(thread) = self.thread.take() else { return };
        // SUMO is free for the next one when this one has let go of it. Where it reads a large file it lets go only after that:
        // the window closes meanwhile, and the next start waits.
        for _ in 0..LOOKS {
            if thread.is_finished() {
                let _ = thread.join();
                return;
            }
            thread::sleep(LOOK);
        }
    }
}

fn start(scenario: &Scenario, with_stage: bool) -> Result<ReadyDrive, RunError> {
    let drive = Drive::by_participant(scenario, Pace::Paused)?;
    let stage = with_stage.then(|| stage(&drive.world));
    Ok(ReadyDrive { drive, stage })
}

/// What stands still in a world.
pub fn stage(world: &World) -> StaticScene {
    let scenario = world.scenario();
    StaticScene::with_trees(world.map(), scenario.seed, scenario.display.trees as usize)
}
