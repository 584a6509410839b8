//! Pictures of a replay without a window. In: a [`Replay`] at some tick. Out: the picture of one view.

use super::Replay;
use crate::{
    drive_loop::RunError,
    hud::Speedometer,
    render::{Gpu, OFFSCREEN, Renderer, quality_for, render_to_image},
    scenario::QualityLevel,
    scene::{self, StaticScene, ViewKind, view_options},
};

/// Off-screen renderer of a replay.
pub struct ReplayRenderer {
    gpu: Gpu,
    static_scene: StaticScene,
    renderer: Renderer,
    instruments: Speedometer,
    kind: ViewKind,
    size: [u32; 2],
}

impl ReplayRenderer {
    /// Makes a renderer for one view at one size, in the scenario's quality; `auto` becomes medium, since speed does not matter
    /// here.
    ///
    /// # Errors
    /// There is no graphics adapter.
    pub fn new(replay: &Replay, kind: ViewKind, size: [u32; 2]) -> Result<Self, RunError> {
        let world = replay.world();
        let gpu = Gpu::headless()?;
        let static_scene = StaticScene::of_drive(world.map(), world.scenario(), world.drive().roadside());
        let level = match world.scenario().display.quality {
            QualityLevel::Auto => QualityLevel::Medium,
            level => level,
        };
        let renderer = Renderer::new(&gpu, &static_scene, OFFSCREEN, quality_for(level, &gpu));
        let instruments = Speedometer::new(world);
        Ok(Self { gpu, static_scene, renderer, instruments, kind, size })
    }

    /// Draws the present tick.
    ///
    /// # Errors
    /// The graphics device is lost.
    pub fn draw(&mut self, replay: &Replay) -> Result<image::RgbaImage, RunError> {
        let world = replay.world();
        let options = view_options(world.scenario());
        let mut view = scene::view(world.snapshot(), 1.0, self.kind, &options, &self.static_scene);
        view.dial = self.kind.has_dial().then(|| self.instruments.read(world.snapshot()));
        Ok(render_to_image(&self.gpu, &mut self.renderer, &view, self.size)?)
    }
}
