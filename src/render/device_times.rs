//! Times of pictures on the graphics card, by its own timestamps. In: pictures to draw one after the other, and the time allowed. Out: the
//! time of each.

use super::{Gpu, GpuError, Renderer};
use std::time::{Duration, Instant};

/// Number of pictures before the measurement. They make what the first use needs, and let the card raise its clock.
const WARM: usize = 3;
/// Maximum number of measured pictures.
const PICTURES: usize = 60;

/// Draws pictures until `limit` has passed, at most 60 and a few before them, and returns the time of each on the graphics card.
/// `draw` gets the renderer and draws the next picture. At least one picture is measured; none are without timestamps.
///
/// # Errors
/// The device is lost, or an error of `draw`.
pub fn device_times<E: From<GpuError>>(
    gpu: &Gpu,
    renderer: &mut Renderer,
    limit: Duration,
    mut draw: impl FnMut(&mut Renderer) -> Result<(), E>,
) -> Result<Vec<Duration>, E> {
    let begin = now();
    let mut times = Vec::new();
    for picture in 0..WARM + PICTURES {
        let is_counted = picture >= WARM || (picture > 0 && begin.elapsed() >= limit);
        draw(renderer)?;
        gpu.finish()?;
        let Some(passes) = renderer.take_pass_times() else { break };
        if is_counted {
            times.push(Duration::from_secs_f32(passes.picture_ms / 1e3));
            if begin.elapsed() >= limit {
                break;
            }
        }
    }
    Ok(times)
}

#[allow(clippy::disallowed_methods, reason = "the time of the measurement is limited here")]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        hud::Speedometer,
        render::{OFFSCREEN, Quality, canvas},
        scenario::{DisplaySettings, Scenario},
        scene::{self, StaticScene, ViewKind, view_options},
        sim::World,
        traffic::EngineChoice,
    };

    #[test]
    fn each_picture_has_one_time_that_covers_its_passes() {
        const SIZE: [u32; 2] = [64, 36];
        let display = DisplaySettings { trees: 20, ..DisplaySettings::default() };
        let scenario = Scenario { traffic: EngineChoice::Native, display, ..Scenario::default() };
        let (gpu, world) = (Gpu::shared().unwrap(), World::new(&scenario).unwrap());
        let static_scene = StaticScene::of_drive(world.map(), &scenario, world.drive().roadside());
        let mut renderer = Renderer::new(gpu, &static_scene, OFFSCREEN, Quality::LOW);
        let mut view = scene::view(world.snapshot(), 1.0, ViewKind::Driver, &view_options(&scenario), &static_scene);
        view.dial = Some(Speedometer::new(&world).read(world.snapshot()));
        let target = canvas(gpu, OFFSCREEN, SIZE);
        for _ in 0..3 {
            renderer.draw(&view, None, &target, SIZE);
            gpu.finish().unwrap();
            let times = renderer.take_pass_times().expect("Mesa's software renderer has timestamps");
            let passes = [times.shadow_ms, times.main_ms, times.mirror_ms, times.tonemap_ms];
            assert!(passes.iter().all(|pass_ms| (0.0..=times.picture_ms).contains(pass_ms)), "{times:?}");
            assert!(times.main_ms > 0.0, "{times:?}");
            assert_eq!(renderer.take_pass_times(), None, "each time is taken once");
        }
        for (limit, measured, drawn) in [(Duration::ZERO, 1, 2), (Duration::from_secs(600), PICTURES, PICTURES + WARM)]
        {
            let mut count = 0;
            let times = device_times::<GpuError>(gpu, &mut renderer, limit, |renderer| {
                count += 1;
                renderer.draw(&view, None, &target, SIZE);
                Ok(())
            });
            assert_eq!((times.unwrap().len(), count), (measured, drawn));
        }
    }
}
