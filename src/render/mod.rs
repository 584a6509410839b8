//! The picture on the GPU. In: a [`StaticScene`] once, a [`View`] each frame. Out: pixels in a window's surface or in a
//! texture, by the same code.
//!
//! Five fixed passes: [`shadow`], [`scene_pass`] (main camera, then mirrors), [`post::tonemap`] (with [`post::bloom`]),
//! the [`dial`], and the experimenter's panel. `frame_plan` plans them, [`Renderer::draw`] runs them. Nothing is created while driving: buffers
//! grow only when a picture holds more cars than any before it, targets change with the window's size, pipelines with
//! the shaders, at nightfall and in rain.

mod auto_quality;
pub mod device;
mod device_times;
pub mod dial;
mod drive_pictures;
mod frame_plan;
mod headlamps;
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
pub mod wall_horizon;

pub use auto_quality::{keeps_rate, quality_for, renderer_that_keeps_up};
pub use device::cost::FrameCost;
pub use device::gpu::{Gpu, GpuError, MAX_SIDE};
pub use device::shader::ShaderFault;
pub use device::timing::PassTimes;
pub use device_times::device_times;
pub use drive_pictures::DrivePictures;
pub use offscreen::{OFFSCREEN, canvas, render_to_image, render_to_light, render_with_panel};
pub use quality::Quality;

use crate::scene::{StaticScene, View, ViewKind};
use crate::snapshot::TaskPicture;
use device::pipeline::PipelineBuilder;
use device::shader::ShaderSources;
use device::timing::{PassTimings, TimedPass};
use dial::DialPass;
use frame_plan::{FramePlan, ViewPass};
use headlamps::most_beams;
use materials::{MaterialPipelines, PipelineWeather};
use post::bloom::{BloomPass, BloomPipelines};
use post::tonemap::{ToneMapPass, ToneMapPipelines, ToneMappedFrame};
use post::ui_pass::{OverlayTarget, UiPass};
use scene_pass::{SceneBindings, SceneInputs, ScenePass};
use shadow::{ShadowPass, ShadowPipeline};
use sky::sky_pass::SkyPass;
use static_meshes::StaticMeshes;
use std::path::Path;

/// Directory of the shaders, relative to the working directory, for [`Renderer::reload_shaders`].
const SHADERS: &str = "shaders";

