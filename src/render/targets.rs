//! What a picture of the scene is drawn into: light and depth. In: a size. Out: render passes, one a picture or, where the
//! processor draws, [`PARTS`] of them.

use super::pipeline::{DEPTH, HDR};

/// Passes of a picture that is drawn in parts.
pub const PARTS: usize = 4;

/// Textures that a picture is drawn into.
#[derive(Debug)]
pub struct Targets {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// With several samples a pixel, if the quality asks for them.
    samples: Option<wgpu::TextureView>,
    /// One sample a pixel.
    pub light: wgpu::TextureView,
    depth: wgpu::TextureView,
    /// Where the processor draws, light and depth once more: it sets up the triangles of a pass on one core and fills them
    /// on all when the pass ends, and a pass with another view of the same textures is another one. So the corners of one
    /// part of the picture are worked out while the part before it is filled.
    again: Option<[wgpu::TextureView; 2]>,
}

impl Targets {
    /// Textures of `size` pixels; `software` if the processor draws.
    pub fn new(device: &wgpu::Device, label: &str, size: [u32; 2], samples: u32, software: bool) -> Self {
        let view_of = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let texture = |format, sample_count, usage| {
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
            view_of(&texture)
        };
        let nothing = wgpu::TextureUsages::empty();
        let light = texture(HDR, 1, wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC);
        let depth = texture(DEPTH, samples, nothing);
        Self {
            size,
            samples: (samples > 1).then(|| texture(HDR, samples, nothing)),
            again: (software && samples == 1).then(|| [&light, &depth].map(|view| view_of(view.texture()))),
            light,
            depth,
        }
    }

    /// True if a picture is drawn in [`PARTS`] passes rather than in one.
    pub fn in_parts(&self) -> bool {
        self.again.is_some()
    }

    /// Begins a part of the picture, the first one on clear textures.
    pub fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        part: usize,
        stamps: Option<wgpu::RenderPassTimestampWrites>,
    ) -> wgpu::RenderPass<'e> {
        let [light, depth] = match &self.again {
            Some([light, depth]) if part % 2 == 1 => [light, depth],
            _ => [&self.light, &self.depth],
        };
        let (view, resolve_target, store) = match &self.samples {
            Some(samples) => (samples, Some(light), wgpu::StoreOp::Discard),
            None => (light, None, wgpu::StoreOp::Store),
        };
        let first = part == 0;
        let kept = if self.in_parts() && part + 1 < PARTS { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations {
                    load: if first { wgpu::LoadOp::Clear(wgpu::Color::BLACK) } else { wgpu::LoadOp::Load },
                    store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(wgpu::Operations {
                    load: if first { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load },
                    store: kept,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: stamps,
            ..Default::default()
        })
    }
}
