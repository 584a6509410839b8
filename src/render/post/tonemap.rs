//! Tone mapping, from light to a picture: tone curve, sRGB encoding, and placement of the mirrors in the main picture.
//! In: textures of light. Out: the target, a plain `Unorm` texture with sRGB values, as egui needs it.

use super::bloom;
use crate::{
    render::device::{
        cost::{CountedPass, CountedQueue, PassCost},
        layout::QuadUniform,
        pipeline::{PipelineBuilder, PipelineDesc},
        shader::ShaderFault,
        targets::{target, uniform_buffer},
    },
    scene::{Camera, Lens},
};
use glam::Vec4;

/// Width of the mirror inset as a share of the picture's width.
pub const MIRROR_WIDTH: f32 = 0.30;
/// Aspect ratio of the mirror inset, width over height.
pub const MIRROR_ASPECT: f32 = 3.4;
/// Share of a lamp's light that its halo adds.
const BLOOM: f32 = 0.30;
/// Gap above the mirror as a share of the picture's height.
const MIRROR_TOP: f32 = 0.02;

/// All pipelines; created anew when shaders are reloaded.
#[derive(Debug)]
pub struct ToneMapPipelines {
    picture: ToneMapVariants,
    mirror: ToneMapVariants,
    /// Smooths the edges of a tone-mapped picture.
    soften: wgpu::RenderPipeline,
}

/// Pipelines of a picture or a mirror, by the way they read its light.
#[derive(Debug)]
struct ToneMapVariants {
    plain: wgpu::RenderPipeline,
    /// Tone mapping with smoothed edges.
    smooth: wgpu::RenderPipeline,
    /// Before the edges are smoothed: the picture, or the flat mirror alone, is as large as its light.
    exact: wgpu::RenderPipeline,
}

impl ToneMapVariants {
    fn variant(&self, smooth: bool) -> &wgpu::RenderPipeline {
        if smooth { &self.smooth } else { &self.plain }
    }
}

/// Reach of edge smoothing (`edges.wgsl`) plus one pixel.
const SMOOTHED_PX: f32 = 4.0;

/// Glass of a mirror: the camera behind it, and the mapping of that camera's picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorGlass {
    /// Tangents of half the angles that a flat glass shows.
    tangents: [f32; 2],
    /// Curvature, see [`MirrorOptions::bend`](crate::scene::MirrorOptions::bend).
    bend: f32,
    /// Width of the drawn picture relative to a flat glass, as a ratio of tangents.
    widened: f32,
}

impl MirrorGlass {
    /// Returns the glass in front of `camera` in an inset of `aspect` (width / height).
    pub fn new(camera: &Camera, bend: f32, aspect: f32) -> Self {
        let Lens::Perspective { fov_x_rad } = camera.lens else {
            return Self { tangents: [1.0; 2], bend: 0.0, widened: 1.0 };
        };
        let x = (fov_x_rad / 2.0).tan();
        let tangents = [x, x / aspect];
        let widened = spread(x.hypot(x / aspect), bend);
        Self { tangents, bend, widened }
    }

    /// Returns the camera whose picture holds everything that the glass shows.
    pub fn behind(&self, camera: &Camera) -> Camera {
        match camera.lens {
            Lens::Perspective { .. } if self.bend > 0.0 => {
                let fov_x_rad = 2.0 * (self.tangents[0] * self.widened).atan();
                Camera { lens: Lens::Perspective { fov_x_rad }, ..*camera }
            }
            _ => *camera,
        }
    }

    fn uniform(&self) -> [f32; 4] {
        [self.tangents[0], self.tangents[1], self.bend, 1.0 / self.widened]
    }
}

/// Returns the ratio of an object's true to its apparent distance from the middle of a curved glass, both as tangents;
/// `tangent` is the apparent one. `tonemap.wgsl` has the same function.
fn spread(tangent: f32, bend: f32) -> f32 {
    if bend <= 0.0 || tangent <= 0.0 {
        return 1.0;
    }
    (tangent.atan() + 2.0 * (bend * tangent).min(1.0).asin()).min(1.5).tan() / tangent
}

