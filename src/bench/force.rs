//! Pace of the force thread while pictures are drawn at full speed. In: a drive ready to be drawn. Out: deviation of the
//! thread's turns from their period.

use super::{DrawnDrive, TimeStatistics, now};
use crate::{
    drive_loop::RunError,
    input::{
        ForceInput,
        force_thread::{ForceDevice, ForceLoop, ForceThread, PERIOD, SharedAngle},
        profiles,
    },
};
use serde::Serialize;
use std::{
    io,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

/// Pace of the force thread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ForceTimes {
    /// Period of the thread, ms.
    pub period_ms: f64,
    /// Deviation of the time between turns from the period.
    pub jitter: TimeStatistics,
    /// Median time of the pictures drawn meanwhile, ms.
    pub frame_ms: f64,
}

/// Force device that ignores forces and keeps the times of the thread's turns.
#[derive(Clone, Default)]
struct TurnTimes(Arc<Mutex<Vec<Instant>>>);

impl ForceDevice for TurnTimes {
    fn set(&mut self, _level: i16) -> io::Result<()> {
        Ok(())
    }

    fn turned(&mut self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(now());
    }

    fn end(&mut self) {}
}

/// Measures over `seconds` of simulation, with 60 pictures in each. Returns `None` if the thread cannot start.
///
/// # Errors
/// The drive cannot continue, or the graphics device is lost.
pub fn force(picture: &mut DrawnDrive, seconds: f64, size: [u32; 2]) -> Result<Option<ForceTimes>, RunError> {
    let Ok(profile) = profiles::named("g29") else { return Ok(None) };
    let watch = TurnTimes::default();
    let force = ForceLoop::new(Box::new(watch.clone()), &profile);
    let Ok(thread) = ForceThread::start(force, Arc::new(SharedAngle::default())) else { return Ok(None) };
    let over = AtomicBool::new(false);
    let drive = std::thread::scope(|scope| {
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                thread.set_input(ForceInput {
                    aligning_nm: 0.0,
                    speed_mps: 20.0,
                    grass: 1.0,
                    contact: 0.0,
                    pulse: 0.0,
                    held_rad: None,
                    running: true,
                });
                std::thread::sleep(Duration::from_millis(10));
            }
        });
        let drive = picture.drive(seconds, size, |_| ());
        over.store(true, Ordering::Relaxed);
        drive
    })?;
    drop(thread);
    let times = std::mem::take(&mut *watch.0.lock().unwrap_or_else(PoisonError::into_inner));
    let jitter: Vec<Duration> = times.windows(2).map(|w| (w[1] - w[0]).abs_diff(PERIOD)).collect();
    Ok((!jitter.is_empty()).then(|| ForceTimes {
        period_ms: PERIOD.as_secs_f64() * 1e3,
        jitter: TimeStatistics::of(jitter),
        frame_ms: drive.times.median_us / 1e3,
    }))
}
