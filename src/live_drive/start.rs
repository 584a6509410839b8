//! Start of a drive on a thread of its own while the drive loop runs. In: a scenario. Out: the drive and its static
//! scene, once they are ready. Checking and reading a foreign network, the warm-up and the trees may take
//! seconds, in which the window must respond to keys.

use crate::{
    drive_loop::{Drive, RunError},
    scenario::{PlannedDrive, Scenario},
    scene::StaticScene,
    sim::WorldError,
    time::Pace,
    traffic::Interruption,
};
use std::{
    sync::mpsc::{self, Receiver, RecvTimeoutError},
    thread::{self, JoinHandle},
    time::Duration,
};

/// Longest wait of a window's frame for a drive that is starting: a window that handles its keys 20 times a second does not
/// seem frozen.
pub const PATIENCE: Duration = Duration::from_millis(50);
/// Interval between checks of an unwanted drive's thread, and their number: half a second in all.
const LOOK: Duration = Duration::from_millis(10);
const LOOKS: usize = 50;

/// Drive that has started.
pub struct ReadyDrive {
    /// World and clock; the clock is paused.
    pub drive: Drive,
    /// Static scene; `None` if the previous one is kept.
    pub static_scene: Option<StaticScene>,
}

/// Drive that is starting on a thread of its own. If it is dropped early, the thread ends within 0.1 s while it waits
/// for another program, and otherwise after SUMO has read its files.
pub struct PendingDrive {
    scenario: Scenario,
    interruption: Interruption,
    done: Receiver<Result<ReadyDrive, RunError>>,
    thread: Option<JoinHandle<()>>,
}

impl PendingDrive {
    /// Starts the drive; `with_static_scene` also builds its static scene.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub fn begin(scenario: &Scenario, with_static_scene: bool) -> Result<Self, RunError> {
        let interruption = Interruption::default();
        let (to, done) = mpsc::sync_channel(1);
        let (heard, wanted) = (interruption.clone(), scenario.clone());
        let begin = move || {
            heard.obey();
            let started = start(&wanted, Pace::Paused, with_static_scene);
            // There is no receiver if the drive is no longer wanted.
            let _ = to.send(started);
        };
        let thread = thread::Builder::new().name("starting".into()).spawn(begin);
        let thread =
            thread.map_err(|error| RunError::Ended(format!("the thread that starts a drive cannot run: {error}")))?;
        Ok(Self { scenario: scenario.clone(), interruption, done, thread: Some(thread) })
    }

    /// Returns the scenario that is starting.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Returns the drive, or the reason why it cannot start, after waiting for `patience` at most; `None` while it is
    /// starting.
    pub fn wait(&mut self, patience: Duration) -> Option<Result<ReadyDrive, RunError>> {
        match self.done.recv_timeout(patience) {
            Ok(done) => Some(done),
            Err(RecvTimeoutError::Timeout) => None,
            // The thread panicked, and the panic was reported.
            Err(RecvTimeoutError::Disconnected) => Some(Err(RunError::Ended("the thread that starts a drive".into()))),
        }
    }
}

impl Drop for PendingDrive {
    fn drop(&mut self) {
        self.interruption.interrupt();
        let Some(thread) = self.thread.take() else { return };
        // SUMO is free for the next drive once this one has released it. While SUMO reads a large file that takes
        // longer: the window closes nevertheless, and the next start waits.
        for _ in 0..LOOKS {
            if thread.is_finished() {
                let _ = thread.join();
                return;
            }
            thread::sleep(LOOK);
        }
    }
}

/// Starts a drive with a person as the driver; `with_static_scene` also builds its static scene, while the world starts.
///
/// # Errors
/// The world cannot start, or the scenario has no participant.
pub fn start(scenario: &Scenario, pace: Pace, with_static_scene: bool) -> Result<ReadyDrive, RunError> {
    let planned = PlannedDrive::new(scenario).map_err(WorldError::from)?;
    let static_scene = with_static_scene.then(|| StaticScene::begin(&planned));
    let drive = Drive::by_participant(planned, pace)?;
    let static_scene = static_scene.map(|scene| scene.join().expect("a scene of a valid road"));
    Ok(ReadyDrive { drive, static_scene })
}