/// Tone-mapping pass with its bindings.
#[derive(Debug)]
pub struct ToneMapPass {
    format: wgpu::TextureFormat,
    layout: wgpu::PipelineLayout,
    group_layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    main: TargetPicture,
    /// Rear-view mirror, and the mirrors on the doors.
    mirrors: [TargetPicture; 3],
    /// Tone-mapped picture before edge smoothing, as large as its light; `None` without that step.
    tone_mapped: Option<ToneMappedPicture>,
}

/// Frame to tone-map: the target, and what is placed on it.
pub struct ToneMappedFrame<'a> {
    /// Target of the whole picture.
    pub target: &'a wgpu::TextureView,
    /// Size of the target, pixels.
    pub size: [u32; 2],
    /// Factor on the light.
    pub exposure: f32,
    /// Glass of the mirror that is the whole picture, if one is.
    pub alone: Option<MirrorGlass>,
    /// Rear-view, left and right mirror.
    pub mirrors: [Option<FramedMirror>; 3],
    /// True to filter steps along edges.
    pub smooth: bool,
}

#[derive(Debug)]
struct ToneMappedPicture {
    view: wgpu::TextureView,
    size: [u32; 2],
    quad: TargetPicture,
}

/// One picture on the target.
#[derive(Debug)]
struct TargetPicture {
    uniform: wgpu::Buffer,
    group: Option<wgpu::BindGroup>,
}

/// A mirror's picture in its frame.
#[derive(Clone, Copy, Debug)]
pub struct FramedMirror {
    /// Glass of the mirror.
    pub glass: MirrorGlass,
    /// Place of the picture.
    pub place: MirrorPlace,
}

/// Place of a mirror's picture.
#[derive(Clone, Copy, Debug)]
pub enum MirrorPlace {
    /// At the top in the middle.
    Inset,
    /// In the world: its upper left, upper right and lower left corner in clip space, its width and height in pixels.
    InWorld([Vec4; 3], [f32; 2]),
}

/// Returns the uniform of a picture flat on a target of `canvas` pixels, at left, top, width and height.
fn placed([left, top, width, height]: [u32; 4], canvas: [u32; 2]) -> QuadUniform {
    let [right, down] = [2.0 / canvas[0] as f32, -2.0 / canvas[1] as f32];
    QuadUniform {
        size: [width as f32, height as f32],
        corner_clip: [left as f32 * right - 1.0, top as f32 * down + 1.0, 0.0, 1.0],
        right_clip: [right, 0.0, 0.0, 0.0],
        down_clip: [0.0, down, 0.0, 0.0],
        ..Default::default()
    }
}

/// Returns the uniform of a picture on a glass in the world. The radius of its corners is 0.28 of its height. Nothing
/// is in front of it, so no depth is needed.
fn in_world([corner, right, down]: [Vec4; 3], [width, height]: [f32; 2], border: f32) -> QuadUniform {
    let flat = |v: Vec4| v.with_z(0.0).to_array();
    QuadUniform {
        size: [width, height],
        border: 0.5 * border,
        corner: 0.28 * height,
        corner_clip: flat(corner),
        right_clip: flat((right - corner) / width),
        down_clip: flat((down - corner) / height),
        ..Default::default()
    }
}

/// Returns left, top, width and height of the mirror inset in a picture of `size`, pixels.
pub fn mirror_rect(size: [u32; 2]) -> [u32; 4] {
    let width = (size[0] as f32 * MIRROR_WIDTH).round().max(2.0);
    let height = (width / MIRROR_ASPECT).round().max(1.0);
    // An equal number of columns on both sides, so that the inset is centred to the pixel.
    let width = width as u32 + (size[0] + width as u32) % 2;
    [(size[0].saturating_sub(width)) / 2, (size[1] as f32 * MIRROR_TOP).round() as u32, width, height as u32]
}

