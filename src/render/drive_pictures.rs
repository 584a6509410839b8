//! Pictures of a drive without a window. In: a road and a scenario once, then the world at any moment. Out: images.

use super::{GpuError, OFFSCREEN, Renderer, device::gpu::Gpu, quality_for, render_to_image};
use crate::{
    hud::Speedometer,
    map::RoadMap,
    roadside::LazyRoadside,
    scenario::{QualityLevel, Scenario},
    scene::{self, StaticScene, ViewKind, view_options},
    sim::World,
};

/// Draws pictures of drives on one road: a graphics device and the static scene.
pub struct DrivePictures {
    gpu: Gpu,
    static_scene: StaticScene,
    renderer: Renderer,
}

impl DrivePictures {
    /// Prepares pictures of drives of this scenario on its road; the trees follow from its seed.
    ///
    /// # Errors
    /// There is no graphics device.
    pub fn new(map: &RoadMap, scenario: &Scenario) -> Result<Self, GpuError> {
        let gpu = Gpu::headless()?;
        // These pictures need not keep up with a screen, so no trial is made.
        let quality = match scenario.display.quality {
            QualityLevel::Auto => QualityLevel::Medium,
            chosen => chosen,
        };
        let roadside = LazyRoadside::new(map, scenario.seed, scenario.display.trees as usize);
        let static_scene = StaticScene::of_drive(map, scenario, &roadside);
        let renderer = Renderer::new(&gpu, &static_scene, OFFSCREEN, quality_for(quality, &gpu));
        Ok(Self { gpu, static_scene, renderer })
    }

    /// Draws the current moment, `size` pixels wide and high, each from 1 to [`MAX_SIDE`](super::MAX_SIDE).
    ///
    /// # Errors
    /// The device is lost while it draws.
    pub fn draw(&mut self, world: &World, kind: ViewKind, size: [u32; 2]) -> Result<image::RgbaImage, GpuError> {
        let mut view = scene::view(world.snapshot(), 1.0, kind, &view_options(world.scenario()), &self.static_scene);
        if kind.has_dial() {
            view.dial = Some(Speedometer::new(world).read(world.snapshot()));
        }
        render_to_image(&self.gpu, &mut self.renderer, &view, size)
    }
}
