//! The picture on the GPU. In: a [`StaticScene`] once, a [`View`] each frame. Out: pixels in a window's surface or in a
//! texture, by the same code.
//!
//! Five fixed passes: [`shadow`], [`scene_pass`] (main camera, then mirrors), [`post::tonemap`] (with [`post::bloom`]),
//! the [`dial`], and the experimenter's panel. [`Renderer::draw`] runs them. Nothing is created while driving: buffers
//! grow only when a picture holds more cars than any before it, targets change with the window's size, pipelines with
//! the shaders.

mod auto_quality;
pub mod device;
pub mod dial;
mod drive_pictures;
pub mod instances;
pub mod level_of_detail;
pub mod materials;
pub mod models;
pub mod offscreen;
pub mod post;
pub mod quality;
pub mod scene_pass;
pub mod shadow;
pub mod sky;
pub mod static_meshes;
pub mod textures;
pub mod view_projection;

pub use auto_quality::{quality_for, renderer_that_keeps_up};
pub use device::cost::FrameCost;
pub use device::gpu::{Gpu, GpuError};
pub use device::shader::ShaderFault;
pub use device::timing::PassTimes;
pub use drive_pictures::{DrivePictures, MAX_SIDE};
pub use offscreen::{OFFSCREEN, canvas, render_to_image, render_to_light, render_with_panel};
pub use quality::Quality;

use crate::scene::{Camera, MirrorPane, StaticScene, View, ViewKind};
use device::pipeline::PipelineBuilder;
use device::shader::ShaderSources;
use device::timing::{self, PassTimings, TimedPass};
use dial::DialPass;
use materials::MaterialPipelines;
use post::bloom::{BloomPass, BloomPipelines};
use post::tonemap::{self, FramedMirror, MirrorGlass, MirrorPlace, ToneMapPass, ToneMapPipeline, mirror_rect};
use post::ui_pass::{OverlayTarget, UiPass};
use scene_pass::{EgoVisibility, SceneBindings, SceneInputs, ScenePass};
use shadow::{ShadowPass, ShadowPipeline};
use sky::sky_pass::SkyPass;
use static_meshes::StaticMeshes;
use std::path::Path;
use view_projection::ViewFrustum;

/// Directory of the shaders, relative to the working directory, for [`Renderer::reload_shaders`].
const SHADERS: &str = "shaders";

/// Draws views of one static scene.
#[derive(Debug)]
pub struct Renderer {
    meshes: StaticMeshes,
    quality: Quality,
    bindings: SceneBindings,
    pipelines: RenderPipelines,
    air: SkyPass,
    shadow: ShadowPass,
    main: ScenePass,
    /// Rear-view mirror; the left and right mirrors are created when a picture first has them.
    mirror: ScenePass,
    sides: Option<[ScenePass; 2]>,
    bloom: BloomPass,
    tonemap: ToneMapPass,
    dial: DialPass,
    panel: UiPass,
    timing: Option<PassTimings>,
    cost: FrameCost,
}

/// Output of the experimenter's panel for one frame, drawn over the picture.
pub struct PanelOutput<'a> {
    /// Context of the panel, the same one for the life of the renderer.
    pub ctx: &'a egui::Context,
    /// Output of the context for this frame.
    pub output: egui::FullOutput,
}

/// All pipelines, replaced together or not at all.
#[derive(Debug)]
struct RenderPipelines {
    shadow: ShadowPipeline,
    materials: MaterialPipelines,
    bloom: BloomPipelines,
    tonemap: ToneMapPipeline,
}

impl Renderer {
    /// Creates a renderer of `static_scene` onto targets of `format`: a `Unorm` format that is not sRGB (`Bgra8Unorm` of a
    /// surface, [`OFFSCREEN`]), because the shader encodes.
    pub fn new(gpu: &Gpu, static_scene: &StaticScene, format: wgpu::TextureFormat, quality: Quality) -> Self {
        // Mesa's software sampler takes minutes for one anisotropic picture of a long road.
        let quality = if gpu.is_software() { Quality { anisotropy: 1, ..quality } } else { quality };
        let device = &gpu.device;
        let meshes = StaticMeshes::new(gpu, static_scene);
        let bindings = SceneBindings::new(device, &quality);
        let shadow = ShadowPass::new(device, &meshes, &quality);
        // A quarter of the shadows' resolution: 256 to 768 texels, painted in a fraction of a second.
        let air = SkyPass::new(device, quality.shadow_size / 4);
        let main = ScenePass::new("main", &meshes, &bindings, shadow.maps(), &air, &quality);
        let mirror = ScenePass::new("mirror", &meshes, &bindings, shadow.maps(), &air, &quality);
        let mut tonemap = ToneMapPass::new(device, format);
        let mut bloom = BloomPass::new(device);
        bloom.fit(device, main.light(), [1, 1]);
        tonemap.fit(device, main.light(), [mirror.light(); 3], bloom.halo(), [1, 1], quality.msaa == 1);
        let builder = PipelineBuilder { device, sources: &ShaderSources::built_in() };
        let pipelines = RenderPipelines::new(&builder, &bindings, &shadow, &bloom, &tonemap, &quality)
            .unwrap_or_else(|e| panic!("the built-in shaders are tested: {e}"));
        let timing = PassTimings::new(device, &gpu.queue);
        let dial = DialPass::new(device, format);
        let panel = UiPass::new(device, format);
        let cost = FrameCost::default();
        Self {
            meshes,
            quality,
            bindings,
            pipelines,
            air,
            shadow,
            main,
            mirror,
            sides: None,
            bloom,
            tonemap,
            dial,
            panel,
            timing,
            cost,
        }
    }