/// Returns left, top, width and height of the area hidden by the inset, in a picture drawn at `drawn` and shown at
/// `size` pixels. It excludes the inset's round corners, and the pixels beside it that edge smoothing or upscaling
/// reads.
pub fn hidden_by_mirror(size: [u32; 2], drawn: [u32; 2]) -> Option<[u32; 4]> {
    let scale = [0, 1].map(|i| drawn[i] as f32 / size[i].max(1) as f32);
    let [left, top, width, height] = mirror_rect(size).map(|v| v as f32);
    // In a round corner of radius 1, the square inside the rounding starts at 0.29.
    let corner = 0.3 * corner_px(size);
    let free = |low: f32, length: f32, scale: f32| {
        let first = ((low + corner) * scale).ceil() + SMOOTHED_PX;
        let end = ((low + length - corner) * scale).floor() - SMOOTHED_PX;
        (end > first).then_some((first as u32, (end - first) as u32))
    };
    let ((left, width), (top, height)) = (free(left, width, scale[0])?, free(top, height, scale[1])?);
    Some([left, top, width, height])
}

/// Returns the radius of the inset's corners, pixels.
fn corner_px(size: [u32; 2]) -> f32 {
    size[1] as f32 / 38.0
}

fn quad(device: &wgpu::Device) -> TargetPicture {
    TargetPicture { uniform: uniform_buffer(device, "quad", size_of::<QuadUniform>()), group: None }
}

