//! A finished picture once more: onto the screen as it is, and small, for the experimenter. In: a texture of a picture.
//! Out: another, of the same size or smaller, in one draw; nothing is read back, nobody waits.

use super::{
    pipeline::{Recipe, Workshop},
    shader::Sources,
};

/// Copies pictures of one format.
#[derive(Debug)]
pub struct MiniaturePass {
    format: wgpu::TextureFormat,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl MiniaturePass {
    /// For pictures of `format`, from and to.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("miniature"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                count: None,
            }],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("miniature"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let mut workshop = Workshop { device, sources: &Sources::built_in(), made: 0 };
        let pipeline = workshop
            .pipeline(&Recipe {
                program: "miniature",
                layout: &pipeline_layout,
                buffers: &[],
                colour: Some((format, None)),
                depth: None,
                cull: None,
                writes: wgpu::ColorWrites::ALL,
                samples: 1,
                cut_out: false,
                constants: &[],
            })
            .unwrap_or_else(|e| panic!("the built-in shaders are tested: {e}"));
        Self { format, layout, pipeline }
    }

    /// A texture that can be drawn onto and copied from, of `size` pixels.
    pub fn canvas(&self, device: &wgpu::Device, size: [u32; 2]) -> wgpu::TextureView {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("miniature"),
            size: wgpu::Extent3d { width: size[0].max(1), height: size[1].max(1), depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// Puts `from`, a view of [`Self::canvas`], on `to`: on all of it, or on the upper left part of this size; the rest is
    /// black.
    pub fn draw(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        from: &wgpu::TextureView,
        to: &wgpu::TextureView,
        part: Option<[u32; 2]>,
    ) {
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("miniature"),
            layout: &self.layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(from) }],
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("miniature"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: to,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        if let Some([width, height]) = part {
            pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
        }
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}
