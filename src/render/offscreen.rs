//! A picture without a window: the same [`Renderer::draw`], into a texture that is read back. In: a view and a size.
//! Out: an image. For this the renderer has to be made with [`OFFSCREEN`] as its format.

use super::{
    Panel, Renderer,
    gpu::{Gpu, GpuError},
};
use crate::scene::View;

/// Format of pictures that are read back.
pub const OFFSCREEN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Draws `view` at `size` pixels and reads the picture back.
///
/// # Errors
/// If the device is lost while it draws.
pub fn render_to_image(
    gpu: &Gpu,
    renderer: &mut Renderer,
    view: &View,
    size: [u32; 2],
) -> Result<image::RgbaImage, GpuError> {
    render_with_panel(gpu, renderer, view, None, size)
}

/// The same with the experimenter's panel over it.
///
/// # Errors
/// As [`render_to_image`].
pub fn render_with_panel(
    gpu: &Gpu,
    renderer: &mut Renderer,
    view: &View,
    panel: Option<Panel>,
    size: [u32; 2],
) -> Result<image::RgbaImage, GpuError> {
    let [width, height] = size;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("off-screen"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: OFFSCREEN,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let target = texture.create_view(&wgpu::TextureViewDescriptor::default());
    renderer.draw(view, panel, &target, size);

    let row = width * 4;
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: u64::from(padded) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read back") });
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None },
        },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| ());
    let lost = |e: String| GpuError::Lost(e);
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| lost(e.to_string()))?;
    let mapped = buffer.get_mapped_range(..).map_err(|e| lost(e.to_string()))?;
    let pixels: Vec<u8> = mapped.chunks(padded as usize).flat_map(|line| &line[..row as usize]).copied().collect();
    Ok(image::RgbaImage::from_raw(width, height, pixels).expect("four bytes a pixel"))
}
