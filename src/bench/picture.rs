//! Pictures: start-up to the first picture, every view at every size, and a drive of minutes with its hitches. In: a scenario.
//! Out: times, and the memory in use on the device.

use super::{TimeStatistics, network, now, present_memory_mb};
use crate::{
    drive_loop::{RunError, offline::OfflineDrive},
    hud::Speedometer,
    render::{Gpu, OFFSCREEN, Renderer, canvas, device_times, quality_for},
    scenario::{DisplaySettings, PlannedDrive, QualityLevel, Scenario},
    scene::{self, StaticScene, View, ViewKind, view_options},
    sim::WorldError,
    temporary::TemporaryFolder,
    traffic::{EngineChoice, TrafficError},
};
use serde::Serialize;
use std::time::Duration;

/// Sizes of the measured pictures, pixels, smallest first.
pub const SIZES: [[u32; 2]; 4] = [[640, 360], [1280, 720], [1920, 1080], [3840, 2160]];

/// Times of the start-up to the first picture, ms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StartupTimes {
    /// World: map, traffic and ego.
    pub world_ms: f64,
    /// Opening of the graphics device.
    pub device_ms: f64,
    /// Static scene: road, land, trees and models; what is left to do when world and device are ready, as it is built meanwhile.
    pub static_scene_ms: f64,
    /// Renderer: pipelines, textures and upload.
    pub renderer_ms: f64,
    /// First picture, until the device is done.
    pub frame_ms: f64,
    /// Sum of all parts.
    pub total_ms: f64,
}

/// Times of one view at one size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameTimes {
    /// Name of the view.
    pub view: &'static str,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Quality level of the scenario.
    pub quality: QualityLevel,
    /// Times to draw a picture and wait until the device is done.
    pub times: TimeStatistics,
    /// Last frame's shadow, main, mirror and tone-mapping pass on the device, ms; `None` without device timestamps.
    pub passes: Option<[f32; 4]>,
    /// Memory of textures and buffers on the device, MB; `None` if the driver does not report it.
    pub device_mb: Option<f64>,
}

/// Times of a drive of minutes in real time, or faster if a picture takes less than a sixtieth of a second.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveTimes {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Simulated time of the drive, s.
    pub seconds: f64,
    /// Times of simulation and picture of each frame, until the device is done.
    pub times: TimeStatistics,
    /// Number of frames that took more than three times the median, which are seen as a jerk.
    pub hitches: usize,
    /// Growth of the process's memory from the first picture to the last, MB; `None` if the system does not report it.
    pub grown_mb: Option<f64>,
}

/// Drive ready to be drawn.
pub struct DrawnDrive {
    pub(super) gpu: Gpu,
    run: OfflineDrive,
    static_scene: StaticScene,
    renderer: Renderer,
    instruments: Speedometer,
    /// Texture to draw on, and its size in pixels.
    target: Option<(wgpu::TextureView, [u32; 2])>,
}

/// Views in which growth is measured.
const VIEWS_OF_GROWTH: [(&str, ViewKind); 2] = [("driver", ViewKind::Driver), ("birdseye", ViewKind::Birdseye)];

/// Growth of the cost with the contents: of a large place against a small one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostGrowth {
    /// Large and small place in words.
    pub places: [String; 2],
    /// Name of the view.
    pub view: &'static str,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Median time of a picture of the small place, ms.
    pub small_ms: f64,
    /// Median time of a picture of the large place, ms.
    pub large_ms: f64,
    /// Quotient of `large_ms` and `small_ms`.
    pub ratio: f64,
}

