//! Checks of graphics, frame times, SUMO and monitors. In: the scenario to be driven and the size of its picture. Out: [`Finding`]s.

use super::{Finding, FindingGrade, MonitorInfo, MonitorsUnknown, quality};
use crate::{
    input::TimeStamp,
    render::{Gpu, GpuError, OFFSCREEN, Renderer, canvas, quality_for},
    scenario::{QualityLevel, Scenario},
    scene::{self, StaticScene, ViewKind, view_options},
    sim::World,
    traffic::EngineChoice,
};
use std::time::Duration;

/// Number of measured pictures, after a first one that creates all resources.
const PICTURES: usize = 30;
/// Minimum number of pictures, including the first one; then no more are begun after the time `MEASURED`.
const FEWEST_PICTURES: usize = 3;
const MEASURED: Duration = Duration::from_secs(3);
/// Duration of a frame at 60 Hz, ms.
const FRAME_MS: f64 = 1000.0 / 60.0;
const LONGEST_MS: f64 = 1000.0 / 30.0;

/// Checks that SUMO can run the scenario.
pub(super) fn sumo(scenario: &Scenario) -> Finding {
    match World::new(&Scenario { traffic: EngineChoice::Sumo, ..scenario.clone() }) {
        Ok(world) => Finding::ok("SUMO", world.traffic_engine()),
        Err(error) => Finding::from_message("SUMO", FindingGrade::Fault, &error.to_string()),
    }
}

/// Checks the graphics adapter, the time to draw a picture of this size, and the qualities that keep the screen's rate.
pub(super) fn examine(scenario: &Scenario, size: [u32; 2], screen_hz: Option<f64>) -> Vec<Finding> {
    let gpu = match Gpu::headless() {
        Ok(gpu) => gpu,
        Err(error) => return vec![Finding::from_message("graphics", FindingGrade::Fault, &error.to_string())],
    };
    let adapter = if gpu.is_software() {
        let remedy = "a graphics card and its driver; for Vulkan on Debian: apt install mesa-vulkan-drivers";
        Finding::warning("graphics", format!("{}: the processor draws", gpu.description()), remedy)
    } else {
        Finding::ok("graphics", gpu.description())
    };
    let mut world = match World::without_sumo(scenario) {
        Ok(world) => world,
        Err(error) => {
            let times = Finding::from_message("frame time", FindingGrade::Fault, &format!("not measured: {error}"));
            return vec![adapter, times];
        }
    };
    let static_scene = static_scene(&world);
    let times = match frames(&gpu, &world, &static_scene, size, scenario.display.quality) {
        Ok(times_ms) => judge(size, &times_ms),
        Err(error) => Finding::from_message("frame time", FindingGrade::Fault, &error.to_string()),
    };
    vec![adapter, times, quality::examine(&gpu, &mut world, &static_scene, size, screen_hz)]
}

fn static_scene(world: &World) -> StaticScene {
    StaticScene::of_drive(world.map(), world.scenario(), world.drive().roadside())
}

/// Reports the configured screen size and eye distance, which only a tape measure can verify.
pub(super) fn display(scenario: &Scenario) -> Finding {
    let (width_m, eye_m) = (scenario.display.screen_width_m, scenario.display.eye_distance_m);
    let angle_deg = 2.0 * (width_m / 2.0 / eye_m).atan().to_degrees();
    Finding::ok(
        "display",
        format!(
            "set: {width_m:.3} m wide, eyes {eye_m:.2} m away, {angle_deg:.1} degrees; check it with codrive doctor \
             --display"
        ),
    )
}

/// Checks the monitors, one finding each.
pub(super) fn monitors(found: &Result<Vec<MonitorInfo>, MonitorsUnknown>) -> Vec<Finding> {
    match found {
        Err(error) => vec![Finding::from_message("monitor", FindingGrade::Warning, &error.to_string())],
        Ok(all) if all.is_empty() => {
            vec![Finding::warning(
                "monitor",
                "the system lists none",
                "connect a monitor; xrandr or the system's settings list monitors",
            )]
        }
        Ok(all) => all.iter().map(monitor).collect(),
    }
}

/// Returns the refresh rate of the primary monitor, or else of the first one, Hz, if it is known.
pub(super) fn screen_hz(found: &Result<Vec<MonitorInfo>, MonitorsUnknown>) -> Option<f64> {
    let all = found.as_ref().ok()?;
    all.iter().find(|monitor| monitor.primary).or(all.first())?.refresh_hz
}

