//! Pictures: from the start to the first one, every view at every size, and a drive of minutes with its hitches. In: a
//! scenario. Out: times, and what the device's memory holds.

use super::{TimeStatistics, now, present_memory_mb};
use crate::{
    drive_loop::{RunError, offline::OfflineDrive},
    hud::Speedometer,
    render::{Gpu, OFFSCREEN, Renderer, canvas, quality_for},
    scenario::{DisplaySettings, QualityLevel, Scenario},
    scene::{self, StaticScene, ViewKind, view_options},
    traffic::EngineChoice,
};
use serde::Serialize;
use std::time::Duration;

/// Sizes of the pictures that are measured, smallest first.
pub const SIZES: [[u32; 2]; 4] = [[640, 360], [1280, 720], [1920, 1080], [3840, 2160]];

/// From nothing to the first picture, milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StartupTimes {
    /// Map, traffic, ego.
    pub world_ms: f64,
    /// Graphics device.
    pub device_ms: f64,
    /// Road, land, trees, models.
    pub stage_ms: f64,
    /// Pipelines, textures, upload.
    pub renderer_ms: f64,
    /// The first picture, read back.
    pub frame_ms: f64,
    /// All of it.
    pub total_ms: f64,
}

/// Times of one view at one size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameTimes {
    /// Name of the view.
    pub view: &'static str,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Level of quality.
    pub quality: QualityLevel,
    /// Draw and wait until the device is done.
    pub times: TimeStatistics,
    /// Last frame's shadow, main, mirror and develop pass on the device, milliseconds, where it has timestamps.
    pub passes: Option<[f32; 4]>,
    /// What textures and buffers take on the device, megabytes, where the driver tells.
    pub device_mb: Option<f64>,
}

/// A drive of minutes in real time, or faster where a picture takes less than a sixtieth of a second.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveTimes {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Seconds of simulation.
    pub seconds: f64,
    /// Simulation and picture of each frame, until the device is done.
    pub times: TimeStatistics,
    /// Frames that took more than twice the median.
    pub hitches: usize,
    /// Memory that the process took between the first picture and the last one, megabytes, where the system tells.
    pub grown_mb: Option<f64>,
}

/// A drive ready to be drawn.
pub struct DrawnDrive {
    gpu: Gpu,
    run: OfflineDrive,
    stage: StaticScene,
    renderer: Renderer,
    instruments: Speedometer,
    /// What is drawn onto, and its size.
    target: Option<(wgpu::TextureView, [u32; 2])>,
}

/// How cost grows with what exists: 40 cars and 5,000 trees on ring-641 over 22 cars and 1,000 trees on ring-250.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostGrowth {
    /// Name of the view.
    pub view: &'static str,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Median of a picture of the small place, milliseconds.
    pub small_ms: f64,
    /// Of the large one.
    pub large_ms: f64,
    /// Median of large over small, of pictures taken in turn.
    pub ratio: f64,
}

/// Draws the small and the large place in turn, `n` times each.
///
/// # Errors
/// As [`startup`] and [`DrawnDrive::frames`].
pub fn growth(scenario: &Scenario, size: [u32; 2], n: u32) -> Result<Vec<CostGrowth>, RunError> {
    let place = |map: &str, vehicles, trees| {
        let (map, traffic) = (map.into(), EngineChoice::Native);
        startup(&Scenario {
            map,
            vehicles,
            traffic,
            display: DisplaySettings { trees, ..scenario.display.clone() },
            ..scenario.clone()
        })
        .map(|(_, picture)| picture)
    };
    let mut places = [place("ring-250", 22, 1000)?, place("ring-641", 40, 5000)?];
    let mut rows = Vec::new();
    for (view, kind) in [("driver", ViewKind::Driver), ("birdseye", ViewKind::Birdseye)] {
        let mut times = [Vec::new(), Vec::new()];
        for turn in 0..=n {
            for (picture, times) in places.iter_mut().zip(&mut times) {
                picture.run.step()?;
                let time_ms = picture.draw(kind, size)?.as_secs_f64() * 1e3;
                if turn > 0 {
                    times.push(time_ms);
                }
            }
        }
        let median = |mut list: Vec<f64>| {
            list.sort_by(f64::total_cmp);
            list[list.len() / 2]
        };
        let [small, large] = times;
        let ratio = median(small.iter().zip(&large).map(|(small, large)| large / small).collect());
        rows.push(CostGrowth { view, size, small_ms: median(small), large_ms: median(large), ratio });
    }
    Ok(rows)
}

