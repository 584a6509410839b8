//! Chooses the quality that this machine can draw: before the drive, because another quality needs other pipelines,
//! which are never made while driving. In: the scenario's level, pictures drawn as a trial. Out: a [`Renderer`].

use super::{Gpu, GpuError, Quality, Renderer, canvas};
use crate::{
    scenario::QualityLevel,
    scene::{StaticScene, View},
};
use std::time::{Duration, Instant};

/// Share of a screen's refresh interval that a picture may take; the rest is for the world and the panel.
const PICTURE_SHARE: f64 = 0.75;
/// Longest time of a picture on a 60 Hz screen.
const BUDGET: Duration = Duration::from_nanos((PICTURE_SHARE * 1e9 / 60.0) as u64);
/// Number of timed pictures in a trial, after one that makes everything needed at the first use.
const TRIALS: usize = 3;

/// Returns the renderer's settings for a level on this adapter. `Auto` is the level expected of the adapter.
pub fn quality_for(level: QualityLevel, gpu: &Gpu) -> Quality {
    match level {
        QualityLevel::Low => Quality::LOW,
        QualityLevel::Medium if gpu.is_software() => Quality::MEDIUM_SOFTWARE,
        QualityLevel::Medium => Quality::MEDIUM,
        QualityLevel::High => Quality::HIGH,
        QualityLevel::Auto => quality_for(expected(gpu), gpu),
    }
}

/// Checks whether pictures that take this long keep up with a screen of `rate_hz`.
pub fn keeps_rate(picture: Duration, rate_hz: f64) -> bool {
    picture.as_secs_f64() * rate_hz <= PICTURE_SHARE
}

/// Returns the first level to try on an adapter of this kind.
fn expected(gpu: &Gpu) -> QualityLevel {
    match gpu.info.device_type {
        wgpu::DeviceType::Cpu => QualityLevel::Low,
        _ => QualityLevel::High,
    }
}

/// Returns the next lower level if a picture took longer than [`BUDGET`]; `None` if it did not, or at the lowest.
fn instead(level: QualityLevel, took: Duration) -> Option<QualityLevel> {
    match level {
        _ if took <= BUDGET => None,
        QualityLevel::High | QualityLevel::Auto => Some(QualityLevel::Medium),
        QualityLevel::Medium => Some(QualityLevel::Low),
        QualityLevel::Low => None,
    }
}

/// Returns a renderer of the scenario's level. For `auto`, it returns the highest level whose pictures of `view` at
/// `size` pixels are in time, or else the lowest. Software rendering gets the lowest without a trial.
///
/// # Errors
/// The device is lost.
pub fn renderer_that_keeps_up(
    gpu: &Gpu,
    static_scene: &StaticScene,
    format: wgpu::TextureFormat,
    asked: QualityLevel,
    view: &View,
    size: [u32; 2],
) -> Result<Renderer, GpuError> {
    let mut level = if asked == QualityLevel::Auto { expected(gpu) } else { asked };
    loop {
        let mut renderer = Renderer::new(gpu, static_scene, format, quality_for(level, gpu));
        if asked != QualityLevel::Auto || level == QualityLevel::Low {
            return Ok(renderer);
        }
        let took = trial(gpu, &mut renderer, format, view, size)?;
        match instead(level, took) {
            None => {
                log::info!("quality {level}: a picture takes {:.1} ms", took.as_secs_f64() * 1e3);
                return Ok(renderer);
            }
            Some(lower) => {
                log::info!("quality {lower}: at {level} a picture takes {:.1} ms", took.as_secs_f64() * 1e3);
                level = lower;
            }
        }
    }
}

/// Returns the median time of a few pictures, each drawn to its end.
fn trial(
    gpu: &Gpu,
    renderer: &mut Renderer,
    format: wgpu::TextureFormat,
    view: &View,
    size: [u32; 2],
) -> Result<Duration, GpuError> {
    let target = canvas(gpu, format, size);
    let mut times = Vec::new();
    for _ in 0..=TRIALS {
        let begin = now();
        renderer.draw(view, None, &target, size);
        gpu.finish()?;
        times.push(begin.elapsed());
    }
    times.remove(0);
    times.sort();
    Ok(times[TRIALS / 2])
}

#[allow(clippy::disallowed_methods, reason = "how long a picture takes is what is measured here")]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_may_take_three_quarters_of_a_refresh_interval() {
        // At 100 Hz an interval has 10 ms.
        for (picture_us, keeps) in [(7_499, true), (7_501, false)] {
            assert_eq!(keeps_rate(Duration::from_micros(picture_us), 100.0), keeps);
        }
    }

    #[test]
    fn only_a_late_picture_lowers_the_level_and_the_lowest_stays() {
        let (soon, late) = (Duration::from_millis(9), Duration::from_millis(13));
        for level in [QualityLevel::Low, QualityLevel::Medium, QualityLevel::High] {
            assert_eq!(instead(level, soon), None);
        }
        assert_eq!(instead(QualityLevel::High, late), Some(QualityLevel::Medium));
        assert_eq!(instead(QualityLevel::Medium, late), Some(QualityLevel::Low));
        assert_eq!(instead(QualityLevel::Low, late), None);
        // Three quarters of a sixtieth of a second, and a nanosecond more.
        let edge = Duration::from_secs(1) * 3 / 4 / 60;
        assert_eq!(instead(QualityLevel::High, edge), None);
        assert_eq!(instead(QualityLevel::Auto, edge + Duration::from_nanos(1)), Some(QualityLevel::Medium));
    }
}