/// Draws the small place, the large one and the small one again, `n` times each, in two views: a short and a long ring, the short ring and a town
/// of a thousand vehicles, grids of 98 and of 10,200 edges. The latter two need SUMO, of which one can run at a time.
///
/// # Errors
/// As in [`startup`] and [`DrawnDrive::frames`].
pub fn growth(scenario: &Scenario, size: [u32; 2], n: u32) -> Result<Vec<CostGrowth>, RunError> {
    let display = |trees| DisplaySettings { trees, ..scenario.display.clone() };
    let ring = |map: &str, vehicles, trees| {
        let traffic = EngineChoice::Native;
        Scenario { map: map.into(), vehicles, traffic, display: display(trees), ..Scenario::default() }
    };
    let measured = |places: [&str; 2], large: &Scenario, small: &Scenario| -> Result<Vec<CostGrowth>, RunError> {
        let (before, _) = times_ms(small, size, n)?;
        let (large, vehicles) = times_ms(large, size, n)?;
        let (after, _) = times_ms(small, size, n)?;
        let rows = VIEWS_OF_GROWTH.iter().enumerate().map(|(k, (view, _))| {
            let (small_ms, large_ms) = ((before[k] + after[k]) / 2.0, large[k]);
            let places = [format!("{} with {vehicles} vehicles", places[0]), places[1].to_owned()];
            CostGrowth { places, view, size, small_ms, large_ms, ratio: large_ms / small_ms }
        });
        Ok(rows.collect())
    };
    let places = ["ring-641, 5000 trees", "ring-250, 1000 trees, 22"];
    let mut rows = measured(places, &ring("ring-641", 40, 5000), &ring("ring-250", 22, 1000))?;
    let folder = TemporaryFolder::new().map_err(|error| TrafficError::Setup(error.to_string()));
    let folder = folder.map_err(WorldError::from)?;
    let grid = |is_large| network::drive_on_grid(folder.path(), is_large, scenario);
    let networks = network::drive_in_full_town(folder.path(), scenario)
        .and_then(|town| Ok((town, grid(true)?, grid(false)?)))
        .map_err(WorldError::from);
    let (town, large, small) = match networks {
        Ok(networks) => networks,
        Err(WorldError::Traffic(TrafficError::Absent(why))) => {
            log::warn!("no network to draw: {why}");
            return Ok(rows);
        }
        Err(error) => return Err(error.into()),
    };
    let trees = scenario.display.trees;
    rows.extend(measured(["the town", "ring-250 with 22"], &town, &ring("ring-250", 22, trees))?);
    rows.extend(measured(["a grid of 10,200 edges", "one of 98"], &large, &small)?);
    Ok(rows)
}

/// Returns the median time of a picture in each view of a drive that goes on meanwhile, ms, and the number of vehicles at its end.
fn times_ms(scenario: &Scenario, size: [u32; 2], n: u32) -> Result<([f64; 2], usize), RunError> {
    let (_, mut picture) = startup(scenario)?;
    let frames = picture.frames(&VIEWS_OF_GROWTH, &[size], n)?;
    let vehicles = picture.run.world().snapshot().cars.len() + 1;
    Ok(([0, 1].map(|view| frames[view].times.median_us / 1e3), vehicles))
}

/// Starts as `codrive drive` does, up to the first picture. The drive has no end; the measurements limit it.
///
/// # Errors
/// The world cannot start, or there is no graphics adapter.
pub fn startup(scenario: &Scenario) -> Result<(StartupTimes, DrawnDrive), RunError> {
    let scenario = &Scenario { duration_s: 0.0, ..scenario.clone() };
    let mut laps = vec![now()];
    let planned = PlannedDrive::new(scenario).map_err(WorldError::from)?;
    let static_scene = StaticScene::begin(&planned);
    let run = OfflineDrive::of(planned, [0.0, f64::INFINITY])?;
    laps.push(now());
    let gpu = Gpu::headless()?;
    laps.push(now());
    let static_scene = static_scene.join().expect("a scene of a valid road");
    laps.push(now());
    let renderer = Renderer::new(&gpu, &static_scene, OFFSCREEN, quality_for(scenario.display.quality, &gpu));
    laps.push(now());
    let instruments = Speedometer::new(run.world());
    let mut picture = DrawnDrive { gpu, run, static_scene, renderer, instruments, target: None };
    picture.draw(ViewKind::Driver, [1280, 720])?;
    laps.push(now());
    let ms = |from: usize, to: usize| (laps[to] - laps[from]).as_secs_f64() * 1e3;
    let startup = StartupTimes {
        world_ms: ms(0, 1),
        device_ms: ms(1, 2),
        static_scene_ms: ms(2, 3),
        renderer_ms: ms(3, 4),
        frame_ms: ms(4, 5),
        total_ms: ms(0, 5),
    };
    Ok((startup, picture))
}

