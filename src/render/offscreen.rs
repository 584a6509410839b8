//! A picture without a window: the same [`Renderer::draw`], into a texture that is read back. In: a view and a size.
//! Out: an image. The renderer must be created with [`OFFSCREEN`] as its format.

use super::{
    PanelOutput, Renderer,
    device::{
        gpu::{Gpu, GpuError},
        targets::target,
    },
};
use crate::scene::View;

/// Format of pictures that are read back.
pub const OFFSCREEN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Creates a texture of `size` pixels to draw onto.
pub fn canvas(gpu: &Gpu, format: wgpu::TextureFormat, size: [u32; 2]) -> wgpu::TextureView {
    target(&gpu.device, "off-screen", (format, 1), size, wgpu::TextureUsages::COPY_SRC)
}

/// Draws `view` at `size` pixels and reads the picture back.
///
/// # Errors
/// The device is lost while it draws.
pub fn render_to_image(
    gpu: &Gpu,
    renderer: &mut Renderer,
    view: &View,
    size: [u32; 2],
) -> Result<image::RgbaImage, GpuError> {
    render_with_panel(gpu, renderer, view, None, size)
}

/// Draws `view` as [`render_to_image`], with the experimenter's panel over it.
///
/// # Errors
/// As [`render_to_image`].
pub fn render_with_panel(
    gpu: &Gpu,
    renderer: &mut Renderer,
    view: &View,
    panel: Option<PanelOutput>,
    size: [u32; 2],
) -> Result<image::RgbaImage, GpuError> {
    let target = canvas(gpu, OFFSCREEN, size);
    renderer.draw(view, panel, &target, size);
    let pixels = read_back(gpu, target.texture(), 4)?;
    Ok(image::RgbaImage::from_raw(size[0], size[1], pixels).expect("four bytes a pixel"))
}

/// Returns the light of `view` before tone curve and dial: red, green, blue and coverage of each pixel, row by row, at
/// the resolution in which it was drawn. For tests of values that a tone curve would hide.
///
/// # Errors
/// As [`render_to_image`].
pub fn render_to_light(
    gpu: &Gpu,
    renderer: &mut Renderer,
    view: &View,
    size: [u32; 2],
) -> Result<Vec<[f32; 4]>, GpuError> {
    renderer.draw(view, None, &canvas(gpu, OFFSCREEN, size), size);
    let bytes = read_back(gpu, renderer.pictures[0].light().texture(), 8)?;
    let half = |b: &[u8]| half::f16::from_le_bytes([b[0], b[1]]).to_f32();
    Ok(bytes.chunks(8).map(|p| [half(p), half(&p[2..]), half(&p[4..]), half(&p[6..])]).collect())
}

/// Returns all bytes of a texture with `pixel` bytes per pixel, row by row.
pub(crate) fn read_back(gpu: &Gpu, texture: &wgpu::Texture, pixel: u32) -> Result<Vec<u8>, GpuError> {
    let row = texture.width() * pixel;
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: u64::from(padded) * u64::from(texture.height()),
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
    gpu.finish()?;
    let mapped = buffer.get_mapped_range(..).map_err(|e| GpuError::Lost(e.to_string()))?;
    Ok(mapped.chunks(padded as usize).flat_map(|line| &line[..row as usize]).copied().collect())
}