/// Starts as `codrive drive` does, up to the first picture. The drive has no end: what is measured says how long it lasts.
///
/// # Errors
/// The world cannot start or there is no graphics adapter.
pub fn startup(scenario: &Scenario) -> Result<(StartupTimes, DrawnDrive), RunError> {
    let scenario = &Scenario { duration_s: 0.0, ..scenario.clone() };
    let mut laps = vec![now()];
    let run = OfflineDrive::new(scenario, [0.0, f64::INFINITY])?;
    laps.push(now());
    let gpu = Gpu::headless()?;
    laps.push(now());
    let stage = StaticScene::with_trees(run.world().map(), scenario.seed, scenario.display.trees as usize);
    laps.push(now());
    let renderer = Renderer::new(&gpu, &stage, OFFSCREEN, quality_for(scenario.display.quality, &gpu));
    laps.push(now());
    let instruments = Speedometer::new(run.world());
    let mut picture = DrawnDrive { gpu, run, stage, renderer, instruments, target: None };
    picture.draw(ViewKind::Driver, [1280, 720])?;
    laps.push(now());
    let ms = |from: usize, to: usize| (laps[to] - laps[from]).as_secs_f64() * 1e3;
    let startup = StartupTimes {
        world_ms: ms(0, 1),
        device_ms: ms(1, 2),
        stage_ms: ms(2, 3),
        renderer_ms: ms(3, 4),
        frame_ms: ms(4, 5),
        total_ms: ms(0, 5),
    };
    Ok((startup, picture))
}

impl DrawnDrive {
    /// Draws each of `views` at every size `n` times, a step of the drive before each; one more before, not counted, for
    /// everything that is made at a first use.
    ///
    /// # Errors
    /// The drive cannot go on or the device is lost.
    pub fn frames(
        &mut self,
        views: &[(&'static str, ViewKind)],
        sizes: &[[u32; 2]],
        n: u32,
    ) -> Result<Vec<FrameTimes>, RunError> {
        let mut rows = Vec::new();
        for &size in sizes {
            for &(view, kind) in views {
                self.draw(kind, size)?;
                let mut times = Vec::new();
                for _ in 0..n {
                    self.run.step()?;
                    times.push(self.draw(kind, size)?);
                }
                let passes = self.renderer.pass_times().map(|p| [p.shadow_ms, p.main_ms, p.mirror_ms, p.tonemap_ms]);
                let quality = self.run.world().scenario().display.quality;
                let device_mb = self.gpu.memory_mb();
                rows.push(FrameTimes { view, size, quality, times: TimeStatistics::of(times), passes, device_mb });
            }
        }
        Ok(rows)
    }

    /// Drives on for `seconds` of simulation and draws the driver's view as a window
    /// would: 60 times in each, or as often as this machine can, each picture as much later as the one before took.
    /// `progress` hears the share that is done.
    ///
    /// # Errors
    /// As [`DrawnDrive::frames`].
    pub fn drive(
        &mut self,
        seconds: f64,
        size: [u32; 2],
        mut progress: impl FnMut(f64),
    ) -> Result<DriveTimes, RunError> {
        const FRAME_S: f64 = 1.0 / 60.0;
        self.draw(ViewKind::Driver, size)?;
        let start_s = self.run.world().snapshot().tick.seconds();
        let (mut times, mut driven_s) = (Vec::new(), FRAME_S);
        let before_mb = present_memory_mb();
        while driven_s < seconds {
            let begin = now();
            self.run.until(start_s + driven_s)?;
            self.draw(ViewKind::Driver, size)?;
            let took = begin.elapsed();
            times.push(took);
            driven_s += took.as_secs_f64().max(FRAME_S);
            progress(driven_s / seconds);
        }
        let all = TimeStatistics::of(times.clone());
        let hitches = times.iter().filter(|t| t.as_secs_f64() * 1e6 > 2.0 * all.median_us).count();
        let grown_mb = present_memory_mb().zip(before_mb).map(|(after, before)| after - before);
        Ok(DriveTimes { size, seconds: driven_s, times: all, hitches, grown_mb })
    }

    /// The adapter, in words.
    pub fn adapter(&self) -> String {
        self.gpu.description()
    }

    /// Draws one picture and waits until the device is done, as a window would that shows every frame.
    fn draw(&mut self, kind: ViewKind, size: [u32; 2]) -> Result<Duration, RunError> {
        let world = self.run.world();
        if self.target.as_ref().is_none_or(|(_, old)| *old != size) {
            self.target = Some((canvas(&self.gpu, OFFSCREEN, size), size));
        }
        let (target, _) = self.target.as_ref().expect("just made");
        let begin = now();
        let mut view = scene::view(world.snapshot(), 1.0, kind, &view_options(world.scenario()), &self.stage);
        view.dial = kind.has_dial().then(|| self.instruments.read(world.snapshot()));
        self.renderer.draw(&view, None, target, size);
        self.gpu.finish()?;
        Ok(begin.elapsed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_of_minutes_lasts_longer_than_a_scenario() {
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            duration_s: 0.2,
            display: DisplaySettings { trees: 20, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let (_, mut picture) = startup(&scenario).unwrap();
        let mut shares = Vec::new();
        let drive = picture.drive(1.0, [64, 36], |share| shares.push(share)).unwrap();
        assert!(drive.seconds >= 1.0 && drive.times.samples >= 2, "{drive:?}");
        assert!(shares.is_sorted() && shares.last().is_some_and(|last| *last >= 1.0));
        assert!(picture.run.world().ended().is_none() && picture.run.world().snapshot().tick.seconds() > 0.2);
    }
}