impl DrawnDrive {
    /// Draws each of `views` at every size `n` times, one step of the drive before each. One picture more, before these and not
    /// counted, sets up resources of the first use.
    ///
    /// # Errors
    /// The drive cannot continue, or the graphics device is lost.
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

    /// Drives on for `seconds` of simulation and draws the driver's view as a window would: 60 pictures a second, or as many as
    /// this machine can. Each picture advances the drive by the time that the one before took. Calls `progress` with the
    /// completed share.
    ///
    /// # Errors
    /// As in [`DrawnDrive::frames`].
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
        let hitches = times.iter().filter(|t| t.as_secs_f64() * 1e6 > 3.0 * all.median_us).count();
        let grown_mb = present_memory_mb().zip(before_mb).map(|(after, before)| after - before);
        Ok(DriveTimes { size, seconds: driven_s, times: all, hitches, grown_mb })
    }

    /// Returns the description of the graphics adapter.
    pub fn adapter(&self) -> String {
        self.gpu.description()
    }

    /// Draws at another quality from now on.
    pub(super) fn set_quality(&mut self, level: QualityLevel) {
        self.renderer = Renderer::new(&self.gpu, &self.static_scene, OFFSCREEN, quality_for(level, &self.gpu));
    }

    /// Returns the time of each picture on the graphics card, one step of the drive before each, as many as `limit` allows
    /// ([`device_times`]).
    ///
    /// # Errors
    /// As in [`DrawnDrive::frames`].
    pub(super) fn device_times(
        &mut self,
        kind: ViewKind,
        size: [u32; 2],
        limit: Duration,
    ) -> Result<Vec<Duration>, RunError> {
        self.fit(size);
        let Self { gpu, run, static_scene, renderer, instruments, target } = self;
        let (target, _) = target.as_ref().expect("just fitted");
        device_times(gpu, renderer, limit, |renderer| {
            run.step()?;
            renderer.draw(&view(run, static_scene, instruments, kind), None, target, size);
            Ok(())
        })
    }

    /// Makes the target of pictures of this size, if it is not there.
    fn fit(&mut self, size: [u32; 2]) {
        if self.target.as_ref().is_none_or(|(_, old)| *old != size) {
            self.target = Some((canvas(&self.gpu, OFFSCREEN, size), size));
        }
    }

    /// Draws one picture and waits until the device is done, as a window that shows every frame would.
    fn draw(&mut self, kind: ViewKind, size: [u32; 2]) -> Result<Duration, RunError> {
        self.fit(size);
        let Self { gpu, run, static_scene, renderer, instruments, target } = self;
        let (target, _) = target.as_ref().expect("just fitted");
        let begin = now();
        renderer.draw(&view(run, static_scene, instruments, kind), None, target, size);
        gpu.finish()?;
        Ok(begin.elapsed())
    }
}

/// Returns the present picture of a drive, with the speedometer where the view has one.
fn view(run: &OfflineDrive, static_scene: &StaticScene, instruments: &mut Speedometer, kind: ViewKind) -> View {
    let world = run.world();
    let mut view = scene::view(world.snapshot(), 1.0, kind, &view_options(world.scenario()), static_scene);
    view.dial = kind.has_dial().then(|| instruments.read(world.snapshot()));
    view
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measured_drive_may_last_longer_than_its_scenario() {
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
