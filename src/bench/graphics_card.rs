//! Pictures on the graphics card: every view at every quality and size, by the card's own timestamps. In: a scenario. Out: times, and the
//! refresh rates that they keep. A computer without a graphics card is not measured.

use super::{DrawnDrive, TimeStatistics, now, startup};
use crate::{
    drive_loop::RunError,
    render::{Gpu, keeps_rate},
    scenario::{QualityLevel, Scenario},
    scene::ViewKind,
};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Sizes of the measured pictures, pixels.
pub const CARD_SIZES: [[u32; 2]; 2] = [[1920, 1080], [3840, 2160]];
/// Qualities of the measured pictures.
const QUALITIES: [QualityLevel; 3] = [QualityLevel::Low, QualityLevel::Medium, QualityLevel::High];
/// Usual refresh rates of screens, Hz, fastest first.
const RATES_HZ: [u32; 9] = [360, 240, 165, 144, 120, 100, 90, 75, 60];
/// Time after which no further row is begun. With the start before it and the last pictures, the command takes less than a minute.
const LIMIT: Duration = Duration::from_secs(40);

/// Times of one view at one quality and size on the graphics card.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CardTimes {
    /// Name of the view.
    pub view: &'static str,
    /// Quality of the pictures.
    pub quality: QualityLevel,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Times of pictures from the begin of the first pass to the end of the last one; `None` if the time was up before.
    pub times: Option<TimeStatistics>,
    /// Fastest usual refresh rate that 99 of 100 pictures keep with a margin ([`keeps_rate`]), Hz; `None` below 60 Hz.
    pub keeps_hz: Option<u32>,
}

/// Measurement of a graphics card.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CardReport {
    /// Name of the adapter.
    pub adapter: String,
    /// Kind of the adapter, such as `DiscreteGpu`.
    pub kind: String,
    /// Graphics interface, such as `Vulkan`.
    pub interface: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Reason for which nothing was measured.
    pub not_measured: Option<&'static str>,
    /// Measured rows; empty if nothing was measured.
    pub rows: Vec<CardTimes>,
}

/// Measures every view at every quality and size. Takes less than a minute; on a computer without a graphics card it measures nothing.
///
/// # Errors
/// As in [`startup`] and [`DrawnDrive::frames`].
pub fn card_times(scenario: &Scenario) -> Result<CardReport, RunError> {
    let gpu = Gpu::headless()?;
    let report = report(&gpu);
    if report.not_measured.is_some() {
        return Ok(report);
    }
    drop(gpu);
    let (_, mut picture) = startup(scenario)?;
    let rows = rows(&mut picture, &QUALITIES, &CARD_SIZES, now() + LIMIT)?;
    Ok(CardReport { rows, ..report })
}

/// Returns a report without rows.
fn report(gpu: &Gpu) -> CardReport {
    let info = &gpu.info;
    CardReport {
        adapter: info.name.clone(),
        kind: format!("{:?}", info.device_type),
        interface: format!("{:?}", info.backend),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        not_measured: gpu.lacks_device_times(),
        rows: Vec::new(),
    }
}

/// Measures rows until `end`; each gets an equal part of the time that is left.
fn rows(
    picture: &mut DrawnDrive,
    qualities: &[QualityLevel],
    sizes: &[[u32; 2]],
    end: Instant,
) -> Result<Vec<CardTimes>, RunError> {
    let mut left = (qualities.len() * sizes.len() * ViewKind::NAMED.len()) as u32;
    let mut rows = Vec::new();
    for &quality in qualities {
        picture.set_quality(quality);
        for &size in sizes {
            for (view, kind) in ViewKind::NAMED {
                let limit = end.saturating_duration_since(now()) / left;
                let times = if limit.is_zero() { vec![] } else { picture.device_times(kind, size, limit)? };
                let times = (!times.is_empty()).then(|| TimeStatistics::of(times));
                let keeps_hz = times.and_then(|times| fastest_kept_hz(Duration::from_secs_f64(times.p99_us / 1e6)));
                rows.push(CardTimes { view, quality, size, times, keeps_hz });
                left -= 1;
            }
        }
    }
    Ok(rows)
}

/// Returns the fastest usual refresh rate that pictures of this time keep.
fn fastest_kept_hz(picture: Duration) -> Option<u32> {
    RATES_HZ.into_iter().find(|hz| keeps_rate(picture, f64::from(*hz)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{scenario::DisplaySettings, traffic::EngineChoice};

    fn drawn() -> DrawnDrive {
        let display = DisplaySettings { trees: 20, ..DisplaySettings::default() };
        startup(&Scenario { traffic: EngineChoice::Native, display, ..Scenario::default() }).unwrap().1
    }

    #[test]
    fn every_view_has_a_row_with_times_of_whole_pictures() {
        let rows = rows(&mut drawn(), &[QualityLevel::Low], &[[64, 36]], now() + Duration::from_secs(3600)).unwrap();
        assert_eq!(rows.iter().map(|row| row.view).collect::<Vec<_>>(), ["driver", "mirror", "birdseye", "chase"]);
        for row in rows {
            let times = row.times.unwrap();
            assert!(times.samples >= 1 && times.min_us > 0.0 && times.min_us <= times.p99_us, "{times:?}");
        }
    }

    #[test]
    fn rows_that_the_time_does_not_reach_are_named_without_times() {
        let rows = rows(&mut drawn(), &[QualityLevel::Low, QualityLevel::High], &[[64, 36]], now()).unwrap();
        assert_eq!(rows.len(), 8);
        assert!(rows.iter().all(|row| row.times.is_none() && row.keeps_hz.is_none()), "{rows:?}");
    }

    #[test]
    fn a_rate_is_kept_with_a_quarter_of_its_interval_to_spare() {
        // 75 % of 1/144, 1/60 s: 5.208 ms, 12.5 ms.
        for (picture_us, hz) in [(5_200, Some(144)), (5_220, Some(120)), (12_499, Some(60)), (12_501, None)] {
            assert_eq!(fastest_kept_hz(Duration::from_micros(picture_us)), hz, "{picture_us} us");
        }
    }

    #[test]
    fn a_computer_without_a_graphics_card_is_not_measured() {
        let software = Gpu::shared().unwrap();
        let report = report(software);
        assert_eq!(report.not_measured.is_some(), software.is_software());
        assert!(!report.adapter.is_empty() && report.rows.is_empty());
    }
}