impl ToneMapPass {
    /// Creates a pass onto targets of `format`.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let picture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("tonemap"),
            entries: &[
                entry(
                    0,
                    wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                ),
                entry(1, picture),
                entry(2, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
                entry(3, picture),
            ],
        });
        Self {
            format,
            layout: device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("tonemap"),
                bind_group_layouts: &[Some(&group_layout)],
                immediate_size: 0,
            }),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("light"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            group_layout,
            main: quad(device),
            mirrors: [(); 3].map(|()| quad(device)),
            tone_mapped: None,
        }
    }

    /// Creates the pass's pipelines.
    ///
    /// # Errors
    /// A mistake in the shader.
    pub fn pipelines(&self, builder: &PipelineBuilder) -> Result<ToneMapPipelines, ShaderFault> {
        let picture = PipelineDesc {
            program: "tonemap",
            layout: &self.layout,
            buffers: &[],
            colour: Some((self.format, None)),
            depth: None,
            cull: None,
            writes: wgpu::ColorWrites::ALL,
            samples: 1,
            cut_out: false,
            constants: &[],
        };
        let mirror = PipelineDesc {
            constants: &[("MIRROR", 1.0)],
            // The corners of a mirror are round.
            colour: Some((self.format, Some(wgpu::BlendState::ALPHA_BLENDING))),
            ..picture.clone()
        };
        let soften = PipelineDesc { program: "soften", ..picture.clone() };
        let smooth = PipelineDesc { constants: &[("SMOOTH", 1.0)], ..picture.clone() };
        let smooth_mirror = PipelineDesc { constants: &[("MIRROR", 1.0), ("SMOOTH", 1.0)], ..mirror.clone() };
        let exact = PipelineDesc { constants: &[("EXACT", 1.0)], ..picture.clone() };
        let exact_mirror = PipelineDesc { constants: &[("MIRROR", 1.0), ("EXACT", 1.0)], ..picture.clone() };
        let pictures = [picture, smooth, exact, mirror, smooth_mirror, exact_mirror, soften];
        let [plain, smooth, exact, plain_mirror, smooth_mirror, exact_mirror, soften] = builder.pipelines(pictures)?;
        Ok(ToneMapPipelines {
            picture: ToneMapVariants { plain, smooth, exact },
            mirror: ToneMapVariants { plain: plain_mirror, smooth: smooth_mirror, exact: exact_mirror },
            soften,
        })
    }

    /// Sets new textures of the pictures; the main one has `size` pixels. With `soften`, edges of the main picture are
    /// smoothed after tone mapping. That is for a picture that is not upscaled: in an upscaled one, mixing light keeps
    /// objects in their places, mixing screen values does not.
    pub fn fit(
        &mut self,
        device: &wgpu::Device,
        main: &wgpu::TextureView,
        mirrors: [&wgpu::TextureView; 3],
        halo: &wgpu::TextureView,
        size: [u32; 2],
        soften: bool,
    ) {
        let group = |uniform: &wgpu::Buffer, light: &wgpu::TextureView| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("tonemap"),
                layout: &self.group_layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(light) },
                    wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(&self.sampler) },
                    wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(halo) },
                ],
            })
        };
        self.main.group = Some(group(&self.main.uniform, main));
        for (quad, light) in self.mirrors.iter_mut().zip(mirrors) {
            quad.group = Some(group(&quad.uniform, light));
        }
        self.tone_mapped = soften.then(|| {
            let usage = wgpu::TextureUsages::TEXTURE_BINDING;
            let view = target(device, "tone mapped", (self.format, 1), size, usage);
            let quad = quad(device);
            let group = Some(group(&quad.uniform, &view));
            ToneMappedPicture { view, size, quad: TargetPicture { group, ..quad } }
        });
    }

    /// Tone-maps the main picture onto the whole target, and the mirrors' pictures into their places.
    pub fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stamps: Option<wgpu::RenderPassTimestampWrites>,
        pipelines: &ToneMapPipelines,
        queue: &CountedQueue,
        frame: &ToneMappedFrame,
    ) -> PassCost {
        self.write_uniforms(queue, frame);
        let ToneMappedFrame { target, alone, mirrors, smooth, .. } = *frame;
        let kind = if alone.is_some() { &pipelines.mirror } else { &pipelines.picture };
        let is_exact = self.tone_mapped.is_some() && alone.is_none_or(|glass| glass.bend <= 0.0);
        let main = match is_exact {
            true => &kind.exact,
            false => kind.variant(smooth && self.tone_mapped.is_none()),
        };
        let main = (&self.main, main);
        let mut cost = PassCost::default();
        let onto_target = match &self.tone_mapped {
            None => main,
            Some(tone_mapped) => {
                cost += composite(encoder, None, &tone_mapped.view, &[Some(main)]);
                (&tone_mapped.quad, &pipelines.soften)
            }
        };
        let mirror = |k: usize| mirrors[k].map(|_| (&self.mirrors[k], pipelines.mirror.variant(smooth)));
        cost + composite(encoder, stamps, target, &[Some(onto_target), mirror(0), mirror(1), mirror(2)])
    }

    fn write_uniforms(&self, queue: &CountedQueue, frame: &ToneMappedFrame) {
        let ToneMappedFrame { size, exposure, alone, .. } = *frame;
        let write = |quad: &TargetPicture, uniform: QuadUniform| {
            queue.write_buffer(&quad.uniform, 0, bytemuck::bytes_of(&uniform));
        };
        let whole = |size: [u32; 2]| placed([0, 0, size[0], size[1]], size);
        let main = QuadUniform {
            lens: alone.map_or([0.0; 4], |glass| glass.uniform()),
            flip: f32::from(u8::from(alone.is_some())),
            exposure,
            // Lamps dazzle no more at night than in the evening: a screen is not so bright.
            bloom: BLOOM * bloom::MOST * exposure.min(6.0),
            soften: f32::from(u8::from(self.tone_mapped.is_some())),
            ..whole(self.tone_mapped.as_ref().map_or(size, |tone_mapped| tone_mapped.size))
        };
        write(&self.main, main);
        let border = (size[1] as f32 / 200.0).max(1.0);
        for (quad, framed) in self.mirrors.iter().zip(frame.mirrors) {
            let Some(FramedMirror { glass, place }) = framed else { continue };
            let placed = match place {
                MirrorPlace::Inset => {
                    QuadUniform { border, corner: corner_px(size), ..placed(mirror_rect(size), size) }
                }
                MirrorPlace::InWorld(corners, glass_px) => in_world(corners, glass_px, border),
            };
            write(quad, QuadUniform { flip: 1.0, exposure, lens: glass.uniform(), ..placed });
        }
        if let Some(tone_mapped) = &self.tone_mapped {
            write(&tone_mapped.quad, whole(size));
        }
    }
}