    /// Draws `view`, and over it the panel if there is one, onto `target`, which is `size` pixels large.
    pub fn draw(&mut self, view: &View, panel: Option<PanelOutput>, target: &wgpu::TextureView, size: [u32; 2]) {
        let Self { meshes, air, shadow, main, mirror, sides, bloom, tonemap, dial, pipelines, timing, .. } = self;
        let (device, queue) = (&meshes.device, &meshes.queue);
        let mirror_size = mirror_rect(size);
        let scale = |side: u32| ((side as f32 * self.quality.mirror_scale).round() as u32).max(1);
        let mut inset = [scale(mirror_size[2]), scale(mirror_size[3])];
        // In the mirror view the mirror is the whole picture.
        let alone = view.kind == ViewKind::Mirror;
        let drawn = self.quality.drawn_size(size, alone);
        let smooth = self.quality.msaa == 1;
        let panes = view.seat.and_then(|seat| seat.mirrors).filter(|_| !alone);
        let glass_px = |pane: &MirrorPane| [1.0, pane.aspect].map(|over| pane.width_share * size[0] as f32 / over);
        let pane_px = |pane: &MirrorPane| glass_px(pane).map(|side| scale(side.round() as u32));
        if let Some([rear, ..]) = &panes {
            inset = pane_px(rear);
            sides.get_or_insert_with(|| {
                ["left mirror", "right mirror"]
                    .map(|label| ScenePass::new(label, meshes, &self.bindings, shadow.maps(), air, &self.quality))
            });
        }
        let mut stale = main.fit(device, drawn) | mirror.fit(device, inset);
        for (side, pane) in sides.iter_mut().flatten().zip(panes.iter().flat_map(|panes| &panes[1..])) {
            stale |= side.fit(device, pane_px(pane));
        }
        if stale {
            bloom.fit(device, main.light(), drawn);
            let [left, right] =
                sides.as_ref().map_or([mirror.light(); 2], |sides| sides.each_ref().map(ScenePass::light));
            let mirrors = [mirror.light(), left, right];
            tonemap.fit(device, main.light(), mirrors, bloom.halo(), drawn, smooth && drawn == size);
        }

        let camera = if alone { view.mirror.as_ref().unwrap_or(&view.camera) } else { &view.camera };
        let aspect = |[width, height]: [u32; 2]| width as f32 / height.max(1) as f32;
        let glass = |camera: &Camera, size| MirrorGlass::new(camera, view.mirror_bend, aspect(size));
        let whole = alone.then(|| glass(camera, size));
        let frustum = ViewFrustum::new(&whole.map_or(*camera, |whole| whole.behind(camera)), size);
        let back = view.mirror.as_ref().filter(|_| !alone);
        let framed = back.map(|camera| glass(camera, inset));
        let from_outside = matches!(view.kind, ViewKind::Birdseye | ViewKind::Chase);
        let ego = if from_outside { EgoVisibility::Outside } else { EgoVisibility::Inside };

        let descriptor = wgpu::CommandEncoderDescriptor { label: Some("frame") };
        let mut encoder = device.create_command_encoder(&descriptor);
        let e = &mut encoder;
        let timed = timing.as_ref();
        let stamps = |pass| timed.map(|timing| timing.stamps(pass));
        let mut cost = FrameCost::default();
        let lights;
        (lights, cost.shadow) = shadow.draw(e, stamps(TimedPass::Shadow), &pipelines.shadow, meshes, view, &frustum);
        let hidden = back.filter(|_| panes.is_none()).and_then(|_| tonemap::hidden_by_mirror(size, drawn));
        let scene = SceneInputs { materials: &pipelines.materials, meshes, view, frustum: &frustum, lights: &lights };
        cost.main = main.draw(e, stamps(TimedPass::Main), &scene, ego, hidden);
        if let (Some(camera), Some(glass)) = (back, framed) {
            let frustum = ViewFrustum::new(&glass.behind(camera), inset);
            let whole = stamps(TimedPass::Mirror);
            let stamps = if panes.is_some() { whole.as_ref().map(timing::begin_only) } else { whole };
            let scene = SceneInputs { frustum: &frustum, ..scene };
            cost.mirror = mirror.draw(e, stamps, &scene, EgoVisibility::Nowhere, None);
        }
        let mut framed = [framed.map(|glass| FramedMirror { glass, lies: MirrorPlace::Inset }), None, None];
        if let Some(panes) = &panes {
            let clip = camera.view_proj(aspect(size));
            framed = panes.each_ref().map(|pane| {
                let lies = MirrorPlace::InWorld(pane.corners.map(|corner| clip * corner.extend(1.0)), glass_px(pane));
                Some(FramedMirror { glass: MirrorGlass::new(&pane.camera, pane.bend, pane.aspect), lies })
            });
            for ((side, pane), framed) in sides.iter_mut().flatten().zip(&panes[1..]).zip(framed[1..].iter().flatten())
            {
                let frustum = ViewFrustum::new(&framed.glass.behind(&pane.camera), pane_px(pane));
                // The right mirror is the last pass of the mirrors. Both door mirrors show the ego's flank at the edge.
                let last = std::ptr::eq(pane, &panes[2]).then(|| stamps(TimedPass::Mirror)).flatten();
                let stamps = last.as_ref().map(timing::end_only);
                let scene = SceneInputs { frustum: &frustum, ..scene };
                cost.mirror += side.draw(e, stamps, &scene, EgoVisibility::Outside, None);
            }
        }
        let stamp = stamps(TimedPass::ToneMap);
        let sky = air.fit(queue, view.to_sun, view.visibility_m);
        let exposure = if view.kind == ViewKind::Birdseye { sky.plan_exposure() } else { sky.exposure };
        cost.tonemap = bloom.draw(e, stamp.as_ref(), &pipelines.bloom);
        cost.tonemap += tonemap.draw(
            e,
            stamp.as_ref().map(timing::end_only),
            &pipelines.tonemap,
            queue,
            target,
            size,
            exposure,
            whole,
            framed,
            smooth,
        );
        if view.dial.is_some() || view.patch.is_some() {
            dial.place = dial::DialPlace::of(view, size);
            dial.palette = view.palette;
            let overlay = OverlayTarget { device, queue, encoder: e, view: target, size };
            dial.draw(overlay, view.dial.as_ref(), view.patch);
        }
        if let Some(PanelOutput { ctx, output }) = panel {
            self.panel.draw(OverlayTarget { device, queue, encoder: e, view: target, size }, ctx, output);
        }
        if let Some(timing) = timing {
            timing.collect(e);
        }
        queue.submit([encoder.finish()]);
        cost.uploaded_bytes = queue.take_bytes();
        for (drawn, bytes) in [dial.take_cost(), self.panel.take_cost()] {
            cost.overlay += drawn;
            cost.uploaded_bytes += bytes;
        }
        self.cost = cost;
    }

