//! Copies of a finished picture: one for the screen, a small one for the experimenter. In: a texture of a picture. Out:
//! another, of the same size or smaller, in one draw; nothing is read back, so nothing waits.

use crate::render::device::{
    pipeline::{PipelineBuilder, PipelineDesc},
    shader::ShaderSources,
    targets::target,
};

/// Copies pictures of one format.
#[derive(Debug)]
pub struct PreviewPass {
    format: wgpu::TextureFormat,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl PreviewPass {
    /// Creates a pass for source and target pictures of `format`.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("preview"),
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
            label: Some("preview"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let builder = PipelineBuilder { device, sources: &ShaderSources::built_in() };
        let pipeline = builder
            .pipeline(&PipelineDesc {
                program: "preview",
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

    /// Creates a texture of `size` pixels that can be drawn onto and copied from.
    pub fn canvas(&self, device: &wgpu::Device, size: [u32; 2]) -> wgpu::TextureView {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        target(device, "preview", (self.format, 1), size, usage)
    }

    /// Copies `from`, a view of [`Self::canvas`], to `to`: to all of it, or to its upper left part of this size; the
    /// rest is black.
    pub fn draw(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        from: &wgpu::TextureView,
        to: &wgpu::TextureView,
        part: Option<[u32; 2]>,
    ) {
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("preview"),
            layout: &self.layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(from) }],
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("preview"),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Gpu, OFFSCREEN, offscreen::read_back};

    /// Returns the copy on a canvas of `size` of a picture of 8 x 8 pixels, whose pixel (x, y) has red 16 x and green
    /// 16 y.
    fn drawn(size: [u32; 2], part: Option<[u32; 2]>) -> Vec<[u8; 4]> {
        let gpu = Gpu::shared().expect("a graphics adapter is needed");
        let side = wgpu::Extent3d { width: 8, height: 8, depth_or_array_layers: 1 };
        let source = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("source"),
            size: side,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: OFFSCREEN,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let bytes: Vec<u8> = (0..64u8).flat_map(|i| [16 * (i % 8), 16 * (i / 8), 0, 255]).collect();
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(32), rows_per_image: None };
        gpu.queue.write_texture(source.as_image_copy(), &bytes, layout, side);
        let pass = PreviewPass::new(&gpu.device, OFFSCREEN);
        let canvas = pass.canvas(&gpu.device, size);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let view = source.create_view(&wgpu::TextureViewDescriptor::default());
        pass.draw(&gpu.device, &mut encoder, &view, &canvas, part);
        gpu.queue.submit([encoder.finish()]);
        let bytes = read_back(gpu, canvas.texture(), 4).unwrap();
        bytes.chunks(4).map(|pixel| [pixel[0], pixel[1], pixel[2], pixel[3]]).collect()
    }

    #[test]
    fn at_the_same_size_every_pixel_stays_as_it_is() {
        let pixels = drawn([8, 8], None);
        for (i, pixel) in (0..64u8).zip(&pixels) {
            assert_eq!(*pixel, [16 * (i % 8), 16 * (i / 8), 0, 255], "pixel {i}");
        }
    }

    #[test]
    fn a_smaller_pixel_is_the_mean_of_its_block() {
        // Blocks of 4 x 2 pixels.
        let pixels = drawn([2, 4], None);
        assert_eq!(pixels[0], [24, 8, 0, 255]);
        assert_eq!(pixels[7], [88, 104, 0, 255]);
    }

    #[test]
    fn a_part_is_drawn_and_the_rest_is_black() {
        let pixels = drawn([8, 8], Some([8, 4]));
        assert_eq!(pixels[0], [0, 8, 0, 255]);
        assert_eq!(pixels[8 * 3 + 7], [112, 104, 0, 255]);
        assert!(pixels[8 * 4..].iter().all(|pixel| pixel[..3] == [0, 0, 0]));
    }
}
