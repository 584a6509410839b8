//! Check of the qualities at which the graphics card keeps the screen's rate. In: a drive, the size of its picture and the screen's rate.
//! Out: a [`Finding`]; without a graphics card, that it was not measured.

use super::{Finding, FindingGrade};
use crate::{
    driver,
    render::{Gpu, OFFSCREEN, Renderer, canvas, device_times, keeps_rate, quality_for},
    scenario::QualityLevel,
    scene::{self, StaticScene, ViewKind, view_options},
    sim::World,
};
use std::{error::Error, time::Duration};

const WHAT: &str = "quality";
/// Measured qualities, best first.
const QUALITIES: [QualityLevel; 3] = [QualityLevel::High, QualityLevel::Medium, QualityLevel::Low];
/// Time for the pictures of one quality.
const LIMIT: Duration = Duration::from_millis(1500);
/// Number of ticks between two pictures: 20 ms.
const TICKS: usize = 2;
/// Refresh rate where the screen's is not known, Hz.
const USUAL_HZ: f64 = 60.0;

/// Measures the driver's view at each quality on the graphics card, while a simulated driver drives.
pub(super) fn examine(
    gpu: &Gpu,
    world: &mut World,
    static_scene: &StaticScene,
    size: [u32; 2],
    screen_hz: Option<f64>,
) -> Finding {
    if let Some(why) = gpu.lacks_device_times() {
        return Finding::ok(WHAT, format!("not measured: {why}"));
    }
    match measure(gpu, world, static_scene, size, LIMIT) {
        Ok(late) => judge(size, screen_hz, world.scenario().display.quality, &late),
        Err(error) => Finding::from_message(WHAT, FindingGrade::Fault, &format!("not measured: {error}")),
    }
}

/// Returns the time below which 99 % of the pictures of each quality stay.
fn measure(
    gpu: &Gpu,
    world: &mut World,
    static_scene: &StaticScene,
    size: [u32; 2],
    limit: Duration,
) -> Result<[Duration; 3], Box<dyn Error + Send + Sync>> {
    let scenario = world.scenario();
    let (options, seed) = (view_options(scenario), scenario.seed);
    let mut driver = world.simulated_driver(&driver::named(&scenario.driver)?.params, seed)?;
    let target = canvas(gpu, OFFSCREEN, size);
    let mut late = [Duration::ZERO; 3];
    for (level, late) in QUALITIES.into_iter().zip(&mut late) {
        let mut renderer = Renderer::new(gpu, static_scene, OFFSCREEN, quality_for(level, gpu));
        let draw = |renderer: &mut Renderer| -> Result<(), Box<dyn Error + Send + Sync>> {
            for _ in 0..TICKS {
                let controls = driver.controls(&world.perceived_by(&driver));
                world.tick(&controls)?;
            }
            let view = scene::view(world.snapshot(), 1.0, ViewKind::Driver, &options, static_scene);
            renderer.draw(&view, None, &target, size);
            Ok(())
        };
        let mut times = device_times(gpu, &mut renderer, limit, draw)?;
        times.sort();
        let last = times.len().checked_sub(1).ok_or("the driver returned no timestamps")?;
        *late = times[(last as f64 * 0.99).round() as usize];
    }
    Ok(late)
}

/// Grades the times below which 99 % of the pictures stay, in the order of [`QUALITIES`].
fn judge(size: [u32; 2], screen_hz: Option<f64>, chosen: QualityLevel, late: &[Duration; 3]) -> Finding {
    let hz = screen_hz.unwrap_or(USUAL_HZ);
    let rows = || QUALITIES.into_iter().zip(late);
    let times: Vec<String> = rows().map(|(level, late)| format!("{level} {:.1}", late.as_secs_f64() * 1e3)).collect();
    let kept: Vec<QualityLevel> = rows().filter(|(_, late)| keeps_rate(**late, hz)).map(|(level, _)| level).collect();
    let names: Vec<String> = kept.iter().map(ToString::to_string).collect();
    let (times, names) = (times.join(", "), if names.is_empty() { "no quality".into() } else { names.join(", ") });
    let assumed = if screen_hz.is_some() { "" } else { " (assumed)" };
    let found = format!(
        "{}x{} at {hz:.0} Hz{assumed} is kept at: {names}; 99 % of the pictures on the graphics card below, ms: {times}",
        size[0], size[1]
    );
    match kept.first() {
        None => Finding::warning(WHAT, found, "a smaller --size and screen, a slower rate, or a faster graphics card"),
        Some(best) if chosen != QualityLevel::Auto && !kept.contains(&chosen) => {
            Finding::warning(WHAT, found, format!("--quality {best}, or --quality auto"))
        }
        Some(_) => Finding::ok(WHAT, found),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scenario::{DisplaySettings, Scenario},
        traffic::EngineChoice,
    };

    #[test]
    fn qualities_that_keep_the_screens_rate_are_named() {
        let late = [9.0, 5.0, 2.0].map(|ms| Duration::from_secs_f64(ms / 1e3));
        let of = |hz, chosen| judge([1920, 1080], hz, chosen, &late);
        // Three quarters of an interval: 12.5 ms at 60 Hz, 5.2 ms at 144 Hz, 1.5 ms at 500 Hz.
        let slow = of(None, QualityLevel::Auto);
        assert!(
            slow.grade == FindingGrade::Ok && slow.found.contains("60 Hz (assumed) is kept at: high, medium, low;")
        );
        let fast = of(Some(144.0), QualityLevel::Medium);
        assert_eq!(fast.grade, FindingGrade::Ok);
        assert!(
            fast.found.contains("144 Hz is kept at: medium, low;")
                && fast.found.ends_with("high 9.0, medium 5.0, low 2.0")
        );
        let wrong = of(Some(144.0), QualityLevel::High);
        assert_eq!(wrong.grade, FindingGrade::Warning);
        assert_eq!(wrong.remedy.as_deref(), Some("--quality medium, or --quality auto"));
        let none = of(Some(500.0), QualityLevel::Auto);
        assert!(none.grade == FindingGrade::Warning && none.found.contains("kept at: no quality;"), "{none:?}");
    }

    #[test]
    fn each_quality_is_measured_in_a_drive_that_goes_on() {
        let display = DisplaySettings { trees: 20, ..DisplaySettings::default() };
        let scenario = Scenario { traffic: EngineChoice::Native, display, ..Scenario::default() };
        let (gpu, mut world) = (Gpu::shared().unwrap(), World::new(&scenario).unwrap());
        let static_scene = StaticScene::of_drive(world.map(), world.scenario(), world.drive().roadside());
        let late = measure(gpu, &mut world, &static_scene, [64, 36], Duration::ZERO).unwrap();
        assert!(late.iter().all(|late| *late > Duration::ZERO), "{late:?}");
        // Of each quality one picture that is not counted and one that is, 20 ms each.
        assert_eq!(world.snapshot().tick.0, 12);
    }
}