fn monitor(monitor: &MonitorInfo) -> Finding {
    match monitor.refresh_hz {
        // Tolerance for 59.94 Hz.
        Some(hz) if hz < 59.0 => {
            let remedy = "use a mode of 60 Hz or more (--refresh HZ); slower modes increase the latency";
            Finding::warning("monitor", monitor.to_string(), remedy)
        }
        Some(_) => Finding::ok("monitor", monitor.to_string()),
        None => {
            Finding::warning("monitor", monitor.to_string(), "check the rate in the system's settings: 60 Hz or more")
        }
    }
}

/// Returns the number of pictures of a world that are drawn in a second, by the median of some seconds. A quality that follows the computer
/// counts as low, its last resort.
///
/// # Errors
/// The device is lost.
pub fn frames_per_s(gpu: &Gpu, world: &World, size: [u32; 2]) -> Result<f64, GpuError> {
    let level = match world.scenario().display.quality {
        QualityLevel::Auto => QualityLevel::Low,
        level => level,
    };
    let times_ms = frames(gpu, world, &static_scene(world), size, level)?;
    Ok(1000.0 / times_ms[times_ms.len() / 2])
}

/// Returns the times to draw the driver's view, ms, sorted; draws as many pictures as fit into a few seconds.
fn frames(
    gpu: &Gpu,
    world: &World,
    static_scene: &StaticScene,
    size: [u32; 2],
    level: QualityLevel,
) -> Result<Vec<f64>, GpuError> {
    let mut renderer = Renderer::new(gpu, static_scene, OFFSCREEN, quality_for(level, gpu));
    let view = scene::view(world.snapshot(), 0.0, ViewKind::Driver, &view_options(world.scenario()), static_scene);
    let target = canvas(gpu, OFFSCREEN, size);
    let (mut times_ms, first) = (Vec::new(), TimeStamp::now());
    for _ in 0..=PICTURES {
        if times_ms.len() >= FEWEST_PICTURES && first.until(TimeStamp::now()) > MEASURED {
            break;
        }
        let begin = TimeStamp::now();
        renderer.draw(&view, None, &target, size);
        gpu.finish()?;
        times_ms.push(begin.until(TimeStamp::now()).as_secs_f64() * 1e3);
    }
    times_ms.remove(0);
    times_ms.sort_by(f64::total_cmp);
    Ok(times_ms)
}

/// Grades frame times, given sorted in ms.
fn judge(size: [u32; 2], times_ms: &[f64]) -> Finding {
    let at = |share: f64| times_ms[((times_ms.len() - 1) as f64 * share).round() as usize];
    let (median, late) = (at(0.5), at(0.99));
    let found = format!("{}x{}: median {median:.1} ms, 99 % below {late:.1} ms", size[0], size[1]);
    let remedy = "--quality low, a smaller --size and screen, or a faster graphics card";
    if median > LONGEST_MS {
        Finding::fault("frame time", format!("{found}: latency cannot stay below 50 ms"), remedy)
    } else if late > FRAME_MS {
        Finding::warning("frame time", format!("{found}: a 60 Hz screen will miss frames"), remedy)
    } else {
        Finding::ok("frame time", found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_monitor_is_a_warning_and_each_has_its_number() {
        let of = |number, refresh_hz| MonitorInfo {
            number,
            name: "TV".into(),
            size: [3840, 2160],
            refresh_hz,
            rates_hz: vec![30.0, 59.94],
            primary: number == 1,
        };
        let lines = monitors(&Ok(vec![of(1, Some(59.94)), of(2, Some(30.0)), of(3, None)]));
        assert_eq!(
            lines.iter().map(|l| l.grade).collect::<Vec<_>>(),
            [FindingGrade::Ok, FindingGrade::Warning, FindingGrade::Warning]
        );
        assert_eq!(lines[0].found, "1: TV, 3840x2160, 59.94 Hz (can do 30.00, 59.94 Hz), primary");
        let rate = |all: &[f64]| screen_hz(&Ok((1..).zip(all).map(|(number, hz)| of(number, Some(*hz))).collect()));
        assert_eq!([rate(&[144.0, 60.0]), rate(&[])], [Some(144.0), None]);
        let none = monitors(&Err("no window can be opened\n  remedy: a display".into()));
        assert_eq!((none[0].grade, none[0].remedy.as_deref()), (FindingGrade::Warning, Some("a display")));
    }

    #[test]
    fn late_pictures_are_a_warning_and_slow_ones_a_fault() {
        let of = |median: f64, last: f64| {
            let mut times = vec![median; 29];
            times.push(last);
            judge([1920, 1080], &times).grade
        };
        assert_eq!(of(4.0, 9.0), FindingGrade::Ok);
        assert_eq!(of(4.0, 25.0), FindingGrade::Warning);
        assert_eq!(of(40.0, 41.0), FindingGrade::Fault);
    }
}