/// Draws pictures onto a target in one pass, each with its pipeline.
fn composite(
    encoder: &mut wgpu::CommandEncoder,
    stamps: Option<wgpu::RenderPassTimestampWrites>,
    target: &wgpu::TextureView,
    quads: &[Option<(&TargetPicture, &wgpu::RenderPipeline)>],
) -> PassCost {
    let mut pass = CountedPass::new(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("tonemap"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        })],
        timestamp_writes: stamps,
        ..Default::default()
    }));
    for (quad, pipeline) in quads.iter().flatten() {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, quad.group.as_ref(), &[]);
        pass.draw(0..6, 0..1);
    }
    pass.cost()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_convex_mirror_shows_more_but_smaller_and_a_flat_one_is_unchanged() {
        let camera = |degrees: f32| Camera {
            eye: Vec3::ZERO,
            forward: Vec3::X,
            up: Vec3::Z,
            lens: Lens::Perspective { fov_x_rad: degrees.to_radians() },
        };
        let flat = MirrorGlass::new(&camera(30.0), 0.0, 3.4);
        assert_eq!((flat.widened, flat.behind(&camera(30.0))), (1.0, camera(30.0)));
        let mut before = 1.0;
        for bend in [0.02, 0.1, 0.25, 0.5] {
            let glass = MirrorGlass::new(&camera(30.0), bend, 3.4);
            assert!(glass.widened > before, "{bend}: {}", glass.widened);
            before = glass.widened;
            // Near the axis: 1 + 2 d / R, the reduction of distant objects by a convex mirror.
            assert!((spread(1e-3, bend) - (1.0 + 2.0 * bend)).abs() < 1e-3);
        }
        // The widest glass that the settings allow still shows less than a half space.
        for aspect in [1.0, 16.0 / 9.0, 3.4] {
            let widest = MirrorGlass::new(&camera(60.0), 0.42 / 0.8, aspect);
            let Lens::Perspective { fov_x_rad } = widest.behind(&camera(60.0)).lens else { panic!("a perspective") };
            assert!(fov_x_rad.to_degrees() < 172.0, "{}", fov_x_rad.to_degrees());
        }
    }

    #[test]
    fn the_mirror_is_at_the_top_in_the_middle() {
        for size in [[160, 90], [320, 180], [640, 360], [1280, 720], [1921, 1080]] {
            let [left, top, width, height] = mirror_rect(size);
            assert_eq!(2 * left + width, size[0], "{size:?}");
            assert!(top + height < size[1] / 4, "{size:?}");
            assert!((width as f32 / size[0] as f32 - MIRROR_WIDTH).abs() < 0.02, "{size:?}");
            let hidden = hidden_by_mirror(size, size);
            assert!(hidden.is_some() || size[1] < 180, "{size:?}");
            let Some([x, y, wide, high]) = hidden else { continue };
            assert!(x >= left + 4 && y >= top + 4, "{size:?}");
            assert!(x + wide + 4 <= left + width && y + high + 4 <= top + height, "{size:?}");
            assert!(2 * x + wide == size[0], "{size:?}: {x} {wide}");
            assert!(3 * wide * high > 2 * width * height || size[1] < 720, "{size:?}: {wide} x {high}");
        }
    }
}
