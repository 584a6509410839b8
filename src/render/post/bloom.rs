//! Bloom: the small halo around lamps and glints. In: the main picture's light. Out: a texture an eighth of its size,
//! in two draws: the light brighter than paper in the sun, then its blur. The blur is stored in bytes as the square
//! root of its share of [`MOST`]; software rendering filters this in a third of the time that light takes.

use crate::render::device::{
    cost::{CountedPass, PassCost},
    pipeline::{HDR, PipelineBuilder, PipelineDesc},
    shader::ShaderFault,
    targets::target,
};

/// Reduction of the halo's texture against the picture.
const SMALLER: u32 = 8;
/// Strongest light in a halo, the unit of the stored share.
pub const MOST: f32 = 12.0;
/// Formats of the two textures.
const FORMATS: [wgpu::TextureFormat; 2] = [HDR, wgpu::TextureFormat::Rgba8Unorm];

/// The two pipelines; created anew when shaders are reloaded.
#[derive(Debug)]
pub struct BloomPipelines([wgpu::RenderPipeline; 2]);

/// The two draws and their textures.
#[derive(Debug)]
pub struct BloomPass {
    layout: wgpu::PipelineLayout,
    group_layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    /// Bright parts, and the halo.
    targets: [wgpu::TextureView; 2],
    groups: Option<[wgpu::BindGroup; 2]>,
}

impl BloomPass {
    /// Creates a pass that has no picture yet.
    pub fn new(device: &wgpu::Device) -> Self {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("bloom"),
            entries: &[
                entry(
                    0,
                    wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: true },
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    },
                ),
                entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
            ],
        });
        Self {
            layout: device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("bloom"),
                bind_group_layouts: &[Some(&group_layout)],
                immediate_size: 0,
            }),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("bloom"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            group_layout,
            targets: targets(device, [1, 1]),
            groups: None,
        }
    }

    /// Creates the pass's pipelines.
    ///
    /// # Errors
    /// A mistake in the shader.
    pub fn pipelines(&self, builder: &PipelineBuilder) -> Result<BloomPipelines, ShaderFault> {
        let small = PipelineDesc {
            program: "bloom",
            layout: &self.layout,
            buffers: &[],
            colour: Some((FORMATS[0], None)),
            depth: None,
            cull: None,
            writes: wgpu::ColorWrites::ALL,
            samples: 1,
            cut_out: false,
            constants: &[("MOST", MOST as f64)],
        };
        let blurred = PipelineDesc {
            colour: Some((FORMATS[1], None)),
            constants: &[("MOST", MOST as f64), ("BLUR", 1.0)],
            ..small.clone()
        };
        builder.pipelines([small, blurred]).map(BloomPipelines)
    }

    /// Fits the textures to a picture of `size` pixels.
    pub fn fit(&mut self, device: &wgpu::Device, light: &wgpu::TextureView, size: [u32; 2]) {
        self.targets = targets(device, size.map(|side| side.div_ceil(SMALLER)));
        self.groups = Some([light, &self.targets[0]].map(|view| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("bloom"),
                layout: &self.group_layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(view) },
                    wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&self.sampler) },
                ],
            })
        }));
    }

    /// Returns the halo, for the tone-mapping pass.
    pub fn halo(&self) -> &wgpu::TextureView {
        &self.targets[1]
    }

    /// Draws the halo; the timed tone-mapping pass begins here.
    pub fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        mut stamps: Option<wgpu::RenderPassTimestampWrites>,
        pipelines: &BloomPipelines,
    ) -> PassCost {
        let mut cost = PassCost::default();
        for (step, target) in self.targets.iter().enumerate() {
            let mut pass = CountedPass::new(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("bloom"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                timestamp_writes: stamps.take(),
                ..Default::default()
            }));
            pass.set_pipeline(&pipelines.0[step]);
            pass.set_bind_group(0, self.groups.as_ref().map(|groups| &groups[step]), &[]);
            pass.draw(0..3, 0..1);
            cost += pass.cost();
        }
        cost
    }
}

fn targets(device: &wgpu::Device, size: [u32; 2]) -> [wgpu::TextureView; 2] {
    FORMATS.map(|format| target(device, "bloom", (format, 1), size, wgpu::TextureUsages::TEXTURE_BINDING))
}