/// Draws views of one static scene.
#[derive(Debug)]
pub struct Renderer {
    meshes: StaticMeshes,
    quality: Quality,
    bindings: SceneBindings,
    sources: ShaderSources,
    pipelines: RenderPipelines,
    air: SkyPass,
    shadow: ShadowPass,
    /// Pictures of the main camera and the rear-view mirror; the left and right mirror are added when a frame first has them.
    pictures: Vec<ScenePass>,
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
    /// Light and weather that the materials are made for.
    weather: PipelineWeather,
    bloom: BloomPipelines,
    tonemap: ToneMapPipelines,
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
        let picture = |label| ScenePass::new(label, &meshes, &bindings, shadow.maps(), &air, &quality);
        let pictures = vec![picture("main"), picture("mirror")];
        let mut tonemap = ToneMapPass::new(device, format);
        let mut bloom = BloomPass::new(device);
        let [main, mirror] = [0, 1].map(|k: usize| pictures[k].light());
        bloom.fit(device, main, [1, 1]);
        tonemap.fit(device, main, [mirror; 3], bloom.halo(), [1, 1], quality.msaa == 1);
        let sources = ShaderSources::built_in();
        let builder = PipelineBuilder { device, sources: &sources };
        let pipelines = RenderPipelines::new(
            &builder,
            &bindings,
            &shadow,
            &bloom,
            &tonemap,
            (&quality, PipelineWeather::default()),
        )
        .unwrap_or_else(|e| panic!("the built-in shaders are tested: {e}"));
        let timing = PassTimings::new(device, &gpu.queue);
        let dial = DialPass::new(device, format);
        let panel = UiPass::new(device, format);
        let cost = FrameCost::default();
        Self {
            meshes,
            quality,
            bindings,
            sources,
            pipelines,
            air,
            shadow,
            pictures,
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
        let plan = FramePlan::new(view, size, &self.quality);
        self.fit(&plan, size);
        let Self {
            meshes,
            quality,
            bindings,
            sources,
            air,
            shadow,
            pictures,
            bloom,
            tonemap,
            dial,
            pipelines,
            timing,
            ..
        } = self;
        let (device, queue) = (&meshes.device, &meshes.queue);
        let sky = air.fit(queue, view);
        let are_lit = !view.headlamps.is_empty() && sky.shows_headlamps();
        let beams = if are_lit { most_beams(quality) } else { 0 };
        let weather = PipelineWeather { beams, is_wet: view.rain_mmph > 0.0 };
        pipelines.fit(&PipelineBuilder { device, sources }, bindings, quality, weather);
        let descriptor = wgpu::CommandEncoderDescriptor { label: Some("frame") };
        let mut encoder = device.create_command_encoder(&descriptor);
        let e = &mut encoder;
        let timed = timing.as_ref();
        let stamps = |pass, bounds| timed.and_then(|timing| timing.stamps(pass, bounds));

        let frustum = &plan.main().frustum;
        let (lights, drawn) = shadow.draw(e, timed, &pipelines.shadow, meshes, view, (sky.to_shining, frustum));
        let mut cost = FrameCost { shadow: drawn, ..FrameCost::default() };
        for (k, picture) in pictures.iter_mut().enumerate() {
            let Some(ViewPass { frustum, ego, hidden, timed, .. }) = &plan.passes[k] else { continue };
            let materials = &pipelines.materials;
            let scene = SceneInputs { materials, meshes, view, frustum, lights: &lights, sky, weather };
            let drawn = picture.draw(e, stamps(*timed, plan.bounds_time(k)), &scene, *ego, *hidden);
            *if *timed == TimedPass::Main { &mut cost.main } else { &mut cost.mirror } += drawn;
        }

        cost.tonemap = bloom.draw(e, stamps(TimedPass::ToneMap, [true, false]), &pipelines.bloom);
        let frame = ToneMappedFrame {
            target,
            size,
            exposure: if view.kind == ViewKind::Birdseye { sky.plan_exposure() } else { sky.exposure },
            alone: plan.alone,
            mirrors: plan.mirrors,
            smooth: quality.msaa == 1,
        };
        cost.tonemap += tonemap.draw(e, stamps(TimedPass::ToneMap, [false, true]), &pipelines.tonemap, queue, &frame);
        let has_dial = view.dial.is_some() || view.patch.is_some() || view.task != TaskPicture::None;
        if has_dial {
            dial.place = dial::DialPlace::of(view, size);
            dial.palette = view.palette;
            let stamps = stamps(TimedPass::Overlay, [true, panel.is_none()]);
            let overlay = OverlayTarget { device, queue, encoder: e, view: target, size, stamps };
            dial.draw(overlay, view.dial.as_ref(), view.task, view.patch);
        }
        if let Some(PanelOutput { ctx, output }) = panel {
            let stamps = stamps(TimedPass::Overlay, [!has_dial, true]);
            self.panel.draw(OverlayTarget { device, queue, encoder: e, view: target, size, stamps }, ctx, output);
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

    /// Fits the targets to a frame; creates the left and right mirror when a picture first has them.
    fn fit(&mut self, plan: &FramePlan, size: [u32; 2]) {
        let Self { meshes, quality, bindings, air, shadow, pictures, bloom, tonemap, .. } = self;
        let labels = ["left mirror", "right mirror"].into_iter().skip(pictures.len() - 2);
        pictures.extend(
            labels
                .filter(|_| plan.passes[3].is_some())
                .map(|label| ScenePass::new(label, meshes, bindings, shadow.maps(), air, quality)),
        );
        let mut stale = false;
        for (picture, pass) in pictures.iter_mut().zip(&plan.passes) {
            stale |= pass.as_ref().is_some_and(|pass| picture.fit(&meshes.device, pass.size));
        }
        if stale {
            let light = |k: usize| pictures.get(k).unwrap_or(&pictures[1]).light();
            let drawn = plan.main().size;
            bloom.fit(&meshes.device, light(0), drawn);
            let soften = quality.msaa == 1 && drawn == size;
            tonemap.fit(&meshes.device, light(0), [1, 2, 3].map(light), bloom.halo(), drawn, soften);
        }
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

    /// Takes the times on the device of the last picture, once [`Gpu::finish`] has returned; `None` without timestamps.
    pub fn take_pass_times(&mut self) -> Option<PassTimes> {
        self.timing.as_mut().and_then(PassTimings::take)
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
        let settings = (&self.quality, self.pipelines.weather);
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let builder = PipelineBuilder { device, sources: &sources };
        let made = RenderPipelines::new(&builder, &self.bindings, &self.shadow, &self.bloom, &self.tonemap, settings);
        let refused = pollster::block_on(scope.pop());
        let pipelines = made?;
        if let Some(error) = refused {
            return Err(ShaderFault::Refused { directory: directory.into(), words: error.to_string() });
        }
        self.pipelines = pipelines;
        self.sources = sources;
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
        (quality, weather): (&Quality, PipelineWeather),
    ) -> Result<Self, ShaderFault> {
        Ok(Self {
            shadow: shadow.pipeline(builder)?,
            materials: bindings.materials(builder, quality, weather)?,
            weather,
            bloom: bloom.pipelines(builder)?,
            tonemap: tonemap.pipelines(builder)?,
        })
    }

    /// Creates the materials anew if light or weather have changed, i.e. when a night begins or ends.
    fn fit(
        &mut self,
        builder: &PipelineBuilder,
        bindings: &SceneBindings,
        quality: &Quality,
        weather: PipelineWeather,
    ) {
        if weather != self.weather {
            let materials = bindings.materials(builder, quality, weather);
            self.materials = materials.unwrap_or_else(|e| panic!("the shaders in use are valid: {e}"));
            self.weather = weather;
        }
    }
}
