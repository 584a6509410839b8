//! Textures to draw onto, those of a picture of the scene (light and depth), and buffers for uniforms. In: a size. Out: a render pass.

use super::{
    cost::CountedPass,
    pipeline::{DEPTH, HDR},
};

/// Creates a texture of `size` pixels, at least one, to draw onto, with this format and number of samples per pixel.
pub fn target(
    device: &wgpu::Device,
    label: &str,
    (format, sample_count): (wgpu::TextureFormat, u32),
    size: [u32; 2],
    usage: wgpu::TextureUsages,
) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size[0].max(1), height: size[1].max(1), depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Creates a buffer for uniforms of `size` bytes.
pub fn uniform_buffer(device: &wgpu::Device, label: &str, size: usize) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Textures that a picture is drawn into.
#[derive(Debug)]
pub struct RenderTargets {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Texture with several samples per pixel, if the quality asks for them.
    samples: Option<wgpu::TextureView>,
    /// Light with one sample per pixel.
    pub light: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl RenderTargets {
    /// Creates textures of `size` pixels.
    pub fn new(device: &wgpu::Device, label: &str, size: [u32; 2], samples: u32) -> Self {
        let texture = |format, samples, usage| target(device, label, (format, samples), size, usage);
        let nothing = wgpu::TextureUsages::empty();
        Self {
            size,
            samples: (samples > 1).then(|| texture(HDR, samples, nothing)),
            light: texture(HDR, 1, wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC),
            depth: texture(DEPTH, samples, nothing),
        }
    }

    /// Begins a picture on cleared textures.
    pub fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        stamps: Option<wgpu::RenderPassTimestampWrites>,
    ) -> CountedPass<'e> {
        let (view, resolve_target, store) = match &self.samples {
            Some(samples) => (samples, Some(&self.light), wgpu::StoreOp::Discard),
            None => (&self.light, None, wgpu::StoreOp::Store),
        };
        CountedPass::new(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes: stamps,
            ..Default::default()
        }))
    }
}