    /// Returns the cost of the last picture.
    pub fn cost(&self) -> FrameCost {
        self.cost
    }

    /// Returns the time of each pass on the device, a few frames ago; `None` without timestamps or before the first
    /// result.
    pub fn pass_times(&self) -> Option<PassTimes> {
        self.timing.as_ref().and_then(PassTimings::latest)
    }

    /// Reloads the shaders from the directory `shaders`; if one is faulty, all stay as they were.
    ///
    /// # Errors
    /// `shaders/FILE.wgsl:LINE: message`.
    pub fn reload_shaders(&mut self) -> Result<(), ShaderFault> {
        self.reload_shaders_from(Path::new(SHADERS))
    }

    /// Reloads the shaders as [`Renderer::reload_shaders`], from another directory.
    ///
    /// # Errors
    /// As there.
    pub fn reload_shaders_from(&mut self, directory: &Path) -> Result<(), ShaderFault> {
        let sources = ShaderSources::from_directory(directory)?;
        let device = &self.meshes.device;
        // Catches errors that naga does not find: a missing entry point, a binding of another type.
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let builder = PipelineBuilder { device, sources: &sources };
        let made =
            RenderPipelines::new(&builder, &self.bindings, &self.shadow, &self.bloom, &self.tonemap, &self.quality);
        let refused = pollster::block_on(scope.pop());
        let pipelines = made?;
        if let Some(error) = refused {
            return Err(ShaderFault::Refused { directory: directory.into(), words: error.to_string() });
        }
        self.pipelines = pipelines;
        self.shadow.forget();
        Ok(())
    }
}

impl RenderPipelines {
    fn new(
        builder: &PipelineBuilder,
        bindings: &SceneBindings,
        shadow: &ShadowPass,
        bloom: &BloomPass,
        tonemap: &ToneMapPass,
        quality: &Quality,
    ) -> Result<Self, ShaderFault> {
        Ok(Self {
            shadow: shadow.pipeline(builder)?,
            materials: bindings.materials(builder, quality)?,
            bloom: bloom.pipelines(builder)?,
            tonemap: tonemap.pipeline(builder)?,
        })
    }
}
