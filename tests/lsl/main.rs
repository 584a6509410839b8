//! Tests of Lab Streaming Layer with other programs at the other end. pylsl and LabRecorder receive the streams of a drive, and devices by
//! pylsl are recorded with it; `scripts/setup --test` installs both. The tests use only this machine's loopback, in a session of their own.
//! With CODRIVE_LSL_SECONDS=600 the drive lasts ten minutes; `--nocapture` prints the figures.

mod devices;
mod outlets;
mod programs;
mod session;
#[allow(dead_code, reason = "of the windows' tests, which use all of it")]
#[path = "../window/xserver.rs"]
mod xserver;

use codrive::{
    input::{Devices, Rig},
    live_drive::{LiveDrive, lab::LabDevices},
    record,
    render::Gpu,
    scenario::{DisplaySettings, Scenario},
    time::Pace,
    traffic::EngineChoice,
};
use std::{
    path::Path,
    time::{Duration, Instant},
};

/// Returns the duration of the drive, s.
pub fn seconds() -> f64 {
    std::env::var("CODRIVE_LSL_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(5.0)
}

/// Runs a live drive without any input, in real time like a window at 60 Hz, recorded in `folder`, with a mark each second.
#[allow(clippy::disallowed_methods, reason = "the loop of a window stands at the wall clock")]
pub fn drive(seconds: f64, lab: LabDevices, folder: &Path) -> (LabDevices, Vec<String>) {
    let gpu = Gpu::shared().expect("a graphics adapter is needed");
    let scenario = Scenario {
        traffic: EngineChoice::Native,
        policy: "constant".into(),
        hold_s: 1.0,
        vehicles: 12,
        warm_up_s: 5.0,
        duration_s: seconds,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    };
    let devices = Devices::with_rig(Rig::fed_by(std::sync::mpsc::channel().1));
    let mut live = LiveDrive::new(&scenario, Pace::RealTime, devices).unwrap();
    live.set_lab(lab);
    live.record(folder, gpu).unwrap();
    live.begin_trial("trial-1-wide").unwrap();
    let (begun, mut flushed) = (Instant::now(), Instant::now());
    let (mut last, mut marks, mut news) = (begun, 0.0, Vec::new());
    while live.drive.world.ended().is_none() {
        std::thread::sleep(Duration::from_millis(16).saturating_sub(last.elapsed()));
        let elapsed = last.elapsed();
        last += elapsed;
        let due = live.advance(elapsed, |_| ()).unwrap();
        live.shown(last - begun, elapsed, &due);
        news.extend(live.take_news());
        if live.drive.world.time_s() >= marks {
            live.note("mark", &format!("at {marks} s"));
            marks += 1.0;
        }
        if flushed.elapsed() > record::FLUSH_EVERY {
            flushed = Instant::now();
            live.flush().unwrap();
        }
    }
    live.finish_recording().unwrap();
    (live.take_lab(), news)
}
